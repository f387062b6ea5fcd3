"""Bifurcation diagrams: section points over the values of a parameter."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb import checks
from flexmb.arguments import checked, require_arguments
from flexmb.compiled.digest import digest
from flexmb.docstrings import unit_of
from flexmb.dynamics.exponents.exponents import FEWEST
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.errors import FlexmbError, InputError
from flexmb.jobs.attempt import Attempt
from flexmb.jobs.engine import PENDING, Chain, Job, drive, require_executor, require_picklable
from flexmb.jobs.progress import ProgressBar
from flexmb.model.mechanism import Mechanism
from flexmb.run.simulate import Step
from flexmb.step.newmark.method import Newmark
from flexmb.sweeps.datasets import POINTS, STATE, dataset_of
from flexmb.sweeps.family import Family, Make, SectionSettings, columns_of, section_point
from flexmb.sweeps.fingerprint import label_of, shown_values, texts_of
from flexmb.sweeps.record import STATUS, Column, Record
from flexmb.sweeps.store import opened
from flexmb.version import installed_version

if TYPE_CHECKING:
    import xarray as xr

DIRECTIONS = {"cold": ("cold",), "up": ("up",), "down": ("down",), "both": ("up", "down")}
"""Rows of a diagram by the name of the direction."""
COLUMNS = (
    Column("seam", "flag"),
    Column("drive_period", units="s"),
    Column("verdict", "text"),
    Column("exponent"),
    Column("exponent_error"),
)
"""Columns of a diagram besides `ok`, `status`, section points and final state."""

RESERVED = ("period", "direction", "signal", "units", "status", "ok", POINTS, STATE, *(c.name for c in COLUMNS))
"""Names in the store that no parameter and no signal may have."""


@checked
def bifurcation(
    make: Make,
    parameter: str,
    values: Sequence[float],
    *,
    fixed: Mapping[str, Any] | None = None,
    skip: int,
    keep: int,
    direction: str = "cold",
    chunks: int = 1,
    signals: Sequence[str] | None = None,
    period: float | Callable[[float], float] | None = None,
    step: Step | None = None,
    method: Newmark | None = None,
    exponent: bool | int | str = False,
    executor: Executor | None = None,
    pending: int = PENDING,
    store: Any = None,
    resume: bool = False,
    progress: bool = False,
) -> xr.Dataset:
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
    executor : any executor of concurrent.futures: processes, a Dask client (client.get_executor()), MPI; None: this
        process.
    pending : largest number of points in the executor at a time.
    store : folder that keeps every finished point (zarr); None: no store.
    resume : whether an existing store is continued; otherwise it is refused.
    progress : whether a progress bar with the remaining time is shown.

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
    drives that has ended by then is not repeated.

    Examples
    --------
    >>> import flexmb as fm
    >>> from flexmb.dynamics.systems.map import Map
    >>> def logistic(x, r):
    ...     return [r * x[0] * (1.0 - x[0])]
    >>> system = Map(logistic, [0.3], parameters={"r": 3.0})
    >>> found = fm.bifurcation(system, "r", [2.0, 3.2], skip=500, keep=4)
    >>> found["x0"].values.round(4)
    array([[0.5   , 0.5   , 0.5   , 0.5   ],
           [0.7995, 0.513 , 0.7995, 0.513 ]])
    """
    family = Family(
        make, parameter, checks.mapping(f"bifurcation over {parameter!r}", "fixed", fixed), step, method, period
    )
    label = family.label
    numbers = _values(label, values)
    _check(family, direction, chunks, len(numbers))
    require_executor(label, executor)
    require_picklable(label, executor, family, f"{label_of(make)} with what is given to it")
    pending = checks.count(label, "pending", pending)
    first = first_of(family, numbers.tolist())
    names = first.names if signals is None else tuple(checks.sequence(label, "signals", signals, "names"))
    skip, keep = checks.count(label, "skip", skip, 0), checks.count(label, "keep", keep)
    together = _together(label, exponent, skip)
    section = SectionSettings(skip, keep, names, _exponent_over(label, True if together else exponent, keep), together)
    units = [first.units[k] for k in columns_of(first, names, label)]
    _refuse_names(label, [parameter, *names])
    settings = {"direction": direction, "chunks": chunks}
    fingerprint = None if store is None else _fingerprint(family, section, numbers, settings, first)
    opened_store = None if fingerprint is None else opened(store, fingerprint, "bifurcation", resume=resume)
    record = Record(("direction", parameter), (len(DIRECTIONS[direction]), len(numbers)), opened_store)
    _lay_out(record, family, section, numbers, direction, units, first)
    done = record.done
    if executor is not None and not done.all() and isinstance(first, MechanismFlow):
        first.advance(1e-6 * (first.period or 1.0))  # uncached code is compiled once here, not by every worker
    cold = direction == "cold"
    chunked = np.array_split(np.argsort(numbers, kind="stable"), len(numbers) if cold else chunks)
    order = _spread(len(chunked)) if cold else range(len(chunked))
    with ProgressBar(label, done.size, done=int(done.sum()), shown=progress) as bar:
        run = _Run(family, section, numbers, record, done, bar)
        chains = (run.chain(*place) for place in _places(DIRECTIONS[direction], [chunked[k] for k in order]))
        drive(chains, executor, label, pending)
    return dataset_of(record.tables, record.attributes)


@dataclass(frozen=True)
class _Run:
    """Common data of all chains of a diagram."""

    family: Family
    section: SectionSettings
    numbers: np.ndarray
    record: Record
    done: np.ndarray
    bar: ProgressBar

    def chain(self, row: int, part: np.ndarray, begins: bool) -> Chain:
        """The points of a chunk one after the other; carried states go from each point to the next."""
        record, carried, carries = self.record, None, STATE in self.record.columns
        for i in part:
            index = (row, int(i))
            if not self.done[index]:
                outcome = yield Job(section_point, (self.family, self.section, self.numbers[i].item(), carried))
                values = {**outcome.values, "ok": outcome.ok, STATUS: outcome.status}
                cold = carried is None or bool(values.get("seam"))
                values["seam"] = carries and cold and not begins
                state = values.pop(STATE, None)
                if carries and state is not None and state.shape == record.columns[STATE].shape:
                    values[STATE] = state
                record.keep(index, values)
                self.bar.one_more(ok=outcome.ok)
            begins = False
            if carries and record.at(index, "ok"):
                carried = record.at(index, STATE).copy()


def _spread(count: int) -> list[int]:
    """Numbers 0 ... count - 1 in an order that fills the range evenly."""
    digits = max(count - 1, 1).bit_length()
    mirrored = (int(f"{k:0{digits}b}"[::-1], 2) for k in range(1 << digits))
    return [k for k in mirrored if k < count]


def _places(directions: Sequence[str], parts: Sequence[np.ndarray]) -> Iterator[tuple[int, np.ndarray, bool]]:
    """Row, values in the order of computation, and flag of the first chunk, for every chunk."""
    for row, name in enumerate(directions):
        ordered = [part[::-1] for part in parts[::-1]] if name == "down" else parts
        for k, part in enumerate(ordered):
            yield row, part, k == 0


def _values(label: str, values: Any) -> np.ndarray:
    """Values of the parameter (n,); integers remain integers."""
    given = checks.sequence(label, "values", values, "numbers")
    for k, value in enumerate(given):
        checks.number(label, f"values[{k}]", value)
    numbers = np.array(given)
    if len(numbers) == 0:
        raise InputError(f"{label}: values is empty; give at least one.")
    if len(np.unique(numbers)) < len(numbers):
        raise InputError(f"{label}: a value is given twice; give each value once.")
    return numbers


def _together(label: str, exponent: Any, skip: int) -> bool:
    """Whether the exponent belongs to the periods of the points."""
    if not isinstance(exponent, str):
        return False
    checks.one_of(label, "exponent", exponent, ["points"])
    if skip < 1:
        raise InputError(
            f'{label}: exponent="points" with skip = 0, but a period must end with each point. Give skip=1.'
        )
    return True


def _exponent_over(label: str, exponent: bool | int | str, keep: int) -> int:
    """Number of periods of the exponent; 0: no exponent."""
    if exponent is False:
        return 0
    periods = keep if exponent is True else checks.count(label, "exponent", exponent, 0)
    if 0 < periods < FEWEST:
        text = f"{label}: an exponent over {periods} periods has no error; at least {FEWEST} are needed"
        raise InputError(f"{text}. Give exponent={FEWEST} or more, or keep so many points.")
    return periods


def _check(family: Family, direction: str, chunks: int, count: int) -> None:
    """Refuse arguments with which no point can be computed."""
    label, make = family.label, family.make
    checks.one_of(label, "direction", direction, DIRECTIONS)
    checks.identifier(label, family.parameter.replace(".", "_") if isinstance(family.parameter, str) else None)
    if checks.count(label, "chunks", chunks) > count:
        raise InputError(f"{label}: chunks is {chunks}, but there are {count} values. Give as many at most.")
    if direction == "cold" and chunks > 1:
        raise InputError(f"{label}: chunks goes with direction 'up', 'down' or 'both'; cold points are independent.")
    if isinstance(make, (Mechanism, Dynamics)):
        return
    if not callable(make):
        text = f"{label}: make is {type(make).__name__}"
        raise InputError(
            f"{text}; it must be a function that returns a Mechanism, a Mechanism or a system such as Map."
        )
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


def _refuse_names(label: str, names: Sequence[str]) -> None:
    for name in names:
        if name in RESERVED or names.count(name) > 1:
            text = f"{label}: {name!r} is a name of the dataset, or given twice"
            raise InputError(f"{text}. Rename the parameter or the signal.")


def _fingerprint(
    family: Family, section: SectionSettings, numbers: np.ndarray, settings: Mapping[str, Any], first: Dynamics
) -> dict[str, Any]:
    """Values on which the results depend, with the compiled model at the first and at the last value."""
    last: Any = "none"
    with Attempt():
        last = digest(family.at(numbers[-1].item()))
    period = family.period
    return {
        "flexmb": installed_version(),
        "make": label_of(family.make),
        **texts_of("text", family.make),
        "model": f"{digest(first)} {last}",
        "parameter": family.parameter,
        "values": shown_values(numbers.tolist()),
        "fixed": {name: f"{type(value).__name__} {digest(value)}" for name, value in sorted(family.fixed.items())},
        "skip": section.skip,
        "keep": section.keep,
        "signals": shown_values(section.signals),
        "exponent": "points" if section.together else section.exponent,
        "period": f"{label_of(period)} ({digest(period)})" if callable(period) else period,
        "step": repr(family.step),
        "method": repr(family.method),
        **settings,
    }


def _lay_out(
    record: Record,
    family: Family,
    section: SectionSettings,
    numbers: np.ndarray,
    direction: str,
    units: Sequence[str],
    first: Dynamics,
) -> None:
    """Set columns, coordinates and attributes of a diagram."""
    make, parameter = family.make, family.parameter
    shape = (section.keep, len(section.signals))
    record.add([*COLUMNS, Column(POINTS, dims=("period", "signal"), shape=shape)])
    if direction != "cold":
        record.add([Column(STATE, dims=("number",), shape=(first.size,))])
    record.coordinate("direction", ("direction",), np.array(DIRECTIONS[direction], dtype=object))
    record.coordinate("signal", ("signal",), np.array(section.signals, dtype=object))
    record.coordinate("units", ("signal",), np.array(units, dtype=object))
    record.coordinate("period", ("period",), np.arange(section.skip, section.skip + section.keep))
    unit = "" if isinstance(make, (Mechanism, Dynamics)) else unit_of(make, parameter)
    record.coordinate(parameter, (parameter,), numbers, unit)
    record.describe(
        name=first.name,
        kind="bifurcation",
        parameter=parameter,
        direction=direction,
        skip=section.skip,
        keep=section.keep,
        flexmb=installed_version(),
        axes=["direction", "period", parameter, "seam"],
    )
