"""Exponents of published systems from each of their signals, and none where there is none."""

import numpy as np
import pytest

import flexmb as fm

# J. C. Sprott, Chaos and Time-Series Analysis (2003): Henon, Lorenz and Rossler; ln 2 is exact.
PUBLISHED = {"henon": 0.41922, "logistic": np.log(2.0), "lorenz": 0.90563, "rossler": 0.0714}

METHODS = (fm.chaos.rosenstein, fm.chaos.kantz, fm.chaos.wolf)

SMOOTH = ["henon x", "henon y", "logistic", "lorenz x", "lorenz y", "lorenz z", "rossler x", "rossler y"]


def _is_slow(name, method):
    """Signals of flows, but for Wolf's method and one of Rosenstein's, and second signals of a system."""
    flows = name.startswith(("lorenz", "rossler")) and method is not fm.chaos.wolf
    kept = (name, method) == ("lorenz z", fm.chaos.rosenstein) or (name, method) == ("logistic", fm.chaos.kantz)
    return not kept and (flows or name in ("lorenz y", "rossler y", "henon y"))


PAIRS = [
    pytest.param(name, method, marks=pytest.mark.slow if _is_slow(name, method) else ())
    for name in SMOOTH
    for method in METHODS
]

REGULAR = ["sine", "two sines", "decay", "constant", "constant, rounded", "ramp"]
REGULAR += ["period 1", "period 2", "period 4", "period 3"]


@pytest.mark.quick(2)
@pytest.mark.parametrize(("name", "method"), PAIRS)
def test_published_exponent_lies_in_the_band(signals, name, method):
    found, true = method(*signals[name]), PUBLISHED[name.split()[0]]
    assert found.ok, found.status
    assert found.units == ("1/s" if signals[name][1] else "1/iteration")
    assert abs(found.value - true) <= found.error, found.status
    assert found.error <= 0.4 * true, found.status


@pytest.mark.slow
@pytest.mark.parametrize("method", [fm.chaos.rosenstein, fm.chaos.kantz])
def test_a_signal_of_spikes_is_off_by_a_seventh_and_says_that_its_embedding_is_doubtful(signals, method):
    found = method(*signals["rossler z"])
    assert "doubtful" in found.status
    assert abs(found.value - PUBLISHED["rossler"]) < 0.15 * PUBLISHED["rossler"]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=pytest.mark.slow) if n not in ("constant", "constant, rounded", "ramp") else n
        for n in REGULAR
    ],
)
def test_regular_signals_have_no_exponent(signals, method, name):
    found = method(*signals[name])
    assert not found.ok
    assert np.isnan(found.value)
    assert np.isnan(found.error)
    assert found.status


@pytest.mark.quick(2)
@pytest.mark.parametrize("method", METHODS)
def test_noise_has_no_exponent(signals, method):
    found = method(*signals["noise"])
    assert np.isnan(found.value), found.status
    assert "noise" in found.status


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "level", [pytest.param(1e-9, marks=pytest.mark.slow), 1e-6, pytest.param(1e-3, marks=pytest.mark.slow)]
)
def test_noise_on_a_periodic_signal_is_no_chaos(signals, method, level):
    x, interval = signals["sine"]
    x = x[:2500]
    found = method(x + level * np.random.default_rng(5).standard_normal(len(x)), interval)
    assert np.isnan(found.value), found.status


@pytest.mark.slow
@pytest.mark.parametrize("method", [METHODS[0], pytest.param(METHODS[1], marks=pytest.mark.slow), METHODS[2]])
def test_times_and_interval_say_the_same(signals, method):
    x, interval = signals["lorenz z"]
    x = x[:1500]
    assert method(x, interval * np.arange(1500)).value == pytest.approx(method(x, interval).value, nan_ok=True)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_unit_and_offset_do_not_matter(signals, method):
    x, interval = signals["henon x"]
    x = x[:3000]
    assert method(-3e-4 * x + 7.0).value == pytest.approx(method(x).value, rel=1e-3)


def test_the_rate_is_per_second(signals):
    x, _ = signals["henon x"]
    assert fm.chaos.rosenstein(x, 0.5).value == pytest.approx(2.0 * fm.chaos.rosenstein(x).value)


@pytest.mark.slow
def test_intermittency_has_a_positive_exponent(maps):
    r = 3.8282
    x = maps["logistic"](20000, r)
    true = np.log(np.abs(r * (1.0 - 2.0 * x))).mean()
    for method in METHODS:
        found = method(x)
        assert np.isnan(found.value) or abs(found.value - true) < 0.5 * true, (method, found.status, true)
    assert fm.chaos.wolf(x).value == pytest.approx(true, rel=0.2)


@pytest.mark.slow
def test_an_oversampled_orbit_has_the_same_exponent(signals):
    """A tenth of the interval, by splines: ten times the samples for the same 90 s."""
    from scipy.interpolate import CubicSpline

    x, interval = signals["lorenz z"]
    t = interval * np.arange(3000)
    fine = np.arange(0.0, t[-1], interval / 10)
    found = fm.chaos.rosenstein(CubicSpline(t, x[:3000])(fine), interval / 10)
    assert abs(found.value - PUBLISHED["lorenz"]) <= max(found.error, 0.15), found.status


@pytest.mark.parametrize("method", METHODS)
def test_too_few_periods_are_counted(signals, method):
    x, interval = signals["sine"]
    found = method(x[:1000], interval)  # 16 periods
    assert not found.ok
    assert "15.9 mean periods; at least 20" in found.status


@pytest.mark.parametrize("method", METHODS)
def test_bad_input_is_named(signals, method):
    x, _ = signals["henon x"]
    broken = x[:1000].copy()
    broken[[17, 40]] = np.nan, np.inf
    with pytest.raises(fm.errors.InputError, match=r"sample 17 is nan, 2 of 1000"):
        method(broken)
    with pytest.raises(fm.errors.InputError, match=r"400 samples; at least 500"):
        method(x[:400])
    with pytest.raises(fm.errors.InputError, match=r"shape \(10, 3\)"):
        method(np.zeros((10, 3)))
    with pytest.raises(fm.errors.InputError, match="not evenly spaced"):
        method(x[:1000], np.arange(1000.0) ** 1.1)
    with pytest.raises(fm.errors.InputError, match="999 times for 1000"):
        method(x[:1000], np.arange(999.0))
    with pytest.raises(fm.errors.InputError, match="must be > 0"):
        method(x[:1000], 0.0)
    with pytest.raises(fm.errors.InputError, match="delay"):
        method(x[:1000], delay=0)


def test_a_labelled_array_is_a_signal(signals):
    import xarray as xr

    x, _ = signals["henon x"]
    labelled = xr.DataArray(x[:2000], dims="time", attrs={"units": "m"})
    assert fm.chaos.rosenstein(labelled).value == fm.chaos.rosenstein(x[:2000]).value


def test_running_estimate_has_the_unit_of_the_exponent_without_a_value_too():
    noise = np.random.default_rng(3).standard_normal(1500)
    coarse, fine = fm.chaos.wolf(noise, 1.0), fm.chaos.wolf(noise, 0.01)
    assert not fine.ok
    assert len(fine.curve) > 10
    np.testing.assert_allclose(fine.curve, 100.0 * coarse.curve)
