"""Numpydoc docstrings: their sections, the entries of their parameters, and the units written there in brackets."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any, TypeVar, cast, dataclass_transform

Kind = TypeVar("Kind", bound=type)

TITLE = re.compile(r"(?:^|\n)(\w[\w ]*)\n-{3,}\n")
"""Title of a section with the line under it."""

UNIT = re.compile(r"\[((?:1/)?[^\[\]\d,]+[^\[\],]*)\]")
"""Text in brackets that is no range of numbers: "[rad/s]", "[m]"."""

ORDER = ("Parameters", "Raises", "Notes", "Examples")
"""Titles in the order in which a completed docstring has them."""


def sections(doc: str) -> dict[str, str]:
    """Sections of a docstring by title; the text before the first section has the title ""."""
    first, *rest = TITLE.split(doc)
    return {"": first.strip(), **{title: text.strip("\n") for title, text in zip(rest[::2], rest[1::2], strict=True)}}


def parameters(thing: Any) -> dict[str, str]:
    """Entries of the section "Parameters" of a function or class by name, each as text on one line."""
    found: dict[str, str] = {}
    for entry in _entries(sections(inspect.getdoc(thing) or "")):
        text = " ".join(entry.partition(":")[2].split())
        found |= dict.fromkeys(_names(entry), text)
    return found


def units(text: str) -> list[str]:
    """Units that stand in brackets in `text`, in their order."""
    return UNIT.findall(text)


def unit_of(function: Any, parameter: str) -> str:
    """Unit of a parameter of `function`, by its docstring; "" without one."""
    return next(iter(units(parameters(function).get(parameter, ""))), "")


@dataclass_transform(frozen_default=True)
def documented(cls: Kind) -> Kind:
    """Decorator: frozen dataclass whose docstring is completed by the docstring of its base.

    The base `cls` adds the paragraphs below its first line, the errors, and the entries of the parameters which the
    class does not describe.  Parameters stand in the order in which the class takes them.
    """
    made: Any = dataclass(frozen=True)(cls)
    own, base = sections(inspect.cleandoc(cls.__doc__ or "")), sections(inspect.cleandoc(cls.__base__.__doc__ or ""))
    paragraphs = "\n\n".join([own.pop(""), *base.pop("").split("\n\n")[1:]])
    entries = {name: entry for entry in (*_entries(base), *_entries(own)) for name in _names(entry)}
    taken = [entries[field.name] for field in fields(made) if field.init and field.name in entries]
    texts = {"Raises": base.get("Raises", ""), **own, "Parameters": "\n".join(dict.fromkeys(taken))}
    made.__doc__ = "\n\n".join(
        [paragraphs, *(f"{title}\n{'-' * len(title)}\n{texts[title]}" for title in ORDER if texts.get(title))]
    )
    return cast("Kind", made)


def _entries(parts: dict[str, str]) -> Iterator[str]:
    """Entries of the section "Parameters", as they are written."""
    yield from filter(None, re.split(r"\n(?=\S)", parts.get("Parameters", "")))


def _names(entry: str) -> list[str]:
    """Names of the parameters that an entry describes."""
    return [name.strip() for name in entry.partition(":")[0].split(",")]
