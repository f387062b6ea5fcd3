"""Lift law of a cam: the least peak of the acceleration, and the least one at pressure angles below 30 degrees.

The law is the 3-4-5 polynomial with two terms more, both of which leave the dwells at its ends alone:

    y/h = x^3 (10 - 15 x + 6 x^2) + x^3 (1 - x)^3 (1 - 2 x) [p + q x (1 - x)],    x from 0 to 1 along the rise.

In units of h/T^2 the cycloidal law has a peak of 2 pi, the 3-4-5 polynomial one of 10/sqrt(3) = 5.7735, and no law less
than the 4 of two constant accelerations. With both terms the least peak is 4.65747, and 5.02607 with a roller whose
pressure angle stays below 30 degrees, by a linear program. The peak is that of the mean of the n-th power, whose p and
q are off by a series in 1/n, so three powers give the limit.
"""

import math
from pathlib import Path

import numpy as np
from numpy.polynomial import Polynomial

import flexmb as fm

LIFT, RISE, SPEED, ROLLER = 0.01, 0.5 * math.pi, 200.0, 0.015
T = RISE / SPEED
UNIT = LIFT / T**2
X = Polynomial([0.0, 1.0])


def law(p, q):
    return X**3 * (10.0 - 15.0 * X + 6.0 * X**2) + X**3 * (1.0 - X) ** 3 * (1.0 - 2.0 * X) * (p + q * X * (1.0 - X))


def driven(motion) -> fm.Mechanism:
    """A follower on the centre line of the cam, and its spring of 5000 N/m with a preload of 220 N."""
    follower = fm.RigidBody("follower", (0.0, ROLLER), mass=0.3, inertia=1e-4)
    return fm.Mechanism("cam follower", [
        follower,
        fm.Prismatic("guide", fm.GROUND, follower, at=(0.0, ROLLER), along=(0.0, 1.0)),
        fm.SpringDamper("spring", fm.GROUND, follower, (0.0, 0.1), (0.0, ROLLER), stiffness=5e3, free_length=0.129),
        fm.Drive("cam", "guide", motion),
    ])  # fmt: skip


def polynomial(p: float = 0.0, q: float = 0.0) -> fm.Mechanism:
    return driven(fm.drives.Polynomial([LIFT * c / T**k for k, c in enumerate(law(p, q).coef)]))


def pressure_angle(p, q):
    """Largest pressure angle of the roller [rad]."""
    x, y = np.linspace(0.0, 1.0, 2001), law(p, q)
    return float(np.arctan(LIFT / RISE * y.deriv()(x) / (ROLLER + LIFT * y(x))).max())


def below_30_degrees(p, q):
    return math.radians(30.0) - pressure_angle(p, q)


def least_peak(limits):
    by_power, at = [], {"p": 10.0, "q": -30.0}
    how = {"subject_to": limits, "t_end": T, "step": T / 400.0}
    for n in (200.0, 400.0, 800.0):
        peak = fm.design.peak("follower.ay", norm=n)
        best = fm.design.optimise(polynomial, {"p": (0.0, 30.0), "q": (-100.0, 0.0)}, objective=peak, start=at, **how)
        if not best.ok:
            raise SystemExit(best.message)
        at = best.parameters
        by_power.append(list(at.values()))
    return np.array([1.0, -6.0, 8.0]) @ by_power / 3.0


free, held = least_peak([]), least_peak([below_30_degrees])
x = np.linspace(0.0, 1.0, 401)
cycloid = fm.drives.Table(T * x, LIFT * (x - np.sin(2.0 * math.pi * x) / (2.0 * math.pi)), slopes=(0.0, 0.0))
laws = {"cycloidal": (driven(cycloid), 2.0 * math.pi), "3-4-5 polynomial": (polynomial(), 10.0 / math.sqrt(3.0))}
laws |= {"least peak": (polynomial(*free), 4.65747), "below 30 degrees": (polynomial(*held), 5.02607)}
runs = {name: fm.simulate(mech, t_end=T, step=T / 2000.0, save=2000) for name, (mech, _) in laws.items()}
for name, (_, exact) in laws.items():
    peak, force = abs(runs[name].array("follower.ay")).max() / UNIT, runs[name].array("cam.force").min()
    print(f"{name:16s} has a peak of {peak:.5f} h/T^2 (exact {exact:.5f}), contact forces from {force:5.1f} N")
for name, both in (("least peak", free), ("below 30 degrees", held)):
    angle = math.degrees(pressure_angle(*both))
    print(f"{name:16s}: p = {both[0]:.3f}, q = {both[1]:.3f}, largest pressure angle {angle:.3f} degrees")
Path("out").mkdir(exist_ok=True)
fm.plots.plot_runs(runs, ["follower.ay", "cam.force"], title="rise of a cam").savefig("out/cam_law.png", dpi=150)
