"""Bifurcation diagrams: section points over the values of a parameter."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import checks
from flexmb.arguments import checked, require_arguments
from flexmb.dynamics.exponents import FEWEST
from flexmb.dynamics.jobs.executors import PENDING, Attempt, Chain, Job, Outcome, require_executor, stopped_runs
from flexmb.dynamics.jobs.progress import ProgressBar
from flexmb.dynamics.lyapunov import lyapunov
from flexmb.dynamics.sections import SectionSignals
from flexmb.dynamics.sweeps.parameter_sweep import POINTS, STATE, Work, settings_of
from flexmb.dynamics.sweeps.store import STATUS, Column, Record, label_of, shown_values
from flexmb.dynamics.systems.dynamics import Dynamics, as_dynamics, is_mechanism
from flexmb.engine.compiled.digest import digest
from flexmb.errors import AssemblyError, FlexmbError, InputError, SolveError
from flexmb.fields import unit_of
from flexmb.late import xr
from flexmb.version import installed_version

if TYPE_CHECKING:
    from flexmb.engine.newmark.method import Newmark
    from flexmb.model.mechanism import Mechanism
    from flexmb.run.simulate import Step

    Make = Callable[..., Mechanism | Dynamics] | Mechanism | Dynamics


@dataclass(frozen=True)
class Family:
    """Systems over the values of a parameter, by arguments of `bifurcation`; it can be sent to other processes."""

    make: Make
    parameter: str
    fixed: Mapping[str, Any]
    step: Step | None = None
    method: Newmark | None = None
    period: float | Callable[[float], float] | None = None

    @property
    def label(self) -> str:
        """Name of the calling function and parameter, for messages."""
        return f"bifurcation over {self.parameter!r}"

    def at(self, value: float) -> Dynamics:
        """System for a `value` of the parameter, in its own start state."""
        parameters = {**self.fixed, self.parameter: value}
        if isinstance(self.make, Dynamics):
            built: Any = self.make.copy()
            built.reset(parameters=parameters)
        else:
            built = self.make(**parameters) if callable(self.make) else self.make.with_(parameters)
        if isinstance(built, Dynamics) and built.unit != "s" and self.period is not None:
            text = f"{self.label}: period= has no influence on {built.name!r}, which counts {built.unit}"
            raise InputError(f"{text}. Leave it out.")
        if not isinstance(built, Dynamics) and not is_mechanism(built):
            text = f"{self.label}: the function returned {type(built).__name__}"
            raise InputError(f"{text}; it must return a Mechanism or a system such as Map.")
        return as_dynamics(self.label, built, step=self.step, method=self.method, period=self._declared(value))

    def period_of(self, flow: Dynamics, value: float) -> float:
        """Time between two section points [unit of the system]; 1 for maps."""
        if flow.unit != "s":
            return 1.0
        declared = self._declared(value)
        return declared if declared is not None else flow.required_period(self.label)

    def _declared(self, value: float) -> float | None:
        period = self.period(value) if callable(self.period) else self.period
        return None if period is None else checks.positive(self.label, "period", period, "s")


@dataclass(frozen=True)
class SectionSettings:
    """Section points and exponent to be computed for each value, by arguments of `bifurcation`."""

    # The number of periods for the exponent is 0 for none; `together`: they are those of the points.
    skip: int
    keep: int
    signals: tuple[str, ...]
    exponent: int = 0
    together: bool = False

    @property
    def last(self) -> int:
        """Number of the period that ends with the last point."""
        return self.skip + self.keep - 1


def section_point(family: Family, section: SectionSettings, value: float, carried: np.ndarray | None) -> Outcome:
    """Section points, verdict and exponent for one value of the parameter."""
    # The motion starts at the state `carried` from a neighbouring value; None: start state of the system.
    # The outcome has `points` (keep, signals); `seam`: whether a carried state could not be used; `state` after the
    # last point; `drive_period`, `verdict`, `exponent`, `exponent_error`. The outcome of a failure has no points.
    flow = family.at(value)
    if stopped := stopped_runs():  # of the function that makes the system
        return Outcome({}, stopped, ok=False)
    period = family.period_of(flow, value)
    columns = columns_of(flow, section.signals, family.label)
    seam = carried is not None and not _start_from(flow, carried, section.last * period)
    run: dict[str, Any] = {"period": period if flow.unit == "s" else None, "confirm": False}
    exponents = lyapunov(flow, skip=section.skip - 1, periods=section.keep, **run) if section.together else None
    points = _points(flow, period, section) if exponents is None else exponents.points
    if exponents is not None and not exponents.ok:
        points = None
    lost: list[str] = []  # signals that are not finite
    if points is not None:
        lost = [flow.names[k] for k in columns if not np.isfinite(points[:, k]).all()]
        lost = lost or ([] if np.isfinite(flow.state()).all() else ["the state"])
    values: dict[str, Any] = {"seam": seam, "drive_period": period if flow.unit == "s" else np.nan}
    if points is None or lost:
        return Outcome(values, f"Not finite: {', '.join(lost[:5])}." if lost else flow.status, ok=False)
    values |= {"points": points[:, columns], "state": flow.state() / _cycles(flow)}
    remark = ""
    if exponents is not None:
        verdict = exponents.verdict
    else:
        exponents = lyapunov(flow, periods=section.exponent, **run) if section.exponent else None
        if exponents is not None and not exponents.ok:
            remark, exponents = f" No exponent: {exponents.status}", None
        if exponents is None:
            verdict = SectionSignals.of(flow).verdict(points)
        else:
            points = np.concatenate([points, exponents.points])
            verdict = SectionSignals.of(flow).verdict(points, (), exponents.value, exponents.error)
    values["verdict"] = str(verdict)
    if exponents is not None:
        values |= {"exponent": exponents.value, "exponent_error": exponents.error}
    return Outcome(values, f"{section.keep} points, after {section.skip} that were skipped.{remark}")


def columns_of(flow: Dynamics, signals: tuple[str, ...], label: str) -> list[int]:
    """Numbers of the chosen signals among the signals of a system."""
    names = list(flow.names)
    return [names.index(checks.one_of(label, "signal", name, names)) for name in signals]


def _cycles(flow: Dynamics) -> np.ndarray:
    """Cycles (n,) of a state over 2 pi, 1 without one: a time is carried as a phase of the drive."""
    cycles = flow.cycles
    return np.array([cycles.get(k, math.tau) / math.tau for k in range(flow.size)])


def _start_from(flow: Dynamics, carried: np.ndarray, time: float) -> bool:
    """Reset the system to a carried state (n,); False after a failure, with a reset to the start state."""
    if carried.shape == (flow.size,):
        try:
            flow.reset(carried * _cycles(flow), time=time)
        except (AssemblyError, SolveError, InputError):
            flow.reset()
        else:
            return True
    return False


def _points(flow: Dynamics, period: float, section: SectionSettings) -> np.ndarray | None:
    """All signals (keep, n) at the ends of periods; None after a failure."""
    points, origin = np.empty((section.keep, len(flow.names))), flow.time
    for k in range(section.last + 1):
        if k > 0 and not flow.advance(1.0 if flow.unit != "s" else origin + k * period - flow.time):
            return None
        if k >= section.skip:
            points[k - section.skip] = flow.observe()
    return points


# Rows of a diagram by the name of the direction.
DIRECTIONS = {"cold": ("cold",), "up": ("up",), "down": ("down",), "both": ("up", "down")}
EXPONENT = "exponent", "exponent_error"
# Columns of a diagram besides `ok`, `status`, section points and final state.
COLUMNS = Column("seam", "flag"), Column("drive_period", units="s"), Column("verdict", "text"), *map(Column, EXPONENT)
# Names in the store that no parameter and no signal may have.
RESERVED = ("period", "direction", "signal", "units", "status", "ok", POINTS, STATE, *(c.name for c in COLUMNS))


@checked
def bifurcation(
    make: Make, parameter: str, values: Sequence[float], *, fixed: Mapping[str, Any] | None = None, skip: int,
    keep: int, direction: str = "cold", chunks: int = 1, signals: Sequence[str] | None = None,
    period: float | Callable[[float], float] | None = None, step: Step | None = None, method: Newmark | None = None,
    exponent: bool | int | str = False, executor: Executor | int | None = None, pending: int = PENDING,
    store: Any = None, resume: bool = False, progress: bool = False,
) -> xr.Dataset:  # fmt: skip
    """Bifurcation diagram: section points, one a period of the drives, at each value of a parameter.

    Parameters
    ----------
    make : a function that returns a Mechanism or a system, called as make(**fixed, **{parameter: value}); or a
        Mechanism, whose "part.field" is varied; or a system (Dynamics), of which a parameter is varied.
    parameter : name of the varied parameter.
    values : values of the parameter, finite and distinct.
    fixed : fixed values of other parameters.
    skip : number of periods at each value before the first point.
    keep : number of points at each value.
    direction : "cold": each value starts from the system's own start; "up" or "down": each value starts from the last
        state at the next lower or higher value, projected onto the joints; "both": up and down, each with a cold start.
    chunks : number of chunks into which the values of "up" and "down" are divided, for as many workers.  The first
        point of a chunk has a cold start, and there `seam` is True.
    signals : names of the signals to keep; None: all.
    period : time between two points [s], or a function period(value); None: the common period of the drives at each
        value.
    step, method : for mechanisms only, see `simulate`.
    exponent : number of periods after the points for the largest exponent; True: as many as points; "points": the
        periods that end with the points, at half the cost and with skip >= 1.  The error of the exponent is the error
        of one run, without a second run with finer steps as in `lyapunov`.  A diagram with another `step` shows the
        influence of the steps.
    executor, pending, store, resume, progress : as in `sweep`.

    Returns
    -------
    xarray.Dataset : each signal over (parameter, "period"), with "both" over ("direction", parameter, "period"); NaN
        at failed points.  Over the points alone: `ok`, `status`, `verdict`, `seam`, `drive_period` [s], `exponent` and
        `exponent_error` (NaN if not wanted) [1/s, or 1/iteration].

    Raises
    ------
    InputError : inadmissible values, names or settings; a function that cannot be sent to the executor; an existing
        store without `resume`, or a store of another sweep.
    WorkerError : workers that died; finished points are in the store.
    FlexmbError : an error of `make` at every value.

    Notes
    -----
    A failed point is kept with its status, and the diagram continues; the next point then starts from the last
    successful one.  Results do not depend on the executor or the number of workers, nor do the bytes of a finished
    store depend on interruptions.  Cold values are visited in an order that fills their range evenly, so an unfinished
    store shows the whole range.  A carried state starts at the time of `skip + keep - 1` periods, so a ramp of the
    drives that has ended by then is not repeated; one whose angle then differs from the carried one by more than the
    least clearance is a cold start, with `seam` True.  A section carries its time as a phase of the drive.

    Examples
    --------
    >>> import flexmb as fm
    >>> from flexmb.dynamics.systems.given import Map
    >>> def logistic(x, r):
    ...     return [r * x[0] * (1.0 - x[0])]
    >>> system = Map(logistic, [0.3], parameters={"r": 3.0})
    >>> found = fm.bifurcation(system, "r", [2.0, 3.2], skip=500, keep=4)
    >>> found["x0"].values.round(4)
    array([[0.5   , 0.5   , 0.5   , 0.5   ],
           [0.7995, 0.513 , 0.7995, 0.513 ]])
    """
    label = f"bifurcation over {parameter!r}"
    family = Family(make, parameter, checks.mapping(label, "fixed", fixed), step, method, period)
    listed = checks.sequence(label, "values", values, "numbers")
    for k, value in enumerate(listed):
        checks.number(label, f"values[{k}]", value)
    numbers = np.array(listed)  # integers remain integers
    if len(numbers) == 0:
        raise InputError(f"{label}: values is empty; give at least one.")
    if len(np.unique(numbers)) < len(numbers):
        raise InputError(f"{label}: a value is given twice; give each value once.")
    _check(family, direction, chunks, len(numbers))
    require_executor(label, executor)
    work = Work(label, (family, label_of(make)), executor, pending, store, resume, progress)
    first = first_of(family, numbers.tolist())
    names = first.names if signals is None else tuple(checks.sequence(label, "signals", signals, "names"))
    skip, keep = checks.count(label, "skip", skip, 0), checks.count(label, "keep", keep)
    section = SectionSettings(skip, keep, names, *_exponent_over(label, exponent, skip, keep))
    columns_of(first, names, label)  # unknown ones are refused here
    for name in (given := [parameter, *names]):
        if name in RESERVED or given.count(name) > 1:
            text = f"{label}: {name!r} is a name of the dataset, or given twice"
            raise InputError(f"{text}. Rename the parameter or the signal.")
    diagram, shape = _Diagram(family, section, numbers, direction, first), (len(DIRECTIONS[direction]), len(numbers))
    record = work.record("bifurcation", ("direction", parameter), shape, lambda: diagram.fingerprint(chunks))
    diagram.lay_out(record)
    if executor is not None and not record.done.all():
        first.prepare()
    return work.done(record, partial(diagram.chains, record, chunks))


@dataclass(frozen=True)
class _Diagram:
    """Systems, section points, values and direction of a diagram, and the system at the first value."""

    family: Family
    section: SectionSettings
    numbers: np.ndarray
    direction: str
    first: Dynamics

    def fingerprint(self, chunks: int) -> dict[str, Any]:
        """Values on which the results depend, with the compiled model at the first and at the last value."""
        family, section, last = self.family, self.section, "none"
        with Attempt():
            last = digest(family.at(self.numbers[-1].item()))
        period = family.period
        return settings_of(family.fixed, family.make) | {
            "make": label_of(family.make), "model": f"{digest(self.first)} {last}", "parameter": family.parameter,
            "values": shown_values(self.numbers.tolist()), "skip": section.skip, "keep": section.keep,
            "signals": shown_values(section.signals), "exponent": "points" if section.together else section.exponent,
            "period": f"{label_of(period)} ({digest(period)})" if callable(period) else period,
            "step": repr(family.step), "method": repr(family.method), "direction": self.direction, "chunks": chunks,
        }  # fmt: skip

    def lay_out(self, record: Record) -> None:
        """Set columns, coordinates and attributes of a diagram."""
        section, first, make, parameter = self.section, self.first, self.family.make, self.family.parameter
        record.add([*COLUMNS, Column(POINTS, dims=("period", "signal"), shape=(section.keep, len(section.signals)))])
        if self.direction != "cold":
            record.add([Column(STATE, dims=("number",), shape=(first.size,))])
        units = [first.units[first.names.index(name)] for name in section.signals]
        record.coordinate("direction", ("direction",), np.array(DIRECTIONS[self.direction], dtype=object))
        record.coordinate("signal", ("signal",), np.array(section.signals, dtype=object))
        record.coordinate("units", ("signal",), np.array(units, dtype=object))
        record.coordinate("period", ("period",), np.arange(section.skip, section.skip + section.keep))
        unit = unit_of(make, parameter) if callable(make) and not isinstance(make, Dynamics) else ""
        record.coordinate(parameter, (parameter,), self.numbers, unit)
        about = {"name": first.name, "kind": "bifurcation", "parameter": parameter, "direction": self.direction}
        numbers = {"skip": section.skip, "keep": section.keep, "flexmb": installed_version()}
        record.describe(**about, **numbers, axes=["direction", "period", parameter, "seam"])

    def chains(self, record: Record, chunks: int, bar: ProgressBar) -> Iterator[Chain]:
        """Chains of all chunks, in the order of computation."""
        numbers, cold = self.numbers, self.direction == "cold"
        chunked = np.array_split(np.argsort(numbers, kind="stable"), len(numbers) if cold else chunks)
        # cold chunks fill the range evenly: their numbers with mirrored bits
        bits = max(len(chunked) - 1, 1).bit_length()
        order = (int(f"{k:0{bits}b}"[::-1], 2) for k in range(1 << bits)) if cold else range(len(chunked))
        parts = [chunked[k] for k in order if k < len(chunked)]
        for row, name in enumerate(DIRECTIONS[self.direction]):
            ordered = [part[::-1] for part in parts[::-1]] if name == "down" else parts
            yield from (self._chain(record, bar, row, part, begins=k == 0) for k, part in enumerate(ordered))

    def _chain(self, record: Record, bar: ProgressBar, row: int, part: np.ndarray, *, begins: bool) -> Chain:
        """The points of a chunk one after the other; carried states go from each point to the next."""
        carried, carries = None, STATE in record.columns
        for i in part:
            index = (row, int(i))
            if not record.at(index, STATUS):
                outcome = yield Job(section_point, (self.family, self.section, self.numbers[i].item(), carried))
                values = {**outcome.values, "ok": outcome.ok, STATUS: outcome.status}
                values["seam"] = carries and not begins and (carried is None or bool(values.get("seam")))
                state = values.pop(STATE, None)
                if carries and state is not None and state.shape == record.columns[STATE].shape:
                    values[STATE] = state
                record.keep(index, values)
                bar.one_more(ok=outcome.ok)
            begins = False
            if carries and record.at(index, "ok"):
                carried = record.at(index, STATE).copy()


def _exponent_over(label: str, exponent: Any, skip: int, keep: int) -> tuple[int, bool]:
    """Number of periods of the exponent (0: no exponent), and whether they are the periods of the points."""
    together = isinstance(exponent, str)
    if together:
        checks.one_of(label, "exponent", exponent, ["points"])
        if skip < 1:
            text = f'{label}: exponent="points" with skip = 0, but a period must end with each point'
            raise InputError(f"{text}. Give skip=1.")
    if exponent is False:
        return 0, False
    periods = keep if together or exponent is True else checks.count(label, "exponent", exponent, 0)
    if 0 < periods < FEWEST:
        text = f"{label}: an exponent over {periods} periods has no error; at least {FEWEST} are needed"
        raise InputError(f"{text}. Give exponent={FEWEST} or more, or keep so many points.")
    return periods, together


def _check(family: Family, direction: str, chunks: int, count: int) -> None:
    """Refuse arguments with which no point can be computed."""
    label, make = family.label, family.make
    checks.one_of(label, "direction", direction, DIRECTIONS)
    checks.identifier(label, family.parameter.replace(".", "_") if isinstance(family.parameter, str) else None)
    if checks.count(label, "chunks", chunks) > count:
        raise InputError(f"{label}: chunks is {chunks}, but there are {count} values. Give as many at most.")
    if direction == "cold" and chunks > 1:
        raise InputError(f"{label}: chunks goes with direction 'up', 'down' or 'both'; cold points are independent.")
    if isinstance(make, Dynamics) or is_mechanism(make):
        return
    if not callable(make):
        text = f"{label}: make is {type(make).__name__}; it must be a function that returns a Mechanism,"
        raise InputError(f"{text} a Mechanism or a system such as Map.")
    require_arguments(f"{label}: {label_of(make)}", make, [*family.fixed, family.parameter])


def first_of(family: Family, values: Sequence[float]) -> Dynamics:
    """The system at the first value that gives one; if none does, the error at the last value is raised."""
    for value in values:
        with Attempt() as attempt:
            flow = family.at(value)
            family.period_of(flow, value)
            return flow
    if isinstance(attempt.error, FlexmbError):
        raise attempt.error
    text = f"{family.label}: no value gives a system ({type(attempt.error).__name__}: {attempt.error})"
    raise InputError(f"{text}. Call the function with one value to see why.") from attempt.error
