"""`flexmb rerun`: equal bits, two motions told apart, nothing executed that was not named."""

import dataclasses

import numpy as np
import pytest

import flexmb as fm
from flexmb.cli.command_line import main
from flexmb.cli.run import without_output
from flexmb.cli.saved import compare

RUN = "run slider-crank --speed 600rpm --clearance 0.1mm --t-end 20ms --save 50 --no-plots --no-vtk --quiet".split()


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    assert main([*RUN, "--out", str(folder)]) == 0
    return folder / "slider-crank.nc"


def test_a_run_is_repeated_bit_for_bit(result, capsys):
    assert main(["rerun", str(result)]) == 0
    assert "The runs are equal to the last bit." in capsys.readouterr().out


def test_another_motion_is_told(result, tmp_path, capsys):
    sol = fm.load(result)
    values = sol.values.copy()
    values[:, sol.names.index("slider.x")] *= 1.001
    path = dataclasses.replace(sol, values=values).to_netcdf(tmp_path / "changed.nc")
    assert main(["rerun", str(path)]) == 1
    said = capsys.readouterr().out
    assert "'slider.x' at most" in said


def test_round_off_that_grows_is_no_other_motion():
    """A difference of 1e-15 exp(100 t): the runs part, and are one motion all the same."""
    sol = fm.simulate(fm.mechanisms.slider_crank(), t_end=0.4, save=400)
    noise = 1e-15 * np.exp(100.0 * sol.time)[:, None] * np.ptp(sol.values, axis=0)
    other = dataclasses.replace(sol, values=sol.values + noise)
    found = compare(sol, other)
    assert found.good
    assert found.parted == pytest.approx(np.log(1e-3 / 1e-15) / 100.0, abs=2e-3)
    assert "up to there they are one motion" in str(found)
    shifted = compare(sol, dataclasses.replace(sol, values=sol.values * 1.01))
    assert not shifted.good
    assert "these are two motions" in str(shifted)


def test_a_file_is_executed_only_if_it_is_named(tmp_path, capsys):
    model = tmp_path / "own.py"
    mark = tmp_path / "executed"
    model.write_text(
        f"from pathlib import Path\nfrom flexmb.mechanisms import slider_crank\nPath({str(mark)!r}).touch()\n"
        "mech = slider_crank()\n"
    )
    arguments = ["run", str(model), "--t-end", "1ms", "--no-plots", "--no-vtk", "--quiet", "--out", str(tmp_path)]
    assert main(arguments) == 0
    mark.unlink()
    assert main(["rerun", str(tmp_path / "own.nc")]) == 2
    assert "Name it if you trust it" in capsys.readouterr().err
    assert not mark.exists()
    assert main(["rerun", str(tmp_path / "own.nc"), str(model)]) == 0
    assert mark.exists()


def test_other_files_are_refused(tmp_path, capsys):
    path = fm.simulate(fm.mechanisms.slider_crank(), t_end=1e-3).to_netcdf(tmp_path / "plain.nc")
    assert main(["rerun", str(path)]) == 2
    assert "does not say how it was made" in capsys.readouterr().err


def test_options_of_output_are_not_repeated_those_of_the_mechanism_are():
    """`--no-flexible` was dropped with `--no-vtk`: a mechanism that is flexible by default was another one."""
    typed = (
        "run rod.py --out a --no-flexible --frames=3 --outer 2 --no-vtk --resume --checkpoint 1s --set a.b=-1 --debug"
    )
    assert without_output(typed.split()) == "run rod.py --no-flexible --outer 2 --set a.b=-1".split()
