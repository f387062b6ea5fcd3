"""Films of a run: GIF and MP4 files, and the moving picture of the HTML report."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import arguments, checks
from flexmb.dynamics.jobs.files import whole_file
from flexmb.errors import InputError
from flexmb.late import mpl
from flexmb.model.shape import MARKER, TRACE, Place, PointShape, nodes_of
from flexmb.results import drawing
from flexmb.results.positions import at_times, magnified
from flexmb.results.solution import Solution, require_rows
from flexmb.show.pictures.pose import Colouring, Pose
from flexmb.show.pictures.scene import SHARE, Box, Scene, box_about, legend, scene_of
from flexmb.show.pictures.style import DIVERGING, SEQUENTIAL, label_axis, panel_of, words_of

# Frames of a film as images; axes and labels are drawn once, moving parts for each frame

# Fields of beams and their units by the word of `colour`.
FIELDS = {"moment": ("bending_moment", "N m"), "axial": ("axial_force", "N"), "shear": ("shear_force", "N")}
STRESS = "von_mises"  # word of `colour` for the stress of meshes
WIDTH = 800  # default width of a film [pixel]
WIDEST = 8192  # largest width and height of a film [pixel]
TALLEST = 1.25  # largest default height of a film over its width
DPI = 100  # pixels of an inch of a film's figure


class Film:
    """Frames of a run as images, drawn one after the other; arguments as of `animate`."""

    def __init__(
        self, sol: Solution, times: np.ndarray, magnify: float, colour: str | None, points: dict[str, Place],
        joints: tuple[str, ...], size: tuple[int, int] | None, follow: Place | None = None,
    ) -> None:  # fmt: skip
        if colour is not None:
            checks.one_of("animate", "colour", colour, (*FIELDS, STRESS))
        true = at_times(sol, times)
        self._centres = None if follow is None else drawing.path(true, follow, np.arange(len(times)))
        box = None if self._centres is None else box_about(true, 0, self._centres[0])
        # Scene of all frames: section forces of the true deformation at the places of the magnified one
        first, last = np.searchsorted(sol.time, true.time[0]), np.searchsorted(sol.time, true.time[-1], side="right")
        shown, rows = magnified(true, magnify), np.arange(len(true.time))
        paths = {}
        if points:
            every, whole = np.arange(first, max(last, first + 1)), magnified(sol, magnify)
            paths = {name: (drawing.path(whole, point, every), sol.time[every]) for name, point in points.items()}
        self.scene = scene_of(shown, rows, box=box, paths=paths, forces=joints, true=true if magnify != 1.0 else None)
        field, self.size = field_of(self.scene, colour), _pixels(self.scene.box, size)
        self._magnify = magnify
        self._figure, self._ax = self._make()
        self._canvas: Any = self._figure.canvas  # matplotlib declares no types here
        colouring = None if field is None else _colouring(self.scene, field[0])
        self._pose, name = Pose(self._ax, self.scene, 0, colouring), self.scene.name
        if self._magnify != 1.0:
            name += f", deformation x {self._magnify:g}" if self._magnify else ", undeformed"
        self._figure.suptitle(name, x=0.02, ha="left", fontsize="medium")
        style: dict[str, Any] = {"ha": "right", "va": "top", "fontsize": "medium", "family": "monospace"}
        self._time = self._figure.text(0.98, 0.985, "", **style)
        self._time.set_in_layout(False)
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
        step = float(np.diff(self.scene.time).min()) if len(self) > 1 else 0.0
        digits = max(0, math.ceil(-math.log10(step))) if step > 0.0 else 3  # each frame has another time
        for k in range(len(self)) if numbers is None else numbers:
            if self._centres is None:
                self._canvas.restore_region(still)
            else:
                (dx, dy), (xs, ys) = self._centres[k] - self._centres[0], self.scene.box
                self._ax.set(xlim=(xs[0] + dx, xs[1] + dx), ylim=(ys[0] + dy, ys[1] + dy))
                self._canvas.draw()
            self._pose.show(k)
            self._time.set_text(f"t = {self.scene.time[k]:.{digits}f} s")
            for artist in moving:
                artist.draw(renderer)
            yield np.asarray(self._canvas.buffer_rgba())[:, :, :3].copy()

    def _make(self) -> tuple[mpl.figure.Figure, mpl.axes.Axes]:
        figure, ax = panel_of((self.size[0] / DPI, self.size[1] / DPI))
        figure.set_dpi(DPI)
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        FigureCanvasAgg(figure)
        ax.set(xlim=self.scene.box[0], ylim=self.scene.box[1], aspect="equal")
        ax.set_xlabel("x [m]", fontsize="small")
        ax.set_ylabel("y [m]", fontsize="small")
        ax.tick_params(labelsize="x-small")
        return figure, ax

    def _bar(self, colouring: Colouring, field: str, units: str) -> None:
        wide = self.size[0] > self.size[1]
        ends, place = "neither" if field == STRESS else "both", "bottom" if wide else "right"
        scale = mpl.cm.ScalarMappable(colouring.scale, colouring.colours)
        size: Any = {"aspect": 40.0, "fraction": 0.06, "shrink": 0.7}
        bar = self._figure.colorbar(scale, ax=self._ax, extend=ends, location=place, **size)
        label_axis(bar.ax.xaxis if wide else bar.ax.yaxis, words_of(field), units)
        (bar.ax.xaxis if wide else bar.ax.yaxis).label.set_fontsize("small")
        bar.ax.tick_params(labelsize="x-small")


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
    if field == STRESS:
        top = stress_limit(scene)
        return Colouring(field, mpl.colors.Normalize(0.0, top), mpl.colormaps[SEQUENTIAL])
    top = field_limit(scene, field)
    return Colouring(field, mpl.colors.Normalize(-top, top), mpl.colormaps[DIVERGING])


def field_of(scene: Scene, colour: str | None) -> tuple[str, str] | None:
    """Field and unit of a colour (key of `FIELDS`, `STRESS`, None) of a scene; None without such bodies."""
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


PALETTE_FRAMES = 8  # number of frames from which the colours of a GIF are chosen
QUALITY = 8  # quality of an MP4 file, 0 to 10


def write_gif(path: Path, film: Film, fps: float) -> None:
    """Write a film as a GIF that is repeated for ever."""
    # All frames have one palette, so that only the changed part of a frame is stored. Times in a GIF are hundredths of
    # a second; they are rounded so that the film as a whole has its length.
    from PIL import Image

    chosen = np.unique(np.linspace(0, len(film) - 1, min(len(film), PALETTE_FRAMES)).round().astype(int))
    strip = Image.fromarray(np.concatenate(list(film.frames(chosen.tolist())), axis=0))
    palette = strip.quantize(colors=255, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    images = [Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE) for frame in film.frames()]
    colours, paper = images[0].getpalette() or [], int(np.asarray(images[0])[-1, 0])
    colours[3 * paper : 3 * paper + 3] = [255, 255, 255]  # the paper is white, not nearly so
    for image in images:
        image.putpalette(colours)
    pauses = [10 * max(int(pause), 1) for pause in np.diff(np.round(100.0 * np.arange(len(images) + 1) / fps))]
    images[0].save(path, "GIF", save_all=True, append_images=images[1:], duration=pauses, loop=0, optimize=False)


def write_mp4(path: Path, film: Film, fps: float) -> None:
    """Write a film as MP4 (H.264) of even numbers of pixels; a film that ffmpeg cuts short raises `OSError`."""
    ffmpeg = checks.package("imageio_ffmpeg", "film", "An .mp4 film")
    wide, high = film.size
    even = (wide + wide % 2, high + high % 2)
    how = {"codec": "libx264", "quality": QUALITY, "macro_block_size": 1, "ffmpeg_log_level": "error"}
    writer = ffmpeg.write_frames(str(path), even, fps=fps, **how)
    writer.send(None)
    try:
        for frame in film.frames():
            added = ((0, even[1] - high), (0, even[0] - wide), (0, 0))
            writer.send(np.ascontiguousarray(np.pad(frame, added, mode="edge")))
        writer.close()
        written = ffmpeg.count_frames_and_secs(str(path))[0]
    except (OSError, RuntimeError) as error:  # OSError: ffmpeg has ended; RuntimeError: its file is no film
        raise OSError("ffmpeg failed; is the disk full?") from error
    finally:
        writer.close()
    if written != len(film):
        raise OSError(f"ffmpeg wrote {written} of {len(film)} frames; is the disk full?")


ENDINGS = (".mp4", ".gif", ".html")
MOST_FRAMES, MOST_PIXELS = 20_000, 4e9  # of a film, and pixels of all frames of a GIF, which is made in memory


@arguments.checked
def animate(
    sol: Solution, path: str | Path, *, seconds: float = 4.0, fps: float = 25.0,
    times: tuple[float, float] | None = None, magnify: float = 1.0, colour: str | None = "moment",
    traces: bool | Sequence[str] | None = None, forces: bool | Sequence[str] = False,
    size: tuple[int, int] | None = None, follow: str | None = None,
) -> Path:  # fmt: skip
    """Film of a run: seconds x fps frames at equal distances in time, the first at the begin and the last at the end.

    Between two saved rows positions follow cubic polynomials (`flexmb.results.positions.at_times`), so a film may have
    more frames than the run has rows.  Beams are drawn with their depth and coloured by a section force, whose colours
    end at the 98th percentile of its absolute value.

    Parameters
    ----------
    sol : the solution.
    path : file of the film: .mp4, .gif (repeated for ever), or .html (the report of the run); its folder is made.
    seconds : length of the film [s].
    fps : frames a second.
    times : begin and end of the motion that is shown [s]; None: all of it.
    magnify : factor of the deformation of flexible bodies; 0: undeformed.
    colour : "moment", "axial" or "shear", the section force that colours the beams; "von_mises", the stress that
        colours plane bodies; None: a colour for each body.
    traces : True: paths of all markers; names of markers, bodies or nodes ("coupler.end"); None: those with a trace.
    forces : True: arrows of the forces of all joints; names of joints.  Forces beyond the 98th percentile have arrows
        of one length.
    size : width and height [pixel], made even for .mp4; None: 800 pixels wide, as high as the mechanism needs.
    follow : name of a marker, body or node that stays in the middle, for mechanisms that travel; the picture is as wide
        as the mechanism in the first frame.  None: the picture stands still and holds the whole run.

    Raises
    ------
    InputError : another ending, numbers that are not positive, more than 20000 frames, a .gif of more than 4e9 pixels
        in all, no saved rows, unknown names, a path that cannot be written.
    MissingPackageError : for .mp4, no package imageio-ffmpeg.
    """
    target = checks.path("animate", path)
    if target.suffix.lower() not in ENDINGS:
        raise InputError(f"animate: path is {str(path)!r}; it must end in one of {', '.join(ENDINGS)}.")
    if target.suffix.lower() == ".html":
        return Path(import_module("flexmb.show.reports.report").report(sol, target))
    rate = checks.positive("animate", "fps", fps)
    frames = checks.positive("animate", "seconds", seconds, "s") * rate
    if not frames <= MOST_FRAMES:
        text = f"animate: seconds x fps are {frames:.6g} frames; it must be at most {MOST_FRAMES}"
        raise InputError(f"{text}. Films have 25 to 60 frames a second: give a smaller fps= or seconds=.")
    count = max(1, round(frames))
    magnify, shown = checks.not_negative("animate", "magnify", magnify), instants(sol, times, count)
    kept = None if follow is None else known_point("animate", sol, "follow", follow)
    drawn = traced_points(sol, traces), joints_with_forces("animate", sol, forces)
    film = Film(sol, shown, magnify, colour, *drawn, size, kept)
    is_gif = target.suffix.lower() == ".gif"
    pixels = float(count) * film.size[0] * film.size[1]
    if is_gif and pixels > MOST_PIXELS:
        text = f"animate: {count} frames of {film.size[0]} x {film.size[1]} pixels are {pixels:.2g}, more than a .gif"
        raise InputError(f"{text} holds ({MOST_PIXELS:.0e}). Make an .mp4, or give a smaller size=, fps= or seconds=.")
    write = write_gif if is_gif else write_mp4
    with whole_file(target, "animate") as part:
        write(part, film, rate)
    return target


def instants(sol: Solution, times: tuple[float, float] | None, count: int) -> np.ndarray:
    """Instants (count,) of frames [s] of `times` or, if None, of saved rows; refused outside the run, or disordered."""
    require_rows("animate", sol)
    first, last = float(sol.time[0]), float(sol.time[-1])
    if times is not None:
        given = checks.sequence("animate", "times", times, "two instants [s]")
        if len(given) != 2:
            raise InputError(f"animate: times is {times!r}; give begin and end, e.g. times=(0.0, 0.5).")
        begin, end = (checks.between("animate", f"times[{k}]", t, first, last, "s") for k, t in enumerate(given))
        if end <= begin:
            raise InputError(f"animate: times is {times!r}; the end must be later than the begin.")
        first, last = begin, end
    return np.linspace(first, last, count)


def traced_points(sol: Solution, traces: bool | Sequence[str] | None) -> dict[str, Place]:
    """Points whose paths are drawn, by name: body, node, and place in its frame; see `animate`."""
    if traces is None:
        names = [name for name, shape in _markers(sol).items() if shape.kind == TRACE]
    elif isinstance(traces, bool):
        names = list(_markers(sol)) if traces else []
    else:
        names = [str(name) for name in checks.sequence("animate", "traces", traces, "names such as 'coupler.end'")]
    return {name: known_point("animate", sol, "traces", name) for name in names}


def _markers(sol: Solution) -> dict[str, PointShape]:
    """Markers by name."""
    return {s.part: s for s in sol.shapes if isinstance(s, PointShape) and s.kind in (MARKER, TRACE)}


def known_point(label: str, sol: Solution, argument: str, name: str) -> Place:
    """The marker, body or node of that name, or `InputError`; `label`: name of the caller."""
    nodes = {node for shape in sol.shapes for node in nodes_of(shape)}
    known = {f"{part}.{node}" if node else part: (part, node, (0.0, 0.0)) for part, node in nodes if part != "ground"}
    known |= {other: known[own] for other, own in sol.aliases.items() if own in known}
    known |= {marker: (shape.body, shape.node, shape.offset) for marker, shape in _markers(sol).items()}
    return known[checks.one_of(label, argument, name, sorted(known))]


def joints_with_forces(label: str, sol: Solution, forces: bool | Sequence[str]) -> tuple[str, ...]:
    """Names of the joints whose forces are drawn; see `animate`."""
    drawn = [s.part for s in sol.shapes if isinstance(s, PointShape) and f"{s.part}.fx" in sol]
    if isinstance(forces, bool):
        return tuple(drawn) if forces else ()
    names = checks.sequence(label, "forces", forces, "names of joints")
    return tuple(checks.one_of(label, "forces", str(name), drawn) for name in names)
