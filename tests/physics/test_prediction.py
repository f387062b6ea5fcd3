"""What a step is begun with, and how little a smooth one costs."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.engine.newmark.predictor import lagrange_weights
from flexmb.engine.state.flow import Predictor


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_a_prediction_of_some_order_meets_every_polynomial_of_that_degree(order):
    """With unequal steps: states at 0, -0.7, -1.7 and -3.2, predicted at 1.3."""
    prediction = Predictor(order=order, past_states=4, second_last_step=1.0, third_last_step=1.5)
    found = np.array(lagrange_weights(order, 1.3, 0.7, prediction))
    for degree in range(order + 1):
        states = np.array([0.0, -0.7, -1.7, -3.2]) ** degree
        assert found @ states == pytest.approx(1.3**degree, rel=1e-13)
    assert (found[order + 1 :] == 0.0).all()


def slider_crank():
    """Crank 50 mm, rod 120 mm, 5000 rpm, rigid."""
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.05, 0.0), 0.30, 1e-5)
    rod = fm.RigidLink("rod", (0.05, 0.0), (0.17, 0.0), 0.21, 2.5e-4)
    slider = fm.RigidBody("slider", (0.17, 0.0), 0.14, 1e-4)
    joints = (
        fm.Revolute("A", fm.GROUND, crank, (0.0, 0.0)),
        fm.Revolute("B", crank, rod, (0.05, 0.0)),
        fm.Revolute("C", rod, slider, (0.17, 0.0)),
        fm.Prismatic("guide", fm.GROUND, slider),
        fm.Drive("motor", "A", fm.ConstantSpeed(5000 * math.pi / 30)),
    )
    return fm.Mechanism("slider-crank", (crank, rod, slider, *joints))


def test_a_smooth_step_needs_next_to_no_factors():
    """Two turns, with evaluations of residuals alone: two or three corrections, and the state that is accepted.

    That state is the closed form x = r cos phi + sqrt(l^2 - r^2 sin^2 phi).
    """
    sol = fm.simulate(slider_crank(), t_end=0.024, step=2e-5, save="steps")
    assert sol.stats.evaluations <= 4.0 * sol.stats.steps
    assert sol.stats.factorisations <= 0.2 * sol.stats.steps
    phi = sol.array("crank.theta")
    phi = phi - phi[0]
    exact = 0.05 * np.cos(phi) + np.sqrt(0.12**2 - (0.05 * np.sin(phi)) ** 2)
    np.testing.assert_allclose(sol.array("slider.x"), exact, rtol=0.0, atol=1e-12)


def test_waves_that_no_step_resolves_fold_no_beam():
    """A rod of 1,000 beams falls about a pin, in steps in which waves run along many of its beams.

    A step that begins with their accelerations ends at another solution of the equations: beams that are folded.  The
    rod moves as the same rod of 20 beams.
    """
    angles = []
    for elements in (20, 1000):
        section = fm.Rectangle(width=0.02, height=0.004)
        rod = fm.FlexibleLink(
            "rod", (0.0, 0.0), (0.4, 0.0), section=section, material=fm.Material(2.1e11, 7800.0), elements=elements
        )
        mechanism = fm.Mechanism("rod", (rod, fm.Revolute("pin", fm.GROUND, rod, (0.0, 0.0))), gravity=(0.0, -9.81))
        sol = fm.simulate(mechanism, t_end=0.1, step=1e-3, save="steps")
        assert sol.ok, sol.status
        assert sol.array("energy.strain").max() < 1e-2 * sol.array("energy.kinetic").max()
        angles.append(math.atan2(sol["rod.end.y"].values[-1], sol["rod.end.x"].values[-1]))
    assert angles[1] == pytest.approx(angles[0], rel=1e-3)


def test_beams_alone_count_as_short():
    """Bodies that a spring ties across a micron are no short beam, and round-off between two centres is no size."""
    link = fm.FlexibleLink(
        "link",
        (0.0, 0.0),
        (0.4, 0.0),
        section=fm.Rectangle(0.02, 0.004),
        material=fm.Material(2.1e11, 7800.0),
        elements=8,
    )
    a, b = (fm.RigidBody(name, (0.1, y), 1.0, 0.1) for name, y in (("a", 0.0), ("b", 1e-6)))
    tie = fm.SpringDamper("tie", a, b, at=a.at, to=b.at, stiffness=1e3, free_length=1e-6)
    assert fm.compile(fm.Mechanism("bodies", [a, b, tie])).shortest == pytest.approx(1e-6)  # the size of all there is
    both = fm.compile(fm.Mechanism("beams", [link, a, b, tie]))
    assert both.shortest == pytest.approx(0.05)
    centres = [fm.RigidBody(name, (x, 0.0), 1.0, 0.1) for name, x in (("c", 0.3), ("d", 0.1 + 0.2))]
    assert fm.compile(fm.Mechanism("coaxial", centres)).length == pytest.approx(0.3)
