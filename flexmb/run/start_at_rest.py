"""Start values of a run that begins in an equilibrium, at rest or in steady rotation."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.engine.step.contact_log import LASTING_PHASE
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import InputError
from flexmb.model.mechanism import Mechanism
from flexmb.program.program import COMMON_Z, FRICTION_Z, NORMAL_Z, PHASE, Program
from flexmb.statics.found import Equilibrium
from flexmb.statics.start.consistent import Start, accelerations, rigid_velocities, yielding_joints

EQUILIBRIUM = "equilibrium"
"""Word for the static equilibrium of the mechanism itself."""

OTHER_SPEED = 1e-9
"""Violation of the joints and drives by the velocities of a steady rotation, relative to these velocities."""


def of_start(label: str, start: Any, restart: Any, redundant: str) -> dict[str, str]:
    """Text of `start` beside the other arguments of a run, which must go with it."""
    if start is None:
        return {}
    if restart is not None or redundant != "refuse":
        raise InputError(f"{label}: start goes with neither restart nor redundant joints. Leave one of them out.")
    return {"start": repr(start)}


def start_at_rest(
    label: str, mechanism: Mechanism, program: Program, closed: Program, start: Any
) -> tuple[Start, np.ndarray]:
    """Start values of a run in an equilibrium, and the histories (n_z,) of its contacts, which last already.

    `start` is an equilibrium of this mechanism, or "equilibrium"; its steady rotation is one that the drives share.
    `closed` is the program with ideal joints for contacts.
    """
    from flexmb.statics.equilibrium import carries, refuse_other_forces, refuse_other_names, static_equilibrium
    from flexmb.statics.steady_rotation import Spin

    if not isinstance(start, Equilibrium) and start != EQUILIBRIUM:
        raise InputError(
            f"{label}: start is {start!r}; it must be {EQUILIBRIUM!r}, or what static_equilibrium(...) "
            "returns, also with spin=."
        )
    at = start if isinstance(start, Equilibrium) else static_equilibrium(mechanism)
    spin = Spin(at.spin, at.about)
    system = StateEvaluation(program)
    refuse_other_names(label, program, at)
    refuse_other_forces(label, program, system, at)
    held = yielding_joints(program, closed)
    v = spin.motion(at.q)[0][: program.n_q] if at.spin else rigid_velocities(closed, at.q, 0.0, held)
    system.at(at.q, v)
    G = system.jacobian.tocsr()
    held_alone = (np.diff(G.indptr) == 1) & (program.tables.constraints.motion < 0)  # the rotation of a particle
    alone = np.flatnonzero(held_alone)
    v[G.indices[G.indptr[alone]]] -= system.velocity_residual[alone] / G.data[G.indptr[alone]]
    missed = np.abs(system.at(at.q, v).velocity_residual).max(initial=0.0)
    if missed > OTHER_SPEED * np.abs(v).max(initial=0.0):
        raise InputError(
            f"{label}: the equilibrium turns at {at.spin:g} rad/s, and joints or drives allow no such motion (by "
            f"{missed:.3g} m/s or rad/s). Give the drive of the hub this speed, e.g. ConstantSpeed({at.spin:g}), and "
            "the place of the hub to static_equilibrium(..., about=)."
        )
    z = np.array(program.reference.z)
    for k in np.flatnonzero(carries(system)):
        begin, law, end = program.tables.contacts.z[k, [COMMON_Z, NORMAL_Z, FRICTION_Z]]
        z[begin + PHASE], z[law:end] = LASTING_PHASE, program.normals[k].lasting_history()
    if not v.any() and not program.drives:
        return Start(at.q, v, np.zeros(program.n_q), at.lam), z
    return Start(at.q, v, *accelerations(program, at.q, v, 0.0, z)), z
