"""Poses in which loads hold what nothing else holds: pendulums, and what hangs from hinges."""

from __future__ import annotations

import numpy as np

from flexmb.equilibrium.stability import is_stable
from flexmb.equilibrium.steady_rotation import Spin
from flexmb.errors import SolveError
from flexmb.program.program import Program
from flexmb.system.at_state import System

STRIDES = 400
"""Strides of the creeping motion before it is given up."""

ITERATIONS = 12
"""Newton iterations of one stride."""

LARGEST = 0.5
"""Largest movement of a stride [rad, or part of the mechanism's size]."""

AT_REST = 1e-9
"""The motion has come to rest when a stride with almost no viscosity moves less than this [rad, or of the size]."""


def settle(program: Program, system: System, q: np.ndarray, spin: Spin) -> tuple[np.ndarray, np.ndarray] | None:
    """Coordinates (n_q,) and multipliers (n_c,) where a mechanism in honey comes to rest under all loads, or None.

    Implicit Euler strides of eta D dq/ds + r(q) + G^T lam = 0, g(q) = 0, with eta smaller after each good one: it falls
    downhill, so it finds a stable equilibrium from any pose but an unstable one, where Newton would stay on the branch
    of its nearest stationary point.

    Parameters
    ----------
    program : the mechanism.
    system : the same, to be evaluated.
    q : (n_q,) the drawn pose.
    spin : rotation of the frame in which it shall rest.
    """
    n, length = program.n_q, program.length
    size = np.where(program.tables.kind == 1, 1.0, length)
    diagonal = program.symbolic.positions(np.arange(n), np.arange(n))
    spin.at(system, q)
    forces = float(np.abs(system.force * size).max(initial=0.0))
    lam = np.linalg.lstsq(system.jacobian.toarray().T, -system.force, rcond=1e-10)[0]
    unbalanced = float(np.abs((system.force + system.jacobian.T @ lam) * size).max(initial=0.0))
    if unbalanced <= 1e-12 * forces:
        return q, lam  # the drawn pose is one, or there is no load at all
    unit = forces / length**2
    eta = unit
    for _ in range(STRIDES):
        viscosity = eta * (length / size) ** 2
        found = _stride(program, system, (q, lam), viscosity, diagonal, spin)
        if found is None:
            eta *= 4.0
            if eta > 1e12 * unit:
                return None
            continue
        moved = float(np.abs((found[0] - q) / size).max())
        q, lam = found
        if moved <= AT_REST and eta <= 1e-3 * unit:
            return q, lam
        eta = max(eta / 3.0, 1e-14 * unit)
    return None


def _stride(program, system, start, viscosity, diagonal, spin) -> tuple[np.ndarray, np.ndarray] | None:
    """One implicit stride from (q, lam); None when Newton fails, or where the viscosity is too small to be downhill."""
    n, size = program.n_q, np.where(program.tables.kind == 1, 1.0, program.length)
    first = start[0]
    q, lam = first.copy(), start[1].copy()
    last = np.inf
    for _ in range(ITERATIONS):
        v, a = spin.motion(q)
        system.at(q, v, a, lam, weights=(1.0, 0.0, 0.0))
        system.work.lu[diagonal] += viscosity
        downhill = is_stable(program, system.block(), system.jacobian) is not False
        force = system.force + system.constraint_force + viscosity * (q - first)
        try:
            d = system.solve(-np.concatenate([force, system.residual]), "settling")
        except SolveError:
            return None
        step = float(np.abs(d[:n] / size).max())
        q, lam = q + d[:n], lam + d[n:]
        if not downhill or not step <= LARGEST or float(np.abs((q - first) / size).max()) > LARGEST:
            return None
        if step <= 1e-11 or (step <= 1e-7 and step >= 0.5 * last):
            return q, lam
        last = step
    return None
