"""Meshes of flexible bodies for a page: rigid motion, deformation as a sum of few shapes, stress at few points."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexmb.model.shape import MeshShape
from flexmb.reports.flexible_parts import rigid_motion
from flexmb.reports.packing import COARSE, FINE, quantised
from flexmb.results import drawing
from flexmb.results.resampling import body_joints, turning_nodes
from flexmb.results.solution import Solution
from flexmb.results.surfaces import Surface, few_shapes

MOST_POINTS = 1500
"""Number of points of all meshes of a page, about, whose stress is shown; of a finer mesh some points stand for all."""

LOOP_POINTS = 160
"""Largest number of points of an outline or of a hole, about."""

WIDER = 1.1
"""Factor by which the squares grow, in each of which one point is kept, until there are few enough."""

SEEN = 2.5e-4
"""Error of the deformation over the largest displacement, at most; no magnification shows more."""


@dataclass(frozen=True)
class MeshPart:
    """A flexible body with a mesh at n instants.

    Parameters
    ----------
    shape : its mesh; its `poses` and `points` are those without deformation.
    surface : its places and stresses.
    motion : (n, 3) x, y, theta of the rigid motion that takes the undeformed body to its joints [m, rad].
    """

    shape: MeshShape
    surface: Surface
    motion: np.ndarray

    def in_frame(self, points: np.ndarray) -> np.ndarray:
        """Places (n, m, 2) [m] in the frame of the rigid motion."""
        c, s = np.cos(self.motion[:, 2, None]), np.sin(self.motion[:, 2, None])
        dx, dy = (points[..., k] - self.motion[:, k, None] for k in (0, 1))
        return np.stack([c * dx + s * dy, c * dy - s * dx], axis=-1)

    def node(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Undeformed pose (3,) of a node, and its displacements (n, 3), in the frame [m, rad]."""
        k = self.shape.nodes.index(name)
        pose, reference = self.surface.poses[:, k], np.array(self.shape.poses[k])
        turned = pose[:, 2] - self.motion[:, 2] - reference[2]
        turned -= 2.0 * np.pi * np.round(turned / (2.0 * np.pi))
        moved = self.in_frame(pose[:, None, :2])[:, 0] - reference[:2]
        return reference, np.column_stack([moved, turned])

    def packed(self, frame: int, most: int) -> dict[str, Any]:
        """Data of the page, with about `most` points with a stress; `frame` is the number of the motion's frame."""
        kept, triangles, loops = coarse(self.surface, most)
        own, reference = self.in_frame(self.surface.points[:, kept]), np.array(self.shape.points)[kept]
        moved = (own - reference).transpose(0, 2, 1).reshape(len(own), -1)
        largest = float(np.abs(moved).max(initial=0.0))
        weights, shapes = few_shapes(moved, SEEN * largest)
        found: dict[str, Any] = {
            "part": self.shape.part,
            "frame": frame,
            "points": quantised(reference, FINE),
            "triangles": triangles.ravel().tolist(),
            "loops": [loop.tolist() for loop in loops],
            "largest": largest,
            "weights": quantised(weights, FINE),
            "shapes": quantised(shapes.T, FINE),
        }
        if self.surface.has_stress:
            found["stress"] = quantised(self.surface.von_mises[:, kept], COARSE, common=True)
        return found


def mesh_parts(sol: Solution, instants: np.ndarray) -> list[MeshPart]:
    """All bodies with meshes at saved instants with numbers (n,); the solution has the poses of all their nodes."""
    return [_mesh_part(sol, shape, instants) for shape in sol.shapes if isinstance(shape, MeshShape)]


def _mesh_part(sol: Solution, shape: MeshShape, instants: np.ndarray) -> MeshPart:
    surface = drawing.surface(sol, shape, instants)
    if not shape.poses:  # a file of before: undeformed as at the first instant
        shape = replace(shape, poses=tuple(map(tuple, surface.poses[0].tolist())))
    joints = body_joints(sol, shape.part, list(shape.nodes))
    chosen = list(joints) if len(joints) > 1 or any(joints.values()) else turning_nodes(shape)
    motion = rigid_motion(np.array(shape.poses)[chosen], surface.poses[:, chosen])
    if len(joints) == 1 and not any(joints.values()):  # it turns with all, and stays at its joint
        (joint,) = joints
        motion = _held(motion, np.array(shape.poses)[joint], surface.poses[:, joint])
    return MeshPart(shape, surface, motion)


def _held(motion: np.ndarray, reference: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """The rigid motion (n, 3), moved so that it takes a reference pose (3,) to the place of the poses (n, 3)."""
    c, s = np.cos(motion[:, 2]), np.sin(motion[:, 2])
    x, y = reference[:2]
    return np.column_stack([pose[:, 0] - c * x + s * y, pose[:, 1] - s * x - c * y, motion[:, 2]])


def coarse(surface: Surface, most: int) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Numbers of representative points of a mesh, and the triangles and loops between these.

    Squares of one size lie over the mesh; one point of each stands for the others, one of the outline where there is
    one.  Triangles whose corners fall together are left out.
    """
    points, triangles = np.array(surface.shape.points), surface.triangles
    loops = [np.array(loop)[:: -(-len(loop) // LOOP_POINTS)] for loop in surface.shape.loops]
    if len(points) > most:
        rim = np.zeros(len(points), dtype=bool)
        rim[np.concatenate([np.array(loop) for loop in surface.shape.loops])] = True
        triangles = _stood_for(points, rim, most)[triangles]
        whole = [triangles[:, k] != triangles[:, j] for k, j in ((0, 1), (1, 2), (2, 0))]
        triangles = triangles[np.logical_and.reduce(whole)]
        triangles = triangles[np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)[1]]
    kept = np.unique(np.concatenate([triangles.ravel(), *loops]))
    number = np.zeros(len(points), dtype=np.int64)
    number[kept] = np.arange(len(kept))
    return kept, number[triangles], [number[loop] for loop in loops]


def _stood_for(points: np.ndarray, rim: np.ndarray, most: int) -> np.ndarray:
    """Number (n,) of the point that stands for each point."""
    low, high = points.min(axis=0), points.max(axis=0)
    side = float(np.sqrt(np.prod(high - low) / most))
    while True:
        squares, of = np.unique(np.floor((points - low) / side).astype(np.int64), axis=0, return_inverse=True)
        if len(squares) <= most:
            break
        side *= WIDER
    of = of.ravel()
    counts = np.bincount(of)
    middle = np.stack([np.bincount(of, points[:, k]) / counts for k in (0, 1)], axis=1)
    away = np.hypot(*(points - middle[of]).T) + np.where(rim, 0.0, 10.0 * side)
    order = np.lexsort((away, of))
    first = order[np.searchsorted(of[order], np.arange(len(squares)))]
    return np.asarray(first[of])
