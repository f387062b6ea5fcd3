"""Kind "section" of figures: Poincare sections.

The upper panel has the scale of the motion, the lower panel the scale of the section points.  The points of a chaotic
motion may coincide in the upper panel and differ by micrometres in the lower panel.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from nine_bar_study.drawing import Observable, Shown, length_text, noted
from nine_bar_study.figures.contrast import COLOUR, observed
from nine_bar_study.run import StudyRun

from flexmb.dynamics.verdict import SEPARATE

if TYPE_CHECKING:
    import xarray as xr

SMALLEST = 1e-6
"""Least range of a close-up over the range of the motion; smaller ranges are within the errors of the integration."""

ROOM = 1.15
"""Range of a close-up over the range of the section points."""

UNITS = ((1e3, "mm", "m/s", 1.0), (1e6, "µm", "mm/s", 1e3), (1e9, "nm", "µm/s", 1e6))
"""Units of close-ups: (factor from m, unit, unit of the velocity, factor from m/s)."""


def column(axes: Any, shown: Shown, letter: str, observable: Observable, run: StudyRun, result: xr.Dataset) -> None:
    """Draw the section points on the phase curve, and a close-up of the points below.

    Parameters
    ----------
    axes : (2,) axes of the case.
    shown : variables of the dataset; the variables of the case are added.
    letter : letter of the case.
    observable : coordinate and velocity.
    run, result : long run of the case, and its result.
    """
    names = (observable.place, observable.rate)
    curve = [result[f"step.{name}"].values for name in names]
    points = [result[f"section.{name}"].values for name in names]
    _whole(axes[0], observable, curve, points)
    noise = float(result[f"section.{observable.place}"].attrs.get("resolution", 0.0))
    same = np.ptp(points[0]) < SEPARATE * noise
    verdict = str(result.attrs[f"verdict.{observable.place}"])
    verdict += "\none point but for errors of the steps" if same else ""
    _close_up(axes[1], observable, curve, points, verdict)
    for name, units, along, at in zip(names, ("m", "m/s"), curve, points, strict=True):
        shown[f"{letter}.{name}"] = noted(at, f"{letter}.point", units, f"once a period, {name}")
        shown[f"{letter}.curve.{name}"] = noted(along, f"{letter}.step", units, f"phase curve, {name}")


def _whole(ax: Any, observable: Observable, curve: list[np.ndarray], points: list[np.ndarray]) -> None:
    """Draw phase curve and section points on the scale of the motion."""
    scale = (observable.factor, observable.rate_factor)
    ax.plot(*(s * c for s, c in zip(scale, curve, strict=True)), color="0.8", linewidth=0.4, zorder=1)
    ax.scatter(*(s * p for s, p in zip(scale, points, strict=True)), s=6.0, color=COLOUR, linewidths=0, zorder=2)
    ax.set_xlabel(f"{observable.text} [{observable.unit}]")
    ax.set_ylabel(f"its velocity [{observable.rate_unit}]")
    ax.text(0.02, 0.02, "grey: the motion between", transform=ax.transAxes, fontsize="small", color="0.3")


def _close_up(ax: Any, observable: Observable, curve: list[np.ndarray], points: list[np.ndarray], verdict: str) -> None:
    """Draw the section points on their own scale, as differences to the middle of their range."""
    middles = [0.5 * (p.max() + p.min()) for p in points]
    ranges = [max(np.ptp(p), SMALLEST * np.ptp(c)) * ROOM for p, c in zip(points, curve, strict=True)]
    factor, unit, rate_unit, rate_factor = next((row for row in UNITS if row[0] * ranges[0] >= 1.0), UNITS[-1])
    offsets = [s * (p - m) for s, p, m in zip((factor, rate_factor), points, middles, strict=True)]
    ax.scatter(*offsets, s=9.0, color=COLOUR, linewidths=0)
    ax.set_xlim(-0.5 * factor * ranges[0], 0.5 * factor * ranges[0])
    ax.set_ylim(-0.5 * rate_factor * ranges[1], 0.5 * rate_factor * ranges[1])
    shift = f"{observable.factor * middles[0]:.7g} {observable.unit}"
    ax.set_xlabel(f"{observable.text}, from {shift} [{unit}]")
    ax.set_ylabel(f"its velocity, from {middles[1]:.5g} m/s [{rate_unit}]")
    text = f"{len(points[0])} points within {length_text(float(np.ptp(points[0])))}: {verdict}"
    ax.set_title(f"close-up: {text}", fontsize="medium", loc="left")


section = partial(observed, what="Poincaré map", rows=2, column=column)
