"""Largest von Mises stress of a plane body with all nodes of its mesh, and the node where it acts.

Stresses are recovered as by `recovery`: in the axes of each cell, averaged over the cells of a node.
"""

from __future__ import annotations

import math

import numpy as np

from flexmb.compiled.stack import stack_space
from flexmb.kernels import extremum_kernel, fast
from flexmb.model.contributions import Coordinate, SignalContribution
from flexmb.planes.cell_numbers import nodal
from flexmb.planes.recovery import areas_and_means, around_nodes, gradients_at_nodes

NODES, WIDTH, CELLS, HEAD = range(4)
"""Parameters p: number of nodes, nodes of a cell, cells.

At HEAD: (nodes, 5) first coordinate, 1 on a pin, arm x, arm y, 1 / area of its cells; (cells, ...) nodes, places X,
mean gradients, gradients at the nodes, d11, d12, d33 times area, sz over sx + sy."""

COORDINATE, ON_PIN, ARM_X, ARM_Y, SHARE, PER_NODE = range(6)
"""Numbers of a node; PER_NODE is their count."""

D11, D12, D33, ACROSS = range(4)
"""Numbers of the material of a cell."""

XX, YY, XY, ZZ, PARTS = range(5)
"""Components of a stress; PARTS is their count."""


@fast
def fill_places(p, q, n, x):
    """Places x (2 n,) of all nodes."""
    for k in range(n):
        at = HEAD + PER_NODE * k
        i = int(p[at + COORDINATE])
        x[2 * k], x[2 * k + 1] = q[i], q[i + 1]
        if p[at + ON_PIN] > 0.0:
            c, s = math.cos(q[i + 2]), math.sin(q[i + 2])
            x[2 * k] += c * p[at + ARM_X] - s * p[at + ARM_Y]
            x[2 * k + 1] += s * p[at + ARM_X] + c * p[at + ARM_Y]


@fast
def deformation(p, x, cell, m, d):
    """d (2 m,) of the nodes of a cell in its own axes, from its first node; cosine and sine of its rotation."""
    first = 2 * int(p[cell])
    x0, y0, g, X = x[first], x[first + 1], cell + 3 * m, cell + m
    a, b = 0.0, 0.0
    for j in range(m):
        i = 2 * int(p[cell + j])
        dx, dy = x[i] - x0, x[i + 1] - y0
        gx, gy = p[g + 2 * j], p[g + 2 * j + 1]
        a += gx * dx + gy * dy
        b += gx * dy - gy * dx
        d[2 * j], d[2 * j + 1] = dx, dy
    size = math.sqrt(a * a + b * b)
    c, s = a / size, b / size
    for j in range(m):
        dx, dy = d[2 * j], d[2 * j + 1]
        d[2 * j] = c * dx + s * dy - (p[X + 2 * j] - p[X])
        d[2 * j + 1] = c * dy - s * dx - (p[X + 2 * j + 1] - p[X + 1])
    return c, s


@fast
def add_stresses(p, x, cell, m, S):
    """Add the shares of one cell to the stresses S (4 n,) of its nodes: sx, sy, txy in world axes, sz."""
    d = nodal()
    c, s = deformation(p, x, cell, m, d)
    cc, ss, cs = c * c, s * s, c * s
    own, at = cell + 5 * m, cell + 5 * m + 2 * m * m
    for k in range(m):
        xx, yy, shear = 0.0, 0.0, 0.0
        for j in range(m):
            gx, gy = p[own + 2 * j], p[own + 2 * j + 1]
            xx += gx * d[2 * j]
            yy += gy * d[2 * j + 1]
            shear += gy * d[2 * j] + gx * d[2 * j + 1]
        own += 2 * m
        node = int(p[cell + k])
        share = p[HEAD + PER_NODE * node + SHARE]
        sx, sy = share * (p[at + D11] * xx + p[at + D12] * yy), share * (p[at + D12] * xx + p[at + D11] * yy)
        t = share * p[at + D33] * shear
        S[PARTS * node + XX] += cc * sx + ss * sy - 2.0 * cs * t
        S[PARTS * node + YY] += ss * sx + cc * sy + 2.0 * cs * t
        S[PARTS * node + XY] += cs * (sx - sy) + (cc - ss) * t
        S[PARTS * node + ZZ] += p[at + ACROSS] * (sx + sy)


@fast
def von_mises_square(sx, sy, t, sz):
    """Square of the von Mises stress."""
    a, b, c = sx - sy, sy - sz, sz - sx
    return 0.5 * (a * a + b * b + c * c) + 3.0 * t * t


@fast
def largest_stress(p, q):
    """Largest nodal von Mises stress, and the number of its node."""
    n, m = int(p[NODES]), int(p[WIDTH])
    x, S = stack_space(2 * n), stack_space(PARTS * n)
    fill_places(p, q, n, x)
    for i in range(PARTS * n):
        S[i] = 0.0
    size = 5 * m + 2 * m * m + 4
    for k in range(int(p[CELLS])):
        add_stresses(p, x, HEAD + PER_NODE * n + size * k, m, S)
    largest, where = -1.0, 0
    for k in range(n):
        at = PARTS * k
        found = von_mises_square(S[at + XX], S[at + YY], S[at + XY], S[at + ZZ])
        if not found <= largest:  # also what is not a number
            largest, where = found, k
    return math.sqrt(largest), float(where)


@extremum_kernel
def peak_stress_kernel(p, t, q, v, a, least):
    """Largest nodal von Mises stress [Pa], and the number of its node."""
    return largest_stress(p, q)


def peak_stress_signal(
    part: str,
    coordinates: tuple[Coordinate, ...],
    ties: np.ndarray,
    points: np.ndarray,
    cells: np.ndarray,
    kind: str,
    materials: np.ndarray,
) -> SignalContribution:
    """The signals `von_mises` and `von_mises_node` of cells (m, k), by places `points` (nodes, 2) without stress [m].

    `ties` (nodes, 4) are first coordinate of each node, 1 on a pin, arm x, arm y; `materials` (m, 4) are d11, d12, d33
    [Pa], and sz over sx + sy.
    """
    m, k = cells.shape
    areas, mean = areas_and_means(points, cells, kind)
    weighted = materials * np.column_stack([areas, areas, areas, np.ones(m)])
    own = (
        cells, points[cells].reshape(m, -1), mean.reshape(m, -1),
        gradients_at_nodes(points, cells, kind).reshape(m, -1), weighted,
    )  # fmt: skip
    per_node = np.column_stack([ties, 1.0 / around_nodes(cells, areas, len(points))])
    numbers = np.concatenate([(len(points), k, m), per_node.ravel(), np.hstack(own).ravel()]).tolist()
    return SignalContribution(
        part, "von_mises", "Pa", peak_stress_kernel, coordinates, tuple(numbers), place="von_mises_node"
    )
