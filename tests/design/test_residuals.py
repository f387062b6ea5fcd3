"""Residuals of fits: correlated ones are told with the errors that hold, shared offsets, pictures and pages of fits."""

import numpy as np
import pytest
import xarray as xr
from test_fit import GOOD, moved, oscillator, record
from test_pieces import BOUNDS, NOISE, STARTS, pendulum

import flexmb as fm
from flexmb.design.fitting import lag_correlations
from flexmb.errors import InputError

RATES = {"rate": (60.0, 120.0), "damping": (0.1, 2.0)}
SHIFT = 0.01


def red(draws: np.random.Generator, shape: tuple[int, ...], r: float) -> np.ndarray:
    """Noise of unit variance with correlation r from one row to the next."""
    found = draws.standard_normal(shape)
    for k in range(1, len(found)):
        found[k] = r * found[k - 1] + np.sqrt(1.0 - r * r) * found[k]
    return found


@pytest.mark.parametrize("r", [0.0, 0.5, 0.8])
def test_factor_of_standard_errors_in_a_linear_model(r):
    """Two slow columns and 2,000 records of 1,000 numbers: errors over standard errors scatter by 1."""
    t = np.linspace(0.0, 1.0, 1000)
    columns = np.column_stack([t * np.sin(9.0 * t), np.exp(-t)])
    inverse, noise = np.linalg.pinv(columns), red(np.random.default_rng(1), (1000, 2000), r)
    found = inverse @ noise
    left = noise - columns @ found
    lags, factors = lag_correlations(left)
    sizes = np.sqrt(np.outer((inverse**2).sum(axis=1), (left**2).sum(axis=0) / (len(t) - 2)))
    off = found / (factors * sizes)
    assert lags.mean() == pytest.approx(r, abs=0.01)
    assert off.std(axis=1) == pytest.approx(1.0, abs=0.06)
    assert (np.abs(off) < 2.0).mean(axis=1) == pytest.approx(0.954, abs=0.02)
    assert (factors > 1.0).mean() == pytest.approx(float(r > 0.0), abs=0.01)


def test_missing_residuals_and_begins_of_pieces_have_no_last_ones():
    """Pairs are counted by hand: (1, 2) and (3, 1) beside a gap and a begin."""
    rows = np.array([[1.0], [2.0], [np.nan], [5.0], [3.0], [1.0]])
    (r,), _ = lag_correlations(rows, [0, 4])
    assert r == pytest.approx((2.0 + 3.0) / np.sqrt((1.0 + 9.0) * (4.0 + 1.0)))


@pytest.fixture(scope="module")
def correlated():
    t = np.linspace(0.0, 2.0, 401)
    noise = 2e-3 * red(np.random.default_rng(4), (len(t),), 0.8)
    return fm.design.fit(
        oscillator, RATES, record(t, moved(t, 90.0, 0.7, 0.1) + noise), signals=["body.x"], noise=2e-3, start={}
    )


@pytest.mark.slow
def test_a_fit_tells_correlated_residuals(correlated):
    r = correlated.residuals["body.x"].attrs["correlation"]
    assert r == pytest.approx(0.8, abs=0.05)
    assert f"by {r:.2f} (body.x)" in correlated.message
    for name, true in (("rate", 90.0), ("damping", 0.7)):
        times = correlated.corrected[name] / correlated.errors[name]
        assert times == pytest.approx(3.0, abs=0.4)
        assert f"{name} {correlated.corrected[name]:.2g} ({times:.2g} times)" in correlated.message
        assert abs(correlated.parameters[name] - true) < 2.5 * correlated.corrected[name]
    assert "corrected" in repr(correlated)


@pytest.mark.slow
def test_white_residuals_are_not_told():
    t = np.linspace(0.0, 1.0, 101)
    noise = 2e-3 * np.random.default_rng(5).standard_normal(len(t))
    how = {"signals": ["body.x"], "start": {}}
    found = fm.design.fit(oscillator, RATES, record(t, moved(t, 90.0, 0.7, 0.1) + noise), noise=2e-3, **how)
    assert found.message == "Converged."
    assert found.corrected == found.errors
    # residuals far below the given noise are errors of the steps, however correlated
    exact = fm.design.fit(oscillator, RATES, record(t, moved(t, 90.0, 0.7, 0.1)), noise=2e-3, **how)
    assert exact.residuals["body.x"].attrs["correlation"] > 0.5
    assert exact.message == "Converged."


@pytest.fixture(scope="module")
def swings():
    """Three swings, one behind the other, of which one encoder with an unknown zero has a gap."""
    draws, t, found = np.random.default_rng(2), np.linspace(0.0, 1.0, 101), []
    for start in STARTS:
        sol = fm.simulate(pendulum(*start, 0.02, 0.01), t_end=1.0, save=t.tolist(), signals=["bar.x", "bar.y"])
        found.append(np.array([sol["bar.x"], sol["bar.y"]]) + SHIFT + NOISE * draws.standard_normal((2, 101)))
    x, y = np.concatenate(found, axis=1)
    x[40:60] = np.nan
    times = np.concatenate([t + 1.01 * k for k in range(3)])
    return xr.Dataset({"bar.x": ("time", x), "bar.y": ("time", y)}, {"time": times})


GUESS = {"inertia": 0.03, "drag": 0.02, "angle": [0.0, -0.8, -2.2], "rate": 0.0}
PIECES = {"signals": ["bar.x", "bar.y"], "pieces": [1.01, 2.02], "free": ["angle", "rate"], "start": GUESS}


@pytest.fixture(scope="module")
def shared(swings):
    noise = {"bar.x": NOISE, "bar.y": 2.0 * NOISE}
    return fm.design.fit(pendulum, BOUNDS, swings, offset=[["bar.x", "bar.y"]], noise=noise, **PIECES)


@pytest.mark.slow
def test_signals_share_an_offset_in_all_pieces(shared):
    assert shared.ok
    assert shared.offsets["bar.x"] == shared.offsets["bar.y"] == pytest.approx(SHIFT, abs=3e-5)
    for name, true in {"inertia": 0.02, "drag": 0.01}.items():
        assert abs(shared.parameters[name] - true) < 3.5 * shared.errors[name]


@pytest.mark.slow
def test_an_offset_that_a_parameter_hides_is_named():
    """The whole mechanism stands somewhere along x, and the sensor has an offset: the data show their sum alone."""

    def somewhere(place: float, rate: float) -> fm.Mechanism:
        body = fm.RigidBody("body", (place + 0.1, 0.0), 1.0, 1.0)
        guide = fm.Prismatic("guide", fm.GROUND, body, at=(0.0, 0.0), along=(1.0, 0.0))
        ends = {"at": (place - 1.0, 0.0), "to": (place + 0.1, 0.0), "free_length": 1.0}
        spring = fm.loads.SpringDamper("spring", fm.GROUND, body, **ends, stiffness=rate)
        return fm.Mechanism("somewhere", [body, guide, spring])

    t = np.linspace(0.0, 1.0, 51)
    data = record(t, moved(t, 90.0, 0.0, 0.1) + 1e-3 * np.random.default_rng(1).standard_normal(len(t)))
    bounds = {"place": (-0.1, 0.08), "rate": (60.0, 120.0)}
    found = fm.design.fit(somewhere, bounds, data, signals=["body.x"], offset=["body.x"], noise=1e-3, start={})
    assert "of place" in found.unseen[0]
    assert "the offset of body.x" in found.unseen[0]
    assert np.isinf(found.errors["place"])
    assert abs(found.parameters["rate"] - 90.0) < 3.0 * found.errors["rate"] < 1.0


@pytest.mark.parametrize(
    ("offset", "message"),
    [
        ([["bar.x", "bar.theta"]], r"bar\.x \[m\] and bar\.theta \[rad\] share an offset; only signals of one unit"),
        (["bar.x", ["bar.x", "bar.theta"]], "each signal has one offset: name it once"),
        ([["bar.x", "bar.x"]], "each signal has one offset"),
        ([[]], "each signal has one offset"),
        ([["bar.x", "bar.z"]], r"offset.*bar\.x"),
        ([[["bar.x"]]], "offset"),
        ([3], "offset is 3"),
    ],
)
def test_offsets_that_cannot_be_shared_are_refused(swings, offset, message):
    data = swings.assign({"bar.theta": swings["bar.x"]})
    how = PIECES | {"signals": ["bar.x", "bar.theta"]}
    with pytest.raises(InputError, match=message):
        fm.design.fit(pendulum, BOUNDS, data, offset=offset, **how)


@pytest.mark.slow
def test_picture_of_residuals(shared, swings):
    figure = fm.plots.plot_residuals(shared)
    above, below = figure.axes[:2]
    assert [ax.get_ylabel().split("\n")[0] for ax in figure.axes] == ["bar.x", "residual", "bar.y", "residual"]
    assert above.get_ylabel().endswith("[m]")
    measured, fitted = above.get_lines()[:2]
    points = measured.get_ydata()
    assert points[np.isfinite(points)] == pytest.approx(swings["bar.x"].values[np.isfinite(swings["bar.x"].values)])
    # the curve goes on where nothing was measured, and ends with its piece
    assert np.isnan(fitted.get_ydata()).sum() == 2
    left = below.get_lines()[1].get_ydata()
    assert np.nanstd(left) == pytest.approx(1.0, abs=0.15)
    (band,) = below.patches
    assert band.get_extents().transformed(below.transData.inverted()).intervaly == pytest.approx([-2.0, 2.0])
    assert [line.get_xdata()[0] for line in above.get_lines()[2:]] == [1.01, 2.02]


@pytest.mark.slow
def test_as_many_numbers_as_unknowns_leave_no_scatter(tmp_path):
    data = record(np.array([0.0, 0.1]), np.array([np.nan, moved(np.array(0.1), 90.0, 0.7, 0.1)]))
    found = fm.design.fit(lambda rate: oscillator(rate, 0.7), {"rate": (60.0, 120.0)}, data, signals=["body.x"])
    assert found.parameters["rate"] == pytest.approx(90.0, rel=1e-3)
    assert found.errors == found.corrected == {"rate": np.inf}
    assert "no scatter" in found.message
    fm.plots.plot_residuals(found)
    fm.report(found, tmp_path / "fit.html")


def test_other_objects_have_no_residuals():
    orbit = fm.chaos.periodic_orbit(fm.chaos.Map(lambda x, r: r * x * (1.0 - x), [0.6], parameters={"r": 2.5}))
    with pytest.raises(InputError, match="plot_residuals: fit is PeriodicOrbit"):
        fm.plots.plot_residuals(orbit)  # whose residuals are others
    with pytest.raises(InputError, match=r"plot_residuals: fit is float; it must be the result of fm\.design\.fit"):
        fm.plots.plot_residuals(3.0)


def test_a_search_that_failing_runs_stop_has_not_converged():
    def limited(rate):
        if rate > 80.0:
            raise fm.errors.ModelError("oscillator: no spring is as stiff")
        return oscillator(rate, 0.7)

    fit = fm.design.fit(limited, {"rate": (60.0, 120.0)}, GOOD, signals=["body.x"], start={"rate": 70.0})
    assert not fit.ok
    assert "stopped beside values for which runs fail" in fit.message
