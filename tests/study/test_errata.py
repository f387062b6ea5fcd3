"""Errors of the paper that docs/nine_bar.md lists, each shown without the formula in question.

The kinetic energy (12) is held against the motion in tests/mechanisms/test_nine_bar_ideal.py.
"""

import re
from pathlib import Path

import numpy as np
import pytest

import flexmb as fm
from flexmb.mechanisms import NineBarData, nine_bar

ROOT = Path(__file__).parents[2]
L1, W = 0.045, 2.0 * np.pi


@pytest.fixture(scope="module")
def turn():
    sol = fm.simulate(nine_bar(W, clearance=0.5e-3), periods=1, save="steps")
    assert sol.ok, sol.status
    return sol


def test_eq_15_counts_the_contact_force_twice_in_the_torque_of_crank_1(turn):
    """Newton and Euler for crank 1 at constant speed: motor torque, weight, force and friction at P1 are in balance.

    In the coordinates of (12) a turn of crank 1 with x, y fixed moves both surfaces, so the contact forces do no
    work.  Equation (15) lets them: with the left side of (10), which holds them already through the inertia of
    what they move, the torque comes out twice as large.
    """
    angle = -W * turn.time
    fx, fy = turn.array("P1.fx"), turn.array("P1.fy")  # on the crank or from it: the sign is told by the data
    moment = L1 * (np.cos(angle) * fy - np.sin(angle) * fx)
    weight = 0.148 * 9.81 * 0.5 * L1 * np.sin(angle)
    friction = 0.010 * turn.array("P1.friction_force")
    torque = turn.array("motor1.torque")
    peak = np.argmax(np.abs(torque))
    side = np.sign(torque[peak] * moment[peak])
    left = torque - side * moment + weight
    assert np.abs(left).max() <= 1.001 * np.abs(friction).max() + 1e-9, "the balance leaves no more than friction"
    assert np.abs(moment).max() == pytest.approx(np.abs(torque).max(), rel=5e-3), "counted twice it would double"


def test_eq_15_has_the_wrong_radius_for_crank_1(turn):
    """Friction acts on the bearing of crank 1 halfway into the penetration: its arm is R1 + delta/2 and not R2."""
    angle = -W * turn.time
    fx, fy = turn.array("P1.fx"), turn.array("P1.fy")
    moment = L1 * (np.cos(angle) * fy - np.sin(angle) * fx)
    torque, friction = turn.array("motor1.torque"), turn.array("P1.friction_force")
    peak = np.argmax(np.abs(torque))
    left = torque - np.sign(torque[peak] * moment[peak]) * moment + 0.148 * 9.81 * 0.5 * L1 * np.sin(angle)
    big = np.abs(friction) > 0.3 * np.abs(friction).max()
    arm = np.abs(left[big] / friction[big])
    assert arm == pytest.approx(0.010 + 0.5 * turn.array("P1.penetration")[big], rel=1e-3)
    assert np.abs(arm - 0.0095).min() > 4e-4


def test_w_and_v_of_eq_20_are_along_the_axes_of_eq_18():
    """mu_2, mu_3, mu_5, mu_6 of N_A are Hermite's cubics: W is lateral, along y; N_B is linear: V is along x."""
    e = np.linspace(0.0, 1.0, 5)
    lateral = np.stack([1 - 3 * e**2 + 2 * e**3, e - 2 * e**2 + e**3, 3 * e**2 - 2 * e**3, e**3 - e**2])
    bent = np.polynomial.polynomial.polyfit(e, lateral.T, 3)
    assert np.abs(bent[3]).min() > 0.5  # cubic terms, as bending has
    page = (ROOT / "docs" / "nine_bar.md").read_text(encoding="utf-8")
    assert "| (20) | W_r along x, V_r along y | W_r along y, V_r along x |" in page


def test_the_page_of_equations_has_all_and_names_what_is_there():
    text = (ROOT / "docs" / "paper" / "equations.md").read_text(encoding="utf-8")
    found = set()
    for row in re.findall(r"^\| (\(.*?) \|", text, re.MULTILINE):
        ends = [int(n) for n in re.findall(r"\d+", row)]
        found |= set(range(ends[0], ends[-1] + 1)) if " to " in row else set(ends)
    assert found == set(range(1, 31))
    for path, name in re.findall(r"`((?:flexmb|tests)/[\w/]+\.py)`(?:, `(\w+)`)?", text):
        assert name in (ROOT / path).read_text(encoding="utf-8"), (path, name)


def test_damping_ratios_of_the_page_are_half_of_zeta2_omega():
    data = NineBarData()
    text = (ROOT / "docs" / "nine_bar.md").read_text(encoding="utf-8").split("### Damping")[1]
    rows = re.findall(r"^\| (\d) \| (.*) \|$", text.split("Steel alone")[0], re.MULTILINE)
    assert [row[0] for row in rows] == ["3", "8", "2", "6", "4", "1"]
    for number, cells in rows:
        root = 1.875104 if number in "14" else np.pi
        wave = np.sqrt(data.young * data.depth**2 / (12.0 * data.density))
        omega = (root / getattr(data, f"length{number}")) ** 2 * wave
        hertz, *shares = (float(cell) for cell in cells.split(" | "))
        assert hertz == pytest.approx(omega / (2.0 * np.pi), abs=0.51)
        assert shares == pytest.approx([50.0 * zeta * omega for zeta in (1e-6, 1e-5, 2e-5, 3e-5, 1e-4)], rel=0.04)


@pytest.mark.parametrize(("name", "hertz"), [("link3", 235), ("link8", 511), ("link2", 541), ("rocker6", 707)])
def test_bending_frequencies_of_the_page_are_those_of_the_beams(name, hertz):
    beam = nine_bar(flexible=True).find(name)
    pins = [fm.Revolute("a", fm.GROUND, beam, at=beam.start), fm.Revolute("b", fm.GROUND, beam, at=beam.end)]
    found = fm.modes(fm.Mechanism("bar", [beam, *pins], gravity=(0.0, 0.0))).frequencies[0]
    assert found == pytest.approx(hertz, abs=0.51)


@pytest.mark.parametrize("load", ["axial", "transverse"])
def test_eq_25_as_printed_resists_no_axial_force(load):
    """Tip of a cantilever by the printed matrix (N_A and N_B as in (18), which swaps them) and by the mended one."""
    young, area, inertia, length = 207e9, 3e-4, 1.5625e-8, 0.3
    place = {"axial": 0, "transverse": 1}[load]
    mended = _stiffness(young * area, young * inertia, length, swapped=False)[3:, 3:]
    printed = _stiffness(young * area, young * inertia, length, swapped=True)[3:, 3:]
    known = {"axial": length / (young * area), "transverse": length**3 / (3.0 * young * inertia)}[load]
    assert np.linalg.solve(mended, np.eye(3)[place])[place] == pytest.approx(known, rel=1e-10)
    assert np.linalg.matrix_rank(printed, tol=1e-9 * np.abs(printed).max()) == 2, "an axial force meets nothing"


def _stiffness(axial, bending, length, *, swapped):
    """Equation (25) by quadrature, with the shape functions of (18); N N^T where (25) prints N^T N, a number."""
    points, weights = np.polynomial.legendre.leggauss(4)
    matrix = np.zeros((6, 6))
    for e, weight in zip(0.5 * (points + 1.0), 0.5 * weights * length, strict=True):
        slope_b = np.array([-1.0, 0, 0, 1.0, 0, 0]) / length
        slope_a = (
            np.array(
                [
                    0,
                    -6 * e + 6 * e**2,
                    length * (1 - 4 * e + 3 * e**2),
                    0,
                    6 * e - 6 * e**2,
                    length * (3 * e**2 - 2 * e),
                ]
            )
            / length
        )
        bend_a = np.array([0, -6 + 12 * e, length * (-4 + 6 * e), 0, 6 - 12 * e, length * (6 * e - 2)]) / length**2
        bend_b = np.zeros(6)  # the axial shape functions are linear
        stretch, curve = (slope_a, bend_b) if swapped else (slope_b, bend_a)
        matrix += weight * (axial * np.outer(stretch, stretch) + bending * np.outer(curve, curve))
    return matrix
