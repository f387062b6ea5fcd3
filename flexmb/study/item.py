"""A figure and a page of a study: the runs that they need, and how they are made from the results."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexmb.study.run import Results, StudyRun

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class StudyFigure:
    """A figure of a study.

    Parameters
    ----------
    number : of the figure in the published study.
    title : caption.
    runs : runs whose results it shows.
    draw : from the results to the picture and to a dataset with exactly the shown numbers, axes in SI units.
    """

    number: int
    title: str
    runs: tuple[StudyRun, ...]
    draw: Callable[[Results], tuple[Figure, xr.Dataset]]

    @property
    def label(self) -> str:
        """Name in messages and tables."""
        return f"figure {self.number}"

    @property
    def heading(self) -> str:
        """Number and caption."""
        return f"Figure {self.number}: {self.title}"


@dataclass(frozen=True)
class StudyPage:
    """A table of a study: claims, exponents, sensitivity, convergence.

    Parameters
    ----------
    name : name in the command, and stem of its files.
    title : heading.
    runs : runs whose results it needs.
    write : from the results to the text (Markdown, without a heading) and to a dataset with its numbers.
    draw : as of a figure, for a page with a picture; None: it has none.
    slow : whether it is left out unless it is asked for by its name or by "all".
    """

    name: str
    title: str
    runs: tuple[StudyRun, ...]
    write: Callable[[Results], tuple[str, xr.Dataset]]
    draw: Callable[[Results], tuple[Figure, xr.Dataset]] | None = None
    slow: bool = False

    @property
    def label(self) -> str:
        """Name in messages and tables."""
        return self.name


def once(runs: Sequence[StudyRun]) -> tuple[StudyRun, ...]:
    """The runs in their order, each once."""
    return tuple(dict.fromkeys(runs))
