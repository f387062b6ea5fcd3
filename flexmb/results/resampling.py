"""Solutions at other instants than the saved ones, and with a magnified deformation, for pictures and films."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmb.model.shape import BeamShape, MeshShape, PointShape
from flexmb.results.drawing import pose
from flexmb.results.peaks import Peaks
from flexmb.results.solution import Solution

COORDINATES = (".x", ".y", ".theta")
"""Endings of the names of coordinates."""


def at_times(sol: Solution, times: np.ndarray) -> Solution:
    """Solution whose rows belong to any instants between the first and the last saved row.

    Coordinates follow cubic polynomials through both neighbouring rows, with the slopes there of the parabolas through
    three rows (Catmull and Rom).  Other signals are interpolated linearly; modes keep the value of the row before.
    `times` (n,) increase [s].
    """
    rows = np.flatnonzero(np.append(np.diff(sol.time) > 0.0, True))  # the last of rows of one time
    time = sol.time[rows]
    left = np.clip(np.searchsorted(time, times, side="right") - 1, 0, max(len(rows) - 2, 0))
    right = np.minimum(left + 1, len(rows) - 1)
    h = time[right] - time[left]
    w = np.clip(np.divide(times - time[left], h, out=np.zeros(len(times)), where=h > 0.0), 0.0, 1.0)[:, None]
    before, after = sol.values[rows[left]], sol.values[rows[right]]
    values = np.where(w < 1.0, before + w * (after - before), after)
    held = [k for name, k in sol.signals.places.items() if name.endswith(".mode")]
    values[:, held] = np.where(w < 1.0, before[:, held], after[:, held])
    if len(rows) > 2:
        smooth = [k for name, k in sol.signals.places.items() if name.endswith(COORDINATES)]
        change = (after - before)[:, smooth]
        first, second = (h[:, None] * _slopes(sol.values, time, rows, k, smooth) - change for k in (left, right))
        values[:, smooth] += w * (1.0 - w) * ((1.0 - w) * first - w * second)
    return with_values(sol, np.asarray(times, dtype=float), values)


def _slopes(values: np.ndarray, time: np.ndarray, rows: np.ndarray, k: np.ndarray, places: list[int]) -> np.ndarray:
    """Slopes at rows k of the parabolas through three rows each."""
    begin = np.clip(k - 1, 0, len(rows) - 3)
    t0, t1, t2 = (time[begin + j][:, None] for j in range(3))
    x0, x1, x2 = (values[rows[begin + j]][:, places] for j in range(3))
    t, d01, d12 = time[k][:, None], (x1 - x0) / (t1 - t0), (x2 - x1) / (t2 - t1)
    return np.asarray(d01 + (2.0 * t - t0 - t1) * (d12 - d01) / (t2 - t0))


def with_values(sol: Solution, time: np.ndarray, values: np.ndarray) -> Solution:
    """Solution with other rows: instants (n,) [s] and signals (n, n_s)."""
    peaks = Peaks(np.abs(values).max(axis=0, initial=0.0), np.zeros(values.shape[1]))
    return replace(sol, time=time, values=values, peaks=peaks)


def magnified(sol: Solution, factor: float) -> Solution:
    """Solution with a magnified deformation of the flexible bodies, for pictures alone.

    The deformation of a body is the difference from its unstressed shape, which is laid through its joints (best fit);
    through its clamped end, if it has no other joint; and through all its nodes, if it has none.  So bodies stay
    together at their joints.  The factor 1 gives the solution itself.
    """
    if factor == 1.0:
        return sol
    values, rows = sol.values.copy(), np.arange(len(sol.time))
    for part, (nodes, shape, seen) in _unstressed_bodies(sol).items():
        poses = np.stack([pose(sol, part, node, rows) for node in nodes], axis=1)  # (n, m, 3)
        rigid = _rigid_fit(shape, poses, body_joints(sol, part, nodes), seen)
        drawn = rigid + factor * (poses - rigid)
        places = [sol.signals.places[f"{part}.{node}{axis}"] for node in nodes for axis in COORDINATES]
        values[:, places] = drawn.reshape(len(rows), -1)
    return with_values(sol, sol.time, values)


def _unstressed_bodies(sol: Solution) -> dict[str, tuple[list[str], np.ndarray, list[int]]]:
    """Flexible bodies: names of their nodes, unstressed poses (m, 3), numbers of the nodes that turn with the body."""
    found = {}
    for part, beams in _beams(sol).items():
        shape = unstressed(beams)
        found[part] = list(shape), np.array(list(shape.values())), list(range(len(shape)))
    for mesh in sol.shapes:
        if isinstance(mesh, MeshShape) and mesh.poses:  # files of before have none of bodies with all nodes
            found[mesh.part] = list(mesh.nodes), np.array(mesh.poses), turning_nodes(mesh)
    return found


def turning_nodes(mesh: MeshShape) -> list[int]:
    """Numbers of the nodes of a body, of a reduced one of its pins alone."""
    pins = [k for k, weight in enumerate(mesh.weights) if any(weight)] or [0]
    return pins if mesh.basis else list(range(len(mesh.nodes)))


def _beams(sol: Solution) -> dict[str, list[BeamShape]]:
    """Beam elements by flexible part."""
    found: dict[str, list[BeamShape]] = {}
    for shape in sol.shapes:
        if isinstance(shape, BeamShape):
            found.setdefault(shape.part, []).append(shape)
    return found


def unstressed(beams: Sequence[BeamShape]) -> dict[str, tuple[float, float, float]]:
    """Poses x, y, theta of the nodes of an unstressed body by name, in the frame of its first node.

    The elements of the body are connected with one another.
    """
    found, left = {beams[0].start: (0.0, 0.0, 0.0)}, list(beams)
    while left:
        near = next((beam for beam in left if beam.start in found or beam.end in found), None)
        if near is None:  # a body in two pieces: the next one begins a frame of its own
            found[left[0].start] = (0.0, 0.0, 0.0)
            continue
        left.remove(near)
        ahead = near.start in found
        x, y, theta = found[near.start if ahead else near.end]
        _, first, last = near.free  # rotations of the unstressed element against its chord
        direction = theta + (near.start_angle - first if ahead else near.end_angle - last)
        length = near.chord if ahead else -near.chord
        other = direction + (last - near.end_angle if ahead else first - near.start_angle)
        place = (x + length * np.cos(direction), y + length * np.sin(direction), other)
        found.setdefault(near.end if ahead else near.start, place)
    return found


def body_joints(sol: Solution, part: str, nodes: list[str]) -> dict[int, bool]:
    """Numbers of the nodes of a body that carry joints, and whether one of them holds the angle."""
    found: dict[int, bool] = {}
    for shape in sol.shapes:
        if isinstance(shape, PointShape) and shape.other is not None:
            for body, node in ((shape.body, shape.node), shape.other[:2]):
                if body == part and node in nodes:
                    k = nodes.index(node)
                    found[k] = found.get(k, False) or shape.kind in ("fixed", "prismatic")
    return found


def _rigid_fit(shape: np.ndarray, poses: np.ndarray, joints: dict[int, bool], turning: list[int]) -> np.ndarray:
    """Poses (n, m, 3) of a body with the unstressed `shape` (m, 3), fitted to nodes of `poses`.

    The nodes `turning` are those of the fit where joints do not hold the body.

    Between two joints the shape is stretched as much as they are apart, so that the fit is exact there.  Nodes of modes
    go with the middle of the pins, from which their amplitudes count.
    """
    held = list(joints) if joints else turning
    middle, centre = shape[held, :2].mean(axis=0), poses[:, held, :2].mean(axis=1)
    size = np.ones(len(poses))
    seen = held if len(held) > 1 or joints.get(held[0]) else turning  # a cantilever has one node
    if len(seen) == 1:
        angle = poses[:, seen[0], 2] - shape[seen[0], 2]
    else:
        a, b = shape[seen, :2] - middle, poses[:, seen, :2] - centre[:, None]
        cross = np.sum(a[:, 0] * b[..., 1] - a[:, 1] * b[..., 0], axis=1)
        along = np.sum(a * b, axis=(1, 2))
        angle = np.arctan2(cross, along)
        if len(held) > 1 and joints:
            size = np.hypot(cross, along) / float(np.sum(a**2))
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    x, y = (size[:, None] * along for along in _turned(c, s, shape[:, :2] - middle))
    x, y = centre[:, None, 0] + x, centre[:, None, 1] + y
    turned = shape[:, 2] + angle[:, None]
    turned = turned + 2.0 * np.pi * np.round((poses[..., 2] - turned) / (2.0 * np.pi))  # turns that the run counted
    return np.stack([x, y, turned], axis=-1)


def _turned(c: np.ndarray, s: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """x and y (n, m) of points (m, 2), turned by angles with these cosines and sines (n, 1)."""
    return c * points[:, 0] - s * points[:, 1], s * points[:, 0] + c * points[:, 1]
