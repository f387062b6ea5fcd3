"""Figures 17, 18, 24, 34, 35 and 41: phase diagrams of the journal and of the slider."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flexmb.paper.attractor import SHOWN, Attractor
from flexmb.paper.doubles import COLOUR, Observable, noted, six
from flexmb.paper.effort import Effort
from flexmb.paper.plate import Plate

if TYPE_CHECKING:
    import xarray as xr

NUMBERS = ((17, 18, 24), (34, 35, 41))


def plates(effort: Effort) -> tuple[Plate, ...]:
    """The phase diagrams.

    Parameters
    ----------
    effort : how long the runs are.
    """
    return six(effort, "Phase diagram", NUMBERS, 1, column)


def column(
    axes: Any, shown: dict[str, Any], letter: str, observable: Observable, run: Attractor, result: xr.Dataset
) -> None:
    """The velocity over the place, at every step of a few periods.

    Parameters
    ----------
    axes : (1,).
    shown : variables of the dataset, to which those of this case are added.
    letter : of the case.
    observable : what is looked at.
    run, result : the case.
    """
    ax, axis = axes[0], f"{letter}.step"
    place, rate = result[f"step.{observable.place}"].values, result[f"step.{observable.rate}"].values
    ax.plot(observable.factor * place, observable.rate_factor * rate, color=COLOUR, linewidth=0.5)
    if observable.place.startswith("P1."):
        for side in (-1.0, 1.0):
            ax.axvline(side * observable.factor * run.case.clearance, color="0.5", linestyle=":", linewidth=1.0)
    ax.set_xlabel(f"{observable.text} [{observable.unit}]")
    ax.set_ylabel(f"its velocity [{observable.rate_unit}]")
    note = f"{SHOWN} periods, every step" + ("; dotted: the clearance" if observable.place.startswith("P1.") else "")
    ax.text(0.02, 0.02, note, transform=ax.transAxes, fontsize="small", color="0.3")
    shown[f"{letter}.{observable.place}"] = noted(place, axis, "m", observable.text)
    shown[f"{letter}.{observable.rate}"] = noted(rate, axis, "m/s", f"velocity, {observable.text}")
