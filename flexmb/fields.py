"""Fields of inputs with their meaning, unit and range, for checks, texts of objects, the command line and docstrings.

    @record
    class Pin(Input):
        radius: float = field("radius of the pin", "m", positive)
        length: float | None = field("length; None: the slot has no ends", "m", not_negative, default=None)

A plain field of a dataclass, as in parts of users, has neither meaning nor unit; declared a number, it must be finite.
"""

from __future__ import annotations

import dataclasses
import inspect
import math
from collections.abc import Callable
from functools import cache
from numbers import Real
from typing import Any, NamedTuple, TypeVar, dataclass_transform

from flexmb import checks
from flexmb.arguments import Checked, joined, sections
from flexmb.checks import collecting
from flexmb.errors import InputError

Kind = TypeVar("Kind", bound=type)


class Rule(NamedTuple):
    """Rule of the values of a field."""

    # function (owner, name, value, unit, hint) that refuses a wrong value, and returns what the field keeps
    check: Callable[[str, str, Any, str, str], Any]
    shown: str = ""  # the rule in documentation, "> 0"


number = Rule(lambda owner, name, value, unit, _: checks.number(owner, name, value, unit))
positive = Rule(checks.positive, "> 0")
"""Rule of a field: a number > 0."""
not_negative = Rule(checks.not_negative, ">= 0")
"""Rule of a field: a number >= 0."""
flag = Rule(lambda owner, name, value, *_: checks.flag(owner, name, value))
vector = Rule(lambda owner, name, value, unit, _: checks.point(owner, name, value, unit))
point = Rule(vector.check, "in the reference configuration")
DIRECTED = "in the reference configuration (any length > 0)"
directed = Rule(lambda owner, name, value, *_: checks.direction(owner, name, value), DIRECTED)


def between(low: float, high: float) -> Rule:
    """A number in [`low`, `high`]."""
    shown = f"between {low:g} and {high:g}"
    return Rule(lambda owner, name, value, *more: checks.between(owner, name, value, low, high, *more), shown)


def count(least: int = 1) -> Rule:
    """A whole number >= `least`."""
    return Rule(lambda owner, name, value, _, hint: checks.count(owner, name, value, least, hint), f">= {least}")


def one_of(*allowed: str) -> Rule:
    """One of some texts."""
    return Rule(lambda owner, name, value, *_: checks.one_of(owner, name, value, allowed))


def several(rule: Rule, of: str) -> Rule:
    """A list of any length; a rule for each of its values, and their kind (`of`) for messages."""

    def check(owner: str, name: str, value: Any, unit: str, hint: str) -> tuple[Any, ...]:
        given = checks.sequence(owner, name, value, of)
        return tuple(rule.check(owner, f"{name}[{k}]", x, unit, hint) for k, x in enumerate(given))

    return Rule(check, rule.shown)


def either(kind: Any, rule: Rule) -> Rule:
    """An object of a class, or else a rule."""
    return Rule(lambda owner, name, x, *more: x if isinstance(x, kind) else rule.check(owner, name, x, *more))


def two(rule: Rule, of: str, wanted: str) -> Rule:
    """A pair; a rule for each of its values, and their kind (`of`) and the `wanted` pair for messages."""

    def check(owner: str, name: str, value: Any, unit: str, hint: str) -> tuple[Any, ...]:
        given = checks.sequence(owner, name, value, f"two {of}")
        if len(given) != 2:
            raise InputError(f"{owner}: {name} is {value!r}; give {wanted}.")
        return tuple(rule.check(owner, f"{name}[{k}]", x, unit, hint) for k, x in enumerate(given))

    return Rule(check, rule.shown)


def instance(kind: type | tuple[type, ...], wanted: str) -> Rule:
    """An object of a class; `wanted` ends the message: "it must be a motion, e.g. Ramp(6.28, 0.5)"."""
    return Rule(lambda owner, name, value, *_: checks.instance(owner, name, value, kind, wanted))


class Field(NamedTuple):
    """Declaration of a field of a dataclass; one of the standard library has a name and a type alone."""

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
        return with_unit(self.meaning, self.unit, f", {self.rule.shown}" if self.rule and self.rule.shown else "")


def with_unit(meaning: str, unit: str, more: str = "") -> str:
    """A meaning with its unit in brackets, and `more`, before its first semicolon."""
    head, mark, rest = meaning.rstrip(".").partition(";")
    return f"{head}{f' [{unit}]' if unit else ''}{more}{mark}{rest}."


def field(meaning: str = "", unit: str = "", rule: Rule | None = None, *, hint: str = "", **options: Any) -> Any:
    """Field of a `record` with its meaning, unit and range.

    Parameters
    ----------
    meaning : what it is; further words follow a semicolon.  Without it the field is not in the docstring.
    unit : SI unit; "rad or m" where it depends on another field.
    rule : what the value must be; None, where that is the default of the field, is always allowed.
    hint : remedy, at the end of messages on numbers out of range.
    options : as of `dataclasses.field`, such as default=1.0.
    """
    return dataclasses.field(metadata={"said": (meaning, unit, rule, hint)}, **options)


@cache
def fields_of(kind: type) -> tuple[Field, ...]:
    """Declarations of the fields of a dataclass."""
    found = []
    for field in dataclasses.fields(kind):
        declared = str(getattr(field.type, "__name__", field.type))
        said: tuple[str, str, Rule | None, str] = field.metadata.get("said", ("", "", None, ""))
        found.append(Field(field.name, declared, *said, field.default is None or "None" in declared))
    return tuple(found)


def unit_of(thing: Any, name: str) -> str:
    """Unit of a field of a dataclass, or of a parameter of a function, length: Annotated[float, "m"]; "" without."""
    if dataclasses.is_dataclass(thing):
        return next((one.unit for one in fields_of(thing) if one.name == name), "")  # type: ignore[arg-type]
    try:
        told: Any = inspect.signature(thing).parameters[name].annotation
        if isinstance(told, str):  # evaluated alone: names for type checking may stand in the others
            made = inspect.unwrap(getattr(thing, "func", thing))
            told = eval(told, getattr(made, "__globals__", vars(inspect.getmodule(made))))
    except (NameError, TypeError, ValueError, KeyError, SyntaxError, AttributeError):  # no such parameter, no signature
        return ""
    told = getattr(told, "__metadata__", ())
    return next((one for one in told if isinstance(one, str)), "")


@dataclass_transform(frozen_default=True, field_specifiers=(field, dataclasses.field))
def record(cls: Kind) -> Kind:
    """Decorator: the class `cls` as a frozen dataclass whose docstring has an entry for each of its fields."""
    return record_with()(cls)


@dataclass_transform(frozen_default=True, field_specifiers=(field, dataclasses.field))
def record_with(**options: bool) -> Callable[[Kind], Kind]:
    """Decorator: `record` with options of `dataclasses.dataclass`, such as eq=False where fields are arrays."""

    def documented(cls: Any) -> Any:
        made: Any = dataclasses.dataclass(frozen=True, **options)(cls)
        texts, declared = sections(inspect.cleandoc(made.__doc__ or "")), dataclasses.fields(made)
        said = [own for own, field in zip(fields_of(cls), declared, strict=True) if field.init and own.meaning]
        keywords = {field.name for field in declared if field.kw_only}  # they come last, as in calls
        ordered = sorted(said, key=lambda field: field.name in keywords)
        texts["Parameters"] = "\n".join(f"{field.name} : {field.text}" for field in ordered)
        made.__doc__ = joined(texts)
        return made

    return documented


@dataclass_transform(frozen_default=True, field_specifiers=(field, dataclasses.field))
def variant(cls: Kind) -> Kind:
    """Decorator: record whose docstring also has the paragraphs below the first line, and the errors, of its base."""
    own, base = sections(inspect.cleandoc(cls.__doc__ or "")), sections(inspect.cleandoc(cls.__base__.__doc__ or ""))
    own[""] = "\n\n".join([own[""], *base[""].split("\n\n")[1:]])
    cls.__doc__ = joined({"Raises": base.get("Raises", ""), **own})
    return record(cls)


class Input(Checked):
    """Base of all inputs: parts, laws, sections, materials, steps, data; fields are checked at the construction."""

    # A subclass that relates several fields to one another does so in its `__post_init__`, after that of the base.

    @collecting
    def __post_init__(self) -> None:
        owner = getattr(self, "label", type(self).__name__)
        kind: Any = type(self)
        unusable = None
        for field in fields_of(kind):
            value = getattr(self, field.name)
            if value is None and field.optional:
                continue
            try:
                kept = value
                if field.rule is not None:
                    kept = field.rule.check(owner, field.name, value, field.unit, field.hint)
                elif field.type in ("float", "float | None"):  # so that equal records compare, hash and print alike
                    kept = checks.number(owner, field.name, value, field.unit)
                elif is_number(value.__class__):  # in a field of another type
                    checks.number(owner, field.name, value, field.unit)
            except InputError as error:
                unusable = unusable or error
                checks.refuse(str(error))
            else:
                refused = isinstance(kept, float) and not math.isfinite(kept)
                if kept is not value and not refused:
                    object.__setattr__(self, field.name, kept)
        if unusable:
            raise unusable


@cache
def is_number(kind: type) -> bool:
    """Whether a class is one of real numbers; remembered, since abstract base classes are slow."""
    return issubclass(kind, Real) and not issubclass(kind, bool)
