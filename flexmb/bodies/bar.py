"""Base of rigid and flexible bars between two points."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flexmb import checks, planar
from flexmb.errors import InputError
from flexmb.model.part import Body

Point = tuple[float, float]


@dataclass(frozen=True)
class Bar(Body):
    """Base of bodies between two points of the reference configuration.

    Parameters
    ----------
    name : the bar's name.
    start, end : its ends in the reference configuration [m], apart from each other.
    """

    formerly = (("at", "start"), ("to", "end"))
    start: Point
    end: Point

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("start", "end"):
            object.__setattr__(self, name, checks.point(self.label, name, getattr(self, name)))
        if planar.distance(self.start, self.end) <= 0.0:
            raise InputError(f"{self.label}: start and end are both {self.start}; a link must have a length > 0 m.")

    @property
    def length(self) -> float:
        """Distance of the ends in the reference configuration [m]."""
        return planar.distance(self.start, self.end)

    @property
    def angle(self) -> float:
        """Direction of the axis in the reference configuration [rad]."""
        return math.atan2(self.end[1] - self.start[1], self.end[0] - self.start[0])
