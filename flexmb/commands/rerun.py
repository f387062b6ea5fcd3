"""`flexmb rerun`: repeat a saved run and compare the results."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flexmb.commands.arguments.mechanism_options import keywords_of
from flexmb.commands.arguments.parser import parser_of, source_of
from flexmb.commands.arguments.saved_command import arguments_of
from flexmb.commands.run import keywords_of_run
from flexmb.errors import InputError
from flexmb.results.netcdf import load
from flexmb.results.solution import Solution
from flexmb.run.simulate import simulate
from flexmb.version import installed_version

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
