"""Toggle press: two links that are nearly in line press a slider against a spring with a small torque.

With links of length l at the angle a against the line of the slider its travel is x = 2 l (cos a - cos a0).  By virtual
work the torque of the motor is the force of the spring times dx/da = -2 l sin a; near the line it vanishes.
"""

import math

import numpy as np

import flexmb as fm

l, k, start = 0.2, 5e5, 0.35
O, A, B = (0.0, 0.0), (l * math.cos(start), l * math.sin(start)), (2.0 * l * math.cos(start), 0.0)
upper = fm.RigidLink("upper", O, A, mass=1e-3, inertia=1e-6)
lower = fm.RigidLink("lower", A, B, mass=1e-3, inertia=1e-6)
ram = fm.RigidBody("ram", B, mass=1.0, inertia=1e-3)
wall = (B[0] + 0.15, 0.0)
mech = fm.Mechanism("toggle press", [
    upper, lower, ram,
    fm.Revolute("O", fm.GROUND, upper, at=O), fm.Revolute("A", upper, lower, at=A), fm.Revolute("B", lower, ram, at=B),
    fm.Prismatic("guide", fm.GROUND, ram, along=(1.0, 0.0)),
    fm.SpringDamper("work", ram, fm.GROUND, at=B, to=wall, stiffness=k),
    fm.Drive("motor", "O", fm.drives.Harmonic(-start + 0.02, frequency=1.0 / 400.0)),
])  # fmt: skip
sol = fm.simulate(mech, t_end=100.0)
if not sol.ok:
    raise SystemExit(sol.status)
angle = start + sol.array("O.angle")
force = k * 2.0 * l * (np.cos(angle) - math.cos(start))
torque = -force * 2.0 * l * np.sin(angle)
print(f"force on the work at the end   {-sol.array('work.force')[-1]:.4f} N (exact {force[-1]:.4f})")
print(f"torque of the motor there      {sol.array('motor.torque')[-1]:.4f} N m (exact {torque[-1]:.4f})")
print(f"largest torque on the way      {sol.peak('motor.torque').value:.3f} N m (exact {np.abs(torque).max():.3f})")
fm.render(sol, path="out/toggle_press.png")
