"""A direct-current motor drives a wheel through a pair of gears against a brake.

Speeds are in the ratio of the teeth; with V, R, k and a viscous brake c behind the ratio n the steady speed of the
motor is k V/(k^2 + R c n^2), n = z1/z2.  The tooth force is F_t along the tangent and F_t tan(20 deg) along the
centres in both bearings.  Source: J. E. Shigley, Mechanical Engineering Design, McGraw-Hill, section 13-14.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fm

TEETH, MODULE = (18, 54), 2e-3
R1, R2 = TEETH[0] * MODULE / 2.0, TEETH[1] * MODULE / 2.0
J1, J2 = 4e-5, 2e-3
VOLTS, OHMS, K, HENRY = 24.0, 0.8, 0.06, 2e-3
BRAKE = 0.02  # [N m s]
TAN = math.tan(math.radians(20.0))


def gearbox():
    pinion = fm.RigidBody("pinion", at=(0.0, 0.0), mass=0.1, inertia=J1, velocity=(0.0, 0.0, 0.0))
    wheel = fm.RigidBody("wheel", at=(R1 + R2, 0.0), mass=0.9, inertia=J2, velocity=(0.0, 0.0, 0.0))
    return fm.Mechanism("gears", [
        pinion, wheel,
        fm.Revolute("P", fm.GROUND, pinion, at=(0.0, 0.0)),
        fm.Revolute("W", fm.GROUND, wheel, at=(R1 + R2, 0.0)),
        fm.Gear("mesh", pinion, wheel, teeth=TEETH),
        fm.Torque("shaft", pinion, 1.0),
        fm.controllers.DCMotor("motor", "pinion.omega", "shaft", voltage=VOLTS, resistance=OHMS, torque_constant=K,
                               inductance=HENRY),
        fm.TorsionSpring("brake", fm.GROUND, wheel, stiffness=0.0, damping=BRAKE),
    ], gravity=(0.0, 0.0))  # fmt: skip


@pytest.fixture(scope="module")
def started():
    times = np.linspace(0.0, 1.5, 151)
    return fm.simulate(gearbox(), t_end=1.5, save=times, step=fm.Adaptive(rtol=1e-6)).require()


def test_the_motor_starts_as_the_equations_by_hand(started):
    n = TEETH[0] / TEETH[1]
    inertia, brake = J1 + n**2 * J2, n**2 * BRAKE

    def rates(_, y):
        current, speed = y
        return [(VOLTS - OHMS * current - K * speed) / HENRY, (K * current - brake * speed) / inertia]

    exact = solve_ivp(rates, (0.0, 1.5), (0.0, 0.0), t_eval=started.time, rtol=1e-10, atol=1e-10).y
    assert started["pinion.omega"].values == pytest.approx(exact[1], abs=2e-5 * exact[1].max())
    assert started["motor.current"].values == pytest.approx(exact[0], abs=1e-4 * exact[0].max())


def test_steady_speeds_and_torques_have_the_ratio_of_the_teeth(started):
    n = TEETH[0] / TEETH[1]
    speed = K * VOLTS / (K**2 + OHMS * BRAKE * n**2)
    assert float(started["pinion.omega"][-1]) == pytest.approx(speed, rel=1e-4)
    assert float(started["wheel.omega"][-1]) == pytest.approx(-n * speed, rel=1e-4)
    assert float(started["motor.torque"][-1]) == pytest.approx(BRAKE * n**2 * speed, rel=1e-3)


def test_the_tooth_force_stands_in_both_bearings(started):
    """The wheel is braked by c w2 and J2 dw2/dt; its tooth force is their sum over r2."""
    omega = started["wheel.omega"].values
    pinion = started["pinion.omega"].values
    ratio = TEETH[0] / TEETH[1]
    rate = (K * started["motor.current"].values - ratio**2 * BRAKE * pinion) / (J1 + ratio**2 * J2)
    tangential = np.abs(J2 * -ratio * rate + BRAKE * omega) / R2
    scale = tangential.max()
    assert np.abs(started["mesh.force"].values) == pytest.approx(tangential, abs=1e-5 * scale)
    for pin in "PW":
        assert np.abs(started[f"{pin}.fy"].values) == pytest.approx(tangential, abs=1e-5 * scale)
        assert np.abs(started[f"{pin}.fx"].values) == pytest.approx(tangential * TAN, abs=1e-5 * scale)
        assert started[f"{pin}.force"].values == pytest.approx(tangential * math.hypot(1.0, TAN), abs=1e-5 * scale)
    assert started["P.fx"].values == pytest.approx(-started["W.fx"].values, abs=1e-5 * scale)
    assert (started["W.fx"].values[5:] < 0.0).all()  # its bearing holds the wheel against the pinion
