"""Live page of a mechanism: its use from scripts, and its HTML."""

from __future__ import annotations

import html
import secrets
import shlex
import time
import webbrowser
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from string import Template
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from flexmb import arguments, checks
from flexmb.design.parameters import Model
from flexmb.display import in_notebook
from flexmb.errors import FlexmbError, InputError
from flexmb.findings.check import Report
from flexmb.model.mechanism import Mechanism
from flexmb.program.compiler import compile as compile_mechanism
from flexmb.run.simulate import period_or_none
from flexmb.show.live import messages
from flexmb.show.live.knobs import LABEL, Knobs
from flexmb.show.live.messages import Files, folder_of
from flexmb.show.live.runs import DEFAULT_PERIODS, DEFAULT_SECONDS, PERIODS, SECONDS, Request, Runner, View
from flexmb.show.live.studies import Studies
from flexmb.show.reports.document import Markup, asset, document, embedded
from flexmb.show.reports.scene import COLOURED, choices

if TYPE_CHECKING:
    from flexmb.show.live.server import Server
    from flexmb.show.live.widget import Widget

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
            words += _typed(name, value, of_part=of_part)
        flag = "--periods" if self._runner.unit == PERIODS else "--t-end"
        return shlex.join([*words, f"{flag}={request.length:g}"])

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

    def _publish(self, view: View) -> None:
        self._tell(messages.RESULT, self._told(view))

    def _tell(self, kind: str, text: str) -> None:
        self._server.tell(kind, text)
        for widget in self._widgets:
            widget.tell(kind, text)

    def _told(self, view: View) -> str:
        return messages.run_message(view, self._wanted, self._knobs.code(view.values), self._command(view))

    def _publish_examination(self, number: int, found: Report | str) -> None:
        self._examination = messages.examination(number, found)
        self._tell("findings", self._examination)

    def _publish_study(self, said: Mapping[str, Any]) -> None:
        self._tell(f"study {said.get('number', said['done'])}", embedded(dict(said)))

    # From the thread of the server

    def _greeting(self) -> dict[str, str]:
        examined = {"findings": self._examination} if self._examination else {}
        return {messages.RESULT: self._told(self._runner.latest), **examined}

    def _hear(self, given: Any) -> None:
        """Fulfil a wish of a browser; wrong ones raise `InputError`."""
        message = messages.require(given, dict, "a message")
        kind = checks.one_of(LABEL, "type", message.get("type"), messages.KINDS)
        if kind == "set":
            values = messages.require(message.get("values", {}), dict, "the object `values`")
            self._runner.submit({str(name): value for name, value in values.items()}, message.get("length"))
        elif kind == "want":
            names = messages.require(message.get("signals"), list, "the list `signals`")
            self._wanted = tuple(dict.fromkeys(str(name)[:200] for name in names[-messages.MOST_WANTED :]))
            self._publish(self._runner.latest)
        elif kind == "go":
            self._runner.go_on(messages.require(message.get("on"), bool, "`on`"))
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


def _typed(name: str, value: Any, *, of_part: bool) -> list[str]:
    """Words of the command line for a number, switch or text; none for other values."""
    flag = f"--{name.replace('_', '-')}"
    if isinstance(value, bool) and not of_part:
        return [flag if value else f"--no-{flag[2:]}"]
    if not (value is None or isinstance(value, bool | int | float | str)):
        return []
    text = "none" if value is None else str(value)
    return [f"--set={name}={text}" if of_part else f"{flag}={text}"]
