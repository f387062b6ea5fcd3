"""Jobs on any executor: so many at a time, chains of jobs that wait for one another, and workers that die."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from typing import Any, NamedTuple

from flexmb.errors import InputError, WorkerError
from flexmb.jobs.attempt import Outcome, attempted

PENDING = 256
"""Jobs that are with the executor at the same time: enough for a pool on one machine, and no burden to a scheduler."""


class Job(NamedTuple):
    """A call to be made by a worker; the function returns an `Outcome`."""

    function: Callable[..., Outcome]
    arguments: tuple[Any, ...]


Chain = Generator[Job, Outcome, None]
"""Jobs one after the other: each is yielded when the outcome of the one before has been sent."""


def drive(chains: Iterable[Chain], executor: Executor | None, owner: str, pending: int = PENDING) -> None:
    """Run all chains to their ends; chains keep their results themselves.

    Chains are taken as there is room for them, with at most `pending` jobs with the executor at the same time; without
    an executor they run in this process, one after the other.  A `WorkerError` tells workers that died or cannot be
    reached.
    """
    if executor is None:
        for chain in chains:
            job = next(chain, None)
            while job is not None:
                job = _after(chain, attempted(job.function, *job.arguments))
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
                _submit(executor, _after(chain, _outcome(future, owner)), chain, running, owner)
    finally:
        for future in running:
            future.cancel()


def require_executor(owner: str, executor: Any) -> None:
    """Refuse an object of another kind than an executor of concurrent.futures."""
    if executor is None or isinstance(executor, Executor):
        return
    text = f"{owner}: executor is {type(executor).__name__}; it must be None or an executor of concurrent.futures"
    raise InputError(f"{text}, e.g. ProcessPoolExecutor(2). A Dask client gives one by client.get_executor().")


def require_picklable(owner: str, executor: Executor | None, what: Any, name: str) -> None:
    """Refuse objects that cannot be sent to the processes of the executor, before anything starts.

    Threads need nothing; Dask sends functions by value.
    """
    if executor is None or isinstance(executor, ThreadPoolExecutor):
        return
    if type(executor).__module__.partition(".")[0] == "distributed":
        return
    try:
        pickle.dumps(what)
    except (pickle.PicklingError, AttributeError, TypeError, RecursionError) as error:
        text = f"{owner}: {name} cannot be sent to other processes ({error}). Use a function at the top of a module"
        raise InputError(
            f"{text}, not a lambda and not one inside another function; what it depends on goes into fixed=."
        ) from error


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


def _outcome(future: Future[Outcome], owner: str) -> Outcome:
    """Outcome of a worker's job.  Failures of a point are outcomes, so an exception means that the worker failed."""
    error = None if future.cancelled() else future.exception()
    if isinstance(error, KeyboardInterrupt):
        raise error
    if future.cancelled() or error is not None:
        raise _lost(owner, error) from error
    return future.result()


def _lost(owner: str, error: BaseException | None) -> WorkerError:
    what = "it was cancelled" if error is None else f"{type(error).__name__}: {' '.join(str(error).split())}"
    return WorkerError(
        f"{owner}: a worker was lost ({what.rstrip('.')}). What is finished stands in the store, if one was given: "
        "start workers anew and call it again with resume=True. Workers die when memory runs out, and at once when "
        "they cannot import the function: put it into a module, and what starts workers under "
        "`if __name__ == '__main__':`."
    )
