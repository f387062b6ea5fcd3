"""Files that show a run as it moves: GIF and MP4 films, and glTF for viewers of 3-D models and web pages.

Source: Khronos Group, glTF 2.0 Specification, 2021 (ISO/IEC 12113).
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Iterable, Iterator, Sequence
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import arguments, checks
from flexmb.dynamics.jobs.files import whole_file
from flexmb.errors import InputError
from flexmb.late import mpl
from flexmb.model.shape import MARKER, TRACE, CircleShape, LineShape, Place, PointShape, RigidShape, nodes_of
from flexmb.results import drawing
from flexmb.results.positions import FlexibleMotion, at_times, flexible_motions, magnified
from flexmb.results.solution import Solution, require_rows
from flexmb.show.pictures.pose import THINNEST, Colouring, Pose, body_colours
from flexmb.show.pictures.scene import SHARE, Box, Scene, box_about, legend, scene_of
from flexmb.show.pictures.style import CLEARANCE, DIVERGING, SEQUENTIAL, label_axis, panel_of, words_of
from flexmb.version import installed_version

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
        self._figure, self._ax = self._make()
        self._canvas: Any = self._figure.canvas  # matplotlib declares no types here
        colouring = None if field is None else _colouring(self.scene, field[0])
        self._pose, name = Pose(self._ax, self.scene, 0, colouring), self.scene.name
        if magnify != 1.0:
            name += f", deformation x {magnify:g}" if magnify else ", undeformed"
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
        return Colouring(field, mpl.colors.Normalize(0.0, stress_limit(scene)), mpl.colormaps[SEQUENTIAL])
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
        return Path(import_module("flexmb.show.reports.study_pages").report(sol, target))
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


MAGIC, VERSION, JSON_CHUNK, BIN_CHUNK = 0x46546C67, 2, 0x4E4F534A, 0x004E4942
FLOAT, UINT = 5126, 5125  # component types of accessors
WEIGHTS = "weights"  # path of the motion of a mesh between its shapes
KINDS = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}
ARRAY_BUFFER, ELEMENT_BUFFER = 34962, 34963


class Glb:
    """A glTF document that grows by meshes, nodes and motions."""

    def __init__(self, generator: str) -> None:
        self._data = bytearray()
        self._inputs: dict[bytes, int] = {}
        lists: dict[str, Any] = {name: [] for name in ("nodes", "meshes", "materials", "accessors", "bufferViews")}
        head: Any = {"asset": {"version": "2.0", "generator": generator}, "scene": 0, "scenes": [{"nodes": []}]}
        self.document = head | lists | {"animations": [{"name": "motion", "channels": [], "samplers": []}]}

    def material(self, name: str, rgb: tuple[float, float, float]) -> int:
        """Number of a new material, seen from both sides; `rgb`: linear colour, 0 to 1."""
        surface = {"baseColorFactor": [*rgb, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.8}
        return self._append("materials", {"name": name, "pbrMetallicRoughness": surface, "doubleSided": True})

    def mesh(
        self, name: str, positions: np.ndarray, normals: np.ndarray, faces: np.ndarray, material: int, *,
        colours: np.ndarray | None = None, shapes: Sequence[np.ndarray] = (),
    ) -> int:  # fmt: skip
        """Number of a new mesh of triangles `faces` (m, 3) on positions (n, 3) [m] with unit normals (n, 3)."""
        # Linear colours (n, 3) of the points multiply that of the material; None: that of the material. `shapes` are
        # displacements (n, 3) [m] that `deform` adds up (morph targets).
        place = self._accessor(positions, ARRAY_BUFFER, limits=True)
        attributes = {"POSITION": place, "NORMAL": self._accessor(normals, ARRAY_BUFFER)}
        if colours is not None:
            attributes["COLOR_0"] = self._accessor(colours, ARRAY_BUFFER)
        indices = self._accessor(faces.reshape(-1, 1), ELEMENT_BUFFER)
        piece: dict[str, Any] = {"attributes": attributes, "indices": indices, "material": material, "mode": 4}
        mesh: dict[str, Any] = {"name": name, "primitives": [piece]}
        if len(shapes):
            piece["targets"] = [{"POSITION": self._accessor(one, ARRAY_BUFFER, limits=True)} for one in shapes]
            mesh[WEIGHTS] = [0.0] * len(shapes)
        return self._append("meshes", mesh)

    def node(self, name: str, meshes: list[int]) -> int:
        """Number of a new node of the scene with some meshes."""
        mine: dict[str, Any] = {"name": name}
        if len(meshes) == 1:
            mine["mesh"] = meshes[0]
        elif meshes:
            mine["children"] = [self._append("nodes", {"name": f"{name} {k}", "mesh": m}) for k, m in enumerate(meshes)]
        number = self._append("nodes", mine)
        self.document["scenes"][0]["nodes"].append(number)
        return number

    def move(
        self, node: int, time: np.ndarray, places: np.ndarray, angles: np.ndarray, scales: np.ndarray | None
    ) -> None:
        """Move a node: instants (n,) [s], places (n, 2) [m], angles (n,) [rad], factors `scales` (n, 3) or None."""
        zero = np.zeros(len(time))
        turns = np.stack([zero, zero, np.sin(0.5 * angles), np.cos(0.5 * angles)], axis=-1)
        motions = {"translation": np.column_stack([places, zero]), "rotation": turns}
        if scales is not None:
            motions["scale"] = scales
        mine = self.document["nodes"][node]
        for path, values in motions.items():
            mine[path] = np.asarray(values[0], dtype=np.float32).tolist()
            if len(time) > 1:
                self._channel(node, path, time, values)

    def deform(self, node: int, time: np.ndarray, weights: np.ndarray) -> None:
        """Deform the mesh of a node by factors (n, k) of its shapes at instants (n,) [s]."""
        self.document["nodes"][node][WEIGHTS] = np.asarray(weights[0], dtype=np.float32).tolist()
        if len(time) > 1:
            self._channel(node, WEIGHTS, time, weights.reshape(-1, 1))

    def _channel(self, node: int, path: str, time: np.ndarray, values: np.ndarray) -> None:
        motion, key = self.document["animations"][0], time.tobytes()
        if key not in self._inputs:
            self._inputs[key] = self._accessor(time.reshape(-1, 1), None, limits=True)
        output = self._accessor(values, None)
        motion["samplers"].append({"input": self._inputs[key], "output": output, "interpolation": "LINEAR"})
        motion["channels"].append({"sampler": len(motion["samplers"]) - 1, "target": {"node": node, "path": path}})

    def bytes(self) -> bytes:
        """The document as a binary glTF file."""
        done = {key: value for key, value in self.document.items() if value != []}
        done["animations"] = [motion for motion in self.document["animations"] if motion["channels"]]
        if not done["animations"]:
            del done["animations"]
        done["buffers"] = [{"byteLength": len(self._data)}]
        text = json.dumps(done, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        data = bytes(self._data) + b"\0" * (-len(self._data) % 4)
        head = struct.pack("<3I", MAGIC, VERSION, 12 + 8 + len(text) + 8 + len(data))
        return head + struct.pack("<2I", len(text), JSON_CHUNK) + text + struct.pack("<2I", len(data), BIN_CHUNK) + data

    def _append(self, kind: str, item: dict[str, Any]) -> int:
        self.document[kind].append(item)
        return len(self.document[kind]) - 1

    def _accessor(self, values: np.ndarray, target: int | None, *, limits: bool = False) -> int:
        """Number of a new accessor of an array (n, k): whole numbers as unsigned, others as floats of 32 bits."""
        whole = np.issubdtype(values.dtype, np.integer)
        array = np.ascontiguousarray(values, dtype=np.uint32 if whole else np.float32)
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self._data), "byteLength": array.nbytes}
        if target is not None:
            view["target"] = target
        self._data += array.tobytes()
        mine: dict[str, Any] = {"bufferView": self._append("bufferViews", view), "count": len(array)}
        mine |= {"componentType": UINT if whole else FLOAT, "type": KINDS[array.shape[1]]}
        if limits:
            mine |= {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()}
        return self._append("accessors", mine)


MOST_INSTANTS = 200  # default number of instants, at most
BAR = 0.006  # half width of the bars of rigid bodies, over the width of the mechanism
STRIDE = 2  # points of a drawn beam element for each straight piece: 4 pieces of 9 points
PIN_SIDES = 16  # number of sides of a pin


def export_gltf(sol: Solution, path: str | Path, *, frames: int | None = None, magnify: float = 1.0) -> Path:
    """Motion of a run as a binary glTF file, one unit a metre, the plane of motion as x and y.

    Rigid bodies, wheels and pins are nodes that move and turn; beams are chains of straight pieces, four an element;
    springs, dampers, rods and cables are nodes that also change their length.  Meshes move, deform by a few shapes, and
    have the colours of the largest von Mises stress that each point has at these instants.  Forces, belts, guides and
    paths are left out.  Viewers interpolate linearly between the instants.

    Parameters
    ----------
    sol : the solution.
    path : the .glb file; its folder is made.
    frames : number of instants, >= 2, evenly over the time, replaced by the nearest rows; None: all, at most 200.
    magnify : factor of the deformation of flexible bodies; 0: undeformed.

    Raises
    ------
    InputError : another ending, a solution without rows or shapes, a path that cannot be written.
    """
    target = checks.path("export_gltf", path)
    if target.suffix.lower() != ".glb":
        raise InputError(f"export_gltf: path is {str(path)!r}; it must end in .glb.")
    require_rows("export_gltf", sol)
    rows = drawing.spread_instants(sol, MOST_INSTANTS)
    if frames is not None:
        along = np.linspace(sol.time[0], sol.time[-1], checks.count("export_gltf", "frames", frames, 2))
        rows = drawing.nearest_instants(sol, along)
    content = Export(magnified(sol, checks.not_negative("export_gltf", "magnify", magnify)), rows, sol).bytes()
    with whole_file(target, "export_gltf") as part:
        part.write_bytes(content)
    return target


class Export(Glb):
    """A glTF document of some rows of a solution, with the stresses of one whose deformation is true."""

    def __init__(self, sol: Solution, rows: np.ndarray, true: Solution) -> None:
        super().__init__(f"flexmb {installed_version()}")
        self._sol, self._rows, self._time = sol, rows, sol.time[rows] - sol.time[rows[0]]
        self._scene: Scene = scene_of(sol, rows, true=true if true is not sol else None)
        self._half, colours = BAR * self._scene.size, body_colours(self._scene)
        self._materials = {part: self.material(part, _linear_of(colour)) for part, colour in colours.items()}
        self._grey = self.material("couplings", _linear_of("#606060"))
        self._rigid()
        for number, line in enumerate(line for line in self._scene.lines if line.is_beam):
            self._beam(number, line)
        bodies = {body.part: body for body in flexible_motions(sol, rows)}
        for surface in self._scene.surfaces:
            self._mesh(surface, bodies[surface.part])
        self._lines()
        self._pins()

    def _rigid(self) -> None:
        """One node for each node of a rigid body, with its outlines and wheels."""
        lines: dict[tuple[str, str], list[np.ndarray]] = {}
        for shape in self._sol.shapes:
            if isinstance(shape, RigidShape):
                mine = lines.setdefault((shape.part, shape.node), [])
                mine += [np.array(line, dtype=float) for line in shape.lines]
            elif isinstance(shape, CircleShape):
                lines.setdefault(shape.at[:2], []).append(drawing.circle_line(shape, 4 * PIN_SIDES + 1))
        for (part, node), mine in lines.items():
            name = f"{part}.{node}" if node else part
            solid = _joined([_bars(line, self._half) for line in mine])
            mesh = self.mesh(name, *solid, self._materials.get(part, self._grey))
            pose = drawing.pose(self._sol, part, node, self._rows)
            self.move(self.node(name, [mesh]), self._time, pose[:, :2], pose[:, 2], None)

    def _beam(self, number: int, line: drawing.Line) -> None:
        """Straight pieces of an element."""
        depth = np.zeros(line.points.shape[1]) if line.depth is None else line.depth
        for k in range(0, line.points.shape[1] - 1, STRIDE):
            half = max(0.25 * float(depth[k] + depth[k + STRIDE]), THINNEST * self._scene.size)
            solid = _bars(np.array([[0.0, 0.0], [1.0, 0.0]]), half)
            mesh = self.mesh(f"{line.part} {number}.{k}", *solid, self._materials[line.part])
            self._stretch(self.node(f"{line.part} {number}.{k}", [mesh]), line.points[:, k], line.points[:, k + STRIDE])

    def _mesh(self, surface: drawing.Surface, body: FlexibleMotion) -> None:
        """A mesh that moves as a rigid body, with the shapes of its deformation."""
        first = np.array(surface.shape.points)
        weights, shapes = body.deformation(surface.points, first)
        zeros, colours, material = np.zeros((len(first), 1)), None, self._materials[surface.part]
        if surface.has_stress:
            top = stress_limit(self._scene)
            colours = _linear(mpl.colormaps[SEQUENTIAL](surface.von_mises.max(axis=0) / top)[:, :3])
            name = f"{surface.part}: largest von Mises stress, 0 to {top:.4g} Pa"
            material = self.material(name, (1.0, 1.0, 1.0))
        up, morphs = np.tile([0.0, 0.0, 1.0], (len(first), 1)), [np.hstack([one, zeros]) for one in shapes]
        plane = np.hstack([first, zeros])
        mesh = self.mesh(surface.part, plane, up, surface.triangles, material, colours=colours, shapes=morphs)
        node = self.node(surface.part, [mesh])
        self.move(node, self._time, body.motion[:, :2], body.motion[:, 2], None)
        if len(shapes):
            self.deform(node, self._time, weights)

    def _stretch(self, node: int, first: np.ndarray, second: np.ndarray) -> None:
        """Move a node of unit length so that it joins two points (n, 2)."""
        way = second - first
        length = np.maximum(np.hypot(*way.T), 1e-9)
        scales = np.stack([length, np.ones(len(length)), np.ones(len(length))], axis=-1)
        self.move(node, self._time, first, np.unwrap(np.arctan2(way[:, 1], way[:, 0])), scales)

    def _lines(self) -> None:
        """Springs, dampers, rods and cables."""
        kinds = {shape.part: shape.kind for shape in self._sol.shapes if isinstance(shape, LineShape)}
        for sign in drawing.symbols(self._sol, self._rows, self._scene.size):
            if sign.part not in kinds or sign.kind != kinds[sign.part]:
                continue
            first, second = sign.points[:, 0], sign.points[:, -1]
            length, u, n = drawing.directions(second[0] - first[0])
            away = sign.points[0] - first[0]
            solid = _bars(np.stack([away @ u / max(float(length[0]), 1e-9), away @ n], axis=-1), 0.3 * self._half)
            self._stretch(self.node(sign.part, [self.mesh(sign.part, *solid, self._grey)]), first, second)

    def _pins(self) -> None:
        """Joints as short prisms."""
        dark = self.material("joints", _linear_of("#101010"))
        red = self.material("clearance", _linear_of(CLEARANCE))
        names = {shape.part for shape in self._sol.shapes if isinstance(shape, PointShape)}
        turn = 2.0 * np.pi * np.arange(PIN_SIDES) / PIN_SIDES
        rim = np.column_stack([np.cos(turn), np.sin(turn)])
        used = {red if mark.kind == "clearance" else dark for mark in self._scene.marks if mark.kind != "journal"}
        meshes = {m: self.mesh("pin", *_prism(1.6 * self._half * rim, 1.3 * self._half), m) for m in used}
        for mark in self._scene.marks:
            if mark.kind != "journal" and mark.part in names:
                node = self.node(mark.part, [meshes[red if mark.kind == "clearance" else dark]])
                self.move(node, self._time, mark.points, np.zeros(len(self._time)), None)


Solid = tuple[np.ndarray, np.ndarray, np.ndarray]  # points, normals and triangles


def _bars(line: np.ndarray, half: float) -> Solid:
    """Bars of square section along a polyline (m, 2); a cube for a line without length."""
    pieces = []
    for a, b in pairwise(line):
        _, (ux, uy), _ = drawing.directions(b - a)
        if ux == uy == 0.0:
            ux, half_x, half_y = 1.0, 2.0 * half, 2.0 * half
        else:
            half_x, half_y = 0.5 * math.dist(a, b), half
        u, n = half_x * np.array([ux, uy]), half_y * np.array([-uy, ux])
        pieces.append(_prism(0.5 * (a + b) + np.array([-u - n, u - n, u + n, n - u]), half))
    return _joined(pieces)


def _prism(outline: np.ndarray, half: float) -> Solid:
    """Prism of a convex outline (m, 2), counter-clockwise, with half a height along z; each of its faces is flat."""
    n = len(outline)
    low, high = (np.column_stack([outline, np.full(n, z)]) for z in (-half, half))
    _, _, left = drawing.directions(np.roll(outline, -1, axis=0) - outline)
    walls = np.stack([low, np.roll(low, -1, axis=0), np.roll(high, -1, axis=0), high], axis=1).reshape(-1, 3)
    outward = np.repeat(np.column_stack([-left, np.zeros(n)]), 4, axis=0)
    quads = (4 * np.arange(n)[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)
    fan = np.stack([np.zeros(n - 2, dtype=int), np.arange(1, n - 1), np.arange(2, n)], axis=1)
    up = np.tile([0.0, 0.0, 1.0], (n, 1))
    return _joined([(walls, outward, quads), (high, up, fan), (low, -up, fan[:, ::-1])])


def _joined(solids: list[Solid]) -> Solid:
    """One solid of several."""
    starts = np.cumsum([0, *(len(points) for points, _, _ in solids[:-1])])
    faces = [faces + start for (_, _, faces), start in zip(solids, starts, strict=True)]
    return np.concatenate([s[0] for s in solids]), np.concatenate([s[1] for s in solids]), np.concatenate(faces)


def _linear_of(colour: str) -> tuple[float, float, float]:
    """Linear red, green, blue of a colour of the screen, such as "#606060"."""
    r, g, b = _linear(np.array([int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)])).tolist()
    return r, g, b


def _linear(values: np.ndarray) -> np.ndarray:
    """Linear red, green, blue of colours of the screen, 0 to 1 (IEC 61966-2-1)."""
    return np.asarray(np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4))
