"""`flexmb paper`: figures and pages of a published study, their data, and the times of the runs."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Mapping
from pathlib import Path

from flexmb import checks
from flexmb.commands.files import require_folder, require_packages
from flexmb.jobs.files import write_text
from flexmb.jobs.pool import cores
from flexmb.study.crew import failed_values, work_off
from flexmb.study.effort import Effort
from flexmb.study.output import make
from flexmb.study.store import Kept
from flexmb.study.study import OWNER, Study, runs_of, studies, study_of
from flexmb.study.times import note_call, times

NINE_BAR = "nine-bar"
RUNS = {"full": "runs", "quick": "runs-quick"}
"""Folders of the results of runs, by effort; quick results do not replace full results."""


def paper(options: argparse.Namespace) -> int:
    """Compute the missing runs, draw figures and write pages.

    Parameters
    ----------
    options : what, study, out, quick, workers, fresh, quiet, list of the command line.

    Returns
    -------
    int : 0 if all figures and pages were made, else 1.

    Raises
    ------
    FlexmbError : an unknown word or study, a folder that cannot be written, a number of workers below 1.
    """
    study = study_of(options.study)
    effort = study.effort(quick=options.quick)
    if options.list:
        return _listed(study, effort)
    items = study.chosen(options.what, effort)
    workers = cores() if options.workers is None else checks.count(OWNER, "--workers", options.workers)
    folder = Path(options.out or Path("out") / _folder(options))
    require_packages({"h5netcdf": ("results", ""), "matplotlib": ("figures", ""), "zarr": ("diagrams", "")})
    for place in (folder, folder / RUNS[effort.name]):
        require_folder(place)
    began, busy = time.perf_counter(), time.process_time()
    kept, runs = Kept(folder / RUNS[effort.name]), runs_of(items)
    if options.fresh:
        for run in runs.values():
            kept.forget(run)
    missing = [run for run in runs.values() if not kept.has(run)]
    failures = failed_values(runs.values(), kept)
    failures |= work_off(missing, kept, workers, shown=not options.quiet, first=study.first)
    made = make(items, kept, folder, effort.name, shown=not options.quiet)
    computed = [run for run in missing if kept.has(run)]
    processor = time.process_time() - busy + (sum(kept.cost(run).cpu for run in computed) if workers > 1 else 0.0)
    note_call(kept.folder, workers, len(computed), processor, time.perf_counter() - began)
    made.written.append(write_text(folder / "times.md", times(items, kept, made.drawn, workers)))
    print(f"{len(computed)} runs computed, {len(runs) - len(missing)} found.\nwritten:", *made.written, sep="\n  ")
    return _told(failures, made.unmade)


def _folder(options: argparse.Namespace) -> str:
    name = "paper" if options.study == NINE_BAR else f"paper-{options.study}"
    return f"{name}-quick" if options.quick else name


def _told(failures: Mapping[str, str], unmade: Mapping[str, str]) -> int:
    """Print the failures, and return the exit code."""
    for name, text in failures.items():
        print(f"flexmb: run {name!r} failed: {text}", file=sys.stderr)
    for name, text in unmade.items():
        print(f"flexmb: {name} could not be made: {text}", file=sys.stderr)
    return 1 if failures or unmade else 0


def _listed(study: Study, effort: Effort) -> int:
    """Print figures and pages, and the names of the studies."""
    print(f"{study.title}; all studies: {', '.join(studies())}")
    for figure in study.figures(effort):
        print(f"{figure.number:>12d}  {figure.title}")
    for page in study.pages(effort):
        print(f"{page.name:>12s}  {page.title}{' (only if asked for)' if page.slow else ''}")
    return 0
