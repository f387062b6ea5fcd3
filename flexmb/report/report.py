"""Report of a run as one HTML page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from flexmb import checks
from flexmb.errors import InputError
from flexmb.model.mechanism import Mechanism
from flexmb.report.run_page import write_run
from flexmb.results.solution import Solution

MOST_FRAMES = 1000
"""Default number of frames at most."""

ENDINGS = {".html", ".htm"}


def report(
    result: Solution,
    path: str | Path,
    *,
    mechanism: Mechanism | None = None,
    frames: int = MOST_FRAMES,
    signals: Sequence[str] | None = None,
    title: str | None = None,
) -> Path:
    """One HTML page with the moving mechanism, plots, contacts, energies, parts, examination and settings of a run.

    The page is one file that needs no network and forbids any; all browsers since 2023 show it.

    Parameters
    ----------
    result : the solution.
    path : the file, which ends in .html; missing folders are made, an older file is replaced.
    mechanism : the mechanism that moved, for the examination of a solution that was read from a file; None: the one
        that the solution knows.
    frames : number of frames at most, >= 2; of longer runs the saved instants nearest to even times are shown, and
        plots become envelopes, whose smallest and largest values are those of all saved instants.
    signals : names of the signals of the plots, and patterns in which * stands for any text; None: the main signals,
        energies, and others up to 24.
    title : title of the page; None: name of the mechanism.

    Returns
    -------
    Path : the file.

    Raises
    ------
    InputError : another kind of result, a solution without saved instants, an unknown signal, fewer than 2 frames, a
        path that does not end in .html or cannot be written.
    """
    if not isinstance(result, Solution):
        text = f"report: result is {type(result).__name__}"
        raise InputError(f"{text}; it must be a Solution, as simulate and load return.")
    if mechanism is not None and not isinstance(mechanism, Mechanism):
        raise InputError(f"report: mechanism is {mechanism!r}; it must be a Mechanism.")
    target = checks.path("report", path)
    if target.suffix.lower() not in ENDINGS:
        raise InputError(f"report: path is {str(path)!r}; it must end in .html.")
    return write_run(result, target, mechanism, checks.count("report", "frames", frames, 2), signals, title)
