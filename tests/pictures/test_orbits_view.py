"""Figures of branches, basins, phase portraits, sections and exponents: what is drawn, labels, bad input."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from flexmb.dynamics.basins import basin
from flexmb.dynamics.exponents import Exponents
from flexmb.dynamics.orbits.continuation import follow
from flexmb.dynamics.orbits.periodic_orbit import periodic_orbit
from flexmb.dynamics.sections import SectionSignals
from flexmb.dynamics.systems.given import Map
from flexmb.errors import InputError
from flexmb.show.pictures.diagrams import (
    plot_basin,
    plot_bifurcation,
    plot_branch,
    plot_exponents,
    plot_phase,
    plot_section,
)


@pytest.fixture(scope="module")
def branch():
    logistic = Map(lambda x, r: r * x * (1 - x), [0.6], parameters={"r": 2.5}, name="logistic")
    return follow(periodic_orbit(logistic), "r", (2.5, 3.4), extremes=1)


def test_branch_is_solid_where_stable_and_marked_at_the_flip(branch):
    doubled = follow(branch.switch(), "r", (None, 3.4))
    (ax,) = plot_branch([branch, doubled], "x0").axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("r", "x0")
    legend = [text.get_text() for text in ax.get_legend().get_texts()]
    assert legend == ["stable", "flip (period doubling)", "unstable"] or set(legend) == {
        "stable",
        "unstable",
        "flip (period doubling)",
    }
    solid, dashed, mark, other = ax.lines
    assert (solid.get_linestyle(), dashed.get_linestyle(), other.get_linestyle()) == ("-", "--", "-")
    assert mark.get_xdata()[0] == pytest.approx(3.0, abs=1e-6)
    assert mark.get_ydata()[0] == pytest.approx(2 / 3, abs=1e-6)
    assert solid.get_xdata()[-1] == dashed.get_xdata()[0]  # nothing is left out between


def test_branch_of_other_values(branch):
    (ax,) = plot_branch(branch, "x0", value="amplitude", title="two").axes
    assert ax.get_ylabel() == "amplitude of x0"
    (ax,) = plot_branch(branch, "period").axes
    assert ax.get_ylabel() == "period [iterations]"


def test_basin_shows_numbers_shares_and_attractors():
    double = Map(lambda x: [x[0] - 0.2 * (x[0] ** 3 - x[0]), 0.5 * x[1]], [0.3, 0.3], names=("x", "y"), name="wells")
    found = basin(double, ("x", np.linspace(-1.4, 1.3, 10)), ("y", [-1.0, 0.0, 1.0]))
    figure = plot_basin(found)
    (ax,) = figure.axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x", "y")
    np.testing.assert_array_equal(ax.collections[0].get_array().reshape(found.number.shape), found.number)
    assert sorted(round(float(line.get_xdata()[0]), 3) for line in ax.lines) == [-1.0, 1.0]
    assert ax.get_xlim() == pytest.approx((-1.55, 1.45))
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["1 (period 1): 50.0 %", "2 (period 1): 50.0 %"]


def section(n=50):
    numbers = np.arange(n)
    values = {"P.ex": ("period", np.sin(numbers), {"units": "m"}), "P.ey": ("period", np.cos(numbers), {"units": "m"})}
    return xr.Dataset(values, {"period": numbers}, {"name": "nine-bar"})


def test_section_points():
    figure = plot_section(section(), "P.ex", "P.ey")
    (ax,) = figure.axes
    assert (ax.get_xlabel(), ax.get_ylabel(), figure.get_suptitle()) == ("P.ex [m]", "P.ey [m]", "nine-bar")
    np.testing.assert_allclose(ax.collections[0].get_offsets()[:, 0], np.sin(np.arange(50)))
    (ax,) = plot_section(section(), "P.ex").axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("period", "P.ex [m]")


def test_phase_portrait_of_a_dataset():
    t = np.linspace(0, 10, 101)
    values = {"x": ("time", np.sin(t), {"units": "m"}), "v": ("time", np.cos(t), {"units": "m/s"})}
    motion = xr.Dataset(values, {"time": t}, {"name": "swing"})
    (ax,) = plot_phase(motion, "x", "v", since=5.0).axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x [m]", "v [m/s]")
    assert len(ax.lines[0].get_xdata()) == 51
    with pytest.raises(InputError, match="after the end of the motion"):
        plot_phase(motion, "x", "v", since=11.0)


def exponents(n=400):
    t = np.arange(1, n + 1, dtype=float)
    history = np.array([0.9 + 3.0 * np.cos(t) / t, -14.6 - 5.0 / t]).T
    return Exponents(
        name="Lorenz",
        spectrum=np.array([0.9, -14.6]),
        errors=np.array([0.01, np.nan]),
        time=t,
        history=history,
        units="1/s",
        ok=True,
        status="Mean of 400 points.",
        points=np.zeros((0, 0)),
        signals=SectionSignals("pendulum", (), (), (), None),
    )


def test_a_direction_that_is_lost_at_once_is_drawn():
    lost = replace(exponents(), spectrum=np.array([0.9, -np.inf]))
    lost.history[:, 1] = -np.inf
    (ax,) = plot_exponents(lost).axes
    assert np.isfinite(ax.get_ylim()).all()


def test_exponents_converge_with_their_bands():
    (ax,) = plot_exponents(exponents()).axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time [s]", "exponent [1/s]")
    assert [t.get_text() for t in ax.get_legend().get_texts()] == ["0.9 ± 0.01 1/s", "-14.6 ± nan 1/s"]
    assert len(ax.patches) == 1  # a band where there is an error
    low, high = ax.get_ylim()
    assert low < -14.6 < 0.9 < high


@pytest.mark.parametrize(
    ("draw", "words"),
    [
        (lambda b: plot_branch(b, "x1"), "signal is 'x1'"),
        (lambda b: plot_branch(b, "x0", value="largest"), "value is 'largest'"),
        (lambda b: plot_branch([], "x0"), "one or several results of follow"),
        (plot_basin, "must be the result of basin"),
        (lambda b: plot_section(section().rename(period="n"), "P.ex"), "must have 'period' or 'crossing'"),
        (lambda b: plot_section(section(), "P.ez"), "signal is 'P.ez'"),
        (lambda b: plot_phase([1.0], "x", "v"), "must be a dataset"),
        (lambda b: plot_exponents(replace(exponents(), history=np.zeros((0, 1)))), "must hold exponents over"),
        (lambda b: plot_exponents(None), "must be the result of lyapunov"),
        (lambda b: plot_bifurcation(None, "x0"), "the result of fm.bifurcation"),
    ],
)
def test_what_is_refused(branch, draw, words):
    with pytest.raises(InputError, match=words):
        draw(branch)
