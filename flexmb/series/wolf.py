"""Largest exponent from one orbit and a neighbour that is replaced when it has gone too far."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.series.exponent import BLOCKS, FLOW, SeriesExponent, Slope, estimate
from flexmb.series.neighbours import typical_log_distance

CANDIDATES = 60
"""Neighbours among which a replacement is sought, at most."""

BIAS = 0.05
"""Part of the value that the choice of replacements falsifies; it comes on top of that which all methods have."""

LASTING = 0.7
"""Part of the rate that must be left when pairs are followed twice as long; noise leaves half."""

SMALLEST = 1e-4
"""Distances below this, in standard deviations, are taken for noise and not followed."""


def wolf(
    signal: Any,
    interval: Any = None,
    *,
    delay: int | None = None,
    dimension: int | None = None,
    theiler: int | None = None,
    evolve: int | None = None,
) -> SeriesExponent:
    """Largest exponent: mean of ln(L'/L) of a neighbour at distance L, which is L' after `evolve` samples, over time.

    After each such time the neighbour is replaced by a near one in nearly the same direction.  Periodic and
    quasi-periodic signals come out at zero within their error and have no value; nor has a signal whose pairs are as
    far apart as arbitrary points after one time, or part at less than 0.7 of the rate when they are followed twice as
    long: it is noise, or `evolve` is too long.  The error holds the difference to the value with twice the time, and
    10 % for the choice of the neighbours; values tend to be too high where stretching varies along the orbit, and too
    low where the phase of the neighbour drifts (Rossler).

    Parameters
    ----------
    signal, interval, delay, dimension, theiler : see `rosenstein`.
    evolve : time for which a pair is followed [samples]; None: three delays for maps, else a mean period.

    Raises
    ------
    InputError : a signal that is too short or not finite, times that are not evenly spaced.

    Notes
    -----
    Source: A. Wolf, J. B. Swift, H. L. Swinney and J. A. Vastano, Physica D 16 (1985) 285, the fixed evolution time.
    Cost: 0.5 s for 1e4 samples.
    """
    options = {"delay": delay, "dimension": dimension, "theiler": theiler}
    time = None if evolve is None else checks.count("wolf", "evolve", evolve)

    def slope(points: np.ndarray, window: int, theiler: int, period: float) -> Slope:
        whole = time or (3 if period < FLOW else round(period))
        first, twice = (_slope(points, theiler, t) for t in (whole, 2 * whole))
        if twice.why_not and whole > 1:  # too few pairs or too far apart: against half the time
            return _lasting(first, _slope(points, theiler, whole // 2), first)
        return _lasting(first, first, twice)

    return estimate("wolf", slope, signal, interval, options)


def _lasting(chosen: Slope, short: Slope, long: Slope) -> Slope:
    """The chosen slope, whose error holds the difference between a short and a long time, if the growth lasts."""
    if chosen.why_not:
        return chosen
    known = not (short.why_not or long.why_not)
    if known and long.value < LASTING * short.value:
        text = f"Followed twice as long, pairs part at {long.value / short.value:.2g} of the rate"
        return replace(chosen, why_not=f"{text}: not exponentially, but once (noise).")
    bias = long.value - short.value if known else BIAS * chosen.value
    return replace(chosen, error=float(np.linalg.norm((chosen.error, bias, BIAS * chosen.value))))


def _slope(points: np.ndarray, theiler: int, evolve: int) -> Slope:
    """Mean growth of the distance [1/sample] along points (n, m)."""
    starts = np.arange(0, len(points) - evolve, evolve)
    before, after = _follow(points, starts, theiler, evolve)
    followed = np.isfinite(before)
    if followed.sum() < 5 * BLOCKS:
        text = f"{followed.sum()} pairs could be followed; at least {5 * BLOCKS} are needed."
        return Slope(np.nan, np.nan, text)
    growth = np.log(np.maximum(after[followed], 1e-12) / before[followed]) / evolve
    steps, running = starts[followed] + evolve, np.cumsum(growth) / np.arange(1, len(growth) + 1)
    if np.log(np.maximum(after[followed], 1e-12)).mean() > typical_log_distance(points) - 0.7:
        text = f"After {evolve} samples pairs are as far apart as arbitrary points: noise, or `evolve` is too long."
        return Slope(np.nan, np.nan, text, steps=steps, curve=running)
    parts = np.array([part.mean() for part in np.array_split(growth, BLOCKS)])
    error = float(parts.std(ddof=1) / np.sqrt(BLOCKS))
    return Slope(float(growth.mean()), error, "", steps=steps, curve=running)


def _follow(points: np.ndarray, starts: np.ndarray, theiler: int, evolve: int) -> tuple[np.ndarray, np.ndarray]:
    """Distances (k,) at the starts and `evolve` samples later of the pairs that are followed; NaN: none was found."""
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
        pick = 0 if direction is None else _choose((points[js] - points[i]) @ direction / ds)
        j, before[s] = js[pick], ds[pick]
        apart = points[j + evolve] - points[i + evolve]
        after[s] = np.linalg.norm(apart)
        direction = apart / after[s] if after[s] > 0.0 else None
    return before, after


def _choose(cosines: np.ndarray) -> int:
    """The nearest candidate within 20, 40, 60, 80 degrees of the old direction, on either side; else the nearest."""
    for angle in (20.0, 40.0, 60.0, 80.0):
        inside = np.flatnonzero(np.abs(cosines) > np.cos(np.radians(angle)))
        if len(inside):
            return int(inside[0])
    return 0
