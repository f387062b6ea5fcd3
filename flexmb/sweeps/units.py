"""Units of a parameter, from where they are written down: the docstring of the function that takes it."""

from __future__ import annotations

import inspect
import re
from typing import Any

UNIT = re.compile(r"\[((?:1/)?[^\[\]\d,]+[^\[\],]*)\]")
"""What stands in brackets and is no range of numbers: "[rad/s]", "[m]"."""


def documented_unit(function: Any, parameter: str) -> str:
    """The first unit in brackets in the entry of `parameter` in a numpydoc docstring, or ""."""
    doc = inspect.getdoc(function) or ""
    section = re.search(r"^Parameters\n-{3,}\n(.*?)(?=\n\S[^\n]*\n-{3,}\n|\Z)", doc, re.DOTALL | re.MULTILINE)
    for entry in re.split(r"\n(?=\S)", section.group(1)) if section else ():
        names, _, text = entry.partition(":")
        found = UNIT.search(text)
        if parameter in [name.strip() for name in names.split(",")] and found:
            return found.group(1)
    return ""
