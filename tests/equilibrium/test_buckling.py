"""Load factors beyond straight columns: loads of several kinds, signs, the sparse solver, and refusals."""

import math

import numpy as np
import pytest
from scipy.special import jv

import flexmb as fm
from flexmb.equilibrium import buckling as module
from flexmb.errors import InputError, SolveError

LENGTH, EI = 2.0, 3.0
MATERIAL = fm.Material(young=1e9, density=1000.0)
SECTION = fm.GeneralSection(area=0.1, second_moment=EI / 1e9)
UNIT = EI / LENGTH**2


def cantilever(*loads, elements=8, gravity=(0.0, 0.0), joint=fm.Fixed):
    beam = fm.FlexibleLink("beam", (0.0, 0.0), (0.0, LENGTH), section=SECTION, material=MATERIAL, elements=elements)
    tip = [load(beam, (0.0, LENGTH)) for load in loads]
    return fm.Mechanism("cantilever", [beam, joint("foot", fm.GROUND, beam, at=(0.0, 0.0)), *tip], gravity=gravity)


def push(beam, tip):
    return fm.Force("P", beam, tip, (0.0, -UNIT))


def pull(beam, tip):
    return fm.Force("P", beam, tip, (0.0, UNIT))


def test_a_column_under_its_own_weight():
    """q L^3/EI = 7.837, from the first root of J_{-1/3}(2/3 sqrt(q L^3/EI)): Greenhill 1881."""
    from scipy.optimize import brentq

    critical = (1.5 * brentq(lambda x: jv(-1 / 3, x), 1.5, 2.2)) ** 2
    assert critical == pytest.approx(7.837, abs=5e-4)
    found = fm.buckling(cantilever(gravity=(0.0, -1.0), elements=16), count=1)
    weight = 1000.0 * 0.1
    assert found.factors[0] * weight * LENGTH**3 / EI == pytest.approx(critical, rel=1e-3)


def test_reversed_loads_have_negative_factors():
    up, down = fm.buckling(cantilever(pull), count=2), fm.buckling(cantilever(push), count=2)
    assert (up.factors < 0.0).all()
    assert len(up.factors) == 2
    np.testing.assert_allclose(up.factors, -down.factors[:2], rtol=1e-9)
    assert down.factors[1] == pytest.approx(9 * math.pi**2 / 4, rel=5e-4)


def test_the_factor_is_where_the_lowest_frequency_vanishes():
    """Exact for a straight column: the lowest omega^2 about the equilibrium changes its sign at the factor."""
    factor = fm.buckling(cantilever(push), count=1).factors[0]
    for share, stable in ((0.9999, True), (1.0001, False)):
        loaded = cantilever(push).with_({"P.force": (0.0, -share * factor * UNIT)})
        lowest = fm.modes(loaded, count=1, at=fm.static_equilibrium(loaded, load_steps=1)).frequencies[0]
        assert (lowest > 0.0) == stable


def test_spring_of_a_rigid_bar():
    """P = k/L: a rigid bar on a hinge with a torsion spring; the load's own stiffness is all there is."""
    bar = fm.RigidLink("bar", (0.0, 0.0), (0.0, LENGTH), 1.0, 1.0)
    hinge = fm.Revolute("O", fm.GROUND, bar, at=(0.0, 0.0))
    spring = fm.TorsionSpring("k", fm.GROUND, bar, stiffness=7.0)
    found = fm.buckling(fm.Mechanism("bar", [bar, hinge, spring, fm.Force("P", bar, (0.0, LENGTH), (0.0, -1.0))]))
    assert list(found.factors) == pytest.approx([7.0 / LENGTH], rel=1e-10)
    assert found.moves == ("bar.theta",)


def test_multipliers_have_stiffness():
    """Two rigid links, one on the other: the multipliers of the hinge between them tip the lower one.

    Equal links a, springs k at both hinges: (P a/k)^2 - 3 P a/k + 1 = 0, from the potential
    V = k/2 (t1^2 + (t2 - t1)^2) - P a/2 (t1^2 + t2^2).
    """
    a, k = 0.7, 5.0
    low = fm.RigidLink("low", (0.0, 0.0), (0.0, a), 1.0, 1.0)
    high = fm.RigidLink("high", (0.0, a), (0.0, 2 * a), 1.0, 1.0)
    parts = [
        low,
        high,
        fm.Revolute("O", fm.GROUND, low, at=(0.0, 0.0)),
        fm.Revolute("A", low, high, at=(0.0, a)),
        fm.TorsionSpring("k1", fm.GROUND, low, stiffness=k),
        fm.TorsionSpring("k2", low, high, stiffness=k),
        fm.Force("P", high, (0.0, 2 * a), (0.0, -1.0)),
    ]
    found = fm.buckling(fm.Mechanism("links", parts))
    np.testing.assert_allclose(found.factors, (3 + np.array([-1, 1]) * math.sqrt(5)) / 2 * k / a, rtol=1e-9)
    # the lower shape: t2/t1 = 1/(1 - P a/k) = golden ratio
    assert found.shape(0, "high.theta") / found.shape(0, "low.theta") == pytest.approx((1 + math.sqrt(5)) / 2, rel=1e-9)


def test_the_sparse_solver_agrees(monkeypatch):
    dense = fm.buckling(cantilever(push), count=3)
    monkeypatch.setattr(module, "DENSE_COORDINATES", 0)
    sparse = fm.buckling(cantilever(push), count=3)
    np.testing.assert_allclose(sparse.factors[:3], dense.factors[:3], rtol=1e-7)


def test_the_table():
    lines = str(fm.buckling(cantilever(push), count=1)).splitlines()
    assert lines[0] == "shape  load factor  moves most"
    assert lines[1].split()[2] in {"beam.node8.x", "beam.node8.theta"}


def test_no_load():
    with pytest.raises(InputError, match=r"buckling: mechanism 'cantilever' has no load. Add a Force"):
        fm.buckling(cantilever())


def test_nothing_holds_the_column():
    with pytest.raises(SolveError, match=r"'beam.node\d.\w+' most is resisted by nothing"):
        fm.buckling(cantilever(push, joint=fm.Revolute))


def test_a_stressed_spring_is_refused():
    stressed = cantilever(push)
    beam = stressed.find("beam")
    spring = fm.SpringDamper("k", fm.GROUND, beam, (1.0, LENGTH), (0.0, LENGTH), stiffness=1.0, free_length=0.5)
    with pytest.raises(InputError, match=r"without its loads mechanism 'cantilever' does not rest.*free length"):
        fm.buckling(stressed.with_part(spring))


@pytest.mark.parametrize("count", [0, 1.5])
def test_count_is_a_whole_number(count):
    with pytest.raises(InputError, match="buckling: count is"):
        fm.buckling(cantilever(push), count=count)
