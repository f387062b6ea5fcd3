"""Symbols of springs, dampers, rods, cables, forces and pitch circles, as polylines at chosen instants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.model.shape import DAMPER, SPRING, ArrowShape, CircleShape, LineShape, Place
from flexmb.results.drawing import carried, pose
from flexmb.results.solution import Solution

COILS = 6
"""Number of teeth of the zig-zag of a spring."""

WIDTH = 0.02
"""Half width of a spring or damper, over the size of the picture."""

ARROW, HEAD = 0.14, 0.035
"""Length of an arrow and of its head, over the size of the picture."""

CIRCLE_POINTS = 73
"""Number of points of a circle."""


@dataclass(frozen=True)
class SymbolLine:
    """A polyline of a symbol at n instants.

    Parameters
    ----------
    part : name of the part.
    kind : "spring", "damper", "rod", "cable", "force" or "pitch circle".
    points : (n, m, 2) [m].
    """

    part: str
    kind: str
    points: np.ndarray


def symbols(sol: Solution, instants: np.ndarray, size: float) -> list[SymbolLine]:
    """Symbols of all shapes that are neither bodies nor points.

    Parameters
    ----------
    sol : the solution.
    instants : (n,) numbers of saved instants.
    size : size of the picture [m], by which widths and arrows are drawn.
    """
    found = []
    for shape in sol.shapes:
        if isinstance(shape, LineShape):
            first, second = (_point(sol, place, instants) for place in (shape.first, shape.second))
            found.append(SymbolLine(shape.part, shape.kind, _between(first, second, shape.kind, WIDTH * size)))
        elif isinstance(shape, ArrowShape):
            found.append(SymbolLine(shape.part, "force", _arrow(sol, shape, instants, size)))
        elif isinstance(shape, CircleShape):
            found.append(SymbolLine(shape.part, "pitch circle", _circle(sol, shape, instants)))
    return found


def _point(sol: Solution, place: Place, instants: np.ndarray) -> np.ndarray:
    """A point (n, 2) of a body at the instants."""
    body, node, offset = place
    return carried(pose(sol, body, node, instants), np.array([offset], dtype=float))[:, 0]


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
