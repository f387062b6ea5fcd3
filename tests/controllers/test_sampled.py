"""Sampled controllers: exact discrete solutions, instants, restarts."""

import math

import numpy as np
import pytest
from plants import ARM, ARM_INERTIA, MOTOR, WEIGHT, J, L, arm, cut_and_continued, different, last, linear, motor, rotor

import flexmb as fm
from flexmb.errors import InputError

STEPS = {
    "radau": {"method": fm.RadauIIA(), "step": fm.Adaptive(rtol=1e-11)},
    "runge-kutta": {"method": fm.RungeKutta4(), "step": fm.FixedStep(1e-4)},
}


@fm.control_kernel
def bang_bang(p, t, u, x, dx, y):
    """Full torque towards a target."""
    y[0] = p[0] if u[0] < p[1] else -p[0]


@fm.control_kernel
def counting(p, t, u, x, dx, y):
    """x counts the instants; the output is the time of the last one."""
    dx[0] = 1.0 / p[0]
    y[0] = t


@fm.control_kernel
def hundredth(p, t, u, x, dx, y):
    """A hundredth of the input."""
    y[0] = 0.01 * u[0]


@fm.control_kernel
def root(p, t, u, x, dx, y):
    """No number after a quarter of a second."""
    y[0] = math.sqrt(0.25 - t)


@pytest.mark.parametrize("options", STEPS.values(), ids=STEPS)
@pytest.mark.parametrize("sample", [0.02, 0.003])
def test_a_sampled_pi_controller_is_exact(options, sample):
    """Voltage of a motor by a sampled PI controller: between instants the plant is linear, its solution known."""
    servo = fm.PID("servo", "rotor.omega", target=20.0, kp=0.3, ki=2.0, sample=sample)
    instants = 20
    x, integral = np.zeros(2), 0.0
    for _ in range(instants):
        error = 20.0 - x[1]
        x, integral = linear(MOTOR, [(0.3 * error + integral) / L, 0.0], x, sample), integral + sample * 2.0 * error
    sol = fm.simulate(rotor(servo, motor("servo.output")), t_end=instants * sample, **options)
    assert sol.ok
    assert last(sol, "motor.current", "rotor.omega") == pytest.approx(x, abs=1e-9)


def test_newmark_agrees_by_its_tolerance():
    servo = fm.PID("servo", "rotor.omega", target=20.0, kp=0.3, ki=2.0, sample=0.02)
    model = rotor(servo, motor("servo.output"))
    exact = fm.simulate(model, t_end=0.4, **STEPS["radau"])
    sol = fm.simulate(model, t_end=0.4, step=fm.Adaptive(rtol=1e-8))
    assert last(sol, "rotor.omega") == pytest.approx(last(exact, "rotor.omega"), abs=1e-7)


@pytest.mark.slow
def test_a_switching_law_is_exact():
    """A rotor between two torques: parabolas from instant to instant."""
    law = fm.Control("servo", ["rotor.theta"], ["shaft"], bang_bang, numbers=(0.05, 0.3), sample=0.01)
    theta, omega = 0.0, 0.0
    for _ in range(200):
        alpha = (0.05 if theta < 0.3 else -0.05) / J
        theta, omega = theta + 0.01 * omega + 0.5 * alpha * 0.01**2, omega + 0.01 * alpha
    for options in (*STEPS.values(), {}):
        sol = fm.simulate(rotor(law), t_end=2.0, **options)
        assert last(sol, "rotor.theta", "rotor.omega") == pytest.approx([theta, omega], abs=1e-9)


def test_the_derivative_of_a_fast_filter_is_a_backward_difference():
    """filter_time far below `sample`: kd (m_k - m_(k-1))/sample."""
    servo = fm.PID("servo", "rotor.theta", "shaft", kp=0.02, kd=2e-3, filter_time=1e-9, sample=0.05)
    theta, omega, before = 0.0, 4.0, 0.0
    for _ in range(12):
        alpha = (-0.02 * theta - 2e-3 * (theta - before) / 0.05) / J
        before = theta
        theta, omega = theta + 0.05 * omega + 0.5 * alpha * 0.05**2, omega + 0.05 * alpha
    sol = fm.simulate(rotor(servo, omega=4.0), t_end=0.6, **STEPS["radau"])
    assert last(sol, "rotor.theta", "rotor.omega") == pytest.approx([theta, omega], abs=1e-9)


def test_the_sampled_law_with_slow_filter_and_limit():
    """g(T) = (1 - exp(-dt/T))/dt in place of 1/T of the filter and of the back-calculation."""
    dt, kp, ki, kd, weight, times, most = 0.05, 0.06, 0.05, 4e-3, 0.7, (0.08, 0.2), 0.02
    servo = fm.PID(
        "servo", "rotor.theta", "shaft", target=1.0, kp=kp, ki=ki, kd=kd, weight=weight, limit=most, sample=dt,
        filter_time=times[0], tracking_time=times[1], derivative_of="error",
    )  # fmt: skip
    of_filter, of_limit = ((1.0 - math.exp(-dt / T)) / dt for T in times)
    theta, omega, integral, f, outputs = 0.0, 0.0, 0.0, 1.0, []
    for _ in range(40):
        error = 1.0 - theta
        slope = of_filter * (error - f)
        wanted = kp * (weight - theta) + integral + kd * slope
        output = min(max(wanted, -most), most)
        integral, f = integral + dt * (ki * error + of_limit * (output - wanted)), f + dt * slope
        theta, omega = theta + dt * omega + 0.5 * output / J * dt**2, omega + dt * output / J
        outputs.append(output)
    assert 5 < np.sum(np.abs(outputs) == most) < 35  # limited, and not
    sol = fm.simulate(rotor(servo), t_end=40 * dt, **STEPS["radau"])
    assert last(sol, "rotor.theta", "rotor.omega") == pytest.approx([theta, omega], abs=1e-9)


def test_no_instant_is_missed_and_outputs_hold():
    """0.1 and 0.03 have common multiples that differ by round-off; 400 instants by steps longer than the samples."""
    first = fm.Control("first", [], ["shaft"], counting, numbers=[0.1], states=1, sample=0.1)
    second = fm.Control("second", [], [], counting, numbers=[0.03], states=1, outputs=["time"], sample=0.03)
    sol = fm.simulate(rotor(first, second), t_end=12.0, save=1200)
    t = np.asarray(sol.time)
    assert float(sol["first.state1"][-1]) == pytest.approx(121.0, abs=1e-9)  # 0 and 120 instants
    assert float(sol["second.state1"][-1]) == pytest.approx(401.0, abs=1e-9)
    between = np.abs(t / 0.1 - np.round(t / 0.1)) > 1e-6
    assert np.asarray(sol["first.output1"])[between] == pytest.approx(np.floor(t[between] / 0.1) * 0.1, abs=1e-12)
    at = np.round(t / 0.1).astype(int)[~between]
    assert np.asarray(sol["first.output1"])[~between] == pytest.approx(0.1 * at, abs=1e-12)  # values just after


def test_forces_can_be_read_at_instants():
    """A sampled controller reads the force of a joint just before its instant: with the torque held until then."""
    servo = fm.Control("servo", ["hinge.fx"], ["actuator"], hundredth, sample=0.1)
    sol = fm.simulate(arm(servo), t_end=0.5, save=5, step=fm.Adaptive(rtol=1e-7))
    assert len(sol.time) == 6
    torque, theta, omega = (np.asarray(sol[name]) for name in ("servo.output1", "arm.theta", "arm.omega"))
    alpha = (torque[:-1] - WEIGHT * ARM * np.cos(theta[1:])) / ARM_INERTIA
    force = -ARM * (alpha * np.sin(theta[1:]) + omega[1:] ** 2 * np.cos(theta[1:]))  # mass 1 kg times acceleration
    assert torque[1:] == pytest.approx(0.01 * force, rel=1e-6)


@pytest.mark.parametrize("method", [None, fm.RadauIIA(), fm.RungeKutta4()], ids=["newmark", "radau", "runge-kutta"])
@pytest.mark.parametrize("share", [0.31, 0.5])
def test_a_restart_goes_on_bit_for_bit(method, share):
    servo = fm.PID("servo", "rotor.omega", target=20.0, kp=0.3, ki=2.0, kd=1e-3, sample=0.02, limit=5.0)
    step = 1e-4 if isinstance(method, fm.RungeKutta4) else None
    model = rotor(servo, motor("servo.output"))
    assert different(*cut_and_continued(model, 0.2, share, method=method, step=step)) == []


def test_a_restart_at_an_instant_does_not_repeat_it():
    law = fm.Control("servo", [], ["shaft"], counting, numbers=[0.01], states=1, sample=0.01)
    whole = fm.simulate(rotor(law), t_end=0.06)
    first = fm.simulate(rotor(law), t_end=0.03)
    second = fm.simulate(rotor(law), t_end=0.06, restart=first.restart)
    assert float(first["servo.state1"][-1]) == pytest.approx(4.0, abs=1e-9)
    assert float(second["servo.state1"][-1]) == pytest.approx(7.0, abs=1e-9)
    assert last(second, "rotor.theta") == pytest.approx(last(whole, "rotor.theta"), rel=1e-9)


@pytest.mark.slow
def test_checkpoints_hold_sampled_controllers(tmp_path):
    servo = fm.PID("servo", "rotor.omega", target=20.0, kp=0.3, ki=2.0, sample=0.02)
    model = rotor(servo, motor("servo.output"))
    whole = fm.simulate(model, t_end=0.2, checkpoint=tmp_path / "run.nc", checkpoint_every=0.0001)
    assert different(whole.restart, fm.simulate(model, t_end=0.2).restart) == []


def test_steps_one_at_a_time_are_those_of_simulate():
    servo = fm.PID("servo", "rotor.omega", target=20.0, kp=0.3, ki=2.0, sample=0.02)
    model = rotor(servo, motor("servo.output"))
    final = list(fm.steps(model, t_end=0.2))[-1]
    assert different(final.restart, fm.simulate(model, t_end=0.2).restart) == ["clock"]  # which counts saved instants


def test_a_failing_law_ends_the_run_with_its_inputs():
    sol = fm.simulate(rotor(fm.Control("servo", ["rotor.omega"], ["shaft"], root, sample=0.1)), t_end=1.0)
    assert not sol.ok
    assert (
        "'root' of controller 'servo' gave numbers that are not finite, at t = 0.3 s with the inputs u = ["
        in sol.status
    )


def test_sampling_times_are_checked():
    for sample in (0.0, -0.1, float("nan"), 1e-18):
        with pytest.raises(InputError, match="Control 'servo': sample is"):
            fm.Control("servo", [], ["shaft"], counting, numbers=[1.0], states=1, sample=sample)
    law = fm.Control("servo", [], ["shaft"], counting, numbers=[9.0], states=1, sample=9.0)  # longer than the run
    assert last(fm.simulate(rotor(law), t_end=0.1), "servo.state1") == pytest.approx([1.0])


@fm.control_kernel
def multiple(p, t, u, x, dx, y):
    """Input times a gain."""
    y[0] = p[0] * u[0]


@pytest.mark.parametrize("order", [1, -1], ids=["source first", "source last"])
def test_a_sampled_law_reads_another_one_with_the_output_of_before_the_instant(order):
    """Mass pulled back by -6 x of the instant before the last one: parabolas between instants, no force at first."""
    mass, dt = fm.bodies.PointMass("mass", at=(1.0, 0.0), mass=1.0), 0.05
    pull = fm.Force("pull", mass, at=(1.0, 0.0), force=(1.0, 0.0))
    cell = fm.Control("cell", ["mass.x"], [], multiple, numbers=(3.0,), outputs=["out"], sample=dt)
    law = fm.Control("law", ["cell.out"], [pull], multiple, numbers=(-2.0,), sample=dt)
    sol = fm.simulate(fm.Mechanism("two laws", [mass, pull, *[cell, law][::order]]), t_end=40 * dt, save=40)
    x, v, before = 1.0, 0.0, 0.0
    for computed in sol["mass.x"].values:
        assert computed == pytest.approx(x, abs=1e-11)
        force, before = -6.0 * before, x
        x, v = x + v * dt + 0.5 * force * dt * dt, v + force * dt
