"""Whitworth's quick return: a crank pin in the slot of a lever, which swings slowly forth and quickly back.

For a crank of length r at the distance d from the pivot of the lever the ratio of both times is
(pi + 2 asin(r/d))/(pi - 2 asin(r/d)).  The instants at which the lever turns back are found by stop conditions.
"""

import math

import flexmb as fm

r, d, speed = 0.1, 0.25, 2.0 * math.pi
O, D = (0.0, 0.0), (0.0, -d)
A = (r, 0.0)
crank = fm.RigidLink("crank", O, A, mass=0.5, inertia=1e-3)
reach = math.hypot(r, d)
lever = fm.RigidLink("lever", D, (2.0 * r, d), mass=1.0, inertia=2e-2)
mech = fm.Mechanism("quick return", [
    crank, lever,
    fm.Revolute("O", fm.GROUND, crank, at=O), fm.Revolute("D", fm.GROUND, lever, at=D),
    fm.PinSlot("pin", lever, crank, at=A, along=(r / reach, d / reach)),
    fm.Drive("motor", "O", fm.ConstantSpeed(speed)),
    fm.Marker("tool", lever, at=(2.0 * r, d), trace=True),
])  # fmt: skip

turns, last = [], None
for _ in range(3):
    last = fm.simulate(mech, periods=2, stop=fm.when("lever.omega", crosses=0.0), restart=last and last.restart)
    if not last.ok:
        raise SystemExit(last.status)
    turns.append(float(last.time[-1]))
ratio = (turns[1] - turns[0]) / (turns[2] - turns[1])
ratio = max(ratio, 1.0 / ratio)
exact = (math.pi + 2.0 * math.asin(r / d)) / (math.pi - 2.0 * math.asin(r / d))
print(f"slow stroke over quick one  {ratio:.8f} (exact {exact:.8f})")
sol = fm.simulate(mech, periods=1)
print(f"swing of the lever          {sol.array('D.angle').max() - sol.array('D.angle').min():.5f} rad "
      f"(exact {2.0 * math.asin(r / d):.5f})")  # fmt: skip
fm.render(sol, path="out/quick_return.png")
