"""Run with derivatives of its state and of its signals by parameters."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from flexmb.engine.sensitivity.linearise import Tangents, new_tangents
from flexmb.engine.sensitivity.parameters import parameter_rates
from flexmb.engine.sensitivity.signal_rows import signal_rows, write_start
from flexmb.engine.sensitivity.tangent_step import CarryingRun, complete_differences, project_differences
from flexmb.engine.state.record import NEVER, Options


class Directions(NamedTuple):
    """Derivatives by p parameters: of the numbers, (p, n_p), of start positions and velocities, (p, n_q)."""

    numbers: np.ndarray
    steps: np.ndarray  # (p,) largest difference of each parameter
    q: np.ndarray
    v: np.ndarray


class ParameterRun(CarryingRun):
    """Run of the Newmark family with derivatives by parameters, and with one difference of the state alone.

    This is a blow, a difference of velocities; `growth` is the factor by which it has grown, in positions and, times
    period / (2 pi), in velocities.
    """

    blocks: list[tuple[np.ndarray, ...]]
    growth = 0.0

    def carry(self, end: float, found: Directions, places: np.ndarray, due: np.ndarray, *, every: bool) -> Tangents:
        """Run until `end` [s]; derivatives of the signals at `places` at the instants `due`, and at `every` step."""
        n, program, k = self.program.n_q, self.program, len(found.q) + 1
        by = parameter_rates(program, found.numbers, found.steps)
        self.stepper.tangents = T = new_tangents(program, k, by, signal_rows(program, k, places, due, every=every))
        blow = np.random.default_rng(0).standard_normal(n) * program.sizes / self.time_scale
        T.q[:, :n], T.v[:, :n] = np.vstack([found.q, np.zeros(n)]), np.vstack([found.v, blow])
        self.blocks = []
        complete_differences(program, self.flow, T, self.stepper.second, histories=False)
        project_differences(program, self.flow, float(self.flow.clock.step_size), T)
        complete_differences(program, self.flow, T, self.stepper.second, histories=True)
        begun = self._length(T)
        options = self.options(end, NEVER)
        write_start(program.tables, program.addresses, options, self.flow, self.trial, self.record, T)
        self.run_to(end, saving=float(np.diff(due).min()))
        self._fetch_rows()
        self.growth = self._length(T) / begun if begun > 0.0 else 0.0
        self.stepper.tangents = None
        return T

    def rows(self, first: np.ndarray, slopes: np.ndarray) -> tuple[np.ndarray, ...]:
        """Start and ends of all steps: time (n,), signals (n, m), derivatives (n, p, m), time shifts (n, p).

        first, slopes : signals (m,) and derivatives (p, m) at the start
        """
        p, m = slopes.shape
        time, y, slope, shift = (np.concatenate(column) for column in zip(*self.blocks, strict=True))
        time, y = np.concatenate([[0.0], time]), np.concatenate([first[None], y])
        slope = np.concatenate([slopes[None], slope.reshape(len(slope), -1, m)[:, :p]])
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
        n = self.program.n_q
        parts = T.q[-1, :n] / self.program.sizes, self.time_scale * T.v[-1, :n] / self.program.sizes
        return float(np.linalg.norm(np.concatenate(parts)))
