"""The elastica: a clamped, inextensible beam under a dead force across its tip.

    EI theta'' = -P cos(theta),  theta(0) = 0,  theta'(L) = 0,  k = P L^2/EI

With phi the angle of the tip, p^2 = (1 + sin phi)/2, sin^2(t) = 1/(2 p^2), in elliptic integrals F and E of modulus p:
    sqrt(k) = F(pi/2) - F(t),  w/L = 1 - 2 [E(pi/2) - E(t)]/sqrt(k),  1 - u/L = sqrt(2 sin phi)/sqrt(k).
Source: K. E. Bisshopp, D. C. Drucker, Large deflection of cantilever beams, Quarterly of Applied Mathematics 3 (1945)
272-275.
"""

import math

import numpy as np
import pytest
from record import Curve, Problem, Value
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

import flexmb as fm
from flexmb.mechanisms.cantilever import cantilever

LENGTH, WIDTH, YOUNG = 2.0, 0.02, 2.0e11
HEIGHT = LENGTH / 20000  # so thin that the stretch, k (h/L)^2/12 of the length, stays below 2.1e-9
EI = YOUNG * WIDTH * HEIGHT**3 / 12.0

EXACT = {
    1: (0.301720773800, 0.0564332362834, 0.461351949712),
    2: (0.493457480397, 0.160641720825, 0.781749831557),
    4: (0.669964181278, 0.328941242247, 1.12123934749),
    6: (0.744571148890, 0.434588828682, 1.28369728580),
    8: (0.784982374953, 0.504827732134, 1.37443150670),
    10: (0.810609024880, 0.554995597754, 1.43028553880),
}
"""k -> deflection of the tip across (w) and along (u) the beam over L, angle of the tip [rad]."""

QUANTITIES = ("w/L", "u/L", "angle of the tip [rad]")

PROBLEM = Problem(
    title="Elastica",
    source="K. E. Bisshopp, D. C. Drucker, Quarterly of Applied Mathematics 3 (1945) 272-275.",
    kind="exact (elliptic integrals)",
    about="""A beam clamped at one end carries a dead force P across its tip, k = P L^2/EI up to 10, where the tip has
    turned by 82 degrees. It tests the beam element at large rotations: the deflections follow from bending alone, the
    beam being so thin that its stretch does not count. The moment at the clamp is P times the lever that is left.""",
)


def bent(k: float, elements: int) -> fm.Mechanism:
    """The beam with its load."""
    section, material = fm.Rectangle(width=WIDTH, height=HEIGHT), fm.Material(young=YOUNG, density=7850.0)
    return cantilever(LENGTH, section, material, elements=elements, force=(0.0, k * EI / LENGTH**2))


def tip(k: float, elements: int) -> tuple[float, float, float]:
    """w/L, u/L and the angle of the tip, as flexmb finds them."""
    found = fm.static_equilibrium(bent(k, elements))
    return found["beam.end.y"] / LENGTH, 1.0 - found["beam.end.x"] / LENGTH, found["beam.end.theta"]


def elliptic(k: float) -> tuple[float, float, float]:
    """The same from elliptic integrals (scipy takes the modulus squared)."""

    def shape(phi: float) -> tuple[float, float]:
        return (1.0 + math.sin(phi)) / 2.0, math.asin(1.0 / math.sqrt(1.0 + math.sin(phi)))

    def missing(phi: float) -> float:
        m, t = shape(phi)
        return ellipk(m) - ellipkinc(t, m) - math.sqrt(k)

    phi = brentq(missing, 1e-6, math.pi / 2 - 1e-12, xtol=1e-15, rtol=1e-15)
    m, t = shape(phi)
    across = 1.0 - 2.0 * (ellipe(m) - ellipeinc(t, m)) / math.sqrt(k)
    return across, 1.0 - math.sqrt(2.0 * math.sin(phi) / k), phi


@pytest.mark.parametrize("k", EXACT)
def test_the_references_follow_from_elliptic_integrals(k):
    """To the twelve digits written above."""
    np.testing.assert_allclose(elliptic(k), EXACT[k], rtol=6e-12)


@PROBLEM.case("16 elements")
def sixteen():
    for k, exact in EXACT.items():
        found = fm.static_equilibrium(bent(k, 16))
        ours = found["beam.end.y"] / LENGTH, 1.0 - found["beam.end.x"] / LENGTH, found["beam.end.theta"]
        for quantity, ref, value in zip(QUANTITIES, exact, ours, strict=True):
            yield Value(f"k = {k}: {quantity}", ref, value, band=1e-4, scale=1.0)
        moment = found.force("clamp")[2] * LENGTH / EI
        yield Value(f"k = {k}: moment of the clamp over EI/L", -k * (1.0 - exact[1]), moment, band=1e-3)


@PROBLEM.case("64 elements")
def sixty_four():
    for k in (1, 4, 10):
        for quantity, ref, value in zip(QUANTITIES, EXACT[k], tip(k, 64), strict=True):
            yield Value(f"k = {k}: {quantity}", ref, value, band=1e-8, scale=1.0)


@PROBLEM.convergence(
    "elastica", "Elastica: error of the tip's deflection w.", "element length / L", "error of w / L", slow=True
)
def elements():
    counts = (4, 8, 16, 32, 64)
    for k in (1, 4, 10):
        errors = [abs(tip(k, n)[0] - elliptic(k)[0]) for n in counts]
        yield Curve(f"k = {k}", [1.0 / n for n in counts], errors, order=4.0)


@PROBLEM.picture("elastica_shapes", "Elastica: 16 elements (dots: nodes) and exact places of the tip (rings).")
def shapes(figure):
    ax = figure.add_subplot(aspect="equal")
    for k, exact in EXACT.items():
        found = fm.static_equilibrium(bent(k, 16))
        x, y = ([found[f"beam.node{i}.{axis}"] / LENGTH for i in range(17)] for axis in "xy")
        ax.plot(x, y, ".-", linewidth=1.2, label=f"k = {k}")
        ax.plot(1.0 - exact[1], exact[0], "o", markersize=10, markerfacecolor="none", markeredgecolor="0.3")
    ax.set(xlabel="x / L", ylabel="y / L")
    ax.legend()


test_case, test_curves = PROBLEM.tests()
