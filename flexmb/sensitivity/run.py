"""A run that carries small differences of its state along."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.errors import SolveError
from flexmb.program.program import Program
from flexmb.run.run import Run
from flexmb.sensitivity.linearise import TURNED, Tangents, follow_histories, linearise, new_tangents
from flexmb.sensitivity.tangent_step import LOST, address_of_advance, advance_with
from flexmb.start.projection import metric_of, nearest
from flexmb.state.options import Options
from flexmb.step.newmark.method import Newmark, NewmarkStepper
from flexmb.system.at_state import System
from flexmb.system.work import Work, workspace

LINGERS = 0.51
"""Newmark's gamma below which accelerations along the joints keep their errors: their factor is 1 - 1/gamma."""

MOVED = 1e-5
"""How far states are moved for the derivative of what no kernel differentiates, as a part of the size, or an angle."""


class CarryingStepper(NewmarkStepper):
    """Steps of the Newmark family that carry small differences of the state along, where there are any.

    Parameters
    ----------
    program : the compiled mechanism.
    method : a method of the Newmark family.
    """

    tangents: Tangents | None = None
    _address: Any = None

    def __init__(self, program: Program, method: Newmark) -> None:
        super().__init__(program, method)
        self.second = workspace(program)
        self.lingers = method.constraints == "velocity" or method.gamma < LINGERS

    def advance(self, run: Run, options: Options, steps: int) -> int:
        """Take at most `steps` steps: the code of the ending."""
        if self.tangents is None:
            return super().advance(run, options, steps)
        arguments = run.arguments(options)
        if self._address is None:
            self._address = address_of_advance(*arguments, 1)
        return int(advance_with(self._address, *arguments, self.second, self.tangents, steps))

    def explain(self, code: int) -> str | None:
        """What the end of the tangents means."""
        if code != LOST:
            return super().explain(code)
        return "the tangent of a step has no finite solution; or the given differences are not finite"


class CarryingRun(Run):
    """A `Run` of the Newmark family whose differences of states, a matrix (size, k), go the same steps.

    Rows are positions, velocities, histories, accelerations and auxiliary accelerations, as in `MechanismFlow`.
    Differences off the manifold, or of accelerations alone, that do not fade as the steps go on (`lingers`) are taken
    out at the start: they would outlive those that shrink, however small they are at first.
    """

    stepper: CarryingStepper

    def __init__(self, program: Program, method: Newmark, *others: Any) -> None:
        super().__init__(program, method, *others)
        self.stepper = CarryingStepper(program, method)

    def carry_to(self, end: float, W: np.ndarray) -> None:
        """Run until `end` [s] and carry W (size, k) along, in place."""
        self.stepper.tangents = T = taken_apart(self.program, W)
        if self.stepper.lingers:
            kept = T.x - T.a
            project(self.program, self.flow, float(self.flow.clock.step_size), T)
            settle(self.program, self.flow, T, self.stepper.second, histories=False)
            T.x[:] = T.a + kept
        self.go_to(end, saving=None)
        self._look_again()
        put_together(self.program, T, W)
        self.stepper.tangents = None

    def on_manifold(self, W: np.ndarray) -> np.ndarray:
        """Differences (size, k) that joints allow, near those of W; accelerations and histories follow."""
        T, found = taken_apart(self.program, W), np.zeros(W.shape)
        project(self.program, self.flow, float(self.flow.clock.step_size), T)
        settle(self.program, self.flow, T, workspace(self.program), histories=True)
        put_together(self.program, T, found)
        return found

    def _look_again(self) -> None:
        """Bring all neighbours to the present time; what is wrong with them is noted as the end of the run."""
        T = self.stepper.tangents
        if T is None or self.note:
            return
        if not all(np.isfinite(x).all() for x in (T.q, T.v, T.z, T.a, T.x, T.tau)):
            self.note = "Stopped: the carried differences grew beyond all numbers; carry them for shorter times"
            return
        try:
            look_again(self.program, self.flow, T, self.stepper.second)
        except SolveError as error:
            self.note = f"Stopped: {str(error).rstrip('.')}"

    def _jump(self, instant: float, interval: float) -> None:
        T = self.stepper.tangents
        if T is not None:
            self._look_again()
        super()._jump(instant, interval)
        if T is not None and not self.note:
            T.step.last = 0.0
            try:
                settle(self.program, self.flow, T, self.stepper.second, histories=False)
            except SolveError as error:
                self.note = f"Stopped: {str(error).rstrip('.')}"


def taken_apart(program: Program, W: np.ndarray) -> Tangents:
    """The differences W (size, k) in arrays of the compiled loop."""
    n, n_z = program.n_q, program.tables.sizes.n_z
    T = new_tangents(program, W.shape[1])
    T.q[:, :n], T.v[:, :n], T.z[:] = W[:n].T, W[n : 2 * n].T, W[2 * n : 2 * n + n_z].T
    T.a[:, :n], T.x[:, :n] = W[2 * n + n_z : 3 * n + n_z].T, W[3 * n + n_z :].T
    return T


def put_together(program: Program, T: Tangents, W: np.ndarray) -> None:
    """W (size, k) from the arrays of the compiled loop."""
    n = program.n_q
    W[:] = np.concatenate([T.q[:, :n].T, T.v[:, :n].T, T.z.T, T.a[:, :n].T, T.x[:, :n].T])


def project(program: Program, flow: Any, most: float, T: Tangents) -> None:
    """Take out of T.q and T.v what joints forbid: G dq = 0, G dv + (dG/dt) dq = 0; `most` as in `find_turning`."""
    n, t, metric = program.n_q, float(flow.clock.t), metric_of(program)
    system, q, v = System(program), flow.q[:n], flow.v[:n]
    G = system.at(q, t=t).jacobian
    eps = min(most, TURNED / max(np.abs(v / np.where(metric == 1.0, program.length, 1.0)).max(), 1e-300))
    turning = (system.at(q + eps * v, t=t + eps).jacobian - system.at(q - eps * v, t=t - eps).jacobian) / (2.0 * eps)
    for j in range(len(T.q)):
        T.q[j, :n] += nearest(metric, G, -(G @ T.q[j, :n]))
        T.v[j, :n] += nearest(metric, G, -(G @ T.v[j, :n] + turning @ T.q[j, :n]))


def settle(program: Program, flow: Any, T: Tangents, work: Work, *, histories: bool) -> None:
    """Accelerations that follow from T.q, T.v, T.z in the present state, for a first step; also `histories` if asked.

    Raises
    ------
    SolveError : the accelerations are not unique.
    """
    n, t, tables = program.n_q, float(flow.clock.t), program.tables
    T.X[:], T.Y[:] = 0.0, 0.0
    now = (flow.q, flow.v, flow.a, flow.lam, flow.z)
    linearise(tables, program.addresses, t, 0.0, *now, 0.0, 1.0, T, work)
    state = [x[:n] for x in now[:3]]
    system, whole = System(program), {"lam": flow.lam, "z": flow.z}
    K = system.at(*state, **whole, t=t, weights=(1.0, 0.0, 0.0)).block()
    C = system.at(*state, **whole, t=t, weights=(0.0, 1.0, 0.0)).block()
    b = np.zeros((len(T.q), n + program.n_c))
    b[:, :n] = T.F[:, :n] - (K @ T.q[:, :n].T).T - (C @ T.v[:, :n].T).T
    for j in range(len(T.q)):
        b[j, n:] = -_change_of_gaps(program, system, state, t, (T.q[j, :n], T.v[j, :n]))
    system.at(*state[:2], **whole, t=t, weights=(0.0, 0.0, 1.0))
    for j in range(len(T.q)):
        T.u[j] = system.solve(b[j], f"Tangent of the accelerations of {program.name!r} at t = {t:.6g} s")
        T.a[j, :n] = T.u[j, :n]
    T.x[:] = T.a
    if histories:
        follow_histories(tables, program.addresses, t, 0.0, *now, T, work)


def _change_of_gaps(program: Program, system: System, state: Any, t: float, change: Any) -> np.ndarray:
    """Change of G a - gamma (n_c,) by changes of q and v, with a held."""
    (q, v, a), (dq, dv) = state, change
    length = np.where(metric_of(program) == 1.0, program.length, 1.0)
    fast = max(float(np.abs(v / length).max()), 1.0)
    most = max(float(np.abs(dq / length).max()), float(np.abs(dv / length).max()) / fast)
    if program.n_c == 0 or most == 0.0:
        return np.zeros(program.n_c)
    eps, sides = MOVED / most, []
    for move in (eps, -eps):
        G = system.at(q + move * dq, v + move * dv, t=t).jacobian
        sides.append(G @ a - system.gamma)
    return np.asarray((sides[0] - sides[1]) / (2.0 * eps))


def look_again(program: Program, flow: Any, T: Tangents, work: Work) -> None:
    """Look at all neighbours at the time of the present state, not later by T.tau as since the last impact."""
    if not T.tau.any():
        return
    n, later = program.n_q, -T.tau[:, None]
    kept = T.x - T.a
    T.q[:, :n] += later * flow.v[:n]
    T.v[:, :n] += later * flow.a[:n]
    if T.step.last > 0.0:
        T.z[:] += later / T.step.last * (flow.z - T.zp)
    T.tau[:] = 0.0
    settle(program, flow, T, work, histories=True)
    T.x[:] = T.a + kept
