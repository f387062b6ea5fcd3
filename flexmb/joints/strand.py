"""Straight strand between two points or drums: gap kernel of cables and of stops along a distance.

With the line from the first centre to the second, d = D (cos phi, sin phi), and R = R1 + R2 the strand is a tangent of
both drums, u = (cos psi, sin psi) with psi = phi - asin(R/D), free for l = sqrt(D^2 - R^2).  A drum with R > 0 winds up
while it turns counter-clockwise, with R < 0 while it turns clockwise; R = 0 is a point.  The strand is drawn out by
    E = l + R1 (theta1 - psi) + R2 (theta2 - psi),   dE = u . dd + R1 dtheta1 + R2 dtheta2
"""

import math

from flexmb.joints.contact_point import difference_column, put_column, put_eccentricity, put_point
from flexmb.kernels import compiled, gap_kernel, signal_kernel


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
    """gap = side (value - E), n = side u: side 1 pulls where the strand is drawn out, -1 pushes where it is short.

    The angle psi counts from `drawn`, within half a turn.  Both forces act at the point where the first drum is left.
    Equation (13.4) of docs/theory/wheels.md.
    """
    _, side, value, s1x, s1y, s2x, s2y, R1, R2, drawn = p
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    ax, ay, bx, by = c1 * s1x - d1 * s1y, d1 * s1x + c1 * s1y, c2 * s2x - d2 * s2y, d2 * s2x + c2 * s2y
    dx, dy, R = q[3] + bx - q[0] - ax, q[4] + by - q[1] - ay, R1 + R2
    ux, uy, size, inverse = strand(R, dx, dy)
    drawn_out = size
    if R1 != 0.0 or R2 != 0.0:
        turn = math.atan2(uy, ux) - drawn
        turn -= 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)
        drawn_out += R1 * (q[2] - turn) + R2 * (q[5] - turn)
    nx, ny = side * ux, side * uy
    put_point(out, q, v, side * (value - drawn_out), nx, ny, q[0] + ax - R1 * uy, q[1] + ay + R1 * ux)
    vx, vy = v[3] - v[5] * by - v[0] + v[2] * ay, v[4] + v[5] * bx - v[1] - v[2] * ax
    swing = (ux * vy - uy * vx) * inverse
    longer = ux * vx + uy * vy + R * swing
    put_eccentricity(out, size * ux, size * uy, longer * ux - size * swing * uy, longer * uy + size * swing * ux)
    for j in range(6):
        gx, gy, Xq, Yq = difference_column(j, ax, ay, bx, by)  # of d and of the first centre
        turn = (ux * gy - uy * gx) * inverse
        put_column(out, j, -ny * turn, nx * turn, Xq - R1 * turn * ux, Yq - R1 * turn * uy)


@signal_kernel
def strand_length(p, t, q, v, a):
    """Free length of a strand: the distance of its points."""
    s1x, s1y, s2x, s2y, R = p
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    dx = q[3] + c2 * s2x - d2 * s2y - q[0] - c1 * s1x + d1 * s1y
    dy = q[4] + d2 * s2x + c2 * s2y - q[1] - d1 * s1x - c1 * s1y
    return math.sqrt(max(dx * dx + dy * dy - R * R, 0.0))
