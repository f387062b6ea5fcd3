"""Whether the joints are independent: rank of the constraint matrix, and which rows are too many."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

TOLERANCE = 1e-9
INDEPENDENT = 1e-10
"""Part of its diagonal below which eigenvalues of G G^T are not taken for round-off: far above TOLERANCE squared."""


@dataclass(frozen=True)
class Rank:
    """Rank of a matrix and the rows beyond it."""

    rank: int
    redundant: tuple[int, ...]


def row_rank(G: Any) -> Rank:
    """Rank of the rows of G, a plain array or sparse, after scaling them to length 1.

    By a pivoted QR of G^T (dense) or of G G^T (large).
    """
    m = G.shape[0]
    if m == 0:
        return Rank(0, ())
    if isinstance(G, np.ndarray):
        used = G[:, G.any(axis=0)]
        lengths = np.sqrt((used * used).sum(axis=1))
        dense, tolerance = (used / np.where(lengths > 0.0, lengths, 1.0)[:, None]).T, TOLERANCE
    else:
        dense, tolerance = _of_sparse(G)
    if dense.shape[0] == 0:
        return Rank(0, tuple(range(m)))
    if isinstance(G, np.ndarray) and _surely_independent(dense):
        return Rank(m, ())
    from scipy.linalg.lapack import dgeqp3  # noqa: PLC0415 - dependent joints alone need it, and it takes long to import

    factored, order = dgeqp3(dense)[:2]  # R in the upper triangle; columns are counted from 1
    diagonal = np.abs(np.diag(factored))
    rank = int((diagonal > tolerance * max(diagonal[0], 1e-300)).sum())
    return Rank(rank, tuple(sorted(int(k) - 1 for k in order[rank:])))


def _surely_independent(columns: np.ndarray) -> bool:
    """Whether columns of length 1 are independent beyond doubt: no pivot of their QR is then below INDEPENDENT^0.5."""
    if columns.shape[1] > columns.shape[0]:
        return False
    gram = columns.T @ columns
    gram.flat[:: len(gram) + 1] -= INDEPENDENT
    try:
        np.linalg.cholesky(gram)
    except np.linalg.LinAlgError:
        return False
    return True


def _of_sparse(G: Any) -> tuple[np.ndarray, float]:
    """What the QR is made of, and the part of its largest diagonal entry below which a row is too many."""
    import scipy.sparse as sp  # noqa: PLC0415 - large models alone need it, and it takes long to import

    lengths = np.sqrt(np.asarray(G.multiply(G).sum(axis=1)).ravel())
    unit = (sp.diags_array(1.0 / np.where(lengths > 0.0, lengths, 1.0)) @ G).tocsr()
    used = np.unique(unit.indices)
    if G.shape[0] * len(used) <= 400_000:
        return unit[:, used].toarray().T, TOLERANCE
    return (unit @ unit.T).toarray(), TOLERANCE**1.5
