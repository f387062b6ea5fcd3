"""The one pool of worker processes of this machine."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
"""Variables that keep the linear algebra of a worker from taking the cores of the others."""


@contextmanager
def worker_pool(count: int, prepare: Callable[..., Any], *arguments: Any) -> Iterator[ProcessPoolExecutor]:
    """`count` fresh processes, each with one thread of linear algebra.

    Ctrl-C ends the workers at once, and so does the end of the process that started them.  They are started anew, not
    forked: a fork takes over locks of threads that it does not have.  A process costs some two seconds, for imports and
    for compiled code from the cache, and all of them start side by side.  `prepare` can be sent to other processes;
    each calls it with the arguments before its first job.
    """
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    fresh = multiprocessing.get_context("spawn")
    try:
        with ProcessPoolExecutor(count, mp_context=fresh, initializer=_begin, initargs=(prepare, arguments)) as pool:
            try:
                yield pool
            except KeyboardInterrupt:
                for child in multiprocessing.active_children():
                    child.terminate()  # or the end of the pool would wait for their jobs
                raise
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def cores() -> int:
    """Number of processor cores that this process may use."""
    allowed = getattr(os, "sched_getaffinity", None)  # not on every system
    return len(allowed(0)) if allowed is not None else os.cpu_count() or 1


def _begin(prepare: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    signal.signal(signal.SIGINT, _leave)
    threading.Thread(target=_leave_with_parent, daemon=True).start()
    prepare(*arguments)


def _leave(number: int, frame: Any) -> None:
    os._exit(130)


def _leave_with_parent() -> None:
    """End this process with its parent: a worker of a killed parent would wait for its next job for ever."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
