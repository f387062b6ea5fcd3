"""Hoist: a motor with a given torque winds a load up with a cable on a drum.

T - r S = J a/r and S - m g = m a: a = (T - m g r) r/(J + m r^2); the load swings on the cable about that motion with
w^2 = K (1/m + r^2/J).  Source: J. L. Meriam, L. G. Kraige, Engineering Mechanics: Dynamics, section 6/4.
"""

import math

import numpy as np
import pytest

import flexmb as fm

R, J, M, G = 0.12, 0.05, 15.0, 9.81
K, SLOW = 4e6, 3e3  # cable [N/m], [N s/m]


def hoist(torque, height=-3.0, *parts, inertia=J):
    drum = fm.RigidBody("drum", at=(0.0, 0.0), mass=4.0, inertia=inertia)
    load = fm.bodies.PointMass("load", at=(R, height), mass=M)
    law = fm.KelvinVoigt(K, SLOW, ramp=1e-6)
    slack = M * G / K  # the cable begins as long as it is under the weight
    rope = fm.couplings.Cable(
        "rope", drum, load, at=(0.0, 0.0), to=(R, height), free_length=-height - slack, normal=law, radii=(R, 0.0)
    )
    axle = fm.Revolute("O", fm.GROUND, drum, at=(0.0, 0.0))
    pull = [] if torque is None else [fm.Torque("motor", drum, torque)]
    return fm.Mechanism("hoist", [drum, load, axle, rope, *pull, *parts], gravity=(0.0, -G))


@pytest.mark.parametrize("torque", [M * G * R + 4.0, 30.0, 10.0])
def test_a_torque_accelerates_drum_and_load(torque):
    a = (torque - M * G * R) * R / (J + M * R**2)
    sol = fm.simulate(hoist(torque), t_end=0.6, save=601).require()
    late = sol.time > 0.1
    assert sol["rope.normal_force"].values[late] == pytest.approx(M * (G + a), rel=1e-4)
    travel = sol["load.y"].values + 3.0
    assert travel[-1] == pytest.approx(0.5 * a * 0.6**2, abs=2e-4 * abs(a) + abs(M * a / K))
    assert sol["drum.omega"].values[-1] * R == pytest.approx(a * 0.6, rel=1e-3)
    assert sol["O.fy"].values[late] == pytest.approx(M * (G + a) + 4.0 * G, rel=1e-4)  # the axle carries all


def test_the_load_hangs_beside_the_drum_and_stays_there():
    sol = fm.simulate(hoist(M * G * R), t_end=0.5).require()
    assert np.abs(sol["load.x"].values - R).max() < 1e-6
    assert np.abs(sol["load.y"].values + 3.0).max() < 1e-6


def test_the_winch_that_winds_steadily_gives_the_torque_of_the_weight():
    drive = fm.Drive("winch", joint="O", motion=fm.drives.CycloidalRamp(5.0, 0.3))
    sol = fm.simulate(hoist(None, -3.0, drive), t_end=1.0).require()
    late = sol.time > 0.6
    assert sol["winch.torque"].values[late] == pytest.approx(M * G * R, rel=1e-3)
    assert sol["load.vy"].values[late] == pytest.approx(5.0 * R, rel=1e-3)
    work = float(sol["energy.drive_work"][-1])
    lifted = M * G * (float(sol["load.y"][-1]) + 3.0)
    kinetic = 0.5 * (M * R**2 + J) * 25.0
    assert work == pytest.approx(lifted + kinetic, rel=2e-3)


def test_the_cable_swings_with_the_frequencies_of_drum_and_load():
    """Drum on a spring kt and load: two masses on two springs, and the load swings as a pendulum."""
    kt = 500.0
    spring = fm.TorsionSpring("brake", fm.GROUND, hoist(None)["drum"], stiffness=kt)
    mech = hoist(M * G * R, -3.0, spring)
    found = fm.modes(mech, count=3, at=fm.static_equilibrium(mech)).frequencies
    stiffness = np.array([[kt + K * R**2, -K * R], [-K * R, K]]) / np.sqrt(np.outer((J, M), (J, M)))
    exact = np.sqrt(np.linalg.eigvalsh(stiffness)) / (2.0 * math.pi)
    assert found[1:] == pytest.approx(exact, rel=1e-5)
    assert found[0] == pytest.approx(math.sqrt(G / 3.0) / (2.0 * math.pi), rel=1e-3)
