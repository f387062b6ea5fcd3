"""Total-Lagrange cell of a St. Venant-Kirchhoff material, integrated by quadrature: the reference for larger strain.

Gradient F = sum x g^T, strain E = (F^T F - 1)/2, stress S = C (E + zeta E_dot), forces int F S g, energy int 1/2 E C E.
Source: T. Belytschko, W. K. Liu, B. Moran, Nonlinear Finite Elements for Continua and Structures, Wiley 2000,
sections 4.9 and 6.4.
"""

from flexmb.kernels import fast
from flexmb.planes.cell_numbers import NODES, ZETA, formulation_at

POINTS, C11, C12, C22, C33, FIRST_POINT = range(6)
"""Numbers of the formulation: quadrature points, moduli [Pa]; at each point weight t dA [m^3], gradients (m, 2)."""

GX, GY = 1, 2
"""Gradient of the first node behind the weight of a point."""


@fast
def point_at(p, k):
    """Place of quadrature point k."""
    return formulation_at(p) + FIRST_POINT + k * (1 + 2 * int(p[NODES]))


@fast
def gradient(p, point, x):
    """Gradient (xx, xy, yx, yy) of a nodal field x (2 m,) at a quadrature point."""
    xx, xy, yx, yy = 0.0, 0.0, 0.0, 0.0
    for k in range(int(p[NODES])):
        gx, gy = p[point + 2 * k + GX], p[point + 2 * k + GY]
        xx += x[2 * k] * gx
        xy += x[2 * k] * gy
        yx += x[2 * k + 1] * gx
        yy += x[2 * k + 1] * gy
    return xx, xy, yx, yy


@fast
def strain(F):
    """Green's strain (E11, E22, 2 E12)."""
    xx, xy, yx, yy = F
    return 0.5 * (xx * xx + yx * yx - 1.0), 0.5 * (xy * xy + yy * yy - 1.0), xx * xy + yx * yy


@fast
def strain_rate(F, L):
    """Rate of `strain` for the rate L of F."""
    xx, xy, yx, yy = F
    lx, ly, mx, my = L
    return xx * lx + yx * mx, xy * ly + yy * my, xx * ly + lx * xy + yx * my + mx * yy


@fast
def stress(p, E):
    """Second Piola-Kirchhoff stress (S11, S22, S12)."""
    at = formulation_at(p)
    x, y, z = E
    return p[at + C11] * x + p[at + C12] * y, p[at + C12] * x + p[at + C22] * y, p[at + C33] * z


@fast
def add_force(p, point, F, S, r):
    """Add the forces of stress S at a quadrature point to r (2 m,)."""
    xx, xy, yx, yy = F
    weight = p[point]
    for k in range(int(p[NODES])):
        gx, gy = weight * p[point + 2 * k + GX], weight * p[point + 2 * k + GY]
        a, b = S[0] * gx + S[2] * gy, S[2] * gx + S[1] * gy
        r[2 * k] += xx * a + xy * b
        r[2 * k + 1] += yx * a + yy * b


@fast
def lagrange_force(p, x, v, r):
    """Forces r (2 m,) of elasticity and damping."""
    for i in range(2 * int(p[NODES])):
        r[i] = 0.0
    for k in range(int(p[formulation_at(p)])):
        point = point_at(p, k)
        F = gradient(p, point, x)
        add_force(p, point, F, damped_stress(p, point, F, v), r)


@fast
def damped_stress(p, point, F, v):
    """Stress at a quadrature point, with that of damping."""
    E = strain(F)
    if p[ZETA] > 0.0:
        D = strain_rate(F, gradient(p, point, v))
        E = (E[0] + p[ZETA] * D[0], E[1] + p[ZETA] * D[1], E[2] + p[ZETA] * D[2])
    return stress(p, E)


@fast
def lagrange_damping(p, x, v, r):
    """Forces r (2 m,) of damping alone, a linear function of v."""
    for i in range(2 * int(p[NODES])):
        r[i] = 0.0
    for k in range(int(p[formulation_at(p)])):
        point = point_at(p, k)
        F = gradient(p, point, x)
        D = strain_rate(F, gradient(p, point, v))
        add_force(p, point, F, stress(p, (p[ZETA] * D[0], p[ZETA] * D[1], p[ZETA] * D[2])), r)


@fast
def lagrange_energy(p, x, v):
    """Strain energy [J] and power of damping [W]."""
    energy, power = 0.0, 0.0
    for k in range(int(p[formulation_at(p)])):
        point = point_at(p, k)
        F = gradient(p, point, x)
        E = strain(F)
        S = stress(p, E)
        energy += 0.5 * p[point] * (E[0] * S[0] + E[1] * S[1] + E[2] * S[2])
        if p[ZETA] > 0.0:
            D = strain_rate(F, gradient(p, point, v))
            S = stress(p, D)
            power += p[ZETA] * p[point] * (D[0] * S[0] + D[1] * S[1] + D[2] * S[2])
    return energy, power


@fast
def lagrange_tangent(p, x, v, kq, kv, r, A):
    """Forces r (2 m,) and A = kq dr/dq + kv dr/dv (2 m, 2 m)."""
    n = 2 * int(p[NODES])
    for i in range(n):
        r[i] = 0.0
        for j in range(n):
            A[i, j] = 0.0
    for k in range(int(p[formulation_at(p)])):
        point = point_at(p, k)
        F = gradient(p, point, x)
        S = damped_stress(p, point, F, v)
        L = gradient(p, point, v) if p[ZETA] > 0.0 else (0.0, 0.0, 0.0, 0.0)
        add_force(p, point, F, S, r)
        stiff, turn = kq + kv * p[ZETA], kq * p[ZETA]
        # what the strain changes by is `strain_rate` with this gradient in place of F
        D = weighted_sum(stiff, F, turn, L)
        add_tangent(p, point, F, D, (kq * S[0], kq * S[1], kq * S[2]), A)


@fast
def weighted_sum(k, X, l, Y):
    """k X + l Y of two gradients."""
    return k * X[0] + l * Y[0], k * X[1] + l * Y[1], k * X[2] + l * Y[2], k * X[3] + l * Y[3]


@fast
def variations(F, gx, gy):
    """Changes of strain by the displacement of a node along x and along y, whose gradient is (gx, gy)."""
    xx, xy, yx, yy = F
    return (xx * gx, xy * gy, xx * gy + xy * gx), (yx * gx, yy * gy, yx * gy + yy * gx)


@fast
def add_tangent(p, point, F, D, S, A):
    """Add the tangent of a quadrature point: initial stress S, and changes of strain by D."""
    m, weight = int(p[NODES]), p[point]
    for l in range(m):
        hx, hy = weight * p[point + 2 * l + GX], weight * p[point + 2 * l + GY]
        along, across = variations(D, hx, hy)
        X, Y = stress(p, along), stress(p, across)
        a, b = S[0] * hx + S[2] * hy, S[2] * hx + S[1] * hy
        for k in range(m):
            gx, gy = p[point + 2 * k + GX], p[point + 2 * k + GY]
            U, V = variations(F, gx, gy)
            initial = gx * a + gy * b
            i, j = 2 * k, 2 * l
            A[i, j] += initial + U[0] * X[0] + U[1] * X[1] + U[2] * X[2]
            A[i, j + 1] += U[0] * Y[0] + U[1] * Y[1] + U[2] * Y[2]
            A[i + 1, j] += V[0] * X[0] + V[1] * X[1] + V[2] * X[2]
            A[i + 1, j + 1] += initial + V[0] * Y[0] + V[1] * Y[1] + V[2] * Y[2]
