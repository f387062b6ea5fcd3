"""Solver for large matrices that change little from one solution to the next."""

from typing import Any

import numpy as np

from flexmb.engine.linalg.dense import PivotingSolver, is_fulfilled, singular_text
from flexmb.engine.linalg.rank import norm_of_inverse
from flexmb.engine.linalg.symbolic import Symbolic
from flexmb.errors import SolveError
from flexmb.late import sp

# Pivot on the diagonal relative to the largest entry of its column, down to which it is taken: less fill than with the
# largest entry, at most ten times the growth, which the refinement makes up for.
DIAGONAL_SHARE = 0.1
EXACT = 1e-14  # backward error of every equation up to which a solution is that of factors of this very matrix
FLOOR = 1e-6  # terms of an equation relative to those of the largest one, below which the latter are its measure
# Number of refinements at most; each with old factors takes a thirtieth of the time of new factors.
MOST_REFINEMENTS = 12
# Backward error after a refinement with old factors relative to that before, above which new factors are faster.
SLOWEST = 0.2
# Norm of the inverse of the scaled matrix below which no vector is mapped to round-off: that of a singular matrix is
# 1e16, and the estimate may be a tenth of the norm.
REGULAR = 1e11


class KeptFactors(PivotingSolver):
    """SuperLU in the order of the pattern, whose factors are kept for the next matrices."""

    # A solution with a new matrix is refined with the factors of an old one until its backward error is that of factors
    # of its own; these are made where that does not converge.
    # Source of the backward error and its refinement: M. Arioli, J. W. Demmel, I. S. Duff, Solving sparse linear
    # systems with sparse backward error, SIAM Journal on Matrix Analysis and Applications 10 (1989) 165-190.

    def __init__(self, symbolic: Symbolic) -> None:
        super().__init__(symbolic)
        self._order = symbolic.order
        place = np.empty(self._n, dtype=np.int64)
        place[self._order] = np.arange(self._n)
        rows, cols = place[self._rows], place[self._cols]
        by_column = np.lexsort((rows, cols))
        self._take(rows[by_column], cols[by_column], self._from[by_column])
        self._lu: Any = None
        self.factored = 0

    def factor(self, values: np.ndarray) -> "KeptFactors":
        """Take the `values` of A, not factored, in the layout of the pattern; returns the solver itself."""
        # Raises `SolveError` if a value is not finite.
        data = self._finite(values)
        self._matrix = sp.csc_matrix((data, self._rows, self._column_starts), shape=(self._n, self._n))
        self._sizes = abs(self._matrix)
        self._is_own = False
        return self

    def solve(self, b: np.ndarray, accuracy: float = 0.0) -> np.ndarray:
        """X with A x = b, (n,); `SolveError` if A is so near to singular that x does not fulfil the equations."""
        # accuracy : last refinement of x with old factors, relative to x, that suffices; 0: that of own factors.
        right = b[self._order]
        if self._lu is not None and not self._is_own:
            x, is_good = self._refined(right, accuracy)
            if is_good and (accuracy or self._residual_left(x, right) is None):
                return self._in_place(x)
        self._make_factors()
        x = self._refined(right, accuracy)[0]
        left = self._residual_left(x, right)
        if left is not None:
            raise SolveError(singular_text(self._n, f"a residual of {left:.1e} is left"))
        return self._in_place(x)

    def _residual_left(self, x: np.ndarray, right: np.ndarray) -> float | None:
        """Residual of the scaled equations where it tells that A is singular."""
        residual = np.max(np.abs(self._r * (right - self._matrix @ x)), initial=0.0)
        size, far = np.max(np.abs(self._r * right), initial=0.0), np.max(np.abs(x / self._c), initial=0.0)
        return None if is_fulfilled(float(residual), float(size), float(far)) else float(residual)

    def _in_place(self, x: np.ndarray) -> np.ndarray:
        """Solution in the numbers of the unknowns."""
        solution = np.empty_like(x)
        solution[self._order] = x
        return solution

    def is_regular(self) -> bool:
        """Whether A maps no vector to round-off beyond doubt."""
        try:
            self._make_factors()
        except SolveError:
            return False
        lu = self._lu
        transposed = sp.linalg.LinearOperator(
            lu.shape, matvec=lu.solve, rmatvec=lambda b: lu.solve(b, "T"), matmat=lu.solve, dtype=float
        )
        return norm_of_inverse(transposed) < REGULAR

    def _make_factors(self) -> None:
        """Factors of the matrix itself."""
        if self._is_own:
            return
        self._r, self._c = self._scales(self._sizes.data)
        scaled = self._matrix.data * self._r[self._rows] * self._c[self._cols]
        self._lu, symmetric = None, {"SymmetricMode": True}
        matrix = sp.csc_matrix((scaled, self._rows, self._column_starts), shape=(self._n, self._n))
        try:
            self._lu = sp.linalg.splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=DIAGONAL_SHARE, options=symmetric)
        except RuntimeError as error:
            raise SolveError(singular_text(self._n, str(error))) from error
        self._is_own, self.factored = True, self.factored + 1

    def _refined(self, right: np.ndarray, accuracy: float) -> tuple[np.ndarray, bool]:
        """Solution by the present factors, refined, and whether its accuracy suffices."""
        x, last = self._by_factors(right), np.inf
        for _ in range(MOST_REFINEMENTS):
            left = right - self._matrix @ x
            terms = self._r * (self._sizes @ np.abs(x) + np.abs(right))
            terms = np.maximum(terms, FLOOR * terms.max(initial=0.0))
            error = float(np.max(np.abs(self._r * left) / np.where(terms > 0.0, terms, 1.0), initial=0.0))
            if error <= EXACT:
                return x, True
            if not error <= SLOWEST * last:
                return x, False
            change = self._by_factors(left)
            x, last = x + change, error
            if np.abs(change / self._c).max() <= accuracy * np.abs(x / self._c).max():
                return x, True
        return x, False

    def _by_factors(self, right: np.ndarray) -> np.ndarray:
        return np.asarray(self._c * self._lu.solve(self._r * right))
