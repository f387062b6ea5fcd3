"""Fixed steps that are too long for contacts, or for vibrations with which a run begins."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from flexmb.doctor.finding import Finding, found
from flexmb.doctor.laws import contacts_of
from flexmb.doctor.loads import penetration, typical_load
from flexmb.equilibrium.free_motions import moves_most
from flexmb.equilibrium.vibrations import State, vibrations_of
from flexmb.errors import FlexmbError
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Body, Joint
from flexmb.program.program import Program
from flexmb.start.consistent import accelerations, rigid_velocities, yielding_joints

UNRESOLVED = 1.0
"""Angular frequency times step above which a vibration is not resolved."""

LOADED_SHARE = 0.01
"""Share of the energy of the vibrations at the start above which a mode carries load."""

LEAST_STEPS = 4.0
"""Steps of an impact below which its restitution means nothing."""

MOST_COORDINATES = 400
"""Number of coordinates above which modes would take too long."""

PART_OF_PERIOD = 0.05
"""Time of the differences along the motion, relative to the step."""


def step_findings(mechanism: Mechanism, ideal: Program, closed: Program, q: np.ndarray, h: float) -> list[Finding]:
    """Findings on a fixed step h [s] that is too long for contacts, or for vibrations with which a run begins.

    `ideal` has ideal joints for clearance joints; in `closed` start velocities are found; the pose (n_q,) is closed.
    """
    findings = list(_short_contacts(mechanism, h))
    if ideal.n_q > MOST_COORDINATES:
        return findings
    try:
        v = rigid_velocities(closed, q, 0.0, yielding_joints(ideal, closed))
        a, _ = accelerations(ideal, q, v, 0.0)
        vibrations = vibrations_of(ideal, [State(0.0, q, v, a, ideal.reference.z)], PART_OF_PERIOD * h)
    except (FlexmbError, np.linalg.LinAlgError):
        return findings  # told by other findings
    if not vibrations:
        return findings
    ((_, energies, modes),) = vibrations
    begun = energies[0, 2]
    coarse = np.flatnonzero((modes.omega * h > UNRESOLVED) & (begun > LOADED_SHARE * begun.sum()))
    if not len(coarse):
        return findings
    k = int(coarse[np.argmax(begun[coarse])])
    period, moves = (
        2.0 * math.pi / float(modes.omega[k]),
        moves_most(ideal.names.coordinates, ideal.length, modes.shapes[:, k]),
    )
    body = ideal.names.bodies[int(ideal.reference.body[ideal.names.coordinates.index(moves)])]
    text = f"A fixed step of {h:.3g} s is {h / period:.2g} periods of the vibration of {1.0 / period:.4g} Hz (mostly"
    text = f"{text} {moves}), which carries {100.0 * float(begun[k] / begun.sum()):.3g} % of what the start excites."
    remedy = f"Take steps of {period / 20.0:.1g} s, or Adaptive()."
    return [*findings, found("coarse-step", (body,), text, remedy, step=h, period=period)]


def _short_contacts(mechanism: Mechanism, h: float) -> Iterator[Finding]:
    """Findings on contacts that are shorter than a few steps: half a period of the lighter mass on the contact."""
    load, masses = typical_load(mechanism), {b.name: getattr(b, "mass", None) for b in mechanism.bodies}
    for part in mechanism.parts if load > 0.0 else ():
        if not isinstance(part, Joint) or isinstance(part, Body):
            continue
        inverse = sum(1.0 / m for m in (masses.get(b.name) for b in (part.first, part.second)) if m)
        for contact in contacts_of(part, mechanism) if inverse > 0.0 else ():
            depth = penetration(contact.normal, load, max(contact.p[0], 1e-2))
            time = math.pi * math.sqrt(depth / (load * inverse))
            if time < LEAST_STEPS * h:
                text = (
                    f"A contact of {part.label} lasts some {time:.2g} s (a mass of {1.0 / inverse:.3g} kg, a force of"
                )
                text = f"{text} {load:.3g} N at {depth:.2g} m), less than {LEAST_STEPS:g} fixed steps of {h:.3g} s."
                remedy = f"Take steps of {time / 32.0:.1g} s, or Adaptive(), which resolves impacts."
                yield found("coarse-step", (part.name,), text, remedy, step=h, contact_time=time)
                break
