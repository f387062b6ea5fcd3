"""Mechanisms as functions of numbers, with each kind of part, for derivatives beside differences."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import flexmb as fm
from flexmb import couplings, drives, friction, loads
from flexmb.mechanisms import four_bar, nine_bar, slider_crank


@dataclass(frozen=True)
class Case:
    """A model, its parameters, signals, and arguments of the run."""

    model: Any
    parameters: dict[str, float]
    of: tuple[str, ...]
    run: dict[str, Any] = field(default_factory=dict)


def pendulum(length: float, mass: float, gravity: float) -> fm.Mechanism:
    rod = fm.RigidLink("rod", (0.0, 0.0), (length, 0.0), mass, mass * length**2 / 12.0)
    return fm.Mechanism("pendulum", [rod, fm.Revolute("O", fm.GROUND, rod, at=(0.0, 0.0))], (0.0, -gravity))


def damped(rate: float, damping: float, torque: float, inertia: float) -> fm.Mechanism:
    rod = fm.RigidLink("rod", (0.0, 0.0), (0.4, 0.0), 1.0, inertia)
    pin = fm.Revolute("O", fm.GROUND, rod, at=(0.0, 0.0))
    spring = fm.loads.TorsionSpring("spring", fm.GROUND, rod, stiffness=rate, damping=damping)
    push = fm.loads.Torque("push", rod, torque, history=drives.Harmonic(1.0, 7.0))
    return fm.Mechanism("damped", [rod, pin, spring, push], (0.0, -9.81))


def swing(length: float, section: float, young: float) -> fm.Mechanism:
    rod = fm.FlexibleLink(
        "rod", (0.0, 0.0), (length, 0.0), section=fm.Rectangle(section, 0.01), elements=4,
        material=fm.Material(young, 2700.0, 0.3), damping=1e-4,
    )
    return fm.Mechanism("swing", [rod, fm.Revolute("O", fm.GROUND, rod, at=(0.0, 0.0))], (0.0, -9.81))


def four(crank: float, coupler: float, speed: float) -> fm.Mechanism:
    A, B = (0.0, 0.0), (0.4, 0.0)
    a = fm.RigidLink("crank", A, (0.0, crank), 0.2, 1e-3)
    x = ((coupler**2 - 0.3**2 + (0.4**2 + crank**2)) / 2.0)  # of the circles about the crank's end and about B
    C = _meet((0.0, crank), coupler, B, 0.3)
    b = fm.RigidLink("coupler", (0.0, crank), C, 0.4, 4e-3)
    c = fm.RigidLink("rocker", B, C, 0.3, 2e-3)
    pins = [
        fm.Revolute("A", fm.GROUND, a, at=A), fm.Revolute("P", a, b, at=(0.0, crank)),
        fm.Revolute("C", b, c, at=C), fm.Revolute("B", fm.GROUND, c, at=B),
    ]
    return fm.Mechanism("four", [a, b, c, *pins, fm.Drive("motor", pins[0], fm.ConstantSpeed(speed))], (0.0, -9.81))


def _meet(first, r, second, s):
    (x, y), (u, v) = first, second
    d = math.hypot(u - x, v - y)
    along = (r * r - s * s + d * d) / (2.0 * d)
    up = math.sqrt(r * r - along * along)
    ex, ey = (u - x) / d, (v - y) / d
    return x + along * ex - up * ey, y + along * ey + up * ex


WORN = slider_crank(speed=100.0, clearance=1e-4)

CASES: dict[str, Case] = {
    "pendulum": Case(pendulum, {"length": 0.5, "mass": 1.3, "gravity": 9.81}, ("rod.theta", "rod.omega", "O.force"), {"t_end": 1.5}),
    "damped rod": Case(damped, {"rate": 40.0, "damping": 0.3, "torque": 2.0, "inertia": 0.02}, ("rod.theta", "O.force"), {"t_end": 1.0, "step": 1e-3}),
    "swinging beam": Case(swing, {"length": 0.6, "section": 0.012, "young": 7e10}, ("rod.end.x", "rod.end.vy", "O.fx"), {"t_end": 0.2, "step": 2e-4}),
    "four-bar": Case(four, {"crank": 0.1, "coupler": 0.35, "speed": 12.0}, ("rocker.theta", "B.force", "motor.torque"), {"t_end": 0.6, "step": 1e-3}),
    "slider-crank": Case(slider_crank(speed=100.0), {"rod.mass": 0.21, "slider.mass": 0.14, "motor.motion.speed": 100.0}, ("O.force", "motor.torque", "slider.ax"), {"t_end": 0.06}),
    "first impact": Case(WORN, {"B.clearance": 1e-4, "B.normal.restitution": 0.9, "rod.mass": 0.21}, ("slider.x", "slider.vx", "B.normal_force", "O.force"), {"t_end": 0.006}),
}
