"""Own equations whose functions are compiled: the same motions as without, closed forms, published digits, threads."""

import math
import pickle

import numba
import numpy as np
import pytest

import flexmb as fm

HOPF = 8.4911176351833  # of the valve, by the eigenvalues of its rest
REST = {9.5: 2.6690214805087}  # openings at which it rests, the roots of y^3 + 10 y^2 = q^2
TOPS = 8.343, 8.808  # of its chaotic motion at q = 7.5


@numba.njit(cache=True)
def valve(t, x, q):
    """A relief valve with opening, speed and pressure (C. Hos, A. Champneys, Physica D 241 (2012) 2068)."""
    return x[1], -1.25 * x[1] - (x[0] + 10.0) + x[2], 20.0 * (q - x[0] * math.sqrt(x[2]))


@numba.njit(cache=True)
def opening(t, x, q):
    """Distance of the valve from its seat."""
    return x[0]


@numba.njit(cache=True)
def rebound(t, x, q):
    """State after an impact on the seat."""
    return x[0], -0.8 * x[1], x[2]


@numba.njit(cache=True)
def ball(t, x, e, g):
    """A ball in free flight."""
    return x[1], -g


@numba.njit(cache=True)
def above(t, x, g, e):
    """Height of the ball; its parameters stand in another order."""
    return x[0]


@numba.njit(cache=True)
def bounce(t, x, e, g):
    """State of the ball after an impact."""
    return x[0], -e * x[1]


@numba.njit(cache=True)
def driven(t, x, A, w):
    """A damped oscillator under a force A cos w t."""
    return x[1], A * math.cos(w * t) - 0.1 * x[1] - x[0]


@numba.njit(cache=True)
def to_stop(t, x, A, w):
    """Distance of the oscillator from a stop at 1."""
    return 1.0 - x[0]


@numba.njit(cache=True)
def off_stop(t, x, A, w):
    """State after an impact on the stop."""
    return x[0], -0.8 * x[1]


@numba.njit(cache=True)
def bursting(t, x):
    """A rate that grows with the square of the state."""
    return (x[0] * x[0],)


@numba.njit(cache=True)
def rooted(t, x):
    """A rate that is no number behind 1."""
    return (1.0 + math.sqrt(1.0 - x[0]),)


@numba.njit(cache=True)
def broken(t, x, e, g):
    """A state after an impact that is no number."""
    return x[0], math.sqrt(x[1])


def system(names, functions, start, parameters, *, fast, **options):
    """A motion with impacts of compiled functions, or of the same functions in Python."""
    function, gap, jump = functions if fast else (one.py_func for one in functions)
    ode = fm.chaos.ODE(function, start, parameters=parameters, names=names.split(), **options)
    return fm.chaos.ImpactODE(ode, gap=gap, jump=jump)


def relief(q, start=(0.2, 0.0, 0.0), *, fast=True, rtol=1e-10):
    """The valve with a flow q."""
    return system("y v p", (valve, opening, rebound), start, {"q": q}, fast=fast, rtol=rtol, atol=1e-10)


def tops(q, start=(0.2, 0.0, 0.0), **how):
    """The section of the valve at its tops."""
    return fm.chaos.SectionMap(relief(q, start, **how), "v", direction="down", limit=100.0)


def falling(height, e=0.8, *, fast=True, jump=bounce):
    """A ball that falls from a height."""
    return system("y v", (ball, above, jump), (height, 0.0), {"e": e, "g": 9.8}, fast=fast)


def stopped(A, *, fast=True):
    """The oscillator with a stop."""
    period = {"period": lambda A, w: 2.0 * math.pi / w}
    functions = driven, to_stop, off_stop
    return system("x v", functions, (0.0, 0.0), {"A": A, "w": 1.0}, fast=fast, **period)


@pytest.mark.quick(1)
@pytest.mark.parametrize("make", [lambda **how: relief(7.5, **how), lambda **how: stopped(0.9, **how)])
def test_motions_are_those_of_the_same_functions_in_python(make):
    fast, slow = make(fast=True), make(fast=False)
    for duration in (0.3, 2.1, 4.0):
        assert fast.advance(duration), fast.status
        assert slow.advance(duration), slow.status
        assert fast.time == slow.time
        assert np.allclose(fast.state(), slow.state(), rtol=1e-7, atol=1e-9)


def test_sections_are_those_of_the_same_functions_in_python():
    sections = [tops(7.5, fast=fast) for fast in (True, False)]
    for _ in range(4):
        fast, slow = ((section.advance(1), section.flow.time, *section.state()) for section in sections)
        assert fast == pytest.approx(slow, rel=1e-8, abs=1e-9)
    assert abs(sections[0].state()[1]) < 1e-12


@pytest.mark.slow
def test_a_jump_across_the_level_is_a_crossing_with_and_without_compilation():
    both = []
    for fast in (True, False):
        section = fm.chaos.SectionMap(falling(1.0, fast=fast), "v", direction="up")
        assert section.advance(3)
        both.append((section.flow.time, *section.state()))
    assert both[0] == pytest.approx(both[1], rel=1e-9, abs=1e-12)
    assert both[0][1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("fast", [True, False])
def test_a_motion_may_end_within_round_off_behind_an_impact(fast):
    impact = math.sqrt(2.0 / 9.8)
    for ulps in range(-3, 8):
        flow = falling(1.0, fast=fast)
        assert flow.advance(impact + ulps * np.spacing(impact)), flow.status
        assert flow.advance(0.1), flow.status
        assert flow.state()[1] == pytest.approx(0.8 * 9.8 * impact - 0.98, rel=1e-9)


def test_a_bouncing_ball_has_its_closed_form():
    # Three impacts of a ball from 50 m within 5 s; digits by the formulas of free fall.
    flow = falling(50.0)
    assert flow.advance(5.0)
    assert flow.state() == pytest.approx([29.2445651649735, 7.348913032994705], rel=1e-12)


def test_the_error_falls_with_the_tolerance():
    errors = []
    for rtol in (1e-6, 1e-8, 1e-10):
        ode = fm.chaos.ODE(driven, [1.0, 0.0], parameters={"A": 0.0, "w": 1.0}, rtol=rtol, atol=rtol)
        ode.advance(20.0)
        w, t = math.sqrt(1.0 - 0.05**2), 20.0
        exact = math.exp(-0.05 * t) * (math.cos(w * t) + 0.05 / w * math.sin(w * t))
        errors.append(abs(ode.state()[0] - exact))
        assert errors[-1] < 20.0 * rtol
    assert errors[0] > 100.0 * errors[1] / 10.0 > 0.0
    assert errors[1] > errors[2]


def test_the_valve_rests_where_its_flow_balances():
    section = tops(9.5)
    assert section.advance(1056), section.status
    assert section.state()[0] == pytest.approx(REST[9.5], rel=1e-11)


def test_the_chaotic_valve_has_its_published_tops():
    section = tops(7.5)
    assert section.advance(1024), section.status
    found = [section.state()[0] for _ in range(32) if section.advance(1)]
    assert len(found) == 32
    assert TOPS[0] - 1e-3 < min(found)
    assert max(found) < TOPS[1] + 1e-3
    assert max(found) - min(found) > 0.8 * (TOPS[1] - TOPS[0])


@pytest.mark.parametrize(("q", "grows"), [(HOPF - 1.6e-4, True), (HOPF + 1.6e-4, False)])
def test_small_motions_of_the_valve_grow_below_its_hopf_bifurcation(q, grows):
    y = float(max(np.roots([1.0, 10.0, 0.0, -q * q]).real))
    section = tops(q, (y + 1e-4, 0.0, y + 10.0), rtol=1e-12)
    assert section.advance(10)
    before = section.state()[0] - y
    assert section.advance(1000)
    assert (section.state()[0] - y > before) == grows


@pytest.mark.slow
def test_a_short_passage_behind_the_wall_is_not_stepped_over():
    # The ball is thrown so that it would pass a ceiling by 1e-6 of its way for a moment.
    @numba.njit
    def below(t, x, top):
        return top - x[0]

    @numba.njit
    def thrown(t, x, top):
        return x[1], -1.0

    @numba.njit
    def back(t, x, top):
        return x[0], -x[1]

    ode = fm.chaos.ODE(thrown, [0.0, 1.0], parameters={"top": 0.5 * (1.0 - 1e-6)})
    flow = fm.chaos.ImpactODE(ode, gap=below, jump=back)
    assert flow.advance(2.0)
    speed = math.sqrt(1e-6)  # at the ceiling, which the ball meets at 1 - speed
    assert flow._last == pytest.approx(1.0 - speed, rel=1e-9)
    assert flow.state()[1] == pytest.approx(-speed - (2.0 - flow._last), rel=1e-9)


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: fm.chaos.ODE(bursting, [1.0]), "t = 1 s"),
        pytest.param(lambda: fm.chaos.ODE(rooted, [0.0]), "a rate is not finite", marks=pytest.mark.slow),
        (lambda: falling(1.0, 0.5), "Impacts pile up at t = 1.35"),
        (lambda: falling(1.0, jump=broken), "gives a state that is not finite"),
    ],
)
def test_motions_that_cannot_go_on_have_a_status(make, said):
    flow = make()
    with np.errstate(all="ignore"):
        assert not flow.advance(10.0)
    assert not flow.ok
    assert said in flow.status
    assert np.isfinite(flow.state()).all()
    assert not flow.advance(1.0)


def test_a_snapshot_goes_on_with_the_same_bits():
    flow = relief(7.5)
    flow.advance(1.7)
    saved = flow.snapshot()
    flow.advance(9.0)
    once = flow.state()
    flow.restore(saved)
    flow.advance(9.0)
    assert np.array_equal(flow.state(), once)


def test_diagrams_by_threads_and_pickled_systems_have_the_same_bits():
    section = tops(7.5)
    given = {"skip": 20, "keep": 5, "signals": ["y"]}
    alone, threads = (fm.bifurcation(section, "q", [5.0, 7.5, 9.0], executor=n, **given) for n in (None, 2))
    assert alone.ok.all()
    assert np.array_equal(alone.y, threads.y)
    sent = pickle.loads(pickle.dumps(section))  # noqa: S301 - written here
    sent.reset(parameters={"q": 5.0})
    sent.advance(24)
    assert sent.state()[0] == alone.y.values[0, -1]


def test_copies_and_points_of_a_diagram_share_their_kernels(monkeypatch):
    section = tops(7.5)
    section.advance(1)
    monkeypatch.setattr("flexmb.dynamics.systems.compiled_ode.kernel_of", None)
    found = fm.bifurcation(section, "q", [5.0, 7.5], skip=2, keep=1)
    assert found.ok.all()
    other = section.copy()
    assert other.advance(2)
    assert other.flow.time != section.flow.time


@pytest.mark.slow
def test_parameters_that_are_no_numbers_are_for_python():
    @numba.njit
    def linear(t, x, K):
        return -K @ x

    ode = fm.chaos.ODE(linear, [1.0, 2.0], parameters={"K": np.eye(2)})
    assert ode.advance(1.0)
    assert ode.state() == pytest.approx(np.exp(-1.0) * np.array([1.0, 2.0]), rel=1e-8)


def test_functions_that_return_whole_numbers_beside_floats_are_for_python():
    @numba.njit
    def mixed(t, x):
        return 1, -x[1]

    ode = fm.chaos.ODE(mixed, [0.0, 1.0])
    assert ode.advance(1.0)
    assert ode.state() == pytest.approx([1.0, math.exp(-1.0)], rel=1e-8)


@pytest.mark.slow
def test_exponents_use_the_same_functions():
    found = fm.lyapunov(fm.chaos.StroboscopicMap(stopped(0.5)), skip=20, periods=60, confirm=False)
    assert found.ok, found.status
