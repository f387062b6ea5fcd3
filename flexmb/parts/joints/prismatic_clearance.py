"""Prismatic joint with clearance: a slider with four corners in a straight guide."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, replace
from typing import TYPE_CHECKING

from flexmb.errors import InputError
from flexmb.fields import field, positive, record
from flexmb.kernels import compiled, gap_kernel, signal_kernel
from flexmb.model.contributions import ContactContribution, Contribution, SignalContribution
from flexmb.model.law import FRICTION_LAW, NORMAL_LAW, FrictionLaw, NormalLaw
from flexmb.model.mechanism import Mechanism
from flexmb.parts.contact.friction import Frictionless
from flexmb.parts.joints.contact_point import guide_friction, put_column, put_eccentricity, put_point
from flexmb.parts.joints.prismatic import Guide, travel_contributions
from flexmb.parts.joints.revolute_clearance import rubbing

if TYPE_CHECKING:
    from flexmb.parts.wear.laws import Wear
    from flexmb.parts.wear.worn_guide import WornGuide

CORNERS = (  # name, sign along the guide, sign across it (upper: to its left)
    ("upper_front", 1.0, 1.0), ("upper_rear", -1.0, 1.0), ("lower_front", 1.0, -1.0), ("lower_rear", -1.0, -1.0),
)  # fmt: skip


@gap_kernel
def corner_gap_kernel(p, q, v, out):
    """Corner of the second body against one side of a guide on the first; the contact point is the corner."""
    c, half, side, mx, my, s1x, s1y, kx, ky = p
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    nx, ny = -side * (c1 * my + d1 * mx), side * (c1 * mx - d1 * my)
    bx, by = c2 * kx - d2 * ky, d2 * kx + c2 * ky
    X, Y = q[3] + bx, q[4] + by
    ex, ey = X - q[0] - c1 * s1x + d1 * s1y, Y - q[1] - d1 * s1x - c1 * s1y
    put_point(out, q, v, c + half - nx * ex - ny * ey, nx, ny, X, Y)
    vex = v[3] - v[5] * by - v[0] + v[2] * (d1 * s1x + c1 * s1y)
    vey = v[4] + v[5] * bx - v[1] - v[2] * (c1 * s1x - d1 * s1y)
    put_eccentricity(out, ex, ey, vex, vey)
    for j in range(6):
        put_column(out, j, 0.0, 0.0, 0.0, 0.0)
    put_column(out, 2, -ny, nx, 0.0, 0.0)
    put_column(out, 3, 0.0, 0.0, 1.0, 0.0)
    put_column(out, 4, 0.0, 0.0, 0.0, 1.0)
    put_column(out, 5, 0.0, 0.0, -by, bx)


@compiled
def pose_in_guide(mx, my, s1x, s1y, s2x, s2y, angle, q):
    """Travel, offset across the guide and tilt of the slider's centre."""
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    ex = q[3] + c2 * s2x - d2 * s2y - q[0] - c1 * s1x + d1 * s1y
    ey = q[4] + d2 * s2x + c2 * s2y - q[1] - d1 * s1x - c1 * s1y
    ux, uy = c1 * mx - d1 * my, d1 * mx + c1 * my
    return ux * ex + uy * ey, ux * ey - uy * ex, q[5] - q[2] - angle


@signal_kernel
def slider_signal(p, t, q, v, a):
    """`chosen`: 0 travel, 1 offset, 2 tilt, 3 mode (0 free, 1 one corner, 2 two across, 3 face, 4 more)."""
    mx, my, s1x, s1y, s2x, s2y, angle, c, length, height, chosen = p
    travel, offset, tilt = pose_in_guide(mx, my, s1x, s1y, s2x, s2y, angle, q)
    which = int(chosen)
    if which < 3:
        return travel if which == 0 else (offset if which == 1 else tilt)
    upper, lower = 0, 0
    for along in (-1.0, 1.0):
        rise = offset + along * length * math.sin(tilt)
        upper += rise + height * math.cos(tilt) >= c + height
        lower += rise - height * math.cos(tilt) <= -c - height
    touching = upper + lower
    if touching <= 1:
        return float(touching)
    if touching > 2:
        return 4.0
    return 2.0 if upper == lower else 3.0


SIGNALS = (("travel", "m"), ("offset", "m"), ("tilt", "rad"), ("mode", ""))


@record
class PrismaticClearance(Guide):
    """Slider with clearance in a straight guide: four corners, each against its side of the guide.

    The first body carries the guide, the second one the slider, a rectangle whose centre is `at`. The signals of a
    corner are the signals of any contact: "P.upper_front.normal_force", ...; upper is the left side of `along`, front
    its end. Signals of the slider: travel, offset [m], speed [m/s], tilt [rad], and mode: 0 free, 1 one corner, 2 two
    corners across (tilted), 3 two corners on one side (its face), 4 more.

    Raises
    ------
    InputError : sizes out of range, laws of the wrong kind, a law from materials without corner_radius.

    Notes
    -----
    A `corner_radius` gives laws made from materials their stiffness on a flat side.  It does not change the geometry,
    so it must be small beside the sides.  The guide has no ends.  At the start the slider is centred and moves as in an
    ideal `Prismatic`.  A face that lies on its side is two corners, so its pressure is not resolved between them.
    Source of the contact states:  P.  Flores, J.  Ambrosio, J.  C.  P.  Claro, H.  M.  Lankarani, Kinematics and
    Dynamics of Multibody Systems with Imperfect Joints, Springer 2008, chapter on translational joints with clearance.
    """

    _: KW_ONLY
    clearance: float = field(
        "gap on either side, centred", "m", positive, hint="For a joint without clearance use Prismatic(...)."
    )
    half_length: float = field("half side of the slider along the guide", "m", positive)
    half_height: float = field("half side of the slider across the guide", "m", positive)
    normal: NormalLaw = field("law of the normal force of a corner", rule=NORMAL_LAW)
    friction: FrictionLaw = field("law of friction of a corner", rule=FRICTION_LAW, default_factory=Frictionless)
    corner_radius: float | None = field("rounding of the corners", "m", positive, default=None)

    kind = "clearance"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.clearance >= self.half_length:
            text = f"{self.label}: clearance is {self.clearance:g} m, half_length {self.half_length:g} m;"
            raise InputError(f"{text} the slider would turn in its guide. Did you mix up metres and millimetres?")

    @property
    def play(self) -> float:
        """Offset at which the faces touch [m]."""
        return self.clearance

    def worn_by(self, wear: Wear, length: float) -> WornGuide:
        """The joint with sides of the guide that wear, unworn so far.

        Parameters
        ----------
        wear : law of wear with the coefficient of the guide, e.g. Archard(bearing=1e-13, width=0.02).
        length : length of the guide whose depth is known, its middle at the joint's point [m].
        """
        from flexmb.parts.wear.worn_guide import WornGuide  # noqa: PLC0415 - it is a joint with clearance itself
        from flexmb.parts.wear.worn_joint import worn  # noqa: PLC0415

        made: WornGuide = worn(self, PrismaticClearance, WornGuide, wear=wear, worn_length=length)
        return made

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        coordinates, p, angle = self.geometry(mechanism)
        mx, my, s1x, s1y, s2x, s2y = p
        turn = -angle  # of the guide's direction, seen from the frame of the slider
        ux, uy = mx * math.cos(turn) - my * math.sin(turn), mx * math.sin(turn) + my * math.cos(turn)
        normal = self._normal()
        found: list[Contribution] = []
        for name, along, across in CORNERS:
            x, y = along * self.half_length, across * self.half_height
            corner = (s2x + x * ux - y * uy, s2y + x * uy + y * ux)
            numbers = (self.play, self.half_height, across, mx, my, s1x, s1y, *corner)
            laws = normal, self.friction, name
            contribution = ContactContribution(self.name, corner_gap_kernel, coordinates, numbers, *laws)
            found.append(contribution)
        sizes = (self.play, self.half_length, self.half_height)
        for k, (name, unit) in enumerate(SIGNALS):
            values = (*p, angle, *sizes, float(k))
            told = self.name, name, unit, slider_signal, coordinates, values
            found.append(SignalContribution(*told, is_mode=name == "mode"))
        _, speed = travel_contributions(self.name, coordinates, p)
        friction = rubbing(self.friction, guide_friction, (*p, 2.0 * self.half_length, 0.0))
        return [*found, speed, replace(self.ideal(mechanism), joint_friction=friction, holds="closed")]

    def _normal(self) -> NormalLaw:
        """The normal law of a corner on a flat side."""
        if self.corner_radius is not None:
            return self.normal.for_radii(math.inf, self.corner_radius)
        try:
            self.normal.parameters()
        except InputError as error:
            text = f"{self.label}: the stiffness of its law depends on the radius of the corners;"
            raise InputError(f"{text} give corner_radius=..., or a law with a stiffness of its own.") from error
        return self.normal
