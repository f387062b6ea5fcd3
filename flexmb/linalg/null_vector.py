"""Null vector of a rectangular matrix: a combination of its columns that vanishes."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

DENSE_COLUMNS = 150
"""Number of columns up to which singular values are computed."""

VANISHING = 1e-13
"""Singular value, relative to the largest, below which a combination of columns vanishes."""

REGULARISATION = 1e-12
"""Weight w of the residual in the bordered matrix: a singular value s becomes an eigenvalue s^2/w, which is far above
round-off where s is above VANISHING."""

LEAST_PIVOT = 1e-20
"""Number on the diagonal that keeps the bordered matrix regular."""

ITERATIONS = 4
"""Number of inverse iterations; each separates a vanishing combination from all others by ten powers of ten."""


def null_vector(B: sp.sparray) -> np.ndarray | None:
    """A vector x (n,) of length 1 with B x = 0 but for round-off, or None.

    Few columns take a singular value decomposition, many an inverse iteration with the sparse factors of
    [[w 1, B], [B^T, 0]], whose eigenvalues near zero are -s^2/w for singular values s much smaller than the weight w.

    Parameters
    ----------
    B : (m, n) matrix, its rows of comparable size.
    """
    m, n = B.shape
    vector: np.ndarray
    if n <= DENSE_COLUMNS:
        dense = B.toarray()
        values = np.linalg.svd(dense, compute_uv=False)  # vectors take most of the time, and few callers need them
        if len(values) == n and values[-1] >= VANISHING * values[0]:
            return None
        vector = np.linalg.svd(dense)[2][-1]
        return vector
    size = largest_singular_value(B)
    if size == 0.0:
        vector = np.eye(1, n)[0]
        return vector
    scaled = B / size
    bordered = sp.block_array([[REGULARISATION * sp.eye_array(m), scaled], [scaled.T, -LEAST_PIVOT * sp.eye_array(n)]])
    factors = splu(bordered.tocsc())
    x = np.cos(np.arange(n) ** 2.0)
    growth = 0.0
    for _ in range(ITERATIONS):
        x /= np.linalg.norm(x)
        x = factors.solve(np.concatenate([np.zeros(m), x]))[m:]
        growth = float(np.linalg.norm(x))
    return np.asarray(x / growth) if growth > REGULARISATION / VANISHING**2 else None


def largest_singular_value(B: sp.sparray) -> float:
    """Largest singular value, by a power iteration: at least the half of it."""
    x = np.cos(np.arange(B.shape[1]) ** 2.0)
    size = 0.0
    for _ in range(10):
        norm = float(np.linalg.norm(x))
        if norm == 0.0:
            return float(np.sqrt((B * B).sum()))
        y = B @ (x / norm)
        size, x = float(np.linalg.norm(y)), B.T @ y
    return size
