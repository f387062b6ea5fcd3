"""Sections of docs/measured.md: each module computes numbers, and writes its passage from them."""

from collections.abc import Iterable, Sequence


def table(head: Sequence[str], rows: Iterable[Sequence[str]], left: int = 1) -> str:
    """A table whose first columns are aligned on the left."""
    rule = ["---" if k < left else "---:" for k in range(len(head))]
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, rule, *rows])


def compared(name: str, known: float, found: float, digits: int = 8) -> list[str]:
    """Cells of a row: quantity, known value, ours, relative error."""
    return [name, f"{known:.{digits}g}", f"{found:.{digits}g}", f"{found / known - 1.0:.1e}"]
