"""Closing of loops: poses with all joints closed, at given positions of the drives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb import arguments, checks
from flexmb.engine.linalg.dense import DENSE_UNKNOWNS, bordered_solution, plain
from flexmb.engine.linalg.rank import RANK_TOLERANCE
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.engine.system.work import MOTION
from flexmb.errors import AssemblyError, ModelError
from flexmb.late import scipy, sp
from flexmb.model.mechanism import Mechanism
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.program.program import Program


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


CLOSED_GAP = 1e-12  # gap of a closed joint relative to the size of the mechanism
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
    wanted, gap, best = CLOSED_GAP * program.length, np.inf, np.inf
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
