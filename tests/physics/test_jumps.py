"""Loads that jump: a run ends a step at the jump and starts anew there, so it stays exact and keeps its order."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.program.program import Program

FORCE, MASS = 3.0, 2.0  # [N, kg]
ON, OFF = 0.123456, 0.7  # [s], multiples of no step used here

RUNS = {
    "alpha": {"step": 0.037},
    "one step a segment": {"step": 0.9},
    "trapezoidal": {"step": 0.11, "method": fm.Newmark.trapezoidal()},
    "hht": {"step": 0.05, "method": fm.Newmark.hht(0.3)},
    "adaptive": {"step": fm.Adaptive(atol=1e-3, max=0.3)},
    "rk4": {"step": 0.05, "method": fm.RungeKutta4()},
}


def pushed(history):
    """A body in free space that is pushed along x."""
    body = fm.RigidBody("body", (1.0, 2.0), MASS, 0.1)
    push = fm.Force("push", body, at=(1.0, 2.0), force=(FORCE, 0.0), history=history)
    return fm.Mechanism("pushed", [body, push], gravity=(0.0, 0.0))


def way(t):
    """x [m] of a mass that is pushed from ON to OFF: rest, a parabola, a line."""
    a = FORCE / MASS
    return 1.0 + a / 2.0 * (np.clip(t - ON, 0.0, None) ** 2 - np.clip(t - OFF, 0.0, None) ** 2)


@pytest.mark.parametrize("save", ["steps", 10])
@pytest.mark.parametrize("run", RUNS)
def test_a_pulse_moves_a_free_body_exactly(run, save):
    sol = fm.simulate(pushed(fm.drives.Pulse(start=ON, end=OFF)), t_end=1.0, save=save, **RUNS[run])
    assert sol.ok, sol.status
    np.testing.assert_allclose(sol.array("body.x"), way(sol.time), rtol=0.0, atol=1e-12)
    work = FORCE**2 / MASS * (OFF - ON) ** 2 / 2.0
    assert sol.array("energy.load_work")[-1] == pytest.approx(work, rel=1e-12)
    assert sol.peak("energy.residual").value <= 1e-14
    assert sol.peak("body.ax") == (FORCE / MASS, ON)
    assert np.all(np.diff(sol.time) > 0.0)


def test_an_instant_at_a_jump_shows_the_state_just_after():
    sol = fm.simulate(pushed(fm.drives.Pulse(start=0.2, end=0.6)), t_end=1.0, save=10, step=0.03)
    on = (sol.time > 0.2 - 1e-9) & (sol.time < 0.6 - 1e-9)
    assert on.sum() == 4
    np.testing.assert_allclose(sol.array("body.ax"), np.where(on, FORCE / MASS, 0.0), atol=1e-14)
    each = fm.simulate(pushed(fm.drives.Pulse(start=0.2, end=0.6)), t_end=1.0, save="steps", step=0.03)
    both = np.abs(each.time - 0.2) < 1e-12
    np.testing.assert_allclose(each.array("body.ax")[both], [0.0, FORCE / MASS], atol=1e-14)  # just before, just after


def test_straight_lines_through_points_are_integrated_exactly_by_order_four():
    """x for a force that rises and falls linearly is made of cubics."""
    times, values = (0.1, 0.33, 0.8), (0.0, 1.0, 0.0)
    sol = fm.simulate(
        pushed(fm.drives.PiecewiseLinear(times, values)), t_end=1.0, save="steps", step=0.19, method=fm.RungeKutta4()
    )
    slopes = (1.0 / 0.23, -1.0 / 0.23 - 1.0 / 0.47, 1.0 / 0.47)  # changes of the slope at the points
    cubic = sum(k * np.clip(sol.time - t, 0.0, None) ** 3 / 6.0 for k, t in zip(slopes, times, strict=True))
    np.testing.assert_allclose(sol.array("body.x"), 1.0 + FORCE / MASS * cubic, rtol=0.0, atol=1e-13)


# Order across a jump

W = 7.0  # [rad/s]


def sprung(history):
    """A body on a torsion spring, at rest, that is turned by a moment of 1 N m; inertia 1 kg m^2."""
    wheel = fm.RigidBody("wheel", (0.0, 0.0), 1.0, 1.0)
    parts = (
        fm.Revolute("O", fm.GROUND, wheel, at=(0.0, 0.0)),
        fm.TorsionSpring("spring", fm.GROUND, wheel, stiffness=W**2),
        fm.Torque("moment", wheel, 1.0, history=history),
    )
    return fm.Mechanism("sprung", [wheel, *parts], gravity=(0.0, 0.0))


def swing(t):
    """theta [rad] of an undamped oscillator under a moment from ON to OFF."""
    return sum(sign * (t > at) * (1.0 - np.cos(W * (t - at))) / W**2 for sign, at in ((1.0, ON), (-1.0, OFF)))


def orders(method, sizes):
    """Slope of the error of theta over the step."""
    errors = []
    for h in sizes:
        sol = fm.simulate(sprung(fm.drives.Pulse(start=ON, end=OFF)), t_end=1.0, save="steps", step=h, method=method)
        errors.append(np.abs(sol.array("wheel.theta") - swing(sol.time)).max())
    return np.polyfit(np.log(sizes), np.log(errors), 1)[0], errors


SIZES = (0.02, 0.0131, 0.0087, 0.0053, 0.0037, 0.0023)


@pytest.mark.parametrize(
    ("method", "order"),
    [(fm.Newmark.generalised_alpha(0.8), 2), (fm.Newmark.trapezoidal(), 2), (fm.RungeKutta4(), 4)],
    ids=["alpha", "trapezoidal", "rk4"],
)
def test_the_order_of_the_method_survives_a_jump(method, order, monkeypatch):
    with_restarts, errors = orders(method, SIZES)
    assert with_restarts > order - 0.1, errors
    monkeypatch.setattr(Program, "breaks", lambda _self, _t_end: ())
    without, larger = orders(method, SIZES)
    assert without < 1.5, "the test would not notice a run that steps across the jump"
    assert larger[-1] > 5.0 * errors[-1]


# A hinged mechanism, energies, restarts


def beating(history):
    """Two hinged rods under gravity; the lower one is beaten by a load."""
    upper = fm.RigidLink("upper", (0.0, 0.0), (0.3, 0.0), 0.5, 4e-3)
    lower = fm.RigidLink("lower", (0.3, 0.0), (0.5, 0.1), 0.3, 2e-3)
    joints = (fm.Revolute("O", fm.GROUND, upper, (0.0, 0.0)), fm.Revolute("P", upper, lower, (0.3, 0.0)))
    load = fm.Force("beat", lower, at=(0.5, 0.1), force=(4.0, 9.0), history=history, follower=True)
    return fm.Mechanism("beating", [upper, lower, *joints, load], gravity=(0.0, -9.81))


BEATS = {
    "pulse": fm.drives.Pulse(2.0, 0.05, 0.2),
    "lines": fm.drives.PiecewiseLinear((0.05, 0.1, 0.2), (0.0, 2.0, 0.0)),
}


@pytest.mark.parametrize("history", BEATS)
def test_energies_close_across_jumps(history):
    residual = []
    for h in (5e-4, 2.5e-4, 1.25e-4):
        sol = fm.simulate(beating(BEATS[history]), t_end=0.3, step=h)
        assert sol.peak("energy.load_work").value > 0.5
        residual.append(sol.peak("energy.residual").value)
    assert residual[-1] < 1e-4 * sol.peak("energy.load_work").value
    assert math.log2(residual[0] / residual[-1]) / 2.0 > 1.8


def test_joint_forces_jump_with_the_load():
    """Right after the jump the forces are those of a run that starts with the load already on."""
    at_once = fm.simulate(beating(fm.drives.Pulse(2.0)), t_end=1e-6, step=1e-6, save="steps")
    soon = fm.simulate(beating(fm.drives.Pulse(2.0, start=1e-9)), t_end=1e-6, step=1e-6, save="steps")
    just_after = int(np.flatnonzero(soon.time == 1e-9)[0])
    for name in ("P.fx", "P.fy", "lower.alpha"):
        assert soon.array(name)[just_after] == pytest.approx(at_once.array(name)[0], rel=1e-6)
        assert abs(soon.array(name)[0] - at_once.array(name)[0]) > 1.0


CUTS = {
    "fixed": {"step": 1.1e-3},
    "adaptive": {"step": fm.Adaptive(atol=1e-7)},
    "rk4": {"step": 1.1e-3, "method": fm.RungeKutta4()},
}


def same_end(one, other):
    for name, array in one.restart.items():
        assert array.tobytes() == other.restart[name].tobytes(), name


@pytest.mark.parametrize("case", CUTS)
@pytest.mark.parametrize("history", BEATS)
@pytest.mark.parametrize("where", ["before", "last before", "first after", "between"])
def test_a_restart_near_a_jump_goes_on_bit_for_bit(case, history, where):
    mechanism, options = beating(BEATS[history]), {"t_end": 0.3, "save": "steps", **CUTS[case]}
    whole = fm.simulate(mechanism, **options)
    # two rows are saved at a jump and one at the start, so the row of the jump has the number of steps before it
    before = int(np.flatnonzero(whole.time == 0.05)[0]) - 1
    steps = before + {"before": -3, "last before": 0, "first after": 1, "between": 7}[where]
    cut = fm.simulate(mechanism, max_steps=steps, **options)
    assert cut.stats.steps == steps
    assert not cut.ok
    assert (cut.time[-1] == 0.05) == (where == "last before")
    rest = fm.simulate(mechanism, restart=cut.restart, **options)
    assert rest.ok, rest.status
    same_end(rest, whole)
    assert cut.stats.steps + rest.stats.steps == whole.stats.steps
    later = whole.time > cut.time[-1]
    assert rest.values[-later.sum() :].tobytes() == whole.values[later].tobytes()


@pytest.mark.parametrize("case", CUTS)
def test_a_run_that_ends_at_a_jump_can_go_on(case):
    mechanism = beating(BEATS["pulse"])
    whole = fm.simulate(mechanism, t_end=0.3, save="steps", **CUTS[case])
    options = CUTS[case] | ({"step": fm.Adaptive(atol=1e-7, max=0.3 / 1000.0)} if case == "adaptive" else {})
    first = fm.simulate(mechanism, t_end=0.2, save="steps", **options)
    assert first.ok
    assert first.time[-1] == 0.2
    rest = fm.simulate(mechanism, t_end=0.3, save="steps", restart=first.restart, **CUTS[case])
    same_end(rest, whole)


def test_saving_that_begins_at_a_jump_begins_just_after_it():
    sol = fm.simulate(beating(BEATS["pulse"]), t_end=0.3, save_from=0.05, save=50, step=1.1e-3)
    whole = fm.simulate(beating(BEATS["pulse"]), t_end=0.3, save=60, step=1.1e-3)
    assert sol.time[0] == 0.05
    np.testing.assert_allclose(sol.array("P.fy"), whole.array("P.fy")[10:], rtol=1e-9)


def test_the_end_of_a_table_that_drives_a_joint_is_a_jump_of_acceleration():
    """Behind the last point the speed stays: the moment vanishes at once, the position is a straight line."""
    times = (0.0, 0.1, 0.2, 0.3, 0.4)
    wheel = fm.RigidBody("wheel", (0.0, 0.0), 1.0, 0.5)
    pin = fm.Revolute("O", fm.GROUND, wheel, at=(0.0, 0.0))
    motor = fm.Drive("motor", "O", fm.drives.Table(times, tuple(t**3 for t in times)))
    mechanism = fm.Mechanism("table", [wheel, pin, motor], gravity=(0.0, 0.0))
    sol = fm.simulate(mechanism, t_end=0.7, save="steps", step=0.0317)
    np.testing.assert_allclose(
        sol.array("motor.torque"), np.where(sol.time <= 0.4, 0.5 * 6.0 * sol.time, 0.0), atol=1e-9
    )
    assert (np.abs(sol.time - 0.4) < 1e-12).sum() == 2
    first = fm.simulate(
        mechanism, t_end=0.4, save="steps", step=0.0317
    )  # a run up to the end of the table still shows it
    assert first.array("motor.torque")[-1] == pytest.approx(1.2, rel=1e-9)
    same_end(fm.simulate(mechanism, t_end=0.7, save="steps", step=0.0317, restart=first.restart), sol)
