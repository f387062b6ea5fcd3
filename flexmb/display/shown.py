"""Records that show themselves by the fields that were given."""

from __future__ import annotations

from typing import Any

from flexmb.display import html
from flexmb.display.text import Inside, given_fields, record_text, value_text
from flexmb.docstrings import parameters, units


class Shown(Inside):
    """Base of frozen records: `repr` shows the fields that differ from their defaults, notebooks a table with units."""

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        if "__repr__" not in vars(cls):
            cls.__repr__ = record_text  # type: ignore[method-assign] # the decorator `dataclass` would make one

    def _repr_html_(self) -> str:
        """HTML for notebooks."""
        described, given = parameters(type(self)), given_fields(self)
        name = given.pop("name", None)
        rows = [(field, value_text(value), _unit(described.get(field, ""))) for field, value in given.items()]
        return html.page(type(self).__name__, "" if name is None else str(name), html.table(rows))


def _unit(text: str) -> str:
    return next(iter(units(text)), "")
