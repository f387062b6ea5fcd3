"""Figures 9-15 and 28-32: slider, torques, contact force and penetration of the ideal, rigid and flexible mechanism."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexmb.paper.curves import (
    LINES,
    SIGNALS,
    Panel,
    clearance_panels,
    draw_curves,
    finish,
    largest,
    speed_panels,
    time_of,
    values_of,
)
from flexmb.paper.drawing import COLOURS, Quantity, Shown, caption, sheet, turns_above
from flexmb.paper.effort import Effort
from flexmb.paper.motion import Motion
from flexmb.paper.plate import Plate, Results

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

OVER_CLEARANCE = dict(zip(range(9, 16), SIGNALS, strict=True))
OVER_SPEED = dict(zip(range(28, 33), list(SIGNALS)[1:6], strict=True))
"""Signals by number of the figure."""

DEVIATIONS = {
    "slider.x": Quantity("deviation", "µm", 1e6),
    "slider.vx": Quantity("deviation", "mm/s", 1e3),
}
"""How deviations from the ideal mechanism are drawn of signals that hardly differ; of others in the signal's unit."""

DWARFED = 10.0
"""How many times as large as the ideal mechanism's peaks are that hide its curve."""

ROOM = 1.6
"""Height of that panel over what the ideal curve needs of it."""

WIDTHS = {"flexible": 1.6, "rigid": 0.7}
"""Of deviations: where there are no impacts both are the same, and both should be seen."""


def plates(effort: Effort) -> tuple[Plate, ...]:
    """The figures of motions.

    Parameters
    ----------
    effort : how long the motions are.
    """
    over = clearance_panels(effort), speed_panels(effort)
    found = [Comparison(number, signal, over[0], "2π rad/s") for number, signal in OVER_CLEARANCE.items()]
    found += [Comparison(number, signal, over[1], "clearance 0.5 mm") for number, signal in OVER_SPEED.items()]
    return tuple(one.plate for one in found)


@dataclass(frozen=True, eq=False)
class Comparison:
    """A signal of the ideal, the rigid and the flexible mechanism, and below it what cannot be seen on its scale.

    That is the ideal curve where peaks dwarf it, and the deviation from it where there are none such.

    Parameters
    ----------
    number : of the figure.
    signal : what is drawn.
    panels : columns.
    where : what they have in common.
    """

    number: int
    signal: str
    panels: tuple[Panel, ...]
    where: str

    @property
    def plate(self) -> Plate:
        """The figure."""
        text = SIGNALS[self.signal].text
        runs = dict.fromkeys(run for panel in self.panels for run in self._runs(panel).values())
        return Plate(self.number, f"{text[0].upper()}{text[1:]}, {self.where}", tuple(runs), self.draw)

    def draw(self, results: Results) -> tuple[Figure, xr.Dataset]:
        """The picture and its data.

        Parameters
        ----------
        results : of the motions.
        """
        found = [{model: results[run] for model, run in self._runs(panel).items()} for panel in self.panels]
        below = self.signal != "P1.penetration"
        size = {"panel": (6.2, 3.3 if below else 4.2), "sharex": "col"}
        figure, axes = sheet(f"Figure {self.number}: {self.plate.title}", 1 + below, len(found), **size)
        shown = Shown()
        for column, panel, data in zip(axes.T, self.panels, found, strict=True):
            caption(column[0], panel.letter, panel.text)
            draw_curves(column[0], shown, panel.letter, self.signal, data, peaks=self.signal not in DEVIATIONS)
            turns_above(column[0], next(iter(data.values())).attrs["period"])
            if below:
                second = _closer if _ratio(data, self.signal) > DWARFED else _deviations
                second(column[1], shown, panel.letter, self.signal, data)
            column[-1].set_xlabel("time [s]")
        axes[0, 0].set_ylabel(SIGNALS[self.signal].label)
        return figure, shown.dataset()

    def _runs(self, panel: Panel) -> dict[str, Motion]:
        """An ideal mechanism has no penetration."""
        return {model: run for model, run in panel.runs.items() if model != "ideal" or self.signal != "P1.penetration"}


def _closer(ax: Axes, shown: Shown, letter: str, signal: str, data: Mapping[str, xr.Dataset]) -> None:
    """The same curves, on the scale of the ideal one."""
    draw_curves(ax, shown, letter, signal, data)
    ax.get_legend().remove()
    values = SIGNALS[signal].factor * values_of(data["ideal"], signal)
    lowest = SIGNALS[signal].factor * min(float(values_of(found, signal).min()) for found in data.values())
    middle, half = 0.5 * (values.max() + values.min()), ROOM * 0.5 * np.ptp(values)
    ax.set_ylim(max(middle - half, lowest - 0.05 * half), middle + half)
    ax.set_ylabel(f"the same, on the scale of\nthe ideal mechanism [{SIGNALS[signal].unit}]")


def _deviations(ax: Axes, shown: Shown, letter: str, signal: str, data: Mapping[str, xr.Dataset]) -> None:
    """The difference from the ideal curve."""
    from scipy.interpolate import CubicSpline

    quantity = DEVIATIONS.get(signal, SIGNALS[signal])
    exact = CubicSpline(time_of(data["ideal"]), values_of(data["ideal"], signal))
    for model in [name for name in LINES if name in data and name != "ideal"]:
        time = time_of(data[model])
        difference = values_of(data[model], signal) - exact(time)
        text = f"{model}, at most {largest(difference, quantity)}"
        style = {"color": COLOURS[model], "label": text, **LINES[model], "linewidth": WIDTHS[model]}
        shown.curve(ax, f"{letter}.{model}", f"{signal}.deviation", time, difference, quantity, **style)
    finish(ax, data)
    ax.axhline(0.0, color="black", linewidth=0.8)
    ax.set_ylabel(f"deviation from the ideal\nmechanism [{quantity.unit}]")


def _ratio(data: Mapping[str, xr.Dataset], signal: str) -> float:
    """How many times as high as the ideal curve the highest one is."""
    peaks = {model: float(np.abs(values_of(found, signal)).max()) for model, found in data.items()}
    return max(peaks.values()) / max(peaks["ideal"], 1e-300)
