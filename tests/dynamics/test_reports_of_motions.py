"""`fm.chaos.report`: what `flexmb chaos` finds and writes, as a call of a script."""

import numpy as np
import pytest
import xarray as xr

import flexmb as fm
from flexmb.cli.command_line import main

QUICK = {"skip": 20, "keep": 50, "series": 20, "samples": 50, "confirm": False}


def pendulum():
    """x'' + x'/2 + sin x = 0.9 cos(2 t / 3): a cycle (G. L. Baker and J. P. Gollub, Chaotic Dynamics, 1990)."""
    return fm.chaos.ODE(
        lambda t, x: np.array([x[1], 0.9 * np.cos(2.0 * t / 3.0) - 0.5 * x[1] - np.sin(x[0])]),
        [0.0, 0.0],
        jacobian=lambda t, x: np.array([[0.0, 1.0], [-np.cos(x[0]), -0.5]]),
        names=["theta", "omega"],
        units=["rad", "rad/s"],
        period=3.0 * np.pi,
        name="pendulum",
        rtol=1e-8,
    )


@pytest.fixture(scope="module")
def found():
    return fm.chaos.report(pendulum(), **QUICK, exponents=2, recurrence=True)


def test_a_cycle_of_a_differential_equation(found):
    assert found.ok
    assert found.exponents.verdict.kind == "periodic"
    assert found.exponents.sum == pytest.approx(-0.5, rel=1e-6)  # the damping
    assert found.motion.times[0] == pytest.approx(70 * found.period)
    assert len(found.motion.times) == 20 * 50 + 1
    (signal,) = found.signals
    assert signal.spectrum.peaks[0] == pytest.approx(1.0 / found.period, rel=1e-3)
    assert signal.recurrence.longest_diagonal == 19 * 50 + 1  # the record but for one period
    assert signal.dimension is None


@pytest.mark.slow
def test_a_report_shows_itself_and_advises_in_words_of_python(found):
    lines = repr(found).splitlines()
    assert lines[0] == f"{found.exponents.name}: periodic-1"
    assert "  50 periods of 9.42478 s, after 20 skipped ones." in lines[2]
    assert any(line.startswith("  largest exponent ") for line in lines)
    too_short = fm.chaos.report(pendulum(), **{**QUICK, "series": 0}, signals=["omega"])
    assert "Give a larger keep." in repr(too_short)
    assert "Give a larger --keep." in too_short.text("--")


@pytest.mark.slow
def test_datasets_tree_and_file_agree(found, tmp_path):
    path = found.to_netcdf(tmp_path / "new" / "chaos.nc")
    assert set(found.groups) == {"", "motion", "series", "spectrum"}
    assert set(found.tree.children) == {"motion", "series", "spectrum"}
    for name, dataset in found.groups.items():
        with xr.open_dataset(path, group=name or None, engine="h5netcdf") as read:
            xr.testing.assert_equal(read.load(), dataset)
    assert found.tree["motion"].sizes["time"] == len(found.motion.times)
    assert fm.report(found, tmp_path / "chaos.html").stat().st_size > 10_000


def test_pictures_have_the_names_of_their_files(found):
    of_signals = {"section-theta-omega.png", "phase-theta-omega.png", "spectrum-theta.png"}
    assert set(fm.plots.plot_report(found)) == {*of_signals, "exponents.png"}
    with pytest.raises(fm.errors.InputError, match=r"chaos\.report"):
        fm.plots.plot_report(found.exponents)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"series": 19}, "chaos.report '.*': series is 19; estimates from signals need 20 periods"),
        ({"samples": 10}, "samples is 10"),
        ({"series": 0, "dimension": True}, "dimension needs the motion between the points. Give series=20"),
        ({"exponents": 3}, "exponents is 3; '.*' has 2"),
        ({"signals": ["nothing"]}, "nothing"),
        ({"step": 0.1}, "belong to a mechanism"),
    ],
)
def test_what_is_refused(arguments, words):
    with pytest.raises(fm.errors.InputError, match=words):
        fm.chaos.report(pendulum(), **{**QUICK, **arguments})


def test_a_map_has_no_motion_between_its_points():
    with pytest.raises(fm.errors.InputError, match="flow in time"):
        fm.chaos.report(fm.chaos.Map(lambda x: 0.5 * x, [1.0]))


@pytest.mark.slow
def test_a_slider_crank_with_clearance_is_the_same_from_script_and_command(tmp_path, capsys):
    """File to the last byte, table, names of the pictures."""
    typed = ["--clearance", "0.1mm", "--skip", "2", "--keep", "50", "--series", "20", "--samples", "50", "--quiet"]
    assert main(["chaos", "slider-crank", *typed, "--no-confirm", "--out", str(tmp_path)]) == 0
    mech = fm.mechanisms.slider_crank(clearance=1e-4)
    found = fm.chaos.report(mech, skip=2, keep=50, series=20, samples=50, confirm=False)
    assert found.to_netcdf(tmp_path / "own.nc").read_bytes() == (tmp_path / "chaos.nc").read_bytes()
    assert capsys.readouterr().out.startswith(found.text("--"))
    assert [signal.name for signal in found.signals] == ["B.ex", "B.ey"]
    assert set(fm.plots.plot_report(found)) == {path.name for path in tmp_path.glob("*.png")}


@pytest.mark.slow
def test_times_of_a_flow_that_goes_on():
    """The last point is the first fine sample, and both have the time of the flow."""
    flow = pendulum()
    flow.advance(5.0)
    groups = fm.chaos.report(flow, **QUICK).groups
    points, motion = groups[""], groups["motion"]
    assert float(points.time[-1]) == pytest.approx(5.0 + 70 * 3.0 * np.pi)
    assert float(motion.time[0]) == pytest.approx(float(points.time[-1]))
    assert float(motion.theta[0]) == pytest.approx(float(points.theta[-1]))
