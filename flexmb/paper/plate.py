"""What figures and tables of the study consist of: the runs they need, and how they are made from their results."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


class Run(Protocol):
    """Something that takes time to compute; a frozen dataclass, so that equal runs are one."""

    @property
    def name(self) -> str:
        """Stem of the file in which the result is kept; different runs have different names."""

    @property
    def work(self) -> float:
        """About how much processor time it takes [s]."""

    def fingerprint(self) -> str:
        """A short text that changes with everything the result depends on."""

    def compute(self) -> xr.Dataset:
        """The result, in one process.  Failure is an exception: a result is complete."""


Results = Mapping[Any, "xr.Dataset"]
"""Results by their runs."""


@dataclass(frozen=True)
class Plate:
    """A figure of the paper.

    Parameters
    ----------
    number : of the figure in the paper.
    title : what it shows.
    runs : runs whose results it shows.
    draw : from the results to the picture and to a dataset with exactly what is shown, axes in SI units.
    """

    number: int
    title: str
    runs: tuple[Run, ...]
    draw: Callable[[Results], tuple[Figure, xr.Dataset]]


@dataclass(frozen=True)
class Page:
    """A table of the study: claims, exponents, sensitivity, convergence, the threshold of speed.

    Parameters
    ----------
    name : by which it is asked for, and the stem of its files.
    title : what it shows.
    runs : runs whose results it needs.
    write : from the results to the text (Markdown, without a heading) and to a dataset with its numbers.
    draw : as of a plate, for a page with a picture; None: it has none.
    slow : whether it is left out unless it is asked for by its name or by "all".
    """

    name: str
    title: str
    runs: tuple[Run, ...]
    write: Callable[[Results], tuple[str, xr.Dataset]]
    draw: Callable[[Results], tuple[Figure, xr.Dataset]] | None = None
    slow: bool = False
