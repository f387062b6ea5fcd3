"""Signals of section points: names, units and resolution, and the verdict that rests on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from flexmb import checks
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.dynamics.verdict.verdict import Verdict, judge


@dataclass(frozen=True, eq=False)
class SectionSignals:
    """Names, units and resolution of the signals of section points.

    Parameters
    ----------
    names, units : names and units (m,) of the signals.
    telling : numbers of the signals on which a verdict rests.
    resolution : differences (m,) of the signals that errors of the integration can make; None: 1e-6 of their sizes.
    dimension : number of exponents of the system; 0: unknown.
    """

    name: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    telling: tuple[int, ...]
    resolution: np.ndarray | None
    dimension: int = 0

    @classmethod
    def of(cls, system: Dynamics) -> Self:
        """Names, units and resolution of the signals that `system` observes."""
        return cls(system.name, system.names, system.units, system.telling, system.resolution, system.dimension)

    def verdict(
        self,
        points: np.ndarray,
        signals: Sequence[str] = (),
        exponent: float | None = None,
        error: float | None = None,
    ) -> Verdict:
        """Verdict on points (n, m) of all signals, by the given signals or, without any, by the signals `telling`.

        The largest exponent and its error are None where they are unknown.
        """
        known = [checks.one_of(f"verdict on {self.name!r}", "signal", name, self.names) for name in signals]
        columns = [self.names.index(name) for name in known] or list(self.telling)
        precision: dict[str, Any] = {"units": [self.units[k] for k in columns]}
        if self.resolution is not None:
            precision |= {"floor": 1.0, "sizes": self.resolution[columns]}
        names = [self.names[k] for k in columns]
        return judge(points[:, columns], names, exponent=exponent, error=error, **precision)
