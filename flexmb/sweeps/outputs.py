"""What a function of a sweep returns, as columns: numbers, arrays, texts, or a mapping of them."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from flexmb.errors import InputError
from flexmb.jobs.attempt import Outcome
from flexmb.sweeps.record import STATUS, Column

ALONE = "value"
"""What the result is called of a function that returns one number or array."""

OUTCOME = ("ok", STATUS)


def called(function: Any, arguments: Mapping[str, Any]) -> Outcome:
    """The outcome of one call, its results as {name: (dims or None, array)}.  Runs in the workers."""
    found = function(**arguments)
    named = found if isinstance(found, Mapping) else {ALONE: found}
    if not named:
        raise InputError("The function returned an empty mapping; it must return at least one number.")
    return Outcome({_name(name): _array(name, value) for name, value in named.items()})


def columns_of(results: Mapping[str, Any], dims: Mapping[str, Sequence[str]], taken: Mapping[str, int]) -> list[Column]:
    """Columns that hold such results.

    Parameters
    ----------
    results : of one call, as `called` gives them.
    dims : names of dimensions by the name of a result, for plain arrays.
    taken : lengths of the dimensions of the points.

    Raises
    ------
    InputError : a name or a dimension that is taken, dims of another number, one of two lengths.
    """
    lengths, found = dict(taken), []
    for name, (own, array) in results.items():
        if name in lengths or name in OUTCOME:
            raise InputError(f"The function returned {name!r}, which is a name of the dataset. Rename it.")
        chosen = tuple(dims.get(name, own or (f"{name}_{k}" for k in range(array.ndim))))
        if len(chosen) != array.ndim:
            text = f"The result {name!r} has {array.ndim} dimensions"
            raise InputError(f"{text}, but dims gives it {len(chosen)}: {', '.join(chosen)}.")
        for dim, length in zip(chosen, array.shape, strict=True):
            if lengths.setdefault(dim, length) != length or dim in taken:
                raise InputError(
                    f"The dimension {dim!r} of {name!r} has two lengths or is a parameter. Rename it by dims=."
                )
        found.append(Column(name, kind_of(array), chosen, array.shape))
    if any(column.name in lengths and column.dims != (column.name,) for column in found):
        raise InputError("A result is called like a dimension of another one. Rename it.")
    return found


def fitting(results: Mapping[str, Any], columns: Mapping[str, Column]) -> dict[str, Any]:
    """The values of results for columns that another point has set.

    Raises
    ------
    InputError : results of other names, shapes or kinds.
    """
    if set(results) != set(columns):
        text = f"The function returned {', '.join(sorted(results))}"
        raise InputError(
            f"{text}, at the first point {', '.join(sorted(columns))}. Return the same names at all points."
        )
    for name, (_, array) in results.items():
        column, kind = columns[name], kind_of(array)
        if array.shape != column.shape or kind not in (column.kind, "number" if column.kind == "complex" else kind):
            here, there = f"{kind} {array.shape}", f"{column.kind} {column.shape}"
            raise InputError(
                f"The result {name!r} is {here}, at the first point {there}. Return the same shape everywhere."
            )
        if kind == "complex" and column.kind == "number":
            raise InputError(
                f"The result {name!r} is complex, at the first point real. Return complex numbers everywhere."
            )
    return {name: array[()] for name, (_, array) in results.items()}


def kind_of(array: np.ndarray) -> str:
    """The kind of column for an array."""
    return {"U": "text", "O": "text", "c": "complex"}.get(array.dtype.kind, "number")


def _name(name: Any) -> str:
    if not isinstance(name, str) or not name or "/" in name or name.startswith(("_", ".")):
        raise InputError(
            f"The function returned a result called {name!r}; a name is a text without '/', not begun by '_'."
        )
    return name


def _array(name: Any, value: Any) -> tuple[tuple[str, ...] | None, np.ndarray]:
    """Names of dimensions where the value has some, and its numbers as float64 or complex128, or its text."""
    xr = sys.modules.get("xarray")
    dims = tuple(str(d) for d in value.dims) if xr is not None and isinstance(value, xr.DataArray) else None
    if isinstance(value, str):
        return dims, np.array(value, dtype=object)
    array = np.asarray(value)
    if array.dtype.kind == "U":
        return dims, array.astype(object)
    if array.dtype.kind not in "biufc":
        text = f"The result {name!r} is {type(value).__name__}"
        raise InputError(f"{text}; a function of a sweep returns numbers, arrays of them, texts or a mapping of these.")
    return dims, array.astype(np.complex128 if array.dtype.kind == "c" else np.float64)
