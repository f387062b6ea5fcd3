"""Figures 23, 27, 40 and 44: bifurcation diagrams over clearance and over speed, of the joint and of the slider."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.paper.curves import motion
from flexmb.paper.diagram import Diagram
from flexmb.paper.drawing import COLOURS as MODELS
from flexmb.paper.drawing import Quantity, Shown, caption, sheet
from flexmb.paper.effort import Effort
from flexmb.paper.motion import Motion
from flexmb.paper.plate import Plate, Results, Run
from flexmb.view.bifurcation import COLOURS, entry_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PARAMETERS = {
    "clearance": Quantity("clearance", "mm", 1e3),
    "speed": Quantity("speed of the cranks", "π rad/s", 1.0 / math.pi),
}
WHERE = {"clearance": "2π rad/s", "speed": "clearance 0.5 mm"}
SIGNALS = {
    "P1.ex": Quantity("journal along X", "mm", 1e3),
    "P1.ey": Quantity("journal along Y", "mm", 1e3),
    "slider.x": Quantity("slider", "mm", 1e3),
    "slider.x.deviation": Quantity("slider, less the ideal one", "µm", 1e6),
}
THRESHOLD = (1.6, 1.65)
"""Speeds of the paper between which the joint's motion becomes chaotic [pi rad/s]."""


def plates(effort: Effort) -> tuple[Plate, ...]:
    """The bifurcation diagrams.

    Parameters
    ----------
    effort : how long the motions are, and how many values there are.
    """
    clearance, speed = (
        {name: Diagram.at(over, effort, flexible=name == "flexible") for name in ("flexible", "rigid")}
        for over in ("clearance", "speed")
    )
    ideal = motion(effort, "ideal", 2.0)
    found = [
        Figures(23, "clearance", ("P1.ex", "P1.ey"), clearance),
        Figures(27, "clearance", ("slider.x", "slider.x.deviation"), clearance, ideal),
        Figures(40, "speed", ("P1.ex", "P1.ey"), speed),
        Figures(44, "speed", ("slider.x", "slider.x.deviation"), speed, ideal),
    ]
    return tuple(one.plate for one in found)


@dataclass(frozen=True, eq=False)
class Figures:
    """A bifurcation diagram: two signals, the flexible mechanism above the rigid one, and below both the exponents.

    Parameters
    ----------
    number : of the figure.
    parameter : over which it is drawn.
    signals : of the two columns.
    diagrams : by model.
    ideal : motion from whose last instant, a whole number of turns after the start, the ideal place of the slider is
        taken; it is the same at all speeds.
    """

    number: int
    parameter: str
    signals: tuple[str, str]
    diagrams: dict[str, Diagram]
    ideal: Motion | None = None

    @property
    def plate(self) -> Plate:
        """The figure."""
        who = "clearance joint" if self.ideal is None else "slider"
        title = f"Bifurcation diagram of the {who} over {PARAMETERS[self.parameter].text}, {WHERE[self.parameter]}"
        others: tuple[Run, ...] = () if self.ideal is None else (self.ideal,)
        return Plate(self.number, title, (*self.diagrams.values(), *others), self.draw)

    def draw(self, results: Results) -> tuple[Figure, xr.Dataset]:
        """The picture and its data.

        Parameters
        ----------
        results : of the diagrams.
        """
        data = {model: self._with_deviation(results[run], results) for model, run in self.diagrams.items()}
        exponents = all(np.isfinite(found["exponent"].values).any() for found in data.values())
        shown = Shown()
        figure, axes = sheet(
            f"Figure {self.number}: {self.plate.title}", 3 if exponents else 2, 2, panel=(6.0, 2.9), sharex=True
        )
        verdicts = set[str]()
        for row, (model, found) in zip(axes, data.items(), strict=False):
            for ax, letter, signal in zip(row, "ab", self.signals, strict=True):
                verdicts |= _points(ax, shown, model, found, self.parameter, signal)
                caption(ax, letter, f"{SIGNALS[signal].text}, {model}")
                self._bounds(ax, data[model], signal)
        if exponents:
            _exponents(axes[-1, 0], shown, data, self.parameter)
            _exponents(axes[-1, 1], shown, data, self.parameter, near=True)
        for ax in axes[-1]:
            ax.set_xlabel(PARAMETERS[self.parameter].label)
        _legend(figure, verdicts)
        return figure, shown.dataset()

    def _with_deviation(self, found: xr.Dataset, results: Results) -> xr.Dataset:
        """With the slider's place less that of the ideal mechanism at the same angle of the cranks."""
        if self.ideal is None:
            return found
        there = float(results[self.ideal]["slider.x"].values[-1])
        return found.assign({"slider.x.deviation": found["slider.x"] - there})

    def _bounds(self, ax: Axes, found: xr.Dataset, signal: str) -> None:
        """What the play leaves the journal; the paper's threshold."""
        if signal.startswith("P1."):
            values = found[self.parameter].values
            play = values if self.parameter == "clearance" else np.full(len(values), 0.5e-3)
            for side in (-1.0, 1.0):
                ax.plot(
                    PARAMETERS[self.parameter].factor * values,
                    side * 1e3 * play,
                    color="0.6",
                    linewidth=0.8,
                    linestyle="--",
                    zorder=1,
                )
        if self.parameter == "speed":
            ax.axvspan(*THRESHOLD, color="0.85", zorder=0)


def _points(ax: Axes, shown: Shown, model: str, found: xr.Dataset, parameter: str, signal: str) -> set[str]:
    """The points of the section, by verdict; the entries of the legend that occur."""
    across, quantity = PARAMETERS[parameter], SIGNALS[signal]
    values, points = found[parameter].values, found[signal].values
    note = {"units": "m", "long_name": f"{quantity.text}, once a turn"}
    shown.note(f"{model}.{parameter}", (f"{model}.{parameter}",), values, units=found[parameter].attrs.get("units", ""))
    shown.note(f"{model}.{signal}", (f"{model}.{parameter}", "turn"), points, **note)
    shown.note(
        f"{model}.verdict",
        (f"{model}.{parameter}",),
        found["verdict"].values.astype(str),
        long_name="verdict on the motion",
    )
    entries = [entry_of(str(verdict)) for verdict in found["verdict"].values]
    size = 3.0 if points.size < 1500 else 1.8
    for entry in dict.fromkeys(entries):
        chosen = np.array([entry == other for other in entries]) & found["ok"].values
        x = np.repeat(across.factor * values[chosen], points.shape[1])
        ax.plot(
            x,
            quantity.factor * points[chosen].ravel(),
            "o",
            color=COLOURS[entry],
            markersize=size,
            markeredgewidth=0.0,
            gid=f"{model}.{signal}|{entry}",
            zorder=2,
        )
    failed = across.factor * values[~found["ok"].values]
    ax.plot(failed, np.full(len(failed), 0.03), "x", color="black", transform=ax.get_xaxis_transform(), gid="failed")
    ax.set_ylabel(f"{quantity.text}\n[{quantity.unit}]")
    ax.ticklabel_format(axis="y", useOffset=False)
    return set(entries)


def _exponents(ax: Axes, shown: Shown, data: dict[str, Any], parameter: str, *, near: bool = False) -> None:
    """The largest exponent of both models with its error; `near` zero once more."""
    across = PARAMETERS[parameter]
    for model, found in data.items():
        for name in ("exponent", "exponent_error"):
            shown.note(f"{model}.{name}", (f"{model}.{parameter}",), found[name].values, units="1/s")
        x, y = across.factor * found[parameter].values, found["exponent"].values
        ax.errorbar(
            x,
            y,
            found["exponent_error"].values,
            color=MODELS[model],
            fmt="o-",
            markersize=2.5,
            linewidth=0.7,
            elinewidth=0.9,
            capsize=1.5,
            label=model,
        )
    ax.axhline(0.0, color="black", linewidth=0.8)
    ax.set_ylabel("largest exponent\n[1/s]")
    caption(ax, "", "largest exponent, one standard deviation" if not near else "the same near zero")
    if near:
        ax.set_ylim(-3.0, 3.0)
    if parameter == "speed":
        ax.axvspan(*THRESHOLD, color="0.85", zorder=0, label="threshold of the paper")
    ax.legend(fontsize="small", loc="upper left")


def _legend(figure: Figure, verdicts: set[str]) -> None:
    """Colours of the verdicts that occur."""
    from matplotlib.lines import Line2D

    style: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 6.0}
    names = [name for name in COLOURS if name in verdicts]
    handles = [Line2D([], [], color=COLOURS[name], label=name or "no verdict", **style) for name in names]
    handles.append(Line2D([], [], color="0.6", linestyle="--", label="play of the joint"))
    figure.legend(handles=handles, loc="outside right upper", fontsize="small", frameon=False)
