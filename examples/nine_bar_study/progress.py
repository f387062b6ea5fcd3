"""Progress of the jobs of a study by their estimated work, and logs of their times that survive a kill."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from flexmb.dynamics.jobs.progress import ProgressBar, clock

WEIGHED = "{desc} {percentage:3.0f}%|{bar}| {elapsed}{postfix}"


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
        self.jobs, self.finished, self.workers = len(works), 0, workers
        self.estimated, self.taken = 0.0, 0.0
        self._tell()
        if shown and self.bar is None:
            self.write()  # the first job may take minutes

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


def append_line(path: Path, **values: Any) -> None:
    """Add a line of named numbers to a log; a line is written at once."""
    line = json.dumps(values) + "\n"
    with path.open("a+b") as log:
        if log.seek(0, os.SEEK_END):
            log.seek(-1, os.SEEK_END)
            if log.read() != b"\n":
                line = "\n" + line  # a line that a kill cut short must not swallow this one
        log.write(line.encode())


def lines_of(path: Path) -> list[dict[str, Any]]:
    """The lines of a log, none where there is no log; lines that a kill cut short are left out."""
    found = []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines() if path.is_file() else []:
        try:
            entry = json.loads(line)
        except json.JSONDecodeError:
            continue
        if isinstance(entry, dict):
            found.append(entry)
    return found
