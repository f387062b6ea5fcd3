"""Mechanisms that no example shows, against kinematics by hand, conservation laws and statics."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fm

STEEL = fm.Material(young=207e9, density=7850.0, poisson=0.3)
G = 9.81


def test_quick_return_with_a_block_between_two_moving_bodies():
    """Crank of 0.1 m about (0, 0.3), its pin in a block that slides along a rocker about the origin."""
    pivot, pin, speed = (0.0, 0.3), (0.1, 0.3), 10.0
    crank = fm.RigidLink("crank", pivot, pin, mass=0.5, inertia=1e-3)
    block = fm.RigidBody("block", at=pin, mass=0.1, inertia=1e-4)
    rocker = fm.RigidLink("rocker", (0.0, 0.0), (0.2, 0.6), mass=1.0, inertia=0.03)
    joints = [
        fm.Revolute("A", fm.GROUND, crank, at=pivot),
        fm.Revolute("B", crank, block, at=pin),
        fm.Revolute("O", fm.GROUND, rocker, at=(0.0, 0.0)),
        fm.Prismatic("slide", rocker, block, along=(0.1, 0.3)),
        fm.Drive("motor", joint="A", motion=fm.ConstantSpeed(speed)),
    ]
    sol = fm.simulate(fm.Mechanism("quick return", [crank, block, rocker, *joints]), periods=1, save=400)
    assert sol.ok
    turn = speed * sol.time
    angle = np.arctan2(0.3 + 0.1 * np.sin(turn), 0.1 * np.cos(turn))
    np.testing.assert_allclose(sol.array("rocker.theta"), angle, atol=1e-9)
    np.testing.assert_allclose(sol.array("block.theta"), angle - angle[0], atol=1e-9)
    assert sol.peak("energy.residual").value < 1e-4 * sol.peak("energy.kinetic").value


def test_travel_driven_between_two_moving_bodies():
    """A slider driven outwards along a spinning arm: angular momentum stays, the force is m (r'' - r w^2)."""
    arm = fm.RigidLink("arm", (0.0, 0.0), (1.0, 0.0), mass=1.0, inertia=1.0 / 12.0, velocity=(0.0, 1.0, 2.0))
    slider = fm.RigidBody("slider", at=(0.5, 0.0), mass=2.0, inertia=0.05)
    parts = [
        fm.Revolute("O", fm.GROUND, arm, at=(0.0, 0.0)),
        fm.Prismatic("slide", arm, slider),
        fm.Drive("push", joint="slide", motion=fm.drives.Ramp(0.3, 0.5)),
    ]
    sol = fm.simulate(fm.Mechanism("governor", [arm, slider, *parts]), t_end=1.0, step=fm.Adaptive(max=1e-3))
    assert sol.ok
    r, w = np.hypot(sol.array("slider.x"), sol.array("slider.y")), sol.array("arm.omega")
    assert r[-1] == pytest.approx(0.5 + 0.3 * (1.0 - 0.25), abs=1e-9)
    np.testing.assert_allclose((1.0 / 3.0 + 0.05 + 2.0 * r**2) * w, (1.0 / 3.0 + 0.05 + 0.5) * 2.0, rtol=1e-5)
    assert sol.array("push.force")[-1] == pytest.approx(-2.0 * r[-1] * w[-1] ** 2, rel=1e-5)
    work = np.trapezoid(sol.array("push.power"), sol.time)
    assert sol.array("energy.kinetic")[-1] - sol.array("energy.kinetic")[0] == pytest.approx(work, rel=1e-4)


def watt_six_bar() -> fm.Mechanism:
    """Two four-bars one behind the other; the rocker of the first carries a third joint."""
    a0, a, b, b0 = (0.0, 0.0), (0.05 * math.cos(1.0), 0.05 * math.sin(1.0)), (0.13, 0.15), (0.15, 0.0)
    c, d, d0 = (0.17, 0.06), (0.32, 0.12), (0.35, 0.0)
    crank = fm.RigidLink("crank", a0, a, mass=0.1, inertia=1e-5)
    coupler = fm.RigidLink("coupler", a, b, mass=0.2, inertia=4e-4)
    ternary = fm.RigidBody("ternary", at=(0.15, 0.07), mass=0.4, inertia=1e-3)
    second = fm.RigidLink("second", c, d, mass=0.2, inertia=4e-4)
    out = fm.RigidLink("out", d0, d, mass=0.2, inertia=4e-4)
    pins = [
        fm.Revolute("A0", fm.GROUND, crank, at=a0),
        fm.Revolute("A", crank, coupler, at=a),
        fm.Revolute("B", coupler, ternary, at=b),
        fm.Revolute("B0", fm.GROUND, ternary, at=b0),
        fm.Revolute("C", ternary, second, at=c),
        fm.Revolute("D", second, out, at=d),
        fm.Revolute("D0", fm.GROUND, out, at=d0),
        fm.Drive("motor", joint="A0", motion=fm.ConstantSpeed(30.0)),
    ]
    return fm.Mechanism("watt", [crank, coupler, ternary, second, out, *pins], gravity=(0.0, -G))


def carried(points: np.ndarray, about: tuple[float, float], angle: np.ndarray) -> np.ndarray:
    """A point turned about another by every angle, as complex numbers."""
    return complex(*about) + (complex(*points) - complex(*about)) * np.exp(1j * angle)


def test_watt_six_bar_closes_both_loops_and_comes_back():
    sol = fm.simulate(watt_six_bar(), periods=2, save=360)
    assert sol.ok
    turn = 30.0 * sol.time
    swing = sol.array("ternary.theta")
    tilt = sol.array("out.theta") - sol.array("out.theta")[0]
    a = 0.05 * np.exp(1j * (turn + 1.0))
    b, c = carried((0.13, 0.15), (0.15, 0.0), swing), carried((0.17, 0.06), (0.15, 0.0), swing)
    d = carried((0.32, 0.12), (0.35, 0.0), tilt)
    np.testing.assert_allclose(np.abs(a - b), np.abs(a - b)[0], rtol=1e-9)
    np.testing.assert_allclose(np.abs(c - d), np.abs(c - d)[0], rtol=1e-9)
    assert np.ptp(tilt) > 0.1
    first, again = sol.values[:361], sol.values[360:]
    k = sol.names.index("motor.torque")
    np.testing.assert_allclose(again[:, k], first[:, k], atol=1e-3 * np.abs(first[:, k]).max())
    stored = sol.array("energy.kinetic") + sol.array("energy.gravity")
    power = sol.array("motor.power")
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(sol.time))])
    np.testing.assert_allclose(stored - stored[0], work, atol=1e-3 * np.ptp(stored))


def test_a_stiff_frame_swings_like_a_compound_pendulum():
    """A triangle of steel bars on a pin: M g s cos(phi) turns J, both of three thin rods."""
    corners = ((0.0, 0.0), (0.3, 0.0), (0.3, 0.2))
    edges = ((0, 1), (1, 2), (2, 0))
    section = fm.Rectangle(width=0.01, height=0.01)
    frame = fm.FlexibleFrame("frame", corners, edges, section=section, material=STEEL, elements=2)
    pin = fm.Revolute("pin", fm.GROUND, frame, at=(0.0, 0.0))
    sol = fm.simulate(fm.Mechanism("frame", [frame, pin], gravity=(0.0, -G)), t_end=0.5)
    assert sol.ok
    mass, moment, inertia = 0.0, np.zeros(2), 0.0
    for i, j in edges:
        p, q = np.array(corners[i]), np.array(corners[j])
        bar, middle = 7850.0 * 1e-4 * np.hypot(*(q - p)), 0.5 * (p + q)
        mass, moment = mass + bar, moment + bar * middle
        inertia += bar * ((q - p) @ (q - p) / 12.0 + middle @ middle)
    arm, start = np.hypot(*moment) / mass, math.atan2(moment[1], moment[0])
    rigid = solve_ivp(
        lambda _, y: [y[1], -mass * G * arm * math.cos(y[0]) / inertia],
        (0.0, 0.5),
        [start, 0.0],
        t_eval=sol.time,
        rtol=1e-10,
        atol=1e-12,
    )
    # the bars bend by some 1e-5 rad
    np.testing.assert_allclose(sol.array("frame.theta"), rigid.y[0] - start, atol=1e-4)


def test_thirty_links_keep_their_energy_with_second_order():
    parts, before, at = [], fm.GROUND, (0.0, 0.0)
    for k in range(30):
        end = (0.1 * (k + 1), 0.0)
        link = fm.RigidLink(f"link{k}", at, end, mass=1.0, inertia=0.01 / 12.0)
        parts += [link, fm.Revolute(f"pin{k}", before, link, at=at)]
        before, at = link, end
    chain = fm.Mechanism("chain", parts, gravity=(0.0, -G))
    errors = [fm.simulate(chain, t_end=0.4, step=h).peak("energy.residual").value for h in (2e-3, 1e-3)]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)
    assert errors[1] < 1e-4 * 30.0 * G * 1.5


@pytest.mark.parametrize("flexible", [False, True])
def test_three_worn_joints_in_a_row_carry_the_weights_below(flexible):
    """At rest the journals hang at c + (N/K)^(2/3) under their bearings, N being the weight below."""
    stiffness, clearance = 1e8, 1e-4
    law = fm.LankaraniNikravesh(stiffness=stiffness, restitution=0.5)
    parts, before = [], fm.GROUND
    for k in range(3):
        top, end = (0.0, -0.2 * k), (0.0, -0.2 * (k + 1))
        body = fm.RigidLink(f"link{k}", top, end, mass=1.0, inertia=1e-2)
        if flexible and k == 1:
            body = fm.FlexibleLink(
                f"link{k}",
                top,
                end,
                section=fm.Circle(diameter=0.008),
                material=STEEL,
                elements=2,
                mass=1.0,
                damping=1e-5,
            )
        joint = fm.RevoluteClearance(
            f"J{k}", before, body, at=top, clearance=clearance, bearing_radius=0.01, normal=law
        )
        parts += [body, joint]
        before = body
    sol = fm.simulate(fm.Mechanism("hanging", parts, gravity=(0.0, -G)), t_end=0.4)
    assert sol.ok
    for k in range(3):
        weight = (3 - k) * G
        assert sol.array(f"J{k}.fy")[-1] == pytest.approx(weight, rel=1e-2)
        depth = (weight / stiffness) ** (2.0 / 3.0)
        assert sol.array(f"J{k}.ey")[-1] == pytest.approx(-clearance - depth, rel=1e-2)
        assert sol.array(f"J{k}.mode")[-1] == 2


def test_signs_of_a_drive_that_lifts_and_of_its_pin():
    """A bar of 2 kg and 1 m lifted slowly: torque m g L/2, power torque times speed, the pin carries the weight."""
    bar = fm.RigidLink("bar", (0.0, 0.0), (1.0, 0.0), mass=2.0, inertia=0.1)
    parts = [fm.Revolute("O", fm.GROUND, bar, at=(0.0, 0.0)), fm.Drive("lift", "O", fm.ConstantSpeed(0.5))]
    sol = fm.simulate(fm.Mechanism("lift", [bar, *parts], gravity=(0.0, -G)), t_end=1.0)
    assert sol.array("lift.torque")[0] == pytest.approx(G)
    assert sol.array("lift.power")[0] == pytest.approx(0.5 * G)
    assert sol.array("O.fy")[0] == pytest.approx(2.0 * G)
    assert sol.array("O.fx")[0] == pytest.approx(-2.0 * 0.5 * 0.5**2)
    assert sol.array("energy.drive_work")[-1] == pytest.approx(G * math.sin(0.5), rel=1e-5)


def test_a_body_on_two_springs_swings_at_its_frequency():
    """m y'' = -m g - 2 k y from rest: y = -m g / (2 k) (1 - cos w t)."""
    body = fm.RigidBody("body", at=(0.0, -1.0), mass=2.0, inertia=0.1)
    springs = [
        fm.SpringDamper(f"spring{k}", fm.GROUND, body, at=(x, 0.0), to=(x, -1.0), stiffness=500.0)
        for k, x in enumerate((-0.2, 0.2))
    ]
    sol = fm.simulate(fm.Mechanism("hung", [body, *springs], gravity=(0.0, -G)), t_end=2.0, step=5e-4)
    sag, w = 2.0 * G / 1000.0, math.sqrt(500.0)
    # Newmark's methods stretch the period by about (w h)^2 / 12; 1/8 leaves room for the damping of the method
    exact = -1.0 - sag * (1.0 - np.cos(w * sol.time))
    np.testing.assert_allclose(sol.array("body.y"), exact, atol=w * 2.0 * (w * 5e-4) ** 2 / 8.0 * sag)
    assert sol.array("energy.load_work")[-1] == 0.0
