"""Derivatives through controllers: beside closed forms and beside differences of runs."""

from functools import partial

import numpy as np
import pytest
from designs import CENTRAL

import flexmb as fm
from flexmb.design.derivatives import sensitivity
from flexmb.errors import InputError

SHARP = fm.Adaptive(rtol=1e-9)


@fm.control_kernel
def brake(p, t, u, x, dx, y):
    """Torque against the speed."""
    y[0] = -p[0] * u[0]


def braked(gain: float, inertia: float, sample: float | None = 0.01) -> fm.Mechanism:
    """A rotor at 2 rad/s with a brake."""
    rotor = fm.RigidBody("rotor", (0.0, 0.0), 1.0, inertia, velocity=(0.0, 0.0, 2.0))
    axis = fm.Revolute("axis", fm.GROUND, rotor, at=(0.0, 0.0))
    law = fm.Control("brake", ["rotor.omega"], ["torque"], law=brake, numbers=[gain], sample=sample)
    return fm.Mechanism("rotor", [rotor, axis, fm.Torque("torque", rotor, 1.0), law])


def arm(kp: float, ki: float, kd: float, target: float, mass: float, *, sample: float | None = None) -> fm.Mechanism:
    """A servo that lifts an arm."""
    link = fm.RigidLink("arm", (0.0, 0.0), (0.5, 0.0), mass, mass / 48.0)
    gains = {"kp": kp, "ki": ki, "kd": kd, "target": target, "sample": sample}
    parts = [link, fm.Revolute("hinge", fm.GROUND, link, at=(0.0, 0.0)), fm.Torque("actuator", link, 1.0)]
    return fm.Mechanism("robot", [*parts, fm.PID("servo", "arm.theta", "actuator", **gains)], (0.0, -9.81))


def swaying(amplitude: float, kp: float, kd: float) -> fm.Mechanism:
    """A sampled servo whose target moves."""
    return arm(kp, 0.0, kd, fm.drives.Harmonic(amplitude, 3.0), 1.0, sample=0.01)


def powered(kp: float, resistance: float, inductance: float) -> fm.Mechanism:
    """A sampled controller of speed that gives a motor its voltage."""
    rotor = fm.RigidBody("rotor", (0.0, 0.0), 1.0, 2e-3)
    parts = [rotor, fm.Revolute("axis", fm.GROUND, rotor, at=(0.0, 0.0)), fm.Torque("shaft", rotor, 1.0)]
    loop = fm.PID("loop", "rotor.omega", target=50.0, kp=kp, ki=1.0, sample=0.01)
    numbers = {"voltage": "loop.output", "resistance": resistance, "inductance": inductance, "torque_constant": 0.05}
    return fm.Mechanism("fan", [*parts, loop, fm.controllers.DCMotor("motor", "rotor.omega", "shaft", **numbers)])


def test_sampled_brake_has_the_derivatives_of_its_recursion():
    """omega_(n+1) = (1 - k T / J) omega_n; the held torque has its mean over the intervals."""
    k, J, T, n = 1.0, 0.5, 0.01, np.arange(31)
    found = sensitivity(braked, {"gain": k, "inertia": J}, of=["rotor.omega", "brake.output1"], t_end=0.3, save=30)
    factor = 1.0 - k * T / J
    by_gain = -2.0 * n * T / J * factor ** np.maximum(n - 1, 0)
    np.testing.assert_allclose(found["rotor.omega"].values, [by_gain, -k / J * by_gain], rtol=1e-7, atol=1e-9)
    torque = -2.0 * factor**n - k * by_gain
    np.testing.assert_allclose(found["brake.output1"].values[0, :-1], torque[:-1], rtol=1e-7)
    mean = found.measures.derivative.sel(measure="mean of brake.output1", parameter="gain")
    assert float(mean) == pytest.approx(torque[:-1].mean(), rel=1e-7)


def test_brake_at_all_times_has_the_derivatives_of_its_decay():
    given = {"gain": 1.0, "inertia": 0.5}
    model = partial(braked, sample=None)
    found = sensitivity(model, given, of=["rotor.omega", "brake.output1"], t_end=1.0, save=10, step=SHARP)
    t = np.linspace(0.0, 1.0, 11)
    slope = -2.0 * t / 0.5 * np.exp(-2.0 * t)
    np.testing.assert_allclose(found["rotor.omega"].values, [slope, -2.0 * slope], atol=1e-6)
    np.testing.assert_allclose(found["brake.output1"].values[0], -2.0 * np.exp(-2.0 * t) - slope, atol=1e-6)


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("model", "given", "of", "bound"),
    [
        pytest.param(
            arm,
            {"kp": 200.0, "ki": 100.0, "kd": 20.0, "target": 1.0, "mass": 1.0},
            ["arm.theta", "servo.output"],
            2e-5,
            marks=pytest.mark.slow,
        ),
        (
            partial(arm, sample=0.005),
            {"kp": 200.0, "ki": 100.0, "kd": 10.0, "target": 1.0, "mass": 1.0},
            ["arm.theta", "servo.output"],
            2e-5,
        ),
        (swaying, {"amplitude": 1.0, "kp": 50.0, "kd": 5.0}, ["arm.theta", "servo.output"], 1e-5),
        (powered, {"kp": 0.2, "resistance": 2.0, "inductance": 1e-2}, ["rotor.omega", "motor.current"], 1e-5),
    ],
    ids=["all times", "sampled", "moving target", "motor"],
)
def test_controllers_agree_with_differences(model, given, of, bound):
    times = np.linspace(0.0, 0.25, 6)
    found = sensitivity(model, given, of=of, t_end=0.25, save=times, step=SHARP)
    for name, value in given.items():
        h, expected = 1e-3 * value, 0.0
        for place, weight in CENTRAL:
            mechanism = model(**given | {name: value + place * h})
            sol = fm.simulate(mechanism, t_end=0.25, save=times.tolist(), step=SHARP)
            expected = expected + weight / h * np.array([np.asarray(sol[s]) for s in of])
        for row, signal in zip(expected, of, strict=True):
            own = found[signal].sel(parameter=name).values
            assert np.abs(own - row).max() < bound * np.abs(row).max(), (name, signal)


def test_instants_of_a_controller_have_no_derivative():
    with pytest.raises(InputError, match="sample moves instants"):
        sensitivity(partial(braked, 1.0, 0.5), {"sample": 0.01}, of=["rotor.omega"], t_end=0.1)
