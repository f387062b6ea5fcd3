"""Machine and cases of the nine-bar mechanism of Chen, Jiang, Deng and Wang (Nonlinear Dynamics, 2018)."""

from __future__ import annotations

import math
from typing import Any

from nine_bar_study.case import USUAL, Case, Machine
from nine_bar_study.drawing import Observable, Quantity
from nine_bar_study.figures.bifurcation import Over
from nine_bar_study.figures.contrast import Contrast
from nine_bar_study.nine_bar.lugre import LoadScaledLuGre

from flexmb.mechanisms.nine_bar import nine_bar

FRICTION = {
    "coulomb": "coulomb",
    "lugre": LoadScaledLuGre(static=0.015, kinetic=0.01, stribeck_speed=1e-3, stiffness=1e5, damping=300.0),
}
"""Friction laws: modified Coulomb of the paper, and LuGre with assumed parameters, since table 3 is missing."""

LONGEST_STEP = 2e-4
"""Longest step [s]: a hundredth of the period of the vibration of a loaded journal along its bearing.

Constant sliding friction hardly damps these vibrations.  The default tolerance allows steps of milliseconds in slow
motions, and the dissipation of such steps damps the vibrations.  At 0.5 pi rad/s the exponent of the rigid mechanism is
-3 1/s with steps of milliseconds, and -0.01 +- 0.05 1/s with `LONGEST_STEP`."""

SOFT = 2.0
"""Turns in which the cranks accelerate to full speed; a start at full speed excites weakly damped vibrations."""

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


def case(model: str, speed: float, clearance: float = USUAL, **others: Any) -> Case:
    """Case of the nine-bar mechanism: speed over pi [rad/s], clearance at P1 [m], other arguments of `Case`."""
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
"""Accepted relative error of steps in diagrams of the flexible mechanism with exponents.

The runs take half the time of runs with the default, and the exponents agree: at 0.05 mm 50.5 +- 1.0 1/s with 1e-4,
50.5 +- 1.5 with 1e-5, 51.1 +- 1.7 in the diagram.  Diagrams of the rigid mechanism have the default, since exponents at
small clearances depend on the tolerance (28.8 +- 0.7 against 12.9 +- 0.5 1/s) and the time does not decrease."""

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
"""Diagram over the speed, with smaller intervals about the published threshold of 1.6 pi rad/s."""

PRINTED = {
    (2.0, 0.05e-3): {"P1.ex": 0.0111, "P1.ey": 0.0656, "slider.x": -0.0221},
    (2.0, 0.5e-3): {"P1.ex": 0.4226, "P1.ey": 0.1088, "slider.x": -0.0135},
    (0.5, 0.5e-3): {"P1.ex": -0.0026, "P1.ey": -0.0187, "slider.x": -0.0106},
    (2.5, 0.5e-3): {"P1.ex": 0.6890, "P1.ey": 0.1868, "slider.x": -0.0021},
}
"""Published exponents of unknown unit, by (speed over pi [rad/s], clearance [m]) and observable."""
