"""Episodes of contact: impacts in closed form, sums against momentum and energy, wherever a run is saved or cut.

The unit impact: a body of 1 kg at 1 m/s against a resting bearing, N = 1 N/m^1.5 depth^1.5, first touch at t = 1 s.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import flexmb as fm
from flexmb.run import run as run_module
from flexmb.run.run import Run
from flexmb.statics.start.consistent import Start

FIRST_CONTACT, CLOSING_SPEED = 2.27286e-4, 4.385783
"""Free flight of the worn slider-crank up to its first contact, whatever the contact law [s, m/s]."""

REFERENCE = {1.0: (1.0933620739, 3.21806546), 0.9: (1.0547874, 3.2498833)}
"""e asked for -> largest depth, duration of the unit impact: (5/4)^(2/5) and its integral; an independent code."""

RULES = {"alpha": fm.Newmark.generalised_alpha(0.8), "trapezoidal": fm.Newmark.trapezoidal(), "rk4": fm.RungeKutta4()}


def restitution(asked):
    """What comes out of the law: a (1 + e) = ln((1 + a)/(1 - a e)), a = 3 (1 - asked^2)/4."""
    a = 0.75 * (1.0 - asked**2)
    return 1.0 if a == 0.0 else brentq(lambda e: a * (1 + e) - math.log((1 + a) / (1 - a * e)), 0.05, 1 - 1e-12)


def thrown(
    asked=1.0, *, clearance=1.0, stiffness=1.0, velocity=(1.0, 0.0, 0.0), gravity=(0.0, 0.0), more=(), least=0.0
):
    """A pin of 1 kg that flies in a resting bearing."""
    pin = fm.RigidBody("pin", at=(0.0, 0.0), mass=1.0, inertia=1.0, velocity=velocity)
    law = fm.LankaraniNikravesh(stiffness=stiffness, restitution=asked, least_approach=least)
    sizes = {"clearance": clearance, "bearing_radius": 20.0 * clearance, "normal": law}
    joint = fm.RevoluteClearance("J", fm.GROUND, pin, at=(0.0, 0.0), **sizes)
    return fm.Mechanism("thrown", [pin, joint, *(part(pin) for part in more)], gravity=gravity)


def unit_impact(asked, step, method="trapezoidal"):
    """The only episode of the unit impact, and the speed of the pin afterwards."""
    sol = fm.simulate(thrown(asked), t_end=6.0, step=step, method=RULES[method], save=1)
    (episode,) = sol.episodes("J")
    return episode, float(sol.array("pin.vx")[-1])


def deviations(asked, step, method="trapezoidal"):
    """Every number of the unit impact less its exact value."""
    found, _ = unit_impact(asked, step, method)
    depth, duration = REFERENCE[asked]
    e = restitution(asked)
    exact = {
        "start": 1.0,
        "duration": duration,
        "approach_speed": 1.0,
        "separation_speed": e,
        "impulse": 1.0 + e,
        "peak_penetration": depth,
        "dissipated_contact": 0.5 * (1.0 - e**2),
        "restitution": e,
    }
    return {name: getattr(found, name) - value for name, value in exact.items()}


# One impact against closed forms


@pytest.mark.parametrize("asked", REFERENCE)
@pytest.mark.parametrize("method", RULES)
def test_the_numbers_of_an_impact(method, asked):
    """Within h^2/2 (units of 1), wherever in its step the contact begins: the steps do not divide the flight."""
    for step in (0.0371, 0.0123):
        for name, error in deviations(asked, step, method).items():
            assert abs(error) < 0.5 * step**2, (name, step, error)
    found, after = unit_impact(asked, 0.0123, method)
    assert (found.contact, found.mode, found.dissipated_friction) == ("J", 1, 0.0)
    assert after == pytest.approx(-restitution(asked), abs=1e-4)


@pytest.mark.parametrize("asked", REFERENCE)
def test_located_instants_and_speeds_converge_at_second_order_at_least(asked):
    """Four halvings of the step; 3.2 s of contact, so the coarsest has thirty steps in it.

    The depth is left out: it is that of the deepest step, whose error of h^2 depends on where the steps fall.
    """
    steps = [0.10371 / 2**k for k in range(5)]
    errors = [deviations(asked, step) for step in steps]
    for name in errors[0].keys() - {"peak_penetration"}:
        first, last = abs(errors[0][name]), abs(errors[-1][name])
        if first > 1e-3 * steps[0] ** 2:  # the elastic impact loses nothing but for round-off of the trapezoids
            assert math.log2(first / last) / 4 > 1.8, (name, [error[name] for error in errors])


@pytest.mark.parametrize(("method", "steps"), [("trapezoidal", (0.0371, 0.37)), ("alpha", (0.0371, 0.1))])
def test_the_impulse_is_the_change_of_momentum(method, steps):
    """m (v- + v+) with m = v- = 1, at coarse steps too.

    Generalised-alpha remembers the force for some steps, 0.8 of it from one to the next: the flight must be longer.
    """
    for step in steps:
        found, after = unit_impact(0.9, step, method)
        assert found.impulse == pytest.approx(1.0 - after, abs=1e-9)


# Many episodes: sums, the buffer, the order


def test_bounces_between_two_walls_are_many_and_alike(monkeypatch):
    """Elastic: every flight lasts 2 c/v, every contact 3.21806546 (m = K = v = 1).  Their number is exact, and larger
    than a buffer that is made small, which is full again and again within a block of steps.
    """
    monkeypatch.setattr(run_module, "BUFFER_ROWS", 5)
    flight, contact = 4.0, REFERENCE[1.0][1]
    number, step = 300, 0.02
    t_end = 0.5 * flight + number * contact + (number - 0.5) * flight
    for save in (1, 4000):
        sol = fm.simulate(thrown(clearance=2.0), t_end=t_end, step=step, method=RULES["trapezoidal"], save=save)
        e = sol.episodes("J")
        assert len(e) == number
        assert len(sol.time) == save + 1
        assert np.all(e.mode == 1)
        np.testing.assert_allclose(e.duration, contact, atol=step**2)
        np.testing.assert_allclose(e.flight[1:], flight, atol=step**2)
        assert np.isnan(e.flight[0])
        np.testing.assert_allclose(e.impulse, 2.0, atol=step**2)


def test_more_episodes_than_the_buffer_holds_at_its_own_size():
    number = run_module.BUFFER_ROWS + 100
    contact = REFERENCE[1.0][1]
    t_end = 0.2 + number * contact + (number - 0.5) * 0.4
    sol = fm.simulate(thrown(clearance=0.2), t_end=t_end, step=0.02, method=RULES["trapezoidal"], save=1)
    assert len(sol.episodes("J")) == number
    assert np.all(np.diff(sol.episodes("J").start) > contact)


FALLING = {"asked": 0.6, "clearance": 1e-3, "stiffness": 1e10, "velocity": (0.0, 0.0, 0.0), "gravity": (0.0, -9.81)}


@pytest.fixture(scope="module")
def fallen():
    """A pin that falls in its bearing, bounces, and comes to rest."""
    return fm.simulate(thrown(**FALLING), t_end=0.5, step=1e-5, save="steps")


def test_impulses_of_all_episodes_are_in_balance_with_the_weight(fallen):
    """m v(t) = -m g t + sum of impulses, the running one included."""
    e = fallen.episodes("J")
    assert len(e) > 6
    momentum = float(fallen.array("pin.vy")[-1])
    assert e.impulse.sum() == pytest.approx(9.81 * 0.5 + momentum, rel=1e-9)


def test_bounces_end_in_continuous_contact(fallen):
    """First fall by the play, v = sqrt(2 g c); speeds fall by the law's restitution; the last one does not end.

    A step is 0.07 of the unit of time of the first impact, so its speeds are known to some 0.07^2/50 (first test).
    """
    e = fallen.episodes("J")
    assert e.approach_speed[0] == pytest.approx(math.sqrt(2 * 9.81 * 1e-3), rel=1e-4)
    assert e.start[0] == pytest.approx(math.sqrt(2 * 1e-3 / 9.81), rel=1e-7)
    # flight without loss: parting and meeting again at the same speed, 2 v/g apart
    np.testing.assert_allclose(e.approach_speed[1:6], e.separation_speed[:5], rtol=1e-3)
    np.testing.assert_allclose(e.flight[1:6], 2.0 * e.separation_speed[:5] / 9.81, rtol=1e-3)
    # the law's restitution is that without a weight, which is a hundredth of the force here
    assert e.restitution[0] == pytest.approx(restitution(0.6), rel=9.81 / e.peak_force[0])
    assert e.peak_force[0] > 900.0
    assert e[-1].mode == 2 == fallen.array("J.mode")[-1]
    assert math.isnan(e[-1].end)
    assert math.isnan(e[-1].separation_speed)
    assert not np.any(np.isnan(e.end[:-1]))


def test_modes_are_those_of_the_signal(fallen):
    """The signal's last value before the end of each episode; its changes between 0 and not 0 number the episodes."""
    e, t, mode = fallen.episodes("J"), fallen.time, fallen.array("J.mode")
    begins = np.flatnonzero((mode[:-1] == 0.0) & (mode[1:] > 0.0))
    assert len(e) == len(begins)
    for k, episode in enumerate(e):
        inside = (t >= episode.start) & ~(t > episode.end)
        assert mode[inside][-1] == episode.mode
        assert t[begins[k]] <= episode.start <= t[begins[k] + 1]
    for loss in ("dissipated_contact", "dissipated_friction"):
        assert getattr(e, loss).sum() == pytest.approx(fallen.array(f"energy.{loss}")[-1], rel=1e-12, abs=1e-15)


def test_continuous_contact_that_ends():
    """At rest on the bottom, then lifted by a force: the episode is continuous and ends a little after the force began.

    Net 2 N against 1 kg from a depth (m g/K)^(2/3) = 1e-6 m; parting within some 1 ms.
    """
    history = fm.drives.PiecewiseLinear((0.0, 0.4, 0.4001, 1.0), (0.0, 0.0, 1.0, 1.0))
    lift = [lambda pin: fm.Force("lift", pin, at=(0.0, 0.0), force=(0.0, 9.81 + 2.0), history=history)]
    sol = fm.simulate(thrown(**FALLING, more=lift), t_end=0.42, step=1e-5, save=1)
    last = sol.episodes("J")[-1]
    assert last.mode == 2
    assert 0.4 < last.end < 0.402
    # impulse against its weight while it lay there, less what the force took off and what it flew off with
    assert last.impulse > 0.9 * 9.81 * (0.4 - last.start)


# What is saved, and where a run is cut


@pytest.fixture(scope="module")
def worn_run(slider_crank):
    """1.5 ms of the worn slider-crank with fixed steps, every step saved."""
    mechanism = slider_crank()
    return mechanism, fm.simulate(mechanism, t_end=1.5e-3, step=1e-6, save="steps")


def rows(sol):
    return sol.contacts.rows


def same_bits(one, other):
    assert one.shape == other.shape
    assert np.ascontiguousarray(one).tobytes() == np.ascontiguousarray(other).tobytes()


def test_first_contact_of_the_worn_slider_crank(slider_crank):
    """The published instant and closing speed, with the accuracy of the step that feels the contact already."""
    errors = []
    for step in (4e-7, 1e-7):
        sol = fm.simulate(slider_crank(), t_end=2.4e-4, step=step, save=1)
        (first,) = sol.episodes("C")
        assert math.isnan(first.end)
        errors.append(abs(first.approach_speed - CLOSING_SPEED))
    assert first.start == pytest.approx(FIRST_CONTACT, abs=5e-10)
    assert first.approach_speed == pytest.approx(CLOSING_SPEED, abs=6e-6)
    assert math.log(errors[0] / errors[1], 4) > 1.8


def test_impacts_of_the_worn_slider_crank(worn_run):
    """As many as the gap has zeros; losses add up to the account; impulses to the integral of the force."""
    _, sol = worn_run
    e = sol.episodes("C")
    depth = sol.array("C.penetration") >= 0.0
    assert len(e) == np.count_nonzero(~depth[:-1] & depth[1:]) > 4
    assert np.all((e.mode == 1) & (e.approach_speed > 0.5))
    for loss in ("dissipated_contact", "dissipated_friction"):
        assert getattr(e, loss).sum() == pytest.approx(sol.array(f"energy.{loss}")[-1], rel=1e-12)
    assert e.impulse.sum() == pytest.approx(np.trapezoid(sol.array("C.normal_force"), sol.time), rel=1e-12)
    assert e.peak_force.max() == sol.peak("C.normal_force").value
    assert e.peak_penetration.max() == sol.peak("C.penetration").value


@pytest.mark.parametrize("save", [1, 7, 5000])
def test_episodes_do_not_depend_on_what_is_saved(worn_run, save):
    mechanism, sol = worn_run
    same_bits(rows(fm.simulate(mechanism, t_end=1.5e-3, step=1e-6, save=save)), rows(sol))


def test_controlled_steps_find_the_same_episodes(slider_crank):
    """Against fixed steps of 1e-7 s.  Steps grow as rtol^(1/3): a hundredth of rtol means a 22nd of what is off.

    Where in a step a contact begins shakes that.  The fourth episode is still running at the end.
    """
    fine = fm.simulate(slider_crank(), t_end=1e-3, step=1e-7, save=1).episodes("C")
    off = []
    for rtol in (2e-6, 2e-8):
        sol = fm.simulate(slider_crank(), t_end=1e-3, step=fm.Adaptive(rtol=rtol), save=1)
        found = sol.episodes("C")
        assert sol.stats.rejected > 2
        assert len(found) == len(fine) == 4
        off.append({name: np.abs(getattr(found, name) / getattr(fine, name) - 1.0)[:3].max() for name in COMPARED})
    for name in COMPARED:
        assert off[1][name] < 0.2 * off[0][name], name
        assert off[1][name] < (1e-5 if name in ("start", "end") else 2e-4), name


COMPARED = ("start", "end", "approach_speed", "separation_speed", "impulse", "dissipated_contact")


@pytest.mark.parametrize("step", [fm.FixedStep(1e-6), fm.Adaptive(rtol=1e-5)])
def test_a_restart_in_mid_episode_goes_on_bit_for_bit(slider_crank, tmp_path, step):
    """The first part has the episode unfinished; the second has it whole, with all that was collected before."""
    whole = fm.simulate(slider_crank(), t_end=1e-3, step=step, save="steps")
    middle = 0.5 * (whole.episodes("C")[1].start + whole.episodes("C")[1].end)
    steps = int(np.flatnonzero(whole.time > middle)[0])
    cut = fm.simulate(slider_crank(), t_end=1e-3, step=step, max_steps=steps)
    assert len(rows(cut)) == 2
    running = cut.episodes("C")[1]
    assert math.isnan(running.end)
    assert 0.0 < running.impulse < whole.episodes("C")[1].impulse
    state = fm.load(cut.to_netcdf(tmp_path / "cut.nc")).restart
    rest = fm.simulate(slider_crank(), t_end=1e-3, step=step, restart=state, save=3)
    same_bits(rows(cut)[:1], rows(whole)[:1])
    same_bits(rows(rest), rows(whole)[1:])


@pytest.mark.parametrize("name", ["episodes", "reuse", "past", "impacts"])
def test_a_state_that_lacks_something_is_refused(worn_run, name):
    """It could only go on as if nothing had been, and not bit for bit."""
    mechanism, _ = worn_run
    cut = fm.simulate(mechanism, t_end=1.5e-3, step=1e-6, max_steps=250)
    state = {key: array for key, array in cut.restart.items() if key != name}
    with pytest.raises(fm.errors.InputError, match=f"restart does not fit this model .*{name!r} is missing"):
        fm.simulate(mechanism, t_end=1.5e-3, step=1e-6, restart=state)


def test_saving_that_begins_in_mid_contact_keeps_the_whole_episode(worn_run):
    """Steps end at the instant, so nothing is the same to the last bit; those that ended before are left out."""
    mechanism, whole = worn_run
    second = whole.episodes("C")[1]
    inside, later = round(0.5 * (second.start + second.end), 6), round(second.end + 1e-6, 6)
    found = fm.simulate(mechanism, t_end=1.5e-3, save_from=inside, step=1e-6).episodes("C")
    assert len(found) == len(rows(whole)) - 1
    assert found[0].start < inside < found[0].end
    for name in ("start", "end", "approach_speed", "impulse", "peak_force", "dissipated_contact"):
        assert getattr(found[0], name) == pytest.approx(getattr(second, name), rel=1e-5), name
    after = fm.simulate(mechanism, t_end=1.5e-3, save_from=later, step=1e-6).episodes("C")
    np.testing.assert_allclose(after.start, whole.episodes("C").start[2:], rtol=1e-5)


def test_a_run_that_stops_before_saving_begins_has_no_episodes(slider_crank):
    sol = fm.simulate(slider_crank(), t_end=1e-3, save_from=9e-4, step=1e-6, max_steps=250)
    assert not sol.ok
    assert len(sol.episodes()) == 0


def test_bodies_that_touch_at_the_start_have_no_start():
    """0.1 below the surface at rest, K = 1: thrown out with K depth^2.5/2.5 = v^2/2."""
    program = fm.compile(thrown(clearance=1.0, velocity=None, least=1e-3))
    run = Run(program, RULES["trapezoidal"], fm.FixedStep(0.01), 20.0, None)
    a = np.array([-(0.1**1.5), 0.0, 0.0])
    run.begin(Start(np.array([1.1, 0.0, 0.0]), np.zeros(3), a, np.zeros(0)))
    run.run_to(20.0, saving=0.0)
    (first,) = run.solution({}).episodes("J")
    assert math.isnan(first.start)
    assert math.isnan(first.approach_speed)
    assert math.isnan(first.duration)
    assert first.separation_speed == pytest.approx(math.sqrt(2.0 * 0.1**2.5 / 2.5), rel=1e-4)
    assert first.impulse == pytest.approx(first.separation_speed, rel=1e-4)
    assert (first.peak_penetration, first.peak_force) == pytest.approx((0.1, 0.1**1.5), rel=1e-12)


# Several contacts


def guided(**more):
    slider = fm.RigidBody("slider", (0.0, 0.0), 0.5, 1e-3)
    law = fm.LankaraniNikravesh(stiffness=1e9, restitution=0.6, least_approach=0.0)
    sizes = {
        "clearance": 1e-3,
        "half_length": 0.05,
        "half_height": 0.02,
        "normal": law,
        "friction": fm.friction.Frictionless(),
    }
    guide = fm.PrismaticClearance("G", fm.GROUND, slider, along=(1.0, 0.0), **sizes)
    return fm.Mechanism("guided", (slider, guide), gravity=(0.0, -9.81), **more)


def test_corners_of_a_slider_and_all_of_them_together():
    """A block falls flat on both lower corners: each has half the impulse of the weight."""
    t_end = 0.2
    sol = fm.simulate(guided(), t_end=t_end, step=1e-5, save=1)
    front, rear, both = (sol.episodes(name) for name in ("G.lower_front", "G.lower_rear", "G"))
    assert len(front) == len(rear) > 5
    assert len(both) == len(front) + len(rear) == len(sol.episodes())
    assert set(both.contact) == {"G.lower_front", "G.lower_rear"}
    assert len(sol.episodes("G.upper_front")) == 0
    np.testing.assert_array_equal(both.start, np.sort(both.start))
    np.testing.assert_allclose(front.start[:5], rear.start[:5], rtol=1e-9)
    assert front.start[0] == pytest.approx(math.sqrt(2 * 1e-3 / 9.81), rel=1e-7)
    balance = 0.5 * (9.81 * t_end + float(sol.array("slider.vy")[-1]))
    assert both.impulse.sum() == pytest.approx(balance, rel=1e-9)
    assert front.impulse.sum() == pytest.approx(0.5 * balance, rel=1e-6)
    assert both.dissipated_contact.sum() == pytest.approx(sol.array("energy.dissipated_contact")[-1], rel=1e-12)
    # in one joint the flights are those in which no corner touches
    flights = both.flight[1:]
    assert np.sum(flights > 1e-6) == len(front) - 1


def test_a_joint_that_never_touches_and_names_that_are_no_contacts():
    sol = fm.simulate(guided(), t_end=1e-3, step=1e-4)
    assert len(sol.episodes("G")) == 0
    assert repr(sol.episodes("G")) == "0 episodes of contact of 'G'"
    with pytest.raises(KeyError, match=r"'guided' has no contact 'G\.lower'\. Did you mean 'G\.lower_rear'\?"):
        sol.episodes("G.lower")
    free = replace(guided(), parts=guided().parts[:1])
    with pytest.raises(fm.errors.InputError, match=r"no contact 'G'\. Nothing in it touches"):
        fm.simulate(free, t_end=1e-3).episodes("G")
    assert len(fm.simulate(free, t_end=1e-3).episodes()) == 0
