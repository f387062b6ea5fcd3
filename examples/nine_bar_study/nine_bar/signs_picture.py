"""Picture of the page "exponents": growth of distances and estimates of both signs; not in the paper."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from nine_bar_study.drawing import Shown, length_text, noted, sheet
from nine_bar_study.nine_bar.cases import MACHINE
from nine_bar_study.nine_bar.signs import EDGES, FOLLOWED, ByDistance, by_distance
from nine_bar_study.run import Results, StudyRun
from nine_bar_study.samples import by_period, cloud, growth_rates

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

COLOURS = {"P1.ex": "#0072b2", "P1.ey": "#56b4e9", "slider.x": "#d55e00"}
BESIDE = ("P1.ex", "slider.x")
"""Observables of the panel on distances of two runs."""

PANEL = (5.6, 4.0)
"""Width and height of a panel [inch]."""


def draw(run: StudyRun, results: Results) -> tuple[Figure, xr.Dataset]:
    """Picture of the distances of two runs, the growth of the tangent vector, and growth rates over the distance."""
    import xarray

    result = results[run]
    figure, axes = sheet(f"One motion, one exponent: {run.case.name}", 2, 2, panel=PANEL)
    shown: Shown = {}
    _apart(axes[0, 0], shown, result)
    _growth(axes[0, 1], shown, result)
    raw, _, joint, _ = tables = by_distance(result)
    _rates(axes[1, 0], shown, (raw, joint), "slider.x and P1.ex as they are")
    _rates(axes[1, 1], shown, (tables[1], tables[3]), "the same less their periodic parts")
    shown["distance"] = noted(np.sqrt(EDGES[1:] * EDGES[:-1]), "distance", "m", "distance of neighbours")
    shown["followed"] = noted(FOLLOWED, "followed", "1", "time for which they are followed, in periods")
    return figure, xarray.Dataset(shown, attrs={"case": run.case.name})


def _apart(ax: Any, shown: Shown, result: xr.Dataset) -> None:
    """Draw the distances of two runs with the initial distance 1e-9 m in both observables, of the median pair."""
    lags, state = result["lag"].values, result["apart.state"].values
    typical = int(np.argsort(np.log(np.maximum(state, 1e-300)).mean(axis=1))[len(state) // 2])
    sizes = {name: float(np.sqrt(2.0) * cloud(by_period(result, name))) for name in BESIDE}
    for name, size in sizes.items():
        values = np.maximum(result[f"apart.{name}"].values[typical], 1e-16)
        logs = result[f"growth.{name}"].values[typical]
        ahead = logs - result["growth.state"].values[typical, 0] + np.log(state[typical, 0])
        ax.semilogy(lags, values, color=COLOURS[name], lw=1.2, label=f"{name}: two runs")
        ax.semilogy(lags, np.exp(ahead), color=COLOURS[name], lw=0.8, ls=":", label=f"{name}: if it stayed small")
        side = "bottom" if size == max(sizes.values()) else "top"
        ax.axhline(size, color=COLOURS[name], ls="--", lw=0.8)
        ax.annotate(f"its cloud: {length_text(size)}", (0.0, size), color=COLOURS[name], va=side, fontsize="small")
        shown[f"apart.{name}"] = noted(values, "lag", "m", f"distance of two runs, {name}")
        shown[f"small.{name}"] = noted(np.exp(ahead), "lag", "m", f"distance if it stayed small, {name}")
        shown[f"cloud.{name}"] = noted(size, (), "m", f"distance from the periodic part, root mean square, {name}")
    shown["lag"] = noted(lags, "lag", "s", "time since the start of the second run")
    ax.set_ylim(1e-15, 1.0)
    ax.set(xlabel="time since the start of the second run [s]", ylabel="distance of two runs [m]")
    ax.set_title("two runs, at first 1e-9 m apart", fontsize="medium", loc="left")
    ax.legend(fontsize="small", loc="lower right")


def _growth(ax: Any, shown: Shown, result: xr.Dataset) -> None:
    """Draw the logarithms of the tangent vector over time; their slope is the largest exponent."""
    times = (result["pair.time"].values - float(result["pair.time"][0]))[:, None] + result["lag"].values
    rates = growth_rates(result)
    for name in MACHINE.places:
        logs = result[f"growth.{name}"].values
        rise = (logs - float(result["growth.state"][0, 0])).ravel()
        ax.plot(times.ravel(), rise, color=COLOURS[name], lw=0.8, label=f"{name}: {rates[name][0]:.4g} 1/s")
        shown[f"growth.{name}"] = noted(rise, "instant", "1", f"ln of a small difference, {name}")
    shown["time"] = noted(times.ravel(), "instant", "s", "time")
    value, error = float(result["exponent"]), float(result["exponent_error"])
    ends = np.array([0.0, times[-1, -1]])
    text = f"exponent of the system: {value:.4g} ± {error:.1g} 1/s"
    ax.plot(ends, value * ends, color="black", ls="--", lw=1.0, label=text)
    ax.fill_between(ends, (value - error) * ends, (value + error) * ends, color="0.5", alpha=0.3, lw=0)
    ax.set(xlabel="time [s]", ylabel="ln of a small difference")
    ax.set_title("what an infinitesimal difference does to each observable", fontsize="medium", loc="left")
    ax.legend(fontsize="small", loc="best")


def _rates(ax: Any, shown: Shown, tables: tuple[ByDistance, ByDistance], title: str) -> None:
    """Draw the growth rates over the distance of neighbours, of slider and journal."""
    middles = np.sqrt(EDGES[1:] * EDGES[:-1])
    ax.axhline(0.0, color="0.5", linewidth=0.9)
    for table, colour in zip(tables, (COLOURS["slider.x"], COLOURS["P1.ex"]), strict=True):
        name = table.signal.split()[0]
        for row, (part, style) in enumerate(zip(FOLLOWED, ("o-", "s:"), strict=True)):
            label = f"{name}, followed {part:g} periods"
            ax.semilogx(middles, table.rates[row], style, color=colour, ms=3.5, lw=1.1, label=label)
        ax.axvline(table.cloud, color=colour, ls="--", lw=0.8)
        text = {"units": "1/s", "long_name": f"rate at which neighbours part, {table.signal}"}
        shown[f"rate.{table.signal}"] = (("followed", "distance"), table.rates, text)
    ax.set(xlabel="distance of neighbours [m]; dashed: the cloud", ylabel="rate at which they part [1/s]")
    ax.set_title(title, fontsize="medium", loc="left")
    ax.legend(fontsize="small", loc="upper right")
