"""Diagrams of motions: bifurcation diagrams, branches of orbits, basins, portraits, sections, reports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import fill
from typing import Any

import numpy as np

from flexmb import arguments, checks
from flexmb.dynamics.basins import Basin
from flexmb.dynamics.exponents import Exponents
from flexmb.dynamics.orbits.periodic_orbit import BRANCH, FLIP, FOLD, GRAZING, NEIMARK_SACKER, Branch, BranchPoint
from flexmb.dynamics.report import ChaosReport, Motion, wrapped
from flexmb.errors import InputError
from flexmb.late import mpl, xr
from flexmb.model.part import Part, name_of
from flexmb.results.solution import Solution
from flexmb.show.pictures import style
from flexmb.show.pictures.signals import plot_spectrum

DIAGRAM_SIZE = (9.0, 5.2)  # [inch]
# Colours of the verdicts, in the order of the legend; readers with colour blindness can distinguish them.
VERDICT_COLOURS = {
    "periodic-1": "#0072b2", "periodic-2": "#56b4e9", "periodic-3": "#009e73", "periodic-4": "#6b8e23",
    "periodic-5 and more": "#b8860b", "quasi-periodic": "#e69f00", "chaotic": "#c0392b",
    "transient": "#cc79a7", "inconclusive": "0.55", "": "black",
}  # fmt: skip

MARKERS = {"up": "^", "down": "v", "cold": "o"}
MANY_POINTS = 4000  # number of points above which the markers are smallest


@arguments.checked
def plot_bifurcation(diagram: xr.Dataset, signal: str, *, title: str | None = None) -> mpl.figure.Figure:
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
    attributes = diagram.attrs if isinstance(diagram, xr.Dataset) else {}
    if attributes.get("kind") != "bifurcation":
        text = f"plot_bifurcation: the dataset is of kind {attributes.get('kind')!r}"
        raise InputError(f"{text}; give the result of fm.bifurcation.")
    parameter = diagram.attrs["parameter"]
    signals = [str(name) for name, pieces in diagram.data_vars.items() if pieces.dims[-2:] == (parameter, "period")]
    checks.one_of("plot_bifurcation", "signal", signal, signals)
    figure, ax = style.panel_of(DIAGRAM_SIZE)
    pieces: dict[tuple[str, str], list[Any]] = {}
    look: dict[str, Any]
    for direction, row in by_direction(diagram):
        values, points = row[parameter].values, row[signal].values
        for k in np.flatnonzero(row["ok"].values):
            key = (entry_of(str(row["verdict"].values[k])), direction)
            pieces.setdefault(key, []).append((np.full(points.shape[1], values[k]), points[k]))
        for value in values[row["seam"].values]:
            ax.axvline(value, color="0.75", linestyle=":", linewidth=1.0, zorder=0)
        failed = values[(row["status"].values != "") & ~row["ok"].values]
        look = {"color": "black", "transform": ax.get_xaxis_transform(), "clip_on": False}
        ax.plot(failed, np.full(len(failed), 0.015), "x", **look)
    count = sum(len(points) for listed in pieces.values() for _, points in listed)
    size = 4.0 if count < MANY_POINTS else 1.2
    for (verdict, name), listed in pieces.items():
        across, points = (np.concatenate(column) for column in zip(*listed, strict=True))
        look = {"color": VERDICT_COLOURS[verdict], "marker": MARKERS[name], "markersize": size, "markeredgewidth": 0.0}
        ax.plot(across, points, linestyle="none", rasterized=count > MANY_POINTS, **look)
    ax.set_title(diagram.attrs["name"] if title is None else title)
    ax.margins(x=0.02)
    style.label_axis(ax.xaxis, parameter, diagram[parameter].attrs.get("units", ""))
    style.label_axis(ax.yaxis, signal, diagram[signal].attrs.get("units", ""))
    _legend(ax, pieces)
    return figure


def by_direction(diagram: xr.Dataset) -> list[tuple[str, xr.Dataset]]:
    """The directions of the diagram, each with its dataset."""
    if "direction" not in diagram.dims:
        return [(diagram.attrs["direction"], diagram)]
    return [(str(name), diagram.isel(direction=k)) for k, name in enumerate(diagram["direction"].values)]


def entry_of(verdict: str) -> str:
    """Entry of the legend, a key of `VERDICT_COLOURS`, for a `verdict`."""
    if verdict in VERDICT_COLOURS:
        return verdict
    return "periodic-5 and more" if verdict.startswith("periodic-") else "inconclusive"


def default_signal(diagram: xr.Dataset) -> str:
    """Default signal of a picture: eccentricity of a joint with clearance, else the first variable signal."""
    names = [str(name) for name, column in diagram.data_vars.items() if column.dims[-1] == "period"]
    moving = [name for name in names if not name.endswith(".theta") and np.ptp(diagram[name].fillna(0.0).values) > 0.0]
    eccentric = [name for name in names if name.endswith(".ex")]
    return next(iter(eccentric + moving + names))


def _legend(ax: mpl.axes.Axes, pieces: dict[tuple[str, str], list[Any]]) -> None:
    """Draw the legend: colours of the verdicts, markers of two directions, crosses and dotted lines."""
    look: dict[str, Any] = {"linestyle": "none", "markersize": 6.0}
    verdicts = [name for name in VERDICT_COLOURS if name and any(name == verdict for verdict, _ in pieces)]
    line = mpl.lines.Line2D
    handles = [line([], [], color=VERDICT_COLOURS[name], marker="o", label=name, **look) for name in verdicts]
    directions = sorted({name for _, name in pieces}, reverse=True)
    if len(directions) > 1:
        handles += [line([], [], color="0.3", marker=MARKERS[name], label=name, **look) for name in directions]
    if any(np.size(one.get_xdata()) for one in ax.lines if one.get_marker() == "x"):
        handles.append(line([], [], color="black", marker="x", label="failed", **look))
    if any(one.get_linestyle() == ":" for one in ax.lines):
        handles.append(line([], [], color="0.75", linestyle=":", label="seam"))
    if handles:
        style.legend_beside(ax, handles=handles)


ORBITS_SIZE = (8.0, 5.0)  # of a figure [inch]
STABLE, UNSTABLE = style.COLOURS[0], style.COLOURS[1]

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
) -> mpl.figure.Figure:
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
    drawn = [branches] if isinstance(branches, Branch) else list(branches)
    if not drawn or not all(isinstance(b, Branch) for b in drawn):
        raise InputError(f"plot_branch: branches is {branches!r}; it must be one or several results of follow().")
    if len({b.parameter for b in drawn}) > 1:
        text = ", ".join(dict.fromkeys(b.parameter for b in drawn))
        raise InputError(f"plot_branch: the branches have different parameters: {text}. Plot them one by one.")
    checks.one_of("plot_branch", "value", value, ("section", "max", "min", "amplitude"))
    first = drawn[0]
    figure, ax = style.panel_of(ORBITS_SIZE, first.name if title is None else title)
    labelled: set[str] = set()
    for branch in drawn:
        _draw_branch(ax, branch, signal, value, labelled)
    units = first.period_units if signal == "period" else dict(zip(first.names, first.units, strict=True))[signal]
    ax.set_xlabel(first.parameter)
    style.label_axis(ax.yaxis, signal if value == "section" or signal == "period" else f"{value} of {signal}", units)
    ax.legend(loc="best", fontsize="small", framealpha=0.9)
    return figure


def _draw_branch(ax: mpl.axes.Axes, branch: Branch, signal: str, value: str, labelled: set[str]) -> None:
    """Draw a branch by pieces of one stability; the legend names each kind once."""
    x, y = np.array([p.value for p in branch.points]), _heights(branch, signal, value, branch.points)
    stable, begin = np.array([p.stable for p in branch.points], dtype=bool), 0
    for k in range(1, len(x) + 1):
        if k < len(x) and stable[k] == stable[begin]:
            continue
        end = min(k + 1, len(x))  # pieces touch one another
        name, colour, dashes = ("stable", STABLE, "-") if stable[begin] else ("unstable", UNSTABLE, "--")
        label = None if name in labelled else name
        ax.plot(x[begin:end], y[begin:end], dashes, color=colour, linewidth=1.5, label=label)
        labelled.add(name)
        begin = k
    for event, height in zip(branch.events, _heights(branch, signal, value, branch.events), strict=True):
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
    return np.asarray({"min": low, "max": high, "amplitude": 0.5 * (high - low)}[value])


def plot_basin(basin: Basin, *, title: str | None = None) -> mpl.figure.Figure:
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
    checks.instance("plot_basin", "basin", basin, Basin, "the result of basin()")
    count = len(basin.attractors)
    colours = [LOST_COLOUR, OPEN_COLOUR, *(style.COLOURS[k % len(style.COLOURS)] for k in range(count))]
    figure, ax = style.panel_of(ORBITS_SIZE, basin.name if title is None else title)
    ax.grid(visible=False)  # hidden by the cells
    colour_map, top = mpl.colors.ListedColormap(colours), count + 0.5
    ax.pcolormesh(basin.x, basin.y, basin.number, cmap=colour_map, vmin=-1.5, vmax=top, shading="nearest")
    ax.set_xlim(*_edges(basin.x))
    ax.set_ylim(*_edges(basin.y))
    for axis, name, unit in zip((ax.xaxis, ax.yaxis), basin.axes, basin.units, strict=True):
        style.label_axis(axis, name, unit)
    for k, points in enumerate(basin.attractors):
        x, y = points[:, basin.places[0]], points[:, basin.places[1]]
        ax.plot(x, y, "o", color=colours[k + 2], markeredgecolor="black", markersize=5, linestyle="none")
    names = {-1: "lost", 0: "undecided"}
    names |= {k: f"{k} (period {n})" if n else f"{k} (not periodic)" for k, n in enumerate(basin.periods, 1)}
    shares = {k: f"{names[k]}: {100.0 * fraction:.1f} %" for k, fraction in basin.fractions.items()}
    patches = [mpl.patches.Patch(facecolor=colours[k + 1], label=label) for k, label in shares.items()]
    figure.legend(handles=patches, loc="outside right upper", frameon=False, fontsize="small")
    return figure


def _edges(values: np.ndarray) -> tuple[float, float]:
    """Outer edges of the cells around the values of an axis."""
    low, high = float(values.min()), float(values.max())
    half = 0.5 * (high - low) / max(len(values) - 1, 1) or 0.5
    return low - half, high + half


PORTRAIT_SIZE = (7.0, 5.0)  # of a figure [inch]
MANY_DOTS = 2000  # number of points above which dots are small
ALONG = ("period", "crossing")  # dimensions of a dataset of section points


def plot_phase(
    motion: Solution | xr.Dataset, x: str, y: str, *, since: float | None = None, title: str | None = None
) -> mpl.figure.Figure:
    """Phase portrait: one signal over another, as a curve.

    Parameters
    ----------
    motion : a solution, or a dataset with signals over one dimension (`orbit.samples()`).
    x, y : names of the signals, e.g. "slider.x", "slider.vx".
    since : begin of the curve [s]; None: the begin of the motion.
    title : title of the figure; None: the name of the system.

    Raises
    ------
    InputError : an unknown signal, another kind of object, a time after the end of the motion.
    """
    data: Any = motion
    if isinstance(motion, Solution):
        columns = {name: ("time", motion.array(name), {"units": motion.units(name)}) for name in (x, y)}
        data = xr.Dataset(columns, {"time": ("time", motion.time, {"units": "s"})}, {"name": motion.name})
    checks.instance("plot_phase", "the motion", data, xr.Dataset, "a dataset of signals")
    values = [_signal("plot_phase", data, name) for name in (x, y)]
    if since is not None:
        begin = checks.number("plot_phase", "since", since, "s")
        late = data["time"].values >= begin if "time" in data.coords else np.ones(len(values[0]), dtype=bool)
        if not late.any():
            raise InputError(f"plot_phase: since is {begin:g} s, after the end of the motion. Give an earlier time.")
        values = [v[late] for v in values]
    figure, ax = _figure(data, title)
    ax.plot(*values, linewidth=0.9, color=style.COLOURS[0])
    _labels(ax, data, x, y)
    return figure


def plot_section(section: xr.Dataset, x: str, y: str | None = None, *, title: str | None = None) -> mpl.figure.Figure:
    """Section points: one signal over another, or over the number of the period.

    Parameters
    ----------
    section : result of `stroboscopic` or `section`.
    x : name of a signal.
    y : name of the signal on the ordinate; None: x over the number of the period or crossing.
    title : title of the figure; None: the name of the system.

    Raises
    ------
    InputError : an unknown signal, a dataset without the dimension "period" or "crossing".
    """
    data = checks.instance("plot_section", "the motion", section, xr.Dataset, "a dataset of signals")
    axis = next((name for name in ALONG if name in data.dims), None)
    if axis is None:
        dims = ", ".join(map(str, data.dims)) or "none"
        raise InputError(f"plot_section: section has the dimensions {dims}; it must have 'period' or 'crossing'.")
    figure, ax = _figure(data, title)
    size = 1.0 if data.sizes[axis] >= MANY_DOTS else 9.0
    if y is None:
        numbers = data[axis].values if axis in data.coords else np.arange(data.sizes[axis])
        ax.scatter(numbers, _signal("plot_section", data, x), s=size, color=style.COLOURS[0], linewidths=0)
        ax.set_xlabel(axis)
        style.label_axis(ax.yaxis, x, data[x].attrs.get("units", ""))
    else:
        across, up = (_signal("plot_section", data, name) for name in (x, y))
        ax.scatter(across, up, s=size, color=style.COLOURS[0], linewidths=0)
        _labels(ax, data, x, y)
    return figure


def plot_exponents(exponents: Exponents, *, title: str | None = None) -> mpl.figure.Figure:
    """Convergence of Lyapunov exponents over time, with the final values and their errors as bands.

    Parameters
    ----------
    exponents : result of `lyapunov` or `benettin`.
    title : title of the figure; None: the name of the system.

    Raises
    ------
    InputError : another kind of object, exponents without a history.
    """
    if not isinstance(exponents, Exponents):
        text = f"plot_exponents: exponents is {type(exponents).__name__}"
        raise InputError(f"{text}; it must be the result of lyapunov() or benettin().")
    history = np.asarray(exponents.history, dtype=np.float64)
    if history.ndim != 2 or len(history) == 0:
        text = f"plot_exponents: the history of {exponents.name!r} has shape {history.shape}"
        raise InputError(f"{text}; it must hold exponents over time. A run that failed at once has none.")
    figure, ax = style.panel_of(PORTRAIT_SIZE, exponents.name if title is None else title)
    for k, curve in enumerate(history.T):
        colour = style.COLOURS[k % len(style.COLOURS)]
        value, error = float(exponents.spectrum[k]), float(exponents.errors[k])
        label = f"{value:.4g} ± {error:.2g} {exponents.units}"
        ax.plot(exponents.time, curve, color=colour, linewidth=1.1, label=label)
        if np.isfinite(error):
            ax.axhspan(value - error, value + error, color=colour, alpha=0.2, linewidth=0)
    ax.axhline(0.0, color="black", linewidth=0.7)
    late = history[len(history) // 10 :]  # the first estimates are far off and would hide the rest
    late = late[np.isfinite(late)] if np.isfinite(late).any() else np.zeros(1)  # -inf: a direction is lost at once
    room = 0.1 * max(float(np.ptp(np.append(late, 0.0))), 1e-12)
    low, high = min(float(late.min()), 0.0), max(float(late.max()), 0.0)
    ax.set_ylim(low - room, high + room)
    per = exponents.units.partition("/")[2]
    style.label_axis(ax.xaxis, "time" if per == "s" else per, "s" if per == "s" else "")
    style.label_axis(ax.yaxis, "exponent", exponents.units)
    ax.legend(loc="best", fontsize="small", framealpha=0.9)
    return figure


def _signal(label: str, data: xr.Dataset, name: str) -> np.ndarray:
    checks.one_of(label, "signal", name, [str(key) for key in data.data_vars])
    return np.asarray(data[name].values)


def _figure(data: xr.Dataset, title: str | None) -> tuple[mpl.figure.Figure, mpl.axes.Axes]:
    return style.panel_of(PORTRAIT_SIZE, str(data.attrs.get("name", "")) if title is None else title)


def _labels(ax: mpl.axes.Axes, data: xr.Dataset, x: str, y: str) -> None:
    same = data[x].attrs.get("units", "") == data[y].attrs.get("units", "")
    style.label_axis(ax.xaxis, x, data[x].attrs.get("units", ""), equal=ax.yaxis if same else None)
    style.label_axis(ax.yaxis, y, data[y].attrs.get("units", ""), equal=ax.xaxis if same else None)


HARMONICS = 25.0  # largest frequency of a drawn spectrum, over the frequency of the section
# Spread of a section, over the spread of the motion, below which it is not enlarged; margin of the picture.
LEAST_SPREAD, MARGIN = 1e-3, 0.1
PORTRAIT = 20  # number of periods of a phase portrait


@arguments.checked
def plot_tornado(sensitivity: Any, signal: str, *, title: str | None = None) -> mpl.figure.Figure:
    """Relative derivatives of the measures of a signal by all parameters, the largest on top.

    Parameters
    ----------
    sensitivity : result of `fm.design.sensitivity`.
    signal : name of a signal of it, or of one of its measures.
    title : title of the figure; None: the name of the signal.

    Raises
    ------
    InputError : another kind of object, a signal without measures in it.
    """
    measures = getattr(sensitivity, "measures", None)
    if measures is None:
        text = f"plot_tornado: sensitivity is {type(sensitivity).__name__}"
        raise InputError(f"{text}; it must be the result of fm.design.sensitivity().")
    every = measures.measure.values.tolist()
    names = [name for name in every if name == signal or name.endswith(f" of {signal}")]
    if not names:
        raise InputError(f"plot_tornado: {signal!r} has no measures; there are {', '.join(every)}.")
    rows = np.asarray(measures["relative"].sel(measure=names).values, dtype=np.float64)
    order = np.argsort(np.nan_to_num(np.abs(rows)).max(axis=0))
    size = (3.0 * len(names) + 1.5, 0.5 * len(order) + 1.8)
    figure, axes = style.panels_of(size, signal if title is None else title, columns=len(names), sharey=True)
    for k, (name, ax) in enumerate(zip(names, axes, strict=True)):
        ax.barh(np.arange(len(order)), rows[k, order], height=0.6, color=style.COLOURS[k % len(style.COLOURS)])
        ax.axvline(0.0, color="black", linewidth=0.8)
        ax.set_title(name.removesuffix(f" of {signal}"))
        ax.set_xlabel("% by 1 % of the parameter")
    axes[0].set_yticks(np.arange(len(order)), [str(measures.parameter.values[k]) for k in order])
    return figure


def plot_report(report: ChaosReport) -> dict[str, mpl.figure.Figure]:
    """Pictures of a `report` of `chaos.report` by the names of their files, as `flexmb chaos` writes them.

    Section and phase portrait of each pair of signals, convergence of the exponents, and spectra, as far as there are
    data.

    Returns
    -------
    dict : figures by file name, such as "exponents.png"; `figure.savefig(name)` writes one.

    Raises
    ------
    InputError : another kind of object.
    """
    checks.instance("plot_report", "report", report, ChaosReport, "the result of chaos.report()")
    figures: dict[str, mpl.figure.Figure] = {}
    motion, name = report.motion, report.exponents.name
    number = report.skip + 1 + np.arange(len(motion.points))
    for x, y in report.planes if len(number) else ():
        title = f"{name}: once a period of {report.period:.4g} s"
        section = plot_section(_columns(motion, motion.points, "period", number), x, y, title=title)
        _widened(section, motion, x, y)
        figures["-".join(["section", x, *([y] if y else [])])] = section
        if y and len(motion.times):
            late = motion.times >= motion.times[-1] - PORTRAIT * report.period
            along = motion.times[late]
            title = f"{name}: the last {round((along[-1] - along[0]) / report.period)} periods"
            portrait = plot_phase(_columns(motion, motion.fine[late], "time", along), x, y, title=title)
            if x.endswith(".ex"):  # the journal moves in a circle
                portrait.axes[0].set_aspect("equal", adjustable="box")
            figures[f"phase-{x}-{y}"] = portrait
    if len(report.exponents.history) and np.isfinite(report.exponents.history).any():
        figures["exponents"] = plot_exponents(report.exponents)
    for f in report.signals:
        if f.spectrum is not None:
            stem, most = f.name.removeprefix("sin(").removesuffix(")"), HARMONICS / report.period
            figures[f"spectrum-{stem}"] = plot_spectrum(f.spectrum, signal=f.name, units=f.unit, up_to=most)
    return {f"{stem}.png": figure for stem, figure in figures.items()}


def _widened(figure: mpl.figure.Figure, motion: Motion, x: str, y: str | None) -> None:
    """Widen the axes around the points of a cycle, so that round-off is not enlarged."""
    ax = figure.axes[0]
    for name, limits in ((x, ax.set_xlim), (y, ax.set_ylim)) if y else ((x, ax.set_ylim),):
        place = motion.names.index(str(name))
        unit, points, fine = motion.units[place], motion.points[:, place], motion.fine[:, place]
        points = wrapped(unit, points)
        size = float(np.ptp(fine)) if len(fine) else float(np.abs(points).max())
        if size > 0.0 and np.ptp(points) < LEAST_SPREAD * size:
            middle = 0.5 * float(points.min() + points.max())
            limits(middle - MARGIN * size, middle + MARGIN * size)


def _columns(motion: Motion, values: np.ndarray, axis: str, along: np.ndarray) -> xr.Dataset:
    """Signals along an axis for a picture; a curve breaks where an angle passes -pi or pi."""
    data = {}
    for name, unit, column in zip(motion.names, motion.units, values.T, strict=True):
        values_shown = wrapped(unit, column).copy()
        if axis == "time" and unit == "rad":
            values_shown[1:][np.abs(np.diff(values_shown)) > np.pi] = np.nan
        data[name] = (axis, values_shown, {"units": unit})
    return xr.Dataset(data, {axis: (axis, along)})


WEAR_SIZE = (9.6, 5.0)  # [inch]
NOTE_WIDTH = 170  # of a note below a picture [characters]
DEEPEST = 0.45  # depth of the deepest place in a picture of wear, over the radius of the unworn surface


@arguments.checked
def plot_wear(life: xr.Dataset, joint: Part | str, *, title: str | None = None) -> mpl.figure.Figure:
    """Profiles of worn surfaces over the turns, magnified, and their deepest place and lost volume.

    Of a bearing or journal the dashed circle is the unworn surface; material is lost outwards from a bearing, inwards
    from a journal.  Angles count in the axes of the worn body.  Of a guide or slot both sides are drawn along it.
    Notes of the study on the joint stand below.

    Parameters
    ----------
    life : result of `wear_out`.
    joint : a joint that wears, or its name.
    title : title of the figure; None: names of mechanism and joint.

    Raises
    ------
    InputError : a dataset of another kind, an unknown joint.
    """
    attributes = life.attrs if isinstance(life, xr.Dataset) else {}
    if attributes.get("kind") != "wear":
        text = f"plot_wear: the dataset is of kind {attributes.get('kind')!r}"
        raise InputError(f"{text}; give the result of fm.wear_out.")
    name = checks.one_of("plot_wear", "joint", name_of(joint), list(np.atleast_1d(attributes["joints"])))
    rows = life.isel(turns=np.flatnonzero(life["ok"].values))
    own = (str(one) for one in rows)
    faces = [one.split(".")[1] for one in own if one.startswith(f"{name}.") and one.endswith("_profile")]
    profiles = {face.removesuffix("_profile"): rows[f"{name}.{face}"].values for face in faces}
    worn = {face: depths for face, depths in profiles.items() if depths.any()} or dict(list(profiles.items())[:1])
    turns, deepest = rows["turns"].values, np.max([depths.max(axis=1) for depths in worn.values()], axis=0)
    figure = style.new_figure(WEAR_SIZE)
    cells = figure.add_gridspec(2, 2)
    figure.suptitle(f"{attributes['name']}, {' and '.join(worn)} of {name}" if title is None else title)
    if f"{name}.worn_length" in attributes:
        along = rows["place"].values * attributes[f"{name}.worn_length"]
        _sides(figure, figure.add_subplot(cells[:, 0]), turns, along, profiles)
    else:
        _circles(figure, figure.add_subplot(cells[:, 0], projection="polar"), turns, worn)
    volume = rows[f"{name}.volume"].values
    for place, column, label, unit in ((0, deepest, "deepest place", "m"), (1, volume, "volume", "m3")):
        ax = figure.add_subplot(cells[place, 1])
        style.grid(ax)
        ax.plot(turns, column, color=style.COLOURS[0])
        style.label_axis(ax.xaxis, "turns", "")
        style.label_axis(ax.yaxis, label, unit)
    notes = [str(note) for note in np.atleast_1d(attributes.get("notes", [])) if str(note).startswith(f"{name}:")]
    if notes:
        figure.supxlabel("\n".join(fill(note, NOTE_WIDTH) for note in notes), fontsize="x-small")
    return figure


def _turns_bar(figure: mpl.figure.Figure, ax: Any, turns: np.ndarray) -> np.ndarray:
    """Colours of the turns (turns, 4), with their bar below."""
    colours = mpl.colormaps[style.SEQUENTIAL]
    shades = mpl.colors.Normalize(0.0, float(turns[-1]) if len(turns) and turns[-1] > 0.0 else 1.0)
    bar = figure.colorbar(mpl.cm.ScalarMappable(shades, colours), ax=ax, location="bottom", shrink=0.7, pad=0.09)
    bar.set_label("turns")
    return np.asarray(colours(shades(turns)))


def _sides(
    figure: mpl.figure.Figure, ax: Any, turns: np.ndarray, along: np.ndarray, profiles: Mapping[str, np.ndarray]
) -> None:
    """Profiles (turns, bins) [m] of the upper and the lower side along a guide, coloured by turns."""
    style.grid(ax)
    colours = _turns_bar(figure, ax, turns)
    style.label_axis(ax.xaxis, "place along the guide", "m")
    style.label_axis(ax.yaxis, "depth, of the lower side downwards", "m")
    for sign, depths in zip((1.0, -1.0), profiles.values(), strict=True):
        for colour, row in zip(colours, depths, strict=True):
            ax.plot(along, sign * row, color=colour, linewidth=1.0)


def _circles(figure: mpl.figure.Figure, ax: Any, turns: np.ndarray, profiles: Mapping[str, np.ndarray]) -> None:
    """Profiles (turns, bins) [m] around the unworn circle of the radius 1, of a journal inwards, coloured by turns."""
    largest = max(float(depths.max(initial=0.0)) for depths in profiles.values()) or 1.0
    bins, colours = next(iter(profiles.values())).shape[1], _turns_bar(figure, ax, turns)
    angle = 2.0 * np.pi * np.arange(bins + 1) / bins
    power, unit = style.prefixed("m", largest)
    tick, texts, depth = [], [], np.zeros(bins)
    for face, depths in profiles.items():
        scale = (-DEEPEST if face == "journal" else DEEPEST) / largest
        for colour, row in zip(colours, depths, strict=True):
            ax.plot(angle, 1.0 + scale * np.append(row, row[0]), color=colour, linewidth=1.0)
        depth = np.maximum(depth, depths.max(axis=0, initial=0.0))
        tick += [1.0 + scale * part * largest for part in (0.5, 1.0)]
        texts += [f"{part * largest * 10.0**-power:.3g} {unit}" for part in (0.5, 1.0)]
    ax.plot(angle, np.ones_like(angle), color="black", linestyle="--", linewidth=0.8)
    ax.set_rticks(tick, texts)
    free = min(range(8), key=lambda k: depth[int((k + 0.5) / 8 * bins)])
    ax.set_rlabel_position(45.0 * free + 22.5)
    ax.set_rlim(0.0, 1.0 + (DEEPEST + 0.05 if "bearing" in profiles else 0.1))
    ax.tick_params(labelsize="small")
