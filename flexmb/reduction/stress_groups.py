"""Nodes of a mesh in groups whose stresses are bounded, so that the search for the largest one passes most of them by.

Von Mises stresses are lengths of vectors, w = W e, of three rows a node.  In a group around the node r

    |W_i e| <= |W_r e| + R sqrt(e B e),   R = max_i |(W_i - W_r) C^-T|,   B = C C^T

for any B; here sqrt(e B e) is the root mean square of the von Mises stresses of all nodes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

Array = npt.NDArray[np.float64]

GROUP = 16
"""Number of nodes of a group."""

LEAST_SHARE = 1e-12
"""Share of the identity that is added to the scaled B [1], which is singular for rigid motions."""

SLACK = 1e-9
"""Relative amount by which the radii of groups are raised, for round-off."""


@dataclass(frozen=True, eq=False)
class StressGroups:
    """Stresses of the nodes of a mesh by groups.

    Parameters
    ----------
    order : (groups, GROUP) numbers of the nodes; a last group that is not full repeats one of its nodes.
    middle : (groups,) numbers of the nodes r.
    radius : (groups,) R.
    metric : (n, n) B.
    rows : (nodes, 3, n) W.
    """

    order: npt.NDArray[np.int64]
    middle: npt.NDArray[np.int64]
    radius: Array
    metric: Array
    rows: Array


def stress_groups(points: Array, stresses: Array) -> StressGroups:
    """Groups of neighbouring nodes.

    Parameters
    ----------
    points : (nodes, 2) [m].
    stresses : (nodes, 4, n) sx, sy, txy, sz by the coordinates.
    """
    sx, sy, t, sz = np.moveaxis(stresses, 1, 0)
    # vm^2 = ((sx + sy) / 2 - sz)^2 + 3 ((sx - sy) / 2)^2 + 3 t^2
    rows = np.stack([0.5 * (sx + sy) - sz, math.sqrt(0.75) * (sx - sy), math.sqrt(3.0) * t], axis=1)
    n = rows.shape[2]
    metric = np.einsum("kri,krj->ij", rows, rows) / len(rows)
    scale = np.sqrt(np.diag(metric))
    scale[scale == 0.0] = 1.0
    metric = (metric / np.outer(scale, scale) + LEAST_SHARE * n * np.eye(n)) * np.outer(scale, scale)
    root = la.cholesky(metric, lower=True)
    seen = la.solve_triangular(root, rows.reshape(-1, n).T, lower=True).T.reshape(rows.shape)
    order = np.concatenate(neighbours(np.arange(len(points)), points))
    order = np.concatenate([order, np.repeat(order[-1:], -len(order) % GROUP)]).reshape(-1, GROUP)
    own = seen[order]
    middle = np.linalg.norm(own - own.mean(axis=1, keepdims=True), axis=(2, 3)).argmin(axis=1)
    away = own - own[np.arange(len(own)), middle][:, None]
    radius = np.linalg.norm(away, ord=2, axis=(2, 3)).max(axis=1) * (1.0 + SLACK)
    return StressGroups(order, order[np.arange(len(order)), middle], radius, metric, rows)


def neighbours(nodes: npt.NDArray[np.int64], points: Array) -> list[npt.NDArray[np.int64]]:
    """Nodes cut across their longer extent, again and again, into groups of `GROUP`, the last one of those left.

    Parameters
    ----------
    nodes : numbers of nodes.
    points : (all nodes, 2) [m].
    """
    if len(nodes) <= GROUP:
        return [nodes]
    own = points[nodes]
    sorted_nodes = nodes[np.argsort(own[:, np.ptp(own, axis=0).argmax()], kind="stable")]
    cut = GROUP * math.ceil(len(nodes) / GROUP / 2)
    return [*neighbours(sorted_nodes[:cut], points), *neighbours(sorted_nodes[cut:], points)]
