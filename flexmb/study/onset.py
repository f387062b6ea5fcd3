"""The speed up to which contact of a joint with clearance is unbroken."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from flexmb import checks
from flexmb.run.simulate import simulate
from flexmb.study.case import Case
from flexmb.study.motion import broken
from flexmb.study.run import StudyError, StudyRun

if TYPE_CHECKING:
    import xarray as xr

STARTS = ("soft", "hard")
TRIALS = 12
"""About the number of speeds that are tried."""


def onset(
    case: Case, highest: float, settle: int, keep: int, start: str = "soft", *, coarse: float, fine: float
) -> StudyRun:
    """The run that looks for the last speed without and the first one with free flight.

    Speeds rise by `coarse` until a settled turn has free flight; then the bracket is halved until it is `fine` wide.
    Each speed begins anew from rest: "soft" with the ramp of the case, "hard" at full speed with the journal in the
    middle.  Two motions beside one another would show as two thresholds.

    Parameters
    ----------
    case : a case with clearance at the first speed.
    highest : last speed [unit of the machine].
    settle, keep : turns at full speed before those that count, and turns that count.
    start : "soft" or "hard".
    coarse, fine : steps of the speed, and width of the bracket that is left [unit of the machine].

    Raises
    ------
    InputError : an unknown start.
    """
    checks.one_of("onset", "start", start, STARTS)
    settings = {"highest": highest, "settle": settle, "keep": keep, "start": start, "coarse": coarse, "fine": fine}
    work = 0.3 * case.cost * (settle + keep) * TRIALS
    return StudyRun(f"onset-{start}-{case.name}", measure_onset, case, tuple(settings.items()), work)


def measure_onset(
    case: Case, *, highest: float, settle: int, keep: int, start: str, coarse: float, fine: float
) -> xr.Dataset:
    """Bracket the speed.

    Parameters
    ----------
    case, highest, settle, keep, start, coarse, fine : as of `onset`.

    Returns
    -------
    xarray.Dataset : over "trial", by rising speed: `speed` [unit of the machine], `flight`, the largest share of free
        flight in any of the turns that count, `landings`, most in a turn, and `least_force`, the smallest normal force
        of these turns [N].

    Raises
    ------
    StudyError : a run that did not end well; contact that breaks at the first speed, or at none.
    """
    import xarray

    unit = case.machine.unit
    speed, tried = case.speed, [tried_at(case, case.speed, settle, keep, start)]
    if tried[0][1] > 0.0:
        raise StudyError(f"{case.name}: contact breaks at the first speed already. Begin at a lower one.")
    while tried[-1][1] == 0.0:
        speed = round(speed + coarse, 6)
        if speed > highest:
            raise StudyError(f"{case.name}: contact is unbroken up to {highest:g} {unit}. Go higher.")
        tried.append(tried_at(case, speed, settle, keep, start))
    low, high = tried[-2][0], tried[-1][0]
    while high - low > fine * (1.0 + 1e-9):
        tried.append(tried_at(case, 0.5 * (low + high), settle, keep, start))
        low, high = (tried[-1][0], high) if tried[-1][1] == 0.0 else (low, tried[-1][0])
    table = np.array(sorted(tried))
    names = (("speed", unit), ("flight", ""), ("landings", ""), ("least_force", "N"))
    columns = {name: ("trial", table[:, k], {"units": unit}) for k, (name, unit) in enumerate(names)}
    about = {"case": case.name, "last_unbroken": low, "first_broken": high}
    return xarray.Dataset(columns, attrs=about)


def tried_at(case: Case, speed: float, settle: int, keep: int, start: str) -> tuple[float, float, float, float]:
    """Speed, largest share of free flight, most landings in a turn, least normal force [N].

    Parameters
    ----------
    case, speed, settle, keep, start : as of `onset`, at one speed.
    """
    case = dataclasses.replace(case, speed=speed, ramp=case.ramp if start == "soft" else 0.0)
    before, mechanism, joint = settle + case.ramp, case.mechanism(), case.machine.joint
    sol = simulate(mechanism, t_end=before * case.period, save=2, **case.solver)
    worst, landings, least = 0.0, 0.0, np.inf
    for k in range(1, keep + 1):
        if sol.ok:
            end = (before + k) * case.period
            sol = simulate(mechanism, t_end=end, save="steps", restart=sol.restart, **case.solver)
        if not sol.ok:
            raise StudyError(f"{case.name}: the run at {speed:g} {case.machine.unit} did not end: {sol.status}")
        # a run that goes on may save nothing at its begin
        depth, steps = sol.array(f"{joint}.penetration"), np.diff(sol.time, prepend=(before + k - 1) * case.period)
        worst = max(worst, float(steps[depth < 0.0].sum()) / case.period)
        landings = max(landings, broken(depth))
        least = min(least, float(sol.array(f"{joint}.normal_force").min()))
        if worst > 0.0:
            break  # what the other turns do cannot mend it
    return speed, worst, landings, least
