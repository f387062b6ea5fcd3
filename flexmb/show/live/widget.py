"""Live page in a cell of a notebook: a widget whose messages go to the kernel instead of a server."""

import threading
from collections.abc import Callable, Mapping
from typing import Any

import anywidget
import traitlets

from flexmb import checks
from flexmb.errors import USER_ERRORS, InputError
from flexmb.show.live.knobs import LABEL
from flexmb.show.live.page import NAMES, Files, answer, refusal
from flexmb.show.reports.document import embedded

# Kinds of messages whose newest one the widget keeps, also in a saved notebook; others are sent and forgotten.
KEPT = ("run", "findings")
MOST_KEPT = 2_000_000  # length of a message at most that is kept, in signs


class Widget(anywidget.AnyWidget):
    """Live page in a cell of a notebook; made by `Page.widget`."""

    # In: script of the frame, text of the page, what hears its messages as of `Server`, newest messages by kind, files.
    page = traitlets.Unicode().tag(sync=True)
    run = traitlets.Unicode().tag(sync=True)
    findings = traitlets.Unicode().tag(sync=True)

    def __init__(
        self, script: str, page: str, heard: Callable[[Any], None], greeting: Mapping[str, str], files: Files
    ) -> None:
        self._esm = script
        super().__init__(page=page, **greeting)
        self._heard, self._files = heard, files
        self._writer = threading.Thread(target=self._write, daemon=True)
        self.on_msg(self._hear)

    def tell(self, kind: str, text: str) -> None:
        """Show a message, from any thread."""
        if kind in KEPT and len(text) <= MOST_KEPT:
            self.set_trait(kind, text)
        else:
            self.send({"text": text})

    def _hear(self, _: Any, content: Any, __: Any) -> None:
        asks = isinstance(content, dict) and content.get("type") == "save"
        if refused := answer(self._save if asks else self._heard, content):
            self.tell("refused", refused)

    def _save(self, message: Mapping[str, Any]) -> None:
        """Write a file in a thread, since a film takes seconds."""
        if self._writer.is_alive():
            raise InputError(f"{LABEL}: an earlier file is still being written. Try again in a moment.")
        name = checks.one_of(LABEL, "file", message.get("file"), NAMES)
        self._writer = threading.Thread(target=self._write, args=(name,), name="flexmb file", daemon=True)
        self._writer.start()

    def _write(self, name: str) -> None:
        try:
            self.tell("saved", embedded({"type": "saved", "text": f"Saved as {self._files.saved(name)}"}))
        except USER_ERRORS as error:  # also of a full disk
            self.tell("refused", refusal(str(error)))
