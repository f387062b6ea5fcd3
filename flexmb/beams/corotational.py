"""The corotational Euler-Bernoulli element: kernel and energies.

Nodes (x1, y1, theta1, x2, y2, theta2); the chord from node 1 to node 2 has length l and direction alpha.

Deformation      e = l - L + L/30 (2 u1^2 - u1 u2 + 2 u2^2),   uk = thetak + offset_k - alpha
Strain energy    V = 1/2 ka e^2 + 1/2 (u1, u2) kb (u1, u2)^T
Kinetic energy   T = 1/2 u^T m u,   u = B(alpha) v: the nodal velocities in the axes of the chord
Damping          zeta ka e_dot, zeta kb (u1_dot, u2_dot): stiffness-proportional, on the deformation only
Gravity          Vg = -g . (a1 x1 + a2 x2 + n (c1 u1 + c2 u2)),   n normal to the chord

Known error: T lacks the axial velocity -alpha_dot w of the bent shape, so uniform flight changes the inertia force of
an element that is bent and turns, by an amount that falls with the square of its length (docs/design.md, section 6).

ka, kb, m, a and c come from weak forms (see `fem`).  The term with L/30 is the shortening of the chord by bending,
averaged over the element; it removes membrane locking.  Inertia forces are d/dt(dT/dv) - dT/dq of this T.
With D = dB/dalpha B^T, A = m D - D m, t = dalpha/dq, all in the axes of the chord:
    f = m a + alpha_dot A u - (u^T m D u) t
Source: M. A. Crisfield, Non-linear Finite Element Analysis of Solids and Structures, vol. 1, Wiley 1991, chapter 7
(corotational beam with averaged shallow-arch strain); the inertia terms are derived here from T.
"""

import math

from flexmb.kernels import compiled, element_kernel, energy_kernel

PARAMETERS = (
    "L ka kb11 kb12 kb22 offset1 offset2 zeta gx gy a1 a2 c1 c2 ma11 ma12 ma22 "
    "mb11 mb12 mb13 mb14 mb22 mb23 mb24 mb33 mb34 mb44"
).split()
"""What p holds, in this order; mb in the order w1, theta1, w2, theta2."""


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
def mass_times(p, x):
    """M x in the axes of the chord."""
    return (
        p[14] * x[0] + p[15] * x[3],
        p[17] * x[1] + p[18] * x[2] + p[19] * x[4] + p[20] * x[5],
        p[18] * x[1] + p[21] * x[2] + p[22] * x[4] + p[23] * x[5],
        p[15] * x[0] + p[16] * x[3],
        p[19] * x[1] + p[22] * x[2] + p[24] * x[4] + p[25] * x[5],
        p[20] * x[1] + p[23] * x[2] + p[25] * x[4] + p[26] * x[5],
    )


@compiled
def dot(x, y):
    """Scalar product of two nodal vectors."""
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2] + x[3] * y[3] + x[4] * y[4] + x[5] * y[5]


@compiled
def combined(k, x, y):
    """k x + y."""
    return (k * x[0] + y[0], k * x[1] + y[1], k * x[2] + y[2], k * x[3] + y[3], k * x[4] + y[4], k * x[5] + y[5])


@compiled
def fill_mass(p, M):
    """M = m."""
    M[0, 0], M[0, 3], M[3, 0], M[3, 3] = p[14], p[15], p[15], p[16]
    M[1, 1], M[1, 2], M[1, 4], M[1, 5] = p[17], p[18], p[19], p[20]
    M[2, 1], M[2, 2], M[2, 4], M[2, 5] = p[18], p[21], p[22], p[23]
    M[4, 1], M[4, 2], M[4, 4], M[4, 5] = p[19], p[22], p[24], p[25]
    M[5, 1], M[5, 2], M[5, 4], M[5, 5] = p[20], p[23], p[25], p[26]


@compiled
def add_curvature_of_chord(k, l, K):
    """K += k d2(alpha)/dq2."""
    h = k / (l * l)
    K[0, 1] -= h
    K[1, 0] -= h
    K[3, 4] -= h
    K[4, 3] -= h
    K[0, 4] += h
    K[4, 0] += h
    K[1, 3] += h
    K[3, 1] += h


@compiled
def rotate_back(c, s, X):
    """X = B^T X B."""
    for k in (0, 3):
        for j in range(6):
            x, y = X[k, j], X[k + 1, j]
            X[k, j] = c * x - s * y
            X[k + 1, j] = s * x + c * y
    for i in range(6):
        for k in (0, 3):
            x, y = X[i, k], X[i, k + 1]
            X[i, k] = c * x - s * y
            X[i, k + 1] = s * x + c * y


@compiled
def inertia(p, l, u, acc, t, K, C, M):
    """Inertia force in the axes of the chord; its tangents are added to K, C, M."""
    rate = t[1] * u[1] + t[4] * u[4]
    Du, mu = turned(u), mass_times(p, u)
    mDu = mass_times(p, Du)
    Au = combined(-1.0, turned(mu), mDu)
    w = combined(rate, Au, mass_times(p, acc))
    s = dot(u, mDu)
    fill_mass(p, M)
    # C = Au t^T + rate A - t Au^T
    for i in range(6):
        C[i, 0] -= rate * M[i, 1]
        C[i, 1] += rate * M[i, 0]
        C[i, 3] -= rate * M[i, 4]
        C[i, 4] += rate * M[i, 3]
        C[0, i] -= rate * M[1, i]
        C[1, i] += rate * M[0, i]
        C[3, i] -= rate * M[4, i]
        C[4, i] += rate * M[3, i]
        C[i, 1] += Au[i] * t[1]
        C[i, 4] += Au[i] * t[4]
        C[1, i] -= Au[i] * t[1]
        C[4, i] -= Au[i] * t[4]
    # K = (-D w + m D a + rate A D u - (Au . Du) t) t^T + Au (d(rate)/dq)^T - s d2(alpha)/dq2
    DDu = turned(Du)
    ADu = combined(-1.0, turned(mDu), mass_times(p, DDu))
    x = combined(-1.0, turned(w), combined(rate, ADu, mass_times(p, turned(acc))))
    x = combined(-dot(Au, Du), t, x)
    hx, hy = (u[4] - u[1]) / (l * l), (u[3] - u[0]) / (l * l)
    for i in range(6):
        K[i, 0] += Au[i] * hx
        K[i, 1] += Au[i] * hy + x[i] * t[1]
        K[i, 3] -= Au[i] * hx
        K[i, 4] += x[i] * t[4] - Au[i] * hy
    add_curvature_of_chord(-s, l, K)
    return combined(-s, t, w)


@compiled
def elasticity(p, l, e, u1, u2, u, t, K, C):
    """Elastic and damping force in the axes of the chord; its tangents are added to K and C."""
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
        for j in range(6):
            K[k, j] += x0 * y0[j] + x1 * y1[j] + x2 * y2[j] + z1 * d1[j] + z2 * d2[j] + z0 * t[j]
            C[k, j] += zeta * (x0 * d0[j] + x1 * d1[j] + x2 * d2[j])
    add_curvature_of_chord(-(N * (g1 + g2) + Q1 + Q2), l, K)
    m1, m2 = Q1 + N * g1, Q2 + N * g2
    m = (m1 + m2) * i
    return (-N, m, m1, N, -m, m2)


@compiled
def weight(p, l, c, s, u1, u2, t, K):
    """Force of gravity, as the structure exerts it, in the axes of the chord; its tangent is added to K."""
    a1, a2, c1, c2 = p[10], p[11], p[12], p[13]
    gx, gy = c * p[8] + s * p[9], c * p[9] - s * p[8]
    lever, both = c1 * u1 + c2 * u2, c1 + c2
    V1 = gx * lever + gy * both
    V2 = gy * lever - 2.0 * gx * both
    for i in (1, 4):
        for j in (1, 4):
            K[i, j] += V2 * t[i] * t[j]
        K[i, 2] += gx * c1 * t[i]
        K[2, i] += gx * c1 * t[i]
        K[i, 5] += gx * c2 * t[i]
        K[5, i] += gx * c2 * t[i]
    add_curvature_of_chord(V1, l, K)
    return (-a1 * gx, -a1 * gy + V1 * t[1], -c1 * gy, -a2 * gx, -a2 * gy + V1 * t[4], -c2 * gy)


@element_kernel
def beam_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Corotational Euler-Bernoulli element; q, r (6,), K, C, M (6, 6)."""
    l, c, s, e, u1, u2 = deformation(p, q)
    slope = (0.0, -1.0 / l, 0.0, 0.0, 1.0 / l, 0.0)  # d(alpha)/dq
    u = to_chord(c, s, v)
    f = inertia(p, l, u, to_chord(c, s, a), slope, K, C, M)
    f = combined(1.0, elasticity(p, l, e, u1, u2, u, slope, K, C), f)
    if p[8] != 0.0 or p[9] != 0.0:
        f = combined(1.0, weight(p, l, c, s, u1, u2, slope, K), f)
    r[0], r[1], r[2] = c * f[0] - s * f[1], s * f[0] + c * f[1], f[2]
    r[3], r[4], r[5] = c * f[3] - s * f[4], s * f[3] + c * f[4], f[5]
    rotate_back(c, s, K)
    rotate_back(c, s, C)
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
    height = p[10] * (p[8] * q[0] + p[9] * q[1]) + p[11] * (p[8] * q[3] + p[9] * q[4])
    return strain, -height - normal * (p[12] * u1 + p[13] * u2), power
