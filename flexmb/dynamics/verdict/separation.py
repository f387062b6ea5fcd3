"""Whether neighbours among section points stay together."""

from __future__ import annotations

import numpy as np

from flexmb.series.neighbours import nearest, typical_log_distance

SUCCESSORS = 3
"""Successive points in one vector: points that look alike in few signals are told apart by where they go."""

LEAST_WAY = 1.5
"""Logarithm of the ratio between the distances of arbitrary points and of neighbours that there must be."""


def separation(z: np.ndarray, bands: int) -> float:
    """Part of the way from neighbours' to arbitrary points' distance (mean logarithms) that neighbours go.

    Points z (n, m) of unit spread, which visit `bands` bands in turn: arbitrary points are of one band then, unless
    that leaves no way to go.  Neighbours are more than three steps apart; their distance is seen after up to a fifth of
    the record, at most 60 steps.  NaN: neighbours are hardly nearer than arbitrary points, or part within one step
    (noise, or too few points for so many dimensions).
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
