"""Tables as Markdown."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence


def table(head: Sequence[str], rows: Sequence[Sequence[str]], left: int = 1) -> str:
    """A table; the first columns are flush left, the others flush right.

    Parameters
    ----------
    head : of the columns.
    rows : their texts; a bar in one is written so that it does not end the cell.
    left : so many columns are flush left.
    """
    rule = "|" + "---|" * left + "---:|" * (len(head) - left)
    lines = ["| " + " | ".join(text.replace("|", "\\|") for text in row) + " |" for row in (head, *rows)]
    return "\n".join([lines[0], rule, *lines[1:]])


def paragraph(text: str) -> str:
    """One paragraph, as wide as the pages."""
    return textwrap.fill(" ".join(text.split()), 120, break_on_hyphens=False, break_long_words=False)
