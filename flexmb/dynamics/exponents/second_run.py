"""A second, shorter run with finer steps from another start, and the errors of exponents that it adds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmb.dynamics.exponents.exponent_error import combined
from flexmb.dynamics.exponents.exponents import Confirmed, Exponents
from flexmb.dynamics.exponents.renormalisation import lasting_contacts, tangent_exponents
from flexmb.dynamics.exponents.schedule import RenormalisationSchedule
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.errors import AssemblyError, InputError, SolveError

PART = 5
"""Points of the first run per point of the second run, for counted and for skipped points."""

SETTLES = 10
"""Points of the first run per skipped point of the second run, at most; finer steps may change the attractor."""

LEAST = 20
"""Smallest number of points of the second run."""

APART = (1e-3, 1e-9)
"""Distances of the second run's start, over the length of the state; the second one is tried if the first one fails."""


def confirmed(first: Exponents, schedule: RenormalisationSchedule, seed: int, *, shown: bool) -> Exponents:
    """Exponents of a first run, completed by a second run; the errors cover the difference of both runs.

    The second run uses a copy of the system.  Its start is near the final state of the first run, after the transient.
    If a contact was closed during the whole first run, the second run starts at the start state of the system and skips
    the whole transient.  Otherwise both runs would have the approach speed of the same onset.
    """
    reason, count = "", len(first.spectrum)
    lasting = bool(lasting_contacts(schedule.system, float(first.time[0])))
    for distance in (0.0,) if lasting else APART:
        other = _from_own_start(schedule) if lasting else _from_final_state(schedule, distance, seed)
        if other is None:
            continue
        run = tangent_exponents(other, count, seed, shown=shown)
        if run.ok and not np.isnan(run.spectrum).any():
            second = Confirmed(run.spectrum, run.errors, other.count, other.system.fineness)
            errors = combined(first.spectrum, first.statistical, second.spectrum, second.errors)
            return replace(first, errors=errors, confirmed=second)
        reason = run.status
    reason = reason or "no state beside the end of the first run can be started from."
    return replace(first, unconfirmed=reason, status=f"{first.status} The second run failed: {reason}")


def _from_own_start(schedule: RenormalisationSchedule) -> RenormalisationSchedule:
    """Schedule of a finer system that starts from its own start and skips the transient of the first run."""
    system = schedule.system.finer()
    system.reset(time=schedule.origin)
    return _shortened(schedule, system, max(schedule.skip, schedule.count // SETTLES))


def _from_final_state(schedule: RenormalisationSchedule, distance: float, seed: int) -> RenormalisationSchedule | None:
    """Schedule of a finer system that starts beside the final state of the first run; None: it cannot start there."""
    system = schedule.system.finer()
    try:
        system.reset(system.another_start(distance, seed), time=schedule.system.time)
    except (InputError, AssemblyError, SolveError):
        return None
    return _shortened(schedule, system, max(-(-schedule.skip // PART), schedule.count // SETTLES))


def _shortened(schedule: RenormalisationSchedule, system: Dynamics, skip: int) -> RenormalisationSchedule:
    """Schedule of the second run of `system`, after `skip` points."""
    return RenormalisationSchedule(
        system,
        schedule.interval,
        skip,
        max(schedule.count // PART, LEAST),
        is_flow=schedule.is_flow,
        is_section=schedule.is_section,
        renormalisations=schedule.renormalisations,
    )
