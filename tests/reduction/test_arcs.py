"""Arcs and bodies of arcs, reduced: the arc itself and closed forms."""

import math

import numpy as np
import pytest

import flexmb as fm

STEEL = fm.Material(young=2.1e11, density=7850.0, poisson=0.3)
SECTION = fm.Rectangle(width=0.1, height=0.02)
R = 0.8
EI, EA, PER_LENGTH = 2.1e11 * 0.1 * 0.02**3 / 12.0, 2.1e11 * 0.002, 7850.0 * 0.002


def quarter(start=0.3, elements=12, **options):
    """A quarter of a circle about (0.1, -0.2)."""
    first, last = ((0.1 + R * math.cos(a), -0.2 + R * math.sin(a)) for a in (start, start + 0.5 * math.pi))
    return fm.FlexibleLink(
        "arc", first, last, section=SECTION, material=STEEL, elements=elements, turn=0.5 * math.pi, **options
    )


def held(body, at, *more):
    return fm.Mechanism("held", [body, fm.Fixed("clamp", fm.GROUND, body, at=at), *more])


@pytest.mark.parametrize("shear", [pytest.param(False, marks=pytest.mark.slow), True])
def test_with_all_nodes_as_pins_nothing_is_lost(shear):
    """Stiffness and mass of all elements are those that the arc has for small displacements."""
    link = quarter(shear=shear)
    small = fm.Reduced(link, pins=[node.name for node in link.nodes()])
    ours, full = (fm.modes(held(body, link.start)).frequencies[:8] for body in (small, link))
    assert ours == pytest.approx(full, rel=1e-9)
    own, mass = link.properties(), small.element.matrices["M"]
    assert small.total_mass() == pytest.approx(own.mass, rel=1e-12)
    turned = np.array([v for n in small.basis.nodes for v in (-n.y, n.x, 1.0)])
    x, y = small.element.moment / own.mass
    assert turned @ mass @ turned - own.mass * (x * x + y * y) == pytest.approx(own.inertia, rel=1e-12)


def test_frequencies_fall_to_those_of_the_arc():
    link = quarter()
    full = fm.modes(held(link, link.start)).frequencies[:3]
    errors = [fm.modes(held(fm.Reduced(link, modes=k), link.start)).frequencies[:3] / full - 1.0 for k in (3, 6, 12)]
    assert np.all(np.array(errors) > 0.0)
    assert np.all(np.diff(errors, axis=0) < 0.0)
    assert max(errors[-1]) < 1e-5


def test_a_ring_has_the_frequencies_of_a_thin_ring():
    """In-plane vibrations with n waves: omega^2 = EI/(rho A R^4) n^2 (n^2 - 1)^2/(n^2 + 1), without extension."""
    angles = 2.0 * math.pi * np.arange(4) / 4
    points = [(R * math.cos(a), R * math.sin(a)) for a in angles]
    ring = fm.FlexibleFrame(
        "ring", points, [(0, 1), (1, 2), (2, 3), (3, 0)], section=SECTION, material=STEEL, elements=8, turns=math.pi / 2
    )
    n = np.array([2.0, 2.0, 3.0, 3.0])
    thin = np.sqrt(EI / (PER_LENGTH * R**4) * n**2 * (n**2 - 1.0) ** 2 / (n**2 + 1.0)) / (2.0 * math.pi)
    small = fm.Reduced(ring, modes=15)
    assert small.frequencies(4) == pytest.approx(thin, rel=1e-3)
    assert small.frequencies(4) == pytest.approx(fm.modes(fm.Mechanism("ring", [ring])).frequencies[3:7], rel=5e-4)


def test_statics_of_a_quarter_ring():
    """Radial force on the tip of a clamped quarter ring: radial deflection pi/4 P R^3/EI + pi/4 P R/EA, thin."""
    link = quarter(0.0, elements=16)
    small = fm.Reduced(link, modes=3)
    deflections = []
    for force in (1.0, -1.0):
        pull = fm.Force("P", small, at=link.end, force=(0.0, force))
        found = fm.static_equilibrium(held(small, link.start, pull), load_steps=1)
        deflections.append(found["arc.end.y"])
    thin = 0.25 * math.pi * (R**3 / EI + R / EA)
    assert 0.5 * (deflections[0] - deflections[1]) == pytest.approx(thin, rel=2e-4)


def stiffened(body, at, spin):
    """Changes of the squared frequencies by a slow turning about the origin, over its square [1]."""
    hub = fm.Clamp("hub", fm.GROUND, body, at=at, angle=fm.ConstantSpeed(spin))
    turning = fm.Mechanism("turning", [body, hub])
    still, fast = (
        fm.modes(turning, at=fm.static_equilibrium(turning, spin=s)).frequencies[:3] * 2.0 * math.pi
        for s in (0.0, spin)
    )
    return (fast**2 - still**2) / spin**2


@pytest.mark.slow
@pytest.mark.parametrize("frame", ["chord", "pin"])
def test_a_turning_arc_is_stiffened_as_it_is_with_all_nodes(frame):
    """Centrifugal forces bend an arc, so forces inside it count; those of the pins alone are of the wrong sign."""
    link = quarter()
    full = stiffened(link, link.start, 2.0)
    found = stiffened(fm.Reduced(link, modes=12, inertia_shapes=True, frame=frame), link.start, 2.0)
    assert found == pytest.approx(full, rel=0.02)
    pins_alone = stiffened(fm.Reduced(link, modes=12, frame=frame), link.start, 2.0)
    assert abs(pins_alone[1] / full[1] - 1.0) > 0.5


@pytest.mark.slow
def test_a_ring_that_is_clamped_to_its_axis():
    """The table of docs/theory/reduced.md: a quarter ring on a hub of radius 0."""
    link = fm.FlexibleLink("arc", (0.0, 0.0), (R, R), section=SECTION, material=STEEL, elements=12, turn=0.5 * math.pi)
    rows = (link, fm.Reduced(link, modes=12), fm.Reduced(link, modes=12, inertia_shapes=True))
    full, alone, found = (stiffened(body, link.start, 2.0) for body in rows)
    assert full == pytest.approx([0.0411, 8.06, 34.10], rel=2e-3)
    assert alone == pytest.approx([-0.0430, 17.3, 20.05], rel=2e-3)
    assert found == pytest.approx(full, rel=4e-3)


def test_drawn_sides_lie_on_two_circles():
    link = quarter()
    (shape,) = fm.Reduced(link, modes=3).shapes(fm.Mechanism("m", [link]))
    first = link.nodes()[0]
    c, s = math.cos(first.theta), math.sin(first.theta)
    x, y = np.array(shape.points).T
    radii = np.hypot(first.x + c * x - s * y - 0.1, first.y + s * x + c * y + 0.2)
    assert np.unique(np.round(radii, 5)).tolist() == pytest.approx([R - 0.01, R + 0.01], abs=1e-5)


def test_stresses_of_an_arc():
    """Clamped quarter ring under a moment M at its tip: stress by Winkler and Bach, r0 the radius without stress."""
    small = fm.Reduced(quarter(stress=True), modes=3)
    force = np.zeros(9)
    force[5] = 40.0
    d = np.concatenate([np.zeros(3), np.linalg.solve(small.element.matrices["K"][3:, 3:], force[3:])])
    along = small.model.stresses((small.basis.shapes @ d)[:, None])[:, 0, 0].reshape(-1, 2, 4)
    r0 = 0.02 / math.log((R + 0.01) / (R - 0.01))
    outer, inner = (40.0 * (r - r0) / (0.002 * (R - r0) * r) for r in (R + 0.01, R - 0.01))
    assert along[:, 0] == pytest.approx(np.full((12, 4), outer), rel=2e-4)
    assert along[:, 1] == pytest.approx(np.full((12, 4), inner), rel=2e-4)


def test_stresses_of_a_pulled_arc():
    """Quarter ring under a force at its tip: normal force and moment of statics, of coarse elements as well."""
    small, (P, Q) = fm.Reduced(quarter(elements=4, stress=True)), (7000.0, 500.0)
    d = np.concatenate([np.zeros(3), np.linalg.solve(small.element.matrices["K"][3:, 3:], [P, Q, 0.0])])
    along = small.model.stresses((small.basis.shapes @ d)[:, None])[:, 0, 0].reshape(-1, 2, 4)
    angles = (np.arange(4)[:, None] + np.arange(4) / 3.0) * math.pi / 8.0
    r0 = 0.02 / math.log((R + 0.01) / (R - 0.01))
    x, y = R * np.sin(angles), R * (1.0 - np.cos(angles))
    N, M = P * np.cos(angles) + Q * np.sin(angles), (R - x) * Q - (R - y) * P
    for side, r in enumerate((R + 0.01, R - 0.01)):
        wanted = N / 0.002 + M * (r - r0) / (0.002 * (R - r0) * r)
        assert along[:, side] == pytest.approx(wanted, abs=2e-3 * np.abs(wanted).max())
