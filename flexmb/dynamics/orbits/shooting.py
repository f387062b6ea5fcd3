"""Multiple shooting: the motion over a period in segments, its gaps, their derivatives; grazing of contacts.

Equation (9.12) of docs/theory/exponents.md.
"""

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.systems.dynamics import Dynamics, Period, orthonormalise
from flexmb.errors import AssemblyError, InputError, ModelError, SolveError

TURN = 2.0 * np.pi


class StateSpace:
    """Differences of states, their lengths, and the entries of a state that must return on a periodic orbit."""

    # Positions and velocities must return, angles of bodies up to whole turns; entries without weight follow from them.
    # Histories of friction and of elements must return as well, in their own units (deflections of bristles). Histories
    # of normal contacts need not: they hold times of onsets, and values that positions and velocities determine. They
    # are passed on from the end of one run to the start of the next run (`free_rows`). The entries named by `angles`
    # count modulo 2 pi.

    def __init__(self, label: str, system: Dynamics, angles: tuple[str, ...] = ()) -> None:
        self.weights, size = system.weights.copy(), system.size
        self.cycle, self.free_rows = np.full(size, np.inf), np.zeros(size, dtype=bool)
        self.history_rows, free_rows = system.histories
        self.cycle[list(system.cycles)], self.free_rows[free_rows] = list(system.cycles.values()), True
        self.weights[self.history_rows] = 1.0
        for name in angles:
            if len(system.names) != size:
                raise InputError(f"{label}: angles are named, but {system.name!r} has no names for its state.")
            self.cycle[system.names.index(checks.one_of(label, "angle", name, system.names))] = TURN

    def difference(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Differences one - other (size,) or (n, size) of states, without whole turns of angles."""
        d, turns = one - other, np.isfinite(self.cycle)
        d[..., turns] -= self.cycle[turns] * np.round(d[..., turns] / self.cycle[turns])
        return np.asarray(d)

    def length(self, d: np.ndarray) -> float:
        """Length of a difference `d` (size,) in the weights."""
        return float(np.sqrt(self.weights @ (d * d)))

    def basis(self, system: Dynamics) -> np.ndarray:
        """Basis (size, d) of the differences that the present state of a `system` allows, orthonormal."""
        d, W = system.dimension, np.zeros((system.size, 0))
        if d:
            W = system.on_manifold(np.eye(d)) if d == system.size else system.on_section(system.tangent_basis(d))
            orthonormalise(W, self.weights)
        if len(self.history_rows) == 0:
            return W
        Z = np.zeros((system.size, len(self.history_rows)))
        Z[self.history_rows, np.arange(len(self.history_rows))] = 1.0
        W = np.ascontiguousarray(np.hstack([W, system.on_manifold(Z)]))
        orthonormalise(W, self.weights)
        return W


TANGENTS = ("carried", "differences")
# Differences of states, over their size, for numerical derivatives of maps and of flows (errors of their steps).
SMALL, SMALL_OF_A_FLOW = 6e-6, 1e-5


@dataclass(frozen=True)
class ShootingRun:
    """The motion over one period in M segments, with d directions."""

    starts: np.ndarray  # states (M, size) at the start and end of each segment
    ends: np.ndarray
    bases: np.ndarray  # bases (M, size, d) at the starts
    slopes: np.ndarray  # derivatives (M, d, d) of the ends by the starts, in the bases of the next starts
    gaps: np.ndarray  # ends less next starts (M, d)
    rates: np.ndarray  # derivatives (M, d) of the ends by the period, for autonomous flows
    drift: np.ndarray  # rate (d,) of the first start, for autonomous flows
    miss: float  # length of all gaps
    period: float  # length of the run [s, or iterations]
    value: float  # value of the continuation parameter; NaN: none

    @property
    def monodromy(self) -> np.ndarray:
        """Derivative (d, d) of the state after the period by the state before."""
        # Equation (9.13) of docs/theory/exponents.md.
        whole = np.eye(self.slopes.shape[1])
        for A in self.slopes:
            whole = A @ whole
        return whole

    def matrix(self) -> np.ndarray:
        """Derivative (M d, M d) of the gaps by the starts."""
        M, d = self.gaps.shape
        J = np.zeros((M * d, M * d))
        for j in range(M):
            k = (j + 1) % M
            J[j * d : (j + 1) * d, j * d : (j + 1) * d] += self.slopes[j]
            J[j * d : (j + 1) * d, k * d : (k + 1) * d] -= np.eye(d)
        return J


class Shooting:
    """Multiple shooting of a flow or map, with the arguments of `periodic_orbit`."""

    def __init__(
        self, label: str, system: Dynamics, *, period: Period, times: int = 1, autonomous: bool = False,
        segments: int = 1, tangent: str = TANGENTS[0], angles: tuple[str, ...] = (),
    ) -> None:  # fmt: skip
        self.label, self.system, self.autonomous, self.segments = label, system, autonomous, segments
        self.times, self.declared, self.angles = checks.count(label, "times", times), period, angles
        self.tangent = checks.one_of(label, "tangent", tangent, TANGENTS)
        self.is_flow, self.scale, self.status = system.unit == "s", 0.0, ""
        self.parameter: str | None = None
        self.enlarged = 1.0  # size of differences of motions, over the usual one
        if not self.is_flow and (period is not None or autonomous):
            text = f"{label}: {system.name!r} counts {system.unit}"
            raise InputError(f"{text}; it has no period= and is not autonomous. Give times= alone.")
        if not self.is_flow and self.times % segments:
            raise InputError(f"{label}: segments is {segments}; it must divide times, {times}, of a map.")
        self.base, self.phase = self._base(), 0.0
        if self.is_flow and not autonomous:
            elapsed_periods = system.time / self.base
            self.phase = max(elapsed_periods - np.floor(elapsed_periods + 1e-9), 0.0)
        self.space = StateSpace(label, system, angles)

    def copy(self, times: int, segments: int) -> "Shooting":
        """Shooting over other numbers of periods and segments, with a copy of the system."""
        other = copy.copy(self)
        other.system, other.times, other.segments, other.status = self.system.copy(), times, segments, ""
        other.base, other.space = other._base(), StateSpace(self.label, other.system, self.angles)
        return other

    def _base(self) -> float:
        """The single period, of which the orbit lasts `times`."""
        if not self.is_flow:
            return 1.0
        given = self.system.period if self.declared is None else self.declared
        if given is None:
            text = f"{self.label}: {self.system.name!r} has no periodic drive and no period= is given"
            raise InputError(f"{text}. Give the period of the drive, or autonomous=True with a guess of the period.")
        return checks.positive(self.label, "period", given(self.system.parameters) if callable(given) else given, "s")

    def set_value(self, value: float) -> bool:
        """Set the continuation parameter and the period of the drives; returns whether the system accepts the value."""
        if self.parameter is None:
            return True
        try:
            self.system.reset(parameters={self.parameter: float(value)})
            if not self.autonomous:
                self.base = self._base()
        except (InputError, ModelError, AssemblyError, SolveError) as error:
            self.status = f"{self.parameter} = {value:.6g} is refused: {error}"
            return False
        self.space = StateSpace(self.label, self.system, self.angles)
        return True

    @property
    def origin(self) -> float:
        """Start time of a run: the time of the given state less whole periods."""
        return self.phase * self.base

    @property
    def period(self) -> float:
        """Length of a run; for autonomous flows a first guess."""
        return self.base * self.times

    def spread(self, state: np.ndarray, period: float) -> np.ndarray | None:
        """Starts (segments, size) of all segments, on the motion from one state (size,); None: it ends early."""
        starts = [state]
        for j in range(self.segments - 1):
            reached = self._go(starts[-1], j, period)
            if reached is None:
                return None
            starts.append(reached)
        return np.array(starts)

    def run(self, starts: np.ndarray, period: float, value: float = np.nan) -> ShootingRun | None:
        """The motion over a period from starts (M, size), projected onto the constraints; None: see `status`."""
        # The continuation parameter is set to `value`; NaN: unchanged.
        M = self.segments
        segments: list[tuple[np.ndarray, ...]] = []
        if not np.isnan(value) and not self.set_value(value):
            return None
        for j in range(M):
            segment = self._segment(starts[j], j, period)
            if segment is None:
                return None
            segments.append(segment)
        start, end, W, carried_bases, rate, drift = ([f[i] for f in segments] for i in range(6))
        weighted = [W[j].T * self.space.weights for j in range(M)]
        gaps = [self.space.difference(end[j], start[(j + 1) % M]) for j in range(M)]
        lengths = [self.space.length(x) for x in (*start, *end)]
        miss = float(np.sqrt(sum(self.space.length(g) ** 2 for g in gaps)))
        if not np.isfinite([miss, *lengths]).all() or not all(np.isfinite(T).all() for T in carried_bases):
            self.status = "The motion over the period is not finite."
            return None
        self.scale = max(self.scale, *lengths)
        following = [(j + 1) % M for j in range(M)]
        return ShootingRun(
            np.array(start), np.array(end), np.array(W),
            np.array([weighted[k] @ carried_bases[j] for j, k in enumerate(following)]),
            np.array([weighted[k] @ gaps[j] for j, k in enumerate(following)]),
            np.array([weighted[k] @ rate[j] / M for j, k in enumerate(following)]), weighted[0] @ drift[0], miss,
            period, value,
        )  # fmt: skip

    def by_parameter(self, run: ShootingRun, small: float) -> np.ndarray:
        """Derivatives (M, d) of the gaps by the parameter, by central differences; NaN after a failure."""
        M, space, shifted_ends = self.segments, self.space, []
        for value in (run.value + small, run.value - small):
            segment_ends: list[tuple[Any, Any]] = [(None, None)] * M
            for j in range(M) if self.set_value(value) else ():
                end = self._go(run.starts[j], j, run.period if self.autonomous else self.period)
                segment_ends[j] = (self.began, end)
            shifted_ends.append(segment_ends)
        self.set_value(run.value)
        rows = np.full(run.gaps.shape, np.nan)
        for j in range(M):
            k = (j + 1) % M
            if all(shifted_ends[s][j][1] is not None and shifted_ends[s][k][1] is not None for s in (0, 1)):
                up, down = (space.difference(shifted_ends[s][j][1], shifted_ends[s][k][0]) for s in (0, 1))
                rows[j] = (run.bases[k].T * space.weights) @ space.difference(up, down) / (2.0 * small)
        return rows

    def moved(self, run: ShootingRun, y: np.ndarray) -> np.ndarray:
        """Starts (M, size) of a run moved by y (M, d) in their bases."""
        # Rows that need not return are taken from the ends of the segments.
        starts = np.asarray(run.starts + np.einsum("jsd,jd->js", run.bases, y))
        starts[:, self.space.free_rows] = np.roll(run.ends, 1, axis=0)[:, self.space.free_rows]
        return starts

    def _segment(self, start: np.ndarray, j: int, period: float) -> tuple[np.ndarray, ...] | None:
        """Start, end, basis at the start, basis advanced to the end, rate of the end, rate of the start."""
        if not self._place(start, j, period):
            return None
        nothing = np.zeros(self.system.size)
        drift = self.system.velocity() if self.autonomous else nothing
        start = self.system.state()
        if self.tangent == "differences":
            W, carried = self._by_differences(start, j, period)
            end = self._go(start, j, period)
        else:
            W = self.space.basis(self.system)
            carried = W.copy()
            end = self._advance(period / self.segments, carried)
        if end is None or W is None:
            return None
        return start, end, W, carried, self.system.velocity() if self.autonomous else nothing, drift

    def _by_differences(self, start: np.ndarray, j: int, period: float) -> tuple[Any, Any]:
        """Basis at a start and basis advanced to the end, from neighbouring runs; `reset` projects their starts."""
        directions = np.random.default_rng(0).standard_normal((len(start), self.system.dimension))
        directions[self.space.weights == 0.0] = 0.0
        if len(directions) == directions.shape[1]:
            directions = np.eye(len(start))
        history_rows = np.zeros((len(start), len(self.space.history_rows)))
        history_rows[self.space.history_rows, np.arange(len(self.space.history_rows))] = 1.0
        directions_and_histories = np.hstack([directions, history_rows])
        orthonormalise(directions_and_histories, self.space.weights)
        relative = self.enlarged * (SMALL_OF_A_FLOW if self.is_flow else SMALL)
        size = relative * max(self.space.length(start), 1e-3 * self.scale, 1e-9)
        W = self._pairs(start, directions_and_histories, j, period, size, ends=False)[0]
        if W is None:
            return None, None
        orthonormalise(W, self.space.weights)
        start_basis, carried = self._pairs(start, W, j, period, size, ends=True)
        if start_basis is None:
            return None, None
        return W, carried @ np.linalg.pinv((W.T * self.space.weights) @ start_basis)

    def _pairs(
        self, start: np.ndarray, V: np.ndarray, j: int, period: float, size: float, *, ends: bool
    ) -> tuple[Any, Any]:
        """Differences (size, d) of starts on both sides of one, and of their ends, over 2 `size`."""
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
                    end = self._advance(period / self.segments)
                    if end is None:
                        return None, None
                    pair.append(end)
            starts.append(self.space.difference(pair[0], pair[2 if ends else 1]))
            after.append(self.space.difference(pair[1], pair[3]) if ends else starts[-1])
        return np.array(starts).T / (2.0 * size), np.array(after).T / (2.0 * size)

    def _go(self, start: np.ndarray, j: int, period: float) -> np.ndarray | None:
        """End of segment j from a start; `began` is the projected start."""
        if not self._place(start, j, period):
            return None
        self.began = self.system.state()
        return self._advance(period / self.segments)

    def _place(self, state: np.ndarray, j: int, period: float) -> bool:
        """Set the system to a state at the beginning of segment j; returns whether that succeeded."""
        if not np.isfinite(state).all():
            self.status = "A state is not finite."
            return False
        try:
            self.system.reset(state, time=self.origin + j * period / self.segments)
        except (InputError, AssemblyError, SolveError) as error:  # behind a wall; constraints that cannot be met
            self.status = str(error)
            return False
        return True

    def _advance(self, duration: float, tangents: np.ndarray | None = None) -> np.ndarray | None:
        if self.system.advance(duration if self.is_flow else round(duration), tangents):
            return self.system.state()
        self.status = self.system.status
        return None


SAMPLES = 200  # default number of samples in a period
FINER = 32  # number of samples in each of the two refinements of a minimum
SHARP = 0.3  # ratio of the rises beside a minimum in both refinements above which the minimum is an impact


def gap_signals(system: Dynamics, asked: str | None, label: str) -> dict[str, tuple[int, float]]:
    """Number and sign of the signals that measure gaps (> 0: open), by name; None: signals of all contacts."""
    if asked is not None:
        return {asked: (system.names.index(checks.one_of(label, "grazing", asked, system.names)), 1.0)}
    return {name: (system.names.index(name), sign) for name, sign in system.gaps.items()}


def sampled(system: Dynamics, duration: float, count: int) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Times (n,), signals (n, names) and states from the present state on; `count` + 1, fewer after a failure."""
    # The duration is in seconds or iterations; a map gives every iteration.
    flow = system.unit == "s"
    count, begin = count if flow else round(duration), system.time
    times, values, states = [begin], [system.observe()], [system.state()]
    for k in range(count):
        time = begin + duration * (k + 1) / count
        if not system.advance(time - system.time if flow else 1):
            break
        times.append(time)
        values.append(system.observe())
        states.append(system.state())
    return np.array(times), np.array(values), states


def closest_approaches(
    system: Dynamics, gaps: dict[str, tuple[int, float]], orbit: tuple[np.ndarray, np.ndarray, Sequence[np.ndarray]]
) -> dict[str, tuple[float, float, int]]:
    """For each gap on an orbit: its turning point nearest to 0 [m], its travel [m], and the number of its closures."""
    # > 0: the surfaces just miss each other; < 0: they just touch. Turning points are located between the samples.
    # Sharp minima, as at rebounds of rigid surfaces, do not count; NaN: no turning point. The system is advanced;
    # `orbit` is a result of `sampled`.
    times, values, states = orbit
    approaches = {}
    for name, (place, sign) in gaps.items():
        gap = sign * values[:, place]
        nearest, closures = np.nan, 0
        for k in range(1, len(gap)):
            next_value = gap[k + 1] if k + 1 < len(gap) else gap[1]  # the orbit is closed
            if not (gap[k] <= gap[k - 1] and gap[k] < next_value):
                continue
            rise = max(gap[k - 1], next_value) - gap[k]
            if not np.isnan(nearest) and abs(gap[k]) - rise > abs(nearest):
                closures += int(gap[k] < 0.0)
                continue  # no smaller turning point is possible here
            least = _turning_point(system, (times[k - 1], 2.0 * times[k] - times[k - 1]), states[k - 1], place, sign)
            closures += int(not least > 0.0)  # a sharp one is an impact
            if not np.isnan(least) and (np.isnan(nearest) or abs(least) < abs(nearest)):
                nearest = least
        approaches[name] = (float(nearest), float(np.ptp(gap)), closures)
    return approaches


def _turning_point(system: Dynamics, span: tuple[float, float], state: np.ndarray, place: int, sign: float) -> float:
    """Smallest gap in a short time span from a state; NaN for a sharp minimum."""
    slopes, least = [], np.nan
    for _ in range(2):
        system.reset(state, time=span[0])
        times, values, states = sampled(system, span[1] - span[0], FINER)
        if len(times) <= FINER:
            return np.nan
        gap = sign * values[:, place]
        k = min(max(int(gap.argmin()), 1), FINER - 1)
        least = float(gap[k])
        slopes.append(max(gap[k - 1], gap[k + 1]) - least)
        state, span = states[k - 1], (times[k - 1], times[k + 1])
    # spans shrink by FINER/2: the rise beside a smooth minimum shrinks by the square of this, beside an edge by FINER/2
    return np.nan if slopes[1] > SHARP * slopes[0] / (FINER / 2.0) else least
