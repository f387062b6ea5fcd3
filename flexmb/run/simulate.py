"""Simulation: start values, the compiled loop in blocks, the record of the run; steps taken one at a time."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import arguments, checks
from flexmb.dynamics.jobs.executors import tell_stopped
from flexmb.engine.compiled import ahead
from flexmb.engine.compiled.notice import notice
from flexmb.engine.newmark.method import Newmark
from flexmb.engine.state.record import DONE
from flexmb.engine.step.contact_events import LASTING_PHASE
from flexmb.engine.step.method import Method
from flexmb.engine.step.step_size import Adaptive, FixedStep
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import InputError, SolveError
from flexmb.findings import watch
from flexmb.findings.finding import found
from flexmb.findings.watch import Looked, amplification, vibration_findings
from flexmb.model.mechanism import Mechanism
from flexmb.model.signal import hint, resolved
from flexmb.program.compiler import common_period, compile_with_start
from flexmb.program.program import COMMON_Z, FRICTION_Z, NORMAL_Z, PHASE, Program
from flexmb.results.solution import SAVED_KEY, STEPS_KEY, Solution, Stats, UnknownSignalError, matching
from flexmb.run.checkpoint import EVERY, Checkpoints, digest, plain_values
from flexmb.run.run import KEYBOARD, NOT_SAVING, TERMINATION, Interruption, Run, passed_contacts, uncomputed_signals
from flexmb.run.saving import SaveGrid, reset_peaks, save_grid
from flexmb.run.stopping import Condition, StopConditions, lost_control
from flexmb.statics import equilibrium
from flexmb.statics.equilibrium import Equilibrium, Spin
from flexmb.statics.start.consistent import Start, accelerations, rigid_velocities, yielding_joints

Step = FixedStep | Adaptive | float
LEAST_NORM = "least-norm"
REDUNDANT = ("refuse", LEAST_NORM)  # what to do with joints that repeat one another
SHORTEST_RUN = 1e-100  # shortest run [s]
DEFAULT = Newmark.generalised_alpha()


@arguments.checked
@np.errstate(all="ignore")  # numbers that are not finite end as errors or statuses
def simulate(
    mechanism: Mechanism, *, t_end: float | None = None, periods: float | None = None, save_from: float = 0.0,
    save_from_period: float | None = None, save: int | float | Sequence[float] | np.ndarray | str = 1000,
    step: Step | None = None, method: Method | None = None, start: Equilibrium | str | None = None,
    restart: Mapping[str, np.ndarray] | None = None, max_steps: int | None = None, redundant: str = "refuse",
    signals: Sequence[str] | None = None, progress: bool = False, stop: Condition | Sequence[Condition] | None = None,
    checkpoint: str | Path | None = None, checkpoint_every: float = EVERY, resume: bool = False,
) -> Solution:  # fmt: skip
    """Simulate a mechanism from its reference configuration, or from an equilibrium.

    `save` takes a number of instants a period (an integer), an interval in s (a float), the times themselves in s (a
    list or an array), or "steps".  All other arguments have SI units.

    At the start the loops are closed, journals stand as their joints say, flexible bodies are unstressed
    and velocities those of the ideal rigid mechanism, but for the fields of displacement and velocity that bodies
    declare.  With `start` bodies, springs and contacts begin as they hang, with their forces.

    Parameters
    ----------
    mechanism : the mechanism.
    t_end : end [s], > 0; or
    periods : number of common periods of the drives.
    save_from : instant from which signals are saved and peaks are taken [s]; or
    save_from_period : the same in periods.
    save : an integer: number of instants a period (a run without periodic drives: in all); a float: interval [s]; a
        list or array: increasing times [s], which are saved and no others; "steps": every accepted step.  Instants
        within steps are interpolated, so the steps do not depend on them.
    step : `Adaptive(...)`, the default, or `FixedStep(size)`, for which the bare size [s] will do.
    method : `Newmark...` (default: generalised-alpha with spectral radius 0.8); `DormandPrince()` for motion that is
        smooth but for impacts, the fastest for rigid bodies; `RadauIIA()` for smooth and stiff motion to many digits;
        `RungeKutta4()`, which needs `FixedStep`.
    start : `static_equilibrium(mechanism)`, in which the run begins at rest but for drives and declared velocities,
        "equilibrium" for the same, if stable, or one with `spin`, which turns; None: the reference configuration.
    restart : `restart` of a solution of the same model; with the same step and method the run goes on bit for bit.
    max_steps : stop, with a status, after so many accepted steps.
    redundant : joints that repeat one another in every pose, as a third parallel crank does: "refuse" them, or
        "least-norm": of all multipliers that give the motion those with the least sum of squares are taken.  Forces in
        N and moments in N m then count alike, and only sums of forces of such joints mean something.  Friction in
        such joints follows these forces, and what drives work against it with them.
    signals : names of the signals that are saved, and patterns in which * stands for any text: ["slider.x", "rod.*"];
        the solution holds these and their peaks alone, in its usual order.  None: all; []: none.  Final state,
        contacts, statistics and status are whole in any case.  Drawing and VTK files need x, y, theta of all nodes.
    progress : show a progress bar with an estimate of the time left.
    stop : condition that ends the run, or several, see `when`; watched from `save_from` on.
    checkpoint : file from which a run that was ended from outside can go on, bit for bit; it is removed when the run
        reaches its end.  SIGTERM then ends a run as Ctrl-C does, with its results.  None: no such file.
    checkpoint_every : time between two checkpoints [s on the clock].
    resume : go on from the file `checkpoint` if it is there; the other arguments are those of the interrupted run.

    Returns
    -------
    Solution : its `ok` is True only if the run reached its end; `status` says in a sentence what happened,
        names the joints whose forces were not unique because the run passed a singular position; `notes` says where
        contact laws left their validity, and which contacts began very slowly or had no onset for a period.  A run
        whose energies miss 1 % of what was turned over or is in motion, or whose steps took or made 5 % of it, stops
        there and is not ok; so is one whose steps took or made 2 % of what went through contacts: its steps were too
        coarse.  From a fifth of these on `status` warns.

    Raises
    ------
    InputError : times that are not > 0, neither or both of t_end and periods, unknown kinds of step or method, a
        restart beyond the end, signals that the mechanism has not, more instants than the memory holds.
    ModelError, AssemblyError, KernelError : a mechanism that cannot start; see `compile` and `consistent_start`.
    """
    if not isinstance(mechanism, Mechanism):
        raise InputError(f"simulate: mechanism is {type(mechanism).__name__}; it must be Mechanism(name, parts).")
    label = f"simulate {mechanism.name!r}"
    method, chosen, program, closed = prepared(label, mechanism, method, step, redundant)
    period = common_period(program) if periods is not None or save_from_period is not None else None
    if period is None and any(p is not None for p in program.periods):
        period = period_or_none(program)
    end = _end(label, t_end, periods, period)
    begin = _begin(label, end, save_from, save_from_period, period)
    if max_steps is not None:
        checks.count(label, "max_steps", max_steps)
    kept = _chosen_places(label, program, signals)
    faults = [*watch.impossible_penetrations(mechanism, program.names.contacts), *lost_control(mechanism, program, end)]
    stopping = StopConditions(label, program.names, stop, faults)
    more: dict[str, Any] = {"max_steps": max_steps, "progress": progress}
    run = Run(program, method, chosen, end, period, mechanism=mechanism, kept=kept, **more)
    model = {"name": mechanism.name, STEPS_KEY: isinstance(save, str)}
    model |= {} if signals is None else {SAVED_KEY: list(signals)}
    command, kept_file = of_start(label, start, restart, redundant), None
    if checkpoint is not None:
        saved = save if isinstance(save, str | Real) else tuple(np.ravel(save).tolist())
        command |= plain_values(begin=begin, end=end, save=saved, step=chosen, method=method, redundant=redundant)
        command |= {"signals": repr(model.get(SAVED_KEY)), "restart": digest(restart), "stop": repr(stop)}
        command |= {} if restart is not None else {"start velocities": digest({"v": program.reference.v})}
        kept_file = Checkpoints(checkpoint, checkpoint_every, command, model)
    if kept_file is not None and resume and kept_file.path.is_file():
        kept_file.resume(run, label, redundant=redundant == LEAST_NORM)
    elif start is not None:
        run.begin(*start_at_rest(label, mechanism, run.stepper.program, closed, start))
    else:
        begin_or_resume(run, mechanism, closed, label, restart, redundant, end)
    if kept_file is not None:
        run.after_block, run.interruption = kept_file.after_block, Interruption([KEYBOARD, TERMINATION])
    begun = 0.0 if restart is None else float(restart["clock"][0])
    grid = save_grid(label, save, period, begin, end, begun)
    rows = len(grid.times) or ((end - max(begin, begun)) / grid.interval if grid.interval else 0.0)
    run.saved.require_room(label, rows)
    started = clock()
    try:
        _run_through(run, stopping, begin, end, grid, fresh=restart is None)
    finally:
        if kept_file is not None and run.interrupted:
            kept_file.write(run)
    return _solution(run, mechanism, closed, (begun, begin), model, kept_file, started)


def _run_through(run: Run, stopping: StopConditions, begin: float, end: float, grid: SaveGrid, *, fresh: bool) -> None:
    """Run to the begin of saving and to the end [s]; `fresh`: without a restart."""
    stopping.watch(run, faults_alone=True)
    if run.flow.clock.t < begin:
        run.flow.clock.save_start = NOT_SAVING  # a restart has the instant at which the run before began to save
        run.run_to(begin, saving=None)
        reset_peaks(run)
    stopping.watch(run, fresh=fresh)
    if len(grid.times):
        run.record = run.record.replaced(save_times=grid.times)
    run.run_to(end, saving=grid.interval)


def _solution(
    run: Run, mechanism: Mechanism, closed: Program, begun_saved: tuple[float, float], model: dict[str, Any],
    kept_file: Checkpoints | None, started: float,
) -> Solution:  # fmt: skip
    """Solution of a run that has ended, with findings; its checkpoint is written or removed."""
    # `begun_saved` holds the instants at which the run and its saving began [s].
    now, (begun, begin) = float(run.flow.clock.t), begun_saved
    span = run.period if run.period is not None else 0.5 * (now - begin)
    motion, contacts = watch.watched_motion(run), run.contact_log()
    findings = [*run.chords.findings, *watch.law_findings_after(run.program, run.flow.z, contacts, now - span)]
    findings += watch.watch_findings(mechanism, motion, contacts)
    findings += watch.failure_findings(run, mechanism, closed, known=any(finding.is_error for finding in findings))
    findings += [*passed_contacts(run), *uncomputed_signals(run)]
    if kept_file is not None:
        troubles = (kept_file.failure, "" if run.interrupted else kept_file.finish())
        findings += [found("bookkeeping", (), text) for text in troubles if text]
    examined = amplification(run.method, 1.0) is not None
    late = partial(vibration_findings, Looked.at(run, motion, begun)) if examined else None
    sol = run.solution(model=model, findings=findings, late=late, wall_time=clock() - started)
    if not sol.ok:
        tell_stopped(f"simulate {sol.name!r}", sol.status)
    return sol


def clock() -> float:
    """Time on the clock without that of compilations, from an arbitrary instant [s]."""
    return time.perf_counter() - notice.seconds


def period_or_none(program: Program) -> float | None:
    """The common period of the drives, or None when there is none."""
    try:
        return common_period(program)
    except InputError:
        return None


def prepared(
    label: str, mechanism: Mechanism, method: Method | None, step: Any, redundant: str
) -> tuple[Method, FixedStep | Adaptive, Program, Program]:
    """Method and step of the arguments of a run, checked, and the program of the mechanism, with that of its start."""
    method = DEFAULT if method is None else method
    if not isinstance(method, Method):
        known = "Newmark(...), RadauIIA(), DormandPrince(), RungeKutta4() or a method of your own"
        known += " (flexmb/engine/step/method.py)"
        raise InputError(f"{label}: method is {method!r}; it must be {known}.")
    ahead.start(*method.loops)
    programs = compile_with_start(mechanism)
    number = isinstance(step, Real) and not isinstance(step, bool)
    chosen: Any = Adaptive() if step is None else FixedStep(step) if number else step
    checks.one_of(label, "redundant", redundant, REDUNDANT)
    if not isinstance(chosen, FixedStep | Adaptive):
        raise InputError(f"{label}: step is {chosen!r}; it must be FixedStep(size) or Adaptive(...).")
    method.check(label, chosen, redundant)
    return method, chosen, *programs


def begin_or_resume(
    run: Run, mechanism: Mechanism, closed: Program, label: str, restart: Mapping[str, np.ndarray] | None,
    redundant: str, end: float,
) -> None:  # fmt: skip
    """Begin a run in the reference configuration, or go on from a restart, which must not lie beyond its `end` [s]."""
    least = redundant == LEAST_NORM
    if restart is None:
        run.begin(run.stepper.start(mechanism, closed, redundant=least))
        return
    run.resume(restart, label, redundant=least)
    now = float(run.flow.clock.t)
    if now > end * (1.0 + 1e-9):
        text = f"{label}: the restart stands at t = {now:g} s, beyond the end at {end:g} s"
        raise InputError(f"{text}. The end counts from the start of the first run; give a larger t_end or periods.")


def _end(label: str, t_end: float | None, periods: float | None, period: float | None) -> float:
    if (t_end is None) == (periods is None):
        text = f"{label}: t_end is {t_end!r} and periods is {periods!r}"
        raise InputError(f"{text}; give either t_end= (seconds) or periods= (of the drives).")
    if t_end is not None:
        return check_end(label, t_end)
    return checks.positive(label, "periods", periods) * float(period or 0.0)


def check_end(label: str, t_end: float) -> float:
    """`t_end` as a float, or `InputError`: squares of its steps must not be 0 among floats."""
    end = checks.positive(label, "t_end", t_end, "s")
    if end < SHORTEST_RUN:
        raise InputError(f"{label}: t_end is {end:g} s; it must be at least {SHORTEST_RUN:g} s.")
    return end


def _begin(label: str, end: float, save_from: float, save_from_period: float | None, period: float | None) -> float:
    begin = checks.not_negative(label, "save_from", save_from, "s")
    if save_from_period is not None:
        begin = checks.not_negative(label, "save_from_period", save_from_period) * float(period or 0.0)
    if begin >= end:
        text = f"{label}: saving begins at {begin:g} s, but the run ends at {end:g} s."
        raise InputError(f"{text} Run longer or save earlier.")
    return begin


def _chosen_places(label: str, program: Program, wanted: object) -> np.ndarray | None:
    """Places (n,) of the chosen signals, ascending, each once; None where that is all."""
    # Integrals and rates of states of controls are chosen by their whole names alone.
    if wanted is None:
        return program.shown
    signals, aliases = program.names.signals, program.names.aliases
    found: set[int] = set()
    for name in checks.sequence(label, "signals", wanted, "names such as 'slider.x' or 'slider.*'"):
        if not isinstance(name, str):
            raise InputError(f"{label}: signals holds {name!r}; it must hold names such as 'slider.x' or 'slider.*'.")
        own = resolved(name, signals, aliases)
        if own in signals.places:
            found.add(signals.places[own])
            continue
        fitting = matching(program.reported.names, own) if "*" in own else []
        if not fitting:
            what = "signal fits" if "*" in own else "signal is called"
            raise InputError(f"{label}: no {what} {name!r}. {hint(name, program.reported, aliases)}")
        found.update(signals.places[one] for one in fitting)
    return np.array(sorted(found), dtype=np.int64)


# Start values of a run that begins in an equilibrium, at rest or in steady rotation

EQUILIBRIUM = "equilibrium"  # word for the static equilibrium of the mechanism itself
# Violation of the joints and drives by the velocities of a steady rotation, relative to these velocities.
OTHER_SPEED = 1e-9


def of_start(label: str, start: Any, restart: Any, redundant: str) -> dict[str, str]:
    """Text of `start` beside the other arguments of a run, which must go with it."""
    if start is None:
        return {}
    if restart is not None or redundant != "refuse":
        raise InputError(f"{label}: start goes with neither restart nor redundant joints. Leave one of them out.")
    return {"start": f"{start!r} {digest({'q': getattr(start, 'q', ())})}"}


def start_at_rest(
    label: str, mechanism: Mechanism, program: Program, closed: Program, start: Any
) -> tuple[Start, np.ndarray]:
    """Start values of a run in an equilibrium, and the histories (n_z,) of its contacts, which last already."""
    # `start` is an equilibrium of this mechanism, or "equilibrium"; its steady rotation is one that the drives share.
    # `closed` is the program with ideal joints for contacts.
    if not isinstance(start, Equilibrium) and not (isinstance(start, str) and start == EQUILIBRIUM):
        text = f"{label}: start is {start!r}; it must be {EQUILIBRIUM!r},"
        raise InputError(f"{text} or what static_equilibrium(...) returns, also with spin=.")
    at = start if isinstance(start, Equilibrium) else equilibrium.static_equilibrium(mechanism)
    if at is not start and at.stable is False:
        text = f"{label}: start is {EQUILIBRIUM!r}, but the equilibrium is unstable; a run leaves it by round-off alone"
        raise InputError(f"{text}. Give start=static_equilibrium(...) to begin there, or declared velocities.")
    spin, system = Spin(at.spin, at.about), StateEvaluation(program)
    equilibrium.refuse_other_names(label, program, at)
    equilibrium.refuse_other_forces(label, program, system, at)
    held = yielding_joints(program, closed)
    v = spin.motion(at.q)[0][: program.n_q] if at.spin else rigid_velocities(closed, at.q, 0.0, held)
    system.at(at.q, v)
    G = system.jacobian.tocsr()
    held_alone = (np.diff(G.indptr) == 1) & (program.tables.constraints.motion < 0)  # the rotation of a particle
    alone = np.flatnonzero(held_alone)
    v[G.indices[G.indptr[alone]]] -= system.velocity_residual[alone] / G.data[G.indptr[alone]]
    missed = np.abs(system.at(at.q, v).velocity_residual).max(initial=0.0)
    if missed > OTHER_SPEED * np.abs(v).max(initial=0.0):
        text = f"{label}: the equilibrium turns at {at.spin:g} rad/s, and joints or drives allow no such motion (by"
        text += f" {missed:.3g} m/s or rad/s). Give the drive of the hub this speed, e.g. ConstantSpeed({at.spin:g}),"
        raise InputError(f"{text} and the place of the hub to static_equilibrium(..., about=).")
    z = np.array(program.reference.z)
    for k in np.flatnonzero(equilibrium.carries(system)):
        begin, law, end = program.tables.contacts.z[k, [COMMON_Z, NORMAL_Z, FRICTION_Z]]
        z[begin + PHASE], z[law:end] = LASTING_PHASE, program.normals[k].lasting_history()
    if not v.any() and not program.drives:
        return Start(at.q, v, np.zeros(program.n_q), at.lam), z
    return Start(at.q, v, *accelerations(program, at.q, v, 0.0, z)), z


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

    values: np.ndarray  # type: ignore[assignment] # has the name of a method of Mapping

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
    mechanism: Mechanism, *, t_end: float | None = None, step: Step | None = None, method: Method | None = None,
    restart: Mapping[str, np.ndarray] | None = None, redundant: str = "refuse",
) -> Iterator[StepState]:  # fmt: skip
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
    span = end if end < np.inf else period  # by which the largest step is chosen
    if span is None:
        largest = chosen.size if isinstance(chosen, FixedStep) else chosen.max
        if largest is None:
            text = f"{label}: there is no t_end, and the drives have no common period that says how long steps may be"
            raise InputError(f"{text}. Give t_end=, step=Adaptive(max=...) or a fixed step.")
        span = float(1e3 * largest)
    run = Run(program, method, chosen, span, period, mechanism=mechanism)
    begin_or_resume(run, mechanism, closed, label, restart, redundant, end)
    return _taken(run, end)


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
