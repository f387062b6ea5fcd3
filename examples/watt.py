"""Watt's linkage: two equal arms and a coupler between them, whose middle draws Watt's curve.

With pivots 2 a apart, arms of length b and a coupler of length 2 c the middle of the coupler moves on
r^2 = b^2 - (a sin(t) -+ sqrt(c^2 - a^2 cos(t)^2))^2 in polar coordinates about the middle of the pivots (1784).
"""

import math

import numpy as np

import flexmb as fm

half, arm, stub = 0.5, 0.45, 0.15  # a, b, c [m]
O, D = (-half, 0.0), (half, 0.0)
# the symmetric pose: arms parallel, coupler through the middle of the pivots
lean = math.acos((half**2 + arm**2 - stub**2) / (2.0 * half * arm))
A = (O[0] + arm * math.cos(lean), arm * math.sin(lean))
B = (-A[0], -A[1])
left = fm.RigidLink("left", O, A, mass=1.0, inertia=0.02)
right = fm.RigidLink("right", D, B, mass=1.0, inertia=0.02)
coupler = fm.RigidLink("coupler", A, B, mass=0.5, inertia=0.004)
pins = [
    fm.Revolute("O", fm.GROUND, left, at=O), fm.Revolute("D", fm.GROUND, right, at=D),
    fm.Revolute("A", left, coupler, at=A), fm.Revolute("B", right, coupler, at=B),
]  # fmt: skip
pen = fm.Marker("pen", coupler, at=(0.0, 0.0), trace=True)
swing = fm.drives.Harmonic(amplitude=0.3, frequency=1.0)
sol = fm.simulate(fm.Mechanism("watt", [left, right, coupler, *pins, fm.Drive("motor", "O", swing), pen]), periods=1)
if not sol.ok:
    raise SystemExit(sol.status)

x, y = sol.array("pen.x"), sol.array("pen.y")
r, t = np.hypot(x, y), np.arctan2(y, x)
root = np.sqrt(np.maximum(stub**2 - (half * np.cos(t)) ** 2, 0.0))
off = [np.abs(arm**2 - (half * np.sin(t) - sign * root) ** 2 - r**2) for sign in (1.0, -1.0)]
away = np.where(r > 1e-3, np.minimum(*off), 0.0)  # at the middle itself the angle is undefined
print(f"the middle of the coupler moves by up to {r.max():.4f} m")
print(f"largest departure from Watt's curve: {away.max():.1e} m^2 (exact 0)")
fm.render(sol, path="out/watt.png")
