"""Whether an equilibrium is stable: signs of the pivots of its bordered stiffness."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from flexmb.program.program import Program

JOINT_COMPLIANCE = 1e-10
"""Compliance of the joints against that of the structure, both scaled to 1: their rows then need not be independent."""

STIFFNESS_ASYMMETRY = 1e-9
"""Forces without a potential: the difference of stiffnesses beyond the diagonal, over the largest."""


def is_stable(program: Program, K: sp.csc_matrix, G: sp.csr_matrix) -> bool | None:
    """Whether x^T K x > 0 for all motions x with G x = 0; None for an asymmetric K or pivots near zero.

    Parameters
    ----------
    program : the mechanism.
    K : (n_q, n_q) tangent stiffness, multipliers included.
    G : (n_c, n_q) constraints.

    Notes
    -----
    A = [[K, G^T], [G, -c 1]] = L D L^T has as many negative pivots as rows in G, and no more, when K + G^T G/c is
    positive (Sylvester's law of inertia).  SuperLU takes the pivots from the diagonal where they are not zero; where it
    had to look elsewhere the eigenvalues of A are counted instead.
    """
    sizes = sp.diags_array(1.0 / np.where(program.tables.kind == 1, program.length, 1.0))
    K = (sizes @ K @ sizes).tocsc()
    largest = abs(K).max() if K.nnz else 0.0
    if abs(K - K.T).max() > STIFFNESS_ASYMMETRY * largest:
        return None
    m = G.shape[0]
    G = (G @ sizes).tocsr()
    lengths = np.sqrt(np.asarray(G.multiply(G).sum(axis=1)).ravel())
    G = sp.diags_array(1.0 / np.where(lengths > 0.0, lengths, 1.0)) @ G
    A = sp.block_array([[K / (largest or 1.0), G.T], [G, -JOINT_COMPLIANCE * sp.eye_array(m)]]).tocsc()
    found = negative_pivots(A)
    return None if found is None else found == m


def negative_pivots(A: sp.csc_matrix) -> int | None:
    """Negative eigenvalues of a symmetric matrix; None when one of them is zero but for round-off."""
    try:
        lu = splu(A, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:
        return None
    if np.array_equal(lu.perm_r, lu.perm_c):
        return int((lu.U.diagonal() < 0.0).sum())
    if A.shape[0] > 1500:
        return None
    values = np.linalg.eigvalsh(A.toarray())
    return None if np.abs(values).min() < 1e-15 * np.abs(values).max() else int((values < 0.0).sum())
