"""Keys and measures of the claims on the nine-bar mechanism."""

from __future__ import annotations

from nine_bar_study.case import Case
from nine_bar_study.claims.evidence import Key, Measure
from nine_bar_study.nine_bar.cases import case

from flexmb.mechanisms.nine_bar import NineBarData

LARGE, SMALL, SMALLEST = 0.5e-3, 0.05e-3, 0.01e-3
"""Clearances of the paper [m]; `SMALLEST` is the first value of the published diagrams."""

SLOW, MIDDLE, FAST = 0.5, 2.0, 2.5
"""Speeds of the paper over pi [rad/s]."""

CASES = ((MIDDLE, SMALL), (MIDDLE, LARGE), (SLOW, LARGE), (FAST, LARGE))
"""Speeds over pi [rad/s] and clearances [m] of the published comparisons of rigid and flexible links."""

FORCE = Measure("peak.P1.force", "contact force", "N")
ACCELERATION = Measure("peak.slider.ax", "slider acceleration", "m/s^2")
TORQUES = Measure("peak.motor1.torque", "torque 1", "N m"), Measure("peak.motor4.torque", "torque 4", "N m")
FLIGHT, DEPTH = Measure("flight", "free flight", "%", 100.0), Measure("penetration", "penetration", "um", 1e6)
LANDINGS = Measure("landings", "landings a turn")
RESPONSES = (ACCELERATION, *TORQUES)
PEAKS = (FORCE, *RESPONSES)
MEASURES = (*PEAKS, FLIGHT, DEPTH, LANDINGS)
"""Measures of a turn with the units of tables."""

NEAREST = LAST_PERIODIC, FIRST_CHAOTIC = 1.6, 1.65
"""Published threshold of chaos: last periodic and first chaotic speed over pi [rad/s]."""

NEAR = (1.55, 1.575, 1.6, 1.65, 1.7, 1.95, 1.975)
"""Speeds over pi [rad/s] of long runs: about the threshold of chaos, and at inconclusive values of the diagram."""

NO_FRICTION = NineBarData(friction_coefficient=0.0)
LAW_TEXTS = {"coulomb": "", "lugre": ", LuGre", "none": ", no friction"}


def key(model: str, speed: float, clearance: float = LARGE, law: str = "coulomb") -> Key:
    """Key of a case with clearance: speed over pi [rad/s], clearance [m]."""
    return Key(model, speed, clearance, law)


def text_of(one: Key) -> str:
    """Text of a key for tables."""
    play = f", {1e3 * one.clearance:.3g} mm" if one.clearance else ""
    return f"{one.model}, {one.speed:g} pi rad/s{play}{LAW_TEXTS[one.law]}"


def case_of(one: Key) -> Case:
    """Case of a key."""
    if one.model == "ideal":
        return case("ideal", one.speed)
    if one.law == "none":
        return case(one.model, one.speed, one.clearance, data=NO_FRICTION, label="cf=0")
    return case(one.model, one.speed, one.clearance, friction=one.law)
