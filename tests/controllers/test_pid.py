"""PID controllers that act at all times, against equations written by hand."""

import numpy as np
import pytest
from plants import ARM, ARM_INERTIA, WEIGHT, arm, cut_and_continued, different, last
from scipy.integrate import solve_ivp

import flexmb as fm

TIGHT = {
    "newmark": {"step": fm.Adaptive(rtol=1e-8)},
    "radau": {"method": fm.RadauIIA(), "step": fm.Adaptive(rtol=1e-9)},
    "runge-kutta": {"method": fm.RungeKutta4(), "step": fm.FixedStep(1e-4)},
}
ONE_FAST = [TIGHT["newmark"], *(pytest.param(TIGHT[n], marks=pytest.mark.slow) for n in ("radau", "runge-kutta"))]


def exact(rates, start, t_end, longest=np.inf):
    """End of the motion of first-order equations, by an independent integrator."""
    tight = {"method": "Radau", "rtol": 1e-11, "atol": 1e-12, "max_step": longest}
    return solve_ivp(rates, (0.0, t_end), start, **tight).y[:, -1]


@pytest.mark.parametrize(
    ("gains", "own"),
    [pytest.param({"kd": 1.0}, ["filter"], marks=pytest.mark.slow), ({"ki": 9.0, "kd": 1.0}, ["integral", "filter"])],
)
def test_its_signals_are_those_of_its_docstring(gains, own, tmp_path):
    """No integrals and rates of states, and no states that fill up a node; a file and a restart do without them."""
    model = arm(fm.PID("servo", "tip.theta", "actuator", target=1.0, kp=40.0, **gains))
    sol = fm.simulate(model, t_end=0.05)
    assert [name for name in sol if name.startswith("servo.")] == [f"servo.{name}" for name in (*own, "output")]
    assert set(fm.check(model).signals) == set(sol.names)
    assert fm.load(sol.to_netcdf(tmp_path / "a.nc")).names == sol.names
    asked = fm.simulate(model, t_end=0.05, signals=["servo.filter_rate", "arm.theta"])
    assert np.array_equal(asked.array("arm.theta"), sol.array("arm.theta"))
    slope = np.gradient(sol.array("servo.filter"), sol.time)
    assert asked.array("servo.filter_rate")[5:-5] == pytest.approx(slope[5:-5], abs=0.02 * np.abs(slope).max())
    with pytest.raises(fm.errors.InputError, match=r"no signal fits 'servo.unused\*'"):
        fm.simulate(model, t_end=0.05, signals=["servo.unused*"])


def gravity_torque(theta):
    return WEIGHT * ARM * np.cos(theta)


@pytest.mark.slow
@pytest.mark.parametrize("options", ONE_FAST, ids=TIGHT)
def test_a_pd_controller_moves_a_pendulum(options):
    servo = fm.PID("servo", "tip.theta", "actuator", target=1.0, kp=20.0, kd=1.5, rate="tip.omega")

    def rates(t, y):
        torque = 20.0 * (1.0 - y[0]) - 1.5 * y[1]
        return [y[1], (torque - gravity_torque(y[0])) / ARM_INERTIA]

    sol = fm.simulate(arm(servo), t_end=1.0, **options)
    assert sol.ok
    assert last(sol, "arm.theta", "arm.omega") == pytest.approx(exact(rates, [0.0, 0.0], 1.0), abs=1e-6)


@pytest.mark.parametrize("options", ONE_FAST, ids=TIGHT)
def test_a_pid_controller_with_filter_limit_and_anti_windup(options):
    servo = fm.PID(
        "servo", "tip.theta", "actuator", target=1.0, kp=40.0, ki=100.0, kd=4.0, limit=8.0, filter_time=0.02,
        tracking_time=0.3, weight=0.7,
    )  # fmt: skip

    def rates(t, y):
        theta, omega, integral, smooth = y
        slope = (-theta - smooth) / 0.02
        wanted = 40.0 * (0.7 - theta) + integral + 4.0 * slope
        torque = np.clip(wanted, -8.0, 8.0)
        rate = 100.0 * (1.0 - theta) + (torque - wanted) / 0.3
        return [omega, (torque - gravity_torque(theta)) / ARM_INERTIA, rate, slope]

    sol = fm.simulate(arm(servo), t_end=0.8, **options)
    found = last(sol, "arm.theta", "arm.omega", "servo.integral", "servo.filter")
    expected = exact(rates, [0.0, 0.0, 0.0, 0.0], 0.8, longest=1e-3)
    assert found == pytest.approx(expected, rel=1e-6, abs=2e-6)
    assert float(np.abs(sol["servo.output"]).max()) == 8.0  # the limit is met, and kept


def test_anti_windup_stops_the_overshoot():
    """While the output is limited the integral must not grow without bound."""
    gains = {"target": 1.0, "kp": 30.0, "ki": 60.0, "kd": 4.0, "limit": 4.0}

    def overshoot(**more):
        sol = fm.simulate(arm(fm.PID("servo", "tip.theta", "actuator", **gains, **more)), t_end=6.0)
        return float(sol["tip.theta"].max()) - 1.0

    assert overshoot(tracking_time=1e6) > 0.25  # as without anti-windup
    assert overshoot() < 0.5 * overshoot(tracking_time=1e6)


def test_the_integral_removes_the_error_of_a_load():
    """At rest the output is the torque of gravity: 1 kg 9.81 m/s^2 0.25 m cos(1)."""
    servo = fm.PID("servo", "tip.theta", "actuator", target=1.0, kp=40.0, ki=100.0, kd=4.0)
    sol = fm.simulate(arm(servo), t_end=10.0)
    assert last(sol, "tip.theta", "servo.output") == pytest.approx([1.0, 9.81 * 0.25 * np.cos(1.0)], abs=1e-6)


def test_the_filter_starts_settled():
    """The first output is that of proportional action alone, wherever the mechanism begins."""
    link = fm.RigidLink("arm", (0.0, 0.0), (0.3, 0.4), mass=1.0, inertia=1.0 / 48.0)
    for sample in (None, 0.01):
        servo = fm.PID("servo", "tip.x", "actuator", target=0.1, kp=50.0, kd=5.0, sample=sample)
        hinge = fm.Revolute("hinge", fm.GROUND, link, at=(0.0, 0.0))
        parts = [link, hinge, fm.Marker("tip", link, at=(0.3, 0.4)), fm.Torque("actuator", link, 1.0), servo]
        sol = fm.simulate(fm.Mechanism("robot", parts), t_end=0.05)
        assert float(sol["servo.output"][0]) == pytest.approx(50.0 * (0.1 - 0.3), rel=1e-12)
        assert float(sol["servo.filter"][0]) == pytest.approx(-0.3, rel=1e-9 if sample is None else 0.2)


@pytest.mark.slow
def test_a_moving_target_is_followed():
    """With the derivative of the error a moving target is met; each jump of the target is an instant of the run."""
    ramp = fm.drives.Harmonic(0.4, 3.0)
    servo = fm.PID(
        "servo", "tip.theta", "actuator", target=ramp, kp=40.0, kd=3.0, rate="tip.omega", derivative_of="error"
    )

    def rates(t, y):
        s, s_dot, _ = ramp.kernel(np.array(ramp.parameters()), t)
        torque = 40.0 * (s - y[0]) + 3.0 * (s_dot - y[1])
        return [y[1], (torque - gravity_torque(y[0])) / ARM_INERTIA]

    sol = fm.simulate(arm(servo), t_end=1.0, step=fm.Adaptive(rtol=1e-8))
    assert last(sol, "arm.theta", "arm.omega") == pytest.approx(exact(rates, [0.0, 0.0], 1.0), abs=1e-6)


@pytest.mark.slow
def test_a_target_that_jumps():
    jump = fm.drives.Pulse(0.5, start=0.31, end=2.0)
    servo = fm.PID("servo", "tip.theta", "actuator", target=jump, kp=40.0, kd=3.0, rate="tip.omega")

    def rates(target):
        return lambda t, y: [y[1], (40.0 * (target - y[0]) - 3.0 * y[1] - gravity_torque(y[0])) / ARM_INERTIA]

    middle = exact(rates(0.0), [0.0, 0.0], 0.31)
    sol = fm.simulate(arm(servo), t_end=0.8, step=fm.Adaptive(rtol=1e-8))
    assert last(sol, "arm.theta", "arm.omega") == pytest.approx(exact(rates(0.5), middle, 0.49), abs=1e-6)


def test_energies_balance():
    """The work of the actuator is booked as that of a load: kinetic energy and potential grow by it."""
    servo = fm.PID("servo", "tip.theta", "actuator", target=1.0, kp=40.0, ki=100.0, kd=4.0, limit=8.0)
    sol = fm.simulate(arm(servo), t_end=0.8, step=fm.Adaptive(rtol=1e-7))
    lifted = 9.81 * float(sol["arm.y"][-1] - sol["arm.y"][0])
    gained = 0.5 * ARM_INERTIA * float(sol["arm.omega"][-1]) ** 2 + lifted
    assert float(sol["energy.load_work"][-1]) == pytest.approx(gained, rel=1e-5)
    power = np.asarray(sol["servo.output"]) * np.asarray(sol["arm.omega"])
    assert float(np.trapezoid(power, sol.time)) == pytest.approx(gained, rel=1e-4)


@pytest.mark.parametrize("method", [None, fm.RadauIIA()], ids=["newmark", "radau"])
def test_a_restart_goes_on_bit_for_bit(method):
    servo = fm.PID("servo", "tip.theta", "actuator", target=1.0, kp=40.0, ki=100.0, kd=4.0, limit=8.0)
    assert different(*cut_and_continued(arm(servo), 0.5, method=method)) == []


def test_a_controller_on_a_flexible_link():
    """A PD controller holds a link at its end: at rest the torque is the moment of its weight."""
    section = fm.Rectangle(width=0.02, height=0.01)
    beam = fm.FlexibleLink("arm", (0.0, 0.0), (0.5, 0.0), section=section, material=fm.STEEL, elements=2, damping=1e-3)
    parts = [
        beam,
        fm.Revolute("hinge", fm.GROUND, beam, at=(0.0, 0.0)),
        fm.Torque("actuator", beam, 1.0, at=(0.0, 0.0)),
    ]
    servo = fm.PID("servo", "arm.start.theta", "actuator", kp=200.0, kd=8.0, rate="arm.start.omega")
    sol = fm.simulate(fm.Mechanism("robot", [*parts, servo], gravity=(0.0, -9.81)), t_end=3.0)
    mass = fm.STEEL.density * 0.02 * 0.01 * 0.5
    assert sol.ok
    assert float(sol["servo.output"][-1]) == pytest.approx(mass * 9.81 * 0.25, rel=1e-3)
    assert float(sol["arm.start.theta"][-1]) == pytest.approx(-mass * 9.81 * 0.25 / 200.0, rel=1e-3)
