"""Computation of the runs of a study on worker processes, longest run first; every finished result is saved."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager, nullcontext
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from nine_bar_study.case import Case
from nine_bar_study.progress import WorkBar, append_line, lines_of
from nine_bar_study.run import StudyRun
from nine_bar_study.store import Cost, Kept, keep
from nine_bar_study.study import OWNER

from flexmb.dynamics.jobs.executors import PENDING, Attempt, Chain, Job, Outcome, drive, failure
from flexmb.errors import WorkerError
from flexmb.run.simulate import simulate

FRESH = "Delete it, or compute it anew with --fresh."


def work_off(
    runs: Sequence[StudyRun], kept: Kept, workers: int, *, shown: bool, first: Sequence[Case] = ()
) -> dict[str, str]:
    """Compute runs and save their results; a failed run does not stop the other runs.

    Diagrams are computed first, one job per value of the parameter.  The other runs follow, longest first.

    Parameters
    ----------
    runs : runs without a saved result.
    kept : saved results.
    workers : number of processes; 1: the calling process.
    shown : whether progress is shown on stderr.
    first : cases whose code is compiled in the calling process, before the workers start.

    Returns
    -------
    dict : reason of each failed run or failed value of a diagram, by name of the run.
    """
    if not runs:
        return {}
    failures: dict[str, str] = {}
    ordered = sorted(runs, key=lambda run: -run.work)
    diagrams, others = ([run for run in ordered if (run.parts > 1) == apart] for apart in (True, False))
    jobs = sum(run.parts for run in runs)
    if workers > 1:
        for case in first:
            simulate(case.mechanism(), t_end=1e-6)
    crew = worker_pool(min(workers, jobs), import_module, "xarray") if workers > 1 else nullcontext()
    with crew as pool, WorkBar("runs", [run.work for run in runs], workers, shown=shown) as bar:
        for run in diagrams:
            _spread(run, kept, pool, bar, failures)
        with Attempt() as attempt:
            drive((_chain(run, kept, bar, failures) for run in others), pool, OWNER, PENDING)
        if attempt.error is not None:
            _lost(attempt.error, others, kept, failures)
    return failures


def failed_values(runs: Iterable[StudyRun], kept: Kept) -> dict[str, str]:
    """First reason of the failed values of each saved diagram, by name of the run."""
    found = {}
    for run in runs:
        if run.parts > 1 and kept.has(run):
            ok, status = kept[run]["ok"].values, kept[run]["status"].values
            if not ok.all():
                found[run.name] = f"{(~ok).sum()} of {len(ok)} values failed; the first: {status[ok.argmin()]}"
    return found


def computed(run: StudyRun, path: Path) -> Outcome:
    """Compute a run and write its result.  Called in the workers."""
    dataset, cost = timed(run.compute)
    keep(run, path, dataset, cost)
    return Outcome({"wall": cost.wall})


def timed(call: Callable[[], Any]) -> tuple[Any, Cost]:
    """Result and times of a call."""
    processor, wall = time.process_time(), time.perf_counter()
    found = call()
    return found, Cost(time.process_time() - processor, time.perf_counter() - wall)


def _chain(run: StudyRun, kept: Kept, bar: WorkBar, failures: dict[str, str]) -> Chain:
    """Jobs of one run that is not a diagram."""
    outcome = yield Job(computed, (run, kept.path(run)))
    if not outcome.ok:
        failures[run.name] = outcome.status
    bar.more(run.work, outcome.values.get("wall"), whole=True)


def _lost(error: BaseException, runs: Sequence[StudyRun], kept: Kept, failures: dict[str, str]) -> None:
    """Note the unfinished runs of a lost worker as failures."""
    if not isinstance(error, WorkerError):
        raise error
    for run in runs:
        if run.name not in failures and not kept.has(run):
            failures[run.name] = "a worker was lost; call the command again to go on"


def _spread(run: StudyRun, kept: Kept, pool: Executor | None, bar: WorkBar, failures: dict[str, str]) -> None:
    """Compute one diagram; the values of its parameter are distributed to the workers."""
    share = run.work / run.parts
    if not kept.store(run).exists():
        kept.log(run).unlink(missing_ok=True)  # the log of deleted values
    logged = Logged(pool, kept.log(run), lambda took: bar.more(share, took, whole=False))
    pending = PENDING if pool is not None else 1
    with Attempt() as attempt:
        found = run.compute(executor=logged, store=kept.store(run), pending=pending)
        values = lines_of(logged.log)[: run.parts]
        processor, wall = (sum(float(value[name]) for value in values) for name in ("processor", "wall"))
        keep(run, kept.path(run), found, Cost(processor, wall, len(values), run.parts))
        failures.update(failed_values([run], kept))
    if attempt.error is not None:
        hint = "" if logged.told or isinstance(attempt.error, WorkerError) else FRESH
        failures[run.name] = f"{failure(attempt.error).status} {hint}".strip()
    bar.more(share * max(run.parts - logged.told, 0), None, whole=True)


class Logged(Executor):
    """Executor that logs the times of its jobs.

    Parameters
    ----------
    pool : executor of the jobs; None: the calling process executes each job in `submit`.
    log : file with one line per job.
    tell : function called with the wall-clock time [s] of each finished job.

    Attributes
    ----------
    told : number of finished jobs.
    """

    def __init__(self, pool: Executor | None, log: Path, tell: Callable[[float], None]) -> None:
        self.pool, self.log, self.tell, self.told = pool, log, tell, 0

    def submit(self, function: Callable[..., Any], /, *arguments: Any, **keywords: Any) -> Future[Any]:
        """Submit the call of `function` with `arguments` and `keywords`."""
        call = partial(function, *arguments, **keywords)
        if self.pool is None:
            future: Future[Any] = Future()
            future.set_result(logged(self.log, call))
        else:
            future = self.pool.submit(logged, self.log, call)
        future.add_done_callback(self._finished)
        return future

    def _finished(self, future: Future[Any]) -> None:
        if not future.cancelled() and future.exception() is None:
            self.told += 1
            self.tell(lines_of(self.log)[-1]["wall"])


def logged(log: Path, call: Callable[[], Any]) -> Any:
    """Result of a call; its times are appended to the log.  Called in the workers."""
    found, cost = timed(call)
    append_line(log, processor=cost.cpu, wall=cost.wall)
    return found


# The one pool of worker processes; processes, since the costs of runs are processor times of processes

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


def _begin(prepare: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    signal.signal(signal.SIGINT, lambda number, frame: os._exit(130))
    threading.Thread(target=_leave_with_parent, daemon=True).start()
    prepare(*arguments)


def _leave_with_parent() -> None:
    """End this process with its parent: a worker of a killed parent would wait for its next job for ever."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
