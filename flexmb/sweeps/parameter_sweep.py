"""Sweeps: a function over a grid of parameters or a list of designs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from functools import partial
from typing import TYPE_CHECKING, Any

from flexmb import checks
from flexmb.arguments import checked, require_arguments
from flexmb.compiled.digest import digest
from flexmb.docstrings import unit_of
from flexmb.errors import InputError
from flexmb.jobs.attempt import Attempt, Outcome, failure
from flexmb.jobs.engine import PENDING, Chain, Job, drive, require_executor, require_picklable
from flexmb.jobs.progress import ProgressBar
from flexmb.sweeps.datasets import LAYOUT, dataset_of
from flexmb.sweeps.fingerprint import label_of, shown_values, texts_of
from flexmb.sweeps.grid import Points, points_of
from flexmb.sweeps.outputs import called, columns_of, fitting
from flexmb.sweeps.record import STATUS, Column, Record
from flexmb.sweeps.store import opened
from flexmb.version import installed_version

if TYPE_CHECKING:
    import xarray as xr


@checked
def sweep(
    function: Callable[..., Any],
    over: Mapping[str, Sequence[Any]] | Sequence[Mapping[str, Any]],
    *,
    fixed: Mapping[str, Any] | None = None,
    dims: Mapping[str, Sequence[str]] | None = None,
    executor: Executor | None = None,
    pending: int = PENDING,
    store: Any = None,
    resume: bool = False,
    progress: bool = False,
) -> xr.Dataset:
    """Results of a function at all combinations of values, or at a list of designs.

    Parameters
    ----------
    function : called as function(**fixed, **parameters) at every point.  It returns a number, a text, an array of fixed
        shape, or a mapping of them by name; arrays of xarray keep the names of their dimensions.  The mapping may hold
        `ok` and `status`, a flag and a text: see the notes.
    over : {"a": values, "b": values} for all combinations, or a list of {"a": value, "b": value}.
    fixed : fixed values of other parameters.
    dims : names of the dimensions of returned arrays, by the name of the result; None: "name_0", "name_1", ...
    executor : any executor of concurrent.futures: processes, a Dask client (client.get_executor()), MPI; None: this
        process.
    pending : largest number of points in the executor at a time.
    store : folder that keeps every finished point (zarr); None: no store.
    resume : whether an existing store is continued; otherwise it is refused.
    progress : whether a progress bar with the remaining time is shown.

    Returns
    -------
    xarray.Dataset : the results over the parameters, or over "design" with the parameters as coordinates.  A result
        without a name is called "value".  Flags and whole numbers become floats, since failed points have NaN.
        `status` of every point is "done", the class and the message of an error, or the status of a run that stopped
        early; `ok` is True for points that succeeded.

    Raises
    ------
    InputError : no points, names in use, a function that cannot be sent to the executor; an existing store without
        `resume`, or a store of another sweep.
    WorkerError : workers that died; finished points are in the store.

    Notes
    -----
    A point succeeds if its function returns and every run in it (`simulate`, `lyapunov`, `benettin`, `stroboscopic`,
    `section`) has reached its end.  A function that deals with failed runs itself, e.g. by smaller steps, returns
    `ok`: True or False, and decides alone.  Runs in threads or processes that the function starts are not seen; their
    `require()` raises.  Ctrl-C ends the sweep; the interrupted point is not kept.

    A failed point is kept with its status, and the sweep continues.  The first successful point, in the order of the
    points, determines the names and shapes of the results; a point with other results has failed.  Results do not
    depend on the executor or the number of workers.  The bytes of a finished store do not depend on interruptions
    either, if the function gives the same results for the same parameters.

    Examples
    --------
    >>> import flexmb as fm
    >>> def area(width, height):
    ...     return {"area": width * height}
    >>> fm.sweep(area, {"width": [1.0, 2.0], "height": [3.0, 4.0, 5.0]})["area"].values
    array([[ 3.,  4.,  5.],
           [ 6.,  8., 10.]])
    >>> fm.sweep(area, [{"width": 1.0, "height": 3.0}, {"width": 2.0, "height": 5.0}])["area"].values
    array([ 3., 10.])
    """
    label = "sweep"
    if not callable(function):
        raise InputError(f"{label}: function is {function!r}; it must be a function of the parameters.")
    label = f"sweep of {label_of(function)}"
    points, fixed_values = points_of(label, over), checks.mapping(label, "fixed", fixed)
    varied_and_fixed = [name for name in points.values if name in fixed_values]
    if varied_and_fixed:
        raise InputError(f"{label}: {varied_and_fixed[0]!r} is varied and fixed. Take it out of one of them.")
    require_executor(label, executor)
    require_arguments(label, function, [*points.values, *fixed_values])
    bound = partial(function, **fixed_values) if fixed_values else function
    require_picklable(label, executor, bound, f"{label_of(function)} with what is given to it")
    pending = checks.count(label, "pending", pending)
    names = {
        name: tuple(checks.sequence(label, f"dims[{name!r}]", d, "names"))
        for name, d in checks.mapping(label, "dims", dims).items()
    }
    fingerprint = None if store is None else _fingerprint(function, points, fixed_values, names)
    opened_store = None if fingerprint is None else opened(store, fingerprint, "sweep", resume=resume)
    record = Record(points.dims, points.shape, opened_store)
    _lay_out(record, function, points)
    done = record.done
    with ProgressBar(label, points.count, done=int(done.sum()), shown=progress) as bar:
        collector = _Collector(record, points, names, bar)
        unfinished = (number for number in range(points.count) if not done[points.index(number)])
        drive((_chain(bound, points, number, collector) for number in unfinished), executor, label, pending)
    return dataset_of(record.tables, record.attributes)


def _chain(function: Any, points: Points, number: int, collector: _Collector) -> Chain:
    """The chain of one point."""
    outcome = yield Job(called, (function, points.at(points.index(number))))
    collector.take(number, outcome)


class _Collector:
    """Collects outcomes in a record whose columns are unknown before the first successful point.

    The columns belong to the first successful point in the order of the points, not in time.  All runs of a sweep thus
    give the same store.  Outcomes of later points are held until the first successful point is known.
    """

    def __init__(self, record: Record, points: Points, dims: Mapping[str, Sequence[str]], bar: ProgressBar) -> None:
        self.record, self.points, self.dims, self.bar = record, points, dims, bar
        self.held, self.next = dict[int, Outcome](), 0
        self.columns: dict[str, Column] | None = None
        if record.store is not None and LAYOUT in record.store.attributes:
            self._use([_column(entry) for entry in record.store.attributes[LAYOUT]])

    def take(self, number: int, outcome: Outcome) -> None:
        """Collect the outcome of point `number`."""
        self.held[number] = outcome
        while self.columns is None and self._is_known(self.next):
            if self.next in self.held and self._decide(self.held[self.next]):
                break
            self.next += 1
        if self.columns is not None:
            for ready in list(self.held):
                self._keep(ready, self.held.pop(ready))

    def _is_known(self, number: int) -> bool:
        if number >= self.points.count:
            return False
        return number in self.held or bool(self.record.at(self.points.index(number), STATUS))

    def _decide(self, outcome: Outcome) -> bool:
        """Set the columns from a successful outcome; a failure is kept instead, and False is returned."""
        with Attempt() as attempt:
            if outcome.ok:
                known_lengths = dict.fromkeys(self.points.values, 1)
                known_lengths.update(zip(self.points.dims, self.points.shape, strict=True))
                self._use(columns_of(outcome.values, self.dims, known_lengths))
                return True
        outcome_kept = self.held.pop(self.next)
        self._keep(self.next, outcome_kept if attempt.error is None else failure(attempt.error))
        return False

    def _use(self, columns: list[Column]) -> None:
        self.record.add(columns)
        self.columns = {column.name: column for column in columns}
        self.record.describe(**{LAYOUT: [[c.name, c.kind, list(c.dims), list(c.shape)] for c in columns]})

    def _keep(self, number: int, outcome: Outcome) -> None:
        values: dict[str, Any] = {}
        if outcome.ok:
            with Attempt() as attempt:
                values = fitting(outcome.values, self.columns or {})
            outcome = outcome if attempt.error is None else failure(attempt.error)
        self.record.keep(self.points.index(number), {**values, "ok": outcome.ok, STATUS: outcome.status})
        self.bar.one_more(ok=outcome.ok)


def _column(entry: Sequence[Any]) -> Column:
    name, kind, dims, shape = entry
    return Column(name, kind, tuple(dims), tuple(shape))


def _fingerprint(
    function: Any, points: Points, fixed: Mapping[str, Any], dims: Mapping[str, Sequence[str]]
) -> dict[str, Any]:
    """Values on which the results depend."""
    return {
        "flexmb": installed_version(),
        "ok": "if all runs reached their ends",
        "function": label_of(function),
        **texts_of("text", function),
        "points": list(points.dims),
        "values": {name: shown_values(list(column)) for name, column in points.values.items()},
        "fixed": {name: f"{type(value).__name__} {digest(value)}" for name, value in sorted(fixed.items())},
        "dims": {name: list(names) for name, names in sorted(dims.items())},
    }


def _lay_out(record: Record, function: Any, points: Points) -> None:
    """Set coordinates and attributes of a sweep."""
    for name in points.values:
        dims, values = points.coordinate(name)
        record.coordinate(name, dims, values, unit_of(function, name))
    record.describe(name=label_of(function), kind="sweep", flexmb=installed_version(), axes=sorted(points.values))
