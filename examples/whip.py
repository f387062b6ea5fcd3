"""The whip of a chain: a folded chain falls faster than a stone.

One end of a chain hangs from the ceiling, the other is let go beside it.  The part that still falls gives its energy to
fewer and fewer links.  If no energy is lost, an end that has fallen by x moves with

    v^2 = 2 g x (L - x/2) / (L - x),

for a chain of length L that is folded without width (M. G. Calkin, R. H. March, Am. J. Phys. 57 (1989) 154-157).  A
chain of links has a fold of one link's width, and its last links swing around: it comes near these values while the
fold is small against what hangs.
"""

import math
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import quad

import flexmb as fm

LINKS, LENGTH, G = 30, 1.0, 9.81  # links on each side of the fold, length of the chain [m]
link = LENGTH / (2 * LINKS + 1)
down = [(0.0, -link * k) for k in range(LINKS + 1)]
joints = down + [(link, y) for _, y in reversed(down)]
mass = 0.2 / (2 * LINKS + 1)
links = [
    fm.RigidLink(f"link{k}", a, b, mass=mass, inertia=mass * link**2 / 12.0)
    for k, (a, b) in enumerate(pairwise(joints))
]
pins = [fm.Revolute("hook", fm.GROUND, links[0], at=joints[0])]
pins += [fm.Revolute(f"pin{k}", links[k], links[k + 1], at=joint) for k, joint in enumerate(joints[1:-1])]
end = fm.Marker("end", links[-1], at=joints[-1], trace=True)
chain = fm.Mechanism("chain", [*links, *pins, end], gravity=(0.0, -G))

fallen = 0.8 * LENGTH
sol = fm.simulate(chain, t_end=0.5, step=2e-4, save="steps", stop=fm.when("end.y", below=-fallen))
speed = -float(sol["end.vy"][-1])
exact = math.sqrt(2.0 * G * fallen * (LENGTH - 0.5 * fallen) / (LENGTH - fallen))
instant, _ = quad(
    lambda s: 2.0 * math.sqrt((LENGTH - s * s) / (2.0 * G * (LENGTH - 0.5 * s * s))), 0.0, math.sqrt(fallen)
)
free = math.sqrt(2.0 * fallen / G)
print(f"the end falls {fallen:.2f} m in {sol.time[-1]:.4f} s (thin fold {instant:.4f}), a stone in {free:.4f} s")
print(f"speed there {speed:.3f} m/s (thin fold {exact:.3f}), of a stone {math.sqrt(2.0 * G * fallen):.3f} m/s")
lost = float(sol["energy.kinetic"][-1] + sol["energy.gravity"][-1] - sol["energy.gravity"][0])
print(f"energy lost {abs(lost) / (0.2 * G * LENGTH):.1e} of the weight times the length (exact 0)")

figure, axes = plt.subplots()
way = np.linspace(0.0, fallen, 200)
axes.plot(-sol.array("end.y"), -sol.array("end.vy"), label=f"chain of {2 * LINKS + 1} links")
axes.plot(way, np.sqrt(2.0 * G * way * (LENGTH - 0.5 * way) / (LENGTH - way)), "--", label="thin fold")
axes.plot(way, np.sqrt(2.0 * G * way), ":", label="stone")
axes.set(xlabel="way that the end has fallen [m]", ylabel="speed [m/s]")
axes.legend()
Path("out").mkdir(exist_ok=True)
figure.savefig("out/whip.png")
