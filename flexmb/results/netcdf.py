"""A solution as a netCDF file: one variable a signal, the rest as JSON, groups for the final state and for episodes.

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

from flexmb.errors import FileFormatError, InputError
from flexmb.jobs.files import folder_made, is_whole, netcdf_image, write_sealed
from flexmb.model import shape
from flexmb.model.signal import Signal, Signals
from flexmb.results.contact_intervals import COLUMNS, MODES, ContactLog
from flexmb.results.conventions import flag_meanings, global_attributes, long_name, udunits
from flexmb.results.late_values import LateValues
from flexmb.results.netcdf_content import NetcdfContent
from flexmb.results.peaks import Peaks
from flexmb.results.solution import Solution
from flexmb.results.stats import Stats

if TYPE_CHECKING:
    import xarray as xr

FORMAT = 1
"""Version of the layout; one that this file does not know is refused."""

VERSION = "flexmb_format"
RECORD = "flexmb_record"  # a variable, since an attribute of HDF5 holds at most 64 KiB
TIME = "time"
RESTART = "restart"
EPISODES = "episodes"
READ_ERRORS = (OSError, ValueError, LookupError, TypeError, AttributeError, RuntimeError)  # all seen on damaged files


def save(sol: Solution, path: str | Path) -> Path:
    """Write `sol` to the file `path` and return it as a `Path`.

    Folders that are missing are made.  The file is written beside its place and then renamed, so that an interrupted
    run leaves either the old file or the new one.

    Parameters
    ----------
    sol : the record.
    path : where to; an older file is replaced.

    Raises
    ------
    InputError : a path that cannot be written; a `model` that cannot be written as JSON.
    """
    target = Path(path)
    dataset = _dataset(sol)
    with folder_made("Solution", target):
        groups = {"": dataset}
        encodings: dict[str, dict[str, Any]] = {"": {str(name): {"_FillValue": None} for name in dataset.variables}}
        if sol.restart:
            groups[RESTART] = _restart(sol)
        if sol.contacts.names:
            groups[EPISODES], encodings[EPISODES] = _episodes(sol), {name: {"_FillValue": None} for name, _ in COLUMNS}
        write_sealed(target, _with_signals(netcdf_image(groups, encodings), sol))
    return target


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
        content = source.read_bytes()
        if not is_whole(content):
            text = f"{str(source)!r}: damaged; its content does not agree with its checksum."
            raise FileFormatError(f"{text} Run it again.")
        with NetcdfContent(content) as file:
            _check_version(source, file)
            return _solution(file)
    except READ_ERRORS as error:
        text = f"{str(source)!r}: cannot be read as a solution; it is damaged, truncated or no netCDF file ({error})."
        raise FileFormatError(f"{text} Write it again with sol.to_netcdf(...).") from error


def _dataset(sol: Solution) -> xr.Dataset:
    """Time, record and global attributes."""
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
    }
    try:
        text = json.dumps(record)
    except (TypeError, ValueError) as error:
        message = f"Solution of {sol.name!r}: model cannot be written as JSON ({error})."
        raise InputError(f"{message} Put plain numbers and texts in it.") from error
    time = xr.Variable(TIME, sol.time, {"units": "s", "long_name": TIME})
    kept = xr.Variable((), text, {"long_name": "record of the run as JSON, which flexmb.load reads"})
    attrs = {"mechanism": sol.name, "status": sol.status, "ok": int(sol.ok), VERSION: FORMAT}
    return xr.Dataset({RECORD: kept}, {TIME: time}, {**attrs, **global_attributes(sol.model)})


def _with_signals(image: bytes, sol: Solution) -> bytes:
    """The bytes of a file with all signals over its time: xarray takes four times as long to write so many variables.

    What a variable of netCDF-4 is in HDF5: https://docs.unidata.ucar.edu/netcdf-c/current/file_format_specifications.html
    """
    import h5py

    whole = io.BytesIO(image)
    with h5py.File(whole, "r+") as file:
        time = file[TIME]
        number = time.attrs["_Netcdf4Dimid"]
        for k, s in enumerate(sol.signals):
            variable = file.create_dataset(s.name, data=sol.array(s.name), track_order=True)
            variable.attrs.create("_Netcdf4Dimid", number, dtype=np.int32)
            variable.attrs.create("_Netcdf4Coordinates", [number], dtype=np.int32)
            variable.attrs["units"], variable.attrs["long_name"] = udunits(s.units), long_name(s.name)
            variable.attrs["peak"] = sol.peaks.values[k : k + 1]
            variable.attrs["peak_time"] = sol.peaks.times[k : k + 1]
            variable.dims[0].attach_scale(time)
    return whole.getvalue()


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
    if int(version) != FORMAT:
        raise FileFormatError(
            f"{str(source)!r}: written in format {int(version)}; this version of flexmb reads format {FORMAT}. "
            "Install the version of flexmb that wrote it."
        )


def _solution(file: NetcdfContent) -> Solution:
    record: dict[str, Any] = json.loads(file.text(RECORD))
    signals = Signals.of(Signal(name, units) for name, units in record["signals"])
    time = file.array("time")
    columns, peaks = file.columns(signals.names, len(time), ("peak", "peak_time"))
    names = tuple(record.get("contacts", ()))  # files of earlier versions have none
    rows = np.column_stack([file.array(f"{EPISODES}/{name}") for name, _ in COLUMNS]) if names else None
    return Solution(
        time=time,
        values=cast(np.ndarray, LateValues(columns, len(time))),
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
