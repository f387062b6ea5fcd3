"""Whether neighbours among section points stay together."""

from __future__ import annotations

import numpy as np

from flexmb.analysis.series.neighbours import nearest, typical_log_distance

SUCCESSORS = 3
"""Successive points in one vector: points that look alike in few signals are told apart by where they go."""

LEAST_WAY = 1.5
"""Logarithm of the ratio between the distances of arbitrary points and of neighbours that there must be."""


def separation(z: np.ndarray, bands: int) -> float:
    """Part of the way from neighbours' to arbitrary points' distance (mean logarithms) that neighbours go.

    Points z (n, m) of unit spread.  Neighbours are of the same band and more than three steps apart; their distance is
    seen after up to a fifth of the record, at most 60 steps.  NaN: neighbours are hardly nearer than arbitrary points,
    or part within one step (noise, or too few points for so many dimensions).
    """
    count = len(z) - SUCCESSORS + 1
    points = np.concatenate([z[s : s + count] for s in range(SUCCESSORS)], axis=1)
    reach = min(60, count // 5)
    pairs = [_pairs(points[: count - reach], band, bands) for band in range(bands)]
    i, j = np.concatenate([a for a, _ in pairs]), np.concatenate([b for _, b in pairs])
    if len(i) < 20:
        return np.nan
    steps = np.arange(reach + 1)
    gaps = np.stack([np.linalg.norm(points[i + s] - points[j + s], axis=1) for s in steps])
    curve = np.log(np.maximum(gaps, 1e-12)).mean(axis=1)
    far = typical_log_distance(points, stride=bands)
    if far - curve[0] < LEAST_WAY or curve[SUCCESSORS] > far - 0.5:
        return np.nan
    late = curve[reach // 2 :].mean()
    return float((late - curve[0]) / (far - curve[0]))


def _pairs(points: np.ndarray, band: int, bands: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of one band and their nearest neighbours in it: indices into points (n, m)."""
    own = points[band::bands]
    near, _ = nearest(own, np.arange(len(own)), 1 + SUCCESSORS // bands, least=1e-12)
    found = near >= 0
    return np.flatnonzero(found) * bands + band, near[found] * bands + band
