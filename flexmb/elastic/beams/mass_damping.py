"""Mass-proportional damping of an element of a flexible body, on the velocity of deformation: kernels, their numbers.

The body's frame has its origin in the node A and its x axis towards the node B; alpha is the direction from A to B.
For the nodes k of the element, those that turn first, the deformation is dk = R(alpha)^T (xk - xA) and, of a node that
turns, thetak - alpha (constant parts have no rate).  The force is r = zeta J^T m J v with J = dd/dq, which no rigid
motion has, and m the consistent mass of the element in the axes of the frame.

In these axes, with S v = (vk - vA, thetak_dot), g = (D dk, -1), D = [[0, 1], [-1, 0]], t = d(alpha)/dq and
H = d2(alpha)/dq2, J = S + g t^T.  Both tangents follow by the product rule, without omissions.
Equation (3.10) of docs/theory/inertia.md.  Equation (11.11) of docs/theory/plane_bodies.md.
"""

import math

import numpy as np

from flexmb.engine.compiled.arrays import stack_vector
from flexmb.kernels import compiled, element_kernel
from flexmb.model.contributions import Coordinate, ElementContribution
from flexmb.model.massless import MOST, massless

ZETA, TURNING, MASSES = range(3)  # parameters p: damping rate zeta, number of nodes that turn, then m (n, n)
POINTS = 4  # number of the coordinates of A and B, the first ones
scratch = stack_vector(MOST)  # vector on A, B and the nodes; of d, d_dot, forces on them the nodes alone count


@compiled
def after(p, i):
    """First coordinate of the point or node behind the one that begins at i."""
    return i + 3 if POINTS <= i < POINTS + 3 * int(p[TURNING]) else i + 2


@compiled
def turned(p, n, x, target):
    """Set target = D x."""
    i = POINTS
    while i < n:
        target[i], target[i + 1], end = x[i + 1], -x[i], after(p, i)
        if end == i + 3:
            target[i + 2] = 0.0
        i = end


@compiled
def dot(n, x, y):
    """Scalar product of two vectors on the nodes."""
    total = 0.0
    for i in range(POINTS, n):
        total += x[i] * y[i]
    return total


@compiled
def mass_times(p, n, x, target):
    """Set target = m x."""
    for i in range(n - POINTS):
        row, total = MASSES + i * (n - POINTS), 0.0
        for j in range(n - POINTS):
            total += p[row + j] * x[POINTS + j]
        target[POINTS + i] = total


@compiled
def deformation_rate(p, q, v, g, u):
    """Fill g and u = d_dot; frame (l, cos, sin), alpha_dot, its derivatives by A along and across AB."""
    dx, dy = q[2] - q[0], q[3] - q[1]
    l = math.sqrt(dx * dx + dy * dy)
    c, s = dx / l, dy / l
    wx, wy = v[2] - v[0], v[3] - v[1]
    stretch, rate = (c * wx + s * wy) / l, (c * wy - s * wx) / l
    i = POINTS
    while i < q.shape[0]:
        x, y, vx, vy = q[i] - q[0], q[i + 1] - q[1], v[i] - v[0], v[i + 1] - v[1]
        g[i], g[i + 1], end = c * y - s * x, -c * x - s * y, after(p, i)
        u[i], u[i + 1] = rate * g[i] + (c * vx + s * vy), rate * g[i + 1] + (c * vy - s * vx)
        if end == i + 3:
            g[i + 2], u[i + 2] = -1.0, v[i + 2] - rate
        i = end
    return l, c, s, rate, rate / l, stretch / l


@compiled
def balance(p, n, k, l, y):
    """Complete y = S^T y + k t: forces on A and B."""
    x_sum, y_sum, i = 0.0, 0.0, POINTS
    while i < n:
        x_sum -= y[i]
        y_sum -= y[i + 1]
        i = after(p, i)
    y[0], y[1], y[2], y[3] = x_sum, y_sum - k / l, 0.0, k / l


@compiled
def put_force(p, q, v, r):
    """r (n,), and energies: nothing stored, the power of damping."""
    g, u, f, n, i = scratch(), scratch(), scratch(), q.shape[0], 0
    l, c, s, _, _, _ = deformation_rate(p, q, v, g, u)
    mass_times(p, n, u, f)
    balance(p, n, dot(n, f, g), l, f)
    while i < n:
        r[i], r[i + 1], end = p[ZETA] * (c * f[i] - s * f[i + 1]), p[ZETA] * (s * f[i] + c * f[i + 1]), after(p, i)
        if end == i + 3:
            r[i + 2] = p[ZETA] * f[i + 2]
        i = end
    return 0.0, 0.0, p[ZETA] * dot(n, u, f)


@compiled
def fill_blocks(p, rate, K, C):
    """C = S^T m S and K = rate S^T m D S."""
    n = K.shape[0]
    for i in range(POINTS, n):
        row = MASSES + (i - POINTS) * (n - POINTS) - POINTS
        for j in range(POINTS, n):
            C[i, j] = p[row + j]
        j = POINTS
        while j < n:
            K[i, j], K[i, j + 1] = -rate * C[i, j + 1], rate * C[i, j]
            j = after(p, j)
    for X in (K, C):
        i = POINTS
        while i < n:
            for j in range(POINTS, n):
                X[0, j] -= X[i, j]
                X[1, j] -= X[i + 1, j]
            i = after(p, i)
        for i in range(n):
            j = POINTS
            while j < n:
                X[i, 0] -= X[i, j]
                X[i, 1] -= X[i, j + 1]
                j = after(p, j)


@compiled
def add_product(y, hx, hy, X):
    """X += y h^T, where h has the entries hx, hy of A and the opposite ones of B."""
    for i in range(X.shape[0]):
        X[i, 0] += y[i] * hx
        X[i, 1] += y[i] * hy
        X[i, 2] -= y[i] * hx
        X[i, 3] -= y[i] * hy


@compiled
def finish(p, c, s, X):
    """X times zeta, with rows and columns turned from the axes of the frame into the axes of the plane."""
    n, k = X.shape[0], 0
    while k < n:
        for j in range(n):
            x, y = X[k, j], X[k + 1, j]
            X[k, j], X[k + 1, j] = c * x - s * y, s * x + c * y
        k = after(p, k)
    for i in range(n):
        k = 0
        while k < n:
            x, y = X[i, k], X[i, k + 1]
            X[i, k], X[i, k + 1] = c * x - s * y, s * x + c * y
            k = after(p, k)
        for j in range(n):
            X[i, j] *= p[ZETA]


@element_kernel
def mass_damping_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Damping of d_dot; q = A, B (x, y), then the nodes; r (n,), K, C (n, n), M = 0."""
    put_force(p, q, v, r)
    g, u, f, x, y, Df, work, n = scratch(), scratch(), scratch(), scratch(), scratch(), scratch(), scratch(), q.shape[0]
    l, c, s, rate, hx, hy = deformation_rate(p, q, v, g, u)
    mass_times(p, n, u, f)
    mass_times(p, n, g, x)
    turned(p, n, u, work)
    mass_times(p, n, work, y)
    fill_blocks(p, rate, K, C)
    # C = S^T m S + J^T m g t^T + t (S^T m g)^T
    balance(p, n, dot(n, g, x), l, x)
    add_product(x, 0.0, -1.0 / l, C)
    # K = J^T m d(d_dot)/dq + d(J^T f)/dq, d(d_dot)/dq = rate D S + D d_dot t^T + g h^T, h = d(rate)/dq
    turned(p, n, f, Df)
    turned(p, n, g, work)
    k = dot(n, g, y) + dot(n, f, work)
    for i in range(POINTS, n):
        y[i] -= Df[i]
    balance(p, n, k, l, y)
    add_product(y, 0.0, -1.0 / l, K)
    add_product(x, hx, hy, K)
    balance(p, n, 0.0, l, x)
    turned(p, n, x, work)
    for i in range(POINTS, n):
        work[i] = rate * work[i] + Df[i]
    balance(p, n, 0.0, l, work)
    for j in range(n):
        C[1, j] -= x[j] / l
        C[3, j] += x[j] / l
        K[1, j] += work[j] / l
        K[3, j] -= work[j] / l
    h = dot(n, f, g) / (l * l)
    for i, j, k in ((0, 1, -h), (2, 3, -h), (0, 3, h), (1, 2, h)):  # f.g H
        K[i, j] += k
        K[j, i] += k
    finish(p, c, s, K)
    finish(p, c, s, C)


MASS_DAMPING = massless("MASS_DAMPING", globals(), mass_damping_kernel)


def damping_element(
    part: str, coordinates: tuple[Coordinate, ...], zeta: float, turning: int, mass: np.ndarray, angle: float
) -> ElementContribution:
    """Damping of an element at a rate zeta [1/s] by the coordinates of A, of B and of its nodes."""
    # `turning` is the number of its nodes that turn, which come first; `mass` (n, n) lies in axes that have the
    # direction `angle` [rad] against the line from A to B in the reference configuration.
    c, s, turn = math.cos(angle), math.sin(angle), np.eye(len(mass))
    for k in (*range(0, 3 * turning, 3), *range(3 * turning, len(mass), 2)):
        turn[k : k + 2, k : k + 2] = [[c, -s], [s, c]]
    p = (float(zeta), float(turning), *(turn @ mass @ turn.T).ravel().tolist())
    return MASS_DAMPING.contribution(part, coordinates, p)
