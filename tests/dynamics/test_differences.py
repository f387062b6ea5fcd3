"""Own systems without a Jacobian: tangents at any scale of the states, dependence on time, functions that change x."""

import math

import numba
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fm
from flexmb.dynamics.systems.differences import central_differences

SCALES = (1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9)
W = 1.2


def duffing(scale, **options):
    """x'' + 0.3 x' - x + x^3 = 0.2 cos 1.2 t, in another unit of length."""
    return fm.chaos.ODE(
        lambda t, x, s: [x[1], -0.3 * x[1] + x[0] - x[0] ** 3 / s**2 + 0.2 * s * np.cos(W * t)],
        [0.5 * scale, 0.0], parameters={"s": scale}, period=2.0 * np.pi / W, atol=1e-12 * scale, **options,
    )  # fmt: skip


def slope_of_duffing(t, x, s):
    return [[0.0, 1.0], [1.0 - 3.0 * x[0] ** 2 / s**2, -0.3]]


@pytest.mark.quick(2)
@pytest.mark.parametrize("scale", SCALES)
def test_tangents_are_the_same_in_any_unit(scale):
    def both(t, y):
        J = np.array(slope_of_duffing(t, y[:2], 1.0))
        rate = [y[1], -0.3 * y[1] + y[0] - y[0] ** 3 + 0.2 * np.cos(W * t)]
        return [*rate, *(J @ y[2:].reshape(2, 2)).ravel()]

    known = solve_ivp(both, (0.0, 6.0), [0.5, 0.0, 1.0, 0.0, 0.0, 1.0], "DOP853", rtol=1e-12, atol=1e-14).y[2:, -1]
    flow, T = duffing(scale), np.eye(2)
    assert flow.advance(6.0, T)
    np.testing.assert_allclose(T.ravel(), known, rtol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("scale", [1e-5, 1e5])
def test_multipliers_of_an_orbit_do_not_depend_on_the_unit(scale):
    orbit = fm.chaos.periodic_orbit(duffing(scale), settle=50)
    assert orbit.stable
    # 0.03906 +- 0.45426 i: of the variational equations at tolerance 1e-12
    np.testing.assert_allclose(sorted(orbit.multipliers.imag), [-0.4542615, 0.4542615], rtol=1e-5)
    np.testing.assert_allclose(orbit.multipliers.real, 0.03906495, rtol=1e-4)


@pytest.mark.parametrize("turns", [0.0, 1e1, 1e3, 1e5, 1e8])
def test_a_pendulum_that_has_run_through_many_turns(turns):
    angle = 2.0 * np.pi * turns + 0.7
    found = central_differences(lambda x: [x[1], -0.1 * x[1] - np.sin(x[0])], np.array([angle, 1.3]))
    np.testing.assert_allclose(found, [[0.0, 1.0], [-np.cos(angle), -0.1]], rtol=1e-6)


@pytest.mark.parametrize(("angle", "error"), [(0.5, 1e-8), (1e3, 1e-6), (6e5, 3e-6), (1e9, 3e-4)])
def test_a_circle_map_that_has_run_through_many_turns(angle, error):
    """The values keep spacing(angle) of round-off; far from it, the map looks like the identity."""
    found = central_differences(lambda x: x + 0.1 - 0.9 * np.sin(x), np.array([angle]))
    assert found.item() == pytest.approx(1.0 - 0.9 * np.cos(angle), abs=error)


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize(
    "point", [(0.0, 0.0), (0.0, 0.3), (1e-17, 1.0), (1e-9, 1e-3), (0.5, 0.3), (1.0, 0.0), (30.0, 1.0)]
)
def test_derivatives_at_zero_and_beside_it(scale, point):
    x = scale * np.array(point)
    found = central_differences(lambda x: [x[1], 0.2 * scale + x[0] - x[0] ** 3 / scale**2 - 0.3 * x[1]], x)
    np.testing.assert_allclose(found, slope_of_duffing(0.0, x, scale), rtol=1e-6, atol=0.0)


@pytest.mark.parametrize("offset", [0.0, 1e-17, 1e-7, 5e-7, 3e-6])
@pytest.mark.parametrize("speed", [0.0, 1e-3, 1e3])
def test_micrometres_beside_radians_per_second(offset, speed):
    """A spring that saturates within a micrometre, beside a rotor."""

    def rates(x):
        return [x[2], x[3], -1e4 * np.tanh(x[0] / 1e-6) - 3.0 * x[2], -1e9 * x[0] + np.sin(x[1]) - 0.1 * x[3]]

    found = central_differences(rates, np.array([offset, 100.0, 1e-3, speed]))
    stiffness = -1e10 / np.cosh(offset / 1e-6) ** 2
    known = [[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0], [stiffness, 0.0, -3.0, 0.0], [-1e9, np.cos(100.0), 0.0, -0.1]]
    np.testing.assert_allclose(found, known, rtol=1e-5)


@pytest.mark.parametrize("x", [0.0, 1e-20, 1e-12, 1e-6, 1.0])
def test_a_dependence_that_is_small_beside_the_value(x):
    assert central_differences(lambda x: [1.0 + x[0]], np.array([x])).item() == pytest.approx(1.0, rel=1e-7)
    assert central_differences(lambda x: [1e9 + 3.0 * x[0]], np.array([x])).item() == pytest.approx(3.0, rel=1e-5)


@pytest.mark.parametrize("x", [1e-14, 1e-12, 1e-10, 1e-7, 1e-3])
def test_round_off_within_a_function_is_no_bend(x):
    assert central_differences(lambda x: (1.0 + x) - 1.0, np.array([x])).item() == pytest.approx(1.0, rel=1e-6)


def test_parts_without_slope_and_domains_with_an_end():
    stop = central_differences(lambda x: [1e3 * max(0.0, x[0] - 1.0), 2.0 + max(0.0, x[0] - 1.0)], np.array([0.5]))
    np.testing.assert_array_equal(stop, [[0.0], [0.0]])
    root = central_differences(lambda x: [math.sqrt(x[0])], np.array([1e-9]))
    assert root.item() == pytest.approx(0.5 / math.sqrt(1e-9), rel=1e-7)
    beside = central_differences(lambda x: [abs(x[0] - 1.0)], np.array([1.0 + 1e-7]))  # closer than the first step
    assert beside.item() == pytest.approx(1.0, rel=1e-6)


@pytest.mark.slow
def test_a_map_with_large_states_has_the_exponent_of_its_jacobian():
    """Chirikov's standard map: at K = 6 the angle grows to 1e6."""

    def step(x, K):
        momentum = x[1] + K * np.sin(x[0])
        return [x[0] + momentum, momentum]

    def slope(x, K):
        c = K * np.cos(x[0])
        return [[1.0 + c, 1.0], [c, 1.0]]

    given = fm.chaos.Map(step, [1e6, 0.3], parameters={"K": 6.0}, jacobian=slope)
    without = fm.chaos.Map(step, [1e6, 0.3], parameters={"K": 6.0})
    known = fm.lyapunov(given, skip=50, periods=600, confirm=False).value
    assert fm.lyapunov(without, skip=50, periods=600, confirm=False).value == pytest.approx(known, rel=1e-5)


@numba.njit
def straight(t, x, s):
    """Free flight."""
    return x[2], x[3], 0.0, 0.0


@numba.njit
def from_stator(t, x, s):
    """Distance from a round stator, from within."""
    return s - math.hypot(x[0], x[1])


@numba.njit
def off_wall(t, x, s):
    """State after an impact on a post or on the stator."""
    r = math.hypot(x[0], x[1])
    approach = (x[0] * x[2] + x[1] * x[3]) / r
    return x[0], x[1], x[2] - 1.7 * approach * x[0] / r, x[3] - 1.7 * approach * x[1] / r


def rotor(scale, *, is_compiled=False):
    """A particle in a round stator, in free flight, in another unit of length."""
    f, g, j = (one if is_compiled else one.py_func for one in (straight, from_stator, off_wall))
    start = np.array([0.0, 0.3, 1.0, 0.2]) * scale
    return fm.chaos.ImpactODE(fm.chaos.ODE(f, start, atol=1e-13 * scale, parameters={"s": scale}), gap=g, jump=j)


def after_one_impact(x):
    """State at t = 1.2: the chord to the circle, the oblique impact, and straight on."""
    place, speed = x[:2], x[2:]
    a, b, c = speed @ speed, place @ speed, place @ place - 1.0
    time = (-b + np.sqrt(b * b - a * c)) / a
    place = place + time * speed
    normal = place / np.hypot(*place)
    speed = speed - 1.7 * (speed @ normal) * normal
    return np.concatenate([place + (1.2 - time) * speed, speed])


@pytest.mark.quick(1)
@pytest.mark.parametrize("is_compiled", [False, True])
@pytest.mark.parametrize("scale", SCALES)
def test_saltation_at_an_oblique_impact_does_not_depend_on_the_unit(scale, is_compiled):
    start, h = np.array([0.0, 0.3, 1.0, 0.2]), 1e-5
    known = np.array(
        [(after_one_impact(start + h * e) - after_one_impact(start - h * e)) / (2.0 * h) for e in np.eye(4)]
    )
    flow, T = rotor(scale, is_compiled=is_compiled), np.eye(4)
    assert flow.advance(1.2, T)
    np.testing.assert_allclose(flow.state() / scale, after_one_impact(start), rtol=1e-9)
    np.testing.assert_allclose(T, known.T, atol=2e-8)


@numba.njit
def from_post(t, x, s):
    """Distance from a round post."""
    return math.hypot(x[0], x[1]) - s


@pytest.mark.quick(7)
@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("is_compiled", [False, True])
def test_a_post_that_lies_within_one_step_is_hit_in_any_unit(scale, is_compiled):
    functions = [one if is_compiled else one.py_func for one in (straight, from_post, off_wall)]
    start = np.array([-1000.0, 0.9, 1.0, 0.0]) * scale
    ode = fm.chaos.ODE(functions[0], start, atol=1e-13 * scale, parameters={"s": scale}, driven=False)
    flow = fm.chaos.ImpactODE(ode, gap=functions[1], jump=functions[2])
    assert all(flow.advance(time) for time in (995.0, 3.0, 3.0, 3.0, 3.0))
    depth = math.sqrt(1.0 - 0.9**2)
    speed = 1.0 - 1.7 * depth**2, 1.7 * 0.9 * depth  # on the post at t = 1000 - depth
    expected = [-depth + (7.0 + depth) * speed[0], 0.9 + (7.0 + depth) * speed[1], *speed]
    np.testing.assert_allclose(flow.state() / scale, expected, rtol=1e-9)


def test_tangents_go_on_with_the_same_bits_from_a_snapshot_and_in_copies():
    flow, T = duffing(1e-6), np.eye(2)
    flow.advance(5.0, T)
    kept, half = flow.snapshot(), T.copy()
    flow.advance(5.0, T)
    for other in (flow, flow.copy(), duffing(1e-6)):
        again = half.copy()
        other.restore(kept)
        other.advance(5.0, again)
        np.testing.assert_array_equal(again, T)


def parametric(t, x):
    """A pendulum whose support moves: without drive at rest, and at rest at any time."""
    return [x[1], -0.1 * x[1] - (1.0 + 0.5 * np.cos(t)) * np.sin(x[0])]


DRIVEN = {
    "support of a pendulum": (parametric, [0.0, 0.0]),
    "support, in motion": (parametric, [0.0, 1.0]),
    "small parametric drive": (lambda t, x: [x[1], -x[0] * (1.0 + 1e-9 * np.cos(t))], [0.0, 0.0]),
    "micrometres": (lambda t, x: [x[1], -np.tanh(x[0] / 1e-6) * (2.0 + np.sin(t))], [0.0, 0.0]),
    "beyond a gap": (lambda t, x: [x[1], -x[0] - max(0.0, x[0] - 1.0) * np.cos(t)], [0.0, 0.0]),
    "quick drive": (lambda t, x: [np.cos(1e5 * t) - x[0]], [1.0]),
    "slow drive": (lambda t, x: [1e-4 * np.sin(1e-6 * t) - x[0]], [1.0]),
    "pulse at 20 s": (lambda t, x: [(1.0 if t > 20.0 else 0.0) - x[0]], [1.0]),
}
AUTONOMOUS = {
    "van der pol": (lambda t, x: [x[1], (1.0 - x[0] ** 2) * x[1] - x[0]], [2.0, 0.0]),
    "pendulum at rest": (lambda t, x: [x[1], -0.1 * x[1] - np.sin(x[0])], [0.0, 0.0]),
    "domain with an end": (lambda t, x: [-math.sqrt(x[0])], [1e-4]),
    "quick growth": (lambda t, x: [math.exp(x[0])], [0.0]),
    "large states": (lambda t, x: [x[1], -np.sin(x[0])], [1e9, 1.0]),
}


@pytest.mark.parametrize("name", DRIVEN)
def test_a_drive_that_vanishes_at_the_start_is_a_drive(name):
    assert fm.chaos.ODE(*DRIVEN[name]).driven


@pytest.mark.parametrize("name", AUTONOMOUS)
def test_autonomous_systems_stay_so(name):
    assert not fm.chaos.ODE(*AUTONOMOUS[name]).driven


def test_the_decision_does_not_depend_on_where_a_motion_stands():
    flow = fm.chaos.ODE(lambda t, x, a: [x[1], -x[0] * (1.0 + a * np.cos(t))], [0.0, 0.0], parameters={"a": 0.0})
    assert not flow.driven
    flow.reset(parameters={"a": 0.1})
    assert flow.driven
    flow.reset([0.0, 0.0])
    assert flow.driven


def test_a_section_of_parametric_excitation_goes_on_from_its_points():
    def section():
        return fm.chaos.SectionMap(fm.chaos.ODE(parametric, [0.0, 1.0], names=["x", "v"]), "v", direction="down")

    one, other = section(), section()
    assert one.size == 3
    assert one.advance(3)
    other.reset(one.state(), time=3)
    assert one.advance(1)
    assert other.advance(1)
    np.testing.assert_allclose(other.state(), one.state(), atol=1e-7)


def logistic_in_place(x, r):
    x[0] = r * x[0] * (1.0 - x[0])
    return x


def test_a_map_that_changes_its_argument_keeps_its_start():
    changing = fm.chaos.Map(logistic_in_place, [0.3], parameters={"r": 4.0})
    plain = fm.chaos.Map(lambda x, r: [r * x[0] * (1.0 - x[0])], [0.3], parameters={"r": 4.0})
    assert changing.start == [0.3]
    T, known = np.eye(1), np.eye(1)
    assert changing.advance(20, T)
    assert plain.advance(20, known)
    assert changing.state() == plain.state()
    np.testing.assert_array_equal(T, known)
    before = changing.state()
    changing.jacobian = lambda x, r: logistic_in_place(x, r).reshape(1, 1)
    changing.advance(1, T)
    assert changing.state() == 4.0 * before * (1.0 - before)


def test_a_function_that_returns_one_array_again_and_again():
    kept = np.zeros(2)

    def rates(t, x):
        kept[:] = x[1], -x[0]
        return kept

    flow, T = fm.chaos.ODE(rates, [1.0, 0.0]), np.eye(2)
    assert flow.advance(1.0, T)
    np.testing.assert_allclose(T, [[np.cos(1.0), np.sin(1.0)], [-np.sin(1.0), np.cos(1.0)]], atol=1e-8)
    kept_map = np.zeros(1)

    def halved(x):
        kept_map[:] = 0.5 * x
        return kept_map

    flow = fm.chaos.Map(halved, [1.0])
    flow.advance(1)
    other = flow.copy()
    flow.advance(3)
    assert other.state() == 0.5
    assert flow.state() == 0.0625


@numba.njit
def in_place(t, x):
    """Decay; the state is changed on the way."""
    x[0] = 1.0 * x[0] + 1e-3
    return (-(x[0] - 1e-3),)


@pytest.mark.parametrize("function", [in_place, in_place.py_func])
def test_rates_that_change_their_argument(function):
    flow = fm.chaos.ODE(function, [1.0])
    assert flow.start == [1.0]
    assert flow.advance(1.0)
    assert flow.state() == pytest.approx([math.exp(-1.0)], rel=1e-8)
    assert flow.start == [1.0]
