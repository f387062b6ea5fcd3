"""Calls that may fail: results or error of a point, in a form that can be sent and stored."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self

ADDRESS = re.compile(r" at 0x[0-9a-fA-F]+")
"""Pattern of an address in memory, which differs from run to run and must not enter a store."""

DONE = "done"
"""Status of a point that succeeded."""


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


def attempted(function: Callable[..., Outcome], *arguments: Any) -> Outcome:
    """Outcome of a function, or of its failure; runs in the workers.

    Parameters
    ----------
    function : function that returns an `Outcome`.
    *arguments : arguments of the function.
    """
    outcome = None
    with Attempt() as attempt:
        outcome = function(*arguments)
    return failure(attempt.error) if outcome is None else outcome


def failure(error: BaseException | None) -> Outcome:
    """Outcome of a point whose function raised `error`: class and message."""
    text = ADDRESS.sub("", " ".join(str(error).split()))
    return Outcome({}, f"{type(error).__name__}: {text}" if text else type(error).__name__, ok=False)
