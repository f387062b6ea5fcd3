"""Files that are there as a whole or not at all, and logs whose lines survive a kill."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A file beside `path`, which takes its place at the end; an interrupted write leaves the old file."""
    part = path.with_name(f".{path.name}.part")
    part.unlink(missing_ok=True)
    yield part
    part.replace(path)


def write_netcdf(path: Path, groups: Mapping[str, xr.Dataset]) -> Path:
    """Write datasets as the groups of one file, whole or not at all.

    Parameters
    ----------
    path : the file.
    groups : datasets by the name of their group, that of the root is "".
    """
    with whole_file(path) as part:
        for name, dataset in groups.items():
            dataset.to_netcdf(part, engine="h5netcdf", group=name or None, mode="a" if part.exists() else "w")
    return path


def write_text(path: Path, text: str) -> Path:
    """Write a text file, whole or not at all."""
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")
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
