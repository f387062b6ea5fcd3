"""How much is computed: the whole study, or a quick look at all of it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Effort:
    """Lengths of the runs.

    Parameters
    ----------
    name : what it is called.
    skip : turns before the first that counts: those of the soft start, and others until it has died out.
    keep : turns that count, in means and spreads.
    shown : of these the last ones that curves show.
    settle, points : periods before the first point of a section, and points.
    series : periods of finely saved signals for exponents from time series.
    values : about how many values of the parameter a diagram has; None: all.
    diagram_settle, diagram_points : periods before the first point, and points, at each value of a diagram.
    exponents : whether diagrams find the exponent at each value.
    """

    name: str
    skip: int
    keep: int
    shown: int
    settle: int
    points: int
    series: int
    values: int | None
    diagram_settle: int
    diagram_points: int
    exponents: bool


FULL = Effort("full", 7, 20, 2, 40, 100, 100, None, 20, 50, exponents=True)
QUICK = Effort("quick", 3, 3, 2, 5, 50, 45, 9, 3, 9, exponents=False)
EFFORTS = {effort.name: effort for effort in (FULL, QUICK)}
