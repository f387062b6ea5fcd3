"""Factors L and U of a complex matrix on the pattern of `lu`, for pairs of stages of implicit Runge-Kutta methods.

Real and imaginary parts lie in two arrays of the layout of `flexmb.engine.linalg.symbolic`.
"""

import math

from flexmb.engine.compiled.arrays import part_of
from flexmb.kernels import compiled


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
