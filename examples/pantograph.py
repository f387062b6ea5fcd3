"""Pantograph: a parallelogram that draws what a stylus follows, three times as large.

O, the stylus P and the pen Q stay on one line with |OQ| = 3 |OP| in every pose, so the pen draws the same figure.
"""

import math

import numpy as np

import flexmb as fm

k, long, a, b = 3.0, 0.6, 1.9, 0.5  # factor, length of the long bars, their angles
O = (0.0, 0.0)
u, v = (math.cos(a), math.sin(a)), (math.cos(b), math.sin(b))
short = long / k
E = (long * u[0], long * u[1])  # end of the first long bar
Q = (E[0] + long * v[0], E[1] + long * v[1])
A = (short * u[0], short * u[1])
P = (A[0] + short * v[0], A[1] + short * v[1])
C = (E[0] + short * v[0], E[1] + short * v[1])


def bar(name, start, end):
    """A uniform bar."""
    length = math.dist(start, end)
    return fm.RigidLink(name, start, end, mass=length, inertia=length**3 / 12.0)


first, second, third, fourth = bar("first", O, E), bar("second", E, Q), bar("third", A, P), bar("fourth", P, C)
mech = fm.Mechanism("pantograph", [
    first, second, third, fourth,
    fm.Revolute("O", fm.GROUND, first, at=O), fm.Revolute("E", first, second, at=E),
    fm.Revolute("A", first, third, at=A),
    fm.Revolute("C", second, fourth, at=C), fm.Revolute("S", third, fourth, at=P),
    fm.Drive("shoulder", "O", fm.drives.Harmonic(amplitude=0.25, frequency=1.0)),
    fm.Drive("elbow", "E", fm.drives.Harmonic(amplitude=0.35, frequency=2.0)),
    fm.Marker("stylus", third, at=P, trace=True), fm.Marker("pen", second, at=Q, trace=True),
])  # fmt: skip
sol = fm.simulate(mech, t_end=1.0)
if not sol.ok:
    raise SystemExit(sol.status)
away = max(np.abs(sol.array(f"pen.{axis}") - k * sol.array(f"stylus.{axis}")).max() for axis in "xy")
wide, large = (np.ptp(sol.array(f"{name}.x")) for name in ("stylus", "pen"))
print(f"width of the pen's figure over that of the stylus  {large / wide:.10f} (exact {k:.10f})")
print(f"largest departure from the enlarged figure         {away:.1e} m (exact 0)")
fm.render(sol, path="out/pantograph.png")
