"""Whether the joints are independent: rank of the constraint matrix, and which rows are too many."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.linalg import qr

TOLERANCE = 1e-9


@dataclass(frozen=True)
class Rank:
    """Rank of a matrix and the rows beyond it."""

    rank: int
    redundant: tuple[int, ...]


def row_rank(G: sp.csr_matrix) -> Rank:
    """Rank of the rows of G after scaling them to length 1, by a pivoted QR of G^T (dense) or of G G^T (large)."""
    m = G.shape[0]
    if m == 0:
        return Rank(0, ())
    lengths = np.sqrt(np.asarray(G.multiply(G).sum(axis=1)).ravel())
    unit = (sp.diags_array(1.0 / np.where(lengths > 0.0, lengths, 1.0)) @ G).tocsr()
    used = np.unique(unit.indices)
    if m * len(used) <= 400_000:
        dense, tolerance = unit[:, used].toarray().T, TOLERANCE
    else:
        dense, tolerance = (unit @ unit.T).toarray(), TOLERANCE**1.5
    r, order = qr(dense, mode="r", pivoting=True)[-2:]
    diagonal = np.abs(np.diag(r))
    rank = int((diagonal > tolerance * max(diagonal[0], 1e-300)).sum())
    return Rank(rank, tuple(sorted(int(k) for k in order[rank:])))
