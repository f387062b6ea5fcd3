"""Moving picture of a mechanism with its controls, as HTML."""

from __future__ import annotations

from collections.abc import Sequence

from flexmb.model.shape import BeamShape, MeshShape
from flexmb.reports.markup import Content, Markup, tag
from flexmb.results.drawing import parts
from flexmb.results.solution import Solution

DURATIONS = {"5": "5 s", "10": "10 s", "20": "20 s", "60": "60 s", "300": "5 min", "real": "real time"}
"""Times in which a run is played."""

MAGNIFICATIONS = ("1", "3", "10", "30", "100", "300", "1000", "3000", "10000")
"""Factors of the displacements of flexible parts."""

COLOURED = {"moment": "bending moment", "axial": "axial force", "stress": "stress"}
"""Names of the fields by which bodies are coloured."""

KEYS = "Keys: Space plays, arrows step (Shift: ten frames), Home and End, + and - zoom, 0 fits, drag pans."


def player(sol: Solution, heading: str, *, fields: Sequence[str]) -> Markup:
    """Picture, time slider and controls; fields as of `reports.scene.fields_of`."""
    names = parts(sol)
    listed = ", ".join(names[:30]) + (", ..." if len(names) > 30 else "")
    text = f"Moving picture of {heading}: {listed}. Plots and tables hold the same in numbers."
    canvas = tag("canvas", text, id="picture", tabindex="0", role="img", aria_label=text, aria_describedby="keys")
    bar = tag("div", id="legend-ticks", class_="ticks"), tag("p", id="legend-text")
    legend = tag("div", *bar, id="legend", class_="legend", aria_hidden="true")
    flexible = any(isinstance(shape, BeamShape | MeshShape) for shape in sol.shapes)
    return tag(
        "div",
        tag("h2", "Motion", class_="visually-hidden"),
        tag("div", canvas, legend, class_="picture"),
        _time_row(),
        _look_row(flexible, fields),
        tag("p", KEYS, id="keys", class_="hint"),
        class_="player",
    )


def _time_row() -> Markup:
    """Controls of the time."""
    return tag(
        "div",
        _button("play", "Play", "Play or pause"),
        _button("back", "\u2039", "One frame back"),
        _button("forward", "\u203a", "One frame forward"),
        tag("input", type="range", id="time", min="0", max="1", step="1", value="0", aria_label="Time"),
        tag("output", id="now", for_="time"),
        tag("span", id="said", class_="visually-hidden", aria_live="polite"),
        class_="row time",
    )


def _look_row(flexible: bool, fields: Sequence[str]) -> Markup:
    """Controls of the look."""
    colours = {"part": "parts", **{field: COLOURED[field] for field in fields}}
    return tag(
        "div",
        _choice("duration", "Played in", DURATIONS, "10"),
        _choice("magnification", "Deformation", {"auto": "auto", **{x: f"{x} \u00d7" for x in MAGNIFICATIONS}}, "1")
        if flexible
        else None,
        _choice("colour", "Colour", colours, list(colours)[min(1, len(fields))]) if flexible else None,
        _box("forces", "Joint forces", checked=True),
        _box("names", "Names", checked=True),
        _button("fit", "Fit", "Fit the picture"),
        _button("clear", "Clear traces", "Remove the traces of clicked points"),
        class_="row look",
    )


def _button(name: str, text: str, label: str) -> Markup:
    return tag("button", text, type="button", id=name, aria_label=label, title=label)


def _choice(name: str, label: str, options: dict[str, str], chosen: str) -> Markup:
    made = [tag("option", text, value=value, selected=value == chosen) for value, text in options.items()]
    return tag("label", label, Markup(" "), tag("select", *made, id=name))


def _box(name: str, label: str, *, checked: bool) -> Markup:
    content: list[Content] = [tag("input", type="checkbox", id=name, checked=checked), label]
    return tag("label", *content)
