"""Report as one HTML page; pages of studies: of a bifurcation diagram, of a motion, of a fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

import numpy as np

from flexmb import arguments, checks
from flexmb.display import counted, pretty
from flexmb.dynamics.report import ChaosReport
from flexmb.dynamics.verdict import MEANING, meaning_of
from flexmb.errors import InputError
from flexmb.late import xr
from flexmb.model.mechanism import Mechanism
from flexmb.results.solution import Solution
from flexmb.show.pictures.diagrams import VERDICT_COLOURS, by_direction, default_signal, entry_of
from flexmb.show.pictures.signals import columns_of
from flexmb.show.reports import document as html
from flexmb.show.reports.run_page import write_run

if TYPE_CHECKING:
    from flexmb.design.fitting import Fit

SWEEP_SIGNALS, CHAOS_SIGNALS = 24, 60  # number of signals on a page of a diagram, of a motion, where none are chosen
GREY = "#8c8c8c"  # colour of motions without a verdict
KEYS = "Click a point to open the report of its run, where there is one; arrows choose a value, Enter opens its report."
SWEEP_HINT = f"{KEYS} Drag pans, + and - zoom, 0 or a double click fits."
CHAOS_HINT = "Drag pans, + and - zoom while the diagram has the focus, 0 or a double click fits."
FIT_HINT = "Points: measured; line: fitted; dashed: twice the noise; dotted: begin of a piece. Drag pans, + and - zoom."
EVIDENCE = "evidence_"
SWEEP_LINKS = {"section": "Diagram", "values": "Values", "settings": "Settings"}
CHAOS_LINKS = {"section": "Section", "exponents": "Exponents", "evidence": "Evidence", "settings": "Settings"}
FIT_LINKS = {"parameters": "Parameters", "residuals": "Residuals", "settings": "Settings"}


def write_sweep(diagram: xr.Dataset, path: Path, signals: Sequence[str] | None, title: str | None) -> Path:
    """Write the page of a bifurcation diagram; see `flexmb.report`."""
    # Names of the signals on the page, that of the first picture first
    known = [str(name) for name, points in diagram.data_vars.items() if "period" in points.dims]
    if signals is not None:
        names = html.chosen_signals(signals, known)
    else:
        first = default_signal(diagram)
        names = [first, *(name for name in known if name != first)][:SWEEP_SIGNALS]
    rows = _rows(diagram, path)
    if not rows:
        raise InputError("report: the diagram has no finished point. Continue it with resume=True.")
    parameter = diagram.attrs["parameter"]
    values, unit = diagram[parameter].values, diagram[parameter].attrs.get("units", "")
    data: dict[str, Any] = {
        "kind": "sweep", "parameter": parameter, "unit": unit,
        "unit_of_exponent": diagram["exponent"].attrs.get("units", "1/s") if "exponent" in diagram else "",
        "values": html.instants(values.astype(float)), "rows": rows,
        "legend": {row["entry"]: row["colour"] for row in rows if row["entry"]},
        "signals": [],
    }  # fmt: skip
    for name in names:  # section points of a signal, a column for each row
        listed = {direction: part[name].values for direction, part in by_direction(diagram)}
        columns = ((listed[row["direction"]][row["place"]], row["ok"]) for row in rows)
        shown = np.stack([column if ok else np.full_like(column, np.nan) for column, ok in columns], axis=1)
        unit_of = diagram[name].attrs.get("units", "")
        data["signals"].append({"name": name, "unit": unit_of, "points": html.floats(shown)})
    heading = str(diagram.attrs["name"]) if title is None else title
    failed = sum(not row["ok"] for row in rows)
    span = f"{html.quantity(float(values.min()), unit)} to {html.quantity(float(values.max()), unit)}"
    text = f"bifurcation diagram: {parameter} from {span}, {len(values)} values, {diagram.sizes['period']} points each"
    main = _sweep_sections(diagram, rows)
    state = html.state_of(f"{failed} failed" if failed else "", html.tag("span", text))
    return html.write_page(path, heading, state, SWEEP_LINKS, main, ("diagram.js", "sweep.js"), data)


def point_file(parameter: str, value: float) -> str:
    """Name of the report of the run at a value, beside the page of the diagram, with six digits: "speed-6.28.html"."""
    return f"{parameter}-{value:.6g}.html"


def _rows(diagram: xr.Dataset, path: Path) -> list[dict[str, Any]]:
    """Finished points of all directions, with verdict, status, and the report of the run where there is one."""
    parameter, found = diagram.attrs["parameter"], []
    for direction, part in by_direction(diagram):
        for k, value in enumerate(part[parameter].values):
            status = str(part["status"].values[k])
            if not status:
                continue
            verdict = str(part["verdict"].values[k])
            entry = entry_of(verdict) if verdict else ""
            name = point_file(parameter, float(value))
            colour = VERDICT_COLOURS[entry]  # of matplotlib; "" is the colour of the text in CSS
            found.append({
                "place": k, "direction": direction, "verdict": verdict, "entry": entry,
                "colour": colour if colour.startswith("#") else "" if colour == "black" else GREY,
                "exponent": float(part["exponent"].values[k]) if "exponent" in part else None,
                "ok": bool(part["ok"].values[k]), "status": status,
                "link": quote(name) if (path.parent / name).is_file() else None,
            })  # fmt: skip
    return found


def _sweep_sections(diagram: xr.Dataset, rows: list[dict[str, Any]]) -> html.Markup:
    parameter = diagram.attrs["parameter"]
    label = f"Bifurcation diagram over {parameter}; the table of values holds the same in words."
    canvas = html.tag("canvas", label, id="diagram", class_="diagram", tabindex="0", role="img", aria_label=label)
    choice = html.tag("label", "Signal", html.Markup(" "), html.tag("select", id="signal"))
    controls = html.tag("div", choice, html.tag("button", "Fit", type="button", id="fit"), class_="row")
    chosen = html.tag("p", "No value is chosen.", id="chosen", aria_live="polite")
    legend, hint = html.tag("div", id="legend", class_="swatches"), html.tag("p", SWEEP_HINT, class_="hint")
    picture = html.section("Diagram", controls, canvas, legend, chosen, hint, anchor="section")
    listed = [(str(key), str(value)) for key, value in diagram.attrs.items() if key not in ("name", "kind")]
    settings = html.section("Settings", html.facts(listed), anchor="settings")
    # Table of the verdicts of all values
    values, unit = diagram[parameter].values, diagram[parameter].attrs.get("units", "")
    cells: list[list[html.Content]] = []
    for row in rows:
        link = html.tag("a", "report", href=row["link"]) if row["link"] else ""
        exponent = "-" if row["exponent"] is None else html.number(row["exponent"], 4)
        value = html.number(values[row["place"]])
        cells.append([value, row["direction"], row["verdict"], exponent, row["status"], link])
    head = f"{parameter} [{pretty(unit)}]" if unit else parameter
    heads = [head, "direction", "verdict", "exponent [1/s]", "status", "run"]
    listing = html.table("Verdicts of all values", heads, cells, numbers=[3])
    return html.tag("main", picture, html.section("Values", listing, anchor="values"), settings, id="top")


def write_chaos(groups: Mapping[str, xr.Dataset], path: Path, signals: Sequence[str] | None, title: str | None) -> Path:
    """Write the page of a study of a motion; see `flexmb.report`."""
    # `groups` are datasets of `flexmb chaos` by the name of their group: "" and, where there are fine samples,
    # "motion". Without `signals` those with fine samples come first, then others; the title is by default the name of
    # the mechanism.
    root, motion = groups[""], groups.get("motion")
    if not root.sizes.get("period", 0):
        raise InputError("report: the study has no section points; its status tells why.")
    # Names of the signals on the page
    known = [str(name) for name, column in root.data_vars.items() if column.dims == ("period",)]
    if signals is not None:
        names = html.chosen_signals(signals, known)
    else:
        sampled = [] if motion is None else [str(name) for name in motion.data_vars]
        names = list(dict.fromkeys([*sampled, *known]))[:CHAOS_SIGNALS]
    units = [root[name].attrs.get("units", "") for name in names]
    data: dict[str, Any] = {
        "kind": "chaos", "first": int(root["period"].values[0]), "unit": root["exponent"].attrs.get("units", ""),
        "plane": list(names[:2]) if len(names) > 1 else ["number", names[0]],
        "section": {"names": names, "units": units, "points": html.floats(_columns(root, names))},
    }  # fmt: skip
    if motion is not None:
        sampled = [str(name) for name in motion.data_vars]
        data["motion"] = {"names": sampled, "curves": html.floats(_columns(motion, sampled))}
    if root.sizes.get("history_time", 0):
        data["history"] = html.floats(np.column_stack([root["history_time"].values, root["exponent_history"].values]))
    heading = str(root.attrs["name"]) if title is None else title
    main = _chaos_sections(root, has_motion=motion is not None)
    verdict = html.tag("strong", str(root.attrs.get("verdict", "no verdict")), id="verdict")
    points = f"{root.sizes['period']} periods of {html.quantity(float(root.attrs['period']), 's')}"
    text = f", {points} after {root.attrs['skip']} skipped ones"
    state = html.state_of("" if root.attrs.get("ok", 1) else "not finished", verdict, text, also="verdict")
    return html.write_page(path, heading, state, CHAOS_LINKS, main, ("diagram.js", "chaos.js"), data)


def _columns(dataset: xr.Dataset, names: Sequence[str]) -> np.ndarray:
    return np.stack([dataset[name].values for name in names], axis=1).astype(float)


def _chaos_sections(root: xr.Dataset, *, has_motion: bool) -> html.Markup:
    reason = str(root.attrs.get("reason", root.attrs.get("status", "")))
    box = html.tag("input", type="checkbox", id="motion", checked=True)
    across = html.tag("label", "across", html.Markup(" "), html.tag("select", id="across"))
    up = html.tag("label", "up", html.Markup(" "), html.tag("select", id="up"))
    between = html.tag("label", box, "motion between the points") if has_motion else None
    controls = html.tag("div", across, up, between, html.tag("button", "Fit", type="button", id="fit"), class_="row")
    label = "Poincare section: one point a period of two signals"
    canvas = html.tag("canvas", label, id="diagram", class_="diagram", tabindex="0", role="img", aria_label=label)
    picture = html.section("Section", controls, canvas, html.tag("p", CHAOS_HINT, class_="hint"), anchor="section")
    keys = ("status", "second_run", "period", "skip", "flexmb")
    settings = [(key.replace("_", " "), str(root.attrs[key])) for key in keys if key in root.attrs]
    why = html.tag("section", html.tag("p", reason), aria_label="Reason of the verdict")
    versions = html.section("Settings and versions", html.facts(settings), anchor="settings")
    found = {key.removeprefix(EVIDENCE): value for key, value in root.attrs.items() if key.startswith(EVIDENCE)}
    rows = [[text, html.number(float(found[key]), 4)] for key, text in MEANING.items() if key in found]
    listing = html.table("Evidence of the verdict", ["quantity", "value"], rows, numbers=[1])
    none = html.tag("p", "The motion has no verdict.")
    evidence = html.section("Evidence", listing if rows else none, anchor="evidence")
    return html.tag("main", why, picture, _exponents(root), evidence, versions, id="top")


def _exponents(root: xr.Dataset) -> html.Markup:
    """Table of the exponents, of both runs, and a picture of their convergence."""
    unit, period = root["exponent"].attrs.get("units", ""), float(root.attrs["period"])
    rows: list[list[html.Content]] = []
    for k, value in enumerate(root["exponent"].values):
        error, second = float(root["exponent_error"].values[k]), "-"
        if "exponent_second" in root:
            second = _with_error(root["exponent_second"].values[k], root["exponent_second_error"].values[k])
        alone = _with_error(value, root["exponent_statistical"].values[k])
        own = f"{k + 1}", html.number(float(value), 4), html.number(error, 2)
        rows.append([*own, alone, second, meaning_of(float(value), error, period)])
    heads = ["number", f"exponent [{unit}]", "error", "this run alone", "second run", "meaning"]
    label = "Convergence of the Lyapunov exponents over the time"
    history = html.tag("canvas", label, id="history", class_="diagram", tabindex="0", role="img", aria_label=label)
    dimension = float(root.attrs.get("lyapunov_dimension", float("nan")))
    shown = html.facts([("Lyapunov dimension of the section", html.number(dimension, 4))])
    more = shown if np.isfinite(dimension) else None
    drawn = history if root.sizes.get("history_time", 0) else None
    listing = html.table("Lyapunov exponents", heads, rows, numbers=[1, 2])
    return html.section("Exponents", listing, more, drawn, anchor="exponents")


def _with_error(value: float, error: float) -> str:
    return f"{value:.4g} \u00b1 {error:.2g}" if np.isfinite(error) else f"{value:.4g}"


def write_fit(fit: Fit, path: Path, signals: Sequence[str] | None, title: str | None) -> Path:
    """Write the page of a fit; see `flexmb.report`."""
    known = [str(name) for name in fit.residuals.data_vars]
    names = known if signals is None else html.chosen_signals(signals, known)
    units = {name: fit.residuals[name].attrs["units"] for name in known}
    data: dict[str, Any] = {"kind": "fit", "begins": list(fit.begins[1:])}
    data["signals"] = [{"name": x, "unit": units[x], "curves": html.floats(columns_of(fit, x))} for x in names]
    text = f"fit of {counted(len(fit.parameters), 'parameter')} to {fit.about['data']}, {fit.runs} runs"
    told = " ".join([fit.message, *(f"Not told apart by the data: {text}." for text in fit.unseen)])
    notes = html.tag("p", told, class_="told" if fit.ok else "told error", role="status")
    head = html.joined([html.state_of("" if fit.ok else "not converged", html.tag("span", text)), notes])
    settings = html.section("Settings and versions", html.facts(fit.about.items()), anchor="settings")
    # Tables of the parameters and offsets
    columns, rows = fit.table()
    named = [[f"{name} [{pretty(fit.units[name])}]" if fit.units[name] else name, *texts] for name, *texts in rows]
    listing = html.table("Values, bounds and correlations", columns, named, numbers=range(1, len(columns)))
    offsets = [[name, html.number(x), pretty(units[name])] for name, x in fit.offsets.items()]
    others = html.table("Offsets", ["signal", "offset", "unit"], offsets, numbers=[1]) if offsets else None
    values = html.section("Parameters", listing, others, anchor="parameters")
    main = html.tag("main", values, _residuals(fit, names), settings, id="top")
    heading = fit.about["mechanism"] if title is None else title
    return html.write_page(path, heading, head, FIT_LINKS, main, ("diagram.js", "fit.js"), data)


def _residuals(fit: Fit, names: Sequence[str]) -> html.Markup:
    """Table of the residuals of all signals, and pictures of the named ones."""
    rows, pictures = [], []
    for name, left in fit.residuals.items():
        count = int(left.notnull().sum())
        rms, noise = float(np.sqrt(np.nansum(left.values**2) / max(count, 1))), left.attrs["noise"]
        numbers = [html.number(x, 3) for x in (rms, noise, rms / (noise or 1.0), left.attrs["correlation"])]
        rows.append([str(name), pretty(left.attrs["units"]), f"{count}", *numbers])
    head = ["signal", "unit", "numbers", "rms of residuals", "noise", "rms over noise", "correlation to the next"]
    for k, name in enumerate(names):
        pictures.append(html.tag("h3", name))
        for kind, text in (("fitted", "measured and fitted"), ("left", "residuals over the noise")):
            label, look = f"{name}, {text}, over the time", f"diagram {kind}"
            shown = html.tag("canvas", label, id=f"{kind}-{k}", class_=look, tabindex="0", role="img", aria_label=label)
            pictures.append(shown)
    listing = html.table(f"Residuals; noise {fit.about['noise']}", head, rows, numbers=range(2, len(head)))
    return html.section("Residuals", listing, *pictures, html.tag("p", FIT_HINT, class_="hint"), anchor="residuals")


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
