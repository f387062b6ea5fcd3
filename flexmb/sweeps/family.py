"""A family of systems: what there is at each value of a parameter, and its section once a period."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.exponents.exponents import Exponents
from flexmb.dynamics.exponents.lyapunov import lyapunov
from flexmb.dynamics.sections.seen import Seen
from flexmb.dynamics.systems.continuous_flow import ContinuousFlow
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.errors import AssemblyError, InputError, SolveError
from flexmb.jobs.attempt import Outcome
from flexmb.model.mechanism import Mechanism
from flexmb.program.period import common_period
from flexmb.run.simulate import Step
from flexmb.step.newmark.method import Newmark

Make = Callable[..., Mechanism | Dynamics] | Mechanism | Dynamics
STOPPED = "Interrupted from the keyboard"
"""How the status of a run begins that was stopped by Ctrl-C: no result of its point."""


@dataclass(frozen=True)
class Family:
    """What gives the system at each value; it can be sent to other processes.

    Parameters
    ----------
    make : a function that returns a mechanism or a system, a mechanism, or a system.
    parameter : the keyword of the function, "part.field" of the mechanism, or the parameter of the system.
    fixed : other ones that stay.
    step, method : of mechanisms, see `MechanismFlow`.
    period : between two points of the section [s], or period(value) that says so; None: that of the drives.
    """

    make: Make
    parameter: str
    fixed: Mapping[str, Any]
    step: Step | None = None
    method: Newmark | None = None
    period: float | Callable[[float], float] | None = None

    @property
    def label(self) -> str:
        """The function that asks, and the parameter, for messages."""
        return f"bifurcation over {self.parameter!r}"

    def at(self, value: float) -> Dynamics:
        """The system at a value of the parameter, at its own start."""
        chosen = {**self.fixed, self.parameter: value}
        if isinstance(self.make, Dynamics):
            other = self.make.copy()
            other.reset(parameters=chosen)
            return self._as_it_is(other)
        made = self.make.with_(chosen) if isinstance(self.make, Mechanism) else self.make(**chosen)
        if isinstance(made, Dynamics):
            return self._as_it_is(made)
        if not isinstance(made, Mechanism):
            text = f"{self.label}: the function returned {type(made).__name__}"
            raise InputError(f"{text}; it must return a Mechanism or a system such as Map.")
        return MechanismFlow(made, step=self.step, method=self.method, period=self._declared(value))

    def _as_it_is(self, system: Dynamics) -> Dynamics:
        """A system, if nothing is given that would have no influence on it."""
        idle = [name for name, value in (("step", self.step), ("method", self.method)) if value is not None]
        idle += ["period"] if self.period is not None and system.unit != "s" else []
        if idle:
            text = f"{self.label}: {idle[0]}= has no influence on {system.name!r}, which counts {system.unit}"
            raise InputError(f"{text} and goes its own steps. Leave it out, or give it where the system is made.")
        return system

    def period_of(self, flow: Dynamics, value: float) -> float:
        """Time between two points of the section [unit of the system]: 1 for maps."""
        if flow.unit != "s":
            return 1.0
        declared = self._declared(value)
        if declared is not None:
            return declared
        if isinstance(flow, MechanismFlow) and flow.period is None:
            common_period(flow.program)  # says which drives do not fit together
        if not isinstance(flow, ContinuousFlow) or flow.period is None:
            text = f"{self.label}: {flow.name!r} has no period"
            raise InputError(f"{text}. Give period= [s], a number or a function of the value.")
        return float(flow.period)

    def _declared(self, value: float) -> float | None:
        found = self.period(value) if callable(self.period) else self.period
        return None if found is None else checks.positive(self.label, "period", found, "s")


@dataclass(frozen=True)
class Section:
    """Which points are taken.

    Parameters
    ----------
    skip : periods that pass before the first point.
    keep : number of points.
    signals : names of the signals that are kept.
    exponent : periods over which the largest exponent is found; 0: it is not.
    together : whether these are the periods between the points, not as many after them.
    """

    skip: int
    keep: int
    signals: tuple[str, ...]
    exponent: int = 0
    together: bool = False

    @property
    def last(self) -> int:
        """Number of the period at whose end the last point is taken."""
        return self.skip + self.keep - 1


def section_point(family: Family, section: Section, value: float, carried: np.ndarray | None) -> Outcome:
    """One point of a diagram: what is kept of it, by the names of the columns.

    Parameters
    ----------
    family : the systems.
    section : what is wanted.
    value : of the parameter.
    carried : state at a neighbouring value from which to go on; None: from the system's own start.

    Returns
    -------
    Outcome : `points` (keep, signals), `seam`: whether a carried state could not be used, `state` after the last
        point, `drive_period`, `verdict`, `exponent`, `exponent_error`; without points when the system was lost.
    """
    flow = family.at(value)
    period = family.period_of(flow, value)
    chosen = columns_of(flow, section.signals, family.label)
    seam = carried is not None and not _goes_on(flow, carried, section.last * period)
    exponents = _both(flow, period, section) if section.together else None
    found = _points(flow, period, section) if exponents is None else exponents.points
    if exponents is not None and not exponents.ok:
        found = None
    lost = _not_finite(flow, found, chosen)
    values: dict[str, Any] = {"seam": seam, "drive_period": period if flow.unit == "s" else np.nan}
    if found is None and flow.status.startswith(STOPPED):
        raise KeyboardInterrupt
    if found is None or lost:
        return Outcome(values, lost or flow.status, ok=False)
    values |= {"points": found[:, chosen], "state": flow.state()}
    judged, remark = _judged(flow, found, period, section) if exponents is None else (_told(exponents), "")
    return Outcome(values | judged, f"{section.keep} points, after {section.skip} that were skipped.{remark}")


def columns_of(flow: Dynamics, signals: tuple[str, ...], label: str) -> list[int]:
    """Where the chosen signals stand among those of the system.

    Raises
    ------
    InputError : an unknown one.
    """
    names = list(flow.names)
    return [names.index(checks.one_of(label, "signal", name, names)) for name in signals]


def _goes_on(flow: Dynamics, carried: np.ndarray, time: float) -> bool:
    """Put the system into a state of its neighbour; False where that cannot be, and it stands at its own start."""
    if carried.shape == (flow.size,):
        try:
            flow.reset(carried, time=time)
        except (AssemblyError, SolveError, InputError):
            flow.reset()
        else:
            return True
    return False


def _points(flow: Dynamics, period: float, section: Section) -> np.ndarray | None:
    """All signals (keep, n) at the ends of periods; None when the system could not be advanced."""
    found, origin = np.empty((section.keep, len(flow.names))), flow.time
    for k in range(section.last + 1):
        if k > 0 and not flow.advance(1.0 if flow.unit != "s" else origin + k * period - flow.time):
            return None
        if k >= section.skip:
            found[k - section.skip] = flow.observe()
    return found


def _both(flow: Dynamics, period: float, section: Section) -> Exponents:
    """The points and the exponent in one pass: the motion is the same with tangents as without."""
    declared = period if flow.unit == "s" else None
    return lyapunov(flow, skip=section.skip - 1, periods=section.keep, period=declared, confirm=False)


def _told(found: Exponents) -> dict[str, Any]:
    """The verdict of exponents and points in one."""
    return {"verdict": str(found.verdict), "exponent": found.value, "exponent_error": found.error}


def _not_finite(flow: Dynamics, points: np.ndarray | None, chosen: list[int]) -> str:
    """What is no number, in a sentence, or ""."""
    if points is None:
        return ""
    bad = [flow.names[k] for k in chosen if not np.isfinite(points[:, k]).all()]
    bad = bad or ([] if np.isfinite(flow.state()).all() else ["the state"])
    return f"Not finite: {', '.join(bad[:5])}." if bad else ""


def _judged(flow: Dynamics, points: np.ndarray, period: float, section: Section) -> tuple[dict[str, Any], str]:
    """What kind of motion the points show, and the exponent where it is asked for; a remark where that has failed."""
    if not section.exponent:
        return {"verdict": str(Seen.of(flow).judged(points))}, ""
    found = lyapunov(flow, periods=section.exponent, period=period if flow.unit == "s" else None, confirm=False)
    if not found.ok:
        return {"verdict": str(Seen.of(flow).judged(points))}, f" No exponent: {found.status}"
    known = {k: v for k, v in (("exponent", found.value), ("error", found.error)) if np.isfinite(v)}
    verdict = Seen.of(flow).judged(np.concatenate([points, found.points]), **known)
    return {"verdict": str(verdict), "exponent": found.value, "exponent_error": found.error}, ""
