"""Section points of a system, as a verdict wants to see them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from flexmb import checks
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.dynamics.verdict.verdict import Verdict, judge


@dataclass(frozen=True, eq=False)
class Seen:
    """What the signals of points are, and how precise.

    Parameters
    ----------
    name : the system.
    names, units : of its signals (m,).
    telling : places of those that tell of the motion.
    resolution : (m,) differences of the signals that may be errors of the integration; None: 1e-6 of their sizes.
    dimension : exponents that the system has; 0: not known.
    """

    name: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    telling: tuple[int, ...]
    resolution: np.ndarray | None
    dimension: int = 0

    @classmethod
    def of(cls, system: Dynamics) -> Self:
        """What there is to say of the points of a system."""
        return cls(system.name, system.names, system.units, system.telling, system.resolution, system.dimension)

    def judged(
        self,
        points: np.ndarray,
        signals: Sequence[str] = (),
        exponent: float | None = None,
        error: float | None = None,
    ) -> Verdict:
        """The verdict on points (n, m), through some of the signals or (none named) through all that tell."""
        known = [checks.one_of(f"verdict on {self.name!r}", "signal", name, self.names) for name in signals]
        chosen = [self.names.index(name) for name in known] or list(self.telling)
        about: dict[str, Any] = {"units": [self.units[k] for k in chosen]}
        if self.resolution is not None:
            about |= {"floor": 1.0, "sizes": self.resolution[chosen]}
        names = [self.names[k] for k in chosen]
        return judge(points[:, chosen], names, exponent=exponent, error=error, **about)
