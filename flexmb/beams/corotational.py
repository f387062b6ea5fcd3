"""The corotational Euler-Bernoulli element: kernel and energies.

Nodes (x1, y1, theta1, x2, y2, theta2); the chord from node 1 to node 2 has length l and direction alpha, its axes are
e and n.  With s = xi L along the unstressed element and the Hermite cubics N2, N4:

Deformation      e = l - L + L/30 (2 u1^2 - u1 u2 + 2 u2^2),   uk = thetak + offset_k - alpha
Position         r = (1 - xi) x1 + xi x2 + w n,   w = N2 u1 + N4 u2;   a section turns by alpha + dw/ds
Strain energy    V = 1/2 ka e^2 + 1/2 (u1, u2) kb (u1, u2)^T
Kinetic energy   T = 1/2 int rho A |dr/dt|^2 + 1/2 int rho I (d(alpha + dw/ds)/dt)^2   (the latter on request)
Damping          zeta ka e_dot, zeta kb (u1_dot, u2_dot): stiffness-proportional, on the deformation only
Gravity          Vg = -g . int rho A r

ka, kb and the integrals of mass come from weak forms (see `fem`).  The term with L/30 is the shortening of the chord by
bending, averaged over the element; it removes membrane locking.

Inertia forces are int rho A dr/dq . d2r/dt2 (and so for the rotation of sections) with nothing dropped.  In the axes of
the chord, with U, A nodal velocities and accelerations, rho = d(alpha)/dt, rho' its rate and dk = d(uk)/dt:

    along e:  (1 - xi) A0 + xi A3 - rho' w - 2 rho (N2 d1 + N4 d2)
    along n:  (1 - xi) A1 + xi A4 + N2 d1' + N4 d2' - rho^2 w
    variation of r: along e (1 - xi) dx0 + xi dx3 - w dalpha,  along n (1 - xi) dx1 + xi dx4 + N2 du1 + N4 du2

so that r holds every rigid motion, and the sums of forces and moments are the rates of the momenta of r.
Source: M. A. Crisfield, Non-linear Finite Element Analysis of Solids and Structures, vol. 1, Wiley 1991, chapter 7
(corotational beam with averaged shallow-arch strain); the inertia terms are derived here from T.
"""

import math

from flexmb.kernels import compiled, element_kernel, energy_kernel

PARAMETERS = (
    "L ka kb11 kb12 kb22 offset1 offset2 zeta gx gy m11 m12 m22 g11 g12 g21 g22 h11 h12 h22 J j1 j2 k11 k12 k22"
).split()
"""What p holds, in this order.

int rho A of products: m of (1 - xi, xi) with themselves, g of these with (N2, N4), h of (N2, N4) with themselves;
int rho I of products: J of 1 with itself, j of 1 with (dN2/ds, dN4/ds), k of the latter with themselves.
"""


@compiled
def deformation(p, q):
    """Chord (l, cos, sin), elongation e and rotations u1, u2 against the chord."""
    dx, dy = q[3] - q[0], q[4] - q[1]
    l = math.sqrt(dx * dx + dy * dy)
    c, s = dx / l, dy / l
    u1 = _rotation(q[2] + p[5], c, s)
    u2 = _rotation(q[5] + p[6], c, s)
    e = l - p[0] + p[0] / 30.0 * (2.0 * u1 * u1 - u1 * u2 + 2.0 * u2 * u2)
    return l, c, s, e, u1, u2


@compiled
def _rotation(theta, c, s):
    """theta - alpha in (-pi, pi]; by sine and cosine, so that a crank may turn for ever."""
    ct, st = math.cos(theta), math.sin(theta)
    return math.atan2(st * c - ct * s, ct * c + st * s)


@compiled
def to_chord(c, s, x):
    """B x: a nodal vector in the axes of the chord."""
    return (c * x[0] + s * x[1], c * x[1] - s * x[0], x[2], c * x[3] + s * x[4], c * x[4] - s * x[3], x[5])


@compiled
def turned(x):
    """D x, with D = dB/dalpha B^T."""
    return (x[1], -x[0], 0.0, x[4], -x[3], 0.0)


@compiled
def dot(x, y):
    """Scalar product of two nodal vectors."""
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2] + x[3] * y[3] + x[4] * y[4] + x[5] * y[5]


@compiled
def combined(k, x, y):
    """k x + y."""
    return (k * x[0] + y[0], k * x[1] + y[1], k * x[2] + y[2], k * x[3] + y[3], k * x[4] + y[4], k * x[5] + y[5])


@compiled
def add_curvature_of_chord(k, l, K):
    """K += k d2(alpha)/dq2, columns 0, 1, 2 and 5."""
    h = k / (l * l)
    K[0, 1] -= h
    K[1, 0] -= h
    K[3, 1] += h
    K[4, 0] += h


@compiled
def rotate_rows_back(c, s, X):
    """X = B^T X."""
    for k in (0, 3):
        for j in range(6):
            x, y = X[k, j], X[k + 1, j]
            X[k, j] = c * x - s * y
            X[k + 1, j] = s * x + c * y


@compiled
def rotate_back(c, s, X):
    """X = B^T X B."""
    rotate_rows_back(c, s, X)
    for i in range(6):
        for k in (0, 3):
            x, y = X[i, k], X[i, k + 1]
            X[i, k] = c * x - s * y
            X[i, k + 1] = s * x + c * y


@compiled
def rotate_back_and_fill(c, s, X):
    """X = B^T X B; columns 3 and 4 follow from 0 and 1, since no force depends on where the element is."""
    rotate_rows_back(c, s, X)
    for i in range(6):
        x, y = X[i, 0], X[i, 1]
        X[i, 0] = c * x - s * y
        X[i, 1] = s * x + c * y
        X[i, 3], X[i, 4] = -X[i, 0], -X[i, 1]


@compiled
def spread(i, x0, x1, x2, x3, x4, x5, k):
    """(x0 .. x5) on the axes, x2 and x5 being forces on u1 and u2, plus k d(alpha)/dq; i = 1/l."""
    moment = (k - x2 - x5) * i
    return (x0, x1 - moment, x2, x3, x4 + moment, x5)


@compiled
def rates(l, u, acc):
    """rho, its rate, the rate of stretching of the chord and the rates of u1 and u2 with their own."""
    rho, stretch = (u[4] - u[1]) / l, (u[3] - u[0]) / l
    rho_dot = (acc[4] - acc[1]) / l - 2.0 * rho * stretch
    return rho, rho_dot, stretch, u[2] - rho, u[5] - rho, acc[2] - rho_dot, acc[5] - rho_dot


@compiled
def inertia_by_acceleration(p, i, u1, u2):
    """Inertia force of a unit of A0, A1, d1', A3, A4, d2' and rho' in turn."""
    m11, m12, m22, g11, g12, g21, g22, h11, h12, h22, J, j1, j2, k11, k12, k22 = p[10:26]
    w1, w2 = g11 * u1 + g12 * u2, g21 * u1 + g22 * u2
    Q = h11 * u1 * u1 + 2.0 * h12 * u1 * u2 + h22 * u2 * u2
    return (
        spread(i, m11, 0.0, 0.0, m12, 0.0, 0.0, -w1),
        spread(i, 0.0, m11, g11, 0.0, m12, g12, 0.0),
        spread(i, 0.0, g11, h11 + k11, 0.0, g21, h12 + k12, j1),
        spread(i, m12, 0.0, 0.0, m22, 0.0, 0.0, -w2),
        spread(i, 0.0, m12, g21, 0.0, m22, g22, 0.0),
        spread(i, 0.0, g12, h12 + k12, 0.0, g22, h22 + k22, j2),
        spread(i, -w1, 0.0, j1, -w2, 0.0, j2, Q + J),
    )


@compiled
def inertia_by_rate(p, i, u1, u2, rho, d1, d2):
    """Inertia force of rho with d1 and d2 alone, its derivatives by rho, d1 and d2, and int rho A w dw/dt."""
    g11, g12, g21, g22, h11, h12, h22 = p[13:20]
    w1, w2, v1, v2 = g11 * u1 + g12 * u2, g21 * u1 + g22 * u2, g11 * d1 + g12 * d2, g21 * d1 + g22 * d2
    k1, k2 = h11 * u1 + h12 * u2, h12 * u1 + h22 * u2
    R, a, b = k1 * d1 + k2 * d2, -2.0 * rho, -rho * rho
    force = spread(i, a * v1, b * w1, b * k1, a * v2, b * w2, b * k2, -a * R)
    by_rho = spread(i, -2.0 * v1, a * w1, a * k1, -2.0 * v2, a * w2, a * k2, 2.0 * R)
    by_d1 = spread(i, a * g11, 0.0, 0.0, a * g21, 0.0, 0.0, -a * k1)
    by_d2 = spread(i, a * g12, 0.0, 0.0, a * g22, 0.0, 0.0, -a * k2)
    return force, by_rho, by_d1, by_d2, R


@compiled
def inertia_by_bending(p, i, u1, u2, rho, rho_dot, d1, d2, acc):
    """Derivatives of the inertia force by u1 and u2."""
    g11, g12, g21, g22, h11, h12, h22 = p[13:20]
    k1, k2, m1, m2 = h11 * u1 + h12 * u2, h12 * u1 + h22 * u2, h11 * d1 + h12 * d2, h12 * d1 + h22 * d2
    a, b = -rho_dot, -rho * rho
    t1 = 2.0 * (rho_dot * k1 + rho * m1) - g11 * acc[0] - g21 * acc[3]
    t2 = 2.0 * (rho_dot * k2 + rho * m2) - g12 * acc[0] - g22 * acc[3]
    return (
        spread(i, a * g11, b * g11, b * h11, a * g21, b * g21, b * h12, t1),
        spread(i, a * g12, b * g12, b * h12, a * g22, b * g22, b * h22, t2),
    )


@compiled
def inertia(p, l, u1, u2, u, acc, K, C, M):
    """Inertia force in the axes of the chord; M, and columns 0, 1, 2 and 5 added to K and C."""
    i = 1.0 / l
    rho, rho_dot, stretch, d1, d2, dd1, dd2 = rates(l, u, acc)
    c0, c1, n1, c3, c4, n2, cr = inertia_by_acceleration(p, i, u1, u2)
    f, by_rho, by_d1, by_d2, R = inertia_by_rate(p, i, u1, u2, rho, d1, d2)
    by_u1, by_u2 = inertia_by_bending(p, i, u1, u2, rho, rho_dot, d1, d2, acc)
    turn = 2.0 * rho * R + p[20] * rho_dot + p[21] * dd1 + p[22] * dd2  # what acts on alpha alone
    turn += (p[17] * u1 * u1 + 2.0 * p[18] * u1 * u2 + p[19] * u2 * u2) * rho_dot
    turn -= (p[13] * u1 + p[14] * u2) * acc[0] + (p[15] * u1 + p[16] * u2) * acc[3]
    f = combined(acc[0], c0, combined(acc[1], c1, combined(acc[3], c3, combined(acc[4], c4, f))))
    f = combined(dd1, n1, combined(dd2, n2, combined(rho_dot, cr, f)))
    turn -= f[2] + f[5]
    back = turned((f[0], f[1] + turn * i, f[2], f[3], f[4] - turn * i, f[5]))
    hx, hy = (acc[4] - acc[1]) * i * i - 2.0 * rho * stretch * i, (acc[3] - acc[0]) * i * i
    for k in range(6):
        G = cr[k] - n1[k] - n2[k]
        H = by_rho[k] - by_d1[k] - by_d2[k] - 2.0 * stretch * G
        T = acc[1] * c0[k] + acc[4] * c3[k] - acc[0] * c1[k] - acc[3] * c4[k] - back[k] - 2.0 * rho * rho * G
        K[k, 0] += H * rho * i + G * hx
        K[k, 1] += (H * stretch - T + by_u1[k] + by_u2[k]) * i + G * hy
        K[k, 2] += by_u1[k]
        K[k, 5] += by_u2[k]
        C[k, 0] += 2.0 * rho * i * G
        C[k, 1] -= i * H
        C[k, 2] += by_d1[k]
        C[k, 5] += by_d2[k]
        M[k, 0], M[k, 1], M[k, 2], M[k, 3], M[k, 4], M[k, 5] = c0[k], c1[k] - i * G, n1[k], c3[k], c4[k] + i * G, n2[k]
    add_curvature_of_chord(turn, l, K)
    return f


@compiled
def elasticity(p, l, e, u1, u2, u, t, K, C):
    """Elastic and damping force in the axes of the chord; columns 0, 1, 2 and 5 are added to K and C."""
    L, ka, kb11, kb12, kb22, zeta = p[0], p[1], p[2], p[3], p[4], p[7]
    rate = t[1] * u[1] + t[4] * u[4]
    u1_dot, u2_dot = u[2] - rate, u[5] - rate
    g1, g2 = L / 30.0 * (4.0 * u1 - u2), L / 30.0 * (4.0 * u2 - u1)
    g1_dot, g2_dot = L / 30.0 * (4.0 * u1_dot - u2_dot), L / 30.0 * (4.0 * u2_dot - u1_dot)
    e_dot = u[3] - u[0] + g1 * u1_dot + g2 * u2_dot
    N = ka * (e + zeta * e_dot)
    Q1 = kb11 * (u1 + zeta * u1_dot) + kb12 * (u2 + zeta * u2_dot)
    Q2 = kb12 * (u1 + zeta * u1_dot) + kb22 * (u2 + zeta * u2_dot)
    i = 1.0 / l
    d0 = (-1.0, (g1 + g2) * i, g1, 1.0, -(g1 + g2) * i, g2)
    d1 = (0.0, i, 1.0, 0.0, -i, 0.0)
    d2 = (0.0, i, 0.0, 0.0, -i, 1.0)
    hx, hy = (u[4] - u[1]) * i * i, (u[3] - u[0]) * i * i
    h = (hx, hy, 0.0, -hx, -hy, 0.0)  # d(rate)/dq
    # derivatives of e_dot, u1_dot, u2_dot by q, times zeta, beside those of e, u1, u2
    y0 = combined(zeta * l * rate, t, combined(-zeta * (g1 + g2), h, d0))
    y0 = combined(zeta * g1_dot, d1, combined(zeta * g2_dot, d2, y0))
    y1, y2 = combined(-zeta, h, d1), combined(-zeta, h, d2)
    n = N * L / 30.0
    for k in range(6):
        x0, x1 = ka * d0[k], kb11 * d1[k] + kb12 * d2[k]
        x2 = kb12 * d1[k] + kb22 * d2[k]
        z1, z2 = n * (4.0 * d1[k] - d2[k]), n * (4.0 * d2[k] - d1[k])
        z0 = N * l * t[k]
        for j in (0, 1, 2, 5):
            K[k, j] += x0 * y0[j] + x1 * y1[j] + x2 * y2[j] + z1 * d1[j] + z2 * d2[j] + z0 * t[j]
            if zeta != 0.0:
                C[k, j] += zeta * (x0 * d0[j] + x1 * d1[j] + x2 * d2[j])
    add_curvature_of_chord(-(N * (g1 + g2) + Q1 + Q2), l, K)
    m1, m2 = Q1 + N * g1, Q2 + N * g2
    m = (m1 + m2) * i
    return (-N, m, m1, N, -m, m2)


@compiled
def weights(p):
    """int rho A of 1 - xi, xi, N2 and N4."""
    return p[10] + p[11], p[11] + p[12], p[13] + p[15], p[14] + p[16]


@compiled
def weight(p, l, c, s, u1, u2, t, K):
    """Force of gravity, as the structure exerts it, in the axes of the chord; columns 0, 1, 2 and 5 are added to K."""
    a1, a2, c1, c2 = weights(p)
    gx, gy = c * p[8] + s * p[9], c * p[9] - s * p[8]
    lever, both = c1 * u1 + c2 * u2, c1 + c2
    V1 = gx * lever + gy * both
    V2 = gy * lever - 2.0 * gx * both
    for i in (1, 4):
        K[i, 1] += V2 * t[i] * t[1]
        K[i, 2] += gx * c1 * t[i]
        K[i, 5] += gx * c2 * t[i]
    K[2, 1] += gx * c1 * t[1]
    K[5, 1] += gx * c2 * t[1]
    add_curvature_of_chord(V1, l, K)
    return (-a1 * gx, -a1 * gy + V1 * t[1], -c1 * gy, -a2 * gx, -a2 * gy + V1 * t[4], -c2 * gy)


@element_kernel
def beam_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Corotational Euler-Bernoulli element; q, r (6,), K, C, M (6, 6)."""
    l, c, s, e, u1, u2 = deformation(p, q)
    slope = (0.0, -1.0 / l, 0.0, 0.0, 1.0 / l, 0.0)  # d(alpha)/dq
    u = to_chord(c, s, v)
    f = inertia(p, l, u1, u2, u, to_chord(c, s, a), K, C, M)
    f = combined(1.0, elasticity(p, l, e, u1, u2, u, slope, K, C), f)
    if p[8] != 0.0 or p[9] != 0.0:
        f = combined(1.0, weight(p, l, c, s, u1, u2, slope, K), f)
    r[0], r[1], r[2] = c * f[0] - s * f[1], s * f[0] + c * f[1], f[2]
    r[3], r[4], r[5] = c * f[3] - s * f[4], s * f[3] + c * f[4], f[5]
    rotate_back_and_fill(c, s, K)
    rotate_back_and_fill(c, s, C)
    rotate_back(c, s, M)


@energy_kernel
def beam_energy(p, t, q, v):
    """Strain energy, potential of gravity, power dissipated by damping."""
    l, c, s, e, u1, u2 = deformation(p, q)
    u = to_chord(c, s, v)
    rate = (u[4] - u[1]) / l
    d1, d2 = u[2] - rate, u[5] - rate
    L, ka, kb11, kb12, kb22 = p[0], p[1], p[2], p[3], p[4]
    e_dot = u[3] - u[0] + L / 30.0 * ((4.0 * u1 - u2) * d1 + (4.0 * u2 - u1) * d2)
    strain = 0.5 * (ka * e * e + kb11 * u1 * u1 + 2.0 * kb12 * u1 * u2 + kb22 * u2 * u2)
    power = p[7] * (ka * e_dot * e_dot + kb11 * d1 * d1 + 2.0 * kb12 * d1 * d2 + kb22 * d2 * d2)
    normal = c * p[9] - s * p[8]
    a1, a2, c1, c2 = weights(p)
    height = a1 * (p[8] * q[0] + p[9] * q[1]) + a2 * (p[8] * q[3] + p[9] * q[4])
    return strain, -height - normal * (c1 * u1 + c2 * u2), power
