"""A solution as a netCDF file: one variable a signal, the rest as JSON, groups for the final state and for episodes.

Signals of bodies with many nodes share variables over time and nodes (`netcdf_nodes`).
The variables can be read by any netCDF reader.  `load` restores the record bit for bit.  It reads the file once,
compares it with its checksum, and keeps its bytes; arrays of signals are made of them at their first use.
"""

from __future__ import annotations

import io
import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from flexmb.arguments import checked
from flexmb.errors import FileFormatError, InputError
from flexmb.jobs.files import READ_ERRORS, netcdf_image, read_sealed, write_sealed
from flexmb.model import shape
from flexmb.model.signal import Signal, Signals
from flexmb.results.contact_intervals import COLUMNS, MODES, ContactLog
from flexmb.results.conventions import flag_meanings, global_attributes, long_name, udunits
from flexmb.results.late_values import LateValues
from flexmb.results.netcdf_content import NetcdfContent
from flexmb.results.netcdf_nodes import PEAK, PEAK_TIME, Column, NodeTable, node_tables, read, variables
from flexmb.results.peaks import Peaks
from flexmb.results.solution import Solution
from flexmb.results.stats import Stats

if TYPE_CHECKING:
    import xarray as xr

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
    )
