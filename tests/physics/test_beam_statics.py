"""Static deflection of beams: one linear element, the elastica, roll-up to a circle."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.engine.system.state_evaluation import StateEvaluation

LENGTH, WIDTH, HEIGHT, YOUNG = 2.0, 0.02, 0.01, 2.0e11
EA, EI = YOUNG * WIDTH * HEIGHT, YOUNG * WIDTH * HEIGHT**3 / 12.0
STEEL = fm.Material(young=YOUNG, density=7850.0)

ELASTICA = {
    1: (0.301720773800, 0.0564332362834, 0.461351949712),
    2: (0.493457480397, 0.160641720825, 0.781749831557),
    4: (0.669964181278, 0.328941242247, 1.12123934749),
    6: (0.744571148890, 0.434588828682, 1.28369728580),
    8: (0.784982374953, 0.504827732134, 1.37443150670),
    10: (0.810609024880, 0.554995597754, 1.43028553880),
}
"""k = P L^2/(EI) of a dead load across a clamped, inextensible beam -> deflection of the tip across and along the
beam over L, angle of the tip.  Exact (elliptic integrals): K. E. Bisshopp, D. C. Drucker, Large deflection of
cantilever beams, Quarterly of Applied Mathematics 3 (1945) 272-275."""


def cantilever(*loads, elements=16, height=HEIGHT, angle=0.0, gravity=(0.0, 0.0)):
    """A clamped beam in direction `angle`; a load is a function of (beam, tip)."""
    tip = (LENGTH * math.cos(angle), LENGTH * math.sin(angle))
    section = fm.Rectangle(width=WIDTH, height=height)
    beam = fm.FlexibleLink("beam", (0.0, 0.0), tip, section=section, material=STEEL, elements=elements)
    clamp = fm.Fixed("clamp", fm.GROUND, beam, (0.0, 0.0))
    return fm.Mechanism("cantilever", (beam, clamp, *(load(beam, tip) for load in loads)), gravity=gravity)


@pytest.mark.parametrize("angle", [0.0, 1.1, -2.6])
def test_one_element_bends_and_stretches_as_the_textbook_says(angle):
    """P L^3/(3 EI), P L^2/(2 EI), M L^2/(2 EI), M L/(EI), N L/(EA): exact for a cubic element."""
    system = StateEvaluation(fm.compile(cantilever(elements=1, angle=angle)))
    K = system.at(system.program.reference.q, weights=(1.0, 0.0, 0.0)).block().toarray()[3:6, 3:6]
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    flexibility = turn @ np.linalg.inv(K) @ turn.T
    exact = np.array(
        [
            [LENGTH / EA, 0, 0],
            [0, LENGTH**3 / (3 * EI), LENGTH**2 / (2 * EI)],
            [0, LENGTH**2 / (2 * EI), LENGTH / EI],
        ]
    )
    scale = np.sqrt(np.outer(np.diag(exact), np.diag(exact)))
    assert (np.abs(flexibility - exact) / scale).max() < 1e-10


def test_a_small_load_bends_by_the_linear_formula():
    """The whole way: load, equilibrium, named coordinate.  The nonlinear part is of relative order (w/L)^2 = 1e-12."""
    load = 1e-6 * 3 * EI / LENGTH**2
    found = fm.static_equilibrium(cantilever(lambda b, t: fm.Force("P", b, t, (0.0, load)), elements=1), load_steps=1)
    assert found["beam.end.y"] == pytest.approx(load * LENGTH**3 / (3 * EI), rel=1e-9)
    assert found["beam.end.theta"] == pytest.approx(load * LENGTH**2 / (2 * EI), rel=1e-9)


@pytest.mark.parametrize("k", ELASTICA)
def test_elastica_under_a_dead_tip_load(k):
    """Sixteen elements, 1e-4.  The beam is so thin (h/L = 1/2000) that its stretch does not count."""
    height = LENGTH / 2000
    load = k * YOUNG * WIDTH * height**3 / 12.0 / LENGTH**2
    mechanism = cantilever(lambda b, t: fm.Force("P", b, t, (0.0, load)), height=height)
    found = fm.static_equilibrium(mechanism)
    across, along, angle = ELASTICA[k]
    assert found["beam.end.y"] / LENGTH == pytest.approx(across, abs=1e-4)
    assert 1.0 - found["beam.end.x"] / LENGTH == pytest.approx(along, abs=1e-4)
    assert found["beam.end.theta"] == pytest.approx(angle, abs=1e-4)
    np.testing.assert_allclose(found.force("clamp"), (0.0, -load, -load * found["beam.end.x"]), atol=1e-6 * load)


def test_elastica_converges_at_second_order_or_better():
    height, k = LENGTH / 2000, 10
    load = k * YOUNG * WIDTH * height**3 / 12.0 / LENGTH**2
    errors = []
    for n in (8, 16, 32):
        mechanism = cantilever(lambda b, t: fm.Force("P", b, t, (0.0, load)), height=height, elements=n)
        errors.append(abs(fm.static_equilibrium(mechanism)["beam.end.y"] / LENGTH - ELASTICA[k][0]))
    assert math.log2(errors[0] / errors[1]) > 1.9
    assert math.log2(errors[1] / errors[2]) > 1.9


@pytest.mark.quick(1)
@pytest.mark.parametrize("turns", [0.5, 1.0, 2.0])
def test_end_moment_rolls_the_beam_up_to_a_circle(turns):
    """x = EI/M sin(M L/EI), y = EI/M (1 - cos(M L/EI)); the angle at a fraction s is s M L/EI."""
    moment = 2 * math.pi * turns * EI / LENGTH
    found = fm.static_equilibrium(cantilever(lambda b, t: fm.Torque("M", b, moment, t), elements=32), load_steps=20)
    radius = EI / moment
    for node in range(33):
        angle = 2 * math.pi * turns * node / 32
        assert found[f"beam.node{node}.theta"] == pytest.approx(angle, abs=1e-9)
        # a chord of the element is shorter than that of the arc by (half its angle)^4/120 of itself
        limit = 2 * LENGTH * (math.pi * turns / 32) ** 4 / 120 + 1e-9
        assert found[f"beam.node{node}.x"] == pytest.approx(radius * math.sin(angle), abs=limit)
        assert found[f"beam.node{node}.y"] == pytest.approx(radius * (1 - math.cos(angle)), abs=limit)
    if turns == 1.0:
        assert math.hypot(found["beam.end.x"], found["beam.end.y"]) < 1e-9 * LENGTH


def test_own_weight_of_a_cantilever():
    """q L^4/(8 EI) at the tip, q L and q L^2/2 at the clamp; weak gravity keeps it linear.

    A cubic element carries its weight by consistent loads, so the nodes of a linear beam are exact.
    """
    g = 1e-5
    found = fm.static_equilibrium(cantilever(elements=2, gravity=(0.0, -g)), load_steps=1)
    weight = 7850.0 * WIDTH * HEIGHT * g
    assert found["beam.end.y"] == pytest.approx(-weight * LENGTH**4 / (8 * EI), rel=1e-8)
    assert found["beam.end.theta"] == pytest.approx(-weight * LENGTH**3 / (6 * EI), rel=1e-8)
    fx, fy, moment = found.force("clamp")
    assert fy == pytest.approx(weight * LENGTH, rel=1e-9)
    assert moment == pytest.approx(weight * LENGTH**2 / 2, rel=1e-8)
    assert abs(fx) < 1e-6 * weight * LENGTH
