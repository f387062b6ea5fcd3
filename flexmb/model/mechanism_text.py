"""Text and HTML table of a mechanism."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from flexmb.display import html
from flexmb.display.text import counted, cut, given_fields, listed, number_text, value_text
from flexmb.model.part import Body, Joint, Part

if TYPE_CHECKING:
    from flexmb.model.mechanism import Mechanism

LISTED_PARTS = 12
"""Number of parts at most in a line."""


def mechanism_text(mechanism: Mechanism) -> str:
    """Name, numbers and names of parts, gravity, in three lines."""
    bodies = [part for part in mechanism.parts if isinstance(part, Body)]
    others = [part for part in mechanism.parts if not isinstance(part, Body)]
    lines = [f"Mechanism {mechanism.name!r}: {_numbers(mechanism)}; {_gravity(mechanism)}"]
    lines += [cut(f"  {noun}  {_names(parts)}") for noun, parts in (("bodies", bodies), ("others", others)) if parts]
    return "\n".join(lines)


def mechanism_html(mechanism: Mechanism) -> str:
    """Table of all parts with their classes, connections and given fields."""
    head = ("part", "class", "connects", "given")
    rows = html.table([_row(part) for part in mechanism.parts], head)
    return html.page(f"Mechanism {mechanism.name!r}", f"{_numbers(mechanism)}; {_gravity(mechanism)}", rows)


def _numbers(mechanism: Mechanism) -> str:
    joints = sum(isinstance(part, Joint) for part in mechanism.parts)
    bodies = len(mechanism.bodies)
    rest = len(mechanism.parts) - bodies - joints
    texts = [counted(bodies, "body"), counted(joints, "joint")]
    return ", ".join([*texts, *([counted(rest, "other part")] if rest else [])])


def _gravity(mechanism: Mechanism) -> str:
    gx, gy = mechanism.gravity
    return f"gravity ({number_text(gx)}, {number_text(gy)}) m/s^2" if gx or gy else "no gravity"


def _names(parts: Sequence[Part]) -> str:
    """Names with classes, parts of one class together."""
    kinds: dict[str, list[str]] = {}
    for part in parts[:LISTED_PARTS]:
        kinds.setdefault(type(part).__name__, []).append(part.name)
    shown = ", ".join(f"{listed(names, LISTED_PARTS)} ({kind})" for kind, names in kinds.items())
    return f"{shown} and {len(parts) - LISTED_PARTS} more" if len(parts) > LISTED_PARTS else shown


def _row(part: Part) -> tuple[str, str, str, str]:
    given = given_fields(part)
    rest = {name: value for name, value in given.items() if name != "name" and not isinstance(value, Part)}
    fields = ", ".join(f"{name}={value_text(value, nested=False)}" for name, value in rest.items())
    return part.name, type(part).__name__, ", ".join(part.references()), fields
