"""Claim, parts of a claim, and the verdict of the parts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from nine_bar_study.claims.evidence import Evidence
from nine_bar_study.statistics import UNTOLD, Comparison

AGREES, DISAGREES, UNDECIDED = "agrees", "disagrees", "cannot be decided"
ASIDE = "not counted"
"""Verdict on a part that is shown and not counted."""

NOT_JUDGED = "not judged"
"""Verdict on a claim without runs."""

NAMED = 2
"""Largest number of parts in a reason."""


@dataclass(frozen=True)
class Part:
    """Part of a claim: the verdict on one case or quantity.

    Parameters
    ----------
    what : name of the case or quantity.
    verdict : AGREES, DISAGREES, UNDECIDED or ASIDE.
    numbers : text of the measured numbers, with units.
    values : measured numbers by name [SI].
    """

    what: str
    verdict: str
    numbers: str
    values: Mapping[str, float] = field(default_factory=dict)

    @property
    def aside(self) -> Part:
        """Copy of the part with the verdict ASIDE."""
        return replace(self, verdict=ASIDE)

    @property
    def beside(self) -> Part:
        """Copy of the part with the verdict ASIDE; the original verdict is appended to `numbers`."""
        return replace(self, verdict=ASIDE, numbers=f"{self.numbers}: {self.verdict}")


@dataclass(frozen=True)
class Finding:
    """Parts and verdict of a claim.

    A claim agrees if all counted parts agree.  The claim disagrees if one counted part disagrees.  All other claims are
    undecided.

    Parameters
    ----------
    parts : parts of the claim.
    """

    parts: tuple[Part, ...]

    @property
    def counted(self) -> tuple[Part, ...]:
        """Parts with a verdict other than ASIDE."""
        return tuple(part for part in self.parts if part.verdict != ASIDE)

    @property
    def verdict(self) -> str:
        """AGREES, DISAGREES or UNDECIDED; NOT_JUDGED without counted parts."""
        verdicts = {part.verdict for part in self.counted}
        if not verdicts:
            return NOT_JUDGED
        if DISAGREES in verdicts:
            return DISAGREES
        return UNDECIDED if UNDECIDED in verdicts else AGREES

    @property
    def reason(self) -> str:
        """Number of parts with the verdict of the claim, and the texts of the first two."""
        if self.verdict == NOT_JUDGED:
            return "There are no runs to judge by."
        telling = [part for part in self.counted if part.verdict == self.verdict]
        named = "; ".join(f"{part.what}: {part.numbers}" for part in telling[:NAMED])
        more = "; and more" if len(telling) > NAMED else ""
        return f"{len(telling)} of {len(self.counted)} parts. {named}{more}."

    @property
    def tally(self) -> str:
        """Numbers of parts with the verdicts AGREES, DISAGREES and UNDECIDED: "7 / 1 / 0"."""
        verdicts = [part.verdict for part in self.counted]
        return " / ".join(str(verdicts.count(verdict)) for verdict in (AGREES, DISAGREES, UNDECIDED))


class Claim(NamedTuple):
    """Claim of a published study with the rule of its verdict.

    Parameters
    ----------
    number : number in the table of claims.
    text : text of the claim.
    figures : numbers of the published figures.
    parts : function of the evidence that returns the parts; no parts without runs.
    rule : text of the rule of the verdicts.
    """

    number: int
    text: str
    figures: str
    parts: Callable[[Evidence], Iterable[Part]]
    rule: str

    def judge(self, seen: Evidence) -> Finding:
        """Finding of the claim by some evidence."""
        return Finding(tuple(self.parts(seen)))


def expect(found: Comparison, wanted: str) -> str:
    """Verdict on the claim that one mean is HIGHER or LOWER than another mean.

    Equal means disagree with the claim.  A difference within the spread is UNDECIDED.
    """
    if found.verdict == UNTOLD:
        return UNDECIDED
    return AGREES if found.verdict == wanted else DISAGREES


def by_rule(*, agrees: bool, disagrees: bool) -> str:
    """Verdict of two mutually exclusive conditions."""
    if agrees:
        return AGREES
    return DISAGREES if disagrees else UNDECIDED
