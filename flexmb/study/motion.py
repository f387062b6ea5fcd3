"""Turns of a case: measures of every turn from all steps, and the last turns in full."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.results.solution import Solution
from flexmb.run.simulate import simulate
from flexmb.study.case import Case, Machine
from flexmb.study.run import StudyError, StudyRun

if TYPE_CHECKING:
    import xarray as xr

OF_STEP = 7e-5
"""About the processor time of a fixed step [s]."""

OF_CONTACTS = {"start": "s", "end": "s", "peak_force": "N", "impulse": "N s"}


def motion(case: Case, skip: int, keep: int, shown: int) -> StudyRun:
    """The run of settled turns.

    Parameters
    ----------
    case : the case.
    skip, keep : turns before the first that counts, and turns that count.
    shown : last ones of these, whose signals are kept at every step.
    """
    turn = case.cost if case.step is None else OF_STEP * case.period / case.step
    settings = (("skip", skip), ("keep", keep), ("shown", shown))
    return StudyRun(case.name + case.accuracy, measure_motion, case, settings, turn * (skip + keep))


def measure_motion(case: Case, *, skip: int, keep: int, shown: int) -> xr.Dataset:
    """Simulate turn by turn.

    Parameters
    ----------
    case, skip, keep, shown : as of `motion`.

    Returns
    -------
    xarray.Dataset : over "turn", for each turn that counts: the largest absolute values `peak.SIGNAL` and the mean step
        [s]; with clearance also the largest penetration [m], the share of free flight and the number of landings.  Over
        "time" (every accepted step of the shown turns): the signals.  With clearance over "episode": start, end [s] and
        peak force [N] of contacts in the shown turns.

    Raises
    ------
    StudyError : a run that did not end well.
    """
    import xarray

    state, turns, last = None, [], []
    mechanism, solver = case.mechanism(), case.solver
    for k in range(1, skip + keep + 1):
        sol = simulate(mechanism, t_end=k * case.period, save="steps", restart=state, **solver)
        if not sol.ok:
            raise StudyError(f"{case.name}: turn {k} did not end: {sol.status}")
        state = sol.restart
        if k > skip:
            turns.append(_measures(sol, case.machine))
        if k > skip + keep - shown:
            last.append(sol)
    columns: dict[str, Any] = {name: ("turn", [turn[name] for turn in turns]) for name in turns[0]}
    columns |= _curves(last, case.machine) | _contacts(last, case.machine.joint)
    about = {"case": case.name + case.accuracy, "period": case.period, "first_turn": skip + 1}
    return xarray.Dataset(columns, attrs=about)


def broken(depth: np.ndarray) -> float:
    """Number of landings in penetrations (n,)."""
    return float(np.count_nonzero((depth[1:] > 0.0) & (depth[:-1] <= 0.0)))


def _measures(sol: Solution, machine: Machine) -> dict[str, float]:
    """Measures of one turn."""
    found = {f"peak.{name}": float(sol.peak(name).value) for name in machine.peaks}
    if f"{machine.joint}.penetration" in sol:
        depth, steps = sol.array(f"{machine.joint}.penetration"), np.diff(sol.time)
        found["penetration"] = max(float(depth.max()), 0.0)
        found["flight"] = float(steps[depth[1:] < 0.0].sum() / (sol.time[-1] - sol.time[0]))
        found["landings"] = broken(depth)
    found["step"] = float(np.diff(sol.time).mean())
    return found


def _curves(last: list[Solution], machine: Machine) -> dict[str, Any]:
    """The signals of the shown turns, one after the other."""
    names = [name for name in machine.curves if name in last[0]]  # a restarted run begins after its first step
    found = {
        name: ("time", np.concatenate([sol.array(name) for sol in last]), {"units": last[0].units(name)})
        for name in names
    }
    return {"time": ("time", np.concatenate([sol.time for sol in last]), {"units": "s"}), **found}


def _contacts(last: list[Solution], joint: str) -> dict[str, Any]:
    """The contacts of the joint in the shown turns."""
    if f"{joint}.penetration" not in last[0]:
        return {}
    episodes = [sol.episodes(joint) for sol in last]
    return {
        f"contact.{name}": ("episode", np.concatenate([getattr(found, name) for found in episodes]), {"units": unit})
        for name, unit in OF_CONTACTS.items()
    }
