"""Scotch yoke: a crank pin in a slot across the guide of a yoke, which moves as a pure sine.

With the mass m of the yoke the torque of the motor is m r^2 w^2 sin(wt) cos(wt), the force of the pin m r w^2 |cos|.
"""

import numpy as np

import flexmb as fm

r, w, m = 0.08, 30.0, 2.5
crank = fm.RigidLink("crank", (0.0, 0.0), (r, 0.0), mass=0.3, inertia=2e-4)
yoke = fm.RigidBody("yoke", (r, 0.0), mass=m, inertia=1e-2)
mech = fm.Mechanism("scotch yoke", [
    crank, yoke,
    fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)),
    fm.Prismatic("guide", fm.GROUND, yoke, along=(1.0, 0.0)),
    fm.PinSlot("pin", yoke, crank, at=(r, 0.0), along=(0.0, 1.0)),
    fm.Drive("motor", "O", fm.ConstantSpeed(w)),
])  # fmt: skip
sol = fm.simulate(mech, periods=1)
if not sol.ok:
    raise SystemExit(sol.status)
turn = w * sol.time
print(f"largest error of the sine        {np.abs(sol.array('yoke.x') - r * np.cos(turn)).max():.1e} m (exact 0)")
print(f"largest torque of the motor      {sol.peak('motor.torque').value:.4f} N m (exact {0.5 * m * (r * w) ** 2:.4f})")
print(f"largest force of the pin         {sol.peak('pin.force').value:.3f} N (exact {m * r * w**2:.3f})")
fm.render(sol, path="out/scotch_yoke.png")
