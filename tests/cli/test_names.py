"""Names with letters that the terminal or the system does not know."""

import os
import subprocess
import sys

import pytest

from flexmb.results.netcdf import load

MODEL = """
import flexmb as fm

bar = fm.RigidLink("K\u00fcrbel", (0.0, 0.0), (1.0, 0.0), mass=1.0, inertia=0.1)
mech = fm.Mechanism("Gr\u00f6\u00dfe", [bar, fm.Revolute("O", fm.GROUND, bar, at=(0.0, 0.0))], gravity=(0.0, -9.81))
"""

ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "\u00fcn\u00ef.py"
    path.write_text(MODEL, encoding="utf-8")
    return path


def flexmb(folder, *arguments, **environment):
    """A command in a process of its own."""
    command = [sys.executable, "-m", "flexmb", *map(str, arguments)]
    return subprocess.run(
        command, cwd=folder, env=os.environ | environment, capture_output=True, timeout=300, check=False
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "environment", [pytest.param(ASCII, marks=pytest.mark.slow), {"PYTHONIOENCODING": "ascii:strict"}]
)
def test_what_the_terminal_cannot_show_is_escaped(tmp_path, model, environment):
    done = flexmb(tmp_path, "check", model, **environment)
    assert done.returncode == 0, done.stderr
    assert b"Gr\\xf6\\xdfe" in done.stdout
    assert b"1: K\\xfcrbel" in done.stdout


@pytest.mark.slow
def test_a_run_without_unicode_writes_all_its_files(tmp_path, model):
    """Nor does it wait for xarray, without pages of diagrams."""
    code = "import sys; from flexmb.cli import main\nmain(sys.argv[1:])\nassert 'xarray' not in sys.modules"
    command = [sys.executable, "-c", code, "run", str(model), "--quiet", "--out", "o"]
    command += ["--t-end", "10ms", "--step", "1ms", "--frames", "2"]
    done = subprocess.run(command, cwd=tmp_path, env=os.environ | ASCII, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    assert {one.suffix for one in (tmp_path / "o").iterdir()} == {".nc", ".pvd", ".png", ".html", ""}
    assert load(tmp_path / "o" / "\u00fcn\u00ef.nc").model["name"] == "Gr\u00f6\u00dfe"
    assert "\u00fcn\u00ef/\u00fcn\u00ef_0001.vtu" in (tmp_path / "o" / "\u00fcn\u00ef.pvd").read_text(encoding="utf-8")
    assert (tmp_path / "o" / "\u00fcn\u00ef" / "\u00fcn\u00ef_0001.vtu").exists()
