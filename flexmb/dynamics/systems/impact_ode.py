"""Ordinary differential equations with impacts: smooth flow, jumps of the state, saltation matrices."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.sections.crossing import UP, Height, carry, locate, stride
from flexmb.dynamics.systems.dynamics import ContinuousFlow, OfFlow
from flexmb.dynamics.systems.given import ODE, central_differences, state_of
from flexmb.errors import InputError

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
    motion afterwards is another system.  A grazing impact has no tangent: the saltation matrix grows like the inverse
    of the approach speed.

    Examples
    --------
    >>> import flexmb as fm
    >>> fall = fm.chaos.ODE(lambda t, x: [x[1], -1.0], [0.5, 0.0], names=["height", "speed"])
    >>> ball = fm.chaos.ImpactODE(fall, gap=lambda t, x: x[0], jump=lambda t, x: [x[0], -0.5 * x[1]])
    >>> ball.advance(1.5), ball.state().round(9)  # hits at t = 1 with speed -1
    (True, array([0.125, 0.   ]))
    """

    flow: ODE
    _last: float

    def __init__(self, ode: ODE, *, gap: Callable[..., float], jump: Callable[..., Any]) -> None:
        if not isinstance(ode, ODE):
            raise InputError(f"ImpactODE: ode is {ode!r}; it must be an ODE(...), the motion between impacts.")
        self.flow, self.gap, self.jump = ode, gap, jump
        self.name, self.names, self.units = ode.name, ode.names, ode.units
        self._check_start()
        state_of(f"{self._label}: jump", jump(ode.time, ode.state(), **ode.parameters), ode.size)

    @property
    def _label(self) -> str:
        return f"ImpactODE {self.name!r}"

    @property
    def time(self) -> float:
        return self.flow.time

    @property
    def ode(self) -> ODE:
        """The motion between impacts."""
        return self.flow

    @property
    def pace(self) -> float:
        return self.flow.pace

    def reset(
        self, state: np.ndarray | None = None, *, time: float = 0.0, parameters: Mapping[str, Any] | None = None
    ) -> None:
        self.flow.reset(state, time=time, parameters=parameters)
        self._check_start()

    def advance(self, duration: float, tangents: np.ndarray | None = None) -> bool:
        limit = self.time + checks.positive(self._label, "duration", duration, "s")
        while self.ok and self.time < limit:
            self.take_step(limit, tangents)
        return self.ok

    def take_step(self, limit: float, tangents: np.ndarray | None = None) -> bool:
        if not self.ok:
            return False
        height = Height(self.flow, self._height, self._closing, UP)
        bracket = stride(height, limit, tangents)
        if bracket is not None and self.flow.ok:
            stuck = bracket.near == 0.0 and height.left(bracket.value)
            duration = 0.0 if stuck else locate(height, bracket)
            if stuck or self.time - self._last < PILE * max(abs(self.time), self.pace):
                self.ok, self.status = False, f"Impacts pile up at t = {self.time:.6g} s: the gap stays closed."
                return False
            self._last = self.time
            if tangents is not None and self.flow.ok:
                carry(self.flow, bracket, duration, tangents)
            if self.flow.ok:
                self._hit(tangents)
        self.ok, self.status = self.flow.ok, self.flow.status
        return self.ok

    def velocity(self) -> np.ndarray:
        return self.flow.velocity()

    def rate(self, signal: int) -> float:
        return self.flow.rate(signal)

    def slopes(self, signal: int, tangents: np.ndarray) -> np.ndarray:
        return self.flow.slopes(signal, tangents)

    def snapshot(self) -> Any:
        return self.flow.snapshot(), self.ok, self.status, self._last

    def restore(self, snapshot: Any) -> None:
        inner, self.ok, self.status, self._last = snapshot
        self.flow.restore(inner)

    def _check_start(self) -> None:
        self.period, self.driven = self.flow.period, self.flow.driven
        gap, speed = self._height(), self._closing()
        if gap < -1e-9 * max(1.0, float(np.abs(self.state()).max())) or (gap < 0.0 and speed < 0.0):
            text = f"{self._label}: at t = {self.time:g} s the state {self.state()} has the gap {gap:.3g}"
            raise InputError(f"{text}; it must be > 0. Start in flight.")
        self.ok, self.status, self._last = self.flow.ok, self.flow.status, float("-inf")

    def _height(self) -> float:
        return float(self.gap(self.time, self.state(), **self.parameters))

    def _gradient(self) -> tuple[np.ndarray, float]:
        """Derivatives (size,) of the gap by the state, and its derivative by time."""
        x, t, p = self.state(), self.time, self.parameters
        n = central_differences(lambda y: [self.gap(t, y, **p)], x)[0]
        return n, float(self._by_time(lambda s: [self.gap(s, x, **p)])[0])

    def _by_time(self, function: Callable[[float], Any]) -> np.ndarray:
        """Central difference of a function of time; its step does not grow with the time of the run."""
        t = self.time
        step = max(6e-6 * (self.period or 1.0), 1e5 * float(np.spacing(abs(t))))
        early, late = t - step, t + step
        change = np.asarray(function(late), dtype=np.float64) - np.asarray(function(early))
        return np.asarray(change / (late - early))

    def _closing(self) -> float:
        n, by_time = self._gradient()
        return float(n @ self.velocity()) + by_time

    def _hit(self, tangents: np.ndarray | None) -> None:
        """Apply the jump to the state and the saltation matrix to the tangent vectors."""
        x, t, p = self.state(), self.time, self.parameters
        n, by_time = self._gradient()
        before = self.velocity()
        rate = float(n @ before) + by_time
        if rate >= 0.0:
            return  # the gap opens again without an impact
        after = np.asarray(self.jump(t, x.copy(), **p), dtype=np.float64)
        if not np.isfinite(after).all():
            self.flow.ok, self.flow.status = False, f"The jump at t = {t:.6g} s gives a state that is not finite."
            return
        self.flow.reset(after, time=t)
        if tangents is None:
            return
        J = central_differences(lambda y: self.jump(t, y, **p), x)
        j = self._by_time(lambda s: self.jump(s, x, **p))
        tangents[:] = J @ tangents + np.outer(self.velocity() - J @ before - j, n @ tangents) / rate
