"""Equal bodies share their models, bases and matrices; what differs in any value does not."""

from dataclasses import replace

import numpy as np
import pytest

import flexmb as fm
from flexmb.elastic.reduced import reduced as shared

STEEL = fm.Material(young=2.1e11, density=7850.0, poisson=0.3)


def plane(name="rod", hole=0.01, at=(0.0, 0.0), angle=0.0, **options):
    """Equal numbers, but every time other objects."""
    mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.02, hole=hole, width=0.02, size=0.01)
    return fm.PlaneBody(name, mesh, at=at, angle=angle, thickness=0.01, material=STEEL, **options)


def beam(name="rod", **options):
    section = fm.Rectangle(width=0.01, height=0.02)
    values = {"section": section, "material": STEEL, "elements": 6} | options
    return fm.FlexibleLink(name, (0.1, 0.2), (0.5, 0.5), **values)


@pytest.fixture(autouse=True)
def nothing_kept(monkeypatch):
    for name in ("MODELS", "BASES", "ELEMENTS"):
        monkeypatch.setattr(shared, name, shared.Kept())


def made(*bodies):
    """Numbers of models, bases and elements that were computed for all bodies."""
    for body in bodies:
        _ = body.element
    return shared.MODELS.made, shared.BASES.made, shared.ELEMENTS.made


@pytest.mark.parametrize("body", [plane, beam])
def test_equal_bodies_are_computed_once(body):
    small = [fm.Reduced(body(name), modes=3) for name in ("first", "second", "third")]
    assert made(*small) == (1, 1, 1)
    assert [one.basis.model.label.split()[-1] for one in small] == ["'first'", "'second'", "'third'"]
    assert [one.shapes(fm.Mechanism("m", [one]))[0].part for one in small] == ["first", "second", "third"]


def test_plane_bodies_share_wherever_they_lie():
    here, there = fm.Reduced(plane(), modes=3), fm.Reduced(plane("other", at=(1.0, 2.0), angle=0.7), modes=3)
    assert made(here, there) == (1, 1, 1)
    first, second = there.nodes()[:2]
    assert (first.x, first.y, first.theta) == pytest.approx((1.0, 2.0, 0.7))
    assert np.hypot(second.x - first.x, second.y - first.y) == pytest.approx(0.12)


@pytest.mark.slow
def test_options_are_told_apart():
    body = plane()
    options = [{"modes": 3}, {"modes": 6}, {"modes": 3, "frame": "pin"}, {"modes": 3, "inertia_shapes": True}]
    assert made(*(fm.Reduced(body, **one) for one in options)) == (1, 4, 4)
    damped = [fm.Reduced(body, modes=3, damping=1e-5), fm.Reduced(body, modes=3, stiffening=False)]
    assert made(*damped, fm.Reduced(body, modes=3, damping_ratios=0.01)) == (1, 4, 7)
    assert made(fm.Reduced(body, pins=("end",))) == (2, 5, 8)


OTHERS = {
    "mesh": lambda: plane(hole=0.0101),
    "thickness": lambda: replace(plane(), thickness=0.011),
    "material": lambda: replace(plane(), material=replace(STEEL, density=7851.0)),
    "state": lambda: replace(plane(), state="strain"),
    "kind of pins": lambda: replace(plane(), interface="averaged"),
    "section": lambda: beam(section=fm.Rectangle(width=0.01, height=0.021)),
    "elements": lambda: beam(elements=7),
    "mass": lambda: beam(mass=1.0),
    "inertia of the pivot": lambda: beam(mass=1.0, pivot_inertia=1e-3),
    "shear": lambda: beam(shear=True),
    "turn": lambda: beam(turn=0.3),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    "case",
    [
        pytest.param(n, marks=pytest.mark.slow)
        if n in ("state", "mesh", "thickness", "turn", "elements", "mass")
        else n
        for n in OTHERS
    ],
)
def test_bodies_that_differ_share_nothing(case):
    other = OTHERS[case]()
    same = plane() if isinstance(other, fm.PlaneBody) else beam()
    small, changed = fm.Reduced(same, modes=3), fm.Reduced(other, modes=3)
    assert made(small, changed) == (2, 2, 2)
    assert changed.frequencies(1)[0] != small.frequencies(1)[0]


def test_few_are_kept():
    bodies = [fm.Reduced(beam(elements=2 + k)) for k in range(shared.REMEMBERED + 1)]
    made(*bodies)
    assert made(fm.Reduced(beam(elements=3)))[0] == len(bodies)
    assert made(fm.Reduced(beam(elements=2)))[0] == len(bodies) + 1


def test_a_sweep_computes_the_basis_of_an_unchanged_body_once():
    def declared(force):
        small = fm.Reduced(plane(), modes=3)
        pull = fm.Force("pull", small, at=(0.12, 0.0), force=(0.0, force))
        return fm.Mechanism("held", [small, fm.Fixed("clamp", fm.GROUND, small, at=(0.0, 0.0)), pull])

    for force in (1.0, 2.0, 3.0):
        fm.simulate(declared(force), t_end=1e-6, step=1e-6)
    assert (shared.MODELS.made, shared.BASES.made, shared.ELEMENTS.made) == (1, 1, 1)
