"""Large bordered matrices [[K, G^T], [G, 0]]: their factors, and the signs of their eigenvalues.

Both take an order of elimination in which constraints follow their coordinates, as `elimination_order` gives it: an
order by fill alone eliminates a body before the constraints that hold it, whose pivots are then round-off.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, splu

from flexmb.linalg.kept_factors import DIAGONAL_SHARE, REGULAR
from flexmb.linalg.rank import norm_of_inverse

Solve = Callable[[np.ndarray], np.ndarray]

JOINT_COMPLIANCE = 1e-10
"""Compliance of the joints against that of the structure, both scaled to 1: their rows then need not be independent."""

HOLD = 4.0
"""Factor w of G^T G beside K, its largest entry in each row scaled to 1: where K is -1 the sum is not 0."""

DENSE_PIVOTS = 1500
"""Number of unknowns up to which eigenvalues are counted where a pivot is zero."""


def solver(A: sp.csc_matrix, order: np.ndarray) -> Solve:
    """Solver of A x = b, x and b (n,) or (n, k); `RuntimeError` for a singular A (n, n), of symmetric pattern.

    `order` is the order of elimination of the first unknowns; the rest follow.
    """
    order = np.append(order, np.arange(len(order), A.shape[0]))
    turned = A[order][:, order].tocsc()
    factors = splu(turned, permc_spec="NATURAL", diag_pivot_thresh=DIAGONAL_SHARE, options={"SymmetricMode": True})

    def solve(b: np.ndarray) -> np.ndarray:
        x = np.empty_like(b)
        x[order] = factors.solve(b[order])
        return x

    return solve


def is_regular(K: Any, G: Any, order: np.ndarray) -> bool:
    """Whether beyond doubt no motion x but 0 has K x = 0 and G x = 0, and no row of G depends on the others.

    K (n, n) is symmetric or nearly so, G (m, n) are constraints; `order` is that of the n + m unknowns.
    """
    scale, rows = _scaled(K, G)
    A = sp.block_array([[scale @ K @ scale, rows.T], [rows, None]]).tocsc()
    try:
        solve = solver(A, order)
    except RuntimeError:
        return False
    inverse = LinearOperator(A.shape, matvec=solve, rmatvec=solve, dtype=float)
    return norm_of_inverse(inverse) < REGULAR


def negative_eigenvalues(K: Any, G: Any, order: np.ndarray) -> int | None:
    """Number of negative eigenvalues of a symmetric K on the motions x with G x = 0; None where a pivot is zero.

    K is (n, n), G (m, n), redundant rows may be among them; `order` is the order of elimination of the n + m unknowns.

    A = [[K + w G^T G, G^T], [G, -c 1]] = L D L^T has m negative pivots, and one more for each negative eigenvalue of
    K + (w + 1/c) G^T G (Sylvester's law of inertia), all scaled to 1.  w G^T G holds each body from the beginning, so
    that pivots of what a constraint holds later are no round-off.  Where a pivot is zero nonetheless, the eigenvalues
    of a small A are counted instead.
    """
    m = G.shape[0]
    scale, rows = _scaled(K, G)
    held = scale @ K @ scale + HOLD * (rows.T @ rows)
    A = sp.csc_array(sp.block_array([[held, rows.T], [rows, -JOINT_COMPLIANCE * sp.eye_array(m)]]))[order][:, order]
    try:
        lu = splu(A.tocsc(), permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:
        return None
    if np.array_equal(lu.perm_r, lu.perm_c):
        return int(np.count_nonzero(lu.U.diagonal() < 0.0)) - int(m)
    if A.shape[0] > DENSE_PIVOTS:
        return None
    values = np.linalg.eigvalsh(A.toarray())
    if np.abs(values).min() < 1e-15 * np.abs(values).max():
        return None
    return int(np.count_nonzero(values < 0.0)) - int(m)


def _scaled(K: Any, G: Any) -> tuple[Any, Any]:
    """Diagonal matrix D by which the entries of D K D are 1 at most, and G D with rows of length 1."""
    largest = np.asarray(abs(K).max(axis=1).todense()).ravel()
    scale = sp.diags_array(1.0 / np.sqrt(np.where(largest > 0.0, largest, 1.0)))
    rows = sp.csr_array(G @ scale)
    lengths = np.sqrt(np.asarray(rows.multiply(rows).sum(axis=1)).ravel())
    return scale, sp.diags_array(1.0 / np.where(lengths > 0.0, lengths, 1.0)) @ rows
