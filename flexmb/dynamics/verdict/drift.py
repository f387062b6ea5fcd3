"""Drift among successive points: a motion that moves on by the same amount from period to period."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.dynamics.verdict.cycles import band_count, longest_cycle, phase_spread, without_bands

BLOCKS, LEAST_BLOCKS, LEAST_OF_BLOCK = 16, 12, 4
"""Parts of the record whose means are laid on a line, the fewest of them, and the fewest points of one."""

STRAIGHT = 0.95
"""Part of the mean square of these means that the line must be: means without a drift have it by chance once in 1e9."""

LEAST_IN_BAND = 10
"""Fewest points of a band whose mean is taken away."""


@dataclass(frozen=True)
class Drift:
    """What points do that move on.

    Parameters
    ----------
    column : place of the signal that does.
    step : how far in one step [unit of the signal].
    k : points of the cycle that is left without the drift; 0: something else is.
    """

    column: int
    step: float
    k: int


def find_drift(values: np.ndarray, tolerances: np.ndarray) -> Drift | None:
    """The drift of points (n, m) of given tolerances (m,); None: no signal drifts.

    Straight within the tolerance over the second half of the record, with or without a cycle on top.  Or straight
    in the means of parts of the record, once the means of the bands are taken away that are visited in turn: then
    noise, closed curves and chaos may be on top.
    """
    for column, tolerance in enumerate(tolerances):
        found = _exact(values[len(values) // 2 :, column] / tolerance)
        if found is not None:
            return Drift(column, found[0] * float(tolerance), found[1])
    for column, tolerance in enumerate(tolerances):
        step = _in_the_mean(values[:, [column]])
        if abs(step) * len(values) > tolerance:
            return Drift(column, step, 0)
    return None


def _exact(scaled: np.ndarray) -> tuple[float, int] | None:
    """Step and shortest cycle of a signal (n,) over its tolerance that is a cycle once its drift is taken away."""
    count, number = len(scaled), np.arange(len(scaled))
    for k in range(1, longest_cycle(2 * count) + 1):
        step = float((scaled[k:] - scaled[:-k]).mean()) / k
        left = scaled - step * number
        if abs(step) * count > 1.0 and phase_spread(left[:, None], k) <= 1.0:
            return step, k
    return None


def _in_the_mean(column: np.ndarray) -> float:
    """Step of a signal (n, 1) whose means over parts of the record lie on a line; 0: they do not."""
    parts = min(BLOCKS, len(column) // LEAST_OF_BLOCK)
    if parts < LEAST_BLOCKS or np.ptp(column) == 0.0:
        return 0.0
    bands, numbers = band_count(column, LEAST_IN_BAND), np.arange(len(column), dtype=np.float64)
    left, number = (without_bands(v, bands)[:, 0] for v in (column, numbers[:, None]))
    y, x = (np.array([part.mean() for part in np.array_split(v, parts)]) for v in (left, number))
    y, x = y - y.mean(), x - x.mean()
    scale = float((x @ x) * (y @ y))
    if scale == 0.0 or float(x @ y) ** 2 < STRAIGHT * scale:
        return 0.0
    return float(number @ left) / float(number @ number)
