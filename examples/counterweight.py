"""Counterweight of a crank: the share of the reciprocating mass for which the peak of the force on the frame is least.

A slider-crank of 50 and 200 mm with a massless rod, and a counterweight of b times the mass of the slider, as far from
the axis as the crank pin and opposite to it. With the acceleration r w^2 x(a) of the slider at the angle a of the
crank, the force on the frame is m r w^2 times the root of (x - b cos a)^2 + (b sin a)^2. Its peak is least where that
at a = 0 equals that near 101 degrees: b = 0.5899341 with the exact motion of the slider, 0.5917343 with the usual
approximation cos a + r/l cos(2 a).

A smooth measure takes the place of the peak, the mean of the p-th power. Its b is off by a series in 1/p, so three
powers give the limit.
"""

import math
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle

import flexmb as fm

R, L, MASS, SPEED = 0.05, 0.2, 0.5, 2.0 * math.pi
UNIT, STEP = MASS * R * SPEED**2, 1.0 / 1440.0
EXACT, LEAST = 0.58993412, 0.66006588
CURVES = {1e-6: ("0.6", "no counterweight"), 0.5: ("C0", "b = 0.5"), 1.0: ("C3", "b = 1")}


def engine(b: float) -> fm.Mechanism:
    frame = fm.RigidBody("frame", (0.0, 0.0), mass=1.0, inertia=1e-3)
    crank = fm.RigidBody("crank", (-R, 0.0), mass=b * MASS, inertia=1e-4)
    rod = fm.RigidLink("rod", (R, 0.0), (R + L, 0.0), mass=0.0, inertia=0.0)
    slider = fm.RigidBody("slider", (R + L, 0.0), mass=MASS, inertia=1e-4)
    return fm.Mechanism("engine", [
        frame, crank, rod, slider,
        fm.Fixed("foundation", fm.GROUND, frame, at=(0.0, 0.0)),
        fm.Revolute("O", frame, crank, at=(0.0, 0.0)),
        fm.Revolute("A", crank, rod, at=(R, 0.0)),
        fm.Revolute("B", rod, slider, at=(R + L, 0.0)),
        fm.Prismatic("guide", frame, slider, at=(R + L, 0.0), along=(1.0, 0.0)),
        fm.Drive("motor", "O", fm.ConstantSpeed(SPEED)),
    ])  # fmt: skip


def force(b):
    """Force on the frame over m r w^2, both components along a turn."""
    sol = fm.simulate(engine(b), periods=1, step=STEP, save=720)
    return -sol.array("foundation.fx") / UNIT, -sol.array("foundation.fy") / UNIT


by_power, b = [], 0.5
for p in (1000.0, 2000.0, 4000.0):
    measure = fm.design.peak("foundation.force", norm=p)
    best = fm.design.optimise(engine, {"b": (0.1, 1.0)}, objective=measure, periods=1, start={"b": b}, step=STEP)
    if not best.ok:
        raise SystemExit(best.message)
    b = best.parameters["b"]
    by_power.append(b)
    print(f"p = {p:4.0f}: b = {b:.7f} after {best.history.sizes['design']} designs")
b = float(np.dot([1.0, -6.0, 8.0], by_power)) / 3.0  # a line and a parabola in 1/p, at 0
print(f"limit:    b = {b:.7f} (exact {EXACT:.7f})")
peak = fm.design.peak("foundation.force")
least = fm.design.sensitivity(engine, {"b": b}, of=[peak], periods=1, step=STEP).measures.amount.item() / UNIT
print(f"peak of the force over m r w^2: {least:.7f} (exact {LEAST:.7f})")

figure = Figure(figsize=(6.5, 4.0), layout="constrained")
axes = figure.subplots()
axes.add_patch(Circle((0.0, 0.0), least, fill=False, color="0.7", linestyle=":"))
for part, (color, label) in (CURVES | {b: ("C2", f"b = {b:.4f}")}).items():
    axes.plot(*force(part), color=color, linewidth=2.5 if part == b else 1.2, label=label)
axes.set(xlabel="force along the guide / m r w$^2$", ylabel="across the guide / m r w$^2$", aspect="equal")
axes.legend(loc="center left", bbox_to_anchor=(1.02, 0.5), frameon=False)
Path("out").mkdir(exist_ok=True)
figure.savefig("out/counterweight.png", dpi=150)
