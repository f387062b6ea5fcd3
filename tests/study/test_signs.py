"""A small chaotic signal on a large periodic one: the sign of its exponent is that of the distance of neighbours.

The chaotic one is Lorenz's x at the usual parameters, whose exponent is 0.906 (J. C. Sprott, Chaos and Time-Series
Analysis, 2003, p. 431), so that nothing of this comes from the mechanism.
"""

import numpy as np
import pytest
from nine_bar_study.samples import growth_by_distance, surrogate, without_periodic_part

from flexmb.dynamics.series.exponent import wolf

EXPONENT = 0.906
PERIODS, SAMPLES = 200, 25
SMALL = 1e-3
EDGES = 10.0 ** np.arange(-6.0, 0.6, 0.5)


def lorenz(count: int, step: float) -> np.ndarray:
    """Lorenz's x by the classical Runge-Kutta method, in standard deviations."""

    def rate(s):
        return np.array([10.0 * (s[1] - s[0]), s[0] * (28.0 - s[2]) - s[1], s[0] * s[1] - 8.0 / 3.0 * s[2]])

    state, found, h = np.array([1.0, 1.0, 20.0]), [], step / 5
    for k in range(5 * (count + 500)):
        a = rate(state)
        b = rate(state + 0.5 * h * a)
        c = rate(state + 0.5 * h * b)
        state = state + h / 6.0 * (a + 2.0 * b + 2.0 * c + rate(state + h * c))
        if k >= 2500 and k % 5 == 4:
            found.append(state[0])
    x = np.array(found)
    return (x - x.mean()) / x.std()


@pytest.fixture(scope="module")
def rows():
    """Signal (periods, samples) of period 1 s."""
    time = np.arange(PERIODS * SAMPLES) / SAMPLES
    return (np.sin(2.0 * np.pi * time) + SMALL * lorenz(len(time), 1.0 / SAMPLES)).reshape(PERIODS, SAMPLES)


def rates(signal, periods):
    follow = periods * SAMPLES
    growth, numbers = growth_by_distance(signal, EDGES, delay=3, dimension=4, theiler=SAMPLES, follow=follow)
    return np.where(numbers >= 100, growth / periods, np.nan)


@pytest.mark.slow
def test_far_neighbours_of_the_sum_show_no_exponent_at_all(rows):
    far = rates(rows.ravel(), 1)[EDGES[:-1] >= 0.01]
    assert np.isfinite(far).sum() >= 2
    assert np.nanmax(np.abs(far)) < 0.01 * EXPONENT


def test_neighbours_as_far_as_the_chaos_is_large_show_the_wrong_sign(rows):
    at_its_size = rates(rows.ravel(), 4)[np.argmin(np.abs(EDGES[:-1] - SMALL))]
    assert at_its_size < -0.05


@pytest.mark.slow
@pytest.mark.parametrize("make", [np.ravel, lambda rows: without_periodic_part(rows).ravel()], ids=["sum", "rest"])
def test_near_neighbours_show_the_exponent(rows, make):
    found = rates(make(rows), 4)
    assert found[np.isfinite(found)][0] == pytest.approx(EXPONENT, rel=0.15)


def test_estimator_refuses_the_sum_and_sees_the_chaos_without_the_periodic_part(rows):
    assert not wolf(rows.ravel(), 1.0 / SAMPLES).ok
    rest = wolf(without_periodic_part(rows).ravel(), 1.0 / SAMPLES)
    assert rest.ok
    assert abs(rest.value - EXPONENT) <= rest.error


def test_a_periodic_signal_has_no_growth_at_whole_periods(rows):
    time = np.arange(100 * 40) / 40.0
    signal = np.sin(2.0 * np.pi * time) + 0.3 * np.cos(6.0 * np.pi * time)
    growth, numbers = growth_by_distance(signal, EDGES, delay=4, dimension=4, theiler=20, follow=40)
    known = numbers > 1000
    known[EDGES[:-1] < 1e-3] = False  # round-off: points at the same phase
    assert known.sum() >= 2
    assert np.abs(growth[known]).max() < 1e-6


def test_surrogate_has_the_spectrum_of_its_signal():
    signal = np.random.default_rng(2).standard_normal(501).cumsum()
    for given in (signal, signal[:-1]):
        made = surrogate(given)
        spectra = [np.abs(np.fft.rfft(values)) for values in (given, made)]
        np.testing.assert_allclose(*spectra, rtol=1e-6, atol=1e-9 * spectra[0].max())
        assert np.abs(np.corrcoef(given, made)[0, 1]) < 0.9
