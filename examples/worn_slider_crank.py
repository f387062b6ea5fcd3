"""A worn slider-crank: the orbit of the journal in its bearing, and whether it is chaotic.

The piston pin has 0.5 mm of clearance, at 5000 rpm (the mechanism of P. Flores and others, Kinematics and Dynamics of
Multibody Systems with Imperfect Joints, Springer 2008).  The largest Lyapunov exponent is found twice: from the tangent
of the time steps, and from the distance of two neighbouring runs.  Both must agree within their errors.
"""

import math
from pathlib import Path

import numpy as np

import flexmb as fm

clearance = 5e-4
worn = fm.mechanisms.slider_crank(clearance=clearance)
sol = fm.simulate(worn, periods=12, save_from_period=10, save=2000)
if not sol.ok:
    raise SystemExit(sol.status)
depth = np.hypot(sol.array("B.ex"), sol.array("B.ey")).max() / clearance
impacts = sol.episodes("B")
print(f"journal at most {depth:.3f} clearances from its centre, {len(impacts.start)} contacts in two turns")

tangent = fm.lyapunov(worn, skip=20, periods=100, confirm=False)
two_runs = fm.chaos.benettin(worn, skip=20, periods=100)
both = math.hypot(tangent.error, two_runs.error)
print(f"largest exponent {tangent.value:.0f} +- {tangent.error:.0f} /s from tangents")
print(f"largest exponent {two_runs.value:.0f} +- {two_runs.error:.0f} /s from two runs, ", end="")
print(f"{abs(tangent.value - two_runs.value) / both:.1f} errors apart")
print(f"verdict {tangent.verdict}")
Path("out").mkdir(exist_ok=True)
fm.plot(sol, "B.ey", x="B.ex", title="journal in its bearing").savefig("out/worn_slider_crank.png")
