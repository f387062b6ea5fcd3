"""Null vectors of a rectangular matrix: combinations of its columns that vanish."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import SuperLU, splu

DENSE_COLUMNS = 150
"""Number of columns up to which singular values are computed."""

VANISHING = 1e-13
"""Singular value, relative to the largest, below which a combination of columns vanishes."""

REGULARISATION = 1e-12
"""Weight w of the residual in the bordered matrix: a singular value s becomes an eigenvalue s^2/w, which is far above
round-off where s is above VANISHING."""

LEAST_PIVOT = 1e-20
"""Number on the diagonal that keeps the bordered matrix regular."""

FIRST_VECTORS = 4
"""Number of vectors looked for at first; then four times as many."""

ITERATIONS = 4
"""Number of inverse iterations; each separates a vanishing combination from all others by ten powers of ten."""


def null_vector(B: sp.sparray) -> np.ndarray | None:
    """A vector x (n,) of length 1 with B x = 0 but for round-off, or None.

    Few columns take a singular value decomposition, many an inverse iteration with the sparse factors of [[w 1, B],
    [B^T, 0]], whose eigenvalues near zero are -s^2/w for singular values s much smaller than the weight w.  The rows of
    B (m, n) have comparable size.
    """
    m, n = B.shape
    vector: np.ndarray
    if n <= DENSE_COLUMNS:
        dense = B.toarray()
        values = np.linalg.svd(dense, compute_uv=False)  # vectors take most of the time, and few callers need them
        if len(values) == n and values[-1] > VANISHING * values[0]:
            return None
        vector = np.linalg.svd(dense)[2][-1]
        return vector
    size = largest_singular_value(B)
    if size == 0.0:
        vector = np.eye(1, n)[0]
        return vector
    factors = _bordered(B / size)
    x = np.cos(np.arange(n) ** 2.0)
    growth = 0.0
    for _ in range(ITERATIONS):
        x /= np.linalg.norm(x)
        x = factors.solve(np.concatenate([np.zeros(m), x]))[m:]
        growth = float(np.linalg.norm(x))
    return np.asarray(x / growth) if growth > REGULARISATION / VANISHING**2 else None


def null_vectors(B: sp.sparray) -> np.ndarray:
    """Orthonormal vectors x (n, k) with B x = 0 but for round-off, all there are.

    Inverse iterations as in `null_vector`, with more and more vectors until one of them does not vanish.  The rows of B
    (m, n) have comparable size.
    """
    m, n = B.shape
    size = largest_singular_value(B)
    if size == 0.0:
        return np.eye(n)
    if n <= DENSE_COLUMNS:
        values, vectors = np.linalg.svd(np.vstack([B.toarray(), np.zeros((1, n))]))[1:]
        values = np.append(values, np.zeros(n - len(values)))
        return np.asarray(vectors[values <= VANISHING * values[0]].T)
    factors, count = _bordered(B / size), FIRST_VECTORS
    while True:
        count = min(count, n)
        x = np.cos(np.arange(1, n + 1)[:, None] * np.arange(1, count + 1) ** 2.0)
        for _ in range(ITERATIONS):
            x = np.linalg.qr(x)[0]
            x = factors.solve(np.vstack([np.zeros((m, count)), x]))[m:]
        x = np.linalg.qr(x)[0]
        values, vectors = np.linalg.svd((B @ x) / size, full_matrices=False)[1:]
        vanish = values <= VANISHING * np.sqrt(n)
        if not vanish.all() or count == n:
            return np.asarray(x @ vectors[vanish].T)
        count *= 4


def _bordered(scaled: sp.sparray) -> SuperLU:
    """Factors of [[w 1, B], [B^T, 0]]."""
    m, n = scaled.shape
    bordered = sp.block_array([[REGULARISATION * sp.eye_array(m), scaled], [scaled.T, -LEAST_PIVOT * sp.eye_array(n)]])
    return splu(bordered.tocsc())


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
