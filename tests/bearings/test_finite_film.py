"""Finite film beside published tables, the limits of long and short films, and the table that a run reads."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.parts.bearings.film import (
    PEAK,
    SHORT,
    SIDE,
    TABLE_BEGIN,
    film_force,
    film_table,
    solve_film,
    table_force,
    table_scalar,
)

ECCENTRICITIES = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
LOADS = {
    1.0: (0.1196, 0.2518, 0.4091, 0.6108, 0.8903, 1.3146, 2.0432, 3.5663, 8.4352),
    0.5: (0.0368, 0.0783, 0.1304, 0.2026, 0.3124, 0.4982, 0.8595, 1.7339, 5.0881),
}
"""Sommerfeld number F psi^2/(B D eta omega) by width over diameter, and by eccentricity (H.-J. Butenschoen 1976)."""

ATTITUDES = {
    1.0: (79.410, 73.858, 68.264, 62.571, 56.705, 50.536, 43.859, 36.235, 26.482),
    0.5: (81.767, 75.142, 68.493, 61.778, 54.993, 48.049, 40.803, 32.938, 23.566),
}
"""Angle from the load to the line of centres [deg]."""

FLOWS = (0.1603, 0.3196, 0.4765, 0.6318, 0.7852, 0.9374, 1.0888, 1.2392, 1.3898)
"""Flow at the sides over R^3 psi omega, at a width of one diameter."""

ARCS = {
    0.5: {0.1: (4.3262, 81.755), 0.2: (2.0318, 75.13), 0.4: (0.78542, 61.774), 0.6: (0.31929, 48.046),
          0.8: (0.09171, 32.93), 0.9: (0.03124, 23.56)},
    1.0: {0.1: (1.3298, 79.41), 0.2: (0.63178, 73.857), 0.4: (0.26040, 62.569), 0.6: (0.12094, 50.53),
          0.8: (0.04456, 36.23), 0.9: (0.01882, 26.475)},
}  # fmt: skip
"""mu N L D/W (R/c)^2 and attitude [deg] by finite differences of another code, extrapolated."""

BOYD = {0.1: (1.33, 79.5), 0.2: (0.631, 74.02), 0.4: (0.264, 63.10), 0.6: (0.121, 50.58), 0.8: (0.0446, 36.24)}
"""The same by A. A. Raimondi and J. Boyd 1958, at a width of one diameter."""

SQUEEZE = {-0.9: 0.5518, -0.5: 0.971, 0.0: 2.4076, 0.1: 3.0122, 0.3: 5.0479, 0.5: 9.7319}
"""F psi^2/(B D eta e') of a pure squeeze, parting below 0, at a width of one diameter (Butenschoen 1976)."""

REYNOLDS = {
    0.2: (2.572559542, 66.89994), 0.5: (6.455556336, 58.29618),
    0.8: (15.08328123, 42.18096), 0.9: (27.65343433, 31.66654),
}  # fmt: skip
"""W c^2/(mu omega R^3 L) and attitude of an infinitely long film with Reynolds' condition."""


def steady(eps, ratio, **more):
    """Sommerfeld number, attitude [deg] and flow over R^3 psi omega at a constant spin."""
    found = solve_film(eps, 0.0, 0.5 * eps, ratio, **more)
    load, attitude = math.hypot(found.radial, found.tangential), math.atan2(found.tangential, -found.radial)
    return 0.5 * load, math.degrees(attitude), found.side / 6.0


@pytest.mark.parametrize("ratio", LOADS)
def test_published_loads_and_attitudes(ratio):
    for eps, load, attitude in zip(ECCENTRICITIES, LOADS[ratio], ATTITUDES[ratio], strict=True):
        assert steady(eps, ratio)[:2] == (pytest.approx(load, rel=3e-3), pytest.approx(attitude, abs=0.05)), eps


@pytest.mark.parametrize("ratio", ARCS)
def test_loads_and_attitudes_of_another_code(ratio):
    for eps, (number, attitude) in ARCS[ratio].items():
        load, angle, _ = steady(eps, ratio)
        assert 1.0 / (2.0 * math.pi * load) == pytest.approx(number, rel=1e-3)
        assert angle == pytest.approx(attitude, abs=0.05)


def test_loads_and_attitudes_of_raimondi_and_boyd():
    for eps, (number, attitude) in BOYD.items():
        load, angle, _ = steady(eps, 1.0)
        assert 1.0 / (2.0 * math.pi * load) == pytest.approx(number, rel=1.4e-2)
        assert angle == pytest.approx(attitude, abs=0.6)


def test_published_flows():
    for eps, flow in zip(ECCENTRICITIES, FLOWS, strict=True):
        assert steady(eps, 1.0)[2] == pytest.approx(flow, rel=1e-2)


@pytest.mark.parametrize("eps", SQUEEZE)
def test_published_squeeze(eps):
    found = solve_film(abs(eps), math.copysign(1.0, eps), 0.0, 1.0, from_widest=False)
    assert 0.5 * abs(found.radial) == pytest.approx(SQUEEZE[eps], rel=3e-3)
    assert abs(found.tangential) < 1e-9 * abs(found.radial)


def test_film_that_begins_anywhere():
    """Without p = 0 at the widest gap the attitude is 58.68 and not 56.71 degrees."""
    assert steady(0.5, 1.0, from_widest=False)[1] == pytest.approx(58.68, abs=0.01)


@pytest.mark.parametrize("eps", REYNOLDS)
def test_a_wide_bearing_is_a_long_one(eps):
    load, attitude = REYNOLDS[eps]
    found, angle, _ = steady(eps, 200.0, cells=192, layers=40)
    assert 2.0 * found == pytest.approx(load, rel=6e-3)
    assert angle == pytest.approx(attitude, abs=0.05)


@pytest.mark.parametrize("eps", [0.2, 0.6])
def test_a_narrow_bearing_is_a_short_one(eps):
    for a, b in ((0.0, 1.0), (1.0, 0.0), (0.5, -0.7)):
        found = solve_film(eps, a, b, 0.02, from_widest=False)
        expected = 4.0 * 0.02**2 * np.array(film_force(SHORT, 0.0, eps, a, b)[:2])
        assert (found.radial, found.tangential) == pytest.approx(expected, abs=3e-3 * np.abs(expected).max())


def test_pressures_solve_the_complementarity_problem():
    """p >= 0, and finer cells change the force by the error that is stated: 0.1 % up to an eccentricity of 0.9."""
    for eps, bound in ((0.3, 1e-3), (0.9, 1e-3), (0.97, 3e-3)):
        for a, b in ((0.0, 1.0), (0.3, -1.0), (-0.3, 1.0)):
            coarse, fine = (solve_film(eps, a, b, 0.7, cells=n, layers=n // 8) for n in (96, 192))
            assert coarse.pressure.min() >= 0.0
            change = math.hypot(coarse.radial - fine.radial, coarse.tangential - fine.tangential)
            assert change < bound * math.hypot(fine.radial, fine.tangential) * (10.0 if a < 0.0 else 1.0)


@pytest.mark.quick(1)
@pytest.mark.parametrize("from_widest", [True, False])
def test_the_table_holds_the_forces(from_widest):
    """Errors by interpolation are below 5e-4 of the force of the same motion, parting turned into closing."""
    p = np.array([0.0] * TABLE_BEGIN + list(film_table(0.6, from_widest)))
    rng = np.random.default_rng(4)
    for _ in range(40):
        eps, alpha = 1.0 - math.exp(-rng.uniform(0.0, 4.5)), rng.uniform(-math.pi, math.pi)
        a, b = math.sin(alpha), math.cos(alpha)
        exact = solve_film(eps, a, b, 0.6, from_widest=from_widest)
        closing = solve_film(eps, abs(a), b, 0.6, from_widest=from_widest)
        force = np.array(table_force(p, eps, a, b))
        size = math.hypot(closing.radial, closing.tangential)
        assert math.hypot(force[0] - exact.radial, force[1] - exact.tangential) < 5e-4 * size
        assert table_scalar(p, PEAK, eps, a, b) == pytest.approx(exact.peak, abs=2e-2 * closing.peak)
        assert table_scalar(p, SIDE, eps, a, b) == pytest.approx(exact.side, rel=4e-2)


def test_equilibrium_of_the_joint_has_the_published_place():
    film = fm.FiniteBearing(viscosity=0.02, width=0.02)
    shaft = fm.RigidBody("journal", (0.0, 0.0), 1.0, 1.0)
    part = fm.JournalBearing(
        "B",
        fm.GROUND,
        shaft,
        at=(0.0, 0.0),
        clearance=5e-5,
        bearing_radius=0.01,
        normal=fm.contact.Hertz(1e9),
        film=film,
    )
    load = 0.8903 * 0.02 * 0.02 * 0.02 * 100.0 * (0.01 / 5e-5) ** 2
    found = part.equilibrium(load, 100.0)
    assert found.eccentricity == pytest.approx(0.5, abs=5e-4)
    assert math.degrees(found.attitude) == pytest.approx(56.705, abs=0.08)
    assert found.flow == pytest.approx(0.7852 * 0.01**2 * 5e-5 * 100.0, rel=1e-2)
    assert found.whirl_ratio == pytest.approx(0.5, abs=0.05)
