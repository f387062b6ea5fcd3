"""Large models: few solutions, multiple eigenvalues, unstable poses."""

import numpy as np
import pytest

import flexmb as fm
from flexmb.statics import buckling as buckling_module
from flexmb.statics import eigen

STEEL = fm.Material(young=2.07e11, density=7850.0)
SECTION = fm.Rectangle(width=0.01, height=0.01)


def columns(count, *, elements, height=1.0, load=-1.0):
    """Equal columns side by side, clamped below, pressed from above."""
    parts = []
    for k in range(count):
        foot, head = (0.1 * k, 0.0), (0.1 * k, height)
        link = fm.FlexibleLink(f"c{k}", foot, head, section=SECTION, material=STEEL, elements=elements)
        parts += [link, fm.Fixed(f"J{k}", fm.GROUND, link, at=foot)]
        parts += [fm.Force(f"P{k}", link, at=head, force=(0.0, load))] if load else []
    return parts


def chain_on_springs(links):
    """A clamped and hinged chain whose links vibrate across at nearly one frequency."""
    parts, before = [], fm.GROUND
    for k in range(links):
        start, end = (0.1 * k, 0.0), (0.1 * (k + 1), 0.0)
        link = fm.FlexibleLink(f"L{k}", start, end, section=SECTION, material=STEEL, elements=4)
        joint = (fm.Revolute if k % 2 else fm.Fixed)(f"J{k}", before, link, at=start)
        parts += [link, joint, fm.SpringDamper(f"s{k}", fm.GROUND, link, (end[0], -0.1), end, stiffness=1e5)]
        before = link
    return fm.Mechanism("chain", [*parts, fm.Force("P", before, at=end, force=(-1.0, 0.0))])


@pytest.fixture
def solutions(monkeypatch):
    """Number of solutions of the eigensolvers."""
    found, own = [], eigen.solver

    def counted(A, order):
        solve = own(A, order)
        return lambda b: found.append(1) or solve(b)

    monkeypatch.setattr(eigen, "solver", counted)
    monkeypatch.setattr(buckling_module, "solver", counted)
    return found


def test_equal_bodies_have_equal_modes(solutions):
    one = fm.modes(fm.Mechanism("one", columns(1, elements=12, load=0.0)), count=3)
    many = fm.modes(fm.Mechanism("many", columns(10, elements=12, load=0.0)), count=25)
    assert len(many.names) > eigen.FEW_MODES_COORDINATES
    assert many.frequencies == pytest.approx(np.repeat(one.frequencies, 10)[:25], rel=1e-7)
    assert len(solutions) <= 600


@pytest.mark.slow
def test_modes_below_a_cluster_take_few_solutions(solutions):
    """700 modes across follow at 179 Hz: telling them apart takes thousands of solutions, counting them two factors."""
    chain = chain_on_springs(700)
    found = fm.modes(chain, count=4)
    assert len(solutions) <= 100
    n, along = 700 * 5, 5.1e3  # sound in a bar of steel with a clamped and a free end, sqrt(E/rho)
    assert len(found.names) > n
    expected = np.sqrt(STEEL.young / STEEL.density) / (4.0 * 70.0) * np.array([1, 3, 5, 7])
    assert np.sqrt(STEEL.young / STEEL.density) == pytest.approx(along, rel=0.01)
    assert found.frequencies == pytest.approx(expected, rel=1e-3)


def test_an_unstable_motion_far_from_zero_comes_first():
    """A bar on its tip beside a long column, whose modes are nearer to zero."""
    bar = fm.RigidBody("bar", at=(5.0, 1e-3), mass=1.0, inertia=1e-9)
    parts = [*columns(1, elements=120, height=5.0, load=0.0), bar, fm.Revolute("O", fm.GROUND, bar, at=(5.0, 0.0))]
    mech = fm.Mechanism("both", parts, gravity=(0.0, -9.81))
    balance = fm.static_equilibrium(mech)
    assert not balance.stable
    found = fm.modes(mech, count=3, at=balance)
    assert found.kinds[0] == "unstable"
    expected = -np.sqrt(9.81 * 1e-3 / (1e-6 + 1e-9)) / (2.0 * np.pi)
    assert found.frequencies[0] == pytest.approx(expected, rel=1e-9)
    assert (found.frequencies[1:] > 0.0).all()


def test_equal_columns_buckle_at_equal_loads(monkeypatch, solutions):
    monkeypatch.setattr(buckling_module, "DENSE_COORDINATES", 0)
    one = fm.buckling(fm.Mechanism("one", columns(1, elements=8)), count=2)
    assert one.factors[0] == pytest.approx(np.pi**2 / 4.0 * STEEL.young * 0.01**4 / 12.0, rel=1e-4)
    three = fm.buckling(fm.Mechanism("three", columns(3, elements=8)), count=5)
    assert three.factors[:5] == pytest.approx(np.repeat(one.factors[:2], 3)[:5], rel=1e-7)
    assert len(solutions) <= 600


def test_a_part_that_refers_to_a_load_is_refused():
    bar = fm.RigidBody("bar", at=(0.0, 0.0), mass=1.0, inertia=1.0)
    mech = fm.Mechanism("m", [bar, fm.Revolute("O", fm.GROUND, bar, at=(0.0, 0.0))])
    with pytest.raises(fm.errors.ModelError, match="refers to 'bar'"):
        mech.with_loads(mech.parts[1:], (0.0, 0.0))


def test_one_degree_of_freedom_of_many_coordinates():
    """A pendulum of 110 bars that are welded together, with a spring at its hinge."""
    bars, parts = 110, []
    for k in range(bars):
        ends = (0.01 * k, 0.0), (0.01 * (k + 1), 0.0)
        bar = fm.RigidLink(f"b{k}", *ends, mass=0.1, inertia=0.1 * 0.01**2 / 12.0)
        parts += [
            bar,
            fm.Fixed(f"J{k}", parts[-2], bar, at=ends[0]) if k else fm.Revolute("J0", fm.GROUND, bar, at=(0, 0)),
        ]
    parts.append(fm.TorsionSpring("s", fm.GROUND, parts[0], stiffness=10.0))
    found = fm.modes(fm.Mechanism("welded", parts), count=3)
    assert len(found.names) > eigen.FEW_MODES_COORDINATES
    length, mass = 0.01 * bars, 0.1 * bars
    assert found.frequencies == pytest.approx([np.sqrt(10.0 / (mass * length**2 / 3.0)) / (2.0 * np.pi)], rel=1e-9)
