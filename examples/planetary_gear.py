"""Planetary gear: the sun drives, the ring stands still, the arm turns; ratio and torques in closed form.

With z_s teeth of the sun and z_r of the ring the arm turns by z_s/(z_s + z_r) of the sun (R. Willis, 1841); without
friction the torque on the arm is that of the sun times the inverse ratio.
"""

import flexmb as fm

z_s, z_p, z_r, module = 24, 18, 60, 2e-3
axis = 0.5 * module * (z_s + z_p)  # distance of the axes of sun and planet
O, Q = (0.0, 0.0), (axis, 0.0)
sun = fm.RigidBody("sun", O, mass=0.2, inertia=2e-5)
planet = fm.RigidBody("planet", Q, mass=0.1, inertia=8e-6)
arm = fm.RigidLink("arm", O, Q, mass=0.2, inertia=6e-5)
mech = fm.Mechanism("planetary gear", [
    sun, planet, arm,
    fm.Revolute("O", fm.GROUND, sun, at=O), fm.Revolute("P", fm.GROUND, arm, at=O), fm.Revolute("Q", arm, planet, at=Q),
    fm.Gear("inside", sun, planet, teeth=(z_s, z_p), arm=arm, module=module),
    fm.Gear("outside", planet, fm.GROUND, teeth=(z_p, z_r), internal=True, arm=arm, distance=axis),
    fm.Drive("motor", "O", fm.ConstantSpeed(40.0)),
    fm.Torque("load", arm, -5.0),
    fm.Marker("tooth", planet, at=(axis + 0.5 * module * z_p, 0.0), trace=True),
])  # fmt: skip
sol = fm.simulate(mech, t_end=2.0)
if not sol.ok:
    raise SystemExit(sol.status)
ratio = z_s / (z_s + z_r)
print(f"speed of the arm         {sol.array('arm.omega')[-1]:.10f} rad/s (exact {40.0 * ratio:.10f})")
planets = 40.0 * (ratio - (1.0 - ratio) * z_s / z_p)
print(f"speed of the planet      {sol.array('planet.omega')[-1]:.10f} rad/s (exact {planets:.10f})")
print(f"torque of the motor      {sol.array('motor.torque')[-1]:.8f} N m (exact {5.0 * ratio:.8f})")
fm.render(sol, path="out/planetary_gear.png")
