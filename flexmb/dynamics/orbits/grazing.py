"""Continuation of orbits with impacts of rigid surfaces, through grazing."""

from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np

from flexmb.dynamics.orbits.continuation import Continuation, ContinuationPoint
from flexmb.dynamics.orbits.orbit_newton import Direction, NewtonResult, correct
from flexmb.dynamics.orbits.periodic_orbit import FOLD, GRAZING, Branch, BranchPoint, size_of
from flexmb.dynamics.orbits.shooting import TURN, Shooting, ShootingRun
from flexmb.dynamics.systems.impact_ode import Approach, FromImpact, ImpactODE, Spans, approaches
from flexmb.errors import InputError

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
        speeds = np.array([a.speed for a in motion.impacts])
        gaps = point.point.grazing | {GAP: least if motion.turns else np.nan}
        orbit = replace(point.point, grazing=gaps, impact_speeds=speeds)
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
        tests = other.tests | {FOLD: -other.tests[FOLD]}
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
            self.pending = [*self.pending, replace(smooth.point, kind=GRAZING, value=float(value))]
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
