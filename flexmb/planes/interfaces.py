"""Pins of plane bodies: nodes of a hole tied to one point with a rotation, rigidly or on average.

rigid     (RBE2)  u_k = u_p + theta_p J (X_k - X_p)           the set moves as a rigid body: too stiff
averaged  (RBE3)  u_p, theta_p minimise  sum_k w_k |u_k - u_p - theta_p J (X_k - X_p)|^2      the set deforms: too soft

J turns by 90 degrees counter-clockwise.  The weights w_k are the lengths of the boundary that belong to the nodes.
Equations (11.6), (11.7) and (11.9) of docs/theory/plane_bodies.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.linalg import qr
from scipy.sparse import coo_array, csr_array

from flexmb import checks
from flexmb.errors import InputError
from flexmb.planes.boundary import tributary_lengths
from flexmb.planes.mesh import PlaneMesh

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

RIGID, AVERAGED = "rigid", "averaged"
"""Kinds of interfaces."""

NO_ARM = 1e-9
"""Distance of nodes over the size of the mesh [1] below which they cannot turn a pin."""


@dataclass(frozen=True, eq=False)
class Interface:
    """A set of nodes that moves with one point.

    Parameters
    ----------
    nodes : node numbers of the set.
    point : place of the pin in the axes of the mesh [m].
    kind : "rigid" or "averaged".
    """

    name: str
    nodes: Indices
    point: tuple[float, float]
    kind: str = RIGID

    def __post_init__(self) -> None:
        checks.one_of(f"Interface {self.name!r}", "kind", self.kind, (RIGID, AVERAGED))

    def arms(self, mesh: PlaneMesh) -> Array:
        """(m, 2) places of the nodes from the pin [m]."""
        found: Array = mesh.points[self.nodes] - np.asarray(self.point)
        return found

    def rigid_motions(self, mesh: PlaneMesh) -> Array:
        """(2m, 3) displacements of the nodes by unit u_x, u_y and theta of the pin."""
        arms = self.arms(mesh)
        motions = np.zeros((len(arms), 2, 3))
        motions[:, 0, 0] = motions[:, 1, 1] = 1.0
        motions[:, 0, 2], motions[:, 1, 2] = -arms[:, 1], arms[:, 0]
        return motions.reshape(-1, 3)

    def weights(self, mesh: PlaneMesh) -> Array:
        """(m,) weights of the nodes, 1 in all: lengths of the boundary between nodes of the set, else equal."""
        edges = mesh.edges.boundary
        inside = np.isin(edges, self.nodes).all(axis=1)
        lengths = tributary_lengths(mesh.points, edges[inside])[self.nodes]
        if np.any(lengths <= 0.0):
            return np.full(len(self.nodes), 1.0 / len(self.nodes))
        return np.asarray(lengths / lengths.sum())

    def averages(self, mesh: PlaneMesh) -> Array:
        """(3, 2m) mean u_x, u_y and theta of displacements of the nodes, by weighted least squares."""
        motions, weights = self.rigid_motions(mesh), np.repeat(self.weights(mesh), 2)
        weighted = motions.T * weights
        return np.asarray(np.linalg.solve(weighted @ motions, weighted), dtype=float)


@dataclass(frozen=True, eq=False)
class Tie:
    """Displacements of all nodes as a linear function of pins and free displacements.

    u = matrix [pins; u[free]]

    Attributes
    ----------
    matrix : (2n, 3p + f) sparse; columns u_x, u_y, theta of each pin, then the free displacements.
    pins : names of the pins.
    free : (f,) numbers of the free displacements among x0, y0, x1, y1, ...
    averages : (3a, 2n) sparse, rows of the averaged pins: their u_x, u_y, theta as means of nodal displacements; with
        these rows the pins can be held by multipliers instead.
    """

    matrix: csr_array
    pins: tuple[str, ...]
    free: Indices
    averages: csr_array


def tie(interfaces: Sequence[Interface], mesh: PlaneMesh) -> Tie:
    """Displacements of all nodes as a linear function of pins and free displacements.

    A rigid pin moves all of its nodes.  An averaged pin takes three displacements of its nodes, those that determine
    its means best; the others stay free.  A pin with one node, nodes that lie at the pin, and a node of two pins are
    refused.
    """
    _require_separate(interfaces, mesh)
    blocks, rows, taken = [], [], np.zeros(2 * len(mesh.points), dtype=bool)
    for interface in interfaces:
        _require_arms(interface, mesh)
        dofs = (2 * interface.nodes[:, None] + np.arange(2)).ravel()
        if interface.kind == RIGID:
            blocks.append((dofs, dofs[:0], interface.rigid_motions(mesh)))
        else:
            averages = interface.averages(mesh)
            rows.append((dofs, averages))
            blocks.append(_eliminated(dofs, averages))
        taken[blocks[-1][0]] = True
    free = np.flatnonzero(~taken)
    place = np.cumsum(~taken) - 1 + 3 * len(interfaces)
    entries = [(free, place[free], np.ones(len(free)))]
    for number, (dependent, others, values) in enumerate(blocks):
        columns = np.concatenate([3 * number + np.arange(3), place[others]])
        entries.append((np.repeat(dependent, len(columns)), np.tile(columns, len(dependent)), values.ravel()))
    matrix = _sparse(entries, (len(taken), 3 * len(interfaces) + len(free)))
    means = [(np.repeat(3 * a + np.arange(3), len(d)), np.tile(d, 3), B.ravel()) for a, (d, B) in enumerate(rows)]
    names = tuple(interface.name for interface in interfaces)
    return Tie(matrix, names, free, _sparse(means, (3 * len(rows), len(taken))))


def _eliminated(dofs: Indices, averages: Array) -> tuple[Indices, Indices, Array]:
    """Three dependent displacements, the others, and the dependent ones (3, 3 + others) by pin and others."""
    scale = np.abs(averages).max(axis=1, keepdims=True)
    chosen = qr(averages / scale, pivoting=True, mode="r")[1][:3]
    rest = np.setdiff1d(np.arange(len(dofs)), chosen)
    inverse = np.linalg.inv(averages[:, chosen])
    return dofs[chosen], dofs[rest], np.hstack([inverse, -inverse @ averages[:, rest]])


def _sparse(entries: Sequence[tuple[Indices, Indices, Array]], shape: tuple[int, int]) -> csr_array:
    """Sparse matrix of rows, columns and values."""
    if not entries:
        return csr_array(shape)
    rows, columns, values = (np.concatenate(part) for part in zip(*entries, strict=True))
    return csr_array(coo_array((values, (rows, columns)), shape=shape))


def _require_arms(interface: Interface, mesh: PlaneMesh) -> None:
    label = f"{mesh.label}: pin {interface.name!r}"
    if len(interface.nodes) < 2:
        text = f"{label} has one node, which cannot turn it and would be torn out of the body"
        raise InputError(f"{text}. Mesh a hole there, or take a set with more nodes.")
    reach = float(np.linalg.norm(interface.arms(mesh), axis=1).max())
    if reach <= NO_ARM * mesh.size:
        raise InputError(f"{label}: all nodes lie at its point. Take the nodes around the hole.")


def _require_separate(interfaces: Sequence[Interface], mesh: PlaneMesh) -> None:
    owner: dict[int, str] = {}
    for interface in interfaces:
        for node in interface.nodes.tolist():
            if node in owner:
                text = f"{mesh.label}: node {node} belongs to the pins {owner[node]!r} and {interface.name!r}"
                raise InputError(f"{text}. Take sets without common nodes.")
            owner[node] = interface.name
