"""Files that are there as a whole or not at all."""

from __future__ import annotations

import errno
import io
import os
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import FileFormatError, FlexmbError, InputError
from flexmb.late import h5py, xr

SEAL, DIGEST = b"flexmb-blake2b:", 16  # first bytes of the checksum behind a file, and number of its further bytes

# Errors of readers on damaged files; all have been seen.
READ_ERRORS = (
    OSError, ValueError, LookupError, TypeError, AttributeError, RuntimeError, ArithmeticError, MemoryError,
    SystemError,
)  # fmt: skip

# Numbers of the errors of disks that are full, and of files that may not grow.
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def unwritable(path: Path, error: Exception, label: str = "") -> InputError:
    """The error of a path that cannot be written, with advice; `label`: name of the caller."""
    reason, number = (error.strerror, error.errno) if isinstance(error, OSError) else (None, None)
    text = f"{label}{': ' if label else ''}{str(path)!r} cannot be written ({reason or error})."
    if number in NO_ROOM:
        return InputError(f"{text} Free some space, or give a path on another disk.")
    return InputError(f"{text} Give a file in a writable folder.")


@contextmanager
def whole_file(path: Path, label: str = "") -> Iterator[Path]:
    """A file beside `path`, with the same ending, which takes its place at the end of the block."""
    # All files of flexmb are written by it: an interrupted write, or a full disk, leaves the old file. Missing folders
    # are made, links are followed, and the content is on the disk when the block ends. A path that cannot be written, a
    # full disk, and an ending or a name that no writer takes raise `InputError`.
    part = path
    try:
        target = Path(os.path.realpath(path))
        target.parent.mkdir(parents=True, exist_ok=True)
        if target.exists() and not (target.is_file() or target.is_dir()):
            yield target  # a pipe or a device
            return
        part = target.with_name(f".{target.stem}.part{target.suffix}")
        part.unlink(missing_ok=True)
        yield part
        with part.open("rb") as file:
            os.fsync(file.fileno())
        part.replace(target)
    except FlexmbError:
        raise
    except (OSError, ValueError, zlib.error) as error:  # ValueError: letters that the system has not, unknown pictures
        inner = error.__context__  # of zlib, whose stream matplotlib closes after the error of the disk
        raise unwritable(path, inner if isinstance(inner, OSError) else error, label) from error
    finally:
        if part != path:
            with suppress(OSError, ValueError):
                part.unlink(missing_ok=True)


def write_netcdf(path: Path, groups: Mapping[str, xr.Dataset]) -> Path:
    """Write datasets as the groups of one file, whole or not at all."""
    image = io.BytesIO()  # in memory: the HDF5 library does not survive a disk that is full
    for k, (name, dataset) in enumerate(groups.items()):
        dataset.to_netcdf(image, engine="h5netcdf", group=name or None, mode="a" if k else "w")
    return write_sealed(path, image.getvalue())


Variable = tuple[tuple[str, ...], Any, Mapping[str, Any]]  # names of the dimensions, values, attributes
Group = tuple[Mapping[str, Variable], Mapping[str, Any]]  # variables by name, attributes


def netcdf_image(groups: Mapping[str, Group]) -> bytes:
    """The bytes of a netCDF file, of the variables and attributes of its groups; xarray would take 1 s to import."""
    import h5netcdf

    image = io.BytesIO()
    with h5netcdf.File(image, "w") as file:
        for name, (variables, attributes) in groups.items():
            group = file.create_group(name) if name else file
            group.attrs.update(attributes)
            for own, (dimensions, values, more) in variables.items():
                array = np.asarray(values)
                sizes = zip(dimensions, array.shape, strict=True)
                group.dimensions.update({d: n for d, n in sizes if d not in group.dimensions})
                if array.dtype == bool:  # which netCDF does not have: as xarray keeps them
                    array, more = array.astype(np.int8), {**more, "dtype": "bool"}  # noqa: PLW2901
                kind = h5py.string_dtype() if array.dtype.kind == "U" else array.dtype
                group.create_variable(own, dimensions, kind, data=array.astype(kind)).attrs.update(more)
    return image.getvalue()


def write_sealed(path: Path, content: bytes, label: str = "") -> Path:
    """Write bytes with their checksum behind them, whole or not at all; they are on the disk when this returns."""
    # Readers of netCDF ignore the checksum.
    with whole_file(path, label) as part, part.open("wb") as file:
        file.write(content)
        file.write(SEAL + blake2b(content, digest_size=DIGEST).digest())
    return path


def read_sealed(path: Path) -> bytes:
    """The content of a file of `write_sealed`; a file without a checksum is taken if nothing stands behind its data."""
    content = path.read_bytes()
    end = len(content) - DIGEST - len(SEAL)
    if content[max(end, 0) :].startswith(SEAL):
        whole = blake2b(memoryview(content)[:end], digest_size=DIGEST).digest() == content[-DIGEST:]
    else:  # the first block of an HDF5 file tells the end of its data, at a place by the version of the block
        begin = {b"\0": 40, b"\1": 44, b"\2": 28, b"\3": 28}.get(content[8:9], 0)
        is_hdf5 = begin > 0 and content.startswith(b"\x89HDF\r\n\x1a\n")
        whole = not is_hdf5 or len(content) <= int.from_bytes(content[begin : begin + 8], "little")
    if not whole:
        raise FileFormatError(f"{str(path)!r}: damaged; its content does not agree with its checksum. Run it again.")
    return content


def refuse_other_files(file: Any, datasets: bool = True) -> None:
    """Refuse an HDF5 file that leads to other files: whoever made it would read local files by the reader's hands."""

    def foreign(name: bytes, link: Any) -> bytes | None:  # an error raised here would not come through HDF5
        if link.type != h5py.h5l.TYPE_HARD:
            return name
        one = h5py.h5o.open(file.id, name) if datasets else None
        return name if isinstance(one, h5py.h5d.DatasetID) and not is_stored_within(one) else None

    found = file.id.links.visit(foreign, info=True)
    if found is not None:
        raise ValueError(f"{found.decode(errors='replace')!r} leads to another file, which is not read")


def is_stored_within(dataset: Any) -> bool:
    """Whether the values of a data set of h5py lie in its file."""
    made = dataset.get_create_plist()
    return not made.get_external_count() and made.get_layout() in STORED_WITHIN


STORED_WITHIN = range(3)  # layouts of HDF5 whose data lie in the file: compact, contiguous, chunked


def load_netcdf(path: Path, groups: Iterable[str] = ("",)) -> dict[str, xr.Dataset]:
    """Datasets of a file of `write_netcdf` by the name of their group; groups that it has not are left out."""
    try:
        content = read_sealed(path)
        with h5py.File(io.BytesIO(content), "r") as file:
            refuse_other_files(file)
            present = [name for name in groups if not name or name in file]
        return {name: xr.load_dataset(io.BytesIO(content), engine="h5netcdf", group=name or None) for name in present}
    except READ_ERRORS as error:
        raise FileFormatError(f"{str(path)!r}: cannot be read ({error}). Make it anew.") from error


def write_text(path: Path, text: str, label: str = "") -> Path:
    """Write a text file, whole or not at all; `label`: name of the caller, for messages."""
    with whole_file(path, label) as part:
        part.write_text(text, encoding="utf-8", errors="backslashreplace")  # bytes of a command line may be no text
    return path
