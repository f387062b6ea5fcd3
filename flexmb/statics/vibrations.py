"""Energies of vibrations in a motion: modes about a moving pose, and how much of the motion they carry.

The mechanism is linearised about a state with its drives held fast, contacts as they are there, laws of controllers
and the stiffness of gravity included.  The forces that its inertia balances there, divided by omega^2, are the
displacements y of the modes from the pose that drives and loads would give at rest; their first and second time
derivatives are differences along the motion.  In a vibration omega^2 y^2, y'^2 and y''^2/omega^2 have one mean.  What
follows a slower drive has less of the last, what follows a faster one less of the first, so the least of the three
bounds the energy of the vibration.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg as la

from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import SolveError
from flexmb.program.program import Program
from flexmb.statics.eigen import DEPENDENT_ROW, all_modes, null_space, undamped

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


class Examination:
    """Vibrations at states of a run, each of which is examined once; dt: time of the differences [s]."""

    def __init__(self, program: Program, dt: float) -> None:
        self.program, self.dt, self._system = program, dt, StateEvaluation(program)
        self._known: dict[bytes, list[tuple[np.ndarray, LinearModes]]] = {}  # poses and modes by closed contacts
        self._rows: dict[float, tuple[LinearModes, np.ndarray]] = {}  # modes and their energies (3, k) by instants

    def groups(self, states: Sequence[State]) -> list[Vibrations]:
        """Vibrations at some states, one group for each set of closed contacts."""
        groups: dict[tuple[bytes, int], list[tuple[State, LinearModes, np.ndarray]]] = {}
        for state in states:
            closed = self.program.closed_contacts(state.z).tobytes()
            if state.t not in self._rows:
                self._rows[state.t] = self._row(state, closed)
            modes, energies = self._rows[state.t]
            if len(modes.omega):
                groups.setdefault((closed, len(modes.omega)), []).append((state, modes, energies))
        found = []
        for group in groups.values():
            at_states, all_modes, of_states = zip(*group, strict=True)
            omega, decay = (np.mean([getattr(one, name) for one in all_modes], axis=0) for name in ("omega", "decay"))
            modes = all_modes[-1]._replace(omega=omega, decay=decay)
            found.append(Vibrations(list(at_states), np.array(of_states), modes))
        return found

    def _row(self, state: State, closed: bytes) -> tuple[LinearModes, np.ndarray]:
        """Modes about a state, and their energies (3, k)."""
        system, dt, n_b = self._system, self.dt, self.program.tables.sizes.n_b
        sizes, released = self.program.sizes[:n_b], _released(system, state)
        q, known = state.q[:n_b] / sizes, self._known.setdefault(closed, [])
        near = (modes for at, modes in reversed(known) if np.abs(q - at).max(initial=0.0) <= NEAR)
        modes = next(near, None)
        if modes is None:
            modes = linear_modes(system, state, released)
            known.append((q, modes))
        if not len(modes.omega):
            return modes, np.zeros((3, 0))
        evaluated = (_at(system, state, k * dt, lam=released.lam) for k in (-1, 1))
        before, after = (modes.shapes.T @ (one.force + one.constraint_force)[:n_b] for one in evaluated)
        now = modes.shapes.T @ released.force
        y = np.array([now, (after - before) / (2.0 * dt), (after - 2.0 * now + before) / dt**2])
        energies = (y / modes.omega ** np.array([[1.0], [2.0], [3.0]])) ** 2
        moved = np.sqrt(energies.max(axis=0)) / modes.omega * np.abs(modes.shapes / sizes[:, None]).max(axis=0)
        energies[:, moved < ROUND_OFF] = 0.0
        return modes, energies


def fastest_bound(program: Program, states: Sequence[State]) -> float:
    """Bound of all angular frequencies [rad/s] about states; infinite where masses are coupled, and of large models."""
    # Where M is diagonal, omega^2 is at most the largest sum of absolute values in a row of M^-1/2 K M^-1/2: a norm
    # bounds all eigenvalues, and joints, which leave a subspace of the motions, lower the largest one.
    if program.tables.sizes.n_b > DENSE:
        return math.inf
    system, bound = StateEvaluation(program), 0.0
    for state in states:
        released = _released(system, state)
        masses = released.M.diagonal()
        if np.count_nonzero(released.M) != np.count_nonzero(masses) or (masses < 0.0).any():
            return math.inf
        K = np.abs(_block(_at(system, state, lam=released.lam, weights=(1.0, 0.0, 0.0))))
        sizes = np.sqrt(np.where(masses > 0.0, masses, np.finfo(float).tiny))
        bound = max(bound, float((0.5 * (K + K.T) / sizes / sizes[:, None]).sum(axis=1).max(initial=0.0)))
    return math.sqrt(bound)


def _at(system: StateEvaluation, state: State, dt: float = 0.0, **more: Any) -> StateEvaluation:
    """Evaluation at rest, a time dt [s] away from a state along its motion; states of controllers as they are then."""
    n_b = system.program.tables.sizes.n_b
    v = np.where(np.arange(len(state.q)) < n_b, 0.0, state.v + dt * state.a)
    return system.at(state.q + dt * state.v + 0.5 * dt * dt * state.a, v, t=state.t, z=state.z, **more)


class Released(NamedTuple):
    """Mechanism that is released from rest."""

    lam: np.ndarray  # (n_c,) multipliers of the joints
    force: np.ndarray  # (n_b,) r + G^T lam, which the inertia balances
    M: Any  # (n, n) masses, and (n_c, n) rows of the joints; plain arrays up to DENSE coordinates
    G: Any
    Z: np.ndarray  # (n, k) orthonormal basis of the motions that the joints allow; beyond DENSE coordinates left out


def _released(system: StateEvaluation, state: State) -> Released:
    """The mechanism released from rest at a state, drives held fast."""
    program, n = system.program, system.program.tables.sizes.n_b
    rest = _at(system, state, weights=(0.0, 0.0, 1.0))
    r, Z = rest.force, np.zeros((n, 0))
    if n > DENSE:
        M, G = rest.blocks
        lam = _multipliers(system, r)
        return Released(lam, (r + G.T @ lam)[:n], M, G, Z)
    A = rest.dense
    if not np.isfinite(A).all():
        raise SolveError("a mass or a joint is not finite")
    M, G = A[:n, :n], A[program.n_q :, :n]
    lengths = np.linalg.norm(G, axis=1)
    Q, R, order = la.qr((G / np.where(lengths > 0.0, lengths, 1.0)[:, None]).T, pivoting=True, check_finite=False)
    pivots = np.abs(R.diagonal())
    rank = int((pivots > DEPENDENT_ROW * pivots.max(initial=0.0)).sum())
    Z = Q[:, rank:]
    if rank < len(G):
        lam = _multipliers(system, r)
    else:
        load = M @ (Z @ np.linalg.solve(Z.T @ M @ Z, Z.T @ r[:n])) - r[:n]
        lam = np.empty(rank)
        lam[order] = la.solve_triangular(R[:rank], Q[:, :rank].T @ load, check_finite=False)
        lam /= lengths
    return Released(lam, r[:n] + G.T @ lam, M, G, Z)


def _multipliers(system: StateEvaluation, r: np.ndarray) -> np.ndarray:
    """Multipliers (n_c,) of the joints by the forces r (n_q,) at rest and the masses that were evaluated last."""
    program = system.program
    if not program.n_c:
        return np.zeros(0)
    try:
        found = system.solve(np.concatenate([-r, np.zeros(program.n_c)]), "forces at rest")[program.n_q :]
    except SolveError:  # redundant joints, or a motion without mass
        found = np.linalg.lstsq(system.jacobian.toarray().T, -r, rcond=None)[0]
    return found if np.isfinite(found).all() else np.zeros(program.n_c)


def _block(system: StateEvaluation) -> np.ndarray:
    """The present matrix of the bodies (n_b, n_b) as a plain array."""
    n = system.program.tables.sizes.n_b
    return system.dense[:n, :n]


def linear_modes(system: StateEvaluation, state: State, released: Released) -> LinearModes:
    """Modes with a positive stiffness about a state; of large models the lowest ones."""
    program, n_b, (lam, _, M, G, Z) = system.program, system.program.tables.sizes.n_b, released
    large = n_b > DENSE
    stiff, damped, _ = np.eye(3)
    # the first one is without the stiffness of gravity
    found = (_at(system, state, lam=one, weights=w) for one, w in ((None, stiff), (lam, stiff), (lam, damped)))
    elastic, K, C = (one.blocks[0] if large else _block(one) for one in found)
    if large:
        squares, x = undamped(K, M, G, np.zeros((program.n_q, 0)), LOWEST, program.symbolic.order)
    else:
        squares, y = all_modes(Z.T @ K @ Z, Z.T @ M @ Z)
        x = Z @ y
    rising = np.argsort(squares)
    rising = rising[squares[rising] > (RIGID_OF_LARGE if large else RIGID) * np.abs(squares).max(initial=0.0)]
    x, squares = x[:, rising], squares[rising]  # the rest is round-off
    own = (x * (elastic @ x)).sum(axis=0)
    return LinearModes(np.sqrt(squares), 0.5 * (x * (C @ x)).sum(axis=0), x[:n_b], own > 0.5 * squares)


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
