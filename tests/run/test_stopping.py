"""Stop conditions: a run ends at the instant at which a signal crosses a level, to round-off."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError
from flexmb.findings.watch import impossible_penetrations
from flexmb.mechanisms import slider_crank
from flexmb.run.stopping import StopConditions

G = 9.81


def thrown(speed=4.0):
    """A free body thrown upwards."""
    return fm.Mechanism(
        "thrown", [fm.RigidBody("ball", (0.0, 0.0), 1.0, 1e-3, velocity=(1.0, speed, 0.0))], gravity=(0.0, -G)
    )


@pytest.mark.parametrize("method", [fm.Newmark.generalised_alpha(), fm.RungeKutta4(), fm.RadauIIA()], ids=repr)
def test_instant_of_a_crossing_in_closed_form(method):
    step = None if not isinstance(method, fm.RungeKutta4) else 1e-3
    sol = fm.simulate(thrown(), t_end=1.0, method=method, step=step, stop=fm.when("ball.vy", below=0.5))
    assert sol.ok
    assert "ball.vy below 0.5" in sol.status
    assert sol.time[-1] == pytest.approx((4.0 - 0.5) / G, rel=1e-12)
    assert sol.array("ball.vy")[-1] == pytest.approx(0.5, abs=4e-15)
    assert np.all(np.diff(sol.time) > 0.0)


@pytest.mark.parametrize("method", [None, fm.RadauIIA(), fm.RungeKutta4()], ids=repr)
@pytest.mark.parametrize("level", [5e-324, 1e-300, 1e-30])
def test_levels_that_vanish_beside_the_motion(method, level):
    """Trials of 1e-185 s ended with "the matrix became singular"."""
    step = 1e-3 if isinstance(method, fm.RungeKutta4) else None
    sol = fm.simulate(thrown(0.0), t_end=0.1, method=method, step=step, stop=fm.when("ball.y", below=-level))
    assert sol.ok
    assert "ball.y below" in sol.status
    assert 0.0 < sol.peak("ball.y").time <= max(1.0001 * math.sqrt(2.0 * level / G), 1e-30)


def test_first_of_several_conditions():
    stop = [fm.when("ball.y", above=0.7), fm.when("ball.x", above=0.3), fm.when("ball.y", crosses=0.6)]
    sol = fm.simulate(thrown(), t_end=2.0, stop=stop)
    assert "ball.y crosses 0.6" in sol.status
    t = (4.0 - math.sqrt(16.0 - 2.0 * G * 0.6)) / G
    assert sol.time[-1] == pytest.approx(t, rel=1e-9)


def test_no_crossing_is_an_ordinary_end():
    sol = fm.simulate(thrown(), t_end=0.1, stop=fm.when("ball.y", above=2.0))
    assert sol.ok
    assert sol.status.startswith("Finished")


def test_crank_angle_of_a_driven_mechanism_and_going_on_from_there():
    omega = 100.0
    mech = slider_crank(omega, clearance=2e-4)
    stop = fm.when("O.angle", above=2.0)
    sol = fm.simulate(mech, periods=2, stop=stop)
    assert sol.time[-1] == pytest.approx(2.0 / omega, rel=1e-14)
    assert sol.peak("O.angle").value == pytest.approx(2.0, rel=1e-14)  # no trial beyond it is left in the peaks
    again = fm.simulate(mech, periods=2, stop=fm.when("O.angle", above=3.0), restart=sol.restart)
    assert again.time[-1] == pytest.approx(3.0 / omega, rel=1e-14)
    with pytest.raises(
        InputError, match=r"'O.angle above 1' is met already at t = 0.02 s, where watching begins and O.angle is 2"
    ):
        fm.simulate(mech, periods=2, stop=fm.when("O.angle", above=1.0), restart=sol.restart)


def test_watching_changes_no_bit_of_the_run():
    mech = slider_crank(clearance=5e-4)
    plain = fm.simulate(mech, t_end=2e-3)
    watched = fm.simulate(mech, t_end=2e-3, stop=fm.when("slider.x", above=10.0))
    assert np.array_equal(plain.values, watched.values)
    assert np.array_equal(plain.peaks.values, watched.peaks.values)


def test_contact_begins_and_ends():
    mech = slider_crank(clearance=5e-4)
    full = fm.simulate(mech, t_end=2e-3)
    first = full.episodes("B").start[0]
    begun = fm.simulate(mech, t_end=2e-3, stop=fm.when("B", contact="begins"))
    assert begun.ok
    assert begun.time[-1] == pytest.approx(first, rel=1e-9)
    assert begun.array("B.penetration")[-1] == pytest.approx(0.0, abs=1e-15)
    ended = fm.simulate(mech, t_end=2e-3, stop=fm.when("B", contact="ends"))
    assert ended.time[-1] == pytest.approx(full.episodes("B").end[0], rel=1e-6)
    assert len(ended.episodes("B")) == 1


def test_a_jump_of_a_load_can_meet_a_condition():
    ball = fm.RigidBody("ball", (0.0, 0.0), 2.0, 1e-3)
    push = fm.Force("push", ball, (0.0, 0.0), (3.0, 0.0), history=fm.drives.Pulse(start=0.1, end=0.2))
    sol = fm.simulate(fm.Mechanism("pushed", [ball, push]), t_end=1.0, stop=fm.when("ball.ax", above=1.0))
    assert sol.ok
    assert sol.time[-1] == pytest.approx(0.1, rel=1e-12)
    assert sol.array("ball.ax")[-1] == pytest.approx(1.5)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: fm.when("x.y"), "no level given; give one of above"),
        (lambda: fm.when("x.y", above=1.0, below=2.0), "above and below given"),
        (lambda: fm.when("x.y", above=math.nan), "above is nan; it must be finite"),
        (lambda: fm.when(3, above=1.0), "the signal is 3"),
        (lambda: fm.when("P", contact="stops"), "contact is 'stops'"),
        (lambda: fm.simulate(thrown(), t_end=1.0, stop=fm.when("ball.z", above=1.0)), "no signal 'ball.z'"),
        (lambda: fm.simulate(thrown(), t_end=1.0, stop="ball.x"), "stop"),
        (lambda: fm.simulate(thrown(), t_end=1.0, stop=[3]), "must be a condition"),
    ],
)
def test_wrong_conditions(make, text):
    with pytest.raises(InputError, match=text):
        make()


def turning():
    """A rotor that turns by 2 t."""
    rotor = fm.RigidBody("rotor", (0.0, 0.0), 1.0, 0.5, velocity=(0.0, 0.0, 2.0))
    return fm.Mechanism("rotor", [rotor, fm.Revolute("axis", fm.GROUND, rotor, at=(0.0, 0.0))])


@pytest.mark.parametrize("order", [1, -1])
def test_the_earliest_of_several_in_one_step(order):
    stop = [fm.when("axis.angle", above=1.01), fm.when("rotor.theta", above=1.005)][::order]
    sol = fm.simulate(turning(), t_end=1.0, step=0.1, stop=stop)
    assert sol.time[-1] == pytest.approx(0.5025, rel=1e-12)
    assert "rotor.theta above 1.005" in sol.status


def test_a_start_on_the_level_is_no_crossing():
    bob = fm.RigidBody("bob", (0.0, -1.0), 1.0, 0.01, velocity=(1.0, 0.0, 1.0))
    swing = fm.Mechanism("swing", [bob, fm.Revolute("h", fm.GROUND, bob, at=(0.0, 0.0))], gravity=(0.0, -G))
    back = fm.simulate(swing, t_end=3.0, stop=fm.when("h.angle", crosses=0.0))
    assert back.time[-1] == pytest.approx(1.01462671, rel=1e-4)
    assert back.array("h.angle")[-1] == pytest.approx(0.0, abs=1e-14)


def test_contacts_of_a_part_with_two_limits_go_by_its_name():
    slider = fm.RigidBody("slider", (0.0, 0.0), 2.0, 0.5, velocity=(1.0, 0.0, 0.0))
    law = fm.KelvinVoigt(stiffness=1e5, damping=0.0, ramp=1e-9)
    guide = fm.Prismatic("guide", fm.GROUND, slider)
    end = fm.Stop("end", "guide", above=0.1, below=-0.1, normal=law)
    mech = fm.Mechanism("slider", [slider, guide, end])
    sol = fm.simulate(mech, t_end=1.0, stop=fm.when("end", contact="begins"))
    assert sol.time[-1] == pytest.approx(0.1, rel=1e-9)
    assert "contact of end begins" in sol.status


def test_a_fault_in_the_same_step_is_no_wanted_stop():
    """A soft journal is pushed through its bearing within one coarse step, in which a wanted level is crossed, too."""
    soft = slider_crank(clearance=5e-4).with_({"B.normal.stiffness": 1e3})
    names = fm.compile(soft).names
    found = StopConditions("test", names, fm.when("slider.x", above=0.0), impossible_penetrations(soft, ("B",)))
    before, after = np.zeros((2, len(names.signals)))
    before[:], after[:] = -1.0, 1.0
    assert found.all_met(before, after) == [0, 1]
    assert [bool(found.fault(k)) for k in (0, 1)] == [True, False]
