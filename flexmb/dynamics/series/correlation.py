"""Correlation dimension and recurrence of the states behind a signal."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.series.embedding import LEAST, Embedding, embed, embedding, spread
from flexmb.dynamics.series.samples import is_constant, mean_period, samples, standardised
from flexmb.errors import InputError
from flexmb.fields import field, record_with
from flexmb.late import scipy

LEAST_OF_DIMENSION = 1000  # smallest number of samples for a dimension
PERIODS = 20  # smallest number of mean periods for a dimension
DIMENSION_REFERENCES = 1000  # largest number of points whose distances to all others are counted
PER_E = 4  # number of radii in a factor e
SPAN = 1.5  # smallest logarithm of the ratio of the radii at the ends of a scaling region
# Largest relative deviation of local slopes from their mean in a scaling region; twice that for the dimensions.
EVEN = 0.10


@record_with(eq=False)
class CorrelationDimension:
    """The correlation dimension of the set of states behind a signal."""

    value: float = field("dimension; NaN without a value, for the reason in `status`")
    error: float = field("half width of the error band: spread of the local slopes and of the embeddings")
    ok: bool = field("whether there is a value")
    status: str = field("result in a sentence")
    dimensions: tuple[int, ...] = field("embedding dimensions (d,)")
    values: tuple[float, ...] = field("correlation dimension in each embedding (d,); NaN without a scaling region")
    region: tuple[float, float] = field("radii of the scaling region, in standard deviations of the signal")
    radius: np.ndarray = field("radii (k,), in standard deviations of the signal", repr=False)
    sums: np.ndarray = field("correlation sums (d, k): fraction of the pairs nearer than the radius", repr=False)
    embedding: Embedding | None = field("the first embedding; None for a constant or short signal", repr=False)


def correlation_dimension(
    signal: Any, *, delay: int | None = None, dimension: int | None = None, theiler: int | None = None
) -> CorrelationDimension:
    """Correlation dimension: slope of ln C(r) over ln r, with the fraction C of pairs of states nearer than r.

    The scaling region is the longest range of radii, at least a factor e^1.5 = 4.5, in which local slopes stay within
    10 % of their mean.  Radii with fewer than 30 pairs or more than 10 % of all pairs do not count.  The slope is
    computed in the dimension of the embedding and in one and two more.  The three slopes must agree within 20 %,
    because the slope of noise grows with the dimension.  The distance of two states is their largest difference.

    A periodic signal gives 1, or 0 if it is sampled in step with its period (maps).  For sets with gaps on all scales
    the local slopes vary (Henon: 1.19 +- 0.05 for 1.21).

    Sets of more than 2 log10 n dimensions have no value (J.-P. Eckmann and D. Ruelle, Physica D 56 (1992) 185).

    Parameters
    ----------
    signal : samples (n,), at least 1000.
    delay : delay of the embedding [samples]; None: from `embedding`.
    dimension : smallest dimension of the embedding; None: from `embedding`.
    theiler : smallest distance in time of a pair [samples]; None: a mean period, and the window of a vector.

    Raises
    ------
    InputError : a signal that is too short or not finite.

    Notes
    -----
    Source: P. Grassberger and I. Procaccia, Physica D 9 (1983) 189; J. Theiler, Phys. Rev. A 34 (1986) 2427.
    Cost: 1 s for 1e4 samples.
    """
    owner = "correlation_dimension"
    x = samples(owner, signal, LEAST_OF_DIMENSION)
    if is_constant(x):
        return _none("The signal is constant: one point.")
    periods = len(x) / mean_period(x)
    if periods < PERIODS:
        return _none(f"The record holds {periods:.1f} mean periods; at least {PERIODS} are needed.")
    embedded = embedding(x, delay=delay, dimension=dimension)
    dimensions = tuple(range(embedded.dimension, embedded.dimension + 3))
    window = max(int(np.ceil(embedded.mean_period)), (dimensions[-1] - 1) * embedded.delay)
    w = checks.count(owner, "theiler", window if theiler is None else theiler, 0)
    x = standardised(x)
    radius = np.exp(np.arange(-9.0, 1.5, 1.0 / PER_E))
    sums, slopes = [], []
    for m in dimensions:
        sum_, least = _sum(embed(x, embedded.delay, m), w, radius)
        sums.append(sum_)
        slopes.append(_scaling(np.log(radius), sum_, least))
    values, lows, highs, spreads = (tuple(s[k] for s in slopes) for k in range(4))
    value, error, why_not = _agreed(values, spreads, len(x))
    region = (float(np.exp(max(lows))), float(np.exp(min(highs)))) if not why_not else (np.nan, np.nan)
    reason_or_value = why_not or f"{value:.3g} +- {error:.2g}, seen in {', '.join(map(str, dimensions))} dimensions."
    found = value, error, not why_not, reason_or_value, dimensions, values, region
    return CorrelationDimension(*found, radius, np.array(sums), embedded)


def _none(why: str) -> CorrelationDimension:
    none = np.nan
    return CorrelationDimension(none, none, False, why, (), (), (none, none), np.empty(0), np.empty((0, 0)), None)


def _sum(points: np.ndarray, theiler: int, radius: np.ndarray) -> tuple[np.ndarray, float]:
    """Fraction (k,) of the pairs of points (n, m) that are nearer than the radii, and the fraction of 30 pairs."""
    refs = spread(len(points), DIMENSION_REFERENCES)
    index, counts, pairs = np.arange(len(points)), np.zeros(len(radius) + 1, dtype=np.int64), 0
    for block in np.array_split(refs, max(1, len(refs) * len(points) // 2_000_000)):
        separated = np.abs(index - block[:, None]) > theiler
        d = scipy.spatial.distance.cdist(points[block], points, "chebyshev")[separated]
        counts += np.bincount(np.searchsorted(radius, d), minlength=len(radius) + 1)
        pairs += len(d)
    return np.cumsum(counts[:-1]) / max(pairs, 1), 30.0 / max(pairs, 1)


def _scaling(log_radius: np.ndarray, share: np.ndarray, least: float) -> tuple[float, float, float, float]:
    """Mean slope, ends of the longest range of even slopes, and spread of these slopes; NaN without a range."""
    if share[0] > 0.005 and share[PER_E * 4] < 1.1 * share[0]:  # a cycle of a few points
        return 0.0, float(log_radius[0]), float(log_radius[PER_E * 4]), 0.0
    usable = np.flatnonzero((share > least) & (share < 0.1))
    best = (np.nan, np.nan, np.nan, np.nan)
    if len(usable) < 2:
        return best
    usable = np.arange(usable[0], usable[-1] + 1)
    x, y = log_radius[usable], np.log(share[usable])
    slopes = np.array([(y[k + 2] - y[k]) / (x[k + 2] - x[k]) for k in range(len(x) - 2)])
    longest = SPAN
    for i in range(len(slopes)):
        for j in range(i + 1, len(slopes)):
            inside = slopes[i : j + 1]
            if np.abs(inside - inside.mean()).max() > EVEN * max(inside.mean(), 0.05):
                continue
            if x[j + 2] - x[i] >= longest:
                longest = x[j + 2] - x[i]
                line = np.polyfit(x[i : j + 3], y[i : j + 3], 1)
                best = (float(line[0]), float(x[i]), float(x[j + 2]), float(inside.std()))
    return best


def _agreed(values: tuple[float, ...], spreads: tuple[float, ...], count: int) -> tuple[float, float, str]:
    """Value, error, and reason for no value, from the values (3,) in three embeddings."""
    if not np.isfinite(values).all():
        listed = ", ".join(f"{v:.3g}" for v in values)
        reason = f"No scaling region in all three embeddings (slopes {listed})"
        return np.nan, np.nan, f"{reason}: noise, or too few samples."
    value = float(np.mean(values))
    if max(values) - min(values) > 2.0 * EVEN * max(value, 0.05):
        reason = f"The slope changes with the embedding, from {values[0]:.3g} to {values[-1]:.3g}"
        return np.nan, np.nan, f"{reason}: noise, or too few samples."
    if value > 2.0 * np.log10(count):
        return np.nan, np.nan, f"A dimension of {value:.3g} needs at least {10 ** (value / 2):.0f} samples."
    return value, float(max(np.max(spreads), max(values) - min(values))), ""


# Recurrence of states: fraction of close pairs, and lines of the recurrence matrix

BLOCK = 2_000_000  # largest number of distances in memory


@record_with(eq=False)
class Recurrence:
    """Recurrence quantification of a signal."""

    rate: float = field("fraction of the pairs of states that are nearer than the threshold")
    determinism: float = field("fraction of recurrences on diagonals of at least `shortest`: states stay together")
    laminarity: float = field("fraction of recurrences on verticals of at least `shortest`: states stay near one state")
    mean_diagonal: float = field("mean length of diagonal lines [samples]")
    longest_diagonal: int = field("largest length of diagonal lines [samples]")
    entropy: float = field("entropy of the distribution of the lengths of diagonal lines [nat]")
    trapping_time: float = field("mean length of vertical lines [samples]")
    longest_vertical: int = field("largest length of vertical lines [samples]")
    threshold: float = field("distance below which a state recurs, in standard deviations of the signal")
    theiler: int = field("smallest distance in time of a pair [samples]")
    embedding: Embedding | None = field("delay and dimension of the states", repr=False)
    ok: bool = field("whether there are recurrences")
    status: str = field("result in a sentence")
    diagonals: np.ndarray = field("number of lines of length 0, 1, 2, ... [samples]", repr=False)
    verticals: np.ndarray = field("number of lines of length 0, 1, 2, ... [samples]", repr=False)
    states: np.ndarray = field("the states (n, m), in standard deviations", repr=False)

    def matrix(self, first: int = 0, count: int = 1000) -> np.ndarray:
        """Recurrence matrix (k, k) of `count` states from number `first` on, bool; fewer at the end of the record."""
        states = self.states[checks.count("matrix", "first", first, 0) :][: checks.count("matrix", "count", count)]
        return np.asarray(scipy.spatial.distance.cdist(states, states, "chebyshev") < self.threshold)


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
    long_diagonals, long_verticals = (np.where(length >= shortest, lines, 0) for lines in (diagonals, verticals))
    fractions = long_diagonals[long_diagonals > 0] / max(long_diagonals.sum(), 1)
    text = f"{total} recurrences among {pairs} pairs nearer than {threshold:.3g} standard deviations."
    if embedded is None:
        text = "The signal is constant: every state recurs."
    return Recurrence(
        rate=total / pairs if total else np.nan, determinism=_ratio(long_diagonals @ length, total),
        laminarity=_ratio(long_verticals @ length, verticals @ length),
        mean_diagonal=_ratio(long_diagonals @ length, long_diagonals.sum()),
        longest_diagonal=int(np.flatnonzero(diagonals)[-1]) if total else 0,
        entropy=float(-(fractions * np.log(fractions)).sum()) if len(fractions) else np.nan,
        trapping_time=_ratio(long_verticals @ length, long_verticals.sum()),
        longest_vertical=int(np.flatnonzero(verticals)[-1]) if verticals.any() else 0, threshold=threshold,
        theiler=w, embedding=embedded, ok=total > 0, status=text, diagonals=diagonals, verticals=verticals,
        states=states,
    )  # fmt: skip


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
    n = len(states)
    counts, index = np.zeros(n + 1, dtype=np.int64), np.arange(n)
    for rows in np.array_split(index, max(1, n * n // BLOCK)):
        near = scipy.spatial.distance.cdist(states[rows], states, "chebyshev") < threshold
        near &= np.abs(index - rows[:, None]) > theiler
        padded = np.zeros((len(rows), n + 2), dtype=np.int8)
        padded[:, 1:-1] = near
        edges = np.flatnonzero(np.diff(padded, axis=1))  # of all rows in turn: a line begins and ends in one row
        counts += np.bincount(edges[1::2] - edges[::2], minlength=n + 1)
    return counts
