"""What comes out of diagrams and sweeps: hysteresis, seams, failures, names, units, refusals, pictures."""

import os
import signal
import threading
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from typing import Annotated

import numba
import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp
from sweep_models import DAMPING, OMEGA, Well, bistable, leaves, logistic, logistic_map, results, uneven

import flexmb as fm
from flexmb.dynamics.jobs.executors import Job, attempted, drive
from flexmb.dynamics.sweeps.bifurcation import Family, SectionSettings, section_point
from flexmb.dynamics.systems.given import Map
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow
from flexmb.errors import AssemblyError

PERIOD = 2.0 * np.pi / OMEGA


def map_of(r=3.0):
    return Map(logistic, [0.3], parameters={"r": r})


def quiet(system, parameter, values, **settings):
    return fm.bifurcation(system, parameter, values, **{"skip": 200, "keep": 16, **settings})


def test_fixed_points_and_period_two_are_exact():
    r = np.array([1.5, 2.0, 2.9, 3.1, 3.4])
    found = quiet(map_of(), "r", r, skip=2000)
    points = np.sort(found["x0"].values, axis=1)
    np.testing.assert_allclose(points[:3], np.repeat(1.0 - 1.0 / r[:3, None], 16, axis=1), rtol=1e-12)
    root = np.sqrt((r[3:] + 1.0) * (r[3:] - 3.0))
    np.testing.assert_allclose(points[3:, 0], (r[3:] + 1.0 - root) / (2.0 * r[3:]), rtol=1e-12)
    np.testing.assert_allclose(points[3:, -1], (r[3:] + 1.0 + root) / (2.0 * r[3:]), rtol=1e-12)
    assert found["verdict"].values.tolist() == ["periodic-1"] * 3 + ["periodic-2"] * 2


def test_the_exponent_of_the_points_themselves():
    after, together = (quiet(map_of(), "r", [3.2, 4.0], keep=400, exponent=over) for over in (True, "points"))
    np.testing.assert_array_equal(together["x0"].values, after["x0"].values)
    np.testing.assert_array_equal(together["period"].values, after["period"].values)
    assert together["verdict"].values.tolist() == ["periodic-2", "chaotic"]
    doubled = 0.5 * np.log(abs(4.0 + 2.0 * 3.2 - 3.2**2))  # of the cycle a, b: f(a)' f(b)' = 4 + 2 r - r^2
    assert together["exponent"].values[0] == pytest.approx(doubled, abs=1e-9)
    assert together["exponent"].values[1] == pytest.approx(np.log(2.0), abs=0.05)


def test_the_layout():
    found = quiet(logistic_map, "r", [2.0, 3.31, 3.5], direction="both", fixed={"start": 0.2})
    assert found["x0"].dims == ("direction", "r", "period")
    assert found["direction"].values.tolist() == ["up", "down"]
    assert found["period"].values.tolist() == list(range(200, 216))
    assert found["r"].attrs["units"] == "1/s"
    assert found["ok"].values.tolist() == [[True, False, True]] * 2
    assert found["x0"].isnull().all("period").values.tolist() == [[False, True, False]] * 2
    assert found["verdict"].values[0, 1] == ""
    assert found["status"].values[0, 1].startswith("InputError: r is 3.3100; it must not be.")
    assert np.isnan(found["exponent"].values).all()
    one = quiet(logistic_map, "r", [2.0, 3.5], direction="up")
    assert one["x0"].dims == ("r", "period")
    assert one.attrs["direction"] == "up"


def test_a_dataset_can_be_written(tmp_path):
    found = quiet(logistic_map, "r", [2.0, 3.31, 3.5], direction="both")
    found.to_netcdf(tmp_path / "d.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "d.nc", engine="h5netcdf") as again:
        xr.testing.assert_equal(again.load(), found)


def test_a_state_is_carried_from_value_to_value():
    """x -> r x: at each value the points begin where those of the value before ended."""
    grow = Map(times, [1.0], parameters={"r": 1.0})
    found = fm.bifurcation(grow, "r", [0.5, 2.0, 3.0], skip=0, keep=3, direction="both")
    up, down = found["x0"].values
    np.testing.assert_array_equal(up, [[1.0, 0.5, 0.25], [0.25, 0.5, 1.0], [1.0, 3.0, 9.0]])
    np.testing.assert_array_equal(down, [[36.0, 18.0, 9.0], [9.0, 18.0, 36.0], [1.0, 3.0, 9.0]])
    assert not found["seam"].values.any()


def times(x, r):
    return [r * x[0]]


def test_seams_are_where_parts_begin():
    values = np.linspace(2.0, 2.9, 10)
    found = quiet(map_of(), "r", values[::-1], direction="both", chunks=3, skip=1, keep=1)
    up, down = found["seam"].values[:, ::-1]
    assert np.flatnonzero(up).tolist() == [4, 7]
    assert np.flatnonzero(down).tolist() == [3, 6]


def test_a_failed_point_is_stepped_over():
    """The state of the last value that went well is carried across a failure; only without one a seam is made."""
    found = fm.bifurcation(logistic_map, "r", [3.2, 3.31, 3.4], skip=0, keep=2, direction="up")
    assert found["seam"].values.tolist() == [False, False, False]
    assert found["x0"].values[2, 0] == found["x0"].values[0, 1]
    found = fm.bifurcation(logistic_map, "r", [3.31, 3.4, 3.5], skip=0, keep=2, direction="up")
    assert found["seam"].values.tolist() == [False, True, False]


@pytest.mark.slow
def test_a_bistable_oscillator_has_hysteresis():
    """A mass in a valley of x^4/4 - x^2/2, of parts: its softening resonance folds over, up and down differ between."""
    values = np.round(np.arange(0.04, 0.115, 0.01), 2)
    settings = {"skip": 150, "keep": 24, "period": PERIOD, "step": PERIOD / 150}
    found = fm.bifurcation(bistable(), "well.amplitude", values, direction="both", **settings)
    assert found["ok"].values.all()
    assert (found["verdict"].values == "periodic-1").all()
    up, down = found["mass.x"].values[:, :, -1]
    differ = np.abs(up - down) > 0.1
    assert np.flatnonzero(differ).tolist() == [2, 3, 4, 5, 6]  # 0.06 to 0.10; at both ends there is one motion
    assert np.abs(up - down)[~differ].max() < 1e-3
    for k in np.flatnonzero(differ):  # both are periodic motions of the equation, solved by another method
        for row in (0, 1):
            x, v = (found[name].values[row, k, -1] for name in ("mass.x", "mass.vx"))
            np.testing.assert_allclose(a_period_later(x, v, values[k]), (x, v), atol=3e-3)


def a_period_later(x, v, amplitude):
    """The state of x'' + d x' - x + x^3 = a cos w t a period after (x, v) at t = 0."""

    def rate(t, y):
        return y[1], amplitude * np.cos(OMEGA * t) - DAMPING * y[1] + y[0] - y[0] ** 3

    return solve_ivp(rate, (0.0, PERIOD), (x, v), method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]


def test_a_mechanism_in_parts_is_the_one_of_make():
    settings = {"skip": 2, "keep": 2, "period": PERIOD, "step": PERIOD / 50}
    first = fm.bifurcation(bistable, "amplitude", [0.1, 0.2], **settings)
    second = fm.bifurcation(bistable(0.7), "well.amplitude", [0.1, 0.2], **settings)
    third = fm.bifurcation(
        MechanismFlow(bistable(), period=PERIOD, step=PERIOD / 50), "well.amplitude", [0.1, 0.2], skip=2, keep=2
    )
    np.testing.assert_array_equal(first["mass.x"].values, second["mass.x"].values)
    np.testing.assert_array_equal(first["mass.x"].values, third["mass.x"].values)
    assert first["drive_period"].values.tolist() == [PERIOD, PERIOD]


def test_the_period_is_found_anew_at_every_value():
    found = fm.bifurcation(fm.mechanisms.slider_crank, "speed", [10.0, 20.0], skip=1, keep=3, signals=["crank.theta"])
    np.testing.assert_allclose(found["drive_period"].values, [2.0 * np.pi / 10.0, 2.0 * np.pi / 20.0], rtol=1e-14)
    turned = np.abs(np.diff(found["crank.theta"].values, axis=1))
    np.testing.assert_allclose(turned, 2.0 * np.pi, rtol=1e-9)
    assert found["speed"].attrs["units"] == "rad/s"


def test_points_are_those_of_a_plain_run():
    """Stroboscopic points of the slider-crank against the signals that `simulate` saves at ends of periods."""
    step = 2.0 * np.pi / 15.0 / 400
    found = fm.bifurcation(fm.mechanisms.slider_crank, "speed", [15.0], skip=1, keep=2, step=step)
    sol = fm.simulate(fm.mechanisms.slider_crank(speed=15.0), periods=2, save=1, step=step)
    np.testing.assert_allclose(found["slider.ax"].values[0], sol.array("slider.ax")[1:], rtol=1e-9)


def test_a_mechanism_is_carried_onto_its_joints():
    found = fm.bifurcation(
        fm.mechanisms.slider_crank, "speed", [10.0, 11.0], skip=1, keep=2, direction="up", fixed={"clearance": 1e-4}
    )
    assert found["ok"].values.all(), found["status"].values
    assert not found["seam"].values.any()


def test_a_period_may_depend_on_the_value():
    well = partial(system_of, amplitude=0.2)
    found = fm.bifurcation(well, "omega", [1.0, 2.0], skip=1, keep=2, period=period_of)
    np.testing.assert_array_equal(found["drive_period"].values, [2.0 * np.pi, np.pi])


def system_of(omega, amplitude):
    return bistable().with_part(Well("well", bistable().find("mass"), amplitude, omega))


def period_of(omega):
    return 2.0 * np.pi / omega


@pytest.mark.slow
def test_ctrl_c_is_no_result():
    family = Family(bistable(), "well.amplitude", {}, step=1e-5, period=PERIOD)
    section_point(
        family, SectionSettings(0, 2, ("mass.x",)), 0.1, None
    )  # compiled now, so that the signal meets the run
    timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # what runs in the background may ignore it
    try:
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            attempted(section_point, family, SectionSettings(0, 200, ("mass.x",)), 0.1, None)
        timer.join()
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"values": []}, "values is empty"),
        ({"values": [1.0, np.nan]}, r"values\[1\]"),
        ({"values": [1.0, 1.0]}, "twice"),
        ({"values": ["a"]}, r"values\[0\]"),
        ({"values": 3.0}, "list of numbers"),
        ({"skip": -1}, "skip"),
        ({"keep": 0}, "keep"),
        ({"keep": 1.5}, "keep"),
        ({"direction": "sideways"}, "Known: cold, up, down, both"),
        ({"direction": "up", "chunks": 5}, "chunks is 5"),
        ({"chunks": 2}, "cold points are independent"),
        ({"signals": ["y0"]}, "'y0'"),
        ({"signals": "x0"}, "list of names"),
        ({"parameter": "q"}, "'q'"),
        ({"parameter": "period"}, "'period'"),
        ({"fixed": {"q": 1.0}}, "'q'"),
        ({"executor": "four"}, "ProcessPoolExecutor"),
        ({"pending": 0}, "pending"),
        ({"exponent": -3}, "exponent"),
        ({"exponent": "later"}, "Known: points"),
        ({"exponent": "points", "skip": 0, "keep": 50}, "Give skip=1"),
        ({"exponent": "points", "keep": 9}, "at least 50"),
        ({"make": 3}, "it must be a function"),
        ({"make": logistic}, "x is missing"),
        ({"make": lambda r: r}, "returned float"),
        ({"make": lambda period: map_of(), "parameter": "period"}, "Rename the parameter"),
        ({"make": bistable, "parameter": "amplitude"}, "period"),
    ],
)
def test_what_makes_no_sense_is_refused(changes, words):
    arguments = {"make": map_of(), "parameter": "r", "values": [2.0, 2.5], "skip": 3, "keep": 2, **changes}
    make, parameter, values = (arguments.pop(name) for name in ("make", "parameter", "values"))
    with pytest.raises(fm.errors.InputError, match=words):
        fm.bifurcation(make, parameter, values, **arguments)


def test_what_cannot_be_sent_is_refused_before_anything_starts(tmp_path):
    with ProcessPoolExecutor(1) as pool:
        with pytest.raises(fm.errors.InputError, match="function at the top of a module"):
            quiet(lambda r: map_of(1.0 * r), "r", [2.0], executor=pool, store=tmp_path / "s")
        with pytest.raises(fm.errors.InputError, match="not a lambda"):
            fm.sweep(lambda a: a, {"a": [1]}, executor=pool, store=tmp_path / "s")
        assert pool._processes == {}
    assert not (tmp_path / "s").exists()
    with ThreadPoolExecutor(1) as pool:
        assert fm.sweep(lambda a: 2 * a, {"a": [1]}, executor=pool)["value"].values.tolist() == [2.0]


def test_a_client_instead_of_its_executor_is_refused():
    with pytest.raises(fm.errors.InputError, match=r"client\.get_executor\(\)"):
        fm.sweep(results, {"a": [1]}, executor=object())


@pytest.mark.parametrize("executor", [0, -1, 2.5, True, "2"])
def test_a_number_of_threads_is_a_count(executor):
    with pytest.raises(fm.errors.InputError, match="number of threads"):
        fm.sweep(results, {"a": [1]}, executor=executor)


class Counting(Executor):
    """Runs jobs when they are waited for; remembers how many it had at the same time."""

    def __init__(self):
        self.most = self.now = 0

    def submit(self, function, *arguments):
        self.now += 1
        self.most = max(self.most, self.now)
        future = Future()
        timer = threading.Timer(0.002, self.run, (future, function, arguments))
        timer.start()
        return future

    def run(self, future, function, arguments):
        self.now -= 1
        future.set_result(function(*arguments))


def test_no_more_jobs_are_pending_than_allowed():
    pool = Counting()
    found = fm.sweep(results, {"a": np.arange(5.0), "b": np.arange(6.0, 14.0)}, executor=pool, pending=4)
    assert found["ok"].values.all()
    assert 2 <= pool.most <= 4


def test_jobs_that_are_left_are_cancelled():
    class Stuck(Executor):
        futures = ()

        def submit(self, function, *arguments):
            self.futures = (*self.futures, Future())
            if len(self.futures) == 3:
                self.futures[0].set_exception(RuntimeError("no worker"))
            return self.futures[-1]

    def one():
        yield Job(results, (1, 2))

    pool = Stuck()
    with pytest.raises(fm.errors.WorkerError, match="RuntimeError: no worker"):
        drive((one() for _ in range(3)), pool, "test")
    assert [future.cancelled() for future in pool.futures] == [False, True, True]


def test_a_grid_and_its_failures():
    found = fm.sweep(results, {"a": [2, 1, 3], "b": [5.0, 6.0]}, dims={"powers": ["power"]})
    assert found["sum"].dims == ("a", "b")
    assert found["powers"].dims == ("a", "b", "power")
    assert found["root"].values[1, 1] == 6j
    assert found["word"].values[2].tolist() == ["3", "3"]
    assert found["powers"].values[2, 0].tolist() == [1.0, 3.0, 9.0]
    assert found["status"].values[0].tolist() == ["ZeroDivisionError: no result of <object object>", "done"]
    assert np.isnan(found["sum"].values[0, 0])
    assert found["ok"].values.sum() == 5


def test_designs():
    qmc = pytest.importorskip("scipy.stats").qmc
    sample = qmc.scale(qmc.LatinHypercube(2, rng=0).random(6), [0.0, 10.0], [1.0, 20.0])
    found = fm.sweep(total, [{"a": a, "b": b} for a, b in sample], fixed={"c": 1.0})
    np.testing.assert_allclose(found["value"].values, sample.sum(axis=1) + 1.0, rtol=1e-15)
    np.testing.assert_array_equal(found["b"].values, sample[:, 1])
    assert found["value"].dims == ("design",)


def total(a: Annotated[float, "mm"], b: Annotated[float, "mm"], c: Annotated[float, "m"]):
    """The sum of lengths."""
    return a + b + c


def test_units_names_and_values_that_are_no_numbers():
    found = fm.sweep(total, {"a": [1.0], "b": [2.0], "c": [3.0]})
    assert [found[name].attrs.get("units") for name in "abc"] == ["mm", "mm", "m"]
    found = fm.sweep(lambda flag, name, law: len(name), {"flag": [True, False], "name": ["x", "yz"], "law": [fm.STEEL]})
    assert found["flag"].values.tolist() == [True, False]
    assert found["name"].values.tolist() == ["x", "yz"]
    assert found["value"].values[:, :, 0].tolist() == [[1.0, 2.0]] * 2


def test_named_dimensions_of_arrays_are_kept():
    found = fm.sweep(lambda a: xr.DataArray([a, a], dims="node"), {"a": [1.0, 2.0]})
    assert found["value"].dims == ("a", "node")
    found = fm.sweep(lambda a: {"x": np.zeros(3), "y": np.ones(3)}, {"a": [1.0]}, dims={"x": ["k"], "y": ["k"]})
    assert found["y"].dims == ("a", "k")


@pytest.mark.parametrize("order", [[1, 2, 1], [1, 1, 2]])
def test_other_results_than_at_the_first_point_have_failed(order, tmp_path):
    for store in (None, tmp_path / "s"):
        found = fm.sweep(uneven, [{"a": a} for a in order], store=store)
        assert found["ok"].values.tolist() == [a == 1 for a in order]
        assert "at the first point" in found["status"].values[order.index(2)]


@pytest.mark.parametrize("results", [(1.0, "broken"), ("whole", 1.0), ("whole", 1j)])
def test_texts_and_numbers_in_one_column_have_failed(results):
    """A text at a point behind numbers ended the whole sweep with an error of Python."""
    found = fm.sweep(lambda k: {"x": results[k]}, {"k": [0, 1, 0]})
    assert found["ok"].values.tolist() == [True, False, True]
    assert found["x"].values[[0, 2]].tolist() == [results[0]] * 2
    assert "'x' is" in str(found["status"].values[1])


def test_the_first_point_that_goes_well_decides_in_any_order():
    """Results that come back in the reverse order are held until the first one is there."""

    class Late(Executor):
        waiting = ()

        def submit(self, function, *arguments):
            self.waiting = (*self.waiting, (Future(), function, arguments))
            if len(self.waiting) == 3:
                for future, call, given in reversed(self.waiting):
                    future.set_result(call(*given))
            return self.waiting[-1][0]

    found = fm.sweep(uneven, [{"a": 1}, {"a": 2}, {"a": 1}], executor=Late())
    assert found["ok"].values.tolist() == [True, False, True]


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (lambda a: None, "NoneType"),
        (lambda a: {}, "empty mapping"),
        (lambda a: {"a": 1.0}, "name of the dataset"),
        (lambda a: {"status": 1.0}, "name of the dataset"),
        (lambda a: {3: 1.0}, "called 3"),
        (lambda a: {"x": {"y": 1.0}}, "dict"),
        (lambda a: {"x": np.zeros(2), "y": np.zeros(3)}, "two lengths"),
        (lambda a: {"k": np.zeros(3), "x": np.zeros(3)}, "called like a dimension"),
        (lambda a: a[0], "TypeError"),
        (leaves, "SystemExit: 3"),
    ],
)
def test_what_is_no_result_is_a_failure_with_a_reason(function, words, tmp_path):
    dims = {"x": ["k"], "y": ["k"]}
    found = fm.sweep(function, {"a": [1.0, 2.0]}, dims=dims, store=tmp_path / "s")
    assert not found["ok"].values.any()
    assert all(words in status for status in found["status"].values)
    again = fm.sweep(function, {"a": [1.0, 2.0]}, dims=dims, store=tmp_path / "s", resume=True)
    assert again.identical(found)


@pytest.mark.parametrize(
    ("over", "words"),
    [
        ({}, "no point"),
        ({"a": []}, "no point"),
        ([], "no point"),
        ({"a": 3.0}, "list of values"),
        (3.0, "dictionaries"),
        ([3.0], "design 0"),
        ([{"a": 1}, {"b": 1}], "design 1 has b"),
        ({"ok": [1]}, "cannot be a parameter"),
        ({"a b": [1]}, "cannot be a parameter"),
        ({"c": [1]}, "varied and fixed"),
    ],
)
def test_points_that_make_no_sense_are_refused(over, words):
    with pytest.raises(fm.errors.InputError, match=words):
        fm.sweep(total, over, fixed={"c": 1.0})


def test_progress_tells_the_time_left_and_failures(capfd):
    fm.sweep(results, {"a": [2, 1], "b": [5.0]}, progress=True)
    shown = capfd.readouterr().err
    assert "2 of 2 points" in shown
    assert "1 failed" in shown


def test_a_dimension_may_be_called_design():
    found = fm.sweep(lambda design: design, {"design": [1.0, 2.0]})
    assert found["value"].values.tolist() == [1.0, 2.0]
    with pytest.raises(fm.errors.InputError, match="design"):
        fm.sweep(lambda design: design, [{"design": 1.0}])


def test_the_picture(tmp_path):
    found = quiet(logistic_map, "r", np.linspace(2.9, 3.5, 61), direction="both", chunks=2, keep=20)
    assert not found["ok"].values.all()
    figure = fm.plots.plot_bifurcation(found, "x0")
    (ax,) = figure.axes
    assert ax.get_xlabel() == "r [1/s]"
    assert ax.get_ylabel() == "x0"
    shown = [text.get_text() for text in ax.get_legend().get_texts()]
    assert {"periodic-1", "periodic-2", "up", "down", "failed", "seam"} <= set(shown)
    assert {line.get_marker() for line in ax.lines} >= {"^", "v", "x"}
    count = sum(len(line.get_xdata()) for line in ax.lines if line.get_marker() in "^v")
    assert count == 20 * int(found["ok"].sum())
    figure.savefig(tmp_path / "d.png")
    with pytest.raises(fm.errors.InputError, match="'y0'"):
        fm.plots.plot_bifurcation(found, "y0")
    with pytest.raises(fm.errors.InputError, match="kind"):
        fm.plots.plot_bifurcation(fm.sweep(total, {"a": [1.0]}, fixed={"b": 1.0, "c": 1.0}), "value")


def test_an_equation_with_impacts_brings_its_period():
    """u'' + u = cos(w t), a wall at 0: points of the diagram are those of the section with the same w."""
    ode = fm.chaos.ODE(
        lambda t, x, w: [x[1], np.cos(w * t) - x[0]],
        [-1.0, 0.0],
        parameters={"w": 2.8},
        period=lambda w: 2.0 * np.pi / w,
        name="impacts",
    )
    system = fm.chaos.ImpactODE(ode, gap=lambda t, x, w: -x[0], jump=lambda t, x, w: [x[0], -0.8 * x[1]])
    found = fm.bifurcation(system, "w", [2.8, 3.0], skip=2, keep=3)
    assert found["ok"].values.all()
    assert found["drive_period"].values == pytest.approx(2.0 * np.pi / np.array([2.8, 3.0]))
    system.reset(parameters={"w": 3.0})
    assert found["x0"].values[1] == pytest.approx(fm.stroboscopic(system, skip=2, keep=3)["x0"].values, abs=1e-9)


@numba.njit
def stiffening(t, x, om):
    return x[1], -0.1 * x[1] - x[0] - 0.3 * x[0] ** 3 + 0.4 * np.cos(om * t)


def test_a_section_is_carried_at_the_phase_of_the_drive():
    """Largest deflections of Duffing's oscillator on its upper branch, up from 0.9 rad/s.

    As `solve_ivp` of scipy has them with the phase kept from each frequency to the next; the fold lies at 1.574 rad/s.
    """

    def section(om):
        about = {"parameters": {"om": om}, "names": ["x", "v"], "period": 2.0 * np.pi / om}
        return fm.chaos.SectionMap(fm.chaos.ODE(stiffening, [0.0, 0.0], **about), "v", direction="down")

    found = fm.bifurcation(section, "om", np.linspace(0.9, 1.5, 7), skip=60, keep=2, direction="up")
    assert found["ok"].all()
    assert not found["seam"].any()
    assert found["x"].values[:, -1] == pytest.approx([0.980, 1.204, 1.453, 1.711, 1.967, 2.217, 2.455], abs=2e-3)


@pytest.mark.parametrize(("ramp", "seams"), [(0.0, [False, False]), (0.02, [False, True])])
def test_a_ramp_of_another_angle_is_a_cold_start(ramp, seams):
    """The drive would turn the crank alone, by half of the ramp times the step of the speed: 12 clearances away."""
    ready = fm.mechanisms.slider_crank(150.0, clearance=2e-4)

    def at(speed):
        motion = fm.drives.Ramp(speed, time=ramp) if ramp else fm.ConstantSpeed(speed)
        return ready.with_part(fm.Drive("motor", joint="O", motion=motion))

    about = {"skip": 3, "keep": 1, "period": lambda speed: 2.0 * np.pi / speed, "signals": ["crank.theta"]}
    found = fm.bifurcation(at, "speed", [150.0, 155.0], direction="up", **about)
    assert found["ok"].all(), found["status"].values
    assert found["seam"].values.tolist() == seams
    cold = fm.bifurcation(at, "speed", [150.0, 155.0], **about)
    turns = (found["crank.theta"].values - cold["crank.theta"].values) / (2.0 * np.pi)
    assert turns == pytest.approx(np.round(turns), abs=1e-9)


def test_a_state_that_a_drive_would_turn_away_from_its_bearing_is_refused():
    """At 1 ms the drive has turned the crank by 0.15 rad, and the rod stays: its journal would be 7 mm away."""
    flow = MechanismFlow(fm.mechanisms.slider_crank(150.0, clearance=2e-4))
    state = flow.state()
    with pytest.raises(AssemblyError, match=r"at t = 0\.001 s move .* more than the clearance of 0\.0002 m"):
        flow.reset(state, time=1e-3)
    assert not flow.ok
    assert not flow.advance(1e-3)
    flow.reset(state, time=2.0 * np.pi / 150.0)
    assert flow.advance(1e-3)
