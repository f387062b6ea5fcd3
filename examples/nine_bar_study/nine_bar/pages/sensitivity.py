"""Page "sensitivity": verdicts on the claims for variations of the unpublished parameters, one at a time."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

from nine_bar_study.claims.evidence import Evidence, Key, Measure, Plan, ideal
from nine_bar_study.claims.finding import AGREES, DISAGREES, NOT_JUDGED, UNDECIDED, Finding
from nine_bar_study.drawing import named, noted
from nine_bar_study.effort import Effort
from nine_bar_study.exponent import growth
from nine_bar_study.item import StudyPage, once
from nine_bar_study.markdown import paragraph, table
from nine_bar_study.motion import motion
from nine_bar_study.nine_bar.cases import case
from nine_bar_study.nine_bar.claims import CLAIMS
from nine_bar_study.nine_bar.measures import ACCELERATION, FAST, FLIGHT, FORCE, MIDDLE, SLOW, SMALL, case_of, key
from nine_bar_study.nine_bar.plan import LAWS, START_TURNS, changed
from nine_bar_study.nine_bar.reaction import reaction, reversal
from nine_bar_study.nine_bar.variations import USUAL, VARIATIONS, Variation
from nine_bar_study.run import Results, StudyRun
from nine_bar_study.statistics import compare

if TYPE_CHECKING:
    import xarray as xr

TURNS = {"full": (4, 10), "quick": (3, 3)}
"""Turns before the first settled turn, and number of settled turns, by effort."""

PERIODS = {"full": (10, 50), "quick": (5, 50)}
"""Periods before the first section point, and number of section points, by effort."""

FEW = 2
"""Beam elements per link of exponents; a third of the time of 4."""

ANGLES = 120
"""Number of crank angles of the reaction of the ideal joint."""

STIFF = (key("rigid", SLOW), key("rigid", MIDDLE), key("rigid", MIDDLE, SMALL))
RIGID = (*STIFF, *LAWS)
FLEXIBLE = (key("flexible", SLOW), key("flexible", MIDDLE), key("flexible", MIDDLE, SMALL))
PURE = (ideal(SLOW), ideal(MIDDLE), ideal(FAST))

LETTERS = {AGREES: "a", DISAGREES: "D", UNDECIDED: "?", NOT_JUDGED: "-"}

INTRODUCTION = """
Each row changes one of the numbers that the paper leaves open, and all claims for which there are runs are judged
again, by the same rules: a agrees, D disagrees, ? cannot be decided, - not judged. A letter in bold differs from the
first row. All rows, the first included, rest on {keep} turns after {skip}, fewer than the page "claims" has, so that
more cannot be decided here; cases are 0.5 pi and 2 pi rad/s with 0.5 mm and 2 pi with 0.05 mm of play, rigid and
flexible, and rigid at 2.5 pi with both friction laws. Exponents, on which claims 7, 8, 11 and 15 rest, are those of
the flexible mechanism over {points} turns after {settle} with 2 elements a link, unless the row says otherwise, and of
the rigid one where no flexible one can be built.
Claims 9 and 10 need more speeds and clearances and are not judged (see "damping"); for claim 9 the speed at which the
reaction of the ideal joint turns round is given instead. Most claims have many parts,
and one that disagrees is enough for a D: the second table gives what they mainly rest on.
"""


class Row(NamedTuple):
    """Variation with its runs.

    Parameters
    ----------
    variation : change of the mechanism or of the steps.
    plan : runs of the claims.
    reaction : run of the reaction of the ideal joint.
    lacking : reason of a missing flexible mechanism; "" with a flexible mechanism.
    """

    variation: Variation
    plan: Plan
    reaction: StudyRun
    lacking: str


def sensitivity(effort: Effort) -> StudyPage:
    """Page "sensitivity" at an effort."""
    rows = rows_of(effort)

    def write(results: Results) -> tuple[str, xr.Dataset]:
        return written(results, rows, effort, INTRODUCTION)

    runs = once([run for row in rows for run in (*row.plan.runs, row.reaction)])
    return StudyPage("sensitivity", "Claims while what is not known varies", runs, write, slow=True)


@cache
def rows_of(effort: Effort) -> tuple[Row, ...]:
    """Rows of the reconstructed mechanism and of its variations at an effort."""
    return tuple(row_of(variation, effort) for variation in (USUAL, *VARIATIONS))


def row_of(variation: Variation, effort: Effort, more: tuple[Key, ...] = (), also: tuple[Key, ...] = ()) -> Row:
    """Variation with its runs at an effort."""
    lacking = variation.why_not(case_of(FLEXIBLE[0]))
    bent: tuple[Key, ...] = () if lacking or not effort.full else (*FLEXIBLE, *more)
    if variation.staggered:
        bent = tuple(one for one in bent if one.speed != SLOW)  # the energy residual of the slow start is too large
    settle, points = PERIODS[effort.name]
    # exponents with other steps are on the page "claims"; the staggered scheme has no tangents
    growing = () if not effort.full else STIFF if lacking or variation.staggered else (*FLEXIBLE, *more, *also)
    skip, keep = TURNS[effort.name]
    plan = Plan(
        {
            one: motion(variation.of(case_of(one)), skip, keep, min(effort.shown, keep))
            for one in (*PURE, *RIGID, *bent)
        },
        {one: _start(variation, one) for one in LAWS},
        {one: growth(variation.of(changed(one, elements=FEW)), settle, points) for one in growing},
    )
    return Row(variation, plan, reaction(variation.of(case("ideal", SLOW)), ANGLES), lacking)


def _start(variation: Variation, one: Key) -> StudyRun:
    return motion(variation.of(changed(one, label="start", ramp=0.0)), 0, START_TURNS, START_TURNS)


def written(results: Results, rows: tuple[Row, ...], effort: Effort, introduction: str) -> tuple[str, xr.Dataset]:
    """Text and numbers of the page.

    Parameters
    ----------
    results : results by run.
    rows : variations with their runs; the first row is the reconstructed mechanism.
    effort : lengths of the runs.
    introduction : paragraphs above the tables.
    """
    seen = [row.plan.read(results) for row in rows]
    found = [{claim.number: claim.judge(evidence) for claim in CLAIMS} for evidence in seen]
    (skip, keep), (settle, points) = TURNS[effort.name], PERIODS[effort.name]
    text = [
        *map(paragraph, introduction.format(skip=skip, keep=keep, settle=settle, points=points).split("\n\n")),
        _verdicts(rows, found),
        "## Main numbers",
        paragraph(
            "Ratios are flexible over rigid, of means over the turns; in brackets the interval that holds the ratio "
            "with 99.7 % probability."
        ),
    ]
    numbers = [_numbers(evidence, results[row.reaction]) for row, evidence in zip(rows, seen, strict=True)]
    text.append(
        table(
            ["", "variation", *(head for _, head, _, _ in NUMBERS)],
            [
                [row.variation.letter, row.variation.what, *(shown for shown, _ in line)]
                for row, line in zip(rows, numbers, strict=True)
            ],
            left=2,
        )
    )
    text += _changes(rows, found)
    return "\n\n".join(text) + "\n", _dataset(rows, found, numbers)


def _verdicts(rows: tuple[Row, ...], found: list[dict[int, Finding]]) -> str:
    """Table of verdicts: one column per claim, one row per variation."""
    usual = found[0]
    lines = []
    for row, findings in zip(rows, found, strict=True):
        letters = [LETTERS[findings[claim.number].verdict] for claim in CLAIMS]
        changed = [findings[c.number].verdict not in (usual[c.number].verdict, NOT_JUDGED) for c in CLAIMS]
        cells = [f"**{letter}**" if new else letter for letter, new in zip(letters, changed, strict=True)]
        lines.append([row.variation.letter, row.variation.what, *cells])
    return table(["", "variation", *(str(claim.number) for claim in CLAIMS)], lines, left=2)


def _changes(rows: tuple[Row, ...], found: list[dict[int, Finding]]) -> list[str]:
    """Passages on changed verdicts and on missing flexible mechanisms."""
    lines = []
    for row, findings in zip(rows[1:], found[1:], strict=True):
        for claim in CLAIMS:
            new, old = findings[claim.number], found[0][claim.number]
            if new.verdict not in (old.verdict, NOT_JUDGED):
                what = f"({row.variation.letter}) {row.variation.what}: claim {claim.number} {new.verdict}"
                lines.append(f"- {what} ({old.verdict} in the first row). {new.reason}")
    lacking = [f"- ({row.variation.letter}) {row.variation.what}: {row.lacking}" for row in rows if row.lacking]
    text = ["## What changed", "\n".join(lines) if lines else "No verdict changed."]
    if lacking:
        text += ["## What cannot be built from beams", "\n".join(lacking)]
    return text


NUMBERS = (
    ("force_ratio.large", "force ratio, 0.5 mm", "1", "peak force, flexible over rigid, 0.5 mm"),
    ("acceleration_ratio.large", "acceleration ratio, 0.5 mm", "1", "peak acceleration, flexible over rigid, 0.5 mm"),
    ("acceleration_ratio.small", "acceleration ratio, 0.05 mm", "1", "peak acceleration, flexible over rigid, 0.05 mm"),
    ("flight.large", "free flight rigid / flexible, 0.5 mm [%]", "%", "free flight, flexible, 0.5 mm"),
    ("flight.small", "free flight rigid / flexible, 0.05 mm [%]", "%", "free flight, flexible, 0.05 mm"),
    ("reversal", "reaction turns round at [pi rad/s]", "pi rad/s", "speed at which the reaction turns round"),
    ("exponent.large", "exponent, flexible, 2 pi, 0.5 mm [1/s]", "1/s", "exponent, flexible, 0.5 mm"),
    ("exponent.small", "exponent, flexible, 2 pi, 0.05 mm [1/s]", "1/s", "exponent, flexible, 0.05 mm"),
)
"""Main numbers: name in the dataset, head in the table, unit and text in the dataset."""


def _numbers(seen: Evidence, reaction: xr.Dataset) -> list[tuple[str, float]]:
    """Main numbers of a variation, each as text and as a number."""
    large = key("rigid", MIDDLE), key("flexible", MIDDLE)
    small = key("rigid", MIDDLE, SMALL), key("flexible", MIDDLE, SMALL)
    speed = reversal(reaction["static"].values, reaction["dynamic"].values)
    return [
        _ratio(seen, *large, FORCE),
        _ratio(seen, *large, ACCELERATION),
        _ratio(seen, *small, ACCELERATION),
        _flights(seen, *large),
        _flights(seen, *small),
        (f"{speed:.3f}", speed),
        _exponent(seen, large[1]),
        _exponent(seen, small[1]),
    ]


def _ratio(seen: Evidence, rigid: Key, flexible: Key, measure: Measure) -> tuple[str, float]:
    if not seen.has(rigid, flexible):
        return "-", math.nan
    found = compare(seen.mean(flexible, measure), seen.mean(rigid, measure))
    return found.shown, found.ratio


def _flights(seen: Evidence, *keys: Key) -> tuple[str, float]:
    """Mean free flight [%] of several keys: text of all, and the number of the last key."""
    shares = [100.0 * seen.mean(one, FLIGHT).value if seen.has(one) else math.nan for one in keys]
    return " / ".join("-" if math.isnan(share) else f"{share:.1f}" for share in shares), shares[-1]


def _exponent(seen: Evidence, one: Key) -> tuple[str, float]:
    if one not in seen.growths:
        return "-", math.nan
    data = seen.growths[one]
    return f"{float(data['exponent']):.3g} ± {float(data['exponent_error']):.1g}", float(data["exponent"])


def _dataset(
    rows: tuple[Row, ...], found: list[dict[int, Finding]], numbers: list[list[tuple[str, float]]]
) -> xr.Dataset:
    """Dataset of the verdicts over variation and claim, and of the main numbers over variation."""
    import xarray

    verdicts = [[findings[claim.number].verdict for claim in CLAIMS] for findings in found]
    columns = {
        name: noted([line[k][1] for line in numbers], "variation", unit, text)
        for k, (name, _, unit, text) in enumerate(NUMBERS)
    }
    return xarray.Dataset(
        {"verdict": named(verdicts, ("variation", "claim"), "verdict on the claim"), **columns},
        coords={
            "variation": named([row.variation.what for row in rows], "variation", "what is varied"),
            "claim": named([claim.number for claim in CLAIMS], "claim", "number of the claim"),
        },
    )
