"""Periodic orbits: fixed points and multipliers of maps, closed forms of flows, rate of convergence, bad input."""

import math
import runpy
from pathlib import Path

import numpy as np
import pytest

from flexmb.dynamics.orbits.periodic_orbit import periodic_orbit
from flexmb.dynamics.sections import SectionMap
from flexmb.dynamics.systems.given import ODE, Map
from flexmb.errors import InputError

flows = runpy.run_path(str(Path(__file__).parent / "flows.py"))


def logistic(r=2.5, start=0.6):
    return Map(lambda x, r: r * x * (1 - x), [start], jacobian=lambda x, r: [[r * (1 - 2 * x[0])]], parameters={"r": r})


def henon(a=1.4, b=0.3, start=(0.6, 0.2)):
    return Map(
        lambda x, a, b: [1 - a * x[0] * x[0] + x[1], b * x[0]],
        start,
        jacobian=lambda x, a, b: [[-2 * a * x[0], 1], [b, 0]],
        parameters={"a": a, "b": b},
        name="Henon",
    )


@pytest.mark.parametrize("tangent", ["carried", "differences"])
def test_logistic_orbits_of_periods_one_and_two(tangent):
    r = 3.3
    one = periodic_orbit(logistic(r), tangent=tangent)
    assert one.state[0] == pytest.approx(1 - 1 / r, abs=1e-12)
    assert one.multipliers[0] == pytest.approx(2 - r, abs=1e-8)
    assert one.ok
    assert not one.stable
    two = periodic_orbit(logistic(r), times=2, settle=100, tangent=tangent)
    root = math.sqrt((r + 1) * (r - 3))
    points = sorted(two.samples()["x0"].values[:2])
    np.testing.assert_allclose(points, [(r + 1 - root) / (2 * r), (r + 1 + root) / (2 * r)], atol=1e-9)
    assert two.multipliers[0] == pytest.approx(4 + 2 * r - r * r, abs=1e-8)
    assert two.stable


def test_henon_has_its_saddle():
    # M. Henon, Comm. Math. Phys. 50 (1976) 69-77: unstable point (0.631354477..., 0.189406343...), slopes of the
    # invariant directions p1 = 0.155946322..., p2 = -1.923738858...
    orbit = periodic_orbit(henon())
    np.testing.assert_allclose(orbit.state, [0.631354477, 0.189406343], atol=1e-9)
    np.testing.assert_allclose(orbit.multipliers.real, [-1.923738858, 0.155946322], atol=1e-9)
    assert np.prod(orbit.multipliers).real == pytest.approx(-0.3, abs=1e-12)
    assert orbit.loss.kind == "flip"


@pytest.mark.parametrize("segments", [1, 8, 16])
@pytest.mark.filterwarnings("ignore:overflow")  # a correction that was too long
def test_long_orbits_of_henon_close_and_contract_areas_exactly(segments):
    # each part contracts areas by b = 0.3 an iteration, whatever the orbit
    orbit = periodic_orbit(henon(), times=16, settle=50, segments=segments)
    assert orbit.ok, orbit.status
    assert "already" not in orbit.status
    one = orbit.shooting.run(orbit.shooting.spread(orbit.state, 16), 16)
    for A in one.slopes:  # two products that nearly cancel: round-off of the square of its size
        assert abs(abs(np.linalg.det(A)) - 0.3 ** (16 / segments)) <= 2e-15 * np.linalg.norm(A, 2) ** 2
    whole = orbit.samples()
    assert float(abs(whole["x0"][-1] - whole["x0"][0])) < 1e-8


def test_several_parts_give_the_same_orbit():
    one = periodic_orbit(henon(), times=6, settle=20, segments=1)
    parts = periodic_orbit(henon(), times=6, guess=one.state + 1e-5, segments=3)
    np.testing.assert_allclose(parts.state, one.state, atol=1e-10)
    np.testing.assert_allclose(parts.multipliers[0], one.multipliers[0], rtol=1e-8)
    flow = flows["duffing"]()
    whole = periodic_orbit(flow, period=2 * math.pi / 0.6, settle=5)
    parts = periodic_orbit(flow, period=2 * math.pi / 0.6, settle=5, segments=4)
    np.testing.assert_allclose(parts.state, whole.state, atol=1e-9)
    np.testing.assert_allclose(np.sort_complex(parts.multipliers), np.sort_complex(whole.multipliers), atol=1e-8)


def test_a_period_that_amplifies_much_is_divided():
    # upright on a shaken base: differences grow by exp(9.4) = 1.2e4 in a period, and a motion from a guess falls over
    W = 2.0 / 3.0

    def upright(t, x, g):
        return [x[1], g * math.cos(W * t) + math.sin(x[0])]

    flow = flows["Smooth"](upright, lambda t, x, g: [[0, 1], [math.cos(x[0]), 0]], [0.0, 0.0], {"g": 0.3}, ["a", "b"])
    orbit = periodic_orbit(flow, period=2 * math.pi / W, guess=np.zeros((4, 2)))
    assert orbit.ok, orbit.status
    # of first order in g the amplitude is g/(1 + W^2)
    assert orbit.state[0] == pytest.approx(-0.3 / (1 + W * W), rel=0.02)
    assert orbit.multipliers[0].real > 1e4
    one = orbit.shooting.run(orbit.shooting.spread(orbit.state, orbit.period), orbit.period)
    np.testing.assert_allclose([np.linalg.det(A) for A in one.slopes], 1.0, atol=1e-8)  # nothing is damped
    again = periodic_orbit(flow, period=2 * math.pi / W, guess=orbit.state)
    assert again.ok, again.status
    assert again.shooting.segments == 2  # each grows by less than 1e4
    np.testing.assert_allclose(again.state, orbit.state, atol=1e-8)


def test_driven_linear_oscillator_is_found_in_one_step():
    zeta, F, W = 0.1, 1.0, 1.7
    orbit = periodic_orbit(flows["linear"](), period=2 * math.pi / W)
    x = F / (1.0 - W * W + 2j * zeta * W)
    np.testing.assert_allclose(orbit.state, [x.real, (1j * W * x).real], atol=1e-9)
    assert orbit.iterations == 1
    exact = np.exp((-zeta + 1j * math.sqrt(1 - zeta**2)) * 2 * math.pi / W)
    np.testing.assert_allclose(
        np.sort_complex(orbit.multipliers), np.sort_complex([exact, exact.conjugate()]), atol=1e-9
    )
    assert orbit.loss.kind == "neimark-sacker"
    assert orbit.loss.margin == pytest.approx(1 - abs(exact), abs=1e-9)
    later = orbit.samples(64)
    t = later["time"].values
    np.testing.assert_allclose(later["x"].values, (x * np.exp(1j * W * t)).real, atol=1e-9)


def test_a_period_may_depend_on_the_parameters():
    flow = flows["linear"]()
    flow.reset(parameters={"W": 2.5})
    orbit = periodic_orbit(flow, period=lambda p: 2 * math.pi / p["W"])
    assert orbit.period == pytest.approx(2 * math.pi / 2.5, rel=1e-15)
    assert orbit.state[0] == pytest.approx((1 / (1 - 2.5**2 + 0.5j)).real, abs=1e-9)


def test_van_der_pol():
    # period 6.6632868593 at mu = 1 (C. M. Andersen, J. F. Geer, SIAM J. Appl. Math. 42 (1982) 678-693); its second
    # multiplier is the exponential of the integral of the divergence mu (1 - x^2) over the orbit (Liouville)
    orbit = periodic_orbit(flows["van_der_pol"](), period=6.0, autonomous=True)
    assert orbit.period == pytest.approx(6.6632868593, abs=2e-10)
    assert orbit.shift == pytest.approx(1.0, abs=1e-9)
    x = orbit.samples(400)["x"].values[:-1]
    exact = math.exp(np.mean(1.0 - x**2) * orbit.period)  # periodic: the trapezoidal rule has the accuracy of round-off
    assert orbit.multipliers[0] == pytest.approx(exact, rel=1e-7)
    assert orbit.stable


@pytest.mark.slow
def test_stiff_van_der_pol():
    # mu = 5: 11.612230667 (the same source, and M. Urabe, IRE Trans. Circuit Theory 7 (1960) 382-386)
    orbit = periodic_orbit(flows["van_der_pol"](5.0), period=11.0, autonomous=True, settle=3)
    assert orbit.period == pytest.approx(11.612230667, abs=1e-8)


def test_convergence_is_quadratic_down_to_round_off():
    orbit = periodic_orbit(flows["duffing"](F=0.5, W=1.2), period=2 * math.pi / 1.2, guess=[2.0, 1.0], tolerance=1e-13)
    assert orbit.ok, orbit.status
    assert orbit.residual < 1e-13
    r = [x for x in orbit.residuals if 1e-12 < x < 1e-1]
    rates = [math.log(r[k + 1] / r[k]) / math.log(r[k] / r[k - 1]) for k in range(1, len(r) - 1)]
    assert max(rates) > 1.7
    # a monodromy that is wrong by a part in a thousand would give a ratio of 1e-3 at best
    assert min(b / a for a, b in zip(orbit.residuals, orbit.residuals[1:], strict=False)) < 1e-5


def test_an_orbit_found_twice_says_so():
    orbit = periodic_orbit(henon(), times=2, guess=[0.63, 0.19])
    assert orbit.ok
    assert "after 1 of the 2 periods" in orbit.status


@pytest.mark.slow
def test_whole_turns_of_an_angle():
    # a damped pendulum that goes round with its drive
    flow = flows["pendulum"](1.5, 4.0)
    flow.advance(60 * 3 * math.pi)
    start = flow.state()
    flow.advance(3 * math.pi)
    turned = flow.state()[0] - start[0]
    orbit = periodic_orbit(flow, period=3 * math.pi, angles=["theta"], iterations=50)
    travelled = orbit.samples(50)["theta"].values
    assert abs(turned) > 3.0
    assert orbit.ok, orbit.status
    turns = (travelled[-1] - travelled[0]) / (2 * math.pi)
    assert round(turns) != 0
    assert turns == pytest.approx(round(turns), abs=1e-8)
    without = periodic_orbit(flow, period=3 * math.pi, guess=orbit.state, iterations=3)
    assert not without.ok


def test_impact_oscillator_has_its_closed_form():
    # one impact a period: x = A cos t + B sin t + c cos(W t + phi), unknown A, B, phi and the speed v at the impact
    flow, exact = impacting(wall=0.5)
    orbit = periodic_orbit(flow, period=2 * math.pi / 1.6, guess=exact.before_section())
    assert orbit.ok, orbit.status
    assert np.linalg.det(orbit.monodromy) == pytest.approx(0.7**2, rel=1e-9)  # e^2 an impact
    np.testing.assert_allclose(orbit.state, exact.before_section(), atol=1e-9)
    assert np.trace(orbit.monodromy) == pytest.approx(exact.trace(), rel=1e-8)
    beside = periodic_orbit(flow, period=2 * math.pi / 1.6, guess=orbit.state, tangent="differences")
    assert np.trace(beside.monodromy) == pytest.approx(exact.trace(), rel=1e-6)


class Closed:
    """The orbit of `Impact` with one impact a period T = 2 pi n/W, from linear equations (S. W. Shaw, P. J. Holmes,
    Journal of Sound and Vibration 90 (1983) 129-155).

    With time counted from the impact, phase phi of the force there, x(0+) = x(T-) = wall, x'(0+) = -e v, x'(T-) = v,
    where c = F/(1 - W^2): A + c cos phi = wall, B - c W sin phi = -e v, A cos T + B sin T = A, -A sin T + B cos T -
    c W sin phi = v.
    """

    def __init__(self, F, W, e, wall, n=1, branch=0):
        self.F, self.W, self.e, self.wall, self.T = F, W, e, wall, 2 * math.pi * n / W
        c, C, S = F / (1 - W * W), math.cos(self.T), math.sin(self.T)
        # A = a v, B = b v, c W sin phi = s v from the last three; then cos^2 + sin^2 = 1
        M = np.array([[0.0, 1.0, -1.0], [C - 1.0, S, 0.0], [-S, C, -1.0]])
        a, b, s = np.linalg.solve(M, [-e, 0.0, 1.0])
        # (wall - a v)^2/c^2 + (s v/(c W))^2 = 1
        roots = np.roots([a * a + (s / W) ** 2, -2 * a * wall, wall * wall - c * c])
        self.v = sorted(r.real for r in roots if abs(r.imag) < 1e-12 and r.real > 0)[branch]
        self.A, self.B, self.c = a * self.v, b * self.v, c
        self.phi = math.atan2(s * self.v / (c * W), (wall - self.A) / c)

    def trace(self):
        """Of the derivative over a period: flight, then [[-e, 0], [(1 + e) a/v, -e]]."""
        a = self.F * math.cos(self.phi) - self.wall
        return -2 * self.e * math.cos(self.T) + (1 + self.e) * a / self.v * math.sin(self.T)

    def at(self, t):
        cos, sin = math.cos(t), math.sin(t)
        x = self.A * cos + self.B * sin + self.c * math.cos(self.W * t + self.phi)
        return np.array([x, -self.A * sin + self.B * cos - self.c * self.W * math.sin(self.W * t + self.phi)])

    def before_section(self):
        """State where the phase of the force is 0."""
        return self.at((-self.phi % (2 * math.pi)) / self.W)


def impacting(F=1.0, W=1.6, e=0.7, wall=0.5, branch=0):
    flow = flows["Impact"]([0.0, 0.0], {"F": F, "W": W, "e": e, "wall": wall})
    return flow, Closed(F, W, e, wall, branch=branch)


@pytest.mark.parametrize(
    ("system", "options", "words"),
    [
        (flows["duffing"](), {}, "no periodic drive and no period= is given"),
        (flows["duffing"](), {"period": -1.0}, "period is -1 s; it must be > 0"),
        (flows["duffing"](), {"period": 1.0, "guess": [1.0]}, r"shape \(1,\); it must have shape \(2,\)"),
        (flows["duffing"](), {"period": 1.0, "guess": [1.0, math.nan]}, "must be finite"),
        (flows["duffing"](), {"period": 1.0, "angles": ["thetas"]}, "angle is 'thetas'"),
        (flows["duffing"](), {"period": 1.0, "grazing": "gap"}, "grazing is 'gap'"),
        (flows["duffing"](), {"period": 1.0, "tangent": "exact"}, "tangent is 'exact'"),
        (henon(), {"period": 1.0}, "counts iterations"),
        (henon(), {"autonomous": True}, "counts iterations"),
        (henon(), {"times": 0}, "times is 0"),
        (henon(), {"times": 4, "segments": 3}, "must divide times"),
        (henon(), {"guess": [[1.0, 1.0], [1.0]], "times": 2}, r"shape \(1,\)"),
        (henon(), {"guess": [[1.0, 1.0], [1.0, 1.0]], "times": 4, "segments": 4}, "one for each of 4 segments"),
        (henon(), {"tolerance": 0.0}, "tolerance is 0"),
        ("henon", {}, "must be a flow or map"),
    ],
)
def test_what_is_refused(system, options, words):
    with pytest.raises(InputError, match=words):
        periodic_orbit(system, **options)


def test_no_convergence_is_a_status():
    orbit = periodic_orbit(logistic(3.9), guess=[0.4], iterations=1, tolerance=1e-14)
    assert not orbit.ok
    assert not orbit.stable
    assert "Not converged after 1 iterations" in orbit.status
    nothing = Map(lambda x: x + 0.1 + x * x, [0.3])  # it has no fixed point
    orbit = periodic_orbit(nothing)
    assert not orbit.ok
    assert "better guess" in orbit.status


@pytest.mark.filterwarnings("ignore:overflow")
def test_a_blow_up_is_a_status():
    orbit = periodic_orbit(henon(), times=30, guess=[2.0, 2.0])
    assert not orbit.ok
    assert "not finite" in orbit.status


def test_an_equilibrium_is_no_orbit():
    orbit = periodic_orbit(flows["van_der_pol"](), period=6.0, guess=[1e-3, 1e-3], autonomous=True, iterations=60)
    assert not orbit.ok or orbit.period == pytest.approx(6.6632868593, abs=1e-6)
    orbit = periodic_orbit(flows["van_der_pol"](), period=6.0, guess=[0.0, 0.0], autonomous=True)
    assert not orbit.ok
    assert "equilibrium" in orbit.status


def test_the_system_stays_as_it_is():
    system = henon()
    periodic_orbit(system, times=2, settle=10)
    np.testing.assert_array_equal(system.state(), system.start)
    assert system.time == 0.0


@pytest.mark.slow
def test_orbits_of_sections_have_the_multipliers_of_the_flow():
    # van der Pol: the multiplier is exp of the integral of the divergence mu (1 - x^2) over a period
    def rates(t, x, mu):
        return [x[1], mu * (1.0 - x[0] ** 2) * x[1] - x[0], 1.0 - x[0] ** 2]

    flow = ODE(lambda t, x, mu: rates(t, x, mu)[:2], [2.0, 0.0], parameters={"mu": 1.0}, names=["x", "v"])
    section = SectionMap(flow, "v", direction="down")
    for guess in (None, [1.5, 0.0], [0.3, 0.7]):
        orbit = periodic_orbit(section, guess=guess)
        assert orbit.ok, orbit.status
        assert orbit.residuals[-1] < 1e-3 * orbit.residuals[-2] < 1e-3 * orbit.residuals[0]
        whole = ODE(rates, [*orbit.state, 0.0], parameters={"mu": 1.0})
        whole.advance(6.663286859323)  # period at mu = 1
        assert whole.state()[:2] == pytest.approx(orbit.state, abs=1e-6)
        assert orbit.multipliers == pytest.approx([math.exp(whole.state()[2])], rel=1e-5)


def test_crossings_of_a_driven_flow_come_back_after_a_period():
    def f(t, x):
        return [x[1], 0.3 * math.cos(t) - 0.3 * x[1] - x[0] ** 3]

    flow = ODE(f, [1.0, 0.0], names=["x", "v"], period=2 * math.pi)
    at_phases = periodic_orbit(flow, settle=30)
    crossings = periodic_orbit(SectionMap(flow, "x", level=0.1), settle=10)
    assert crossings.ok, crossings.status
    assert crossings.multipliers == pytest.approx(at_phases.multipliers, abs=1e-6)
