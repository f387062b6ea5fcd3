"""Parts that figures share: quantities with units, colours, sheets, and the numbers that go with a picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = {"ideal": "black", "rigid": "#e07b00", "flexible": "#0072b2"}
"""Colours of the models; told apart by people who see few colours, too."""

GRID = {"visible": True, "color": "0.9", "linewidth": 0.6}

SI = {"mm": "m", "µm": "m", "mm/s": "m/s", "m/s²": "m/s2", "π rad/s": "rad/s", "rpm": "rad/s"}
"""SI units by units of axes, where they are not the same."""

Dims = str | tuple[str, ...]
Noted = tuple[Dims, np.ndarray, dict[str, str]]
"""Dimensions, values and attributes of a variable of a dataset."""

Shown = dict[str, Any]
"""Variables of the dataset of a figure, by name."""


@dataclass(frozen=True)
class Quantity:
    """A signal on an axis.

    Parameters
    ----------
    text : name of the quantity.
    unit : unit of the axis.
    factor : that unit, so many to one of SI.
    """

    text: str
    unit: str
    factor: float = 1.0

    @property
    def label(self) -> str:
        """Label of an axis."""
        return f"{self.text} [{self.unit}]"

    @property
    def title(self) -> str:
        """Name with a capital letter."""
        return f"{self.text[0].upper()}{self.text[1:]}"

    def noted(self, values: Any, dims: Dims) -> Noted:
        """A variable of a dataset with values [SI]."""
        return noted(values, dims, SI.get(self.unit, self.unit), self.text)


@dataclass(frozen=True)
class Observable:
    """A place and its velocity on the axes of phase diagrams and sections.

    Parameters
    ----------
    place, rate : names of the signals.
    text : name of the place, "journal along X".
    unit, factor : unit of the place on an axis, so many to one metre.
    rate_unit, rate_factor : the same of the velocity.
    """

    place: str
    rate: str
    text: str
    unit: str
    factor: float
    rate_unit: str = "m/s"
    rate_factor: float = 1.0


def noted(values: Any, dims: Dims, units: str, text: str) -> Noted:
    """A variable of a dataset.

    Parameters
    ----------
    values : (n,) or more axes [units].
    dims : name of its dimension, or of several.
    units : SI.
    text : name of the quantity.
    """
    return dims, np.asarray(values), {"units": units, "long_name": text}


def named(values: Any, dims: Dims, text: str) -> Noted:
    """A variable of a dataset that has no unit: names, verdicts, counts.

    Parameters
    ----------
    values : (n,) or more axes.
    dims : name of its dimension, or of several.
    text : name of the quantity.
    """
    return dims, np.asarray(values), {"long_name": text}


def draw_curve(
    ax: Axes, shown: Shown, group: str, signal: str, x: np.ndarray, y: np.ndarray, quantity: Quantity, **style: Any
) -> None:
    """Draw a signal over time and note it; the line has the name of its variable as its `gid`.

    Parameters
    ----------
    ax : axes.
    shown : variables of the dataset, to which it is added.
    group : panel and model, "a.rigid".
    signal : name of the signal.
    x : (n,) time from the first instant that is shown [s].
    y : (n,) the signal [SI].
    quantity : its text and unit.
    **style : of the line.
    """
    name = f"{group}.{signal}"
    shown[group] = noted(x, group, "s", "time from the first instant shown")
    shown[name] = quantity.noted(y, group)
    ax.plot(x, quantity.factor * y, gid=name, **style)


def sheet(title: str, rows: int, columns: int, *, panel: tuple[float, float], **options: Any) -> tuple[Figure, Any]:
    """A figure, free of matplotlib's global state, and its axes (rows, columns).

    Parameters
    ----------
    title : above it.
    rows, columns : of panels.
    panel : width and height of a panel [inch].
    **options : of `Figure.subplots`.
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
    """The letter of a panel, "a", and its text."""
    ax.set_title(f"({letter}) {text}" if letter else text, fontsize="medium", loc="left")


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
