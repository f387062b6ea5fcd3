"""The command line from argument to file: what it writes, what it refuses, with which exit code."""

import gc
import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from flexmb.cli import run as run_module
from flexmb.cli.arguments import parser as options
from flexmb.cli.arguments.source import ready
from flexmb.cli.command_line import main, with_negative_numbers
from flexmb.results.netcdf import load

SHORT = ["--t-end", "2ms", "--step", "20us", "--save", "20", "--quiet"]

MODEL = """
import math
from typing import Annotated
import flexmb as fm

O, A = (0.0, 0.0), (1.0, 0.0)

def swing(length: Annotated[float, "m"] = 1.0, *, gravity: Annotated[float, "m/s^2"] = 9.81, light: bool = False):
    '''A pendulum.

    Parameters
    ----------
    length : of the bar.
    gravity : downwards.
    light : whether it weighs little.
    '''
    bar = fm.RigidLink("bar", O, (length, 0.0), mass=0.1 if light else 2.0, inertia=0.01)
    return fm.Mechanism("swing", [bar, fm.Revolute("O", fm.GROUND, bar, at=O)], gravity=(0.0, -gravity))

def of_material(material):
    return mech

def nothing():
    return 3

mech = swing()
if __name__ == "__main__":
    raise SystemExit("a script's own run")
"""


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "model.py"
    path.write_text(MODEL)
    return path


def refused(arguments, capsys):
    """The one line on stderr of a command that is refused with exit code 2."""
    assert main([str(a) for a in arguments]) == 2
    out, err = capsys.readouterr()
    assert err.startswith("flexmb: ")
    assert err.count("\n") == 1
    assert "Traceback" not in err
    assert out == ""
    return err


def test_run_writes_everything_and_says_so(tmp_path, capsys):
    out = tmp_path / "deep" / "out"
    arguments = "run slider-crank --speed 600rpm --clearance 0.1mm --t-end 2ms --step 2us --save 20 --frames 5"
    assert main([*arguments.split(), "--out", str(out)]) == 0
    printed, progress = capsys.readouterr()
    sol = load(out / "slider-crank.nc")
    assert sol.ok
    assert len(sol.time) == 21
    assert sol.stats.steps == 1000
    # the crank turns at 600 rpm = 20 pi rad/s
    assert np.ptp(sol.array("crank.theta")) == pytest.approx(20 * np.pi * 2e-3, rel=1e-9)
    assert len(list((out / "slider-crank").glob("*.vtu"))) == 5
    for name in ("slider-crank.pvd", "slider-crank.nc", "signals.png", "mechanism.png"):
        assert str(out / name) in printed
        assert (out / name).stat().st_size > 0
    assert (out / "signals.png").read_bytes().startswith(b"\x89PNG")
    assert "Finished at t = 0.002 s" in printed
    assert f"{sol.peak('B.normal_force').value:.6g}" in printed
    assert "stroke of slider" in printed
    assert "s of motion" in progress
    assert "files are written to" in progress  # pictures and the page of a large run take seconds


def test_stroke_of_the_table_is_that_of_a_slider_crank(tmp_path, capsys):
    arguments = "run slider-crank --speed 2pi --periods 1 --step 1ms --no-vtk --no-plots --out"
    assert main([*arguments.split(), str(tmp_path)]) == 0
    line = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("stroke"))
    assert float(line.split()[-2]) == pytest.approx(0.1, rel=1e-5)  # twice the crank of 0.05 m


def test_the_picture_shows_four_poses_of_the_last_period(tmp_path):
    from flexmb.mechanisms import slider_crank

    arguments = "run slider-crank --speed 2pi --periods 3 --save 40 --step 1ms --quiet --no-vtk --no-plots --out"
    assert main([*arguments.split(), str(tmp_path)]) == 0
    instants = run_module.four_instants(slider_crank(2 * np.pi), load(tmp_path / "slider-crank.nc"))
    assert instants == pytest.approx([2.0, 2.25, 2.5, 2.75])


def test_quiet_keeps_the_summary(tmp_path, capsys):
    without = ["--no-vtk", "--no-plots", "--no-report"]
    assert main(["run", "slider-crank", *SHORT, *without, "--out", str(tmp_path)]) == 0
    out, err = capsys.readouterr()
    assert "Finished at t = 0.002 s." in out
    assert "motor.torque" in out
    assert err == ""
    assert [p.name for p in tmp_path.iterdir()] == ["slider-crank.nc"]


def test_options_reach_the_mechanism_and_the_solver(tmp_path):
    arguments = "run slider-crank --speed -2pi --flexible --elements 3 --periods 0.001 --step 0.1ms --method hht:0.05"
    assert main([*arguments.split(), "--quiet", "--no-vtk", "--no-plots", "--out", str(tmp_path)]) == 0
    sol = load(tmp_path / "slider-crank.nc")
    assert sol.array("motor.speed")[0] == pytest.approx(-2 * np.pi, rel=1e-12)
    assert "rod.node3.x" in sol
    assert "rod.node4.x" not in sol
    assert sol.time[-1] == pytest.approx(1e-3)
    assert "alpha_f=0.05" in sol.model["method"]
    assert "0.0001" in sol.model["step"]


def test_error_controlled_steps(tmp_path):
    arguments = "run slider-crank --speed 2pi --t-end 10ms --rtol 1e-5 --quiet --no-vtk --no-plots --out"
    assert main([*arguments.split(), str(tmp_path)]) == 0
    assert "rtol=1e-05" in load(tmp_path / "slider-crank.nc").model["step"]


@pytest.mark.parametrize("save", ["steps", pytest.param("20", marks=pytest.mark.slow)])
def test_a_run_goes_on(tmp_path, save):
    arguments = ["run", "slider-crank", "--step", "20us", "--quiet", "--no-vtk", "--no-plots", "--save", save]
    first, second = tmp_path / "first", tmp_path / "second"
    assert main([*arguments, "--t-end", "1ms", "--out", str(first)]) == 0
    more = ["--t-end", "2ms", "--restart", str(first / "slider-crank.nc"), "--out", str(second)]
    assert main([*arguments, *more]) == 0
    earlier, later = load(first / "slider-crank.nc").time, load(second / "slider-crank.nc").time
    assert later[-1] == 2e-3
    assert len(later) > 5
    # no instant is saved twice, and none is left out
    assert 0.0 < later[0] - earlier[-1] <= 1.001 * np.diff(later).max()


def test_save_from_period(tmp_path):
    arguments = "run slider-crank --periods 1 --save-from-period 0.5 --save 10 --step 0.1ms --quiet --no-vtk --no-plots"
    assert main([*arguments.split(), "--speed", "2pi", "--out", str(tmp_path)]) == 0
    sol = load(tmp_path / "slider-crank.nc")
    assert sol.time[0] == pytest.approx(0.5)
    assert sol.time[-1] == pytest.approx(1.0)


@pytest.mark.quick(1)
@pytest.mark.parametrize(("suffix", "name"), [("", "model"), (":mech", "model-mech"), (":swing", "model-swing")])
def test_a_mechanism_from_a_file(model, tmp_path, suffix, name):
    out = tmp_path / "out"
    assert main(["run", f"{model}{suffix}", *SHORT, "--no-vtk", "--no-plots", "--out", str(out)]) == 0
    sol = load(out / f"{name}.nc")
    # let go at rest and level, the bar turns with 3 g / (2 L) about its end; here J = m L^2 / 4 + 0.01
    assert sol.array("bar.alpha")[0] == pytest.approx(-2.0 * 9.81 * 0.5 / (2.0 * 0.25 + 0.01), rel=1e-9)


def test_parameters_of_a_function_in_a_file(model, tmp_path):
    out = tmp_path / "out"
    options = ["--length", "500mm", "--gravity", "1.62", "--light"]
    assert main(["run", f"{model}:swing", *options, *SHORT, "--no-vtk", "--no-plots", "--out", str(out)]) == 0
    alpha = load(out / "model-swing.nc").array("bar.alpha")[0]
    assert alpha == pytest.approx(-0.1 * 1.62 * 0.25 / (0.1 * 0.0625 + 0.01), rel=1e-9)


@pytest.mark.parametrize(
    ("what", "message"),
    [
        ("{model}:none", "no mechanism 'none'.*It has: .*swing.*mech"),
        ("{model}:nothing", "returned int; it must return a Mechanism"),
        ("{model}:of_material", "missing a required argument: 'material'.*Give its parameters defaults"),
        ("{folder}/absent.py", "absent.py: there is no such file"),
        ("{folder}/broken.py", "broken.py: not a Python file: .*line 1"),
        ("{folder}/empty.py", "empty.py: the file has no mechanism `mech`.*Write mech"),
        ("nine-bra", "'nine-bra' is no mechanism.*Did you mean 'nine-bar'"),
    ],
)
@pytest.mark.parametrize("command", ["run", "check"])
def test_sources_that_are_refused(model, tmp_path, capsys, what, message, command):
    (tmp_path / "broken.py").write_text("def (:\n")
    (tmp_path / "empty.py").write_text("x = 1\n")
    err = refused([command, what.format(model=model, folder=tmp_path)], capsys)
    assert re.search(message, err), err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("--clearance 0.5parsec", "'parsec' is no unit known here"),
        ("--clearance 3rpm", "--clearance: '3rpm' is an angular speed; give a length in m"),
        ("--clearance -1mm", "clearance is -0.001 m; it must be > 0"),
        ("--t-end 5mm", "--t-end: '5mm' is a length; give a time in s"),
        ("--t-end 0", "t_end is 0 s; it must be > 0"),
        ("--step -1us", "it must be > 0"),
        ("--rtol 1rpm", "--rtol: '1rpm' is an angular speed"),
        ("--method rk5", "--method: method is 'rk5'. Known: generalised-alpha"),
        ("--method trapezoidal:2", "'trapezoidal' takes no number"),
        ("--method hht:2", "alpha is 2; it must lie between 0 and 0.333333"),
        ("--method runge-kutta", "RungeKutta4 has no error estimate; give step=FixedStep"),
        ("--periods 1 --save-from-period 2", "Run longer or save earlier"),
        ("--save 0", "save is 0; it must be at least 1. An interval has a unit: 1ms"),
        ("--restart absent.nc", "'absent.nc': there is no such file"),
    ],
)
def test_values_that_are_refused(tmp_path, capsys, arguments, message):
    err = refused(["run", "slider-crank", *arguments.split(), "--out", tmp_path], capsys)
    assert message in err
    assert not list(tmp_path.glob("*.nc"))


def test_no_periodic_drive(model, tmp_path, capsys):
    assert "Say how long it shall run: --t-end" in refused(["run", model, "--out", tmp_path / "out"], capsys)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "say what to do.\nexamples:\n  flexmb new press"),
        (["walk"], "there is no command 'walk'. Known: new, list"),
        (["rn", "nine-bar"], "there is no command 'rn'. Did you mean 'run'?"),
        (["run"], "required: NAME"),
        (["run", "--quiet", "slider-crank"], "the mechanism comes first: flexmb run NAME"),
        (["run", "slider-crank", "--sped", "2"], "unrecognized arguments: --sped"),
        (["run", "slider-crank", "--step", "1us", "--rtol", "1e-5"], "not allowed with"),
        (["run", "slider-crank", "--t-end", "1", "--periods", "1"], "not allowed with"),
    ],
)
def test_usage(arguments, message, capsys):
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2
    assert message in capsys.readouterr().err


def test_a_folder_that_cannot_be_written_is_refused_before_the_run(tmp_path, capsys, monkeypatch):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setattr(run_module, "simulate", lambda *_, **__: pytest.fail("it ran"))
    err = refused(["run", "slider-crank", *SHORT, "--out", tmp_path / "file" / "out"], capsys)
    assert "cannot be written" in err
    assert "writable folder" in err


@pytest.mark.parametrize(("package", "option"), [("matplotlib", "--no-plots"), ("meshio", "--no-vtk"), ("h5py", "")])
def test_a_missing_package_is_named_before_the_run(tmp_path, capsys, monkeypatch, package, option):
    monkeypatch.setitem(sys.modules, package, None)
    monkeypatch.setattr(run_module, "simulate", lambda *_, **__: pytest.fail("it ran"))
    err = refused(["run", "slider-crank", *SHORT, "--out", tmp_path], capsys)
    assert f"pip install {package}" in err
    assert option in err


def test_a_package_that_a_model_lacks(tmp_path, capsys):
    path = tmp_path / "needy.py"
    path.write_text("import package_that_nobody_has.inner\n")
    assert "package_that_nobody_has" in refused(["check", path], capsys)


def test_a_run_that_does_not_finish(tmp_path, capsys, monkeypatch):
    whole = run_module.simulate
    monkeypatch.setattr(run_module, "simulate", lambda *a, **k: whole(*a, **k, max_steps=40))
    assert main(["run", "slider-crank", *SHORT, "--out", str(tmp_path)]) == 1
    assert "flexmb: Stopped after 40 steps" in capsys.readouterr().err
    assert not load(tmp_path / "slider-crank.nc").ok
    assert (tmp_path / "signals.png").exists()


def test_keyboard_leaves_what_was_computed(tmp_path, capsys, monkeypatch):
    from flexmb.engine.newmark.method import NewmarkStepper

    block, calls = NewmarkStepper.advance, []

    def interrupted(self, *arguments):
        calls.append(None)
        if len(calls) > 1:
            raise KeyboardInterrupt
        return block(self, *arguments)

    monkeypatch.setattr(NewmarkStepper, "advance", interrupted)
    monkeypatch.setattr("flexmb.run.run.FIRST_BLOCK_UPDATES", 0)  # so that the least block is taken, of 16 steps
    assert main(["run", "slider-crank", *SHORT, "--no-vtk", "--no-plots", "--no-report", "--out", str(tmp_path)]) == 1
    sol = load(tmp_path / "slider-crank.nc")
    assert "Interrupted" in sol.status
    assert sol.stats.steps == 16
    assert len(sol.time) == 1 + 16 // 5
    assert "Interrupted" in capsys.readouterr().err


def test_keyboard_before_the_first_saved_instant(tmp_path, capsys, monkeypatch):
    from flexmb.engine.newmark.method import NewmarkStepper

    calls = []

    def interrupted(self, *arguments):
        calls.append(None)
        raise KeyboardInterrupt

    monkeypatch.setattr(NewmarkStepper, "advance", interrupted)
    arguments = ["run", "slider-crank", "--periods", "2", "--save-from-period", "1", "--step", "20us", "--quiet"]
    assert main([*arguments, "--out", str(tmp_path)]) == 1
    assert len(calls) == 1  # the run does not go on with what was to be saved
    err = capsys.readouterr().err
    assert "nothing was saved" in err
    assert "Interrupted" in err
    assert len(load(tmp_path / "slider-crank.nc").restart) > 0


@pytest.mark.slow
def test_pictures_that_fail_do_not_cost_the_run(tmp_path, capsys):
    (tmp_path / "signals.png").mkdir()
    assert main(["run", "slider-crank", *SHORT, "--out", str(tmp_path)]) == 1
    assert "some files are missing" in capsys.readouterr().err
    assert load(tmp_path / "slider-crank.nc").ok


def test_list(capsys):
    assert main(["list"]) == 0
    out = capsys.readouterr().out
    for word in ("nine-bar:", "slider-crank:", "four-bar:", "--clearance", "[m]", "--flexible", "(default 4)"):
        assert word in out


def test_check(capsys):
    assert main(["check", "nine-bar", "--speed", "2pi", "--clearance", "0.5mm"]) == 0
    out = capsys.readouterr().out
    for word in ("degrees of freedom  2", "clearance joints    1: P1", "redundant joints    none"):
        assert word in out
    # the eight bodies of Chen, Jiang, Deng, Wang, Nonlinear Dynamics (2018), table 1
    mass = 0.148 + 0.805 + 0.603 + 0.265 + 0.581 + 4.334 + 0.827 + 0.801
    assert f"mass                {mass:.6g} kg" in out


def test_check_tells_all_errors_and_fails(tmp_path, capsys):
    lines = [
        "import flexmb as fm",
        "arm = fm.RigidLink('arm', (0, 0), (1, 0), mass=1.0, inertia=0.1)",
        "pins = [fm.Revolute(name, fm.GROUND, arm, at=(0, 0)) for name in ('one', 'two')]",
        "loose = fm.RigidLink('loose', (5, 0), (6, 0), mass=1.0, inertia=0.1)",
        "mech = fm.Mechanism('broken', [arm, loose, *pins])",
    ]
    (tmp_path / "broken.py").write_text("\n".join(lines))
    assert main(["check", str(tmp_path / "broken.py")]) == 1
    said = capsys.readouterr().out
    assert "error [redundant-joints] The joints 'one', 'two'" in said
    assert "warning [free-body] 'loose'" in said
    assert main(["check", str(tmp_path / "broken.py"), "--json"]) == 1
    report = json.loads(capsys.readouterr().out)
    assert report["ok"] is False
    assert {finding["code"] for finding in report["findings"]} == {"redundant-joints", "free-body", "free-motion"}


@pytest.mark.parametrize("code", ["0", "1", "'stop'", ""])
def test_a_file_that_ends_python_is_no_success(tmp_path, capsys, code):
    (tmp_path / "ending.py").write_text(f"import sys\n\nsys.exit({code})\n")
    err = refused(["run", str(tmp_path / "ending.py")], capsys)
    assert "ending.py, line 3: the file ends Python" in err


def test_check_of_a_file(model, capsys):
    assert main(["check", f"{model}:swing", "--length", "2m"]) == 0
    assert "Mechanism 'swing'" in capsys.readouterr().out


@pytest.fixture
def record(tmp_path, capsys):
    without = ["--no-vtk", "--no-plots", "--no-report"]
    assert main(["run", "slider-crank", *SHORT, *without, "--out", str(tmp_path)]) == 0
    capsys.readouterr()
    return tmp_path / "slider-crank.nc"


def test_vtk_of_a_run_on_disk(record, tmp_path, capsys):
    assert main(["vtk", str(record)]) == 0
    assert main(["vtk", str(record), "--frames", "3", "--out", str(tmp_path / "a" / "b.pvd")]) == 0
    assert main(["vtk", str(record), "--frames", "2", "--out", str(tmp_path / "new")]) == 0
    places = [record.with_suffix(".pvd"), tmp_path / "a" / "b.pvd", tmp_path / "new" / "slider-crank.pvd"]
    assert capsys.readouterr().out.split() == [str(place) for place in places]
    assert len(list((tmp_path / "slider-crank").glob("*.vtu"))) == 21
    assert len(list((tmp_path / "a" / "b").glob("*.vtu"))) == 3
    assert "crank" in json.loads((tmp_path / "a" / "b" / "names.json").read_text())["parts"].values()


def test_vtk_of_a_truncated_file(record, capsys):
    content = record.read_bytes()
    record.write_bytes(content[: len(content) // 2])
    assert "damaged, truncated or no netCDF file" in refused(["vtk", record], capsys)


def test_vtk_refusals(record, tmp_path, capsys):
    assert "no such file" in refused(["vtk", tmp_path / "absent.nc"], capsys)
    assert "frames is 1; it must be at least 2" in refused(["vtk", record, "--frames", "1"], capsys)
    assert "must end in .pvd" in refused(["vtk", record, "--out", tmp_path / "a.png"], capsys)


def test_debug_shows_where_an_error_came_from(tmp_path):
    from flexmb.errors import InputError

    with pytest.raises(InputError):
        main(["run", "slider-crank", "--t-end", "5mm", "--debug", "--out", str(tmp_path)])


def test_negative_numbers_are_tied_to_their_option():
    given = ["run", "x", "--speed", "-2pi", "--start", "-.5,-pi", "--quiet", "-h", "--a=1", "-2"]
    assert with_negative_numbers(given) == [
        "run",
        "x",
        "--speed=-2pi",
        "--start=-.5,-pi",
        "--quiet",
        "-h",
        "--a=1",
        "-2",
    ]


def test_help_and_version_do_not_wait_for_numba(root):
    code = (
        "import sys; from flexmb.cli import main\ntry: main(sys.argv[1:])\nfinally: assert 'numba' not in sys.modules"
    )
    for option, word in (("--version", "flexmb "), ("--help", "check"), ("list", "nine-bar: ")):
        command = [sys.executable, "-c", code, option]
        done = subprocess.run(command, capture_output=True, text=True, cwd=root, check=False)
        assert done.returncode == 0, done.stderr
        assert word in done.stdout


LEFT = """
import flexmb as fm

class Log:
    def __init__(self):
        self.me = self

    def __del__(self, opened=open):
        with opened("garbage.txt", "w") as file:
            file.write("written")

Log()
mech = fm.mechanisms.slider_crank(10.0)
"""


@pytest.mark.slow
def test_what_is_left_to_the_collector_is_written_when_a_command_ends(tmp_path):
    """A command looks for garbage seldom, and once at its end; commands called from Python leave Python as it is."""
    (tmp_path / "model.py").write_text(LEFT)
    command = [sys.executable, "-m", "flexmb", "check", "model.py"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "garbage.txt").read_text() == "written"
    before = gc.get_threshold()
    assert main(["list"]) == 0
    assert gc.get_threshold() == before


def test_ready_mechanisms_are_listed_as_they_are_run():
    """Their signatures are read from the sources for the list, and from the functions for a run."""
    listed, usable = options.declared(), ready()
    assert list(listed) == list(usable)
    for name, make in usable.items():
        assert options.options_of(listed[name]) == options.options_of(make)
        assert listed[name].__doc__.splitlines()[0] == make.__doc__.splitlines()[0]


@pytest.mark.slow
def test_as_a_module(root):
    command = [sys.executable, "-m", "flexmb", "run", "slider-crank", "--clearance", "1 parsec"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=root, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("flexmb: --clearance")


def test_the_summary_counts_impacts(tmp_path, capsys):
    """The numbers of the line are those of the episodes in the file."""
    arguments = "run slider-crank --speed 5000rpm --clearance 0.5mm --t-end 2ms --step 1us --no-vtk --no-plots --out"
    assert main([*arguments.split(), str(tmp_path)]) == 0
    line = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("impacts in B"))
    e = load(tmp_path / "slider-crank.nc").episodes("B")
    hits = e[e.mode == 1]
    assert len(hits) > 2
    assert re.match(rf"impacts in B +{len(hits)}\b", line)
    assert f"largest impulse {hits.impulse.max():.3g} N s" in line
    assert f"longest flight {np.nanmax(e.flight):.3g} s" in line


@pytest.mark.skipif(
    sys.platform != "linux" or len(os.sched_getaffinity(0)) == 1, reason="pictures are drawn in the process itself"
)
def test_a_run_that_is_killed_leaves_no_process_that_draws(tmp_path):
    words = [sys.executable, "-m", "flexmb", "run", "slider-crank", "--periods", "1e6", "--out", str(tmp_path)]
    with subprocess.Popen(words, stderr=subprocess.DEVNULL) as process:
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        own = waited_for(lambda: children.read_text().split())
        process.kill()
    assert waited_for(lambda: not any(Path(f"/proc/{child}").exists() for child in own))


def waited_for(answer):
    """The first answer that is true, within 30 s."""
    for _ in range(3000):
        if found := answer():
            return found
        time.sleep(0.01)
    return found
