"""Closing of loops: poses with all joints closed, at given positions of the drives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb import arguments, checks
from flexmb.errors import AssemblyError
from flexmb.linalg.dense_or_sparse import bordered_solution, plain
from flexmb.model.mechanism import Mechanism
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.program.program import Program
from flexmb.start.rigid_motion import RigidMotion
from flexmb.system.state_evaluation import StateEvaluation
from flexmb.system.work import MOTION

CLOSED_GAP = 1e-12
"""Gap of a closed joint relative to the size of the mechanism."""

DRIVE_STRIDE = 0.1
"""Largest change of a drive between two poses [rad, or relative to the size of the mechanism]."""

MOST_ITERATIONS = 60
"""Number of Newton iterations of a stride at most."""

LARGEST_MOVE = 0.3
"""Largest movement of a body in an iteration [rad, or relative to the size of the mechanism]."""

SPARSE_ENTRIES = 400_000
"""Number of entries of the constraint matrix above which the least movement is computed by sparse factors."""


@dataclass(frozen=True)
class Pose:
    """Coordinates of an assembled mechanism.

    Parameters
    ----------
    q : (n_q,) coordinates [m, rad].
    names : (n_q,) their names.
    gap : largest gap of a joint [m or rad].
    aliases : other names of nodes.
    """

    q: np.ndarray
    names: tuple[str, ...]
    gap: float
    aliases: dict[str, str]

    def __getitem__(self, name: str) -> float:
        stem, _, axis = name.rpartition(".")
        return float(self.q[self.names.index(f"{self.aliases.get(stem, stem)}.{axis}")])


@arguments.checked
def assemble(mechanism: Mechanism, drives: Mapping[str, float] | None = None) -> Pose:
    """Close all joints from the reference configuration, with ideal joints for contacts and rigid bodies.

    The drives move from the reference configuration to their positions in small strides, so that every loop keeps its
    branch.

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
    for name, value in (drives or {}).items():
        checks.one_of(f"assemble {mechanism.name!r}", "drive", name, program.drives)
        target[name] = checks.number(f"assemble {mechanism.name!r}", name, value)
    q, gap = close_loops(program, target)
    return Pose(q, program.names.coordinates, gap, program.names.aliases)


def drive_rows(program: Program) -> dict[str, int]:
    """Number of the constraint equation of each drive, or driven coordinate of a clamp."""
    driven = np.flatnonzero(program.tables.constraints.motion >= 0)
    return dict(zip(program.drives, map(int, driven), strict=True))


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
    ahead = np.zeros(program.n_c)
    driven = list(rows.values())
    ahead[driven] = (g + shift)[driven]
    strides = max(1, int(np.ceil(np.abs(ahead).max(initial=0.0) / DRIVE_STRIDE)))
    gap = 0.0
    for k in range(1, strides + 1):
        q, gap = _newton(program, system, rigid, q, shift - ahead * (1.0 - k / strides), t)
    return q, gap


def _newton(
    program: Program, system: StateEvaluation, rigid: RigidMotion, q: np.ndarray, shift: np.ndarray, t: float
) -> tuple[np.ndarray, float]:
    """Solve g + shift = 0 by least movements of the bodies; return the pose and its largest gap."""
    wanted = CLOSED_GAP * program.length
    gap, best = np.inf, np.inf
    for _ in range(MOST_ITERATIONS):
        system.at(q, t=t)
        g = system.residual + shift
        gap = float(np.abs(g).max()) if len(g) else 0.0
        if gap <= wanted:
            return q, gap
        best = min(best, gap)
        w = least_shift(system.blocks[1] @ rigid.plain_basis(q), -g, rigid.sizes)
        largest = np.abs(w / rigid.sizes).max(initial=0.0)
        q = rigid.moved(q, w * (LARGEST_MOVE / largest) if largest > LARGEST_MOVE else w)
    if gap <= 1e3 * wanted:
        return q, gap
    raise AssemblyError(_open_joints(program, g, gap))


def least_shift(A: Any, b: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """The w with the least norm of w/sizes that minimises |A w - b|; A plain, or sparse (hundreds of bodies)."""
    m, n = A.shape
    A = A * sizes if isinstance(A, np.ndarray) else A.multiply(sizes).tocsr()
    if not isinstance(A, np.ndarray) and m * n > SPARSE_ENTRIES:
        import scipy.sparse as sp

        found = bordered_solution(sp.eye_array(n), A, np.concatenate([np.zeros(n), b]))
        if found is not None and np.abs(A @ found[:n] - b).max() <= 1e-9 * np.abs(b).max():
            return np.asarray(sizes * found[:n])
    return np.asarray(sizes * np.linalg.lstsq(plain(A), b, rcond=1e-10)[0])


def _open_joints(program: Program, g: np.ndarray, gap: float) -> str:
    names: dict[str, float] = {}
    for row, value in zip(program.names.rows, g, strict=True):
        part = row.partition("[")[0]
        names[part] = float(np.hypot(names.get(part, 0.0), value))
    worst = sorted(names.items(), key=lambda item: -item[1])[:4]
    listed = ", ".join(f"{name!r} by {value:.4g}" for name, value in worst)
    return (
        f"Mechanism {program.name!r} cannot be assembled: joints stay open, {listed} (m or rad; {gap:.3g} at worst). "
        "Check the lengths of the links in that loop, or choose positions of the drives that it can reach."
    )
