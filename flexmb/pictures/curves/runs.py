"""Signals of several runs over one another, and the balance of energies of one run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from flexmb import checks
from flexmb.errors import InputError
from flexmb.pictures.curves.envelope import draw_signal
from flexmb.pictures.curves.plot import FRAME, PANEL, WIDTH
from flexmb.pictures.style import grid, label_axis
from flexmb.results.solution import Solution

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STORED = ("energy.kinetic", "energy.strain", "energy.gravity")
"""Energies that the mechanism holds."""

TURNED_OVER = "energy.turned_over"
"""Scale of a balance, which is no part of it."""

RESIDUAL, GRAVITY = "energy.residual", "energy.gravity"


def plot_runs(runs: Mapping[str, Solution], names: str | Sequence[str], *, title: str | None = None) -> Figure:
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
        if not len(sol.time):
            raise InputError(f"plot_runs: runs[{label!r}] has no saved instants. Save some, e.g. save=1000.")
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
        label_axis(ax.yaxis, name, first.units(name), between="\n")
    axes[0].legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize="small")
    ends = [float(t) for sol in given.values() for t in (sol.time[0], sol.time[-1])]
    if max(ends) > min(ends):
        axes[0].set_xlim(min(ends), max(ends))
    label_axis(axes[-1].xaxis, "time", "s")
    return figure


def plot_energies(sol: Solution, *, title: str | None = None) -> Figure:
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
        label_axis(ax.yaxis, text, "J", between="\n")
        if len(names) > 1:
            ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize="small")
    if sol.time[-1] > sol.time[0]:
        axes[0].set_xlim(sol.time[0], sol.time[-1])
    label_axis(axes[-1].xaxis, "time", "s")
    return figure


def panels_of_time(count: int, title: str) -> tuple[Figure, Sequence[Axes]]:
    """Figure with panels above one another that share the time."""
    from flexmb.pictures.figure import Picture

    figure = Picture(figsize=(WIDTH, FRAME + PANEL * max(count, 2)), layout="constrained")
    axes = list(figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0])
    for ax in axes:
        grid(ax)
    figure.align_ylabels(axes)
    figure.suptitle(title)
    return figure, axes
