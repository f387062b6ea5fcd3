"""Rigid nine-bar mechanism with play at P1 in two minimal coordinates: equations, contact and steps of their own.

Nothing of flexmb is used here but the numbers of the mechanism, which a test hands over.

Coordinates: q = (a, b), the directions of link 3 (from P4 to B) and of link 2 (from the journal to B).  Cranks turn by
given angles.  With J turning by a right angle and e(x) = (cos x, sin x):

    B = P4 + L3 e(a)                                    journal = B - L2 e(b)
    A : |A - O6| = L6, |A - B| = AB, in one branch      G, C : fixed to the line A-B
    S = C + L8 e(c), S_y given                          bearing = O1 + L1 e(theta1)

Equations of motion by virtual work: sum over bodies of the velocity coefficients times (inertia force - weight) equals
the virtual work of the contact.  Velocity coefficients and accelerations follow from differentiating the closures.

Contact, with eta = journal - bearing, depth d = |eta| - clearance, n = eta/|eta|, t = J n, d > 0:

    N = max(0, K d^1.5 (1 + chi d'/w)),   T = -cf ramp(slip; v0, v1) N

w is the reference speed: with RULE = PRINTED the closing speed at the onset of the contact, at least `least`; with
LARGEST the largest since the onset of closing speed and opening speed/e, e being the restitution of a free impact.
The friction acts at R1 + d/2 from the centre of the bearing.

Steps: classical Runge-Kutta of fixed size, split where a contact begins (root of d by Newton on the step's length).
"""

import math
from typing import NamedTuple

import numba
import numpy as np
from restitution import delivered

PRINTED, LARGEST = 0, 1
"""Rules for the reference speed of the normal law."""


class Model(NamedTuple):
    """Numbers of the mechanism: lengths, places, masses, contact [SI]."""

    L1: float
    L2: float
    L3: float
    L4: float
    L6: float
    L8: float
    AB: float
    Cx: float  # C and the panel's centre of mass in axes along A-B
    Cy: float
    Gx: float
    Gy: float
    O4y: float
    O6x: float
    O6y: float
    line: float
    m2: float
    m3: float
    m6: float
    m7: float
    m8: float
    m9: float
    J2: float
    J3: float
    J6: float  # about the axis in the frame
    J7: float
    J8: float
    gravity: float
    clearance: float
    R1: float
    K: float
    chi: float
    e: float
    cf: float
    v0: float
    v1: float
    least: float
    rule: int
    speed: float
    ramp: float  # time of the start from rest; 0: at full speed from the start


def model_of(data, speed, clearance, *, rule=LARGEST, least=0.0, ramp=0.0):
    """The model with the numbers of a record that has the fields of NineBarData."""
    AB, AC, BC = data.side_ab, data.side_ac, data.side_bc
    Cx = (AB**2 + AC**2 - BC**2) / (2.0 * AB)
    Cy = -math.sqrt(AC**2 - Cx**2)
    towards = ((AB + Cx) / 3.0, Cy / 3.0)  # the centroid, seen from A
    share = data.centre7 / math.hypot(*towards)
    R1, R2 = data.bearing_radius, data.bearing_radius - clearance
    compliance = (1.0 - data.contact_poisson**2) / data.contact_young
    K = 4.0 / (3.0 * 2.0 * compliance) * math.sqrt(R1 * R2 / (R1 - R2))
    chi = 0.75 * (1.0 - data.restitution**2)
    return Model(
        data.length1, data.length2, data.length3, data.length4, data.length6, data.length8,
        AB, Cx, Cy, share * towards[0], share * towards[1],
        data.pivot4[1], data.pivot6[0], data.pivot6[1], data.slider_line,
        data.mass2, data.mass3, data.mass6, data.mass7, data.mass8, data.mass9,
        data.inertia2, data.inertia3, data.inertia6, data.inertia7, data.inertia8,
        data.gravity, clearance, R1, K, chi, delivered(chi),
        data.friction_coefficient, data.v0, data.v1, least, rule, speed, ramp,
    )  # fmt: skip


@numba.njit(cache=True)
def crank_angle(p, t):
    """Angle, rate and acceleration of the crank that turns forwards; the rate rises as 10 x^3 - 15 x^4 + 6 x^5."""
    w, T = p.speed, p.ramp
    if T <= 0.0:
        return w * t, w, 0.0
    if t >= T:
        return w * (t - 0.5 * T), w, 0.0
    x = t / T
    rate = w * x * x * x * (10.0 - 15.0 * x + 6.0 * x * x)
    return w * T * x**4 * (2.5 - 3.0 * x + x * x), rate, w / T * 30.0 * x * x * (1.0 - x) ** 2


@numba.njit(cache=True)
def closures(p, t, q):
    """Points P4, B, A, C, S, G and bearing, six numbers each of which pairs are (x, y)."""
    angle, _, _ = crank_angle(p, t)
    x4, y4 = p.L4 * math.cos(angle), p.O4y + p.L4 * math.sin(angle)
    bx, by = x4 + p.L3 * math.cos(q[0]), y4 + p.L3 * math.sin(q[0])
    dx, dy = bx - p.O6x, by - p.O6y
    size = math.sqrt(dx * dx + dy * dy)
    along = (size * size + p.L6 * p.L6 - p.AB * p.AB) / (2.0 * size)
    aside = math.sqrt(p.L6 * p.L6 - along * along)
    ax = p.O6x + (along * dx - aside * dy) / size
    ay = p.O6y + (along * dy + aside * dx) / size
    ux, uy = (bx - ax) / p.AB, (by - ay) / p.AB
    cx, cy = ax + p.Cx * ux - p.Cy * uy, ay + p.Cx * uy + p.Cy * ux
    gx, gy = ax + p.Gx * ux - p.Gy * uy, ay + p.Gx * uy + p.Gy * ux
    sx = cx - math.sqrt(p.L8 * p.L8 - (p.line - cy) ** 2)
    return x4, y4, bx, by, ax, ay, cx, cy, sx, gx, gy


@numba.njit(cache=True)
def loop_rates(p, points, vx, vy):
    """Rates of rocker 6, panel 7 and link 8 for right sides (vx, vy) of the loop of B and then of C's Y."""
    _, _, bx, by, ax, ay, _, _, _, _, _ = points
    ux, uy, wx, wy = ax - p.O6x, ay - p.O6y, bx - ax, by - ay
    # r6 J u + r7 J w = (vx, vy)
    det = -uy * wx + wy * ux
    return (vx * wx + vy * wy) / det, -(vx * ux + vy * uy) / det


@numba.njit(cache=True)
def motion(p, t, q, v, w):
    """Accelerations a'', b'' and S_x''; depth, its rate and the normal force; w: reference speed (0: open)."""
    angle, rate, accel = crank_angle(p, t)
    points = closures(p, t, q)
    x4, y4, bx, by, ax, ay, cx, cy, sx, gx, gy = points
    # velocity coefficients of a: those of b move link 2 alone
    Bx, By = -(by - y4), bx - x4
    k6, k7 = loop_rates(p, points, Bx, By)
    Ax, Ay = -k6 * (ay - p.O6y), k6 * (ax - p.O6x)
    Cx, Cy = Ax - k7 * (cy - ay), Ay + k7 * (cx - ax)
    Gx, Gy = Ax - k7 * (gy - ay), Ay + k7 * (gx - ax)
    ex8, ey8 = sx - cx, p.line - cy
    k8 = -Cy / ex8
    Sx = Cx - k8 * ey8
    # velocities and accelerations for a'' = b'' = 0
    c4x, c4y = x4, y4 - p.O4y
    v4x, v4y = -rate * c4y, rate * c4x
    a4x, a4y = -accel * c4y - rate * rate * c4x, accel * c4x - rate * rate * c4y
    vBx, vBy = v4x + v[0] * Bx, v4y + v[0] * By
    aBx, aBy = a4x - v[0] * v[0] * (bx - x4), a4y - v[0] * v[0] * (by - y4)
    r6, r7 = loop_rates(p, points, vBx, vBy)
    vCy = r6 * (ax - p.O6x) + r7 * (cx - ax)
    r8 = -vCy / ex8
    ux, uy, wx, wy = ax - p.O6x, ay - p.O6y, bx - ax, by - ay
    s6, s7 = loop_rates(p, points, aBx + r6 * r6 * ux + r7 * r7 * wx, aBy + r6 * r6 * uy + r7 * r7 * wy)
    aAx, aAy = -s6 * uy - r6 * r6 * ux, s6 * ux - r6 * r6 * uy
    aCx = aAx - s7 * (cy - ay) - r7 * r7 * (cx - ax)
    aCy = aAy + s7 * (cx - ax) - r7 * r7 * (cy - ay)
    aGx = aAx - s7 * (gy - ay) - r7 * r7 * (gx - ax)
    aGy = aAy + s7 * (gx - ax) - r7 * r7 * (gy - ay)
    s8 = (-aCy + r8 * r8 * ey8) / ex8
    aSx = aCx - s8 * ey8 - r8 * r8 * ex8
    # link 2
    e2x, e2y = math.cos(q[1]), math.sin(q[1])
    h2x, h2y = 0.5 * p.L2 * e2y, -0.5 * p.L2 * e2x  # d(centre 2)/db
    a2x, a2y = aBx + 0.5 * p.L2 * v[1] * v[1] * e2x, aBy + 0.5 * p.L2 * v[1] * v[1] * e2y
    g = p.gravity
    m11 = p.J3 + p.J6 * k6 * k6 + p.J7 * k7 * k7 + p.J8 * k8 * k8
    m11 += (0.25 * p.m3 + p.m2) * (Bx * Bx + By * By) + p.m7 * (Gx * Gx + Gy * Gy) + p.m9 * Sx * Sx
    m11 += 0.25 * p.m8 * ((Cx + Sx) ** 2 + Cy * Cy)
    m12 = p.m2 * (Bx * h2x + By * h2y)
    m22 = p.J2 + 0.25 * p.m2 * p.L2 * p.L2
    f1 = -p.J6 * k6 * s6 - p.J7 * k7 * s7 - p.J8 * k8 * s8
    f1 -= 0.25 * p.m3 * (Bx * (a4x + aBx - 2.0 * g) + By * (a4y + aBy)) + p.m2 * (Bx * (a2x - g) + By * a2y)
    f1 += 0.5 * p.m6 * g * Ax
    f1 -= p.m7 * (Gx * (aGx - g) + Gy * aGy) + p.m9 * Sx * (aSx - g)
    f1 -= 0.25 * p.m8 * ((Cx + Sx) * (aCx + aSx - 2.0 * g) + Cy * aCy)
    f2 = -p.m2 * (h2x * (a2x - g) + h2y * a2y)
    # contact
    o1x, o1y = p.L1 * math.cos(angle), -p.L1 * math.sin(angle)  # crank 1 turns backwards
    jx, jy = bx - p.L2 * e2x, by - p.L2 * e2y
    etax, etay = jx - o1x, jy - o1y
    vex = vBx + p.L2 * v[1] * e2y - rate * o1y
    vey = vBy - p.L2 * v[1] * e2x + rate * o1x
    size = math.sqrt(etax * etax + etay * etay)
    depth, closing, N = size - p.clearance, 0.0, 0.0
    if size > 0.0:
        nx, ny = etax / size, etay / size
        closing = nx * vex + ny * vey
        if w > 0.0 and depth > 0.0:
            if p.rule == LARGEST:
                w = max(w, closing, -closing / p.e)
            N = max(0.0, p.K * depth * math.sqrt(depth) * (1.0 + p.chi * closing / w))
            arm = p.R1 + 0.5 * depth
            slip = -ny * vex + nx * vey + v[1] * (arm - size) + rate * arm
            held = min(max((abs(slip) - p.v0) / (p.v1 - p.v0), 0.0), 1.0)
            T = -p.cf * held * N * (1.0 if slip > 0.0 else -1.0)
            fx, fy = -N * nx - T * ny, -N * ny + T * nx
            f1 += fx * Bx + fy * By
            f2 += 2.0 * (fx * h2x + fy * h2y) + T * (arm - size)
    det = m11 * m22 - m12 * m12
    qa, qb = (m22 * f1 - m12 * f2) / det, (m11 * f2 - m12 * f1) / det
    return qa, qb, aSx + Sx * qa, depth, closing, N


@numba.njit(cache=True)
def runge_kutta(p, t, h, y, w, out):
    """One classical step from y = (a, b, a', b') with reference speed w, into `out`."""
    k = np.zeros((4, 4))
    z = y.copy()
    for i in range(4):
        share = 0.0 if i == 0 else (1.0 if i == 3 else 0.5)
        if i > 0:
            for j in range(4):
                z[j] = y[j] + share * h * k[i - 1, j]
        qa, qb, _, _, _, _ = motion(p, t + share * h, z[:2], z[2:], w)
        k[i, 0], k[i, 1], k[i, 2], k[i, 3] = z[2], z[3], qa, qb
    for j in range(4):
        out[j] = y[j] + h / 6.0 * (k[0, j] + 2.0 * k[1, j] + 2.0 * k[2, j] + k[3, j])


@numba.njit(cache=True)
def onset_in(p, t, h, y, out):
    """Length of the step that ends where the gap closes, by Newton guarded by bisection; `out` is the state there."""
    low, high, s = 0.0, h, 0.5 * h
    for _ in range(60):
        runge_kutta(p, t, s, y, 0.0, out)
        _, _, _, depth, closing, _ = motion(p, t + s, out[:2], out[2:], 0.0)
        if depth > 0.0:
            high = s
        else:
            low = s
        if abs(depth) < 1e-17 or high - low < 1e-16:
            break
        new = s - depth / closing if closing > 0.0 else 0.5 * (low + high)
        s = new if low < new < high else 0.5 * (low + high)
    return s


@numba.njit(cache=True)
def step(p, t, h, y, w):
    """One step of length h, split where a contact begins; changes y, returns the reference speed and onsets."""
    out, onsets = np.empty(4), 0
    left = h
    while left > 0.0:
        runge_kutta(p, t, left, y, w, out)
        _, _, _, depth, closing, _ = motion(p, t + left, out[:2], out[2:], w)
        if w == 0.0 and depth > 0.0:
            part = onset_in(p, t, left, y, out)
            _, _, _, _, closing, _ = motion(p, t + part, out[:2], out[2:], 0.0)
            y[:] = out
            w, onsets = max(closing, p.least, 1e-12), onsets + 1
            t, left = t + part, left - part
            if left < 1e-13:
                left = 0.0
            continue
        y[:] = out
        if w > 0.0:
            if depth <= 0.0:
                w = 0.0
            elif p.rule == LARGEST:
                w = max(w, closing, -closing / p.e)
        left = 0.0
    return w, onsets


@numba.njit(cache=True)
def follow(p, t, h, count, y, w):
    """Steps of length h; changes y, returns the reference speed."""
    for i in range(count):
        w, _ = step(p, t + i * h, h, y, w)
    return w


@numba.njit(cache=True)
def turns(p, y, w, h, first, count, result):
    """Turns from turn `first` on; rows of `result`: peak force, peak |S_x''|, flight share, onsets, depth, w."""
    turn = 2.0 * math.pi / p.speed
    steps = round(turn / h)
    h = turn / steps
    for k in range(count):
        force, accel, open_, onsets, deepest, largest = 0.0, 0.0, 0, 0, 0.0, 0.0
        for i in range(steps):
            t = (first + k) * turn + i * h
            w, found = step(p, t, h, y, w)
            onsets += found
            _, _, a, depth, closing, N = motion(p, t + h, y[:2], y[2:], w)
            force, accel, deepest = max(force, N), max(accel, abs(a)), max(deepest, depth)
            largest = max(largest, w)
            open_ += depth <= 0.0
        result[k, 0], result[k, 1], result[k, 2] = force, accel, open_ / steps
        result[k, 3], result[k, 4], result[k, 5] = onsets, deepest, largest
    return w


@numba.njit(cache=True)
def growth(p, y, w, h, first, count, looks, distance, logs):
    """Logarithms of the growth of the distance to a neighbour, one a turn; lengths and times weigh alike."""
    turn = 2.0 * math.pi / p.speed
    steps = round(turn / (h * looks)) * looks
    h = turn / steps
    other, w2 = y.copy(), w
    other[0] += distance
    size = distance
    for k in range(count):
        logs[k] = 0.0
        for i in range(steps):
            t = (first + k) * turn + i * h
            w, _ = step(p, t, h, y, w)
            w2, _ = step(p, t, h, other, w2)
            if (i + 1) % (steps // looks) == 0:
                d = other - y
                weigh = turn / (2.0 * math.pi)
                length = math.sqrt(d[0] ** 2 + d[1] ** 2 + (weigh * d[2]) ** 2 + (weigh * d[3]) ** 2)
                logs[k] += math.log(length / size)
                other[:] = y + distance / length * d
                if w > 0.0 and w2 > 0.0:
                    w2 = max(w + distance / length * (w2 - w), 1e-12)
                size = distance
    return w
