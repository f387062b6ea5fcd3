"""Meshes of plane bodies at chosen instants: places of their points, stresses, outlines."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flexmb.model.shape import MeshShape
from flexmb.planes.recovery import linear_stresses, nodal_stresses, von_mises
from flexmb.reduction.kernel import FIRST

CORNERS = {"tri3": 3, "tri6": 3, "quad4": 4, "quad9": 4}
"""Number of corners of a cell, by kind."""


PIECES = {
    "tri3": ((0, 1, 2),),
    "tri6": ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
    "quad4": ((0, 1, 2), (0, 2, 3)),
    "quad9": ((0, 4, 8), (0, 8, 7), (4, 1, 5), (4, 5, 8), (8, 5, 2), (8, 2, 6), (7, 8, 6), (7, 6, 3)),
}
"""Triangles between the points of a cell, by kind."""


@dataclass(frozen=True)
class Surface:
    """The mesh of a body at n instants.

    Parameters
    ----------
    shape : its mesh.
    points : (n, m, 2) drawn places, of which a deformation may be magnified [m].
    poses : (n, nodes, 3) x, y, theta of the nodes, from which stresses are found [m, rad].
    """

    part: str
    shape: MeshShape
    points: np.ndarray
    poses: np.ndarray

    @property
    def cells(self) -> np.ndarray:
        """(k, nodes) numbers of the points of each cell."""
        return np.array(self.shape.cells, dtype=np.int64)

    @property
    def rims(self) -> np.ndarray:
        """(k, points) numbers of the points around each cell, in order."""
        cells, corners = self.cells, CORNERS[self.shape.kind]
        if cells.shape[1] == corners:
            return cells
        around: np.ndarray = np.stack([cells[:, :corners], cells[:, corners : 2 * corners]], axis=2)
        return around.reshape(len(cells), -1)

    @property
    def triangles(self) -> np.ndarray:
        """(k, 3) numbers of the points of triangles, some of them to a cell."""
        return self.cells[:, PIECES[self.shape.kind]].reshape(-1, 3)

    @cached_property
    def stress(self) -> np.ndarray:
        """(n, m, 4) stresses sx, sy, txy at the points in world axes, and sz [Pa]; 0 without materials."""
        shape = self.shape
        if not shape.materials:
            return np.zeros((*self.points.shape[:2], 4))
        number = shape.material_of or (0,) * len(shape.cells)
        mesh = np.array(shape.points), self.cells, shape.kind, np.array(shape.materials)[list(number)]
        if not shape.basis:
            return nodal_stresses(*mesh, moved_points(shape, self.poses))
        shapes = np.array(shape.basis).T.reshape(-1, len(shape.points), 2)
        own = np.einsum("ti,ims->tms", self._shortened, linear_stresses(*mesh, shapes), optimize=True)
        return turned(own, deformed(shape, self.poses)[1])

    @cached_property
    def von_mises(self) -> np.ndarray:
        """(n, m) von Mises stress at the points [Pa]; of reduced beams the normal stress in the outer fibres."""
        if self.shape.fibres:
            normal: np.ndarray = np.abs(self._shortened @ np.array(self.shape.fibres).T)
            return normal
        return von_mises(self.stress)

    @property
    def has_stress(self) -> bool:
        """Whether the stress is known."""
        return bool(self.shape.materials or self.shape.fibres)

    @property
    def _shortened(self) -> np.ndarray:
        """(n, coordinates) deformation of a reduced body with its shortening by bending, e of equation (12.11)."""
        return shortened(deformed(self.shape, self.poses)[0], np.array(self.shape.shortening))

    def outlines(self) -> list[np.ndarray]:
        """Closed lines (n, points + 1, 2) of the outline and of all holes."""
        return [self.points[:, [*loop, loop[0]]] for loop in self.shape.loops]


def moved_points(shape: MeshShape, poses: np.ndarray) -> np.ndarray:
    """Places (n, m, 2) of all points of a mesh by the poses (n, nodes, 3) x, y, theta of its nodes."""
    if shape.basis:
        return _reduced(shape, poses)
    carriers = np.array(shape.carriers, dtype=float)
    node, (x, y) = carriers[:, 0].astype(np.int64), carriers[:, 1:].T
    pose = poses[:, node]
    c, s = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    return np.stack([pose[..., 0] + c * x - s * y, pose[..., 1] + s * x + c * y], axis=-1)


def _reduced(shape: MeshShape, poses: np.ndarray) -> np.ndarray:
    """Places of a reduced body: the frame carries the reference configuration and the displacements in it."""
    d, angle = deformed(shape, poses)
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    own = np.array(shape.points) + (d.reshape(len(d), -1) @ np.array(shape.basis).T).reshape(len(d), -1, 2)
    x, y = own[..., 0], own[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def deformed(shape: MeshShape, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Deformations (n, nodes, 3) of a reduced body in its frame, and the angle (n,) of the frame [rad].

    The poses (n, nodes, 3) of its nodes are x, y, theta.
    """
    reference = np.array(shape.poses)
    angle = poses[:, 0, 2] - reference[0, 2]
    if shape.weights:
        weights = np.array(shape.weights)
        along = (weights * poses[..., :2]).sum(axis=(1, 2))
        across = (weights[:, 0] * poses[..., 1] - weights[:, 1] * poses[..., 0]).sum(axis=1)
        angle = np.arctan2(across, along)
        turns = poses[:, 0, 2] - reference[0, 2] - angle
        angle = angle + 2.0 * np.pi * np.round(turns / (2.0 * np.pi))
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    d = np.empty_like(poses)
    d[..., 0] = c * poses[..., 0] + s * poses[..., 1] - reference[:, 0]
    d[..., 1] = c * poses[..., 1] - s * poses[..., 0] - reference[:, 1]
    d[..., 2] = poses[..., 2] - angle[:, None] - reference[:, 2]
    return d, angle


def shortened(d: np.ndarray, shortening: np.ndarray) -> np.ndarray:
    """Deformation e = d + c(d) (n, coordinates) of a reduced body from d (n, nodes, 3), with its shortening by bending.

    The translation of the first node is left out, which has no stress but its round-off.  `shortening` (k, n + 1, n)
    has directions, each above its matrix; (k, n, n) in older files: matrices of the coordinates from the fourth one on.
    """
    e: np.ndarray = (d - d[:, :1] * np.array([1.0, 1.0, 0.0])).reshape(len(d), -1)
    if not len(shortening):
        return e
    matrices, n = shortening[:, -e.shape[1] :], e.shape[1]
    along = shortening[:, 0] if shortening.shape[1] > n else np.eye(n)[FIRST : FIRST + len(shortening)]
    e += 0.5 * np.einsum("ti,kij,tj->tk", e, matrices, e, optimize=True) @ along
    return e


def turned(stress: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Stresses (n, m, 4) sx, sy, txy, sz in axes from which their own ones are turned by angles (n,) [rad]."""
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    sx, sy, t, sz = np.moveaxis(stress, -1, 0)
    xx, yy = c * c * sx + s * s * sy - 2.0 * c * s * t, s * s * sx + c * c * sy + 2.0 * c * s * t
    return np.stack([xx, yy, c * s * (sx - sy) + (c * c - s * s) * t, sz], axis=-1)


def few_shapes(moved: np.ndarray, limit: float) -> tuple[np.ndarray, np.ndarray]:
    """Factors (n, k) and shapes (k, m), as few as possible, of displacements (n, m), the sum within a limit [m].

    Proper orthogonal decomposition, by the eigenvectors of the products of instants or of displacements, of which there
    are fewer: a singular value decomposition takes ten times as long.
    """
    wide = len(moved) <= moved.shape[1]
    vectors = np.linalg.eigh(moved @ moved.T if wide else moved.T @ moved)[1][:, ::-1]
    factors, shapes = (vectors, vectors.T @ moved) if wide else (moved @ vectors, vectors.T)
    count, rest = 0, moved.copy()
    while count < len(shapes) and np.abs(rest).max(initial=0.0) > limit:
        rest -= np.outer(factors[:, count], shapes[count])
        count += 1
    return factors[:, :count], shapes[:count]
