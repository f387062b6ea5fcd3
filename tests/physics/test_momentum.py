"""Momenta and centre of mass against those of rigid bars, alone and together."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError

START, END, MASS, VELOCITY = (1.0, 0.5), (2.2, 1.4), 3.0, (0.7, -0.4, 2.0)
LENGTH, ELEMENTS = 1.5, 6
CENTRE = (1.6, 0.95)


def rod(**changes):
    section, steel_like = fm.Rectangle(width=0.02, height=0.02), fm.Material(2e9, 1000.0)
    options = {"section": section, "material": steel_like, "elements": ELEMENTS, "velocity": VELOCITY, **changes}
    return fm.FlexibleLink("rod", START, END, **options)


def flown(*parts, t_end=0.05, step=2.5e-4):
    mech = fm.Mechanism("flight", parts, gravity=(0.0, -9.81))
    return mech, fm.simulate(mech, t_end=t_end, step=step, save=10)


def test_a_rod_with_bosses_counts_as_the_rigid_bar_it_stands_for():
    """Mass, centre at 60 % of the length and inertia given; m v and r x m v + J omega of the bar about the origin."""
    centre, inertia = (START[0] + 0.6 * 1.2, START[1] + 0.6 * 0.9), 1.5
    moving = rod(mass=MASS, centre=0.6, inertia=inertia)
    mech, sol = flown(moving)
    found = fm.momentum(mech, sol)
    dx, dy = centre[0] - CENTRE[0], centre[1] - CENTRE[1]  # the velocity is that of the middle
    vx, vy = VELOCITY[0] - VELOCITY[2] * dy, VELOCITY[1] + VELOCITY[2] * dx
    assert found.mass == pytest.approx(MASS, rel=1e-12)
    np.testing.assert_allclose(found.centre[0], centre, rtol=1e-12)
    np.testing.assert_allclose(found.linear[0], [MASS * vx, MASS * vy], rtol=1e-12)
    spin = MASS * (centre[0] * vy - centre[1] * vx) + inertia * VELOCITY[2]
    assert found.angular[0] == pytest.approx(spin, rel=1e-12)


def test_the_centre_of_mass_of_a_falling_rod_flies_a_parabola():
    """To round-off: the rod stays straight, so its masses do not change."""
    mech, sol = flown(rod(), t_end=0.5)
    found = fm.momentum(mech, sol)
    t = found.time
    exact = np.stack([CENTRE[0] + VELOCITY[0] * t, CENTRE[1] + VELOCITY[1] * t - 0.5 * 9.81 * t**2], axis=1)
    np.testing.assert_allclose(found.centre, exact, rtol=0, atol=1e-11)
    assert np.ptp(sol.array("rod.theta")) > 0.9  # it turned


def test_bodies_are_counted_alone_or_together():
    ball = fm.RigidBody("ball", (4.0, -1.0), 0.5, 0.01, velocity=(0.0, 3.0, 7.0))
    mech, sol = flown(rod(), ball)
    one, two, both = (fm.momentum(mech, sol, names) for names in (("rod",), ("ball",), None))
    np.testing.assert_allclose(one.linear + two.linear, both.linear, rtol=1e-12)
    np.testing.assert_allclose(one.angular + two.angular, both.angular, rtol=1e-12)
    assert both.mass == pytest.approx(1000.0 * 4e-4 * LENGTH + 0.5, rel=1e-12)
    np.testing.assert_allclose(two.centre[0], (4.0, -1.0), rtol=1e-12)
    assert two.angular[0] == pytest.approx(4.0 * 0.5 * 3.0 + 0.01 * 7.0, rel=1e-12)


def test_what_does_not_fit_is_refused():
    mech, sol = flown(rod())
    with pytest.raises(InputError, match="Known: rod"):
        fm.momentum(mech, sol, ("rodd",))
    with pytest.raises(InputError, match="bodies is empty"):
        fm.momentum(mech, sol, ())
    with pytest.raises(InputError, match="other signals"):
        fm.momentum(mech.with_({"rod.elements": 2}), sol)
    with pytest.raises(InputError, match="parts with other numbers"):
        fm.momentum(flown(rod(material=fm.Material(2e9, 3000.0)), t_end=1e-3)[0], sol)


def test_length_of_the_rod_is_what_the_numbers_above_say():
    assert math.dist(START, END) == pytest.approx(LENGTH, rel=1e-15)
