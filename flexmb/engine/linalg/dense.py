"""Small linear systems with pivoting, and functions for matrices that are plain or sparse.

For some hundred unknowns the bookkeeping of a sparse matrix takes longer than all arithmetic with a plain one.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.linalg import LinAlgError, solve

from flexmb.engine.linalg.symbolic import Symbolic
from flexmb.errors import SolveError
from flexmb.late import sp

# Solver with pivoting, for matrices whose factors without pivoting are not accurate enough

GOOD_RESIDUAL = 1e-6  # residual relative to the right-hand side, both scaled, above which the matrix is singular
ROUND_OFF = 1e-14  # round-off of A x relative to the largest entry of x, both scaled
# Largest entry of x relative to that of the right-hand side above which A counts as singular: one of 500 beam elements
# reaches 2e11, one without an inverse about 1e16.
SINGULAR_GROWTH = 1e13
# Each round about halves the exponents of what a row and a column lack to the size 1: 1e16 becomes sqrt(1e1).
SCALING_ROUNDS = 5


class PivotingSolver:
    """Slow and safe: SuperLU with partial pivoting on rows and columns scaled to the size 1, refined once.

    Source of the scaling: D. Ruiz, A scaling algorithm to equilibrate both rows and columns norms in matrices,
    report RAL-TR-2001-034, Rutherford Appleton Laboratory, 2001, algorithm 1 with the maximum norm.
    [[0, 2], [1, 0]] x = [4, 3], which `factor` cannot do:

    >>> import numpy as np
    >>> from flexmb.engine.linalg.symbolic import symbolic
    >>> swap = symbolic(2, [0], [1], [0, 1])
    >>> values = np.zeros(swap.size)
    >>> values[swap.positions([0, 1], [1, 0])] = [2.0, 1.0]
    >>> PivotingSolver(swap).factor(values).solve(np.array([4.0, 3.0])).tolist()
    [3.0, 2.0]
    """

    def __init__(self, symbolic: Symbolic) -> None:
        self._n = symbolic.n
        self._take(symbolic.a_rows, symbolic.a_cols, symbolic.places)

    def _take(self, rows: np.ndarray, cols: np.ndarray, places: np.ndarray) -> None:
        """Entries of A column by column, and the places of their values."""
        self._rows, self._cols, self._from = rows, cols, places
        self._column_starts = np.searchsorted(self._cols, np.arange(self._n + 1))
        self._by_row = np.argsort(self._rows, kind="stable")
        self._row_starts = np.searchsorted(self._rows[self._by_row], np.arange(self._n))

    def factor(self, values: np.ndarray) -> PivotingSolver:
        """Take the `values` of A, not factored, in the layout of the pattern; returns the solver itself."""
        # Raises `SolveError` if a value is not finite or A is singular to the last digit.
        data = self._finite(values)
        self._r, self._c = self._scales(np.abs(data))
        scaled = data * self._r[self._rows] * self._c[self._cols]
        self._matrix = sp.csc_matrix((scaled, self._rows, self._column_starts), shape=(self._n, self._n))
        try:
            self._factors = sp.linalg.splu(self._matrix)
        except RuntimeError as error:
            raise SolveError(singular_text(self._n, str(error))) from error
        return self

    def _finite(self, values: np.ndarray) -> np.ndarray:
        """The entries of A, or `SolveError` where one is not finite."""
        data: np.ndarray = values[self._from]
        bad = np.flatnonzero(~np.isfinite(data))
        if bad.size:
            entry = f"({self._rows[bad[0]]}, {self._cols[bad[0]]})"
            raise SolveError(f"PivotingSolver: entry {entry} of the matrix is {data[bad[0]]}; it must be finite.")
        return data

    def solve(self, b: np.ndarray) -> np.ndarray:
        """X with A x = b, (n,); `SolveError` if A is so near to singular that x does not fulfil the equations."""
        right = self._r * b
        x = self._factors.solve(right)
        x += self._factors.solve(right - self._matrix @ x)
        residual = np.max(np.abs(right - self._matrix @ x), initial=0.0)
        size, far = np.max(np.abs(right), initial=0.0), np.max(np.abs(x), initial=0.0)
        if not is_fulfilled(residual, size, far):
            raise SolveError(singular_text(self._n, f"a residual of {residual:.1e} is left"))
        return np.asarray(self._c * x)

    def _scales(self, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Factors of rows and of columns that bring the largest entry of each near 1.  size : absolute values."""
        r, c = np.ones(self._n), np.ones(self._n)
        for _ in range(SCALING_ROUNDS):
            scaled = size * r[self._rows] * c[self._cols]
            in_row = np.maximum.reduceat(scaled[self._by_row], self._row_starts)
            in_column = np.maximum.reduceat(scaled, self._column_starts[:-1])
            r /= np.sqrt(np.where(in_row > 0.0, in_row, 1.0))
            c /= np.sqrt(np.where(in_column > 0.0, in_column, 1.0))
        return r, c


def is_fulfilled(residual: float, size: float, far: float) -> bool:
    """Whether scaled equations are fulfilled but for round-off, by the largest entries of b - A x, of b and of x."""
    # a fine mesh answers a small load by a large x; what is left then is the round-off of the product A x
    round_off = ROUND_OFF * far if far / SINGULAR_GROWTH <= size else 0.0
    return residual <= max(GOOD_RESIDUAL * size, round_off)


def singular_text(n: int, finding: str) -> str:
    """Message about a singular matrix of n unknowns."""
    text = f"PivotingSolver: the {n} x {n} matrix is singular ({finding})."
    return f"{text} Look for joints that hold the same motion twice and for nodes without mass and stiffness."


def solve_dense(A: np.ndarray, b: np.ndarray) -> np.ndarray:
    """x (n,) or (n, k) with A (n, n) x = b, scaled, refined once, and held against the limits of `PivotingSolver`."""
    # A `SolveError` tells an entry that is not finite, or a matrix so near to singular that x misses the equations.
    n = len(b)
    if not np.isfinite(A).all():
        i, j = np.argwhere(~np.isfinite(A))[0]
        raise SolveError(f"entry ({i}, {j}) of the matrix is {A[i, j]}; it must be finite.")
    # Masses of machines of micrometres are so far below the entries of joints that the largest entries of rows and
    # columns hide them: then those on the diagonal become 1 first.
    diagonal = np.abs(np.diagonal(A))
    for first in (np.ones(n), 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))):
        r, c = (first * one for one in scales(first[:, None] * np.abs(A) * first))
        scaled = r[:, None] * A * c
        right = (r * b.T).T
        try:
            x = solve(scaled, right)
            x += solve(scaled, right - scaled @ x)  # factored again: 20 us, and scipy's factors take 0.15 s to import
        except LinAlgError:
            finding = "a pivot is exactly 0"
            continue
        residual, size, far = (np.abs(one).max(axis=0, initial=0.0) for one in (right - scaled @ x, right, x))
        if all(map(is_fulfilled, *map(np.atleast_1d, (residual, size, far)))):
            return np.asarray((c * x.T).T)
        finding = f"a residual of {np.max(residual):.1e} is left"
    raise SolveError(singular_text(n, finding))


def scales(size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Factors of rows and of columns that bring the largest entry of each near 1 (Ruiz, see `PivotingSolver`)."""
    # `size` (n, n) are absolute values.
    r, c = np.ones(len(size)), np.ones(len(size))
    for _ in range(SCALING_ROUNDS):
        scaled = size * r[:, None] * c
        in_row, in_column = scaled.max(axis=1, initial=0.0), scaled.max(axis=0, initial=0.0)
        r /= np.sqrt(np.where(in_row > 0.0, in_row, 1.0))
        c /= np.sqrt(np.where(in_column > 0.0, in_column, 1.0))
    return r, c


# Functions for matrices that are plain arrays in small models and sparse in large ones

DENSE_UNKNOWNS = 240  # unknowns up to which plain arrays are used; at 270 sparse ones are as fast


def plain(A: Any) -> np.ndarray:
    """A as a plain array."""
    return A if isinstance(A, np.ndarray) else A.toarray()


def stacked(upper: Any, lower: Any) -> Any:
    """The rows of `upper` above the rows of `lower`; plain if both are plain."""
    if isinstance(upper, np.ndarray) and isinstance(lower, np.ndarray):
        return np.concatenate([upper, lower])
    return sp.vstack([upper, lower]).tocsr()


def scaled_rows(factors: np.ndarray, A: Any) -> Any:
    """Each row of A times its factor."""
    return factors[:, None] * A if isinstance(A, np.ndarray) else A.multiply(factors[:, None]).tocsr()


def bordered_solution(S: Any, A: Any, b: np.ndarray) -> np.ndarray | None:
    """x with [[S, A^T], [A, 0]] x = b (n + m,), None where the matrix is singular to the last digit."""
    # S (n, n) is symmetric or not, A is (m, n).
    if isinstance(S, np.ndarray) and isinstance(A, np.ndarray):
        m, n = A.shape
        whole = np.zeros((n + m, n + m))
        whole[:n, :n], whole[:n, n:], whole[n:, :n] = S, A.T, A
        try:
            return np.linalg.solve(whole, b)
        except np.linalg.LinAlgError:
            return None
    try:
        return np.asarray(sp.linalg.splu(sp.block_array([[S, A.T], [A, None]]).tocsc()).solve(b))
    except RuntimeError:
        return None
