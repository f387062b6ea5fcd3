"""Derivatives of a user's function by differences: a step for each coordinate, found from the function itself.

No step follows from a state alone: a coordinate may pass through zero, or have run through many periods of a function
of it.  Steps are tried from rung to rung of a ladder until an entry is accepted.  The result depends on the present
state only, so that motions go on with the same bits from a snapshot and in every thread.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

Values = Callable[[np.ndarray], Any]  # a function of a state (n,), with values (m,)

STEP = 2e-5  # first step, over the coordinate: between cube and square root of round-off
RUNG, RUNGS = 17.0, 18  # ratio of two steps that are tried, and most of them in one direction
NEAR = 0.0571  # place of the point that tests a parabola, over the step; a chance ratio
ACCEPTED = 1e-7  # accepted difference of slopes at that point, over the slope: round-off and bend of the function
CLEAR = 100.0  # bend, over round-off, that is one of the function
VANISHING = 1e-12  # coordinate, over the largest one, that counts as zero
FARTHEST = 1e3  # largest step, over the largest coordinate, or over 1
ROUND_OFF = 2.2e-16
# Distances of sample states from a state, over its largest coordinate or over 1.
DISTANCES = (1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3)
PLACES = np.array([[1.0], [-1.0], [NEAR]])  # points, over the step
# Slope of the parabola through the first two points and the state, and what the third chord has beyond it, by chords.
BY_CHORDS = np.array([[0.5, 0.5, 0.0], [-0.5 * (1.0 + NEAR), -0.5 * (1.0 - NEAR), 1.0]])


def samples(x: np.ndarray) -> Iterator[tuple[np.ndarray, float]]:
    """A state and others around it, with their distances from it."""
    yield x.copy(), 0.0
    for distance in DISTANCES:
        size = distance * max(1.0, float(np.abs(x).max()))
        yield x + size * np.cos(np.arange(1.0, len(x) + 1.0)), size


def values_at(function: Values, points: np.ndarray, count: int) -> np.ndarray:
    """Values (k, count) at trial points (k, n), which the function may change; NaN where it has none."""
    found = np.empty((len(points), count))
    for k, point in enumerate(points):
        try:
            found[k] = function(point)
        except Exception:  # noqa: BLE001 - a motion need not reach the point
            found[k] = np.nan
    return found


def entering(function: Values, x: np.ndarray) -> np.ndarray:
    """Whether (n, m) coordinates are seen in the values, at any of some states around x (n,)."""
    with np.errstate(all="ignore"):
        n, m = len(x), len(np.asarray(function(x.copy())))
        found = np.zeros((n, m), dtype=bool)
        for state, size in samples(x):
            values = values_at(function, state + np.vstack([np.zeros(n), 0.7 * size * np.eye(n)]), m)
            found |= np.isfinite(values[0]) & np.isfinite(values[1:]) & (values[1:] != values[0])
    return found


@dataclass(frozen=True, eq=False)
class Trial:
    """Slopes (k, m) of parabolas through a state and two points beside it, with their errors."""

    slope: np.ndarray
    error: np.ndarray
    round_off: np.ndarray  # least error, by the round-off of the values
    accepted: np.ndarray  # (k, m) whether the error is small beside the slope
    constant: np.ndarray  # (k, m) whether a value is the same at all points though it depends on the coordinate


class Differences:
    """Derivatives (n, m) of a function at a state (n,): the accepted slopes, or the best of those that were tried."""

    # `enters` (n, m): values that are seen to depend on a coordinate. A step at which such a value is constant may be
    # too small to be seen.
    def __init__(self, function: Values, x: np.ndarray, value: np.ndarray, enters: np.ndarray | bool) -> None:
        self.function, self.x, self.value = function, x, value
        self.enters = np.broadcast_to(enters, (len(x), len(value)))

    def attempt(self, columns: np.ndarray, steps: np.ndarray) -> Trial:
        """Try steps (k,) of columns (k,)."""
        # A fourth point tests a parabola: the difference of slopes there is its error by the bend of the function.
        k, m, rows = len(columns), len(self.value), np.arange(len(columns))
        points = np.empty((3, k, len(self.x)))
        points[:] = self.x
        points[:, rows, columns] += PLACES * steps
        apart = (points[:, rows, columns] - self.x[columns])[:, :, None]
        chords = (values_at(self.function, points.reshape(3 * k, -1), m).reshape(3, k, m) - self.value) / apart
        slope, bend = (BY_CHORDS @ chords.reshape(3, -1)).reshape(2, k, m)
        steepest = np.abs(chords[:2]).max(axis=0)
        constant = (steepest == 0.0) & self.enters[columns]
        ahead, _, near = apart
        round_off = (ROUND_OFF / near) * ((steepest > 0.0) | constant) * (np.abs(self.value) + ahead * steepest)
        error = np.maximum(np.abs(bend), round_off)
        return Trial(slope, error, round_off, error <= ACCEPTED * steepest, constant)

    def search(self, first: np.ndarray) -> np.ndarray:
        """Derivatives by steps from rung to rung, beginning with first ones (n,)."""
        everywhere = np.arange(len(self.x))
        trial = self.attempt(everywhere, first)
        if trial.accepted.all():
            return trial.slope
        self.found, self.least = np.full(trial.slope.shape, np.nan), np.full(trial.slope.shape, np.inf)
        self.accepted = np.zeros(trial.slope.shape, dtype=bool)
        self._take(everywhere, trial, trial.error < np.inf)
        self._refine(trial, first.copy())
        self._coarsen(trial, first.copy())
        return self.found

    def _take(self, columns: np.ndarray, trial: Trial, better: np.ndarray) -> None:
        """Take accepted entries, and those that are better, where none is accepted."""
        taken = ~self.accepted[columns] & (trial.accepted | better)
        self.found[columns] = np.where(taken, trial.slope, self.found[columns])
        self.least[columns] = np.where(taken, trial.error, self.least[columns])
        self.accepted[columns] |= trial.accepted

    def _refine(self, trial: Trial, steps: np.ndarray) -> None:
        """Try ever smaller steps where entries bend."""
        columns, hump = np.arange(len(self.x)), np.zeros(self.found.shape)
        for _ in range(RUNGS):
            bends = ~self.accepted[columns] & ~(trial.error <= trial.round_off)
            columns = columns[bends.any(axis=1)]
            if len(columns) == 0:
                break
            steps[columns] /= RUNG
            trial = self.attempt(columns, steps[columns])
            # A bend that grows as the step falls shows that larger steps were beyond all lengths of the function.
            hidden = np.isfinite(trial.error) & (trial.error > CLEAR * trial.round_off)
            hump[columns] = np.where(hidden, np.maximum(hump[columns], trial.error), hump[columns])
            self._take(columns, trial, ~trial.constant & (hidden | (trial.error < self.least[columns])))
        self.accepted |= self.least < hump / CLEAR

    def _coarsen(self, trial: Trial, steps: np.ndarray) -> None:
        """Try ever larger steps where round-off is too large, or may hide that a value depends on the coordinate."""
        farthest, columns = FARTHEST * max(1.0, np.abs(self.x).max(), steps.max() / STEP), np.arange(len(self.x))
        promising = np.ones(self.found.shape, dtype=bool)
        hidden = trial.constant
        while True:
            waiting = (~self.accepted[columns] & promising).any(axis=1)
            columns = columns[waiting & (RUNG * steps[columns] <= farthest)]
            if len(columns) == 0:
                break
            steps[columns] *= RUNG
            trial = self.attempt(columns, steps[columns])
            better = trial.error < self.least[columns]
            self._take(columns, trial, better)
            promising = better | hidden[columns]


def central_differences(
    function: Values,
    x: np.ndarray,
    enters: np.ndarray | bool | None = None,
    *,
    step: float | None = None,
    value: np.ndarray | None = None,
) -> np.ndarray:
    """Derivatives (m, n) of a function of x (n,) with values (m,); `step`: a first step, else by the sizes of x."""
    size = np.abs(x)
    largest = float(size.max())
    first = STEP * np.where(size > VANISHING * largest, size, largest or 1.0) if step is None else np.full(len(x), step)
    with np.errstate(all="ignore"):
        known = np.array(function(x.copy()) if value is None else value, dtype=np.float64)
        return Differences(function, x, known, entering(function, x) if enters is None else enters).search(first).T
