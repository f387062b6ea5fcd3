"""Pins of plane bodies: nodes tied to a point with a rotation, rigidly (RBE2) or in the mean (RBE3).

With weights w (sum 1), arms r_k of the nodes from the pin in the mesh, their mean c = sum w r_k and s_k = r_k - c:

    x_pin = sum w x_k - R c,     sum w (R s_k) x x_k = 0

R = R(theta) is the rotation that fits the nodes best in the sense of least squares.  No stiffness is added.  The
weights are the lengths of the boundary that belong to the nodes.
Source: R. D. Cook et al., Concepts and Applications of Finite Element Analysis, 4th ed., Wiley 2002, section 13.2
(constraint equations); the rotation by least squares is Horn's, J. Opt. Soc. Am. A 4 (1987) 629-642, in the plane.
Equations (11.6), (11.7) and (11.9) of docs/theory/plane_bodies.md.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr
from scipy.sparse import coo_array, csr_array

from flexmb.elastic.meshes.mesh import PlaneMesh, tributary_lengths
from flexmb.errors import InputError
from flexmb.kernels import constraint_kernel
from flexmb.model.contributions import ConstraintContribution, Coordinate
from flexmb.planar import Array, Indices

MEAN_X, MEAN_Y, MOMENT, WEIGHTS = range(4)  # parameters p: c, sum w |s|^2 [m^2], then three numbers of every node
WEIGHT, ARM_X, ARM_Y, PER_NODE = range(4)  # numbers of a node: its weight and s; PER_NODE is their count


@constraint_kernel
def averaged_pin_kernel(p, t, q, v, lam, g, G, g_t, gamma, H):
    """Pin (x, y, theta) and nodes (x, y) each: two equations of the place [m], one of the rotation [rad]."""
    c, s, spin = math.cos(q[2]), math.sin(q[2]), v[2]
    mx, my = c * p[MEAN_X] - s * p[MEAN_Y], s * p[MEAN_X] + c * p[MEAN_Y]
    g[0], g[1] = q[0] + mx, q[1] + my
    G[0, 0], G[1, 1], G[0, 2], G[1, 2] = 1.0, 1.0, -my, mx
    gamma[0], gamma[1] = spin * spin * mx, spin * spin * my
    cross, dot, dot_rate, unit = 0.0, 0.0, 0.0, 1.0 / p[MOMENT]
    for k in range((q.shape[0] - 3) // 2):
        i, at = 3 + 2 * k, WEIGHTS + PER_NODE * k
        w, x, y = p[at + WEIGHT], p[at + ARM_X], p[at + ARM_Y]
        ax, ay = unit * w * (c * x - s * y), unit * w * (s * x + c * y)
        g[0] -= w * q[i]
        g[1] -= w * q[i + 1]
        cross += ax * q[i + 1] - ay * q[i]
        dot += ax * q[i] + ay * q[i + 1]
        dot_rate += ax * v[i] + ay * v[i + 1]
        G[0, i], G[1, i + 1] = -w, -w
        G[2, i], G[2, i + 1] = -ay, ax
        H[2, i], H[2, i + 1] = -lam[2] * ax, -lam[2] * ay
        H[i, 2], H[i + 1, 2] = -lam[2] * ax, -lam[2] * ay
    g[2], G[2, 2] = cross, -dot
    gamma[2], H[2, 2] = spin * (2.0 * dot_rate + spin * cross), -(lam[0] * mx + lam[1] * my) - lam[2] * cross


def averaged_pin(
    part: str, coordinates: tuple[Coordinate, ...], arms: np.ndarray, weights: np.ndarray
) -> ConstraintContribution:
    """Constraint of a pin, x, y, theta, by x, y of every node; arms (n, 2) to nodes [m], weights (n,) of sum 1."""
    mean = weights @ arms
    own = arms - mean
    moment = float(weights @ (own**2).sum(axis=1))
    numbers = tuple(map(float, [*mean, moment, *np.column_stack([weights, own]).ravel()]))
    return ConstraintContribution(part, averaged_pin_kernel, coordinates, numbers, 3, is_drive=True)


RIGID, AVERAGED = "rigid", "averaged"  # kinds of interfaces
NO_ARM = 1e-9  # distance of nodes over the size of the mesh [1] below which they cannot turn a pin


@dataclass(frozen=True, eq=False)
class Interface:
    """A set of nodes that moves with one point."""

    name: str
    nodes: Indices  # node numbers of the set
    point: tuple[float, float]  # place of the pin in the axes of the mesh [m]
    kind: str = RIGID  # "rigid" or "averaged"

    def arms(self, mesh: PlaneMesh) -> Array:
        """(m, 2) places of the nodes from the pin [m]."""
        return np.asarray(mesh.points[self.nodes] - np.asarray(self.point))

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
        lengths = tributary_lengths(mesh.points, edges[np.isin(edges, self.nodes).all(axis=1)])[self.nodes]
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
    """Displacements of all nodes, linear in pins and free displacements: u = matrix [pins; u[free]]."""

    matrix: csr_array  # (2n, 3p + f) sparse; columns u_x, u_y, theta of each pin, then the free displacements
    pins: tuple[str, ...]  # names of the pins
    free: Indices  # (f,) numbers of the free displacements among x0, y0, x1, y1, ...
    # (3a, 2n) sparse, rows of the averaged pins: their u_x, u_y, theta as means of nodal displacements; with these rows
    # the pins can be held by multipliers instead
    averages: csr_array


def tie(interfaces: Sequence[Interface], mesh: PlaneMesh) -> Tie:
    """Displacements of all nodes as a linear function of pins and free displacements."""
    # A rigid pin moves all of its nodes. An averaged pin takes three displacements of its nodes, those that determine
    # its means best; the others stay free. A pin with one node, nodes that lie at the pin, and a node of two pins are
    # refused.
    owner: dict[int, str] = {}
    for interface in interfaces:
        for node in interface.nodes.tolist():
            if node in owner:
                text = f"{mesh.label}: node {node} belongs to the pins {owner[node]!r} and {interface.name!r}"
                raise InputError(f"{text}. Take sets without common nodes.")
            owner[node] = interface.name
    blocks, rows, taken = [], [], np.zeros(2 * len(mesh.points), dtype=bool)
    for interface in interfaces:
        _require_arms(interface, mesh)
        dofs = (2 * interface.nodes[:, None] + np.arange(2)).ravel()
        if interface.kind == RIGID:
            blocks.append((dofs, dofs[:0], interface.rigid_motions(mesh)))
        else:
            averages = interface.averages(mesh)
            rows.append((dofs, averages))
            # Three dependent displacements, the others, and the dependent ones (3, 3 + others) by pin and others
            chosen = qr(averages / np.abs(averages).max(axis=1, keepdims=True), pivoting=True, mode="r")[1][:3]
            rest = np.setdiff1d(np.arange(len(dofs)), chosen)
            inverse = np.linalg.inv(averages[:, chosen])
            blocks.append((dofs[chosen], dofs[rest], np.hstack([inverse, -inverse @ averages[:, rest]])))
        taken[blocks[-1][0]] = True
    free, place = np.flatnonzero(~taken), np.cumsum(~taken) - 1 + 3 * len(interfaces)
    entries = [(free, place[free], np.ones(len(free)))]
    for number, (dependent, others, values) in enumerate(blocks):
        columns = np.concatenate([3 * number + np.arange(3), place[others]])
        entries.append((np.repeat(dependent, len(columns)), np.tile(columns, len(dependent)), values.ravel()))
    matrix = _sparse(entries, (len(taken), 3 * len(interfaces) + len(free)))
    means = [(np.repeat(3 * a + np.arange(3), len(d)), np.tile(d, 3), B.ravel()) for a, (d, B) in enumerate(rows)]
    names = tuple(interface.name for interface in interfaces)
    return Tie(matrix, names, free, _sparse(means, (3 * len(rows), len(taken))))


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
    if float(np.linalg.norm(interface.arms(mesh), axis=1).max()) <= NO_ARM * mesh.size:
        raise InputError(f"{label}: all nodes lie at its point. Take the nodes around the hole.")
