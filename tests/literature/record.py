"""How a problem of the literature states what it found: values beside references, curves beside orders, pictures.

A file of this folder defines one `Problem`, hangs its cases on it, and ends with
`test_case, test_curves = PROBLEM.tests()`.
The same cases make docs/validation.md (`make validation`).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest


@dataclass(frozen=True)
class Value:
    """One number beside its reference.

    Parameters
    ----------
    quantity : what it is, with its unit in brackets.
    reference : what the source says.
    ours : what flexmb says.
    band : largest accepted error.
    scale : what the error is divided by; None: |reference|; 1.0: nothing, the band is in the unit of the quantity.
    missed : why the band is missed, where it is; then `limit` is what the error must keep nevertheless.
    limit : see `missed`.

    Raises
    ------
    ValueError : a reference of 0 without a scale; a band that is missed without a limit.
    """

    quantity: str
    reference: float
    ours: float
    band: float
    scale: float | None = None
    missed: str = ""
    limit: float | None = None

    def __post_init__(self) -> None:
        if self.scale is None and self.reference == 0.0:
            raise ValueError(f"{self.quantity}: an error relative to a reference of 0 says nothing; give scale=1.0.")
        if self.missed and self.limit is None:
            raise ValueError(f"{self.quantity}: misses its band; give the limit that it keeps.")

    @property
    def error(self) -> float:
        """Difference over the scale."""
        return abs(self.ours - self.reference) / (abs(self.reference) if self.scale is None else self.scale)

    @property
    def holds(self) -> bool:
        """Whether the band is kept, or, where that is said to be impossible, the limit (and the word still true)."""
        if self.missed:
            return self.limit is not None and self.band < self.error <= self.limit
        return self.error <= self.band


@dataclass(frozen=True)
class Curve:
    """Errors over element lengths or steps, and the order they must show.

    Parameters
    ----------
    label : what the curve belongs to.
    x : sizes, in the unit of the figure.
    errors : errors at these sizes.
    order : slope that the log-log fit must reach within `slack`; higher is welcome.
    slack : see `order`.

    Raises
    ------
    ValueError : other than one error for each of at least two sizes.
    """

    label: str
    x: Sequence[float]
    errors: Sequence[float]
    order: float
    slack: float = 0.1

    def __post_init__(self) -> None:
        if not len(self.x) == len(self.errors) >= 2:
            raise ValueError(f"{self.label}: {len(self.x)} sizes and {len(self.errors)} errors make no curve.")

    @property
    def slope(self) -> float:
        """Slope of the straight line through the points in logarithms."""
        return float(np.polyfit(np.log(self.x), np.log(self.errors), 1)[0])


@dataclass(frozen=True)
class Case:
    """One way to compute the problem: a title such as "16 elements", and the function that returns its values."""

    title: str
    compute: Callable[[], Iterable[Value]]
    slow: bool = False


@dataclass(frozen=True)
class Figure:
    """A figure of docs/validation.md: curves with measured slopes, or a drawing."""

    name: str
    caption: str
    draw: Callable[[Any], None] | None = None
    curves: Callable[[], Iterable[Curve]] | None = None
    axes: tuple[str, str] = ("", "")
    slow: bool = False


@dataclass
class Problem:
    """A problem of the literature.

    Parameters
    ----------
    title : its name.
    source : where the reference values come from.
    kind : "published", "exact", or "computed once", and by what.
    about : a few sentences: the model, what it tests, what to know of the numbers.
    """

    title: str
    source: str
    kind: str
    about: str
    cases: list[Case] = field(default_factory=list)
    figures: list[Figure] = field(default_factory=list)

    def case(self, title: str, *, slow: bool = False) -> Callable[[Any], Any]:
        """Decorator: a function without arguments that returns values."""

        def keep(function: Callable[[], Iterable[Value]]) -> Callable[[], Iterable[Value]]:
            self.cases.append(Case(title, function, slow))
            return function

        return keep

    def picture(self, name: str, caption: str) -> Callable[[Any], Any]:
        """Decorator: a function that draws into a matplotlib figure."""

        def keep(function: Callable[[Any], None]) -> Callable[[Any], None]:
            self.figures.append(Figure(name, caption, draw=function))
            return function

        return keep

    def convergence(self, name: str, caption: str, x: str, y: str, *, slow: bool = False) -> Callable[[Any], Any]:
        """Decorator: a function without arguments that returns curves; x and y name the axes with their units."""

        def keep(function: Callable[[], Iterable[Curve]]) -> Callable[[], Iterable[Curve]]:
            self.figures.append(Figure(name, caption, curves=function, axes=(x, y), slow=slow))
            return function

        return keep

    def tests(self) -> tuple[Callable[..., None], Callable[..., None]]:
        """The tests of all cases and of all curves."""

        @pytest.mark.parametrize("case", [_marked(c, c.title, c.slow) for c in self.cases])
        def test_case(case: Case) -> None:
            values = list(case.compute())
            for v in values:
                print(f"{v.quantity}: {v.ours:.12g}, reference {v.reference:.12g}, error {v.error:.2e} ({v.band:.0e})")
            assert values, "a case without values checks nothing"
            wrong = [v for v in values if not v.holds]
            assert not wrong, "\n".join(f"{v.quantity}: {v.ours!r} against {v.reference!r}" for v in wrong)

        drawn = [_marked(f, f.name, f.slow) for f in self.figures if f.curves is not None]

        @pytest.mark.slow
        @pytest.mark.parametrize("figure", drawn)
        def test_curves(figure: Figure) -> None:
            assert figure.curves is not None
            for curve in figure.curves():
                print(f"{curve.label}: errors {np.array(curve.errors)}, slope {curve.slope:.2f}, order {curve.order}")
                assert curve.slope >= curve.order - curve.slack, curve.label

        return test_case, test_curves


def timed(case: Case) -> tuple[list[Value], float]:
    """The values of a case and the wall time they took [s]."""
    began = time.perf_counter()
    values = list(case.compute())
    return values, time.perf_counter() - began


def _marked(item: Any, name: str, slow: bool) -> Any:
    return pytest.param(item, id=name, marks=[pytest.mark.slow] if slow else [])
