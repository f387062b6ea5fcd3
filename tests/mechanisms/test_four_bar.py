"""The ready four-bar mechanism against Freudenstein's equation and its own mass properties."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.mechanisms import FourBarData, four_bar

GROUND, CRANK, COUPLER, ROCKER = 0.254, 0.108, 0.2794, 0.2705
OMEGA = 340 * 2 * math.pi / 60


def test_angles_satisfy_freudenstein_s_equation():
    """K1 cos(psi) - K2 cos(theta) + K3 = cos(theta - psi), F. Freudenstein, Trans. ASME 77 (1955) 853-861."""
    sol = fm.simulate(four_bar(), periods=1, save="steps")
    theta, psi = sol.array("crank.theta"), sol.array("rocker.theta")
    K1, K2 = GROUND / CRANK, GROUND / ROCKER
    K3 = (CRANK**2 - COUPLER**2 + ROCKER**2 + GROUND**2) / (2 * CRANK * ROCKER)
    assert np.abs(theta - OMEGA * sol.time).max() <= 1e-10
    assert np.abs(K1 * np.cos(psi) - K2 * np.cos(theta) + K3 - np.cos(theta - psi)).max() <= 1e-9


def test_torque_is_the_power_of_the_stored_energy():
    """Without gravity and friction the drive's power is the rate of the kinetic energy."""
    sol = fm.simulate(four_bar(), periods=1, save="steps", step=2e-5)
    power, T = sol.array("motor.power"), sol.array("energy.kinetic")
    n = len(sol.time) // 3 * 2
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(sol.time))])
    assert np.abs(work - (T - T[0])).max() <= 1e-5 * np.ptp(T)
    assert abs(T[n] - T[0]) > 0.01 * T[0]


def test_rigid_and_flexible_links_weigh_the_same():
    rigid, flexible = four_bar(), four_bar(flexible=True)
    for name, depth, length in (("crank", 0.00424, CRANK), ("coupler", 0.0016, COUPLER), ("rocker", 0.0016, ROCKER)):
        own, other = flexible.find(name).properties(), rigid.find(name)
        bar = 2710.0 * 0.0254 * depth * length
        mass = bar + (0.042 if name == "coupler" else 0.0)
        assert own.mass == pytest.approx(mass, rel=1e-12)
        assert other.mass == pytest.approx(mass, rel=1e-12)
        node = other.nodes()[0]
        assert own.centre == pytest.approx((node.x, node.y), abs=1e-12)
        assert own.inertia == pytest.approx(other.inertia, rel=1e-10)
    coupler = rigid.find("coupler")
    bar = 2710.0 * 0.0254 * 0.0016 * COUPLER
    # a bar and a point mass at its end, about their common centre: m l^2/12 + (m M/(m + M)) (l/2)^2
    expected = bar * COUPLER**2 / 12 + bar * 0.042 / (bar + 0.042) * (COUPLER / 2) ** 2
    assert coupler.inertia == pytest.approx(expected, rel=1e-9)


def test_flexible_links_with_clearance_run():
    sol = fm.simulate(four_bar(flexible=True, clearance=0.1e-3, friction="coulomb", ramp=0.1), t_end=0.2)
    assert sol.ok, sol.status
    assert sol.peak("coupler.deflection").value > 1e-5
    assert sol.peak("B.normal_force").value > 1.0


def test_crank_that_cannot_turn_round_is_refused():
    with pytest.raises(fm.errors.InputError, match="crank cannot turn round"):
        FourBarData(crank=0.26)
    with pytest.raises(fm.errors.InputError, match="Grashof"):
        FourBarData(ground=0.45)


@pytest.mark.parametrize(
    ("keywords", "words"),
    [
        ({"data": 3}, ["data", "FourBarData"]),
        ({"friction": "dry"}, ["four_bar", "dry"]),
        ({"start": "up"}, ["start", "up"]),
    ],
)
def test_refusals(keywords, words):
    with pytest.raises(fm.errors.InputError) as error:
        four_bar(**keywords)
    assert all(word in str(error.value) for word in words)
