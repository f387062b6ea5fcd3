"""Figure that is saved into a folder which need not exist, and writes names in any script."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib import rcParams
from matplotlib.figure import Figure
from matplotlib.text import Text

from flexmb.dynamics.jobs.files import whole_file
from flexmb.show.pictures.style import make_drawable


class Picture(Figure):
    """matplotlib's figure; saving it makes the folder of the file, drawing it finds fonts for all characters."""

    def draw(self, renderer: Any) -> None:
        """Draw the figure."""
        make_drawable(text for text in self.findobj(Text) if isinstance(text, Text))
        super().draw(renderer)

    def savefig(self, fname: Any, **options: Any) -> None:
        """Save the figure as a file, which is there as a whole or not at all, or into an open file.

        Options are those of `matplotlib.figure.Figure.savefig`.  A path that cannot be written and an ending that is no
        kind of picture raise `InputError`.
        """
        if not isinstance(fname, (str, Path)):
            super().savefig(fname, **options)
            return
        path = Path(fname)
        if not path.suffix:
            path = path.with_name(f"{path.name}.{options.get('format') or rcParams['savefig.format']}")
        with whole_file(path) as part:
            super().savefig(part, **options)
