"""The page "convergence": flexible against rigid links, with what elements and steps change."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, NamedTuple

from flexmb.paper.claims.evidence import QUANTITIES, Key, shown, si_unit
from flexmb.paper.claims.plan import FINER, case_of
from flexmb.paper.claims.response import CASES
from flexmb.paper.doubles import named, noted
from flexmb.paper.effort import Effort
from flexmb.paper.markdown import paragraph, table
from flexmb.paper.motion import Motion
from flexmb.paper.plate import Page, Results, Run
from flexmb.paper.statistics import EQUAL, HIGHER, LOWER, Mean, compare, plain

if TYPE_CHECKING:
    import xarray as xr

INTRODUCTION = """
Settled turns {first} to {last} of each run; peaks are the largest absolute values of a turn, from all steps. Each
entry is the mean and, after ±, the standard deviation of the turns; in brackets the standard error of the mean,
corrected for the correlation of neighbouring turns. Single peaks of a chaotic run prove nothing, so all verdicts are
on means: higher or lower if the interval that holds the difference with 99.7 % probability lies beyond 1 % of the
larger mean, equal if it lies within 5 %, and no difference within the spread otherwise. "4 elements" and "rtol 1e-4"
are what the rest of the study uses.
"""

ELEMENTS = {"full": (2, 8), "quick": (2,)}
"""Beam elements of a link, beside the usual 4."""

USUAL_ELEMENTS, USUAL_RTOL = 4, 1e-4


class Level(NamedTuple):
    """A model with a mesh and an accuracy.

    Parameters
    ----------
    model : "rigid" or "flexible".
    elements : of each link; of no meaning for the rigid one.
    rtol : accepted error of a step, relative.
    """

    model: str
    elements: int
    rtol: float

    @property
    def text(self) -> str:
        """For tables."""
        mesh = f", {self.elements} elements" if self.model == "flexible" else ""
        return f"{self.model}{mesh}, rtol {self.rtol:.0e}".replace("e-0", "e-")


RIGID, FLEXIBLE = (Level(model, USUAL_ELEMENTS, USUAL_RTOL) for model in ("rigid", "flexible"))


def levels(effort: Effort) -> tuple[Level, ...]:
    """Meshes and accuracies, the usual ones first of each model.

    Parameters
    ----------
    effort : how many.
    """
    rigid = (RIGID, Level("rigid", USUAL_ELEMENTS, FINER))
    meshes = tuple(Level("flexible", n, USUAL_RTOL) for n in ELEMENTS[effort.name])
    finer = () if effort.name == "quick" else (Level("flexible", USUAL_ELEMENTS, FINER),)
    return (*rigid, FLEXIBLE, *meshes, *finer)


def run_of(level: Level, speed: float, clearance: float, effort: Effort) -> Motion:
    """The run of a case at a level.

    Parameters
    ----------
    level : mesh and accuracy.
    speed : over pi [rad/s].
    clearance : at P1 [m].
    effort : how many turns.
    """
    case = dataclasses.replace(case_of(Key(level.model, speed, clearance)), elements=level.elements)
    rtol = None if level.rtol == USUAL_RTOL else level.rtol
    return Motion(case, effort.skip, effort.keep, effort.shown, rtol)


def pages(effort: Effort) -> tuple[Page, ...]:
    """The page at an effort."""
    table_of = {(case, level): run_of(level, *case, effort) for case in CASES for level in levels(effort)}

    def write(results: Results) -> tuple[str, xr.Dataset]:
        return written({place: results[run] for place, run in table_of.items()})

    runs: dict[Run, None] = dict.fromkeys(table_of.values())
    return (Page("convergence", "Flexible against rigid, elements and steps", tuple(runs), write, slow=True),)


Place = tuple[tuple[float, float], Level]


def written(found: dict[Place, xr.Dataset]) -> tuple[str, xr.Dataset]:
    """The text and the numbers.

    Parameters
    ----------
    found : settled turns by ((speed over pi, clearance), level).
    """
    one = next(iter(found.values()))
    first, count = int(one.attrs["first_turn"]), one.sizes["turn"]
    text = [paragraph(INTRODUCTION.format(first=first, last=first + count - 1))]
    for case in dict.fromkeys(case for case, _ in found):
        at = {level: data for (other, level), data in found.items() if other == case}
        text.append(f"## {case[0]:g} pi rad/s, {1e3 * case[1]:g} mm")
        text.append(_means(at))
        if RIGID in at and FLEXIBLE in at:
            text += [_flexible_against_rigid(at), _refinement(at)]
    return "\n\n".join(text) + "\n", _dataset(found)


def _mean(data: xr.Dataset, quantity: str) -> Mean:
    return Mean.of(data[quantity].values)


def _means(at: dict[Level, xr.Dataset]) -> str:
    rows = []
    for level, data in at.items():
        cells = []
        for quantity, (_, _, factor) in QUANTITIES.items():
            mean = _mean(data, quantity)
            error = "" if mean.error <= 1e-4 * abs(mean.value) else f" ({plain(factor * mean.error, 2)})"
            unit = QUANTITIES[quantity][1]
            cells.append(shown(mean, quantity).removesuffix(f" {unit}") + error)
        rows.append([level.text, *cells, plain(1e6 * float(data["step"].mean()), 3)])
    head = ["model", *(f"{name} [{unit}]" if unit else name for name, unit, _ in QUANTITIES.values()), "step [us]"]
    return table(head, rows)


def _flexible_against_rigid(at: dict[Level, xr.Dataset]) -> str:
    """Ratios with their intervals, of every flexible level to the rigid one of the same accuracy."""
    rows, columns = [], [level for level in at if level.model == "flexible"]
    for quantity, (name, _, _) in QUANTITIES.items():
        cells = []
        for level in columns:
            rigid = at.get(Level("rigid", USUAL_ELEMENTS, level.rtol), at[RIGID])
            found = compare(_mean(at[level], quantity), _mean(rigid, quantity))
            cells.append(f"{found.shown}: {found.verdict}")
        rows.append([name, *cells])
    head = ["flexible over rigid", *(level.text.removeprefix("flexible, ") for level in columns)]
    return table(head, rows, left=len(head))


def _refinement(at: dict[Level, xr.Dataset]) -> str:
    """Whether other elements or steps change a mean by more than its error."""
    pairs = [(level, RIGID if level.model == "rigid" else FLEXIBLE) for level in at if level not in (RIGID, FLEXIBLE)]
    rows = []
    for quantity, (name, _, _) in QUANTITIES.items():
        cells = []
        for level, usual in pairs:
            found = compare(_mean(at[level], quantity), _mean(at[usual], quantity))
            known = found.verdict in (HIGHER, LOWER, EQUAL)
            cells.append(f"{found.shown}: {found.verdict if known else 'within the error'}")
        rows.append([name, *cells])
    head = ["finer or coarser over usual", *(level.text for level, _ in pairs)]
    return table(head, rows, left=len(head))


def _dataset(found: dict[Place, xr.Dataset]) -> xr.Dataset:
    """Means, deviations and errors over case, level and quantity [SI]; NaN where there is no run."""
    import numpy as np
    import xarray

    cases, there = (list(dict.fromkeys(place[k] for place in found)) for k in (0, 1))
    values = np.full((len(cases), len(there), len(QUANTITIES), 3), np.nan)
    for (case, level), data in found.items():
        for k, quantity in enumerate(QUANTITIES):
            mean = _mean(data, quantity)
            values[cases.index(case), there.index(level), k] = mean.value, mean.deviation, mean.error
    axes = ("case", "level", "quantity")
    texts = {"mean": "mean", "deviation": "standard deviation of the turns", "error": "standard error of the mean"}
    speeds = [f"{speed:g} pi rad/s, {1e3 * clearance:g} mm" for speed, clearance in cases]
    return xarray.Dataset(
        {name: noted(values[..., k], axes, "that of `unit`", text) for k, (name, text) in enumerate(texts.items())},
        coords={
            "case": named(speeds, "case", "speed and clearance"),
            "level": named([level.text for level in there], "level", "elements and steps"),
            "quantity": named(list(QUANTITIES), "quantity", "measure of a turn"),
            "unit": named([si_unit(quantity) for quantity in QUANTITIES], "quantity", "unit of the quantity"),
        },
    )
