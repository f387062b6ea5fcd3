"""Figures of the nonlinear part, which set two cases side by side: (a) and (b) of 17-26, 34-39 and 41-43."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.paper.attractor import Attractor, by_clearance, by_speed
from flexmb.paper.effort import Effort
from flexmb.paper.plate import Plate, Results

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

LETTERS = ("a", "b")
WIDTH, HEIGHT, FRAME = 5.2, 3.9, 0.8  # of a panel, and of what is around all panels [inch]
COLOUR = "#0072b2"
"""Of what is shown of the flexible mechanism."""


@dataclass(frozen=True)
class Observable:
    """A place and its rate, as figures show them.

    Parameters
    ----------
    place, rate : names of the signals.
    text : what it is called, "journal along X".
    unit, factor : in which the place is drawn, and from metres to that.
    rate_unit, rate_factor : the same of the rate.
    """

    place: str
    rate: str
    text: str
    unit: str
    factor: float
    rate_unit: str = "m/s"
    rate_factor: float = 1.0


JOURNAL_X = Observable("P1.ex", "P1.vex", "journal along X", "µm", 1e6, "mm/s", 1e3)
JOURNAL_Y = Observable("P1.ey", "P1.vey", "journal along Y", "µm", 1e6, "mm/s", 1e3)
SLIDER = Observable("slider.x", "slider.vx", "slider", "mm", 1e3)
OBSERVABLES = (JOURNAL_X, JOURNAL_Y, SLIDER)

Column = Callable[[Any, dict[str, Any], str, Observable, Attractor, "xr.Dataset"], None]
"""(axes (rows,), variables of the dataset so far, letter, observable, run, its result): draws one case."""


@dataclass(frozen=True, eq=False)
class Double:
    """A figure of two cases.

    Parameters
    ----------
    number : of the figure.
    what : "Phase diagram".
    observable : what is looked at.
    runs, texts : the two cases, and what tells them apart.
    rows : of panels.
    column : draws one of them.
    """

    number: int
    what: str
    observable: Observable
    runs: tuple[Attractor, Attractor]
    texts: tuple[str, str]
    rows: int
    column: Column

    @property
    def plate(self) -> Plate:
        """The figure."""
        return Plate(self.number, f"{self.what}, {self.observable.text}", self.runs, self.draw)

    def draw(self, results: Results) -> tuple[Figure, xr.Dataset]:
        """The picture, and a dataset with exactly what is shown.

        Parameters
        ----------
        results : of the two runs.
        """
        import xarray
        from matplotlib.figure import Figure

        figure = Figure(figsize=(2 * WIDTH, self.rows * HEIGHT + FRAME), layout="constrained")
        axes = figure.subplots(self.rows, 2, squeeze=False)
        for ax in axes.flat:
            ax.grid(visible=True, color="0.9", linewidth=0.6)
            ax.set_axisbelow(True)
        shown: dict[str, Any] = {}
        for letter, column, run, text in zip(LETTERS, axes.T, self.runs, self.texts, strict=True):
            column[0].set_title(f"({letter}) {text}", fontsize="medium", loc="left")
            self.column(column, shown, letter, self.observable, run, results[run])
        elements = {run.case.elements for run in self.runs} - {4}
        coarse = f" ({elements.pop()} elements a link)" if elements else ""
        figure.suptitle(f"Figure {self.number}: {self.plate.title}, flexible links{coarse}", fontsize="large")
        about = {f"{letter}.case": run.case.name for letter, run in zip(LETTERS, self.runs, strict=True)}
        return figure, xarray.Dataset(shown, attrs={"title": self.plate.title} | about)


def six(
    effort: Effort, what: str, numbers: tuple[tuple[int, ...], tuple[int, ...]], rows: int, column: Column
) -> tuple[Plate, ...]:
    """The figures of one kind: three observables by clearance, and three by speed.

    Parameters
    ----------
    effort : how long the runs are.
    what : "Phase diagram".
    numbers : of the three figures by clearance, and of those by speed.
    rows : of panels.
    column : draws one case.
    """
    contrasts = (
        (by_clearance(effort), ("clearance 0.05 mm, 2π rad/s", "clearance 0.5 mm, 2π rad/s")),
        (by_speed(effort), ("0.5π rad/s, clearance 0.5 mm", "2.5π rad/s, clearance 0.5 mm")),
    )
    return tuple(
        Double(number, what, observable, runs, texts, rows, column).plate
        for (runs, texts), three in zip(contrasts, numbers, strict=True)
        for number, observable in zip(three, OBSERVABLES, strict=True)
    )


Axes = str | tuple[str, ...]


def noted(values: Any, axis: Axes, units: str, text: str) -> tuple[Axes, np.ndarray, dict[str, str]]:
    """A variable of a dataset.

    Parameters
    ----------
    values : (n,) or more axes [units].
    axis : name of its dimension, or of several.
    units : SI.
    text : what it is.
    """
    return axis, np.asarray(values), {"units": units, "long_name": text}


def named(values: Any, axis: Axes, text: str) -> tuple[Axes, np.ndarray, dict[str, str]]:
    """A variable of a dataset that has no unit: names, verdicts, counts.

    Parameters
    ----------
    values : (n,) or more axes.
    axis : name of its dimension, or of several.
    text : what it is.
    """
    return axis, np.asarray(values), {"long_name": text}


def length_text(metres: float) -> str:
    """A length in the unit in which it is easily read: "23 µm".

    Parameters
    ----------
    metres : the length [m].
    """
    for unit, factor in (("m", 1.0), ("mm", 1e3), ("µm", 1e6), ("nm", 1e9)):
        if abs(metres) * factor >= 1.0:
            return f"{metres * factor:.3g} {unit}"
    return "0" if metres == 0.0 else f"{metres * 1e9:.2g} nm"
