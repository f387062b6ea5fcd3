"""Whether an equilibrium is stable: signs of the eigenvalues of its stiffness."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from flexmb.linalg.bordered import negative_eigenvalues
from flexmb.program.program import Program

STIFFNESS_ASYMMETRY = 1e-9
"""Forces without a potential: the difference of stiffnesses beyond the diagonal, over the largest."""


def is_stable(program: Program, K: sp.csc_matrix, G: sp.csr_matrix) -> bool | None:
    """Whether x^T K x > 0 for all motions x with G x = 0; None for an asymmetric K or pivots near zero.

    K (n_q, n_q) is the tangent stiffness, multipliers included, G (n_c, n_q) are the constraints.
    """
    sizes = sp.diags_array(1.0 / np.where(program.tables.kind == 1, program.length, 1.0))
    K = (sizes @ K @ sizes).tocsc()
    if abs(K - K.T).max() > STIFFNESS_ASYMMETRY * (abs(K).max() if K.nnz else 0.0):
        return None
    found = negative_eigenvalues(K, G @ sizes, program.symbolic.order)
    return None if found is None else found == 0
