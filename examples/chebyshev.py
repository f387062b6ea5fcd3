"""Chebyshev's linkage: crossed arms of 5, a coupler of 2, pivots 4 apart; the middle of the coupler keeps its height.

It stands at the height 4 exactly where it is above both pivots and in the middle between them, and departs from it by
less than a hundredth in between (P. L. Chebyshev, 1853).
"""

import numpy as np

import flexmb as fm

O, D, A, B = (0.0, 0.0), (4.0, 0.0), (3.0, 4.0), (1.0, 4.0)
left = fm.RigidLink("left", O, A, mass=1.0, inertia=1.0)
right = fm.RigidLink("right", D, B, mass=1.0, inertia=1.0)
coupler = fm.RigidLink("coupler", A, B, mass=1.0, inertia=1.0)
pins = [
    fm.Revolute("O", fm.GROUND, left, at=O), fm.Revolute("D", fm.GROUND, right, at=D),
    fm.Revolute("A", left, coupler, at=A), fm.Revolute("B", right, coupler, at=B),
]  # fmt: skip
rise = 0.5 * np.pi - np.arctan2(4.0, 3.0)  # of the left arm, from the drawn pose to the vertical one
swing = fm.drives.Harmonic(amplitude=0.5 * rise, frequency=0.5, phase=-0.5 * np.pi, mean=0.5 * rise)
pen = fm.Marker("pen", coupler, at=(2.0, 4.0), trace=True)
sol = fm.simulate(
    fm.Mechanism("chebyshev", [left, right, coupler, *pins, fm.Drive("motor", "O", swing), pen]), t_end=1.0
)
if not sol.ok:
    raise SystemExit(sol.status)

x, y = sol.array("pen.x"), sol.array("pen.y")
for k, place in ((0, 2.0), (-1, 0.0)):
    print(f"at x = {x[k]:.6f} (exact {place:.6f}) the height is {y[k]:.6f} (exact 4.000000)")
print(f"in between it changes by {np.ptp(y):.5f}")
fm.render(sol, path="out/chebyshev.png")
