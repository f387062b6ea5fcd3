"""Fields of parts set on the command line: --set PART.FIELD=VALUE."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import is_dataclass, replace
from typing import Any

from flexmb import checks
from flexmb.commands.arguments.mechanism_options import Option, options_of
from flexmb.commands.arguments.units import UNITS
from flexmb.errors import InputError
from flexmb.model.mechanism import Mechanism, require_field
from flexmb.model.part import Part


class Field(Option):
    """A field of a part as an option; `name` is that of the option and the path of the field."""

    @property
    def flag(self) -> str:
        """The option and the field as they are typed: "--set B.bearing_radius"."""
        return f"--{self.name}"


GRAVITY = Field("set gravity", "numbers", None, "m/s^2", "")
TRUTH = {"true": True, "yes": True, "on": True, "1": True, "false": False, "no": False, "off": False, "0": False}


def changed(mechanism: Mechanism, texts: Sequence[str]) -> Mechanism:
    """The mechanism with changed fields: "crank.mass=200g", "B.normal.restitution=0.8", "gravity=0,-9.81"."""
    changes = {}
    for text in texts:
        path, equals, value = text.partition("=")
        if not equals or not value:
            raise InputError(f"--set: {text!r} has no value; give PART.FIELD=VALUE, e.g. crank.mass=200g.")
        changes[path] = _value(field_option(mechanism, path, "set"), value)
    return mechanism.with_(changes) if isinstance(mechanism, Mechanism) and changes else mechanism


def field_option(mechanism: Mechanism, path: str, flag: str) -> Option:
    """The field of a part as an option, with the kind and the unit in the docstring of its class.

    The path is "PART.FIELD", "PART.FIELD.FIELD", or "gravity"; `flag` is the option that names the field, for messages.
    """
    if path == "gravity":
        return GRAVITY
    name, _, rest = path.partition(".")
    label = f"--{flag}: {path!r}"
    if not rest:
        raise InputError(f"{label} names no field; give PART.FIELD. Parts: {', '.join(mechanism.names)}.")
    owner: Any = mechanism.find(name)
    *inner, last = rest.split(".")
    for field in inner:
        owner = getattr(owner, require_field(label, field, owner))
        if not is_dataclass(owner):
            raise InputError(f"{label}: {field!r} has no fields of its own.")
    value = getattr(owner, require_field(label, last, owner))
    found = next((option for option in options_of(type(owner)) if option.name == last), None)
    if found is None or isinstance(value, Part) or is_dataclass(value):
        text = f"{label}: {last!r} is {type(value).__name__}, which cannot be typed"
        raise InputError(f"{text}. Change it in a file of your own with mech.with_ or mech.with_part.")
    return Field(f"{flag} {path}", found.kind, found.default, found.unit, found.help)


def _value(option: Option, text: str) -> Any:
    if option.kind == "number" and not option.unit:
        return _of_either_unit(option, text)
    if option.kind != "flag":
        return option.value(text.strip("()[]") if option.kind == "numbers" else text)
    return TRUTH[checks.one_of(option.flag, "value", text.lower(), TRUTH)]


def _of_either_unit(option: Option, text: str) -> Any:
    """Number of a field whose unit depends on another one: "rad/s for an angle, m/s for a travel"."""
    words = f" {option.help.replace(',', ' ')} "
    units = [unit for unit in UNITS if unit and f" {unit} " in words]
    for unit in units:
        with suppress(InputError):
            return replace(option, unit=unit).value(text)
    return option.value(text)
