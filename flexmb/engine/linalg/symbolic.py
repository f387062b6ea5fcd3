"""Symbolic factorisation: fill, panels, positions of all entries of L and U.

Source: T. A. Davis, Direct Methods for Sparse Linear Systems, SIAM 2006, sections 4.1 (elimination tree) and 4.8
(supernodes); the walk up the tree from every entry of a row is that of T. A. Davis, Algorithm 849: A concise sparse
Cholesky factorization package, ACM Transactions on Mathematical Software 31 (2005) 587-591.
"""

import math
import os
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

import numpy as np

from flexmb.errors import InputError, SolveError
from flexmb.kernels import compiled


# Compiled loops of the symbolic factorisation: fill, panels, and where an entry lives; linear in the entries of L
@compiled
def count_below(row_ptr, columns, parent, count, mark):
    """Parent of each place in the elimination tree (-1: a root) and number of places below it with the fill."""
    # columns[row_ptr[i] : row_ptr[i + 1]] : places before i that A couples to it; parent, count, mark : (n,), filled.
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
    """Join neighbouring panels of `starts` (count + 1 bounds) in place; the number of panels that are left."""
    # Two are joined if the first is the child of the second in the tree, the result is at most `widest` places wide,
    # and the part of stored zeros in L is at most `waste`.
    last = 0  # panels that are finished
    for s in range(1, count):
        first, start, end = starts[last], starts[s], starts[s + 1]
        width = end - first
        stored = width * (ptr[end] - ptr[end - 1]) + width * (width - 1) // 2
        if not (parent[start - 1] == start and width <= widest and stored - (ptr[end] - ptr[first]) <= waste * stored):
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
def locate_targets(starts, row_ptr, rows, value_ptr, panel, targets):
    """Position of every entry that the product of a panel's L and U is subtracted from, row by row."""
    # An entry and its mirror image live in the panel p of the lower place, among whose rows are all higher ones of s.
    at = 0
    for s in range(len(starts) - 1):
        below = rows[row_ptr[s] : row_ptr[s + 1]]
        u = len(below)
        for i in range(u):
            p = panel[below[i]]
            first, m, corner = starts[p], row_ptr[p], value_ptr[p]
            width, k = starts[p + 1] - first, below[i] - first
            length = width + row_ptr[p + 1] - m
            for j in range(i, u):
                column = below[j] - first
                if column >= width:
                    while rows[m] < below[j]:
                        m += 1
                    column = width + m - row_ptr[p]
                left = column * length + k if column < width else width * length + k * (length - width) + column - width
                targets[at + i * u + j], targets[at + j * u + i] = corner + k * length + column, corner + left
        at += u * u


WIDEST_PANEL = 3  # number of unknowns in a panel at most: the coordinates of a node, with unrolled loops in `factor`
# Share of zeros in a panel, up to which joined panels are faster than separate ones (tests/speed/lu_time.py).
PANEL_ZEROS = 0.2
LARGEST_SHARE = 0.7  # share of the memory for positions of updates; all else takes some .4 of them


@dataclass(frozen=True, eq=False)
class Symbolic:
    """Pattern of A, L and U in panels: runs of up to three unknowns with a common structure."""

    # Panel s eliminates the places ``starts[s] .. starts[s+1]`` of the order, w of them; below it stand the u places
    # ``rows[row_ptr[s] : row_ptr[s+1]]``. Its values begin at ``value_ptr[s]``: w rows of U, each w + u long, then the
    # transposed panel of L, w rows of length u. One dummy slot follows the last value: it swallows the contributions of
    # fixed coordinates. All arrays are int64.
    n: int  # number of unknowns
    order: np.ndarray  # (n,) unknown at each place
    starts: np.ndarray  # (n_panels + 1,) first place of each panel
    row_ptr: np.ndarray  # (n_panels + 1,) where its rows begin in `rows`
    rows: np.ndarray  # places below each panel, ascending
    value_ptr: np.ndarray  # (n_panels + 1,) where its values begin
    target_ptr: np.ndarray  # (n_panels + 1,) where its updates begin in `targets`
    a_rows: np.ndarray  # structural nonzeros of A, numbers of unknowns, column by column
    a_cols: np.ndarray
    _place: np.ndarray = field(init=False, repr=False)
    _panel: np.ndarray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        place = np.empty(self.n, dtype=np.int64)
        place[self.order] = np.arange(self.n)
        object.__setattr__(self, "_place", place)
        object.__setattr__(self, "_panel", np.repeat(np.arange(len(self.starts) - 1), np.diff(self.starts)))
        for entry in fields(self):
            value = getattr(self, entry.name)
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    def __reduce__(self) -> tuple[Any, ...]:
        # Through the constructor, because numpy forgets on the way that an array is read-only.
        return Symbolic, tuple(getattr(self, entry.name) for entry in fields(self) if entry.init)

    @property
    def size(self) -> int:
        """Length of the array of values, the dummy slot included."""
        return int(self.value_ptr[-1]) + 1

    @property
    def dummy(self) -> int:
        """Position of the slot that nothing reads."""
        return int(self.value_ptr[-1])

    @cached_property
    def targets(self) -> np.ndarray:
        """Value that each entry (i, j) of the product of a panel's L and U is subtracted from, row by row, uint32."""
        # The largest array by far, found when a caller factors without pivoting: statics and modes do without it. A
        # system that promises more memory than it has would end the process without a word.
        need = 4e-9 * float(self.target_ptr[-1])  # [GB]
        told = "SC_PHYS_PAGES" in getattr(os, "sysconf_names", ())
        most = 1e-9 * os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") if told else math.inf
        if need > LARGEST_SHARE * most:
            text = f"The factors of {self.n:,} unknowns take {need:.3g} GB of memory in the time loop, this machine has"
            raise SolveError(f"{text} {most:.3g} GB. Take fewer parts or a reduced body; statics and modes need less.")
        found = np.empty(self.target_ptr[-1], dtype=np.uint32)
        locate_targets(self.starts, self.row_ptr, self.rows, self.value_ptr, self._panel, found)
        found.setflags(write=False)
        return found

    @cached_property
    def places(self) -> np.ndarray:
        """Positions of the structural nonzeros, in the order of `a_rows` and `a_cols`; read-only."""
        found = self.positions(self.a_rows, self.a_cols)
        found.setflags(write=False)
        return found

    def positions(self, rows: np.ndarray, cols: np.ndarray) -> np.ndarray:
        """Positions of the entries (row, col) of A in the array of values, in the shape of `rows` and `cols`."""
        # Where one of the two is negative (a fixed coordinate) the dummy slot is meant. An entry outside the pattern,
        # or an unknown that is not there, is refused.
        i, j = np.broadcast_arrays(np.asarray(rows, dtype=np.int64), np.asarray(cols, dtype=np.int64))
        _check_range("Symbolic.positions", self.n, i, j)
        result = np.full(i.shape, self.dummy, dtype=np.int64)
        free = (i >= 0) & (j >= 0)
        at = np.empty(free.sum(), dtype=np.int64)
        places = self._place[i[free]], self._place[j[free]]
        locate_all(self.starts, self.row_ptr, self.rows, self.value_ptr, self._panel, *places, at)
        if at.size and at.min() < 0:
            k = int(np.argmin(at))
            text = f"Symbolic.positions: entry ({i[free][k]}, {j[free][k]}) is not in the pattern;"
            raise InputError(f"{text} give it to symbolic() among rows and cols.")
        result[free] = at
        return result


def symbolic(n: int, rows: np.ndarray, cols: np.ndarray, order: np.ndarray) -> Symbolic:
    """Pattern of the factors of A with n unknowns, and where each update goes.

    `rows` and `cols` are structural nonzeros of A, in any order and as often as you like.  Transposed and diagonal
    entries are added, pairs with a negative number (fixed coordinates) left out.  `order` (n,) is from
    `elimination_order`.  The cost is linear in the number of entries of L and U, apart from sorting.
    Sources: see `flexmb.engine.linalg.symbolic`.  An arrow, its tip eliminated last, does not fill:

    >>> arrow = symbolic(3, [0, 1, 2, 2], [2, 2, 0, 1], [0, 1, 2])
    >>> arrow.positions([0, 2, -1], [2, 0, 1]).tolist()
    [1, 2, 7]
    """
    owner, order = "symbolic", np.asarray(order, dtype=np.int64)
    if order.shape != (n,) or not np.array_equal(np.sort(order), np.arange(n)):
        raise InputError(f"{owner}: order is no permutation of 0 .. {n - 1}; take it from elimination_order.")
    a_rows, a_cols = _pattern(owner, n, rows, cols)
    place = np.empty(n, dtype=np.int64)
    place[order] = np.arange(n)
    parent, ptr, below = _fill(n, place[a_rows], place[a_cols])
    # Panels: equal structures first, then neighbours that cost few zeros.
    starts, count = np.arange(n + 1), n
    for waste in (0.0, PANEL_ZEROS) if n else ():
        count = join_panels(parent, ptr, WIDEST_PANEL, waste, starts, count)
    starts = starts[: count + 1].copy()
    u, w = np.diff(ptr)[starts[1:] - 1], np.diff(starts)
    row_ptr = _running(u)
    rows_below = below[np.arange(row_ptr[-1]) + np.repeat(ptr[starts[1:] - 1] - row_ptr[:-1], u)]
    value_ptr, target_ptr = _running(w * (w + 2 * u)), _running(u * u)
    return Symbolic(n, order.copy(), starts, row_ptr, rows_below, value_ptr, target_ptr, a_rows, a_cols)


def _check_range(owner: str, n: int, *numbers: np.ndarray) -> None:
    for array in numbers:
        if array.size and array.max() >= n:
            raise InputError(f"{owner}: unknown {array.max()} is not there; unknowns are 0 .. {n - 1}.")


def _pattern(owner: str, n: int, rows: np.ndarray, cols: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Structural nonzeros with their mirror images and the diagonal, each once, column by column."""
    i, j = np.asarray(rows, dtype=np.int64).ravel(), np.asarray(cols, dtype=np.int64).ravel()
    if i.shape != j.shape:
        raise InputError(f"{owner}: {len(i)} rows and {len(j)} cols; give one column for each row.")
    _check_range(owner, n, i, j)
    free = (i >= 0) & (j >= 0)
    i, j, diagonal = i[free], j[free], np.arange(n)
    keys = np.concatenate([i + n * j, j + n * i, diagonal + n * diagonal])
    keys.sort()
    keys = keys[np.diff(keys, prepend=-1) > 0]
    cols = keys // max(n, 1)
    return keys - n * cols, cols


def _fill(n: int, rows: np.ndarray, cols: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Parents in the elimination tree, and the places below each pivot once the fill is there, with offsets."""
    keys = (rows * n + cols)[rows > cols]
    keys.sort()
    rows = keys // max(n, 1)
    columns, row_ptr = keys - n * rows, _running(np.bincount(rows, minlength=n))
    parent, count, mark = (np.empty(n, dtype=np.int64) for _ in range(3))
    count_below(row_ptr, columns, parent, count, mark)
    ptr = _running(count)
    below = np.empty(ptr[-1], dtype=np.int64)
    list_below(row_ptr, columns, parent, ptr, below, count, mark)
    return parent, ptr, below


def _running(lengths: np.ndarray) -> np.ndarray:
    """Offsets of consecutive parts of given lengths, with the end of the last one."""
    return np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
