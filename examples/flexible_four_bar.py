"""A crank-rocker whose coupler and rocker bend: how far, and what that does to the torque of the crank.

With the beams made ever stiffer the motion must tend to that of the rigid mechanism, which has a closed form: the
angle of the rocker from the distance of the crank pin to the rocker's pivot.  The error falls as 1 / E.
"""

import math
from dataclasses import replace

import numpy as np

import flexmb as fm

O, A, B, D = (0.0, 0.0), (0.1, 0.0), (0.30, 0.30), (0.4, 0.0)
speed = 20.0
soft = fm.Material(young=20e9, density=2000.0)


def four_bar(material):
    crank = fm.RigidLink("crank", O, A, mass=0.2, inertia=2e-4)
    bar = {"section": fm.Rectangle(width=0.02, height=0.005), "material": material, "elements": 4, "damping": 1e-4}
    coupler, rocker = fm.FlexibleLink("coupler", A, B, **bar), fm.FlexibleLink("rocker", D, B, **bar)
    joints = [
        fm.Revolute("O", fm.GROUND, crank, at=O),
        fm.Revolute("A", crank, coupler, at=A),
        fm.Revolute("B", coupler, rocker, at=B),
        fm.Revolute("D", fm.GROUND, rocker, at=D),
    ]
    motor = fm.Drive("motor", joint="O", motion=fm.drives.Ramp(speed, time=0.5 * math.pi / speed))
    return fm.Mechanism("four-bar", [crank, coupler, rocker, *joints, motor], gravity=(0.0, -9.81))


def rigid_rocker(phi):
    """Angle of the line from D to B when the crank stands at phi."""
    coupler, rocker = math.dist(A, B), math.dist(D, B)
    dx, dy = math.dist(O, A) * np.cos(phi) - D[0], math.dist(O, A) * np.sin(phi) - D[1]
    reach = np.hypot(dx, dy)
    at_pivot = np.arccos((rocker**2 + reach**2 - coupler**2) / (2 * rocker * reach))
    return np.unwrap(np.arctan2(dy, dx)) % (2 * math.pi) - at_pivot


for factor in (1, 10, 100):
    sol = fm.simulate(four_bar(replace(soft, young=factor * soft.young)), t_end=0.4, step=1e-4, save=400)
    if not sol.ok:
        raise SystemExit(sol.status)
    chord = np.arctan2(sol.array("rocker.end.y") - D[1], sol.array("rocker.end.x") - D[0])
    away = np.abs(chord - rigid_rocker(sol.array("crank.theta"))).max()
    print(
        f"E x {factor:3d}: rocker leaves the rigid motion by {away:.1e} rad, coupler bends by "
        f"{sol.peak('coupler.deflection').value:.1e} m, crank torque up to {sol.peak('motor.torque').value:.3f} N m"
    )
