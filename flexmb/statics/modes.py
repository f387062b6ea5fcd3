"""Natural frequencies and modes of the linearised mechanism, and energies of vibrations in a motion.

Vibrations: the mechanism is linearised about a state with its drives held fast, contacts as they are there, laws of
controllers and the stiffness of gravity included.  The forces that its inertia balances there, divided by omega^2, are
the displacements y of the modes from the pose that drives and loads would give at rest; their first and second time
derivatives are differences along the motion.  In a vibration omega^2 y^2, y'^2 and y''^2/omega^2 have one mean.  What
follows a slower drive has less of the last, what follows a faster one less of the first, so the least of the three
bounds the energy of the vibration.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from flexmb import arguments, checks, display
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import InputError, SolveError
from flexmb.fields import field, record
from flexmb.late import scipy, sp
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import refuse_controllers
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.program.program import Program, resolve
from flexmb.statics import eigen, equilibrium
from flexmb.statics.equilibrium import Equilibrium, Spin
from flexmb.statics.start.consistent import close_loops

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
        modes = next((modes for at, modes in reversed(known) if np.abs(q - at).max(initial=0.0) <= NEAR), None)
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
    n = program.tables.sizes.n_b
    if n > DENSE:
        return math.inf
    system, bound = StateEvaluation(program), 0.0
    for state in states:
        released = _released(system, state)
        masses = released.M.diagonal()
        if np.count_nonzero(released.M) != np.count_nonzero(masses) or (masses < 0.0).any():
            return math.inf
        K = np.abs(_at(system, state, lam=released.lam, weights=(1.0, 0.0, 0.0)).dense[:n, :n])
        sizes = np.sqrt(np.where(masses > 0.0, masses, np.finfo(float).tiny))
        bound = max(bound, float((0.5 * (K + K.T) / sizes / sizes[:, None]).sum(axis=1).max(initial=0.0)))
    return math.sqrt(bound)


def _at(system: StateEvaluation, state: State, dt: float = 0.0, **more: Any) -> StateEvaluation:
    """Evaluation at rest, a time dt [s] away from a state along its motion; states of controllers as they are then."""
    v = np.where(np.arange(len(state.q)) < system.program.tables.sizes.n_b, 0.0, state.v + dt * state.a)
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
    rows = G / np.where(lengths > 0.0, lengths, 1.0)[:, None]
    Q, R, order = scipy.linalg.qr(rows.T, pivoting=True, check_finite=False)
    pivots = np.abs(R.diagonal())
    rank = int((pivots > eigen.DEPENDENT_ROW * pivots.max(initial=0.0)).sum())
    Z = Q[:, rank:]
    if rank < len(G):
        lam = _multipliers(system, r)
    else:
        load = M @ (Z @ np.linalg.solve(Z.T @ M @ Z, Z.T @ r[:n])) - r[:n]
        lam = np.empty(rank)
        lam[order] = scipy.linalg.solve_triangular(R[:rank], Q[:, :rank].T @ load, check_finite=False)
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


def linear_modes(system: StateEvaluation, state: State, released: Released) -> LinearModes:
    """Modes with a positive stiffness about a state; of large models the lowest ones."""
    program, n_b, (lam, _, M, G, Z) = system.program, system.program.tables.sizes.n_b, released
    large = n_b > DENSE
    stiff, damped, _ = np.eye(3)
    # the first one is without the stiffness of gravity
    found = (_at(system, state, lam=one, weights=w) for one, w in ((None, stiff), (lam, stiff), (lam, damped)))
    elastic, K, C = (one.blocks[0] if large else one.dense[:n_b, :n_b] for one in found)
    if large:
        squares, x = eigen.undamped(K, M, G, np.zeros((program.n_q, 0)), LOWEST, program.symbolic.order)
    else:
        squares, y = eigen.all_modes(Z.T @ K @ Z, Z.T @ M @ Z)
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
    Z = eigen.null_space(system.dense[n:, :n])
    k, c, m = (Z.T @ A @ Z for A in (K, C, M))
    A = np.block([[np.zeros_like(k), np.eye(len(k))], [-scipy.linalg.solve(m, k), -scipy.linalg.solve(m, c)]])
    s, left, right = scipy.linalg.eig(A, left=True, right=True)
    s, left, right = (x[..., s.imag > 0.0] for x in (s, left, right))
    rates = np.concatenate([Z.T @ state.v, Z.T @ state.a])
    eta = (left.conj().T @ rates) / ((left.conj() * right).sum(axis=0) * s)
    return s, 2.0 * np.abs((Z @ right[len(k) :])[n_b:] * eta).T


ENERGY_ROUND_OFF = 1e-15  # strain energy over the sum of its absolute terms, below which it is round-off
ASYMMETRY_ROUND_OFF = 1e-11  # asymmetry of the stiffness over its largest entry, above which it is no round-off
ASYMMETRY_OF_DIFFERENCES = 1e-7  # the same with controllers, whose laws and measured inputs are differenced
# Sentence on contacts that are left out.
REMEDY = "Give at=fm.static_equilibrium(mechanism) of a pose in which they carry."
SHOWN_MODES = 6  # number of frequencies at most in a text


@record
class Modes:
    """Modes about a pose, drives held fast; `print(modes)` shows a table."""

    frequencies: np.ndarray = field(
        "(n,) natural frequencies [Hz], ascending; 0 for a rigid motion, negative for an unstable one "
        "(-sqrt(|omega^2|)/2 pi). With `damped` or in a turning frame |Im s|/2 pi, ordered by |s|: of the damped "
        "vibration, as seen from the frame"
    )
    shapes: np.ndarray = field("(n_q, n) mode shapes, normalised to x^T M x = 1; complex with `damped` or rotation")
    names: tuple[str, ...] = field("(n_q,) names of the coordinates")
    aliases: dict[str, str] = field("other names of nodes")
    rigid: int = field("number of rigid motions; they come first")
    kinds: tuple[str, ...] = field(
        '(n,) what each mode is: "rigid: rotation of \'rod\'", "elastic", "overdamped", "unstable", "back to unstable" '
        '(decays by negative stiffness rather than by damping), "not resolved" (strain energy lost in round-off)'
    )
    moves: tuple[str, ...] = field("(n,) coordinates that the modes move most, rotations times the size")
    eigenvalues: np.ndarray = field("(n,) complex s [1/s]: motions grow as exp(s t)")
    damping: np.ndarray = field("(n,) damping ratios -Re s/|s|; negative where the motion grows, 0 where s is 0")
    left_out: tuple[str, ...] = field("contacts that take no part: all, about an equilibrium the open ones", default=())

    def shape(self, mode: int, name: str) -> float | complex:
        """Amplitude of a coordinate, `name` "rod.node3.y", in the `mode` of this number, from 0."""
        if not 0 <= checks.count("Modes", "mode", mode, 0) < self.shapes.shape[1]:
            raise InputError(f"Modes: mode is {mode}; there are modes 0 to {self.shapes.shape[1] - 1}.")
        place = resolve(name, self.aliases)
        value = self.shapes[self.names.index(checks.one_of("Modes", "coordinate", place, self.names)), mode]
        return complex(value) if np.iscomplexobj(self.shapes) else float(value)

    def __repr__(self) -> str:
        elastic = [f"{f:.4g}" for f in self.frequencies[self.rigid :][:SHOWN_MODES]]
        more = ", ..." if len(self.frequencies) - self.rigid > SHOWN_MODES else ""
        rigid = f", {self.rigid} rigid" if self.rigid else ""
        shown = f"; {', '.join(elastic)}{more} Hz" if elastic else ""
        return f"Modes: {len(self.kinds)}{rigid}{shown}"

    def _repr_html_(self) -> str:
        columns = zip(self.frequencies, self.damping, self.kinds, self.moves, strict=True)
        rows = [(k, f"{f:.6g}", f"{d:.4g}", kind, moves) for k, (f, d, kind, moves) in enumerate(columns)]
        table = display.table(rows, ("mode", "frequency [Hz]", "damping", "kind", "moves most"))
        return display.page(repr(self), "", table, display.texts(equilibrium.left_out_texts(self.left_out, REMEDY)))

    def __str__(self) -> str:
        """A table: number, frequency, damping ratio, kind, where it moves most; contacts that are left out."""
        if not self.kinds:
            return "no modes: nothing can move"
        width = max(4, *(len(kind) for kind in self.kinds))
        rows = [f"mode  frequency [Hz]  damping    {'kind':{width}}  moves most"]
        for k, kind in enumerate(self.kinds):
            numbers = f"{self.frequencies[k]:14.6g}  {self.damping[k]:<9.4g}"
            rows.append(f"{k:4d}  {numbers}  {kind:{width}}  {self.moves[k]}")
        return "\n".join([*rows, *equilibrium.left_out_texts(self.left_out, REMEDY)])


@arguments.checked
def modes(mechanism: Mechanism, count: int = 10, at: Equilibrium | None = None, damped: bool = False) -> Modes:
    """Natural frequencies and modes of small motions about the reference configuration or a static equilibrium.

    Drives hold their position.  Stiffness is that of the pose.  Gravity, forces and contacts count with `at` alone,
    since the reference configuration need not be an equilibrium: a taut cable, a pressed stop, a journal under load
    have the tangent stiffness of their laws there, open ones have none (`left_out`).  Without `at` clearance joints are
    ideal ones.  A controller without states that acts at all times, such as a PD law, has the stiffness of its law and,
    if `damped`, its damping.

    Equation (8.2) of docs/theory/equilibrium.md.

    Parameters
    ----------
    mechanism : the mechanism.
    count : number of modes, lowest first.
    at : a static equilibrium of the same mechanism, or of the one with ideal joints; one that spins makes gyroscopic
        modes, as seen from the turning frame.  Their kinds with `damped` say whether the rotation is stable.
    damped : with the damping of material and dampers; complex eigenvalues, and the shapes in their phases.  Without it
        a turning frame has Coriolis' forces alone, which do no work.

    Raises
    ------
    InputError : an equilibrium of another model; gravity or drives that are not steady in a turning frame.
    SolveError : the eigensolver did not converge; a motion without mass; forces without a potential, when
        `damped` is False.

    Notes
    -----
    Rigid motions are found first, body by body, from G and K alone, and the rest is computed orthogonal to them: no
    frequency is compared with another to tell a rigid motion from a slow one.  In a turning frame nothing is called
    rigid, since every motion has stiffness there.  See `flexmb.statics.equilibrium` for its matrices.
    Source: R. D. Cook, D. S. Malkus, M. E. Plesha, R. J. Witt, Concepts and Applications of Finite Element Analysis,
    4th ed., Wiley 2002, chapter 11; rotation: L. Meirovitch, Computational Methods in Structural Dynamics, Sijthoff and
    Noordhoff 1980, chapter 3.
    """
    count = checks.count("modes", "count", count)
    if not isinstance(damped, bool):
        raise InputError(f"modes: damped is {damped!r}; it must be True or False.")
    if at is not None and not isinstance(at, Equilibrium):
        raise InputError(f"modes: at is {at!r}; it must be what static_equilibrium(...) returns, or None.")
    spin = Spin(at.spin, at.about) if at is not None else Spin(0.0, (0.0, 0.0))
    reason = "motions under a controller with states of its own, or a sampled one, are no vibrations of the structure"
    refuse_controllers(mechanism, "modes", reason, with_memory=not spin.speed)
    program = _program_of(mechanism, at)
    system = StateEvaluation(program)
    q, lam = (close_loops(program, {})[0], np.zeros(program.n_c)) if at is None else (at.q, at.lam)
    gyroscopic = spin.speed and not damped
    D = system.at(q, lam=lam, weights=(0.0, 1.0, 0.0)).block() if gyroscopic else 0.0  # at rest all of C is damping
    K, C, M = spin.matrices(system, q, lam)
    C = 0.5 * ((C - D) - (C - D).T) if gyroscopic else C  # gyroscopic forces do no work
    G = system.jacobian
    left_out = equilibrium.open_contacts(system) if at is not None else equilibrium.unpaired(mechanism)
    equilibrium.check_spin("modes", mechanism, program, system, spin)
    if at is not None:
        equilibrium.refuse_other_forces("modes", program, system, at)
    motions = np.zeros((0, 0)) if spin.speed else eigen.free_motions(program, q, K, G)
    rigid = eigen.shapes_of(program, q, motions, M) if motions.size else np.zeros((program.n_q, 0))
    left, real = max(count - rigid.shape[1], 0), not (damped or spin.speed)
    if not left:
        s, x = np.zeros(0), np.zeros((program.n_q, 0))
    elif real:
        refuse_asymmetry(program, K)
        K = 0.5 * (K + K.T)
        squares, x = eigen.undamped(K, M, G, rigid, left, program.symbolic.order)
        s = np.where(squares < 0.0, np.sqrt(np.abs(squares)) + 0j, 1j * np.sqrt(np.abs(squares)))
    else:
        # Rigid motions that no damper acts on are left out of the problem. Where one does, the problem keeps them: each
        # has s = 0 beside another s of its own, and the lowest |s| are those zeros with their round-off.
        kept = rigid.shape[1] if (np.abs(C @ rigid) > 1e-12 * (abs(C) @ np.abs(rigid))).any() else 0
        s, x = (found[..., kept:] for found in eigen.damped(K, C, M, G, rigid, left + kept, kept=kept > 0))
        x = x / np.sqrt(np.abs((x.conj() * (M @ x)).sum(axis=0)))
    kinds = [f"rigid: {eigen.motion_in_words(program, motion)}" for motion in motions.T[:count]]
    kinds += _kinds(K, s, x)
    s, shapes = np.append(np.zeros(rigid.shape[1]), s)[:count], np.hstack([rigid, x])[:, :count]
    frequencies = (np.abs(s.imag) - (s.real if real else 0.0)) / (2.0 * np.pi)  # of unstable real modes < 0
    damping = -s.real / np.where(s == 0.0, 1.0, np.abs(s)) + 0.0
    names, others = program.names.coordinates, program.names.aliases
    moves = tuple(eigen.moves_most(names, program.length, shape) for shape in shapes.T)
    return Modes(frequencies, shapes, names, others, rigid.shape[1], tuple(kinds), moves, s, damping, left_out)


def _kinds(K: Any, s: np.ndarray, x: np.ndarray) -> list[str]:
    """Kinds of the modes that are not rigid motions."""
    stiffness = (x.conj() * (K @ x)).sum(axis=0)
    terms, found = (np.abs(x) * (abs(K) @ np.abs(x))).sum(axis=0), []
    for k, value in enumerate(s):
        if abs(stiffness[k]) <= ENERGY_ROUND_OFF * terms[k] and np.abs(value.imag) > 0.0:
            found.append("not resolved")
        elif value.real > 1e-9 * np.abs(value):
            found.append("unstable")
        else:
            back = stiffness[k].real < -0.5 * abs(value) ** 2  # of s^2 + d s + k = 0, where x^H M x = 1
            found.append("elastic" if value.imag else "back to unstable" if back else "overdamped")
    return found


def _program_of(mechanism: Mechanism, at: Equilibrium | None) -> Program:
    """Program about the reference configuration, bare, or about an equilibrium, also of ideal joints, with loads."""
    if at is None:
        if isinstance(mechanism, Mechanism):  # else compile says what it is
            # Gravity and forces are left out: their stiffness would need the forces of the joints, too.
            controlled = {name for controller in mechanism.controllers for name in controller.control().loads}
            dead = {part.name for part in mechanism.parts if part.declared_load} - controlled
            mechanism = mechanism.with_loads([part for part in mechanism.parts if part.name not in dead], (0.0, 0.0))
        return compile_mechanism(mechanism, closed=True, controlled=True)
    program = compile_mechanism(mechanism)
    ideal = any(c.holds == "closed" for c in mechanism.contributions().constraints)
    if ideal and (len(at.q), len(at.lam)) != (program.n_q, program.n_c):
        program = compile_mechanism(mechanism, closed=True, controlled=True, touching=True)
    equilibrium.refuse_other_names("modes", program, at)
    return program


def refuse_asymmetry(program: Program, K: sp.csc_matrix) -> None:
    """`SolveError` for forces without a potential: their modes are complex, and may grow."""
    difference = sp.coo_array(abs(K - K.T))
    worst = int(difference.data.argmax()) if difference.nnz else -1
    allowed = ASYMMETRY_OF_DIFFERENCES if len(program.tables.controls.kernel) else ASYMMETRY_ROUND_OFF
    if worst < 0 or difference.data[worst] <= allowed * abs(K).max():
        return
    row, column = (program.names.coordinates[int(k[worst])] for k in (difference.row, difference.col))
    text = f"modes: the stiffness of mechanism {program.name!r} is not symmetric between {row!r} and {column!r},"
    text += " so it has no real modes. A follower force does this, or a controller that measures elsewhere than"
    raise SolveError(f"{text} it acts: ask for modes(..., damped=True), which shows flutter as growth.")
