"""Delay embedding of a signal, and neighbours in state space."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.series.samples import is_constant, mean_period, samples, standardised
from flexmb.errors import InputError
from flexmb.fields import field, record_with
from flexmb.late import scipy

BLOCK = 1_000_000  # largest number of distances in memory


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


def typical_log_distance(points: np.ndarray, *, stride: int = 1, shift: int = 0) -> float:
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
    edges = np.quantile(x, np.linspace(0.0, 1.0, bins + 1)[1:-1])
    cell = np.searchsorted(edges, x, side="right")
    found = np.zeros(longest + 1)
    for lag in range(longest + 1):  # sum of p_ab ln(p_ab / (p_a p_b)) over the cells
        a, b = cell[: len(x) - lag], cell[lag:]
        joint = np.bincount(a * bins + b, minlength=bins * bins).reshape(bins, bins) / len(a)
        independent = joint.sum(axis=1)[:, None] * joint.sum(axis=0)
        nonzero = joint > 0.0
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
    w = checks.count(owner, "theiler", theiler, 0)
    return np.array([_false_share(x, tau, m, w) for m in range(1, largest + 1)])


def _false_share(x: np.ndarray, tau: int, m: int, theiler: int) -> float:
    """Fraction of false neighbours among at most 4000 vectors of dimension m."""
    count = len(x) - m * tau
    if count < LEAST // 2:
        return np.nan
    refs = spread(count, 4000)
    neighbour, distance = nearest(embed(x, tau, m)[:count], refs, theiler)
    has_neighbour = neighbour >= 0
    if has_neighbour.sum() < LEAST // 4:
        return np.nan
    next_gap = np.abs(x[refs[has_neighbour] + m * tau] - x[neighbour[has_neighbour] + m * tau])
    d = np.maximum(distance[has_neighbour], 1e-6)
    return float(np.mean((next_gap > 15.0 * d) | (np.hypot(next_gap, distance[has_neighbour]) > 2.0)))


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
