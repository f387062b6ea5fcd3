"""Phase portraits, section points and the convergence of exponents, as matplotlib figures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexmb import checks
from flexmb.dynamics.exponents.exponents import Exponents
from flexmb.errors import InputError
from flexmb.pictures.style import COLOURS, grid, label_axis
from flexmb.results.solution import Solution

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZE = (7.0, 5.0)  # of a figure [inch]

MANY = 2000
"""Number of points above which dots are small."""

ALONG = ("period", "crossing")
"""Dimensions of a dataset of section points."""


def plot_phase(
    motion: Solution | xr.Dataset, x: str, y: str, *, since: float | None = None, title: str | None = None
) -> Figure:
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
    data = _signals(motion, (x, y)) if isinstance(motion, Solution) else _dataset("plot_phase", motion)
    values = [_signal("plot_phase", data, name) for name in (x, y)]
    if since is not None:
        begin = checks.number("plot_phase", "since", since, "s")
        late = data["time"].values >= begin if "time" in data.coords else np.ones(len(values[0]), dtype=bool)
        if not late.any():
            raise InputError(f"plot_phase: since is {begin:g} s, after the end of the motion. Give an earlier time.")
        values = [v[late] for v in values]
    figure, ax = _figure(data, title)
    ax.plot(*values, linewidth=0.9, color=COLOURS[0])
    _labels(ax, data, x, y)
    return figure


def _signals(sol: Solution, names: tuple[str, ...]) -> xr.Dataset:
    """Dataset of some signals of a solution."""
    import xarray as xr

    columns = {name: ("time", sol.array(name), {"units": sol.units(name)}) for name in names}
    return xr.Dataset(columns, {"time": ("time", sol.time, {"units": "s"})}, {"name": sol.name})


def plot_section(section: xr.Dataset, x: str, y: str | None = None, *, title: str | None = None) -> Figure:
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
    data = _dataset("plot_section", section)
    axis = next((name for name in ALONG if name in data.dims), None)
    if axis is None:
        dims = ", ".join(map(str, data.dims)) or "none"
        raise InputError(f"plot_section: section has the dimensions {dims}; it must have 'period' or 'crossing'.")
    figure, ax = _figure(data, title)
    size = 1.0 if data.sizes[axis] >= MANY else 9.0
    if y is None:
        numbers = data[axis].values if axis in data.coords else np.arange(data.sizes[axis])
        ax.scatter(numbers, _signal("plot_section", data, x), s=size, color=COLOURS[0], linewidths=0)
        ax.set_xlabel(axis)
        label_axis(ax.yaxis, x, data[x].attrs.get("units", ""))
    else:
        across, up = (_signal("plot_section", data, name) for name in (x, y))
        ax.scatter(across, up, s=size, color=COLOURS[0], linewidths=0)
        _labels(ax, data, x, y)
    return figure


def plot_exponents(exponents: Exponents, *, title: str | None = None) -> Figure:
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
    figure, ax = _named_figure(exponents.name if title is None else title)
    for k, curve in enumerate(history.T):
        colour = COLOURS[k % len(COLOURS)]
        value, error = float(exponents.spectrum[k]), float(exponents.errors[k])
        ax.plot(
            exponents.time, curve, color=colour, linewidth=1.1, label=f"{value:.4g} ± {error:.2g} {exponents.units}"
        )
        if np.isfinite(error):
            ax.axhspan(value - error, value + error, color=colour, alpha=0.2, linewidth=0)
    ax.axhline(0.0, color="black", linewidth=0.7)
    late = history[len(history) // 10 :]  # the first estimates are far off and would hide the rest
    late = late[np.isfinite(late)] if np.isfinite(late).any() else np.zeros(1)  # -inf: a direction is lost at once
    room = 0.1 * max(float(np.ptp(np.append(late, 0.0))), 1e-12)
    low, high = min(float(late.min()), 0.0), max(float(late.max()), 0.0)
    ax.set_ylim(low - room, high + room)
    per = exponents.units.partition("/")[2]
    label_axis(ax.xaxis, "time" if per == "s" else per, "s" if per == "s" else "")
    label_axis(ax.yaxis, "exponent", exponents.units)
    ax.legend(loc="best", fontsize="small", framealpha=0.9)
    return figure


def _dataset(label: str, given: xr.Dataset) -> xr.Dataset:
    import xarray as xr

    if not isinstance(given, xr.Dataset):
        raise InputError(f"{label}: the motion is {given!r}; it must be a dataset of signals.")
    return given


def _signal(label: str, data: xr.Dataset, name: str) -> np.ndarray:
    checks.one_of(label, "signal", name, [str(key) for key in data.data_vars])
    return np.asarray(data[name].values)


def _figure(data: xr.Dataset, title: str | None) -> tuple[Figure, Axes]:
    return _named_figure(str(data.attrs.get("name", "")) if title is None else title)


def _named_figure(title: str) -> tuple[Figure, Axes]:
    from flexmb.pictures.figure import Picture

    figure = Picture(figsize=SIZE, layout="constrained")
    ax = figure.subplots()
    grid(ax)
    if title:
        figure.suptitle(title)
    return figure, ax


def _labels(ax: Axes, data: xr.Dataset, x: str, y: str) -> None:
    same = data[x].attrs.get("units", "") == data[y].attrs.get("units", "")
    label_axis(ax.xaxis, x, data[x].attrs.get("units", ""), equal=ax.yaxis if same else None)
    label_axis(ax.yaxis, y, data[y].attrs.get("units", ""), equal=ax.xaxis if same else None)
