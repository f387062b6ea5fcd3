"""Straight segment and circle of a body: flat face and roller."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flexmb import arguments, checks
from flexmb.display.shown import Shown
from flexmb.errors import InputError

CIRCLE_POINTS = 72
"""Number of segments of a drawn circle."""


@dataclass(frozen=True)
class Line(arguments.Checked, Shown):
    """Straight segment, e.g. the face of a flat follower.

    Parameters
    ----------
    start, end : its ends in the reference configuration of the mechanism [m], apart from each other.

    Raises
    ------
    InputError : ends that coincide or are not finite.
    """

    start: tuple[float, float]
    end: tuple[float, float]

    def __post_init__(self) -> None:
        for name in ("start", "end"):
            object.__setattr__(self, name, checks.point("Line", name, getattr(self, name)))
        if math.dist(self.start, self.end) == 0.0:
            raise InputError(
                f"Line: both ends are {self.start}; a segment needs a length. Use PointOnCurve for an edge."
            )

    @property
    def length(self) -> float:
        """Distance of the ends [m]."""
        return math.dist(self.start, self.end)

    @property
    def size(self) -> float:
        """The length [m]."""
        return self.length

    def drawing(self) -> tuple[tuple[float, float], ...]:
        """Both ends [m], for pictures."""
        return self.start, self.end


@dataclass(frozen=True)
class CircularCurve(arguments.Checked, Shown):
    """Circle, e.g. a roller or a pin.

    Parameters
    ----------
    centre : its centre in the reference configuration of the mechanism [m].
    radius : its radius [m], > 0.

    Raises
    ------
    InputError : a radius that is not > 0.

    Notes
    -----
    The circle is fixed to its body.  A roller that turns on its follower is a body of its own with a `Revolute`.
    """

    centre: tuple[float, float]
    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", checks.point("CircularCurve", "centre", self.centre))
        hint = "For an edge without radius use PointOnCurve(...)."
        checks.positive("CircularCurve", "radius", self.radius, "m", hint)

    @property
    def size(self) -> float:
        """The diameter [m]."""
        return 2.0 * self.radius

    def drawing(self) -> tuple[tuple[float, float], ...]:
        """Points of a closed polyline in the reference configuration [m], for pictures."""
        x, y = self.centre
        angles = [2.0 * math.pi * k / CIRCLE_POINTS for k in range(CIRCLE_POINTS + 1)]
        return tuple((x + self.radius * math.cos(a), y + self.radius * math.sin(a)) for a in angles)
