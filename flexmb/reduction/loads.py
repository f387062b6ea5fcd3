"""Loads on the mesh of a reduced body: their generalised forces by the nodes of the body."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from flexmb import checks
from flexmb.errors import InputError
from flexmb.loads.mesh_load import MeshLoad
from flexmb.model.contributions import MULTIPLIES, Contribution, Coordinate, ElementContribution, signal_contributions
from flexmb.model.law import Motion
from flexmb.planes.load_kernels import SIGNALS
from flexmb.planes.mesh_body import MeshBody
from flexmb.planes.nodal_load import FollowedEdges, NodalLoad
from flexmb.reduction.craig_bampton import Basis
from flexmb.reduction.load_kernels import DEAD, EDGES, FOLLOWER, reduced_load_kernel, reduced_load_signal
from flexmb.reduction.superelement import Superelement, quarter_turned, stiffness_under

if TYPE_CHECKING:
    from flexmb.reduction.reduced import Reduced

Array = npt.NDArray[np.float64]


def load_contributions(
    name: str,
    load: NodalLoad,
    history: Motion | None,
    coordinates: tuple[Coordinate, ...],
    found: Basis,
    element: Superelement,
    *,
    stiffening: bool,
) -> list[Contribution]:
    """Element and signals of a load, times the value of the motion `history`; None: constant.

    With `stiffening` the stress of the load with held pins stiffens or softens the body.
    """
    kind = EDGES if load.edges else FOLLOWER if load.follower else DEAD
    shapes = np.asarray(found.model.shape @ found.shapes)  # Psi at the points
    turning = _quarter(shapes) - quarter_turned(shapes)  # Phi
    f = load.forces.ravel()
    both = f, _quarter(f) if kind != EDGES else np.zeros_like(f)
    blocks = [*element.frame_parameters(), *(shapes.T @ g for g in both), *(turning.T @ g for g in both)]
    if stiffening:
        none = np.zeros((found.shapes.shape[1],) * 2)
        blocks += [stiffness_under(found, found.model.shape.T @ g) if g.any() else none for g in both]
    if load.edges:
        moved = edge_matrix(load.edges, len(f)) @ shapes
        blocks += [shapes.T @ moved, turning.T @ moved]
    head = element.load_head(kind, found.model.direction, stiffens=stiffening)
    p = (*head, *np.concatenate([np.ravel(block) for block in blocks]).tolist())
    return [
        ElementContribution(name, reduced_load_kernel, coordinates, p, factor=history),
        *signal_contributions(name, reduced_load_signal, SIGNALS, coordinates, p, use_of_factor=MULTIPLIES),
    ]


def checked_loads(body: MeshBody, given: object) -> tuple[MeshLoad, ...]:
    """Loads whose static shapes a reduced body keeps, a sequence of loads on the mesh of this body."""
    loads = checks.sequence(body.label, "load_shapes", given, "loads such as loads.EdgePressure")
    for load in loads:
        if not isinstance(load, MeshLoad):
            text = f"{body.label}: load_shapes holds {load!r}; it must hold loads on the mesh of a body"
            raise InputError(f"{text}, such as loads.EdgePressure.")
        if load.body.name != body.name:
            text = f"{body.label}: load_shapes holds {load.label}, which acts on {load.body.label}"
            raise InputError(f"{text}. Leave it out, or give the load this body.")
        load.plane_of(body)
    return loads


def left_out(body: Reduced, force: Array) -> tuple[float, float]:
    """Strain energy [J] of forces (N,) [N] on the model with all pins held, and its part without the kept shapes."""
    found, m = body.basis, body.basis.model.count
    kept = (found.shapes.T @ force)[m:]
    whole = 0.5 * float(found.static(force) @ force)
    return whole, whole - 0.5 * float(kept @ np.linalg.solve(body.element.matrices["K"][m:, m:], kept))


def _quarter(rows: Array) -> Array:
    """J times vectors x0, y0, x1, y1, ... along the first axis."""
    turned = np.empty_like(rows)
    turned[0::2], turned[1::2] = -rows[1::2], rows[0::2]
    return turned


def edge_matrix(edges: FollowedEdges, size: int) -> sp.csr_matrix:
    """A (size, size): nodal forces of a load that follows edges, by the places of the nodes."""
    blocks = np.zeros((*edges.normal.shape, 2, 2))
    blocks[..., 0, 0] = blocks[..., 1, 1] = edges.along
    blocks[..., 0, 1], blocks[..., 1, 0] = -edges.normal, edges.normal
    places = 2 * edges.nodes[:, :, None] + np.arange(2)  # (b, k, 2)
    b, k, _ = places.shape
    rows = np.broadcast_to(places[:, :, None, :, None], (b, k, k, 2, 2))
    columns = np.broadcast_to(places[:, None, :, None, :], (b, k, k, 2, 2))
    return sp.csr_matrix((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size))
