"""Commands on saved runs: films, pictures, pages, VTK files, repetition."""

from __future__ import annotations

import argparse
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np

from flexmb.cli.arguments.options import COMMAND, arguments_of, keywords_of
from flexmb.cli.arguments.parser import parser_of, source_of
from flexmb.cli.arguments.units import quantity
from flexmb.cli.run import REPORT, keywords_of_run
from flexmb.dynamics.jobs.files import READ_ERRORS, load_netcdf
from flexmb.errors import InputError
from flexmb.model.mechanism import Mechanism
from flexmb.results.netcdf import load
from flexmb.results.solution import Solution
from flexmb.results.vtk import write_vtk
from flexmb.run.simulate import simulate
from flexmb.show.reports.chaos_page import write_chaos
from flexmb.show.reports.report import report as page_of
from flexmb.version import installed_version

if TYPE_CHECKING:
    import xarray as xr

# `flexmb plot`: signals of a saved run as a picture


def plot(options: argparse.Namespace) -> int:
    """`flexmb plot`: draw signals of a saved run, and print the path of the picture."""
    from flexmb.show.pictures.signals import (  # noqa: PLC0415 - matplotlib when a picture is asked for
        plot as picture_of,
    )

    panels = [names_of(text) for text in options.signals]
    figure = picture_of(load(options.file), panels, title=options.title, x=options.x)
    target = Path(options.out)
    figure.savefig(target, dpi=150)
    print(target)
    return 0


def names_of(text: str | None) -> list[str]:
    """Names in a text, separated by commas."""
    return [name.strip() for name in (text or "").split(",") if name.strip()]


def pixels(text: str | None) -> tuple[int, int] | None:
    """Width and height in a text such as 600x400; None without a text."""
    if text is None:
        return None
    found = re.fullmatch(r"(\d+)x(\d+)", text)
    if found is None:
        raise InputError(f"--size: {text!r} is no size; write width and height in pixels, e.g. 600x400.")
    return int(found[1]), int(found[2])


# `flexmb animate`: film of a saved run

ALL = "all"
"""Text that stands for all markers or joints."""


def animate(options: argparse.Namespace) -> int:
    """`flexmb animate`: write the film of a saved run, and print its path."""
    from flexmb.show.pictures.films import animate as film  # noqa: PLC0415 - matplotlib when a picture is asked for

    seconds, fps = quantity(options.seconds, "s", "--seconds"), quantity(options.fps, "", "--fps")
    magnify = quantity(options.magnify, "", "--magnify")
    size = pixels(options.size)
    sol = load(options.file)
    times = None
    if (options.begin is not None or options.end is not None) and len(sol.time):
        begin = float(sol.time[0]) if options.begin is None else quantity(options.begin, "s", "--from")
        end = float(sol.time[-1]) if options.end is None else quantity(options.end, "s", "--to")
        times = (begin, end)
    print(
        film(
            sol,
            options.out,
            seconds=seconds,
            fps=fps,
            times=times,
            magnify=magnify,
            colour=None if options.colour == "none" else options.colour,
            traces=True if options.traces == ALL else names_of(options.traces) or None,
            forces=True if options.forces == ALL else names_of(options.forces),
            size=size,
            follow=options.follow,
        )
    )
    return 0


# `flexmb report`: HTML page of a saved run

GROUPS = ("", "motion")
"""Groups of a file of `flexmb chaos` that are drawn."""


def report(options: argparse.Namespace) -> int:
    """`flexmb report`: write the page of a saved run, with its mechanism if the file or the user names it."""
    if groups := datasets_of(options.file):
        print(write_diagram(groups, options.out or options.file.with_suffix(".html")))
        return 0
    target = options.out or options.file.with_name(REPORT)
    sol = load(options.file)
    print(page_of(sol, target, mechanism=_mechanism(sol, options.name), frames=options.frames))
    return 0


def _mechanism(sol: Solution, name: str | None) -> Mechanism | None:
    """Mechanism of a saved run, declared again; None where it is unknown."""
    given = repeated_command(sol, name)
    source = source_of(given)
    if source is None:
        return None
    parser, maker_options = parser_of(source, "run")
    options = parser.parse_args(given)
    changed = source.with_changes(options.set)
    return changed.mechanism(keywords_of(options, maker_options))


def datasets_of(path: Path) -> dict[str, xr.Dataset]:
    """Datasets of a file of `flexmb sweep` or `flexmb chaos` by group; {} for another file."""
    try:
        with h5py.File(path, "r") as file:
            kind = file.attrs.get("kind", b"")
    except READ_ERRORS:
        return {}
    if kind not in ("bifurcation", "chaos", b"bifurcation", b"chaos"):
        return {}
    return load_netcdf(path, GROUPS)


def write_diagram(groups: dict[str, xr.Dataset], path: Path) -> Path:
    """Page of a diagram or of a study of a motion."""
    if groups[""].attrs["kind"] == "chaos":
        return write_chaos(groups, path, None, None)
    return page_of(groups[""], path)


def repeated_command(sol: Solution, given: str | None) -> list[str]:
    """Arguments of `flexmb run` with which the mechanism of a saved run can be built; [] for an unknown mechanism."""
    command = sol.model.get(COMMAND)
    if not isinstance(command, list) or len(command) < 2 or command[0] != "run":
        return [] if given is None else ["run", given]
    if given is None and ".py" in command[1]:
        return []
    return ["run", given or command[1], *map(str, command[2:])]


# `flexmb vtk`: VTK files of a saved run


def vtk(options: argparse.Namespace) -> int:
    """`flexmb vtk`: write the VTK files of a saved run, and print the name of their list."""
    print(write_vtk(load(options.file), place_of(options.file, options.out), frames=options.frames))
    return 0


def place_of(file: Path, out: Path | None) -> Path:
    """The .pvd file: beside the run, in the folder `out`, or `out` itself where it has an ending."""
    if out is None:
        return file.with_suffix(".pvd")
    return out / f"{file.stem}.pvd" if out.is_dir() or not out.suffix else out


# `flexmb rerun`: repeat a saved run and compare the results

SAME, AGREES = 0.0, 1e-9
"""Relative differences: of equal runs; largest at the begin of runs that agree up to round-off."""

DIVERGED = 1e-3
"""Relative difference above which two runs have diverged."""

BEGIN = 0.05
"""Share of the instants that are the begin of a run."""

EQUAL, DIFFERENT = 0, 1
"""Exit codes of runs that agree and of runs that differ."""


@dataclass(frozen=True)
class Comparison:
    """Comparison of two runs.

    Parameters
    ----------
    largest : largest difference, relative to the range of its signal.
    signal : name of the signal with the largest difference.
    at_begin : largest relative difference at the begin of the run.
    parted : first instant with a relative difference above 1e-3 [s]; None: no such instant.
    """

    largest: float
    signal: str
    at_begin: float
    parted: float | None

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
    """`flexmb rerun`: repeat the run of a file with its own arguments, and print the comparison.

    Returns 0 if the runs agree, else 1.
    """
    given = arguments_of(options.file, options.name)
    source = source_of(given)
    parser, maker_options = parser_of(source, "run")
    again = parser.parse_args(given)
    if source is None:
        raise InputError(f"{options.file}: names no mechanism. Name it: flexmb rerun {options.file} NAME")
    mechanism = source.with_changes(again.set).mechanism(keywords_of(again, maker_options))
    progress = not options.quiet
    return tell(options.file, simulate(mechanism, progress=progress, **keywords_of_run(mechanism, again)))


def compare(one: Solution, other: Solution) -> Comparison:
    """Differences of the saved signals of two runs, which must have the same signals and instants."""
    if one.signals != other.signals or not np.array_equal(one.time, other.time):
        raise InputError("rerun: the runs have other signals or instants; they are of other mechanisms or arguments.")
    ranges = np.maximum(np.ptp(one.values, axis=0), 1e-9 * np.abs(one.values).max(axis=0))
    with np.errstate(all="ignore"):
        part = np.nan_to_num(np.abs(one.values - other.values) / np.where(ranges > 0.0, ranges, 1.0), nan=np.inf)
    part[np.isnan(one.values) & np.isnan(other.values)] = 0.0
    worst = part.max(axis=1)
    place = int(np.argmax(part.max(axis=0)))
    parted = np.flatnonzero(worst > DIVERGED)
    begin = worst[: max(2, int(BEGIN * len(worst)))].max()
    return Comparison(
        float(worst.max()), one.names[place], float(begin), float(one.time[parted[0]]) if len(parted) else None
    )


def tell(path: Path, again: Solution) -> int:
    """Print the comparison of a saved run with its repetition; exit code 0 if they agree."""
    saved = load(path)
    found = compare(saved, again)
    print(found)
    if saved.model.get("flexmb") != installed_version():
        print(f"The file was written by flexmb {saved.model.get('flexmb')}, this is {installed_version()}.")
    return EQUAL if found.good and saved.status == again.status else DIFFERENT
