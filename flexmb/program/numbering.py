"""Numbers of coordinates and unknowns, and the elimination order of the matrix."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND
from flexmb.model.pieces import AXES, Coordinate, Node, Pieces


class Numbering:
    """Numbers of the coordinates of a mechanism: three a node, in the order of declaration."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.nodes: tuple[tuple[str, Node], ...] = mechanism.nodes()
        self._first = {(part, node.name): 3 * k for k, (part, node) in enumerate(self.nodes)}
        self.of_body: dict[str, tuple[int, int]] = {}  # where the coordinates of each body begin and end
        for k, (part, _) in enumerate(self.nodes):
            self.of_body[part] = self.of_body.get(part, (3 * k, 0))[0], 3 * k + 3
        self.n_q = 3 * len(self.nodes)
        self._first[(GROUND.name, "")] = self.n_q

    def dofs(self, coordinates: Sequence[Coordinate]) -> list[int]:
        """Numbers of coordinates; the ground's are n_q, n_q + 1, n_q + 2."""
        return [self._first[(part, node)] + axis for part, node, axis in coordinates]

    def unknowns(self, coordinates: Sequence[Coordinate]) -> list[int]:
        """The same with -1 for the ground's coordinates."""
        return [d if d < self.n_q else -1 for d in self.dofs(coordinates)]

    def names(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        stems = (f"{part}.{node.name}" if node.name else part for part, node in self.nodes)
        return tuple(f"{stem}.{axis}" for stem in stems for axis in AXES)

    def pose(self) -> np.ndarray:
        """The drawn pose, (n_q,) [m, rad]."""
        return np.array([x for _, n in self.nodes for x in (n.x, n.y, n.theta)])

    @cached_property
    def extent(self) -> float:
        """Extent of the nodes in the drawn pose [m], whatever its direction; 1 for a single node at the origin."""
        points = self.pose().reshape(-1, 3)[:, :2]
        end = points[np.argmax(np.hypot(*(points - points.mean(axis=0)).T))]
        extent = float(np.hypot(*(points - end).T).max())
        return extent or float(np.hypot(*points.T).max()) or 1.0


def blocks_and_edges(pieces: Pieces, number: Numbering) -> tuple[list[np.ndarray], list[tuple[int, ...]], list[bool]]:
    """Blocks of unknowns (nodes, then constraints), groups of coupled blocks, and which blocks are constraints."""
    n_nodes = number.n_q // 3
    blocks = [np.arange(3 * k, 3 * k + 3) for k in range(n_nodes)]
    last = [False] * n_nodes

    def touched(coordinates: Sequence[Coordinate]) -> set[int]:
        return {d // 3 for d in number.unknowns(coordinates) if d >= 0}

    edges = [tuple(sorted(touched(e.coordinates))) for e in (*pieces.elements, *pieces.contacts)]
    row = number.n_q
    for piece in pieces.constraints:
        edges.append((*sorted(touched(piece.coordinates)), len(blocks)))
        blocks.append(np.arange(row, row + piece.rows))
        last.append(True)
        row += piece.rows
    return blocks, edges, last
