"""Run of a program: limits of its steps, arrays of the compiled loop, advanced in blocks for bar, Ctrl-C and saving."""

from __future__ import annotations

import math
import signal
import time
from bisect import bisect
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextvars import ContextVar
from itertools import pairwise
from types import FrameType
from typing import Any, Self

import numpy as np

from flexmb.dynamics.jobs.executors import is_ended, is_in_job
from flexmb.dynamics.jobs.progress import ProgressBar
from flexmb.engine.compiled.notice import notice
from flexmb.engine.compiled.records import fitting
from flexmb.engine.energy import COORDINATE_ROUND_OFF, check_balance_at_end, idle_energy, start_balance
from flexmb.engine.linalg import lu
from flexmb.engine.linalg.rank import surplus_rows
from flexmb.engine.newmark.predictor import FARTHEST_LEAP
from flexmb.engine.state.flow import new_flow, new_trial, rigid_coordinates
from flexmb.engine.state.record import BUFFER_FULL, CONDITION_MET, DONE, NEVER, RUNNING, Options
from flexmb.engine.step.contact_events import close_round_off_gaps, running_episodes, start_episodes
from flexmb.engine.step.method import Method
from flexmb.engine.step.step_size import FIRST_STEP, FLIGHT_WEIGHT, SHORT_STEP, Adaptive, FixedStep
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.engine.system.work import workspace
from flexmb.errors import InputError, KernelError, SolveError
from flexmb.findings.finding import Finding, found, sentences
from flexmb.findings.watch import naming_kernels
from flexmb.model.law import CHORDS_OF_A_SINE, Motion
from flexmb.model.mechanism import Mechanism
from flexmb.program.compiler import just_before
from flexmb.program.program import Program
from flexmb.results.contact_intervals import ContactLog
from flexmb.results.solution import LateFindings, Peaks, Solution, Stats
from flexmb.results.status import sentence
from flexmb.run.checkpoint import MODEL, refuse_broken_clock, refuse_other_model
from flexmb.run.sampling import act
from flexmb.run.saving import SAME_INSTANT, SavedRows, add_peaks, begin_watch, no_peaks, saves_end, start_saving
from flexmb.run.stopping import Snapshot, StopConditions, end_at_crossing
from flexmb.statics.start.consistent import Start, accelerations, held_rows, least_norm, looks_dependent
from flexmb.version import installed_version

# Signals that end a run: they wait until a block of steps is finished, so that no saved instant is lost or doubled

KEYBOARD, TERMINATION = signal.SIGINT, signal.SIGTERM


class Interruption:
    """A context in which signals, given by their numbers, are only noted; the second one of a kind acts at once."""

    # Outside the main thread of Python, signals act as ever.

    def __init__(self, signals: Sequence[signal.Signals]) -> None:
        self.signals = signals
        self.before: dict[signal.Signals, Any] = {}
        self.asked: int | None = None

    def __enter__(self) -> Self:
        try:
            self.before = {number: signal.signal(number, self._note) for number in self.signals}
        except ValueError:  # not in the main thread
            self.before = {}
        return self

    def __exit__(self, kind: Any, *_: object) -> None:
        for number, handler in self.before.items():
            signal.signal(number, handler)
        if kind is None:
            self.act()  # a signal that came after the last block

    def _note(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002 - given by the system
        if self.asked == number:
            raise KeyboardInterrupt
        self.asked = number

    def act(self) -> None:
        """Raise `KeyboardInterrupt` if a signal came, with a text on a signal that is not of the keyboard."""
        # The end of the jobs of a thread does the same.
        if is_ended():
            raise KeyboardInterrupt
        number, self.asked = self.asked, None
        if number is not None:
            raise KeyboardInterrupt("" if number == KEYBOARD else f"Ended by {signal.Signals(number).name}")


LEAST_STEP = 16.0  # smallest step by default over the round-off of the time
# Fixed steps in a cycle: with so few, or fewer, another motion is seen; with fewer than these, a finding tells it.
LEAST_SEEN, LEAST_CLEAR = 2.0, 8.0


def step_limits(run: Run) -> tuple[float, float, float, tuple[float, ...]]:
    """Largest and smallest step [s], accepted error of a step [m], and the numbers of `StepControl`."""
    # The least speed crosses the mechanism in 100 runs or periods; with clearance, 100 clearances if these are less, so
    # that the steps resolve a contact that comes to rest.
    if isinstance(run.step, FixedStep):
        return run.step.size, run.step.size, NEVER, (1.0,) * 5
    span = run.t_end if run.period is None else min(run.period, run.t_end)
    clearance, length, rtol = run.program.least_clearance, run.program.length, run.step.rtol
    steps = run.method.fewest_steps(contacts=clearance is not None)
    largest = run.step.max or span / steps
    flight, loose = (FLIGHT_WEIGHT, 2.0) if rigid_coordinates(run.program).all() else (1.0, 4.0)
    part = 1e-3 * length if clearance is None else loose * min(clearance, 1e-2 * length)
    way = length if clearance is None else min(length, 1e2 * clearance)
    bounds = (rtol, 1e-2 / steps * way / largest, *run.method.impacts(run.step), flight)
    return largest, run.step.min or min(1e-9 * largest, least_step(run.t_end)), run.step.atol or rtol * part, bounds


def least_step(t: float) -> float:
    """Smallest step by which the time t [s] can be advanced [s]."""
    return LEAST_STEP * float(np.spacing(t))


class Chords:
    """Longest steps between whose ends drives, histories of loads and inputs of controllers are nearly straight."""

    # A fixed step that sees another motion than that of a drive or load is refused.

    def __init__(self, run: Run) -> None:
        self.pieces: list[tuple[Motion, list[float], list[float]]] = []
        for motion in run.program.motions:
            edges = [0.0, *sorted(t for t in motion.breaks(run.t_end) if 0.0 < t < run.t_end), run.t_end]
            chords = [motion.longest_chord(*ends) for ends in pairwise(edges)]
            if min(chords) < math.inf:
                self.pieces.append((motion, edges[1:-1], chords))
        self.findings: list[Finding] = []
        h = run.step.size if isinstance(run.step, FixedStep) else 0.0
        for motion, _, chords in self.pieces:
            cycle = CHORDS_OF_A_SINE * min(chords)
            if h <= cycle / LEAST_CLEAR * (1.0 - 1e-9):
                continue
            what = type(motion).__name__
            text = f"fixed step of {h:.3g} s is {h / cycle:.2g} cycles of {what}, whose shortest lasts {cycle:.3g} s"
            remedy = f"Take steps of {min(chords):.2g} s, or Adaptive()."
            if h * LEAST_SEEN >= cycle * (1.0 - 1e-9):
                raise InputError(f"simulate {run.program.name!r}: a {text}: the steps see another motion. {remedy}")
            text = f"A {text}: few steps see the motion."
            self.findings.append(found("coarse-step", (), text, remedy, step=h, cycle=cycle))

    def longest(self, t: float) -> float:
        """Longest step about the instant t [s]; inf: any."""
        return min((chords[bisect(edges, t)] for _, edges, chords in self.pieces), default=math.inf)


def passed_contacts(run: Run) -> Iterator[Finding]:
    """Findings on contacts that fixed steps have passed without seeing whether these close."""
    for name, t in zip(run.program.names.contacts, run.record.passed, strict=True):
        if t != 0.0:
            text = f"At t = {t:.6g} s a fixed step went by the contact {name!r}, which was closed then, or at a gap "
            text += "that the ends of the step do not tell."
            yield found("passed-contact", (name.partition(".")[0],), text, "Take smaller steps, or Adaptive().", time=t)


def uncomputed_signals(run: Run) -> Iterator[Finding]:
    """Finding on the first saved signal of a finished run that is no finite number."""
    time, values = run.saved.finished()
    if run.code == DONE and not np.isfinite(values.sum()) and len(places := np.argwhere(~np.isfinite(values))):
        row, column = places[0]
        names, t = run.stepper.reported.names.signals, float(time[row])
        name = (names if run.kept is None else names.chosen(run.kept))[int(column)].name
        text = f"At t = {t:.6g} s the signal {name!r} is {values[row, column]}."
        remedy = "Mend the drive, load, law or sensor that is not defined there."
        yield found("no-number", (name.partition(".")[0],), text, remedy, time=t)


# Number of saved instants in the buffer of the loop, at most and at least; numbers in the buffer (64 MB).
BUFFER_ROWS, LEAST_BUFFER_ROWS, BUFFER_NUMBERS = 512, 16, 1 << 23
BLOCK_SECONDS = 0.2  # processor time of a block of steps [s], after which the progress bar moves
FIRST_BLOCK_UPDATES = 20_000  # number of unknowns times steps of the first block, some ten milliseconds
# Tolerance of Newton's corrections relative to h^2 |a|.
# Others: `ITERATION_FRACTION` of engine/radau/step.py, `STEP_ROUND_OFF` and `REST_STRIDE` of statics/equilibrium.py,
# `CLOSED_LOOP` of statics/start/consistent.py; all values and what they change: docs/numbers.md.
NEWTON_TOLERANCE = 1e-6
NEWTON_ITERATIONS = 30  # number of Newton iterations of a step at most
NOT_SAVING = -1.0  # value of `Clock.save_start` before saving has begun [s]
# Round-off of coordinates over the size of the mechanism from which they have no digits left.
LARGEST_ROUND_OFF = 1e-3
STOPPED_AFTER = "Stopped after"
REDUNDANT = "redundant"  # name of the number of redundant constraint equations in a restart
# Observer of the runs of this context after each block of steps; its `KeyboardInterrupt(text)` ends the run.
AFTER_BLOCK: ContextVar[Callable[[Run], None] | None] = ContextVar("function after each block of a run", default=None)


class Run:
    """One run of a program; see `simulate` for the arguments."""

    def __init__(
        self, program: Program, method: Method, step: FixedStep | Adaptive, t_end: float, period: float | None, *,
        mechanism: Mechanism | None = None, max_steps: int | None = None, progress: bool = False,
        kept: np.ndarray | None = None,
    ) -> None:  # fmt: skip
        self.method, self.step, self.stepper = method, step, method.stepper(program, mechanism)
        self.mechanism = mechanism
        self.program = program = self.stepper.program
        self.period, self.t_end, self.max_steps, self.progress = period, t_end, max_steps, progress
        self.lu = lu.tables(program.symbolic)
        self.kept, rows = kept, BUFFER_NUMBERS // max(len(kept) if kept is not None else self.stepper.columns, 1)
        self.record = self.stepper.record(max(LEAST_BUFFER_ROWS, min(BUFFER_ROWS, rows)), kept)
        self.work, self.flow = workspace(program), new_flow(program)
        self.saved = SavedRows(self.record.values.shape[1], kept)
        self.episodes: list[np.ndarray] = []
        self.saving = self.interrupted = False
        self.after_block: Callable[[Run], None] = AFTER_BLOCK.get() or (lambda _: None)
        self.interruption = Interruption([KEYBOARD])
        self.code, self.note, self.redundant = RUNNING, "", 0
        self.stopping: StopConditions | None = None
        self.met = ""
        self.earlier = no_peaks(self.record)
        pushing = [f"{part.name}.{name}" for part in mechanism.parts for name in part.pushes] if mechanism else []
        if pushing:  # parts that can only push: the loop watches the least values of these signals
            lows = np.array([self.stepper.reported.names.signals.places[name] for name in pushing], dtype=np.int64)
            self.record = self.record.replaced(low_places=lows, lows=np.full((len(lows), 2), np.inf))
        self.h_max, self.h_min, self.error, self.bounds = step_limits(self)
        self.chords = Chords(self)
        self.trial = new_trial(program, 0, self.bounds)

    def begin(self, start: Start, z: np.ndarray | None = None, *, time: float = 0.0) -> None:
        """Take start values at a time [s], with histories z (n_z,); None: histories at the start."""
        n, z = self.program.n_q, self.program.reference.z if z is None else z
        flow, code = self.flow, self.stepper.prepare(self, start, z, time)
        flow.q[:n], flow.v[:n], flow.a[:n], flow.x[:n] = start.q, start.v, start.a, start.a
        flow.lam[:], flow.z[:], flow.clock.t = start.lam, z, time
        self._set_redundancy(start.redundant)
        flow.clock.held_steps = -1.0 if looks_dependent(self.program, self.work, start.q, start.redundant) else 0.0
        flow.clock.save_start, flow.clock.jumps = NOT_SAVING, 0.0
        flow.clock.step_size = self.h_max if isinstance(self.step, FixedStep) else FIRST_STEP * self.h_max
        with naming_kernels(self):
            self.stepper.evaluate(self)
        start_balance(flow.ledger, flow.balance)
        begun, flow.z[:] = flow.z.copy(), self.work.z_new
        close_round_off_gaps(self.program, begun, flow)
        start_episodes(self.program.tables, flow)
        flow.largest_states[:] = np.abs(flow.v[self.program.tables.sizes.n_b : n])
        self.stepper.write(self)
        if self.program.samplers:
            self._cross_jump(time, NEVER, first=True)
        begin_watch(self)
        if code != RUNNING:
            self.code, self.note = code, self.stepper.explain(code) or ""

    def evaluate(self) -> None:
        """Evaluate energies, forces and signals of the state in `flow`."""
        self.stepper.evaluate(self)
        self.stepper.write(self)

    def one_step(self, limit: float) -> bool:
        """Take one step, not beyond the time `limit` [s], without saving; whether the step was accepted."""
        kept, self.max_steps = self.max_steps, int(self.record.count.steps) + 1
        self.run_to(limit, saving=None)
        self.max_steps = kept
        if self.note.startswith(STOPPED_AFTER):
            self.note, self.code = "", RUNNING
        return self.code in (RUNNING, DONE) and not self.note

    def resume(self, restart: Mapping[str, np.ndarray], label: str, *, redundant: bool = False) -> None:
        """Take the final state of another run of the same model."""
        if not isinstance(restart, Mapping):
            raise InputError(f"{label}: restart is {restart!r}; it must be `restart` of a solution of this mechanism.")
        try:
            self.record.signals[:] = fitting(restart, "signals", self.record.signals)
            self.flow.restore(restart)
            self.stepper.restore(restart)
            self.keep_fixed_step()
        except ValueError as error:
            text = f"{label}: restart does not fit this model ({str(error)!r} is missing, of another size or beyond"
            raise InputError(f"{text} its limits). Use `restart` of a solution of the same mechanism.") from error
        refuse_other_model(self.program, restart, label)
        refuse_broken_clock(self.flow.clock, label)
        if REDUNDANT in restart and not redundant:
            raise InputError(f"{label}: the run of the restart had redundant joints. Give redundant='least-norm', too.")
        if redundant:
            G = StateEvaluation(self.program).at(self.flow.q[: self.program.n_q], t=self.flow.clock.t).jacobian
            self._set_redundancy(len(surplus_rows(G)))
        begin_watch(self)

    def keep_fixed_step(self) -> None:
        """Set the size of fixed steps; a step after a much shorter one is a starting step."""
        if isinstance(self.step, FixedStep):
            self.flow.clock.step_size = self.h_max
            if self.flow.clock.last_step < SHORT_STEP * self.h_max:
                self.flow.clock.last_step, self.flow.x[:] = 0.0, self.flow.a

    def _set_redundancy(self, redundant: int) -> None:
        """Set the number of constraint equations that are redundant in every pose."""
        if redundant != self.redundant:
            q, t = self.flow.q[: self.program.n_q], float(self.flow.clock.t)
            rows = held_rows(self.program, self.work, q, t, redundant)
            self.redundant, self.trial = redundant, new_trial(self.program, redundant, self.bounds, rows)

    def run_to(self, end: float, saving: float | None) -> None:
        """Run until `end` [s]; `saving`: time between saved instants [s], 0 for every step, None for no saving."""
        # A step ends just before a jump of a drive or load, and the next one is a starting step just after the jump.
        if self.note or self.code not in (RUNNING, DONE):
            return  # a run that was stopped before the instants to be saved stays stopped
        if saving is not None:
            start_saving(self, saving)
        self.flow.balance.residual_limit = self.stepper.residual_limit
        interval = NEVER if saving is None else saving
        if self.progress:
            self.stepper.advance(self, self.options(end, interval), 0)  # compiled before a bar is shown
            notice.close()
        bar = ProgressBar(self.program.name, end, done=float(self.flow.clock.t), shown=self.progress, of="s of motion")
        try:
            with self.interruption:
                self._run_over_jumps(end, interval, bar, ends=saving is not None)
            if self.code == DONE and not self.note and 0.0 < interval < NEVER and saves_end(self, end):
                now = float(self.flow.clock.t)
                if not self.saved.is_at(now, 1e-6 * interval):
                    self.saved.add_one(now, self.record.signals)
        except MemoryError:
            self.note = f"Stopped: {self.saved.count:,} saved instants fill the memory; save fewer instants or signals"
        except KeyboardInterrupt as stop:
            self.note, self.interrupted = str(stop) or "Interrupted from the keyboard", True
            if is_in_job():
                raise  # or the job would go on with a run that is not whole
        finally:
            bar.close()

    def _run_over_jumps(self, end: float, interval: float, bar: ProgressBar, *, ends: bool) -> None:
        """Run until `end` [s], step by step over the jumps; `ends`: whether the balance of energies is drawn there."""
        flow, n = self.flow, self.program.tables.sizes.n_b
        begun, flow.balance.idle = 0.5 * flow.v[:n] * flow.momentum[:n], 0.0
        for instant in self.program.instants(float(flow.clock.t), end):
            if self._advance_to(just_before(instant), interval, bar, ahead=True):
                self._cross_jump(instant, interval)
                self.after_block(self)  # blocks between samples of a controller may all be short
            if self.met or self.note or self.code not in (RUNNING, DONE):
                break
        else:
            self._advance_to(end, interval, bar)
        if self.code == DONE and not self.note and ends:
            owners = self.program.reference.body[:n], self.trial.groups[:n]
            flow.balance.idle = idle_energy(*owners, begun, 0.5 * flow.v[:n] * flow.momentum[:n])
            size = max(self.program.length, 1.0)
            if COORDINATE_ROUND_OFF * np.abs(flow.q[:n]).max(initial=0.0) > LARGEST_ROUND_OFF * size:
                flow.balance.round_off = 0.0  # a state without digits excuses no residual
            self.code = check_balance_at_end(flow.ledger, flow.balance) or DONE

    def _advance_to(self, target: float, interval: float, bar: ProgressBar, *, ahead: bool = False) -> bool:
        """Run until `target` [s]; whether the run reached it; `ahead`: even without a step left."""
        options = self.options(target, interval)
        steps, self.code = max(FIRST_BLOCK_UPDATES // (self.program.symbolic.n + 1), 16), RUNNING
        while self.code == RUNNING and not self.note:
            began = time.perf_counter()
            if self.max_steps is not None:
                steps = max(0, min(steps, self.max_steps - int(self.record.count.steps)))
            located = self.stopping is not None and not all(one.is_fault for one in self.stopping.conditions)
            begun = Snapshot(self) if located else None
            if steps == 0 and ahead and self.flow.clock.t >= (1.0 - 1e-12) * target:
                self.code = DONE
            elif steps == 0:
                self.note = f"{STOPPED_AFTER} {self.max_steps} steps, as asked for"
                return False
            else:
                self.advance(options, steps)
            if self.code == CONDITION_MET and self.stopping is not None:
                self.code = end_at_crossing(self, self.stopping, begun, target, interval)
            self.empty_buffer(options)
            bar.update(min(self.flow.clock.t, bar.total) - bar.n)
            took = time.perf_counter() - began
            steps = int(min(max(steps * min(BLOCK_SECONDS / max(took, 1e-6), 4.0), 16), 1_000_000))
            if self.code == BUFFER_FULL:
                self.code = RUNNING
            self.interruption.act()  # in the last block, too, or a loop of short runs could not be ended
            if self.code == RUNNING:
                self.after_block(self)
        return self.code == DONE and not self.met

    def advance(self, options: Options, steps: int) -> None:
        """Take at most `steps` steps; an exception of a user's kernel ends the run with a note."""
        try:
            with naming_kernels(self):
                self.code = self.stepper.advance(self, options, steps)
        except KernelError as error:
            self.note = f"Stopped: {str(error).rstrip('.')}"

    def _cross_jump(self, instant: float, interval: float, *, first: bool = False) -> None:
        """Cross a jump of loads: new accelerations, joint forces and powers; the next step is a starting step."""
        # Positions, velocities and energies stay; histories of sampled controllers change (`first`: of all of them).
        flow, n = self.flow, self.program.n_q
        flow.clock.t, flow.clock.last_step = instant, 0.0
        try:
            act(self.program.samplers, instant, self.record.signals, flow.z, every=first)
            solve = least_norm if self.redundant else accelerations
            a, lam = solve(self.program, flow.q[:n], flow.v[:n], instant, flow.z)
        except (KernelError, SolveError) as error:
            self.note = f"Stopped: {str(error).rstrip('.')}"
            return
        flow.a[:n], flow.x[:n], flow.lam[:] = a, a, lam
        kept = flow.ledger.copy()
        self.stepper.evaluate(self)
        flow.ledger[:] = kept
        record, before = self.record, self.record.signals.copy()
        self.stepper.write(self)
        add_peaks(record, instant)
        if interval == 0.0:
            self.saved.add_one(flow.clock.t, record.signals)
        elif interval < NEVER and self.saved.is_at(instant, SAME_INSTANT * interval):
            self.saved.replace_last(record.signals)  # an instant of the grid at the jump shows the state just after
        if self.stopping is not None:
            self.met = self.stopping.met(before, record.signals)

    def arguments(self, options: Options) -> tuple[Any, ...]:
        """Arguments of every compiled loop: tables, kernels, factors, options, state, trial, work, record."""
        common = (self.program.tables, self.program.addresses, self.lu, options, self.flow, self.trial)
        return *common, self.work, self.record

    def options(self, end: float, saving: float) -> Options:
        """Options of the compiled loop for a run until `end` that saves every `saving` [s]."""
        return Options(
            self.stepper.regular, self.stepper.first, self.stepper.form, NEWTON_TOLERANCE, NEWTON_ITERATIONS,
            float(self.program.length), FARTHEST_LEAP * self.program.shortest, isinstance(self.step, Adaptive),
            float(self.error), max(float(self.h_min), least_step(min(end, max(float(self.flow.clock.t), self.t_end)))),
            min(float(self.h_max), self.chords.longest(0.5 * (float(self.flow.clock.t) + end))), float(end),
            float(saving),
        )  # fmt: skip

    def _fetch_buffer(self) -> None:
        if self.record.count.episodes:
            self.episodes.append(self.record.episodes[: self.record.count.episodes].copy())
            self.record.count.episodes = 0
        rows = int(self.record.count.rows)
        if rows:
            self.saved.add(self.record.times[:rows], self.record.values[:rows])
            self.record.count.rows = 0

    def empty_buffer(self, options: Options) -> None:
        """Empty the buffer; repeatedly, if the last step has more instants than the buffer has rows."""
        self._fetch_buffer()
        while self.code == BUFFER_FULL and options.save_interval > 0.0:
            self.stepper.save(self, options)
            if self.record.count.rows == 0:
                return
            self._fetch_buffer()

    def solution(
        self, model: dict[str, Any], *, findings: Sequence[Finding] = (), late: LateFindings | None = None,
        wall_time: float = 0.0,
    ) -> Solution:  # fmt: skip
        """Solution of the run so far, with findings, later findings, and the time on the clock [s]."""
        own = [found("bookkeeping", (), remark) for remark in self.stepper.remarks()]
        faults, status = sentences(findings, errors=True), self.status()
        if faults:
            status = status.partition(" Try ")[0]  # the cause is known: no remedies of any failure
        program, kept = self.stepper.reported, slice(None) if self.kept is None else self.kept
        names, (time, values) = program.names.signals, self.saved.finished()
        return Solution(
            time=time, values=values, signals=names if self.kept is None else names.chosen(self.kept),
            peaks=Peaks(self.record.peak[kept].copy(), self.record.peak_time[kept].copy()),
            status=" ".join([status, *(f"Not ok: {fault}" for fault in faults)]),
            ok=self.code == DONE and not self.note and not faults, stats=self.stats(wall_time),
            aliases=program.names.aliases, shapes=program.shapes, restart=self.restart(),
            contacts=self.contact_log(), findings=(*findings, *own), late=late,
            model={**model, "flexmb": installed_version(), "method": repr(self.method), "step": repr(self.step)},
            mechanism=self.mechanism,
        )  # fmt: skip

    def restart(self) -> dict[str, np.ndarray]:
        """Present state by name, from which a run of the same model continues bit for bit."""
        # `Flow`, signals, fingerprint, arrays of the method (`Stepper.saved`); group `restart` of `results/netcdf.py`.
        own = {"signals": self.record.signals.copy(), MODEL: self.program.fingerprint}
        own |= {REDUNDANT: np.array([self.redundant])} if self.redundant else {}
        return {**self.flow.saved(), **own, **self.stepper.saved()}

    def stats(self, wall_time: float = 0.0) -> Stats:
        """Statistics of the run so far; `wall_time`: time on the clock [s]."""
        count, step = self.record.count, self.record.report
        numbers = (count.steps, count.rejected, count.iterations, count.evaluations, count.factorisations)
        smallest = step.smallest if count.steps else 0.0
        return Stats(*numbers, smallest, step.largest, wall_time, count.rejected_at_contacts, count.not_converged)

    def contact_log(self) -> ContactLog:
        """Rows of all contact intervals since saving began, running ones included."""
        running = running_episodes(self.program.tables, self.flow)
        rows = np.concatenate([*self.episodes, running if self.saving else running[:0]])
        return ContactLog(self.program.names.contacts, rows)

    def status(self) -> str:
        """Status of the run: a sentence on its end."""
        if self.met and self.code == DONE:
            return f"Stopped at t = {self.flow.clock.t:.9g} s as asked for: {self.met}."
        if self.note:
            return f"{self.note}, at t = {self.flow.clock.t:.6g} s."
        own = self.stepper.explain(self.code)
        if own is not None:
            return f"Stopped at t = {self.flow.clock.t:.6g} s: {own}"
        return sentence(self.program, self.code, self.flow, self.trial, self.record)
