"""Kinds of plane cells: local order of nodes, edges, shape functions, degrees of quadrature."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt
from skfem import (
    Element,
    ElementQuad1,
    ElementQuad2,
    ElementTriP1,
    ElementTriP2,
    Mesh2D,
    MeshQuad1,
    MeshQuad2,
    MeshTri1,
    MeshTri2,
)
from skfem.quadrature import get_quadrature

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class CellKind:
    """One kind of cells.

    Nodes are ordered as in VTK and gmsh: corners counter-clockwise, then the middles of the edges, then the centre.

    Attributes
    ----------
    name : "tri3", "tri6", "quad4" or "quad9".
    nodes, corners : numbers of nodes and of corners.
    edges : local nodes of each edge: both ends, then the middle of quadratic cells; the cell lies on the left.
    element : scikit-fem's shape functions.
    mesh : scikit-fem's class of meshes with these cells, curved where the middles are off the chords.
    stiffness_order : degree up to which stiffness, stress and geometric stiffness are integrated exactly; the stiffness
        of cells with straight edges, without taper, is then exact.
    mass_order : the same for the mass; exact for all cells, curved ones included.
    """

    name: str
    nodes: int
    corners: int
    edges: tuple[tuple[int, ...], ...]
    element: type[Element]
    mesh: type[Mesh2D]
    stiffness_order: int
    mass_order: int

    @property
    def is_quadratic(self) -> bool:
        """Whether edges have nodes in their middles."""
        return self.nodes > self.corners

    @property
    def reference_nodes(self) -> Array:
        """(2, nodes) coordinates of the nodes in the reference cell."""
        places: Array = np.asarray(self.element().doflocs, dtype=float).T
        return places

    def shape_functions(self, places: Array) -> tuple[Array, Array]:
        """Values (nodes, q) and gradients (2, nodes, q) of the shape functions in the reference cell.

        places : (2, q) coordinates in the reference cell.
        """
        element = self.element()
        pairs = [element.lbasis(places, i) for i in range(self.nodes)]
        values = np.stack([np.broadcast_to(value, places.shape[1:]) for value, _ in pairs])
        gradients = np.stack([np.broadcast_to(slope, places.shape) for _, slope in pairs], axis=1)
        return values, gradients


TRIANGLE, QUADRILATERAL = ((0, 1), (1, 2), (2, 0)), ((0, 1), (1, 2), (2, 3), (3, 0))
"""Edges of cells by their corners."""

KINDS = {
    kind.name: kind
    for kind in (
        CellKind("tri3", 3, 3, TRIANGLE, ElementTriP1, MeshTri1, 1, 2),
        CellKind("tri6", 6, 3, tuple((*e, 3 + i) for i, e in enumerate(TRIANGLE)), ElementTriP2, MeshTri2, 4, 6),
        CellKind("quad4", 4, 4, QUADRILATERAL, ElementQuad1, MeshQuad1, 3, 3),
        CellKind("quad9", 9, 4, tuple((*e, 4 + i) for i, e in enumerate(QUADRILATERAL)), ElementQuad2, MeshQuad2, 5, 7),
    )
}
"""Kinds of cells by name."""


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
    found: Array = J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0]
    return found
