"""Energies of vibrations in a motion: modes about a moving pose, and how much of the motion they carry.

The mechanism is linearised about a state with its drives held fast.  The elastic forces that its inertia balances
there, divided by omega^2, are the displacements y of the modes from the pose that drives and loads would give at rest;
their first and second time derivatives are differences along the motion.  In a vibration omega^2 y^2, y'^2 and
y''^2/omega^2 have one mean.  What follows a slower drive has less of the last, what follows a faster one less of the
first, so the least of the three bounds the energy of the vibration.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from flexmb.equilibrium.free_motions import null_space
from flexmb.program.program import Program
from flexmb.system.state_evaluation import StateEvaluation

NEAR = 0.05
"""Change of the pose [rad, or relative to the size of the mechanism] up to which modes are not computed anew."""

RIGID = 1e-12
"""Stiffness over mass relative to the largest, below which a motion is rigid: the rest is round-off."""


class LinearModes(NamedTuple):
    """Elastic modes about a pose, drives held fast.

    Parameters
    ----------
    omega : (k,) angular frequencies [rad/s], ascending.
    decay : (k,) rates at which dampers let them die out [1/s].
    shapes : (n_q, k) shapes x with x^T M x = 1.
    """

    omega: np.ndarray
    decay: np.ndarray
    shapes: np.ndarray


class State(NamedTuple):
    """Saved state: time [s], coordinates, velocities, accelerations (n_q,) of the bodies."""

    t: float
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray


def energies_of_modes(program: Program, states: Sequence[State], dt: float) -> tuple[np.ndarray, LinearModes]:
    """Energies (states, 3, modes) of the modes, omega^2 y^2, y'^2 and y''^2/omega^2 [J], and the modes of the last.

    Parameters
    ----------
    program : the compiled mechanism.
    states : states of a run.
    dt : time of the differences [s].

    Raises
    ------
    SolveError, KernelError : modes that cannot be computed.
    """
    system = StateEvaluation(program)
    modes, at, rows = linear_modes(system, states[0]), states[0].q, []
    sizes = np.where(np.asarray(program.tables.kind)[: len(at)] == 1, 1.0, program.length)
    for state in states:
        if np.abs((state.q - at) / sizes).max() > NEAR:
            modes, at = linear_modes(system, state), state.q
        before, now, after = (
            modes.shapes.T @ system.at(_padded(program, q), t=state.t).force[: len(q)]
            for q in (state.q + dt * (k * state.v + 0.5 * k * k * dt * state.a) for k in (-1, 0, 1))
        )
        y = np.array([now, (after - before) / (2.0 * dt), (after - 2.0 * now + before) / dt**2])
        rows.append((y / modes.omega ** np.array([[1.0], [2.0], [3.0]])) ** 2)
    least = min(row.shape[1] for row in rows)
    return np.array([row[:, :least] for row in rows]), modes


def linear_modes(system: StateEvaluation, state: State) -> LinearModes:
    """Elastic modes about a state.

    Parameters
    ----------
    system : evaluation of the program.
    state : the state.

    Raises
    ------
    SolveError, KernelError : modes that cannot be computed.
    """
    n, n_b = system.program.n_q, len(state.q)
    q = _padded(system.program, state.q)
    K, C, M = (system.at(q, t=state.t, weights=w).dense[:n_b, :n_b] for w in np.eye(3))
    Z = null_space(system.dense[n:, :n_b])
    if Z.shape[1] == 0:
        return LinearModes(np.zeros(0), np.zeros(0), np.zeros((n_b, 0)))
    k, m = (Z.T @ (A + A.T) @ Z / 2.0 for A in (K, M))
    squares, y = la.eigh(k, m)
    elastic = squares > RIGID * squares[-1]
    x = Z @ y[:, elastic]
    return LinearModes(np.sqrt(squares[elastic]), 0.5 * (x * (C @ x)).sum(axis=0), x)


def _padded(program: Program, q: np.ndarray) -> np.ndarray:
    """Coordinates (n_q,) with the states of controls at 0."""
    return np.append(q, np.zeros(program.n_q - len(q)))
