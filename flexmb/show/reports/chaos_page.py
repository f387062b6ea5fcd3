"""Page of a study of a motion: verdict, Poincare section, exponents and their convergence, evidence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.dynamics.verdict import MEANING, meaning_of
from flexmb.errors import InputError
from flexmb.late import xr
from flexmb.show.reports import document as html

SCRIPTS = ("diagram.js", "chaos.js")
MOST_SIGNALS = 60  # number of signals on a page where none are chosen
EVIDENCE = "evidence_"
HINT = "Drag pans, + and - zoom while the diagram has the focus, 0 or a double click fits."
LINKS = {"section": "Section", "exponents": "Exponents", "evidence": "Evidence", "settings": "Settings"}


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
        names = list(dict.fromkeys([*sampled, *known]))[:MOST_SIGNALS]
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
    main = _main(root, has_motion=motion is not None)
    verdict = html.tag("strong", str(root.attrs.get("verdict", "no verdict")), id="verdict")
    points = f"{root.sizes['period']} periods of {html.quantity(float(root.attrs['period']), 's')}"
    text = f", {points} after {root.attrs['skip']} skipped ones"
    state = html.state_of("" if root.attrs.get("ok", 1) else "not finished", verdict, text, also="verdict")
    return html.write_page(path, heading, state, LINKS, main, SCRIPTS, data)


def _columns(dataset: xr.Dataset, names: Sequence[str]) -> np.ndarray:
    return np.stack([dataset[name].values for name in names], axis=1).astype(float)


def _main(root: xr.Dataset, *, has_motion: bool) -> html.Markup:
    reason = str(root.attrs.get("reason", root.attrs.get("status", "")))
    box = html.tag("input", type="checkbox", id="motion", checked=True)
    across = html.tag("label", "across", html.Markup(" "), html.tag("select", id="across"))
    up = html.tag("label", "up", html.Markup(" "), html.tag("select", id="up"))
    between = html.tag("label", box, "motion between the points") if has_motion else None
    controls = html.tag("div", across, up, between, html.tag("button", "Fit", type="button", id="fit"), class_="row")
    label = "Poincare section: one point a period of two signals"
    canvas = html.tag("canvas", label, id="diagram", class_="diagram", tabindex="0", role="img", aria_label=label)
    picture = html.section("Section", controls, canvas, html.tag("p", HINT, class_="hint"), anchor="section")
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
