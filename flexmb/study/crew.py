"""The runs of a study on worker processes: longest first, each kept when it is finished."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor, Future
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any

from flexmb.errors import WorkerError
from flexmb.jobs.attempt import Attempt, Outcome, failure
from flexmb.jobs.engine import PENDING, Chain, Job, drive
from flexmb.jobs.files import append_line, lines_of
from flexmb.jobs.pool import worker_pool
from flexmb.jobs.progress import WorkBar
from flexmb.run.simulate import simulate
from flexmb.study.case import Case
from flexmb.study.run import StudyRun
from flexmb.study.store import Cost, Kept, keep
from flexmb.sweeps.family import STOPPED

FRESH = "Delete it, or compute it anew with --fresh."


def work_off(
    runs: Sequence[StudyRun], kept: Kept, workers: int, *, shown: bool, first: Sequence[Case] = ()
) -> dict[str, str]:
    """Compute runs and keep their results; one that fails does not stop the others.

    Diagrams come first, each value a job of its own; then the other runs, the longest first.

    Parameters
    ----------
    runs : runs whose results are not there.
    kept : folder of the results.
    workers : number of processes; 1: this one.
    shown : whether progress is shown on stderr.
    first : cases whose code is compiled here, before all workers would do it at the same time.

    Returns
    -------
    dict : by the name of a run that failed, or of whose values some failed, the reason.
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
    crew = worker_pool(min(workers, jobs), _imported) if workers > 1 else nullcontext()
    with crew as pool, WorkBar("runs", [run.work for run in runs], workers, shown=shown) as bar:
        for run in diagrams:
            _spread(run, kept, pool, bar, failures)
        with Attempt() as attempt:
            drive((_chain(run, kept, bar, failures) for run in others), pool, "flexmb paper", PENDING)
        if attempt.error is not None:
            _lost(attempt.error, others, kept, failures)
    return failures


def failed_values(runs: Iterable[StudyRun], kept: Kept) -> dict[str, str]:
    """By the name of a diagram whose result is there but of whose values some failed, the first reason."""
    found = {}
    for run in runs:
        if run.parts > 1 and kept.has(run):
            ok, status = kept[run]["ok"].values, kept[run]["status"].values
            if not ok.all():
                found[run.name] = f"{(~ok).sum()} of {len(ok)} values failed; the first: {status[ok.argmin()]}"
    return found


def computed(run: StudyRun, path: Path) -> Outcome:
    """Compute a run and write its result.  Runs in the workers."""
    dataset, cost = timed(run.compute)
    keep(run, path, dataset, cost)
    return Outcome({"wall": cost.wall})


def timed(call: Callable[[], Any]) -> tuple[Any, Cost]:
    """The result of a call, and its times."""
    processor, wall = time.process_time(), time.perf_counter()
    found = call()
    return found, Cost(time.process_time() - processor, time.perf_counter() - wall)


def _imported() -> None:
    """Imports of a worker, side by side with those of the others."""
    import xarray  # noqa: F401 - for its time


def _chain(run: StudyRun, kept: Kept, bar: WorkBar, failures: dict[str, str]) -> Chain:
    """One run."""
    outcome = yield Job(computed, (run, kept.path(run)))
    if STOPPED in outcome.status:  # Ctrl-C, seen by a simulation in this process
        raise KeyboardInterrupt
    if not outcome.ok:
        failures[run.name] = outcome.status
    bar.more(run.work, outcome.values.get("wall"), whole=True)


def _lost(error: BaseException, runs: Sequence[StudyRun], kept: Kept, failures: dict[str, str]) -> None:
    """Workers that died lose their unfinished runs."""
    if not isinstance(error, WorkerError):
        raise error
    for run in runs:
        if run.name not in failures and not kept.has(run):
            failures[run.name] = "a worker was lost; call the command again to go on"


def _spread(run: StudyRun, kept: Kept, pool: Executor | None, bar: WorkBar, failures: dict[str, str]) -> None:
    """One diagram, its values spread over the workers."""
    share = run.work / run.parts
    if not kept.store(run).exists():
        kept.log(run).unlink(missing_ok=True)  # of values that are there no more
    logged = Logged(pool, kept.log(run), lambda took: bar.more(share, took, whole=False))
    pending = PENDING if pool is not None else 1
    with Attempt() as attempt:
        found = run.compute(executor=logged, store=kept.store(run), pending=pending)
        values = lines_of(logged.log)[: run.parts]
        took = (sum(float(value[name]) for value in values) for name in ("processor", "wall"))
        keep(run, kept.path(run), found, Cost(*took, len(values), run.parts))
        failures.update(failed_values([run], kept))
    if attempt.error is not None:
        hint = "" if logged.told or isinstance(attempt.error, WorkerError) else FRESH
        failures[run.name] = f"{failure(attempt.error).status} {hint}".strip()
    bar.more(share * max(run.parts - logged.told, 0), None, whole=True)


class Logged(Executor):
    """An executor whose jobs note their times.

    Parameters
    ----------
    pool : executor that does the jobs; None: this process does them at once.
    log : file that gets a line for each job.
    tell : called with the time by the clock [s] of a finished job.

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
    """The result of a call, whose times are added to the log.  Runs in the workers."""
    found, cost = timed(call)
    append_line(log, processor=cost.cpu, wall=cost.wall)
    return found
