"""Families of systems over a parameter, and the section points of one member."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.exponents.exponents import Exponents
from flexmb.dynamics.exponents.lyapunov import lyapunov
from flexmb.dynamics.sections.section_signals import SectionSignals
from flexmb.dynamics.systems.continuous_flow import ContinuousFlow
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.errors import AssemblyError, InputError, SolveError
from flexmb.jobs.attempt import Outcome, stopped_runs
from flexmb.model.mechanism import Mechanism
from flexmb.program.period import common_period
from flexmb.run.simulate import Step
from flexmb.step.newmark.method import Newmark

Make = Callable[..., Mechanism | Dynamics] | Mechanism | Dynamics


@dataclass(frozen=True)
class Family:
    """Systems over the values of a parameter; a family can be sent to other processes.

    Parameters
    ----------
    make : a function that returns a mechanism or a system; a mechanism; or a system.
    parameter : keyword of the function, "part.field" of the mechanism, or parameter of the system.
    fixed : fixed values of other parameters.
    step, method : for mechanisms only, see `MechanismFlow`.
    period : time between two section points [s], or a function period(value); None: the period of the drives.
    """

    make: Make
    parameter: str
    fixed: Mapping[str, Any]
    step: Step | None = None
    method: Newmark | None = None
    period: float | Callable[[float], float] | None = None

    @property
    def label(self) -> str:
        """Name of the calling function and parameter, for messages."""
        return f"bifurcation over {self.parameter!r}"

    def at(self, value: float) -> Dynamics:
        """System for a `value` of the parameter, in its own start state."""
        parameters = {**self.fixed, self.parameter: value}
        if isinstance(self.make, Dynamics):
            system = self.make.copy()
            system.reset(parameters=parameters)
            return self._as_it_is(system)
        built = self.make.with_(parameters) if isinstance(self.make, Mechanism) else self.make(**parameters)
        if isinstance(built, Dynamics):
            return self._as_it_is(built)
        if not isinstance(built, Mechanism):
            text = f"{self.label}: the function returned {type(built).__name__}"
            raise InputError(f"{text}; it must return a Mechanism or a system such as Map.")
        return MechanismFlow(built, step=self.step, method=self.method, period=self._declared(value))

    def _as_it_is(self, system: Dynamics) -> Dynamics:
        """A system, after refusal of arguments that would have no influence on it."""
        idle = [name for name, value in (("step", self.step), ("method", self.method)) if value is not None]
        idle += ["period"] if self.period is not None and system.unit != "s" else []
        if idle:
            text = f"{self.label}: {idle[0]}= has no influence on {system.name!r}, which counts {system.unit}"
            raise InputError(f"{text} and has steps of its own. Leave it out, or give it where the system is built.")
        return system

    def period_of(self, flow: Dynamics, value: float) -> float:
        """Time between two section points [unit of the system]; 1 for maps."""
        if flow.unit != "s":
            return 1.0
        declared = self._declared(value)
        if declared is not None:
            return declared
        if isinstance(flow, MechanismFlow) and flow.period is None:
            common_period(flow.program)  # its message names the drives without a common period
        if not isinstance(flow, ContinuousFlow) or flow.period is None:
            text = f"{self.label}: {flow.name!r} has no period"
            raise InputError(f"{text}. Give period= [s], a number or a function of the value.")
        return float(flow.period)

    def _declared(self, value: float) -> float | None:
        period = self.period(value) if callable(self.period) else self.period
        return None if period is None else checks.positive(self.label, "period", period, "s")


@dataclass(frozen=True)
class SectionSettings:
    """Section points and exponent to be computed for each value.

    Parameters
    ----------
    skip : number of periods before the first point.
    keep : number of points.
    signals : names of the signals to keep.
    exponent : number of periods for the largest exponent; 0: no exponent.
    together : whether the exponent belongs to the periods of the points; False: to the periods after the last point.
    """

    skip: int
    keep: int
    signals: tuple[str, ...]
    exponent: int = 0
    together: bool = False

    @property
    def last(self) -> int:
        """Number of the period that ends with the last point."""
        return self.skip + self.keep - 1


def section_point(family: Family, section: SectionSettings, value: float, carried: np.ndarray | None) -> Outcome:
    """Section points, verdict and exponent for one value of the parameter.

    The motion starts at the state `carried` from a neighbouring value; None: start state of the system.

    The outcome has `points` (keep, signals); `seam`: whether a carried state could not be used; `state` after the last
    point; `drive_period`, `verdict`, `exponent`, `exponent_error`.  The outcome of a failure has no points.
    """
    flow = family.at(value)
    if stopped := stopped_runs():  # of the function that makes the system
        return Outcome({}, stopped, ok=False)
    period = family.period_of(flow, value)
    columns = columns_of(flow, section.signals, family.label)
    seam = carried is not None and not _start_from(flow, carried, section.last * period)
    exponents = _points_with_exponent(flow, period, section) if section.together else None
    points = _points(flow, period, section) if exponents is None else exponents.points
    if exponents is not None and not exponents.ok:
        points = None
    lost = _not_finite(flow, points, columns)
    values: dict[str, Any] = {"seam": seam, "drive_period": period if flow.unit == "s" else np.nan}
    if points is None or lost:
        return Outcome(values, lost or flow.status, ok=False)
    values |= {"points": points[:, columns], "state": flow.state()}
    if exponents is None:
        verdict, remark = _verdict_of_points(flow, points, period, section)
    else:
        verdict, remark = _verdict_of_exponents(exponents), ""
    return Outcome(values | verdict, f"{section.keep} points, after {section.skip} that were skipped.{remark}")


def columns_of(flow: Dynamics, signals: tuple[str, ...], label: str) -> list[int]:
    """Numbers of the chosen signals among the signals of a system."""
    names = list(flow.names)
    return [names.index(checks.one_of(label, "signal", name, names)) for name in signals]


def _start_from(flow: Dynamics, carried: np.ndarray, time: float) -> bool:
    """Reset the system to a carried state (n,); False after a failure, with a reset to the start state."""
    if carried.shape == (flow.size,):
        try:
            flow.reset(carried, time=time)
        except (AssemblyError, SolveError, InputError):
            flow.reset()
        else:
            return True
    return False


def _points(flow: Dynamics, period: float, section: SectionSettings) -> np.ndarray | None:
    """All signals (keep, n) at the ends of periods; None after a failure."""
    points, origin = np.empty((section.keep, len(flow.names))), flow.time
    for k in range(section.last + 1):
        if k > 0 and not flow.advance(1.0 if flow.unit != "s" else origin + k * period - flow.time):
            return None
        if k >= section.skip:
            points[k - section.skip] = flow.observe()
    return points


def _points_with_exponent(flow: Dynamics, period: float, section: SectionSettings) -> Exponents:
    """Section points and exponent of one run; tangent vectors do not change the motion."""
    declared = period if flow.unit == "s" else None
    return lyapunov(flow, skip=section.skip - 1, periods=section.keep, period=declared, confirm=False)


def _verdict_of_exponents(exponents: Exponents) -> dict[str, Any]:
    """Verdict and exponent of a run with tangent vectors, as results of a point."""
    return {"verdict": str(exponents.verdict), "exponent": exponents.value, "exponent_error": exponents.error}


def _not_finite(flow: Dynamics, points: np.ndarray | None, columns: list[int]) -> str:
    """Signals that are not finite, in a sentence; "" if all are finite."""
    if points is None:
        return ""
    bad = [flow.names[k] for k in columns if not np.isfinite(points[:, k]).all()]
    bad = bad or ([] if np.isfinite(flow.state()).all() else ["the state"])
    return f"Not finite: {', '.join(bad[:5])}." if bad else ""


def _verdict_of_points(
    flow: Dynamics, points: np.ndarray, period: float, section: SectionSettings
) -> tuple[dict[str, Any], str]:
    """Verdict on the points and the optional exponent of a further run; remark on a failure of this run, or ""."""
    if not section.exponent:
        return {"verdict": str(SectionSignals.of(flow).verdict(points))}, ""
    exponents = lyapunov(flow, periods=section.exponent, period=period if flow.unit == "s" else None, confirm=False)
    if not exponents.ok:
        return {"verdict": str(SectionSignals.of(flow).verdict(points))}, f" No exponent: {exponents.status}"
    value, error = (x if np.isfinite(x) else None for x in (exponents.value, exponents.error))
    verdict = SectionSignals.of(flow).verdict(np.concatenate([points, exponents.points]), (), value, error)
    return {"verdict": str(verdict), "exponent": exponents.value, "exponent_error": exponents.error}, ""
