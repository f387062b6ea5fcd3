"""Element matrices of beams against textbook matrices, exact mass integrals and exact frequencies."""

import pickle
from fractions import Fraction

import numpy as np
import pytest
from element_matrices import beam_matrices, mass_moments
from numpy.polynomial import Polynomial
from scipy.linalg import eigh
from scipy.optimize import brentq
from scipy.special import iv, jv

from flexmb.elastic.beams.fem import BeamMatrices
from flexmb.elastic.beams.section import Circle, GeneralSection, Rectangle, Section, Tapered, Tube
from flexmb.errors import InputError
from flexmb.model.law import STEEL, Material

UNIT = GeneralSection(area=1.0, second_moment=1.0)
UNIT_MATERIAL = Material(young=1.0, density=1.0)
BAR = Rectangle(width=0.012, height=0.025)
TAPERED_BARS = [
    Tapered(Rectangle(width=0.02, height=0.03), Rectangle(width=0.01, height=0.012)),
    Tapered(Circle(0.03), Circle(0.011)),
    Tapered(Tube(outer=0.03, inner=0.02), Tube(outer=0.025, inner=0.01)),
    Tapered(GeneralSection(area=3e-4, second_moment=2e-8), GeneralSection(area=1e-4, second_moment=3e-9)),
]


def assembled(local: np.ndarray) -> np.ndarray:
    """Global matrix of a chain of elements with two nodes each."""
    n, k = len(local), local.shape[1] // 2
    full = np.zeros(((n + 1) * k,) * 2)
    for e, matrix in enumerate(local):
        full[e * k : (e + 2) * k, e * k : (e + 2) * k] += matrix
    return full


def first_frequency(matrices: BeamMatrices, clamp: slice) -> float:
    """Lowest angular frequency [rad/s] in bending with the degrees of freedom `clamp` held."""
    K, M = assembled(matrices.bending_stiffness), assembled(matrices.bending_mass)
    free = np.delete(np.arange(len(K)), clamp)
    return float(np.sqrt(eigh(K[np.ix_(free, free)], M[np.ix_(free, free)], eigvals_only=True)[0]))


def test_uniform_element_is_the_textbook_element():
    """J. S. Przemieniecki, Theory of Matrix Structural Analysis, 1968, sections 5.6 and 11.6 (and Cook, 2.3, 11.3)."""
    L = 0.37
    A, I, E, rho = 3e-4, 1.5625e-8, 207e9, 7801.0
    bending = [[12, 6 * L, -12, 6 * L], [6 * L, 4 * L**2, -6 * L, 2 * L**2]]
    bending += [[-12, -6 * L, 12, -6 * L], [6 * L, 2 * L**2, -6 * L, 4 * L**2]]
    mass = [[156, 22 * L, 54, -13 * L], [22 * L, 4 * L**2, 13 * L, -3 * L**2]]
    mass += [[54, 13 * L, 156, -22 * L], [-13 * L, -3 * L**2, -22 * L, 4 * L**2]]
    rotary = [[36, 3 * L, -36, 3 * L], [3 * L, 4 * L**2, -3 * L, -(L**2)]]
    rotary += [[-36, -3 * L, 36, -3 * L], [3 * L, -(L**2), -3 * L, 4 * L**2]]
    got = beam_matrices([0.0, L], BAR, STEEL)
    rayleigh = beam_matrices([0.0, L], BAR, STEEL, rotary_inertia=True)
    assert got.axial_stiffness[0] == pytest.approx(E * A / L * np.array([[1, -1], [-1, 1]]), rel=1e-13)
    assert got.axial_mass[0] == pytest.approx(rho * A * L / 6 * np.array([[2, 1], [1, 2]]), rel=1e-13)
    assert got.bending_stiffness[0] == pytest.approx(E * I / L**3 * np.array(bending), rel=1e-12)
    assert got.bending_mass[0] == pytest.approx(rho * A * L / 420 * np.array(mass), rel=1e-12)
    added = rho * A * L / 420 * np.array(mass) + rho * I / (30 * L) * np.array(rotary)
    assert rayleigh.bending_mass[0] == pytest.approx(added, rel=1e-12)
    assert rayleigh.bending_stiffness[0] == pytest.approx(got.bending_stiffness[0], rel=1e-15)
    assert got.ea[0] == pytest.approx([E * A, E * A], rel=1e-15)
    assert got.ei[0] == pytest.approx([E * I, E * I], rel=1e-14)


@pytest.mark.parametrize("n", [1, 7, 2000])
def test_no_digits_are_lost_far_from_the_start(n):
    """All elements of a uniform beam are the first one, also 2000 elements away."""
    stations = np.arange(n + 1) / 1024.0  # exact in binary, so that every length is the same number
    got = beam_matrices(stations, BAR, STEEL)
    for matrices in (got.bending_stiffness, got.bending_mass, got.axial_stiffness, got.axial_mass):
        assert np.all(np.abs(matrices - matrices[0]) <= 1e-13 * np.abs(matrices[0]))


@pytest.mark.parametrize("section", [BAR, *TAPERED_BARS], ids=["uniform", "rectangle", "circle", "tube", "general"])
@pytest.mark.parametrize("rotary", [False, True], ids=["Euler-Bernoulli", "Rayleigh"])
def test_rigid_motions_give_no_force_and_mass_is_positive(section, rotary):
    stations = np.array([0.1, 0.12, 0.2, 0.5])
    got = beam_matrices(stations, section, STEEL, rotary_inertia=rotary)
    axial, bending = (got.axial_stiffness, got.axial_mass), (got.bending_stiffness, got.bending_mass)
    for L, ka, ma, kb, mb in zip(got.lengths, *axial, *bending, strict=True):
        assert np.abs(ka @ [1, 1]).max() <= 1e-13 * np.abs(ka).max()
        assert np.abs(kb @ [1, 0, 1, 0]).max() <= 1e-12 * np.abs(kb).max()
        assert np.abs(kb @ [-L / 2, 1, L / 2, 1]).max() <= 1e-12 * L * np.abs(kb).max()
        for matrix in (ka, kb, ma, mb):
            assert np.array_equal(matrix, matrix.T)
        scale = np.array([1.0, L, 1.0, L])
        assert np.linalg.eigvalsh(mb / np.outer(scale, scale))[0] > 0.0
        assert np.linalg.eigvalsh(kb / np.outer(scale, scale))[2] > 0.0


def test_tapered_rectangle_has_its_exact_mass_moments():
    """A = (b0 + b1 s)(h0 + h1 s): integrals of rho A, rho A x, rho A x^2 in rational numbers."""
    L, b0, b1, h0, h1 = Fraction(3, 10), Fraction(2, 100), Fraction(-1, 100), Fraction(3, 100), Fraction(-18, 1000)
    area = [b0 * h0, b0 * h1 + b1 * h0, b1 * h1]
    exact = [7801 * L ** (k + 1) * sum(a / (i + k + 1) for i, a in enumerate(area)) for k in range(3)]
    for stations in ([0.0, 0.3], [0.0, 0.05, 0.06, 0.3], np.linspace(0.0, 0.3, 9)):
        got = beam_matrices(stations, TAPERED_BARS[0], STEEL)
        assert mass_moments(got) == pytest.approx([float(value) for value in exact], rel=1e-13)
        assert got.axial_mass.sum() == pytest.approx(float(exact[0]), rel=1e-13)
        assert got.lengths.sum() == pytest.approx(0.3, rel=1e-15)


def test_rotary_inertia_adds_the_rotation_of_the_section():
    """A solid bar b x h x L turns about its start with m (L^2/3 + h^2/12) (rigid-body mechanics)."""
    L, m = 0.3, 7801.0 * 0.012 * 0.025 * 0.3
    stations = np.linspace(0.0, L, 4)
    plain, rayleigh = (beam_matrices(stations, BAR, STEEL, rotary_inertia=rotary) for rotary in (False, True))
    assert mass_moments(plain) == pytest.approx((m, m * L / 2, m * L**2 / 3), rel=1e-13)
    assert mass_moments(rayleigh) == pytest.approx((m, m * L / 2, m * (L**2 / 3 + 0.025**2 / 12)), rel=1e-13)


def test_quadrature_is_exact_for_tapered_sections():
    """Stiffness and Rayleigh mass of a tapered circle against integrals of polynomials in closed form."""
    L, x = 0.3, Polynomial([0.0, 1.0])
    s = x / L
    shapes = [1 - 3 * s**2 + 2 * s**3, L * (s - 2 * s**2 + s**3), 3 * s**2 - 2 * s**3, L * (s**3 - s**2)]
    diameter = 0.03 + (0.011 - 0.03) * s
    area, second = np.pi / 4 * diameter**2, np.pi / 64 * diameter**4

    def integral(polynomial: Polynomial) -> float:
        return float(polynomial.integ()(L))

    stiffness = [[integral(207e9 * second * a.deriv(2) * b.deriv(2)) for b in shapes] for a in shapes]
    mass = [[integral(7801 * (area * a * b + second * a.deriv() * b.deriv())) for b in shapes] for a in shapes]
    got = beam_matrices([0.0, L], TAPERED_BARS[1], STEEL, rotary_inertia=True)
    assert got.bending_stiffness[0] == pytest.approx(np.array(stiffness), rel=1e-11)
    assert got.bending_mass[0] == pytest.approx(np.array(mass), rel=1e-11)
    # int dx/(E A) of a cone: 4 L/(pi E d1 d2), not a polynomial, so the quadrature shows
    assert got.axial_stiffness[0, 0, 0] == pytest.approx(np.pi * 207e9 * 0.03 * 0.011 / (4 * L), rel=2e-4)
    fine = beam_matrices(np.linspace(0.0, L, 5), TAPERED_BARS[1], STEEL).axial_stiffness[:, 0, 0]
    assert 1 / np.sum(1 / fine) == pytest.approx(np.pi * 207e9 * 0.03 * 0.011 / (4 * L), rel=1e-9)
    assert got.ei[0] == pytest.approx(207e9 * np.pi / 64 * np.array([0.03**4, 0.011**4]), rel=1e-14)


def test_section_is_placed_by_station_over_length():
    """A mesh that begins elsewhere, and a beam cut in elements, see the same taper."""
    here = beam_matrices([0.0, 0.1, 0.3], TAPERED_BARS[0], STEEL)
    there = beam_matrices([2.0, 2.1, 2.3], TAPERED_BARS[0], STEEL)
    assert there.bending_stiffness == pytest.approx(here.bending_stiffness, rel=1e-12)
    assert here.ea[0, 1] == here.ea[1, 0]
    assert here.ea[:, 0] == pytest.approx([207e9 * 6e-4, 207e9 * (0.02 - 0.01 / 3) * (0.03 - 0.018 / 3)], rel=1e-14)


def test_tip_force_bends_a_cantilever_as_the_sign_rule_says():
    """w = F L^3 / 3EI and theta = F L^2 / 2EI at the tip, both positive for a force to the left (Gere, Timoshenko)."""
    F, L = 10.0, 0.3
    K = assembled(beam_matrices([0.0, 0.1, L], BAR, STEEL).bending_stiffness)[2:, 2:]
    w = np.linalg.solve(K, [0.0, 0.0, F, 0.0])
    EI = 207e9 * 1.5625e-8
    assert w[2:] == pytest.approx([F * L**3 / (3 * EI), F * L**2 / (2 * EI)], rel=1e-11)


def orders(errors: list[float]) -> np.ndarray:
    """Observed orders when the elements are halved from one error to the next."""
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


def test_first_frequency_of_uniform_cantilever_converges_with_order_four():
    """omega = 1.8751040687119611^2 sqrt(EI / rho A L^4): first root of cos x cosh x = -1 (Rayleigh, 1877).

    Cubic elements err by omega^2 h^4 / 1440 (Strang, Fix, An Analysis of the Finite Element Method, 1973, chapter 6).
    """
    exact = 1.8751040687119611**2
    errors = []
    for n in (2, 4, 8):
        matrices = beam_matrices(np.linspace(0.0, 1.0, n + 1), UNIT, UNIT_MATERIAL)
        errors.append(first_frequency(matrices, slice(0, 2)) / exact - 1.0)
    assert min(errors) > 0.0  # consistent mass: from above
    assert errors[-1] == pytest.approx(exact**2 * 8.0**-4 / 1440.0, rel=0.02)
    assert np.all(orders(errors) >= 3.8)


class Wedge(Section):
    """Constant width, height falling linearly to zero at s = 1."""

    def area_at(self, s):
        return 1.0 - np.asarray(s)

    def second_moment_at(self, s):
        return (1.0 - np.asarray(s)) ** 3


def wedge_frequency() -> float:
    """Root of J1 I2 + I1 J2 at 2 sqrt(omega): G. Kirchhoff 1879; E. T. Cranch, A. A. Adler, J. Appl. Mech. 23, 1956."""
    x = brentq(lambda x: jv(1, x) * iv(2, x) + iv(1, x) * jv(2, x), 4.0, 5.0, xtol=1e-14)
    return x * x / 4.0


def test_wedge_has_its_published_frequency():
    assert wedge_frequency() == pytest.approx(5.315, abs=5e-4)


def test_first_frequency_of_clamped_wedge_converges_with_order_four():
    """omega = 5.315 sqrt(E I0 / rho A0 L^4), clamped at the thick end, running out to an edge."""
    errors = []
    for n in (4, 8, 16):
        matrices = beam_matrices(np.linspace(0.0, 1.0, n + 1), Wedge(), UNIT_MATERIAL)
        errors.append(first_frequency(matrices, slice(0, 2)) / wedge_frequency() - 1.0)
    assert min(errors) > 0.0
    assert errors[-1] < 1e-6
    assert np.all(orders(errors) >= 3.8)


def test_graded_mesh_converges_to_the_same_frequency():
    """A mesh twelve times finer at the tip than at the clamp."""
    stations = np.sin(np.linspace(0.0, np.pi / 2, 17))
    got = first_frequency(beam_matrices(stations, Wedge(), UNIT_MATERIAL), slice(0, 2))
    assert got == pytest.approx(wedge_frequency(), rel=1e-5)


def test_free_bar_has_the_axial_frequency_of_rods():
    """omega = pi sqrt(E / rho) / L for a free-free rod (Rayleigh); linear elements err by (pi h / L)^2 / 24."""
    n = 40
    matrices = beam_matrices(np.linspace(0.0, 1.0, n + 1), UNIT, UNIT_MATERIAL)
    values = eigh(assembled(matrices.axial_stiffness), assembled(matrices.axial_mass), eigvals_only=True)
    assert np.sqrt(values[1]) / np.pi - 1.0 == pytest.approx((np.pi / n) ** 2 / 24.0, rel=1e-3)


def test_arrays_are_read_only_and_can_be_pickled():
    got = beam_matrices([0.0, 0.1, 0.3], BAR, STEEL)
    again = pickle.loads(pickle.dumps(got))  # noqa: S301, made in this line
    assert np.array_equal(again.bending_mass, got.bending_mass)
    with pytest.raises(ValueError, match="read-only"):
        got.bending_mass[0, 0, 0] = 1.0


class BadSection(Section):
    """A user's section with a mistake."""

    def __init__(self, area, second_moment=np.ones_like):
        self.area, self.second_moment = area, second_moment

    def area_at(self, s):
        return self.area(s)

    def second_moment_at(self, s):
        return self.second_moment(s)


ONES = np.ones_like
BAD = [
    (([0.0, 1.0], BadSection(lambda s: 1.0), STEEL), "BadSection.area_at: the result has shape ()"),
    (([0.0, 1.0], BadSection(lambda s: s - 0.5), STEEL), "BadSection.area_at: the value at s = 0.04691 is -0.453"),
    (([0.0, 1.0], BadSection(lambda s: np.where(s < 1.0, 1.0, -1.0)), STEEL), "area_at: the value at s = 1 is -1"),
    (([0.0, 1.0], BadSection(ONES, lambda s: s * np.inf), STEEL), "second_moment_at: the value at s = 0.04691 is inf"),
]


@pytest.mark.parametrize(("arguments", "message"), BAD, ids=range(len(BAD)))
def test_bad_input_is_named(arguments, message):
    with pytest.raises(InputError) as caught:
        beam_matrices(*arguments)
    assert message in str(caught.value)
