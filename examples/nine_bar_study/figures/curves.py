"""Kinds "comparison" and "laws" of figures: curves of a signal over the saved turns."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from nine_bar_study.case import MODELS, Case
from nine_bar_study.drawing import COLOURS, Quantity, Shown, caption, draw_curve, sheet
from nine_bar_study.effort import Effort
from nine_bar_study.figures.contrast import Contrast, time_of
from nine_bar_study.item import StudyFigure, once
from nine_bar_study.run import Results, StudyRun

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LINES: dict[str, dict[str, Any]] = {
    "flexible": {"linewidth": 0.5, "alpha": 0.75},
    "rigid": {"linewidth": 0.5, "alpha": 0.85},
    "ideal": {"linewidth": 1.1},
}
"""Styles of the models in the order of drawing: vibrations of flexible links lie below the impacts of rigid links."""

HEAD = 0.3
"""Height of the legend above the curves, over the height of the curves."""

DWARFED = 10.0
"""Ratio of the largest peak to the ideal peak above which the ideal curve has a panel of its own scale."""

ROOM = 1.6
"""Height of the panel on the scale of the ideal mechanism, over the height of the ideal curve."""

WIDTHS = {"flexible": 1.6, "rigid": 0.7}
"""Line widths of deviations; both curves remain visible where they coincide."""

CLOSE_UP = 0.05
"""Half width of the close-up of the highest peak, over the period."""

LAW_COLOURS = (COLOURS["rigid"], "#8e44ad")


def comparison(
    number: int,
    effort: Effort,
    contrast: Contrast,
    signal: str,
    deviation: Quantity | None = None,
    models: tuple[str, ...] = MODELS,
) -> StudyFigure:
    """Figure of a signal of several models, and of the deviation from the ideal mechanism below.

    The lower panel shows the signal on the scale of the ideal curve if peaks exceed 10 ideal peaks.  Figures of the
    penetration have no lower panel, since the ideal mechanism has no penetration.

    Parameters
    ----------
    number : number of the figure.
    effort : lengths of the runs.
    contrast : cases of the columns.
    signal : name of the signal.
    deviation : name and unit of the deviation; None: unit of the signal, with the largest values in the legend.
    models : compared models.
    """
    machine = contrast.cases[0].machine
    models = tuple(model for model in models if model != "ideal" or not _is_penetration(signal))
    columns = contrast.columns(effort, models)
    runs = once([run for _, _, by_model in columns for run in by_model.values()])
    title = f"{machine.quantities[signal].title}, {contrast.where}"
    draw = partial(_compared, f"Figure {number}: {title}", columns, signal, machine.quantities[signal], deviation)
    return StudyFigure(number, title, runs, draw)


def _is_penetration(signal: str) -> bool:
    return signal.endswith(".penetration")


def _compared(
    heading: str,
    columns: list[tuple[str, str, dict[str, StudyRun]]],
    signal: str,
    quantity: Quantity,
    deviation: Quantity | None,
    results: Results,
) -> tuple[Figure, xr.Dataset]:
    import xarray

    below, shown = not _is_penetration(signal), dict[str, Any]()
    panel = (6.2, 3.3 if below else 4.2)
    figure, axes = sheet(heading, 1 + below, len(columns), panel=panel, sharex="col")
    for axis, (letter, text, runs) in zip(axes.T, columns, strict=True):
        data = {model: results[run] for model, run in runs.items()}
        caption(axis[0], letter, text)
        draw_curves(axis[0], shown, letter, signal, quantity, data, peaks=deviation is None)
        turns_above(axis[0], next(iter(runs.values())))
        if below and _ratio(data, signal) > DWARFED:
            _closer(axis[1], shown, letter, signal, quantity, data)
        elif below:
            _deviations(axis[1], shown, letter, signal, deviation or quantity, data)
        axis[-1].set_xlabel("time [s]")
    axes[0, 0].set_ylabel(quantity.label)
    return figure, xarray.Dataset(shown)


def _closer(
    ax: Axes, shown: Shown, letter: str, signal: str, quantity: Quantity, data: Mapping[str, xr.Dataset]
) -> None:
    """Draw the curves on the scale of the ideal curve."""
    draw_curves(ax, shown, letter, signal, quantity, data)
    legend = ax.get_legend()
    if legend is not None:
        legend.remove()
    values = quantity.factor * values_of(data["ideal"], signal)
    lowest = quantity.factor * min(float(values_of(found, signal).min()) for found in data.values())
    middle, half = 0.5 * (values.max() + values.min()), ROOM * 0.5 * np.ptp(values)
    ax.set_ylim(max(middle - half, lowest - 0.05 * half), middle + half)
    ax.set_ylabel(f"the same, on the scale of\nthe ideal mechanism [{quantity.unit}]")


def _deviations(
    ax: Axes, shown: Shown, letter: str, signal: str, quantity: Quantity, data: Mapping[str, xr.Dataset]
) -> None:
    """Draw the differences to the ideal curve."""
    from scipy.interpolate import CubicSpline

    exact = CubicSpline(time_of(data["ideal"]), values_of(data["ideal"], signal))
    for model in [name for name in LINES if name in data and name != "ideal"]:
        time = time_of(data[model])
        difference = values_of(data[model], signal) - exact(time)
        text = f"{model}, at most {largest(difference, quantity)}"
        style = {"color": COLOURS[model], "label": text, **LINES[model], "linewidth": WIDTHS[model]}
        draw_curve(ax, shown, f"{letter}.{model}", f"{signal}.deviation", time, difference, quantity, **style)
    _finish(ax, data)
    ax.axhline(0.0, color="black", linewidth=0.8)
    ax.set_ylabel(f"deviation from the ideal\nmechanism [{quantity.unit}]")


def _ratio(data: Mapping[str, xr.Dataset], signal: str) -> float:
    """Largest absolute value of all models over the largest absolute value of the ideal curve."""
    peaks = {model: float(np.abs(values_of(found, signal)).max()) for model, found in data.items()}
    return max(peaks.values()) / max(peaks["ideal"], 1e-300)


def laws(number: int, effort: Effort, signal: str, case: Case, names: Mapping[str, str], where: str) -> StudyFigure:
    """Figure of a signal of the rigid mechanism with two friction laws, and of both curves about the highest peak.

    Parameters
    ----------
    number : number of the figure.
    effort : lengths of the runs.
    signal : name of the signal.
    case : case of the model "rigid".
    names : texts of the two friction laws, by name.
    where : text of speed and clearance.
    """
    quantity = case.machine.quantities[signal]
    runs = {law: effort.settled(dataclasses.replace(case, friction=law)) for law in names}
    runs["ideal"] = effort.settled(dataclasses.replace(case, model="ideal"))
    title = f"{quantity.title}, rigid links, {where}"
    draw = partial(_by_law, f"Figure {number}: {title}", runs, names, signal, quantity)
    return StudyFigure(number, title, tuple(runs.values()), draw)


def _by_law(
    heading: str,
    runs: Mapping[str, StudyRun],
    names: Mapping[str, str],
    signal: str,
    quantity: Quantity,
    results: Results,
) -> tuple[Figure, xr.Dataset]:
    import xarray

    data, shown = {name: results[run] for name, run in runs.items()}, dict[str, Any]()
    figure, axes = sheet(heading, 3, 1, panel=(9.5, 2.8))
    for ax, letter, (law, text) in zip(axes[:2, 0], "ab", names.items(), strict=True):
        caption(ax, letter, text)
        draw_curves(ax, shown, letter, signal, quantity, {"rigid": data[law], "ideal": data["ideal"]})
    bounds = [ax.get_ylim() for ax in axes[:2, 0]]  # one scale: the heights are compared
    for ax in axes[:2, 0]:
        ax.set_ylim(min(low for low, _ in bounds), max(high for _, high in bounds))
    turns_above(axes[0, 0], runs["ideal"])
    _close_up(axes[2, 0], shown, data, names, signal, quantity)
    for ax in axes[:, 0]:
        ax.set_ylabel(f"{quantity.text.partition(' of ')[0]} [{quantity.unit}]")
    axes[2, 0].set_xlabel("time [s]")
    return figure, xarray.Dataset(shown)


def _close_up(
    ax: Axes,
    shown: Shown,
    data: Mapping[str, xr.Dataset],
    names: Mapping[str, str],
    signal: str,
    quantity: Quantity,
) -> None:
    """Draw the curves of both friction laws about the highest peak of the first."""
    first = data[next(iter(names))]
    when = time_of(first)[int(np.abs(values_of(first, signal)).argmax())]
    for letter, (law, text), colour in zip("ab", names.items(), LAW_COLOURS, strict=True):
        time, values = time_of(data[law]), values_of(data[law], signal)
        style = {"color": colour, "linewidth": 0.9, "label": text}
        draw_curve(ax, shown, f"{letter}.rigid", signal, time, values, quantity, **style)
    room = CLOSE_UP * first.attrs["period"]
    ax.set_xlim(when - room, when + room)
    caption(ax, "", "both, about the highest peak of (a)")
    ax.legend(fontsize="small", loc="best")


def values_of(data: xr.Dataset, signal: str) -> np.ndarray:
    """Values of a signal in a figure (n,) [SI]; negative penetrations are 0."""
    values = data[signal].values
    return np.maximum(values, 0.0) if _is_penetration(signal) else values


def draw_curves(
    ax: Axes,
    shown: Shown,
    letter: str,
    signal: str,
    quantity: Quantity,
    data: Mapping[str, xr.Dataset],
    *,
    peaks: bool = True,
) -> None:
    """Draw a signal of several models; the legend gives the largest absolute values.

    Parameters
    ----------
    ax : axes of the panel.
    shown : variables of the dataset; the curves are added.
    letter : letter of the panel.
    signal, quantity : name of the signal, and text and unit of its axis.
    data : settled turns by model.
    peaks : whether the legend gives the largest values.
    """
    for model in [name for name in LINES if name in data]:
        values = values_of(data[model], signal)
        text = f"{model}, at most {largest(values, quantity)}" if peaks else model
        style = {"color": COLOURS[model], "label": text, **LINES[model]}
        draw_curve(ax, shown, f"{letter}.{model}", signal, time_of(data[model]), values, quantity, **style)
    _finish(ax, data)


def turns_above(ax: Axes, run: StudyRun) -> None:
    """Add an upper axis in turns of the drives of a run."""
    period = run.case.period

    def to_turns(time: Any) -> Any:
        return time / period

    def to_time(turns: Any) -> Any:
        return turns * period

    top = ax.secondary_xaxis("top", functions=(to_turns, to_time))
    top.set_xlabel(f"turns of the {run.case.machine.drives}", fontsize="small")
    top.tick_params(labelsize="small")


def largest(values: np.ndarray, quantity: Quantity) -> str:
    """Text of the largest absolute value of (n,) values [SI]: "398 m/s²"."""
    return f"{float(f'{quantity.factor * np.abs(values).max():.3g}'):g} {quantity.unit}"


def _finish(ax: Axes, data: Mapping[str, xr.Dataset]) -> None:
    """Set the limits of the time axis, and draw the legend in the order of the models."""
    ends = [float(time_of(found)[-1]) for found in data.values()]
    ax.set_xlim(0.0, max(ends))
    low, high = ax.get_ylim()
    ax.set_ylim(low, high + HEAD * (high - low))
    entries = dict(zip(*reversed(ax.get_legend_handles_labels()), strict=True))
    order = sorted(entries, key=lambda text: MODELS.index(text.partition(",")[0]))
    box = ax.legend([entries[text] for text in order], order, fontsize="small", loc="upper left", framealpha=0.85)
    for line in box.get_lines():
        line.set(linewidth=1.6, alpha=1.0)
