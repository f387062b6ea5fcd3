"""The one progress bar: of a run, of a sweep, of a study."""

import sys
import time
from typing import Any, Self

COUNTED = "{l_bar}{bar}| {n:.5g}/{total:.5g} %s [{elapsed}<{remaining}{postfix}]"
EVERY = 60.0  # time between two lines of progress in a file [s on the clock]


class ProgressBar:
    """A bar on a terminal, lines in a file: one every minute and one at the end; or only its numbers."""

    # It begins at `done`, which does not count for the time left; `of`: unit of the numbers; `form`: format of tqdm
    # with a place for the unit; `n`: present number.

    def __init__(
        self, name: str, total: float, *, done: float = 0, shown: bool, of: str = "points", form: str = COUNTED
    ) -> None:
        self.name, self.total, self.n, self.of, self.shown = name, total, done, of, shown
        self.failed, self.behind = 0, ""
        self.bar: Any = None
        self.told = self.began = time.monotonic()
        if shown and sys.stderr is not None and sys.stderr.isatty():
            from tqdm import tqdm  # takes longer to import than a short run to compute

            self.bar = tqdm(total=total, initial=done, desc=name, bar_format=form.replace("%s", of), mininterval=0.1)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def update(self, more: float) -> None:
        """Go on by `more`."""
        self.n += more
        if self.bar is not None:
            self.bar.update(more)
        elif self.shown and time.monotonic() - self.told >= EVERY:
            self.write()

    def one_more(self, *, ok: bool) -> None:
        """Count a finished point."""
        self.failed += not ok
        if not ok:
            self.say(f"{self.failed} failed", refresh=False)
        self.update(1)

    def say(self, text: str, *, refresh: bool = True) -> None:
        """Show a text behind the bar, or behind the numbers of the next line."""
        self.behind = text
        if self.bar is not None:
            self.bar.set_postfix_str(text, refresh=refresh)

    def close(self) -> None:
        """End the line of the bar, or write the last line."""
        if self.bar is not None:
            self.bar.close()
        elif self.shown:
            self.write()
        self.shown = False

    def write(self) -> None:
        """Write a line now."""
        self.told = time.monotonic()
        share = 100.0 * self.n / self.total if self.total else 100.0
        numbers = f"{self.n:.5g} of {self.total:.5g} {self.of}, {clock(self.told - self.began)}"
        behind = f", {self.behind}" if self.behind else ""
        print(f"{self.name}: {share:.0f} %, {numbers}{behind}", file=sys.stderr, flush=True)


def clock(seconds: float) -> str:
    """A time [s] in words: "40 s", "3 min", "2 h 5 min"."""
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"
