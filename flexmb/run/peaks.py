"""Peaks of a run: of the time that is saved, which a solution reports, and of all its steps, which are watched."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexmb.results.peaks import Peaks
from flexmb.state.poses import keep_first
from flexmb.state.record import OF_PEAK, PLACE

if TYPE_CHECKING:
    from flexmb.run.run import Run
    from flexmb.state.record import RunRecord


def no_peaks(record: RunRecord) -> Peaks:
    """Peaks of all signals before a run."""
    return Peaks(np.zeros_like(record.peak), np.zeros_like(record.peak))


def begin_watch(run: Run) -> None:
    """Start peaks, lows and poses at the present state."""
    reset_peaks(run)
    run.earlier = no_peaks(run.record)
    run.record.lows[:] = np.inf
    keep_first(run.record.poses, float(run.flow.clock.t), run.record.signals, run.flow.z)


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


def watch_lows(run: Run) -> None:
    """Let the compiled loop watch the least values of the signals of parts that can only push."""
    places = run.stepper.reported.names.signals.places
    names = [f"{part.name}.{name}" for part in run.mechanism.parts for name in part.pushes] if run.mechanism else []
    if names:
        lows = np.array([places[name] for name in names], dtype=np.int64)
        run.record = run.record.replaced(low_places=lows, lows=np.full((len(names), 2), np.inf))


def _sizes(record: RunRecord) -> np.ndarray:
    """Present sizes of all signals, as peaks count them."""
    sizes: np.ndarray = np.where(record.one_sided, np.maximum(record.signals, 0.0), np.abs(record.signals))
    return sizes


def _with_places(record: RunRecord, larger: np.ndarray) -> np.ndarray:
    """Larger signals, each with the signal of its place."""
    larger[record.places[:, PLACE]] = larger[record.places[:, OF_PEAK]]
    return larger
