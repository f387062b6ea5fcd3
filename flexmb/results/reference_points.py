"""Places of the nodes at which stresses of a body are known."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexmb.bodies.flexible_body import FlexibleBody
from flexmb.model.shape import MeshShape
from flexmb.planes.plane_body import PlaneBody
from flexmb.reduction.reduced import Reduced

if TYPE_CHECKING:
    from flexmb.results.solution import Solution

STRESSED = FlexibleBody | PlaneBody | Reduced
"""Bodies that have stresses."""


def reference_points(body: STRESSED) -> np.ndarray:
    """Places (n, 2) of the nodes of a body in the reference configuration, by their numbers [m].

    Nodes of a plane body are those of its mesh, of reduced beams those of the mesh that shows them.
    """
    if isinstance(body, FlexibleBody):
        return np.array([(node.x, node.y) for node in body.nodes()])
    if isinstance(body, PlaneBody):
        own, origin, angle = np.asarray(body.mesh.points), body.origin, body.direction
    else:
        own, origin, angle = mesh_points(body), body.model.origin, body.model.direction
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(origin + own @ np.array([[c, s], [-s, c]]))


def mesh_points(body: Reduced) -> np.ndarray:
    """Points (n, 2) of the mesh that shows a reduced body, in its own axes [m]; none where nothing shows it."""
    drawn = body.model.drawn
    return np.zeros((0, 2)) if drawn is None else np.array(drawn.points)


def place_of_stress(sol: Solution, part: str, node: int) -> tuple[float, float] | None:
    """Place of a node in the reference configuration [m]; None where the solution does not know it."""
    if sol.mechanism is not None:
        body = sol.mechanism.find(part)
        return tuple(reference_points(body)[node].tolist()) if isinstance(body, STRESSED) else None
    # points of a body with all nodes of its mesh are those of the reference configuration
    meshes = (shape for shape in sol.shapes if isinstance(shape, MeshShape) and shape.part == part and not shape.basis)
    return next((shape.points[node] for shape in meshes), None)
