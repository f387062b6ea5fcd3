"""Figures 6-16 and 28-33: the motion over the last turns: slider, torques, contact force, path of the shaft centre."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexmb.paper.case import MODELS, Case
from flexmb.paper.drawing import COLOURS, Quantity, Shown, caption, sheet, turns_above
from flexmb.paper.effort import Effort
from flexmb.paper.motion import Motion
from flexmb.paper.plate import Plate, Results

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIGNALS = {
    "slider.x": Quantity("displacement of the slider", "mm", 1e3),
    "slider.vx": Quantity("velocity of the slider", "m/s"),
    "slider.ax": Quantity("acceleration of the slider", "m/s²"),
    "motor1.torque": Quantity("driving torque of crank 1", "N m"),
    "motor4.torque": Quantity("driving torque of crank 4", "N m"),
    "P1.force": Quantity("contact force at P1", "N"),
    "P1.penetration": Quantity("penetration at P1", "µm", 1e6),
}
DEVIATIONS = {
    "slider.x": ("slider.vx", Quantity("deviation from the ideal mechanism", "µm", 1e6)),
    "slider.vx": ("slider.ax", Quantity("deviation from the ideal mechanism", "mm/s", 1e3)),
}
"""Signals that hardly differ: the rate by which the ideal one is interpolated, and how the difference is drawn."""

PATH = {"P1.ex": Quantity("journal along X", "µm", 1e6), "P1.ey": Quantity("journal along Y", "µm", 1e6)}
LAWS = {"coulomb": "modified Coulomb friction", "lugre": "LuGre friction"}
DWARFED = 10.0
"""How many times as large as the ideal mechanism's a peak is that makes a second panel necessary."""

ROOM = 1.6
"""Height of that panel over what the ideal curve needs of it."""

LINES = {
    "rigid": {"linewidth": 0.5, "alpha": 0.85},
    "flexible": {"linewidth": 0.6, "alpha": 0.8},
    "ideal": {"linewidth": 1.2},
}
"""In the order of drawing: what has the highest peaks lies under the others."""

CLOSE_UP = 0.05
"""Part of a turn that is drawn enlarged before and after the highest peak."""


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
    runs: dict[str, Motion]


def plates(effort: Effort) -> tuple[Plate, ...]:
    """The figures of motions.

    Parameters
    ----------
    effort : how long the motions are.
    """
    clearance = [
        _panel(effort, k, 2.0, play, f"clearance {1e3 * play:g} mm") for k, play in zip("ab", (5e-5, 5e-4), strict=True)
    ]
    speed = [_panel(effort, k, speed, 5e-4, f"{speed:g}π rad/s") for k, speed in zip("ab", (0.5, 2.5), strict=True)]
    kinds = ("slider.x", "slider.vx", "slider.ax", "motor1.torque", "motor4.torque", "P1.force", "P1.penetration")
    found = [Friction(number, kind, effort).plate for number, kind in zip((6, 7, 8), kinds[2:5], strict=True)]
    found += [
        Comparison(number, kind, tuple(clearance), "2π rad/s").plate
        for number, kind in zip(range(9, 16), kinds, strict=True)
    ]
    found += [Path(16, tuple(clearance), "2π rad/s").plate]
    found += [
        Comparison(number, kind, tuple(speed), "clearance 0.5 mm").plate
        for number, kind in zip(range(28, 33), kinds[1:6], strict=True)
    ]
    return (*found, Path(33, tuple(speed), "clearance 0.5 mm").plate)


def _panel(effort: Effort, letter: str, speed: float, clearance: float, text: str) -> Panel:
    runs = {model: motion(effort, model, speed, clearance) for model in MODELS}
    return Panel(letter, text, runs)


def motion(effort: Effort, model: str, speed: float, clearance: float = 0.5e-3, friction: str = "coulomb") -> Motion:
    """The motion of a case at an effort.

    Parameters
    ----------
    effort : how long it is.
    model, speed, clearance, friction : of the case; an ideal mechanism is one, whatever its clearance.
    """
    case = Case(model=model, speed=speed, friction=friction, **({} if model == "ideal" else {"clearance": clearance}))
    return Motion(case, effort.skip, effort.keep, effort.shown)


@dataclass(frozen=True)
class Comparison:
    """A signal of the ideal, the rigid and the flexible mechanism, and below it what cannot be seen on its scale.

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
        title = f"{SIGNALS[self.signal].text.capitalize().replace('p1', 'P1')}, {self.where}"
        runs = dict.fromkeys(run for panel in self.panels for run in self._runs(panel).values())
        return Plate(self.number, title, tuple(runs), self.draw)

    def draw(self, results: Results) -> tuple[Figure, xr.Dataset]:
        """The picture and its data.

        Parameters
        ----------
        results : of the motions.
        """
        found = [{model: results[run] for model, run in self._runs(panel).items()} for panel in self.panels]
        quantity, shown = SIGNALS[self.signal], Shown()
        closer = self.signal in DEVIATIONS or any(_ratio(data, self.signal) > DWARFED for data in found)
        figure, axes = sheet(
            f"Figure {self.number}: {self.plate.title}",
            2 if closer else 1,
            len(found),
            panel=(6.2, 3.1 if closer else 4.0),
            sharex="col",
        )
        for column, panel, data in zip(axes.T, self.panels, found, strict=True):
            caption(column[0], panel.letter, panel.text)
            _curves(column[0], shown, panel.letter, self.signal, data)
            turns_above(column[0], next(iter(data.values())).attrs["period"])
            if self.signal in DEVIATIONS:
                _deviations(column[1], shown, panel.letter, self.signal, data)
            elif closer:
                _closer(column[1], shown, panel.letter, self.signal, data)
            column[-1].set_xlabel("time [s]")
        axes[0, 0].set_ylabel(quantity.label)
        return figure, shown.dataset()

    def _runs(self, panel: Panel) -> dict[str, Motion]:
        """An ideal mechanism has no penetration."""
        return {model: run for model, run in panel.runs.items() if model != "ideal" or self.signal != "P1.penetration"}


def _curves(ax: Axes, shown: Shown, letter: str, signal: str, data: dict[str, xr.Dataset]) -> None:
    """The signal of all models, with the largest absolute value of each in the legend."""
    quantity = SIGNALS[signal]
    for model in [name for name in LINES if name in data]:
        values = _values(data[model], signal)
        text = (
            model
            if signal in DEVIATIONS
            else f"{model}, at most {quantity.factor * np.abs(values).max():.3g} {quantity.unit}"
        )
        shown.curve(
            ax,
            f"{letter}.{model}",
            signal,
            _time(data[model]),
            values,
            quantity,
            color=COLOURS[model],
            label=text,
            **LINES[model],
        )
    _ends(ax, data)
    _legend(ax, data)


def _closer(ax: Axes, shown: Shown, letter: str, signal: str, data: dict[str, xr.Dataset]) -> None:
    """The same, as high as the ideal curve is."""
    _curves(ax, shown, letter, signal, data)
    ax.get_legend().remove()
    values = SIGNALS[signal].factor * _values(data["ideal"], signal)
    middle, half = 0.5 * (values.max() + values.min()), 0.5 * np.ptp(values)
    ax.set_ylim(middle - ROOM * half, middle + ROOM * half)
    ax.set_ylabel(f"on the scale of the ideal\nmechanism [{SIGNALS[signal].unit}]")


def _deviations(ax: Axes, shown: Shown, letter: str, signal: str, data: dict[str, xr.Dataset]) -> None:
    """The difference from the ideal curve."""
    from scipy.interpolate import CubicHermiteSpline

    rate, quantity = DEVIATIONS[signal]
    ideal = data["ideal"]
    exact = CubicHermiteSpline(_time(ideal), _values(ideal, signal), _values(ideal, rate))
    for model in [name for name in LINES if name in data and name != "ideal"]:
        time = _time(data[model])
        difference = _values(data[model], signal) - exact(time)
        most = quantity.factor * np.abs(difference).max()
        shown.curve(
            ax,
            f"{letter}.{model}",
            f"{signal}.deviation",
            time,
            difference,
            quantity,
            color=COLOURS[model],
            label=f"{model}, at most {most:.3g} {quantity.unit}",
            **LINES[model],
        )
    ax.axhline(0.0, color="black", linewidth=0.8)
    ax.set_ylabel(f"deviation from the ideal\nmechanism [{quantity.unit}]")
    _ends(ax, data)
    _legend(ax, data)


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
        title = f"{SIGNALS[self.signal].text.capitalize()}, rigid links, 2.5π rad/s, clearance 0.5 mm"
        return Plate(self.number, title, tuple(self._runs().values()), self.draw)

    def draw(self, results: Results) -> tuple[Figure, xr.Dataset]:
        """The picture and its data.

        Parameters
        ----------
        results : of the motions.
        """
        data = {name: results[run] for name, run in self._runs().items()}
        quantity, shown = SIGNALS[self.signal], Shown()
        figure, axes = sheet(f"Figure {self.number}: {self.plate.title}", 3, 1, panel=(9.0, 2.6))
        for ax, letter, law in zip(axes[:, 0], "ab", LAWS, strict=False):
            caption(ax, letter, LAWS[law])
            _curves(ax, shown, letter, self.signal, {"rigid": data[law], "ideal": data["ideal"]})
            ax.set_ylabel(f"{quantity.text.partition(' of ')[0]} [{quantity.unit}]")
        high = max(abs(bound) for ax in axes[:2, 0] for bound in ax.get_ylim())
        for ax in axes[:2, 0]:
            ax.set_ylim(-high, high)
        turns_above(axes[0, 0], data["ideal"].attrs["period"])
        self._close_up(axes[2, 0], shown, data)
        axes[2, 0].set_xlabel("time [s]")
        return figure, shown.dataset()

    def _runs(self) -> dict[str, Motion]:
        laws = {law: motion(self.effort, "rigid", 2.5, friction=law) for law in LAWS}
        return {**laws, "ideal": motion(self.effort, "ideal", 2.5)}

    def _close_up(self, ax: Axes, shown: Shown, data: dict[str, xr.Dataset]) -> None:
        """Both laws about the highest peak of the first."""
        quantity, first = SIGNALS[self.signal], data["coulomb"]
        when = _time(first)[int(np.abs(_values(first, self.signal)).argmax())]
        colours = {"coulomb": COLOURS["rigid"], "lugre": "#8e44ad"}
        for letter, law in zip("ab", LAWS, strict=True):
            shown.curve(
                ax,
                f"{letter}.rigid",
                self.signal,
                _time(data[law]),
                _values(data[law], self.signal),
                quantity,
                color=colours[law],
                linewidth=0.9,
                label=LAWS[law],
            )
        room = CLOSE_UP * first.attrs["period"]
        ax.set_xlim(when - room, when + room)
        caption(ax, "", "both, about the highest peak of (a)")
        ax.set_ylabel(f"{quantity.text.partition(' of ')[0]} [{quantity.unit}]")
        ax.legend(fontsize="small", loc="upper right")


@dataclass(frozen=True)
class Path:
    """The path of the shaft centre in the bearing: rigid above, flexible below.

    Parameters
    ----------
    number : of the figure.
    panels : columns.
    where : what they have in common.
    """

    number: int
    panels: tuple[Panel, ...]
    where: str

    @property
    def plate(self) -> Plate:
        """The figure."""
        runs = dict.fromkeys(panel.runs[model] for panel in self.panels for model in ("rigid", "flexible"))
        return Plate(self.number, f"Path of the shaft centre at P1, {self.where}", tuple(runs), self.draw)

    def draw(self, results: Results) -> tuple[Figure, xr.Dataset]:
        """The picture and its data.

        Parameters
        ----------
        results : of the motions.
        """
        shown = Shown()
        figure, axes = sheet(f"Figure {self.number}: {self.plate.title}", 2, 2, panel=(5.0, 4.9))
        for column, panel in zip(axes.T, self.panels, strict=True):
            for ax, model in zip(column, ("rigid", "flexible"), strict=True):
                _path(ax, shown, f"{panel.letter}.{model}", results[panel.runs[model]], panel.runs[model].case)
                caption(ax, panel.letter, f"{panel.text}, {model}")
        for ax in axes[-1]:
            ax.set_xlabel(PATH["P1.ex"].label)
        for ax in axes[:, 0]:
            ax.set_ylabel(PATH["P1.ey"].label)
        axes[0, 0].legend(fontsize="small", loc="upper left", bbox_to_anchor=(0.0, 1.0))
        return figure, shown.dataset()


def _path(ax: Axes, shown: Shown, group: str, data: xr.Dataset, case: Case) -> None:
    """One path: all of it thin, what is in contact over it, the circle that the clearance leaves."""
    from matplotlib.patches import Circle

    model = group.partition(".")[2]
    time, touching = _time(data), data["P1.penetration"].values > 0.0
    for signal, quantity in PATH.items():
        shown.note(f"{group}.{signal}", (group,), data[signal].values, units="m", long_name=quantity.text)
    shown.note(group, (group,), time, units="s", long_name="time from the first instant shown")
    shown.note(f"{group}.contact", (group,), touching, long_name="whether journal and bearing touch")
    x, y = (1e6 * data[signal].values for signal in PATH)
    ax.plot(x, y, color="0.6", linewidth=0.5, label="free flight", gid=f"{group}.path")
    ax.plot(
        np.where(touching, x, np.nan),
        np.where(touching, y, np.nan),
        color=COLOURS[model],
        linewidth=1.0,
        label="contact",
        gid=f"{group}.touching",
    )
    ax.add_patch(
        Circle(
            (0.0, 0.0),
            1e6 * case.clearance,
            fill=False,
            color="black",
            linewidth=0.7,
            linestyle="--",
            label="clearance",
        )
    )
    share = np.diff(time)[~touching[1:]].sum() / (time[-1] - time[0])
    ax.text(
        0.5,
        0.5,
        f"{100.0 * share:.0f} % of the time\nin free flight",
        transform=ax.transAxes,
        ha="center",
        va="center",
        fontsize="small",
        bbox={"facecolor": "white", "alpha": 0.8, "linewidth": 0.0},
    )
    ax.set_aspect("equal")


def _time(data: xr.Dataset) -> np.ndarray:
    """From the first instant that is shown [s]."""
    time = data["time"].values
    return time - time[0]


def _values(data: xr.Dataset, signal: str) -> np.ndarray:
    """A signal as it is drawn: there is no negative penetration."""
    values = data[signal].values
    return np.maximum(values, 0.0) if signal == "P1.penetration" else values


def _ratio(data: dict[str, xr.Dataset], signal: str) -> float:
    """How many times as high as the ideal curve the highest one is; 0 where there is none to compare with."""
    if "ideal" not in data:
        return 0.0
    peaks = {model: float(np.abs(_values(found, signal)).max()) for model, found in data.items()}
    return max(peaks.values()) / max(peaks["ideal"], 1e-300)


def _ends(ax: Axes, data: dict[str, xr.Dataset]) -> None:
    ax.set_xlim(0.0, max(float(_time(found)[-1]) for found in data.values()))


def _legend(ax: Axes, data: dict[str, xr.Dataset]) -> None:
    """In the order of the models, with lines that can be seen."""
    handles, texts = ax.get_legend_handles_labels()
    order: Sequence[int] = sorted(
        range(len(texts)), key=lambda k: [m for m in (*MODELS,)].index(texts[k].partition(",")[0])
    )
    box = ax.legend(
        [handles[k] for k in order], [texts[k] for k in order], fontsize="small", loc="upper right", framealpha=0.85
    )
    for line in box.get_lines():
        line.set_linewidth(1.6)
