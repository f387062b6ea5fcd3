"""The equations by hand against exact and converged values, and flexmb against them."""

import minimal
import models as m
import numpy as np
import pytest

import flexmb as fm

pytestmark = pytest.mark.filterwarnings("ignore::scipy.integrate.IntegrationWarning")


def test_free_slider_crank_keeps_its_energy():
    """From M theta'^2 = const alone: the time of an angle as a quadrature, against the equation of motion by scipy."""
    assert minimal.run_free("DOP853", 1e-12, 0.024) == pytest.approx(minimal.exact_angle(0.024), abs=1e-11)


def test_python_and_numba_sides_are_the_same():
    for mu in (0.0, 0.03):
        law, y = (5e-4, mu, 1.3), np.array([-0.1, 0.1632, -200.0, -3.0])
        t = 2.3e-4
        assert minimal.contact(t, y, *law) == pytest.approx(minimal.compiled()[2](t, y, *law), rel=1e-13)
        assert minimal.worn_rates(t, y, *law) == pytest.approx(minimal.compiled()[1](t, y, *law), rel=1e-13)


@pytest.mark.parametrize(("mu", "peak", "place"), [(0.0, 45872.0, 0.160926), (0.03, 45826.0, 0.160975)])
def test_first_impacts(mu, peak, place):
    """Values of another program for the same equations, steps of 1e-8 s."""
    found = minimal.worn_reference(mu, 1.5e-3)
    assert found["peak"] == pytest.approx(peak, rel=5e-5)
    assert found["first"] == pytest.approx(0.22729e-3, abs=5e-9)
    assert found["x1"] == pytest.approx(place, abs=1e-6)


def test_the_drive_torque_of_ideal_joints():
    theta = np.linspace(0.0, 2.0 * np.pi, 100_001)
    assert np.abs(m.ideal_torque(theta)).max() == pytest.approx(138.522, abs=1e-3)
    speed = np.gradient(m.ideal_position(theta), theta) * m.OMEGA
    assert np.abs(speed).max() == pytest.approx(28.4114, abs=1e-4)


def test_flexmb_converges_to_the_equations_by_hand():
    """Order 2 in the angle of the free slider-crank; 4 ms with impacts."""
    exact = minimal.exact_angle(0.024)
    errors = [
        abs(fm.simulate(m.ideal(driven=False), t_end=0.024, step=h, save=1).array("crank.theta")[-1] - exact)
        for h in (2e-5, 1e-5)
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)
    x = minimal.run_worn("DOP853", 1e-12, 4e-3, fast=True)[1]
    sol = fm.simulate(m.worn(0.0), t_end=4e-3, step=1e-6, save=1)
    assert sol.array("slider.x")[-1] == pytest.approx(x, abs=2e-6)
