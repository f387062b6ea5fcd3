"""A second run beside a first one: with finer steps, from another start, and a fifth as long."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmb.dynamics.exponents.exponent_error import combined
from flexmb.dynamics.exponents.exponents import Confirmed, Exponents
from flexmb.dynamics.exponents.lasting_contact import lasting
from flexmb.dynamics.exponents.schedule import Schedule
from flexmb.dynamics.exponents.tangent_run import carried
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.errors import AssemblyError, InputError, SolveError

PART = 5
"""One in so many points of the first run is what the second one has; as many of those that were left out before it."""

SETTLES = 10
"""One in so many points of the first run is left out at least: other steps may lead the motion elsewhere."""

LEAST = 20
"""Points of the second run, at least."""

APART = (1e-3, 1e-9)
"""How far the other start is, as a part of the state; the second one where the first one leads nowhere."""


def confirmed(first: Exponents, plan: Schedule, seed: int, *, shown: bool) -> Exponents:
    """The first run with what a second one found, and errors that cover what it changes.

    The second run begins beside the state in which the first one ended, so that the transient is over, and leaves
    that state alone.  Where a contact was closed during all that was counted it begins at the mechanism's own start,
    with the whole transient: what the contact keeps of its last onset would be the same in both runs else.

    Parameters
    ----------
    first : what the first run found.
    plan : when the system was looked at.
    seed : of other directions.
    shown : whether a progress bar is.
    """
    text, count = "", len(first.spectrum)
    kept = bool(lasting(plan.system, float(first.time[0])))
    for part in (0.0,) if kept else APART:
        other = _anew(plan) if kept else _begun(plan, part, seed)
        if other is None:
            continue
        found = carried(other, count, seed, shown=shown)
        if found.ok and not np.isnan(found.spectrum).any():
            second = Confirmed(found.spectrum, found.errors, other.count, other.system.fineness)
            errors = combined(first.spectrum, first.statistical, second.spectrum, second.errors)
            return replace(first, errors=errors, confirmed=second)
        text = found.status
    why = text or "no state beside the end of the first run can be started from."
    return replace(first, unconfirmed=why, status=f"{first.status} The second run failed: {why}")


def _anew(plan: Schedule) -> Schedule:
    """A plan for a finer system from its own start, with the transient of the first run."""
    system = plan.system.finer()
    system.reset(time=plan.origin)
    return _shorter(plan, system, max(plan.skip, plan.count // SETTLES))


def _begun(plan: Schedule, part: float, seed: int) -> Schedule | None:
    """A plan for a finer system that stands beside the end of the first run; None: it cannot stand there."""
    system = plan.system.finer()
    try:
        system.reset(system.another_start(part, seed), time=plan.system.time)
    except (InputError, AssemblyError, SolveError):
        return None
    return _shorter(plan, system, max(-(-plan.skip // PART), plan.count // SETTLES))


def _shorter(plan: Schedule, system: Dynamics, skip: int) -> Schedule:
    """The plan of a second run of `system`, after `skip` points."""
    kinds = {"is_flow": plan.is_flow, "is_section": plan.is_section}
    return Schedule(system, plan.unit, skip, max(plan.count // PART, LEAST), **kinds, looks=plan.looks)
