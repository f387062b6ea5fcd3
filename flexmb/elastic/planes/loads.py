"""Loads on the nodes of a mesh: nodal forces, kernels, contributions.

The forces f_k on the nodes of a rigid pin with the arms a_k are one force and one moment, by X = sum a_k x f_k and
D = sum a_k . f_k.  An edge has the products P of a pressure and S of a shear: f_k = (P_kl J + S_kl) x_l.  It is linear
in x, so the tangent is constant but for the arms of pins.
Equations (11.12) and (11.13) of docs/theory/plane_bodies.md.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array

from flexmb.elastic.meshes.mesh import PlaneMesh, Thickness, edge_rule, numbers_of_cells
from flexmb.elastic.planes import elements
from flexmb.elastic.planes.cells import mass_basis, ties_of
from flexmb.engine.compiled.arrays import matrix_view, part_of
from flexmb.errors import InputError
from flexmb.kernels import Kernel, element_kernel, fast, signal_kernel
from flexmb.model import contributions as pieces
from flexmb.model.law import Motion
from flexmb.planar import Array

if TYPE_CHECKING:
    from flexmb.elastic.planes.plane_body import PlaneBody

# Nodal forces of loads on plane bodies: fields in the body, tractions and pressures on its edges

# A constant vector (x, y), or a function of points (p, 2) [m] that returns vectors (p, 2).
Field: TypeAlias = Sequence[float] | Callable[[Array], Any]
Stress: TypeAlias = float | Callable[[Array], Any]  # number, or function of points (p, 2) [m] that gives numbers (p,)


def body_force(mesh: PlaneMesh, field: Field, thickness: Thickness) -> Array:
    """Nodal forces (2n,) [N] of a force per volume [N/m^3], ordered x0, y0, x1, y1, ...; the thickness is in m."""
    basis = mass_basis(mesh)
    places = np.moveaxis(np.asarray(basis.global_coordinates()), 0, -1)
    t = numbers_of_cells(mesh, "thickness", thickness, "m")[:, None]
    weighted = _vectors(mesh, field, places) * (basis.dx * t)[:, :, None]
    forces = np.zeros((len(mesh.points), 2))
    for k, (shape, *_) in enumerate(basis.basis):
        np.add.at(forces, mesh.cells[:, k], np.einsum("mqa,mq->ma", weighted, np.broadcast_to(shape, basis.dx.shape)))
    return forces.ravel()


def edge_load(mesh: PlaneMesh, name: str, traction: Field, thickness: Thickness) -> Array:
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
    """Edges of the boundary on which a load acts."""

    nodes: npt.NDArray[np.int64]  # (b, k) nodes of each edge, the body on the left
    places: Array  # (b, q, 2) its quadrature points [m]
    thickness: Array  # (b,) thickness of its cell [m]


def loaded_edges(mesh: PlaneMesh, name: str, thickness: Thickness) -> LoadedEdges:
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
    """(b, k, k) integrals P of N_k p N_l' along each edge [N/m], for a stress p that follows the edge."""
    # Equation (11.13) of docs/theory/plane_bodies.md. The stress is a number [Pa], or a function of points (p, 2) [m]
    # that returns numbers (p,).
    values, slopes, weights = edge_rule(edges.nodes.shape[1])
    given = real_values(stress(edges.places.reshape(-1, 2)) if callable(stress) else stress)
    count = edges.places.size // 2
    if given.shape != ((count,) if callable(stress) else ()) or not np.isfinite(given).all():
        text = f"{mesh.label}: a load has values of shape {given.shape}, or values that are not finite"
        raise InputError(f"{text}; it must be a number, or a function of points (p, 2) that returns numbers (p,).")
    at_points = np.broadcast_to(given, (count,)).reshape(edges.places.shape[:2]) * edges.thickness[:, None]
    return np.asarray(np.einsum("bq,kq,lq,q->bkl", at_points, values, slopes, weights))


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
    if values.shape != ((places.size // 2, 2) if callable(field) else (2,)) or not np.isfinite(values).all():
        text = f"{mesh.label}: a load has values of shape {values.shape}, or values that are not finite"
        raise InputError(f"{text}; it must be (x, y), or a function of points (p, 2) that returns (p, 2).")
    return np.broadcast_to(values, (places.size // 2, 2)).reshape(places.shape)


# Kernels of loads on the nodes of a mesh: forces, dead or turning with a pin, and stresses that follow edges

# Numbers p of a force on a node: sum of f, X, D, beta where nothing turns; coordinates of gamma and of beta, or -1.
FORCE_X, FORCE_Y, CROSS, ALONG, ANGLE, OWN, TURNING = range(7)
PRODUCTS = 2  # place of the products of an edge (m, m, 2), behind the numbers of nodes and pins; then the ties
P, S, PAIR = range(3)  # products of a pressure and of a shear for a pair of nodes, and their number
ON_EDGES, FIRST_ELEMENT = range(2)  # numbers p of a signal: 1 for edges; then of each element; at last the signal's
COORDINATES, SIZE, NUMBERS = range(3)  # numbers of an element of a signal: of coordinates, of its own numbers; these
POWER = 2  # number of the signal `power`; those of fx and fy are 0 and 1
SIGNALS = (("fx", "N"), ("fy", "N"), ("power", "W"))  # signals of a load on a mesh with their units


@fast
def node_force(p, q, r):
    """Residual r (n,) of a force on a node; cosine and sine of beta - gamma are returned."""
    own, turning = int(p[OWN]), int(p[TURNING])
    beta = q[turning] if turning >= 0 else p[ANGLE]
    c, s = math.cos(beta), math.sin(beta)
    for i in range(r.shape[0]):
        r[i] = 0.0
    r[0] = s * p[FORCE_Y] - c * p[FORCE_X]
    r[1] = -s * p[FORCE_X] - c * p[FORCE_Y]
    if own < 0:
        return 1.0, 0.0
    c, s = math.cos(beta - q[own]), math.sin(beta - q[own])
    r[own] = -c * p[CROSS] - s * p[ALONG]
    return c, s


@element_kernel
def node_force_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Force on a node (x, y), further coordinates are angles; r (n,), K (n, n)."""
    c, s = node_force(p, q, r)
    own, turning = int(p[OWN]), int(p[TURNING])
    if turning >= 0:
        K[0, turning], K[1, turning] = -r[1], r[0]
    if own >= 0 and own != turning:
        slope = s * p[CROSS] - c * p[ALONG]
        K[own, own] = -slope
        if turning >= 0:
            K[own, turning] = slope


@fast
def edge_force(p, q, arms, f, r):
    """Arms, forces f (2 m,), residual r (n,) of an edge."""
    x = elements.nodal()
    elements.turned_arms(p, q, arms)
    elements.node_places(p, q, arms, x)
    # Forces f (2 m,) on the nodes of an edge at the places x (2 m,)
    m = int(p[elements.NODES])
    for k in range(m):
        fx, fy = 0.0, 0.0
        for l in range(m):
            at = PRODUCTS + PAIR * (k * m + l)
            normal, along = p[at + P], p[at + S]
            fx += along * x[2 * l] - normal * x[2 * l + 1]
            fy += along * x[2 * l + 1] + normal * x[2 * l]
        f[2 * k], f[2 * k + 1] = fx, fy
    for i in range(2 * m):
        f[i] = -f[i]
    for i in range(r.shape[0]):
        r[i] = 0.0
    elements.on_coordinates(p, arms, f, r)


@element_kernel
def edge_force_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    """Pressure and shear on an edge, which follow it; r (n,), K (n, n)."""
    arms, f = elements.nodal(), elements.nodal()
    edge_force(p, q, arms, f, r)
    m = int(p[elements.NODES])
    B = matrix_view(elements.square(), 2 * m, 2 * m)
    for k in range(m):
        for l in range(m):
            at = PRODUCTS + PAIR * (k * m + l)
            normal, along = p[at + P], p[at + S]
            B[2 * k, 2 * l], B[2 * k, 2 * l + 1] = -along, normal
            B[2 * k + 1, 2 * l], B[2 * k + 1, 2 * l + 1] = -normal, -along
    elements.matrix_on_coordinates(p, arms, B, K)
    for k in range(m):
        tie = elements.tie_at(p, k)
        if p[tie + elements.ON_PIN] > 0.0:
            theta = int(p[tie + elements.FIRST]) + 2
            K[theta, theta] -= arms[2 * k] * f[2 * k] + arms[2 * k + 1] * f[2 * k + 1]


@signal_kernel
def mesh_load_signal(p, t, q, v, a):
    """Force along x or y, or power, of a load; p: 1 for edges, then n, size and p of each element, number of signal."""
    last = p.shape[0] - 1
    on_edges, number, at, first, found = p[ON_EDGES] > 0.0, int(p[last]), FIRST_ELEMENT, 0, 0.0
    arms, f, r = elements.nodal(), elements.nodal(), elements.on_every_coordinate()
    while at < last:
        n, begin = int(p[at + COORDINATES]), at + NUMBERS
        end = begin + int(p[at + SIZE])
        own, coordinates, rows = part_of(p, begin, end), part_of(q, first, first + n), part_of(r, 0, n)
        if on_edges:
            edge_force(own, coordinates, arms, f, rows)
        else:
            node_force(own, coordinates, rows)
        if number == POWER:
            for i in range(n):
                found -= rows[i] * v[first + i]
        elif on_edges:
            for k in range(int(own[elements.NODES])):
                found -= f[2 * k + number]
        else:
            found -= rows[number]
        at, first = end, first + n
    return found


@dataclass(frozen=True, eq=False)
class FollowedEdges:
    """Edges that a load follows, the body on their left."""

    nodes: npt.NDArray[np.int64]  # (b, k) nodes of each edge
    normal: Array  # (b, k, k) products of the pressure [N/m]
    along: Array  # (b, k, k) products of the shear [N/m]

    def matrix(self, size: int) -> csr_array:
        """A (size, size): nodal forces x0, y0, x1, y1, ... by the places of the nodes."""
        blocks = np.zeros((*self.normal.shape, 2, 2))
        blocks[..., 0, 0] = blocks[..., 1, 1] = self.along
        blocks[..., 0, 1], blocks[..., 1, 0] = -self.normal, self.normal
        places = 2 * self.nodes[:, :, None] + np.arange(2)  # (b, k, 2)
        b, k, _ = places.shape
        rows = np.broadcast_to(places[:, :, None, :, None], (b, k, k, 2, 2))
        columns = np.broadcast_to(places[:, None, :, None, :], (b, k, k, 2, 2))
        return csr_array((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size))

    def forces(self, mesh: PlaneMesh) -> Array:
        """Nodal forces (n, 2) [N] at the places of the mesh."""
        return np.asarray((self.matrix(mesh.points.size) @ mesh.points.ravel()).reshape(-1, 2))


@dataclass(frozen=True, eq=False)
class NodalLoad:
    """A load on the nodes of a mesh, in the axes of the mesh."""

    forces: Array  # (n, 2) forces on the undeformed body [N]
    nodes: npt.NDArray[np.int64]  # numbers of the nodes on which it acts, though its values may be 0
    follower: bool = False  # whether their directions turn with the first pin
    edges: FollowedEdges | None = None  # edges that it follows, in place of directions; None: no edges


def load_contributions(
    body: PlaneBody, name: str, load: NodalLoad, history: Motion | None
) -> list[pieces.Contribution]:
    """Elements and signals of a load on all nodes of a body, times the value of `history`; None: constant."""
    kernel: Kernel = edge_force_kernel if load.edges else node_force_kernel
    parts = list(_edges(body, load.edges) if load.edges else _nodes(body, load))
    numbers, coordinates = [float(load.edges is not None)], list[pieces.Coordinate]()
    for place, p in parts:
        numbers += [float(len(place)), float(len(p)), *p]
        coordinates += place
    dofs = tuple(coordinates), tuple(numbers)
    signals = pieces.signal_contributions(name, mesh_load_signal, SIGNALS, *dofs, use_of_factor=pieces.MULTIPLIES)
    return [*(pieces.ElementContribution(name, kernel, place, p, factor=history) for place, p in parts), *signals]


def _edges(body: PlaneBody, edges: FollowedEdges) -> Iterator[tuple[tuple[pieces.Coordinate, ...], tuple[float, ...]]]:
    """Coordinates and numbers of each edge."""
    products = np.stack([edges.normal, edges.along], axis=3).reshape(len(edges.nodes), -1)
    for nodes, own in zip(edges.nodes.tolist(), products.tolist(), strict=True):
        coordinates, ties, held = ties_of(body.name, nodes, body.mesh.points, body.free_nodes, body.on_pins)
        yield coordinates, (float(len(nodes)), float(held), *own, *ties)


def _nodes(body: PlaneBody, load: NodalLoad) -> Iterator[tuple[tuple[pieces.Coordinate, ...], tuple[float, ...]]]:
    """Coordinates and numbers of each loaded node, then of each loaded pin."""
    on_pins: dict[str, Array] = {}
    for k in load.nodes.tolist():
        fx, fy = load.forces[k].tolist()
        pin = body.on_pins.get(k)
        if pin is None:
            yield _force(body, load, (fx, fy, 0.0, 0.0), pieces.node_coordinates(body.name, body.free_nodes[k])[:2])
            continue
        ax, ay = (body.mesh.points[k] - pin.point).tolist()
        sums = on_pins.setdefault(pin.name, np.zeros(4))
        sums += (fx, fy, ax * fy - ay * fx, ax * fx + ay * fy)
    for name, sums in on_pins.items():
        yield _force(body, load, tuple(sums.tolist()), pieces.node_coordinates(body.name, name))


def _force(
    body: PlaneBody, load: NodalLoad, sums: tuple[float, ...], place: tuple[pieces.Coordinate, ...]
) -> tuple[tuple[pieces.Coordinate, ...], tuple[float, ...]]:
    """Coordinates and numbers of a force on the node at `place`, with its rotation if it has one."""
    own, at = (2 if len(place) == 3 else -1), -1
    if load.follower:
        turning = pieces.node_coordinates(body.name, body.interfaces[0].name)[2]
        if turning not in place:
            place = (*place, turning)
        at = place.index(turning)
    return place, (*sums, body.direction, float(own), float(at))
