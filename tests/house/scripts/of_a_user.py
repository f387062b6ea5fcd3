"""Script as users write it, for mypy: parts, points and numbers in lists, joints as parts or by name.

`make lint` checks it with the package.  The last two lines are wrong; mypy tells of comments that excuse no error.
"""

import flexmb as fm

O, A = (0.0, 0.0), (0.3, 0.0)
arm = fm.RigidLink("arm", O, A, mass=1.0, inertia=0.01)
hinge = fm.Revolute("hinge", fm.GROUND, arm, at=O)
motion = fm.drives.Table([0.0, 1.0, 2.0], [0.0, 0.5, 1.0])
parts = [arm, hinge]
frame = fm.FlexibleFrame("frame", [O, A], [(0, 1)], section=fm.Rectangle(0.01, 0.01), material=fm.STEEL)
mech = fm.Mechanism("m", [*parts, fm.Drive("motor", joint=hinge, motion=motion)])
other = fm.Mechanism("m", parts).with_part(fm.Drive("motor", "hinge", fm.ConstantSpeed(1.0)))
stopped = mech.with_part(fm.Stop("end", hinge, above=1.0, normal=fm.KelvinVoigt(1e4, 1.0)))
body = fm.RigidBody("body", O, 1.0, 0.1, outline=[O, A])
sol = fm.simulate(mech, t_end=1.0, signals=["arm.*"])
print(sol["arm.x"], sol.peak("arm.x"), mech[hinge], mech.without_part("motor"))

wrong = fm.RigidLink("a", O, A, mas=1.0, inertia=0.1)  # type: ignore[call-arg]
print(arm.nothing)  # type: ignore[attr-defined]
