"""Several joints with play at once; every kind of joint by every kind of rod, exchanged by one part each."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

import flexmb as fm
from flexmb.mechanisms import nine_bar, slider_crank

PLAY, BEARING, SPEED = 2e-4, 0.01, 60.0
NORMAL = fm.ExactRestitution(stiffness=1e9, restitution=0.6, least_approach=1e-3)
FRICTION = fm.SmoothCoulomb(0.05, v0=1e-2)


def with_play(joint, clearance=PLAY):
    """The same joint with play, under the same name."""
    options = {"clearance": clearance, "bearing_radius": BEARING, "normal": NORMAL, "friction": FRICTION}
    return fm.RevoluteClearance(joint.name, joint.first, joint.second, at=joint.at, **options)


def elastic(joint):
    """The same joint as a bushing."""
    stiffness, damping = 5e7, 2e3
    return fm.Bushing(joint.name, joint.first, joint.second, at=joint.at, stiffness=stiffness, damping=damping)


def coupled(mech):
    """The motor on a rotor of its own, which turns the crank through an elastic coupling: O may then have play."""
    crank, motor = mech.find("crank"), mech.find("motor")
    rotor = fm.RigidBody("rotor", (0.0, 0.0), 1.0, 1e-2)
    parts = (
        rotor,
        fm.Revolute("axle", fm.GROUND, rotor, at=(0.0, 0.0)),
        fm.TorsionSpring("coupling", rotor, crank, stiffness=2e3, damping=0.5),
        replace(motor, joint="axle"),
    )
    for part in parts:
        mech = mech.with_part(part)
    return mech


def check(sol, joints, residual):
    """Ended well, energies in balance, every named joint was hit; forces only where surfaces touch."""
    assert sol.ok, sol.status
    moved = max(sol.peak(f"energy.{name}").value for name in ("kinetic", "drive_work"))
    assert sol.peak("energy.residual").value <= residual * moved
    for name in joints:
        depth, N = sol.array(f"{name}.penetration"), sol.array(f"{name}.normal_force")
        assert depth.max() > 0.0
        assert np.all(N[depth < 0.0] == 0.0)
        assert depth.max() < 0.2 * PLAY


def first_touch(sol, name):
    """Time of the first contact, and the eccentricity's direction there."""
    k = int(np.flatnonzero(sol.array(f"{name}.penetration") > 0.0)[0])
    return sol.time[k], np.array([sol.array(f"{name}.ex")[k], sol.array(f"{name}.ey")[k]]) / PLAY


@pytest.mark.parametrize("joints", ["AB", "OAB"])
def test_slider_crank_with_two_and_three_plays(joints):
    """The first impacts: a journal left alone goes on as it flies, so it first touches opposite to its acceleration."""
    mech = coupled(slider_crank(SPEED))
    for name in joints:
        mech = mech.with_part(with_play(mech.find(name)))
    sol = fm.simulate(mech, t_end=2.0 * math.pi / SPEED, save="steps")
    check(sol, joints, 1e-2)
    # B: the slider flies on at its speed (0, stretched start) while the rod's end is pulled back by r w^2 (1 + r/l),
    # at least when A moves on with the crank: the journal (slider) meets the outer side of its bearing
    t, n = first_touch(sol, "B")
    assert n[0] > 0.9
    fastest = math.sqrt(2.0 * PLAY / (0.05 * SPEED**2 * (1.0 + 0.05 / 0.12)))
    assert t >= 0.99 * fastest
    assert t <= 5.0 * fastest


@pytest.mark.parametrize("joints", [("P1", "P4"), ("P1", "P4", "B2")])
def test_nine_bar_with_two_and_three_plays(joints):
    mech = nine_bar(2.0 * math.pi, clearance=PLAY)
    for name in joints[1:]:
        mech = mech.with_part(replace(mech.find("P1"), **{f: getattr(mech.find(name), f) for f in FIELDS}))
    sol = fm.simulate(mech, periods=1, save="steps")
    check(sol, joints, 2e-2)


FIELDS = ("name", "first", "second", "at")


KINDS = {"ideal": lambda joint: joint, "bushing": elastic, "clearance": with_play}


def test_all_combinations_of_joint_and_rod():
    """3 kinds of joint A x 3 of joint B, each with a rigid and a flexible rod: a short time, near the ideal motion."""
    ideal, end = slider_crank(SPEED), 0.3 * 2.0 * math.pi / SPEED
    x = 0.05 * math.cos(SPEED * end) + math.sqrt(0.12**2 - (0.05 * math.sin(SPEED * end)) ** 2)
    for (a, A), (b, B), flexible in itertools.product(KINDS.items(), KINDS.items(), (False, True)):
        mech = slider_crank(SPEED, flexible=flexible, elements=2)
        mech = mech.with_part(A(ideal.find("A"))).with_part(B(ideal.find("B")))
        sol = fm.simulate(mech, t_end=end, save=1)
        assert sol.ok, (a, b, flexible, sol.status)
        plays = (a == "clearance") + (b == "clearance")
        loose = 1.3 * PLAY * plays + 5e-6 * (1 + flexible)
        assert abs(sol.array("slider.x")[-1] - x) < loose, (a, b, flexible)
        assert abs(sol.array("slider.x")[-1] - x) > 1e-12 or (a, b, flexible) == ("ideal", "ideal", False)
