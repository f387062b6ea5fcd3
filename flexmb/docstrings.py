"""Numpydoc docstrings: their sections, and the entries of their parameters."""

import inspect
import re
from collections.abc import Iterator, Mapping
from typing import Any

TITLE = re.compile(r"(?:^|\n)(\w[\w ]*)\n-{3,}\n")  # title of a section with the line under it
ORDER = ("Parameters", "Attributes", "Raises", "Notes", "Examples")  # order of the titles of a joined docstring


def sections(doc: str) -> dict[str, str]:
    """Sections of a docstring by title; the text before the first section has the title ""."""
    first, *rest = TITLE.split(doc)
    return {"": first.strip(), **{title: text.strip("\n") for title, text in zip(rest[::2], rest[1::2], strict=True)}}


def joined(texts: Mapping[str, str]) -> str:
    """Docstring of sections by title; empty ones are left out."""
    titled = [f"{title}\n{'-' * len(title)}\n{texts[title]}" for title in ORDER if texts.get(title)]
    return "\n\n".join([texts[""], *titled])


def parameters(thing: Any) -> dict[str, str]:
    """Entries of the section "Parameters" of a function or class by name, each as text on one line."""
    found: dict[str, str] = {}
    for entry in _entries(sections(inspect.getdoc(thing) or "")):
        names, _, text = entry.partition(":")
        found |= dict.fromkeys((name.strip() for name in names.split(",")), " ".join(text.split()))
    return found


def _entries(parts: Mapping[str, str]) -> Iterator[str]:
    """Entries of the section "Parameters", as they are written."""
    yield from filter(None, re.split(r"\n(?=\S)", parts.get("Parameters", "")))
