"""One head-on impact of a ball in a ring: exact restitution, and the converged depth, duration and peak force."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import flexmb as fm
from flexmb.run.run import Run
from flexmb.statics.start.consistent import Start

RING, BALL, SPEED, STIFFNESS, PLAY = 2.0, 0.5, 1.5, 1e9, 1e-3
REDUCED = RING * BALL / (RING + BALL)

REFERENCE = {0.9: (1.0547874, 3.2498833, 1.0916121)}
"""e asked for -> largest depth, duration, peak force for m = K = v = 1, n = 3/2: an independent code, converged."""

ELASTIC = (1.0933620739, 3.21806546)
"""Largest depth and duration for e = 1, same units: (5/4)^(2/5) and 2 (5/4)^(2/5) times the integral of
1/sqrt(1 - s^(5/2)) over s = 0..1."""

RULES = {"alpha": fm.Newmark.generalised_alpha(0.8), "trapezoidal": fm.Newmark.trapezoidal(), "rk4": fm.RungeKutta4()}


def thrown(restitution, step, *, method=None, angle=0.0, t_end=1.5e-3):
    """The ball flies from the middle of the resting ring against it, in direction `angle`."""
    ring = fm.RigidBody("ring", (0.0, 0.0), RING, 1.0)
    ball = fm.RigidBody("ball", (0.0, 0.0), BALL, 1.0)
    law = fm.LankaraniNikravesh(stiffness=STIFFNESS, restitution=restitution, least_approach=0.0)
    joint = fm.RevoluteClearance("J", ring, ball, (0.0, 0.0), clearance=PLAY, bearing_radius=0.02, normal=law)
    program = fm.compile(fm.Mechanism("thrown", (ring, ball, joint)))
    run = Run(program, method or fm.Newmark.trapezoidal(), fm.FixedStep(step), t_end, None)
    v = np.array([0.0, 0.0, 0.0, SPEED * math.cos(angle), SPEED * math.sin(angle), 0.0])
    run.begin(Start(np.zeros(6), v, np.zeros(6), np.zeros(0)))
    run.run_to(t_end, saving=0.0)
    return run.solution({})


def separation(sol, angle=0.0):
    """Rebound speed over approach speed, along the line of flight."""
    vx = sol.array("ball.vx")[-1] - sol.array("ring.vx")[-1]
    vy = sol.array("ball.vy")[-1] - sol.array("ring.vy")[-1]
    return -(vx * math.cos(angle) + vy * math.sin(angle)) / SPEED


def exact_restitution(restitution):
    """a (1 + e) = ln((1 + a)/(1 - a e)) for N = K depth^n (1 + a rate/approach), whatever n, K, mass and speed.

    Rate as a function of depth: m rate d(rate)/d(depth) = -N, variables separate.
    """
    a = 0.75 * (1 - restitution**2)
    return brentq(lambda e: a * (1 + e) - math.log((1 + a) / (1 - a * e)), 0.05, 1.0 - 1e-12)


@pytest.mark.parametrize("restitution", [0.5, 0.8, 0.9])
def test_restitution_that_comes_out(restitution):
    sol = thrown(restitution, 2e-7)
    assert sol.array("J.mode")[-1] == 0.0
    assert separation(sol) == pytest.approx(exact_restitution(restitution), rel=1e-5)


@pytest.mark.parametrize("method", RULES)
def test_restitution_does_not_depend_on_method_or_direction(method):
    sol = thrown(0.9, 2e-7, method=RULES[method], angle=2.3)
    assert separation(sol, 2.3) == pytest.approx(exact_restitution(0.9), rel=1e-5)
    np.testing.assert_allclose(sol.array("ball.theta"), 0.0, atol=1e-12)


def test_an_elastic_impact_loses_nothing():
    sol = thrown(1.0, 2e-7)
    assert separation(sol) == pytest.approx(1.0, rel=1e-6)
    assert abs(sol.array("energy.dissipated_contact")[-1]) < 1e-6 * sol.array("energy.kinetic")[0]


def test_momentum_and_energy_of_an_impact():
    """m v of both is kept to round-off; the ledger's loss is that of the centre-of-mass energy, m v^2/2 (1 - e^2)."""
    sol = thrown(0.8, 2e-7)
    total = RING * sol.array("ring.vx") + BALL * sol.array("ball.vx")
    np.testing.assert_allclose(total, BALL * SPEED, rtol=1e-10)
    lost = 0.5 * REDUCED * SPEED**2 * (1 - exact_restitution(0.8) ** 2)
    assert sol.array("energy.dissipated_contact")[-1] == pytest.approx(lost, rel=1e-4)
    kinetic = sol.array("energy.kinetic")
    assert kinetic[0] - kinetic[-1] == pytest.approx(lost, rel=1e-4)


@pytest.mark.parametrize("restitution", [0.9, 1.0])
def test_depth_duration_and_peak_force(restitution):
    """Dimensionless: depth over (m v^2/K)^(2/5), time over that depth over v."""
    length = (REDUCED * SPEED**2 / STIFFNESS) ** 0.4
    step = 1e-7
    sol = thrown(restitution, step)
    depth = sol.array("J.penetration")
    inside = sol.time[depth > 0.0]
    found = (depth.max() / length, (inside[-1] - inside[0]) * SPEED / length)
    expected = REFERENCE[0.9][:2] if restitution == 0.9 else ELASTIC
    assert found[0] == pytest.approx(expected[0], rel=1e-5)
    assert found[1] == pytest.approx(expected[1], abs=2 * step * SPEED / length)
    if restitution == 0.9:
        peak = sol.peak("J.normal_force").value / (STIFFNESS * length**1.5)
        assert peak == pytest.approx(REFERENCE[0.9][2], rel=1e-5)


def test_restitution_converges_at_second_order():
    """Down to steps that resolve the impact with some twenty points."""
    exact = exact_restitution(0.9)
    errors = [abs(separation(thrown(0.9, h)) / exact - 1) for h in (8e-6, 4e-6, 2e-6, 1e-6)]
    assert errors[0] < 2e-2
    # the phase of the onset in its step shakes single errors; over a factor of eight the order shows
    assert math.log2(errors[0] / errors[3]) / 3 > 1.5, errors
