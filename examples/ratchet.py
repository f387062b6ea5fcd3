"""Ratchet and pawl as two outlines: the wheel turns one way and is held the other way, whole teeth further.

The wheel is thrown forward (clockwise) against a steady load.  The pawl climbs along the slow flanks, its spring
returns it into each gap, and when the load turns the wheel back, the steep flank of a tooth meets the pawl.  All teeth
are alike, so the wheel rests at angles that differ by whole multiples of the pitch, 2 pi / 12.
"""

import math

import numpy as np

import flexmb as fm

teeth, outer, inner = 12, 0.05, 0.042
pitch = 2 * math.pi / teeth
pivot, tip = (-0.05, 0.053), (0.0, 0.0435)


def wheel_outline():
    points = []
    for k in range(teeth):
        flank = math.radians(88) + pitch * k
        points += [(r * math.cos(a), r * math.sin(a)) for r, a in ((outer, flank), (inner, flank + 1e-3))]
    return fm.cams.Outline(points)


def machine(speed):
    wheel = fm.RigidBody("wheel", at=(0.0, 0.0), mass=0.5, inertia=5e-4, velocity=(0.0, 0.0, -speed))
    pawl = fm.RigidBody("pawl", at=(-0.025, 0.049), mass=0.03, inertia=8e-6)
    lever = fm.cams.Outline((tip, (-0.002, 0.049), (-0.052, 0.056), (-0.055, 0.051)))
    law, rubbing = fm.KelvinVoigt(stiffness=1e6, damping=200.0, ramp=1e-6), fm.ModifiedCoulomb(0.1, 1e-4, 1e-3)
    return fm.Mechanism("ratchet", [
        wheel, pawl,
        fm.Revolute("O", fm.GROUND, wheel, at=(0.0, 0.0)),
        fm.Revolute("P", fm.GROUND, pawl, at=pivot),
        fm.cams.OutlineOnOutline("teeth", wheel, wheel_outline(), pawl, lever, normal=law, friction=rubbing),
        fm.TorsionSpring("spring", fm.GROUND, pawl, stiffness=0.5, damping=1e-3, free_angle=-0.3),
        fm.Torque("load", wheel, 0.2),
        fm.TorsionSpring("oil", fm.GROUND, wheel, stiffness=0.0, damping=2e-3),
    ])  # fmt: skip


rests = []
for speed in (0.0, 25.0, 45.0, 60.0):
    sol = fm.simulate(machine(speed), t_end=0.6)
    turned, lost = sol["wheel.theta"].values, np.abs(sol["energy.residual"].values).max()
    rests.append(turned[-1])
    print(
        f"thrown at {speed:4.1f} rad/s: forward to {math.degrees(turned.min()):9.4f} degrees, "
        f"at rest at {math.degrees(turned[-1]):9.4f}, {abs(rests[0] - turned[-1]) / pitch:.9f} teeth on; "
        f"energy unaccounted for {lost:.1e} of {sol['energy.turned_over'].values[-1]:.2f} J"
    )
