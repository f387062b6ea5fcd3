"""Results of a sweep by point, in memory and in a store on disk (zarr) from which an interrupted sweep resumes.

The arrays extend over the dimensions of the sweep.  A chunk is written to a temporary file, which is renamed.  The
status of a point is written last, so a point with a status has all of its results.  The bytes of a finished store do
not depend on the time, place and order of the computation.

Chunks contain the bytes of the numbers (codecs "bytes" and "vlen-utf8" of zarr) as an uncompressed file of gzip (codec
"gzip"), whose header names the array and the point, and their checksum (codec "crc32c").  This module writes a chunk in
a tenth of a millisecond; zarr takes one or two milliseconds.  zarr makes the descriptions of arrays; each of them, and
that of the store, has a checksum among its attributes.
"""

from __future__ import annotations

import inspect
import json
import os
import struct
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from hashlib import blake2b
from importlib import import_module
from pathlib import Path
from types import BuiltinFunctionType, FunctionType, MethodType
from typing import Any, NamedTuple, NoReturn

import numpy as np

from flexmb import checks
from flexmb.dynamics.jobs.files import READ_ERRORS
from flexmb.dynamics.systems.dynamics import Dynamics
from flexmb.engine.compiled.digest import UNKNOWN, Parts, digest, named_by, parts_of
from flexmb.errors import FileFormatError, InputError, MissingPackageError


# Fingerprints of sweeps: short texts that are equal if and only if the results are equal
def label_of(function: Any) -> str:
    """Name of a function, a mechanism or a system, such as "flexmb.mechanisms.nine_bar.nine_bar"."""
    if isinstance(function, partial):
        return f"partial of {label_of(function.func)}"
    if isinstance(function, Dynamics) or not callable(function):
        return f"{type(function).__name__} {function.name!r}"
    named = function if isinstance(function, (FunctionType, BuiltinFunctionType, MethodType, type)) else type(function)
    module, name = named.__module__, named.__qualname__
    return name if module in ("__main__", None) else f"{module}.{name}"


def shown_values(values: Sequence[Any]) -> str:
    """Number, first and last value and digest of a list of `values`, for messages and comparison."""
    ends = f" from {values[0]!s:.24s} to {values[-1]!s:.24s}" if len(values) else ""
    return f"{len(values)}{ends} ({digest(list(values))})"


def texts_of(name: str, function: Any) -> dict[str, str]:
    """Digests of a function, and of each object that it names, for messages and comparison."""
    plain = inspect.unwrap(function) if callable(function) else function
    named = named_by(plain) if isinstance(plain, FunctionType) else {}
    return {name: digest(function), **{f"global {key}": digest(named[key]) for key in sorted(named)}}


@parts_of.register
def _system(value: Dynamics) -> Parts:
    state = [value.name, value.names, dict(value.parameters), value.state()]
    return type(value).__qualname__, [*state, *value.makings()]


STATUS = "status"  # name of the column that is written last: a point whose status is not "" is finished
ARRAYS = "arrays"  # attribute of a store: whether an array has one chunk per point, by its name; others are coordinates
Index = tuple[int, ...]
# Arrays by name: dimensions, values, attributes.
Tables = Mapping[str, tuple[tuple[str, ...], np.ndarray, Mapping[str, Any]]]


class Kind(NamedTuple):
    """Representation of the entries of a column: type in memory, type in the store, value of missing entries."""

    dtype: Any
    stored: Any
    fill: Any


KINDS = {
    "number": Kind(np.float64, "float64", np.nan), "flag": Kind(np.bool_, "bool", False), "text": Kind(object, str, ""),
    "complex": Kind(np.complex128, "complex128", complex(np.nan, np.nan)),
}  # fmt: skip


@dataclass(frozen=True)
class Column:
    """Column of results: one entry per point."""

    name: str  # name of the result
    kind: str = "number"  # "number", "complex", "flag" or "text"
    dims: tuple[str, ...] = ()  # names of the dimensions of an entry
    shape: tuple[int, ...] = ()  # lengths of the dimensions of an entry
    units: str = ""  # unit; "" for none


class Record:
    """Arrays of results over the points by name, (*shape, *column.shape), and coordinates; store None: in memory."""

    def __init__(self, dims: tuple[str, ...], shape: tuple[int, ...], store: Store | None = None) -> None:
        self.dims, self.shape, self.store = dims, shape, store
        self.columns, self.attributes = dict[str, Column](), dict[str, Any]()
        self.tables = dict[str, tuple[tuple[str, ...], np.ndarray, Mapping[str, Any]]]()
        self.add([Column("ok", "flag"), Column(STATUS, "text")])

    @property
    def done(self) -> np.ndarray:
        """Flags of the finished points (*shape)."""
        return np.asarray(self.tables[STATUS][1] != "", dtype=np.bool_)

    def add(self, columns: Iterable[Column]) -> None:
        """Add `columns`; finished values are read from the store, in which none may be lost."""
        new = list(columns)
        for column in new:
            kind, attributes = KINDS[column.kind], {"units": column.units} if column.units else {}
            self.columns[column.name] = column
            if self.store is None:
                values = np.full((*self.shape, *column.shape), kind.fill, dtype=kind.dtype)
            else:
                values = self.store.column(column, self.dims, self.shape)
            self.tables[column.name] = ((*self.dims, *column.dims), values, attributes)
        for column in new:
            needed = self.done if column.name == "ok" else self.done & self.tables["ok"][1]
            if self.store is not None:
                self.store.refuse_lost(column.name, needed, len(column.shape))

    def coordinate(self, name: str, dims: tuple[str, ...], values: np.ndarray, units: str = "") -> None:
        """Set a coordinate: values along dimensions, numbers or texts."""
        self.tables[name] = (dims, values, {"units": units} if units else {})
        if self.store is not None:
            self.store.coordinate(name, *self.tables[name])

    def describe(self, **attributes: Any) -> None:
        """Set attributes of the whole sweep: numbers, texts and lists of them."""
        self.attributes.update(attributes)
        if self.store is not None:
            known = {**self.store.attributes.get(ARRAYS, {}), **{name: name in self.columns for name in self.tables}}
            self.store.describe(**attributes, **{ARRAYS: {name: known[name] for name in sorted(known)}})

    def keep(self, index: Index, values: Mapping[str, Any]) -> None:
        """Store the results of the point at `index`, its status last; a point that is `ok` has all results."""
        for name in sorted(self.columns if values["ok"] else values, key=lambda name: name == STATUS):
            value = self.tables[name][1][index] = values.get(name, self.at(index, name))
            if self.store is not None:
                self.store.write(self.columns[name], index, value)

    def at(self, index: Index, name: str) -> Any:
        """Entry of the column `name` at `index`."""
        return self.tables[name][1][index]


FORMAT = 4  # version of the layout; stores of other versions are refused
VERSION = "flexmb_sweep_format"
# Attributes of a description: checksum of the rest, and that of the values of a coordinate, which is one chunk.
SEAL, CONTENT = "checksum", "content"
GROUP_FILE = "zarr.json"
GZIP = bytes((0x1F, 0x8B, 8, 8, 0, 0, 0, 0, 0, 255))  # header of a file of gzip with a name, of no time and system
PARTIAL = ".partial"  # suffix of temporary files of this module and of zarr


class Store:
    """Open store of a sweep; see `opened` and `existing`."""

    def __init__(self, path: Path, attributes: Mapping[str, Any]) -> None:
        self.path, self.attributes = path, dict(attributes)

    def describe(self, **attributes: Any) -> None:
        """Add attributes in one write."""
        if any(self.attributes.get(name) != value for name, value in attributes.items()):
            self.attributes |= attributes
            content = {"attributes": self.attributes, "zarr_format": 3, "node_type": "group"}
            self._put(self.path / GROUP_FILE, _sealed(content))

    def column(self, column: Column, dims: tuple[str, ...], shape: tuple[int, ...]) -> np.ndarray:
        """Values (*shape, *column.shape) of the array of a column; a missing array is created."""
        kind = KINDS[column.kind]
        if not (self.path / column.name / GROUP_FILE).is_file():
            self._lay_out(
                column.name, shape=(*shape, *column.shape),
                chunks=(*(1,) * len(shape), *(max(n, 1) for n in column.shape)), dtype=kind.stored,
                fill_value=kind.fill, dimension_names=[*dims, *column.dims],
                attributes={"units": column.units} if column.units else {},
                compressors=[_zarr().codecs.GzipCodec(level=0), _zarr().codecs.Crc32cCodec()],
            )  # fmt: skip
        with _reading(self.path):
            return np.array(self._array(column.name)[...], dtype=kind.dtype)

    def coordinate(self, name: str, dims: tuple[str, ...], values: np.ndarray, attributes: Mapping[str, Any]) -> None:
        """Write a whole array of numbers or texts along dimensions."""
        text = values.dtype.kind in "UO"
        self._lay_out(
            name, values.astype(object) if text else values, shape=values.shape,
            chunks=tuple(max(n, 1) for n in values.shape), dtype=str if text else values.dtype,
            dimension_names=list(dims), attributes=dict(attributes),
        )  # fmt: skip

    def write(self, column: Column, index: Index, value: Any) -> None:
        """Write the value of a column at one point."""
        # Numbers in order; or number of texts, and length and UTF-8 bytes of each text; as of gzip.
        place, kind = self._place(column.name, index, len(column.shape)), KINDS[column.kind]
        if kind.stored is not str:
            data = np.ascontiguousarray(value, dtype=np.dtype(kind.stored).newbyteorder("<")).tobytes()
        else:
            texts = [str(text).encode() for text in np.ravel(np.array(value, dtype=object))]
            data = struct.pack("<I", len(texts)) + b"".join(struct.pack("<I", len(text)) + text for text in texts)
        ending = struct.pack("<II", zlib.crc32(data), len(data) % 2**32)
        data = self._header(place) + zlib.compress(data, 0, -15) + ending
        self._put(place, data + _crc32c(data))

    def read(self) -> Tables:
        """All arrays of the store by name; results of a point without a status are not `ok`."""
        found, arrays = {}, {}
        with _reading(self.path):
            for name in self.attributes[ARRAYS]:
                array = arrays[name] = self._array(name)
                values = np.asarray(array[...])
                values = values if values.dtype.kind in "fcbiu" else values.astype(object)
                attributes = {key: value for key, value in array.attrs.items() if key not in (SEAL, CONTENT)}
                found[name] = (tuple(array.metadata.dimension_names), values, attributes)
            done, ok = np.asarray(found[STATUS][1] != "", dtype=np.bool_), found["ok"][1]
            ok &= done
        for name, per_point in self.attributes[ARRAYS].items():
            needed = (done if name == "ok" else ok) if per_point else np.array(True)
            self.refuse_lost(name, needed, arrays[name].ndim - needed.ndim)
        return found

    def refuse_lost(self, name: str, needed: np.ndarray, inner: int) -> None:
        """Refuse a store with missing chunks."""
        for index in np.ndindex(needed.shape):
            place = self._place(name, index, inner)
            if needed[index] and not place.is_file():
                self._refuse(place, "is lost")

    def _refuse(self, place: Path, wrong: str) -> NoReturn:
        text = f"Store {str(self.path)!r}: {str(place.relative_to(self.path))!r} {wrong}."
        raise FileFormatError(f"{text} Delete the store and compute it anew.")

    def _header(self, place: Path) -> bytes:
        """Header of a chunk in the format of gzip, with its name in the store."""
        return GZIP + place.relative_to(self.path).as_posix().encode("latin-1", "backslashreplace") + b"\0"

    def _place(self, name: str, index: Sequence[int], inner: int) -> Path:
        """File of the chunk of a point, or of a whole array."""
        return self.path.joinpath(name, "c", *map(str, index), *("0",) * inner)

    def _array(self, name: str) -> Any:
        """Array of zarr with an undamaged description, and without chunks of others, which may fill the memory."""
        whole = _unsealed(self.path / name / GROUP_FILE, name)["attributes"].get(CONTENT)
        for place in (self.path / name / "c").rglob("*"):
            if place.is_file() and not place.name.endswith(PARTIAL):
                content = place.read_bytes()  # a damaged one has another checksum, which zarr tells
                alien = whole != _digest(content) if whole else not content.startswith(self._header(place))
                if alien and content[-4:] == _crc32c(content[:-4]):
                    self._refuse(place, "holds values of another point")
        return _zarr().open_array(self.path / name, mode="r", zarr_format=3)

    def _lay_out(self, name: str, values: np.ndarray | None = None, **settings: Any) -> None:
        """Write a new array, its description last."""
        zarr, made = _zarr(), dict[str, Any]()
        settings = {"compressors": [zarr.codecs.Crc32cCodec()], "config": {"write_empty_chunks": True}} | settings
        array = zarr.create_array(made, zarr_format=3, **settings)
        if values is not None:
            array[...] = values
        description = json.loads(made.pop(GROUP_FILE).to_bytes())
        files = {place: chunk.to_bytes() for place, chunk in made.items()}
        if values is not None:
            description["attributes"][CONTENT] = _digest(*files.values())
        for place, content in (*files.items(), (GROUP_FILE, _sealed(description, name))):
            self._put(self.path / name / place, content)

    def _put(self, place: Path, content: bytes) -> None:
        """Write a file; an interrupted call leaves no file."""
        beside = place.with_name(f"{place.name}.{os.getpid()}{PARTIAL}")
        try:
            try:
                beside.write_bytes(content)
            except FileNotFoundError:
                place.parent.mkdir(parents=True, exist_ok=True)
                beside.write_bytes(content)
            beside.replace(place)
        except OSError as error:
            text = f"Store {str(self.path)!r}: cannot be written ({error.strerror or error})."
            raise InputError(f"{text} Make room or give another folder; resume=True goes on from here.") from error


def opened(path: Any, fingerprint: Mapping[str, Any], kind: str, *, resume: bool) -> Store:
    """New store in a folder, or, with `resume`, the store that is there, if it has this fingerprint and kind."""
    # The fingerprint holds texts on which the results depend; the kind is "bifurcation" or "sweep". Points with a
    # status are not computed again.
    _zarr()
    folder = checks.path("store", path)
    try:
        found = _found(folder, fingerprint, kind, resume=resume)
        folder.mkdir(parents=True, exist_ok=True)
        for file in folder.rglob(f"*{PARTIAL}"):  # of a killed process
            if file.is_file():
                file.unlink(missing_ok=True)
    except OSError as error:
        text = f"Store {str(folder)!r}: cannot be made or written ({error.strerror or error})."
        raise InputError(f"{text} Give a writable folder.") from error
    if found is not None:
        return found
    store = Store(folder, {})
    store.describe(**{VERSION: FORMAT}, kind=kind, fingerprint=dict(fingerprint))
    return store


def _found(folder: Path, fingerprint: Mapping[str, Any], kind: str, *, resume: bool) -> Store | None:
    """The store of the same sweep in a folder; None: no store, and no other files."""
    if folder.exists() and not folder.is_dir():
        raise FileFormatError(f"Store {str(folder)!r}: this is a file. Give a folder, such as out/speed.zarr.")
    if (folder / GROUP_FILE).is_file():
        if not resume:
            text = f"Store {str(folder)!r}: it is there already"
            raise InputError(f"{text}. Go on with it (resume=True, --resume), give another path, or delete it.")
        found = existing(folder)
        label, there, here = f"Store {str(folder)!r}", found.attributes, json.loads(json.dumps(fingerprint))
        if there.get("kind") != kind:
            raise InputError(f"{label}: it holds a {there.get('kind')}, not a {kind}. Give another path.")
        inner = [value.items() if isinstance(value, dict) else ((name, value),) for name, value in here.items()]
        told = ((name, str(text)) for pairs in inner for name, text in pairs)  # each fixed argument by itself
        untold = [f"{name} ({text.partition(UNKNOWN)[2]})" for name, text in told if UNKNOWN in text]
        if untold:
            text = f"{label}: it cannot be told whether it was written by the same sweep, because of"
            text += f" {', '.join(untold)}. Give another path"
            raise InputError(f"{text}, or make such objects within the function.")
        there = there.get("fingerprint", {})
        names = sorted(name for name in {*there, *here} if there.get(name) != here.get(name))
        if names:
            listed = "; ".join(f"{name}: {there.get(name)} there, {here.get(name)} now" for name in names)
            text = f"{label}: it was written by another sweep ({listed})."
            raise InputError(f"{text} Give another path, or what it was made of.")
        return found
    if folder.exists() and any(not file.name.endswith(PARTIAL) for file in folder.iterdir()):
        raise FileFormatError(f"Store {str(folder)!r}: the folder holds other files. Give an empty or a new one.")
    return None


@contextmanager
def _reading(folder: Path) -> Iterator[None]:
    """Context that turns exceptions of zarr on damaged files into a `FileFormatError` with advice."""
    try:
        yield
    except (*READ_ERRORS, MemoryError) as error:
        text = f"Store {str(folder)!r}: cannot be read ({' '.join(str(error).split())})."
        raise FileFormatError(f"{text} Delete it and compute it anew.") from error


def existing(path: Any) -> Store:
    """Existing store, opened without changes; damaged and foreign ones are refused."""
    _zarr()
    folder = checks.path("store", path)
    file = folder / GROUP_FILE
    if not file.is_file():
        raise FileFormatError(f"Store {str(folder)!r}: there is none. Check the path.")
    with _reading(folder):
        version = json.loads(file.read_bytes()).get("attributes", {}).get(VERSION)
    if version is None:
        text = f"Store {str(folder)!r}: a zarr store, but not one of flexmb's sweeps"
        raise FileFormatError(f"{text}. Open it with xarray.open_zarr, or give another path.")
    if version != FORMAT:
        text = f"Store {str(folder)!r}: written in format {version}; this version of flexmb knows format {FORMAT}"
        raise FileFormatError(f"{text}. Use the version of flexmb that wrote it.")
    with _reading(folder):
        return Store(folder, _unsealed(file)["attributes"])


def _crc32c(data: bytes) -> bytes:
    """Checksum of the codec "crc32c"."""
    return struct.pack("<I", import_module("google_crc32c").value(data))  # zarr depends on it


def _digest(*parts: bytes) -> str:
    return blake2b(b"".join(parts), digest_size=16).hexdigest()


def _checksum(description: Mapping[str, Any], name: str) -> str:
    return _digest(name.encode(), json.dumps(description, sort_keys=True).encode())


def _sealed(description: Mapping[str, Any], name: str = "") -> bytes:
    """Content of the file of a description, with the checksum of it and of the name of its array."""
    attributes = {**description["attributes"], SEAL: _checksum(description, name)}
    return json.dumps({**description, "attributes": attributes}, indent=2).encode()


def _unsealed(file: Path, name: str = "") -> dict[str, Any]:
    """Description in a file, without its checksum."""
    description: dict[str, Any] = json.loads(file.read_bytes())
    if description["attributes"].pop(SEAL, None) != _checksum(description, name):
        raise ValueError(f"{file.parent.name}/{file.name} does not agree with its checksum")
    return description


def _zarr() -> Any:
    try:
        return import_module("zarr")
    except ImportError as error:
        text = "A store needs the package 'zarr', which is not installed. Install it: pip install zarr"
        raise MissingPackageError(f"{text}, or leave store= out.") from error
