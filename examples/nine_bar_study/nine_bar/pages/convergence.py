"""Page "convergence": flexible against rigid links, and influence of elements and steps on the means."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from nine_bar_study.drawing import named, noted
from nine_bar_study.effort import Effort
from nine_bar_study.item import StudyPage, once
from nine_bar_study.markdown import paragraph, table
from nine_bar_study.nine_bar.measures import CASES, MEASURES, key
from nine_bar_study.nine_bar.plan import FINER, changed
from nine_bar_study.run import Results, StudyRun
from nine_bar_study.statistics import UNTOLD, Mean, compare, plain

from flexmb.engine.step.step_size import RTOL

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
"""Numbers of beam elements per link by effort, beside the default of 4."""

USUAL_ELEMENTS = 4


class Level(NamedTuple):
    """Model with a number of elements and a tolerance.

    Parameters
    ----------
    model : "rigid" or "flexible".
    elements : beam elements per link, unused by the model "rigid".
    rtol : accepted relative error of a step.
    """

    model: str
    elements: int = USUAL_ELEMENTS
    rtol: float = RTOL

    @property
    def text(self) -> str:
        """Text of model, elements and tolerance for tables."""
        mesh = f", {self.elements} elements" if self.model == "flexible" else ""
        return f"{self.model}{mesh}, rtol {self.rtol:.0e}".replace("e-0", "e-")

    def run(self, speed: float, clearance: float, effort: Effort) -> StudyRun:
        """Run of settled turns at a speed over pi [rad/s] and a clearance [m]."""
        rtol = None if self.rtol == RTOL else self.rtol
        return effort.settled(changed(key(self.model, speed, clearance), elements=self.elements, rtol=rtol))


RIGID, FLEXIBLE = Level("rigid"), Level("flexible")

Found = dict[tuple[tuple[float, float], Level], "xr.Dataset"]
"""Settled turns by (speed over pi [rad/s], clearance [m]) and level."""


def levels(effort: Effort) -> tuple[Level, ...]:
    """Levels of an effort, the default level of each model first."""
    meshes = (Level("flexible", n) for n in ELEMENTS[effort.name])
    finer = [Level("flexible", rtol=FINER)] if effort.full else []
    return (RIGID, Level("rigid", rtol=FINER), FLEXIBLE, *meshes, *finer)


def convergence(effort: Effort) -> StudyPage:
    """Page "convergence" at an effort."""
    runs = {(case, level): level.run(*case, effort) for case in CASES for level in levels(effort)}

    def write(results: Results) -> tuple[str, xr.Dataset]:
        return written({place: results[run] for place, run in runs.items()})

    title = "Flexible against rigid, elements and steps"
    return StudyPage("convergence", title, once(list(runs.values())), write, slow=True)


def written(found: Found) -> tuple[str, xr.Dataset]:
    """Text and numbers of the page."""
    one = next(iter(found.values()))
    first, count = int(one.attrs["first_turn"]), one.sizes["turn"]
    text = [paragraph(INTRODUCTION.format(first=first, last=first + count - 1))]
    for case in dict.fromkeys(case for case, _ in found):
        at = {level: data for (other, level), data in found.items() if other == case}
        text += [f"## {case[0]:g} pi rad/s, {1e3 * case[1]:g} mm", _means(at)]
        if RIGID in at and FLEXIBLE in at:
            text += [_flexible_against_rigid(at), _refinement(at)]
    return "\n\n".join(text) + "\n", _dataset(found)


def _means(at: dict[Level, xr.Dataset]) -> str:
    rows = []
    for level, data in at.items():
        cells = []
        for measure in MEASURES:
            mean = Mean.of(data[measure.name].values)
            error = "" if mean.error <= 1e-4 * abs(mean.value) else f" ({plain(measure.factor * mean.error, 2)})"
            cells.append(measure.shown(mean).removesuffix(f" {measure.unit}") + error)
        rows.append([level.text, *cells, plain(1e6 * float(data["step"].mean()), 3)])
    head = ["model", *(f"{one.text} [{one.unit}]" if one.unit else one.text for one in MEASURES), "step [us]"]
    return table(head, rows)


def _compared(head: list[str], pairs: list[tuple[xr.Dataset, xr.Dataset]], untold: str) -> str:
    """Table of the ratios of all measures, first over second of each pair, with intervals and verdicts."""
    rows = []
    for measure in MEASURES:
        found = [compare(*(Mean.of(data[measure.name].values) for data in pair)) for pair in pairs]
        verdicts = (untold if one.verdict == UNTOLD else one.verdict for one in found)
        rows.append([measure.text, *(f"{one.shown}: {said}" for one, said in zip(found, verdicts, strict=True))])
    return table(head, rows, left=len(head))


def _flexible_against_rigid(at: dict[Level, xr.Dataset]) -> str:
    """Table of each flexible level against the rigid level of equal tolerance."""
    columns = [level for level in at if level.model == "flexible"]
    pairs = [(at[level], at.get(Level("rigid", rtol=level.rtol), at[RIGID])) for level in columns]
    head = ["flexible over rigid", *(level.text.removeprefix("flexible, ") for level in columns)]
    return _compared(head, pairs, UNTOLD)


def _refinement(at: dict[Level, xr.Dataset]) -> str:
    """Table of each level against the default level of its model."""
    others = [level for level in at if level not in (RIGID, FLEXIBLE)]
    pairs = [(at[level], at[RIGID if level.model == "rigid" else FLEXIBLE]) for level in others]
    return _compared(["finer or coarser over usual", *(level.text for level in others)], pairs, "within the error")


def _dataset(found: Found) -> xr.Dataset:
    """Dataset of means, deviations and errors over case, level and quantity [SI]; NaN without a run."""
    import xarray

    cases, there = list(dict.fromkeys(case for case, _ in found)), list(dict.fromkeys(level for _, level in found))
    values = np.full((len(cases), len(there), len(MEASURES), 3), np.nan)
    for (case, level), data in found.items():
        for k, measure in enumerate(MEASURES):
            mean = Mean.of(data[measure.name].values)
            values[cases.index(case), there.index(level), k] = mean.value, mean.deviation, mean.error
    axes = ("case", "level", "quantity")
    texts = {"mean": "mean", "deviation": "standard deviation of the turns", "error": "standard error of the mean"}
    speeds = [f"{speed:g} pi rad/s, {1e3 * clearance:g} mm" for speed, clearance in cases]
    return xarray.Dataset(
        {name: noted(values[..., k], axes, "that of `unit`", text) for k, (name, text) in enumerate(texts.items())},
        coords={
            "case": named(speeds, "case", "speed and clearance"),
            "level": named([level.text for level in there], "level", "elements and steps"),
            "quantity": named([measure.name for measure in MEASURES], "quantity", "measure of a turn"),
            "unit": named([measure.si for measure in MEASURES], "quantity", "unit of the quantity"),
        },
    )
