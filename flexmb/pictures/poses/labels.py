"""Names beside points of a figure, placed where they hide neither one another nor the points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.pictures.glyphs import make_drawable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Annotation
    from matplotlib.transforms import Bbox

DISTANCES = (6.0, 11.0, 18.0, 27.0, 38.0, 52.0, 70.0)
"""Distances of a name from its point that are tried, the nearest first [pt]."""

DIRECTIONS = 16
"""Number of directions that are tried at each distance."""

LEADER = 15.0
"""Distance from which on a thin line leads from the name to its point [pt]."""

POINT_SIZE = 12.0
"""Side of the square around a point that names keep free [pt]."""

FOOT = 5.0
"""Distance of the middle of a triangle from the point that stands on it [pt]."""

ON_NAME, OUTSIDE, ON_POINT, ON_LINE = 1e4, 2e3, 3e2, 8.0
"""Costs of a place: on another name, outside the axes, on a point, for each sample of a line beneath it."""


def place_names(
    ax: Axes,
    points: Sequence[tuple[np.ndarray, str]],
    lines: Sequence[np.ndarray],
    keep_free: Sequence[np.ndarray] = (),
    feet: Sequence[np.ndarray] = (),
) -> list[Annotation]:
    """Names beside their points; the layout of the figure is settled by this call.

    Each name takes the cheapest of some hundred places around its point: the nearest one that is free of other names,
    of points, and, if possible, of lines.  Points, polylines (m, 2) that are better not hidden, further points to be
    kept free, and the feet of triangles are places in data.
    """
    figure = ax.figure.get_figure(root=True)
    if figure is None:
        return []
    figure.draw_without_rendering()
    scale = figure.dpi / 72.0
    to_pixels = ax.transData.transform
    at = [to_pixels(np.asarray(point, dtype=float)) for point, _ in points]
    below = [to_pixels(np.asarray(p, dtype=float)) - (0.0, FOOT * scale) for p in feet]
    dots = np.array([*at, *(to_pixels(np.asarray(p, dtype=float)) for p in keep_free), *below]).reshape(-1, 2)
    passed = np.concatenate([np.zeros((0, 2)), *(_samples(to_pixels(line), 3.0 * scale) for line in lines)])
    room, made = ax.get_window_extent(), []
    taken: list[tuple[float, float, float, float]] = []
    for (point, name), pixel in zip(points, at, strict=True):
        text = _annotation(ax, point, name)
        size = text.get_window_extent()
        best = min(
            _places(size.width, size.height, scale),
            key=lambda place: (
                place[2] + _cost(pixel, place, (size.width, size.height), room, taken, dots, passed, scale)
            ),
        )
        x, y, far = best
        text.set_position((x / scale, y / scale))
        if far >= LEADER and text.arrow_patch is not None:
            text.arrow_patch.set_visible(True)
        taken.append((pixel[0] + x, pixel[1] + y, size.width, size.height))
        made.append(text)
    return made


def boxes(names: Sequence[Annotation]) -> list[Bbox]:
    """Boxes of names on the canvas [pixel]."""
    from matplotlib.text import Text

    return [Text.get_window_extent(name) for name in names]


def _annotation(ax: Axes, point: np.ndarray, name: str) -> Annotation:
    """Name at its point, with a leader that is not shown yet."""
    from matplotlib.patheffects import withStroke

    style: dict[str, Any] = {"ha": "left", "va": "bottom", "fontsize": "x-small", "zorder": 5}
    style |= {"path_effects": [withStroke(linewidth=2.0, foreground="white")], "annotation_clip": False}
    style["arrowprops"] = {"arrowstyle": "-", "color": "0.55", "linewidth": 0.5, "shrinkA": 0.0, "shrinkB": 3.0}
    place = (float(point[0]), float(point[1]))
    text = ax.annotate(name, place, xytext=(0.0, 0.0), textcoords="offset points", **style)
    text.set_in_layout(False)
    make_drawable([text])
    if text.arrow_patch is not None:
        text.arrow_patch.set_visible(False)
    return text


def _places(width: float, height: float, scale: float) -> list[tuple[float, float, float]]:
    """Lower left corners of the tried places relative to the point [pixel], and their distances [pt]."""
    found = []
    for distance in DISTANCES:
        for k in range(DIRECTIONS):
            angle = 2.0 * math.pi * (k + 2) / DIRECTIONS  # up and to the right first
            c, s = math.cos(angle), math.sin(angle)
            # the box touches the circle of this distance with its nearest edge or corner
            x = distance * scale * c + (0.5 * c - 0.5) * width
            y = distance * scale * s + (0.5 * s - 0.5) * height
            found.append((x, y, distance + 0.01 * k))
    return found


def _cost(
    pixel: np.ndarray,
    place: tuple[float, float, float],
    size: tuple[float, float],
    room: Bbox,
    taken: list[tuple[float, float, float, float]],
    dots: np.ndarray,
    passed: np.ndarray,
    scale: float,
) -> float:
    """Cost of a place beside its distance."""
    x, y = pixel[0] + place[0], pixel[1] + place[1]
    right, top = x + size[0], y + size[1]
    gap = 1.5 * scale
    cost = ON_NAME * sum(
        x < ox + ow + gap and ox < right + gap and y < oy + oh + gap and oy < top + gap for ox, oy, ow, oh in taken
    )
    if x < room.x0 + gap or y < room.y0 + gap or right > room.x1 - gap or top > room.y1 - gap:
        cost += OUTSIDE
    half = 0.5 * POINT_SIZE * scale
    cost += ON_POINT * float(np.sum(_inside(dots, x - half, y - half, right + half, top + half)))
    return float(cost) + ON_LINE * float(np.sum(_inside(passed, x, y, right, top)))


def _inside(points: np.ndarray, x0: float, y0: float, x1: float, y1: float) -> np.ndarray:
    return np.asarray((points[:, 0] > x0) & (points[:, 0] < x1) & (points[:, 1] > y0) & (points[:, 1] < y1))


def _samples(line: np.ndarray, spacing: float) -> np.ndarray:
    """Points along a polyline, at most `spacing` apart."""
    found = [line[:1]]
    for a, b in pairwise(line):
        n = max(1, math.ceil(math.hypot(*(b - a)) / spacing))
        found.append(a + np.linspace(0.0, 1.0, n + 1)[1:, None] * (b - a))
    return np.concatenate(found)
