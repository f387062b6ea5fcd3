"""Any function of parameters over a grid or a list of designs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from functools import partial
from typing import TYPE_CHECKING, Any

from flexmb import checks
from flexmb.errors import InputError
from flexmb.jobs.attempt import Attempt, Outcome, failure
from flexmb.jobs.engine import PENDING, Chain, Job, drive, require_executor, require_picklable
from flexmb.jobs.progress import ProgressBar
from flexmb.run.run import installed_version
from flexmb.sweeps.diagram import LAYOUT, dataset_of
from flexmb.sweeps.fingerprint import digest, label_of, shown_values
from flexmb.sweeps.grid import Points, points_of
from flexmb.sweeps.outputs import called, columns_of, fitting
from flexmb.sweeps.record import STATUS, Column, Record
from flexmb.sweeps.store import opened
from flexmb.sweeps.units import documented_unit

if TYPE_CHECKING:
    import xarray as xr


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
    """The results of a function at all combinations of values, or at a list of designs.

    Parameters
    ----------
    function : called as function(**fixed, **parameters) at every point.  It returns a number, a text, an array of fixed
        shape, or a mapping of them by name; xarray's arrays keep the names of their dimensions.
    over : {"a": values, "b": values} for all combinations, or a list of {"a": value, "b": value}.
    fixed : other parameters, by name, that stay.
    dims : names of the dimensions of the arrays that are returned, by their names; None: "name_0", "name_1", ...
    executor : where points are computed, any executor of concurrent.futures: of processes, of a Dask client
        (client.get_executor()), of MPI; None: in this process.
    pending : most points that are with the executor at the same time.
    store : folder in which every point is kept when it is finished (zarr); None: nowhere.
    resume : go on with the store if it is there; else a store that is there is refused.
    progress : show a progress bar with an estimate of the time left.

    Returns
    -------
    xarray.Dataset : the results over the parameters, or over "design" with the parameters as coordinates; what is
        returned alone is called "value".  Truth values and whole numbers become floats, so that a point that failed can
        have NaN.  `ok` and `status` say of every point how it ended: "done", or the class and the message of the error.

    Raises
    ------
    InputError : no points, names that are taken, a function that cannot be sent to the executor; a store that is there
        already or was written by another sweep.
    WorkerError : workers that died; what is finished is in the store.

    Notes
    -----
    A point that fails is kept with its status, and the others go on.  The first point that goes well, in the order of
    the points, says which results there are; one that returns others has failed.  Results do not depend on the executor
    or on the number of workers, and neither do the bytes of a finished store, killed and gone on with or not, provided
    that the function gives the same results for the same parameters.

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
    points, given = points_of(label, over), checks.mapping(label, "fixed", fixed)
    twice = [name for name in points.values if name in given]
    if twice:
        raise InputError(f"{label}: {twice[0]!r} is varied and fixed. Take it out of one of them.")
    bound = partial(function, **given) if given else function
    require_executor(label, executor)
    require_picklable(label, executor, bound, f"{label_of(function)} with what is given to it")
    pending = checks.count(label, "pending", pending)
    names = {
        name: tuple(checks.sequence(label, f"dims[{name!r}]", d, "names"))
        for name, d in checks.mapping(label, "dims", dims).items()
    }
    prints = None if store is None else _fingerprint(function, points, given, names)
    kept = None if prints is None else opened(store, prints, "sweep", resume=resume)
    record = Record(points.dims, points.shape, kept)
    _lay_out(record, function, points)
    done = record.done
    with ProgressBar(label, points.count, done=int(done.sum()), shown=progress) as bar:
        keeper = _Keeper(record, points, names, bar)
        ahead = (number for number in range(points.count) if not done[points.index(number)])
        drive((_chain(bound, points, number, keeper) for number in ahead), executor, label, pending)
    return dataset_of(record.tables, record.attributes)


def _chain(function: Any, points: Points, number: int, keeper: _Keeper) -> Chain:
    """One point."""
    outcome = yield Job(called, (function, points.at(points.index(number))))
    keeper.take(number, outcome)


class _Keeper:
    """Puts outcomes into a record whose columns are not known before the first point that goes well.

    That is the first one in the order of the points, not of time, so that all runs of a sweep end in the same store.
    What comes before it is decided is held back.
    """

    def __init__(self, record: Record, points: Points, dims: Mapping[str, Sequence[str]], bar: ProgressBar) -> None:
        self.record, self.points, self.dims, self.bar = record, points, dims, bar
        self.held, self.next = dict[int, Outcome](), 0
        self.columns: dict[str, Column] | None = None
        if record.store is not None and LAYOUT in record.store.attributes:
            self._use([_column(entry) for entry in record.store.attributes[LAYOUT]])

    def take(self, number: int, outcome: Outcome) -> None:
        """The outcome of point `number`."""
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
        """Whether this outcome says what the columns are; a failure is kept instead."""
        with Attempt() as attempt:
            if outcome.ok:
                taken = dict.fromkeys(self.points.values, 1)
                taken.update(zip(self.points.dims, self.points.shape, strict=True))
                self._use(columns_of(outcome.values, self.dims, taken))
                return True
        found = self.held.pop(self.next)
        self._keep(self.next, found if attempt.error is None else failure(attempt.error))
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
    """What the results depend on."""
    return {
        "flexmb": installed_version(),
        "function": label_of(function),
        "text": digest(function),
        "points": list(points.dims),
        "values": {name: shown_values(list(column)) for name, column in points.values.items()},
        "fixed": {name: f"{type(value).__name__} {digest(value)}" for name, value in sorted(fixed.items())},
        "dims": {name: list(chosen) for name, chosen in sorted(dims.items())},
    }


def _lay_out(record: Record, function: Any, points: Points) -> None:
    """Coordinates and attributes of a sweep."""
    for name in points.values:
        dims, values = points.coordinate(name)
        record.coordinate(name, dims, values, documented_unit(function, name))
    record.describe(name=label_of(function), kind="sweep", flexmb=installed_version(), axes=sorted(points.values))
