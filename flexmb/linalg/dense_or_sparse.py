"""Functions for matrices that are plain arrays in small models and sparse in large ones.

For some hundred unknowns the bookkeeping of a sparse matrix takes longer than all arithmetic with a plain one.
"""

from __future__ import annotations

from typing import Any

import numpy as np

DENSE_UNKNOWNS = 120
"""Unknowns up to which plain arrays are used."""


def plain(A: Any) -> np.ndarray:
    """A as a plain array."""
    return A if isinstance(A, np.ndarray) else A.toarray()


def stacked(upper: Any, lower: Any) -> Any:
    """The rows of `upper` above the rows of `lower`; plain if both are plain."""
    if isinstance(upper, np.ndarray) and isinstance(lower, np.ndarray):
        return np.concatenate([upper, lower])
    import scipy.sparse as sp  # noqa: PLC0415 - large models alone need it, and it takes long to import

    return sp.vstack([upper, lower]).tocsr()


def scaled_rows(factors: np.ndarray, A: Any) -> Any:
    """Each row of A times its factor."""
    return factors[:, None] * A if isinstance(A, np.ndarray) else A.multiply(factors[:, None]).tocsr()


def bordered_solution(S: Any, A: Any, b: np.ndarray) -> np.ndarray | None:
    """x with [[S, A^T], [A, 0]] x = b (n + m,), None where the matrix is singular to the last digit.

    S (n, n) is symmetric or not, A is (m, n).
    """
    if isinstance(S, np.ndarray) and isinstance(A, np.ndarray):
        m, n = A.shape
        whole = np.zeros((n + m, n + m))
        whole[:n, :n], whole[:n, n:], whole[n:, :n] = S, A.T, A
        try:
            return np.linalg.solve(whole, b)
        except np.linalg.LinAlgError:
            return None
    import scipy.sparse as sp  # noqa: PLC0415 - see `stacked`
    from scipy.sparse.linalg import splu  # noqa: PLC0415

    try:
        solution: np.ndarray = splu(sp.block_array([[S, A.T], [A, None]]).tocsc()).solve(b)
        return solution
    except RuntimeError:
        return None
