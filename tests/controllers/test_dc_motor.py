"""DC motors against closed forms."""

import numpy as np
import pytest
from plants import ARM_INERTIA, MOTOR, J, K, L, N, R, arm, cut_and_continued, different, last, linear, motor, rotor

import flexmb as fm

TIGHT = {
    "newmark": ({"step": fm.Adaptive(rtol=1e-8)}, 2e-7),
    "radau": ({"method": fm.RadauIIA(), "step": fm.Adaptive(rtol=1e-10)}, 1e-10),
    "runge-kutta": ({"method": fm.RungeKutta4(), "step": fm.FixedStep(2e-4)}, 1e-10),
}


@pytest.mark.parametrize(("options", "error"), TIGHT.values(), ids=TIGHT)
def test_a_motor_runs_up(options, error):
    sol = fm.simulate(rotor(motor(12.0)), t_end=0.3, **options)
    expected = linear(MOTOR, [12.0 / L, 0.0], [0.0, 0.0], 0.3)
    assert sol.ok
    assert last(sol, "motor.current", "rotor.omega") == pytest.approx(expected, abs=error)
    assert float(sol["motor.torque"][-1]) == pytest.approx(K * N * expected[0], abs=error)


def test_a_motor_without_inductance_is_of_first_order():
    """J omega' = k n (V - k n omega)/R."""
    sol = fm.simulate(rotor(motor(12.0, inductance=0.0)), t_end=0.2, step=fm.Adaptive(rtol=1e-8))
    end, rate = 12.0 / (K * N), (K * N) ** 2 / (R * J)
    omega = end * (1.0 - np.exp(-0.2 * rate))
    assert float(sol["rotor.omega"][-1]) == pytest.approx(omega, rel=1e-7)
    assert float(sol["motor.current"][-1]) == pytest.approx((12.0 - K * N * omega) / R, rel=1e-6)


def test_supplied_energy_is_heat_magnetic_energy_and_work():
    """Integral of V i = integral of R i^2 + L i^2/2 + work of the shaft, with a voltage that changes in time."""
    wave = fm.drives.Harmonic(9.0, 20.0)
    sol = fm.simulate(rotor(motor(wave, current=0.5)), t_end=0.5, save="steps", step=fm.Adaptive(rtol=1e-7))
    current, t = np.asarray(sol["motor.current"]), np.asarray(sol.time)
    supplied = np.trapezoid(np.asarray(sol["motor.voltage"]) * current, t)
    heat = np.trapezoid(R * current**2, t)
    stored = 0.5 * L * (current[-1] ** 2 - 0.5**2)
    work = float(sol["energy.load_work"][-1])
    assert supplied == pytest.approx(heat + stored + work, rel=1e-5)
    assert work == pytest.approx(0.5 * J * float(sol["rotor.omega"][-1]) ** 2, rel=1e-5)


def test_a_controller_drives_the_voltage():
    """Speed control: a PI controller whose output the motor reads, at all times."""
    servo = fm.PID("servo", "rotor.omega", target=20.0, kp=0.3, ki=2.0)
    A = np.zeros((3, 3))
    A[:2, :2] = MOTOR
    A[0, 1] -= 0.3 / L
    A[0, 2], A[2, 1] = 1.0 / L, -2.0
    expected = linear(A, [0.3 * 20.0 / L, 0.0, 40.0], np.zeros(3), 0.3)
    for parts in ((servo, motor("servo.output")), (motor("servo.output"), servo)):  # declared in any order
        sol = fm.simulate(rotor(*parts), t_end=0.3, step=fm.Adaptive(rtol=1e-8))
        assert last(sol, "motor.current", "rotor.omega", "servo.integral") == pytest.approx(expected, abs=3e-7)


def test_a_motor_does_not_depend_on_the_frame():
    """Turned by 1.1 rad and shifted by (3, -2) m, an arm moves as before."""

    def speed(angle, origin):
        c, s, (x, y) = np.cos(angle), np.sin(angle), origin
        end = (x + 0.5 * c, y + 0.5 * s)
        link = fm.RigidLink("arm", origin, end, mass=1.0, inertia=1.0 / 48.0)
        parts = [link, fm.Revolute("hinge", fm.GROUND, link, at=origin), fm.Marker("tip", link, at=end)]
        values = {"voltage": 6.0, "resistance": R, "inductance": L, "torque_constant": 0.5}
        drive = fm.controllers.DCMotor("motor", "tip.omega", "actuator", **values)
        parts += [fm.Torque("actuator", link, 1.0), drive]
        gravity = (9.81 * s, -9.81 * c)
        tight = {"method": fm.RadauIIA(), "step": fm.Adaptive(rtol=1e-10)}
        sol = fm.simulate(fm.Mechanism("robot", parts, gravity=gravity), t_end=0.5, **tight)
        return last(sol, "arm.omega", "motor.current")

    assert speed(1.1, (3.0, -2.0)) == pytest.approx(speed(0.0, (0.0, 0.0)), abs=1e-9)


@pytest.mark.parametrize("method", [None, fm.RadauIIA()], ids=["newmark", "radau"])
def test_a_restart_goes_on_bit_for_bit(method):
    assert different(*cut_and_continued(rotor(motor(12.0)), 0.1, method=method)) == []


def test_states_and_outputs_stand_among_the_signals():
    own = ["motor.current_integral", "motor.current_rate"]  # by their whole names alone
    sol = fm.simulate(rotor(motor(12.0)), t_end=0.01, signals=["motor.*", *own])
    assert dict(zip(sol.signals.names, sol.signals.units, strict=True)) == {
        "motor.current_integral": "A s", "motor.current": "A", "motor.current_rate": "A/s",
        "motor.torque": "N m", "motor.voltage": "V",
    }  # fmt: skip
    assert float(sol["motor.current_rate"][0]) == pytest.approx(12.0 / L, rel=1e-12)
    charge = np.trapezoid(np.asarray(sol["motor.current"]), np.asarray(sol.time))
    assert float(sol["motor.current_integral"][-1]) == pytest.approx(charge, rel=1e-5)


def test_momentum_counts_bodies_alone():
    model = arm(fm.PID("servo", "tip.theta", "actuator", target=1.0, kp=40.0, ki=100.0, kd=4.0))
    sol = fm.simulate(model, t_end=0.1)
    found = fm.momentum(model, sol)
    assert found.mass == 1.0
    assert float(found.angular[-1]) == pytest.approx(ARM_INERTIA * float(sol["arm.omega"][-1]), rel=1e-9)
