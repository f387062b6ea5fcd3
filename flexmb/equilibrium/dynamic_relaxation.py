"""Dynamic relaxation: equilibria in which loads alone resist some motions, as of pendulums."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from flexmb.equilibrium.stability import is_stable
from flexmb.equilibrium.steady_rotation import Spin
from flexmb.errors import SolveError
from flexmb.program.program import Program
from flexmb.system.state_evaluation import StateEvaluation

MOST_STRIDES = 400
"""Number of strides at most."""

STRIDE_ITERATIONS = 12
"""Number of Newton iterations of a stride at most."""

LARGEST_STRIDE = 0.5
"""Largest movement in a stride [rad, or relative to the size of the mechanism]."""

INDEPENDENCE = 1e-14
"""Number on the diagonal beside rows of constraints of length 1, which keeps them apart where they repeat others."""

ROUND_OFF = 1e-15
"""Force of springs without load relative to their stiffness times the size of the mechanism."""

REST_STRIDE = 1e-9
"""Movement in a stride with little viscosity at rest [rad, or relative to the size of the mechanism]."""


def relax(program: Program, system: StateEvaluation, q: np.ndarray, spin: Spin) -> tuple[np.ndarray, np.ndarray] | None:
    """Coordinates (n_q,) and multipliers (n_c,) at rest under all loads, after a motion with large viscosity; or None.

    Strides of implicit Euler for eta D dq/ds + r(q) + G^T lam = 0, g(q) = 0, with a smaller eta after each success.
    Every stride decreases the potential, so that the motion ends in a stable equilibrium; Newton's method would find
    the nearest stationary point.
    """
    n, length = program.n_q, program.length
    size = np.where(program.tables.kind == 1, 1.0, length)
    diagonal = program.symbolic.positions(np.arange(n), np.arange(n))
    spin.at(system, q)
    forces = float(np.abs(system.force * size).max(initial=0.0))
    lam = least_multipliers(system.jacobian, system.force)
    unbalanced = float(np.abs((system.force + system.jacobian.T @ lam) * size).max(initial=0.0))
    system.at(q, weights=(1.0, 0.0, 0.0))
    stiffest = float((abs(system.block()) @ size * size).max(initial=0.0))
    if unbalanced <= max(1e-12 * forces, ROUND_OFF * stiffest):
        return q, lam  # an equilibrium already, or no load
    unit = forces / length**2
    eta = unit
    for _ in range(MOST_STRIDES):
        viscosity = eta * (length / size) ** 2
        found = _stride(program, system, (q, lam), viscosity, diagonal, spin)
        if found is None:
            eta *= 4.0
            if eta > 1e12 * unit:
                return None
            continue
        moved = float(np.abs((found[0] - q) / size).max())
        q, lam = found
        if moved <= REST_STRIDE and eta <= 1e-3 * unit:
            return q, lam
        eta = max(eta / 3.0, 1e-14 * unit)
    return None


def least_multipliers(G: sp.csr_matrix, force: np.ndarray) -> np.ndarray:
    """Multipliers (n_c,) that leave the least of G^T lam + force.

    Redundant rows share their force as their round-off has it: `INDEPENDENCE` keeps the bordered matrix regular.
    """
    m, n = G.shape
    lengths = np.sqrt(np.asarray(G.multiply(G).sum(axis=1)).ravel())
    scale = sp.diags_array(1.0 / np.where(lengths > 0.0, lengths, 1.0))
    rows = scale @ G
    bordered = sp.block_array([[sp.eye_array(n), rows.T], [rows, -INDEPENDENCE * sp.eye_array(m)]]).tocsc()
    found: np.ndarray = scale @ splu(bordered).solve(np.concatenate([-force, np.zeros(m)]))[n:]
    return found


def _stride(
    program: Program,
    system: StateEvaluation,
    start: tuple[np.ndarray, np.ndarray],
    viscosity: np.ndarray,
    diagonal: np.ndarray,
    spin: Spin,
) -> tuple[np.ndarray, np.ndarray] | None:
    """One implicit stride from (q, lam); None if Newton fails or the viscosity is too small."""
    n, size = program.n_q, np.where(program.tables.kind == 1, 1.0, program.length)
    first = start[0]
    q, lam = first.copy(), start[1].copy()
    last = np.inf
    for _ in range(STRIDE_ITERATIONS):
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
        if not downhill or not step <= LARGEST_STRIDE or float(np.abs((q - first) / size).max()) > LARGEST_STRIDE:
            return None
        if step <= 1e-11 or (step <= 1e-7 and step >= 0.5 * last):
            return q, lam
        last = step
    return None
