"""Lyapunov exponents from tangent vectors, or from two trajectories; a second run beside them.

`exponents_of` holds the loop over the points, `growth_to_next_point` the loop between two points.  Both serve tangent
vectors (`TangentVectors`) and pairs of trajectories (`TrajectoryPair`).
Equation (9.4) of docs/theory/exponents.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from flexmb import arguments, checks
from flexmb.dynamics.exponents import SETTLING, Confirmed, Exponents, check_enough, combined, error_of, with_verdict
from flexmb.dynamics.jobs.executors import tell_stopped
from flexmb.dynamics.jobs.progress import ProgressBar
from flexmb.dynamics.sections import SectionSignals, strobe_of
from flexmb.dynamics.systems.dynamics import Dynamics, as_dynamics, orthonormalise
from flexmb.errors import AssemblyError, InputError, SolveError

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

Perturbation: TypeAlias = "TangentVectors | TrajectoryPair"  # small differences of states whose growth is measured


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
    # fraction of the renormalisations with too much growth at which they become more frequent: a single impact is
    # divided at its instant, and not the whole period
    strained_fraction = 0.25

    def __init__(self, W: np.ndarray, weights: np.ndarray) -> None:
        self.W, self.weights = W, weights

    def is_strained(self, logs: np.ndarray) -> bool:
        """Whether the lengths of the vectors differ by more than `TOO_MUCH` (`logs`: logarithms of their growth)."""
        return bool(logs.max(initial=0.0) - logs.min(initial=0.0) > np.log(TOO_MUCH))

    def growth(self, schedule: Schedule, number: int, begin: float, end: float) -> np.ndarray | None:
        """Logarithms (k,) of the growth between two fractions of the interval before a point; None: it failed."""
        # An interval with far too much growth is divided into halves. `schedule.trouble` is the reason of a failure,
        # unless the system failed.
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


# A second, shorter run with finer steps from another start, and the errors of exponents that it adds

PART = 5  # points of the first run per point of the second run, for counted and for skipped points
# Points of the first run per skipped point of the second run, at most; finer steps may change the attractor.
SETTLES = 10
LEAST = 20  # smallest number of points of the second run
# Distances of the second run's start, over the length of the state; the second one is tried if the first one fails.
SECOND_RUN_APART = (1e-3, 1e-9)


def confirmed(first: Exponents, schedule: Schedule, seed: int, *, shown: bool) -> Exponents:
    """Exponents of a first run, completed by a second run; the errors cover the difference of both runs."""
    # The second run uses a copy of the system. Its start is near the final state of the first run, after the transient.
    # If a contact was closed during the whole first run, the second run starts at the start state of the system and
    # skips the whole transient. Otherwise both runs would have the approach speed of the same onset.
    reason, skip, settles = "", schedule.skip, schedule.count // SETTLES
    lasting = bool(schedule.system.remarks(float(first.time[0])))
    for distance in (0.0,) if lasting else SECOND_RUN_APART:
        system = schedule.system.finer()
        if lasting:
            system.reset(time=schedule.origin)
        else:
            try:
                system.reset(system.another_start(distance, seed), time=schedule.system.time)
            except (InputError, AssemblyError, SolveError):
                continue
        skipped, count = max(skip if lasting else -(-skip // PART), settles), max(schedule.count // PART, LEAST)
        other = replace(schedule, system=system, skip=skipped, count=count, trouble="")
        run = tangent_exponents(other, len(first.spectrum), seed, shown=shown)
        if run.ok and not np.isnan(run.spectrum).any():
            second = Confirmed(run.spectrum, run.errors, other.count, other.system.fineness)
            errors = combined(first.spectrum, first.statistical, second.spectrum, second.errors)
            return replace(first, errors=errors, confirmed=second)
        reason = run.status
    reason = reason or "no state beside the end of the first run can be started from."
    return replace(first, unconfirmed=reason, status=f"{first.status} The second run failed: {reason}")


@arguments.checked
def lyapunov(
    system: Any, *, skip: float = 0, periods: int | None = None, duration: float | None = None, count: int = 1,
    interval: float | None = None, period: float | None = None, step: Step | None = None,
    method: Newmark | None = None, seed: int = 0, confirm: bool = True, progress: bool = False,
) -> Exponents:  # fmt: skip
    """Lyapunov exponents of a system, from tangent vectors that are advanced with the motion.

    The vectors are made orthonormal once a period, and more often if they grow by more than 1e4.  The exponents are the
    means of the logarithms of their lengths (G. Benettin et al., Meccanica 15 (1980) 9).  The first tenth of the run is
    not counted: the vectors turn to their directions.

    Parameters
    ----------
    system : a mechanism, which starts from its reference configuration; or a flow or map, which continues from its
        present state.
    skip : number of periods (iterations, crossings) before the run, for the transient; with `duration` seconds.
    periods : number of periods of a driven system, of iterations of a map, or of crossings of a section.
    duration : duration [s], for a flow without a period, in place of `periods`.  One of its exponents is 0.
    count : number of exponents, the largest first.
    interval : with `duration`, time between two points of the history [s]; None: a thousandth of the duration.
    period : the period [s]; None: the common period of the drives.
    step, method : for a mechanism only, see `simulate`.
    seed : seed of the random directions in which the vectors start.
    confirm : whether a second run confirms the first one.  It has a fifth of the periods (20 at least), a tenth of the
        tolerance or half of a fixed step, and another start: beside the final state of the first run or, if a contact
        never opened, the mechanism's own start and the whole of `skip`.  Its difference goes into the errors, and the
        verdict is "chaotic" only if both runs agree.  False: errors and verdict of one run.
    progress : whether a progress bar with the remaining time is shown.

    Returns
    -------
    Exponents : in 1/s for flows and their sections, in 1/iteration for maps; with errors, convergence history, section
        points and verdict.  After a failure midway ok is False, and the record holds the results before the failure.

    Raises
    ------
    InputError : too few periods or intervals; neither or both of periods and duration; a duration of a map; more
        exponents than the system has directions.
    ModelError, AssemblyError, KernelError : a mechanism that cannot start.

    Notes
    -----
    The exponent belongs to the numerical motion.  The method damps vibrations that the steps do not resolve, so a
    negative exponent may be numerical dissipation, as in slow mechanisms with clearance: repeat the run with shorter
    steps, `step=Adaptive(max=...)`, or without dissipation, `method=Newmark.trapezoidal()`.  Hard impacts need a finer
    tolerance than the motion itself; the second run shows whether, and `step=Adaptive(rtol=...)` sets it.

    The system stays at the end of the first run.

    Examples
    --------
    >>> import flexmb as fm
    >>> import numpy as np
    >>> tent = fm.chaos.Map(lambda x, a: a * np.minimum(x, 1.0 - x), [0.3], parameters={"a": 1.5})
    >>> found = fm.lyapunov(tent, skip=100, periods=1000)
    >>> round(found.value, 9)  # ln 1.5
    0.405465108
    """
    span = Span("lyapunov", skip, periods, duration, interval, period)
    schedule = span.schedule(system, step, method)
    label = f"lyapunov {schedule.system.name!r}"
    seed, count = checks.count(label, "seed", seed, 0), checks.count(label, "count", count)
    exponents = tangent_exponents(schedule, count, seed, shown=progress)
    if confirm and exponents.ok:
        exponents = confirmed(exponents, schedule, seed + 1, shown=progress)
    return span.finished(exponents, schedule)


def benettin(
    system: Any, *, skip: float = 0, periods: int | None = None, duration: float | None = None,
    distance: float | None = None, interval: float | None = None, period: float | None = None,
    step: Step | None = None, method: Newmark | None = None, seed: int = 0, progress: bool = False,
) -> Exponents:  # fmt: skip
    """The largest Lyapunov exponent from two neighbouring trajectories; no tangent of the system is needed.

    Once a period the distance of the second trajectory from the first one is restored, along the line between them
    (G. Benettin, L. Galgani, J.-M. Strelcyn, Phys. Rev. A 14 (1976) 2338).  A mechanism is then projected onto its
    constraints, and both trajectories restart so that they take equal steps.

    Parameters
    ----------
    system : a mechanism, which starts from its reference configuration; or a flow or map, which continues from its
        present state.
    skip, periods, duration, interval, period, step, method, seed, progress : see `lyapunov`.
    distance : distance of the trajectories in the weights of the system (for a mechanism [m]); None: 1e-6 of the length
        of the state, 1e-9 for a mechanism with contacts.

    Raises
    ------
    InputError : see `lyapunov`; a distance that is not > 0.
    ModelError, AssemblyError, KernelError : a mechanism that cannot start.

    Notes
    -----
    The distance must be far above the errors of the steps in one period, and small enough for linear growth.  The range
    between is narrow for error-controlled steps of a mechanism, so `FixedStep` is the better choice.  In contact the
    distance must be far below the penetration: with 2.6e-7 m the worn slider-crank at 5000 rpm gives 356 1/s, with
    1e-9 m and 1e-11 m 464 1/s, as `lyapunov` does (467 +/- 20).

    Examples
    --------
    >>> import flexmb as fm
    >>> import numpy as np
    >>> tent = fm.chaos.Map(lambda x, a: a * np.minimum(x, 1.0 - x), [0.3], parameters={"a": 1.5})
    >>> found = fm.chaos.benettin(tent, skip=100, periods=1000)
    >>> round(found.value, 3)  # ln 1.5
    0.405
    """
    span = Span("benettin", skip, periods, duration, interval, period)
    schedule = span.schedule(system, step, method)
    first = schedule.system
    seed = checks.count(f"benettin {first.name!r}", "seed", seed, 0)
    direction = partial(first.tangent_basis, 1, seed)
    exponents = exponents_of(schedule, lambda: TrajectoryPair(first, distance, direction()[:, 0]), 1, shown=progress)
    return span.finished(exponents, schedule)


class TrajectoryPair:
    """Two trajectories at a small distance, at first along a direction (size,); see `benettin`."""

    strained_fraction = 0.0

    def __init__(self, first: Dynamics, distance: float | None, direction: np.ndarray) -> None:
        self.first, self.second, self.weights, self.size = first, first.copy(), first.weights, 0.0
        usual, given = first.small * (self.length(first.state()) or 1.0), distance is not None
        self.distance = checks.positive(f"benettin {first.name!r}", "distance", distance) if given else usual
        self.renormalise(direction)

    def length(self, difference: np.ndarray) -> float:
        """Length of a `difference` (size,) in the weights."""
        return float(np.sqrt(self.weights @ difference**2))

    def renormalise(self, direction: np.ndarray) -> None:
        """Restart both systems, the second at `distance` in a `direction` (size,) of any length."""
        x, time = self.first.state(), self.first.time
        if self.first.underlying is self.first:
            self.first.reset(x, time=time)
        self.second.reset(x + self.distance / self.length(direction) * direction, time=time)
        self.size = self.length(self.second.state() - self.first.state())

    def is_strained(self, logs: np.ndarray) -> bool:
        """Whether the distance grew by more than `TOO_MUCH` (`logs`: logarithm (1,) of the growth)."""
        return bool(logs[0] > np.log(TOO_MUCH))

    def growth(self, schedule: Schedule, number: int, begin: float, end: float) -> np.ndarray | None:  # noqa: ARG002
        """Logarithm (1,) of the growth of the distance; None if a system fails or the trajectories meet."""
        reached = [schedule.advance(system, number, end) for system in (self.first, self.second)]
        if not all(reached):
            schedule.trouble = (self.first if not reached[0] else self.second).status
            return None
        difference = self.second.state() - self.first.state()
        difference[schedule.records] = 0.0  # bookkeeping would grow without bound if the distance shrinks
        length = self.length(difference)
        if length == 0.0 or self.size == 0.0:
            schedule.trouble = f"The two trajectories met at {self.first.clock:.6g}; give a larger distance."
            return None
        growth = length / self.size
        self.renormalise(difference)
        return np.array([np.log(growth)])
