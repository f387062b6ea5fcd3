"""Solution of small linear systems with pivoting: `PivotingSolver` (pivoting.py) for matrices that are plain arrays."""

from __future__ import annotations

import numpy as np
from numpy.linalg import LinAlgError, solve

from flexmb.errors import SolveError
from flexmb.linalg.pivoting import GOOD_RESIDUAL, ROUND_OFF, SCALING_ROUNDS, SINGULAR_GROWTH, singular_text


def solve_dense(A: np.ndarray, b: np.ndarray) -> np.ndarray:
    """x (n,) with A (n, n) x = b, scaled, refined once and held against the same limits as `PivotingSolver` has.

    A `SolveError` tells an entry that is not finite; a matrix that is singular, or so near to it that x does not fulfil
    the equations.
    """
    n = len(b)
    if not np.isfinite(A).all():
        i, j = np.argwhere(~np.isfinite(A))[0]
        raise SolveError(f"entry ({i}, {j}) of the matrix is {A[i, j]}; it must be finite.")
    r, c = scales(np.abs(A))
    scaled = r[:, None] * A * c
    right = r * b
    try:
        x = solve(scaled, right)
        x += solve(scaled, right - scaled @ x)  # factored again: 20 us, and scipy's factors take 0.15 s to import
    except LinAlgError as error:
        raise SolveError(singular_text(n, "a pivot is exactly 0")) from error
    residual = np.abs(right - scaled @ x).max(initial=0.0)
    size, far = np.abs(right).max(initial=0.0), np.abs(x).max(initial=0.0)
    # a fine mesh answers a small load by a large x; what is left then is the round-off of the product A x
    round_off = ROUND_OFF * far if far / SINGULAR_GROWTH <= size else 0.0
    if not residual <= max(GOOD_RESIDUAL * size, round_off):
        raise SolveError(singular_text(n, f"a residual of {residual:.1e} is left"))
    return c * x


def scales(size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Factors of rows and of columns that bring the largest entry of each near 1 (Ruiz, see `PivotingSolver`).

    `size` (n, n) are absolute values.
    """
    r, c = np.ones(len(size)), np.ones(len(size))
    for _ in range(SCALING_ROUNDS):
        scaled = size * r[:, None] * c
        in_row, in_column = scaled.max(axis=1, initial=0.0), scaled.max(axis=0, initial=0.0)
        r /= np.sqrt(np.where(in_row > 0.0, in_row, 1.0))
        c /= np.sqrt(np.where(in_column > 0.0, in_column, 1.0))
    return r, c
