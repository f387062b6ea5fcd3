"""`check` and `simulate` name the same joints where constraints repeat one another."""

import re

import pytest

import flexmb as fm
from flexmb.errors import AssemblyError, ModelError

O, A, B, D = (0.0, 0.0), (0.0, 0.2), (0.5, 0.2), (0.5, 0.0)


def parallelogram(third=False):
    ends = {"left": (O, A), "bar": (A, B), "right": (D, B)}
    links = {name: fm.RigidLink(name, *points, mass=0.5, inertia=2e-3) for name, points in ends.items()}
    left, bar, right = links.values()
    pins = [
        fm.Revolute("O", fm.GROUND, left, at=O), fm.Revolute("A", left, bar, at=A), fm.Revolute("B", bar, right, at=B),
        fm.Revolute("D", fm.GROUND, right, at=D), fm.Drive("motor", "O", fm.ConstantSpeed(1.0)),
    ]  # fmt: skip
    if third:
        middle = fm.RigidLink("middle", (0.25, 0.0), (0.25, 0.2), mass=0.5, inertia=2e-3)
        pins += [
            middle,
            fm.Revolute("E", fm.GROUND, middle, at=middle.start),
            fm.Revolute("F", middle, bar, at=middle.end),
        ]
    return [*links.values(), *pins]


def slides():
    block = fm.RigidBody("block", O, mass=1.0, inertia=0.1)
    guides = [fm.Prismatic(f"slide{k}", fm.GROUND, block, at=(0.0, 0.1 * k)) for k in range(2)]
    return [block, *guides, fm.Drive("push", "slide0", fm.ConstantSpeed(0.1))]


def two_motors():
    return [*parallelogram(), fm.Drive("second", "D", fm.ConstantSpeed(1.0))]


def dead_centre():
    """A slider-crank whose crank and slider are driven, in line."""
    crank = fm.RigidLink("crank", O, (0.1, 0.0), mass=1.0, inertia=1e-3)
    rod = fm.RigidLink("rod", (0.1, 0.0), (0.4, 0.0), mass=1.0, inertia=1e-3)
    slider = fm.RigidBody("slider", (0.4, 0.0), mass=1.0, inertia=1e-3)
    return [
        crank, rod, slider, fm.Revolute("O", fm.GROUND, crank, at=O), fm.Revolute("A", crank, rod, at=rod.start),
        fm.Revolute("B", rod, slider, at=rod.end), fm.Prismatic("guide", fm.GROUND, slider),
        fm.Drive("motor", "O", fm.ConstantSpeed(1.0)), fm.Drive("push", "guide", fm.ConstantSpeed(0.0)),
    ]  # fmt: skip


@pytest.mark.parametrize(
    "parts",
    [parallelogram(third=True), slides(), two_motors(), dead_centre()],
    ids=["third", "slides", "motors", "dead centre"],
)
def test_the_same_joints_are_named(parts):
    mech = fm.Mechanism("repeated", parts)
    with pytest.raises((ModelError, AssemblyError)) as refused:
        fm.simulate(mech, t_end=0.1)
    words = str(refused.value).partition("repeat one another")[0]
    told = set(re.findall(r"'(\w+)'", words)) - {"repeated"}
    codes = ("redundant-joints", "over-driven", "singular-pose")
    found = [finding for finding in fm.check(mech).findings if finding.code in codes]
    named = {name for finding in found for name in re.findall(r"'(\w+)'", finding.text)}
    assert found
    assert told == named
    assert set(fm.check(mech).redundant) <= named
