"""Curves over the last turns: which signals, in which units, of which motions, drawn in which order."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.paper.case import MODELS, Case
from flexmb.paper.drawing import COLOURS, Quantity, Shown
from flexmb.paper.effort import Effort
from flexmb.paper.motion import Motion

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

SIGNALS = {
    "slider.x": Quantity("displacement of the slider along X", "mm", 1e3),
    "slider.vx": Quantity("velocity of the slider", "m/s"),
    "slider.ax": Quantity("acceleration of the slider", "m/s²"),
    "motor1.torque": Quantity("driving torque of crank 1", "N m"),
    "motor4.torque": Quantity("driving torque of crank 4", "N m"),
    "P1.force": Quantity("contact force at P1", "N"),
    "P1.penetration": Quantity("penetration at P1", "µm", 1e6),
}

LINES: dict[str, dict[str, Any]] = {
    "flexible": {"linewidth": 0.5, "alpha": 0.75},
    "rigid": {"linewidth": 0.5, "alpha": 0.85},
    "ideal": {"linewidth": 1.1},
}
"""In the order of drawing: vibrations of flexible links fill the panel, so they lie under the rigid one's impacts."""

HEAD = 0.3
"""Room for the legend above the curves, over their height."""


@dataclass(frozen=True)
class Panel:
    """One column of a figure.

    Parameters
    ----------
    letter : "a" or "b".
    text : what it shows.
    runs : motions by model.
    """

    letter: str
    text: str
    runs: Mapping[str, Motion]


def motion(effort: Effort, model: str, speed: float, clearance: float = 0.5e-3, friction: str = "coulomb") -> Motion:
    """The motion of a case at an effort.

    Parameters
    ----------
    effort : how long it is.
    model, speed, clearance, friction : of the case; an ideal mechanism is one, whatever its clearance.
    """
    play = {} if model == "ideal" else {"clearance": clearance}
    return Motion(Case(model=model, speed=speed, friction=friction, **play), effort.skip, effort.keep, effort.shown)


def clearance_panels(effort: Effort) -> tuple[Panel, ...]:
    """(a) 0.05 mm and (b) 0.5 mm, at 2 pi rad/s; how long the motions are is said by `effort`."""
    return tuple(_panel(effort, k, 2.0, c, f"clearance {1e3 * c:g} mm") for k, c in (("a", 0.05e-3), ("b", 0.5e-3)))


def speed_panels(effort: Effort) -> tuple[Panel, ...]:
    """(a) 0.5 pi and (b) 2.5 pi rad/s, with 0.5 mm; how long the motions are is said by `effort`."""
    return tuple(_panel(effort, k, w, 0.5e-3, f"{w:g}π rad/s") for k, w in (("a", 0.5), ("b", 2.5)))


def time_of(data: xr.Dataset) -> np.ndarray:
    """Time from the beginning of the shown turns of a motion, whose `data` these are (n,) [s]."""
    time, period = data["time"].values, data.attrs["period"]
    return time - period * math.floor(time[0] / period + 1e-9)


def values_of(data: xr.Dataset, signal: str) -> np.ndarray:
    """A signal as it is drawn (n,): there is no negative penetration.

    Parameters
    ----------
    data : of a motion.
    signal : its name.
    """
    values = data[signal].values
    return np.maximum(values, 0.0) if signal == "P1.penetration" else values


def draw_curves(
    ax: Axes, shown: Shown, letter: str, signal: str, data: Mapping[str, xr.Dataset], *, peaks: bool = True
) -> None:
    """Draw a signal of several models, with the largest absolute value of each in the legend.

    Parameters
    ----------
    ax : where.
    shown : what is drawn is noted there.
    letter : of the panel.
    signal : its name.
    data : motions by model.
    peaks : whether the largest values are told.
    """
    quantity = SIGNALS[signal]
    for model in [name for name in LINES if name in data]:
        values = values_of(data[model], signal)
        text = f"{model}, at most {largest(values, quantity)}" if peaks else model
        style = {"color": COLOURS[model], "label": text, **LINES[model]}
        shown.curve(ax, f"{letter}.{model}", signal, time_of(data[model]), values, quantity, **style)
    finish(ax, data)


def finish(ax: Axes, data: Mapping[str, xr.Dataset]) -> None:
    """Ends of the time axis; the legend above the curves, in the order of the models, with lines that can be seen.

    Parameters
    ----------
    ax : the panel.
    data : motions by model.
    """
    ends = [float(time_of(found)[-1]) for found in data.values()]
    ax.set_xlim(0.0, max(ends))
    low, high = ax.get_ylim()
    ax.set_ylim(low, high + HEAD * (high - low))
    entries = dict(zip(*reversed(ax.get_legend_handles_labels()), strict=True))
    order = sorted(entries, key=lambda text: MODELS.index(text.partition(",")[0]))
    box = ax.legend([entries[text] for text in order], order, fontsize="small", loc="upper left", framealpha=0.85)
    for line in box.get_lines():
        line.set(linewidth=1.6, alpha=1.0)


def largest(values: np.ndarray, quantity: Quantity) -> str:
    """The largest absolute value, for a legend: "398 m/s²".

    Parameters
    ----------
    values : (n,) [SI].
    quantity : how they are drawn.
    """
    return f"{float(f'{quantity.factor * np.abs(values).max():.3g}'):g} {quantity.unit}"


def _panel(effort: Effort, letter: str, speed: float, clearance: float, text: str) -> Panel:
    return Panel(letter, text, {model: motion(effort, model, speed, clearance) for model in MODELS})
