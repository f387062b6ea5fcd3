"""Page of a bifurcation diagram: points coloured by verdict, table of all values, links to reports of runs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np

from flexmb.display import pretty
from flexmb.errors import InputError
from flexmb.late import xr
from flexmb.show.pictures.diagrams import VERDICT_COLOURS, by_direction, default_signal, entry_of
from flexmb.show.reports import document as html

SCRIPTS = ("diagram.js", "sweep.js")
MOST_SIGNALS = 24  # number of signals on a page where none are chosen
# Colour of motions without a verdict.
GREY = "#8c8c8c"
KEYS = "Click a point to open the report of its run, where there is one; arrows choose a value, Enter opens its report."
ZOOM = "Drag pans, + and - zoom, 0 or a double click fits."


def write_sweep(diagram: xr.Dataset, path: Path, signals: Sequence[str] | None, title: str | None) -> Path:
    """Write the page of a bifurcation diagram; see `flexmb.report`."""
    # Names of the signals on the page, that of the first picture first
    known = [str(name) for name, points in diagram.data_vars.items() if "period" in points.dims]
    if signals is not None:
        names = html.chosen_signals(signals, known)
    else:
        first = default_signal(diagram)
        names = [first, *(name for name in known if name != first)][:MOST_SIGNALS]
    rows = _rows(diagram, path)
    if not rows:
        raise InputError("report: the diagram has no finished point. Continue it with resume=True.")
    parameter = diagram.attrs["parameter"]
    values, unit = diagram[parameter].values, diagram[parameter].attrs.get("units", "")
    data = {
        "kind": "sweep", "parameter": parameter, "unit": unit,
        "unit_of_exponent": diagram["exponent"].attrs.get("units", "1/s") if "exponent" in diagram else "",
        "values": html.instants(values.astype(float)), "rows": rows,
        "legend": {row["entry"]: row["colour"] for row in rows if row["entry"]},
        "signals": [_points(diagram, name, rows) for name in names],
    }  # fmt: skip
    heading = str(diagram.attrs["name"]) if title is None else title
    failed = sum(not row["ok"] for row in rows)
    span = f"{html.quantity(float(values.min()), unit)} to {html.quantity(float(values.max()), unit)}"
    text = f"bifurcation diagram: {parameter} from {span}, {len(values)} values, {diagram.sizes['period']} points each"
    state = html.state_of(f"{failed} failed" if failed else "", html.tag("span", text))
    return html.write_page(path, heading, state, LINKS, _main(diagram, rows), SCRIPTS, data)


LINKS = {"section": "Diagram", "values": "Values", "settings": "Settings"}


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
            entry, name = entry_of(verdict) if verdict else "", point_file(parameter, float(value))
            colour = VERDICT_COLOURS[entry]  # of matplotlib; "" is the colour of the text in CSS
            found.append({
                "place": k, "direction": direction, "verdict": verdict, "entry": entry,
                "colour": colour if colour.startswith("#") else "" if colour == "black" else GREY,
                "exponent": float(part["exponent"].values[k]) if "exponent" in part else None,
                "ok": bool(part["ok"].values[k]), "status": status,
                "link": quote(name) if (path.parent / name).is_file() else None,
            })  # fmt: skip
    return found


def _points(diagram: xr.Dataset, name: str, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Section points of a signal, a column for each row."""
    values = {direction: part[name].values for direction, part in by_direction(diagram)}
    columns = ((values[row["direction"]][row["place"]], row["ok"]) for row in rows)
    shown = [column if ok else np.full_like(column, np.nan) for column, ok in columns]
    return {"name": name, "unit": diagram[name].attrs.get("units", ""), "points": html.floats(np.stack(shown, axis=1))}


def _main(diagram: xr.Dataset, rows: list[dict[str, Any]]) -> html.Markup:
    parameter = diagram.attrs["parameter"]
    label = f"Bifurcation diagram over {parameter}; the table of values holds the same in words."
    canvas = html.tag("canvas", label, id="diagram", class_="diagram", tabindex="0", role="img", aria_label=label)
    choice = html.tag("label", "Signal", html.Markup(" "), html.tag("select", id="signal"))
    controls = html.tag("div", choice, html.tag("button", "Fit", type="button", id="fit"), class_="row")
    chosen = html.tag("p", "No value is chosen.", id="chosen", aria_live="polite")
    legend, hint = html.tag("div", id="legend", class_="swatches"), html.tag("p", f"{KEYS} {ZOOM}", class_="hint")
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
