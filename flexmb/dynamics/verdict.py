"""The verdict on a motion from its section points: evidence (bands, cycles, stationarity), and its kind."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from numbers import Real
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from flexmb import checks, display
from flexmb.dynamics.series.embedding import mean_log_distance, nearest
from flexmb.dynamics.series.samples import CHAOTIC, LARGEST, growth_correlations, kind_of, real_numbers
from flexmb.errors import InputError
from flexmb.fields import field, record

# Columns of section points for a verdict: angles on their circle, without constant and driven signals

TURN = 2.0 * np.pi
GROUP = 1e-3  # smallest size of a signal, over the size of the largest signal of the same unit
# Multiple of the floor below which the spread of a signal cannot distinguish a cycle from other motions.
SEPARATE = 10.0

Known = tuple[tuple[str, ...] | None, tuple[str, ...], np.ndarray | None]  # units, driven names and sizes of signals


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
    labels, values = checks.sequence("judge", "names", names, "names of signals"), real_numbers(points)
    if values is None:
        raise InputError("judge: the points are no table of numbers (n, m): successive points, signals.")
    if values.ndim == 1 and len(labels) == 1:
        values = values[:, None]
    if values.ndim != 2 or values.shape[1] != len(labels):
        text = f"judge: the points have shape {values.shape} for {len(labels)} names; it must be (n, {len(labels)})"
        raise InputError(f"{text}: successive points, signals.")
    return values, tuple(str(label) for label in labels)


def columns_of(values: np.ndarray, names: tuple[str, ...], known: Known, floor: float) -> Columns:
    """Columns of the signals with information, of finite points (n, m) with names, units and sizes (m,)."""
    # The unit "rad" is an angle, taken modulo 2 pi; without units a signal that grows by whole turns is an angle.
    # `driven` are signals that drives prescribe; `floor` is the round-off or integration error of a signal over its
    # size. Without sizes they are the largest magnitude of each signal, and at least 1e-3 of the largest magnitude of
    # the same unit.
    units, driven, sizes = known
    if sizes is None:  # a velocity that is always 0 at the section does not have its own round-off as its size
        sizes = np.abs(values).max(axis=0)
        if units is not None:
            group = [max(sizes[j] for j, other in enumerate(units) if other == unit) for unit in units]
            sizes = np.maximum(sizes, GROUP * np.array(group))
    columns: list[tuple[str, np.ndarray, float]] = []
    left_out = []
    for k, name in enumerate(names):
        column = values[:, k]
        if units is None:  # an angle grows by an equal integer number of turns in every step, as a driven one
            steps = np.diff(column)
            turns = np.round(steps.mean() / TURN)
            angle = turns != 0 and np.abs(steps - turns * TURN).max() < 1e-6
        else:
            angle = units[k] == "rad"
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
    return Columns(table, tuple(name for name, _, _ in columns), floors, table[half:].std(axis=0), tuple(left_out))


# Bands: sets of section points that are visited in turn; separation of neighbours within a band

# Limits of doubling bands: fewest points of a band, largest ratio of the mean squares, fewest doublings.
LEAST_IN_DOUBLED_BAND, FINER, FEWEST_DOUBLINGS = 12, 0.25, 3
SUCCESSORS = 3  # number of successive points in one vector; they distinguish points that are equal in the few signals
LEAST_WAY = 1.5  # smallest logarithm of the ratio of the distances of arbitrary points and of neighbours


def band_count(z: np.ndarray, least: int = 20) -> int:
    """Number of bands that points (n, m) visit in turn, each with `least` points at least; 1: no bands."""
    # The smallest number at which the mean square about the means of the phases falls to half of the total, and lies
    # within a fifth of the minimum over all numbers up to 32.
    longest, total = min(32, len(z) // least), float(z.var(axis=0).sum())
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
    # Points z (n, m) have unit spread and visit `bands` bands in turn. Equation (9.9) of docs/theory/exponents.md.
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
        far = mean_log_distance(points, stride=stride)
        if far - curve[0] >= LEAST_WAY and curve[SUCCESSORS] <= far - 0.5:
            return float((curve[reach // 2 :].mean() - curve[0]) / (far - curve[0]))
    return np.nan


# Cycles of section points: points that return after k steps, or approach such a cycle

RETURNS = 3  # number of returns of each point of a cycle in the last quarter of the record
# Number of returns of each point of a cycle that only the last tenth shows; fewer may be chance or a laminar phase.
TAIL = 10
LONGEST = 200  # largest number of points of a cycle


def longest_cycle(count: int) -> int:
    """Number of points of the longest cycle that `count` points can show."""
    return min(LONGEST, count // (2 * RETURNS))


def find_cycle(scaled: np.ndarray) -> tuple[int, int] | None:
    """Points of the shortest cycle on which the last quarter or tenth of the points lies, and its first point."""
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
                return k, int(outside[-1]) + 1 if len(outside) else 0
    return None


def phase_spread(scaled: np.ndarray, k: int) -> float:
    """Largest extent of points (n, m) of one phase of k, over their tolerances, over the whole cycles of the record."""
    cycles = len(scaled) // k
    return float(np.ptp(scaled[len(scaled) - cycles * k :].reshape(cycles, k, -1), axis=0).max())


def find_approach(scaled: np.ndarray, spread: float, longest: int = LONGEST) -> tuple[int, float, float] | None:
    """Points of the shortest cycle that is approached, factor of its steps from point to point, length of the last."""
    # A cycle has at most `longest` points. The steps over k shrink by at least a third from each third of the record to
    # the next, and are below a fifth of the spread of the points in the last third. Points (n, m) and the extent
    # `spread` are in tolerances.
    for k in range(1, min(longest, longest_cycle(len(scaled))) + 1):
        steps = np.abs(scaled[k:] - scaled[:-k]).max(axis=1)
        thirds = [np.array([third.max(), np.median(third)]) for third in np.array_split(steps, 3)]
        if all((b <= a / 1.5).all() for a, b in pairwise(thirds)) and thirds[2][0] < 0.2 * spread:
            rate = float((thirds[2][1] / thirds[0][1]) ** (1.5 / len(steps))) if thirds[0][1] > 0.0 else 0.0
            return k, rate, float(steps[-1])
    return None


# Stationarity of successive points: drift, halves of the record that differ, amplitudes that swell or shrink

# Number of blocks whose means are fitted by a line; the fewest blocks, and the fewest points of a block.
BLOCKS, LEAST_BLOCKS, LEAST_OF_BLOCK = 16, 12, 4
# Smallest fraction of the mean square of the block means that the line explains; chance reaches it once in 1e9 records.
STRAIGHT = 0.95
LEAST_IN_BAND = 10  # fewest points of a band whose mean is subtracted


def find_drift(values: np.ndarray, tolerances: np.ndarray) -> tuple[int, float, int] | None:
    """Column of points (n, m) that drifts, its change in a step [its unit], points of the cycle on top (0: none)."""
    # Either a signal is straight within its tolerance over the second half of the record, with or without a cycle on
    # top. Or its means over parts of the record lie on a line, after the means of the bands are subtracted; then noise,
    # closed curves and chaos may be on top.
    for column, tolerance in enumerate(tolerances):
        scaled = values[len(values) // 2 :, column] / tolerance
        for k in range(1, longest_cycle(2 * len(scaled)) + 1):
            step = float((scaled[k:] - scaled[:-k]).mean()) / k
            without_drift = scaled - step * np.arange(len(scaled))
            if abs(step) * len(scaled) > 1.0 and phase_spread(without_drift[:, None], k) <= 1.0:
                return column, step * float(tolerance), k
    for column, tolerance in enumerate(tolerances):
        step = _mean_drift(values[:, [column]])
        if abs(step) * len(values) > tolerance:
            return column, step, 0
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


# Meaning of the evidence of a verdict, by name.
MEANING = {
    "zero_one": "0-1 test: 0 regular, 1 chaotic", "separation": "separation of neighbours: 0 stay together, 1 part",
    "k": "points of the cycle", "since": "first point on the cycle",
    "shrink": "factor by which steps shrink from point to point",
    "growth": "factor by which steps grow from point to point",
    "level": "change of the means between the halves, in deviations",
    "loudness": "change of the deviations between the halves",
    "swelling": "change of the amplitude, first to last quarter",
    "drift": "step by which a signal moves on from point to point",
    "doublings": "doublings of the bands, as far as the points can show",
    "bands": "parts of the section that are visited in turn", "signals": "signals on which the verdict rests",
    "points": "points, one a period",
}  # fmt: skip


def meaning_of(value: float, error: float, period: float) -> str:
    """Meaning of an exponent [1/s] with an error (NaN: unknown), in words; `period` [s] lies between two points."""
    if not np.isfinite(value):
        return "none was found"
    if not np.isfinite(error):
        return "without an error: take more periods"
    if abs(value) <= error:
        return "zero within its error: neighbours keep their distance"
    time = 1.0 / abs(value)
    length = f"a factor e in {time:.3g} s ({time / period:.3g} periods)"
    return f"neighbours part by {length}" if value > 0.0 else f"neighbours come nearer by {length}"


LEAST = 12  # smallest number of points for a verdict
LEAST_APERIODIC = 100  # smallest number of points that distinguishes quasi-periodic from chaotic motion
# Smallest number of points for chaos, if the exponent exceeds this multiple of its error.
LEAST_CHAOTIC, CLEARLY = 50, 3.0
SETTLED = 0.1  # fraction of the record within which a periodic motion must have reached its cycle
MOST_SIGNALS = 8  # largest number of columns in the 0-1 test
# Length of the record over the largest lag of the 0-1 test.
# With a tenth, as in the source, 250 points of a closed curve may look chaotic, and banded chaos regular.
PART = 4
# Separation of neighbours D below which a motion is regular, above which it is chaotic; below which K is not asked.
# Limits of the 0-1 test K: `series/samples.py`; of tests for cycles, approach and drift: above.
REGULAR, PARTED, TOGETHER = 0.2, 0.5, 0.05
RELATIVE = 1e-4  # difference that counts as none, over the spread of the signal


@record
class Verdict:
    """Kind of a motion; `str` gives "periodic-3", "quasi-periodic", "chaotic", "transient" or "inconclusive"."""

    kind: str = field('"periodic", "quasi-periodic", "chaotic", "transient" or "inconclusive"')
    reason: str = field("reason, and advice after an inconclusive or transient verdict, in a sentence or two")
    k: int = field("points of the cycle of a periodic motion, or of the one it approaches; 0: none", default=0)
    evidence: Mapping[str, float] = field(
        "numbers of the verdict; see `judge`", default_factory=lambda: MappingProxyType({}), repr=False, hash=False
    )

    def __post_init__(self) -> None:
        checks.one_of("Verdict", "kind", self.kind, KINDS)
        object.__setattr__(self, "evidence", MappingProxyType(dict(self.evidence)))

    def __str__(self) -> str:
        return f"periodic-{self.k}" if self.kind == "periodic" else self.kind

    def __repr__(self) -> str:
        return display.cut(f"Verdict: {self}. {self.reason}", 3)

    def _repr_html_(self) -> str:
        rows = [(name, f"{value:.6g}") for name, value in self.evidence.items()]
        return display.page(f"Verdict: {self}", self.reason, display.folded("evidence", display.table(rows)))

    def __reduce__(self) -> tuple[Any, ...]:  # a mapping proxy cannot be pickled
        return type(self), (self.kind, self.reason, self.k, dict(self.evidence))


KINDS = ("periodic", "quasi-periodic", "chaotic", "transient", "inconclusive")


def judge(
    points: Any, names: Sequence[str], *, exponent: float | None = None, error: float | None = None,
    units: Sequence[str] | None = None, driven: Sequence[str] = (), floor: float = 1e-6,
    sizes: Sequence[float] | None = None,
) -> Verdict:  # fmt: skip
    """The verdict on a motion from its successive section points.

    The first rule that applies decides:

    1. Periodic-k: in the last quarter, all points of each phase of k lie within 1e-4 of the spread of their signal, or
       within 10 `floor`; the shortest such k counts, at most 200 and a sixth of the points.  The cycle must be reached
       in the first tenth of the record, else the motion is transient.  With a negative exponent 1e-3 of the spread
       counts, because only noise keeps such points apart.
    2. Transient, approach: steps over k shrink from third to third of the record.
    3. Transient, drift: a signal changes by the same amount from point to point, exactly (a cycle may be on top) or in
       the means of sixteen blocks, of whose mean square a line explains 95 %.  An angle ("rad") counts modulo 2 pi, so
       a rotation drifts only if the record is shorter than a turn.
    4. Transient, growth: steps grow from third to third of the record, as in a linear instability.
       Transient, change: the means of the halves differ by more than the larger standard deviation, or the deviations
       by more than a factor 3 (of means and deviations or of medians and quartiles, the smaller result counts).  Or
       neighbours part in one half and stay together in the other.  Or a regular motion swells or shrinks from quarter
       to quarter, by more than 5 % in all.  Random walks, as of the action in a chaotic sea, are transient, too.
    5. Chaotic: the exponent lies above its error; K > 0.7 (0-1 test) or D > 0.5 (separation), and neither is regular.
       Without an exponent both must hold.  A second run must have an exponent above its error (`Exponents._agreed`).
    6. Inconclusive: bands double (2, 4, 8, ..., of 12 points each) as far as the record shows, each time with at most a
       fourth of the mean square.  Near an accumulation of period doublings the exponent is 0, and the points are a
       Cantor set, no closed curve.
    7. Quasi-periodic: the exponent is 0 within its error; K or D is regular (K < 0.3, D < 0.2), and neither is chaotic.
       Without an exponent both must be regular, or K < 0.7 and D < 0.05, because K needs some 200 points of a closed
       curve to come near 0.  An island of a conservative system is a closed curve, too.
    8. Inconclusive: all other records.  An exponent of 0 without a closed curve occurs in conservative systems, in
       which neighbours part like a power of time and the exponent falls as log(t) / t.

    D is the growth of the distance of nearest neighbours (points with their two successors) after up to n/5 steps,
    from 0 to 1 for the distance of arbitrary points of one band; NaN for noise.  K has lags up to n/4 and is taken of
    the points less the means of their bands.

    A signal that is zero at the section up to round-off (a velocity at a dead centre) can be distinguished from a
    small motion only by `units` or `sizes`.

    Equation (9.8) of docs/theory/exponents.md: the tolerance of a cycle.

    Parameters
    ----------
    points : successive points (n, m) of a stroboscopic or other section, of all signals, without the known transient;
        at least 12, 100 for quasi-periodic or chaotic, 50 for chaos with an exponent above 3 times its error.
    names : names (m,) of the signals.
    exponent : largest exponent, of the flow (zero for a periodic motion without drive) or of the section [any unit];
        None: unknown.
    error : half width of the exponent's band [same unit]; None: 0.
    units : units (m,) of the signals; "rad" is taken modulo 2 pi.  None: a signal that grows by whole turns is an
        angle.
    driven : names of the signals that drives prescribe; the verdict does not use them.
    floor : round-off or integration error of a signal over its size, > 0.
    sizes : sizes (m,) of the signals, such as their largest magnitudes over the run [units]; None: the largest
        magnitudes of the points, and at least 1e-3 of the largest of the same unit.

    Returns
    -------
    The verdict.  Its `evidence` holds, as far as they were computed, "points", "signals" (used), "k", "since",
    "shrink", "growth", "drift" (a point), "level" (difference of means over deviation), "loudness" (ratio of
    deviations), "swelling" (of quarters), "bands", "doublings", "zero_one" (K), "separation" (D), "exponent", "error".
    Points that are not finite make the verdict inconclusive.

    Raises
    ------
    InputError : points and names of different number, an unknown driven signal, an exponent that is no number.

    Notes
    -----
    Sources: G. A. Gottwald and I. Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129; H. Kantz, Phys. Lett. A 185
    (1994) 77 for the separation; J.-P. Eckmann, S. O. Kamphorst and D. Ruelle, Europhys. Lett. 4 (1987) 973.
    Cost: 0.1 s for 500 points of 4 signals.

    Examples
    --------
    >>> import flexmb as fm
    >>> print(fm.chaos.judge([[0.5], [0.8]] * 50, ["x"]))
    periodic-2
    """
    values, labels = points_of(points, names)
    without_motion = checks.sequence("judge", "driven", driven, "names of signals")
    for name in without_motion:
        checks.one_of("judge", "driven", name, labels)
    known = None if units is None else checks.sequence("judge", "units", units, "units")
    given = None if sizes is None else checks.sequence("judge", "sizes", sizes, "numbers")
    for what, listed in (("units", known), ("sizes", given)):
        if listed is not None and len(listed) != len(labels):
            raise InputError(f"judge: {len(listed)} {what} for {len(labels)} names.")
    largest = [checks.not_negative("judge", f"sizes[{k}]", size) for k, size in enumerate(given or ())]
    evidence: dict[str, float] = {"points": float(len(values))}
    value, band = (None if isinstance(x, Real) and np.isnan(float(x)) else x for x in (exponent, error))
    if value is not None:
        evidence["exponent"] = checks.number("judge", "exponent", value)
        evidence["error"] = 0.0 if band is None else checks.not_negative("judge", "error", band)
    floor = checks.positive("judge", "floor", floor)
    bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
    if len(bad):
        return Verdict("inconclusive", f"Point {bad[0]} is not finite: the run failed there.", 0, evidence)
    if np.abs(values).max(initial=0.0) > LARGEST:
        return Verdict("inconclusive", f"A signal is above {LARGEST:g}: the motion grows without bound.", 0, evidence)
    if len(values) < LEAST:
        return Verdict("inconclusive", f"{len(values)} points; at least {LEAST} are needed.", 0, evidence)
    columns = columns_of(values, labels, (known, without_motion, None if given is None else np.array(largest)), floor)
    evidence["signals"] = float(len(set(columns.names)))
    if not columns.names:
        text = f"Only driven signals ({', '.join(columns.left_out)}), without information. Give other signals."
        return Verdict("inconclusive", text, 0, evidence)
    return _periodic(columns, evidence) or _transient(columns, evidence) or _aperiodic(columns, evidence)


def _tolerances(columns: Columns, floors: float = 1.0, noise: float = 1.0) -> np.ndarray:
    return np.asarray(np.maximum(floors * columns.floor, noise * RELATIVE * columns.spread) + 1e-300)


def _periodic(columns: Columns, evidence: dict[str, float]) -> Verdict | None:
    noise = SEPARATE if _sign(evidence) < 0 else 1.0  # with a negative exponent only noise keeps points apart
    cycle = find_cycle(columns.values / _tolerances(columns, SEPARATE, noise))
    if cycle is None:
        return None
    (k, since), count = cycle, len(columns.values)
    evidence["k"], evidence["since"] = float(k), float(since)
    text = f"The points return after {k} step{'s' if k > 1 else ''}"
    if since > SETTLED * count:
        drifts = _drifts(columns, evidence)
        if drifts is not None:
            return drifts
        text += f", but only from point {since} of {count} on: leave out at least {since} more."
        return Verdict("transient", text, k, evidence)
    if _sign(evidence) > 0:
        text += f"; yet the exponent is {_band(evidence)}, above zero. The cycle is unstable, or the exponent wrong."
        return Verdict("inconclusive", text, k, evidence)
    text += f" from point {since} on." if since else "."
    return Verdict("periodic", text, k, evidence)


def _transient(columns: Columns, evidence: dict[str, float]) -> Verdict | None:
    tolerances, count = _tolerances(columns), len(columns.values)
    scaled = columns.values / tolerances
    spread = float(np.ptp(scaled, axis=0).max())
    approach = find_approach(scaled, spread) or find_approach(scaled[count // 2 :], spread)
    if approach is not None:
        k, rate, left = approach
        evidence["k"], evidence["shrink"] = float(k), rate
        text = f"The points still approach a {k}-cycle: steps shrink by {rate:.4g} a point"
        more = np.log(max(left, 1.0)) / -np.log(rate) if 0.0 < rate < 1.0 else np.inf
        advice = f"some {np.ceil(more):.0f} more points" if np.isfinite(more) else "more points"
        return Verdict("transient", f"{text}; leave out these and {advice}.", k, evidence)
    drifts = _drifts(columns, evidence)
    if drifts is not None:
        return drifts
    growth = find_approach(scaled[::-1], spread, longest=1)  # backwards growth is an approach
    if growth is not None and growth[1] > 0.0:
        evidence["growth"] = 1.0 / growth[1]
        text = f"The motion grows: steps from point to point become larger by {evidence['growth']:.4g} each"
        advice = "Neighbours part as in any unstable motion, which is no chaos: give it what bounds it"
        return Verdict("transient", f"{text}. {advice}, or take more points.", 0, evidence)
    level, loudness = halves_differ(columns.values, tolerances)
    evidence["level"], evidence["loudness"] = level, loudness
    if level <= 1.0 and loudness <= 3.0:
        return None
    text = f"The halves of the record differ: their means by {level:.2g} standard deviations, these by {loudness:.2g}"
    text += " times. Leave out more points, or take more"
    advice = "Leave out a signal that walks at random, or give it the unit rad if it counts modulo 2 pi"
    return Verdict("transient", f"{text}. {advice}." if _sign(evidence) > 0 else f"{text}.", 0, evidence)


def _drifts(columns: Columns, evidence: dict[str, float]) -> Verdict | None:
    """The verdict on points with a drift; None: no drift."""
    drift = find_drift(columns.values, _tolerances(columns))
    if drift is None:
        return None
    column, step, k = drift
    evidence["drift"], evidence["k"] = step, float(k)
    whole = step * (len(columns.values) - 1)
    text = f"{columns.names[column]} moves on by {step:.3g} a point, {whole:.3g} over the record"
    if k > 1:
        text += f", with a {k}-cycle on top"
    advice = "Leave out more points if the drift ends; if it goes on for ever, examine the rate of the signal instead"
    advice += "; give an angle the unit rad and enough points to come round"
    return Verdict("transient", f"{text}. {advice}.", k, evidence)


def _aperiodic(columns: Columns, evidence: dict[str, float]) -> Verdict:
    count = len(columns.values)
    clearly = evidence.get("exponent", 0.0) > CLEARLY * evidence.get("error", 0.0)
    if count < (LEAST_CHAOTIC if clearly else LEAST_APERIODIC):
        text = f"No cycle of up to {longest_cycle(count)} points. To tell more {LEAST_APERIODIC} are needed"
        return Verdict("inconclusive", f"{text}; there are {count}.", 0, evidence)
    clear = columns.spread > SEPARATE * columns.floor
    if not clear.any():
        text = f"The points differ by less than {SEPARATE:g} times the floor: a cycle with the integration's noise"
        return Verdict("inconclusive", f"{text}, or a motion too small to see. Integrate more finely.", 0, evidence)
    z = columns.values[:, clear]
    z = (z - z.mean(axis=0)) / z.std(axis=0)
    bands = band_count(z)
    deviations = without_bands(z, bands)[:, :: -(-z.shape[1] // MOST_SIGNALS)]
    angles = np.random.default_rng(0).uniform(np.pi / 5, 4 * np.pi / 5, 60)
    K = float(np.median([np.median(growth_correlations(column, angles, PART)) for column in deviations.T]))
    D = separation(z, bands)
    evidence.update(bands=float(bands), doublings=float(doublings(z)), zero_one=K, separation=D)
    return _changing(z, bands, evidence) or _aperiodic_kind(kind_of(K), kind_of(D, REGULAR, PARTED), evidence)


def _changing(z: np.ndarray, bands: int, evidence: dict[str, float]) -> Verdict | None:
    """The verdict on points (n, m) whose kind or amplitude changes within the record; None: no change."""
    half = len(z) // 2
    if half >= LEAST_APERIODIC:
        kinds = [kind_of(separation(points, bands), REGULAR, PARTED) for points in (z[:half], z[half:])]
        if set(kinds) == {"regular", "chaotic"}:
            text = f"The first half of the record is {kinds[0]}, the second {kinds[1]}. Leave out more points."
            return Verdict("transient", text, 0, evidence)
    # Ratio of the deviations of the first and last quarter that grow or shrink all along; else 1.
    deviations = np.stack([quarter.std(axis=0) for quarter in np.array_split(z, 4)])
    steps = np.diff(deviations, axis=0)
    trend = ((steps > 0.0).all(axis=0) | (steps < 0.0).all(axis=0)) & (deviations > 0.0).all(axis=0)
    ratio = np.where(trend, deviations[-1] / np.where(deviations[0] > 0.0, deviations[0], 1.0), 1.0)
    evidence["swelling"] = swelling = float(np.maximum(ratio, 1.0 / np.where(ratio > 0.0, ratio, 1.0)).max())
    if evidence["zero_one"] < CHAOTIC and evidence["separation"] < REGULAR and swelling > 1.05:
        text = f"A regular motion whose amplitude changes by a factor {swelling:.3g} from first to last quarter."
        return Verdict("transient", f"{text} Leave out more points, or take more.", 0, evidence)
    return None


def _aperiodic_kind(zero_one: str, neighbours: str, evidence: dict[str, float]) -> Verdict:
    """The verdict on points without cycle and without transient, from exponent, 0-1 test and separation."""
    kinds, sign = {zero_one, neighbours}, _sign(evidence)
    D = evidence["separation"]
    distance = f"separation {D:.2f} ({neighbours})" if np.isfinite(D) else "too few points to find neighbours"
    values = f"0-1 test {evidence['zero_one']:.2f} ({zero_one}), {distance}"
    if "exponent" in evidence:
        values = f"exponent {_band(evidence)}, {values}"
        chaotic = sign > 0 and "chaotic" in kinds and "regular" not in kinds
        closed = sign == 0 and "regular" in kinds and "chaotic" not in kinds
    else:
        together = zero_one != "chaotic" and evidence["separation"] < TOGETHER
        chaotic, closed = kinds == {"chaotic"}, kinds == {"regular"} or together
    if chaotic:
        return Verdict("chaotic", f"No cycle, and neighbours part: {values}.", 0, evidence)
    if evidence["doublings"]:
        text = f"Bands double repeatedly, up to {2 ** evidence['doublings']:.0f} bands: {values}"
        advice = "At or near a point where period doublings accumulate, chaos and long cycles look alike"
        return Verdict("inconclusive", f"{text}. {advice}: take more points, or another parameter.", 0, evidence)
    if closed:
        return Verdict("quasi-periodic", f"No cycle, and neighbours stay together: {values}.", 0, evidence)
    if sign < 0:
        text = f"No cycle of up to {longest_cycle(int(evidence['points']))} points, yet a negative exponent: {values}."
        return Verdict("inconclusive", f"{text} A longer cycle, or one not reached yet: take more points.", 0, evidence)
    if "exponent" in evidence and sign == 0:
        text = f"An exponent of zero, but no closed curve is seen: {values}. Neighbours part like a power of time"
        text += ", as in a conservative system, which a finite record does not decide; or chaos is too weak"
        return Verdict("inconclusive", f"{text} to be detected yet: take more points.", 0, evidence)
    advice = "Take more points" + ("" if "exponent" in evidence else ", or give the exponent of the system")
    return Verdict("inconclusive", f"The tests do not agree: {values}. {advice}.", 0, evidence)


def _sign(evidence: Mapping[str, float]) -> int:
    """Sign of the exponent: 1, 0 or -1 above, within or below its error about zero; 0 if the exponent is unknown."""
    value, error = evidence.get("exponent", 0.0), evidence.get("error", 0.0)
    return int(value > error) - int(value < -error)


def _band(evidence: Mapping[str, float]) -> str:
    return f"{evidence['exponent']:.3g} +- {evidence['error']:.2g}"
