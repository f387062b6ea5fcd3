"""Stationarity of successive points: drift, halves of the record that differ, amplitudes that swell or shrink."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.dynamics.verdict.bands import band_count, without_bands
from flexmb.dynamics.verdict.cycles import longest_cycle, phase_spread

BLOCKS, LEAST_BLOCKS, LEAST_OF_BLOCK = 16, 12, 4
"""Number of blocks whose means are fitted by a line; the fewest blocks, and the fewest points of a block."""

STRAIGHT = 0.95
"""Smallest fraction of the mean square of the block means that the line explains; chance reaches it once in 1e9
records.
"""

LEAST_IN_BAND = 10
"""Fewest points of a band whose mean is subtracted."""


@dataclass(frozen=True)
class Drift:
    """Signal with a constant change from point to point.

    Parameters
    ----------
    column : number of the signal.
    step : change in one step [unit of the signal].
    k : number of points of the cycle without the drift; 0: no cycle.
    """

    column: int
    step: float
    k: int


def find_drift(values: np.ndarray, tolerances: np.ndarray) -> Drift | None:
    """The drift of points (n, m) with tolerances (m,); None: no signal drifts.

    Either a signal is straight within its tolerance over the second half of the record, with or without a cycle on top.
    Or its means over parts of the record lie on a line, after the means of the bands are subtracted; then noise, closed
    curves and chaos may be on top.
    """
    for column, tolerance in enumerate(tolerances):
        drift = _exact_drift(values[len(values) // 2 :, column] / tolerance)
        if drift is not None:
            return Drift(column, drift[0] * float(tolerance), drift[1])
    for column, tolerance in enumerate(tolerances):
        step = _mean_drift(values[:, [column]])
        if abs(step) * len(values) > tolerance:
            return Drift(column, step, 0)
    return None


def _exact_drift(scaled: np.ndarray) -> tuple[float, int] | None:
    """Step of a signal (n,) over its tolerance, and the shortest cycle of the signal without this drift."""
    count, number = len(scaled), np.arange(len(scaled))
    for k in range(1, longest_cycle(2 * count) + 1):
        step = float((scaled[k:] - scaled[:-k]).mean()) / k
        without_drift = scaled - step * number
        if abs(step) * count > 1.0 and phase_spread(without_drift[:, None], k) <= 1.0:
            return step, k
    return None


def _mean_drift(column: np.ndarray) -> float:
    """Step of a signal (n, 1) whose means over blocks of the record lie on a line; else 0."""
    blocks = min(BLOCKS, len(column) // LEAST_OF_BLOCK)
    if blocks < LEAST_BLOCKS or np.ptp(column) == 0.0:
        return 0.0
    bands, numbers = band_count(column, LEAST_IN_BAND), np.arange(len(column), dtype=np.float64)
    signal, number = (without_bands(v, bands)[:, 0] for v in (column, numbers[:, None]))
    y, x = (np.array([block.mean() for block in np.array_split(v, blocks)]) for v in (signal, number))
    y, x = y - y.mean(), x - x.mean()
    scale = float((x @ x) * (y @ y))
    if scale == 0.0 or float(x @ y) ** 2 < STRAIGHT * scale:
        return 0.0
    return float(number @ signal) / float(number @ number)


def halves_differ(values: np.ndarray, tolerances: np.ndarray) -> tuple[float, float]:
    """Distance of the halves of points (n, m) in deviations, and ratio of their deviations; the largest of all columns.

    For each column the smaller of two results counts: by mean and standard deviation, on which spikes weigh, and by
    median and quartiles, which jump between bands.  Differences within `tolerances` (m,) count as none.
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
    """Half the distance of the quartiles, scaled to the standard deviation of a normal distribution."""
    low, high = np.quantile(values, (0.25, 0.75), axis=0)
    return np.asarray(0.7413 * (high - low))


def swells(z: np.ndarray) -> float:
    """Ratio of the deviations of the first and last quarter of points (n, m) that grow or shrink all along; else 1."""
    deviations = np.stack([quarter.std(axis=0) for quarter in np.array_split(z, 4)])
    steps = np.diff(deviations, axis=0)
    trend = ((steps > 0.0).all(axis=0) | (steps < 0.0).all(axis=0)) & (deviations > 0.0).all(axis=0)
    ratio = np.where(trend, deviations[-1] / np.where(deviations[0] > 0.0, deviations[0], 1.0), 1.0)
    return float(np.maximum(ratio, 1.0 / np.where(ratio > 0.0, ratio, 1.0)).max())
