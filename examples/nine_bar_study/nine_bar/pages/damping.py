"""Page "damping": verdicts on the claims over the material damping of the links, which the paper does not print."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from nine_bar_study.claims.finding import AGREES, DISAGREES, NOT_JUDGED, UNDECIDED
from nine_bar_study.effort import Effort
from nine_bar_study.item import StudyPage, once
from nine_bar_study.markdown import paragraph, table
from nine_bar_study.nine_bar.claims import CLAIMS
from nine_bar_study.nine_bar.measures import FAST, MIDDLE, NEAREST, SMALL, SMALLEST, key
from nine_bar_study.nine_bar.pages.sensitivity import Row, row_of, written
from nine_bar_study.nine_bar.variations import DAMPED, ZETAS
from nine_bar_study.run import Results

if TYPE_CHECKING:
    import xarray as xr

MORE = (key("flexible", FAST),)
EXPONENTS = (
    *(key("flexible", MIDDLE, SMALLEST), key("rigid", MIDDLE), key("rigid", MIDDLE, SMALL)),
    *(key("flexible", speed) for speed in NEAREST),
)

INTRODUCTION = """
The paper prints no damping of its links: zeta1 and zeta2 of eq. (30) have no values. Here zeta2 runs over four decades,
and the claims are judged by the rules of the page "claims", from {keep} turns after {skip} and exponents over {points}
turns after {settle}, with 2 elements a link; in the last rows other numbers change as well. Claim 9 rests on 0.5, 1.6,
1.65, 2 and 2.5 pi rad/s, claim 10 on 0.01, 0.05 and 0.5 mm. Rows with a letter are those of the page "sensitivity".

A value at which most claims agree is inferred: it is fitted to what the paper says and proves nothing, neither that the
paper took it nor that such links have it. What damping steel and pins have stands in docs/nine_bar.md.
"""


def damping(effort: Effort) -> StudyPage:
    """Page "damping" at an effort."""
    rows = tuple(row_of(one, effort, MORE, EXPONENTS) for one in DAMPED)

    def write(results: Results) -> tuple[str, xr.Dataset]:
        text, data = written(results, rows, effort, INTRODUCTION)
        return f"{text}\n{standing(data['verdict'].values[: len(ZETAS)])}\n\n{exponents(rows, results)}\n", data

    runs = once([run for row in rows for run in (*row.plan.runs, row.reaction)])
    return StudyPage("damping", "Claims over the damping, which nobody printed", runs, write, slow=True)


def standing(verdicts: np.ndarray) -> str:
    """Passage that separates claims that disagree at any damping from claims that depend on the damping."""
    agreeing = (verdicts == AGREES).sum(axis=1)
    best = [f"{z:g}" for n, z in zip(agreeing, ZETAS, strict=True) if n == agreeing.max()]
    counts = ", ".join(f"{n} at {z:g} s" for n, z in zip(agreeing, ZETAS, strict=True))
    text = f"Most claims agree at zeta2 = {', '.join(best)} s. Agreeing claims, of {len(CLAIMS)}: {counts}."
    rows = [[str(claim.number), claim.text, _stands(verdicts[:, k])] for k, claim in enumerate(CLAIMS)]
    shown = table(["claim", "what the paper says", f"over zeta2 from {ZETAS[0]:g} to {ZETAS[-1]:g} s"], rows, left=3)
    return f"## What disagrees, and what depends on the damping\n\n{paragraph(text)}\n\n{shown}"


def exponents(rows: Sequence[Row], results: Results) -> str:
    """Table of the exponents of the flexible mechanism on which the claims rest: rows by variation, columns by case."""
    plans = [row.plan.growths for row in rows]
    found = {one for plan in plans for one in plan if one.model == "flexible"}
    keys = sorted(found, key=lambda one: (one.speed, one.clearance))
    head = [f"{one.speed:g} pi, {1e3 * one.clearance:g} mm" for one in keys]
    lines = [
        [row.variation.what, *(_growth(results[plan[one]]) if one in plan else "" for one in keys)]
        for row, plan in zip(rows, plans, strict=True)
    ]
    text = (
        "Largest exponent [1/s] of the flexible mechanism by speed [rad/s] and clearance, its error, and the verdict."
    )
    return f"## Exponents\n\n{paragraph(text)}\n\n{table(['variation', *head], lines, left=1)}"


def _growth(data: xr.Dataset) -> str:
    """Exponent and verdict of a run."""
    return f"{float(data['exponent']):.3g} ± {float(data['exponent_error']):.1g} {data.attrs['verdict']}"


def _stands(verdicts: np.ndarray) -> str:
    """Text of the verdicts on one claim over `ZETAS`."""
    found = {v: [f"{z:g}" for z, w in zip(ZETAS, verdicts, strict=True) if w == v] for v in sorted(set(verdicts))}
    if len(found) == 1:
        return f"{next(iter(found))}, whatever the damping"
    text = "; ".join(f"{name} at {', '.join(values)} s" for name, values in found.items())
    if {AGREES, DISAGREES} <= set(found):
        return f"depends on what was not published: {text}"
    known = set(found) - {UNDECIDED, NOT_JUDGED}
    return f"{next(iter(known))} where it can be decided: {text}" if known else text
