"""Energies of vibrations in a motion: modes about a moving pose, and how much of the motion they carry.

The mechanism is linearised about a state with its drives held fast, contacts as they are there, laws of controllers
and the stiffness of gravity included.  The forces that its inertia balances there, divided by omega^2, are the
displacements y of the modes from the pose that drives and loads would give at rest; their first and second time
derivatives are differences along the motion.  In a vibration omega^2 y^2, y'^2 and y''^2/omega^2 have one mean.  What
follows a slower drive has less of the last, what follows a faster one less of the first, so the least of the three
bounds the energy of the vibration.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg as la

from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import SolveError
from flexmb.program.program import COMMON_Z, Program
from flexmb.statics.eigen import null_space, undamped

NEAR = 0.05  # change of pose [rad, or relative to the size of the mechanism] up to which modes are not computed anew
RIGID, RIGID_OF_LARGE = 1e-12, 1e-9  # stiffness over mass relative to the largest, up to which a motion is rigid
ROUND_OFF = 1e-12  # displacement of a vibration over the size of the mechanism, or rotation [rad], up to round-off
DENSE, LOWEST = 300, 24  # coordinates up to which all modes are found; number of the lowest ones found beyond


class LinearModes(NamedTuple):
    """Modes about a pose, drives held fast."""

    omega: np.ndarray  # (k,) angular frequencies [rad/s], ascending
    decay: np.ndarray  # (k,) rates at which dampers let them die out [1/s]
    shapes: np.ndarray  # (n_b, k) shapes x with x^T M x = 1
    elastic: np.ndarray  # (k,) whether more than half of the stiffness is elastic; of the others it is that of gravity


class State(NamedTuple):
    """State of a run: time [s], coordinates and their rates (n_q,), histories (n_z,)."""

    t: float
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    z: np.ndarray


class Vibrations(NamedTuple):
    """Vibrations at the states of a run in which the same contacts are closed."""

    states: list[State]
    energies: np.ndarray  # (states, 3, k) omega^2 y^2, y'^2 and y''^2/omega^2 of the modes [J]
    modes: LinearModes  # means of frequencies and decays, shapes of the last state


def vibrations_of(program: Program, states: Sequence[State], dt: float) -> list[Vibrations]:
    """Vibrations at some states, one group for each set of closed contacts."""
    system, n_b = StateEvaluation(program), program.tables.sizes.n_b
    sizes = program.sizes[:n_b]
    known: dict[bytes, tuple[np.ndarray, LinearModes]] = {}
    groups: dict[tuple[bytes, int], list[tuple[State, LinearModes, np.ndarray]]] = {}
    for state in states:
        closed, lam = closed_contacts(program, state.z).tobytes(), _multipliers_at_rest(system, state)
        at, modes = known.get(closed, (None, None))
        if at is None or modes is None or np.abs((state.q[:n_b] - at) / sizes).max(initial=0.0) > NEAR:
            modes = linear_modes(system, state, lam)
            known[closed] = state.q[:n_b], modes
        if not len(modes.omega):
            continue
        evaluated = (_at(system, state, k * dt, lam=lam) for k in (-1, 0, 1))
        before, now, after = (modes.shapes.T @ (one.force + one.constraint_force)[:n_b] for one in evaluated)
        y = np.array([now, (after - before) / (2.0 * dt), (after - 2.0 * now + before) / dt**2])
        energies = (y / modes.omega ** np.array([[1.0], [2.0], [3.0]])) ** 2
        moved = np.sqrt(energies.max(axis=0)) / modes.omega * np.abs(modes.shapes / sizes[:, None]).max(axis=0)
        energies[:, moved < ROUND_OFF] = 0.0
        groups.setdefault((closed, len(modes.omega)), []).append((state, modes, energies))
    found = []
    for group in groups.values():
        at_states, all_modes, energies = zip(*group, strict=True)
        omega, decay = (np.mean([getattr(one, name) for one in all_modes], axis=0) for name in ("omega", "decay"))
        found.append(Vibrations(list(at_states), np.array(energies), all_modes[-1]._replace(omega=omega, decay=decay)))
    return found


def closed_contacts(program: Program, z: np.ndarray) -> np.ndarray:
    """Whether contacts are closed and joints that remember strained, (..., contacts + joints), of z (..., n_z)."""
    begin, end = program.tables.constraints.joint_friction_z.T
    return np.asarray(z[..., [*program.tables.contacts.z[:, COMMON_Z], *begin[end > begin]]] != 0.0)


def _at(system: StateEvaluation, state: State, dt: float = 0.0, **more: Any) -> StateEvaluation:
    """Evaluation at rest, a time dt [s] away from a state along its motion; states of controllers as they are then."""
    n_b = system.program.tables.sizes.n_b
    v = np.where(np.arange(len(state.q)) < n_b, 0.0, state.v + dt * state.a)
    return system.at(state.q + dt * state.v + 0.5 * dt * dt * state.a, v, t=state.t, z=state.z, **more)


def linear_modes(system: StateEvaluation, state: State, lam: np.ndarray) -> LinearModes:
    """Modes with a positive stiffness about a state; of large models the lowest ones."""
    program, n_b = system.program, system.program.tables.sizes.n_b
    n, count, rigid = (program.n_q, LOWEST, RIGID_OF_LARGE) if n_b > DENSE else (n_b, n_b, RIGID)
    elastic = _at(system, state, weights=(1.0, 0.0, 0.0)).blocks[0][:n, :n]  # without the stiffness of gravity
    (K, _), (C, _), (M, G) = (_at(system, state, lam=lam, weights=w).blocks for w in np.eye(3))
    K, C, M = K[:n, :n], C[:n, :n], M[:n, :n]
    squares, x = undamped(K, M, G[:, :n], np.zeros((n, 0)), count, program.symbolic.order)
    rising = np.argsort(squares)
    rising = rising[squares[rising] > rigid * np.abs(squares).max(initial=0.0)]  # the rest is round-off
    x, squares = x[:, rising], squares[rising]
    own = (x * (elastic @ x)).sum(axis=0)
    return LinearModes(np.sqrt(squares), 0.5 * (x * (C @ x)).sum(axis=0), x[:n_b], own > 0.5 * squares)


def _multipliers_at_rest(system: StateEvaluation, state: State) -> np.ndarray:
    """Multipliers (n_c,) of the joints if the mechanism were released from rest at a state."""
    program = system.program
    if not program.n_c:
        return np.zeros(0)
    r = _at(system, state, weights=(0.0, 0.0, 1.0)).force
    try:
        found = system.solve(np.concatenate([-r, np.zeros(program.n_c)]), "forces at rest")[program.n_q :]
    except SolveError:  # redundant joints, or a motion without mass
        found = np.linalg.lstsq(system.jacobian.toarray().T, -r, rcond=None)[0]
    return found if np.isfinite(found).all() else np.zeros(program.n_c)


def loop_modes(program: Program, state: State) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues (k,) [1/s] of mechanism and controllers with a frequency > 0, amplitudes (k, states) of these."""
    # The rates of the state, along a left eigenvector w, are s eta where it vibrates freely with the amplitude eta.
    system, n, n_b = StateEvaluation(program), program.n_q, program.tables.sizes.n_b
    v = np.where(np.arange(n) < n_b, 0.0, state.v)
    K, C, M = (system.at(state.q, v, t=state.t, z=state.z, weights=w).dense[:n, :n] for w in np.eye(3))
    Z = null_space(system.dense[n:, :n])
    k, c, m = (Z.T @ A @ Z for A in (K, C, M))
    A = np.block([[np.zeros_like(k), np.eye(len(k))], [-la.solve(m, k), -la.solve(m, c)]])
    s, left, right = la.eig(A, left=True, right=True)
    s, left, right = (x[..., s.imag > 0.0] for x in (s, left, right))
    rates = np.concatenate([Z.T @ state.v, Z.T @ state.a])
    eta = (left.conj().T @ rates) / ((left.conj() * right).sum(axis=0) * s)
    states = (Z @ right[len(k) :])[n_b:]
    return s, 2.0 * np.abs(states * eta).T
