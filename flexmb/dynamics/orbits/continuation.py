"""Pseudo-arclength continuation of periodic orbits along a parameter, through folds; events between points."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.orbits import periodic_orbit as orbits
from flexmb.dynamics.orbits.orbit_newton import ArclengthPlane, Direction, NewtonResult, correct, extended, solved
from flexmb.dynamics.orbits.periodic_orbit import Branch, BranchPoint, size_of, small_of
from flexmb.dynamics.orbits.shooting import Shooting, ShootingRun, closest_approaches, gap_signals, sampled
from flexmb.dynamics.systems.impact_ode import ImpactODE
from flexmb.errors import InputError

LOCATED = 1e-9  # precision of an event: fraction of a step, or of the test function
Tests = dict[str, float]


@dataclass(frozen=True)
class ContinuationPoint:
    """An orbit on a branch, the direction of the branch ahead, and the number of corrections that it took."""

    # Test functions change their signs at events; `touches` are numbers of closures of each gap.
    point: BranchPoint
    ahead: Direction
    tests: Tests
    touches: dict[str, int]
    iterations: int
    run: ShootingRun  # the run in the coordinates of the continuation

    def test(self, name: str, old: "ContinuationPoint") -> float:
        """Value of a test function; for grazing its sign changes with the number of closures since an earlier point."""
        value = self.tests.get(name, np.nan)
        if name not in self.touches:
            return value
        return abs(value) if self.touches.get(name) == old.touches.get(name) else -abs(value)


def root(
    make: Callable[[float], ContinuationPoint | None], low: tuple[float, ContinuationPoint],
    high: tuple[float, ContinuationPoint], test: Callable[[ContinuationPoint], float],
) -> tuple[float, ContinuationPoint]:  # fmt: skip
    """Position and orbit between two points at which a test function vanishes, by bracketed secants (Illinois)."""
    # Without an orbit at a trial, as beyond the grazing of rigid surfaces, the root is sought before the trial. `make`
    # returns the orbit at a position, or None; `low` and `high` are positions and orbits at the ends of the bracket.
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


LABEL = "follow"
SHARPEST = 0.9  # smallest cosine of the angle by which the branch may turn in a step
FEW, MANY = 3, 6  # numbers of iterations up to which the next step grows, and from which it shrinks
CORRECTIONS = 10  # largest number of corrections of an orbit on a branch


def follow(
    orbit: orbits.PeriodicOrbit, parameter: str, span: tuple[float | None, float], *, step: float = 0.01,
    largest: float = 0.05, smallest: float = 1e-7, points: int = 500, extremes: int = 0, grazing: str | None = None,
    tolerance: float | None = None,
) -> Branch:  # fmt: skip
    """Continuation of a periodic orbit along a parameter, through folds of the branch.

    Steps go along the branch (pseudo-arclength), so the parameter may turn back.  They shrink if many corrections are
    needed or the branch bends, and grow if few corrections are needed.

    Parameters
    ----------
    orbit : orbit at the begin; it is computed again if its parameter is not the begin of the range.
    parameter : name of a parameter of the system; "part.field" of a mechanism.
    span : range (from, to) of the parameter; from None: its value in the orbit.  The branch ends outside this range.
    step : first step, as a fraction of range, state and period together.
    largest, smallest : bounds of the steps; the branch ends if a smaller step is needed.
    points : largest number of orbits.
    extremes : number of samples of an orbit for the largest and smallest values of signals; 0: none.
    grazing : name of a signal that measures a gap, > 0 if open; contacts of a mechanism and the gap of an `ImpactODE`
        are known.
    tolerance : see `periodic_orbit`.

    Raises
    ------
    InputError : an orbit that was not found, an unknown parameter, a range of zero length, numbers out of range.

    Notes
    -----
    Events are located by secants along the branch, between points at which a test function has different signs.  Test
    functions: component of the branch's direction along the parameter (fold), product of multiplier + 1 (flip), product
    of the products of two multipliers less 1 (Neimark-Sacker, for a complex pair), number of closures of a gap
    (grazing), determinant of the extended problem (branch points: pitchfork, crossing).  Two events of one kind in a
    step cancel: lower `largest`.  Orbits of an `ImpactODE` with a drive are followed by state and instant of their
    slowest impact (equation 9.14), so their branches pass grazing, at which multipliers are those without the touch;
    branches of other systems with rigid surfaces end there, with a corresponding status.
    Source: H. B. Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems (1977); Y. A.
    Kuznetsov, Elements of Applied Bifurcation Theory, Springer 1995, chapter 10.
    """
    if not isinstance(orbit, orbits.PeriodicOrbit) or not orbit.ok:
        given = f"{orbit!r}" if not isinstance(orbit, orbits.PeriodicOrbit) else f"not found: {orbit.status}"
        raise InputError(f"{LABEL}: orbit is {given}; it must be a periodic orbit that was found (`periodic_orbit`).")
    for name, value in (("step", step), ("largest", largest), ("smallest", smallest)):
        checks.positive(LABEL, name, value)
    shooting = orbit.shooting.copy(orbit.times, orbit.shooting.segments)
    if not isinstance(span, (tuple, list)) or len(span) != 2:
        raise InputError(f"{LABEL}: span is {span!r}; it must be a pair (from, to).")
    begin, end = span
    if begin is None:
        begin = orbit.parameters[checks.one_of(LABEL, "parameter", parameter, orbit.parameters)]
    begin, end = checks.number(LABEL, "span[0]", begin), checks.number(LABEL, "span[1]", end)
    if begin == end:
        raise InputError(f"{LABEL}: span is ({begin:g}, {end:g}); both ends must differ.")
    shooting.system.reset(parameters={parameter: begin})  # an unknown one is refused here
    shooting.parameter = parameter
    rigid = isinstance(shooting.system, ImpactODE) and not shooting.autonomous
    if rigid:
        from flexmb.dynamics.orbits.grazing import ImpactContinuation
    continuation = (ImpactContinuation if rigid else Continuation)(
        shooting=shooting.copy(shooting.times, 1) if rigid else shooting, span=(begin, end),
        bounds=(step, largest, smallest), tolerance=orbits.tolerance_of(shooting.system, tolerance),
        gaps=gap_signals(shooting.system, grazing, LABEL), extremes=checks.count(LABEL, "extremes", extremes, 0),
    )  # fmt: skip
    return continuation.run(orbit, checks.count(LABEL, "points", points, 2))


@dataclass(kw_only=True)
class Continuation:
    """Continuation along a branch by arguments of `follow`; `bounds` of steps: first, largest, smallest."""

    shooting: Shooting
    span: tuple[float, float]
    bounds: tuple[float, float, float]
    tolerance: float
    gaps: dict[str, tuple[int, float]]
    extremes: int

    @property
    def coordinates(self) -> Shooting:
        """The shooting by whose unknowns steps are taken."""
        return self.shooting

    def run(self, orbit: orbits.PeriodicOrbit, most: int) -> Branch:
        """Continue the branch until it leaves the range, no step succeeds, or it has `most` orbits."""
        period = orbit.period if self.shooting.autonomous else np.nan
        self.shooting.set_value(self.span[0])
        period = self.shooting.period if np.isnan(period) else period
        starts = self.shooting.spread(orbit.state, period)
        result = NewtonResult(None, (), ok=False, status=f"The motion from the orbit fails: {self.shooting.status}")
        if starts is not None:
            result = correct(self.shooting, starts, period, self.span[0], tolerance=self.tolerance, iterations=30)
        points: list[ContinuationPoint] = []
        events: list[BranchPoint] = []
        if not result.ok or result.last is None:
            return self._branch(points, events, ok=False, status=f"No orbit at the first value: {result.status}")
        run = result.last
        self.lengths = size_of(self.shooting, run), run.period, abs(self.span[1] - self.span[0])
        first = self._first(result)
        if not isinstance(first, ContinuationPoint):
            return self._branch(points, events, ok=False, status=f"No direction: {first}")
        points.append(first)
        ok, size = False, self.bounds[0]
        while len(points) < most:
            following, size, status = self._step(points[-1], size)
            if following is None:
                events += self._grazing_at_the_end(points)
                break
            events += self._events(points[-1], following)
            points.append(following)
            if not min(self.span) <= following.point.value <= max(self.span):
                ok, status = True, f"The branch left the range at {following.point.value:.6g}."
                break
        else:
            status = f"Ended after {most} points, as asked for."
        return self._branch(points, events, ok=ok, status=status)

    def _first(self, result: NewtonResult) -> ContinuationPoint | str:
        """The first point of the branch, or the reason why there is none."""
        ahead = None if result.last is None else self._direction(result.last, None)
        return self._no_direction() if ahead is None else self._continuation_point(result, ahead)

    def _no_direction(self) -> str:
        """The reason why the branch has no direction."""
        return self.coordinates.status or "the motion has no derivative there, as where rigid surfaces graze"

    def _step(self, last: ContinuationPoint, size: float) -> tuple[ContinuationPoint | None, float, str]:
        """The next orbit, the size of the step after it, and the reason if there is no orbit."""
        _, largest, smallest = self.bounds
        reason = ""
        while size >= smallest:
            next_point = self._orbit_at(last, size)
            if isinstance(next_point, ContinuationPoint):
                cosine = self._dot(last.ahead, next_point.ahead)
                if cosine >= SHARPEST:
                    factor = 0.6 if next_point.iterations >= MANY else 1.0
                    if next_point.iterations <= FEW and cosine > 0.98:
                        factor = 1.5
                    return next_point, min(size * factor, largest), ""
                next_point = "the branch bends too sharply"
            reason, size = next_point, 0.5 * size
        text = f"Ended at {last.point.value:.6g}: a step smaller than {smallest:g} would be needed"
        return None, size, f"{text} ({reason})."

    def _orbit_at(self, last: ContinuationPoint, size: float) -> ContinuationPoint | str:
        """The orbit at a distance `size` from another one, or the reason why there is none."""
        run, shooting = last.run, self.coordinates
        along, value = last.ahead, run.value + size * last.ahead.value
        through = Direction(run.starts + size * along.starts, run.period + size * along.period, value)
        plane = ArclengthPlane(last.ahead, through, self.lengths, small_of(shooting, self.lengths[2]))
        period = through.period
        if not shooting.set_value(through.value):
            return shooting.status.rstrip(".")
        if not shooting.autonomous:
            period = shooting.period
        starts = through.starts.copy()
        starts[:, shooting.space.free_rows] = run.starts[:, shooting.space.free_rows]
        limits: dict[str, Any] = {"tolerance": self.tolerance, "iterations": CORRECTIONS}
        result = correct(shooting, starts, period, through.value, **limits, plane=plane)
        if not result.ok or result.last is None:
            return result.status.rstrip(".")
        ahead = self._direction(result.last, last.ahead)
        return self._no_direction() if ahead is None else self._continuation_point(result, ahead)

    def _direction(self, run: ShootingRun, before: Direction | None) -> Direction | None:
        """Unit direction of the branch, onwards from `before`; None: from the begin of the range to its end."""
        shooting = self.coordinates
        J = extended(shooting, run, small_of(shooting, self.lengths[2]))
        if J is None:
            return None
        M, d = run.gaps.shape
        x, t, p = self.lengths
        if before is None:
            row = np.zeros(J.shape[1])
            row[-1] = np.sign(self.span[1] - self.span[0]) / p
        else:
            by_y = np.einsum("js,jsd->jd", before.starts * shooting.space.weights / x**2, run.bases).ravel()
            row = np.concatenate([by_y, [before.period / t**2] * shooting.autonomous, [before.value / p**2]])
        unknowns = solved(np.vstack([J, row]), np.append(np.zeros(len(J)), 1.0))
        # sign of the determinant, times the smallest singular value: it vanishes where branches cross
        units = np.array([x] * (M * d) + [t] * shooting.autonomous + [p])
        ahead = unknowns / units
        whole = np.vstack([J * units / units[0], ahead / np.linalg.norm(ahead)])
        self.volume = float(np.linalg.slogdet(whole)[0] * np.linalg.svd(whole, compute_uv=False)[-1])
        starts = np.einsum("jsd,jd->js", run.bases, unknowns[: M * d].reshape(M, d))
        direction = Direction(starts, float(unknowns[M * d]) if shooting.autonomous else 0.0, float(unknowns[-1]))
        length = np.sqrt(self._dot(direction, direction))
        return Direction(direction.starts / length, direction.period / length, direction.value / length)

    def _dot(self, one: Direction, other: Direction) -> float:
        x, t, p = self.lengths
        states = float((one.starts * other.starts * self.coordinates.space.weights).sum()) / x**2
        return states + one.period * other.period / t**2 + one.value * other.value / p**2

    def _continuation_point(self, result: NewtonResult, ahead: Direction) -> ContinuationPoint | str:
        """The point of a branch for a converged run: orbit, direction, test functions."""
        run, shooting = result.last, self.shooting
        if run is None:
            raise InputError(f"{LABEL}: no orbit.")
        multipliers, _ = orbits.multipliers_of(run.monodromy, autonomous=shooting.autonomous)
        system, volume = shooting.system, self.volume
        shooting.set_value(run.value)
        system.reset(run.starts[0], time=shooting.origin)
        signals, extremes = system.observe(), np.full((len(system.names), 2), np.nan)
        approaches: dict[str, float] = {}
        touches: dict[str, int] = {}
        if self.gaps or self.extremes:
            samples = sampled(system, run.period, max(self.extremes, 200 * shooting.times if self.gaps else 0))
            extremes = np.array([samples[1].min(axis=0), samples[1].max(axis=0)]).T
            closest = closest_approaches(system, self.gaps, samples)
            approaches = {name: least for name, (least, _, _) in closest.items()}
            touches = {f"{orbits.GRAZING} {name}": times for name, (_, _, times) in closest.items()}
        rising = ahead.value / self.lengths[2]
        flip, torus = orbits.flip_test(multipliers), orbits.torus_test(multipliers)
        tests = {orbits.FOLD: rising, orbits.FLIP: flip, orbits.NEIMARK_SACKER: torus, orbits.BRANCH: volume}
        tests |= {f"{orbits.GRAZING} {name}": least for name, least in approaches.items()}
        stable = bool((np.abs(multipliers) < 1.0).all())
        point = BranchPoint(
            value=float(run.value), kind="", period=run.period, state=run.starts[0], signals=signals, stable=stable,
            multipliers=multipliers, residual=result.residuals[-1], extremes=extremes, grazing=approaches,
            rising=rising, shooting_run=run,
        )  # fmt: skip
        return ContinuationPoint(point, ahead, tests, touches, len(result.residuals) - 1, run)

    def _events(self, old: ContinuationPoint, new: ContinuationPoint) -> list[BranchPoint]:
        """The events between two orbits, in the order of the branch."""
        located = []
        for name in old.tests:
            before, after = old.test(name, old), new.test(name, old)
            if before * after < 0.0:
                position, point_on_branch = self._located(old, new, name)
                # where branches cross, the corrections may end on the other branch: a larger value is accepted
                most = (2e-2 if name == orbits.BRANCH else 1e-3) * max(abs(before), abs(after)) + 1e-9
                vanishes = not abs(point_on_branch.tests[name]) > most
                multipliers = point_on_branch.point.multipliers
                if vanishes and (name != orbits.NEIMARK_SACKER or orbits.crosses_circle(multipliers)):
                    located.append((position, replace(point_on_branch.point, kind=name.partition(" ")[0])))
        low, high = min(self.span), max(self.span)
        return [point for _, point in sorted(located, key=lambda item: item[0]) if low <= point.value <= high]

    def _located(self, old: ContinuationPoint, new: ContinuationPoint, name: str) -> tuple[float, ContinuationPoint]:
        """Position along the step and orbit at which a test function vanishes."""
        first, second = old.run, new.run
        starts = self.coordinates.space.difference(second.starts, first.starts)
        step = Direction(starts, second.period - first.period, second.value - first.value)

        def orbit_at(position: float) -> ContinuationPoint | None:
            found = self._orbit_at(old, position)
            return found if isinstance(found, ContinuationPoint) else None

        ends = (0.0, old), (self._dot(step, old.ahead), new)
        return root(orbit_at, *ends, lambda point_on_branch: point_on_branch.test(name, old))

    def _grazing_at_the_end(self, points: list[ContinuationPoint]) -> list[BranchPoint]:
        """The last orbit as an event, if the branch ends because surfaces come into contact."""
        if len(points) < 2:
            return []
        last, first = points[-1].point, points[0].point
        near = [n for n, g in last.grazing.items() if abs(g) < 1e-3 * max(abs(first.grazing.get(n, np.nan)), 1e-300)]
        return [replace(last, kind=orbits.GRAZING)] if near else []

    def _branch(self, points: list[ContinuationPoint], events: list[BranchPoint], *, ok: bool, status: str) -> Branch:
        system = self.shooting.system
        return Branch(
            name=system.name, parameter=str(self.shooting.parameter), period_units=system.unit, names=system.names,
            units=system.units, points=tuple(s.point for s in points), events=tuple(events), ok=ok, status=status,
            shooting=self.shooting, tolerance=self.tolerance, span=self.span, gaps=self.gaps,
        )  # fmt: skip
