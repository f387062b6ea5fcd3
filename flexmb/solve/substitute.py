"""Solutions with the factors of `lu`: one right-hand side, or two in one pass.

Of two, the second stands beside the first in the workspace, so one value of L or U meets two neighbouring numbers, and
the places of the rows are read once.  Panels of three unknowns, the coordinates of a node, are unrolled.
"""

from flexmb.kernels import compiled


@compiled
def solve(sym, lu, b, x, y):
    """A x = b with the values that `factor` left.  sym : LU; b, x : (n,), may be one array; y : (n,) workspace."""
    order = sym.order
    for k in range(len(order)):
        y[k] = b[order[k]]
    forward(sym.starts, sym.row_ptr, sym.rows, sym.value_ptr, lu, y)
    backward(sym.starts, sym.row_ptr, sym.rows, sym.value_ptr, lu, y)
    for k in range(len(order)):
        x[order[k]] = y[k]


@compiled
def forward(starts, row_ptr, rows, value_ptr, lu, y):
    """Y = L^-1 y."""
    for s in range(len(starts) - 1):
        first, r, at = starts[s], row_ptr[s], value_ptr[s]
        w, u = starts[s + 1] - first, row_ptr[s + 1] - r
        length = w + u
        a = at + w * length
        if w == 3:
            p0 = y[first]
            p1 = y[first + 1] - lu[at + length] * p0
            p2 = y[first + 2] - lu[at + 2 * length] * p0 - lu[at + 2 * length + 1] * p1
            y[first + 1], y[first + 2] = p1, p2
            for i in range(u):
                y[rows[r + i]] -= lu[a + i] * p0 + lu[a + u + i] * p1 + lu[a + 2 * u + i] * p2
            continue
        for k in range(w):
            known = y[first + k]
            for i in range(k + 1, w):
                y[first + i] -= lu[at + i * length + k] * known
            for i in range(u):
                y[rows[r + i]] -= lu[a + k * u + i] * known


@compiled
def backward(starts, row_ptr, rows, value_ptr, lu, y):
    """Y = U^-1 y; the diagonal of U is kept inverted."""
    for s in range(len(starts) - 2, -1, -1):
        first, r, a = starts[s], row_ptr[s], value_ptr[s]
        w, u = starts[s + 1] - first, row_ptr[s + 1] - r
        length = w + u
        if w == 3:
            b, c = a + length, a + 2 * length
            p0, p1, p2 = y[first], y[first + 1], y[first + 2]
            for j in range(u):
                p = y[rows[r + j]]
                p0, p1, p2 = p0 - lu[a + 3 + j] * p, p1 - lu[b + 3 + j] * p, p2 - lu[c + 3 + j] * p
            p2 *= lu[c + 2]
            p1 = (p1 - lu[b + 2] * p2) * lu[b + 1]
            y[first], y[first + 1], y[first + 2] = (p0 - lu[a + 1] * p1 - lu[a + 2] * p2) * lu[a], p1, p2
            continue
        for k in range(w - 1, -1, -1):
            row = a + k * length
            rest = y[first + k]
            for j in range(k + 1, w):
                rest -= lu[row + j] * y[first + j]
            for j in range(u):
                rest -= lu[row + w + j] * y[rows[r + j]]
            y[first + k] = rest * lu[row + k]


@compiled
def solve_two(sym, lu, b, c, x, z, pair):
    """A x = b and A z = c with the values that `factor` left.  sym : LU; b, c, x, z : (n,); pair : (2 n,) workspace."""
    order = sym.order
    for k in range(len(order)):
        pair[2 * k], pair[2 * k + 1] = b[order[k]], c[order[k]]
    forward_two(sym.starts, sym.row_ptr, sym.rows, sym.value_ptr, lu, pair)
    backward_two(sym.starts, sym.row_ptr, sym.rows, sym.value_ptr, lu, pair)
    for k in range(len(order)):
        x[order[k]], z[order[k]] = pair[2 * k], pair[2 * k + 1]


@compiled
def forward_two(starts, row_ptr, rows, value_ptr, lu, y):
    """Y = L^-1 y for two columns."""
    for s in range(len(starts) - 1):
        first, r, at = starts[s], row_ptr[s], value_ptr[s]
        w, u = starts[s + 1] - first, row_ptr[s + 1] - r
        length, f = w + u, 2 * first
        a = at + w * length
        if w == 3:
            p0, q0 = y[f], y[f + 1]
            left = lu[at + length]
            p1, q1 = y[f + 2] - left * p0, y[f + 3] - left * q0
            left, near = lu[at + 2 * length], lu[at + 2 * length + 1]
            p2, q2 = y[f + 4] - left * p0 - near * p1, y[f + 5] - left * q0 - near * q1
            y[f + 2], y[f + 3], y[f + 4], y[f + 5] = p1, q1, p2, q2
            for i in range(u):
                k = 2 * rows[r + i]
                l0, l1, l2 = lu[a + i], lu[a + u + i], lu[a + 2 * u + i]
                y[k] -= l0 * p0 + l1 * p1 + l2 * p2
                y[k + 1] -= l0 * q0 + l1 * q1 + l2 * q2
        elif w == 2:
            p0, q0 = y[f], y[f + 1]
            left = lu[at + length]
            p1, q1 = y[f + 2] - left * p0, y[f + 3] - left * q0
            y[f + 2], y[f + 3] = p1, q1
            for i in range(u):
                k = 2 * rows[r + i]
                l0, l1 = lu[a + i], lu[a + u + i]
                y[k] -= l0 * p0 + l1 * p1
                y[k + 1] -= l0 * q0 + l1 * q1
        else:
            p0, q0 = y[f], y[f + 1]
            for i in range(u):
                k = 2 * rows[r + i]
                y[k] -= lu[a + i] * p0
                y[k + 1] -= lu[a + i] * q0


@compiled
def backward_two(starts, row_ptr, rows, value_ptr, lu, y):
    """Y = U^-1 y for two columns; the diagonal of U is kept inverted."""
    for s in range(len(starts) - 2, -1, -1):
        first, r, a = starts[s], row_ptr[s], value_ptr[s]
        w, u = starts[s + 1] - first, row_ptr[s + 1] - r
        length, f = w + u, 2 * first
        p0, q0 = y[f], y[f + 1]
        if w == 3:
            b, c = a + length, a + 2 * length
            p1, q1, p2, q2 = y[f + 2], y[f + 3], y[f + 4], y[f + 5]
            for j in range(u):
                k = 2 * rows[r + j]
                p, q = y[k], y[k + 1]
                u0, u1, u2 = lu[a + 3 + j], lu[b + 3 + j], lu[c + 3 + j]
                p0, p1, p2 = p0 - u0 * p, p1 - u1 * p, p2 - u2 * p
                q0, q1, q2 = q0 - u0 * q, q1 - u1 * q, q2 - u2 * q
            p2, q2 = p2 * lu[c + 2], q2 * lu[c + 2]
            p1, q1 = (p1 - lu[b + 2] * p2) * lu[b + 1], (q1 - lu[b + 2] * q2) * lu[b + 1]
            p0, q0 = p0 - lu[a + 1] * p1 - lu[a + 2] * p2, q0 - lu[a + 1] * q1 - lu[a + 2] * q2
            y[f + 2], y[f + 3], y[f + 4], y[f + 5] = p1, q1, p2, q2
        elif w == 2:
            b = a + length
            p1, q1 = y[f + 2], y[f + 3]
            for j in range(u):
                k = 2 * rows[r + j]
                p, q = y[k], y[k + 1]
                u0, u1 = lu[a + 2 + j], lu[b + 2 + j]
                p0, p1, q0, q1 = p0 - u0 * p, p1 - u1 * p, q0 - u0 * q, q1 - u1 * q
            p1, q1 = p1 * lu[b + 1], q1 * lu[b + 1]
            p0, q0 = p0 - lu[a + 1] * p1, q0 - lu[a + 1] * q1
            y[f + 2], y[f + 3] = p1, q1
        else:
            for j in range(u):
                k = 2 * rows[r + j]
                p0, q0 = p0 - lu[a + 1 + j] * y[k], q0 - lu[a + 1 + j] * y[k + 1]
        y[f], y[f + 1] = p0 * lu[a], q0 * lu[a]
