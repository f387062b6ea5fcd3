"""Figure and page of a study, with their runs and the functions that draw and write them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from nine_bar_study.run import Results, StudyRun

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class StudyFigure:
    """Figure of a study: number, title, runs and drawing.

    Parameters
    ----------
    number : number of the figure in the published study.
    title : caption of the figure.
    runs : runs of the shown results.
    draw : function of the results that returns the picture and the dataset of the shown numbers [SI].
    """

    number: int
    title: str
    runs: tuple[StudyRun, ...]
    draw: Callable[[Results], tuple[Figure, xr.Dataset]]

    @property
    def label(self) -> str:
        """Name of the figure in messages and tables."""
        return f"figure {self.number}"


@dataclass(frozen=True)
class StudyPage:
    """Page of a study: claims, exponents, sensitivity, convergence, threshold.

    Parameters
    ----------
    name : name in the command, and stem of the files.
    title : heading of the page.
    runs : runs of the shown results.
    write : function of the results that returns the text (Markdown without heading) and the dataset of the numbers.
    draw : function of the results that returns picture and dataset; None: page without picture.
    slow : whether the page is omitted unless its name or "all" is given.
    """

    name: str
    title: str
    runs: tuple[StudyRun, ...]
    write: Callable[[Results], tuple[str, xr.Dataset]]
    draw: Callable[[Results], tuple[Figure, xr.Dataset]] | None = None
    slow: bool = False

    @property
    def label(self) -> str:
        """Name of the page in messages and tables."""
        return self.name


def once(runs: Sequence[StudyRun]) -> tuple[StudyRun, ...]:
    """Runs without repetitions, in order of first occurrence."""
    return tuple(dict.fromkeys(runs))
