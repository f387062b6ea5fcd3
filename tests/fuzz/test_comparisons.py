"""Random combinations of parts agree with themselves: whatever is saved, in any view, by any method.

A difference is a fault where no note or status tells it.
"""

import math
import sys
import warnings
from pathlib import Path

import pytest
from cases import slow_where

sys.path.insert(0, str(Path(__file__).resolve().parent))

import comparisons

import flexmb as fm

QUICK, ALL = (6, 9, 15), range(100)

KNOWN: dict[int, str] = {}
"""Combinations with a difference whose cause is known, by their seeds."""


def cases():
    """All seeds but the quick ones, the known ones as failures that are expected."""
    for seed in ALL:
        if seed not in QUICK:
            marks = [pytest.mark.xfail(reason=KNOWN[seed], strict=True)] if seed in KNOWN else []
            yield pytest.param(seed, marks=marks)


def agree(seed):
    """Compare a combination with itself."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        _, found = comparisons.compared(seed)
    untold = [f"{one.kind}: {one.text}" for one in found if not one.told]
    assert not untold, "\n".join(untold)


@pytest.mark.parametrize("seed", slow_where(lambda n: n != 6, QUICK))
def test_a_combination_agrees_with_itself(seed):
    agree(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", list(cases()))
def test_one_of_a_hundred_combinations_agrees_with_itself(seed):
    agree(seed)


def test_links_that_closing_leaves_free_stand_alike_in_all_units():
    """A bar on a crank whose drive begins at .3 rad: its angle at the start does not depend on the unit of length."""
    angles = []
    for unit in (1.0, 1000.0):
        crank = fm.RigidLink("crank", (0.0, 0.0), (0.2 * unit, 0.0), mass=1.0, inertia=4e-3 * unit**2)
        bar = fm.RigidLink("bar", (0.2 * unit, 0.0), (0.4 * unit, 0.0), mass=1.0, inertia=4e-3 * unit**2)
        motion = fm.drives.Harmonic(0.3, 1.0, phase=0.5 * math.pi)
        model = fm.Mechanism("pendulum on a crank", [
            crank, bar, fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)),
            fm.Revolute("A", crank, bar, at=(0.2 * unit, 0.0)), fm.Drive("motor", "O", motion)
        ])  # fmt: skip
        angles.append(float(fm.simulate(model, t_end=0.01, save=1)["bar.theta"].values[0]))
    assert angles[1] == pytest.approx(angles[0], abs=1e-9)


def test_a_bump_stop_may_be_wider_than_two_pi():
    block = fm.RigidBody("block", at=(0.0, 0.0), mass=1.0, inertia=1e-3)
    law = fm.KelvinVoigt(1e4, 1.0)
    stop = fm.Stop("stop", first=fm.GROUND, second=block, at=(0.0, 0.0), above=7.0, along=(1.0, 0.0), normal=law)
    guide = fm.Prismatic("guide", fm.GROUND, block, at=(0.0, 0.0))
    push = fm.Force("push", block, (0.0, 0.0), (1.0, 0.0))
    model = fm.Mechanism("bump", [block, guide, stop, push])
    assert fm.check(model).ok
    assert fm.simulate(model, t_end=0.1).ok
