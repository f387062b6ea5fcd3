"""Run of the Newmark family with small differences of its state."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.errors import SolveError
from flexmb.program.program import Program
from flexmb.run.run import Run
from flexmb.sensitivity.linearise import POSE_DIFFERENCE, Tangents, advance_histories, linearise, new_tangents
from flexmb.sensitivity.tangent_step import TANGENT_LOST, address_of_advance, advance_with_tangents
from flexmb.start.projection import metric_of, shortest_correction
from flexmb.state.options import Options
from flexmb.step.newmark.method import Newmark, NewmarkStepper
from flexmb.system.state_evaluation import StateEvaluation
from flexmb.system.work import Work, workspace

LEAST_FADING_GAMMA = 0.51
"""Newmark's gamma up to which errors of accelerations along the constraints do not fade: factor 1 - 1/gamma a step."""

STATE_DIFFERENCE = 1e-5
"""Difference of states for derivatives that no kernel gives [rad, or relative to the size of the mechanism]."""


class CarryingStepper(NewmarkStepper):
    """Steps of the Newmark family, with small differences of the state if `tangents` is set."""

    tangents: Tangents | None = None
    _address: Any = None

    def __init__(self, program: Program, method: Newmark) -> None:
        super().__init__(program, method)
        self.second = workspace(program)
        self.keeps_errors = method.constraints == "velocity" or method.gamma < LEAST_FADING_GAMMA

    def advance(self, run: Run, options: Options, steps: int) -> int:
        """Take at most `steps` steps; RUNNING, or the code of the ending."""
        if self.tangents is None:
            return super().advance(run, options, steps)
        arguments = run.arguments(options)
        if self._address is None:
            self._address = address_of_advance(*arguments, 1)
        return int(advance_with_tangents(self._address, *arguments, self.second, self.tangents, steps))

    def explain(self, code: int) -> str | None:
        """Sentence on a lost tangent."""
        if code != TANGENT_LOST:
            return super().explain(code)
        return "the tangent of a step has no finite solution; or the given differences are not finite"


class CarryingRun(Run):
    """Run of the Newmark family with differences of its state, a matrix (size, k).

    Rows are positions, velocities, histories, accelerations and auxiliary accelerations, as in `MechanismFlow`.
    Differences that violate the constraints, or of accelerations alone, fade in most methods.  Where they do not
    (`keeps_errors`), they are removed at the start, since they would outlive differences that shrink.
    """

    stepper: CarryingStepper

    def __init__(self, program: Program, method: Newmark, *others: Any) -> None:
        super().__init__(program, method, *others)
        self.stepper = CarryingStepper(program, method)

    def carry_to(self, end: float, W: np.ndarray) -> None:
        """Run until `end` [s], and carry the differences W (size, k) along, in place."""
        self.stepper.tangents = T = unpack_differences(self.program, W)
        if self.stepper.keeps_errors:
            kept = T.x - T.a
            project_differences(self.program, self.flow, float(self.flow.clock.step_size), T)
            complete_differences(self.program, self.flow, T, self.stepper.second, histories=False)
            T.x[:] = T.a + kept
        self.run_to(end, saving=None)
        self._synchronise()
        pack_differences(self.program, T, W)
        self.stepper.tangents = None

    def on_manifold(self, W: np.ndarray) -> np.ndarray:
        """Differences (size, k) near W that satisfy the constraints, with accelerations and histories that follow."""
        T, found = unpack_differences(self.program, W), np.zeros(W.shape)
        project_differences(self.program, self.flow, float(self.flow.clock.step_size), T)
        complete_differences(self.program, self.flow, T, workspace(self.program), histories=True)
        pack_differences(self.program, T, found)
        return found

    def _synchronise(self) -> None:
        """Remove the time shifts of all neighbours; a failure ends the run with a note."""
        T = self.stepper.tangents
        if T is None or self.note:
            return
        if not all(np.isfinite(x).all() for x in (T.q, T.v, T.z, T.a, T.x, T.tau)):
            self.note = "Stopped: the carried differences grew beyond all numbers; carry them for shorter times"
            return
        try:
            synchronise(self.program, self.flow, T, self.stepper.second)
        except SolveError as error:
            self.note = f"Stopped: {str(error).rstrip('.')}"

    def _cross_jump(self, instant: float, interval: float, *, first: bool = False) -> None:
        T = self.stepper.tangents
        if T is not None:
            self._synchronise()
        super()._cross_jump(instant, interval, first=first)
        if T is not None and not self.note:
            T.step.last = 0.0
            try:
                complete_differences(self.program, self.flow, T, self.stepper.second, histories=False)
            except SolveError as error:
                self.note = f"Stopped: {str(error).rstrip('.')}"


def unpack_differences(program: Program, W: np.ndarray) -> Tangents:
    """The differences W (size, k) as arrays of the compiled loop."""
    n, n_z = program.n_q, program.tables.sizes.n_z
    T = new_tangents(program, W.shape[1])
    T.q[:, :n], T.v[:, :n], T.z[:] = W[:n].T, W[n : 2 * n].T, W[2 * n : 2 * n + n_z].T
    T.a[:, :n], T.x[:, :n] = W[2 * n + n_z : 3 * n + n_z].T, W[3 * n + n_z :].T
    return T


def pack_differences(program: Program, T: Tangents, W: np.ndarray) -> None:
    """Set W (size, k) from the arrays of the compiled loop."""
    n = program.n_q
    W[:] = np.concatenate([T.q[:, :n].T, T.v[:, :n].T, T.z.T, T.a[:, :n].T, T.x[:, :n].T])


def project_differences(program: Program, flow: Any, most: float, T: Tangents) -> None:
    """Project T.q and T.v onto G dq = 0, G dv + (dG/dt) dq = 0; `most` as in `find_jacobian_rate`."""
    n, t, metric = program.n_q, float(flow.clock.t), metric_of(program)
    system, q, v = StateEvaluation(program), flow.q[:n], flow.v[:n]
    G = system.at(q, t=t).jacobian
    eps = min(most, POSE_DIFFERENCE / max(np.abs(v / np.where(metric == 1.0, program.length, 1.0)).max(), 1e-300))
    turning = (system.at(q + eps * v, t=t + eps).jacobian - system.at(q - eps * v, t=t - eps).jacobian) / (2.0 * eps)
    for j in range(len(T.q)):
        T.q[j, :n] += shortest_correction(metric, G, -(G @ T.q[j, :n]))
        T.v[j, :n] += shortest_correction(metric, G, -(G @ T.v[j, :n] + turning @ T.q[j, :n]))


def complete_differences(program: Program, flow: Any, T: Tangents, work: Work, *, histories: bool) -> None:
    """Set the accelerations, and `histories`, that follow from T.q, T.v, T.z in the present state, for a first step."""
    n, t, tables = program.n_q, float(flow.clock.t), program.tables
    T.X[:], T.Y[:] = 0.0, 0.0
    now = (flow.q, flow.v, flow.a, flow.lam, flow.z)
    linearise(tables, program.addresses, t, 0.0, *now, 0.0, 1.0, T, work)
    state = [x[:n] for x in now[:3]]
    system, whole = StateEvaluation(program), {"lam": flow.lam, "z": flow.z}
    K = system.at(*state, **whole, t=t, weights=(1.0, 0.0, 0.0)).block()
    C = system.at(*state, **whole, t=t, weights=(0.0, 1.0, 0.0)).block()
    b = np.zeros((len(T.q), n + program.n_c))
    b[:, :n] = T.F[:, :n] - (K @ T.q[:, :n].T).T - (C @ T.v[:, :n].T).T
    for j in range(len(T.q)):
        b[j, n:] = -_acceleration_gap_difference(program, system, state, t, (T.q[j, :n], T.v[j, :n]))
    system.at(*state[:2], **whole, t=t, weights=(0.0, 0.0, 1.0))
    for j in range(len(T.q)):
        T.u[j] = system.solve(b[j], f"Tangent of the accelerations of {program.name!r} at t = {t:.6g} s")
        T.a[j, :n] = T.u[j, :n]
    T.x[:] = T.a
    if histories:
        advance_histories(tables, program.addresses, t, 0.0, *now, T, work)


def _acceleration_gap_difference(
    program: Program, system: StateEvaluation, state: Any, t: float, change: Any
) -> np.ndarray:
    """Difference of G a - gamma (n_c,) by differences of q and v, at constant a."""
    (q, v, a), (dq, dv) = state, change
    length = np.where(metric_of(program) == 1.0, program.length, 1.0)
    fast = max(float(np.abs(v / length).max()), 1.0)
    most = max(float(np.abs(dq / length).max()), float(np.abs(dv / length).max()) / fast)
    if program.n_c == 0 or most == 0.0:
        return np.zeros(program.n_c)
    eps, sides = STATE_DIFFERENCE / most, []
    for move in (eps, -eps):
        G = system.at(q + move * dq, v + move * dv, t=t).jacobian
        sides.append(G @ a - system.gamma)
    return np.asarray((sides[0] - sides[1]) / (2.0 * eps))


def synchronise(program: Program, flow: Any, T: Tangents, work: Work) -> None:
    """Remove the time shifts T.tau, which neighbours have since the last impact."""
    if not T.tau.any():
        return
    n, later = program.n_q, -T.tau[:, None]
    kept = T.x - T.a
    T.q[:, :n] += later * flow.v[:n]
    T.v[:, :n] += later * flow.a[:n]
    if T.step.last > 0.0:
        T.z[:] += later / T.step.last * (flow.z - T.zp)
    T.tau[:] = 0.0
    complete_differences(program, flow, T, work, histories=True)
    T.x[:] = T.a + kept
