"""The results of a sweep, point by point: in memory, and in a store when one is given."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from flexmb.sweeps.store import Store

STATUS = "status"
"""The column that is written last: a point whose status is not "" is finished."""

Index = tuple[int, ...]
Tables = Mapping[str, tuple[tuple[str, ...], np.ndarray, Mapping[str, Any]]]
"""Arrays by name: dimensions, values, attributes."""


@dataclass(frozen=True)
class Kind:
    """How the numbers of a column are held, and what stands where there are none."""

    dtype: Any
    stored: Any
    fill: Any


KINDS = {
    "number": Kind(np.float64, "float64", np.nan),
    "complex": Kind(np.complex128, "complex128", complex(np.nan, np.nan)),
    "flag": Kind(np.bool_, "bool", False),
    "text": Kind(object, str, ""),
}


@dataclass(frozen=True)
class Column:
    """One result of every point.

    Parameters
    ----------
    name : its name.
    kind : "number", "complex", "flag" or "text".
    dims : names of the dimensions that it has at every point.
    shape : their lengths.
    units : its units, "" for none.
    """

    name: str
    kind: str = "number"
    dims: tuple[str, ...] = ()
    shape: tuple[int, ...] = ()
    units: str = ""


class Record:
    """Arrays of results over the points, and of coordinates.

    Parameters
    ----------
    dims : names of the dimensions of the points.
    shape : their lengths.
    store : where results are kept too, or None.

    Attributes
    ----------
    columns : what there is of every point.
    tables : arrays (*shape, *column.shape) of the columns by name, and coordinates.
    attributes : what holds for all points.
    """

    def __init__(self, dims: tuple[str, ...], shape: tuple[int, ...], store: Store | None = None) -> None:
        self.dims, self.shape, self.store = dims, shape, store
        self.columns, self.attributes = dict[str, Column](), dict[str, Any]()
        self.tables = dict[str, tuple[tuple[str, ...], np.ndarray, Mapping[str, Any]]]()
        self.add([Column("ok", "flag"), Column(STATUS, "text")])

    @property
    def done(self) -> np.ndarray:
        """Which points are finished: truth values of that shape."""
        return np.asarray(self.tables[STATUS][1] != "", dtype=np.bool_)

    def add(self, columns: Iterable[Column]) -> None:
        """More columns; what the store has of them is read."""
        for column in columns:
            kind, attributes = KINDS[column.kind], {"units": column.units} if column.units else {}
            self.columns[column.name] = column
            if self.store is None:
                values = np.full((*self.shape, *column.shape), kind.fill, dtype=kind.dtype)
            else:
                values = self.store.column(column, self.dims, self.shape)
            self.tables[column.name] = ((*self.dims, *column.dims), values, attributes)

    def coordinate(self, name: str, dims: tuple[str, ...], values: np.ndarray, units: str = "") -> None:
        """Values along dimensions, numbers or texts."""
        attributes = {"units": units} if units else {}
        self.tables[name] = (dims, values, attributes)
        if self.store is not None:
            self.store.coordinate(name, dims, values, attributes)

    def describe(self, **attributes: Any) -> None:
        """Say what holds for all points; plain numbers, texts and lists of them."""
        self.attributes.update(attributes)
        if self.store is not None:
            self.store.describe(**attributes)

    def keep(self, index: Index, values: Mapping[str, Any]) -> None:
        """The results of the point at `index`, its status among them."""
        for name in sorted(values, key=lambda name: name == STATUS):
            self.tables[name][1][index] = values[name]
            if self.store is not None:
                self.store.write(self.columns[name], index, values[name])

    def at(self, index: Index, name: str) -> Any:
        """What the column `name` has at `index`."""
        return self.tables[name][1][index]
