"""One call that may fail: what it returned, or what went wrong, in a form that can be sent and stored."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self

ADDRESS = re.compile(r" at 0x[0-9a-fA-F]+")
"""Where an object lies in memory: it differs from run to run, and a store must not."""

DONE = "done"


@dataclass(frozen=True)
class Outcome:
    """What came of one point.

    Parameters
    ----------
    values : what was returned, {} where it failed.
    status : how it ended, in a sentence; never "".
    ok : whether it went well.
    """

    values: Mapping[str, Any]
    status: str = DONE
    ok: bool = True


class Attempt:
    """A block whose exception is remembered, not raised: a point that fails must not end the sweep of others.

    What asks the process to stop (Ctrl-C) goes on; a call of `sys.exit` in a user's function is a failure like others.

    Attributes
    ----------
    error : what was raised, or None.
    """

    def __init__(self) -> None:
        self.error: BaseException | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool:
        caught = kind is not None and issubclass(kind, (Exception, SystemExit))
        self.error = error if caught else None
        return caught


def attempted(function: Callable[..., Outcome], *arguments: Any) -> Outcome:
    """The outcome that `function` returns, or that of its failure.  Runs in the workers."""
    found = None
    with Attempt() as attempt:
        found = function(*arguments)
    return failure(attempt.error) if found is None else found


def failure(error: BaseException | None) -> Outcome:
    """The outcome of a point that raised `error`: class and message."""
    text = ADDRESS.sub("", " ".join(str(error).split()))
    return Outcome({}, f"{type(error).__name__}: {text}" if text else type(error).__name__, ok=False)
