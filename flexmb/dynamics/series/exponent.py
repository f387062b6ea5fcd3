"""The largest exponent from one signal, by the methods of Kantz, Rosenstein and Wolf."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from flexmb import arguments, checks
from flexmb.dynamics.series.embedding import Embedding, distances, embed, embedding, mean_log_distance, nearest, spread
from flexmb.dynamics.series.samples import is_constant, mean_period, samples, spacing, standardised
from flexmb.fields import field, record, record_with
from flexmb.late import scipy

LEAST = 500  # smallest number of samples for an exponent
PERIODS = 20  # smallest number of mean periods for an exponent
BLOCKS = 8  # number of parts of the record whose slopes give the error of the mean
# Smallest distance of the straight part from saturation: of mean logarithms of distances, to arbitrary points.
MARGIN = 1.5
LEAST_RISE = 1.0  # smallest rise of the straight part, as a logarithm


@record_with(eq=False)
class SeriesExponent(arguments.Checked):
    """The largest exponent of a system, estimated from one of its signals."""

    formerly = (("unit", "units", "0.3"),)
    value: float = field("exponent [unit]; NaN without a value, for the reason in `status`")
    error: float = field(
        "half width of the error band [unit]: twice the scatter over parts of the record and over the halves of the "
        "straight part, the change with one dimension more, and 5 % for the finite distance of neighbours"
    )
    units: str = field('"1/s" or "1/iteration"')
    ok: bool = field("whether there is a value; False for constant, periodic, quasi-periodic and random signals")
    status: str = field("result in a sentence")
    method: str = field('"wolf", "rosenstein" or "kantz"')
    embedding: Embedding | None = field("the embedding; None for a constant or short signal", repr=False)
    theiler: int = field("smallest distance in time of neighbours [samples]")
    region: tuple[float, float] = field("first and last time of the straight part [s or iterations]; NaN: none")
    time: np.ndarray = field("times of the curve (k,) [s or iterations]", repr=False)
    curve: np.ndarray = field('mean logarithm of the distance (k,); of "wolf" the running estimate', repr=False)


@record
class Slope:
    """Slope and its error in one embedding dimension [1/sample], or the reason for no value."""

    # Begin and end of the straight part, and the divergence curve: times (k,) [samples], mean logarithms of distances.
    value: float
    error: float
    why_not: str
    region: tuple[float, float] = (np.nan, np.nan)
    steps: np.ndarray = field(default_factory=lambda: np.empty(0))
    curve: np.ndarray = field(default_factory=lambda: np.empty(0))


# Function (points (n, m), theiler, steps (k,), shift) -> curves (blocks, k) of the mean logarithm of the distance.
Curves = Callable[[np.ndarray, int, np.ndarray, int], np.ndarray]
FINITE = 0.05  # error of the slope by finite distances, over the value; observed with signals of Lorenz and Rossler
FLOW = 8.0  # number of samples in a mean period above which a signal belongs to a flow, below to a map


def estimate(
    method: str, slope: Callable[..., Slope], signal: Any, interval: Any,
    options: tuple[int | None, int | None, int | None],
) -> SeriesExponent:  # fmt: skip
    """The exponent from the slopes in two embedding dimensions: the common part of all methods."""
    # `slope(points, window, theiler, period)` takes standardised vectors, the signal has samples (n,), `interval` is as
    # of `spacing`, `options` are delay, dimension, theiler of the methods.
    x, embedded, w = samples(method, signal, LEAST), None, 0
    step, unit = spacing(method, interval, len(x))

    def record_of(found: Slope, status: str, value: float = np.nan, error: float = np.nan) -> SeriesExponent:
        """The record, without a value for the reason `status`; for "wolf" the curve is the running estimate [unit]."""
        begin, end = found.region
        known, curve = bool(np.isfinite(value)), found.curve / step if method == "wolf" else found.curve
        about = method, embedded, w, (begin * step, end * step) if known else (np.nan, np.nan)
        return SeriesExponent(value, error, unit, known, status, *about, found.steps * step, curve)

    nothing = Slope(np.nan, np.nan, "")
    if is_constant(x):
        return record_of(nothing, "The signal is constant: no neighbours part.")
    periods = len(x) / mean_period(x)
    if periods < PERIODS:
        return record_of(nothing, f"The record holds {periods:.1f} mean periods; at least {PERIODS} are needed.")
    delay, dimension, theiler = options
    embedded = embedding(x, delay=delay, dimension=dimension)
    w = max(int(np.ceil(embedded.mean_period)), embedded.window) if theiler is None else theiler
    w = checks.count(method, "theiler", w, 0)
    x, slopes = standardised(x), []
    for m in (embedded.dimension, embedded.dimension + 1):
        slopes.append(slope(embed(x, embedded.delay, m), (m - 1) * embedded.delay, w, embedded.mean_period))
        if slopes[-1].why_not:
            return record_of(slopes[-1], slopes[-1].why_not)
    a, b = slopes
    contributions = (2.0 * max(a.error, b.error), a.value - b.value, FINITE * a.value)
    value, error = a.value / step, float(np.linalg.norm(contributions)) / step
    if value <= error:
        return record_of(a, f"The growth of {value:.3g} {unit} does not exceed its error of {error:.2g} {unit}.")
    text = f"{value:.4g} +- {error:.2g} {unit}, seen in {embedded.dimension} and {embedded.dimension + 1} dimensions"
    text += "." if embedded.ok else f"; the embedding is doubtful: {embedded.status}"
    return record_of(a, text, value, error)


def block_means(logs: np.ndarray) -> np.ndarray:
    """Curves (BLOCKS, k) of the means over blocks of points; logs (k, n), a column a point."""
    return np.stack([block.mean(axis=1) for block in np.array_split(logs, BLOCKS, axis=1)])


def straight_part(curves: Curves, points: np.ndarray, window: int, theiler: int, period: float) -> Slope:
    """Slope of the straight part of a divergence curve."""
    # The straight part begins one step after the time that a vector covers (`window`): nearest neighbours are selected
    # by their distance, and noise parts them at once. It ends where the error of the slope is smallest, at the latest
    # `MARGIN` below the distance of arbitrary points. The error is the scatter over parts of the record and half the
    # difference of the slopes of its halves. The straight part has at least 4 values and a rise of `LEAST_RISE`. Points
    # are vectors (n, m); window, `theiler` (smallest distance in time of neighbours) and mean period are in samples.
    shift = 0 if period < FLOW else int(np.ceil(period / 8.0))
    ceiling, longest = mean_log_distance(points, shift=shift) - MARGIN, len(points) // 4
    reach = int(min(longest, window + 8 * max(period, 4.0)))
    while True:
        steps = np.arange(0, reach + 1, max(1, reach // 150))
        blocks = curves(points, theiler, steps, shift)
        if blocks.shape[0] < BLOCKS:
            return Slope(np.nan, np.nan, "Too few points have a neighbour that is not the same point again.")
        mean, begin = blocks.mean(axis=0), int(np.searchsorted(steps, window + 1))
        above = np.flatnonzero(mean[begin:] > ceiling)
        if len(above) or reach >= longest:
            break
        reach = min(longest, 2 * reach)
    latest = begin + int(above[0]) if len(above) else len(steps)
    if latest - begin < 4:
        text = "No straight part: neighbours are as far apart as arbitrary points at once (noise, or too few samples)."
        return Slope(np.nan, np.nan, text, steps=steps, curve=mean)
    ends, fits = np.unique(np.linspace(begin + 4, latest, 40).astype(int)), []
    for end in ends:
        inside, middle = slice(begin, end), (begin + end) // 2
        of_blocks = np.array([_slope(steps[inside], block[inside]) for block in blocks])
        first = _slope(steps[begin : middle + 1], mean[begin : middle + 1])
        second = _slope(steps[middle - 1 : end], mean[middle - 1 : end])
        error = np.hypot(of_blocks.std(ddof=1) / np.sqrt(len(of_blocks)), 0.5 * (second - first))
        fits.append((end, _slope(steps[inside], mean[inside]), float(error)))
    rises = [value * (steps[end - 1] - steps[begin]) for end, value, _ in fits]
    if max(rises) < LEAST_RISE:
        text = f"No straight part: the distance of neighbours changes by a factor {np.exp(max(rises)):.2g} only, not e."
        return Slope(np.nan, np.nan, text, steps=steps, curve=mean)
    end, value, error = min((f for f, rise in zip(fits, rises, strict=True) if rise >= LEAST_RISE), key=lambda f: f[2])
    return Slope(value, error, "", (float(steps[begin]), float(steps[end - 1])), steps, mean)


def _slope(t: np.ndarray, y: np.ndarray) -> float:
    d = t - t.mean()
    return float(d @ y / (d @ d))


KANTZ_REFERENCES = 600  # largest number of points whose neighbours are observed
NEIGHBOURS = 8  # number of neighbours of a point


def kantz(
    signal: Any, interval: Any = None, *, delay: int | None = None, dimension: int | None = None,
    theiler: int | None = None,
) -> SeriesExponent:  # fmt: skip
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
    return estimate("kantz", _kantz_slope, signal, interval, (delay, dimension, theiler))


def _kantz_slope(points: np.ndarray, window: int, theiler: int, period: float) -> Slope:
    """Slope with the mean inside the logarithm; its error includes the difference to the mean outside."""
    inner = straight_part(partial(_kantz_curves, True), points, window, theiler, period)
    if inner.why_not:
        return inner
    outer = straight_part(partial(_kantz_curves, False), points, window, theiler, period)
    return replace(inner, error=float(np.hypot(inner.error, 0.0 if outer.why_not else inner.value - outer.value)))


def _kantz_curves(inside: bool, points: np.ndarray, theiler: int, steps: np.ndarray, shift: int) -> np.ndarray:
    """Curves (blocks, k) of the mean logarithm of the mean distance (inside), or of the mean of the mean logarithms."""
    count = len(points) - int(steps[-1])
    refs = spread(count, KANTZ_REFERENCES)
    # Nearest neighbours of the points `refs`, one of each passage of the orbit; -1: too few
    neighbours = np.full((len(refs), NEIGHBOURS), -1)
    candidates = min(count, 2 * theiler + 1 + 2 * NEIGHBOURS * (2 * shift + 1))
    _, nearby = scipy.spatial.cKDTree(points[:count]).query(points[refs], k=candidates)
    for row, i, js in zip(neighbours, refs, nearby, strict=True):
        taken = 0
        for j in js[np.abs(js - i) > theiler]:
            if taken == 0 or np.abs(row[:taken] - j).min() > shift:
                row[taken] = j
                taken += 1
            if taken == NEIGHBOURS:
                break
    complete = (neighbours >= 0).all(axis=1)
    first, second = np.repeat(refs[complete], NEIGHBOURS), neighbours[complete].ravel()
    if complete.sum() < 10 * BLOCKS:
        return np.empty((0, len(steps)))
    apart = (distances(points, first + step, second + step, shift).reshape(-1, NEIGHBOURS) for step in steps)
    if inside:
        return block_means(np.array([np.log(np.maximum(d.mean(axis=1), 1e-12)) for d in apart]))
    return block_means(np.array([np.log(np.maximum(d, 1e-12)).mean(axis=1) for d in apart]))


# Largest number of points whose neighbours are observed; they are evenly spread over the record.
ROSENSTEIN_REFERENCES = 2000


def rosenstein(
    signal: Any, interval: Any = None, *, delay: int | None = None, dimension: int | None = None,
    theiler: int | None = None,
) -> SeriesExponent:  # fmt: skip
    """Largest exponent: slope of <ln |distance of nearest neighbours|> over time.

    The straight part begins one step after the time that a vector covers.  It ends where the error of its slope is
    smallest, at the latest where the mean logarithm is 1.5 below that of arbitrary points.  There is no value without
    4 points and a rise by a factor e, or if the slope does not exceed its error, as for periodic, quasi-periodic and
    random signals.

    For a flow (8 samples or more in a mean period) the distance is measured to the orbit of the neighbour instead of
    the neighbour, because two samples differ along the orbit by a constant up to a sampling interval.  For Rossler's x
    the estimate is then 0.071 instead of 0.046 (exact: 0.0714).

    The method is not suited to zero or negative exponents, nor to signals whose noise exceeds the distance of nearest
    neighbours.  It needs some 10^d to 30^d samples for an attractor of dimension d, and 20 mean periods.

    Parameters
    ----------
    signal : samples (n,), at least 500.
    interval : time between samples [s], or their times (n,) [s]; None: iterations of a map.
    delay : delay of the embedding [samples]; None: from `embedding`.
    dimension : dimension of the embedding; None: from `embedding`.
    theiler : smallest distance in time of neighbours [samples]; None: a mean period, and the window of a vector.

    Raises
    ------
    InputError : a signal that is too short or not finite, times that are not evenly spaced.

    Notes
    -----
    Source: M. T. Rosenstein, J. J. Collins and C. J. De Luca, Physica D 65 (1993) 117.
    Cost: 0.1 s for 1e4 samples of a map, 1 s of a flow.

    Examples
    --------
    >>> import flexmb as fm
    >>> x = [0.3]
    >>> for _ in range(4999):
    ...     x.append(4.0 * x[-1] * (1.0 - x[-1]))
    >>> abs(fm.chaos.rosenstein(x).value - 0.6931) < 0.03
    True
    """
    slope = partial(straight_part, _rosenstein_curves)
    return estimate("rosenstein", slope, signal, interval, (delay, dimension, theiler))


def _rosenstein_curves(points: np.ndarray, theiler: int, steps: np.ndarray, shift: int) -> np.ndarray:
    """Curves (blocks, k) of the mean logarithm of the distance, from points (n, m)."""
    count = len(points) - int(steps[-1])
    refs = spread(count, ROSENSTEIN_REFERENCES)
    neighbours, _ = nearest(points[:count], refs, theiler, least=1e-12)
    refs, neighbours = refs[neighbours >= 0], neighbours[neighbours >= 0]
    if len(refs) < 10 * BLOCKS:
        return np.empty((0, len(steps)))
    apart = np.array([distances(points, refs + step, neighbours + step, shift) for step in steps])
    return block_means(np.log(np.maximum(apart, 1e-12)))


# The largest exponent from one orbit and a neighbour that is replaced regularly, by the method of Wolf

CANDIDATES = 60  # largest number of neighbours among which a replacement is sought
BIAS = 0.05  # error by the choice of replacements, over the value; it is added to the errors that all methods have
LASTING = 0.7  # smallest ratio of the rates over the double and the single time; noise gives a half
SMALLEST = 1e-4  # smallest distance of a pair, in standard deviations; smaller distances are noise


def wolf(
    signal: Any, interval: Any = None, *, delay: int | None = None, dimension: int | None = None,
    theiler: int | None = None, evolve: int | None = None,
) -> SeriesExponent:  # fmt: skip
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
    steps_given = None if evolve is None else checks.count("wolf", "evolve", evolve)

    def slope(points: np.ndarray, window: int, theiler: int, period: float) -> Slope:
        steps = steps_given or (3 if period < FLOW else round(period))
        single, double = (_wolf_slope(points, theiler, t) for t in (steps, 2 * steps))
        if double.why_not and steps > 1:  # too few pairs or too far apart: against half the time
            return _lasting(single, _wolf_slope(points, theiler, steps // 2), single)
        return _lasting(single, single, double)

    return estimate("wolf", slope, signal, interval, (delay, dimension, theiler))


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


def _wolf_slope(points: np.ndarray, theiler: int, evolve: int) -> Slope:
    """Mean growth of the distance [1/sample] along points (n, m)."""
    starts = np.arange(0, len(points) - evolve, evolve)
    before, after = _follow(points, starts, theiler, evolve)
    has_neighbour = np.isfinite(before)
    if has_neighbour.sum() < 5 * BLOCKS:
        text = f"{has_neighbour.sum()} pairs could be followed; at least {5 * BLOCKS} are needed."
        return Slope(np.nan, np.nan, text)
    growth = np.log(np.maximum(after[has_neighbour], 1e-12) / before[has_neighbour]) / evolve
    steps, running = starts[has_neighbour] + evolve, np.cumsum(growth) / np.arange(1, len(growth) + 1)
    if np.log(np.maximum(after[has_neighbour], 1e-12)).mean() > mean_log_distance(points) - 0.7:
        text = f"After {evolve} samples pairs are as far apart as arbitrary points: noise, or `evolve` is too long."
        return Slope(np.nan, np.nan, text, steps=steps, curve=running)
    block_means = np.array([block.mean() for block in np.array_split(growth, BLOCKS)])
    error = float(block_means.std(ddof=1) / np.sqrt(BLOCKS))
    return Slope(float(growth.mean()), error, "", steps=steps, curve=running)


def _follow(points: np.ndarray, starts: np.ndarray, theiler: int, evolve: int) -> tuple[np.ndarray, np.ndarray]:
    """Distances (k,) of the pairs at the starts and `evolve` samples later; NaN without a pair."""
    usable = len(points) - evolve
    tree = scipy.spatial.cKDTree(points[:usable])
    distances, indices = tree.query(points[starts], k=min(usable, CANDIDATES + 2 * theiler))
    before, after = np.full(len(starts), np.nan), np.full(len(starts), np.nan)
    direction = None
    for s, i in enumerate(starts):
        allowed = (np.abs(indices[s] - i) > theiler) & (distances[s] > SMALLEST)
        js, ds = indices[s][allowed][:CANDIDATES], distances[s][allowed][:CANDIDATES]
        if len(js) == 0:
            direction = None
            continue
        choice = 0
        if direction is not None:  # the nearest within 20, 40, 60, 80 degrees of it on either side; else the nearest
            cosines = np.abs((points[js] - points[i]) @ direction / ds)
            inside = (np.flatnonzero(cosines > np.cos(np.radians(angle))) for angle in (20.0, 40.0, 60.0, 80.0))
            choice = next((int(places[0]) for places in inside if len(places)), 0)
        j, before[s] = js[choice], ds[choice]
        difference = points[j + evolve] - points[i + evolve]
        after[s] = np.linalg.norm(difference)
        direction = difference / after[s] if after[s] > 0.0 else None
    return before, after
