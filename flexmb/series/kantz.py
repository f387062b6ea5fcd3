"""The largest exponent from several neighbours of each point, by the method of Kantz."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from flexmb.series.exponent import BLOCKS, SeriesExponent, Slope, block_means, estimate, straight_part
from flexmb.series.neighbours import distances, spread

REFERENCES = 600
"""Largest number of points whose neighbours are observed."""

NEIGHBOURS = 8
"""Number of neighbours of a point."""


def kantz(
    signal: Any,
    interval: Any = None,
    *,
    delay: int | None = None,
    dimension: int | None = None,
    theiler: int | None = None,
) -> SeriesExponent:
    """Largest exponent: slope of <ln (mean distance of the neighbours of a point)> over time.

    The mean over the 8 nearest neighbours of each of 600 points, one neighbour of each passage of the orbit, stands
    inside the logarithm.  The slope lies above the exponent if stretching varies along the orbit (Lorenz's x, y).
    The error therefore contains twice the difference to the slope with the mean outside the logarithm.  Straight part
    and signals without a value: see `rosenstein`.  The source uses the neighbours within a radius; a fixed number of
    neighbours also serves sparse regions.

    Parameters
    ----------
    signal, interval, delay, dimension, theiler : see `rosenstein`.

    Raises
    ------
    InputError : a signal that is too short or not finite, times that are not evenly spaced.

    Notes
    -----
    Source: H. Kantz, Phys. Lett. A 185 (1994) 77.  Cost: 3 s for 1e4 samples.
    """
    options = {"delay": delay, "dimension": dimension, "theiler": theiler}
    return estimate("kantz", _slope, signal, interval, options)


def _slope(points: np.ndarray, window: int, theiler: int, period: float) -> Slope:
    """Slope with the mean inside the logarithm; its error includes the difference to the mean outside."""
    inner = straight_part(partial(_curves, True), points, window, theiler, period)
    if inner.why_not:
        return inner
    outer = straight_part(partial(_curves, False), points, window, theiler, period)
    difference = 0.0 if outer.why_not else inner.value - outer.value
    return replace(inner, error=float(np.hypot(inner.error, difference)))


def _curves(inside: bool, points: np.ndarray, theiler: int, steps: np.ndarray, shift: int) -> np.ndarray:
    """Curves (blocks, k) of the mean logarithm of the mean distance (inside), or of the mean of the mean logarithms."""
    count = len(points) - int(steps[-1])
    refs = spread(count, REFERENCES)
    neighbours = _neighbours(points[:count], refs, theiler, shift)
    complete = (neighbours >= 0).all(axis=1)
    i, j = np.repeat(refs[complete], NEIGHBOURS), neighbours[complete].ravel()
    if complete.sum() < 10 * BLOCKS:
        return np.empty((0, len(steps)))
    logs = np.empty((len(steps), int(complete.sum())))
    for row, step in zip(logs, steps, strict=True):
        distance = distances(points, i + step, j + step, shift).reshape(-1, NEIGHBOURS)
        if inside:
            row[:] = np.log(np.maximum(distance.mean(axis=1), 1e-12))
        else:
            row[:] = np.log(np.maximum(distance, 1e-12)).mean(axis=1)
    return block_means(logs)


def _neighbours(points: np.ndarray, refs: np.ndarray, theiler: int, shift: int) -> np.ndarray:
    """Nearest neighbours (r, NEIGHBOURS) of `points[refs]`, one of each passage of the orbit; -1: too few."""
    from scipy.spatial import cKDTree

    neighbours = np.full((len(refs), NEIGHBOURS), -1)
    candidates = min(len(points), 2 * theiler + 1 + 2 * NEIGHBOURS * (2 * shift + 1))
    _, nearby = cKDTree(points).query(points[refs], k=candidates)
    for row, i, js in zip(neighbours, refs, nearby, strict=True):
        count = 0
        for j in js[np.abs(js - i) > theiler]:
            if count == 0 or np.abs(row[:count] - j).min() > shift:
                row[count] = j
                count += 1
            if count == NEIGHBOURS:
                break
    return neighbours
