"""Largest speed without free flight in a joint with clearance."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np
from nine_bar_study.case import Case
from nine_bar_study.motion import broken
from nine_bar_study.run import StudyError, StudyRun

from flexmb import checks
from flexmb.run.simulate import simulate

if TYPE_CHECKING:
    import xarray as xr

STARTS = ("soft", "hard")
TRIALS = 12
"""Approximate number of simulated speeds."""


def onset(
    case: Case, highest: float, settle: int, keep: int, start: str = "soft", *, coarse: float, fine: float
) -> StudyRun:
    """Run that brackets the threshold speed of free flight.

    The speed rises in steps of `coarse` until a settled turn has free flight.  Bisection then reduces the bracket to
    the width `fine`.  Each simulation starts from rest: "soft" with the ramp of the case, "hard" at full speed with
    the journal in the middle of the bearing.  Different thresholds of both starts indicate coexisting motions.

    Parameters
    ----------
    case : case with clearance at the first speed.
    highest : largest speed [unit of the machine].
    settle, keep : turns at full speed before the first settled turn, and number of settled turns.
    start : kind of start, "soft" or "hard".
    coarse, fine : step of the speed, and final width of the bracket [unit of the machine].

    Raises
    ------
    InputError : an unknown kind of start.
    """
    checks.one_of("onset", "start", start, STARTS)
    settings = {"highest": highest, "settle": settle, "keep": keep, "start": start, "coarse": coarse, "fine": fine}
    work = 0.3 * case.cost * (settle + keep) * TRIALS
    return StudyRun(f"onset-{start}-{case.name}", measure_onset, case, tuple(settings.items()), work)


def measure_onset(
    case: Case, *, highest: float, settle: int, keep: int, start: str, coarse: float, fine: float
) -> xr.Dataset:
    """Bracket the threshold speed of free flight.

    Returns
    -------
    xarray.Dataset : over "trial", by ascending speed: `speed` [unit of the machine]; `flight`, largest share of free
        flight in a settled turn; `landings`, largest number of onsets of contact in a settled turn; `least_force`,
        smallest normal force in the settled turns [N].  Attributes `last_unbroken` and `first_broken`: the bracket.

    Raises
    ------
    StudyError : a simulation failed; free flight at the first speed, or at no speed.
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
    """Speed, largest share of free flight and of onsets in a settled turn, smallest normal force [N]."""
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
        # a restarted simulation does not save its first state
        depth, steps = sol.array(f"{joint}.penetration"), np.diff(sol.time, prepend=(before + k - 1) * case.period)
        worst = max(worst, float(steps[depth < 0.0].sum()) / case.period)
        landings = max(landings, broken(depth))
        least = min(least, float(sol.array(f"{joint}.normal_force").min()))
        if worst > 0.0:
            break  # free flight in one turn decides
    return speed, worst, landings, least
