"""Meshes of plane bodies at chosen instants: places of their points, stresses, outlines."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flexmb.model.shape import MeshShape
from flexmb.planes.recovery import nodal_stresses, von_mises

CORNERS = {"tri3": 3, "tri6": 3, "quad4": 4, "quad9": 4}
"""Number of corners of a cell, by kind."""


@dataclass(frozen=True)
class Surface:
    """The mesh of a body at n instants.

    Parameters
    ----------
    part : name of the body.
    shape : its mesh.
    points : (n, m, 2) [m].
    """

    part: str
    shape: MeshShape
    points: np.ndarray

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

    @cached_property
    def stress(self) -> np.ndarray:
        """(n, m, 4) stresses sx, sy, txy at the points in world axes, and sz [Pa]; 0 without materials."""
        shape = self.shape
        if not shape.materials:
            return np.zeros((*self.points.shape[:2], 4))
        number = shape.material_of or (0,) * len(shape.cells)
        materials = np.array(shape.materials)[list(number)]
        return nodal_stresses(np.array(shape.points), self.cells, shape.kind, materials, self.points)

    @property
    def von_mises(self) -> np.ndarray:
        """(n, m) von Mises stress at the points [Pa]."""
        return von_mises(self.stress)

    def outlines(self) -> list[np.ndarray]:
        """Closed lines (n, points + 1, 2) of the outline and of all holes."""
        return [self.points[:, [*loop, loop[0]]] for loop in self.shape.loops]


def moved_points(shape: MeshShape, poses: np.ndarray) -> np.ndarray:
    """Places (n, m, 2) of all points of a mesh by the poses (n, nodes, 3) of its nodes.

    Parameters
    ----------
    shape : the mesh.
    poses : x, y, theta of the nodes in their order.
    """
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

    Parameters
    ----------
    shape : its mesh.
    poses : (n, nodes, 3) x, y, theta of its nodes.
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
