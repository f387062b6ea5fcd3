"""Motions that move on, and motions whose exponent is zero: never quasi-periodic without a closed curve."""

import math

import numpy as np
import pytest
from cases import slow_where

import flexmb as fm

GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
CYCLES = {1: [0.5], 2: [0.2, 0.8], 3: [0.2, 0.5, 0.9], 4: [0.1, 0.7, 0.3, 0.9]}
RATES = [0.001, 0.003, 0.01, 0.03, 0.1, 0.3]
FEIGENBAUM = 3.569945672


def drifting(k, rise, count=400):
    """A k-cycle that rises by `rise` in all."""
    return np.resize(CYCLES[k], count) + np.linspace(0.0, rise, count)


def named(found, step):
    """Whether a verdict says that the motion moves on, by so much a point."""
    return str(found) == "transient" and f"moves on by {step:.3g} a point" in found.reason


@pytest.mark.quick(7)
@pytest.mark.parametrize("k", CYCLES)
@pytest.mark.parametrize("rate", slow_where(lambda n: n in (0.003, 0.03), RATES))
@pytest.mark.parametrize("sign", slow_where(lambda n: n < 0.0, [1.0, -1.0]))
def test_a_straight_drift_is_a_transient_that_names_it(k, rate, sign):
    """Counted over the whole record, and in each point; with an exponent of zero and without one."""
    for rise in (sign * rate, sign * rate * 399):
        x = drifting(k, rise)
        for options in ({}, {"exponent": 0.0, "error": 1e-3}, {"exponent": 1e-4, "error": 1e-3}):
            found = fm.chaos.judge(x, ["x"], **options)
            assert named(found, rise / 399), (str(found), found.reason)
            assert found.k == k
            assert found.evidence["drift"] == pytest.approx(rise / 399)
        assert "rad" in found.reason  # what to do if it is an angle


def test_the_drift_of_the_issue():
    """`np.tile([.2, .8], 200) + a t`, whatever t is: the number of a point, or 0 to 1."""
    for a in np.geomspace(0.001, 0.3, 12):
        for t in (np.arange(400), np.linspace(0.0, 1.0, 400)):
            assert str(fm.chaos.judge(np.tile([0.2, 0.8], 200) + a * t, ["x"])) == "transient"


@pytest.mark.parametrize("rate", RATES)
def test_one_signal_of_several_that_drifts_is_named(maps, rate):
    angle = maps["circle"](400, GOLDEN, 0.5)
    for other in (np.cos(angle), maps["henon"](400)[:, 0], np.resize(CYCLES[3], 400)):
        found = fm.chaos.judge(np.column_stack([other, drifting(2, rate)]), ["a", "b"])
        assert named(found, rate / 399), found.reason
        assert found.reason.startswith("b moves on")


@pytest.mark.parametrize("rise", [0.01, 0.03, 0.1, 0.3])
def test_a_drift_under_noise(rise):
    """Noise of a tenth of the rise and of 1e-5."""
    noise = np.random.default_rng(0).standard_normal(400)
    for size in (0.1 * rise, 1e-5):
        found = fm.chaos.judge(drifting(2, rise) + size * noise, ["x"])
        assert str(found) == "transient"
        assert "moves on by" in found.reason


def test_a_drift_under_a_closed_curve_and_under_chaos(maps):
    """A rise of the size of the motion."""
    angle = maps["circle"](400, GOLDEN, 0.5)
    for x in (np.cos(angle), maps["henon"](400)[:, 0], maps["logistic"](400, 3.6)):
        rise = 4.0 * x.std()
        for sign in (1.0, -1.0):
            found = fm.chaos.judge(x + np.linspace(0.0, sign * rise, 400), ["x"])
            assert str(found) == "transient"
            assert "moves on by" in found.reason


def test_a_motion_that_settles_and_then_drifts():
    n = np.arange(400)
    found = fm.chaos.judge(drifting(2, 0.2) + 0.5 * 0.9**n, ["x"])
    assert named(found, 0.2 / 399), found.reason


def test_an_angle_that_moves_on_counts_modulo_a_turn():
    """By whole turns: periodic. By another part of a turn: round and round. By less than a turn in all: a drift."""
    n = np.arange(400)
    turns = np.tile([0.2, 0.8], 200) + 2.0 * math.pi * 3 * n
    assert str(fm.chaos.judge(turns, ["phi"], units=["rad"])) == "periodic-2"
    assert str(fm.chaos.judge(turns, ["phi"])) == "transient"
    assert str(fm.chaos.judge(0.7 * n, ["phi"], units=["rad"])) == "quasi-periodic"
    slow = fm.chaos.judge(0.002 * n, ["phi"], units=["rad"])
    assert named(slow, 0.002), slow.reason


@pytest.mark.slow
def test_what_does_not_drift_keeps_its_verdict(maps):
    """Closed curves near rational rotation numbers and slow ones, cycles, chaos in bands and without."""
    for rotation in (GOLDEN, 1.0 / 3.0 + 1e-3, 0.5 + 1.5e-3, 0.25 - math.pi / 1500.0, math.pi / 785.0, 0.0101):
        angle = maps["circle"](1000, rotation, 0.0)
        for points in (np.cos(angle)[:, None], np.column_stack([np.cos(angle), np.sin(angle)])):
            names = ["x", "y"][: points.shape[1]]
            found = fm.chaos.judge(points, names)
            assert str(found) == "quasi-periodic", (rotation, found.reason)
            assert str(fm.chaos.judge(points, names, exponent=1e-5, error=1e-3)) == "quasi-periodic"
    for r, kind in ((3.2, "periodic-2"), (3.566, "periodic-16"), (3.6, "chaotic"), (4.0, "chaotic")):
        assert str(fm.chaos.judge(maps["logistic"](1000, r)[:, None], ["x"])) == kind


# Exponents of zero without a closed curve.


@pytest.mark.parametrize(
    "count", [250, 400, pytest.param(1000, marks=pytest.mark.slow), pytest.param(3000, marks=pytest.mark.slow)]
)
def test_the_accumulation_of_doublings_is_inconclusive(maps, count):
    """The exponent is 0, the points a Cantor set: bands that double repeatedly."""
    points = maps["logistic"](count, FEIGENBAUM, skip=20000)[:, None]
    for exponent in (None, 1e-5, -3e-4, 3e-4):
        options = {} if exponent is None else {"exponent": exponent, "error": 1e-4}
        found = fm.chaos.judge(points, ["x"], **options)
        assert str(found) == "inconclusive", (count, options, str(found), found.reason)
        assert "doubl" in found.reason
        assert found.evidence["doublings"] >= 3


def standard(count, K, start):
    x, p, found = *start, []
    for _ in range(count):
        p += K * math.sin(x)
        x += p
        found.append((x, p))
    return np.array(found)


def test_an_island_of_the_standard_map_is_a_closed_curve():
    for start in ((math.pi + 0.5, 0.0), (math.pi - 0.9, 0.1)):
        points = standard(1000, 0.8, start)
        assert (
            str(fm.chaos.judge(points, ["x", "p"], units=["rad", "rad"], exponent=3e-3, error=4e-3)) == "quasi-periodic"
        )


@pytest.mark.slow
def test_the_sea_of_the_standard_map():
    """Chaotic where action and angle count modulo a turn; else the action walks away, which is never quasi-periodic."""
    for start in ((0.1, 0.2), (1.0, 0.0), (3.0, 2.0)):
        points = standard(1000, 7.0, start)
        known = {"exponent": 1.26, "error": 0.02}
        assert str(fm.chaos.judge(points, ["x", "p"], units=["rad", "rad"], **known)) == "chaotic"
        walking = fm.chaos.judge(points, ["x", "p"], units=["rad", ""], **known)
        assert str(walking) in ("transient", "inconclusive", "chaotic")
        assert "rad" in walking.reason or str(walking) == "chaotic"


def test_growth_like_a_power_of_time_is_named():
    """Neighbours of noise with an exponent of zero: no closed curve, so nothing is decided, and the reason says why."""
    points = np.random.default_rng(3).standard_normal((1000, 2))
    found = fm.chaos.judge(points, ["x", "y"], exponent=1e-3, error=2e-3)
    assert str(found) == "inconclusive"
    assert "zero" in found.reason
    assert "conservative" in found.reason
