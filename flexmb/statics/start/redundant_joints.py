"""Joints that are redundant in every pose: number of redundant rows, and multipliers of least norm."""

from typing import Any, NamedTuple

import numpy as np

from flexmb.engine.linalg import lu
from flexmb.engine.linalg.dense import bordered_solution, plain
from flexmb.engine.linalg.rank import RANK_TOLERANCE, dependent_rows, row_rank
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.engine.system.work import MOTION, Work
from flexmb.errors import AssemblyError, KernelError, SolveError
from flexmb.late import scipy
from flexmb.program.program import Program
from flexmb.statics.start.assemble import RigidMotion, close_loops, drive_rows

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
    every = len(row_rank(G).redundant)
    if every == 0:
        return None
    joints = np.flatnonzero(np.asarray(program.tables.constraints.motion) < 0)
    own = len(row_rank(G[joints]).redundant)
    names = dependent_parts(program, G[joints], joints) if own else ()
    if every == own:
        return Redundancy(names, own, (), 0, False)
    shaken = system.at(shaken_pose(program, q)).blocks[1]
    structural = len(row_rank(shaken).redundant) - len(row_rank(shaken[joints]).redundant)
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
    extra = len(row_rank(StateEvaluation(program).at(q, t=t).blocks[1]).redundant)
    if extra == 0:
        return 0
    try:
        further = neighbouring_pose(closed, q, t)
    except AssemblyError:
        return 0
    return extra if len(row_rank(StateEvaluation(program).at(further, t=t).blocks[1]).redundant) == extra else 0


def neighbouring_pose(closed: Program, q: np.ndarray, t: float) -> np.ndarray:
    """A closed pose near q, drives moved as well, in a direction without symmetry."""
    rigid, rows = RigidMotion(closed), drive_rows(closed)
    system = StateEvaluation(closed).at(q, t=t)
    A = plain(system.blocks[1] @ rigid.plain_basis(q))
    held = np.setdiff1d(np.arange(closed.n_c), list(rows.values()))
    ways = scipy.linalg.null_space(A[held], rcond=RANK_TOLERANCE)
    if ways.shape[1] == 0:
        return q
    w = ways @ np.cos(1.0 + 2.3 * np.arange(ways.shape[1]))
    aside = rigid.moved(q, POSE_SHIFT * w / np.abs(w).max())
    system.at(aside, t=t)
    motion = system.work.drive[closed.tables.constraints.motion >= 0, MOTION]
    target = {
        name: float(s + system.work.g[row]) for (name, row), s in zip(rows.items(), motion, strict=True)
    }  # where the drives stand now
    return close_loops(closed, target, start=aside, t=t)[0]


def least_norm(
    program: Program, q: np.ndarray, v: np.ndarray, t: float, z: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Accelerations (n_q,) and multipliers (n_c,) of least norm; z (n_z,) is the history, None: that of the start."""
    system = StateEvaluation(program).at(q, v, t=t, z=z, weights=(0.0, 0.0, 1.0))
    M, G = system.blocks
    needed = np.setdiff1d(np.arange(program.n_c), row_rank(G).redundant)
    found = bordered_solution(M, G[needed], np.concatenate([-system.force, system.gamma[needed]]))
    if found is None:
        text = f"Start accelerations of {program.name!r}: the matrix is singular"
        raise SolveError(f"{text}. Give every body some mass.")
    a = found[: program.n_q]
    lam = np.linalg.lstsq(plain(G).T, -(system.force + M @ a), rcond=RANK_TOLERANCE)[0]
    return a, lam


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
