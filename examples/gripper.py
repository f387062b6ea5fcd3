"""A compliant gripper: two jaws on leaf springs close on a round part; the force that is left for the grip.

Each jaw hangs on two parallel leaf springs of length L, which keep it straight: its stiffness is k = 24 E I/L^3.  A
force F pushes each jaw by the way w until it touches the part, whose contact has the stiffness K.  The springs take k w
of the force, so that the grip is (F - k w)/(1 + k/K), but for terms of second order in w/L.
"""

import flexmb as fm

L, WAY, RADIUS, F = 0.06, 5e-4, 0.008, 6.0  # leaf springs [m], way of a jaw [m], part [m], force on a jaw [N]
WIDTH, THICKNESS, HEIGHT, DEPTH = 0.01, 5e-4, 0.012, 0.02  # of the leaf springs and of the jaws [m]
law = fm.KelvinVoigt(stiffness=1e7, damping=500.0)
grow = fm.drives.PiecewiseLinear((0.0, 0.05), (0.0, 1.0))
part = fm.RigidBody("part", at=(0.0, 0.0), mass=0.05, inertia=1e-6)


def jaw(name, side):
    """A jaw at the left (-1) or at the right (+1) of the part, its leaf springs, its force and its contact."""
    face, back = side * (RADIUS + WAY), side * (RADIUS + WAY + DEPTH)
    block = fm.RigidBody(name, at=(0.5 * (face + back), 0.0), mass=0.02, inertia=2e-6)
    parts = [block, fm.Force(f"{name}_push", block, at=(back, 0.0), force=(-side * F, 0.0), history=grow)]
    for k, x in enumerate((face + side * 0.002, back - side * 0.002)):
        foot, head, section = (x, -L), (x, 0.0), fm.Rectangle(WIDTH, THICKNESS)
        leaf = fm.FlexibleLink(f"{name}{k}", foot, head, section=section, material=fm.STEEL, elements=4, damping=2e-3)
        parts += [leaf, fm.Fixed(f"{name}{k}_foot", fm.GROUND, leaf, at=foot)]
        parts += [fm.Fixed(f"{name}{k}_head", leaf, block, at=head)]
    a, b = min(face, back), max(face, back)
    outline = fm.cams.Outline([(a, -HEIGHT), (b, -HEIGHT), (b, HEIGHT), (a, HEIGHT)], [0.0] * 4)
    circle = fm.cams.CircularCurve((0.0, 0.0), RADIUS)
    return [*parts, fm.cams.OutlineContact(f"{name}_grip", block, outline, part, circle, normal=law)]


base = fm.Fixed("base", fm.GROUND, part, at=(0.0, -RADIUS))
gripper = fm.Mechanism("gripper", [part, base, *jaw("left", -1.0), *jaw("right", 1.0)], gravity=(0.0, 0.0))
sol = fm.simulate(gripper, t_end=0.15)
if not sol.ok:
    raise SystemExit(sol.status)

k = 24.0 * fm.STEEL.young * WIDTH * THICKNESS**3 / 12.0 / L**3
exact = (F - k * WAY) / (1.0 + k / law.stiffness)
for name in ("left", "right"):
    print(f"grip of the {name} jaw {float(sol[f'{name}_grip.normal_force'][-1]):.4f} N (leaf springs {exact:.4f})")
touched = sol.episodes("left_grip")
print(f"first touch after {1e3 * touched.start[0]:.2f} ms with {1e3 * touched.approach_speed[0]:.2f} mm/s")
fm.render(sol, times=(0.0, 0.15), path="out/gripper.png")
