"""Factors U^T D^-1 U of a symmetric A on a fixed pattern, without pivoting; solutions with them.

Half of the work of `lu`: of its layout the rows of U alone are filled and used.  The diagonal of U is kept inverted.
"""

import math

from flexmb.engine.compiled.arrays import matrix_view, part_of
from flexmb.engine.linalg.lu import backward, backward_two
from flexmb.kernels import compiled


@compiled
def factor_symmetric(sym, lu, seen, least):
    """Factor A, whose upper entries in the order of elimination are in lu; whether all pivots are large enough."""
    # sym : LU; lu : (size,); seen : (n,) largest terms summed up to the pivots, filled; a pivot must be more than
    # `least` times that.
    for s in range(len(sym.starts) - 1):
        w, at = sym.starts[s + 1] - sym.starts[s], sym.value_ptr[s]
        for k in range(w):
            seen[sym.starts[s] + k] = abs(lu[at + k * (w + sym.row_ptr[s + 1] - sym.row_ptr[s] + 1)])
    for s in range(len(sym.starts) - 1):
        at, w, u = sym.value_ptr[s], sym.starts[s + 1] - sym.starts[s], sym.row_ptr[s + 1] - sym.row_ptr[s]
        own, below = (
            part_of(seen, sym.starts[s], sym.starts[s + 1]),
            part_of(sym.rows, sym.row_ptr[s], sym.row_ptr[s + 1]),
        )
        targets, length = part_of(sym.targets, sym.target_ptr[s], sym.target_ptr[s + 1]), w + u
        for k in range(w):
            row = part_of(lu, at + k * length, at + (k + 1) * length)
            if not least * own[k] < row[k] < math.inf:  # false for nan, too
                return False
            inverse = 1.0 / row[k]
            row[k] = inverse
            for i in range(k + 1, w):
                left, other = row[i] * inverse, part_of(lu, at + i * length, at + (i + 1) * length)
                own[i] = max(own[i], abs(left * row[i]))
                for j in range(i, length):
                    other[j] -= left * row[j]
        if w == 2:
            _update_2(lu, at, u, seen, below, targets)
        else:
            _update(lu, at, w, u, seen, below, targets)
    return True


@compiled
def _update(lu, at, w, u, seen, below, targets):
    """Subtract the products of a panel from the upper entries below it."""
    length = w + u
    for i in range(u):
        goal, term = part_of(targets, i * u, (i + 1) * u), 0.0
        for k in range(w):
            row = part_of(lu, at + k * length, at + (k + 1) * length)
            left = row[w + i] * row[k]
            term += left * row[w + i]
            for j in range(i, u):
                lu[goal[j]] -= left * row[w + j]
        seen[below[i]] = max(seen[below[i]], abs(term))


@compiled
def _update_2(lu, at, u, seen, below, targets):
    """`_update` for two pivots."""
    a, b = part_of(lu, at + 2, at + 2 + u), part_of(lu, at + 4 + u, at + 4 + 2 * u)
    p, q = lu[at], lu[at + 3 + u]
    for i in range(u):
        x, y, goal = a[i] * p, b[i] * q, part_of(targets, i * u, (i + 1) * u)
        seen[below[i]] = max(seen[below[i]], abs(x * a[i] + y * b[i]))
        for j in range(i, u):
            lu[goal[j]] -= x * a[j] + y * b[j]


@compiled
def solve_symmetric(sym, lu, rhs, x, y):
    """A x = rhs with the factors; sym : LU; rhs, x : (n,), may be one array; y : (n,) workspace."""
    into = sym.into
    for k in range(len(into)):
        y[k] = rhs[into[k]]
    for s in range(len(sym.starts) - 1):
        at, w, u = sym.value_ptr[s], sym.starts[s + 1] - sym.starts[s], sym.row_ptr[s + 1] - sym.row_ptr[s]
        own, below = part_of(y, sym.starts[s], sym.starts[s + 1]), part_of(sym.rows, sym.row_ptr[s], sym.row_ptr[s + 1])
        if w == 2:
            a, b = part_of(lu, at, at + 2 + u), part_of(lu, at + 2 + u, at + 4 + 2 * u)
            p = own[0] * a[0]
            own[1] -= a[1] * p
            q = own[1] * b[1]
            for i in range(u):
                y[below[i]] -= a[2 + i] * p + b[2 + i] * q
            continue
        for k in range(w):
            row = part_of(lu, at + k * (w + u), at + (k + 1) * (w + u))
            known = own[k] * row[k]
            for i in range(k + 1, w):
                own[i] -= row[i] * known
            for i in range(u):
                y[below[i]] -= row[w + i] * known
    backward(sym.starts, sym.row_ptr, sym.rows, sym.value_ptr, lu, y)
    for k in range(len(into)):
        x[into[k]] = y[k]


@compiled
def solve_symmetric_two(sym, lu, b, c, x, z, pair):
    """A x = b and A z = c with the factors; sym : LU; b, c, x, z : (n,); pair : (2 n,) workspace."""
    into = sym.into
    y = matrix_view(pair, len(into), 2)
    for k in range(len(into)):
        y[k, 0], y[k, 1] = b[into[k]], c[into[k]]
    for s in range(len(sym.starts) - 1):
        at, w, u = sym.value_ptr[s], sym.starts[s + 1] - sym.starts[s], sym.row_ptr[s + 1] - sym.row_ptr[s]
        first, below = sym.starts[s], part_of(sym.rows, sym.row_ptr[s], sym.row_ptr[s + 1])
        for k in range(w):
            row = part_of(lu, at + k * (w + u), at + (k + 1) * (w + u))
            p, q = y[first + k, 0] * row[k], y[first + k, 1] * row[k]
            for i in range(k + 1, w):
                y[first + i, 0] -= row[i] * p
                y[first + i, 1] -= row[i] * q
            for i in range(u):
                y[below[i], 0] -= row[w + i] * p
                y[below[i], 1] -= row[w + i] * q
    backward_two(sym.starts, sym.row_ptr, sym.rows, sym.value_ptr, lu, pair)
    for k in range(len(into)):
        x[into[k]], z[into[k]] = y[k, 0], y[k, 1]
