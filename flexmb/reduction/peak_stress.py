"""Largest von Mises stress of a reduced plane body, and the node where it acts.

Stresses of the shapes are added up before the von Mises stress is taken, many nodes side by side.
"""

from __future__ import annotations

import math

import numpy as np

from flexmb.compiled.stack import stack_matrix, stack_vector
from flexmb.compiled.views import part_of
from flexmb.kernels import extremum_kernel, fast
from flexmb.model.contributions import Coordinate, SignalContribution
from flexmb.planes.peak_stress import von_mises_square
from flexmb.reduction.kernel import COUNT, MOST, QD, T1, T2, deformation, end_of, frame_of, shortened

scratch = stack_matrix(QD + MOST, MOST)

NODES, PARTS, STRESSES = range(3)
"""Parameters behind those of the element: number of nodes; of stresses sx, sy, txy, sz, without those at the end
that are zero at all nodes.

At STRESSES, for every LANES nodes: of each coordinate these stresses of the nodes side by side; zeros after the last.
"""

LANES = 16
"""Number of nodes side by side."""

SX, SY, TXY, SZ = range(0, 4 * LANES, LANES)
"""Places of the stresses of the nodes side by side, among all of them."""

side_by_side = stack_vector(4 * LANES)


@fast
def add_stresses(p, at, e, n, size, S):
    """Set S (size,) = stresses of nodes side by side, by the deformation e (n,), of which e[0] = e[1] = 0."""
    for k in range(size):
        S[k] = p[at + 2 * size + k] * e[2]
    for i in range(3, n, 3):
        first, second, third = at + i * size, at + (i + 1) * size, at + (i + 2) * size
        e1, e2, e3 = e[i], e[i + 1], e[i + 2]
        for k in range(size):
            S[k] += p[first + k] * e1 + p[second + k] * e2 + p[third + k] * e3


@fast
def largest_stress(p, q, x):
    """Largest nodal von Mises stress, and the number of its node."""
    n, S = int(p[COUNT]), side_by_side()
    e = part_of(x[T1], 0, n)
    c, s, angle, _ = frame_of(p, q)
    deformation(p, q, c, s, angle, x)
    for i in range(n):
        x[1, i] = 0.0  # d' has no part in stresses
    shortened(p, x, e, part_of(x[T2], 0, n))
    begin = end_of(p)
    nodes, size = int(p[begin + NODES]), LANES * int(p[begin + PARTS])
    for k in range(size, 4 * LANES):
        S[k] = 0.0
    largest, where, at = -1.0, 0, begin + STRESSES
    for first in range(0, nodes, LANES):
        add_stresses(p, at, e, n, size, S)
        at += n * size
        for k in range(LANES):
            S[SX + k] = von_mises_square(S[SX + k], S[SY + k], S[TXY + k], S[SZ + k])
        for k in range(min(LANES, nodes - first)):
            if not S[k] <= largest:  # also what is not a number
                largest, where = S[k], first + k
    return math.sqrt(largest), float(where)


@extremum_kernel
def peak_stress_kernel(p, t, q, v, a):
    """Largest nodal von Mises stress [Pa], and the number of its node."""
    return largest_stress(p, q, scratch())


def peak_stress_signal(
    part: str, coordinates: tuple[Coordinate, ...], element: tuple[float, ...], stresses: np.ndarray
) -> SignalContribution:
    """The signals `von_mises` and `von_mises_node` of a body.

    Parameters
    ----------
    part : name of the body.
    coordinates : coordinates of the element.
    element : parameters of the element.
    stresses : (nodes, 4, n) sx, sy, txy, sz in the axes of the body, by its coordinates [Pa/m, Pa/rad].
    """
    count, _, n = stresses.shape
    parts, groups = 1 + int(np.flatnonzero(stresses.any(axis=(0, 2)))[-1]), -(-count // LANES)
    padded = np.zeros((groups * LANES, parts, n))
    padded[:count] = stresses[:, :parts]
    own = padded.reshape(groups, LANES, parts, n).transpose(0, 3, 2, 1)
    p = (*element, float(count), float(parts), *own.ravel().tolist())
    return SignalContribution(part, "von_mises", "Pa", peak_stress_kernel, coordinates, p, place="von_mises_node")
