"""Figures 6-8: the rigid mechanism with the modified Coulomb law and with LuGre."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexmb.paper.curves import SIGNALS, draw_curves, motion, time_of, values_of
from flexmb.paper.drawing import COLOURS, Shown, caption, sheet, turns_above
from flexmb.paper.effort import Effort
from flexmb.paper.motion import Motion
from flexmb.paper.plate import Plate, Results

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NUMBERS = {6: "slider.ax", 7: "motor1.torque", 8: "motor4.torque"}
LAWS = {"coulomb": "modified Coulomb friction", "lugre": "LuGre friction"}
COLOUR = {"coulomb": COLOURS["rigid"], "lugre": "#8e44ad"}
CLOSE_UP = 0.05
"""Part of a turn that is drawn enlarged before and after the highest peak."""


def plates(effort: Effort) -> tuple[Plate, ...]:
    """The figures of friction.

    Parameters
    ----------
    effort : how long the motions are.
    """
    return tuple(Friction(number, signal, effort).plate for number, signal in NUMBERS.items())


@dataclass(frozen=True)
class Friction:
    """A signal of the rigid mechanism with two laws of friction, and both over each other about the highest peak.

    Parameters
    ----------
    number : of the figure.
    signal : what is drawn.
    effort : how long the motions are.
    """

    number: int
    signal: str
    effort: Effort

    @property
    def plate(self) -> Plate:
        """The figure."""
        text = SIGNALS[self.signal].text
        title = f"{text[0].upper()}{text[1:]}, rigid links, 2.5π rad/s, clearance 0.5 mm"
        return Plate(self.number, title, tuple(self._runs().values()), self.draw)

    def draw(self, results: Results) -> tuple[Figure, xr.Dataset]:
        """The picture and its data.

        Parameters
        ----------
        results : of the motions.
        """
        data, shown = {name: results[run] for name, run in self._runs().items()}, Shown()
        figure, axes = sheet(f"Figure {self.number}: {self.plate.title}", 3, 1, panel=(9.5, 2.8))
        for ax, letter, law in zip(axes[:2, 0], "ab", LAWS, strict=True):
            caption(ax, letter, LAWS[law])
            draw_curves(ax, shown, letter, self.signal, {"rigid": data[law], "ideal": data["ideal"]})
        bounds = [ax.get_ylim() for ax in axes[:2, 0]]  # one scale: the heights are what is compared
        for ax in axes[:2, 0]:
            ax.set_ylim(min(low for low, _ in bounds), max(high for _, high in bounds))
        turns_above(axes[0, 0], data["ideal"].attrs["period"])
        self._close_up(axes[2, 0], shown, data)
        text, unit = SIGNALS[self.signal].text.partition(" of ")[0], SIGNALS[self.signal].unit
        for ax in axes[:, 0]:
            ax.set_ylabel(f"{text} [{unit}]")
        axes[2, 0].set_xlabel("time [s]")
        return figure, shown.dataset()

    def _runs(self) -> dict[str, Motion]:
        laws = {law: motion(self.effort, "rigid", 2.5, friction=law) for law in LAWS}
        return {**laws, "ideal": motion(self.effort, "ideal", 2.5)}

    def _close_up(self, ax: Axes, shown: Shown, data: Mapping[str, xr.Dataset]) -> None:
        """Both laws about the highest peak of the first."""
        quantity, first = SIGNALS[self.signal], data["coulomb"]
        when = time_of(first)[int(np.abs(values_of(first, self.signal)).argmax())]
        for letter, law in zip("ab", LAWS, strict=True):
            time, values = time_of(data[law]), values_of(data[law], self.signal)
            style = {"color": COLOUR[law], "linewidth": 0.9, "label": LAWS[law]}
            shown.curve(ax, f"{letter}.rigid", self.signal, time, values, quantity, **style)
        room = CLOSE_UP * first.attrs["period"]
        ax.set_xlim(when - room, when + room)
        caption(ax, "", "both, about the highest peak of (a)")
        ax.legend(fontsize="small", loc="best")
