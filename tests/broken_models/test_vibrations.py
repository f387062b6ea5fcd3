"""Phase and amplitude that steps lose are told as large as they are."""

import math
import pickle

import numpy as np
import pytest

import flexmb as fm
from flexmb.findings import watch
from flexmb.findings.watch import UNRESOLVED, loss_of
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


@pytest.mark.parametrize("method", METHODS)
def test_slower_vibrations_lose_less(method):
    """A bound of all frequencies bounds all losses as long as steps resolve it."""
    omegas = np.linspace(1e-3, UNRESOLVED, 200)
    lost = np.abs([loss_of(method, omega, 1.0, 1.0) for omega in omegas])
    assert (np.diff(lost, axis=0) >= -1e-14).all()


def test_the_bound_is_above_all_frequencies():
    """Chains that hang and lie, alone and on springs: omega^2 of the modes about the states of a run."""
    from flexmb.statics.modes import Examination, fastest_bound

    for stiffness in (0.0, 300.0):
        looked = looked_at(hanging_chain(stiffness), t_end=0.5)
        states, examined = looked.states(range(len(looked.times))), 0
        for state in states:
            for found in Examination(looked.program, 1e-4).groups([state]):
                assert 0.1 * fastest_bound(looked.program, [state]) < found.modes.omega.max()
                assert found.modes.omega.max() <= fastest_bound(looked.program, [state])
                examined += 1
        assert examined > 3
    assert np.isinf(fastest_bound(*flexible_states()))


def hanging_chain(stiffness):
    """Four links that fall from the horizontal, the last one on a spring."""
    links = [fm.RigidLink(f"l{k}", (0.1 * k, 0.0), (0.1 * (k + 1), 0.0), 0.1, 1e-4) for k in range(4)]
    pins = [fm.Revolute(f"p{k}", links[k - 1] if k else fm.GROUND, links[k], at=(0.1 * k, 0.0)) for k in range(4)]
    spring = fm.SpringDamper("spring", fm.GROUND, links[-1], (0.4, 0.3), (0.4, 0.0), stiffness=stiffness, damping=0.0)
    parts = [*links, *pins, *([spring] if stiffness else [])]
    return fm.Mechanism("chain", parts, gravity=(0.0, -9.81))


def looked_at(mech, **options):
    """What a run keeps for the examination."""
    return fm.simulate(mech, **options).late.args[0]


def flexible_states():
    """Program and states of a flexible slider-crank, whose masses are coupled."""
    looked = looked_at(fm.mechanisms.slider_crank(flexible=True), periods=0.1)
    return looked.program, looked.states([0])


@pytest.mark.slow
def test_findings_are_the_same_whenever_they_are_asked_for(tmp_path):
    """At once, after other runs, from another process and from a file."""
    sol, again = (fm.simulate(oscillator(192.0), t_end=20.0) for _ in range(2))
    assert len(sol.notes) == 1
    fm.simulate(oscillator(5.0), t_end=1.0)
    assert pickle.loads(pickle.dumps(again)).notes == sol.notes  # noqa: S301, made in this line
    assert again.findings == sol.findings
    last = fm.simulate(oscillator(192.0), t_end=20.0)
    last.to_netcdf(tmp_path / "last.nc")
    assert fm.load(tmp_path / "last.nc").notes == sol.notes == last.notes


def test_a_run_that_nobody_asks_is_not_examined(monkeypatch):
    sol = fm.simulate(oscillator(192.0), t_end=2.0)
    monkeypatch.setattr(watch, "_are_resolved", None)
    assert sol.ok
    with pytest.raises(TypeError):
        _ = sol.notes


def test_two_equal_vibrations_are_not_one_that_loses_twice():
    """Two oscillators side by side lose what each loses."""
    parts = []
    for name in ("one", "other"):
        mass = fm.RigidBody(name, O, 1.0, 0.1, velocity=(1.92, 0.0, 0.0))
        guide = fm.Prismatic(f"guide of {name}", fm.GROUND, mass, at=O, along=(1, 0))
        spring = fm.SpringDamper(f"spring of {name}", fm.GROUND, mass, (-1.0, 0.0), O, stiffness=192.0**2, damping=0.0)
        parts += [mass, guide, spring]
    pair = fm.simulate(fm.Mechanism("pair", parts), t_end=20.0, step=1e-3)
    alone = fm.simulate(oscillator(192.0), t_end=20.0, step=1e-3)
    lost = [[f.numbers["phase"] for f in sol.findings if f.code == "lost-vibration"] for sol in (pair, alone)]
    assert lost[0] == pytest.approx(lost[1], rel=1e-3)


def test_the_trapezoidal_rule_keeps_amplitudes():
    """tan(phi/2) = omega h/2 is its exact dispersion."""
    h, omega = 0.3, 2.0
    found = loss_of(fm.Newmark.trapezoidal(), omega, h, 1)
    assert found.amplitude == pytest.approx(0.0, abs=1e-14)
    assert found.phase == pytest.approx(omega * h - 2.0 * math.atan(0.5 * omega * h), rel=1e-12)


@pytest.mark.slow
def test_a_long_vibration_is_noted():
    """192 rad/s for 100 s with default steps."""
    sol = fm.simulate(oscillator(192.0), t_end=100.0)
    assert any("The vibration of 30.56 Hz (mostly mass.x)" in note and "of its phase" in note for note in sol.notes)


@pytest.mark.slow
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
