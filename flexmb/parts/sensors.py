"""Marker: a point of a body whose motion is reported."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from flexmb.fields import field, point, record
from flexmb.kernels import signal_kernel
from flexmb.model.contributions import Contribution, signal_contributions
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Part
from flexmb.model.shape import MARKER, TRACE, PointShape, Shapes

SIGNALS = (  # signals of a marker with their units, in the order of `marker_kernel`
    ("x", "m"), ("y", "m"), ("vx", "m/s"), ("vy", "m/s"), ("ax", "m/s2"), ("ay", "m/s2"), ("theta", "rad"),
    ("omega", "rad/s"),
)  # fmt: skip


@signal_kernel
def marker_kernel(p, t, q, v, a):
    """Position, velocity, acceleration, rotation or angular velocity of a point of a node; p: offset, number."""
    sx, sy, number = p
    if number >= 6.0:
        return q[2] if number == 6.0 else v[2]
    c, s = math.cos(q[2]), math.sin(q[2])
    ex, ey = c * sx - s * sy, s * sx + c * sy  # from the node to the point
    if number < 2.0:
        return q[0] + ex if number == 0.0 else q[1] + ey
    if number < 4.0:
        return v[0] - v[2] * ey if number == 2.0 else v[1] + v[2] * ex
    w2 = v[2] * v[2]
    return a[0] - a[2] * ey - w2 * ex if number == 4.0 else a[1] + a[2] * ex - w2 * ey


@record
class Marker(Part):
    """A point of a body, or of a node of a flexible body, without mass: it reports its motion.

    A marker may stand in place of a point, which then follows it in `with_`: `Force("load", body, at=marker, ...)`.

    Signals: x, y [m], vx, vy [m/s], ax, ay [m/s2], theta [rad] and omega [rad/s] of the body there, in world axes.

    Raises
    ------
    InputError : a point where a flexible body has no node.
    """

    body: Part = field("the body")
    at: tuple[float, float] = field("the point", "m", point)
    trace: bool = field("whether pictures show its path", default=False)

    @property
    def marker(self) -> str:
        """Name by which points follow the marker."""
        return self.name

    def __iter__(self) -> Iterator[float]:
        """Coordinates of the point in the reference configuration [m]."""
        return iter(self.at)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        end = mechanism.body(self.body.name, self.label).attach(self.label, self.at)
        return signal_contributions(self.name, marker_kernel, SIGNALS, end.coordinates, end.offset)

    def shapes(self, mechanism: Mechanism) -> Shapes:
        end = mechanism.body(self.body.name, self.label).attach(self.label, self.at)
        kind = TRACE if self.trace and self.body.name != GROUND.name else MARKER
        return (PointShape(self.name, kind, end.part, end.node, end.offset),)
