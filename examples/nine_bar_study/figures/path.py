"""Kind "path" of figures: the path of the centre of the journal in the bearing."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from nine_bar_study.case import PLAY_MODELS
from nine_bar_study.drawing import COLOURS, Quantity, Shown, caption, named, noted, sheet
from nine_bar_study.effort import Effort
from nine_bar_study.figures.contrast import Contrast, time_of
from nine_bar_study.item import StudyFigure, once
from nine_bar_study.run import Results, StudyRun

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

AXES = {"ex": Quantity("journal along X", "µm", 1e6), "ey": Quantity("journal along Y", "µm", 1e6)}


def path(number: int, effort: Effort, contrast: Contrast, models: tuple[str, ...] = PLAY_MODELS) -> StudyFigure:
    """Figure of the path of the centre of the journal, one model per row.

    Parameters
    ----------
    number : number of the figure.
    effort : lengths of the runs.
    contrast : cases of the columns.
    models : models of the rows.
    """
    columns = contrast.columns(effort, models)
    title = f"Path of the shaft centre at {contrast.cases[0].machine.joint}, {contrast.where}"
    runs = once([run for _, _, by_model in columns for run in by_model.values()])
    return StudyFigure(number, title, runs, partial(_draw, f"Figure {number}: {title}", columns))


def _draw(
    heading: str, columns: list[tuple[str, str, dict[str, StudyRun]]], results: Results
) -> tuple[Figure, xr.Dataset]:
    import xarray

    shown: Shown = {}
    figure, axes = sheet(heading, len(columns[0][2]), len(columns), panel=(5.0, 4.9))
    for axis, (letter, text, runs) in zip(axes.T, columns, strict=True):
        for ax, (model, run) in zip(axis, runs.items(), strict=True):
            share = _path(ax, shown, f"{letter}.{model}", run, results[run])
            caption(ax, letter, f"{text}, {model}: {100.0 * share:.2g} % of the time in flight")
    for ax in axes[-1]:
        ax.set_xlabel(AXES["ex"].label)
    for ax in axes[:, 0]:
        ax.set_ylabel(AXES["ey"].label)
    entries: dict[str, Any] = {}
    for ax in axes[:, 0]:
        entries |= dict(zip(*reversed(ax.get_legend_handles_labels()), strict=True))
    handles, labels = list(entries.values()), list(entries)
    figure.legend(handles, labels, fontsize="small", loc="outside lower center", ncols=len(entries))
    return figure, xarray.Dataset(shown)


def _path(ax: Axes, shown: Shown, group: str, run: StudyRun, data: xr.Dataset) -> float:
    """Draw one path, its contact intervals and the circle of the clearance; the result is the share of free flight."""
    model, joint, time = run.case.model, run.case.machine.joint, time_of(data)
    touching = data[f"{joint}.penetration"].values > 0.0
    shown[group] = noted(time, group, "s", "time from the first instant shown")
    for name, quantity in AXES.items():
        shown[f"{group}.{joint}.{name}"] = quantity.noted(data[f"{joint}.{name}"].values, group)
    shown[f"{group}.contact"] = named(touching, group, "whether journal and bearing touch")
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    circle = 1e6 * run.case.clearance * np.cos(angle), 1e6 * run.case.clearance * np.sin(angle)
    ax.plot(*circle, color="black", linewidth=0.7, linestyle="--", label="circle of the clearance")
    x, y = (1e6 * data[f"{joint}.{name}"].values for name in AXES)
    lines = "|".join(f"{group}.{joint}.{name}" for name in AXES)
    ax.plot(x, y, color="0.6", linewidth=0.5, label="free flight", gid=lines)
    held = np.where(touching, x, np.nan), np.where(touching, y, np.nan)
    ax.plot(*held, color=COLOURS[model], linewidth=1.0, label=f"contact, {model}", gid=f"{group}.contact")
    ax.set_aspect("equal")
    return float(np.diff(time)[~touching[1:]].sum() / (time[-1] - time[0]))
