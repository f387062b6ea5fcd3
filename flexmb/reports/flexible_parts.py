"""Motion of flexible parts, split into a rigid motion and displacements of the nodes against it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmb.model.shape import MARKER, TRACE, BeamShape, PointShape
from flexmb.results.drawing import GROUND, carried, pose
from flexmb.results.resampling import unstressed
from flexmb.results.solution import Solution

NEAR = 0.02
"""Distance of a joint from a node, over the size of the part, below which the joint is taken to hold the node."""


@dataclass(frozen=True)
class FlexiblePart:
    """A flexible part at n instants.

    The rigid motion takes the unstressed part to where the nodes at its joints are, by least squares: with two joints
    along the chord between them, with one along the tangent there, without joints through all nodes.

    Parameters
    ----------
    nodes : names of its nodes.
    reference : (m, 3) x, y, theta of the nodes of the unstressed part, in the frame of the rigid motion [m, rad].
    motion : (n, 3) x, y, theta of the rigid motion [m, rad].
    displacements : (n, m, 3) poses of the nodes in this frame, less the reference [m, rad].
    """

    part: str
    nodes: tuple[str, ...]
    reference: np.ndarray
    motion: np.ndarray
    displacements: np.ndarray


def flexible_parts(sol: Solution, instants: np.ndarray) -> list[FlexiblePart]:
    """All flexible parts of a solution, with the poses of all its nodes, at saved instants with numbers (n,)."""
    beams: dict[str, list[BeamShape]] = {}
    for shape in sol.shapes:
        if isinstance(shape, BeamShape):
            beams.setdefault(shape.part, []).append(shape)
    joints = _joint_points(sol, instants[:1])
    return [_flexible_part(sol, part, elements, joints, instants) for part, elements in beams.items()]


def _joint_points(sol: Solution, first: np.ndarray) -> np.ndarray:
    """Places (k, 2) of all joints at the first instant [m]."""
    places = [np.zeros((0, 2))]
    for shape in sol.shapes:
        if isinstance(shape, PointShape) and shape.kind not in (MARKER, TRACE):
            at = pose(sol, shape.body, shape.node, first) if shape.body != GROUND else np.zeros((1, 3))
            places.append(carried(at, np.array([shape.offset], dtype=float))[0])
    return np.concatenate(places)


def _flexible_part(
    sol: Solution, part: str, elements: Sequence[BeamShape], joints: np.ndarray, instants: np.ndarray
) -> FlexiblePart:
    found = unstressed(elements)
    nodes, reference = tuple(found), np.array(list(found.values()))
    poses = np.stack([pose(sol, part, node, instants) for node in nodes], axis=1)
    size = float(np.ptp(reference[:, :2], axis=0).max())
    apart = np.hypot(*(poses[0, :, None, :2] - joints[None]).transpose(2, 0, 1))
    held = np.flatnonzero((apart < NEAR * size).any(axis=1))
    chosen = held if len(held) else np.arange(len(nodes))
    motion = rigid_motion(reference[chosen], poses[:, chosen])
    c, s = np.cos(motion[:, 2, None]), np.sin(motion[:, 2, None])
    dx, dy = (poses[:, :, k] - motion[:, k, None] for k in (0, 1))
    turned = poses[:, :, 2] - motion[:, 2, None] - reference[:, 2]
    turned -= 2.0 * np.pi * np.round(turned / (2.0 * np.pi))
    local = np.stack([c * dx + s * dy - reference[:, 0], c * dy - s * dx - reference[:, 1], turned], axis=-1)
    return FlexiblePart(part, nodes, reference, motion, local)


def rigid_motion(reference: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Rigid motion (n, 3) that takes nodes to their poses by least squares; the angle of one node is its theta.

    `reference` (m, 3) are x, y, theta of the nodes in the moved frame, `poses` (n, m, 3) those of the nodes [m, rad].
    """
    centre, middle = reference[:, :2].mean(axis=0), poses[:, :, :2].mean(axis=1)
    if len(reference) == 1:
        angle = poses[:, 0, 2] - reference[0, 2]
    else:
        a, b = reference[:, :2] - centre, poses[:, :, :2] - middle[:, None]
        along = (a[None] * b).sum(axis=(1, 2))
        across = (a[None, :, 0] * b[:, :, 1] - a[None, :, 1] * b[:, :, 0]).sum(axis=1)
        angle = np.unwrap(np.arctan2(across, along))
    c, s = np.cos(angle), np.sin(angle)
    x = middle[:, 0] - c * centre[0] + s * centre[1]
    y = middle[:, 1] - s * centre[0] - c * centre[1]
    return np.stack([x, y, angle], axis=-1)
