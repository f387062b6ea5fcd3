"""Scissor lift of three stages: the force of the actuator at its foot for a load on its top.

With n stages of arms of length l at the angle a the height is n l sin a, and the foot stands at l cos a.  By virtual
work a load W and arms of mass m ask for the force (n W + n^2 m g)/tan a along the ground.
"""

import math

import flexmb as fm

n, l, m, load, g = 3, 1.0, 4.0, 200.0, 9.81
start, speed = math.radians(25.0), 1e-3
c, s = l * math.cos(start), l * math.sin(start)

parts, tips = [], {}
for stage in range(n):
    low, high = stage * s, (stage + 1) * s
    rising = fm.RigidLink(f"rising{stage}", (0.0, low), (c, high), mass=m, inertia=m * l**2 / 12.0)
    falling = fm.RigidLink(f"falling{stage}", (c, low), (0.0, high), mass=m, inertia=m * l**2 / 12.0)
    parts += [rising, falling, fm.Revolute(f"middle{stage}", rising, falling, at=(0.5 * c, 0.5 * (low + high)))]
    if stage:
        parts += [fm.Revolute(f"left{stage}", tips["left"], rising, at=(0.0, low)),
                  fm.Revolute(f"right{stage}", tips["right"], falling, at=(c, low))]  # fmt: skip
    else:
        foot = fm.RigidBody("foot", (c, 0.0), mass=1.0, inertia=1e-2)
        parts += [foot, fm.Revolute("anchor", fm.GROUND, rising, at=(0.0, 0.0)),
                  fm.Revolute("ankle", foot, falling, at=(c, 0.0)),
                  fm.Prismatic("rail", fm.GROUND, foot, along=(1.0, 0.0))]  # fmt: skip
    tips = {"left": falling, "right": rising}

platform = fm.Force("load", tips["left"], at=(0.0, n * s), force=(0.0, -load))
actuator = fm.Drive("actuator", "rail", fm.ConstantSpeed(-speed))
mech = fm.Mechanism("scissor lift", [*parts, platform, actuator], gravity=(0.0, -g))
sol = fm.simulate(mech, t_end=200.0)
if not sol.ok:
    raise SystemExit(sol.status)

for k in (1, -1):
    angle = math.acos((c + sol.array("actuator.travel")[k]) / l)
    exact = -(n * load + n**2 * m * g) / math.tan(angle)
    pull = sol.array("actuator.force")[k]
    print(f"at {math.degrees(angle):.2f} degrees the actuator pulls with {pull:.3f} N (exact {exact:.3f})")
fm.render(sol, path="out/scissor_lift.png")
