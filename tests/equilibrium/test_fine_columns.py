"""Buckling loads of columns and frames with many elements, with and without shear; closed forms and matrices."""

import math

import numpy as np
import pytest
import scipy.linalg as la

import flexmb as fm

YOUNG, POISSON, WIDTH = 2e11, 0.3, 0.01
STEEL = fm.Material(young=YOUNG, density=7800.0, poisson=POISSON)


def column(ratio, elements, *, shear=False, load=1.0):
    """A column of length 1, clamped at its foot; the same as half of one with hinged ends that is twice as long."""
    section = fm.Rectangle(width=WIDTH, height=1.0 / ratio)
    bar = fm.FlexibleLink("bar", (0, 0), (0, 1), section=section, material=STEEL, elements=elements, shear=shear)
    parts = [bar, fm.Fixed("foot", fm.GROUND, bar, at=(0, 0)), fm.Force("P", bar, (0, 1), (0.0, -load))]
    return fm.Mechanism("column", parts)


def euler(ratio):
    return math.pi**2 / 4.0 * YOUNG * WIDTH / ratio**3 / 12.0


def haringx(ratio):
    """P = S/2 (sqrt(1 + 4 P_E/S) - 1), from V = EI psi'^2/2 + S (w' - psi)^2/2 - P (w' psi - psi^2/2) with sines.

    S = k G A (1 - 2 P/EA): the elongation of an element holds a share of the shear force, see equation (2.16).
    """
    P, area = euler(ratio), WIDTH / ratio
    stiff = 10.0 * (1 + POISSON) / (12.0 + 11.0 * POISSON) * YOUNG / (2.0 * (1.0 + POISSON)) * area
    bend, found = P, P
    for _ in range(60):
        S = stiff * (1.0 - 2.0 * found / (YOUNG * area))
        found = 0.5 * S * (math.sqrt(1.0 + 4.0 * bend / S) - 1.0)
    return found


@pytest.mark.quick(1)
@pytest.mark.parametrize("ratio", [5, 10, 20, 40])
def test_eulers_load_with_any_number_of_elements(ratio):
    """Two elements in a quarter of a wave: errors fall with the fourth power, to the round-off of fine ones.

    They grew with the number: .67 of Euler's load with 96 elements and hinged ends, length over height 10.
    """
    factors = [fm.buckling(column(ratio, n), count=1).factors[0] / euler(ratio) - 1.0 for n in (2, 4, 8, 32, 96)]
    orders = np.log2(np.array(factors[:2]) / np.array(factors[1:3]))
    np.testing.assert_allclose(orders, 4.0, atol=0.05)
    assert 0.0 < factors[2] < 3e-6
    assert abs(factors[3]) < 1e-7
    assert abs(factors[4]) < 1e-7


@pytest.mark.quick(1)
@pytest.mark.parametrize("ratio", [4, 5, 10, 20])
def test_shear_lowers_the_buckling_load(ratio):
    """Haringx's load, of Reissner's beam without its compression: hinged ends, length over height 8 to 40; order 2."""
    factors = [fm.buckling(column(ratio, n, shear=True), count=1).factors[0] / haringx(ratio) - 1 for n in (8, 32, 96)]
    assert abs(factors[0]) < 2e-4
    assert abs(factors[1]) < 2e-5
    assert abs(factors[2]) < 3e-6
    assert haringx(ratio) < euler(ratio) / (1.0 + 0.02 * (8.0 / ratio) ** 2 / 4.0)


def bar_matrices(start, end, stiff, bend, axial):
    """K and K_G of a bar with a normal force, in the order x1, y1, theta1, x2, y2, theta2 (Cook et al. 2002, 18.2)."""
    L, (c, s) = math.dist(start, end), np.subtract(end, start) / math.dist(start, end)
    cubic = np.array([[12, 6 * L, -12, 6 * L], [6 * L, 4 * L**2, -6 * L, 2 * L**2]])
    slopes = np.array([[36, 3 * L, -36, 3 * L], [3 * L, 4 * L**2, -3 * L, -(L**2)]])
    K, K_G = np.zeros((6, 6)), np.zeros((6, 6))
    for place, form, scale in ((K, cubic, bend / L**3), (K_G, slopes, axial / (30.0 * L))):
        rows = np.array([form[0], form[1], -form[0], form[1, [0, 3, 2, 1]]])
        place[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = scale * rows
    K[np.ix_([0, 3], [0, 3])] = stiff / L * np.array([[1, -1], [-1, 1]])
    turn = la.block_diag(*[np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])] * 2)
    return turn.T @ K @ turn, turn.T @ K_G @ turn


def test_a_portal_with_many_elements():
    """Clamped feet, length over height 10, 16 elements a bar; it was 10.7 % too low, without a note."""
    EI, EA, n = 1.0, 1200.0, 16
    corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)]
    material, section = fm.Material(young=1e9, density=1.0), fm.GeneralSection(area=EA / 1e9, second_moment=EI / 1e9)
    sides = [(0, 1), (1, 2), (2, 3)]
    bars = fm.FlexibleFrame("bars", corners, sides, section=section, material=material, elements=n)
    feet = [fm.Fixed(f"foot{k}", fm.GROUND, bars, at=corners[k]) for k in (0, 3)]
    push = [fm.Force(f"P{k}", bars, corners[k], (0.0, -1.0)) for k in (1, 2)]
    found = fm.buckling(fm.Mechanism("portal", [bars, *feet, *push]), count=1)
    points = np.vstack([np.linspace(corners[a], corners[b], n + 1)[:-1] for a, b in sides] + [corners[3]])
    K, K_G = (np.zeros((3 * len(points), 3 * len(points))) for _ in range(2))
    for e in range(len(points) - 1):
        own = slice(3 * e, 3 * e + 6)
        k, k_G = bar_matrices(points[e], points[e + 1], EA, EI, 0.0 if n <= e < 2 * n else -1.0)
        K[own, own] += k
        K_G[own, own] += k_G
    free = slice(3, -3)
    exact = 1.0 / la.eigh(-K_G[free, free], K[free, free], eigvals_only=True)[-1]
    assert found.factors[0] == pytest.approx(exact, rel=1e-5)
    assert not found.notes


def test_the_check_shows_the_margin_of_a_fine_column():
    """It printed 1/1.01 for 1/1.13."""
    findings = fm.check(column(10, 96, load=euler(10) / 1.13)).findings
    (text,) = [one.text for one in findings if one.code == "near-buckling"]
    assert text.startswith("The loads are 1/1.13 of the buckling load")


def test_loads_that_bend_little_take_one_load_step():
    """A spinning arm, and a beam under its weight: ten steps gave the same at ten times the cost."""
    arm = fm.FlexibleLink("arm", (0.1, 0), (1, 0), section=fm.Rectangle(0.01, 0.02), material=STEEL, elements=20)
    hub = fm.Fixed("hub", fm.GROUND, arm, at=(0.1, 0.0))
    bent = fm.Mechanism("arm", [arm, hub], gravity=(0.0, -9.81))
    for mechanism, spin in ((fm.Mechanism("arm", [arm, hub]), 150.0), (bent, 0.0)):
        found = fm.static_equilibrium(mechanism, spin=spin)
        exact = fm.static_equilibrium(mechanism, load_steps=1, spin=spin)
        assert found.iterations == exact.iterations <= 6
        np.testing.assert_allclose(found.q, exact.q, rtol=1e-12, atol=1e-12)


def test_loads_that_bend_much_take_shorter_steps():
    """A cantilever rolled up by a moment to half a circle: M = pi EI/L, its tip at (0, 2 L/pi)."""
    thin = fm.Rectangle(width=0.01, height=0.002)
    rod = fm.FlexibleLink("rod", (0, 0), (1, 0), section=thin, material=STEEL, elements=40)
    moment = math.pi * YOUNG * 0.01 * 0.002**3 / 12.0
    parts = [rod, fm.Fixed("foot", fm.GROUND, rod, at=(0, 0)), fm.Torque("M", rod, moment, at=(1.0, 0.0))]
    found = fm.static_equilibrium(fm.Mechanism("rod", parts))
    assert found["rod.end.theta"] == pytest.approx(math.pi, rel=1e-4)
    assert (found["rod.end.x"], found["rod.end.y"]) == pytest.approx((0.0, 2.0 / math.pi), abs=1e-3)


@pytest.mark.slow
def test_a_body_that_nothing_holds_is_named():
    """Without any stiffness the answer was: use more load steps."""
    body = fm.RigidBody("body", (0.0, 0.0), mass=1.0, inertia=1.0)
    with pytest.raises(fm.errors.SolveError, match="a motion that moves 'body"):
        fm.static_equilibrium(fm.Mechanism("falling", [body], gravity=(0.0, -9.81)))


@pytest.mark.parametrize(("formulation", "low", "high"), [("corotated", 1.0, 1.034), ("total-lagrange", 0.985, 1.0)])
def test_a_thick_strut_as_a_mesh(formulation, low, high):
    """Against Haringx's load, hinged length over height 8: docs/theory/equilibrium.md says how far each is off."""
    mesh = fm.meshes.rectangle(1.0, 0.25, 8, 2)
    place = {"at": (0.125, 0.0), "angle": math.pi / 2, "pins": ("left", "right")}
    strut = fm.PlaneBody("strut", mesh, thickness=WIDTH, material=STEEL, formulation=formulation, **place)
    parts = [strut, fm.Fixed("foot", fm.GROUND, strut, at=(0, 0)), fm.Force("P", strut, (0, 1), (0.0, -1.0))]
    found = fm.buckling(fm.Mechanism("strut", parts), count=1).factors[0]
    assert low < found / haringx(4) < high
    reduced = fm.Reduced(strut, modes=8)
    parts = [reduced, fm.Fixed("foot", fm.GROUND, reduced, at=(0, 0)), fm.Force("P", reduced, (0, 1), (0.0, -1.0))]
    found = fm.buckling(fm.Mechanism("strut", parts), count=1).factors[0]
    assert found / haringx(4) == pytest.approx(1.010, abs=2e-3)
