"""Derivatives of a user's function by differences: a step for each coordinate, found from the function itself.

A state alone gives no step: a coordinate may pass zero, or have run through many periods.  The result depends on the
present state only, so that motions go on with the same bits from a snapshot and in every thread.
"""

from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

Values = Callable[[np.ndarray], Any]  # a function of a state (n,), with values (m,)

STEP = 2e-5  # first step, over the coordinate: between cube and square root of round-off
RUNG, RUNGS = 17.0, 18  # ratio of two steps that are tried, and most of them in one direction
NEAR = 0.0571  # place of the point that tests a parabola, over the step; a chance ratio
ACCEPTED = 1e-7  # accepted difference of slopes at that point, over the slope: round-off and bend of the function
CLEAR, FALLEN = 20.0, 100.0  # bend, over round-off, that is one of the function; fall of bends that is no chance
VANISHING = 1e-12  # coordinate, over the largest one, that counts as zero
FARTHEST = 1e3  # largest step, over the largest coordinate, or over 1
ROUND_OFF = 2.2e-16
# Distances of sample states from a state, over its largest coordinate or over 1.
DISTANCES = (1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3)
PLACES = np.array([[[1.0]], [[-1.0]], [[NEAR]]])  # points, over the step
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
    found = np.full((len(points), count), np.nan)
    with np.errstate(all="ignore"):
        for k, point in enumerate(points):
            with suppress(Exception):  # a motion need not reach the point
                found[k] = function(point)
    return found


def entering(function: Values, x: np.ndarray) -> np.ndarray:
    """Whether (n, m) coordinates are seen in the values, at any of some states around x (n,)."""
    n, m = len(x), len(np.asarray(function(x.copy())))
    found = np.zeros((n, m), dtype=bool)
    for state, size in samples(x):
        values = values_at(function, state + np.vstack([np.zeros(n), 0.7 * size * np.eye(n)]), m)
        found |= np.isfinite(values[0]) & np.isfinite(values[1:]) & (values[1:] != values[0])
    return found


class Trial(NamedTuple):
    """Slopes (k, m) of parabolas through a state and two points beside it in k directions."""

    slope: np.ndarray
    steepest: np.ndarray  # steepest chord
    bend: np.ndarray  # difference of slopes at a fourth point, by a bend of the function or by round-off
    unit: np.ndarray  # (k, 1) that difference by the round-off of 1
    accepted: np.ndarray  # whether bend and round-off of the values are small beside the slope


class Differences:
    """Derivatives (n, m) of a function at a state (n,): accepted slopes, or else the best ones."""

    def __init__(self, function: Values, x: np.ndarray, value: np.ndarray, enters: np.ndarray | bool) -> None:
        self.function, self.x, self.value = function, x, value
        # values (n, m) that are seen to depend on a coordinate: constant ones are not accepted, a step may be too small
        self.enters = enters | np.zeros((len(x), len(value)), dtype=bool)

    def attempt(self, columns: Any, steps: np.ndarray) -> Trial:
        """Try the steps of some columns (k,) among steps (n,)."""
        points = self.x + PLACES * np.diag(steps)[columns]
        ahead, back, near = apart = (points - self.x).sum(axis=2, keepdims=True)
        values = values_at(self.function, points.reshape(-1, len(self.x)), len(self.value))
        chords = (values.reshape(3, len(ahead), -1) - self.value) / apart
        slope, bend = (BY_CHORDS @ chords.reshape(3, -1)).reshape(2, *chords.shape[1:])
        up, down, _ = np.abs(chords)
        steepest, bend, unit = np.maximum(up, down), np.abs(bend), ROUND_OFF / near
        limit = ACCEPTED * steepest
        is_seen = (unit * np.abs(self.value) <= limit) | ~self.enters[columns] & (steepest == 0.0)
        return Trial(slope, steepest, bend, unit, is_seen & (bend <= limit))

    def search(self, trial: Trial, steps: np.ndarray, size: np.ndarray) -> np.ndarray:
        """Derivatives from a trial on, by steps from rung to rung; `size` (m,): sizes of the terms of the values."""
        shape, columns = trial.slope.shape, np.arange(len(self.x))
        self.size, self.least, self.hump = np.abs(self.value) + size, np.full(shape, np.inf), np.zeros(shape)
        self.found, self.accepted, self.constant = np.full(shape, np.nan), np.zeros(shape, bool), trial.steepest == 0.0
        bends, _ = self._take(columns, trial)
        self._walk(steps.copy(), bends, is_finer=True)
        self.accepted |= self.least < self.hump / FALLEN
        self._walk(steps.copy(), np.ones(shape, dtype=bool), is_finer=False)
        return self.found

    def _take(self, columns: np.ndarray, trial: Trial, *, is_finer: bool = False) -> tuple[np.ndarray, np.ndarray]:
        """Take slopes that are accepted, or better; whether (k, m) the function bends, and slopes are better."""
        round_off = trial.unit * self.size + trial.steepest * (ROUND_OFF / NEAR)
        error, bends = np.maximum(trial.bend, round_off), ~(trial.bend <= CLEAR * round_off)
        error[~np.isfinite(error)] = np.inf
        better = error < self.least[columns]
        if is_finer:  # a bend that grows as the step falls: larger steps were beyond all lengths of the function
            hidden = bends & (error < np.inf)
            better = (trial.steepest > 0.0) & (better | hidden)
            self.hump[columns] = np.where(hidden, np.maximum(self.hump[columns], error), self.hump[columns])
        taken = ~self.accepted[columns] & (trial.accepted | better)
        self.found[columns] = np.where(taken, trial.slope, self.found[columns])
        self.least[columns] = np.where(taken, error, self.least[columns])
        self.accepted[columns] |= trial.accepted
        return bends, better

    def _walk(self, steps: np.ndarray, waits: np.ndarray, *, is_finer: bool) -> None:
        """Try smaller steps where the function bends, or larger ones where round-off is too large, or hides a value."""
        farthest = FARTHEST * max(1.0, float(np.abs(self.x).max()), float(steps.max()) / STEP)
        columns, ratio = np.arange(len(self.x)), 1.0 / RUNG if is_finer else RUNG
        for _ in range(RUNGS):
            waiting = (waits & ~self.accepted[columns]).any(axis=1)
            columns = columns[waiting & (ratio * steps[columns] <= farthest)]
            if len(columns) == 0:
                break
            steps[columns] *= ratio
            bends, better = self._take(columns, self.attempt(columns, steps), is_finer=is_finer)
            waits = bends if is_finer else better | self.constant[columns]


def central_differences(
    function: Values, x: np.ndarray, enters: Any = None, value: Any = None, steps: Any = None, size: Any = None
) -> np.ndarray:
    """Derivatives (m, n) of a function of x (n,) with values (m,)."""
    # May be known: coordinates seen in the values, the values, first steps, a function for `size` in a search.
    if steps is None:
        steps = np.abs(x)
        largest = steps.max()
        steps[steps <= VANISHING * largest] = largest or 1.0
        steps *= STEP
    with np.errstate(all="ignore"):
        value = np.array(function(x.copy()), dtype=np.float64) if value is None else value
        tried = Differences(function, x, value, entering(function, x) if enters is None else enters)
        trial = tried.attempt(slice(None), steps)
        if trial.accepted.all():
            return trial.slope.T
        by_slopes = np.abs(x) @ np.nan_to_num(np.abs(trial.slope), posinf=0.0)
        return tried.search(trial, steps, by_slopes if size is None else size()).T
