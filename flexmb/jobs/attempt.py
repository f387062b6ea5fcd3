"""Calls that may fail: results or error of a point, in a form that can be sent and stored."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from contextvars import ContextVar
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self

ADDRESS = re.compile(r" at 0x[0-9a-fA-F]+")
"""Pattern of an address in memory, which differs from run to run and must not enter a store."""

DONE = "done"
"""Status of a point that succeeded."""

_STOPPED: ContextVar[list[str] | None] = ContextVar("stopped runs of the present job", default=None)


@dataclass(frozen=True)
class Outcome:
    """Result of one point.

    Parameters
    ----------
    values : results by name; {} after a failure.
    status : end of the computation, in a sentence; never "".
    ok : whether the point succeeded.
    """

    values: Mapping[str, Any]
    status: str = DONE
    ok: bool = True


class Attempt:
    """A block whose exception is kept and not raised, because a failed point must not end a sweep.

    KeyboardInterrupt (Ctrl-C) is raised.  A call of `sys.exit` in a user's function counts as a failure.

    Attributes
    ----------
    error : the exception, or None.
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


def is_in_job() -> bool:
    """Presence of a job around the caller; Ctrl-C ends the whole job then, and not only a run in it."""
    return _STOPPED.get() is not None


def tell_stopped(run: str, status: str) -> None:
    """Note the name and status of a run that did not reach its end, for the job around it."""
    if (runs := _STOPPED.get()) is not None:
        runs.append(f"{run}: {ADDRESS.sub('', status)}")


def stopped_runs() -> str:
    """The first run of the present job that did not reach its end, and the number of others; "" if all did."""
    runs = _STOPPED.get() or []
    others = f" (and {len(runs) - 1} more)" if len(runs) > 1 else ""
    return f"A run did not reach its end{others}: {runs[0]}" if runs else ""


def attempted(function: Callable[..., Outcome], *arguments: Any) -> Outcome:
    """Outcome of a function, or of its failure; runs in the workers.

    Runs that do not reach their ends are noted during the call, see `stopped_runs`.
    """
    outcome, noted = None, _STOPPED.set([])
    try:
        with Attempt() as attempt:
            outcome = function(*arguments)
    finally:
        _STOPPED.reset(noted)
    return failure(attempt.error) if outcome is None else outcome


def failure(error: BaseException | None) -> Outcome:
    """Outcome of a point whose function raised `error`: class and message."""
    text = ADDRESS.sub("", " ".join(str(error).split()))
    return Outcome({}, f"{type(error).__name__}: {text}" if text else type(error).__name__, ok=False)
