"""Contact with a worn side of a guide or slot: the nearest free place of a corner, or of the centre of a pin.

The free places of the point end at y = g + f(x) beside the side, f the cubic B-spline of the depths that can be
reached (`flexmb.parts.wear.side`): f'' is continuous, f is 0 beyond the known places.  The depth is the distance from
the border, along its normal, which turns by its curvature.

Equations (16.7) to (16.9) of docs/theory/wear.md.
"""

import math

from flexmb.kernels import compiled, gap_kernel, signal_kernel
from flexmb.parts.joints.contact_point import put_column, put_eccentricity, put_point

(PLAY, HALF, RADIUS, SIDE, ALONG_X, ALONG_Y, OFFSET1_X, OFFSET1_Y, OFFSET2_X, OFFSET2_Y, STEP, STEEPEST, DEEPEST,
 CHOSEN) = range(14)  # fmt: skip
# Place of the first depth; of a pin the left side of the slot comes first.
DEPTHS = 14
# Number of trials at most for the foot; bisection alone has found it to round-off by then.
MOST_TRIALS = 60
# Error of the foot over the distance of two places [1] that ends the search.
CLOSE = 1e-13


@compiled
def border(p, first, n, x):
    """f, f', f'' at x."""
    step = p[STEP]
    place = x / step + 0.5 * n - 0.5
    k = math.floor(place)
    u = place - k
    w = 1.0 - u
    left, right = 2.0 / 3.0 - u * u * (1.0 - 0.5 * u), 2.0 / 3.0 - w * w * (1.0 - 0.5 * w)
    weights = (w * w * w / 6.0, left, right, u * u * u / 6.0)
    slopes = (-0.5 * w * w, u * (1.5 * u - 2.0), -w * (1.5 * w - 2.0), 0.5 * u * u)
    bends = (w, 3.0 * u - 2.0, 3.0 * w - 2.0, u)
    f, f1, f2 = 0.0, 0.0, 0.0
    for j in range(4):
        i = int(k) - 1 + j
        if 0 <= i < n:
            h = p[first + i]
            f, f1, f2 = f + weights[j] * h, f1 + slopes[j] * h, f2 + bends[j] * h
    return f, f1 / step, f2 / (step * step)


@compiled
def nearest_border(p, first, n, x, y):
    """Depth D of the point (x, y), normal along and across the guide, 1/(rho + D), foot on the border."""
    s, reach = x, 2.0 * p[STEEPEST] * (abs(y) + p[DEEPEST])
    low, high = x - reach, x + reach
    f, f1, f2 = 0.0, 0.0, 0.0
    for _ in range(MOST_TRIALS):
        f, f1, f2 = border(p, first, n, s)
        F, F_s = x - s + (y - f) * f1, -1.0 - f1 * f1 + (y - f) * f2
        if F_s < 0.0 and abs(F) <= -CLOSE * p[STEP] * F_s:
            break
        if F >= 0.0:
            low = s
        else:
            high = s
        s = s - F / F_s if F_s < 0.0 else low
        if not low < s < high:
            s = 0.5 * (low + high)
    size = math.sqrt(1.0 + f1 * f1)
    depth, bend = (y - f) * size, -f2 / (size * size * size)
    turns = 1.0 + bend * depth
    return depth, -f1 / size, 1.0 / size, bend / turns if turns != 0.0 else 0.0, s


@compiled
def touch(p, q):
    """Arms, point in the axes of the guide, its directions, depth, normal, curvature, point of contact, side, place."""
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    ax, ay = c1 * p[OFFSET1_X] - d1 * p[OFFSET1_Y], d1 * p[OFFSET1_X] + c1 * p[OFFSET1_Y]
    bx, by = c2 * p[OFFSET2_X] - d2 * p[OFFSET2_Y], d2 * p[OFFSET2_X] + c2 * p[OFFSET2_Y]
    ux, uy = c1 * p[ALONG_X] - d1 * p[ALONG_Y], d1 * p[ALONG_X] + c1 * p[ALONG_Y]
    ex, ey = q[3] + bx - q[0] - ax, q[4] + by - q[1] - ay
    along, across = ux * ex + uy * ey, ux * ey - uy * ex
    far, side, n = p[PLAY] + p[HALF], p[SIDE], p.shape[0] - DEPTHS
    if side == 0.0:
        n = n // 2
        side = 1.0
        depth, mx, my, inverse, foot = nearest_border(p, DEPTHS, n, along, across - far)
        deeper, ox, oy, turns, place = nearest_border(p, DEPTHS + n, n, along, -across - far)
        if deeper > depth:
            side, depth, mx, my, inverse, foot = -1.0, deeper, ox, oy, turns, place
    else:
        depth, mx, my, inverse, foot = nearest_border(p, DEPTHS, n, along, side * across - far)
    nx, ny = mx * ux - side * my * uy, mx * uy + side * my * ux
    radius = p[RADIUS]
    ahead, grows = (radius - 0.5 * depth, -0.5) if radius > 0.0 else (0.0, 0.0)
    return ax, ay, bx, by, ex, ey, ux, uy, across, depth, nx, ny, inverse, ahead, grows, foot + radius * mx


@gap_kernel
def worn_side_gap_kernel(p, q, v, out):
    """Corner or pin against the worn sides of a guide or slot."""
    ax, ay, bx, by, ex, ey, ux, uy, across, depth, nx, ny, inverse, ahead, grows, _ = touch(p, q)
    put_point(out, q, v, -depth, nx, ny, q[3] + bx + ahead * nx, q[4] + by + ahead * ny)
    vx, vy = v[3] - v[5] * by - v[0] + v[2] * ay, v[4] + v[5] * bx - v[1] - v[2] * ax
    wx, wy = (ex, ey) if p[SIDE] != 0.0 else (-across * uy, across * ux)
    put_eccentricity(out, wx, wy, vx, vy)
    gx, gy = (-1.0, 0.0, ay, 1.0, 0.0, -by), (0.0, -1.0, -ax, 0.0, 1.0, bx)  # de/dq
    for j in range(6):
        x, y, turn, px, py = gx[j], gy[j], 0.0, 0.0, 0.0
        if j > 2:
            px, py = x, y
        if j == 2:  # the guide turns
            x, y, turn = x + ey, y - ex, 1.0
        turn += inverse * (nx * y - ny * x)
        r = grows * (nx * x + ny * y)
        put_column(out, j, -ny * turn, nx * turn, px - ahead * ny * turn + r * nx, py + ahead * nx * turn + r * ny)


PLACE, SLIDING = range(2)
# Signals with their units, in the order of `worn_side_signal`; the last one of a pin alone.
SIGNALS = (("place", "m"), ("slip", "m/s"), ("offset", "m"))


@signal_kernel
def worn_side_signal(p, t, q, v, a):
    """`CHOSEN`: place of the contact along the guide from its middle, slip, place of the pin across the slot."""
    _, _, bx, by, _, _, _, _, across, _, nx, ny, _, ahead, _, place = touch(p, q)
    which = int(p[CHOSEN])
    if which == PLACE:
        return place
    if which != SLIDING:
        return across
    r2x, r2y = bx + ahead * nx, by + ahead * ny
    r1x, r1y = r2x + q[3] - q[0], r2y + q[4] - q[1]
    x, y = v[3] - v[5] * r2y - v[0] + v[2] * r1y, v[4] + v[5] * r2x - v[1] - v[2] * r1x
    return nx * y - ny * x


@signal_kernel
def worn_guide_mode(p, t, q, v, a):
    """Mode of a slider by its corners: 0 free, 1 one, 2 two across, 3 face, 4 more; p: of each, upper ones first."""
    size, upper, lower = p.shape[0] // 4, 0, 0
    for k in range(4):
        _, _, _, _, _, _, _, _, _, depth, _, _, _, _, _, _ = touch(p[k * size : (k + 1) * size], q)
        touching = depth >= 0.0
        if k < 2:
            upper += touching
        else:
            lower += touching
    if upper + lower > 2:
        return 4.0
    return 3.0 if upper == 2 or lower == 2 else float(upper + lower)
