"""A clamped beam whose width and height fall linearly to the tip.

Small deflections, by virtual work with the flexibilities of the beam:
    force P across the tip   w = int P (L - x)^2/EI dx,   angle = int P (L - x)/EI dx
    moment M on the tip      w = int M (L - x)/EI dx,     angle = int M/EI dx
    own weight               w = int m(x) (L - x)/EI dx,  m(x) = int_x^L g rho A(s) (s - x) ds
    force N along the beam   u = int N/EA dx
For a constant width, two of them in closed form: `closed_force`, `closed_moment`.
Large deflections: (EI theta')' = -P x', theta(0) = 0, theta'(L) = 0, x' = (1 + P sin(theta)/EA) cos(theta), integrated.
Source: S. P. Timoshenko, J. M. Gere, Mechanics of Materials, Van Nostrand 1972 (beams of variable section).
"""

import math

import numpy as np
import pytest
from record import Curve, Problem, Value
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

import flexmb as fm
from flexmb.mechanisms.cantilever import cantilever

LENGTH, YOUNG, DENSITY = 1.0, 2.0e11, 7850.0
MATERIAL = fm.Material(young=YOUNG, density=DENSITY)
WIDTHS, HEIGHTS = {"height": (0.02, 0.02), "width and height": (0.03, 0.01)}, (0.001, 0.0004)

PROBLEM = Problem(
    title="Tapered cantilever",
    source="Flexibilities by virtual work: S. P. Timoshenko, J. M. Gere, Mechanics of Materials, Van Nostrand 1972.",
    kind="exact (integrals; closed form for constant width), large deflections computed here by shooting to 1e-12",
    about="""A clamped beam tapers from a height of 1 to 0.4 mm, with constant width or with a width from 30 to 10 mm:
    the bending stiffness falls to 1/16, or 1/47, of its value at the clamp. Elements integrate the taper exactly, but
    their cubic shape is not the deflection of a tapered beam, so the deflection converges with the fourth power of the
    element length. Elongation under an end load is exact. The reference of large deflections counts the stretch, 2e-6
    of the length.""",
)


def dimensions(taper: str, x: float) -> tuple[float, float]:
    """Width and height [m] at x [m], written down once more, away from the section's own code."""
    b0, b1 = WIDTHS[taper]
    h0, h1 = HEIGHTS
    return b0 + (b1 - b0) * x / LENGTH, h0 + (h1 - h0) * x / LENGTH


def ei(taper: str, x: float) -> float:
    """Bending stiffness [N m^2]."""
    b, h = dimensions(taper, x)
    return YOUNG * b * h**3 / 12.0


def ea(taper: str, x: float) -> float:
    """Axial stiffness [N]."""
    b, h = dimensions(taper, x)
    return YOUNG * b * h


def integral(function) -> float:
    """Over the beam, to twelve digits."""
    return quad(function, 0.0, LENGTH, epsabs=0.0, epsrel=1e-12)[0]


def weight_moment(taper: str, x: float, g: float) -> float:
    """Moment at x of the weight beyond it; A(s) (s - x) is a cubic, so Gauss' rule with two points is exact."""
    half, middle = 0.5 * (LENGTH - x), 0.5 * (LENGTH + x)
    places = [middle + sign * half / math.sqrt(3.0) for sign in (-1.0, 1.0)]
    return half * sum(g * DENSITY * math.prod(dimensions(taper, s)) * (s - x) for s in places)


def closed_force(P: float) -> float:
    """Deflection of the tip for constant width: int x^2/(h1 + (h0 - h1) x/L)^3 dx over the distance x from the tip."""
    b, (h0, h1) = WIDTHS["height"][0], HEIGHTS
    m = (h0 - h1) / LENGTH

    def antiderivative(h: float) -> float:  # with x = (h - h1)/m: int (h - h1)^2/h^3 dh / m^3
        return (math.log(h) + 2.0 * h1 / h - h1**2 / (2.0 * h**2)) / m**3

    return 12.0 * P / (YOUNG * b) * (antiderivative(h0) - antiderivative(h1))


def closed_moment(M: float) -> float:
    """Angle of the tip for constant width: int 1/h^3 dx = (h0 + h1) L/(2 h0^2 h1^2)."""
    b, (h0, h1) = WIDTHS["height"][0], HEIGHTS
    return 12.0 * M / (YOUNG * b) * (h0 + h1) * LENGTH / (2.0 * h0**2 * h1**2)


def tip(taper: str, elements: int, **loads) -> tuple[float, float, float]:
    """Displacement along and across the beam [m] and rotation of the tip [rad], as flexmb finds them."""
    (b0, b1), (h0, h1) = WIDTHS[taper], HEIGHTS
    section = fm.Tapered(fm.Rectangle(width=b0, height=h0), fm.Rectangle(width=b1, height=h1))
    found = fm.static_equilibrium(cantilever(LENGTH, section, MATERIAL, elements=elements, **loads))
    return found["beam.end.x"] - LENGTH, found["beam.end.y"], found["beam.end.theta"]


SMALL = 1e-5
"""Slope that small loads cause: its square, 1e-10, is by how much large rotations change the deflection."""


def small_loads(taper: str) -> dict[str, tuple[dict, float, float]]:
    """Loads that turn the tip by about SMALL, with the exact deflection and rotation of the tip."""
    soft = integral(lambda x: (LENGTH - x) / ei(taper, x))
    P, M = SMALL / soft, SMALL / integral(lambda x: 1.0 / ei(taper, x))
    g = SMALL / integral(lambda x: weight_moment(taper, x, 1.0) / ei(taper, x))
    own = integral(lambda x: weight_moment(taper, x, g) * (LENGTH - x) / ei(taper, x))
    return {
        "force": ({"force": (0.0, P)}, integral(lambda x: P * (LENGTH - x) ** 2 / ei(taper, x)), SMALL),
        "moment": ({"moment": M}, M * soft, SMALL),
        "own weight": ({"gravity": (0.0, g)}, own, SMALL),
    }


def large(taper: str, P: float) -> tuple[float, float, float]:
    """Displacement along and across the beam and rotation of the tip under a dead force across it, by shooting."""

    def slope(s, state):
        _, _, theta, moment = state
        x, y = math.cos(theta), math.sin(theta)
        stretch = 1.0 + P * y / ea(taper, s)
        return stretch * x, stretch * y, moment / ei(taper, s), -P * stretch * x

    def at_clamp(angle: float) -> np.ndarray:
        run = solve_ivp(slope, (LENGTH, 0.0), (0.0, 0.0, angle, 0.0), method="DOP853", rtol=1e-12, atol=1e-13)
        return run.y[:, -1]

    angle = brentq(lambda a: at_clamp(a)[2], 1e-9, math.pi / 2 - 1e-9, xtol=1e-14, rtol=1e-14)
    x, y, _, _ = at_clamp(angle)
    return -x - LENGTH, -y, angle


def heavy(taper: str) -> float:
    """A force that bends the tip by about 60 degrees."""
    return 3.0 * LENGTH / integral(lambda x: (LENGTH - x) ** 2 / ei(taper, x))


def test_the_integrals_agree_with_the_closed_forms():
    assert integral(lambda x: (LENGTH - x) ** 2 / ei("height", x)) == pytest.approx(closed_force(1.0), rel=1e-11)
    assert integral(lambda x: 1.0 / ei("height", x)) == pytest.approx(closed_moment(1.0), rel=1e-11)


@PROBLEM.case("small loads, 16 elements")
def small():
    for taper in WIDTHS:
        for name, (loads, deflection, angle) in small_loads(taper).items():
            _, y, theta = tip(taper, 16, **loads)
            yield Value(f"taper of {taper}, {name}: deflection of the tip [m]", deflection, y, band=1e-4)
            yield Value(f"taper of {taper}, {name}: angle of the tip [rad]", angle, theta, band=1e-4)


@PROBLEM.case("force along the beam, 16 elements")
def stretched():
    N = 1.0
    for taper in WIDTHS:
        elongation = integral(lambda x, taper=taper: N / ea(taper, x))
        x = tip(taper, 16, force=(N, 0.0))[0]
        yield Value(f"taper of {taper}: elongation under 1 N [m]", elongation, x, band=1e-8)


@PROBLEM.case("large deflection, 16 elements")
def far():
    for taper in WIDTHS:
        P = heavy(taper)
        quantities = ("x of the tip - L [m]", "y of the tip [m]", "angle of the tip [rad]")
        for quantity, ref, ours in zip(quantities, large(taper, P), tip(taper, 16, force=(0.0, P)), strict=True):
            yield Value(f"taper of {taper}, {P:.4g} N: {quantity}", ref, ours, band=1e-4, scale=1.0)


@PROBLEM.convergence(
    "tapered", "Tapered cantilever: errors of the tip, taper of width and height.", "element length / L", "error"
)
def elements():
    taper, counts = "width and height", (8, 16, 32, 64)
    sizes = [1.0 / n for n in counts]
    loads, deflection, _ = small_loads(taper)["force"]
    errors = [abs(tip(taper, n, **loads)[1] / deflection - 1.0) for n in counts]
    yield Curve("small deflection, relative", sizes, errors, order=4.0)
    P = heavy(taper)
    _, y, _ = large(taper, P)
    errors = [abs(tip(taper, n, force=(0.0, P))[1] - y) / LENGTH for n in counts]
    yield Curve("large deflection, over L", sizes, errors, order=4.0)


test_case, test_curves = PROBLEM.tests()
