"""Steps taken one at a time from Python."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from flexmb import arguments
from flexmb.engine.state.record import DONE
from flexmb.engine.step.method import Method
from flexmb.engine.step.step_size import FixedStep
from flexmb.errors import InputError, SolveError
from flexmb.model.mechanism import Mechanism
from flexmb.model.signal import hint, resolved
from flexmb.results.solution import Stats, UnknownSignalError
from flexmb.run.run import Run
from flexmb.run.simulate import Step, begin_or_resume, check_end, period_or_none, prepared


class StepState(Mapping[str, float]):
    """A mechanism after a step of `steps`: time, signals, cost; `state["slider.x"]` is a float.

    It stays what it was when further steps are taken.

    Parameters
    ----------
    run : the run that took the step.
    h : size of the step [s].

    Attributes
    ----------
    t : time [s].
    h : size of the step that led here [s]; 0 for the start.
    values : (n_s,) all signals, in the order of the names, read-only.
    restart : the state by name, as `restart` of a `Solution`: `simulate(..., restart=state.restart)` goes on from it.
    stats : what it has cost so far.

    Raises
    ------
    UnknownSignalError : of `state[name]` for a name that is no signal; also a `KeyError`.
    """

    def __init__(self, run: Run, h: float) -> None:
        self._names, self._owner = run.stepper.reported.names, run.stepper.reported.name
        self.t, self.h = float(run.flow.clock.t), h
        self.values = run.record.signals.copy()
        self.values.flags.writeable = False
        self.restart = run.restart()
        self.stats: Stats = run.stats()

    def __getitem__(self, name: str) -> float:
        signals, aliases = self._names.signals, self._names.aliases
        place = signals.places.get(resolved(name, signals, aliases)) if isinstance(name, str) else None
        if place is None:
            raise UnknownSignalError(f"{self._owner!r} has no signal {name!r}. {hint(str(name), signals, aliases)}")
        return float(self.values[place])

    def __contains__(self, name: object) -> bool:
        signals = self._names.signals
        return isinstance(name, str) and resolved(name, signals, self._names.aliases) in signals.places

    def __iter__(self) -> Iterator[str]:
        return iter(self._names.signals.names)

    def __len__(self) -> int:
        return len(self.values)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self)

    def __repr__(self) -> str:
        return f"State of {self._owner!r} at t = {self.t:.6g} s, after a step of {self.h:.3g} s"


@arguments.checked
def steps(
    mechanism: Mechanism,
    *,
    t_end: float | None = None,
    step: Step | None = None,
    method: Method | None = None,
    restart: Mapping[str, np.ndarray] | None = None,
    redundant: str = "refuse",
) -> Iterator[StepState]:
    """Take the steps of `simulate` one at a time: first the start, then the state after every accepted step.

    Parameters
    ----------
    mechanism : the mechanism.
    t_end : end [s], > 0; None: the steps go on until the loop is left.
    step, method, restart, redundant : see `simulate`.  Without t_end error-controlled steps need drives with a common
        period, or `Adaptive(max=...)`.

    Yields
    ------
    StepState : time, signals and the state itself.

    Raises
    ------
    InputError : see `simulate`; no end, no period and no largest step.
    SolveError : a step fails; the sentence says what happened, as the status of a `Solution` does.

    Notes
    -----
    The steps are those of `simulate(..., save="steps")`, to the bit; where a drive or load jumps, the
    state after it.  Taken one at a time each costs some 0.1 ms more.

    Examples
    --------
    >>> import flexmb as fm
    >>> for state in fm.steps(fm.mechanisms.slider_crank(), step=1e-5):
    ...     if state["slider.vx"] < -5.0:
    ...         break
    >>> state.t < 0.01
    True
    """
    label = f"steps of {getattr(mechanism, 'name', mechanism)!r}"
    method, chosen, program, closed = prepared(label, mechanism, method, step, redundant)
    period = period_or_none(program) if any(p is not None for p in program.periods) else None
    end = np.inf if t_end is None else check_end(label, t_end)
    span = _span(label, chosen, end, period)
    run = Run(program, method, chosen, span, period, mechanism=mechanism)
    begin_or_resume(run, mechanism, closed, label, restart, redundant, end)
    return _taken(run, end)


def _span(label: str, step: Any, end: float, period: float | None) -> float:
    """Time by which the largest step is chosen [s]."""
    if end < np.inf:
        return end
    if period is not None:
        return period
    largest = step.size if isinstance(step, FixedStep) else step.max
    if largest is None:
        text = f"{label}: there is no t_end, and the drives have no common period that says how long steps may be"
        raise InputError(f"{text}. Give t_end=, step=Adaptive(max=...) or a fixed step.")
    return float(1e3 * largest)


def _taken(run: Run, end: float) -> Iterator[StepState]:
    """The start and the state after each step."""
    yield StepState(run, 0.0)
    far = end if end < np.inf else 1e9 * run.h_max
    while run.code != DONE:
        before = run.record.count.steps
        if not run.one_step(far):
            raise SolveError(run.status())
        if run.record.count.steps > before:
            yield StepState(run, float(run.record.report.size))
