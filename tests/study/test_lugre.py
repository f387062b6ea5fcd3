"""The LuGre law of the paper: sliding, sticking, history, contracts."""

import math

import numpy as np
import pytest
from nine_bar_study.nine_bar.cases import FRICTION, case
from nine_bar_study.nine_bar.lugre import LoadScaledLuGre
from scipy.integrate import solve_ivp

import flexmb as fm
from flexmb.errors import InputError

NUMBERS = {"static": 0.015, "kinetic": 0.01, "stribeck_speed": 1e-3, "stiffness": 1e5, "damping": 300.0}
LAW = LoadScaledLuGre(**NUMBERS)


def after(law, h, slips, load=200.0):
    """Force [N] and deflection [m] after steps of `h` at the slips."""
    z, new = np.zeros(1), np.zeros(1)
    T = 0.0
    for slip in slips:
        T = law.kernel.python(law.parameters(), h, slip, load, z, new)[0]
        z[0] = new[0]
    return T, z[0]


@pytest.mark.parametrize("slip", [-0.2, 1e-3, 5e-4, 0.05])
def test_steady_sliding(slip):
    """z' = 0: T = -(g(slip) sign(slip) + sigma_2 slip) N."""
    law = LoadScaledLuGre(**NUMBERS, viscous=0.4)
    T, _ = after(law, 1e-5, [slip] * 4000)
    g = 0.01 + 0.005 * math.exp(-((slip / 1e-3) ** 2))
    assert pytest.approx(-200.0 * (math.copysign(g, slip) + 0.4 * slip), rel=1e-6) == T


def test_the_history_is_that_of_the_equation():
    """Fine steps against an integrator of ordinary differential equations, slip 2 mm/s sin(100 t)."""

    def rate(t, z):
        v = 2e-3 * np.sin(100.0 * t)
        return v - 1e5 * abs(v) * z / (0.01 + 0.005 * np.exp(-((v / 1e-3) ** 2)))

    wanted = solve_ivp(rate, (0.0, 0.02), [0.0], method="LSODA", rtol=1e-10, atol=1e-16).y[0, -1]
    errors = []
    for steps in (4000, 8000):
        h = 0.02 / steps
        _, z = after(LAW, h, 2e-3 * np.sin(100.0 * h * np.arange(1, steps + 1)))
        errors.append(abs(z - wanted))
    assert errors[1] < 0.01 * abs(wanted)
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.2)  # implicit Euler


def test_stiffness_follows_the_load():
    light, heavy = (after(LAW, 1e-6, [1e-6] * 10, load)[0] for load in (10.0, 1000.0))
    assert heavy == pytest.approx(100.0 * light, rel=1e-12)


def test_bristles_are_gone_when_the_surfaces_part():
    z, new = np.array([1e-7]), np.ones(1)
    assert LAW.kernel.python(LAW.parameters(), 1e-6, 0.1, 0.0, z, new)[0] == 0.0
    assert new[0] == 0.0


@pytest.mark.slow
def test_contracts():
    mechanism = case("rigid", 2.5, friction="lugre").mechanism()
    assert mechanism.find("P1").friction == FRICTION["lugre"] == LAW
    fm.testing.check_part(mechanism, "P1")


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"static": 0.005}, "static"),
        ({"stiffness": 0.0}, "stiffness is 0 1/m; it must be > 0"),
        ({"damping": -1.0}, "damping is -1 s/m; it must be >= 0"),
        ({"stribeck_speed": -1e-3}, "stribeck_speed"),
        ({"kinetic": math.nan}, "kinetic"),
    ],
)
def test_bad_numbers(change, told):
    with pytest.raises(InputError, match=told):
        LoadScaledLuGre(**{**NUMBERS, **change})


def test_sticks():
    assert LAW.creep_speed(0.9) == 0.0
    assert LAW.creep_speed(1.1) == math.inf
