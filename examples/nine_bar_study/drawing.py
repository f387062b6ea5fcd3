"""Common elements of the figures: quantities with units, colours, sheets, variables of the dataset of a figure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = {"ideal": "black", "rigid": "#e07b00", "flexible": "#0072b2"}
"""Colours of the models, distinct for colour-blind readers."""

GRID = {"visible": True, "color": "0.9", "linewidth": 0.6}

SI = {"mm": "m", "µm": "m", "mm/s": "m/s", "m/s²": "m/s2", "π rad/s": "rad/s", "rpm": "rad/s"}
"""SI unit of each unit of axes that is not an SI unit."""

Dims = str | tuple[str, ...]
Noted = tuple[Dims, np.ndarray, dict[str, str]]
"""Dimensions, values and attributes of a variable of a dataset."""

Shown = dict[str, Any]
"""Variables of the dataset of a figure, by name."""


@dataclass(frozen=True)
class Quantity:
    """Quantity of a signal on an axis.

    Parameters
    ----------
    text : name of the quantity.
    unit : unit of the axis.
    factor : values on the axis per SI unit.
    """

    text: str
    unit: str
    factor: float = 1.0

    @property
    def label(self) -> str:
        """Label of an axis: name and unit."""
        return f"{self.text} [{self.unit}]"

    @property
    def title(self) -> str:
        """Name with an initial capital letter."""
        return f"{self.text[0].upper()}{self.text[1:]}"

    def noted(self, values: Any, dims: Dims) -> Noted:
        """Variable of a dataset with the values [SI], SI unit and name of the quantity."""
        return noted(values, dims, SI.get(self.unit, self.unit), self.text)


@dataclass(frozen=True)
class Observable:
    """Coordinate and velocity on the axes of phase diagrams and sections.

    Parameters
    ----------
    place, rate : signals of the coordinate and of the velocity.
    text : name of the coordinate, "journal along X".
    unit, factor : unit of the coordinate on an axis, and values on the axis per metre.
    rate_unit, rate_factor : unit of the velocity on an axis, and values on the axis per m/s.
    """

    place: str
    rate: str
    text: str
    unit: str
    factor: float
    rate_unit: str = "m/s"
    rate_factor: float = 1.0


def noted(values: Any, dims: Dims, units: str, text: str) -> Noted:
    """Variable of a dataset with a unit.

    Parameters
    ----------
    values : (n,) or more axes [units].
    dims : name of its dimension, or of several.
    units : SI.
    text : name of the quantity.
    """
    return dims, np.asarray(values), {"units": units, "long_name": text}


def named(values: Any, dims: Dims, text: str) -> Noted:
    """Variable of a dataset without a unit: names, verdicts, counts."""
    return dims, np.asarray(values), {"long_name": text}


def draw_curve(
    ax: Axes, shown: Shown, group: str, signal: str, x: np.ndarray, y: np.ndarray, quantity: Quantity, **style: Any
) -> None:
    """Draw a signal over time and add it to the dataset; the `gid` of the line is the name of the variable.

    Parameters
    ----------
    ax : axes of the panel.
    shown : variables of the dataset; time and signal are added.
    group : panel and model, "a.rigid".
    signal : name of the signal.
    x : (n,) time from the first instant of the panel [s].
    y : (n,) values of the signal [SI].
    quantity : name and unit of the signal.
    **style : style of the line.
    """
    name = f"{group}.{signal}"
    shown[group] = noted(x, group, "s", "time from the first instant shown")
    shown[name] = quantity.noted(y, group)
    ax.plot(x, quantity.factor * y, gid=name, **style)


def sheet(title: str, rows: int, columns: int, *, panel: tuple[float, float], **options: Any) -> tuple[Figure, Any]:
    """Figure outside matplotlib's global state, and its axes (rows, columns).

    Parameters
    ----------
    title : title of the figure.
    rows, columns : number of rows and columns of panels.
    panel : width and height of a panel [inch].
    **options : options of `Figure.subplots`.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(panel[0] * columns, panel[1] * rows + 0.7), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    figure.suptitle(title, fontsize="large")
    for ax in axes.flat:
        ax.grid(**GRID)
        ax.set_axisbelow(True)
    return figure, axes


def caption(ax: Axes, letter: str, text: str) -> None:
    """Write the letter, "a", and the text of a panel above the axes."""
    ax.set_title(f"({letter}) {text}" if letter else text, fontsize="medium", loc="left")


def length_text(metres: float) -> str:
    """Text of a length with a prefixed unit: "23 µm".

    Parameters
    ----------
    metres : length [m].
    """
    for unit, factor in (("m", 1.0), ("mm", 1e3), ("µm", 1e6), ("nm", 1e9)):
        if abs(metres) * factor >= 1.0:
            return f"{metres * factor:.3g} {unit}"
    return "0" if metres == 0.0 else f"{metres * 1e9:.2g} nm"
