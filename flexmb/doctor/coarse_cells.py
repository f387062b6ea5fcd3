"""Plane bodies of linear cells that are too few across a body to bend."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flexmb.doctor.finding import Finding, found
from flexmb.model.mechanism import Mechanism
from flexmb.planes.plane_body import PlaneBody
from flexmb.planes.regions import cell_values, elasticity
from flexmb.reduction.reduced import Reduced

TOO_STIFF = 0.1
"""Share by which a body is too stiff in bending, above which there is a remark."""

TRIANGLES = {"tri3": ((0, 1, 2),), "quad4": ((0, 1, 2), (0, 2, 3))}
"""Linear cells as triangles."""


def coarse_cells(mechanism: Mechanism) -> Iterator[Finding]:
    """Findings on meshes of linear cells that make a body much too stiff in bending."""
    for part in mechanism.bodies:
        body = part.body if isinstance(part, Reduced) else part
        excess = bending_excess(body) if isinstance(body, PlaneBody) else 0.0
        if isinstance(body, PlaneBody) and excess > TOO_STIFF:
            text = f"{part.label}: its {body.mesh.kind} cells are too few across it: in bending it is some "
            text += f"{100.0 * excess:.2g} % too stiff."
            remedy = "Take quadratic cells, mesh=mesh.to_quadratic(), or several times as many across it."
            yield found("coarse-cells", (part.name,), text, remedy, excess=excess)


def bending_excess(body: PlaneBody) -> float:
    """Share by which a body of linear cells is too stiff in bending; 0 for quadratic cells.

    The strain energy of u = -x y, v = x^2/2 at the nodes, x along the body, less that of this field itself, is the
    energy of the strains that linear cells add; over the energy of bending of a bar of the same area whose height is
    twice the area over the length of the boundary.
    """
    mesh = body.mesh
    if mesh.kind not in TRIANGLES:
        return 0.0
    points = mesh.points - mesh.points.mean(axis=0)
    along = np.linalg.eigh(points.T @ points)[1][:, -1]
    across = np.array([-along[1], along[0]])
    x, y = points @ along, points @ across
    field = (-(x * y)[:, None] * along + 0.5 * (x**2)[:, None] * across).ravel()
    stiffness = elasticity(mesh, body.material, body.state)[:, 0]
    for thickness, cells in cell_values(mesh, "thickness", body.thickness):
        stiffness[cells] *= thickness
    square, whole = np.zeros(len(mesh.cells)), np.zeros(len(mesh.cells))
    for corners in TRIANGLES[mesh.kind]:
        (ax, ay), (bx, by), (cx, cy) = (points[mesh.cells[:, k]].T for k in corners)
        area, heights = 0.5 * ((bx - ax) * (cy - ay) - (cx - ax) * (by - ay)), y[mesh.cells[:, corners]]
        square += area / 12.0 * ((heights**2).sum(axis=1) + heights.sum(axis=1) ** 2)
        whole += area
    rings = [points[np.append(loop, loop[0])] for loop in mesh.loops]
    boundary = sum(np.linalg.norm(np.diff(ring, axis=0), axis=1).sum() for ring in rings)
    height = 2.0 * whole.sum() / boundary
    added = field @ (body.matrices.stiffness @ field) - stiffness @ square
    return float(added / (stiffness @ whole * height**2 / 12.0))
