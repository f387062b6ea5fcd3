"""`flexmb sweep`: ranges with units, what is written, what is refused, with which exit code."""

import numpy as np
import pytest
import xarray as xr

import flexmb as fm
from flexmb.cli.arguments.parser import Option
from flexmb.cli.command_line import main
from flexmb.cli.studies import values_of

MODEL = """
from typing import Annotated
import flexmb as fm

def swing(speed: Annotated[float, "rad/s"] = 10.0, *, length: Annotated[float, "m"] = 1.0, bars: int = 1):
    '''A driven bar.

    Parameters
    ----------
    speed : of the motor.
    length : of the bar.
    bars : how many.
    '''
    if speed == 15.0:
        raise fm.errors.InputError("speed is 15; it must not be.")
    bar = fm.RigidLink("bar", (0.0, 0.0), (length, 0.0), mass=2.0, inertia=0.01)
    pin = fm.Revolute("O", fm.GROUND, bar, at=(0.0, 0.0))
    return fm.Mechanism("swing", [bar, pin, fm.Drive("motor", "O", fm.ConstantSpeed(speed))], gravity=(0.0, -9.81))

mech = swing()
"""
SHORT = ["--skip", "1", "--keep", "2", "--step", "10ms", "--quiet"]
SPEED = Option("speed", "number", 1.0, "rad/s", "")


@pytest.fixture
def model(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "model.py").write_text(MODEL)
    return "model.py:swing"


def refused(arguments, capsys):
    assert main([str(a) for a in arguments]) == 2
    err = capsys.readouterr().err
    assert err.startswith("flexmb: ")
    assert "Traceback" not in err
    return err


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("0.5pi:2.5pi:3", [0.5 * np.pi, 1.5 * np.pi, 2.5 * np.pi]),
        ("60rpm:120rpm:2", [2.0 * np.pi, 4.0 * np.pi]),
        ("-1:1:3", [-1.0, 0.0, 1.0]),
        ("3:3:1", [3.0]),
        ("1,2pi,4", [1.0, 2.0 * np.pi, 4.0]),
    ],
)
def test_ranges(text, values):
    np.testing.assert_allclose(values_of(text, SPEED), values, rtol=1e-15)


def test_ranges_of_whole_numbers():
    assert values_of("2:8:4", Option("elements", "count", 4, "", "")) == [2, 4, 6, 8]
    with pytest.raises(fm.errors.InputError, match="no whole number"):
        values_of("2:8:5", Option("elements", "count", 4, "", ""))


@pytest.mark.parametrize("text", ["1:2", "1:2:3:4", "1:2:0", "1:2:1.5", "1:2:x", "1mm:2mm:3", ":2:3"])
def test_ranges_that_are_none(text):
    with pytest.raises(fm.errors.InputError, match="speed"):
        values_of(text, SPEED)


@pytest.mark.slow
def test_dataset_and_picture(model, capsys):
    arguments = ["sweep", model, "--speed", "10:20:3", "--out", "results", "--length", "500mm", *SHORT[:-1]]
    assert main(arguments) == 1  # one point failed
    out, err = capsys.readouterr()
    assert "3 values of speed from 10 to 20 rad/s" in out
    assert "1 of 3 points failed; the first one: InputError: speed is 15" in err
    with xr.open_dataset("results/bifurcation.nc", engine="h5netcdf") as found:
        assert found["speed"].values.tolist() == [10.0, 15.0, 20.0]
        assert found["ok"].values.tolist() == [True, False, True]
    pictures = [line.strip() for line in out.splitlines() if line.strip().endswith(".png")]
    assert len(pictures) == 1
    assert "results/bifurcation.nc" in out


@pytest.mark.slow
def test_workers_write_the_same_store_and_it_is_gone_on_with(model, capsys):
    common = ["sweep", model, "--speed", "10:14:5", "--direction", "both", "--chunks", "2", "--no-plots", *SHORT]
    assert main([*common, "--store", "one.zarr"]) == 0
    assert main([*common, "--store", "two.zarr", "--workers", "2"]) == 0
    assert fm.sweeps.load_sweep("one.zarr").identical(fm.sweeps.load_sweep("two.zarr"))
    assert "--resume" in refused([*common, "--store", "one.zarr"], capsys)
    assert main([*common, "--store", "one.zarr", "--resume"]) == 0
    assert "written by another sweep" in refused([*common, "--store", "one.zarr", "--resume", "--length", "2m"], capsys)


def test_a_field_of_a_part(model, capsys):
    arguments = ["sweep", "model.py", "--vary", "bar.mass=100g:0.3kg:3", "--plot", "O.fy", *SHORT]
    assert main(arguments) == 0
    with xr.open_dataset("out/model/bifurcation.nc", engine="h5netcdf") as found:
        np.testing.assert_allclose(found["bar.mass"].values, [0.1, 0.2, 0.3], rtol=1e-15)
        force = found["O.fy"].values[:, 0]
    np.testing.assert_allclose(force[1:] / force[0], [2.0, 3.0], rtol=1e-9)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["model.py:swing"], "one parameter must have a range, found: none"),
        (["model.py:swing", "--speed", "1:2:3", "--length", "1:2:3"], "--speed, --length"),
        (["model.py:swing", "--speed", "1:2"], "no range"),
        (["model.py:swing", "--speed", "1:2:3", "--direction", "sideways"], "Known: cold, up, down, both"),
        (["model.py:swing", "--speed", "1:2:3", "--workers", "0"], "--workers"),
        (["model.py:swing", "--speed", "1:2:3", "--signals", "nothing.x"], "'nothing.x'"),
        (["model.py:swing", "--speed", "1:2:3", "--plot", "nothing.x", "--skip", "0", "--keep", "1"], "'nothing.x'"),
        (["model.py", "--vary", "bar.mass"], "PART.FIELD"),
        (["model.py", "--vary", "bar.weight=1:2:3"], "weight"),
        (["model.py", "--vary", "rod.mass=1:2:3"], "'rod'"),
        (["model.py", "--vary", "bar.mass=1m:2m:3"], "a length"),
        (["model.py:swing", "--speed", "1:2:3", "--method", "runge-kutta"], "Newmark"),
    ],
)
def test_what_is_refused(model, arguments, words, capsys):
    assert words in refused(["sweep", *arguments, "--quiet"], capsys)
