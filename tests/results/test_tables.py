"""Several signals at once, tables, and the instants that are saved."""

import numpy as np
import pandas as pd
import pytest

import flexmb as fm
from flexmb.errors import InputError

MECHANISM = fm.mechanisms.slider_crank(200.0, clearance=2e-4)


@pytest.fixture(scope="module")
def sol():
    return fm.simulate(MECHANISM, t_end=5e-3, save=50)


def test_several_signals(sol):
    found = sol[["slider.x", "B.normal_force"]]
    assert list(found.data_vars) == ["slider.x", "B.normal_force"]
    assert np.array_equal(found["slider.x"], sol["slider.x"])
    assert found["B.normal_force"].attrs["units"] == "N"
    assert found.attrs["mechanism"] == sol.name
    assert sol["slider.x", "B.normal_force"].identical(found)


def test_a_pattern(sol):
    found = sol["slider.*"]
    assert list(found.data_vars) == [name for name in sol.names if name.startswith("slider.")]
    assert list(sol[["crank.x", "B.e*"]].data_vars)[:2] == ["crank.x", "B.ex"]
    assert sol["*"].identical(sol.dataset)
    assert fm.simulate(MECHANISM, t_end=1e-4, signals=["slider.*"])["*"].sizes["time"] > 1


@pytest.mark.parametrize("wanted", ["slidr.*", ["slider.x", "slider.q"], ["slider.x", 3], 3])
def test_what_fits_no_signal(sol, wanted):
    with pytest.raises(KeyError, match="has no signal"):
        sol[wanted]


def test_a_table_of_pandas(sol):
    table = sol.to_dataframe()
    assert isinstance(table, pd.DataFrame)
    assert table.index.name == "time"
    assert np.array_equal(table.index, sol.time)
    assert list(table.columns) == list(sol.names)
    assert np.array_equal(table["slider.x"], sol["slider.x"])
    assert list(sol["slider.v*"].to_dataframe().columns) == ["slider.vx", "slider.vy"]


OPTIONS = {
    "newmark": {},
    "fixed": {"step": 1e-5},
    "radau": {"method": fm.RadauIIA()},
    "runge-kutta": {"method": fm.RungeKutta4(), "step": fm.FixedStep(2e-6)},
}


@pytest.mark.parametrize("method", OPTIONS)
def test_an_interval(method):
    """0.1 ms over 5 ms: 51 instants, as with the number 50; the steps are the same."""
    options = {"t_end": 5e-3, **OPTIONS[method]}
    mechanism = fm.mechanisms.slider_crank(200.0)
    few, many = (fm.simulate(mechanism, save=save, **options) for save in (50, 1e-4))
    assert np.allclose(many.time, 1e-4 * np.arange(51), rtol=1e-12, atol=0.0)
    assert np.array_equal(few.values, many.values)
    assert few.stats.steps == many.stats.steps


@pytest.mark.parametrize("method", OPTIONS)
def test_times(method):
    """Times of any distance are saved, and no others: those of a fine grid have the same rows, bit for bit."""
    mechanism, options = fm.mechanisms.slider_crank(200.0), {"t_end": 5e-3, **OPTIONS[method]}
    grid = fm.simulate(mechanism, save=1e-4, **options)
    for chosen in ([0, 3, 4, 17, 50], [1], [49, 50], [12, 30]):
        sol = fm.simulate(mechanism, save=grid.time[chosen], **options)
        assert np.array_equal(sol.time, grid.time[chosen])
        assert np.array_equal(sol.values, grid.values[chosen])
        assert {name: array.tobytes() for name, array in sol.restart.items() if name not in ("clock", "model")} == {
            name: array.tobytes() for name, array in grid.restart.items() if name not in ("clock", "model")
        }


def test_times_of_a_fall():
    """x = g t^2 / 2 at instants of a logarithmic scale; sqrt(2) and pi are no multiples of anything."""
    body = fm.RigidBody("ball", (0.0, 0.0), 1.0, 1.0)
    times = [1e-6, 1e-3, 0.1, np.sqrt(2.0), 3.0, np.pi]
    sol = fm.simulate(fm.Mechanism("fall", [body], gravity=(0.0, -9.81)), t_end=4.0, save=times)
    assert sol.time.tolist() == times
    assert np.asarray(sol["ball.y"]) == pytest.approx(-4.905 * np.square(times), rel=1e-9, abs=1e-13)


def test_times_with_stops_restarts_and_checkpoints(tmp_path):
    mechanism, times = fm.mechanisms.slider_crank(200.0), [1e-3, 2e-3, 2.5e-3, 4e-3]
    whole = fm.simulate(mechanism, t_end=5e-3, save=times)
    stopped = fm.simulate(mechanism, t_end=5e-3, save=times, stop=fm.when("slider.vx", below=-20.0))
    assert stopped.ok
    assert stopped.time.tolist() == [t for t in times if t <= stopped.restart["clock"][0]]
    cut = fm.simulate(mechanism, t_end=5e-3, save=times, max_steps=whole.stats.steps // 2)
    rest = fm.simulate(mechanism, t_end=5e-3, restart=cut.restart, save=[t for t in times if t > cut.time[-1]])
    assert [*cut.time, *rest.time] == times
    assert np.array_equal(np.concatenate([cut.values, rest.values]), whole.values)
    last = fm.simulate(mechanism, t_end=2e-3, save=[1e-3, 2e-3])
    assert last.time.tolist() == [1e-3, 2e-3]
    again = fm.simulate(mechanism, t_end=4e-3, restart=last.restart, save=[2e-3, 4e-3])
    assert again.time.tolist() == [2e-3, 4e-3]


@pytest.mark.parametrize(
    ("save", "words"),
    [
        (0.5, "save is an interval of 0.5 s, but 0.005 s are saved.*an integer"),
        (-1e-3, "must be > 0"),
        (float("nan"), "save"),
        ([2e-3, 1e-3], r"save\[1\] is 0.001 s after 0.002 s; times must increase"),
        ([1e-3, 6e-3], "save holds 0.006 s; its times must lie from 0 to 0.005 s"),
        ([], "save"),
        ("1ms", "must be a number of instants, an interval"),
        (0, "at least 1"),
        (True, "whole number"),
        (None, "whole number"),
        ([[1e-3]], "save"),
    ],
)
def test_what_cannot_be_saved(save, words):
    with pytest.raises(InputError, match=words):
        fm.simulate(MECHANISM, t_end=5e-3, save=save)


def test_the_command_takes_an_interval_with_its_unit(tmp_path):
    from flexmb.cli.command_line import main

    common = ["run", "slider-crank", "--t-end", "5ms", "--out", str(tmp_path), "--no-plots", "--no-report", "--quiet"]
    assert main([*common, "--save", "1ms"]) == 0
    assert fm.load(tmp_path / "slider-crank.nc").time == pytest.approx(1e-3 * np.arange(6))
    assert main([*common, "--save", "0.5"]) == 2
