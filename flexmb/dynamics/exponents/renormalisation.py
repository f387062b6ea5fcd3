"""Growth of small differences: schedule, advance, logarithms, renormalisation.

`exponents_of` holds the loop over the points, `growth_to_next_point` the loop between two points.  Both serve tangent
vectors (`TangentVectors`) and pairs of trajectories (`benettin.TrajectoryPair`).
Equation (9.4) of docs/theory/exponents.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from flexmb import checks
from flexmb.dynamics.exponents.exponents import SETTLING, Exponents, Growth, check_enough
from flexmb.dynamics.jobs.progress import ProgressBar
from flexmb.dynamics.sections.maps import SectionMap, StroboscopicMap
from flexmb.dynamics.sections.points import SectionSignals
from flexmb.dynamics.systems.dynamics import ContinuousFlow, Dynamics, orthonormalise
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow, clock
from flexmb.engine.step.contact_log import running_episodes
from flexmb.errors import InputError
from flexmb.model.mechanism import Mechanism
from flexmb.results.contact_intervals import COLUMN

# Renormalisation schedule: the points of a run, and how often small differences are renormalised between them

MOST_LOOKS = 4096
"""Largest number of renormalisations between two points."""
INTERVALS = 1000
"""Number of intervals into which a duration is divided, if no interval is given."""


@dataclass
class RenormalisationSchedule:
    """Points at which the growth of small differences is recorded, and renormalisations between two points.

    Parameters
    ----------
    interval : time between two points [s]; of a map 1 iteration.
    skip : number of points before the small differences start.
    count : number of points after the skipped ones.
    is_flow : whether the time between two points can be divided.
    is_section : whether the points are points of a section or of a map.
    renormalisations : number of renormalisations between two points.
    trouble : reason why the run ended early, if the system itself did not fail; else "".
    """

    system: Dynamics
    interval: float
    skip: int
    count: int
    is_flow: bool
    is_section: bool
    renormalisations: int = 1
    trouble: str = ""

    def __post_init__(self) -> None:
        self.origin, self.records = self.system.time, self.system.records

    def advance(self, system: Dynamics, number: int, fraction: float = 1.0, tangents: np.ndarray | None = None) -> bool:
        """Advance a system that stands between two points to a fraction of the interval before point `number` (>= 1).

        The system is that of the schedule or a copy; tangent vectors (size, k) are advanced in place.  Returns whether
        the end was reached.
        """
        if not self.is_flow:
            return system.advance(1, tangents)
        return system.advance(self.origin + (number - 1 + fraction) * self.interval - system.time, tangents)

    def renormalise_more_often(self) -> None:
        """Double the number of renormalisations between two points, up to `MOST_LOOKS`."""
        self.renormalisations = min(2 * self.renormalisations, MOST_LOOKS)


def schedule_of(
    caller: str,
    system: Dynamics,
    skip: float,
    periods: int | None,
    duration: float | None,
    interval: float | None,
    period: float | None,
) -> RenormalisationSchedule:
    """Schedule by the arguments of `lyapunov` or `benettin`, which are checked."""
    label = f"{caller} {system.name!r}"
    if (periods is None) == (duration is None):
        text = f"{label}: periods is {periods!r} and duration is {duration!r}"
        raise InputError(
            f"{text}; give either periods= (iterations of a map, crossings of a section) or duration= [s]."
        )
    if duration is not None:
        if not isinstance(system, ContinuousFlow):
            raise InputError(f"{label}: duration= belongs to a flow; this is a map. Give periods=.")
        end = checks.positive(label, "duration", duration, "s")
        unit = end / INTERVALS if interval is None else checks.positive(label, "interval", interval, "s")
        points = round(end / unit)
        check_enough(label, points, "intervals")
        skipped = int(np.ceil(checks.not_negative(label, "skip", skip, "s") / unit - 1e-9))
        return RenormalisationSchedule(system, unit, skipped, points, is_flow=True, is_section=False)
    number, skipped = checks.count(label, "periods", periods), checks.count(label, "skip", skip, 0)
    is_flow = isinstance(system, (ContinuousFlow, StroboscopicMap))
    check_enough(label, number, system.unit if not is_flow else "periods")
    if not isinstance(system, (ContinuousFlow, StroboscopicMap)):
        return RenormalisationSchedule(system, 1.0, skipped, number, is_flow=False, is_section=True)
    strobe = system if isinstance(system, StroboscopicMap) else StroboscopicMap(system, period)
    return RenormalisationSchedule(strobe.flow, strobe.period, skipped, number, is_flow=True, is_section=True)


def refuse_idle_arguments(
    caller: str, given: Any, system: Dynamics, duration: float | None, interval: float | None, period: float | None
) -> None:
    """Refuse arguments that would have no influence.

    These are an interval without a duration, a period of a map, and a period with a duration.  `given` is the argument
    of which the system was made.
    """
    label = f"{caller} {system.name!r}"
    if interval is not None and duration is None:
        raise InputError(f"{label}: interval= goes with duration=; with periods= the interval is the period.")
    if period is None or isinstance(given, Mechanism):
        return
    if not isinstance(system, ContinuousFlow):
        raise InputError(f"{label}: period= belongs to a flow; this is a map. Leave it out.")
    if duration is not None:
        raise InputError(
            f"{label}: period= goes with periods=; with duration= give interval=, the time between points."
        )


# Growth of small differences: advance, measure the growth, take the logarithm, renormalise; then the exponents

TOO_MUCH = 1e4
"""Growth factor, or ratio of growth factors, between two renormalisations, above which they become more frequent."""
FAR_TOO_MUCH = 1e6
"""Ratio of growth factors above which the vectors are advanced again, in halves: the shortest is lost in round-off."""
LOST = 1e-13
"""Length of a vector without its components along the others, over its own length, below which it is round-off."""


class Perturbation(Protocol):
    """Small differences of states whose growth is measured."""

    strained_fraction: float
    """Fraction of the renormalisations with too much growth at which they become more frequent."""

    def growth(self, schedule: RenormalisationSchedule, number: int, begin: float, end: float) -> np.ndarray | None:
        """Logarithms (k,) of the growth between two fractions of an interval; renormalises the differences.

        `number` is that of the point at the end of the interval.  With a result None, `schedule.trouble` is set to the
        reason, unless the system failed.
        """

    def is_strained(self, logs: np.ndarray) -> bool:
        """Whether logarithms (k,) of the growth between two renormalisations `logs` are too large."""


def exponents_of(
    schedule: RenormalisationSchedule, start: Callable[[], Perturbation], count: int, *, shown: bool
) -> Exponents:
    """Lyapunov exponents of one run, without a verdict; `start` makes the differences after the skipped points."""
    system, growth, points = schedule.system, Growth(), [np.zeros((0, len(schedule.system.names)))]
    progress = ProgressBar(system.name, float(schedule.skip + schedule.count), shown=shown, of="periods")
    perturbation, begin = None, clock(system)
    last_of_transient = schedule.skip + schedule.count // SETTLING
    for number in range(1, schedule.skip + schedule.count + 1):
        if number == schedule.skip + 1:
            perturbation = start()
        before = clock(system)
        if number == last_of_transient + 1:
            begin = before
        logs = growth_to_next_point(schedule, perturbation, number)
        if logs is None:
            break
        progress.update(1)
        if number > schedule.skip:
            points.append(system.observe()[None])
        if number > last_of_transient:
            growth.logs.append(logs)
            growth.times.append(clock(system) - before)
    progress.close()
    return _recorded(schedule, growth, begin, count, np.concatenate(points))


def growth_to_next_point(
    schedule: RenormalisationSchedule, perturbation: Perturbation | None, number: int
) -> np.ndarray | None:
    """Logarithms (k,) of the growth of small differences up to the next point; None: the point was not reached.

    The schedule's number of renormalisations between two points may increase.  Without a perturbation the system is
    advanced alone.
    """
    if perturbation is None:
        return np.zeros(0) if schedule.advance(schedule.system, number) else None
    total, strained, times = np.zeros(0), 0, schedule.renormalisations
    for k in range(1, times + 1):
        logs = perturbation.growth(schedule, number, (k - 1) / times, k / times)
        if logs is None:
            return None
        total = total + logs if len(total) else logs
        strained += perturbation.is_strained(logs)
    if schedule.is_flow and strained and strained >= perturbation.strained_fraction * times:
        schedule.renormalise_more_often()
    return total


class TangentVectors:
    """Tangent vectors, made orthonormal at each renormalisation (G. Benettin et al., Meccanica 15 (1980) 9).

    Parameters
    ----------
    W : vectors (size, k), orthonormal in the weights.
    weights : weights (size,) of the system.
    """

    strained_fraction = 0.25  # a single impact is divided at its instant, and not the whole period

    def __init__(self, W: np.ndarray, weights: np.ndarray) -> None:
        self.W, self.weights = W, weights

    def is_strained(self, logs: np.ndarray) -> bool:
        """Whether the lengths of the vectors differ by more than `TOO_MUCH` (`logs`: logarithms of their growth)."""
        return bool(logs.max(initial=0.0) - logs.min(initial=0.0) > np.log(TOO_MUCH))

    def growth(self, schedule: RenormalisationSchedule, number: int, begin: float, end: float) -> np.ndarray | None:
        """See `Perturbation.growth`; an interval with far too much growth is divided into halves."""
        system, W, weights = schedule.system, self.W, self.weights
        saved = (system.snapshot(), W.copy()) if isinstance(system, ContinuousFlow) and schedule.is_flow else None
        reached = schedule.advance(system, number, end, W)
        whole = lengths_of(W, weights)
        lengths = orthonormalise(W, weights) if reached else np.full(W.shape[1], np.nan)
        W[schedule.records] = 0.0  # bookkeeping would grow without bound if the rest of a vector shrinks
        finite = bool(np.isfinite(lengths).all() and np.isfinite(W).all())
        spread = lengths.max() / max(min(lengths.min(), 1.0), 1e-300) if finite else np.inf
        if saved is not None and spread > FAR_TOO_MUCH and end - begin > 1.0 / MOST_LOOKS:
            return self._in_halves(schedule, number, (begin, end), saved)
        if not reached:
            return None
        if not finite or (lengths < LOST * whole).any():
            fault = "are not finite" if not finite else "are parallel up to round-off"
            text = f"The tangent vectors {fault} at {clock(system):.6g}"
            schedule.trouble = f"{text}." if not finite else f"{text}. Ask for fewer exponents (count=)."
            return None
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(lengths))

    def _in_halves(
        self, schedule: RenormalisationSchedule, number: int, span: tuple[float, float], saved: tuple[Any, np.ndarray]
    ) -> np.ndarray | None:
        """Logarithms (k,) of the growth over `span`, from the state `saved` at its begin, with one more division."""
        system, (begin, end) = schedule.system, span
        if not isinstance(system, ContinuousFlow):
            return None
        if not system.ok:  # does the motion fail, or are only the vectors too long?
            system.restore(saved[0])
            if not schedule.advance(system, number, end):
                return None
        system.restore(saved[0])
        self.W[:] = saved[1]
        middle = 0.5 * (begin + end)
        first = self.growth(schedule, number, begin, middle)
        second = None if first is None else self.growth(schedule, number, middle, end)
        return None if first is None or second is None else first + second


def lengths_of(W: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Lengths (k,) of the columns of W (size, k) in the weights, without overflow of their squares."""
    weighted = weights > 0.0
    largest = np.abs(W[weighted]).max(axis=0, initial=0.0)
    scale = np.where(largest > 0.0, largest, 1.0)
    with np.errstate(invalid="ignore", over="ignore"):
        return np.asarray(largest * np.sqrt(weights[weighted] @ (W[weighted] / scale) ** 2))


def tangent_exponents(schedule: RenormalisationSchedule, count: int, seed: int, *, shown: bool) -> Exponents:
    """Lyapunov exponents of one run with `count` tangent vectors in random directions, without a verdict."""
    system, weights = schedule.system, schedule.system.weights
    return exponents_of(
        schedule, lambda: TangentVectors(system.tangent_basis(count, seed), weights), count, shown=shown
    )


def _recorded(
    schedule: RenormalisationSchedule, growth: Growth, begin: float, count: int, points: np.ndarray
) -> Exponents:
    """Exponents of a run without a verdict; `begin`: start of the measured growth [s]."""
    system, wanted = schedule.system, schedule.count - schedule.count // SETTLING
    ok = len(growth.times) == wanted
    unit = "1/s" if schedule.is_flow or system.unit == "crossings" else "1/iteration"
    status = f"Mean of {wanted} {'points' if schedule.is_flow else system.unit}."
    status = " ".join([status, *lasting_contacts(system, begin)]) if ok else schedule.trouble or system.status
    period = float(np.mean(growth.times)) if schedule.is_section and unit == "1/s" and growth.times else float("nan")
    signals = SectionSignals.of(system)
    about = {"name": system.name, "units": unit, "ok": ok, "status": status, "points": points, "signals": signals}
    return growth.record(begin, count, period=period, **about)


def lasting_contacts(system: Dynamics, since: float) -> list[str]:
    """A sentence on each contact that stayed closed since a given time [s], the start of the measured growth.

    Laws with hysteresis damping depend on the approach speed of the last onset.  The run lacks the tangent of this
    approach speed if the onset precedes the measured growth.  Contacts with other laws are not listed.  Only a
    `MechanismFlow` has contacts.
    """
    flow = system.flow if isinstance(system, (StroboscopicMap, SectionMap)) else system
    if not isinstance(flow, MechanismFlow):
        return []
    sentences, program, now = [], flow.program, flow.run.flow
    for row in running_episodes(program.tables, now):
        contact = int(row[COLUMN["contact"]])
        _, begin, end, _ = program.tables.contacts.z[contact]
        damped = program.normals[contact].damped_since_onset(now.z[begin:end].tolist())
        if damped and row[COLUMN["peak_force"]] > 0.0 and not row[COLUMN["start"]] > since:
            name = program.names.contacts[contact]
            sentences.append(f"{name} has been in contact without a break during all that was counted: {damped}.")
    return sentences
