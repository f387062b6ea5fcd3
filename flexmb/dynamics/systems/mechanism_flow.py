"""A mechanism as a flow: its time steps, with tangent vectors, from any state; its scales."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, Self

import numpy as np

from flexmb import checks
from flexmb.dynamics.systems.dynamics import SMALL, ContinuousFlow, Parameters, State, orthonormalise
from flexmb.dynamics.systems.given import tangents_of
from flexmb.engine.compiled import ahead
from flexmb.engine.compiled.digest import Parts, kind_of, parts_of
from flexmb.engine.linalg.rank import surplus_rows
from flexmb.engine.newmark.method import Newmark
from flexmb.engine.sensitivity.tangent_step import CarryingRun
from flexmb.engine.state.record import DONE, RUNNING
from flexmb.engine.step.contact_events import running_episodes
from flexmb.engine.step.step_size import Adaptive, FixedStep
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import AssemblyError, InputError
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import refuse_controllers
from flexmb.parts.contact.onset import HISTORY
from flexmb.parts.contact.validity import HISTORY_WITH_EXTREMES
from flexmb.program.compiler import clash, common_period, compile_with_start
from flexmb.program.program import Program
from flexmb.results.contact_intervals import COLUMN
from flexmb.results.status import followed
from flexmb.run.simulate import Step, period_or_none
from flexmb.statics.start.consistent import Start, accelerations, consistent_start, metric_of, projected

PLACES = (".ex", ".ey")  # endings of the signals that give the position of a journal in its bearing
RATES = {"x": "vx", "y": "vy", "theta": "omega"}  # endings of the names of velocities by those of coordinates
PENETRATION = "penetration"
ONSET = 1  # index of the instant of the onset among the histories that every contact has
INSTANT = 1e-3  # time span of the differences in time from which rates are taken, as a multiple of the largest step
# Size of the differences of states from which slopes of signals are taken, as a multiple of the state's length.
NUDGE = 1e-6
# Distance of two trajectories over the length of the state: contacts are nonlinear beyond some 1e-8 m.
SMALL_IN_CONTACT = 1e-9
# Shortest reliable duration of a run with error-controlled steps, as a multiple of the smallest allowed step.
SHORTEST = 100.0


class MechanismFlow(ContinuousFlow):
    """The motion of a mechanism in time, as `simulate` computes it.

    A state is (q, v, z, a, x): positions [m, rad], velocities [m/s, rad/s], histories of contacts and elements,
    accelerations, and the auxiliary accelerations of the generalised-alpha family.  `reset` projects a given state onto
    the constraints, and computes a and x from q, v and z.

    Parameters
    ----------
    mechanism : the mechanism.
    step : `Adaptive(...)`, the default, or `FixedStep(size)`, or the bare size [s] of fixed steps.
    method : a method of `Newmark`; None: generalised-alpha with spectral radius 0.8.
    period : expected period of the motion [s]; None: the common period of the drives.  It bounds the size of
        error-controlled steps.

    Raises
    ------
    InputError : another kind of method; error-controlled steps without a period or a largest step.
    ModelError, AssemblyError, KernelError : a mechanism that cannot start.
    """

    def __init__(
        self, mechanism: Mechanism, *, step: Step | None = None, method: Newmark | None = None,
        period: float | None = None,
    ) -> None:  # fmt: skip
        if not isinstance(mechanism, Mechanism):
            raise InputError(f"MechanismFlow: {mechanism!r} is not a Mechanism.")
        self.base, self.name, self.changes = mechanism, mechanism.name, dict[str, Any]()
        label = self._label
        refuse_controllers(mechanism, label, "the tangents of a motion do not carry controllers along")
        if method is not None and not (isinstance(method, Newmark) and method.has_tangent):
            raise InputError(f"{label}: method is {method!r}; only the steps of Newmark(...) itself have a tangent.")
        step = Adaptive() if step is None else step
        self.step = step if isinstance(step, (Adaptive, FixedStep)) else FixedStep(step)
        self.method = Newmark.generalised_alpha() if method is None else method
        self.declared = None if period is None else checks.positive(label, "period", period, "s")
        ahead.start(*self.method.loops)
        self.reset()

    @property
    def time(self) -> float:
        return float(self.run.flow.clock.t)

    @property
    def size(self) -> int:
        return 4 * self.program.n_q + self.program.tables.sizes.n_z

    @property
    def dimension(self) -> int:
        G = StateEvaluation(self.program).at(self.run.flow.q[: self.program.n_q], t=self.time).blocks[1]
        return 2 * (self.program.n_q - self.program.n_c + len(surplus_rows(G)))

    @property
    def weights(self) -> np.ndarray:
        """Weights (size,) of the squares of a state (q, v, z, a, x) in its length.

        Angles are multiplied by the length of the mechanism, velocities by period / (2 pi).  Histories and
        accelerations have the weight 0.  Without a period it is 1 s.
        """
        metric, n_z = metric_of(self.program), self.program.tables.sizes.n_z
        n, time = self.program.n_q, (self.period or 1.0) / (2.0 * np.pi)
        return np.concatenate([metric, time**2 * metric, np.zeros(n_z + 2 * n)])

    @property
    def records(self) -> np.ndarray:
        """Rows (m,) of the instants and speeds of onsets, and of the extremes noted by contact laws."""
        program, rows = self.program, list[int]()
        for (common, _, end, _), law in zip(program.tables.contacts.z, program.normals, strict=True):
            extremes = len(HISTORY_WITH_EXTREMES) - len(HISTORY) if law.history() is HISTORY_WITH_EXTREMES else 0
            rows += [int(common) + ONSET, *range(int(end) - extremes, int(end))]
        return 2 * program.n_q + np.array(rows, dtype=np.int64)

    @property
    def state_names(self) -> Mapping[str, int]:
        coordinates, n = self.program.names.coordinates, self.program.n_q
        names = {name: k for k, name in enumerate(coordinates)}
        for k, name in enumerate(coordinates):
            body, _, last = name.rpartition(".")
            names[f"{body}.{RATES.get(last, last)}"] = n + k
        return names

    @property
    def angles(self) -> np.ndarray:
        return np.flatnonzero(np.asarray(self.program.tables.kind) == 1)

    @property
    def histories(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows of histories of friction and of elements, which must return, and of normal contacts, which follow."""
        tables = self.program.tables
        pairs = [*np.asarray(tables.elements.z), *np.asarray(tables.constraints.joint_friction_z)]
        pairs += [row[2:4] for row in np.asarray(tables.contacts.z)]
        returning = sorted({i for begin, end in pairs for i in range(int(begin), int(end))})
        free, n = sorted(set(range(tables.sizes.n_z)) - set(returning)), 2 * self.program.n_q
        return n + np.array(returning, dtype=np.int64), n + np.array(free, dtype=np.int64)

    @property
    def gaps(self) -> Mapping[str, float]:
        wanted = [f"{contact}.{PENETRATION}" for contact in self.program.names.contacts]
        return {name: -1.0 for name in wanted if name in self.names}

    @property
    def is_rough(self) -> bool:
        return isinstance(self.step, Adaptive)

    @property
    def small(self) -> float:
        return SMALL_IN_CONTACT if self.program.normals else SMALL

    @property
    def telling(self) -> tuple[int, ...]:
        """Numbers of the positions, the velocities, and the positions of journals.

        Forces and accelerations are functions of positions, velocities and histories, and their spikes spoil every
        mean.  Sums of energies never return to their start.
        """
        return tuple(k for k, name in enumerate(self.names) if k < 2 * self.program.n_q or name.endswith(PLACES))

    @property
    def main_signals(self) -> tuple[str, ...]:
        """Position of the first journal with clearance, else of the slider in its guide, or the last body's angle."""
        journal = next((name for name in self.names if name.endswith(PLACES[0])), None)
        if journal is not None:
            return journal, journal.removesuffix(PLACES[0]) + PLACES[1]
        body, guide = followed(self.mechanism)
        if body is None:
            return self.names[:1]
        axis = "theta" if guide is None else "x" if abs(guide.along[0]) >= abs(guide.along[1]) else "y"
        return (self.names[self.number_of(self._label, f"{body.name}.{axis}")],)

    @property
    def resolution(self) -> np.ndarray:
        """Differences (m,) of the signals that errors of the integration can make [units of the signals].

        With error-controlled steps: a tenth of the error allowed in a step, because the steps fall differently in each
        period of a periodic motion.  With fixed steps: 1e-8 of the length of the mechanism and of its largest speed.
        For signals other than positions, velocities and positions of journals: 1e-6 of their largest values.
        """
        program, peak = self.program, self.run.record.peak
        n, length = program.n_q, program.length
        scale = np.where(np.asarray(program.tables.kind) == 1, 1.0 / length, 1.0)
        speed = max(float((peak[n : 2 * n] / scale).max(initial=0.0)), length / (self.period or 1.0))
        position, velocity = 1e-8 * length, 1e-8 * speed
        if isinstance(self.step, Adaptive):
            position, velocity = 0.1 * float(self.run.error), 0.1 * self.step.rtol * speed
        resolution = np.maximum(1e-6 * peak, 1e-300)
        resolution[:n], resolution[n : 2 * n] = position * scale, velocity * scale
        resolution[[k for k, name in enumerate(self.names) if name.endswith(PLACES)]] = position
        return resolution

    @property
    def parameters(self) -> Mapping[str, Any]:
        return dict(self.changes)

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism with the present parameters."""
        return self.base.with_(self.changes) if self.changes else self.base

    def state(self) -> np.ndarray:
        flow, n = self.run.flow, self.program.n_q
        return np.concatenate([flow.q[:n], flow.v[:n], flow.z, flow.a[:n], flow.x[:n]])

    def observe(self) -> np.ndarray:
        return self.run.record.signals.copy()

    def reset(self, state: State = None, *, time: float = 0.0, parameters: Parameters = None) -> None:
        time = checks.number(self._label, "time", time, "s")
        self._compile({**self.changes, **(parameters or {})})
        if state is None:
            self._begin(consistent_start(self.mechanism, self.program, time, closed=self._closed), None, time)
            return
        state = np.asarray(state, dtype=np.float64)
        if state.shape != (self.size,) or not np.isfinite(state).all():
            text = f"{self._label}: the given state has shape {state.shape}"
            raise InputError(f"{text}; it must be {self.size} finite numbers (see `state`).")
        n, n_z = self.program.n_q, self.program.tables.sizes.n_z
        q, v = projected(self.program, state[:n], state[n : 2 * n], time)
        moved, play = np.abs(q - state[:n]).reshape(-1, 3)[:, :2].max(), self.program.least_clearance
        if play is not None and moved > play:
            text = f"{self._label}: joints and drives at t = {time:.6g} s move the given state by {moved:.3g} m"
            raise AssemblyError(f"{text}, more than the clearance of {play:.3g} m. Give a state nearer to them.")
        z = state[2 * n : 2 * n + n_z].copy()
        a, lam = accelerations(self.program, q, v, time, z)
        self._begin(Start(q, v, a, lam, 0), z, time)

    def advance(self, duration: float, tangents: np.ndarray | None = None) -> bool:
        """See `Dynamics.advance`; `tangents` are advanced by the linearised steps of this motion (`sensitivity`).

        The derivative is taken at constant step sizes.  Error-controlled steps end at the onset of a contact, so each
        neighbouring motion is compared at its own onset, and a force that sets in suddenly gives its velocity a jump.
        Fixed steps do not end at onsets: contacts with sudden forces, such as dampers, need `Adaptive` steps.
        """
        duration = checks.positive(self._label, "duration", duration, "s")
        if not self.ok:
            return False
        if tangents is None:
            self.run.run_to(self.time + duration, saving=None)
        else:
            self.run.carry_to(self.time + duration, self._checked(tangents))
        self.ok, self.status = self.run.code in (RUNNING, DONE) and not self.run.note, self.run.status()
        return self.ok

    def on_manifold(self, tangents: np.ndarray) -> np.ndarray:
        """Projection of `tangents` (size, k) onto the differences that satisfy joints and drives at the present state.

        Differences of positions and velocities are projected in the metric of `weights`.  Differences of accelerations
        follow from them and from the differences of histories.
        """
        return self.run.on_manifold(self._checked(np.array(tangents, dtype=np.float64, order="C")))

    def tangent_basis(self, count: int, seed: int = 0) -> np.ndarray:
        """Tangent vectors (size, count), orthonormal in the weights, from random directions without histories.

        Histories have no weight, and a bristle of 1e-6 m must not start with a difference of 1.
        """
        W, n = super().tangent_basis(count, seed), self.program.n_q
        W[2 * n : 2 * n + self.program.tables.sizes.n_z] = 0.0
        W = self.on_manifold(W)
        orthonormalise(W, self.weights)
        return W

    def _checked(self, tangents: np.ndarray) -> np.ndarray:
        return tangents_of(self._label, tangents, self.size, "Make them orthonormal after shorter times")

    def take_step(self, limit: float, tangents: np.ndarray | None = None) -> bool:
        if not self.ok:
            return False
        here, began = self.snapshot(), self.time
        self.ok, self.status = self.run.one_step(limit), self.run.status()
        if self.ok and tangents is not None:
            size = self.time - began
            self.restore(here)
            return self.advance(size, tangents)
        return self.ok

    def velocity(self) -> np.ndarray:
        """Rate (size,) of the state (q, v, z, a, x) by differences in time.

        The rates of histories are those that a very short step gives, the rates of accelerations those of the
        accelerations that solve the equations of motion.  Auxiliary accelerations have the rates of accelerations.
        """
        n, tau = self.program.n_q, INSTANT * self.run.h_max
        x = self.state()
        q, v, z, a = x[:n], x[n : 2 * n], x[2 * n : -2 * n], x[-2 * n : -n]
        dz = np.zeros_like(z)
        if len(z):
            here, began = self.snapshot(), self.time
            self.advance(tau)
            dz = (self.state()[2 * n : -2 * n] - z) / (self.time - began)
            self.restore(here)
        later = ((s, q + s * v + 0.5 * s * s * a, v + s * a, z + s * dz) for s in (tau, -tau))
        ahead, behind = (accelerations(self.program, x1, v1, self.time + s, z1)[0] for s, x1, v1, z1 in later)
        jerk = (ahead - behind) / (2.0 * tau)
        return np.concatenate([v, a, dz, jerk, jerk])

    def rate(self, signal: int) -> float:
        n = self.program.n_q
        if signal < 2 * n:
            return float(self.state()[n + signal] if signal < n else self.run.flow.a[signal - n])
        if signal < 3 * n:
            return float(self.velocity()[self._row(signal)])
        tau, x, rates = INSTANT * self.run.h_max, self.state(), self.velocity()
        ahead, behind = (self._signal_at(signal, x + s * rates, self.time + s) for s in (tau, -tau))
        return (ahead - behind) / (2.0 * tau)

    def slopes(self, signal: int, tangents: np.ndarray) -> np.ndarray:
        if signal < 3 * self.program.n_q:
            return np.array(tangents[self._row(signal)])
        x, weights, slopes = self.state(), self.weights, []
        scale = NUDGE * np.sqrt(float(weights @ x**2) or 1.0)
        for w in tangents.T:
            step = scale / (np.sqrt(float(weights @ w**2)) or float(np.abs(w).max()) or 1.0)
            up, down = (self._signal_at(signal, x + s * w, self.time) for s in (step, -step))
            slopes.append((up - down) / (2.0 * step))
        return np.array(slopes)

    def _row(self, signal: int) -> int:
        """Row of a state that holds a signal which is a position, velocity or acceleration."""
        return signal if signal < 2 * self.program.n_q else signal + self.program.tables.sizes.n_z

    def _signal_at(self, signal: int, state: np.ndarray, time: float) -> float:
        """A signal in another state, whose accelerations and forces follow from positions, velocities and histories."""
        n, run, flow, here = self.program.n_q, self.run, self.run.flow, self.snapshot()
        q, v, z = state[:n], state[n : 2 * n], state[2 * n : -2 * n]
        a, lam = accelerations(self.program, q, v, time, z)
        flow.q[:n], flow.v[:n], flow.a[:n], flow.lam[:], flow.z[:], flow.clock.t = q, v, a, lam, z, time
        run.evaluate()
        value = float(run.record.signals[signal])
        self.restore(here)
        return value

    def has_cheap_rate(self, signal: int) -> bool:
        return signal < 2 * self.program.n_q

    @property
    def pace(self) -> float:
        return float(self.run.h_max)

    @property
    def shortest(self) -> float:
        return SHORTEST * float(self.run.h_min) if isinstance(self.step, Adaptive) else 0.0

    def number_of(self, owner: str, signal: str) -> int:
        node, dot, last = str(signal).rpartition(".")
        return super().number_of(owner, f"{self.program.names.aliases.get(node, node)}{dot}{last}")

    def no_period(self) -> str:
        """Reason why the flow has no period, as a sentence without its end."""
        periods = clash(self.program)
        if periods is None:
            return "it has no periodic drive"
        return f"the periods of its drives, {periods[0]:g} s and {periods[1]:g} s, have no small common multiple"

    def required_period(self, owner: str) -> float:  # noqa: ARG002 - the error names the drives
        return common_period(self.program) if self.period is None else self.period

    def prepare(self) -> bool:
        return self.advance(1e-6 * (self.period or 1.0))

    def makings(self) -> list[Any]:
        return [v for _, v in sorted(vars(self).items()) if isinstance(v, (Program, FixedStep, Adaptive, Newmark))]

    def remarks(self, since: float) -> list[str]:
        """A sentence on each contact that stayed closed since the start `since` of the measured growth [s].

        Laws with hysteresis damping depend on the approach speed of the last onset.  The run lacks the tangent of this
        approach speed if the onset precedes the measured growth.  Contacts with other laws are not listed.
        """
        sentences, tables, names = [], self.program.tables, self.program.names.contacts
        for row in running_episodes(tables, self.run.flow):
            contact = int(row[COLUMN["contact"]])
            _, begin, end, _ = tables.contacts.z[contact]
            damped = self.program.normals[contact].damped_since_onset(self.run.flow.z[begin:end].tolist())
            if damped and row[COLUMN["peak_force"]] > 0.0 and not row[COLUMN["start"]] > since:
                text = f"{names[contact]} has been in contact without a break during all that was counted"
                sentences.append(f"{text}: {damped}.")
        return sentences

    def snapshot(self) -> Any:
        run = self.run  # arrays of `Flow`, signals, code and note of the last step
        return run.flow.saved(), run.record.signals.copy(), self.changes, run.code, run.note, self.ok, self.status

    def restore(self, snapshot: Any) -> None:
        arrays, signals, changes, *ending = snapshot
        if changes != self.changes:
            text = f"{self._label}: the snapshot belongs to the parameters {changes}, the flow has {self.changes}. With"
            raise InputError(f"{text} other parameters a motion begins from state(): reset(state, parameters=...).")
        self.run.code, self.run.note, self.ok, self.status = ending
        self.run.flow.restore(arrays)
        self.run.keep_fixed_step()
        self.run.record.signals[:] = signals

    def copy(self) -> Self:
        return self._with(self.step)

    @property
    def fineness(self) -> str:
        step = self.step
        return f"rtol {step.rtol:g}" if isinstance(step, Adaptive) else f"steps of {step.size:g} s"

    def finer(self) -> Self:
        other = self._with(self.step.finer())
        other.reset(self.state(), time=self.time)  # the step control starts anew
        return other

    def another_start(self, distance: float, seed: int) -> np.ndarray:
        """Changed velocities in the same pose, so that no journal is pushed into its bearing; see `Dynamics`."""
        n, direction = self.program.n_q, self.tangent_basis(1, seed)[:, 0]
        x, weights = self.state(), self.weights
        size = float(np.sqrt(weights[n : 2 * n] @ x[n : 2 * n] ** 2))
        length = float(np.sqrt(weights[n : 2 * n] @ direction[n : 2 * n] ** 2))
        x[n : 2 * n] += distance * (size or self.program.length) / (length or 1.0) * direction[n : 2 * n]
        return x

    def _with(self, step: Adaptive | FixedStep) -> Self:
        """A copy with other steps."""
        other = type(self)(self.base, step=step, method=self.method, period=self.declared)
        other._compile(self.changes)
        other.restore(self.snapshot())
        other.run.record.peak[:] = self.run.record.peak
        return other

    def _compile(self, changes: Mapping[str, Any]) -> None:
        """Compile the mechanism with these changes, and make a new run."""
        if changes != self.changes or "program" not in vars(self):
            self.program, self._closed = compile_with_start(self.base.with_(changes) if changes else self.base)
            self.period = self.declared or period_or_none(self.program)
            self.driven = len(self.program.motions) > 0
            self.names = tuple(s.name for s in self.program.names.signals)
            self.units = tuple(s.units for s in self.program.names.signals)
        self.changes = dict(changes)
        if self.period is None and isinstance(self.step, Adaptive) and self.step.max is None:
            text = f"{self._label}: no drive has a period, so the largest step is unknown."
            raise InputError(f"{text} Give period= (about that of the motion), step=Adaptive(max=...) or a fixed step.")
        span = self.period or 1.0
        self.run = CarryingRun(self.program, self.method, self.step, span, span)
        self.ok, self.status = False, "The last reset failed."

    def _begin(self, start: Start, z: np.ndarray | None, time: float) -> None:
        self.run.begin(start, z=z, time=time)
        self.run.flow.clock.save_start, self.ok, self.status = -1.0, True, "ready"


DERIVED = ("symbolic", "shapes")  # fields of a program without influence on the digest; the other fields determine them


@parts_of.register
def _program(value: Program) -> Parts:
    names = [f.name for f in fields(value) if f.name not in DERIVED]
    return kind_of(value), [part for name in names for part in (name, getattr(value, name))]
