"""Kernels of loads on the nodes of a mesh: forces, dead or turning with a pin, and stresses that follow edges.

A force on a node, or the sum of forces f_k on the nodes of a rigid pin with the arms a_k: with beta, the direction of
the axes in which f is given, and gamma, the angle of the pin,

    F = R(beta) sum f_k,     M = sum R(gamma) a_k x R(beta) f_k = cos(beta - gamma) X + sin(beta - gamma) D

with X = sum a_k x f_k and D = sum a_k . f_k.  Equation (11.12) of docs/theory/plane_bodies.md.

An edge with the places x_l of its nodes and the products P of a pressure and S of a shear: f_k = (P_kl J + S_kl) x_l.
It is linear in x, so the tangent is constant but for the arms of pins.  Equation (11.13).
"""

import math

from flexmb.compiled.views import matrix_view, part_of
from flexmb.kernels import element_kernel, fast, signal_kernel
from flexmb.planes.cell_numbers import FIRST, NODES, ON_PIN, nodal, on_every_coordinate, square, tie_at
from flexmb.planes.pinned import matrix_on_coordinates, node_places, on_coordinates, turned_arms

FORCE_X, FORCE_Y, CROSS, ALONG, ANGLE, OWN, TURNING, NODE_NUMBERS = range(8)
"""Numbers p of a force on a node: sum of f, X, D, beta where nothing turns; coordinates of gamma and of beta, or -1."""

PRODUCTS = 2
"""Place of the products of an edge (m, m, 2), behind the numbers of nodes and pins; then the ties."""

P, S, PAIR = range(3)
"""Products of a pressure and of a shear for a pair of nodes, and their number."""

ON_EDGES, FIRST_ELEMENT = range(2)
"""Numbers p of a signal: 1 for edges; then of each element, and at the end the number of the signal."""

COORDINATES, SIZE, NUMBERS = range(3)
"""Numbers of an element of a signal: those of its coordinates and of its own numbers, which follow."""

POWER = 2
"""Number of the signal `power`; those of fx and fy are 0 and 1."""

SIGNALS = (("fx", "N"), ("fy", "N"), ("power", "W"))
"""Signals of a load on a mesh with their units."""


@fast
def node_force(p, q, r):
    """Residual r (n,) of a force on a node; cosine and sine of beta - gamma are returned."""
    own, turning = int(p[OWN]), int(p[TURNING])
    beta = q[turning] if turning >= 0 else p[ANGLE]
    c, s = math.cos(beta), math.sin(beta)
    for i in range(r.shape[0]):
        r[i] = 0.0
    r[0] = s * p[FORCE_Y] - c * p[FORCE_X]
    r[1] = -s * p[FORCE_X] - c * p[FORCE_Y]
    if own < 0:
        return 1.0, 0.0
    c, s = math.cos(beta - q[own]), math.sin(beta - q[own])
    r[own] = -c * p[CROSS] - s * p[ALONG]
    return c, s


@element_kernel
def node_force_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Force on a node (x, y), further coordinates are angles; r (n,), K (n, n)."""
    c, s = node_force(p, q, r)
    own, turning = int(p[OWN]), int(p[TURNING])
    if turning >= 0:
        K[0, turning], K[1, turning] = -r[1], r[0]
    if own >= 0 and own != turning:
        slope = s * p[CROSS] - c * p[ALONG]
        K[own, own] = -slope
        if turning >= 0:
            K[own, turning] = slope


@fast
def edge_forces(p, x, f):
    """Forces f (2 m,) on the nodes of an edge at the places x (2 m,)."""
    m = int(p[NODES])
    for k in range(m):
        fx, fy = 0.0, 0.0
        for l in range(m):
            at = PRODUCTS + PAIR * (k * m + l)
            normal, along = p[at + P], p[at + S]
            fx += along * x[2 * l] - normal * x[2 * l + 1]
            fy += along * x[2 * l + 1] + normal * x[2 * l]
        f[2 * k], f[2 * k + 1] = fx, fy


@fast
def edge_force(p, q, arms, f, r):
    """Arms, forces f (2 m,), residual r (n,) of an edge."""
    x = nodal()
    turned_arms(p, q, arms)
    node_places(p, q, arms, x)
    edge_forces(p, x, f)
    for i in range(2 * int(p[NODES])):
        f[i] = -f[i]
    for i in range(r.shape[0]):
        r[i] = 0.0
    on_coordinates(p, arms, f, r)


@fast
def edge_tangent(p, q, r, K):
    """Residual r (n,) and tangent K (n, n) of an edge."""
    arms, f = nodal(), nodal()
    edge_force(p, q, arms, f, r)
    m = int(p[NODES])
    B = matrix_view(square(), 2 * m, 2 * m)
    for k in range(m):
        for l in range(m):
            at = PRODUCTS + PAIR * (k * m + l)
            normal, along = p[at + P], p[at + S]
            B[2 * k, 2 * l], B[2 * k, 2 * l + 1] = -along, normal
            B[2 * k + 1, 2 * l], B[2 * k + 1, 2 * l + 1] = -normal, -along
    matrix_on_coordinates(p, arms, B, K)
    for k in range(m):
        tie = tie_at(p, k)
        if p[tie + ON_PIN] > 0.0:
            theta = int(p[tie + FIRST]) + 2
            K[theta, theta] -= arms[2 * k] * f[2 * k] + arms[2 * k + 1] * f[2 * k + 1]


@element_kernel
def edge_force_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Pressure and shear on an edge, which follow it; r (n,), K (n, n)."""
    edge_tangent(p, q, r, K)


@fast
def total(p, q, v):
    """Force along x or y, or power, of all elements of a load."""
    last = p.shape[0] - 1
    on_edges, number, at, first, found = p[ON_EDGES] > 0.0, int(p[last]), FIRST_ELEMENT, 0, 0.0
    arms, f, r = nodal(), nodal(), on_every_coordinate()
    while at < last:
        n, begin = int(p[at + COORDINATES]), at + NUMBERS
        end = begin + int(p[at + SIZE])
        own, coordinates, rows = part_of(p, begin, end), part_of(q, first, first + n), part_of(r, 0, n)
        if on_edges:
            edge_force(own, coordinates, arms, f, rows)
        else:
            node_force(own, coordinates, rows)
        if number == POWER:
            for i in range(n):
                found -= rows[i] * v[first + i]
        elif on_edges:
            for k in range(int(own[NODES])):
                found -= f[2 * k + number]
        else:
            found -= rows[number]
        at, first = end, first + n
    return found


@signal_kernel
def mesh_load_signal(p, t, q, v, a):
    """Force along x or y, or power, of a load; p: 1 for edges, then n, size and p of each element, number of signal."""
    return total(p, q, v)
