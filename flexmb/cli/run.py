"""`flexmb run`: simulate a mechanism, write its files, print a summary."""

import argparse
import ctypes
import os
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Executor, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from io import BytesIO
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.dynamics.jobs.files import unwritable
from flexmb.engine.dormand_prince.method import DormandPrince
from flexmb.engine.newmark.method import Newmark
from flexmb.engine.step.runge_kutta import RungeKutta4
from flexmb.engine.step.step_size import Adaptive, FixedStep
from flexmb.errors import FlexmbError, InputError, MissingPackageError
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.results.netcdf import load
from flexmb.results.solution import Solution, facts
from flexmb.results.status import followed, main_signals, panels
from flexmb.results.vtk import write_vtk
from flexmb.run.checkpoint import removed_after
from flexmb.run.simulate import simulate
from flexmb.units import quantity

REPORT = "report.html"  # page of a run; pages of diagrams and of studies of a motion have the names of their files


def require_packages(needed: Mapping[str, tuple[str, str]]) -> None:
    """Refuse to start without the packages that the results need."""
    for package, (purpose, other) in needed.items():
        if find_spec(package) is None:
            text = f"{purpose} need the package {package!r}, which is not installed. Install it: pip install {package}"
            raise MissingPackageError(f"{text},{other}." if other else f"{text}.")


def require_those_of(options: argparse.Namespace) -> None:
    """Refuse to start without the packages that a command with these options needs."""
    needed = {"h5netcdf": ("results", ""), "h5py": ("results", "")}
    if not options.no_plots:
        needed["matplotlib"] = ("pictures", " or leave them out with --no-plots")
    if not getattr(options, "no_vtk", True):
        needed["meshio"] = ("VTK files", " or leave them out with --no-vtk")
    require_packages(needed)


def tell(text: str, written: Sequence[Path], *troubles: str | None) -> None:
    """Print a summary with the written files, and troubles, if any, as errors."""
    print(text, "", "written:", *(f"  {path}" for path in written), sep="\n")
    for trouble in filter(None, troubles):
        print(f"flexmb: {trouble}", file=sys.stderr)


def require_folder(folder: Path) -> None:
    """Create a folder, and refuse to start if it cannot be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except (OSError, ValueError) as error:
        raise unwritable(folder, error, "--out") from error


def table(mechanism: Mechanism, sol: Solution) -> str:
    """Text of the summary of a run."""
    rows = [("mechanism", sol.name), ("status", sol.status), *((fact.label, fact.text) for fact in facts(sol))]
    body, guide = followed(mechanism)
    if body is not None and len(sol.time):  # stroke of a slider along its guide, or swing of the last body
        if guide is not None and guide.first.name == GROUND.name:
            along = np.array(guide.along) / np.hypot(*guide.along)
            travel = along[0] * sol.array(f"{body.name}.x") + along[1] * sol.array(f"{body.name}.y")
            rows.append((f"stroke of {body.name}", f"{np.ptp(travel):.6g} m"))
        else:
            rows.append((f"swing of {body.name}", f"{np.ptp(sol.array(f'{body.name}.theta')):.6g} rad"))
    rows += [("note", text) for text in sol.notes]
    lines = [f"{name:<22s}{text}" for name, text in rows]
    peaks = [(name, sol.peak(name)) for name in main_signals(sol)]
    if peaks:
        lines += ["", f"{'largest absolute value':<34s}{'of all steps':>14s}          at t [s]"]
        lines += [f"  {name:<32s}{p.value:>14.6g} {sol.units(name):<8s}{p.time:>9.6g}" for name, p in peaks]
    return "\n".join(lines)


COMMAND = "command"  # name of the arguments of `flexmb run` in `Solution.model`
OUTPUT = ("--out", "--frames", "--checkpoint")
# Options of output, with values and without, which are not repeated.
FLAGS = ("--resume", "--no-vtk", "--no-plots", "--no-report", "--quiet", "--debug")
PERIODS = 2.0  # default length of a run, in periods
METHODS: dict[str, Callable[..., Newmark | RungeKutta4 | DormandPrince]] = {
    name: getattr(Newmark, name.replace("-", "_")) for name in ("generalised-alpha", "hht", "wbz", "trapezoidal")
} | {"runge-kutta": RungeKutta4, "dormand-prince": DormandPrince}
WITH_NUMBER = ("generalised-alpha", "hht", "wbz")  # methods that take a number


def run(mechanism: Mechanism, name: str, options: argparse.Namespace) -> int:
    """`flexmb run`: simulate a mechanism and write all files; returns 0 if the run reached its end, else 1."""
    folder = Path(options.out or Path("out") / name)
    if not options.no_vtk:
        checks.count("run", "--frames", options.frames, 2)
    require_those_of(options)
    require_folder(folder)
    path = folder / f"{name}.checkpoint.nc"
    every = quantity(options.checkpoint, "s", "--checkpoint")
    note = f"there is no {path}; the run starts at the beginning."
    if not options.resume:
        note = f"{path} is of an interrupted run, which --resume continues; this run starts anew."
    with drawing_process(options) as painter:
        keywords = keywords_of_run(mechanism, options)
        if path.is_file() != options.resume and not options.quiet:
            print(f"flexmb: {note}", file=sys.stderr)
        keywords |= {"checkpoint": path, "checkpoint_every": every, "resume": options.resume}
        with removed_after() as checkpoints:
            sol = simulate(mechanism, progress=not options.quiet, **keywords)
            sol = replace(sol, model={**sol.model, COMMAND: without_output(options.arguments)})
            if not options.quiet:
                print(f"flexmb: files are written to {folder}.", file=sys.stderr, flush=True)
            written = [sol.to_netcdf(folder / f"{name}.nc")]  # before the pictures, which can be drawn again
        lost = _write_rest(mechanism, sol, folder, name, options, written, painter)
    tell(table(mechanism, sol), written, *(one.failure for one in checkpoints), lost, "" if sol.ok else sol.status)
    return 0 if sol.ok and not lost else 1


def without_output(arguments: Sequence[str]) -> list[str]:
    """Arguments of `flexmb run` without output options."""
    values = [False, *(text in OUTPUT for text in arguments)]
    pairs = zip(arguments, values, strict=False)
    return [text for text, is_value in pairs if not is_value and text.partition("=")[0] not in (*OUTPUT, *FLAGS)]


def keywords_of_run(mechanism: Mechanism, options: argparse.Namespace) -> dict[str, Any]:
    """Keywords of `simulate` for times, steps, method and restart."""
    restart = {} if options.restart is None else {"restart": load(options.restart).restart}
    # End of the run and begin of saving, as keywords of `simulate`
    keywords: dict[str, Any] = {}
    for name, unit in {"t_end": "s", "periods": "", "save_from_period": ""}.items():
        if vars(options)[name] is not None:
            keywords[name] = quantity(vars(options)[name], unit, f"--{name.replace('_', '-')}")
    if options.save is not None:  # "steps", a time with its unit, or a number of instants
        timed = options.save.rstrip()[-1:].isalpha()
        value: Any = options.save if options.save == "steps" else quantity(options.save, "s" if timed else "", "--save")
        hint = "An interval has a unit: 1ms."
        keywords["save"] = value if timed else checks.count("flexmb run", "--save", value, hint=hint)
    if options.t_end is None and options.periods is None:
        if not periods_of(mechanism):
            text = f"Mechanism {mechanism.name!r} has no periodic drive"
            raise InputError(f"{text}. Say how long it shall run: --t-end 1s.")
        keywords["periods"] = PERIODS
    return {**keywords, **solver_of(options), **restart}


def periods_of(mechanism: Mechanism) -> list[float]:
    """Periods of all periodic drives and clamps [s]."""
    return [period for period in compile_mechanism(mechanism).periods if period is not None]


def solver_of(options: argparse.Namespace) -> dict[str, Any]:
    """Step and method as keywords; options without a value are omitted."""
    method: dict[str, Any] = {}
    if options.method is not None:  # "hht", or "hht:0.05" with a number
        name, colon, number = options.method.partition(":")
        make = METHODS[checks.one_of("--method", "method", name, METHODS)]
        if colon and name not in WITH_NUMBER:
            raise InputError(f"--method: {name!r} takes no number; write --method {name}.")
        method["method"] = make(quantity(number, "", f"--method {name}:")) if colon else make()
    if options.step is not None:
        return {"step": FixedStep(quantity(options.step, "s", "--step")), **method}
    return method if options.rtol is None else {"step": Adaptive(rtol=quantity(options.rtol, "", "--rtol")), **method}


def flow_options(options: argparse.Namespace) -> dict[str, Any]:
    """Period, step and method of a flow as keywords; options without a value are omitted."""
    period = {} if options.period is None else {"period": quantity(options.period, "s", "--period")}
    return {**period, **solver_of(options)}


MOST_SAVED = 100_000_000  # numbers of a solution at most that are handed to another process [1]
PARENT_DEATH_SIGNAL = 1  # option of prctl: the signal that a process gets when the one that made it has ended


@contextmanager
def drawing_process(options: argparse.Namespace) -> Iterator[Executor | None]:
    """A process that loads matplotlib while this one computes, and then draws; None where there is nothing to gain."""
    copies = sys.platform == "linux" and threading.active_count() == 1  # elsewhere a process begins from nothing
    if options.no_plots or not copies or len(os.sched_getaffinity(0)) == 1:
        yield None
        return
    with ProcessPoolExecutor(1, get_context("fork"), _follow, (os.getpid(),)) as pool:
        pool.submit(_load_matplotlib)
        yield pool


def _follow(run: int) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the run, whose pictures are drawn
    ctypes.CDLL(None).prctl(PARENT_DEATH_SIGNAL, signal.SIGKILL)
    if os.getppid() != run:  # it has ended before
        os.kill(os.getpid(), signal.SIGKILL)


def _load_matplotlib() -> None:
    for name in ("scene", "signals"):
        import_module(f"flexmb.show.pictures.{name}")
    import_module("flexmb.show.pictures.style").new_figure((1.0, 1.0)).savefig(BytesIO())


def _draw(sol: Solution, shown: list[list[str]], times: np.ndarray, path: Path) -> None:
    from flexmb.show.pictures.scene import render  # noqa: PLC0415
    from flexmb.show.pictures.signals import plot  # noqa: PLC0415 - only when asked for

    if shown:
        plot(sol, shown).savefig(path, dpi=150)
    else:
        render(sol, times, path=path)


def _write_rest(
    mechanism: Mechanism, sol: Solution, folder: Path, name: str, options: argparse.Namespace, written: list[Path],
    painter: Executor | None,
) -> str:  # fmt: skip
    """Write VTK files and pictures, and add them to `written`; returns the reason of missing files, or ""."""
    from flexmb.show.reports.study_pages import report  # noqa: PLC0415 - only when asked for

    if len(sol.time) < 2:
        return "nothing was saved, so there are no pictures and no VTK files. Run longer, or save earlier."
    shown, missing = panels(sol), []
    pictures, instants = {"signals.png": shown, "mechanism.png": []}, four_instants(mechanism, sol)
    painter = painter if sol.time.size * len(sol.names) <= MOST_SAVED else None
    drawn: dict[str, Callable[[], object]] = {}
    for file, names in list(pictures.items())[0 if shown else 1 :] if not options.no_plots else ():
        here = partial(_draw, sol, names, instants, folder / file)
        drawn[file] = painter.submit(here).result if painter is not None else here
    writers: dict[str, Callable[[], object]] = {}
    if not options.no_vtk:
        writers[f"{name}.pvd"] = partial(write_vtk, sol, folder / f"{name}.pvd", frames=options.frames)
    if not options.no_report:
        writers[REPORT] = partial(report, sol, folder / REPORT, mechanism=mechanism)
    for file, write in (writers | drawn).items():
        try:
            write()
            written.append(folder / file)
        except (FlexmbError, OSError, BrokenExecutor) as error:
            missing.append(f"{file} ({error})")  # the run itself is on disk already
    return f"some files are missing: {'; '.join(missing)}" if missing else ""


def four_instants(mechanism: Mechanism, sol: Solution) -> np.ndarray:
    """Four instants, evenly spread over the last period of the slowest drive."""
    first, last = float(sol.time[0]), float(sol.time[-1])
    longest = max(periods_of(mechanism), default=last - first)
    return np.linspace(max(first, last - longest), last, 5)[:4]
