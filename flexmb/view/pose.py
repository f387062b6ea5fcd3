"""Artists of one pose of a mechanism, which move from pose to pose without being made again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.model.shape import MARKER, TRACE
from flexmb.view.style import CLEARANCE, COLOURS, TRACED

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap, Normalize

    from flexmb.results.drawing import Line, Mark
    from flexmb.results.symbols import SymbolLine
    from flexmb.view.scene import Scene

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

THINNEST = 0.004
"""Half of the least drawn depth of a beam, over the width of the picture."""

RING = 0.014
"""Radius of the ring that stands for a joint with clearance, over the width of the picture."""

JOURNAL = 0.55
"""Radius of the journal over that of its ring; the rest is the clearance, enlarged."""


@dataclass(frozen=True)
class Colouring:
    """Colours of beams by a field.

    Parameters
    ----------
    field : name of the field of the lines.
    scale : value of the colours' ends.
    colours : colour map.
    """

    field: str
    scale: Normalize
    colours: Colormap


class Pose:
    """Artists of one pose on an axes.

    Parameters
    ----------
    ax : the axes.
    scene : the drawing.
    now : number of the instant that is shown first.
    colouring : colours of beams; None: each body has its own colour.
    """

    def __init__(self, ax: Axes, scene: Scene, now: int, colouring: Colouring | None = None) -> None:
        self._ax, self._scene = ax, scene
        self._updates: list[Callable[[int], None]] = []
        self.artists: list[Artist] = []
        own = body_colours(scene)
        for line in scene.lines:
            if line.is_beam:
                self._beam(line, own[line.part], colouring)
            else:
                self._rigid(line, own[line.part] if colouring is None else "0.45")
        for sign in (*scene.signs, *scene.forces):
            self._polyline(sign.points, f"{sign.kind} {sign.part}", SYMBOLS[sign.kind])
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

    def _rigid(self, line: Line, colour: str) -> None:
        point = bool(np.ptp(line.points[0], axis=0).max() == 0.0)  # a body without joints outside its centre
        style: dict[str, Any] = {"marker": "s", "markersize": 14} if point else {"solid_capstyle": "round"}
        if line.points.shape[1] > 3 and np.allclose(line.points[0, 0], line.points[0, -1]):
            self._area(line.points, {"facecolor": colour, "alpha": 0.16, "edgecolor": "none", "zorder": 1.6})
        self._polyline(line.points, "", {"color": colour, "linewidth": 2.6, "zorder": 2.0, **style})

    def _area(self, points: np.ndarray, style: dict[str, Any]) -> None:
        from matplotlib.patches import Polygon

        artist = self._ax.add_patch(Polygon(points[0], closed=True, **style))
        self.artists.append(artist)
        self._updates.append(lambda now: artist.set_xy(points[now]))

    def _beam(self, line: Line, colour: str, colouring: Colouring | None) -> None:
        left, right = edges(line, THINNEST * self._scene.size)
        if colouring is None:
            outline = np.concatenate([left, right[:, ::-1]], axis=1)
            self._area(outline, {"facecolor": colour, "alpha": 0.35, "edgecolor": "none", "zorder": 1.9})
            self._polyline(line.points, "", {"color": colour, "linewidth": 2.0, "zorder": 2.0})
            return
        for edge in (left, right):
            self._polyline(edge, "", {"color": "0.25", "linewidth": 0.7, "zorder": 2.0})
        self._coloured(line, left, right, colouring)

    def _coloured(self, line: Line, left: np.ndarray, right: np.ndarray, colouring: Colouring) -> None:
        from matplotlib.collections import PolyCollection

        quads = np.stack([left[:, :-1], left[:, 1:], right[:, 1:], right[:, :-1]], axis=2)  # (n, m - 1, 4, 2)
        values = 0.5 * (line.fields[colouring.field][:, :-1] + line.fields[colouring.field][:, 1:])
        style: dict[str, Any] = {"cmap": colouring.colours, "norm": colouring.scale, "zorder": 1.95}
        artist = PolyCollection(list(quads[0]), edgecolors="face", linewidths=0.4, **style)
        self._ax.add_collection(artist, autolim=False)
        self.artists.append(artist)

        def update(now: int) -> None:
            artist.set_verts(quads[now])
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
        from matplotlib.patches import Circle

        radius = RING * self._scene.size
        inside = next((m for m in self._scene.marks if m.part == mark.part and m.kind == "journal"), mark)
        away = inside.points - mark.points
        largest = float(np.hypot(*away.T).max()) or 1.0
        centres = mark.points + (1.0 - JOURNAL) * radius / largest * away
        ring = {"facecolor": "white", "edgecolor": CLEARANCE, "linewidth": 1.6, "zorder": 4.0}
        for points, size, style in (
            (mark.points, radius, ring),
            (centres, JOURNAL * radius, {"facecolor": "0.3", "edgecolor": "none", "zorder": 4.1}),
        ):
            self._circle(Circle((0.0, 0.0), size, gid=f"clearance {mark.part}", **style), points)

    def _circle(self, artist: Any, points: np.ndarray) -> None:
        self._ax.add_patch(artist)
        self.artists.append(artist)
        self._updates.append(lambda now: artist.set_center(tuple(points[now])))


def body_colours(scene: Scene) -> dict[str, str]:
    """Colours of the bodies by name.

    Parameters
    ----------
    scene : the drawing.
    """
    return {part: COLOURS[k % len(COLOURS)] for k, part in enumerate(scene.parts)}


def edges(line: Line, least: float) -> tuple[np.ndarray, np.ndarray]:
    """Both edges (n, m, 2) of a beam in its depth.

    Parameters
    ----------
    line : axis of the beam.
    least : least half depth that is drawn [m].
    """
    along = np.gradient(line.points, axis=1)
    along /= np.maximum(np.hypot(along[..., 0], along[..., 1]), 1e-300)[..., None]
    normal = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    depth = np.zeros(line.points.shape[1]) if line.depth is None else line.depth
    half = np.maximum(0.5 * depth, least)[:, None]
    return line.points + half * normal, line.points - half * normal
