"""Modes of poses that point along an axis, modes under loads, wrong arguments."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.statics import buckling

STEEL = fm.Material(young=207e9, density=7850.0, poisson=0.3)
ROUND = fm.Circle(0.01)


def link(end=(0.0, -1.0), **options):
    return fm.FlexibleLink("rod", (0.0, 0.0), end, section=ROUND, material=STEEL, **options)


def hinged(end, **options):
    rod = link(end, **options)
    return fm.Mechanism("hinged", (rod, fm.Revolute("O", fm.GROUND, rod, (0.0, 0.0))))


@pytest.mark.parametrize("end", [(1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (-1.0, 0.0), (1e-9, 1.0), (0.6, 0.8)])
@pytest.mark.parametrize("elements", [1, 8, 60])
def test_a_hinged_beam_turns_freely_wherever_it_points(end, elements):
    """Where a beam points along an axis, stiffnesses that should be 0 are the round-off of EA/L."""
    found = fm.modes(hinged(end, elements=elements), count=2)
    assert found.kinds[0] == "rigid: rotation of 'rod'"
    assert found.kinds[1] == "elastic"


@pytest.mark.parametrize("end", [(0.0, 1.0), (-1.0, 0.0)])
def test_a_weak_hinge_spring_is_still_seen_along_an_axis(end):
    """omega^2 = k/J, J = m L^2/3; 1e-3 N m against EA L = 1.6e7."""
    mech = hinged(end)
    spring = fm.TorsionSpring("k", fm.GROUND, mech.find("rod"), stiffness=1e-3, at=(0.0, 0.0))
    found = fm.modes(mech.with_part(spring), count=1)
    inertia = 7850.0 * math.pi * 0.01**2 / 4 / 3
    assert found.frequencies[0] == pytest.approx(math.sqrt(1e-3 / inertia) / (2 * math.pi), rel=1e-3)


def test_a_frame_on_a_hinge_turns_freely():
    points = ((0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0))
    frame = fm.FlexibleFrame("frame", points, ((0, 1), (1, 2), (2, 3)), section=ROUND, material=STEEL)
    mech = fm.Mechanism("gate", (frame, fm.Revolute("O", fm.GROUND, frame, (0.0, 0.0))))
    assert fm.modes(mech, count=2).kinds == ("rigid: rotation of 'frame'", "elastic")


@pytest.mark.parametrize("more", [{"gravity": (0.0, -9.81)}, {"gravity": (3.0, 9.81)}])
def test_gravity_does_not_upset_the_modes_of_the_drawn_pose(more):
    """Half of its stiffness, without that of the joint's force, made a hanging beam "unstable"."""
    found = fm.modes(hinged((0.0, -1.0)).with_(more), count=3)
    bare = fm.modes(hinged((0.0, -1.0)), count=3)
    assert found.kinds == bare.kinds
    assert list(found.frequencies) == list(bare.frequencies)


def test_a_force_on_an_arm_does_not_either():
    """A dead pull of 100 N along a rigid rod of 1 m alone would give omega^2 = 100/J, but so does its reaction."""
    rod = fm.RigidLink("rod", (0.0, 0.0), (1.0, 0.0), mass=1.0, inertia=0.1)
    parts = (rod, fm.Revolute("O", fm.GROUND, rod, (0.0, 0.0)), fm.Force("F", rod, (1.0, 0.0), (100.0, 0.0)))
    mech = fm.Mechanism("pulled", parts)
    assert fm.modes(mech).kinds == ("rigid: rotation of 'rod'",)
    loaded = fm.modes(mech, at=fm.static_equilibrium(mech))
    # about the pin: J = 0.1 + 1 * 0.5^2
    assert loaded.frequencies[0] == pytest.approx(math.sqrt(100.0 * 1.0 / 0.35) / (2 * math.pi), rel=1e-9)


def test_a_hanging_rod_at_its_equilibrium_swings():
    """omega^2 = m g (L/2)/(J + m L^2/4)."""
    rod = fm.RigidLink("rod", (0.0, 0.0), (0.0, -1.0), mass=1.0, inertia=0.1)
    mech = fm.Mechanism("hanging", (rod, fm.Revolute("O", fm.GROUND, rod, (0.0, 0.0))), gravity=(0.0, -9.81))
    found = fm.modes(mech, at=fm.static_equilibrium(mech))
    assert found.frequencies[0] == pytest.approx(math.sqrt(9.81 * 0.5 / 0.35) / (2 * math.pi), rel=1e-12)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda m: fm.modes(m, at="standing"), "at is 'standing'"),
        (lambda m: fm.modes(m, at=True), "at is True"),
        (lambda m: fm.modes(m, damped="no"), "damped is 'no'"),
        (lambda m: fm.modes("hinged"), "'hinged' is not a Mechanism"),
        (lambda m: fm.modes(m).shape(0.5, "rod.end.x"), "mode is 0.5"),
        (lambda m: fm.modes(m).shape("first", "rod.end.x"), "mode is 'first'"),
        (lambda m: fm.modes(m).shape(0, 3), "coordinate is 3"),
        (lambda m: fm.buckling(3), "3 is not a Mechanism"),
    ],
)
def test_wrong_arguments_are_named(call, text):
    with pytest.raises(fm.errors.InputError, match=text):
        call(hinged((1.0, 0.0)))


def cantilevers(count, elements, **options):
    """Equal beams side by side, pressed along their axes by 1 N each."""
    parts = []
    for k in range(count):
        at = (0.0, float(k))
        rod = fm.FlexibleLink(f"rod{k}", at, (1.0, k), section=ROUND, material=STEEL, elements=elements, **options)
        parts += [rod, fm.Fixed(f"F{k}", fm.GROUND, rod, at), fm.Force(f"P{k}", rod, (1.0, k), (-1.0, 0.0))]
    return fm.Mechanism("cantilevers", parts)


SLOWEST = 1.8751040687**2 / (2 * math.pi) * math.sqrt(207e9 * 0.01**2 / 16 / 7850.0)
EULER = math.pi**2 / 4 * 207e9 * math.pi * 0.01**4 / 64


@pytest.mark.parametrize("count", [2, 7])
def test_equal_bodies_have_equal_frequencies_each(count):
    """Iterative eigensolvers see one or two of several equal values."""
    found = fm.modes(cantilevers(count, 240 // count), count=count + 1)
    assert list(found.frequencies[:count]) == pytest.approx([SLOWEST] * count, rel=1e-6)
    assert found.frequencies[count] > 6.0 * SLOWEST
    mixed = found.shapes[:, :count]
    assert np.linalg.matrix_rank(mixed / np.abs(mixed).max(), tol=1e-6) == count


@pytest.mark.parametrize("count", [2, 5])
def test_equal_bodies_have_equal_damped_modes_each(count):
    """xi = zeta omega/2 of stiffness-proportional damping."""
    found = fm.modes(cantilevers(count, 100 // count, damping=1e-4), count=count + 1, damped=True)
    assert list(found.frequencies[:count]) == pytest.approx([SLOWEST] * count, rel=1e-5)
    assert list(found.damping[:count]) == pytest.approx([1e-4 * 2 * math.pi * SLOWEST / 2] * count, rel=1e-5)
    assert found.frequencies[count] > 6.0 * SLOWEST
    assert np.linalg.matrix_rank(found.shapes[:, :count], tol=1e-6) == count


def test_equal_columns_buckle_each(monkeypatch):
    monkeypatch.setattr(buckling, "DENSE_COORDINATES", 0)
    found = fm.buckling(cantilevers(5, 12), count=6)
    assert list(found.factors[:5]) == pytest.approx([EULER] * 5, rel=1e-4)
    assert found.factors[5] == pytest.approx(9.0 * EULER, rel=1e-2)
