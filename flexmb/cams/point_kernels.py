"""A point or roller of the second body on a closed curve of the first: constraint, gap and friction kernels."""

import math

from flexmb.cams.curves.spans import foot
from flexmb.cams.pair import put_equation, put_gap, put_sliding, second_speed, with_arms
from flexmb.kernels import compiled, constraint_kernel, gap_kernel, joint_friction_kernel, signal_kernel

SCALE, CENTRE_X, CENTRE_Y, RADIUS, CURVE = range(5)
"""Places in p: length for tolerances [m], centre in the frame of the second node [m], radius [m], the curve."""


@compiled
def point_pair(p, base, q, X, Y, radius):
    """The pair of the curve at `base` and a circle around (X, Y), a point for the radius 0."""
    c, s = math.cos(q[2]), math.sin(q[2])
    ex, ey = X - q[0], Y - q[1]
    Z, W = c * ex + s * ey, -s * ex + c * ey
    x, y, tx, ty, bend = foot(p, base, Z, W)
    away = (Z - x) * ty - (W - y) * tx
    nx, ny = c * ty + s * tx, s * ty - c * tx
    X, Y = q[0] + c * x - s * y, q[1] + s * x + c * y
    return with_arms(q, X, Y, nx, ny, away - radius, 1.0, bend, radius, 1.0)


@compiled
def roller_pair(p, q):
    """The pair of the curve and the roller at the coordinates q."""
    c, s = math.cos(q[5]), math.sin(q[5])
    X, Y = q[3] + c * p[CENTRE_X] - s * p[CENTRE_Y], q[4] + s * p[CENTRE_X] + c * p[CENTRE_Y]
    return point_pair(p, CURVE, q, X, Y, p[RADIUS])


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
