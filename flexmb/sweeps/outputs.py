"""Results of a function in a sweep, as columns: numbers, arrays, texts, or a mapping of them."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from flexmb.errors import InputError
from flexmb.jobs.attempt import DONE, Outcome, stopped_runs
from flexmb.sweeps.record import STATUS, Column

ALONE = "value"
"""Name of the result of a function that returns one number or array."""

OUTCOME = ("ok", STATUS)
"""Columns of every sweep."""


def called(function: Any, arguments: Mapping[str, Any]) -> Outcome:
    """Outcome of one call, with its results as {name: (dims or None, array)}; runs in the workers."""
    results = function(**arguments)
    named = dict(results) if isinstance(results, Mapping) else {ALONE: results}
    ok, status = _judged(named)
    if not ok:
        return Outcome({}, status, ok=False)
    if not named:
        raise InputError("The function returned an empty mapping; it must return at least one number.")
    return Outcome({_name(name): _array(name, value) for name, value in named.items()}, status)


def _judged(named: dict[Any, Any]) -> tuple[bool, str]:
    """Success and status of a point, taken out of the results of its function, or found from the runs in it."""
    stopped = stopped_runs()
    said, status = np.asarray(named.pop("ok", not stopped)), named.pop(STATUS, "")
    if said.shape or said.dtype.kind != "b":
        raise InputError(f"The function returned ok = {said}; it must be True or False, whether the point succeeded.")
    if not isinstance(status, str):
        raise InputError(f"The function returned {STATUS!r} = {status!r}, a name of the dataset; it must be a text.")
    return bool(said), status or (DONE if said else stopped or "The function returned ok = False.")


def columns_of(
    results: Mapping[str, Any], dims: Mapping[str, Sequence[str]], known_lengths: Mapping[str, int]
) -> list[Column]:
    """Columns for the results of a call."""
    lengths, columns = dict(known_lengths), []
    for name, (own_dims, array) in results.items():
        if name in lengths or name in OUTCOME:
            raise InputError(f"The function returned {name!r}, which is a name of the dataset. Rename it.")
        names_of_dims = tuple(dims.get(name, own_dims or (f"{name}_{k}" for k in range(array.ndim))))
        if len(names_of_dims) != array.ndim:
            text = f"The result {name!r} has {array.ndim} dimensions"
            raise InputError(f"{text}, but dims gives it {len(names_of_dims)}: {', '.join(names_of_dims)}.")
        for dim, length in zip(names_of_dims, array.shape, strict=True):
            if lengths.setdefault(dim, length) != length or dim in known_lengths:
                raise InputError(
                    f"The dimension {dim!r} of {name!r} has two lengths or is a parameter. Rename it by dims=."
                )
        columns.append(Column(name, kind_of(array), names_of_dims, array.shape))
    if any(column.name in lengths and column.dims != (column.name,) for column in columns):
        raise InputError("A result is called like a dimension of another one. Rename it.")
    return columns


def fitting(results: Mapping[str, Any], columns: Mapping[str, Column]) -> dict[str, Any]:
    """Values of results for the columns of the first successful point; other names, shapes or kinds are refused."""
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
    """Kind of a column for an `array`: "number", "complex" or "text"."""
    return {"U": "text", "O": "text", "c": "complex"}.get(array.dtype.kind, "number")


def _name(name: Any) -> str:
    if not isinstance(name, str) or not name or "/" in name or name.startswith(("_", ".")):
        raise InputError(
            f"The function returned a result called {name!r}; a name is a text without '/', not begun by '_'."
        )
    return name


def _array(name: Any, value: Any) -> tuple[tuple[str, ...] | None, np.ndarray]:
    """Names of the dimensions, if the value has names, and its entries as float64, complex128 or text."""
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
