"""Poses of a mechanism at several instants, as a matplotlib figure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import checks
from flexmb.errors import InputError
from flexmb.model.shape import MARKER, TRACE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from flexmb.results.drawing import Line, Mark
    from flexmb.results.solution import Solution

Box = tuple[tuple[float, float], tuple[float, float]]
"""Limits of x and of y [m]."""

PANELS = 6
"""Default number of instants."""
TRACE_POSES = 6
"""Number of earlier poses behind each instant."""
PER_ELEMENT = 9
"""Number of points on a beam element."""
COLOURS = ("#1b6ca8", "#d1495b", "#2e8b57", "#e08e0b", "#6a4c93", "#00838f", "#8d5524", "#c2185b", "#607d8b", "#556b2f")
BOX_POSES = 400
"""Number of poses of a run, at most, that the limits of the axes are taken from."""
SYMBOLS: dict[str, dict[str, Any]] = {
    "spring": {"color": "0.25", "linewidth": 1.1, "zorder": 2.5},
    "damper": {"color": "0.25", "linewidth": 1.1, "zorder": 2.5},
    "rod": {"color": "0.35", "linewidth": 1.6, "zorder": 1.8},
    "cable": {"color": "0.35", "linewidth": 0.9, "linestyle": "--", "zorder": 1.8},
    "force": {"color": "#b00020", "linewidth": 1.4, "zorder": 3.5},
    "pitch circle": {"color": "0.45", "linewidth": 1.0, "zorder": 1.7},
}
MARKERS = {"prismatic": "s", "fixed": "D", "clearance": "o"}


def render(
    sol: Solution,
    times: Sequence[float] | np.ndarray | None = None,
    *,
    path: str | Path | None = None,
    size: tuple[float, float] | None = None,
) -> Figure:
    """Poses of a mechanism at several instants, side by side, with earlier poses in light grey.

    Each body has a colour.  Beams are drawn deformed in true scale.  Joints are dots, joints with clearance red rings;
    joints on the ground stand on a triangle.  Springs are zig-zags, dampers dashpots, forces arrows of one length,
    gears and belts circles with a spoke.  The axes show the room of the whole run, so its pictures have one size.

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
    from matplotlib.figure import Figure

    from flexmb.results import drawing
    from flexmb.results.symbols import symbols

    nearest = drawing.nearest_instants if times is None else drawing.nearest_to_each
    indices = nearest(sol, _instants(sol, times))
    all_indices, box = _with_trace(indices), _box_of_run(sol)
    lines = drawing.lines(sol, all_indices, PER_ELEMENT)
    marks, traces = drawing.marks(sol, all_indices), drawing.traces(sol)
    signs = symbols(sol, all_indices, box[0][1] - box[0][0])
    columns = 2 if len(indices) == 4 else min(3, len(indices))
    rows = math.ceil(len(indices) / columns)
    figure = Figure(figsize=_size(box, columns, rows, size), layout="constrained")
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for k, ax in enumerate(grid.flat):
        if k < len(indices):
            now = int(np.searchsorted(all_indices, indices[k]))
            before = int(np.searchsorted(all_indices, indices[k - 1])) if k else now
            _panel(ax, lines, marks, now, range(before, now))
            for sign in signs:
                ax.plot(*sign.points[now].T, gid=f"{sign.kind} {sign.part}", **SYMBOLS[sign.kind])
            for name, path_of_point in traces.items():
                ax.plot(*path_of_point.T, color="#7a3fb5", linewidth=1.0, zorder=1.5, gid=f"{TRACE} {name}")
            ax.set_title(f"t = {sol.time[indices[k]]:.6g} s", fontsize="small")
        ax.set(xlim=box[0], ylim=box[1], aspect="equal", visible=k < len(indices))
        _label(ax, left=k % columns == 0, below=k + columns >= len(indices))
    _names(grid.flat[0], marks, int(np.searchsorted(all_indices, indices[0])), box)
    _finish(figure, sol.name, _colours(lines), marks)
    return figure if path is None else _saved(figure, Path(path))


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


def _box_of_run(sol: Solution) -> Box:
    """Limits of x and y that hold all poses of a run, some hundred of them in long runs."""
    from flexmb.results import drawing
    from flexmb.results.symbols import symbols

    every = np.unique(np.linspace(0, len(sol.time) - 1, min(len(sol.time), BOX_POSES)).round().astype(int))
    lines, marks = drawing.lines(sol, every, PER_ELEMENT), drawing.marks(sol, every)
    points = [line.points for line in lines] + [m.points for m in marks] + list(drawing.traces(sol).values())
    whole = np.concatenate([p.reshape(-1, 2) for p in points])
    size = float(max(*np.ptp(whole, axis=0), 1e-9))
    return _box([whole, *(sign.points for sign in symbols(sol, every, size))])


def _box(points: list[np.ndarray]) -> Box:
    """Limits of x and y around all points, with a margin."""
    flat = np.concatenate([p.reshape(-1, 2) for p in points])
    low, high = flat.min(axis=0), flat.max(axis=0)
    size = float(max(*(high - low), 1e-9))
    margin, least = 0.12 * size, 0.35 * size
    widen = np.maximum(least - (high - low), 0.0) / 2.0 + margin
    (x0, y0), (x1, y1) = (low - widen).tolist(), (high + widen).tolist()
    return (x0, x1), (y0, y1)


def _size(box: Box, columns: int, rows: int, size: tuple[float, float] | None) -> tuple[float, float]:
    """Width and height of the figure [inch]."""
    if size is not None:
        width, height = size
        return checks.positive("render", "size[0]", width, "inch"), checks.positive("render", "size[1]", height, "inch")
    (x0, x1), (y0, y1) = box
    wide = 3.2 if columns > 1 else 6.0
    return 0.6 + (wide + 0.15) * columns, 1.2 + rows * (0.3 + min(wide * (y1 - y0) / (x1 - x0), 4.5))


def _colours(lines: list[Line]) -> dict[str, str]:
    parts = dict.fromkeys(line.part for line in lines)
    return {part: COLOURS[k % len(COLOURS)] for k, part in enumerate(parts)}


def _panel(ax: Axes, lines: list[Line], marks: list[Mark], now: int, before: range) -> None:
    """Draw one pose, with the earlier poses behind."""
    colours = _colours(lines)
    for line in lines:
        for k in before:
            ax.plot(*line.points[k].T, color="0.85", linewidth=0.8, zorder=1)
        point = np.ptp(line.points[now], axis=0).max() == 0.0  # a body without joints outside its centre
        style: dict[str, Any] = {"marker": "s", "markersize": 14} if point else {"solid_capstyle": "round"}
        width = 2.0 if line.is_beam else 2.6
        ax.plot(*line.points[now].T, color=colours[line.part], linewidth=width, zorder=2, **style)
    for mark in marks:
        if mark.kind != "journal":
            _joint(ax, mark, mark.points[now])
    ax.grid(visible=True, color="0.94", linewidth=0.5)
    ax.set_axisbelow(True)


def _label(ax: Axes, *, left: bool, below: bool) -> None:
    """Label the axes at the rim of the grid only."""
    ax.tick_params(labelsize="x-small", labelbottom=below, labelleft=left)
    ax.set_xlabel("x [m]" if below else "", fontsize="small")
    ax.set_ylabel("y [m]" if left else "", fontsize="small")


def _joint(ax: Axes, mark: Mark, at: np.ndarray) -> None:
    if mark.on_ground:
        ax.plot(at[0], at[1], marker=6, color="0.45", markersize=9, linestyle="", zorder=3)
    style: dict[str, Any]
    if mark.kind == "clearance":
        style = {"markersize": 9, "markerfacecolor": "white", "markeredgecolor": "#c00000", "markeredgewidth": 1.8}
    elif mark.kind in (MARKER, TRACE):
        style = {"markersize": 3.5, "color": "#7a3fb5"}
    else:
        style = {"markersize": 4.5, "color": "black"}
    ax.plot(at[0], at[1], marker=MARKERS.get(mark.kind, "o"), linestyle="", zorder=4, **style)


def _names(ax: Axes, marks: list[Mark], now: int, box: Box) -> None:
    """Draw the names of the joints on the side away from the other joints; coincident joints share a label."""
    from matplotlib.patheffects import withStroke

    near = 0.03 * (box[0][1] - box[0][0])
    groups: list[tuple[np.ndarray, list[str]]] = []
    for mark in (m for m in marks if m.kind != "journal"):
        at = mark.points[now]
        group = next((names for point, names in groups if np.hypot(*(point - at)) < near), None)
        if group is None:
            groups.append((at, [mark.part]))
        else:
            group.append(mark.part)
    middle = np.mean([at for at, _ in groups], axis=0) if groups else np.zeros(2)
    rim = 0.2 * box[0][0] + 0.8 * box[0][1]  # further right a name would run over the edge
    halo = [withStroke(linewidth=2.0, foreground="white")]
    for at, names in groups:
        right, up = middle[0] <= at[0] < rim, at[1] >= middle[1]
        style: dict[str, Any] = {"ha": "left" if right else "right", "va": "bottom" if up else "top"}
        style |= {"textcoords": "offset points", "fontsize": "x-small", "path_effects": halo, "zorder": 5}
        shift = (5 if right else -5, 5 if up else -5)
        ax.annotate(", ".join(names), (float(at[0]), float(at[1])), xytext=shift, **style)


def _finish(figure: Figure, title: str, colours: dict[str, str], marks: list[Mark]) -> None:
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], color=colour, linewidth=2.4, label=part) for part, colour in colours.items()]
    if any(m.kind == "clearance" for m in marks):
        ring: dict[str, Any] = {"marker": "o", "markersize": 8, "markerfacecolor": "white"}
        ring |= {"markeredgecolor": "#c00000", "markeredgewidth": 1.8}
        handles.append(Line2D([], [], linestyle="", label="joint with clearance", **ring))
    if handles:
        columns = min(len(handles), 6)
        figure.legend(handles=handles, loc="outside lower center", ncols=columns, frameon=False, fontsize="small")
    figure.suptitle(title)


def _saved(figure: Figure, path: Path) -> Figure:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=150)
    except (OSError, ValueError) as error:  # ValueError: an ending that is no format of matplotlib
        text = f"render: {str(path)!r} cannot be written ({error}). Give e.g. a .png in a writable folder."
        raise InputError(text) from error
    return figure
