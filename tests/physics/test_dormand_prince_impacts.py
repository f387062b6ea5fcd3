"""Impacts with the method of Dormand and Prince: closed forms, a worn joint, ledger, events, peaks, restarts."""

import math
import runpy
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import flexmb as fm
from flexmb.errors import InputError

METHOD = fm.DormandPrince()
PLAY, SPEED_OF_PIN = 1e-3, 1.0


def thrown(law, *, t_end=0.005, rtol=1e-6, speed=SPEED_OF_PIN, **options):
    """A pin of 1 kg that flies to and fro in its bearing."""
    pin = fm.RigidBody("pin", at=(0.0, 0.0), mass=1.0, inertia=1.0, velocity=(speed, 0.0, 0.0))
    joint = fm.RevoluteClearance("J", fm.GROUND, pin, (0.0, 0.0), clearance=PLAY, bearing_radius=0.1, normal=law)
    step = options.pop("step", fm.Adaptive(rtol=rtol))
    sol = fm.simulate(fm.Mechanism("thrown", [pin, joint]), t_end=t_end, method=METHOD, step=step, **options)
    assert sol.ok, sol.status
    return sol


def place(t, omega):
    """Where the pin is between two elastic walls, whose spring has the angular frequency omega, and its speed."""
    flight, contact = PLAY / SPEED_OF_PIN, math.pi / omega
    sign, left = 1.0, t + flight  # as if it had come from the other wall
    while left > 2.0 * flight + contact:
        sign, left = -sign, left - 2.0 * flight - contact
    if left <= 2.0 * flight:
        return sign * (left - flight) * SPEED_OF_PIN, sign * SPEED_OF_PIN
    angle = omega * (left - 2.0 * flight)
    return sign * (PLAY + SPEED_OF_PIN / omega * math.sin(angle)), sign * SPEED_OF_PIN * math.cos(angle)


# Closed forms


@pytest.mark.parametrize("save", ["steps", 397])
def test_elastic_impacts_are_those_of_the_closed_form_at_steps_and_between(save):
    omega = 1e4
    sol = thrown(fm.KelvinVoigt(omega**2, 0.0), t_end=0.0099, rtol=1e-8, save=save)
    exact = np.array([place(t, omega) for t in sol.time])
    assert len(sol.episodes("J")) == 4
    assert np.abs(sol.array("pin.x") - exact[:, 0]).max() < 1e-10
    assert np.abs(sol.array("pin.vx") - exact[:, 1]).max() < 1e-6
    depth = np.maximum(np.abs(exact[:, 0]) - PLAY, 0.0)
    assert np.abs(sol.array("J.normal_force") - omega**2 * depth).max() < 1e-6 * omega


def test_errors_fall_with_rtol():
    omega, found = 1e4, []
    for rtol in (1e-4, 1e-6, 1e-8):
        sol = thrown(fm.KelvinVoigt(omega**2, 0.0), t_end=0.0099, rtol=rtol, save=1)
        found.append(abs(sol.array("pin.x")[-1] - place(0.0099, omega)[0]))
    assert found[0] < 5e-7
    assert found[2] < 1e-10
    assert found[2] < found[1] < found[0]


@pytest.mark.parametrize("rtol", [1e-4, 1e-6])
def test_elastic_impacts_lose_no_energy_beyond_rtol(rtol):
    """An oscillator that meets a stiff spring in 14 swings: steps end close to onset and separation."""
    block = fm.RigidBody("b", at=(0.0, 0.0), mass=1.0, inertia=0.1, velocity=(1.0, 0.0, 0.0))
    guide = fm.Prismatic("g", fm.GROUND, block)
    spring = fm.SpringDamper("s", fm.GROUND, block, (-1e3, 0.0), (0.0, 0.0), stiffness=1.0)
    stop = fm.Stop("stop", "g", above=0.3, normal=fm.KelvinVoigt(1e9, 0.0))
    mech = fm.Mechanism("swing", (block, guide, spring, stop))
    sol = fm.simulate(mech, t_end=50.0, save=1, method=METHOD, step=fm.Adaptive(rtol=rtol))
    energy = 0.5 * (sol.array("b.vx")[-1] ** 2 + sol.array("b.x")[-1] ** 2)
    assert sol.ok, sol.status
    assert len(sol.episodes("stop")) == 14
    assert abs(energy / 0.5 - 1.0) < 2.0 * rtol
    assert sol.stats.steps < 250


@pytest.mark.parametrize("share", [0.9, 0.999])
def test_a_stop_sees_a_level_that_is_passed_and_left_within_a_step(share):
    """F = v (k m)^(1/2) is 1e4 N; a step of an impact may have its largest force within."""
    stop = fm.when("J.normal_force", above=1e4 * share)
    sol = thrown(fm.KelvinVoigt(1e8, 0.0), t_end=0.0099, rtol=1e-4, stop=stop)
    assert "as asked for" in sol.status
    assert len(sol.episodes("J")) <= 1
    onset, angle = PLAY / SPEED_OF_PIN, math.asin(share)
    assert sol.time[-1] == pytest.approx(onset + 1e-4 * angle, abs=1e-6)


def test_events_are_no_nearer_than_round_off():
    """A pin at 20 m that meets a wall of 1e12 N/m: steps to the onset were shorter than what changes its gap."""
    pin = fm.RigidBody("pin", at=(20.0, 0.0), mass=1.0, inertia=1.0, velocity=(0.1, 0.0, 0.0))
    law = fm.KelvinVoigt(1e12, 0.0)
    joint = fm.RevoluteClearance("J", fm.GROUND, pin, pin.at, clearance=PLAY, bearing_radius=0.1, normal=law)
    step = fm.Adaptive(rtol=1e-8)
    sol = fm.simulate(fm.Mechanism("far", [pin, joint]), t_end=0.099, method=METHOD, step=step, max_steps=1000)
    assert sol.ok, sol.status
    assert sol.episodes("J").restitution == pytest.approx(np.ones(5), rel=1e-6)


def test_steps_of_an_impact_are_few_or_as_many_as_asked_for():
    def inside(step):
        sol = thrown(fm.KelvinVoigt(1e8, 0.0), t_end=0.0099, step=step, save="steps")
        assert len(sol.episodes("J")) == 4
        return (sol.array("J.normal_force") > 0.0).sum() / 4

    assert 3.0 <= inside(fm.Adaptive()) <= 8.0  # ends of steps within
    assert 29.0 <= inside(fm.Adaptive(impact_steps=30)) <= 36.0


def test_an_impact_has_the_restitution_of_its_law():
    sol = thrown(fm.LankaraniNikravesh(stiffness=1e9, restitution=0.9), t_end=0.002, rtol=1e-4)
    hit = sol.episodes("J")[0]
    a = 0.75 * (1.0 - 0.9**2)
    exact = brentq(lambda e: a * (1.0 + e) - math.log((1.0 + a) / (1.0 - a * e)), 0.5, 1.0)  # `test_impact.py`
    assert hit.separation_speed == pytest.approx(exact, rel=2e-5)
    assert hit.dissipated_contact == pytest.approx(0.5 * (1.0 - hit.separation_speed**2), rel=1e-4)
    assert abs(sol.array("energy.residual")[-1]) < 1e-5
    assert sol.stats.steps < 150


def test_a_force_that_jumps_at_its_onset():
    """A linear damper beside the spring acts at once: x = v exp(-d t) sin(w t)/w behind the onset."""
    k, c = 1e8, 4e3
    d, onset = 0.5 * c, PLAY / SPEED_OF_PIN
    w = math.sqrt(k - d * d)
    sol = thrown(fm.KelvinVoigt(k, c), t_end=onset + 1e-4, rtol=1e-8, save=400)
    t = np.maximum(sol.time - onset, 0.0)
    exact = np.where(t > 0.0, PLAY + SPEED_OF_PIN * np.exp(-d * t) * np.sin(w * t) / w, SPEED_OF_PIN * sol.time)
    assert np.abs(sol.array("pin.x") - exact).max() < 1e-9


def test_peaks_lie_between_the_steps():
    """F = v (k m)^(1/2); the depth is v (m/k)^(1/2)."""
    sol = thrown(fm.KelvinVoigt(1e8, 0.0), t_end=0.0099, step=fm.Adaptive(impact_steps=7), save="steps")
    peak, force = sol.peak("J.normal_force"), sol.array("J.normal_force")
    assert peak.value == pytest.approx(1e4, rel=1e-3)
    assert peak.value >= force.max()
    assert min(abs(peak.time - time_of_crest(k)) for k in range(4)) < 2e-6
    by_steps = []
    for hit in sol.episodes("J"):
        assert hit.peak_force == pytest.approx(1e4, rel=3e-5)
        assert hit.peak_penetration == pytest.approx(1e-4, rel=3e-5)
        by_steps.append(force[(sol.time > hit.start) & (sol.time < hit.end)].max())
    assert min(by_steps) < 0.99e4  # the steps alone miss it


def test_impulse_and_depth_of_an_impact_are_found_between_its_steps():
    """The damper loses most before the deepest point, where its force is no longer the largest."""
    k, c = 1e8, 6e3
    hit = thrown(fm.KelvinVoigt(k, c, ramp=1e-7), t_end=0.002).episodes("J")[0]
    assert hit.impulse == pytest.approx(SPEED_OF_PIN + hit.separation_speed, rel=1e-5)
    z = 0.5 * c / math.sqrt(k)
    depth = math.exp(-z * math.acos(z) / math.sqrt(1.0 - z * z)) / math.sqrt(k)
    assert hit.peak_penetration == pytest.approx(depth, rel=4e-4)  # the ramp takes 3e-4


def time_of_crest(k, omega=1e4):
    """Instant of the largest force in impact k."""
    return PLAY / SPEED_OF_PIN + 0.5 * math.pi / omega + k * (2.0 * PLAY / SPEED_OF_PIN + math.pi / omega)


# The worn slider-crank: peak of 45825.04 N and slider at 1 ms as `minimal.worn_reference` of tests/speed has them


MODELS = runpy.run_path(str(Path(__file__).parents[1] / "speed" / "models.py"))


def worn(**options):
    sol = fm.simulate(MODELS["worn"](), t_end=1e-3, method=METHOD, **{"save": 1, **options})
    assert sol.ok or "max_steps" in options, sol.status
    return sol


def test_the_worn_slider_crank_is_that_of_an_independent_reference():
    found = []
    for rtol in (1e-3, 1e-6):
        sol = worn(step=fm.Adaptive(rtol=rtol))
        assert sol.peak("C.normal_force").value == pytest.approx(45825.04, rel=1e-4)
        found.append(abs(sol.array("slider.x")[-1] - 0.16097495))
        assert abs(sol.array("energy.residual")[-1]) < 10.0 * rtol * sol.array("energy.dissipated_contact")[-1] + 1e-6
    assert found[0] < 1e-7
    assert found[1] < 2e-8  # five of them may be the digits of the reference, 5e-9


def test_a_restart_amid_an_impact_goes_on_to_the_bit():
    begun = int(np.argmax(worn(save="steps").array("C.normal_force") > 0.0))
    half = worn(max_steps=begun + 2, save="steps")
    assert half.array("C.normal_force")[-1] > 0.0
    assert np.array_equal(worn(restart=half.restart).values[-1], worn().values[-1])


def test_saved_instants_change_no_step():
    assert np.array_equal(worn(save=3).values[-1], worn(save=301).values[-1])


# Other mechanisms, events, what is refused


def nudged():
    """A double pendulum, a tree of pins, whose lower link falls against a stop."""
    upper = fm.RigidLink("upper", (0.0, 0.0), (0.5, 0.0), 1.0, 0.02)
    lower = fm.RigidLink("lower", (0.5, 0.0), (1.0, 0.0), 1.0, 0.02)
    pins = fm.Revolute("A", fm.GROUND, upper, (0.0, 0.0)), fm.Revolute("B", upper, lower, (0.5, 0.0))
    stop = fm.Stop("stop", "A", below=-0.4, normal=fm.LankaraniNikravesh(2e3, restitution=0.8))
    return fm.Mechanism("nudged", (upper, lower, *pins, stop), gravity=(0.0, -9.81))


@pytest.mark.parametrize(
    ("mech", "t_end"), [(nudged(), 0.6), (fm.mechanisms.nine_bar(clearance=5e-4), 0.03)], ids=["tree", "loops"]
)
def test_mechanisms_with_impacts_as_radau_has_them(mech, t_end):
    sols = [
        fm.simulate(mech, t_end=t_end, method=method, step=fm.Adaptive(rtol=1e-8), save=20)
        for method in (METHOD, fm.RadauIIA())
    ]
    assert all(sol.ok for sol in sols), [sol.status for sol in sols]
    own, other = sols
    assert [len(sol.episodes()) for sol in sols] == 2 * [len(own.episodes())]
    assert len(own.episodes()) >= 1
    for body in (part.name for part in mech.parts if isinstance(part, fm.RigidBody)):
        assert np.abs(own.array(f"{body}.x") - other.array(f"{body}.x")).max() < 2e-7
    assert own.stats.steps < other.stats.steps


def test_a_trial_that_is_far_too_long_leaves_nothing_behind():
    """Stages deep in a wall have forces without bounds; the next trial knew of them (ground at nan)."""
    sol = fm.simulate(
        fm.mechanisms.nine_bar(clearance=5e-4), t_end=0.07, method=METHOD, step=fm.Adaptive(rtol=1e-3, max=1e-2)
    )
    assert sol.ok, sol.status
    assert sol.stats.rejected > 5


@pytest.mark.parametrize(("rtol", "left"), [(1e-4, 2e-3), (1e-7, 1e-5)])
def test_a_contact_that_a_stage_feels_is_not_stepped_over(rtol, left):
    graze = runpy.run_path(str(Path(__file__).with_name("test_radau.py")))["graze"]
    sol = fm.simulate(graze(), t_end=10.0, method=METHOD, step=fm.Adaptive(rtol=rtol))
    energy = 0.5 * sol.array("b.vx") ** 2 + 0.5 * (2.0 * math.pi) ** 2 * sol.array("b.x") ** 2
    assert sol.ok, sol.status
    assert len(sol.episodes("B")) == 25
    assert np.abs(np.median(energy[-100:]) / energy[0] - 1.0) < left


def test_fixed_steps_that_are_too_long_for_impacts_say_so():
    joint = {"clearance": PLAY, "bearing_radius": 0.1, "normal": fm.KelvinVoigt(1e8, 0.0)}
    pin = fm.RigidBody("pin", at=(0.0, 0.0), mass=1.0, inertia=1.0, velocity=(1.0, 0.0, 0.0))
    mech = fm.Mechanism("thrown", [pin, fm.RevoluteClearance("J", fm.GROUND, pin, (0.0, 0.0), **joint)])
    sol = fm.simulate(mech, t_end=0.004, method=METHOD, step=3e-4)
    assert not sol.ok
    assert "contacts of 'J' last less than 4 of the fixed steps" in sol.status


def test_friction_with_a_history_is_refused_by_name():
    law = fm.friction.LuGre(static=0.12, kinetic=0.1)
    pin = fm.RigidBody("pin", at=(0.0, 0.0), mass=1.0, inertia=1.0)
    joint = fm.RevoluteClearance(
        "J",
        fm.GROUND,
        pin,
        (0.0, 0.0),
        clearance=PLAY,
        bearing_radius=0.1,
        normal=fm.KelvinVoigt(1e8, 0.0),
        friction=law,
    )
    with pytest.raises(InputError, match=r"DormandPrince.*'J' has a law with a history.*Newmark"):
        fm.simulate(fm.Mechanism("bristles", [pin, joint]), t_end=1e-3, method=METHOD)
