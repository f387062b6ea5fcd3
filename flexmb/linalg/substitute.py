"""Solution with the factors of `lu`, for one right-hand side or for two in one pass.

Of two, the second stands beside the first in the workspace, so one value of L or U meets two neighbouring numbers, and
the places of the rows are read once.  Panels of three unknowns, the coordinates of a node, are unrolled.

Parts of arrays are taken by `part_of`: an index that is known to begin at 0 needs no look whether it counts from the
end, which took a third of the time.
"""

from flexmb.compiled.views import matrix_view, part_of
from flexmb.kernels import compiled


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
            continue
        for k in range(w):
            known = own[k]
            for i in range(k + 1, w):
                own[i] -= lu[at + i * length + k] * known
            left = part_of(lu, a + k * u, a + k * u + u)
            for i in range(u):
                y[below[i]] -= left[i] * known


@compiled
def backward(starts, row_ptr, rows, value_ptr, lu, y):
    """Y = U^-1 y; the diagonal of U is kept inverted."""
    for s in range(len(starts) - 2, -1, -1):
        at, w, u = value_ptr[s], starts[s + 1] - starts[s], row_ptr[s + 1] - row_ptr[s]
        own, below, length = part_of(y, starts[s], starts[s + 1]), part_of(rows, row_ptr[s], row_ptr[s + 1]), w + u
        if w == 3:
            a, b, c = (
                part_of(lu, at, at + length),
                part_of(lu, at + length, at + 2 * length),
                part_of(lu, at + 2 * length, at + 3 * length),
            )
            p0, p1, p2 = own[0], own[1], own[2]
            for j in range(u):
                p = y[below[j]]
                p0, p1, p2 = p0 - a[3 + j] * p, p1 - b[3 + j] * p, p2 - c[3 + j] * p
            p2 *= c[2]
            p1 = (p1 - b[2] * p2) * b[1]
            own[0], own[1], own[2] = (p0 - a[1] * p1 - a[2] * p2) * a[0], p1, p2
            continue
        for k in range(w - 1, -1, -1):
            row = part_of(lu, at + k * length, at + (k + 1) * length)
            rest = own[k]
            for j in range(k + 1, w):
                rest -= row[j] * own[j]
            right = part_of(row, w, length)
            for j in range(u):
                rest -= right[j] * y[below[j]]
            own[k] = rest * row[k]


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
        own, below, length = (
            part_of(pair, 2 * starts[s], 2 * starts[s + 1]),
            part_of(rows, row_ptr[s], row_ptr[s + 1]),
            w + u,
        )
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
        own, below, length = (
            part_of(pair, 2 * starts[s], 2 * starts[s + 1]),
            part_of(rows, row_ptr[s], row_ptr[s + 1]),
            w + u,
        )
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
