"""Massless rod: two points that keep their distance."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexmb import checks, planar
from flexmb.errors import InputError, ModelError
from flexmb.joints.direction import dot
from flexmb.kernels import compiled, constraint_kernel
from flexmb.model.contributions import Attachment, ConstraintContribution, Contribution, Reaction
from flexmb.model.part import Part
from flexmb.model.shape import ROD, LineShape, Shapes

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism


FIRST_ANGLE, SECOND_ANGLE = 2, 5
"""Places of the angles of two nodes among their coordinates."""


@compiled
def line_between(s1x, s1y, s2x, s2y, q):
    """Line from a point of the first node to one of the second: length, direction e; derivatives by q (6,).

    With d = x2 + R2 s2 - x1 - R1 s1 these are along = e . dd/dq, that of the length, and across = n . dd/dq with
    n = (-ey, ex), that of the angle times the length.  Second derivatives of the length are across across^T/length, of
    the angle -(along across^T + across along^T)/length^2; besides, by (2, 2) and (5, 5), -across and along/length.
    """
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    ax, ay = c1 * s1x - d1 * s1y, d1 * s1x + c1 * s1y
    bx, by = c2 * s2x - d2 * s2y, d2 * s2x + c2 * s2y
    dx, dy = q[3] + bx - q[0] - ax, q[4] + by - q[1] - ay
    size = math.sqrt(dx * dx + dy * dy)
    ex, ey = dx / size, dy / size
    along = (-ex, -ey, ex * ay - ey * ax, ex, ey, ey * bx - ex * by)
    across = (ey, -ex, -ey * ay - ex * ax, -ey, ex, ex * bx + ey * by)
    return size, ex, ey, along, across


@compiled
def add_bending(k, size, across, H):
    """H += k times the second derivatives of the length of a line."""
    for i in range(6):
        for j in range(6):
            H[i, j] += k * across[i] * across[j] / size
    H[2, 2] -= k * across[FIRST_ANGLE]
    H[5, 5] -= k * across[SECOND_ANGLE]


@constraint_kernel
def distance_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """g = |d| - length with d = x2 + R2 s2 - x1 - R1 s1; q (6,)."""
    s1x, s1y, s2x, s2y, length = p
    size, _, _, along, across = line_between(s1x, s1y, s2x, s2y, q)
    g[0] = size - length
    for i in range(6):
        G[0, i] = along[i]
    turn = dot(across, v)
    gamma[0] = -turn * turn / size + across[FIRST_ANGLE] * v[2] * v[2] + across[SECOND_ANGLE] * v[5] * v[5]
    add_bending(lam[0], size, across, H)


@dataclass(frozen=True)
class Distance(Part):
    """Massless rigid rod with a pin at each end: two points of two bodies keep their distance.

    Signals: force (tension of the rod; negative: pressure) [N].

    Parameters
    ----------
    name : name of the rod.
    first, second : the bodies; `GROUND` is the frame.
    at : point of the first body in the reference configuration [m].
    to : point of the second body in the reference configuration [m].

    Raises
    ------
    InputError : points that coincide: such a rod is a revolute joint.
    ModelError : a rod from a body to itself.
    """

    formerly = (("start", "at"), ("end", "to"))
    first: Part
    second: Part
    at: tuple[float, float]
    to: tuple[float, float]

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("at", "to"):
            object.__setattr__(self, name, checks.point(self.label, name, getattr(self, name)))
        if planar.distance(self.at, self.to) == 0.0:
            raise InputError(f"{self.label}: both points are {self.at}; a rod needs a length. Use Revolute(...).")
        if self.first.name == self.second.name:
            raise ModelError(f"{self.label} joins {self.first.name!r} to itself; give two different bodies.")

    def ends(self, mechanism: Mechanism) -> tuple[Attachment, Attachment]:
        """Both points on the bodies of `mechanism`."""
        first = mechanism.body(self.first.name, self.label).attach(self.label, self.at)
        return first, mechanism.body(self.second.name, self.label).attach(self.label, self.to)

    def shapes(self, mechanism: Mechanism) -> Shapes:
        """The rod."""
        first, second = self.ends(mechanism)
        return (LineShape(self.name, ROD, first.place, second.place),)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        """One constraint equation."""
        first, second = self.ends(mechanism)
        p = (*first.offset, *second.offset, planar.distance(self.at, self.to))
        coordinates, tension = (*first.coordinates, *second.coordinates), Reaction("force", "N", 0, -1.0)
        return [ConstraintContribution(self.name, distance_kernel, coordinates, p, 1, reactions=(tension,))]
