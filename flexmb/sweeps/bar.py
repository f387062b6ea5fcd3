"""The progress of a sweep: points finished, points that failed, the time left."""

from __future__ import annotations

from types import TracebackType
from typing import Any, Self


class Bar:
    """A bar over points, on stderr, or nothing.

    Parameters
    ----------
    name : what stands before it.
    total : number of points.
    done : how many are finished already; they do not count for the time left.
    shown : whether it is shown.
    """

    def __init__(self, name: str, total: int, done: int, *, shown: bool) -> None:
        self.failed, self.bar = 0, _tqdm(name, total, done) if shown else None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.bar is not None:
            self.bar.close()

    def one_more(self, *, ok: bool) -> None:
        """A point is finished."""
        if self.bar is None:
            return
        if not ok:
            self.failed += 1
            self.bar.set_postfix_str(f"{self.failed} failed", refresh=False)
        self.bar.update(1)


def _tqdm(name: str, total: int, done: int) -> Any:
    from tqdm import tqdm

    form = "{l_bar}{bar}| {n}/{total} points [{elapsed}<{remaining}{postfix}]"
    return tqdm(total=total, initial=done, bar_format=form, desc=name)
