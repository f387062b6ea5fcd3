"""Cycles among successive points of a section: points that return after k steps, or are on their way to it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

RETURNS = 3
"""Times that each point of a cycle must be seen in the second half of the record."""

TAIL = 10
"""Times that it must be seen where it shows in the last tenth only, which chance or a laminar phase may feign."""

LONGEST = 200
"""Longest cycle that is sought."""

LEAST_IN_BAND, FINER, FEWEST_DOUBLINGS = 12, 0.25, 3
"""Of bands that double: fewest points of one, most of the mean square that one doubling leaves, fewest doublings."""


@dataclass(frozen=True)
class Cycle:
    """A cycle that points settle on.

    Parameters
    ----------
    k : points of the cycle.
    since : index of the first point that lies on it, to the tolerance.
    size : largest distance of its returns, in tolerances.
    """

    k: int
    since: int
    size: float


def longest_cycle(count: int) -> int:
    """Longest cycle that `count` points can show."""
    return min(LONGEST, count // (2 * RETURNS))


def find_cycle(scaled: np.ndarray) -> Cycle | None:
    """The shortest cycle on which the last quarter of points (n, m) lies, else the last tenth; None: there is none.

    `scaled`: points over their tolerances.  All points of one phase lie within one tolerance, first to last, so that
    what creeps round a closed curve in nearly k steps is no cycle.
    """
    count = len(scaled)
    for part, returns in ((4, RETURNS), (10, TAIL)):
        for k in range(1, longest_cycle(count) + 1):
            length = max(count // part, returns * k)
            if length > count:
                break
            spread = phase_spread(scaled[count - length :], k)
            if spread <= 1.0:
                return Cycle(k, _since(scaled, k), spread)
    return None


def phase_spread(scaled: np.ndarray, k: int) -> float:
    """Largest extent of the points (n, m) of one phase of k, in tolerances; of as many whole cycles as there are.

    Parameters
    ----------
    scaled : points over their tolerances.
    k : points of a cycle.
    """
    cycles = len(scaled) // k
    return float(np.ptp(scaled[len(scaled) - cycles * k :].reshape(cycles, k, -1), axis=0).max())


def _since(scaled: np.ndarray, k: int) -> int:
    """Index from which on all points lie within a tolerance of the last ones of their phase."""
    count = len(scaled)
    last = scaled[count - k :]
    back = np.arange(count)[::-1] % k  # steps before the last point, modulo k
    away = np.abs(scaled - last[k - 1 - back]).max(axis=1) > 1.0
    outside = np.flatnonzero(away)
    return int(outside[-1]) + 1 if len(outside) else 0


@dataclass(frozen=True)
class Approach:
    """A cycle that points creep towards.

    Parameters
    ----------
    k : points of the cycle.
    rate : factor by which the steps shrink in one step of the section.
    left : last step over k, in tolerances.
    """

    k: int
    rate: float
    left: float


def find_approach(scaled: np.ndarray, spread: float) -> Approach | None:
    """The shortest cycle that points (n, m) approach; None: there is none.

    The steps over k shrink from each third of the record to the next, by at least a third, and in the last third they
    are below a fifth of the spread of the points (all in tolerances).
    """
    count = len(scaled)
    for k in range(1, longest_cycle(count) + 1):
        steps = np.abs(scaled[k:] - scaled[:-k]).max(axis=1)
        thirds = [np.array([part.max(), np.median(part)]) for part in np.array_split(steps, 3)]
        shrink = all((b <= a / 1.5).all() for a, b in pairwise(thirds))
        if shrink and thirds[2][0] < 0.2 * spread:
            rate = float((thirds[2][1] / thirds[0][1]) ** (1.5 / len(steps))) if thirds[0][1] > 0.0 else 0.0
            return Approach(k, rate, float(steps[-1]))
    return None


def swells(z: np.ndarray) -> float:
    """Largest ratio of the deviations of first and last quarter of points (n, m), if it grows or shrinks all along.

    1: the quarters rise and fall; then it is no trend but chance.
    """
    loud = np.stack([quarter.std(axis=0) for quarter in np.array_split(z, 4)])
    steps = np.diff(loud, axis=0)
    trend = ((steps > 0.0).all(axis=0) | (steps < 0.0).all(axis=0)) & (loud > 0.0).all(axis=0)
    ratio = np.where(trend, loud[-1] / np.where(loud[0] > 0.0, loud[0], 1.0), 1.0)
    return float(np.maximum(ratio, 1.0 / np.where(ratio > 0.0, ratio, 1.0)).max())


def band_count(z: np.ndarray, least: int = 20) -> int:
    """Bands that points (n, m) visit in turn, with `least` points in each of them; 1: they do not.

    The smallest number at which the mean square about the means of the phases is down to half, and within a fifth of
    its least over all numbers up to 32.
    """
    longest = min(32, len(z) // least)
    total = float(z.var(axis=0).sum())
    left = [sum(float(((z[p::k] - z[p::k].mean(axis=0)) ** 2).sum()) for p in range(k)) / (total * len(z))
            for k in range(1, longest + 1)]  # fmt: skip
    if not left or min(left) > 0.5:
        return 1
    return int(np.flatnonzero(np.array(left) <= 1.2 * min(left))[0]) + 1


def doublings(z: np.ndarray) -> int:
    """How often bands of points (n, m) double, if they do so as far as the record can show; 0: they stop before that.

    Each time the mean square about the means of the phases of 2, 4, 8, ... is down to a fourth at least: where period
    doublings accumulate it is down to a tenth or so, on closed curves and in banded chaos it soon stays.  The record
    shows bands of 12 points each.
    """
    deepest = int(np.log2(max(len(z) // LEAST_IN_BAND, 1)))
    left = [float((without_bands(z, 2**m) ** 2).sum()) for m in range(deepest + 1)]
    always = all(after <= FINER * before for before, after in pairwise(left)) and left[0] > 0.0
    return deepest if always and deepest >= FEWEST_DOUBLINGS else 0


def without_bands(z: np.ndarray, k: int) -> np.ndarray:
    """Points (n, m) less the mean of their phase of k."""
    left = z.copy()
    for phase in range(k):
        left[phase::k] -= z[phase::k].mean(axis=0)
    return left
