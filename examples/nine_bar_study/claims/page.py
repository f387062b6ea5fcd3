"""Page "claims": each claim of a published study with its verdict and parts."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

from nine_bar_study.claims.evidence import Plan
from nine_bar_study.claims.finding import DISAGREES, UNDECIDED, Claim, Finding, Part
from nine_bar_study.drawing import named, noted
from nine_bar_study.item import StudyPage, once
from nine_bar_study.markdown import paragraph, table
from nine_bar_study.run import Results

if TYPE_CHECKING:
    import xarray as xr

ATTACKED = (DISAGREES, UNDECIDED)
"""Verdicts of parts that are tried again with finer or longer runs."""

HEAD = ("claim", "what the paper says", "figures", "verdict", "agree / disagree / open", "reason")


def claims_page(
    title: str, introduction: str, claims: Sequence[Claim], deciding: Plan, attacks: Mapping[str, Plan]
) -> StudyPage:
    """Page "claims" of a study.

    Parameters
    ----------
    title : heading of the page.
    introduction : paragraphs above the table.
    claims : claims of the study.
    deciding : runs whose results are judged.
    attacks : finer or longer runs that try again the parts that do not agree, by the text of the change.
    """
    runs = once([run for plan in (deciding, *attacks.values()) for run in plan.runs])
    write = partial(written, introduction=introduction, claims=claims, deciding=deciding, attacks=attacks)
    return StudyPage("claims", title, runs, write)


def written(
    results: Results, *, introduction: str, claims: Sequence[Claim], deciding: Plan, attacks: Mapping[str, Plan]
) -> tuple[str, xr.Dataset]:
    """Text and numbers of the page "claims"."""
    seen = deciding.read(results)
    found = {claim.number: claim.judge(seen) for claim in claims}
    against = {name: other.read(results) for name, other in attacks.items()}
    attacked = {
        claim.number: {name: claim.judge(evidence) for name, evidence in against.items()}
        for claim in claims
        if found[claim.number].verdict in ATTACKED
    }
    found = {number: withstood(finding, attacked.get(number, {})) for number, finding in found.items()}
    rows = [
        [str(c.number), c.text, c.figures, found[c.number].verdict, found[c.number].tally, found[c.number].reason]
        for c in claims
    ]
    passages = [*(paragraph(part) for part in introduction.split("\n\n")), table(HEAD, rows, left=len(HEAD))]
    passages += [_passage(claim, found[claim.number], attacked.get(claim.number, {})) for claim in claims]
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
    """Finding after the attacks: a part that disagrees, but not in all finer or longer runs, becomes UNDECIDED."""
    return Finding(tuple(_withstood(part, again(part, attacked)) for part in found.parts))


def _withstood(part: Part, others: list[tuple[str, Part]]) -> Part:
    lost = [name for name, other in others if other.verdict != DISAGREES]
    if part.verdict != DISAGREES or not lost:
        return part
    text = f"{part.numbers}; this disagrees, but not with {lost[0]}"
    return dataclasses.replace(part, verdict=UNDECIDED, numbers=text)


def again(part: Part, attacked: Mapping[str, Finding]) -> list[tuple[str, Part]]:
    """Parts of the same name in the finer or longer runs, with the text of the change."""
    return [
        (name, other)
        for name, finding in attacked.items()
        for other in finding.parts
        if other.what == part.what and not part.numbers.startswith(other.numbers)
    ]


def attacked_with(found: Finding, attacked: Mapping[str, Finding]) -> str:
    """Table of the parts that do not agree, with their verdicts in finer and longer runs."""
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
    """Dataset of the numbers of all parts over "number", and of the verdicts over "claim" and over "part"."""
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
