"""Controllers that drive their signal away, targets whose derivative is infinite; stops that begin at their level."""

import numpy as np
import pytest
from plants import ARM_INERTIA, arm, rotor

import flexmb as fm


@pytest.mark.parametrize(
    "more",
    [
        pytest.param({}, marks=pytest.mark.slow),
        {"limit": 8.0, "ki": -10.0},
        pytest.param({"limit": 8.0, "sample": 0.01}, marks=pytest.mark.slow),
    ],
    ids=["unlimited", "limited", "sampled"],
)
def test_a_pid_of_the_wrong_sign_ends_the_run_with_its_name(more):
    """It ran 2,000,000 steps without a word; now a hundred turns at most, whatever the time asked for."""
    servo = fm.PID("servo", "tip.angle", "actuator", target=1.0, kp=-40.0, kd=-4.0, **more)
    sol = fm.simulate(arm(servo), t_end=1e3, signals=["arm.theta"], max_steps=200_000)
    assert not sol.ok
    assert "PID 'servo' drives 'tip.angle' away from its target" in sol.status
    assert "the sign of its gains or of 'actuator' is wrong" in sol.status
    assert sol.stats.steps < 100_000
    assert abs(float(sol.restart["q"][2])) == pytest.approx(1.0 + 200.0 * np.pi, rel=0.01)
    again = fm.simulate(arm(servo), t_end=1e3, signals=["arm.theta"], max_steps=200_000, save=10)
    assert again.restart["q"].tobytes() == sol.restart["q"].tobytes()  # whatever is saved


def test_a_speed_control_of_the_wrong_sign():
    sol = fm.simulate(rotor(fm.PID("governor", "rotor.omega", "shaft", target=100.0, kp=-0.02, ki=-0.1)), t_end=60.0)
    assert "PID 'governor' drives 'rotor.omega' away" in sol.status
    assert not sol.ok


def test_a_controller_that_brakes_goes_on():
    """A rotor of 2e-3 kg m^2 under a torque of 1 N m, braked by 0.1 N m at most: omega = 0.9 t / J, and no fault."""
    brake = fm.PID("brake", "rotor.theta", "shaft", kp=1.0, limit=0.1)
    parts = rotor(brake)
    parts = parts.with_part(fm.Torque("wind", parts.find("rotor"), 1.0))
    sol = fm.simulate(parts, t_end=2.0)
    assert sol.ok, sol.status
    assert float(sol["rotor.theta"][-1]) == pytest.approx(0.5 * 450.0 * 4.0, rel=0.01)  # beyond a hundred turns


def test_a_target_that_turns_is_followed_for_any_number_of_turns():
    ramp = fm.drives.Ramp(2000.0, time=0.1)
    servo = fm.PID(
        "servo", "rotor.theta", "shaft", target=ramp, kp=20.0, kd=0.5, rate="rotor.omega", derivative_of="error"
    )
    sol = fm.simulate(rotor(servo), t_end=2.0)
    assert sol.ok
    assert float(sol["rotor.theta"][-1]) > 3000.0


def test_the_derivative_of_a_jump_needs_a_filter():
    """With a filter the kick turns the arm by kd jump / inertia at once; without one it was lost without a word."""
    jump = fm.drives.Pulse(0.5, start=0.1, end=2.0)
    gains = {"target": jump, "kd": 2.0, "derivative_of": "error"}
    with pytest.raises(fm.errors.InputError, match=r"PID 'servo': the target jumps at t = 0\.1 s.*filter_time="):
        fm.PID("servo", "tip.angle", "actuator", rate="tip.omega", **gains)
    kick = fm.PID("servo", "tip.angle", "actuator", filter_time=1e-5, **{**gains, "kp": 1e-9})
    sol = fm.simulate(arm(kick, gravity=(0.0, 0.0)), t_end=0.1002, step=fm.Adaptive(rtol=1e-7))
    spent = 1.0 - np.exp(-2e-4 * 2.0 / ARM_INERTIA)
    assert float(sol["arm.theta"][-1]) == pytest.approx(0.5 * spent, rel=0.1)
    for target in (fm.drives.Ramp(1.0, time=0.1), fm.drives.PiecewiseLinear([0.0, 1.0, 2.0], [-1.0, 0.0, 1.0]), 3.0):
        fm.PID("servo", "tip.angle", "actuator", rate="tip.omega", kd=1.0, target=target, derivative_of="error")


@pytest.mark.parametrize(("level", "side"), [(0.0, "below"), (0.5, "below"), (0.5, "above")])
def test_a_signal_that_begins_at_its_level_and_goes_beyond_ends_the_run(level, side):
    """x = x0 -+ g t^2 / 2 leaves its level at once; the condition was never met."""
    ball = fm.RigidBody("ball", (0.0, level), 1.0, 1.0)
    gravity = (0.0, -9.81 if side == "below" else 9.81)
    mechanism, condition = fm.Mechanism("fall", [ball], gravity=gravity), fm.when("ball.y", **{side: level})
    sol = fm.simulate(mechanism, t_end=1.0, stop=condition)
    assert "as asked for" in sol.status
    assert float(sol.time[-1]) < 1e-4
    assert fm.simulate(mechanism, t_end=1.0, stop=condition, restart=sol.restart).time[-1] == 1.0
    away = fm.simulate(fm.Mechanism("fall", [ball], gravity=(0.0, -gravity[1])), t_end=1.0, stop=condition)
    assert "Finished" in away.status
