"""A solution as a netCDF file: one variable a signal, the rest as JSON, groups for the final state and for episodes.

The variables can be read by any netCDF reader.  `load` restores the record bit for bit.
"""

from __future__ import annotations

import json
import warnings
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.errors import FileFormatError, InputError
from flexmb.jobs.files import is_intact, netcdf_image, write_sealed
from flexmb.model import shape
from flexmb.model.signal import Signal, Signals
from flexmb.results.contact_intervals import COLUMNS, MODES, ContactLog
from flexmb.results.solution import Peaks, Solution
from flexmb.results.stats import Stats

if TYPE_CHECKING:
    import xarray as xr

FORMAT = 1
"""Version of the layout; one that this file does not know is refused."""

ENGINE = "h5netcdf"
VERSION = "flexmb_format"
RECORD = "flexmb_record"  # a variable, since an attribute of HDF5 holds at most 64 KiB
RESTART = "restart"
EPISODES = "episodes"
LARGEST_GROWTH = 50
"""Size of the data of a file over the size of the file, at most; flexmb does not compress."""

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
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        groups = {"": dataset}
        encodings: dict[str, dict[str, Any]] = {"": {str(name): {"_FillValue": None} for name in dataset.variables}}
        if sol.restart:
            groups[RESTART] = _restart(sol)
        if sol.contacts.names:
            groups[EPISODES], encodings[EPISODES] = _episodes(sol), {name: {"_FillValue": None} for name, _ in COLUMNS}
        write_sealed(target, netcdf_image(groups, encodings))
    except OSError as error:
        text = f"Solution: {str(target)!r} cannot be written ({error.strerror or error})."
        raise InputError(f"{text} Give a file in a writable folder.") from error
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
    if not source.is_file():
        raise FileFormatError(f"{str(source)!r}: there is no such file. Check the path; sol.to_netcdf(...) writes one.")
    if not is_intact(source):
        raise FileFormatError(f"{str(source)!r}: damaged; its content does not agree with its checksum. Run it again.")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # on files that are not flexmb's, which are refused below
            dataset, restart, episodes = _read(source)
        _check_version(source, dataset)
        return _solution(dataset, restart, episodes)
    except READ_ERRORS as error:
        text = f"{str(source)!r}: cannot be read as a solution; it is damaged, truncated or no netCDF file ({error})."
        raise FileFormatError(f"{text} Write it again with sol.to_netcdf(...).") from error


def _dataset(sol: Solution) -> xr.Dataset:
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
    dataset = sol.dataset
    for k, s in enumerate(sol.signals):
        dataset[s.name].attrs.update(peak=sol.peaks.values[k], peak_time=sol.peaks.times[k])
    dataset[RECORD] = xr.Variable((), text)
    return dataset.assign_attrs({VERSION: FORMAT, "Conventions": "CF-1.11"})


def _restart(sol: Solution) -> xr.Dataset:
    import xarray as xr

    arrays = sol.restart.items()
    return xr.Dataset({name: ([f"{name}_{i}" for i in range(a.ndim)], a) for name, a in arrays})


def _episodes(sol: Solution) -> xr.Dataset:
    """All episodes in the order in which they ended; the contact as its number, named by `flag_meanings`."""
    import xarray as xr

    names, rows = sol.contacts
    attrs: dict[str, dict[str, Any]] = {name: {"units": units} for name, units in COLUMNS}
    attrs["contact"] = {"flag_values": np.arange(float(len(names))), "flag_meanings": " ".join(names)}
    attrs["mode"] = {"flag_values": [float(mode) for mode in MODES], "flag_meanings": " ".join(MODES.values())}
    return xr.Dataset({name: xr.Variable("episode", rows[:, k], attrs[name]) for k, (name, _) in enumerate(COLUMNS)})


def _read(source: Path) -> tuple[xr.Dataset, dict[str, np.ndarray], dict[str, np.ndarray]]:
    """All variables of the file, of its group of the final state, and of its group of contact intervals."""
    import h5py
    import xarray as xr

    most = LARGEST_GROWTH * source.stat().st_size
    with h5py.File(source, "r") as raw:  # first, since h5netcdf complains on stderr about files that it cannot open
        present = [name for name in (RESTART, EPISODES) if name in raw]
    with xr.open_dataset(source, engine=ENGINE, decode_cf=False, cache=False) as file:
        _refuse_bomb(file, most)
        dataset = file.load()
    groups: dict[str, dict[str, np.ndarray]] = {RESTART: {}, EPISODES: {}}
    for group in present:
        with xr.open_dataset(source, engine=ENGINE, decode_cf=False, cache=False, group=group) as file:
            _refuse_bomb(file, most)
            groups[group] = {str(name): variable.values for name, variable in file.load().data_vars.items()}
    return dataset, groups[RESTART], groups[EPISODES]


def _refuse_bomb(dataset: xr.Dataset, most: int) -> None:
    """Refuse a dataset that would fill the memory, though its file is small."""
    if dataset.nbytes > most:
        raise ValueError(f"it declares {dataset.nbytes} bytes of data, more than {LARGEST_GROWTH} times its own size")


def _check_version(source: Path, dataset: xr.Dataset) -> None:
    version = dataset.attrs.get(VERSION)
    if version is None or RECORD not in dataset:
        raise FileFormatError(
            f"{str(source)!r}: a netCDF file, but not one of flexmb (no {VERSION!r}, no {RECORD!r}). "
            "Open it with xarray.open_dataset."
        )
    if int(version) != FORMAT:
        raise FileFormatError(
            f"{str(source)!r}: written in format {int(version)}; this version of flexmb reads format {FORMAT}. "
            "Install the version of flexmb that wrote it."
        )


def _solution(dataset: xr.Dataset, restart: dict[str, np.ndarray], episodes: dict[str, np.ndarray]) -> Solution:
    record: dict[str, Any] = json.loads(str(dataset[RECORD].values[()]))
    signals = Signals.of(Signal(name, units) for name, units in record["signals"])
    time = dataset["time"].values
    values = np.empty((len(time), len(signals)))
    for k, s in enumerate(signals):
        values[:, k] = dataset.variables[s.name].values
    attrs = [dataset.variables[s.name].attrs for s in signals]
    peaks = Peaks(np.array([a["peak"] for a in attrs]), np.array([a["peak_time"] for a in attrs]))
    names = tuple(record.get("contacts", ()))  # files of earlier versions have none
    columns = [episodes[name] for name, _ in COLUMNS] if names else []
    return Solution(
        time=time,
        values=values,
        signals=signals,
        peaks=peaks,
        status=record["status"],
        ok=record["ok"],
        stats=Stats(**record["stats"]),
        contacts=ContactLog(names, np.column_stack(columns)) if names else ContactLog(),
        aliases=record["aliases"],
        shapes=shape.from_json(record["shapes"]),
        restart=restart,
        notes=tuple(record.get("notes", ())),  # files of before have none
        model=record["model"],
        description=record.get("mechanism", {}),
    )
