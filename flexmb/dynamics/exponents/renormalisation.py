"""Growth of small differences: schedule, advance, logarithms, renormalisation.

`exponents_of` holds the loop over the points, `growth_to_next_point` the loop between two points.  Both serve tangent
vectors (`TangentVectors`) and pairs of trajectories (`benettin.TrajectoryPair`).
Equation (9.4) of docs/theory/exponents.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from flexmb import checks
from flexmb.dynamics.exponents.exponents import SETTLING, Exponents, check_enough, error_of, with_verdict
from flexmb.dynamics.jobs.executors import tell_stopped
from flexmb.dynamics.jobs.progress import ProgressBar
from flexmb.dynamics.sections.maps import strobe_of
from flexmb.dynamics.sections.points import SectionSignals
from flexmb.dynamics.systems.dynamics import Dynamics, as_dynamics, orthonormalise
from flexmb.errors import InputError

if TYPE_CHECKING:
    from flexmb.engine.newmark.method import Newmark
    from flexmb.run.simulate import Step

MOST_LOOKS = 4096  # largest number of renormalisations between two points
INTERVALS = 1000  # number of intervals into which a duration is divided, if no interval is given


@dataclass(frozen=True)
class Span:
    """Arguments of `lyapunov` and `benettin` on the points of a run, and its caller."""

    caller: str
    skip: float
    periods: int | None
    duration: float | None
    interval: float | None
    period: float | None

    def schedule(self, given: Any, step: Step | None, method: Newmark | None) -> Schedule:
        """Schedule of a run of the system `given`; arguments that would have no influence are refused."""
        system = as_dynamics(self.caller, given, period=self.period, step=step, method=method)
        label, is_flow = f"{self.caller} {system.name!r}", system.underlying is system
        if self.interval is not None and self.duration is None:
            raise InputError(f"{label}: interval= goes with duration=; with periods= the interval is the period.")
        if self.period is not None and given is system:
            if not is_flow:
                raise InputError(f"{label}: period= belongs to a flow; this is a map. Leave it out.")
            if self.duration is not None:
                text = f"{label}: period= goes with periods=; with duration= give interval=, the time between points"
                raise InputError(f"{text}.")
        if (self.periods is None) == (self.duration is None):
            text = f"{label}: periods is {self.periods!r} and duration is {self.duration!r}; give either periods="
            raise InputError(f"{text} (iterations of a map, crossings of a section) or duration= [s].")
        if self.duration is not None:
            if not is_flow:
                raise InputError(f"{label}: duration= belongs to a flow; this is a map. Give periods=.")
            end = checks.positive(label, "duration", self.duration, "s")
            unit = end / INTERVALS if self.interval is None else checks.positive(label, "interval", self.interval, "s")
            number = round(end / unit)
            check_enough(label, number, "intervals")
            skipped = int(np.ceil(checks.not_negative(label, "skip", self.skip, "s") / unit - 1e-9))
            return Schedule(system, unit, skipped, number, is_section=False)
        number, skipped = checks.count(label, "periods", self.periods), checks.count(label, "skip", self.skip, 0)
        check_enough(label, number, system.unit if not is_flow and system.period is None else "periods")
        strobe = strobe_of(self.caller, system, self.period)
        flow, length = strobe.underlying, strobe.period
        if flow is None or length is None:
            return Schedule(system, 1.0, skipped, number)
        return Schedule(flow, length, skipped, number)

    def finished(self, exponents: Exponents, schedule: Schedule) -> Exponents:
        """Exponents of a run with the verdict on its section points, and a note for the job after an early end."""
        if not exponents.ok:
            tell_stopped(f"{self.caller} {schedule.system.name!r}", exponents.status)
        return with_verdict(exponents) if schedule.is_section else exponents


@dataclass
class Schedule:
    """Points at which the growth of small differences is recorded, and renormalisations between two points."""

    system: Dynamics
    interval: float  # time between two points [s]; of a map 1 iteration
    skip: int  # number of points before the small differences start
    count: int  # number of points after the skipped ones
    is_section: bool = True  # whether the points are points of a section or of a map
    renormalisations: int = 1  # number of renormalisations between two points
    trouble: str = ""  # reason why the run ended early, if the system itself did not fail; else ""

    def __post_init__(self) -> None:
        self.origin, self.records = self.system.time, self.system.records
        self.flow = self.system.underlying if self.system.underlying is self.system else None

    def advance(self, system: Dynamics, number: int, fraction: float = 1.0, tangents: np.ndarray | None = None) -> bool:
        """Advance a system between two points to a fraction of the interval before point `number` (>= 1)."""
        # The system is that of the schedule or a copy; tangent vectors (size, k) are advanced in place. Returns whether
        # the end was reached.
        if self.flow is None:
            return system.advance(1, tangents)
        return system.advance(self.origin + (number - 1 + fraction) * self.interval - system.time, tangents)


# Growth of small differences: advance, measure the growth, take the logarithm, renormalise; then the exponents

# Growth factor, or ratio of growth factors, between two renormalisations, above which they become more frequent.
TOO_MUCH = 1e4
# Ratio of growth factors above which the vectors are advanced again, in halves: the shortest is lost in round-off.
FAR_TOO_MUCH = 1e6
# Length of a vector without its components along the others, over its own length, below which it is round-off.
LOST = 1e-13


class Perturbation(Protocol):
    """Small differences of states whose growth is measured."""

    strained_fraction: float
    """Fraction of the renormalisations with too much growth at which they become more frequent."""

    def growth(self, schedule: Schedule, number: int, begin: float, end: float) -> np.ndarray | None:
        """Logarithms (k,) of the growth between two fractions of the interval before a point; None: it failed."""
        # The differences are renormalised. `schedule.trouble` is the reason of a failure, unless the system failed.

    def is_strained(self, logs: np.ndarray) -> bool:
        """Whether logarithms (k,) of the growth between two renormalisations `logs` are too large."""


def exponents_of(schedule: Schedule, start: Callable[[], Perturbation], count: int, *, shown: bool) -> Exponents:
    """Lyapunov exponents of one run, without a verdict; `start` makes the differences after the skipped points."""
    system, points = schedule.system, [np.zeros((0, len(schedule.system.names)))]
    logs, times = list[np.ndarray](), list[float]()
    progress = ProgressBar(system.name, float(schedule.skip + schedule.count), shown=shown, of="periods")
    perturbation, begin = None, system.clock
    last_of_transient = schedule.skip + schedule.count // SETTLING
    for number in range(1, schedule.skip + schedule.count + 1):
        if number == schedule.skip + 1:
            perturbation = start()
        before = system.clock
        if number == last_of_transient + 1:
            begin = before
        growth = growth_to_next_point(schedule, perturbation, number)
        if growth is None:
            break
        progress.update(1)
        if number > schedule.skip:
            points.append(system.observe()[None])
        if number > last_of_transient:
            logs.append(growth)
            times.append(system.clock - before)
    progress.close()
    table = np.array(logs).reshape(len(times), count)
    return _recorded(schedule, table, np.array(times), begin, np.concatenate(points))


def _recorded(schedule: Schedule, logs: np.ndarray, times: np.ndarray, begin: float, points: np.ndarray) -> Exponents:
    """Exponents of a run, without a verdict, from logarithms of growth (n, k) in times (n,) from `begin` on [s]."""
    system, wanted, sums, spent = schedule.system, schedule.count - schedule.count // SETTLING, logs, np.cumsum(times)
    ok = len(times) == wanted
    status = f"Mean of {wanted} {system.unit if schedule.flow is None else 'points'}."
    status = " ".join([status, *system.remarks(begin)]) if ok else schedule.trouble or system.status
    timed = system.underlying is not None
    values = errors = np.full(logs.shape[1], np.nan)
    if len(times):
        with np.errstate(invalid="ignore"):
            sums = np.cumsum(logs, axis=0) / spent[:, None]
        order = np.argsort(-sums[-1], kind="stable")
        values, sums = sums[-1][order], sums[:, order]
        errors = np.array([error_of(column, times) for column in logs.T])[order]
    time, unit = begin + spent, "1/s" if timed else "1/iteration"
    period = float(np.mean(times)) if schedule.is_section and timed and len(times) else float("nan")
    signals = SectionSignals.of(system)
    return Exponents(system.name, values, errors, time, sums, unit, ok, status, points, signals, period)


def growth_to_next_point(schedule: Schedule, perturbation: Perturbation | None, number: int) -> np.ndarray | None:
    """Logarithms (k,) of the growth of small differences up to the next point; None: the point was not reached."""
    # The schedule's number of renormalisations between two points may increase. Without a perturbation the system is
    # advanced alone.
    if perturbation is None:
        return np.zeros(0) if schedule.advance(schedule.system, number) else None
    total, strained, times = np.zeros(0), 0, schedule.renormalisations
    for k in range(1, times + 1):
        logs = perturbation.growth(schedule, number, (k - 1) / times, k / times)
        if logs is None:
            return None
        total = total + logs if len(total) else logs
        strained += perturbation.is_strained(logs)
    if schedule.flow is not None and strained and strained >= perturbation.strained_fraction * times:
        schedule.renormalisations = min(2 * schedule.renormalisations, MOST_LOOKS)
    return total


class TangentVectors:
    """Tangent vectors, made orthonormal at each renormalisation (G. Benettin et al., Meccanica 15 (1980) 9)."""

    # The vectors W (size, k) are orthonormal in the weights (size,) of the system.
    strained_fraction = 0.25  # a single impact is divided at its instant, and not the whole period

    def __init__(self, W: np.ndarray, weights: np.ndarray) -> None:
        self.W, self.weights = W, weights

    def is_strained(self, logs: np.ndarray) -> bool:
        """Whether the lengths of the vectors differ by more than `TOO_MUCH` (`logs`: logarithms of their growth)."""
        return bool(logs.max(initial=0.0) - logs.min(initial=0.0) > np.log(TOO_MUCH))

    def growth(self, schedule: Schedule, number: int, begin: float, end: float) -> np.ndarray | None:
        """See `Perturbation.growth`; an interval with far too much growth is divided into halves."""
        system, flow, W, weights = schedule.system, schedule.flow, self.W, self.weights
        saved = None if flow is None else (flow.snapshot(), W.copy())
        reached = schedule.advance(system, number, end, W)
        whole = lengths_of(W, weights)
        lengths = orthonormalise(W, weights) if reached else np.full(W.shape[1], np.nan)
        W[schedule.records] = 0.0  # bookkeeping would grow without bound if the rest of a vector shrinks
        finite = bool(np.isfinite(lengths).all() and np.isfinite(W).all())
        spread = lengths.max() / max(min(lengths.min(), 1.0), 1e-300) if finite else np.inf
        if flow is not None and saved is not None and spread > FAR_TOO_MUCH and end - begin > 1.0 / MOST_LOOKS:
            if not flow.ok:  # does the motion fail, or are only the vectors too long?
                flow.restore(saved[0])
                if not schedule.advance(flow, number, end):
                    return None
            flow.restore(saved[0])
            W[:] = saved[1]
            middle = 0.5 * (begin + end)
            first = self.growth(schedule, number, begin, middle)
            second = None if first is None else self.growth(schedule, number, middle, end)
            return None if first is None or second is None else first + second
        if not reached:
            return None
        if not finite or (lengths < LOST * whole).any():
            fault = "are not finite" if not finite else "are parallel up to round-off"
            text = f"The tangent vectors {fault} at {system.clock:.6g}"
            schedule.trouble = f"{text}." if not finite else f"{text}. Ask for fewer exponents (count=)."
            return None
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(lengths))


def lengths_of(W: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Lengths (k,) of the columns of W (size, k) in the weights, without overflow of their squares."""
    weighted = weights > 0.0
    largest = np.abs(W[weighted]).max(axis=0, initial=0.0)
    scale = np.where(largest > 0.0, largest, 1.0)
    with np.errstate(invalid="ignore", over="ignore"):
        return np.asarray(largest * np.sqrt(weights[weighted] @ (W[weighted] / scale) ** 2))


def tangent_exponents(schedule: Schedule, count: int, seed: int, *, shown: bool) -> Exponents:
    """Lyapunov exponents of one run with `count` tangent vectors in random directions, without a verdict."""
    basis, weights = schedule.system.tangent_basis, schedule.system.weights
    return exponents_of(schedule, lambda: TangentVectors(basis(count, seed), weights), count, shown=shown)
