"""The force at the ideal joint: hodographs with a known answer, and the nine-bar mechanism."""

import math

import numpy as np
import pytest
from nine_bar_study.nine_bar.cases import case
from nine_bar_study.nine_bar.reaction import crossings, reaction, reversal, turning

N = 64
ANGLE = np.arange(N) * 2.0 * math.pi / N


def hodograph(aside: float) -> tuple[np.ndarray, np.ndarray]:
    """S = (-5, aside), D = (2 + cos a, 0.3 sin a): along x the force is least at a = pi, and D is largest at a = 0."""
    static = np.tile([-5.0, aside], (N, 1))
    return static, np.stack([2.0 + np.cos(ANGLE), 0.3 * np.sin(ANGLE)], axis=1)


def test_crossing_through_the_origin_is_found_exactly():
    # S x D = 0 where sin a = 0; S + w^2 D = 0 there for w^2 = 5/3 (a = 0) and 5 (a = pi)
    found = crossings(*hodograph(0.0))
    assert [c.speed * math.pi for c in found] == pytest.approx([math.sqrt(5.0 / 3.0), math.sqrt(5.0)], rel=1e-12)
    assert [c.angle for c in found] == pytest.approx([0.0, math.pi], abs=1e-12)


def test_crossings_between_the_points_are_found():
    # D = (1, sin a - 1/2): parallel to S = (-4, 0) at 30 and 150 degrees, which are no points of the grid
    dynamic = np.stack([np.ones(N), np.sin(ANGLE) - 0.5], axis=1)
    found = crossings(np.tile([-4.0, 0.0], (N, 1)), dynamic)
    assert [c.speed * math.pi for c in found] == pytest.approx([2.0, 2.0], rel=1e-12)
    assert [math.degrees(c.angle) for c in found] == pytest.approx([30.0, 150.0], abs=1e-9)


def test_no_crossing_where_the_parts_do_not_oppose_each_other():
    static, dynamic = hodograph(0.0)
    assert crossings(-static, dynamic) == []


def test_force_that_passes_beside_the_origin_turns_round_all_the_same():
    static, dynamic = hodograph(0.1)
    speed = reversal(static, dynamic)
    below, above = turning(static, dynamic, 0.98 * speed), turning(static, dynamic, 1.05 * speed)
    assert below.swing < 0.5 * math.pi < above.swing
    assert 0.0 < turning(static, dynamic, speed).least < 0.1
    assert above.swing > 2.0 * below.swing


def test_reversal_of_a_straight_hodograph_is_where_it_reaches_zero():
    # F_x = -5 + w^2 (2 + cos a) < 0 for all angles up to w^2 = 5/3
    static, dynamic = hodograph(0.0)
    dynamic[:, 1] = 0.0
    assert reversal(static, dynamic) * math.pi == pytest.approx(math.sqrt(5.0 / 3.0), rel=1e-9)
    assert math.isnan(reversal(-static, dynamic))


@pytest.mark.parametrize("rounds", [-2, 1, 3])
def test_direction_that_goes_round_is_counted(rounds):
    force = np.stack([np.cos(rounds * ANGLE), np.sin(rounds * ANGLE)], axis=1)
    found = turning(force, np.zeros((N, 2)), 1.0)
    assert (found.turns, found.least) == (rounds, pytest.approx(1.0))
    assert found.fastest == pytest.approx(abs(rounds))


@pytest.fixture(scope="module")
def nine_bar_reaction():
    data = reaction(case("ideal", 1.0), points=60).compute()
    return data["static"].values, data["dynamic"].values


@pytest.mark.slow
def test_a_third_speed_gives_the_same_parts(nine_bar_reaction):
    from flexmb.statics.inverse_dynamics import inverse_dynamics

    static, dynamic = nine_bar_reaction
    speed = 2.5 * math.pi
    times = np.arange(60) * (2.0 * math.pi / 60) / speed
    force = inverse_dynamics(case("ideal", 2.5).mechanism(), times).forces["P1"][:, :2]
    assert static + speed**2 * dynamic == pytest.approx(force, abs=1e-8 * np.abs(force).max())


def test_nine_bar_force_turns_round_between_165_and_17_pi(nine_bar_reaction):
    static, dynamic = nine_bar_reaction
    assert 1.65 < reversal(static, dynamic) < 1.70
    assert turning(static, dynamic, 1.6).swing < 1.0
    assert turning(static, dynamic, 1.7).swing > 2.5
    assert crossings(static, dynamic)[0].speed > 2.5
