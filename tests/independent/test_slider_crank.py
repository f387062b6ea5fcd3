"""The slider-crank of flexmb with a worn piston pin against a hand-written integrator that shares no line with it.

5000 rpm, 0.5 mm of play: point by point before chaos tells two computations apart, then by means over turns and by the
largest Lyapunov exponent.  Errors are standard errors from means of blocks of turns, which allow for correlation.
"""

import dataclasses
import functools
import math

import numpy as np
import pytest
import slider_crank as own
from averages import mean_and_error

import flexmb as fm
from flexmb.mechanisms import SliderCrankData

VARIANT, LEAST = own.PRINTED, 1e-6
"""The reference speed of flexmb's contact law, and its lower bound [m/s]."""

OMEGA, CLEARANCE, STEP = 5000 * math.pi / 30, 0.5e-3, 2e-7
TURN = 2 * math.pi / OMEGA
SETTLE, TURNS, BLOCKS = 40, 200, 20
FINE = fm.Adaptive(rtol=1e-6)


def data(clearance=CLEARANCE, *, mu=0.0, variant=VARIANT, least=LEAST, held=1.0, **changes):
    numbers = dataclasses.replace(SliderCrankData(), **changes)
    return own.data_of(numbers, clearance, OMEGA, variant=variant, least=least, held=held, mu=mu)


def carried(p, end, step, begin=0.0):
    """State, memory and signals after a run from the centred journal."""
    y, memory, signals = own.start(p), np.zeros(2), np.zeros(10)
    own.go(begin, end, step, y, memory, signals, p)
    return y, memory, signals


def positions(p, step, count):
    """The slider at so many hundredths of a turn."""
    y, memory, signals = own.start(p), np.zeros(2), np.zeros(10)
    x = [y[1]]
    for i in range(count):
        own.go(i * TURN / 100, (i + 1) * TURN / 100, step, y, memory, signals, p)
        x.append(y[1])
    return np.array(x)


@pytest.mark.slow
@pytest.mark.parametrize("variant", [own.PRINTED, own.LARGEST])
@pytest.mark.parametrize("mu", [0.0, 0.03])
def test_error_of_the_integrator_falls_at_least_with_the_square_of_the_step(mu, variant):
    """One millisecond: 5/2 for a force that begins like t^(3/2), 2 where a largest speed falls between two steps."""
    p = data(mu=mu, variant=variant)
    coarse, fine, x = (carried(p, 1e-3, step)[0][1] for step in (1.6e-6, 5e-8, 5e-9))
    assert abs(fine - x) < 1e-10
    assert abs(coarse - x) > 32**2 * abs(fine - x)


PEAKS = {own.PRINTED: 45872.0, own.LARGEST: 45884.0, own.HELD: 45872.0}
"""Largest force of the first impact [N]; the crank pushes a little faster than the surfaces met."""


@pytest.mark.parametrize("variant", PEAKS)
def test_first_impact(variant):
    _, memory, signals = carried(data(variant=variant, held=4.385783), 3.5e-4, 2e-8)
    assert memory[0] == 0.0
    assert signals[3] == 1.0
    assert signals[8] == pytest.approx(4.385783, abs=1e-6)
    assert signals[0] == pytest.approx(PEAKS[variant], abs=1.0)


def test_energy_of_an_elastic_contact_is_work_of_the_drive():
    p = data(restitution=1.0)
    assert p.chi == 0.0
    y, memory, signals = carried(p, 2 * TURN, 5e-8)
    assert signals[3] > 20
    assert y[5] == 0.0
    rest = own.energy(2 * TURN, y, memory, p) - own.energy(0.0, own.start(p), np.zeros(2), p)
    assert abs(rest) < 1e-6  # of 140 J in motion


@pytest.mark.quick(1)
@pytest.mark.parametrize("variant", [own.PRINTED, own.LARGEST])
def test_losses_close_the_balance_with_damping_and_friction(variant):
    p = data(mu=0.03, variant=variant)
    y, memory, signals = carried(p, 2 * TURN, 5e-8)
    assert y[5] > 1.0
    rest = own.energy(2 * TURN, y, memory, p) - own.energy(0.0, own.start(p), np.zeros(2), p)
    assert abs(rest) < 1e-6


@pytest.mark.slow
def test_stiff_damping_is_followed_by_implicit_steps():
    """A held reference speed of 0.1 mm/s: explicit steps of 20 ns are stable, those of 200 ns would not be."""
    p = data(1e-4, variant=own.HELD, held=1e-4)
    coarse, fine = (carried(p, 0.5 * TURN, step)[0] for step in (2e-7, 2e-8))
    assert coarse[1] == pytest.approx(fine[1], abs=1e-9)
    assert coarse[3] == pytest.approx(fine[3], abs=1e-4)


@pytest.mark.quick(1)
@pytest.mark.parametrize(("mu", "step", "power"), [(0.0, 4e-8, 1.6), (0.03, 2e-8, 0.8)])
def test_half_a_turn_point_by_point(mu, step, power):
    """The square of its step is what flexmb comes closer with; with friction, which turns within a step, the step.

    Chaos makes the distance 100 times as large until the turn is over: there the integrator itself is precise to 1e-8 m
    (here to 1e-10 m), after two turns to 1e-4 m.
    """
    p = data(mu=mu)
    friction = fm.ModifiedCoulomb(mu, v0=p.v0, v1=p.v1) if mu else None
    mechanism, x = fm.mechanisms.slider_crank(OMEGA, clearance=CLEARANCE, friction=friction), positions(p, 2e-8, 50)
    errors = []
    for h in (2 * step, step):
        sol = fm.simulate(mechanism, t_end=0.5 * TURN, save=50, step=h, method=fm.Newmark.trapezoidal())
        assert sol.ok, sol.status
        assert np.allclose(sol.time, np.arange(51) * TURN / 100, rtol=0.0, atol=1e-15)
        errors.append(np.abs(sol.array("slider.x") - x).max())
    assert errors[1] < 1e-7
    assert errors[0] > 2.0**power * errors[1]


@functools.cache
def own_turns():
    """Signals of the settled turns, by name."""
    p = data()
    y, memory = own.start(p), np.zeros(2)
    own.turns(0, SETTLE, STEP, y, memory, p)
    signals, _ = own.turns(SETTLE, TURNS, STEP, y, memory, p)
    return dict(zip(own.SIGNALS, signals.T, strict=True))


@functools.cache
def flexmb_turns():
    """The same of flexmb, from every accepted step."""
    mechanism = fm.mechanisms.slider_crank(OMEGA, clearance=CLEARANCE)
    sol = fm.simulate(mechanism, periods=SETTLE + TURNS, save_from_period=SETTLE, save="steps", step=FINE)
    assert sol.ok, sol.status
    turn = np.clip(np.floor(sol.time / TURN - SETTLE + 1e-9).astype(int), 0, TURNS - 1)
    open_steps = np.diff(sol.time, prepend=sol.time[0]) * (sol.array("B.penetration") <= 0.0)
    force, acceleration = np.zeros(TURNS), np.zeros(TURNS)
    np.maximum.at(force, turn, sol.array("B.normal_force"))
    np.maximum.at(acceleration, turn, np.abs(sol.array("slider.ax")))
    flight = np.bincount(turn, open_steps, TURNS) / TURN
    return {"peak_force": force, "peak_acceleration": acceleration, "flight": flight}


@pytest.mark.slow
@pytest.mark.parametrize("signal", ["peak_force", "peak_acceleration", "flight"])
def test_means_over_turns_agree(signal):
    (a, da), (b, db) = (mean_and_error(found()[signal], BLOCKS) for found in (own_turns, flexmb_turns))
    assert max(da, db) < 0.1 * a
    assert abs(a - b) < 3.0 * math.hypot(da, db)


@pytest.mark.slow
def test_exponents_agree():
    p = data()
    y, memory = own.start(p), np.zeros(2)
    own.turns(0, SETTLE, STEP, y, memory, p)
    value, error = mean_and_error(own.growth(SETTLE, TURNS, STEP, y, memory, p, 1e-10)[TURNS // 10 :] / TURN)
    found = fm.lyapunov(fm.mechanisms.slider_crank(OMEGA, clearance=CLEARANCE), skip=SETTLE, periods=TURNS, step=FINE)
    assert value > 10.0 * error
    assert abs(value - found.value) < 3.0 * math.hypot(error, found.error)
