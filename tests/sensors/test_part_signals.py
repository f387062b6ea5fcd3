"""Signals of joints, springs and loads; all saved signals belong to the state at their instant."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError
from flexmb.mechanisms import slider_crank

G = 9.81


def test_angles_of_joints_are_those_of_the_linkage():
    omega, r, l = 80.0, 0.05, 0.12
    sol = fm.simulate(slider_crank(omega), periods=1, step=fm.Adaptive(rtol=1e-8), save=300)
    turn = omega * sol.time
    rod = -np.arcsin(r / l * np.sin(turn))  # of the rod against the axis of the slider
    assert np.abs(sol.array("O.angle") - turn).max() < 1e-12
    assert np.abs(sol.array("A.angle") - (rod - turn)).max() < 1e-7
    assert np.abs(sol.array("A.angle") - (sol.array("rod.theta") - sol.array("crank.theta"))).max() < 1e-14
    assert np.abs(sol.array("A.omega") - (sol.array("rod.omega") - sol.array("crank.omega"))).max() < 1e-12
    x = r * np.cos(turn) + l * np.cos(rod)
    assert np.abs(sol.array("guide.travel") - (x - r - l)).max() < 1e-8
    assert np.abs(sol.array("guide.speed") - sol.array("slider.vx")).max() < 1e-12


def test_angle_of_a_worn_joint_and_of_one_between_turned_bodies():
    mech = slider_crank(clearance=5e-4)
    sol = fm.simulate(mech, t_end=2e-3)
    assert np.abs(sol.array("B.angle") - (sol.array("slider.theta") - sol.array("rod.theta"))).max() < 1e-14
    leaf = fm.RigidBody("leaf", (0.3, 0.0), 1.0, 1e-2, theta=0.7)
    hinge = fm.Revolute("hinge", fm.GROUND, leaf, at=(0.0, 0.0))
    sol = fm.simulate(fm.Mechanism("leaf", [leaf, hinge], gravity=(0.0, -G)), t_end=0.1)
    assert sol.array("hinge.angle")[0] == 0.0
    assert np.abs(sol.array("hinge.angle") - (sol.array("leaf.theta") - 0.7)).max() < 1e-15


def oscillator(**spring):
    mass = fm.RigidBody("mass", (0.5, 0.0), 2.0, 1e-3)
    guide = fm.Prismatic("guide", fm.GROUND, mass)
    part = fm.SpringDamper("spring", fm.GROUND, mass, at=(0.0, 0.0), to=(0.5, 0.0), **spring)
    return fm.Mechanism("oscillator", [mass, guide, part])


def test_spring_and_damper_in_closed_form():
    k, d, l0 = 800.0, 5.0, 0.4
    sol = fm.simulate(oscillator(stiffness=k, damping=d, free_length=l0), t_end=0.4, step=fm.Adaptive(rtol=1e-9))
    decay, w = d / 4.0, math.sqrt(k / 2.0 - (d / 4.0) ** 2)
    t, u0 = sol.time, 0.1
    u = u0 * np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t))
    rate = -u0 * np.exp(-decay * t) * (decay**2 + w**2) / w * np.sin(w * t)
    assert np.abs(sol.array("spring.length") - l0 - u).max() < 1e-8
    assert np.abs(sol.array("spring.rate") - rate).max() < 1e-6
    assert np.abs(sol.array("spring.force") - (k * u + d * rate)).max() < 1e-5
    assert np.abs(sol.array("spring.energy") - 0.5 * k * u**2).max() < 1e-6
    assert np.abs(sol.array("spring.energy") - sol.array("energy.strain")).max() < 1e-12
    assert np.abs(sol.array("spring.force") + 2.0 * sol.array("mass.ax")).max() < 1e-6  # it alone moves the mass


def test_torsion_spring_pulls_as_the_body_turns():
    wheel = fm.RigidBody("wheel", (0.0, 0.0), 1.0, 0.02, velocity=(0.0, 0.0, 3.0))
    parts = [wheel, fm.Revolute("axle", fm.GROUND, wheel, at=(0.0, 0.0))]
    spring = fm.TorsionSpring("coil", fm.GROUND, wheel, stiffness=0.5, damping=0.01, free_angle=0.3)
    sol = fm.simulate(fm.Mechanism("wheel", [*parts, spring]), t_end=1.0, step=fm.Adaptive(rtol=1e-8))
    angle, omega = sol.array("coil.angle"), sol.array("coil.rate")
    assert np.abs(angle - sol.array("axle.angle")).max() == 0.0
    assert np.abs(sol.array("coil.torque") - 0.02 * sol.array("wheel.alpha")).max() < 1e-9
    assert np.abs(sol.array("coil.torque") + 0.5 * (angle - 0.3) + 0.01 * omega).max() < 1e-14
    assert np.abs(sol.array("coil.energy") - sol.array("energy.strain")).max() < 1e-12


def test_loads_with_their_history_and_power():
    ball = fm.RigidBody("ball", (0.0, 0.0), 2.0, 0.1)
    wave = fm.drives.Harmonic(amplitude=1.0, frequency=1.5)
    push = fm.Force("push", ball, (0.1, 0.0), (3.0, 4.0), history=wave, follower=True)
    spin = fm.Torque("spin", ball, -0.2, history=wave)
    sol = fm.simulate(fm.Mechanism("pushed", [ball, push, spin]), t_end=1.0, step=fm.Adaptive(rtol=1e-8), save=4000)
    size, c, s = (sol.array(name) for name in ("push.force", "ball.theta", "ball.theta"))
    c, s = np.cos(c), np.sin(s)
    assert np.abs(sol.array("push.fx") - size / 5.0 * (3.0 * c - 4.0 * s)).max() < 1e-13
    assert np.abs(sol.array("push.fx") - 2.0 * sol.array("ball.ax")).max() < 1e-6
    assert np.abs(sol.array("push.fy") - 2.0 * sol.array("ball.ay")).max() < 1e-6
    assert np.abs(sol.array("spin.torque") + 0.04 * size).max() < 1e-15
    power = sol.array("push.power") + sol.array("spin.power")
    work = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(sol.time) * (power[1:] + power[:-1]))])
    assert np.abs(work - sol.array("energy.load_work")).max() < 1e-6 * np.abs(work).max() + 1e-6


def test_bushing_reports_rates_and_energy():
    body = fm.RigidBody("body", (0.0, 0.0), 1.0, 1e-2)
    bushing = fm.Bushing("mount", fm.GROUND, body, at=(0.0, 0.0), stiffness=(500.0, 900.0), torsion=2.0, damping=1.0)
    parts = [body, bushing, fm.Force("push", body, (0.05, 0.0), (2.0, 3.0))]
    sol = fm.simulate(fm.Mechanism("mount", parts), t_end=0.2)
    for rate, velocity in (("dx_rate", "vx"), ("dy_rate", "vy"), ("omega", "omega")):
        assert np.abs(sol.array(f"mount.{rate}") - sol.array(f"body.{velocity}")).max() < 1e-13
    assert np.abs(sol.array("mount.energy") - sol.array("energy.strain")).max() < 1e-13


@fm.element_kernel
def drag_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    r[0] = p[0] * v[0]
    C[0, 0] = p[0]


@fm.kernels.signal_kernel
def drag_signal(p, t, q, v, a):
    return -p[0] * v[0]


def test_an_element_of_ones_own_reports_what_it_declares():
    from dataclasses import dataclass

    @dataclass(frozen=True)
    class Drag(fm.Element):
        body: fm.Part
        c: float
        kernel = drag_kernel
        coords = ("body.x",)
        signals = (("force", "N", drag_signal),)

    ball = fm.RigidBody("ball", (0.0, 0.0), 2.0, 0.1, velocity=(1.0, 0.0, 0.0))
    sol = fm.simulate(fm.Mechanism("drag", [ball, Drag("drag", ball, 0.7)]), t_end=1.0)
    assert sol.units("drag.force") == "N"
    assert np.abs(sol.array("drag.force") + 0.7 * sol.array("ball.vx")).max() < 1e-15
    with pytest.raises(InputError, match="each must be"):
        type("Wrong", (Drag,), {"signals": (("force", drag_signal),)})


def instants_within_steps(**options):
    """A worn slider-crank whose saved instants lie within the steps."""
    sol = fm.simulate(slider_crank(clearance=5e-4, friction="coulomb"), t_end=4e-3, save=997, **options)
    assert sol.stats.steps < 5 * len(sol.time)
    return sol


@pytest.mark.parametrize("method", [fm.Newmark.generalised_alpha(), fm.RadauIIA()], ids=repr)
def test_signals_between_steps_belong_to_their_state(method):
    mech = slider_crank(clearance=5e-4, friction="coulomb")
    sol = instants_within_steps(method=method)
    bodies = {body.name: body for body in mech.bodies}
    kinetic = sum(
        0.5 * body.mass * (sol.array(f"{name}.vx") ** 2 + sol.array(f"{name}.vy") ** 2)
        + 0.5 * body.inertia * sol.array(f"{name}.omega") ** 2
        for name, body in bodies.items()
    )
    assert np.abs(sol.array("energy.kinetic") - kinetic).max() < 1e-12 * kinetic.max()
    size = np.hypot(sol.array("B.ex"), sol.array("B.ey"))
    assert np.abs(sol.array("B.penetration") - (size - 5e-4)).max() < 1e-15
    assert np.abs(sol.array("O.angle") - sol.array("motor.angle")).max() < 1e-13
    closed = sol.array("B.penetration") > 0.0
    assert np.all(sol.array("B.normal_force")[~closed] == 0.0)
    assert np.all((sol.array("B.mode") > 0.0) == closed)


def test_saved_instants_do_not_change_the_motion():
    mech = slider_crank(clearance=5e-4)
    ends = [fm.simulate(mech, t_end=2e-3, save=save).restart for save in (1, 997, "steps")]
    for other in ends[1:]:
        assert all(np.array_equal(ends[0][name], other[name]) for name in ("q", "v", "a", "lam", "z", "ledger"))


def test_marker_accelerations_between_steps():
    omega = 30.0
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.1, 0.0), mass=1.0, inertia=1e-3)
    parts = [crank, fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)), fm.Drive("motor", "O", fm.ConstantSpeed(omega))]
    mech = fm.Mechanism("crank", [*parts, fm.Marker("tip", crank, at=(0.1, 0.0))])
    sol = fm.simulate(mech, periods=1, save=333)
    assert (
        np.abs(np.hypot(sol.array("tip.x"), sol.array("tip.y")) - 0.1).max() < 1e-8
    )  # cubic in steps of a hundredth of a turn
    assert np.abs(sol.array("tip.vx") + omega * sol.array("tip.y")).max() < 1e-7
