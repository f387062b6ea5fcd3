"""Renormalisation schedule: the points of a run, and how often small differences are renormalised between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.exponents.exponents import check_enough
from flexmb.dynamics.sections.stroboscopic import StroboscopicMap
from flexmb.dynamics.systems.continuous_flow import ContinuousFlow
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.errors import InputError
from flexmb.model.mechanism import Mechanism

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
