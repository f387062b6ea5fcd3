"""Two codes on the same model, timed in turn in one process: A, B, A, B, ... so that a busy machine slows both.

What is timed is the motion alone, model built and start values known: for flexmb what `simulate` reports, which
contains energies, contact episodes, largest values of all signals and the making of the solution; for the peer its
`SolveDynamic` without sensors or files.  Accuracy comes from one more run of each.  Times are CPU times of the process,
one thread each: on a quiet machine those of the clock, on a busy one without what other work takes.
"""

import datetime
import gc
import importlib.metadata
import json
import math
import os
import platform
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from statistics import median

RECORDS = Path(__file__).resolve().parents[2] / "out" / "speed"
PAIRS = int(os.environ.get("FLEXMB_SPEED_PAIRS", "5"))
"""Rounds at least; of short runs so many more that SPENT seconds are spent, at most MOST times as many."""
SPENT, MOST = 10.0, 5
TORQUE = "torque [N m]"
"""The value that `spikes` is about."""
ALIKE = 1.05
"""Errors that differ by less count as the same."""


@dataclass(frozen=True)
class Runner:
    """One code with one setting.

    once : runs and returns the time [s].
    values : runs and returns what came out; "error" is what rows compare.
    """

    code: str
    label: str
    once: Callable[[], float]
    values: Callable[[], dict[str, float]]


@dataclass(frozen=True)
class Wish:
    """That our runner (None: the fastest one whose error is no larger than the peer's) be so many times faster."""

    theirs: str
    factor: float
    ours: str | None = None
    why: str = ""


@dataclass(frozen=True)
class Row:
    """A model: its runners, made when it is measured, and what the ratio ought to be."""

    name: str
    title: str
    error: str
    make: Callable[[], list[Runner]]
    wishes: tuple[Wish, ...]
    reference: str = ""
    note: str = ""
    ceiling: float = math.inf  # our error in a wish with `ours` may not be larger
    spikes: float = math.inf  # nor our largest torque [N m]
    cores: tuple[str, str, float] | None = None  # our runners on one core and on two, and how many times faster


COUNTING = "counting"  # code of runners that only count, beside those on one core and on two


@dataclass
class Timing:
    """Times of a runner [s], in the order of the rounds, and its values."""

    code: str
    label: str
    times: list[float] = field(default_factory=list)
    values: dict[str, float] = field(default_factory=dict)
    failure: str = ""

    @property
    def middle(self) -> float:
        """Median [s]."""
        return median(self.times) if self.times else math.nan

    @property
    def error(self) -> float:
        """The error that rows compare."""
        return self.values.get("error", math.nan)


@dataclass
class Verdict:
    """A wish against the times: ratio of medians, smallest and largest ratio of a round."""

    ours: str
    theirs: str
    factor: float
    ratio: float = math.nan
    low: float = math.nan
    high: float = math.nan
    our_error: float = math.nan
    their_error: float = math.nan
    why: str = ""
    complaint: str = ""

    @property
    def holds(self) -> bool:
        """Whether the wish is fulfilled."""
        return not self.complaint

    def __str__(self) -> str:
        """One line with the numbers."""
        span = f"{self.ratio:.2f} x ({self.low:.2f} to {self.high:.2f}), wanted {self.factor:g} x"
        errors = f"errors {self.our_error:.2g} and {self.their_error:.2g}"
        text = f"{self.ours} against {self.theirs}: {span}; {errors}"
        return f"{text}: {self.complaint}" if self.complaint else text


def measured(row: Row, pairs: int = PAIRS) -> dict:
    """Time all runners of a row in turn, at least `pairs` rounds; the record is kept in out/speed."""
    timings, rounds = timed(row.make(), pairs)
    verdicts = [verdict(row, wish, timings) for wish in row.wishes]
    if row.cores:
        verdicts.append(_on_two_cores(row, timings))
    record = {
        "name": row.name,
        "title": row.title,
        "error": row.error,
        "reference": row.reference,
        "note": row.note,
        "spikes": None if row.spikes == math.inf else row.spikes,
        "rounds": rounds,
        "timings": [asdict(t) for t in timings],
        "verdicts": [asdict(v) for v in verdicts],
    }
    keep(row.name, record)
    return record


def timed(runners: list[Runner], pairs: int) -> tuple[list[Timing], int]:
    """Values and times of these runners, and the number of rounds."""
    timings = [Timing(r.code, r.label) for r in runners]
    for runner, timing in zip(runners, timings, strict=True):
        _guarded(timing, lambda timing=timing, runner=runner: timing.values.update(runner.values()))
    began, rounds = time.perf_counter(), 0
    while rounds < pairs or (rounds < MOST * pairs and time.perf_counter() - began < SPENT):
        rounds += 1
        for runner, timing in zip(runners, timings, strict=True):
            gc.collect()
            if not timing.failure:
                _guarded(timing, lambda timing=timing, runner=runner: timing.times.append(runner.once()))
    return timings, rounds


def _guarded(timing: Timing, call: Callable[[], object]) -> None:
    """Call; a runner that gives up is noted with what it said, and left out from then on."""
    try:
        call()
    except GaveUp as error:
        timing.failure = str(error)[:200]


class GaveUp(Exception):
    """A run did not reach its end."""


def verdict(row: Row, wish: Wish, timings: list[Timing]) -> Verdict:
    """A wish against the times."""
    theirs = next(t for t in timings if (t.code, t.label) == ("Exudyn", wish.theirs))
    by_clock = row.cores or ()  # where processes are compared, the time is not that of the CPU
    ours = _chosen(wish, [t for t in timings if t.code == "flexmb" and t.label not in by_clock], theirs)
    found = Verdict("-" if ours is None else ours.label, theirs.label, wish.factor, why=wish.why)
    if theirs.failure:
        found.complaint = f"the peer gave up: {theirs.failure}"
        return found
    if ours is None:
        found.their_error = theirs.error
        found.complaint = "none of our settings is as accurate"
        return found
    rounds = [b / a for a, b in zip(ours.times, theirs.times, strict=False)]
    found.ratio, found.low, found.high = theirs.middle / ours.middle, min(rounds), max(rounds)
    found.our_error, found.their_error = ours.error, theirs.error
    complaints = [ours.failure] if ours.failure else []
    if found.ratio < wish.factor:
        complaints.append(f"{found.ratio:.2f} x is less than {wish.factor:g} x")
    if wish.ours is not None and found.our_error > row.ceiling:
        complaints.append(f"our error of {found.our_error:.2g} is above {row.ceiling:g}")
    if ours.values.get(TORQUE, 0.0) > row.spikes:
        complaints.append(f"our largest torque of {ours.values[TORQUE]:.4g} N m is a false peak")
    found.complaint = "; ".join(complaints)
    return found


def _on_two_cores(row: Row, timings: list[Timing]) -> Verdict:
    """Our one process against our two."""
    one, two, factor = row.cores
    slow, fast = (next(t for t in timings if (t.code, t.label) == ("flexmb", label)) for label in (one, two))
    alone, both = (next(t for t in timings if (t.code, t.label) == (COUNTING, label)) for label in (one, two))
    counted = alone.middle / both.middle  # what two cores gain at most, here and now
    factor = round(min(factor, counted), 2)
    rounds = [a / b for a, b in zip(slow.times, fast.times, strict=True)]
    found = Verdict(two, f"flexmb, {one}", factor, slow.middle / fast.middle, min(rounds), max(rounds))
    found.our_error, found.their_error, found.why = (
        fast.error,
        slow.error,
        f"{os.cpu_count()} cores, counting {counted:.2f} x",
    )
    if found.ratio < factor:
        found.complaint = f"{found.ratio:.2f} x is less than {factor:g} x"
    return found


def _chosen(wish: Wish, ours: list[Timing], theirs: Timing) -> Timing | None:
    """Our runner that a wish is about."""
    if wish.ours is not None:
        return next(t for t in ours if t.label == wish.ours)
    good = [t for t in ours if not t.failure and _as_accurate(t.values, theirs.values)]
    return min(good, key=lambda t: t.middle, default=None)


def _as_accurate(ours: dict[str, float], theirs: dict[str, float]) -> bool:
    """Whether none of our errors (a row may have several: their names begin with "error") is larger than theirs."""
    return all(ours.get(name, math.inf) <= ALIKE * v for name, v in theirs.items() if name.startswith("error"))


def keep(name: str, record: dict) -> None:
    """Write a record to out/speed, for docs/performance.py."""
    RECORDS.mkdir(parents=True, exist_ok=True)
    record["where"] = stamp()
    (RECORDS / f"{name}.json").write_text(json.dumps(record, indent=1, default=float) + "\n", encoding="utf-8")


def stamp() -> dict[str, str]:
    """Date, machine, versions, and how busy the machine was."""
    listed = Path("/proc/cpuinfo")
    text = listed.read_text(encoding="utf-8") if listed.is_file() else ""
    names = [line.partition(":")[2].strip() for line in text.splitlines() if line.startswith("model name")]
    versions = []
    for package in ("exudyn", "numpy", "scipy", "numba", "flexmb"):
        try:
            versions.append(f"{package} {importlib.metadata.version(package)}")
        except importlib.metadata.PackageNotFoundError:
            versions.append(f"{package} (not installed)" if package == "exudyn" else f"{package} (from its sources)")
    return {
        "date": f"{datetime.datetime.now(datetime.UTC):%Y-%m-%d}",
        "machine": f"{names[0] if names else platform.machine()}, {os.cpu_count()} cores, {platform.system()}",
        "versions": f"Python {platform.python_version()}, {', '.join(versions)}",
        "load": f"{os.getloadavg()[0]:.1f}" if os.name == "posix" else "-",
    }


def lines(record: dict) -> Iterator[str]:
    """A record for people."""
    yield f"{record['title']}  [{record['rounds']} rounds; error: {record['error']}]"
    for t in (Timing(**one) for one in record["timings"]):
        if t.failure:
            yield f"  {t.code:7s} {t.label:34s} gave up: {t.failure}"
            continue
        values = ", ".join(f"{k} {v:.6g}" for k, v in t.values.items())
        yield f"  {t.code:7s} {t.label:34s} {1e3 * t.middle:10.2f} ms  {values}"
    for v in (Verdict(**one) for one in record["verdicts"]):
        yield f"  {'ok' if v.holds else 'NOT'}: {v}"
