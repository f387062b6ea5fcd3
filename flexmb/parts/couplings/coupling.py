"""Linear relations of angles and travels, equal rotation, one-way clutches; rods and cables between two points."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from typing import Any

import numpy as np

from flexmb import checks, planar
from flexmb.errors import InputError, ModelError
from flexmb.fields import Rule, field, not_negative, one_of, positive, record, vector
from flexmb.findings.finding import Finding, found
from flexmb.kernels import compiled, constraint_kernel, friction_law, joint_friction_kernel, signal_kernel
from flexmb.model import contributions as pieces
from flexmb.model.law import FrictionLaw, NormalLaw
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Joint, Part, PointToPoint, WatchedMotion, name_of, refuse_one_body
from flexmb.model.shape import CABLE, ROD, CircleShape, LineShape, Shapes
from flexmb.parts.contact.friction import Frictionless
from flexmb.parts.joints.contact_point import arms_of, curvature_times, direction, dot
from flexmb.parts.joints.prismatic import Prismatic, joint_with_coordinate, speed_signal
from flexmb.parts.joints.revolute import Revolute, coincidence_piece, drawn_angle, drawn_theta
from flexmb.parts.joints.stop import NO_CLEARANCE, own_stiffness, strand, strand_gap_kernel, strand_length
from flexmb.places import LOAD, LOAD_BY_Q, SLIDING


@constraint_kernel
def angles_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """g = sum of p[i] q[i], less p[n]."""
    n = q.shape[0]
    total = -p[n]
    for i in range(n):
        total += p[i] * q[i]
        G[0, i] = p[i]
    g[0] = total


def angle_of(mechanism: Mechanism, part: str, owner: str) -> tuple[pieces.Coordinate, float]:
    """Angle of the main node of a body, and its value in the reference configuration [rad]."""
    body = mechanism.body(part, owner)
    return (body.name, body.main, 2), body.node(body.main).theta


def angles_contribution(
    mechanism: Mechanism, owner: Part, factors: Sequence[tuple[Part, float]], reactions: tuple[pieces.Reaction, ...]
) -> pieces.ConstraintContribution:
    """Equation sum of factor times angle = its value as drawn [rad]; factors in metres make the multiplier a force."""
    moving = ((part.name, factor) for part, factor in factors if part.name != GROUND.name)
    found = [(*angle_of(mechanism, name, owner.label), factor) for name, factor in moving]
    p = (*(factor for *_, factor in found), sum(factor * angle for _, angle, factor in found))
    coordinates = tuple(coordinate for coordinate, *_ in found)
    return pieces.ConstraintContribution(owner.name, angles_kernel, coordinates, p, 1, reactions=reactions)


@record
class SameRotation(Part):
    """Two bodies that keep their relative angle, as a parallel guide or a coupling of shafts does; they may be apart.

    Signals: torque (on the second body) [N m].

    Raises
    ------
    ModelError : a body with itself.
    """

    first: Part = field("first body; `GROUND` for a body that must not turn")
    second: Part = field("second body")

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_one_body(self, "couples {} with")

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        factors = (self.first, -1.0), (self.second, 1.0)
        return [angles_contribution(mechanism, self, factors, (pieces.Reaction("torque", "N m", 0, 1.0),))]


COUNT, VALUE, BEGIN = range(3)  # places in p: number of joints, value of the sum; where the joints begin

TURNS, FACTOR, X1, Y1, THETA1, X2, Y2, THETA2, DRAWN, AXIS_Y = range(10)
OFFSET1_X, OFFSET1_Y, OFFSET2_X, OFFSET2_Y, SIZE = range(10, 15)
# Numbers of a joint: whether its angle counts, factor, places of the six coordinates; then the angle as it is drawn, or
# direction of the guide and both points in the frames of their nodes. SIZE: their number.
AXIS_X = DRAWN


@constraint_kernel
def coupling_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """g = sum of factor times angle or travel of each joint, less a value."""
    g[0] = -p[VALUE]
    for joint in range(int(p[COUNT])):
        k = BEGIN + SIZE * joint
        theta1, theta2, factor = int(p[k + THETA1]), int(p[k + THETA2]), p[k + FACTOR]
        if p[k + TURNS] > 0.0:
            g[0] += factor * (q[theta2] - q[theta1] - p[k + DRAWN])
            G[0, theta1] -= factor
            G[0, theta2] += factor
            continue
        x1, y1, x2, y2 = int(p[k + X1]), int(p[k + Y1]), int(p[k + X2]), int(p[k + Y2])
        own_q = q[x1], q[y1], q[theta1], q[x2], q[y2], q[theta2]
        own_v = v[x1], v[y1], v[theta1], v[x2], v[y2], v[theta2]
        numbers = (p[k + AXIS_X], p[k + AXIS_Y], p[k + OFFSET1_X], p[k + OFFSET1_Y], p[k + OFFSET2_X], p[k + OFFSET2_Y])
        travel, J, nx, ny, far, near = direction(*numbers, own_q)
        places = (x1, y1, theta1, x2, y2, theta2)
        g[0] += factor * travel
        for i in range(6):
            G[0, places[i]] += factor * J[i]
        gamma[0] -= factor * dot(curvature_times(nx, ny, far, near, own_v), own_v)
        force = lam[0] * factor
        H[theta1, theta1] -= force * far
        H[theta2, theta2] -= force * near
        H[theta1, theta2] += force * near
        H[theta2, theta1] += force * near
        for place, x in ((x1, force * ny), (y1, -force * nx), (x2, -force * ny), (y2, force * nx)):
            H[place, theta1] += x
            H[theta1, place] += x


@signal_kernel
def angle_rate(p, t, q, v, a):
    """Angular velocity of the second node against the first."""
    return v[1] - v[0]


@record
class Coupling(Part):
    """Linear relation of joint coordinates: the sum of factor times angle or travel of named joints is constant.

    A screw is {"nut": -pitch / (2 pi), "slide": 1.0}; a differential {"left": 1.0, "right": 1.0, "cage": -2.0}.

    Signals of each joint J: J_torque (on its second body) [N m] or J_force (along its guide) [N], J_speed [rad/s or
    m/s], J_power [W]; the powers add up to 0.

    Raises
    ------
    InputError : no joints, factors that are no numbers or 0.
    ModelError : no such joint, or a joint without angle or travel.

    Notes
    -----
    The force on a joint's coordinate is minus factor times the multiplier, so torques and forces are to one another as
    the factors.  Ideal: no mass, no backlash, no losses.  Angles count on over whole turns.
    """

    factors: Any = field("factor of each joint by its name, not 0")
    value: float = field("value of the sum, in the units of factor times coordinate", default=0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        given = self.factors
        if not isinstance(given, Mapping) and not isinstance(given, tuple):
            raise InputError(f"{self.label}: factors is {given!r}; give a dictionary such as {{'O': 2.0, 'Q': -1.0}}.")
        pairs = tuple(given.items()) if isinstance(given, Mapping) else given
        if not pairs:
            raise InputError(f"{self.label}: factors is empty; give the factor of at least one joint.")
        checked = []
        for pair in pairs:
            if not isinstance(pair, tuple) or len(pair) != 2:
                raise InputError(f"{self.label}: factors holds {pair!r}; give pairs of a joint and its factor.")
            name = name_of(pair[0])
            if not isinstance(name, str):
                raise InputError(f"{self.label}: factors holds the joint {pair[0]!r}; give joints or their names.")
            checked.append((name, checks.number(self.label, f"factors[{name!r}]", pair[1])))
            if checked[-1][1] == 0.0:
                raise InputError(f"{self.label}: factors[{name!r}] is 0, so the joint does not count; leave it out.")
        names = [name for name, _ in checked]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise InputError(f"{self.label}: factors holds joint {twice!r} twice; add up its factors.")
        object.__setattr__(self, "factors", tuple(checked))

    def validate(self, mechanism: Mechanism) -> None:
        """Check that all joints exist and have an angle or a travel."""
        self._joints(mechanism)

    def _joints(self, mechanism: Mechanism) -> list[tuple[Revolute | Prismatic, float]]:
        """Joints of the coupling with their factors."""
        return [(joint_with_coordinate(mechanism, self.label, name), factor) for name, factor in self.factors]

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        joints = self._joints(mechanism)
        places: dict[pieces.Coordinate, int] = {}
        numbers: list[float] = [float(len(joints)), self.value]
        reactions: list[pieces.Reaction] = []
        signals: list[pieces.Contribution] = []
        for joint, factor in joints:
            ends = joint.ends(mechanism)
            coordinates, turns = ends.coordinates, not isinstance(joint, Prismatic)
            drawn = (drawn_angle(mechanism, ends), *(5 * (0.0,)))
            own = joint.line(mechanism) if isinstance(joint, Prismatic) else drawn
            for coordinate in coordinates[2::3] if turns else coordinates:
                places.setdefault(coordinate, len(places))
            numbers += [float(turns), factor, *(float(places.get(coordinate, -1)) for coordinate in coordinates), *own]
            kind, units = ("torque", "N m") if turns else ("force", "N")
            speed = f"{joint.name}_speed"
            reactions.append(pieces.Reaction(f"{joint.name}_{kind}", units, 0, factor))
            reactions.append(pieces.Reaction(f"{joint.name}_power", "W", 0, factor, rate=speed))
            rate = (angle_rate, coordinates[2::3], ()) if turns else (speed_signal, coordinates, own)
            signals.append(pieces.SignalContribution(self.name, speed, "rad/s" if turns else "m/s", *rate))
        equation = self.name, coupling_kernel, tuple(places), tuple(numbers), 1, None if turns else coordinates[3:]
        return [pieces.ConstraintContribution(*equation, reactions=tuple(reactions)), *signals]


LARGE_WIND_UP = 0.5  # wind-up above which there is a remark [rad]
COARSE_STEP = 0.35  # fixed step over the time of an engagement above which there is a remark: speeds are off by 2 %
# Places in the history: wind-up [rad]; its rate [rad/s] and the angle [rad] at the last state; 1 from then on.
WIND_UP, LAST_RATE, LAST_ANGLE, BEGUN = range(4)
COUNTER_CLOCKWISE, CLOCKWISE = "counter-clockwise", "clockwise"


@joint_friction_kernel
def clutch_rotation(p, q, lam, out, H):
    """Sliding is the relative angular velocity; the relative angle stands in place of a load."""
    out[LOAD] = q[5] - q[2]
    for theta, arm in ((2, -1.0), (5, 1.0)):
        out[SLIDING + theta], out[LOAD_BY_Q + theta] = arm, arm


@friction_law
def clutch_kernel(p, h, slip, angle, z, z_new):
    """T = side max(0, k w + d w_dot), w_dot = -side slip while w > 0; w grows with the angle from w_dot > 0 on."""
    k, d, side = p
    rate, last, w, w_rate, w_angle = -side * slip, z[LAST_RATE], z[WIND_UP], 0.0, 0.0
    if z[BEGUN] == 0.0:
        w = 0.0
    elif w > 0.0 or last >= 0.0:
        w += side * (z[LAST_ANGLE] - angle)
        w_angle = -side
    elif rate > 0.0:  # within the step, rate grows from last < 0 to rate > 0
        span = rate - last
        w = 0.5 * h * rate * rate / span
        w_rate = 0.5 * h * rate * (rate - 2.0 * last) / (span * span)
    z_new[LAST_RATE], z_new[LAST_ANGLE], z_new[BEGUN] = rate, angle, 1.0
    if w <= 0.0:
        w, w_rate, w_angle = 0.0, 0.0, 0.0
    z_new[WIND_UP] = w
    torque = k * w + d * rate
    if torque <= 0.0:
        return 0.0, 0.0, 0.0
    return side * torque, -(k * w_rate + d), side * k * w_angle


@dataclass(frozen=True)
class WindUp(FrictionLaw):
    """Torque of a one-way clutch: a spring and damper that act against rotation one way."""

    stiffness: float  # k [N m/rad], > 0
    damping: float  # d [N m s/rad], >= 0
    side: float  # 1.0 if positive rotation is free, -1.0 if negative rotation is free

    kernel = clutch_kernel

    def history(self) -> tuple[float, ...]:
        """Wind-up [rad], its rate [rad/s], the angle [rad], and whether both are known."""
        return 0.0, 0.0, 0.0, 0.0


@record
class OneWayClutch(Joint):
    """Pin with a one-way clutch (freewheel, roller or sprag clutch, backstop): its second body turns freely one way.

    Against rotation the other way stands the torque stiffness w + damping dw/dt of its wind-up w >= 0, which begins
    where the relative rotation turns back and ends where w is 0 again; the torque never changes its sign.

    Signals: fx, fy, force (on the second body) [N], torque (on the second body) [N m].

    Raises
    ------
    InputError : stiffness not > 0, negative damping, an unknown direction.

    Notes
    -----
    The clutch engages at any angle, without backlash and without drag while it overruns; it does not slip under too
    large a torque.  It yields torque/stiffness and does not creep.  The ledger counts the energy of the wind-up as
    dissipated in friction, and gives it back as the clutch unwinds.  Statics and modes know no wind-up: it resists
    nothing there.  Where it holds, replace it by a `Revolute` and a `TorsionSpring` of its stiffness.
    Source of the model, an engaged clutch as a spring that cannot pull: F. Zhu, R. G. Parker, Non-linear dynamics of a
    one-way clutch in belt-pulley systems, Journal of Sound and Vibration 279 (2005) 285-308.
    """

    _: KW_ONLY
    stiffness: float = field("torsional stiffness of the engaged clutch", "N m/rad", positive)
    damping: float = field("damping of the engaged clutch", "N m s/rad", not_negative, default=0.0)
    free: str = field("free turn of the second", rule=one_of(COUNTER_CLOCKWISE, CLOCKWISE), default=COUNTER_CLOCKWISE)

    kind = "revolute"

    def findings_after(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterator[Finding]:
        """Findings on a wind-up that no clutch bears, and on an engagement of a few fixed steps."""
        torque, when = motion.peak(f"{self.name}.torque")
        if torque > LARGE_WIND_UP * self.stiffness:
            angle = torque / self.stiffness
            text = f"At t = {when:.6g} s {self.label} is wound up by some {angle:.4g} rad."
            yield found("unreal-motion", (self.name,), text, "Its stiffness is in N m/rad.", time=when, angle=angle)
        # Time in which the largest torque changes the speed of the bodies: J/damping or sqrt(J/stiffness), whichever is
        # shorter. J is the torque over the largest acceleration, at least the moment of inertia of the rigid bodies,
        # since impacts accelerate them more.
        acceleration, inverse = 0.0, 0.0
        for end in self.ends(mechanism):
            name = f"{end.part}.{end.node}.alpha" if end.node else f"{end.part}.alpha"
            acceleration += motion.peak(name)[0] if name in motion.signals.places else 0.0
            inertia = getattr(self.first if end.part == self.first.name else self.second, "inertia", None)
            inverse += 1.0 / inertia if isinstance(inertia, float) else 0.0
        h, duration = motion.fixed_step, math.inf
        if torque != 0.0 and acceleration != 0.0:
            J = max(torque / acceleration, 1.0 / inverse if inverse > 0.0 else 0.0)
            duration = min(J / self.damping if self.damping > 0.0 else math.inf, math.sqrt(J / self.stiffness))
        if h is not None and h > COARSE_STEP * duration:
            text = f"{self.label} engages at t = {when:.6g} s within some {duration:.2g} s, in which a fixed step of"
            text = f"{text} {h:.3g} s is long: speeds behind it may be off by 2 % or more."
            remedy = f"Take steps of {0.1 * duration:.1g} s, or Adaptive()."
            yield found("coarse-step", (self.name,), text, remedy, step=h, duration=duration)

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        law = WindUp(self.stiffness, self.damping, 1.0 if self.free == COUNTER_CLOCKWISE else -1.0)
        clutch = pieces.JointFriction(clutch_rotation, (), law, ("torque", "N m"))
        return [replace(coincidence_piece(self.name, self.ends(mechanism)), joint_friction=clutch)]


FIRST_ANGLE, SECOND_ANGLE = 2, 5  # places of the angles of two nodes among their coordinates


@compiled
def line_between(s1x, s1y, s2x, s2y, q):
    """Line from a point of the first node to one of the second: length, direction e; derivatives by q (6,)."""
    # With d = x2 + R2 s2 - x1 - R1 s1 these are along = e . dd/dq, that of the length, and across = n . dd/dq with n =
    # (-ey, ex), that of the angle times the length. Second derivatives of the length are across across^T/length, of the
    # angle -(along across^T + across along^T)/length^2; besides, by (2, 2) and (5, 5), -across and along/length.
    ax, ay, bx, by, dx, dy = arms_of(s1x, s1y, s2x, s2y, q)
    size = math.sqrt(dx * dx + dy * dy)
    ex, ey = dx / size, dy / size
    along = (-ex, -ey, ex * ay - ey * ax, ex, ey, ey * bx - ex * by)
    return size, ex, ey, along, (ey, -ex, -ey * ay - ex * ax, -ey, ex, ex * bx + ey * by)


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


@record
class Distance(PointToPoint):
    """Massless rigid rod with a pin at each end: two points of two bodies keep their distance.

    Signals: force (tension of the rod; negative: pressure) [N].

    Raises
    ------
    InputError : points that coincide: such a rod is a revolute joint.
    ModelError : a rod from a body to itself.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        if planar.distance(self.at, self.to) == 0.0:
            raise InputError(f"{self.label}: both points are {self.at}; a rod needs a length. Use Revolute(...).")
        refuse_one_body(self)

    def shapes(self, mechanism: Mechanism) -> Shapes:
        first, second = self.ends(mechanism)
        return (LineShape(self.name, ROD, first.place, second.place),)

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        ends, tension = self.ends(mechanism), pieces.Reaction("force", "N", 0, -1.0)
        own = (*ends.offsets, planar.distance(self.at, self.to)), 1, ends.second.coordinates
        return [pieces.ConstraintContribution(self.name, distance_kernel, ends.coordinates, *own, reactions=(tension,))]


def rounds(
    part: Part, motion: WatchedMotion, ends: pieces.Ends, R: float, drawn: np.ndarray, hint: str
) -> Iterator[Finding]:
    """Finding on a line between two points, or a tangent of circles about them, that leaves half a turn."""
    d = np.vstack([drawn, motion.point(ends.second.place) - motion.point(ends.first.place)])
    angle = np.arctan2(d[:, 1], d[:, 0]) - np.arcsin(np.clip(R / np.hypot(*d.T), -1.0, 1.0))
    turn = np.abs(np.unwrap(angle) - angle[0])
    if (k := int(np.argmax(turn > math.pi))) > 0:
        text = f"At t = {(when := motion.times[k - 1]):.6g} s {part.label} has turned by more than half a turn;"
        yield found("unreal-motion", (part.name,), f"{text} it does not count turns.", hint, wrong=True, time=when)


LARGE_STRETCH = 0.2  # elongation over length above which there is a remark


@record
class Cable(PointToPoint):
    """Cable, rope or chain without mass between two points or drums: slack it does nothing, taut it pulls.

    A contact whose gap is the slack and whose penetration is the elongation.  A drum winds R theta of the cable up, and
    is pulled at the tangent of the strand, which moves with drum and load; a radius > 0 winds up while the drum turns
    counter-clockwise, < 0 clockwise.  With a free length below the distance of the points it starts under tension.  The
    law of a linear cable is `KelvinVoigt(K, damping)` with K = E A / free_length [N/m].

    Signals: distance of the points (free length between drums) [m], and those of a contact (see `RevoluteClearance`):
    penetration (elongation) [m], normal_force (tension) [N], fx, fy, force (on the second body) [N], mode (0 slack, 1
    jerk, 2 taut); ex, ey from the first point to the second [m].

    Raises
    ------
    InputError : a length that is not > 0, an object that is no normal law, a law whose stiffness depends on the radii
        of a joint.
    ModelError : a cable from a body to itself; drums that overlap.

    Notes
    -----
    Static equilibrium, modes of prestressed structures and runs take the tension of the start into account.  The ledger
    counts energy that a contact holds as dissipated until it is given back, so `energy.dissipated_contact` falls below
    zero where tension of the start is released.  No mass and no bending stiffness: not for sag and not for waves in
    long cables.

    A pulley is a wheel with two cables, one wound on and one off it, so tensions differ by its inertia and friction; it
    may move, and the cable does not slip on it.  The stiffness does not change with the wound length,
    and the strand may turn by less than half a turn from the direction in which it is drawn.
    """

    formerly = (("length", "free_length", "0.3"),)
    _: KW_ONLY
    free_length: float | None = field("length without tension; None: of the points", "m", positive, default=None)
    normal: NormalLaw = field("tension over elongation", rule=Rule(own_stiffness))
    radii: tuple[float, float] = field("radii of both drums, see above; 0: a point", "m", vector, default=(0.0, 0.0))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.free_length is None and planar.distance(self.at, self.to) == 0.0:
            text = f"{self.label}: both points are {self.at}, so the cable needs a length."
            raise InputError(f"{text} Give free_length= in m.")
        refuse_one_body(self, "ties {} to")

    @property
    def slack_length(self) -> float:
        """Length without tension [m]."""
        return self._drawn()[2] if self.free_length is None else self.free_length

    def _drawn(self) -> tuple[float, float, float]:
        """Direction and free length of the strand in the reference configuration."""
        ux, uy, size, _ = strand(sum(self.radii), self.to[0] - self.at[0], self.to[1] - self.at[1])
        return ux, uy, size

    def shapes(self, mechanism: Mechanism) -> Shapes:
        ends = self.ends(mechanism)
        drums = (CircleShape(self.name, e.place, abs(r)) for e, r in zip(ends, self.radii, strict=True) if r)
        return (LineShape(self.name, CABLE, ends[0].place, ends[1].place), *drums)

    def findings_after(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterator[Finding]:
        """Findings on an elongation that no cable bears, and on a strand that goes round."""
        (stretch, when), length = motion.peak(f"{self.name}.penetration"), self.slack_length
        if stretch > LARGE_STRETCH * length:
            text = f"At t = {when:.6g} s {self.label} is stretched by {stretch:.4g} m, its length is {length:.4g} m."
            remedy = "The stiffness of a cable is E A/length, in N/m."
            yield found("unreal-motion", (self.name,), text, remedy, time=when, stretch=stretch, length=length)
        if R := sum(self.radii):
            drawn, hint = np.subtract(self.to, self.at), "Draw it in the middle of its way."
            yield from rounds(self, motion, self.ends(mechanism), R, drawn, hint)

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        ends = self.ends(mechanism)
        coordinates, offsets = ends.coordinates, ends.offsets
        ux, uy, size = self._drawn()
        if any(self.radii) and size == 0.0:
            raise ModelError(f"{self.label}: its drums overlap, so there is no strand between them. Move one of them.")
        turns = [drawn_theta(mechanism, end) for end in ends]
        period = 2.0 * math.pi * abs(sum(self.radii))
        wound = self.radii[0] * turns[0] + self.radii[1] * turns[1]
        p = (NO_CLEARANCE, 1.0, self.slack_length + wound, *offsets, *self.radii, math.atan2(uy, ux))
        laws, least = (self.normal, Frictionless()), abs(sum(self.radii))
        contact = pieces.ContactContribution(self.name, strand_gap_kernel, coordinates, p, *laws, period=period)
        told = self.name, "distance", "m", strand_length, coordinates, (*offsets, least)
        return [contact, pieces.SignalContribution(*told)]
