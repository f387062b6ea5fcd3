"""What is found about a claim."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from flexmb.paper.statistics import UNTOLD, Comparison

AGREES, DISAGREES, UNDECIDED = "agrees", "disagrees", "cannot be decided"
ASIDE = "not counted"
"""Of a part that is shown beside those that decide."""

NOT_JUDGED = "not judged"
"""Of a claim for which there are no runs."""

NAMED = 2
"""Parts that a reason names."""


@dataclass(frozen=True)
class Part:
    """One case or quantity of a claim.

    Parameters
    ----------
    what : which.
    verdict : AGREES, DISAGREES, UNDECIDED or ASIDE.
    numbers : what it rests on, in words, with units.
    values : the same as numbers [SI].
    """

    what: str
    verdict: str
    numbers: str
    values: Mapping[str, float] = field(default_factory=dict)


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
        """One line: how many parts say so, and the first of them."""
        if self.verdict == NOT_JUDGED:
            return "There are no runs to judge by."
        telling = [part for part in self.counted if part.verdict == self.verdict]
        named = "; ".join(f"{part.what}: {part.numbers}" for part in telling[:NAMED])
        more = "; and more" if len(telling) > NAMED else ""
        return f"{len(telling)} of {len(self.counted)} parts. {named}{more}."


def tally(finding: Finding) -> str:
    """How many parts agree, disagree and are open: "7 / 1 / 0"."""
    verdicts = [part.verdict for part in finding.counted]
    return " / ".join(str(verdicts.count(verdict)) for verdict in (AGREES, DISAGREES, UNDECIDED))


def expect(found: Comparison, wanted: str) -> str:
    """The verdict on a claim that one mean is HIGHER or LOWER than another.

    Equal means contradict it, too; a difference within the spread decides nothing.

    Parameters
    ----------
    found : the comparison.
    wanted : HIGHER or LOWER, what the claim says of the first.
    """
    if found.verdict == UNTOLD:
        return UNDECIDED
    return AGREES if found.verdict == wanted else DISAGREES


def by_rule(*, agrees: bool, disagrees: bool) -> str:
    """The verdict of two conditions that exclude one another."""
    if agrees:
        return AGREES
    return DISAGREES if disagrees else UNDECIDED


def finding(parts: Iterable[Part]) -> Finding:
    """The finding of such parts."""
    return Finding(tuple(parts))
