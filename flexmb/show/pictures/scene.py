"""Scenes of a run, and figures of a mechanism before it moves and at several instants."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import arguments, checks
from flexmb.errors import InputError
from flexmb.late import mpl
from flexmb.model.mechanism import Mechanism
from flexmb.model.signal import Signal, Signals
from flexmb.results import drawing
from flexmb.results.drawing import ARROW, HEAD, Line, Mark, Surface, arrow_line, symbols
from flexmb.results.solution import Peaks, Solution, Stats, require_rows
from flexmb.show.pictures.pose import RING, Pose, body_colours, place_names
from flexmb.show.pictures.style import CLEARANCE, panel_of, panels_of, settled

Box = tuple[tuple[float, float], tuple[float, float]]  # limits of x and of y [m]
PER_ELEMENT = 9  # number of points on a beam element
SHARE = 98.0  # percentile of absolute values at which colours and lengths of arrows end; impacts would dwarf the rest
BOX_POSES = 400  # number of poses of a run, at most, that the limits of the axes are taken from


@dataclass(frozen=True)
class Scene:
    """Drawing of a run at n instants."""

    name: str  # name of the mechanism
    time: np.ndarray  # (n,) instants [s]
    lines: list[Line]  # outlines of rigid bodies and meshes, axes of beams
    marks: list[Mark]  # joints and markers
    signs: list[Line]  # symbols of springs, loads, couplings
    box: Box  # limits of x and y
    forces: list[Line] = field(default_factory=list)  # arrows of joint forces, at most as long as the arrow of a load
    # paths (m, 2) of points by name [m], and their instants (m,) [s]
    paths: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    surfaces: list[Surface] = field(default_factory=list)  # meshes of plane bodies

    @property
    def size(self) -> float:
        """Width of the picture [m]."""
        return self.box[0][1] - self.box[0][0]

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of the bodies with lines, in their order."""
        return tuple(dict.fromkeys(line.part for line in self.lines))


def scene_of(
    sol: Solution, rows: np.ndarray, *, box: Box | None = None,
    paths: dict[str, tuple[np.ndarray, np.ndarray]] | None = None, forces: Sequence[str] = (),
    true: Solution | None = None,
) -> Scene:  # fmt: skip
    """Scene of saved rows with numbers (n,) of a solution; `box`: limits of the axes, None: room for all poses."""
    # `paths` are paths of points by name, with their instants; None: those of the markers with a trace. Section forces
    # and stresses are those of `true` where the deformation of `sol` is magnified.
    traced = {name: (path, sol.time) for name, path in drawing.traces(sol).items()} if paths is None else paths
    if box is None:  # room for all poses of the run, some hundred of them in long runs
        every = np.unique(np.linspace(0, len(sol.time) - 1, min(len(sol.time), BOX_POSES)).round().astype(int))
        points = [line.points for line in drawing.lines(sol, every, PER_ELEMENT)]
        points += [*(mark.points for mark in drawing.marks(sol, every)), *(path for path, _ in traced.values())]
        whole = np.concatenate([p.reshape(-1, 2) for p in points])
        extent = float(max(*np.ptp(whole, axis=0), 1e-9))
        box = box_around([whole, *(sign.points for sign in symbols(sol, every, extent))])
    size = box[0][1] - box[0][0]
    lines, marks = drawing.lines(sol, rows, PER_ELEMENT), drawing.marks(sol, rows)
    # Arrows of joint forces are as long as the forces are large up to the 98th percentile of all of them, which has the
    # length of a load's arrow; larger forces, those of impacts, have the same length.
    places = {mark.part: mark.points for mark in marks if mark.kind != "journal"}
    vectors = {name: np.stack([sol.array(f"{name}.fx"), sol.array(f"{name}.fy")], axis=-1)[rows] for name in forces}
    sizes = np.concatenate([np.zeros(1), *(np.hypot(*v.T) for v in vectors.values())])
    top = float(np.percentile(sizes, SHARE)) or float(sizes.max()) or 1.0
    arrows = []
    for name, vector in vectors.items():
        if name not in places:
            raise InputError(f"forces: {name!r} is no joint that is drawn. Known: {', '.join(places)}.")
        arrow = ARROW * size * vector / np.maximum(np.hypot(*vector.T), top)[:, None]
        arrows.append(Line(name, "force", arrow_line(places[name], places[name] + arrow, HEAD * size)))
    signs, meshes = symbols(sol, rows, size), drawing.surfaces(sol, rows)
    if true is not None:
        for line, own in zip(lines, drawing.lines(true, rows, PER_ELEMENT), strict=True):
            line.fields.update(own.fields)
        own_poses = (mesh.poses for mesh in drawing.surfaces(true, rows))
        meshes = [replace(mesh, poses=poses) for mesh, poses in zip(meshes, own_poses, strict=True)]
    return Scene(sol.name, sol.time[rows], lines, marks, signs, box, arrows, traced, meshes)


LEAST_SIZE, LONE_POINT = 1e-9, 0.1  # extent of a mechanism [m] below which it is a point; width of its picture [m]


def box_around(points: list[np.ndarray]) -> Box:
    """Limits of x and y around all points (..., 2) [m], with a margin."""
    flat = np.concatenate([p.reshape(-1, 2) for p in points])
    low, high = flat.min(axis=0), flat.max(axis=0)
    extent = float(max(*(high - low)))
    size = LONE_POINT if extent < LEAST_SIZE else extent
    margin, least = 0.12 * size, 0.35 * size
    widen = np.maximum(least - (high - low), 0.0) / 2.0 + margin
    (x0, y0), (x1, y1) = (low - widen).tolist(), (high + widen).tolist()
    return (x0, x1), (y0, y1)


def box_about(sol: Solution, row: int, centre: np.ndarray) -> Box:
    """Limits of x and y around a point (2,) [m], as wide as the bodies need in any direction at one instant."""
    points = np.concatenate([line.points[0] for line in drawing.lines(sol, np.array([row]), PER_ELEMENT)])
    return box_around([centre + float(np.hypot(*(points - centre).T).max()) * np.array([[-1.0, -1.0], [1.0, 1.0]])])


SIZES = 0.5, 100.0  # least and largest width and height of a picture [inch]
PANELS = 6  # default number of instants
TRACE_POSES = 6  # number of earlier poses behind each instant
MOST_NAMES = 24  # largest number of names in a legend, and of names of joints in a panel; of more joints none is named
NEAR = 0.012  # distance of joints that share a name, over the width of the picture
CORNERS = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])  # of a ring names keep free, over its radius


@arguments.checked
def render(
    sol: Solution, times: Sequence[float] | np.ndarray | None = None, *, path: str | Path | None = None,
    size: tuple[float, float] | None = None,
) -> mpl.figure.Figure:  # fmt: skip
    """Poses of a mechanism at several instants, side by side, with earlier poses in light grey.

    Each body has a colour.  Beams are drawn deformed in true scale and with their depth.  Joints are dots, joints with
    clearance red rings in which the journal is seen, its eccentricity drawn over the largest one of the picture; joints
    on the ground stand on a triangle, sliders on the line of their guide.  Springs are zig-zags, dampers dashpots,
    forces arrows of one length, gears circles with a spoke, belts closed lines.  The axes show the room of the whole
    run, so its pictures have one size.

    Parameters
    ----------
    sol : the solution.
    times : instants [s], replaced by the nearest saved instants; None: six instants over the whole time.
    path : file of the picture, whose ending gives the format; None: no file.
    size : width and height [inch]; None: from the size of the mechanism.

    Raises
    ------
    InputError : instants outside the run, a solution without instants or shapes, a path that cannot be written.
    """
    nearest = drawing.nearest_instants if times is None else drawing.nearest_to_each
    indices = nearest(sol, _instants(sol, times))
    between = [np.linspace(a, b, TRACE_POSES + 2).round().astype(int) for a, b in pairwise(indices)]
    rows = np.unique(np.concatenate([indices, *between]))
    scene = scene_of(sol, rows)
    columns = 2 if len(indices) == 4 else min(3, len(indices))
    lines = math.ceil(len(indices) / columns)
    inches = figure_size("render", scene.box, columns, lines, size)
    figure, axes = panels_of(inches, sol.name, rows=lines, columns=columns, sharex=True, sharey=True)
    for k, ax in enumerate(axes):
        if k < len(indices):
            now = int(np.searchsorted(rows, indices[k]))
            for line in scene.lines:
                for before in range(int(np.searchsorted(rows, indices[k - 1])) if k else now, now):
                    ax.plot(*line.points[before].T, color="0.85", linewidth=0.8, zorder=1)
            Pose(ax, scene, now)
            ax.set_title(f"t = {sol.time[indices[k]]:.6g} s", fontsize="small")
        ax.set(xlim=scene.box[0], ylim=scene.box[1], aspect="equal", visible=k < len(indices))
        left, below = k % columns == 0, k + columns >= len(indices)
        ax.tick_params(labelsize="x-small", labelbottom=below, labelleft=left)
        ax.set_xlabel("x [m]" if below else "", fontsize="small")
        ax.set_ylabel("y [m]" if left else "", fontsize="small")
    legend(figure, scene)
    with settled(figure):
        joint_names(axes[0], scene, int(np.searchsorted(rows, indices[0])))
        if path is not None:
            figure.savefig(path, dpi=150)
    return figure


def _instants(sol: Solution, times: Sequence[float] | np.ndarray | None) -> np.ndarray:
    require_rows("render", sol)
    first, last = float(sol.time[0]), float(sol.time[-1])
    if times is None:
        return np.linspace(first, last, PANELS)
    listed = checks.sequence("render", "times", times, "instants")
    wanted = [checks.between("render", f"times[{i}]", t, first, last, "s") for i, t in enumerate(listed)]
    if not wanted:
        raise InputError("render: times is empty; give at least one instant, or leave it out for six.")
    return np.array(wanted)


def figure_size(label: str, box: Box, columns: int, rows: int, size: tuple[float, float] | None) -> tuple[float, float]:
    """Width and height of a figure of some panels [inch], as given, or from the limits of x and y."""
    if size is not None:
        wide, high = checks.point(label, "size", size, "inch")
        width = checks.between(label, "size[0]", wide, *SIZES, "inch")
        return width, checks.between(label, "size[1]", high, *SIZES, "inch")
    (x0, x1), (y0, y1) = box
    wide = 3.2 if columns > 1 else 6.0
    return 0.6 + (wide + 0.15) * columns, 1.2 + rows * (0.3 + min(wide * (y1 - y0) / (x1 - x0), 1.4 * wide))


def joint_names(
    ax: mpl.axes.Axes, scene: Scene, now: int, others: Sequence[tuple[np.ndarray, str]] = ()
) -> list[mpl.text.Annotation]:
    """Names of the joints beside them; coincident joints share a name."""
    groups: list[tuple[np.ndarray, list[str]]] = []
    for mark in (m for m in scene.marks if m.kind != "journal"):
        at = mark.points[now]
        group = next((names for point, names in groups if np.hypot(*(point - at)) < NEAR * scene.size), None)
        if group is None:
            groups.append((at, [mark.part]))
        else:
            group.append(mark.part)
    if len(groups) > MOST_NAMES:
        return place_names(ax, others, [])
    lines = [line.points[now] for line in scene.lines] + [sign.points[now] for sign in scene.signs]
    named = [(at, ", ".join(names)) for at, names in groups]
    rings = [mark.points[now] + RING * scene.size * CORNERS for mark in scene.marks if mark.kind == "clearance"]
    feet = [mark.points[now] for mark in scene.marks if mark.on_ground]
    return place_names(ax, [*named, *others], lines, [point for ring in rings for point in ring], feet)


def legend(figure: mpl.figure.Figure, scene: Scene) -> None:
    """Legend of bodies and joints with clearance, below the panels."""
    colours = body_colours(scene)
    handles = [mpl.lines.Line2D([], [], color=colour, linewidth=2.4, label=part) for part, colour in colours.items()]
    if any(m.kind == "clearance" for m in scene.marks):
        ring: dict[str, Any] = {"marker": "o", "markersize": 8, "markerfacecolor": "white"}
        ring |= {"markeredgecolor": CLEARANCE, "markeredgewidth": 1.8}
        handles.append(mpl.lines.Line2D([], [], linestyle="", label="joint with clearance", **ring))
    if len(handles) > MOST_NAMES:
        more = len(handles) - MOST_NAMES + 1
        handles = [*handles[: MOST_NAMES - 1], mpl.lines.Line2D([], [], linestyle="", label=f"and {more} more")]
    if handles:
        lengths, width = [len(str(handle.get_label())) for handle in handles], figure.get_size_inches()[0]
        parts = ((k, np.array_split(lengths, k)) for k in range(len(lengths), 1, -1))
        columns = next((k for k, own in parts if sum(0.62 + 0.085 * max(one) for one in own) <= width), 1)
        figure.legend(handles=handles, loc="outside lower center", ncols=columns, frameon=False, fontsize="small")


UNITS = {"x": "m", "y": "m", "theta": "rad"}


def plot_mechanism(
    mechanism: Mechanism, path: str | Path | None, *, lengths: bool, size: tuple[float, float] | None
) -> mpl.figure.Figure:
    """Picture of a mechanism, see `Mechanism.plot`, with lengths of straight links or without; `size` [inch]."""
    if not mechanism.bodies:
        raise InputError(f"{mechanism.label} has no bodies to draw. Add some, e.g. a RigidLink.")
    scene = scene_of(reference_solution(mechanism), np.array([0]))
    figure, ax = panel_of(figure_size("plot", scene.box, 1, 1, size), mechanism.name)
    Pose(ax, scene, 0)
    ax.set(xlim=scene.box[0], ylim=scene.box[1], aspect="equal", xlabel="x [m]", ylabel="y [m]")
    legend(figure, scene)
    links = []  # middles of the straight bodies and their lengths
    for part in scene.parts if lengths else ():
        points = np.concatenate([line.points[0] for line in scene.lines if line.part == part])
        length = math.dist(points[0], points[-1])
        if length > 0.0 and np.hypot(*np.diff(points, axis=0).T).sum() < (1.0 + 1e-6) * length:
            links.append((0.5 * (points[0] + points[-1]), f"{length:.4g} m"))
    joint_names(ax, scene, 0, links)
    if path is not None:
        figure.savefig(path, dpi=150)
    return figure


def reference_solution(mechanism: Mechanism) -> Solution:
    """Solution with one row, the reference configuration, for drawings."""
    signals, values = [], []
    for part, node in mechanism.nodes():
        stem = f"{part}.{node.name}" if node.name else part
        for axis, value in zip(UNITS, (node.x, node.y, node.theta), strict=True):
            signals.append(Signal(f"{stem}.{axis}", UNITS[axis]))
            values.append(value)
    row = np.array([values])
    return Solution(
        time=np.zeros(1), values=row, signals=Signals.of(tuple(signals)),
        peaks=Peaks(np.abs(row[0]), np.zeros(len(values))), status="Reference configuration.", ok=True,
        stats=Stats(), shapes=mechanism.shapes(), model={"name": mechanism.name},
    )  # fmt: skip
