"""Contacts of a mechanism that were closed without a break for as long as its exponents were counted."""

from __future__ import annotations

import numpy as np

from flexmb.analysis.dynamics import Dynamics
from flexmb.analysis.mechanism_flow import MechanismFlow
from flexmb.analysis.section_map import SectionMap
from flexmb.analysis.stroboscopic import StroboscopicMap
from flexmb.integrate.touch import still_running

CONTACT, START, APPROACH = 0, 4, 5
"""Columns of an episode: which contact, when it began [s], how fast its surfaces came together [m/s]."""
ASKED = "restitution"
"""What laws of hysteresis damping are asked for: below 1 their damping takes the approach speed of the last onset."""


def lasting(system: Dynamics, since: float) -> list[str]:
    """A sentence on each contact that has been closed since `since` [s], so that no onset of it was counted.

    Laws of hysteresis damping keep the approach speed of the last onset, which sets the damping as long as the contact
    lasts; others do not depend on it, and nothing is said.

    Parameters
    ----------
    system : a mechanism's flow, or a section of one; of another system there is nothing to say.
    since : when counting began [s].
    """
    flow = system.flow if isinstance(system, (StroboscopicMap, SectionMap)) else system
    if not isinstance(flow, MechanismFlow):
        return []
    said, program = [], flow.program
    for row in still_running(program.tables, flow.run.flow):
        contact, start, speed = int(row[CONTACT]), row[START], row[APPROACH]
        if start > since or vars(program.normals[contact]).get(ASKED, 1.0) == 1.0:
            continue
        known = f"the approach speed of its last onset, {speed:.3g} m/s" if np.isfinite(speed) else (
            "the approach speed that it began the run with")  # fmt: skip
        text = f"{program.names.contacts[contact]} has been in contact without a break during all that was counted"
        said.append(f"{text}: its damping is set by {known}.")
    return said
