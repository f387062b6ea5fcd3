"""--set PART.FIELD=VALUE on all commands that begin with a mechanism."""

import json

import numpy as np
import pytest
import xarray as xr

import flexmb as fm
from flexmb.cli.arguments.source import changed
from flexmb.cli.command_line import main

WORN = fm.mechanisms.slider_crank(clearance=1e-4)
RUN = ["--t-end", "1ms", "--step", "20us", "--save", "20", "--no-vtk", "--no-plots", "--quiet"]


@pytest.mark.parametrize(
    ("text", "path", "value"),
    [
        ("slider.mass=200g", "slider.mass", 0.2),
        ("B.clearance=50um", "B.clearance", 5e-5),
        ("B.normal.restitution=0.5", "B.normal.restitution", 0.5),
        ("B.normal.reference_speed=largest", "B.normal.reference_speed", "largest"),
        ("motor.motion.speed=60rpm", "motor.motion.speed", 2.0 * np.pi),
        ("slider.velocity=(-1, 2, 30)", "slider.velocity", (-1.0, 2.0, 30.0)),
        ("slider.theta=30deg", "slider.theta", np.pi / 6.0),
    ],
)
def test_values_with_units(text, path, value):
    part, *fields = path.split(".")
    found = changed(WORN, [text])[part]
    for field in fields:
        found = getattr(found, field)
    assert found == pytest.approx(value) if not isinstance(value, str) else found == value


def test_gravity_and_several_changes_together():
    mech = changed(WORN, ["gravity=0,-1.62", "slider.mass=0.3", "slider.inertia=0.01"])
    assert mech.gravity == (0.0, -1.62)
    assert (mech["slider"].mass, mech["slider"].inertia) == (0.3, 0.01)


def test_nothing_set_is_nothing_changed():
    assert changed(WORN, []) is WORN


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("slidr.mass=1", "has no part 'slidr'. Did you mean 'slider'?"),
        ("slider.mas=1", "Did you mean 'mass'?"),
        ("slider.mass=3rpm", "--set slider.mass: '3rpm' is an angular speed; give a mass in kg"),
        ("slider.mass=heavy", "'heavy' is no number; give a mass in kg, e.g. --set slider.mass=200g."),
        ("B.bearing_radius=wide", "--set B.bearing_radius: 'wide' is no number; give a length in m"),
        ("A.clearance=1mm", "Revolute 'A' has no clearance. Give the mechanism a joint with clearance"),
        ("slider.mass=-1", "RigidBody 'slider': mass is -1 kg; it must be > 0"),
        ("slider.mass", "has no value; give PART.FIELD=VALUE"),
        ("slider=1", "'slider' names no field; give PART.FIELD"),
        ("B.first=rod", "'first' is RigidLink, which cannot be typed"),
        ("B.normal=hertz", "cannot be typed. Change it in a file of your own"),
        ("B.normal.restituton=0.5", "Did you mean 'restitution'?"),
        ("B.clearance.mass=1", "'clearance' has no fields of its own"),
        ("gravty=0,1", "'gravty' names no field"),
    ],
)
@pytest.mark.parametrize("command", ["check", "sweep"])
def test_refusals_name_part_and_field(capsys, command, text, message):
    more = ["--speed", "20:40:2", "--skip", "1", "--keep", "2", "--no-plots", "--quiet"] if command == "sweep" else []
    assert main([command, "slider-crank", "--clearance", "0.1mm", "--set", text, *more]) == 2
    err = capsys.readouterr().err
    assert message in err
    assert err.count("\n") == 1


def test_check_and_run_and_rerun_see_it(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["check", "slider-crank", "--set", "slider.mass=5", "--json"]) == 0
    whole = json.loads(capsys.readouterr().out)["mass"]
    light = sum(body.total_mass() for body in fm.mechanisms.slider_crank().bodies)
    assert whole - light == pytest.approx(5.0 - fm.mechanisms.slider_crank()["slider"].mass)
    assert main(["run", "slider-crank", "--set", "gravity=0,-500", *RUN]) == 0
    capsys.readouterr()
    assert main(["rerun", "out/slider-crank/slider-crank.nc", "--quiet"]) == 0
    assert capsys.readouterr().out == "The runs are equal to the last bit.\n"


def test_a_sweep_sees_it_at_every_value(tmp_path, monkeypatch):
    """The torque at the start of a crank without rod is that of gravity alone, so gravity shows."""
    monkeypatch.chdir(tmp_path)
    common = ["--skip", "1", "--keep", "2", "--step", "10ms", "--no-plots", "--quiet", "--signals", "motor.torque"]
    loads = {}
    for g in ("0", "50"):
        assert main(["sweep", "slider-crank", "--speed", "1,2", "--set", f"gravity=0,-{g}", *common]) == 0
        with xr.open_dataset("out/slider-crank/bifurcation.nc") as diagram:
            loads[g] = np.abs(diagram["motor.torque"].values).max(axis=-1).ravel()
    assert np.all(loads["50"] > 2.0 * loads["0"])
