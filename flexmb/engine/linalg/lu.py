"""Factors L and U of A on a fixed pattern, without pivoting and without searching; solutions with them.

Of two, the second stands beside the first in the workspace, so one value of L or U meets two neighbouring numbers, and
the places of the rows are read once.  Panels of three unknowns, the coordinates of a node, are unrolled.

Parts of arrays are taken by `part_of`: an index that is known to begin at 0 needs no look whether it counts from the
end, which took a third of the time.

The pattern comes from `flexmb.engine.linalg.symbolic`; all values are in one array of its layout.  The caller adds the
entries of A at their positions, `factor` turns them into L and U in place, and `solve` uses the factors.

Without pivoting, the accuracy of the factors depends on the pivots, which `factor` tests, and on the growth of entries,
which it does not test.  Where results matter, compare A x with the right-hand side, and call `PivotingSolver` for large
differences.

Source: T. A. Davis, Direct Methods for Sparse Linear Systems, SIAM 2006, section 6.3 (right-looking LU).
"""

import math
from weakref import WeakKeyDictionary

import numpy as np

from flexmb.engine.compiled.arrays import matrix_view, part_of
from flexmb.engine.compiled.records import Integers, Places, Record, SmallPlaces
from flexmb.engine.linalg.symbolic import Symbolic
from flexmb.kernels import compiled


# Solution with the factors of `lu`, for one right-hand side or for two in one pass
@compiled
def solve(sym, lu, b, x, y):
    """A x = b with the values that `factor` left.  sym : LU; b, x : (n,), may be one array; y : (n,) workspace."""
    into = sym.into
    for k in range(len(into)):
        y[k] = b[into[k]]
    forward(sym.starts, sym.row_ptr, sym.rows, sym.value_ptr, lu, y)
    backward(sym.starts, sym.row_ptr, sym.rows, sym.value_ptr, lu, y)
    for k in range(len(into)):
        x[into[k]] = y[k]


@compiled
def forward(starts, row_ptr, rows, value_ptr, lu, y):
    """Y = L^-1 y."""
    for s in range(len(starts) - 1):
        at, w, u = value_ptr[s], starts[s + 1] - starts[s], row_ptr[s + 1] - row_ptr[s]
        own, below, length = part_of(y, starts[s], starts[s + 1]), part_of(rows, row_ptr[s], row_ptr[s + 1]), w + u
        a = at + w * length
        if w == 3:
            b, c = part_of(lu, at + length, a), part_of(lu, at + 2 * length, a)
            p0 = own[0]
            p1 = own[1] - b[0] * p0
            p2 = own[2] - c[0] * p0 - c[1] * p1
            own[1], own[2] = p1, p2
            l0, l1, l2 = part_of(lu, a, a + u), part_of(lu, a + u, a + 2 * u), part_of(lu, a + 2 * u, a + 3 * u)
            for i in range(u):
                y[below[i]] -= l0[i] * p0 + l1[i] * p1 + l2[i] * p2
        elif w == 2:
            p0, l0, l1 = own[0], part_of(lu, a, a + u), part_of(lu, a + u, a + 2 * u)
            p1 = own[1] - part_of(lu, at + length, a)[0] * p0
            own[1] = p1
            for i in range(u):
                y[below[i]] -= l0[i] * p0 + l1[i] * p1
        else:
            p0, l0 = own[0], part_of(lu, a, a + u)
            for i in range(u):
                y[below[i]] -= l0[i] * p0


@compiled
def backward(starts, row_ptr, rows, value_ptr, lu, y):
    """Y = U^-1 y; the diagonal of U is kept inverted."""
    for s in range(len(starts) - 2, -1, -1):
        at, w, u = value_ptr[s], starts[s + 1] - starts[s], row_ptr[s + 1] - row_ptr[s]
        own, below, length = part_of(y, starts[s], starts[s + 1]), part_of(rows, row_ptr[s], row_ptr[s + 1]), w + u
        if w == 3:
            a, b = part_of(lu, at, at + length), part_of(lu, at + length, at + 2 * length)
            c = part_of(lu, at + 2 * length, at + 3 * length)
            p0, p1, p2 = own[0], own[1], own[2]
            for j in range(u):
                p = y[below[j]]
                p0, p1, p2 = p0 - a[3 + j] * p, p1 - b[3 + j] * p, p2 - c[3 + j] * p
            p2 *= c[2]
            p1 = (p1 - b[2] * p2) * b[1]
            own[0], own[1], own[2] = (p0 - a[1] * p1 - a[2] * p2) * a[0], p1, p2
        elif w == 2:
            a, b = part_of(lu, at, at + length), part_of(lu, at + length, at + 2 * length)
            p0, p1 = own[0], own[1]
            for j in range(u):
                p = y[below[j]]
                p0, p1 = p0 - a[2 + j] * p, p1 - b[2 + j] * p
            p1 *= b[1]
            own[0], own[1] = (p0 - a[1] * p1) * a[0], p1
        else:
            a, p0 = part_of(lu, at, at + length), own[0]
            for j in range(u):
                p0 -= a[1 + j] * y[below[j]]
            own[0] = p0 * a[0]


@compiled
def solve_two(sym, lu, b, c, x, z, pair):
    """A x = b and A z = c with the values that `factor` left.  sym : LU; b, c, x, z : (n,); pair : (2 n,) workspace."""
    into = sym.into
    y = matrix_view(pair, len(into), 2)
    for k in range(len(into)):
        i = into[k]
        y[k, 0], y[k, 1] = b[i], c[i]
    forward_two(sym.starts, sym.row_ptr, sym.rows, sym.value_ptr, lu, pair)
    backward_two(sym.starts, sym.row_ptr, sym.rows, sym.value_ptr, lu, pair)
    for k in range(len(into)):
        i = into[k]
        x[i], z[i] = y[k, 0], y[k, 1]


@compiled
def forward_two(starts, row_ptr, rows, value_ptr, lu, pair):
    """Y = L^-1 y for two columns."""
    y = matrix_view(pair, starts[len(starts) - 1], 2)
    for s in range(len(starts) - 1):
        at, w, u = value_ptr[s], starts[s + 1] - starts[s], row_ptr[s + 1] - row_ptr[s]
        own, length = part_of(pair, 2 * starts[s], 2 * starts[s + 1]), w + u
        below = part_of(rows, row_ptr[s], row_ptr[s + 1])
        a = at + w * length
        p0, q0 = own[0], own[1]
        l0 = part_of(lu, a, a + u)
        if w == 3:
            b, c = part_of(lu, at + length, a), part_of(lu, at + 2 * length, a)
            p1, q1 = own[2] - b[0] * p0, own[3] - b[0] * q0
            p2, q2 = own[4] - c[0] * p0 - c[1] * p1, own[5] - c[0] * q0 - c[1] * q1
            own[2], own[3], own[4], own[5] = p1, q1, p2, q2
            l1, l2 = part_of(lu, a + u, a + 2 * u), part_of(lu, a + 2 * u, a + 3 * u)
            for i in range(u):
                k, x0, x1, x2 = below[i], l0[i], l1[i], l2[i]
                y[k, 0] -= x0 * p0 + x1 * p1 + x2 * p2
                y[k, 1] -= x0 * q0 + x1 * q1 + x2 * q2
        elif w == 2:
            b, l1 = part_of(lu, at + length, a), part_of(lu, a + u, a + 2 * u)
            p1, q1 = own[2] - b[0] * p0, own[3] - b[0] * q0
            own[2], own[3] = p1, q1
            for i in range(u):
                k, x0, x1 = below[i], l0[i], l1[i]
                y[k, 0] -= x0 * p0 + x1 * p1
                y[k, 1] -= x0 * q0 + x1 * q1
        else:
            for i in range(u):
                k, x0 = below[i], l0[i]
                y[k, 0] -= x0 * p0
                y[k, 1] -= x0 * q0


@compiled
def backward_two(starts, row_ptr, rows, value_ptr, lu, pair):
    """Y = U^-1 y for two columns; the diagonal of U is kept inverted."""
    y = matrix_view(pair, starts[len(starts) - 1], 2)
    for s in range(len(starts) - 2, -1, -1):
        at, w, u = value_ptr[s], starts[s + 1] - starts[s], row_ptr[s + 1] - row_ptr[s]
        own, length = part_of(pair, 2 * starts[s], 2 * starts[s + 1]), w + u
        below = part_of(rows, row_ptr[s], row_ptr[s + 1])
        a = part_of(lu, at, at + length)
        p0, q0 = own[0], own[1]
        if w == 3:
            b, c = part_of(lu, at + length, at + 2 * length), part_of(lu, at + 2 * length, at + 3 * length)
            p1, q1, p2, q2 = own[2], own[3], own[4], own[5]
            for j in range(u):
                k = below[j]
                p, q, x0, x1, x2 = y[k, 0], y[k, 1], a[3 + j], b[3 + j], c[3 + j]
                p0, p1, p2 = p0 - x0 * p, p1 - x1 * p, p2 - x2 * p
                q0, q1, q2 = q0 - x0 * q, q1 - x1 * q, q2 - x2 * q
            p2, q2 = p2 * c[2], q2 * c[2]
            p1, q1 = (p1 - b[2] * p2) * b[1], (q1 - b[2] * q2) * b[1]
            p0, q0 = p0 - a[1] * p1 - a[2] * p2, q0 - a[1] * q1 - a[2] * q2
            own[2], own[3], own[4], own[5] = p1, q1, p2, q2
        elif w == 2:
            b = part_of(lu, at + length, at + 2 * length)
            p1, q1 = own[2], own[3]
            for j in range(u):
                k = below[j]
                p, q, x0, x1 = y[k, 0], y[k, 1], a[2 + j], b[2 + j]
                p0, p1, q0, q1 = p0 - x0 * p, p1 - x1 * p, q0 - x0 * q, q1 - x1 * q
            p1, q1 = p1 * b[1], q1 * b[1]
            p0, q0 = p0 - a[1] * p1, q0 - a[1] * q1
            own[2], own[3] = p1, q1
        else:
            for j in range(u):
                k, x0 = below[j], a[1 + j]
                p0, q0 = p0 - x0 * y[k, 0], q0 - x0 * y[k, 1]
        own[0], own[1] = p0 * a[0], q0 * a[0]


@compiled
def multiply(sym, values, x, y):
    """Compute y = A x with values before `factor`.  sym : LU; values : (size,); x, y : (n,), two arrays."""
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


LOST_PIVOT = 1e-13  # pivot relative to the largest term summed up to it, below which it is round-off: a lost pivot
# Pivot of a constraint row relative to the largest term summed up to it, below which the row is held.
# The sine of the angle between this row and the rows before it is then 1e-4.
HELD_PIVOT = 1e-8
ROWS_HELD = -2  # result of `factor` with held rows; -1 without held rows
NO_ROW = 1 << 62  # number of the first constraint for `factor` if no row may be held


class LU(Record):
    """Arrays of `Symbolic` for the compiled functions, read-only."""

    order: Integers
    starts: Integers
    row_ptr: Integers
    rows: Places
    value_ptr: Integers
    target_ptr: Integers
    targets: SmallPlaces
    # `order` as unsigned indices; rows and targets are unsigned, too, since signed indices are tested for signs
    into: Places
    diagonal: Places  # where the diagonal of A is, in the order of elimination


def tables(symbolic: Symbolic) -> LU:
    """Integer arrays of `symbolic` for `factor` and `solve`; shared and remembered."""
    found = _TABLES.get(symbolic)
    if found is None:
        s, unsigned = symbolic, np.uint64
        into, rows = s.order.view(unsigned), s.rows.view(unsigned)
        diagonal = s.positions(s.order, s.order).view(unsigned)
        diagonal.setflags(write=False)
        found = LU(s.order, s.starts, s.row_ptr, rows, s.value_ptr, s.target_ptr, s.targets, into, diagonal)
        _TABLES[symbolic] = found
    return found


_TABLES: WeakKeyDictionary[Symbolic, LU] = WeakKeyDictionary()


@compiled
def factor(sym, lu, seen, threshold, first_row=NO_ROW, hold=HELD_PIVOT):
    """Factor A = L U in place; -1, ROWS_HELD, or the first unknown whose pivot is lost or not finite."""
    # L has a unit diagonal; the diagonal of U is stored inverted. sym : LU; lu : (size,); seen : (n,) largest terms
    # summed up to the pivots, filled; threshold, hold [1]; first_row : number of the first constraint. A pivot is lost
    # if it is not larger than `threshold` times the largest term summed up to it. These terms scale like the pivot with
    # units and time step, unlike the entries of its row: G S^-1 G^T of a joint may be 1e-12 beside a 1 in G and still
    # have all its digits.
    # A constraint row whose pivot is not larger than `hold` times that term depends on rows before it. The row is held:
    # left out, as with an infinite pivot, so that `solve` does not change its multiplier. Its `seen` becomes negative.
    order, starts, row_ptr, value_ptr = sym.order, sym.starts, sym.row_ptr, sym.value_ptr
    for k in range(len(order)):  # the diagonal of A, in the order of elimination
        seen[k] = abs(lu[sym.diagonal[k]])
    held, watched = -1, threshold if first_row == NO_ROW else max(threshold, hold)
    for s in range(len(starts) - 1):
        first, at, t, r = starts[s], value_ptr[s], sym.target_ptr[s], row_ptr[s]
        w, u = starts[s + 1] - first, row_ptr[s + 1] - r
        below, targets = part_of(sym.rows, r, r + u), part_of(sym.targets, t, t + u * u)
        if u == 2:  # most panels of linkages; a number that is known lets the compiler unroll
            lost = _eliminate_panel(lu, at, w, 2, seen, first, threshold, watched, order, first_row, below, targets)
        else:
            lost = _eliminate_panel(lu, at, w, u, seen, first, threshold, watched, order, first_row, below, targets)
        if lost >= 0:
            return order[first + lost]
        held = min(held, lost)
    return held


@compiled
def _eliminate_panel(lu, at, w, u, seen, first, threshold, watched, order, first_row, below, targets):
    """Eliminate a panel of w pivots with u rows below; the place of a lost pivot, ROWS_HELD, or -1."""
    if w == 1:
        return _eliminate_1(lu, at, u, seen, first, threshold, watched, order, first_row, below, targets)
    if w == 2:
        return _eliminate_2(lu, at, u, seen, first, threshold, watched, order, first_row, below, targets)
    lost = _eliminate_3(lu, at, u, seen, first, threshold, watched, order, first_row)
    if lost < 0:
        # The product of L and U is subtracted from the targets.
        a, b, c, left, middle, right = _beside_3(lu, at, u)
        for i in range(u):
            x, y, z, goal = left[i], middle[i], right[i], part_of(targets, i * u, (i + 1) * u)
            seen[below[i]] = max(seen[below[i]], abs(x * a[i] + y * b[i] + z * c[i]))
            for j in range(u):
                lu[goal[j]] -= x * a[j] + y * b[j] + z * c[j]
    return lost


@compiled
def _inverse(pivot, summed, threshold, watched, may_hold):
    """Inverse of a pivot and -1; 0 and ROWS_HELD for a held row; 0 and 0 for a lost pivot."""
    size = abs(pivot)
    if watched * summed < size < np.inf:  # false for nan, too
        return 1.0 / pivot, -1
    if may_hold and size < np.inf:
        return 0.0, ROWS_HELD
    if threshold * summed < size < np.inf:
        return 1.0 / pivot, -1
    return 0.0, 0


@compiled
def _eliminate_1(lu, at, u, seen, first, threshold, watched, order, first_row, below, targets):
    """Eliminate one pivot: its column of L, and the product with its row of U; 0 if it is lost, ROWS_HELD, or -1."""
    inverse, code = _inverse(lu[at], seen[first], threshold, watched, order[first] >= first_row)
    if code == 0:
        return 0
    seen[first] = -max(seen[first], 1e-300) if code == ROWS_HELD else seen[first]
    lu[at] = inverse
    a, lower = part_of(lu, at + 1, at + 1 + u), part_of(lu, at + 1 + u, at + 1 + 2 * u)
    for i in range(u):
        x, goal = lower[i] * inverse, part_of(targets, i * u, (i + 1) * u)
        lower[i] = x
        seen[below[i]] = max(seen[below[i]], abs(x * a[i]))
        for j in range(u):
            lu[goal[j]] -= x * a[j]
    return code


@compiled
def _eliminate_2(lu, at, u, seen, first, threshold, watched, order, first_row, below, targets):
    """`_eliminate_1` for two pivots; the place of a lost one."""
    b, d = at + 2 + u, at + 4 + 2 * u
    i0, s0 = _inverse(lu[at], seen[first], threshold, watched, order[first] >= first_row)
    if s0 == 0:
        return 0
    above, side = lu[at + 1], lu[b] * i0
    near = side * above
    seen1 = max(seen[first + 1], abs(near))
    i1, s1 = _inverse(lu[b + 1] - near, seen1, threshold, watched, order[first + 1] >= first_row)
    if s1 == 0:
        return 1
    seen[first] = -max(seen[first], 1e-300) if s0 == ROWS_HELD else seen[first]
    seen[first + 1] = -max(seen1, 1e-300) if s1 == ROWS_HELD else seen1
    lu[at], lu[b], lu[b + 1] = i0, side, i1
    right0, right1 = part_of(lu, at + 2, at + 2 + u), part_of(lu, b + 2, d)
    left0, left1 = part_of(lu, d, d + u), part_of(lu, d + u, d + 2 * u)
    for j in range(u):
        right1[j] -= side * right0[j]
        p = left0[j] * i0
        left0[j], left1[j] = p, (left1[j] - above * p) * i1
    for i in range(u):
        x, y, goal = left0[i], left1[i], part_of(targets, i * u, (i + 1) * u)
        seen[below[i]] = max(seen[below[i]], abs(x * right0[i] + y * right1[i]))
        for j in range(u):
            lu[goal[j]] -= x * right0[j] + y * right1[j]
    return min(s0, s1)


@compiled
def _eliminate_3(lu, at, u, seen, first, threshold, watched, order, first_row):
    """Eliminate three pivots: first the corner, then the rows beside and below it in one pass."""
    a, b, c = at, at + 3 + u, at + 6 + 2 * u
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
    seen[first] = -max(seen[first], 1e-300) if s0 == ROWS_HELD else seen[first]
    seen[first + 1] = -max(seen1, 1e-300) if s1 == ROWS_HELD else seen1
    seen[first + 2] = -max(seen2, 1e-300) if s2 == ROWS_HELD else seen2
    lu[a], lu[b], lu[b + 1], lu[b + 2], lu[c], lu[c + 1], lu[c + 2] = i0, b0, i1, b2, c0, c1, i2
    right0, right1, right2, below0, below1, below2 = _beside_3(lu, at, u)
    for j in range(u):
        x, p = right0[j], below0[j] * i0
        y, q = right1[j] - b0 * x, (below1[j] - a1 * p) * i1
        right1[j], right2[j] = y, right2[j] - c0 * x - c1 * y
        below0[j], below1[j] = p, q
        below2[j] = (below2[j] - a2 * p - b2 * q) * i2
    return min(s0, s1, s2)


@compiled
def _beside_3(lu, at, u):
    """Rows of U beside the corner of a panel of three, and transposed rows of L below it, (u,) each."""
    a, b, c, d = at + 3, at + 6 + u, at + 9 + 2 * u, at + 9 + 3 * u
    x, y, z = part_of(lu, d, d + u), part_of(lu, d + u, d + 2 * u), part_of(lu, d + 2 * u, d + 3 * u)
    return part_of(lu, a, a + u), part_of(lu, b, b + u), part_of(lu, c, c + u), x, y, z


@compiled
def null_vector(sym, lu, s, k, b, x, y):
    """Null vector x of A for the held row k of panel s, with x = 1 at this row; b, x, y : (n,), three arrays."""
    # The factors of the rows before are exact, so that the solution of U x = 1 with a pivot of 1 in place of 0 is x.
    stride = sym.starts[s + 1] - sym.starts[s] + sym.row_ptr[s + 1] - sym.row_ptr[s]
    diagonal = sym.value_ptr[s] + k * (stride + 1)
    b[:] = 0.0
    b[sym.order[sym.starts[s] + k]] = 1.0
    lu[diagonal] = 1.0
    solve(sym, lu, b, x, y)
    lu[diagonal] = 0.0


@compiled
def held_residual(sym, lu, seen, b, y):
    """Largest residual that `solve` leaves in held rows for the right-hand side b; b, y : (n,)."""
    # `seen` is -inf for held rows that are not to be looked at.
    for k in range(len(sym.order)):
        y[k] = b[sym.order[k]]
    forward(sym.starts, sym.row_ptr, sym.rows, sym.value_ptr, lu, y)
    largest = 0.0
    for k in range(len(sym.order)):
        if -np.inf < seen[k] < 0.0:
            largest = max(largest, abs(y[k]))
    return largest


@compiled
def first_held_row(sym, seen):
    """Number of the first held constraint row."""
    for place in range(len(sym.order)):
        if seen[place] < 0.0:
            return sym.order[place]
    return 0


@compiled
def smallest_pivot(sym, lu, seen, first_row):
    """Smallest pivot of the constraint rows that are not held, relative to the largest term summed up to it."""
    most = 1.0
    for k in range(len(sym.order)):
        inverse = abs(lu[sym.diagonal[k]])
        if sym.order[k] >= first_row and seen[k] > 0.0 and inverse > 0.0:
            most = max(most, inverse * seen[k])
    return 1.0 / most


# Factors of a complex matrix on the same pattern, for pairs of stages of implicit Runge-Kutta methods
@compiled
def factor_complex(sym, re, im, seen):
    """A = L U in place; -1, or the first unknown in elimination order whose pivot is lost."""
    # sym : LU; re, im : (size,); seen : (n,) what `lu.factor` left of the real matrix of the same joints: rows that it
    # held are held here, too. L has a unit diagonal, that of U is left inverted.
    starts, row_ptr, value_ptr = sym.starts, sym.row_ptr, sym.value_ptr
    for s in range(len(starts) - 1):
        first, at, w, u = starts[s], value_ptr[s], starts[s + 1] - starts[s], row_ptr[s + 1] - row_ptr[s]
        lost = _eliminate(re, im, at, w, u, seen, first)
        if lost >= 0:
            return sym.order[first + lost]
        for k in range(w):
            _update(sym, re, im, at + k * (w + u) + w, at + w * (w + u) + k * u, u, sym.target_ptr[s])
    return -1


@compiled
def _eliminate(re, im, at, w, u, seen, first):
    """Rows of U and transposed rows of L in one panel; the pivot that is lost, or -1."""
    length, lower = w + u, at + w * (w + u)
    for k in range(w):
        row, column = at + k * length, lower + k * u
        a, b = re[row + k], im[row + k]
        square = a * a + b * b
        if not 0.0 < square < math.inf and seen[first + k] >= 0.0:  # true for nan, too
            return k
        inverse_a, inverse_b = (a / square, -b / square) if seen[first + k] >= 0.0 else (0.0, 0.0)
        re[row + k], im[row + k] = inverse_a, inverse_b
        for j in range(u):
            x, y = re[column + j], im[column + j]
            re[column + j], im[column + j] = x * inverse_a - y * inverse_b, x * inverse_b + y * inverse_a
        for i in range(k + 1, w):
            here, there = at + i * length, lower + i * u
            x, y = re[here + k], im[here + k]
            p, q = x * inverse_a - y * inverse_b, x * inverse_b + y * inverse_a
            re[here + k], im[here + k] = p, q
            for j in range(k + 1, length):
                re[here + j] -= p * re[row + j] - q * im[row + j]
                im[here + j] -= p * im[row + j] + q * re[row + j]
            p, q = re[row + i], im[row + i]
            for j in range(u):
                re[there + j] -= p * re[column + j] - q * im[column + j]
                im[there + j] -= p * im[column + j] + q * re[column + j]
    return -1


@compiled
def _update(sym, re, im, row, column, u, t):
    """Subtract the product of a column of L and a row of U wherever it belongs."""
    for i in range(u):
        p, q, goal = re[column + i], im[column + i], part_of(sym.targets, t + i * u, t + (i + 1) * u)
        for j in range(u):
            a, b = re[row + j], im[row + j]
            re[goal[j]] -= p * a - q * b
            im[goal[j]] -= p * b + q * a


@compiled
def solve_complex(sym, re, im, x, y, pair):
    """Solve with the values that `factor_complex` left; x, y: (n,) right side, then solution; pair: (2 n,) space."""
    into, n = sym.into, len(sym.into)
    p, q = part_of(pair, 0, n), part_of(pair, n, 2 * n)
    for k in range(n):
        p[k], q[k] = x[into[k]], y[into[k]]
    _forward(sym, re, im, p, q)
    _backward(sym, re, im, p, q)
    for k in range(n):
        x[into[k]], y[into[k]] = p[k], q[k]


@compiled
def _forward(sym, re, im, p, q):
    """L^-1 (p + i q)."""
    starts, row_ptr, value_ptr = sym.starts, sym.row_ptr, sym.value_ptr
    for s in range(len(starts) - 1):
        first, at, w, u = starts[s], value_ptr[s], starts[s + 1] - starts[s], row_ptr[s + 1] - row_ptr[s]
        below, length = part_of(sym.rows, row_ptr[s], row_ptr[s + 1]), w + u
        for k in range(w):
            a, b = p[first + k], q[first + k]
            for i in range(k + 1, w):
                x, y = re[at + i * length + k], im[at + i * length + k]
                p[first + i] -= x * a - y * b
                q[first + i] -= x * b + y * a
            left = at + w * length + k * u
            for i in range(u):
                x, y = re[left + i], im[left + i]
                p[below[i]] -= x * a - y * b
                q[below[i]] -= x * b + y * a


@compiled
def _backward(sym, re, im, p, q):
    """U^-1 (p + i q)."""
    starts, row_ptr, value_ptr = sym.starts, sym.row_ptr, sym.value_ptr
    for s in range(len(starts) - 2, -1, -1):
        first, at, w, u = starts[s], value_ptr[s], starts[s + 1] - starts[s], row_ptr[s + 1] - row_ptr[s]
        below, length = part_of(sym.rows, row_ptr[s], row_ptr[s + 1]), w + u
        for k in range(w - 1, -1, -1):
            row = at + k * length
            a, b = p[first + k], q[first + k]
            for j in range(k + 1, w):
                x, y = re[row + j], im[row + j]
                a -= x * p[first + j] - y * q[first + j]
                b -= x * q[first + j] + y * p[first + j]
            for j in range(u):
                x, y = re[row + w + j], im[row + w + j]
                a -= x * p[below[j]] - y * q[below[j]]
                b -= x * q[below[j]] + y * p[below[j]]
            x, y = re[row + k], im[row + k]
            p[first + k], q[first + k] = a * x - b * y, a * y + b * x
