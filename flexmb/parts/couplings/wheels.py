"""Wheels that turn one another: base of gears and belts, gear pair, rack and pinion.

With the length D and direction phi of the line from the first centre to the second, and R = r1 + r2 (r2 < 0: a ring
with inner teeth, or an open belt):
    g = r1 theta1 + r2 theta2 - R phi - value
The ratio is exact for any D.  The multiplier is the force F at the radii r1 and r2.  Its gradient is the couple r1 F
and r2 F, and F R/D across the line of centres on the first wheel and against it on the second: balanced for any D.
Teeth and strands push or pull along the line as well, by |F| w(D) in either direction of F.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from typing import Any

import numpy as np

from flexmb import checks, planar
from flexmb.errors import InputError, ModelError
from flexmb.fields import between, count, directed, either, field, point, positive, record, two
from flexmb.findings.finding import Finding, found
from flexmb.kernels import Kernel, compiled, constraint_kernel, friction_law, gap_kernel, joint_friction_kernel
from flexmb.model import contributions as pieces
from flexmb.model.law import FrictionLaw, NormalLaw
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Joint, Part, WatchedMotion
from flexmb.model.shape import CircleShape, Shapes
from flexmb.parts.contact.friction import Frictionless
from flexmb.parts.couplings import coupling
from flexmb.parts.joints import contact_point
from flexmb.parts.joints.contact_point import add_curvature, direction, dot, put_column, put_eccentricity, put_point
from flexmb.parts.joints.revolute import drawn_direction, drawn_theta
from flexmb.places import GAP_RATE, LOAD, LOAD_BY_LAM, SLIDING

STEEPEST = 1.0 - 1e-9  # largest cosine of the operating pressure angle: closer axes count as this far apart


@gap_kernel
def tooth_gap_kernel(p, q, v, out):
    """Gap of involute flanks: half the play, opened by the distance of the axes, closed by the relative rotation."""
    # With B = rb1 + rb2 (rb2 < 0: internal), the distance D and direction psi of the axes and cos alpha = |B|/D: gap =
    # half + B (inv alpha - inv alpha_0) -+ [rb1 (theta1 - psi) + rb2 (theta2 - psi) - offset], inv x = tan x - x.
    _, half, rb1, rb2, side, inv_a, offset, pitch = p
    dx, dy = q[3] - q[0], q[4] - q[1]
    D, B = math.sqrt(dx * dx + dy * dy), rb1 + rb2
    sign = 1.0 if B > 0.0 else -1.0
    ex, ey = dx / D, dy / D
    cos_a = min(sign * B / D, STEEPEST)
    sin_a = math.sqrt(1.0 - cos_a * cos_a)
    tan_a, x = sin_a / cos_a, rb1 * q[2] + rb2 * q[5] - B * math.atan2(dy, dx) - offset
    x -= pitch * math.floor(x / pitch + 0.5)  # all teeth are alike
    gap = half + B * (tan_a - math.atan(tan_a) - inv_a) - side * x
    nx, ny = -sign * (sin_a * ex - side * cos_a * ey), -sign * (sin_a * ey + side * cos_a * ex)
    share = rb1 / B
    put_point(out, q, v, gap, nx, ny, q[0] + share * dx, q[1] + share * dy)
    wx, wy = 0.0, 0.0
    for j in range(6):
        gx, gy = (-1.0, 0.0, 0.0, 1.0, 0.0, 0.0)[j], (0.0, -1.0, 0.0, 0.0, 1.0, 0.0)[j]
        turn, bend = (ex * gy - ey * gx) / D, (ex * gx + ey * gy) * cos_a / (D * sin_a)
        along, across = cos_a * bend - side * cos_a * turn, sin_a * turn - side * sin_a * bend
        nqx, nqy = -sign * (along * ex - across * ey), -sign * (along * ey + across * ex)
        Xq, Yq = share * gx + (1.0 if j == 0 else 0.0), share * gy + (1.0 if j == 1 else 0.0)
        put_column(out, j, nqx, nqy, Xq, Yq)
        wx += nqx * v[j]
        wy += nqy * v[j]
    rate = out[GAP_RATE]
    put_eccentricity(out, -gap * nx, -gap * ny, -rate * nx - gap * wx, -rate * ny - gap * wy)


STANDARD_PRESSURE_ANGLE = math.radians(20.0)  # pressure angle of standard gears [rad] (ISO 53)
PRESSURE_ANGLE = between(0.0, 0.25 * math.pi)
ARM = 6  # place of the arm's angle among the coordinates, where it is the last one; it says which turn phi is in


@constraint_kernel
def rolling_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """g = r1 theta1 + r2 theta2 - R phi - value; phi within half a turn of the arm's angle plus `drawn`."""
    # Equations (13.1) and (13.2) of docs/theory/wheels.md.
    r1, r2, s1x, s1y, s2x, s2y, drawn, value = p
    D, ex, ey, along, across = coupling.line_between(s1x, s1y, s2x, s2y, q)
    R, expected = r1 + r2, drawn
    if q.shape[0] > ARM:
        expected += q[ARM]
    beyond = math.atan2(ey, ex) - expected
    phi = expected + beyond - 2.0 * math.pi * math.floor(beyond / (2.0 * math.pi) + 0.5)
    g[0] = r1 * q[2] + r2 * q[5] - R * phi - value
    for i in range(6):
        G[0, i] = -R * across[i] / D
    G[0, 2] += r1
    G[0, 5] += r2
    swing = along[coupling.FIRST_ANGLE] * v[2] * v[2] + along[coupling.SECOND_ANGLE] * v[5] * v[5]
    gamma[0], k = R * (swing - 2.0 * dot(along, v) * dot(across, v) / D) / D, lam[0] * R / D
    for i in range(6):
        for j in range(6):
            H[i, j] = k * (along[i] * across[j] + across[i] * along[j]) / D
    H[2, 2] -= k * along[coupling.FIRST_ANGLE]
    H[5, 5] -= k * along[coupling.SECOND_ANGLE]


@compiled
def put_along(w, slope, D, along, across, out, H):
    """Direction w dD/dq of a force along the line of centres, and its derivatives; slope = dw/dD."""
    # Equation (13.3) of docs/theory/wheels.md.
    for i in range(6):
        out[SLIDING + i] = w * along[i]
        for j in range(6):
            H[i, j] = slope * along[i] * along[j]
    coupling.add_bending(w, D, across, H)


@compiled
def put_size(force, share, least, out):
    """Load: share of |force|, at least `least`."""
    out[LOAD] = max(share * abs(force), least)
    if out[LOAD] > least:
        out[LOAD_BY_LAM] = math.copysign(share, force)


@joint_friction_kernel
def tooth_pressure(p, q, lam, out, H):
    """Teeth part the wheels by |F| w, w = R tan(alpha)/D, cos alpha = base/D; R < 0: a ring draws its wheel inwards."""
    s1x, s1y, s2x, s2y, R, base = p
    D, _, _, along, across = coupling.line_between(s1x, s1y, s2x, s2y, q)
    cos_a = min(base / D, STEEPEST)
    square = 1.0 / (cos_a * cos_a) - 1.0  # of tan alpha
    w = R * math.sqrt(square) / D
    put_size(lam[0], 1.0, 0.0, out)
    put_along(w, w / (D * square) if base < STEEPEST * D else -w / D, D, along, across, out, H)


@joint_friction_kernel
def strand_pull(p, q, lam, out, H):
    """Both strands pull with the mean tension, |F|/2 or the pretension: w = -dL/dD = -2 sqrt(1 - (R/D)^2)."""
    s1x, s1y, s2x, s2y, R, pretension = p
    D, _, _, along, across = coupling.line_between(s1x, s1y, s2x, s2y, q)
    root = math.sqrt(max(1.0 - R * R / (D * D), 0.0))
    put_size(lam[0], 0.5, pretension, out)
    put_along(-2.0 * root, -2.0 * R * R / (D * D * D * root) if root > 0.0 else 0.0, D, along, across, out, H)


@joint_friction_kernel
def rack_pressure(p, q, lam, out, H):
    """Teeth push the pinion off its rack by |F| tan(alpha), along n of the rack."""
    nx, ny, s1x, s1y, s2x, s2y, tan_a = p
    _, J, mx, my, far, near = direction(nx, ny, s1x, s1y, s2x, s2y, q)
    put_size(lam[0], 1.0, 0.0, out)
    for i in range(6):
        out[SLIDING + i] = tan_a * J[i]
    add_curvature(tan_a, mx, my, far, near, H)


@friction_law
def push_kernel(p, h, slip, N, z, z_new):
    """T = N in the given direction, whatever slides."""
    return N, 0.0, 1.0


@dataclass(frozen=True)
class Push(FrictionLaw):
    """Force in the direction of "sliding" as large as the load: a reaction that depends on a multiplier."""

    kernel = push_kernel


Point = tuple[float, float]
FITS = 1e-3  # difference of the distance of the axes from the sum of the pitch radii, relative to it, that still fits
PAIR = two(either(type(None), point), "points", "two points, one of them or None")
COAXIAL = 1e-9  # distance of two centres over their radii, below which they are one: a gearbox with shafts in line


@record
class Wheels(Part):
    """Base of pairs of wheels that turn one another.

    Left out, also one by one, the centres are the pin between wheel and arm, else the centre of mass; of the ground a
    pin of the arm.

    Raises
    ------
    InputError : centres that are no points.
    ModelError : a wheel that turns itself.
    """

    first: Part = field("first wheel")
    second: Part = field("second wheel")
    _: KW_ONLY
    arm: Part = field("body that carries the axes; `GROUND` for fixed axes", default=GROUND)
    centres: Any = field("centres of both wheels in the reference configuration, see `Wheels`", "m", PAIR, default=None)

    def __post_init__(self) -> None:
        super().__post_init__()
        names = (self.first.name, self.second.name)
        if names[0] == names[1] or (self.arm.name != GROUND.name and self.arm.name in names):
            raise ModelError(f"{self.label} couples a body with itself; give different bodies as wheels and arm.")

    def _distances(self, mechanism: Mechanism, motion: WatchedMotion) -> np.ndarray:
        """Distances (n,) of both centres at the poses of a motion [m]."""
        first, second = (motion.point(mount.place) for mount in self._mounts(mechanism))
        return np.asarray(np.hypot(*(second - first).T))

    def _rounds(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterator[Finding]:
        """Finding on a line of centres that goes round without an arm."""
        drawn, hint = np.diff(self._axes(mechanism), axis=0)[0], "Give arm=, the body that carries the axes."
        if self.arm.name == GROUND.name and np.abs(drawn).max() > COAXIAL:
            yield from coupling.rounds(self, motion, self._mounts(mechanism), 0.0, drawn, hint)

    def _axes(self, mechanism: Mechanism) -> list[Point]:
        """Centres of both wheels in the reference configuration [m]."""
        pairs = zip(self.centres or (None, None), (self.first, self.second), strict=True)
        found: list[Any] = [c or (w.name != GROUND.name and self._axis(mechanism, w)) for c, w in pairs]
        other, apart = found[0] or found[1], getattr(self, "distance", None)
        if not all(found):  # the ground, whose centre is a pin of the arm
            pins = sorted(_pins(mechanism, self.arm), key=lambda joint: GROUND.name not in joint.references())
            fits = [p.at for p in pins if apart and abs(planar.distance(p.at, other) - apart) <= FITS * apart]
            found = [point or (fits and fits[0]) for point in found]
        if not all(found):
            text = f"{self.label}: one wheel is the ground, which has no centre."
            raise ModelError(f"{text} Give distance= of the axes and a pin of the arm at its centre, or centres=.")
        return found

    def _axis(self, mechanism: Mechanism, wheel: Part) -> Point:
        """Pin between a wheel and the arm, or one that they share with a third body; else the centre of mass."""
        pins, arm = _pins(mechanism, wheel), [pin.at for pin in _pins(mechanism, self.arm)]
        for pin in sorted(pins, key=lambda joint: self.arm.name not in joint.references()):
            if self.arm.name in pin.references() or pin.at in arm:
                return pin.at
        body = mechanism.body(wheel.name, self.label)
        node = body.node(body.main)
        return node.x, node.y

    def _mounts(self, mechanism: Mechanism) -> pieces.Ends:
        """Centres of both wheels as points of their bodies."""
        wheels = zip((self.first, self.second), self._axes(mechanism), strict=True)
        return pieces.Ends(*(mechanism.body(wheel.name, self.label).attach(self.label, at) for wheel, at in wheels))

    def _circles(self, mechanism: Mechanism, radii: Point) -> Shapes:
        """Pitch circles with the radii [m] about the centres of the wheels that move."""
        mounts = zip(self._mounts(mechanism), radii, strict=True)
        return tuple(CircleShape(self.name, m.place, radius) for m, radius in mounts if m.part != GROUND.name)

    def _rolling(
        self, mechanism: Mechanism, radii: Point, along: tuple[Kernel, tuple[float, ...]] | None
    ) -> pieces.ConstraintContribution:
        """Equation r1 theta1 + r2 theta2 - (r1 + r2) phi = constant, with the direction phi of the line of centres."""
        # radii : of the wheels [m], negative for a wheel that turns with the first one;  along : kernel of the force
        # along the line of centres, and its parameters behind the points
        ends, ((x1, y1), (x2, y2)) = self._mounts(mechanism), self._axes(mechanism)
        if math.hypot(x2 - x1, y2 - y1) <= COAXIAL * (abs(radii[0]) + abs(radii[1])):
            # shafts in line: the angle of the arm for phi, whose casing takes the difference of torques
            factors = list(zip((self.first, self.second, self.arm), (*radii, -sum(radii)), strict=True))
            second = -1 if self.second.name == GROUND.name else int(self.first.name != GROUND.name)
            return coupling.angles_contribution(mechanism, self, factors, _reactions(radii, second))
        coordinates, offsets, phi, drawn = ends.coordinates, ends.offsets, math.atan2(y2 - y1, x2 - x1), 0.0
        if self.arm.name != GROUND.name:
            arm, drawn = coupling.angle_of(mechanism, self.arm.name, self.label)
            coordinates = (*coordinates, arm)
        turns = [drawn_theta(mechanism, end) for end in ends]
        level = radii[0] * turns[0] + radii[1] * turns[1] - sum(radii) * phi
        push = pieces.JointFriction(along[0], (*offsets, *along[1]), Push(), ("", "")) if along else None
        told = _reactions(radii, -1 if ends.second.part == GROUND.name else 5)
        own = self.name, rolling_kernel, coordinates, (*radii, *offsets, phi - drawn, level), 1, ends.second.coordinates
        return pieces.ConstraintContribution(*own, joint_friction=push, reactions=told)


def _reactions(radii: Point, place: int) -> tuple[pieces.Reaction, ...]:
    """Tangential force, torques on both wheels, power of the second wheel, whose angle stands at `place`."""
    torques = zip(("first_torque", "second_torque"), radii, strict=True)
    power = pieces.Reaction("power", "W", 0, radii[1] if place >= 0 else 0.0, place)
    return (pieces.Reaction("force", "N", 0, 1.0), *(pieces.Reaction(name, "N m", 0, r) for name, r in torques), power)


def _pins(mechanism: Mechanism, body: Part) -> list[Joint]:
    """Joints of a body at a point about which it may turn."""
    joints = (part for part in mechanism.parts if isinstance(part, Joint) and part.holds_point)
    return [joint for joint in joints if body.name in joint.references()]


LARGE_PLAY = 0.2  # error of the distance of the axes in a motion, over the module, above which there is a remark
# Names of the contacts of a pair with backlash; 1 where the first wheel pushes while it turns counter-clockwise.
FLANKS = {"forward": 1.0, "backward": -1.0}


@record
class Gear(Wheels):
    """Gear pair of two wheels, ideal or with backlash; the wheels need joints of their own.

    The pitch circles roll on one another: r1 (theta1 - phi) + r2 (theta2 - phi) is constant, with the direction phi of
    the line of centres, and - r2 for an internal pair.

    Signals: force (tangential, at the pitch circles) [N]; first_torque, second_torque (on the wheels) [N m]; power (of
    second_torque) [W].  The tooth force itself loads the bearings of both wheels.  With backlash: of both contacts,
    forward and backward (`mesh.forward.normal_force`, ...), as of `RevoluteClearance`; the forward one carries where
    the first wheel drives counter-clockwise.

    Raises
    ------
    InputError : numbers of teeth that are not whole or not > 0; an internal pair of equal wheels; backlash without a
        normal law, or more than half a tooth.
    ModelError : a wheel that meshes with itself; a distance of the axes that is 0, or does not fit the module; backlash
        of a wheel whose centre of mass is not on its axis.

    Notes
    -----
    The ratio depends on the teeth alone, exactly and for any distance of the axes, which sets the force at the pitch
    point.  An ideal pair carries on either flank: the tangential force F presses the wheels apart with |F| tan(alpha),
    on both directions of F.  While the axes move this force does work, which is booked with friction in joints: real
    teeth open then; give backlash.  Without an arm the line of centres may turn by less than half a turn.  Wheels drawn
    at another distance than that of their pitch circles load their axes by F (r1 + r2)/D, so moments balance; on one
    axis (shafts in line) they load the arm with a torque.

    With backlash the teeth are rigid involutes with an elastic normal law, which stands for the stiffness of the mesh.
    The force has the direction of the line of action.  Play and pressure angle follow the distance of the axes exactly,
    so bearings may have clearance.  At the start the teeth stand in the middle of their play and move as an ideal pair.
    Sliding along the flanks and a varying number of teeth in mesh are left out.
    Source: J. J. Uicker, G. R. Pennock, J. E. Shigley, Theory of Machines and Mechanisms, 4th ed., Oxford 2011, ch. 7.
    """

    _: KW_ONLY
    teeth: tuple[int, int] = field(
        "numbers of teeth of both wheels", rule=two(count(), "whole numbers", "two whole numbers, e.g. (20, 40)")
    )
    internal: bool = field("whether the wheel with more teeth is a ring with inner teeth", default=False)
    distance: float | None = field("of the axes, for the pitch circles; None: as drawn", "m", positive, default=None)
    module: float | None = field("pitch diameter over teeth; None: by the distance", "m", positive, default=None)
    backlash: float | None = field(
        "play of the teeth along the pitch circles", "m", positive, hint="For an ideal pair leave backlash out.",
        default=None,
    )  # fmt: skip
    normal: NormalLaw | None = field("law of the flanks along the line of action, with backlash", default=None)
    pressure_angle: float = field(
        "alpha; 0, of an ideal pair: no radial force", "rad", PRESSURE_ANGLE, default=STANDARD_PRESSURE_ANGLE
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.internal and self.teeth[0] == self.teeth[1]:
            raise InputError(f"{self.label}: both wheels have {self.teeth[0]} teeth; a ring needs more than its wheel.")
        if self.backlash is not None:
            checks.between(self.label, "pressure_angle", self.pressure_angle, 1e-3, 0.25 * math.pi, "rad")
            if not isinstance(self.normal, NormalLaw):
                text = f"{self.label}: normal is {self.normal!r};"
                raise InputError(f"{text} a pair with backlash needs a normal law, e.g. KelvinVoigt.")
        elif self.normal is not None:
            raise InputError(f"{self.label}: normal is given without backlash; give backlash=... in m, or leave it.")

    def radii(self, mechanism: Mechanism) -> tuple[float, float]:
        """Pitch radii of both wheels in a `mechanism` [m].

        Raises
        ------
        ModelError : a distance of the axes that is 0, unknown, or does not fit the module.
        """
        (z1, z2), distance = self.teeth, self.distance or planar.distance(*self._axes(mechanism))
        if distance == 0.0:
            raise ModelError(f"{self.label}: the centres of both wheels coincide. Give distance= of the axes.")
        sum_of_teeth = abs(z2 - z1) if self.internal else z1 + z2
        if self.module is not None and abs(0.5 * self.module * sum_of_teeth - distance) > FITS * distance:
            text = f"{self.label}: the axes are {distance:g} m apart, but wheels of {z1} and {z2}"
            text += f" teeth with module {self.module:g} m need {0.5 * self.module * sum_of_teeth:g} m."
            raise ModelError(f"{text} Move an axis, or change the wheels.")
        return distance * z1 / sum_of_teeth, distance * z2 / sum_of_teeth

    def module_of(self, mechanism: Mechanism) -> float:
        """Module of the teeth in a `mechanism` [m]."""
        return 2.0 * self.radii(mechanism)[0] / self.teeth[0]

    def signed_radii(self, mechanism: Mechanism) -> tuple[float, float]:
        """Pitch radii of both wheels in a `mechanism` [m], that of a ring below 0."""
        r1, r2 = self.radii(mechanism)
        return r1, -r2 if self.internal else r2

    def contact_size(self, mechanism: Mechanism) -> float | None:
        """Module of teeth with backlash in `mechanism` [m]."""
        return None if self.backlash is None else self.module_of(mechanism)

    def findings_after(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterator[Finding]:
        """Findings on an ideal pair whose axes go round, or leave the distance that its wheels are made for."""
        yield from self._rounds(mechanism, motion) if self.backlash is None else ()
        if self.backlash is not None or self.distance is not None:
            return
        apart, drawn = self._distances(mechanism, motion), abs(sum(self.signed_radii(mechanism)))
        off = np.abs(apart - drawn)
        k = int(np.argmax(off))
        if off[k] > LARGE_PLAY * self.module_of(mechanism):
            text = f"At t = {motion.times[k]:.6g} s the centres of the wheels of {self.label}"
            text += f" are {apart[k]:.4g} m apart; its teeth mesh at {drawn:.4g} m."
            remedy = "An ideal pair holds its ratio at any distance: hold the axes, or give backlash= and normal=."
            yield found("unreal-motion", (self.name,), text, remedy, time=motion.times[k], distance=apart[k])

    def shapes(self, mechanism: Mechanism) -> Shapes:
        return self._circles(mechanism, self.radii(mechanism))

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        r1, r2 = self.signed_radii(mechanism)
        R = math.copysign(r1 + r2, r2) if self.internal else r1 + r2
        base = planar.distance(*self._axes(mechanism)) * math.cos(self.pressure_angle)
        ideal = self._rolling(mechanism, (r1, r2), (tooth_pressure, (R, base)) if self.pressure_angle > 0.0 else None)
        if self.backlash is None or self.normal is None:
            return [ideal]
        one, two = (mechanism.body(part.name, self.label) for part in (self.first, self.second))
        first, second = one.node(one.main), two.node(two.main)
        apart, wanted = planar.distance((first.x, first.y), (second.x, second.y)), abs(r1 + r2)
        if GROUND.name in (self.first.name, self.second.name) or abs(apart - wanted) > FITS * wanted:
            text = f"{self.label}: with backlash both wheels must be bodies whose centres of mass lie on their axes,"
            text += f" {wanted:g} m apart; they are {apart:g} m apart."
            raise ModelError(f"{text} Use a heavy body on a Fixed joint for a ring at rest.")
        pitch = 2.0 * math.pi * abs(r1) / self.teeth[0]
        if self.backlash >= 0.5 * pitch:
            text = f"{self.label}: backlash is {self.backlash:g} m, but a tooth and its gap are {pitch:.4g} m long"
            raise InputError(f"{text} together; it must be less than half of that.")
        c = math.cos(self.pressure_angle)
        direction = math.atan2(second.y - first.y, second.x - first.x)
        offset = c * (r1 * (first.theta - direction) + r2 * (second.theta - direction))
        coordinates = (*pieces.node_coordinates(one.name, first.name), *pieces.node_coordinates(two.name, second.name))
        play = self.backlash, 0.5 * self.backlash * c, r1 * c, r2 * c
        rest = math.tan(self.pressure_angle) - self.pressure_angle, offset, pitch * c
        flanks = ((name, (*play, side, *rest)) for name, side in FLANKS.items())
        own, laws = (self.name, tooth_gap_kernel, coordinates), (self.normal, Frictionless())
        contacts = (pieces.ContactContribution(*own, p, *laws, name) for name, p in flanks)
        return [*contacts, replace(ideal, holds="closed")]


PARTED = 0.05  # error of the distance of the pinion from the pitch line over its radius, above which there is a remark


@constraint_kernel
def rack_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Travel of the pinion's centre along the rack, plus signed radius times relative angle, is constant."""
    ux, uy, s1x, s1y, s2x, s2y, radius, value = p
    contact_point.direction_row(ux, uy, s1x, s1y, s2x, s2y, q, v, lam, 0, g, G, gamma, H)
    g[0] += radius * (q[5] - q[2]) - value
    G[0, 2] -= radius
    G[0, 5] += radius


@record
class Rack(Part):
    """Ideal rack and pinion, or a wheel that rolls on a straight track without slipping; both may move.

    Signals: force (on the pinion, along the rack) [N], torque (on the pinion, about its centre, against that of the
    force) [N m]; power (of both, given to the pinion) [W].

    Raises
    ------
    InputError : a pressure angle out of range.
    ModelError : a pitch line through the centre of the pinion, or a pinion that is its own rack.

    Notes
    -----
    The radius is the distance of the centre from the pitch line in the reference configuration.  A joint or guide must
    keep that distance: the part only couples rotation and travel.  The force F along the rack acts at the pitch point
    and presses the pinion off the rack with |F| tan(alpha), in either direction of F.
    """

    pinion: Part = field("the wheel; its centre of mass is the centre of its pitch circle")
    rack: Part = field("the rack or track; `GROUND` for a fixed one")
    at: tuple[float, float] = field("a point of the pitch line of the rack", "m", point)
    along: tuple[float, float] = field("direction of the pitch line", rule=directed, default=(1.0, 0.0))
    pressure_angle: float = field(
        "alpha of the teeth; 0: it rolls", "rad", PRESSURE_ANGLE, default=STANDARD_PRESSURE_ANGLE
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.pinion.name in (self.rack.name, GROUND.name):
            text = f"{self.label}: the pinion is {self.pinion.name!r};"
            raise ModelError(f"{text} give a moving body other than the rack.")

    def radius(self, mechanism: Mechanism) -> float:
        """Radius of the pitch circle in a `mechanism` [m]; < 0 for a pinion to the right of the direction of its rack.

        Raises
        ------
        ModelError : a pitch line through the centre of the pinion.
        """
        body = mechanism.body(self.pinion.name, self.label)
        node = body.node(body.main)
        ux, uy = self.along
        across = (ux * (node.y - self.at[1]) - uy * (node.x - self.at[0])) / math.hypot(ux, uy)
        if across == 0.0:
            text = f"{self.label}: the pitch line through {self.at} passes the centre of {self.pinion.name!r}"
            raise ModelError(f"{text}, so the pinion has no radius. Move the line to the pitch point.")
        return across

    def findings_after(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterator[Finding]:
        """Finding on a pinion that leaves the pitch line."""
        pinion, rack = (mechanism.body(part.name, self.label) for part in (self.pinion, self.rack))
        end, node = rack.attach(self.label, self.at), pinion.node(pinion.main)
        radius, turned = self.radius(mechanism), rack.node(end.node).theta
        theta = motion.pose(rack.name, end.node)[:, 2]
        dx, dy = (motion.point((pinion.name, node.name, (0.0, 0.0))) - motion.point(end.place)).T
        angle = math.atan2(self.along[1], self.along[0]) - turned + theta
        across = np.cos(angle) * dy - np.sin(angle) * dx
        k = int(np.argmax(np.abs(across - radius)))
        if abs(across[k] - radius) > PARTED * abs(radius):
            text = f"At t = {motion.times[k]:.6g} s the centre of {self.pinion.name!r} is {abs(across[k]):.4g}"
            text += f" m from the pitch line of {self.label}, whose radius is {abs(radius):.4g} m."
            remedy, numbers = "Hold the distance by a joint or guide.", {"distance": across[k], "radius": radius}
            yield found("unreal-motion", (self.name,), text, remedy, time=motion.times[k], **numbers)

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        pinion, rack = (mechanism.body(part.name, self.label) for part in (self.pinion, self.rack))
        end, node = rack.attach(self.label, self.at), pinion.node(pinion.main)
        angle, radius = math.atan2(self.along[1], self.along[0]), self.radius(mechanism)
        travel = math.cos(angle) * (node.x - self.at[0]) + math.sin(angle) * (node.y - self.at[1])
        value = travel + radius * (node.theta - rack.node(end.node).theta)
        u = drawn_direction(mechanism, end, self.along)
        coordinates = (*end.coordinates, *((pinion.name, pinion.main, axis) for axis in (0, 1, 2)))
        power = pieces.Reaction("power", "W", on=(3, 4, 5), power=True)
        reactions = (pieces.Reaction("force", "N", 0, 1.0), pieces.Reaction("torque", "N m", 0, radius), power)
        p = (*u, *end.offset, 0.0, 0.0, radius, value)
        off = math.copysign(math.tan(self.pressure_angle), radius)
        push = pieces.JointFriction(rack_pressure, (-u[1], u[0], *p[2:6], off), Push(), ("", ""))
        own = self.name, rack_kernel, coordinates, p, 1, end.coordinates
        piece = pieces.ConstraintContribution(*own, reactions=reactions)
        return [replace(piece, joint_friction=push) if off else piece]
