"""The command: figures and pages of a published study, their data, and the times of the runs."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from nine_bar_study.crew import failed_values, work_off
from nine_bar_study.effort import Effort
from nine_bar_study.output import make
from nine_bar_study.store import Kept
from nine_bar_study.study import OWNER, Study, runs_of, studies, study_of
from nine_bar_study.times import note_call, times

from flexmb import checks
from flexmb.cli.run import require_folder, require_packages
from flexmb.dynamics.jobs.files import write_text
from flexmb.engine.compiled.ahead import cores
from flexmb.errors import FlexmbError

NINE_BAR = "nine-bar"
RUNS = {"full": "runs", "quick": "runs-quick"}
"""Folders of the results of runs, by effort; quick results do not replace full results."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Carry out the command; 0 if all figures and pages were made, 1 if not, 2 if it cannot be carried out."""
    options = _parser().parse_args(arguments)
    try:
        return _made(options)
    except FlexmbError as error:
        print(f"{OWNER}: {error}", file=sys.stderr)
        return 2


def _parser() -> argparse.ArgumentParser:
    """The command line."""
    parser = argparse.ArgumentParser(
        description="A published study computed anew: the study of Chen, Jiang, Deng and Wang (Nonlinear Dynamics, "
        "2018) on the nine-bar mechanism, or another one. Results of runs are kept in DIR/runs (quick: "
        "DIR/runs-quick), so an interrupted command continues when it is called again."
    )
    parser.add_argument(
        "what",
        metavar="WHAT",
        nargs="*",
        help="numbers of figures (9), ranges (9-16), names of pages, `figures`, `pages` or `all`; default: all figures "
        "and pages except the slow pages, which need `all` or their names",
    )
    parser.add_argument("--study", metavar="NAME", default=NINE_BAR, help="nine-bar (default) or slider-crank")
    parser.add_argument("--out", metavar="DIR", help="folder of all files (default out/paper, quick: out/paper-quick)")
    parser.add_argument("--quick", action="store_true", help="short runs: all figures and pages within ten minutes")
    parser.add_argument("--workers", type=int, metavar="N", help="worker processes (default: one for each core)")
    parser.add_argument("--fresh", action="store_true", help="compute existing results again")
    parser.add_argument("--list", action="store_true", help="list figures and pages only")
    parser.add_argument("--quiet", action="store_true", help="no progress and no messages; the summary is printed")
    return parser


def _made(options: argparse.Namespace) -> int:
    """Compute the missing runs, draw figures and write pages."""
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
        print(f"{OWNER}: run {name!r} failed: {text}", file=sys.stderr)
    for name, text in unmade.items():
        print(f"{OWNER}: {name} could not be made: {text}", file=sys.stderr)
    return 1 if failures or unmade else 0


def _listed(study: Study, effort: Effort) -> int:
    """Print figures and pages, and the names of the studies."""
    print(f"{study.title}; all studies: {', '.join(studies())}")
    for figure in study.figures(effort):
        print(f"{figure.number:>12d}  {figure.title}")
    for page in study.pages(effort):
        print(f"{page.name:>12s}  {page.title}{' (only if asked for)' if page.slow else ''}")
    return 0
