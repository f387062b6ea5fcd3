"""Evidence of a verdict: bands, cycles and stationarity of section points."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from flexmb import checks
from flexmb.dynamics.series.embedding import nearest, typical_log_distance
from flexmb.dynamics.series.samples import real_numbers
from flexmb.errors import InputError

# Columns of section points for a verdict: angles on their circle, without constant and driven signals

TURN = 2.0 * np.pi
GROUP = 1e-3  # smallest size of a signal, over the size of the largest signal of the same unit
# Multiple of the floor below which the spread of a signal cannot distinguish a cycle from other motions.
SEPARATE = 10.0


class Columns(NamedTuple):
    """Signals of section points for a verdict, and the names of signals without information."""

    # Points (n, m) in their units; a rotating angle has two columns, cosine and sine. Of each column: the name of the
    # signal, the difference that is round-off or integration error, the deviation over the second half of the record.
    values: np.ndarray
    names: tuple[str, ...]
    floor: np.ndarray
    spread: np.ndarray
    left_out: tuple[str, ...]


def points_of(points: Any, names: Sequence[str]) -> tuple[np.ndarray, tuple[str, ...]]:
    """Points as (n, m) float64, and the names of their signals; see `judge`."""
    labels = checks.sequence("judge", "names", names, "names of signals")
    values = real_numbers(points)
    if values is None:
        raise InputError("judge: the points are no table of numbers (n, m): successive points, signals.")
    if values.ndim == 1 and len(labels) == 1:
        values = values[:, None]
    if values.ndim != 2 or values.shape[1] != len(labels):
        text = f"judge: the points have shape {values.shape} for {len(labels)} names; it must be (n, {len(labels)})"
        raise InputError(f"{text}: successive points, signals.")
    return values, tuple(str(label) for label in labels)


def columns_of(
    values: np.ndarray,
    names: tuple[str, ...],
    units: Sequence[str] | None,
    driven: Sequence[str],
    floor: float,
    sizes: np.ndarray | None,
) -> Columns:
    """Columns of the signals with information, of finite points (n, m) with names, units and sizes (m,)."""
    # The unit "rad" is an angle, taken modulo 2 pi; without units a signal that grows by whole turns is an angle.
    # `driven` are signals that drives prescribe; `floor` is the round-off or integration error of a signal over its
    # size. Without sizes they are the largest magnitude of each signal, and at least 1e-3 of the largest magnitude of
    # the same unit.
    if sizes is None:
        sizes = _sizes(values, units)
    columns: list[tuple[str, np.ndarray, float]] = []
    left_out = []
    for k, name in enumerate(names):
        column = values[:, k]
        angle = units[k] == "rad" if units is not None else _turns(column)
        entries, size = [column], float(sizes[k])
        if angle:  # about its mean direction, or cosine and sine
            near = np.angle(np.exp(1j * (column - np.angle(np.exp(1j * column).mean()))))
            rotates = np.abs(near).max() >= 0.9 * np.pi
            entries, size = ([np.cos(column), np.sin(column)], 1.0) if rotates else ([near], TURN / 2)
        turned = angle and max(np.ptp(entry) for entry in entries) <= floor * size and np.ptp(column) >= TURN / 2
        if name in driven or turned:
            left_out.append(name)
        else:
            columns += [(name, entry, floor * float(size)) for entry in entries]
    half = len(values) // 2
    table = np.stack([column for _, column, _ in columns], axis=1) if columns else np.empty((len(values), 0))
    floors = np.array([column_floor for _, _, column_floor in columns])
    labels = tuple(name for name, _, _ in columns)
    return Columns(table, labels, floors, table[half:].std(axis=0), tuple(left_out))


def _sizes(values: np.ndarray, units: Sequence[str] | None) -> np.ndarray:
    """Sizes (m,) of signals from their points (n, m)."""
    # A velocity that is always 0 at the section does not have its own round-off as its size.
    own = np.asarray(np.abs(values).max(axis=0))
    if units is None:
        return own
    group = [max(own[j] for j, other in enumerate(units) if other == unit) for unit in units]
    return np.asarray(np.maximum(own, GROUP * np.array(group)))


def _turns(column: np.ndarray) -> bool:
    """Whether a signal grows by an equal integer number of turns in every step, as a driven angle."""
    steps = np.diff(column)
    turns = np.round(steps.mean() / TURN)
    return bool(turns != 0 and np.abs(steps - turns * TURN).max() < 1e-6)


# Bands: sets of section points that are visited in turn; separation of neighbours within a band

# Limits of doubling bands: fewest points of a band, largest ratio of the mean squares, fewest doublings.
LEAST_IN_DOUBLED_BAND, FINER, FEWEST_DOUBLINGS = 12, 0.25, 3
SUCCESSORS = 3  # number of successive points in one vector; they distinguish points that are equal in the few signals
LEAST_WAY = 1.5  # smallest logarithm of the ratio of the distances of arbitrary points and of neighbours


def band_count(z: np.ndarray, least: int = 20) -> int:
    """Number of bands that points (n, m) visit in turn, each with `least` points at least; 1: no bands."""
    # The smallest number at which the mean square about the means of the phases falls to half of the total, and lies
    # within a fifth of the minimum over all numbers up to 32.
    longest = min(32, len(z) // least)
    total = float(z.var(axis=0).sum())
    squares = [sum(float(((z[p::k] - z[p::k].mean(axis=0)) ** 2).sum()) for p in range(k)) / (total * len(z))
               for k in range(1, longest + 1)]  # fmt: skip
    if not squares or min(squares) > 0.5:
        return 1
    return int(np.flatnonzero(np.array(squares) <= 1.2 * min(squares))[0]) + 1


def doublings(z: np.ndarray) -> int:
    """Number of doublings of the bands of points (n, m), if they double as far as the record can show; else 0."""
    # At each doubling the mean square about the means of the 2, 4, 8, ... phases falls to a fourth or less. It falls to
    # about a tenth at an accumulation of period doublings, and soon stays constant on closed curves and in banded
    # chaos. The record shows bands of 12 points each.
    deepest = int(np.log2(max(len(z) // LEAST_IN_DOUBLED_BAND, 1)))
    squares = [float((without_bands(z, 2**m) ** 2).sum()) for m in range(deepest + 1)]
    always = all(after <= FINER * before for before, after in pairwise(squares)) and squares[0] > 0.0
    return deepest if always and deepest >= FEWEST_DOUBLINGS else 0


def without_bands(z: np.ndarray, k: int) -> np.ndarray:
    """Points (n, m) less the mean of their phase of k."""
    deviations = z.copy()
    for phase in range(k):
        deviations[phase::k] -= z[phase::k].mean(axis=0)
    return deviations


def separation(z: np.ndarray, bands: int) -> float:
    """Growth of the distance of neighbours: 0 if neighbours stay together, 1 if they become arbitrary points."""
    # The mean logarithm of the distance of neighbours, from its start value to that of arbitrary points, after up to a
    # fifth of the record, at most 60 steps. Neighbours are vectors of successive points, more than three steps apart.
    # Arbitrary points belong to one band, unless neighbours are then hardly nearer. NaN: neighbours are hardly nearer
    # than arbitrary points, or part within one step (noise, or too few points for so many dimensions).
    # Equation (9.9) of docs/theory/exponents.md.
    # Points z (n, m) have unit spread and visit `bands` bands in turn.
    count = len(z) - SUCCESSORS + 1
    points = np.concatenate([z[s : s + count] for s in range(SUCCESSORS)], axis=1)
    reach = min(60, count // 5)
    refs = np.arange(count - reach)
    near, _ = nearest(points[: count - reach], refs, SUCCESSORS, least=1e-12)
    i, j = refs[near >= 0], near[near >= 0]
    if len(i) < 20:
        return np.nan
    gaps = np.stack([np.linalg.norm(points[i + s] - points[j + s], axis=1) for s in range(reach + 1)])
    curve = np.log(np.maximum(gaps, 1e-12)).mean(axis=1)
    for stride in dict.fromkeys((bands, 1)):
        far = typical_log_distance(points, stride=stride)
        if far - curve[0] >= LEAST_WAY and curve[SUCCESSORS] <= far - 0.5:
            return float((curve[reach // 2 :].mean() - curve[0]) / (far - curve[0]))
    return np.nan


# Cycles of section points: points that return after k steps, or approach such a cycle

RETURNS = 3  # number of returns of each point of a cycle in the last quarter of the record
# Number of returns of each point of a cycle that only the last tenth shows; fewer may be chance or a laminar phase.
TAIL = 10
LONGEST = 200  # largest number of points of a cycle


class Cycle(NamedTuple):
    """A cycle of `k` points on which points have settled, from the point number `since` on."""

    k: int
    since: int


def longest_cycle(count: int) -> int:
    """Number of points of the longest cycle that `count` points can show."""
    return min(LONGEST, count // (2 * RETURNS))


def find_cycle(scaled: np.ndarray) -> Cycle | None:
    """The shortest cycle on which the last quarter of the points lies, else the last tenth; None: no cycle."""
    # All points of one phase lie within one tolerance, from the first to the last. Points that creep round a closed
    # curve in nearly k steps are therefore no cycle. Points are (n, m), over their tolerances.
    count = len(scaled)
    for divisor, returns in ((4, RETURNS), (10, TAIL)):
        for k in range(1, longest_cycle(count) + 1):
            length = max(count // divisor, returns * k)
            if length > count:
                break
            if phase_spread(scaled[count - length :], k) <= 1.0:
                last, back = scaled[count - k :], np.arange(count)[::-1] % k  # steps before the last point, modulo k
                outside = np.flatnonzero(np.abs(scaled - last[k - 1 - back]).max(axis=1) > 1.0)
                return Cycle(k, int(outside[-1]) + 1 if len(outside) else 0)
    return None


def phase_spread(scaled: np.ndarray, k: int) -> float:
    """Largest extent of points (n, m) of one phase of k, over their tolerances, over the whole cycles of the record."""
    cycles = len(scaled) // k
    return float(np.ptp(scaled[len(scaled) - cycles * k :].reshape(cycles, k, -1), axis=0).max())


class Approach(NamedTuple):
    """A cycle of `k` points that points approach."""

    # Steps over k shrink by the factor `rate` from point to point; the last one is `left` tolerances long.
    k: int
    rate: float
    left: float


def find_approach(scaled: np.ndarray, spread: float, longest: int = LONGEST) -> Approach | None:
    """The shortest cycle, of at most `longest` points, that points approach; None: no cycle."""
    # The steps over k shrink by at least a third from each third of the record to the next, and are below a fifth of
    # the spread of the points in the last third. Points (n, m) and the extent `spread` are in tolerances.
    count = len(scaled)
    for k in range(1, min(longest, longest_cycle(count)) + 1):
        steps = np.abs(scaled[k:] - scaled[:-k]).max(axis=1)
        thirds = [np.array([third.max(), np.median(third)]) for third in np.array_split(steps, 3)]
        shrink = all((b <= a / 1.5).all() for a, b in pairwise(thirds))
        if shrink and thirds[2][0] < 0.2 * spread:
            rate = float((thirds[2][1] / thirds[0][1]) ** (1.5 / len(steps))) if thirds[0][1] > 0.0 else 0.0
            return Approach(k, rate, float(steps[-1]))
    return None


# Stationarity of successive points: drift, halves of the record that differ, amplitudes that swell or shrink

# Number of blocks whose means are fitted by a line; the fewest blocks, and the fewest points of a block.
BLOCKS, LEAST_BLOCKS, LEAST_OF_BLOCK = 16, 12, 4
# Smallest fraction of the mean square of the block means that the line explains; chance reaches it once in 1e9 records.
STRAIGHT = 0.95
LEAST_IN_BAND = 10  # fewest points of a band whose mean is subtracted


class Drift(NamedTuple):
    """A signal, by its column, with a constant change in one step [unit of the signal]."""

    # Without the drift it has a cycle of `k` points; 0: no cycle.
    column: int
    step: float
    k: int


def find_drift(values: np.ndarray, tolerances: np.ndarray) -> Drift | None:
    """The drift of points (n, m) with tolerances (m,); None: no signal drifts."""
    # Either a signal is straight within its tolerance over the second half of the record, with or without a cycle on
    # top. Or its means over parts of the record lie on a line, after the means of the bands are subtracted; then noise,
    # closed curves and chaos may be on top.
    for column, tolerance in enumerate(tolerances):
        scaled = values[len(values) // 2 :, column] / tolerance
        for k in range(1, longest_cycle(2 * len(scaled)) + 1):
            step = float((scaled[k:] - scaled[:-k]).mean()) / k
            without_drift = scaled - step * np.arange(len(scaled))
            if abs(step) * len(scaled) > 1.0 and phase_spread(without_drift[:, None], k) <= 1.0:
                return Drift(column, step * float(tolerance), k)
    for column, tolerance in enumerate(tolerances):
        step = _mean_drift(values[:, [column]])
        if abs(step) * len(values) > tolerance:
            return Drift(column, step, 0)
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
    """Distance of the halves of points (n, m) in deviations, and ratio of their deviations; largest of all columns."""
    # For each column the smaller of two results counts: by mean and standard deviation, on which spikes weigh, and by
    # median and quartiles, which jump between bands. Differences within `tolerances` (m,) count as none.
    first, last = values[: len(values) // 2], values[len(values) // 2 :]
    levels, ratios = [], []
    for middle, deviation in ((np.mean, np.std), (np.median, _quartiles)):
        spreads = np.maximum(np.stack([deviation(half, axis=0) for half in (first, last)]), tolerances)
        levels.append(np.abs(middle(last, axis=0) - middle(first, axis=0)) / spreads.max(axis=0))
        ratios.append(spreads.max(axis=0) / spreads.min(axis=0))
    return float(np.min(levels, axis=0).max()), float(np.min(ratios, axis=0).max())


def _quartiles(values: np.ndarray, axis: int) -> np.ndarray:
    """Half the distance of the quartiles, scaled to the standard deviation of a normal distribution."""
    low, high = np.quantile(values, (0.25, 0.75), axis=axis)
    return np.asarray(0.7413 * (high - low))


def swells(z: np.ndarray) -> float:
    """Ratio of the deviations of the first and last quarter of points (n, m) that grow or shrink all along; else 1."""
    deviations = np.stack([quarter.std(axis=0) for quarter in np.array_split(z, 4)])
    steps = np.diff(deviations, axis=0)
    trend = ((steps > 0.0).all(axis=0) | (steps < 0.0).all(axis=0)) & (deviations > 0.0).all(axis=0)
    ratio = np.where(trend, deviations[-1] / np.where(deviations[0] > 0.0, deviations[0], 1.0), 1.0)
    return float(np.maximum(ratio, 1.0 / np.where(ratio > 0.0, ratio, 1.0)).max())
