"""Figures and pages of the study of Chen, Jiang, Deng and Wang (Nonlinear Dynamics, 2018)."""

from __future__ import annotations

from nine_bar_study.claims.page import claims_page
from nine_bar_study.effort import Effort
from nine_bar_study.item import StudyPage
from nine_bar_study.nine_bar.cases import case
from nine_bar_study.nine_bar.claims import CLAIMS
from nine_bar_study.nine_bar.figures import figures
from nine_bar_study.nine_bar.pages.convergence import convergence
from nine_bar_study.nine_bar.pages.damping import damping
from nine_bar_study.nine_bar.pages.exponents import exponents
from nine_bar_study.nine_bar.pages.sensitivity import sensitivity
from nine_bar_study.nine_bar.pages.threshold import threshold
from nine_bar_study.nine_bar.plan import attacks, plan
from nine_bar_study.study import Study

INTRODUCTION = """
Each claim is decided by the rule that stands above its parts. The rules were written down before the numbers were
looked at, with these exceptions. Claim 13 had parts on speeds between, which the paper does not compare; claim 3
looked at two turns alone; claims 14 to 17 were added after the others.
"Periodic", in claims 7 to 10, asked for an exponent three errors below zero, until it was found that only the damping
of coarse steps had given the rigid mechanism one; now the points must return, and the exponent must not be above zero.
In claims 9 and 10 the diagrams alone decided, whose points are shorter runs; of three of them a longer one was needed.
And parts that disagreed in the first runs, but not in finer or longer ones, did disagree; now they are not decided.

A claim agrees when all its parts do, and disagrees when one of them does. Means are those of successive settled turns;
a value after ± is the standard deviation from turn to turn, and the interval of a ratio holds it with 99.7 %
probability, with the correlation of neighbouring turns taken into account. In comparisons (`compare` in the rules)
"higher" and "lower" mean that the whole interval of the difference lies beyond 1 % of the larger mean, "equal" that it
lies within 5 %. What cannot be told from the spread of the turns is not decided. Parts that do not agree are tried
again with finer or longer runs.
"""


def pages(effort: Effort) -> tuple[StudyPage, ...]:
    """Pages of the nine-bar study at an effort."""
    claims = claims_page("The paper's claims, judged", INTRODUCTION, CLAIMS, plan(effort), attacks(effort))
    return (claims, convergence(effort), threshold(effort), exponents(effort), damping(effort), sensitivity(effort))


STUDY = Study(
    "Chen, Jiang, Deng and Wang, Nonlinear Dynamics (2018): the nine-bar mechanism",
    figures,
    pages,
    (case("rigid", 2.0), case("flexible", 2.0)),
)
