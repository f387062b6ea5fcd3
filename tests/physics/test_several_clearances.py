"""Several joints with play at once; every kind of joint by every kind of rod, exchanged by one part each."""

import cmath
import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import flexmb as fm
from flexmb.mechanisms import nine_bar, slider_crank

PLAY, BEARING, SPEED = 2e-4, 0.01, 60.0
R, L = 0.05, 0.12
NORMAL = fm.contact.ExactRestitution(stiffness=1e10, restitution=0.6, least_approach=1e-3)
FRICTION = fm.friction.SmoothCoulomb(0.05, v0=1e-2)
PLACE = ("name", "first", "second", "at")


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
    crank = replace(crank, velocity=(0.0, 0.5 * R * SPEED, SPEED))  # an elastic coupling would leave it at rest
    rotor = fm.RigidBody("rotor", (0.0, 0.0), 1.0, 1e-2)
    parts = (
        crank,
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
        assert depth.max() < 0.5 * PLAY


def flying(joints, t):
    """Eccentricity of each journal while no surface has touched: every body keeps its speed and its spin.

    From the stretched position: the crank (about O, or free about its centre at speed r w/2) at w, the rod's centre at
    r w/2 upwards and its spin -r w/l, the slider at rest.
    """
    crank, rod = cmath.exp(1j * SPEED * t), cmath.exp(-1j * R * SPEED / L * t)
    centre = 0.5 * R * (1.0 + 1j * SPEED * t) if "O" in joints else 0.5 * R * crank
    middle = R + 0.5 * L + 0.5j * R * SPEED * t
    # journals: of the crank in the frame, of the rod in the crank, of the slider in the rod
    return {
        "O": centre - 0.5 * R * crank,
        "A": middle - 0.5 * L * rod - centre - 0.5 * R * crank,
        "B": R + L - middle - 0.5 * L * rod,
    }


@pytest.mark.parametrize("joints", ["AB", "OAB"])
def test_slider_crank_with_two_and_three_plays(joints):
    """A turn; and the first impact of all, which is that of A, when and where free flight brings it."""
    mech = coupled(slider_crank(SPEED))
    for name in joints:
        mech = mech.with_part(with_play(mech.find(name)))
    sol = fm.simulate(mech, t_end=2.0 * math.pi / SPEED, save="steps")
    check(sol, joints, 1e-3)
    touch = {n: brentq(lambda t, n=n: abs(flying(joints, t)[n]) - PLAY, 1e-5, 1e-2, xtol=1e-14) for n in joints}
    first = min(touch, key=touch.get)
    assert first == "A"
    k = int(np.flatnonzero(sol.array("A.penetration") > 0.0)[0])
    assert sol.time[k - 1] < touch["A"] < sol.time[k]
    for j in (k - 1, k // 2):
        for name in joints:
            e = complex(sol.array(f"{name}.ex")[j], sol.array(f"{name}.ey")[j])
            assert abs(e - flying(joints, sol.time[j])[name]) < 1e-4 * PLAY


@pytest.mark.parametrize("joints", [("P1", "P4"), ("P1", "P4", "B2")])
def test_nine_bar_with_two_and_three_plays(joints):
    mech = nine_bar(2.0 * math.pi, clearance=PLAY)
    for name in joints[1:]:
        mech = mech.with_part(replace(mech.find("P1"), **{f: getattr(mech.find(name), f) for f in PLACE}))
    sol = fm.simulate(mech, periods=1, save="steps")
    check(sol, joints, 1e-3)


KINDS = {"ideal": lambda joint: joint, "bushing": elastic, "clearance": with_play}


@pytest.mark.slow
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
