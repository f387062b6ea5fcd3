"""Fields of inputs: each says once what it means, its unit and its range; checks, texts, help and pages read it there.

    @record
    class Pin(Input):
        radius: float = field("radius of the pin", "m", positive)
        length: float | None = field("length; None: the slot has no ends", "m", not_negative, default=None)
"""

from __future__ import annotations

import dataclasses
import inspect
import math
from collections.abc import Callable, Iterator
from dataclasses import MISSING
from functools import cache
from itertools import groupby
from numbers import Real
from typing import Any, NamedTuple, TypeVar, dataclass_transform, get_type_hints

from flexmb import checks
from flexmb.arguments import Checked
from flexmb.checks import collecting
from flexmb.docstrings import joined, sections
from flexmb.errors import InputError

Kind = TypeVar("Kind", bound=type)

# Rules: what the value of a field must be


class Rule(NamedTuple):
    """What the value of a field must be.

    Parameters
    ----------
    check : function (owner, name, value, unit, hint) that refuses a wrong value, and returns what the field keeps.
    shown : the rule in documentation, "> 0".
    """

    check: Callable[[str, str, Any, str, str], Any]
    shown: str = ""


def _as_given(check: Callable[..., Any]) -> Callable[[str, str, Any, str, str], Any]:
    """A check after which the field keeps its value as it was given: 1 stays 1, not 1.0."""

    def checked(owner: str, name: str, value: Any, unit: str, hint: str) -> Any:
        check(owner, name, value, unit, hint)
        return value

    return checked


positive = Rule(_as_given(checks.positive), "> 0")
not_negative = Rule(_as_given(checks.not_negative), ">= 0")
number = Rule(_as_given(lambda owner, name, value, unit, _: checks.number(owner, name, value, unit)))
flag = Rule(_as_given(lambda owner, name, value, *_: checks.flag(owner, name, value)))
point = Rule(lambda owner, name, value, unit, _: checks.point(owner, name, value, unit))
direction = Rule(lambda owner, name, value, *_: checks.direction(owner, name, value))


def between(low: float, high: float) -> Rule:
    """A number in [`low`, `high`]."""

    def check(owner: str, name: str, value: Any, unit: str, hint: str) -> None:
        checks.between(owner, name, value, low, high, unit, hint)

    return Rule(_as_given(check), f"between {low:g} and {high:g}")


def count(least: int = 1) -> Rule:
    """A whole number >= `least`."""
    return Rule(lambda owner, name, value, _, hint: checks.count(owner, name, value, least, hint), f">= {least}")


def one_of(*allowed: str) -> Rule:
    """One of some texts."""
    return Rule(lambda owner, name, value, *_: checks.one_of(owner, name, value, allowed))


def points(of: str = "points") -> Rule:
    """Any number of points, `of` which kind the message says."""

    def check(owner: str, name: str, value: Any, unit: str, _: str) -> tuple[tuple[float, float], ...]:
        given = checks.sequence(owner, name, value, of)
        return tuple(checks.point(owner, f"{name}[{k}]", p, unit) for k, p in enumerate(given))

    return Rule(check)


def instance(kind: type | tuple[type, ...], wanted: str) -> Rule:
    """An object of a class; `wanted` ends the message: "it must be a motion, e.g. Ramp(6.28, 0.5)"."""

    def check(owner: str, name: str, value: Any, *_: str) -> Any:
        if not isinstance(value, kind):
            raise InputError(f"{owner}: {name} is {value!r}; it must be {wanted}.")
        return value

    return Rule(check)


# Fields, and records of them


class Field(NamedTuple):
    """What a field of a dataclass says of itself; a field of the standard library says its name and type alone."""

    name: str
    type: str = ""
    meaning: str = ""
    unit: str = ""
    rule: Rule | None = None
    hint: str = ""
    optional: bool = False

    @property
    def text(self) -> str:
        """Meaning, with unit and range before its first semicolon."""
        head, mark, rest = self.meaning.partition(";")
        unit = f" [{self.unit}]" if self.unit else ""
        shown = f", {self.rule.shown}" if self.rule and self.rule.shown else ""
        text = f"{head}{unit}{shown}{mark}{rest}"
        return text if text.endswith(".") else f"{text}."


def field(meaning: str, unit: str = "", rule: Rule | None = None, *, hint: str = "", **options: Any) -> Any:
    """Field of a record; `options` are those of `dataclasses.field`, such as default=1.0.

    Parameters
    ----------
    meaning : what it is; further sentences follow a semicolon.
    unit : SI unit; "rad or m" where it depends on another field.
    rule : what the value must be; None, where that is the default of the field, is always allowed.
    hint : remedy, at the end of messages on numbers out of range.
    """
    return dataclasses.field(metadata={"said": (meaning, unit, rule, hint)}, **options)


@cache
def fields_of(kind: type) -> tuple[Field, ...]:
    """Fields of a dataclass, with what they say of themselves."""
    return tuple(_said(field) for field in dataclasses.fields(kind))


def _said(field: dataclasses.Field[Any]) -> Field:
    declared = str(getattr(field.type, "__name__", field.type))
    optional = field.default is None or "None" in declared
    return Field(field.name, declared, *field.metadata.get("said", ("", "", None, "")), optional)


def unit_of(thing: Any, name: str) -> str:
    """Unit of a field of a dataclass, or of a parameter of a function, length: Annotated[float, "m"]; "" without."""
    if dataclasses.is_dataclass(thing):
        return next((field.unit for field in fields_of(thing) if field.name == name), "")
    try:
        hints = get_type_hints(thing, include_extras=True)
    except (NameError, TypeError):  # imported for type checking only; no function
        hints = getattr(thing, "__annotations__", {})
    return next((one for one in getattr(hints.get(name), "__metadata__", ()) if isinstance(one, str)), "")


@dataclass_transform(frozen_default=True, field_specifiers=(field, dataclasses.field))
def record(cls: Kind) -> Kind:
    """Decorator: frozen dataclass whose docstring has an entry for each of its fields."""
    made: Any = dataclasses.dataclass(frozen=True)(cls)
    document(made)
    return made  # type: ignore[no-any-return]


def document(kind: Any) -> None:
    """Complete the docstring of a dataclass by the section "Parameters", from what its fields say."""
    described = sections(inspect.cleandoc(kind.__doc__ or ""))
    taken = {field.name for field in dataclasses.fields(kind) if field.init}
    said = [field for field in fields_of(kind) if field.name in taken and field.meaning]
    entries = (f"{', '.join(one.name for one in same)} : {text}" for text, same in _grouped(said))
    kind.__doc__ = joined({"": described.pop(""), "Parameters": "\n".join(entries), **described})


def _grouped(said: list[Field]) -> Iterator[tuple[str, list[Field]]]:
    """Neighbours of one text."""
    return ((text, list(same)) for text, same in groupby(said, key=lambda field: field.text))


# Inputs: what users declare


class Input(Checked):
    """Base of what users declare: parts, laws, sections, materials, steps, data; its fields are checked when it is made.

    A subclass that relates several fields to one another does so in its `__post_init__`, after that of the base.
    """

    @collecting
    def __post_init__(self) -> None:
        check_fields(self, getattr(self, "label", type(self).__name__))


def check_fields(record: Any, owner: str) -> None:
    """Check all fields of a record by their rules; those without one must be finite where they are numbers."""
    unusable = None
    for field in fields_of(type(record)):
        value = getattr(record, field.name)
        if value is None and field.optional:
            continue
        try:
            kept = _kept(field, owner, value)
        except InputError as error:
            unusable = unusable or error
            checks.refuse(str(error))
            continue
        if kept is not value:
            object.__setattr__(record, field.name, kept)
    if unusable:
        raise unusable


LARGEST_COUNT = 10**15
"""Whole numbers below it are floats without loss."""


def _kept(field: Field, owner: str, value: Any) -> Any:
    """What a field keeps of a value."""
    if field.rule is not None:
        return field.rule.check(owner, field.name, value, field.unit, field.hint)
    kind = value.__class__
    plain = (kind is float and math.isfinite(value)) or (kind is int and abs(value) < LARGEST_COUNT)
    if not plain and (field.type in ("float", "float | None") or is_kind_of_number(kind)):
        checks.number(owner, field.name, value, field.unit)
    return value


@cache
def is_kind_of_number(kind: type) -> bool:
    """Whether a class is one of real numbers; remembered, since abstract base classes are slow."""
    return issubclass(kind, Real) and not issubclass(kind, bool)
