"""The largest exponent as one signal shows it: the record, and the straight part of a divergence curve."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.series.embedding import Embedding, embed, embedding
from flexmb.series.neighbours import typical_log_distance
from flexmb.series.samples import is_constant, mean_period, samples, spacing, standardised

LEAST = 500
"""Samples below which no exponent is estimated."""

PERIODS = 20
"""Mean periods below which no exponent is estimated."""

BLOCKS = 8
"""Parts of the record whose slopes give the error of the mean."""

MARGIN = 1.5
"""The straight part ends at the latest where the mean logarithm of the distance is this much below that of arbitrary
points."""

LEAST_RISE = 1.0
"""The straight part must rise by a factor e at least."""


@dataclass(frozen=True, eq=False)
class SeriesExponent:
    """The largest exponent of a system, as one of its signals shows it.

    Parameters
    ----------
    value : exponent [unit]; NaN where the signal shows none, `status` says why.
    error : half width of its band [unit]: twice the scatter over parts of the record and over the two halves of the
        straight part, the change with one dimension more, and 5 % for the finite distance of neighbours.
    unit : "1/s" or "1/iteration".
    ok : whether there is a value; False for constant, periodic, quasi-periodic and random signals.
    status : how it came about or why not, in a sentence.
    method : "wolf", "rosenstein" or "kantz".
    embedding : delay and dimension it was seen in; None for a constant or too short one.
    theiler : neighbours were farther apart than this [samples].
    region : first and last time of the straight part [s or iterations]; NaN without one.
    time : times of the curve (k,) [s or iterations].
    curve : mean logarithm of the distance of neighbours (k,), in standard deviations of the signal; for "wolf" the
        running estimate [unit].
    """

    value: float
    error: float
    unit: str
    ok: bool
    status: str
    method: str
    embedding: Embedding | None = field(repr=False)
    theiler: int
    region: tuple[float, float]
    time: np.ndarray = field(repr=False)
    curve: np.ndarray = field(repr=False)


@dataclass(frozen=True)
class Slope:
    """What one dimension gives: slope and error [1/sample], region [samples], curve; or a reason why not."""

    value: float
    error: float
    why_not: str
    region: tuple[float, float] = (np.nan, np.nan)
    steps: np.ndarray = field(default_factory=lambda: np.empty(0))
    curve: np.ndarray = field(default_factory=lambda: np.empty(0))


Curves = Callable[[np.ndarray, int, np.ndarray, int], np.ndarray]
"""(points (n, m), theiler, steps (k,), shift) -> curves (blocks, k) of the mean logarithm of the distance."""

FINITE = 0.05
"""Part of the value by which finite distances falsify slopes; seen with Lorenz's and Rossler's signals."""

FLOW = 8.0
"""Signals with more samples than this in a mean period are those of a flow, the others those of a map."""


def estimate(
    method: str, slope: Callable[..., Slope], signal: Any, interval: Any, options: dict[str, int | None]
) -> SeriesExponent:
    """The exponent from slopes in the dimension of the embedding and in one more; what all methods share.

    Parameters
    ----------
    method : name of the method.
    slope : slope(points, window, theiler, period) of standardised vectors.
    signal : samples (n,).
    interval : as of `spacing`.
    options : delay, dimension, theiler, as the methods take them.
    """
    x = samples(method, signal, LEAST)
    step, unit = spacing(method, interval, len(x))
    if is_constant(x):
        return _none(method, unit, None, 0, "The signal is constant: no neighbours part.")
    periods = len(x) / mean_period(x)
    if periods < PERIODS:
        text = f"The record holds {periods:.1f} mean periods; at least {PERIODS} are needed."
        return _none(method, unit, None, 0, text)
    found = embedding(x, delay=options["delay"], dimension=options["dimension"])
    theiler = options["theiler"]
    w = max(int(np.ceil(found.mean_period)), found.window) if theiler is None else theiler
    w = checks.count(method, "theiler", w, 0)
    x, slopes = standardised(x), []
    for m in (found.dimension, found.dimension + 1):
        slopes.append(slope(embed(x, found.delay, m), (m - 1) * found.delay, w, found.mean_period))
        if slopes[-1].why_not:
            return _none(method, unit, found, w, slopes[-1].why_not, slopes[-1], step)
    return _agreed(method, unit, found, w, slopes, step)


def _agreed(method: str, unit: str, found: Embedding, w: int, slopes: list[Slope], step: float) -> SeriesExponent:
    """The record of two slopes, if they tell the same."""
    a, b = slopes
    parts = (2.0 * max(a.error, b.error), a.value - b.value, FINITE * a.value)
    value, error = a.value / step, float(np.linalg.norm(parts)) / step
    if value <= error:
        text = f"The growth of {value:.3g} {unit} does not stand out of its error of {error:.2g} {unit}."
        return _none(method, unit, found, w, text, a, step)
    text = f"{value:.4g} +- {error:.2g} {unit}, seen in {found.dimension} and {found.dimension + 1} dimensions"
    text += "." if found.ok else f"; the embedding is doubtful: {found.status}"
    region = (a.region[0] * step, a.region[1] * step)
    curve = _scaled(method, a, step)
    return SeriesExponent(value, error, unit, True, text, method, found, w, region, a.steps * step, curve)


def _none(
    method: str, unit: str, found: Embedding | None, w: int, why: str, slope: Slope | None = None, step: float = 1.0
) -> SeriesExponent:
    nothing = Slope(np.nan, np.nan, why) if slope is None else slope
    times, curve = nothing.steps * step, _scaled(method, nothing, step)
    return SeriesExponent(np.nan, np.nan, unit, False, why, method, found, w, (np.nan, np.nan), times, curve)


def _scaled(method: str, slope: Slope, step: float) -> np.ndarray:
    """The curve; the running estimate of "wolf", with a value or without, in the unit of the exponent."""
    return slope.curve / step if method == "wolf" else slope.curve


def block_means(logs: np.ndarray) -> np.ndarray:
    """Curves (BLOCKS, k) of the means over blocks of points; logs (k, n), a column a point."""
    return np.stack([block.mean(axis=1) for block in np.array_split(logs, BLOCKS, axis=1)])


def straight_part(curves: Curves, points: np.ndarray, window: int, theiler: int, period: float) -> Slope:
    """Slope of the straight part of a divergence curve.

    The rule: it begins one step after the vectors at the start have been left behind (`window`), because nearest
    neighbours are chosen for being near and part at once by what is noise in them.  It ends where the error of the
    slope is smallest: the scatter over parts of the record and half the difference of the slopes of its two halves; at
    the latest `MARGIN` below the distance of arbitrary points.  At least 4 values, and a rise of `LEAST_RISE`.
    """
    shift = 0 if period < FLOW else int(np.ceil(period / 8.0))
    ceiling = typical_log_distance(points, shift=shift) - MARGIN
    longest = len(points) // 4
    reach = int(min(longest, window + 8 * max(period, 4.0)))
    while True:
        stride = max(1, reach // 150)
        steps = np.arange(0, reach + 1, stride)
        blocks = curves(points, theiler, steps, shift)
        if blocks.shape[0] < BLOCKS:
            return Slope(np.nan, np.nan, "Too few points have a neighbour that is not the same point again.")
        mean = blocks.mean(axis=0)
        begin = int(np.searchsorted(steps, window + 1))
        above = np.flatnonzero(mean[begin:] > ceiling)
        if len(above) or reach >= longest:
            break
        reach = min(longest, 2 * reach)
    end = begin + int(above[0]) if len(above) else len(steps)
    return _fit(steps, blocks, begin, end)


def _fit(steps: np.ndarray, blocks: np.ndarray, begin: int, latest: int) -> Slope:
    """Slope and error of the mean of curves (blocks, k) over the straightest part from `begin` on."""
    mean = blocks.mean(axis=0)
    if latest - begin < 4:
        text = "No straight part: neighbours are as far apart as arbitrary points at once (noise, or too few samples)."
        return Slope(np.nan, np.nan, text, steps=steps, curve=mean)
    ends = np.unique(np.linspace(begin + 4, latest, 40).astype(int))
    fits = [(end, *_slope_and_error(steps, blocks, begin, end)) for end in ends]
    rises = [value * (steps[end - 1] - steps[begin]) for end, value, _ in fits]
    if max(rises) < LEAST_RISE:
        text = f"No straight part: the distance of neighbours changes by a factor {np.exp(max(rises)):.2g} only, not e."
        return Slope(np.nan, np.nan, text, steps=steps, curve=mean)
    end, value, error = min((f for f, rise in zip(fits, rises, strict=True) if rise >= LEAST_RISE), key=lambda f: f[2])
    return Slope(value, error, "", (float(steps[begin]), float(steps[end - 1])), steps, mean)


def _slope_and_error(steps: np.ndarray, blocks: np.ndarray, begin: int, end: int) -> tuple[float, float]:
    """Slope of the mean of curves (blocks, k) over steps[begin:end], and its error."""
    mean, inside, middle = blocks.mean(axis=0), slice(begin, end), (begin + end) // 2
    parts = np.array([_slope(steps[inside], block[inside]) for block in blocks])
    first, second = (
        _slope(steps[begin : middle + 1], mean[begin : middle + 1]),
        _slope(steps[middle - 1 : end], mean[middle - 1 : end]),
    )
    error = np.hypot(parts.std(ddof=1) / np.sqrt(len(parts)), 0.5 * (second - first))
    return _slope(steps[inside], mean[inside]), float(error)


def _slope(t: np.ndarray, y: np.ndarray) -> float:
    d = t - t.mean()
    return float(d @ y / (d @ d))
