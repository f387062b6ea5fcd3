"""Options of the command line from the signature and the docstring of a function that makes a mechanism."""

from __future__ import annotations

import argparse
import inspect
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from flexmb.commands.units import known_unit, quantity
from flexmb.errors import InputError
from flexmb.sweeps.grid import parameter_docs

Maker = Callable[..., Any]
KINDS = {"bool": "flag", "float": "number", "int": "count", "str": "text"}
BOUND = re.compile(r"\[([^\[\]]*)\]")


@dataclass(frozen=True)
class Option:
    """One parameter of a maker, as an option.

    Parameters
    ----------
    name : the parameter.
    kind : "number", "count", "numbers" (a tuple), "flag" or "text".
    default : its default, or `inspect.Parameter.empty`.
    unit : SI unit, "" for none.
    help : what the docstring says.
    """

    name: str
    kind: str
    default: Any
    unit: str
    help: str

    @property
    def flag(self) -> str:
        """The option as it is typed."""
        return "--" + self.name.replace("_", "-")

    @property
    def is_required(self) -> bool:
        """Whether the parameter has no default."""
        return self.default is inspect.Parameter.empty

    def value(self, text: str) -> Any:
        """What the maker is given for the typed `text`."""
        if text.lower() == "none" and (self.kind == "text" or self.default is None):
            return None
        if self.kind == "text":
            return text
        if self.kind == "numbers":
            return tuple(quantity(part, self.unit, self.flag) for part in text.split(","))
        number = quantity(text, self.unit, self.flag)
        if self.kind == "count":
            if number != int(number):
                raise InputError(f"{self.flag}: {text!r} is no whole number.")
            return int(number)
        return number


def options_of(maker: Maker) -> list[Option]:
    """The parameters of `maker` that can be typed: numbers, tuples of numbers, flags and texts.

    Units are read from its numpydoc docstring, where they stand in brackets: "clearance : radial play [m]".
    Parameters of other kinds, such as laws or materials, are left to Python.
    """
    described = parameter_docs(maker)
    found = []
    for parameter in _signature(maker).parameters.values():
        kind = _kind(parameter)
        if kind:
            text = described.get(parameter.name, "")
            found.append(Option(parameter.name, kind, parameter.default, _unit(text), text))
    return found


def add_options(parser: argparse.ArgumentParser, maker: Maker, title: str) -> list[Option]:
    """Add the options of `maker` to a parser; what is not typed is not passed on."""
    options = options_of(maker)
    group = parser.add_argument_group(title)
    for option in options:
        shown = (option.help + shown_default(option)).replace("%", "%%")
        common: dict[str, Any] = {"dest": f"maker.{option.name}", "default": argparse.SUPPRESS, "help": shown}
        if option.kind == "flag":
            group.add_argument(option.flag, action=argparse.BooleanOptionalAction, **common)
        else:
            required = {"required": True} if option.is_required else {}
            group.add_argument(option.flag, metavar=_metavar(option), **required, **common)
    return options


def taken(arguments: argparse.Namespace, options: list[Option]) -> dict[str, Any]:
    """Keywords for the maker from what was typed."""
    given = vars(arguments)
    keywords = {}
    for option in options:
        if f"maker.{option.name}" in given:
            value = given[f"maker.{option.name}"]
            keywords[option.name] = value if option.kind == "flag" else option.value(value)
    return keywords


def shown_default(option: Option) -> str:
    """The default for a list of options."""
    if option.is_required:
        return " (must be given)"
    if option.kind == "flag" or option.default is None:
        return ""
    values = option.default if isinstance(option.default, tuple) else (option.default,)
    shown = ",".join(f"{value:.6g}" if isinstance(value, float) else str(value) for value in values)
    return f" (default {shown}{' ' + option.unit if option.unit else ''})"


def _signature(maker: Maker) -> inspect.Signature:
    """The signature; annotations are looked up where possible, so that a name such as `Friction` tells its kinds."""
    try:
        return inspect.signature(maker, eval_str=True)
    except NameError:  # imported for type checking only
        return inspect.signature(maker)


def _kind(parameter: inspect.Parameter) -> str:
    """How the parameter can be typed, "" for not at all; the annotation decides, then the default."""
    if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD, parameter.POSITIONAL_ONLY):
        return ""
    bare = parameter.annotation is parameter.empty
    words = set(re.findall(r"\w+", "" if bare else inspect.formatannotation(parameter.annotation)))
    if "tuple" in words:
        return "numbers" if "float" in words else ""
    return next(
        (kind for word, kind in KINDS.items() if word in words), KINDS.get(type(parameter.default).__name__, "")
    )


def _unit(text: str) -> str:
    """The first unit in brackets."""
    units = (known_unit(found) for found in BOUND.findall(text) if found)
    return next((unit for unit in units if unit), "")


def _metavar(option: Option) -> str:
    return {"number": "X", "count": "N", "numbers": "X,Y", "text": "TEXT"}[option.kind]
