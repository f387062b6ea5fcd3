"""Commands on saved runs: films, pictures, pages, VTK files, repetition."""

import argparse
import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from flexmb.cli.arguments.parser import keywords_of, parser_of, source_of
from flexmb.cli.run import COMMAND, REPORT, keywords_of_run
from flexmb.dynamics.jobs.files import READ_ERRORS, load_netcdf
from flexmb.errors import FileFormatError, InputError
from flexmb.model.mechanism import Mechanism
from flexmb.results.netcdf import load
from flexmb.results.solution import Solution
from flexmb.results.vtk import write_vtk
from flexmb.run.simulate import simulate
from flexmb.show.reports.study_pages import report as page_of
from flexmb.show.reports.study_pages import write_chaos
from flexmb.units import quantity
from flexmb.version import installed_version


def plot(options: argparse.Namespace) -> int:
    """`flexmb plot`: draw signals of a saved run, and print the path of the picture."""
    from flexmb.show.pictures import signals  # noqa: PLC0415 - matplotlib when a picture is asked for

    panels = [names_of(text) for text in options.signals]
    signals.plot(load(options.file), panels, title=options.title, x=options.x).savefig(options.out, dpi=150)
    print(Path(options.out))
    return 0


def names_of(text: str | None) -> list[str]:
    """Names in a text, separated by commas."""
    return [name.strip() for name in (text or "").split(",") if name.strip()]


ALL = "all"  # text that stands for all markers or joints


def animate(options: argparse.Namespace) -> int:
    """`flexmb animate`: write the film of a saved run, and print its path."""
    from flexmb.show.pictures.films import animate as film  # noqa: PLC0415 - matplotlib when a picture is asked for

    units = {"seconds": "s", "fps": "", "magnify": ""}
    given: dict[str, Any] = {name: quantity(vars(options)[name], unit, f"--{name}") for name, unit in units.items()}
    pixels = re.fullmatch(r"(\d+)x(\d+)", options.size or "")
    if options.size is not None and pixels is None:
        raise InputError(f"--size: {options.size!r} is no size; write width and height in pixels, e.g. 600x400.")
    sol, times = load(options.file), None
    if (options.begin is not None or options.end is not None) and len(sol.time):
        begin = float(sol.time[0]) if options.begin is None else quantity(options.begin, "s", "--from")
        end = float(sol.time[-1]) if options.end is None else quantity(options.end, "s", "--to")
        times = (begin, end)
    colour = None if options.colour == "none" else options.colour
    traces, forces = (text == ALL or names_of(text) for text in (options.traces, options.forces))
    given |= {"traces": traces or None, "forces": forces, "colour": colour, "follow": options.follow}
    size = None if pixels is None else (int(pixels[1]), int(pixels[2]))
    print(film(sol, options.out, times=times, size=size, **given))
    return 0


GROUPS = ("", "motion")  # groups of a file of `flexmb chaos` that are drawn


def report(options: argparse.Namespace) -> int:
    """`flexmb report`: write the page of a saved run, with its mechanism if the file or the user names it."""
    known = False
    with suppress(*READ_ERRORS), h5py.File(options.file, "r") as file:
        known = file.attrs.get("kind", b"") in ("bifurcation", "chaos", b"bifurcation", b"chaos")
    if known:
        groups = load_netcdf(options.file, GROUPS)
        target = options.out or options.file.with_suffix(".html")
        is_chaos = groups[""].attrs["kind"] == "chaos"
        print(write_chaos(groups, target, None, None) if is_chaos else page_of(groups[""], target))
        return 0
    sol, mechanism = load(options.file), None
    command = command_of(sol)
    if options.name is not None or (command and ".py" not in command[1]):
        mechanism, _ = declared_again(command, options.name)
    print(page_of(sol, options.out or options.file.with_name(REPORT), mechanism=mechanism, frames=options.frames))
    return 0


def command_of(sol: Solution) -> list[str]:
    """Arguments of `flexmb run` that a saved run was made with; [] where they are unknown."""
    command = sol.model.get(COMMAND)
    return list(map(str, command)) if isinstance(command, list) and command[1:] and command[0] == "run" else []


def declared_again(command: list[str], name: str | None) -> tuple[Mechanism, argparse.Namespace]:
    """Mechanism of a saved run, of its command or of the given `name`, and the other options of the command."""
    given = ["run", name or command[1], *command[2:]]
    source = source_of(given)
    parser, maker_options = parser_of(source, "run")
    options = parser.parse_args(given)
    if source is None:
        raise InputError(f"the command of the run, {' '.join(given)!r}, names no mechanism. Give it as NAME.")
    return source.with_changes(options.set).mechanism(keywords_of(options, maker_options)), options


def vtk(options: argparse.Namespace) -> int:
    """`flexmb vtk`: write the VTK files of a saved run, and print the name of their list."""
    place = options.out or options.file.with_suffix(".pvd")
    if options.out is not None and (place.is_dir() or not place.suffix):
        place /= f"{options.file.stem}.pvd"
    print(write_vtk(load(options.file), place, frames=options.frames))
    return 0


SAME, AGREES = 0.0, 1e-9  # relative differences: of equal runs; largest at the begin of runs that agree up to round-off
DIVERGED = 1e-3  # relative difference above which two runs have diverged
BEGIN = 0.05  # share of the instants that are the begin of a run
EQUAL, DIFFERENT = 0, 1  # exit codes of runs that agree and of runs that differ


@dataclass(frozen=True)
class Comparison:
    """Comparison of two runs."""

    largest: float  # largest difference, relative to the range of its signal
    signal: str  # name of the signal with the largest difference
    at_begin: float  # largest relative difference at the begin of the run
    parted: float | None  # first instant with a relative difference above 1e-3 [s]; None: no such instant

    @property
    def good(self) -> bool:
        """Whether the runs are equal, or differ by the growth of round-off alone."""
        return self.largest == SAME or self.at_begin < AGREES

    def __str__(self) -> str:
        """Comparison as a sentence."""
        if self.largest == SAME:
            return "The runs are equal to the last bit."
        text = f"The runs differ by {self.largest:.2g} of the range of {self.signal!r} at most"
        if self.parted is None:
            return f"{text}, by {self.at_begin:.2g} at the begin."
        text = f"{text}; they part at t = {self.parted:.6g} s"
        if not self.good:
            return f"{text}, and differ by {self.at_begin:.2g} at the begin already: these are two motions."
        rate = np.log(DIVERGED / np.finfo(float).eps) / self.parted
        return f"{text}, as round-off that grows by exp({rate:.3g} t) does: up to there they are one motion."


def rerun(options: argparse.Namespace) -> int:
    """`flexmb rerun`: repeat a run by its own arguments, print the comparison; 0 if both agree, else 1."""
    saved = load(options.file)
    command = command_of(saved)
    if not command:
        raise FileFormatError(f"{str(options.file)!r}: does not say how it was made; `flexmb run` writes such files.")
    if options.name is None and ".py" in command[1]:
        text = f"{str(options.file)!r} is a run of {command[1]}, a file that would be executed"
        raise InputError(f"{text}. Name it if you trust it: flexmb rerun {options.file} {command[1]}")
    mechanism, given = declared_again(command, options.name)
    again = simulate(mechanism, progress=not options.quiet, **keywords_of_run(mechanism, given))
    found = compare(saved, again)
    print(found)
    if saved.model.get("flexmb") != installed_version():
        print(f"The file was written by flexmb {saved.model.get('flexmb')}, this is {installed_version()}.")
    return EQUAL if found.good and saved.status == again.status else DIFFERENT


def compare(one: Solution, other: Solution) -> Comparison:
    """Differences of the saved signals of two runs, which must have the same signals and instants."""
    if one.signals != other.signals or not np.array_equal(one.time, other.time):
        raise InputError("rerun: the runs have other signals or instants; they are of other mechanisms or arguments.")
    ranges = np.maximum(np.ptp(one.values, axis=0), 1e-9 * np.abs(one.values).max(axis=0))
    with np.errstate(all="ignore"):
        part = np.nan_to_num(np.abs(one.values - other.values) / np.where(ranges > 0.0, ranges, 1.0), nan=np.inf)
    part[np.isnan(one.values) & np.isnan(other.values)] = 0.0
    worst, signal = part.max(axis=1), one.names[int(np.argmax(part.max(axis=0)))]
    parted = next((float(time) for time, size in zip(one.time, worst, strict=True) if size > DIVERGED), None)
    return Comparison(float(worst.max()), signal, float(worst[: max(2, int(BEGIN * len(worst)))].max()), parted)
