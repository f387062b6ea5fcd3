"""Delay embedding of a signal: neighbours, correlation dimension and recurrence of the states behind the signal."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.series.samples import is_constant, mean_period, samples, standardised
from flexmb.errors import InputError
from flexmb.fields import field, record_with
from flexmb.late import scipy

BLOCK = 2_000_000  # largest number of distances in memory


def spread(count: int, most: int) -> np.ndarray:
    """At most `most` indices (r,), spread evenly over `count` points."""
    return np.unique(np.linspace(0, count - 1, most).astype(int))


def nearest(points: np.ndarray, refs: np.ndarray, theiler: int, least: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Nearest neighbour of each reference point, outside a window of time (J. Theiler, Phys. Rev. A 34 (1986) 2427)."""
    # Returned are indices (r,) of the neighbours of points[refs], -1 without a neighbour, and their distances (r,),
    # `least` at least. Points are (n, m), `theiler` is the smallest distance in time of neighbours [samples].
    tree = scipy.spatial.cKDTree(points)
    neighbour, distance = np.full(len(refs), -1), np.full(len(refs), np.nan)
    unfinished, k = np.arange(len(refs)), 4
    while len(unfinished):
        k = min(k, len(points))
        for block in np.array_split(unfinished, max(1, len(unfinished) * k // BLOCK)):
            d, j = tree.query(points[refs[block]], k=k)
            d, j = d.reshape(len(block), k), j.reshape(len(block), k)
            allowed = (np.abs(j - refs[block][:, None]) > theiler) & (d > least)
            first = allowed.argmax(axis=1)
            has_neighbour = allowed[np.arange(len(block)), first]
            neighbour[block[has_neighbour]] = j[has_neighbour, first[has_neighbour]]
            distance[block[has_neighbour]] = d[has_neighbour, first[has_neighbour]]
        unfinished = unfinished[neighbour[unfinished] < 0]
        if k == len(points) or k > 4096:  # points without a neighbour are left out
            break
        k *= 4
    return neighbour, distance


def mean_log_distance(points: np.ndarray, *, stride: int = 1, shift: int = 0) -> float:
    """Mean logarithm of the distance of two arbitrary points of (n, m); see `distances` for `shift`."""
    # The distance in time is a multiple of `stride` [samples].
    rng, count = np.random.default_rng(1), len(points)
    i, j = rng.integers(0, count, 5000), rng.integers(0, count, 5000)
    j = i + (j - i) // stride * stride
    inside = (j >= 0) & (j != i)
    d = distances(points, i[inside], j[inside], shift)
    return float(np.log(d[d > 0.0]).mean()) if (d > 0.0).any() else -np.inf


def distances(points: np.ndarray, i: np.ndarray, j: np.ndarray, shift: int) -> np.ndarray:
    """Distances (k,) of points[i] from points[j]; with `shift` > 0 from the orbit through points[j]."""
    # Two samples of one orbit differ along the orbit by up to a sampling interval. This constant difference would hide
    # the growth of the distance. Therefore the nearest sample within `shift` of j is taken, and the component of its
    # distance across the orbit. Points are (n, m); `shift` is the half width of the search along the orbit [samples].
    if shift == 0:
        return np.asarray(np.linalg.norm(points[j] - points[i], axis=1))
    last = len(points) - 2
    best, least = np.clip(j, 1, last), np.full(len(i), np.inf)
    for s in range(-shift, shift + 1):
        other = np.clip(j + s, 1, last)
        gap = points[other] - points[i]
        square = np.einsum("ij,ij->i", gap, gap)
        nearer = square < least
        best[nearer], least[nearer] = other[nearer], square[nearer]
    gap, along = points[best] - points[i], points[best + 1] - points[best - 1]
    parallel = np.einsum("ij,ij->i", gap, along)
    parallel = parallel**2 / np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
    return np.asarray(np.sqrt(np.maximum(least - parallel, 0.0)))


LEAST = 100  # smallest number of samples for a delay or a dimension
FALSE_SHARE = 0.01  # fraction of false neighbours below which a dimension is sufficient


@record_with(eq=False)
class Embedding:
    """Delay and dimension of the embedding of a signal."""

    delay: int = field("distance of two entries of a vector [samples]")
    dimension: int = field("number of entries of a vector")
    mean_period: float = field("inverse of the mean frequency of the power spectrum [samples]")
    information: np.ndarray = field("mutual information at lags 0, 1, ... [nat]", repr=False)
    false_share: np.ndarray = field("fraction of false neighbours in dimensions 1, 2 and so on", repr=False)
    ok: bool = field("whether the fraction of false neighbours is small enough in this dimension")
    status: str = field("result in a sentence")

    @property
    def window(self) -> int:
        """Length in time of a vector [samples]."""
        return (self.dimension - 1) * self.delay


def embed(signal: Any, delay: int, dimension: int) -> np.ndarray:
    """Vectors (x[i], x[i + delay], ..., x[i + (dimension - 1) delay]) of a signal, as rows.

    Parameters
    ----------
    signal : samples (n,).
    delay : distance of two entries of a vector [samples], >= 1.
    dimension : number of entries of a vector, >= 1.

    Returns
    -------
    Array (n - (dimension - 1) delay, dimension) in the unit of the signal.

    Raises
    ------
    InputError : a signal that is shorter than a vector or not finite.

    Notes
    -----
    Source: F. Takens, Lecture Notes in Mathematics 898 (1981) 366.

    Examples
    --------
    >>> import flexmb as fm
    >>> fm.chaos.embed([0.0, 1.0, 2.0, 3.0], 2, 2)
    array([[0., 2.],
           [1., 3.]])
    """
    m, tau = checks.count("embed", "dimension", dimension), checks.count("embed", "delay", delay)
    x = samples("embed", signal, (m - 1) * tau + 1)
    count = len(x) - (m - 1) * tau
    return np.stack([x[i * tau : i * tau + count] for i in range(m)], axis=1)


def mutual_information(signal: Any, longest: int | None = None) -> np.ndarray:
    """Mutual information of samples at distances of 0, 1, ..., `longest` samples [nat].

    The range is divided into intervals with equal numbers of samples, so the result does not depend on units, offsets
    and monotonic calibrations.  A finite record adds about (intervals - 1)^2 / (2 n).

    Parameters
    ----------
    signal : samples (n,), at least 100.
    longest : largest lag [samples]; None: two mean periods, at most a quarter of the record.

    Raises
    ------
    InputError : a signal that is too short or not finite, a lag beyond the record.

    Notes
    -----
    Source: A. M. Fraser and H. L. Swinney, Phys. Rev. A 33 (1986) 1134.  Cost: 0.1 s for 1e4 samples and 100 lags.
    """
    x = samples("mutual_information", signal, LEAST)
    if longest is None:
        longest = int(min(len(x) // 4, np.ceil(2.0 * mean_period(x))))
    longest = checks.count("mutual_information", "longest", longest, 0)
    if longest > len(x) - LEAST // 2:
        raise InputError(f"mutual_information: longest is {longest}; {len(x)} samples allow {len(x) - LEAST // 2}.")
    bins = int(np.clip(np.sqrt(len(x) / 5.0), 4, 32))
    cell = np.searchsorted(np.quantile(x, np.linspace(0.0, 1.0, bins + 1)[1:-1]), x, side="right")
    found = np.zeros(longest + 1)
    for lag in range(longest + 1):  # sum of p_ab ln(p_ab / (p_a p_b)) over the cells
        a, b = cell[: len(x) - lag], cell[lag:]
        joint = np.bincount(a * bins + b, minlength=bins * bins).reshape(bins, bins) / len(a)
        independent, nonzero = joint.sum(axis=1)[:, None] * joint.sum(axis=0), joint > 0.0
        found[lag] = np.sum(joint[nonzero] * np.log(joint[nonzero] / independent[nonzero]))
    return found


def false_neighbours(signal: Any, delay: int, *, largest: int = 8, theiler: int | None = None) -> np.ndarray:
    """Fraction of false nearest neighbours in 1, 2, ..., `largest` dimensions.

    A neighbour is false if the difference of the next entry is larger than 15 times the distance, or if the distance
    with the next entry is larger than two standard deviations of the signal.  Distances below 1e-6 standard deviations
    are set to 1e-6 standard deviations, so integration errors make no neighbour false.  NaN: the record is too short
    for the dimension.

    Parameters
    ----------
    signal : samples (n,), at least 100, not all the same.
    delay : distance of two entries of a vector [samples].
    largest : largest dimension.
    theiler : smallest distance in time of neighbours [samples]; None: a mean period, at most a tenth of the record.

    Raises
    ------
    InputError : a signal that is constant, too short or not finite.

    Notes
    -----
    Source: M. B. Kennel, R. Brown and H. D. I. Abarbanel, Phys. Rev. A 45 (1992) 3403, both criteria.
    """
    owner = "false_neighbours"
    x, tau = samples(owner, signal, LEAST), checks.count(owner, "delay", delay)
    largest = checks.count(owner, "largest", largest)
    if is_constant(x):
        raise InputError(f"{owner}: the signal is constant; it has no neighbours.")
    x = standardised(x)
    if theiler is None:
        theiler = int(min(np.ceil(mean_period(x)), len(x) // 10))
    w, shares = checks.count(owner, "theiler", theiler, 0), np.full(largest, np.nan)
    for k in range(largest):
        ahead = (k + 1) * tau  # from a vector of dimension k + 1 to its next entry
        count = len(x) - ahead
        if count < LEAST // 2:
            break
        refs = spread(count, 4000)
        neighbour, distance = nearest(embed(x, tau, k + 1)[:count], refs, w)
        known = neighbour >= 0
        if known.sum() >= LEAST // 4:
            gap, d = np.abs(x[refs[known] + ahead] - x[neighbour[known] + ahead]), distance[known]
            shares[k] = np.mean((gap > 15.0 * np.maximum(d, 1e-6)) | (np.hypot(gap, d) > 2.0))
    return shares


def embedding(signal: Any, *, delay: int | None = None, dimension: int | None = None, largest: int = 8) -> Embedding:
    """Delay and dimension of the embedding of a signal.

    The delay is the first minimum of the mutual information between a tenth and a quarter of the mean period; shorter
    minima are accidents of exactly periodic signals.  Without a minimum it is the first lag at which the mutual
    information has fallen to 1/e, at most a quarter of the mean period.  For signals with fewer than 8 samples in a
    mean period (maps) it is 1.  The dimension is the smallest with less than 1 % of false neighbours.  Without such a
    dimension, `ok` is False, and the dimension is that with the fewest: noise, or a state of more dimensions.

    Parameters
    ----------
    signal : samples (n,), at least 100, not all the same.
    delay : known delay [samples]; None: unknown.
    dimension : known dimension; None: unknown.
    largest : largest dimension to be tried.

    Raises
    ------
    InputError : a signal that is constant, too short or not finite.

    Examples
    --------
    >>> import flexmb as fm, numpy as np
    >>> found = fm.chaos.embedding(np.sin(0.1 * np.arange(2000)))
    >>> found.dimension, 6 <= found.delay <= 16  # of a period of 62.8 samples
    (2, True)
    """
    x = samples("embedding", signal, LEAST)
    period, information = mean_period(x), mutual_information(x)
    tau = _delay(information, period) if delay is None else checks.count("embedding", "delay", delay)
    if dimension is not None:
        m = checks.count("embedding", "dimension", dimension)
        return Embedding(tau, m, period, information, np.full(0, np.nan), True, "The dimension is given.")
    shares = false_neighbours(x, tau, largest=largest)
    if np.isnan(shares).all():
        text = f"{len(x)} samples hold too few vectors with delay {tau}."
        return Embedding(tau, 1, period, information, shares, False, text)
    enough = np.flatnonzero(shares < FALSE_SHARE)
    m = 1 + int(enough[0] if len(enough) else np.nanargmin(shares))
    text = f"{100 * shares[m - 1]:.2g} % of the neighbours are false in dimension {m}"
    text += "." if len(enough) else f", in none up to {largest} less than 1 %: noise, or a state of more dimensions."
    return Embedding(tau, m, period, information, shares, bool(len(enough)), text)


def _delay(information: np.ndarray, period: float) -> int:
    """Lag of the first minimum, below the values at the two lags on either side; else of the fall to 1/e."""
    if period < 8.0:
        return 1
    quarter = max(1, round(period / 4.0))
    for lag in range(max(1, round(period / 10.0)), len(information) - 1):
        if information[lag] <= information[max(lag - 2, 0) : lag + 3].min() and information[lag] < information[lag - 1]:
            return min(lag, quarter)
    below = np.flatnonzero(information < information[0] / np.e)
    return max(1, min(int(below[0]) if len(below) else int(period / 4.0), quarter))


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
    x, radius = standardised(x), np.exp(np.arange(-9.0, 1.5, 1.0 / PER_E))
    sums, slopes = [], []
    for m in dimensions:
        # Fraction of the pairs of points (n, m) that are nearer than the radii, and the fraction of 30 pairs
        points = embed(x, embedded.delay, m)
        counts = np.zeros(len(radius) + 1, dtype=np.int64)
        pairs = 0
        refs, index = spread(len(points), DIMENSION_REFERENCES), np.arange(len(points))
        for block in np.array_split(refs, max(1, len(refs) * len(points) // BLOCK)):
            d = scipy.spatial.distance.cdist(points[block], points, "chebyshev")[np.abs(index - block[:, None]) > w]
            counts += np.bincount(np.searchsorted(radius, d), minlength=len(radius) + 1)
            pairs += len(d)
        sums.append(np.cumsum(counts[:-1]) / max(pairs, 1))
        slopes.append(_scaling(np.log(radius), sums[-1], 30.0 / max(pairs, 1)))
    values, lows, highs, spreads = (tuple(s[k] for s in slopes) for k in range(4))
    value, error, why_not = _agreed(values, spreads, len(x))
    region = (float(np.exp(max(lows))), float(np.exp(min(highs)))) if not why_not else (np.nan, np.nan)
    reason_or_value = why_not or f"{value:.3g} +- {error:.2g}, seen in {', '.join(map(str, dimensions))} dimensions."
    found = value, error, not why_not, reason_or_value, dimensions, values, region
    return CorrelationDimension(*found, radius, np.array(sums), embedded)


def _none(why: str) -> CorrelationDimension:
    none = np.nan
    return CorrelationDimension(none, none, False, why, (), (), (none, none), np.empty(0), np.empty((0, 0)), None)


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
    slopes, longest = np.array([(y[k + 2] - y[k]) / (x[k + 2] - x[k]) for k in range(len(x) - 2)]), SPAN
    for i in range(len(slopes)):
        for j in range(i + 1, len(slopes)):
            inside = slopes[i : j + 1]
            if np.abs(inside - inside.mean()).max() > EVEN * max(inside.mean(), 0.05):
                continue
            if x[j + 2] - x[i] >= longest:
                longest, line = x[j + 2] - x[i], np.polyfit(x[i : j + 3], y[i : j + 3], 1)
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
    signal: Any, *, threshold: float | None = None, delay: int | None = None, dimension: int | None = None,
    theiler: int | None = None, shortest: int = 2,
) -> Recurrence:  # fmt: skip
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
    if threshold is None:  # from pairs that are drawn at random
        rng = np.random.default_rng(3)
        i, j = rng.integers(0, len(states), 50000), rng.integers(0, len(states), 50000)
        separated = np.abs(i - j) > w
        d = np.abs(states[i[separated]] - states[j[separated]]).max(axis=1)
        threshold = max(float(np.quantile(d, 0.05)), 1e-6)
    return _counted(embedded, states, threshold, w, shortest)


def _counted(embedded: Embedding | None, states: np.ndarray, threshold: float, w: int, shortest: int) -> Recurrence:
    """The record of the recurrences of states (n, m)."""
    n, (diagonals, verticals) = len(states), _line_lengths(states, threshold, w)
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


def _line_lengths(states: np.ndarray, threshold: float, theiler: int) -> tuple[np.ndarray, np.ndarray]:
    """Numbers (n + 1,) of lines of each length: diagonal ones above the Theiler window, vertical ones outside of it."""
    n, index = len(states), np.arange(len(states))  # the matrix of recurrences is symmetric
    diagonals, verticals = np.zeros((2, n + 1), dtype=np.int64)
    for lag in range(theiler + 1, n):
        near = np.abs(states[lag:, 0] - states[:-lag, 0]) < threshold
        for column in states.T[1:]:
            near &= np.abs(column[lag:] - column[:-lag]) < threshold
        edges = np.flatnonzero(np.diff(near, prepend=False, append=False))
        np.add.at(diagonals, edges[1::2] - edges[::2], 1)
    for rows in np.array_split(index, max(1, n * n // BLOCK)):
        near = scipy.spatial.distance.cdist(states[rows], states, "chebyshev") < threshold
        near &= np.abs(index - rows[:, None]) > theiler
        padded = np.zeros((len(rows), n + 2), dtype=np.int8)
        padded[:, 1:-1] = near
        edges = np.flatnonzero(np.diff(padded, axis=1))  # of all rows in turn: a line begins and ends in one row
        verticals += np.bincount(edges[1::2] - edges[::2], minlength=n + 1)
    return diagonals, verticals
