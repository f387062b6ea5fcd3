"""Figures 16 and 33: the path of the shaft centre in the bearing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexmb.paper.curves import Panel, clearance_panels, speed_panels, time_of
from flexmb.paper.drawing import COLOURS, Quantity, Shown, caption, sheet
from flexmb.paper.effort import Effort
from flexmb.paper.plate import Plate, Results

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PATH = {"P1.ex": Quantity("journal along X", "µm", 1e6), "P1.ey": Quantity("journal along Y", "µm", 1e6)}
WITH_PLAY = ("rigid", "flexible")


def plates(effort: Effort) -> tuple[Plate, ...]:
    """The figures of paths.

    Parameters
    ----------
    effort : how long the motions are.
    """
    first = Path(16, clearance_panels(effort), "2π rad/s")
    return first.plate, Path(33, speed_panels(effort), "clearance 0.5 mm").plate


@dataclass(frozen=True, eq=False)
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
        runs = dict.fromkeys(panel.runs[model] for panel in self.panels for model in WITH_PLAY)
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
            for ax, model in zip(column, WITH_PLAY, strict=True):
                run = panel.runs[model]
                share = _path(ax, shown, f"{panel.letter}.{model}", results[run], run.case.clearance)
                caption(ax, panel.letter, f"{panel.text}, {model}: {100.0 * share:.2g} % of the time in flight")
        for ax in axes[-1]:
            ax.set_xlabel(PATH["P1.ex"].label)
        for ax in axes[:, 0]:
            ax.set_ylabel(PATH["P1.ey"].label)
        entries = dict(zip(*reversed(axes[0, 0].get_legend_handles_labels()), strict=True))
        entries |= dict(zip(*reversed(axes[1, 0].get_legend_handles_labels()), strict=True))
        figure.legend(entries.values(), entries, fontsize="small", loc="outside lower center", ncols=len(entries))
        return figure, shown.dataset()


def _path(ax: Axes, shown: Shown, group: str, data: xr.Dataset, clearance: float) -> float:
    """One path: all of it thin, what is in contact over it, the circle of the clearance; the share of free flight."""
    model, time, touching = group.partition(".")[2], time_of(data), data["P1.penetration"].values > 0.0
    shown.note(group, (group,), time, units="s", long_name="time from the first instant shown")
    for signal, quantity in PATH.items():
        shown.note(f"{group}.{signal}", (group,), data[signal].values, units="m", long_name=quantity.text)
    shown.note(f"{group}.contact", (group,), touching, long_name="whether journal and bearing touch")
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    circle = 1e6 * clearance * np.cos(angle), 1e6 * clearance * np.sin(angle)
    ax.plot(*circle, color="black", linewidth=0.7, linestyle="--", label="circle of the clearance")
    x, y = (1e6 * data[signal].values for signal in PATH)
    ax.plot(x, y, color="0.6", linewidth=0.5, label="free flight", gid=f"{group}.P1.ex|{group}.P1.ey")
    held = np.where(touching, x, np.nan), np.where(touching, y, np.nan)
    ax.plot(*held, color=COLOURS[model], linewidth=1.0, label=f"contact, {model}", gid=f"{group}.contact")
    ax.set_aspect("equal")
    return float(np.diff(time)[~touching[1:]].sum() / (time[-1] - time[0]))
