"""Closing of loops; consistent positions, velocities, accelerations and multipliers; joints redundant in every pose."""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary, ref

import numpy as np

from flexmb import arguments, checks
from flexmb.engine.linalg import lu
from flexmb.engine.linalg.dense import DENSE_UNKNOWNS, bordered_solution, plain, scaled_rows, stacked
from flexmb.engine.linalg.rank import RANK_TOLERANCE, dependent_rows, surplus_rows
from flexmb.engine.linalg.symbolic import Symbolic
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.engine.system.work import MOTION, Work
from flexmb.errors import AssemblyError, KernelError, ModelError, SolveError
from flexmb.late import scipy, sp
from flexmb.model.mechanism import Mechanism
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.program.program import Program, freeze


# Rigid motions of all bodies of a program, for closing loops and for start velocities
class RigidMotion:
    """Motions of all bodies as rigid ones, flexible bodies included: w = (x, y, angle) for each body."""

    # States of controls, behind the coordinates of the bodies, have no part in these motions. Poses may hold them.

    def __init__(self, program: Program) -> None:
        self.program = program
        self.body = np.asarray(program.reference.body[: program.tables.sizes.n_b : 3])  # of each node
        self.turns = np.asarray(program.reference.turns)[: len(self.body)]
        self.count = len(program.names.bodies)
        self.sizes = np.tile([program.length, program.length, 1.0], self.count)  # of w
        self.first = np.full(self.count, -1)
        self.first[self.body[::-1]] = np.arange(len(self.body))[::-1]  # of several the last one stays

    def basis(self, q: np.ndarray) -> sp.csr_matrix:
        """B (n_q, 3 bodies): velocities of the coordinates by velocities of the bodies about their first nodes."""
        return sp.csr_matrix(self._entries(q), shape=(self.program.n_q, 3 * self.count))

    def plain_basis(self, q: np.ndarray) -> np.ndarray | sp.csr_matrix:
        """`basis` as a plain array, for at most DENSE_UNKNOWNS unknowns (see `engine/linalg/dense.py`)."""
        if self.program.symbolic.n > DENSE_UNKNOWNS:
            return self.basis(q)
        values, places = self._entries(q)
        B = np.zeros((self.program.n_q, 3 * self.count))
        B[places] = values
        return B

    def _entries(self, q: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
        """Values of B, with their rows and columns."""
        nodes = np.arange(len(self.body))
        pose = q.reshape(-1, 3)[: len(nodes)]
        arms, column = pose - pose[self.first[self.body]], 3 * self.body
        rows = np.concatenate([3 * nodes, 3 * nodes + 1, 3 * nodes + 2, 3 * nodes, 3 * nodes + 1])
        columns = np.concatenate([column, column + 1, column + 2, column + 2, column + 2])
        ones = np.ones(len(nodes))
        return np.concatenate([ones, ones, self.turns, -arms[:, 1], arms[:, 0]]), (rows, columns)

    def moved(self, q: np.ndarray, w: np.ndarray) -> np.ndarray:
        """Coordinates after the bodies have moved by w (finite rotations)."""
        n, shift = 3 * len(self.body), w.reshape(-1, 3)[self.body]
        pose = q[:n].reshape(-1, 3)
        centre, c, s = pose[self.first[self.body]], np.cos(shift[:, 2]), np.sin(shift[:, 2])
        dx, dy = (pose - centre)[:, 0], (pose - centre)[:, 1]
        x, y = centre[:, 0] + shift[:, 0] + c * dx - s * dy, centre[:, 1] + shift[:, 1] + s * dx + c * dy
        return np.append(np.column_stack([x, y, pose[:, 2] + self.turns * shift[:, 2]]).ravel(), q[n:])


def body_rows(program: Program, q: np.ndarray, t: float = 0.0) -> Any:
    """G B (n_c, 3 bodies): rows of the constraints by motions of the bodies, at a pose q (n_q,) and a time t [s]."""
    return StateEvaluation(program).at(q, t=t).blocks[1] @ RigidMotion(program).plain_basis(q)


def by_part(program: Program, values: np.ndarray) -> dict[str, float]:
    """Root of the sum of squares of the values (n_c,) of constraint rows, by the name of their part."""
    found: dict[str, float] = {}
    for row, value in zip(program.names.rows, values, strict=True):
        name = row.partition("[")[0]
        found[name] = float(np.hypot(found.get(name, 0.0), value))
    return found


# Massless links: whether each of their motions moves a mass

NO_INERTIA = 1e-12  # inertia of a motion over the largest of the mechanism, below which a massless link moves alone
SHARE = 0.1  # part of the fastest coordinate of such a motion, above which a link is named


def check_massless(mechanism: Mechanism, program: Program, q: np.ndarray) -> None:
    """Refuse massless links that move without moving a mass, at a closed pose (n_q,), all bodies taken as rigid."""
    massless = [k for k, body in enumerate(mechanism.bodies) if body.is_massless]
    if not massless:
        return
    rigid = RigidMotion(program)
    M, G = StateEvaluation(program).at(q, weights=(0.0, 0.0, 1.0)).blocks
    B, sizes = plain(rigid.plain_basis(q)), np.tile([1.0, 1.0, 1.0 / program.length], rigid.count)
    inertia = sizes[:, None] * (B.T @ plain(M) @ B) * sizes
    own = np.concatenate([3 * k + np.arange(3) for k in massless])
    inertia[own, :] = inertia[:, own] = 0.0
    free = scipy.linalg.null_space(plain(G) @ B * sizes, rcond=RANK_TOLERANCE) if program.n_c else None
    ways = np.eye(3 * rigid.count) if free is None else free
    if ways.shape[1] == 0:
        return
    values, vectors = scipy.linalg.eigh(ways.T @ inertia @ ways)
    if values[0] > NO_INERTIA * max(float(np.abs(inertia).max()), 1e-300):
        return
    motion = np.abs(ways @ vectors[:, 0]).reshape(-1, 3).max(axis=1)
    names = [program.names.bodies[k] for k in massless if motion[k] > SHARE * motion.max()]
    listed = f"{'link' if len(names) == 1 else 'links'} {', '.join(map(repr, names))}"
    text = f"Mechanism {program.name!r}: massless {listed} can move without moving a mass, so forces"
    raise ModelError(f"{text} have nothing to accelerate. Give mass and inertia, or hold the link by a further joint.")


CLOSED_LOOP = 1e-12  # gap of a closed joint relative to the size of the mechanism
DRIVE_STRIDE = 0.1  # largest change of a drive between two poses [rad, or relative to the size of the mechanism]
MOST_ITERATIONS = 60  # number of Newton iterations of a stride at most
LARGEST_MOVE = 0.3  # largest movement of a body in an iteration [rad, or relative to the size of the mechanism]
SPARSE_ENTRIES = 400_000  # entries of the constraint matrix above which sparse factors find the least movement


@dataclass(frozen=True)
class Pose:
    """Coordinates of an assembled mechanism."""

    q: np.ndarray  # (n_q,) coordinates [m, rad]
    names: tuple[str, ...]  # (n_q,) their names
    gap: float  # largest gap of a joint [m or rad]
    aliases: dict[str, str]  # other names of nodes

    def __getitem__(self, name: str) -> float:
        stem, _, axis = name.rpartition(".")
        return float(self.q[self.names.index(f"{self.aliases.get(stem, stem)}.{axis}")])


@arguments.checked
def assemble(mechanism: Mechanism, drives: Mapping[str, float] | None = None) -> Pose:
    """Close all joints from the reference configuration, with ideal joints for contacts and rigid bodies.

    The drives move from the reference configuration to their positions in small strides: every loop keeps its branch.

    Parameters
    ----------
    mechanism : the mechanism.
    drives : position of each drive from the reference configuration [rad, m]; default: its motion at t = 0.

    Raises
    ------
    AssemblyError : a loop that cannot close; says which joint is open and by how much.
    InputError : the name of no drive.
    """
    program = compile_mechanism(mechanism, start=True)
    target = {}
    for name, value in checks.mapping(f"assemble {mechanism.name!r}", "drives", drives).items():
        checks.one_of(f"assemble {mechanism.name!r}", "drive", name, program.drives)
        target[name] = checks.number(f"assemble {mechanism.name!r}", name, value)
    q, gap = close_loops(program, target)
    return Pose(q, program.names.coordinates, gap, program.names.aliases)


def drive_rows(program: Program) -> dict[str, int]:
    """Number of the constraint equation of each drive, or driven coordinate of a clamp."""
    return dict(zip(program.drives, map(int, np.flatnonzero(program.tables.constraints.motion >= 0)), strict=True))


def close_loops(
    program: Program, target: Mapping[str, float], start: np.ndarray | None = None, t: float = 0.0
) -> tuple[np.ndarray, float]:
    """Closed pose and its largest gap, from a start pose; `target`: positions of drives in place of their motions."""
    system, rigid = StateEvaluation(program), RigidMotion(program)
    q = np.array(program.reference.q if start is None else start)
    g = system.at(q, t=t).residual
    motion = dict(zip(program.drives, system.work.drive[program.tables.constraints.motion >= 0, MOTION], strict=True))
    rows = drive_rows(program)
    # shift turns the rows of the drives into measure - target; `ahead` is what they have to go
    shift = np.zeros(program.n_c)
    for name, value in target.items():
        shift[rows[name]] = motion[name] - value
    ahead, driven = np.zeros(program.n_c), list(rows.values())
    ahead[driven] = (g + shift)[driven]
    strides, gap = max(1, int(np.ceil(np.abs(ahead).max(initial=0.0) / DRIVE_STRIDE))), 0.0
    for k in range(1, strides + 1):
        q, gap = _newton(program, system, rigid, q, shift - ahead * (1.0 - k / strides), t)
    return q, gap


def _newton(
    program: Program, system: StateEvaluation, rigid: RigidMotion, q: np.ndarray, shift: np.ndarray, t: float
) -> tuple[np.ndarray, float]:
    """Solve g + shift = 0 by least movements of the bodies; return the pose and its largest gap."""
    wanted, gap, best = CLOSED_LOOP * program.length, np.inf, np.inf
    for _ in range(MOST_ITERATIONS):
        system.at(q, t=t)
        g = system.residual + shift
        gap = float(np.abs(g).max()) if len(g) else 0.0
        if gap <= wanted:
            return q, gap
        best, w = min(best, gap), least_shift(system.blocks[1] @ rigid.plain_basis(q), -g, rigid.sizes)
        largest = np.abs(w / rigid.sizes).max(initial=0.0)
        q = rigid.moved(q, w * (LARGEST_MOVE / largest) if largest > LARGEST_MOVE else w)
    if gap <= 1e3 * wanted:
        return q, gap
    worst = sorted(by_part(program, g).items(), key=lambda item: -item[1])[:4]
    listed = ", ".join(f"{name!r} by {value:.4g}" for name, value in worst)
    text = f"Mechanism {program.name!r} cannot be assembled: joints stay open, {listed} (m or rad; {gap:.3g} at worst)."
    text += " Check the lengths of the links in that loop, or choose positions of the drives that it can reach."
    raise AssemblyError(text)


def least_shift(A: Any, b: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """The w with the least norm of w/sizes that minimises |A w - b|; A plain, or sparse (hundreds of bodies)."""
    m, n = A.shape
    A = A * sizes if isinstance(A, np.ndarray) else A.multiply(sizes).tocsr()
    if not isinstance(A, np.ndarray) and m * n > SPARSE_ENTRIES:
        found = bordered_solution(sp.eye_array(n), A, np.concatenate([np.zeros(n), b]))
        if found is not None and np.abs(A @ found[:n] - b).max() <= 1e-9 * np.abs(b).max():
            return np.asarray(sizes * found[:n])
    return np.asarray(sizes * np.linalg.lstsq(plain(A), b, rcond=1e-10)[0])


POSE_SHIFT = 0.05  # shift to a second pose that tells redundant joints from a singular pose [rad, or over the size]


class Redundancy(NamedTuple):
    """Constraint equations that depend on others at a pose."""

    joints: tuple[str, ...]  # parts whose equations repeat one another without the drives
    rows: int  # number of redundant equations among these
    driven: tuple[str, ...]  # parts whose equations repeat one another with the drives, beyond those
    excess: int  # number of further redundant equations
    structural: bool  # whether the excess does not depend on the pose

    @property
    def parts(self) -> tuple[str, ...]:
        """All these parts."""
        return tuple(dict.fromkeys((*self.joints, *self.driven)))


def redundancy(program: Program, q: np.ndarray, system: StateEvaluation | None = None) -> Redundancy | None:
    """Redundant equations at a pose (n_q,); None where all are independent."""
    system = system or StateEvaluation(program)
    G = system.at(q).blocks[1]
    every = len(surplus_rows(G))
    if every == 0:
        return None
    joints = np.flatnonzero(np.asarray(program.tables.constraints.motion) < 0)
    own = len(surplus_rows(G[joints]))
    names = dependent_parts(program, G[joints], joints) if own else ()
    if every == own:
        return Redundancy(names, own, (), 0, False)
    shaken = system.at(shaken_pose(program, q)).blocks[1]
    structural = len(surplus_rows(shaken)) - len(surplus_rows(shaken[joints]))
    driven = dependent_parts(program, shaken if structural > 0 else G)
    return Redundancy(names, own, driven, max(every - own, structural), structural > 0)


def dependent_parts(program: Program, G: Any, rows: np.ndarray | None = None) -> tuple[str, ...]:
    """Names of parts whose equations depend on one another, by G (rows, coordinates) or its rows `rows`."""
    numbers = dependent_rows(G) if rows is None else rows[list(dependent_rows(G))]
    return tuple(dict.fromkeys(program.names.rows[k].partition("[")[0] for k in numbers))


def shaken_pose(program: Program, q: np.ndarray) -> np.ndarray:
    """A pose without any symmetry near q, in which joints are open: rows that depend there always do."""
    # q is a pose of the bodies alone or with the states of controls.
    return np.asarray(q + POSE_SHIFT * np.sin(1.0 + 7.3 * np.arange(len(q))) * program.sizes[: len(q)])


def redundant_rows(program: Program, closed: Program, q: np.ndarray, t: float) -> int:
    """Number of rows redundant at an assembled pose q (n_q,) at t [s] and beside it; 0 for a singular pose."""
    extra = len(surplus_rows(StateEvaluation(program).at(q, t=t).blocks[1]))
    if extra == 0:
        return 0
    # The pose beside it is closed, the drives are moved as well, in a direction without symmetry.
    rigid, rows, system = RigidMotion(closed), drive_rows(closed), StateEvaluation(closed).at(q, t=t)
    A = plain(system.blocks[1] @ rigid.plain_basis(q))
    ways = scipy.linalg.null_space(A[np.setdiff1d(np.arange(closed.n_c), list(rows.values()))], rcond=RANK_TOLERANCE)
    if ways.shape[1]:
        w = ways @ np.cos(1.0 + 2.3 * np.arange(ways.shape[1]))
        q = rigid.moved(q, POSE_SHIFT * w / np.abs(w).max())
        motion = system.at(q, t=t).work.drive[closed.tables.constraints.motion >= 0, MOTION]
        # where the drives stand now
        target = {name: float(s + system.work.g[row]) for (name, row), s in zip(rows.items(), motion, strict=True)}
        try:
            q = close_loops(closed, target, start=q, t=t)[0]
        except AssemblyError:
            return 0
    return extra if len(surplus_rows(StateEvaluation(program).at(q, t=t).blocks[1])) == extra else 0


def least_norm(
    program: Program, q: np.ndarray, v: np.ndarray, t: float, z: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Accelerations (n_q,) and multipliers (n_c,) of least norm; z (n_z,) is the history, None: that of the start."""
    system = StateEvaluation(program).at(q, v, t=t, z=z, weights=(0.0, 0.0, 1.0))
    M, G = system.blocks
    needed = np.setdiff1d(np.arange(program.n_c), surplus_rows(G))
    found = bordered_solution(M, G[needed], np.concatenate([-system.force, system.gamma[needed]]))
    if found is None:
        raise SolveError(f"Start accelerations of {program.name!r}: the matrix is singular. Give every body some mass.")
    a = found[: program.n_q]
    return a, np.linalg.lstsq(plain(G).T, -(system.force + M @ a), rcond=RANK_TOLERANCE)[0]


def held_rows(program: Program, work: Work, q: np.ndarray, t: float, redundant: int) -> tuple[int, ...]:
    """Rows that the factors at a regular pose q (n_q,) at t [s] hold, of which `redundant` are so in every pose."""
    # The workspace is overwritten. None where another number is held: bodies without inertia, a singular pose.
    seen = np.zeros(program.symbolic.n)
    values = StateEvaluation(program, work).at(q, t=t, weights=(0.0, 0.0, 1.0)).work.lu.copy()
    lu.factor(lu.tables(program.symbolic), values, seen, lu.LOST_PIVOT, program.n_q)
    held = program.symbolic.order[seen < 0.0] - program.n_q
    return tuple(held.tolist()) if len(held) == redundant else ()


def looks_dependent(program: Program, work: Work, q: np.ndarray, redundant: int) -> bool:
    """Whether independent constraint rows look redundant, because some inertia is very small."""
    # The pivots depend on the directions of the bodies, so that three rotations of the mechanism are tested; a rotation
    # at which a kernel refuses its arguments is left out. The workspace is overwritten; `redundant` rows are so in
    # every pose, q (n_q,) is the pose at the start.
    system, angles = StateEvaluation(program, work), np.asarray(program.tables.kind) == 1
    for turn in (0.0, 0.7, 2.3):
        try:
            values = system.at(q + turn * angles, weights=(0.0, 0.0, 1.0)).work.lu.copy()
        except KernelError:
            continue
        seen = np.zeros(program.symbolic.n)
        lu.factor(lu.tables(program.symbolic), values, seen, lu.LOST_PIVOT, program.n_q, 10.0 * lu.HELD_PIVOT)
        if int((seen < 0.0).sum()) > redundant:
            return True
    return False


LISTED_PARTS = 12  # number of parts in a list at most
ROUND_OFF_OF_RATES = 1e-12  # start velocity over the drives' largest rate that is round-off of a start at rest
RATES = 32  # number of intervals of a motion at whose ends its rate is looked at
SETTLED = 1e-12  # last correction of the states of controls that begin at rest, relative to the states
NO_ENERGY = 1e-14  # inertia of a motion relative to the largest, that of bodies without inertia in start velocities
YIELD = 1e-8  # compliance of velocity rows over the inverse of the largest inertia: start velocities of large models
MOST_ROUNDS = 100  # number of rounds at most in which these rows become rigid
SETTLED_VELOCITY = 1e-7  # change of a start velocity in a round over the largest, below which it may be round-off
MOST_FRICTION_ITERATIONS = 30  # number of Newton iterations at most on multipliers that friction depends on


@dataclass(frozen=True)
class Start:
    """Consistent start values, which satisfy constraints, their rates and the equations of motion."""

    q: np.ndarray  # (n_q,) as velocities and accelerations
    v: np.ndarray
    a: np.ndarray
    lam: np.ndarray  # (n_c,) multipliers
    redundant: int = 0  # number of redundant constraint equations


def consistent_start(
    mechanism: Mechanism, program: Program, t: float = 0.0, *, redundant: bool = False, closed: Program | None = None
) -> Start:
    """Start values of a mechanism: clearance joints centred, bodies without a declared field unstressed and rigid."""
    # The time is in s. Joints that are `redundant` in every pose have the multipliers of least norm; `closed` is the
    # mechanism compiled with `start=True`.
    # An `AssemblyError` tells loops that cannot close, joints that are not independent, a singular pose, or declared
    # velocities that the joints forbid; a `SolveError` a coordinate without mass.
    closed = compile_mechanism(mechanism, start=True) if closed is None else closed
    own = closed.reference  # all that pose and velocities depend on, beside the structure of `program`:
    arrays = [array.tobytes() for array in (closed.tables.p, own.q, own.v, own.z, own.body, own.turns)]
    kinds = [*map(type, closed.motions)]
    ideal = ref(closed.symbolic), DENSE_UNKNOWNS, t, redundant, closed.length, closed.periods, kinds, arrays
    q, _ = latest(program, "pose", ideal, lambda: close_loops(closed, {}, t=t))
    extra = redundant_rows(program, closed, q, t) if redundant else 0
    system, pose = StateEvaluation(program), with_states(program, q, q)[0]
    if extra == 0:
        latest(program, "joints", ideal, lambda: check_independent(program, pose, system, least_norm=redundant))
    check_massless(mechanism, program, pose)
    same, soft = system if closed is program else None, yielding_joints(program, closed)
    v = latest(program, "velocities", ideal, lambda: rigid_velocities(closed, q, t, soft, same))
    q, v = with_states(program, q, v)
    if program.settled:  # states of controls in which their rates are 0, by Newton's method
        v, dofs = v.copy(), np.array(program.settled)
        for _ in range(MOST_FRICTION_ITERATIONS):
            rate = system.at(q, v, t=t, weights=(0.0, 1.0, 0.0)).force[dofs]
            shift = np.linalg.lstsq(plain(system.blocks[0])[np.ix_(dofs, dofs)], rate, rcond=None)[0]
            v[dofs] -= shift
            if np.abs(shift).max() <= SETTLED * np.abs(v[dofs]).max():
                break
        else:
            names = ", ".join(repr(program.names.coordinates[k]) for k in dofs)
            text = f"Mechanism {program.name!r}: no start values of {names} make their rates 0."
            raise SolveError(f"{text} Give start values.")
    a, lam = least_norm(program, q, v, t) if extra else accelerations(program, q, v, t, system=system)
    return Start(q, v, a, lam, extra)


_LATEST: WeakKeyDictionary[Symbolic, dict[str, tuple[Any, Any]]] = WeakKeyDictionary()  # key and result by name


def latest(program: Program, name: str, key: Any, make: Callable[[], Any]) -> Any:
    """The result of `make`, or the latest one of that name for a program of this structure, if its key was the same."""
    # In a sweep of a clearance the mechanism with ideal joints is the same at all points. Kernels are pure functions.
    known = _LATEST.setdefault(program.symbolic, {})
    found = known.get(name)
    if found is None or found[0] != key:
        found = key, make()
        freeze(found[1])
        known[name] = found
    return found[1]


def with_states(program: Program, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities of bodies (n_b,), with the start values of the states of controls behind them (n_q,)."""
    states = np.asarray(program.reference.v)[program.tables.sizes.n_b :]
    if len(states) == 0 or len(q) == program.n_q:
        return q, v
    return np.append(q, np.zeros(len(states))), np.append(v, states)


def check_independent(
    program: Program, q: np.ndarray, system: StateEvaluation | None = None, *, least_norm: bool = False
) -> None:
    """Refuse redundant joints at q, with their names and whether the pose or the mechanism is the reason."""
    system = system or StateEvaluation(program)
    if (found := redundancy(program, q, system)) is None:
        return
    parts, count = found.parts, found.rows + found.excess
    listed = ", ".join(repr(p) for p in parts[:LISTED_PARTS]) + (", ..." if len(parts) > LISTED_PARTS else "")
    drives = [repr(p) for p in parts if p in {drive.partition(".")[0] for drive in program.drives}]
    if len(surplus_rows(system.at(shaken_pose(program, q)).blocks[1])) < count:
        text = f"Mechanism {program.name!r} starts in a singular pose: there, {listed} repeat one another, and the"
        text += " motion can branch. Start a little beside it (e.g. another crank angle), or, if the links are parallel"
        text += " on purpose, remove one joint or make a link flexible"
        remedy = "; redundant='least-norm' is for joints that repeat one another in every pose."
        raise AssemblyError(text + (remedy if least_norm else ", or simulate(..., redundant='least-norm')."))
    fewer = f"a drive ({', '.join(drives)})" if drives else "one"
    text = f"Mechanism {program.name!r} is over-constrained by {count} row(s): {listed} repeat one another."
    text += f" Remove {fewer}, replace a Prismatic or Fixed by a Revolute, make a link flexible,"
    raise ModelError(f"{text} or simulate(..., redundant='least-norm').")


def yielding_joints(program: Program, closed: Program) -> frozenset[str]:
    """Names of the joints that yield to declared velocities: with clearance, or elastic."""
    always = {row.partition("[")[0] for row in program.names.rows}
    own = {name.partition(".")[0] for name in program.names.contacts}
    return frozenset(own | ({row.partition("[")[0] for row in closed.names.rows} - always))


def rigid_velocities(
    closed: Program, q: np.ndarray, t: float, soft: Container[str] = (), system: StateEvaluation | None = None
) -> np.ndarray:
    """Velocities (n_q,) of rigid bodies by the drives, with least kinetic energy in all free motions."""
    # Declared velocities hold exactly; `AssemblyError` if joints forbid them. Joints named in `soft` (with clearance,
    # or elastic) yield to declared velocities, so that a journal can be thrown into its bearing. v = B w + d, with
    # rigid motions B w and the remainder d of declared fields. Equation (1.10) of docs/theory/equations_of_motion.md.
    system, rigid = system or StateEvaluation(closed), RigidMotion(closed)
    B = rigid.plain_basis(q)
    declared, d = declared_rows(closed, rigid, B)
    M, G = system.at(q, d, t=t, weights=(0.0, 0.0, 1.0)).blocks
    A = stacked(G @ B, B[declared])
    b = np.concatenate([-system.velocity_residual, (closed.reference.v - d)[declared]])
    owners = [row.partition("[")[0] for row in closed.names.rows]
    owners += [closed.names.coordinates[k] for k in declared]
    inertia = B.T @ M @ B
    wanted = 1e-7 * max(float(np.abs(b).max(initial=0.0)), float(np.abs(d).max(initial=0.0)), 1e-30)
    w = least_energy(inertia, A, b)
    hard = np.array([owner not in soft for owner in owners], dtype=bool)
    if np.abs(A @ w - b).max(initial=0.0) > wanted and not hard.all():
        weight = np.where(hard, 1e7, 1.0)
        w = least_energy(inertia, scaled_rows(weight, A), weight * b)
    missed = np.where(hard, np.abs(A @ w - b), 0.0)
    if missed.max(initial=0.0) > wanted and missed.max() > ROUND_OFF_OF_RATES * largest_rate(closed):
        # with declared velocities held, what stays open is the joint's: it shall be named, and by its own size
        weight = np.where(np.arange(len(b)) >= len(b) - len(declared), 1e7, 1.0)
        w = least_energy(inertia, scaled_rows(weight, A), weight * b)
        missed = np.where(hard, np.abs(A @ w - b), 0.0)
        text = f"Mechanism {closed.name!r}: no start velocities satisfy all joints, drives and declared velocities;"
        text += f" largest violation {missed.max():.3g} m/s or rad/s at {owners[int(missed.argmax())]!r}."
        raise AssemblyError(f"{text} {_remedy_of_velocities(closed, declared)}")
    return np.asarray(B @ w + d)


def _remedy_of_velocities(closed: Program, declared: np.ndarray) -> str:
    """Remedies for velocities that contradict one another: of drives, of declared velocities, of flexible bodies."""
    remedies, owner = [], np.asarray(closed.reference.body)[: closed.tables.sizes.n_b]
    if len(declared):
        remedies.append("Correct the declared velocities, or leave out one that joints and drives impose.")
        flexible = np.bincount(owner) > 3
        flexible[owner[declared]] = False
        names = ", ".join(f"{name!r}" for name, free in zip(closed.names.bodies, flexible, strict=True) if free)
        if names:
            remedies.append(f"Flexible bodies begin as rigid ones: {names} without velocity= of each node cannot bend.")
    if closed.drives:
        remedies.append("A drive cannot move a dead centre: start elsewhere.")
        if len(closed.reference.q) > 3 * len(closed.names.bodies):
            rest = "begin its motion at rest, e.g. CycloidalRamp, or Table(..., slopes=(0.0, 0.0))"
            remedies.append(f"A flexible body begins as a rigid one: where a drive bends it, {rest}.")
    return " ".join(remedies) or "Begin in another pose."


def largest_rate(program: Program) -> float:
    """Largest rate of all drives over their periods, or over their breaks or 1 s without a period [m/s, rad/s]."""
    largest = 0.0
    for motion in program.motions[: len(program.drives)]:
        p, span = np.array(motion.parameters(), dtype=float), motion.period or max(1.0, *motion.breaks(1e3), 0.0)
        rates = np.abs([motion.kernel(p, float(t))[1] for t in np.linspace(0.0, span, RATES + 1)])
        largest = max(largest, float(rates[np.isfinite(rates)].max(initial=0.0)))
    return largest


def declared_rows(closed: Program, rigid: RigidMotion, B: Any) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates that represent declared rigid motions, nearest to fields, and the remainder d (n_q,) of fields."""
    v = np.asarray(closed.reference.v)
    declared = np.flatnonzero(~np.isnan(v))
    body = rigid.body[declared // 3]  # in order, as the coordinates are
    rows, d = [], np.zeros(len(v))
    bounds = np.searchsorted(body, np.arange(rigid.count + 1)).tolist() if len(body) else [0]
    for k, (begin, end) in enumerate(pairwise(bounds)):
        given = declared[begin:end]
        if len(given) > 3:
            own = plain(B[given][:, 3 * k : 3 * k + 3])
            size = np.array([1.0, 1.0, max(float(np.abs(own[:, 2]).max()), 1e-300)])
            d[given] = v[given] - own @ (np.linalg.lstsq(own / size, v[given], rcond=None)[0] / size)
        rows.append(given[:3])
    return np.concatenate([*rows, np.zeros(0, dtype=np.int64)]).astype(np.int64), d


def least_energy(inertia: Any, A: Any, b: np.ndarray) -> np.ndarray:
    """The w of least w^T inertia w that minimises |A w - b|; rows of A may depend on one another."""
    n, m, scale = A.shape[1], A.shape[0], max(float(inertia.max()), 1e-300)
    if m <= n:
        found = bordered_solution(inertia / scale, A, np.concatenate([np.zeros(n), b]))
        if found is not None and np.abs(A @ found[:n] - b).max(initial=0.0) <= 1e-10 * np.abs(b).max(initial=1e-30):
            return found[:n]
    if not isinstance(A, np.ndarray) and (w := yielding_rows(inertia / scale, A, b)) is not None:
        return w
    values, vectors = np.linalg.eigh(plain(inertia))
    values = np.maximum(values, NO_ENERGY * values.max())  # bodies without inertia move as the joints want
    root = vectors / np.sqrt(values)
    return np.asarray(root @ np.linalg.lstsq(A @ root, b, rcond=1e-11)[0])


def yielding_rows(inertia: Any, A: Any, b: np.ndarray) -> np.ndarray | None:
    """The w of `least_energy` for sparse matrices, largest entry of the inertia 1; None where it is not found."""
    # Rows yield to the change of their multipliers s, A w - YIELD (s - s_before) = b, so that dependent ones leave the
    # matrix regular; s is iterated until w is settled (method of multipliers). Of rows that contradict one another some
    # 1e-8 of the contradiction is left.
    m, n = A.shape
    whole = sp.block_array([[inertia + NO_ENERGY * sp.eye_array(n), A.T], [A, -YIELD * sp.eye_array(m)]])
    factors, w, s, before = sp.linalg.splu(whole.tocsc()), np.zeros(n), np.zeros(m), np.inf
    for _ in range(MOST_ROUNDS):
        found: np.ndarray = factors.solve(np.concatenate([np.zeros(n), b - YIELD * s]))
        change, w = float(np.abs(found[:n] - w).max(initial=0.0)), found[:n]
        s, size = found[n:], float(np.abs(w).max(initial=0.0))
        if change <= 1e-14 * size or (change <= SETTLED_VELOCITY * size and change > 0.5 * before):
            return w
        before = change
    return None


def accelerations(
    program: Program, q: np.ndarray, v: np.ndarray, t: float, z: np.ndarray | None = None, *,
    system: StateEvaluation | None = None,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Accelerations (n_q,) and multipliers (n_c,): M a + G^T lam = -r(q, v, 0), G a = gamma."""
    # z : history (n_z,) at this state, None: that at the start;  system : evaluation of the program, None: a new one
    # Equation (1.11) of docs/theory/equations_of_motion.md.
    system, iterates = system or StateEvaluation(program), program.tables.sizes.has_joint_friction
    system.at(q, v, t=t, z=z, weights=(0.0, 0.0, 1.0))

    def solved() -> tuple[np.ndarray, np.ndarray]:
        lam, (M, G) = np.zeros(program.n_c), system.blocks
        sums = abs(M).sum(axis=1), abs(G).sum(axis=0)  # of sparse matrices these are matrices
        free = np.flatnonzero(np.ravel(sums[0]) + np.ravel(sums[1]) == 0.0)
        if len(free):
            name = program.names.coordinates[free[0]]
            text = f"Mechanism {program.name!r}: coordinate {name!r} has no mass and no joint;"
            raise SolveError(f"{text} give it some mass.")
        for _ in range(MOST_FRICTION_ITERATIONS):
            b = np.concatenate([-system.force - system.constraint_force, system.gamma])
            x = system.solve(b, f"Accelerations of {program.name!r} at t = {t:.6g} s")
            lam = lam + x[program.n_q :]
            if not iterates or np.abs(x[program.n_q :]).max(initial=0.0) <= 1e-14 * np.abs(lam).max(initial=0.0):
                break
            system.at(q, v, lam=lam, t=t, z=z, weights=(0.0, 0.0, 1.0))
        return x[: program.n_q], lam

    if iterates or not system.small:
        return solved()
    equations = [array.tobytes() for array in (system.work.lu, system.work.gamma, system.work.r)]
    return latest(program, "accelerations", equations, solved)  # type: ignore[no-any-return]


def degrees_of_freedom(program: Program, q: np.ndarray) -> tuple[int, int]:
    """Degrees of freedom of the bodies taken as rigid, with and without the drives' rows."""
    A, joints = body_rows(program, q), np.flatnonzero(program.tables.constraints.motion < 0)
    free = 3 * len(program.names.bodies) - A.shape[0] + len(surplus_rows(A))
    return free, 3 * len(program.names.bodies) - len(joints) + len(surplus_rows(A[joints]))


WHOLE_TURN = 2.0 * np.pi
MOST_PROJECTIONS = 30  # number of Newton iterations at most
CLOSED_GAP = 1e-12  # gap of a projected pose relative to the size of the mechanism
FAR_GAP = 1e-14  # the same relative to the largest coordinate, whose round-off counts far from the origin


def projected(program: Program, q: np.ndarray, v: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray]:
    """The positions and velocities (n_q,) nearest to q and v that satisfy all constraints at time t."""
    # Whole turns of the drives are removed first, so that a state of one period may be the start of another: gaps of
    # angles are then less than a turn. Angles count by the size of the mechanism.
    system, metric = StateEvaluation(program), metric_of(program)
    q, angles = np.array(q, dtype=np.float64), np.asarray(program.tables.kind) == 1
    G = plain(system.at(q, t=t).blocks[1])
    turns = np.round(system.residual / WHOLE_TURN)
    rows = np.flatnonzero(np.abs(G[:, ~angles]).max(axis=1, initial=0.0) == 0.0)
    if turns[rows].any():
        shift = np.linalg.lstsq(G[rows][:, angles], -WHOLE_TURN * turns[rows], rcond=1e-11)[0]
        q[angles] += WHOLE_TURN * np.round(shift / WHOLE_TURN)
    for _ in range(MOST_PROJECTIONS):
        G = system.at(q, t=t).blocks[1]
        gap, far = system.residual, np.abs(np.where(angles, program.length, 1.0) * q).max(initial=0.0)
        if np.abs(gap).max(initial=0.0) <= max(CLOSED_GAP * program.length, FAR_GAP * far):
            break
        q = q + shortest_correction(metric, G, -gap)
    else:
        worst = program.names.rows[int(np.abs(gap).argmax())]
        text = f"Mechanism {program.name!r}: the given state is too far from one that its joints allow"
        raise AssemblyError(f"{text}; {worst!r} stays open by {np.abs(gap).max():.3g}. Give a state nearer to it.")
    G = system.at(q, v, t=t).blocks[1]
    return q, np.array(v) + shortest_correction(metric, G, -system.velocity_residual)


def metric_of(program: Program) -> np.ndarray:
    """Weights (n_q,) of squared coordinates: 1; for angles the squared size of the mechanism [m^2]."""
    return np.where(np.asarray(program.tables.kind) == 1, program.length**2, 1.0)


def shortest_correction(metric: np.ndarray, G: Any, b: np.ndarray) -> np.ndarray:
    """The shortest x (n,) in the metric with G x = b, in the sense of least squares for redundant rows."""
    weight: Any = np.diag(metric) if isinstance(G, np.ndarray) else sp.diags_array(metric).tocsc()
    return least_energy(weight, G, b) if len(b) else np.zeros(len(metric))
