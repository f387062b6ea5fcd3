"""Trailing arm of a suspension: height of rest and natural frequency from the moment about its pin.

M(phi) = m g L cos(phi) - F(phi) a(phi) with the spring's force F and lever a; at rest M = 0, and the small vibrations
have w^2 = -dM/dphi / J.  Source: W. Matschinsky, Road Vehicle Suspensions, PEP 2000, ch. 5 (wheel rate).
"""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import flexmb as fm

L, S, M, G = 0.45, 0.3, 35.0, 9.81  # arm, place of the spring on it, wheel [kg]
JC, K, D = 0.6, 60e3, 900.0
TOP, FREE = (0.25, 0.40), 0.42


def spring_vector(phi):
    """From the seat on the arm to the upper end, for the arm's angle below the horizontal."""
    return TOP[0] - S * math.cos(phi), TOP[1] + S * math.sin(phi)


def moment(phi):
    """Moment that lowers the arm."""
    x, y = spring_vector(phi)
    length = math.hypot(x, y)
    seat = (S * math.cos(phi), -S * math.sin(phi))
    raising = K * (length - FREE) * (seat[0] * y - seat[1] * x) / length
    return M * G * L * math.cos(phi) - raising


def suspension(damping=0.0):
    wheel = fm.RigidBody("wheel", at=(L, 0.0), mass=M, inertia=JC)
    values = {"stiffness": K, "damping": damping, "free_length": FREE}
    return fm.Mechanism("trailing arm", [
        wheel,
        fm.Revolute("A", fm.GROUND, wheel, at=(0.0, 0.0)),
        fm.SpringDamper("spring", wheel, fm.GROUND, at=(S, 0.0), to=TOP, **values),
    ], gravity=(0.0, -G))  # fmt: skip


REST = brentq(moment, -0.5, 0.5, xtol=1e-14)
SLOPE = (moment(REST + 1e-5) - moment(REST - 1e-5)) / 2e-5
INERTIA = JC + M * L**2


def test_the_arm_rests_where_the_moments_balance():
    pose = fm.static_equilibrium(suspension())
    assert pose["wheel.theta"] == pytest.approx(-REST, abs=1e-10)
    assert pose["wheel.y"] == pytest.approx(-L * math.sin(REST), abs=1e-10)
    x, y = spring_vector(REST)
    pull = K * (math.hypot(x, y) - FREE) / math.hypot(x, y)
    assert pose.force("A")[0] == pytest.approx(-pull * x, rel=1e-8)
    assert pose.force("A")[1] == pytest.approx(M * G - pull * y, rel=1e-8)


def test_the_natural_frequency_is_that_of_the_slope_of_the_moment():
    exact = math.sqrt(-SLOPE / INERTIA) / (2.0 * math.pi)
    mech = suspension()
    assert fm.modes(mech, count=1, at=fm.static_equilibrium(mech)).frequencies[0] == pytest.approx(exact, rel=1e-6)


def test_the_damping_ratio_is_that_of_the_wheel_rate():
    x, y = spring_vector(REST)
    lever = (S * math.cos(REST) * y + S * math.sin(REST) * x) / math.hypot(x, y)
    exact = D * lever**2 / (2.0 * math.sqrt(-SLOPE * INERTIA))
    mech = suspension(D)
    modes = fm.modes(mech, count=1, at=fm.static_equilibrium(mech), damped=True)
    assert modes.damping[0] == pytest.approx(exact, rel=1e-6)


def test_a_run_from_the_equilibrium_stays_there():
    sol = fm.simulate(suspension(), t_end=0.5, start="equilibrium").require()
    assert np.abs(sol["wheel.theta"].values + REST).max() < 1e-10
