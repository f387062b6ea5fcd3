"""Embedding, 0-1 test, spectrum, recurrence and correlation dimension of signals whose answers are known."""

import math
from functools import cache

import numpy as np
import pytest
from cases import slow_where
from hypothesis import given, settings
from hypothesis import strategies as st

import flexmb as fm

CHAOTIC = ["henon x", "henon y", "logistic", "lorenz x", "lorenz y", "lorenz z", "rossler x", "rossler y", "rossler z"]
REGULAR = ["sine", "two sines", "constant", "period 1", "period 2", "period 4", "period 3"]


# embedding


def test_vectors_hold_delayed_samples():
    v = fm.chaos.embed(np.arange(10.0), 3, 3)
    assert v.shape == (4, 3)
    assert (v[1] == [1.0, 4.0, 7.0]).all()


@pytest.mark.slow
def test_information_at_lag_0_is_that_of_equal_intervals_and_two_iterations_forget_two_bits(signals):
    """r = 4 doubles the angle: two iterations forget two bits.  1400 samples make 16 intervals, whose images fit."""
    information = fm.chaos.mutual_information(signals["logistic"][0][:1400], 2)
    assert math.exp(information[0]) == pytest.approx(16.0, rel=1e-3)
    assert information[0] - information[2] == pytest.approx(2.0 * math.log(2.0), abs=0.08)


@pytest.mark.slow
def test_independent_samples_share_only_what_finite_records_feign(signals):
    x, _ = signals["noise"]
    bins = round(math.exp(fm.chaos.mutual_information(x, 0)[0]))
    assert fm.chaos.mutual_information(x, 20)[1:].mean() == pytest.approx((bins - 1) ** 2 / (2 * len(x)), rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "dimension"),
    [("logistic", 1), ("henon x", 2), ("henon y", 2), ("sine", 2), ("lorenz x", 3), ("lorenz z", 3), ("rossler x", 3)],
)
def test_dimension_of_the_state(signals, name, dimension):
    found = fm.chaos.embedding(signals[name][0])
    assert found.ok
    assert found.dimension == dimension


@pytest.mark.parametrize("name", ["lorenz x", "rossler x"])
def test_delay_of_a_flow_is_near_the_published_one(signals, name):
    """0.16 s to 0.18 s for Lorenz's x, 1.3 s to 1.6 s for Rossler's x: the first minimum."""
    x, interval = signals[name]
    low, high = {"lorenz x": (0.12, 0.2), "rossler x": (1.2, 1.7)}[name]
    assert low <= fm.chaos.embedding(x).delay * interval <= high


def test_noise_fits_into_no_dimension(signals):
    found = fm.chaos.embedding(signals["noise"][0])
    assert not found.ok
    assert "noise" in found.status


# 0-1 test


@pytest.mark.quick(3)
@pytest.mark.parametrize("name", CHAOTIC)
def test_chaos_walks_at_random(signals, name):
    assert fm.chaos.zero_one_test(signals[name][0]).kind == "chaotic"


@pytest.mark.parametrize("name", REGULAR)
def test_regular_signals_go_round(signals, name):
    found = fm.chaos.zero_one_test(signals[name][0])
    assert found.kind == "regular", found.status


def test_noise_is_chaotic_to_the_0_1_test_as_its_docstring_says(signals):
    assert fm.chaos.zero_one_test(signals["noise"][0]).kind == "chaotic"
    assert "noise gives 1 as well" in fm.chaos.zero_one_test.__doc__


def test_oversampling_would_hide_chaos_and_thinning_shows_it(signals):
    x, _ = signals["lorenz z"]
    t = np.arange(len(x))
    fine = np.interp(np.arange(0.0, 4000.0, 0.1), t[:4001], x[:4001])
    assert fm.chaos.zero_one_test(fine[:4000], thin=1).kind == "regular"
    found = fm.chaos.zero_one_test(fine)
    assert found.kind == "chaotic"
    assert 40 <= found.thin <= 80  # a quarter of 24 samples, ten times


def test_oversampled_and_short_says_how_many_samples_are_needed(signals):
    found = fm.chaos.zero_one_test(signals["lorenz x"][0][:500])
    assert not found.ok
    assert math.isnan(found.value)
    assert "at least 3600" in found.status  # 200, each 18th


def test_banded_and_intermittent_chaos(maps):
    assert fm.chaos.zero_one_test(maps["logistic"](2000, 3.6)).kind == "chaotic"
    assert fm.chaos.zero_one_test(maps["logistic"](5000, 3.8282)).kind == "chaotic"


# power spectrum


@pytest.mark.parametrize("name", ["sine", "two sines", "period 2", "period 4", "period 3"])
def test_regular_signals_are_lines(signals, name):
    found = fm.chaos.power_spectrum(*signals[name])
    assert found.kind == "lines", found.line_share


@pytest.mark.parametrize("name", ["henon x", "henon y", "logistic", "noise", "lorenz x", "lorenz y"])
def test_chaos_and_noise_are_broad(signals, name):
    assert fm.chaos.power_spectrum(*signals[name]).kind == "broad"


def test_coherent_chaos_is_mixed(signals):
    assert fm.chaos.power_spectrum(*signals["rossler x"]).kind == "mixed"


def test_power_of_lines_and_of_all():
    """Mean squares a^2 / 2 of two sines; the integral of the density is the variance."""
    t = 0.01 * np.arange(20000)
    x = 3.0 + 2.0 * np.sin(2 * math.pi * 5.0 * t) + 0.5 * np.sin(2 * math.pi * 12.34 * t + 1.0)
    found = fm.chaos.power_spectrum(x, 0.01)
    assert found.peaks[:2] == pytest.approx([5.0, 12.34], abs=0.005)
    assert found.power[:2] == pytest.approx([2.0, 0.125], rel=1e-3)
    assert found.density.sum() * found.frequency[1] == pytest.approx(x.var(), rel=1e-3)
    assert found.units == "Hz"


@pytest.mark.parametrize("apart", [5, 6, 7])
@pytest.mark.parametrize("weak", [0.5, 1.0])
def test_power_of_lines_side_by_side(apart, weak):
    """Lines some bins apart share no power; a line of half the height is seen from 6 bins on."""
    k = np.arange(4000)
    x = np.sin(2 * math.pi * 0.05 * k) + weak * np.sin(2 * math.pi * (0.05 + apart / 4000) * k + 1.0)
    found = fm.chaos.power_spectrum(x)
    if len(found.peaks) == 1:
        assert apart == 5
        assert weak < 1.0
        return
    assert np.sort(found.power) == pytest.approx([0.5 * weak**2, 0.5], rel=5e-3)
    assert found.power.sum() == pytest.approx(x.var(), rel=5e-3)


def test_floor_of_white_noise():
    """One-sided density of unit white noise: 2 per cycle; its median is ln 2 of the mean."""
    found = fm.chaos.power_spectrum(np.random.default_rng(2).standard_normal(20000))
    assert np.median(found.floor[200:-200]) == pytest.approx(2.0 * math.log(2.0), rel=0.05)
    assert found.units == "1/iteration"


# correlation dimension


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("name", "dimension", "tolerance"),
    [
        # Grassberger and Procaccia (1983): Henon 1.21 +- 0.01 (1.25 +- 0.02 extrapolated), Lorenz 2.05 +- 0.01; an
        # interval, a circle, a torus: 1, 1, 2; Sprott (2003): Rossler 1.99 +- 0.08
        ("henon x", 1.22, 0.06),
        pytest.param("henon y", 1.22, 0.06, marks=pytest.mark.slow),
        ("logistic", 1.0, 0.1),
        pytest.param("lorenz x", 2.05, 0.12, marks=pytest.mark.slow),
        pytest.param("lorenz y", 2.05, 0.12, marks=pytest.mark.slow),
        pytest.param("lorenz z", 2.05, 0.15, marks=pytest.mark.slow),
        pytest.param("rossler x", 1.99, 0.2, marks=pytest.mark.slow),
        ("sine", 1.0, 0.05),
        ("two sines", 2.0, 0.2),
    ],
)
def test_published_dimension(signals, name, dimension, tolerance):
    found = fm.chaos.correlation_dimension(signals[name][0])
    assert found.ok, found.status
    assert abs(found.value - dimension) < tolerance, found.status


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["period 2", *(pytest.param(n, marks=pytest.mark.slow) for n in ("period 4", "period 3"))]
)
def test_cycle_of_a_map_has_dimension_0(signals, name):
    assert fm.chaos.correlation_dimension(signals[name][0]).value == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["noise", "constant", "ramp"])
def test_what_has_no_dimension(signals, name):
    found = fm.chaos.correlation_dimension(signals[name][0])
    assert not found.ok
    assert math.isnan(found.value)


@pytest.mark.slow
def test_noise_is_not_of_small_dimension_in_any_embedding(signals):
    for m in (1, 2, 3, 5):
        found = fm.chaos.correlation_dimension(signals["noise"][0][:2500], delay=1, dimension=m)
        assert not found.ok, found.status


# recurrence


def test_lines_of_a_sequence_counted_by_hand():
    """0 1 1 0 0 | repeated: recurrence at threshold 0.5 is equality."""
    x = np.tile([0.0, 1.0, 1.0, 0.0, 0.0], 30)
    found = fm.chaos.recurrence(x, threshold=0.5, delay=1, dimension=1, theiler=1)
    equal = x[:, None] == x[None, :]
    upper = np.triu(equal, 2)
    assert found.rate == pytest.approx(upper.sum() / (148 * 149 / 2))
    assert found.longest_diagonal == 145
    assert (found.diagonals @ np.arange(len(found.diagonals))) == upper.sum()
    assert found.longest_vertical == 3
    assert (found.matrix(0, 150) == equal).all()


def test_periodic_lines_are_as_long_as_the_record_and_chaotic_ones_short(signals):
    sine, chaos = (fm.chaos.recurrence(signals[name][0][:2000]) for name in ("sine", "henon x"))
    assert sine.longest_diagonal > 0.9 * 2000
    assert chaos.longest_diagonal < 100
    assert sine.rate == pytest.approx(0.05, abs=0.01)


def test_determinism_tells_a_map_from_noise(signals):
    chaos = fm.chaos.recurrence(signals["logistic"][0][:2000], dimension=1)
    noise = fm.chaos.recurrence(signals["noise"][0][:2000], dimension=1)
    assert chaos.determinism > 0.6
    assert noise.determinism < 0.2  # 2 x the rate of 0.05: chance
    assert noise.laminarity < 0.2


def test_intermittency_is_laminar(maps):
    """Third iterates stay in the channel: laminar phases are vertical lines."""
    every_third = maps["logistic"](6000, 3.8282)[::3]
    found = fm.chaos.recurrence(every_third, dimension=1, delay=1)
    assert found.laminarity > 0.8
    assert found.longest_vertical > 20


def test_a_constant_does_not_recur_usefully(signals):
    found = fm.chaos.recurrence(signals["constant"][0])
    assert not found.ok
    assert math.isnan(found.rate)


# all of them

ANSWERS = {
    "embedding": lambda x: (fm.chaos.embedding(x).delay, fm.chaos.embedding(x).dimension),
    "zero_one_test": lambda x: fm.chaos.zero_one_test(x).value,
    "power_spectrum": lambda x: fm.chaos.power_spectrum(x).line_share,
    "recurrence": lambda x: (fm.chaos.recurrence(x).determinism, fm.chaos.recurrence(x).laminarity),
    "correlation_dimension": lambda x: fm.chaos.correlation_dimension(x).value,
    "rosenstein": lambda x: fm.chaos.rosenstein(x).value,
    "wolf": lambda x: fm.chaos.wolf(x).value,
    "kantz": lambda x: fm.chaos.kantz(x).value,
}


@pytest.fixture(scope="module")
def henon_once(signals):
    """A thousand points of Henon's map, and the answers to them by name."""
    x = signals["henon x"][0][:1000]
    return x, cache(lambda name: ANSWERS[name](x))


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", slow_where(lambda n: n in ("kantz", "recurrence"), ANSWERS))
@settings(max_examples=8)
@given(scale=st.floats(1e-6, 1e6), sign=st.sampled_from([-1.0, 1.0]), offset=st.floats(-100.0, 100.0))
def test_scale_and_offset_change_no_answer(henon_once, name, scale, sign, offset):
    """Offsets in units of the signal; a pair at the edge of a threshold may change sides by round-off."""
    x, answers = henon_once
    found = ANSWERS[name](sign * scale * (x + offset))
    assert found == pytest.approx(answers(name), rel=2e-3, abs=2e-3, nan_ok=True)


@pytest.mark.parametrize("name", ANSWERS)
def test_not_finite_is_named(name):
    x = np.sin(np.arange(2000.0))
    x[5] = np.inf
    with pytest.raises(fm.errors.InputError, match="sample 5 is inf, 1 of 2000"):
        ANSWERS[name](x)


@pytest.mark.parametrize("name", ANSWERS)
def test_too_short_is_named(name):
    with pytest.raises(fm.errors.InputError, match=r"has 15 samples; at least \d+ are needed"):
        ANSWERS[name](np.arange(15.0))
