"""Sections of flows: crossings located to round-off, stroboscopic and Poincare maps, their points as tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np

from flexmb import arguments, checks
from flexmb.dynamics.jobs.executors import tell_stopped
from flexmb.dynamics.jobs.progress import ProgressBar
from flexmb.dynamics.systems.dynamics import ContinuousFlow, Dynamics, OfFlow, Parameters, State, as_dynamics
from flexmb.dynamics.systems.given import state_of
from flexmb.dynamics.verdict import Verdict, judge
from flexmb.errors import InputError
from flexmb.late import xr

if TYPE_CHECKING:
    from flexmb.engine.newmark.method import Newmark
    from flexmb.run.simulate import Step

ROUNDS = 200  # largest number of trials of a search for a crossing
HALVINGS = 40  # largest number of halvings of a step in the search for a point before a crossing
DOWN, UP = -1, 1  # directions of a crossing, and sides of the level
# Height of the cubic's minimum, over the lower end of the step, below which the step is searched for two crossings.
CLOSE = 0.1


class Bracket(NamedTuple):
    """Times between which a crossing lies [s], counted from a snapshot with tangent vectors (size, k) or None."""

    # The height before the crossing, at the time `near`, is `value`.
    before: Any
    tangents: np.ndarray | None
    near: float
    value: float
    far: float


@dataclass
class Height:
    """Height of a signal over a level, and the side of the level before a crossing."""

    flow: ContinuousFlow
    value: Callable[[], float]  # function that returns the present height
    # function that returns the rate of the height [1/s]; None: the rate is costly, and two crossings in one step may be
    # missed
    rate: Callable[[], float] | None
    side: int  # UP or DOWN

    def at(self, before: Any, duration: float) -> float:
        """Height a time [s] after a snapshot; the flow stays there."""
        self.flow.restore(before)
        self.flow.advance(duration)
        return self.value()

    def left(self, value: float) -> bool:
        """Whether a height `value` lies on the other side of the level; a height of 0 does not."""
        return value * self.side < 0.0


def stride(height: Height, limit: float, tangents: np.ndarray | None) -> Bracket | None:
    """Advance the flow by one step, up to `limit` [s]; returns the bracket of a crossing in that step, or None."""
    # A step that ends with a jump is searched up to the jump, and then for a crossing by it. After a failure the flow
    # has the status. Tangent vectors (size, k) are advanced in place.
    flow, saved = height.flow, None if tangents is None else tangents.copy()
    before, start, old = flow.snapshot(), flow.time, height.value()
    old_rate = None if height.rate is None else height.rate()
    if not flow.take_step(limit, tangents):
        return None
    size, inner = flow.time - start, flow.before_jump()
    if inner is None:
        return _within(height, Bracket(before, saved, 0.0, old, size), old_rate)
    after = flow.snapshot()
    flow.restore(inner)
    short = size - 16.0 * float(np.spacing(flow.time))  # a time before the jump
    found = _within(height, Bracket(before, saved, 0.0, old, short), old_rate) if short > 0.0 else None
    flow.restore(after)
    return found or (Bracket(before, saved, 0.0, old, size) if height.left(height.value()) else None)


def _within(height: Height, step: Bracket, old_rate: float | None) -> Bracket | None:
    """Bracket of a crossing in a step, at whose end the flow stands."""
    # A step whose ends lie on the same side is examined if the cubic through heights and rates at both ends comes near
    # the level.
    old, new, side = step.value, height.value(), height.side
    if height.left(new):
        near, value = 0.0, 0.0 if height.left(old) else old
        for k in range(HALVINGS if height.left(old) else 0):  # it begins with an impact: a time before the crossing
            time = 0.5 ** (k + 1) * step.far
            ahead = height.at(step.before, time)
            if not height.left(ahead):
                near, value = time, ahead
                break
        return step._replace(near=near, value=value)
    dip = 0.0
    if height.rate is not None and old_rate is not None and not height.left(old):
        dip = turning_point(side * old, side * old_rate, side * new, side * height.rate(), step.far)
    if dip == 0.0:
        return None
    after, inside = height.flow.snapshot(), height.at(step.before, dip)
    height.flow.restore(after)
    return step._replace(far=dip) if height.left(inside) else None


def locate(height: Height, bracket: Bracket) -> float:
    """Put the flow on the crossing; returns the time from the snapshot to the crossing [s]."""
    # The crossing is the first time after it that the clock of the flow can represent. Regula falsi with the Illinois
    # modification, and bisection every fourth time (M. Dowell, P. Jarratt, BIT 11 (1971) 168). Each trial is a step of
    # the flow from the snapshot, so the result is a point of the flow and not of an interpolation.
    flow, before = height.flow, bracket.before
    flow.restore(before)
    a, b, fa = bracket.near, bracket.far, bracket.value
    least = 4.0 * float(np.spacing(abs(flow.time) + b))
    fb, moved_last = height.at(before, b), 0
    for count in range(ROUNDS):
        if height.left(fb) or not flow.ok:
            break  # a step with tangent vectors may end a little later than a step without
        b += 2.0**count * max(1e-9 * bracket.far, least)
        fb = height.at(before, b)
    for count in range(ROUNDS):
        if b - a <= least or b <= flow.shortest or not flow.ok:
            break
        x = 0.5 * (a + b) if count % 4 == 3 or fa == fb else b - fb * (b - a) / (fb - fa)
        x = min(max(x, a + 0.5 * least, flow.shortest), b - 0.5 * least)
        value = height.at(before, x)
        if height.left(value):
            b, fb, fa, moved_last = x, value, 0.5 * fa if moved_last == DOWN else fa, DOWN
        else:
            a, fa, fb, moved_last = x, value, 0.5 * fb if moved_last == UP else fb, UP
    if flow.ok:
        height.at(before, b)
    return b


def carry(flow: ContinuousFlow, bracket: Bracket, duration: float, tangents: np.ndarray) -> None:
    """Advance `tangents` (size, k) from the snapshot of a bracket to the present state of the flow, on the crossing."""
    # `duration` is the time from the snapshot to the crossing [s].
    point = flow.snapshot()
    tangents[:] = bracket.tangents
    flow.restore(bracket.before)
    if flow.advance(duration, tangents):
        flow.restore(point)


def turning_point(f0: float, r0: float, f1: float, r1: float, size: float) -> float:
    """Time of the minimum of a cubic in a step of `size` [s], if the minimum comes near the level; else 0."""
    # f0, f1 are heights > 0 at both ends of the step, r0, r1 their rates.
    if not r0 < 0.0 < r1:
        return 0.0
    # f(s) = f0 + r0 s + c s^2 + d s^3
    c, d = (3.0 * (f1 - f0) / size - 2.0 * r0 - r1) / size, (r0 + r1 - 2.0 * (f1 - f0) / size) / size**2
    below = c + np.sqrt(c * c - 3.0 * r0 * d) if c * c >= 3.0 * r0 * d else 0.0
    s = -r0 / below if below > 0.0 else 0.5 * size
    if not 0.0 < s < size:
        return 0.0
    return float(s) if f0 + s * (r0 + s * (c + s * d)) < CLOSE * min(f0, f1) else 0.0


class SectionOfFlow(OfFlow):
    """A map of a flow, which stands at the last point, with the signals and parameters of the flow."""

    def _observe(self, flow: Any) -> None:
        """Take a flow in time, with its name and signals."""
        if not isinstance(flow, ContinuousFlow):
            text = f"{type(self).__name__}: flow is {type(flow).__name__}"
            raise InputError(f"{text}; it must be a flow in time, as MechanismFlow(mechanism) or ODE.")
        self.flow, self.name = flow, flow.name
        self.names, self.units = flow.names, flow.units

    underlying: Any = property(attrgetter("flow"))
    remarks: Any = property(attrgetter("flow.remarks"))

    def another_start(self, distance: float, seed: int) -> np.ndarray:
        start: np.ndarray = self.state()
        start[: self.flow.size] = self.flow.another_start(distance, seed)
        return start


class StroboscopicMap(SectionOfFlow):
    """The map of a flow over one period of its drives.

    Parameters
    ----------
    flow : the flow, which the map advances.  Periods count from its present time.
    period : the period [s]; None: the period of the flow, also after `reset` with other parameters.

    Raises
    ------
    InputError : a map; no period given for a flow without one, or for drives without a common period; a period that
        is not > 0.

    Examples
    --------
    >>> import flexmb as fm
    >>> driven = fm.chaos.ODE(lambda t, x: [x[1], -x[0] - x[1]], [1.0, 0.0], period=2.0)
    >>> strobe = fm.chaos.StroboscopicMap(driven)
    >>> strobe.advance(3), strobe.time, driven.time
    (True, 3.0, 6.0)
    """

    unit = "periods"
    period: float

    def __init__(self, flow: ContinuousFlow, period: float | None = None) -> None:
        self._observe(flow)
        self.declared = None if period is None else checks.positive(self._label, "period", period, "s")
        self.origin, self.period = flow.time, self._derived()
        self.ok, self.status = flow.ok, flow.status

    @property
    def time(self) -> float:
        return float(np.round((self.flow.time - self.origin) / self.period, 9))

    def reset(self, state: State = None, *, time: float = 0.0, parameters: Parameters = None) -> None:
        count = checks.number(self._label, "time", time, "periods")
        if parameters:
            self.flow.reset(parameters=parameters)
            self.period = self._derived()
        self.flow.reset(state, time=count * self.period)
        self.names, self.units, self.origin = self.flow.names, self.flow.units, 0.0
        self.ok, self.status = self.flow.ok, self.flow.status

    def advance(self, duration: float, tangents: np.ndarray | None = None) -> bool:
        periods = checks.count(self._label, "duration", duration, 0)
        first = round(self.time)
        for k in range(first + 1, first + periods + 1):
            if not self.flow.advance(self.origin + k * self.period - self.flow.time, tangents):
                break
        self.ok, self.status = self.flow.ok, self.flow.status
        return self.ok

    on_manifold: Any = property(attrgetter("flow.on_manifold"))

    def _derived(self) -> float:
        if self.declared is not None:
            return self.declared
        if self.flow.period is None:
            advice = "Give period= (in seconds), or take a section by a signal: SectionMap(flow, signal)."
            raise InputError(f"{self._label}: {self.flow.no_period()}. {advice}")
        return self.flow.period


def strobe_of(caller: str, system: Dynamics, period: float | None) -> Dynamics:
    """Stroboscopic map of a flow, by default with the flow's own period [s]; a map is returned as it is."""
    if system.underlying is system:
        return StroboscopicMap(system.underlying, period)
    if period is not None:
        raise InputError(f"{caller} {system.name!r}: period= belongs to a flow; this is a map. Leave it out.")
    return system


# Sides of the level on which a section point arrives, by the name of the direction.
DIRECTIONS = {"up": (UP,), "down": (DOWN,), "both": (DOWN, UP)}
# Longest time without a crossing: in periods of the flow, or without a period in multiples of `pace`.
PERIODS, PACES = 1000.0, 1e5
AHEAD = 1e-9  # distance from the level, as a fraction of a step, below which a point counts as lying on the level


class SectionMap(SectionOfFlow):
    """The map of a flow from one crossing of a level to the next (Poincare map).

    Crossings are located to round-off on the steps of the flow, and so do not depend on saved instants.  A point of the
    section of a driven flow is (state, time [s]), of another flow the state alone.  Tangent vectors are projected onto
    the section:  dx -= v (n . dx) / (n . v), with the velocity v of the flow and the gradient n of the signal.  With a
    driven flow they include the difference of the times of crossing.

    Parameters
    ----------
    flow : the flow, which the map advances.
    signal : name of a signal of the flow.
    level : level of the section [unit of the signal].
    direction : "up", "down" or "both".
    limit : time without a crossing after which `advance` ends with a status [s]; None: 1000 periods of the flow, or
        1e5 steps of a flow without a period.

    Raises
    ------
    InputError : a map, an unknown signal or direction, a level that is no number, a limit that is not > 0.

    Examples
    --------
    >>> import flexmb as fm
    >>> oscillator = fm.chaos.ODE(lambda t, x: [x[1], -x[0]], [1.0, 0.0], names=["x", "v"])
    >>> section = fm.chaos.SectionMap(oscillator, "x", direction="down")
    >>> section.advance(1), round(oscillator.time, 9)
    (True, 1.570796327)
    """

    unit = "crossings"

    def __init__(
        self, flow: ContinuousFlow, signal: str, *, level: float = 0.0, direction: str = "up",
        limit: float | None = None,
    ) -> None:  # fmt: skip
        self._observe(flow)
        self.signal, self.direction = signal, checks.one_of(self._label, "direction", direction, DIRECTIONS)
        self.level = checks.number(self._label, "level", level)
        self.declared = None if limit is None else checks.positive(self._label, "limit", limit, "s")
        self._count = 0
        self._take_over()

    @property
    def time(self) -> float:
        return float(self._count)

    @property
    def size(self) -> int:
        return self.flow.size + self.flow.driven

    @property
    def dimension(self) -> int:
        return self.flow.dimension - (not self.flow.driven)

    @property
    def cycles(self) -> Mapping[int, float]:
        """Angles of the flow, and the time of crossing of a flow with a period."""
        period = self.flow.period if self.flow.driven else None
        return {**self.flow.cycles, **({} if period is None else {self.flow.size: period})}

    @property
    def weights(self) -> np.ndarray:
        """Weights of the flow and, for a driven flow, of the time of crossing.

        A difference of times is weighted by the speed of the flow at the last reset.
        """
        return np.append(self.flow.weights, self._time_weight) if self.flow.driven else self.flow.weights

    def state(self) -> np.ndarray:
        return np.append(self.flow.state(), self.flow.time) if self.flow.driven else self.flow.state()

    def reset(self, state: State = None, *, time: float = 0.0, parameters: Parameters = None) -> None:
        count = checks.count(self._label, "time", time, 0)
        if state is None:
            self.flow.reset(parameters=parameters)
        else:
            text = f"{self._label}{' (state of the flow, time [s])' if self.flow.driven else ''}"
            point = state_of(text, state, self.size)
            now = float(point[-1]) if self.flow.driven else 0.0
            self.flow.reset(point[: self.flow.size], time=now, parameters=parameters)
        self._count = count
        self.names, self.units = self.flow.names, self.flow.units
        self._take_over()

    def advance(self, duration: float, tangents: np.ndarray | None = None) -> bool:
        for _ in range(checks.count(self._label, "duration", duration, 0)):
            if not self.ok:
                break
            T, n = None, self.flow.size
            if tangents is not None:  # differences at the present time of neighbours that start at different times
                late = np.outer(self.flow.velocity(), tangents[n]) if self.flow.driven else 0.0
                T = np.array(tangents[:n] - late)
            while self._to_next_crossing(T) and self._side not in DIRECTIONS[self.direction]:
                pass
            if not self.ok:
                break
            self._count += 1
            if T is not None and tangents is not None:
                self._project(T, tangents)
        return self.ok

    def on_manifold(self, tangents: np.ndarray) -> np.ndarray:
        T, n = np.array(tangents, dtype=np.float64), self.flow.size
        later = np.outer(self.flow.velocity(), T[n]) if self.flow.driven else 0.0
        T[:n] = self.flow.on_manifold(T[:n] - later) + later
        return T

    def go_to_section(self) -> bool:
        near = 1e-9 * max(abs(self.level), self.flow.pace * abs(self.flow.rate(self._signal)))
        return abs(self._height()) <= near or self.advance(1)

    def on_section(self, tangents: np.ndarray) -> np.ndarray:
        n, found = self.flow.size, np.array(tangents)
        if self.flow.rate(self._signal) != 0.0:
            late = np.outer(self.flow.velocity(), found[n]) if self.flow.driven else 0.0
            self._project(found[:n] - late, found)
        return found

    def _height(self) -> float:
        return float(self.flow.observe()[self._signal]) - self.level

    def _take_over(self) -> None:
        """Take over the state of the flow: side of the level, limit of the time, weight of a difference of times."""
        flow = self.flow
        self.ok, self.status = flow.ok, flow.status
        self._signal = flow.number_of(self._label, self.signal)
        self.limit = self.declared or (PACES * flow.pace if flow.period is None else PERIODS * flow.period)
        height, rate = self._height(), flow.rate(self._signal)
        if flow.resolution is not None and abs(height) <= flow.resolution[self._signal] and rate != 0.0:
            height = 0.0  # a projected state is not exactly on the level
        self._side = UP if height + AHEAD * flow.pace * rate >= 0.0 else DOWN
        self._time_weight = float(flow.weights @ flow.velocity() ** 2) or 1.0

    def _project(self, T: np.ndarray, tangents: np.ndarray) -> None:
        """Write into `tangents` the differences at the crossing, for differences T at one time."""
        rate = self.flow.rate(self._signal)
        if rate == 0.0:
            self.ok, self.status = False, f"The signal {self.signal!r} touches its level at t = {self.flow.time:.6g} s."
            return
        late = -self.flow.slopes(self._signal, T) / rate
        tangents[: self.flow.size] = T + np.outer(self.flow.velocity(), late)
        if self.flow.driven:
            tangents[-1] = late

    def _to_next_crossing(self, T: np.ndarray | None) -> bool:
        """Advance to the next crossing of the level; returns whether there was one."""
        flow, began = self.flow, self.flow.time
        crossed = flow.seek(self._signal, self.level, self._side, began + self.limit) if T is None else None
        if crossed is not None:
            return self._arrived(crossed, began)
        rate = (lambda: flow.rate(self._signal)) if flow.has_cheap_rate(self._signal) else None
        height = Height(flow, self._height, rate, self._side)
        bracket: Bracket | None = None
        while bracket is None and flow.ok and flow.time < began + self.limit:
            bracket = stride(height, began + self.limit, T)
        if bracket is not None and flow.ok:
            duration = locate(height, bracket)
            if T is not None and flow.ok:
                carry(flow, bracket, duration, T)
        return self._arrived(bracket is not None, began)

    def _arrived(self, crossed: bool, began: float) -> bool:
        """Status behind a crossing, or at the end of a search that began at a time [s]; whether there was one."""
        flow = self.flow
        if crossed and flow.ok:
            self._side = -self._side
        self.ok, self.status = flow.ok and crossed, flow.status
        if flow.ok and not crossed:
            text = f"{self.signal!r} did not cross {self.level:g} within {self.limit:g} s after t = {began:.6g} s"
            self.status = f"{text}; it may stay on one side. Choose another level, or a longer limit=."
        return self.ok


@dataclass(frozen=True, eq=False)
class SectionSignals:
    """Names, units and resolution of the signals of section points."""

    name: str
    names: tuple[str, ...]  # names and units (m,) of the signals
    units: tuple[str, ...]
    telling: tuple[int, ...]  # numbers of the signals on which a verdict rests
    # differences (m,) of the signals that errors of the integration can make; None: 1e-6 of their sizes
    resolution: np.ndarray | None
    dimension: int = 0  # number of exponents of the system; 0: unknown

    @classmethod
    def of(cls, system: Dynamics) -> Self:
        """Names, units and resolution of the signals that `system` observes."""
        return cls(system.name, system.names, system.units, system.telling, system.resolution, system.dimension)

    def verdict(
        self, points: np.ndarray, signals: Sequence[str] = (), exponent: float | None = None, error: float | None = None
    ) -> Verdict:
        """Verdict on points (n, m) of all signals, by the given signals or, without any, by the signals `telling`."""
        # The largest exponent and its error are None or not finite where they are unknown.
        value, band = (x if x is not None and np.isfinite(x) else None for x in (exponent, error))
        known = [checks.one_of(f"verdict on {self.name!r}", "signal", name, self.names) for name in signals]
        columns = [self.names.index(name) for name in known] or list(self.telling)
        precision: dict[str, Any] = {"units": [self.units[k] for k in columns]}
        if self.resolution is not None:
            precision |= {"floor": 1.0, "sizes": self.resolution[columns]}
        return judge(points[:, columns], [self.names[k] for k in columns], exponent=value, error=band, **precision)


@arguments.checked
def stroboscopic(
    system: Any, *, keep: int, skip: int = 0, period: float | None = None, step: Step | None = None,
    method: Newmark | None = None, progress: bool = False,
) -> xr.Dataset:  # fmt: skip
    """States of a driven system once a period.

    Parameters
    ----------
    system : a mechanism, which starts from its reference configuration; or a flow or map, which continues from its
        present state and stays at the last point.  The points of a map are its iterations.
    keep : number of points.
    skip : periods before the first point.
    period : the period [s]; None: the common period of the drives.
    step, method : for a mechanism only, see `simulate`.
    progress : whether a progress bar with the remaining time is shown.

    Returns
    -------
    xarray.Dataset : dimension "period"; coordinates `period` (number, from `skip` on) and `time` [s]; a variable for
        each signal.  Attributes: name, kind "stroboscopic", period [s] (NaN for a map), skip, ok, status.  After a
        failure ok is 0, and the dataset holds the points before the failure.

    Raises
    ------
    InputError : numbers that are not whole, no point to keep, a system without a period (see `StroboscopicMap`).
    ModelError, AssemblyError, KernelError : a mechanism that cannot start.

    Examples
    --------
    >>> import flexmb as fm
    >>> logistic = fm.chaos.Map(lambda x, r: r * x * (1.0 - x), [0.3], parameters={"r": 3.2})
    >>> points = fm.stroboscopic(logistic, skip=1000, keep=4)
    >>> points.x0.values.round(4)
    array([0.7995, 0.513 , 0.7995, 0.513 ])
    """
    flow = as_dynamics("stroboscopic", system, period=period, step=step, method=method)
    strobe = strobe_of("stroboscopic", flow, period)
    return _collected(strobe, {"kind": "stroboscopic", "period": _length(strobe)}, skip, keep, progress)


def section(
    system: Any, signal: str, *, keep: int, skip: int = 0, level: float = 0.0, direction: str = "up",
    limit: float | None = None, period: float | None = None, step: Step | None = None, method: Newmark | None = None,
    progress: bool = False,
) -> xr.Dataset:  # fmt: skip
    """States of a system at which a signal crosses a level (Poincare section), located on the steps of the solver.

    Parameters
    ----------
    system : a mechanism, which starts from its reference configuration; or a flow, which continues from its present
        state and stays on the last crossing.
    signal : name of the signal, one of `names` of the flow; of a mechanism as in `sol[...]`.
    keep : number of crossings.
    skip : crossings before the first one that is kept.
    level : level of the section [unit of the signal].
    direction : "up", "down" or "both".
    limit : time without a crossing after which the search ends with a status [s]; None: see `SectionMap`.
    period : for a mechanism without periodic drives: approximate period of its motion [s].
    step, method : for a mechanism only, see `simulate`.
    progress : whether a progress bar with the remaining time is shown.

    Returns
    -------
    xarray.Dataset : as of `stroboscopic`, with the dimension "crossing", the kind "section", and the further attributes
        signal, level and direction.

    Raises
    ------
    InputError : a map; an unknown signal or direction; numbers that are not whole, no point to keep.
    ModelError, AssemblyError, KernelError : a mechanism that cannot start.

    Examples
    --------
    >>> import flexmb as fm
    >>> oscillator = fm.chaos.ODE(lambda t, x: [x[1], -x[0]], [1.0, 0.0], names=["x", "v"])
    >>> points = fm.chaos.section(oscillator, "v", keep=2)
    >>> points.time.values.round(6)
    array([3.141593, 9.424778])
    """
    flow = as_dynamics("section", system, period=period, step=step, method=method)
    if flow.underlying is not flow:
        raise InputError(f"section {flow.name!r}: a map has no crossings. Use stroboscopic(...).")
    crossings = SectionMap(flow.underlying, signal, level=level, direction=direction, limit=limit)
    about = {"kind": "section", "period": _length(flow), "signal": signal, "level": crossings.level}
    return _collected(crossings, {**about, "direction": direction}, skip, keep, progress)


def _length(system: Dynamics) -> float:
    return np.nan if system.period is None else float(system.period)


def _collected(system: Dynamics, about: dict[str, Any], skip: int, keep: int, progress: bool) -> xr.Dataset:
    """Table of `keep` points after `skip` points; the present state is the first stroboscopic point if skip is 0."""
    strobe, label = about["kind"] == "stroboscopic", f"{about['kind']} {system.name!r}"
    dimension = "period" if strobe else "crossing"
    skip, keep = checks.count(label, "skip", skip, 0), checks.count(label, "keep", keep)
    progress_bar = ProgressBar(system.name, float(skip + keep), shown=progress, of=f"{dimension}s")
    times, values = [], []
    for k in range(skip + keep):
        if (k > 0 or not strobe) and not system.advance(1):
            break
        progress_bar.update(1)
        if k >= skip:
            times.append(system.clock)
            values.append(system.observe())
    progress_bar.close()
    rows = np.array(values).reshape(len(times), len(system.names))
    units = "" if system.underlying is None else "s"
    status = system.status if len(times) < keep else f"{keep} {dimension}s, after {skip} that were skipped."
    if len(times) < keep:
        tell_stopped(label, status)
    about = {"name": system.name, **about, "skip": skip, "ok": int(len(times) == keep), "status": status}
    signals = enumerate(zip(system.names, system.units, strict=True))
    data = {name: (dimension, rows[:, k], {"units": unit}) for k, (name, unit) in signals}
    numbers: Any = (dimension, np.arange(skip, skip + len(times)), {})
    return xr.Dataset(data, {dimension: numbers, "time": (dimension, np.array(times), {"units": units})}, about)
