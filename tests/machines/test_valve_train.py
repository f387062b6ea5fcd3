"""Valve train: an eccentric cam, a rocker with a roller and a spring.

The centres of cam and roller keep their distance, so cam and rocker are a four-bar linkage with the rod R + r.  The
contact force F along the rod follows from the rocker: J phi'' = F a(phi) - k (phi - phi0), with its lever a.
Source: J. J. Uicker, G. R. Pennock, J. E. Shigley, Theory of Machines and Mechanisms, 4th ed., Oxford 2011, ch. 6.
"""

import math

import numpy as np
import pytest

import flexmb as fm

E, R, ROLLER, ARM = 0.008, 0.025, 0.01, 0.06  # eccentricity, cam, roller, rocker [m]
PIVOT = (0.055, 0.035)
J, K, FREE = 8e-4, 40.0, 0.25  # [kg m^2], [N m/rad], prestress [rad]


def rocker_angle(turn):
    """Direction from the pivot to the roller, on the upper side, for angles of the cam."""
    x, y = PIVOT[0] - E * np.cos(turn), PIVOT[1] - E * np.sin(turn)  # from the centre of the cam to the pivot
    d = np.hypot(x, y)
    return np.arctan2(-y, -x) - np.arccos((ARM**2 + d**2 - (R + ROLLER) ** 2) / (2.0 * ARM * d))


def rod(turn, phi):
    """Unit vector from the centre of the cam to that of the roller, and that centre from the pivot."""
    arm = ARM * np.stack([np.cos(phi), np.sin(phi)])
    way = np.stack([PIVOT[0] + arm[0] - E * np.cos(turn), PIVOT[1] + arm[1] - E * np.sin(turn)])
    return way / np.hypot(*way), arm


def exact(turn, speed):
    """Contact force and torque of the motor, with derivatives of the Fourier series of the rocker's angle."""
    n = 256
    grid = 2.0 * np.pi * np.arange(n) / n
    series = np.fft.fft(rocker_angle(grid)) / n
    waves = np.fft.fftfreq(n, 1.0 / n)
    basis = np.exp(1j * np.outer(turn, waves))
    phi, second = (basis @ series).real, speed**2 * (basis @ (-(waves**2) * series)).real
    normal, arm = rod(turn, phi)
    lever = arm[0] * normal[1] - arm[1] * normal[0]
    start = rocker_angle(0.0)
    spring = K * (phi - start) + math.copysign(K * FREE, lever[0])
    force = (J * second + spring) / lever
    return phi - start, force, force * E * (np.cos(turn) * normal[1] - np.sin(turn) * normal[0])


def valve(speed, normal=None):
    start = float(rocker_angle(0.0))
    tip = (PIVOT[0] + ARM * math.cos(start), PIVOT[1] + ARM * math.sin(start))
    (_, _), arm = rod(np.array(0.0), np.array(start))
    (nx, ny), _ = rod(np.array(0.0), np.array(start))
    closing = -math.copysign(FREE, float(arm[0] * ny - arm[1] * nx))
    u = np.linspace(0.0, 2.0 * np.pi, 181)[:-1]
    profile = fm.ClosedCurve(np.column_stack([E + R * np.cos(u), R * np.sin(u)]))
    cam = fm.RigidBody("cam", at=(0.0, 0.0), mass=0.4, inertia=1e-4)
    rocker = fm.RigidBody("rocker", at=PIVOT, mass=0.1, inertia=J)
    roller = fm.cams.CircularCurve(tip, ROLLER)
    return fm.Mechanism("valve train", [
        cam, rocker,
        fm.Revolute("O", fm.GROUND, cam, at=(0.0, 0.0)),
        fm.Revolute("Q", fm.GROUND, rocker, at=PIVOT),
        fm.CurveOnCurve("tappet", cam, profile, rocker, roller, normal=normal),
        fm.TorsionSpring("spring", fm.GROUND, rocker, stiffness=K, free_angle=closing),
        fm.Drive("motor", "O", fm.ConstantSpeed(speed)),
    ], gravity=(0.0, 0.0))  # fmt: skip


@pytest.mark.parametrize("speed", [30.0, 250.0])
def test_lift_force_and_torque_follow_from_the_linkage(speed):
    sol = fm.simulate(valve(speed), periods=1, step=fm.Adaptive(rtol=1e-7)).require()
    angle, force, torque = exact(sol["O.angle"].values, speed)
    assert sol["rocker.theta"].values == pytest.approx(angle, abs=1e-8)
    assert sol["tappet.force"].values == pytest.approx(force, abs=2e-5 * np.abs(force).max())
    assert sol["motor.torque"].values == pytest.approx(torque, abs=2e-5 * np.abs(torque).max())
    assert force.min() > 0.0  # pressed together all the time


@pytest.mark.slow
def test_a_contact_lifts_off_beyond_the_speed_of_the_closed_form():
    """The least force falls with the square of the speed at the place where it reaches zero."""
    turn = np.linspace(0.0, 2.0 * np.pi, 721)
    speeds = np.linspace(250.0, 500.0, 251)
    least = np.array([exact(turn, w)[1].min() for w in speeds])
    first = float(np.interp(0.0, -least, speeds))
    law = fm.KelvinVoigt(stiffness=1e7, damping=600.0, ramp=1e-7)
    gaps = []
    for speed in (0.97 * first, 1.05 * first):
        sol = fm.simulate(valve(speed, law), periods=1).require()
        gaps.append(max(float(-sol["tappet.penetration"].values.min()), 0.0))
    assert gaps[0] < 1e-12
    assert gaps[1] > 1e-6
