"""Errors of the paper that docs/nine_bar.md lists, each shown without the formula in question.

The kinetic energy (12) is held against the motion in tests/mechanisms/test_nine_bar_ideal.py.
"""

import numpy as np
import pytest

import flexmb as fm
from flexmb.mechanisms import nine_bar

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
