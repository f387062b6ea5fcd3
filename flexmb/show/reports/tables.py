"""Tables of a page: parts of a mechanism, peaks, energies, statistics and settings of a run."""

from __future__ import annotations

import platform
import shlex
from collections.abc import Mapping
from typing import Any

import numpy as np

from flexmb.display import pretty
from flexmb.findings.finding import SEVERITIES
from flexmb.findings.report import Report
from flexmb.model.mechanism import part_facts
from flexmb.results.naming import ENERGIES
from flexmb.results.solution import Solution
from flexmb.results.solution import facts as facts_of
from flexmb.show.reports.document import Content, Markup, facts, joined, number, quantity, section, table, tag
from flexmb.version import installed_version

# Tables of the parts of a mechanism: bodies, joints, loads, with their numbers, sections, materials and laws

UNKNOWN = (
    "The file of this solution knows no mechanism: it was written by hand or by an earlier version. "
    "report(sol, path, mechanism=mech) shows its parts and examines them."
)
NOT_EXAMINED = (
    "Not examined: files hold the numbers of a mechanism, not the mechanism itself. "
    "report(sol, path, mechanism=mech) examines it."
)


def model_section(sol: Solution, description: Mapping[str, Any]) -> Markup:
    """Section of all parts, in plain values (see `flexmb.model.mechanism`); empty: unknown."""
    parts = description.get("parts", [])
    if not parts:
        names = ", ".join(dict.fromkeys(name.partition(".")[0] for name in sol.names)) or "no part"
        return section("Model", tag("p", UNKNOWN), facts([("signals of", names)]), anchor="model")
    known = part_facts(description)
    bodies = [part for part in known if part.is_body]
    others = [[p.name, p.kind, p.connects, p.values] for p in known if not p.is_body]
    gx, gy = description.get("gravity", (0.0, 0.0))
    summary = [
        ("parts", f"{len(parts)}"),
        ("mass", quantity(sum(part.mass or 0.0 for part in bodies), "kg")),
        ("gravity", f"({number(gx)}, {number(gy)}) {pretty('m/s^2')}"),
    ]
    rows = [[p.name, p.kind, "-" if p.mass is None else number(p.mass), p.values] for p in bodies]
    return section(
        "Model",
        facts(summary),
        table("Bodies", ["name", "class", "mass [kg]", "values"], rows, numbers=[2]) if bodies else None,
        table("Joints, drives, loads and other parts", ["name", "class", "between", "values"], others)
        if others
        else None,
        anchor="model",
    )


def check_section(report: Report | str) -> Markup:
    """Section of the examination of the mechanism, a result of `check`, or the reason why there is none."""
    if isinstance(report, str):
        return section("Examination", tag("p", report), anchor="check")
    counts = [(sum(f.severity == severity for f in report.findings), severity) for severity in SEVERITIES]
    words = ", ".join(f"{count} {word}{'' if count == 1 else 's'}" for count, word in counts if count)
    rows: list[tuple[str, Content]] = [
        ("findings", words or "nothing to remark"),
        ("degrees of freedom", f"{report.freedom} (rigid bodies, clearances closed), {report.free} not driven"),
        ("equations", f"{report.coordinates} coordinates, {report.rows} constraint rows"),
        ("natural frequencies", ", ".join(number(f, 4) for f in report.frequencies) + " Hz")
        if report.frequencies
        else ("natural frequencies", "none"),
    ]
    found = [[tag("span", f.severity, class_=f"badge {f.severity}"), f.code, f.text, f.remedy] for f in report.findings]
    heads = ["severity", "code", "finding", "remedy"]
    return section("Examination", facts(rows), table("Findings", heads, found) if found else None, anchor="check")


# Tables of a run: peaks, balance of energies, statistics, settings and versions

CAPTION = "Energies [J] at the first and the last saved instant, and their largest absolute values"


def peaks_table(sol: Solution, names: list[str]) -> Markup:
    """Largest absolute values of signals over all accepted steps."""
    rows: list[list[Content]] = []
    for name in names:
        peak = sol.peak(name)
        go = tag("button", number(peak.time), type="button", class_="go", data_time=repr(peak.time))
        rows.append([name, number(peak.value), pretty(sol.units(name)), go])
    heads = ["signal", "largest absolute value", "unit", "at t [s]"]
    return table("Largest absolute values of all accepted steps", heads, rows, numbers=[1])


def energy_section(sol: Solution) -> Markup | None:
    """Section of the balance of energies; None for a solution without energies."""
    names = {key: f"energy.{key}" for key in ENERGIES if f"energy.{key}" in sol}
    if not names or not len(sol.time):
        return None
    rows = []
    for key, name in names.items():
        first, last = sol.array(name)[[0, -1]]
        rows.append([ENERGIES[key], number(first), number(last), number(sol.peak(name).value)])
    heads = ["energy", "first", "last", "largest"]
    made = table(CAPTION, heads, rows, numbers=[1, 2, 3])
    share = None
    if {"residual", "turned_over"} <= names.keys() and sol.peak(names["turned_over"]).value > 0.0:
        part = sol.peak(names["residual"]).value / sol.peak(names["turned_over"]).value
        share = tag("p", f"The largest residual is {part:.2g} of the energy turned over.")
    plot = tag("div", class_="plots", id="energy-plots")
    return section("Balance of energies", share, tag("div", plot, made, class_="pair"), anchor="energy")


def statistics_section(sol: Solution) -> Markup:
    """Section of status, facts and notes of a run."""
    rows = [("status", sol.status), *((fact.label, fact.text) for fact in facts_of(sol))]
    notes = tag("ul", *(tag("li", note) for note in sol.notes), class_="notes") if sol.notes else None
    return section("Statistics", facts(rows), tag("h3", "Notes") if notes else None, notes, anchor="statistics")


def settings_section(sol: Solution, frames: int) -> Markup:
    """Section of settings, versions and the command of a run."""
    model = dict(sol.model)
    command = model.pop("command", None)
    rows: list[tuple[str, Content]] = [("command", tag("code", command_text(command)))] if command else []
    rows += [("mechanism", sol.name), ("frames here", f"{frames} of {len(sol.time)} saved instants")]
    rows += [(key, _short(value)) for key, value in model.items() if key not in ("name", "flexmb", "version")]
    written = model.get("flexmb", model.get("version", "unknown"))
    here = f"flexmb {installed_version()}, Python {platform.python_version()}, numpy {np.__version__}"
    rows += [("computed by", f"flexmb {written}"), ("page written by", here)]
    return section("Settings and versions", facts(rows), anchor="settings")


def command_text(arguments: Any) -> str:
    """Command line of a run from its stored arguments."""
    words = arguments if isinstance(arguments, list) else [arguments]
    return shlex.join(["flexmb", *map(str, words)])


def _short(value: Any) -> str:
    text = value if isinstance(value, str) else ", ".join(map(str, value)) if isinstance(value, list) else str(value)
    return text if len(text) <= 400 else f"{text[:400]} ..."


def key_numbers(sol: Solution) -> Markup:
    """State and first numbers of a run, for the head of a page; its status where it tells more than the end."""
    badge = tag("span", "finished" if sol.ok else "not finished", class_=f"badge {'good' if sol.ok else 'error'}")
    span = f"{quantity(sol.time[0], 's')} to {quantity(sol.time[-1], 's')}"
    text = f"{span}, {len(sol.time)} saved instants, {sol.stats.steps} steps, {sol.stats.wall_time:.3g} s of computing"
    numbers = tag("p", badge, Markup(" "), tag("span", text), class_="key-numbers")
    if sol.ok and ". " not in sol.status:
        return numbers
    kind = "warning" if sol.ok else "error"
    return joined([numbers, tag("p", sol.status, class_=f"told {kind}", role="status")])
