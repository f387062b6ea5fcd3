"""Messages of a live page to its browsers, wishes of browsers, checked, and files of the newest run."""

import threading
from collections.abc import Callable
from importlib.util import find_spec
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from flexmb import checks
from flexmb.errors import FlexmbError, InputError
from flexmb.findings.check import Report
from flexmb.results.drawing import spread_instants
from flexmb.results.solution import Solution
from flexmb.results.status import main_signals
from flexmb.show.live.knobs import LABEL
from flexmb.show.live.runs import View
from flexmb.show.pictures.films import animate
from flexmb.show.reports.document import embedded, floats
from flexmb.show.reports.run_page import clearance_data, curves
from flexmb.show.reports.scene import fields_of, scene_or_reason
from flexmb.show.reports.study_pages import report

NAMES = ("report.html", "film", "run.nc")  # names by which a page asks for a file
STORE_ENTRY = "zarr.json"  # file in each folder that is itself a store


def folder_of(name: str, given: str | Path) -> Path:
    """A folder in which files can be written, made where it does not exist; else `InputError`."""
    folder = checks.path(LABEL, given).absolute()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix=".flexmb-", dir=folder):
            pass
    except OSError as error:
        what = "is a file, and no folder" if folder.is_file() else f"takes no files ({error.strerror})"
        raise InputError(f"{LABEL}: {name} {str(given)!r} {what}. Give a folder in which you may write.") from error
    if (folder / STORE_ENTRY).exists():
        text = f"{LABEL}: {name} {str(given)!r} is itself the store of a sweep"
        raise InputError(f"{text}. Give the folder above it, or a new one.")
    return folder


class Files:
    """Files of the newest run, `view()`, of a page with a title; `folder`: where a notebook saves them."""

    def __init__(self, view: Callable[[], View], title: Callable[[], str], folder: Path) -> None:
        self.view, self.title, self.folder = view, title, folder
        self.filming = threading.Lock()

    def written(self, name: str, folder: Path) -> Path:
        """A file of the newest run, written into a folder."""
        view = self.view()
        if view.solution is None:
            raise InputError(f"{LABEL}: there is no run to save: {view.status}")
        sol = view.solution
        stem = "".join(sign if sign.isalnum() or sign in "-_" else "-" for sign in self.title())[:80] or "run"
        if name == "report.html":
            return report(sol, folder / f"{stem}.html", mechanism=view.mechanism)
        if name == "run.nc":
            return Path(sol.to_netcdf(folder / f"{stem}.nc"))
        kind = "gif" if find_spec("imageio_ffmpeg") is None else "mp4"
        with self.filming:  # one at a time: each takes a processor for seconds
            return animate(sol, folder / f"{stem}.{kind}")

    def saved(self, name: str) -> Path:
        """A file of the newest run in the folder of the page; a name that is taken gets a number."""
        with TemporaryDirectory(prefix=".flexmb-", dir=folder_of("folder", self.folder)) as place:
            made = self.written(name, Path(place))
            names = (f"{made.stem}{f'-{k}' if k > 1 else ''}{made.suffix}" for k in count(1))
            return made.rename(next(self.folder / one for one in names if not (self.folder / one).exists()))


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
    frames = spread_instants(sol, FRAMES)
    frames = frames[np.isfinite(sol.values[frames]).all(axis=1)]
    if len(frames) == 0:
        return {}
    main = [name for name in main_signals(sol) if name in sol]
    names = list(dict.fromkeys([*main[:MAIN], *(name for name in wanted if name in sol)])) or list(sol.names[:1])
    drawn, missing = scene_or_reason(sol, view.mechanism, frames)
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
