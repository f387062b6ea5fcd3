"""All wrong arguments of a constructor are told at once, each once; an error alone reads as before."""

from dataclasses import dataclass

import pytest

import flexmb as fm
from flexmb.errors import InputError, ModelError


def message(make):
    """Text of the error of a constructor."""
    with pytest.raises(InputError) as caught:
        make()
    return str(caught.value)


def test_wrong_numbers_of_a_body_are_told_together():
    text = message(lambda: fm.RigidLink("rod", (0.0, 0.0), (1.0, 0.0), mass=-1.0, inertia=float("nan"), centre=2.0))
    assert "RigidLink 'rod': mass is -1 kg; it must be > 0." in text
    assert text.count("inertia is nan; it must be finite") == 1
    assert "centre is 2; it must lie between 0 and 1." in text


def test_one_wrong_number_is_one_sentence():
    text = message(lambda: fm.RigidLink("rod", (0.0, 0.0), (1.0, 0.0), mass=0.0, inertia=1.0))
    assert text == "RigidLink 'rod': mass is 0 kg; it must be > 0."


def test_what_follows_from_a_wrong_kind_is_not_told():
    """A text in place of a clearance cannot be compared with the radius: no TypeError."""
    body = fm.RigidLink("rod", (0.0, 0.0), (1.0, 0.0), mass=1.0, inertia=1.0)
    text = message(
        lambda: fm.RevoluteClearance(
            "A", fm.GROUND, body, at=(0.0, 0.0), clearance="small", bearing_radius=-1.0, normal=None
        )
    )
    assert "clearance is 'small'; it must be a number" in text
    assert "bearing_radius is -1" in text


@pytest.mark.parametrize(
    ("make", "names"),
    [
        (lambda: fm.Material(young=-1.0, density=0.0), ("young", "density")),
        (lambda: fm.Rectangle(width=0.0, height=-1.0), ("width", "height")),
        (lambda: fm.LankaraniNikravesh(-1.0, restitution=-3.0), ("stiffness", "restitution")),
        (lambda: fm.Adaptive(rtol=-1.0, max=0.0), ("rtol", "max")),
    ],
    ids=("material", "section", "law", "step"),
)
def test_laws_sections_materials_and_steps(make, names):
    text = message(make)
    assert all(f"{name} is " in text for name in names)


def test_a_part_of_ones_own_tells_all_its_errors():
    @dataclass(frozen=True)
    class Magnet(fm.Element):
        name: str
        body: fm.Part
        strength: float
        range: float
        coords = ("body.x",)

        @fm.element_kernel
        def kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
            r[0] = p[0] * q[0]

    body = fm.RigidBody("stone", (0.0, 0.0), 1.0, 1.0)
    text = message(lambda: Magnet("m", body, float("inf"), "far"))
    assert "strength is inf" in text
    assert "range is 'far'" in text


def test_the_next_object_begins_anew():
    message(lambda: fm.Rectangle(width=0.0, height=-1.0))
    assert fm.Rectangle(width=1.0, height=1.0).height == 1.0
    body = fm.RigidBody("stone", (0.0, 0.0), 1.0, 1.0)
    with pytest.raises(ModelError, match="joins 'stone' to itself"):
        fm.Revolute("O", body, body, at=(0.0, 0.0))
