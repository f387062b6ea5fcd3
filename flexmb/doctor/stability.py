"""Stability of the reference configuration under the declared loads, gravity included."""

from __future__ import annotations

import numpy as np

from flexmb.display.text import quoted
from flexmb.doctor.finding import Finding, found
from flexmb.equilibrium.eigen import damped
from flexmb.equilibrium.found import Equilibrium
from flexmb.equilibrium.free_motions import moves_most
from flexmb.equilibrium.modes import Modes, modes
from flexmb.equilibrium.statics import correction
from flexmb.equilibrium.steady_rotation import Spin
from flexmb.errors import FlexmbError, SolveError
from flexmb.model.mechanism import Mechanism
from flexmb.program.program import Program
from flexmb.system.state_evaluation import StateEvaluation

MOST_ITERATIONS = 20
"""Number of Newton iterations towards an equilibrium beside the reference configuration."""

BESIDE = 0.05
"""Distance of an equilibrium from the reference configuration up to which the mechanism is meant to rest there [rad, or
relative to the size of the mechanism]."""

BALANCED = 1e-7
"""Unbalanced force relative to the largest load, and gap relative to the size, of an equilibrium."""

MOST_COORDINATES = 600
"""Number of coordinates above which loads are left out, since their balance would take long."""

MOST_CONTROLLED = 150
"""Number of coordinates and states above which eigenvalues of control loops would take long."""

LEAST_GROWTH = 1e-4
"""Growth relative to the largest eigenvalue, below which it may be round-off of a multiple eigenvalue 0."""

MODES = 10
"""Number of modes that are looked at."""


def stability_findings(mechanism: Mechanism, ideal: Program, q: np.ndarray, bare: Modes | None) -> list[Finding]:
    """Finding on a small motion that runs away from the reference configuration.

    Where an equilibrium under the loads lies beside the reference configuration, its modes decide; else, and where
    bodies are declared with velocities, those without the loads, since what begins to move is not meant to rest.  The
    pose (n_q,) is closed; `bare` modes are None where there are none.
    """
    moves = np.nan_to_num(ideal.reference.v).any()  # NaN where no velocity is declared
    pose, loads = None if moves else equilibrium_beside(ideal, q), "Without loads"
    if pose is not None:
        names = ideal.names
        at = Equilibrium(*pose, names.coordinates, names.aliases, {}, 0)
        try:
            bare, loads = modes(mechanism, count=MODES, at=at), "Under its loads, gravity included,"
        except FlexmbError:
            pose = None
    if bare is None or "unstable" not in bare.kinds:
        return []
    worst = int(np.argmin(bare.frequencies))
    rate = -float(bare.frequencies[worst]) * 2.0 * np.pi
    body = ideal.names.bodies[int(ideal.reference.body[bare.names.index(bare.moves[worst])])]
    text = f"{loads} a small motion away from the reference configuration, mostly of {bare.moves[worst]!r}, grows by"
    remedy = (
        "It stands on its head, or is buckled: turn it over, or hold it by a spring, a joint or a stronger section."
    )
    return [found("unstable-reference", (body,), f"{text} exp({rate:.4g} t), t in s.", remedy, rate=rate)]


def loop_findings(mechanism: Mechanism, program: Program, q: np.ndarray) -> list[Finding]:
    """Finding on control loops that act at all times and let a small motion about the pose (n_q,) grow.

    From the eigenvalues of mechanism and control laws together, at rest in the reference configuration; without the
    stiffness of gravity in it.  Sampled laws are left out.
    """
    if not program.controls or program.n_q > MOST_CONTROLLED or program.names.contacts:
        return []
    system, q = StateEvaluation(program), np.append(q, program.reference.q[len(q) :])
    K, C, M = (system.at(q, weights=w).block() for w in np.eye(3))
    try:
        s, x = damped(K, C, M, system.jacobian, np.zeros((program.n_q, 0)), 2 * program.n_q)
    except (FlexmbError, np.linalg.LinAlgError, ValueError):  # no finite matrices: told by other findings
        return []
    worst = int(np.argmax(s.real)) if len(s) else 0
    if not len(s) or s[worst].real <= LEAST_GROWTH * np.abs(s).max():
        return []
    names = tuple(part.name for part in mechanism.controllers)
    moved = moves_most(program.names.coordinates, program.length, np.abs(x[: program.tables.sizes.n_b, worst]))
    text = f"With {quoted(names)} a small motion, mostly of {moved!r}, grows by exp({s[worst].real:.4g} t), t in s."
    remedy = "Check the sign of the feedback, and reduce the gains."
    return [
        found("unstable-loop", names, text, remedy, rate=s[worst].real, frequency=abs(s[worst].imag) / (2.0 * np.pi))
    ]


def equilibrium_beside(program: Program, q: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Coordinates and multipliers of an equilibrium beside a pose (n_q,), stable or not; None where there is none."""
    if program.n_q > MOST_COORDINATES:
        return None
    system, start, size = StateEvaluation(program), q, np.where(program.tables.kind == 1, 1.0, program.length)
    force, G = system.at(q, weights=(1.0, 0.0, 0.0)).force, system.jacobian.toarray()
    lam, none = np.linalg.lstsq(G.T, -force, rcond=None)[0], np.zeros(program.n_q)
    for _ in range(MOST_ITERATIONS):
        system.at(q, lam=lam)
        rest, most = system.force + system.constraint_force, max(np.abs(system.force).max(), np.abs(force).max())
        closed = np.abs(system.residual).max(initial=0.0) <= BALANCED * program.length
        if closed and np.abs(rest).max() <= BALANCED * most:
            return q, lam
        try:
            d = correction(system, q, lam, none, Spin(0.0, (0.0, 0.0)))
        except SolveError:
            return None
        q, lam = q + d[: program.n_q], lam + d[program.n_q :]
        if not np.abs((q - start) / size).max() <= BESIDE:
            return None
    return None
