"""Steps of differences: places far from the origin, small machines, frequencies after many cycles, radii, factors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import flexmb as fm
from flexmb.chaos import MechanismFlow, periodic_orbit
from flexmb.design import at_end, orbit_sensitivity, sensitivity, static_sensitivity
from flexmb.fields import field, record
from flexmb.program import structure

SPEED, END = 100.0, 0.017  # of the crank [rad/s], of its runs [s]


def crank(b: float, *, x: float = 0.0, size: float = 1.0) -> fm.Mechanism:
    """Slider-crank of 50 mm times `size`, whose slider starts b beside the crank's pin at x."""
    O, A, B = (x, 0.0), (x, 0.05 * size), (x + b, 0.0)
    inertia = 1e-4 * size**2
    first = fm.RigidLink("crank", O, A, mass=0.3, inertia=inertia)
    rod = fm.RigidLink("rod", A, B, mass=0.3, inertia=inertia)
    piston = fm.RigidBody("piston", at=B, mass=0.14, inertia=inertia)
    joints = [
        fm.Revolute("O", fm.GROUND, first, at=O),
        fm.Revolute("A", first, rod, at=A),
        fm.Revolute("B", rod, piston, at=B),
        fm.Prismatic("guide", fm.GROUND, piston, along=(1.0, 0.0)),
        fm.Drive("motor", joint="O", motion=fm.ConstantSpeed(SPEED)),
    ]
    return fm.Mechanism("slider-crank", [first, rod, piston, *joints])


def slope_of_piston(b: float, size: float = 1.0) -> float:
    """Derivative of the piston's place by b: l dl/db over the rod's part along the guide, with l dl/db = b."""
    y = 0.05 * size * math.sin(math.pi / 2.0 + SPEED * END)
    return b / math.sqrt(b**2 + (0.05 * size) ** 2 - y**2)


def derivative(model: Any, parameters: Any, of: str = "piston.x", end: float = END, **more: Any) -> float:
    found = sensitivity(model, parameters, of=[at_end(of)], t_end=end, save=2, **more)
    return float(found.measures.derivative.values[0, 0])


@pytest.mark.quick(2)
@pytest.mark.parametrize("x", [0.0, 10.0, 100.0, 1000.0, 1e6])
def test_place_of_a_pin_far_from_the_origin(x):
    found = derivative(lambda place: crank(place - x, x=x), {"place": x + 0.08})
    rel = max(2e-6, 2e-11 * x)  # coordinates have a round-off of 1e-16 of x, steps a millionth of the machine's size
    assert found == pytest.approx(slope_of_piston(0.08), rel=rel)


@pytest.mark.parametrize("size", [1.0, 0.1, 1e-2, 1e-3])
def test_misalignment_of_nothing_in_small_machines(size):
    found = derivative(lambda dx: crank(0.08 * size + dx, size=size), {"dx": 0.0})
    assert found == pytest.approx(slope_of_piston(0.08 * size, size), rel=1e-6)


@pytest.mark.parametrize("dx", [1e-7, 1e-9, 1e-12])
def test_misalignment_that_is_lost_in_round_off(dx):
    found = derivative(lambda dx: crank(0.08 + dx), {"dx": dx})
    assert found == pytest.approx(slope_of_piston(0.08), rel=1e-6)


@pytest.mark.quick(1)
@pytest.mark.parametrize("x", [0.0, 100.0, 1000.0])
def test_cantilever_far_from_the_origin(x):
    def cantilever(end: float) -> fm.Mechanism:
        steel, section = fm.Material(2e11, 7800.0, 0.3), fm.Rectangle(0.01, 0.01)
        beam = fm.FlexibleLink("beam", (x, 0.0), (end, 0.0), section=section, material=steel, elements=4)
        parts = [beam, fm.Fixed("wall", fm.GROUND, beam, at=(x, 0.0)), fm.Force("F", beam, (end, 0.0), (0.0, -0.1))]
        return fm.Mechanism("cantilever", parts, gravity=(0.0, 0.0))

    found = static_sensitivity(cantilever, {"end": x + 0.5}, of=["beam.end.y"], frequencies=1)
    sag, pitch = found.measures.derivative.values[:, 0]
    assert sag == pytest.approx(-0.1 * 0.5**2 / (2e11 * 0.01**4 / 12.0), rel=1e-5)  # of F l^3 / (3 E I)
    assert pitch == pytest.approx(-2.0 * found.measures.amount.values[1] / 0.5, rel=5e-4)  # of a multiple of 1 / l^2


# Loads, drives and laws of controllers with the phase w t, on a mass of 1 kg on a guide


@fm.drive_kernel
def swing(p, t):
    size, w = p
    return size * math.sin(w * t), size * w * math.cos(w * t), -size * w * w * math.sin(w * t)


@dataclass(frozen=True)
class Swing(fm.Motion):
    """Motion of a user."""

    size: float
    w: float
    kernel = swing


@fm.control_kernel
def shaker(p, t, u, x, dx, y):
    y[0] = math.sin(p[0] * t)


def shaken(w: float, kind: str) -> fm.Mechanism:
    body = fm.RigidBody("body", (0.0, 0.0), 1.0, 1.0)
    guide = fm.Prismatic("guide", fm.GROUND, body, at=(0.0, 0.0), along=(1.0, 0.0))
    history = {"harmonic": fm.drives.Harmonic(1.0, frequency=w / (2.0 * math.pi)), "own": Swing(1.0, w)}.get(kind)
    sample = 0.01 if kind == "sampled" else None
    force = fm.Force("F", body, (0.0, 0.0), (1.0, 0.0), **({"history": history} if history else {}))
    controls = [] if history else [fm.Control("shaker", ["body.x"], ["F"], shaker, numbers=(w,), sample=sample)]
    return fm.Mechanism("shaken", [body, guide, force, *controls], gravity=(0.0, 0.0))


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("kind", "w", "end"),
    [
        ("harmonic", 300.0, 40.0),
        ("own", 300.0, 40.0),
        ("law", 300.0, 40.0),
        pytest.param("harmonic", 5000.0, 20.0, marks=pytest.mark.slow),
    ],
)
def test_frequency_of_a_load_after_many_cycles(kind, w, end):
    found = derivative(lambda w: shaken(w, kind), {"w": w}, "body.ax", end)
    assert found == pytest.approx(end * math.cos(w * end), rel=2e-5)


@pytest.mark.slow
def test_frequency_of_a_drive_after_many_cycles():
    def driven(f: float) -> fm.Mechanism:
        body = fm.RigidBody("body", (0.0, 0.0), 1.0, 1.0)
        guide = fm.Prismatic("guide", fm.GROUND, body, at=(0.0, 0.0), along=(1.0, 0.0))
        drive = fm.Drive("drive", joint="guide", motion=fm.drives.Harmonic(0.01, frequency=f))
        return fm.Mechanism("driven", [body, guide, drive], gravity=(0.0, 0.0))

    f, end, turn = 50.0, 4.003, 2.0 * math.pi
    phase = turn * f * end
    speed = 0.01 * turn * (math.cos(phase) - phase * math.sin(phase))  # of 0.01 turn f cos(turn f t), by f
    found = sensitivity(driven, {"f": f}, of=[at_end("body.x"), at_end("body.vx")], t_end=end, save=2)
    expected = [0.01 * turn * end * math.cos(phase), speed]
    assert found.measures.derivative.values.ravel() == pytest.approx(expected, rel=1e-6)


def test_frequency_of_a_sampled_law_after_many_cycles():
    w, end = 3000.0, 2.0
    held = 0.01 * np.arange(200)
    found = derivative(lambda w: shaken(w, "sampled"), {"w": w}, "body.vx", end)
    assert found == pytest.approx(0.01 * float((held * np.cos(w * held)).sum()), rel=1e-5)


# Radii and factors, which moments and reported forces follow

WHEELS = [fm.RigidBody("a", (0.0, 0.0), 0.2, 1e-4), fm.RigidBody("b", (0.3, 0.0), 0.8, 1e-3)]
AXLES = [fm.Revolute("O", fm.GROUND, WHEELS[0], at=(0.0, 0.0)), fm.Revolute("Q", fm.GROUND, WHEELS[1], at=(0.3, 0.0))]
TORQUE = fm.Torque("T", WHEELS[0], 0.1)


def belt(r: float = 0.02) -> fm.Mechanism:
    drums = fm.couplings.Belt("belt", *WHEELS, radii=(r, 0.05))
    return fm.Mechanism("belt", [*WHEELS, *AXLES, TORQUE, drums])


def coupled(r: float = 2.0) -> fm.Mechanism:
    coupling = fm.couplings.Coupling("gears", factors={"O": r, "Q": 1.0})
    return fm.Mechanism("coupled", [*WHEELS, *AXLES, TORQUE, coupling])


def rack(r: float = 0.02) -> fm.Mechanism:
    bar = fm.RigidBody("bar", (0.0, -r), 1.0, 1.0)
    teeth = fm.couplings.Rack("rack", WHEELS[0], bar, at=(0.0, -r))
    return fm.Mechanism("rack", [WHEELS[0], bar, AXLES[0], teeth, TORQUE])


def pin(r: float = 0.02) -> fm.Mechanism:
    rod = fm.RigidLink("rod", (0.0, 0.0), (0.5, 0.0), mass=1.0, inertia=0.02)
    law = fm.friction.SmoothCoulomb(0.2, 1e-2)
    return fm.Mechanism("pin", [rod, fm.Revolute("O", fm.GROUND, rod, at=(0.0, 0.0), friction=law, radius=r)])


@pytest.mark.parametrize(
    ("model", "of"),
    [
        (belt, ["b.omega", "belt.force", "belt.first_torque", "belt.second_torque"]),
        (coupled, ["b.omega", "gears.O_torque", "gears.O_power"]),
        (rack, ["bar.vx", "rack.force", "rack.torque", "rack.power"]),
        (pin, ["rod.theta", "O.friction_torque"]),
    ],
)
def test_radii_and_factors_agree_with_differences_of_runs(model, of):
    r = model.__defaults__[0]
    found = sensitivity(model, ["r"], of=[at_end(one) for one in of], t_end=0.1, step=fm.Adaptive(rtol=1e-9))
    h = 1e-4 * r
    runs = [fm.simulate(model(r + side * h), t_end=0.1, step=fm.Adaptive(rtol=1e-9)) for side in (1.0, -1.0)]
    for k, name in enumerate(of):
        more, less = (float(sol.array(name)[-1]) for sol in runs)
        slope = (more - less) / (2.0 * h)
        assert float(found.measures.derivative.values[k, 0]) == pytest.approx(slope, rel=1e-4, abs=1e-6 * abs(more) / r)


def test_structures_that_are_not_remembered_are_compared_by_content():
    def forgotten(b: float) -> fm.Mechanism:
        structure._LATEST.clear()
        return crank(b)

    assert derivative(forgotten, {"b": 0.08}) == pytest.approx(slope_of_piston(0.08), rel=1e-6)


# Orbit of a small machine: a mass on a guide, held by a spring to a slider that swings about a mean of 0


@fm.drive_kernel
def about(p, t):
    return p[0] + 2e-5 * math.sin(100.0 * t), 2e-3 * math.cos(100.0 * t), -0.2 * math.sin(100.0 * t)


@record
class About(fm.Motion):
    """Harmonic motion of 0.02 mm at 100 rad/s about a mean."""

    mean: float = field("mean", "m", default=0.0)

    kernel = about

    @property
    def period(self) -> float:
        return math.pi / 50.0


def small_machine(mean: float = 0.0) -> fm.Mechanism:
    slider, mass = fm.RigidBody("slider", (0.0, 0.0), 1e-3, 1e-12), fm.RigidBody("mass", (5e-5, 1e-4), 1e-3, 1e-12)
    parts = [
        fm.Prismatic("rail", fm.GROUND, slider, at=(0.0, 0.0), along=(1.0, 0.0)),
        fm.Prismatic("guide", fm.GROUND, mass, at=(5e-5, 1e-4), along=(0.0, 1.0)),
        fm.Drive("drive", joint="rail", motion=About(mean)),
        fm.SpringDamper("spring", slider, mass, at=(0.0, 0.0), to=(5e-5, 1e-4), stiffness=5.0, damping=0.05),
    ]
    return fm.Mechanism("small machine", [slider, mass, *parts], gravity=(0.0, 0.0))


@pytest.mark.slow
def test_orbit_of_a_small_machine_by_a_length_of_nothing():
    def orbit(mean: float) -> Any:
        flow = MechanismFlow(small_machine(mean), step=fm.Adaptive(rtol=1e-8), period=math.pi / 50.0)
        return periodic_orbit(flow)

    found = orbit_sensitivity(orbit(0.0), ["drive.motion.mean"], of=["mass.y"])
    place = list(found.dataset.entry.values).index("mass.y")
    more, less = (orbit(side * 1e-7).state[place] for side in (1.0, -1.0))
    assert float(found.dataset["state"][0, place]) == pytest.approx((more - less) / 2e-7, rel=1e-4)
    assert "Doubtful" not in found.status
