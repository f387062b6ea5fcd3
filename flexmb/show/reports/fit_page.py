"""Page of a fit: parameters with their errors, bounds and correlations, signals beside measured ones, residuals."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmb.display import counted, pretty
from flexmb.show.pictures.signals import columns_of
from flexmb.show.reports import document as html

if TYPE_CHECKING:
    from flexmb.design.fitting import Fit

SCRIPTS = ("diagram.js", "fit.js")
LINKS = {"parameters": "Parameters", "residuals": "Residuals", "settings": "Settings"}
HINT = "Points: measured; line: fitted; dashed: twice the noise; dotted: begin of a piece. Drag pans, + and - zoom."


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
    main = html.tag("main", _parameters(fit, units), _residuals(fit, names), settings, id="top")
    return html.write_page(path, fit.about["mechanism"] if title is None else title, head, LINKS, main, SCRIPTS, data)


def _parameters(fit: Fit, units: dict[str, str]) -> html.Markup:
    """Tables of the parameters and offsets."""
    head, rows = fit.table()
    named = [[f"{name} [{pretty(fit.units[name])}]" if fit.units[name] else name, *texts] for name, *texts in rows]
    listing = html.table("Values, bounds and correlations", head, named, numbers=range(1, len(head)))
    offsets = [[name, html.number(x), pretty(units[name])] for name, x in fit.offsets.items()]
    others = html.table("Offsets", ["signal", "offset", "unit"], offsets, numbers=[1]) if offsets else None
    return html.section("Parameters", listing, others, anchor="parameters")


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
    return html.section("Residuals", listing, *pictures, html.tag("p", HINT, class_="hint"), anchor="residuals")
