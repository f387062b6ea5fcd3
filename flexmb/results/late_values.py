"""Saved signals that stay in the bytes of their file until they are used."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, overload

import numpy as np

BLOCK = 4096
"""Number of rows that are copied at once, so that a block of all signals fits into the cache of the processor."""


class LateValues:
    """Signals as one array each; the matrix of all of them is made at its first use.

    Parameters
    ----------
    columns : arrays (n,), one for each signal, at any place in memory.
    n : number of saved instants.
    """

    def __init__(self, columns: Sequence[np.ndarray], n: int) -> None:
        self.columns, self.shape = tuple(columns), (n, len(columns))

    def column(self, place: int) -> np.ndarray:
        """Signal number `place`, (n,), read-only."""
        column = np.require(self.columns[place], requirements="A")
        column.flags.writeable = False
        return column

    def matrix(self) -> np.ndarray:
        """All signals, (n, n_s), read-only."""
        values = np.empty(self.shape)
        for first in range(0, len(values), BLOCK):
            for k, column in enumerate(self.columns):
                values[first : first + BLOCK, k] = column[first : first + BLOCK]
        values.flags.writeable = False
        return values


class LateField:
    """Field of a frozen record that holds an array, or `LateValues`, of which the first reader makes the array."""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, record: None, kind: type) -> LateField: ...
    @overload
    def __get__(self, record: object, kind: type) -> np.ndarray: ...
    def __get__(self, record: Any, kind: type) -> Any:
        if record is None:
            raise AttributeError(self.name)  # the field has no default
        value = vars(record)[self.name]
        if isinstance(value, LateValues):
            value = vars(record)[self.name] = value.matrix()
        return value

    def __set__(self, record: Any, value: np.ndarray | LateValues) -> None:
        vars(record)[self.name] = value
