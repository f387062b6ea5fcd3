"""Boundary of a plane mesh: edges of one cell alone, closed loops, holes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from flexmb.planes.cell_kinds import KINDS

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Edges:
    """Edges of all cells, each edge once.

    Attributes
    ----------
    nodes : (e, 2) or (e, 3) first node, last node and middle of each edge, as its first cell has it on the left.
    cells : (e, 2) both cells of an edge; -1 for the missing one of a boundary edge.
    counts : (e,) number of cells of each edge.
    folded : (e,) whether the first two cells of an edge lie on the same side of it.
    """

    nodes: Indices
    cells: Indices
    counts: Indices
    folded: npt.NDArray[np.bool_]

    @property
    def boundary(self) -> Indices:
        """(b, 2) or (b, 3) nodes of the edges of the boundary, with the body on the left."""
        found: Indices = self.nodes[self.counts == 1]
        return found


def edges_of(cells: Indices, kind: str) -> Edges:
    """All edges of cells (m, k) of one kind."""
    local = np.array(KINDS[kind].edges)
    every = cells[:, local]  # (m, edges a cell, nodes an edge)
    owner = np.repeat(np.arange(len(cells)), len(local))
    every = every.reshape(-1, local.shape[1])
    ends = np.sort(every[:, :2], axis=1)
    key = ends[:, 0] * (int(cells.max()) + 1) + ends[:, 1]
    order = np.argsort(key, kind="stable")
    first = np.flatnonzero(np.diff(key[order], prepend=-1))
    counts = np.diff(np.append(first, len(key)))
    second = order[np.minimum(first + 1, len(key) - 1)]
    cells_of = np.stack([owner[order[first]], np.where(counts > 1, owner[second], -1)], axis=1)
    folded = (counts > 1) & (every[order[first], 0] == every[second, 0])
    return Edges(every[order[first]], cells_of, counts, folded)


def loops_of(boundary: Indices) -> list[Indices]:
    """Closed loops of boundary edges: nodes in order, middles between their corners, the body on the left.

    A node at which more than two boundary edges meet ends a loop early; `PlaneMesh` refuses such meshes.  The edges are
    (b, 2) or (b, 3) nodes.
    """
    after = dict(zip(boundary[:, 0].tolist(), boundary.tolist(), strict=True))
    loops = []
    while after:
        node, nodes = next(iter(after)), []
        while node in after:
            edge = after.pop(node)
            nodes += [edge[0], *edge[2:]]
            node = edge[1]
        loops.append(np.array(nodes, dtype=np.int64))
    return loops


def area_inside(points: Array) -> float:
    """Signed area of a polygon with corners (n, 2) [m], in m^2; > 0 counter-clockwise."""
    x, y = (points - points[0]).T
    return float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def tributary_lengths(points: Array, edges: Indices) -> Array:
    """(n,) integral [m] of the nodes' shape functions along boundary edges (b, 2) or (b, 3); points (n, 2) [m]."""
    lengths = np.zeros(len(points))
    values, slopes, weights = edge_rule(edges.shape[1])
    speed = np.linalg.norm(np.einsum("bka,kq->bqa", points[edges], slopes), axis=2)
    np.add.at(lengths, edges, np.einsum("bq,kq,q->bk", speed, values, weights))
    return lengths


def edge_rule(nodes: int) -> tuple[Array, Array, Array]:
    """Values (nodes, q) and slopes (nodes, q) of an edge's shape functions, and weights (q,), on 0 ... 1.

    The edge has 2 nodes, or 3 with the middle as the last one.
    """
    x, weights = np.polynomial.legendre.leggauss(4)
    s, weights = 0.5 * (x + 1.0), 0.5 * weights
    if nodes == 2:
        return np.stack([1.0 - s, s]), np.stack([-np.ones_like(s), np.ones_like(s)]), weights
    values = np.stack([(1.0 - s) * (1.0 - 2.0 * s), s * (2.0 * s - 1.0), 4.0 * s * (1.0 - s)])
    return values, np.stack([4.0 * s - 3.0, 4.0 * s - 1.0, 4.0 - 8.0 * s]), weights
