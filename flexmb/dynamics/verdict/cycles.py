"""Cycles of section points: points that return after k steps, or approach such a cycle."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

RETURNS = 3
"""Number of returns of each point of a cycle in the last quarter of the record."""

TAIL = 10
"""Number of returns of each point of a cycle that only the last tenth shows; fewer may be chance or a laminar phase."""

LONGEST = 200
"""Largest number of points of a cycle."""


@dataclass(frozen=True)
class Cycle:
    """A cycle on which points have settled.

    Parameters
    ----------
    k : number of points of the cycle.
    since : index of the first point that lies on the cycle within the tolerance.
    size : largest distance of the returns, in tolerances.
    """

    k: int
    since: int
    size: float


def longest_cycle(count: int) -> int:
    """Number of points of the longest cycle that `count` points can show."""
    return min(LONGEST, count // (2 * RETURNS))


def find_cycle(scaled: np.ndarray) -> Cycle | None:
    """The shortest cycle on which the last quarter of the points lies, else the last tenth; None: no cycle.

    All points of one phase lie within one tolerance, from the first to the last.  Points that creep round a closed
    curve in nearly k steps are therefore no cycle.  Points are (n, m), over their tolerances.
    """
    count = len(scaled)
    for divisor, returns in ((4, RETURNS), (10, TAIL)):
        for k in range(1, longest_cycle(count) + 1):
            length = max(count // divisor, returns * k)
            if length > count:
                break
            spread = phase_spread(scaled[count - length :], k)
            if spread <= 1.0:
                return Cycle(k, _since(scaled, k), spread)
    return None


def phase_spread(scaled: np.ndarray, k: int) -> float:
    """Largest extent of points (n, m) of one phase of k, over their tolerances, over the whole cycles of the record."""
    cycles = len(scaled) // k
    return float(np.ptp(scaled[len(scaled) - cycles * k :].reshape(cycles, k, -1), axis=0).max())


def _since(scaled: np.ndarray, k: int) -> int:
    """Index from which on all points lie within a tolerance of the last points of their phase."""
    count = len(scaled)
    last = scaled[count - k :]
    back = np.arange(count)[::-1] % k  # steps before the last point, modulo k
    away = np.abs(scaled - last[k - 1 - back]).max(axis=1) > 1.0
    outside = np.flatnonzero(away)
    return int(outside[-1]) + 1 if len(outside) else 0


@dataclass(frozen=True)
class Approach:
    """A cycle that points approach.

    Parameters
    ----------
    k : number of points of the cycle.
    rate : factor by which the steps over k shrink from point to point.
    left : last step over k, in tolerances.
    """

    k: int
    rate: float
    left: float


def find_approach(scaled: np.ndarray, spread: float) -> Approach | None:
    """The shortest cycle that points approach; None: no cycle.

    The steps over k shrink by at least a third from each third of the record to the next, and are below a fifth of the
    spread of the points in the last third.  Points (n, m) and the extent `spread` are in tolerances.
    """
    count = len(scaled)
    for k in range(1, longest_cycle(count) + 1):
        steps = np.abs(scaled[k:] - scaled[:-k]).max(axis=1)
        thirds = [np.array([third.max(), np.median(third)]) for third in np.array_split(steps, 3)]
        shrink = all((b <= a / 1.5).all() for a, b in pairwise(thirds))
        if shrink and thirds[2][0] < 0.2 * spread:
            rate = float((thirds[2][1] / thirds[0][1]) ** (1.5 / len(steps))) if thirds[0][1] > 0.0 else 0.0
            return Approach(k, rate, float(steps[-1]))
    return None
