"""Compiled loops of the symbolic factorisation: fill, panels, and where an entry lives; linear in the entries of L.

Source: T. A. Davis, Direct Methods for Sparse Linear Systems, SIAM 2006, sections 4.1 (elimination tree) and 4.8
(supernodes); the walk up the tree from every entry of a row is that of T. A. Davis, Algorithm 849: A concise sparse
Cholesky factorization package, ACM Transactions on Mathematical Software 31 (2005) 587-591.
"""

from flexmb.kernels import compiled


@compiled
def count_below(row_ptr, columns, parent, count, mark):
    """Parent of each place in the elimination tree (-1: a root) and number of places below it once the fill is there.

    columns[row_ptr[i] : row_ptr[i + 1]] : places before i that A couples to it; parent, count, mark : (n,), filled.
    """
    for i in range(len(row_ptr) - 1):
        parent[i], count[i], mark[i] = -1, 0, i
        for at in range(row_ptr[i], row_ptr[i + 1]):
            k = columns[at]
            while mark[k] != i:
                if parent[k] < 0:
                    parent[k] = i
                count[k] += 1
                mark[k] = i
                k = parent[k]


@compiled
def list_below(row_ptr, columns, parent, ptr, below, end, mark):
    """The places below each, ascending: below[ptr[k] : ptr[k + 1]].  end, mark : (n,), workspace."""
    for i in range(len(row_ptr) - 1):
        end[i], mark[i] = ptr[i], i
        for at in range(row_ptr[i], row_ptr[i + 1]):
            k = columns[at]
            while mark[k] != i:
                below[end[k]] = i
                end[k] += 1
                mark[k] = i
                k = parent[k]


@compiled
def join_panels(parent, ptr, widest, waste, starts, count):
    """Join neighbouring panels of `starts` (count + 1 bounds) in place; the number of panels that are left.

    Two are joined if the first is the child of the second in the tree, the result is at most `widest` places wide, and
    the part of stored zeros in L is at most `waste`.
    """
    last = 0  # panels that are finished
    for s in range(1, count):
        first, start, end = starts[last], starts[s], starts[s + 1]
        width = end - first
        stored = width * (ptr[end] - ptr[end - 1]) + width * (width - 1) // 2
        needed = ptr[end] - ptr[first]
        if not (parent[start - 1] == start and width <= widest and stored - needed <= waste * stored):
            last += 1
            starts[last] = start
    starts[last + 1] = starts[count]
    return last + 1


@compiled
def locate(starts, row_ptr, rows, value_ptr, panel, i, j):
    """Position of the entry at places (i, j) in the array of values, -1 outside the pattern (see `Symbolic`)."""
    low, high = min(i, j), max(i, j)
    s = panel[low]
    width, begin = starts[s + 1] - starts[s], row_ptr[s]
    length = width + row_ptr[s + 1] - begin
    if high < starts[s + 1]:
        return value_ptr[s] + (i - starts[s]) * length + (j - starts[s])
    first, beyond = begin, row_ptr[s + 1]
    while first < beyond:
        middle = (first + beyond) // 2
        if rows[middle] < high:
            first = middle + 1
        else:
            beyond = middle
    if first == row_ptr[s + 1] or rows[first] != high:
        return -1
    k, m = low - starts[s], first - begin
    if i < j:
        return value_ptr[s] + k * length + width + m
    return value_ptr[s] + width * length + k * (length - width) + m


@compiled
def locate_all(starts, row_ptr, rows, value_ptr, panel, i, j, found):
    """`locate` for entries (m,)."""
    for k in range(len(i)):
        found[k] = locate(starts, row_ptr, rows, value_ptr, panel, i[k], j[k])


@compiled
def locate_targets(starts, row_ptr, rows, value_ptr, panel, reached, targets):
    """Position of every entry that the product of a panel's L and U is subtracted from, row by row.

    The rows below a panel are among those below the panel of each of them, both ascending; `reached` (n,) is work: how
    far each was read.
    """
    at = 0
    for s in range(len(starts) - 1):
        first, u = row_ptr[s], row_ptr[s + 1] - row_ptr[s]
        for j in range(u):
            reached[j] = row_ptr[panel[rows[first + j]]]
        for i in range(u):
            place = rows[first + i]
            p = panel[place]
            start, beyond, begin = starts[p], starts[p + 1], row_ptr[p]
            width, k = beyond - start, place - start
            row = value_ptr[p] + k * (width + row_ptr[p + 1] - begin)
            for j in range(i):
                low = rows[first + j]
                t = panel[low]
                w, begins = starts[t + 1] - starts[t], row_ptr[t]
                below = row_ptr[t + 1] - begins
                if place < starts[t + 1]:
                    targets[at + j] = value_ptr[t] + (place - starts[t]) * (w + below) + low - starts[t]
                else:
                    q = reached[j]
                    while rows[q] < place:
                        q += 1
                    reached[j] = q
                    targets[at + j] = value_ptr[t] + w * (w + below) + (low - starts[t]) * below + q - begins
            q = begin
            for j in range(i, u):
                high = rows[first + j]
                if high < beyond:
                    targets[at + j] = row + high - start
                else:
                    while rows[q] < high:
                        q += 1
                    targets[at + j] = row + width + q - begin
            at += u
