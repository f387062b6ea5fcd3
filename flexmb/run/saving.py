"""Saved instants of a run, their rows, and peaks over all steps."""

from __future__ import annotations

import math
from collections.abc import Iterable
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from flexmb import checks
from flexmb.engine.state.record import OF_PEAK, PLACE
from flexmb.errors import InputError
from flexmb.results.solution import Peaks

if TYPE_CHECKING:
    from flexmb.engine.state.record import RunRecord
    from flexmb.run.run import Run

SAME_TIME = 1e-12  # difference of two instants relative to the end of a run, below which they are one
SAME_INSTANT = 1e-9  # difference of two saved instants relative to the time between them, below which they are one


class SaveGrid(NamedTuple):
    """Saved instants: interval, or shortest time between given times [s], 0 for every step; given times (n,) [s]."""

    interval: float
    times: np.ndarray


def save_grid(label: str, save: Any, period: float | None, begin: float, end: float, begun: float = 0.0) -> SaveGrid:
    """Saved instants from `begin` to `end` [s] for the argument `save` of `simulate`; the run starts at `begun`."""
    # A number of instants counts from `begin`, so that a run that is restarted goes on with the instants of the first.
    none = np.zeros(0)
    if isinstance(save, str) and save == "steps":
        return SaveGrid(0.0, none)
    if isinstance(save, str):
        raise InputError(f"{label}: save is {save!r}; it must be a number of instants, an interval [s] or 'steps'.")
    if isinstance(save, Iterable) and np.ndim(save):  # type: ignore[arg-type] # arrays without dimensions are numbers
        given, first = checks.sequence(label, "save", save, "times [s]"), max(begin, begun)
        times = np.array([checks.number(label, f"save[{k}]", t, "s") for k, t in enumerate(given)])
        gaps, slack = np.diff(times), SAME_TIME * end
        if not len(times):
            raise InputError(f"{label}: save holds no times; give some, or save no signals: signals=[].")
        if (gaps <= 0.0).any():
            k = int(np.argmin(gaps)) + 1
            raise InputError(f"{label}: save[{k}] is {times[k]:g} s after {times[k - 1]:g} s; times must increase.")
        for wrong in times[(times < first - slack) | (times > end + slack)]:
            raise InputError(f"{label}: save holds {wrong:g} s; its times must lie from {first:g} to {end:g} s.")
        return SaveGrid(float(gaps.min(initial=end - first)), np.clip(times, first, end))
    if isinstance(save, Real) and not isinstance(save, Integral):
        interval = checks.positive(label, "save", save, "s", "An interval of time; instants a period are an integer.")
        if interval > (span := end - max(begin, begun)):
            text = f"{label}: save is an interval of {interval:g} s, but {span:g} s are saved"
            raise InputError(f"{text}. Give a shorter one, or an integer: the number of saved instants a period.")
        return SaveGrid(interval, none)
    hint = "It is a number of instants a period of the drives (without one: of the run), an interval [s] (a float), "
    number = checks.count(label, "save", save, hint=f"{hint}times [s] (a list), or 'steps' for all.")
    return SaveGrid((end - begin if period is None or period > end - begin else period) / number, none)


def start_saving(run: Run, saving: float) -> None:
    """Save the present instant, or continue the save grid of a resumed run; `saving`: its interval [s]."""
    clock, times, run.saving = run.flow.clock, run.record.save_times, True
    fresh = bool(clock.save_start < 0.0)
    clock.save_start = clock.t if fresh else clock.save_start
    if len(times):
        clock.saved_instants = float(np.searchsorted(times, clock.t + SAME_INSTANT * saving, "right"))
        fresh = run.saved.count == 0 and abs(times[0] - clock.t) <= SAME_INSTANT * saving
    elif saving > 0.0:  # counted anew, since the interval may be another one
        clock.saved_instants = np.floor((clock.t - clock.save_start) / saving + SAME_INSTANT)
    if fresh:
        run.saved.add_one(clock.t, run.record.signals)


def saves_end(run: Run, end: float) -> bool:
    """Whether the last instant is saved: always with a grid, of given times if its time `end` [s] is the last."""
    times = run.record.save_times
    return len(times) == 0 or (not run.met and bool(times[-1] == end))


# Saved rows of a run in one growing array, filled from the buffer of the loop

SURE_SIZE = 1e6  # size of saved rows up to which no memory is asked for [bytes]
LARGEST_SHARE = 0.8  # share of the memory for saved rows; a system promises more than it has and then ends the process


def free_memory() -> float:
    """Memory that the system can still give [bytes]; inf where it does not tell."""
    told = Path("/proc/meminfo")
    words = told.read_text(encoding="ascii").partition("MemAvailable:")[2].split() if told.is_file() else []
    return 1024.0 * float(words[0]) if words else math.inf


class SavedRows:
    """Saved instants and their signals; `kept`: places (columns,) of these among all signals, None for all."""

    def __init__(self, columns: int, kept: np.ndarray | None = None) -> None:
        self.kept, self.columns, self.count = kept, columns, 0
        self._times, self._values = np.empty(0), np.empty((0, columns))

    def require_room(self, label: str, rows: float) -> None:
        """Refuse a number of rows for which there is no memory; `label`: first words of the error."""
        try:
            np.empty((int(min(rows, 1e15)), self.columns + 1))
        except (MemoryError, ValueError) as error:  # ValueError: more than any array may have
            text = f"{label}: save asks for {rows:.3g} instants of {self.columns} signals"
            size = f"{8e-9 * rows * self.columns:.3g} GB"
            raise InputError(f"{text}, {size}. Save fewer instants, or fewer signals: signals=[...].") from error

    def add(self, times: np.ndarray, values: np.ndarray) -> None:
        """Append rows (n, columns) at times (n,); `MemoryError` where the machine has no room for them."""
        end = self.count + len(times)
        if end > len(self._times):
            size = 8 * self.columns + 8
            most = LARGEST_SHARE * (self.count + free_memory() / size) if end * size > SURE_SIZE else math.inf
            if end > most:
                raise MemoryError
            self._resize(int(min(max(end, self.count + self.count // 2), most)))
        self._times[self.count : end], self._values[self.count : end], self.count = times, values, end

    def add_one(self, time: float, signals: np.ndarray) -> None:
        """Append one row, of all signals (n_y,)."""
        self.add(np.array([time]), self._chosen(signals)[None, :])

    def is_at(self, time: float, tolerance: float) -> bool:
        """Whether the last row is of that time [s]."""
        return self.count > 0 and abs(float(self._times[self.count - 1]) - time) <= tolerance

    def replace_last(self, signals: np.ndarray) -> None:
        """Replace the last row by other signals (n_y,)."""
        self._values[self.count - 1] = self._chosen(signals)

    def shorten(self, rows: int) -> None:
        """Keep the first `rows` rows alone."""
        self.count = min(self.count, rows)

    def finished(self) -> tuple[np.ndarray, np.ndarray]:
        """Times (n,) and values (n, columns), read-only."""
        self._resize(self.count)
        for array in (self._times, self._values):
            array.setflags(write=False)
        return self._times, self._values

    def _chosen(self, signals: np.ndarray) -> np.ndarray:
        return signals if self.kept is None else signals[self.kept]

    def _resize(self, rows: int) -> None:
        if rows == len(self._times):
            return
        if not self._times.flags.writeable:  # what was handed out stays as it is
            self._times, self._values = self._times.copy(), self._values.copy()
        for array, shape in ((self._times, (rows,)), (self._values, (rows, self.columns))):
            array.resize(shape, refcheck=False)


# Peaks of a run: of the time that is saved, which a solution reports, and of all its steps, which are watched
def no_peaks(record: RunRecord) -> Peaks:
    """Peaks of all signals before a run."""
    return Peaks(np.zeros_like(record.peak), np.zeros_like(record.peak))


def begin_watch(run: Run) -> None:
    """Start peaks, lows and poses at the present state."""
    reset_peaks(run)
    run.earlier = no_peaks(run.record)
    run.record.lows[:] = np.inf
    poses, signals, first = run.record.poses, run.record.signals, float(run.flow.clock.t)
    poses.times[0], poses.sizes[0], poses.values[0], poses.z[0] = first, 0.0, signals, run.flow.z
    poses.number.set_numbers(np.array([1, 1, 1, 0.0]))


def reset_peaks(run: Run) -> None:
    """Start the reported peaks at the present state; earlier ones stay watched."""
    run.earlier = all_peaks(run)
    run.stepper.reset_peaks()
    run.record.peak[:], run.record.peak_time[:] = _sizes(run.record), run.flow.clock.t


def all_peaks(run: Run) -> Peaks:
    """Peaks over all steps of a run."""
    record, earlier = run.record, run.earlier
    latest = record.peak, record.peak_time
    later = _with_places(record, record.peak >= earlier.values)
    return Peaks(*(np.where(later, now, before) for now, before in zip(latest, earlier, strict=True)))


def add_peaks(record: RunRecord, instant: float) -> None:
    """Count the present signals, at an instant [s], among the peaks."""
    size = _sizes(record)
    larger = _with_places(record, size > record.peak)
    record.peak_time[larger], record.peak[larger] = instant, size[larger]


def _sizes(record: RunRecord) -> np.ndarray:
    """Present sizes of all signals, as peaks count them."""
    return np.asarray(np.where(record.one_sided, np.maximum(record.signals, 0.0), np.abs(record.signals)))


def _with_places(record: RunRecord, larger: np.ndarray) -> np.ndarray:
    """Larger signals, each with the signal of its place."""
    larger[record.places[:, PLACE]] = larger[record.places[:, OF_PEAK]]
    return larger
