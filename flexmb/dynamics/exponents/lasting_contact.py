"""Contacts of a mechanism that were closed without a break for as long as its exponents were counted."""

from __future__ import annotations

from flexmb.dynamics.sections.section_map import SectionMap
from flexmb.dynamics.sections.stroboscopic import StroboscopicMap
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.results.remarks import COLUMN, damped_since_onset
from flexmb.step.contact_log import running_episodes


def lasting(system: Dynamics, since: float) -> list[str]:
    """A sentence on each contact that has been closed since `since` [s], so that no onset of it was counted.

    Laws with hysteresis damping keep a speed of the last onset, which scales the damping as long as the contact lasts;
    others do not depend on it, and nothing is said.

    Parameters
    ----------
    system : a mechanism's flow, or a section of one; of another system there is nothing to say.
    since : when counting began [s].
    """
    flow = system.flow if isinstance(system, (StroboscopicMap, SectionMap)) else system
    if not isinstance(flow, MechanismFlow):
        return []
    said, program, now = [], flow.program, flow.run.flow
    for row in running_episodes(program.tables, now):
        contact = int(row[COLUMN["contact"]])
        _, begin, end, _ = program.tables.contacts.z[contact]
        damped = damped_since_onset(program.normals[contact], now.z[begin:end])
        if damped and row[COLUMN["peak_force"]] > 0.0 and not row[COLUMN["start"]] > since:
            name = program.names.contacts[contact]
            said.append(f"{name} has been in contact without a break during all that was counted: {damped}.")
    return said
