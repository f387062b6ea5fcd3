"""Live page in a cell of a notebook: a widget whose messages go to the kernel instead of a server."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import anywidget
import traitlets

from flexmb.errors import FlexmbError
from flexmb.show.live.messages import refusal

# Kinds of messages whose newest one the widget keeps, also in a saved notebook; others are sent and forgotten.
KEPT = ("run", "findings")
MOST_KEPT = 2_000_000  # length of a message at most that is kept, in signs


class Widget(anywidget.AnyWidget):
    """Live page in a cell of a notebook; made by `Page.widget`."""

    # In: script of the frame, text of the page, what hears its messages as of `Server`, newest messages by kind.
    page = traitlets.Unicode().tag(sync=True)
    run = traitlets.Unicode().tag(sync=True)
    findings = traitlets.Unicode().tag(sync=True)

    def __init__(self, script: str, page: str, heard: Callable[[Any], str | None], greeting: Mapping[str, str]) -> None:
        self._esm = script
        super().__init__(page=page, **greeting)
        self._heard = heard
        self.on_msg(self._hear)

    def tell(self, kind: str, text: str) -> None:
        """Show a message, from any thread."""
        if kind in KEPT and len(text) <= MOST_KEPT:
            self.set_trait(kind, text)
        else:
            self.send({"text": text})

    def _hear(self, _: Any, content: Any, __: Any) -> None:
        try:
            refused = self._heard(content)
        except FlexmbError as error:
            refused = str(error)
        if refused:
            self.tell("refused", refusal(refused))
