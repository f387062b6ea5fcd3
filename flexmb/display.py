"""Short texts and HTML tables of objects."""

import sys
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import MISSING, Field, fields, is_dataclass
from html import escape
from typing import Any

import numpy as np

from flexmb.fields import unit_of

WIDTH = 110  # largest length of a line
LINES = 3  # largest number of lines of a record
LISTED = 6  # largest number of values of a list that is shown; a longer one is shown by its length
LONGEST_LIST = 60  # largest length of a list that is shown


def number_text(value: float) -> str:
    """A number with 8 digits at most: "0.3" for 0.30000000000000004, "104.71976" for 1000 revolutions a minute."""
    return f"{value:.8g}"


def value_text(value: Any, *, nested: bool = True) -> str:
    """Short text of a field of a record; without `nested`, records in it show their classes alone."""
    if isinstance(value, Inside):
        return value.text_inside(nested=nested)
    if isinstance(value, tuple | list):
        return _list_text([value_text(item, nested=nested) for item in value], "()")
    if isinstance(value, Mapping):
        return _list_text([f"{key}: {value_text(item, nested=nested)}" for key, item in value.items()], "{}")
    if is_dataclass(value) and not isinstance(value, type) and not nested:
        return f"{type(value).__name__}(...)"
    if isinstance(value, np.ndarray):
        return f"array of shape {value.shape}"
    is_float = isinstance(value, float | np.floating)
    return number_text(float(value)) if is_float else str(getattr(value, "__name__", None) or repr(value))


class Inside:
    """Base of records whose text inside of another record differs from their own."""

    def text_inside(self, *, nested: bool) -> str:
        """Text of the record as a field of another one; `nested`: whether its fields are shown."""
        return " ".join(repr(self).split()) if nested else f"{type(self).__name__}(...)"


def _list_text(texts: Sequence[str], ends: str) -> str:
    """Texts with commas between brackets; their number where they are too many or too long."""
    text = f"{ends[0]}{', '.join(texts)}{',' if len(texts) == 1 and ends == '()' else ''}{ends[1]}"
    return text if len(texts) <= LISTED and len(text) <= LONGEST_LIST else f"({len(texts)} values)"


def given_fields(record: Any) -> dict[str, Any]:
    """Fields of a record that differ from their defaults, by name; without hidden ones."""
    shown = (field for field in fields(record) if field.repr and field.init)
    values = {field.name: (field, getattr(record, field.name)) for field in shown}
    return {name: value for name, (field, value) in values.items() if not _is_default(field, value)}


def _is_default(field: Field[Any], value: Any) -> bool:
    default = field.default if field.default_factory is MISSING else field.default_factory()
    if default is MISSING or value is default:
        return default is not MISSING
    arrays = isinstance(value, np.ndarray) or isinstance(default, np.ndarray)
    return bool(np.array_equal(value, default) if arrays else value == default)


def record_text(record: Any) -> str:
    """Class, name and fields of a dataclass `record` that differ from their defaults, in three lines at most."""
    given, text = given_fields(record), ""
    for nested in (True, False):
        texts = {name: value_text(value, nested=nested) for name, value in given.items()}
        entries = [one if name == "name" else f"{name}={one}" for name, one in texts.items()]
        text = f"{type(record).__name__}({', '.join(entries)})"
        if len(wrapped := cut(text, 2 * LINES, indent="    ").splitlines()) <= LINES:
            return "\n".join(wrapped)
    return cut(text, LINES, indent="    ")


def cut(text: str, lines: int = 1, indent: str = "  ") -> str:
    """A text wrapped to lines of 110 characters, the last of which ends with "..." where there is more."""
    # `indent` are the first characters of all lines but the first one.
    how: Any = {"max_lines": lines, "placeholder": " ...", "break_on_hyphens": False}
    return "\n".join(textwrap.wrap(text, WIDTH, subsequent_indent=indent, **how))


def listed(names: Iterable[str], most: int = 10) -> str:
    """Names with commas; the first ones alone, and the number of the others, where there are more than `most`."""
    known = list(names)
    more = f" and {len(known) - most} more" if len(known) > most else ""
    return ", ".join(known[:most]) + more


def quoted(names: Iterable[str], most: int = 8) -> str:
    """Names in quotes, with commas; as of `listed` where there are more than `most`."""
    return listed(map(repr, names), most)


def counted(number: int, noun: str) -> str:
    """A number with its noun: "1 joint", "2 joints", "3 bodies"."""
    plural = f"{noun[:-1]}ies" if noun.endswith("y") else f"{noun}s"
    return f"{number} {noun if number == 1 else plural}"


def pretty(unit: str) -> str:
    """A unit with raised exponents: "m/s^2" becomes "m/s²"."""
    return unit.replace("^2", "²").replace("s2", "s²").replace("m2", "m²").replace("m^3", "m³")


# Notebooks: HTML of objects, as small tables, escaped, without colours of their own


def in_notebook() -> bool:
    """Whether this program is the kernel of a notebook."""
    ipython, marimo = sys.modules.get("IPython"), sys.modules.get("marimo")
    if ipython is not None and "ipykernel" in sys.modules and ipython.get_ipython() is not None:
        return True
    return marimo is not None and bool(marimo.running_in_notebook())


# Styles; lines and texts have the colour of the page, so they suit light and dark ones.
CELL = "text-align: left; padding: 0.1em 0.8em 0.1em 0"
SHORT = f"{CELL}; white-space: nowrap"
TABLE = "border-collapse: collapse; color: inherit"
SHORT_TEXT = 24  # length of a text that is not wrapped
MOST_ROWS = 60  # largest number of rows of a table


def page(title: str, subtitle: str = "", *blocks: str) -> str:
    """HTML of an object: plain texts as title and subtitle, below them HTML from `table`, `texts` and `folded`."""
    head = f"<div><b>{escape(title)}</b>"
    if subtitle:
        head += f' <span style="opacity: 0.7">{escape(subtitle)}</span>'
    return f"{head}</div>{''.join(blocks)}"


def table(rows: Iterable[Sequence[object]], head: Sequence[str] = ()) -> str:
    """HTML of a table; empty without rows."""
    cells = [[escape(str(cell)) for cell in row] for row in rows]
    if not cells:
        return ""
    more, lines = len(cells) - MOST_ROWS, [_row("td", row) for row in cells[:MOST_ROWS]]
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


class Shown(Inside):
    """Base of frozen records: `repr` shows the fields that differ from their defaults, notebooks a table with units."""

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        if "__repr__" not in vars(cls):
            cls.__repr__ = record_text  # type: ignore[method-assign] # the decorator `dataclass` would make one

    def _repr_html_(self) -> str:
        """HTML for notebooks."""
        given = given_fields(self)
        name = given.pop("name", None)
        rows = [(field, value_text(value), unit_of(type(self), field)) for field, value in given.items()]
        return page(type(self).__name__, "" if name is None else str(name), table(rows))
