"""Store of results on disk (zarr, format 3) with one chunk per point; an interrupted sweep resumes from its store.

The arrays extend over the dimensions of the sweep.  A chunk is written to a temporary file, which is renamed.  The
status of a point is written last, so a point with a status has all of its results.  The bytes of a finished store do
not depend on the time, place and order of the computation.

Chunks contain the bytes of the numbers without compression (codecs "bytes" and "vlen-utf8" of zarr).  This module
writes a chunk in a tenth of a millisecond; zarr takes one or two milliseconds.  zarr writes all other files.
"""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.errors import FileFormatError, InputError, MissingPackageError
from flexmb.sweeps.record import KINDS, Column, Index, Tables

FORMAT = 1
"""Version of the layout; stores of other versions are refused."""

VERSION = "flexmb_sweep_format"
GROUP_FILE = "zarr.json"
PARTIAL = ".partial"
"""Suffix of temporary files of this module and of zarr."""


class Store:
    """Open store of a sweep; see `opened` and `existing`.

    Parameters
    ----------
    path : folder of the store.
    group : zarr group of the store.
    """

    def __init__(self, path: Path, group: Any) -> None:
        self.path, self.group = path, group

    @property
    def attributes(self) -> dict[str, Any]:
        """Attributes of the store by name."""
        return dict(self.group.attrs)

    def describe(self, **attributes: Any) -> None:
        """Add attributes in one write."""
        if any(self.attributes.get(name) != value for name, value in attributes.items()):
            self._write(self.group.update_attributes, attributes)

    def column(self, column: Column, dims: tuple[str, ...], shape: tuple[int, ...]) -> np.ndarray:
        """Values (*shape, *column.shape) of the array of a column; a missing array is created."""
        kind = KINDS[column.kind]
        if not self._has(column.name):
            self._write(
                self.group.create_array,
                column.name,
                shape=(*shape, *column.shape),
                chunks=(*(1,) * len(shape), *(max(n, 1) for n in column.shape)),
                dtype=kind.stored,
                fill_value=kind.fill,
                dimension_names=[*dims, *column.dims],
                attributes={"units": column.units} if column.units else {},
                compressors=None,
                config={"write_empty_chunks": True},
            )
        with _reading(self.path):
            return np.array(self.group[column.name][...], dtype=kind.dtype)

    def coordinate(self, name: str, dims: tuple[str, ...], values: np.ndarray, attributes: Mapping[str, Any]) -> None:
        """Write a whole array of numbers or texts along dimensions."""
        text = values.dtype.kind in "UO"
        if not self._has(name):
            self._write(
                self.group.create_array,
                name,
                shape=values.shape,
                chunks=tuple(max(n, 1) for n in values.shape),
                dtype=str if text else values.dtype,
                dimension_names=list(dims),
                attributes=dict(attributes),
                compressors=None,
                config={"write_empty_chunks": True},
            )
        self._write(self.group[name].__setitem__, ..., values.astype(object) if text else values)

    def write(self, column: Column, index: Index, value: Any) -> None:
        """Write the value of a column at one point."""
        place = self.path.joinpath(column.name, "c", *map(str, index), *("0",) * len(column.shape))
        self._write(_put, place, _chunk(column, value))

    def read(self) -> Tables:
        """All arrays of the store by name."""
        found = {}
        with _reading(self.path):
            for name, array in sorted(self.group.arrays()):
                values = np.asarray(array[...])
                values = values if values.dtype.kind in "fcbiu" else values.astype(object)
                found[name] = (tuple(array.metadata.dimension_names), values, dict(array.attrs))
        return found

    def _has(self, name: str) -> bool:
        with _reading(self.path):
            return name in self.group

    def _write(self, write: Any, *arguments: Any, **keywords: Any) -> None:
        try:
            write(*arguments, **keywords)
        except OSError as error:
            text = f"Store {str(self.path)!r}: cannot be written ({error.strerror or error})."
            raise InputError(f"{text} Make room or give another folder; resume=True goes on from here.") from error


def opened(path: Any, fingerprint: Mapping[str, Any], kind: str, *, resume: bool) -> Store:
    """New or resumed store.

    Parameters
    ----------
    path : folder of the store.
    fingerprint : texts on which the results depend, by name.
    kind : kind of the sweep, "bifurcation" or "sweep".
    resume : whether an existing store is resumed; False: an existing store is refused.

    Raises
    ------
    InputError : an existing store without `resume`; a store of another model, other settings or another version.
    FileFormatError : a folder with other files, or a damaged store.
    MissingPackageError : zarr is not installed.
    """
    zarr, folder = _zarr(), checks.path("store", path)
    if folder.exists() and not folder.is_dir():
        raise FileFormatError(f"Store {str(folder)!r}: this is a file. Give a folder, such as out/speed.zarr.")
    if (folder / GROUP_FILE).is_file():
        if not resume:
            text = f"Store {str(folder)!r}: it is there already"
            raise InputError(f"{text}. Go on with it (resume=True, --resume), give another path, or delete it.")
        store = existing(folder, mode="r+")
        _refuse_others(store, fingerprint, kind)
        _sweep_out(folder)
        return store
    if folder.exists() and any(not file.name.endswith(PARTIAL) for file in folder.iterdir()):
        raise FileFormatError(f"Store {str(folder)!r}: the folder holds other files. Give an empty or a new one.")
    attributes = {VERSION: FORMAT, "kind": kind, "fingerprint": dict(fingerprint)}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _sweep_out(folder)
        return Store(folder, zarr.create_group(folder, zarr_format=3, attributes=attributes))
    except OSError as error:
        text = f"Store {str(folder)!r}: cannot be made ({error.strerror or error})."
        raise InputError(f"{text} Give a writable folder.") from error


@contextmanager
def _reading(folder: Path) -> Iterator[None]:
    """Context that turns exceptions of zarr on damaged files into a `FileFormatError` with advice."""
    try:
        yield
    except (OSError, ValueError, KeyError, TypeError, RuntimeError) as error:
        text = f"Store {str(folder)!r}: cannot be read ({' '.join(str(error).split())})."
        raise FileFormatError(f"{text} Delete it and compute it anew.") from error


def existing(path: Any, mode: str = "r") -> Store:
    """Existing store, opened without changes.

    Raises
    ------
    InputError : an argument that is not a path.
    FileFormatError : a missing or damaged store, a store of another program or of another version of the format.
    """
    zarr, folder = _zarr(), checks.path("store", path)
    if not (folder / GROUP_FILE).is_file():
        raise FileFormatError(f"Store {str(folder)!r}: there is none. Check the path.")
    with _reading(folder):
        group = zarr.open_group(folder, mode=mode, zarr_format=3)
    version = group.attrs.get(VERSION)
    if version is None:
        text = f"Store {str(folder)!r}: a zarr store, but not one of flexmb's sweeps"
        raise FileFormatError(f"{text}. Open it with xarray.open_zarr, or give another path.")
    if version != FORMAT:
        text = f"Store {str(folder)!r}: written in format {version}; this version of flexmb knows format {FORMAT}"
        raise FileFormatError(f"{text}. Use the version of flexmb that wrote it.")
    return Store(folder, group)


def _refuse_others(store: Store, fingerprint: Mapping[str, Any], kind: str) -> None:
    """Refuse a store of another sweep; the message lists the differences."""
    found, label = store.attributes, f"Store {str(store.path)!r}"
    if found.get("kind") != kind:
        raise InputError(f"{label}: it holds a {found.get('kind')}, not a {kind}. Give another path.")
    there, here = found.get("fingerprint", {}), json.loads(json.dumps(fingerprint))
    names = sorted(name for name in {*there, *here} if there.get(name) != here.get(name))
    if names:
        listed = "; ".join(f"{name}: {there.get(name)} there, {here.get(name)} now" for name in names)
        raise InputError(
            f"{label}: it was written by another sweep ({listed}). Give another path, or what it was made of."
        )


def _chunk(column: Column, value: Any) -> bytes:
    """Bytes of one chunk: numbers in order; or number of texts, and length and UTF-8 bytes of each text."""
    kind = KINDS[column.kind]
    if kind.stored is not str:
        return np.ascontiguousarray(value, dtype=np.dtype(kind.stored).newbyteorder("<")).tobytes()
    texts = [str(text).encode() for text in np.ravel(np.array(value, dtype=object))]
    return struct.pack("<I", len(texts)) + b"".join(struct.pack("<I", len(text)) + text for text in texts)


def _put(place: Path, content: bytes) -> None:
    """Write a file; an interrupted call leaves no file."""
    beside = place.with_name(f"{place.name}.{os.getpid()}{PARTIAL}")
    try:
        beside.write_bytes(content)
    except FileNotFoundError:
        place.parent.mkdir(parents=True, exist_ok=True)
        beside.write_bytes(content)
    beside.replace(place)


def _sweep_out(folder: Path) -> None:
    """Remove temporary files of a killed process."""
    for file in folder.rglob(f"*{PARTIAL}"):
        file.unlink(missing_ok=True)


def _zarr() -> Any:
    try:
        return import_module("zarr")
    except ImportError as error:
        text = "A store needs the package 'zarr', which is not installed. Install it: pip install zarr"
        raise MissingPackageError(f"{text}, or leave store= out.") from error
