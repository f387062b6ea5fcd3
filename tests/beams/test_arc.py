"""Arcs as the unstressed shape of beams: geometry, mass, drawing, wrong input, turns of smooth curves."""

import math
import re

import numpy as np
import pytest

import flexmb as fm
from flexmb.bodies import smooth_turns
from flexmb.elastic.beams import fem as hermite
from flexmb.errors import InputError
from flexmb.model.shape import from_json, to_json
from flexmb.results.positions import unstressed

MATERIAL = fm.Material(young=2.1e11, density=7850.0, poisson=0.3)
SECTION = fm.Rectangle(width=0.1, height=0.02)
R = 0.8


def arc(turn=1.2, start=0.3, elements=4, **options):
    """A link along the circle of radius R about (0.1, -0.2), from the angle `start` on."""
    first, last = (on_circle(angle) for angle in (start, start + turn))
    return fm.FlexibleLink(
        "arc", first, last, section=SECTION, material=MATERIAL, elements=elements, turn=turn, **options
    )


def on_circle(angle):
    return (0.1 + R * math.cos(angle), -0.2 + R * math.sin(angle))


@pytest.mark.parametrize("turn", [1.2, -1.2, 3.5, -6.0, 1e-9])
def test_nodes_lie_on_the_circle_and_look_along_it(turn):
    link = arc(turn, elements=(0.2, 0.5, 0.9))
    for node, s in zip(link.nodes(), (0.0, 0.2, 0.5, 0.9, 1.0), strict=True):
        angle = 0.3 + s * turn
        radius = R if turn > 0.0 else -R
        centre = np.array([0.1, -0.2])
        assert np.hypot(node.x - 0.1, node.y + 0.2) == pytest.approx(R, rel=1e-12)
        np.testing.assert_allclose([node.x, node.y], on_circle(angle), atol=1e-9)
        look = np.array([math.cos(node.theta), math.sin(node.theta)])
        normal = np.array([-look[1], look[0]])  # points to the centre of an arc that turns left
        np.testing.assert_allclose(
            np.array([node.x, node.y]) + radius * normal, centre, atol=1e-6 if turn == 1e-9 else 1e-12
        )
    assert link.beams[0].length == pytest.approx(R * abs(turn), rel=1e-6)


def test_a_frame_has_the_same_nodes():
    link = arc()
    frame = fm.FlexibleFrame(
        "frame", (link.start, link.end), ((0, 1),), section=SECTION, material=MATERIAL, elements=4, turns=(1.2,)
    )
    found = {(round(n.x, 12), round(n.y, 12)) for n in frame.nodes()}
    assert found == {(round(n.x, 12), round(n.y, 12)) for n in link.nodes()}


@pytest.mark.parametrize("shear", [False, True])
def test_mass_centre_and_inertia_converge_with_the_fourth_power(shear):
    turn, exact = 2.0, 7850.0 * 0.002 * R * 2.0
    errors = []
    for n in (4, 8, 16):
        found = arc(turn, elements=n, shear=shear).properties()
        out = R * math.sin(0.5 * turn) / (0.5 * turn)
        centre = np.array([0.1, -0.2]) + out * np.array([math.cos(0.3 + 1.0), math.sin(0.3 + 1.0)])
        inertia = exact * (R**2 - out**2)
        if shear:  # rho I of the sections
            inertia += 7850.0 * 0.1 * 0.02**3 / 12.0 * R * turn
        assert found.mass == pytest.approx(exact, rel=1e-12)
        errors.append((float(np.hypot(*(np.array(found.centre) - centre))) / R, abs(found.inertia / inertia - 1.0)))
    orders = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
    assert orders.min() > 3.8, orders


def test_drawn_elements_follow_the_circle_and_bear_nothing():
    """The cubic between two nodes leaves the circle by the fourth power of its turn."""
    xi, off = np.linspace(0.0, 1.0, 21), []
    for n in (4, 8, 16):
        link = arc(elements=n)
        nodes = {node.name: np.array([node.x, node.y, node.theta]) for node in link.nodes()}
        worst = 0.0
        for shape in link.shapes(fm.Mechanism("arc", [link])):
            ends = nodes[shape.start], nodes[shape.end]
            points = hermite.element_shape(*ends, shape, xi)[0]
            worst = max(worst, np.abs(np.hypot(*(points - (0.1, -0.2)).T) / R - 1.0).max())
            forces = hermite.section_forces(*ends, shape, xi)
            assert max(np.abs(f).max() for f in forces) < 1e-9 * 2.1e11 * 0.002
            assert np.abs(hermite.curvature(*ends, shape, xi)).max() < 1e-12
        off.append(worst)
    assert np.log2(np.array(off[:-1]) / off[1:]).min() > 3.8, off


def test_the_unstressed_shape_of_drawing_records_is_the_arc():
    link = arc(elements=5, shear=True)
    nodes = {node.name: node for node in link.nodes()}
    found = unstressed(list(link.shapes(fm.Mechanism("arc", [link]))))
    first = nodes["node0"]
    c, s = math.cos(first.theta), math.sin(first.theta)
    for name, (x, y, theta) in found.items():
        node = nodes[name]
        moved = (first.x + c * x - s * y, first.y + s * x + c * y, first.theta + theta)
        np.testing.assert_allclose(moved, (node.x, node.y, node.theta), atol=1e-14)


def test_strains_of_a_bent_arc():
    """A quarter ring bent to another radius by end moments: strain c (1/r - 1/R), no axial strain."""
    link = arc(0.5 * math.pi, start=0.0, elements=8)
    load = 40.0
    moment = fm.Torque("M", link, load, at=link.end)
    clamp = fm.Fixed("clamp", fm.GROUND, link, at=link.start)
    bent = fm.Mechanism("bent", [link, clamp, moment])
    found = fm.static_equilibrium(bent)
    assert link.strain_at_rest(bent, found)[0] == pytest.approx(0.01 * load / (2.1e11 * 0.1 * 0.02**3 / 12.0), rel=1e-4)
    turned = load * R * 0.5 * math.pi / (2.1e11 * 0.1 * 0.02**3 / 12.0)
    assert found["arc.end.theta"] == pytest.approx(math.pi + turned, rel=1e-9)


def test_drawing_records_of_arcs_survive_a_file():
    link = arc(shear=True)
    shapes = link.shapes(fm.Mechanism("arc", [link]))
    assert from_json(to_json(shapes)) == shapes
    assert shapes[0].unstressed is not None


def test_a_nearly_closed_arc_is_no_stubby_beam():
    link = arc(turn=6.0, elements=16)
    report = fm.check(fm.Mechanism("arc", [link, fm.Fixed("clamp", fm.GROUND, link, at=link.start)]))
    assert "stubby-beam" not in {finding.code for finding in report.findings}


# Turns of smooth curves


def test_turns_through_points_of_a_circle():
    angles = 2.0 * math.pi * np.arange(12) / 12
    ring = smooth_turns(np.column_stack([np.cos(angles), np.sin(angles)]), closed=True)
    np.testing.assert_allclose(ring, 2.0 * math.pi / 12, rtol=1e-12)
    errors = []
    for n in (8, 16, 32):
        angles = np.linspace(0.2, 2.0, n + 1)
        turns = smooth_turns([(math.cos(a), math.sin(a)) for a in angles])
        errors.append(np.abs(np.array(turns) - 1.8 / n).max())
    assert np.log2(np.array(errors[:-1]) / errors[1:]).min() > 2.9


def test_a_line_does_not_turn():
    assert smooth_turns([(0.0, 0.0), (1.0, 2.0)]) == (0.0,)
    np.testing.assert_allclose(smooth_turns([(0.0, 0.0), (1.0, 2.0), (1.5, 3.0), (4.0, 8.0)]), 0.0, atol=1e-14)


def test_an_elliptic_arch_converges():
    """Tip of a clamped quarter of an ellipse under a small force, against Mohr's integral over the exact curve."""
    a, b, EI, EA = 1.0, 0.5, 2.1e11 * 0.1 * 0.02**3 / 12.0, 2.1e11 * 0.002
    t = (np.polynomial.legendre.leggauss(60)[0] + 1.0) * 0.25 * math.pi
    weights = np.polynomial.legendre.leggauss(60)[1] * 0.25 * math.pi
    speed = np.hypot(a * np.sin(t), b * np.cos(t))
    # a unit force downwards at (0, b): moment x, axial force -dy/ds
    exact = weights @ (speed * ((a * np.cos(t)) ** 2 / EI + (b * np.cos(t) / speed) ** 2 / EA))
    errors = []
    for n in (8, 16, 32):
        angles = np.linspace(0.0, 0.5 * math.pi, n + 1)
        points = [(a * math.cos(u), b * math.sin(u)) for u in angles]
        edges = [(k, k + 1) for k in range(n)]
        frame = fm.FlexibleFrame(
            "arch", points, edges, section=SECTION, material=MATERIAL, elements=1, turns=smooth_turns(points)
        )
        parts = [frame, fm.Fixed("clamp", fm.GROUND, frame, at=points[0])]
        loads = [fm.Force("P", frame, at=points[-1], force=(0.0, -load)) for load in (0.1, -0.1)]
        up, down = (fm.static_equilibrium(fm.Mechanism("arch", [*parts, load]), load_steps=1) for load in loads)
        errors.append(abs((down[f"arch.node{n}.y"] - up[f"arch.node{n}.y"]) / 0.2 / exact - 1.0))
    assert errors[-1] < 2e-5
    assert np.log2(np.array(errors[:-1]) / errors[1:]).min() > 1.9, errors


# Wrong input


def frame(**options):
    return fm.FlexibleFrame(
        "frame", ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)), ((0, 1), (1, 2)), section=SECTION, material=MATERIAL, **options
    )


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: arc(turn=1.0, mass=30.0), "FlexibleLink 'arc': mass and inertia are for straight links"),
        (
            lambda: arc(turn=6.3),
            "FlexibleLink 'arc': turn is 6.3 rad; an arc between two points turns by less than 2 pi",
        ),
        (lambda: arc(turn=math.nan), "FlexibleLink 'arc': "),
        (lambda: frame(turns=90.0), "FlexibleFrame 'frame': turns is 90 rad; an arc"),
        (lambda: frame(turns=(0.1,)), "FlexibleFrame 'frame': 1 turns for 2 edges; give one each."),
        (lambda: frame(turns=(0.1, 7.0)), "FlexibleFrame 'frame': turns[1] is 7 rad; an arc"),
        (lambda: frame(turns="round"), "FlexibleFrame 'frame': turns is 'round'; it must be a number in rad."),
        (lambda: smooth_turns([(0.0, 0.0)]), "smooth_turns: 1 points make no curve; give at least 2."),
        (lambda: smooth_turns([(0.0, 0.0), (1.0, 0.0)], closed=True), "smooth_turns: 2 points make no curve; give at"),
        (
            lambda: smooth_turns([(0.0, 0.0), (1.0, 0.0), (1.0, 0.0)]),
            "smooth_turns: points[1] and the next one are both",
        ),
        (lambda: smooth_turns([(0.0, 0.0), (1.0, 0.0), (0.0, 0.1)]), "smooth_turns: from points["),
        (lambda: smooth_turns(3), "smooth_turns: points is 3; it must be a list of points (x, y)."),
    ],
)
def test_wrong_arcs_are_told(make, text):
    with pytest.raises(InputError, match=re.escape(text)):
        make()
