"""Runs of the claims on the nine-bar mechanism: deciding runs, and finer or longer runs of the attacks."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from nine_bar_study.case import PLAY_MODELS
from nine_bar_study.claims.evidence import Key, Plan, ideal
from nine_bar_study.effort import Effort
from nine_bar_study.exponent import growth
from nine_bar_study.motion import motion
from nine_bar_study.nine_bar.cases import OVER_CLEARANCE, OVER_SPEED
from nine_bar_study.nine_bar.measures import CASES, FAST, LARGE, MIDDLE, NEAR, NEAREST, SLOW, SMALLEST, case_of, key
from nine_bar_study.run import StudyRun

from flexmb.mechanisms.nine_bar import NineBarData

SPEEDS = (SLOW, MIDDLE, FAST)
"""Speeds over pi [rad/s] of the paper."""

DATA = NineBarData()
START_TURNS = 3
MANY_TURNS = 100
"""Number of settled turns of the rigid mechanism in longer runs."""

SOME_TURNS = 60
"""Number of settled turns at 0.05 mm with finer steps; the deviation of the peaks over 20 turns is too large."""

LONG, SHORT, SHORTEST = (60, 150), (20, 50), (10, 50)
"""Periods before the first section point, and number of section points: longer runs, finer steps, quick effort."""

FINER, MESHES = 1e-5, (2, 8)
LEAST_APPROACH, SHORTER = 1e-7, 5e-5
"""Smaller values of numerical parameters: least approach speed [m/s] and longest step [s]."""

LAWS = (key("rigid", FAST), key("rigid", FAST, LARGE, "lugre"))
AT_CASES = tuple(key(model, *case) for model in PLAY_MODELS for case in CASES)


def plan(effort: Effort) -> Plan:
    """Deciding runs at an effort."""
    models = PLAY_MODELS if effort.full else PLAY_MODELS[:1]
    keys = [*(ideal(speed) for speed in SPEEDS), *AT_CASES, *_slippery(models), *LAWS]
    near = [key("flexible", speed) for speed in NEAR if effort.full or speed in NEAREST]
    near += [key("flexible", MIDDLE, SMALLEST), *(one for one in AT_CASES if one.model == "rigid")]
    lengths = LONG if effort.full else SHORTEST
    return Plan(
        {one: effort.settled(case_of(one)) for one in keys},
        {one: started(one) for one in LAWS},
        {one: _long(one, effort) for one in AT_CASES if one.model == "flexible"}
        | {one: growth(changed(one, elements=effort.elements), *lengths) for one in near},
        {
            (over.parameter, model): over.run(effort, model)
            for over in (OVER_SPEED, OVER_CLEARANCE)
            for model in PLAY_MODELS
            if effort.exponents  # without them diagrams cannot decide
        },
    )


def attacks(effort: Effort) -> Mapping[str, Plan]:
    """Finer or longer runs at an effort, by text of the change; none at the quick effort."""
    if not effort.full:
        return {}
    pure = {ideal(speed): effort.settled(case_of(ideal(speed))) for speed in SPEEDS}
    many = (*AT_CASES, *_slippery(PLAY_MODELS), LAWS[1])
    scattered = [one for one in AT_CASES if one.clearance < LARGE]
    flexible = [one for one in (*AT_CASES, key("flexible", MIDDLE, SMALLEST)) if one.model == "flexible"]
    finer = Plan(
        pure
        | {one: effort.settled(changed(one, rtol=FINER)) for one in many}
        | {one: lengthened(one, effort, SOME_TURNS, rtol=FINER) for one in scattered},
        {one: started(one, rtol=FINER) for one in LAWS},
        {one: growth(changed(one, rtol=FINER), *SHORT) for one in flexible},
    )
    meshes = {f"{n} elements": Plan(pure | {one: effort.settled(meshed(one, n)) for one in AT_CASES}) for n in MESHES}
    rigid = [one for one in AT_CASES if one.model == "rigid"]
    again = (*rigid, *(key(model, speed) for model in PLAY_MODELS for speed in NEAR))
    longer = Plan(
        pure | {one: lengthened(one, effort, MANY_TURNS) for one in (*rigid, LAWS[1])},
        growths={one: growth(case_of(one), *LONG) for one in again},
    )
    ours = Plan(
        pure
        | {one: _finer_numbers(one, effort) for one in many}
        | {one: _finer_numbers(one, effort, SOME_TURNS) for one in scattered}
    )
    return {
        f"rtol {FINER:g}": finer,
        f"least_approach {LEAST_APPROACH:g} m/s, steps of {1e3 * SHORTER:g} ms at most": ours,
        **meshes,
        f"{MANY_TURNS} turns (rigid), exponents over {LONG[1]} after {LONG[0]}": longer,
    }


def changed(one: Key, **numbers: Any) -> Any:
    """Case of a key with changed fields."""
    return dataclasses.replace(case_of(one), **numbers)


def meshed(one: Key, elements: int) -> Any:
    """Case of a key with another number of beam elements per link, unchanged for the rigid mechanism."""
    return changed(one, elements=elements) if one.model == "flexible" else case_of(one)


def started(one: Key, **numbers: Any) -> StudyRun:
    """Run of the first turns of a key, with a start at full speed."""
    return motion(changed(one, label="start", ramp=0.0, **numbers), 0, START_TURNS, START_TURNS)


def lengthened(one: Key, effort: Effort, turns: int, **numbers: Any) -> StudyRun:
    """Run of settled turns of a key, of another number of turns."""
    return effort.settled(changed(one, label=f"{turns} turns", **numbers), turns)


def _long(one: Key, effort: Effort) -> StudyRun:
    return effort.attractor(changed(one, elements=effort.elements))


def _finer_numbers(one: Key, effort: Effort, turns: int | None = None) -> StudyRun:
    """Run of settled turns of a key with `LEAST_APPROACH` and `SHORTER`."""
    case = case_of(one)
    label = "-".join(filter(None, (case.label, "ours finer")))
    data = dataclasses.replace(case.data or DATA, least_approach=LEAST_APPROACH)
    return effort.settled(dataclasses.replace(case, data=data, longest=SHORTER, label=label), turns)


def _slippery(models: tuple[str, ...]) -> list[Key]:
    return [key(model, speed, LARGE, "none") for model in models for speed in (SLOW, FAST)]
