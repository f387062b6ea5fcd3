"""Poses of a mechanism at several instants, as a matplotlib figure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import arguments, checks
from flexmb.errors import InputError
from flexmb.pictures.poses.labels import place_names
from flexmb.pictures.poses.pose import RING, Pose, body_colours
from flexmb.pictures.poses.scene import Box, Scene, scene_of
from flexmb.pictures.style import CLEARANCE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.text import Annotation

    from flexmb.results.solution import Solution

SIZES = 0.5, 100.0
"""Least and largest width and height of a picture [inch]."""
PANELS = 6
"""Default number of instants."""
TRACE_POSES = 6
"""Number of earlier poses behind each instant."""
MOST_NAMES = 24
"""Largest number of names in a legend, and of names of joints in a panel; of more joints none is named."""
NEAR = 0.012
"""Distance of joints that share a name, over the width of the picture."""


CORNERS = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
"""Points of a ring that names keep free, over its radius."""


@arguments.checked
def render(
    sol: Solution,
    times: Sequence[float] | np.ndarray | None = None,
    *,
    path: str | Path | None = None,
    size: tuple[float, float] | None = None,
) -> Figure:
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
    from flexmb.pictures.figure import Picture
    from flexmb.results import drawing

    nearest = drawing.nearest_instants if times is None else drawing.nearest_to_each
    indices = nearest(sol, _instants(sol, times))
    rows = _with_trace(indices)
    scene = scene_of(sol, rows)
    columns = 2 if len(indices) == 4 else min(3, len(indices))
    lines = math.ceil(len(indices) / columns)
    figure = Picture(figsize=figure_size("render", scene.box, columns, lines, size), layout="constrained")
    grid = figure.subplots(lines, columns, sharex=True, sharey=True, squeeze=False)
    for k, ax in enumerate(grid.flat):
        if k < len(indices):
            now = int(np.searchsorted(rows, indices[k]))
            _earlier_poses(ax, scene, range(int(np.searchsorted(rows, indices[k - 1])) if k else now, now))
            Pose(ax, scene, now)
            ax.set_title(f"t = {sol.time[indices[k]]:.6g} s", fontsize="small")
        ax.set(xlim=scene.box[0], ylim=scene.box[1], aspect="equal", visible=k < len(indices))
        _label(ax, left=k % columns == 0, below=k + columns >= len(indices))
    legend(figure, scene)
    figure.suptitle(sol.name)
    joint_names(grid.flat[0], scene, int(np.searchsorted(rows, indices[0])))
    if path is not None:
        figure.savefig(path, dpi=150)
    return figure


def _instants(sol: Solution, times: Sequence[float] | np.ndarray | None) -> np.ndarray:
    if not len(sol.time):
        raise InputError("render: the solution has no saved instants. Save some, e.g. by simulate(..., save=...).")
    if not sol.shapes:
        raise InputError("render: the solution has no shapes to draw. Build it from a mechanism with bodies.")
    first, last = float(sol.time[0]), float(sol.time[-1])
    if times is None:
        return np.linspace(first, last, PANELS)
    wanted = [checks.between("render", f"times[{i}]", t, first, last, "s") for i, t in enumerate(times)]
    if not wanted:
        raise InputError("render: times is empty; give at least one instant, or leave it out for six.")
    return np.array(wanted)


def _with_trace(indices: np.ndarray) -> np.ndarray:
    """The instants to be shown, and some instants between them."""
    between = [np.linspace(a, b, TRACE_POSES + 2).round().astype(int) for a, b in pairwise(indices)]
    return np.unique(np.concatenate([indices, *between]))


def figure_size(label: str, box: Box, columns: int, rows: int, size: tuple[float, float] | None) -> tuple[float, float]:
    """Width and height of a figure of some panels [inch], as given, or from the limits of x and y."""
    if size is not None:
        wide, high = checks.point(label, "size", size, "inch")
        return checks.between(label, "size[0]", wide, *SIZES, "inch"), checks.between(
            label, "size[1]", high, *SIZES, "inch"
        )
    (x0, x1), (y0, y1) = box
    wide = 3.2 if columns > 1 else 6.0
    return 0.6 + (wide + 0.15) * columns, 1.2 + rows * (0.3 + min(wide * (y1 - y0) / (x1 - x0), 1.4 * wide))


def _earlier_poses(ax: Axes, scene: Scene, before: range) -> None:
    """Draw the earlier poses in grey, and the grid."""
    for line in scene.lines:
        for k in before:
            ax.plot(*line.points[k].T, color="0.85", linewidth=0.8, zorder=1)
    ax.grid(visible=True, color="0.94", linewidth=0.5)
    ax.set_axisbelow(True)


def _label(ax: Axes, *, left: bool, below: bool) -> None:
    """Label the axes at the rim of the grid only."""
    ax.tick_params(labelsize="x-small", labelbottom=below, labelleft=left)
    ax.set_xlabel("x [m]" if below else "", fontsize="small")
    ax.set_ylabel("y [m]" if left else "", fontsize="small")


def joint_names(ax: Axes, scene: Scene, now: int, others: Sequence[tuple[np.ndarray, str]] = ()) -> list[Annotation]:
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


def legend(figure: Figure, scene: Scene) -> None:
    """Legend of bodies and joints with clearance, below the panels."""
    from matplotlib.lines import Line2D

    colours = body_colours(scene)
    handles = [Line2D([], [], color=colour, linewidth=2.4, label=part) for part, colour in colours.items()]
    if any(m.kind == "clearance" for m in scene.marks):
        ring: dict[str, Any] = {"marker": "o", "markersize": 8, "markerfacecolor": "white"}
        ring |= {"markeredgecolor": CLEARANCE, "markeredgewidth": 1.8}
        handles.append(Line2D([], [], linestyle="", label="joint with clearance", **ring))
    if len(handles) > MOST_NAMES:
        more = len(handles) - MOST_NAMES + 1
        handles = [*handles[: MOST_NAMES - 1], Line2D([], [], linestyle="", label=f"and {more} more")]
    if handles:
        columns = _columns([len(str(handle.get_label())) for handle in handles], figure.get_size_inches()[0])
        figure.legend(handles=handles, loc="outside lower center", ncols=columns, frameon=False, fontsize="small")


def _columns(lengths: list[int], width: float) -> int:
    """Largest number of columns of a legend that fit into a width [inch], for the lengths of its texts."""
    for columns in range(len(lengths), 1, -1):
        if sum(0.62 + 0.085 * max(column) for column in np.array_split(lengths, columns)) <= width:
            return columns
    return 1
