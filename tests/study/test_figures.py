"""Figures of motions and diagrams: what the axes show is what the data holds, in the units that they name."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from cases import slow_where
from nine_bar_study.effort import Effort
from nine_bar_study.nine_bar.cases import QUANTITIES
from nine_bar_study.nine_bar.figures import figures
from study_runs import check_data

TINY = Effort("tiny", 3, 1, 1, 1, 50, 45, 2, 4, 3, exponents=False)
FACTORS = {"mm": 1e3, "µm": 1e6, "mm/s": 1e3, "m/s": 1.0, "m/s²": 1.0, "N": 1.0, "N m": 1.0}
FIGURES = {one.number: one for one in figures(TINY)}
MOTIONS = {number: FIGURES[number] for number in (*range(6, 17), *range(28, 34))}
DIAGRAMS = {number: FIGURES[number] for number in (23, 27, 40, 44)}


class Computed(dict):
    """Results, computed when they are asked for; instead of flexible motions rigid ones, which cost less."""

    def __missing__(self, run):
        if run.case.model == "flexible":
            return self[replace(run, case=replace(run.case, model="rigid"), name=run.name.replace("flexible", "rigid"))]
        self[run] = run.compute()
        return self[run]


@pytest.fixture(scope="module")
def results():
    return Computed()


def lines_of(figure):
    return [(ax, line) for ax in figure.axes for line in ax.lines if line.get_gid()]


def unit_of(label):
    return label.rpartition("[")[2].rstrip("]")


def axis_unit(ax, figure):
    """The unit of the vertical axis; panels of one row may share the label of the first."""
    row = [other for other in figure.axes if other.get_subplotspec().rowspan == ax.get_subplotspec().rowspan]
    return unit_of(ax.get_ylabel() or row[0].get_ylabel())


def is_labelled(ax):
    return "[" in ax.get_ylabel()


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    "number",
    slow_where(lambda n: n >= 28, [n for n in MOTIONS if n not in (16, 33)]),
)
def test_curves(number, results):
    figure, shown = MOTIONS[number].draw(results)
    drawn = lines_of(figure)
    assert len(drawn) >= 4
    for ax, line in drawn:
        name = line.get_gid()
        (dim,) = shown[name].dims
        np.testing.assert_array_equal(line.get_xdata(), shown[dim])
        np.testing.assert_allclose(line.get_ydata(), FACTORS[axis_unit(ax, figure)] * shown[name], rtol=1e-12)
    assert {line.get_gid() for _, line in drawn} == set(shown.data_vars)
    assert all(np.isfinite(values).all() for values in shown.data_vars.values())
    assert f"Figure {number}:" in figure.get_suptitle()


@pytest.mark.parametrize(("number", "signal"), [(11, "slider.ax"), (9, "slider.x.deviation")])
def test_curves_are_those_of_the_run(number, signal, results):
    _, shown = MOTIONS[number].draw(results)
    (run,) = [run for run in MOTIONS[number].runs if run.name == "rigid-2pi-0.5mm"]
    data = results[run]
    found = shown[f"b.rigid.{signal}"].values
    assert shown["b.rigid"].values[[0, -1]] == pytest.approx([0.0, run.case.period], abs=1e-3)
    np.testing.assert_allclose(shown["b.rigid"] + run["skip"] * run.case.period, data["time"], rtol=1e-12)
    if signal in data:
        np.testing.assert_array_equal(found, data[signal])
    else:  # the slider is off by about the play, not by what a shift of one step in time would make of its 80 mm
        assert 0.1e-3 < np.abs(found).max() < 1e-3
        late = (
            shown["b.rigid"] >= shown["b.ideal"][0]
        ).values  # a chord has nothing before the first step of the ideal one
        there = np.interp(shown["b.rigid"].values[late], shown["b.ideal"], shown["b.ideal.slider.x"])
        np.testing.assert_allclose(data["slider.x"].values[late] - there, found[late], atol=1e-6)  # 4 m/s² (1 ms)² / 8


@pytest.mark.parametrize(
    ("number", "signal"), [(9, "slider.x"), (11, "slider.ax"), (12, "motor1.torque"), (14, "P1.force")]
)
def test_units_are_those_of_the_run(number, signal, results):
    _, shown = MOTIONS[number].draw(results)
    (run,) = [run for run in MOTIONS[number].runs if run.name == "rigid-2pi-0.5mm"]
    assert shown[f"b.rigid.{signal}"].attrs["units"] == results[run][signal].attrs["units"]


def test_no_penetration_in_flight(results):
    _, shown = MOTIONS[15].draw(results)
    depth = shown["b.rigid.P1.penetration"].values
    assert depth.min() == 0.0
    assert depth.max() > 1e-6
    assert not any("ideal" in str(name) for name in shown.data_vars)


@pytest.mark.parametrize("number", [16, pytest.param(33, marks=pytest.mark.slow)])
def test_paths(number, results):
    figure, shown = MOTIONS[number].draw(results)
    drawn = {line.get_gid(): line for _, line in lines_of(figure)}
    for group in ("a.rigid", "a.flexible", "b.rigid", "b.flexible"):
        line, contact = drawn[f"{group}.P1.ex|{group}.P1.ey"], drawn[f"{group}.contact"]
        np.testing.assert_allclose(line.get_xdata(), 1e6 * shown[f"{group}.P1.ex"])
        np.testing.assert_allclose(line.get_ydata(), 1e6 * shown[f"{group}.P1.ey"])
        np.testing.assert_array_equal(np.isfinite(contact.get_xdata()), shown[f"{group}.contact"])
        radius = np.hypot(contact.get_xdata(), contact.get_ydata())
        clearance = 50.0 if (number, group[0]) == (16, "a") else 500.0
        assert np.nanmin(radius) >= clearance * (1.0 - 1e-9)
        assert np.nanmax(radius) < 1.2 * clearance


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    "plate",
    [pytest.param(plate, marks=pytest.mark.slow) if number >= 28 else plate for number, plate in MOTIONS.items()],
    ids=[f"figure {number}" for number in MOTIONS],
)
def test_axes_and_data_have_units(plate, results, tmp_path):
    figure, shown = plate.draw(results)
    check_data(shown, tmp_path / "figure.nc")
    for row in {ax.get_subplotspec().rowspan for ax in figure.axes}:
        axes = [ax for ax in figure.axes if ax.get_subplotspec().rowspan == row]
        assert is_labelled(axes[0])
    assert any("[" in ax.get_xlabel() for ax in figure.axes)
    assert figure.legends or any(ax.get_legend() for ax in figure.axes)


@pytest.mark.slow
@pytest.mark.parametrize("number", slow_where(lambda n: n in (23, 27, 40), DIAGRAMS))
def test_diagrams(number, results):
    figure, shown = DIAGRAMS[number].draw(results)
    drawn = lines_of(figure)
    parameter = "speed" if number in (40, 44) else "clearance"
    across = {"speed": 1.0 / np.pi, "clearance": 1e3}[parameter]
    points = {}
    for ax, line in drawn:
        name = line.get_gid().partition("|")[0]
        points.setdefault(name, []).append((ax, line.get_xdata(), line.get_ydata()))
    for name, pieces in points.items():
        model = name.partition(".")[0]
        values = np.repeat(across * shown[f"{model}.{parameter}"].values, shown.sizes["turn"])
        x = np.concatenate([x for _, x, _ in pieces])
        y = np.concatenate([y for _, _, y in pieces]) / FACTORS[unit_of(pieces[0][0].get_ylabel())]
        wanted = sorted(zip(values, shown[name].values.ravel(), strict=True))
        np.testing.assert_allclose(sorted(zip(x, y, strict=True)), wanted, rtol=1e-12)
    assert len(points) == 4


@pytest.mark.slow
def test_the_cloud_of_the_slider(results):
    """Its mean is taken away, and its own place is drawn on the scale of the stroke."""
    figure, shown = DIAGRAMS[44].draw(results)
    cloud, place = shown["rigid.slider.x.deviation"].values, shown["rigid.slider.x"].values
    np.testing.assert_allclose(np.ptp(cloud, axis=1), np.ptp(place, axis=1), atol=1e-12)
    np.testing.assert_allclose(cloud.mean(axis=1), 0.0, atol=1e-12)
    assert np.ptp(cloud[0]) < 1e-6  # no impacts at 0.5 pi rad/s
    assert np.ptp(figure.axes[0].get_ylim()) == pytest.approx(1.1 * 76.0, abs=1.0)  # stroke of the ideal slider [mm]


@pytest.mark.slow
def test_exponents_have_a_panel_of_their_own(results, tmp_path):
    plate = DIAGRAMS[40]
    with_exponents = {}
    for k, run in enumerate(plate.runs):
        found = results[run]
        value = np.array([-1.0, 20.0 + k])
        with_exponents[run] = found.assign(exponent=("speed", value), exponent_error=("speed", 0.1 * np.abs(value)))
    figure, shown = plate.draw(with_exponents)
    check_data(shown, tmp_path / "figure.nc")
    assert len(figure.axes) == 6
    np.testing.assert_array_equal(shown["rigid.exponent"], [-1.0, 21.0])
    x, y = figure.axes[4].containers[1].lines[0].get_data()
    np.testing.assert_allclose(x, shown["rigid.speed"] / np.pi)
    np.testing.assert_array_equal(y, shown["rigid.exponent"])


@pytest.mark.slow
def test_failed_values_are_marked_and_have_no_points(results):
    plate = DIAGRAMS[44]
    broken = {run: results[run].assign(ok=("speed", [True, False])) for run in plate.runs}
    figure, _ = plate.draw(broken)
    crosses = [line for line in figure.axes[0].lines if line.get_marker() == "x"]
    assert [line.get_xdata().tolist() for line in crosses] == [[pytest.approx(2.5)]]
    assert all(line.get_xdata().max() < 1.0 for _, line in lines_of(figure))


def test_every_signal_is_one_of_the_run(results):
    data = results[MOTIONS[15].runs[0]]
    assert isinstance(data, xr.Dataset)
    assert {name for name in QUANTITIES if name not in data} == set()
