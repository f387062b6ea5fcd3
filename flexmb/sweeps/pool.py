"""A pool of worker processes of this machine."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from typing import Any

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
"""Variables that keep the linear algebra of a worker from taking the cores of the others."""


@contextmanager
def worker_pool(count: int, prepare: Callable[..., Any], *arguments: Any) -> Iterator[ProcessPoolExecutor]:
    """`count` fresh processes, each with one thread of linear algebra, which die at once when Ctrl-C is typed.

    They are started anew, not forked: a fork takes over locks of threads that it does not have.  A process costs some
    two seconds, for imports and for compiled code from the cache, and all of them start side by side.

    Parameters
    ----------
    count : number of processes.
    prepare : called with `arguments` in each process before its first job; it can be sent to other processes.
    """
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    try:
        with ProcessPoolExecutor(
            count, mp_context=get_context("spawn"), initializer=_begin, initargs=(prepare, arguments)
        ) as pool:
            yield pool
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _begin(prepare: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    signal.signal(signal.SIGINT, _leave)
    prepare(*arguments)


def _leave(number: int, frame: Any) -> None:
    os._exit(130)
