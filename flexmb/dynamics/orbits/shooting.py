"""Passes over a period with their tangent: what is left of coming back to the start, and how it depends on it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.systems.continuous_flow import ContinuousFlow
from flexmb.dynamics.systems.dynamics import Dynamics, orthonormalise
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.errors import AssemblyError, InputError, ModelError, SolveError

TURN = 2.0 * np.pi
TANGENTS = ("carried", "differences")

SMALL, SMALL_OF_A_FLOW = 6e-6, 1e-5
"""Differences of states, as a part of their size, from which derivatives are taken: maps, and flows whose steps have
errors of their own."""

Period = float | Callable[[Mapping[str, Any]], float] | None


class Space:
    """How far two states are apart, and which of their numbers must come back.

    Positions and velocities must (those without weight follow from others), angles of bodies up to whole turns.  Of the
    histories of a mechanism those of friction and of elements must come back as well (deflections of bristles, in
    their own units); those of normal contacts hold times of onsets, which cannot, and what positions and
    velocities determine: they are handed on from the end of a pass to the start of the next one.
    """

    def __init__(self, label: str, system: Dynamics, angles: tuple[str, ...] = ()) -> None:
        self.weights, size = system.weights.copy(), system.size
        self.angle, self.handed = np.zeros(size, dtype=bool), np.zeros(size, dtype=bool)
        self.memory = np.zeros(0, dtype=np.int64)
        if isinstance(system, MechanismFlow):
            n, n_z = system.program.n_q, system.program.tables.sizes.n_z
            self.angle[:n] = np.asarray(system.program.tables.kind) == 1
            self.memory = 2 * n + remembered(system)
            self.handed[2 * n : 2 * n + n_z] = True
            self.handed[self.memory] = False
            self.weights[self.memory] = 1.0
        for name in angles:
            if len(system.names) != size:
                raise InputError(f"{label}: angles are named, but {system.name!r} has no names for its state.")
            self.angle[system.names.index(checks.one_of(label, "angle", name, system.names))] = True

    def difference(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """one - other (size,), whole turns of angles taken away."""
        d = one - other
        d[self.angle] -= TURN * np.round(d[self.angle] / TURN)
        return d

    def length(self, d: np.ndarray) -> float:
        """Length of a difference in the weights."""
        return float(np.sqrt(self.weights @ (d * d)))

    def basis(self, system: Dynamics) -> np.ndarray:
        """Directions (size, d), orthonormal in the weights, in which the present state can differ."""
        d = system.dimension
        if d == 0:
            W = np.zeros((system.size, 0))
        elif d == system.size:
            W = system.on_manifold(np.eye(d))
            orthonormalise(W, self.weights)
        else:
            W = system.tangent_basis(d)
        if len(self.memory) == 0:
            return W
        Z = np.zeros((system.size, len(self.memory)))
        Z[self.memory, np.arange(len(self.memory))] = 1.0
        W = np.ascontiguousarray(np.hstack([W, system.on_manifold(Z)]))
        orthonormalise(W, self.weights)
        return W


def remembered(system: MechanismFlow) -> np.ndarray:
    """Places among the histories z of those of friction and of elements."""
    tables = system.program.tables
    pairs = [*np.asarray(tables.elements.z), *np.asarray(tables.constraints.joint_friction_z)]
    pairs += [row[2:4] for row in np.asarray(tables.contacts.z)]
    return np.array(sorted({i for begin, end in pairs for i in range(int(begin), int(end))}), dtype=np.int64)


@dataclass(frozen=True)
class Pass:
    """One pass over the period in M parts; d directions.

    starts, ends : (M, size) states;  bases : (M, size, d) of the starts
    slopes : (M, d, d) derivatives of the ends in the bases of the next starts;  gaps : (M, d) ends less next starts
    rates : (M, d) of the ends when the period grows;  drift : (d,) of the first start as time goes on, both for flows
        without a clock of their own
    miss : length of all gaps;  period : of the pass;  value : of the parameter
    """

    starts: np.ndarray
    ends: np.ndarray
    bases: np.ndarray
    slopes: np.ndarray
    gaps: np.ndarray
    rates: np.ndarray
    drift: np.ndarray
    miss: float
    period: float
    value: float

    @property
    def monodromy(self) -> np.ndarray:
        """(d, d) derivative of the state after the period by that before it."""
        whole = np.eye(self.slopes.shape[1])
        for A in self.slopes:
            whole = A @ whole
        return whole

    def matrix(self) -> np.ndarray:
        """(M d, M d) derivative of the gaps by the starts."""
        M, d = self.gaps.shape
        J = np.zeros((M * d, M * d))
        for j in range(M):
            k = (j + 1) % M
            J[j * d : (j + 1) * d, j * d : (j + 1) * d] += self.slopes[j]
            J[j * d : (j + 1) * d, k * d : (k + 1) * d] -= np.eye(d)
        return J


class Shooting:
    """Passes of a system over `times` periods in `segments` parts.

    Parameters
    ----------
    label : what messages begin with.
    system : it is moved about.
    period, times, autonomous, segments, tangent, angles : see `periodic_orbit`.
    """

    def __init__(
        self,
        label: str,
        system: Dynamics,
        *,
        period: Period,
        times: int,
        autonomous: bool,
        segments: int,
        tangent: str,
        angles: tuple[str, ...],
    ) -> None:
        self.label, self.system, self.autonomous, self.segments = label, system, autonomous, segments
        self.times, self.declared, self.angles = checks.count(label, "times", times), period, angles
        self.tangent = checks.one_of(label, "tangent", tangent, TANGENTS)
        self.is_flow, self.parameter, self.scale, self.status = system.unit == "s", None, 0.0, ""
        if not self.is_flow and (period is not None or autonomous):
            text = f"{label}: {system.name!r} counts {system.unit}"
            raise InputError(f"{text}; it has no period= to be given and is not autonomous. Give times= alone.")
        if not self.is_flow and self.times % segments:
            raise InputError(f"{label}: segments is {segments}; it must divide times, {times}, of a map.")
        self.base, self.phase = self._base(), 0.0
        if self.is_flow and not autonomous:
            turns = system.time / self.base
            self.phase = max(turns - np.floor(turns + 1e-9), 0.0)
        self.space = Space(label, system, angles)

    def copy(self, times: int, segments: int) -> Shooting:
        """Passes of a copy of the system over other numbers of periods and parts."""
        other = Shooting(
            self.label,
            self.system.copy(),
            period=self.declared,
            times=times,
            autonomous=self.autonomous,
            segments=segments,
            tangent=self.tangent,
            angles=self.angles,
        )
        other.parameter, other.scale, other.phase = self.parameter, self.scale, self.phase
        return other

    def _base(self) -> float:
        """The period that is repeated `times` times."""
        if not self.is_flow:
            return 1.0
        known = self.declared
        if known is None and isinstance(self.system, ContinuousFlow):
            known = self.system.period
        if known is None:
            text = f"{self.label}: {self.system.name!r} has no periodic drive and no period= is given"
            raise InputError(f"{text}. Give the period of what drives it, or autonomous=True with a guess of its own.")
        if callable(known):
            known = known(self.system.parameters)
        return checks.positive(self.label, "period", known, "s")

    def set_value(self, value: float) -> bool:
        """Give the parameter that is followed a value; whether the system takes it.  The period of drives follows."""
        if self.parameter is None:
            return True
        try:
            self.system.reset(parameters={self.parameter: float(value)})
            if not self.autonomous:
                self.base = self._base()
        except (InputError, ModelError, AssemblyError, SolveError) as error:
            self.status = f"{self.parameter} = {value:.6g} is refused: {error}"
            return False
        self.space = Space(self.label, self.system, self.angles)
        return True

    @property
    def origin(self) -> float:
        """Time at which a pass begins: that of the given state less whole periods."""
        return self.phase * self.base

    @property
    def period(self) -> float:
        """Length of a pass, of flows without a clock a first guess."""
        return self.base * self.times

    def spread(self, state: np.ndarray, period: float) -> np.ndarray | None:
        """Starts (segments, size) of all parts, on the motion from one state; None if it ends before."""
        starts = [state]
        for j in range(self.segments - 1):
            reached = self._go(starts[-1], j, period, None)
            if reached is None:
                return None
            starts.append(reached)
        return np.array(starts)

    def run(self, starts: np.ndarray, period: float, value: float = np.nan) -> Pass | None:
        """A pass from these starts (M, size), brought to the manifold first; None if it fails (see `status`)."""
        M = self.segments
        found: list[tuple[np.ndarray, ...]] = []
        if not np.isnan(value) and not self.set_value(value):
            return None
        for j in range(M):
            one = self._part(starts[j], j, period)
            if one is None:
                return None
            found.append(one)
        start, end, W, carried, rate, drift = ([f[i] for f in found] for i in range(6))
        wide = [W[j].T * self.space.weights for j in range(M)]
        gaps = [self.space.difference(end[j], start[(j + 1) % M]) for j in range(M)]
        lengths = [self.space.length(x) for x in (*start, *end)]
        miss = float(np.sqrt(sum(self.space.length(g) ** 2 for g in gaps)))
        if not np.isfinite([miss, *lengths]).all() or not all(np.isfinite(T).all() for T in carried):
            self.status = "A pass over the period is not finite."
            return None
        self.scale = max(self.scale, *lengths)
        following = [(j + 1) % M for j in range(M)]
        return Pass(
            np.array(start),
            np.array(end),
            np.array(W),
            np.array([wide[k] @ carried[j] for j, k in enumerate(following)]),
            np.array([wide[k] @ gaps[j] for j, k in enumerate(following)]),
            np.array([wide[k] @ rate[j] / M for j, k in enumerate(following)]),
            wide[0] @ drift[0],
            miss,
            period,
            value,
        )

    def by_parameter(self, one: Pass, small: float) -> np.ndarray:
        """(M, d) derivatives of the gaps by the parameter, by central differences of size `small`; NaN if one fails."""
        M, space, ends = self.segments, self.space, []
        period = one.period
        for value in (one.value + small, one.value - small):
            reached: list[tuple[Any, Any]] = [(None, None)] * M
            for j in range(M) if self.set_value(value) else ():
                at = period if self.autonomous else self.period
                end = self._go(one.starts[j], j, at, None)
                reached[j] = (self.began, end)
            ends.append(reached)
        self.set_value(one.value)
        rows = np.full(one.gaps.shape, np.nan)
        for j in range(M):
            k = (j + 1) % M
            if all(ends[s][j][1] is not None and ends[s][k][1] is not None for s in (0, 1)):
                up, down = (space.difference(ends[s][j][1], ends[s][k][0]) for s in (0, 1))
                rows[j] = (one.bases[k].T * space.weights) @ space.difference(up, down) / (2.0 * small)
        return rows

    def moved(self, one: Pass, y: np.ndarray) -> np.ndarray:
        """Starts (M, size) of a pass moved by y (M, d) in their bases; what is handed on is taken from the ends."""
        starts = one.starts + np.einsum("jsd,jd->js", one.bases, y)
        starts[:, self.space.handed] = np.roll(one.ends, 1, axis=0)[:, self.space.handed]
        return starts

    def _part(self, start: np.ndarray, j: int, period: float) -> tuple[np.ndarray, ...] | None:
        """Start, end, basis, what becomes of the basis, rate of the end, rate of the start."""
        if not self._place(start, j, period):
            return None
        nothing = np.zeros(self.system.size)
        drift = self.system.velocity() if self.autonomous else nothing
        start = self.system.state()
        if self.tangent == "differences":
            W, carried = self._by_differences(start, j, period)
            end = self._go(start, j, period, None)
        else:
            W = self.space.basis(self.system)
            carried = W.copy()
            end = self._advance(period / self.segments, carried)
        if end is None or W is None:
            return None
        return start, end, W, carried, self.system.velocity() if self.autonomous else nothing, drift

    def _by_differences(self, start: np.ndarray, j: int, period: float) -> tuple[Any, Any]:
        """Basis at a start and what becomes of it, from passes beside it; the starts are what `reset` makes of them."""
        rough = np.random.default_rng(0).standard_normal((len(start), self.system.dimension))
        rough[self.space.weights == 0.0] = 0.0
        if len(rough) == rough.shape[1]:
            rough = np.eye(len(start))
        memory = np.zeros((len(start), len(self.space.memory)))
        memory[self.space.memory, np.arange(len(self.space.memory))] = 1.0
        V = np.hstack([rough, memory])
        orthonormalise(V, self.space.weights)
        part = SMALL_OF_A_FLOW if self.is_flow else SMALL
        size = part * max(self.space.length(start), 1e-3 * self.scale, 1e-9)
        W = self._pairs(start, V, j, period, size, ends=False)[0]
        if W is None:
            return None, None
        orthonormalise(W, self.space.weights)
        made, carried = self._pairs(start, W, j, period, size, ends=True)
        if made is None:
            return None, None
        return W, carried @ np.linalg.pinv((W.T * self.space.weights) @ made)

    def _pairs(
        self, start: np.ndarray, V: np.ndarray, j: int, period: float, size: float, *, ends: bool
    ) -> tuple[Any, Any]:
        """(size, d) differences of starts on both sides of one, over 2 `size`, and of what becomes of them."""
        starts, after = [], []
        if V.shape[1] == 0:
            return V.copy(), V.copy()
        for direction in V.T:
            pair = []
            for sign in (1.0, -1.0):
                if not self._place(start + sign * size * direction, j, period):
                    return None, None
                pair.append(self.system.state())
                if ends:
                    end = self._advance(period / self.segments, None)
                    if end is None:
                        return None, None
                    pair.append(end)
            starts.append(self.space.difference(pair[0], pair[2 if ends else 1]))
            after.append(self.space.difference(pair[1], pair[3]) if ends else starts[-1])
        return np.array(starts).T / (2.0 * size), np.array(after).T / (2.0 * size)

    def _go(self, start: np.ndarray, j: int, period: float, tangents: np.ndarray | None) -> np.ndarray | None:
        """The end of part j that begins there; `began` is where it really did."""
        if not self._place(start, j, period):
            return None
        self.began = self.system.state()
        return self._advance(period / self.segments, tangents)

    def _place(self, state: np.ndarray, j: int, period: float) -> bool:
        """Bring the system to a state at the beginning of part j; whether it could be."""
        if not np.isfinite(state).all():
            self.status = "A state is not finite."
            return False
        try:
            self.system.reset(state, time=self.origin + j * period / self.segments)
        except (AssemblyError, SolveError) as error:
            self.status = str(error)
            return False
        return True

    def _advance(self, duration: float, tangents: np.ndarray | None) -> np.ndarray | None:
        ok = self.system.advance(duration if self.is_flow else round(duration), tangents)
        if not ok:
            self.status = self.system.status
            return None
        return self.system.state()
