"""Messages of a live page to its browsers: views, examinations; wishes of browsers, checked."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError, InputError
from flexmb.findings.check import Report
from flexmb.results.drawing import nearest_instants
from flexmb.results.solution import Solution
from flexmb.results.status import main_signals
from flexmb.show.live.knobs import LABEL
from flexmb.show.live.runs import View
from flexmb.show.reports.document import embedded, floats
from flexmb.show.reports.run_page import clearance_data, curves
from flexmb.show.reports.scene import fields_of, scene

FRAMES = 300  # largest number of frames of a message
MAIN, MOST_WANTED = 2, 40  # numbers of main signals, and of other ones at most, in a message
LENGTH = ""  # name of the length of a run among the fields of the page
RESULT = "run"  # kind of the messages of views


def run_message(view: View, wanted: tuple[str, ...], code: str, command: str) -> str:
    """Message of a view with the main signals and other ones, and with texts that make the mechanism."""
    said: dict[str, Any] = {
        "type": "run", "number": view.number, "values": dict(view.values), "length": view.length,
        "status": view.status, "ok": view.ok, "done": view.done, "code": code, "command": command,
    }  # fmt: skip
    if view.solution is not None:
        said |= _result(view, view.solution, wanted)
    return embedded(said)


def _result(view: View, sol: Solution, wanted: tuple[str, ...]) -> dict[str, Any]:
    """Scene, signals, journals, section points and largest values of a run; nothing where no row is finite."""
    frames = np.arange(len(sol.time))
    if len(frames) > FRAMES:
        frames = nearest_instants(sol, np.linspace(sol.time[0], sol.time[-1], FRAMES))
    frames = frames[np.isfinite(sol.values[frames]).all(axis=1)]
    if len(frames) == 0:
        return {}
    main = [name for name in main_signals(sol) if name in sol]
    names = list(dict.fromkeys([*main[:MAIN], *(name for name in wanted if name in sol)])) or list(sol.names[:1])
    try:
        drawn, missing = scene(sol, view.mechanism, frames), ""
    except FlexmbError as error:
        drawn, missing = None, str(error)
    peaks = [[name, *sol.peak(name)[:2], sol.units(name)] for name in dict.fromkeys([*main, *wanted]) if name in sol]
    found: dict[str, Any] = {
        "scene": drawn, "missing": missing, "fields": fields_of(drawn) if drawn else [],
        "signals": curves(sol, names, frames), "journals": clearance_data(sol, frames),
        "known": list(sol.names), "units": list(sol.signals.units),
        "peaks": peaks, "notes": list(sol.notes), "seconds": sol.stats.wall_time,
        "main": main[:MAIN] or names,
    }  # fmt: skip
    if view.period is not None and view.section.shape[1:] == (len(sol.names),):
        places = [sol.names.index(name) for name in names if name in sol.names]
        points = floats(np.ascontiguousarray(view.section[:, places]))
        found["section"] = {"names": [sol.names[k] for k in places], "points": points, "period": view.period}
    return found


def examination(number: int, report: Report | str) -> str:
    """Message of an examination."""
    rows, freedom = [], ""
    if isinstance(report, str):
        rows = [["error", "", report, ""]]
    else:
        rows = [[f.severity, f.code, f.text, f.remedy] for f in report.findings]
        freedom = f"Degrees of freedom: {report.freedom} (rigid, clearances closed), {report.free} not driven."
    return embedded({"type": "findings", "number": number, "rows": rows, "freedom": freedom})


def refusal(text: str, field: str | None = None) -> str:
    """Message on something refused; `field`: name of the value, or kind of the study, to which it belongs."""
    return embedded({"type": "refused", "text": text, "field": field})


def answer(heard: Callable[[Any], None], given: Any) -> str | None:
    """Refusal of a message that a browser has sent; None where it was met."""
    try:
        heard(given)
    except FlexmbError as error:
        message = given if isinstance(given, dict) else {}
        values = message.get("values")
        fields = [*(values if isinstance(values, dict) else ()), *([LENGTH] if "length" in message else ())]
        fields += [message["kind"]] if "kind" in message else []
        return refusal(str(error), str(fields[0])[:200] if len(fields) == 1 else None)
    return None


KINDS = ("set", "want", "go", "study", "stop", "open")  # kinds of messages from browsers


def require(given: Any, kind: type, what: str) -> Any:
    """`given` if it is of a kind, else `InputError`."""
    if not isinstance(given, kind) or (kind is not bool and isinstance(given, bool)):
        raise InputError(f"{LABEL}: {what} is missing or of a wrong kind.")
    return given
