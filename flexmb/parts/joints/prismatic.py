"""Guides and slots: prismatic joint and pin in a slot, ideal and with clearance; a clamp that moves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, replace
from typing import TYPE_CHECKING, Any, cast

from flexmb import checks, places
from flexmb.errors import InputError, ModelError
from flexmb.fields import directed, field, instance, not_negative, point, positive, record
from flexmb.kernels import compiled, constraint_kernel, gap_kernel, joint_friction_kernel, signal_kernel
from flexmb.model import contributions as pieces
from flexmb.model.law import FRICTION_LAW, NORMAL_LAW, FrictionLaw, Motion, NormalLaw
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Joint, Part
from flexmb.model.shape import PointShape, Shapes
from flexmb.parts.contact.friction import Frictionless
from flexmb.parts.joints import contact_point
from flexmb.parts.joints.revolute import Revolute, drawn_angle, drawn_direction, rubbing
from flexmb.places import GUIDE

if TYPE_CHECKING:
    from flexmb.parts.wear.worn_guide import WornGuide, WornSlot
    from flexmb.parts.wear.worn_joint import Wear


# Entries of G and H that `guide_kernel` writes: the first row turns with the first node.
OF_GUIDE = (0, 1, 2, 3, 4, 5), (2, 5)
BY_TURN = ((5, 5), *((i, 2) for i in range(6)), *((2, i) for i in (0, 1, 3, 4, 5)))


@constraint_kernel
def guide_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Slider in a guide on the first body: no offset across the guide, no relative rotation."""
    contact_point.slide(p, q, v, lam, g, G, gamma, H)


@constraint_kernel
def travel_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Travel of the second body along the guide, 0 in the reference configuration."""
    ux, uy, s1x, s1y, s2x, s2y = p
    contact_point.direction_row(ux, uy, s1x, s1y, s2x, s2y, q, v, lam, 0, g, G, gamma, H)


@compiled
def turned(x, y, angle):
    """Vector turned by an angle; most are zero, or belong to the ground, and need no sine."""
    if angle == 0.0 or (x == 0.0 and y == 0.0):
        return x, y
    c, s = math.cos(angle), math.sin(angle)
    return c * x - s * y, s * x + c * y


@signal_kernel
def travel_signal(p, t, q, v, a):
    """Travel of the second body's point along a direction of the first body."""
    ux, uy, s1x, s1y, s2x, s2y = p
    nx, ny = turned(ux, uy, q[2])
    bx, by = turned(s2x, s2y, q[5])
    return nx * (q[3] + bx - q[0]) + ny * (q[4] + by - q[1]) - ux * s1x - uy * s1y


@signal_kernel
def speed_signal(p, t, q, v, a):
    """Rate of `travel_signal`."""
    ux, uy, _, _, s2x, s2y = p
    nx, ny = turned(ux, uy, q[2])
    bx, by = turned(s2x, s2y, q[5])
    vx, vy = v[3] - v[5] * by - v[0], v[4] + v[5] * bx - v[1]
    return nx * vx + ny * vy + v[2] * (nx * (q[4] + by - q[1]) - ny * (q[3] + bx - q[0]))


def travel_contributions(
    part: str, coordinates: tuple[pieces.Coordinate, ...], p: tuple[float, ...]
) -> tuple[pieces.SignalContribution, pieces.SignalContribution]:
    """Signals travel [m] and speed [m/s] of a point of the second body along a line of the first."""
    # `coordinates` are the six of both nodes, `p` the direction of the line and both points in the frames of their
    # nodes.
    travel = pieces.SignalContribution(part, "travel", "m", travel_signal, coordinates, p)
    return travel, pieces.SignalContribution(part, "speed", "m/s", speed_signal, coordinates, p)


@record
class OnLine(Joint):
    """Base of joints that hold a point of the second body on a line of the first."""

    along: tuple[float, float] = field("direction of the line", rule=directed, default=(1.0, 0.0))

    holds_point = False

    def shapes(self, mechanism: Mechanism) -> Shapes:
        line, point = self.ends(mechanism)
        return (PointShape(self.name, self.kind, *point.place, other=line.place, along=self.line(mechanism)[:2]),)

    def line(self, mechanism: Mechanism) -> tuple[float, float, float, float, float, float]:
        """Direction of the line in `mechanism`, and both points, in the frames of their nodes."""
        ends = self.ends(mechanism)
        return (*drawn_direction(mechanism, ends.first, self.along), *ends.offsets)


@record
class Guide(OnLine):
    """Base of joints whose second body slides along a guide of the first."""

    at: Any = field("the joint's point; None: the main node of the second body", "m", point, default=None)
    along: tuple[float, float] = field("direction of the guide", rule=directed, default=(1.0, 0.0))

    def ideal(self, mechanism: Mechanism) -> pieces.ConstraintContribution:
        """The two constraint equations of a slider without clearance in `mechanism`."""
        ends = self.ends(mechanism)
        p = *self.line(mechanism), drawn_angle(mechanism, ends)
        own = self.name, guide_kernel, ends.coordinates, p, 2, ends.second.coordinates, 1
        return pieces.ConstraintContribution(*own, columns=OF_GUIDE, curved=BY_TURN, known=GUIDE)


@record
class Prismatic(Guide):
    """Ideal prismatic joint (slider) between any two bodies; the guide belongs to the first one.

    Signals: fx, fy, force (on the second body) [N], moment (on the second body, about its joint point) [N m]; travel
    along the guide (0 in the reference configuration) [m], speed [m/s]; with friction also friction_force (on the
    second body, along the guide) [N], which fx and fy do not contain.  Force F and moment M of the joint press the two
    ends of a slider of length l, N = |F/2 + M/l| + |F/2 - M/l|.

    Raises
    ------
    InputError : a direction without length; friction without length.
    """

    _: KW_ONLY
    friction: FrictionLaw | None = field(
        "law of friction between slider and guide", rule=contact_point.JOINT_FRICTION, default=None
    )
    length: float | None = field("length l of the slider along the guide, with friction", "m", positive, default=None)
    preload: float = field("further normal load, with friction", "N", not_negative, default=0.0)

    kind = "prismatic"
    is_guide = True

    def __post_init__(self) -> None:
        super().__post_init__()
        contact_point.check_friction(self, "length")

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        ideal, line = self.ideal(mechanism), self.line(mechanism)
        signals = travel_contributions(self.name, ideal.coordinates, line)
        if self.friction is None or self.length is None:
            return [ideal, *signals]
        rubs = contact_point.guide_friction, (*line, self.length, self.preload), self.friction
        return [replace(ideal, joint_friction=pieces.JointFriction(*rubs)), *signals]

    def drive_contribution(self, mechanism: Mechanism) -> pieces.ConstraintContribution | None:
        ends = self.ends(mechanism)
        own = self.name, travel_kernel, ends.coordinates, self.line(mechanism), 1, ends.second.coordinates
        return pieces.ConstraintContribution(*own, is_drive=True, drive_units=("m", "N"))


def joint_with_coordinate(mechanism: Mechanism, label: str, name: Part | str) -> Revolute | Prismatic:
    """The joint of that name, which has an angle or a travel; others are refused."""
    if name not in mechanism.names:
        joints = [part.name for part in mechanism.parts if isinstance(part, Joint)]
        text = f"{label} refers to joint {name!r}, but mechanism {mechanism.name!r} has no such part"
        raise ModelError(f"{text}. {checks.did_you_mean(name, joints)}")
    part = mechanism.find(name)
    if not isinstance(part, Revolute | Prismatic):
        raise ModelError(f"{label}: {part.label} has no angle or travel. Give a Revolute or a Prismatic joint.")
    return part


# Coordinates of the second body in the frame of the first, with units of coordinate and force.
ROWS = (("x", "m", "N"), ("y", "m", "N"), ("angle", "rad", "N m"))


@constraint_kernel
def clamp_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Point of the second node against that of the first, along the axes of the first; relative rotation."""
    s1x, s1y, s2x, s2y, angle = p
    contact_point.direction_row(1.0, 0.0, s1x, s1y, s2x, s2y, q, v, lam, 0, g, G, gamma, H)
    contact_point.direction_row(0.0, 1.0, s1x, s1y, s2x, s2y, q, v, lam, 1, g, G, gamma, H)
    contact_point.put_turn(2, angle, q, g, G)


MOTION = instance(Motion, "a motion, e.g. Ramp(6.28, 0.5)")  # rule of the motions of a clamp


@record
class Clamp(Joint):
    """Rigid connection of two bodies at a point, moved: angle and position of the second follow motions.

    R1^T (x2 + R2 s2 - x1) - s1 = (x, y)(t) and theta2 - theta1 = reference value + angle(t), with the motions counted
    from the reference configuration.

    Signals: fx, fy, force (on the second body, world axes) [N], moment (on the second body, about its point) [N m]; for
    each motion x, x_rate, x_force, x_power [m, m/s, N, W], the same of y, and angle, angle_rate, angle_torque,
    angle_power [rad, rad/s, N m, W]; the forces act on the second body along the axes of the first.

    Raises
    ------
    InputError : an object that is no motion, a motion that jumps, or no motion at all.

    Notes
    -----
    The axes of the first body are the axes of the node that is held: along and across a link, X and Y for the ground.
    """

    _: KW_ONLY
    angle: Motion | None = field("motion of the relative angle; None: constant", "rad", MOTION, default=None)
    x: Motion | None = field("motion of the point along x of the first body; None: constant", "m", MOTION, default=None)
    y: Motion | None = field("motion of the point along y of the first body; None: constant", "m", MOTION, default=None)

    kind = "fixed"
    holds_point = False

    def __post_init__(self) -> None:
        super().__post_init__()
        given = {name: getattr(self, name) for name, *_ in ROWS}
        for name, motion in given.items():
            if motion is not None and not motion.is_smooth:
                text = f"{self.label}: {name} is {type(motion).__name__}(...), whose value or speed jumps;"
                text += " a clamp would need an infinite force to follow."
                raise InputError(f"{text} Move it with Table, Ramp or CycloidalRamp.")
        if all(motion is None for motion in given.values()):
            raise InputError(f"{self.label}: angle, x and y are None; give a motion, or use Fixed(...) for a weld.")

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        ends = self.ends(mechanism)
        p = (*ends.offsets, drawn_angle(mechanism, ends))
        driven = ((row, getattr(self, name), name, (u, f)) for row, (name, u, f) in enumerate(ROWS))
        motions = tuple(pieces.RowMotion(*each) for each in driven if each[1] is not None)
        own = self.name, clamp_kernel, ends.coordinates, p, 3, ends.second.coordinates
        return [pieces.ConstraintContribution(*own, moment_row=2, motions=motions)]


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
    contact_point.put_point(out, q, v, c + half - nx * ex - ny * ey, nx, ny, X, Y)
    vex = v[3] - v[5] * by - v[0] + v[2] * (d1 * s1x + c1 * s1y)
    vey = v[4] + v[5] * bx - v[1] - v[2] * (c1 * s1x - d1 * s1y)
    contact_point.put_eccentricity(out, ex, ey, vex, vey)
    contact_point.put_side_columns(out, nx, ny, bx, by)


@signal_kernel
def slider_signal(p, t, q, v, a):
    """`chosen`: 0 travel, 1 offset, 2 tilt, 3 mode (0 free, 1 one corner, 2 two across, 3 face, 4 more)."""
    mx, my, s1x, s1y, s2x, s2y, angle, c, length, height, chosen = p
    # Travel, offset across the guide and tilt of the slider's centre
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    ex = q[3] + c2 * s2x - d2 * s2y - q[0] - c1 * s1x + d1 * s1y
    ey = q[4] + d2 * s2x + c2 * s2y - q[1] - d1 * s1x - c1 * s1y
    ux, uy = c1 * mx - d1 * my, d1 * mx + c1 * my
    travel, offset, tilt = ux * ex + uy * ey, ux * ey - uy * ex, q[5] - q[2] - angle
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
    return 4.0 if touching > 2 else (2.0 if upper == lower else 3.0)


SIGNALS = (("travel", "m"), ("offset", "m"), ("tilt", "rad"), ("mode", ""))  # the mode is the last one


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

        return worn(self, PrismaticClearance, WornGuide, wear=wear, worn_length=length)

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        ideal, p = self.ideal(mechanism), self.line(mechanism)
        coordinates, angle = ideal.coordinates, ideal.p[-1]
        mx, my, s1x, s1y, s2x, s2y = p
        turn = -angle  # of the guide's direction, seen from the frame of the slider
        ux, uy = mx * math.cos(turn) - my * math.sin(turn), mx * math.sin(turn) + my * math.cos(turn)
        normal, found = self.normal, list[pieces.Contribution]()
        if self.corner_radius is not None:  # of a corner on a flat side
            normal = normal.for_radii(math.inf, self.corner_radius)
        else:
            try:
                normal.parameters()
            except InputError as error:
                text = f"{self.label}: the stiffness of its law depends on the radius of the corners;"
                raise InputError(f"{text} give corner_radius=..., or a law with a stiffness of its own.") from error
        for name, along, across in CORNERS:
            x, y = along * self.half_length, across * self.half_height
            corner = (s2x + x * ux - y * uy, s2y + x * uy + y * ux)
            numbers = (self.play, self.half_height, across, mx, my, s1x, s1y, *corner)
            laws = normal, self.friction, name
            found.append(pieces.ContactContribution(self.name, corner_gap_kernel, coordinates, numbers, *laws))
        values = (*p, angle, self.play, self.half_length, self.half_height)
        *told, mode = pieces.signal_contributions(self.name, slider_signal, SIGNALS, coordinates, values)
        found += [*told, replace(mode, is_mode=True)]
        _, speed = travel_contributions(self.name, coordinates, p)
        friction = rubbing(self.friction, contact_point.guide_friction, (*p, 2.0 * self.half_length, 0.0))
        return [*found, speed, replace(ideal, joint_friction=friction, holds="closed")]


@constraint_kernel
def slot_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """A point of the second body stays on a straight line of the first."""
    ux, uy, s1x, s1y, s2x, s2y = p
    contact_point.direction_row(-uy, ux, s1x, s1y, s2x, s2y, q, v, lam, 0, g, G, gamma, H)


@joint_friction_kernel
def slot_friction(p, q, lam, out, H):
    """Pin of radius R on the side of the slot that holds it: N = |F|, slip = rate of travel +- R (omega2 - omega1)."""
    ux, uy, s1x, s1y, s2x, s2y, R = p
    side = math.copysign(1.0, lam[0])
    out[places.LOAD], out[places.LOAD_BY_LAM] = abs(lam[0]), side
    _, J, nx, ny, far, near = contact_point.direction(ux, uy, s1x, s1y, s2x, s2y, q)
    for j in range(6):
        out[places.SLIDING + j] = J[j]
    for theta, arm in ((2, R), (5, -R)):
        out[places.SLIDING + theta] += side * arm
    contact_point.add_curvature(1.0, nx, ny, far, near, H)


@gap_kernel
def slot_gap_kernel(p, q, v, out):
    """Round pin in a slot with round ends: e from the nearest point of the middle line, gap = c - |e|, n = e/|e|."""
    # The contact point lies half the depth beyond the pin's surface, so both bodies are pushed at one point.
    c, reach, radius, mx, my, s1x, s1y, s2x, s2y = p
    ax, ay, bx, by, ex, ey = contact_point.arms_of(s1x, s1y, s2x, s2y, q)
    c1, d1 = math.cos(q[2]), math.sin(q[2])
    ux, uy = c1 * mx - d1 * my, d1 * mx + c1 * my
    along, across = ux * ex + uy * ey, ux * ey - uy * ex
    side = abs(along) <= reach
    if side:
        size, sign = abs(across), 1.0 if across >= 0.0 else -1.0
        nx, ny = -sign * uy, sign * ux
    else:
        end = reach if along > 0.0 else -reach
        ax, ay = ax + end * ux, ay + end * uy  # the middle of the round end
        ex, ey = ex - end * ux, ey - end * uy
        size = math.sqrt(ex * ex + ey * ey)
        nx, ny = ex / size, ey / size
    ahead = radius + 0.5 * (c + size) - size  # from the pin's centre to the contact point
    contact_point.put_point(out, q, v, c - size, nx, ny, q[3] + bx + ahead * nx, q[4] + by + ahead * ny)
    vx, vy = v[3] - v[5] * by - v[0] + v[2] * ay, v[4] + v[5] * bx - v[1] - v[2] * ax
    wx, wy = (size * nx, size * ny) if side else (ex, ey)
    if side:  # the middle line turns; the way along it does not count
        vx, vy = -out[places.GAP_RATE] * nx - v[2] * wy, -out[places.GAP_RATE] * ny + v[2] * wx
    contact_point.put_eccentricity(out, wx, wy, vx, vy)
    for j in range(6):
        # of the pin's centre from the middle, or the round end
        gx, gy, _, _ = contact_point.difference_column(j, ax, ay, bx, by)
        Xq, Yq = (gx, gy) if j > 2 else (0.0, 0.0)
        grows = nx * gx + ny * gy
        if side:
            nqx, nqy = (-ny, nx) if j == 2 else (0.0, 0.0)
            grows += nx * ey - ny * ex if j == 2 else 0.0  # the line turns, too
        else:
            turn = (nx * gy - ny * gx) / size
            nqx, nqy = -ny * turn, nx * turn
        px, py = Xq + ahead * nqx - 0.5 * grows * nx, Yq + ahead * nqy - 0.5 * grows * ny
        contact_point.put_column(out, j, nqx, nqy, px, py)


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

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        coordinates, p = self.ends(mechanism).coordinates, self.line(mechanism)
        row = pieces.ConstraintContribution(self.name, slot_kernel, coordinates, p, 1, second=coordinates[3:])
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

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        p = self.line(mechanism)
        reach = 1e300 if self.length is None else 0.5 * self.length
        normal = self.normal.for_radii(math.inf, self.pin_radius)
        sizes, laws = (self.clearance, reach, self.pin_radius), (normal, self.friction)
        row, *signals = super().contributions(mechanism)
        friction = rubbing(self.friction, slot_friction, (*p, self.pin_radius))
        ideal = replace(cast("pieces.ConstraintContribution", row), joint_friction=friction, holds="closed")
        contact = pieces.ContactContribution(self.name, slot_gap_kernel, ideal.coordinates, (*sizes, *p), *laws)
        return [contact, *signals, ideal]
