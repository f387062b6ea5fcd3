"""`flexmb report`: HTML page of a saved run."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

import h5py

from flexmb.commands.arguments.mechanism_options import keywords_of
from flexmb.commands.arguments.parser import parser_of, source_of
from flexmb.commands.arguments.saved_command import COMMAND
from flexmb.commands.files import REPORT
from flexmb.jobs.files import READ_ERRORS, load_netcdf
from flexmb.model.mechanism import Mechanism
from flexmb.reports.chaos_page import write_chaos
from flexmb.reports.report import report as page_of
from flexmb.results.netcdf import load
from flexmb.results.solution import Solution

if TYPE_CHECKING:
    import xarray as xr

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
