"""Nodes of a cell on rigid pins, x = pin + R(theta) arm: places, velocities, accelerations, forces, tangents.

A cell without pins has the coordinates (x, y) of its nodes.  A cell with pins has x, y, theta of the pins, then (x, y)
of its other nodes.  With T = dx/dq, forces on the coordinates are T^T r.
"""

import math

from flexmb.kernels import fast
from flexmb.planes.cell_numbers import ARM_X, ARM_Y, FIRST, NODES, ON_PIN, PINS, tie_at


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


@fast
def pins_of(p):
    """Number of pins of a cell."""
    return int(p[PINS])
