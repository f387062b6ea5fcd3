"""Kind "phase" of figures: phase diagrams, the velocity over the coordinate."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from nine_bar_study.drawing import Observable, Shown, noted
from nine_bar_study.exponent import SHOWN
from nine_bar_study.figures.contrast import COLOUR, observed
from nine_bar_study.run import StudyRun

if TYPE_CHECKING:
    import xarray as xr


def column(axes: Any, shown: Shown, letter: str, observable: Observable, run: StudyRun, result: xr.Dataset) -> None:
    """Draw the velocity over the coordinate at every step of 4 periods.

    Parameters
    ----------
    axes : (1,) axes of the case.
    shown : variables of the dataset; the variables of the case are added.
    letter : letter of the case.
    observable : coordinate and velocity.
    run, result : long run of the case, and its result.
    """
    ax, axis = axes[0], f"{letter}.step"
    place, rate = result[f"step.{observable.place}"].values, result[f"step.{observable.rate}"].values
    ax.plot(observable.factor * place, observable.rate_factor * rate, color=COLOUR, linewidth=0.5)
    in_joint = observable.place.startswith(f"{run.case.machine.joint}.")
    if in_joint:
        for side in (-1.0, 1.0):
            ax.axvline(side * observable.factor * run.case.clearance, color="0.5", linestyle=":", linewidth=1.0)
    ax.set_xlabel(f"{observable.text} [{observable.unit}]")
    ax.set_ylabel(f"its velocity [{observable.rate_unit}]")
    note = f"{SHOWN} periods, every step" + ("; dotted: the clearance" if in_joint else "")
    ax.text(0.02, 0.02, note, transform=ax.transAxes, fontsize="small", color="0.3")
    shown[f"{letter}.{observable.place}"] = noted(place, axis, "m", observable.text)
    shown[f"{letter}.{observable.rate}"] = noted(rate, axis, "m/s", f"velocity, {observable.text}")


phase = partial(observed, what="Phase diagram", rows=1, column=column)
