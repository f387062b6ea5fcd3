"""What the figures of motions and diagrams have in common: colours, units, axes, and the data that goes with them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

COLOURS = {"ideal": "black", "rigid": "#e07b00", "flexible": "#0072b2"}
"""Of the models; told apart by people who see few colours, too."""

GRID = {"visible": True, "color": "0.9", "linewidth": 0.6}

SI = {"mm": "m", "µm": "m", "mm/s": "m/s", "m/s²": "m/s2", "π rad/s": "rad/s"}
"""Units of the data by those of axes, where they are not the same."""


@dataclass(frozen=True)
class Quantity:
    """How a signal is drawn.

    Parameters
    ----------
    text : what it is called.
    unit : in which it is drawn.
    factor : from SI to that unit.
    """

    text: str
    unit: str
    factor: float = 1.0

    @property
    def label(self) -> str:
        """For an axis."""
        return f"{self.text} [{self.unit}]"

    @property
    def noted(self) -> dict[str, str]:
        """Attributes of the data [SI]."""
        return {"units": SI.get(self.unit, self.unit), "long_name": self.text}


@dataclass
class Shown:
    """The curves of a figure, as the dataset that goes with it: names such as "a.rigid.slider.ax".

    A line of the figure has the name of its variable as its `gid`.

    Parameters
    ----------
    variables : by name, as xarray takes them.
    """

    variables: dict[str, Any] = field(default_factory=dict)

    def curve(
        self, ax: Axes, group: str, signal: str, x: np.ndarray, y: np.ndarray, quantity: Quantity, **style: Any
    ) -> Line2D:
        """Draw a signal over time and note it.

        Parameters
        ----------
        ax : where.
        group : what the curves of one run in one panel have in common, "a.rigid".
        signal : name of the signal.
        x : (n,) time from the first instant that is shown [s].
        y : (n,) the signal [SI].
        quantity : how it is drawn.
        **style : of the line.
        """
        name = f"{group}.{signal}"
        self.variables[group] = (group, x, {"units": "s", "long_name": "time from the first instant shown"})
        self.variables[name] = (group, y, quantity.noted)
        (line,) = ax.plot(x, quantity.factor * y, gid=name, **style)
        return line

    def note(self, name: str, dims: tuple[str, ...], values: np.ndarray, **attributes: str) -> None:
        """Note what is drawn by other means.

        Parameters
        ----------
        name : of the variable.
        dims : of its axes.
        values : its values [SI].
        **attributes : units and long_name.
        """
        self.variables[name] = (dims, values, attributes)

    def dataset(self) -> xr.Dataset:
        """All that was noted."""
        import xarray

        return xarray.Dataset(self.variables)


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


def turns_above(ax: Axes, period: float) -> None:
    """A second axis above, in turns of the cranks.

    Parameters
    ----------
    ax : axes over time [s].
    period : of the cranks [s].
    """
    top = ax.secondary_xaxis("top", functions=(lambda t: t / period, lambda n: n * period))
    top.set_xlabel("turns of the cranks", fontsize="small")
    top.tick_params(labelsize="small")


def caption(ax: Axes, letter: str, text: str) -> None:
    """The letter of a panel and what it shows.

    Parameters
    ----------
    ax : the panel.
    letter : "a".
    text : what it shows.
    """
    ax.set_title(f"({letter}) {text}" if letter else text, fontsize="medium", loc="left")
