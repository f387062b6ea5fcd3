"""Branches of periodic orbits along a parameter, with the events on them and the orbits that branch off."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from flexmb import arguments, checks
from flexmb.dynamics.orbits.orbit_newton import ArclengthPlane, Direction, NewtonResult, correct
from flexmb.dynamics.orbits.periodic_orbit import BRANCH, FLIP, PeriodicOrbit, is_real, orbit_of
from flexmb.dynamics.orbits.shooting import Shooting, ShootingRun
from flexmb.errors import InputError
from flexmb.fields import field, record_with
from flexmb.late import xr


@record_with(eq=False, kw_only=True)
class BranchPoint:
    """An orbit on a branch."""

    value: float = field("value of the parameter")
    kind: str = field('"" for an ordinary point; else the kind of the event')
    period: float = field("period of the orbit [s, or iterations]")
    state: np.ndarray = field("start state (size,)")
    signals: np.ndarray = field("signals (names,) at the start")
    multipliers: np.ndarray = field("Floquet multipliers (d,), largest first, without that of a shift in time")
    stable: bool = field("whether all multipliers lie inside the unit circle")
    residual: float = field("gap between end and start, over the size of the state")
    extremes: np.ndarray = field("smallest and largest values (names, 2) on the orbit; NaN if not requested")
    grazing: dict[str, float] = field("turning point nearest to 0 of each gap", "m")
    rising: float = field("change of the parameter along the branch over the whole change, -1 ... 1")
    shooting_run: ShootingRun = field("the motion over the period")
    impact_speeds: np.ndarray = field("closing speeds of impacts (`ImpactODE`)", default_factory=lambda: np.zeros(0))


@record_with(eq=False, kw_only=True)
class Branch(arguments.Checked):
    """Periodic orbits along a parameter."""

    formerly = (("unit", "period_units", "0.3"),)
    name: str = field("name of the system")
    parameter: str = field("name of the parameter")
    period_units: str = field("unit of the period")
    names: tuple[str, ...] = field("names of the signals")
    units: tuple[str, ...] = field("units of the signals")
    points: tuple[BranchPoint, ...] = field("orbits in the order of the branch")
    events: tuple[BranchPoint, ...] = field("orbits at which stability changes or surfaces graze, in order")
    ok: bool = field("whether the branch ended at the end of the range")
    status: str = field("end of the branch, in a sentence")
    shooting: Shooting = field("shooting that found the orbits")
    tolerance: float = field("largest residual of an orbit")
    span: tuple[float, float] = field("range of the parameter")
    gaps: dict[str, tuple[int, float]] = field("number and sign of the signals of gaps")

    def orbit(self, point: int | BranchPoint) -> PeriodicOrbit:
        """The periodic orbit at a `point`, a number of the point or an element of `points` or `events`, computed again.

        Raises
        ------
        InputError : a number beyond the branch.
        """
        if not isinstance(point, BranchPoint):
            if not -len(self.points) <= checks.count("Branch", "point", point, -len(self.points)) < len(self.points):
                raise InputError(f"Branch of {self.name!r}: point is {point}; there are {len(self.points)}.")
            point = self.points[point]
        run, shooting = point.shooting_run, self.shooting.copy(self.shooting.times, self.shooting.segments)
        result = correct(shooting, run.starts, run.period, run.value, tolerance=self.tolerance, iterations=10)
        return orbit_of(shooting, result, self.gaps)

    def switch(self, event: int | BranchPoint | None = None, *, step: float = 0.02) -> PeriodicOrbit:
        """The first orbit of the branch that begins at a flip (with twice the period) or at a branch point.

        Continue this orbit from its own parameter: `follow(orbit, parameter, (None, to))`.

        Parameters
        ----------
        event : element of `events`, or its number; None: the first flip, else the first branch point.
        step : distance from the event, over the size of the state.

        Raises
        ------
        InputError : no such event, or an event of another kind.

        Notes
        -----
        The step goes along the eigenvector of the multiplier -1 (+1 at a branch point).  Orbit and parameter are found
        on the plane
        across the step, so the other branch may begin on either side.  `ok` is False if no other orbit is found.
        """
        if event is None:
            event = next((e for kind in (FLIP, BRANCH) for e in self.events if e.kind == kind), None)
        event = self.event_of("switch", event, (FLIP, BRANCH), "a flip or a branch point of this branch")
        step = checks.positive("switch", "step", step)
        factor, run = 2 if event.kind == FLIP else 1, event.shooting_run
        shooting = self.shooting.copy(self.shooting.times * factor, self.shooting.segments * factor)
        values, vectors = np.linalg.eig(run.monodromy)
        usable = np.where(is_real(values), np.abs(values - (-1.0 if factor == 2 else 1.0)), np.inf)
        y = np.real(vectors[:, int(usable.argmin())])
        displacements, y_of_segment = [], y / np.linalg.norm(y)
        for _ in range(factor):
            for j in range(self.shooting.segments):
                displacements.append(run.bases[j] @ y_of_segment)
                y_of_segment = run.slopes[j] @ y_of_segment
        size, width = size_of(self.shooting, run), abs(self.span[1] - self.span[0])
        normal = Direction(np.array(displacements), 0.0, 0.0)
        starts = np.tile(run.starts, (factor, 1)) + step * size * normal.starts
        through = Direction(starts, factor * run.period, run.value)
        plane = ArclengthPlane(normal, through, (size, run.period, width), small_of(shooting, width))
        limits: dict[str, Any] = {"tolerance": self.tolerance, "iterations": 20}
        result = correct(shooting, starts, through.period, run.value, **limits, plane=plane)
        orbit = orbit_of(shooting, result, self.gaps)
        if orbit.ok and factor == 2 and "already" in orbit.status:
            text = "The step came back to the orbit without doubling; try another step="
            return orbit_of(shooting, NewtonResult(result.last, result.residuals, ok=False, status=text), self.gaps)
        return orbit

    def curve(
        self, event: int | BranchPoint, parameter: str, span: tuple[float, float], *, step: float = 0.02,
        points: int = 200,
    ) -> xr.Dataset:  # fmt: skip
        """The curve of an event over the plane of the branch's parameter and a second one.

        Parameters
        ----------
        event : element of `events`, or its number: grazing, a flip or a Neimark-Sacker point.
        parameter : name of the second parameter.
        span : range (from, to) of the second parameter, which holds its value; the curve ends outside.
        step : first step, as a fraction of both ranges.
        points : largest number of points on each side of the event.

        Returns
        -------
        Dataset with both parameters and the period over "point"; attributes "ok" and "status" tell how it ended.

        Raises
        ------
        InputError : no such event, an event of another kind, an unknown parameter, a range without its value.

        Notes
        -----
        Along the curve the test function of the event vanishes (see `follow`): for grazing the turning point of the gap
        that touches.  At each point orbits are found for given parameters, so a curve ends where its orbits fold.
        """
        from flexmb.dynamics.orbits.event_curve import curve

        return curve(self, event, parameter, span, step=step, points=points)

    def to_dataset(self) -> xr.Dataset:
        """The branch as a table over "point": signals at the start, period, stability, multipliers, events.

        Multipliers have two variables over "multiplier", real and imaginary part.  Events have variables over "event".
        """
        points, axis = self.points, "point"
        signals = np.array([p.signals for p in points]).reshape(len(points), len(self.names))
        extremes = np.array([p.extremes for p in points]).reshape(len(points), len(self.names), 2)
        data: dict[str, Any] = {}
        for k, (name, units) in enumerate(zip(self.names, self.units, strict=True)):
            data[name] = (axis, signals[:, k], {"units": units})
            if np.isfinite(extremes[:, k]).any():
                data[f"{name}.min"], data[f"{name}.max"] = ((axis, extremes[:, k, s], {"units": units}) for s in (0, 1))
        widest = max((len(p.multipliers) for p in points), default=0)
        table = np.full((len(points), widest), np.nan, dtype=np.complex128)
        for row, p in zip(table, points, strict=True):
            row[: len(p.multipliers)] = p.multipliers
        data["period"] = (axis, np.array([p.period for p in points]), {"units": self.period_units})
        data["stable"] = (axis, np.array([p.stable for p in points], dtype=bool))
        data["residual"] = (axis, np.array([p.residual for p in points]))
        data["multiplier.real"] = ((axis, "multiplier"), table.real.copy())
        data["multiplier.imag"] = ((axis, "multiplier"), table.imag.copy())
        for name in points[0].grazing if points else ():
            data[f"grazing.{name}"] = (axis, np.array([p.grazing.get(name, np.nan) for p in points]), {"units": "m"})
        data["event.kind"] = ("event", np.array([e.kind for e in self.events], dtype=str))
        data[f"event.{self.parameter}"] = ("event", np.array([e.value for e in self.events]))
        data["event.period"] = ("event", np.array([e.period for e in self.events]), {"units": self.period_units})
        signals = np.array([e.signals for e in self.events]).reshape(len(self.events), len(self.names))
        for k, name in enumerate(self.names):
            data[f"event.{name}"] = ("event", signals[:, k], {"units": self.units[k]})
        coordinate = (axis, np.array([p.value for p in points]))
        attrs = {"name": self.name, "parameter": self.parameter, "ok": int(self.ok), "status": self.status}
        return xr.Dataset(data, {self.parameter: coordinate}, attrs)

    def event_of(self, label: str, event: Any, kinds: Sequence[str], wanted: str) -> BranchPoint:
        """The `event` of one of some `kinds`, an element of `events` or its number; `label`, `wanted`: for messages."""
        number = isinstance(event, (int, np.integer)) and not isinstance(event, bool)
        if number and -len(self.events) <= event < len(self.events):
            event = self.events[event]
        if not isinstance(event, BranchPoint) or event.kind not in kinds:
            listed = ", ".join(f"{k}: {e.kind} at {e.value:.6g}" for k, e in enumerate(self.events)) or "none"
            text = f"{label}: event is {event if not isinstance(event, BranchPoint) else event.kind!r}"
            raise InputError(f"{text}; it must be {wanted}. Events: {listed}.")
        return event

    def __repr__(self) -> str:
        values = [p.value for p in self.points]
        span = f"{min(values):.6g} to {max(values):.6g}" if values else "nowhere"
        events = ", ".join(f"{e.kind} at {e.value:.8g}" for e in self.events) or "no events"
        return f"Branch of {self.name!r}, {self.parameter} {span}, {len(self.points)} points: {events}. {self.status}"


def size_of(shooting: Shooting, run: ShootingRun) -> float:
    """Scale of the states of a run: their mean length, or 1 if all are 0."""
    return max(float(np.mean([shooting.space.length(x) for x in run.starts])), 1e-2 * shooting.scale) or 1.0


def small_of(shooting: Shooting, width: float) -> float:
    """Difference of the parameter for derivatives, by the width of its range."""
    return (1e-6 if not shooting.is_flow else 1e-5) * width
