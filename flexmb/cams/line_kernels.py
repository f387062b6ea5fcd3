"""A straight face of the second body on a closed curve of the first: constraint, gap and friction kernels."""

import math

from flexmb.cams.curves.spans import support
from flexmb.cams.pair import put_equation, put_gap, put_sliding, second_speed, with_arms
from flexmb.cams.point_kernels import point_pair
from flexmb.kernels import compiled, constraint_kernel, gap_kernel, joint_friction_kernel, signal_kernel

SCALE, START_X, START_Y, ALONG_X, ALONG_Y, SIDE, LENGTH, CURVE = range(8)
"""Places in p: length for tolerances [m], first end of the line [m] and its direction in the frame of the second node,
+1 for a curve on the left of the line and -1 on the right, length of the line [m], the curve."""


@compiled
def face_pair(p, q):
    """The pair of the curve and the whole line; place of the contact along the line from its first end; that end."""
    c1, s1, c2, s2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    ux, uy = c2 * p[ALONG_X] - s2 * p[ALONG_Y], s2 * p[ALONG_X] + c2 * p[ALONG_Y]
    X, Y = q[3] + c2 * p[START_X] - s2 * p[START_Y], q[4] + s2 * p[START_X] + c2 * p[START_Y]
    nx, ny = p[SIDE] * uy, -p[SIDE] * ux  # from the curve to the line
    x, y, _, _, bend = support(p, CURVE, c1 * nx + s1 * ny, -s1 * nx + c1 * ny)
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
    put_gap(point_pair(p, CURVE, q, X, Y, 0.0), q, v, out)


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
