"""Page of a run: the moving mechanism, plots, joints with clearance, tables."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from flexmb.doctor.check import check
from flexmb.doctor.report import Report
from flexmb.errors import FlexmbError, InputError
from flexmb.model.description import described
from flexmb.model.mechanism import Mechanism
from flexmb.reports.clearances import clearance_data, clearance_section
from flexmb.reports.curves import chosen_names, curves, frame_instants
from flexmb.reports.document import write_page
from flexmb.reports.markup import Markup, joined, section, tag
from flexmb.reports.model_tables import NOT_EXAMINED, check_section, model_section
from flexmb.reports.player import player
from flexmb.reports.run_tables import energy_section, key_numbers, peaks_table, settings_section, statistics_section
from flexmb.reports.scene import fields_of, scene
from flexmb.results.main_signals import main_signals
from flexmb.results.solution import Solution

SCRIPTS = ("plots.js", "mesh.js", "scene.js", "drawing.js", "player.js", "journals.js", "run.js")
LINKS = {
    "peaks": "Largest values",
    "clearances": "Clearances",
    "energy": "Energies",
    "statistics": "Statistics",
    "model": "Model",
    "check": "Examination",
    "settings": "Settings",
}
"""Texts of the links to the sections, as far as they are there."""


def write_run(
    sol: Solution, path: Path, mechanism: Mechanism | None, frames: int, signals: Any, title: str | None
) -> Path:
    """Write the page of a run; see `flexmb.report`."""
    if not len(sol.time):
        raise InputError("report: the solution has no saved instants. Save some, e.g. by simulate(..., save=...).")
    names, instants = chosen_names(sol, signals), frame_instants(sol, frames)
    if len(instants) == 0:
        raise InputError("report: no saved instant is finite. Look at sol.status for the end of the run.")
    known = sol.mechanism if mechanism is None else mechanism
    moving, missing = _scene(sol, known, instants)
    data: dict[str, Any] = {"kind": "run", "name": sol.name, "signals": curves(sol, names, instants)}
    data |= {"scene": moving, "journals": clearance_data(sol, instants)}
    heading = sol.name if title is None else title
    shown = tag("p", missing, class_="missing") if moving is None else player(sol, heading, fields=fields_of(moving))
    description = described(known) if known is not None else dict(sol.description)
    sections = joined([_body(sol, shown, known, description), settings_section(sol, len(instants))])
    page = tag("main", sections, id="top")
    links = {anchor: text for anchor, text in LINKS.items() if f'id="{anchor}"' in sections}
    return write_page(path, heading, key_numbers(sol), links, page, SCRIPTS, data)


def _scene(sol: Solution, mechanism: Mechanism | None, instants: np.ndarray) -> tuple[dict[str, Any] | None, str]:
    """Moving mechanism, or None with the reason why it cannot be drawn."""
    if not sol.shapes:
        return None, "The solution has no shapes to draw."
    try:
        return scene(sol, mechanism, instants), ""
    except InputError as error:  # poses that were not saved
        return None, str(error)


def _body(sol: Solution, moving: Markup, mechanism: Mechanism | None, description: dict[str, Any]) -> Markup:
    """All sections but the last one."""
    panels = tag("div", class_="plots", id="plots")
    plots = tag("div", tag("h2", "Signals over the time t [s]"), panels, _more_signals(), class_="signals")
    names = [name for name in main_signals(sol) if name in sol]
    return joined(
        [
            tag("div", moving, plots, class_="stage"),
            section("Largest values", peaks_table(sol, names), anchor="peaks") if names else None,
            clearance_section(sol),
            energy_section(sol),
            statistics_section(sol),
            model_section(sol, description),
            check_section(_examined(mechanism)),
        ]
    )


def _examined(mechanism: Mechanism | None) -> Report | str:
    """Examination of a mechanism, or the reason why there is none."""
    if mechanism is None:
        return NOT_EXAMINED
    try:
        return check(mechanism)
    except FlexmbError as error:
        return f"The examination failed: {error}"


def _more_signals() -> Markup:
    """Choice of a further plot."""
    select = tag("select", tag("option", "Add a plot ...", value=""), id="more-signals", aria_label="Add a plot")
    hint = "Click or drag in a plot to set the time; Shift and drag to zoom in, double click to zoom out."
    return tag("div", select, tag("p", hint, class_="hint"), class_="more")
