"""Progress bar of a run, and its silent substitute."""

from __future__ import annotations

from typing import Any


class NoBar:
    """Silent substitute of a progress bar, since tqdm takes long to import and to set up.

    Parameters
    ----------
    total : end of the bar [s].
    """

    def __init__(self, total: float) -> None:
        self.total, self.n = total, 0.0

    def update(self, more: float) -> None:
        """Go on by `more` [s]."""
        self.n += more

    def close(self) -> None:
        """Nothing to close."""


def bar(name: str, begin: float, end: float, *, shown: bool, of: str = "s of motion") -> Any:
    """Progress bar over the time from `begin` to `end` [s] of the mechanism `name`; `of`: unit of the bar."""
    if not shown:
        return NoBar(end)
    from tqdm import tqdm

    form = "{l_bar}{bar}| {n:.4g}/{total:.4g} " + of + " [{elapsed}<{remaining}]"
    return tqdm(total=end, initial=begin, bar_format=form, desc=name)
