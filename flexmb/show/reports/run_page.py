"""Page of a run: the moving mechanism, plots, joints with clearance, tables."""

import platform
import shlex
from collections.abc import Mapping
from itertools import pairwise, zip_longest
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.display import counted, pretty
from flexmb.errors import USER_ERRORS, InputError
from flexmb.findings.check import Report, check
from flexmb.findings.finding import SEVERITIES
from flexmb.model.mechanism import Mechanism, described, values_text
from flexmb.results.contact_intervals import MODES, Episodes
from flexmb.results.drawing import spread_instants
from flexmb.results.netcdf import ENERGIES
from flexmb.results.solution import Solution, contact_facts, facts, matching, require_rows
from flexmb.results.status import main_signals, panels
from flexmb.show.reports import document as html
from flexmb.show.reports.scene import fields_of, player, scene_or_reason
from flexmb.version import installed_version

# Signals of a page: chosen names, their panels, and curves whose peaks survive in long runs

MOST_CURVES = 24  # number of signals on a page where none are chosen
MOST_CHOSEN = 200  # number of chosen signals at most: each takes some 10 kB of a page
MOST_IN_PANEL = 6  # number of signals in a panel at most
ROWS_PER_FRAME = 2  # number of rows of a curve for each frame; longer curves become envelopes
NODE_DOTS = 2  # number of dots in the name of a signal of a node of a flexible part, at least


def chosen_names(sol: Solution, signals: Any) -> list[str]:
    """Names of the signals on the page, the main ones first."""
    # `signals` are names and patterns in which * stands for any text; None: the main signals, energies, signals of
    # joints and loads, motions of bodies, `MOST_CURVES` of them.
    if signals is None:
        plain = [name for name in sol.names if name.count(".") < NODE_DOTS]
        bodies = {name.rpartition(".")[0] for name in plain if name.endswith(".alpha")}
        energies = [name for name in plain if name.startswith("energy.")]
        of_parts: dict[str, list[str]] = {}
        for name in plain:
            of_parts.setdefault(name.rpartition(".")[0], []).append(name)
        others = (own for part, own in of_parts.items() if part not in {*bodies, "energy"})
        in_turn = [name for row in zip_longest(*others) for name in row if name]
        return list(dict.fromkeys([*main_signals(sol), *energies, *in_turn, *plain]))[:MOST_CURVES]
    if isinstance(signals, str):
        raise InputError(f"report: signals is {signals!r}; it must be a list of names, e.g. [{signals!r}].")
    found: dict[str, None] = {}
    for name in signals:
        fitting = matching(sol.names, name) if "*" in str(name) else []
        found |= dict.fromkeys(fitting or [str(sol[name].attrs["name"])])
    if len(found) > MOST_CHOSEN:
        raise InputError(f"report: signals are {len(found)} signals; a page holds {MOST_CHOSEN} at most. Choose fewer.")
    return list(found)


def curves(sol: Solution, names: list[str], frames: np.ndarray) -> dict[str, Any]:
    """Signals for the page: values at the frames, and curves over the time."""
    # A curve with more rows than `ROWS_PER_FRAME` for each frame becomes an envelope: for each of as many equal shares
    # of the rows as there are frames, the smallest and the largest value, in the order in which they occur.
    values = np.stack([sol.array(name) for name in names], axis=1) if names else np.zeros((len(sol.time), 0))
    first = panels(sol, None if set(main_signals(sol)) <= set(names) else names) or [names[:1]]
    found: dict[str, Any] = {
        "names": names, "units": [sol.units(name) for name in names],
        "panels": [panel[:MOST_IN_PANEL] for panel in first], "time": html.instants(sol.time[frames]),
    }  # fmt: skip
    if len(sol.time) <= ROWS_PER_FRAME * len(frames) + 1:
        return {**found, "rows": frames.tolist(), "abscissae": html.instants(sol.time), "curves": html.floats(values)}
    times, narrow = envelope(sol.time, values, len(frames))
    found |= {"at_frames": html.floats(values[frames]), "abscissae": html.instants(times)}
    return {**found, "curves": html.floats(narrow), "envelope": True}


def envelope(time: np.ndarray, values: np.ndarray, buckets: int) -> tuple[np.ndarray, np.ndarray]:
    """Smallest and largest values (2 b, m) of b shares of the rows, and times (2 b,) [s] within these shares."""
    # Times are (n,) [s], values (n, m); numbers that are not finite are left out. b is n / 2 at most.
    edges = np.linspace(0, len(time), buckets + 1).astype(int)
    times, narrow = np.empty(2 * buckets), np.empty((2 * buckets, values.shape[1]))
    columns = np.arange(values.shape[1])
    for k, (begin, end) in enumerate(pairwise(edges)):
        share = values[begin:end]
        low = np.argmin(np.where(np.isfinite(share), share, np.inf), axis=0)
        high = np.argmax(np.where(np.isfinite(share), share, -np.inf), axis=0)
        first, second = np.minimum(low, high), np.maximum(low, high)
        narrow[2 * k], narrow[2 * k + 1] = share[first, columns], share[second, columns]
        times[2 * k], times[2 * k + 1] = time[begin], time[(begin + end) // 2]
    return times, narrow


ROUND = 1e-6  # relative spread of |e| + gap, below which the journal moves in a circle
MOST_POINTS = 4000  # number of points of a path
MOST_EPISODES = 300  # number of listed contact intervals of a joint


def clearance_of(sol: Solution, joint: str) -> float | None:
    """Radius of the circle in which the centre of a journal moves freely [m]; None for a joint of another form."""
    names = [f"{joint}.{signal}" for signal in ("ex", "ey", "penetration")]
    if not len(sol.time) or not all(name in sol for name in names):
        return None
    ex, ey, depth = (sol.array(name) for name in names)
    radius = np.hypot(ex, ey) - depth
    middle = float(np.median(radius))
    return middle if middle > 0.0 and np.ptp(radius) < ROUND * middle else None


def joints_with_contacts(sol: Solution) -> list[str]:
    """Names of all joints with contacts, journals in bearings first."""
    named = [name.partition(".")[0] for name in sol.contacts.names]
    named += [name.rpartition(".")[0] for name in sol.names if name.endswith(".ex") and name.count(".") == 1]
    return sorted(dict.fromkeys(named), key=lambda joint: clearance_of(sol, joint) is None)


def clearance_data(sol: Solution, frames: np.ndarray) -> list[dict[str, Any]]:
    """Journals for the scripts: clearance, values at the frames, and the path over all saved instants."""
    every, found = np.unique(np.linspace(0, len(sol.time) - 1, MOST_POINTS).round().astype(int)), []
    for joint in joints_with_contacts(sol):
        clearance = clearance_of(sol, joint)
        if clearance is None:
            continue
        pair = np.stack([sol.array(f"{joint}.ex"), sol.array(f"{joint}.ey")], axis=1)
        names = f"{joint}.penetration", f"{joint}.normal_force"
        depth, force = (np.nan_to_num(sol.array(x)) if x in sol else np.zeros(len(sol.time)) for x in names)
        now = np.column_stack([pair[frames], depth[frames], force[frames]])
        touching = "".join("1" if x > 0.0 else "0" for x in depth[every])
        path = {"path": html.quantised(pair[every], html.MIDDLE), "touching": touching}
        found.append({"joint": joint, "clearance": clearance, "now": html.floats(now), **path})
    return found


def _joint(sol: Solution, joint: str) -> html.Markup:
    """Picture, facts and contact intervals of a joint."""
    clearance = clearance_of(sol, joint)
    known = any(name.partition(".")[0] == joint for name in sol.contacts.names)
    rows: list[tuple[str, str | None]] = [("clearance", html.quantity(clearance, "m"))] if clearance is not None else []
    rows += [(fact.label, fact.text) for fact in contact_facts(sol, joint)]
    if f"{joint}.normal_force" in sol:
        peak = sol.peak(f"{joint}.normal_force")
        rows.append(("largest normal force", f"{html.quantity(peak.value, 'N')} at t = {peak.time:.6g} s"))
    label = f"Journal of joint {joint} in its bearing, with the path of its centre"
    picture = html.tag("canvas", class_="journal", role="img", aria_label=label, data_joint=joint)
    left = html.tag("div", picture if clearance is not None else None, html.facts(rows), class_="journal-side")
    listing = _intervals(sol.episodes(joint), joint) if known else None
    return html.tag("article", html.tag("h3", joint), html.tag("div", left, listing, class_="joint"), class_="card")


def _intervals(episodes: Episodes, joint: str) -> html.Markup:
    """Table of contact intervals, each with a button that goes to its start."""
    if not len(episodes):
        return html.tag("p", "The surfaces did not touch.")
    caption, several = f"Contact intervals of {joint}", len(set(episodes.contact)) > 1
    if len(episodes) > MOST_EPISODES:
        caption += f": the {MOST_EPISODES} with the largest forces of {len(episodes)}"
        episodes = episodes[np.sort(np.argsort(-episodes.peak_force, kind="stable")[:MOST_EPISODES])]
    rows = []
    for e in episodes:
        when = e.start if np.isfinite(e.start) else e.end
        shown = f"{e.start:.6g}" if np.isfinite(e.start) else "before"
        times = {"data_time": f"{when:.9g}", "data_end": f"{e.end:.9g}"} if np.isfinite(when) else {}
        go = html.tag("button", shown, type="button", class_="go", **times)
        numbers = (e.duration, e.approach_speed, e.peak_force, e.impulse, e.dissipated_contact)
        cells = ["-" if not np.isfinite(x) else f"{x:.4g}" for x in numbers]
        rows.append([go, *([e.contact] if several else []), MODES.get(e.mode, str(e.mode)), *cells])
    heads = ["onset [s]", *(["contact"] if several else []), "kind", "duration [s]", "approach [m/s]"]
    heads += ["largest force [N]", "impulse [N s]", "loss [J]"]
    listing = html.table(caption, heads, rows, numbers=range(len(heads) - 5, len(heads)))
    return html.tag("div", listing, class_="intervals")


# Tables of the parts of a mechanism: bodies, joints, loads, with their numbers, sections, materials and laws

UNKNOWN = (
    "The file of this solution knows no mechanism: it was written by hand or by an earlier version. "
    "report(sol, path, mechanism=mech) shows its parts and examines them."
)
NOT_EXAMINED = (
    "Not examined: files hold the numbers of a mechanism, not the mechanism itself. "
    "report(sol, path, mechanism=mech) examines it."
)


def _model_section(sol: Solution, description: Mapping[str, Any]) -> html.Markup:
    """Section of all parts, in plain values (see `flexmb.model.mechanism`); empty: unknown."""
    parts = description.get("parts", [])
    if not parts:
        names = ", ".join(dict.fromkeys(name.partition(".")[0] for name in sol.names)) or "no part"
        return html.section("Model", html.tag("p", UNKNOWN), html.facts([("signals of", names)]), anchor="model")
    bodies = [part for part in parts if part["kind"] == "body"]
    masses = [part["mass"] if isinstance(part.get("mass"), int | float) else None for part in bodies]
    others = []
    for part in (part for part in parts if part["kind"] != "body"):
        joined = [part["fields"][key][0] for key in ("first", "second", "body", "joint") if key in part["fields"]]
        between = " and ".join(str(name) for name in joined if isinstance(name, str))
        speed = f"{part['name']}.speed"  # motions of a drive have the unit of its signals
        unit = sol.units(speed) if speed in sol else ""
        told = values_text(part["fields"], units={"rad/s or m/s": unit, "rad or m": unit[:-2]} if unit else None)
        others.append([part["name"], part["class"], between, told])
    gx, gy = description.get("gravity", (0.0, 0.0))
    gravity = f"({html.number(gx)}, {html.number(gy)}) {pretty('m/s^2')}"
    mass = html.quantity(sum(mass or 0.0 for mass in masses), "kg")
    summary = [("parts", f"{len(parts)}"), ("mass", mass), ("gravity", gravity)]
    texts = ["-" if mass is None else html.number(mass) for mass in masses]
    rows = [[p["name"], p["class"], text, values_text(p["fields"])] for p, text in zip(bodies, texts, strict=True)]
    heads, more = ["name", "class", "mass [kg]", "values"], ["name", "class", "between", "values"]
    listed = html.table("Bodies", heads, rows, numbers=[2]) if bodies else None
    rest = html.table("Joints, drives, loads and other parts", more, others) if others else None
    return html.section("Model", html.facts(summary), listed, rest, anchor="model")


def _check_section(report: Report | str) -> html.Markup:
    """Section of the examination of the mechanism, a result of `check`, or the reason why there is none."""
    if isinstance(report, str):
        return html.section("Examination", html.tag("p", report), anchor="check")
    counts = [(sum(f.severity == severity for f in report.findings), severity) for severity in SEVERITIES]
    words = ", ".join(f"{count} {word}{'' if count == 1 else 's'}" for count, word in counts if count)
    frequencies = ", ".join(html.number(f, 4) for f in report.frequencies) + " Hz" if report.frequencies else "none"
    rows: list[tuple[str, html.Content]] = [
        ("findings", words or "nothing to remark"),
        ("degrees of freedom", f"{report.freedom} (rigid bodies, clearances closed), {report.free} not driven"),
        ("equations", f"{report.coordinates} coordinates, {report.rows} constraint rows"),
        ("natural frequencies", frequencies),
    ]
    badges = (html.tag("span", f.severity, class_=f"badge {f.severity}") for f in report.findings)
    found = [[badge, f.code, f.text, f.remedy] for badge, f in zip(badges, report.findings, strict=True)]
    listed = html.table("Findings", ["severity", "code", "finding", "remedy"], found) if found else None
    return html.section("Examination", html.facts(rows), listed, anchor="check")


CAPTION = "Energies [J] at the first and the last saved instant, and their largest absolute values"


def energy_section(sol: Solution) -> html.Markup | None:
    """Section of the balance of energies; None for a solution without energies."""
    names = {key: f"energy.{key}" for key in ENERGIES if f"energy.{key}" in sol}
    if not names or not len(sol.time):
        return None
    rows = []
    for key, name in names.items():
        first, last = sol.array(name)[[0, -1]]
        rows.append([ENERGIES[key], html.number(first), html.number(last), html.number(sol.peak(name).value)])
    made, share = html.table(CAPTION, ["energy", "first", "last", "largest"], rows, numbers=[1, 2, 3]), None
    if {"residual", "turned_over"} <= names.keys() and sol.peak(names["turned_over"]).value > 0.0:
        part = sol.peak(names["residual"]).value / sol.peak(names["turned_over"]).value
        share = html.tag("p", f"The largest residual is {part:.2g} of the energy turned over.")
    plot = html.tag("div", class_="plots", id="energy-plots")
    return html.section("Balance of energies", share, html.tag("div", plot, made, class_="pair"), anchor="energy")


def _short(value: Any) -> str:
    text = value if isinstance(value, str) else ", ".join(map(str, value)) if isinstance(value, list) else str(value)
    return text if len(text) <= 400 else f"{text[:400]} ..."


SCRIPTS = ("plots.js", "mesh.js", "scene.js", "drawing.js", "player.js", "journals.js", "run.js")
# Texts of the links to the sections, as far as they are there.
LINKS = {
    "peaks": "Largest values", "clearances": "Clearances", "energy": "Energies", "statistics": "Statistics",
    "model": "Model", "check": "Examination", "settings": "Settings",
}  # fmt: skip


def write_run(
    sol: Solution, path: Path, mechanism: Mechanism | None, frames: int, signals: Any, title: str | None
) -> Path:
    """Write the page of a run; see `flexmb.report`."""
    require_rows("report", sol, drawn=False)
    names, instants = chosen_names(sol, signals), spread_instants(sol, frames)
    instants = instants[np.isfinite(sol.values[instants]).all(axis=1)]
    if len(instants) == 0:
        raise InputError("report: no saved instant is finite. Look at sol.status for the end of the run.")
    known = sol.mechanism if mechanism is None else mechanism
    moving, missing = scene_or_reason(sol, known, instants)
    data: dict[str, Any] = {"kind": "run", "name": sol.name, "signals": curves(sol, names, instants)}
    data |= {"scene": moving, "journals": clearance_data(sol, instants)}
    heading = sol.name if title is None else title
    shown = player(sol, heading, fields=fields_of(moving)) if moving else html.tag("p", missing, class_="missing")
    description = described(known) if known is not None else dict(sol.description)
    # Settings, versions and the command of the run
    model = dict(sol.model)
    command = model.pop("command", None)
    typed = shlex.join(["flexmb", *map(str, command if isinstance(command, list) else [command])])
    rows: list[tuple[str, html.Content]] = [("command", html.tag("code", typed))] if command else []
    rows += [("mechanism", sol.name), ("frames here", f"{len(instants)} of {len(sol.time)} saved instants")]
    rows += [(key, _short(value)) for key, value in model.items() if key not in ("name", "flexmb", "version")]
    written = model.get("flexmb", model.get("version", "unknown"))
    here = f"flexmb {installed_version()}, Python {platform.python_version()}, numpy {np.__version__}"
    rows += [("computed by", f"flexmb {written}"), ("page written by", here)]
    settings = html.section("Settings and versions", html.facts(rows), anchor="settings")
    sections = html.joined([_body(sol, shown, known, description), settings])
    links = {anchor: text for anchor, text in LINKS.items() if f'id="{anchor}"' in sections}
    # State and first numbers; the status where it tells more than the end
    span = f"{html.quantity(sol.time[0], 's')} to {html.quantity(sol.time[-1], 's')}"
    saved, stats = counted(len(sol.time), "saved instant"), sol.stats
    text = f"{span}, {saved}, {counted(stats.steps, 'step')}, {stats.wall_time:.3g} s of computing"
    head = html.state_of("" if sol.ok else "not finished", html.tag("span", text))
    if not sol.ok or ". " in sol.status:
        told = html.tag("p", sol.status, class_=f"told {'warning' if sol.ok else 'error'}", role="status")
        head = html.joined([head, told])
    return html.write_page(path, heading, head, links, html.tag("main", sections, id="top"), SCRIPTS, data)


def _body(sol: Solution, moving: html.Markup, mechanism: Mechanism | None, description: dict[str, Any]) -> html.Markup:
    """All sections but the last one."""
    panels = html.tag("div", class_="plots", id="plots")
    first = html.tag("option", "Add a plot ...", value="")
    select = html.tag("select", first, id="more-signals", aria_label="Add a plot")
    hint = "Click or drag in a plot to set the time; Shift and drag to zoom in, double click to zoom out."
    more = html.tag("div", select, html.tag("p", hint, class_="hint"), class_="more")
    plots = html.tag("div", html.tag("h2", "Signals over the time t [s]"), panels, more, class_="signals")
    largest = []
    for name in (name for name in main_signals(sol) if name in sol):
        peak = sol.peak(name)
        go = html.tag("button", html.number(peak.time), type="button", class_="go", data_time=repr(peak.time))
        largest.append([name, html.number(peak.value), pretty(sol.units(name)), go])
    heads = ["signal", "largest absolute value", "unit", "at t [s]"]
    peaks = html.table("Largest absolute values of all accepted steps", heads, largest, numbers=[1])
    joints = [_joint(sol, joint) for joint in joints_with_contacts(sol)]
    rows = [("status", sol.status), *((fact.label, fact.text) for fact in facts(sol))]
    notes = html.tag("ul", *(html.tag("li", note) for note in sol.notes), class_="notes") if sol.notes else None
    heading = html.tag("h3", "Notes") if notes else None
    sections = [
        html.tag("div", moving, plots, class_="stage"),
        html.section("Largest values", peaks, anchor="peaks") if largest else None,
        html.section("Joints with clearance", *joints, anchor="clearances") if joints else None,
        energy_section(sol),
        html.section("Statistics", html.facts(rows), heading, notes, anchor="statistics"),
        _model_section(sol, description),
        _check_section(examined(mechanism)),
    ]
    return html.joined(sections)


def examined(mechanism: Mechanism | None) -> Report | str:
    """Examination of a mechanism, or the reason why there is none."""
    if mechanism is None:
        return NOT_EXAMINED
    try:
        return check(mechanism)
    except USER_ERRORS as error:
        return f"The examination failed: {error}"
