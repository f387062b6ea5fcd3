"""Nodal forces of loads on plane bodies: fields in the body, tractions and pressures on its edges."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from flexmb.errors import InputError
from flexmb.planes.boundary import edge_rule
from flexmb.planes.forms import mass_basis
from flexmb.planes.mesh import PlaneMesh
from flexmb.planes.regions import ByRegion, numbers_of_cells

Array = npt.NDArray[np.float64]
Field = Sequence[float] | Callable[[Array], Any]
"""A constant vector (x, y), or a function of points (p, 2) [m] that returns vectors (p, 2)."""


def body_force(mesh: PlaneMesh, field: Field, thickness: ByRegion[float]) -> Array:
    """Nodal forces (2n,) [N] of a force per volume, ordered x0, y0, x1, y1, ...

    Parameters
    ----------
    mesh : the mesh.
    field : force per volume [N/m^3].
    thickness : thickness across the plane [m], or thicknesses by region.
    """
    basis = mass_basis(mesh)
    places = np.moveaxis(np.asarray(basis.global_coordinates()), 0, -1)
    t = numbers_of_cells(mesh, "thickness", thickness, "m")[:, None]
    weighted = _vectors(mesh, field, places) * (basis.dx * t)[:, :, None]
    forces = np.zeros((len(mesh.points), 2))
    for k, (shape, *_) in enumerate(basis.basis):
        np.add.at(forces, mesh.cells[:, k], np.einsum("mqa,mq->ma", weighted, np.broadcast_to(shape, basis.dx.shape)))
    return forces.ravel()


def edge_load(mesh: PlaneMesh, name: str, traction: Field, thickness: float) -> Array:
    """Nodal forces (2n,) [N] of a force per area on the boundary edges of a set.

    Parameters
    ----------
    mesh : the mesh.
    name : name of the set.
    traction : force per area [Pa].
    thickness : thickness across the plane [m].
    """
    edges, speed, places = _edges(mesh, name)
    lengths = np.linalg.norm(speed, axis=2, keepdims=True)
    return _on_edges(mesh, edges, thickness * lengths * _vectors(mesh, traction, places))


def edge_pressure(mesh: PlaneMesh, name: str, pressure: float, thickness: float) -> Array:
    """Nodal forces (2n,) [N] of a pressure on the boundary edges of a set; > 0 pushes into the body.

    Parameters
    ----------
    mesh : the mesh.
    name : name of the set.
    pressure : [Pa].
    thickness : thickness across the plane [m].
    """
    edges, speed, _ = _edges(mesh, name)
    # the body lies on the left of an edge, so its inner normal is the direction turned by 90 degrees
    inner = np.stack([-speed[:, :, 1], speed[:, :, 0]], axis=2)
    return _on_edges(mesh, edges, thickness * pressure * inner)


def _edges(mesh: PlaneMesh, name: str) -> tuple[npt.NDArray[np.int64], Array, Array]:
    """Edges of a set, tangents (b, q, 2) and places (b, q, 2) of their quadrature points [m]."""
    edges = mesh.edges_in(name)
    if not len(edges):
        text = f"{mesh.label}: the set {name!r} holds no edge of the boundary, so nothing can press on it"
        raise InputError(f"{text}. Take a set with the nodes along an edge or a hole.")
    values, slopes, _ = edge_rule(edges.shape[1])
    own = mesh.points[edges]
    return edges, np.einsum("bka,kq->bqa", own, slopes), np.einsum("bka,kq->bqa", own, values)


def _on_edges(mesh: PlaneMesh, edges: npt.NDArray[np.int64], weighted: Array) -> Array:
    """Nodal forces of vectors (b, q, 2) on edges."""
    values, _, weights = edge_rule(edges.shape[1])
    forces = np.zeros((len(mesh.points), 2))
    np.add.at(forces, edges, np.einsum("bqa,kq,q->bka", weighted, values, weights))
    return forces.ravel()


def _vectors(mesh: PlaneMesh, field: Field, places: Array) -> Array:
    """Vectors (..., 2) of a field at places (..., 2)."""
    values = np.asarray(field(places.reshape(-1, 2)) if callable(field) else field, dtype=float)
    shape = (places.size // 2, 2) if callable(field) else (2,)
    if values.shape != shape or not np.isfinite(values).all():
        text = f"{mesh.label}: a load has values of shape {values.shape}, or values that are not finite"
        raise InputError(f"{text}; it must be (x, y), or a function of points (p, 2) that returns (p, 2).")
    return np.broadcast_to(values, (places.size // 2, 2)).reshape(places.shape)
