"""Jobs on any executor: calls that may fail, chains that wait for one another, threads and worker processes."""

import pickle
import re
import threading
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from numbers import Integral
from typing import Any, NamedTuple, Self

from flexmb import checks
from flexmb.errors import InputError, WorkerError

# Pattern of an address in memory, which differs from run to run and must not enter a store.
ADDRESS = re.compile(r" at 0x[0-9a-fA-F]+")
DONE = "done"  # status of a point that succeeded
_STOPPED: ContextVar[list[str] | None] = ContextVar("stopped runs of the present job", default=None)
_ENDED: ContextVar[threading.Event | None] = ContextVar("event that ends the jobs of this thread", default=None)


@dataclass(frozen=True)
class Outcome:
    """Result of one point."""

    values: Mapping[str, Any]  # results by name; {} after a failure
    status: str = DONE  # end of the computation, in a sentence; never ""
    ok: bool = True  # whether the point succeeded


class Attempt:
    """A block whose exception is kept (`error`) and not raised, because a failed point must not end a sweep."""

    # KeyboardInterrupt (Ctrl-C) is raised. A call of `sys.exit` in a user's function counts as a failure.

    def __init__(self) -> None:
        self.error: BaseException | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: Any, error: BaseException | None, trace: Any) -> bool:
        caught = kind is not None and issubclass(kind, (Exception, SystemExit))
        self.error = error if caught else None
        return caught


def is_in_job() -> bool:
    """Presence of a job around the caller; Ctrl-C ends the whole job then, and not only a run in it."""
    return _STOPPED.get() is not None


def is_ended() -> bool:
    """End of the jobs of this thread: its results are no longer waited for."""
    ended = _ENDED.get()
    return ended is not None and ended.is_set()


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
    """Outcome of a function, or of its failure; runs in the workers."""
    # Runs that do not reach their ends are noted during the call, see `stopped_runs`.
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


@contextmanager
def threads(count: int) -> Iterator[ThreadPoolExecutor]:
    """`count` threads: compiled steps hold no lock of Python, so runs are side by side."""
    # Ctrl-C, as any error, ends the runs of all threads after their present block of steps.
    ended = threading.Event()
    with ThreadPoolExecutor(count, "flexmb", _ENDED.set, (ended,)) as pool:
        try:
            yield pool
        finally:
            ended.set()


# Jobs on any executor: so many at a time, chains of jobs that wait for one another, and workers that die

# Jobs that are with the executor at the same time: enough for a pool on one machine, and no burden to a scheduler.
PENDING = 256


class Job(NamedTuple):
    """A call to be made by a worker; the function returns an `Outcome`."""

    function: Callable[..., Outcome]
    arguments: tuple[Any, ...]


# Jobs one after the other: each is yielded when the outcome of the one before has been sent.
Chain = Generator[Job, Outcome, None]


def drive(chains: Iterable[Chain], executor: Executor | int | None, owner: str, pending: int = PENDING) -> None:
    """Run all chains to their ends; chains keep their results themselves."""
    # Chains are taken as there is room for them, with at most `pending` jobs with the executor at the same time; a
    # number is one of threads; without an executor they run in this process, one after the other. A `WorkerError` tells
    # workers that died or cannot be reached.
    if executor is None:
        for chain in chains:
            job = next(chain, None)
            while job is not None:
                job = _after(chain, attempted(job.function, *job.arguments))
        return
    if not isinstance(executor, Executor):
        with threads(int(executor)) as pool:
            drive(chains, pool, owner, pending)
        return
    ahead, running = iter(chains), dict[Future[Outcome], Chain]()
    try:
        while True:
            while len(running) < pending and (following := next(ahead, None)) is not None:
                _submit(executor, next(following, None), following, running, owner)
            if not running:
                return
            finished, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in sorted(finished, key=_is_lost):  # what was found is kept before what was lost is told
                chain = running.pop(future)
                if _is_lost(future):  # failures of a point are outcomes, so the worker failed
                    error = None if future.cancelled() else future.exception()
                    if isinstance(error, KeyboardInterrupt):
                        raise error
                    raise _lost(owner, error) from error
                _submit(executor, _after(chain, future.result()), chain, running, owner)
    finally:
        for future in running:
            future.cancel()


def require_executor(owner: str, executor: Any) -> None:
    """Refuse an object of another kind than a number of threads or an executor of concurrent.futures."""
    if executor is None or isinstance(executor, Executor):
        return
    if isinstance(executor, Integral) and not isinstance(executor, bool):
        checks.count(owner, "executor (a number of threads)", executor)
        return
    text = f"{owner}: executor is {type(executor).__name__}; it must be None, a number of threads or an executor of "
    text += "concurrent.futures, e.g. ProcessPoolExecutor(2)"
    raise InputError(f"{text}. A Dask client gives one by client.get_executor().")


def require_picklable(owner: str, executor: Executor | int | None, what: Any, name: str) -> None:
    """Refuse objects that cannot be sent to the processes of the executor, before anything starts."""
    # Threads need nothing; Dask sends functions by value.
    is_dask = type(executor).__module__.partition(".")[0] == "distributed"
    if executor is None or is_dask or isinstance(executor, Integral | ThreadPoolExecutor):
        return
    try:
        pickle.dumps(what)
    except (pickle.PicklingError, AttributeError, TypeError, RecursionError) as error:
        text = f"{owner}: {name} cannot be sent to other processes ({error}). Use a function at the top of a module,"
        text += " not a lambda and not one inside another function"
        raise InputError(f"{text}; what it depends on goes into fixed=.") from error


def _after(chain: Chain, outcome: Outcome) -> Job | None:
    """The next job of a chain, None at its end."""
    try:
        return chain.send(outcome)
    except StopIteration:
        return None


def _submit(
    executor: Executor, job: Job | None, chain: Chain, running: dict[Future[Outcome], Chain], owner: str
) -> None:
    if job is None:
        return
    try:
        running[executor.submit(attempted, job.function, *job.arguments)] = chain
    except RuntimeError as error:  # a broken pool, or one that was shut down
        raise _lost(owner, error) from error


def _is_lost(future: Future[Outcome]) -> bool:
    return future.cancelled() or future.exception() is not None


def _lost(owner: str, error: BaseException | None) -> WorkerError:
    what = "it was cancelled" if error is None else f"{type(error).__name__}: {' '.join(str(error).split())}"
    text = f"{owner}: a worker was lost ({what.rstrip('.')}). What is finished stands in the store, if one was given:"
    text += " start workers anew and call it again with resume=True. Workers die when memory runs out, and at once when"
    text += " they cannot import the function: put it into a module, and what starts workers under"
    return WorkerError(f"{text} `if __name__ == '__main__':`.")
