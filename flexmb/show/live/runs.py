"""Runs of a live page in one thread: the newest values win, long runs show their rows so far, runs may go on."""

import threading
from collections.abc import Callable, Mapping
from contextvars import copy_context
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from flexmb.errors import USER_ERRORS, FlexmbError, InputError
from flexmb.findings.check import Report
from flexmb.model.mechanism import Mechanism
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.results.positions import at_times
from flexmb.results.solution import Solution
from flexmb.run.run import AFTER_BLOCK, Run
from flexmb.run.simulate import clock, period_or_none, simulate
from flexmb.show.live.knobs import LABEL, Knob, Knobs, Value
from flexmb.show.reports.run_page import examined

# Keywords of `simulate` for the length of a run.
PERIODS, SECONDS = "periods", "t_end"
DEFAULT_PERIODS, DEFAULT_SECONDS = 2.0, 1.0  # lengths of a run where none is given: periods; time [s]
SHORTEST, LONGEST = 0.05, 250.0  # shortest and longest run over the first length
# Saved instants of a run, about; of a period at most and at least.
ROWS, ROWS_OF_A_PERIOD, FEWEST_OF_A_PERIOD = 2000, 400, 40
MOST_SECONDS = 120.0  # time on the clock after which a run is ended [s]
EVERY = 0.4  # time between two views of a run that lasts [s on the clock]
QUIET = 0.2  # time without other values after which a mechanism is examined [s on the clock]
MOST_POINTS, MOST_NUMBERS = 5000, 1_000_000  # points of a section at most; numbers of these points in all
JOIN = 5.0  # longest time for which a closing page waits for its thread [s on the clock]
CLOSED = f"{LABEL}: the page is closed. Open another one, in a notebook by its cell."
REPLACED, TOO_LONG = "Ended for newer values", f"Stopped after {MOST_SECONDS:g} s on the clock"


@dataclass(frozen=True)
class View:
    """Result of a run of a live page."""

    values: Mapping[str, Value]  # values of the knobs, by name
    length: float  # length of the run, in periods or seconds
    status: str  # how the run ended, a sentence; or the error that kept it from beginning
    ok: bool = False  # whether it reached its end
    solution: Solution | None = field(default=None, repr=False)  # the run; None after an error
    # largest absolute values of all signals over all accepted steps, by name
    largest: Mapping[str, float] = field(default_factory=dict, repr=False)
    mechanism: Mechanism | None = field(default=None, repr=False)
    section: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)), repr=False)
    number: int = 0
    done: bool = True
    period: float | None = None


def view_of(request: "Request", mechanism: Mechanism, sol: Solution, **more: Any) -> View:
    """View of a solution."""
    largest = dict(zip(sol.names, sol.peaks.values.tolist(), strict=True))
    more |= {"mechanism": mechanism, "number": request.number}
    return View(request.values, request.length, sol.status, sol.ok, sol, largest, **more)


@dataclass(frozen=True)
class Request:
    """Values and length of a run, with its number."""

    number: int
    values: Mapping[str, Value]
    length: float


Published = Callable[[View], None]
Examined = Callable[[int, Report | str], None]


class Runner:
    """Thread that runs a mechanism for the newest values, and publishes views and examinations from there."""

    def __init__(self, knobs: Knobs, unit: str, length: float, published: Published, examined: Examined) -> None:
        about = ("", "length of the run in periods of the drives") if unit == PERIODS else ("s", "length of the run")
        self.span = Knob(unit, "number", length, SHORTEST * length, LONGEST * length, *about)
        self.knobs, self.unit = knobs, unit
        self.published, self.examined = published, examined
        self.request = Request(0, knobs.start, length)
        self.latest = View(knobs.start, length, "not run yet", number=-1)
        self.finished = -1  # number of the newest request that has ended
        self.goes_on = self.closed = False
        self.changed = threading.Condition()
        self.thread = threading.Thread(target=self._work, name="flexmb live page", daemon=True)

    def first(self) -> None:
        """First run, with compilations, in the calling thread."""
        self.latest = self._view(self.request, None)
        self.finished = self.latest.number

    def start(self) -> None:
        """Start the thread."""
        self.thread.start()

    def close(self) -> None:
        """End the run and the thread."""
        with self.changed:
            self.closed = True
            self.changed.notify_all()
        if self.thread.is_alive() and self.thread is not threading.current_thread():
            self.thread.join(JOIN)

    def submit(self, values: Mapping[str, Any], length: Any = None) -> Request:
        """Ask for a run with other values and another length; the others stay.  Wrong ones raise `InputError`."""
        given = self.knobs.checked(values)
        if self.closed:
            raise InputError(CLOSED)
        with self.changed:
            longer = self.request.length if length is None else self.span.number(length)
            self.request = Request(self.request.number + 1, {**self.request.values, **given}, longer)
            self.changed.notify_all()
            return self.request

    def wait(self, request: Request) -> View:
        """View of a request, or of the newer one that took its place."""
        with self.changed:
            self.changed.wait_for(lambda: self.finished >= request.number or self.closed)
            if self.finished < request.number:
                raise InputError(CLOSED)
            return self.latest

    def go_on(self, wanted: bool) -> None:
        """Let runs go on from their ends, or not."""
        with self.changed:
            self.goes_on = wanted
            self.changed.notify_all()

    def outdated(self, request: Request) -> bool:
        """Presence of newer values, or the end of the page."""
        return self.closed or self.request.number != request.number

    def _work(self) -> None:
        request, is_examined = self.request, False
        while True:
            with self.changed:
                going = self.goes_on and self.latest.ok and len(self.latest.section) < MOST_POINTS
                if not going and not self.outdated(request):
                    self.changed.wait(None if is_examined else QUIET)
                if self.closed:
                    return
                newest = self.request
            if newest.number != request.number:
                request, is_examined = newest, False
                self._serve(request)
            elif going:
                self._serve(request, self.latest)
            elif not is_examined:
                is_examined = True
                if self.latest.mechanism is not None:
                    self.examined(self.latest.number, examined(self.latest.mechanism))

    def _serve(self, request: Request, before: View | None = None) -> None:
        """Run a request, or go on from a view, and publish the result."""
        view = self._view(request, before)
        if not view.status.startswith(REPLACED):
            with self.changed:
                self.latest = view
            self.published(view)
            with self.changed:  # after its message, so that a script goes on beside a page that knows the run
                self.finished = view.number
                self.changed.notify_all()

    def _view(self, request: Request, before: View | None) -> View:
        """View of a run, or of the error that it ended with."""
        try:
            return self._run(request, before)
        except (*USER_ERRORS, SystemExit) as error:  # also of a function that ends its program: the page stays
            said = str(error) if isinstance(error, FlexmbError) else f"{type(error).__name__}: {error}"
            return View(request.values, request.length, said, number=request.number)

    def _run(self, request: Request, before: View | None) -> View:
        mechanism = self.knobs.mechanism(request.values) if before is None else before.mechanism
        if mechanism is None:
            raise InputError(f"{LABEL}: there is no run to go on from.")
        period = period_or_none(compile_mechanism(mechanism))
        begun, restart = 0.0, None
        if before is not None and before.solution is not None:
            restart = before.solution.restart
            begun = float(before.solution.time[-1]) / (period or 1.0 if self.unit == PERIODS else 1.0)
        many = request.length if self.unit == PERIODS else 1.0
        save = int(np.clip(ROWS / many, FEWEST_OF_A_PERIOD, ROWS_OF_A_PERIOD))
        span: dict[str, Any] = {self.unit: begun + request.length, "save": save}
        if self.unit == SECONDS:
            span["save"] = request.length / ROWS_OF_A_PERIOD / 2.0
        if begun:
            span |= {"save_from_period" if self.unit == PERIODS else "save_from": begun, "restart": restart}
        watched, context = _Watch(self, request, mechanism), copy_context()
        context.run(AFTER_BLOCK.set, watched)
        sol = context.run(simulate, mechanism, **span)
        # Signals (n, n_s) once a period: rows of earlier runs, and saved instants of this one
        section = np.zeros((0, len(sol.names))) if before is None else before.section
        if period is not None and len(sol.time) > 1:
            first, last = np.floor(sol.time[[0, -1]] / period + 1e-6)
            times = period * np.arange(first + 1.0, last + 1.0)
            rows = at_times(sol, times).values  # a run in seconds saves other instants
            most = min(MOST_POINTS, MOST_NUMBERS // max(len(sol.names), 1))
            section = np.concatenate([section, rows])[-most:]
        return view_of(request, mechanism, sol, section=section, period=period)


class _Watch:
    """Observer of a run: ends it for newer values, shows its rows so far."""

    def __init__(self, runner: Runner, request: Request, mechanism: Mechanism) -> None:
        self.runner, self.request, self.mechanism = runner, request, mechanism
        self.begun = self.told = clock()

    def __call__(self, run: Run) -> None:
        if self.runner.outdated(self.request):
            raise KeyboardInterrupt(REPLACED)
        now = clock()
        if now - self.begun > MOST_SECONDS:
            raise KeyboardInterrupt(TOO_LONG)
        if now - self.told > EVERY and run.saved.count > 1 and self.runner.thread.is_alive():  # there is a page
            self.told = now
            sol = replace(run.solution({"name": self.mechanism.name}), status=f"Running: t = {run.flow.clock.t:.4g} s.")
            self.runner.published(view_of(self.request, self.mechanism, sol, done=False, period=run.period))
