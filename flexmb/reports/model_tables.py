"""Tables of the parts of a mechanism: bodies, joints, loads, with their numbers, sections, materials and laws."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from flexmb.doctor.finding import SEVERITIES
from flexmb.doctor.report import Report
from flexmb.reports.markup import Content, Markup, facts, number, pretty, quantity, section, table, tag
from flexmb.results.solution import Solution

UNKNOWN = (
    "The file of this solution knows no mechanism: it was written by hand or by an earlier version. "
    "report(sol, path, mechanism=mech) shows its parts and examines them."
)
NOT_EXAMINED = (
    "Not examined: files hold the numbers of a mechanism, not the mechanism itself. "
    "report(sol, path, mechanism=mech) examines it."
)

LEFT_OUT = frozenset({"first", "second", "body", "mass", "outline", "class"})
"""Fields that have a column of their own, and drawings."""


def model_section(sol: Solution, description: Mapping[str, Any]) -> Markup:
    """Section of all parts, in plain values (see `flexmb.model.description`); empty: unknown."""
    parts = description.get("parts", [])
    if not parts:
        names = ", ".join(dict.fromkeys(name.partition(".")[0] for name in sol.names)) or "no part"
        return section("Model", tag("p", UNKNOWN), facts([("signals of", names)]), anchor="model")
    bodies = [part for part in parts if part["kind"] == "body"]
    others = [part for part in parts if part["kind"] != "body"]
    mass = sum(part["mass"] for part in bodies if isinstance(part.get("mass"), int | float))
    gx, gy = description.get("gravity", (0.0, 0.0))
    summary = [
        ("parts", f"{len(parts)}"),
        ("mass", quantity(mass, "kg")),
        ("gravity", f"({number(gx)}, {number(gy)}) {pretty('m/s^2')}"),
    ]
    body_rows = [[p["name"], p["class"], _mass(p), values_text(p["fields"])] for p in bodies]
    other_rows = [[p["name"], p["class"], _ends(p["fields"]), values_text(p["fields"])] for p in others]
    return section(
        "Model",
        facts(summary),
        table("Bodies", ["name", "class", "mass [kg]", "values"], body_rows, numbers=[2]) if bodies else None,
        table("Joints, drives, loads and other parts", ["name", "class", "between", "values"], other_rows)
        if others
        else None,
        anchor="model",
    )


def _mass(part: Mapping[str, Any]) -> str:
    mass = part.get("mass")
    return number(mass) if isinstance(mass, int | float) else "-"


def _ends(fields: Mapping[str, Any]) -> str:
    """Bodies or joints that a part connects."""
    names = [fields[key][0] for key in ("first", "second", "body", "joint") if key in fields]
    return " and ".join(str(name) for name in names if isinstance(name, str))


def values_text(fields: Mapping[str, Any]) -> str:
    """Values of a part or law in one line, from [value, unit] by field; zeros and disabled switches are left out."""
    return "; ".join(_values(fields))


def _values(fields: Mapping[str, Any]) -> Iterator[str]:
    for name, (value, unit) in fields.items():
        if name in LEFT_OUT or value is None or value is False or value == 0:
            continue
        word = name.replace("_", " ")
        if isinstance(value, Mapping):
            inner = ", ".join(_values(value["fields"]))
            yield f"{word} {value['class']}" + (f" ({inner})" if inner else "")
        elif value is True:
            yield word
        else:
            yield f"{word} {_plain(value)} {pretty(unit)}".rstrip()


def _plain(value: Any) -> str:
    if isinstance(value, list):
        return f"({', '.join(_plain(item) for item in value)})"
    if isinstance(value, Mapping):
        return str(value.get("class", ""))
    return number(value) if isinstance(value, float) else str(value)


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
