"""The ready slider-crank against exact values; numbers: reference problem of the worn piston pin, 5000 rpm."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.mechanisms import SliderCrankData, slider_crank

R, L, OMEGA = 0.05, 0.12, 5000 * 2 * math.pi / 60


def test_ideal_mechanism_in_closed_form():
    sol = fm.simulate(slider_crank(), periods=1, save="steps", step=2e-6)
    theta = OMEGA * sol.time
    root = np.sqrt(L**2 - (R * np.sin(theta)) ** 2)
    assert np.abs(sol.array("slider.x") - R * np.cos(theta) - root).max() <= 1e-10
    speed = -OMEGA * R * np.sin(theta) * (1.0 + R * np.cos(theta) / root)
    assert np.abs(sol.array("slider.vx") - speed).max() <= 1e-10 * OMEGA
    # the largest acceleration stands at the outer dead centre, r w^2 (1 + r/l)
    assert sol.peak("slider.ax").value == pytest.approx(R * OMEGA**2 * (1 + R / L), rel=1e-6)


def test_first_contact_after_free_flight_is_exact():
    """Until then nothing touches: contact at 2.27286e-4 s, closing at 4.385783 m/s, whatever the contact law."""
    sol = fm.simulate(slider_crank(clearance=0.5e-3), t_end=2.35e-4, save="steps", step=1e-8)
    depth = sol.array("B.penetration")
    k = int(np.argmax(depth > 0.0))
    share = depth[k] / (depth[k] - depth[k - 1])
    assert sol.time[k] - share * 1e-8 == pytest.approx(2.27286e-4, abs=2e-9)
    assert sol.array("B.penetration_rate")[k - 1] == pytest.approx(4.385783, rel=1e-4)


def test_worn_pin_shakes_the_slider():
    ideal, worn = (fm.simulate(slider_crank(clearance=c), periods=2).peak("slider.ax").value for c in (None, 0.5e-3))
    assert ideal == pytest.approx(19419.36, rel=1e-3)
    assert worn > 3.0 * ideal


def test_flexible_rod_is_the_uniform_bar_of_the_same_mass():
    rod = slider_crank(flexible=True).find("rod")
    own = rod.properties()
    assert own.mass == pytest.approx(0.21, rel=1e-12)
    assert own.inertia == pytest.approx(0.21 * 0.12**2 / 12, rel=1e-10)
    rigid = slider_crank(data=SliderCrankData(rod_inertia=None)).find("rod")
    assert rigid.inertia == pytest.approx(own.inertia, rel=1e-10)
    assert own.inertia / slider_crank().find("rod").inertia == pytest.approx(1.008, abs=1e-9)  # as the docstring says


def test_flexible_rod_runs_and_bends():
    sol = fm.simulate(slider_crank(flexible=True), periods=1)
    assert sol.ok, sol.status
    assert 1e-6 < sol.peak("rod.deflection").value < 1e-3


@pytest.mark.parametrize(
    ("keywords", "words"),
    [
        ({"data": SliderCrankData}, ["data", "SliderCrankData"]),
        ({"friction": 0.3}, ["slider_crank", "0.3", "friction"]),
        ({"clearance": -1e-4}, ["'B'", "-0.0001"]),
        ({"flexible": "yes"}, ["flexible", "True or False"]),
    ],
)
def test_refusals(keywords, words):
    with pytest.raises(fm.errors.InputError) as error:
        slider_crank(**keywords)
    assert all(word in str(error.value) for word in words)


def test_rod_shorter_than_the_crank_is_refused():
    with pytest.raises(fm.errors.InputError, match=r"rod is 0\.04 m; it must be longer than the crank"):
        SliderCrankData(rod=0.04)
