"""An eccentric cam lifts a flat follower against a spring, until the follower lifts off.

With the eccentricity e, the follower's mass m, the spring's stiffness k and its force F0 at the lowest place, the
contact force at the cam speed w and the lift y is F0 + k y - m w^2 (y - e).  The follower lifts off first at the top:

    w^2 = (F0 + 2 k e) / (m e).
"""

import math

import numpy as np

import flexmb as fm

e, radius, m, k = 0.01, 0.03, 0.3, 2000.0
u = np.linspace(0.0, 2 * math.pi, 181)[:-1]
profile = fm.ClosedCurve(np.column_stack([e + radius * np.cos(u), radius * np.sin(u)]))
first = math.sqrt((k * (radius - e) + 2 * k * e) / (m * e))


def valve(speed, normal=None):
    cam = fm.RigidBody("cam", at=(0.0, 0.0), mass=0.5, inertia=1e-3)
    follower = fm.RigidBody("follower", at=(0.0, radius), mass=m, inertia=1e-4)
    face = fm.Line((-0.05, radius), (0.05, radius))
    return fm.Mechanism("valve", [
        cam, follower,
        fm.Revolute("axis", fm.GROUND, cam, at=(0.0, 0.0)),
        fm.Prismatic("guide", fm.GROUND, follower, along=(0.0, 1.0)),
        fm.CurveOnCurve("tappet", cam, profile, follower, face, normal=normal),
        fm.SpringDamper("spring", fm.GROUND, follower, at=(0.0, 0.2), to=(0.0, radius), stiffness=k, free_length=0.2),
        fm.Drive("motor", "axis", fm.ConstantSpeed(speed)),
    ])  # fmt: skip


slow = fm.simulate(valve(40.0), periods=1)
print(f"at 40 rad/s: lift {np.ptp(slow['follower.y'].values):.6f} m (exact {2 * e:.6f})")
exact = k * (radius - e) + m * e * 40.0**2
print(f"             smallest contact force {slow['tappet.force'].values.min():.4f} N (exact {exact:.4f})")

speeds = np.array([160.0, 166.0]) ** 2
least = [fm.simulate(valve(math.sqrt(s)), periods=1)["tappet.force"].values.min() for s in speeds]
found = math.sqrt(np.interp(0.0, least[::-1], speeds[::-1]))
print(f"the force of the ideal pair reaches zero at {found:.3f} rad/s (exact {first:.3f})")

steel = fm.KelvinVoigt(stiffness=1e8, damping=4e3, ramp=1e-7)
for speed in (0.99 * first, 1.01 * first, 200.0):
    sol = fm.simulate(valve(speed, steel), periods=4)
    height, count = 1e3 * max(-sol["tappet.penetration"].values.min(), 0.0), len(sol.episodes("tappet"))
    print(f"contact at {speed:7.3f} rad/s: {count} episodes in 4 turns, largest gap {height:.3f} mm")
