"""The corotational beam element, straight or an arc, without shear (Euler, Bernoulli) or with it (Timoshenko).

Nodes (x1, y1, theta1, x2, y2, theta2); the chord from node 1 to node 2 has length l and direction alpha, its axes are
e and n.  With s = xi L along the unstressed element and the shape functions N2, N4 (cubics of Hermite without shear):

Deformation      e = l - l0 + L/30 (b11 u1^2 - b12 u1 u2 + b22 u2^2),   uk = thetak + offset_k - alpha
Position         r = (1 - xi) x1 + xi x2 + w n,   w = N2 u1 + N4 u2;   a section turns by alpha + psi2 u1 + psi4 u2
Strain energy    V = 1/2 ka e^2 + 1/2 (u - u0) kb (u - u0)^T,   u = (u1, u2), u0 of the unstressed element
Kinetic energy   T = 1/2 int rho A |dr/dt|^2 + 1/2 int rho I (turning of the section)^2   (the latter on request)
Damping          zeta ka e_dot, zeta kb (u1_dot, u2_dot): stiffness-proportional, on the deformation only
Gravity          Vg = -g . int rho A r

ka, kb and the integrals of mass come from weak forms, see `fem`.  The bij are 2, 1, 2 without shear.  A straight
element has l0 = L and u0 = 0; for an arc see `arc`.  Inertia forces are int rho A dr/dq . d2r/dt2 (and so for the
rotation of sections) with nothing dropped, in the axes of the chord.
Source: M. A. Crisfield, Non-linear Finite Element Analysis of Solids and Structures, vol. 1, Wiley 1991, chapter 7
(corotational beam with averaged shallow-arch strain); the inertia terms are derived here from T.
Equations (2.1) to (2.5), (2.6) to (2.11), (2.16), (2.17) and (2.18) of docs/theory/beam.md.
Equations (3.1) to (3.7) of docs/theory/inertia.md.
"""

import math
from collections.abc import Sequence

from flexmb import checks, kernels
from flexmb.engine.compiled.lanes import any_of, choose, lanes_of, nearest, rows_of, total, write_lanes
from flexmb.model.contributions import ElementKernels

# Circular arcs between two points, as the unstressed shape of beams and of their elements

Point = tuple[float, float]


def checked_turn(label: str, name: str, value: object) -> float:
    """`value` as the turn of an arc [rad], or `InputError`."""
    turn = checks.number(label, name, value, "rad")
    if abs(turn) >= 2.0 * math.pi:
        text = f"{label}: {name} is {turn:g} rad; an arc between two points turns by less than 2 pi"
        checks.refuse(f"{text}. Divide it into several; angles are in rad.")
    return turn


def chord_share(turn: float) -> float:
    """Distance of the ends of an arc over its length: sin(turn/2)/(turn/2)."""
    return math.sin(0.5 * turn) / (0.5 * turn) if turn else 1.0


def tangents(start: Point, end: Point, turn: float, places: Sequence[float]) -> list[float]:
    """Directions of an arc at fractions of its length [rad]."""
    line = math.atan2(end[1] - start[1], end[0] - start[0])
    return [line + (s - 0.5) * turn for s in places] if turn else [line] * len(places)


def points(start: Point, end: Point, turn: float, places: Sequence[float]) -> list[Point]:
    """Points [m] of an arc between its ends, which turns by `turn` [rad], within 2 pi, at fractions of its length."""
    (x, y), (dx, dy) = start, (end[0] - start[0], end[1] - start[1])
    if not turn:
        return [(x + s * dx, y + s * dy) for s in places]
    found = []
    for s in places:
        share = math.sin(0.5 * s * turn) / math.sin(0.5 * turn)
        c, d = share * math.cos(0.5 * (s - 1.0) * turn), share * math.sin(0.5 * (s - 1.0) * turn)
        found.append((x + c * dx - d * dy, y + d * dx + c * dy))
    return found


# The chord of a beam element: its parameters, its deformation against the chord, and the rates of both

LENGTH, AXIAL, B11, B12, B22, OFFSET1, OFFSET2, ZETA, GRAVITY_X, GRAVITY_Y = range(10)
M11, M12, M22, G11, G12, G21, G22, H11, H12, H22, J, J1, J2, K11, K12, K22 = range(10, 26)
# Parameters p: L, ka, kb, offsets, zeta, g, integrals of mass, and the unstressed shape; PARAMETERS is their number.
# int rho A of products: M of (1 - xi, xi) with themselves, G of these with (N2, N4), H of (N2, N4) with themselves; int
# rho I of products: J of 1 with itself, J1 and J2 of 1 with (psi2, psi4), K of the latter with themselves. BOW: the
# shortening of the chord is L/30 (BOW11 u1^2 - BOW12 u1 u2 + BOW22 u2^2), with 2, 1, 2 without shear. FREE1, FREE2:
# rotations u1, u2 of the unstressed element; FREE_LENGTH: chord and shortening of the unstressed element.
BOW11, BOW12, BOW22, FREE_LENGTH, FREE1, FREE2, PARAMETERS = range(26, 33)
TURN, REST = 6.28125, 0.0019353071795864769  # 2 pi in two parts: the first times a number of turns below 2^40 is exact


@kernels.fast
def turned_back(theta, angle):
    """theta - angle in [-pi, pi]; subtracting whole turns first keeps the digits of a crank that turns often."""
    u = theta - angle
    if any_of(abs(u) > math.pi):
        turns = nearest(u / (TURN + REST))
        u = (theta - turns * TURN - angle) - turns * REST
    return u


# arctan r = r + r (A1 z + A2 z^2 + ...), z = r^2, for r up to FOLDED = tan(pi/8), within 1e-16 of it (Chebyshev points)
FOLDED = 0.41421356237309503
A1, A2, A3, A4 = -0.3333333333332844, 0.19999999998854384, -0.1428571418090295, 0.1111110617713739
A5, A6, A7 = -0.09090772993270721, 0.07689952309911112, -0.0664022342032706
A8, A9, A10 = 0.05688293562313399, -0.043478902221454854, 0.02113338077579371


@kernels.fast
def direction(y, x):
    """Angle of the vector (x, y) in [-pi, pi] within 5e-16, in half of the time of `math.atan2`."""
    aside, ahead = abs(y), abs(x)
    steep = aside > ahead
    low, high = choose(steep, ahead, aside), choose(steep, aside, ahead)
    folded = low > FOLDED * high  # arctan r = pi/4 + arctan((r - 1)/(r + 1))
    r = choose(folded, low - high, low) / choose(folded, low + high, high)
    z = r * r
    z2 = z * z
    first, second = (A1 + A2 * z) + (A3 + A4 * z) * z2, (A5 + A6 * z) + (A7 + A8 * z) * z2
    z4 = z2 * z2
    angle = r + r * (z * (first + second * z4 + (A9 + A10 * z) * (z4 * z4)))
    angle = choose(folded, angle + 0.25 * math.pi, angle)
    angle = choose(steep, 0.5 * math.pi - angle, angle)
    angle = choose(x < 0.0, math.pi - angle, angle)
    return choose(y < 0.0, -angle, angle)


@kernels.fast
def deformation(p, q):
    """Chord (1/l, cos, sin), elongation e and rotations u1, u2 against the chord."""
    dx, dy = q[3] - q[0], q[4] - q[1]
    l = math.sqrt(dx * dx + dy * dy)
    i, alpha = 1.0 / l, direction(dy, dx)
    u1, u2 = turned_back(q[2], alpha - p[OFFSET1]), turned_back(q[5], alpha - p[OFFSET2])
    e = l - p[FREE_LENGTH] + p[LENGTH] / 30.0 * (p[BOW11] * u1 * u1 - p[BOW12] * u1 * u2 + p[BOW22] * u2 * u2)
    return i, dx * i, dy * i, e, u1, u2


@kernels.fast
def to_chord(c, s, x):
    """The two translations of a nodal vector in the axes of the chord."""
    return c * x[0] + s * x[1], c * x[1] - s * x[0], c * x[3] + s * x[4], c * x[4] - s * x[3]


@kernels.fast
def rates(i, v, chord_v):
    """rho, the rate of the chord's length, and the rates of u1 and u2."""
    rho = (chord_v[3] - chord_v[1]) * i
    return rho, chord_v[2] - chord_v[0], v[2] - rho, v[5] - rho


@kernels.fast
def bowing(p, x1, x2):
    """Gradient (g1, g2) of e by u1 and u2, a linear function of (u1, u2)."""
    twice1, twice2 = 2.0 * p[BOW11], 2.0 * p[BOW22]
    return p[LENGTH] / 30.0 * (twice1 * x1 - p[BOW12] * x2), p[LENGTH] / 30.0 * (twice2 * x2 - p[BOW12] * x1)


@kernels.fast
def felt(p, c, s, chord_a):
    """Accelerations of the ends less gravity, in the axes of the chord; so inertia forces include the weight."""
    X, Y = p[GRAVITY_X], p[GRAVITY_Y]
    gx, gy = c * X + s * Y, c * Y - s * X
    return chord_a[0] - gx, chord_a[1] - gy, chord_a[2] - gx, chord_a[3] - gy


@kernels.fast
def with_ends(p, x1, x2):
    """int rho A of (1 - xi) w and xi w, for w = N2 x1 + N4 x2."""
    return p[G11] * x1 + p[G12] * x2, p[G21] * x1 + p[G22] * x2


@kernels.fast
def with_cubics(p, x1, x2):
    """int rho A of N2 w and N4 w, for w = N2 x1 + N4 x2."""
    return p[H11] * x1 + p[H12] * x2, p[H12] * x1 + p[H22] * x2


@kernels.fast
def inertia(p, u1, u2, x, rho, d1, d2):
    """Inertia forces on ends, u1, u2, alpha by end accelerations x, rho' = rho, u1'' = d1, u2'' = d2."""
    x0, x1, x3, x4 = x
    w1, w2 = with_ends(p, u1, u2)
    k1, k2 = with_cubics(p, u1, u2)
    b1, b2 = with_ends(p, d1, d2)
    c1, c2 = with_cubics(p, d1, d2)
    return (
        p[M11] * x0 + p[M12] * x3 - rho * w1,
        p[M11] * x1 + p[M12] * x4 + b1,
        p[M12] * x0 + p[M22] * x3 - rho * w2,
        p[M12] * x1 + p[M22] * x4 + b2,
        p[G11] * x1 + p[G21] * x4 + c1 + p[K11] * d1 + p[K12] * d2 + p[J1] * rho,
        p[G12] * x1 + p[G22] * x4 + c2 + p[K12] * d1 + p[K22] * d2 + p[J2] * rho,
        (u1 * k1 + u2 * k2 + p[J]) * rho - w1 * x0 - w2 * x3 + p[J1] * d1 + p[J2] * d2,
    )


@kernels.fast
def by_turning(p, u1, u2, rho, d1, d2):
    """Centrifugal and Coriolis forces of the spin rho of the chord, in the order of `inertia`."""
    w1, w2 = with_ends(p, u1, u2)
    k1, k2 = with_cubics(p, u1, u2)
    v1, v2 = with_ends(p, d1, d2)
    a, b = -2.0 * rho, -rho * rho
    return a * v1, b * w1, a * v2, b * w2, b * k1, b * k2, -a * (k1 * d1 + k2 * d2)


@kernels.fast
def elastic(p, e, u1, u2, longer, d1, d2):
    """Normal force and moments on u1 and u2, of elasticity and damping."""
    zeta = p[ZETA]
    g1, g2 = bowing(p, u1, u2)
    N = p[AXIAL] * (e + zeta * (longer + g1 * d1 + g2 * d2))
    x1, x2 = u1 - p[FREE1] + zeta * d1, u2 - p[FREE2] + zeta * d2
    return N, p[B11] * x1 + p[B12] * x2 + N * g1, p[B12] * x1 + p[B22] * x2 + N * g2


@kernels.fast
def spread(i, f):
    """Forces on ends, u1, u2 and alpha as a nodal vector in the axes of the chord."""
    lift = (f[6] - f[4] - f[5]) * i
    return f[0], f[1] - lift, f[4], f[2], f[3] + lift, f[5]


@kernels.fast
def turned(c, s, f):
    """B^T f, of a nodal vector f in the axes of the chord."""
    return c * f[0] - s * f[1], s * f[0] + c * f[1], f[2], c * f[3] - s * f[4], s * f[3] + c * f[4], f[5]


@kernels.fast
def write(f, r):
    """r = f."""
    r[0], r[1], r[2], r[3], r[4], r[5] = f


@kernels.fast
def forces(p, u, x, motion):
    """Nodal forces in the axes of the chord, the lift on its ends, and the normal force."""
    # u : result of `deformation`; x : `felt` accelerations of the ends; motion : rates of chord, u1, u2 and their
    # rates.
    i, _, _, e, u1, u2 = u
    rho, longer, d1, d2, rho_dot, dd1, dd2 = motion
    m, n = inertia(p, u1, u2, x, rho_dot, dd1, dd2), by_turning(p, u1, u2, rho, d1, d2)
    N, M1, M2 = elastic(p, e, u1, u2, longer, d1, d2)
    x0, x1, x3, x4 = m[0] + n[0] - N, m[1] + n[1], m[2] + n[2] + N, m[3] + n[3]
    M1, M2 = M1 + m[4] + n[4], M2 + m[5] + n[5]
    lift = (m[6] + n[6] - M1 - M2) * i
    return (x0, x1 - lift, M1, x3, x4 + lift, M2), lift, N


@kernels.fast
def state(p, q, v, a):
    """`deformation`, `felt` accelerations and all rates of an element."""
    u = deformation(p, q)
    i, c, s, _, _, _ = u
    rho, longer, d1, d2 = rates(i, v, to_chord(c, s, v))
    chord_a = to_chord(c, s, a)
    rho_dot = (chord_a[3] - chord_a[1]) * i - 2.0 * rho * longer * i
    dd1, dd2 = a[2] - rho_dot, a[5] - rho_dot
    return u, felt(p, c, s, chord_a), (rho, longer, d1, d2, rho_dot, dd1, dd2)


@kernels.fast
def along_turn(p, u, motion, r, r_dot):
    """Change of forces on ends, u1, u2 and alpha when rho grows by r and its rate by r_dot at constant theta."""
    _, _, _, _, u1, u2 = u
    rho, _, d1, d2, _, _, _ = motion
    w1, w2 = with_ends(p, u1, u2)
    v1, v2 = with_ends(p, d1, d2)
    k1, k2 = with_cubics(p, u1, u2)
    s1, s2 = p[G11] + p[G12], p[G21] + p[G22]
    twice = 2.0 * rho
    return (
        -w1 * r_dot - 2.0 * (v1 - rho * s1) * r,
        -s1 * r_dot - twice * w1 * r,
        -w2 * r_dot - 2.0 * (v2 - rho * s2) * r,
        -s2 * r_dot - twice * w2 * r,
        (p[J1] - p[H11] - p[H12] - p[K11] - p[K12]) * r_dot - (twice * k1 + p[ZETA] * (p[B11] + p[B12])) * r,
        (p[J2] - p[H12] - p[H22] - p[K12] - p[K22]) * r_dot - (twice * k2 + p[ZETA] * (p[B12] + p[B22])) * r,
        (u1 * k1 + u2 * k2 + p[J] - p[J1] - p[J2]) * r_dot + 2.0 * (k1 * d1 + k2 * d2 - rho * (k1 + k2)) * r,
    )


@kernels.fast
def with_normal(p, u, f, dN):
    """Forces f plus the forces of a normal force dN."""
    _, _, _, _, u1, u2 = u
    g1, g2 = bowing(p, u1, u2)
    return f[0] - dN, f[1], f[2] + dN, f[3], f[4] + g1 * dN, f[5] + g2 * dN, f[6]


@kernels.fast
def by_length(p, u, x, motion, lift, kq, kv):
    """Derivative of the nodal forces when the second end moves along the chord."""
    i, _, _, _, u1, u2 = u
    rho, longer, _, _, _, _, _ = motion
    stretch = longer * i
    g1, g2 = bowing(p, u1, u2)
    r = -kq * rho * i
    r_dot = -kq * (x[3] - x[1]) * i * i - 2.0 * (stretch * r + rho * i * (kv - kq * stretch))
    dN = p[AXIAL] * (kq + p[ZETA] * (kv - (g1 + g2) * r))
    f = spread(i, with_normal(p, u, along_turn(p, u, motion, r, r_dot), dN))
    back = kq * lift * i
    return f[0], f[1] + back, f[2], f[3], f[4] - back, f[5]


@kernels.fast
def by_side(p, u, x, motion, F, N, kq, kv, ka):
    """Derivative of the nodal forces F when the second end moves across the chord, which turns."""
    i, _, _, _, u1, u2 = u
    rho, longer, d1, d2, rho_dot, _, _ = motion
    x0, x1, x3, x4 = x
    turn, stretch = kq * i, longer * i
    g1, g2 = bowing(p, u1, u2)
    gd1, gd2 = bowing(p, d1, d2)
    w1, w2 = with_ends(p, u1, u2)
    k1, k2 = with_cubics(p, u1 + u1, u2 + u2)
    m1, m2 = with_cubics(p, d1 + d1, d2 + d2)
    s1, s2, both = p[G11] + p[G12], p[G21] + p[G22], rho * rho
    r = (kv - kq * stretch) * i
    r_dot = (ka - turn * (x3 - x0)) * i - 2.0 * (stretch * r + rho * rho * turn)
    dN = p[AXIAL] * (p[ZETA] * (kq * rho - (g1 + g2) * r - turn * (gd1 + gd2)) - turn * (g1 + g2))
    f = along_turn(p, u, motion, r, r_dot)
    # a turn of both ends: 1 without shear
    n = N * p[LENGTH] / 10.0
    n1, n2 = n * ((2.0 * p[BOW11] - p[BOW12]) / 3.0), n * ((2.0 * p[BOW22] - p[BOW12]) / 3.0)
    f = (
        f[0] + turn * (p[M11] * x1 + p[M12] * x4 + rho_dot * s1),
        f[1] - turn * (p[M11] * x0 + p[M12] * x3 - both * s1),
        f[2] + turn * (p[M12] * x1 + p[M22] * x4 + rho_dot * s2),
        f[3] - turn * (p[M12] * x0 + p[M22] * x3 - both * s2),
        f[4] - turn * (p[G11] * x0 + p[G21] * x3 - both * (p[H11] + p[H12]) + p[B11] + p[B12] + n1),
        f[5] - turn * (p[G12] * x0 + p[G22] * x3 - both * (p[H12] + p[H22]) + p[B12] + p[B22] + n2),
        f[6] - turn * (w1 * x1 + w2 * x4 - s1 * x0 - s2 * x3 + rho_dot * (k1 + k2) + rho * (m1 + m2)),
    )
    f = spread(i, with_normal(p, u, f, dN))
    return f[0] - turn * F[1], f[1] + turn * F[0], f[2], f[3] - turn * F[4], f[4] + turn * F[3], f[5]


@kernels.fast
def by_rotation(p, u, x, motion, N, k, kq, kv, ka):
    """Derivative of the nodal forces by the rotation of the first end (k = 0) or of the second (k = 1)."""
    i, _, _, _, u1, u2 = u
    rho, _, d1, d2, rho_dot, _, _ = motion
    ga, gb, ha, hb, ra, rb = p[G11 + k], p[G21 + k], p[H11 + k], p[H12 + k], p[K11 + k], p[K12 + k]
    a, b, both = -(rho_dot * kq + 2.0 * rho * kv), ka - kq * rho * rho, kq + p[ZETA] * kv
    n = kq * N * p[LENGTH] / 30.0
    dN = p[AXIAL] * (both * bowing(p, u1, u2)[k] + p[ZETA] * kq * bowing(p, d1, d2)[k])
    w, w_dot = with_cubics(p, u1, u2)[k], with_cubics(p, d1, d2)[k]
    on_alpha = 2.0 * (rho_dot * w + rho * w_dot) - ga * x[0] - gb * x[2]
    f = (
        ga * a, ga * b, gb * a, gb * b,
        ha * b + ra * ka + p[B11 + k] * both + (-p[BOW12] * n if k else 2.0 * p[BOW11] * n),
        hb * b + rb * ka + p[B12 + k] * both + (2.0 * p[BOW22] * n if k else -p[BOW12] * n),
        kq * on_alpha + 2.0 * kv * rho * w + ka * p[J1 + k],
    )  # fmt: skip
    return spread(i, with_normal(p, u, f, dN))


@kernels.fast
def add(k, x, y):
    """k x + y."""
    return k * x[0] + y[0], k * x[1] + y[1], k * x[2] + y[2], k * x[3] + y[3], k * x[4] + y[4], k * x[5] + y[5]


@kernels.fast
def turned_pair(c, s, x, y):
    """The two columns of B^T (x, y) B of a node."""
    zero = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return turned(c, s, add(c, x, add(-s, y, zero))), turned(c, s, add(s, x, add(c, y, zero)))


@kernels.fast
def residual(p, q, v, a):
    """Nodal forces."""
    u, x, motion = state(p, q, v, a)
    _, c, s, _, _, _ = u
    F, _, _ = forces(p, u, x, motion)
    return turned(c, s, F)


@kernels.fast
def evaluate(p, q, v, a, kq, kv, ka):
    """r and columns of A = kq dr/dq + kv dr/dv + ka dr/da; all but inertia forces have opposite ones for both ends."""
    u, x, motion = state(p, q, v, a)
    i, c, s, _, u1, u2 = u
    F, lift, N = forces(p, u, x, motion)
    X, Y = by_length(p, u, x, motion, lift, kq, kv), by_side(p, u, x, motion, F, N, kq, kv, ka)
    w1, w2 = with_ends(p, u1, u2)
    s1, s2 = (p[G11] + p[G12]) * i, (p[G21] + p[G22]) * i
    x0 = (ka * p[M11] - X[0], ka * w1 * i - X[1], -X[2], ka * p[M12] - X[3], -ka * w1 * i - X[4], -X[5])
    x3 = (ka * p[M12] + X[0], ka * w2 * i + X[1], X[2], ka * p[M22] + X[3], -ka * w2 * i + X[4], X[5])
    x1 = add(ka, (0.0, p[M11] + s1, p[G11], 0.0, p[M12] - s1, p[G12]), add(-1.0, Y, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)))
    x4 = add(ka, (0.0, p[M12] + s2, p[G21], 0.0, p[M22] - s2, p[G22]), Y)
    A0, A1 = turned_pair(c, s, x0, x1)
    A2 = turned(c, s, by_rotation(p, u, x, motion, N, 0, kq, kv, ka))
    A3, A4 = turned_pair(c, s, x3, x4)
    A5 = turned(c, s, by_rotation(p, u, x, motion, N, 1, kq, kv, ka))
    return turned(c, s, F), (A0, A1, A2, A3, A4, A5)


@kernels.fast
def write_matrix(columns, A):
    """The columns of A (6, 6)."""
    for j, column in enumerate(columns):
        A[0, j], A[1, j], A[2, j], A[3, j], A[4, j], A[5, j] = column


@kernels.element_kernel
def beam_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Corotational Euler-Bernoulli element; q, r (6,), K, C, M (6, 6)."""
    for X, kq, kv, ka in ((K, 1.0, 0.0, 0.0), (C, 0.0, 1.0, 0.0), (M, 0.0, 0.0, 1.0)):
        F, columns = evaluate(p, q, v, a, kq, kv, ka)
        write(F, r)
        write_matrix(columns, X)


@kernels.tangent_kernel
def beam_tangent(p, t, h, q, v, a, z, kq, kv, ka, r, A, z_new):
    """r (6,) and kq K + kv C + ka M (6, 6)."""
    F, columns = evaluate(p, q, v, a, kq, kv, ka)
    write(F, r)
    write_matrix(columns, A)


@kernels.force_kernel
def beam_force(p, t, h, q, v, a, z, r, z_new):
    """Residual r (6,) alone."""
    write(residual(p, q, v, a), r)


@kernels.fast
def energies(p, q, u, longer, d1, d2):
    """Strain energy, potential of gravity, power dissipated by damping."""
    _, c, s, e, u1, u2 = u
    gx, gy = p[GRAVITY_X], p[GRAVITY_Y]
    g1, g2 = bowing(p, u1, u2)
    e_dot = longer + g1 * d1 + g2 * d2
    ka, kb11, kb12, kb22 = p[AXIAL], p[B11], p[B12], p[B22]
    x1, x2 = u1 - p[FREE1], u2 - p[FREE2]
    strain = 0.5 * (ka * e * e + kb11 * x1 * x1 + 2.0 * kb12 * x1 * x2 + kb22 * x2 * x2)
    power = p[ZETA] * (ka * e_dot * e_dot + kb11 * d1 * d1 + 2.0 * kb12 * d1 * d2 + kb22 * d2 * d2)
    height = (p[M11] + p[M12]) * (gx * q[0] + gy * q[1]) + (p[M12] + p[M22]) * (gx * q[3] + gy * q[4])
    aside = (p[G11] + p[G21]) * u1 + (p[G12] + p[G22]) * u2
    return strain, -height - (c * gy - s * gx) * aside, power


@kernels.fast
def mass_times(p, u, x):
    """M x."""
    i, c, s, _, u1, u2 = u
    y = to_chord(c, s, x)
    turn = (y[3] - y[1]) * i
    return turned(c, s, spread(i, inertia(p, u1, u2, y, turn, x[2] - turn, x[5] - turn)))


@kernels.energy_kernel
def beam_energy(p, t, q, v):
    """Strain energy, potential of gravity, power dissipated by damping."""
    u = deformation(p, q)
    i, c, s, _, _, _ = u
    _, longer, d1, d2 = rates(i, v, to_chord(c, s, v))
    return energies(p, q, u, longer, d1, d2)


@kernels.fast
def damping(p, q, v, w):
    """v.D v and v.D w."""
    i, c, s, _, u1, u2 = deformation(p, q)
    g1, g2 = bowing(p, u1, u2)
    _, longer, d1, d2 = rates(i, v, to_chord(c, s, v))
    _, more, w1, w2 = rates(i, w, to_chord(c, s, w))
    N = p[AXIAL] * (longer + g1 * d1 + g2 * d2)
    m1, m2 = p[B11] * d1 + p[B12] * d2 + N * g1, p[B12] * d1 + p[B22] * d2 + N * g2
    return p[ZETA] * (N * longer + m1 * d1 + m2 * d2), p[ZETA] * (N * more + m1 * w1 + m2 * w2)


@kernels.damping_kernel
def beam_damping(p, t, q, v, w):
    """Powers of damping with the velocities v, and of v and w."""
    return damping(p, q, v, w)


@kernels.fast
def account(p, q, v, a, y):
    """Nodal forces, M v, M y, and energies as `beam_energy` gives them."""
    u, x, motion = state(p, q, v, a)
    _, c, s, _, _, _ = u
    _, longer, d1, d2, _, _, _ = motion
    F, _, _ = forces(p, u, x, motion)
    return turned(c, s, F), mass_times(p, u, v), mass_times(p, u, y), energies(p, q, u, longer, d1, d2)


@kernels.account_kernel
def beam_account(p, t, h, q, v, a, y, z, r, Mv, My, z_new):
    """r, M v, M y (6,); energies as `beam_energy` gives them."""
    F, along, across, stored = account(p, q, v, a, y)
    write(F, r)
    write(along, Mv)
    write(across, My)
    return stored


# The same for four elements at a time; entries of vectors and matrices stand side by side

rows, entries = rows_of(PARAMETERS), lanes_of(6)


@kernels.force_kernel
def four_forces(p, t, h, q, v, a, z, r, z_new):
    """Residuals."""
    write_lanes(r, 0, residual(rows(p), entries(q), entries(v), entries(a)))


@kernels.tangent_kernel
def four_tangents(p, t, h, q, v, a, z, kq, kv, ka, r, A, z_new):
    """Residuals, and matrices column by column in A (36, 4)."""
    F, columns = evaluate(rows(p), entries(q), entries(v), entries(a), kq, kv, ka)
    write_lanes(r, 0, F)
    for k, column in enumerate(columns):
        write_lanes(A, 6 * k, column)


@kernels.account_kernel
def four_accounts(p, t, h, q, v, a, y, z, r, Mv, My, z_new):
    """r, M v, M y of each; sums of the energies."""
    F, along, across, (strain, gravity, power) = account(rows(p), entries(q), entries(v), entries(a), entries(y))
    write_lanes(r, 0, F)
    write_lanes(Mv, 0, along)
    write_lanes(My, 0, across)
    return total(strain), total(gravity), total(power)


@kernels.damping_kernel
def four_dampings(p, t, q, v, w):
    """Sums of the powers of damping."""
    own, mixed = damping(rows(p), entries(q), entries(v), entries(w))
    return total(own), total(mixed)


FOURS = four_forces, four_tangents, four_accounts, four_dampings
BEAM = ElementKernels(beam_kernel, beam_energy, beam_force, beam_tangent, beam_account, beam_damping, FOURS)
