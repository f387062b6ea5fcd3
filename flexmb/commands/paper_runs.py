"""The runs of `flexmb paper` on worker processes: longest first, each kept when it is finished."""

from __future__ import annotations

import multiprocessing
import os
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager, nullcontext
from functools import partial
from pathlib import Path
from typing import Any

from flexmb.commands.paper_files import Cost, Kept, append_line, keep, lines_of
from flexmb.commands.paper_progress import Progress
from flexmb.errors import WorkerError
from flexmb.mechanisms.nine_bar import nine_bar
from flexmb.paper.diagram import Diagram
from flexmb.paper.plate import Run
from flexmb.run.simulate import simulate
from flexmb.sweeps.attempt import Attempt, Outcome, failure
from flexmb.sweeps.engine import PENDING, Chain, Job, drive
from flexmb.sweeps.family import STOPPED
from flexmb.sweeps.pool import worker_pool

FRESH = "Delete it, or compute it anew with --fresh."


def work_off(runs: Sequence[Run], kept: Kept, workers: int, *, shown: bool) -> dict[str, str]:
    """Compute runs and keep their results; one that fails does not stop the others.

    Diagrams come first, each point a job of its own; then the other runs, the longest first.

    Parameters
    ----------
    runs : what is to be computed.
    kept : where results go.
    workers : number of processes; 1: this one.
    shown : whether progress is shown on stderr.

    Returns
    -------
    dict : by the name of a run that failed, or of whose points some failed, what happened.
    """
    if not runs:
        return {}
    diagrams = sorted((run for run in runs if isinstance(run, Diagram)), key=_work, reverse=True)
    others = sorted((run for run in runs if not isinstance(run, Diagram)), key=_work, reverse=True)
    failures: dict[str, str] = {}
    jobs = len(others) + sum(len(diagram.chosen) for diagram in diagrams)
    with _crew(workers, jobs) as pool, Progress(runs, workers, shown=shown) as progress:
        for diagram in diagrams:
            _spread(diagram, kept, pool, progress, failures)
        chains = (_chain(run, kept, progress, failures) for run in others)
        with Attempt() as attempt:
            drive(chains, pool, "flexmb paper", PENDING)
        if attempt.error is not None:
            _lost(attempt.error, others, kept, failures)
    return failures


def failed_points(runs: Iterable[Run], kept: Kept) -> dict[str, str]:
    """By the name of a diagram whose result is there but of whose points some failed, what happened.

    Parameters
    ----------
    runs : what is looked at.
    kept : results of runs.
    """
    found = {}
    for run in runs:
        if isinstance(run, Diagram) and kept.has(run):
            ok, status = kept[run]["ok"].values, kept[run]["status"].values
            if not ok.all():
                found[run.name] = f"{(~ok).sum()} of {len(ok)} values failed; the first: {status[ok.argmin()]}"
    return found


def computed(run: Run, path: Path) -> Outcome:
    """Compute a run and write its result.  Runs in the workers."""
    processor, wall = time.process_time(), time.perf_counter()
    dataset = run.compute()
    cost = Cost(time.process_time() - processor, time.perf_counter() - wall)
    keep(run, path, dataset, cost)
    return Outcome({"wall": cost.wall})


@contextmanager
def _crew(workers: int, jobs: int) -> Iterator[ProcessPoolExecutor | None]:
    """Worker processes, no more than jobs, or None for this one alone; they end with this block, however it ends."""
    if workers > 1:
        _compile_once()
    with worker_pool(min(workers, jobs), _begin) if workers > 1 else nullcontext() as pool:
        try:
            yield pool
        except KeyboardInterrupt:
            for child in multiprocessing.active_children() if pool is not None else ():
                child.terminate()  # or the end of the pool would wait for what they are at
            raise


def _compile_once() -> None:
    """Compile what is not in the cache yet here, not in all workers at the same time."""
    for flexible in (False, True):
        simulate(nine_bar(clearance=0.5e-3, flexible=flexible), t_end=1e-6)


def _begin() -> None:
    """What every worker does first: imports, and a watch on the process that started it.

    Where that one is killed, a worker would wait for its next job for ever.
    """
    import xarray  # noqa: F401, PLC0415 - for its time

    threading.Thread(target=_leave_with_parent, daemon=True).start()


def _leave_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _chain(run: Run, kept: Kept, progress: Progress, failures: dict[str, str]) -> Chain:
    """One run."""
    outcome = yield Job(computed, (run, kept.path(run)))
    if STOPPED in outcome.status:  # Ctrl-C, seen by a simulation in this process
        raise KeyboardInterrupt
    if not outcome.ok:
        failures[run.name] = outcome.status
    progress.more(run.work, outcome.values.get("wall"), whole=True)


def _lost(error: BaseException, runs: Sequence[Run], kept: Kept, failures: dict[str, str]) -> None:
    """Workers that died take with them what they had not finished."""
    if not isinstance(error, WorkerError):
        raise error
    for run in runs:
        if run.name not in failures and not kept.has(run):
            failures[run.name] = "a worker was lost; call the command again to go on"


def _spread(diagram: Diagram, kept: Kept, pool: Executor | None, progress: Progress, failures: dict[str, str]) -> None:
    """One diagram, its points spread over the workers."""
    count = len(diagram.chosen)
    share = diagram.work / count
    if not kept.store(diagram).exists():
        kept.log(diagram).unlink(missing_ok=True)  # of points that are there no more
    logged = Logged(pool, kept.log(diagram), lambda took: progress.more(share, took, whole=False))
    with Attempt() as attempt:
        found = diagram.spread(logged, kept.store(diagram), PENDING if pool is not None else 1)
        points = lines_of(logged.log)[:count]
        took = (sum(float(point[name]) for point in points) for name in ("processor", "wall"))
        keep(diagram, kept.path(diagram), found, Cost(*took, len(points), count))
        failures.update(failed_points([diagram], kept))
    if attempt.error is not None:
        hint = "" if logged.told or isinstance(attempt.error, WorkerError) else FRESH
        failures[diagram.name] = f"{failure(attempt.error).status} {hint}".strip()
    progress.more(share * max(count - logged.told, 0), None, whole=True)


class Logged(Executor):
    """An executor whose jobs note what they took.

    Parameters
    ----------
    pool : where jobs are done; None: here, at once.
    log : file that gets a line for each job.
    tell : called with the time by the clock [s] that a finished job took.

    Attributes
    ----------
    told : number of finished jobs.
    """

    def __init__(self, pool: Executor | None, log: Path, tell: Callable[[float], None]) -> None:
        self.pool, self.log, self.tell, self.told = pool, log, tell, 0

    def submit(self, function: Callable[..., Any], /, *arguments: Any, **keywords: Any) -> Future:
        """As of any executor: call `function` with `arguments` and `keywords`."""
        call = partial(function, *arguments, **keywords)
        if self.pool is None:
            future: Future = Future()
            future.set_result(logged(self.log, call))
        else:
            future = self.pool.submit(logged, self.log, call)
        future.add_done_callback(self._finished)
        return future

    def _finished(self, future: Future) -> None:
        if not future.cancelled() and future.exception() is None:
            self.told += 1
            self.tell(lines_of(self.log)[-1]["wall"])


def logged(log: Path, call: Callable[[], Any]) -> Any:
    """The result of a call; what it took is added to the log.  Runs in the workers."""
    processor, wall = time.process_time(), time.perf_counter()
    found = call()
    append_line(log, processor=time.process_time() - processor, wall=time.perf_counter() - wall)
    return found


def _work(run: Run) -> float:
    return run.work
