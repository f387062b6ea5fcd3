"""Derivatives by the numbers of each kind of part, beside differences of runs with the same fixed steps."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np
import pytest
from designs import CENTRAL

import flexmb as fm
from flexmb.design.derivatives import Span, derivatives
from flexmb.design.parameters import ParameterModel
from flexmb.run import run

HERE = Path(__file__).resolve()


def _each_part():
    spec = importlib.util.spec_from_file_location("each_part", HERE.parents[1] / "parts" / "test_check_part.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    laws = {kind: (module.two_links(module.clearance(*law)), "pin") for kind, law in module.LAWS.items()}
    return module.BUILT_IN | laws


BUILT_IN = _each_part()
STEP, STEPS = 1e-4, 20

PARTS = 1e-3, 3e-3, 1e-5
"""Differences relative to the parameter: the second where round-off shows, the third where vibrations turn by radians.
"""

KINDS = {"m": 0.1, "rad": 0.1, "m/s": 0.01, "rad/s": 0.1, "N": 1.0, "N m": 0.1}
"""Units of the signals that are compared, and usual sizes of these signals in the two thousandths of a second."""

LEAST = 1e-2
"""Relative derivative below which a derivative is compared with the size of the signal."""

QUICK = {
    "RigidLink": "crank.inertia",
    "FlexibleLink, damped": "arm.section.height",
    "FlexibleLink, arc": "arm.material.density",
    "PlaneBody": "plate.thickness",
    "Revolute, friction": "A.friction.coefficient",
    "HuntCrossley": "pin.normal.restitution",
    "LuGre": "pin.friction.stiffness",
    "Bushing": None,
    "Torque, Harmonic": "load.history.frequency",
    "Gear, backlash": None,
    "CurveOnCurve, contact": None,
    "OneWayClutch": None,
    "Drive of a Prismatic": "motor.motion.speed",
    "DCMotor": None,
}
"""A kind of part of each family, with one of its numbers (None: its first)."""

REFUSED = {"FlexibleLink, bent and moving", "JournalBearing, short, half"}
"""Mechanisms that no step of this size solves, or whose film jumps with the sense of its wedge."""

DIRECTIONS = ("attitude",)
"""Directions of small vectors, which turn within the differences by which derivatives of signals are found."""

BOUND = 2e-5
BOUNDS = {
    "Clamp": 2e-4,
    "FlexibleFrame, arcs": 5e-5,
    "FlexibleLink, arc": 5e-5,
    "FlexibleLink, uneven": 5e-5,
    "FlexibleLink, arc, mass damping": 2e-3,
    "Prismatic, friction": 5e-5,
    "WornBearing": 5e-4,
}
"""Largest errors.  Of a falling arc or beam all derivatives are 0, and round-off of its stiff axis over the difference
of the parameter is left (4e-10 rad/s, with mass damping 8e-7 rad/s for a turn by one radian).  The angle of contact of
a worn bearing is where its gap is least, which small ways of a journal in the middle turn (7e-4 rad of 6.8).  Where
friction begins in the first step, its secant is beside the difference of the step: by 2e-7, 3e-8, 2e-9 m/s with steps
of 1e-4, 5e-5, 2.5e-5 s.  Derivatives of the start by the speed of a clamp have round-off of 2e-10 m/s a m/s, which over
a step is 6e-6 N a m/s of forces that hardly depend on it (5e-5 N a m/s).
"""

STRUCTURAL = {"A.radius", "servo.sample"}
"""Numbers that change the structure of the equations, or move instants."""


def numbers_of(part, prefix: str) -> Iterator[str]:
    """Names of the real numbers of a part and of the records in it, but for zeros."""
    for one in fields(part):
        value = getattr(part, one.name)
        if not one.init or one.name == "name":
            continue
        if isinstance(value, float) and value != 0.0 and str(one.type) in ("float", "float | None"):
            yield f"{prefix}.{one.name}"
        elif is_dataclass(value) and not isinstance(value, (fm.Part, type)):
            yield from numbers_of(value, f"{prefix}.{one.name}")


def errors(mechanism: fm.Mechanism, name: str) -> float:
    """Largest error of the derivative of any coordinate or joint force, over the largest of its kind."""
    held = ParameterModel("test", mechanism, [name])
    named = fm.compile(mechanism).names.signals
    signals = [s.name for s in named if s.units in KINDS and not s.name.endswith(DIRECTIONS)]
    found = derivatives("test", held, Span(STEP * STEPS, None, STEPS // 4, STEP, None), signals, every=False)
    least = np.inf
    for part in PARTS:
        h, expected = part * abs(held.values[0]), 0.0
        for place, weight in CENTRAL:
            changed = held.at([held.values[0] + place * h])
            sol = fm.simulate(changed, t_end=STEP * STEPS, save=list(found.times), step=STEP)
            expected = expected + weight / h * np.stack([np.asarray(sol[s]) for s in signals], axis=1)
        worst, units = 0.0, np.array(found.units)
        for unit in set(found.units):
            own = units == unit
            size = max(np.abs(expected[:, own]).max(), LEAST * KINDS[unit] / abs(held.values[0]))
            worst = max(worst, np.abs(found.slopes[:, 0, own] - expected[:, own]).max() / size)
        least = min(least, worst)
        if least < 1e-5:
            break
    return least


@pytest.fixture(autouse=True)
def sharp(monkeypatch):
    """Steps are solved to round-off, so that differences see the parameter alone."""
    monkeypatch.setattr(run, "NEWTON_TOLERANCE", 1e-13)


@pytest.mark.quick(3)
@pytest.mark.parametrize("kind", QUICK)
def test_derivatives_by_a_number_agree_with_differences(kind):
    mechanism, part = BUILT_IN[kind]
    name = QUICK[kind] or next(numbers_of(mechanism[part], part))
    assert errors(mechanism, name) < 1e-5


@pytest.mark.slow
@pytest.mark.parametrize("kind", [kind for kind in BUILT_IN if kind not in REFUSED])
def test_derivatives_by_all_numbers_agree_with_differences(kind):
    mechanism, part = BUILT_IN[kind]
    for name in numbers_of(mechanism[part], part):
        if name not in STRUCTURAL:
            assert errors(mechanism, name) < BOUNDS.get(kind, BOUND), name
