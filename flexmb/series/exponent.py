"""The largest exponent from one signal: record, and fit of the straight part of a divergence curve."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flexmb import arguments, checks
from flexmb.series.embedding import Embedding, embed, embedding
from flexmb.series.neighbours import typical_log_distance
from flexmb.series.samples import is_constant, mean_period, samples, spacing, standardised

LEAST = 500
"""Smallest number of samples for an exponent."""

PERIODS = 20
"""Smallest number of mean periods for an exponent."""

BLOCKS = 8
"""Number of parts of the record whose slopes give the error of the mean."""

MARGIN = 1.5
"""Smallest distance of the straight part from saturation: of mean logarithms of distances, to arbitrary points."""

LEAST_RISE = 1.0
"""Smallest rise of the straight part, as a logarithm."""


@dataclass(frozen=True, eq=False)
class SeriesExponent(arguments.Checked):
    """The largest exponent of a system, estimated from one of its signals.

    Parameters
    ----------
    value : exponent [unit]; NaN without a value, for the reason in `status`.
    error : half width of the error band [unit]: twice the scatter over parts of the record and over the halves of the
        straight part, the change with one dimension more, and 5 % for the finite distance of neighbours.
    units : "1/s" or "1/iteration".
    ok : whether there is a value; False for constant, periodic, quasi-periodic and random signals.
    status : result in a sentence.
    method : "wolf", "rosenstein" or "kantz".
    embedding : delay and dimension of the embedding; None for a constant or too short signal.
    theiler : smallest distance in time of neighbours [samples].
    region : first and last time of the straight part [s or iterations]; NaN without a straight part.
    time : times of the curve (k,) [s or iterations].
    curve : mean logarithm of the distance of neighbours (k,), in standard deviations of the signal; for "wolf" the
        running estimate [unit].
    """

    formerly = (("unit", "units"),)
    value: float
    error: float
    units: str
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
    """Slope in one embedding dimension.

    Parameters
    ----------
    value, error : slope and error [1/sample].
    why_not : reason for no value; "" with a value.
    region : begin and end of the straight part [samples].
    steps, curve : divergence curve: times (k,) [samples] and mean logarithms of distances (k,).
    """

    value: float
    error: float
    why_not: str
    region: tuple[float, float] = (np.nan, np.nan)
    steps: np.ndarray = field(default_factory=lambda: np.empty(0))
    curve: np.ndarray = field(default_factory=lambda: np.empty(0))


Curves = Callable[[np.ndarray, int, np.ndarray, int], np.ndarray]
"""Function (points (n, m), theiler, steps (k,), shift) -> curves (blocks, k) of the mean logarithm of the distance."""

FINITE = 0.05
"""Error of the slope by finite distances, over the value; observed with signals of Lorenz and Rossler."""

FLOW = 8.0
"""Number of samples in a mean period above which a signal belongs to a flow, below to a map."""


def estimate(
    method: str, slope: Callable[..., Slope], signal: Any, interval: Any, options: dict[str, int | None]
) -> SeriesExponent:
    """The exponent from the slopes in two embedding dimensions: the common part of all methods.

    `slope(points, window, theiler, period)` takes standardised vectors, the signal has samples (n,), `interval` is as
    of `spacing`, `options` are delay, dimension, theiler of the methods.
    """
    x = samples(method, signal, LEAST)
    step, unit = spacing(method, interval, len(x))
    if is_constant(x):
        return _none(method, unit, None, 0, "The signal is constant: no neighbours part.")
    periods = len(x) / mean_period(x)
    if periods < PERIODS:
        text = f"The record holds {periods:.1f} mean periods; at least {PERIODS} are needed."
        return _none(method, unit, None, 0, text)
    embedded = embedding(x, delay=options["delay"], dimension=options["dimension"])
    theiler = options["theiler"]
    w = max(int(np.ceil(embedded.mean_period)), embedded.window) if theiler is None else theiler
    w = checks.count(method, "theiler", w, 0)
    x, slopes = standardised(x), []
    for m in (embedded.dimension, embedded.dimension + 1):
        slopes.append(slope(embed(x, embedded.delay, m), (m - 1) * embedded.delay, w, embedded.mean_period))
        if slopes[-1].why_not:
            return _none(method, unit, embedded, w, slopes[-1].why_not, slopes[-1], step)
    return _agreed(method, unit, embedded, w, slopes, step)


def _agreed(method: str, unit: str, embedded: Embedding, w: int, slopes: list[Slope], step: float) -> SeriesExponent:
    """The record of two slopes, with a value if the exponent exceeds its error."""
    a, b = slopes
    contributions = (2.0 * max(a.error, b.error), a.value - b.value, FINITE * a.value)
    value, error = a.value / step, float(np.linalg.norm(contributions)) / step
    if value <= error:
        text = f"The growth of {value:.3g} {unit} does not exceed its error of {error:.2g} {unit}."
        return _none(method, unit, embedded, w, text, a, step)
    text = f"{value:.4g} +- {error:.2g} {unit}, seen in {embedded.dimension} and {embedded.dimension + 1} dimensions"
    text += "." if embedded.ok else f"; the embedding is doubtful: {embedded.status}"
    region = (a.region[0] * step, a.region[1] * step)
    curve = _scaled(method, a, step)
    return SeriesExponent(value, error, unit, True, text, method, embedded, w, region, a.steps * step, curve)


def _none(
    method: str, unit: str, embedded: Embedding | None, w: int, why: str, slope: Slope | None = None, step: float = 1.0
) -> SeriesExponent:
    recorded = Slope(np.nan, np.nan, why) if slope is None else slope
    times, curve = recorded.steps * step, _scaled(method, recorded, step)
    return SeriesExponent(np.nan, np.nan, unit, False, why, method, embedded, w, (np.nan, np.nan), times, curve)


def _scaled(method: str, slope: Slope, step: float) -> np.ndarray:
    """The curve; for "wolf" the running estimate in the unit of the exponent."""
    return slope.curve / step if method == "wolf" else slope.curve


def block_means(logs: np.ndarray) -> np.ndarray:
    """Curves (BLOCKS, k) of the means over blocks of points; logs (k, n), a column a point."""
    return np.stack([block.mean(axis=1) for block in np.array_split(logs, BLOCKS, axis=1)])


def straight_part(curves: Curves, points: np.ndarray, window: int, theiler: int, period: float) -> Slope:
    """Slope of the straight part of a divergence curve.

    The straight part begins one step after the time that a vector covers (`window`): nearest neighbours are selected by
    their distance, and noise parts them at once.  It ends where the error of the slope is smallest, at the latest
    `MARGIN` below the distance of arbitrary points.  The error is the scatter over parts of the record and half the
    difference of the slopes of its halves.  The straight part has at least 4 values and a rise of `LEAST_RISE`.  Points
    are vectors (n, m); window, `theiler` (smallest distance in time of neighbours) and mean period are in samples.
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
    """Slope and error of the mean of curves (blocks, k) over their straightest part from `begin` on."""
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
    """Slope of the mean of curves (blocks, k) over steps[begin:end], and error of the slope."""
    mean, inside, middle = blocks.mean(axis=0), slice(begin, end), (begin + end) // 2
    block_slopes = np.array([_slope(steps[inside], block[inside]) for block in blocks])
    first, second = (
        _slope(steps[begin : middle + 1], mean[begin : middle + 1]),
        _slope(steps[middle - 1 : end], mean[middle - 1 : end]),
    )
    error = np.hypot(block_slopes.std(ddof=1) / np.sqrt(len(block_slopes)), 0.5 * (second - first))
    return _slope(steps[inside], mean[inside]), float(error)


def _slope(t: np.ndarray, y: np.ndarray) -> float:
    d = t - t.mean()
    return float(d @ y / (d @ d))
