"""Ordinary differential equations with impacts: smooth flow, jumps of the state, saltation matrices."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, Self

import numpy as np

from flexmb import checks
from flexmb.dynamics.sections import UP, Height, carry, locate, stride
from flexmb.dynamics.systems.differences import STEP, central_differences
from flexmb.dynamics.systems.dynamics import ContinuousFlow, OfFlow, Parameters, State
from flexmb.dynamics.systems.given import ODE, compiled_motion, state_of
from flexmb.errors import InputError
from flexmb.late import scipy

Spans = tuple[tuple[float, float, int], ...]  # spans of time: begin and length, as fractions of so many periods
PILE = 1e-12  # time between two impacts, over the time of the run or a step, below which impacts pile up (chatter)


class ImpactODE(OfFlow, ContinuousFlow):
    """A flow whose state jumps whenever a gap closes.

    Let x- be the state before and x+ = jump(t, x-) the state after an impact, f the rates, n the gradient of the gap,
    and s the rate of the gap just before the impact.  Small differences jump by the saltation matrix
    S = J + (f+ - J f- - dj/dt) n^T / s,  J = d jump / dx
    (M. di Bernardo et al., Piecewise-smooth Dynamical Systems, Springer 2008, section 2.5).

    Parameters
    ----------
    ode : motion between impacts; this flow advances it.
    gap : gap(t, x, **parameters) -> distance from the wall, > 0 in flight.
    jump : jump(t, x, **parameters) -> state (size,) after an impact.

    Raises
    ------
    InputError : another kind of flow; a start behind the wall; a jump that returns no state.

    Notes
    -----
    Impacts are located to round-off.  A run in which impacts pile up (chatter) ends with a status, because the sticking
    motion afterwards is another system.  If the functions of `ode`, `gap` and `jump` are all under `@numba.njit`, the
    motion runs in compiled code (see `ODE`).  A grazing impact has no tangent: the saltation matrix grows like the
    inverse of the approach speed.

    Examples
    --------
    >>> import flexmb as fm
    >>> fall = fm.chaos.ODE(lambda t, x: [x[1], -1.0], [0.5, 0.0], names=["height", "speed"])
    >>> ball = fm.chaos.ImpactODE(fall, gap=lambda t, x: x[0], jump=lambda t, x: [x[0], -0.5 * x[1]])
    >>> ball.advance(1.5), ball.state().round(9)  # hits at t = 1 with speed -1
    (True, array([0.125, 0.   ]))
    """

    flow: ODE
    _last: float  # instant of the last impact [s], and the state (size,) before it
    _before: np.ndarray
    _unhit: Any = None  # snapshot before the impact with which the last step ended
    silent: Spans = ()  # spans in which surfaces pass through each other
    time: Any = property(attrgetter("flow.time"))
    pace: Any = property(attrgetter("flow.pace"))
    velocity: Any = property(attrgetter("flow.velocity"))
    rate: Any = property(attrgetter("flow.rate"))
    slopes: Any = property(attrgetter("flow.slopes"))

    def __init__(self, ode: ODE, *, gap: Callable[..., float], jump: Callable[..., Any]) -> None:
        checks.instance("ImpactODE", "ode", ode, ODE, "an ODE(...), the motion between impacts")
        self.flow, self.gap, self.jump = ode, gap, jump
        self._motion = compiled_motion(ode.method, ode.start, ode.parameters, ode.function, gap, jump)
        if self._motion is not None:
            self._motion.take(ode.parameters)
        self.name, self.names, self.units = ode.name, ode.names, ode.units
        self._check_start()
        state_of(f"{self._label}: jump", jump(ode.time, ode.state(), **ode.parameters), ode.size)

    @property
    def _label(self) -> str:
        return f"ImpactODE {self.name!r}"

    @property
    def ode(self) -> ODE:
        """The motion between impacts."""
        return self.flow

    def reset(self, state: State = None, *, time: float = 0.0, parameters: Parameters = None) -> None:
        self.flow.reset(state, time=time, parameters=parameters)
        if parameters and self._motion is not None:
            self._motion.take(self.parameters)
        if state is None and parameters:  # a start given later may be in flight
            self._start()
        else:
            self._check_start()

    def advance(self, duration: float, tangents: np.ndarray | None = None) -> bool:
        limit = self.time + checks.positive(self._label, "duration", duration, "s")
        if tangents is None and self._is_compiled:
            self._run(limit)
        while self.ok and self.time < limit:
            self.take_step(limit, tangents)
        return self.ok

    def take_step(self, limit: float, tangents: np.ndarray | None = None) -> bool:
        if not self.ok:
            return False
        if tangents is None and self._is_compiled:
            self._run(limit, single=True)
            return self.ok
        is_silent, until = self._span()
        limit = min(limit, until)
        if is_silent:
            self.flow.take_step(limit, tangents)
            self.ok, self.status = self.flow.ok, self.flow.status
            return self.ok
        height = Height(self.flow, self.gap_now, self.rate_of_gap, UP)
        self._unhit = None
        was_behind = height.left(self.gap_now())  # by round-off, after an impact
        bracket = stride(height, limit, tangents)
        if bracket is not None and self.flow.ok:
            stuck = was_behind and bracket.near == 0.0
            if stuck and height.left(height.at(bracket.before, bracket.far)) and self.rate_of_gap() > 0.0:
                return self.ok  # it is about to leave the wall
            duration = 0.0 if stuck else locate(height, bracket)
            if stuck or self.time - self._last < PILE * max(abs(self.time), self.pace):
                self.ok, self.status = False, f"Impacts pile up at t = {self.time:.6g} s: the gap stays closed."
                return False
            self._last, self._before = self.time, self.state()
            if tangents is not None and self.flow.ok:
                carry(self.flow, bracket, duration, tangents)
            if self.flow.ok:
                self._unhit = self.snapshot()
                self._hit(tangents)
        self.ok, self.status = self.flow.ok, self.flow.status
        return self.ok

    def seek(self, signal: int, level: float, side: int, limit: float) -> bool | None:
        return self._run(limit, section=(signal, level, side)) if self._is_compiled and self.ok else None

    @property
    def _is_compiled(self) -> bool:
        return self._motion is not None and self._motion.usable and not self.silent

    def _run(self, limit: float, **options: Any) -> bool:
        """Advance in compiled code; whether a section was met."""
        motion: Any = self._motion
        motion.last = self._last
        crossed: bool = motion.run(self.flow, limit, **options)
        if motion.last != self._last:
            self._last, self._before = motion.last, motion.before
        self.ok, self.status = self.flow.ok, self.flow.status
        return crossed

    def copy(self) -> Self:
        other = super().copy()
        other._motion = self._motion and self._motion.copy()
        return other

    def snapshot(self) -> Any:
        return self.flow.snapshot(), self.ok, self.status, self._last

    def restore(self, snapshot: Any) -> None:
        inner, self.ok, self.status, self._last = snapshot
        self.flow.restore(inner)

    def before_jump(self) -> Any:
        return self._unhit

    def _check_start(self) -> None:
        self.period, self.driven = self.flow.period, self.flow.driven
        gap, size = self.gap_now(), max(1.0, float(np.abs(self.state()).max()))
        behind = gap < -1e-9 * size or (gap < 0.0 and self.rate_of_gap() < 0.0)
        if behind and not self._span()[0]:
            text = f"{self._label}: at t = {self.time:g} s the state {self.state()} has the gap {gap:.3g}"
            raise InputError(f"{text}; it must be > 0. Start in flight.")
        self.ok, self.status = self.flow.ok, self.flow.status
        self._last, self._before = float("-inf"), self.state()

    def _start(self) -> None:
        """Start, or a status behind the wall."""
        try:
            self._check_start()
        except InputError as error:
            self.ok, self.status = False, str(error)

    def _span(self) -> tuple[bool, float]:
        """Whether the present instant lies in a silent span, and the time [s] until which that holds."""
        until = float("inf")
        for begin, part, times in self.silent:
            period = times * float(self.period or 1.0)
            elapsed, length = (self.time - begin * period) % period, part * period
            rest = period - elapsed
            if rest < 1e-12 * period:  # the begin, but for round-off
                elapsed, rest = 0.0, rest + period
            if elapsed < (1.0 - 1e-12) * length:
                return True, self.time + length - elapsed
            until = min(until, self.time + rest)
        return False, until

    def gap_now(self) -> float:
        """The present gap."""
        return float(self.gap(self.time, self.state(), **self.parameters))

    def _gradient(self) -> tuple[np.ndarray, float]:
        """Derivatives (size,) of the gap by the state, and its derivative by time."""
        x, t, p = self.state(), self.time, self.parameters
        n = central_differences(lambda y: [self.gap(t, y, **p)], x)[0]
        return n, float(self._by_time(lambda s: [self.gap(s, x.copy(), **p)], t)[0])

    def _by_time(self, function: Callable[[float], Any], time: float, size: Any = None) -> np.ndarray:
        """Derivatives of a function of time, at a time."""
        first, t = np.array([STEP * min(self.pace, self.period or self.pace)]), np.array([time])
        return central_differences(lambda s: function(s.item()), t, False, steps=first, size=size)[:, 0]

    def rate_of_gap(self) -> float:
        """The present rate of the gap [1/s]."""
        t, x, f, p = self.time, self.state(), self.velocity(), self.parameters

        def size() -> Any:
            n, by_time = self._gradient()
            return np.array([np.abs(n) @ np.abs(x) + abs(by_time * t)])

        return float(self._by_time(lambda s: [self.gap(t + s, x + s * f, **p)], 0.0, size).item())

    def _hit(self, tangents: np.ndarray | None) -> None:
        """Apply the jump to the state and the saltation matrix to the tangent vectors."""
        x, t, p = self.state(), self.time, self.parameters
        before, rate = self.velocity(), self.rate_of_gap()
        if rate >= 0.0:
            return  # the gap opens again without an impact
        after = np.array(self.jump(t, x.copy(), **p), dtype=np.float64)
        if not np.isfinite(after).all():
            self.flow.ok, self.flow.status = False, f"The jump at t = {t:.6g} s gives a state that is not finite."
            return
        if tangents is None:
            self.flow.reset(after, time=t)
            return
        n, _ = self._gradient()
        j = self._by_time(lambda s: self.jump(s, x.copy(), **p), t)
        self.flow.reset(after, time=t)
        J = central_differences(lambda y: self.jump(t, y, **p), x)
        tangents[:] = J @ tangents + np.outer(self.velocity() - J @ before - j, n @ tangents) / rate


@dataclass(frozen=True, eq=False)
class Approach:
    """An impact, or a turning point of the gap, of a motion with impacts."""

    time: float
    state: np.ndarray  # state (size,), before the impact
    gap: float  # gap at a turning point; 0 at an impact
    speed: float  # closing speed of an impact, > 0; 0 at a turning point


STEPS = 64  # least number of steps of a period in which turning points are sought


def approaches(flow: ImpactODE, duration: float) -> list[Approach] | None:
    """Impacts and turning points of the gap over a time [s] from the present state on; None: the motion ends early."""
    found, end, longest = [], flow.time + duration, min(duration, flow.period or duration) / STEPS
    rate = flow.rate_of_gap()
    while flow.ok and flow.time < end:
        before, last = flow.snapshot(), flow._last
        if not flow.take_step(min(end, flow.time + longest)):
            return None
        old, rate = rate, flow.rate_of_gap()
        if flow._last != last:
            after = flow.snapshot()
            flow.flow.reset(flow._before, time=flow.time)
            found.append(Approach(flow.time, flow._before, 0.0, -flow.rate_of_gap()))
            flow.restore(after)
        elif old < 0.0 <= rate:
            found.append(_turning_point(flow, before, flow.time))
    return found if flow.ok else None


def _turning_point(flow: ImpactODE, before: Any, end: float) -> Approach:
    """The turning point between a snapshot and an instant [s]; the flow stays where it is."""
    after = flow.snapshot()

    def rate(duration: float) -> float:
        flow.restore(before)
        if duration > 0.0:
            flow.flow.advance(duration)
        return float(flow.rate_of_gap())

    flow.restore(before)
    scipy.optimize.brentq(rate, 0.0, end - flow.time, xtol=1e-13 * (end - flow.time), rtol=1e-14)
    found = Approach(flow.time, flow.state(), flow.gap_now(), 0.0)
    flow.restore(after)
    return found


class FromImpact(OfFlow):
    """The motion of an `ImpactODE` from just before an impact over `times` periods, as a map of (state, instant)."""

    # Equation (9.14) of docs/theory/exponents.md.
    # Fixed points are periodic orbits with that impact: the state returns, the gap vanishes. The impact stands at the
    # start, so the map is smooth where its closing speed passes 0. `flow.silent` must hold the span around it.
    unit = "periods"
    flow: ImpactODE

    def __init__(self, flow: ImpactODE, state: np.ndarray, instant: float, times: int, scale: float) -> None:
        self.flow, self.name, self._time, self.times, self.scale = flow, flow.name, 0.0, times, scale
        self.names, self.units = (*flow.names, "instant"), (*flow.units, "s")
        self._state = np.append(state, instant)
        self.ok, self.status = True, "ready"

    time: Any = property(attrgetter("_time"))
    size: Any = property(lambda self: len(self._state))
    dimension: Any = size

    @property
    def weights(self) -> np.ndarray:
        return np.append(self.flow.weights, self.slowness**-2)

    def state(self) -> np.ndarray:
        return self._state.copy()

    observe = state

    def reset(self, state: State = None, *, time: float = 0.0, parameters: Parameters = None) -> None:
        self._state = self._state if state is None else np.array(state, dtype=np.float64)
        self._time, self.ok, self.status = time, True, "ready"
        self.flow.flow.reset(self._state[:-1], time=self._state[-1], parameters=parameters)
        self.flow._start()

    @property
    def length(self) -> float:
        """Duration of the map [s]."""
        return self.times * float(self.flow.period or 1.0)

    @property
    def slowness(self) -> float:
        """Time [s] that counts as a unit of the state: 1/(2 pi) of the duration over the scale of the states."""
        return self.length / (2.0 * np.pi * self.scale)

    def rebound(self, tangents: np.ndarray | None = None) -> tuple[float, float]:
        """Put the flow just after the impact, with differences (size + 1, k) carried along."""
        # Returns gap and closing speed before the impact.
        flow, p, t, x = self.flow, self.flow.parameters, float(self._state[-1]), self._state[:-1]
        flow.flow.reset(x, time=t)
        gap, speed = flow.gap_now(), -flow.rate_of_gap()
        after = np.array(flow.jump(t, x.copy(), **p), dtype=np.float64)
        if tangents is not None:
            n, by_time = flow._gradient()
            J = central_differences(lambda y: flow.jump(t, y, **p), x)
            j = flow._by_time(lambda s: flow.jump(s, x.copy(), **p), t)
            gaps = n @ tangents[:-1] + by_time * tangents[-1]
            flow.flow.reset(after, time=t)
            tangents[:-1] = J @ tangents[:-1] + np.outer(j - flow.velocity(), tangents[-1])
            tangents[-1] += gaps * self.slowness
        flow.flow.reset(after, time=t)
        flow._start()
        return gap, speed

    def advance(self, duration: float, tangents: np.ndarray | None = None) -> bool:
        for _ in range(round(duration) if self.ok else 0):
            instants = None if tangents is None else tangents[-1].copy()
            gap, _ = self.rebound(tangents)
            carried = None if tangents is None else np.ascontiguousarray(tangents[:-1])
            self.ok, self.status = self.flow.advance(self.length, carried), self.flow.status
            if not self.ok:
                return False
            if tangents is not None and carried is not None and instants is not None:
                tangents[:-1] = carried + np.outer(self.flow.velocity(), instants)
            self._state = np.append(self.flow.state(), self._state[-1] + gap * self.slowness)
            self._time += 1.0
        return self.ok
