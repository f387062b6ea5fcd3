"""Recurrence of states: fraction of close pairs, and lines of the recurrence matrix."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.errors import InputError
from flexmb.series.embedding import LEAST, Embedding, embed, embedding
from flexmb.series.samples import is_constant, samples, standardised

BLOCK = 2_000_000
"""Largest number of distances in memory."""


@dataclass(frozen=True, eq=False)
class Recurrence:
    """Recurrence quantification of a signal.

    Parameters
    ----------
    rate : fraction of the pairs of states that are nearer than the threshold.
    determinism : fraction of the recurrences on diagonal lines of at least `shortest`: states that stay near each
        other.
    laminarity : fraction of the recurrences on vertical lines of at least `shortest`: states that stay near one state.
    mean_diagonal, longest_diagonal : lengths of diagonal lines [samples].
    entropy : entropy of the distribution of the lengths of diagonal lines [nat].
    trapping_time, longest_vertical : mean and largest length of vertical lines [samples].
    threshold : distance below which a state recurs, in standard deviations of the signal.
    theiler : smallest distance in time of a pair [samples].
    embedding : delay and dimension of the states.
    ok : whether there are recurrences.
    status : result in a sentence.
    diagonals, verticals : number of lines of length 0, 1, 2, ... [samples].
    states : the states (n, m), in standard deviations.
    """

    rate: float
    determinism: float
    laminarity: float
    mean_diagonal: float
    longest_diagonal: int
    entropy: float
    trapping_time: float
    longest_vertical: int
    threshold: float
    theiler: int
    embedding: Embedding | None = field(repr=False)
    ok: bool
    status: str
    diagonals: np.ndarray = field(repr=False)
    verticals: np.ndarray = field(repr=False)
    states: np.ndarray = field(repr=False)

    def matrix(self, first: int = 0, count: int = 1000) -> np.ndarray:
        """Recurrence matrix (k, k) of successive states, bool.

        Parameters
        ----------
        first : number of the first state.
        count : number of states; fewer at the end of the record.
        """
        from scipy.spatial.distance import cdist

        states = self.states[checks.count("matrix", "first", first, 0) :][: checks.count("matrix", "count", count)]
        return np.asarray(cdist(states, states, "chebyshev") < self.threshold)


def recurrence(
    signal: Any,
    *,
    threshold: float | None = None,
    delay: int | None = None,
    dimension: int | None = None,
    theiler: int | None = None,
    shortest: int = 2,
) -> Recurrence:
    """Recurrence quantification of a signal: rate of recurrence, and statistics of the lines of the recurrence matrix.

    The longest diagonal is as long as the record for periodic and quasi-periodic signals, and short for chaos.
    Determinism is near 1 for all smooth flows.  It distinguishes maps from noise only in one dimension, because
    overlapping vectors of noise form short lines, too (0.8 in five dimensions).  The whole matrix is never in memory;
    `Recurrence.matrix` returns a block of it.

    Parameters
    ----------
    signal : samples (n,), at least 100, evenly spaced.
    threshold : distance below which a state recurs, in standard deviations of the signal; the distance of two vectors
        is the largest difference of their entries.  None: the distance that is larger than 5 % of the pairs.
    delay : delay of the embedding [samples]; None: from `embedding`.
    dimension : dimension of the embedding; None: from `embedding`.
    theiler : smallest distance in time of a pair [samples]; None: the window of a vector, at least 1.
    shortest : smallest length of a line [samples].

    Raises
    ------
    InputError : a signal that is too short or not finite, a threshold that is not positive.

    Notes
    -----
    Source: N. Marwan, M. C. Romano, M. Thiel and J. Kurths, Phys. Rep. 438 (2007) 237, sections 3.2 and 3.5.
    Cost: 2 s for 1e4 samples (growing with their square), some 50 MB.
    """
    owner = "recurrence"
    x, shortest = samples(owner, signal, LEAST), checks.count(owner, "shortest", shortest, 2)
    if threshold is not None:
        threshold = checks.positive(owner, "threshold", threshold)
    if is_constant(x):
        return _counted(None, np.zeros((0, 1)), 0.0, 0, shortest)
    embedded = embedding(x, delay=delay, dimension=dimension)
    w = max(1, embedded.window) if theiler is None else checks.count(owner, "theiler", theiler, 0)
    states = embed(standardised(x), embedded.delay, embedded.dimension)
    if len(states) < w + LEAST // 2:
        raise InputError(f"{owner}: {len(states)} vectors with a Theiler window of {w} are too few.")
    return _counted(embedded, states, _quantile(states, w, 0.05) if threshold is None else threshold, w, shortest)


def _counted(embedded: Embedding | None, states: np.ndarray, threshold: float, w: int, shortest: int) -> Recurrence:
    """The record of the recurrences of states (n, m)."""
    diagonals, verticals = _diagonals(states, threshold, w), _verticals(states, threshold, w)
    n = len(states)
    length = np.arange(n + 1)
    total, pairs = int(diagonals @ length), max((n - w) * (n - w - 1) // 2, 1)
    long_diagonals, long_verticals = (
        np.where(length >= shortest, diagonals, 0),
        np.where(length >= shortest, verticals, 0),
    )
    fractions = long_diagonals[long_diagonals > 0] / max(long_diagonals.sum(), 1)
    text = f"{total} recurrences among {pairs} pairs nearer than {threshold:.3g} standard deviations."
    if embedded is None:
        text = "The signal is constant: every state recurs."
    return Recurrence(
        rate=total / pairs if total else np.nan,
        determinism=_ratio(long_diagonals @ length, total),
        laminarity=_ratio(long_verticals @ length, verticals @ length),
        mean_diagonal=_ratio(long_diagonals @ length, long_diagonals.sum()),
        longest_diagonal=int(np.flatnonzero(diagonals)[-1]) if total else 0,
        entropy=float(-(fractions * np.log(fractions)).sum()) if len(fractions) else np.nan,
        trapping_time=_ratio(long_verticals @ length, long_verticals.sum()),
        longest_vertical=int(np.flatnonzero(verticals)[-1]) if verticals.any() else 0,
        threshold=threshold,
        theiler=w,
        embedding=embedded,
        ok=total > 0,
        status=text,
        diagonals=diagonals,
        verticals=verticals,
        states=states,
    )


def _ratio(value: Any, whole: Any) -> float:
    """Quotient of two counts; NaN for 0/0."""
    return float(value / whole) if whole else float("nan")


def _quantile(states: np.ndarray, theiler: int, fraction: float) -> float:
    """Distance below which a fraction of the pairs of states (n, m) lies, at least 1e-6."""
    rng = np.random.default_rng(3)
    i, j = rng.integers(0, len(states), 50000), rng.integers(0, len(states), 50000)
    separated = np.abs(i - j) > theiler
    d = np.abs(states[i[separated]] - states[j[separated]]).max(axis=1)
    return max(float(np.quantile(d, fraction)), 1e-6)


def _diagonals(states: np.ndarray, threshold: float, theiler: int) -> np.ndarray:
    """Number (n + 1,) of diagonal lines of each length above the Theiler window; the matrix is symmetric."""
    n = len(states)
    counts = np.zeros(n + 1, dtype=np.int64)
    for lag in range(theiler + 1, n):
        near = np.abs(states[lag:, 0] - states[:-lag, 0]) < threshold
        for column in states.T[1:]:
            near &= np.abs(column[lag:] - column[:-lag]) < threshold
        edges = np.flatnonzero(np.diff(near, prepend=False, append=False))
        np.add.at(counts, edges[1::2] - edges[::2], 1)
    return counts


def _verticals(states: np.ndarray, threshold: float, theiler: int) -> np.ndarray:
    """Number (n + 1,) of vertical lines of each length outside the Theiler window."""
    from scipy.spatial.distance import cdist

    n = len(states)
    counts, index = np.zeros(n + 1, dtype=np.int64), np.arange(n)
    for rows in np.array_split(index, max(1, n * n // BLOCK)):
        near = cdist(states[rows], states, "chebyshev") < threshold
        near &= np.abs(index - rows[:, None]) > theiler
        padded = np.zeros((len(rows), n + 2), dtype=np.int8)
        padded[:, 1:-1] = near
        edges = np.flatnonzero(np.diff(padded, axis=1))  # of all rows in turn: a line begins and ends in one row
        counts += np.bincount(edges[1::2] - edges[::2], minlength=n + 1)
    return counts
