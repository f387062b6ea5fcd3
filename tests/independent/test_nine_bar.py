"""The rigid nine-bar mechanism with play beside an integrator of its own (nine_bar.py)."""

import math

import nine_bar as own
import numpy as np
import pytest
from averages import mean_and_error

import flexmb as fm
from flexmb.mechanisms import NineBarData, nine_bar
from flexmb.mechanisms.nine_bar import NineBarPose

DATA = NineBarData()
RULES = {"onset": own.PRINTED, "largest": own.LARGEST}
LEAST = 1e-6
SKIP, TURNS, BLOCKS, PERIODS = 8, 60, 12, 100
LOOKS, APART, FINE = 50, 1e-7, 5e-7
"""How often in a turn a neighbour is put back, its distance [rad], and steps for it [s].

Contacts make 1e-10 of round-off, by which exponents of neighbours 1e-9 rad apart are too large by 2 1/s.  Steps of
5e-6 s leap over the corners of friction and reference speed, by which they are too large by 1 to 3 1/s.
"""

QUANTITIES = ("peak force", "peak acceleration of the slider", "share of free flight")

CASES = [
    (2.0, 0.05e-3, "onset", 1e-5),
    (2.0, 0.5e-3, "onset", 1e-5),
    (2.5, 0.5e-3, "onset", 1e-5),
    (2.0, 0.05e-3, "largest", 1e-6),
    (2.0, 0.5e-3, "largest", 1e-6),
]
"""Speed over pi [rad/s], clearance [m], reference speed, tolerance (finer where turns are nearly alike)."""


def model(speed, clearance, rule="onset", ramp=2.0, data=DATA):
    """The model of the integrator, its state at the start; ramp : turns of the start from rest."""
    w = speed * math.pi
    p = own.model_of(data, w, clearance, rule=RULES[rule], least=LEAST, ramp=ramp * 2.0 * math.pi / w)
    pose = NineBarPose.at(DATA, 0.0, 0.0)
    a = math.atan2(pose.B[1] - pose.P4[1], pose.B[0] - pose.P4[0])
    b = math.atan2(pose.B[1] - pose.P1[1], pose.B[0] - pose.P1[0])
    return p, np.array([a, b, 0.0, 0.0])


def mechanism(speed, clearance, rule="onset"):
    data = NineBarData(least_approach=LEAST, reference_speed=rule)
    return nine_bar(speed * math.pi, clearance=clearance, ramp=2.0 * 2.0 / speed, data=data)


def by_integrator(speed, clearance, rule, h=1e-6, skip=SKIP, turns=TURNS):
    """Rows (turns, 3) of `QUANTITIES`."""
    p, y = model(speed, clearance, rule)
    rows = np.zeros((skip + turns, 6))
    own.turns(p, y, 0.0, h, 0, skip + turns, rows)
    return rows[skip:, :3]


def by_library(speed, clearance, rule, rtol=1e-5, skip=SKIP, turns=TURNS):
    """The same."""
    mech, state, rows, T = mechanism(speed, clearance, rule), None, [], 2.0 / speed
    for k in range(1, skip + turns + 1):
        sol = fm.simulate(mech, t_end=k * T, save="steps", restart=state, step=fm.Adaptive(rtol=rtol, max=2e-4))
        assert sol.ok, sol.status
        state = sol.restart
        if k > skip:
            depth = sol.array("P1.penetration")
            flight = np.diff(sol.time)[depth[1:] < 0.0].sum() / T
            rows.append((sol.peak("P1.normal_force").value, sol.peak("slider.ax").value, flight))
    return np.array(rows)


@pytest.mark.slow
@pytest.mark.parametrize("rule", [pytest.param("onset", marks=pytest.mark.slow), "largest"])
def test_first_motion_point_by_point(rule):
    """Start from rest, journal in its middle: 50 ms of fall, first impacts and sliding, before chaos."""
    p, y = model(2.0, 0.5e-3, rule)
    h, w, times, places = 1e-6, 0.0, [], []
    for i in range(50_000):
        w, _ = own.step(p, i * h, h, y, w)
        if i % 1000 == 999:
            times.append((i + 1) * h)
            places.append(own.closures(p, times[-1], y[:2])[8])
    sol = fm.simulate(mechanism(2.0, 0.5e-3, rule), t_end=0.05, save=50, step=fm.Adaptive(rtol=1e-9, max=2e-5))
    assert sol.ok, sol.status
    assert len(sol.episodes("P1")) >= 5
    assert sol.time[1:] == pytest.approx(times, abs=1e-15)
    assert sol.array("slider.x")[1:] == pytest.approx(places, abs=5e-9)


@pytest.mark.slow
def test_order_of_the_integrator():
    """Without contact, errors of half the step are a sixteenth."""
    wide, found = NineBarData(bearing_radius=0.2), []
    for n in (25, 50, 100):
        p, y = model(2.0, 0.1, data=wide)  # so much play that nothing touches
        for i in range(n):
            own.step(p, i * 0.05 / n, 0.05 / n, y, 0.0)
        found.append(y)
    assert np.abs(found[1] - found[0]).max() / np.abs(found[2] - found[1]).max() == pytest.approx(16.0, rel=0.15)


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "clearance", "rule", "rtol"), CASES)
def test_means_over_turns(speed, clearance, rule, rtol):
    """Turns that are nearly alike remember one another for longer than a block: two runs tell how far means scatter."""
    runs = [by_library(speed, clearance, rule, part * rtol).T for part in (1.0, 0.98)]
    for name, ours, again, theirs in zip(QUANTITIES, *runs, by_integrator(speed, clearance, rule).T, strict=True):
        (a, wide), (other, _), (b, width) = [mean_and_error(one, BLOCKS) for one in (ours, again, theirs)]
        a, wide = 0.5 * (a + other), max(wide, 0.5 * abs(a - other))
        error = math.hypot(wide, width)
        print(f"{speed} pi, {1e3 * clearance:g} mm, {rule}: {name} {a:.5g}, integrator {b:.5g}, error {error:.2g}")
        assert abs(a - b) <= 3.0 * error, name


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "clearance", "rule", "rtol"), CASES)
def test_exponents(speed, clearance, rule, rtol):
    p, y = model(speed, clearance, rule)
    w = own.turns(p, y, 0.0, 5e-6, 0, 20, np.zeros((20, 6)))
    logs = np.zeros(PERIODS)
    own.growth(p, y, w, FINE, 20, PERIODS, LOOKS, APART, logs)
    wanted, wide = mean_and_error(logs[PERIODS // 10 :] * 0.5 * speed)
    flow = fm.chaos.MechanismFlow(
        mechanism(speed, clearance, rule), step=fm.Adaptive(rtol=rtol, max=2e-4), period=2.0 / speed
    )
    found = fm.lyapunov(flow, skip=20, periods=PERIODS, confirm=False)
    both = f"{found.value:.4g} +- {found.error:.2g}, integrator {wanted:.4g} +- {wide:.2g}"
    text = f"{speed} pi, {1e3 * clearance:g} mm, {rule}: {both}"
    print(text)
    assert abs(found.value - wanted) <= 3.0 * math.hypot(found.error, wide), text


def growth_of_neighbours(p, t, span, y, direction, apart, weights, h=2e-7):
    """Logarithm of the growth of a small difference in free flight at t [s], in a time `span` [s]."""
    ends = []
    for sign in (1.0, -1.0):
        z = y + sign * apart * direction
        own.follow(p, t, h, round(span / h), z, 0.0)
        ends.append(z)
    return math.log(np.linalg.norm(weights * (ends[0] - ends[1])) / (2.0 * apart))


@pytest.mark.slow
@pytest.mark.parametrize("rule", RULES)
def test_growth_of_small_differences(rule):
    """Tangents beside neighbours of the integrator on the same 100 pieces of chaotic motion."""
    p, begin = model(2.0, 0.5e-3, rule)
    flow, fine = [
        fm.chaos.MechanismFlow(mechanism(2.0, 0.5e-3, rule), step=fm.Adaptive(rtol=rtol, max=longest), period=1.0)
        for rtol, longest in ((1e-6, 2e-4), (1e-9, 1e-5))
    ]
    place = [flow.state_names[f"{link}.{x}"] for x in ("theta", "omega") for link in ("link3", "link2")]
    turned, weights = begin[:2] - flow.state()[place[:2]], np.array([1.0, 1.0, 0.5 / math.pi, 0.5 / math.pi])
    W, span, found = flow.tangent_basis(1, seed=1), 0.0137, []
    flow.advance(8.0)
    while len(found) < 100:
        flow.advance(span, W)
        W /= np.linalg.norm(weights * W[place, 0])
        y, t = flow.state()[place], flow.time
        y[:2] += turned
        if own.motion(p, t, y[:2], y[2:], 0.0)[3] > -1e-7:
            continue  # in contact, or nearly
        far, near = [growth_of_neighbours(p, t, span, y, W[place, 0], apart, weights) for apart in (1e-7, 1e-8)]
        if abs(far - near) > 0.05:
            continue  # a contact that nearly ends the difference, and leaves its round-off
        carried = W.copy()
        fine.reset(flow.state(), time=t)
        fine.advance(span, carried)
        found.append((math.log(np.linalg.norm(weights * carried[place, 0])), far))
    ours, theirs = np.array(found).T
    print(rule, "ln growth", ours.sum(), "integrator", theirs.sum(), "largest difference", np.abs(ours - theirs).max())
    assert theirs.sum() > 50.0
    assert ours.sum() == pytest.approx(theirs.sum(), rel=5e-3)
    assert np.abs(ours - theirs).max() < 0.2
    assert np.median(np.abs(ours - theirs)) < 3e-3


@pytest.mark.slow
def test_threshold_speed():
    """The speed at which the contact breaks for the first time, 0.5 mm: both say the same within 0.0125 pi rad/s."""
    grid = np.arange(1.575, 1.66, 0.0125)
    unbroken = [
        [rows(speed, 0.5e-3, "onset", skip=30, turns=6)[:, 2].max() == 0.0 for speed in grid]
        for rows in (by_integrator, by_library)
    ]
    last = [float(grid[np.flatnonzero(flags)[-1]]) for flags in unbroken]
    print("last unbroken speeds", last)
    assert abs(last[0] - last[1]) <= 0.0126
