"""Verdicts on motions whose kind is known, seen through all signals and through each alone."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import flexmb as fm

COUNT = 1000
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


def logistic_points(maps, r, count=COUNT, **options):
    return maps["logistic"](count, r, **options)[:, None]


def spiral(rate, count=COUNT):
    n = np.arange(count)
    return np.stack([rate**n * np.cos(n), rate**n * np.sin(n)], axis=1)


def verdicts(points, **options):
    """Of all signals together, and of each alone."""
    names = [f"x{k}" for k in range(points.shape[1])]
    alone = [fm.chaos.judge(points[:, [k]], [names[k]], **options) for k in range(len(names))] if len(names) > 1 else []
    return [fm.chaos.judge(points, names, **options), *alone]


# Cycles: parameters of the windows from R. M. May, Nature 261 (1976) 459: period 2 at 3, 4 at 3.4495, 8 at 3.5441,
# 16 at 3.5644, accumulation at 3.5699, period 3 at 1 + sqrt(8) = 3.8284.


@pytest.mark.parametrize(("r", "k"), [(2.8, 1), (3.2, 2), (3.5, 4), (3.55, 8), (3.566, 16), (3.83, 3)])
@pytest.mark.parametrize("count", [120, 1000])
def test_cycles_of_the_logistic_map(maps, r, k, count):
    found = fm.chaos.judge(logistic_points(maps, r, count), ["x"])
    assert str(found) == f"periodic-{k}", found.reason
    assert found.k == k


def test_a_cycle_longer_than_the_record_can_show_is_not_invented(maps):
    found = fm.chaos.judge(logistic_points(maps, 3.566, 60), ["x"])
    assert str(found) == "inconclusive"
    assert "No cycle of up to 10 points" in found.reason


def test_a_cycle_with_the_error_of_an_integration(maps):
    points = 1.0 + logistic_points(maps, 3.5) + 3e-8 * np.random.default_rng(0).standard_normal((COUNT, 1))
    assert str(fm.chaos.judge(points, ["x"])) == "periodic-4"


def test_a_long_cycle_is_not_taken_for_a_closed_curve(maps):
    """At r = 3.602 there is a window (exponent -0.008) of a cycle of many points."""
    found = fm.chaos.judge(logistic_points(maps, 3.602, skip=3000), ["x"])
    assert str(found) == "periodic-88", found.reason


def test_errors_above_the_floor_are_not_called_chaos(maps):
    points = 1.0 + 8e-6 * np.random.default_rng(0).standard_normal((COUNT, 2))
    for found in verdicts(points):
        assert str(found) == "inconclusive"
    assert str(fm.chaos.judge(points, ["a", "b"], floor=1e-4)) == "periodic-1"


@pytest.mark.parametrize("exponent", [None, -1.0])
@pytest.mark.parametrize(("size", "k"), [(4.0, 1), (40.0, 2)])
def test_differences_of_some_floors_are_none_with_and_without_an_exponent(exponent, size, k):
    """Points that alternate by a difference over the floor, as steps of a solver do that fall in two ways by turns."""
    points = 1.0 + 0.5 * size * 1e-9 * (-1.0) ** np.arange(60)
    found = fm.chaos.judge(points, ["x"], exponent=exponent, error=0.1, floor=1e-9)
    assert str(found) == f"periodic-{k}", found.reason


# Chaos: 3.6 in two bands, 3.5925 in four, 3.8282 intermittent of type I.


@pytest.mark.parametrize(
    "r",
    [
        pytest.param(3.5925, marks=pytest.mark.slow),
        3.6,
        pytest.param(3.7, marks=pytest.mark.slow),
        3.8282,
        pytest.param(3.9, marks=pytest.mark.slow),
        4.0,
    ],
)
def test_chaos_of_the_logistic_map(maps, r):
    assert str(fm.chaos.judge(logistic_points(maps, r), ["x"])) == "chaotic"


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    "count", [120, 250, pytest.param(1000, marks=pytest.mark.slow), pytest.param(3000, marks=pytest.mark.slow)]
)
def test_henon_through_all_its_signals(maps, count):
    points = maps["henon"](count)
    seen = np.column_stack([points, points @ [1.0, 1.0], points[:, 0] ** 3])
    assert {str(found) for found in verdicts(seen)} == {"chaotic"}
    assert {str(found) for found in verdicts(seen, exponent=0.42, error=0.05)} == {"chaotic"}


@pytest.mark.slow
def test_lorenz_and_rossler_sections_are_chaotic(signals):
    """Maxima of z: Lorenz's own map; maxima of Rossler's x."""
    for name in ("lorenz z", "rossler x"):
        x = signals[name][0]
        at = np.flatnonzero((x[1:-1] > x[:-2]) & (x[1:-1] >= x[2:])) + 1
        a, b, c = x[at - 1], x[at], x[at + 1]
        top = b + (c - a) ** 2 / (8.0 * (2.0 * b - a - c))  # of the parabola through three samples
        assert str(fm.chaos.judge(top[:, None], ["top"])) == "chaotic", name


# Quasi-periodic


@pytest.mark.quick(1)
@pytest.mark.parametrize(("rotation", "coupling"), [(GOLDEN, 0.0), (GOLDEN, 0.8), (0.3337, 0.3), (math.pi / 10, 0.5)])
@pytest.mark.parametrize(
    "count",
    [200, *(pytest.param(n, marks=pytest.mark.slow) for n in (250, 500)), pytest.param(1000, marks=pytest.mark.slow)],
)
def test_closed_curves_through_all_signals(maps, rotation, coupling, count):
    angle = maps["circle"](count, rotation, coupling)
    points = np.column_stack([np.cos(angle), 0.1 * np.sin(angle) + 5.0, np.cos(angle) + 0.3 * np.sin(2.0 * angle)])
    assert {str(found) for found in verdicts(points)} == {"quasi-periodic"}
    assert {str(found) for found in verdicts(points, exponent=1e-4, error=1e-3)} == {"quasi-periodic"}


def test_three_frequencies_are_not_chaos():
    n = np.arange(2000.0)
    points = np.column_stack([np.sin(n) + np.sin(math.sqrt(2.0) * n), np.cos(n) - np.cos(math.sqrt(2.0) * n)])
    assert "chaotic" not in {str(found) for found in verdicts(points)}


# Transients


@pytest.mark.quick(8)
@pytest.mark.parametrize("rate", [0.9, 0.99, 0.999])
@pytest.mark.parametrize("count", [120, 250, 500, 1000])
def test_a_decay_is_a_transient(rate, count):
    found = verdicts(5.0 + spiral(rate, count))
    if rate**count < 1e-12:
        return  # see the next test
    assert {str(verdict) for verdict in found} == {"transient"}, found[0].reason


def test_settled_points_are_periodic_from_the_first_tenth_on():
    points = 5.0 + spiral(0.7)  # 5e-5, ten floors, is reached at point 28 of 1000
    found = fm.chaos.judge(points, ["x", "y"])
    assert str(found) == "periodic-1"
    assert found.evidence["since"] == pytest.approx(math.log(5e-5) / math.log(0.7), abs=4)
    late = fm.chaos.judge(points[:200], ["x", "y"])
    assert str(late) == "transient"
    assert late.k == 1
    assert "leave out at least" in late.reason


def test_algebraic_creeping_at_a_bifurcation(maps):
    """At r = 3 steps shrink like n^(-3/2): no exponential rate, and still a transient."""
    for found in verdicts(logistic_points(maps, 3.0, 2000, skip=0)):
        assert str(found) == "transient"


def test_a_ramp_and_a_growing_motion_are_transients():
    n = np.arange(200.0)[:, None]
    assert str(fm.chaos.judge(n, ["x"])) == "transient"
    assert str(fm.chaos.judge(1.02**n * np.cos(n), ["x"])) == "transient"


@pytest.mark.parametrize("rate", [1.05, 1.3, 2.0, -1.7])
@pytest.mark.parametrize("count", [100, 300, 400])
def test_a_motion_that_grows_without_end_is_no_chaos(rate, count):
    """Neighbours part in every linear instability; at 2**300 no quartile of the record is above its tolerance."""
    n = np.arange(float(count))
    points = abs(rate) ** n * (np.cos(n) if rate > 0.0 else (-1.0) ** n)
    for exponent in (math.log(abs(rate)), None):
        found = fm.chaos.judge(points, ["x"], exponent=exponent)
        assert str(found) == "transient", found.reason


@pytest.mark.slow
def test_parametric_resonance_is_no_chaos():
    """Mathieu's equation in its first tongue: x grows by 1.37 each period of the parameter, 1e16 in 120 periods."""
    mathieu = fm.chaos.ODE(
        lambda t, x: [x[1], -(1.0 + 0.4 * math.cos(2.0 * t)) * x[0]], [1.0, 0.0], period=math.pi, rtol=1e-7
    )
    found = fm.lyapunov(mathieu, periods=120)
    assert found.value > found.error
    assert str(found.verdict) == "transient"
    assert found.verdict.evidence["growth"] == pytest.approx(math.exp(found.value * math.pi), rel=1e-3)


@pytest.mark.quick(1)
@pytest.mark.parametrize("start", [(0.1, 0.1), (0.3, 0.1)])
@pytest.mark.parametrize("tail", [0.85, 0.5, 0.3])
def test_a_chaotic_transient_that_ends_is_not_called_chaotic(maps, start, tail):
    """Henon's map at a = 1.3 has a 7-cycle; before it some 300 to 500 chaotic points."""
    points = maps["henon"](3000, 1.3, start=start, skip=0)
    settled = int(fm.chaos.judge(points, ["x", "y"]).evidence["since"])
    assert settled > 300
    count = int(settled / (1.0 - tail))
    for found in verdicts(points[:count]):
        assert str(found) in ("transient", "periodic-7")
        assert found.k == 7
    if tail < 0.9:
        assert str(fm.chaos.judge(points[:count], ["x", "y"])) == "transient"
    before = fm.chaos.judge(points[: settled - 60], ["x", "y"])
    assert str(before) == "chaotic"  # its end is not in the record


def test_chaos_that_turns_into_a_closed_curve(maps):
    angle = maps["circle"](500, GOLDEN, 0.5)
    curve = 0.7 * np.column_stack([np.cos(angle), np.sin(angle)])
    chaos = maps["henon"](500)
    chaos = chaos / chaos.std(axis=0) * curve.std(axis=0)
    for found in verdicts(np.concatenate([chaos - chaos.mean(axis=0), curve])):
        assert str(found) == "transient", found.reason


# Witnesses against each other


def test_noise_is_inconclusive():
    points = np.random.default_rng(3).standard_normal((COUNT, 2))
    for found in verdicts(points):
        assert str(found) == "inconclusive"
        assert "give the exponent" in found.reason


def test_an_exponent_that_contradicts_makes_it_inconclusive(maps):
    periodic, chaos = logistic_points(maps, 3.5), logistic_points(maps, 4.0)
    angle = maps["circle"](COUNT, GOLDEN, 0.5)
    closed = np.column_stack([np.cos(angle), np.sin(angle)])
    assert str(fm.chaos.judge(periodic, ["x"], exponent=0.5, error=0.1)) == "inconclusive"
    assert str(fm.chaos.judge(periodic, ["x"], exponent=-0.5, error=0.1)) == "periodic-4"
    assert str(fm.chaos.judge(periodic, ["x"], exponent=0.05, error=0.1)) == "periodic-4"
    assert str(fm.chaos.judge(chaos, ["x"], exponent=0.0, error=0.1)) == "inconclusive"
    assert str(fm.chaos.judge(chaos, ["x"], exponent=-0.7, error=0.1)) == "inconclusive"
    assert str(fm.chaos.judge(chaos, ["x"], exponent=0.7, error=math.nan)) == "chaotic"
    assert str(fm.chaos.judge(chaos, ["x"], exponent=math.nan)) == "chaotic"
    assert str(fm.chaos.judge(closed, ["x", "y"], exponent=0.5, error=0.1)) == "inconclusive"


# Signals that say nothing, angles


def test_a_driven_crank_says_nothing(maps):
    turns = 0.3 + 2.0 * math.pi * np.arange(COUNT)[:, None]
    points = np.concatenate([turns, maps["henon"](COUNT)], axis=1)
    names = ["crank.theta", "x", "y"]
    assert str(fm.chaos.judge(points, names)) == "chaotic"
    assert str(fm.chaos.judge(points, names, units=["rad", "m", "m"])) == "chaotic"
    assert fm.chaos.judge(points, names).evidence["signals"] == 2
    alone = fm.chaos.judge(turns, names[:1])
    assert str(alone) == "inconclusive"
    assert "crank.theta" in alone.reason
    wrapped = np.full((COUNT, 1), 0.3)
    assert str(fm.chaos.judge(wrapped, names[:1], driven=names[:1])) == "inconclusive"
    constant = np.concatenate([wrapped, maps["henon"](COUNT)], axis=1)
    assert str(fm.chaos.judge(constant, names)) == "chaotic"


def test_angles_count_modulo_a_turn(maps):
    angle = maps["circle"](COUNT, GOLDEN, 0.5)[:, None]
    for points in (angle, np.mod(angle, 2.0 * math.pi), np.mod(angle + math.pi, 2.0 * math.pi) - math.pi):
        assert str(fm.chaos.judge(points, ["phi"], units=["rad"])) == "quasi-periodic"
    rocking = math.pi + 0.1 * (logistic_points(maps, 3.5) - 0.5)  # about the cut of (-pi, pi]
    cut = np.mod(rocking + math.pi, 2.0 * math.pi) - math.pi
    assert str(fm.chaos.judge(cut, ["phi"], units=["rad"])) == "periodic-4"
    turning = rocking + 2.0 * math.pi * 3 * np.arange(COUNT)[:, None]
    assert str(fm.chaos.judge(turning, ["phi"], units=["rad"])) == "periodic-4"


def test_round_off_of_a_velocity_that_is_zero_at_the_section(maps):
    tiny = 1e-13 * np.random.default_rng(1).standard_normal((COUNT, 1))
    points = np.concatenate([logistic_points(maps, 3.5), tiny], axis=1)
    assert str(fm.chaos.judge(points, ["a.vx", "b.vx"], units=["m/s", "m/s"])) == "periodic-4"
    assert str(fm.chaos.judge(tiny, ["b.vx"], sizes=[0.5])) == "periodic-1"


# Input


def test_too_few_points_say_how_many_are_needed(maps):
    short = fm.chaos.judge(logistic_points(maps, 4.0, 11), ["x"])
    assert str(short) == "inconclusive"
    assert "11 points; at least 12" in short.reason
    some = fm.chaos.judge(logistic_points(maps, 4.0, 99), ["x"])
    assert str(some) == "inconclusive"
    assert "100 are needed; there are 99" in some.reason


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_run_that_failed_is_inconclusive(maps, bad):
    points = logistic_points(maps, 3.5)
    points[70] = bad
    found = fm.chaos.judge(points, ["x"])
    assert str(found) == "inconclusive"
    assert "Point 70 is not finite" in found.reason


def test_bad_input_is_named():
    points = np.zeros((50, 2))
    with pytest.raises(fm.errors.InputError, match=r"shape \(50, 2\) for 1 names"):
        fm.chaos.judge(points, ["x"])
    with pytest.raises(fm.errors.InputError, match="Did you mean 'crank'"):
        fm.chaos.judge(points, ["crank", "x"], driven=["crnk"])
    with pytest.raises(fm.errors.InputError, match="1 units for 2 names"):
        fm.chaos.judge(points, ["a", "b"], units=["m"])
    with pytest.raises(fm.errors.InputError, match="floor is 0"):
        fm.chaos.judge(points, ["a", "b"], floor=0.0)
    with pytest.raises(fm.errors.InputError, match="exponent is inf"):
        fm.chaos.judge(points, ["a", "b"], exponent=math.inf)
    with pytest.raises(fm.errors.InputError, match="error is -1"):
        fm.chaos.judge(points, ["a", "b"], exponent=1.0, error=-1.0)
    with pytest.raises(fm.errors.InputError, match=r"sizes\[1\]"):
        fm.chaos.judge(points, ["a", "b"], sizes=[1.0, -1.0])
    with pytest.raises(fm.errors.InputError, match="no table of numbers"):
        fm.chaos.judge("nonsense", ["a"])


def test_a_verdict_is_a_value(maps):
    found = fm.chaos.judge(logistic_points(maps, 3.5), ["x"])
    assert pickle.loads(pickle.dumps(found)) == found  # noqa: S301 - our own bytes
    with pytest.raises(TypeError):
        found.evidence["k"] = 3.0
    with pytest.raises(fm.errors.InputError, match="Did you mean 'chaotic'"):
        fm.chaos.Verdict("chaos", "")


@pytest.mark.slow
@settings(max_examples=15)
@given(
    scale=st.floats(1e-6, 1e6), sign=st.sampled_from([-1.0, 1.0]), offset=st.floats(-10.0, 10.0),
    kind=st.sampled_from(["periodic-4", "chaotic", "quasi-periodic", "transient"]),
)  # fmt: skip
def test_scale_and_offset_change_no_verdict(maps, scale, sign, offset, kind):
    angle = maps["circle"](300, GOLDEN, 0.5)
    points = {
        "periodic-4": logistic_points(maps, 3.5, 300),
        "chaotic": maps["henon"](300),
        "quasi-periodic": np.column_stack([np.cos(angle), np.sin(angle)]),
        "transient": spiral(0.98, 300),
    }[kind]
    assert {str(found) for found in verdicts(sign * scale * (points + offset))} == {kind}
