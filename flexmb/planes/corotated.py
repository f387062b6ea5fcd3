"""Corotated cell: linear elasticity in axes that turn with the mean deformation gradient of the cell.

With nodes at X in the mesh and x in the world, g the mean gradient of each shape function over the cell, and
J = [[0, -1], [1, 0]]:

Rotation       a = sum g . x,  b = sum (J g) . x,  rho = |(a, b)|,  R = rotation by alpha = atan2(b, a)
Deformation    e = R^T (x - x0),  d = e - (X - X0)
Energy         V = 1/2 d^T K0 d,  K0 the stiffness of linear elasticity
Damping        D = 1/2 zeta d_dot^T K0 d_dot: none in a rigid motion

alpha is the rotation of the polar decomposition of the mean deformation gradient.  In the turned axes its gradient is
w = J g / rho, the rate of d is P (R^T v) with P = 1 - (J e) w^T, forces are P^T f with f = K0 (d + zeta d_dot), and

    d(P^T f) = P^T K0 P + (J f) w^T + w (J f)^T - (f . e) w w^T - mu / rho (g w^T + w g^T),   mu = -(J e) . f

adds the change of P to the stiffness, so forces are the gradient of V and the tangent is exact for any rotation.
Source: C. A. Felippa, B. Haugen, A unified formulation of small-strain corotational finite elements, Computer Methods
in Applied Mechanics and Engineering 194 (2005) 2285-2335, sections 4 and 5 (projector P, geometric stiffness), here
with a rotation that is a function of all nodes, so that nothing is left out.
"""

import math

from flexmb.kernels import fast
from flexmb.planes.cell_numbers import NODES, PLACES, ZETA, formulation_at, nodal


@fast
def deformation(p, x, d):
    """d (2 m,) of nodes at x (2 m,), relative to the first node; cos, sin of the rotation, and rho."""
    m, g = int(p[NODES]), formulation_at(p)
    a, b = 0.0, 0.0
    for k in range(m):
        ex, ey = x[2 * k] - x[0], x[2 * k + 1] - x[1]
        gx, gy = p[g + 2 * k], p[g + 2 * k + 1]
        a += gx * ex + gy * ey
        b += gx * ey - gy * ex
        d[2 * k], d[2 * k + 1] = ex, ey
    rho = math.sqrt(a * a + b * b)
    c, s = a / rho, b / rho
    for k in range(m):
        ex, ey = d[2 * k], d[2 * k + 1]
        d[2 * k] = c * ex + s * ey - (p[PLACES + 2 * k] - p[PLACES])
        d[2 * k + 1] = c * ey - s * ex - (p[PLACES + 2 * k + 1] - p[PLACES + 1])
    return c, s, rho


@fast
def place_in_axes(p, d, k):
    """e of node k in the turned axes, from the first node."""
    return d[2 * k] + p[PLACES + 2 * k] - p[PLACES], d[2 * k + 1] + p[PLACES + 2 * k + 1] - p[PLACES + 1]


@fast
def deformation_rate(p, c, s, rho, d, v, rate):
    """d_dot (2 m,) of nodal velocities v (2 m,); the rate of alpha and g . (R^T v)."""
    m, g = int(p[NODES]), formulation_at(p)
    turn, stretch = 0.0, 0.0
    for k in range(m):
        dx, dy = v[2 * k] - v[0], v[2 * k + 1] - v[1]
        ux, uy = c * dx + s * dy, c * dy - s * dx
        gx, gy = p[g + 2 * k], p[g + 2 * k + 1]
        turn += (gx * uy - gy * ux) / rho
        stretch += gx * ux + gy * uy
        rate[2 * k], rate[2 * k + 1] = ux, uy
    for k in range(m):
        ex, ey = place_in_axes(p, d, k)
        rate[2 * k] += turn * ey
        rate[2 * k + 1] -= turn * ex
    return turn, stretch


@fast
def stiffness_times(p, u, f):
    """f = K0 u (2 m,)."""
    n = 2 * int(p[NODES])
    at = formulation_at(p) + n
    for i in range(n):
        f[i] = 0.0
    for j in range(n):
        row, uj = at + j * n, u[j]
        for i in range(n):
            f[i] += p[row + i] * uj


@fast
def turned_product(n, d, f):
    """(J d) . f of two nodal vectors of n numbers."""
    total = 0.0
    for k in range(0, n, 2):
        total += d[k] * f[k + 1] - d[k + 1] * f[k]
    return total


@fast
def product(n, x, y):
    """x . y of two vectors of n numbers."""
    total = 0.0
    for i in range(n):
        total += x[i] * y[i]
    return total


@fast
def projected(p, c, s, rho, moment, f, r):
    """r = R P^T f (2 m,), with moment = (J e) . f."""
    g = formulation_at(p)
    for k in range(int(p[NODES])):
        fx = f[2 * k] + moment / rho * p[g + 2 * k + 1]
        fy = f[2 * k + 1] - moment / rho * p[g + 2 * k]
        r[2 * k], r[2 * k + 1] = c * fx - s * fy, s * fx + c * fy


@fast
def corotated_force(p, x, v, r):
    """Forces r (2 m,) of elasticity and damping."""
    n = 2 * int(p[NODES])
    d, rate, f = nodal(), nodal(), nodal()
    c, s, rho = deformation(p, x, d)
    if p[ZETA] > 0.0:
        deformation_rate(p, c, s, rho, d, v, rate)
        for i in range(n):
            rate[i] = d[i] + p[ZETA] * rate[i]
        stiffness_times(p, rate, f)
    else:
        stiffness_times(p, d, f)
    projected(p, c, s, rho, turned_product(n, d, f), f, r)


@fast
def corotated_damping(p, x, v, r):
    """Forces r (2 m,) of damping alone, a linear function of v."""
    n = 2 * int(p[NODES])
    d, rate, f = nodal(), nodal(), nodal()
    c, s, rho = deformation(p, x, d)
    deformation_rate(p, c, s, rho, d, v, rate)
    stiffness_times(p, rate, f)
    for i in range(n):
        f[i] *= p[ZETA]
    projected(p, c, s, rho, turned_product(n, d, f), f, r)


@fast
def corotated_energy(p, x, v):
    """Strain energy [J] and power of damping [W]."""
    n = 2 * int(p[NODES])
    d, rate, f = nodal(), nodal(), nodal()
    c, s, rho = deformation(p, x, d)
    stiffness_times(p, d, f)
    strain = 0.5 * product(n, d, f)
    if p[ZETA] == 0.0:
        return strain, 0.0
    deformation_rate(p, c, s, rho, d, v, rate)
    stiffness_times(p, rate, f)
    return strain, p[ZETA] * product(n, rate, f)


@fast
def corotated_tangent(p, x, v, kq, kv, r, A):
    """Forces r (2 m,) and A = kq dr/dq + kv dr/dv (2 m, 2 m).

    In the turned axes A = stiff K0 - turn K0 J + left w^T + w right^T + turn / rho k g^T with k = K0 J d.
    """
    n, zeta = 2 * int(p[NODES]), p[ZETA]
    d, f, k, left, right = nodal(), nodal(), nodal(), nodal(), nodal()
    c, s, rho = deformation(p, x, d)
    for i in range(0, n, 2):
        left[i], left[i + 1] = -d[i + 1], d[i]
    stiffness_times(p, left, k)
    turn, stretch = 0.0, 0.0
    if zeta > 0.0:
        rate = nodal()
        turn, stretch = deformation_rate(p, c, s, rho, d, v, rate)
        for i in range(0, n, 2):
            left[i], left[i + 1] = -rate[i + 1], rate[i]
            right[i], right[i + 1] = d[i] + zeta * rate[i], d[i + 1] + zeta * rate[i + 1]
        stiffness_times(p, right, f)
        stiffness_times(p, left, right)  # K0 J d_dot
    else:
        stiffness_times(p, d, f)
        for i in range(n):
            right[i] = 0.0
    moment = turned_product(n, d, f)
    projected(p, c, s, rho, moment, f, r)
    stiff, turn = kq + kv * zeta, kq * zeta * turn
    rank_ones(p, rho, (kq, stiff, turn, kq * zeta * stretch, kq * moment), d, f, k, left, right)
    write_tangent(p, c, s, rho, stiff, turn, k, left, right, A)


@fast
def rank_ones(p, rho, factors, d, f, k, left, right):
    """Turn left = J d_dot, right = K0 J d_dot into the vectors beside w in `corotated_tangent`."""
    kq, stiff, turn, stretch, moment = factors
    n, g, zeta = 2 * int(p[NODES]), formulation_at(p), p[ZETA]
    bent = turned_product(n, d, k)  # (J e) . K0 (J e)
    along = 0.0  # f . e
    for i in range(0, n, 2):
        ex, ey = place_in_axes(p, d, i // 2)
        along += f[i] * ex + f[i + 1] * ey
    damped = stretch / rho * bent - kq * zeta * product(n, k, left)
    half = 0.5 * (stiff * bent - kq * along)
    for i in range(0, n, 2):
        gx, gy = p[g + i], p[g + i + 1]
        wx, wy = -gy / rho, gx / rho
        x = half * wx + moment / rho * gx - stiff * k[i] - kq * f[i + 1]
        y = half * wy + moment / rho * gy - stiff * k[i + 1] + kq * f[i]
        lx, ly = right[i], right[i + 1]
        left[i] = x - kq * zeta * lx + stretch / rho * k[i] - damped * wx
        left[i + 1] = y - kq * zeta * ly + stretch / rho * k[i + 1] - damped * wy
        right[i] = x + turn * k[i + 1] - turn / rho * bent * gx
        right[i + 1] = y - turn * k[i] - turn / rho * bent * gy


@fast
def write_tangent(p, c, s, rho, stiff, turn, k, left, right, A):
    """Blocks of `corotated_tangent`, turned into world axes."""
    n, g = 2 * int(p[NODES]), formulation_at(p)
    at = g + n
    for i in range(0, n, 2):
        ux, uy = -p[g + i + 1] / rho, p[g + i] / rho
        lx, ly, kx, ky = left[i], left[i + 1], turn / rho * k[i], turn / rho * k[i + 1]
        for j in range(0, n, 2):
            gx, gy = p[g + j], p[g + j + 1]
            wx, wy = -gy / rho, gx / rho
            row, below = at + i * n + j, at + (i + 1) * n + j
            xx = stiff * p[row] - turn * p[row + 1] + lx * wx + ux * right[j] + kx * gx
            xy = stiff * p[row + 1] + turn * p[row] + lx * wy + ux * right[j + 1] + kx * gy
            yx = stiff * p[below] - turn * p[below + 1] + ly * wx + uy * right[j] + ky * gx
            yy = stiff * p[below + 1] + turn * p[below] + ly * wy + uy * right[j + 1] + ky * gy
            px, py = c * xx - s * yx, c * xy - s * yy
            qx, qy = s * xx + c * yx, s * xy + c * yy
            A[i, j], A[i, j + 1] = c * px - s * py, s * px + c * py
            A[i + 1, j], A[i + 1, j + 1] = c * qx - s * qy, s * qx + c * qy
