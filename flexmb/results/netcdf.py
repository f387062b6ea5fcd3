"""A solution as a netCDF file: one variable a signal, the rest as JSON, groups for restart and contacts.

A variable for each of 15,000 signals would take minutes to write and to open.  `plate.node12.vx` is the column of the
node 12 in `plate.node.vx`, whose dimension is the coordinate `plate.node`, the numbers of the nodes.

Signals of bodies with many nodes share variables over time and nodes (`netcdf_nodes`).
The variables can be read by any netCDF reader.  `load` restores the record bit for bit.  It reads the file once,
compares it with its checksum, and keeps its bytes; arrays of signals are made of them at their first use.
"""

from __future__ import annotations

import io
import json
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, NamedTuple, Self, cast

import numpy as np

from flexmb.arguments import checked
from flexmb.dynamics.jobs.files import (
    READ_ERRORS,
    is_stored_within,
    netcdf_image,
    read_sealed,
    refuse_other_files,
    write_sealed,
)
from flexmb.errors import FileFormatError, InputError
from flexmb.findings.finding import Finding
from flexmb.model import shape
from flexmb.model.signal import Signal, Signals
from flexmb.results.contact_intervals import COLUMNS, MODES, ContactLog
from flexmb.results.naming import LateValues, flag_meanings, global_attributes, long_name, udunits
from flexmb.results.solution import Peaks, Solution, Stats

if TYPE_CHECKING:
    import xarray as xr

# Signals of bodies with many nodes in a netCDF file: one variable a body and quantity, over time and nodes

MOST_SINGLE = 100
"""Largest number of nodes of a body whose signals have a variable each."""

NUMBERED = re.compile(r"(?P<body>.+\.node)(?P<number>\d+)\.(?P<quantity>[^.]+)")
"""Name of a signal of a numbered node."""

PEAK, PEAK_TIME = "peak", "peak_time"
"""Last words of the names of variables, and names of attributes: largest absolute values, and their times."""


class Column(NamedTuple):
    """A signal: values (n,), largest absolute value, its time."""

    values: np.ndarray
    peak: float
    time: float


@dataclass(frozen=True)
class NodeTable:
    """One quantity at many nodes of a body.

    Parameters
    ----------
    dimension : name of the dimension of the nodes, "plate.node".
    quantity : last word of the names of the signals, "vx".
    units : SI unit.
    numbers : (m,) numbers of the nodes.
    places : (m,) places of the signals among all signals.
    """

    dimension: str
    quantity: str
    units: str
    numbers: tuple[int, ...]
    places: tuple[int, ...]

    @property
    def name(self) -> str:
        """Name of the variable."""
        return f"{self.dimension}.{self.quantity}"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the signals (m,)."""
        return tuple(f"{self.dimension}{number}.{self.quantity}" for number in self.numbers)


def node_tables(signals: Signals) -> list[NodeTable]:
    """Tables of all bodies with more than `MOST_SINGLE` nodes.

    The tables of a body have the same nodes; a signal that is saved at other ones, as `signals=` may choose, is left
    out, and so has its own variable.
    """
    found: dict[tuple[str, str, str], list[tuple[int, int]]] = {}
    for place, (name, units) in enumerate(zip(signals.names, signals.units, strict=True)):
        if match := NUMBERED.fullmatch(name):
            key = match["body"], match["quantity"], units
            if str(int(match["number"])) == match["number"]:
                found.setdefault(key, []).append((int(match["number"]), place))
    nodes: dict[str, tuple[int, ...]] = {}
    tables: dict[str, NodeTable] = {}
    for (body, quantity, units), rows in found.items():
        numbers, places = tuple(n for n, _ in rows), tuple(k for _, k in rows)
        table = NodeTable(body, quantity, units, numbers, places)
        if len(numbers) > MOST_SINGLE and nodes.setdefault(body, numbers) == numbers:
            tables.setdefault(table.name, table)
    return [table for table in tables.values() if not {table.name, table.dimension} & signals.places.keys()]


def variables(sol: Solution, tables: Iterable[NodeTable]) -> dict[str, xr.Variable]:
    """Variables of tables: values over time and nodes, peaks and their times over nodes, numbers of the nodes."""
    import xarray as xr

    found = {}
    for table in tables:
        nodes, places, unit = table.dimension, list(table.places), udunits(table.units)
        text = {"long_name": f"numbers of the nodes of {nodes.rpartition('.')[0]}"}
        found[nodes] = xr.Variable(nodes, np.array(table.numbers, dtype=np.int64), text)
        name = long_name(table.name)
        values = np.stack([sol.array(signal) for signal in table.names], axis=1)
        found[table.name] = xr.Variable(("time", nodes), values, {"units": unit, "long_name": name})
        for word, peaks, units, meaning in (
            (PEAK, sol.peaks.values, unit, "largest absolute value"),
            (PEAK_TIME, sol.peaks.times, "s", "time of the largest absolute value"),
        ):
            attrs = {"units": units, "long_name": f"{meaning}, {name}"}
            found[f"{table.name}.{word}"] = xr.Variable(nodes, peaks[places], attrs)
    return found


def read(file: NetcdfContent, name: str, n: int) -> Iterator[tuple[str, Column]]:
    """Names and columns of the signals of a table; a variable that is no table of floats raises `ValueError`."""
    nodes, _, quantity = name.rpartition(".")
    values, numbers = file.array(name), file.array(nodes)
    if values.shape != (n, len(numbers)) or values.dtype != np.float64:
        text = f"{name!r} has shape {values.shape} and type {values.dtype}"
        raise ValueError(f"{text}; it must be {n} x {len(numbers)} floats")
    peaks, times = (file.array(f"{name}.{word}").tolist() for word in (PEAK, PEAK_TIME))
    for number, column, peak, time in zip(numbers.tolist(), values.T, peaks, times, strict=True):
        yield f"{nodes}{number}.{quantity}", Column(column, peak, time)


# Variables and attributes of a netCDF file in memory

LARGEST_GROWTH = 50
"""Size of the data of a file over the size of the file, at most; flexmb does not compress."""

NO_VARIABLE = b"This is a netCDF dimension but not a netCDF variable"
"""First words of the attribute NAME of a dimension without values, by the netCDF-4 format."""


class NetcdfContent:
    """Variables and attributes of a netCDF file whose bytes are in memory.

    Arrays that are stored in one piece share the memory of the bytes; so only names and places are read at first.

    Raises
    ------
    OSError : bytes that are no HDF5 file.
    ValueError : variables that would fill the memory, though the file is small; data in other files.
    """

    def __init__(self, content: bytes) -> None:
        import h5py

        self.content, self.copied = content, 0
        self.hdf: Any = h5py
        self.file: Any = h5py.File(io.BytesIO(content), "r")
        self.shifted = self.file.userblock_size > 0
        refuse_other_files(self.file, datasets=False)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.file.close()

    def __contains__(self, name: str) -> bool:
        return name in self.file

    def names(self, group: str) -> list[str]:
        """Names of the variables of a `group` in the order in which they were written; none without such a group."""
        found = self.file.get(group, {})
        return [name for name in found if not bytes(found[name].attrs.get("NAME", b"")).startswith(NO_VARIABLE)]

    def number(self, name: str) -> float | None:
        """Global attribute `name` as a number; None without such an attribute."""
        value = self.file.attrs.get(name)
        return None if value is None else float(np.asarray(value).ravel()[0])

    def text(self, name: str) -> str:
        """Variable `name`, which holds a text."""
        self._refuse_outer(self.file[name].id)
        return str(self.file[name].asstr()[()])

    def array(self, name: str) -> np.ndarray:
        """Variable `name`."""
        values = self._values(self._dataset(name))
        kind = self.file[name].attrs.get("dtype")  # truth values, which netCDF does not have
        return values.astype(bool) if kind in (b"bool", "bool") else values

    def column(self, name: str, n: int, attributes: Sequence[str]) -> tuple[np.ndarray, list[float]]:
        """Variable that holds one signal (n,), and the values of some of its attributes."""
        dataset = self._dataset(name)
        values = self._values(dataset)
        if values.shape != (n,) or values.dtype != np.float64:
            raise ValueError(f"{name!r} has shape {values.shape} and type {values.dtype}; it must be {n} floats")
        numbers = np.empty((len(attributes), 1))
        for row, attribute in zip(numbers, attributes, strict=True):
            self.hdf.h5a.open(dataset, attribute.encode()).read(row)
        return values, numbers[:, 0].tolist()

    def _dataset(self, name: str) -> Any:
        return self.hdf.h5d.open(self.file.id, name.encode())

    def _refuse_outer(self, dataset: Any) -> None:
        """Refuse a variable whose values lie in another file."""
        if not is_stored_within(dataset):
            raise ValueError(f"{self.hdf.h5i.get_name(dataset).decode()!r} leads to another file, which is not read")

    def _values(self, dataset: Any) -> np.ndarray:
        """Values of a variable; a view of the bytes where they are stored in one piece."""
        kind, shape, place = dataset.dtype, dataset.shape, dataset.get_offset()
        size = math.prod(shape) * kind.itemsize
        if place is not None and not self.shifted and dataset.get_storage_size() == size:
            return np.frombuffer(self.content, kind, math.prod(shape), place).reshape(shape)
        self._refuse_outer(dataset)
        self.copied += size
        if self.copied > LARGEST_GROWTH * len(self.content):
            text = f"it declares {self.copied} bytes of data"
            raise ValueError(f"{text}, more than {LARGEST_GROWTH} times its own size")
        values = np.empty(shape, kind)
        dataset.read(self.hdf.h5s.ALL, self.hdf.h5s.ALL, values)
        return values


# A solution as a netCDF file: one variable a signal, the rest as JSON, groups for the final state and for episodes

SINGLE, FORMAT = 1, 2
"""Versions of the layout: all signals have variables of their own; some share variables.  Newer ones are refused."""

VERSION = "flexmb_format"
RECORD = "flexmb_record"  # a variable, since an attribute of HDF5 holds at most 64 KiB
TIME = "time"
RESTART = "restart"
EPISODES = "episodes"


def save(sol: Solution, path: str | Path) -> Path:
    """Write `sol` to the file `path` and return it as a `Path`.

    Folders that are missing are made.  The file is written beside its place and then renamed, so that an interrupted
    run leaves either the old file or the new one.  Errors: a path that cannot be written; a `model` that cannot be
    written as JSON.
    """
    target, tables = Path(path), node_tables(sol.signals)
    dataset = _dataset(sol, tables)
    groups = {"": dataset}
    encodings: dict[str, dict[str, Any]] = {"": {str(name): {"_FillValue": None} for name in dataset.variables}}
    if sol.restart:
        groups[RESTART] = _restart(sol)
    if sol.contacts.names:
        groups[EPISODES], encodings[EPISODES] = _episodes(sol), {name: {"_FillValue": None} for name, _ in COLUMNS}
    shared = {place for table in tables for place in table.places}
    single = [place for place in range(len(sol.signals)) if place not in shared]
    return write_sealed(target, _with_signals(netcdf_image(groups, encodings), sol, single), "Solution")


@checked
def load(path: str | Path) -> Solution:
    """Read a solution that `Solution.to_netcdf` wrote.

    Parameters
    ----------
    path : the file.

    Raises
    ------
    FileFormatError : a file that is missing, truncated, not written by flexmb, or in a format newer than this version.
    """
    source = Path(path)
    if source.suffix == ".py":
        text = f"{str(source)!r}: a file of Python, and no result of a run. Run it first (flexmb run {source.name})"
        raise FileFormatError(f"{text}, and give the file that this writes: out/{source.stem}/{source.stem}.nc.")
    if not source.is_file():
        raise FileFormatError(f"{str(source)!r}: there is no such file. Check the path; sol.to_netcdf(...) writes one.")
    try:
        with NetcdfContent(read_sealed(source)) as file:
            _check_version(source, file)
            return _solution(file)
    except READ_ERRORS as error:
        text = f"{str(source)!r}: cannot be read as a solution; it is damaged, truncated or no netCDF file ({error})."
        raise FileFormatError(f"{text} Write it again with sol.to_netcdf(...).") from error


def _dataset(sol: Solution, tables: list[NodeTable]) -> xr.Dataset:
    """Time, record, tables of nodes and global attributes."""
    import xarray as xr

    record = {
        "signals": [[s.name, s.units] for s in sol.signals],
        "aliases": dict(sol.aliases),
        "shapes": shape.to_json(sol.shapes),
        "status": sol.status,
        "ok": bool(sol.ok),
        "stats": asdict(sol.stats),
        "notes": sol.notes,
        "findings": [finding.as_dict() for finding in sol.findings],
        "contacts": list(sol.contacts.names),
        "model": dict(sol.model),
        "mechanism": sol.described(),
        "node_tables": [table.name for table in tables],
    }
    try:
        text = json.dumps(record)
    except (TypeError, ValueError) as error:
        message = f"Solution of {sol.name!r}: model cannot be written as JSON ({error})."
        raise InputError(f"{message} Put plain numbers and texts in it.") from error
    time = xr.Variable(TIME, sol.time, {"units": "s", "long_name": TIME})
    kept = xr.Variable((), text, {"long_name": "record of the run as JSON, which flexmb.load reads"})
    attrs = {"mechanism": sol.name, "status": sol.status, "ok": int(sol.ok), VERSION: FORMAT if tables else SINGLE}
    return xr.Dataset({RECORD: kept, **variables(sol, tables)}, {TIME: time}, {**attrs, **global_attributes(sol.model)})


def _with_signals(image: bytes, sol: Solution, places: list[int]) -> bytes:
    """The bytes of a file with signals over its time: xarray takes four times as long to write so many variables.

    What a variable of netCDF-4 is in HDF5: https://docs.unidata.ucar.edu/netcdf-c/current/file_format_specifications.html
    The list of variables in `time` is written once: `attach_scale` would write it anew for each of them.
    """
    import h5py

    whole = io.BytesIO(image)
    with h5py.File(whole, "r+") as file:
        time = file[TIME]
        number, at = time.attrs["_Netcdf4Dimid"], np.empty(1, dtype=object)
        at[0] = np.array([time.ref], dtype=h5py.ref_dtype)
        attached = []
        for k in places:
            s = sol.signals[k]
            variable = file.create_dataset(s.name, data=sol.array(s.name), track_order=True)
            variable.attrs.create("_Netcdf4Dimid", number, dtype=np.int32)
            variable.attrs.create("_Netcdf4Coordinates", [number], dtype=np.int32)
            variable.attrs["units"], variable.attrs["long_name"] = udunits(s.units), long_name(s.name)
            variable.attrs[PEAK] = sol.peaks.values[k : k + 1]
            variable.attrs[PEAK_TIME] = sol.peaks.times[k : k + 1]
            variable.attrs.create("DIMENSION_LIST", at, dtype=h5py.vlen_dtype(h5py.ref_dtype))
            attached.append((variable.ref, 0))
        _attach(time, attached)
    return whole.getvalue()


def _attach(time: Any, attached: list[tuple[Any, int]]) -> None:
    """Write the list of the variables over `time`: references, and the number of their dimension."""
    import h5py

    before = time.attrs.get("REFERENCE_LIST", ())
    kind = [("dataset", h5py.ref_dtype), ("dimension", np.uint32)]
    time.attrs.create("REFERENCE_LIST", np.array([*(tuple(row) for row in before), *attached], dtype=kind))


def _restart(sol: Solution) -> xr.Dataset:
    import xarray as xr

    arrays = sol.restart.items()
    comment = "state at the end of the run, from which flexmb.simulate(..., restart=...) goes on"
    variables = {name: ([f"{name}_{i}" for i in range(a.ndim)], a) for name, a in arrays}
    return xr.Dataset(variables, attrs={"comment": comment})


def _episodes(sol: Solution) -> xr.Dataset:
    """All episodes in the order in which they ended; the contact as its number, named by `flag_meanings`."""
    import xarray as xr

    names, rows = sol.contacts
    attrs: dict[str, dict[str, Any]] = {
        name: {"units": udunits(units), "long_name": long_name(name)} for name, units in COLUMNS
    }
    attrs["contact"] |= {"flag_values": np.arange(float(len(names))), "flag_meanings": flag_meanings(names)}
    attrs["mode"] |= {"flag_values": [float(mode) for mode in MODES], "flag_meanings": " ".join(MODES.values())}
    return xr.Dataset({name: xr.Variable("episode", rows[:, k], attrs[name]) for k, (name, _) in enumerate(COLUMNS)})


def _check_version(source: Path, file: NetcdfContent) -> None:
    version = file.number(VERSION)
    if version is None or RECORD not in file:
        raise FileFormatError(
            f"{str(source)!r}: a netCDF file, but not one of flexmb (no {VERSION!r}, no {RECORD!r}). "
            "Open it with xarray.open_dataset."
        )
    if int(version) not in (SINGLE, FORMAT):
        raise FileFormatError(
            f"{str(source)!r}: written in format {int(version)}; this version of flexmb reads formats up to {FORMAT}. "
            "Install the version of flexmb that wrote it."
        )


def _columns(file: NetcdfContent, signals: Signals, n: int, tables: list[str]) -> list[Column]:
    """Columns of all signals."""
    shared = {name: column for table in tables for name, column in read(file, table, n)}
    found = []
    for name in signals.names:
        if name in shared:
            found.append(shared[name])
        else:
            values, (peak, time) = file.column(name, n, (PEAK, PEAK_TIME))
            found.append(Column(values, peak, time))
    return found


def _solution(file: NetcdfContent) -> Solution:
    record: dict[str, Any] = json.loads(file.text(RECORD))
    signals = Signals.of(Signal(name, units) for name, units in record["signals"])
    time = file.array("time")
    columns = _columns(file, signals, len(time), record.get("node_tables", []))
    peaks = (np.array([getattr(column, word) for column in columns]) for word in ("peak", "time"))
    names = tuple(record.get("contacts", ()))  # files of earlier versions have none
    rows = np.column_stack([file.array(f"{EPISODES}/{name}") for name, _ in COLUMNS]) if names else None
    return Solution(
        time=time,
        values=cast(np.ndarray, LateValues([column.values for column in columns], len(time))),
        signals=signals,
        peaks=Peaks(*peaks),
        status=record["status"],
        ok=record["ok"],
        stats=Stats(**record["stats"]),
        contacts=ContactLog() if rows is None else ContactLog(names, rows),
        aliases=record["aliases"],
        shapes=shape.from_json(record["shapes"]),
        restart={name: file.array(f"{RESTART}/{name}") for name in file.names(RESTART)},
        notes=tuple(record.get("notes", ())),  # files of before have none
        model=record["model"],
        description=record.get("mechanism", {}),
        findings=tuple(Finding(**{**f, "parts": tuple(f["parts"])}) for f in record.get("findings", ())),
    )
