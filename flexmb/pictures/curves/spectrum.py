"""The power spectrum of a signal as a matplotlib figure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexmb.errors import InputError
from flexmb.pictures.style import COLOURS, grid, label_axis, label_of
from flexmb.series.spectrum import PowerSpectrum

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZE = (8.0, 4.5)  # [inch]

DEEP = 1e-14
"""Smallest density that is drawn, over the highest density; below are side lobes and round-off."""

ROOM = 100.0
"""Upper limit of the ordinate, over the highest density, with room for the legend."""

MARKED = 12
"""Largest number of marked lines, the strongest first."""


def plot_spectrum(
    spectrum: PowerSpectrum, *, signal: str = "", units: str = "", up_to: float | None = None, title: str | None = None
) -> Figure:
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
    from flexmb.pictures.figure import Picture

    if not isinstance(spectrum, PowerSpectrum):
        raise InputError(f"plot_spectrum: spectrum is {spectrum!r}; it must be the result of power_spectrum().")
    inside = np.ones(len(spectrum.frequency), dtype=bool) if up_to is None else spectrum.frequency <= up_to
    if inside.sum() < 2:
        raise InputError(f"plot_spectrum: up_to is {up_to!r}; there are no frequencies below. Give a larger one.")
    frequency, density, floor = (x[inside] for x in (spectrum.frequency, spectrum.density, spectrum.floor))
    figure = Picture(figsize=SIZE, layout="constrained")
    ax = figure.subplots()
    highest = float(density.max()) or 1.0
    ax.semilogy(frequency, np.maximum(density, DEEP * highest), color=COLOURS[0], linewidth=0.8, label="density")
    ax.semilogy(frequency, np.maximum(floor, DEEP * highest), color="black", linewidth=0.8, label="floor")
    lines = [f for f in spectrum.peaks[:MARKED] if f <= frequency[-1]]
    if lines:
        heights = density[np.searchsorted(frequency, lines)]
        ax.semilogy(lines, heights, "v", color=COLOURS[1], markersize=5, linestyle="none", label="strongest lines")
    ax.set_xlim(frequency[0], frequency[-1])
    lowest = max(float(density[density > 0.0].min(initial=highest)), DEEP * highest)
    ax.set_ylim(0.3 * lowest, ROOM * highest)
    grid(ax)
    label_axis(ax.xaxis, "frequency", spectrum.units)
    squared = f"{units}^2" if units.isalpha() else f"({units})$^{{2}}$" if units else "1"
    per = "/Hz" if spectrum.units == "Hz" else " iteration"
    ax.set_ylabel(label_of("power density", f"{squared}{per}"))
    ax.legend(loc="upper right", ncols=3, fontsize="small", framealpha=0.9)
    summary = f"{100.0 * spectrum.line_share:.3g} % of the power in lines: {spectrum.kind}"
    figure.suptitle((f"{signal}, {summary}" if signal else summary) if title is None else title)
    return figure
