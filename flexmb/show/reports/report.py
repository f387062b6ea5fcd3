"""Report as one HTML page: of a run, of a bifurcation diagram, of a study of a motion, of a fit."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from flexmb import arguments, checks
from flexmb.dynamics.report import ChaosReport
from flexmb.errors import InputError
from flexmb.late import xr
from flexmb.model.mechanism import Mechanism
from flexmb.results.solution import Solution
from flexmb.show.reports.run_page import write_run
from flexmb.show.reports.study_pages import write_chaos, write_fit, write_sweep

if TYPE_CHECKING:
    from flexmb.design.fitting import Fit

MOST_FRAMES = 1000  # default number of frames at most
ENDINGS = {".html", ".htm"}


@arguments.checked
def report(
    result: Solution | ChaosReport | Fit | xr.Dataset, path: str | Path, *, mechanism: Mechanism | None = None,
    frames: int = MOST_FRAMES, signals: Sequence[str] | None = None, title: str | None = None,
) -> Path:  # fmt: skip
    """One HTML page with the moving mechanism, plots, contacts, energies, parts, examination and settings of a run.

    The page is one file that needs no network and forbids any; all browsers since 2023 show it.  A bifurcation diagram
    is shown with its verdicts, a study of a motion with section, exponents and verdict, a fit with its residuals.

    Parameters
    ----------
    result : the solution; or the dataset of `bifurcation`; or the result of `design.fit` or of `chaos.report`, or a
        dataset that `flexmb chaos` wrote.
    path : the file, which ends in .html; missing folders are made, an older file is replaced.
    mechanism : the mechanism that moved, for the examination of a solution that was read from a file; None: the one
        that the solution knows.
    frames : number of frames at most, >= 2; of longer runs the saved instants nearest to even times are shown, and
        plots become envelopes, whose smallest and largest values are those of all saved instants.
    signals : names of the signals of the plots, and, of a run, patterns in which * stands for any text; None: the main
        signals, energies, and others up to 24.
    title : title of the page; None: name of the mechanism.

    Notes
    -----
    A point of a diagram opens the report of its run, where the folder of the page has one: "PARAMETER-VALUE.html" with
    six digits, such as "speed-6.28319.html".

    Raises
    ------
    InputError : another kind of result, a mechanism with other parts than the one that moved, a solution without saved
        instants, an unknown signal, fewer than 2 frames, a path that does not end in .html or cannot be written.
    """
    target = checks.path("report", path)
    if target.suffix.lower() not in ENDINGS:
        raise InputError(f"report: path is {str(path)!r}; it must end in .html.")
    if mechanism is not None:
        checks.instance("report", "mechanism", mechanism, Mechanism, "a Mechanism")
    most = checks.count("report", "frames", frames, 2)
    if isinstance(result, Solution):
        moved = {part["name"] for part in result.described().get("parts", ())}
        if mechanism is not None and moved and moved != set(mechanism.names):
            others = ", ".join(sorted(moved ^ set(mechanism.names))[:5])
            text = f"report: {mechanism.label} is not the one that moved in the solution of {result.name!r}:"
            raise InputError(f"{text} {others} stand in one of them only. Give the mechanism of this run, or none.")
        return write_run(result, target, mechanism, most, signals, title)
    if isinstance(result, ChaosReport):
        return write_chaos(result.groups, target, signals, title)
    from flexmb.design.fitting import Fit  # takes long to import

    if isinstance(result, Fit):
        return write_fit(result, target, signals, title)
    kind = result.attrs.get("kind") if isinstance(result, xr.Dataset) else None
    if kind == "bifurcation":
        return write_sweep(result, target, signals, title)
    if kind == "chaos":
        return write_chaos({"": result}, target, signals, title)
    wanted = "a Solution, or the dataset of a diagram (fm.bifurcation) or of `flexmb chaos`, or a Fit"
    raise InputError(f"report: result is {type(result).__name__}; it must be {wanted}.")
