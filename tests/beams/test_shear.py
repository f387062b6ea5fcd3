"""Beam matrices with shear against Przemieniecki's, virtual work, and the thin limit; shear factors."""

import math
import re

import meshio
import numpy as np
import pytest
from element_matrices import beam_matrices, mass_moments
from scipy.integrate import quad

import flexmb as fm
from flexmb.elastic.beams import fem as hermite
from flexmb.errors import InputError
from flexmb.parts.bodies.flexible import matrices

MATERIAL = fm.Material(young=2.1e11, density=7850.0, poisson=0.3)
G = 2.1e11 / 2.6
THICK = fm.Rectangle(width=0.1, height=0.2)
TAPERED = {
    "rectangle": fm.Tapered(fm.Rectangle(0.1, 0.3), fm.Rectangle(0.1, 0.15)),
    "tube": fm.Tapered(fm.Tube(outer=0.3, inner=0.2), fm.Tube(outer=0.2, inner=0.1)),
}
O, X = (0.0, 0.0), (1.0, 0.0)


def one(section=THICK, length=0.7, **options):
    return beam_matrices([0.0, length], section, MATERIAL, **{"shear": 5.0 / 6.0, "rotary_inertia": True, **options})


# Matrices of one element


def test_stiffness_is_przemienieckis():
    L, EI, shear = 0.7, 2.1e11 * 0.1 * 0.2**3 / 12.0, 5.0 / 6.0 * G * 0.02
    phi = 12.0 * EI / (shear * L**2)
    expected = np.array(
        [[12, 6 * L, -12, 6 * L], [6 * L, (4 + phi) * L**2, -6 * L, (2 - phi) * L**2],
         [-12, -6 * L, 12, -6 * L], [6 * L, (2 - phi) * L**2, -6 * L, (4 + phi) * L**2]]
    )  # fmt: skip
    np.testing.assert_allclose(one().bending_stiffness[0], EI / (L**3 * (1.0 + phi)) * expected, rtol=1e-12)


def test_mass_and_rotary_inertia_are_przemienieckis():
    """His equations (11.40): translation and rotation of sections, in the order w1, theta1, w2, theta2."""
    L, rho_a, rho_i = 0.7, 7850.0 * 0.02, 7850.0 * 0.1 * 0.2**3 / 12.0
    p = 12.0 * 2.1e11 * 0.1 * 0.2**3 / 12.0 / (5.0 / 6.0 * G * 0.02 * L**2)
    a, b = 13 / 35 + 7 * p / 10 + p**2 / 3, (11 / 210 + 11 * p / 120 + p**2 / 24) * L
    c, d = 9 / 70 + 3 * p / 10 + p**2 / 6, (13 / 420 + 3 * p / 40 + p**2 / 24) * L
    e, f = (1 / 105 + p / 60 + p**2 / 120) * L**2, (1 / 140 + p / 60 + p**2 / 120) * L**2
    moved = np.array([[a, b, c, -d], [b, e, d, -f], [c, d, a, -b], [-d, -f, -b, e]])
    k, m = (1 / 10 - p / 2) * L, (2 / 15 + p / 6 + p**2 / 3) * L**2
    n = (-1 / 30 - p / 6 + p**2 / 6) * L**2
    turned = np.array([[6 / 5, k, -6 / 5, k], [k, m, -k, n], [-6 / 5, -k, 6 / 5, -k], [k, n, -k, m]])
    data, scale = one(), (1.0 + p) ** 2
    np.testing.assert_allclose(data.rotary_mass[0], rho_i / (L * scale) * turned, rtol=1e-11)
    expected = rho_a * L / scale * moved + rho_i / (L * scale) * turned
    np.testing.assert_allclose(data.bending_mass[0], expected, rtol=1e-11)


@pytest.mark.parametrize("section", [THICK, *TAPERED.values()])
def test_rigid_motions_bend_nothing_and_have_the_momenta_of_the_bar(section):
    sheared, plain = one(section, shear=True), one(section, shear=False)
    for motion in ([1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.7, 1.0]):
        assert np.abs(sheared.bending_stiffness[0] @ motion).max() < 1e-12 * sheared.bending_stiffness.max()
        for a, b in ((sheared.bending_mass, plain.bending_mass), (sheared.rotary_mass, plain.rotary_mass)):
            np.testing.assert_allclose(motion @ a[0] @ motion, motion @ b[0] @ motion, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("slenderness", [1e2, 1e3, 1e4, 1e5])
def test_thin_beams_are_those_without_shear(slenderness):
    """The difference falls with (h/L)^2, down to round-off: no locking."""
    section = fm.Rectangle(0.1, 1.0 / slenderness)
    sheared, plain = (beam_matrices([0.0, 1.0], section, MATERIAL, shear=k) for k in (True, False))
    phi = 12.0 * plain.ei[0, 0] / (10.0 * 1.3 / 15.3 * G * 0.1 / slenderness)
    for name in ("bending_stiffness", "bending_mass", "bow"):
        a, b = getattr(sheared, name), getattr(plain, name)
        # bow: 2 - 3 c with c = phi/2; a relative change of 1.5 phi at most in stiffness, 3.5 phi elsewhere
        assert np.abs(a - b).max() <= (3.5 * phi + 1e-15) * np.abs(b).max(), name
        assert np.abs(a - b).max() >= 0.1 * phi * np.abs(b).max(), name


def test_no_shear_has_no_trace():
    sheared, plain = one(shear=False), beam_matrices([0.0, 0.7], THICK, MATERIAL, rotary_inertia=True)
    assert sheared.bending_stiffness.tobytes() == plain.bending_stiffness.tobytes()
    np.testing.assert_array_equal(plain.bow, [[2.0, 1.0, 2.0]])
    np.testing.assert_array_equal(plain.shear_shares, [[0.0, 0.0]])


def test_one_mesh_for_beams_with_and_without_shear():
    plain = fm.FlexibleLink("plain", O, X, section=THICK, material=MATERIAL, elements=3)
    sheared = fm.FlexibleLink("sheared", O, X, section=THICK, material=MATERIAL, elements=3, shear=True)
    fm.compile(fm.Mechanism("both", [plain, sheared]))
    for link, shear in ((plain, False), (sheared, True)):
        alone = beam_matrices(link.beams[0].stations, THICK, MATERIAL, shear=shear, rotary_inertia=shear)
        together = matrices(link.beams[0])
        for name in ("bending_stiffness", "bending_mass", "rotary_mass", "bow", "shear_shares"):
            np.testing.assert_array_equal(getattr(together, name), getattr(alone, name))


# Tapered beams


def flexibility(section, factor):
    """Displacement and rotation of the tip of a cantilever of 1 m under a unit force, by virtual work."""

    def bend(x):
        return (1.0 - x) / (2.1e11 * float(section.second_moment_at(x)))

    def slide(x):
        return 1.0 / (float(factor(x)) * G * float(section.area_at(x)))

    limits = {"epsabs": 0.0, "epsrel": 1e-13}
    across = quad(lambda x: (1.0 - x) * bend(x) + slide(x), 0.0, 1.0, **limits)[0]
    return np.array([across, quad(bend, 0.0, 1.0, **limits)[0]])


def tip(section, elements, shear):
    """The same by the assembled elements."""
    data = beam_matrices(np.linspace(0.0, 1.0, elements + 1), section, MATERIAL, shear=shear)
    K = np.zeros((2 * elements + 2, 2 * elements + 2))
    for k, matrix in enumerate(data.bending_stiffness):
        K[2 * k : 2 * k + 4, 2 * k : 2 * k + 4] += matrix
    return np.linalg.solve(K[2:, 2:], np.eye(2 * elements)[-2])[-2:]


def test_a_uniform_cantilever_of_one_element_is_exact():
    expected = flexibility(THICK, lambda _: 5.0 / 6.0)
    np.testing.assert_allclose(tip(THICK, 1, 5.0 / 6.0), expected, rtol=1e-12)


@pytest.mark.parametrize("kind", TAPERED)
def test_tapered_cantilevers_converge_with_the_fourth_power(kind):
    section = TAPERED[kind]
    expected = flexibility(section, lambda x: section.shear_factor_at(x, 0.3))
    errors = np.array([np.abs(tip(section, n, True) / expected - 1.0) for n in (4, 8, 16, 32)])
    assert errors[-1].max() < 2e-7
    orders = np.log2(errors[:-1] / errors[1:])
    assert orders.min() > 3.8, orders


# Deformed shape and section forces


def test_shape_and_section_forces_of_a_cantilever_with_shear():
    link = fm.FlexibleLink("beam", O, X, section=THICK, material=MATERIAL, elements=1, shear=True)
    (shape,) = link.shapes(fm.Mechanism("beam", [link]))
    EI, shear, P = 2.1e11 * 0.1 * 0.2**3 / 12.0, 13.0 / 15.3 * G * 0.02, 1e3
    x = np.linspace(0.0, 1.0, 7)
    w = P / EI * (x**2 / 2.0 - x**3 / 6.0) + P / shear * x
    end = np.array([1.0, w[-1], P / (2.0 * EI)])
    # against an axis that is turned by 1e-5 rad, cosines are 1 to 1e-10 and the stretch is small
    points = hermite.element_shape(np.zeros(3), end, shape, x)[0]
    np.testing.assert_allclose(points[:, 1], w, atol=1e-8 * w[-1])
    forces = hermite.section_forces(np.zeros(3), end, shape, x)
    np.testing.assert_allclose(forces.M[0], P * (1.0 - x), atol=1e-5 * P)
    np.testing.assert_allclose(forces.V[0], P, rtol=1e-5)
    np.testing.assert_allclose(hermite.curvature(np.zeros(3), end, shape, x)[0], P * (1.0 - x) / EI, atol=1e-11)


# Shear factors


def test_shear_factors_of_cowper():
    """Values for nu = 0.3 and the limits of his table: solid and thin tubes."""
    factor = {name: float(s.shear_factor_at(0.5, 0.3)) for name, s in (
        ("rectangle", THICK), ("circle", fm.Circle(0.1)), ("thin", fm.Tube(outer=1.0, inner=0.999999)),
        ("solid", fm.Tube(outer=1.0, inner=1e-6)),
    )}  # fmt: skip
    assert factor["rectangle"] == pytest.approx(0.849673, abs=1e-6)
    assert factor["circle"] == pytest.approx(0.886364, abs=1e-6)
    assert factor["thin"] == pytest.approx(2.0 * 1.3 / (4.0 + 3.0 * 0.3), rel=1e-6)
    assert factor["solid"] == pytest.approx(factor["circle"], rel=1e-9)
    assert float(THICK.shear_factor_at(0.5, 0.0)) == pytest.approx(5.0 / 6.0)


def test_shape_of_the_places_is_kept():
    places = np.zeros((2, 3))
    for section in (THICK, fm.Circle(0.1), fm.Tube(0.2, 0.1), *TAPERED.values()):
        assert section.shear_factor_at(places, 0.3).shape == (2, 3)


def link(**options):
    return fm.FlexibleLink("rod", O, X, **{"section": THICK, "material": MATERIAL, **options})


class Mine(fm.Section):
    """A section that knows area and second moment alone."""

    def area_at(self, s):
        return np.full(np.shape(s), 1e-2)

    def second_moment_at(self, s):
        return np.full(np.shape(s), 1e-5)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: link(shear=1.2), "FlexibleLink 'rod': shear is 1.2; a shear factor is at most 1. Where a book"),
        (lambda: link(shear=-0.5), "FlexibleLink 'rod': shear is -0.5; it must be > 0."),
        (lambda: link(shear=0.0), "FlexibleLink 'rod': shear is 0; it must be > 0."),
        (lambda: link(shear="Cowper"), "FlexibleLink 'rod': shear is 'Cowper'; it must be a number."),
        (
            lambda: link(shear=True, section=fm.GeneralSection(area=1e-2, second_moment=1e-5)),
            "FlexibleLink 'rod': shear is True, and GeneralSection: shear_factor is None; give it to bend by shear",
        ),
        (lambda: link(shear=True, section=Mine()), "shear is True, and Mine: the shear factor is unknown; give it as"),
        (
            lambda: fm.GeneralSection(area=1e-2, second_moment=1e-5, shear_factor=1.5),
            "GeneralSection: shear_factor is 1.5; a shear factor is at most 1.",
        ),
        (lambda: link(shear=2.0), "FlexibleLink 'rod': shear is 2; a shear factor is at most"),
        (lambda: beam_matrices([0.0, 1.0], Mine(), MATERIAL, shear=True), "Mine: the shear factor is unknown"),
    ],
)  # fmt: skip
def test_wrong_shear_is_told(make, text):
    with pytest.raises(InputError, match=re.escape(text)):
        make()


def test_a_wrong_factor_of_a_users_section_is_told():
    class Wrong(Mine):
        def shear_factor_at(self, s, poisson):
            return 0.5

    with pytest.raises(InputError, match=r"Wrong\.shear_factor_at: the result is array\(0\.5\)"):
        beam_matrices([0.0, 1.0], Wrong(), MATERIAL, shear=True)


def test_given_factors_count():
    general = fm.GeneralSection(area=0.02, second_moment=0.1 * 0.2**3 / 12.0, shear_factor=5.0 / 6.0)
    expected = matrices(link(shear=5.0 / 6.0).beams[0]).bending_stiffness
    for other in (
        link(section=general, shear=True),
        link(section=general, shear=5.0 / 6.0),
        link(section=Mine(), shear=0.5),
    ):
        found = matrices(other.beams[0]).bending_stiffness
        assert np.allclose(found, expected, rtol=1e-12) is (other.section is general)


def test_rotary_inertia_comes_with_shear():
    """As in Timoshenko's equations; False leaves it out.  True is not the number 1 kg m."""
    rho_i = 7850.0 * 0.1 * 0.2**3 / 12.0
    options = ({"shear": True}, {}, {"shear": True, "rotary_inertia": False}, {"rotary_inertia": 1.0})
    for given, expected in zip((*options, {"rotary_inertia": True}), (rho_i, 0.0, 0.0, 1.0, rho_i), strict=True):
        data = matrices(link(elements=1, **given).beams[0])
        turn = np.array([0.0, 1.0, 1.0, 1.0])
        assert turn @ data.rotary_mass[0] @ turn == pytest.approx(expected, rel=1e-12), given
        assert math.isfinite(mass_moments(data)[2])


def test_links_and_frames_of_meshes_take_shear(tmp_path):
    path = str(tmp_path / "line.vtu")
    meshio.Mesh([(0.0, 0.0, 0.0), (0.4, 0.0, 0.0), (1.0, 0.0, 0.0)], [("line", np.array([(0, 1), (1, 2)]))]).write(path)
    given = {"sections": {0: THICK}, "material": MATERIAL}
    for made in (fm.FlexibleLink.from_mesh("rod", path, O, X, **given, shear=True),
                 fm.FlexibleFrame.from_mesh("rod", path, **given, shear=True)):  # fmt: skip
        expected = beam_matrices([0.0, 0.4, 1.0], THICK, MATERIAL, shear=True, rotary_inertia=True)
        found = matrices(made.beams[0])
        np.testing.assert_array_equal(found.bending_mass, expected.bending_mass)
        np.testing.assert_array_equal(found.bending_stiffness, expected.bending_stiffness)
