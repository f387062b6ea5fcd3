"""Plane bodies as their reduction sees them, in the axes of their mesh."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from flexmb.errors import InputError
from flexmb.model.contributions import Node
from flexmb.planes.forms import geometric_stiffness, stress_at_quadrature
from flexmb.planes.interfaces import RIGID, tie
from flexmb.planes.mesh_shape import mesh_shape
from flexmb.planes.plane_body import PlaneBody
from flexmb.planes.stress import stress_operator
from flexmb.reduction.elastic_model import ElasticModel, Sparse

Array = npt.NDArray[np.float64]


def model_of_plane(body: PlaneBody, pins: Sequence[str]) -> ElasticModel:
    """Elastic model of a plane body with pins where parts are attached; its other pins are left out."""
    kept = [interface for interface in body.interfaces if interface.name in pins]
    if not kept:
        raise InputError(f"{body.label}: none of its pins is left. Keep at least one.")
    shape = sp.csr_matrix(body.tie.matrix if len(kept) == len(body.interfaces) else tie(kept, body.mesh).matrix)

    stiffness = sp.csr_matrix(body.matrices.stiffness)

    def stress_stiffness(z: Array) -> Sparse:
        moved = shape @ z
        stress = stress_at_quadrature(body.mesh, body.material, moved, body.state)
        turned = sp.csr_matrix(geometric_stiffness(body.mesh, stress, body.thickness))
        forces = (stiffness @ moved).reshape(-1, 2)
        turns = np.zeros(shape.shape[1])
        for k, interface in enumerate(kept):
            if interface.kind == RIGID:  # its nodes move by -theta^2/2 of their arms, and its forces do work on that
                turns[3 * k + 2] = -float((forces[interface.nodes] * interface.arms(body.mesh)).sum())
        return (shape.T @ turned @ shape + sp.diags_array(turns)).tocsc()

    def stresses(shapes: Array) -> Array:
        operator = stress_operator(body.mesh, body.material, body.state)
        found: Array = np.asarray(operator @ (shape @ shapes)).reshape(len(body.mesh.points), 4, -1)
        return found

    return ElasticModel(
        body.label,
        tuple(Node(interface.name, *interface.point, 0.0) for interface in kept),
        (shape.T @ stiffness @ shape).tocsc(),
        body.mesh.points,
        shape,
        sp.csr_matrix(body.matrices.scalar_mass),
        sp.csr_matrix((1, shape.shape[1])),
        sp.csr_matrix((1, 1)),
        stress_stiffness,
        body.damping,
        body.origin,
        body.direction,
        mesh_shape(body.name, body.mesh, body.material, body.state),
        shape,
        stresses,
        body.mass_damping,
    )
