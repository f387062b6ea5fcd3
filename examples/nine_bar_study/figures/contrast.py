"""Two cases side by side: columns (a) and (b) of a figure."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from nine_bar_study.case import MODELS, Case
from nine_bar_study.drawing import Observable, Shown, caption, sheet
from nine_bar_study.effort import Effort
from nine_bar_study.item import StudyFigure, once
from nine_bar_study.run import Results, StudyRun

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

COLOUR = "#0072b2"
"""Colour of the curves of a figure with one model."""


@dataclass(frozen=True)
class Contrast:
    """Two cases that differ in one number.

    Parameters
    ----------
    where : text of the common number, "clearance 0.5 mm".
    texts : text of the different number of each case, "2π rad/s".
    cases : the two cases, of any model.
    """

    where: str
    texts: tuple[str, ...]
    cases: tuple[Case, ...]

    def columns(self, effort: Effort, models: tuple[str, ...] = MODELS) -> list[tuple[str, str, dict[str, StudyRun]]]:
        """Letter, text, and runs of settled turns by model, of each case."""
        runs = [
            {model: effort.settled(dataclasses.replace(case, model=model)) for model in models} for case in self.cases
        ]
        return list(zip("abcdef", self.texts, runs, strict=False))

    def attractors(self, effort: Effort) -> tuple[StudyRun, ...]:
        """Long runs of the cases."""
        cases = (dataclasses.replace(case, elements=effort.elements or case.elements) for case in self.cases)
        return tuple(effort.attractor(case) for case in cases)


Column = Callable[[Any, Shown, str, Observable, StudyRun, "xr.Dataset"], None]
"""Function (axes (rows,), variables of the dataset, letter, observable, run, result of the run) that draws one case."""


def observed(
    number: int, effort: Effort, contrast: Contrast, place: str, *, what: str, rows: int, column: Column
) -> StudyFigure:
    """Figure of one observable in the long runs of two cases.

    Parameters
    ----------
    number : number of the figure.
    effort : lengths of the runs.
    contrast : cases of the columns.
    place : coordinate of the observable.
    what : text of the kind of figure, "Phase diagram".
    rows : number of rows of panels.
    column : function that draws one case.
    """
    observable = next(seen for seen in contrast.cases[0].machine.observables if seen.place == place)
    runs = contrast.attractors(effort)
    title = f"{what}, {observable.text}"
    draw = partial(_draw, f"Figure {number}: {title}", title, contrast, runs, observable, rows, column)
    return StudyFigure(number, title, once(runs), draw)


def _draw(
    heading: str,
    title: str,
    contrast: Contrast,
    runs: tuple[StudyRun, ...],
    observable: Observable,
    rows: int,
    column: Column,
    results: Results,
) -> tuple[Figure, xr.Dataset]:
    import xarray

    usual = runs[0].case.machine.elements
    elements = {run.case.elements for run in runs if run.case.model == "flexible"} - {usual}
    coarse = f" ({elements.pop()} elements a link)" if elements else ""
    figure, axes = sheet(f"{heading}, {runs[0].case.model} links{coarse}", rows, len(runs), panel=(5.2, 3.9))
    shown: Shown = {}
    about = {"title": title}
    for letter, text, axis, run in zip("abcdef", contrast.texts, axes.T, runs, strict=False):
        caption(axis[0], letter, f"{text}, {contrast.where}")
        column(axis, shown, letter, observable, run, results[run])
        about[f"{letter}.case"] = run.case.name
    return figure, xarray.Dataset(shown, attrs=about)


def time_of(data: xr.Dataset) -> np.ndarray:
    """Time from the begin of the saved turns of a motion (n,) [s]."""
    time, period = data["time"].values, data.attrs["period"]
    since: np.ndarray = time - period * math.floor(time[0] / period + 1e-9)
    return since
