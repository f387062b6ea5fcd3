"""Phase and amplitude that steps lose are told as large as they are."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.findings.vibrations import loss_of
from flexmb.mechanisms.slider_crank import SliderCrankData

O = (0.0, 0.0)


def oscillator(omega, x=0.01, damping=0.0):
    """A mass on a spring, set off with a velocity."""
    mass = fm.RigidBody("mass", O, 1.0, 0.1, velocity=(x * omega, 0.0, 0.0))
    guide = fm.Prismatic("guide", fm.GROUND, mass, at=O, along=(1, 0))
    spring = fm.SpringDamper("spring", fm.GROUND, mass, (-1.0, 0.0), O, stiffness=omega**2, damping=damping)
    return fm.Mechanism("oscillator", [mass, guide, spring])


def shaken(motion, damping=0.0):
    """A mass on a spring whose other end is moved: 192 rad/s with the drive held fast."""
    cart, mass = fm.RigidBody("cart", (-1.0, 0.0), 1.0, 0.1), fm.RigidBody("mass", O, 1.0, 0.1)
    rails = [fm.Prismatic(f"on {b.name}", fm.GROUND, b, at=b.at, along=(1, 0)) for b in (cart, mass)]
    spring = fm.SpringDamper("spring", cart, mass, cart.at, O, stiffness=192.0**2, damping=damping)
    return fm.Mechanism("shaken", [cart, mass, *rails, spring, fm.Drive("shaker", "on cart", motion)])


def notes_on_vibrations(sol):
    """Remarks of the estimate."""
    return [note for note in sol.notes if "The vibration of" in note or "begins with a vibration" in note]


METHODS = [
    fm.Newmark.generalised_alpha(), fm.Newmark.hht(0.1), fm.Newmark.trapezoidal(), fm.RungeKutta4(), fm.RadauIIA(),
]  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
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


def test_a_long_driven_vibration_is_noted_as_large_as_it_is():
    """A base that starts to swing at once leaves an undamped vibration beside the one that follows it."""
    speed, omega, span = 3.0, 192.0, 40.0
    sol = fm.simulate(shaken(fm.drives.Harmonic(0.01, speed)), t_end=span)
    (note,) = notes_on_vibrations(sol)
    lag = float(note.split("lose some ")[1].split(" rad")[0])
    # x = A (w^2 sin(W t) - W w sin(w t))/(w^2 - W^2), for a base at A sin(W t)
    factor = 0.01 / (omega**2 - speed**2)
    late = sol.time > span - 0.5
    t, x = sol.time[late], sol["mass.x"].values[late]
    free = (x - factor * omega**2 * np.sin(speed * t)) / (-factor * speed * omega)
    cosine, sine = np.linalg.lstsq(np.column_stack([np.cos(omega * t), np.sin(omega * t)]), free, rcond=None)[0]
    assert math.atan2(-cosine, sine) % (2.0 * math.pi) == pytest.approx(lag % (2.0 * math.pi), abs=0.2 * lag)
    assert lag > 0.5


def test_a_vibration_that_follows_its_drive_is_not_noted():
    """Damped, started softly, or driven slower or faster than it vibrates: nothing accumulates."""
    for motion, damping, span in (
        (fm.drives.Harmonic(0.01, 3.0), 40.0, 10.0),
        (fm.drives.CycloidalRamp(1.0, 1.0), 0.0, 20.0),
    ):
        assert not notes_on_vibrations(fm.simulate(shaken(motion, damping), t_end=span))


@pytest.mark.parametrize(("damping", "steps", "told"), [(0.0, 1000, "lose"), (1e-6, 100, "begins"), (1e-6, None, "")])
def test_a_flexible_slider_crank_with_coarse_steps(damping, steps, told):
    """A rod without damping keeps its vibration; one with damping is off while it dies out, 24 % in the torque."""
    crank = fm.mechanisms.slider_crank(data=SliderCrankData(damping=damping), flexible=True)
    sol = fm.simulate(crank, periods=2, step=0.012 / steps if steps else None)
    assert sol.ok
    assert [told in note for note in notes_on_vibrations(sol)] == ([True] if told else []), sol.notes


def test_a_fine_or_short_or_damped_vibration_is_not():
    for mech, options in (
        (oscillator(192.0), {"t_end": 0.03, "step": 1e-5}),
        (oscillator(192.0, damping=40.0), {"t_end": 2.0}),
        (oscillator(192.0, x=0.0), {"t_end": 2.0}),
    ):
        assert not notes_on_vibrations(fm.simulate(mech, **options))


def test_a_restart_counts_its_own_steps():
    """The second half of a run loses half of the phase."""
    mech = oscillator(192.0)
    first = fm.simulate(mech, t_end=20.0, step=1e-3)
    again = fm.simulate(mech, t_end=40.0, step=1e-3, restart=first.restart)
    assert [n.split("lose some")[1] for n in again.notes] == [n.split("lose some")[1] for n in first.notes]
