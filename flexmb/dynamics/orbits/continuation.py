"""Pseudo-arclength continuation of periodic orbits through folds and grazing; events between points."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np

from flexmb import checks
from flexmb.dynamics.orbits import periodic_orbit as orbits
from flexmb.dynamics.orbits.orbit_newton import ArclengthPlane, Direction, NewtonResult, correct, extended, solved
from flexmb.dynamics.orbits.periodic_orbit import Branch, BranchPoint, size_of, small_of
from flexmb.dynamics.orbits.shooting import TURN, Shooting, ShootingRun, closest_approaches, gap_signals, sampled
from flexmb.dynamics.systems.impact_ode import Approach, FromImpact, ImpactODE, Spans, approaches
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


IMPACT, TOUCH = "impact", "touch"  # test functions of grazing: closing speed at the start, least gap without impact
QUARTER = 0.25  # half of a silent span, over the distance to the next impact or turning point
LONGEST = 0.125  # largest half of a silent span, over the period
CLOSE_TO_GRAZING = 1e-3  # distance to grazing up to which other events are sought, over the step
SAME = 1e-6  # difference of the instants of one impact, over the period
GAP = "gap"
PROBE = 1e-5  # displacement along a branch that tells the side on which a gap opens


@dataclass(frozen=True)
class Motion:
    """A motion over a period: start (size,) at the origin of the orbit, impacts, turning points of the gap."""

    start: np.ndarray
    impacts: list[Approach]
    turns: list[Approach]

    @property
    def first(self) -> Approach:
        """The first impact."""
        return next(iter(self.impacts))


@dataclass(kw_only=True)
class ImpactContinuation(Continuation):
    """Continuation of the orbits of an `ImpactODE`."""

    # The unknowns are state and instant of the slowest impact, by which orbits are smooth at grazing. Without impacts
    # they are the state at the origin. Turning points of the gap lie in silent spans, where surfaces pass through each
    # other; so test functions change their signs at grazing, and the branch goes on with one impact more or less.
    from_impact: Shooting | None = None
    scale: float = 1.0  # of the states, in the weights of instants
    pending: list[BranchPoint] = field(default_factory=list)  # events of the last step
    touches: list[tuple[ShootingRun, float, Spans]] = field(default_factory=list)  # runs near grazing

    def __post_init__(self) -> None:
        given = self.shooting.declared
        if given is not None:  # silent spans are fractions of the period of the system
            self._listener().flow._given_period = (lambda **p: given(p)) if callable(given) else given

    @property
    def coordinates(self) -> Shooting:
        return self.shooting if self.from_impact is None else self.from_impact

    def _first(self, result: NewtonResult) -> ContinuationPoint | str:
        if result.last is None:
            return result.status
        run = result.last
        motion = self._from(self._listener(), run.starts[0])
        return self.shooting.status if motion is None else self._enter(motion, run.value)

    # Motions and coordinates

    def _listener(self) -> ImpactODE:
        """The system, as the shooting moves it."""
        return cast("ImpactODE", self.shooting.system)

    def _from(self, flow: ImpactODE, start: np.ndarray) -> Motion | None:
        """The motion of a flow over a period from a start at the origin; None: it fails."""
        try:
            flow.reset(start, time=self.shooting.origin)
        except InputError as error:  # behind the wall
            self.shooting.status = str(error)
            return None
        return self._observed(flow, start)

    def _observed(self, flow: ImpactODE, start: np.ndarray) -> Motion | None:
        """The motion of a flow over a period from its present state on; None: it fails."""
        found = approaches(flow, float(flow.period or 1.0) * self.shooting.times)
        if found is None:
            self.shooting.status = flow.status
            return None
        return Motion(start, [a for a in found if a.speed > 0.0], [a for a in found if a.speed == 0.0])

    def _motion(self, starts: np.ndarray, value: float) -> Motion | None:
        """The motion of unknowns (1, n) of the present coordinates at a value of the parameter."""
        if not self.coordinates.set_value(value) or not self.shooting.set_value(value):
            return None
        if self.from_impact is None:
            return self._from(self._listener(), starts[0])
        system = self._impact_map()
        system.reset(starts[0])
        _, speed = system.rebound()
        motion = self._observed(system.flow, starts[0])
        system.rebound()
        wait = (self.shooting.origin - system.flow.time) % system.length
        if motion is None or (wait > 0.0 and not system.flow.advance(wait)):
            return None
        first = Approach(float(starts[0][-1]), starts[0][:-1].copy(), 0.0, speed)
        half = 0.5 * system.flow.silent[-1][1] * system.length
        turns = [a for a in motion.turns if abs(self._elapsed(first, a.time)) > half]
        return Motion(system.flow.state(), [first, *motion.impacts], turns)

    def _impact_map(self) -> FromImpact:
        return cast("FromImpact", self.coordinates.system)

    def _enter(
        self, motion: Motion, value: float, touch: Approach | None = None, *, with_impact: bool = False
    ) -> ContinuationPoint | str:
        """The first point in the coordinates for a motion."""
        # A `touch`, at which it grazes, becomes an impact, or is none any longer.
        impacts = [a for a in motion.impacts if a is not touch] + ([touch] if touch is not None and with_impact else [])
        start = touch if with_impact else min(impacts, key=lambda a: a.speed, default=None)
        turns = [a for a in motion.turns if a is not touch] + ([touch] if touch is not None and not with_impact else [])
        inner, length, period = self._listener().flow, self.shooting.space.length, self.shooting.period
        inner.reset(motion.start, time=self.shooting.origin)
        self.scale = float(np.hypot(length(motion.start), length(inner.velocity()) * period / TURN)) or 1.0
        self._choose(start, impacts, turns, value)
        shooting, starts = self.coordinates, motion.start if start is None else np.append(start.state, start.time)
        if not shooting.set_value(value):
            return shooting.status
        period = shooting.period
        result = correct(shooting, starts[None], period, value, tolerance=self.tolerance, iterations=10)
        run = result.last
        if run is None or (touch is None and not result.ok):
            return result.status
        self.lengths = size_of(shooting, run), run.period, self.lengths[2]
        ahead = self._direction(run, None)
        if ahead is None:
            return shooting.status
        opens = 1.0 if touch is None else self._opens(run, ahead, None if with_impact else touch)
        if np.isnan(opens):
            return f"the motion beside it fails: {self.shooting.status}"
        if opens < 0.0:
            ahead = backwards(ahead)
        return self._continuation_point(result, ahead)

    def _opens(self, run: ShootingRun, ahead: Direction, touch: Approach | None) -> float:
        """Change along a direction of the gap at a turning point, or of the closing speed at a start that grazes."""
        values = []
        for sign in (-PROBE, PROBE):
            starts, value = run.starts + sign * ahead.starts, run.value + sign * ahead.value
            motion = self._motion(starts, value)
            if motion is None or (touch is not None and not motion.turns):
                return np.nan
            if touch is None:
                values.append(motion.first.speed)
            else:
                values.append(min(motion.turns, key=lambda a: abs(self._elapsed(touch, a.time))).gap)
        return values[1] - values[0]

    def _elapsed(self, touch: Approach, time: float) -> float:
        """Time [s] between an approach and an instant of the period, the shorter way round."""
        period = self.shooting.period
        return (time - touch.time + 0.5 * period) % period - 0.5 * period

    def _choose(self, start: Approach | None, impacts: list[Approach], turns: list[Approach], value: float) -> None:
        """Unknowns from the impact `start` (None: state at the origin), and spans without impacts at turning points."""
        spans, self.from_impact = self._spans(start, impacts, turns), None
        if start is None:
            return
        inner = self._listener().copy()
        inner.silent = spans
        system = FromImpact(inner, start.state, start.time, self.shooting.times, self.scale)
        shooting = Shooting(self.shooting.label, system, period=None, angles=self.shooting.angles)
        shooting.parameter = self.shooting.parameter
        shooting.set_value(value)
        self.from_impact = shooting

    def _spans(self, start: Approach | None, impacts: list[Approach], turns: list[Approach]) -> Spans:
        """Silent spans at turning points and at the `start`, the last one, which the system itself hears."""
        period, times, spans, everything = self.shooting.period, self.shooting.times, [], [*impacts, *turns]
        for one in [*turns, *([start] if start is not None else [])]:
            others = [abs(self._elapsed(one, other.time)) for other in everything if other is not one]
            half = min(QUARTER * min(others, default=period), LONGEST * period)
            spans.append((((one.time - half) / period) % 1.0, 2.0 * half / period, times))
        self._listener().silent = tuple(spans[: len(turns)])
        return tuple(spans)

    # Points

    def _continuation_point(self, result: NewtonResult, ahead: Direction) -> ContinuationPoint | str:
        """The point of a branch, with the ordinary run over the period and the test functions of grazing."""
        run = result.last
        motion = None if run is None else self._motion(run.starts, run.value)
        if run is None or motion is None:
            return f"the motion: {self.shooting.status or self.coordinates.status}".rstrip(".")
        flow, speed = self._listener(), np.nan
        spans = flow.silent
        if self.from_impact is not None:
            speed = motion.first.speed
            flow.silent = spans if speed > 0.0 else self._impact_map().flow.silent
        ordinary = self.shooting.run(motion.start[None], self.shooting.period, run.value)
        if ordinary is None:
            flow.silent = spans
            return f"the motion over the period: {self.shooting.status}".rstrip(".")
        point = super()._continuation_point(NewtonResult(ordinary, result.residuals, result.ok, result.status), ahead)
        flow.silent = spans
        if not isinstance(point, ContinuationPoint):
            return point
        least = min((a.gap for a in motion.turns), default=np.inf)
        gaps = point.point.grazing | {GAP: least if motion.turns else np.nan}
        orbit = replace(point.point, grazing=gaps, impact_speeds=np.array([a.speed for a in motion.impacts]))
        return replace(point, run=run, tests=point.tests | {IMPACT: speed, TOUCH: least}, point=orbit)

    def grazing(self, event: BranchPoint) -> ShootingRun:
        """Run at grazing, in coordinates in which the surfaces just pass each other."""
        self.lengths = 1.0, 1.0, abs(self.span[1] - self.span[0])
        motion = self._actual(event)
        if motion is None:
            raise InputError(f"The motion at {event.value:.6g} fails: {self.shooting.status}")
        touch = min([*motion.impacts, *motion.turns], key=lambda a: abs(a.gap) + a.speed**2)
        point = self._enter(motion, event.value, touch)
        if not isinstance(point, ContinuationPoint):
            raise InputError(f"The motion at {event.value:.6g} fails: {point}")
        self._remember(point.run, touch, motion)
        return point.run

    def _remember(self, run: ShootingRun, touch: Approach, motion: Motion) -> None:
        """Keep phase of the touch and silent spans of a run, for neighbouring runs."""
        start = motion.first if self.from_impact is not None else None
        turns = motion.turns if touch in motion.turns else [*motion.turns, touch]
        spans = self._spans(start, [a for a in motion.impacts if a is not touch], turns)
        self.touches = [*self.touches, (run, touch.time / self.shooting.period, spans)]

    def listen_as(self, guess: ShootingRun) -> None:
        """Set the silent spans of an earlier run."""
        spans = next(spans for one, _, spans in self.touches if one is guess)
        self._listener().silent = spans if self.from_impact is None else spans[:-1]
        if self.from_impact is not None:
            self._impact_map().flow.silent = spans

    def least_gap(self, run: ShootingRun, guess: ShootingRun) -> float:
        """Gap of a run at the turning point that touches in an earlier one, its `guess`; NaN: none."""
        motion, period = self._motion(run.starts, run.value), self.shooting.period
        if motion is None or not motion.turns:
            return float("nan")
        phase = next(phase for one, phase, _ in self.touches if one is guess)
        touch = min(motion.turns, key=lambda a: abs((a.time / period - phase + 0.5) % 1.0 - 0.5))
        self._remember(run, touch, motion)
        return touch.gap

    # Steps and passages

    def _step(self, last: ContinuationPoint, size: float) -> tuple[ContinuationPoint | None, float, str]:
        following, next_size, status = super()._step(last, size)
        self.pending = []
        if following is None:
            return following, next_size, status
        crossed = [n for n in (IMPACT, TOUCH) if -np.inf < last.tests[n] * following.tests[n] < 0.0]
        if crossed:
            located = {name: self._located(last, following, name) for name in crossed}
            name = min(crossed, key=lambda n: located[n][0])
            return self._passed(last, *located[name], name)
        motion = self._actual(following.point)
        if motion is None or len(motion.impacts) != len(last.point.impact_speeds):
            if size * QUARTER >= self.bounds[2]:
                return self._step(last, size * QUARTER)
            return None, size, f"Ended at {last.point.value:.6g}: the number of impacts changes, but not by one."
        self.pending = super()._events(last, following)
        following, reason = self._at_the_slowest(following, motion)
        return following, next_size, reason or status

    def _at_the_slowest(self, point: ContinuationPoint, motion: Motion) -> tuple[ContinuationPoint | None, str]:
        """A point in the coordinates of its slowest impact; None, and the reason, if the orbit is not found there."""
        slowest, value = min(motion.impacts, key=lambda a: a.speed, default=None), point.point.value
        if slowest is None or abs(self._elapsed(slowest, float(point.run.starts[0, -1]))) < SAME * self.shooting.period:
            self._choose(slowest, motion.impacts, motion.turns, value)
            return point, ""
        other = self._enter(motion, value)
        if not isinstance(other, ContinuationPoint):
            return None, f"Ended at {value:.6g}: {other}"
        if other.ahead.value * point.ahead.value >= 0.0:
            return other, ""
        orbit = replace(other.point, rising=-other.point.rising)  # the parameter goes on with the sign of the point
        tests = other.tests | {orbits.FOLD: -other.tests[orbits.FOLD]}
        return replace(other, ahead=backwards(other.ahead), point=orbit, tests=tests), ""

    def _actual(self, point: BranchPoint) -> Motion | None:
        """The motion of an orbit, with no silent spans."""
        self.shooting.set_value(point.value)
        flow = self._listener().copy()
        flow.silent = ()
        return self._from(flow, point.state)

    def _passed(
        self, last: ContinuationPoint, position: float, grazing: ContinuationPoint, name: str
    ) -> tuple[ContinuationPoint | None, float, str]:
        """The first orbit behind grazing, the size of the next step, and the reason if there is none."""
        value = grazing.run.value
        near = self._orbit_at(last, (1.0 - CLOSE_TO_GRAZING) * position)
        if isinstance(near, ContinuationPoint):
            self.pending = super()._events(last, near)
        motion = self._motion(grazing.run.starts, value)
        if motion is None:
            return None, self.bounds[0], f"Ended at grazing, {value:.6g}: {self.shooting.status}"
        touch = motion.first if name == IMPACT else min(motion.turns, key=lambda a: abs(a.gap))
        begin = self._enter(motion, value, touch, with_impact=name == TOUCH)
        smooth = begin if name == IMPACT else grazing
        if isinstance(smooth, ContinuationPoint):
            self.pending = [*self.pending, replace(smooth.point, kind=orbits.GRAZING, value=float(value))]
        if not isinstance(begin, ContinuationPoint):
            return None, self.bounds[0], f"Ended at grazing, {value:.6g}: {begin}"
        first = self._orbit_at(begin, CLOSE_TO_GRAZING * self.bounds[0])
        if not isinstance(first, ContinuationPoint):
            return None, self.bounds[0], f"Ended at grazing, {value:.6g}: {first}"
        pending = self.pending
        following, size, status = self._step(first, self.bounds[0])
        self.pending = [*pending, *self.pending]
        return following, size, status

    def _branch(self, points: list[ContinuationPoint], events: list[BranchPoint], *, ok: bool, status: str) -> Branch:
        self._listener().silent = ()  # orbits of the branch are those of the system itself
        return super()._branch(points, events, ok=ok, status=status)

    def _events(self, old: ContinuationPoint, new: ContinuationPoint) -> list[BranchPoint]:  # noqa: ARG002
        return self.pending

    def _grazing_at_the_end(self, points: list[ContinuationPoint]) -> list[BranchPoint]:  # noqa: ARG002
        return self.pending


def backwards(ahead: Direction) -> Direction:
    """The opposite direction."""
    return Direction(-ahead.starts, -ahead.period, -ahead.value)
