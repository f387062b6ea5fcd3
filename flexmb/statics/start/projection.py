"""Projection of a state onto the constraints: nearest positions and velocities."""

from typing import Any

import numpy as np

from flexmb.engine.linalg.dense import bordered_solution, plain
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import AssemblyError
from flexmb.late import sp
from flexmb.program.program import Program

WHOLE_TURN = 2.0 * np.pi
MOST_PROJECTIONS = 30  # number of Newton iterations at most
CLOSED_GAP = 1e-12  # gap of a closed joint relative to the size of the mechanism


def projected(program: Program, q: np.ndarray, v: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray]:
    """The positions and velocities (n_q,) nearest to q and v that satisfy all constraints at time t."""
    # Whole turns of the drives are removed first, so that a state of one period may be the start of another. Angles
    # count by the size of the mechanism.
    system, metric = StateEvaluation(program), metric_of(program)
    q = without_whole_turns(program, system, np.array(q, dtype=np.float64), t)
    for _ in range(MOST_PROJECTIONS):
        G = system.at(q, t=t).blocks[1]
        gap = system.residual
        if np.abs(gap).max(initial=0.0) <= CLOSED_GAP * max(program.length, 1.0):
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
    if len(b) == 0:
        return np.zeros(len(metric))
    if isinstance(G, np.ndarray):
        weight: Any = np.diag(metric)
    else:
        weight = sp.diags_array(metric).tocsc()
    found = bordered_solution(weight, G, np.concatenate([np.zeros(len(metric)), b]))
    size = np.abs(b).max()
    if found is not None and np.abs(G @ found[: len(metric)] - b).max() <= 1e-9 * size + 1e-300:
        return np.asarray(found[: len(metric)])
    root = 1.0 / np.sqrt(metric)
    return np.asarray(root * np.linalg.lstsq(plain(G) * root, b, rcond=1e-11)[0])


def without_whole_turns(program: Program, system: StateEvaluation, q: np.ndarray, t: float) -> np.ndarray:
    """q with bodies turned by whole turns, so that gaps of angles are less than a turn."""
    angles = np.asarray(program.tables.kind) == 1
    G = plain(system.at(q, t=t).blocks[1])
    turns = np.round(system.residual / WHOLE_TURN)
    rows = np.flatnonzero(np.abs(G[:, ~angles]).max(axis=1, initial=0.0) == 0.0)
    if not turns[rows].any():
        return q
    shift = np.linalg.lstsq(G[rows][:, angles], -WHOLE_TURN * turns[rows], rcond=1e-11)[0]
    q[angles] += WHOLE_TURN * np.round(shift / WHOLE_TURN)
    return q
