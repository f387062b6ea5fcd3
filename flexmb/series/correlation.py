"""The correlation dimension: how the number of neighbours grows with the distance."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.series.embedding import Embedding, embed, embedding
from flexmb.series.neighbours import spread
from flexmb.series.samples import is_constant, mean_period, samples, standardised

LEAST = 1000
"""Samples below which no dimension is estimated."""

PERIODS = 20
"""Mean periods below which no dimension is estimated."""

REFERENCES = 1000
"""Points whose distances to all others are counted, at most."""

PER_E = 4
"""Radii in a factor e."""

SPAN = 1.5
"""Logarithm of the ratio of radii that a scaling region must cover."""

EVEN = 0.10
"""Part by which local slopes may deviate from their mean in a scaling region; the dimensions may by twice that."""


@dataclass(frozen=True, eq=False)
class CorrelationDimension:
    """The correlation dimension of the set that a signal comes from.

    Parameters
    ----------
    value : dimension; NaN where there is none, `status` says why.
    error : half width of its band: spread of the local slopes and over the embeddings.
    ok : whether there is a value.
    status : how it came about or why not, in a sentence.
    dimensions : embedding dimensions (d,) that were tried.
    values : dimension seen in each (d,); NaN without a scaling region.
    region : smallest and largest radius of the scaling region, in standard deviations of the signal.
    radius : radii (k,), in standard deviations of the signal.
    sums : correlation sums (d, k): part of the pairs that are nearer than the radius.
    embedding : delay and dimension from which it was tried; None for a constant or too short signal.
    """

    value: float
    error: float
    ok: bool
    status: str
    dimensions: tuple[int, ...]
    values: tuple[float, ...]
    region: tuple[float, float]
    radius: np.ndarray = field(repr=False)
    sums: np.ndarray = field(repr=False)
    embedding: Embedding | None = field(repr=False)


def correlation_dimension(
    signal: Any, *, delay: int | None = None, dimension: int | None = None, theiler: int | None = None
) -> CorrelationDimension:
    """Correlation dimension: slope of ln C(r) over ln r, C the part of pairs of states nearer than r.

    The scaling region is the longest range of radii, at least a factor e^1.5 = 4.5, in which local slopes stay within
    10 % of their mean; radii with fewer than 30 pairs or more than 10 % of all do not count.  It is sought in the
    dimension of the embedding and in one and two more; they must agree within 20 %, else there is no value: the
    slope of noise grows with the dimension.  Distances are largest differences.

    A periodic signal gives 1, or 0 if it is sampled in step with its period (maps).  Slopes wriggle for sets with
    gaps on all scales (Henon: 1.19 +- 0.05 for 1.21).

    Not for sets of more dimensions than 2 log10 n (J.-P. Eckmann and D. Ruelle, Physica D 56 (1992) 185); a larger
    value is refused.

    Parameters
    ----------
    signal : samples (n,), at least 1000.
    delay : delay of the embedding [samples]; None: as `embedding` finds it.
    dimension : its smallest dimension; None: as `embedding` finds it.
    theiler : pairs must be farther apart than this [samples]; None: a mean period, and the window of a vector.

    Raises
    ------
    InputError : a signal that is too short or not finite.

    Notes
    -----
    Source: P. Grassberger and I. Procaccia, Physica D 9 (1983) 189; J. Theiler, Phys. Rev. A 34 (1986) 2427.
    Cost: 1 s for 1e4 samples.
    """
    owner = "correlation_dimension"
    x = samples(owner, signal, LEAST)
    if is_constant(x):
        return _none("The signal is constant: one point.")
    periods = len(x) / mean_period(x)
    if periods < PERIODS:
        return _none(f"The record holds {periods:.1f} mean periods; at least {PERIODS} are needed.")
    found = embedding(x, delay=delay, dimension=dimension)
    dimensions = tuple(range(found.dimension, found.dimension + 3))
    window = (dimensions[-1] - 1) * found.delay
    w = max(int(np.ceil(found.mean_period)), window) if theiler is None else checks.count(owner, "theiler", theiler, 0)
    x = standardised(x)
    radius = np.exp(np.arange(-9.0, 1.5, 1.0 / PER_E))
    sums, slopes = [], []
    for m in dimensions:
        share, least = _sum(embed(x, found.delay, m), w, radius)
        sums.append(share)
        slopes.append(_scaling(np.log(radius), share, least))
    values, lows, highs, spreads = (tuple(s[k] for s in slopes) for k in range(4))
    value, error, why_not = _agreed(values, spreads, len(x))
    region = (float(np.exp(max(lows))), float(np.exp(min(highs)))) if not why_not else (np.nan, np.nan)
    text = why_not or f"{value:.3g} +- {error:.2g}, seen in {', '.join(map(str, dimensions))} dimensions."
    return CorrelationDimension(
        value, error, not why_not, text, dimensions, values, region, radius, np.array(sums), found
    )


def _none(why: str) -> CorrelationDimension:
    nothing = np.empty(0)
    return CorrelationDimension(
        np.nan, np.nan, False, why, (), (), (np.nan, np.nan), nothing, nothing.reshape(0, 0), None
    )


def _sum(points: np.ndarray, theiler: int, radius: np.ndarray) -> tuple[np.ndarray, float]:
    """Part (k,) of the pairs of points (n, m) that are nearer than the radii, and that part which is 30 pairs."""
    from scipy.spatial.distance import cdist

    refs = spread(len(points), REFERENCES)
    index, counts, pairs = np.arange(len(points)), np.zeros(len(radius) + 1, dtype=np.int64), 0
    for part in np.array_split(refs, max(1, len(refs) * len(points) // 2_000_000)):
        apart = np.abs(index - part[:, None]) > theiler
        d = cdist(points[part], points, "chebyshev")[apart]
        counts += np.bincount(np.searchsorted(radius, d), minlength=len(radius) + 1)
        pairs += len(d)
    return np.cumsum(counts[:-1]) / max(pairs, 1), 30.0 / max(pairs, 1)


def _scaling(log_radius: np.ndarray, share: np.ndarray, least: float) -> tuple[float, float, float, float]:
    """Mean slope, ends of the longest range of even slopes, spread of the slopes in it; NaN: there is none."""
    if share[0] > 0.005 and share[PER_E * 4] < 1.1 * share[0]:  # the same few points again and again
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
    """Value, error and reason why not, from the values (3,) in three embeddings."""
    if not np.isfinite(values).all():
        listed = ", ".join(f"{v:.3g}" for v in values)
        text = f"No scaling region in all three embeddings (slopes {listed})"
        return np.nan, np.nan, f"{text}: noise, or too few samples."
    value = float(np.mean(values))
    if max(values) - min(values) > 2.0 * EVEN * max(value, 0.05):
        text = f"The slope changes with the embedding, from {values[0]:.3g} to {values[-1]:.3g}"
        return np.nan, np.nan, f"{text}: noise, or too few samples."
    if value > 2.0 * np.log10(count):
        return np.nan, np.nan, f"A dimension of {value:.3g} needs at least {10 ** (value / 2):.0f} samples."
    return value, float(max(np.max(spreads), max(values) - min(values))), ""
