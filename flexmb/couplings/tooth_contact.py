"""Contact of involute teeth with backlash: one flank of a gear pair along its line of action."""

from __future__ import annotations

import math

from flexmb.joints.contact_point import put_column, put_eccentricity, put_point
from flexmb.kernels import gap_kernel
from flexmb.places import GAP_RATE

STEEPEST = 1.0 - 1e-9
"""Largest cosine of the operating pressure angle: axes that come closer are counted as this far apart."""


@gap_kernel
def tooth_gap_kernel(p, q, v, out):
    """Gap of involute flanks: half the play, opened by the distance of the axes, closed by the relative rotation.

    With B = rb1 + rb2 (rb2 < 0: internal), the distance D and direction psi of the axes and cos alpha = |B|/D:
    gap = half + B (inv alpha - inv alpha_0) -+ [rb1 (theta1 - psi) + rb2 (theta2 - psi) - offset], inv x = tan x - x.
    """
    _, half, rb1, rb2, side, inv_a, offset, pitch = p
    dx, dy = q[3] - q[0], q[4] - q[1]
    D, B = math.sqrt(dx * dx + dy * dy), rb1 + rb2
    sign = 1.0 if B > 0.0 else -1.0
    ex, ey = dx / D, dy / D
    cos_a = min(sign * B / D, STEEPEST)
    sin_a = math.sqrt(1.0 - cos_a * cos_a)
    tan_a = sin_a / cos_a
    x = rb1 * q[2] + rb2 * q[5] - B * math.atan2(dy, dx) - offset
    x -= pitch * math.floor(x / pitch + 0.5)  # all teeth are alike
    gap = half + B * (tan_a - math.atan(tan_a) - inv_a) - side * x
    nx, ny = -sign * (sin_a * ex - side * cos_a * ey), -sign * (sin_a * ey + side * cos_a * ex)
    share = rb1 / B
    put_point(out, q, v, gap, nx, ny, q[0] + share * dx, q[1] + share * dy)
    wx, wy = 0.0, 0.0
    for j in range(6):
        gx, gy = 0.0, 0.0
        if j == 0:
            gx = -1.0
        elif j == 1:
            gy = -1.0
        elif j == 3:
            gx = 1.0
        elif j == 4:
            gy = 1.0
        turn, bend = (ex * gy - ey * gx) / D, (ex * gx + ey * gy) * cos_a / (D * sin_a)
        along, across = cos_a * bend - side * cos_a * turn, sin_a * turn - side * sin_a * bend
        nqx, nqy = -sign * (along * ex - across * ey), -sign * (along * ey + across * ex)
        Xq, Yq = share * gx + (1.0 if j == 0 else 0.0), share * gy + (1.0 if j == 1 else 0.0)
        put_column(out, j, nqx, nqy, Xq, Yq)
        wx += nqx * v[j]
        wy += nqy * v[j]
    rate = out[GAP_RATE]
    put_eccentricity(out, -gap * nx, -gap * ny, -rate * nx - gap * wx, -rate * ny - gap * wy)


def involute(angle: float) -> float:
    """tan(angle) - angle, the roll angle of an involute less its pressure angle."""
    return math.tan(angle) - angle
