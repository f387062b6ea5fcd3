"""Curves of events in two parameters: grazing, flips and Neimark-Sacker points of a branch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.orbits import periodic_orbit as orbits
from flexmb.dynamics.orbits.continuation import ImpactContinuation
from flexmb.dynamics.orbits.orbit_newton import correct
from flexmb.dynamics.orbits.periodic_orbit import Branch, BranchPoint
from flexmb.dynamics.orbits.shooting import SAMPLES, Shooting, ShootingRun, closest_approaches, sampled
from flexmb.dynamics.systems.impact_ode import ImpactODE
from flexmb.errors import FlexmbError, InputError
from flexmb.late import xr

KINDS = (orbits.GRAZING, orbits.FLIP, orbits.NEIMARK_SACKER)
DIFFERENCE = 1e-4  # difference of a parameter for the gradient of a test function, over its range
CORRECTIONS = 8  # largest number of corrections of a point of the curve
FEW = 4  # number of corrections up to which the next step grows
SMALLEST = 1e-4  # smallest step, over the first one
SHARPEST = 0.9  # smallest cosine of the angle by which the curve may turn in a step
PRECISE = 1e-9  # correction, over the ranges, with which a point is found

CurvePoint = tuple[np.ndarray, ShootingRun]  # place (2,) in units of the ranges, and the orbit there


@dataclass
class Plane:
    """Orbits over the plane of two parameters, with the test function that vanishes on the curve."""

    shooting: Shooting
    other: str  # the second parameter
    units: np.ndarray  # widths (2,) of both ranges
    tolerance: float
    test: Callable[[ShootingRun, ShootingRun], float]  # of an orbit and its guess
    prepare: Callable[[ShootingRun], None] = lambda guess: None
    low: float = -np.inf  # range of the second parameter, in which the curve is followed
    high: float = np.inf

    def at(self, place: np.ndarray, guess: ShootingRun) -> tuple[ShootingRun, float] | None:
        """Orbit near a guess and test function at a place (2,), in units of the ranges; None: no orbit."""
        value, other = place * self.units
        self.prepare(guess)
        shooting = self.shooting
        try:
            shooting.system.reset(parameters={self.other: float(other)})
        except FlexmbError:
            return None
        if not shooting.set_value(float(value)):
            return None
        period = guess.period if shooting.autonomous else shooting.period
        result = correct(shooting, guess.starts, period, float(value), tolerance=self.tolerance, iterations=10)
        if not result.ok or result.last is None:
            return None
        g = self.test(result.last, guess)
        return (result.last, g) if np.isfinite(g) else None

    def gradient(self, place: np.ndarray, run: ShootingRun) -> np.ndarray | None:
        """Derivatives (2,) of the test function; None: no orbit nearby."""
        columns = []
        for k in range(2):
            shift = np.zeros(2)
            shift[k] = DIFFERENCE
            up, down = self.at(place + shift, run), self.at(place - shift, run)
            if up is None or down is None:
                return None
            columns.append((up[1] - down[1]) / (2.0 * DIFFERENCE))
        return np.array(columns)

    def corrected(
        self, place: np.ndarray, gradient: np.ndarray, guess: ShootingRun
    ) -> tuple[np.ndarray, np.ndarray, ShootingRun, int] | None:
        """The place on the curve near another one, gradient and orbit there, number of corrections; None: not found."""
        # Broyden's method keeps the gradient (C. G. Broyden, Math. Comp. 19 (1965) 577).
        last, step = np.nan, np.zeros(2)
        for count in range(CORRECTIONS):
            found = self.at(place, guess)
            if found is None:
                return None
            guess, g = found
            if count:
                gradient = gradient + (g - last - gradient @ step) / (step @ step) * step
            step, last = -g * gradient / (gradient @ gradient), g
            if np.abs(step).max() < PRECISE:
                return place, gradient, guess, count
            place = place + step
        return None

    def walk(self, begin: CurvePoint, size: float, most: int, sign: float) -> tuple[list[CurvePoint], str]:
        """Points of the curve, at first towards the `sign` of the second parameter, and the reason of the end."""
        (place, run), found = begin, list[CurvePoint]()
        ahead, step, slope = np.array([0.0, sign]), size, self.gradient(place, run)
        while len(found) < most:
            if slope is None or not np.any(slope):
                return found, "no orbits nearby"
            along = np.array([-slope[1], slope[0]]) / np.linalg.norm(slope)
            along *= np.sign(along @ ahead) or 1.0
            following = self.corrected(place + step * along, slope, run)
            if following is None or (following[0] - place) @ along < SHARPEST * np.linalg.norm(following[0] - place):
                step *= 0.5
                if step < SMALLEST * size:
                    return found, "a smaller step would be needed"
                slope = self.gradient(place, run)
                continue
            (place, slope, run, count), ahead = following, along
            found.append((place, run))
            if not self.low <= place[1] * self.units[1] <= self.high:
                return found, ""
            step = min(1.5 * step, 10.0 * size) if count <= FEW else step
        return found, f"{most} points, as asked for"


def curve(
    branch: Branch, event: int | BranchPoint, parameter: str, span: tuple[float, float], *, step: float, points: int
) -> xr.Dataset:
    """Points of the curve; see `Branch.curve`."""
    label = "Branch.curve"
    event = branch.event_of(label, event, KINDS, "grazing, a flip or a Neimark-Sacker point")
    shooting = branch.shooting.copy(branch.shooting.times, branch.shooting.segments)
    checks.one_of(label, "parameter", parameter, shooting.system.parameters)
    if parameter == branch.parameter:
        raise InputError(f"{label}: parameter is {parameter!r}, along which the branch runs; name another one.")
    if not isinstance(span, (tuple, list)) or len(span) != 2:
        raise InputError(f"{label}: span is {span!r}; it must be a pair (from, to).")
    low, high = sorted(checks.number(label, f"span[{k}]", x) for k, x in enumerate(span))
    begin = checks.number(label, parameter, shooting.system.parameters[parameter])
    if not low <= begin <= high or low == high:
        raise InputError(f"{label}: span is ({low:g}, {high:g}); it must hold {begin:g}, the value of {parameter!r}.")
    plane, run = _plane(branch, event, shooting, parameter, high - low)
    place = np.array([event.value, begin]) / plane.units
    size, most = checks.between(label, "step", step, 1e-6, 1.0), checks.count(label, "points", points, 1)
    plane.low, plane.high, middle = low, high, (place, run)
    (down, lower_end), (up, upper_end) = (plane.walk(middle, size, most, sign) for sign in (-1.0, 1.0))
    whole = [*down[::-1], middle, *up]
    ends = [f"{side} end: {end}" for side, end in (("lower", lower_end), ("upper", upper_end)) if end]
    places = np.array([place for place, _ in whole]) * plane.units
    period = ("point", np.array([run.period for _, run in whole]), {"units": branch.period_units})
    data = {branch.parameter: ("point", places[:, 0]), parameter: ("point", places[:, 1]), "period": period}
    about = {"name": branch.name, "kind": event.kind, "ok": int(not ends), "status": "; ".join(ends) or "Whole."}
    return xr.Dataset(data, attrs=about)


def _plane(
    branch: Branch, event: BranchPoint, shooting: Shooting, parameter: str, width: float
) -> tuple[Plane, ShootingRun]:
    """Orbits with the test function of an event, and the orbit at the event."""
    units = np.array([abs(branch.span[1] - branch.span[0]), width])

    def of_multipliers(run: ShootingRun, guess: ShootingRun) -> float:
        multipliers, _ = orbits.multipliers_of(run.monodromy, autonomous=shooting.autonomous)
        return orbits.flip_test(multipliers) if event.kind == orbits.FLIP else orbits.torus_test(multipliers)

    def of_gap(run: ShootingRun, guess: ShootingRun) -> float:
        shooting.set_value(run.value)
        shooting.system.reset(run.starts[0], time=shooting.origin)
        samples = sampled(shooting.system, run.period, SAMPLES * shooting.times)
        return min((g for g, _, _ in closest_approaches(shooting.system, branch.gaps, samples).values()), key=abs)

    if event.kind != orbits.GRAZING or not isinstance(shooting.system, ImpactODE) or shooting.autonomous:
        test = of_gap if event.kind == orbits.GRAZING else of_multipliers
        return Plane(shooting, parameter, units, branch.tolerance, test), event.shooting_run
    about: dict[str, Any] = {"span": branch.span, "tolerance": branch.tolerance, "gaps": {}, "extremes": 0}
    continuation = ImpactContinuation(shooting=shooting, bounds=(1.0, 1.0, 1.0), **about)
    run, other = continuation.grazing(event), (continuation.least_gap, continuation.listen_as)
    return Plane(continuation.coordinates, parameter, units, branch.tolerance, *other), run
