"""Line between a point of one node and a point of another: vectors, and a force along the line."""

import math

from flexmb.kernels import compiled


@compiled
def arms_of(s1x, s1y, s2x, s2y, q):
    """Vectors from the nodes to the points, and from the first point to the second."""
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    ax, ay = c1 * s1x - d1 * s1y, d1 * s1x + c1 * s1y
    bx, by = c2 * s2x - d2 * s2y, d2 * s2x + c2 * s2y
    return ax, ay, bx, by, q[3] + bx - q[0] - ax, q[4] + by - q[1] - ay


@compiled
def put_line_force(F, nx, ny, ax, ay, bx, by, r):
    """r (6,) of a tension F along (nx, ny), the direction from the first point to the second."""
    r[0], r[1], r[2] = -F * nx, -F * ny, F * (nx * ay - ny * ax)
    r[3], r[4], r[5] = F * nx, F * ny, F * (ny * bx - nx * by)
