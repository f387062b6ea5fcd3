"""Largest von Mises stress of a reduced plane body, and the node where it acts.

Stresses of the shapes are added up before the von Mises stress is taken.  Groups of nodes whose bound lies below a
stress that was found already are passed by; the result is that of all nodes.
"""

from __future__ import annotations

import math

import numpy as np

from flexmb.compiled.stack import stack_matrix, stack_space
from flexmb.compiled.views import part_of
from flexmb.kernels import extremum_kernel, fast
from flexmb.model.contributions import Coordinate, SignalContribution
from flexmb.reduction.kernel import COUNT, MOST, QD, T1, T2, deformation, end_of, frame_of, shortened
from flexmb.reduction.stress_groups import GROUP, stress_groups

scratch = stack_matrix(QD + MOST, MOST)

GROUPS, METRIC = 0, 1
"""Parameters behind those of the element: number of groups, B (n, n).

Then radii and middle nodes (groups), W of the middle nodes (3, n, groups), nodes (groups, GROUP) and W (groups, 3, n,
GROUP).
"""


@fast
def add_squares(p, at, n, count, e, sums, squares):
    """Set squares to |W e|^2 of `count` nodes, whose W (3, n, count) stands at `at`; sums is for work."""
    for k in range(count):
        squares[k] = 0.0
    for _ in range(3):
        for k in range(count):
            sums[k] = 0.0
        for i in range(n):
            own, row = e[i], part_of(p, at, at + count)
            for k in range(count):
                sums[k] += row[k] * own
            at += count
        for k in range(count):
            squares[k] += sums[k] * sums[k]


@fast
def largest_of(squares, count):
    """Largest of the first `count` squares, or one that is not a number, and its place."""
    largest, where = -1.0, 0
    for k in range(count):
        if not squares[k] <= largest:
            largest, where = squares[k], k
    return largest, where


@fast
def largest_stress(p, q, x):
    """Largest nodal von Mises stress, and the number of its node."""
    n = int(p[COUNT])
    e = part_of(x[T1], 0, n)
    c, s, angle, _ = frame_of(p, q)
    deformation(p, q, c, s, angle, x)
    for i in range(n):
        x[1, i] = 0.0  # d' has no part in stresses
    shortened(p, x, e, part_of(x[T2], 0, n))
    return largest_in_groups(p, end_of(p), n, e)


@fast
def largest_in_groups(p, begin, n, e):
    """Largest nodal von Mises stress of the strains e, and its node; parameters of the stresses stand at `begin`."""
    groups = int(p[begin + GROUPS])
    mean = 0.0
    for i in range(n):
        row = begin + METRIC + i * n
        for j in range(n):
            mean += e[i] * p[row + j] * e[j]
    mean = math.sqrt(max(mean, 0.0))
    radii = begin + METRIC + n * n
    middles = radii + groups
    rows = middles + groups
    nodes = rows + 3 * n * groups
    own = nodes + GROUP * groups
    squares, sums, few = stack_space(groups), stack_space(max(groups, GROUP)), stack_space(GROUP)
    add_squares(p, rows, n, groups, e, sums, squares)
    largest, where = largest_of(squares, groups)
    node = p[middles + where]
    for g in range(groups):
        bound = math.sqrt(squares[g]) + p[radii + g] * mean
        if not bound * bound <= largest:
            add_squares(p, own + 3 * n * GROUP * g, n, GROUP, e, sums, few)
            found, where = largest_of(few, GROUP)
            if not found <= largest:
                largest, node = found, p[nodes + GROUP * g + where]
    return math.sqrt(largest), node


@extremum_kernel
def peak_stress_kernel(p, t, q, v, a):
    """Largest nodal von Mises stress [Pa], and the number of its node."""
    return largest_stress(p, q, scratch())


def peak_stress_signal(
    part: str,
    coordinates: tuple[Coordinate, ...],
    element: tuple[float, ...],
    points: np.ndarray,
    stresses: np.ndarray,
) -> SignalContribution:
    """The signals `von_mises` and `von_mises_node` of a body.

    Parameters
    ----------
    part : name of the body.
    coordinates : coordinates of the element.
    element : parameters of the element.
    points : (nodes, 2) of the mesh [m].
    stresses : (nodes, 4, n) sx, sy, txy, sz in the axes of the body, by its coordinates [Pa/m, Pa/rad].
    """
    found = stress_groups(points, stresses)
    middle, own = found.rows[found.middle], found.rows[found.order]
    blocks = (
        found.metric, found.radius, found.middle, middle.transpose(1, 2, 0), found.order, own.transpose(0, 2, 3, 1),
    )  # fmt: skip
    numbers = np.concatenate([block.ravel() for block in blocks]).tolist()
    p = (*element, float(len(found.radius)), *numbers)
    return SignalContribution(part, "von_mises", "Pa", peak_stress_kernel, coordinates, p, place="von_mises_node")
