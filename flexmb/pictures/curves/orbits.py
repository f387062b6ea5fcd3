"""Branches of periodic orbits and basins of attraction as matplotlib figures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexmb import checks
from flexmb.dynamics.basins.basin import Basin
from flexmb.dynamics.orbits.branch import Branch, BranchPoint
from flexmb.dynamics.orbits.floquet import BRANCH, FLIP, FOLD, GRAZING, NEIMARK_SACKER
from flexmb.errors import InputError
from flexmb.pictures.style import COLOURS, grid, label_axis

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZE = (8.0, 5.0)  # of a figure [inch]

STABLE, UNSTABLE = COLOURS[0], COLOURS[1]

MARKS = {
    FOLD: ("o", "#e69f00", "fold"),
    FLIP: ("s", "#cc79a7", "flip (period doubling)"),
    NEIMARK_SACKER: ("D", "#009e73", "Neimark-Sacker (torus)"),
    GRAZING: ("v", "black", "grazing"),
    BRANCH: ("*", "#882255", "branch point"),
}

LOST_COLOUR, OPEN_COLOUR = "black", "0.75"


def plot_branch(
    branches: Branch | Sequence[Branch], signal: str, *, value: str = "section", title: str | None = None
) -> Figure:
    """Periodic orbits over a parameter: stable orbits solid, unstable orbits dashed, events marked.

    Parameters
    ----------
    branches : one branch, or several of one system and parameter.
    signal : name of a signal, or "period".
    value : "section": value at the start of the orbit; "max" or "min": largest or smallest value on the orbit, for
        branches computed with extremes=; "amplitude": half of their difference.
    title : title of the figure; None: the name of the system.

    Raises
    ------
    InputError : no branch, an unknown signal or value, missing extremes, different parameters.
    """
    from flexmb.pictures.figure import Picture

    drawn = [branches] if isinstance(branches, Branch) else list(branches)
    if not drawn or not all(isinstance(b, Branch) for b in drawn):
        raise InputError(f"plot_branch: branches is {branches!r}; it must be one or several results of follow().")
    if len({b.parameter for b in drawn}) > 1:
        text = ", ".join(dict.fromkeys(b.parameter for b in drawn))
        raise InputError(f"plot_branch: the branches have different parameters: {text}. Plot them one by one.")
    checks.one_of("plot_branch", "value", value, ("section", "max", "min", "amplitude"))
    figure = Picture(figsize=SIZE, layout="constrained")
    ax = figure.subplots()
    labelled: set[str] = set()
    for branch in drawn:
        _draw_branch(ax, branch, signal, value, labelled)
    first = drawn[0]
    units = first.period_units if signal == "period" else dict(zip(first.names, first.units, strict=True))[signal]
    ax.set_xlabel(first.parameter)
    ylabel = signal if value == "section" or signal == "period" else f"{value} of {signal}"
    label_axis(ax.yaxis, ylabel, units)
    grid(ax)
    ax.legend(loc="best", fontsize="small", framealpha=0.9)
    figure.suptitle(first.name if title is None else title)
    return figure


def _draw_branch(ax: Axes, branch: Branch, signal: str, value: str, labelled: set[str]) -> None:
    """Draw a branch by pieces of one stability; the legend names each kind once."""
    x = np.array([p.value for p in branch.points])
    y = _heights(branch, signal, value, branch.points)
    stable = np.array([p.stable for p in branch.points], dtype=bool)
    begin = 0
    for k in range(1, len(x) + 1):
        if k < len(x) and stable[k] == stable[begin]:
            continue
        end = min(k + 1, len(x))  # pieces touch one another
        name, colour, style = ("stable", STABLE, "-") if stable[begin] else ("unstable", UNSTABLE, "--")
        label = None if name in labelled else name
        ax.plot(x[begin:end], y[begin:end], style, color=colour, linewidth=1.5, label=label)
        labelled.add(name)
        begin = k
    heights = _heights(branch, signal, value, branch.events)
    for event, height in zip(branch.events, heights, strict=True):
        mark, colour, name = MARKS[event.kind]
        label = None if name in labelled else name
        ax.plot(event.value, height, mark, color=colour, markersize=8, zorder=3, label=label, linestyle="none")
        labelled.add(name)


def _heights(branch: Branch, signal: str, value: str, points: tuple[BranchPoint, ...]) -> np.ndarray:
    """Ordinates of the points."""
    if signal == "period":
        return np.array([p.period for p in points])
    column = branch.names.index(checks.one_of("plot_branch", "signal", signal, (*branch.names, "period")))
    if value == "section":
        return np.array([p.signals[column] for p in points])
    extremes = np.array([p.extremes[column] for p in points]).reshape(-1, 2)
    if len(points) and not np.isfinite(extremes).any():
        raise InputError(f"plot_branch: value is {value!r}, but extremes were not kept. Use follow(..., extremes=100).")
    low, high = extremes[:, 0], extremes[:, 1]
    heights = {"min": low, "max": high, "amplitude": 0.5 * (high - low)}
    return np.asarray(heights[value])


def plot_basin(basin: Basin, *, title: str | None = None) -> Figure:
    """Basins of attraction: the grid of start values, coloured by attractor, with the fraction of each attractor.

    Points of the attractors within the range of the grid are marked.

    Parameters
    ----------
    basin : result of `basin()`.
    title : title of the figure; None: the name of the system.

    Raises
    ------
    InputError : another kind of object.
    """
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    from flexmb.pictures.figure import Picture

    if not isinstance(basin, Basin):
        raise InputError(f"plot_basin: basin is {basin!r}; it must be the result of basin().")
    count = len(basin.attractors)
    colours = [LOST_COLOUR, OPEN_COLOUR, *(COLOURS[k % len(COLOURS)] for k in range(count))]
    figure = Picture(figsize=SIZE, layout="constrained")
    ax = figure.subplots()
    colour_map, top = ListedColormap(colours), count + 0.5
    ax.pcolormesh(basin.x, basin.y, basin.number, cmap=colour_map, vmin=-1.5, vmax=top, shading="nearest")
    (ax_name, ay_name), (ax_unit, ay_unit) = basin.axes, basin.units
    ax.set_xlim(*_edges(basin.x))
    ax.set_ylim(*_edges(basin.y))
    label_axis(ax.xaxis, ax_name, ax_unit)
    label_axis(ax.yaxis, ay_name, ay_unit)
    for k, points in enumerate(basin.attractors):
        x, y = points[:, basin.places[0]], points[:, basin.places[1]]
        ax.plot(x, y, "o", color=colours[k + 2], markeredgecolor="black", markersize=5, linestyle="none")
    names = {-1: "lost", 0: "undecided"} | {k + 1: _named(k + 1, n) for k, n in enumerate(basin.periods)}
    patches = [
        Patch(facecolor=colours[k + 1], label=f"{names[k]}: {100.0 * fraction:.1f} %")
        for k, fraction in basin.fractions.items()
    ]
    figure.legend(handles=patches, loc="outside right upper", frameon=False, fontsize="small")
    figure.suptitle(basin.name if title is None else title)
    return figure


def _edges(values: np.ndarray) -> tuple[float, float]:
    """Outer edges of the cells around the values of an axis."""
    low, high = float(values.min()), float(values.max())
    half = 0.5 * (high - low) / max(len(values) - 1, 1) or 0.5
    return low - half, high + half


def _named(number: int, period: int) -> str:
    return f"{number} (period {period})" if period else f"{number} (not periodic)"
