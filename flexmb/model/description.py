"""Description of a mechanism in plain values: parts with their classes, numbers and units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.docstrings import parameters, units
from flexmb.model.part import Body, Part

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism

LISTED_VALUES = 8
"""Number of values of a sequence at most; a longer one is described by its length."""


def described(mechanism: Mechanism) -> dict[str, Any]:
    """Plain values that describe a mechanism, for JSON: "gravity" [m/s^2] and "parts".

    Each part has its "name", its "class", the kind "body" or "part", its "mass" [kg] (bodies alone), and "fields":
    [value, unit] by the name of the field, without fields that are None.  Values are numbers, texts, lists of these, or
    for laws, materials and sections such fields again, with "class".
    """
    return {"gravity": list(mechanism.gravity), "parts": [_part(part) for part in mechanism.parts]}


def _part(part: Part) -> dict[str, Any]:
    found: dict[str, Any] = {"name": part.name, "class": type(part).__name__, "kind": "part"}
    if isinstance(part, Body):
        found |= {"kind": "body", "mass": plain(part.total_mass())}
    return {**found, "fields": _fields(part)}


def _fields(owner: Any) -> dict[str, list[Any]]:
    """Values and units of the declared fields of a record, without its name and without fields that are None."""
    kind: Any = type(owner)
    known = units_of_fields(kind)
    names = (field.name for field in fields(owner) if field.init and field.name != "name")
    values = {name: getattr(owner, name) for name in names}
    return {name: [plain(value), known.get(name, "")] for name, value in values.items() if value is not None}


@cache
def units_of_fields(kind: type) -> dict[str, str]:
    """Units of the fields of a class in its docstring, by name."""
    found = {name: next(iter(units(text)), "") for name, text in parameters(kind).items()}
    return {name: unit for name, unit in found.items() if unit}


def plain(value: Any) -> Any:
    """A value as numbers, texts and lists of these; records become dictionaries of their fields."""
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Part):
        return value.name
    if is_dataclass(value) and not isinstance(value, type):
        return {"class": type(value).__name__, "fields": _fields(value)}
    if isinstance(value, tuple | list | np.ndarray | Mapping):
        short = len(value) <= LISTED_VALUES and not isinstance(value, Mapping)
        return [plain(item) for item in value] if short else f"{len(value)} values"
    name = getattr(value, "__name__", type(value).__name__)
    return str(name)
