"""Stresses at the nodes of a mesh from the places of its nodes, at any rotation.

In every cell, displacements are those against its own axes, which turn with its mean deformation gradient.  Stresses
are taken at the points where they are most exact, carried to the nodes by the functions that fit these points, turned
into world axes, and averaged over the cells of a node with their areas as weights: as by `stress`, at any rotation.
Source: E. Hinton, J. S. Campbell, Local and global smoothing of discontinuous finite element functions using a least
squares method, Int. J. Numer. Meth. Engng 8 (1974) 461-480; J. Barlow, Optimal stress locations in finite element
models, Int. J. Numer. Meth. Engng 10 (1976) 243-251.
"""

from __future__ import annotations

import math

import numpy as np
from skfem.quadrature import get_quadrature

from flexmb.planes.cell_kinds import KINDS

GAUSS = 0.5 / math.sqrt(3.0)
"""Distance of the two Gauss points of the unit interval from its middle."""

FOUR = tuple((0.5 + a * GAUSS, 0.5 + b * GAUSS) for b in (-1, 1) for a in (-1, 1))
"""The 2 x 2 Gauss points of the unit square."""

SAMPLES = {
    "tri3": ((1.0 / 3.0, 1.0 / 3.0),),
    "tri6": ((1.0 / 6.0, 1.0 / 6.0), (2.0 / 3.0, 1.0 / 6.0), (1.0 / 6.0, 2.0 / 3.0)),
    "quad4": FOUR,
    "quad9": FOUR,
}
"""Points of the reference cell where stresses are most exact (Barlow), by kind."""


def carried_to_nodes(kind: str) -> np.ndarray:
    """(nodes, samples), values at the nodes of functions of the values at the samples."""
    samples, nodes = np.array(SAMPLES[kind], dtype=float), KINDS[kind].reference_nodes.T

    def terms(places: np.ndarray) -> np.ndarray:
        x, y = places.T
        return np.stack([np.ones_like(x), x, y, x * y], axis=1)[:, : len(samples)]

    found: np.ndarray = terms(nodes) @ np.linalg.inv(terms(samples))
    return found


def gradients_at_nodes(points: np.ndarray, cells: np.ndarray, kind: str) -> np.ndarray:
    """(cells, nodes, nodes, 2): gradients [1/m] that give the recovered strain at a node (second axis) of a cell."""
    gradients = gradients_at(points, cells, kind, np.array(SAMPLES[kind], dtype=float).T)[1]
    found: np.ndarray = np.einsum("kp,cpnx->cknx", carried_to_nodes(kind), gradients)
    return found


def gradients_at(points: np.ndarray, cells: np.ndarray, kind: str, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Jacobian determinants (m, q) [m^2] and gradients (m, q, k, 2) [1/m] at places (2, q) of the reference cell."""
    slopes = KINDS[kind].shape_functions(places)[1]
    jacobian = np.einsum("rnp,cnx->cpxr", slopes, points[cells])
    gradients: np.ndarray = np.einsum("rnp,cprx->cpnx", slopes, np.linalg.inv(jacobian))
    return np.linalg.det(jacobian), gradients


def areas_and_means(points: np.ndarray, cells: np.ndarray, kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Areas (m,) of the cells [m^2], and means (m, k, 2) of the gradients over them [1/m]."""
    cell = KINDS[kind]
    places, weights = get_quadrature(cell.element.refdom, cell.stiffness_order)
    area, gradients = gradients_at(points, cells, kind, places)
    area = area * weights
    whole = area.sum(axis=1)
    return whole, np.einsum("cp,cpnx->cnx", area / whole[:, None], gradients)


def around_nodes(cells: np.ndarray, areas: np.ndarray, count: int) -> np.ndarray:
    """Area (count,) of all cells of each node [m^2]."""
    found: np.ndarray = np.bincount(cells.ravel(), np.repeat(areas, cells.shape[1]), minlength=count)
    return found


def nodal_stresses(
    points: np.ndarray, cells: np.ndarray, kind: str, materials: np.ndarray, x: np.ndarray
) -> np.ndarray:
    """Stresses (n, nodes, 4) sx, sy, txy in world axes and sz [Pa] at n instants.

    `points` (nodes, 2) are places without stress, `x` (n, nodes, 2) places [m]; cells are (m, k), `materials` (m, 4)
    d11, d12, d33 [Pa] of each cell, and sz over sx + sy.
    """
    (areas, mean), own = areas_and_means(points, cells, kind), gradients_at_nodes(points, cells, kind)
    whole = around_nodes(cells, areas, len(points))
    found = np.zeros((len(x), len(points), 4))
    for now, sums in zip(x, found, strict=True):
        in_cells = _in_cells(points[cells], now[cells], mean, own, materials)
        np.add.at(sums, cells, areas[:, None, None] * in_cells)
    found /= whole[:, None]
    return found


def linear_stresses(
    points: np.ndarray, cells: np.ndarray, kind: str, materials: np.ndarray, u: np.ndarray
) -> np.ndarray:
    """Stresses (n, nodes, 4) sx, sy, txy, sz [Pa] of n small displacements u (n, nodes, 2) [m].

    They are those of `nodal_stresses` without rotations.
    """
    areas, own = areas_and_means(points, cells, kind)[0], gradients_at_nodes(points, cells, kind)
    found = np.zeros((len(u), len(points), 4))
    for now, sums in zip(u, found, strict=True):
        S = _elastic(np.einsum("cna,cknx->ckax", now[cells], own), materials)
        np.add.at(sums, cells, areas[:, None, None] * _listed(S, materials))
    found /= around_nodes(cells, areas, len(points))[:, None]
    return found


def _in_cells(X: np.ndarray, x: np.ndarray, mean: np.ndarray, own: np.ndarray, materials: np.ndarray) -> np.ndarray:
    """Stresses (m, k, 4) at the nodes of all cells."""
    F = np.einsum("cna,cnx->cax", x - x[:, :1], mean)
    a, b = F[:, 0, 0] + F[:, 1, 1], F[:, 1, 0] - F[:, 0, 1]
    size = np.hypot(a, b)
    c, s = a / size, b / size
    R = np.stack([np.stack([c, -s], axis=1), np.stack([s, c], axis=1)], axis=1)
    d = np.einsum("cab,cna->cnb", R, x - x[:, :1]) - (X - X[:, :1])
    H = np.einsum("cna,cknx->ckax", d, own)
    return _listed(np.einsum("cai,ckij,cbj->ckab", R, _elastic(H, materials), R), materials)


def _elastic(H: np.ndarray, materials: np.ndarray) -> np.ndarray:
    """Stresses (m, k, 2, 2) in the plane of displacement gradients (m, k, 2, 2)."""
    d11, d12, d33, _ = materials.T[:, :, None]
    ex, ey, shear = H[..., 0, 0], H[..., 1, 1], H[..., 0, 1] + H[..., 1, 0]
    S = np.empty_like(H)
    S[..., 0, 0], S[..., 1, 1] = d11 * ex + d12 * ey, d12 * ex + d11 * ey
    S[..., 0, 1] = S[..., 1, 0] = d33 * shear
    return S


def _listed(S: np.ndarray, materials: np.ndarray) -> np.ndarray:
    """Stresses (m, k, 4) sx, sy, txy, sz."""
    sx, sy = S[..., 0, 0], S[..., 1, 1]
    return np.stack([sx, sy, S[..., 0, 1], materials[:, 3, None] * (sx + sy)], axis=-1)


def von_mises(stress: np.ndarray) -> np.ndarray:
    """Von Mises stress [Pa] of stresses (..., 4) sx, sy, txy, sz."""
    sx, sy, txy, sz = np.moveaxis(stress, -1, 0)
    half = 0.5 * ((sx - sy) ** 2 + (sy - sz) ** 2 + (sz - sx) ** 2)
    found: np.ndarray = np.sqrt(half + 3.0 * txy**2)
    return found
