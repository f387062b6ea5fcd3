"""Files that are there as a whole or not at all, and logs whose lines survive a kill."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flexmb.errors import InputError

if TYPE_CHECKING:
    import xarray as xr


@contextmanager
def folder_made(label: str, path: Path) -> Iterator[None]:
    """A block that writes the file `path`, whose folder is made.

    Parameters
    ----------
    label : name of the caller, for messages.
    path : the file.

    Raises
    ------
    InputError : a path that cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        text = f"{label}: {str(path)!r} cannot be written ({error.strerror or error})."
        raise InputError(f"{text} Give a file in a writable folder.") from error


SEAL, DIGEST = b"flexmb-blake2b:", 16
"""First bytes of the checksum behind a file, and number of its further bytes."""


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A file beside `path`, which takes its place at the end; an interrupted write leaves the old file."""
    part = path.with_name(f".{path.name}.part")
    part.unlink(missing_ok=True)
    try:
        yield part
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def write_netcdf(path: Path, groups: Mapping[str, xr.Dataset]) -> Path:
    """Write datasets as the groups of one file, whole or not at all.

    Parameters
    ----------
    path : the file.
    groups : datasets by the name of their group, that of the root is "".
    """
    return write_sealed(path, netcdf_image(groups))


def netcdf_image(groups: Mapping[str, xr.Dataset], encodings: Mapping[str, Mapping[str, Any]] | None = None) -> bytes:
    """The bytes of a netCDF file.

    The file is made in memory: the HDF5 library does not survive a disk that is full.

    Parameters
    ----------
    groups : datasets by the name of their group, that of the root is "".
    encodings : encodings of the variables of a group, by the name of the group.
    """
    image = io.BytesIO()
    for k, (name, dataset) in enumerate(groups.items()):
        encoding = dict((encodings or {}).get(name, {}))
        mode: Any = "a" if k else "w"
        dataset.to_netcdf(image, engine="h5netcdf", group=name or None, mode=mode, encoding=encoding)
    return image.getvalue()


def write_sealed(path: Path, content: bytes) -> Path:
    """Write bytes with their checksum behind them, whole or not at all; they are on the disk when this returns.

    Readers of netCDF ignore the checksum.

    Parameters
    ----------
    path : the file.
    content : its bytes.
    """
    with whole_file(path) as part, part.open("wb") as file:
        file.write(content)
        file.write(SEAL + blake2b(content, digest_size=DIGEST).digest())
        file.flush()
        os.fsync(file.fileno())
    return path


def is_whole(content: bytes) -> bool:
    """Whether the content of a file agrees with the checksum behind it; True without a checksum."""
    end = len(content) - DIGEST - len(SEAL)
    seal = content[max(end, 0) :]
    return (
        not seal.startswith(SEAL)
        or blake2b(memoryview(content)[:end], digest_size=DIGEST).digest() == seal[len(SEAL) :]
    )


def write_text(path: Path, text: str) -> Path:
    """Write a text file, whole or not at all."""
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8", errors="backslashreplace")  # bytes of a command line may be no text
    return path


def append_line(path: Path, **values: Any) -> None:
    """Add a line of named numbers to a log; a line is written at once."""
    line = json.dumps(values) + "\n"
    with path.open("a+b") as log:
        if log.seek(0, os.SEEK_END):
            log.seek(-1, os.SEEK_END)
            line = (
                line if log.read() == b"\n" else "\n" + line
            )  # a line that a kill cut short must not swallow this one
        log.write(line.encode())


def lines_of(path: Path) -> list[dict[str, Any]]:
    """The lines of a log, none where there is no log; lines that a kill cut short are left out."""
    found = []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines() if path.is_file() else []:
        try:
            entry = json.loads(line)
        except json.JSONDecodeError:
            continue
        if isinstance(entry, dict):
            found.append(entry)
    return found
