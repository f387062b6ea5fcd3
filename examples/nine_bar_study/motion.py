"""Settled turns of a case: measures of each turn over all steps, and signals of the last turns."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from nine_bar_study.case import Case, Machine
from nine_bar_study.run import StudyError, StudyRun

from flexmb.results.solution import Solution
from flexmb.run.simulate import simulate

if TYPE_CHECKING:
    import xarray as xr

OF_STEP = 7e-5
"""Approximate processor time of a fixed step [s]."""

COUNTED = 0.5
"""Least height of a peak over the height of the largest peak."""

APART = 1e-3
"""Least distance of two peaks over the period; of two closer peaks the smaller one is dropped."""

OF_CONTACTS = {"start": "s", "end": "s", "peak_force": "N", "impulse": "N s"}


def motion(case: Case, skip: int, keep: int, shown: int) -> StudyRun:
    """Run of the settled turns of a case.

    Parameters
    ----------
    case : case of the study.
    skip, keep : turns before the first settled turn, and number of settled turns.
    shown : last settled turns, whose signals are saved at every step.
    """
    turn = case.cost if case.step is None else OF_STEP * case.period / case.step
    settings = (("skip", skip), ("keep", keep), ("shown", shown))
    return StudyRun(case.name + case.accuracy, measure_motion, case, settings, turn * (skip + keep))


def measure_motion(case: Case, *, skip: int, keep: int, shown: int) -> xr.Dataset:
    """Simulate a case turn by turn.

    Returns
    -------
    xarray.Dataset : over "turn", for each settled turn: largest absolute values `peak.SIGNAL` and mean step `step` [s];
        with clearance also largest penetration `penetration` [m], share of free flight `flight` and number of onsets of
        contact `landings`.  Over "instant.SIGNAL": `large.SIGNAL`, instants of the large peaks of all settled
        turns [s].  Over "time", every step of the last turns: the signals.  With clearance over "episode", contact
        intervals of the last turns: `contact.start`, `contact.end` [s], `contact.peak_force` [N],
        `contact.impulse` [N s].

    Raises
    ------
    StudyError : a simulation failed.
    """
    import xarray

    state, turns, last = None, [], []
    large: dict[str, list[np.ndarray]] = {name: [] for name in case.machine.peaks}
    mechanism, solver = case.mechanism(), case.solver
    for k in range(1, skip + keep + 1):
        sol = simulate(mechanism, t_end=k * case.period, save="steps", restart=state, **solver)
        if not sol.ok:
            raise StudyError(f"{case.name}: turn {k} did not end: {sol.status}")
        state = sol.restart
        if k > skip:
            turns.append(_measures(sol, case.machine))
            for name in set(large) & set(sol):
                large[name].append(peaks_of(sol.time, sol.array(name), APART * case.period))
        if k > skip + keep - shown:
            last.append(sol)
    columns: dict[str, Any] = {name: ("turn", [turn[name] for turn in turns]) for name in turns[0]}
    found = {name: np.concatenate(values) for name, values in large.items() if values}
    columns |= {f"large.{name}": (f"instant.{name}", values, {"units": "s"}) for name, values in found.items()}
    columns |= _curves(last, case.machine) | _contacts(last, case.machine.joint)
    about = {"case": case.name + case.accuracy, "period": case.period, "first_turn": skip + 1}
    return xarray.Dataset(columns, attrs=about)


def peaks_of(time: np.ndarray, values: np.ndarray, apart: float) -> np.ndarray:
    """Instants of the large peaks of the absolute value of a signal, ascending (k,) [s].

    Parameters
    ----------
    time, values : (n,) instants [s] and values of the signal at every step.
    apart : least distance of two peaks [s].
    """
    size = np.abs(values)
    inner = np.flatnonzero((size[1:-1] >= size[:-2]) & (size[1:-1] > size[2:])) + 1
    kept: list[float] = []
    for k in inner[np.argsort(-size[inner], kind="stable")]:
        if size[k] < COUNTED * size.max():
            break
        if all(abs(time[k] - other) >= apart for other in kept):
            kept.append(float(time[k]))
    return np.sort(np.array(kept))


def broken(depth: np.ndarray) -> float:
    """Number of onsets of contact in the penetrations (n,) of successive steps."""
    return float(np.count_nonzero((depth[1:] > 0.0) & (depth[:-1] <= 0.0)))


def _measures(sol: Solution, machine: Machine) -> dict[str, float]:
    """Measures of one turn by name."""
    found = {f"peak.{name}": float(sol.peak(name).value) for name in machine.peaks}
    if f"{machine.joint}.penetration" in sol:
        depth, steps = sol.array(f"{machine.joint}.penetration"), np.diff(sol.time)
        found["penetration"] = max(float(depth.max()), 0.0)
        found["flight"] = float(steps[depth[1:] < 0.0].sum() / (sol.time[-1] - sol.time[0]))
        found["landings"] = broken(depth)
    found["step"] = float(np.diff(sol.time).mean())
    return found


def _curves(last: list[Solution], machine: Machine) -> dict[str, Any]:
    """Variables of the signals of the last turns; a restarted run does not save its first state again."""
    names = [name for name in machine.curves if name in last[0]]  # an ideal mechanism has no signals of clearance
    found = {
        name: ("time", np.concatenate([sol.array(name) for sol in last]), {"units": last[0].units(name)})
        for name in names
    }
    return {"time": ("time", np.concatenate([sol.time for sol in last]), {"units": "s"}), **found}


def _contacts(last: list[Solution], joint: str) -> dict[str, Any]:
    """Variables of the contact intervals of the joint in the last turns."""
    if f"{joint}.penetration" not in last[0]:
        return {}
    episodes = [sol.episodes(joint) for sol in last]
    return {
        f"contact.{name}": ("episode", np.concatenate([getattr(found, name) for found in episodes]), {"units": unit})
        for name, unit in OF_CONTACTS.items()
    }
