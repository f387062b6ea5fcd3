"""Arm with a flexible forearm: its frequencies with the elbow held, free and on an upper arm.

Clamped and free: (b L)^2 = 3.5160, 22.0345; pinned and free: 15.4182, 49.9649, times sqrt(E I/(rho A L^4)).
Source: R. D. Blevins, Formulas for Natural Frequency and Mode Shape, Krieger 1984, table 8-1.
"""

import math

import numpy as np
import pytest

import flexmb as fm

UPPER, FORE = 0.4, 0.5
SECTION = fm.Rectangle(width=0.03, height=0.004)
EI, RHO_A = fm.STEEL.young * 0.03 * 0.004**3 / 12.0, fm.STEEL.density * 0.03 * 0.004
UNIT = math.sqrt(EI / (RHO_A * FORE**4))  # [rad/s]
ELBOW, TIP = (UPPER, 0.0), (UPPER + FORE, 0.0)
STOP = 0.3  # [s]


def arm(*parts, shoulder=None):
    upper = fm.RigidLink("upper", (0.0, 0.0), ELBOW, mass=2.0, inertia=0.03)
    fore = fm.FlexibleLink("fore", ELBOW, TIP, section=SECTION, material=fm.STEEL, elements=8)
    pins = [fm.Revolute("shoulder", fm.GROUND, upper, at=(0.0, 0.0)), fm.Revolute("elbow", upper, fore, at=ELBOW)]
    motor = fm.Drive("motor", "shoulder", shoulder or fm.drives.Polynomial((0.0,)))
    return fm.Mechanism("arm", [upper, fore, *pins, motor, *parts], gravity=(0.0, 0.0))


def held(motion=None):
    return fm.Drive("servo", "elbow", motion or fm.drives.Polynomial((0.0,)))


def test_with_a_servo_that_holds_the_forearm_is_clamped():
    found = fm.modes(arm(held()), count=2).frequencies * 2.0 * math.pi / UNIT
    assert found == pytest.approx([3.51602, 22.0345], rel=1e-3)


def test_without_a_servo_the_forearm_is_pinned():
    found = fm.modes(arm(), count=3).frequencies * 2.0 * math.pi / UNIT
    assert found[0] == pytest.approx(0.0, abs=1e-3)  # it turns as a whole
    assert found[1:] == pytest.approx([15.4182, 49.9649], rel=1e-3)


def test_a_soft_servo_lies_between_them():
    """A forearm on a spring kt at its pin: b^3 (cosh sin - sinh cos) = kt/(E I) (1 + cosh cos), of b = beta L."""
    from scipy.optimize import brentq

    for kt in (1.0, 50.0, 1e4):

        def characteristic(b, c=kt * FORE / EI):
            return b * (math.cosh(b) * math.sin(b) - math.sinh(b) * math.cos(b)) - c * (1 + math.cosh(b) * math.cos(b))

        exact = brentq(characteristic, 0.05, 1.8751040) ** 2
        spring = fm.TorsionSpring("servo", arm()["upper"], arm()["fore"], stiffness=kt, at=ELBOW)
        assert fm.modes(arm(spring), count=1).frequencies[0] * 2.0 * math.pi / UNIT == pytest.approx(exact, rel=1e-4)


def test_after_the_stop_the_tip_swings_with_the_clamped_frequency():
    lift = fm.drives.Table((0.0, STOP / 3.0, STOP / 1.5, STOP), (0.0, 0.1, 0.3, 0.4), slopes=(0.0, 0.0))
    sol = fm.simulate(arm(held(), shoulder=lift), t_end=STOP, save=100).require()
    assert float(sol["upper.theta"][-1]) == pytest.approx(0.4, abs=1e-9)
    swing = fm.simulate(bent(), t_end=1.2, start="equilibrium", save=2400)
    y = swing.require()["fore.end.y"].values
    t = swing.time
    ups = np.flatnonzero((y[:-1] < 0.0) & (y[1:] >= 0.0))
    crossings = t[ups] - y[ups] * (t[ups + 1] - t[ups]) / (y[ups + 1] - y[ups])
    period = (crossings[-1] - crossings[0]) / (len(crossings) - 1)
    assert 2.0 * math.pi / period / UNIT == pytest.approx(3.51602, rel=2e-3)


def bent():
    """A small force at the tip, which is let go after a millisecond."""
    pulse = fm.drives.Pulse(start=-1.0, end=1e-3)
    return arm(held(), fm.Force("pull", arm()["fore"], at=TIP, force=(0.0, 1.0), history=pulse))
