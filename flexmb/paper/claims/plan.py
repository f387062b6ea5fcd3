"""Which runs the claims are judged by, and with which finer ones a "disagrees" is attacked."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

from flexmb.mechanisms.nine_bar_data import NineBarData
from flexmb.paper.attractor import Attractor
from flexmb.paper.case import Case
from flexmb.paper.claims.chaos import NEAR
from flexmb.paper.claims.evidence import FAST, LARGE, MIDDLE, PLAY_MODELS, SLOW, SMALL, SMALLEST, Key, Plan, ideal
from flexmb.paper.claims.response import CASES
from flexmb.paper.diagram import VALUES, Diagram
from flexmb.paper.effort import Effort
from flexmb.paper.growth import Growth
from flexmb.paper.motion import Motion
from flexmb.paper.plate import Run

SPEEDS = {"full": (0.5, 1.0, 1.5, 1.75, 2.0, 2.25, 2.5), "quick": (SLOW, MIDDLE, FAST)}
"""Over pi [rad/s], for peaks over the speed."""

SPEEDS_WITHOUT_FRICTION = {"full": (0.5, 1.0, 1.5, 2.0, 2.5), "quick": (SLOW, MIDDLE, FAST)}

START_TURNS = 3
MANY_TURNS = 100
"""Of the rigid mechanism, where a difference is within the spread of the usual number."""

SOME_TURNS = 60
"""At 0.05 mm with finer steps, where the peaks of 20 turns scatter too much."""

LONG = (60, 150)
"""Periods before the first point, and points, of exponents that are looked at again."""

SHORT = (20, 50)
"""The same with finer steps."""

FINER = 1e-5
MESHES = (2, 8)
NO_FRICTION = NineBarData(friction_coefficient=0.0)

SLOWER = NineBarData(least_approach=1e-7)
SHORTER = 5e-5
"""Numbers that are no physics, made finer: least approach speed [m/s] and longest step [s]."""


def case_of(key: Key) -> Case:
    """The case that a key names."""
    if key.model == "ideal":
        return Case(model="ideal", speed=key.speed)
    if key.law == "none":
        return Case(model=key.model, speed=key.speed, clearance=key.clearance, data=NO_FRICTION, label="cf=0")
    return Case(model=key.model, speed=key.speed, clearance=key.clearance, friction=key.law)


def settled(key: Key, effort: Effort, rtol: float | None = None) -> Motion:
    """Its settled turns."""
    return Motion(case_of(key), effort.skip, effort.keep, effort.shown, rtol)


def started(key: Key, rtol: float | None = None) -> Motion:
    """Its first turns."""
    return Motion(dataclasses.replace(case_of(key), label="start", ramp=0.0), 0, START_TURNS, START_TURNS, rtol)


def of_long_run(key: Key, effort: Effort) -> Run:
    """The long run that says what kind of motion it is; a quick look has two beam elements a link."""
    elements = 2 if effort.name == "quick" and key.model == "flexible" else 4
    return Attractor(dataclasses.replace(case_of(key), elements=elements), effort.settle, effort.points, effort.series)


def of_diagrams(effort: Effort) -> dict[tuple[str, str], Run]:
    """Diagrams over the speed and over the clearance, by parameter and model."""
    return {
        (parameter, model): Diagram.at(parameter, effort, flexible=model == "flexible")
        for parameter in VALUES
        for model in PLAY_MODELS
    }


def plan(effort: Effort) -> Plan:
    """The runs that decide.

    Parameters
    ----------
    effort : how long they are.
    """
    keys = [ideal(speed) for speed in SPEEDS[effort.name]]
    keys += [Key(model, speed) for model in PLAY_MODELS for speed in SPEEDS[effort.name]]
    keys += [Key(model, speed, clearance) for model in PLAY_MODELS for speed, clearance in CASES]
    models = PLAY_MODELS if effort.name == "full" else PLAY_MODELS[:1]
    keys += [Key(model, speed, LARGE, "none") for model in models for speed in SPEEDS_WITHOUT_FRICTION[effort.name]]
    laws = [Key("rigid", FAST), Key("rigid", FAST, LARGE, "lugre")]
    near = [Key("flexible", speed) for speed in NEAR] if effort.name == "full" else []
    return Plan(
        {key: settled(key, effort) for key in [*keys, *laws]},
        {key: started(key) for key in laws},
        {key: of_long_run(key, effort) for key in (Key("flexible", *case) for case in CASES)}
        | {key: Growth(case_of(key), *LONG) for key in near},
        of_diagrams(effort),
    )


def attacks(effort: Effort) -> Mapping[str, Plan]:
    """Runs with which a "disagrees" is tried again, by what is finer or longer in them; none at a quick look.

    Parameters
    ----------
    effort : how long they are.
    """
    if effort.name != "full":
        return {}
    keys = [Key(model, *case) for model in PLAY_MODELS for case in CASES]
    pure = {ideal(speed): settled(ideal(speed), effort) for speed in (SLOW, MIDDLE, FAST)}
    other_speeds = [Key(model, speed) for model in PLAY_MODELS for speed in SPEEDS[effort.name]]
    laws = [Key("rigid", FAST), Key("rigid", FAST, LARGE, "lugre")]
    slippery = [Key(model, speed, LARGE, "none") for model in PLAY_MODELS for speed in SPEEDS_WITHOUT_FRICTION["full"]]
    scattered = {key: lengthened(key, effort, SOME_TURNS, FINER) for key in keys if key.clearance == SMALL}
    finer = Plan(
        pure | {key: settled(key, effort, FINER) for key in [*keys, *other_speeds, *slippery, laws[1]]} | scattered,
        {key: started(key, FINER) for key in laws},
        {
            key: Growth(case_of(key), *SHORT, FINER)
            for key in [*keys, Key("flexible", MIDDLE, SMALLEST)]
            if key.model == "flexible"
        },
    )
    meshes = {f"{n} elements": Plan(pure | {key: meshed(key, effort, n) for key in keys}) for n in MESHES}
    rigid = [key for key in (*keys, laws[1]) if key.model == "rigid"]
    near = [Key(model, speed) for model in PLAY_MODELS for speed in NEAR]
    longer = Plan(
        pure | {key: lengthened(key, effort) for key in rigid},
        growths={key: Growth(case_of(key), *LONG) for key in (*(Key("rigid", *case) for case in CASES), *near)},
    )
    ours = Plan(
        pure
        | {key: finer_numbers(key, effort) for key in [*keys, *other_speeds, *slippery, laws[1]]}
        | {key: finer_numbers(key, effort, SOME_TURNS) for key in keys if key.clearance == SMALL}
    )
    return {
        f"rtol {FINER:g}": finer,
        f"least_approach {SLOWER.least_approach:g} m/s, steps of {1e3 * SHORTER:g} ms at most": ours,
        **meshes,
        f"{MANY_TURNS} turns (rigid), exponents over {LONG[1]} after {LONG[0]}": longer,
    }


def meshed(key: Key, effort: Effort, elements: int) -> Motion:
    """Its settled turns with another number of elements; those of the rigid mechanism are the same."""
    case = case_of(key)
    case = dataclasses.replace(case, elements=elements) if key.model == "flexible" else case
    return Motion(case, effort.skip, effort.keep, effort.shown)


def finer_numbers(key: Key, effort: Effort, turns: int | None = None) -> Motion:
    """Its settled turns with the numbers that are no physics made finer."""
    case = case_of(key)
    data = dataclasses.replace(case.data, least_approach=SLOWER.least_approach)
    case = dataclasses.replace(
        case, data=data, longest=SHORTER, label="-".join(filter(None, (case.label, "ours finer")))
    )
    return Motion(case, effort.skip, turns or effort.keep, effort.shown)


def lengthened(key: Key, effort: Effort, turns: int = MANY_TURNS, rtol: float | None = None) -> Motion:
    """Many settled turns."""
    case = dataclasses.replace(case_of(key), label=f"{turns} turns")
    return Motion(case, effort.skip, turns, effort.shown, rtol)
