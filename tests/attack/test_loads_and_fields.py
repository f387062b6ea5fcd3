"""Loads, clamps and fields in combinations: other formulations of the same model, periods, wrong arguments."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.cli import run as run_module

STEEL = fm.Material(young=207e9, density=7850.0, poisson=0.3)


def block(*make):
    body = fm.RigidBody("body", (0.0, 0.0), mass=1.0, inertia=1.0)
    return fm.Mechanism("block", (body, *(part for m in make for part in m(body))))


def clamp_x(motion):
    return lambda body: [fm.Clamp("c", fm.GROUND, body, (0.0, 0.0), x=motion)]


def slider(motion):
    return lambda body: [fm.Prismatic("p", fm.GROUND, body), fm.Drive("d", joint="p", motion=motion)]


@pytest.mark.parametrize("make", [clamp_x, slider])
def test_a_travel_at_constant_speed_never_comes_back(make):
    """2 pi/speed is the time of a turn, and means nothing for a travel."""
    for motion in (fm.ConstantSpeed(2.0), fm.drives.Ramp(1.0, 0.1), fm.drives.CycloidalRamp(1.0, 0.1)):
        assert fm.compile(block(make(motion))).periods == (None,)
        with pytest.raises(fm.errors.InputError, match="no periodic drive"):
            fm.simulate(block(make(motion)), periods=1)
    growing = fm.drives.Table((0.0, 1.0, 2.0, 3.0), (0.0, 1.0, 2.0, 3.5), periodic=True)
    assert fm.compile(block(make(growing))).periods == (None,)


@pytest.mark.parametrize("make", [clamp_x, slider])
def test_a_travel_to_and_fro_does(make):
    wave = fm.drives.Table((0.0, 1.0, 2.0, 3.0), (0.2, 1.0, 0.5, 0.2), periodic=True)
    assert fm.compile(block(make(fm.drives.Harmonic(0.1, 5.0, phase=1.0, mean=3.0)))).periods == (0.2,)
    assert fm.compile(block(make(wave))).periods == (3.0,)


def test_the_command_line_sees_the_period_of_a_clamp():
    turning = block(lambda body: [fm.Clamp("c", fm.GROUND, body, (0.0, 0.0), angle=fm.drives.Harmonic(0.1, 4.0))])
    assert run_module.periods_of(turning) == [0.25]
    sol = fm.simulate(turning, periods=2, step=1e-2, save=20)
    assert list(run_module.four_instants(turning, sol)) == pytest.approx([0.25, 0.3125, 0.375, 0.4375])
    assert run_module.periods_of(block(clamp_x(fm.ConstantSpeed(1.0)))) == []


def test_inverse_dynamics_of_bodies_with_declared_start_velocities():
    """Torque J alpha: the speed grows from 2 rad/s, so the declared one holds at the start alone."""
    rod = fm.RigidLink("rod", (0.0, 0.0), (1.0, 0.0), mass=1.0, inertia=0.1, velocity=(0.0, 1.0, 2.0))
    motor = fm.Drive("motor", joint="O", motion=fm.drives.Polynomial((0.0, 2.0, 1.5)))
    mech = fm.Mechanism("rod", (rod, fm.Revolute("O", fm.GROUND, rod, (0.0, 0.0)), motor))
    found = fm.inverse_dynamics(mech, [0.0, 0.4, 1.0])
    assert found.torque("motor") == pytest.approx([0.35 * 3.0] * 3, rel=1e-9)
    assert found.v[:, 2] == pytest.approx([2.0, 3.2, 5.0], rel=1e-9)


def test_inverse_dynamics_wants_a_list_of_instants():
    mech = block(lambda body: [fm.Clamp("c", fm.GROUND, body, (0.0, 0.0), angle=fm.drives.Ramp(1.0, 1.0))])
    with pytest.raises(
        fm.errors.InputError, match=r"inverse_dynamics 'block': times is 0.5; it must be a list of instants"
    ):
        fm.inverse_dynamics(mech, 0.5)
    with pytest.raises(fm.errors.InputError, match=r"times\[1\] is nan"):
        fm.inverse_dynamics(mech, [0.0, math.nan])


def test_momentum_wants_a_solution():
    with pytest.raises(fm.errors.InputError, match=r"momentum 'block': solution is None"):
        fm.momentum(block(), None)


@pytest.mark.parametrize("name", ["velocity", "displacement"])
def test_a_field_of_one_number_is_refused(name):
    with pytest.raises(fm.errors.InputError, match=rf"FlexibleLink 'rod': {name}.* is array\(1.\)"):
        fm.FlexibleLink("rod", (0, 0), (1, 0), section=fm.Circle(0.01), material=STEEL, **{name: np.array(1.0)})


@pytest.mark.slow
def test_a_clamp_on_a_moving_body_is_a_driven_hinge():
    """The same flexible arm on the same moving link, by Clamp and by Revolute with Drive: every force agrees."""
    base = fm.RigidLink("base", (0.0, 0.0), (0.5, 0.0), mass=1.0, inertia=0.05)
    arm = fm.FlexibleLink("arm", (0.5, 0.0), (0.9, 0.1), section=fm.Circle(0.006), material=STEEL, elements=3)
    swing = fm.drives.Harmonic(0.3, 2.0, phase=-math.pi / 2, mean=0.3)
    hub = (fm.Revolute("O", fm.GROUND, base, (0.0, 0.0)), fm.Drive("d", joint="O", motion=fm.drives.Ramp(5.0, 0.3)))
    at = (0.5, 0.0)
    one = (base, arm, *hub, fm.Clamp("c", base, arm, at, angle=swing))
    two = (base, arm, *hub, fm.Revolute("c", base, arm, at), fm.Drive("e", joint="c", motion=swing))
    a, b = (fm.simulate(fm.Mechanism("m", p, gravity=(0.0, -9.81)), t_end=0.2, step=5e-4, save=40) for p in (one, two))
    assert a.ok
    assert b.ok
    pairs = {"c.fx": "c.fx", "c.angle_torque": "e.torque", "c.angle_power": "e.power", "c.angle_rate": "e.speed"}
    for mine, other in pairs.items():
        size = np.abs(b.array(other)).max()
        assert size > 0.01
        np.testing.assert_allclose(a.array(mine), b.array(other), atol=1e-6 * size)
    assert a.array("energy.drive_work")[-1] == pytest.approx(b.array("energy.drive_work")[-1], abs=1e-8)


def test_forces_inside_an_isolated_pair_leave_its_momenta():
    """A clamp that moves and turns one free body against another: linear and angular momentum stay, order 2 in h."""
    rod = fm.FlexibleLink(
        "rod", (0, 0), (1, 0), section=fm.Circle(0.01), material=STEEL, elements=2, velocity=(0.3, 0.2, 1.0)
    )
    body = fm.RigidBody("body", (1.2, 0.1), mass=2.0, inertia=0.3)
    motions = {
        "angle": fm.drives.CycloidalRamp(5.0, 0.1),
        "x": fm.drives.CycloidalRamp(0.5, 0.1),
        "y": fm.drives.Harmonic(0.05, 3.0, 0.3),
    }
    mech = fm.Mechanism("pair", (rod, body, fm.Clamp("c", rod, body, (1.0, 0.0), **motions)))
    drift = []
    for h in (1e-3, 5e-4):
        sol = fm.simulate(mech, t_end=0.2, step=h, save=20)
        assert sol.ok
        found = fm.momentum(mech, sol)
        drift.append(np.ptp(np.column_stack([found.linear, found.angular]), axis=0).max())
    assert np.ptp(sol.array("body.omega")) > 1.0, "nothing moves: the test says nothing"
    assert drift[1] < 2e-5
    assert drift[1] < 0.35 * drift[0]


@pytest.mark.parametrize("cut", [0.3, float(np.nextafter(0.3, 0.0)), 0.5, 0.7])
def test_a_run_cut_at_a_jump_goes_on_as_if_it_were_whole(cut):
    mech = block(lambda body: [fm.Force("F", body, (0, 0), (1.0, 0.0), history=fm.drives.Pulse(start=0.3, end=0.7))])
    whole = fm.simulate(mech, t_end=1.0, step=1e-2)
    half = fm.simulate(mech, t_end=cut, step=1e-2)
    rest = fm.simulate(mech, t_end=1.0, step=1e-2, restart=half.restart)
    assert rest.array("body.x")[-1] == pytest.approx(0.5 * 0.4**2 + 0.4 * 0.3, rel=1e-12)
    assert rest.array("body.x")[-1] == pytest.approx(whole.array("body.x")[-1], abs=1e-15)
