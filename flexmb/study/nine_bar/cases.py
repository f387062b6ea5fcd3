"""The nine-bar mechanism of Chen, Jiang, Deng and Wang (Nonlinear Dynamics, 2018): machine and cases."""

from __future__ import annotations

import math
from typing import Any

from flexmb.mechanisms.nine_bar import nine_bar
from flexmb.study.case import Case, Machine
from flexmb.study.drawing import Observable, Quantity
from flexmb.study.figures.bifurcation import Over
from flexmb.study.figures.contrast import Contrast
from flexmb.study.nine_bar.lugre import LoadScaledLuGre

FRICTION = {
    "coulomb": "coulomb",
    "lugre": LoadScaledLuGre(static=0.015, kinetic=0.01, stribeck_speed=1e-3, stiffness=1e5, damping=300.0),
}
"""Friction laws: the paper's modified Coulomb, and its LuGre with numbers of ours (its table 3 is missing)."""

LONGEST_STEP = 2e-4
"""[s], a hundredth of the period in which a journal that is pressed on its bearing swings along it.

Friction is constant while it slides, so these vibrations hardly die out.  Steps of milliseconds, which the default
tolerance allows where nothing else moves fast, would damp them: at 0.5 pi rad/s the exponent of the rigid mechanism is
-3 1/s with such steps, and -0.01 +- 0.05 1/s with these."""

SOFT = 2.0
"""Turns in which the cranks get to their speed; a start at full speed would set off vibrations that hardly die out."""

QUANTITIES = {
    "slider.x": Quantity("displacement of the slider along X", "mm", 1e3),
    "slider.vx": Quantity("velocity of the slider", "m/s"),
    "slider.ax": Quantity("acceleration of the slider", "m/s²"),
    "motor1.torque": Quantity("driving torque of crank 1", "N m"),
    "motor4.torque": Quantity("driving torque of crank 4", "N m"),
    "P1.force": Quantity("contact force at P1", "N"),
    "P1.penetration": Quantity("penetration at P1", "µm", 1e6),
}

MACHINE = Machine(
    make=nine_bar,
    unit="pi rad/s",
    short="pi",
    factor=math.pi,
    turn=2.0,
    drives="cranks",
    joint="P1",
    quantities=QUANTITIES,
    peaks=("slider.ax", "motor1.torque", "motor4.torque", "P1.force"),
    observables=(
        Observable("P1.ex", "P1.vex", "journal along X", "µm", 1e6, "mm/s", 1e3),
        Observable("P1.ey", "P1.vey", "journal along Y", "µm", 1e6, "mm/s", 1e3),
        Observable("slider.x", "slider.vx", "slider", "mm", 1e3),
    ),
    laws=FRICTION,
    clearance=0.5e-3,
    elements=4,
    ramp=SOFT,
    longest=LONGEST_STEP,
    cost={"ideal": 0.01, "rigid": 0.15, "flexible": 0.9},
)


def case(model: str, speed: float, clearance: float | None = None, **others: Any) -> Case:
    """A case of the nine-bar mechanism; speed over pi [rad/s], clearance at P1 [m], others as of `Case`."""
    return Case(machine=MACHINE, model=model, speed=speed, clearance=clearance, **others)


PLAYS = Contrast(
    "2π rad/s",
    ("clearance 0.05 mm", "clearance 0.5 mm"),
    (case("flexible", 2.0, 0.05e-3), case("flexible", 2.0, 0.5e-3)),
)
SPEEDS = Contrast(
    "clearance 0.5 mm",
    ("0.5π rad/s", "2.5π rad/s"),
    (case("flexible", 0.5, 0.5e-3), case("flexible", 2.5, 0.5e-3)),
)

COARSE = {"flexible": 1e-3}
"""Tolerance of diagrams with exponents and beams: their runs are long, and take half the time of default steps.

Their exponents do not depend on it: 50.5 +- 1.0 1/s at 0.05 mm with 1e-4, 50.5 +- 1.5 with 1e-5, 51.1 +- 1.7 in the
diagram.  Without beams they do where the play is small, 28.8 +- 0.7 against 12.9 +- 0.5 1/s, and no time is gained."""

OVER_CLEARANCE = Over(
    "clearance",
    Quantity("clearance", "mm", 1e3),
    tuple(n * 1e-5 for n in (*range(1, 10), *range(10, 51, 2))),
    case("flexible", 2.0),
    "2π rad/s",
    COARSE,
)
"""Clearances closer to each other where they are small: the motion changes from 0.01 to 0.1 mm, hardly beyond."""
OVER_SPEED = Over(
    "speed",
    Quantity("speed of the cranks", "π rad/s", 1.0 / math.pi),
    tuple(math.pi * n / 40 for n in (*range(20, 60, 2), *range(60, 81), *range(82, 101, 2))),
    case("flexible", 2.5),
    "clearance 0.5 mm",
    COARSE,
    (1.6, 1.65, "threshold of the paper"),
)
"""Speeds closer to each other about the paper's threshold of 1.6 pi."""

PRINTED = {
    (2.0, 0.05e-3): {"P1.ex": 0.0111, "P1.ey": 0.0656, "slider.x": -0.0221},
    (2.0, 0.5e-3): {"P1.ex": 0.4226, "P1.ey": 0.1088, "slider.x": -0.0135},
    (0.5, 0.5e-3): {"P1.ex": -0.0026, "P1.ey": -0.0187, "slider.x": -0.0106},
    (2.5, 0.5e-3): {"P1.ex": 0.6890, "P1.ey": 0.1868, "slider.x": -0.0021},
}
"""The paper's exponents by speed over pi [rad/s] and clearance [m], without a unit, as it prints them."""
