"""Run with derivatives of its state and of its signals by parameters."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from flexmb.engine.sensitivity.linearise import Tangents, new_tangents
from flexmb.engine.sensitivity.parameters import Moved, act_differences, parameter_rates
from flexmb.engine.sensitivity.signal_rows import signal_rows
from flexmb.engine.sensitivity.tangent_step import CarryingRun, complete_differences, project_differences
from flexmb.engine.state.record import NEVER, Options
from flexmb.run.saving import SAME_INSTANT
from flexmb.statics.start.consistent import Start


class Directions(NamedTuple):
    """Derivatives by p parameters: of the numbers, (p, n_p), of start positions, velocities, histories, (p, n)."""

    numbers: np.ndarray
    steps: np.ndarray  # (p,) largest difference of each parameter
    q: np.ndarray
    v: np.ndarray
    z: np.ndarray
    samplers: Sequence[Moved]  # of each parameter


class ParameterRun(CarryingRun):
    """Run of the Newmark family with derivatives by parameters, and with one difference of the state alone."""

    # This is a blow, a difference of velocities; `growth` is the factor by which it has grown, in positions and, times
    # period / (2 pi), in velocities.
    blocks: list[tuple[np.ndarray, ...]]
    found: Directions
    growth = begun = 0.0

    def carry(
        self, start: Start, end: float, found: Directions, places: np.ndarray, due: np.ndarray, *, every: bool
    ) -> Tangents:
        """Run until `end` [s]; derivatives of the signals at `places` at the instants `due`, and at `every` step."""
        # The run has begun at `start`. Signals that sampled controllers read are added to the places.
        program, k = self.program, len(found.q) + 1
        read = [place for sampler in program.samplers for place in sampler.inputs if isinstance(place, int)]
        self.inputs = np.unique(np.array(read, dtype=np.int64))
        rows = signal_rows(program, k, np.concatenate([places, self.inputs]), due, every=every)
        self.stepper.tangents = T = new_tangents(program, k, parameter_rates(program, found.numbers, found.steps), rows)
        self.found, self.blocks = found, []
        if program.samplers:
            self.begin(start)  # which lets them act once more, now with differences
        else:
            self._start_differences(T)
        self._write_slopes(T, 0)
        rows.number.instants = 1
        self.run_to(end, saving=float(np.diff(due).min()))
        self._fetch_rows()
        self.growth = self._length(T) / self.begun if self.begun > 0.0 else 0.0
        self.stepper.tangents = None
        return T

    def _start_differences(self, T: Tangents) -> None:
        """Set the differences at the start."""
        n, program, found = self.program.n_q, self.program, self.found
        blow = np.random.default_rng(0).standard_normal(n) * program.sizes / self.time_scale
        blow[program.tables.sizes.n_b :] = 0.0
        T.q[:, :n], T.v[:, :n] = np.vstack([found.q, np.zeros(n)]), np.vstack([found.v, blow])
        T.z[: len(found.z)] = found.z
        complete_differences(program, self.flow, T, self.stepper.second, histories=False)
        project_differences(program, self.flow, float(self.flow.clock.step_size), T)
        complete_differences(program, self.flow, T, self.stepper.second, histories=True)
        self.begun = self._length(T)

    def _cross_jump(self, instant: float, interval: float, *, first: bool = False) -> None:
        T = self.stepper.tangents
        if T is None:
            super()._cross_jump(instant, interval, first=first)
            return
        if first:
            self._start_differences(T)
        self._synchronise()
        if any(first or sampler.acts_at(instant) for sampler in self.program.samplers):
            y, dy = self.record.signals, np.zeros((len(T.q), len(self.record.signals)))
            self.find_slopes()
            dy[:, T.rows.places] = T.rows.now
            now = (instant, y, np.array(self.flow.z), dy, np.array(T.z), self.record.peak, self.found.samplers)
            T.z[:] = act_differences(self.program, *now, every=first)
        super()._cross_jump(instant, interval, first=first)
        rows, last = T.rows, int(T.rows.number.instants) - 1
        if not first and not self.note:
            if last >= 0 and abs(rows.due[last] - instant) <= SAME_INSTANT * float(np.diff(rows.due).min()):
                self._write_slopes(T, last)
            if rows.every:
                # A row of steps with the state just after the jump.
                self._fetch_rows()
                self.find_slopes()
                y = self.record.signals[T.rows.places][None]
                self.blocks.append((np.array([instant]), y, T.rows.now.reshape(1, -1).copy(), np.zeros((1, len(T.q)))))

    def find_slopes(self) -> None:
        """Set `rows.now` of the tangents to the derivatives of the signals in the present state."""
        self.stepper.advance(self, self.options(NEVER, NEVER), 0)

    def _write_slopes(self, T: Tangents, row: int) -> None:
        """Write the derivatives at the present instant into a row of the saved instants."""
        self.find_slopes()
        T.rows.slopes[row] = T.rows.now.ravel()

    def rows(self, first: np.ndarray, slopes: np.ndarray) -> tuple[np.ndarray, ...]:
        """Start and ends of all steps: time (n,), signals (n, m), derivatives (n, p, m), time shifts (n, p)."""
        # first, slopes : signals (m,) and derivatives (p, m) at the start
        p, m = slopes.shape
        time, y, slope, shift = (np.concatenate(column) for column in zip(*self.blocks, strict=True))
        time, slope = np.concatenate([[0.0], time]), slope.reshape(*shift.shape, -1)[:, :p, :m]
        y, slope = np.concatenate([first[None], y[:, :m]]), np.concatenate([slopes[None], slope])
        return time, y, slope, np.concatenate([np.zeros((1, p)), shift[:, :p]])

    def empty_buffer(self, options: Options) -> None:
        """Empty the buffers of the run and of its rows."""
        super().empty_buffer(options)
        self._fetch_rows()

    def _fetch_rows(self) -> None:
        T = self.stepper.tangents
        if T is not None and T.rows.number.steps > 0:
            rows = T.rows
            kept = slice(0, int(rows.number.steps))
            arrays = rows.times, rows.step_values, rows.step_slopes, rows.shifts
            self.blocks.append(tuple(array[kept].copy() for array in arrays))
            rows.number.steps = 0

    @property
    def time_scale(self) -> float:
        """Time by which velocities are compared with positions [s]."""
        return (self.period or self.t_end) / (2.0 * math.pi)

    def _length(self, T: Tangents) -> float:
        n = self.program.tables.sizes.n_b
        sizes = self.program.sizes[:n]
        return float(np.linalg.norm(np.concatenate([T.q[-1, :n] / sizes, self.time_scale * T.v[-1, :n] / sizes])))
