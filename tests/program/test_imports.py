"""What a run imports: packages that take long to import wait until they are needed."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

RIGID = """
import sys
import flexmb as fm
mechanism = fm.mechanisms.slider_crank(clearance=2e-4, friction="coulomb")
sol = fm.simulate(mechanism, t_end=1e-5, step=1e-6, save=1, progress={progress})
assert sol.ok and sol.array("slider.x").shape == (2,), sol
print(*(name for name in {names} if name in sys.modules))
"""
LATE = "pandas xarray scipy.sparse scipy.optimize scipy.interpolate skfem meshio matplotlib tqdm".split()


def imported(progress):
    """Those of LATE that a new process has imported after a run of a rigid mechanism."""
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    code = RIGID.format(progress=progress, names=LATE)
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=500, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout.split(), done.stderr


def test_a_rigid_run_imports_neither_labels_nor_sparse_matrices_nor_bars():
    assert imported(progress=False) == ([], "")


@pytest.mark.slow
def test_lines_of_progress_in_a_file_need_no_bar():
    names, shown = imported(progress=True)
    assert names == []
    assert "s of motion" in shown
    assert "100 %" in shown
