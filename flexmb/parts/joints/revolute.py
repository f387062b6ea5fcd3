"""Revolute joints, ideal and with clearance, and the rigid connection."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import KW_ONLY, replace
from typing import TYPE_CHECKING, ClassVar

from flexmb import checks
from flexmb.errors import InputError
from flexmb.fields import field, not_negative, positive, record
from flexmb.findings.finding import Finding, found
from flexmb.kernels import Kernel, compiled, constraint_kernel, gap_kernel
from flexmb.model import contributions as pieces
from flexmb.model.law import FRICTION_LAW, NORMAL_LAW, FrictionLaw, NormalLaw
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Joint, Pose
from flexmb.parts.contact.friction import Frictionless
from flexmb.parts.joints import contact_point
from flexmb.places import ANGLE, JOURNAL, PIN

if TYPE_CHECKING:
    from flexmb.parts.wear.worn_clearance import WornClearance
    from flexmb.parts.wear.worn_joint import Wear


@compiled
def coincide(s1x, s1y, s2x, s2y, q, v, lam, g, G, gamma, H):
    """Constraint equations 0 and 1: g = x2 + R2 s2 - x1 - R1 s1 in X and Y."""
    # Equations (1.4) and (1.5) of docs/theory/equations_of_motion.md.
    ax, ay, bx, by, g[0], g[1] = contact_point.arms_of(s1x, s1y, s2x, s2y, q)
    G[0, 0] = -1.0
    G[0, 2] = ay
    G[0, 3] = 1.0
    G[0, 5] = -by
    G[1, 1] = -1.0
    G[1, 2] = -ax
    G[1, 4] = 1.0
    G[1, 5] = bx
    w1, w2 = v[2] * v[2], v[5] * v[5]
    gamma[0], gamma[1] = bx * w2 - ax * w1, by * w2 - ay * w1
    H[2, 2] = lam[0] * ax + lam[1] * ay
    H[5, 5] = -lam[0] * bx - lam[1] * by


AT_PIN, BY_ANGLES = ((0, 2, 3, 5), (1, 2, 4, 5)), ((2, 2), (5, 5))  # entries of G and H that `coincide` writes


@constraint_kernel
def coincidence_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Two points of two nodes coincide."""
    s1x, s1y, s2x, s2y = p
    coincide(s1x, s1y, s2x, s2y, q, v, lam, g, G, gamma, H)


@constraint_kernel
def weld_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Two points of two nodes coincide and the relative rotation stays."""
    s1x, s1y, s2x, s2y, angle = p
    coincide(s1x, s1y, s2x, s2y, q, v, lam, g, G, gamma, H)
    contact_point.put_turn(2, angle, q, g, G)


@constraint_kernel
def angle_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Relative rotation of two nodes: g = theta2 - theta1 - angle; q = (theta1, theta2)."""
    contact_point.difference(p, q, g, G)


def drawn_theta(mechanism: Mechanism, end: pieces.Attachment) -> float:
    """Theta of the node of an end in the reference configuration [rad]."""
    return mechanism.body(end.part).node(end.node).theta


def drawn_angle(mechanism: Mechanism, ends: pieces.Ends) -> float:
    """theta2 - theta1 of the nodes that a joint holds, in the reference configuration."""
    return drawn_theta(mechanism, ends.second) - drawn_theta(mechanism, ends.first)


def drawn_direction(
    mechanism: Mechanism, end: pieces.Attachment, along: tuple[float, float], turn: float = 0.0
) -> tuple[float, float]:
    """Unit vector along a direction of the reference configuration, turned by `turn` [rad], in the frame of a node."""
    angle = math.atan2(along[1], along[0]) + turn - drawn_theta(mechanism, end)
    return math.cos(angle), math.sin(angle)


def angle_contribution(part: str, mechanism: Mechanism, ends: pieces.Ends) -> pieces.AngleContribution:
    """Relative rotation of the second body against the first, 0 in the reference configuration, and its rate."""
    pair = (ends.first.part, ends.first.node, 2), (ends.second.part, ends.second.node, 2)
    return pieces.AngleContribution(part, pair, (drawn_angle(mechanism, ends),))


def coincidence_piece(part: str, ends: pieces.Ends, *, holds: str = "always") -> pieces.ConstraintContribution:
    """The two constraint equations of a revolute joint."""
    coordinates = ends.coordinates
    own = coincidence_kernel, coordinates, ends.offsets, 2, coordinates[3:]
    return pieces.ConstraintContribution(part, *own, holds=holds, columns=AT_PIN, curved=BY_ANGLES, known=PIN)


@record
class Revolute(Joint):
    """Ideal revolute joint (pin) between two bodies.

    Signals: fx, fy, force (on the second body) [N]; angle (of the second body against the first, 0 in the reference
    configuration) [rad], omega [rad/s]; with friction also friction_torque (on the second body) [N m].

    Raises
    ------
    InputError : friction without radius, or a radius without friction.

    Notes
    -----
    With friction N is the joint's force, and the slip radius (omega2 - omega1).
    The torque of a sliding Coulomb pin is mu radius |force| (the circle of friction has the radius mu radius; exactly
    mu/sqrt(1 + mu^2) radius, since fx and fy are the joint's force without the friction on its surface).
    """

    _: KW_ONLY
    friction: FrictionLaw | None = field("law of friction of the pin", rule=contact_point.JOINT_FRICTION, default=None)
    radius: float | None = field("radius of the pin, with friction", "m", positive, default=None)
    preload: float = field("further normal load, with friction", "N", not_negative, default=0.0)

    kind = "revolute"

    def __post_init__(self) -> None:
        super().__post_init__()
        contact_point.check_friction(self, "radius")

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        ends = self.ends(mechanism)
        contribution, angle = coincidence_piece(self.name, ends), angle_contribution(self.name, mechanism, ends)
        if self.friction is None or self.radius is None:
            return [contribution, angle]
        p, signal = (self.radius, self.preload), ("friction_torque", "N m")
        friction = pieces.JointFriction(contact_point.journal_friction, p, self.friction, signal, self.radius)
        return [replace(contribution, joint_friction=friction), angle]

    def drive_contribution(self, mechanism: Mechanism) -> pieces.ConstraintContribution | None:
        ends = self.ends(mechanism)
        own = self.name, angle_kernel, ends.coordinates[2::3], (drawn_angle(mechanism, ends),), 1
        return pieces.ConstraintContribution(*own, is_drive=True, curved=(), known=ANGLE)


@record
class Fixed(Joint):
    """Rigid connection of two bodies at a point.

    Signals: fx, fy, force (on the second body) [N], moment (on the second body, about the point) [N m].
    """

    kind = "fixed"
    holds_point = False

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        ends = self.ends(mechanism)
        p = (*ends.offsets, drawn_angle(mechanism, ends))
        own, columns = (self.name, weld_kernel, ends.coordinates, p, 3, ends.second.coordinates), (*AT_PIN, (2, 5))
        return [pieces.ConstraintContribution(*own, moment_row=2, columns=columns, curved=BY_ANGLES)]


@gap_kernel
def journal_gap_kernel(p, q, v, out):
    """Journal in a bearing, see `contact_point.journal_gap`."""
    contact_point.journal_gap(p, q, v, True, out)


@constraint_kernel
def held_journal_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """The journal's centre stands beside the bearing's by (ex, ey) along X and Y; rates as of an ideal joint."""
    s1x, s1y, s2x, s2y, ex, ey = p
    coincide(s1x, s1y, s2x, s2y, q, v, lam, g, G, gamma, H)
    g[0] -= ex
    g[1] -= ey


CENTRED, SEATED = "centred", "seated"
TOUCHING = 1.0 + 1e-12  # largest eccentricity over the clearance [1] of a journal in contact, round-off included


@record
class RevoluteClearance(Joint):
    """Revolute joint with clearance: the first body carries the bearing, the second one the journal.

    Signals: ex, ey (journal centre in the bearing) [m], vex, vey [m/s], penetration [m], penetration_rate [m/s],
    normal_force, friction_force, fx, fy, force (on the second body) [N], mode (0 free flight, 1 impact: from the
    closing of the gap to the end of the first rebound, 2 continuous contact); angle (of the second body against the
    first, 0 in the reference configuration) [rad], omega [rad/s].

    The centre of the bearing is `at`, and the journal's centre is declared there for any `start`: "centred"; "seated",
    in contact in the direction of gravity; or (ex, ey), the journal's centre less the bearing's along X and Y [m], at
    most `clearance` long.

    Raises
    ------
    InputError : clearance or radius out of range, a law of the wrong kind, a start outside the clearance, "seated"
        without gravity.

    Notes
    -----
    Start velocities are the velocities of an ideal joint, so the journal rests in its bearing for any `start`. The
    loops are closed with the journal in that place. "Seated" is e = clearance gravity/|gravity|; its opposite if the
    journal belongs to the ground, because the bearing then hangs on the journal. If other forces press on the joint,
    give (ex, ey). Analyses that replace the joint by an ideal one (modes, inverse dynamics) keep the eccentricity.
    """

    _: KW_ONLY
    clearance: float = field(
        "bearing radius less journal radius", "m", positive, hint="For a joint without clearance use Revolute(...)."
    )
    bearing_radius: float = field("radius of the bearing", "m", positive)
    normal: NormalLaw = field("law of the normal force", rule=NORMAL_LAW)
    friction: FrictionLaw = field("law of friction", rule=FRICTION_LAW, default_factory=Frictionless)
    start: str | tuple[float, float] = field("place of the journal at the start, see above", "m", default=CENTRED)

    kind = "clearance"
    lost_when: ClassVar[str] = "the journal passes through its bearing"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.clearance >= self.bearing_radius:
            text = f"{self.label}: clearance is {self.clearance:g} m; it must be smaller than the"
            raise InputError(f"{text} bearing radius {self.bearing_radius:g} m. Did you mix up metres and millimetres?")
        if isinstance(self.start, str):
            if self.start not in (CENTRED, SEATED):
                text = f"{self.label}: start is {self.start!r}; it must be {CENTRED!r}, {SEATED!r} or (ex, ey) in m."
                raise InputError(f"{text} {checks.did_you_mean(self.start, [CENTRED, SEATED])}")
            return
        e = checks.point(self.label, "start", self.start)
        beyond = math.hypot(*e) - self.play
        if beyond > (TOUCHING - 1.0) * self.play:
            text = f"{self.label}: start is ({e[0]:g}, {e[1]:g}) m, {beyond:.3g} m outside the clearance of"
            text += f" {self.play:g} m; the journal would begin inside the bearing's wall. Give a shorter (ex,"
            raise InputError(f'{text} ey), or start="seated" for a journal that touches where gravity pulls it.')
        object.__setattr__(self, "start", e)

    def validate(self, mechanism: Mechanism) -> None:
        """Refuse a seated journal without gravity."""
        super().validate(mechanism)
        if self.start == SEATED and math.hypot(*mechanism.gravity) <= 0.0:
            text = f"{self.label}: start is 'seated',"
            text += f" but mechanism {mechanism.name!r} has no gravity that pulls the journal anywhere."
            raise InputError(f"{text} Say where it stands with start=(ex, ey) in m, or give gravity=(0, -9.81).")

    def eccentricity(self, mechanism: Mechanism) -> tuple[float, float]:
        """Centre of the journal seen from that of the bearing at the start of `mechanism` [m]."""
        if self.start == CENTRED:
            return 0.0, 0.0
        if isinstance(self.start, tuple):
            return self.start
        (gx, gy), sign = mechanism.gravity, -1.0 if self.second.name == GROUND.name else 1.0
        factor = sign * self.play / math.hypot(gx, gy)
        return factor * gx, factor * gy

    @property
    def play(self) -> float:
        """Eccentricity at which the surfaces touch [m]."""
        return self.clearance

    @property
    def journal_radius(self) -> float:
        """Radius of the journal [m]."""
        return self.bearing_radius - self.clearance

    def worn_by(self, wear: Wear) -> WornClearance:
        """The joint with a surface that wears by the law `wear`, e.g. Archard(bearing=1e-13); unworn so far."""
        from flexmb.parts.wear.worn_clearance import WornClearance  # noqa: PLC0415 - it is a joint with clearance itself
        from flexmb.parts.wear.worn_joint import worn  # noqa: PLC0415

        return worn(self, RevoluteClearance, WornClearance, wear=wear)

    def idealised(self) -> Revolute:
        return Revolute(self.name, self.first, self.second, self.at)

    def findings_at_rest(self, mechanism: Mechanism, load: float, pose: Pose | None) -> Iterator[Finding]:  # noqa: ARG002
        """Finding on a contact into which weight and declared forces press by much of the radius."""
        radius = self.bearing_radius
        depth = self.normal.for_radii(radius, self.journal_radius).depth_under(load, radius) if load else 0.0
        if depth > self.deep_from * radius:
            more = "more than " if math.isinf(depth) else ""
            depth = min(depth, radius)
            text = f"A force of {load:.4g} N, of weights and loads, presses the journal of {self.label}"
            text += f" into its bearing by {more}{depth:.4g} m; the radius is {radius:.4g} m."
            remedy = "If it shall not be so soft: stiffness is in N/m^n, multiply one in N/mm^1.5 by 3.16e4."
            yield found("soft-contact", (self.name,), text, remedy, force=load, penetration=depth)

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        ends = self.ends(mechanism)
        p = (self.play, self.bearing_radius, *ends.offsets)
        normal = self.normal.for_radii(self.bearing_radius, self.journal_radius)
        own = self.name, journal_gap_kernel, ends.coordinates, p, normal, self.friction
        contact = pieces.ContactContribution(*own, known=JOURNAL)
        return [contact, angle_contribution(self.name, mechanism, ends), self._held(mechanism, ends)]

    def _held(self, mechanism: Mechanism, ends: pieces.Ends) -> pieces.ConstraintContribution:
        """The two constraint equations that hold the journal in its place at the start."""
        p = (*ends.offsets, *self.eccentricity(mechanism))
        friction = rubbing(self.friction, contact_point.journal_friction, (self.journal_radius, 0.0))
        place = self.name, held_journal_kernel, ends.coordinates, p, 2, ends.second.coordinates
        return pieces.ConstraintContribution(*place, joint_friction=friction, holds="closed")


def rubbing(law: FrictionLaw, kernel: Kernel, p: tuple[float, ...]) -> pieces.JointFriction | None:
    """Friction of the ideal joint that stands for one with clearance; None without friction."""
    return None if isinstance(law, Frictionless) else pieces.JointFriction(kernel, p, law)
