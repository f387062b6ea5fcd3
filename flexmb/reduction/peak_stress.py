"""Signal of the largest von Mises stress of a reduced plane body, and of the node where it acts.

Stresses of the shapes are added up before the von Mises stress is taken.
"""

from __future__ import annotations

import math

import numpy as np

from flexmb.compiled.stack import stack_matrix
from flexmb.compiled.views import part_of
from flexmb.kernels import fast, signal_kernel
from flexmb.model.contributions import Coordinate, SignalContribution
from flexmb.reduction.kernel import COUNT, MOST, QD, T1, T2, deformation, end_of, frame_of, shortened

scratch = stack_matrix(QD + MOST, MOST)

NODES, STRESSES = 0, 1
"""Parameters behind those of the element: number of nodes, then sx, sy, txy, sz of each node by the coordinates.

Last: 0 for the stress, 1 for the node.
"""


@fast
def largest_stress(p, q, x):
    """Largest nodal von Mises stress and its node."""
    n = int(p[COUNT])
    c, s, angle, _ = frame_of(p, q)
    deformation(p, q, c, s, angle, x)
    for i in range(n):
        x[1, i] = 0.0  # d' has no part in stresses
    shortened(p, x, part_of(x[T1], 0, n), part_of(x[T2], 0, n))
    begin = end_of(p)
    largest, where, at = -1.0, 0, begin + STRESSES
    for k in range(int(p[begin + NODES])):
        sx, sy, t, sz = 0.0, 0.0, 0.0, 0.0
        for i in range(n):
            e = x[T1, i]
            sx += p[at + i] * e
            sy += p[at + n + i] * e
            t += p[at + 2 * n + i] * e
            sz += p[at + 3 * n + i] * e
        at += 4 * n
        a, b, d = sx - sy, sy - sz, sz - sx
        found = 0.5 * (a * a + b * b + d * d) + 3.0 * t * t
        if not found <= largest:  # also what is not a number
            largest, where = found, k
    return math.sqrt(largest), where


@signal_kernel
def peak_stress_kernel(p, t, q, v, a):
    """Largest nodal von Mises stress [Pa], or the number of its node."""
    largest, where = largest_stress(p, q, scratch())
    return largest if p[p.shape[0] - 1] == 0.0 else float(where)


def peak_stress_signals(
    part: str, coordinates: tuple[Coordinate, ...], element: tuple[float, ...], stresses: np.ndarray
) -> list[SignalContribution]:
    """The signals `von_mises` and `von_mises_node` of a body.

    Parameters
    ----------
    part : name of the body.
    coordinates : coordinates of the element.
    element : parameters of the element.
    stresses : (nodes, 4, n) sx, sy, txy, sz in the axes of the body, by its coordinates [Pa/m, Pa/rad].
    """
    p = (*element, float(len(stresses)), *stresses.ravel().tolist())
    return [
        SignalContribution(part, "von_mises", "Pa", peak_stress_kernel, coordinates, (*p, 0.0)),
        SignalContribution(
            part, "von_mises_node", "", peak_stress_kernel, coordinates, (*p, 1.0), is_mode=True, place_of="von_mises"
        ),
    ]
