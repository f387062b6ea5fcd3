"""Sections of flows: stroboscopic maps, and Poincare maps at the crossings of a level."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.sections.crossing import DOWN, UP, Bracket, Height, carry, locate, stride
from flexmb.dynamics.systems.dynamics import ContinuousFlow, Dynamics, OfFlow, Parameters, State
from flexmb.dynamics.systems.given import state_of
from flexmb.errors import InputError


# Base class of the sections of a flow
class SectionOfFlow(OfFlow):
    """A map of a flow, which stands at the last point, with the signals and parameters of the flow."""

    def _observe(self, flow: Any) -> None:
        """Take a flow in time, with its name and signals."""
        if not isinstance(flow, ContinuousFlow):
            text = f"{type(self).__name__}: flow is {type(flow).__name__}"
            raise InputError(f"{text}; it must be a flow in time, as MechanismFlow(mechanism) or ODE.")
        self.flow, self.name = flow, flow.name
        self.names, self.units = flow.names, flow.units

    @property
    def underlying(self) -> ContinuousFlow:
        return self.flow

    def remarks(self, since: float) -> list[str]:
        return self.flow.remarks(since)

    def another_start(self, distance: float, seed: int) -> np.ndarray:
        start = self.state()
        start[: self.flow.size] = self.flow.another_start(distance, seed)
        return start


# Stroboscopic map: a flow observed once a period
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

    def on_manifold(self, tangents: np.ndarray) -> np.ndarray:
        return self.flow.on_manifold(tangents)

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
        self,
        flow: ContinuousFlow,
        signal: str,
        *,
        level: float = 0.0,
        direction: str = "up",
        limit: float | None = None,
    ) -> None:
        self._observe(flow)
        self.signal = signal
        self.direction = checks.one_of(self._label, "direction", direction, DIRECTIONS)
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
        T = np.array(tangents, dtype=np.float64)
        n = self.flow.size
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
        v = flow.velocity()
        self._time_weight = float(flow.weights @ v**2) or 1.0

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
