"""Options of the commands and of mechanisms, and arguments in the file of a run."""

from __future__ import annotations

import argparse
import inspect
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flexmb.cli.arguments.units import known_unit, quantity
from flexmb.docstrings import parameters, units
from flexmb.engine.step.step_size import RTOL
from flexmb.errors import FileFormatError, InputError
from flexmb.results.netcdf import load

# Arguments of `flexmb run` in the file of a run

COMMAND = "command"
"""Name of the arguments of `flexmb run` in `Solution.model`."""


def arguments_of(path: Path, given: str | None) -> list[str]:
    """Arguments of `flexmb run` that repeat a saved run of the mechanism `given`, a name or FILE.py.

    None: the ready mechanism named in the file; a run of a user's file is refused without `given`.
    """
    command = load(path).model.get(COMMAND)
    if not isinstance(command, list) or len(command) < 2 or command[0] != "run":
        raise FileFormatError(f"{str(path)!r}: does not say how it was made; `flexmb run` writes such files.")
    if given is None and ".py" in command[1]:
        text = f"{str(path)!r} is a run of {command[1]}, a file that would be executed"
        raise InputError(f"{text}. Name it if you trust it: flexmb rerun {path} {command[1]}")
    return ["run", given or command[1], *map(str, command[2:])]


def without_output(arguments: Sequence[str]) -> list[str]:
    """Arguments of `flexmb run` without output options."""
    kept: list[str] = []
    skip = False
    for text in arguments:
        if skip:
            skip = False
        elif text in ("--out", "--frames", "--checkpoint"):
            skip = True
        elif not text.startswith(("--out=", "--frames=", "--checkpoint=", "--resume", "--quiet", "--no-", "--debug")):
            kept.append(text)
    return kept


# Options of the command line from the signature and docstring of a function that returns a mechanism

Maker = Callable[..., Any]
KINDS = {"bool": "flag", "float": "number", "int": "count", "str": "text"}


@dataclass(frozen=True)
class Option:
    """A parameter of a function, as an option.

    Parameters
    ----------
    name : name of the parameter.
    kind : "number", "count", "numbers" (a tuple), "flag" or "text".
    default : default value, or `inspect.Parameter.empty`.
    unit : SI unit, "" for none.
    help : description in the docstring.
    """

    name: str
    kind: str
    default: Any
    unit: str
    help: str

    @property
    def flag(self) -> str:
        """Name of the option on the command line."""
        return "--" + self.name.replace("_", "-")

    @property
    def is_required(self) -> bool:
        """Whether the parameter has no default."""
        return self.default is inspect.Parameter.empty

    def value(self, text: str) -> Any:
        """Argument of the function for a typed `text`."""
        if text.lower() == "none" and (self.kind == "text" or self.default is None):
            return None
        if self.kind == "text":
            return text
        if self.kind == "numbers":
            return tuple(quantity(part, self.unit, self.flag) for part in text.split(","))
        number = quantity(text, self.unit, self.flag)
        if self.kind == "count":
            if number != int(number):
                raise InputError(f"{self.flag}: {text!r} is no whole number.")
            return int(number)
        return number


def options_of(maker: Maker) -> list[Option]:
    """Options for the parameters of a function that are numbers, tuples of numbers, flags or texts.

    Units are read from the numpydoc docstring, in brackets: "length : length of the rod [m]".  Other parameters, such
    as laws or materials, have no option.
    """
    described = parameters(maker)
    options = []
    for parameter in _signature(maker).parameters.values():
        kind = _kind(parameter)
        if kind:
            text = described.get(parameter.name, "")
            options.append(Option(parameter.name, kind, parameter.default, _unit(text), text))
    return options


def add_options(parser: argparse.ArgumentParser, maker: Maker, title: str) -> list[Option]:
    """Add the options of a function to a parser, in a group with a title; returns them."""
    options = options_of(maker)
    group = parser.add_argument_group(title)
    for option in options:
        help_text = (option.help + shown_default(option)).replace("%", "%%")
        common: dict[str, Any] = {"dest": f"maker.{option.name}", "default": argparse.SUPPRESS, "help": help_text}
        if option.kind == "flag":
            group.add_argument(option.flag, action=argparse.BooleanOptionalAction, **common)
        else:
            group.add_argument(option.flag, metavar=_metavar(option), required=option.is_required, **common)
    return options


def keywords_of(arguments: argparse.Namespace, options: list[Option]) -> dict[str, Any]:
    """Keywords of the function from the typed options."""
    given = vars(arguments)
    keywords = {}
    for option in options:
        if f"maker.{option.name}" in given:
            value = given[f"maker.{option.name}"]
            keywords[option.name] = value if option.kind == "flag" else option.value(value)
    return keywords


def shown_default(option: Option) -> str:
    """Default of an option, as a text for its help."""
    if option.is_required:
        return " (must be given)"
    if option.kind == "flag" or option.default is None:
        return ""
    values = option.default if isinstance(option.default, tuple) else (option.default,)
    shown = ",".join(f"{value:.6g}" if isinstance(value, float) else str(value) for value in values)
    return f" (default {shown}{' ' + option.unit if option.unit else ''})"


def _signature(maker: Maker) -> inspect.Signature:
    """Signature of a function with evaluated annotations, if possible; aliases are then resolved."""
    try:
        return inspect.signature(maker, eval_str=True)
    except NameError:  # imported for type checking only
        return inspect.signature(maker)


def _kind(parameter: inspect.Parameter) -> str:
    """Kind of the option for a parameter, "" for none; from the annotation, else from the default."""
    if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD, parameter.POSITIONAL_ONLY):
        return ""
    bare = parameter.annotation is parameter.empty
    words = set(re.findall(r"\w+", "" if bare else inspect.formatannotation(parameter.annotation)))
    if "tuple" in words:
        return "numbers" if "float" in words else ""
    return next(
        (kind for word, kind in KINDS.items() if word in words), KINDS.get(type(parameter.default).__name__, "")
    )


def _unit(text: str) -> str:
    """First unit in brackets in `text` that is a unit of the command line; "" without one."""
    return next(filter(None, map(known_unit, units(text))), "")


def _metavar(option: Option) -> str:
    return {"number": "X", "count": "N", "numbers": "X,Y", "text": "TEXT"}[option.kind]


# Options of the commands beside the options of a mechanism

TANGENT_METHODS = "methods of `flexmb run` except runge-kutta"
QUIET = "no progress and no messages; the summary is printed"
SHELLS = ("bash", "zsh", "fish")


def add_run(run: argparse.ArgumentParser) -> None:
    """Options of `flexmb run`."""
    time = run.add_argument_group("time")
    end = time.add_mutually_exclusive_group()
    end.add_argument("--periods", metavar="X", help="length of the run in periods of the drives (default 2)")
    end.add_argument("--t-end", metavar="TIME", help="length of the run, e.g. 0.5s")
    time.add_argument("--save-from-period", metavar="X", help="first saved period, also for peaks (default 0)")
    time.add_argument(
        "--save", metavar="N", help="saved instants a period, an interval as 1ms, or `steps` (default 1000)"
    )
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
    files.add_argument("--no-plots", action="store_true", help="no pictures")
    files.add_argument("--no-report", action="store_true", help="no report.html")
    files.add_argument("--quiet", action="store_true", help=QUIET)


def add_sweep(sweep: argparse.ArgumentParser) -> None:
    """Options of `flexmb sweep`."""
    group = sweep.add_argument_group(
        "sweep", "Give one option of the mechanism a range: --speed 0.5pi:2.5pi:50, or values: 1,2,4."
    )
    group.add_argument(
        "--vary", metavar="PART.FIELD=RANGE", help="range of a field of a part, e.g. P1.clearance=0.1mm:1mm:10"
    )
    group.add_argument("--skip", type=int, metavar="N", default=50, help="periods before the first point (default 50)")
    keep = "points at each value (default 100, the fewest for chaos without --exponent)"
    group.add_argument("--keep", type=int, metavar="N", default=100, help=keep)
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
    files.add_argument("--no-report", action="store_true", help="no bifurcation.html")
    files.add_argument("--quiet", action="store_true", help=QUIET)


def add_chaos(chaos: argparse.ArgumentParser) -> None:
    """Options of `flexmb chaos`."""
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
    files.add_argument("--no-report", action="store_true", help="no chaos.html")
    files.add_argument("--quiet", action="store_true", help=QUIET)


def add_check(check: argparse.ArgumentParser) -> None:
    """Options of `flexmb check`."""
    check.add_argument("--step", metavar="TIME", help="fixed step that a run is to take: is it short enough?")
    check.add_argument("--json", action="store_true", help="print the report as JSON")


def add_vtk(vtk: argparse.ArgumentParser) -> None:
    """Options of `flexmb vtk`."""
    vtk.add_argument("file", metavar="RUN.nc", type=Path, help="file of `flexmb run`")
    vtk.add_argument("--frames", type=int, metavar="N", help="number of frames (default: all instants, at most 200)")
    vtk.add_argument("--out", type=Path, metavar="PLACE", help="a folder, or FILE.pvd (default: beside RUN.nc)")


def add_report(report: argparse.ArgumentParser) -> None:
    """Options of `flexmb report`."""
    report.add_argument("file", metavar="RUN.nc", type=Path, help="file of `flexmb run`, `sweep` or `chaos`")
    trusted = "the mechanism; needed for its examination where the file is of a run of FILE.py, which is executed"
    report.add_argument("name", metavar="NAME", nargs="?", help=trusted)
    report.add_argument("--out", type=Path, metavar="FILE.html", help="default: report.html beside a run")
    report.add_argument("--frames", type=int, metavar="N", default=1000, help="most frames (default 1000)")


def add_animate(film: argparse.ArgumentParser) -> None:
    """Options of `flexmb animate`."""
    film.add_argument("file", metavar="RUN.nc", type=Path, help="file of `flexmb run`")
    film.add_argument("--out", metavar="FILE", required=True, help="the film: .mp4, .gif, or .html (report)")
    film.add_argument("--seconds", metavar="TIME", default="4s", help="length of the film (default 4s)")
    film.add_argument("--fps", metavar="N", default="25", help="frames a second (default 25)")
    film.add_argument("--from", dest="begin", metavar="TIME", help="begin of the motion (default: of the run)")
    film.add_argument("--to", dest="end", metavar="TIME", help="end of the motion (default: of the run)")
    film.add_argument("--magnify", metavar="X", default="1", help="factor of the deformation (default 1)")
    colours = "colours: moment (default), axial or shear of beams, von_mises of meshes, or none"
    film.add_argument("--colour", metavar="NAME", default="moment", help=colours)
    film.add_argument("--traces", metavar="A,B", help="points whose paths are drawn, or all (default: some markers)")
    film.add_argument("--forces", metavar="A,B", help="joints whose forces are drawn, or all (default: none)")
    film.add_argument("--follow", metavar="NAME", help="body, node or marker that stays in the middle (default: none)")
    film.add_argument("--size", metavar="WxH", help="width and height in pixels, e.g. 600x400")


def add_plot(picture: argparse.ArgumentParser) -> None:
    """Options of `flexmb plot`."""
    picture.add_argument("file", metavar="RUN.nc", type=Path, help="file of `flexmb run`")
    texts = "a signal a panel, e.g. slider.ax; signals joined by commas share a panel"
    picture.add_argument("signals", metavar="SIGNAL", nargs="+", help=texts)
    picture.add_argument("--out", metavar="FILE", required=True, help="the picture: .png, .pdf, .svg")
    picture.add_argument("--x", metavar="SIGNAL", default="time", help="signal of the abscissa (default time)")
    picture.add_argument("--title", metavar="TEXT", help="title of the picture (default: name of the mechanism)")


def add_rerun(rerun: argparse.ArgumentParser) -> None:
    """Options of `flexmb rerun`."""
    rerun.add_argument("file", metavar="RUN.nc", type=Path, help="file of `flexmb run`")
    trusted = "the mechanism; needed where the file is of a run of FILE.py, which is executed"
    rerun.add_argument("name", metavar="NAME", nargs="?", help=trusted)
    rerun.add_argument("--quiet", action="store_true", help=QUIET)


def add_new(new: argparse.ArgumentParser) -> None:
    """Options of `flexmb new`."""
    new.add_argument("file", metavar="NAME", type=Path, help="name of the model; the file is NAME.py")
    new.add_argument("--force", action="store_true", help="replace an existing file")


def add_completion(completion: argparse.ArgumentParser) -> None:
    """Options of `flexmb completion`."""
    completion.add_argument("shell", metavar="SHELL", choices=SHELLS, help="bash, zsh or fish")


def add_nothing(command: argparse.ArgumentParser) -> None:
    """No options."""


def _add_method(command: argparse.ArgumentParser, names: str) -> argparse._ArgumentGroup:
    """Add the options for step and method, which all commands with a motion have."""
    solver = command.add_argument_group("method")
    step = solver.add_mutually_exclusive_group()
    step.add_argument("--step", metavar="TIME", help="fixed step, e.g. 10us (default: error-controlled steps)")
    step.add_argument("--rtol", metavar="X", help=f"relative tolerance of the velocities in a step (default {RTOL:g})")
    solver.add_argument("--method", metavar="NAME", help=names)
    return solver
