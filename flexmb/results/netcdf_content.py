"""Variables and attributes of a netCDF file in memory."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from types import TracebackType
from typing import Any, Self

import numpy as np

from flexmb.jobs.files import is_stored_within, refuse_other_files

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
