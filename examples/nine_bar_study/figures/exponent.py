"""Kind "exponent" of figures: the largest Lyapunov exponent, from one observable and of the system.

The upper panel shows the running estimate from one observable by the method of Wolf et al., and the published value.
The signal has 100 samples per period.  The delay is at the first minimum of the mutual information.  The dimension
leaves less than 1 % of false neighbours.  Pairs are followed for a mean period of the signal.  The lower panel shows
the exponent of the system, computed with the linearised steps and independent of the observable.
"""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from nine_bar_study.drawing import Observable, Shown, noted
from nine_bar_study.effort import Effort
from nine_bar_study.figures.contrast import COLOUR, Contrast, observed
from nine_bar_study.item import StudyFigure
from nine_bar_study.run import StudyRun
from nine_bar_study.samples import SAMPLES, by_period

from flexmb.dynamics.series.exponent import SeriesExponent, wolf

if TYPE_CHECKING:
    import xarray as xr

Printed = Mapping[tuple[float, float], Mapping[str, float]]
"""Published exponents of unknown unit by (speed, clearance), and by observable."""

ESTIMATE, PAPER = "#d55e00", "black"

SETTLED = 10
"""Reciprocal of the first part of a running estimate that is ignored by the limits of the axis."""


def exponent(number: int, effort: Effort, contrast: Contrast, place: str, printed: Printed) -> StudyFigure:
    """Figure of the largest exponents of two cases."""
    title, of_case = "Lyapunov exponent", partial(column, printed=printed)
    return observed(number, effort, contrast, place, what=title, rows=2, column=of_case)


def column(
    axes: Any,
    shown: Shown,
    letter: str,
    observable: Observable,
    run: StudyRun,
    result: xr.Dataset,
    *,
    printed: Printed,
) -> None:
    """Draw the estimate from an observable over the length of the record, and the exponent of the system below.

    Parameters
    ----------
    axes : (2,) axes of the case.
    shown : variables of the dataset; the variables of the case are added.
    letter : letter of the case.
    observable : coordinate and velocity.
    run, result : long run of the case, and its result.
    printed : published exponents.
    """
    period = run.case.period
    value = printed_value(printed, run, observable.place)
    _estimate(axes[0], shown, letter, observable, value, result)
    _system(axes[1], shown, letter, result)
    for ax in axes:
        right = ax.secondary_yaxis("right", functions=(lambda v: v * period, lambda v: v / period))
        right.set_ylabel("[1/period]")


def printed_value(printed: Printed, run: StudyRun, place: str) -> float:
    """Published exponent of the case of a run and an observable; NaN without a published value."""
    return printed.get((run.case.speed, run.case.clearance), {}).get(place, float("nan"))


def _estimate(ax: Any, shown: Shown, letter: str, observable: Observable, value: float, result: xr.Dataset) -> None:
    found = estimate_of(result, observable.place)
    ax.axhline(0.0, color="0.6", linewidth=0.8)
    if len(found.curve):
        trusted = f"± {found.error:.2g} 1/s" if found.ok else "1/s, no value by its own checks"
        ax.plot(found.time, found.curve, color=ESTIMATE, lw=1.1, label=f"Wolf: {float(found.curve[-1]):.3g} {trusted}")
    else:
        ax.set_xlim(0.0, float(np.ptp(result["time"].values)))
        text = "no estimate: " + "\n".join(textwrap.wrap(found.status, 48))
        ax.text(0.5, 0.5, text, transform=ax.transAxes, fontsize="small", color=ESTIMATE, ha="center", va="center")
    if np.isfinite(value):
        ax.axhline(value, color=PAPER, linestyle="--", linewidth=1.2, label=f"the paper: {value:+.4f}, unit unknown")
    _limit(ax, np.append(found.curve, [0.0, value]))
    ax.set_xlabel("length of the record [s]")
    ax.set_ylabel(f"from {observable.place} alone [1/s]")
    ax.legend(loc="upper right", fontsize="small")
    ax.text(0.02, 0.02, _settings(found), transform=ax.transAxes, fontsize="x-small", color="0.3")
    shown[f"{letter}.time"] = noted(found.time, f"{letter}.estimate", "s", "length of the record")
    shown[f"{letter}.wolf"] = noted(found.curve, f"{letter}.estimate", "1/s", f"running estimate, {observable.place}")
    shown[f"{letter}.printed"] = ((), value, {"units": "unknown", "long_name": "value printed in the paper"})


def _system(ax: Any, shown: Shown, letter: str, result: xr.Dataset) -> None:
    time, history = result["history.time"].values, result["history.exponent"].values
    value, error = float(result["exponent"]), float(result["exponent_error"])
    ax.axhline(0.0, color="0.6", linewidth=0.8)
    ax.axhspan(value - error, value + error, color=COLOUR, alpha=0.25, linewidth=0)
    ax.plot(
        time, history, color=COLOUR, linewidth=1.1, label=f"{value:.4g} ± {error:.1g} 1/s: {result.attrs['verdict']}"
    )
    _limit(ax, np.append(history, 0.0))
    ax.set_xlabel("time [s]")
    ax.set_ylabel("of the system [1/s]")
    ax.legend(loc="best", fontsize="small")
    shown[f"{letter}.history.time"] = noted(time, f"{letter}.history", "s", "time")
    shown[f"{letter}.history.exponent"] = noted(history, f"{letter}.history", "1/s", "exponent of the system")
    shown[f"{letter}.exponent"] = ((), value, {"units": "1/s", "long_name": "exponent of the system"})
    shown[f"{letter}.exponent_error"] = ((), error, {"units": "1/s", "long_name": "its standard deviation"})


def _limit(ax: Any, values: np.ndarray) -> None:
    """Set the limits of the axis to the last nine tenths of a curve."""
    late = np.append(values[:-2][len(values) // SETTLED :], values[-2:])
    late = late[np.isfinite(late)]
    room = 0.2 * max(float(np.ptp(late)), 1e-9)
    ax.set_ylim(late.min() - room, late.max() + 2.0 * room)


def _settings(found: SeriesExponent) -> str:
    if found.embedding is None:
        return found.status
    made = f"{SAMPLES} samples a period, delay {found.embedding.delay}, dimension {found.embedding.dimension}"
    return f"{made}, followed {found.embedding.mean_period / SAMPLES:.2g} periods"


def estimate_of(result: xr.Dataset, name: str) -> SeriesExponent:
    """Estimate of the largest exponent from one observable by the method of Wolf et al."""
    rows = by_period(result, name)
    return _wolf(rows.tobytes(), rows.shape[1], float(result.attrs["period"]))


@lru_cache(maxsize=32)
def _wolf(samples: bytes, count: int, period: float) -> SeriesExponent:
    return wolf(np.frombuffer(samples), period / count)
