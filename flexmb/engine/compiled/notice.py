"""Notices to the user while functions of the package are compiled, and the times they rest on.

flexmb compiles the time loop for this machine: about 21 s, once.
    flexmb: done in 22 s.

Beside other work it says "21 to 80 s": processor time, and time on the clock with the share that a short measure had.

The lines go to stderr; on a terminal the first one counts the seconds.  Nothing is said where nothing is compiled, by
worker processes but the first, or with FLEXMB_MESSAGES=0.
"""

import atexit
import multiprocessing
import os
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

from numba.core import event

# Processor time of compiling the large functions, measured by `python tests/speed/compile.py --costs`

REFERENCE_PACE = 0.0083  # processor time of the measure of pace on the machine of these costs [s] (`notice.pace`)
PACES = 5  # number of these measures
FIRST_STAGE = "the equations of motion"  # stage of kernels and other small functions
# Processor time of compiling large functions [s], by stage; small functions represent others, too.
STAGES: dict[str, dict[str, float]] = {
    FIRST_STAGE: {
        "flexmb.engine.system.evaluate.evaluate": 5.4,
        "flexmb.parts.joints.contact_point.direction_row": 0.5,
        "flexmb.parts.joints.revolute.coincide": 1.0,
    },
    "the accounts of a run": {
        "flexmb.engine.linalg.lu.factor": 1.4,
        "flexmb.engine.system.evaluate.evaluate_accepted": 3.2,
        "flexmb.engine.system.constraints.report_forces": 0.2,
        "flexmb.engine.energy.contact_losses": 0.5,
        "flexmb.engine.energy.update_balance": 1.0,
        "flexmb.engine.system.outputs.write_outputs": 1.3,
    },
    "what saves many instants within a step": {"flexmb.engine.step.acceptance.save_instants": 3.5},
    "the time loop": {"flexmb.engine.newmark.method.advance": 21.0},
    "the explicit time loop": {"flexmb.engine.step.runge_kutta.advance_explicit": 13.8},
    "the time loop of Radau's method": {"flexmb.engine.radau.method.advance_radau": 18.8},
    "the time loop of Dormand and Prince": {"flexmb.engine.dormand_prince.method.advance_dormand_prince": 17.1},
    "the loop of exponents": {
        "flexmb.engine.sensitivity.linearise.linearise": 10.1,
        "flexmb.engine.sensitivity.linearise.advance_histories": 1.8,
        "flexmb.engine.sensitivity.tangent_step.advance_with_tangents": 19.6,
    },
}

UNPIECED_FACTOR = 4.5  # factor of the time with a version of numba without pieces (`flexmb/engine/compiled/pieces.py`)
QUIET_SECONDS = 1.0  # time without a compilation, after which a stage has ended where nothing else runs [s]
LEAST_SECONDS = 1.0  # expected time of a stage, below which there is no notice [s]
NEARLY = 1.3  # ratio of the ends of a range of seconds that is told as its upper end
LINE_WIDTH = 79
caches: dict[str, Any] = {}  # where compiled code of each function of the package is kept, by name


def is_told() -> bool:
    """Whether this process prints notices; of several workers the first one alone does."""
    if os.environ.get("FLEXMB_MESSAGES") == "0" or sys.stderr is None:
        return False
    return multiprocessing.parent_process() is None or multiprocessing.current_process().name.endswith("-1")


def _line(text: str) -> None:
    """A line on stderr, above bars that stand there."""
    bars = getattr(sys.modules.get("tqdm"), "tqdm", None)
    if bars is not None and getattr(bars, "_instances", None):
        bars.write(text, file=sys.stderr)
    else:
        print(text, file=sys.stderr, flush=True)


def say(text: str) -> None:
    """A line on stderr."""
    if is_told():
        notice.close()
        _line(f"flexmb: {text}")


@cache
def say_once(text: str) -> None:
    """A line on stderr, once a process."""
    say(text)


@cache
def pace() -> tuple[float, float]:
    """Processor time over that on the machine of the costs; time on the clock over processor time [1]."""
    # What is timed is Python's own compiler: like numba it is made of many small steps.
    lines = "".join(f"x{k} = [f(a, {k}) for a in range(b) if a > {k}]\n" for k in range(400))
    clock, processor = time.perf_counter(), time.thread_time()
    for _ in range(PACES):
        compile(lines, "pace", "exec")
    clock, processor = time.perf_counter() - clock, time.thread_time() - processor
    return processor / (PACES * REFERENCE_PACE), max(1.0, clock / max(processor, 1e-9))


def expected(stage: str) -> float:
    """Measured time of compiling a stage without its cached functions [s]."""
    left = [cost for name, cost in STAGES[stage].items() if name not in caches or not caches[name].there()]
    return notice.times * sum(left)


class Notice(event.Listener):
    """Listener of numba's compilations that prints the notices."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._depth, self._text, self._stage, self._moving = 0, "", "", False
        self.times = 1.0
        """How much longer everything takes where functions are compiled one by one."""
        self._began = self._ended = self._cost = 0.0
        self._missing = ""
        self._pace: float | None = None
        self.seconds, self._entered = 0.0, 0.0
        """Time that compilations of this process have taken, those of users' functions included [s]."""

    def on_start(self, found: Any) -> None:
        """A function begins to be compiled."""
        function = found.data["dispatcher"].py_func
        with self._lock:
            if self._depth or (getattr(function, "__module__", None) or "").startswith("flexmb."):
                self._enter()
            if self._depth == 1 and is_told():
                name = f"{function.__module__}.{function.__qualname__}"
                self._open(name)
                self._missing = "" if name == self._missing else self._missing

    def on_end(self, found: Any) -> None:  # noqa: ARG002 - as numba asks
        """A function is compiled."""
        with self._lock:
            if self._depth:
                self._depth -= 1
                self._ended = time.perf_counter()
                self.seconds += 0.0 if self._depth else self._ended - self._entered

    def _enter(self) -> None:
        """Count a function within others; the time of the outermost one counts."""
        if self._depth == 0:
            self._entered = time.perf_counter()
        self._depth += 1

    @contextmanager
    def compiling(self, name: str) -> Iterator[None]:
        """Count the compilation of a user's function, with a line where it lasts longer than LEAST_SECONDS."""
        with self._lock:
            self._enter()
        began, line = time.perf_counter(), f"compiles your function {name!r} for this machine."
        late = threading.Timer(LEAST_SECONDS, lambda: _line(f"flexmb {line}"))
        late.daemon = True
        if is_told():
            late.start()
        try:
            yield
        finally:
            late.cancel()
            self.on_end(None)
            if is_told() and time.perf_counter() - began > LEAST_SECONDS:
                _line(f"flexmb: done in {time.perf_counter() - began:.0f} s.")

    @contextmanager
    def waiting(self, name: str, since: float) -> Iterator[None]:
        """A function is compiled in another process that began `since` seconds ago."""
        with self._lock:
            self._enter()
            if self._depth == 1 and is_told():
                self._open(name, since)
        yield
        self.on_end(None)

    def _open(self, name: str, since: float = 0.0) -> None:
        """Begin the stage of a function; a function without a stage belongs to the open stage, or to the first."""
        stage = next((stage for stage, costs in STAGES.items() if name in costs), self._stage or FIRST_STAGE)
        if stage == self._stage:
            return
        self.close()
        cost = expected(stage)
        alone, beside = pace()
        least = cost * alone - since
        most = max(least, cost * (self._pace or alone * beside) - since)
        if most < LEAST_SECONDS:
            return
        about = f"{most:.0f}" if most < NEARLY * least else f"{max(least, LEAST_SECONDS):.0f} to {most:.0f}"
        self._stage, self._began, self._cost = stage, time.perf_counter(), cost
        self._missing = max(STAGES[stage], key=lambda name: STAGES[stage][name])
        self._text = f"flexmb compiles {stage} for this machine: about {about} s, once"
        self._moving = sys.stderr.isatty() and "tqdm" not in sys.modules
        if self._moving:
            self._draw("")
        else:
            _line(f"{self._text}.")
        threading.Thread(target=self._watch, args=(self._began,), daemon=True).start()

    def _watch(self, began: float) -> None:
        """Count the seconds on a terminal, and end the stage when nothing is compiled any more."""
        while True:
            time.sleep(0.25)
            with self._lock:
                if self._began != began or not self._stage:
                    return
                if not self._depth and time.perf_counter() - self._ended > QUIET_SECONDS * pace()[1]:
                    self.close()
                elif self._moving:
                    self._draw("")

    def _draw(self, end: str) -> None:
        line = f"{self._text} ({time.perf_counter() - self._began:.0f} s)"
        print(f"\r{line:<{LINE_WIDTH}}", end=end, file=sys.stderr, flush=True)

    def close(self) -> None:
        """Say that it is done, if something was compiled."""
        with self._lock:
            if not self._stage or sys.stderr is None:
                return
            self._stage, took = "", max(self._ended - self._began, 0.0)
            if not self._missing:  # its largest function was among what was compiled: a better measure of the pace
                self._pace = took / self._cost
            if self._moving:
                self._draw("\n")
            _line(f"flexmb: done in {took:.0f} s.")


notice = Notice()  # listener of this process
event.register("numba:compile", notice)
atexit.register(notice.close)
