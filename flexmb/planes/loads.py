"""Nodal forces of loads on plane bodies: fields in the body, tractions and pressures on its edges."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from flexmb.errors import InputError
from flexmb.planes.boundary import edge_rule
from flexmb.planes.forms import mass_basis
from flexmb.planes.mesh import PlaneMesh
from flexmb.planes.regions import ByRegion, numbers_of_cells

Array = npt.NDArray[np.float64]
Field: TypeAlias = Sequence[float] | Callable[[Array], Any]
"""A constant vector (x, y), or a function of points (p, 2) [m] that returns vectors (p, 2)."""

Stress: TypeAlias = float | Callable[[Array], Any]
"""A constant number, or a function of points (p, 2) [m] that returns numbers (p,)."""


def body_force(mesh: PlaneMesh, field: Field, thickness: ByRegion[float]) -> Array:
    """Nodal forces (2n,) [N] of a force per volume [N/m^3], ordered x0, y0, x1, y1, ...; the thickness is in m."""
    basis = mass_basis(mesh)
    places = np.moveaxis(np.asarray(basis.global_coordinates()), 0, -1)
    t = numbers_of_cells(mesh, "thickness", thickness, "m")[:, None]
    weighted = _vectors(mesh, field, places) * (basis.dx * t)[:, :, None]
    forces = np.zeros((len(mesh.points), 2))
    for k, (shape, *_) in enumerate(basis.basis):
        np.add.at(forces, mesh.cells[:, k], np.einsum("mqa,mq->ma", weighted, np.broadcast_to(shape, basis.dx.shape)))
    return forces.ravel()


def edge_load(mesh: PlaneMesh, name: str, traction: Field, thickness: ByRegion[float]) -> Array:
    """Nodal forces (2n,) [N] of a force per area [Pa] on the boundary edges of a set; the thickness is in m."""
    edges = loaded_edges(mesh, name, thickness)
    values, slopes, weights = edge_rule(edges.nodes.shape[1])
    lengths = np.linalg.norm(np.einsum("bka,kq->bqa", mesh.points[edges.nodes], slopes), axis=2)
    vectors = _vectors(mesh, traction, edges.places) * (lengths * edges.thickness[:, None])[:, :, None]
    forces = np.zeros((len(mesh.points), 2))
    np.add.at(forces, edges.nodes, np.einsum("bqa,kq,q->bka", vectors, values, weights))
    return forces.ravel()


@dataclass(frozen=True, eq=False)
class LoadedEdges:
    """Edges of the boundary on which a load acts.

    Parameters
    ----------
    nodes : (b, k) nodes of each edge, the body on the left.
    places : (b, q, 2) its quadrature points [m].
    thickness : (b,) thickness of its cell [m].
    """

    nodes: npt.NDArray[np.int64]
    places: Array
    thickness: Array


def loaded_edges(mesh: PlaneMesh, name: str, thickness: ByRegion[float]) -> LoadedEdges:
    """Boundary edges of a set, one at least; the thickness is in m."""
    numbers = mesh.edge_numbers(name)
    if not len(numbers):
        text = f"{mesh.label}: the set {name!r} holds no edge of the boundary, so nothing can press on it"
        raise InputError(f"{text}. Take a set with the nodes along an edge or a hole.")
    nodes = mesh.edges.nodes[numbers]
    values, _, _ = edge_rule(nodes.shape[1])
    places = np.einsum("bka,kq->bqa", mesh.points[nodes], values)
    return LoadedEdges(nodes, places, numbers_of_cells(mesh, "thickness", thickness, "m")[mesh.edges.cells[numbers, 0]])


def edge_products(mesh: PlaneMesh, edges: LoadedEdges, stress: Stress) -> Array:
    """(b, k, k) integrals P of N_k p N_l' along each edge [N/m], for a stress p that follows the edge.

    A pressure p has the nodal forces P_kl J x_l at the places x_l, since J x' is the inner normal times the length; a
    shear along the edge has P_kl x_l.  Equation (11.13) of docs/theory/plane_bodies.md.  The stress is a number [Pa],
    or a function of points (p, 2) [m] that returns numbers (p,).
    """
    values, slopes, weights = edge_rule(edges.nodes.shape[1])
    given = real_values(stress(edges.places.reshape(-1, 2)) if callable(stress) else stress)
    count = edges.places.size // 2
    if given.shape != ((count,) if callable(stress) else ()) or not np.isfinite(given).all():
        text = f"{mesh.label}: a load has values of shape {given.shape}, or values that are not finite"
        raise InputError(f"{text}; it must be a number, or a function of points (p, 2) that returns numbers (p,).")
    at_points = np.broadcast_to(given, (count,)).reshape(edges.places.shape[:2]) * edges.thickness[:, None]
    return np.asarray(np.einsum("bq,kq,lq,q->bkl", at_points, values, slopes, weights))


def edge_pressure(mesh: PlaneMesh, name: str, pressure: Stress, thickness: ByRegion[float]) -> Array:
    """Nodal forces (2n,) [N] of a pressure [Pa] on the edges of a set, by thickness [m]; > 0 pushes into the body."""
    edges = loaded_edges(mesh, name, thickness)
    return on_edges(mesh, edges.nodes, edge_products(mesh, edges, pressure), 0.0).ravel()


def on_edges(mesh: PlaneMesh, nodes: npt.NDArray[np.int64], normal: Array, along: Array | float) -> Array:
    """Nodal forces (n, 2) [N] of stresses that follow edges of nodes (b, k), at the places of the mesh.

    `normal` and `along` are products (b, k, k) of the pressure and of the shear, or 0 [N/m].
    """
    x = mesh.points[nodes]
    inner = np.stack([-x[:, :, 1], x[:, :, 0]], axis=2)  # the body lies on the left of an edge
    forces = np.zeros((len(mesh.points), 2))
    on_nodes = np.einsum("bkl,bla->bka", normal, inner)
    if np.ndim(along):
        on_nodes = on_nodes + np.einsum("bkl,bla->bka", along, x)
    np.add.at(forces, nodes, on_nodes)
    return forces


def real_values(given: Any) -> Array:
    """Values of a user's function as real numbers; nan where they are none."""
    try:
        values = np.asarray(given)
    except ValueError:  # lists of different lengths
        return np.full(1, np.nan)
    return values.astype(float) if values.dtype.kind in "biuf" else np.full(values.shape, np.nan)


def _vectors(mesh: PlaneMesh, field: Field, places: Array) -> Array:
    """Vectors (..., 2) of a field at places (..., 2)."""
    values = real_values(field(places.reshape(-1, 2)) if callable(field) else field)
    shape = (places.size // 2, 2) if callable(field) else (2,)
    if values.shape != shape or not np.isfinite(values).all():
        text = f"{mesh.label}: a load has values of shape {values.shape}, or values that are not finite"
        raise InputError(f"{text}; it must be (x, y), or a function of points (p, 2) that returns (p, 2).")
    return np.broadcast_to(values, (places.size // 2, 2)).reshape(places.shape)
