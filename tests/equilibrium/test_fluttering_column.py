"""Flutter of a finely divided column, by the sparse eigensolver of damped modes."""

import math

import pytest

import flexmb as fm
from flexmb.statics import eigen

LENGTH, SIDE, DEPTH = 1.0, 0.02, 0.01
STEEL = fm.Material(2.1e11, 7850.0)
EI, LINE_MASS = STEEL.young * SIDE * DEPTH**3 / 12.0, STEEL.density * SIDE * DEPTH


def fluttering(elements, count):
    """Eigenvalues over sqrt(EI/(m L^4)) at 20.5 EI/L^2, a little above the flutter load."""
    rod = fm.FlexibleLink(
        "rod", (0, 0), (0, LENGTH), section=fm.Rectangle(SIDE, DEPTH), material=STEEL, elements=elements
    )
    clamp = fm.Fixed("clamp", fm.GROUND, rod, at=(0, 0))
    load = fm.Force("load", rod, (0, LENGTH), (0.0, -20.5 * EI / LENGTH**2), follower=True)
    column = fm.Mechanism("column", [rod, clamp, load])
    found = fm.modes(column, count=count, at=fm.static_equilibrium(column), damped=True).eigenvalues
    return found / math.sqrt(EI / (LINE_MASS * LENGTH**4))


def test_becks_column_of_600_elements_flutters_as_one_of_12(monkeypatch):
    """With some 100 solutions by the factors; once it took a minute of them, since speeds outweighed displacements."""
    solutions, find = [], eigen.largest_of
    monkeypatch.setattr(eigen, "largest_of", lambda f, *rest: find(lambda x: solutions.append(1) or f(x), *rest))
    fine = fluttering(600, 4)
    assert 0 < len(solutions) < 500
    coarse = fluttering(12, 4)
    assert abs(fine[0].real) == pytest.approx(abs(coarse[0].real), rel=2e-3)
    assert fine.imag == pytest.approx(coarse.imag, rel=2e-3)
    assert fine[0].real == pytest.approx(-fine[1].real, rel=1e-6)
    assert abs(fine[2:].real).max() < 1e-8 * fine.imag.max()
