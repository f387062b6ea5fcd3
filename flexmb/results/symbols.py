"""Symbols of springs, dampers, rods, cables, guides, belts, forces and pitch circles, as polylines at instants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.model.shape import DAMPER, SPRING, ArrowShape, BeltShape, CircleShape, LineShape, Place, Point, PointShape
from flexmb.results.drawing import GROUND, carried, path, pose
from flexmb.results.solution import Solution

COILS = 6
"""Number of teeth of the zig-zag of a spring."""

WIDTH = 0.02
"""Half width of a spring or damper, over the size of the picture."""

ARROW, HEAD = 0.14, 0.035
"""Length of an arrow and of its head, over the size of the picture."""

CIRCLE_POINTS = 73
"""Number of points of a circle."""

ARC_POINTS = 37
"""Number of points of the arc of a belt on a wheel."""

OVERHANG = 0.06
"""Length of a guide beyond the travel, over the size of the picture."""

KINDS = ("spring", "damper", "rod", "cable", "force", "pitch circle", "belt", "guide")
"""Kinds of symbols."""


@dataclass(frozen=True)
class SymbolLine:
    """A polyline of a symbol at n instants.

    Parameters
    ----------
    kind : one of `KINDS`.
    points : (n, m, 2) [m].
    body : the body that a circle turns with; "" for other symbols.
    """

    part: str
    kind: str
    points: np.ndarray
    body: str = ""


def symbols(sol: Solution, instants: np.ndarray, size: float) -> list[SymbolLine]:
    """Symbols of all shapes that are neither bodies nor points, at saved instants with numbers (n,).

    Widths and arrows are drawn by the size of the picture [m].
    """
    found = []
    for shape in sol.shapes:
        if isinstance(shape, LineShape):
            first, second = (_point(sol, place, instants) for place in (shape.first, shape.second))
            found.append(SymbolLine(shape.part, shape.kind, _between(first, second, shape.kind, WIDTH * size)))
        elif isinstance(shape, ArrowShape):
            found.append(SymbolLine(shape.part, "force", _arrow(sol, shape, instants, size)))
        elif isinstance(shape, CircleShape):
            found.append(SymbolLine(shape.part, "pitch circle", _circle(sol, shape, instants), shape.at[0]))
        elif isinstance(shape, BeltShape):
            found.append(SymbolLine(shape.part, "belt", _belt(sol, shape, instants)))
        elif isinstance(shape, PointShape) and shape.along and shape.other and _is_saved(sol, shape.other):
            line = _guide(sol, shape, shape.other, shape.along, instants, OVERHANG * size)
            found.append(SymbolLine(shape.part, "guide", line))
    return found


def _point(sol: Solution, place: Place, instants: np.ndarray) -> np.ndarray:
    """A point (n, 2) of a body at the instants."""
    return path(sol, place, instants)


def _between(first: np.ndarray, second: np.ndarray, kind: str, width: float) -> np.ndarray:
    """Polyline (n, m, 2) from one point to another: zig-zag, dashpot, or straight."""
    if kind == SPRING:
        along = np.array([0.0, 0.15, *np.linspace(0.15, 0.85, 2 * COILS + 1)[1:-1:2], 0.85, 1.0])
        across = np.array([0.0, 0.0, *((-1.0) ** np.arange(COILS)), 0.0, 0.0])
    elif kind == DAMPER:  # rod and piston, then the cup and its rod
        along = np.array([0.0, 0.5, 0.5, 0.5, 0.5, 0.35, 0.65, 0.65, 0.35, 0.65, 0.65, 1.0])
        across = np.array([0.0, 0.0, 0.7, -0.7, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 0.0, 0.0])
    else:
        along, across = np.array([0.0, 1.0]), np.zeros(2)
    way = second - first
    length = np.hypot(way[:, 0], way[:, 1])
    unit = way / np.where(length > 0.0, length, 1.0)[:, None]
    normal = np.stack([-unit[:, 1], unit[:, 0]], axis=-1)
    return np.asarray(first[:, None] + along[:, None] * way[:, None] + width * across[:, None] * normal[:, None])


def _arrow(sol: Solution, arrow: ArrowShape, instants: np.ndarray, size: float) -> np.ndarray:
    """Shaft and head (n, 5, 2) of an arrow that ends in its point."""
    tip, angle = _point(sol, arrow.at, instants), np.zeros(len(instants))
    if arrow.turns:
        angle = pose(sol, arrow.at[0], arrow.at[1], instants)[:, 2]
    angle = angle + np.arctan2(arrow.direction[1], arrow.direction[0])
    u = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    n = np.stack([-u[:, 1], u[:, 0]], axis=-1)
    back, side = HEAD * size, 0.4 * HEAD * size
    return np.stack([tip - ARROW * size * u, tip, tip - back * u + side * n, tip, tip - back * u - side * n], axis=1)


def _circle(sol: Solution, circle: CircleShape, instants: np.ndarray) -> np.ndarray:
    """Circle (n, m, 2) from its centre, along a spoke, and around."""
    body, node, (x, y) = circle.at
    angles = np.linspace(0.0, 2.0 * np.pi, CIRCLE_POINTS)
    rim = np.stack([x + circle.radius * np.cos(angles), y + circle.radius * np.sin(angles)], axis=-1)
    return carried(pose(sol, body, node, instants), np.vstack([[[x, y]], rim]))


def _guide(
    sol: Solution, shape: PointShape, guide: Place, along: Point, instants: np.ndarray, over: float
) -> np.ndarray:
    """Straight line (n, 2, 2) along which a point slides: its travel in the whole run, and more at both ends."""
    every = np.arange(len(sol.time))
    begin = _point(sol, guide, every)
    angle = pose(sol, guide[0], guide[1], every)[:, 2] + np.arctan2(along[1], along[0])
    unit = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    travel = np.sum((_point(sol, (shape.body, shape.node, shape.offset), every) - begin) * unit, axis=-1)
    ends = np.array([travel.min() - over, travel.max() + over])
    return np.asarray(begin[instants, None] + ends[:, None] * unit[instants, None])


def _is_saved(sol: Solution, place: Place) -> bool:
    """Whether the run saved the pose of the body of a point."""
    body, node, _ = place
    return body == GROUND or (f"{body}.{node}.theta" if node else f"{body}.theta") in sol


def _belt(sol: Solution, belt: BeltShape, instants: np.ndarray) -> np.ndarray:
    """Closed line (n, m, 2) of a belt: around the first wheel, a strand, around the second wheel, a strand."""
    first, second = (_point(sol, place, instants) for place in (belt.first, belt.second))
    way = second - first
    distance = np.maximum(np.hypot(way[:, 0], way[:, 1]), 1e-300)
    r1, r2 = belt.radii
    slope = np.clip((r1 + r2 if belt.crossed else r1 - r2) / distance, -1.0, 1.0)
    half = np.arccos(slope)  # between the line of centres and the radius to the upper point of contact
    angle, turn = np.arctan2(way[:, 1], way[:, 0])[:, None], np.linspace(0.0, 1.0, ARC_POINTS)
    around = angle + half[:, None] + (2.0 * np.pi - 2.0 * half)[:, None] * turn
    if belt.crossed:  # the second wheel turns against the first one
        back = angle + np.pi - half[:, None] - (2.0 * np.pi - 2.0 * half)[:, None] * turn
    else:
        back = angle - half[:, None] + 2.0 * half[:, None] * turn
    arcs = [
        centre[:, None] + radius * np.stack([np.cos(a), np.sin(a)], axis=-1)
        for centre, radius, a in ((first, r1, around), (second, r2, back))
    ]
    return np.concatenate([*arcs, arcs[0][:, :1]], axis=1)
