"""Results of a sweep by point, in memory and in an optional store."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from flexmb.sweeps.store import Store

STATUS = "status"
"""Name of the column that is written last: a point whose status is not "" is finished."""

ARRAYS = "arrays"
"""Attribute of a store: whether an array has one chunk per point, by its name; others are coordinates."""

Index = tuple[int, ...]
Tables = Mapping[str, tuple[tuple[str, ...], np.ndarray, Mapping[str, Any]]]
"""Arrays by name: dimensions, values, attributes."""


@dataclass(frozen=True)
class Kind:
    """Representation of the entries of a column: type in memory, type in the store, value of missing entries."""

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
    """Column of results: one entry per point.

    Parameters
    ----------
    name : name of the result.
    kind : "number", "complex", "flag" or "text".
    dims : names of the dimensions of an entry.
    shape : lengths of the dimensions of an entry.
    units : unit; "" for none.
    """

    name: str
    kind: str = "number"
    dims: tuple[str, ...] = ()
    shape: tuple[int, ...] = ()
    units: str = ""


class Record:
    """Arrays of results over the points, and coordinates.

    Parameters
    ----------
    dims : names of the dimensions of the points.
    shape : lengths of these dimensions.
    store : store of the results; None: memory only.

    Attributes
    ----------
    columns : columns by name.
    tables : arrays (*shape, *column.shape) of the columns by name, and coordinates.
    attributes : attributes of the whole sweep.
    """

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
        attributes = {"units": units} if units else {}
        self.tables[name] = (dims, values, attributes)
        if self.store is not None:
            self.store.coordinate(name, dims, values, attributes)

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
