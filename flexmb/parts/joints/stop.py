"""Stops: limits of the angle of a joint, of its travel, or of the way between two points.

With the line from the first centre to the second, d = D (cos phi, sin phi), and R = R1 + R2 the strand is a tangent of
both drums, u = (cos psi, sin psi) with psi = phi - asin(R/D), free for l = sqrt(D^2 - R^2).  A drum with R > 0 winds up
while it turns counter-clockwise, with R < 0 while it turns clockwise; R = 0 is a point.  The strand is drawn out by
    E = l + R1 (theta1 - psi) + R2 (theta2 - psi),   dE = u . dd + R1 dtheta1 + R2 dtheta2
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY
from typing import Any, ClassVar

import numpy as np

from flexmb import planar
from flexmb.errors import InputError, ModelError
from flexmb.fields import Rule, directed, field, point, positive, record
from flexmb.kernels import Kernel, compiled, gap_kernel, signal_kernel
from flexmb.model.contributions import ContactContribution, Contribution, Ends
from flexmb.model.law import Motion, NormalLaw
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Part, refuse_one_body
from flexmb.parts.contact.friction import Frictionless
from flexmb.parts.joints import contact_point as touch
from flexmb.parts.joints.prismatic import Prismatic, joint_with_coordinate
from flexmb.parts.joints.revolute import Revolute, drawn_angle, drawn_direction
from flexmb.places import GAP, GAP_RATE


# Straight strand between two points or drums: gap kernel of cables and of stops along a distance
@compiled
def strand(R, dx, dy):
    """Direction u and free length of a strand, and inverse of the length; 0 for points that coincide."""
    square = dx * dx + dy * dy
    size = math.sqrt(max(square - R * R, 0.0))
    if size == 0.0:
        return 1.0, 0.0, 0.0, 0.0
    return (size * dx + R * dy) / square, (size * dy - R * dx) / square, size, 1.0 / size


@gap_kernel
def strand_gap_kernel(p, q, v, out):
    """gap = side (value - E), n = side u: side 1 pulls where the strand is drawn out, -1 pushes where it is short."""
    # The angle psi counts from `drawn`, within half a turn. Both forces act at the point where the first drum is left.
    # Equation (13.4) of docs/theory/wheels.md.
    _, side, value, s1x, s1y, s2x, s2y, R1, R2, drawn = p
    ax, ay, bx, by, dx, dy = touch.arms_of(s1x, s1y, s2x, s2y, q)
    R = R1 + R2
    ux, uy, size, inverse = strand(R, dx, dy)
    drawn_out = size
    if R1 != 0.0 or R2 != 0.0:
        turn = math.atan2(uy, ux) - drawn
        turn -= 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)
        drawn_out += R1 * (q[2] - turn) + R2 * (q[5] - turn)
    nx, ny = side * ux, side * uy
    touch.put_point(out, q, v, side * (value - drawn_out), nx, ny, q[0] + ax - R1 * uy, q[1] + ay + R1 * ux)
    vx, vy = v[3] - v[5] * by - v[0] + v[2] * ay, v[4] + v[5] * bx - v[1] - v[2] * ax
    swing = (ux * vy - uy * vx) * inverse
    longer = ux * vx + uy * vy + R * swing
    touch.put_eccentricity(out, size * ux, size * uy, longer * ux - size * swing * uy, longer * uy + size * swing * ux)
    for j in range(6):
        gx, gy, Xq, Yq = touch.difference_column(j, ax, ay, bx, by)  # of d and of the first centre
        turn = (ux * gy - uy * gx) * inverse
        touch.put_column(out, j, -ny * turn, nx * turn, Xq - R1 * turn * ux, Yq - R1 * turn * uy)


@signal_kernel
def strand_length(p, t, q, v, a):
    """Free length of a strand: the distance of its points."""
    s1x, s1y, s2x, s2y, R = p
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    dx = q[3] + c2 * s2x - d2 * s2y - q[0] - c1 * s1x + d1 * s1y
    dy = q[4] + d2 * s2x + c2 * s2y - q[1] - d1 * s1x - c1 * s1y
    return math.sqrt(max(dx * dx + dy * dy - R * R, 0.0))


ABOVE, BELOW = "above", "below"
Pieces = list[tuple[str, Kernel, tuple[float, ...]]]  # per limit: name, gap kernel, its parameters behind the clearance
NO_CLEARANCE = 0.0  # first parameter p of a contact without a clearance [m]


@compiled
def put_gap_vector(out, nx, ny, turn):
    """Vector from the face of the first body to that of the second, -gap n, and its rate; n turns with speed `turn`."""
    gap, rate = out[GAP], out[GAP_RATE]
    touch.put_eccentricity(out, -gap * nx, -gap * ny, -rate * nx + gap * turn * ny, -rate * ny - gap * turn * nx)


@gap_kernel
def turn_gap_kernel(p, q, v, out):
    """Face of the second body against one of the first, at a radius from the pin: gap = side radius (limit - angle)."""
    # n is fixed to the first body, across the direction from the pin to its face. The play of the pin along n counts,
    # so the gradient of the gap belongs to one contact point for any positions.
    _, side, limit, radius, dx, dy, s1x, s1y, s2x, s2y = p
    ax, ay, bx, by, wx, wy = touch.arms_of(s1x, s1y, s2x, s2y, q)  # (wx, wy): play of the pin
    c1, d1 = math.cos(q[2]), math.sin(q[2])
    ex, ey = c1 * dx - d1 * dy, d1 * dx + c1 * dy
    nx, ny = -side * ey, side * ex
    reach = radius + ex * wx + ey * wy
    X, Y = q[0] + ax + reach * ex, q[1] + ay + reach * ey
    touch.put_point(out, q, v, side * radius * (limit - q[5] + q[2]) - nx * wx - ny * wy, nx, ny, X, Y)
    put_gap_vector(out, nx, ny, v[2])
    for j in range(6):
        gx, gy, Xq, Yq = touch.difference_column(j, ax, ay, bx, by)  # of the play, and of the pin on the first body
        longer = ex * gx + ey * gy
        if j == 2:
            longer += ex * wy - ey * wx
            touch.put_column(out, j, -ny, nx, Xq + longer * ex - reach * ey, Yq + longer * ey + reach * ex)
        else:
            touch.put_column(out, j, 0.0, 0.0, Xq + longer * ex, Yq + longer * ey)


@gap_kernel
def travel_gap_kernel(p, q, v, out):
    """Slider against an end of its guide: gap = side (limit - travel); the contact point is the slider's."""
    _, side, limit, mx, my, s1x, s1y, s2x, s2y = p
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    nx, ny = side * (c1 * mx - d1 * my), side * (d1 * mx + c1 * my)
    bx, by = c2 * s2x - d2 * s2y, d2 * s2x + c2 * s2y
    X, Y = q[3] + bx, q[4] + by
    wx, wy = X - q[0] - c1 * s1x + d1 * s1y, Y - q[1] - d1 * s1x - c1 * s1y
    touch.put_point(out, q, v, side * limit - nx * wx - ny * wy, nx, ny, X, Y)
    put_gap_vector(out, nx, ny, v[2])
    touch.put_side_columns(out, nx, ny, bx, by)


def own_stiffness(label: str, name: str, law: Any, *_: str) -> NormalLaw:
    """A normal law whose stiffness does not follow from the radii of a joint, or `InputError`."""
    if not isinstance(law, NormalLaw):
        text = "it must be a normal law, e.g. KelvinVoigt(stiffness=1e5, damping=50.0, ramp=1e-4)"
        raise InputError(f"{label}: {name} is {law!r}; {text}.")
    try:
        law.parameters()
    except InputError as error:
        text = f"{label}: the stiffness of {type(law).__name__} depends on the radii of a journal and its bearing,"
        text += " which this part has not."
        raise InputError(f"{text} Give a law with a stiffness of its own, e.g. HuntCrossley or KelvinVoigt.") from error
    return law


@record
class Stop(Part):
    """Limits of a joint, or of the way between two bodies: a contact that closes at a limit, and opens again.

    Of a revolute joint two faces touch at `radius` from the pin, gap = radius (above - angle) or radius (angle -
    below); their force is tangential there and acts on both bodies, so the stop loads the pin as well.  Of a prismatic
    joint the force acts along the guide.  Without a joint (a bump stop beside a bushing or spring) `first` and `second`
    are given: the way of the point `to` of the second body from the point `at` of the first is limited, along a
    direction of the first body or, without `along`, as the distance of the points, along which the force acts.

    Of a joint, `along` points from the pin to the face of the second body; left out, to the centre of the second body,
    of the first where the second one is the ground or centred at the pin.

    Signals: those of a contact (see `RevoluteClearance`): penetration [m],
    penetration_rate [m/s], normal_force, fx, fy, force (on the second body) [N], mode (0 open, 1 impact, 2 lasting
    contact); ex, ey: from the face of the first body to that of the second [m].  With both limits they stand under
    "name.above" and "name.below".  The torque of a stop is radius times normal_force.

    Raises
    ------
    InputError : neither a joint nor two bodies and a point, or both; no limit, limits that leave no way between them or
        that the reference configuration violates, an object that is no normal law, a law whose stiffness depends on the
        radii of a joint.
    ModelError : no such joint, a joint without angle or travel, a drive that begins beyond a limit; a stop from a body
        to itself.

    Notes
    -----
    Faces do not rub.  Angles count on over whole turns, so a limit may be larger than one turn.  A stiff law and a
    radius say how the stop yields, N = k radius (angle - above) for a linear law: not for bodies that bend beside it.
    """

    by_name = ("joint",)
    deep_from: ClassVar[float] = 1.0  # buffers may yield
    joint: Any = field("a `Revolute` or `Prismatic` joint, or its name; None: two bodies", default=None)
    _: KW_ONLY
    first: Any = field("without a joint: first body, or `GROUND`", default=None)
    second: Any = field("without a joint: second body, or `GROUND`", default=None)
    at: Any = field("point of the first body", "m", point, default=None)
    to: Any = field("point of the second body; None: the same point", "m", point, default=None)
    above: float | None = field("largest angle or travel, >= 0; None: no limit", "rad or m", default=None)
    below: float | None = field("smallest angle or travel, <= 0; None: no limit", "rad or m", default=None)
    normal: NormalLaw = field("law of the normal force", rule=Rule(own_stiffness))
    radius: float = field("distance of the faces from the pin; with 1 m, N/m are N m/rad", "m", positive, default=1.0)
    along: Any = field("direction from the pin to the face, or of the way, see above", rule=directed, default=None)

    def __post_init__(self) -> None:
        super().__post_init__()
        ends = self.first, self.second, self.at
        if not isinstance(self.joint, str) or ends != (None, None, None) or self.to is not None:
            if self.joint is not None or not all(isinstance(body, Part) for body in ends[:2]) or self.at is None:
                text = f"{self.label}: joint is {self.joint!r}; it must be a joint or its name. For bodies without a"
                raise InputError(f"{text} common joint leave it out and give first=, second= and at=.")
            refuse_one_body(self, "stops {} against")
            if self.to is None:
                object.__setattr__(self, "to", self.at)
            if self.along is None and self.at == self.to:
                raise InputError(f"{self.label}: both points are {self.at}; give along=, or another point to=.")
        if self.above is None and self.below is None:
            raise InputError(f"{self.label}: above and below are None; give one of them, in rad or m.")
        for name, sign, limit in self._limits():
            if sign * limit < 0.0:
                text = f"{self.label}: {name} is {limit:g}, but the joint starts at 0, its reference configuration."
                side = ">=" if sign > 0.0 else "<="
                raise InputError(f"{text} Give {name} {side} 0, or draw the mechanism within its limits.")
        if self.above is not None and self.below is not None and self.above <= self.below:
            raise InputError(f"{self.label}: above is {self.above:g}, below {self.below:g}; above must be larger.")

    def validate(self, mechanism: Mechanism) -> None:
        """Check that the joint has an angle or a travel, and that no drive begins beyond a limit."""
        if self.joint is None:
            return
        joint_with_coordinate(mechanism, self.label, self.joint)
        for part in mechanism.parts:
            motion = getattr(part, "motion", None)
            if getattr(part, "joint", None) != self.joint or not isinstance(motion, Motion):
                continue
            start = float(motion.kernel(np.array(motion.parameters(), dtype=float), 0.0)[0])
            low, high = -math.inf if self.below is None else self.below, math.inf if self.above is None else self.above
            if not low <= start <= high:
                text = f"{self.label}: {part.label} begins at {start:g}, beyond the limits {low:g}"
                raise ModelError(f"{text} and {high:g} of joint {self.joint!r}. Begin between them, or move the stop.")

    def contact_size(self, mechanism: Mechanism) -> float | None:
        """Radius of the faces of a revolute joint, so that the angle beyond the limit is judged."""
        return self.radius if self.joint and isinstance(mechanism.find(self.joint), Revolute) else None

    def contributions(self, mechanism: Mechanism) -> Sequence[Contribution]:
        found: Pieces = []  # name, kernel and parameters of each limit
        if self.joint is not None:
            joint = joint_with_coordinate(mechanism, self.label, self.joint)
            ends = joint.ends(mechanism)
            if isinstance(joint, Prismatic):
                p = joint.line(mechanism)
                found = [(name, travel_gap_kernel, (side, x, *p)) for name, side, x in self._limits()]
            else:
                along = self.along if self.along is not None else self._towards_a_centre(mechanism, joint)
                drawn = drawn_angle(mechanism, ends)
                for name, side, limit in self._limits():
                    faces = drawn_direction(mechanism, ends.first, along, limit)
                    found.append((name, turn_gap_kernel, (side, limit + drawn, self.radius, *faces, *ends.offsets)))
        else:  # of the way between two points
            bodies = (mechanism.body(part.name, self.label) for part in (self.first, self.second))
            ends = Ends(*(body.attach(self.label, at) for body, at in zip(bodies, (self.at, self.to), strict=True)))
            dx, dy = self.to[0] - self.at[0], self.to[1] - self.at[1]
            if self.along is None:
                size, rest = math.hypot(dx, dy), (*ends.offsets, 0.0, 0.0, 0.0)
                found = [(name, strand_gap_kernel, (s, size + x, *rest)) for name, s, x in self._limits()]
            else:
                angle = math.atan2(self.along[1], self.along[0])
                m = drawn_direction(mechanism, ends.first, self.along)
                drawn, line = dx * math.cos(angle) + dy * math.sin(angle), (*m, *ends.offsets)
                found = [(name, travel_gap_kernel, (s, x + drawn, *line)) for name, s, x in self._limits()]
        place, laws, several = ends.coordinates, (self.normal, Frictionless()), len(found) > 1
        return [ContactContribution(self.name, kernel, place, (NO_CLEARANCE, *p), *laws, name if several else "")
                for name, kernel, p in found]  # fmt: skip

    def _limits(self) -> list[tuple[str, float, float]]:
        """Name, side and value of each limit."""
        both = (ABOVE, 1.0, self.above), (BELOW, -1.0, self.below)
        return [(name, side, limit) for name, side, limit in both if limit is not None]

    def _towards_a_centre(self, mechanism: Mechanism, joint: Revolute) -> tuple[float, float]:
        """Direction from the pin to the centre of the second body, or of the first; X where both lie at the pin."""
        for part in (joint.second, joint.first):
            body = mechanism.body(part.name, self.label)
            node = body.node(body.main)
            if body.name != GROUND.name and planar.distance(joint.at, (node.x, node.y)) > 0.0:
                return node.x - joint.at[0], node.y - joint.at[1]
        return 1.0, 0.0
