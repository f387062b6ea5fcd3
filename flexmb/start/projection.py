"""A state brought back to where the joints allow it to be: the nearest positions and velocities."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.errors import AssemblyError
from flexmb.linalg.dense_or_sparse import bordered_solution, plain
from flexmb.program.program import Program
from flexmb.system.at_state import System

TURN = 2.0 * np.pi
ROUNDS = 30
CLOSED = 1e-12
"""Gap of closed joints, as a part of the size of the mechanism."""


def projected(program: Program, q: np.ndarray, v: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray]:
    """The positions and velocities (n_q,) nearest to q and v that joints and drives allow at time t.

    Whole turns of the drives are taken out first, so that a state of one period may stand at the start of another.
    Angles count by the size of the mechanism.

    Raises
    ------
    AssemblyError : no positions near q close the joints.
    """
    system, metric = System(program), metric_of(program)
    q = turned_back(program, system, np.array(q, dtype=np.float64), t)
    for _ in range(ROUNDS):
        G = system.at(q, t=t).blocks[1]
        gap = system.residual
        if np.abs(gap).max(initial=0.0) <= CLOSED * max(program.length, 1.0):
            break
        q = q + nearest(metric, G, -gap)
    else:
        worst = program.names.rows[int(np.abs(gap).argmax())]
        text = f"Mechanism {program.name!r}: the given state is too far from one that its joints allow"
        raise AssemblyError(f"{text}; {worst!r} stays open by {np.abs(gap).max():.3g}. Give a state nearer to it.")
    G = system.at(q, v, t=t).blocks[1]
    return q, np.array(v) + nearest(metric, G, -system.velocity_residual)


def metric_of(program: Program) -> np.ndarray:
    """Weights (n_q,) of squares of coordinates: 1, and the square of the mechanism's size for angles."""
    return np.where(np.asarray(program.tables.kind) == 1, program.length**2, 1.0)


def nearest(metric: np.ndarray, G: Any, b: np.ndarray) -> np.ndarray:
    """The shortest x (n,) in the metric with G x = b; of least squares where rows repeat one another."""
    if len(b) == 0:
        return np.zeros(len(metric))
    if isinstance(G, np.ndarray):
        weight: Any = np.diag(metric)
    else:
        import scipy.sparse as sp

        weight = sp.diags_array(metric).tocsc()
    found = bordered_solution(weight, G, np.concatenate([np.zeros(len(metric)), b]))
    size = np.abs(b).max()
    if found is not None and np.abs(G @ found[: len(metric)] - b).max() <= 1e-9 * size + 1e-300:
        return np.asarray(found[: len(metric)])
    root = 1.0 / np.sqrt(metric)
    return np.asarray(root * np.linalg.lstsq(plain(G) * root, b, rcond=1e-11)[0])


def turned_back(program: Program, system: System, q: np.ndarray, t: float) -> np.ndarray:
    """q with bodies turned by whole turns, so that rows of angles alone are open by less than one."""
    angles = np.asarray(program.tables.kind) == 1
    G = plain(system.at(q, t=t).blocks[1])
    turns = np.round(system.residual / TURN)
    rows = np.flatnonzero(np.abs(G[:, ~angles]).max(axis=1, initial=0.0) == 0.0)
    if not turns[rows].any():
        return q
    shift = np.linalg.lstsq(G[rows][:, angles], -TURN * turns[rows], rcond=1e-11)[0]
    q[angles] += TURN * np.round(shift / TURN)
    return q
