"""Contact of a worn surface: the nearest free place of the journal's centre, and the arm of friction.

e is the eccentricity in the axes of the worn body, u(phi) a direction there, sigma the support of the free places
(`flexmb.parts.wear.profile`).  The depth is the distance of e from them, D = max (e . u - sigma), along the normal n at
the largest value; n turns by t/(rho + D) with e.

Equations (16.2), (16.3) and (16.5) of docs/theory/wear.md.
"""

import math

from flexmb.kernels import compiled, gap_kernel, signal_kernel
from flexmb.parts.joints.contact_point import put_column, put_eccentricity, put_point

CLEARANCE, BEARING_RADIUS, OFFSET1_X, OFFSET1_Y, OFFSET2_X, OFFSET2_Y, ON_JOURNAL, CHOSEN = range(8)
# Place of the first number of the tables of a `Surface`, one behind the other.
TABLES = 8


@compiled
def nearest(p, n, ex, ey):
    """Depth D, normal, and 1/(rho + D), by which the normal turns; (ex, ey) in the axes of the worn body."""
    # Between two angles sigma is rho_0 + r x + a cos x + b sin x, so the largest value has a closed form.
    cos, sin, support, slope, radius = TABLES, TABLES + n, TABLES + 2 * n, TABLES + 3 * n, TABLES + 4 * n
    k, best = 0, -math.inf
    for i in range(n):
        now = ex * p[cos + i] + ey * p[sin + i] - p[support + i]
        if now > best:
            k, best = i, now
    if ey * p[cos + k] - ex * p[sin + k] < p[slope + k]:
        k = k - 1 if k > 0 else n - 1
    step, ux, uy, rho = 2.0 * math.pi / n, p[cos + k], p[sin + k], p[radius + k]
    following = k + 1 if k < n - 1 else 0
    r = (p[radius + following] - rho) / step
    along, across = ex * ux + ey * uy - p[support + k] + rho, ey * ux - ex * uy - p[slope + k] + r
    size, x = math.sqrt(along * along + across * across), 0.0
    if size > 0.0:
        x = math.atan2(across, along) - math.asin(min(max(r / size, -1.0), 1.0))
        x = min(max(x, 0.0), step)
    c, s = math.cos(x), math.sin(x)
    depth = along * c + across * s - rho - r * x
    turns = rho + r * x + depth
    return depth, ux * c - uy * s, uy * c + ux * s, 1.0 / turns if turns > 0.0 and size > 0.0 else 0.0


@compiled
def arm(p, n, ex, ey, depth, nx, ny, inverse):
    """Factor of the arm of friction, and its derivatives by e."""
    # It is the sum of the pressures over the size of their resultant, beside the same of an unworn bearing at this
    # depth.
    c, tx, ty = p[CLEARANCE], -ny, nx
    A, B, A0, B0 = 0.0, 0.0, 0.0, 0.0
    Ax, Ay, Bx, By, turn = 0.0, 0.0, 0.0, 0.0, 0.0
    A0n, A0t, B0n, B0t = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        ux, uy = p[TABLES + i], p[TABLES + n + i]
        near, aside = ux * nx + uy * ny, ux * tx + uy * ty
        d = ex * ux + ey * uy - p[TABLES + 5 * n + i]
        if d > 0.0:
            A, B, turn = A + d, B + d * near, turn + d * aside
            Ax, Ay, Bx, By = Ax + ux, Ay + uy, Bx + near * ux, By + near * uy
        d = (c + depth) * near - c
        if d > 0.0:
            along, across = near, (c + depth) * aside * inverse
            A0, B0 = A0 + d, B0 + d * near
            A0n, A0t = A0n + along, A0t + across
            B0n, B0t = B0n + near * along, B0t + near * across + d * aside * inverse
    x, y, factor = 0.0, 0.0, 1.0
    if B > 0.0 and A > 0.0:
        factor = A / B
        Bx, By = Bx + turn * inverse * tx, By + turn * inverse * ty
        x, y = Ax / A - Bx / B, Ay / A - By / B
    if B0 > 0.0:
        factor *= B0 / A0
        along, across = B0n / B0 - A0n / A0, B0t / B0 - A0t / A0
        x, y = x + along * nx + across * tx, y + along * ny + across * ty
    return factor, factor * x, factor * y


@compiled
def relative(p, q, v):
    """Arms from the nodes to both centres, eccentricity and its rate."""
    c1, d1, c2, d2 = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    ax, ay = c1 * p[OFFSET1_X] - d1 * p[OFFSET1_Y], d1 * p[OFFSET1_X] + c1 * p[OFFSET1_Y]
    bx, by = c2 * p[OFFSET2_X] - d2 * p[OFFSET2_Y], d2 * p[OFFSET2_X] + c2 * p[OFFSET2_Y]
    ex, ey = q[3] + bx - q[0] - ax, q[4] + by - q[1] - ay
    vex, vey = v[3] - by * v[5] - v[0] + ay * v[2], v[4] + bx * v[5] - v[1] - ax * v[2]
    worn = 5 if p[ON_JOURNAL] > 0.0 else 2  # rotation of the worn body
    return ax, ay, bx, by, ex, ey, vex, vey, worn, math.cos(q[worn]), math.sin(q[worn])


@gap_kernel
def worn_gap_kernel(p, q, v, out):
    """Journal in a worn bearing, or worn journal: the normal passes through the centre of the surface that is round."""
    n, c, R1 = (p.shape[0] - TABLES) // 6, p[CLEARANCE], p[BEARING_RADIUS]
    ax, ay, bx, by, ex, ey, vex, vey, worn, C, S = relative(p, q, v)
    X, Y, radius, grows = q[3] + bx, q[4] + by, R1 - c, -0.5
    if worn == 5:
        X, Y, radius, grows = q[0] + ax, q[1] + ay, R1, 0.5
    lx, ly = C * ex + S * ey, C * ey - S * ex
    depth, mx, my, inverse = nearest(p, n, lx, ly)
    factor, fx, fy = 1.0, 0.0, 0.0
    if depth > 0.0:
        factor, fx, fy = arm(p, n, lx, ly, depth, mx, my, inverse)
    nx, ny, fx, fy = C * mx - S * my, S * mx + C * my, C * fx - S * fy, S * fx + C * fy
    radius += grows * depth
    put_point(out, q, v, -depth, nx, ny, X + factor * radius * nx, Y + factor * radius * ny)
    put_eccentricity(out, ex, ey, vex, vey)
    gx, gy = (-1.0, 0.0, ay, 1.0, 0.0, -by), (0.0, -1.0, -ax, 0.0, 1.0, bx)  # de/dq
    for j in range(6):
        x, y, turn, px, py = gx[j], gy[j], 0.0, 0.0, 0.0
        if j == worn:
            x, y, turn = x + ey, y - ex, 1.0
        if j < 3 and worn == 5:
            px, py = -x, -y
        elif j > 2 and worn == 2:
            px, py = x, y
        turn += inverse * (nx * y - ny * x)
        r = (fx * x + fy * y) * radius + factor * grows * (nx * x + ny * y)
        put_column(out, j, -ny * turn, nx * turn, px + r * nx - factor * radius * ny * turn,
                   py + r * ny + factor * radius * nx * turn)  # fmt: skip


PLACE_X, PLACE_Y, ANGLE, SLIDING = range(4)
# Signals with their units, in the order of `worn_signal`.
SIGNALS = (("x", "m"), ("y", "m"), ("contact_angle", "rad"), ("slip", "m/s"))


@signal_kernel
def worn_signal(p, t, q, v, a):
    """`CHOSEN`: place in `SIGNALS`; the first three in the axes of the worn body."""
    which, n = int(p[CHOSEN]), (p.shape[0] - TABLES) // 6
    _, _, _, _, ex, ey, vex, vey, worn, C, S = relative(p, q, v)
    lx, ly = C * ex + S * ey, C * ey - S * ex
    if which == PLACE_X:
        return lx
    if which == PLACE_Y:
        return ly
    depth, mx, my, inverse = nearest(p, n, lx, ly)
    if which == ANGLE:
        return math.atan2(my, mx)
    factor = 1.0
    if depth > 0.0:
        factor, _, _ = arm(p, n, lx, ly, depth, mx, my, inverse)
    nx, ny, spin = C * mx - S * my, S * mx + C * my, v[worn]
    radius = p[BEARING_RADIUS] + 0.5 * depth if worn == 5 else p[BEARING_RADIUS] - p[CLEARANCE] - 0.5 * depth
    return nx * (vey - ex * spin) - ny * (vex + ey * spin) + factor * radius * (v[5] - v[2])
