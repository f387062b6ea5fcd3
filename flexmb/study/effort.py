"""Lengths of the runs of a study: the whole study, or a quick look at all of it."""

from __future__ import annotations

from dataclasses import dataclass

from flexmb.study.case import Case
from flexmb.study.exponent import attractor
from flexmb.study.motion import motion
from flexmb.study.run import StudyRun


@dataclass(frozen=True)
class Effort:
    """Lengths of the runs.

    Parameters
    ----------
    name : "full" or "quick".
    skip : turns before the first that counts: those of the soft start, and others until it has died out.
    keep : turns that count, in means and spreads.
    shown : last ones of these, which curves show.
    settle, points : periods before the first point of a section, and points.
    series : periods of finely saved signals for exponents from time series.
    values : about how many values of the parameter a diagram has; None: all.
    diagram_settle, diagram_points : periods before the first point, and points, at each value of a diagram.
    exponents : whether diagrams find the exponent at each value.
    elements : beam elements of a link in long runs; None: the usual number.
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
    elements: int | None = None

    @property
    def full(self) -> bool:
        """Whether this effort computes the whole study."""
        return self.name == "full"

    def settled(self, case: Case, turns: int | None = None) -> StudyRun:
        """The run of settled turns of a case; `turns` in place of the usual number."""
        return motion(case, self.skip, turns or self.keep, self.shown)

    def attractor(self, case: Case) -> StudyRun:
        """The long run of a case with clearance."""
        return attractor(case, self.settle, self.points, self.series)


FULL = Effort("full", 7, 20, 2, 40, 100, 100, None, 20, 50, exponents=True)
QUICK = Effort("quick", 3, 3, 2, 5, 50, 45, 9, 3, 9, exponents=False, elements=2)
EFFORTS = {effort.name: effort for effort in (FULL, QUICK)}
