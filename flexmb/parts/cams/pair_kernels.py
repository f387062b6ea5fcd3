"""Two curves on their common normal: constraint, gap and friction kernels by the kind of the second curve.

c1 and c2 = c1 + distance n are the points of both curves, n the outward normal of the first one, t = k x n.  A curve
has the curvature b/a there (1/0: a point, 0/1: a line).  With tau = t . (u2 - u1) of the velocities u of the material
points, the normal turns by dphi and the points travel by ds1, ds2 along their curves, each counter-clockwise:
    dphi (a1 b2 + a2 b1 + b1 b2 distance) = b1 b2 tau + a1 b2 dtheta1 + a2 b1 dtheta2
    ds1  (...) = a1 (b2 tau + a2 (dtheta2 - dtheta1) - b2 distance dtheta1),   ds2 = tau - ds1 - distance dphi
Source: to second order a curve is its circle of curvature; the equations are those of its rolling and sliding (J. J.
Uicker, G. R. Pennock, J. E. Shigley, Theory of Machines and Mechanisms, 4th ed., 2011, on Euler-Savary and cams).
"""

import math
from dataclasses import dataclass, replace
from typing import Any

from flexmb.kernels import Kernel, compiled, constraint_kernel, gap_kernel, joint_friction_kernel, signal_kernel
from flexmb.model.contributions import (
    ConstraintContribution,
    ContactContribution,
    Contribution,
    Coordinate,
    JointFriction,
    Reaction,
    SignalContribution,
)
from flexmb.parts.cams.spans import common_normal, extreme
from flexmb.parts.contact.friction import Frictionless
from flexmb.parts.joints.contact_point import put_column, put_eccentricity, put_point
from flexmb.places import LOAD, LOAD_BY_LAM, SLIDING


@compiled
def unit_motion(j, r1x, r1y, r2x, r2y):
    """Velocities u1, u2 of the material points at c1, c2 and of both angles, for a unit velocity of coordinate j."""
    if j == 0:
        return 1.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if j == 1:
        return 0.0, 1.0, 0.0, 0.0, 0.0, 0.0
    if j == 2:
        return -r1y, r1x, 0.0, 0.0, 1.0, 0.0
    if j == 3:
        return 0.0, 0.0, 1.0, 0.0, 0.0, 0.0
    if j == 4:
        return 0.0, 0.0, 0.0, 1.0, 0.0, 0.0
    return 0.0, 0.0, -r2y, r2x, 0.0, 1.0


@compiled
def travel(tau, w1, w2, distance, a1, b1, a2, b2):
    """Turn of the normal, and travel of both points along their curves; no turn where any normal would do."""
    scale = a1 * b2 + a2 * b1 + b1 * b2 * distance
    over = 1.0 / scale if scale != 0.0 else 0.0
    turn = over * (b1 * b2 * tau + a1 * b2 * w1 + a2 * b1 * w2)
    first = over * a1 * (b2 * tau + a2 * (w2 - w1) - b2 * distance * w1)
    return turn, first, tau - first - distance * turn


@compiled
def row(x, y, r1x, r1y, r2x, r2y):
    """Velocity of c2 less that of c1 along (x, y), by the six coordinates."""
    return -x, -y, x * r1y - y * r1x, x, y, y * r2x - x * r2y


@compiled
def row_change(x, y, px, py, r1x, r1y, r2x, r2y, x1, y1, x2, y2):
    """Derivative of `row`, for derivatives (px, py) of the direction, (x1, y1) and (x2, y2) of the arms."""
    return (-px, -py, px * r1y - py * r1x + x * y1 - y * x1, px, py, py * r2x - px * r2y + y * x2 - x * y2)


@compiled
def with_arms(q, X, Y, nx, ny, distance, a1, b1, a2, b2):
    """All numbers of a pair: c1, normal, distance, curvatures, arms from both nodes to c1 and c2."""
    r2x, r2y = X + distance * nx - q[3], Y + distance * ny - q[4]
    return X, Y, nx, ny, distance, a1, b1, a2, b2, X - q[0], Y - q[1], r2x, r2y


@compiled
def second_speed(pair, v):
    """Velocity of the second body along the normal at c2."""
    _, _, nx, ny, _, _, _, _, _, _, _, r2x, r2y = pair
    return nx * (v[3] - v[5] * r2y) + ny * (v[4] + v[5] * r2x)


@compiled
def put_equation(pair, v, lam, g, G, gamma, H):
    """Equation distance = 0 of a constraint kernel."""
    _, _, nx, ny, distance, a1, b1, a2, b2, r1x, r1y, r2x, r2y = pair
    g[0] = distance
    J = row(nx, ny, r1x, r1y, r2x, r2y)
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


@compiled
def middle_change(j, pair):
    """Derivatives of the middle between c1 and c2 by coordinate j, and turn of the normal."""
    _, _, nx, ny, distance, a1, b1, a2, b2, r1x, r1y, r2x, r2y = pair
    u1x, u1y, u2x, u2y, w1, w2 = unit_motion(j, r1x, r1y, r2x, r2y)
    tau = -ny * (u2x - u1x) + nx * (u2y - u1y)
    turn, first, _ = travel(tau, w1, w2, distance, a1, b1, a2, b2)
    along, across = 0.5 * (nx * (u2x - u1x) + ny * (u2y - u1y)), first + 0.5 * distance * turn
    return u1x + along * nx - across * ny, u1y + along * ny + across * nx, turn


@compiled
def put_sliding(pair, lam, out, H):
    """Output of a joint-friction kernel: load |lam|, and sliding at the middle between c1 and c2."""
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


@compiled
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
    put_eccentricity(
        out, distance * nx, distance * ny, rate * nx - distance * spin * ny, rate * ny + distance * spin * nx
    )


CURVE_SCALE, SECOND, CURVE_UNDER_CURVE = range(3)  # places in p: length for tolerances [m], second curve, first curve


@compiled
def curves_pair(p, q):
    """The pair of both curves at the coordinates q."""
    c, s = math.cos(q[2]), math.sin(q[2])
    ex, ey = q[3] - q[0], q[4] - q[1]
    turn = q[5] - q[2]
    x, y, X, Y, tx, ty, bend, other_bend = common_normal(
        p, CURVE_UNDER_CURVE, int(p[SECOND]), math.cos(turn), math.sin(turn), c * ex + s * ey, -s * ex + c * ey
    )
    distance = (X - x) * ty - (Y - y) * tx
    fx, fy, ux, uy = q[0] + c * x - s * y, q[1] + s * x + c * y, c * ty + s * tx, s * ty - c * tx
    return with_arms(q, fx, fy, ux, uy, distance, 1.0, bend, 1.0, other_bend)


@constraint_kernel
def curves_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Distance of two closed curves = 0."""
    put_equation(curves_pair(p, q), v, lam, g, G, gamma, H)


@joint_friction_kernel
def curves_friction(p, q, lam, out, H):
    """Load and sliding of a closed curve on another one."""
    put_sliding(curves_pair(p, q), lam, out, H)


@gap_kernel
def curves_gap_kernel(p, q, v, out):
    """Distance of two closed curves."""
    put_gap(curves_pair(p, q), q, v, out)


@signal_kernel
def curves_speed(p, t, q, v, a):
    """Velocity of the second curve along the normal at the contact."""
    return second_speed(curves_pair(p, q), v)


# Places in p: length for tolerances [m], centre in the frame of the second node [m], radius [m], the curve.
POINT_SCALE, CENTRE_X, CENTRE_Y, RADIUS, CURVE_UNDER_POINT = range(5)


@compiled
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


@compiled
def roller_pair(p, q):
    """The pair of the curve and the roller at the coordinates q."""
    c, s = math.cos(q[5]), math.sin(q[5])
    X, Y = q[3] + c * p[CENTRE_X] - s * p[CENTRE_Y], q[4] + s * p[CENTRE_X] + c * p[CENTRE_Y]
    return point_pair(p, CURVE_UNDER_POINT, q, X, Y, p[RADIUS])


@constraint_kernel
def roller_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Distance of a circle from a closed curve = 0."""
    put_equation(roller_pair(p, q), v, lam, g, G, gamma, H)


@joint_friction_kernel
def roller_friction(p, q, lam, out, H):
    """Load and sliding of a circle, which does not roll on its body, on a closed curve."""
    put_sliding(roller_pair(p, q), lam, out, H)


@gap_kernel
def roller_gap_kernel(p, q, v, out):
    """Distance of a circle from a closed curve."""
    put_gap(roller_pair(p, q), q, v, out)


@signal_kernel
def roller_speed(p, t, q, v, a):
    """Velocity of the circle along the normal at the contact."""
    return second_speed(roller_pair(p, q), v)


# Places in p: length for tolerances [m], first end of the line [m] and its direction in the frame of the second node,
# +1 for a curve on the left of the line and -1 on the right, length of the line [m], the curve.
LINE_SCALE, START_X, START_Y, ALONG_X, ALONG_Y, SIDE, LENGTH, CURVE_UNDER_LINE = range(8)


@compiled
def face_pair(p, q):
    """The pair of the curve and the whole line; place of the contact along the line from its first end; that end."""
    c1, s1, c2, s2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    ux, uy = c2 * p[ALONG_X] - s2 * p[ALONG_Y], s2 * p[ALONG_X] + c2 * p[ALONG_Y]
    X, Y = q[3] + c2 * p[START_X] - s2 * p[START_Y], q[4] + s2 * p[START_X] + c2 * p[START_Y]
    nx, ny = p[SIDE] * uy, -p[SIDE] * ux  # from the curve to the line
    x, y, _, _, bend = extreme(p, CURVE_UNDER_LINE, c1 * nx + s1 * ny, -s1 * nx + c1 * ny, False)
    x, y = q[0] + c1 * x - s1 * y, q[1] + s1 * x + c1 * y
    distance = (X - x) * nx + (Y - y) * ny
    pair = with_arms(q, x, y, nx, ny, distance, 1.0, bend, 1.0, 0.0)
    return pair, (x - X) * ux + (y - Y) * uy, X, Y


@constraint_kernel
def face_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Distance of a line from a convex closed curve = 0."""
    pair, _, _, _ = face_pair(p, q)
    put_equation(pair, v, lam, g, G, gamma, H)


@joint_friction_kernel
def face_friction(p, q, lam, out, H):
    """Load and sliding of a line on a closed curve."""
    pair, _, _, _ = face_pair(p, q)
    put_sliding(pair, lam, out, H)


@gap_kernel
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


@signal_kernel
def face_place(p, t, q, v, a):
    """Place of the contact along the line from its first end."""
    _, place, _, _ = face_pair(p, q)
    return place


@signal_kernel
def face_speed(p, t, q, v, a):
    """Velocity of the line along the normal at the contact."""
    pair, _, _, _ = face_pair(p, q)
    return second_speed(pair, v)


# Kernels of pairs of curves, by kind of the second curve, and contributions made of them

TOUCHING, OPEN = "touching", "open"  # starts of a contact: second body put onto the curve, or where it is drawn


@dataclass(frozen=True)
class PairKernels:
    """Kernels of one kind of pair."""

    equation: Kernel  # constraint kernel of the distance
    gap: Kernel  # gap kernel
    sliding: Kernel  # joint-friction kernel
    speed: Kernel  # signal kernel of the normal speed of the second body

    def contributions(self, part: Any, coordinates: tuple[Coordinate, ...], p: tuple[float, ...]) -> list[Contribution]:
        """Constraint equation of an ideal pair; contact and its ideal form at the start."""
        rubbing = None if part.friction is None else JointFriction(self.sliding, p, part.friction)
        first, second = (part.name, self.equation, coordinates, p, 1), coordinates[3:]
        ideal = ConstraintContribution(*first, second, joint_friction=rubbing, holds="closed")
        if part.normal is not None:
            friction = part.friction or Frictionless()
            contact = ContactContribution(part.name, self.gap, coordinates, p, part.contact_law(), friction)
            return [contact] if part.start == OPEN else [contact, ideal]
        reactions = Reaction("force", "N", 0), Reaction("power", "W", 0, rate="normal_speed")
        speed = SignalContribution(part.name, "normal_speed", "m/s", self.speed, coordinates, p)
        return [replace(ideal, holds="always", reactions=reactions), speed]


FACE = PairKernels(face_kernel, face_gap_kernel, face_friction, face_speed)  # pair of a closed curve with a line
ROLLER = PairKernels(roller_kernel, roller_gap_kernel, roller_friction, roller_speed)  # curve with a circle or point
CURVES = PairKernels(curves_kernel, curves_gap_kernel, curves_friction, curves_speed)  # pair of two closed curves
