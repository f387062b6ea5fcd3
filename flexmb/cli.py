"""The command line: flexmb run | sweep | chaos | list | check | vtk | report | rerun | paper."""

from __future__ import annotations

import argparse
import io
import os
import re
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from flexmb.errors import FlexmbError
from flexmb.version import installed_version

if TYPE_CHECKING:
    from flexmb.commands.mechanism_options import Option
    from flexmb.commands.source import Source

OK, NOT_FINISHED, REFUSED, INTERRUPTED = 0, 1, 2, 130
"""Exit codes."""
WITH_SOURCE = ("run", "sweep", "chaos", "check")
SOURCE_HELP = "a ready mechanism (see `flexmb list`), or FILE.py[:NAME] with a Mechanism or a function that returns one"
TANGENT_METHODS = "methods of `flexmb run` except runge-kutta"
UNITS_HELP = "Numbers may carry a unit: 0.5mm, 50um, 2pi, 3000rpm, 30deg, 0.1ms; without one they are SI."


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    arguments : arguments after `flexmb`; None: the typed arguments.

    Returns
    -------
    int : exit code: 0 done, 1 the run did not reach its end or `check` found errors, 2 refused, 130 interrupted from
        the keyboard.
    """
    given = with_negative_numbers(sys.argv[1:] if arguments is None else arguments)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # names of parts that the terminal cannot show
    try:
        code = _dispatch(given)
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        if not reader_is_gone():
            raise
        return OK
    except FlexmbError as error:
        if "--debug" in given:
            raise
        print(f"flexmb: {' '.join(str(error).split())}", file=sys.stderr)
        return REFUSED
    except ModuleNotFoundError as error:
        if "--debug" in given or not error.name:
            raise
        package = error.name.partition(".")[0]
        print(f"flexmb: the package {package!r} is missing. Install it: pip install {package}", file=sys.stderr)
        return REFUSED
    except KeyboardInterrupt:
        print("flexmb: interrupted from the keyboard.", file=sys.stderr)
        return INTERRUPTED


def reader_is_gone() -> bool:
    """Whether the reader of the output has closed the pipe, as `head` does; further output goes nowhere then."""
    try:
        print(flush=True)  # what failed is no longer in the buffer
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return True
    return False


def with_negative_numbers(arguments: Sequence[str]) -> list[str]:
    """Arguments with negative numbers joined to their options: --speed -2pi becomes --speed=-2pi.

    Parameters
    ----------
    arguments : the arguments.
    """
    joined: list[str] = []
    for text in arguments:
        if joined and re.match(r"-[.\d]|-pi", text) and joined[-1].startswith("--") and "=" not in joined[-1]:
            joined[-1] = f"{joined[-1]}={text}"
        else:
            joined.append(text)
    return joined


def _dispatch(given: list[str]) -> int:
    source = _source(given)
    parser, maker_options = _parser(source, given[0] if given else "")
    options, unknown = parser.parse_known_args(given)
    if unknown:
        options.own_parser.error(f"unrecognized arguments: {' '.join(unknown)}")
    options.arguments = given
    if getattr(options, "quiet", False):
        os.environ["FLEXMB_MESSAGES"] = "0"  # no messages on compilation, also in worker processes
    if options.command == "list":
        from flexmb.commands.source import list_mechanisms

        return list_mechanisms()
    if options.command == "vtk":
        from flexmb.commands.run import write_frames

        return write_frames(options.file, options.out, options.frames)
    if options.command == "paper":
        from flexmb.commands.paper import paper

        return paper(options)
    if options.command == "rerun":
        return _rerun(options.file, options.name)
    if options.command == "report":
        return _report(options)
    if source is None:
        parser.error(f"the mechanism comes first: flexmb {options.command} NAME [options]")
    return _with_mechanism(source, maker_options, options)


def _report(options: argparse.Namespace) -> int:
    """Write the page of a saved run, with its mechanism if the file or the user names it."""
    from flexmb.commands.mechanism_options import keywords_of
    from flexmb.commands.report import datasets_of, repeated_command, write_diagram
    from flexmb.reports.report import report
    from flexmb.results.netcdf import load

    target = options.out or options.file.with_suffix(".html")
    if groups := datasets_of(options.file):
        print(write_diagram(groups, target))
        return OK
    sol, mechanism = load(options.file), None
    given = repeated_command(sol, options.name)
    source = _source(given)
    if source is not None:
        parser, maker_options = _parser(source, "run")
        mechanism = source.mechanism(keywords_of(parser.parse_args(given), maker_options))
    print(report(sol, target, mechanism=mechanism, frames=options.frames))
    return OK


def _rerun(path: Path, name: str | None) -> int:
    """Repeat the run of a file with its own arguments, and compare."""
    from flexmb.commands.mechanism_options import keywords_of
    from flexmb.commands.rerun import source_of, tell
    from flexmb.commands.run import keywords_of_run
    from flexmb.run.simulate import simulate

    given = source_of(path, name)
    source = _source(given)
    parser, maker_options = _parser(source, "run")
    options = parser.parse_args(given)
    if source is None:
        parser.error(f"{path}: names no mechanism")
    mechanism = source.mechanism(keywords_of(options, maker_options))
    return tell(path, simulate(mechanism, progress=True, **keywords_of_run(mechanism, options)))


def _with_mechanism(source: Source, maker_options: list[Option], options: argparse.Namespace) -> int:
    from flexmb.commands.mechanism_options import keywords_of

    if options.command == "sweep":
        from flexmb.commands.sweep import sweep

        return sweep(source, options.source, maker_options, options)
    mechanism = source.mechanism(keywords_of(options, maker_options))
    if options.command == "check":
        from flexmb.commands.check import check_mechanism

        return check_mechanism(mechanism, as_json=options.json)
    if options.command == "chaos":
        from flexmb.commands.chaos import chaos

        return chaos(mechanism, source.name, options)
    from flexmb.commands.run import run

    return run(mechanism, source.name, options)


def _source(given: list[str]) -> Source | None:
    """The source of the mechanism in the arguments, which is needed first: its parameters become options."""
    if len(given) < 2 or given[0] not in WITH_SOURCE or given[1].startswith("-"):
        return None
    from flexmb.commands.source import find

    return find(given[1])


def _parser(source: Source | None, wanted: str) -> tuple[argparse.ArgumentParser, list[Option]]:
    """The parser, and the options of the source, which are added to the typed command only."""
    parser = argparse.ArgumentParser(
        prog="flexmb", description="Planar flexible multibody dynamics with imperfect joints.", allow_abbrev=False
    )
    parser.add_argument("--version", action="version", version=f"flexmb {installed_version()}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    add = partial(commands.add_parser, allow_abbrev=False)
    run = add("run", help="simulate a mechanism and write its results", epilog=UNITS_HELP)
    examined = "all that is wrong with a mechanism; degrees of freedom, mass, natural frequencies"
    check = add("check", help=examined, epilog=f"{UNITS_HELP} Exit code 1 where a run could not be right.")
    check.add_argument("--json", action="store_true", help="print the report as JSON")
    sweep = add("sweep", help="a bifurcation diagram over one parameter", epilog=UNITS_HELP)
    chaos = add("chaos", help="exponents, section and verdict: periodic or chaotic", epilog=UNITS_HELP)
    _add_run_options(run)
    _add_sweep_options(sweep)
    _add_chaos_options(chaos)
    listing = add("list", help="ready mechanisms and their options")
    vtk = add("vtk", help="write VTK files of a saved run")
    vtk.add_argument("file", metavar="RUN.nc", type=Path, help="file of `flexmb run`")
    vtk.add_argument("--frames", type=int, metavar="N", help="number of frames (default: all instants, at most 200)")
    vtk.add_argument("--out", type=Path, metavar="FILE.pvd", help="default: beside RUN.nc")
    rerun = add("rerun", help="repeat a saved run and compare the results")
    rerun.add_argument("file", metavar="RUN.nc", type=Path, help="file of `flexmb run`")
    trusted = "the mechanism; needed where the file is of a run of FILE.py, which is executed"
    rerun.add_argument("name", metavar="NAME", nargs="?", help=trusted)
    report = add("report", help="write the HTML page of a saved run, diagram or study")
    report.add_argument("file", metavar="RUN.nc", type=Path, help="file of `flexmb run`, `sweep` or `chaos`")
    report.add_argument("name", metavar="NAME", nargs="?", help=trusted)
    report.add_argument("--out", type=Path, metavar="FILE.html", help="default: beside RUN.nc")
    report.add_argument("--frames", type=int, metavar="N", default=1000, help="most frames (default 1000)")
    paper = add("paper", help="figures and tables of a published study computed anew")
    _add_paper_options(paper)
    for command in (run, sweep, chaos, check, listing, vtk, rerun, report, paper):
        command.add_argument("--debug", action="store_true", help="show the traceback of an error")
        command.set_defaults(own_parser=command)
    options: list[Option] = []
    for name, command in {"run": run, "sweep": sweep, "chaos": chaos, "check": check}.items():
        command.add_argument("source", metavar="NAME", help=SOURCE_HELP)
        if source is not None and name == wanted:
            options = _add_maker(command, source)
    return parser, options


def _add_maker(command: argparse.ArgumentParser, source: Source) -> list[Option]:
    from flexmb.commands.mechanism_options import add_options

    try:
        return add_options(command, source.make, f"options of {source.name}")
    except argparse.ArgumentError as error:
        text = f"{source.name}: a parameter has the name of an option of this command ({error})."
        raise FlexmbError(f"{text} Rename the parameter.") from error


def _add_run_options(run: argparse.ArgumentParser) -> None:
    time = run.add_argument_group("time")
    end = time.add_mutually_exclusive_group()
    end.add_argument("--periods", metavar="X", help="length of the run in periods of the drives (default 2)")
    end.add_argument("--t-end", metavar="TIME", help="length of the run, e.g. 0.5s")
    time.add_argument("--save-from-period", metavar="X", help="first saved period, also for peaks (default 0)")
    time.add_argument("--save", metavar="N", help="saved instants a period, or `steps` for every step (default 1000)")
    time.add_argument("--restart", metavar="RUN.nc", type=Path, help="start from the end of this run of the mechanism")
    keep = run.add_argument_group("interruptions")
    every = "time between checkpoints, from which --resume goes on (default 30s)"
    keep.add_argument("--checkpoint", metavar="TIME", default="30s", help=every)
    keep.add_argument("--resume", action="store_true", help="go on with a run that was ended from outside, bit for bit")
    names = "generalised-alpha[:RADIUS] (default), hht[:ALPHA], wbz[:ALPHA], trapezoidal, runge-kutta"
    _add_method(run, f"{names}; runge-kutta needs --step")
    files = run.add_argument_group("files")
    files.add_argument("--out", metavar="DIR", help="folder of the results (default out/NAME)")
    files.add_argument("--frames", type=int, metavar="N", default=100, help="number of VTK frames (default 100)")
    files.add_argument("--no-vtk", action="store_true", help="no VTK files")
    files.add_argument("--no-report", action="store_true", help="no report.html")
    files.add_argument("--no-plots", action="store_true", help="no pictures")
    files.add_argument("--quiet", action="store_true", help="no progress bar and no summary")


def _add_sweep_options(sweep: argparse.ArgumentParser) -> None:
    group = sweep.add_argument_group(
        "sweep", "Give one option of the mechanism a range: --speed 0.5pi:2.5pi:50, or values: 1,2,4."
    )
    group.add_argument(
        "--vary", metavar="PART.FIELD=RANGE", help="range of a field of a part, e.g. P1.clearance=0.1mm:1mm:10"
    )
    group.add_argument("--skip", type=int, metavar="N", default=50, help="periods before the first point (default 50)")
    group.add_argument("--keep", type=int, metavar="N", default=50, help="points at each value (default 50)")
    group.add_argument(
        "--direction",
        metavar="NAME",
        default="cold",
        help="start of each value: cold (default), from the value below (up) or above (down), or both",
    )
    group.add_argument(
        "--chunks", type=int, metavar="N", default=1, help="chunks of up and down with a cold start each (default 1)"
    )
    group.add_argument("--signals", metavar="A,B", help="signals to keep (default all)")
    group.add_argument("--period", metavar="TIME", help="time between two points (default the period of the drives)")
    group.add_argument("--exponent", action="store_true", help="also the largest Lyapunov exponent at each value")
    solver = _add_method(sweep, TANGENT_METHODS)
    solver.add_argument("--workers", type=int, metavar="N", default=1, help="number of worker processes (default 1)")
    files = sweep.add_argument_group("files")
    files.add_argument("--store", metavar="DIR.zarr", help="store of all finished points (zarr)")
    files.add_argument("--resume", action="store_true", help="continue an existing store")
    files.add_argument("--out", metavar="DIR", help="folder of dataset and pictures (default out/NAME)")
    files.add_argument("--plot", metavar="A,B", help="signals of the pictures (default: one signal)")
    files.add_argument("--no-plots", action="store_true", help="no pictures")
    files.add_argument("--no-report", action="store_true", help="no report.html")
    files.add_argument("--quiet", action="store_true", help="no progress bar and no summary")


def _add_chaos_options(chaos: argparse.ArgumentParser) -> None:
    group = chaos.add_argument_group("chaos")
    group.add_argument("--skip", type=int, metavar="N", default=20, help="periods before the first point (default 20)")
    group.add_argument("--keep", type=int, metavar="N", default=200, help="points, one a period (default 200)")
    group.add_argument("--exponents", type=int, metavar="K", default=1, help="number of exponents (default 1)")
    group.add_argument("--period", metavar="TIME", help="time between two points (default the period of the drives)")
    group.add_argument("--signals", metavar="A,B", help="signals to be drawn and analysed (default: one signal)")
    group.add_argument(
        "--series", type=int, metavar="N", default=64, help="number of finely sampled periods (default 64; 0: none)"
    )
    group.add_argument("--samples", type=int, metavar="N", default=400, help="samples in each of them (default 400)")
    group.add_argument(
        "--dimension",
        action="store_true",
        help="also the correlation dimension of each signal; it needs some 300 periods",
    )
    group.add_argument("--recurrence", action="store_true", help="also the recurrence quantification of each signal")
    group.add_argument(
        "--no-confirm",
        action="store_true",
        help="no second run with finer steps, a fifth as long, which confirms errors and verdict",
    )
    _add_method(chaos, TANGENT_METHODS)
    files = chaos.add_argument_group("files")
    files.add_argument("--out", metavar="DIR", help="folder of results and pictures (default out/NAME)")
    files.add_argument("--no-plots", action="store_true", help="no pictures")
    files.add_argument("--no-report", action="store_true", help="no report.html")
    files.add_argument("--quiet", action="store_true", help="no progress bar and no table")


def _add_paper_options(paper: argparse.ArgumentParser) -> None:
    paper.description = (
        "A published study computed anew: the study of Chen, Jiang, Deng and Wang (Nonlinear Dynamics, 2018) on the "
        "nine-bar mechanism, or another one. Results of runs are kept in DIR/runs (quick: DIR/runs-quick), so an "
        "interrupted command continues when it is called again."
    )
    paper.add_argument(
        "what",
        metavar="WHAT",
        nargs="*",
        help="numbers of figures (9), ranges (9-16), names of pages, `figures`, `pages` or `all`; default: all figures "
        "and pages except the slow pages, which need `all` or their names",
    )
    paper.add_argument("--study", metavar="NAME", default="nine-bar", help="nine-bar (default) or slider-crank")
    paper.add_argument("--out", metavar="DIR", help="folder of all files (default out/paper, quick: out/paper-quick)")
    paper.add_argument("--quick", action="store_true", help="short runs: all figures and pages within ten minutes")
    paper.add_argument("--workers", type=int, metavar="N", help="worker processes (default: one for each core)")
    paper.add_argument("--fresh", action="store_true", help="compute existing results again")
    paper.add_argument("--list", action="store_true", help="list figures and pages only")
    paper.add_argument("--quiet", action="store_true", help="no progress and no list of files")


def _add_method(command: argparse.ArgumentParser, names: str) -> argparse._ArgumentGroup:
    """Add the options for step and method, which all commands with a motion have."""
    from flexmb.step.step_size import RTOL

    solver = command.add_argument_group("method")
    step = solver.add_mutually_exclusive_group()
    step.add_argument("--step", metavar="TIME", help="fixed step, e.g. 10us (default: error-controlled steps)")
    step.add_argument("--rtol", metavar="X", help=f"relative tolerance of the velocities in a step (default {RTOL:g})")
    solver.add_argument("--method", metavar="NAME", help=names)
    return solver
