"""Pictures of a report on a motion: sections, phase portraits, convergence of the exponents, spectra."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexmb import arguments
from flexmb.dynamics.report import ChaosReport, Motion, wrapped
from flexmb.errors import InputError
from flexmb.show.pictures.diagrams import plot_exponents, plot_phase, plot_section
from flexmb.show.pictures.signals import plot_spectrum

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

HARMONICS = 25.0
"""Largest frequency of a drawn spectrum, over the frequency of the section."""

LEAST_SPREAD, ROOM = 1e-3, 0.1
"""Spread of a section, over the spread of the motion, below which it is not enlarged; margin of the picture."""

PORTRAIT = 20
"""Number of periods of a phase portrait."""


@arguments.checked
def plot_report(report: ChaosReport) -> dict[str, Figure]:
    """Pictures of a report on a motion by the names of their files, as `flexmb chaos` writes them.

    Section and phase portrait of each pair of signals, convergence of the exponents, and spectra, as far as there are
    data.

    Parameters
    ----------
    report : result of `chaos.report`.

    Returns
    -------
    dict : figures by file name, such as "exponents.png"; `figure.savefig(name)` writes one.

    Raises
    ------
    InputError : another kind of object.
    """
    if not isinstance(report, ChaosReport):
        raise InputError(f"plot_report: report is {report!r}; it must be the result of chaos.report().")
    figures: dict[str, Figure] = {}
    motion, name = report.motion, report.exponents.name
    number = report.skip + 1 + np.arange(len(motion.points))
    for x, y in report.planes if len(number) else ():
        title = f"{name}: once a period of {report.period:.4g} s"
        section = plot_section(_columns(motion, motion.points, "period", number), x, y, title=title)
        _widened(section, motion, x, y)
        figures["-".join(["section", x, *([y] if y else [])])] = section
        if y and len(motion.times):
            figures[f"phase-{x}-{y}"] = _portrait(report, x, y)
    if len(report.exponents.history) and np.isfinite(report.exponents.history).any():
        figures["exponents"] = plot_exponents(report.exponents)
    for f in report.signals:
        if f.spectrum is not None:
            figures[f"spectrum-{f.name.removeprefix('sin(').removesuffix(')')}"] = plot_spectrum(
                f.spectrum, signal=f.name, units=f.unit, up_to=HARMONICS / report.period
            )
    return {f"{stem}.png": figure for stem, figure in figures.items()}


def _portrait(report: ChaosReport, x: str, y: str) -> Figure:
    """Phase portrait of the last periods of the motion."""
    motion = report.motion
    late = motion.times >= motion.times[-1] - PORTRAIT * report.period
    number = round((motion.times[late][-1] - motion.times[late][0]) / report.period)
    title = f"{report.exponents.name}: the last {number} periods"
    figure = plot_phase(_columns(motion, motion.fine[late], "time", motion.times[late]), x, y, title=title)
    if x.endswith(".ex"):  # the journal moves in a circle
        figure.axes[0].set_aspect("equal", adjustable="box")
    return figure


def _widened(figure: Figure, motion: Motion, x: str, y: str | None) -> None:
    """Widen the axes around the points of a cycle, so that round-off is not enlarged."""
    ax = figure.axes[0]
    for name, limits in ((x, ax.set_xlim), (y, ax.set_ylim)) if y else ((x, ax.set_ylim),):
        place = motion.names.index(str(name))
        unit, points, fine = motion.units[place], motion.points[:, place], motion.fine[:, place]
        points = wrapped(unit, points)
        size = float(np.ptp(fine)) if len(fine) else float(np.abs(points).max())
        if size > 0.0 and np.ptp(points) < LEAST_SPREAD * size:
            middle = 0.5 * float(points.min() + points.max())
            limits(middle - ROOM * size, middle + ROOM * size)


def _columns(motion: Motion, values: np.ndarray, axis: str, along: np.ndarray) -> xr.Dataset:
    """Signals along an axis for a picture; a curve breaks where an angle passes -pi or pi."""
    import xarray as xr

    data = {}
    for name, unit, column in zip(motion.names, motion.units, values.T, strict=True):
        values_shown = wrapped(unit, column).copy()
        if axis == "time" and unit == "rad":
            values_shown[1:][np.abs(np.diff(values_shown)) > np.pi] = np.nan
        data[name] = (axis, values_shown, {"units": unit})
    return xr.Dataset(data, {axis: (axis, along)})
