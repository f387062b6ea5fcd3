"""Basins of attraction over a grid of start values, and the attractors found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from numbers import Integral
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.jobs.executors import Chain, Job, Outcome, drive, require_executor
from flexmb.dynamics.orbits.shooting import Shooting, StateSpace
from flexmb.dynamics.systems.dynamics import Dynamics, Period, as_dynamics
from flexmb.errors import AssemblyError, InputError, SolveError
from flexmb.fields import field, record_with
from flexmb.late import xr

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism

KEPT = 128  # number of section points that represent an attractor without repetition
CLOSE = 0.1  # distance of two sets of points without repetition, over their size, below which they are one attractor
SAME = 1e-6  # difference of two rounds, over the tolerance, below which they are equal
LOST, UNDECIDED = -1, 0  # numbers of motions that ended, and of motions whose attractor is unknown


@dataclass(frozen=True)
class Rules:
    """Limits and tolerances of the observation of motions; see `basin`."""

    base: float  # period [s, or iterations]
    origin: float  # start time of the motions
    settle: int  # number of periods between two judgements, and largest number of periods
    longest: int
    repeats: int  # largest number of periods after which an attractor repeats itself
    close: float  # distance of two states below which they are equal
    bound: float  # length of a state above which a motion is lost
    space: StateSpace  # differences of states

    def away(self, points: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Distances (n,) of points (n, size) from one other point or from as many others, without whole turns."""
        d = self.space.difference(points, other)
        return np.asarray(np.sqrt((d * d) @ self.space.weights))


# Points that represent a motion, its number of periods until repetition (0: none, -1: lost), and periods computed.
Track = tuple[np.ndarray, int, int]


def tracks_of(system: Dynamics, starts: np.ndarray, rules: Rules) -> Outcome:
    """Tracks of the motions from start states (n, size); the system is advanced.  Called in the workers."""
    return Outcome({"tracks": [_track(system, start, rules) for start in starts]})


def _track(system: Dynamics, start: np.ndarray, rules: Rules) -> Track:
    """Observe one motion until it repeats itself, ends, or reaches the largest number of periods."""
    # It is judged every `settle` periods. A repetition counts if it is still there at the next judgement, because
    # motions near an unstable orbit seem to repeat themselves for a while.
    nothing = start[None, :][:0]
    try:
        system.reset(start, time=rules.origin)
    except (AssemblyError, SolveError):
        return nothing, LOST, 0
    step = rules.base if system.unit == "s" else round(rules.base)
    points: list[np.ndarray] = [system.state()]
    repetition, since = 0, 0  # periods of a repetition at the last judgement, and the time of that judgement
    for n in range(1, rules.longest + 1):
        if not system.advance(step):
            return nothing, LOST, n
        points.append(system.state())
        if not rules.away(points[-1][None], np.zeros(len(start)))[0] <= rules.bound:
            return nothing, LOST, n
        if n % rules.settle:
            continue
        again = points[n - (n - since) % repetition][None, :] if repetition else None
        if again is not None and rules.away(again, points[since])[0] <= 2.0 * rules.close:
            return np.array(points[-repetition:]), repetition, since
        # The number of periods after which the points return; 0: no return, or points still far from their limit.
        # Rounds that differ by d1, and by d0 the time before, are d1 r/(1 - r), r = d1/d0, from their limit.
        last, repetition, since = np.array(points[-3 * rules.repeats :]), 0, n
        back = rules.away(last[:-1][::-1], last[-1])
        for k in (k for k in range(1, len(last) // 3 + 1) if not back[k - 1] > rules.close):
            now, before, first = last[-k:], last[-2 * k : -k], last[-3 * k : -2 * k]
            d1, d0 = (float(rules.away(*pair).max()) for pair in ((now, before), (before, first)))
            if d1 <= SAME * rules.close or (d1 < d0 and d1 * d1 <= rules.close * (d0 - d1)):
                nearer = (m for m in range(1, k) if k % m == 0)  # a spiral comes nearer to itself after some turns
                away = ((m, rules.away(now, last[-k - m : -m]).max()) for m in nearer)
                repetition = next((m for m, d in away if d <= 3.0 * rules.close), k)
                break
    return np.array(points[-KEPT:]), 0, rules.longest


def matched_attractors(tracks: list[Track], rules: Rules) -> tuple[np.ndarray, tuple[np.ndarray, ...], tuple[int, ...]]:
    """Numbers of the attractors of all motions, by their points and periods; points and periods of the attractors."""
    number = np.zeros(len(tracks), dtype=np.int64)
    known: list[tuple[np.ndarray, int]] = []
    for i, (points, k, _) in enumerate(tracks):
        if k == LOST:
            number[i] = LOST
            continue
        if k == 0 and not _same(points[: len(points) // 2], points[len(points) // 2 :], 0, rules):
            continue  # a transient
        for j, (other, again) in enumerate(known):
            if again == k and _same(points, other, k, rules):
                number[i] = j + 1
                break
        else:
            known.append((points, k))
            number[i] = len(known)
    return number, tuple(points for points, _ in known), tuple(k for _, k in known)


def _same(points: np.ndarray, other: np.ndarray, repeats: int, rules: Rules) -> bool:
    """Whether two motions are on one attractor: the points of each lie near points of the other."""
    table = np.array([rules.away(other, p) for p in points])
    if repeats:
        return bool(max(table.min(axis=1).max(), table.min(axis=0).max()) <= 10.0 * rules.close)
    size = min(float(np.sqrt(((s - s.mean(axis=0)) ** 2 @ rules.space.weights).max())) for s in (points, other))
    return bool(max(np.median(table.min(axis=1)), np.median(table.min(axis=0))) <= CLOSE * size)


LABEL = "basin"
CHUNKS = 4  # number of pieces of work for each worker
Axis = tuple[str | int, Sequence[float] | np.ndarray]


@record_with(eq=False, kw_only=True)
class Basin:
    """The attractor of the motion from each point of a grid of states."""

    name: str = field("name of the system")
    axes: tuple[str, str] = field("names of the two entries of the state")
    units: tuple[str, str] = field('units of the axes, "" if unknown')
    places: tuple[int, int] = field("indices of the axes in the state")
    x: np.ndarray = field("values (nx,) of the first axis")
    y: np.ndarray = field("values (ny,) of the second axis")
    number: np.ndarray = field(
        "number (ny, nx) of the attractor, from 1 on; 0: undecided in the time given; -1: lost (a state that is not "
        "finite or out of bounds, or failed steps)"
    )
    attractors: tuple[np.ndarray, ...] = field("section points (k, size) of each attractor, in the order of the motion")
    periods: tuple[int, ...] = field("periods until each attractor repeats; 0: quasi-periodic or chaotic")
    taken: np.ndarray = field("number (ny, nx) of periods until the repetition was found, or of all periods")
    status: str = field("result in a sentence")

    @property
    def fractions(self) -> dict[int, float]:
        """Fraction of the grid by number of the attractor, with lost (-1) and undecided (0) motions."""
        numbers = [*np.unique(self.number[self.number <= UNDECIDED]).tolist(), *range(1, len(self.attractors) + 1)]
        return {k: float(np.mean(self.number == k)) for k in numbers}

    def to_dataset(self) -> xr.Dataset:
        """Numbers and periods over both axes; points of the attractors over "attractor", "point" and "coordinate"."""
        longest = max((len(a) for a in self.attractors), default=0)
        points = np.full((len(self.attractors), longest, self.attractors[0].shape[1] if self.attractors else 0), np.nan)
        for table, attractor in zip(points, self.attractors, strict=True):
            table[: len(attractor)] = attractor
        (a, b), (ua, ub) = self.axes, self.units
        flags = {"long_name": "attractor; 0: undecided, -1: lost"}
        axes = {a: (a, self.x, {"units": ua}), b: (b, self.y, {"units": ub})}
        data = {
            "number": ((b, a), self.number, flags),
            "taken": ((b, a), self.taken, {"units": "periods"}),
            "points": (("attractor", "point", "coordinate"), points),
            "repeats": ("attractor", np.array(self.periods, dtype=np.int64)),
        }
        numbers = {"attractor": np.arange(1, len(self.attractors) + 1)}
        return xr.Dataset(data, {**axes, **numbers}, {"name": self.name, "status": self.status})

    def __repr__(self) -> str:
        fractions = ", ".join(f"{k}: {100.0 * f:.1f} %" for k, f in self.fractions.items())
        return f"Basin of {self.name!r} over {self.axes[0]} and {self.axes[1]}, {fractions}. {self.status}"


def basin(
    system: Dynamics | Mechanism, x: Axis, y: Axis, *, period: Period = None, settle: int = 20, longest: int = 500,
    repeats: int = 16, tolerance: float = 1e-4, bound: float = 1e3, angles: Sequence[str] = (),
    executor: Executor | int | None = None, workers: int = 1,
) -> Basin:  # fmt: skip
    """Basins of attraction over two entries of the state; the other entries keep their present values.

    The motion from each point of the grid is observed once a period.  A motion is on an attractor when its section
    points repeat themselves.  Attractors without repetition are recognised by their last 128 points.

    Parameters
    ----------
    system : a flow, a map, or a mechanism; it is not changed.
    x, y : pairs (name, values) of the two entries: names of the signals if these are the state; names of coordinates
        ("crank.theta") and velocities ("crank.omega", "slider.vx") of a mechanism; or an index in the state.
    period : period of the drives [s], see `periodic_orbit`; any time for a flow without a drive.
    settle : number of periods before the first judgement, and between judgements.
    longest : largest number of periods; then a motion without repetition is judged by its last points.
    repeats : largest number of periods after which a motion can repeat itself.
    tolerance : tolerance of repetitions and of equal attractors, over the size of the grid.
    bound : distance from 0, in sizes of the grid, beyond which a motion is lost; angles count without whole turns.
    angles : names of state entries that count modulo 2 pi; the angles of a mechanism are known.
    executor : a number of threads of this process, or an executor of `concurrent.futures`, for chunks of the grid; the
        system must be picklable for other executors than threads.
    workers : number of chunks that run at once on an executor; threads are counted.

    Raises
    ------
    InputError : unknown names, an empty axis, numbers out of range, a flow without period.
    SolveError : a part of the grid that failed on the executor.
    WorkerError : workers that died.

    Notes
    -----
    The result does not depend on the executor: motions are independent, and are compared at the end.  Attractors are
    numbered in the order of the grid.  Recurrence as the mark of an attractor: G. Datseris, A. Wagemakers, Chaos 32
    (2022) 023104.

    Examples
    --------
    >>> import numpy as np
    >>> import flexmb as fm
    >>> newton = fm.chaos.Map(lambda z: z / 2 + z / (2 * (z @ z)) * [1, -1], [1.0, 0.2], name="square root of 1")
    >>> found = fm.chaos.basin(newton, ("x0", [-2.0, -1.0, 1.0, 2.0]), ("x1", [-0.5, 0.5]))
    >>> found.number.tolist(), [a.round(6).tolist() for a in found.attractors]
    ([[1, 1, 2, 2], [1, 1, 2, 2]], [[[-1.0, 0.0]], [[1.0, 0.0]]])
    """
    moved = as_dynamics(LABEL, system, wanted="a flow or map (Map, MechanismFlow) or a Mechanism")
    require_executor(LABEL, executor)
    (a, ax, ua, xs), (b, by, ub, ys) = (_place(moved, axis, which) for axis, which in ((x, "x"), (y, "y")))
    if a == b:
        raise InputError(f"{LABEL}: x and y are both {ax!r}; they must be two numbers of the state.")
    starts = np.tile(moved.state(), (len(ys) * len(xs), 1))
    starts[:, a], starts[:, b] = np.tile(xs, len(ys)), np.repeat(ys, len(xs))
    limits = {"settle": settle, "longest": longest, "repeats": repeats}
    rules = _rules(Shooting(LABEL, moved, period=period, angles=tuple(angles)), starts, tolerance, bound, limits)
    if executor is None:
        found: list[list[Track]] = [tracks_of(moved.copy(), starts, rules).values["tracks"]]
    else:
        at_once = int(executor) if isinstance(executor, Integral) else workers
        chunks = np.array_split(starts, min(CHUNKS * at_once, len(starts)))
        found = [[] for _ in chunks]

        def chain(chunk: np.ndarray, part: list[Track]) -> Chain:
            outcome = yield Job(tracks_of, (moved.copy(), chunk, rules))
            if not outcome.ok:
                raise SolveError(f"{LABEL}: a part of the grid failed: {outcome.status}")
            part += outcome.values["tracks"]

        drive(map(chain, chunks, found), executor, LABEL)
    tracks = [track for part in found for track in part]
    number, attractors, periods = matched_attractors(tracks, rules)
    taken = np.array([n for _, _, n in tracks], dtype=np.int64).reshape(len(ys), len(xs))
    lost, open_ = int(np.sum(number == LOST)), int(np.sum(number == UNDECIDED))
    status = f"{len(attractors)} attractors; {lost} motions were lost, {open_} are undecided."
    return Basin(
        name=moved.name, axes=(ax, by), units=(ua, ub), places=(a, b), x=xs, y=ys, number=number.reshape(taken.shape),
        attractors=attractors, periods=periods, taken=taken, status=status,
    )  # fmt: skip


def _place(system: Dynamics, axis: Any, which: str) -> tuple[int, str, str, np.ndarray]:
    """Index in the state, name, unit and values of an axis."""
    if not isinstance(axis, (tuple, list)) or len(axis) != 2:
        raise InputError(f"{LABEL}: {which} is {axis!r}; it must be a pair (name, values).")
    name, values = axis
    try:
        grid = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{LABEL}: the values of {which} are {values!r}; they must be numbers.") from None
    if grid.ndim != 1 or len(grid) == 0 or not np.isfinite(grid).all():
        text = f"{LABEL}: the values of {which} have shape {grid.shape};"
        raise InputError(f"{text} they must be a list of finite numbers.")
    known = system.state_names
    if isinstance(name, str):
        place = known[checks.one_of(LABEL, which, name, known)]
    else:
        place = checks.count(LABEL, which, name, 0)
        if place >= system.size:
            raise InputError(f"{LABEL}: {which} is {place}; the state has the numbers 0 to {system.size - 1}.")
        name = next((key for key, at in known.items() if at == place), f"state[{place}]")
    return place, name, dict(zip(system.names, system.units, strict=True)).get(name, ""), grid


def _rules(passes: Shooting, starts: np.ndarray, tolerance: float, bound: float, limits: Mapping[str, int]) -> Rules:
    counts: dict[str, Any] = {name: checks.count(LABEL, name, value) for name, value in limits.items()}
    if counts["longest"] <= counts["settle"]:
        raise InputError(f"{LABEL}: longest is {counts['longest']}; it must be above settle, {counts['settle']}.")
    weights = passes.space.weights
    size = float(np.sqrt(((starts - starts.mean(axis=0)) ** 2 @ weights).max()))
    size = size or float(np.sqrt((starts**2 @ weights).max())) or 1.0
    tolerance = checks.positive(LABEL, "tolerance", tolerance)
    reach = checks.positive(LABEL, "bound", bound) * max(size, float(np.sqrt((starts**2 @ weights).max())))
    return Rules(passes.base, passes.origin, **counts, close=tolerance * size, bound=reach, space=passes.space)
