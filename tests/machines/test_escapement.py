"""Clock with a recoil escapement: a toothed wheel under a steady torque keeps a pendulum with two pins swinging.

Each swing lets one tooth pass, so the wheel gives torque x pitch per swing, which air, contacts and the swing's growth
take.  A recoil escapement gains: pins press the pendulum back, the more the heavier the weight.
Source: A. L. Rawlings, The Science of Clocks and Watches, 3rd ed., BHI 1993, ch. 4 and 5 (with Airy's theorem).
"""

import math

import numpy as np
import pytest

import flexmb as fm

TEETH, TIP, ROOT, PIN = 12, 0.05, 0.040, 0.0015
PITCH = 2.0 * math.pi / TEETH
SPAN = 1.25 * PITCH  # each pin stands two and a half teeth from the other one
PIVOT = (0.0, TIP / math.cos(SPAN))  # pins move along the radii
MASS, LENGTH, INERTIA, AIR, G = 0.5, 0.25, 1e-4, 1e-3, 9.81
LAWS = {
    "spring and damper": fm.KelvinVoigt(2e5, 20.0, ramp=1e-6),
    "damper from the onset": fm.KelvinVoigt(2e5, 20.0),
    "exact restitution": fm.contact.ExactRestitution(stiffness=1e8, restitution=0.3),
}


def teeth():
    points = []
    for k in range(TEETH):
        a, b = 1.4 + PITCH * k, 1.4 + PITCH * (k + 0.75)
        points += [(TIP * math.cos(a), TIP * math.sin(a)), (ROOT * math.cos(b), ROOT * math.sin(b))]
    return fm.cams.Outline(points)


def clock(torque, law):
    wheel = fm.RigidBody("wheel", at=(0.0, 0.0), mass=0.05, inertia=2e-6)
    bob = fm.RigidBody("pendulum", at=(0.0, PIVOT[1] - LENGTH), mass=MASS, inertia=INERTIA, velocity=(LENGTH, 0.0, 1.0))
    outline, r = teeth(), TIP - 1e-3 + PIN
    pins = {"left": (-r * math.sin(SPAN), r * math.cos(SPAN)), "right": (r * math.sin(SPAN), r * math.cos(SPAN))}
    pallets = [
        fm.cams.OutlineContact(name, wheel, outline, bob, fm.cams.CircularCurve(place, PIN), normal=law)
        for name, place in pins.items()
    ]
    return fm.Mechanism("clock", [
        wheel, bob, *pallets,
        fm.Revolute("O", fm.GROUND, wheel, at=(0.0, 0.0)), fm.Revolute("P", fm.GROUND, bob, at=PIVOT),
        fm.Torque("weight", wheel, -torque),
        fm.TorsionSpring("air", fm.GROUND, bob, stiffness=0.0, damping=AIR),
    ], gravity=(0.0, -G))  # fmt: skip


def swings(sol):
    """Instants at which the pendulum passes its lowest place to the right, and the wheel's angle there."""
    theta, time = sol["pendulum.theta"].values, sol.time
    ups = np.flatnonzero((theta[:-1] < 0.0) & (theta[1:] >= 0.0))
    part = -theta[ups] / (theta[ups + 1] - theta[ups])
    wheel = sol["wheel.theta"].values
    return ups, time[ups] + part * (time[ups + 1] - time[ups]), wheel[ups] + part * (wheel[ups + 1] - wheel[ups])


def run(torque, law, t_end=8.0):
    return fm.simulate(clock(torque, LAWS[law]), t_end=t_end, save=int(2000 * t_end)).require()


@pytest.mark.quick(1)
@pytest.mark.parametrize("law", list(LAWS))
def test_each_swing_lets_one_tooth_pass(law):
    _, times, wheel = swings(run(0.015, law))
    passed = -np.diff(wheel[2:]) / PITCH
    assert len(times) >= 7
    assert passed.round() == pytest.approx(1.0)
    assert -(wheel[-1] - wheel[2]) / PITCH == pytest.approx(len(wheel) - 3, abs=0.3)  # a pallet has play


@pytest.mark.quick(1)
@pytest.mark.parametrize("law", list(LAWS))
def test_the_weight_pays_for_air_and_impacts(law):
    """The work of the weight by the turn of the wheel, that of the air by the speeds, the energy by the swing."""
    sol = run(0.015, law)
    time, omega = sol.time, sol["pendulum.omega"].values
    work = -0.015 * (sol["wheel.theta"].values[-1] - sol["wheel.theta"].values[0])
    air = AIR * float(np.trapezoid(omega**2, time))
    height = -LENGTH * (np.cos(sol["pendulum.theta"].values) - 1.0)
    energy = 0.5 * (INERTIA + MASS * LENGTH**2) * omega**2 + MASS * G * height
    energy += 0.5 * 2e-6 * sol["wheel.omega"].values ** 2
    contacts = float(sol["energy.dissipated_contact"][-1])
    assert contacts > 0.0
    assert work == pytest.approx(air + contacts + energy[-1] - energy[0], rel=1e-3)
    assert float(sol["energy.dissipated_damping"][-1]) == pytest.approx(air, rel=1e-4)


@pytest.mark.slow
def test_a_heavier_weight_makes_the_clock_gain():
    free = 2.0 * math.pi * math.sqrt((INERTIA + MASS * LENGTH**2) / (MASS * G * LENGTH))
    found = []
    for torque in (0.01, 0.02, 0.03):
        sol = run(torque, "spring and damper")
        _, times, _ = swings(sol)
        period = (times[-1] - times[2]) / (len(times) - 3)
        swing = np.abs(sol["pendulum.theta"].values[sol.time > times[2]]).max()
        found.append(period / (free * (1.0 + swing**2 / 16.0)))
    assert 1.0 > found[0] > found[1] > found[2] > 0.7
