"""Pin in a slot: ideal, and with clearance."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, replace
from typing import TYPE_CHECKING, cast

from flexmb.fields import directed, field, not_negative, positive, record
from flexmb.kernels import constraint_kernel, gap_kernel, joint_friction_kernel
from flexmb.model.contributions import ConstraintContribution, ContactContribution, Contribution
from flexmb.model.law import FRICTION_LAW, NORMAL_LAW, FrictionLaw, NormalLaw
from flexmb.model.mechanism import Mechanism
from flexmb.parts.contact.friction import Frictionless
from flexmb.parts.joints.contact_point import (
    add_curvature,
    arms_of,
    difference_column,
    direction,
    put_column,
    put_eccentricity,
    put_point,
)
from flexmb.parts.joints.prismatic import OnLine, direction_row, travel_contributions
from flexmb.parts.joints.revolute import rubbing
from flexmb.places import LOAD, LOAD_BY_LAM, SLIDING

if TYPE_CHECKING:
    from flexmb.parts.wear.worn_guide import WornSlot
    from flexmb.parts.wear.worn_joint import Wear


@constraint_kernel
def slot_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """A point of the second body stays on a straight line of the first."""
    ux, uy, s1x, s1y, s2x, s2y = p
    direction_row(-uy, ux, s1x, s1y, s2x, s2y, q, v, lam, 0, g, G, gamma, H)


@joint_friction_kernel
def slot_friction(p, q, lam, out, H):
    """Pin of radius R on the side of the slot that holds it: N = |F|, slip = rate of travel +- R (omega2 - omega1)."""
    ux, uy, s1x, s1y, s2x, s2y, R = p
    side = math.copysign(1.0, lam[0])
    out[LOAD], out[LOAD_BY_LAM] = abs(lam[0]), side
    _, J, nx, ny, far, near = direction(ux, uy, s1x, s1y, s2x, s2y, q)
    for j in range(6):
        out[SLIDING + j] = J[j]
    for theta, arm in ((2, R), (5, -R)):
        out[SLIDING + theta] += side * arm
    add_curvature(1.0, nx, ny, far, near, H)


@gap_kernel
def slot_gap_kernel(p, q, v, out):
    """Round pin in a slot with round ends: e from the nearest point of the middle line, gap = c - |e|, n = e/|e|."""
    # The contact point lies half the depth beyond the pin's surface, so both bodies are pushed at one point.
    c, reach, radius, mx, my, s1x, s1y, s2x, s2y = p
    ax, ay, bx, by, ex, ey = arms_of(s1x, s1y, s2x, s2y, q)
    c1, d1 = math.cos(q[2]), math.sin(q[2])
    ux, uy = c1 * mx - d1 * my, d1 * mx + c1 * my
    along, across = ux * ex + uy * ey, ux * ey - uy * ex
    side = abs(along) <= reach
    if side:
        size = abs(across)
        sign = 1.0 if across >= 0.0 else -1.0
        nx, ny = -sign * uy, sign * ux
    else:
        end = reach if along > 0.0 else -reach
        ax, ay = ax + end * ux, ay + end * uy  # the middle of the round end
        ex, ey = ex - end * ux, ey - end * uy
        size = math.sqrt(ex * ex + ey * ey)
        nx, ny = ex / size, ey / size
    ahead = radius + 0.5 * (c + size) - size  # from the pin's centre to the contact point
    X, Y = q[3] + bx + ahead * nx, q[4] + by + ahead * ny
    put_point(out, q, v, c - size, nx, ny, X, Y)
    vx, vy = v[3] - v[5] * by - v[0] + v[2] * ay, v[4] + v[5] * bx - v[1] - v[2] * ax
    wx, wy = (size * nx, size * ny) if side else (ex, ey)
    put_eccentricity(out, wx, wy, vx, vy)
    for j in range(6):
        gx, gy, _, _ = difference_column(j, ax, ay, bx, by)  # of the pin's centre from the middle, or the round end
        Xq, Yq = (gx, gy) if j > 2 else (0.0, 0.0)
        if side:
            nqx, nqy = (-ny, nx) if j == 2 else (0.0, 0.0)
            grows = nx * gx + ny * gy
            if j == 2:  # the line turns, too
                grows += -ny * ex + nx * ey
        else:
            turn = (nx * gy - ny * gx) / size
            nqx, nqy = -ny * turn, nx * turn
            grows = nx * gx + ny * gy
        put_column(out, j, nqx, nqy, Xq + ahead * nqx - 0.5 * grows * nx, Yq + ahead * nqy - 0.5 * grows * ny)


@record
class PinSlot(OnLine):
    """Ideal pin in a straight slot: a point of the second body stays on a line of the first, and turns freely.

    The pin and the middle of the slot are at `at`.

    Signals: fx, fy, force (on the second body) [N], travel of the pin along the slot [m], speed [m/s].

    Raises
    ------
    InputError : a direction without length.
    """

    along: tuple[float, float] = field("direction of the slot", rule=directed, default=(1.0, 0.0))

    kind = "slot"

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        coordinates, p = self.ends(mechanism).coordinates, self.line(mechanism)
        row = ConstraintContribution(self.name, slot_kernel, coordinates, p, 1, second=coordinates[3:])
        return [row, *travel_contributions(self.name, coordinates, p)]


@record
class PinSlotClearance(PinSlot):
    """Round pin of the second body with clearance in a slot of the first; the slot has round ends.

    Signals: as of a contact (see `RevoluteClearance`; ex, ey from the middle line of the slot), travel [m] and
    speed [m/s].

    Raises
    ------
    InputError : sizes out of range, laws of the wrong kind.

    Notes
    -----
    At the start the pin is in the middle of the slot's width and moves as in an ideal `PinSlot`.  A law made from
    materials has the stiffness of the pin against a flat side.
    """

    _: KW_ONLY
    clearance: float = field(
        "half width of the slot less pin radius", "m", positive, hint="For a pin without clearance use PinSlot(...)."
    )
    pin_radius: float = field("radius of the pin", "m", positive)
    length: float | None = field("travel between the round ends; None: no ends", "m", not_negative, default=None)
    normal: NormalLaw = field("law of the normal force", rule=NORMAL_LAW)
    friction: FrictionLaw = field("law of friction", rule=FRICTION_LAW, default_factory=Frictionless)

    kind = "clearance"

    def worn_by(self, wear: Wear, length: float) -> WornSlot:
        """The joint with sides of the slot that wear, unworn so far.

        Parameters
        ----------
        wear : law of wear with the coefficient of the slot, e.g. Archard(bearing=1e-13, width=0.02).
        length : length of the slot whose depth is known, its middle at the joint's point [m].
        """
        from flexmb.parts.wear.worn_guide import WornSlot  # noqa: PLC0415 - it is a joint with clearance itself
        from flexmb.parts.wear.worn_joint import worn  # noqa: PLC0415

        return worn(self, PinSlotClearance, WornSlot, wear=wear, worn_length=length)

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        p = self.line(mechanism)
        reach = 1e300 if self.length is None else 0.5 * self.length
        normal = self.normal.for_radii(math.inf, self.pin_radius)
        sizes, laws = (self.clearance, reach, self.pin_radius), (normal, self.friction)
        row, *signals = super().contributions(mechanism)
        friction = rubbing(self.friction, slot_friction, (*p, self.pin_radius))
        ideal = replace(cast("ConstraintContribution", row), joint_friction=friction, holds="closed")
        contact = ContactContribution(self.name, slot_gap_kernel, ideal.coordinates, (*sizes, *p), *laws)
        return [contact, *signals, ideal]
