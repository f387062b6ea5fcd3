"""Every example runs in an empty folder and prints numbers that agree with the reference values beside them."""

import math
import os
import re
import runpy
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
from cases import slow_where
from scipy.optimize import linprog, minimize_scalar

from flexmb.cli.command_line import main

EXAMPLES = Path(__file__).parents[2] / "examples"
NUMBER = r"([-+]?\d+\.?\d*(?:e[-+]?\d+)?)"


KNOWN = {
    "peaucellier": 1e-12,
    "chebyshev": 1e-7,
    "watt": 1e-10,
    "stephenson": 1e-10,
    "quick_return": 1e-8,
    "scotch_yoke": 1e-5,
    "toggle_press": 1e-6,
    "scissor_lift": 5e-6,
    "planetary_gear": 1e-10,
    "pantograph": 1e-10,
    "path_synthesis": 1e-8,
}
"""Examples of known mechanisms, each with the largest relative error of the numbers beside their exact values."""

LONGER = ("scissor_lift", "planetary_gear", "pantograph", "path_synthesis")


@pytest.fixture
def output(tmp_path, monkeypatch, capsys):
    """A function that runs an example in this process, in an empty folder, and returns what it prints.

    A warning that a user would see is an error.
    """
    monkeypatch.chdir(tmp_path)

    def run(name):
        with warnings.catch_warnings():
            for kind in (UserWarning, RuntimeWarning, FutureWarning):
                warnings.simplefilter("error", kind)
            runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
        said = capsys.readouterr()
        assert said.err == ""
        return said.out

    return run


@pytest.fixture
def printed(tmp_path, output):
    """The same for an example that draws a picture."""

    def run(name):
        text = output(name)
        assert (tmp_path / "out" / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        return text

    return run


def numbers(pattern, text):
    """The numbers at the places marked # of every line that matches."""
    found = re.findall(pattern.replace("#", NUMBER), text)
    assert found, text
    return [[float(x) for x in row] for row in found]


def test_no_example_is_forgotten():
    tested = {"pendulum", "cantilever", "flexible_four_bar", "own_law", "frame_from_mesh", "restart", "chaos"}
    tested |= {"cam_lift_off", "geneva", "ratchet", "pick_and_place", "counterweight", "cam_law", "worn_from_noise"}
    tested |= {
        "andrews",
        "spin_up",
        "whip",
        "worn_slider_crank",
        "nine_bar",
        "gripper",
        "rod_of_plates",
        "nine_bar_plates",
    }
    assert {path.stem for path in EXAMPLES.glob("*.py")} == tested | set(KNOWN) | {"nine_bar_paper"}  # tests/study


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", slow_where(lambda n: n in LONGER, KNOWN))
def test_known_mechanism(name, printed):
    text = printed(name)
    pairs = numbers(r"# ?(?:rad/s|N m|m\^2|rad|N|m)? ?\(exact #\)", text)
    assert len(pairs) == text.count("(exact ")
    for found, exact in pairs:
        assert found == pytest.approx(exact, rel=KNOWN[name], abs=1e-10 if name != "chebyshev" else 1e-6)


@pytest.mark.slow
def test_pick_and_place(output):
    text = output("pick_and_place")
    for line, error in (("carriage at +# m .*target #", 1e-4), (r"turned by +# deg +\(target #", 0.01)):
        ((found, expected),) = numbers(line, text)
        assert abs(found - expected) <= error
    ((current, expected),) = numbers(r"current +# A +\(expected #", text)
    assert abs(current - expected) <= 1e-3 * expected
    assert "voltage 24 V" in text


def test_pendulum(output):
    text = output("pendulum")
    ((measured, exact),) = numbers(r"period +# s, exact # s", text)
    # the lemniscate constant in Legendre's form: K(1/2) = Gamma(1/4)^2 / (4 sqrt(pi))
    assert exact == pytest.approx(math.sqrt(2.0 / (3.0 * 9.81)) * math.gamma(0.25) ** 2 / math.sqrt(math.pi), rel=1e-7)
    assert measured == pytest.approx(exact, rel=5e-6)


def test_cantilever(output):
    text = output("cantilever")
    ((_, exact),) = numbers(r"load # N, deflection of the tip # m", text)
    assert exact == pytest.approx(0.71379, abs=5e-6)  # K. Mattiasson, IJNME 17 (1981) 145-153, table I, P L^2/EI = 5
    errors = {int(n): error for n, error in numbers(r" # elements: .* error #;", text)}
    assert errors[4] < 5e-4
    assert errors[8] < errors[4] / 10  # fourth order, up to the stretching that the exact value leaves out
    assert errors[32] < 5e-6


def test_cam_lift_off(output):
    text = output("cam_lift_off")
    for measured, exact in (*numbers(r"lift # m \(exact #\)", text), *numbers(r"force # N \(exact #\)", text)):
        assert measured == pytest.approx(exact, rel=1e-5)
    ((found, exact),) = numbers(r"zero at # rad/s \(exact #\)", text)
    assert exact == pytest.approx(math.sqrt(80.0 / 0.003), abs=1e-3)  # (F0 + 2 k e)/(m e)
    assert found == pytest.approx(exact, rel=1e-5)
    episodes = dict(numbers(r"contact at +# rad/s: # episodes", text))
    assert [count > 1 for speed, count in sorted(episodes.items())] == [False, True, True]


def test_geneva(output):
    text = output("geneva")
    ((speed, exact),) = numbers(r"speed ratio # \(1 \+ sqrt 2 = #\)", text)
    assert speed == pytest.approx(exact, abs=1e-9)
    ((found, peak),) = numbers(r"acceleration # w\^2 \(#\)", text)
    assert found == pytest.approx(peak, rel=1e-5)
    error = float(re.findall(r"largest error (\S+)", text)[0])
    assert error < 1e-9
    turned = float(re.findall(r"turned by (\S+) degrees", text)[0])
    assert turned == pytest.approx(-90.0, abs=0.2)


def test_ratchet(output):
    rows = numbers(r"degrees, at rest at +# *, +# teeth on", output("ratchet"))
    assert [teeth for _, teeth in rows] == pytest.approx([0.0, 0.0, 2.0, 4.0], abs=1e-8)
    assert [rest for rest, _ in rows] == pytest.approx([rows[0][0] - 30.0 * n for n in (0, 0, 2, 4)], abs=2e-4)


def test_flexible_four_bar(output):
    rows = numbers(r"by # rad, coupler bends by # m", output("flexible_four_bar"))
    away, bends = zip(*rows, strict=True)
    for values in (away, bends):  # ten times as stiff: a tenth of it
        assert values[0] / values[1] == pytest.approx(10.0, rel=0.3)
        assert values[1] / values[2] == pytest.approx(10.0, rel=0.1)


@pytest.mark.slow
def test_own_law(tmp_path):
    """In a process of its own, as a user runs it: the kernel of the law stands in `__main__`."""
    environment = {**os.environ, "PYTHONPATH": str(EXAMPLES.parent)}
    command = [sys.executable, str(EXAMPLES / "own_law.py")]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    rows = numbers(r"with # m/s ends with # m/s, exact # m/s", done.stdout)
    assert len(rows) >= 3
    assert rows[0][0] == pytest.approx(0.5, abs=1e-7)
    for _, after, exact in rows:
        assert after == pytest.approx(exact, rel=2e-5)


def test_frame_from_mesh(output, tmp_path):
    text = output("frame_from_mesh")
    ((statics, exact),) = numbers(r"sinks by # um, Castigliano # um", text)
    moved = float(re.search(f"at rest after {NUMBER} um", text).group(1))
    ((moment, lever),) = numbers(r"# N mm in the column, P a = # N mm", text)
    assert statics == pytest.approx(exact, rel=1e-4)
    assert moved == pytest.approx(statics, rel=1e-4)
    assert moment == pytest.approx(lever, rel=1e-4)
    assert len(list((tmp_path / "out" / "bracket").glob("*.vtu"))) == 50


def test_restart(output):
    text = output("restart")
    assert "largest difference of the contact force: 0.0 N" in text
    ((first, second, whole),) = numbers(r"saved instants: # \+ # = #", text)
    assert first + second == whole


@pytest.mark.slow
def test_chaos(output, tmp_path):
    text = output("chaos")
    doublings = numbers(r"period # doubles at G = #, published #, error #", text)
    assert [row[0] for row in doublings] == [1, 2]
    # J. R. Taylor, Classical Mechanics (2005), table 12.1; steps of a 400th of the period move them by 3e-4
    assert [row[2] for row in doublings] == [1.0663, 1.0793]
    for _, found, published, error in doublings:
        assert found == pytest.approx(published, abs=4e-4)
        assert error == pytest.approx(found - published, abs=1e-4)
    assert "the orbit takes 4 s and is stable" in text
    exponents = {drive: (value, error) for drive, value, error in numbers(r"G = #: largest exponent # \+- # /s", text)}
    assert exponents[1.06][0] < exponents[1.06][1]
    assert exponents[1.503][0] > 3 * exponents[1.503][1]
    # Periodic motions: error of the steps. A chaotic one: lengths of vectors count speeds, too, so the logarithm of a
    # volume is that of the flow and up to 0.75 for the state at each end, over 180 periods.
    bounds = [2.5e-3, 2.5e-3, 2 * 0.75 / 180]
    for (found, exact, _), bound in zip(numbers(r"add up to # /s, exact # /s, error #", text), bounds, strict=True):
        assert exact == pytest.approx(-2 * 1.5 * 2 * math.pi / 4, abs=1e-4)
        assert found == pytest.approx(exact, abs=bound)
    assert {"periodic-1", "periodic-4", "chaotic"} <= set(re.search("verdicts: (.*)", text).group(1).split(", "))
    assert (tmp_path / "out" / "pendulum.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_andrews(printed):
    text = printed("andrews")
    pairs = numbers(r"# rad \(published #\)", text)
    assert len(pairs) == 7
    assert pairs[0][1] == 15.810771196  # Test Set for Initial Value Problem Solvers, release 2.4
    for found, published in pairs:
        assert found == pytest.approx(published, abs=1.1e-8)


@pytest.mark.slow
def test_spin_up(printed):
    text = printed("spin_up")
    ((back, independent),) = numbers(r"back by # m \(independent #\)", text)
    assert back == pytest.approx(independent, rel=2e-3)
    ((stretch, exact),) = numbers(r"stretch # m \(exact #\)", text)
    assert exact == pytest.approx(1.2 * 36.0 * 1e3 / (3.0 * 2.8e7), rel=1e-4)
    assert stretch == pytest.approx(exact, rel=1e-3)
    ((vibration, published),) = numbers(r"afterwards # m \(published #\)", text)
    assert vibration == pytest.approx(published, abs=1.01e-4)  # two digits


def test_whip(printed):
    text = printed("whip")
    ((time, thin, stone),) = numbers(r"in # s \(thin fold #\), a stone in # s", text)
    assert stone == pytest.approx(math.sqrt(2.0 * 0.8 / 9.81), abs=1e-4)
    assert time == pytest.approx(thin, rel=5e-3)  # the fold of links has a width
    ((speed, thin, stone),) = numbers(r"there # m/s \(thin fold #\), of a stone # m/s", text)
    assert thin == pytest.approx(math.sqrt(2.0 * 9.81 * 0.8 * 0.6 / 0.2), abs=1e-3)
    assert speed == pytest.approx(thin, rel=0.04)
    assert float(re.findall(r"energy lost (\S+) of", text)[0]) < 1e-3


@pytest.mark.slow
def test_gripper(printed):
    text = printed("gripper")
    grips = numbers(r"jaw # N \(leaf springs #\)", text)
    assert len(grips) == 2
    for grip, exact in grips:
        assert exact == pytest.approx(6.0 - 24.0 * 207e9 * 0.01 * 5e-4**3 / 12.0 / 0.06**3 * 5e-4, rel=1e-3)
        assert grip == pytest.approx(exact, rel=1e-3)


@pytest.mark.slow  # two hundred periods with clearance
def test_worn_slider_crank(printed):
    text = printed("worn_slider_crank")
    (first,) = numbers(r"exponent # \+- # /s from tangents", text)
    (second,) = numbers(r"exponent # \+- # /s from two runs", text)
    assert first[0] > 5.0 * first[1]
    assert abs(first[0] - second[0]) < 4.0 * math.hypot(first[1], second[1])
    assert "verdict chaotic" in text
    ((depth, contacts),) = numbers(r"at most # clearances from its centre, # contacts", text)
    assert 1.0 < depth < 1.3
    assert contacts >= 2


def test_nine_bar(printed):
    text = printed("nine_bar")
    torques = numbers(r"largest torque # N m \(inverse dynamics #\)", text)
    assert len(torques) == 2
    for simulated, inverse in torques:
        assert simulated == pytest.approx(inverse, rel=2e-4)
    ((moved, peaks),) = numbers(r"slider by # %.*\n.*acceleration # times", text)
    assert moved < 1.0  # docs/paper/claims.md, claim 1
    assert peaks > 10.0  # claim 2


@pytest.mark.slow
def test_rod_of_plates(printed):
    rows = numbers(r"frequency # Hz \(exact #\), deflection # mm, largest stress # MPa", printed("rod_of_plates"))
    assert len(rows) == 4
    for found, exact, deflection, stress in rows:
        assert exact == pytest.approx(math.pi * 0.008 / 0.18 * math.sqrt(2e11 / 12.0 / 7870.0), abs=0.01)
        assert found == pytest.approx(exact, rel=2e-3)  # shear and rotary inertia take 0.1 %
        assert deflection == pytest.approx(1.8672, rel=5e-3)  # docs/validation.md, within two turns
        assert stress == pytest.approx(rows[0][3], rel=2e-2)


@pytest.mark.slow  # ten seconds
def test_nine_bar_plates(printed):
    text = printed("nine_bar_plates")
    (beams, plates) = numbers(r"# kg, first frequencies with held cranks #, #, # Hz", text)
    assert plates[0] == pytest.approx(beams[0], rel=5e-4)
    assert plates[1:] == pytest.approx(beams[1:], rel=0.03)
    (beams, plates) = numbers(r"impact with # N at # ms; largest stress # MPa in crank4, safety #", text)
    assert plates[:2] == pytest.approx(beams[:2], rel=0.2)
    assert plates[2] == pytest.approx(beams[2], rel=0.25)
    assert plates[3] == pytest.approx(355.0 / plates[2], rel=0.01)


def shaking(slider):
    """Share b of the least peak of the force on the frame, and the peak, for an acceleration (n,) of the slider."""
    angle = np.linspace(0.0, 2.0 * math.pi, len(slider), endpoint=False)

    def peak(b):
        return float(np.hypot(slider - b * np.cos(angle), b * np.sin(angle)).max())

    found = minimize_scalar(peak, bounds=(0.1, 1.0), method="bounded", options={"xatol": 1e-12})
    return found.x, found.fun


@pytest.mark.slow
def test_counterweight(printed):
    """The exact acceleration of the slider from its path by differentiation in Fourier's space."""
    text = printed("counterweight")
    angle = np.linspace(0.0, 2.0 * math.pi, 2**17, endpoint=False)
    path = np.fft.rfft(np.cos(angle) + np.sqrt(16.0 - np.sin(angle) ** 2))
    path[32:] = 0.0  # harmonics fall below round-off
    share, least = shaking(np.fft.irfft(np.arange(len(path)) ** 2 * path))
    ((found, exact),) = numbers(r"limit: +b = # \(exact #\)", text)
    assert exact == pytest.approx(share, abs=1e-7)
    assert found == pytest.approx(share, abs=2e-6)
    ((found, exact),) = numbers(r"r w\^2: # \(exact #\)", text)
    assert exact == pytest.approx(least, abs=1e-7)
    assert found == pytest.approx(least, rel=5e-6)
    assert shaking(np.cos(angle) + 0.25 * np.cos(2.0 * angle))[0] == pytest.approx(0.5917343, abs=1e-7)


def least_acceleration(steepest):
    """Least peak of the acceleration over h/T^2 with two terms more than 3-4-5, by a linear program.

    Its unknowns are the factors of both terms and the peak; 10 mm of lift in 90 degrees, radius 15 mm to the roller.
    """
    x = np.polynomial.Polynomial([0.0, 1.0])
    terms = [x**3 * (1.0 - x) ** 3 * (1.0 - 2.0 * x) * (x * (1.0 - x)) ** k for k in range(2)]
    terms.append(10.0 * x**3 - 15.0 * x**4 + 6.0 * x**5)
    at = np.linspace(0.0, 1.0, 4001)
    bend = np.stack([one.deriv(2)(at) for one in terms], axis=1)
    tilt = np.stack([one.deriv()(at) / (0.5 * math.pi) - math.tan(steepest) * one(at) for one in terms], axis=1)
    peak = np.ones((len(at), 1))
    rows = np.block([[bend[:, :2], -peak], [-bend[:, :2], -peak], [tilt[:, :2], 0.0 * peak]])
    room = np.concatenate([-bend[:, 2], bend[:, 2], 1.5 * math.tan(steepest) - tilt[:, 2]])
    return linprog([0.0, 0.0, 1.0], A_ub=rows, b_ub=room, bounds=[(None, None)] * 3).fun


@pytest.mark.slow  # five seconds; path_synthesis and counterweight are optimised, too
def test_cam_law(printed):
    text = printed("cam_law")
    known = 2.0 * math.pi, 10.0 / math.sqrt(3.0), least_acceleration(1.5), least_acceleration(math.radians(30.0))
    rows = numbers(r"peak of # h/T\^2 \(exact #\), contact forces from +# N", text)
    assert [row[1] for row in rows] == pytest.approx(known, abs=1e-5)
    assert [row[0] for row in rows] == pytest.approx(known, rel=3e-5)
    assert [row[2] > 0.0 for row in rows] == [False, False, True, True]  # the usual laws lift off
    free, held = re.findall(f"pressure angle {NUMBER} degrees", text)
    assert float(free) > 31.0
    assert float(held) == pytest.approx(30.0, abs=1e-3)


@pytest.mark.slow  # eight seconds; fits to noise are in tests/design/test_fit.py
def test_worn_from_noise(printed):
    text = printed("worn_from_noise")
    rows = numbers(r" # \+- # \(true #\)", text)
    assert len(rows) == 3
    for value, error, true in rows:
        assert abs(value - true) < 3.0 * error
        assert error < 1e-2 * true
    (residuals,) = re.findall(f"residuals are {NUMBER} of the noise", text)
    assert float(residuals) == pytest.approx(1.0, abs=0.07)  # three times the scatter of a thousand draws


def test_commands_of_the_page(root, capsys):
    """None of docs/howto/command_line.md names a mechanism or an option that the command line does not know."""
    text = (root / "docs" / "howto" / "command_line.md").read_text(encoding="utf-8")
    commands = [c.split() for c in re.findall(r"^    flexmb (\S.*?)(?: +#.*)?$", text, re.MULTILINE)]
    ready = [c for c in commands if c[0] in {"run", "check", "sweep", "chaos"} and not c[1].endswith(".py")]
    assert len(ready) >= 3
    for command, name, *rest in ready:
        with pytest.raises(SystemExit) as stop:
            main([command, name, "--help"])
        assert stop.value.code == 0
        known = re.findall(r"--[a-z-]+", capsys.readouterr().out)
        assert {word for word in rest if word.startswith("--")} <= set(known)
