"""Main signals of a run are chosen by the size of their peaks."""

import pytest

import flexmb as fm
from flexmb.results.solution import MOST_OF_A_KIND
from flexmb.results.status import main_signals

LAW = fm.KelvinVoigt(stiffness=1e5, damping=10.0, ramp=1e-5)


def balls(count):
    """Balls of growing mass that fall on a floor; the last one starts out of its reach."""
    parts = []
    floor = fm.cams.Outline(((0.0, -1.0), (count + 1.0, -1.0), (count + 1.0, 0.0), (0.0, 0.0)))
    for k in range(1, count + 1):
        height = 10.0 if k == count else 0.11
        ball = fm.RigidBody(f"ball{k}", at=(float(k), height), mass=float(k), inertia=1e-3)
        round_ = fm.cams.CircularCurve((float(k), height), 0.1)
        parts += [ball, fm.cams.OutlineContact(f"floor{k}", fm.GROUND, floor, ball, round_, normal=LAW)]
    return fm.Mechanism("balls", parts, gravity=(0.0, -9.81))


@pytest.fixture(scope="module")
def sol():
    return fm.simulate(balls(8), t_end=0.1, save=100)


def test_contacts_that_never_close_are_left_out_and_the_largest_stay(sol):
    shown = [name for name in main_signals(sol) if name.endswith(".normal_force")]
    assert sol.peak("floor8.normal_force").value == 0.0
    assert shown == [f"floor{k}.normal_force" for k in range(2, 2 + MOST_OF_A_KIND)]
    peaks = [sol.peak(f"floor{k}.normal_force").value for k in range(1, 8)]
    assert peaks == sorted(peaks)
    assert f"largest {shown[0]}" in repr(sol)


def test_round_off_is_not_shown():
    """A rod that turns evenly about its centre of mass needs no torque and has no stress by bending."""
    rod = fm.RigidLink("rod", (-0.5, 0.0), (0.5, 0.0), mass=1.0, inertia=0.1)
    motor = fm.Drive("motor", joint="O", motion=fm.ConstantSpeed(10.0))
    mech = fm.Mechanism("even", [rod, fm.Revolute("O", fm.GROUND, rod, at=(0.0, 0.0)), motor])
    assert "motor.torque" not in main_signals(fm.simulate(mech, periods=1, save=50))


def test_stresses_of_bodies_that_deform_are_shown():
    """A plate pendulum under its weight; of the same plate far stiffer only the stress differs from 0, too."""
    steel = fm.Material(young=2.1e11, density=7850.0, poisson=0.3)
    mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.02, hole=0.01, width=0.02, size=0.005)
    rod = fm.PlaneBody("rod", mesh, start=(0.0, 0.0), end=(0.12, 0.0), thickness=0.01, material=steel)
    arm = fm.Reduced(rod, modes=3)
    pin = fm.Revolute("O", fm.GROUND, arm, at=(0.0, 0.0))
    sol = fm.simulate(fm.Mechanism("plate", [arm, pin], gravity=(0.0, -9.81)), t_end=1e-3, save=10)
    assert "rod.von_mises" in main_signals(sol)
