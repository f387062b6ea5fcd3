"""Massless rod: two points that keep their distance."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexmb import checks, planar
from flexmb.errors import InputError, ModelError
from flexmb.kernels import constraint_kernel
from flexmb.model.contributions import Attachment, ConstraintContribution, Contribution, Reaction
from flexmb.model.part import Part
from flexmb.model.shape import ROD, LineShape, Shapes

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism


@constraint_kernel
def distance_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """g = |d| - length with d = x2 + R2 s2 - x1 - R1 s1; q (6,)."""
    s1x, s1y, s2x, s2y, length = p
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    ax, ay = c1 * s1x - d1 * s1y, d1 * s1x + c1 * s1y
    bx, by = c2 * s2x - d2 * s2y, d2 * s2x + c2 * s2y
    dx, dy = q[3] + bx - q[0] - ax, q[4] + by - q[1] - ay
    size = math.sqrt(dx * dx + dy * dy)
    nx, ny = dx / size, dy / size
    along = (-nx, -ny, nx * ay - ny * ax, nx, ny, ny * bx - nx * by)
    across = (ny, -nx, -ny * ay - nx * ax, -ny, nx, nx * bx + ny * by)  # derivatives of the direction, times |d|
    g[0] = size - length
    turn = 0.0
    for i in range(6):
        G[0, i] = along[i]
        turn += across[i] * v[i]
    first, second = nx * ax + ny * ay, nx * bx + ny * by
    gamma[0] = -turn * turn / size - first * v[2] * v[2] + second * v[5] * v[5]
    for i in range(6):
        for j in range(6):
            H[i, j] = lam[0] * across[i] * across[j] / size
    H[2, 2] += lam[0] * first
    H[5, 5] -= lam[0] * second


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
