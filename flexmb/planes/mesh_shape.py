"""Drawing record of a mesh."""

from __future__ import annotations

import numpy as np

from flexmb.model.material import Material
from flexmb.model.shape import MeshShape
from flexmb.planes.mesh import PlaneMesh
from flexmb.planes.regions import STRAIN, ByRegion, cell_values, elasticity


def mesh_shape(part: str, mesh: PlaneMesh, material: ByRegion[Material], state: str) -> MeshShape:
    """Mesh of a body in the reference configuration, without its carriers; the state is "stress" or "strain"."""
    rows, number = np.unique(cell_materials(mesh, material, state), axis=0, return_inverse=True)
    materials = [(d11, d12, d33, across) for d11, d12, d33, across in rows.tolist()]
    return MeshShape(
        part,
        mesh.kind,
        tuple(map(tuple, mesh.points.tolist())),
        tuple(map(tuple, mesh.cells.tolist())),
        tuple(tuple(loop.tolist()) for loop in mesh.loops),
        (),
        materials=tuple(materials),
        material_of=tuple(number.ravel().tolist()) if len(materials) > 1 else (),
    )


def cell_materials(mesh: PlaneMesh, material: ByRegion[Material], state: str) -> np.ndarray:
    """(m, 4) d11, d12, d33 [Pa] of each cell, and sz over sx + sy: Poisson's ratio in plane strain, else 0."""
    across = np.zeros((len(mesh.cells), 1))
    if state == STRAIN:
        for item, cells in cell_values(mesh, "material", material):
            across[cells] = item.poisson
    return np.hstack([elasticity(mesh, material, state), across])
