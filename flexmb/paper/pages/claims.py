"""The page "claims": what the paper says of its results, one by one, against ours."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING

from flexmb.paper.claims.catalogue import CLAIMS, Claim
from flexmb.paper.claims.evidence import Plan
from flexmb.paper.claims.finding import DISAGREES, UNDECIDED, Finding, Part, tally
from flexmb.paper.claims.plan import attacks, plan
from flexmb.paper.doubles import named, noted
from flexmb.paper.effort import Effort
from flexmb.paper.markdown import paragraph, table
from flexmb.paper.plate import Page, Results, Run

if TYPE_CHECKING:
    import xarray as xr

ATTACKED = (DISAGREES, UNDECIDED)
"""Verdicts that are not taken as they are."""

INTRODUCTION = """
Each claim is decided by the rule that stands above its parts. The rules were written down before the numbers were
looked at, with these exceptions. The two parts of claim 13, what the paper shows and what it says, were one before.
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


def pages(effort: Effort) -> tuple[Page, ...]:
    """The page at an effort."""
    deciding, others = plan(effort), attacks(effort)

    def write(results: Results) -> tuple[str, xr.Dataset]:
        return written(results, deciding, others)

    runs: dict[Run, None] = dict.fromkeys(deciding.runs)
    for other in others.values():
        runs.update(dict.fromkeys(other.runs))
    return (Page("claims", "The paper's claims, judged", tuple(runs), write),)


def written(results: Results, deciding: Plan, others: Mapping[str, Plan]) -> tuple[str, xr.Dataset]:
    """The text and the numbers.

    Parameters
    ----------
    results : by runs.
    deciding : the runs that decide.
    others : runs with which what does not agree is attacked, by what is finer in them.
    """
    seen = deciding.read(results)
    found = {claim.number: claim.judge(seen) for claim in CLAIMS}
    against = {name: other.read(results) for name, other in others.items()}
    attacked = {
        claim.number: {name: claim.judge(evidence) for name, evidence in against.items()}
        for claim in CLAIMS
        if found[claim.number].verdict in ATTACKED
    }
    found = {number: withstood(finding, attacked.get(number, {})) for number, finding in found.items()}
    rows = [
        [str(c.number), c.text, c.figures, found[c.number].verdict, tally(found[c.number]), found[c.number].reason]
        for c in CLAIMS
    ]
    head = ["claim", "what the paper says", "figures", "verdict", "agree / disagree / open", "reason"]
    passages = [*(paragraph(part) for part in INTRODUCTION.split("\n\n")), table(head, rows, left=6)]
    passages += [_passage(claim, found[claim.number], attacked.get(claim.number, {})) for claim in CLAIMS]
    return "\n\n".join(passages) + "\n", _dataset(found)


def _passage(claim: Claim, found: Finding, attacked: Mapping[str, Finding]) -> str:
    lines = [f"## Claim {claim.number}: {found.verdict}", paragraph(claim.text), paragraph(claim.rule)]
    if found.parts:
        rows = [[part.what, part.verdict, part.numbers] for part in found.parts]
        lines.append(table(["part", "verdict", "numbers"], rows, left=3))
    if found.verdict in ATTACKED:
        lines.append(attacked_with(found, attacked))
    return "\n\n".join(lines)


def withstood(found: Finding, attacked: Mapping[str, Finding]) -> Finding:
    """What is left of a finding: a part that disagrees, but not in all finer or longer runs, is not decided.

    Parameters
    ----------
    found : the finding of the runs that decide.
    attacked : findings by what is finer in their runs.
    """
    return Finding(tuple(_withstood(part, again(part, attacked)) for part in found.parts))


def _withstood(part: Part, others: list[tuple[str, Part]]) -> Part:
    lost = [name for name, other in others if other.verdict != DISAGREES]
    if part.verdict != DISAGREES or not lost:
        return part
    text = f"{part.numbers}; this disagrees, but not with {lost[0]}"
    return dataclasses.replace(part, verdict=UNDECIDED, numbers=text)


def again(part: Part, attacked: Mapping[str, Finding]) -> list[tuple[str, Part]]:
    """The same part from other runs, by what is finer in them.

    Parameters
    ----------
    part : one part of a finding.
    attacked : findings by what is finer in their runs; the same numbers come from the same run, and are left out.
    """
    return [
        (name, other)
        for name, finding in attacked.items()
        for other in finding.parts
        if other.what == part.what and not part.numbers.startswith(other.numbers)
    ]


def attacked_with(found: Finding, attacked: Mapping[str, Finding]) -> str:
    """What finer and longer runs say of the parts that do not agree.

    Parameters
    ----------
    found : the finding.
    attacked : findings by what is finer in their runs; parts that they lack are left out.
    """
    rows = []
    for part in found.counted:
        if part.verdict not in ATTACKED:
            continue
        others = again(part, attacked)
        rows += [[part.what, part.verdict, name, other.verdict, other.numbers] for name, other in others]
        if not others:
            rows.append([part.what, part.verdict, "no finer run", "-", "-"])
    head = ["part", "verdict", "attacked with", "verdict then", "numbers then"]
    return "Attacked with:\n\n" + table(head, rows, left=len(head))


def _dataset(found: Mapping[int, Finding]) -> xr.Dataset:
    """All numbers of all parts, over "number"; verdicts over "claim" and over "part"."""
    import xarray

    parts = [(number, part) for number, finding in found.items() for part in finding.parts]
    numbers = [(place, name, value) for place, (_, part) in enumerate(parts) for name, value in part.values.items()]
    return xarray.Dataset(
        {
            "verdict": named([finding.verdict for finding in found.values()], "claim", "verdict on the claim"),
            "part.claim": named([number for number, _ in parts], "part", "claim of the part"),
            "part.what": named([part.what for _, part in parts], "part", "case or quantity"),
            "part.verdict": named([part.verdict for _, part in parts], "part", "verdict on the part"),
            "number.part": named([place for place, _, _ in numbers], "number", "place of its part"),
            "number.name": named([name for _, name, _ in numbers], "number", "what the number is"),
            "number.value": noted([float(v) for _, _, v in numbers], "number", "SI", "number, in the unit of its name"),
        },
        coords={"claim": named(list(found), "claim", "number of the claim")},
    )
