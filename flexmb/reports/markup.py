"""HTML whose texts are escaped when it is made."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from math import isfinite


class Markup(str):
    """Text that is HTML already; any other text is escaped where it enters."""

    __slots__ = ()


Content = str | None
"""Piece of a page: markup, plain text, or None for nothing."""

VOID = frozenset({"input", "meta", "br"})
"""Elements without content."""


def tag(name: str, *content: Content, **attributes: str | bool | None) -> Markup:
    """An element with pieces inside it, of which plain text is escaped, and attributes by name.

    "_" stands for "-", and a "_" at the end is left out.  None and False: no such attribute, True: an attribute without
    a value.
    """
    written = ""
    for key, value in attributes.items():
        if value is None or value is False:
            continue
        word = key.rstrip("_").replace("_", "-")
        written += f" {word}" if value is True else f' {word}="{html.escape(value)}"'
    if name in VOID:
        return Markup(f"<{name}{written}>")
    return Markup(f"<{name}{written}>{joined(content)}</{name}>")


def joined(content: Iterable[Content]) -> Markup:
    """Pieces one after the other; plain text is escaped."""
    return Markup("".join(x if isinstance(x, Markup) else html.escape(x) for x in content if x is not None))


def section(title: str, *content: Content, anchor: str) -> Markup:
    """A section with a heading and an anchor for links."""
    heading = tag("h2", title, id=f"{anchor}-title")
    return tag("section", heading, *content, id=anchor, aria_labelledby=f"{anchor}-title")


def table(
    caption: str, heads: Sequence[str], rows: Iterable[Sequence[Content]], *, numbers: Sequence[int] = ()
) -> Markup:
    """A table with a caption, in a box that scrolls sideways where the page is narrow.

    The first cell of a row is its head; `numbers` are places of the columns with numbers.
    """
    classes = ["number" if k in numbers else None for k in range(len(heads))]
    head = tag("tr", *(tag("th", text, scope="col", class_=c) for text, c in zip(heads, classes, strict=True)))
    body = []
    for row in rows:
        first, *rest = row
        cells = [tag("td", cell, class_=c) for cell, c in zip(rest, classes[1:], strict=True)]
        body.append(tag("tr", tag("th", first, scope="row"), *cells))
    made = tag("table", tag("caption", caption), tag("thead", head), tag("tbody", *body))
    return tag("div", made, class_="scroll", role="region", tabindex="0", aria_label=caption)


def facts(rows: Iterable[tuple[str, Content]]) -> Markup:
    """Names with their values."""
    return tag("dl", *(tag("div", tag("dt", name), tag("dd", value)) for name, value in rows), class_="facts")


def number(value: float, digits: int = 6) -> str:
    """A number with so many significant digits; "-" for one that is not finite."""
    return f"{value:.{digits}g}" if isfinite(value) else "-"


def quantity(value: float, unit: str = "", digits: int = 6) -> str:
    """A number with its unit."""
    return f"{number(value, digits)} {pretty(unit)}".rstrip()


def pretty(unit: str) -> str:
    """A unit with raised exponents: "m/s^2" becomes "m/s²"."""
    return unit.replace("^2", "²").replace("s2", "s²").replace("m2", "m²").replace("m^3", "m³")
