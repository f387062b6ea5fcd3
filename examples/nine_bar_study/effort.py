"""Lengths of the runs of a study: full or quick."""

from __future__ import annotations

from dataclasses import dataclass

from nine_bar_study.case import Case
from nine_bar_study.exponent import attractor
from nine_bar_study.motion import motion
from nine_bar_study.run import StudyRun


@dataclass(frozen=True)
class Effort:
    """Lengths of the runs of a study.

    Parameters
    ----------
    name : "full" or "quick".
    skip : turns before the first settled turn, including the ramp of the drives.
    keep : settled turns, over which means and deviations are computed.
    shown : last settled turns, saved at every step for the curves.
    settle, points : periods before the first section point, and number of section points.
    series : periods of evenly sampled signals for exponents from time series.
    values : approximate number of values of the parameter in a diagram; None: all.
    diagram_settle, diagram_points : periods before the first section point, and number of section points, at each
        value of a diagram.
    exponents : whether diagrams contain the exponent at each value.
    elements : beam elements per link in long runs; None: default of the machine.
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
        """Whether the effort is the full one."""
        return self.name == "full"

    def settled(self, case: Case, turns: int | None = None) -> StudyRun:
        """Run of the settled turns of a case; `turns` replaces `keep`."""
        return motion(case, self.skip, turns or self.keep, self.shown)

    def attractor(self, case: Case) -> StudyRun:
        """Long run of a case with clearance."""
        return attractor(case, self.settle, self.points, self.series)


FULL = Effort("full", 7, 20, 2, 40, 100, 100, None, 20, 50, exponents=True)
QUICK = Effort("quick", 4, 10, 2, 5, 50, 25, 7, 3, 9, exponents=False, elements=2)
