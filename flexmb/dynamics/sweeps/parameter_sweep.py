"""Sweeps: a function over a grid of parameters or a list of designs; its results as columns."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.arguments import checked, require_arguments
from flexmb.dynamics.jobs import executors
from flexmb.dynamics.jobs.progress import ProgressBar
from flexmb.dynamics.sweeps import store as stores
from flexmb.engine.compiled.digest import digest
from flexmb.errors import InputError
from flexmb.fields import unit_of
from flexmb.late import xr
from flexmb.version import installed_version

DESIGN = "design"
RESERVED = ("ok", "status")


@dataclass(frozen=True)
class Points:
    """The points of a sweep: its dimensions, the parameters of a grid or "design", and values along them."""

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    values: Mapping[str, Sequence[Any]]

    @property
    def count(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    def index(self, number: int) -> stores.Index:
        """Indices of point `number` along the dimensions, in the order of computation."""
        return tuple(int(k) for k in np.unravel_index(number, self.shape))

    def at(self, index: stores.Index) -> dict[str, Any]:
        """Arguments of the function at an `index`."""
        if self.dims == (DESIGN,) and DESIGN not in self.values:
            return {name: column[index[0]] for name, column in self.values.items()}
        return {name: self.values[name][k] for name, k in zip(self.dims, index, strict=True)}

    def coordinate(self, name: str) -> tuple[tuple[str, ...], np.ndarray]:
        """Dimension and values of the parameter `name`; other values than numbers and texts become texts."""
        column = self.values[name]
        kinds = {np.asarray(value).dtype.kind if np.ndim(value) == 0 else "O" for value in column}
        numbers = kinds <= set("iuf") or kinds <= set("b")
        values = np.array(column) if numbers else np.array([str(value) for value in column], dtype=object)
        return ((name,) if name in self.dims else (DESIGN,)), values


def points_of(label: str, over: Any) -> Points:
    """Points of a grid {"a": values, "b": values}, all combinations, or of designs [{"a": value, "b": value}]."""
    # All designs have the same parameters.
    values: dict[str, Sequence[Any]]
    if isinstance(over, Mapping):
        values = {name: checks.sequence(label, f"grid[{name!r}]", column, "values") for name, column in over.items()}
        points = Points(tuple(values), tuple(len(column) for column in values.values()), values)
    else:
        designs = checks.sequence(label, "designs", over, "dictionaries, or a dictionary of lists for a grid")
        for k, design in enumerate(designs):
            if not isinstance(design, Mapping):
                text = f"{label}: design {k} is {design!r}; it must be a dictionary such as {{'speed': 2.0}}."
                raise InputError(text)
            if set(design) != set(designs[0]):
                names, others = ", ".join(map(str, design)), ", ".join(map(str, designs[0]))
                raise InputError(f"{label}: design {k} has {names}, the first one {others}. Give all of them the same.")
        values = {name: [design[name] for design in designs] for name in (designs[0] if designs else ())}
        points = Points((DESIGN,), (len(designs),), values)
    if points.count == 0 or not values:
        raise InputError(f"{label}: there is no point in it. Give values for at least one parameter.")
    for name in values:
        if not isinstance(name, str) or not name.isidentifier() or name in RESERVED:
            text = f"{label}: {name!r} cannot be a parameter"
            raise InputError(f"{text}; it must be a keyword, and not 'ok' or 'status'.")
        if name == DESIGN and points.dims == (DESIGN,) and not isinstance(over, Mapping):
            raise InputError(f"{label}: a parameter cannot be called 'design' in a list of designs. Rename it.")
    return points


# Results of a function in a sweep, as columns: numbers, arrays, texts, or a mapping of them

ALONE = "value"  # name of the result of a function that returns one number or array
OUTCOME = ("ok", stores.STATUS)  # columns of every sweep


def called(function: Any, arguments: Mapping[str, Any]) -> executors.Outcome:
    """Outcome of one call, with its results as {name: (dims or None, array)}; runs in the workers."""
    results = function(**arguments)
    named = dict(results) if isinstance(results, Mapping) else {ALONE: results}
    stopped = executors.stopped_runs()
    said, status = np.asarray(named.pop("ok", not stopped)), named.pop(stores.STATUS, "")
    if said.shape or said.dtype.kind != "b":
        raise InputError(f"The function returned ok = {said}; it must be True or False, whether the point succeeded.")
    if not isinstance(status, str):
        text = f"The function returned {stores.STATUS!r} = {status!r}, a name of the dataset"
        raise InputError(f"{text}; it must be a text.")
    if not said:
        return executors.Outcome({}, status or stopped or "The function returned ok = False.", ok=False)
    if not named:
        raise InputError("The function returned an empty mapping; it must return at least one number.")
    for name in named:
        if not isinstance(name, str) or not name or "/" in name or name.startswith(("_", ".")):
            text = f"The function returned a result called {name!r}"
            raise InputError(f"{text}; a name is a text without '/', not begun by '_'.")
    return executors.Outcome({name: _array(name, value) for name, value in named.items()}, status or executors.DONE)


def columns_of(
    results: Mapping[str, Any], dims: Mapping[str, Sequence[str]], known_lengths: Mapping[str, int]
) -> list[stores.Column]:
    """Columns for the results of a call."""
    lengths, columns = dict(known_lengths), []
    for name, (own_dims, array) in results.items():
        if name in lengths or name in OUTCOME:
            raise InputError(f"The function returned {name!r}, which is a name of the dataset. Rename it.")
        names_of_dims = tuple(dims.get(name, own_dims or (f"{name}_{k}" for k in range(array.ndim))))
        if len(names_of_dims) != array.ndim:
            text = f"The result {name!r} has {array.ndim} dimensions"
            raise InputError(f"{text}, but dims gives it {len(names_of_dims)}: {', '.join(names_of_dims)}.")
        for dim, length in zip(names_of_dims, array.shape, strict=True):
            if lengths.setdefault(dim, length) != length or dim in known_lengths:
                text = f"The dimension {dim!r} of {name!r} has two lengths or is a parameter"
                raise InputError(f"{text}. Rename it by dims=.")
        columns.append(stores.Column(name, kind_of(array), names_of_dims, array.shape))
    if any(column.name in lengths and column.dims != (column.name,) for column in columns):
        raise InputError("A result is called like a dimension of another one. Rename it.")
    return columns


def fitting(results: Mapping[str, Any], columns: Mapping[str, stores.Column]) -> dict[str, Any]:
    """Values of results for the columns of the first successful point; other names, shapes or kinds are refused."""
    if set(results) != set(columns):
        text = f"The function returned {', '.join(sorted(results))}, at the first point {', '.join(sorted(columns))}"
        raise InputError(f"{text}. Return the same names at all points.")
    for name, (_, array) in results.items():
        column, kind = columns[name], kind_of(array)
        if kind == "complex" and column.kind == "number":
            text = f"The result {name!r} is complex, at the first point real"
            raise InputError(f"{text}. Return complex numbers everywhere.")
        if array.shape != column.shape or (kind != column.kind and (kind, column.kind) != ("number", "complex")):
            text = f"The result {name!r} is {kind} {array.shape}, at the first point {column.kind} {column.shape}"
            raise InputError(f"{text}. Return the same kind and shape everywhere.")
    return {name: array[()] for name, (_, array) in results.items()}


def kind_of(array: np.ndarray) -> str:
    """Kind of a column for an `array`: "number", "complex" or "text"."""
    return {"U": "text", "O": "text", "c": "complex"}.get(array.dtype.kind, "number")


def _array(name: Any, value: Any) -> tuple[tuple[str, ...] | None, np.ndarray]:
    """Names of the dimensions, if the value has names, and its entries as float64, complex128 or text."""
    xr = sys.modules.get("xarray")
    dims = tuple(str(d) for d in value.dims) if xr is not None and isinstance(value, xr.DataArray) else None
    if isinstance(value, str):
        return dims, np.array(value, dtype=object)
    array = np.asarray(value)
    if array.dtype.kind == "U":
        return dims, array.astype(object)
    if array.dtype.kind not in "biufc":
        text = f"The result {name!r} is {type(value).__name__}"
        raise InputError(f"{text}; a function of a sweep returns numbers, arrays of them, texts or a mapping of these.")
    return dims, array.astype(np.complex128 if array.dtype.kind == "c" else np.float64)


AXES, LAYOUT = "axes", "layout"  # attributes of a store: names of the coordinates; layout of the results of a function
# Columns of a diagram that become other variables of the dataset: all signals, and final states.
POINTS, STATE = "points", "state"


def load_sweep(path: str | Path) -> xr.Dataset:
    """Dataset of a store in the folder `path`, equal to the result of `bifurcation` or `sweep` that wrote it.

    Unfinished points of an interrupted run have an empty status.

    Raises
    ------
    InputError : an argument that is not a path.
    FileFormatError : no store, a damaged store, or a format of another version.
    MissingPackageError : zarr is not installed.
    """
    store = stores.existing(path)
    attributes = {k: v for k, v in store.attributes.items() if k not in (stores.VERSION, stores.ARRAYS, "fingerprint")}
    return dataset_of(store.read(), attributes)


def dataset_of(tables: stores.Tables, attributes: Mapping[str, Any]) -> xr.Dataset:
    """Dataset of the arrays and attributes of a record or store."""
    entries: dict[str, Any] = {}
    for name, (dims, values, attrs) in tables.items():  # texts of one width are supported by all file formats
        entries[name] = (dims, values.astype(str) if values.dtype == object else values, dict(attrs))
    if attributes["kind"] == "bifurcation":
        entries.pop(STATE, None)
        (dims, points, _), names, units = entries.pop(POINTS), entries.pop("signal")[1], entries.pop("units")[1]
        columns = (np.ascontiguousarray(points[..., k]) for k in range(len(names)))
        signals = zip(names, columns, units, strict=True)
        entries = {str(n): (dims[:-1], c, {"units": str(unit)} if unit else {}) for n, c, unit in signals} | entries
    coordinates = {name: entries.pop(name) for name in attributes[AXES]}
    described = {name: value for name, value in attributes.items() if name not in (AXES, LAYOUT)}
    dataset = xr.Dataset(entries, coords=coordinates, attrs=described)
    if dataset.attrs.get("direction") not in (None, "both"):
        dataset = dataset.isel(direction=0, drop=True)
    return dataset


@dataclass(frozen=True)
class Work:
    """Common arguments of `sweep` and `bifurcation`: executor, store, progress."""

    # `sent` is what goes to the workers, with its name in messages.
    label: str
    sent: tuple[Any, str]
    executor: Executor | int | None
    pending: int
    store: Any
    resume: bool
    progress: bool

    def __post_init__(self) -> None:
        executors.require_picklable(self.label, self.executor, self.sent[0], f"{self.sent[1]} with what is given to it")
        checks.count(self.label, "pending", self.pending)

    def record(
        self, kind: str, dims: tuple[str, ...], shape: tuple[int, ...], fingerprint: Callable[[], Mapping[str, Any]]
    ) -> stores.Record:
        """Record of the results, in a store if one is given; the fingerprint tells sweeps of one kind apart."""
        if self.store is None:
            return stores.Record(dims, shape)
        return stores.Record(dims, shape, stores.opened(self.store, fingerprint(), kind, resume=self.resume))

    def done(self, record: stores.Record, chains: Callable[[ProgressBar], Iterable[executors.Chain]]) -> xr.Dataset:
        """Dataset of a record after all chains have run."""
        done = record.done
        with ProgressBar(self.label, done.size, done=int(done.sum()), shown=self.progress) as bar:
            executors.drive(chains(bar), self.executor, self.label, self.pending)
        return dataset_of(record.tables, record.attributes)


def settings_of(fixed: Mapping[str, Any], function: Any) -> dict[str, Any]:
    """Entries of every fingerprint: version, function with all that it names, fixed values."""
    values = {name: f"{type(value).__name__} {digest(value)}" for name, value in sorted(fixed.items())}
    return {"flexmb": installed_version(), **stores.texts_of("text", function), "fixed": values}


@checked
def sweep(
    function: Callable[..., Any], over: Mapping[str, Sequence[Any]] | Sequence[Mapping[str, Any]], *,
    fixed: Mapping[str, Any] | None = None, dims: Mapping[str, Sequence[str]] | None = None,
    executor: Executor | int | None = None, pending: int = executors.PENDING, store: Any = None, resume: bool = False,
    progress: bool = False,
) -> xr.Dataset:  # fmt: skip
    """Results of a function at all combinations of values, or at a list of designs.

    Parameters
    ----------
    function : called as function(**fixed, **parameters) at every point.  It returns a number, a text, an array of fixed
        shape, or a mapping of them by name; arrays of xarray keep the names of their dimensions.  The mapping may hold
        `ok` and `status`, a flag and a text: see the notes.
    over : {"a": values, "b": values} for all combinations, or a list of {"a": value, "b": value}.
    fixed : fixed values of other parameters.
    dims : names of the dimensions of returned arrays, by the name of the result; None: "name_0", "name_1", ...
    executor : a number of threads of this process, or any executor of concurrent.futures: processes, a Dask client
        (client.get_executor()), MPI; None: one point after the other.
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
    own = stores.label_of(function)
    label = f"sweep of {own}"
    points, fixed_values = points_of(label, over), checks.mapping(label, "fixed", fixed)
    varied_and_fixed = [name for name in points.values if name in fixed_values]
    if varied_and_fixed:
        raise InputError(f"{label}: {varied_and_fixed[0]!r} is varied and fixed. Take it out of one of them.")
    executors.require_executor(label, executor)
    require_arguments(label, function, [*points.values, *fixed_values])
    bound = partial(function, **fixed_values) if fixed_values else function
    work = Work(label, (bound, own), executor, pending, store, resume, progress)
    given = checks.mapping(label, "dims", dims)
    names = {name: tuple(checks.sequence(label, f"dims[{name!r}]", d, "names")) for name, d in given.items()}
    record = work.record("sweep", points.dims, points.shape, lambda: settings_of(fixed_values, function) | {
        "ok": "if all runs reached their ends", "function": own, "points": list(points.dims),
        "values": {name: stores.shown_values(list(column)) for name, column in points.values.items()},
        "dims": {name: list(dims_of_one) for name, dims_of_one in sorted(names.items())},
    })  # fmt: skip
    for name in points.values:
        record.coordinate(name, *points.coordinate(name), unit_of(function, name))
    record.describe(name=own, kind="sweep", flexmb=installed_version(), axes=sorted(points.values))
    done = record.done

    def chains(bar: ProgressBar) -> Iterator[executors.Chain]:
        collector = _Collector(record, points, names, bar)

        def chain(number: int) -> executors.Chain:
            outcome = yield executors.Job(called, (bound, points.at(points.index(number))))
            collector.take(number, outcome)

        return (chain(number) for number in range(points.count) if not done[points.index(number)])

    return work.done(record, chains)


class _Collector:
    """Collects outcomes in a record whose columns are unknown before the first successful point."""

    # The columns belong to the first successful point in the order of the points, not in time. All runs of a sweep thus
    # give the same store. Outcomes of later points are held until the first successful point is known.

    def __init__(
        self, record: stores.Record, points: Points, dims: Mapping[str, Sequence[str]], bar: ProgressBar
    ) -> None:
        self.record, self.points, self.dims, self.bar = record, points, dims, bar
        self.held, self.next = dict[int, executors.Outcome](), 0
        self.columns: dict[str, stores.Column] | None = None
        if record.store is not None and LAYOUT in record.store.attributes:
            layout = record.store.attributes[LAYOUT]
            self._use([stores.Column(name, kind, tuple(dims), tuple(shape)) for name, kind, dims, shape in layout])

    def take(self, number: int, outcome: executors.Outcome) -> None:
        """Collect the outcome of point `number`."""
        self.held[number] = outcome
        while self.columns is None and self.next < self.points.count:
            known = self.next in self.held or bool(self.record.at(self.points.index(self.next), stores.STATUS))
            if not known or (self.next in self.held and self._decide(self.held[self.next])):
                break
            self.next += 1
        if self.columns is not None:
            for ready in list(self.held):
                self._keep(ready, self.held.pop(ready))

    def _decide(self, outcome: executors.Outcome) -> bool:
        """Set the columns from a successful outcome; a failure is kept instead, and False is returned."""
        with executors.Attempt() as attempt:
            if outcome.ok:
                known_lengths = dict.fromkeys(self.points.values, 1)
                known_lengths.update(zip(self.points.dims, self.points.shape, strict=True))
                self._use(columns_of(outcome.values, self.dims, known_lengths))
                return True
        kept = self.held.pop(self.next)
        self._keep(self.next, kept if attempt.error is None else executors.failure(attempt.error))
        return False

    def _use(self, columns: list[stores.Column]) -> None:
        self.record.add(columns)
        self.columns = {column.name: column for column in columns}
        self.record.describe(**{LAYOUT: [[c.name, c.kind, list(c.dims), list(c.shape)] for c in columns]})

    def _keep(self, number: int, outcome: executors.Outcome) -> None:
        values: dict[str, Any] = {}
        if outcome.ok:
            with executors.Attempt() as attempt:
                values = fitting(outcome.values, self.columns or {})
            outcome = outcome if attempt.error is None else executors.failure(attempt.error)
        self.record.keep(self.points.index(number), {**values, "ok": outcome.ok, stores.STATUS: outcome.status})
        self.bar.one_more(ok=outcome.ok)
