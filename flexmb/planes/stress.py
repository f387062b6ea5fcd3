"""Stresses at the nodes of plane bodies as a linear function of small displacements; principal stresses.

The same stresses as those of `recovery` without rotation: taken where they are most exact, continued to the nodes, and
averaged over the cells of a node with their areas as weights.  Stresses of modes superpose; von Mises stresses do not,
so they come last.
Equation (11.10) of docs/theory/plane_bodies.md.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.sparse import bsr_array, csr_array

from flexmb.model.material import Material
from flexmb.planes.forms import assembled
from flexmb.planes.mesh import PlaneMesh
from flexmb.planes.mesh_shape import cell_materials
from flexmb.planes.recovery import areas_and_means, around_nodes, gradients_at_nodes
from flexmb.planes.regions import STRESS, ByRegion

Array = npt.NDArray[np.float64]


def stress_operator(mesh: PlaneMesh, material: ByRegion[Material], state: str = STRESS) -> csr_array:
    """Sparse matrix (4n, 2n) [Pa/m] from displacements x0, y0, x1, ... to stresses sx, sy, txy, sz of every node.

    A node between two regions has the mean of both materials; the state is "stress" or "strain".  Stresses at nodes of
    the boundary converge with one order less than those inside.  At sharp inner corners they grow without limit as the
    mesh becomes finer.
    """
    areas, _ = areas_and_means(mesh.points, mesh.cells, mesh.kind)
    shares = areas[:, None] / around_nodes(mesh.cells, areas, len(mesh.points))[mesh.cells]
    slopes = gradients_at_nodes(mesh.points, mesh.cells, mesh.kind) * shares[:, :, None, None]
    x, y = slopes[..., 0], slopes[..., 1]
    d11, d12, d33, across = cell_materials(mesh, material, state).T[:, :, None, None]
    both = across * (d11 + d12)
    blocks = [[d11 * x, d12 * y], [d12 * x, d11 * y], [d33 * y, d33 * x], [both * x, both * y]]
    whole = [[assembled(mesh, local) for local in row] for row in blocks]
    pattern, n = whole[0][0], len(mesh.points)
    data = np.stack([np.stack([part.data for part in row], axis=-1) for row in whole], axis=-2)
    return csr_array(bsr_array((data, pattern.indices, pattern.indptr), shape=(4 * n, 2 * n)).tocsr())


def principal(stress: Array) -> tuple[Array, Array, Array]:
    """Larger and smaller principal stress in the plane [Pa], and the direction of the larger one [rad].

    Stresses are (..., 3) or (..., 4) sx, sy, txy [Pa]; sz counts for nothing here.
    """
    sx, sy, txy = np.moveaxis(np.asarray(stress, dtype=float), -1, 0)[:3]
    mean, radius = 0.5 * (sx + sy), np.hypot(0.5 * (sx - sy), txy)
    return mean + radius, mean - radius, 0.5 * np.arctan2(2.0 * txy, sx - sy)
