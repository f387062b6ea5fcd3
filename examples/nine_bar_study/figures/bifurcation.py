"""Kind "bifurcation": section points and exponents over the speed or over the clearance."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from nine_bar_study.case import PLAY_MODELS, Case
from nine_bar_study.diagram import diagram, part_of
from nine_bar_study.drawing import COLOURS as MODEL_COLOURS
from nine_bar_study.drawing import Quantity, Shown, caption, named, noted, sheet
from nine_bar_study.effort import Effort
from nine_bar_study.item import StudyFigure
from nine_bar_study.run import Results, StudyRun

from flexmb.show.pictures.diagrams import VERDICT_COLOURS as COLOURS
from flexmb.show.pictures.diagrams import entry_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MANY = 1500
"""Number of points in a panel above which markers are small."""

NEAR_ZERO = (-3.0, 3.0)
"""Limits of the panel of exponents near zero [1/s]."""

CLEARANCE = "clearance of the joint"
"""Entry of the clearance in legends."""

DEVIATION = "deviation"
"""Suffix of a signal less its mean over the turns at each value of the parameter."""


@dataclass(frozen=True)
class Over:
    """Parameter of a bifurcation diagram with its values and constant numbers.

    Parameters
    ----------
    parameter : "speed" or "clearance".
    quantity : name and unit of the parameter.
    values : all values of the parameter [rad/s or m].
    case : case with the constant numbers.
    where : text of the constant speed or clearance.
    rtol : accepted relative error of steps by model, in diagrams with exponents; other diagrams use the default.
    mark : published range of the parameter [unit of the quantity] and its text; None: no range.
    """

    parameter: str
    quantity: Quantity
    values: Sequence[float]
    case: Case
    where: str
    rtol: Mapping[str, float] = field(default_factory=dict)
    mark: tuple[float, float, str] | None = None

    def run(self, effort: Effort, model: str) -> StudyRun:
        """Run of the diagram of a model at an effort."""
        rtol = self.rtol.get(model) if effort.exponents else None
        case = dataclasses.replace(self.case, model=model, rtol=rtol)
        lengths = effort.diagram_settle, effort.diagram_points
        exponent = "points" if effort.exponents else False
        return diagram(case, self.parameter, part_of(self.values, effort.values), *lengths, exponent)


def bifurcation(
    number: int, effort: Effort, over: Over, *, who: str, signals: Mapping[str, Quantity], ideal: Case | None = None
) -> StudyFigure:
    """Bifurcation diagrams of two signals, flexible above rigid mechanism, and largest exponents of both below.

    A diagram over the speed has a panel of the exponents near zero.  A diagram over the clearance has a panel of the
    ranges of the section points.

    Parameters
    ----------
    number : number of the figure.
    effort : lengths of the runs.
    over : parameter of the diagram.
    who : text of the observed body or joint.
    signals : two signals with name and unit, one per column.
    ideal : case whose stroke is the range of the axis of the first signal; None: range of the section points.
    """
    diagrams = {model: over.run(effort, model) for model in reversed(PLAY_MODELS)}
    stroke = None if ideal is None else effort.settled(ideal)
    title = f"Bifurcation diagram of the {who} over {over.quantity.text}, {over.where}"
    runs = (*diagrams.values(), *([] if stroke is None else [stroke]))
    return StudyFigure(number, title, runs, _Drawing(f"Figure {number}: {title}", over, signals, diagrams, stroke))


@dataclass(frozen=True, eq=False)
class _Drawing:
    """Drawing of a bifurcation diagram; the fields are arguments of `bifurcation`."""

    heading: str
    over: Over
    signals: Mapping[str, Quantity]
    diagrams: Mapping[str, StudyRun]
    stroke: StudyRun | None

    def __call__(self, results: Results) -> tuple[Figure, xr.Dataset]:
        import xarray

        data = {model: self._with_deviation(results[run]) for model, run in self.diagrams.items()}
        exponents = all(np.isfinite(found["exponent"].values).any() for found in data.values())
        shown, verdicts = dict[str, Any](), set[str]()
        figure, axes = sheet(self.heading, 3 if exponents else 2, 2, panel=(6.0, 2.9), sharex=True)
        for row, (model, found) in zip(axes, data.items(), strict=False):
            for ax, letter, (signal, quantity) in zip(row, "ab", self.signals.items(), strict=True):
                verdicts |= self._points(ax, shown, model, found, signal)
                caption(ax, letter, f"{quantity.text}, {model}")
                self._marks(ax, found, signal)
        for column, signal in zip(axes.T, self.signals, strict=True):
            self._scale(column[:2], signal, data, results)
        if exponents:
            self._exponents(axes[-1, 0], shown, data)
            if self.over.parameter == "speed":
                self._exponents(axes[-1, 1], shown, data, near=True)
            else:
                self._clouds(axes[-1, 1], shown, data)
        for ax in axes[-1]:
            ax.set_xlabel(self.over.quantity.label)
        _legend(figure, axes, verdicts)
        return figure, xarray.Dataset(shown)

    def _with_deviation(self, found: xr.Dataset) -> xr.Dataset:
        names = [name for name in self.signals if name.endswith(f".{DEVIATION}")]
        places = {name: found[name.removesuffix(f".{DEVIATION}")] for name in names}
        return found.assign({name: place - place.mean("period") for name, place in places.items()})

    def _marks(self, ax: Axes, found: xr.Dataset, signal: str) -> None:
        """Draw the clearance of the joint and the published range of the parameter."""
        across, parameter, case = self.over.quantity, self.over.parameter, self.over.case
        if signal.startswith(f"{case.machine.joint}."):
            values = found[parameter].values
            play = values if parameter == "clearance" else np.full(len(values), case.clearance)
            style: dict[str, Any] = {"color": "0.6", "linewidth": 0.8, "linestyle": "--", "zorder": 1}
            for side in (-1.0, 1.0):
                ax.plot(across.factor * values, side * self.signals[signal].factor * play, label=CLEARANCE, **style)
        self._mark(ax)

    def _mark(self, ax: Axes) -> None:
        if self.over.mark is not None:
            low, high, text = self.over.mark
            ax.axvspan(low, high, color="0.85", zorder=0, label=text)

    def _scale(self, axes: Any, signal: str, data: Mapping[str, xr.Dataset], results: Results) -> None:
        """Set one range of the axis for both models: range of the section points, or stroke of the ideal mechanism."""
        values = [found[signal].values[found["ok"].values] for found in data.values()]
        if signal == next(iter(self.signals)) and self.stroke is not None:
            values = [results[self.stroke][signal].values]
            text, place = f"height: the stroke of the {signal.partition('.')[0]}", axes[0].transAxes
            axes[0].text(0.99, 0.95, text, transform=place, ha="right", va="top", fontsize="small")
        low, high = min(float(v.min()) for v in values), max(float(v.max()) for v in values)
        room, factor = 0.05 * (high - low), self.signals[signal].factor
        for ax in axes:
            ax.set_ylim(factor * (low - room), factor * (high + room))

    def _points(self, ax: Axes, shown: Shown, model: str, found: xr.Dataset, signal: str) -> set[str]:
        """Draw the section points, coloured by verdict; the returned names are the entries of the legend."""
        across, quantity, parameter = self.over.quantity, self.signals[signal], self.over.parameter
        values, points, verdicts = found[parameter].values, found[signal].values, found["verdict"].values
        dim = f"{model}.{parameter}"
        shown[dim] = across.noted(values, dim)
        shown[f"{model}.{signal}"] = noted(points, (dim, "turn"), "m", f"{quantity.text}, once a turn")
        shown[f"{model}.verdict"] = named(verdicts.astype(str), dim, "verdict on the motion")
        good, entries = found["ok"].values, [entry_of(str(verdict)) for verdict in verdicts]
        size = 3.0 if points.size < MANY else 1.8
        style: dict[str, Any] = {"marker": "o", "linestyle": "none", "markersize": size, "markeredgewidth": 0.0}
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

    def _exponents(self, ax: Axes, shown: Shown, data: Mapping[str, xr.Dataset], *, near: bool = False) -> None:
        """Draw the largest exponent of both models with its standard deviation; `near`: limits near zero."""
        across, parameter = self.over.quantity, self.over.parameter
        names = {"exponent": "largest exponent", "exponent_error": "its standard deviation"}
        style: dict[str, Any] = {"fmt": "o-", "markersize": 2.5, "linewidth": 0.7, "elinewidth": 0.9, "capsize": 1.5}
        for model, found in data.items():
            for name, text in names.items():
                shown[f"{model}.{name}"] = noted(found[name].values, f"{model}.{parameter}", "1/s", text)
            x, y = across.factor * found[parameter].values, found["exponent"].values
            ax.errorbar(x, y, found["exponent_error"].values, color=MODEL_COLOURS[model], label=model, **style)
        ax.axhline(0.0, color="black", linewidth=0.8)
        ax.set_ylabel("largest exponent\n[1/s]")
        caption(ax, "", "largest exponent, one standard deviation" if not near else "the same near zero")
        if near:
            ax.set_ylim(*NEAR_ZERO)
        self._mark(ax)
        ax.legend(fontsize="small", loc="upper left")

    def _clouds(self, ax: Axes, shown: Shown, data: Mapping[str, xr.Dataset]) -> None:
        """Draw the range of the section points of the first signal over the clearance."""
        across, (signal, quantity) = self.over.quantity, next(iter(self.signals.items()))
        text = f"largest less smallest {quantity.text}, once a turn"
        for model, found in data.items():
            size = np.where(found["ok"].values, np.ptp(found[signal].values, axis=1), np.nan)
            shown[f"{model}.{signal}.cloud"] = noted(size, f"{model}.{self.over.parameter}", "m", text)
            x, style = across.factor * found[self.over.parameter].values, {"markersize": 2.5, "linewidth": 0.7}
            ax.semilogy(x, 1e6 * size, "o-", color=MODEL_COLOURS[model], label=model, **style)
        ax.set_ylabel("size of the cloud\n[µm]")
        caption(ax, "", text)
        ax.legend(fontsize="small", loc="lower right")


def _legend(figure: Figure, axes: Any, verdicts: set[str]) -> None:
    """Draw the legend: colours of the verdicts, lines, and crosses of failed values."""
    from matplotlib.lines import Line2D

    style: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 6.0}
    names = [name for name in COLOURS if name in verdicts]
    handles: list[Any] = [Line2D([], [], color=COLOURS[name], label=name or "no verdict", **style) for name in names]
    others: dict[str, Any] = {}
    for ax in axes[:2].flat:
        others |= {text: handle for handle, text in zip(*ax.get_legend_handles_labels(), strict=True)}
    handles += others.values()
    figure.legend(handles=handles, loc="outside lower center", fontsize="small", ncols=len(handles), frameon=False)
