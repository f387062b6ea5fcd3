"""A bifurcation diagram of a study: section points once a turn at each speed or at each clearance."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flexmb import checks
from flexmb.jobs.engine import PENDING
from flexmb.study.case import Case
from flexmb.study.exponent import TANGENT
from flexmb.study.run import StudyError, StudyRun
from flexmb.sweeps.bifurcation_diagram import bifurcation

if TYPE_CHECKING:
    import xarray as xr

    from flexmb.model.mechanism import Mechanism

PARAMETERS = ("speed", "clearance")
IN_CONTACT = 0.6
"""Cost of a turn, the mean over a diagram, over that of a turn with impacts."""


def diagram(
    case: Case, parameter: str, values: Sequence[float], skip: int, keep: int, exponent: bool | str = False
) -> StudyRun:
    """The run of a diagram.

    Parameters
    ----------
    case : gives what stays, the steps included.
    parameter : "speed" or "clearance".
    values : speeds [rad/s] or clearances [m].
    skip, keep : turns before the first point, and points, at each value.
    exponent : whether the largest exponent is found: True, over as many turns more; "points", over those of the points.
    """
    checks.one_of("diagram", "parameter", parameter, PARAMETERS)
    settings = {"parameter": parameter, "values": tuple(values), "skip": skip, "keep": keep, "exponent": exponent}
    each = {False: 1.0, True: 1.0 + TANGENT, "points": TANGENT}[exponent]
    work = IN_CONTACT * case.cost * (skip + keep * each) * len(values)
    name = f"diagram-{parameter}-{case.model}"
    return StudyRun(name, measure_diagram, case, tuple(settings.items()), work, len(values))


def part_of(values: Sequence[float], count: int | None) -> tuple[float, ...]:
    """About `count` of the values, both ends among them; None: all.

    Parameters
    ----------
    values : rising.
    count : how many.
    """
    if count is None or count >= len(values):
        return tuple(values)
    return tuple(values[k] for k in np.linspace(0, len(values) - 1, max(count, 2)).round().astype(int))


def measure_diagram(
    case: Case,
    *,
    parameter: str,
    values: Sequence[float],
    skip: int,
    keep: int,
    exponent: bool | str,
    executor: Executor | None = None,
    store: Path | None = None,
    pending: int = PENDING,
) -> xr.Dataset:
    """Compute it value by value.

    Parameters
    ----------
    case, parameter, values, skip, keep, exponent : as of `diagram`.
    executor : where values are computed; None: in this process.
    store : folder in which finished values are kept, and found again; None: nowhere.
    pending : most values that are with the executor at the same time.

    Returns
    -------
    xarray.Dataset : as `bifurcation` returns it.  Values that failed have a status that says so.

    Raises
    ------
    StudyError : no value went well.
    InputError : a store of another diagram.
    """
    found = bifurcation(
        case_over,
        parameter,
        list(values),
        fixed={"case": case},
        skip=skip,
        keep=keep,
        exponent=exponent,
        period=partial(turn_at, case.machine.turn * case.machine.factor) if parameter == "speed" else case.period,
        step=case.steps,
        executor=executor,
        pending=pending,
        store=store,
        resume=store is not None,
    )
    if not found["ok"].any():
        raise StudyError(f"diagram over {parameter}: no value went well; the first: {found['status'].values[0]}")
    return found


def case_over(case: Case, speed: float | None = None, clearance: float | None = None) -> Mechanism:
    """The mechanism of a case at another speed or clearance.

    Parameters
    ----------
    case : the case.
    speed : of the drives [rad/s]; None: that of the case.
    clearance : of the joint [m]; None: that of the case.
    """
    speed = case.speed if speed is None else speed / case.machine.factor
    return dataclasses.replace(case, speed=speed, clearance=clearance or case.clearance).mechanism()


def turn_at(angle: float, speed: float) -> float:
    """The time of a turn [s]; drives with a ramp have no period of their own.

    Parameters
    ----------
    angle : of a turn [rad].
    speed : of the drives [rad/s].
    """
    return angle / speed
