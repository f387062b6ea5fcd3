"""Tables and paragraphs in Markdown."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence


def table(head: Sequence[str], rows: Sequence[Sequence[str]], left: int = 1) -> str:
    """Table in Markdown; the first columns are aligned left, the other columns right.

    Parameters
    ----------
    head : heads of the columns.
    rows : texts of the cells, row by row; vertical bars are escaped.
    left : number of columns aligned left.
    """
    rule = "|" + "---|" * left + "---:|" * (len(head) - left)
    lines = ["| " + " | ".join(text.replace("|", "\\|") for text in row) + " |" for row in (head, *rows)]
    return "\n".join([lines[0], rule, *lines[1:]])


def paragraph(text: str) -> str:
    """Paragraph in lines of at most 120 characters."""
    return textwrap.fill(" ".join(text.split()), 120, break_on_hyphens=False, break_long_words=False)
