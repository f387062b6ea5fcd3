"""Base class of the sections of a flow."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

import numpy as np

from flexmb.dynamics.systems.continuous_flow import ContinuousFlow
from flexmb.dynamics.systems.dynamics import Dynamics


class SectionOfFlow(Dynamics):
    """A map of a flow, with the signals and parameters of the flow.

    Attributes
    ----------
    flow : the flow, which stands at the last point.
    """

    flow: ContinuousFlow

    @property
    def size(self) -> int:
        return self.flow.size

    @property
    def dimension(self) -> int:
        return self.flow.dimension

    @property
    def weights(self) -> np.ndarray:
        return self.flow.weights

    @property
    def records(self) -> np.ndarray:
        return self.flow.records

    @property
    def telling(self) -> tuple[int, ...]:
        return self.flow.telling

    @property
    def resolution(self) -> np.ndarray | None:
        return self.flow.resolution

    @property
    def parameters(self) -> Mapping[str, Any]:
        return self.flow.parameters

    def state(self) -> np.ndarray:
        return self.flow.state()

    def observe(self) -> np.ndarray:
        return self.flow.observe()

    @property
    def fineness(self) -> str:
        return self.flow.fineness

    def finer(self) -> Self:
        other = self.copy()
        other.flow = self.flow.finer()
        return other

    def another_start(self, distance: float, seed: int) -> np.ndarray:
        start = self.state()
        start[: self.flow.size] = self.flow.another_start(distance, seed)
        return start
