"""Rows at other instants and magnified deformations."""

import runpy
from pathlib import Path

import numpy as np
import pytest

import flexmb as fm
from flexmb.results.positions import at_times, magnified

solution = runpy.run_path(str(Path(__file__).parents[1] / "handmade.py"))["solution"]


def test_saved_rows_are_met():
    sol = solution(n=21)
    again = at_times(sol, sol.time)
    np.testing.assert_allclose(again.values, sol.values, rtol=0.0, atol=1e-15)


def test_coordinates_between_rows_are_of_third_order():
    """The crank turns on a circle: errors fall by eight with half the distance of the rows."""
    times = np.linspace(0.3, 0.7, 400)
    errors = []
    for n in (21, 41, 81):
        x = at_times(solution(n=n), times).array("crank.x")
        errors.append(np.abs(x - 0.1 * np.cos(2.0 * np.pi * times)).max())
    assert errors[0] < 1e-4
    assert np.log2(errors[0] / errors[1]) > 2.9
    assert np.log2(errors[1] / errors[2]) > 2.9


def test_other_signals_are_linear_and_modes_are_held():
    sol = solution(n=5)
    half = at_times(sol, np.array([0.125]))
    force, mode = sol.array("P.normal_force"), sol.array("P.mode")
    assert half.array("P.normal_force")[0] == pytest.approx(0.5 * (force[0] + force[1]))
    assert half.array("P.mode")[0] == mode[0]
    assert at_times(sol, np.array([0.25])).array("P.mode")[0] == mode[1]


@pytest.mark.parametrize("n", [1, 2])
def test_few_rows(n):
    sol = solution(n=n)
    np.testing.assert_array_equal(at_times(sol, sol.time[:1]).values, sol.values[:1])


def test_rows_of_one_time_are_no_trouble():
    sol = solution(n=11)
    time = sol.time.copy()
    time[5] = time[4]
    found = at_times(solution(n=11, time=time, values=sol.values), np.linspace(0.0, 1.0, 33))
    assert np.isfinite(found.values).all()
    assert np.abs(found.array("crank.x")).max() < 0.12


@pytest.fixture(scope="module")
def pinned():
    """A flexible link between two pins, bent by its weight, and a cantilever."""
    square = fm.Rectangle(width=0.01, height=0.01)
    rod = fm.FlexibleLink("rod", (0.0, 0.0), (1.0, 0.0), section=square, material=fm.STEEL, elements=4)
    arm = fm.FlexibleLink("arm", (0.0, 1.0), (1.0, 1.0), section=square, material=fm.STEEL, elements=4)
    parts = [
        rod,
        arm,
        fm.Revolute("A", fm.GROUND, rod, at=(0.0, 0.0)),
        fm.PinSlot("B", fm.GROUND, rod, at=(1.0, 0.0)),
        fm.Fixed("C", fm.GROUND, arm, at=(0.0, 1.0)),
    ]
    return fm.simulate(fm.Mechanism("beams", parts, gravity=(0.0, -9.81)), t_end=0.02, save=100)


def test_bodies_stay_at_their_joints(pinned):
    large = magnified(pinned, 50.0)
    for name in ("rod.start.x", "rod.start.y", "rod.end.y", "arm.start.x", "arm.start.y", "arm.start.theta"):
        np.testing.assert_allclose(large.array(name), pinned.array(name), atol=1e-10, err_msg=name)
    for name, held in (("rod.node2.y", 0.0), ("arm.end.y", 1.0)):
        true = pinned.array(name)[-1] - held
        assert abs(true) > 1e-5
        assert large.array(name)[-1] - held == pytest.approx(50.0 * true, rel=1e-3)
    assert magnified(pinned, 1.0) is pinned


def test_a_rigid_motion_is_not_magnified():
    sol = solution(n=9)
    straight = magnified(sol, 100.0)
    np.testing.assert_array_equal(straight.array("crank.x"), sol.array("crank.x"))
    flat = np.abs(np.sin(2.0 * np.pi * sol.time)) < 1e-9  # the arm is straight there
    for name in ("arm.node0.x", "arm.node2.x", "arm.node2.y"):
        np.testing.assert_allclose(straight.array(name)[flat], sol.array(name)[flat], atol=1e-12)
