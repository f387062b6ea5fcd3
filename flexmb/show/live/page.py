"""Live page of a mechanism: its use from scripts, its HTML, messages to and from browsers, files of the newest run."""

from __future__ import annotations

import html
import secrets
import shlex
import threading
import time
import webbrowser
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from importlib.util import find_spec
from itertools import count
from pathlib import Path
from string import Template
from tempfile import TemporaryDirectory
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from flexmb import arguments, checks
from flexmb.design.parameters import Model
from flexmb.display import in_notebook
from flexmb.errors import FlexmbError, InputError
from flexmb.findings.check import Report
from flexmb.model.mechanism import Mechanism
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.results.drawing import spread_instants
from flexmb.results.solution import Solution
from flexmb.results.status import main_signals
from flexmb.run.simulate import period_or_none
from flexmb.show.live.knobs import LABEL, Knobs
from flexmb.show.live.runs import DEFAULT_PERIODS, DEFAULT_SECONDS, PERIODS, SECONDS, Request, Runner, View
from flexmb.show.live.studies import Studies
from flexmb.show.pictures.films import animate
from flexmb.show.reports.document import Markup, asset, document, embedded, floats
from flexmb.show.reports.run_page import clearance_data, curves
from flexmb.show.reports.scene import COLOURED, choices, fields_of, scene_or_reason
from flexmb.show.reports.study_pages import report

if TYPE_CHECKING:
    from flexmb.show.live.server import Server
    from flexmb.show.live.widget import Widget

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
    if isinstance(report, str):
        rows, freedom = [["error", "", report, ""]], ""
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


SCRIPTS = ("mesh.js", "scene.js", "drawing.js", "player.js", "journals.js", "diagram.js")
# Scripts of a report; style and scripts of the live page alone.
OWN = ("live.css", "controls.js", "panels.js", "studies.js", "live.js")
MOST_PAGES = 8  # pages of a notebook at a time; the oldest one is closed then
MOST_WIDGETS = 16  # widgets of a page at a time; the oldest ones are still then
TOKEN_BYTES = 24  # length of the token [bytes]
PACKAGES = {"starlette": "a live page", "uvicorn": "a live page", "websockets": "a live page"}


@arguments.checked
def explore(
    model: Model, *, vary: Mapping[str, Any] | Sequence[str] | None = None, fixed: Mapping[str, Any] | None = None,
    periods: float | None = None, t_end: float | None = None, store: str | Path | None = None,
    folder: str | Path | None = None, port: int | None = None, open: bool | None = None, block: bool | None = None,
) -> Page:  # fmt: skip
    """Live page in the browser or in a notebook: a moving mechanism with sliders, and a run at each change.

    The page listens on this machine alone (127.0.0.1), and its address holds a token.  It shows signals, orbits of
    journals, sections, spectra, largest values and findings, compares with pinned runs, and writes reports and files.
    As the last value of a cell of a notebook it is shown there, and its runs are made in the kernel.

    Parameters
    ----------
    model : a mechanism, whose numbers of parts vary ("B.clearance"); or a function that returns one, whose arguments
        vary.
    vary : ranges (low, high) by name in SI units, or lists of choices ([False, True]), or choices by label
        ({"Coulomb": law, "none": None}); a list of names: ranges from a fifth of their values to five times these;
        None: all numbers for which that is possible.
    fixed : other arguments of a function, or start values of its varied ones.
    periods, t_end : length of a run in periods of the drives, or [s]; None: two periods, or 1 s without such drives.
    store : folder that keeps the points of bifurcation diagrams, from which the same diagram goes on; None: none.
    folder : folder into which the page in a notebook saves reports, films and netCDF files; None: the working folder.
        Files that are there stay.  A browser saves where it saves all files.
    port : port of the page, so that links to it stay the same; None: a free one.
    open : whether the page is opened in the browser; None: outside of notebooks.
    block : whether the call waits until Ctrl-C; otherwise the page lives until its `close`, or the end of the program;
        None: outside of notebooks.

    Returns
    -------
    Page : with its address `url`, `set`, `code`, `widget` and `close`; a context manager.

    Raises
    ------
    InputError : another kind of model; unknown names; empty ranges, or ranges that cannot be guessed; a port in use; a
        store or a folder in which nothing can be written.
    MissingPackageError : starlette, uvicorn or websockets are not installed (`pip install 'flexmb[live]'`).

    Notes
    -----
    All browsers that know the token share one set of values, also with `set`.  A model that fails, and a run that does
    not reach its end, are told on the page.
    """
    if periods is not None and t_end is not None:
        raise InputError(f"{LABEL}: periods is {periods!r} and t_end is {t_end!r}; give one of them.")
    opened = not in_notebook() if open is None else checks.flag(LABEL, "open", open)
    waits = not in_notebook() if block is None else checks.flag(LABEL, "block", block)
    given = {} if fixed is None else checks.mapping(LABEL, "fixed", fixed)
    page = Page(Knobs(model, vary, given), length_of(periods, t_end), store=store, port=port, folder=folder)
    if in_notebook():  # where a cell that is run again makes another page
        _SHOWN.append(page)
        if len(_SHOWN) > MOST_PAGES:
            _SHOWN.pop(0).close()
    return shown(page, opened=opened, block=waits)


def shown(page: Page, *, opened: bool, block: bool) -> Page:
    """A page, opened in the browser or not, after its end or at once."""
    if opened:
        webbrowser.open(page.url)
    if block:
        page.wait()
    return page


def length_of(periods: float | None, t_end: float | None) -> tuple[str, float] | None:
    """Unit and length of the first run; None: by the drives."""
    if t_end is not None:
        return SECONDS, checks.positive(LABEL, "t_end", t_end, "s")
    return None if periods is None else (PERIODS, checks.positive(LABEL, "periods", periods))


# Pages of a notebook, the oldest one first.
_SHOWN: list[Page] = []


class Page:
    """A live page; made by `explore`."""

    # In: numbers and choices that vary; unit and length of the first run; words by which the command line finds the
    # mechanism, none for one of a script; folder of diagrams; port; folder of files. None is as for `explore`.
    def __init__(
        self, knobs: Knobs, length: tuple[str, float] | None = None, source: Sequence[str] = (),
        store: str | Path | None = None, port: int | None = None, folder: str | Path | None = None,
    ) -> None:  # fmt: skip
        number = None if port is None else checks.count(LABEL, "port", checks.between(LABEL, "port", port, 1024, 65535))
        for package, purpose in PACKAGES.items():
            checks.package(package, "live", purpose)
        kept = None if store is None else folder_of("store", store)
        saves = Path.cwd() if folder is None else folder_of("folder", folder)
        from flexmb.show.live.server import Server

        if not source and str(getattr(knobs.model, "__module__", "")).startswith("flexmb.mechanisms."):
            source = [str(getattr(knobs.model, "__name__", "")).replace("_", "-")]  # a ready one
        if length is None:
            length = PERIODS, DEFAULT_PERIODS
            with suppress(FlexmbError):  # told on the page
                if period_or_none(compile_mechanism(knobs.mechanism(knobs.start))) is None:
                    length = SECONDS, DEFAULT_SECONDS
        self._knobs, self._source = knobs, tuple(source)
        self._wanted: tuple[str, ...] = ()
        self._examination = ""
        self._telling = threading.Lock()  # an older view is never told after a newer one
        self._runner = Runner(knobs, *length, self._publish, self._publish_examination)
        self._studies = Studies(knobs, self._publish_study, kept)
        self._widgets: list[Widget] = []
        self._files = Files(lambda: self._runner.latest, self._name, saves)
        self._runner.first()  # before the page opens: code is compiled here
        token = secrets.token_urlsafe(TOKEN_BYTES)
        self._server: Server = Server(self._text, self._hear, self._greeting, self._files, token, number)
        self._runner.start()
        self._server.start()

    @property
    def url(self) -> str:
        """Address with the token, for the browser."""
        return f"http://127.0.0.1:{self._server.port}/?token={self._server.token}"

    @property
    def view(self) -> View:
        """The newest result."""
        return self._runner.latest

    def set(self, **values: Any) -> View:
        """Move sliders, and wait for the run.

        Parameters
        ----------
        values : values by name, also as texts with a unit ("0.2 mm"); of names with dots as
            `set(**{"B.clearance": 2e-4})`.

        Returns
        -------
        View : status, largest values and solution of the run.

        Raises
        ------
        InputError : a name that does not vary, a value out of its range, a page that is closed.
        """
        return self._runner.wait(self._runner.submit(values))

    def widget(self) -> Widget:
        """Widget that shows the page in a cell of a notebook; it needs anywidget (`pip install 'flexmb[live]'`)."""
        checks.package("anywidget", "live", "a live page in a notebook")
        from flexmb.show.live.widget import Widget

        made = Widget(asset("widget.js", "live"), self._text(None, ""), self._hear, self._greeting(), self._files)
        self._widgets = [*self._widgets, made][-MOST_WIDGETS:]
        return made

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        """The widget, and for places without widgets the player of the present run."""
        shown, solution = (self.widget()._repr_mimebundle_() or ({},))[0], self.view.solution
        still = solution._repr_html_() if solution else html.escape(self.view.status)
        return {**shown, "text/plain": repr(self), "text/html": still}

    def _display_(self) -> Widget:  # of marimo
        return self.widget()

    def code(self) -> str:
        """Python text that makes the mechanism with the present values."""
        return self._knobs.code(self._runner.request.values)

    def command(self) -> str:
        """Command that opens the page with the present values; "" for a model that the command line does not find."""
        return self._command(self._runner.request)

    def _command(self, request: Request | View) -> str:
        if not self._source:
            return ""
        words, of_part = ["flexmb", "explore", *self._source], isinstance(self._knobs.model, Mechanism)
        for name, value in (self._knobs.fixed | self._knobs.given(request.values)).items():
            flag = f"--{name.replace('_', '-')}"
            if isinstance(value, bool) and not of_part:
                words.append(flag if value else f"--no-{flag[2:]}")
            elif value is None or isinstance(value, bool | int | float | str):  # others cannot be typed
                text = "none" if value is None else str(value)
                words.append(f"--set={name}={text}" if of_part else f"{flag}={text}")
        length = "--periods" if self._runner.unit == PERIODS else "--t-end"
        return shlex.join([*words, f"{length}={request.length:g}"])

    def wait(self) -> None:
        """Wait until Ctrl-C or `close`; the page is closed then."""
        print(f"{self._name()}: {self.url}\nCtrl-C ends the page.", flush=True)
        try:
            while not self._runner.closed:
                time.sleep(0.2)
        except KeyboardInterrupt:
            print()
        finally:
            self.close()

    def close(self) -> None:
        """End the page: its run, its study and its server; the port is free then."""
        self._studies.stop()
        self._runner.close()
        self._server.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "closed" if self._runner.closed else self._runner.latest.status
        return f"Page of {self._name()!r} on port {self._server.port}: {state}"

    def _name(self) -> str:
        made = self._runner.latest.mechanism
        return made.name if made is not None else str(getattr(self._knobs.model, "__name__", "mechanism"))

    # From the thread of the runs

    def _publish(self, view: View | None = None) -> None:
        """A view for all browsers; None: the newest one, for a browser that asks while the next run may end."""
        with self._telling:
            self._tell(RESULT, self._told(view or self._runner.latest))

    def _tell(self, kind: str, text: str) -> None:
        self._server.tell(kind, text)
        for widget in self._widgets:
            widget.tell(kind, text)

    def _told(self, view: View) -> str:
        return run_message(view, self._wanted, self._knobs.code(view.values), self._command(view))

    def _publish_examination(self, number: int, found: Report | str) -> None:
        self._examination = examination(number, found)
        self._tell("findings", self._examination)

    def _publish_study(self, said: Mapping[str, Any]) -> None:
        self._tell(f"study {said.get('number', said['done'])}", embedded(dict(said)))

    # From the thread of the server

    def _greeting(self) -> dict[str, str]:
        examined = {"findings": self._examination} if self._examination else {}
        return {RESULT: self._told(self._runner.latest), **examined}

    def _hear(self, given: Any) -> None:
        """Fulfil a wish of a browser; wrong ones raise `InputError`."""
        message = require(given, dict, "a message")
        kind = checks.one_of(LABEL, "type", message.get("type"), KINDS)
        if kind == "set":
            values = require(message.get("values", {}), dict, "the object `values`")
            self._runner.submit({str(name): value for name, value in values.items()}, message.get("length"))
        elif kind == "want":
            names = require(message.get("signals"), list, "the list `signals`")
            self._wanted = tuple(dict.fromkeys(str(name)[:200] for name in names[-MOST_WANTED:]))
            self._publish()
        elif kind == "go":
            self._runner.go_on(require(message.get("on"), bool, "`on`"))
        elif kind == "study":
            self._studies.begin(self._runner.request.values, message)
        else:
            self._studies.stop()

    def _text(self, port: int | None, token: str) -> str:
        """Text of the page; port None: within a frame of a notebook, without a network."""
        knobs, runner = self._knobs, self._runner
        data = {
            "token": token, "title": self._name(), "knobs": [knob.described() for knob in knobs.known.values()],
            "start": dict(runner.request.values), "hidden": list(knobs.hidden),
            "length": runner.request.length, "span": runner.span.described(), "held": port is None,
        }  # fmt: skip
        text = f"Moving picture of {self._name()}. Panels hold the same in numbers."
        player = Template(asset("player.html")).substitute(text=html.escape(text), flexible=choices(tuple(COLOURED)))
        body = Template(asset("live.html", "live")).substitute(title=html.escape(self._name()), player=player)
        style, *scripts = (asset(name, "live") for name in OWN)
        network = "" if port is None else f"ws://127.0.0.1:{port} ws://localhost:{port}"
        own = (style, "\n".join(scripts))
        return document(f"{self._name()} - flexmb", Markup(body), SCRIPTS, data, own=own, network=network)
