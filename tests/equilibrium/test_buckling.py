"""Load factors beyond straight columns: loads of several kinds, signs, the sparse solver, and refusals."""

import math

import numpy as np
import pytest
from scipy.special import jv

import flexmb as fm
from flexmb.errors import InputError, ModelError, SolveError
from flexmb.statics import buckling as module

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


def test_joints_that_repeat_one_another_are_named():
    twice = cantilever(push)
    with pytest.raises(ModelError, match="'again'"):
        fm.buckling(twice.with_part(fm.Revolute("again", fm.GROUND, twice.find("beam"), at=(0.0, 0.0))))


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


@pytest.mark.parametrize("body", ["beam", "chord", "pin"])
def test_bending_before_does_not_make_a_column_buckle(body):
    """A hundredth of the load across the column bends it, and bending alone has no buckling load.

    Turning of the elements by the bending once gave 0.55 of Euler's load.
    """
    c, s = math.cos(0.4), math.sin(0.4)
    tip = (LENGTH * c, LENGTH * s)
    beam = fm.FlexibleLink("beam", (0.0, 0.0), tip, section=SECTION, material=MATERIAL, elements=8)
    column = beam if body == "beam" else fm.Reduced(beam, modes=6, frame=body)
    load = (-UNIT * (c + 0.01 * s), -UNIT * (s - 0.01 * c))
    parts = [column, fm.Fixed("foot", fm.GROUND, column, at=(0.0, 0.0)), fm.Force("P", column, tip, load)]
    found = fm.buckling(fm.Mechanism("column", parts), count=1)
    assert found.factors[0] == pytest.approx(math.pi**2 / 4, rel=2e-3)
    assert found.from_half == pytest.approx(found.factors[0], rel=0.05)
    assert not found.notes


def test_a_cantilever_that_only_bends_is_told():
    across = fm.buckling(cantilever(lambda beam, tip: fm.Force("P", beam, tip, (UNIT, 0.0))), count=1)
    (note,) = across.notes
    assert note.startswith(f"The load factor {across.factors[0]:.6g} is no buckling load to rely on: ")
    assert str(across).endswith(note)
    assert "not to be relied on" in repr(across)
    assert note.partition(":")[0] in across._repr_html_()


def frame(points, pairs, joint, feet, load):
    """Bars of length 1 with EI = 1 and a force on the top of the first one."""
    material, section = fm.Material(young=1e9, density=1.0), fm.GeneralSection(area=1e-3, second_moment=1e-9)
    bars = fm.FlexibleFrame("bars", points, pairs, section=section, material=material, elements=6)
    parts = [joint(f"foot{k}", fm.GROUND, bars, at=foot) for k, foot in enumerate(feet)]
    parts += [fm.Force(f"P{k}", bars, at, force) for k, (at, force) in enumerate(load)]
    return fm.Mechanism("frame", [bars, *parts])


def test_an_l_frame_and_a_portal_frame():
    """Equal bars of length 1: (1 - x cot x)/x^2 = -1/3 for hinged feet, x cot x = -6 for clamped ones, P = x^2 EI.

    The bar that rests holds the top of the loaded one like a spring of 3 EI/L; the beam of a portal that sways, of 6.
    """
    from scipy.optimize import brentq

    knee = brentq(lambda x: (1.0 - x / math.tan(x)) / x**2 + 1.0 / 3.0, 3.3, 4.3) ** 2
    sway = brentq(lambda x: x / math.tan(x) + 6.0, 2.0, 3.0) ** 2
    top = ((0.0, 1.0), (0.0, -1.0))
    corner = frame([(0, 0), (0, 1), (1, 1)], [(0, 1), (1, 2)], fm.Revolute, [(0, 0), (1, 1)], [top])
    points, sides = [(0, 0), (0, 1), (1, 1), (1, 0)], [(0, 1), (1, 2), (2, 3)]
    portal = frame(points, sides, fm.Fixed, [(0, 0), (1, 0)], [top, ((1.0, 1.0), (0.0, -1.0))])
    wind = frame(points, sides, fm.Fixed, [(0, 0), (1, 0)], [((0.0, 1.0), (0.05, -1.0)), ((1.0, 1.0), (0.05, -1.0))])
    for mechanism, load in ((corner, knee), (portal, sway), (wind, sway)):
        found = fm.buckling(mechanism, count=1)
        assert found.factors[0] == pytest.approx(load, rel=3e-3)
        assert not found.notes


OUTLINE = [(-0.04, 0), (0.04, 0), (0.04, 0.16), (0.02, 0.16), (0.02, 0.04), (-0.02, 0.04), (-0.02, 0.16), (-0.04, 0.16)]


def fork(force, *, reduced=False):
    """A fork with one loaded prong, clamped at its foot."""
    holes = {"foot": ((0.0, 0.02), 0.008), "left": ((-0.03, 0.15), 0.004), "right": ((0.03, 0.15), 0.004)}
    mesh = fm.meshes.plate_with_holes(OUTLINE, holes, size=0.012, kind="tri6")
    steel = fm.Material(young=2.1e11, density=7850.0, poisson=0.3)
    full = fm.PlaneBody("fork", mesh, thickness=0.01, material=steel, stress=False)
    body = fm.Reduced(full, modes=6) if reduced else full
    foot = fm.Fixed("foot", fm.GROUND, body, at=(0.0, 0.02))
    return fm.Mechanism("fork", [body, foot, fm.Force("F", body, (-0.03, 0.15), force)])


@pytest.mark.slow
def test_a_fork_and_a_reduced_one_buckle_alike():
    """Stiffness that owes itself to turning once gave 17.8 with all nodes and 21.4 reduced under the force along the
    prong, 0.72 and 2.05 under one across it, which the fork bears without buckling.
    """
    along = [fm.buckling(fork((0.0, -1e4), reduced=reduced), count=1) for reduced in (False, True)]
    assert along[1].factors[0] == pytest.approx(along[0].factors[0], rel=0.01)
    assert not any(found.notes for found in along)
    across = [fm.buckling(fork((1e4, 0.0), reduced=reduced), count=1) for reduced in (False, True)]
    assert all(found.factors[0] > 10.0 for found in across)
    assert all("no buckling load to rely on" in found.notes[0] for found in across)
