"""Elasticity of a plane cell: corotated, and total Lagrange; nodes of a cell on rigid pins.

Head (below); places X of the nodes (m, 2), axes of the mesh [m]; mass matrix (m, m) [kg]; numbers of the formulation;
for a cell with nodes on pins four numbers a node: its first coordinate, 1 if it lies on a pin, its arm from the pin.

A cell without pins has the coordinates (x, y) of its nodes.  A cell with pins has x, y, theta of the pins, then (x, y)
of its other nodes.  With T = dx/dq, forces on the coordinates are T^T r.

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

Gradient F = sum x g^T, strain E = (F^T F - 1)/2, stress S = C (E + zeta E_dot), forces int F S g, energy int 1/2 E C E.
Source: T. Belytschko, W. K. Liu, B. Moran, Nonlinear Finite Elements for Continua and Structures, Wiley 2000,
sections 4.9 and 6.4.
"""

import math

from flexmb.engine.compiled.arrays import stack_vector
from flexmb.kernels import fast

# Head: number of nodes m, number of pins, formulation, damping time [s], gravity [m/s^2]; PLACES begins the places.
NODES, PINS, FORMULATION, ZETA, GRAVITY_X, GRAVITY_Y, PLACES = range(7)
COROTATED, TOTAL_LAGRANGE = 0.0, 1.0  # formulations
MOST_NODES = 9  # nodes of the largest cell
MOST, MOST_COORDINATES = 2 * MOST_NODES, 3 * MOST_NODES  # displacements of the largest cell; coordinates if all on pins
# Scratch vectors of the kernels: a number a displacement, a coordinate, a pair of displacements.
nodal, on_every_coordinate, square = stack_vector(MOST), stack_vector(MOST_COORDINATES), stack_vector(MOST * MOST)
FIRST, ON_PIN, ARM_X, ARM_Y, TIE = range(5)  # numbers of the tie of a node; TIE is their count


@fast
def mass_at(p):
    """Place of the mass matrix."""
    return PLACES + 2 * int(p[NODES])


@fast
def formulation_at(p):
    """Place of the numbers of the formulation."""
    m = int(p[NODES])
    return PLACES + 2 * m + m * m


@fast
def tie_at(p, k):
    """Place of the tie of node k of a cell with pins."""
    return p.shape[0] - TIE * (int(p[NODES]) - k)


# Nodes of a cell on rigid pins, x = pin + R(theta) arm: places, velocities, accelerations, forces, tangents
@fast
def turned_arms(p, q, arms):
    """Arms (2 m,) of the nodes in world axes, 0 for nodes off the pins."""
    for k in range(int(p[NODES])):
        tie = tie_at(p, k)
        arms[2 * k], arms[2 * k + 1] = 0.0, 0.0
        if p[tie + ON_PIN] > 0.0:
            theta = q[int(p[tie + FIRST]) + 2]
            c, s = math.cos(theta), math.sin(theta)
            arms[2 * k] = c * p[tie + ARM_X] - s * p[tie + ARM_Y]
            arms[2 * k + 1] = s * p[tie + ARM_X] + c * p[tie + ARM_Y]


@fast
def node_places(p, q, arms, x):
    """Places x (2 m,) of the nodes."""
    for k in range(int(p[NODES])):
        i = int(p[tie_at(p, k) + FIRST])
        x[2 * k], x[2 * k + 1] = q[i] + arms[2 * k], q[i + 1] + arms[2 * k + 1]


@fast
def node_rates(p, v, arms, u):
    """u = T v (2 m,)."""
    for k in range(int(p[NODES])):
        tie = tie_at(p, k)
        i = int(p[tie + FIRST])
        spin = v[i + 2] if p[tie + ON_PIN] > 0.0 else 0.0
        u[2 * k], u[2 * k + 1] = v[i] - spin * arms[2 * k + 1], v[i + 1] + spin * arms[2 * k]


@fast
def node_accelerations(p, v, a, arms, u):
    """Accelerations u (2 m,) of the nodes."""
    node_rates(p, a, arms, u)
    for k in range(int(p[NODES])):
        tie = tie_at(p, k)
        spin = v[int(p[tie + FIRST]) + 2] if p[tie + ON_PIN] > 0.0 else 0.0
        u[2 * k] -= spin * spin * arms[2 * k]
        u[2 * k + 1] -= spin * spin * arms[2 * k + 1]


@fast
def on_coordinates(p, arms, f, r):
    """r = T^T f; r is 0 before."""
    for k in range(int(p[NODES])):
        tie = tie_at(p, k)
        i = int(p[tie + FIRST])
        r[i] += f[2 * k]
        r[i + 1] += f[2 * k + 1]
        if p[tie + ON_PIN] > 0.0:
            r[i + 2] += arms[2 * k] * f[2 * k + 1] - arms[2 * k + 1] * f[2 * k]


@fast
def matrix_on_coordinates(p, arms, B, A):
    """A = T^T B T; A is 0 before."""
    m = int(p[NODES])
    for k in range(m):
        tie = tie_at(p, k)
        i, turns = int(p[tie + FIRST]), p[tie + ON_PIN] > 0.0
        ax, ay = arms[2 * k], arms[2 * k + 1]
        for l in range(m):
            other = tie_at(p, l)
            j = int(p[other + FIRST])
            xx, xy = B[2 * k, 2 * l], B[2 * k, 2 * l + 1]
            yx, yy = B[2 * k + 1, 2 * l], B[2 * k + 1, 2 * l + 1]
            A[i, j] += xx
            A[i, j + 1] += xy
            A[i + 1, j] += yx
            A[i + 1, j + 1] += yy
            bx, by = arms[2 * l], arms[2 * l + 1]
            tx, ty = xy * bx - xx * by, yy * bx - yx * by
            if p[other + ON_PIN] > 0.0:
                A[i, j + 2] += tx
                A[i + 1, j + 2] += ty
            if turns:
                A[i + 2, j] += ax * yx - ay * xx
                A[i + 2, j + 1] += ax * yy - ay * xy
                if p[other + ON_PIN] > 0.0:
                    A[i + 2, j + 2] += ax * ty - ay * tx


@fast
def arms_of_pin(p, pin, arms, u):
    """u (2 m,): arms of the nodes on one pin, 0 for all others."""
    for k in range(int(p[NODES])):
        tie = tie_at(p, k)
        own = p[tie + ON_PIN] > 0.0 and int(p[tie + FIRST]) == 3 * pin
        u[2 * k] = arms[2 * k] if own else 0.0
        u[2 * k + 1] = arms[2 * k + 1] if own else 0.0


# Corotated cell: linear elasticity in axes that turn with the mean deformation gradient of the cell
@fast
def deformation_by(p, m, places, gradients, x, d):
    """d (2 m,) of nodes at x (2 m,), relative to the first node; cos, sin of the rotation, and rho."""
    # The places of the nodes and the mean gradients begin at these places of p.
    a, b = 0.0, 0.0
    for k in range(m):
        ex, ey = x[2 * k] - x[0], x[2 * k + 1] - x[1]
        gx, gy = p[gradients + 2 * k], p[gradients + 2 * k + 1]
        a += gx * ex + gy * ey
        b += gx * ey - gy * ex
        d[2 * k], d[2 * k + 1] = ex, ey
    rho = math.sqrt(a * a + b * b)
    c, s = a / rho, b / rho
    for k in range(m):
        ex, ey = d[2 * k], d[2 * k + 1]
        d[2 * k] = c * ex + s * ey - (p[places + 2 * k] - p[places])
        d[2 * k + 1] = c * ey - s * ex - (p[places + 2 * k + 1] - p[places + 1])
    return c, s, rho


@fast
def deformation(p, x, d):
    """`deformation_by` the numbers of a cell."""
    return deformation_by(p, int(p[NODES]), PLACES, formulation_at(p), x, d)


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
        fx, fy = f[2 * k] + moment / rho * p[g + 2 * k + 1], f[2 * k + 1] - moment / rho * p[g + 2 * k]
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
    """Forces r (2 m,) and A = kq dr/dq + kv dr/dv (2 m, 2 m)."""
    # In the turned axes A = stiff K0 - turn K0 J + left w^T + w right^T + turn / rho k g^T with k = K0 J d.
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
    damped, half = stretch / rho * bent - kq * zeta * product(n, k, left), 0.5 * (stiff * bent - kq * along)
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


# Total-Lagrange cell of a St. Venant-Kirchhoff material, integrated by quadrature: the reference for larger strain

# Numbers of the formulation: quadrature points, moduli [Pa]; at each point weight t dA [m^3], gradients (m, 2).
POINTS, C11, C12, C22, C33, FIRST_POINT = range(6)
GX, GY = 1, 2  # gradient of the first node behind the weight of a point


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
