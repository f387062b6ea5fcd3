"""The progress of `flexmb paper`: processor time that is done, runs, the time left."""

from __future__ import annotations

from collections.abc import Sequence
from types import TracebackType
from typing import Any, Self

from flexmb.paper.plate import Run


class Progress:
    """A bar over the estimated processor time of all runs, on stderr, or nothing.

    The time left is the estimate of what is left, times what finished runs took by the clock over their estimates.

    Parameters
    ----------
    runs : what is to be computed.
    workers : processes that share it.
    shown : whether it is shown.
    """

    def __init__(self, runs: Sequence[Run], workers: int, *, shown: bool) -> None:
        self.total, self.done = sum(run.work for run in runs), 0.0
        self.runs, self.finished, self.workers = len(runs), 0, workers
        self.estimated, self.taken = 0.0, 0.0
        self.bar = _tqdm(self.total) if shown else None
        self._show()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.bar is not None:
            self.bar.close()

    @property
    def left(self) -> float:
        """Time by the clock until all is done [s]."""
        ratio = self.taken / self.estimated if self.estimated > 0.0 else 1.0
        return max(self.total - self.done, 0.0) * ratio / self.workers

    def more(self, work: float, wall: float | None, *, whole: bool) -> None:
        """A run or a part of one is finished.

        Parameters
        ----------
        work : its estimated processor time [s].
        wall : what it took by the clock in its process [s]; None: it was not computed now, or not to its end.
        whole : whether a run ended with it.
        """
        self.done += work
        self.finished += whole
        if wall is not None:
            self.estimated += work
            self.taken += wall
        if self.bar is not None:
            self.bar.update(max(min(work, self.total - self.bar.n), 0.0))
            self._show()

    def _show(self) -> None:
        if self.bar is not None:
            self.bar.set_postfix_str(f"{self.finished} of {self.runs} runs, {clock(self.left)} left", refresh=True)


def clock(seconds: float) -> str:
    """A time as it is said: "40 s", "3 min", "2 h 5 min".

    Parameters
    ----------
    seconds : the time [s].
    """
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


def _tqdm(total: float) -> Any:
    from tqdm import tqdm  # noqa: PLC0415 - only when shown

    return tqdm(total=total, bar_format="runs {percentage:3.0f}%|{bar}| {elapsed}{postfix}", mininterval=0.5)
