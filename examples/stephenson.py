"""Stephenson's six-bar linkage (type III): a crank-rocker whose coupler point drives a second rocker.

Each loop is closed by hand, by intersections of two circles; the angle of the second rocker must be the same.
"""

import math

import numpy as np

import flexmb as fm

O, C, F = (0.0, 0.0), (0.4, 0.0), (0.15, 0.45)
crank, coupler, rocker, link, follower = 0.1, 0.35, 0.3, 0.25, 0.2
BESIDE = (0.2, 0.12)  # the coupler point from A, along and across the line A-B


def meet(p, r, q, s, side):
    """Intersection of the circles about p and q, left (1) or right (-1) of the way from p to q."""
    (px, py), (qx, qy) = p, q
    apart = np.hypot(qx - px, qy - py)
    along = (r**2 - s**2 + apart**2) / (2.0 * apart)
    up = side * np.sqrt(r**2 - along**2)
    ux, uy = (qx - px) / apart, (qy - py) / apart
    return px + along * ux - up * uy, py + along * uy + up * ux


def pose(angle):
    """Places of A, B, P and E for an angle of the crank."""
    A = crank * np.cos(angle), crank * np.sin(angle)
    B = meet(A, coupler, C, rocker, 1)
    ux, uy = (B[0] - A[0]) / coupler, (B[1] - A[1]) / coupler
    P = A[0] + BESIDE[0] * ux - BESIDE[1] * uy, A[1] + BESIDE[0] * uy + BESIDE[1] * ux
    return A, B, P, meet(P, link, F, follower, -1)


A, B, P, E = (tuple(map(float, point)) for point in pose(1.0))


def bar(name, start, end):
    """A uniform bar."""
    length = math.dist(start, end)
    return fm.RigidLink(name, start, end, mass=length, inertia=length**3 / 12.0)


ends = {"crank": (O, A), "rocker": (C, B), "link": (P, E), "follower": (F, E)}
bars = {name: bar(name, *two) for name, two in ends.items()}
bars["coupler"] = fm.RigidBody("coupler", tuple(np.mean([A, B, P], axis=0)), mass=0.6, inertia=8e-3)
pairs = {"O": ("", "crank", O), "A": ("crank", "coupler", A), "B": ("coupler", "rocker", B), "C": ("", "rocker", C),
         "P": ("coupler", "link", P), "E": ("link", "follower", E), "F": ("", "follower", F)}  # fmt: skip
pins = [fm.Revolute(name, bars.get(one, fm.GROUND), bars[two], at=at) for name, (one, two, at) in pairs.items()]
motor = fm.Drive("motor", "O", fm.ConstantSpeed(10.0))
pen = fm.Marker("pen", bars["coupler"], at=P, trace=True)
sol = fm.simulate(fm.Mechanism("stephenson", [*bars.values(), *pins, motor, pen]), periods=1)
if not sol.ok:
    raise SystemExit(sol.status)

*_, there = pose(1.0 + sol.array("O.angle"))
exact = np.unwrap(np.arctan2(there[1] - F[1], there[0] - F[0]))
found = sol.array("F.angle")
print(f"swing of the follower  {np.ptp(found):.10f} rad (exact {np.ptp(exact):.10f})")
print(f"largest error of its angle {np.abs(found - (exact - exact[0])).max():.1e} rad (exact 0)")
fm.render(sol, path="out/stephenson.png")
