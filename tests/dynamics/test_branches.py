"""Branches of periodic orbits: values of bifurcations that are exact or published, folds, switches, endings."""

import math
import runpy
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from flexmb.dynamics.orbits.continuation import follow
from flexmb.dynamics.orbits.periodic_orbit import periodic_orbit
from flexmb.dynamics.systems.given import Map
from flexmb.errors import InputError

here = Path(__file__).parent
flows = runpy.run_path(str(here / "flows.py"))
orbits = runpy.run_path(str(here / "test_periodic_orbits.py"))
logistic, henon, Closed = orbits["logistic"], orbits["henon"], orbits["Closed"]


def kinds(branch):
    return [e.kind for e in branch.events]


def test_logistic_flips_at_3_and_its_doubled_orbit_at_1_plus_sqrt_6():
    branch = follow(periodic_orbit(logistic(2.5)), "r", (2.5, 4.0))
    assert branch.ok, branch.status
    assert kinds(branch) == ["flip"]
    assert branch.events[0].value == pytest.approx(3.0, abs=1e-8)
    np.testing.assert_allclose([p.state[0] for p in branch.points], [1 - 1 / p.value for p in branch.points], atol=1e-9)
    doubled = branch.switch()
    assert doubled.ok
    assert doubled.times == 2
    assert doubled.stable
    second = follow(doubled, "r", (None, 4.0))
    assert kinds(second) == ["flip"]
    assert second.events[0].value == pytest.approx(1 + math.sqrt(6), abs=1e-8)
    third = follow(second.switch(), "r", (None, 3.6))
    # 3.5440903595519...: J. S. Cottingham's and others' value of the second doubling's end (OEIS A086181)
    assert third.events[0].value == pytest.approx(3.5440903595519, abs=1e-7)


def test_logistic_window_of_period_three_begins_with_a_fold():
    orbit = periodic_orbit(logistic(3.84), times=3, settle=300)
    branch = follow(orbit, "r", (3.84, 3.8))
    assert kinds(branch) == ["fold"]
    assert branch.events[0].value == pytest.approx(1 + math.sqrt(8), abs=1e-8)
    assert branch.events[0].multipliers[0] == pytest.approx(1.0, abs=1e-5)
    stable = [p.stable for p in branch.points]
    assert stable == sorted(stable, reverse=True)  # it loses its stability once and for all
    # the branch turns back at the fold and leaves the range where it came in
    assert branch.points[-1].value > 3.84


def test_henon_folds_and_flips_where_theory_says():
    # fixed points exist for a > -(1 - b)^2/4 and flip at a = 3 (1 - b)^2/4 (Henon 1976, equations 8, 9); period 4
    # begins at (1 - b)^2 + (1 + b)^2/4, where the trace of the derivative of period 2 is -1 - b^2
    b = 0.3
    branch = follow(periodic_orbit(henon(0.2)), "a", (0.2, -1.0))
    assert kinds(branch) == ["fold", "flip"] or kinds(branch) == ["fold"]
    assert branch.events[0].value == pytest.approx(-((1 - b) ** 2) / 4, abs=1e-8)
    branch = follow(periodic_orbit(henon(0.2)), "a", (0.2, 1.0))
    assert kinds(branch) == ["flip"]
    assert branch.events[0].value == pytest.approx(0.75 * (1 - b) ** 2, abs=1e-8)
    second = follow(branch.switch(), "a", (None, 1.0))
    assert second.events[0].value == pytest.approx((1 - b) ** 2 + (1 + b) ** 2 / 4, abs=1e-8)


def test_delayed_logistic_map_loses_stability_to_a_torus():
    # x_{n+1} = r x_n (1 - x_{n-1}): a pair exp(+-i pi/3) at r = 2 (J. Maynard Smith 1968; Kuznetsov, example 4.2)
    delayed = Map(lambda x, r: [r * x[0] * (1 - x[1]), x[0]], [0.4, 0.4], parameters={"r": 1.6})
    branch = follow(periodic_orbit(delayed), "r", (1.6, 2.3))
    assert kinds(branch) == ["neimark-sacker"]
    event = branch.events[0]
    assert event.value == pytest.approx(2.0, abs=1e-7)
    assert event.multipliers[0] == pytest.approx(np.exp(1j * math.pi / 3), abs=1e-6) or event.multipliers[
        0
    ] == pytest.approx(np.exp(-1j * math.pi / 3), abs=1e-6)


def test_two_real_multipliers_with_product_1_are_no_torus():
    # multipliers 2 and p: their product passes 1 at p = 1/2
    saddle = Map(lambda x, p: [2 * x[0], p * x[1]], [0.0, 0.0], parameters={"p": 0.4})
    branch = follow(periodic_orbit(saddle), "p", (0.4, 0.8))
    assert kinds(branch) == []
    assert branch.ok


def test_pitchfork_is_a_branch_point_and_can_be_left():
    # x (r - x^2): branches x = 0 and x^2 = r - 1 cross at r = 1
    cubic = Map(lambda x, r: r * x - x**3, [0.0], parameters={"r": 0.5})
    branch = follow(periodic_orbit(cubic), "r", (0.5, 1.8))
    assert kinds(branch) == ["branch"]
    assert branch.events[0].value == pytest.approx(1.0, abs=1e-4)
    other = follow(branch.switch(step=0.2), "r", (None, 1.8))
    np.testing.assert_allclose([p.state[0] ** 2 for p in other.points], [p.value - 1 for p in other.points], atol=1e-8)


def harmonic_balance(W, d=0.1, F=0.5, beta=1.0, harmonics=25):
    """Coefficients by collocation in Fourier series: an independent solution of the Duffing equation."""
    n = 4 * harmonics
    t = 2 * np.pi * np.arange(n) / n
    k = np.arange(1, harmonics + 1, 2)
    basis = np.hstack([np.cos(np.outer(t, k)), np.sin(np.outer(t, k))])
    first = np.hstack([-np.sin(np.outer(t, k)) * k, np.cos(np.outer(t, k)) * k])
    second = -basis * np.concatenate([k, k]) ** 2

    def residual(c):
        x = basis @ c
        return np.linalg.lstsq(
            basis, W**2 * second @ c + d * W * first @ c + x + beta * x**3 - F * np.cos(t), rcond=None
        )[0]

    return basis, residual


@pytest.fixture(scope="module")
def resonance():
    flow = flows["duffing"](W=1.0)
    flow.tolerances = {"rtol": 1e-8, "atol": 1e-10}
    orbit = periodic_orbit(flow, period=lambda p: 2 * math.pi / p["W"], settle=20, tolerance=1e-8)
    return follow(orbit, "W", (1.0, 2.5), extremes=64, largest=0.2, tolerance=1e-8)


@pytest.mark.slow
def test_duffing_resonance_has_two_folds(resonance):
    assert resonance.ok, resonance.status
    assert kinds(resonance) == ["fold", "fold"]
    # the jump frequencies of one-term harmonic balance, a few parts in a thousand from those of the equation:
    # folds of [(1 - W^2 + 3/4 A^2)^2 + (d W)^2] A^2 = F^2
    upper, lower = (e.value for e in resonance.events)
    for exact, estimated in zip((upper, lower), jumps(), strict=True):
        assert exact == pytest.approx(estimated, rel=0.01)
    unstable = [p.value for p in resonance.points if not p.stable]
    assert min(unstable) == pytest.approx(lower, abs=0.05)
    assert max(unstable) == pytest.approx(upper, abs=0.05)


def jumps(d=0.1, F=0.5):
    """Largest W of the upper branch, smallest of the lower ones, by one harmonic; W^2 as a function of A."""
    A = np.linspace(0.05, 4.0, 400_000)
    s = 1 + 0.75 * A**2
    root = (s - d * d / 2) ** 2 - s * s + (F / A) ** 2
    A, s, root = A[root > 0], s[root > 0], np.sqrt(root[root > 0])
    plus, minus = np.sqrt(s - d * d / 2 + root), np.sqrt(np.maximum(s - d * d / 2 - root, 0))
    return max(minus.max(), plus[0.95 * A.max() < A].max()), plus.min()


@pytest.mark.slow
def test_duffing_points_solve_the_fourier_equations(resonance):
    for p in resonance.points[:: len(resonance.points) // 7]:
        basis, residual = harmonic_balance(p.value)
        orbit = resonance.orbit(p)
        samples = orbit.samples(len(basis))["x"].values[:-1]
        c = np.linalg.lstsq(basis, samples, rcond=None)[0]
        assert np.abs(residual(c)).max() < 1e-6


@pytest.mark.slow
def test_dataset_of_a_branch(resonance):
    data = resonance.to_dataset()
    assert dict(data.sizes) == {"point": len(resonance.points), "multiplier": 2, "event": 2}
    assert {"x", "v", "x.max", "x.min", "period", "stable", "residual", "multiplier.real"} <= set(data.data_vars)
    assert data["event.kind"].values.tolist() == ["fold", "fold"]
    np.testing.assert_allclose(data["period"], 2 * np.pi / data["W"], rtol=1e-14)
    # areas shrink by exp(-d T), on stable and unstable orbits alike
    product = data["multiplier.real"].prod("multiplier") - data["multiplier.imag"].prod("multiplier")
    real = (data["multiplier.imag"] == 0).all("multiplier")
    np.testing.assert_allclose(product[real], np.exp(-0.1 * data["period"])[real], rtol=1e-6)
    assert data.attrs["parameter"] == "W"
    assert data.attrs["ok"] == 1


@pytest.mark.slow
def test_driven_pendulum_doubles_where_published():
    # thresholds of the doublings 1.0663, 1.0793, 1.0821 (J. R. Taylor, Classical Mechanics, 2005, table 12.1: w = 2 pi,
    # w0 = 1.5 w, beta = w0/4; in units of w0 damping 1/2 and frequency 2/3), on the branch of orbits without symmetry
    orbit = periodic_orbit(flows["pendulum"](0.9), period=3 * math.pi, settle=30)
    branch = follow(orbit, "g", (0.9, 1.08))
    assert kinds(branch) == ["branch"]
    found, doubled = [], branch.switch(step=0.1)
    for step in (0.02, 0.004, None):
        assert doubled.ok, doubled.status
        side = follow(doubled, "g", (None, 1.09), largest=0.2)
        assert kinds(side) == ["flip"]
        found.append(side.events[0].value)
        doubled = side.switch(step=step) if step else None
    np.testing.assert_allclose(found, [1.0663, 1.0793, 1.0821], atol=1e-4)


@pytest.mark.slow
def test_van_der_pol_is_followed_with_its_period():
    # 2 pi/T = 1 - mu^2/16 + 17 mu^4/3072 + 35 mu^6/884736 - 678899 mu^8/5096079360 ... (Andersen, Geer 1982)
    orbit = periodic_orbit(flows["van_der_pol"](0.5), period=6.0, autonomous=True, settle=3)
    branch = follow(orbit, "mu", (0.5, 0.25))
    assert branch.ok, branch.status
    for p in branch.points:
        m = p.value**2
        series = 1 - m / 16 + 17 * m**2 / 3072 + 35 * m**3 / 884736 - 678899 * m**4 / 5096079360
        assert p.period == pytest.approx(2 * math.pi / series, abs=2e-3 * m**5 + 1e-9)


@pytest.mark.slow
def test_impact_oscillator_flips_where_its_closed_form_does():
    # the orbit flips where trace = -(1 + e^2), the determinant being e^2
    F, W, e = 1.0, 2.6, 0.8
    flip = brentq(lambda wall: Closed(F, W, e, wall).trace() + 1 + e * e, *bracket(F, W, e))
    start = flip - 0.02
    closed = Closed(F, W, e, start)
    flow = flows["Impact"](closed.before_section(), {"F": F, "W": W, "e": e, "wall": start})
    orbit = periodic_orbit(flow, period=2 * math.pi / W)
    assert orbit.ok, orbit.status
    branch = follow(orbit, "wall", (None, flip + 0.02))
    assert branch.ok, branch.status
    assert kinds(branch) == ["flip"]
    assert branch.events[0].value == pytest.approx(flip, abs=1e-7)


def bracket(F, W, e):
    """Walls on both sides of the flip."""
    walls = np.linspace(-0.05, 0.1, 151)
    values = [Closed(F, W, e, wall).trace() + 1 + e * e for wall in walls]
    k = next(k for k in range(150) if values[k] * values[k + 1] < 0)
    return walls[k], walls[k + 1]


@pytest.mark.slow
def test_impact_oscillator_at_a_wall_in_the_middle_flips_at_the_published_frequency():
    # Shaw and Holmes 1983: with the wall at the rest position and e = 0.8 the orbit flips at W = 2.65
    closed = Closed(1.0, 2.5, 0.8, 0.0)
    flow = flows["Impact"](closed.before_section(), {"F": 1.0, "W": 2.5, "e": 0.8, "wall": 0.0})
    branch = follow(periodic_orbit(flow, period=lambda p: 2 * math.pi / p["W"]), "W", (2.5, 2.75))
    assert kinds(branch) == ["flip"]
    assert branch.events[0].value == pytest.approx(2.65, abs=0.005)


@pytest.mark.slow
def test_orbit_without_impacts_ends_where_it_grazes():
    # the amplitude is F/|1 - W^2|
    F, W = 1.0, 1.6
    amplitude = F / (W * W - 1)
    flow = flows["Impact"]([-amplitude, 0.0], {"F": F, "W": W, "e": 0.7, "wall": 1.5 * amplitude})
    orbit = periodic_orbit(flow, period=2 * math.pi / W, grazing="gap")
    assert orbit.grazing["gap"] == pytest.approx(0.5 * amplitude, rel=1e-6)
    branch = follow(orbit, "wall", (None, 0.8 * amplitude), grazing="gap")
    assert not branch.ok
    assert "smaller than" in branch.status
    assert kinds(branch) == ["grazing"]
    assert branch.events[0].value == pytest.approx(amplitude, rel=1e-4)


@pytest.mark.slow
def test_touching_of_a_soft_stop_is_located():
    # a stop with a spring: the orbit goes on beyond the touch, which is where the free amplitude is the gap
    def f(t, x, wall):
        return [x[1], math.cos(1.6 * t) - 0.2 * x[1] - x[0] - 5.0 * max(x[0] - wall, 0.0)]

    def slope(t, x, wall):
        return [[0.0, 1.0], [-1.0 - 5.0 * (x[0] > wall), -0.2]]

    class Stop(flows["Smooth"]):
        def observe(self):
            return np.array([self.x[0], self._parameters["wall"] - self.x[0]])

    amplitude = abs(1 / (1 - 1.6**2 + 0.2j * 1.6))
    flow = Stop(f, slope, [0.0, 0.0], {"wall": 1.05 * amplitude}, ("x", "gap"))
    flow.tolerances = {"rtol": 1e-8, "atol": 1e-10}
    orbit = periodic_orbit(flow, period=2 * math.pi / 1.6, tolerance=1e-8)
    branch = follow(orbit, "wall", (None, 0.95 * amplitude), grazing="gap", tolerance=1e-8)
    assert branch.ok, branch.status
    assert kinds(branch) == ["grazing"]
    assert branch.events[0].value == pytest.approx(amplitude, rel=1e-5)


def test_a_range_is_held():
    branch = follow(periodic_orbit(logistic(2.5)), "r", (2.5, 2.6), points=3)
    assert not branch.ok
    assert len(branch.points) == 3
    assert "3 points, as asked for" in branch.status


def test_what_is_refused():
    orbit = periodic_orbit(logistic(2.5))
    with pytest.raises(InputError, match="must be a periodic orbit that was found"):
        follow(periodic_orbit(logistic(3.9), guess=[0.4], iterations=0), "r", (2.5, 3.0))
    with pytest.raises(InputError, match="parameter is 's'"):
        follow(orbit, "s", (2.5, 3.0))
    with pytest.raises(InputError, match="both ends must differ"):
        follow(orbit, "r", (None, 2.5))
    with pytest.raises(InputError, match=r"must be a pair \(from, to\)"):
        follow(orbit, "r", 3.0)
    with pytest.raises(InputError, match="largest is 0"):
        follow(orbit, "r", (2.5, 3.0), largest=0.0)
    branch = follow(orbit, "r", (2.5, 2.7))
    with pytest.raises(InputError, match="Events: none"):
        branch.switch()
    with pytest.raises(InputError, match="point is 99"):
        branch.orbit(99)
