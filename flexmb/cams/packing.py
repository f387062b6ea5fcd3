"""Curves of bodies as numbers of kernels, and distances in the reference configuration."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import planar
from flexmb.cams.curves.closed_curve import SAMPLES, ClosedCurve
from flexmb.cams.curves.geometry import sampled
from flexmb.cams.curves.line import CircularCurve, Line
from flexmb.errors import ModelError
from flexmb.model.contributions import Coordinate, Node, node_coordinates
from flexmb.model.shape import RigidShape, Shapes

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism

TOLERANCE_LENGTH = 1e-3
"""Length by which tolerances of a run with contacts are scaled, over the size of the curve."""


def carrier(mechanism: Mechanism, part: str, owner: str) -> Node:
    """Node of the rigid body or ground that carries a curve; a flexible body is refused."""
    body = mechanism.body(part, owner)
    nodes = body.nodes()
    if len(nodes) != 1:
        raise ModelError(
            f"{owner}: {body.label} is flexible and cannot carry a curve. Fix a RigidBody with the curve to one of its "
            "nodes by Fixed(...)."
        )
    return nodes[0]


def carriers(mechanism: Mechanism, pair: Any) -> tuple[tuple[Node, Node], tuple[Coordinate, ...]]:
    """Nodes of both rigid bodies of a pair, which carry its curves, and their coordinates x, y, theta."""
    first, second = (carrier(mechanism, part.name, pair.label) for part in (pair.first, pair.second))
    own = node_coordinates(pair.first.name, first.name)
    return (first, second), (*own, *node_coordinates(pair.second.name, second.name))


def in_frame(node: Node, point: tuple[float, float]) -> tuple[float, float]:
    """A point of the reference configuration in the frame of a node [m]."""
    return planar.to_frame((node.x, node.y), node.theta, point)


def curve_numbers(curve: ClosedCurve, node: Node) -> tuple[float, ...]:
    """Numbers of a closed curve in the frame of a node, see `flexmb.cams.curves.spans`."""
    c, s = math.cos(node.theta), math.sin(node.theta)
    spans = curve.array.copy()
    spans[:, :, 0] -= (node.x, node.y)
    spans = np.einsum("ab,nbi->nai", np.array([[c, s], [-s, c]]), spans)
    n = len(spans)
    each = math.isqrt(n - 1) + 1
    boxes: list[float] = []
    for first in range(0, n, each):
        end = min(n, first + each)
        starts = spans[first:end, :, 0]
        centre = starts[len(starts) // 2]
        radius = float(np.hypot(*(starts - centre).T).max())
        boxes += [*map(float, centre), radius, float(first), float(end)]
    return (float(n), float(-(-n // each)), *boxes, *spans.ravel().tolist())


def distance(curve: ClosedCurve, other: ClosedCurve | CircularCurve | Line) -> tuple[float, float]:
    """Approximate gap of two curves as they are drawn [m], < 0 for an overlap, and the place along a line [m]."""
    points = sampled(curve.array, SAMPLES)
    if isinstance(other, Line):
        side, u = side_of(curve, other), along(other)
        far = side * ((other.start[0] - points[:, 0]) * u[1] - (other.start[1] - points[:, 1]) * u[0])
        k = int(np.argmin(far))
        place = (points[k, 0] - other.start[0]) * u[0] + (points[k, 1] - other.start[1]) * u[1]
        return float(far[k]), float(place)
    if isinstance(other, CircularCurve):
        return signed_distance(points, other.centre) - other.radius, 0.0
    return min(signed_distance(points, p) for p in sampled(other.array, 1)), 0.0


def signed_distance(polygon: np.ndarray, point: Any) -> float:
    """Distance of a point from a closed polygon, < 0 inside."""
    to, chord = polygon - np.asarray(point), np.roll(polygon, -1, axis=0) - polygon
    share = np.clip(-np.sum(to * chord, axis=1) / np.sum(chord * chord, axis=1), 0.0, 1.0)
    away = float(np.hypot(*(to + share[:, None] * chord).T).min())
    ahead = np.roll(to, -1, axis=0)
    turn = np.arctan2(to[:, 0] * ahead[:, 1] - to[:, 1] * ahead[:, 0], np.sum(to * ahead, axis=1))
    return -away if abs(float(turn.sum())) > math.pi else away


def along(line: Line) -> tuple[float, float]:
    """Unit vector of a line."""
    return (line.end[0] - line.start[0]) / line.length, (line.end[1] - line.start[1]) / line.length


def side_of(curve: ClosedCurve, line: Line) -> float:
    """+1 for a curve on the left of a line, -1 on the right."""
    x, y = sampled(curve.array, 1).mean(axis=0)
    u = along(line)
    return 1.0 if u[0] * (y - line.start[1]) - u[1] * (x - line.start[0]) >= 0.0 else -1.0


def pair_shapes(mechanism: Mechanism, pair: Any, first: Any, second: Any) -> Shapes:
    """Curves of both bodies of a pair, for pictures."""
    nodes, _ = carriers(mechanism, pair)
    drawn = (pair.first, nodes[0], first), (pair.second, nodes[1], second)
    return [shape(body.name, node, curve.drawing()) for body, node, curve in drawn]


def shape(part: str, node: Node, points: tuple[tuple[float, float], ...]) -> RigidShape:
    """A polyline of the reference configuration that moves with a node, for pictures."""
    return RigidShape(part, node.name, (tuple(in_frame(node, p) for p in points),))
