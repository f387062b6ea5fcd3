"""Bifurcation diagram of a study: section points over the speed or the clearance."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from nine_bar_study.case import Case
from nine_bar_study.exponent import TANGENT
from nine_bar_study.run import StudyError, StudyRun

from flexmb import checks
from flexmb.dynamics.jobs.executors import PENDING
from flexmb.dynamics.sweeps.bifurcation import bifurcation

if TYPE_CHECKING:
    import xarray as xr

    from flexmb.model.mechanism import Mechanism

PARAMETERS = ("speed", "clearance")
IN_CONTACT = 0.6
"""Mean cost of a turn over a diagram, relative to the cost of a turn with impacts."""


def diagram(
    case: Case, parameter: str, values: Sequence[float], skip: int, keep: int, exponent: bool | str = False
) -> StudyRun:
    """Run of a bifurcation diagram.

    Parameters
    ----------
    case : case with the constant numbers: model, friction, steps, and speed or clearance.
    parameter : "speed" or "clearance".
    values : speeds [rad/s] or clearances [m].
    skip, keep : turns before the first section point, and number of section points, at each value.
    exponent : largest exponent at each value: False, none; True, over `keep` further turns; "points", over the turns of
        the section points.
    """
    checks.one_of("diagram", "parameter", parameter, PARAMETERS)
    settings = {"parameter": parameter, "values": tuple(values), "skip": skip, "keep": keep, "exponent": exponent}
    each = {False: 1.0, True: 1.0 + TANGENT, "points": TANGENT}[exponent]
    work = IN_CONTACT * case.cost * (skip + keep * each) * len(values)
    name = f"diagram-{parameter}-{case.model}"
    return StudyRun(name, measure_diagram, case, tuple(settings.items()), work, len(values))


def part_of(values: Sequence[float], count: int | None) -> tuple[float, ...]:
    """About `count` of the values, including the first and the last.

    Parameters
    ----------
    values : values of the parameter, ascending.
    count : approximate number of returned values; None: all.
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
    """Compute a bifurcation diagram value by value.

    Parameters
    ----------
    case, parameter, values, skip, keep, exponent : arguments of `diagram`.
    executor : executor of the values; None: the calling process.
    store : folder of finished values, from which an interrupted diagram resumes; None: no folder.
    pending : largest number of values in the executor at the same time.

    Returns
    -------
    xarray.Dataset : result of `bifurcation`; the status of a failed value gives the reason.

    Raises
    ------
    StudyError : all values failed.
    InputError : `store` belongs to another diagram.
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
