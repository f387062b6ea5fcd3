"""Following a periodic orbit along a parameter, through folds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from flexmb import checks
from flexmb.dynamics.orbits.branch import Branch, BranchPoint, size_of, small_of
from flexmb.dynamics.orbits.floquet import (
    BRANCH,
    FLIP,
    FOLD,
    GRAZING,
    NEIMARK_SACKER,
    crosses_circle,
    flip_test,
    multipliers_of,
    torus_test,
)
from flexmb.dynamics.orbits.grazing import closest_approaches, gap_signals, sampled
from flexmb.dynamics.orbits.newton import Direction, Found, Plane, correct, extended, solved
from flexmb.dynamics.orbits.periodic_orbit import PeriodicOrbit, tolerance_of
from flexmb.dynamics.orbits.shooting import Pass, Shooting
from flexmb.errors import InputError

LABEL = "follow"

SHARPEST = 0.9
"""Cosine of the largest turn of the branch in a step."""

FEW, MANY = 3, 6
"""Iterations after which the next step grows, or shrinks."""

CORRECTIONS = 10
LOCATED = 1e-9
"""Events are located up to this part of a step, or until their test is this small."""

Tests = dict[str, float]


@dataclass(frozen=True)
class Station:
    """An orbit on the way, the direction of the branch there, and the tests that change their sign at events."""

    point: BranchPoint
    ahead: Direction
    tests: Tests
    touches: dict[str, int]
    iterations: int

    def test(self, name: str, old: Station) -> float:
        """A test that changes its sign between two orbits; that of grazing where a gap closes more or less often."""
        value = self.tests.get(name, np.nan)
        if not name.startswith(GRAZING):
            return value
        return abs(value) if self.touches.get(name) == old.touches.get(name) else -abs(value)


def follow(
    orbit: PeriodicOrbit,
    parameter: str,
    span: tuple[float | None, float],
    *,
    step: float = 0.01,
    largest: float = 0.05,
    smallest: float = 1e-7,
    points: int = 500,
    extremes: int = 0,
    grazing: str | None = None,
    tolerance: float | None = None,
) -> Branch:
    """The branch of orbits that passes through one, along a parameter and through its folds.

    Steps are taken along the branch (pseudo-arclength), so that it may turn back.  They shrink where
    corrections are many or the branch bends, and grow where they are few.

    Parameters
    ----------
    orbit : where to begin; if the parameter is not at the beginning of the range there, it is sought again.
    parameter : name of a parameter of the system; a mechanism's are "part.field".
    span : (from, to) of the parameter; from None: its value in the orbit.  The branch ends where it leaves this range.
    step : first step, of range, state and period together, as a part of them.
    largest, smallest : bounds of steps; a branch that needs a smaller one ends.
    points : largest number of orbits.
    extremes : into how many parts each orbit is divided to find the largest and smallest values of signals; 0: none.
    grazing : name of a signal that tells a gap, > 0 where it is open; a mechanism's contacts are known.
    tolerance : of what does not come back, as in `periodic_orbit`.

    Raises
    ------
    InputError : an orbit that was not found, an unknown parameter, a range without length, numbers out of range.

    Notes
    -----
    Events are located by secants along the branch, where a test changes its sign: the parameter's part of the branch's
    direction (fold), the product of multiplier + 1 (flip), the product of products of two multipliers less 1
    (Neimark-Sacker, if the pair is complex), how often surfaces close a gap (grazing), the determinant of the whole
    problem (branch points: pitchfork, crossing).  Two events of one kind in a step cancel: lower `largest`.
    Where surfaces do not yield, orbits end at grazing; a branch that ends there says so.
    Source: H. B. Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems (1977); Y. A.
    Kuznetsov, Elements of Applied Bifurcation Theory, Springer 1995, chapter 10.
    """
    if not isinstance(orbit, PeriodicOrbit) or not orbit.ok:
        what = f"{orbit!r}" if not isinstance(orbit, PeriodicOrbit) else f"not found: {orbit.status}"
        raise InputError(f"{LABEL}: orbit is {what}; it must be a periodic orbit that was found (`periodic_orbit`).")
    for name, value in (("step", step), ("largest", largest), ("smallest", smallest)):
        checks.positive(LABEL, name, value)
    shooting = orbit.shooting.copy(orbit.times, orbit.shooting.segments)
    begin, end = _range(orbit, parameter, span)
    shooting.system.reset(parameters={parameter: begin})  # an unknown one is refused here
    shooting.parameter = parameter
    walk = Walk(
        shooting=shooting,
        span=(begin, end),
        bounds=(step, largest, smallest),
        tolerance=tolerance_of(shooting.system, tolerance),
        gaps=gap_signals(shooting.system, grazing, LABEL),
        extremes=checks.count(LABEL, "extremes", extremes, 0),
    )
    return walk.run(orbit, checks.count(LABEL, "points", points, 2))


def _range(orbit: PeriodicOrbit, parameter: str, span: tuple[float | None, float]) -> tuple[float, float]:
    if not isinstance(span, (tuple, list)) or len(span) != 2:
        raise InputError(f"{LABEL}: span is {span!r}; it must be a pair (from, to).")
    begin = span[0]
    if begin is None:
        begin = orbit.parameters[checks.one_of(LABEL, "parameter", parameter, orbit.parameters)]
    begin, end = checks.number(LABEL, "span[0]", begin), checks.number(LABEL, "span[1]", span[1])
    if begin == end:
        raise InputError(f"{LABEL}: span is ({begin:g}, {end:g}); both ends must differ.")
    return begin, end


@dataclass(kw_only=True)
class Walk:
    """The way along a branch; see `follow` for what its numbers mean."""

    shooting: Shooting
    span: tuple[float, float]
    bounds: tuple[float, float, float]
    tolerance: float
    gaps: dict[str, tuple[int, float]]
    extremes: int

    def run(self, orbit: PeriodicOrbit, most: int) -> Branch:
        """Step by step until the range is left, or no step succeeds."""
        period = orbit.period if self.shooting.autonomous else np.nan
        self.shooting.set_value(self.span[0])
        period = self.shooting.period if np.isnan(period) else period
        starts = self.shooting.spread(orbit.state, period)
        nothing = Found(None, (), ok=False, status=f"The motion from the orbit fails: {self.shooting.status}")
        found = nothing if starts is None else self._correct(starts, period, self.span[0], None, 30)
        stations: list[Station] = []
        events: list[BranchPoint] = []
        if not found.ok or found.last is None:
            return self._branch(stations, events, ok=False, status=f"No orbit at the first value: {found.status}")
        one = found.last
        self.lengths = (
            size_of(self.shooting, one),
            one.period,
            abs(self.span[1] - self.span[0]),
        )
        ahead = self._direction(one, None)
        if ahead is None:
            return self._branch(stations, events, ok=False, status=f"No direction: {self.shooting.status}")
        stations.append(self._station(found, ahead))
        ok, status, size = False, f"Ended after {most} points, as asked for.", self.bounds[0]
        while len(stations) < most:
            following, size, status = self._step(stations[-1], size)
            if following is None:
                events += self._grazing_at_the_end(stations)
                break
            events += self._events(stations[-1], following)
            stations.append(following)
            if not min(self.span) <= following.point.value <= max(self.span):
                ok, status = True, f"The branch left the range at {following.point.value:.6g}."
                break
        else:
            status = f"Ended after {most} points, as asked for."
        return self._branch(stations, events, ok=ok, status=status)

    def _step(self, old: Station, size: float) -> tuple[Station | None, float, str]:
        """The next orbit, the step to be tried after it, and why there is none."""
        _, largest, smallest = self.bounds
        reason = ""
        while size >= smallest:
            new = self._orbit_at(old, size)
            if isinstance(new, Station):
                bend = self._dot(old.ahead, new.ahead)
                if bend >= SHARPEST:
                    factor = 1.5 if new.iterations <= FEW and bend > 0.98 else 0.6 if new.iterations >= MANY else 1.0
                    return new, min(size * factor, largest), ""
                new = "the branch bends too sharply"
            reason, size = new, 0.5 * size
        text = f"Ended at {old.point.value:.6g}: a step smaller than {smallest:g} would be needed"
        return None, size, f"{text} ({reason})."

    def _orbit_at(self, old: Station, size: float) -> Station | str:
        """The orbit a step from another one, or why there is none."""
        one = old.point.made_of
        through = Direction(
            one.starts + size * old.ahead.starts,
            one.period + size * old.ahead.period,
            one.value + size * old.ahead.value,
        )
        plane = Plane(old.ahead, through, self.lengths, self._small())
        period = through.period
        if not self.shooting.set_value(through.value):
            return self.shooting.status.rstrip(".")
        if not self.shooting.autonomous:
            period = self.shooting.period
        starts = through.starts.copy()
        starts[:, self.shooting.space.handed] = one.starts[:, self.shooting.space.handed]
        found = self._correct(starts, period, through.value, plane, CORRECTIONS)
        if not found.ok or found.last is None:
            return found.status.rstrip(".")
        ahead = self._direction(found.last, old.ahead)
        return self.shooting.status if ahead is None else self._station(found, ahead)

    def _correct(self, starts: np.ndarray, period: float, value: float, plane: Plane | None, most: int) -> Found:
        return correct(self.shooting, starts, period, value, tolerance=self.tolerance, iterations=most, plane=plane)

    def _direction(self, one: Pass, before: Direction | None) -> Direction | None:
        """Direction of the branch, of length 1, onwards from `before`; None: from the range's beginning to its end."""
        J = extended(self.shooting, one, self._small())
        if J is None:
            return None
        M, d = one.gaps.shape
        x, t, p = self.lengths
        if before is None:
            row = np.zeros(J.shape[1])
            row[-1] = np.sign(self.span[1] - self.span[0]) / p
        else:
            wide = before.starts * self.shooting.space.weights / x**2
            by_y = np.einsum("js,jsd->jd", wide, one.bases).ravel()
            row = np.concatenate([by_y, [before.period / t**2] * self.shooting.autonomous, [before.value / p**2]])
        u = solved(np.vstack([J, row]), np.append(np.zeros(len(J)), 1.0))
        self.volume = _signed_volume(J, u, np.array([x] * (M * d) + [t] * self.shooting.autonomous + [p]))
        starts = np.einsum("jsd,jd->js", one.bases, u[: M * d].reshape(M, d))
        found = Direction(starts, float(u[M * d]) if self.shooting.autonomous else 0.0, float(u[-1]))
        size = np.sqrt(self._dot(found, found))
        return Direction(found.starts / size, found.period / size, found.value / size)

    def _dot(self, one: Direction, other: Direction) -> float:
        x, t, p = self.lengths
        states = float((one.starts * other.starts * self.shooting.space.weights).sum()) / x**2
        return states + one.period * other.period / t**2 + one.value * other.value / p**2

    def _small(self) -> float:
        return small_of(self.shooting, abs(self.span[1] - self.span[0]))

    def _station(self, found: Found, ahead: Direction) -> Station:
        """What is to be known of an orbit that was found."""
        one, shooting = found.last, self.shooting
        if one is None:
            raise InputError(f"{LABEL}: no orbit.")
        multipliers, _ = multipliers_of(one.monodromy, autonomous=shooting.autonomous)
        system, volume = shooting.system, self.volume
        shooting.set_value(one.value)
        system.reset(one.starts[0], time=shooting.origin)
        signals, ends = system.observe(), np.full((len(system.names), 2), np.nan)
        near: dict[str, float] = {}
        touches: dict[str, int] = {}
        if self.gaps or self.extremes:
            run = sampled(system, one.period, max(self.extremes, 200 * shooting.times if self.gaps else 0))
            ends = np.array([run[1].min(axis=0), run[1].max(axis=0)]).T
            closest = closest_approaches(system, self.gaps, run)
            near = {name: least for name, (least, _, _) in closest.items()}
            touches = {f"{GRAZING} {name}": times for name, (_, _, times) in closest.items()}
        rising = ahead.value / self.lengths[2]
        tests = {FOLD: rising, FLIP: flip_test(multipliers), NEIMARK_SACKER: torus_test(multipliers), BRANCH: volume}
        tests |= {f"{GRAZING} {name}": least for name, least in near.items()}
        point = BranchPoint(
            value=float(one.value),
            kind="",
            period=one.period,
            state=one.starts[0],
            signals=signals,
            multipliers=multipliers,
            stable=bool((np.abs(multipliers) < 1.0).all()),
            residual=found.misses[-1],
            extremes=ends,
            grazing=near,
            rising=rising,
            made_of=one,
        )
        return Station(point, ahead, tests, touches, len(found.misses) - 1)

    def _events(self, old: Station, new: Station) -> list[BranchPoint]:
        """The events between two orbits, in the order of the branch."""
        found = []
        for name in old.tests:
            before, after = old.test(name, old), new.test(name, old)
            if before * after < 0.0:
                place, station = self._located(old, new, name)
                if self._is_one(name, station, max(abs(before), abs(after))):
                    kind = name.partition(" ")[0]
                    found.append((place, replace(station.point, kind=kind)))
        low, high = min(self.span), max(self.span)
        return [point for _, point in sorted(found, key=lambda item: item[0]) if low <= point.value <= high]

    def _located(self, old: Station, new: Station, name: str) -> tuple[float, Station]:
        """Place along the step and orbit where a test vanishes."""
        away = self._dot(self._between(old, new), old.ahead)
        return root(
            lambda s: _or_none(self._orbit_at(old, s)),
            (0.0, old),
            (away, new),
            lambda station: station.test(name, old),
        )

    def _between(self, old: Station, new: Station) -> Direction:
        one, other, space = old.point.made_of, new.point.made_of, self.shooting.space
        way = np.array([space.difference(b, a) for a, b in zip(one.starts, other.starts, strict=True)])
        return Direction(way, other.period - one.period, other.value - one.value)

    @staticmethod
    def _is_one(name: str, station: Station, before: float) -> bool:
        """Whether the test vanishes there and does not jump, and is one of stability."""
        # where branches cross the corrections may end on the other one, so that less is asked for
        if abs(station.tests[name]) > (2e-2 if name == BRANCH else 1e-3) * before + 1e-9:
            return False
        return name != NEIMARK_SACKER or crosses_circle(station.point.multipliers)

    def _grazing_at_the_end(self, stations: list[Station]) -> list[BranchPoint]:
        """The last orbit, if the branch ends where surfaces come to touch."""
        if len(stations) < 2:
            return []
        last, first = stations[-1].point, stations[0].point
        near = [n for n, g in last.grazing.items() if abs(g) < 1e-3 * max(abs(first.grazing.get(n, np.nan)), 1e-300)]
        return [replace(last, kind=GRAZING)] if near else []

    def _branch(self, stations: list[Station], events: list[BranchPoint], *, ok: bool, status: str) -> Branch:
        system = self.shooting.system
        return Branch(
            name=system.name,
            parameter=str(self.shooting.parameter),
            unit=system.unit,
            names=system.names,
            units=system.units,
            points=tuple(s.point for s in stations),
            events=tuple(events),
            ok=ok,
            status=status,
            shooting=self.shooting,
            tolerance=self.tolerance,
            span=self.span,
            gaps=self.gaps,
        )


def _or_none(found: Station | str) -> Station | None:
    return found if isinstance(found, Station) else None


def _signed_volume(J: np.ndarray, u: np.ndarray, units: np.ndarray) -> float:
    """Determinant's sign of J with the direction u below it, times the smallest singular value: 0 where branches cross.

    Unknowns in their units (columns,); gaps in the first of them.
    """
    ahead = u / units
    whole = np.vstack([J * units / units[0], ahead / np.linalg.norm(ahead)])
    return float(np.linalg.slogdet(whole)[0] * np.linalg.svd(whole, compute_uv=False)[-1])


def root(
    make: Callable[[float], Station | None],
    low: tuple[float, Station],
    high: tuple[float, Station],
    test: Callable[[Station], float],
) -> tuple[float, Station]:
    """Place and orbit between two at which a test of orbits vanishes: secants, kept within the bracket (Illinois).

    Where no orbit is found, as beyond the grazing of stiff surfaces, the root is looked for before it.
    """
    (a, one), (b, other) = low, high
    fa, fb = test(one), test(other)
    width, largest = abs(b - a), max(abs(fa), abs(fb))
    best = (a, one) if abs(fa) < abs(fb) else (b, other)
    for _ in range(40):
        s = (a * fb - b * fa) / (fb - fa)
        middle = make(s)
        f = test(middle) if middle is not None else np.nan
        f = -fa if np.isnan(f) else f
        if middle is not None and abs(f) < abs(test(best[1])):
            best = (s, middle)
        if abs(f) <= LOCATED * largest or abs(b - a) <= LOCATED * width:
            break
        if f * fb < 0.0:
            a, fa = b, fb
        else:
            fa *= 0.5
        b, fb = s, f
    return best
