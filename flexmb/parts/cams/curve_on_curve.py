"""Bodies that touch along curves: cam and follower, knife edge and groove, ideal or as a contact that can open.

c1 and c2 = c1 + distance n are the points of both curves on their common normal, n the outward normal of the first one,
t = k x n.  A curve has the curvature b/a there (1/0: a point, 0/1: a line).  With tau = t . (u2 - u1) of the velocities
u of the material points, the normal turns by dphi and the points travel by ds1, ds2 along their curves, each
counter-clockwise:
    dphi (a1 b2 + a2 b1 + b1 b2 distance) = b1 b2 tau + a1 b2 dtheta1 + a2 b1 dtheta2
    ds1  (...) = a1 (b2 tau + a2 (dtheta2 - dtheta1) - b2 distance dtheta1),   ds2 = tau - ds1 - distance dphi
Source: to second order a curve is its circle of curvature; the equations are those of its rolling and sliding (J. J.
Uicker, G. R. Pennock, J. E. Shigley, Theory of Machines and Mechanisms, 4th ed., 2011, on Euler-Savary and cams).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import KW_ONLY, dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import kernels, planar
from flexmb.errors import InputError, ModelError
from flexmb.fields import field, instance, one_of, point, record
from flexmb.findings.finding import Finding, found
from flexmb.model import contributions as pieces
from flexmb.model.law import FrictionLaw, NormalLaw
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Part, WatchedMotion, refuse_one_body
from flexmb.model.shape import RigidShape, Shapes
from flexmb.parts.cams.curves import SAMPLES, CircularCurve, ClosedCurve, Line, common_normal, extreme, sampled
from flexmb.parts.contact.friction import Frictionless
from flexmb.parts.joints.contact_point import put_column, put_eccentricity, put_point
from flexmb.places import LOAD, LOAD_BY_LAM, SLIDING


@kernels.compiled
def unit_motion(j, r1x, r1y, r2x, r2y):
    """Velocities u1, u2 of the material points at c1, c2 and of both angles, for a unit velocity of coordinate j."""
    first = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0, 0.0, 0.0), (-r1y, r1x, 0.0, 0.0, 1.0, 0.0)
    second = (0.0, 0.0, 1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0, 0.0, 0.0), (0.0, 0.0, -r2y, r2x, 0.0, 1.0)
    return (first + second)[j]


@kernels.compiled
def travel(tau, w1, w2, distance, a1, b1, a2, b2):
    """Turn of the normal, and travel of both points along their curves; no turn where any normal would do."""
    scale = a1 * b2 + a2 * b1 + b1 * b2 * distance
    over = 1.0 / scale if scale != 0.0 else 0.0
    turn = over * (b1 * b2 * tau + a1 * b2 * w1 + a2 * b1 * w2)
    first = over * a1 * (b2 * tau + a2 * (w2 - w1) - b2 * distance * w1)
    return turn, first, tau - first - distance * turn


@kernels.compiled
def row(x, y, r1x, r1y, r2x, r2y):
    """Velocity of c2 less that of c1 along (x, y), by the six coordinates."""
    return -x, -y, x * r1y - y * r1x, x, y, y * r2x - x * r2y


@kernels.compiled
def row_change(x, y, px, py, r1x, r1y, r2x, r2y, x1, y1, x2, y2):
    """Derivative of `row`, for derivatives (px, py) of the direction, (x1, y1) and (x2, y2) of the arms."""
    return (-px, -py, px * r1y - py * r1x + x * y1 - y * x1, px, py, py * r2x - px * r2y + y * x2 - x * y2)


@kernels.compiled
def with_arms(q, X, Y, nx, ny, distance, a1, b1, a2, b2):
    """All numbers of a pair: c1, normal, distance, curvatures, arms from both nodes to c1 and c2."""
    r2x, r2y = X + distance * nx - q[3], Y + distance * ny - q[4]
    return X, Y, nx, ny, distance, a1, b1, a2, b2, X - q[0], Y - q[1], r2x, r2y


@kernels.compiled
def middle_change(j, pair):
    """Derivatives of the middle between c1 and c2 by coordinate j, and turn of the normal."""
    _, _, nx, ny, distance, a1, b1, a2, b2, r1x, r1y, r2x, r2y = pair
    u1x, u1y, u2x, u2y, w1, w2 = unit_motion(j, r1x, r1y, r2x, r2y)
    tau = -ny * (u2x - u1x) + nx * (u2y - u1y)
    turn, first, _ = travel(tau, w1, w2, distance, a1, b1, a2, b2)
    along, across = 0.5 * (nx * (u2x - u1x) + ny * (u2y - u1y)), first + 0.5 * distance * turn
    return u1x + along * nx - across * ny, u1y + along * ny + across * nx, turn


@kernels.compiled
def put_gap(pair, q, v, out):
    """Output of a gap kernel; the contact point lies in the middle between c1 and c2."""
    X, Y, nx, ny, distance, _, _, _, _, r1x, r1y, r2x, r2y = pair
    half = 0.5 * distance
    put_point(out, q, v, distance, -nx, -ny, X + half * nx, Y + half * ny)
    J = row(nx, ny, r1x, r1y, r2x, r2y)
    rate, spin = 0.0, 0.0
    for j in range(6):
        Xq, Yq, turn = middle_change(j, pair)
        put_column(out, j, turn * ny, -turn * nx, Xq, Yq)
        rate += J[j] * v[j]
        spin += turn * v[j]
    vx, vy = rate * nx - distance * spin * ny, rate * ny + distance * spin * nx
    put_eccentricity(out, distance * nx, distance * ny, vx, vy)


CURVE_SCALE, SECOND, CURVE_UNDER_CURVE = range(3)  # places in p: length for tolerances [m], second curve, first curve


@kernels.compiled
def curves_pair(p, q):
    """The pair of both curves at the coordinates q."""
    c, s = math.cos(q[2]), math.sin(q[2])
    ex, ey, turn = q[3] - q[0], q[4] - q[1], q[5] - q[2]
    pose = math.cos(turn), math.sin(turn), c * ex + s * ey, -s * ex + c * ey  # of the second curve
    x, y, X, Y, tx, ty, bend, other_bend = common_normal(p, CURVE_UNDER_CURVE, int(p[SECOND]), *pose)
    distance = (X - x) * ty - (Y - y) * tx
    fx, fy, ux, uy = q[0] + c * x - s * y, q[1] + s * x + c * y, c * ty + s * tx, s * ty - c * tx
    return with_arms(q, fx, fy, ux, uy, distance, 1.0, bend, 1.0, other_bend)


# Places in p: length for tolerances [m], centre in the frame of the second node [m], radius [m], the curve.
POINT_SCALE, CENTRE_X, CENTRE_Y, RADIUS, CURVE_UNDER_POINT = range(5)


@kernels.compiled
def point_pair(p, base, q, X, Y, radius):
    """The pair of the curve at `base` and a circle around (X, Y), a point for the radius 0."""
    c, s = math.cos(q[2]), math.sin(q[2])
    ex, ey = X - q[0], Y - q[1]
    Z, W = c * ex + s * ey, -s * ex + c * ey
    x, y, tx, ty, bend = extreme(p, base, Z, W, True)
    away = (Z - x) * ty - (W - y) * tx
    nx, ny = c * ty + s * tx, s * ty - c * tx
    X, Y = q[0] + c * x - s * y, q[1] + s * x + c * y
    return with_arms(q, X, Y, nx, ny, away - radius, 1.0, bend, radius, 1.0)


@kernels.compiled
def roller_pair(p, q):
    """The pair of the curve and the roller at the coordinates q."""
    c, s = math.cos(q[5]), math.sin(q[5])
    X, Y = q[3] + c * p[CENTRE_X] - s * p[CENTRE_Y], q[4] + s * p[CENTRE_X] + c * p[CENTRE_Y]
    return point_pair(p, CURVE_UNDER_POINT, q, X, Y, p[RADIUS])


# Places in p: length for tolerances [m], first end of the line [m] and its direction in the frame of the second node,
# +1 for a curve on the left of the line and -1 on the right, length of the line [m], the curve.
LINE_SCALE, START_X, START_Y, ALONG_X, ALONG_Y, SIDE, LENGTH, CURVE_UNDER_LINE = range(8)


@kernels.compiled
def face_pair(p, q):
    """The pair of the curve and the whole line; place of the contact along the line from its first end; that end."""
    c1, s1, c2, s2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    ux, uy = c2 * p[ALONG_X] - s2 * p[ALONG_Y], s2 * p[ALONG_X] + c2 * p[ALONG_Y]
    X, Y = q[3] + c2 * p[START_X] - s2 * p[START_Y], q[4] + s2 * p[START_X] + c2 * p[START_Y]
    nx, ny = p[SIDE] * uy, -p[SIDE] * ux  # from the curve to the line
    x, y, _, _, bend = extreme(p, CURVE_UNDER_LINE, c1 * nx + s1 * ny, -s1 * nx + c1 * ny, False)
    x, y = q[0] + c1 * x - s1 * y, q[1] + s1 * x + c1 * y
    distance = (X - x) * nx + (Y - y) * ny
    return with_arms(q, x, y, nx, ny, distance, 1.0, bend, 1.0, 0.0), (x - X) * ux + (y - Y) * uy, X, Y


@kernels.compiled
def face_alone(p, q):
    """The pair of the curve and the whole line."""
    pair, _, _, _ = face_pair(p, q)
    return pair


@kernels.gap_kernel
def face_gap_kernel(p, q, v, out):
    """Distance of a segment from a convex closed curve; beyond its ends that of the end."""
    pair, place, X, Y = face_pair(p, q)
    if 0.0 <= place <= p[LENGTH]:
        put_gap(pair, q, v, out)
        return
    if place > 0.0:
        c, s = math.cos(q[5]), math.sin(q[5])
        X += p[LENGTH] * (c * p[ALONG_X] - s * p[ALONG_Y])
        Y += p[LENGTH] * (s * p[ALONG_X] + c * p[ALONG_Y])
    put_gap(point_pair(p, CURVE_UNDER_LINE, q, X, Y, 0.0), q, v, out)


@kernels.signal_kernel
def face_place(p, t, q, v, a):
    """Place of the contact along the line from its first end."""
    _, place, _, _ = face_pair(p, q)
    return place


# Kernels of pairs of curves, by kind of the second curve, and contributions made of them

TOUCHING, OPEN = "touching", "open"  # starts of a contact: second body put onto the curve, or where it is drawn


@dataclass(frozen=True)
class PairKernels:
    """Kernels of one kind of pair."""

    equation: kernels.Kernel  # constraint kernel of the distance
    gap: kernels.Kernel  # gap kernel
    sliding: kernels.Kernel  # joint-friction kernel
    speed: kernels.Kernel  # signal kernel of the normal speed of the second body

    def contributions(
        self, part: Any, coordinates: tuple[pieces.Coordinate, ...], p: tuple[float, ...]
    ) -> list[pieces.Contribution]:
        """Constraint equation of an ideal pair; contact and its ideal form at the start."""
        rubbing = None if part.friction is None else pieces.JointFriction(self.sliding, p, part.friction)
        first, second = (part.name, self.equation, coordinates, p, 1), coordinates[3:]
        ideal = pieces.ConstraintContribution(*first, second, joint_friction=rubbing, holds="closed")
        if part.normal is not None:
            friction = part.friction or Frictionless()
            contact = pieces.ContactContribution(part.name, self.gap, coordinates, p, part.contact_law(), friction)
            return [contact] if part.start == OPEN else [contact, ideal]
        reactions = pieces.Reaction("force", "N", 0), pieces.Reaction("power", "W", 0, rate="normal_speed")
        speed = pieces.SignalContribution(part.name, "normal_speed", "m/s", self.speed, coordinates, p)
        return [replace(ideal, holds="always", reactions=reactions), speed]


pair_of = roller_pair


@kernels.constraint_kernel
def equation_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Distance of a circle, or of another second curve, from a closed curve = 0."""
    _, _, nx, ny, distance, a1, b1, a2, b2, r1x, r1y, r2x, r2y = pair_of(p, q)
    g[0], J = distance, row(nx, ny, r1x, r1y, r2x, r2y)
    total = 0.0
    for j in range(6):
        G[0, j] = J[j]
        u1x, u1y, u2x, u2y, w1, w2 = unit_motion(j, r1x, r1y, r2x, r2y)
        tau = -ny * (u2x - u1x) + nx * (u2y - u1y)
        turn, first, second = travel(tau, w1, w2, distance, a1, b1, a2, b2)
        x1, y1 = -first * ny - w1 * r1y, first * nx + w1 * r1x
        x2, y2 = second * ny - w2 * r2y, -second * nx + w2 * r2x
        change = row_change(nx, ny, -turn * ny, turn * nx, r1x, r1y, r2x, r2y, x1, y1, x2, y2)
        for i in range(6):
            H[i, j] = lam[0] * change[i]
            total += v[i] * change[i] * v[j]
    gamma[0] = -total


@kernels.joint_friction_kernel
def sliding_kernel(p, q, lam, out, H):
    """Load |lam|, and sliding at the middle between c1 and c2 of the second curve, which does not roll on its body."""
    pair = pair_of(p, q)
    _, _, nx, ny, distance, _, _, _, _, r1x, r1y, r2x, r2y = pair
    half = 0.5 * distance
    r1x, r1y, r2x, r2y = r1x + half * nx, r1y + half * ny, r2x - half * nx, r2y - half * ny
    out[LOAD] = abs(lam[0])
    out[LOAD_BY_LAM] = 1.0 if lam[0] > 0.0 else (-1.0 if lam[0] < 0.0 else 0.0)
    J = row(-ny, nx, r1x, r1y, r2x, r2y)
    for j in range(6):
        out[SLIDING + j] = J[j]
        X, Y, turn = middle_change(j, pair)
        x1, y1 = X - (1.0 if j == 0 else 0.0), Y - (1.0 if j == 1 else 0.0)
        x2, y2 = X - (1.0 if j == 3 else 0.0), Y - (1.0 if j == 4 else 0.0)
        change = row_change(-ny, nx, -turn * nx, -turn * ny, r1x, r1y, r2x, r2y, x1, y1, x2, y2)
        for i in range(6):
            H[i, j] = change[i]


@kernels.gap_kernel
def distance_kernel(p, q, v, out):
    """Distance of the second curve from a closed curve."""
    put_gap(pair_of(p, q), q, v, out)


@kernels.signal_kernel
def speed_kernel(p, t, q, v, a):
    """Velocity of the second curve along the normal at the contact."""
    _, _, nx, ny, _, _, _, _, _, _, _, r2x, r2y = pair_of(p, q)
    return nx * (v[3] - v[5] * r2y) + ny * (v[4] + v[5] * r2x)


ROLLER = PairKernels(equation_kernel, distance_kernel, sliding_kernel, speed_kernel)  # curve with a circle or point


def pair_kernels(name: str, pair: Any) -> PairKernels:
    """Kernels of the pairs that a function (p, q) gives, under the `name` of this module that holds them."""
    functions = {**globals(), "pair_of": pair}
    made = (kernels.rebound(getattr(ROLLER, one.name), f"{name}.{one.name}", functions) for one in fields(PairKernels))
    return PairKernels(*made)


FACE = replace(pair_kernels("FACE", face_alone), gap=face_gap_kernel)  # pair of a closed curve with a line
CURVES = pair_kernels("CURVES", curves_pair)  # pair of two closed curves


# Curves of bodies as numbers of kernels, and distances in the reference configuration

TOLERANCE_LENGTH = 1e-3  # length by which tolerances of a run with contacts are scaled, over the size of the curve


def carriers(
    mechanism: Mechanism, owner: str, *bodies: Part
) -> tuple[list[pieces.Node], tuple[pieces.Coordinate, ...]]:
    """Nodes of both rigid bodies, or ground, that carry the curves of a pair, and their coordinates x, y, theta."""
    found = []
    for body in (mechanism.body(part.name, owner) for part in bodies):
        nodes = body.nodes()
        if len(nodes) != 1:
            text = f"{owner}: {body.label} is flexible and cannot carry a curve."
            raise ModelError(f"{text} Fix a RigidBody with the curve to one of its nodes by Fixed(...).")
        found.append(nodes[0])
    pairs = zip(bodies, found, strict=True)
    return found, tuple(c for part, node in pairs for c in pieces.node_coordinates(part.name, node.name))


def in_frame(node: pieces.Node, point: tuple[float, float]) -> tuple[float, float]:
    """A point of the reference configuration in the frame of a node [m]."""
    return planar.to_frame((node.x, node.y), node.theta, point)


def curve_numbers(curve: ClosedCurve, node: pieces.Node) -> tuple[float, ...]:
    """Numbers of a closed curve in the frame of a node, see `flexmb.parts.cams.curves`."""
    c, s = math.cos(node.theta), math.sin(node.theta)
    spans = curve.array.copy()
    spans[:, :, 0] -= (node.x, node.y)
    spans = np.einsum("ab,nbi->nai", np.array([[c, s], [-s, c]]), spans)
    n = len(spans)
    each = math.isqrt(n - 1) + 1
    boxes: list[float] = []
    for first in range(0, n, each):
        end = min(n, first + each)
        starts = spans[first:end, :, 0]
        centre = starts[len(starts) // 2]
        boxes += [*map(float, centre), float(np.hypot(*(starts - centre).T).max()), float(first), float(end)]
    return (float(n), float(-(-n // each)), *boxes, *spans.ravel().tolist())


def distance(curve: ClosedCurve, other: ClosedCurve | CircularCurve | Line) -> tuple[float, float]:
    """Approximate gap of two curves as they are drawn [m], < 0 for an overlap, and the place along a line [m]."""
    points = sampled(curve.array, SAMPLES)
    if isinstance(other, Line):
        side, u = side_of(curve, other), along(other)
        far = side * ((other.start[0] - points[:, 0]) * u[1] - (other.start[1] - points[:, 1]) * u[0])
        k = int(np.argmin(far))
        return float(far[k]), float((points[k, 0] - other.start[0]) * u[0] + (points[k, 1] - other.start[1]) * u[1])
    if isinstance(other, CircularCurve):
        return signed_distance(points, other.centre) - other.radius, 0.0
    return min(signed_distance(points, p) for p in sampled(other.array, 1)), 0.0


def signed_distance(polygon: np.ndarray, point: Any) -> float:
    """Distance of a point from a closed polygon, < 0 inside."""
    to, chord = polygon - np.asarray(point), np.roll(polygon, -1, axis=0) - polygon
    share = np.clip(-np.sum(to * chord, axis=1) / np.sum(chord * chord, axis=1), 0.0, 1.0)
    away = float(np.hypot(*(to + share[:, None] * chord).T).min())
    return -away if planar.surrounds(to) else away


def along(line: Line) -> tuple[float, float]:
    """Unit vector of a line."""
    return (line.end[0] - line.start[0]) / line.length, (line.end[1] - line.start[1]) / line.length


def side_of(curve: ClosedCurve, line: Line) -> float:
    """+1 for a curve on the left of a line, -1 on the right."""
    x, y = sampled(curve.array, 1).mean(axis=0)
    u = along(line)
    return 1.0 if u[0] * (y - line.start[1]) - u[1] * (x - line.start[0]) >= 0.0 else -1.0


def pair_shapes(mechanism: Mechanism, pair: Any, *curves: Any) -> Shapes:
    """Curves of both bodies of a pair, or of the first one alone, as polylines for pictures."""
    bodies = pair.first, pair.second
    drawn = zip(bodies, carriers(mechanism, pair.label, *bodies)[0], curves, strict=False)
    return [RigidShape(b.name, at.name, (tuple(in_frame(at, p) for p in curve.drawing()),)) for b, at, curve in drawn]


PULL = 1e-3  # pull of an ideal pair relative to its largest force, above which there is a remark
FAR = 0.25  # largest gap in the reference configuration that is closed at the start, over the size of the first curve
OVERLAP = 1e-3  # largest overlap in the reference configuration with which a contact may start open, over the same
NORMAL = instance(NormalLaw, "a normal law, e.g. HuntCrossley, or None")
FRICTION = instance(FrictionLaw, "a friction law, e.g. ModifiedCoulomb, or None")  # rules of the laws of a pair


@record
class Pair(Part):
    """Base of pairs of curves: ideal, or with the law of a contact that can open."""

    _: KW_ONLY
    normal: NormalLaw | None = field(
        "law of the normal force; None: ideal, the curves never part", rule=NORMAL, default=None
    )
    friction: FrictionLaw | None = field("law of friction", rule=FRICTION, default=None)
    start: str = field("of a contact, see `CurveOnCurve`", rule=one_of(TOUCHING, OPEN), default=TOUCHING)
    if TYPE_CHECKING:  # fields of the pairs
        first: Part
        second: Part

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_one_body(self)
        if self.normal is None and self.start == OPEN:
            raise InputError(f"{self.label}: an ideal pair cannot start open; give normal=..., or leave start.")


@record
class CurveOnCurve(Pair):
    """Two curves of two bodies that touch: cam with flat, roller or curved follower, two cams.

    One of the curves must be a `ClosedCurve`, the other is a `Line`, `CircularCurve` or `ClosedCurve`.  With a law the
    contact can open; a law made from materials has the stiffness of the places of largest curvature of both curves.  It
    starts "touching", with loops closed and velocities found as for an ideal pair, or "open": the bodies stand and move
    as declared.

    Signals, ideal: force (contact force, > 0: the bodies press on each other) [N]; normal_speed (velocity along the
    normal there, of the body with the `Line` or `CircularCurve`, else of the second one) [m/s]; power (force times
    normal_speed, given to this body) [W]; with `friction` also friction_force [N].  With `normal`: as of a contact (see
    `RevoluteClearance`; ex, ey from the surface of the first curve to that of the second).  With a `Line` also place
    (of the contact along it from its start) [m].

    Raises
    ------
    InputError : curves of other kinds, a law of the wrong kind, a concave curve under a `Line`, a roller that is larger
        than a hollow of the curve, or another curve that is (undercut).
    ModelError : a body with itself, a flexible body, curves that are far apart or overlap in the reference
        configuration.

    Notes
    -----
    Bodies lie outside of each other.  The pair is one equation, the distance on the common normal = 0; an ideal pair
    also pulls, so a negative force tells where a real follower lifts off.  The nearest points are searched anew at each
    evaluation; a contact has one point, the nearest.  An ideal `Line` counts as unlimited: `place` outside 0 to its
    length tells that it is too short.  A contact uses the ends of the segment as edges.
    Source: J. J. Uicker, G. R. Pennock, J. E. Shigley, Theory of Machines and Mechanisms, 4th ed., Oxford 2011, ch. 6.
    """

    first: Part = field("first body")
    first_curve: Any = field("its curve, in the reference configuration")
    second: Part = field("second body")
    second_curve: Any = field("its curve, in the reference configuration")

    def __post_init__(self) -> None:
        super().__post_init__()
        curves = self.first_curve, self.second_curve
        known = all(isinstance(c, ClosedCurve | CircularCurve | Line) for c in curves)
        if not known or not any(isinstance(c, ClosedCurve) for c in curves):
            text = f"{self.label}: the curves are {curves[0]!r} and {curves[1]!r}; one must be a ClosedCurve, the other"
            raise InputError(f"{text} a Line, cams.CircularCurve or ClosedCurve (fm.Circle is the section of a beam).")
        curve, other = self._ordered()[1::2]
        least, _, (x, y) = curve.extreme_curvature()
        if isinstance(other, Line) and least <= 0.0:
            text = f"{self.label}: the curve is not convex near ({x:.6g},"
            text += f" {y:.6g}) m (curvature {least:.4g} 1/m), so a straight face bridges that place."
            raise InputError(f"{text} Use a roller (CircularCurve), or another profile.")
        if isinstance(other, CircularCurve) and least * other.radius <= -1.0:
            text = f"{self.label}: the roller of radius {other.radius:g} m does not fit into the hollow near ({x:.6g},"
            text += f" {y:.6g}) m, whose radius is {-1.0 / least:.4g} m (undercut)."
            raise InputError(f"{text} Use a smaller roller.")
        if isinstance(other, ClosedCurve):
            self._check_fit(curve, other)
            self._check_fit(other, curve)

    def _check_fit(self, curve: ClosedCurve, other: ClosedCurve) -> None:
        """Refuse a hollow of `curve` that no place of `other` fits into."""
        (least, _, (x, y)), largest = curve.extreme_curvature(), other.extreme_curvature()[1]
        if least <= -largest:
            text = f"{self.label}: the other curve, of radius {1.0 / largest:.4g} m at least, does not fit"
            text += f" into the hollow near ({x:.6g}, {y:.6g}) m, of radius {-1.0 / least:.4g} m (undercut)."
            raise InputError(f"{text} Change one of them.")

    def _ordered(self) -> tuple[Part, Any, Part, Any]:
        """Bodies and curves with a closed curve first."""
        if isinstance(self.first_curve, ClosedCurve):
            return self.first, self.first_curve, self.second, self.second_curve
        return self.second, self.second_curve, self.first, self.first_curve

    @property
    def pushes(self) -> tuple[str, ...]:
        return ("force",) if self.normal is None else ()

    def findings_after(self, mechanism: Mechanism, motion: WatchedMotion) -> Iterator[Finding]:  # noqa: ARG002 - alone
        """Finding on a pull, where a real follower would lift off."""
        for name in self.pushes:
            (least, when), (largest, _) = motion.lows[f"{self.name}.{name}"], motion.peak(f"{self.name}.{name}")
            if least < -PULL * largest:
                text = f"At t = {when:.6g} s {self.label} pulls with {-least:.4g} N, where a follower would lift off."
                remedy = "Give normal=... for a contact that opens, or a stronger spring."
                yield found("unreal-motion", (self.name,), text, remedy, time=when, force=least)

    @property
    def _radii(self) -> tuple[list[float], list[float]]:
        """Radii of a circle [m], and largest curvatures of closed curves [1/m]."""
        curves = self.first_curve, self.second_curve
        radii = [c.radius for c in curves if isinstance(c, CircularCurve)]
        return radii, [c.extreme_curvature()[1] for c in curves if isinstance(c, ClosedCurve)]

    @property
    def pin_radius(self) -> float:
        """Least radius of curvature of both curves [m], beside which penetrations are judged."""
        radii, bends = self._radii
        return min([*radii, *(1.0 / bend for bend in bends)])

    def contact_law(self) -> NormalLaw | None:
        """Normal law; one made from materials has the stiffness of the places of largest curvature."""
        radii, bends = self._radii
        bend = sum([*(1.0 / radius for radius in radii), *bends])
        return None if self.normal is None else self.normal.for_radii(math.inf, 1.0 / bend)

    def validate(self, mechanism: Mechanism) -> None:
        """Refuse curves that are far apart, overlap, or touch beyond the end of a line."""
        super().validate(mechanism)
        curve, other = self._ordered()[1::2]
        check_distance(self, curve, other)

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        body, curve, second, other = self._ordered()
        nodes, coordinates = carriers(mechanism, self.label, body, second)
        head, closed = (TOLERANCE_LENGTH * curve.size,), curve_numbers(curve, nodes[0])
        if isinstance(other, Line):
            start, end = in_frame(nodes[1], other.start), in_frame(nodes[1], other.end)
            p = (*head, *start, *along(Line(start, end)), side_of(curve, other), other.length, *closed)
            place = pieces.SignalContribution(self.name, "place", "m", face_place, coordinates, p)
            return [*FACE.contributions(self, coordinates, p), place]
        if isinstance(other, CircularCurve):
            p = (*head, *in_frame(nodes[1], other.centre), other.radius, *closed)
            return ROLLER.contributions(self, coordinates, p)
        p = (*head, float(CURVE_UNDER_CURVE + len(closed)), *closed, *curve_numbers(other, nodes[1]))
        return CURVES.contributions(self, coordinates, p)

    def shapes(self, mechanism: Mechanism) -> Shapes:
        return pair_shapes(mechanism, self, self.first_curve, self.second_curve)


def check_distance(part: Any, curve: ClosedCurve, other: Any) -> None:
    """Check gap and place of contact of a pair in the reference configuration."""
    gap, place = distance(curve, other)
    size = curve.size
    if part.start == OPEN:
        if gap < -OVERLAP * size:
            text = f"{part.label}: the curves overlap by {-gap:.4g} m in the reference configuration. Move one of the"
            raise ModelError(f'{text} bodies, or give start="touching", which puts the second one onto the curve.')
        return
    if abs(gap) > FAR * size:
        word = "are" if gap > 0.0 else "overlap by"
        text = f"{part.label}: the curves {word} {abs(gap):.4g} m {'apart ' if gap > 0.0 else ''}in the reference"
        text += f" configuration, beside a curve of {size:.4g} m. Curves are given in the reference configuration,"
        text += " in the axes of the frame; move them or the bodies until they touch,"
        raise ModelError(f'{text} or give normal=... and start="open".')
    if isinstance(other, Line) and not -OVERLAP * size <= place <= other.length + OVERLAP * size:
        text = f"{part.label}: in the reference configuration the curve touches the line {place:.4g} m from its start,"
        raise ModelError(f"{text} beyond its ends at 0 and {other.length:.4g} m. Make the line longer.")


POINT = 1e-9  # radius that stands for a point in checks of distances, over the size of the curve


@record
class PointOnCurve(Pair):
    """A point of the second body that stays on a closed curve of the first: knife edge, pin in a groove.

    Signals, ideal: force (along the outward normal of the curve on the second body) [N], normal_speed (velocity
    of the point along it) [m/s], power (of the force, given to the second body) [W]; with `friction` also
    friction_force [N].  With `normal`, of an edge that can lift off outwards: as of a contact (see
    `RevoluteClearance`).

    Raises
    ------
    InputError : no closed curve, a law of the wrong kind.
    ModelError : a body with itself, a flexible body, a point far from the curve.

    Notes
    -----
    The groove has no clearance.  A pin with clearance in a straight slot is `PinSlotClearance`.
    """

    first: Part = field("body with the curve")
    curve: ClosedCurve = field("its curve", rule=instance(ClosedCurve, "a ClosedCurve"))
    second: Part = field("body with the point")
    at: tuple[float, float] = field("the point", "m", point)

    @property
    def pin_radius(self) -> float:
        """Least radius of curvature of the curve [m], beside which penetrations are judged."""
        return 1.0 / self.curve.extreme_curvature()[1]

    def contact_law(self) -> NormalLaw | None:
        """Normal law; it needs a stiffness, since an edge has no radius."""
        return self.normal

    def validate(self, mechanism: Mechanism) -> None:
        """Refuse a point far from the curve."""
        super().validate(mechanism)
        check_distance(self, self.curve, CircularCurve(self.at, POINT * self.curve.size))

    def contributions(self, mechanism: Mechanism) -> Sequence[pieces.Contribution]:
        nodes, coordinates = carriers(mechanism, self.label, self.first, self.second)
        size, numbers = TOLERANCE_LENGTH * self.curve.size, curve_numbers(self.curve, nodes[0])
        return ROLLER.contributions(self, coordinates, (size, *in_frame(nodes[1], self.at), 0.0, *numbers))

    def shapes(self, mechanism: Mechanism) -> Shapes:
        return pair_shapes(mechanism, self, self.curve)
