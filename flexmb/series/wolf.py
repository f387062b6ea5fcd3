"""The largest exponent from one orbit and a neighbour that is replaced regularly, by the method of Wolf."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.series.exponent import BLOCKS, FLOW, SeriesExponent, Slope, estimate
from flexmb.series.neighbours import typical_log_distance

CANDIDATES = 60
"""Largest number of neighbours among which a replacement is sought."""

BIAS = 0.05
"""Error by the choice of replacements, over the value; it is added to the errors that all methods have."""

LASTING = 0.7
"""Smallest ratio of the rates over the double and the single time; noise gives a half."""

SMALLEST = 1e-4
"""Smallest distance of a pair, in standard deviations; smaller distances are noise."""


def wolf(
    signal: Any,
    interval: Any = None,
    *,
    delay: int | None = None,
    dimension: int | None = None,
    theiler: int | None = None,
    evolve: int | None = None,
) -> SeriesExponent:
    """Largest exponent: mean of ln(L'/L) over time; L and L' are the distances of a neighbour `evolve` samples apart.

    After `evolve` samples the neighbour is replaced by a near point in nearly the same direction.  Periodic and
    quasi-periodic signals give zero within the error, and so no value.  There is no value either if pairs are as far
    apart as arbitrary points after one time, or part at less than 0.7 of the rate over twice the time: the signal is
    noise, or `evolve` is too long.  The error contains the difference to the value with twice the time, and 10 % for
    the choice of the neighbours.  Values tend to be too high if stretching varies along the orbit, and too low if the
    phase of the neighbour drifts (Rossler).

    Parameters
    ----------
    signal, interval, delay, dimension, theiler : see `rosenstein`.
    evolve : time between two replacements [samples]; None: three delays for maps, else a mean period.

    Raises
    ------
    InputError : a signal that is too short or not finite, times that are not evenly spaced.

    Notes
    -----
    Source: A. Wolf, J. B. Swift, H. L. Swinney and J. A. Vastano, Physica D 16 (1985) 285, the fixed evolution time.
    Cost: 0.5 s for 1e4 samples.
    """
    options = {"delay": delay, "dimension": dimension, "theiler": theiler}
    steps_given = None if evolve is None else checks.count("wolf", "evolve", evolve)

    def slope(points: np.ndarray, window: int, theiler: int, period: float) -> Slope:
        steps = steps_given or (3 if period < FLOW else round(period))
        single, double = (_slope(points, theiler, t) for t in (steps, 2 * steps))
        if double.why_not and steps > 1:  # too few pairs or too far apart: against half the time
            return _lasting(single, _slope(points, theiler, steps // 2), single)
        return _lasting(single, single, double)

    return estimate("wolf", slope, signal, interval, options)


def _lasting(chosen: Slope, short: Slope, long: Slope) -> Slope:
    """The chosen slope if the growth lasts; its error includes the difference between a short and a long time."""
    if chosen.why_not:
        return chosen
    known = not (short.why_not or long.why_not)
    if known and long.value < LASTING * short.value:
        text = f"Over twice the time, pairs part at {long.value / short.value:.2g} of the rate"
        return replace(chosen, why_not=f"{text}: they part once and not exponentially (noise).")
    bias = long.value - short.value if known else BIAS * chosen.value
    return replace(chosen, error=float(np.linalg.norm((chosen.error, bias, BIAS * chosen.value))))


def _slope(points: np.ndarray, theiler: int, evolve: int) -> Slope:
    """Mean growth of the distance [1/sample] along points (n, m)."""
    starts = np.arange(0, len(points) - evolve, evolve)
    before, after = _follow(points, starts, theiler, evolve)
    has_neighbour = np.isfinite(before)
    if has_neighbour.sum() < 5 * BLOCKS:
        text = f"{has_neighbour.sum()} pairs could be followed; at least {5 * BLOCKS} are needed."
        return Slope(np.nan, np.nan, text)
    growth = np.log(np.maximum(after[has_neighbour], 1e-12) / before[has_neighbour]) / evolve
    steps, running = starts[has_neighbour] + evolve, np.cumsum(growth) / np.arange(1, len(growth) + 1)
    if np.log(np.maximum(after[has_neighbour], 1e-12)).mean() > typical_log_distance(points) - 0.7:
        text = f"After {evolve} samples pairs are as far apart as arbitrary points: noise, or `evolve` is too long."
        return Slope(np.nan, np.nan, text, steps=steps, curve=running)
    block_means = np.array([block.mean() for block in np.array_split(growth, BLOCKS)])
    error = float(block_means.std(ddof=1) / np.sqrt(BLOCKS))
    return Slope(float(growth.mean()), error, "", steps=steps, curve=running)


def _follow(points: np.ndarray, starts: np.ndarray, theiler: int, evolve: int) -> tuple[np.ndarray, np.ndarray]:
    """Distances (k,) of the pairs at the starts and `evolve` samples later; NaN without a pair."""
    from scipy.spatial import cKDTree

    usable = len(points) - evolve
    tree = cKDTree(points[:usable])
    distances, indices = tree.query(points[starts], k=min(usable, CANDIDATES + 2 * theiler))
    before, after = np.full(len(starts), np.nan), np.full(len(starts), np.nan)
    direction = None
    for s, i in enumerate(starts):
        allowed = (np.abs(indices[s] - i) > theiler) & (distances[s] > SMALLEST)
        js, ds = indices[s][allowed][:CANDIDATES], distances[s][allowed][:CANDIDATES]
        if len(js) == 0:
            direction = None
            continue
        choice = 0 if direction is None else _choose((points[js] - points[i]) @ direction / ds)
        j, before[s] = js[choice], ds[choice]
        difference = points[j + evolve] - points[i + evolve]
        after[s] = np.linalg.norm(difference)
        direction = difference / after[s] if after[s] > 0.0 else None
    return before, after


def _choose(cosines: np.ndarray) -> int:
    """Nearest candidate within 20, 40, 60, 80 degrees of the old direction on either side; else the nearest one."""
    for angle in (20.0, 40.0, 60.0, 80.0):
        inside = np.flatnonzero(np.abs(cosines) > np.cos(np.radians(angle)))
        if len(inside):
            return int(inside[0])
    return 0
