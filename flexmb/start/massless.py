"""Massless links: whether each of their motions moves a mass."""

from __future__ import annotations

import numpy as np

from flexmb.errors import ModelError
from flexmb.linalg.dense_or_sparse import plain
from flexmb.linalg.rank import RANK_TOLERANCE
from flexmb.model.mechanism import Mechanism
from flexmb.program.program import Program
from flexmb.start.rigid_motion import RigidMotion
from flexmb.system.state_evaluation import StateEvaluation

NO_INERTIA = 1e-12
"""Inertia of a motion over the largest inertia of the mechanism, below which a massless link moves alone."""

SHARE = 0.1
"""Part of the fastest coordinate of such a motion, above which a link is named."""


def check_massless(mechanism: Mechanism, program: Program, q: np.ndarray) -> None:
    """Refuse massless links that can move without moving a mass, at a closed pose (n_q,).

    Nothing is computed without massless links.  Flexible bodies count as rigid: a link that only bends them moves their
    mass.
    """
    massless = [k for k, body in enumerate(mechanism.bodies) if body.is_massless]
    if not massless:
        return
    from scipy.linalg import eigh, null_space

    rigid = RigidMotion(program)
    M, G = StateEvaluation(program).at(q, weights=(0.0, 0.0, 1.0)).blocks
    B, sizes = plain(rigid.plain_basis(q)), np.tile([1.0, 1.0, 1.0 / program.length], rigid.count)
    inertia = sizes[:, None] * (B.T @ plain(M) @ B) * sizes
    own = np.concatenate([3 * k + np.arange(3) for k in massless])
    inertia[own, :] = inertia[:, own] = 0.0
    ways = null_space(plain(G) @ B * sizes, rcond=RANK_TOLERANCE) if program.n_c else np.eye(3 * rigid.count)
    if ways.shape[1] == 0:
        return
    values, vectors = eigh(ways.T @ inertia @ ways)
    if values[0] > NO_INERTIA * max(float(np.abs(inertia).max()), 1e-300):
        return
    motion = np.abs(ways @ vectors[:, 0]).reshape(-1, 3).max(axis=1)
    names = [program.names.bodies[k] for k in massless if motion[k] > SHARE * motion.max()]
    listed = f"{'link' if len(names) == 1 else 'links'} {', '.join(map(repr, names))}"
    raise ModelError(
        f"Mechanism {program.name!r}: massless {listed} can move without moving a mass, so forces have nothing to "
        "accelerate. Give mass and inertia, or hold the link by a further joint."
    )
