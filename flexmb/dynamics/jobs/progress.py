"""The one progress bar: of a run, of a sweep, of a study."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Any, Self

COUNTED = "{l_bar}{bar}| {n:.5g}/{total:.5g} %s [{elapsed}<{remaining}{postfix}]"
EVERY = 60.0
"""Time between two lines of progress in a file [s on the clock]."""
WEIGHED = "{desc} {percentage:3.0f}%|{bar}| {elapsed}{postfix}"


class ProgressBar:
    """A bar on stderr, or only its numbers: tqdm takes longer to import than a short run to compute.

    Parameters
    ----------
    name : text before the bar.
    total : number at which it is full.
    done : number at which it begins; it does not count for the time left.
    shown : whether it is drawn.
    of : unit of the numbers.
    form : format of tqdm with a place for the unit.

    Attributes
    ----------
    n : present number.
    failed : points that failed.
    """

    def __init__(
        self, name: str, total: float, *, done: float = 0, shown: bool, of: str = "points", form: str = COUNTED
    ) -> None:
        self.total, self.n, self.failed = total, done, 0
        self.drawn = _drawn(total, done, name, form, of) if shown else None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def update(self, more: float) -> None:
        """Go on by `more`."""
        self.n += more
        if self.drawn is not None:
            self.drawn.update(more)

    def one_more(self, *, ok: bool) -> None:
        """Count a finished point."""
        self.failed += not ok
        if not ok:
            self.say(f"{self.failed} failed", refresh=False)
        self.update(1)

    def say(self, text: str, *, refresh: bool = True) -> None:
        """Show a text behind the bar."""
        if self.drawn is not None:
            self.drawn.set_postfix_str(text, refresh=refresh)

    def close(self) -> None:
        """End the line of the bar."""
        if self.drawn is not None:
            self.drawn.close()


class WorkBar(ProgressBar):
    """A bar over the estimated processor time of jobs.

    The time left is the estimate of the jobs left, times the ratio of clock time to estimate of the finished jobs.

    Parameters
    ----------
    name : text before the bar.
    works : estimated processor time of each job [s].
    workers : number of processes that share the jobs.
    shown : whether the bar is drawn.
    """

    def __init__(self, name: str, works: list[float], workers: int, *, shown: bool) -> None:
        super().__init__(name, sum(works), shown=shown, of="s of work", form=WEIGHED)
        self.name, self.jobs, self.finished, self.workers = name, len(works), 0, workers
        self.estimated, self.taken = 0.0, 0.0
        self._tell()
        if isinstance(self.drawn, Lines):
            self.drawn.write()  # the first job may take minutes

    @property
    def left(self) -> float:
        """Time by the clock until all jobs are finished [s]."""
        ratio = self.taken / self.estimated if self.estimated > 0.0 else 1.0
        return max(self.total - self.n, 0.0) * ratio / self.workers

    def more(self, work: float, wall: float | None, *, whole: bool) -> None:
        """Count a finished job, or a part of one, by its estimated processor time [s] and its time by the clock [s].

        `wall` is None where it was not computed now, or not to its end; `whole`: a job ended with it.
        """
        self.finished += whole
        if wall is not None:
            self.estimated += work
            self.taken += wall
        self.update(min(work, max(self.total - self.n, 0.0)))
        self._tell()

    def _tell(self) -> None:
        self.say(f"{self.finished} of {self.jobs} {self.name}, {clock(self.left)} left")


def clock(seconds: float) -> str:
    """A time [s] in words: "40 s", "3 min", "2 h 5 min"."""
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


class Lines:
    """Progress as whole lines, for a file: one every minute, and one at the end.

    Parameters
    ----------
    total : number at the end.
    initial : number at the begin.
    desc : first words of a line.
    of : unit of the numbers.
    """

    def __init__(self, total: float, initial: float, desc: str, of: str) -> None:
        self.total, self.n, self.desc, self.of = total, initial, desc, of
        self.behind, self.began, self.is_open = "", time.monotonic(), True
        self.told = self.began

    def update(self, more: float) -> None:
        """Go on by `more`, and write a line if it is time."""
        self.n += more
        if time.monotonic() - self.told >= EVERY:
            self.write()

    def set_postfix_str(self, text: str, refresh: bool = True) -> None:  # noqa: ARG002 - written with the next line
        """Text behind the numbers of the next line; `refresh` has no effect."""
        self.behind = text

    def close(self) -> None:
        """Write the last line."""
        if self.is_open:
            self.write()
        self.is_open = False

    def write(self) -> None:
        """Write a line now."""
        self.told = time.monotonic()
        share = 100.0 * self.n / self.total if self.total else 100.0
        numbers = f"{self.n:.5g} of {self.total:.5g} {self.of}, {clock(self.told - self.began)}"
        behind = f", {self.behind}" if self.behind else ""
        print(f"{self.desc}: {share:.0f} %, {numbers}{behind}", file=sys.stderr, flush=True)


def _drawn(total: float, done: float, name: str, form: str, of: str) -> Any:
    """A bar on a terminal, lines elsewhere."""
    if sys.stderr is None or not sys.stderr.isatty():
        return Lines(total, done, name, of)
    from tqdm import tqdm

    return tqdm(total=total, initial=done, desc=name, bar_format=form.replace("%s", of), mininterval=0.1)
