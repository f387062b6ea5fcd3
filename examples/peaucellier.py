"""Peaucellier's linkage: seven links and ten pins, and a point that moves on an exactly straight line.

The arms O-B and O-C of length l and the rhombus A-B-P-C of side s keep |OA| |OP| = l^2 - s^2.  A moves on a circle
through O with the diameter 2 d, so P moves on the line x = (l^2 - s^2)/(2 d) (A. Peaucellier, 1864).
"""

import math

import numpy as np

import flexmb as fm

l, s, d, start = 0.5, 0.2, 0.25, 0.6
O, Q = (0.0, 0.0), (d, 0.0)
A = (d + d * math.cos(start), d * math.sin(start))
line = (l**2 - s**2) / (2.0 * d)

reach, along = math.hypot(*A), math.atan2(A[1], A[0])
half = math.acos((l**2 + reach**2 - s**2) / (2.0 * l * reach))  # between O-A and the arms
B, C = ((l * math.cos(along + turn), l * math.sin(along + turn)) for turn in (half, -half))
P = (B[0] + C[0] - A[0], B[1] + C[1] - A[1])

links = {
    name: fm.RigidLink(name, start, end, mass=math.dist(start, end), inertia=math.dist(start, end) ** 3 / 12.0)
    for name, start, end in (
        ("crank", Q, A),
        ("OB", O, B),
        ("OC", O, C),
        ("AB", A, B),
        ("AC", A, C),
        ("BP", B, P),
        ("CP", C, P),
    )
}
pins = [
    fm.Revolute(f"{point}{number}", links.get(first, fm.GROUND), links[second], at=at)
    for point, at, pairs in (
        ("Q", Q, [("ground", "crank")]),
        ("O", O, [("ground", "OB"), ("ground", "OC")]),
        ("A", A, [("crank", "AB"), ("crank", "AC")]),
        ("B", B, [("OB", "AB"), ("OB", "BP")]),
        ("C", C, [("OC", "AC"), ("OC", "CP")]),
        ("P", P, [("BP", "CP")]),
    )
    for number, (first, second) in enumerate(pairs)
]
swing = fm.drives.Harmonic(amplitude=0.5, frequency=1.0)
pen = fm.Marker("pen", links["BP"], at=P, trace=True)
mech = fm.Mechanism("peaucellier", [*links.values(), *pins, fm.Drive("motor", "Q0", swing), pen])

sol = fm.simulate(mech, periods=1)
if not sol.ok:
    raise SystemExit(sol.status)
x, y = sol.array("pen.x"), sol.array("pen.y")
print(f"the pen moves up and down by {np.ptp(y):.4f} m")
print(f"place of the line       {x.mean():.12f} m (exact {line:.12f})")
print(f"largest distance to it  {np.abs(x - line).max():.1e} m (exact 0)")
fm.render(sol, path="out/peaucellier.png")
