"""Ideal prismatic joint between any two bodies, and its travel."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from flexmb import checks
from flexmb.errors import InputError
from flexmb.joints.revolute import drawn_angle
from flexmb.kernels import compiled, constraint_kernel
from flexmb.model.part import Joint
from flexmb.model.pieces import ConstraintPiece, Piece

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism


@compiled
def direction_row(dx, dy, s1x, s1y, s2x, s2y, q, v, lam, row, g, G, gamma, H):
    """g = n . (x2 + R2 s2 - x1 - R1 s1), where n = R1 (dx, dy) turns with the first node."""
    c1, d1 = math.cos(q[2]), math.sin(q[2])
    c2, d2 = math.cos(q[5]), math.sin(q[5])
    nx, ny = c1 * dx - d1 * dy, d1 * dx + c1 * dy
    bx, by = c2 * s2x - d2 * s2y, d2 * s2x + c2 * s2y
    ex, ey = q[3] + bx - q[0], q[4] + by - q[1]
    # the part along R1 s1 is constant: n . R1 s1 = d . s1
    g[row] = nx * ex + ny * ey - dx * s1x - dy * s1y
    turn = -ny * ex + nx * ey  # d(n)/d(theta1) . e
    swing = -nx * by + ny * bx  # n . d(R2 s2)/d(theta2)
    G[row, 0] = -nx
    G[row, 1] = -ny
    G[row, 2] = turn
    G[row, 3] = nx
    G[row, 4] = ny
    G[row, 5] = swing
    radial = nx * bx + ny * by
    # second derivatives
    h22, h55 = -(nx * ex + ny * ey), -radial
    h25 = nx * bx + ny * by  # d(n)/d(theta1) . d(R2 s2)/d(theta2)
    k = lam[row]
    H[2, 2] += k * h22
    H[5, 5] += k * h55
    H[2, 5] += k * h25
    H[5, 2] += k * h25
    H[0, 2] += k * ny
    H[2, 0] += k * ny
    H[1, 2] -= k * nx
    H[2, 1] -= k * nx
    H[3, 2] -= k * ny
    H[2, 3] -= k * ny
    H[4, 2] += k * nx
    H[2, 4] += k * nx
    vx, vy = v[3] - v[0], v[4] - v[1]
    w1, w2 = v[2], v[5]
    gamma[row] = -(w1 * w1 * h22 + w2 * w2 * h55 + 2.0 * w1 * w2 * h25 + 2.0 * w1 * (-ny * vx + nx * vy))


@constraint_kernel
def guide_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Slider in a guide on the first body: no offset across the guide, no relative rotation."""
    ux, uy, s1x, s1y, s2x, s2y, angle = p
    direction_row(-uy, ux, s1x, s1y, s2x, s2y, q, v, lam, 0, g, G, gamma, H)
    g[1] = q[5] - q[2] - angle
    G[1, 2] = -1.0
    G[1, 5] = 1.0


@constraint_kernel
def travel_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Travel of the second body along the guide, 0 in the drawn pose."""
    ux, uy, s1x, s1y, s2x, s2y = p
    direction_row(ux, uy, s1x, s1y, s2x, s2y, q, v, lam, 0, g, G, gamma, H)


@dataclass(frozen=True)
class Prismatic(Joint):
    """Ideal prismatic joint (slider) between any two bodies; the guide belongs to the first one.

    Signals: fx, fy, force (on the second body) [N], moment (on the second body, about its joint point) [N m].

    Parameters
    ----------
    name : the joint's name.
    first, second : the bodies; `GROUND` is the frame.
    at : the joint's point in the drawn pose [m]; left out: the main node of the second body.
    along : direction of the guide in the drawn pose (any length > 0).

    Raises
    ------
    InputError : a direction without length.
    """

    at: Any = None
    along: tuple[float, float] = (1.0, 0.0)

    kind = "prismatic"
    at_may_be_left_out = True

    def __post_init__(self) -> None:
        super().__post_init__()
        along = checks.point(self.label, "along", self.along, "")
        if math.hypot(*along) <= 0.0:
            raise InputError(f"{self.label}: along is {self.along}; it must be a direction with a length > 0.")
        object.__setattr__(self, "along", along)

    def pieces(self, mechanism: Mechanism) -> Sequence[Piece]:
        """Two rows."""
        coordinates, p, angle = self._geometry(mechanism)
        second = coordinates[3:]
        return [ConstraintPiece(self.name, guide_kernel, coordinates, (*p, angle), 2, second=second, moment_row=1)]

    def drive_piece(self, mechanism: Mechanism) -> ConstraintPiece | None:
        """The travel of the second body along the guide, 0 in the drawn pose."""
        coordinates, p, _ = self._geometry(mechanism)
        return ConstraintPiece(self.name, travel_kernel, coordinates, p, 1, is_drive=True, drive_units=("m", "N"))

    def _geometry(self, mechanism: Mechanism) -> tuple[Any, tuple[float, ...], float]:
        first, second = ends = self.ends(mechanism)
        theta = mechanism.body(first.part).node(first.node).theta
        direction = math.atan2(self.along[1], self.along[0]) - theta
        p = (math.cos(direction), math.sin(direction), *first.offset, *second.offset)
        return (*first.coordinates, *second.coordinates), p, drawn_angle(mechanism, ends)
