"""Signals as figures: over time, of several runs, spectra, natural frequencies, journals in their bearings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from flexmb import arguments, checks
from flexmb.dynamics.series.samples import PowerSpectrum
from flexmb.errors import InputError, SolveError
from flexmb.late import mpl
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Part, name_of
from flexmb.model.shape import PointShape
from flexmb.results.solution import Solution, require_rows, require_solution
from flexmb.show.pictures import style
from flexmb.statics.equilibrium import static_equilibrium
from flexmb.statics.modes import modes

# Envelopes of signals that swing too fast for single lines to be seen

COLUMNS = 400  # number of columns of an envelope
LEAST_SWING = 0.02  # least swing that counts, over the signal's range; smaller ones hide in the width of a line
DENSE = 0.5  # reversals of a signal in a column, in the busiest fifth, from which on it is drawn as an envelope


def is_dense(time: np.ndarray, values: np.ndarray, columns: int = COLUMNS) -> bool:
    """Whether a curve of a signal (n,) at instants (n,) [s] is a solid block, at least in a fifth of the picture."""
    if len(time) < columns or not time[-1] > time[0]:
        return False
    change = np.diff(values)
    turns = np.flatnonzero(change[1:] * change[:-1] < 0.0) + 1
    swings = np.abs(np.diff(values[turns]))
    large = turns[1:][swings > LEAST_SWING * float(np.ptp(values))]
    counts = np.bincount(_column(time, columns)[large], minlength=columns)
    return bool(np.sort(counts)[-columns // 5 :].mean() > DENSE)


def envelope(time: np.ndarray, values: np.ndarray, columns: int = COLUMNS) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Middles of the columns, and the least and the largest value in each."""
    # Every value lies in the band: the last value of a column also counts in the next one, as its line does. Columns
    # without values are left out. The signal (n,) belongs to increasing instants (n,) [s]; columns lie evenly over the
    # time.
    place = _column(time, columns)
    starts = np.flatnonzero(np.append(True, np.diff(place) > 0))
    low, high = np.fmin.reduceat(values, starts), np.fmax.reduceat(values, starts)
    before = values[starts[1:] - 1]
    low[1:], high[1:] = np.fmin(low[1:], before), np.fmax(high[1:], before)
    width = (time[-1] - time[0]) / columns
    return time[0] + (place[starts] + 0.5) * width, low, high


def _column(time: np.ndarray, columns: int) -> np.ndarray:
    """Number of the column of each instant."""
    place = np.floor((time - time[0]) / (time[-1] - time[0]) * columns).astype(int)
    return np.asarray(np.minimum(place, columns - 1))


def draw_signal(ax: mpl.axes.Axes, time: np.ndarray, values: np.ndarray, k: int, label: str, **more: Any) -> None:
    """Draw a signal over time: a line, or the band of its envelope where single lines would be a solid block."""
    # The signal (n,) belongs to instants (n,) [s]; its number k in the panel gives colour and line style. Further
    # keywords are those of matplotlib for a line.
    look = style.curve(k)
    if not is_dense(time, values):
        ax.plot(time, values, label=label, **{**look, **more})
        return
    middle, low, high = envelope(time, values)
    rim = {"edgecolor": look["color"], "linestyle": look["linestyle"], "linewidth": 0.6}
    ax.fill_between(middle, low, high, facecolor=mpl.colors.to_rgba(look["color"], 0.3), label=label, **rim)


WIDTH, PANEL, FRAME = 8.0, 1.9, 0.9  # of the figure, of one panel, of title and axis [inch]


@arguments.checked
def plot(
    sol: Solution, names: str | Sequence[str | Sequence[str]], *, title: str | None = None, x: str = "time"
) -> mpl.figure.Figure:
    """Signals in panels, one above the other.

    A signal that swings too fast for single lines to be seen is drawn as a band between its least and largest values;
    no peak is lost.  The curves of a panel differ in line style, too.  The figure needs no display;
    `fig.savefig(path)` writes it.

    Parameters
    ----------
    sol : the solution.
    names : one name, or one entry for each panel; the signals of an entry that is a list share a panel, e.g.
        ["slider.ax", ["B.fx", "B.fy"]].
    title : title of the figure; None: the name of the mechanism.
    x : "time" or the signal of the abscissa, e.g. x="B.ex" with "B.ey" for the orbit of a journal.

    Raises
    ------
    InputError : an unknown name, no name, signals of different units in one panel, a solution without saved instants.
    """
    require_rows("plot", sol, drawn=False)
    # Names of the signals by panel, checked
    entries = [names] if isinstance(names, str) else list(checks.sequence("plot", "names", names, "names of signals"))
    panels = [
        [entry] if isinstance(entry, str) else list(checks.sequence("plot", f"names[{k}]", entry, "names of signals"))
        for k, entry in enumerate(entries)
    ]
    if not panels or not all(panels):
        raise InputError("plot: names is empty; give at least one signal, e.g. plot(sol, ['slider.ax']).")
    for panel in panels:
        units = list(dict.fromkeys(sol.units(name) for name in panel))
        if len(units) > 1:
            text = f"plot: {', '.join(panel)} have different units, {' and '.join(map(repr, units))}."
            raise InputError(f"{text} Put them into different panels.")
    if x != "time":
        sol.array(x)  # an unknown name is refused before anything is drawn
    figure, axes = panels_of_time(len(panels), sol.name if title is None else title)
    for ax, panel in zip(axes, panels, strict=True):
        _draw(ax, sol, panel, x)
    style.label_axis(axes[-1].xaxis, x, "s" if x == "time" else sol.units(x))
    return figure


def _draw(ax: mpl.axes.Axes, sol: Solution, panel: list[str], x: str) -> None:
    across = sol.time if x == "time" else sol.array(x)
    for k, name in enumerate(panel):
        if x != "time":
            ax.plot(across, sol.array(name), label=name, **style.curve(k))
        elif name.endswith(".mode"):  # a mode jumps: a slanted line would show values that it never has
            ax.plot(across, sol.array(name), label=name, drawstyle="steps-post", **style.curve(k))
        else:
            draw_signal(ax, across, sol.array(name), k, name)
    style.label_axis(ax.yaxis, panel[0] if len(panel) == 1 else "", sol.units(panel[0]), between="\n")
    if len(panel) > 1:
        style.legend_beside(ax)
    if x == "time":
        if len(sol.time) > 1:
            ax.set_xlim(sol.time[0], sol.time[-1])
    elif sol.units(x) == sol.units(panel[0]):
        ax.set_aspect("equal", adjustable="datalim")  # the orbit of a journal in its bearing is a circle


STORED = ("energy.kinetic", "energy.strain", "energy.gravity")  # energies that the mechanism holds
TURNED_OVER = "energy.turned_over"  # scale of a balance, which is no part of it
RESIDUAL, GRAVITY = "energy.residual", "energy.gravity"


def plot_runs(
    runs: Mapping[str, Solution], names: str | Sequence[str], *, title: str | None = None
) -> mpl.figure.Figure:
    """Signals of several runs, a panel for each signal and a curve for each run.

    Parameters
    ----------
    runs : solutions by the text that names them in the legend, e.g. {"ideal": first, "worn": second}.
    names : names of signals that all runs have, in one unit.
    title : title of the figure; None: the name of the first mechanism.

    Raises
    ------
    InputError : no run, no name, a run without a signal, units that differ.
    """
    given = checks.mapping("plot_runs", "runs", runs)
    panels = [names] if isinstance(names, str) else list(names)
    if not given or not panels:
        raise InputError("plot_runs: runs or names are empty; give at least one of each.")
    for label, sol in given.items():
        if not isinstance(sol, Solution):
            raise InputError(f"plot_runs: runs[{label!r}] is {type(sol).__name__}; it must be a solution.")
        require_rows(f"plot_runs: runs[{label!r}]", sol, drawn=False)
    for name in panels:
        units = {sol.units(name) for sol in given.values()}
        if len(units) > 1:
            listed = " and ".join(repr(u) for u in sorted(units))
            raise InputError(f"plot_runs: {name!r} has different units in these runs, {listed}.")
    first = next(iter(given.values()))
    figure, axes = panels_of_time(len(panels), first.name if title is None else title)
    for ax, name in zip(axes, panels, strict=True):
        for k, (label, sol) in enumerate(given.items()):
            draw_signal(ax, sol.time, sol.array(name), k, str(label))
        style.label_axis(ax.yaxis, name, first.units(name), between="\n")
    style.legend_beside(axes[0])
    ends = [float(t) for sol in given.values() for t in (sol.time[0], sol.time[-1])]
    if max(ends) > min(ends):
        axes[0].set_xlim(min(ends), max(ends))
    style.label_axis(axes[-1].xaxis, "time", "s")
    return figure


def plot_energies(sol: Solution, *, title: str | None = None) -> mpl.figure.Figure:
    """Balance of energies: the stored energies, the works and losses, and the residual of the balance.

    The energy of gravity is drawn as its change since the first row.

    Parameters
    ----------
    sol : the solution.
    title : title of the figure; None: the name of the mechanism.

    Raises
    ------
    InputError : a run that did not save its energies.
    """
    require_solution("plot_energies", sol)
    saved = [name for name in sol.names if name.startswith("energy.") and name != TURNED_OVER]
    if not saved or not len(sol.time):
        text = "plot_energies: no energies were saved."
        raise InputError(f"{text} Add 'energy.*' to simulate(..., signals=[...]), or leave it out to save all.")
    works = [name for name in saved if name not in (*STORED, RESIDUAL) and abs(sol.array(name)).max() > 0.0]
    stored = [name for name in saved if name in STORED and abs(sol.array(name)).max() > 0.0]
    groups = [("stored energy", stored), ("works and losses", works)]
    groups += [("residual", [RESIDUAL])] if RESIDUAL in saved else []
    shown = [(text, names) for text, names in groups if names]
    figure, axes = panels_of_time(len(shown), sol.name if title is None else title)
    for ax, (text, names) in zip(axes, shown, strict=True):
        for k, name in enumerate(names):
            label, values = name.removeprefix("energy.").replace("_", " "), sol.array(name)
            if name == GRAVITY:  # its zero is at the origin, mostly far below the mechanism
                label, values = "gravity, from the start", values - values[0]
            draw_signal(ax, sol.time, values, k, label)
        style.label_axis(ax.yaxis, text, "J", between="\n")
        if len(names) > 1:
            style.legend_beside(ax)
    if sol.time[-1] > sol.time[0]:
        axes[0].set_xlim(sol.time[0], sol.time[-1])
    style.label_axis(axes[-1].xaxis, "time", "s")
    return figure


def panels_of_time(count: int, title: str) -> tuple[mpl.figure.Figure, Sequence[mpl.axes.Axes]]:
    """Figure with panels above one another that share the time."""
    figure, axes = style.panels_of((WIDTH, FRAME + PANEL * max(count, 2)), title, rows=count, sharex=True)
    figure.align_ylabels(axes)
    return figure, axes


def columns_of(fit: Any, name: str) -> np.ndarray:
    """Time, measured and computed signal, residual over its noise, (n, 4), with a row of NaN between two pieces."""
    left, computed, time = fit.residuals[name], fit.computed[name].values, fit.residuals["time"].values
    columns = np.column_stack([time, computed + left.values, computed, left.values / (left.attrs["noise"] or 1.0)])
    return np.insert(columns, np.searchsorted(time, fit.begins[1:]), np.nan, axis=0)


@arguments.checked
def plot_residuals(fit: Any, *, title: str | None = None) -> mpl.figure.Figure:
    """Measured points with the fitted curve of each signal, and the residuals over their noise below.

    A band shows twice the noise, which is that of the scatter if none was given.  Dotted lines begin the pieces of the
    record.

    Parameters
    ----------
    fit : result of `fm.design.fit`.
    title : title of the figure; None: the name of the mechanism.

    Raises
    ------
    InputError : another kind of object.
    """
    if getattr(getattr(fit, "residuals", None), "data_vars", None) is None:
        raise InputError(f"plot_residuals: fit is {type(fit).__name__}; it must be the result of fm.design.fit().")
    names = [str(name) for name in fit.residuals.data_vars]
    size, heights = (WIDTH, FRAME + 1.5 * PANEL * len(names)), [2.0, 1.0] * len(names)
    heading = fit.about["mechanism"] if title is None else title
    figure, axes = style.panels_of(size, heading, rows=len(heights), sharex=True, height_ratios=heights)
    for name, above, below in zip(names, axes[::2], axes[1::2], strict=True):
        time, measured, computed, left = columns_of(fit, name).T
        dots: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 5.0 if len(time) < COLUMNS else 3.0}
        above.plot(time, measured, color="0.6", label="measured", **dots)
        above.plot(time, computed, label="fitted", **style.curve(0))
        below.axhspan(-2.0, 2.0, color="0.9", zorder=0.5, label="twice the noise")
        below.axhline(0.0, color="0.4", linewidth=0.8)
        below.plot(time, left, color=style.COLOURS[0], **dots)
        for ax, begin in ((ax, begin) for ax in (above, below) for begin in fit.begins[1:]):
            ax.axvline(begin, color="0.4", linewidth=0.9, linestyle=":")
        style.label_axis(above.yaxis, name, fit.residuals[name].attrs["units"], between="\n")
        below.set_ylabel("residual\nover noise")
    for ax in axes[:2]:
        style.legend_beside(ax)
    figure.align_ylabels(axes)
    style.label_axis(axes[-1].xaxis, "time", "s")
    return figure


SPECTRUM_SIZE = (8.0, 4.5)  # [inch]
DEEP = 1e-14  # smallest density that is drawn, over the highest density; below are side lobes and round-off
ROOM = 100.0  # upper limit of the ordinate, over the highest density, with room for the legend
MARKED = 12  # largest number of marked lines, the strongest first


def plot_spectrum(
    spectrum: PowerSpectrum, *, signal: str = "", units: str = "", up_to: float | None = None, title: str | None = None
) -> mpl.figure.Figure:
    """Power spectrum of a signal with its floor and the strongest lines.

    Parameters
    ----------
    spectrum : result of `power_spectrum`.
    signal : name of the signal, for the title.
    units : unit of the signal.
    up_to : largest frequency to be drawn [unit of the spectrum]; None: all.
    title : title of the figure; None: the signal and the fraction of the power in lines.

    Raises
    ------
    InputError : another kind of object; no frequency up to the largest one.
    """
    checks.instance("plot_spectrum", "spectrum", spectrum, PowerSpectrum, "the result of power_spectrum()")
    inside = np.ones(len(spectrum.frequency), dtype=bool) if up_to is None else spectrum.frequency <= up_to
    if inside.sum() < 2:
        raise InputError(f"plot_spectrum: up_to is {up_to!r}; there are no frequencies below. Give a larger one.")
    frequency, density, floor = (x[inside] for x in (spectrum.frequency, spectrum.density, spectrum.floor))
    summary = f"{100.0 * spectrum.line_share:.3g} % of the power in lines: {spectrum.kind}"
    heading = f"{signal}, {summary}" if signal else summary
    figure, ax = style.panel_of(SPECTRUM_SIZE, heading if title is None else title)
    highest = float(density.max()) or 1.0
    ax.semilogy(frequency, np.maximum(density, DEEP * highest), color=style.COLOURS[0], linewidth=0.8, label="density")
    ax.semilogy(frequency, np.maximum(floor, DEEP * highest), color="black", linewidth=0.8, label="floor")
    lines = [f for f in spectrum.peaks[:MARKED] if f <= frequency[-1]]
    if lines:
        heights = density[np.searchsorted(frequency, lines)]
        look: dict[str, Any] = {"color": style.COLOURS[1], "markersize": 5, "linestyle": "none"}
        ax.semilogy(lines, heights, "v", label="strongest lines", **look)
    ax.set_xlim(frequency[0], frequency[-1])
    lowest = max(float(density[density > 0.0].min(initial=highest)), DEEP * highest)
    ax.set_ylim(0.3 * lowest, ROOM * highest)
    style.label_axis(ax.xaxis, "frequency", spectrum.units)
    squared = f"{units}^2" if units.isalpha() else f"({units})²" if units else "1"
    ax.set_ylabel(style.label_of("power density", squared + ("/Hz" if spectrum.units == "Hz" else " iteration")))
    ax.legend(loc="upper right", ncols=3, fontsize="small", framealpha=0.9)
    return figure


CAMPBELL_SIZE = (7.5, 5.0)  # of a figure [inch]


def plot_campbell(
    mechanism: Mechanism, speeds: Sequence[float] | np.ndarray, *, count: int = 4,
    orders: Sequence[float] = (1.0, 2.0, 3.0, 4.0), about: tuple[float, float] = (0.0, 0.0), damped: bool = False,
    title: str | None = None,
) -> mpl.figure.Figure:  # fmt: skip
    """Campbell diagram: natural frequencies over the speed of rotation, and the multiples of the speed.

    At each speed the mechanism is at rest in a frame that turns (`static_equilibrium(spin=...)`), and its modes are
    seen from that frame.  A resonance is possible where a frequency crosses a multiple of the speed.  Frequencies of
    unstable and overdamped motions are left out; curves join frequencies of equal rank.  They have a gap at a speed
    without an equilibrium, as an exactly critical one, and a cross on the lower edge marks it.

    Parameters
    ----------
    mechanism : the mechanism, whose drives turn at the speed or are clamps.
    speeds : speeds of rotation [rad/s], increasing, two at least.
    count : number of frequencies.
    orders : multiples of the speed that are drawn.
    about : centre of the rotation [m].
    damped : with the damping of material and dampers, see `modes`.
    title : title of the figure; None: the name of the mechanism.

    Raises
    ------
    InputError : fewer than two speeds, speeds that do not increase; see `static_equilibrium` and `modes`.
    SolveError : no speed has an equilibrium with modes; the error of the first one.
    """
    listed = checks.sequence("plot_campbell", "speeds", speeds, "speeds")
    given = [checks.number("plot_campbell", f"speeds[{k}]", w, "rad/s") for k, w in enumerate(listed)]
    if len(given) < 2 or np.any(np.diff(given) <= 0.0):
        raise InputError(f"plot_campbell: speeds are {given}; they must be two or more, increasing.")
    found, failed = _frequencies(mechanism, given, checks.count("plot_campbell", "count", count), about, damped)
    figure, ax = style.panel_of(CAMPBELL_SIZE, mechanism.name if title is None else title)
    for order in orders:
        line = order * np.array(given) / (2.0 * np.pi)
        ax.plot(given, line, color="0.6", linewidth=0.9, linestyle=(0, (4, 3)), zorder=1.5)
        beside: Any = {"xytext": (4, 0), "textcoords": "offset points", "va": "center", "fontsize": "small"}
        ax.annotate(f"{order:g}x", (given[-1], line[-1]), **beside)
    for k, frequency in enumerate(found.T):
        ax.plot(given, frequency, marker="o", markersize=3.0, label=f"mode {k + 1}", **style.curve(k))
    if failed:
        look: dict[str, Any] = {"color": "black", "clip_on": False, "transform": ax.get_xaxis_transform()}
        ax.plot(failed, np.full(len(failed), 0.015), "x", label="failed", **look)
    style.label_axis(ax.xaxis, "speed", "rad/s")
    style.label_axis(ax.yaxis, "natural frequency", "Hz")
    ax.set_xlim(given[0], given[-1])
    ax.set_ylim(0.0, 1.08 * float(np.nanmax(found)) if np.isfinite(found).any() else 1.0)
    figure.legend(loc="outside right upper", frameon=False, fontsize="small")
    return figure


def _frequencies(
    mechanism: Mechanism, speeds: list[float], count: int, about: tuple[float, float], damped: bool
) -> tuple[np.ndarray, list[float]]:
    """Lowest frequencies of elastic motions (speeds, count) [Hz], NaN where there are fewer; speeds that failed."""
    found, failed = np.full((len(speeds), count), np.nan), {}
    for row, speed in zip(found, speeds, strict=True):
        try:
            state = static_equilibrium(mechanism, spin=speed, about=about)
            every = modes(mechanism, count=2 * count, at=state, damped=damped)
        except SolveError as error:
            failed[speed] = error
            continue
        elastic = [f for f, kind in zip(every.frequencies, every.kinds, strict=True) if kind == "elastic"][:count]
        row[: len(elastic)] = elastic
    if len(failed) == len(speeds):
        raise failed[speeds[0]]
    return found, list(failed)


JOURNAL_SIZE = (5.6, 5.4)  # of a figure [inch]


def plot_journal(
    sol: Solution, joint: Part | str, *, clearance: float | None = None, since: float | None = None,
    title: str | None = None,
) -> mpl.figure.Figure:  # fmt: skip
    """Orbit of a journal: its centre relative to that of the bearing, and the circle of the clearance.

    Rows with contact are dots: beyond the circle by the penetration; in a film of oil, from the height of the roughness
    on.  The place of the thinnest film is marked.

    Parameters
    ----------
    sol : the solution.
    joint : a revolute joint with clearance, or its name.
    clearance : radius of the circle [m]; None: from the film, or the rows with contact, eccentricity less penetration.
    since : begin of the orbit [s]; None: the begin of the run.
    title : title of the figure; None: the name of the joint.

    Raises
    ------
    InputError : no such joint; no saved row with contact from which the clearance is known; a time after the end.
    """
    joint = name_of(joint)
    rows = _rows("plot_journal", sol, joint, since)
    ex, ey = (sol.array(f"{joint}.{axis}")[rows] for axis in ("ex", "ey"))
    depth = sol.array(f"{joint}.penetration")[rows]
    touching = depth > 0.0
    film = sol.array(f"{joint}.film_thickness")[rows] if f"{joint}.film_thickness" in sol else None
    if clearance is None and film is not None:
        radius = float(np.median(np.hypot(ex, ey) + film))
    elif clearance is None:
        if not touching.any():
            text = f"plot_journal: no saved row of {joint!r} has contact, so its clearance is unknown here."
            raise InputError(f"{text} Give clearance=..., in m.")
        radius = float(np.median(np.hypot(ex, ey)[touching] - depth[touching]))
    else:
        radius = checks.positive("plot_journal", "clearance", clearance, "m")
    figure, ax = style.panel_of(JOURNAL_SIZE, f"{sol.name}, journal of {joint}" if title is None else title)
    turn, label = np.linspace(0.0, 2.0 * np.pi, 361), f"clearance {radius:.3g} m"
    x, y = radius * np.cos(turn), radius * np.sin(turn)
    ax.plot(x, y, color=style.CLEARANCE, linewidth=1.4, linestyle="--", label=label)
    ax.plot(ex, ey, color=style.COLOURS[0], linewidth=0.7, label="orbit")
    ax.plot(ex[touching], ey[touching], ".", color="black", markersize=2.5, linestyle="none", label="contact")
    if film is not None:
        k = int(film.argmin())
        label = f"thinnest film {film[k]:.3g} m"
        ax.plot(ex[k], ey[k], "o", color=style.COLOURS[1], markersize=6.0, fillstyle="none", label=label)
    ax.set_aspect("equal", adjustable="datalim")
    style.label_axis(ax.xaxis, f"{joint}.ex", "m", equal=ax.yaxis)
    style.label_axis(ax.yaxis, f"{joint}.ey", "m", equal=ax.xaxis)
    figure.legend(loc="outside lower center", ncols=3, frameon=False, fontsize="small")
    return figure


def plot_contact_force(
    sol: Solution, joint: Part | str, *, since: float | None = None, title: str | None = None
) -> mpl.figure.Figure:
    """Normal force of a joint with clearance over the direction of the contact, in polar coordinates.

    The direction is that from the centre of the bearing to the journal, in world axes; 0 is to the right.  Dots are
    saved rows with contact.

    Parameters
    ----------
    sol : the solution.
    joint : a revolute joint with clearance, or its name.
    since : begin [s]; None: the begin of the run.
    title : title of the figure; None: the name of the joint.

    Raises
    ------
    InputError : no such joint, no saved row with contact, a time after the end.
    """
    joint = name_of(joint)
    rows = _rows("plot_contact_force", sol, joint, since)
    ex, ey, force = (sol.array(f"{joint}.{name}")[rows] for name in ("ex", "ey", "normal_force"))
    touching = force > 0.0
    if not touching.any():
        raise InputError(f"plot_contact_force: no saved row of {joint!r} has contact. Run longer, or save more rows.")
    figure = style.new_figure(JOURNAL_SIZE)
    ax, angle = figure.add_subplot(projection="polar"), np.arctan2(ey, ex)[touching]
    ax.vlines(angle, 0.0, force[touching], color=style.COLOURS[0], linewidth=0.5, alpha=0.35)
    ax.plot(angle, force[touching], ".", color=style.COLOURS[0], markersize=3.0, linestyle="none")
    ax.set_ylim(0.0, 1.05 * float(force.max()))
    ordered = np.sort(angle)  # the numbers stand in the widest gap
    gaps = np.diff(np.append(ordered, ordered[0] + 2.0 * np.pi))
    k = int(gaps.argmax())
    ax.set_rlabel_position(float(np.degrees(ordered[k] + 0.5 * gaps[k])))  # type: ignore[attr-defined]
    ax.grid(visible=True, color="0.9", linewidth=0.6)
    name = f"{sol.name}, normal force of {joint} [N] over the direction of the contact"
    figure.suptitle(name if title is None else title, fontsize="medium")
    return figure


DIRECTIONS = 720  # number of directions of a pressure around a bearing


def plot_pressure(
    sol: Solution, joint: Part | str, *, at: float | None = None, title: str | None = None
) -> mpl.figure.Figure:
    """Pressure of an oil film around its bearing, in the middle of the width, in polar coordinates.

    Directions are those from the centre of the bearing, in world axes; 0 is to the right.  The dashed line leads to the
    journal's centre: in a round bearing the film is thinnest there.

    Parameters
    ----------
    sol : the solution, with the signals of the joint and the motion of both bodies.
    joint : a journal bearing, or its name; the part itself where the solution does not know its mechanism.
    at : instant [s], of which the nearest saved row counts; None: that of the largest pressure.
    title : title of the figure; None: joint, instant, largest pressure and thinnest film.

    Raises
    ------
    InputError : no joint with a film, a solution that does not know its mechanism, a missing signal.
    """
    name = name_of(joint)
    _rows("plot_pressure", sol, name, None)
    part = sol.mechanism[name] if sol.mechanism is not None and not isinstance(joint, Part) else joint
    if not isinstance(part, Part) or part.oiled is None:
        text = f"plot_pressure: {name!r} is known as no joint with a film; give the JournalBearing itself"
        raise InputError(f"{text}, where the solution does not know its mechanism.")
    when = checks.number("plot_pressure", "at", at, "s") if at is not None else None
    k = int(sol.array(f"{name}.pressure").argmax() if when is None else np.abs(sol.time - when).argmin())
    directions = 2.0 * np.pi * np.arange(DIRECTIONS + 1) / DIRECTIONS
    # Place of the journal and its rate, angles and spins of bearing and journal, each (2,)
    shape = next(one for one in sol.shapes if isinstance(one, PointShape) and one.part == name)
    nodes = [(shape.body, shape.node), *([shape.other[:2]] if shape.other else [])]
    columns = [[f"{name}.{axis}" for axis in pair] for pair in (("ex", "ey"), ("vex", "vey"))]
    columns += [[".".join(filter(None, (*node, angle))) for node in nodes] for angle in ("theta", "omega")]
    (x, y), *motion = (
        np.array([0.0 if one.startswith("ground.") else float(sol.array(one)[k]) for one in pair]) for pair in columns
    )
    found = part.oiled.pressures(directions, np.array([x, y]), *motion)
    largest, thinnest = float(np.abs(found).max()), float(sol.array(f"{name}.film_thickness")[k])
    power, unit = style.prefixed("Pa", largest)
    figure = style.new_figure(JOURNAL_SIZE)
    ax = figure.add_subplot(projection="polar")
    ax.fill_between(directions, 0.0, found * 10.0**-power, color=style.COLOURS[0], alpha=0.25, linewidth=0.0)
    ax.plot(directions, found * 10.0**-power, color=style.COLOURS[0])
    top, towards = 1.05 * (largest or 1.0) * 10.0**-power, float(np.arctan2(y, x))
    label = "to the journal's centre"
    ax.plot([towards, towards], [0.0, top], color="black", linestyle="--", linewidth=0.8, label=label)
    ax.set_ylim(min(0.0, float(found.min()) * 10.0**-power), top)
    ax.set_rlabel_position(float(np.degrees(directions[found.argmax()])) + 180.0)  # type: ignore[attr-defined]
    ax.grid(visible=True, color="0.9", linewidth=0.6)
    figure.legend(loc="outside lower center", frameon=False, fontsize="small")
    told = f"pressure of the film of {name} [{unit}] at t = {sol.time[k]:.5g} s, thinnest film {thinnest:.3g} m"
    figure.suptitle(f"{sol.name}: {told}" if title is None else title, fontsize="small")
    return figure


def _rows(label: str, sol: Solution, joint: str, since: float | None) -> np.ndarray:
    """Rows from `since` on; a joint without journal is refused."""
    require_solution(label, sol)
    journals = [s.part for s in sol.shapes if isinstance(s, PointShape) and s.along is None and f"{s.part}.ex" in sol]
    checks.one_of(label, "joint", joint, journals)
    begin = -np.inf if since is None else checks.number(label, "since", since, "s")
    rows = np.flatnonzero(sol.time >= begin)
    if not len(rows):
        raise InputError(f"{label}: since is {begin:g} s, after the end of the motion. Give an earlier time.")
    return rows
