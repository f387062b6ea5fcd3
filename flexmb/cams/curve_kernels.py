"""A closed curve of the second body on a closed curve of the first: constraint, gap and friction kernels."""

import math

from flexmb.cams.curves.spans import common_normal
from flexmb.cams.pair import put_equation, put_gap, put_sliding, second_speed, with_arms
from flexmb.kernels import compiled, constraint_kernel, gap_kernel, joint_friction_kernel, signal_kernel

SCALE, SECOND, CURVE = range(3)
"""Places in p: length for tolerances [m], place of the second curve, the first curve."""


@compiled
def curves_pair(p, q):
    """The pair of both curves at the coordinates q."""
    c, s = math.cos(q[2]), math.sin(q[2])
    ex, ey = q[3] - q[0], q[4] - q[1]
    turn = q[5] - q[2]
    x, y, X, Y, tx, ty, bend, other_bend = common_normal(
        p, CURVE, int(p[SECOND]), math.cos(turn), math.sin(turn), c * ex + s * ey, -s * ex + c * ey
    )
    distance = (X - x) * ty - (Y - y) * tx
    return with_arms(
        q,
        q[0] + c * x - s * y,
        q[1] + s * x + c * y,
        c * ty + s * tx,
        s * ty - c * tx,
        distance,
        1.0,
        bend,
        1.0,
        other_bend,
    )


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
