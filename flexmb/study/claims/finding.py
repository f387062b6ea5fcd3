"""A claim, the parts by which it is judged, and the verdict that they give."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from flexmb.study.claims.evidence import Evidence
from flexmb.study.statistics import UNTOLD, Comparison

AGREES, DISAGREES, UNDECIDED = "agrees", "disagrees", "cannot be decided"
ASIDE = "not counted"
"""Verdict on a part that is shown beside the parts that decide."""

NOT_JUDGED = "not judged"
"""Verdict on a claim for which there are no runs."""

NAMED = 2
"""Parts that a reason names."""


@dataclass(frozen=True)
class Part:
    """One case or quantity of a claim.

    Parameters
    ----------
    what : name of the case or quantity.
    verdict : AGREES, DISAGREES, UNDECIDED or ASIDE.
    numbers : the measured numbers in words, with units.
    values : the same numbers by name [SI].
    """

    what: str
    verdict: str
    numbers: str
    values: Mapping[str, float] = field(default_factory=dict)

    @property
    def aside(self) -> Part:
        """The same part, not counted."""
        return replace(self, verdict=ASIDE)

    @property
    def beside(self) -> Part:
        """The same part, not counted, with its verdict among the numbers."""
        return replace(self, verdict=ASIDE, numbers=f"{self.numbers}: {self.verdict}")


@dataclass(frozen=True)
class Finding:
    """All parts of a claim, and the verdict they give.

    A claim agrees when all its parts do, disagrees when one does, and cannot be decided otherwise.

    Parameters
    ----------
    parts : the parts.
    """

    parts: tuple[Part, ...]

    @property
    def counted(self) -> tuple[Part, ...]:
        """The parts that decide."""
        return tuple(part for part in self.parts if part.verdict != ASIDE)

    @property
    def verdict(self) -> str:
        """AGREES, DISAGREES, UNDECIDED; NOT_JUDGED without parts."""
        verdicts = {part.verdict for part in self.counted}
        if not verdicts:
            return NOT_JUDGED
        if DISAGREES in verdicts:
            return DISAGREES
        return UNDECIDED if UNDECIDED in verdicts else AGREES

    @property
    def reason(self) -> str:
        """One line: the number of parts with the verdict of the claim, and the first of them."""
        if self.verdict == NOT_JUDGED:
            return "There are no runs to judge by."
        telling = [part for part in self.counted if part.verdict == self.verdict]
        named = "; ".join(f"{part.what}: {part.numbers}" for part in telling[:NAMED])
        more = "; and more" if len(telling) > NAMED else ""
        return f"{len(telling)} of {len(self.counted)} parts. {named}{more}."

    @property
    def tally(self) -> str:
        """Numbers of parts that agree, disagree and are open: "7 / 1 / 0"."""
        verdicts = [part.verdict for part in self.counted]
        return " / ".join(str(verdicts.count(verdict)) for verdict in (AGREES, DISAGREES, UNDECIDED))


class Claim(NamedTuple):
    """A claim of a published study.

    Parameters
    ----------
    number : its number in our list.
    text : the claim.
    figures : figures that show it.
    parts : from the evidence to the parts, none of them where there are no runs.
    rule : the rule by which the parts are judged, in words.
    """

    number: int
    text: str
    figures: str
    parts: Callable[[Evidence], Iterable[Part]]
    rule: str

    def judge(self, seen: Evidence) -> Finding:
        """The finding of some evidence."""
        return Finding(tuple(self.parts(seen)))


def expect(found: Comparison, wanted: str) -> str:
    """The verdict on a claim that one mean is HIGHER or LOWER than another.

    Equal means contradict it, too; a difference within the spread decides nothing.

    Parameters
    ----------
    found : the comparison.
    wanted : HIGHER or LOWER, the claimed relation of the first to the second.
    """
    if found.verdict == UNTOLD:
        return UNDECIDED
    return AGREES if found.verdict == wanted else DISAGREES


def by_rule(*, agrees: bool, disagrees: bool) -> str:
    """The verdict of two conditions that exclude one another."""
    if agrees:
        return AGREES
    return DISAGREES if disagrees else UNDECIDED
