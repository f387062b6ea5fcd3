"""Figures 23, 27, 40 and 44: bifurcation diagrams over clearance and over speed, of the joint and of the slider."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.paper.curves import motion
from flexmb.paper.diagram import FIXED, Diagram
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
    "slider.x": Quantity("place of the slider", "mm", 1e3),
    "slider.x.deviation": Quantity("slider less its mean", "µm", 1e6),
}
MANY = 1500
"""Points of a panel from which on markers are small."""

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

    Beside the exponents: over the speed the same near zero, where the sign changes; over the clearance, where it does
    not, the size of the clouds, which on the scale of the diagram look like one point when the play is small.

    Parameters
    ----------
    number : of the figure.
    parameter : over which it is drawn.
    signals : of the two columns.
    diagrams : by model.
    ideal : motion whose stroke is the scale of the slider's place; None: a figure of the joint.
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
        data = {model: self._with_deviation(results[run]) for model, run in self.diagrams.items()}
        exponents = all(np.isfinite(found["exponent"].values).any() for found in data.values())
        shown, verdicts, rows = Shown(), set[str](), 3 if exponents else 2
        title = f"Figure {self.number}: {self.plate.title}"
        figure, axes = sheet(title, rows, 2, panel=(6.0, 2.9), sharex=True)
        for row, (model, found) in zip(axes, data.items(), strict=False):
            for ax, letter, signal in zip(row, "ab", self.signals, strict=True):
                verdicts |= _points(ax, shown, model, found, self.parameter, signal)
                caption(ax, letter, f"{SIGNALS[signal].text}, {model}")
                self._marks(ax, found, signal)
        for column, signal in zip(axes.T, self.signals, strict=True):
            self._scale(column[:2], signal, data, results)
        if exponents:
            _exponents(axes[-1, 0], shown, data, self.parameter)
            if self.parameter == "speed":
                _exponents(axes[-1, 1], shown, data, self.parameter, near=True)
            else:
                _clouds(axes[-1, 1], shown, data, self.signals[0])
        for ax in axes[-1]:
            ax.set_xlabel(PARAMETERS[self.parameter].label)
        _legend(figure, axes, verdicts)
        return figure, shown.dataset()

    def _with_deviation(self, found: xr.Dataset) -> xr.Dataset:
        """With the slider's place less its mean over the turns at each value: the size of the cloud."""
        if self.ideal is None:
            return found
        return found.assign({"slider.x.deviation": found["slider.x"] - found["slider.x"].mean("period")})

    def _marks(self, ax: Axes, found: xr.Dataset, signal: str) -> None:
        """What the play leaves the journal; the paper's threshold."""
        across = PARAMETERS[self.parameter]
        if signal.startswith("P1."):
            values = found[self.parameter].values
            play = values if self.parameter == "clearance" else np.full(len(values), FIXED["speed"]["clearance"])
            style = {"color": "0.6", "linewidth": 0.8, "linestyle": "--", "zorder": 1, "label": "play of the joint"}
            for side in (-1.0, 1.0):
                ax.plot(across.factor * values, side * SIGNALS[signal].factor * play, **style)
        if self.parameter == "speed":
            ax.axvspan(*THRESHOLD, color="0.85", zorder=0, label="threshold of the paper")

    def _scale(self, axes: Any, signal: str, data: Mapping[str, xr.Dataset], results: Results) -> None:
        """One scale for both models: that of the points, for the slider that of its stroke."""
        values = [found[signal].values[found["ok"].values] for found in data.values()]
        if signal == "slider.x" and self.ideal is not None:
            values = [results[self.ideal]["slider.x"].values]
            axes[0].text(
                0.99,
                0.95,
                "height: the stroke of the slider",
                transform=axes[0].transAxes,
                ha="right",
                va="top",
                fontsize="small",
            )
        low, high = min(float(v.min()) for v in values), max(float(v.max()) for v in values)
        room = 0.05 * (high - low)
        for ax in axes:
            ax.set_ylim(SIGNALS[signal].factor * (low - room), SIGNALS[signal].factor * (high + room))


def _points(ax: Axes, shown: Shown, model: str, found: xr.Dataset, parameter: str, signal: str) -> set[str]:
    """The points of the section, by verdict; the entries of the legend that occur."""
    across, quantity = PARAMETERS[parameter], SIGNALS[signal]
    values, points = found[parameter].values, found[signal].values
    note = {"units": "m", "long_name": f"{quantity.text}, once a turn"}
    shown.note(f"{model}.{parameter}", (f"{model}.{parameter}",), values, **across.noted)
    shown.note(f"{model}.{signal}", (f"{model}.{parameter}", "turn"), points, **note)
    shown.note(
        f"{model}.verdict",
        (f"{model}.{parameter}",),
        found["verdict"].values.astype(str),
        long_name="verdict on the motion",
    )
    good = found["ok"].values
    entries = [entry_of(str(verdict)) for verdict in found["verdict"].values]
    style = {
        "marker": "o",
        "linestyle": "none",
        "markersize": 3.0 if points.size < MANY else 1.8,
        "markeredgewidth": 0.0,
    }
    for entry in dict.fromkeys(entry for entry, ok in zip(entries, good, strict=True) if ok):
        chosen = np.array([entry == other for other in entries]) & good
        x = np.repeat(across.factor * values[chosen], points.shape[1])
        y = quantity.factor * points[chosen].ravel()
        ax.plot(x, y, color=COLOURS[entry], gid=f"{model}.{signal}|{entry}", zorder=2, **style)
    if not good.all():
        failed = across.factor * values[~good]
        style = {"color": "black", "transform": ax.get_xaxis_transform(), "label": "failed"}
        ax.plot(failed, np.full(len(failed), 0.03), "x", **style)
    ax.set_ylabel(f"{quantity.text}\n[{quantity.unit}]")
    ax.ticklabel_format(axis="y", useOffset=False)
    return {entry for entry, ok in zip(entries, good, strict=True) if ok}


def _exponents(ax: Axes, shown: Shown, data: dict[str, Any], parameter: str, *, near: bool = False) -> None:
    """The largest exponent of both models with its error; `near` zero once more."""
    across = PARAMETERS[parameter]
    names = {"exponent": "largest exponent", "exponent_error": "its standard deviation"}
    for model, found in data.items():
        for name, text in names.items():
            shown.note(f"{model}.{name}", (f"{model}.{parameter}",), found[name].values, units="1/s", long_name=text)
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


def _clouds(ax: Axes, shown: Shown, data: Mapping[str, xr.Dataset], signal: str) -> None:
    """Over the clearance, how far the points of a signal are apart."""
    across, name = PARAMETERS["clearance"], SIGNALS[signal].text
    for model, found in data.items():
        size = np.where(found["ok"].values, np.ptp(found[signal].values, axis=1), np.nan)
        note = {"units": "m", "long_name": f"largest less smallest {name}, once a turn"}
        shown.note(f"{model}.{signal}.cloud", (f"{model}.clearance",), size, **note)
        x = across.factor * found["clearance"].values
        ax.semilogy(x, 1e6 * size, "o-", color=MODELS[model], markersize=2.5, linewidth=0.7, label=model)
    ax.set_ylabel("size of the cloud\n[µm]")
    caption(ax, "", f"largest less smallest {name}, once a turn")
    ax.legend(fontsize="small", loc="lower right")


def _legend(figure: Figure, axes: Any, verdicts: set[str]) -> None:
    """Colours of the verdicts that occur, and the lines and crosses that there are."""
    from matplotlib.lines import Line2D

    style: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 6.0}
    names = [name for name in COLOURS if name in verdicts]
    handles: list[Any] = [Line2D([], [], color=COLOURS[name], label=name or "no verdict", **style) for name in names]
    others: dict[str, Any] = {}
    for ax in axes[:2].flat:
        others |= {text: handle for handle, text in zip(*ax.get_legend_handles_labels(), strict=True)}
    handles += others.values()
    figure.legend(handles=handles, loc="outside lower center", fontsize="small", ncols=len(handles), frameon=False)
