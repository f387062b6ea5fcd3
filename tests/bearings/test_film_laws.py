"""Closed forms of films beside published tables, and beside integration of the Reynolds equation in other ways."""

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import quad

from flexmb.parts.bearings.film import HALF, LONG, POSITIVE, SHORT, WHOLE, film_force, film_pressure

KINDS = (SHORT, LONG)
CASES = [(0.0, 0.3, 1.0), (1e-9, -0.2, 0.4), (0.05, 1.0, 0.2), (0.4, -0.7, -0.3), (0.6, 0.0, -1.0), (0.8, 0.5, 0.0)]
CASES += [(0.9, -1.0, 0.1), (0.95, 0.2, 2.0), (0.99, 1.0, 1.0)]
"""Eccentricities with rates a of squeeze and b of wedge."""

OCVIRK = {
    0.1: (0.0803829807, 82.70775), 0.2: (0.1725466860, 75.43121), 0.3: (0.2923750179, 68.17808),
    0.4: (0.4668374166, 60.93963), 0.5: (0.7503810818, 53.68020), 0.6: (1.2726315795, 46.32070),
    0.8: (5.7313280693, 30.50015), 0.95: (98.0498605, 14.47477),
}  # fmt: skip
"""Load W c^2/(mu w R L^3) and attitude [deg] of the short bearing by eccentricity (DuBois and Ocvirk 1953)."""

SOMMERFELD = {
    0.2: (3.772205383, 1.901961201, 82.59594), 0.5: (9.673596609, 5.153165209, 69.81897),
    0.8: (19.03995548, 12.48717083, 49.67452), 0.9: (27.70068494, 22.87526863, 37.26284),
}  # fmt: skip
"""Load W c^2/(mu w R^3 L) of the full and of the half long film, and attitude of the latter [deg]."""


def steady(kind, eps, extent=POSITIVE):
    """Load and attitude [deg] at a constant spin of 1 rad/s."""
    Fr, Ft = film_force(kind, extent, eps, 0.0, 0.5 * eps)[:2]
    return math.hypot(Fr, Ft), math.degrees(math.atan2(Ft, -Fr))


@pytest.mark.parametrize("eps", OCVIRK)
def test_short_bearing_has_the_published_load_and_attitude(eps):
    load, attitude = OCVIRK[eps]
    assert steady(SHORT, eps) == (pytest.approx(load, rel=1e-8), pytest.approx(attitude, abs=1e-5))


@pytest.mark.parametrize("eps", SOMMERFELD)
def test_long_bearing_has_the_published_loads_and_attitude(eps):
    full, half, attitude = SOMMERFELD[eps]
    assert steady(LONG, eps, WHOLE) == (pytest.approx(full, rel=1e-9), pytest.approx(90.0))
    assert steady(LONG, eps) == (pytest.approx(half, rel=1e-9), pytest.approx(attitude, abs=1e-5))


def pressure(kind, eps, a, b):
    """Pressure of the short film in its middle plane over 3/2 mu (L/c)^2, of the long one over 6 mu (R/c)^2."""
    k = 2.0 / (2.0 + eps * eps) if kind == LONG else 1.0

    def at(theta):
        H = 1.0 + eps * np.cos(theta)
        weight = (1.0 + H) / H**2 if kind == LONG else 1.0 / H**3
        return weight * (k * b * np.sin(theta) - a * np.cos(theta))

    return at, math.atan2(a, k * b)


@pytest.mark.parametrize(("eps", "a", "b"), CASES[2:])
def test_long_pressure_satisfies_the_reynolds_equation(eps, a, b):
    """(H^3 p')' = 12 (a cos - b sin): finite differences on the positive film, from one zero to the other."""
    p, alpha = pressure(LONG, eps, a, b)
    theta, h = np.linspace(alpha, alpha + math.pi, 4001, retstep=True)
    inner = 0.5 * (theta[1:] + theta[:-1])
    flux = (1.0 + eps * np.cos(inner)) ** 3 * 6.0 * np.diff(p(theta)) / h
    source = 12.0 * (a * np.cos(theta[1:-1]) - b * np.sin(theta[1:-1]))
    assert np.abs(np.diff(flux) / h - source).max() < 1e-5 / (1.0 - eps) ** 2 * max(abs(a), abs(b))
    assert p(theta[1:-1]).min() > 0.0
    assert np.abs(p(theta[[0, -1]])).max() < 1e-12 * p(theta).max()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("extent", [POSITIVE, HALF, WHOLE])
@pytest.mark.parametrize(("eps", "a", "b"), CASES)
def test_force_is_the_integral_of_the_pressure(kind, extent, eps, a, b):
    p, alpha = pressure(kind, eps, a, b)
    begin, end = alpha, alpha + math.pi
    if extent == HALF:
        if b == 0.0:
            return
        begin = 0.0 if b > 0.0 else -math.pi
        end = begin + math.pi
    if extent == WHOLE:
        begin, end = 0.0, 2.0 * math.pi
    scale = 6.0 if kind == LONG else 1.0
    options = {"epsabs": 0.0, "epsrel": 1e-11, "limit": 400}
    corners = [x for x in (-math.pi, math.pi) if begin < x < end]

    def integral(f):
        pieces = [begin, *corners, end]
        return sum(quad(lambda x: scale * p(x) * f(x), lo, hi, **options)[0] for lo, hi in itertools.pairwise(pieces))

    expected = integral(math.cos), integral(math.sin)
    size = math.hypot(*expected)
    assert np.abs(np.subtract(film_force(kind, extent, eps, a, b)[:2], expected)).max() < 1e-9 * size


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("extent", [POSITIVE, HALF, WHOLE])
@pytest.mark.parametrize(("eps", "a", "b"), CASES[2:])
def test_derivatives_are_exact(kind, extent, eps, a, b):
    if extent == HALF and b == 0.0:  # where it jumps
        return
    found = np.array(film_force(kind, extent, eps, a, b))
    for k, column in enumerate((slice(2, 4), [4, 6], [5, 7])):
        h, expected = 1e-4 * (1.0 - eps if k == 0 else 1.0), 0.0
        for place, weight in ((-2, 1.0), (-1, -8.0), (1, 8.0), (2, -1.0)):
            x = [eps, a, b]
            x[k] += place * h
            expected = expected + weight * np.array(film_force(kind, extent, *x)[:2]) / (12.0 * h)
        assert found[column] == pytest.approx(expected, abs=2e-7 * np.abs(expected).max())


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("eps", "a", "b"), CASES)
def test_mirrored_spin_mirrors_the_force(kind, eps, a, b):
    Fr, Ft, Fr_e, Ft_e, Fr_a, Fr_b, Ft_a, Ft_b = film_force(kind, POSITIVE, eps, a, b)
    mirrored = np.array((Fr, -Ft, Fr_e, -Ft_e, Fr_a, -Fr_b, -Ft_a, Ft_b))
    found = np.array(film_force(kind, POSITIVE, eps, a, -b))
    if b == 0.0:
        found[[1, 3, 5, 6]] = mirrored[[1, 3, 5, 6]] = np.abs(found[[1, 3, 5, 6]])
    assert found == pytest.approx(mirrored, rel=1e-9, abs=1e-12 * np.abs(mirrored).max())


@pytest.mark.quick(4)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("eps", "a", "b"), CASES)
def test_largest_pressure(kind, eps, a, b):
    p, alpha = pressure(kind, eps, a, b)
    gap = 1.0 - eps
    near = math.pi + np.sqrt(gap) * np.linspace(-3.0, 3.0, 400001) if eps > 0.7 else alpha
    theta = np.concatenate([alpha + np.linspace(0.0, math.pi, 200001), np.atleast_1d(near)])
    assert film_pressure(kind, eps, a, b) == pytest.approx(p(theta).max(), rel=1e-6)


@pytest.mark.parametrize("eps", [0.1, 0.5, 0.9])
def test_squeeze_of_a_long_film_all_round(eps):
    """12 pi e'/(1 - eps^2)^(3/2), as of Pinkus and Sternlicht 1961."""
    Fr, Ft = film_force(LONG, WHOLE, eps, 1.0, 0.0)[:2]
    assert pytest.approx(-12.0 * math.pi / (1.0 - eps * eps) ** 1.5) == Fr
    assert abs(Ft) < 1e-12 * abs(Fr)


@pytest.mark.parametrize(("eps", "a", "b"), [(0.3, 0.01, 0.5), (0.7, -0.002, 0.35)])
def test_half_turn_has_the_published_derivatives(eps, a, b):
    """F_r, F_t of Ocvirk's film with the terms of squeeze, as rotor dynamics writes them."""
    s2, w = 1.0 - eps * eps, 2.0 * b / eps
    Fr = -(eps**2 * w / s2**2 + math.pi * (1.0 + 2.0 * eps**2) * a / (2.0 * s2**2.5))
    Ft = math.pi * eps * w / (4.0 * s2**1.5) + 2.0 * eps * a / s2**2
    assert film_force(SHORT, HALF, eps, a, b)[:2] == pytest.approx((Fr, Ft), rel=1e-12)
