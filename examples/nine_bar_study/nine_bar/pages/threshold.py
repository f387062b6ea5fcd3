"""Page "threshold": the largest speed without free flight in the joint."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from nine_bar_study.drawing import named, noted
from nine_bar_study.effort import Effort
from nine_bar_study.item import StudyPage
from nine_bar_study.markdown import paragraph, table
from nine_bar_study.nine_bar.cases import SOFT, case
from nine_bar_study.nine_bar.measures import FIRST_CHAOTIC, LAST_PERIODIC
from nine_bar_study.nine_bar.reaction import crossings, reaction, reversal, turning
from nine_bar_study.onset import onset
from nine_bar_study.run import Results, StudyRun

if TYPE_CHECKING:
    import xarray as xr

CLEARANCES = {"full": (0.5e-3, 0.25e-3, 0.1e-3, 0.05e-3), "quick": (0.5e-3,)}
"""Clearances at P1 [m] by effort."""

MODELS = {"full": ("rigid", "flexible"), "quick": ("rigid",)}
TURNS = {"full": (25, 10), "quick": (10, 3)}
"""Turns before the first settled turn, and number of settled turns, by effort."""

BEGIN, END = 1.4, 3.0
"""First and largest simulated speed over pi [rad/s]."""

SPEEDS = (0.5, 1.0, 1.5, 1.6, 1.65, 1.7, 1.8, 2.0, 2.5)
PAPER = (LAST_PERIODIC, FIRST_CHAOTIC)
COARSE, FINE = 0.05, 0.005
"""Step of the speed, and final width of the bracket, over pi [rad/s]."""

REACTION = """
In the ideal mechanism the force on the joint P1 is F = S + w^2 D at each angle of the cranks: S is what gravity
needs, D what the inertia of the bodies needs. It is a vector in the plane. As a closed curve over the turn, its
hodograph, it runs through the origin only at single speeds; there S and D are parallel and opposed. The first of them
is {first}. That is far above all speeds of the paper, and contact does not wait for it: at {reversal:.4f} pi rad/s
the component of F along its own mean over the turn falls to zero. From there on the force turns round within a small
angle of the crank, and no side of the bearing is pressed all the time. What is left of F then is a force across the
mean direction of {least:.2g} N; the largest force of that turn is {most:.3g} N. This reversal is the threshold that
the ideal reaction gives; it does not depend on the clearance.
"""

SIMULATION = """
With play, the last speed at which no settled turn has any free flight (the smallest step in which the gap is open
would count), and the first at which one has, found by going up from {begin:g} pi rad/s and halving the bracket down
to {fine:g} pi rad/s. Contact counts as unbroken after {keep} turns without flight, {settle} turns after the cranks
have come to speed. A soft start brings them there within {ramp:g} turns; a hard one begins at full speed with the
journal in the middle of its bearing. Least force: the smallest normal force in the turns that count at the last
unbroken speed; beside it that of the ideal joint.
"""


def threshold(effort: Effort) -> StudyPage:
    """Page "threshold" at an effort."""
    ideal, onsets = reaction(case("ideal", PAPER[0])), onsets_of(effort)

    def write(results: Results) -> tuple[str, xr.Dataset]:
        return written(results[ideal], {run: results[run] for run in onsets})

    return StudyPage("threshold", "The last speed with unbroken contact", (ideal, *onsets), write)


def onsets_of(effort: Effort) -> tuple[StudyRun, ...]:
    """Runs of the thresholds with clearance at an effort."""
    lengths = (END, *TURNS[effort.name])
    places = [(model, clearance) for model in MODELS[effort.name] for clearance in CLEARANCES[effort.name]]
    soft = [onset(case(model, BEGIN, clearance), *lengths, coarse=COARSE, fine=FINE) for model, clearance in places]
    if not effort.full:
        return tuple(soft)
    return (*soft, *(onset(case(model, BEGIN), *lengths, "hard", coarse=COARSE, fine=FINE) for model in MODELS["full"]))


def written(ideal: xr.Dataset, onsets: dict[StudyRun, xr.Dataset]) -> tuple[str, xr.Dataset]:
    """Text and numbers of the page."""
    import xarray

    static, dynamic = ideal["static"].values, ideal["dynamic"].values
    round_at, zeros = reversal(static, dynamic), crossings(static, dynamic)
    text = [*_ideal(static, dynamic, round_at), *_with_play(onsets, static, dynamic)]
    ends = {run: (data.attrs["last_unbroken"], data.attrs["first_broken"]) for run, data in onsets.items()}
    data = xarray.Dataset(
        {
            "last_unbroken": noted([low for low, _ in ends.values()], "run", "pi rad/s", "last speed without flight"),
            "first_broken": noted([high for _, high in ends.values()], "run", "pi rad/s", "first speed with flight"),
            "static": noted(static, ("angle", "axis"), "N", "force S on the ideal P1 at rest"),
            "dynamic": noted(dynamic, ("angle", "axis"), "N s^2", "force D, S + w^2 D at the speed w [rad/s]"),
        },
        coords={
            "run": named([run.name for run in ends], "run", "run with play"),
            "angle": noted(ideal["angle"].values, "angle", "rad", "angle of crank 4"),
            "axis": named(["x", "y"], "axis", "component"),
        },
        attrs={"reversal": round_at, "first_crossing": zeros[0].speed if zeros else math.nan},
    )
    return "\n\n".join(text) + "\n", data


def _ideal(static: np.ndarray, dynamic: np.ndarray, round_at: float) -> list[str]:
    """Passage and table on the reaction of the ideal joint."""
    zeros, first = crossings(static, dynamic), "none"
    if zeros:
        first = f"{zeros[0].speed:.4f} pi rad/s, at {math.degrees(zeros[0].angle):.1f} degrees of crank 4"
    there = turning(static, dynamic, round_at)
    most = float(np.hypot(*(static + (math.pi * round_at) ** 2 * dynamic).T).max())
    rows = []
    for speed in (*SPEEDS, *(zero.speed for zero in zeros[:1])):
        found = turning(static, dynamic, speed)
        direction = (f"{math.degrees(found.angle):.1f}", f"{math.degrees(found.swing):.0f}", f"{found.fastest:.3g}")
        rows.append([f"{speed:.4g} pi", f"{found.least:.3g}", *direction, str(found.turns)])
    head = (
        *("speed [rad/s]", "least force [N]", "at crank angle [degrees]", "swing of the direction [degrees]"),
        *("fastest turn of the direction [rad/rad]", "times round in a turn"),
    )
    return [
        "## From the ideal mechanism",
        paragraph(REACTION.format(first=first, reversal=round_at, least=there.least, most=most)),
        table(head, rows),
    ]


def _with_play(onsets: dict[StudyRun, xr.Dataset], static: np.ndarray, dynamic: np.ndarray) -> list[str]:
    """Passage and table on simulations with clearance, and on the published threshold."""
    if not onsets:
        return []
    rows, one = [], next(iter(onsets))
    for run, data in onsets.items():
        low, high = data.attrs["last_unbroken"], data.attrs["first_broken"]
        speeds = data["speed"].values
        at, above = int(np.abs(speeds - low).argmin()), int(np.abs(speeds - high).argmin())
        rows.append(
            [
                run.case.model,
                f"{1e3 * run.case.clearance:g}",
                run["start"],
                f"{low:.4f} pi",
                f"{high:.4f} pi",
                f"{float(data['least_force'][at]):.3g}",
                f"{turning(static, dynamic, low).least:.3g}",
                f"{100.0 * float(data['flight'][above]):.2g}",
                "yes" if low >= PAPER[0] - FINE and high <= PAPER[1] + FINE else "no",
            ]
        )
    head = (
        *("model", "clearance [mm]", "start", "last unbroken [rad/s]", "first broken [rad/s]", "least force [N]"),
        "least force, ideal [N]",
        *("free flight at the first broken [%]", "between the paper's 1.6 and 1.65 pi"),
    )
    text = SIMULATION.format(begin=BEGIN, fine=FINE, keep=one["keep"], settle=one["settle"], ramp=SOFT)
    said = (
        "The paper calls the motion (flexible, 0.5 mm) periodic up to 1.6 pi and chaotic from 1.65 pi rad/s on; it "
        "gives no speed for contact and none for other clearances."
    )
    ends = [data.attrs[name] for data in onsets.values() for name in ("last_unbroken", "first_broken")]
    low, high, round_at = min(ends), max(ends), reversal(static, dynamic)
    where = "below" if high < round_at else "above" if low > round_at else "on both sides of"
    said += (
        f" Contact breaks between {low:.3f} and {high:.3f} pi rad/s, {where} the speed of {round_at:.3f} pi rad/s at "
        "which the reaction of the ideal joint turns round: the journal swings in its play, and the force with it."
    )
    return ["## With play", paragraph(text), table(head, rows, left=3), paragraph(said)]
