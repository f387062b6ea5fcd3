"""`flexmb chaos`: what is found, printed and written for motions whose kind is known; what is refused."""

import math

import numpy as np
import pytest
import xarray as xr

import flexmb as fm
from flexmb.cli.command_line import main
from flexmb.dynamics.report import Motion, goes_round, planes, wrapped
from flexmb.dynamics.verdict import meaning_of
from flexmb.show.pictures.diagrams import _widened

MODEL = """
import math
from typing import Annotated
import flexmb as fm

DAMPING = 0.5

def pendulum(push: float = 0.9, burst: Annotated[float, "s"] = 0.0):
    '''x'' + x'/2 + sin x = push cos(2 t / 3): the pendulum of G. L. Baker and J. P. Gollub, Chaotic Dynamics (1990).

    Parameters
    ----------
    push : amplitude.
    burst : when a force of 1e200 N sets in, if it is > 0.
    '''
    rod = fm.RigidLink("rod", (0.0, 0.0), (0.0, -2.0), mass=1.0, inertia=1.0 / 3.0)
    J = 4.0 / 3.0
    clock = fm.drives.Harmonic(1.0, frequency=1.0 / (3.0 * math.pi), phase=math.pi / 2)
    parts = [
        rod,
        fm.Revolute("O", fm.GROUND, rod, at=(0.0, 0.0)),
        fm.TorsionSpring("damper", fm.GROUND, rod, stiffness=0.0, damping=DAMPING * J, at=(0.0, 0.0)),
        fm.Torque("push", rod, torque=push * J, history=clock),
    ]
    if burst > 0.0:
        history = fm.drives.Pulse(start=burst)
        parts.append(fm.Force("burst", rod, at=(0.0, -2.0), force=(1e200, 0.0), history=history))
    return fm.Mechanism("pendulum", parts, gravity=(0.0, -J))

mech = pendulum()
still = fm.Mechanism("still", pendulum().parts[:2], gravity=(0.0, -1.0))
"""
PERIOD = 3.0 * math.pi
COMMON = ["--period", repr(PERIOD), "--step", repr(PERIOD / 400)]


@pytest.fixture
def model(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "model.py").write_text(MODEL)
    return "model.py:pendulum"


def read(path, group=None):
    with xr.open_dataset(path, group=group, engine="h5netcdf") as found:
        return found.load()


def refused(arguments, capsys):
    assert main([str(a) for a in arguments]) == 2
    err = capsys.readouterr().err
    assert err.startswith("flexmb: ")
    assert "Traceback" not in err
    return err


def test_a_periodic_motion(model, capsys):
    arguments = ["chaos", model, *COMMON, "--skip", "60", "--keep", "60", "--exponents", "2", "--series", "20"]
    assert main([*arguments, "--samples", "200", "--out", "out"]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("pendulum: periodic-1\n")
    assert "periods" in err  # the bar
    found = read("out/chaos.nc")
    assert (found.attrs["verdict"], found.attrs["ok"]) == ("periodic-1", 1)
    assert found["exponent"].values.sum() == pytest.approx(-0.5, rel=1e-3)  # what damping takes of any volume
    assert found["period"].values.tolist() == list(range(61, 121))
    np.testing.assert_allclose(found["time"].values, PERIOD * found["period"].values)
    motion, spectrum = read("out/chaos.nc", "motion"), read("out/chaos.nc", "spectrum")
    assert motion.sizes["time"] == 20 * 200 + 1
    assert motion["time"].values[0] == pytest.approx(120 * PERIOD)
    # the fine samples are the same motion, which is where it was once a period
    np.testing.assert_allclose(motion["rod.theta"].values[::200], found["rod.theta"].values[-1], atol=1e-4)
    assert spectrum["line"].values[0, 0] == pytest.approx(1.0 / PERIOD, rel=1e-3)
    pictures = {line.strip() for line in out.splitlines() if line.strip().endswith(".png")}
    names = ("section-rod.theta-rod.omega", "phase-rod.theta-rod.omega", "exponents", "spectrum-rod.theta")
    assert pictures == {f"out/{name}.png" for name in names}


@pytest.mark.slow
def test_a_chaotic_motion(model, capsys):
    arguments = ["chaos", model, *COMMON, "--push", "1.5", "--keep", "300", "--exponents", "2", "--series", "150"]
    assert main([*arguments, "--samples", "100", "--dimension", "--recurrence", "--no-plots", "--quiet"]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("pendulum: chaotic")
    assert err == ""
    found, series = read("out/model-pendulum/chaos.nc"), read("out/model-pendulum/chaos.nc", "series")
    assert found.attrs["verdict"] == "chaotic"
    value, error = (float(found[name].values[0]) for name in ("exponent", "exponent_error"))
    assert value > 5 * error > 0
    assert found["exponent"].values.sum() == pytest.approx(-0.5, rel=1e-3)
    assert 1.0 < found.attrs["lyapunov_dimension"] < 2.0
    assert series["signal"].values.tolist() == ["sin(rod.theta)"]  # the rod goes over the top
    assert float(series["zero_one"][0]) > 0.9
    assert float(series["rosenstein"][0]) == pytest.approx(value, abs=float(series["rosenstein_error"][0]) + 2 * error)
    assert float(series["recurrence_rate"][0]) == pytest.approx(0.05, rel=0.2)
    assert str(series["spectrum_kind"].values[0]) == "broad"


@pytest.mark.slow
def test_too_few_points_are_inconclusive_and_say_so(model, capsys, monkeypatch):
    """An exponent within three times its error asks for 100 points."""
    monkeypatch.setattr("flexmb.dynamics.verdict.CLEARLY", 100.0)
    assert main(["chaos", model, *COMMON, "--push", "1.5", "--keep", "60", "--series", "0", "--no-plots"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("pendulum: inconclusive\n")
    assert "100 are needed; there are 60" in out
    assert "Give a larger --keep" in out  # the 0-1 test


@pytest.mark.slow
def test_a_second_run_is_told_unless_it_is_not_wanted(model, capsys):
    """Each exponent with its error, that of the run alone and what the second run found."""
    arguments = ["chaos", model, *COMMON, "--push", "1.5", "--keep", "100", "--series", "0", "--no-plots"]
    assert main([*arguments, "--out", "both"]) == 0
    out, found = capsys.readouterr().out, read("both/chaos.nc")
    steps = f"steps of {PERIOD / 800:g} s"
    assert out.count("  this run alone") == out.count("  second run") == 1
    assert f"{steps}, another start, 20 periods" in out
    assert steps in found.attrs["second_run"]
    own, error = (float(found[name][0]) for name in ("exponent_statistical", "exponent_error"))
    apart = abs(float(found["exponent"][0]) - float(found["exponent_second"][0]))
    both = math.hypot(own, float(found["exponent_second_error"][0]))
    assert error == pytest.approx(math.hypot(own, apart if apart > 2.0 * both else 0.0))
    assert main([*arguments, "--out", "one", "--no-confirm"]) == 0
    out, found = capsys.readouterr().out, read("one/chaos.nc")
    assert "second run" not in out
    assert "exponent_second" not in found
    assert found["exponent_error"].values.tolist() == found["exponent_statistical"].values.tolist() == [own]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("burst", "points"),
    [pytest.param("1", 0, marks=pytest.mark.slow), ("200", 21), pytest.param("500", 50, marks=pytest.mark.slow)],
)
def test_a_run_that_fails(model, capsys, burst, points):
    """At once, among the points, and in the fine samples that follow; what was found until then is written."""
    arguments = ["chaos", model, "--burst", burst, *COMMON, "--skip", "0", "--keep", "50", "--series", "20"]
    assert main([*arguments, "--samples", "100", "--out", "out"]) == 1
    out, err = capsys.readouterr()
    found = read("out/chaos.nc")
    assert found.attrs["ok"] == 0
    assert f"Stopped at t = {burst}" in found.attrs["status"]
    assert err.splitlines()[-1] == f"flexmb: {found.attrs['status']}"
    assert found.sizes["period"] == points
    assert ("no verdict" in out.splitlines()[0]) == (points < 50)
    if points == 50:
        times = read("out/chaos.nc", "motion")["time"].values
        assert 50 * PERIOD <= times[0] < times[-1] < 501.0


@pytest.mark.slow
def test_journal_of_a_joint_with_play(tmp_path, capsys):
    arguments = ["chaos", "slider-crank", "--clearance", "0.1mm", "--skip", "2", "--keep", "50", "--series", "20"]
    assert main([*arguments, "--samples", "100", "--out", str(tmp_path), "--quiet"]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {
        "chaos.nc",
        "exponents.png",
        "chaos.html",
        "section-B.ex-B.ey.png",
        "phase-B.ex-B.ey.png",
        "spectrum-B.ex.png",
        "spectrum-B.ey.png",
    }


@pytest.mark.slow
def test_signals_of_ones_choice(model):
    arguments = [
        "chaos",
        model,
        *COMMON,
        "--signals",
        "rod.omega,O.fx",
        "--skip",
        "5",
        "--keep",
        "50",
        "--series",
        "20",
    ]
    assert main([*arguments, "--samples", "100", "--quiet", "--out", "out"]) == 0
    assert read("out/chaos.nc", "series")["signal"].values.tolist() == ["rod.omega", "O.fx"]
    assert sorted(read("out/chaos.nc", "motion")) == ["O.fx", "rod.omega", "rod.theta"]


def test_a_cycle_is_drawn_as_points_not_as_round_off():
    angles = np.linspace(0.0, 2.0 * np.pi, 101)
    fine = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    cycle = np.array([[1.0, 0.0]] * 50) + 1e-12 * np.random.default_rng(0).standard_normal((50, 2))
    motion = Motion(("a.x", "a.vx"), ("m", "m/s"), cycle, 1.0, angles, fine)
    data = xr.Dataset({"a.x": ("period", cycle[:, 0]), "a.vx": ("period", cycle[:, 1])})
    figure = fm.plots.plot_section(data, "a.x", "a.vx")
    _widened(figure, motion, "a.x", "a.vx")
    assert figure.axes[0].get_xlim() == pytest.approx((0.8, 1.2))
    assert figure.axes[0].get_ylim() == pytest.approx((-0.2, 0.2))


def test_what_is_drawn_over_what():
    known = ["a.x", "a.vx", "a.theta", "a.omega", "P.ex", "P.ey", "O.fx"]
    assert planes(["P.ey", "P.ex", "a.vx", "O.fx"], known) == [("P.ex", "P.ey"), ("a.x", "a.vx"), ("O.fx", None)]


def test_angles_that_go_round_are_drawn_on_one_turn():
    angles = np.linspace(0.0, 20.0, 50)
    assert goes_round("rad", angles)
    assert not goes_round("m", angles)
    assert not goes_round("rad", 0.1 * angles)
    assert np.abs(wrapped("rad", angles)).max() <= np.pi
    np.testing.assert_allclose(np.cos(wrapped("rad", angles)), np.cos(angles), atol=1e-12)


@pytest.mark.parametrize(
    ("value", "error", "words"),
    [
        (2.0, 0.1, "part by a factor e in 0.5 s (0.25 periods)"),
        (-2.0, 0.1, "come nearer by a factor e in 0.5 s"),
        (0.1, 0.2, "zero within its error"),
        (1.0, math.nan, "take more periods"),
        (math.nan, math.nan, "none was found"),
    ],
)
def test_meaning_of_an_exponent(value, error, words):
    assert words in meaning_of(value, error, 2.0)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["model.py"], "--period"),
        (["model.py:still"], "no periodic drive"),
        (["model.py:pendulum", "--period", "1m"], "a time"),
        (["model.py:pendulum", *COMMON, "--keep", "49"], "too few for exponents"),
        (["model.py:pendulum", *COMMON, "--keep", "50", "--exponents", "3"], "--exponents is 3; 'pendulum' has 2"),
        (["slider-crank"], "prescribe the whole motion"),
        (["model.py:pendulum", *COMMON, "--series", "19"], "need 20 periods"),
        (["model.py:pendulum", *COMMON, "--samples", "10"], "--samples is 10"),
        (["model.py:pendulum", *COMMON, "--series", "0", "--dimension"], "--dimension needs"),
        (["model.py:pendulum", *COMMON, "--signals", "rod.thta"], "Did you mean 'rod.theta'"),
        (["model.py:pendulum", *COMMON, "--method", "runge-kutta"], "Newmark"),
        (["model.py:pendulum", *COMMON, "--skip", "-1"], "skip"),
        (["model.py:nothing"], "nothing"),
    ],
)
def test_what_is_refused(model, arguments, words, capsys):
    assert words in refused(["chaos", *arguments, "--quiet"], capsys)


def test_a_parameter_may_bear_the_name_of_an_option_of_another_command(tmp_path, capsys):
    text = "def make(samples: int = 1) -> fm.Mechanism:\n    return fm.Mechanism('one', [fm.GROUND])\n"
    (tmp_path / "named.py").write_text(f"import flexmb as fm\n\n{text}")
    assert "--samples" in refused(["chaos", f"{tmp_path / 'named.py'}:make"], capsys)
    with pytest.raises(SystemExit) as stop:
        main(["run", f"{tmp_path / 'named.py'}:make", "--help"])
    assert stop.value.code == 0


def test_spectrum_pictures():
    t = 0.01 * np.arange(4000)
    found = fm.chaos.power_spectrum(np.sin(2.0 * np.pi * 5.0 * t), 0.01)
    ax = fm.plots.plot_spectrum(found, signal="a.x", units="m", up_to=20.0).axes[0]
    assert ax.get_ylabel() == "power density [m²/Hz]"
    assert ax.get_xlim()[1] == pytest.approx(20.0, rel=1e-3)
    assert ax.lines[2].get_xdata() == pytest.approx([5.0], abs=0.03)
    with pytest.raises(fm.errors.InputError, match="no frequencies"):
        fm.plots.plot_spectrum(found, up_to=0.0)
    with pytest.raises(fm.errors.InputError, match="power_spectrum"):
        fm.plots.plot_spectrum(t)
