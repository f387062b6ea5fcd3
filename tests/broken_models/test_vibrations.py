"""Phase and amplitude that steps lose are told as large as they are."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.run.vibrations import loss_of

O = (0.0, 0.0)


def oscillator(omega, x=0.01, damping=0.0):
    """A mass on a spring, set off with a velocity."""
    mass = fm.RigidBody("mass", O, 1.0, 0.1, velocity=(x * omega, 0.0, 0.0))
    guide = fm.Prismatic("guide", fm.GROUND, mass, at=O, along=(1, 0))
    spring = fm.SpringDamper("spring", fm.GROUND, mass, (-1.0, 0.0), O, stiffness=omega**2, damping=damping)
    return fm.Mechanism("oscillator", [mass, guide, spring])


@pytest.mark.parametrize("method", [fm.Newmark.generalised_alpha(), fm.Newmark.hht(0.1), fm.Newmark.trapezoidal()])
@pytest.mark.parametrize("step", [0.02, 0.1])
def test_loss_of_a_run(method, step):
    """The loss predicted is that of a run with these steps, by its phase and amplitude at the end."""
    omega, steps = 3.0, 400
    sol = fm.simulate(oscillator(omega), t_end=steps * step, step=step, save="steps", method=method)
    x, v = sol["mass.x"].values, sol["mass.vx"].values
    z = omega * x + 1j * v  # starts at i omega x0 and turns with exp(-i omega t)
    phase = np.unwrap(np.angle(z[1:] / z[:-1])).sum() + omega * steps * step
    found = loss_of(method, omega, step, steps)
    assert phase == pytest.approx(found.phase, rel=0.02, abs=0.02)
    amplitude = 1.0 - np.abs(z[-20:]).max() / np.abs(z[:20]).max()
    assert amplitude == pytest.approx(found.amplitude, rel=0.1, abs=0.01)


def test_the_trapezoidal_rule_keeps_amplitudes():
    """tan(phi/2) = omega h/2 is its exact dispersion."""
    h, omega = 0.3, 2.0
    found = loss_of(fm.Newmark.trapezoidal(), omega, h, 1)
    assert found.amplitude == pytest.approx(0.0, abs=1e-14)
    assert found.phase == pytest.approx(omega * h - 2.0 * math.atan(0.5 * omega * h), rel=1e-12)


def test_a_long_vibration_is_noted():
    """192 rad/s for 100 s with default steps."""
    sol = fm.simulate(oscillator(192.0), t_end=100.0)
    assert any("The vibration of 30.56 Hz (mostly mass.x)" in note and "of its phase" in note for note in sol.notes)


def test_a_fine_or_short_or_damped_vibration_is_not():
    for mech, options in (
        (oscillator(192.0), {"t_end": 0.03, "step": 1e-5}),
        (oscillator(192.0, damping=40.0), {"t_end": 2.0}),
        (oscillator(192.0, x=0.0), {"t_end": 2.0}),
    ):
        assert not [note for note in fm.simulate(mech, **options).notes if "vibration" in note]
