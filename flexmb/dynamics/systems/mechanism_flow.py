"""A mechanism as a flow: the real time stepper, driven from state to state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple, Self

import numpy as np

from flexmb import checks
from flexmb.compiled import ahead
from flexmb.contact.onset import HISTORY
from flexmb.contact.validity import HISTORY_WITH_EXTREMES
from flexmb.dynamics.systems import mechanism_rates
from flexmb.dynamics.systems.continuous_flow import ContinuousFlow
from flexmb.dynamics.systems.dynamics import orthonormalise
from flexmb.errors import InputError
from flexmb.linalg.rank import row_rank
from flexmb.model.mechanism import Mechanism
from flexmb.program.compiler import compile_with_start
from flexmb.program.period import clash
from flexmb.run.simulate import Step, period_or_none
from flexmb.sensitivity.run import CarryingRun
from flexmb.start.consistent import Start, accelerations, consistent_start
from flexmb.start.projection import metric_of, projected
from flexmb.state.record import DONE, RUNNING
from flexmb.step.method import Method
from flexmb.step.newmark.method import Newmark
from flexmb.step.step_size import Adaptive, FixedStep
from flexmb.system.state_evaluation import StateEvaluation

PLACES = (".ex", ".ey")
"""How signals end that say where a journal is in its bearing."""
ONSET = 1
"""Place of the instant of its onset in what is noted of a contact."""
SHORTEST = 100.0
"""Steps of mechanisms that are wanted are at least so many times the smallest one allowed."""


class Snapshot(NamedTuple):
    """A state with all that the step control has learnt: time, arrays of `Flow`, signals, code, note, ok, status."""

    time: float
    arrays: dict[str, np.ndarray]
    signals: np.ndarray
    code: int
    note: str
    ok: bool
    status: str


class MechanismFlow(ContinuousFlow):
    """The motion of a mechanism in time, as `simulate` computes it.

    A state is (q, v, z, a, x): positions [m, rad], velocities [m/s, rad/s], histories of contacts and elements,
    accelerations, and the auxiliary accelerations of the generalised-alpha family; the last two follow from the others
    when a state is given to `reset`, which also brings it to the nearest one that joints and drives allow.

    Parameters
    ----------
    mechanism : the mechanism.
    step : `Adaptive(...)`, the default, or `FixedStep(size)`, for which the bare size [s] will do.
    method : `Newmark...`; None: generalised-alpha with spectral radius 0.8.
    period : time in which the motion is expected to repeat [s]; None: the common period of the drives.
        Error-controlled steps are at most a part of it.

    Raises
    ------
    InputError : another kind of method; error-controlled steps without a period or a largest step.
    ModelError, AssemblyError, KernelError : a mechanism that cannot start.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        *,
        step: Step | None = None,
        method: Newmark | None = None,
        period: float | None = None,
    ) -> None:
        self.name = mechanism.name
        label = f"MechanismFlow of {self.name!r}"
        if method is not None and not (isinstance(method, Method) and method.has_tangent):
            raise InputError(f"{label}: method is {method!r}; it must be Newmark(...), whose steps have a tangent.")
        step = Adaptive() if step is None else step
        self.step = step if isinstance(step, (Adaptive, FixedStep)) else FixedStep(step)
        self.method = method or Newmark.generalised_alpha()
        self.declared = None if period is None else checks.positive(label, "period", period, "s")
        self.base, self.changes = mechanism, dict[str, Any]()
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
        return 2 * (self.program.n_q - row_rank(G).rank)

    @property
    def weights(self) -> np.ndarray:
        """Angles count by the size of the mechanism, speeds by the period; histories do not."""
        metric, n_z = metric_of(self.program), self.program.tables.sizes.n_z
        n, time = self.program.n_q, (self.period or 1.0) / (2.0 * np.pi)
        return np.concatenate([metric, time**2 * metric, np.zeros(n_z + 2 * n)])

    @property
    def records(self) -> np.ndarray:
        """Instants and speeds of onsets, and the largest depths, forces and speeds that contact laws have seen."""
        tables, found = self.program.tables.contacts.z, list[int]()
        for (common, _, end, _), law in zip(tables, self.program.normals, strict=True):
            kept = len(HISTORY_WITH_EXTREMES) - len(HISTORY) if law.history() is HISTORY_WITH_EXTREMES else 0
            found += [int(common) + ONSET, *range(int(end) - kept, int(end))]
        return 2 * self.program.n_q + np.array(found, dtype=np.int64)

    @property
    def telling(self) -> tuple[int, ...]:
        """Positions and velocities, which are all of a motion, and the places of journals.

        Forces and accelerations are functions of these, with spikes from which no mean can be taken; accounts of
        energies never return.
        """
        n = 2 * self.program.n_q
        return tuple(k for k, name in enumerate(self.names) if k < n or name.endswith(PLACES))

    @property
    def resolution(self) -> np.ndarray:
        """A tenth of what a step may miss; error-controlled steps fall differently in each period of a periodic motion.

        Of fixed steps 1e-8 of the size of the mechanism and of its largest speed.  Of signals other than positions,
        velocities and places of journals 1e-6 of their largest values.
        """
        n, length, peak = self.program.n_q, self.program.length, self.run.record.peak
        angle = np.asarray(self.program.tables.kind) == 1
        scale = np.where(angle, 1.0 / length, 1.0)
        speed = max(float((peak[n : 2 * n] / scale).max(initial=0.0)), length / (self.period or 1.0))
        way, rate = 1e-8 * length, 1e-8 * speed
        if isinstance(self.step, Adaptive):
            way, rate = 0.1 * float(self.run.error), 0.1 * self.step.rtol * speed
        found = np.maximum(1e-6 * peak, 1e-300)
        found[:n], found[n : 2 * n] = way * scale, rate * scale
        found[[k for k, name in enumerate(self.names) if name.endswith(PLACES)]] = way
        return found

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

    def reset(
        self, state: np.ndarray | None = None, *, time: float = 0.0, parameters: Mapping[str, Any] | None = None
    ) -> None:
        time = checks.number(f"MechanismFlow of {self.name!r}", "time", time, "s")
        self._compile({**self.changes, **(parameters or {})})
        if state is None:
            self._begin(consistent_start(self.mechanism, self.program, time, closed=self._closed), None, time)
            return
        state = np.asarray(state, dtype=np.float64)
        if state.shape != (self.size,) or not np.isfinite(state).all():
            text = f"MechanismFlow of {self.name!r}: the given state has shape {state.shape}"
            raise InputError(f"{text}; it must be {self.size} finite numbers (see `state`).")
        n, n_z = self.program.n_q, self.program.tables.sizes.n_z
        q, v = projected(self.program, state[:n], state[n : 2 * n], time)
        z = state[2 * n : 2 * n + n_z].copy()
        a, lam = accelerations(self.program, q, v, time, z)
        self._begin(Start(q, v, a, lam, 0), z, time)

    def advance(self, duration: float, tangents: np.ndarray | None = None) -> bool:
        """See `Dynamics.advance`; `tangents` go through the very steps of the motion (`sensitivity/tangent_step.py`).

        The sizes of steps are taken as given.  Error-controlled steps end where a contact begins, so there each
        neighbour is compared at its own onset: a force that is there at once jumps its velocity as it should.  Fixed
        steps do not know of onsets: a contact whose force jumps, as that of a damper does, needs `Adaptive` steps.
        """
        label = f"MechanismFlow of {self.name!r}"
        duration = checks.positive(label, "duration", duration, "s")
        if not self.ok:
            return False
        if tangents is None:
            self.run.run_to(self.time + duration, saving=None)
        else:
            self.run.carry_to(self.time + duration, self._checked(tangents))
        self.ok, self.status = self.run.code in (RUNNING, DONE) and not self.run.note, self.run.status()
        return self.ok

    def on_manifold(self, tangents: np.ndarray) -> np.ndarray:
        """The part of arbitrary differences (size, k) that joints and drives allow at the present state.

        Differences of positions and velocities are projected in the metric of `weights`; those of accelerations follow
        from them and from those of the histories, of which only what a state can differ in stays.
        """
        W = np.array(tangents, dtype=np.float64, order="C")
        return self.run.on_manifold(self._checked(W))

    def tangent_basis(self, count: int, seed: int = 0) -> np.ndarray:
        """`count` tangent vectors (size, count), orthonormal in the weights, from random directions without histories.

        Histories have no weight, and bristles of 1e-6 m no use for differences of 1.

        Raises
        ------
        InputError : more of them than the system has dimensions; a number or a seed that is not whole.
        """
        W, n = super().tangent_basis(count, seed), self.program.n_q
        W[2 * n : 2 * n + self.program.tables.sizes.n_z] = 0.0
        W = self.on_manifold(W)
        orthonormalise(W, self.weights)
        return W

    def _checked(self, tangents: np.ndarray) -> np.ndarray:
        W = tangents
        if not isinstance(W, np.ndarray) or W.ndim != 2 or W.shape[0] != self.size or W.dtype != np.float64:
            text = f"MechanismFlow of {self.name!r}: tangents have shape {np.shape(W)}"
            raise InputError(f"{text}; they must be a float64 array ({self.size}, k), one difference a column.")
        if not np.isfinite(W).all():
            text = f"MechanismFlow of {self.name!r}: tangents hold numbers that are not finite"
            raise InputError(f"{text}. Make them orthonormal after shorter times, before one is lost in the others.")
        return W

    def take_step(self, limit: float, tangents: np.ndarray | None = None) -> bool:
        if not self.ok:
            return False
        here = self.snapshot()
        self.ok, self.status = self.run.one_step(limit), self.run.status()
        if self.ok and tangents is not None:
            size = self.time - here.time
            self.restore(here)
            return self.advance(size, tangents)
        return self.ok

    def velocity(self) -> np.ndarray:
        return mechanism_rates.velocity_of(self)

    def rate(self, signal: int) -> float:
        return mechanism_rates.rate_of(self, signal)

    def slopes(self, signal: int, tangents: np.ndarray) -> np.ndarray:
        return mechanism_rates.slopes_of(self, signal, tangents)

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

    @property
    def driven(self) -> bool:
        """Whether drives or loads change in time."""
        return len(self.program.motions) > 0

    def no_period(self) -> str:
        """Why it has no period, in a sentence without its end."""
        found = clash(self.program)
        if found is None:
            return "it has no periodic drive"
        return f"the periods of its drives, {found[0]:g} s and {found[1]:g} s, have no small common multiple"

    def snapshot(self) -> Snapshot:
        run = self.run
        return Snapshot(
            self.time, run.flow.saved(), run.record.signals.copy(), run.code, run.note, self.ok, self.status
        )

    def restore(self, snapshot: Snapshot) -> None:
        self.run.flow.restore(snapshot.arrays)
        self.run.record.signals[:] = snapshot.signals
        self.run.code, self.run.note, self.ok, self.status = snapshot[3:]

    def copy(self) -> Self:
        return self._with(self.step)

    @property
    def fineness(self) -> str:
        step = self.step
        return f"rtol {step.rtol:g}" if isinstance(step, Adaptive) else f"steps of {step.size:g} s"

    def finer(self) -> Self:
        other = self._with(self.step.finer())
        other.reset(self.state(), time=self.time)  # what the step control has learnt belongs to the other steps
        return other

    def another_start(self, part: float, seed: int) -> np.ndarray:
        """Other velocities in the same pose, so that no journal is pushed into its bearing."""
        n, way = self.program.n_q, self.tangent_basis(1, seed)[:, 0]
        x, weights = self.state(), self.weights
        size = float(np.sqrt(weights[n : 2 * n] @ x[n : 2 * n] ** 2))
        length = float(np.sqrt(weights[n : 2 * n] @ way[n : 2 * n] ** 2))
        x[n : 2 * n] += part * (size or self.program.length) / (length or 1.0) * way[n : 2 * n]
        return x

    def _with(self, step: Adaptive | FixedStep) -> Self:
        """A copy with these steps."""
        other = type(self)(self.base, step=step, method=self.method, period=self.declared)
        other._compile(self.changes)
        other.run.trial, other.run.redundant = (
            other.run.trial.replaced(free_multipliers=self.run.trial.free_multipliers),
            self.run.redundant,
        )
        other.restore(self.snapshot())
        other.run.record.peak[:] = self.run.record.peak
        return other

    def _compile(self, changes: Mapping[str, Any]) -> None:
        """Make program and run for these changes of the mechanism."""
        changed = changes != self.changes or "program" not in vars(self)
        mechanism = self.base.with_(changes) if changes else self.base
        if changed:
            self.program, self._closed = compile_with_start(mechanism)
            self.period = self.declared or period_or_none(self.program)
            self.names = tuple(s.name for s in self.program.names.signals)
            self.units = tuple(s.units for s in self.program.names.signals)
        self.changes = dict(changes)
        if self.period is None and isinstance(self.step, Adaptive) and self.step.max is None:
            text = f"MechanismFlow of {self.name!r}: no drive has a period, so nothing says how large a step may be"
            raise InputError(
                f"{text}. Give period= (about that of the motion), step=Adaptive(max=...) or a fixed step."
            )
        span = self.period or 1.0
        self.run = CarryingRun(self.program, self.method, self.step, span, span)
        self.ok, self.status = True, "ready"

    def _begin(self, start: Start, z: np.ndarray | None, time: float) -> None:
        self.run.begin(start, z=z, time=time)
        self.run.flow.clock.save_start = -1.0
