"""Distance of a point of the second node along a direction of the first: value, gradient, second derivatives.

d = n . (x2 + R2 s2 - x1 - R1 s1) with n = R1 m.  With e = x2 + R2 s2 - x1, far = n . e and near = n . R2 s2 the second
derivatives stand in `add_curvature`.
"""

import math

from flexmb.kernels import compiled


@compiled
def direction(mx, my, s1x, s1y, s2x, s2y, q):
    """d, its gradient, and n, far, near."""
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    nx, ny = c1 * mx - d1 * my, d1 * mx + c1 * my
    bx, by = c2 * s2x - d2 * s2y, d2 * s2x + c2 * s2y
    ex, ey = q[3] + bx - q[0], q[4] + by - q[1]
    far = nx * ex + ny * ey
    gradient = (-nx, -ny, nx * ey - ny * ex, nx, ny, ny * bx - nx * by)
    # the part along R1 s1 is constant: n . R1 s1 = m . s1
    return far - mx * s1x - my * s1y, gradient, nx, ny, far, nx * bx + ny * by


@compiled
def add_curvature(k, nx, ny, far, near, H):
    """H += k d2d/dq2."""
    H[2, 2] -= k * far
    H[5, 5] -= k * near
    H[2, 5] += k * near
    H[5, 2] += k * near
    for i, x in ((0, k * ny), (1, -k * nx), (3, -k * ny), (4, k * nx)):
        H[i, 2] += x
        H[2, i] += x


@compiled
def curvature_times(nx, ny, far, near, v):
    """d2d/dq2 v."""
    w1, w2 = v[2], v[5]
    swing = nx * (v[4] - v[1]) - ny * (v[3] - v[0]) - far * w1 + near * w2
    return ny * w1, -nx * w1, swing, -ny * w1, nx * w1, near * (w1 - w2)


@compiled
def dot(x, y):
    """Scalar product of six numbers."""
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2] + x[3] * y[3] + x[4] * y[4] + x[5] * y[5]
