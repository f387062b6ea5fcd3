"""Figure that is saved into a folder which need not exist, and writes names in any script."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from matplotlib.text import Text

from flexmb.pictures.glyphs import make_drawable


class Picture(Figure):
    """matplotlib's figure; saving it makes the folder of the file, drawing it finds fonts for all characters."""

    def draw(self, renderer: Any) -> None:
        """Draw the figure.

        Parameters
        ----------
        renderer : what draws it.
        """
        make_drawable(text for text in self.findobj(Text) if isinstance(text, Text))
        super().draw(renderer)

    def savefig(self, fname: Any, **options: Any) -> None:
        """Save the figure.

        Parameters
        ----------
        fname : path of the file, or an open file.
        options : options of `matplotlib.figure.Figure.savefig`.
        """
        if isinstance(fname, (str, Path)):
            Path(fname).parent.mkdir(parents=True, exist_ok=True)
        super().savefig(fname, **options)
