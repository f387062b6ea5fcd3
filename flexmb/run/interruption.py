"""Signals that end a run: they wait until a block of steps is finished, so that no saved instant is lost or doubled."""

from __future__ import annotations

import signal
from collections.abc import Sequence
from types import FrameType, TracebackType
from typing import Any, Self

KEYBOARD, TERMINATION = signal.SIGINT, signal.SIGTERM


class Interruption:
    """A context in which signals, given by their numbers, are only noted; the second one of a kind acts at once.

    Outside the main thread of Python, signals act as ever.
    """

    def __init__(self, signals: Sequence[signal.Signals]) -> None:
        self.signals = signals
        self.before: dict[signal.Signals, Any] = {}
        self.asked: int | None = None

    def __enter__(self) -> Self:
        try:
            self.before = {number: signal.signal(number, self._note) for number in self.signals}
        except ValueError:  # not in the main thread
            self.before = {}
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        for number, handler in self.before.items():
            signal.signal(number, handler)
        if kind is None:
            self.act()  # a signal that came after the last block

    def _note(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002 - given by the system
        if self.asked == number:
            raise KeyboardInterrupt
        self.asked = number

    def act(self) -> None:
        """Raise `KeyboardInterrupt` if a signal came, with a text on a signal that is not of the keyboard."""
        number, self.asked = self.asked, None
        if number is not None:
            raise KeyboardInterrupt("" if number == KEYBOARD else f"Ended by {signal.Signals(number).name}")
