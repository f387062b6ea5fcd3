"""Fits: known answers back, standard errors of the right size, what cannot be told apart, refusals."""

import numpy as np
import pytest
import xarray as xr
from designs import worn

import flexmb as fm
from flexmb.design.fitting import read_csv
from flexmb.errors import InputError, ModelError
from flexmb.mechanisms import slider_crank


def oscillator(rate: float, damping: float, start: float = 0.1) -> fm.Mechanism:
    body = fm.RigidBody("body", (start, 0.0), 1.0, 1.0)
    guide = fm.Prismatic("guide", fm.GROUND, body, at=(0.0, 0.0), along=(1.0, 0.0))
    ends = {"at": (-1.0, 0.0), "to": (start, 0.0), "free_length": 1.0}
    spring = fm.loads.SpringDamper("spring", fm.GROUND, body, **ends, stiffness=rate, damping=damping)
    return fm.Mechanism("oscillator", [body, guide, spring])


def moved(t: np.ndarray, rate: float, damping: float, start: float) -> np.ndarray:
    """Position of the oscillator, released from its start, in closed form."""
    a, w = 0.5 * damping, np.sqrt(rate - 0.25 * damping**2)
    return start * np.exp(-a * t) * (np.cos(w * t) + a / w * np.sin(w * t))


def record(t: np.ndarray, values: np.ndarray) -> xr.Dataset:
    return xr.Dataset({"body.x": ("time", values)}, {"time": t})


TIMES = np.linspace(0.0, 0.6, 61)
FINE = fm.Adaptive(rtol=1e-8)


@pytest.mark.slow
def test_numbers_of_an_oscillator_come_back():
    bounds = {"rate": (20.0, 200.0), "damping": (0.05, 3.0), "start": (0.02, 0.5)}
    times = TIMES[:31]
    data = record(times, moved(times, 90.0, 0.7, 0.13))
    found = fm.design.fit(oscillator, bounds, data, signals=["body.x"], step=FINE)
    assert found.ok
    assert list(found.parameters.values()) == pytest.approx([90.0, 0.7, 0.13], rel=1e-6)
    assert found.rms < 1e-6
    assert "Converged" in repr(found)


@pytest.mark.slow
@pytest.mark.parametrize("records", [2, pytest.param(20, marks=pytest.mark.slow)])
def test_standard_errors_have_the_size_of_the_scatter(records):
    """Errors over standard errors of noisy records, of two parameters and an offset."""
    scatter, bounds = [], {"rate": (60.0, 120.0), "damping": (0.1, 2.0)}
    draws = np.random.default_rng(5)
    for _ in range(records):
        noisy = moved(TIMES, 90.0, 0.7, 0.1) + 0.02 + 2e-3 * draws.standard_normal(len(TIMES))
        how = {"noise": 2e-3, "offset": ["body.x"], "start": {"rate": 80.0}}
        found = fm.design.fit(oscillator, bounds, record(TIMES, noisy), signals=["body.x"], **how)
        assert found.offsets["body.x"] == pytest.approx(0.02, abs=1.5e-3)
        scatter.append(
            [(found.parameters[k] - true) / found.errors[k] for k, true in (("rate", 90.0), ("damping", 0.7))]
        )
    rms = np.sqrt(np.mean(np.square(scatter), axis=0))
    assert (rms < (1.5 if records == 20 else 3.0)).all()
    assert (rms > (0.6 if records == 20 else 0.0)).all()  # twenty records: 1 +- 0.16


@pytest.mark.slow
def test_parameters_that_the_data_do_not_tell_apart_are_named():
    def two_springs(first: float, second: float) -> fm.Mechanism:
        return oscillator(first + second, 0.5)

    data = record(TIMES, moved(TIMES, 90.0, 0.5, 0.1))
    bounds, start = {"first": (1.0, 80.0), "second": (1.0, 80.0)}, {"first": 30.0}
    found = fm.design.fit(two_springs, bounds, data, signals=["body.x"], start=start)
    assert sum(found.parameters.values()) == pytest.approx(90.0, rel=1e-4)
    assert "first" in found.unseen[0]
    assert "second" in found.unseen[0]
    assert np.isinf(list(found.errors.values())).all()
    assert "Not told apart" in repr(found)


def test_outliers_do_not_move_a_robust_fit():
    times = TIMES[:41]
    noisy = moved(times, 90.0, 0.7, 0.1)
    noisy[::20] += 0.3
    how = {"signals": ["body.x"], "noise": 1e-3, "start": {"rate": 80.0}}
    bounds = {"rate": (60.0, 120.0), "damping": (0.1, 2.0)}
    plain = fm.design.fit(oscillator, bounds, record(times, noisy), **how)
    robust = fm.design.fit(oscillator, bounds, record(times, noisy), loss="cauchy", **how)
    assert abs(robust.parameters["rate"] - 90.0) < 0.02 * abs(plain.parameters["rate"] - 90.0)


@pytest.mark.slow
def test_file_with_gaps_of_its_own_time(tmp_path):
    """A CSV file whose times are uneven and whose values have holes; the run begins within it."""
    t = np.sort(np.random.default_rng(2).uniform(0.0, 0.6, 50))
    values = moved(t, 90.0, 0.7, 0.1)
    values[10:20] = np.nan
    rows = [f"{time + 3.0},{value}" for time, value in zip(t, values, strict=True)]
    file = tmp_path / "record.csv"
    file.write_text("\n".join(["time,body.x", "1.0,7.0", *rows]))
    bounds = {"rate": (60.0, 120.0), "damping": (0.1, 2.0)}
    how = {"begin": 3.0, "step": FINE, "start": {"rate": 80.0}}
    found = fm.design.fit(oscillator, bounds, file, signals=["body.x"], **how)
    assert list(found.parameters.values()) == pytest.approx([90.0, 0.7], rel=1e-5)
    assert "Left out: 1 of 51 instants (before `begin` or without a time), 10 values" in found.message
    file.write_text("\n".join(["time,body.x", *rows, "9.0,0.1V"]))
    with pytest.raises(InputError, match=r"body.x has '0.1V' in line 52; give numbers, and nothing where one is"):
        fm.design.fit(oscillator, bounds, file, signals=["body.x"], begin=3.0)


@pytest.mark.slow
def test_standard_errors_of_a_robust_fit_are_those_without_the_outliers():
    """The noise is not given: its level is that of the scatter, of which outliers are no part, or a bounded one."""
    rng = np.random.default_rng(5)
    values = moved(TIMES, 90.0, 0.7, 0.1) + rng.normal(0.0, 2e-3, len(TIMES))
    bounds, clean = {"rate": (60.0, 120.0), "damping": (0.1, 2.0)}, np.arange(len(TIMES)) % 20 > 0
    kept = fm.design.fit(oscillator, bounds, record(TIMES[clean], values[clean]), signals=["body.x"])
    values[~clean] += 0.3
    for loss, most in (("cauchy", 1.6), ("huber", 2.5)):
        found = fm.design.fit(oscillator, bounds, record(TIMES, values), signals=["body.x"], loss=loss)
        for name, error in kept.errors.items():
            assert 0.9 * error < found.errors[name] < most * error


@pytest.mark.slow
def test_clearance_and_mass_from_a_noisy_acceleration():
    """Two turns of a worn slider-crank with dozens of impacts; the search begins anywhere within wide bounds."""
    data = fm.simulate(slider_crank(speed=100.0, clearance=1.2e-4), periods=2, signals=["slider.ax"]).dataset
    exact = data["slider.ax"]
    draws = np.random.default_rng(1)
    data["slider.ax"] = exact + 0.02 * float(abs(exact).max()) * draws.standard_normal(exact.shape)
    bounds = {"B.clearance": (2e-5, 5e-4), "slider.mass": (0.05, 0.5)}
    found = fm.design.fit(worn(), bounds, data, signals=["slider.ax"])
    for name, true in (("B.clearance", 1.2e-4), ("slider.mass", 0.14)):
        assert abs(found.parameters[name] - true) < 3.0 * found.errors[name]
        assert found.errors[name] < 1e-3 * true


GOOD = record(TIMES, moved(TIMES, 90.0, 0.7, 0.1))


def test_standard_errors_are_those_of_the_closed_form():
    noise, h = 1e-3, 1e-4
    bounds, how = {"rate": (60.0, 120.0), "damping": (0.1, 2.0)}, {"noise": {"body.x": noise}, "start": {"rate": 80.0}}
    fit = fm.design.fit(oscillator, bounds, GOOD, signals=["body.x"], **how)
    columns = [
        (moved(TIMES, 90.0 + h * a, 0.7 + h * b, 0.1) - moved(TIMES, 90.0 - h * a, 0.7 - h * b, 0.1)) / (2.0 * h)
        for a, b in ((1.0, 0.0), (0.0, 1.0))
    ]
    expected = noise * np.sqrt(np.diag(np.linalg.inv(np.array(columns) @ np.transpose(columns))))
    assert list(fit.errors.values()) == pytest.approx(expected, rel=1e-2)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"parameters": {"rat": (1.0, 2.0)}}, "rate"),
        ({"parameters": {"rate": (2.0, 1.0)}}, "bounds of rate are 2 and 1"),
        ({"parameters": {"rate": (1.0, 2.0, 3.0)}}, "two bounds"),
        ({"parameters": {"rate": 3.0}}, "two bounds"),
        ({"data": GOOD.isel(time=slice(0, 1))}, "increasing times"),
        ({"data": GOOD.isel(time=slice(None, None, -1))}, "increasing times"),
        ({"data": record(np.append(TIMES, TIMES[-1] + 1e-12), np.zeros(len(TIMES) + 1))}, "increasing times"),
        ({"parameters": {}}, "at least one"),
        ({"signals": []}, "at least one name"),
        ({"signals": ["body.x", "body.x"]}, "each of them once"),
        ({"data": GOOD.expand_dims("k")}, "no row of numbers along 'time'"),
        ({"data": GOOD.astype(str)}, "no row of numbers along 'time'"),
        ({"data": GOOD * np.nan}, "0 measured numbers"),
        ({"noise": 0.0}, "noise of body.x is 0"),
        ({"noise": {"body_x": 1e-3}}, "noise is of body_x; name all signals"),
        ({"data": 7.0}, "xarray signals along 'time'"),
        ({"data": "nowhere.csv"}, "cannot be read as CSV"),
        ({"signals": ["body.vx"]}, "body.x"),
        ({"loss": "square"}, "huber"),
        ({"noise": -1.0}, "noise of body.x"),
        ({"offset": ["body.y"]}, "offset"),
        ({"offset": 3}, "offset is 3"),
        ({"offset": "body.x"}, "offset is 'body.x'"),
        ({"most_runs": 0}, "most_runs is 0"),
        ({"begin": 1.99}, "increasing times|measured numbers"),
    ],
)
def test_wrong_input_is_refused(changes, message):
    given = {
        "parameters": {"rate": (60.0, 120.0), "damping": (0.1, 2.0)},
        "data": GOOD,
        "signals": ["body.x"],
    } | changes
    with pytest.raises(InputError, match=message):
        fm.design.fit(oscillator, given.pop("parameters"), given.pop("data"), **given)


def test_csv_file_with_a_mark_of_the_byte_order(tmp_path):
    """Spreadsheets write it before the first name."""
    file = tmp_path / "data.csv"
    file.write_text("time,body.x\n0,1\n0.5,2\n", encoding="utf-8-sig")
    assert read_csv("fit", file)["body.x"].values.tolist() == [1.0, 2.0]


@pytest.mark.slow
def test_models_that_fail_within_the_bounds_turn_the_search_back():
    """An error of the user's function beyond a rate of 95 N/m, where the true one is 90 N/m."""

    def narrow(rate: float) -> fm.Mechanism:
        if rate > 95.0:
            raise ValueError("math domain error")
        return oscillator(rate, 0.7)

    short = GOOD.isel(time=slice(0, 40))
    found = fm.design.fit(narrow, {"rate": (60.0, 120.0)}, short, signals=["body.x"], noise=1e-3)
    assert found.parameters["rate"] == pytest.approx(90.0, rel=1e-3)


def test_a_model_that_always_fails_is_told_with_its_error():
    def broken(rate: float) -> fm.Mechanism:
        raise KeyError("table")

    with pytest.raises(ModelError, match=r"failed at .*rate.*KeyError: 'table'"):
        fm.design.fit(broken, {"rate": (60.0, 120.0)}, GOOD, signals=["body.x"])


@pytest.mark.slow
def test_a_parameter_that_ends_at_a_bound_of_nothing_has_an_error():
    """Derivatives of a damping that is nearly 0 are judged by the width of its bounds."""
    data = record(TIMES, moved(TIMES, 90.0, 0.0, 0.1) + 1e-3 * np.random.default_rng(3).standard_normal(len(TIMES)))
    bounds, start = {"rate": (60.0, 120.0), "damping": (0.0, 2.0)}, {"rate": 80.0}
    found = fm.design.fit(oscillator, bounds, data, signals=["body.x"], start=start)
    assert found.parameters["damping"] < 0.05
    assert 1e-3 < found.errors["damping"] < 0.05
    assert found.unseen == ()


TRUE = {"clearance": 1.2e-4, "restitution": 0.75, "friction": 0.06, "mass": 0.14}


def rattling(clearance: float, restitution: float, friction: float, mass: float) -> fm.Mechanism:
    """A slider-crank with a worn pin: six contacts in a third of a turn."""
    normal = fm.contact.ExactRestitution.from_materials(fm.STEEL, fm.STEEL, restitution=restitution)
    crank = slider_crank(speed=100.0, clearance=clearance, friction=fm.friction.SmoothCoulomb(friction, v0=0.01))
    return crank.with_({"B.normal": normal, "slider.mass": mass})


@pytest.mark.slow
def test_standard_errors_hold_what_is_true_in_a_hundred_repetitions():
    """Noise of 2 % of the peak; searches begin some errors away.  Of 100 numbers 95 are expected within two errors."""
    run = fm.simulate(rattling(**TRUE), t_end=0.02, save=1000)
    exact = run.dataset["slider.ax"].values
    noise = 0.02 * float(np.abs(exact).max())
    bounds = {"clearance": (5e-5, 3e-4), "restitution": (0.5, 0.95), "friction": (0.01, 0.2), "mass": (0.05, 0.5)}
    off = []
    for seed in range(100):
        rng = np.random.default_rng(1000 + seed)
        data = run.dataset[["slider.ax"]].copy()
        data["slider.ax"] = ("time", exact + noise * rng.standard_normal(len(exact)))
        guess = {name: value * (1.0 + 2e-3 * rng.standard_normal()) for name, value in TRUE.items()}
        found = fm.design.fit(rattling, bounds, data, signals=["slider.ax"], noise=noise, start=guess)
        off.append([(found.parameters[name] - value) / found.errors[name] for name, value in TRUE.items()])
    within = (np.abs(off) < 2.0).sum(axis=0)
    assert within.min() >= 90, dict(zip(TRUE, within.tolist(), strict=True))
    scatter = np.std(off, axis=0)
    assert (scatter > 0.7).all(), scatter
    assert (scatter < 1.3).all(), scatter
