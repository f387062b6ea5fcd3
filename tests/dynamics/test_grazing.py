"""Branches of orbits with rigid impacts through grazing, and curves of events in two parameters, by closed forms."""

import math

import numba
import numpy as np
import pytest
import scipy.linalg
import scipy.optimize

import flexmb as fm
from flexmb.dynamics.systems.impact_ode import FromImpact

C, E = 0.1, 0.8
TURN = 2.0 * math.pi


@numba.njit
def rates(t, x, A, w):
    """Rates of x'' + C x' + x = A cos(w t)."""
    return x[1], A * math.cos(w * t) - C * x[1] - x[0]


@numba.njit
def gap(t, x, A, w):
    """Distance of a stop at x = 1."""
    return 1.0 - x[0]


@numba.njit
def jump(t, x, A, w):
    """State after an impact."""
    return x[0], -E * x[1]


def oscillator(A=0.5, w=1.0, rtol=1e-10, functions=(rates, gap, jump)):
    """x'' + C x' + x = A cos(w t), with a stop at x = 1."""
    ode = fm.chaos.ODE(
        functions[0],
        [0.0, 0.0],
        jacobian=lambda t, x, A, w: [[0.0, 1.0], [-1.0, -C]],
        parameters={"A": A, "w": w},
        names=["x", "v"],
        period=lambda A, w: TURN / w,
        rtol=rtol,
        atol=1e-3 * rtol,
    )
    return fm.chaos.ImpactODE(ode, gap=functions[1], jump=functions[2])


class Closed:
    """The orbit with one impact a period 2 pi, of the speed v, at w = 1: amplitude, phase, multipliers.

    The motion is h + p with p = (A/C) sin t and a free vibration h, whose values before and after a period follow from
    the impact.
    """

    def __init__(self, v):
        free = scipy.linalg.expm(np.array([[0.0, 1.0], [-1.0, -C]]) * TURN)
        p, rate = np.linalg.solve(free - np.eye(2), free @ [1.0, -E * v] - [1.0, v])
        self.A, self.phase, self.v = C * math.hypot(p, rate), math.atan2(p, rate), v
        before = np.array([v, self.A * math.cos(self.phase) - C * v - 1.0])
        after = np.array([-E * v, self.A * math.cos(self.phase) + C * E * v - 1.0])
        jump = np.diag([1.0, -E])
        self.multipliers = np.linalg.eigvals(free @ (jump + np.outer(after - jump @ before, [1.0, 0.0]) / v))

    @staticmethod
    def fold():
        found = scipy.optimize.minimize_scalar(lambda v: Closed(v).A, bounds=(1e-4, 0.02), options={"xatol": 1e-10})
        return found.fun

    @staticmethod
    def at(A):
        return Closed(scipy.optimize.brentq(lambda v: Closed(v).A - A, 0.005, 3.0, xtol=1e-14))


@pytest.fixture(scope="module")
def touching():
    """Upwards from motions without impacts, through grazing."""
    orbit = fm.chaos.periodic_orbit(oscillator(0.08), settle=10)
    return fm.chaos.follow(orbit, "A", (None, 0.115), largest=0.1)


def kinds(branch):
    return [e.kind for e in branch.events]


def test_the_closed_form_is_the_given_one():
    # digits of an independent computation: amplitude, phase, speed, multiplier
    for A, phase, v, multiplier in (
        (1.0, 0.07595216, 1.69573294, -0.5842953 + 0.0056003j),
        (0.8, 0.10110512, 1.35356086, None),
        (0.5, 0.17711236, 0.83701602, -0.58116589 + 0.06065134j),
    ):
        one = Closed.at(A)
        assert (one.phase, one.v) == pytest.approx((phase, v), abs=1e-8)
        if multiplier is not None:
            assert max(one.multipliers, key=lambda m: m.imag) == pytest.approx(multiplier, abs=1e-7)
        assert np.prod(one.multipliers) == pytest.approx(E**2 * math.exp(-TURN * C), rel=1e-10)
    assert Closed.at(0.101).multipliers[0].real == pytest.approx(-0.4062546, abs=1e-6)
    assert Closed.at(0.1005).multipliers[0].real == pytest.approx(-0.3481, abs=1e-4)
    assert Closed.fold() == pytest.approx(0.0999707536, abs=1e-10)


@pytest.mark.slow
def test_a_branch_passes_grazing_and_turns_in_the_fold_behind_it(touching):
    assert touching.ok, touching.status
    assert kinds(touching) == ["grazing", "fold"]
    grazing, fold = touching.events
    assert grazing.value == pytest.approx(0.1, abs=1e-9)
    assert fold.value == pytest.approx(Closed.fold(), abs=1e-10)
    free = [p for p in touching.points if len(p.impact_speeds) == 0]
    hitting = touching.points[len(free) :]
    np.testing.assert_allclose([p.grazing["gap"] for p in free], [1.0 - p.value / C for p in free], atol=1e-8)
    # motions without impacts, and at grazing, have the multipliers of the free oscillator
    for p in (*free, grazing):
        assert np.abs(p.multipliers) == pytest.approx(math.exp(-0.5 * C * TURN), rel=1e-7)
    assert len(hitting) > 5
    for p in hitting:
        one = Closed(float(p.impact_speeds[0]))
        assert p.value == pytest.approx(one.A, abs=1e-9)
        assert np.sort_complex(p.multipliers) == pytest.approx(np.sort_complex(one.multipliers), rel=1e-4)
        assert np.prod(p.multipliers) == pytest.approx(E**2 * math.exp(-TURN * C), rel=1e-6)
    table = touching.to_dataset()
    assert list(table["event.kind"].values) == ["grazing", "fold"]
    assert np.isnan(table["grazing.gap"].values[-1])  # no turning point besides the impact


@pytest.mark.slow
def test_the_same_way_back():
    one = Closed.at(0.15)
    flow = oscillator(0.15)
    flow.reset([1.0, -E * one.v], time=one.phase)
    flow.advance(TURN - one.phase)
    orbit = fm.chaos.periodic_orbit(oscillator(0.15), guess=flow.state())
    assert orbit.multipliers == pytest.approx(one.multipliers, abs=1e-6)
    branch = fm.chaos.follow(orbit, "A", (None, 0.09), extremes=50, largest=0.1)
    assert branch.ok, branch.status
    assert kinds(branch) == ["fold", "grazing"]
    assert branch.events[0].value == pytest.approx(Closed.fold(), abs=1e-10)
    assert branch.events[1].value == pytest.approx(0.1, abs=1e-9)
    assert len(branch.points[-1].impact_speeds) == 0
    assert branch.points[-1].extremes[0, 1] == pytest.approx(branch.points[-1].value / C, rel=2e-2)
    hitting = [p for p in branch.points if len(p.impact_speeds)]
    for point in (hitting[3], branch.points[-1], branch.events[1]):  # where the end of the branch has none
        again = branch.orbit(point)
        assert again.ok
        assert again.multipliers == pytest.approx(point.multipliers, abs=1e-6)


@pytest.mark.slow
def test_the_doubled_orbit_of_a_branch_that_passes_grazing():
    # at w = .35 two impacts a period; the flip lies before the grazing at which one of them is lost
    orbit = fm.chaos.periodic_orbit(oscillator(1.03, w=0.35, rtol=1e-7), settle=60)
    branch = fm.chaos.follow(orbit, "A", (None, 0.955), step=0.05, largest=0.2)
    assert kinds(branch) == ["flip", "grazing"]
    doubled = branch.switch(0)
    assert doubled.ok, doubled.status
    assert doubled.times == 2
    assert "already" not in doubled.status


def test_grazing_curve_over_amplitude_and_frequency(touching):
    curve = touching.curve(0, "w", (0.99, 1.02), step=0.3)
    assert curve.ok, curve.status
    A, w = curve["A"].values, curve["w"].values
    assert w.min() < 0.99 < 1.02 < w.max()
    np.testing.assert_allclose(A, np.sqrt((1.0 - w**2) ** 2 + (C * w) ** 2), atol=1e-7)
    np.testing.assert_allclose(curve["period"].values, TURN / w, rtol=1e-12)


@pytest.mark.slow
def test_a_fast_oscillator_whose_period_is_told_to_the_orbit_alone():
    # a kilohertz: speeds are a thousand times the displacements
    s = 1e-3
    ode = fm.chaos.ODE(
        lambda t, x, A: [x[1], (A * math.cos(t / s) - C * s * x[1] - x[0]) / s**2],
        [0.0, 0.0],
        jacobian=lambda t, x, A: [[0.0, 1.0], [-1.0 / s**2, -C / s]],
        parameters={"A": 0.09},
    )
    flow = fm.chaos.ImpactODE(ode, gap=lambda t, x, A: 1.0 - x[0], jump=lambda t, x, A: [x[0], -E * x[1]])
    orbit = fm.chaos.periodic_orbit(flow, settle=10, period=TURN * s)
    branch = fm.chaos.follow(orbit, "A", (None, 0.105), largest=0.1)
    assert branch.ok, branch.status
    assert kinds(branch) == ["grazing", "fold"]
    assert branch.events[0].value == pytest.approx(0.1, abs=1e-9)
    assert branch.events[1].value == pytest.approx(Closed.fold(), abs=1e-9)
    last = branch.points[-1]
    assert last.value == pytest.approx(Closed(float(last.impact_speeds[0]) * s).A, abs=1e-8)


@pytest.mark.slow
def test_a_wall_moves_beyond_the_position_of_rest_where_the_flow_starts():
    ode = fm.chaos.ODE(
        lambda t, x, wall: [x[1], 0.4 * math.cos(2.0 * t) - C * x[1] - x[0]],
        [0.0, 0.0],
        parameters={"wall": 0.1},
        period=math.pi,
    )
    flow = fm.chaos.ImpactODE(ode, gap=lambda t, x, wall: wall - x[0], jump=lambda t, x, wall: [x[0], -E * x[1]])
    free, answer = scipy.linalg.expm(np.array([[0.0, 1.0], [-1.0, -C]]) * math.pi), 0.4 / (2j * C - 3.0)

    def forced(wall, v):
        """Forced motion, as a complex number, at the impact of the orbit with one impact a period, of the speed v."""
        x, rate = np.linalg.solve(free - np.eye(2), free @ [wall, -E * v] - [wall, v])
        return complex(x, -0.5 * rate)

    v = scipy.optimize.brentq(lambda v: abs(forced(0.1, v)) - abs(answer), 0.5, 1.5)
    hit = 0.5 * np.angle(forced(0.1, v) / answer) % math.pi
    flow.reset([0.1, -E * v], time=hit)
    flow.advance(math.pi - hit)
    orbit = fm.chaos.periodic_orbit(flow, guess=flow.state())
    branch = fm.chaos.follow(orbit, "wall", (None, -0.05), step=0.3, largest=0.5)
    assert branch.ok, branch.status
    for p in branch.points:
        assert abs(forced(p.value, float(p.impact_speeds[0]))) == pytest.approx(abs(answer), abs=1e-8)


def test_a_rebound_into_the_wall_ends_with_a_status():
    in_python = [one.py_func for one in (rates, gap, jump)]
    system = FromImpact(oscillator(functions=in_python), np.array([1.1, -0.5]), 0.0, 1, 1.0)
    assert not system.advance(1.0)
    assert "Start in flight" in system.status


@pytest.mark.slow
def test_flip_curve_of_a_bouncing_ball():
    # once a period: the table rises with (1 - e)/(1 + e) g T/2 at the impact; the orbit flips where the derivative
    # of the table's speed is 2 g (1 + e^2)/(1 + e)^2 (P. J. Holmes, J. Sound Vib. 84 (1982) 173-189)
    g, e, w = 9.81, 0.5, TURN
    fall = fm.chaos.ODE(
        lambda t, x, a, g: [x[1], -g],
        [0.3, 0.0],
        jacobian=lambda t, x, a, g: [[0.0, 1.0], [0.0, 0.0]],
        parameters={"a": 0.3, "g": g},
        period=lambda a, g: 1.0,
        rtol=1e-10,
        atol=1e-13,
    )
    ball = fm.chaos.ImpactODE(
        fall,
        gap=lambda t, x, a, g: x[0] - a * math.sin(w * t),
        jump=lambda t, x, a, g: [x[0], (1.0 + e) * a * w * math.cos(w * t) - e * x[1]],
    )
    rise = 0.5 * g * (1.0 - e) / (1.0 + e)
    hit = math.acos(rise / (0.3 * w)) / w
    rest = 1.0 - hit
    start = [0.3 * math.sin(w * hit) + 0.5 * g * rest - 0.5 * g * rest**2, 0.5 * g - g * rest]
    orbit = fm.chaos.periodic_orbit(ball, guess=start)
    assert orbit.stable
    branch = fm.chaos.follow(orbit, "a", (None, 0.45))
    bend = lambda g: 2.0 * g * (1.0 + e**2) / (1.0 + e) ** 2  # noqa: E731
    exact = lambda g: math.hypot(0.5 * g * (1.0 - e) / (1.0 + e) / w, bend(g) / w**2)  # noqa: E731
    assert kinds(branch) == ["flip"]
    assert branch.events[0].value == pytest.approx(exact(g), abs=1e-8)
    curve = branch.curve(0, "g", (9.5, 10.0), step=0.2)
    assert curve.ok, curve.status
    np.testing.assert_allclose(curve["a"].values, [exact(x) for x in curve["g"].values], atol=1e-7)


@pytest.mark.slow
def test_grazing_curve_of_a_soft_stop():
    # the free amplitude is the gap where the orbit touches
    def f(t, x, wall, w):
        return [x[1], math.cos(w * t) - 0.2 * x[1] - x[0] - 5.0 * max(x[0] - wall, 0.0)]

    flow = fm.chaos.ODE(
        f,
        [0.0, 0.0],
        parameters={"wall": 0.7, "w": 1.6},
        names=["x", "v"],
        period=lambda wall, w: TURN / w,
        jacobian=lambda t, x, wall, w: [[0.0, 1.0], [-1.0 - 5.0 * (x[0] > wall), -0.2]],
        rtol=1e-8,
        atol=1e-10,
    )
    flow = Watched(flow)
    orbit = fm.chaos.periodic_orbit(flow, settle=30, grazing="gap")
    branch = fm.chaos.follow(orbit, "wall", (None, 0.6), grazing="gap", step=0.1, largest=0.3)
    assert kinds(branch) == ["grazing"]
    curve = branch.curve(0, "w", (1.55, 1.65), step=0.3)
    assert curve.ok, curve.status
    w = curve["w"].values
    np.testing.assert_allclose(curve["wall"].values, np.abs(1.0 / (1.0 - w**2 + 0.2j * w)), rtol=1e-5)


class Watched(fm.chaos.ODE):
    """A flow that observes its distance from a stop as well."""

    def __init__(self, flow):
        vars(self).update(vars(flow))
        self.names, self.units = ("x", "gap"), ("", "")

    def observe(self):
        return np.array([self._state[0], self._parameters["wall"] - self._state[0]])


def test_what_a_curve_refuses(touching):
    with pytest.raises(fm.errors.InputError, match=r"event is 'fold'; .* Events: 0: grazing at 0\.1, 1: fold"):
        touching.curve(1, "w", (0.9, 1.1))
    with pytest.raises(fm.errors.InputError, match="along which the branch runs"):
        touching.curve(0, "A", (0.9, 1.1))
    with pytest.raises(fm.errors.InputError, match="must hold 1, the value of 'w'"):
        touching.curve(0, "w", (1.1, 1.2))
    with pytest.raises(fm.errors.InputError, match="parameter"):
        touching.curve(0, "omega", (0.9, 1.1))
    with pytest.raises(fm.errors.InputError, match="event is 7"):
        touching.curve(7, "w", (0.9, 1.1))


def test_an_unknown_gap_is_refused(touching):
    with pytest.raises(fm.errors.InputError, match="grazing is 'distance'"):
        fm.chaos.follow(touching.orbit(0), "A", (None, 0.09), grazing="distance")


@pytest.mark.slow
def test_a_free_oscillation_that_meets_a_wall_says_why_its_branch_ends():
    ode = fm.chaos.ODE(
        lambda t, x, wall: [x[1], 0.5 * (1.0 - x[0] ** 2) * x[1] - x[0]], [2.0, 0.0], parameters={"wall": 2.01}
    )
    flow = fm.chaos.ImpactODE(ode, gap=lambda t, x, wall: wall - x[0], jump=lambda t, x, wall: [x[0], -E * x[1]])
    orbit = fm.chaos.periodic_orbit(flow, period=6.4, autonomous=True, settle=5)
    branch = fm.chaos.follow(orbit, "wall", (None, 1.9))
    assert not branch.ok
    assert "()" not in branch.status
    assert branch.points[-1].value == pytest.approx(2.0, abs=0.02)
