"""Frames of a film as images; axes and labels are drawn once, moving parts for each frame."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import checks
from flexmb.errors import InputError
from flexmb.model.shape import Place
from flexmb.pictures.poses.pose import Colouring, Pose
from flexmb.pictures.poses.render import legend
from flexmb.pictures.poses.scene import SHARE, Box, Scene, box_about, scene_of
from flexmb.pictures.style import DIVERGING, SEQUENTIAL, grid, label_axis, words_of
from flexmb.results import drawing
from flexmb.results.resampling import at_times, magnified
from flexmb.results.solution import Solution

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.text import Text

FIELDS = {"moment": ("bending_moment", "N m"), "axial": ("axial_force", "N"), "shear": ("shear_force", "N")}
"""Fields of beams and their units by the word of `colour`."""

STRESS = "von_mises"
"""Word of `colour` for the stress of meshes."""

WIDTH = 800
"""Default width of a film [pixel]."""

WIDEST = 8192
"""Largest width and height of a film [pixel]."""

TALLEST = 1.25
"""Largest default height of a film over its width."""

DPI = 100
"""Pixels of an inch of a film's figure."""


class Film:
    """Frames of a run as images, drawn one after the other.

    Parameters
    ----------
    times : (n,) instants [s].
    magnify : factor of the deformation.
    colour : key of `FIELDS`, `STRESS`, or None.
    points : points whose paths are drawn.
    joints : joints whose forces are drawn.
    size : width and height [pixel]; None: from the mechanism.
    follow : point in the middle of all frames; None: the axes stand still.

    Raises
    ------
    InputError : an unknown colour, a size that is not positive.
    """

    def __init__(
        self,
        sol: Solution,
        times: np.ndarray,
        magnify: float,
        colour: str | None,
        points: dict[str, Place],
        joints: tuple[str, ...],
        size: tuple[int, int] | None,
        follow: Place | None = None,
    ) -> None:
        if colour is not None:
            checks.one_of("animate", "colour", colour, (*FIELDS, STRESS))
        true = at_times(sol, times)
        self._centres = None if follow is None else drawing.path(true, follow, np.arange(len(times)))
        box = None if self._centres is None else box_about(true, 0, self._centres[0])
        self.scene = _scene(sol, true, magnify, points, joints, box)
        field = field_of(self.scene, colour)
        self.size = _pixels(self.scene.box, size)
        self._magnify = magnify
        self._figure, self._ax = self._make()
        self._canvas: Any = self._figure.canvas  # matplotlib declares no types here
        colouring = None if field is None else _colouring(self.scene, field[0])
        self._pose = Pose(self._ax, self.scene, 0, colouring)
        self._time = self._caption()
        if field is not None and colouring is not None:
            self._bar(colouring, *field)
        else:
            legend(self._figure, self.scene)

    def __len__(self) -> int:
        return len(self.scene.time)

    def frames(self, numbers: Iterable[int] | None = None) -> Iterator[np.ndarray]:
        """Images (height, width, 3) of the frames of these numbers, of all by default."""
        moving = sorted([*self._pose.artists, self._time], key=lambda artist: artist.get_zorder())
        for artist in moving:
            artist.set_animated(True)
        renderer = self._canvas.get_renderer()
        self._canvas.draw()
        if self._centres is not None:
            self._figure.set_layout_engine("none")  # settled by now; longer numbers at moving axes would shake it
        still = self._canvas.copy_from_bbox(self._figure.bbox)
        digits = _digits(self.scene.time)
        for k in range(len(self)) if numbers is None else numbers:
            if self._centres is None:
                self._canvas.restore_region(still)
            else:
                self._move_axes(self._centres[k] - self._centres[0])
            self._pose.show(k)
            self._time.set_text(f"t = {self.scene.time[k]:.{digits}f} s")
            for artist in moving:
                artist.draw(renderer)
            yield np.asarray(self._canvas.buffer_rgba())[:, :, :3].copy()

    def _move_axes(self, shift: np.ndarray) -> None:
        """Draw the axes again, displaced by `shift` (2,) [m] from the first frame."""
        (dx, dy), (xs, ys) = shift, self.scene.box
        self._ax.set(xlim=(xs[0] + dx, xs[1] + dx), ylim=(ys[0] + dy, ys[1] + dy))
        self._canvas.draw()

    def _make(self) -> tuple[Figure, Axes]:
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        from flexmb.pictures.figure import Picture

        inches = (self.size[0] / DPI, self.size[1] / DPI)
        figure = Picture(figsize=inches, dpi=DPI, layout="constrained")
        FigureCanvasAgg(figure)
        ax = figure.subplots()
        grid(ax)
        ax.set(xlim=self.scene.box[0], ylim=self.scene.box[1], aspect="equal")
        ax.set_xlabel("x [m]", fontsize="small")
        ax.set_ylabel("y [m]", fontsize="small")
        ax.tick_params(labelsize="x-small")
        return figure, ax

    def _caption(self) -> Text:
        """Name on the left above the axes, time on the right."""
        name = self.scene.name
        if self._magnify != 1.0:
            name += f", deformation x {self._magnify:g}" if self._magnify else ", undeformed"
        self._figure.suptitle(name, x=0.02, ha="left", fontsize="medium")
        style: dict[str, Any] = {"ha": "right", "va": "top", "fontsize": "medium", "family": "monospace"}
        text = self._figure.text(0.98, 0.985, "", **style)
        text.set_in_layout(False)
        return text

    def _bar(self, colouring: Colouring, field: str, units: str) -> None:
        from matplotlib.cm import ScalarMappable

        wide = self.size[0] > self.size[1]
        bar = self._figure.colorbar(
            ScalarMappable(colouring.scale, colouring.colours),
            ax=self._ax,
            extend="neither" if field == STRESS else "both",
            location="bottom" if wide else "right",
            aspect=40.0,
            fraction=0.06,
            shrink=0.7,
        )
        label_axis(bar.ax.xaxis if wide else bar.ax.yaxis, words_of(field), units)
        (bar.ax.xaxis if wide else bar.ax.yaxis).label.set_fontsize("small")
        bar.ax.tick_params(labelsize="x-small")


def _scene(
    sol: Solution,
    true: Solution,
    magnify: float,
    points: dict[str, Place],
    joints: tuple[str, ...],
    box: Box | None,
) -> Scene:
    """Scene of all frames: section forces of the true deformation at the places of the magnified one."""
    first, last = np.searchsorted(sol.time, true.time[0]), np.searchsorted(sol.time, true.time[-1], side="right")
    shown, rows = magnified(true, magnify), np.arange(len(true.time))
    paths = {}
    if points:
        every = np.arange(first, max(last, first + 1))
        whole = magnified(sol, magnify)
        paths = {name: (drawing.path(whole, point, every), sol.time[every]) for name, point in points.items()}
    return scene_of(shown, rows, box=box, paths=paths, forces=joints, true=true if magnify != 1.0 else None)


def _pixels(box: Box, size: tuple[int, int] | None) -> tuple[int, int]:
    """Width and height of the film [pixel]."""
    if size is not None:
        given = checks.sequence("animate", "size", size, "width and height [pixel]")
        if len(given) != 2:
            raise InputError(f"animate: size is {size!r}; give width and height in pixels, e.g. size=(800, 600).")
        wide, high = (checks.count("animate", f"size[{k}]", value, 100) for k, value in enumerate(given))
        if max(wide, high) > WIDEST:
            raise InputError(f"animate: size is {wide} x {high} pixels; each must be {WIDEST} at most.")
        return wide, high
    (x0, x1), (y0, y1) = box
    high = round(150 + min((WIDTH - 110) * (y1 - y0) / (x1 - x0), TALLEST * WIDTH))
    return WIDTH, high + high % 2


def _colouring(scene: Scene, field: str) -> Colouring:
    """Colours of a field, the same for both signs; of a stress from 0 to the largest."""
    import matplotlib
    from matplotlib.colors import Normalize

    if field == STRESS:
        top = stress_limit(scene)
        return Colouring(field, Normalize(0.0, top), matplotlib.colormaps[SEQUENTIAL])
    top = field_limit(scene, field)
    return Colouring(field, Normalize(-top, top), matplotlib.colormaps[DIVERGING])


def field_of(scene: Scene, colour: str | None) -> tuple[str, str] | None:
    """Field and unit by which a scene is coloured; None where it has no such bodies.

    The colour is a key of `FIELDS`, `STRESS`, or None.
    """
    if colour == STRESS:
        return (STRESS, "Pa") if any(mesh.has_stress for mesh in scene.surfaces) else None
    return FIELDS[colour] if colour is not None and any(line.is_beam for line in scene.lines) else None


def stress_limit(scene: Scene) -> float:
    """Largest von Mises stress of the meshes of a scene [Pa]."""
    return max((float(mesh.von_mises.max(initial=0.0)) for mesh in scene.surfaces), default=0.0) or 1.0


def field_limit(scene: Scene, field: str) -> float:
    """Value at the ends of the colours of a field."""
    values = np.concatenate([np.abs(line.fields[field]).ravel() for line in scene.lines if line.is_beam])
    return float(np.percentile(values, SHARE)) or float(values.max()) or 1.0


def _digits(time: np.ndarray) -> int:
    """Decimals of the shown time, so that each frame has another one."""
    step = float(np.diff(time).min()) if len(time) > 1 else 0.0
    return max(0, math.ceil(-math.log10(step))) if step > 0.0 else 3
