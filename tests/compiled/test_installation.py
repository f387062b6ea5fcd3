"""An installation that carries compiled code compiles nothing, and gives what compiled code gives."""

import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

TELL_COMPILED = """
from numba.core import event

class Names(event.Listener):
    def on_start(self, found):
        print("compiled", found.data["dispatcher"].py_func.__qualname__)
    def on_end(self, found):
        pass

event.register("numba:compile", Names())
"""

MODELS = (
    TELL_COMPILED
    + """
import sys
import flexmb as fm
import numpy as np
short = {"t_end": 1e-4, "step": 1e-6}

def peak(clearance):
    return fm.simulate(fm.mechanisms.slider_crank(clearance=clearance), t_end=1e-3).peak("B.normal_force").value

def carried():
    flow = fm.chaos.MechanismFlow(fm.mechanisms.slider_crank(clearance=5e-4))
    W = flow.tangent_basis(2, seed=3)
    flow.advance(2e-3, W)
    return W

beam = fm.FlexibleLink("beam", (0, 0), (1, 0), section=fm.Circle(0.01), material=fm.STEEL)
strut = [beam, fm.Fixed("foot", fm.GROUND, beam, (0, 0)), fm.Force("load", beam, (1, 0), (-1.0, 0.0))]
found = {
    "ideal": fm.simulate(fm.mechanisms.nine_bar(), t_end=0.01).values,
    "rigid": fm.simulate(fm.mechanisms.nine_bar(clearance=5e-4), t_end=0.01).values,
    "flexible": fm.simulate(fm.mechanisms.nine_bar(clearance=5e-4, flexible=True), t_end=1e-3).values,
    "tangent": carried(),
    "sweep": fm.sweep(peak, {"clearance": np.array([1e-4, 2e-4])})["value"].values,
    "statics": fm.static_equilibrium(fm.Mechanism("strut", strut)).q,
    "modes": fm.modes(fm.Mechanism("strut", strut)).frequencies,
    "explicit": fm.simulate(fm.mechanisms.slider_crank(), **short, method=fm.RungeKutta4()).values,
}
fm.buckling(fm.Mechanism("strut", strut))
fm.check(fm.mechanisms.nine_bar(clearance=5e-4))
fm.inverse_dynamics(fm.mechanisms.slider_crank(), [0.0, 1e-3])
np.savez(sys.argv[1], **found)
"""
)


def run(code, package, cache, *arguments, **variables):
    environment = {**os.environ, "PYTHONPATH": str(package), "NUMBA_CACHE_DIR": str(cache), "FLEXMB_MESSAGES": "1"}
    command = [sys.executable, "-c", code, *map(str, arguments)]
    return subprocess.run(command, env=environment | variables, cwd=package, check=True, capture_output=True, text=True)


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The package with compiled code beside it, in a folder of its own."""
    if platform.machine() != "x86_64":
        pytest.skip("no code is shipped for this machine")
    folder = tmp_path_factory.mktemp("installed")
    shutil.copytree(ROOT / "flexmb", folder / "flexmb", ignore=shutil.ignore_patterns("__pycache__"))
    target = folder / "flexmb" / "engine" / "compiled" / "shipped"
    subprocess.run([sys.executable, ROOT / "tests" / "ship.py", target], check=True, cwd=ROOT, capture_output=True)
    return folder


@pytest.mark.slow
def test_nothing_is_compiled_and_results_are_the_same(installed, tmp_path):
    import numpy as np

    cache = tmp_path / "cache"
    said = run(MODELS, installed, cache, tmp_path / "shipped.npz")
    assert said.stdout == said.stderr == ""
    assert not list(cache.rglob("*.nbc"))
    run(MODELS, ROOT, os.environ["NUMBA_CACHE_DIR"], tmp_path / "own.npz", FLEXMB_SHIPPED="0", FLEXMB_MESSAGES="0")
    with np.load(tmp_path / "shipped.npz") as shipped, np.load(tmp_path / "own.npz") as own:
        for name in own.files:
            assert shipped[name] == pytest.approx(own[name], rel=1e-12, abs=1e-12 * np.abs(own[name]).max()), name


@pytest.mark.slow
def test_a_model_of_the_users_own_law_compiles_that_law_alone(installed, tmp_path):
    (tmp_path / "law.py").write_text(LAW, encoding="utf-8")
    said = run(OWN, installed, tmp_path / "cache", PYTHONPATH=os.pathsep.join([str(installed), str(tmp_path)]))
    names = [line.split()[1] for line in said.stdout.splitlines() if line.startswith("compiled")]
    assert names == ["stiff_kernel"]
    assert said.stderr == ""


LAW = """
from dataclasses import dataclass

import flexmb as fm


@fm.normal_law
def stiff_kernel(p, h, gap, gap_rate, z, z_new):
    stiffness, = p
    if gap >= 0.0:
        return 0.0, 0.0, 0.0
    return -stiffness * gap, -stiffness, 0.0


@dataclass(frozen=True)
class Stiff(fm.NormalLaw):
    stiffness: float
    kernel = stiff_kernel
"""

OWN = (
    TELL_COMPILED
    + """
import flexmb as fm
from law import Stiff

mechanism = fm.mechanisms.slider_crank(clearance=5e-4).with_({"B.normal": Stiff(1e7)})
sol = fm.simulate(mechanism, t_end=1e-3)
assert sol.ok and sol.peak("B.normal_force").value > 0.0, sol
"""
)
