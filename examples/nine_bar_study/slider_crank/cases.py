"""Machine and cases of the slider-crank with a worn piston pin of Flores, Ambrosio, Claro and Lankarani (2008)."""

from __future__ import annotations

import math
from typing import Any

from nine_bar_study.case import USUAL, Case, Machine
from nine_bar_study.drawing import Observable, Quantity
from nine_bar_study.figures.bifurcation import Over
from nine_bar_study.figures.contrast import Contrast

from flexmb.mechanisms.slider_crank import SliderCrankData, slider_crank

QUANTITIES = {
    "slider.x": Quantity("displacement of the slider", "mm", 1e3),
    "slider.vx": Quantity("velocity of the slider", "m/s"),
    "slider.ax": Quantity("acceleration of the slider", "m/s²"),
    "motor.torque": Quantity("crank moment", "N m"),
    "B.force": Quantity("contact force in the piston pin", "N"),
    "B.penetration": Quantity("penetration in the piston pin", "µm", 1e6),
}

RPM = 2.0 * math.pi / 60.0

MACHINE = Machine(
    make=slider_crank,
    unit="rpm",
    short="rpm",
    factor=RPM,
    turn=60.0,
    drives="crank",
    joint="B",
    quantities=QUANTITIES,
    peaks=("slider.vx", "slider.ax", "motor.torque", "B.force"),
    observables=(
        Observable("B.ex", "B.vex", "journal along X", "µm", 1e6),
        Observable("B.ey", "B.vey", "journal along Y", "µm", 1e6),
        Observable("slider.x", "slider.vx", "slider", "mm", 1e3),
    ),
    laws={"none": None, "coulomb": "coulomb"},
    clearance=0.5e-3,
    elements=8,
    ramp=0.0,
    longest=1e-5,
    cost={"ideal": 0.01, "rigid": 0.05, "flexible": 0.5},
)
"""Slider-crank that starts at full speed, with crank and rod collinear and the journal in the middle of its bearing."""

DATA = SliderCrankData(v0=0.0)
"""Data of the independent computation: the friction coefficient rises from zero slip."""
SPEED = 5000.0
"""Speed of the crank [rpm]."""


def case(model: str, clearance: float = USUAL, speed: float = SPEED, **others: Any) -> Case:
    """Case of the slider-crank: clearance of the piston pin [m], speed [rpm], other arguments of `Case`."""
    return Case(machine=MACHINE, model=model, speed=speed, clearance=clearance, **others)


PLAYS = Contrast(
    "5000 rpm",
    ("clearance 0.1 mm", "clearance 0.5 mm"),
    (case("rigid", 0.1e-3), case("rigid", 0.5e-3)),
)
SPEEDS = Contrast(
    "clearance 0.5 mm",
    ("1000 rpm", "5000 rpm"),
    (case("rigid", 0.5e-3, 1000.0), case("rigid", 0.5e-3)),
)
OVER_CLEARANCE = Over(
    "clearance",
    Quantity("clearance", "mm", 1e3),
    tuple(n * 2e-5 for n in range(1, 26)),
    case("rigid"),
    "5000 rpm",
)
