"""Where every entry of the factors L and U lives, worked out once for a pattern of A."""

from dataclasses import dataclass, field, fields
from functools import cached_property
from itertools import pairwise

import numpy as np

from flexmb.errors import InputError

WIDEST = 3
"""Most unknowns in one panel: the coordinates of a node, for which the numeric kernel has unrolled loops."""

WASTE = 0.2
"""Part of zeros in a panel up to which joining two is faster than keeping them apart (tests/speed/lu_time.py)."""

CHUNK = 1024
"""Panels whose targets are looked up at once: bounds the memory of the temporary arrays."""


@dataclass(frozen=True, eq=False)
class Symbolic:
    """Pattern of A, L and U in panels: runs of up to three unknowns with a common structure.

    Panel s eliminates the places ``starts[s] .. starts[s+1]`` of the order, w of them; below it stand the u places
    ``rows[row_ptr[s] : row_ptr[s+1]]``.  Its values begin at ``value_ptr[s]``: w rows of U, each w + u long, then the
    transposed panel of L, w rows of length u.  One dummy slot follows the last value: it swallows the contributions
    of fixed coordinates.

    Parameters
    ----------
    n : int
        Number of unknowns.
    order : (n,) int64 array
        Unknown at each place.
    starts : (n_panels + 1,) int64 array
        First place of each panel.
    row_ptr : (n_panels + 1,) int64 array
        Where its rows begin in `rows`.
    rows : int64 array
        Places below each panel, ascending.
    value_ptr : (n_panels + 1,) int64 array
        Where its values begin.
    target_ptr : (n_panels + 1,) int64 array
        Where its updates begin in `targets`.
    targets : uint32 array
        Value that each entry (i, j) of the product of a panel's L and U is subtracted from, row by row.
    a_rows, a_cols : int64 arrays
        Structural nonzeros of A, numbers of unknowns, column by column.
    """

    n: int
    order: np.ndarray
    starts: np.ndarray
    row_ptr: np.ndarray
    rows: np.ndarray
    value_ptr: np.ndarray
    target_ptr: np.ndarray
    targets: np.ndarray
    a_rows: np.ndarray
    a_cols: np.ndarray
    _place: np.ndarray = field(init=False, repr=False)
    _panel: np.ndarray = field(init=False, repr=False)
    _keys: np.ndarray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        place = np.empty(self.n, dtype=np.int64)
        place[self.order] = np.arange(self.n)
        panel = np.repeat(np.arange(len(self.starts) - 1), np.diff(self.starts))
        owner = np.repeat(np.arange(len(self.starts) - 1), np.diff(self.row_ptr))
        object.__setattr__(self, "_place", place)
        object.__setattr__(self, "_panel", panel)
        object.__setattr__(self, "_keys", owner * self.n + self.rows)
        for entry in fields(self):
            value = getattr(self, entry.name)
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    def __reduce__(self) -> tuple:
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
    def places(self) -> np.ndarray:
        """Positions of the structural nonzeros, in the order of `a_rows` and `a_cols`; read-only."""
        found = self.positions(self.a_rows, self.a_cols)
        found.setflags(write=False)
        return found

    def positions(self, rows: np.ndarray, cols: np.ndarray) -> np.ndarray:
        """Where the entries (row, col) of A stand in the array of values.

        Parameters
        ----------
        rows, cols : int arrays of one shape
            Numbers of unknowns; where one of the two is negative (a fixed coordinate) the dummy slot is meant.

        Returns
        -------
        int64 array
            Positions, in the shape of `rows`.

        Raises
        ------
        InputError
            An entry outside the pattern, or an unknown that is not there.
        """
        i, j = np.broadcast_arrays(np.asarray(rows, dtype=np.int64), np.asarray(cols, dtype=np.int64))
        _check_range("Symbolic.positions", self.n, i, j)
        result = np.full(i.shape, self.dummy, dtype=np.int64)
        free = (i >= 0) & (j >= 0)
        at = self._at(self._place[i[free]], self._place[j[free]])
        if at.size and at.min() < 0:
            k = int(np.argmin(at))
            raise InputError(
                f"Symbolic.positions: entry ({i[free][k]}, {j[free][k]}) is not in the pattern; "
                "give it to symbolic() among rows and cols."
            )
        result[free] = at
        return result

    def _at(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Positions of the entries at places (i, j), -1 outside the pattern."""
        low, high = np.minimum(i, j), np.maximum(i, j)
        s = self._panel[low]
        width, below = self.starts[s + 1] - self.starts[s], self.row_ptr[s + 1] - self.row_ptr[s]
        inside = high < self.starts[s + 1]
        key = s * self.n + high
        found = np.minimum(np.searchsorted(self._keys, key), max(len(self._keys) - 1, 0))
        known = inside | ((self._keys[found] == key) if len(self._keys) else False)
        k = low - self.starts[s]  # row of U, or of transposed L, within the panel
        m = found - self.row_ptr[s]
        length = width + below
        upper = self.value_ptr[s] + k * length + width + m
        lower = self.value_ptr[s] + width * length + k * below + m
        square = self.value_ptr[s] + (i - self.starts[s]) * length + (j - self.starts[s])
        return np.where(known, np.where(inside, square, np.where(i < j, upper, lower)), -1)


def symbolic(n: int, rows: np.ndarray, cols: np.ndarray, order: np.ndarray) -> Symbolic:
    """Pattern of the factors of A, and where each update goes.

    Parameters
    ----------
    n : int
        Number of unknowns.
    rows, cols : int arrays of one shape
        Structural nonzeros of A, in any order and as often as you like.  Transposed and diagonal entries are added,
        pairs with a negative number (fixed coordinates) left out.
    order : (n,) int array
        Unknowns in the order of their elimination, from `elimination_order`.

    Returns
    -------
    Symbolic
        Its cost is linear in the number of entries of L and U, apart from sorting.

    Raises
    ------
    InputError
        `order` is no permutation, or an entry lies outside A.

    Notes
    -----
    Source: T. A. Davis, Direct Methods for Sparse Linear Systems, SIAM 2006, sections 4.1 (elimination tree) and 4.8
    (supernodes).

    Examples
    --------
    An arrow, its tip eliminated last, does not fill:

    >>> arrow = symbolic(3, [0, 1, 2, 2], [2, 2, 0, 1], [0, 1, 2])
    >>> arrow.positions([0, 2, -1], [2, 0, 1]).tolist()
    [1, 2, 7]
    """
    owner = "symbolic"
    order = np.asarray(order, dtype=np.int64)
    if order.shape != (n,) or not np.array_equal(np.sort(order), np.arange(n)):
        raise InputError(f"{owner}: order is no permutation of 0 .. {n - 1}; take it from elimination_order.")
    a_rows, a_cols = _pattern(owner, n, rows, cols)
    place = np.empty(n, dtype=np.int64)
    place[order] = np.arange(n)
    structures = _fill(n, place[a_rows], place[a_cols])
    starts = _panels(structures)
    below = [sorted(structures[end - 1]) for end in starts[1:]]
    u = np.array([len(places) for places in below], dtype=np.int64)
    w = np.diff(np.array(starts, dtype=np.int64))
    parts = {
        "n": n,
        "order": order.copy(),
        "starts": np.array(starts, dtype=np.int64),
        "row_ptr": _running(u),
        "rows": np.array([place for places in below for place in places], dtype=np.int64),
        "value_ptr": _running(w * (w + 2 * u)),
        "target_ptr": _running(u * u),
        "a_rows": a_rows,
        "a_cols": a_cols,
    }
    return Symbolic(targets=_targets(Symbolic(targets=np.empty(0, dtype=np.uint32), **parts)), **parts)


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
    keys = np.unique(np.concatenate([i + n * j, j + n * i, diagonal + n * diagonal]))
    return keys % n, keys // n


def _fill(n: int, rows: np.ndarray, cols: np.ndarray) -> list[set[int]]:
    """Places below each pivot once the fill is there: its own and those its children in the tree hand up."""
    structures: list[set[int]] = [set() for _ in range(n)]
    for i, j in zip(rows.tolist(), cols.tolist(), strict=True):
        if i > j:
            structures[j].add(i)
    for structure in structures:
        if structure:
            parent = min(structure)
            structures[parent] |= structure
            structures[parent].discard(parent)
    return structures


def _panels(structures: list[set[int]]) -> list[int]:
    """First places of the panels, and n: equal structures first, then neighbours that cost few zeros."""
    starts = _merged(structures, list(range(len(structures) + 1)), 0.0)
    return _merged(structures, starts, WASTE)


def _merged(structures: list[set[int]], starts: list[int], waste: float) -> list[int]:
    """Panels joined while they stay narrow and the part of stored zeros in L stays below `waste`."""
    result = starts[:1]
    for start, end in pairwise(starts[1:]):
        first = result[-1]
        stored = (end - first) * len(structures[end - 1]) + (end - first) * (end - first - 1) // 2
        needed = sum(len(structures[k]) for k in range(first, end))
        child = start in structures[start - 1] if start < end else False
        if not (child and end - first <= WIDEST and stored - needed <= waste * stored):
            result.append(start)
    return [*result, len(structures)] if structures else [0]


def _running(lengths: np.ndarray) -> np.ndarray:
    """Where each of the consecutive parts begins, and where the last one ends."""
    return np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)


def _targets(bare: Symbolic) -> np.ndarray:
    """Position of every entry that the product of a panel's L and U is subtracted from."""
    result = np.empty(bare.target_ptr[-1], dtype=np.uint32)
    u = np.diff(bare.row_ptr)
    for low in range(0, len(u), CHUNK):
        ptr = bare.target_ptr[low : low + CHUNK + 1]
        s = np.repeat(np.arange(low, low + len(ptr) - 1), np.diff(ptr))
        entry = np.arange(ptr[0], ptr[-1]) - bare.target_ptr[s]
        i, j = bare.row_ptr[s] + entry // u[s], bare.row_ptr[s] + entry % u[s]
        result[ptr[0] : ptr[-1]] = bare._at(bare.rows[i], bare.rows[j])
    return result
