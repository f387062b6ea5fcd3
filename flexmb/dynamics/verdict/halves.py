"""Whether the halves of a record are alike."""

from __future__ import annotations

import numpy as np


def halves_differ(values: np.ndarray, tolerances: np.ndarray) -> tuple[float, float]:
    """How far the halves of points (n, m) are apart, in deviations, and the ratio of these; the most of all columns.

    Of each column the smaller answer counts of two: mean and standard deviation, which spikes take with them, and
    median and half the distance of quartiles, which jump where there are several bands.

    Parameters
    ----------
    values : the points.
    tolerances : (m,) differences that count as none.
    """
    first, last = values[: len(values) // 2], values[len(values) // 2 :]
    levels, ratios = [], []
    for middle, deviation in ((_mean, _deviation), (_median, _quartiles)):
        spreads = np.maximum(np.stack([deviation(first), deviation(last)]), tolerances)
        levels.append(np.abs(middle(last) - middle(first)) / spreads.max(axis=0))
        ratios.append(spreads.max(axis=0) / spreads.min(axis=0))
    return float(np.min(levels, axis=0).max()), float(np.min(ratios, axis=0).max())


def _mean(values: np.ndarray) -> np.ndarray:
    return np.asarray(values.mean(axis=0))


def _deviation(values: np.ndarray) -> np.ndarray:
    return np.asarray(values.std(axis=0))


def _median(values: np.ndarray) -> np.ndarray:
    return np.asarray(np.median(values, axis=0))


def _quartiles(values: np.ndarray) -> np.ndarray:
    """Half the distance of the quartiles, times what makes it a standard deviation if the points are normal."""
    low, high = np.quantile(values, (0.25, 0.75), axis=0)
    return np.asarray(0.7413 * (high - low))
