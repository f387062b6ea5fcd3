"""Means of correlated turns: known standard errors, intervals that hold what they promise, verdicts on two means."""

import math

import numpy as np
import pytest
from nine_bar_study.statistics import (
    COVERAGE,
    EQUAL,
    HIGHER,
    LOWER,
    UNTOLD,
    Mean,
    binomial_tail,
    compare,
    correlation_time,
)

import flexmb as fm


def autoregressive(phi: float, shape: tuple[int, ...], seed: int) -> np.ndarray:
    """Stationary series x_k = phi x_(k-1) + noise of unit variance, along the last axis."""
    rng = np.random.default_rng(seed)
    x = np.empty(shape)
    x[..., 0] = rng.normal(size=shape[:-1]) / math.sqrt(1.0 - phi**2)
    for k in range(1, shape[-1]):
        x[..., k] = phi * x[..., k - 1] + rng.normal(size=shape[:-1])
    return x


@pytest.mark.parametrize("phi", [0.0, 0.5, 0.8])
def test_standard_error_of_a_long_series_is_the_known_one(phi):
    # of the mean of n values of an AR(1) process with unit noise: 1 / ((1 - phi) sqrt(n))
    n = 4000
    errors = [Mean.of(series).error for series in autoregressive(phi, (40, n), seed=3)]
    assert np.mean(errors) == pytest.approx(1.0 / ((1.0 - phi) * math.sqrt(n)), rel=0.05)


def test_error_of_alternating_values_is_never_below_that_of_independent_ones():
    x = np.tile([1.0, 3.0], 20)
    assert Mean.of(x).error == pytest.approx(x.std(ddof=1) / math.sqrt(len(x)))
    assert correlation_time(x) == 1.0


@pytest.mark.parametrize(("phi", "least"), [(0.0, 0.99), (0.5, 0.97)])
def test_intervals_of_twenty_turns_hold_the_true_mean(phi, least):
    means = [Mean.of(series) for series in autoregressive(phi, (2000, 20), seed=1)]
    held = np.mean([abs(mean.value) <= mean.interval for mean in means])
    assert least <= held <= 1.0
    naive = np.mean([abs(m.value) <= 3.0 * m.deviation / math.sqrt(m.count) for m in means])
    assert held > naive or phi == 0.0  # with correlation the naive error promises too much


def test_interval_of_few_independent_values_is_that_of_student():
    mean = Mean.of([1.0, 2.0, 3.0, 4.0])
    # two-sided 99.73 % quantile of t with 3 degrees of freedom: 9.2187 (tables); the error is s / 2
    assert COVERAGE == 0.9973
    assert mean.interval == pytest.approx(9.2187 * np.std([1, 2, 3, 4], ddof=1) / 2.0, rel=1e-3)


@pytest.mark.parametrize(
    ("first", "second", "verdict"),
    [
        ((2.0, 0.1), (1.0, 0.1), HIGHER),
        ((1.0, 0.1), (2.0, 0.1), LOWER),
        ((1.0, 0.01), (1.001, 0.01), EQUAL),
        ((1.0, 0.5), (1.1, 0.5), UNTOLD),
        ((1.005, 0.0), (1.0, 0.0), EQUAL),  # below what steps may be wrong
        ((0.0, 0.0), (0.2, 0.01), LOWER),
        ((0.0, 0.0), (0.0, 0.0), EQUAL),
    ],
)
def test_verdict_on_two_means(first, second, verdict):
    def of(mean, spread):
        return Mean.of(mean + spread * np.tile([1.0, -1.0], 10))

    found = compare(of(*first), of(*second))
    assert found.verdict == verdict
    if min(first[0], second[0]) > 0.0:
        assert found.low <= found.ratio <= found.high
        assert found.ratio == pytest.approx(first[0] / second[0])
    else:
        assert math.isnan(found.ratio)


def test_equal_distributions_are_seldom_called_different():
    rng = np.random.default_rng(5)
    verdicts = [
        compare(Mean.of(rng.normal(1.0, 0.2, 20)), Mean.of(rng.normal(1.0, 0.2, 20))).verdict for _ in range(1000)
    ]
    assert sum(verdict in (HIGHER, LOWER) for verdict in verdicts) <= 10


def test_tail_of_the_binomial_distribution():
    assert binomial_tail(2, 3, 0.5) == pytest.approx(0.5)  # 3/8 + 1/8
    assert binomial_tail(0, 3, 0.5) == 1.0
    assert binomial_tail(3, 3, 0.1) == pytest.approx(1e-3)


@pytest.mark.parametrize("values", [[], [1.0], [1.0, math.nan]])
def test_a_mean_of_nothing_is_refused(values):
    with pytest.raises(fm.errors.InputError, match="Mean"):
        Mean.of(values)
