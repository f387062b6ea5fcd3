"""Figure that is saved into a folder which need not exist."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib.figure import Figure


class Picture(Figure):
    """matplotlib's figure; saving it makes the folder of the file."""

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
