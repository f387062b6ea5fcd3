"""Signals over time or over one another, as a matplotlib figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from flexmb import arguments, checks
from flexmb.errors import InputError
from flexmb.pictures.curves.envelope import draw_signal
from flexmb.pictures.style import curve, grid, label_axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from flexmb.results.solution import Solution

WIDTH, PANEL, FRAME = 8.0, 1.9, 0.9  # of the figure, of one panel, of title and axis [inch]


@arguments.checked
def plot(
    sol: Solution, names: str | Sequence[str | Sequence[str]], *, title: str | None = None, x: str = "time"
) -> Figure:
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
    from flexmb.pictures.figure import Picture

    panels = _panels(sol, names)
    if not len(sol.time):
        raise InputError("plot: the solution has no saved instants. Save some, e.g. by simulate(..., save=...).")
    if x != "time":
        sol.array(x)  # an unknown name is refused before anything is drawn
    figure = Picture(figsize=(WIDTH, FRAME + PANEL * max(len(panels), 2)), layout="constrained")
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for ax, panel in zip(axes, panels, strict=True):
        _draw(ax, sol, panel, x)
    label_axis(axes[-1].xaxis, x, "s" if x == "time" else sol.units(x))
    figure.align_ylabels(axes)
    figure.suptitle(sol.name if title is None else title)
    return figure


def _panels(sol: Solution, names: str | Sequence[str | Sequence[str]]) -> list[list[str]]:
    """Names of the signals by panel, checked."""
    entries = [names] if isinstance(names, str) else list(checks.sequence("plot", "names", names, "names of signals"))
    panels = [[entry] if isinstance(entry, str) else list(entry) for entry in entries]
    if not panels or not all(panels):
        raise InputError("plot: names is empty; give at least one signal, e.g. plot(sol, ['slider.ax']).")
    for panel in panels:
        units = list(dict.fromkeys(sol.units(name) for name in panel))
        if len(units) > 1:
            listed = " and ".join(repr(u) for u in units)
            text = f"plot: {', '.join(panel)} have different units, {listed}."
            raise InputError(f"{text} Put them into different panels.")
    return panels


def _draw(ax: Axes, sol: Solution, panel: list[str], x: str) -> None:
    across = sol.time if x == "time" else sol.array(x)
    for k, name in enumerate(panel):
        if x != "time":
            ax.plot(across, sol.array(name), label=name, **curve(k))
        elif name.endswith(".mode"):  # a mode jumps: a slanted line would show values that it never has
            ax.plot(across, sol.array(name), label=name, drawstyle="steps-post", **curve(k))
        else:
            draw_signal(ax, across, sol.array(name), k, name)
    label_axis(ax.yaxis, panel[0] if len(panel) == 1 else "", sol.units(panel[0]), between="\n")
    grid(ax)
    if len(panel) > 1:
        # beside the panel: inside it would hide some part of the curves
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize="small")
    if x == "time":
        if len(sol.time) > 1:
            ax.set_xlim(sol.time[0], sol.time[-1])
    elif sol.units(x) == sol.units(panel[0]):
        ax.set_aspect("equal", adjustable="datalim")  # the orbit of a journal in its bearing is a circle
