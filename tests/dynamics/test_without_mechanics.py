"""Dynamics is a house of its own: maps and differential equations run through it without any mechanics."""

import subprocess
import sys

import pytest

MECHANICS = "elastic engine findings mechanisms model parts program results run show statics".split()
"""Rooms of the package that flows and maps do without."""

OF_ENGINE = ("", "compiled")
"""What sweeps take of the engine: digests of functions, by which a store knows its sweep."""

BEGIN = """
import sys

class Refuse:
    def find_spec(self, name, path=None, target=None):
        top, room, inner, *_ = [*name.split("."), "", ""]
        if top == "flexmb" and room in {rooms} and not (room == "engine" and inner in {of_engine}):
            raise ImportError(name + " is mechanics")

sys.meta_path.insert(0, Refuse())
import flexmb as fm
import numpy as np

henon = fm.chaos.Map(lambda x, a: [1.0 - a * x[0] ** 2 + x[1], 0.3 * x[0]], [0.1, 0.1], parameters=dict(a=1.4))
rates = lambda t, x: [x[1], np.sin(t) - x[0] - x[1]]
sprung = fm.chaos.ODE(rates, [0.0, 0.0], period=2.0 * np.pi, names=["x", "v"])
"""

TOOLS = """
print(fm.lyapunov(henon, skip=20, periods=200).verdict)
print(fm.chaos.benettin(henon, periods=200).value > 0.3)
print(fm.lyapunov(sprung, skip=5, periods=60, confirm=False).verdict)
print(fm.chaos.section(sprung, "v", keep=3).sizes)
sprung.reset()
ball = fm.chaos.ImpactODE(sprung, gap=lambda t, x: 0.5 + x[0], jump=lambda t, x: [x[0], -0.5 * x[1]])
print(fm.chaos.judge(fm.stroboscopic(ball, keep=40, skip=10).x.values[:, None], ["x"]))
print(fm.chaos.periodic_orbit(henon, guess=[0.6, 0.2]).stable)
orbit = fm.chaos.periodic_orbit(henon.copy(), guess=[0.6, 0.2])
print(fm.chaos.follow(orbit, "a", (1.4, 1.3)).ok)
print(fm.chaos.basin(sprung, ("x", [0.0, 0.1]), ("v", [0.0]), settle=5, longest=60).number.tolist())
print(fm.chaos.zero_one_test(np.sin(0.3 * np.arange(3000))).kind)
print(fm.chaos.report(sprung, keep=50, series=20, samples=50, confirm=False).exponents.verdict)
try:
    fm.lyapunov(3, periods=100)
except fm.errors.InputError as error:
    print(error)
"""
SAID = """
chaotic
True
periodic-1
Frozen({'crossing': 3})
periodic-1
False
True
[[1, 1]]
regular
periodic-1
lyapunov: system is 3; it must be a Mechanism, or a flow or map as ODE, Map, StroboscopicMap.
"""
"""What the tools print."""


def said_without_mechanics(code: str, of_engine: tuple[str, ...] = ()) -> str:
    """What a fresh process prints that cannot import mechanics."""
    begin = BEGIN.format(rooms=MECHANICS, of_engine=of_engine)
    run = subprocess.run([sys.executable, "-c", begin + code], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    return run.stdout.strip()


@pytest.mark.slow
def test_exponents_sections_orbits_basins_verdicts_and_series():
    assert said_without_mechanics(TOOLS) == SAID.strip()


def test_mechanics_cannot_be_imported_there():
    code = "try:\n    fm.chaos.MechanismFlow\nexcept ImportError as error:\n    print(error)"
    assert said_without_mechanics(code).endswith("is mechanics")


def test_sweeps_need_digests_alone():
    code = "print(fm.bifurcation(henon, 'a', [0.9, 1.4], skip=500, keep=12, direction='up').verdict.values[0])"
    assert said_without_mechanics(code, OF_ENGINE) == "periodic-2"
