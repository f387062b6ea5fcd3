"""Figures of the nonlinear part: their data is what their axes show."""

import numpy as np
import pytest
from cases import slow_where
from nine_bar_study.effort import FULL
from nine_bar_study.nine_bar.cases import MACHINE, PRINTED, case
from nine_bar_study.nine_bar.figures import figures
from nine_bar_study.nine_bar.pages import exponents
from study_runs import check_data

OBSERVED = MACHINE.places
SIGNALS = [name for seen in MACHINE.observables for name in (seen.place, seen.rate)]
PAGE = exponents.exponents(FULL)
FIRST = PAGE.runs[0]
NUMBERS = {17, 18, 19, 20, 21, 22, 24, 25, 26, 34, 35, 36, 37, 38, 39, 41, 42, 43}


def made(run, seed):
    """A result as of a run: a circle in each plane with a small random walk, which no run has computed."""
    import xarray

    draw, T = np.random.default_rng(seed), run.case.period
    periods, samples, pairs = 20, 100, 2
    noise = 1e-5 * draw.standard_normal(periods * samples + 1)
    angle = 2.0 * np.pi * np.arange(periods * samples + 1) / samples
    columns = {"time": ("time", angle * T / (2.0 * np.pi), {"units": "s"})}
    for k, name in enumerate(SIGNALS):
        columns[name] = ("time", 1e-4 * np.cos(angle + k) + noise, {})
        columns[f"step.{name}"] = ("step", 1e-4 * np.cos(angle[:400] + k), {})
        columns[f"section.{name}"] = ("point", 1e-5 * draw.standard_normal(60), {"resolution": 1e-9})
    columns["step.time"] = ("step", angle[:400])
    columns["history.time"] = ("history", T * np.arange(10.0, 60.0))
    columns["history.exponent"] = ("history", 3.0 + draw.standard_normal(50))
    lag = np.linspace(0.0, T, 11)
    columns |= {"lag": ("lag", lag), "pair.time": ("pair", 60.0 + T * np.arange(pairs))}
    columns |= {"exponent": ((), 3.0), "exponent_error": ((), 0.2)}
    for name in ("state", *OBSERVED):
        growth = 3.0 * (columns["pair.time"][1][:, None] - 60.0 + lag)
        columns |= {f"growth.{name}": (("pair", "lag"), growth), f"apart.{name}": (("pair", "lag"), np.exp(growth))}
    verdicts = {f"verdict.{name}": "chaotic" for name in OBSERVED}
    return xarray.Dataset(columns, attrs={"period": T, "verdict": "chaotic"} | verdicts)


@pytest.fixture(scope="module")
def results():
    return {run: made(run, k) for k, run in enumerate(PAGE.runs)}


FIGURES = {one.number: one for one in figures(FULL) if one.number in NUMBERS}


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    "plate",
    slow_where(lambda n: n.number not in (19, 25, 36, 42), FIGURES.values()),
    ids=lambda plate: str(plate.number),
)
def test_every_axis_has_a_label_with_a_unit_and_data(plate, results, tmp_path):
    figure, data = plate.draw(results)
    check_data(data, tmp_path / "figure.nc")
    for ax in figure.axes:
        assert "[" in ax.get_xlabel()
        assert "[" in ax.get_ylabel()
        assert ax.has_data()
    assert {name[0] for name in data.data_vars} == {"a", "b"}
    assert data.attrs["a.case"] == plate.runs[0].case.name


def test_phase_data_is_what_the_curve_shows(results):
    plate = FIGURES[17]
    figure, data = plate.draw(results)
    for ax, letter in zip(figure.axes, "ab", strict=True):
        curve = ax.lines[0]
        np.testing.assert_allclose(curve.get_xdata(), 1e6 * data[f"{letter}.P1.ex"].values)
        np.testing.assert_allclose(curve.get_ydata(), 1e3 * data[f"{letter}.P1.vex"].values)


def test_close_up_of_a_section_holds_all_points(results):
    plate = FIGURES[25]
    figure, data = plate.draw(results)
    whole, close = figure.axes[0], figure.axes[2]
    np.testing.assert_allclose(np.sort(whole.collections[0].get_offsets()[:, 0]), np.sort(1e3 * data["a.slider.x"]))
    offsets = close.collections[0].get_offsets()
    assert len(offsets) == 60
    assert (np.abs(offsets) <= np.abs([close.get_xlim()[1], close.get_ylim()[1]])).all()
    assert "60 points within" in close.get_title(loc="left")


def test_exponent_figure_shows_the_printed_value_and_the_band(results):
    plate = FIGURES[26]
    figure, data = plate.draw(results)
    assert float(data["a.printed"]) == -0.0221
    assert float(data["b.printed"]) == -0.0135
    dashed = [line for line in figure.axes[0].lines if line.get_linestyle() == "--"]
    assert [line.get_ydata()[0] for line in dashed] == [-0.0221]
    np.testing.assert_allclose(data["b.history.exponent"], results[plate.runs[1]]["history.exponent"])


def test_printed_values_are_the_papers():
    assert exponents.printed(FIRST, "P1.ex") == 0.0111
    assert np.isnan(exponents.printed(FULL.attractor(case("rigid", 1.0)), "P1.ex"))
    assert sum(value > 0.0 for case in PRINTED.values() for value in case.values()) == 6


@pytest.mark.slow
def test_page_holds_its_numbers_and_its_picture(results):
    text, data = PAGE.write(results)
    assert data["printed"].values[0].tolist() == [0.0111, 0.0656, -0.0221]
    np.testing.assert_allclose(data["growth"], 3.0, rtol=1e-9)
    for run in PAGE.runs:
        assert text.count(run.case.name) >= 4
    for heading in ("## The system", "## Observable by observable", "## Why the signs differ", "## Which unit?"):
        assert heading in text
    assert "(!)" not in text
    figure, shown = PAGE.draw(results)
    assert len(figure.axes) == 4
    assert all(ax.get_xlabel() and ax.get_ylabel() for ax in figure.axes)
    assert set(shown["followed"].values) == {0.1, 1.0}


@pytest.mark.parametrize(("later", "said"), [(3.0, ""), (3.6, ""), (4.0, "(!)")])
def test_page_says_where_two_exponents_differ(later, said):
    rates = {"state": (later, 0.1)} | dict.fromkeys(OBSERVED, (later, 0.1))
    nothing = {"estimates": {}, "zero_one": {}, "through": {}, "clouds": {}}
    case = exponents.Of(run=FIRST, exponent=3.0, error=0.2, verdict="chaotic", rates=rates, **nothing)
    text = exponents._systems([case])
    assert ("(!)" in text) == bool(said)
    assert ("not settled" in text) == bool(said)
