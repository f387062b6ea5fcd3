"""A solution as a netCDF file: signals as one variable over time, the rest as JSON, groups for restart and contacts.

`values(time, signal)` can be read by any netCDF reader: with xarray as `file["values"].sel(signal="slider.ax")`.  The
names are the coordinate `signal`; `units`, `long_name`, `peak` and `peak_time` belong to them.
`load` restores the record bit for bit.  It reads the file once, and compares it with its checksum.
"""

from __future__ import annotations

import io
import json
import os
import platform
import shlex
from dataclasses import asdict
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.arguments import checked
from flexmb.dynamics.jobs import files
from flexmb.errors import FileFormatError, InputError
from flexmb.findings.finding import Finding
from flexmb.late import h5py
from flexmb.model import shape
from flexmb.model.signal import Signal, Signals
from flexmb.results.contact_intervals import COLUMNS, MODES, ContactLog
from flexmb.results.solution import Peaks, Solution, Stats
from flexmb.version import installed_version

# Long names, units and global attributes by the CF conventions (https://cfconventions.org, CF-1.11)

CONVENTIONS = "CF-1.11"
WRITERS = ("numpy", "h5py")  # packages whose versions a file tells, beside flexmb and Python

MEANINGS = {  # long names of signals whose own names are letters; docs/conventions.md defines them
    "x": "coordinate x", "y": "coordinate y", "theta": "rotation", "vx": "velocity along x",
    "vy": "velocity along y", "omega": "angular velocity", "ax": "acceleration along x",
    "ay": "acceleration along y", "alpha": "angular acceleration", "ex": "eccentricity along x",
    "ey": "eccentricity along y", "vex": "rate of the eccentricity along x",
    "vey": "rate of the eccentricity along y", "fx": "force along x", "fy": "force along y",
    "dx": "deflection along x", "dy": "deflection along y", "mode": "state of the contact",
}  # fmt: skip

ENERGIES = {  # long names of the signals of the part `energy`
    "kinetic": "kinetic energy", "strain": "strain energy", "gravity": "potential energy of gravity",
    "drive_work": "work of the drives", "load_work": "work of the loads",
    "dissipated_contact": "energy lost in normal contact", "dissipated_friction": "energy lost by friction",
    "dissipated_damping": "energy lost by damping", "dissipated_algorithm": "energy lost by the time integration",
    "residual": "error of the balance of energies", "turned_over": "energy turned over",
}  # fmt: skip


def long_name(signal: str) -> str:
    """Long name of a signal: "velocity along x of rod node3" for "rod.node3.vx"."""
    owner, _, own = signal.rpartition(".")
    if owner == "energy" and own in ENERGIES:
        return ENERGIES[own]
    meaning = MEANINGS.get(own, own.replace("_", " "))
    return f"{meaning} of {owner.replace('.', ' ')}" if owner else meaning


def udunits(unit: str) -> str:
    """Unit as UDUNITS reads it: "1" for a number without unit, "1/s" for "/s"; others, such as "N m", are the same."""
    plain = unit.strip()
    return f"1{plain}" if plain.startswith("/") else plain or "1"


def flag_meanings(names: tuple[str, ...]) -> str:
    """Names as the words of the attribute `flag_meanings`, without blanks inside a name."""
    return " ".join("_".join(name.split()) for name in names)


LARGEST_GROWTH = 50  # size of the data of a file over the size of the file, at most; flexmb does not compress
# First words of the attribute NAME of a dimension without values, by the netCDF-4 format.
NO_VARIABLE = b"This is a netCDF dimension but not a netCDF variable"


class NetcdfContent:
    """Content of an open HDF5 file of `size` bytes in memory; `ValueError` for values that would fill the memory."""

    def __init__(self, file: Any, size: int) -> None:
        files.refuse_other_files(file, datasets=False)
        self.file, self.size, self.read = file, size, 0

    def names(self, group: str) -> list[str]:
        """Names of the variables of a `group` in the order in which they were written; none without such a group."""
        found = self.file.get(group, {})
        return [name for name in found if not bytes(found[name].attrs.get("NAME", b"")).startswith(NO_VARIABLE)]

    def number(self, name: str) -> float | None:
        """Global attribute `name` as a number; None without such an attribute."""
        value = self.file.attrs.get(name)
        return None if value is None else float(np.asarray(value).ravel()[0])

    def variable(self, name: str) -> Any:
        """Variable `name` as h5py has it; refused where its values lie in another file."""
        found = self.file[name]
        if not files.is_stored_within(found.id):
            raise ValueError(f"{name!r} leads to another file, which is not read")
        return found

    def array(self, name: str) -> np.ndarray:
        """Variable `name`."""
        variable = self.variable(name)
        self.read += variable.size * variable.dtype.itemsize
        if self.read > LARGEST_GROWTH * self.size:
            raise ValueError(f"it declares {self.read} bytes of data, more than {LARGEST_GROWTH} times its own size")
        values: np.ndarray = variable[()]
        kind = variable.attrs.get("dtype")  # truth values, which netCDF does not have
        return values.astype(bool) if kind in (b"bool", "bool") else np.asarray(values)

    def text(self, name: str) -> str:
        """Variable `name`, which is one text."""
        variable = self.variable(name)
        if variable.size != 1:
            raise ValueError(f"{name!r} has {variable.size} values; it must be one text")
        return str(variable.asstr()[()])

    def floats(self, name: str, shape: tuple[int, ...]) -> np.ndarray:
        """Variable `name`, which holds floats of this shape, read-only."""
        values = self.array(name)
        if values.shape != shape or values.dtype != np.float64:
            size = " x ".join(map(str, shape))
            raise ValueError(f"{name!r} has shape {values.shape} and type {values.dtype}; it must be {size} floats")
        values.flags.writeable = False
        return values


FORMAT = 3  # version of the layout; files of former versions are read, newer ones are refused
VERSION = "flexmb_format"
RECORD = "flexmb_record"  # a variable, since an attribute of HDF5 holds at most 64 KiB
TIME, SIGNAL, VALUES = "time", "signal", "values"
PEAK, PEAK_TIME = "peak", "peak_time"
RESTART = "restart"
EPISODES = "episodes"


def save(sol: Solution, path: str | Path) -> Path:
    """Write `sol` to the file `path` and return it as a `Path`."""
    # Folders that are missing are made. The file is written beside its place and then renamed, so that an interrupted
    # run leaves either the old file or the new one. Errors: a path that cannot be written; a `model` that cannot be
    # written as JSON.
    groups: dict[str, files.Group] = {"": _contents(sol)}
    if sol.restart:
        comment = "state at the end of the run, from which flexmb.simulate(..., restart=...) goes on"
        dims = {name: tuple(f"{name}_{i}" for i in range(a.ndim)) for name, a in sol.restart.items()}
        groups[RESTART] = {name: (dims[name], a, {}) for name, a in sol.restart.items()}, {"comment": comment}
    if sol.contacts.names:
        # All episodes in the order in which they ended; the contact as its number, named by `flag_meanings`
        names, rows = sol.contacts
        attrs: dict[str, Any] = {key: {"units": udunits(unit), "long_name": long_name(key)} for key, unit in COLUMNS}
        attrs["contact"] |= {"flag_values": np.arange(float(len(names))), "flag_meanings": flag_meanings(names)}
        attrs["mode"] |= {"flag_values": [float(mode) for mode in MODES], "flag_meanings": " ".join(MODES.values())}
        groups[EPISODES] = {name: (("episode",), rows[:, k], attrs[name]) for k, (name, _) in enumerate(COLUMNS)}, {}
    return files.write_sealed(checks.path("Solution", path), files.netcdf_image(groups), "Solution")


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
    source = checks.path("load", path)
    if source.suffix == ".py":
        text = f"{str(source)!r}: a file of Python, and no result of a run. Run it first (flexmb run {source.name})"
        raise FileFormatError(f"{text}, and give the file that this writes: out/{source.stem}/{source.stem}.nc.")
    try:
        if not source.is_file():
            text = f"{str(source)!r}: there is no such file"
            text += " but a folder, as of a sweep's store, which xarray.open_zarr reads" if source.is_dir() else ""
            raise FileFormatError(f"{text}. Check the path; sol.to_netcdf(...) writes one.")
        content = files.read_sealed(source)
        with h5py.File(io.BytesIO(content), "r") as file:
            found = NetcdfContent(file, len(content))
            version = found.number(VERSION)
            if version is None or RECORD not in found.file:
                text = f"{str(source)!r}: a netCDF file, but not one of flexmb (no {VERSION!r}, no {RECORD!r})."
                raise FileFormatError(f"{text} Open it with xarray.open_dataset.")
            if not 1 <= int(version) <= FORMAT:
                text = f"{str(source)!r}: written in format {version:g}; this version of flexmb reads formats up to"
                raise FileFormatError(f"{text} {FORMAT}. Install the version of flexmb that wrote it.")
            return _solution(found)
    except files.READ_ERRORS as error:
        text = f"{str(source)!r}: cannot be read as a solution; it is damaged, truncated or no netCDF file ({error})."
        raise FileFormatError(f"{text} Write it again with sol.to_netcdf(...).") from error


def _contents(sol: Solution) -> files.Group:
    """Signals and record as variables, and global attributes."""
    record = {
        "signals": [[s.name, s.units] for s in sol.signals], "aliases": dict(sol.aliases),
        "shapes": shape.to_json(sol.shapes), "status": sol.status, "ok": bool(sol.ok), "stats": asdict(sol.stats),
        "notes": sol.notes, "findings": [finding.as_dict() for finding in sol.findings],
        "contacts": list(sol.contacts.names), "model": dict(sol.model), "mechanism": sol.described(),
    }  # fmt: skip
    try:
        text = json.dumps(record)
    except (TypeError, ValueError) as error:
        message = f"Solution of {sol.name!r}: model cannot be written as JSON ({error})."
        raise InputError(f"{message} Put plain numbers and texts in it.") from error
    of_signals: dict[str, tuple[Any, dict[str, str]]] = {
        SIGNAL: (sol.names, {"long_name": "names of the signals"}),
        "units": ([udunits(unit) for unit in sol.signals.units], {"long_name": "units of the signals"}),
        "long_name": ([long_name(name) for name in sol.names], {"long_name": "long names of the signals"}),
        PEAK: (sol.peaks.values, {"long_name": "largest absolute values of all accepted steps, each in its unit"}),
        PEAK_TIME: (sol.peaks.times, {"units": "s", "long_name": "times of the largest absolute values"}),
    }
    of_values = {"long_name": "values of the signals, each in its unit"}
    of_values["coordinates"] = " ".join(sorted(set(of_signals) - {SIGNAL}))
    names = {"long_name": "record of the run as JSON, which flexmb.load reads"}
    variables: dict[str, files.Variable] = {RECORD: ((), text, names), VALUES: ((TIME, SIGNAL), sol.values, of_values)}
    variables[TIME] = ((TIME,), sol.time, {"units": "s", "long_name": TIME})
    numbers = PEAK, PEAK_TIME
    arrays = {name: np.array(own, dtype=float if name in numbers else str) for name, (own, _) in of_signals.items()}
    variables |= {name: ((SIGNAL,), own, of_signals[name][1]) for name, own in arrays.items()}
    attrs = {"mechanism": sol.name, "status": sol.status, "ok": int(sol.ok), VERSION: FORMAT}
    # Conventions, title, source, history and versions, by mechanism and command
    now, command = datetime.now(UTC).isoformat(timespec="seconds"), sol.model.get("command")
    typed = shlex.join(["flexmb", *map(str, command)]) if isinstance(command, list) else "flexmb.Solution.to_netcdf"
    made = os.fsencode(typed).decode("utf-8", "replace")  # names of files need not be texts
    packages = [f"flexmb {installed_version()}", f"Python {platform.python_version()}"]
    packages += [f"{package} {metadata.version(package)}" for package in WRITERS]
    attrs |= {"Conventions": CONVENTIONS, "title": f"Motion of the mechanism {sol.model.get('name', '')!r}"}
    attrs |= {"source": f"flexmb {sol.model.get('flexmb', installed_version())}"}
    return variables, attrs | {"history": f"{now}: {made}", "versions": ", ".join(packages)}


def _columns(file: NetcdfContent, names: tuple[str, ...], n: int, tables: list[str]) -> tuple[np.ndarray, Peaks]:
    """Signals and peaks of a former version, where a table "plate.node.vx" held the signals "plate.node12.vx"."""
    found: dict[str, tuple[np.ndarray, float, float]] = {}
    for table in tables:
        nodes, _, quantity = table.rpartition(".")
        numbers = file.array(nodes).tolist()
        peaks, times = (file.array(f"{table}.{word}").tolist() for word in (PEAK, PEAK_TIME))
        rows = zip(numbers, file.floats(table, (n, len(numbers))).T, peaks, times, strict=True)
        found |= {f"{nodes}{number}.{quantity}": row for number, *row in rows}  # type: ignore[misc]
    for name in names:
        if name not in found:
            attributes = file.file[name].attrs
            found[name] = file.floats(name, (n,)), float(attributes[PEAK][0]), float(attributes[PEAK_TIME][0])
    values = np.empty((n, len(names)))
    for k, name in enumerate(names):
        values[:, k] = found[name][0]
    return values, Peaks(*(np.array([found[name][k] for name in names]) for k in (1, 2)))


def _solution(file: NetcdfContent) -> Solution:
    record: dict[str, Any] = json.loads(file.text(RECORD))
    if not isinstance(record["ok"], bool) or not isinstance(record["status"], str):
        text = f"ok is {record['ok']!r} and status {record['status']!r}"
        raise ValueError(f"{text}; they must be a truth value and a text")
    wrong = {key: value for key, value in record["stats"].items() if isinstance(value, str) or not 0 <= value < np.inf}
    if wrong:
        raise ValueError(f"statistics of the run are {wrong!r}; they must be numbers from 0 on")
    signals, time = Signals.of(Signal(name, units) for name, units in record["signals"]), file.array(TIME)
    if not np.isfinite(time).all():
        raise ValueError(f"{TIME!r} has values that are not finite")
    if file.number(VERSION) == FORMAT:
        values = file.floats(VALUES, (len(time), len(signals)))
        if tuple(one.decode() if isinstance(one, bytes) else str(one) for one in file.array(SIGNAL)) != signals.names:
            raise ValueError(f"{SIGNAL!r} and the record have other names, or another order")
        peaks = Peaks(*(file.floats(name, (len(signals),)) for name in (PEAK, PEAK_TIME)))
    else:
        values, peaks = _columns(file, signals.names, len(time), record.get("node_tables", []))
    names = tuple(record.get("contacts", ()))  # files of earlier versions have none
    rows = np.column_stack([file.array(f"{EPISODES}/{name}") for name, _ in COLUMNS]) if names else None
    return Solution(
        time=time, values=values, signals=signals, peaks=peaks, status=record["status"], ok=record["ok"],
        stats=Stats(**record["stats"]), contacts=ContactLog() if rows is None else ContactLog(names, rows),
        aliases=record["aliases"], shapes=shape.from_json(record["shapes"]),
        restart={name: file.array(f"{RESTART}/{name}") for name in file.names(RESTART)},
        notes=tuple(record.get("notes", ())),  # files of before have none
        model=record["model"], description=record.get("mechanism", {}),
        findings=tuple(Finding(**{**f, "parts": tuple(f["parts"])}) for f in record.get("findings", ())),
    )  # fmt: skip
