"""Stroboscopic map: a flow observed once a period."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

import numpy as np

from flexmb import checks
from flexmb.dynamics.sections.section_of_flow import SectionOfFlow
from flexmb.dynamics.systems.continuous_flow import ContinuousFlow
from flexmb.errors import InputError


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

    def __init__(self, flow: ContinuousFlow, period: float | None = None) -> None:
        if not isinstance(flow, ContinuousFlow):
            text = f"StroboscopicMap: flow is {type(flow).__name__}"
            raise InputError(f"{text}; it must be a flow in time, as MechanismFlow(mechanism) or ODE.")
        self.flow, self.name = flow, flow.name
        self.declared = None if period is None else checks.positive(self._label, "period", period, "s")
        self.names, self.units = flow.names, flow.units
        self.origin, self.period = flow.time, self._derived()
        self.ok, self.status = flow.ok, flow.status

    @property
    def _label(self) -> str:
        return f"StroboscopicMap of {self.name!r}"

    @property
    def time(self) -> float:
        return float(np.round((self.flow.time - self.origin) / self.period, 9))

    def reset(
        self, state: np.ndarray | None = None, *, time: float = 0.0, parameters: Mapping[str, Any] | None = None
    ) -> None:
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

    def copy(self) -> Self:
        other = type(self)(self.flow.copy(), self.declared)
        other.origin, other.ok, other.status = self.origin, self.ok, self.status
        return other

    def _derived(self) -> float:
        if self.declared is not None:
            return self.declared
        if self.flow.period is None:
            advice = "Give period= (in seconds), or take a section by a signal: SectionMap(flow, signal)."
            raise InputError(f"{self._label}: {self.flow.no_period()}. {advice}")
        return self.flow.period
