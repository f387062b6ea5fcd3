"""Artists of one pose of a mechanism, and names beside its points."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import planar
from flexmb.late import mpl
from flexmb.model.shape import MARKER, TRACE
from flexmb.results.drawing import RIGID, Line, Mark, Surface, directions
from flexmb.show.pictures.style import CLEARANCE, COLOURS, TRACED, lay_out, make_drawable

if TYPE_CHECKING:
    from flexmb.show.pictures.scene import Scene

# Names beside points of a figure, placed where they hide neither one another nor the points

DISTANCES = (6.0, 11.0, 18.0, 27.0, 38.0, 52.0, 70.0)  # tried distances of a name from its point, nearest first [pt]
DIRECTIONS = 16  # number of directions that are tried at each distance
LEADER = 15.0  # distance from which on a thin line leads from the name to its point [pt]
POINT_SIZE = 12.0  # side of the square around a point that names keep free [pt]
FOOT = 5.0  # distance of the middle of a triangle from the point that stands on it [pt]
# Costs of a place: on another name, outside the axes, on a point, for each sample of a line beneath it.
ON_NAME, OUTSIDE, ON_POINT, ON_LINE = 1e4, 2e3, 3e2, 8.0


def place_names(
    ax: mpl.axes.Axes, points: Sequence[tuple[np.ndarray, str]], lines: Sequence[np.ndarray],
    keep_free: Sequence[np.ndarray] = (), feet: Sequence[np.ndarray] = (),
) -> list[mpl.text.Annotation]:  # fmt: skip
    """Names beside their points; the layout of the figure is settled by this call."""
    # Each name takes the cheapest of some hundred places around its point: the nearest one that is free of other names,
    # of points, and, if possible, of lines. Points, polylines (m, 2) that are better not hidden, further points to be
    # kept free, and the feet of triangles are places in data.
    figure = ax.figure.get_figure(root=True)
    if figure is None:
        return []
    lay_out(figure)
    scale, to_pixels = figure.dpi / 72.0, ax.transData.transform
    at = [to_pixels(np.asarray(point, dtype=float)) for point, _ in points]
    below = [to_pixels(np.asarray(p, dtype=float)) - (0.0, FOOT * scale) for p in feet]
    dots = np.array([*at, *(to_pixels(np.asarray(p, dtype=float)) for p in keep_free), *below]).reshape(-1, 2)
    passed = np.concatenate([np.zeros((0, 2)), *(_samples(to_pixels(line), 3.0 * scale) for line in lines)])
    room, made = ax.get_window_extent(), []
    gap, half = 1.5 * scale, 0.5 * POINT_SIZE * scale
    taken = np.zeros((0, 2, 2))
    for (point, name), pixel in zip(points, at, strict=True):
        text = _annotation(ax, point, name)
        extent = text.get_window_extent()
        size = np.array([extent.width, extent.height])
        turn = 2.0 * np.pi * (np.arange(DIRECTIONS) + 2) / DIRECTIONS  # up and to the right first
        ways = np.column_stack([np.cos(turn), np.sin(turn)])
        corners = np.array(DISTANCES)[:, None, None] * scale * ways + (0.5 * ways - 0.5) * size
        away = np.array(DISTANCES)[:, None] + 0.01 * np.arange(DIRECTIONS)
        corners, away = corners.reshape(-1, 2), away.ravel()
        low, high = pixel + corners, pixel + corners + size
        hidden = (low[:, None] < taken[:, 1] + gap) & (taken[:, 0] < high[:, None] + gap)
        outside = (low < np.array(room.min) + gap) | (high > np.array(room.max) - gap)
        costs = away + ON_NAME * hidden.all(axis=2).sum(axis=1) + OUTSIDE * outside.any(axis=1)
        costs += ON_POINT * _inside(dots, low - half, high + half) + ON_LINE * _inside(passed, low, high)
        best = int(np.argmin(costs))
        text.set_position(tuple(corners[best] / scale))
        if away[best] >= LEADER and text.arrow_patch is not None:
            text.arrow_patch.set_visible(True)
        taken = np.concatenate([taken, [[low[best], high[best]]]])
        made.append(text)
    return made


def boxes(names: Sequence[mpl.text.Annotation]) -> list[mpl.transforms.Bbox]:
    """Boxes of names on the canvas [pixel]."""
    return [mpl.text.Text.get_window_extent(name) for name in names]


def _annotation(ax: mpl.axes.Axes, point: np.ndarray, name: str) -> mpl.text.Annotation:
    """Name at its point, with a leader that is not shown yet."""
    style: dict[str, Any] = {"ha": "left", "va": "bottom", "fontsize": "x-small", "zorder": 5}
    style |= {"path_effects": [mpl.patheffects.withStroke(linewidth=2.0, foreground="white")], "annotation_clip": False}
    style["arrowprops"] = {"arrowstyle": "-", "color": "0.55", "linewidth": 0.5, "shrinkA": 0.0, "shrinkB": 3.0}
    text = ax.annotate(name, (float(point[0]), float(point[1])), xytext=(0.0, 0.0), textcoords="offset points", **style)
    text.set_in_layout(False)
    make_drawable([text])
    if text.arrow_patch is not None:
        text.arrow_patch.set_visible(False)
    return text


def _inside(points: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Number of points (n, 2) in each of the boxes (k, 2)."""
    return np.asarray(((points > low[:, None]) & (points < high[:, None])).all(axis=2).sum(axis=1))


def _samples(line: np.ndarray, spacing: float) -> np.ndarray:
    """Points along a polyline, at most `spacing` apart."""
    found = [line[:1]]
    for a, b in pairwise(line):
        n = max(1, math.ceil(math.hypot(*(b - a)) / spacing))
        found.append(a + np.linspace(0.0, 1.0, n + 1)[1:, None] * (b - a))
    return np.concatenate(found)


# Artists of one pose of a mechanism, which move from pose to pose without being made again

SYMBOLS: dict[str, dict[str, Any]] = {
    "spring": {"color": "0.25", "linewidth": 1.1, "zorder": 2.5},
    "damper": {"color": "0.25", "linewidth": 1.1, "zorder": 2.5},
    "rod": {"color": "0.35", "linewidth": 1.6, "zorder": 1.8},
    "cable": {"color": "0.35", "linewidth": 0.9, "linestyle": "--", "zorder": 1.8},
    "force": {"color": "#b00020", "linewidth": 1.4, "zorder": 3.5},
    "pitch circle": {"color": "0.45", "linewidth": 1.0, "zorder": 1.7},
    "belt": {"color": "0.2", "linewidth": 1.6, "zorder": 1.75},
    "guide": {"color": "0.55", "linewidth": 1.0, "linestyle": (0, (8, 2, 2, 2)), "zorder": 1.2},
}
MARKERS = {"prismatic": "s", "slot": "o", "fixed": "D", "clearance": "o", "bushing": "h"}
VON_MISES = "von_mises"  # field of meshes by which a `Colouring` colours them
THINNEST = 0.004  # half of the least drawn depth of a beam, over the width of the picture
RING = 0.014  # radius of the ring that stands for a joint with clearance, over the width of the picture
JOURNAL, PLAY = 0.5, 0.9  # radius of the journal, and of the room in which it moves, over that of its ring


@dataclass(frozen=True)
class Colouring:
    """Colours of beams, or of meshes, by a field."""

    field: str  # name of the field of the lines
    scale: mpl.colors.Normalize  # value of the colours' ends
    colours: mpl.colors.Colormap  # colour map


class Pose:
    """Artists of one pose on an axes; without a colouring of beams each body has its own colour."""

    def __init__(self, ax: mpl.axes.Axes, scene: Scene, now: int, colouring: Colouring | None = None) -> None:
        self._ax, self._scene = ax, scene
        self._updates: list[Callable[[int], None]] = []
        self.artists: list[mpl.artist.Artist] = []
        own = body_colours(scene)
        for line in with_arms(scene):
            if line.kind == RIGID:
                colour = own[line.part] if colouring is None else "0.45"
                look: Any = {"marker": "s", "markersize": 11} if is_point(line) else {"solid_capstyle": "round"}
                if line.points.shape[1] > 3 and np.allclose(line.points[0, 0], line.points[0, -1]):
                    self._area(line.points, {"facecolor": colour, "alpha": 0.16, "edgecolor": "none", "zorder": 1.6})
                self._polyline(line.points, "", {"color": colour, "linewidth": 2.6, "zorder": 2.0, **look})
        beams = [line for line in scene.lines if line.is_beam]
        if beams:
            self._beams(beams, own, None if colouring is None or colouring.field == VON_MISES else colouring)
        for surface in scene.surfaces:
            self._mesh(surface, own[surface.part], colouring)
        for sign in (*scene.signs, *scene.forces):
            style = SYMBOLS[sign.kind]
            if sign.body in own and colouring is None:
                self._area(sign.points[:, 1:], {"facecolor": own[sign.body], "alpha": 0.16, "zorder": 1.55})
                style = {**style, "color": own[sign.body], "linewidth": 1.6}
            self._polyline(sign.points, f"{sign.kind} {sign.part}", style)
        for name, (path, time) in scene.paths.items():
            self._path(name, path, time)
        for mark in scene.marks:
            if mark.kind != "journal":
                self._joint(mark)
        self.show(now)

    def show(self, now: int) -> None:
        """Move all artists to the instant number `now`."""
        for update in self._updates:
            update(now)

    def _polyline(self, points: np.ndarray, gid: str, style: dict[str, Any]) -> None:
        (artist,) = self._ax.plot([], [], gid=gid, **style)
        self.artists.append(artist)
        self._updates.append(lambda now: artist.set_data(*points[now].T))

    def _area(self, points: np.ndarray, style: dict[str, Any]) -> None:
        artist = mpl.patches.Polygon(points[0], closed=True, **style)
        self._ax.add_patch(artist)
        self.artists.append(artist)
        self._updates.append(lambda now: artist.set_xy(points[now]))

    def _beams(self, beams: list[Line], own: dict[str, str], colouring: Colouring | None) -> None:
        """Beams with their depth: in the colour of the body around the axis, or by a field between thin edges."""
        sides = [edges(line, THINNEST * self._scene.size) for line in beams]
        if colouring is None:
            outlines = [np.concatenate([left, right[:, ::-1]], axis=1) for left, right in sides]
            style: dict[str, Any] = {"facecolors": [own[line.part] for line in beams], "alpha": 0.35, "zorder": 1.9}
            self._polygons(np.stack(outlines, axis=1), None, {**style, "edgecolors": "none"})
            for line in beams:
                self._polyline(line.points, "", {"color": own[line.part], "linewidth": 2.0, "zorder": 2.0})
            return
        quads = [np.stack([a[:, :-1], a[:, 1:], b[:, 1:], b[:, :-1]], axis=2) for a, b in sides]  # (n, m - 1, 4, 2)
        fields = [line.fields[colouring.field] for line in beams]
        values = np.concatenate([0.5 * (f[:, :-1] + f[:, 1:]) for f in fields], axis=1)
        style = {"cmap": colouring.colours, "norm": colouring.scale, "zorder": 1.95}
        self._polygons(np.concatenate(quads, axis=1), values, {**style, "edgecolors": "face", "linewidths": 0.4})
        thin = {"colors": "0.25", "linewidths": 0.7, "zorder": 2.0}
        for k in (0, 1):
            self._polygons(np.stack([side[k] for side in sides], axis=1), None, thin, is_open=True)

    def _mesh(self, surface: Surface, own: str, colouring: Colouring | None) -> None:
        """A mesh in the colour of its body, or with the stress of its cells, between its edges."""
        cells = surface.points[:, surface.rims]
        if colouring is None or colouring.field != VON_MISES:
            colour = own if colouring is None else "0.7"
            style: dict[str, Any] = {"facecolors": colour, "edgecolors": "none", "alpha": 0.3, "zorder": 1.9}
            self._polygons(cells, None, {**style, "antialiaseds": False})
        else:
            colour, values = "0.25", surface.von_mises[:, surface.cells].mean(axis=2)
            style = {"cmap": colouring.colours, "norm": colouring.scale, "zorder": 1.95}
            self._polygons(cells, values, {**style, "edgecolors": "face", "linewidths": 0.3})
        for rim in surface.outlines():
            self._polyline(rim, "", {"color": colour, "linewidth": 1.4, "zorder": 2.0})

    def _polygons(
        self, points: np.ndarray, values: np.ndarray | None, style: dict[str, Any], *, is_open: bool = False
    ) -> None:
        """Polygons or open lines (n, k, m, 2), coloured by `values` (n, k) or as `style` tells."""
        kind: Any = mpl.collections.LineCollection if is_open else mpl.collections.PolyCollection
        artist = kind(list(points[0]), **style)
        self._ax.add_collection(artist, autolim=False)
        self.artists.append(artist)

        def update(now: int) -> None:
            artist.set_verts(points[now])
            if values is not None:
                artist.set_array(values[now])

        self._updates.append(update)

    def _path(self, name: str, path: np.ndarray, time: np.ndarray) -> None:
        style: dict[str, Any] = {"color": TRACED, "linewidth": 1.0, "zorder": 1.5, "gid": f"{TRACE} {name}"}
        if len(self._scene.time) == 1:
            self.artists += self._ax.plot(*path.T, **style)
            return
        self._ax.plot(*path.T, **{**style, "alpha": 0.3})
        (artist,) = self._ax.plot([], [], **{**style, "linewidth": 1.6})
        self.artists.append(artist)
        ends = np.searchsorted(time, self._scene.time, side="right")
        self._updates.append(lambda now: artist.set_data(*path[: ends[now]].T))

    def _joint(self, mark: Mark) -> None:
        if mark.on_ground:
            self._dot(mark.points, {"marker": 6, "color": "0.45", "markersize": 9, "zorder": 3})
        if mark.kind == "clearance" and not mark.slides:
            self._ring(mark)
            return
        style: dict[str, Any] = {"markersize": 4.5, "color": "black", "zorder": 4}
        if mark.kind == "clearance":
            style |= {"markersize": 9, "markerfacecolor": "white", "markeredgecolor": CLEARANCE, "markeredgewidth": 1.8}
        elif mark.kind in (MARKER, TRACE):
            style |= {"markersize": 3.5, "color": TRACED}
        self._dot(mark.points, {"marker": MARKERS.get(mark.kind, "o"), **style})

    def _dot(self, points: np.ndarray, style: dict[str, Any]) -> None:
        (artist,) = self._ax.plot([], [], linestyle="", **style)
        self.artists.append(artist)
        self._updates.append(lambda now: artist.set_data(points[now, :1], points[now, 1:]))

    def _ring(self, mark: Mark) -> None:
        """Ring with the journal inside; its eccentricity is drawn over the largest one of the scene."""
        radius = RING * self._scene.size
        inside = next((m for m in self._scene.marks if m.part == mark.part and m.kind == "journal"), mark)
        away = inside.points - mark.points
        largest = float(np.hypot(*away.T).max()) or 1.0
        centres = mark.points + (PLAY - JOURNAL) * radius / largest * away
        ring = {"facecolor": "white", "edgecolor": CLEARANCE, "linewidth": 1.6, "zorder": 4.0}
        inner = {"facecolor": "0.3", "edgecolor": "none", "zorder": 4.1}
        for points, size, style in ((mark.points, radius, ring), (centres, JOURNAL * radius, inner)):
            self._circle(mpl.patches.Circle((0.0, 0.0), size, gid=f"clearance {mark.part}", **style), points)

    def _circle(self, artist: Any, points: np.ndarray) -> None:
        self._ax.add_patch(artist)
        self.artists.append(artist)
        self._updates.append(lambda now: artist.set_center(tuple(points[now])))


def with_arms(scene: Scene) -> list[Line]:
    """Lines of a scene; a body without extent that carries curves of contacts is no dot."""
    # Instead, a line joins its centre with each closed curve that lies beside it, such as the pin of a Geneva drive.
    found = []
    for line in scene.lines:
        centre = line.points[0, 0]
        curves = [c for c in scene.lines if c.part == line.part and np.ptp(c.points[0], axis=0).max() > 0.0]
        wheels = [s for s in scene.signs if s.body == line.part]
        if np.ptp(line.points[0], axis=0).max() > 0.0 or not (curves or wheels):
            found.append(line)
            continue
        for curve in curves:
            if np.allclose(curve.points[0, 0], curve.points[0, -1]) and not planar.surrounds(curve.points[0] - centre):
                middle = curve.points[:, :-1].mean(axis=1)
                found.append(replace(line, points=np.stack([line.points[:, 0], middle], axis=1)))
    return found


def is_point(line: Line) -> bool:
    """Whether a line is a point: a body without joints outside its centre."""
    return bool(np.ptp(line.points[0], axis=0).max() == 0.0)


def body_colours(scene: Scene) -> dict[str, str]:
    """Colours of the bodies by name."""
    return {part: COLOURS[k % len(COLOURS)] for k, part in enumerate(scene.parts)}


def edges(line: Line, least: float) -> tuple[np.ndarray, np.ndarray]:
    """Both edges (n, m, 2) of a beam in its depth, drawn with the half depth `least` [m] at least."""
    _, _, normal = directions(np.gradient(line.points, axis=1))
    depth = np.zeros(line.points.shape[1]) if line.depth is None else line.depth
    half = np.maximum(0.5 * depth, least)[:, None]
    return line.points + half * normal, line.points - half * normal
