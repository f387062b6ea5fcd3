"""Pressure around bearings: it carries the force of the film, its peak is the signal, its picture shows it."""

import math
from dataclasses import replace

import numpy as np
import pytest

import flexmb as fm
from flexmb.mechanisms import slider_crank
from flexmb.parts.bearings.kernels import JOURNAL_FILM, PEAK_PRESSURE, SIDE_FLOW, film_signal
from flexmb.parts.wear.worn_bearing import WORN_FILM, worn_film_signal

C, R, WIDTH = 5e-5, 0.01, 0.012
DRY = slider_crank(speed=2.0 * math.pi * 1000 / 60, clearance=C)
OIL = {"viscosity": 0.02, "width": WIDTH}
WET = fm.JournalBearing(
    "B", DRY["rod"], DRY["slider"], at=(0.17, 0.0), clearance=C, bearing_radius=R, film=fm.ShortBearing(**OIL),
    roughness=1e-6, normal=DRY["B"].normal,
)  # fmt: skip
DIRECTIONS = 2.0 * math.pi * np.arange(7200) / 7200
RANDOM = np.random.default_rng(11)
WORN_BY = {"bearing": fm.Archard(bearing=1e-13, bins=720), "journal": fm.Archard(journal=1e-13, bins=720)}
WAVES = 1e-5 * (1.0 + np.cos(3.0 * 2.0 * math.pi * np.arange(720) / 720))


def states(n):
    """Coordinates and rates of both bodies, whose points are their centres."""
    for _ in range(n):
        q, v = RANDOM.normal(size=6), RANDOM.normal(size=6) * (1e-2, 1e-2, 10.0, 1e-2, 1e-2, 10.0)
        size, angle = RANDOM.uniform(0.02, 0.9) * C, RANDOM.uniform(-3.2, 3.2)
        q[3:5] = q[:2] + size * np.array([math.cos(angle), math.sin(angle)])
        yield q, v


def pressures(joint, q, v):
    return joint.pressures(DIRECTIONS, q[3:5] - q[:2], v[3:5] - v[:2], q[[2, 5]], v[[2, 5]])


def told(kernel, p, at, q, v):
    p = np.array(p if at else (*p, 0.0))
    p[at or -1] = PEAK_PRESSURE
    return kernel(p, 0.0, q, v, np.zeros(6))


def carried(pressure, share):
    """Force on the journal; `share`: mean over the width of the pressure in its middle."""
    of_axes = np.array([np.cos(DIRECTIONS), np.sin(DIRECTIONS)])
    return -of_axes @ pressure * share * WIDTH * R * 2.0 * math.pi / len(DIRECTIONS)


def force(kernel, p, q, v):
    r = np.zeros(6)
    kernel(np.array(p), 0.0, 0.0, q, v, np.zeros(6), np.zeros(0), r, np.zeros(0))
    return -r[3:5]


@pytest.mark.parametrize("cavitation", ["positive", "half", "none"])
@pytest.mark.parametrize(("film", "share"), [(fm.ShortBearing, 2.0 / 3.0), (fm.LongBearing, 1.0)])
def test_pressure_around_a_bearing_carries_the_force_of_its_film(film, share, cavitation):
    joint = replace(WET, film=film(**OIL, cavitation=cavitation))
    p = joint.numbers((0.0, 0.0), (0.0, 0.0))
    error = 5e-3 if cavitation == "half" else 1e-4  # of the sum over the directions: a half film ends with a jump
    for q, v in states(20):
        found, expected = pressures(joint, q, v), force(JOURNAL_FILM.force, p, q, v)
        assert carried(found, share) == pytest.approx(expected, abs=error * abs(expected).max())
        if cavitation == "positive":
            assert found.max() == pytest.approx(told(film_signal, p, 12, q, v), rel=1e-4)


@pytest.mark.parametrize("more", [{}, {"supply": "everywhere"}], ids=["widest", "everywhere"])
def test_pressure_of_a_finite_film_has_the_peak_of_its_table(more):
    joint = replace(WET, film=fm.FiniteBearing(**OIL, **more))
    p = joint.numbers((0.0, 0.0), (0.0, 0.0))
    for q, v in states(10):
        found = pressures(joint, q, v)
        assert found.min() >= 0.0
        assert found.max() == pytest.approx(told(film_signal, p, 12, q, v), rel=1e-2)


def test_grooves_part_the_pressure_where_they_are():
    joint = replace(WET, film=fm.FiniteBearing(**OIL, grooves=(0.5, 3.6), groove_width=0.4))
    for q, v in states(5):
        found = pressures(joint, q, v)
        for groove in (0.5, 3.6):
            inside = np.abs((DIRECTIONS - q[2] - groove + math.pi) % (2.0 * math.pi) - math.pi) < 0.19
            assert not found[inside].any()
        assert found.max() > 0.0


@pytest.mark.quick(1)
@pytest.mark.parametrize("surface", WORN_BY)
@pytest.mark.parametrize("depths", [np.zeros(720), WAVES], ids=["unworn", "waves"])
def test_pressure_of_a_worn_bearing_carries_the_force_of_its_film(surface, depths):
    joint = WET.worn_by(WORN_BY[surface]).with_depths(depths)
    p = joint.film_numbers((0.0, 0.0), (0.0, 0.0))
    for q, v in states(20):
        found, expected = pressures(joint, q, v), force(WORN_FILM.force, p, q, v)
        assert found.max() == pytest.approx(told(worn_film_signal, p, 0, q, v), rel=2e-3)
        assert carried(found, 2.0 / 3.0) == pytest.approx(expected, abs=5e-3 * abs(expected).max())
        if not depths.any():
            apart = np.abs(found - pressures(WET, q, v))
            assert apart.mean() < 1e-3 * found.max()  # between two angles of the profile it is a line


def test_picture_shows_the_largest_pressure_of_a_run(tmp_path):
    sol = fm.simulate(DRY.with_part(WET), periods=0.2, save=200)
    figure = fm.plots.plot_pressure(sol, "B")
    (curve, towards), k = figure.axes[0].lines, int(sol.array("B.pressure").argmax())
    assert 1e6 * curve.get_ydata().max() == pytest.approx(float(sol.array("B.pressure")[k]), rel=1e-3)
    assert towards.get_xdata()[0] == pytest.approx(math.atan2(sol.array("B.ey")[k], sol.array("B.ex")[k]))
    assert f"t = {sol.time[k]:.5g} s" in figure.get_suptitle()
    figure.savefig(tmp_path / "pressure.png")
    early = fm.plots.plot_pressure(sol, WET, at=float(sol.time[3]))
    assert f"t = {sol.time[3]:.5g} s" in early.get_suptitle()


@pytest.mark.parametrize(
    ("joint", "more", "words"),
    [("A", {}, "joint is 'A'"), (DRY["B"], {}, "joint with a film"), ("B", {"at": "soon"}, "at is 'soon'")],
)
def test_what_has_no_film_is_refused(joint, more, words):
    sol = fm.simulate(DRY.with_part(WET), periods=0.01)
    with pytest.raises(fm.errors.InputError, match=words):
        fm.plots.plot_pressure(sol, joint, **more)


@pytest.mark.parametrize("cavitation", ["positive", "half", "none"])
def test_oil_leaves_a_short_film_where_its_pressure_drives_it_out(cavitation):
    """Flow of both sides h^3/(12 mu) dp/dz, with the parabola 4 p/L of the pressure in the middle."""
    joint = replace(WET, film=fm.ShortBearing(**OIL, cavitation=cavitation))
    p = np.array([*joint.numbers((0.0, 0.0), (0.0, 0.0))])
    p[12] = SIDE_FLOW
    for q, v in states(20):
        e = q[3:5] - q[:2]
        h = C - e[0] * np.cos(DIRECTIONS) - e[1] * np.sin(DIRECTIONS)
        flow = (h**3 * np.maximum(pressures(joint, q, v), 0.0)).mean() * 2.0 * math.pi * R * 8.0 / (0.24 * WIDTH)
        assert film_signal(p, 0.0, q, v, np.zeros(6)) == pytest.approx(flow, rel=2e-3)
