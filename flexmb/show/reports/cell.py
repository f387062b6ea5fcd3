"""Small player of a run for a cell of a notebook: a frame with a page of its own, without kernel and network."""

from __future__ import annotations

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.results.drawing import nearest_instants
from flexmb.results.solution import Solution
from flexmb.show.reports.document import Content, Markup, document, instants, tag
from flexmb.show.reports.scene import fields_of, player, scene

SCRIPTS = ("mesh.js", "scene.js", "drawing.js", "player.js", "cell.js")

FRAMES = (200, 100, 50, 25)
"""Numbers of frames, of which the first is taken that keeps to `MOST_SIGNS`."""

MOST_SIGNS = 200_000  # length of the HTML of a player at most
HEIGHT = 460  # height of the frame [CSS pixel]

STYLE = """
body { background: none; }
.player { height: 100vh; display: flex; flex-direction: column; padding: 10px 12px; }
.picture { flex: 1; min-height: 0; display: flex; flex-direction: column; }
#picture { flex: 1; min-height: 0; height: auto; }
#keys { display: none; }
"""


def cell(sol: Solution) -> Markup:
    """Frame with the player of a run; empty for a run that cannot be drawn, or whose motion is too long a text."""
    if not sol.shapes or not len(sol.time):
        return Markup()
    finite = np.flatnonzero(np.isfinite(sol.values).all(axis=1))
    for most in FRAMES:
        try:
            frames = _frames(sol, finite, most)
            made = framed(_page(sol, frames), f"Motion of {sol.name}", HEIGHT) if len(frames) else Markup()
        except FlexmbError:  # poses that were not saved
            return Markup()
        if len(made) <= MOST_SIGNS:
            return made
    return Markup()


def framed(text: str, title: str, height: int) -> Markup:
    """Frame that holds the text of a page, whose scripts reach nothing outside of it."""
    style = f"width: 100%; height: {height}px; border: 0"
    return tag("iframe", srcdoc=text, sandbox="allow-scripts", title=title, style=style)


def _frames(sol: Solution, finite: np.ndarray, most: int) -> np.ndarray:
    """Numbers of saved instants with finite values, `most` of them about, evenly over the time."""
    if len(finite) <= most:
        return finite
    chosen = nearest_instants(sol, np.linspace(sol.time[finite[0]], sol.time[finite[-1]], most))
    return chosen[np.isin(chosen, finite)]


def _page(sol: Solution, frames: np.ndarray) -> str:
    """Text of the page of a player."""
    drawn = scene(sol, sol.mechanism, frames)
    body: Content = player(sol, sol.name, fields=fields_of(drawn))
    return document(
        sol.name, Markup(body), SCRIPTS, {"time": instants(sol.time[frames]), "scene": drawn}, own=(STYLE, "")
    )
