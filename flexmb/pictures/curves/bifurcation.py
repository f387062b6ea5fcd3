"""Bifurcation diagrams as matplotlib figures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import arguments, checks
from flexmb.errors import InputError
from flexmb.pictures.style import grid, label_axis

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZE = (9.0, 5.2)  # [inch]
COLOURS = {
    "periodic-1": "#0072b2",
    "periodic-2": "#56b4e9",
    "periodic-3": "#009e73",
    "periodic-4": "#6b8e23",
    "periodic-5 and more": "#b8860b",
    "quasi-periodic": "#e69f00",
    "chaotic": "#c0392b",
    "transient": "#cc79a7",
    "inconclusive": "0.55",
    "": "black",
}
"""Colours of the verdicts, in the order of the legend; readers with colour blindness can distinguish them."""

MARKERS = {"up": "^", "down": "v", "cold": "o"}
MANY = 4000
"""Number of points above which the markers are smallest."""


@arguments.checked
def plot_bifurcation(diagram: xr.Dataset, signal: str, *, title: str | None = None) -> Figure:
    """A bifurcation diagram: the points of a signal over the parameter.

    The colour shows the verdict on the motion, the marker the direction of the sweep.  Dotted lines are seams between
    chunks of a sweep, crosses on the lower edge failed points.  The figure needs no display; `fig.savefig(path)` writes
    it.

    Parameters
    ----------
    diagram : result of `bifurcation` or `load_sweep`.
    signal : name of a signal of the diagram.
    title : title of the figure; None: the name of the mechanism.

    Raises
    ------
    InputError : a dataset of another kind, an unknown signal.
    """
    import xarray

    from flexmb.pictures.figure import Picture

    attributes = diagram.attrs if isinstance(diagram, xarray.Dataset) else {}
    if attributes.get("kind") != "bifurcation":
        text = f"plot_bifurcation: the dataset is of kind {attributes.get('kind')!r}"
        raise InputError(f"{text}; give the result of fm.bifurcation.")
    parameter = diagram.attrs["parameter"]
    signals = [str(name) for name, pieces in diagram.data_vars.items() if pieces.dims[-2:] == (parameter, "period")]
    checks.one_of("plot_bifurcation", "signal", signal, signals)
    figure = Picture(figsize=SIZE, layout="constrained")
    ax = figure.subplots()
    pieces: dict[tuple[str, str], list[Any]] = {}
    for direction, row in _rows(diagram):
        _gather(pieces, row, parameter, signal, direction)
        _mark(ax, row, parameter)
    _draw(ax, pieces)
    ax.set_title(diagram.attrs["name"] if title is None else title)
    ax.margins(x=0.02)
    label_axis(ax.xaxis, parameter, diagram[parameter].attrs.get("units", ""))
    label_axis(ax.yaxis, signal, diagram[signal].attrs.get("units", ""))
    _legend(ax, pieces)
    return figure


def _rows(diagram: xr.Dataset) -> list[tuple[str, xr.Dataset]]:
    """The directions of the diagram, each with its dataset."""
    if "direction" not in diagram.dims:
        return [(diagram.attrs["direction"], diagram)]
    return [(str(name), diagram.isel(direction=k)) for k, name in enumerate(diagram["direction"].values)]


def entry_of(verdict: str) -> str:
    """Entry of the legend, a key of `COLOURS`, for a `verdict`."""
    if verdict in COLOURS:
        return verdict
    return "periodic-5 and more" if verdict.startswith("periodic-") else "inconclusive"


def default_signal(diagram: xr.Dataset) -> str:
    """Default signal of a picture: eccentricity of a joint with clearance, else the first variable signal."""
    names = [str(name) for name, column in diagram.data_vars.items() if column.dims[-1] == "period"]
    moving = [name for name in names if not name.endswith(".theta") and np.ptp(diagram[name].fillna(0.0).values) > 0.0]
    eccentric = [name for name in names if name.endswith(".ex")]
    return next(iter(eccentric + moving + names))


def _gather(pieces: dict[tuple[str, str], list[Any]], row: xr.Dataset, parameter: str, signal: str, name: str) -> None:
    """Add the section points of one direction to `pieces`, by verdict and direction."""
    values, points = row[parameter].values, row[signal].values
    for k in np.flatnonzero(row["ok"].values):
        key = (entry_of(str(row["verdict"].values[k])), name)
        pieces.setdefault(key, []).append((np.full(points.shape[1], values[k]), points[k]))


def _mark(ax: Axes, row: xr.Dataset, parameter: str) -> None:
    """Draw seams and failed points of a direction."""
    values = row[parameter].values
    for value in values[row["seam"].values]:
        ax.axvline(value, color="0.75", linestyle=":", linewidth=1.0, zorder=0)
    finished = row["status"].values != ""
    failed = values[finished & ~row["ok"].values]
    ax.plot(failed, np.full(len(failed), 0.015), "x", color="black", transform=ax.get_xaxis_transform(), clip_on=False)


def _draw(ax: Axes, pieces_of: dict[tuple[str, str], list[Any]]) -> None:
    count = sum(len(points) for listed in pieces_of.values() for _, points in listed)
    size = 4.0 if count < MANY else 1.2
    for (verdict, name), listed in pieces_of.items():
        across, points = (np.concatenate(column) for column in zip(*listed, strict=True))
        style: dict[str, Any] = {"color": COLOURS[verdict], "marker": MARKERS[name], "markersize": size}
        style["markeredgewidth"] = 0.0
        ax.plot(across, points, linestyle="none", rasterized=count > MANY, **style)
    grid(ax)


def _legend(ax: Axes, pieces: dict[tuple[str, str], list[Any]]) -> None:
    """Draw the legend: colours of the verdicts, markers of two directions, crosses and dotted lines."""
    from matplotlib.lines import Line2D

    style: dict[str, Any] = {"linestyle": "none", "markersize": 6.0}
    verdicts = [name for name in COLOURS if name and any(name == verdict for verdict, _ in pieces)]
    handles = [Line2D([], [], color=COLOURS[name], marker="o", label=name, **style) for name in verdicts]
    directions = sorted({name for _, name in pieces}, reverse=True)
    if len(directions) > 1:
        handles += [Line2D([], [], color="0.3", marker=MARKERS[name], label=name, **style) for name in directions]
    if any(np.size(line.get_xdata()) for line in ax.lines if line.get_marker() == "x"):
        handles.append(Line2D([], [], color="black", marker="x", label="failed", **style))
    if any(line.get_linestyle() == ":" for line in ax.lines):
        handles.append(Line2D([], [], color="0.75", linestyle=":", label="seam"))
    if handles:
        ax.legend(handles=handles, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize="small")
