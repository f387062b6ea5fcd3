"""Mass-proportional damping of a beam element, on the velocity of deformation: kernel and power.

The body's frame has its origin in the node A and its x axis towards the node B; alpha is the direction from A to B.
For the nodes k = i, j of the element

Deformation      dk = R(alpha)^T (xk - xA)  and  thetak - alpha   (constant parts have no rate)
Its rate         dk_dot = R^T (vk - vA) + alpha_dot D dk,   thetak_dot - alpha_dot,   D = [[0, 1], [-1, 0]]
Force            r = zeta J^T m J v,   J = d(d)/dq
Power            zeta d_dot^T m d_dot >= 0

with m the consistent mass of the element in the axes of the body's frame.  Every rigid motion, also of a bent body, has
d_dot = 0 and is not damped.  The forces are in balance, moments included.

In the axes of the frame, with S v = (vk - vA, thetak_dot), g = (D di, -1, D dj, -1), t = d(alpha)/dq and
H = d2(alpha)/dq2, J = S + g t^T.  Both tangents follow by the product rule, without omissions.
Equation (3.10) of docs/theory/inertia.md.
"""

import math
from collections.abc import Sequence

import numpy as np

from flexmb.kernels import account_kernel, compiled, element_kernel, energy_kernel, force_kernel

ZETA, M11, M12, M13, M14, M15, M16, M22, M23, M24, M25, M26 = range(12)
M33, M34, M35, M36, M44, M45, M46, M55, M56, M66 = range(12, 22)
"""Parameters p: damping rate zeta and upper triangle of m, row by row."""


@compiled
def turned(x):
    """D x for both nodes."""
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
def deformation_rate(q, v):
    """Frame (l, cos, sin), alpha_dot, its derivatives by A along and across AB, g, d_dot, in the axes of the frame."""
    dx, dy = q[2] - q[0], q[3] - q[1]
    l = math.sqrt(dx * dx + dy * dy)
    c, s = dx / l, dy / l
    wx, wy = v[2] - v[0], v[3] - v[1]
    stretch, rate = (c * wx + s * wy) / l, (c * wy - s * wx) / l
    xi, yi, xj, yj = q[4] - q[0], q[5] - q[1], q[7] - q[0], q[8] - q[1]
    g = (c * yi - s * xi, -c * xi - s * yi, -1.0, c * yj - s * xj, -c * xj - s * yj, -1.0)
    vxi, vyi, vxj, vyj = v[4] - v[0], v[5] - v[1], v[7] - v[0], v[8] - v[1]
    u = (c * vxi + s * vyi, c * vyi - s * vxi, v[6], c * vxj + s * vyj, c * vyj - s * vxj, v[9])
    return l, c, s, rate, rate / l, stretch / l, g, combined(rate, g, u)


@compiled
def mass_times(p, x):
    """M x; p holds the upper triangle of m."""
    a, b, c, d, e, f = x
    return (
        p[M11] * a + p[M12] * b + p[M13] * c + p[M14] * d + p[M15] * e + p[M16] * f,
        p[M12] * a + p[M22] * b + p[M23] * c + p[M24] * d + p[M25] * e + p[M26] * f,
        p[M13] * a + p[M23] * b + p[M33] * c + p[M34] * d + p[M35] * e + p[M36] * f,
        p[M14] * a + p[M24] * b + p[M34] * c + p[M44] * d + p[M45] * e + p[M46] * f,
        p[M15] * a + p[M25] * b + p[M35] * c + p[M45] * d + p[M55] * e + p[M56] * f,
        p[M16] * a + p[M26] * b + p[M36] * c + p[M46] * d + p[M56] * e + p[M66] * f,
    )


@compiled
def on_nodes(k, y, l):
    """S^T y + k t: forces on A, B, i and j."""
    return (-y[0] - y[3], -y[1] - y[4] - k / l, 0.0, k / l, y[0], y[1], y[2], y[3], y[4], y[5])


@compiled
def add_product(y, hx, hy, X):
    """X += y h^T, where h has the entries hx, hy of A and the opposite ones of B."""
    for i in range(10):
        X[i, 0] += y[i] * hx
        X[i, 1] += y[i] * hy
        X[i, 2] -= y[i] * hx
        X[i, 3] -= y[i] * hy


@compiled
def fill_blocks(p, rate, K, C):
    """C = S^T m S and K = rate S^T m D S."""
    k = M11
    for i in range(4, 10):
        for j in range(i, 10):
            C[i, j] = p[k]
            C[j, i] = p[k]
            k += 1
    for i in range(4, 10):
        for j in (4, 7):
            K[i, j], K[i, j + 1] = -rate * C[i, j + 1], rate * C[i, j]
    for X in (K, C):
        for j in range(4, 10):
            X[0, j], X[1, j] = -X[4, j] - X[7, j], -X[5, j] - X[8, j]
        for i in range(10):
            X[i, 0], X[i, 1] = -X[i, 4] - X[i, 7], -X[i, 5] - X[i, 8]


@compiled
def add_curvature(k, l, K):
    """K += k H."""
    h = k / (l * l)
    for i, j in ((0, 1), (2, 3)):
        K[i, j] -= h
        K[j, i] -= h
    for i, j in ((0, 3), (1, 2)):
        K[i, j] += h
        K[j, i] += h


@compiled
def finish(zeta, c, s, X):
    """X times zeta, with rows and columns turned from the axes of the frame into the axes of the plane."""
    for k in (0, 2, 4, 7):
        for j in range(10):
            x, y = X[k, j], X[k + 1, j]
            X[k, j], X[k + 1, j] = c * x - s * y, s * x + c * y
    for i in range(10):
        for k in (0, 2, 4, 7):
            x, y = X[i, k], X[i, k + 1]
            X[i, k], X[i, k + 1] = c * x - s * y, s * x + c * y
    for i in range(10):
        for j in range(10):
            X[i, j] *= zeta


@compiled
def write_force(zeta, l, c, s, g, f, r):
    """r = zeta J^T f."""
    F = on_nodes(dot(f, g), f, l)
    for k in (0, 2, 4, 7):
        r[k], r[k + 1] = zeta * (c * F[k] - s * F[k + 1]), zeta * (s * F[k] + c * F[k + 1])
    r[6], r[9] = zeta * F[6], zeta * F[9]


@element_kernel
def mass_damping_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Damping of d_dot; q = (xA, yA, xB, yB, xi, yi, thetai, xj, yj, thetaj), r (10,), K, C (10, 10), M = 0."""
    zeta = p[ZETA]
    l, c, s, rate, hx, hy, g, d_dot = deformation_rate(q, v)
    f, x, y = mass_times(p, d_dot), mass_times(p, g), mass_times(p, turned(d_dot))
    write_force(zeta, l, c, s, g, f, r)
    fill_blocks(p, rate, K, C)
    # C = S^T m S + J^T m g t^T + t (S^T m g)^T
    zero = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    slope = on_nodes(1.0, zero, l)
    xJ, xS = on_nodes(dot(g, x), x, l), on_nodes(0.0, x, l)
    add_product(xJ, 0.0, -1.0 / l, C)
    # K = J^T m d(d_dot)/dq + d(J^T f)/dq, d(d_dot)/dq = rate D S + D d_dot t^T + g h^T, h = d(rate)/dq
    Df = turned(f)
    column = on_nodes(dot(g, y) + dot(f, turned(g)), combined(-1.0, Df, y), l)
    row = on_nodes(0.0, combined(rate, turned(x), Df), l)
    add_product(column, 0.0, -1.0 / l, K)
    add_product(xJ, hx, hy, K)
    for j in range(10):
        for i in (1, 3):
            C[i, j] += slope[i] * xS[j]
            K[i, j] -= slope[i] * row[j]
    add_curvature(dot(f, g), l, K)
    finish(zeta, c, s, K)
    finish(zeta, c, s, C)


@compiled
def put_force(p, q, v, r):
    """r (10,), and the power of damping."""
    l, c, s, rate, hx, hy, g, d_dot = deformation_rate(q, v)
    f = mass_times(p, d_dot)
    write_force(p[ZETA], l, c, s, g, f, r)
    return p[ZETA] * dot(d_dot, f)


@force_kernel
def mass_damping_force(p, t, h, q, v, a, z, r, z_new):
    """Residual r (10,) alone."""
    put_force(p, q, v, r)


@energy_kernel
def mass_damping_energy(p, t, q, v):
    """Energies: nothing stored, and the power of damping."""
    _, _, _, _, _, _, _, d_dot = deformation_rate(q, v)
    return 0.0, 0.0, p[ZETA] * dot(d_dot, mass_times(p, d_dot))


@account_kernel
def mass_damping_account(p, t, h, q, v, a, y, z, r, Mv, My, z_new):
    """r (10,), no mass, the power of damping."""
    return 0.0, 0.0, put_force(p, q, v, r)


def damping_parameters(
    zeta: float, angle: float, axial: np.ndarray, bending: np.ndarray, lumps: Sequence[tuple[float, float]]
) -> tuple[float, ...]:
    """Parameters p of an element at a damping rate zeta1 [1/s].

    `angle` [rad] is the direction of the element against the line from A to B in the reference configuration; `axial`
    (2, 2) is the mass in the order u1, u2 [kg], `bending` (4, 4) in the order w1, theta1, w2, theta2 [kg, kg m,
    kg m^2]; `lumps` are mass [kg] and moment of inertia [kg m^2] on each of the two nodes.
    """
    m, turn = np.zeros((6, 6)), np.eye(6)
    m[np.ix_((0, 3), (0, 3))] = axial
    m[np.ix_((1, 2, 4, 5), (1, 2, 4, 5))] = bending
    c, s = math.cos(angle), math.sin(angle)
    for k in (0, 3):
        turn[k : k + 2, k : k + 2] = [[c, -s], [s, c]]
    m = turn @ m @ turn.T
    for k, (mass, inertia) in zip((0, 3), lumps, strict=True):
        m[range(k, k + 3), range(k, k + 3)] += (mass, mass, inertia)
    return (float(zeta), *(float(x) for x in m[np.triu_indices(6)]))
