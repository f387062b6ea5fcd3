"""Free motions: motions of the bodies without resistance, and their descriptions in words."""

from __future__ import annotations

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from flexmb.errors import SolveError
from flexmb.linalg.bordered import is_regular
from flexmb.linalg.null_vector import null_vectors
from flexmb.program.program import Program
from flexmb.start.rigid_motion import RigidMotion

DENSE_MOTIONS = 900
"""Number of rigid motions of bodies (three each) up to which plain matrices find the free ones."""

DEPENDENT_ROW = 1e-10
"""Pivot of a constraint row relative to the largest, below which it depends on others (poses close to 1e-12)."""

ROW_ROUND_OFF = 1e-14
"""Entry of a constraint row on the bodies relative to the sum of the absolute values of its terms, below which it is
round-off."""

FREE_FORCE = 1e-13
"""Force of a free motion relative to the sum of the absolute values of its terms."""

STIFFNESS_ROUND_OFF = 1e-15
"""Round-off of an entry of the stiffness relative to the largest entry of its node."""

SMALL_SHARE = 1e-8
"""Component of a motion relative to its largest, below which it is not named."""


def null_space(G: np.ndarray, tolerance: float = DEPENDENT_ROW) -> np.ndarray:
    """Orthonormal basis (n, k) of the motions x with G x = 0, by a pivoted QR of G^T with rows of length 1."""
    n = G.shape[1]
    lengths = np.linalg.norm(G, axis=1)
    G = G[lengths > 0.0] / lengths[lengths > 0.0, None]
    if not len(G):
        return np.eye(n)
    Q, R, _ = la.qr(G.T, pivoting=True)
    diagonal = np.abs(np.diag(R))
    basis: np.ndarray = Q[:, int((diagonal > tolerance * diagonal[0]).sum()) :]
    return basis


def free_motions(program: Program, q: np.ndarray, K: sp.csc_matrix, G: sp.csr_matrix) -> np.ndarray:
    """Rigid motions (3 bodies, k) of the bodies that satisfy the constraints without a force of stiffness.

    Flexible bodies resist every deformation, so that these are all motions without strain energy.  Each row of K B w is
    compared with the sum of the absolute values of its own terms, its round-off: a spring of 1e-9 of the stiffness of a
    beam counts, and a large stiffness elsewhere hides nothing.
    """
    B = RigidMotion(program).basis(q)
    sizes = np.where(np.arange(B.shape[1]) % 3 == 2, 1.0, program.length)
    B = (B @ sp.diags_array(sizes)).tocsr()
    if B.shape[1] > DENSE_MOTIONS and is_regular(K, G, program.symbolic.order):
        return np.zeros((B.shape[1], 0))
    find = _sparse_motions if B.shape[1] > DENSE_MOTIONS else _dense_motions
    Z = find(program, B, K, G)
    motions: np.ndarray = sizes[:, None] * simplified(Z)
    return motions


def _dense_motions(program: Program, B: sp.csr_matrix, K: sp.csc_matrix, G: sp.csr_matrix) -> np.ndarray:
    """Free motions (3 bodies, k) by factors of plain matrices."""
    # rows that only the round-off of their own terms resists, as of pins and nodes of one body, resist nothing
    terms_of_rows = np.asarray((abs(G) @ abs(B)).sum(axis=1)).ravel()
    rows_of_bodies = (G @ B).toarray()
    Z = null_space(rows_of_bodies[np.abs(rows_of_bodies).max(axis=1, initial=0.0) > ROW_ROUND_OFF * terms_of_rows])
    if not Z.shape[1]:
        return Z
    moved = B @ Z
    terms = (abs(K) @ np.abs(moved)).sum(axis=1) + STIFFNESS_ROUND_OFF / FREE_FORCE * stiffest_at(K) * np.abs(
        moved
    ).max()
    rows = terms > 0.0
    force = (K @ moved)[rows] / terms[rows, None]
    if not np.isfinite(force).all():
        raise SolveError(_too_stiff(program))
    if len(force):
        values, vectors = la.svd(la.qr(force, mode="r")[0][: force.shape[1]])[1:]
        values = np.append(values, np.zeros(Z.shape[1] - len(values)))
        Z = Z @ vectors[values <= FREE_FORCE * np.sqrt(len(force))].T
    return Z


def _sparse_motions(program: Program, B: sp.csr_matrix, K: sp.csc_matrix, G: sp.csr_matrix) -> np.ndarray:
    """Free motions (3 bodies, k) of many bodies, which keep all rows of G B and K B at 0.

    Entries that are the round-off of their terms are none; the rest has rows of length 1.
    """
    blocks = []
    for A, share, floor in ((G, ROW_ROUND_OFF, None), (K, FREE_FORCE, STIFFNESS_ROUND_OFF * stiffest_at(K))):
        found = sp.coo_array(A @ B)
        if not np.isfinite(found.data).all():
            raise SolveError(_too_stiff(program))
        terms = np.asarray((abs(A) @ abs(B)).tocsr()[found.row, found.col]).ravel()
        least = share * terms + (0.0 if floor is None else floor[found.row])
        kept = np.abs(found.data) > least
        block = sp.csr_array((found.data[kept], (found.row[kept], found.col[kept])), shape=found.shape)
        lengths = np.sqrt(np.asarray(block.multiply(block).sum(axis=1)).ravel())
        rows = np.flatnonzero(lengths)
        blocks.append(sp.diags_array(1.0 / lengths[rows]) @ block[rows])
    return null_vectors(sp.vstack(blocks))


def _too_stiff(program: Program) -> str:
    return (
        f"Mechanism {program.name!r}: its stiffness in this pose is too large for floats. Check the "
        "numbers of its parts and their units."
    )


def stiffest_at(K: sp.csc_matrix) -> np.ndarray:
    """Largest stiffness (n_q,) of a node along x or y, at both of these coordinates; 0 at rotations.

    Entries of a beam along x or y that should be 0 are the round-off of its axial stiffness, since the stiffness is
    rotated from the axes of the beam.
    """
    largest = abs(K).tocsr().max(axis=1).toarray().ravel()
    along = np.maximum(largest[0::3], largest[1::3])
    return np.column_stack([along, along, np.zeros_like(along)]).ravel()


def simplified(Z: np.ndarray) -> np.ndarray:
    """Combinations of the same motions that are single translations or rotations if possible, translations first."""
    Z, count = Z.copy(), Z.shape[1]
    angles = list(range(2, len(Z), 3))
    # the first body's translation, all rotations, then what is left: so bodies that hang together translate together
    order = [0, 1, *angles, *(k for k in range(3, len(Z)) if k % 3 != 2)]
    chosen: list[int] = []
    turning: list[int] = []
    for place in order:
        left = [k for k in range(count) if k not in chosen]
        if not left:
            break
        best = max(left, key=lambda k: abs(Z[place, k]))
        if abs(Z[place, best]) <= 1e-6:
            continue
        chosen.append(best)
        turning += [best] if place % 3 == 2 else []
        Z[:, best] /= Z[place, best]
        others = [k for k in range(count) if k != best]
        Z[:, others] -= np.outer(Z[:, best], Z[place, others])
    Z = Z[:, [k for k in chosen if k not in turning] + turning]
    return np.where(np.abs(Z) > SMALL_SHARE * np.abs(Z).max(axis=0, initial=0.0), Z, 0.0)


def shapes_of(program: Program, q: np.ndarray, motions: np.ndarray, M: sp.csc_matrix) -> np.ndarray:
    """Motions of bodies as shapes (n_q, k) of the coordinates with x^T M x = 1, orthogonal in M, in their order.

    Translations remain translations; the rotation of a free body becomes that about its centre of mass.
    """
    X: np.ndarray = RigidMotion(program).basis(q) @ motions
    for k in range(X.shape[1]):
        for _ in range(2):  # twice: round-off of the first pass
            X[:, k] -= X[:, :k] @ (X[:, :k].T @ (M @ X[:, k]))
        energy = float(X[:, k] @ (M @ X[:, k]))
        X[:, k] /= np.sqrt(energy) if energy > 0.0 else np.abs(X[:, k]).max()
    return X


def motion_in_words(program: Program, motion: np.ndarray) -> str:
    """Description of a rigid motion (3 bodies,): "translation in x of 'rod'"."""
    w = motion.reshape(-1, 3) / np.where(np.arange(3) == 2, 1.0, program.length)
    size = np.abs(w).max()
    moving = np.abs(w).max(axis=1) > SMALL_SHARE * size
    turning = np.abs(w[:, 2]) > SMALL_SHARE * size
    if turning.any():
        also = _listed(program, moving & ~turning)
        return f"rotation of {_listed(program, turning)}" + (f", moving {also}" if also else "")
    first = w[int(np.flatnonzero(moving)[0]), :2]
    same = np.abs(w[moving, :2] - first).max() <= 1e-6 * size
    ways = {(True, False): "in x", (False, True): "in y"}
    in_x, in_y = (bool(x) for x in np.abs(first) > SMALL_SHARE * size)
    way = ways.get((in_x, in_y))
    if way is None:
        dx, dy = first / np.hypot(*first)
        way = f"along ({dx:.3g}, {dy:.3g})"
    return f"translation {way} of {_listed(program, moving)}" if same else f"motion of {_listed(program, moving)}"


def _listed(program: Program, which: np.ndarray) -> str:
    names = [repr(program.names.bodies[b]) for b in np.flatnonzero(which)]
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")


def moves_most(names: tuple[str, ...], length: float, shape: np.ndarray) -> str:
    """Name of the coordinate with the largest amplitude in a shape (n_q,), rotations times `length` [m]."""
    sizes = np.where(np.arange(len(shape)) % 3 == 2, length, 1.0)
    return names[int(np.abs(shape * sizes).argmax())]
