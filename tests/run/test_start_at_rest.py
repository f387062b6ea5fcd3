"""Runs that begin in an equilibrium stay there, at rest or in steady rotation."""

import numpy as np
import pytest
from cases import slow_where

import flexmb as fm
from flexmb.errors import InputError

STEEL = fm.Material(young=2e11, density=7850.0, poisson=0.3)
DOWN = (0.0, -9.81)
STEPS = [None, 1e-3]


def beam(name="beam"):
    section = fm.Rectangle(width=0.02, height=0.004)
    return fm.FlexibleLink(name, (0.0, 0.0), (0.8, 0.0), section=section, material=STEEL, elements=6)


def hanging(*more, body=None):
    body = body or beam()
    return fm.Mechanism("hanging", [body, fm.Fixed("foot", fm.GROUND, body, at=(0.0, 0.0)), *more], gravity=DOWN)


def swing(sol, name):
    return float(np.ptp(sol.array(name)))


@pytest.mark.parametrize("step", STEPS)
def test_a_beam_under_its_weight_stays_at_rest(step):
    """It sagged 6.0 mm and swung about that from the reference configuration; joints carry the weight at once."""
    mech = hanging()
    sol = fm.simulate(mech, t_end=0.2, step=step, start="equilibrium")
    assert sol.ok
    at = fm.static_equilibrium(mech)
    assert sol["beam.end.y"][0] == at["beam.end.y"] < -5e-3
    assert swing(sol, "beam.end.y") < 1e-13
    weight = 7850.0 * 0.02 * 0.004 * 0.8 * 9.81
    np.testing.assert_allclose(sol["foot.fy"], weight, rtol=1e-6)
    np.testing.assert_allclose(sol["energy.strain"], sol["energy.strain"][0], rtol=1e-9)
    assert np.abs(sol["energy.kinetic"]).max() < 1e-15 * sol["energy.strain"][0]
    assert np.abs(sol["energy.residual"]).max() < 1e-9 * sol["energy.strain"][0]


def plate():
    mesh = fm.meshes.link_with_eyes(0.4, 0.05, 0.02, 0.03, size=0.012)
    return fm.PlaneBody("beam", mesh, start=(0.0, 0.0), end=(0.4, 0.0), thickness=0.002, material=STEEL)


def hung_block(law):
    block = fm.RigidBody("beam", (0.0, -1.0), mass=10.0, inertia=1.0)
    guide = fm.Prismatic("guide", fm.GROUND, block, along=(0.0, 1.0))
    rope = fm.couplings.Cable("rope", fm.GROUND, block, (0.0, 0.0), (0.0, -1.0), normal=law)
    return fm.Mechanism("block", [block, guide, rope], gravity=DOWN)


def sprung():
    block = fm.RigidBody("beam", (0.0, -1.0), mass=10.0, inertia=1.0)
    guide = fm.Prismatic("guide", fm.GROUND, block, along=(0.0, 1.0))
    spring = fm.SpringDamper("k", fm.GROUND, block, (0.0, 0.0), (0.0, -1.0), stiffness=3e3, damping=1.0)
    stop = fm.Stop("stop", "guide", above=0.0, normal=fm.contact.Hertz(stiffness=1e8))
    lift = fm.Force("lift", block, (0.0, -1.0), (0.0, 150.0))
    return fm.Mechanism("block", [block, guide, spring, stop, lift], gravity=DOWN)


CASES = {
    "mesh": lambda: hanging(body=plate()),
    "reduced": lambda: hanging(body=fm.Reduced(beam(), modes=3)),
    "rope": lambda: hung_block(fm.KelvinVoigt(5e4, 20.0)),
    "hunt-crossley": lambda: hung_block(fm.contact.HuntCrossley(5e6, restitution=0.95)),
    "stop and spring": sprung,
}


@pytest.mark.quick(4)
@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("case", slow_where(lambda n: n == "mesh", CASES))
def test_meshes_ropes_stops_and_springs_stay_at_rest(case, step):
    mech = CASES[case]()
    at = fm.static_equilibrium(mech)
    sol = fm.simulate(mech, t_end=0.05, step=step, start=at)
    assert sol.ok, sol.status
    for name in at.names:
        assert swing(sol, name) < 1e-12
        assert sol.array(name)[0] == at[name]
    contacts = [name for name in sol.names if name.endswith(".normal_force")]
    for name in contacts:
        assert sol[name].min() > 0.0
        assert (sol[name.replace("normal_force", "mode")] == 2).all()
    assert np.abs(sol["energy.residual"]).max() < 1e-10


def test_a_journal_in_its_bearing_stays_at_rest():
    body = fm.RigidBody("pan", (0.0, 0.0), mass=2.0, inertia=1.0)
    play = fm.RevoluteClearance(
        "pin", fm.GROUND, body, at=(0.0, 0.0), clearance=1e-3, bearing_radius=0.01, normal=fm.KelvinVoigt(1e6, 10.0)
    )
    spring = fm.TorsionSpring("turn", fm.GROUND, body, stiffness=9.0)
    sol = fm.simulate(fm.Mechanism("pan", [body, play, spring], gravity=DOWN), t_end=0.1, start="equilibrium")
    assert sol.ok, sol.status
    np.testing.assert_allclose(sol["pin.normal_force"], 2.0 * 9.81, rtol=1e-9)


def test_a_restart_goes_on_from_a_run_that_began_at_rest():
    mech = hanging()
    at = fm.static_equilibrium(mech)
    first = fm.simulate(mech, t_end=0.05, start=at, step=1e-3)
    second = fm.simulate(mech, t_end=0.1, restart=first.restart, step=1e-3)
    whole = fm.simulate(mech, t_end=0.1, start=at, step=1e-3)
    assert second["beam.end.y"][-1] == whole["beam.end.y"][-1]
    assert swing(second, "beam.end.y") < 1e-13


SPEED = 40.0


def rotor(speed=SPEED):
    arm = beam()
    hub = fm.Revolute("hub", fm.GROUND, arm, at=(0.0, 0.0))
    return fm.Mechanism("rotor", [arm, hub, fm.Drive("motor", "hub", fm.ConstantSpeed(speed))])


@pytest.mark.parametrize("step", [None, 1e-4])
def test_a_rotor_begins_stretched(step):
    """Without damping it would ring in its axial vibrations; the pull at the hub is m omega^2 L/2 of the long beam."""
    sol = fm.simulate(rotor(), t_end=0.05, step=step, start=fm.static_equilibrium(rotor(), spin=SPEED))
    assert sol.ok, sol.status
    np.testing.assert_allclose(sol["energy.strain"], sol["energy.strain"][0], rtol=1e-5)
    mass = 7850.0 * 0.02 * 0.004 * 0.8
    np.testing.assert_allclose(np.hypot(sol["hub.fx"], sol["hub.fy"]), mass * SPEED**2 * 0.4, rtol=1e-4)
    assert float(sol["beam.end.theta"][-1]) == pytest.approx(SPEED * 0.05, rel=1e-5)


def test_a_drive_of_another_speed_is_refused():
    still = fm.static_equilibrium(rotor(), spin=SPEED)
    with pytest.raises(InputError, match=r"the equilibrium given is none|turns at 40 rad/s"):
        fm.simulate(rotor(speed=30.0), t_end=0.01, start=still)


def test_what_start_may_be():
    mech = hanging()
    with pytest.raises(InputError, match=r"start is 3; it must be 'equilibrium'"):
        fm.simulate(mech, t_end=0.1, start=3)
    with pytest.raises(InputError, match="start goes with neither restart"):
        fm.simulate(mech, t_end=0.1, start="equilibrium", restart=fm.simulate(mech, t_end=1e-3).restart)
    other = fm.static_equilibrium(hanging(body=beam("other")))
    with pytest.raises(InputError, match="has a coordinate 'other"):
        fm.simulate(mech, t_end=0.1, start=other)


def test_an_unstable_equilibrium_is_no_start_unless_it_is_given():
    """A pendulum upside down on a spring of 5 N m/rad, less than m g l = 9.81 N m."""
    rod = fm.RigidLink("rod", (0.0, 0.0), (0.0, 2.0), mass=1.0, inertia=0.1)
    pin = fm.Revolute("pin", fm.GROUND, rod, at=(0.0, 0.0))
    spring = fm.TorsionSpring("spring", fm.GROUND, rod, stiffness=5.0)
    mech = fm.Mechanism("upside down", [rod, pin, spring], gravity=DOWN)
    with pytest.raises(InputError, match="'upside down': start is 'equilibrium', but the equilibrium is unstable"):
        fm.simulate(mech, t_end=0.1, start="equilibrium")
    at = fm.static_equilibrium(mech)
    assert at.stable is False
    assert fm.simulate(mech, t_end=0.1, start=at).ok
