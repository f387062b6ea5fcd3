"""Factors L and U of A on a fixed pattern, without pivoting and without searching; a pivoting solver to fall back on.

The pattern comes from `flexmb.program.symbolic`, the values live in one array in its layout: the caller adds the
entries of A at the positions it was told, `factor` turns them into L and U in place, `solve` uses them.

Without pivoting the factors are as good as the pivots, which `factor` watches, and the growth of the entries, which
it does not: compare `multiply` with the right-hand side where the result matters, and call `PivotingSolver` where the
difference is large.

Source: T. A. Davis, Direct Methods for Sparse Linear Systems, SIAM 2006, section 6.3 (right-looking LU).
"""

from typing import NamedTuple

import numpy as np

from flexmb.errors import SolveError
from flexmb.kernels import compiled
from flexmb.program.symbolic import Symbolic
from flexmb.solve.substitute import forward, solve

THRESHOLD = 1e-13
"""Pivot relative to the largest term that was summed up to it: below this, only round-off is left of it."""

HOLD = 1e-8
"""Pivot of a constraint's row relative to the largest term that was summed up to it, below which its multiplier is
held: the sine of the angle between this row and those before it is then 1e-4."""

HELD = -2
"""What `factor` returns when multipliers are held; -1 when none is."""

NO_ROW = 1 << 62
"""First constraint for `factor` when no multiplier may be held."""

GOOD_RESIDUAL = 1e-6
"""Residual relative to the right-hand side, both scaled, that only a singular matrix leaves after pivoting."""

ROUND_OFF = 1e-14
"""Round-off of A x relative to the largest entry of x, both scaled."""

SINGULAR_GROWTH = 1e13
"""Largest entry of x relative to that of the right-hand side above which A counts as singular: one of 500 beam elements
reaches 2e11, one without an inverse about 1e16."""

SCALING_ROUNDS = 5
"""Each round about halves the exponents of what a row and a column lack to the size 1: 1e16 becomes sqrt(1e1)."""


class LU(NamedTuple):
    """The arrays of `Symbolic` that the compiled functions walk along, read-only."""

    order: np.ndarray
    starts: np.ndarray
    row_ptr: np.ndarray
    rows: np.ndarray
    value_ptr: np.ndarray
    target_ptr: np.ndarray
    targets: np.ndarray


def tables(symbolic: Symbolic) -> LU:
    """What `factor`, `solve` and `multiply` need of `symbolic`: its integer arrays, shared with it."""
    return LU(*(getattr(symbolic, name) for name in LU._fields))


@compiled
def factor(sym, lu, seen, threshold, first_row=NO_ROW, hold=HOLD):
    """A = L U in place; -1, HELD, or the first unknown in elimination order whose pivot is lost or not finite.

    L has a unit diagonal, that of U is left inverted.  sym : LU; lu : (size,); seen : (n,) workspace; threshold [1];
    first_row : number of the first constraint; hold [1] : see below.
    A pivot is lost if it is not larger than threshold times the largest term that was summed up to it.  Unlike the
    entries of its row, these terms scale as the pivot does when units or the time step change: G S^-1 G^T of a
    joint may be 1e-12 beside a 1 in G and still have all its digits.

    A constraint whose pivot is `hold` times that term or smaller hardly differs from those before it.  It is left out,
    as if its pivot were infinite: `solve` then leaves its multiplier as it is.  At its place `seen` becomes negative.
    """
    order, starts, row_ptr, rows, value_ptr, target_ptr, targets = sym
    _start_seen(starts, row_ptr, value_ptr, lu, seen)
    held = -1
    for s in range(len(starts) - 1):
        first, at, t, r = starts[s], value_ptr[s], target_ptr[s], row_ptr[s]
        w, u = starts[s + 1] - first, row_ptr[s + 1] - r
        if w == 3:
            lost = _eliminate_3(lu, at, u, seen, first, threshold, order, first_row, hold)
        else:
            lost = _eliminate(lu, at, w, u, seen, first, threshold, order, first_row, hold)
        if lost >= 0:
            return order[first + lost]
        held = min(held, lost)
        if w == 3:
            _see_3(lu, at, u, seen, rows, r)
            _update_3(lu, at, u, targets, t)
        elif w == 2:
            _see(lu, at, w, u, seen, rows, r)
            _update_2(lu, at, u, targets, t)
        else:
            _see(lu, at, w, u, seen, rows, r)
            _update_1(lu, at, u, targets, t)
    return held


@compiled
def _start_seen(starts, row_ptr, value_ptr, lu, seen):
    """The diagonal of A, in the order of elimination."""
    for s in range(len(starts) - 1):
        first, w = starts[s], starts[s + 1] - starts[s]
        stride = w + row_ptr[s + 1] - row_ptr[s] + 1
        for k in range(w):
            seen[first + k] = abs(lu[value_ptr[s] + k * stride])


@compiled
def _see(lu, at, w, u, seen, rows, r):
    """Largest term so far on the diagonals below a panel."""
    length = w + u
    for i in range(u):
        term = 0.0
        for k in range(w):
            term += lu[at + k * length + w + i] * lu[at + w * length + k * u + i]
        seen[rows[r + i]] = max(seen[rows[r + i]], abs(term))


@compiled
def _eliminate(lu, at, w, u, seen, first, threshold, order, first_row, hold):
    """Rows of U and transposed rows of L in one panel; the pivot that is lost, or HELD, or -1."""
    length, lower, held = w + u, at + w * (w + u), -1
    watched = threshold if first_row == NO_ROW else max(threshold, hold)
    for k in range(w):
        row, column = at + k * length, lower + k * u
        pivot = lu[row + k]
        inverse = 1.0 / pivot
        if not watched * seen[first + k] < abs(pivot) < np.inf:  # false for nan, too
            if order[first + k] >= first_row and abs(pivot) < np.inf:
                inverse, held = 0.0, HELD
                seen[first + k] = -max(seen[first + k], 1e-300)
            elif not threshold * seen[first + k] < abs(pivot) < np.inf:
                return k
        lu[row + k] = inverse
        for j in range(u):
            lu[column + j] *= inverse
        for i in range(k + 1, w):
            here, there = at + i * length, lower + i * u
            left, above = lu[here + k] * inverse, lu[row + i]
            lu[here + k] = left
            seen[first + i] = max(seen[first + i], abs(left * above))
            for j in range(k + 1, length):
                lu[here + j] -= left * lu[row + j]
            for j in range(u):
                lu[there + j] -= above * lu[column + j]
    return held


@compiled
def _inverse(pivot, summed, threshold, watched, may_hold):
    """1 / pivot and -1; 0 and HELD for one that is held; 0 and 0 for one that is lost."""
    size = abs(pivot)
    if watched * summed < size < np.inf:  # false for nan, too
        return 1.0 / pivot, -1
    if may_hold and size < np.inf:
        return 0.0, HELD
    if threshold * summed < size < np.inf:
        return 1.0 / pivot, -1
    return 0.0, 0


@compiled
def _eliminate_3(lu, at, u, seen, first, threshold, order, first_row, hold):
    """`_eliminate` for three pivots: the corner first, then all that stands beside and below it in one pass."""
    a, b, c = at, at + 3 + u, at + 6 + 2 * u
    watched = threshold if first_row == NO_ROW else max(threshold, hold)
    i0, s0 = _inverse(lu[a], seen[first], threshold, watched, order[first] >= first_row)
    if s0 == 0:
        return 0
    a1, a2, b0, c0 = lu[a + 1], lu[a + 2], lu[b] * i0, lu[c] * i0
    near1, near2 = b0 * a1, c0 * a2
    seen1 = max(seen[first + 1], abs(near1))
    i1, s1 = _inverse(lu[b + 1] - near1, seen1, threshold, watched, order[first + 1] >= first_row)
    if s1 == 0:
        return 1
    b2, c1 = lu[b + 2] - b0 * a2, (lu[c + 1] - c0 * a1) * i1
    seen2 = max(seen[first + 2], abs(near2), abs(c1 * b2))
    i2, s2 = _inverse(lu[c + 2] - near2 - c1 * b2, seen2, threshold, watched, order[first + 2] >= first_row)
    if s2 == 0:
        return 2
    seen[first] = -max(seen[first], 1e-300) if s0 == HELD else seen[first]
    seen[first + 1] = -max(seen1, 1e-300) if s1 == HELD else seen1
    seen[first + 2] = -max(seen2, 1e-300) if s2 == HELD else seen2
    lu[a], lu[b], lu[b + 1], lu[b + 2], lu[c], lu[c + 1], lu[c + 2] = i0, b0, i1, b2, c0, c1, i2
    lower = c + 3 + u
    for j in range(u):
        x, p = lu[a + 3 + j], lu[lower + j] * i0
        y, q = lu[b + 3 + j] - b0 * x, (lu[lower + u + j] - a1 * p) * i1
        lu[b + 3 + j], lu[c + 3 + j] = y, lu[c + 3 + j] - c0 * x - c1 * y
        lu[lower + j], lu[lower + u + j] = p, q
        lu[lower + 2 * u + j] = (lu[lower + 2 * u + j] - a2 * p - b2 * q) * i2
    return min(s0, s1, s2)


@compiled
def _see_3(lu, at, u, seen, rows, r):
    """`_see` for three pivots."""
    a, b, c, d = at + 3, at + 6 + u, at + 9 + 2 * u, at + 9 + 3 * u
    for i in range(u):
        term = lu[a + i] * lu[d + i] + lu[b + i] * lu[d + u + i] + lu[c + i] * lu[d + 2 * u + i]
        seen[rows[r + i]] = max(seen[rows[r + i]], abs(term))


@compiled
def _update_1(lu, at, u, targets, t):
    """Subtract the product of a panel's L and U wherever it belongs: one pivot."""
    a, lower = at + 1, at + 1 + u
    for i in range(u):
        x = lu[lower + i]
        for j in range(u):
            lu[targets[t + j]] -= x * lu[a + j]
        t += u


@compiled
def _update_2(lu, at, u, targets, t):
    """`_update_1` for two pivots."""
    a, b, lower = at + 2, at + 4 + u, at + 4 + 2 * u
    for i in range(u):
        x, y = lu[lower + i], lu[lower + u + i]
        for j in range(u):
            lu[targets[t + j]] -= x * lu[a + j] + y * lu[b + j]
        t += u


@compiled
def _update_3(lu, at, u, targets, t):
    """`_update_1` for three pivots."""
    a, b, c, lower = at + 3, at + 6 + u, at + 9 + 2 * u, at + 9 + 3 * u
    for i in range(u):
        x, y, z = lu[lower + i], lu[lower + u + i], lu[lower + 2 * u + i]
        for j in range(u):
            lu[targets[t + j]] -= x * lu[a + j] + y * lu[b + j] + z * lu[c + j]
        t += u


@compiled
def dependence(sym, lu, s, k, b, x, y):
    """X with A x = 0 but for x = 1 at the row k of panel s, which `factor` held; b, x, y : (n,), three arrays.

    The factors of the rows before it are exact, so the solution of U x = 1 with a pivot of 1 in place of 0 is this x.
    """
    stride = sym.starts[s + 1] - sym.starts[s] + sym.row_ptr[s + 1] - sym.row_ptr[s]
    diagonal = sym.value_ptr[s] + k * (stride + 1)
    b[:] = 0.0
    b[sym.order[sym.starts[s] + k]] = 1.0
    lu[diagonal] = 1.0
    solve(sym, lu, b, x, y)
    lu[diagonal] = 0.0


@compiled
def left_over(sym, lu, seen, b, y):
    """What `solve` will leave of b in the constraints that `factor` held, largest absolute value; b, y : (n,)."""
    for k in range(len(sym.order)):
        y[k] = b[sym.order[k]]
    forward(sym.starts, sym.row_ptr, sym.rows, sym.value_ptr, lu, y)
    largest = 0.0
    for k in range(len(sym.order)):
        if seen[k] < 0.0:
            largest = max(largest, abs(y[k]))
    return largest


@compiled
def first_held(sym, seen):
    """The first constraint that `factor` held."""
    for place in range(len(sym.order)):
        if seen[place] < 0.0:
            return sym.order[place]
    return 0


@compiled
def weakest(sym, lu, seen, first_row):
    """Smallest pivot of a constraint that is not held, relative to the largest term that was summed up to it."""
    least = 1.0
    for s in range(len(sym.starts) - 1):
        first, w = sym.starts[s], sym.starts[s + 1] - sym.starts[s]
        stride = w + sym.row_ptr[s + 1] - sym.row_ptr[s] + 1
        for k in range(w):
            inverse = abs(lu[sym.value_ptr[s] + k * stride])
            if sym.order[first + k] >= first_row and seen[first + k] > 0.0 and inverse > 0.0:
                least = min(least, 1.0 / (inverse * seen[first + k]))
    return least


@compiled
def multiply(sym, values, x, y):
    """Y = A x with values that are not factored yet.  sym : LU; values : (size,); x, y : (n,), two arrays."""
    order, starts, row_ptr, rows, value_ptr = sym.order, sym.starts, sym.row_ptr, sym.rows, sym.value_ptr
    y[:] = 0.0
    for s in range(len(starts) - 1):
        first, r, at = starts[s], row_ptr[s], value_ptr[s]
        w, u = starts[s + 1] - first, row_ptr[s + 1] - r
        length, lower = w + u, at + w * (w + u)
        for k in range(w):
            here = order[first + k]
            for j in range(w):
                y[here] += values[at + k * length + j] * x[order[first + j]]
            for j in range(u):
                there = order[rows[r + j]]
                y[here] += values[at + k * length + w + j] * x[there]
                y[there] += values[lower + k * u + j] * x[here]


class PivotingSolver:
    """Slow and safe: SuperLU with partial pivoting on rows and columns scaled to the size 1, refined once.

    Parameters
    ----------
    symbolic : Symbolic
        Pattern in whose layout the values come.

    Notes
    -----
    Source of the scaling: D. Ruiz, A scaling algorithm to equilibrate both rows and columns norms in matrices,
    report RAL-TR-2001-034, Rutherford Appleton Laboratory, 2001, algorithm 1 with the maximum norm.

    Examples
    --------
    [[0, 2], [1, 0]] x = [4, 3], which `factor` cannot do:

    >>> import numpy as np
    >>> from flexmb.program.symbolic import symbolic
    >>> swap = symbolic(2, [0], [1], [0, 1])
    >>> values = np.zeros(swap.size)
    >>> values[swap.positions([0, 1], [1, 0])] = [2.0, 1.0]
    >>> PivotingSolver(swap).factor(values).solve(np.array([4.0, 3.0])).tolist()
    [3.0, 2.0]
    """

    def __init__(self, symbolic: Symbolic) -> None:
        self._n = symbolic.n
        self._rows, self._cols = symbolic.a_rows, symbolic.a_cols
        self._from = symbolic.positions(self._rows, self._cols)
        self._column_starts = np.searchsorted(self._cols, np.arange(self._n + 1))
        self._by_row = np.argsort(self._rows, kind="stable")
        self._row_starts = np.searchsorted(self._rows[self._by_row], np.arange(self._n))

    def factor(self, values: np.ndarray) -> "PivotingSolver":
        """Take the `values` of A, not factored, in the layout of the pattern; returns the solver itself.

        Raises `SolveError` if a value is not finite or A is singular to the last digit.
        """
        from scipy.sparse import csc_matrix  # noqa: PLC0415 - large models alone need it, and it takes long to import
        from scipy.sparse.linalg import splu  # noqa: PLC0415

        data = values[self._from]
        bad = np.flatnonzero(~np.isfinite(data))
        if bad.size:
            entry = f"({self._rows[bad[0]]}, {self._cols[bad[0]]})"
            raise SolveError(f"PivotingSolver: entry {entry} of the matrix is {data[bad[0]]}; it must be finite.")
        self._r, self._c = self._scales(np.abs(data))
        scaled = data * self._r[self._rows] * self._c[self._cols]
        self._matrix = csc_matrix((scaled, self._rows, self._column_starts), shape=(self._n, self._n))
        try:
            self._factors = splu(self._matrix)
        except RuntimeError as error:
            raise SolveError(singular_text(self._n, str(error))) from error
        return self

    def solve(self, b: np.ndarray) -> np.ndarray:
        """X with A x = b, (n,); `SolveError` if A is so near to singular that x does not fulfil the equations."""
        right = self._r * b
        x = self._factors.solve(right)
        x += self._factors.solve(right - self._matrix @ x)
        residual = np.max(np.abs(right - self._matrix @ x), initial=0.0)
        size, far = np.max(np.abs(right), initial=0.0), np.max(np.abs(x), initial=0.0)
        # a fine mesh answers a small load by a large x; what is left then is the round-off of the product A x
        round_off = ROUND_OFF * far if far / SINGULAR_GROWTH <= size else 0.0
        if not residual <= max(GOOD_RESIDUAL * size, round_off):
            raise SolveError(singular_text(self._n, f"a residual of {residual:.1e} is left"))
        return self._c * x

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


def singular_text(n: int, finding: str) -> str:
    """What to say about a matrix of n unknowns without an inverse."""
    return (
        f"PivotingSolver: the {n} x {n} matrix is singular ({finding}). Look for joints that hold the same motion "
        "twice and for nodes without mass and stiffness."
    )
