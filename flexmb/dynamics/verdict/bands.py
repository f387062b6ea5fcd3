"""Bands: sets of section points that are visited in turn; separation of neighbours within a band."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from flexmb.series.neighbours import nearest, typical_log_distance

LEAST_IN_BAND, FINER, FEWEST_DOUBLINGS = 12, 0.25, 3
"""Limits of doubling bands: fewest points of a band, largest ratio of the mean squares, fewest doublings."""

SUCCESSORS = 3
"""Number of successive points in one vector; they distinguish points that are equal in the few signals."""

LEAST_WAY = 1.5
"""Smallest logarithm of the ratio of the distances of arbitrary points and of neighbours."""


def band_count(z: np.ndarray, least: int = 20) -> int:
    """Number of bands that points (n, m) visit in turn, each with `least` points at least; 1: no bands.

    The smallest number at which the mean square about the means of the phases falls to half of the total, and lies
    within a fifth of the minimum over all numbers up to 32.
    """
    longest = min(32, len(z) // least)
    total = float(z.var(axis=0).sum())
    squares = [sum(float(((z[p::k] - z[p::k].mean(axis=0)) ** 2).sum()) for p in range(k)) / (total * len(z))
               for k in range(1, longest + 1)]  # fmt: skip
    if not squares or min(squares) > 0.5:
        return 1
    return int(np.flatnonzero(np.array(squares) <= 1.2 * min(squares))[0]) + 1


def doublings(z: np.ndarray) -> int:
    """Number of doublings of the bands of points (n, m), if they double as far as the record can show; else 0.

    At each doubling the mean square about the means of the 2, 4, 8, ... phases falls to a fourth or less.  It falls to
    about a tenth at an accumulation of period doublings, and soon stays constant on closed curves and in banded chaos.
    The record shows bands of 12 points each.
    """
    deepest = int(np.log2(max(len(z) // LEAST_IN_BAND, 1)))
    squares = [float((without_bands(z, 2**m) ** 2).sum()) for m in range(deepest + 1)]
    always = all(after <= FINER * before for before, after in pairwise(squares)) and squares[0] > 0.0
    return deepest if always and deepest >= FEWEST_DOUBLINGS else 0


def without_bands(z: np.ndarray, k: int) -> np.ndarray:
    """Points (n, m) less the mean of their phase of k."""
    deviations = z.copy()
    for phase in range(k):
        deviations[phase::k] -= z[phase::k].mean(axis=0)
    return deviations


def separation(z: np.ndarray, bands: int) -> float:
    """Growth of the distance of neighbours: 0 if neighbours stay together, 1 if they become arbitrary points.

    The mean logarithm of the distance of neighbours, from its start value to that of arbitrary points, after up to a
    fifth of the record, at most 60 steps.  Neighbours are vectors of successive points, more than three steps apart.
    Arbitrary points belong to one band, unless neighbours are then hardly nearer.  NaN: neighbours are hardly nearer
    than arbitrary points, or part within one step (noise, or too few points for so many dimensions).

    Equation (9.9) of docs/theory/exponents.md.

    Points z (n, m) have unit spread and visit `bands` bands in turn.
    """
    count = len(z) - SUCCESSORS + 1
    points = np.concatenate([z[s : s + count] for s in range(SUCCESSORS)], axis=1)
    reach = min(60, count // 5)
    refs = np.arange(count - reach)
    near, _ = nearest(points[: count - reach], refs, SUCCESSORS, least=1e-12)
    i, j = refs[near >= 0], near[near >= 0]
    if len(i) < 20:
        return np.nan
    gaps = np.stack([np.linalg.norm(points[i + s] - points[j + s], axis=1) for s in range(reach + 1)])
    curve = np.log(np.maximum(gaps, 1e-12)).mean(axis=1)
    for stride in dict.fromkeys((bands, 1)):
        far = typical_log_distance(points, stride=stride)
        if far - curve[0] >= LEAST_WAY and curve[SUCCESSORS] <= far - 0.5:
            return float((curve[reach // 2 :].mean() - curve[0]) / (far - curve[0]))
    return np.nan
