"""Rank of the constraint matrix, and its redundant rows."""

from typing import Any

import numpy as np

from flexmb.late import scipy, sp

RANK_TOLERANCE = 1e-9  # diagonal entry of R of a pivoted QR relative to the largest, below which a row is redundant
CERTAIN_EIGENVALUE = 1e-10  # eigenvalue of G G^T relative to its diagonal, above which it is no round-off
# Norm of the inverse of G G^T, its rows of length 1, below which the rows of a sparse G are independent beyond doubt:
# those of a chain of n links reach n^2, those that repeat one another 1e16.
CERTAIN_INVERSE = 1e12
# Number of constraint rows above which only the redundant rows are named, and not those that they repeat.
DENSE_ROWS = 800
# Entry of a combination of rows that vanishes, relative to the largest, below which the row is not in it.
IN_COMBINATION = 1e-6


def surplus_rows(G: Any) -> tuple[int, ...]:
    """Numbers of the redundant rows of G, a plain array or sparse, ascending; its rank is that of the other rows."""
    # By a pivoted QR of G^T (dense) or of G G^T (large), rows scaled to length 1; a sparse G whose rows are clearly
    # independent needs none, and of the others each group of rows that share no column with the rest has its own.
    m = G.shape[0]
    if m == 0:
        return ()
    if isinstance(G, np.ndarray):
        used = G[:, G.any(axis=0)]
        lengths = np.sqrt((used * used).sum(axis=1))
        columns = (used / np.where(lengths > 0.0, lengths, 1.0)[:, None]).T
        return () if _surely_independent(columns) else _by_qr(columns, m, RANK_TOLERANCE)
    lengths = np.sqrt(np.asarray(G.multiply(G).sum(axis=1)).ravel())
    unit = (sp.diags_array(1.0 / np.where(lengths > 0.0, lengths, 1.0)) @ G).tocsr()
    gram = (unit @ unit.T).tocsc()
    if (lengths > 0.0).all() and _clearly_independent(gram):
        return ()
    used = np.unique(unit.indices)
    if m * len(used) <= 400_000:
        return _by_qr(unit[:, used].toarray().T, m, RANK_TOLERANCE)
    count, group = sp.csgraph.connected_components(gram, directed=False)
    redundant: list[int] = []
    for rows in np.split(np.argsort(group, kind="stable"), np.cumsum(np.bincount(group, minlength=count))[:-1]):
        redundant += [int(rows[k]) for k in _by_qr(gram[rows][:, rows].toarray(), len(rows), RANK_TOLERANCE**1.5)]
    return tuple(sorted(redundant))


def dependent_rows(G: Any) -> list[int]:
    """Numbers of the rows of G that occur in a combination of rows that vanishes."""
    redundant = surplus_rows(G)
    if not redundant or G.shape[0] > DENSE_ROWS:
        return list(redundant)
    dense = G if isinstance(G, np.ndarray) else G.toarray()
    lengths = np.sqrt((dense * dense).sum(axis=1))
    empty, unit = np.flatnonzero(lengths == 0.0), dense / np.where(lengths > 0.0, lengths, 1.0)[:, None]
    vectors = np.linalg.svd(unit.T)[2][len(lengths) - len(redundant) :]
    part = np.sqrt((vectors * vectors).sum(axis=0))
    return sorted({*np.flatnonzero(part > IN_COMBINATION * part.max()).tolist(), *empty.tolist()})


def _by_qr(columns: np.ndarray, m: int, tolerance: float) -> tuple[int, ...]:
    """Redundant ones of m columns: their diagonal in R is this part of the largest or less."""
    if columns.shape[0] == 0:
        return tuple(range(m))
    factored, order = scipy.linalg.lapack.dgeqp3(columns)[:2]  # R in the upper triangle; columns are counted from 1
    diagonal = np.abs(np.diag(factored))
    rank = int((diagonal > tolerance * max(diagonal[0], 1e-300)).sum())
    return tuple(sorted(int(k) - 1 for k in order[rank:]))


def _surely_independent(columns: np.ndarray) -> bool:
    """Whether columns of length 1 are independent: no pivot of their QR is then below CERTAIN_EIGENVALUE^0.5."""
    if columns.shape[1] > columns.shape[0]:
        return False
    gram = columns.T @ columns
    gram.flat[:: len(gram) + 1] -= CERTAIN_EIGENVALUE
    try:
        np.linalg.cholesky(gram)
    except np.linalg.LinAlgError:
        return False
    return True


def _clearly_independent(gram: Any) -> bool:
    """Whether the inverse of G G^T, sparse, is so small that no row can be made of the others."""
    try:
        factors = sp.linalg.splu(gram, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    except RuntimeError:  # exactly singular
        return False
    inverse = sp.linalg.LinearOperator(gram.shape, matvec=factors.solve, rmatvec=factors.solve, dtype=float)
    return norm_of_inverse(inverse) < CERTAIN_INVERSE


def norm_of_inverse(inverse: Any) -> float:
    """Estimate of the 1-norm of an inverse, by `onenormest` and by one vector that has a part of every other one."""
    # The vectors of `onenormest` are of 1 and -1: they may miss what two equal rows map to round-off.
    b = np.cos(np.arange(inverse.shape[0]) ** 2.0)
    return float(max(np.abs(inverse.matvec(b)).sum() / np.abs(b).sum(), sp.linalg.onenormest(inverse)))
