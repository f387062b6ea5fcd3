"""`flexmb paper`: the study of the nine-bar mechanism: figures, tables, the data of both, and what they took."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from flexmb import checks
from flexmb.commands.files import require_folder, require_packages
from flexmb.commands.paper_files import RUNS, Kept, make_page, make_plate, write_text
from flexmb.commands.paper_runs import failed_points, work_off
from flexmb.commands.paper_times import label, note_call, times
from flexmb.paper.contents import chosen, pages, plates, runs_of
from flexmb.paper.effort import FULL, QUICK, Effort
from flexmb.paper.plate import Page, Plate
from flexmb.sweeps.attempt import Attempt, failure


def paper(options: argparse.Namespace) -> int:
    """Compute what is not there yet, draw and write what was asked for.

    Parameters
    ----------
    options : what, out, quick, workers, fresh, quiet, list of the command line.

    Returns
    -------
    int : 0 if all is there, 1 if something is missing.

    Raises
    ------
    FlexmbError : a word that means nothing, a folder that cannot be written, a number of workers below 1.
    """
    effort = QUICK if options.quick else FULL
    if options.list:
        return _listed(effort)
    figures, tables = chosen(options.what, effort)
    workers = cores() if options.workers is None else checks.count("flexmb paper", "--workers", options.workers)
    folder = Path(options.out or Path("out") / ("paper-quick" if options.quick else "paper"))
    require_packages({"h5netcdf": ("results", ""), "matplotlib": ("figures", ""), "zarr": ("diagrams", "")})
    for place in (folder, folder / RUNS[effort.name]):
        require_folder(place)
    began, busy = time.perf_counter(), time.process_time()
    kept, runs = Kept(folder / RUNS[effort.name]), runs_of([*figures, *tables])
    if options.fresh:
        for run in runs.values():
            kept.forget(run)
    missing = [run for run in runs.values() if not kept.has(run)]
    failures = failed_points(runs.values(), kept) | work_off(missing, kept, workers, shown=not options.quiet)
    written, drawn, unmade = _made([*figures, *tables], kept, folder, effort)
    computed = [run for run in missing if kept.has(run)]
    processor = time.process_time() - busy + (sum(kept.cost(run).processor for run in computed) if workers > 1 else 0.0)
    note_call(kept.folder, workers, len(computed), processor, time.perf_counter() - began)
    written.append(write_text(folder / "times.md", times([*figures, *tables], kept, drawn, workers)))
    if not options.quiet:
        print(f"{len(computed)} runs computed, {len(runs) - len(missing)} found.\nwritten:", *written, sep="\n  ")
    return _told(failures, unmade)


def cores() -> int:
    """Processor cores that this process may use."""
    allowed = getattr(os, "sched_getaffinity", None)  # not on every system
    return len(allowed(0)) if allowed is not None else os.cpu_count() or 1


def _made(
    items: Sequence[Plate | Page], kept: Kept, folder: Path, effort: Effort
) -> tuple[list[Path], dict[str, float], dict[str, str]]:
    """What was written, the processor time by figure and page, and what could not be made."""
    written: list[Path] = []
    took: dict[str, float] = {}
    unmade: dict[str, str] = {}
    for item in items:
        absent = [run.name for run in item.runs if not kept.has(run)]
        if absent:
            unmade[label(item)] = f"{', '.join(absent)} missing"
            continue
        began = time.process_time()
        with Attempt() as attempt:
            if isinstance(item, Plate):
                written += make_plate(item, kept, folder, effort.name)
            else:
                written += make_page(item, kept, folder, effort.name)
            took[label(item)] = time.process_time() - began
        if attempt.error is not None:
            unmade[label(item)] = failure(attempt.error).status
    return written, took, unmade


def _told(failures: Mapping[str, str], unmade: Mapping[str, str]) -> int:
    """Say what failed; the exit code."""
    for name, text in failures.items():
        print(f"flexmb: run {name!r} failed: {text}", file=sys.stderr)
    for name, text in unmade.items():
        print(f"flexmb: {name} could not be made: {text}", file=sys.stderr)
    return 1 if failures or unmade else 0


def _listed(effort: Effort) -> int:
    """Print figures and pages."""
    for plate in plates(effort):
        print(f"{plate.number:>12d}  {plate.title}")
    for page in pages(effort):
        print(f"{page.name:>12s}  {page.title}{' (only if asked for)' if page.slow else ''}")
    return 0
