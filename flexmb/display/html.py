"""HTML of objects for notebooks: small tables, escaped, without colours of their own."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

CELL = "text-align: left; padding: 0.1em 0.8em 0.1em 0"
SHORT = f"{CELL}; white-space: nowrap"
TABLE = "border-collapse: collapse; color: inherit"
FAINT = "opacity: 0.7"
"""Styles; lines and texts have the colour of the page, so they suit light and dark ones."""

SHORT_TEXT = 24
"""Length of a text that is not wrapped."""

MOST_ROWS = 60
"""Largest number of rows of a table."""


def page(title: str, subtitle: str = "", *blocks: str) -> str:
    """HTML of an object: plain texts as title and subtitle, below them HTML from `table`, `texts` and `folded`."""
    head = f"<div><b>{escape(title)}</b>"
    if subtitle:
        head += f' <span style="{FAINT}">{escape(subtitle)}</span>'
    return f"{head}</div>{''.join(blocks)}"


def table(rows: Iterable[Sequence[object]], head: Sequence[str] = ()) -> str:
    """HTML of a table; empty without rows."""
    cells = [[escape(str(cell)) for cell in row] for row in rows]
    if not cells:
        return ""
    more = len(cells) - MOST_ROWS
    lines = [_row("td", row) for row in cells[:MOST_ROWS]]
    if more > 0:
        lines.append(_row("td", [f"... {more} more"]))
    top = f"<thead>{_row('th', [escape(text) for text in head])}</thead>" if head else ""
    return f'<table style="{TABLE}">{top}<tbody>{"".join(lines)}</tbody></table>'


def _row(kind: str, cells: Sequence[str]) -> str:
    styles = (SHORT if len(cell) <= SHORT_TEXT else CELL for cell in cells)
    shown = (f'<{kind} style="{style}">{cell}</{kind}>' for style, cell in zip(styles, cells, strict=True))
    return f"<tr>{''.join(shown)}</tr>"


def texts(lines: Iterable[str]) -> str:
    """HTML of plain sentences, each as an entry of a list; empty without any."""
    entries = "".join(f"<li>{escape(line)}</li>" for line in lines)
    return f"<ul>{entries}</ul>" if entries else ""


def folded(summary: str, content: str) -> str:
    """HTML of a block that opens on a click; empty without content."""
    return f"<details><summary>{escape(summary)}</summary>{content}</details>" if content else ""
