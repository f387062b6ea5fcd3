"""Kinds of plane cells, and the boundary of a mesh of them."""

from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt
import skfem as fe
from skfem.quadrature import get_quadrature

from flexmb.planar import Array, Indices

# Kinds of plane cells: local order of nodes, edges, shape functions, degrees of quadrature


@dataclass(frozen=True)
class CellKind:
    """One kind of cells; nodes as in VTK and gmsh: corners counter-clockwise, middles of the edges, centre."""

    name: str  # "tri3", "tri6", "quad4" or "quad9"
    nodes: int  # number of nodes
    corners: int  # number of corners
    # local nodes of each edge: both ends, then the middle of quadratic cells; the cell lies on the left
    edges: tuple[tuple[int, ...], ...]
    element: type[fe.Element]  # scikit-fem's shape functions
    mesh: type[fe.Mesh2D]  # scikit-fem's class of meshes with these cells, curved where the middles are off the chords
    # degree up to which stiffness, stress and geometric stiffness are integrated exactly; the stiffness of cells with
    # straight edges, without taper, is then exact
    stiffness_order: int
    mass_order: int  # the same for the mass; exact for all cells, curved ones included

    @property
    def is_quadratic(self) -> bool:
        """Whether edges have nodes in their middles."""
        return self.nodes > self.corners

    @property
    def reference_nodes(self) -> Array:
        """(2, nodes) coordinates of the nodes in the reference cell."""
        return np.asarray(np.asarray(self.element().doflocs, dtype=float).T)

    def shape_functions(self, places: Array) -> tuple[Array, Array]:
        """Values (nodes, q), gradients (2, nodes, q) of shape functions at places (2, q) of the reference cell."""
        element = self.element()
        pairs = [element.lbasis(places, i) for i in range(self.nodes)]
        values = np.stack([np.broadcast_to(value, places.shape[1:]) for value, _ in pairs])
        gradients = np.stack([np.broadcast_to(slope, places.shape) for _, slope in pairs], axis=1)
        return values, gradients


TRIANGLE, QUADRILATERAL = ((0, 1), (1, 2), (2, 0)), ((0, 1), (1, 2), (2, 3), (3, 0))  # edges of cells by their corners
QUADRATIC = tuple((*edge, 4 + i) for i, edge in enumerate(QUADRILATERAL))  # with the middles of the edges

KINDS = {  # kinds of cells by name
    kind.name: kind
    for kind in (
        CellKind("tri3", 3, 3, TRIANGLE, fe.ElementTriP1, fe.MeshTri1, 1, 2),
        CellKind("tri6", 6, 3, tuple((*e, 3 + i) for i, e in enumerate(TRIANGLE)), fe.ElementTriP2, fe.MeshTri2, 4, 6),
        CellKind("quad4", 4, 4, QUADRILATERAL, fe.ElementQuad1, fe.MeshQuad1, 3, 3),
        CellKind("quad9", 9, 4, QUADRATIC, fe.ElementQuad2, fe.MeshQuad2, 5, 7),
    )
}


@cache
def places_of_check(kind: str) -> Array:
    """(2, q) places of a reference cell at which the Jacobian determinant is compared with 0: its nodes and inside."""
    cell = KINDS[kind]
    inner = get_quadrature(cell.element.refdom, cell.mass_order)[0]
    return np.hstack([cell.reference_nodes, inner])


def jacobians(points: Array, cells: npt.NDArray[np.int64], kind: str) -> Array:
    """(m, q) Jacobian determinants [m^2] of all cells at `places_of_check`."""
    slopes = KINDS[kind].shape_functions(places_of_check(kind))[1]
    x = points[cells]
    J = np.einsum("mka,bkq->abmq", x, slopes, optimize=True)
    return np.asarray(J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0])


@dataclass(frozen=True, eq=False)
class Edges:
    """Edges of all cells, each edge once."""

    # (e, 2) or (e, 3) first node, last node and middle of each edge, as its first cell has it on the left
    nodes: Indices
    cells: Indices  # (e, 2) both cells of an edge; -1 for the missing one of a boundary edge
    counts: Indices  # (e,) number of cells of each edge
    folded: npt.NDArray[np.bool_]  # (e,) whether the first two cells of an edge lie on the same side of it

    @property
    def boundary(self) -> Indices:
        """(b, 2) or (b, 3) nodes of the edges of the boundary, with the body on the left."""
        return np.asarray(self.nodes[self.counts == 1])


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
    """Closed loops of boundary edges: nodes in order, middles between their corners, the body on the left."""
    # A node at which more than two boundary edges meet ends a loop early; `PlaneMesh` refuses such meshes. The edges
    # are (b, 2) or (b, 3) nodes.
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
    """Values and slopes (nodes, q) of shape functions of an edge, its middle last; weights (q,), on 0 ... 1."""
    x, weights = np.polynomial.legendre.leggauss(4)
    s, weights = 0.5 * (x + 1.0), 0.5 * weights
    if nodes == 2:
        return np.stack([1.0 - s, s]), np.stack([-np.ones_like(s), np.ones_like(s)]), weights
    values = np.stack([(1.0 - s) * (1.0 - 2.0 * s), s * (2.0 * s - 1.0), 4.0 * s * (1.0 - s)])
    return values, np.stack([4.0 * s - 3.0, 4.0 * s - 1.0, 4.0 - 8.0 * s]), weights
