"""Stop conditions: a run ends when a signal crosses a level, at the instant of the crossing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import arguments, checks
from flexmb.engine.state.record import BUFFER_FULL, DIRECTION, DONE, LEVEL, NEVER, RUNNING
from flexmb.errors import InputError
from flexmb.model.mechanism import Mechanism
from flexmb.model.signal import hint, resolved
from flexmb.program.program import Names, Program

if TYPE_CHECKING:
    from flexmb.run.run import Run

BEGINS, ENDS = "begins", "ends"
PENETRATION = "penetration"  # signal of a contact that is positive while the contact lasts
MOST_TRIALS = 100  # number of trials of a search for the instant at most; bisection alone needs 53
# Part of a step below which no crossing near the instant 0 is resolved: matrices of shorter steps overflow.
FINEST = 1e-32
SAME = 1e-9  # distance beyond its level, relative to it, at which a signal may begin: a run goes on from its stop
LEAST = 1e-12  # the same distance for the level 0, in the unit of the signal


@dataclass(frozen=True)
class Condition:
    """A signal that crosses a level; made by `when`."""

    signal: str  # name of the signal
    level: float  # level, in the unit of the signal
    direction: int  # 1 rising through the level, -1 falling, 0 both
    text: str  # the condition in words
    is_event: bool = True  # whether only a crossing counts; else a run must not begin beyond the level
    is_fault: bool = False  # whether a run that meets it is not ok; its instant is not located
    pushed_by: str = ""  # name of a signal that must be positive where a fault is met; "": none


@arguments.checked
def when(
    signal: str, *, above: float | None = None, below: float | None = None, crosses: float | None = None,
    contact: str | None = None,
) -> Condition:  # fmt: skip
    """Condition that ends a run: `simulate(..., stop=when("slider.x", above=0.1))`.

    Parameters
    ----------
    signal : name of a signal; for `contact` the name of a joint with clearance or of another contact.
    above, below, crosses : level that the signal rises through, falls through, or crosses in any direction.
    contact : "begins" or "ends".

    Returns
    -------
    Condition : for the argument `stop` of `simulate`, also in a list: the first that is met ends the run.

    Raises
    ------
    InputError : none or several of the four, a level that is no finite number.

    Notes
    -----
    Signals are compared at the ends of steps.  A signal that crosses its level twice within one step is not seen; give
    smaller steps.  The instant is found by shorter and shorter last steps, to round-off of the time.  A signal that
    begins a run at its level (`above`, `below`) and goes beyond it ends the run; after a restart it does not.  A
    contact that touches at the start has begun: only its next onset ends the run.
    """
    given = {"above": above, "below": below, "crosses": crosses, "contact": contact}
    named = [name for name, value in given.items() if value is not None]
    if not isinstance(signal, str):
        raise InputError(f"when: the signal is {signal!r}; it must be a name such as 'slider.x'.")
    if len(named) != 1:
        said = " and ".join(named) or "no level"
        raise InputError(f"when({signal!r}): {said} given; give one of above, below, crosses or contact.")
    if contact is not None:
        checks.one_of(f"when({signal!r})", "contact", contact, (BEGINS, ENDS))
        words = f"contact of {signal} {contact}"
        return Condition(f"{signal}.{PENETRATION}", 0.0, 1 if contact == BEGINS else -1, words)
    level = checks.number(f"when({signal!r})", named[0], given[named[0]])
    words = f"{signal} {named[0]} {level:g}"
    return Condition(signal, level, {"above": 1, "below": -1, "crosses": 0}[named[0]], words, crosses is not None)


class StopConditions:
    """Stop conditions of a run, one, several or None, and faults: conditions of runs that are not ok."""

    def __init__(self, label: str, names: Names, stop: Any, faults: Sequence[Condition] = ()) -> None:
        several = () if stop is None else stop
        conditions = [stop] if isinstance(stop, Condition) else checks.sequence(label, "stop", several, "conditions")
        rows: list[tuple[int, Condition, int]] = []
        for one in (*faults, *conditions):
            if not isinstance(one, Condition):
                text = f"{label}: stop holds {one!r}; it must be a condition"
                raise InputError(f"{text}, e.g. fm.when('slider.x', above=0.1), or a list of conditions.")
            place = names.signals.places.get(resolved(one.signal, names.signals, names.aliases))
            places = [] if place is None else [place]
            if place is None and one.signal.endswith(f".{PENETRATION}"):  # those of all contacts of a part
                part = one.signal.removesuffix(PENETRATION)
                own = [name for name in names.signals.names if name.startswith(part)]
                places = [names.signals.places[name] for name in own if name.rpartition(".")[2] == PENETRATION]
            if not places:
                text = f"{label}: stop asks for {one.text!r}, but there is no signal {one.signal!r}"
                raise InputError(f"{text}. {hint(one.signal, names.signals, names.aliases)}")
            signs = (1, -1) if one.direction == 0 else (one.direction,)
            rows += [(place, one, sign) for place in places for sign in signs]
        self.label, self.signals = label, names.signals
        self.conditions = [condition for _, condition, _ in rows]
        self.places = np.array([place for place, _, _ in rows], dtype=np.int64)
        levels = [[one.level, float(sign), float(not one.is_fault)] for _, one, sign in rows]
        self.levels = np.array(levels).reshape(-1, 3)

    def watch(self, run: Run, *, faults_alone: bool = False, fresh: bool = False) -> None:
        """Let the compiled loop of a run watch the conditions from its present state on."""
        # With `faults_alone` only faults are watched; `fresh`: the run begins anew, and does not go on from a stop. A
        # condition that is met already is refused.
        count = sum(one.is_fault for one in self.conditions) if faults_alone else len(self.conditions)
        for k, one in enumerate(self.conditions[:count]):
            place, (level, sign, _) = self.places[k], self.levels[k]
            value = float(run.record.signals[place])
            if fresh and value == level and not (one.is_event or one.signal.endswith(f".{PENETRATION}")):
                self.levels[k, LEVEL] += sign * (SAME * abs(level) or LEAST)
            if not one.is_event and sign * (value - level) > 2.0 * (SAME * max(abs(level), abs(value)) + LEAST):
                t = float(run.flow.clock.t)
                text = f"{self.label}: stop: {one.text!r} is met already at t = {t:g} s, where watching begins and "
                text += f"{one.signal} is {value:g}"
                raise InputError(f"{text}. Give another level, or crosses= for the next crossing.")
        if count != len(run.record.watched):
            run.record = run.record.replaced(watched=self.places[:count], levels=self.levels[:count])
            run.stopping = self

    def fault(self, number: int) -> str:
        """Text of a fault; "" for a condition of the user."""
        one = self.conditions[number]
        return one.text if one.is_fault else ""

    def met(self, before: np.ndarray, after: np.ndarray) -> str:
        """The first condition that is met between two rows of all signals, in words; "" for none."""
        numbers = self.all_met(before, after)
        return self.conditions[numbers[0]].text if numbers else ""

    def all_met(self, before: np.ndarray, after: np.ndarray) -> list[int]:
        """Numbers of the conditions that are met between two rows of all signals."""
        pairs = enumerate(zip(self.places, self.levels, strict=True))
        return [k for k, (p, (x, sign, _)) in pairs if sign * (before[p] - x) < 0.0 <= sign * (after[p] - x)]

    def excess(self, number: int, signals: np.ndarray) -> float:
        """Excess of a watched signal over its level, positive beyond it."""
        level, sign, _ = self.levels[number]
        return float(sign * (signals[self.places[number]] - level))


class Snapshot:
    """State of a run with empty buffers between two blocks of steps, to which the run can return."""

    FIELDS = ("peak", "peak_time", "signals", "last_signals", "last_lam", "last_z", "held_rows", "lows")

    def __init__(self, run: Run) -> None:
        record = run.record
        self.flow, self.own = run.flow.saved(), run.stepper.saved()
        self.count, self.report = record.count.numbers(), record.report.numbers()
        self.arrays = {name: getattr(record, name).copy() for name in self.FIELDS}
        self.poses = record.poses.saved()
        self.rows, self.episodes = run.saved.count, len(run.episodes)

    def restore(self, run: Run) -> None:
        """Take a run back to this state."""
        record = run.record
        run.flow.restore(self.flow)
        run.stepper.restore(self.own)
        record.count.set_numbers(self.count)
        record.report.set_numbers(self.report)
        record.poses.restore(self.poses)
        for name, array in self.arrays.items():
            getattr(record, name)[:] = array
        run.saved.shorten(self.rows)
        del run.episodes[self.episodes :]


def end_at_crossing(run: Run, watch: StopConditions, begun: Snapshot | None, end: float, interval: float) -> int:
    """End a run at the instant at which a condition was met in its last step; DONE, or the code of another ending."""
    # The last block is run again up to the step before, then steps of other sizes are tried from there. `begun` is the
    # state at the start of that block, None where only faults are watched; `end` is the end of its steps [s],
    # `interval` the time between saved instants [s].
    number = int(run.record.count.condition) - 1
    if begun is None or watch.fault(number):
        pushed_by = watch.conditions[number].pushed_by
        if pushed_by and not float(run.record.signals[watch.signals.places[pushed_by]]) > 0.0:
            return BUFFER_FULL  # the run goes on, after saved instants that may be due
        run.note = f"Stopped: {watch.fault(number)}"
        return RUNNING
    steps, beyond = int(run.record.count.steps) - 1, float(run.flow.clock.t)
    begun.restore(run)
    while int(run.record.count.steps) < steps:
        code = take(run, end, interval, steps - int(run.record.count.steps))
        if code not in (RUNNING, BUFFER_FULL):
            return code
    before, begun_at, start = Snapshot(run), float(run.flow.clock.t), run.record.signals.copy()

    def excess(t: float) -> float:
        """Excess of condition `number` at the end of steps from the state before to the time t."""
        before.restore(run)
        take(run, t, NEVER, MOST_TRIALS)
        return watch.excess(number, run.record.signals) if run.flow.clock.t >= t else np.nan

    last = beyond
    for _ in watch.conditions:  # another condition may be met earlier in the same step
        last = crossing_time(excess, begun_at, last, watch.excess(number, start))
        excess(last)
        others = [k for k in watch.all_met(start, run.record.signals) if k != number and not watch.fault(k)]
        if not others:
            break
        number = others[0]
    before.restore(run)
    run.record.levels[:, DIRECTION] = 0.0  # nothing is watched any more
    code = take(run, last, interval, MOST_TRIALS)
    if code == DONE:
        run.met = watch.conditions[number].text
    return code


def take(run: Run, end: float, saving: float, steps: int) -> int:
    """Take at most `steps` steps until `end` [s], saving every `saving` [s]; RUNNING, or the code of the ending."""
    options = run.options(end, saving)
    run.advance(options, steps)
    run.empty_buffer(options)
    return run.code


def crossing_time(excess: Callable[[float], float], low: float, high: float, below: float) -> float:
    """Time [s] at which a function turns positive, by regula falsi (Illinois) within bisection, to round-off."""
    # It is not positive at `low`, where its value is `below`, and positive at `high` [s]; nan is taken as positive.
    least, above, side = FINEST * (high - low), excess(high), 0
    for _ in range(MOST_TRIALS):
        if high - low <= max(4.0 * np.spacing(high), least):
            break
        t = low + (high - low) * (below / (below - above) if np.isfinite(above) and below < 0.0 else 0.5)
        margin = 2.0 * np.spacing(high)
        t = min(max(t, low + margin), high - margin)
        value = excess(t)
        if value < 0.0:
            low, below = t, value
            above *= 0.5 if side < 0 else 1.0
            side = -1
        else:
            high, above = t, value
            below *= 0.5 if side > 0 else 1.0
            side = 1
    return high


# Distance of a signal from its target, by its unit, at which control is lost; m count in sizes of the mechanism.
LOST = {"rad": 200.0 * np.pi, "rad/s": 1e4, "m": 100.0, "m/s": 1e4}
TIMES_TARGET = 100.0  # the same distance over the largest target, where that is more


def lost_control(mechanism: Mechanism, program: Program, end: float) -> Iterator[Condition]:
    """Conditions that end a run until `end` [s]: a signal far from its target, pushed on by a controller's load."""
    # Far is, say, a hundred turns, which no working controller lets happen. A run goes on while the load brakes.
    signals = program.names.signals
    for controller in mechanism.controllers:
        name, low, high = controller.followed(end) or ("", 0.0, 0.0)
        place = signals.places.get(resolved(name, signals, program.names.aliases))
        unit = "" if place is None else signals.units[place]
        if place is None or unit not in LOST:
            continue
        far = max(LOST[unit] * (program.length if unit == "m" else 1.0), TIMES_TARGET * max(abs(low), abs(high)))
        load = next(iter(controller.control().loads), "")
        text = f"{controller.label} drives {name!r} away from its target, by {far:.3g} {unit} so far: the sign of its"
        text = f"{text} gains{f' or of {load!r}' if load else ''} is wrong, or the loop is unstable (see fm.check)"
        power = f"{load}.power" if f"{load}.power" in signals.places else ""
        for level, sign in ((high + far, 1), (low - far, -1)):
            yield Condition(signals.names[place], level, sign, text, is_fault=True, pushed_by=power)
