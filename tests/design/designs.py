"""Mechanisms whose numbers are varied: smooth ones, with impacts and friction, rigid and flexible."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import flexmb as fm
from flexmb.contact import ExactRestitution
from flexmb.mechanisms import slider_crank
from flexmb.parts.joints.stop import Stop

CENTRAL = (-2.0, 1.0 / 12.0), (-1.0, -8.0 / 12.0), (1.0, 8.0 / 12.0), (2.0, -1.0 / 12.0)
"""Places and weights of differences of fourth order."""


class Case(NamedTuple):
    """A model, its parameters, the signals that are compared, the end of the run [s], its step."""

    model: Any
    parameters: dict[str, float]
    of: tuple[str, ...]
    end: float
    step: Any = fm.Adaptive(rtol=1e-9)


def ball(h0: float, g: float, e: float, k: float = 1e9) -> fm.Mechanism:
    """A ball of 1 kg above a table; heights count from its start."""
    body = fm.RigidBody("ball", (0.0, 0.0), 1.0, 1.0)
    guide = fm.Prismatic("guide", fm.GROUND, body, at=(0.0, 0.0), along=(0.0, 1.0))
    table = Stop("table", guide, below=-h0, normal=ExactRestitution(stiffness=k, restitution=e))
    return fm.Mechanism("ball", [body, guide, table], (0.0, -g))


def pendulum(length: float, mass: float, gravity: float) -> fm.Mechanism:
    rod = fm.RigidLink("rod", (0.0, 0.0), (length, 0.0), mass, mass * length**2 / 12.0)
    return fm.Mechanism("pendulum", [rod, fm.Revolute("O", fm.GROUND, rod, at=(0.0, 0.0))], (0.0, -gravity))


def sprung(rate: float, damping: float, torque: float, inertia: float) -> fm.Mechanism:
    rod = fm.RigidLink("rod", (0.0, 0.0), (0.4, 0.0), 1.0, inertia)
    spring = fm.loads.TorsionSpring("spring", fm.GROUND, rod, stiffness=rate, damping=damping)
    push = fm.loads.Torque("push", rod, torque, history=fm.drives.Harmonic(1.0, 7.0))
    return fm.Mechanism("sprung", [rod, fm.Revolute("O", fm.GROUND, rod, at=(0.0, 0.0)), spring, push], (0.0, -9.81))


def beam(length: float, height: float, young: float = 70e9) -> fm.Mechanism:
    section = fm.Rectangle(0.01, height)
    stuff = fm.Material(young, 2700.0, 0.3)
    end = (length, 0.0)
    rod = fm.FlexibleLink("rod", (0.0, 0.0), end, section=section, material=stuff, elements=4, damping=1e-4)
    return fm.Mechanism("beam", [rod, fm.Revolute("O", fm.GROUND, rod, at=(0.0, 0.0))], (0.0, -9.81))


def four_bar(crank: float, coupler: float, speed: float) -> fm.Mechanism:
    """A crank-rocker that starts with its crank upright, bars of 0.4 m (frame) and 0.3 m (rocker)."""
    pin, frame, rocker = (0.0, crank), 0.4, 0.3
    way = math.hypot(frame, crank)
    along = (coupler**2 - rocker**2 + way**2) / (2.0 * way)
    up, ex, ey = math.sqrt(coupler**2 - along**2), frame / way, -crank / way
    tip = (along * ex - up * ey, crank + along * ey + up * ex)
    bars = [
        fm.RigidLink("crank", (0.0, 0.0), pin, 0.2, 1e-3),
        fm.RigidLink("coupler", pin, tip, 0.4, 4e-3),
        fm.RigidLink("rocker", (frame, 0.0), tip, 0.3, 2e-3),
    ]
    first = fm.Revolute("A", fm.GROUND, bars[0], at=(0.0, 0.0))
    pins = [
        fm.Revolute("P", bars[0], bars[1], at=pin),
        fm.Revolute("C", bars[1], bars[2], at=tip),
        fm.Revolute("B", fm.GROUND, bars[2], at=(frame, 0.0)),
    ]
    motor = fm.Drive("motor", first, fm.ConstantSpeed(speed))
    return fm.Mechanism("four-bar", [*bars, first, *pins, motor], (0.0, -9.81))


def plate(young: float, density: float, thickness: float) -> fm.Mechanism:
    mesh = fm.meshes.rectangle(0.3, 0.1, 2, 1, "tri6")
    stuff = fm.Material(young, density)
    body = fm.PlaneBody("plate", mesh, thickness=thickness, material=stuff, pins=("left", "right"), damping=2e-4)
    return fm.Mechanism("plate", [body, fm.Revolute("O", fm.GROUND, body, at=(0.0, 0.05))], (0.0, -9.81))


def rubbing(mu: float, rate: float) -> fm.Mechanism:
    """A slider that a spring pulls along a rough guide."""
    body = fm.RigidBody("slider", (0.1, 0.0), 1.0, 1.0)
    law = fm.friction.SmoothCoulomb(mu, v0=0.05)
    guide = fm.Prismatic("guide", fm.GROUND, body, at=(0.1, 0.0), along=(1.0, 0.0), friction=law, length=0.3)
    ends = {"at": (-0.3, 0.0), "to": (0.1, 0.0)}
    spring = fm.loads.SpringDamper("spring", fm.GROUND, body, **ends, stiffness=rate, free_length=0.2)
    return fm.Mechanism("rubbing", [body, guide, spring], (0.0, -9.81))


def worn(**more: Any) -> fm.Mechanism:
    return slider_crank(speed=100.0, clearance=1e-4, **more)


SMOOTH = {
    "pendulum": Case(
        pendulum, {"length": 0.5, "mass": 1.3, "gravity": 9.81}, ("rod.theta", "rod.omega", "O.force"), 0.8
    ),
    "sprung": Case(
        sprung,
        {"rate": 40.0, "damping": 0.3, "torque": 2.0, "inertia": 0.02},
        ("rod.theta", "O.force", "energy.kinetic"),
        1.0,
        5e-4,
    ),
    "beam": Case(beam, {"length": 0.6, "height": 0.012}, ("rod.end.y", "rod.end.vy", "O.fy"), 0.2, 1e-4),
    "four-bar": Case(
        four_bar, {"crank": 0.1, "coupler": 0.35, "speed": 12.0}, ("rocker.theta", "B.force", "motor.torque"), 0.6, 5e-4
    ),
    "slider-crank": Case(
        slider_crank(speed=100.0),
        {"rod.mass": 0.21, "slider.mass": 0.14, "motor.motion.speed": 100.0},
        ("O.force", "motor.torque"),
        0.03,
    ),
    "rubbing": Case(rubbing, {"mu": 0.2, "rate": 200.0}, ("slider.x", "slider.vx"), 0.5, 1e-4),
    "plate": Case(plate, {"young": 1e7, "density": 2000.0, "thickness": 0.01}, ("plate.theta", "O.force"), 0.1, 1e-4),
}

WITH_IMPACTS = {
    "ball": Case(ball, {"h0": 50.0, "g": 9.8, "e": 0.8}, ("ball.y", "ball.vy"), 5.0, fm.Adaptive(rtol=1e-9, max=0.05)),
    "worn": Case(worn(), {"B.clearance": 1e-4, "rod.mass": 0.21}, ("slider.x", "slider.vx", "O.force"), 0.006),
    "worn, friction": Case(
        worn(friction="coulomb"),
        {"B.clearance": 1e-4, "B.friction.coefficient": 0.03},
        ("slider.x", "slider.vx"),
        0.004,
        fm.Adaptive(rtol=1e-11),
    ),
    "worn, flexible": Case(
        worn(flexible=True, elements=2), {"B.clearance": 1e-4, "slider.mass": 0.14}, ("slider.x", "slider.vx"), 0.004
    ),
}
