"""A run: the arrays of the compiled loop, driven in blocks so that progress, Ctrl-C and saving work."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from flexmb.compiled.notice import notice
from flexmb.energy.balance import final_verdict, open_account
from flexmb.errors import InputError, SolveError
from flexmb.jobs.progress import ProgressBar
from flexmb.linalg import lu
from flexmb.linalg.rank import row_rank
from flexmb.model.mechanism import Mechanism
from flexmb.program.program import Program
from flexmb.results.solution import ContactLog, Peaks, Solution
from flexmb.results.stats import Stats
from flexmb.results.status import sentence
from flexmb.run.saved_rows import SavedRows
from flexmb.start.consistent import Start, accelerations
from flexmb.start.redundant_joints import least_norm
from flexmb.state.flow import new_flow
from flexmb.state.options import NEVER, Options
from flexmb.state.record import BUFFER_FULL, DONE, RUNNING
from flexmb.state.trial import new_trial, rigid_coordinates
from flexmb.step.contact_log import close_what_touches, still_running, taken_out, touching_from_the_start
from flexmb.step.method import Method
from flexmb.step.step_size import FLIGHT_COUNTS, Adaptive, FixedStep
from flexmb.system.at_state import System
from flexmb.system.work import workspace

BUFFER, LEAST_BUFFER, BUFFER_NUMBERS = 512, 16, 1 << 23
"""Saved instants in the buffer of the loop at most and at least, and numbers in it: 64 MB."""

BLOCK_SECONDS = 0.2
FIRST_BLOCK = 20_000
"""Unknowns times steps of the first block, whose speed is not known yet: some ten milliseconds."""

NEWTON_TOLERANCE = 1e-6
ITERATIONS = 30
NOT_SAVING = -1.0
ENOUGH = "Stopped after"


class Run:
    """One run of a program; see `simulate` for the arguments."""

    def __init__(
        self,
        program: Program,
        method: Method,
        step: FixedStep | Adaptive,
        t_end: float,
        period: float | None,
        *,
        mechanism: Mechanism | None = None,
        max_steps: int | None = None,
        progress: bool = False,
        kept: np.ndarray | None = None,
    ) -> None:
        self.method, self.step, self.stepper = method, step, method.stepper(program, mechanism)
        self.program = program = self.stepper.program
        self.period, self.t_end, self.max_steps, self.progress = period, t_end, max_steps, progress
        self.lu = lu.tables(program.symbolic)
        self.kept, rows = kept, BUFFER_NUMBERS // max(len(kept) if kept is not None else self.stepper.columns, 1)
        self.record = self.stepper.record(max(LEAST_BUFFER, min(BUFFER, rows)), kept)
        self.work, self.flow = workspace(program), new_flow(program)
        self.saved = SavedRows(self.record.values.shape[1], kept)
        self.episodes: list[np.ndarray] = []
        self.saving = False
        self.code, self.note, self.redundant = RUNNING, "", 0
        self.h_max, self.h_min, self.error, self.bounds = self._limits()
        self.trial = new_trial(program, 0, self.bounds)

    def _limits(self) -> tuple[float, float, float, tuple[float, ...]]:
        """Largest and smallest step [s], accepted error of a step [m], and the `Bounds` of step control.

        Speeds count from that which takes 100 runs or periods to cross the mechanism; with clearance to cross 100
        clearances if these are less, so that a contact that comes to rest is resolved.
        """
        if isinstance(self.step, FixedStep):
            return self.step.size, self.step.size, NEVER, (1.0, 1.0, 1.0, 1.0)
        span = self.t_end if self.period is None else min(self.period, self.t_end)
        clearance, length, rtol = self.program.least_clearance, self.program.length, self.step.rtol
        steps = self.method.fewest_steps(contacts=clearance is not None)
        largest = self.step.max or span / steps
        flight, loose = (FLIGHT_COUNTS, 2.0) if rigid_coordinates(self.program).all() else (1.0, 4.0)
        part = 1e-3 * length if clearance is None else loose * min(clearance, 1e-2 * length)
        way = length if clearance is None else min(length, 1e2 * clearance)
        bounds = (rtol, 1e-2 / steps * way / largest, self.step.steps_of_an_impact, flight)
        return largest, self.step.min or min(1e-9 * largest, 1e-12 * span), self.step.atol or rtol * part, bounds

    def begin(self, start: Start, *, z: np.ndarray | None = None, time: float = 0.0) -> None:
        """Take start values, at that time [s] and with histories z (n_z,), None: those of the drawn pose."""
        n, z = self.program.n_q, self.program.drawn.z if z is None else z
        flow, code = self.flow, self.stepper.prepare(self, start, z, time)
        flow.q[:n], flow.v[:n], flow.a[:n], flow.x[:n] = start.q, start.v, start.a, start.a
        flow.lam[:], flow.z[:] = start.lam, z
        flow.clock.t = time
        self._expect(start.redundant)
        flow.clock.held_steps = -1.0 if self._seems_dependent(start) else 0.0
        flow.clock.saving_from = NOT_SAVING
        flow.clock.size = self.h_max if isinstance(self.step, FixedStep) else 1e-3 * self.h_max
        self.stepper.look(self)
        open_account(flow.ledger, flow.account)
        begun = flow.z.copy()
        flow.z[:] = self.work.z_new
        close_what_touches(self.program, begun, flow)
        touching_from_the_start(self.program.tables, flow)
        self.stepper.write(self)
        self.forget_peaks()
        if code != RUNNING:
            self.code, self.note = code, self.stepper.explain(code) or ""

    def look(self) -> None:
        """Find energies, forces and signals of what stands in `flow`; a restored state alone may follow."""
        self.stepper.look(self)
        self.stepper.write(self)

    def one_step(self, limit: float) -> bool:
        """Take one step, not beyond the time `limit` [s]; whether it was accepted.  Nothing is saved."""
        kept, self.max_steps = self.max_steps, int(self.record.count.steps) + 1
        self.go_to(limit, saving=None)
        self.max_steps = kept
        if self.note.startswith(ENOUGH):
            self.note, self.code = "", RUNNING
        return self.code in (RUNNING, DONE) and not self.note

    def _seems_dependent(self, start: Start) -> bool:
        """Whether rows that are independent look dependent, because some inertia is very small.

        How much they do depends on the direction of the bodies against X and Y: all are turned together.
        """
        system, angles = System(self.program, self.work), np.asarray(self.program.tables.kind) == 1
        for turn in (0.0, 0.7, 2.3):
            values = system.at(start.q + turn * angles, weights=(0.0, 0.0, 1.0)).work.lu.copy()
            seen = np.zeros(self.program.symbolic.n)
            lu.factor(self.lu, values, seen, lu.THRESHOLD, self.program.n_q, 10.0 * lu.HOLD)
            if int((seen < 0.0).sum()) > start.redundant:
                return True
        return False

    def resume(self, restart: Mapping[str, np.ndarray], label: str, *, redundant: bool = False) -> None:
        """Take the final state of another run of the same model.

        Parameters
        ----------
        restart : arrays by name.
        label : what errors begin with.
        redundant : whether rows may repeat one another.
        """
        if not isinstance(restart, Mapping):
            text = f"{label}: restart is {restart!r}"
            raise InputError(f"{text}; it must be `restart` of a solution of the same mechanism.")
        try:
            if np.shape(restart.get("signals")) != self.record.new.shape:
                raise ValueError("signals")
            self.flow.restore(restart)
            self.stepper.restore(restart)
        except ValueError as error:
            raise InputError(
                f"{label}: restart does not fit this model "
                f"({str(error)!r} is missing or of another size). Use `restart` of a solution of the same mechanism."
            ) from error
        self.record.new[:] = restart["signals"]
        if redundant:
            G = System(self.program).at(self.flow.q[: self.program.n_q], t=self.flow.clock.t).jacobian
            self._expect(len(row_rank(G).redundant))
        self.forget_peaks()

    def _expect(self, redundant: int) -> None:
        """So many rows repeat others in every pose."""
        if redundant != self.redundant:
            self.redundant, self.trial = redundant, new_trial(self.program, redundant, self.bounds)

    def forget_peaks(self) -> None:
        """Begin to look for peaks at the present state."""
        self.stepper.forget_peaks()
        self.record.peak[:] = np.where(self.record.one_sided, np.maximum(self.record.new, 0.0), np.abs(self.record.new))
        self.record.peak_time[:] = self.flow.clock.t

    def go_to(self, end: float, saving: float | None) -> None:
        """Run until `end`; `saving` is the time between saved instants, 0 for every step, None for nothing.

        Where a drive or a load jumps a step ends just before, and the next one starts anew just after.
        """
        if self.note or self.code not in (RUNNING, DONE):
            return  # a run that was stopped before the instants to be saved stays stopped
        if saving is not None:
            self._begin_saving(saving, end)
        self.flow.account.limit = self.stepper.missing
        interval = NEVER if saving is None else saving
        if self.progress:
            self.stepper.advance(self, self.options(end, interval), 0)  # compiled before a bar is shown
            notice.close()
        bar = ProgressBar(self.program.name, end, done=float(self.flow.clock.t), shown=self.progress, of="s of motion")
        try:
            for instant in self.program.breaks(end):
                if instant > self.flow.clock.t and self._reach(just_before(instant), interval, bar, ahead=True):
                    self._jump(instant, interval)
                if self.note or self.code not in (RUNNING, DONE):
                    break
            else:
                if self._reach(end, interval, bar) and saving is not None:
                    self.code = final_verdict(self.flow.ledger, self.flow.account) or DONE
        except KeyboardInterrupt:
            self.note = "Interrupted from the keyboard"
        bar.close()

    def _reach(self, target: float, interval: float, bar: ProgressBar, *, ahead: bool = False) -> bool:
        """Run until `target`; whether it was reached.  With `ahead` that is seen even if no step is left to take."""
        options = self.options(target, interval)
        steps, self.code = max(FIRST_BLOCK // (self.program.symbolic.n + 1), 16), RUNNING
        while self.code == RUNNING:
            began = time.perf_counter()
            steps = self._allowed(steps)
            if steps == 0 and ahead and self.flow.clock.t >= (1.0 - 1e-12) * target:
                self.code = DONE
            elif steps == 0:
                self.note = f"{ENOUGH} {self.max_steps} steps, as asked for"
                return False
            else:
                self.code = self.stepper.advance(self, options, steps)
            self._empty(options)
            bar.update(min(self.flow.clock.t, bar.total) - bar.n)
            took = time.perf_counter() - began
            steps = int(min(max(steps * min(BLOCK_SECONDS / max(took, 1e-6), 4.0), 16), 1_000_000))
            if self.code == BUFFER_FULL:
                self.code = RUNNING
        return self.code == DONE

    def _jump(self, instant: float, interval: float) -> None:
        """Go from just before a jump of the loads to just after: new accelerations, joint forces and powers.

        Positions, velocities, histories and energies stay.  The next step is a first step.
        """
        flow, n = self.flow, self.program.n_q
        flow.clock.t, flow.clock.last = instant, 0.0
        try:
            solve = least_norm if self.redundant else accelerations
            a, lam = solve(self.program, flow.q[:n], flow.v[:n], instant, flow.z)
        except SolveError as error:
            self.note = f"Stopped: {str(error).rstrip('.')}"
            return
        flow.a[:n], flow.x[:n], flow.lam[:] = a, a, lam
        kept = flow.ledger.copy()
        self.stepper.look(self)
        flow.ledger[:] = kept
        self.stepper.write(self)
        record = self.record
        size = np.where(record.one_sided, record.new, np.abs(record.new))
        record.peak_time[size > record.peak] = instant
        record.peak[:] = np.maximum(record.peak, size)
        if interval == 0.0:
            self.saved.add_one(flow.clock.t, record.new)
        elif interval < NEVER and self.saved.is_at(instant, 1e-9 * interval):
            self.saved.replace_last(record.new)  # an instant of the grid at the jump shows the state just after

    def _begin_saving(self, saving: float, end: float) -> None:
        """Save the present instant, or go on with the grid of the run that was resumed."""
        clock, self.saving = self.flow.clock, True
        if saving > 0.0:
            self.saved.expect(int(min((end - clock.t) / saving, 1e9)) + 2)
        if clock.saving_from < 0.0:
            clock.saving_from, clock.saved = clock.t, 0.0
            self.saved.add_one(clock.t, self.record.new)
        elif saving > 0.0:  # counted anew, since the interval may be another one
            clock.saved = np.floor((clock.t - clock.saving_from) / saving + 1e-9)

    def _allowed(self, steps: int) -> int:
        if self.max_steps is None:
            return steps
        return max(0, min(steps, self.max_steps - int(self.record.count.steps)))

    def arguments(self, options: Options) -> tuple[Any, ...]:
        """What every compiled loop is called with: tables, kernels, factors, options, state, trial, work, record."""
        common = (self.program.tables, self.program.addresses, self.lu, options, self.flow, self.trial)
        return *common, self.work, self.record

    def options(self, end: float, saving: float) -> Options:
        """Numbers of method and step control for a run until `end` that saves every `saving` [s]."""
        return Options(
            self.stepper.regular,
            self.stepper.first,
            self.stepper.form,
            NEWTON_TOLERANCE,
            ITERATIONS,
            float(self.program.length),
            isinstance(self.step, Adaptive),
            float(self.error),
            float(self.h_min),
            float(self.h_max),
            float(end),
            float(saving),
        )

    def _fetch(self) -> None:
        if self.record.count.episodes:
            self.episodes.append(taken_out(self.record))
        rows = int(self.record.count.rows)
        if rows:
            self.saved.add(self.record.times[:rows], self.record.values[:rows])
            self.record.count.rows = 0

    def _empty(self, options: Options) -> None:
        """Fetch the buffer, again and again where the last step passed more instants than it has room for."""
        self._fetch()
        while self.code == BUFFER_FULL and options.save_interval > 0.0:
            self.stepper.save(self, options)
            if self.record.count.rows == 0:
                return
            self._fetch()

    def solution(self, model: dict[str, Any], *, notes: tuple[str, ...] = (), wall_time: float = 0.0) -> Solution:
        """The record of what was run so far, with remarks and the time it took on the clock [s]."""
        program = self.stepper.shown
        kept = slice(None) if self.kept is None else self.kept
        names, (time, values) = program.names.signals, self.saved.finished()
        return Solution(
            time=time,
            values=values,
            signals=names if self.kept is None else names.chosen(self.kept),
            peaks=Peaks(self.record.peak[kept].copy(), self.record.peak_time[kept].copy()),
            status=self.status(),
            ok=self.code == DONE and not self.note,
            stats=self.stats(wall_time),
            aliases=program.names.aliases,
            shapes=program.shapes,
            restart=self.restart(),
            contacts=self.contact_log(),
            notes=(*notes, *self.stepper.remarks()),
            model={**model, "flexmb": installed_version(), "method": repr(self.method), "step": repr(self.step)},
        )

    def restart(self) -> dict[str, np.ndarray]:
        """The present state, from which a run of the same model goes on to the bit."""
        return {**self.flow.saved(), "signals": self.record.new.copy(), **self.stepper.saved()}

    def stats(self, wall_time: float = 0.0) -> Stats:
        """What the run cost so far, which took `wall_time` on the clock [s]."""
        count, step = self.record.count, self.record.step
        numbers = (count.steps, count.rejected, count.iterations, count.evaluations, count.factorisations)
        return Stats(*numbers, step.smallest if count.steps else 0.0, step.largest, wall_time)

    def contact_log(self) -> ContactLog:
        """Rows of the episodes that ended since saving began, and of those that are running."""
        running = still_running(self.program.tables, self.flow)
        rows = np.concatenate([*self.episodes, running if self.saving else running[:0]])
        return ContactLog(self.program.names.contacts, rows)

    def status(self) -> str:
        """How the run ended, in a sentence."""
        if self.note:
            return f"{self.note}, at t = {self.flow.clock.t:.6g} s."
        own = self.stepper.explain(self.code)
        if own is not None:
            return f"Stopped at t = {self.flow.clock.t:.6g} s: {own}"
        return sentence(self.program, self.code, self.flow, self.trial, self.record)


def just_before(instant: float) -> float:
    """An instant so close before that only round-off lies between; `t + h` cannot round beyond it."""
    return float(instant - 4.0 * np.spacing(instant))


@cache
def installed_version() -> str:
    """Version of flexmb, "unknown" when it is not installed."""
    try:
        return version("flexmb")
    except PackageNotFoundError:
        return "unknown"
