"""Small player of a run in a notebook: a page within a frame, without kernel and network."""

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.results.drawing import nearest_instants
from flexmb.results.solution import Solution
from flexmb.show.reports.document import Markup, document, instants, tag
from flexmb.show.reports.scene import fields_of, player, scene

SCRIPTS = ("mesh.js", "scene.js", "drawing.js", "player.js", "cell.js")
FRAMES = (200, 100, 50, 25)  # numbers of frames, of which the first is taken that keeps to `MOST_SIGNS`
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
    finite = np.flatnonzero(np.isfinite(sol.values).all(axis=1))
    for most in FRAMES if sol.shapes and len(finite) else ():
        frames = finite
        if len(finite) > most:
            along = np.linspace(sol.time[finite[0]], sol.time[finite[-1]], most)
            frames = np.intersect1d(nearest_instants(sol, along), finite)
        try:
            made = _framed(sol, frames)
        except FlexmbError:  # poses that were not saved
            break
        if len(made) <= MOST_SIGNS:
            return made
    return Markup()


def _framed(sol: Solution, frames: np.ndarray) -> Markup:
    """Frame that holds the page of a player, whose scripts reach nothing outside of it."""
    drawn = scene(sol, sol.mechanism, frames)
    data = {"time": instants(sol.time[frames]), "scene": drawn}
    text = document(sol.name, player(sol, sol.name, fields=fields_of(drawn)), SCRIPTS, data, own=(STYLE, ""))
    style = f"width: 100%; height: {HEIGHT}px; border: 0"
    return tag("iframe", srcdoc=text, sandbox="allow-scripts", title=f"Motion of {sol.name}", style=style)
