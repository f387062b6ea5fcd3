"""Large matrices: factors kept from one solution to the next, bordered systems, signs of eigenvalues, null vectors.

Bordered matrices take an order of elimination in which constraints follow their coordinates, as `elimination_order`
gives it: an order by fill alone eliminates a body before the constraints that hold it, whose pivots are then round-off.
"""

from __future__ import annotations

from collections.abc import Callable
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

    def factor(self, values: np.ndarray) -> KeptFactors:
        """Take the `values` of A, not factored, in the layout of the pattern; returns the solver itself."""
        # Raises `SolveError` if a value is not finite.
        self._matrix = sp.csc_matrix((self._finite(values), self._rows, self._column_starts), shape=(self._n, self._n))
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


# Null vectors of a rectangular matrix: combinations of its columns that vanish

DENSE_COLUMNS = 150  # number of columns up to which singular values are computed
VANISHING = 1e-13  # singular value, relative to the largest, below which a combination of columns vanishes
# Weight w of the residual in the bordered matrix: a singular value s becomes an eigenvalue s^2/w, which is far above
# round-off where s is above VANISHING.
REGULARISATION = 1e-12
LEAST_PIVOT = 1e-20  # number on the diagonal that keeps the bordered matrix regular
FIRST_VECTORS = 4  # number of vectors looked for at first; then four times as many
# Number of inverse iterations; each separates a vanishing combination from all others by ten powers of ten.
ITERATIONS = 4


def null_vector(B: sp.sparray) -> np.ndarray | None:
    """A vector x (n,) of length 1 with B x = 0 but for round-off, or None."""
    # Few columns take a singular value decomposition, many an inverse iteration with the sparse factors of [[w 1, B],
    # [B^T, 0]], whose eigenvalues near zero are -s^2/w for singular values s much smaller than the weight w. The rows
    # of B (m, n) have comparable size.
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
    """Orthonormal vectors x (n, k) with B x = 0 but for round-off, all there are."""
    # Inverse iterations of `null_vector`, with more vectors until one does not vanish. B (m, n) has rows of like size.
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


def _bordered(scaled: sp.sparray) -> sp.linalg.SuperLU:
    """Factors of [[w 1, B], [B^T, 0]]."""
    m, n = scaled.shape
    bordered = sp.block_array([[REGULARISATION * sp.eye_array(m), scaled], [scaled.T, -LEAST_PIVOT * sp.eye_array(n)]])
    return sp.linalg.splu(bordered.tocsc())


def largest_singular_value(B: sp.sparray) -> float:
    """Largest singular value, by a power iteration: at least the half of it."""
    x, size = np.cos(np.arange(B.shape[1]) ** 2.0), 0.0
    for _ in range(10):
        norm = float(np.linalg.norm(x))
        if norm == 0.0:
            return float(np.sqrt((B * B).sum()))
        y = B @ (x / norm)
        size, x = float(np.linalg.norm(y)), B.T @ y
    return size


Solve = Callable[[np.ndarray], np.ndarray]
# Compliance of the joints against that of the structure, both scaled to 1: their rows then need not be independent.
JOINT_COMPLIANCE = 1e-10
HOLD = 4.0  # factor w of G^T G beside K, its largest entry in each row scaled to 1: where K is -1 the sum is not 0
DENSE_PIVOTS = 1500  # number of unknowns up to which eigenvalues are counted where a pivot is zero


def solver(A: sp.csc_matrix, order: np.ndarray) -> Solve:
    """Solver of A x = b, x and b (n,) or (n, k); `RuntimeError` for a singular A (n, n), of symmetric pattern."""
    # `order` is the order of elimination of the first unknowns; the rest follow.
    order = np.append(order, np.arange(len(order), A.shape[0]))
    turned, options = A[order][:, order].tocsc(), {"SymmetricMode": True}
    factors = sp.linalg.splu(turned, permc_spec="NATURAL", diag_pivot_thresh=DIAGONAL_SHARE, options=options)

    def solve(b: np.ndarray) -> np.ndarray:
        x = np.empty_like(b)
        x[order] = factors.solve(b[order])
        return x

    return solve


def is_regular(K: Any, G: Any, order: np.ndarray) -> bool:
    """Whether beyond doubt no motion x but 0 has K x = 0 and G x = 0, and no row of G depends on the others."""
    # K (n, n) is symmetric or nearly so, G (m, n) are constraints; `order` is that of the n + m unknowns.
    scale, rows = scaled(K, G)
    A = sp.block_array([[scale @ K @ scale, rows.T], [rows, None]]).tocsc()
    try:
        solve = solver(A, order)
    except RuntimeError:
        return False
    return norm_of_inverse(sp.linalg.LinearOperator(A.shape, matvec=solve, rmatvec=solve, dtype=float)) < REGULAR


def negative_eigenvalues(K: Any, G: Any, order: np.ndarray) -> int | None:
    """Number of negative eigenvalues of a symmetric K on the motions x with G x = 0; None where a pivot is zero."""
    # K is (n, n), G (m, n), redundant rows may be among them; `order` is the order of elimination of the n + m
    # unknowns.
    # A = [[K + w G^T G, G^T], [G, -c 1]] = L D L^T has m negative pivots, and one more for each negative eigenvalue of
    # K + (w + 1/c) G^T G (Sylvester's law of inertia), all scaled to 1. w G^T G holds each body from the beginning, so
    # that pivots of what a constraint holds later are no round-off. Where a pivot is zero nonetheless, the eigenvalues
    # of a small A are counted instead.
    m = G.shape[0]
    scale, rows = scaled(K, G)
    held = scale @ K @ scale + HOLD * (rows.T @ rows)
    A = sp.csc_array(sp.block_array([[held, rows.T], [rows, -JOINT_COMPLIANCE * sp.eye_array(m)]]))[order][:, order]
    try:
        lu = sp.linalg.splu(A.tocsc(), permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:
        return None
    if np.array_equal(lu.perm_r, lu.perm_c):
        return int(np.count_nonzero(lu.U.diagonal() < 0.0)) - int(m)
    if A.shape[0] > DENSE_PIVOTS:
        return None
    values = np.linalg.eigvalsh(A.toarray())
    if np.abs(values).min() < 1e-15 * np.abs(values).max():
        return None
    return int(np.count_nonzero(values < 0.0)) - int(m)


def scaled(K: Any, G: Any) -> tuple[Any, Any]:
    """Diagonal matrix D by which the entries of D K D are 1 at most, and G D with rows of length 1."""
    largest = np.asarray(abs(K).max(axis=1).todense()).ravel()
    scale = sp.diags_array(1.0 / np.sqrt(np.where(largest > 0.0, largest, 1.0)))
    rows = sp.csr_array(G @ scale)
    lengths = np.sqrt(np.asarray(rows.multiply(rows).sum(axis=1)).ravel())
    return scale, sp.diags_array(1.0 / np.where(lengths > 0.0, lengths, 1.0)) @ rows
