"""A run that is stopped, written to disk, read again and gone on with: bit for bit the run that was never stopped.

The joint of this slider-crank has play, so the stop falls between impacts or into one; the history of the contact is
part of what is written.
"""

import numpy as np

import flexmb as fm

O, A, B = (0.0, 0.0), (0.05, 0.0), (0.17, 0.0)
crank = fm.RigidLink("crank", O, A, mass=0.3, inertia=1e-4)
rod = fm.RigidLink("rod", A, B, mass=0.2, inertia=2.5e-4)
slider = fm.RigidBody("slider", at=B, mass=0.14, inertia=1e-4)
steel = fm.Material(young=207e9, density=7850.0, poisson=0.3)
law = fm.LankaraniNikravesh.from_materials(steel, steel)
parts = [
    crank,
    rod,
    slider,
    fm.Revolute("O", fm.GROUND, crank, at=O),
    fm.Revolute("A", crank, rod, at=A),
    fm.RevoluteClearance("B", rod, slider, at=B, clearance=1e-4, bearing_radius=1e-2, normal=law),
    fm.Prismatic("guide", fm.GROUND, slider, along=(1.0, 0.0)),
    fm.Drive("motor", joint="O", motion=fm.ConstantSpeed(100.0)),
]
mech = fm.Mechanism("slider-crank", parts)
run = {"t_end": 0.06, "step": 1e-5, "save": 600}

whole = fm.simulate(mech, **run)
first = fm.simulate(mech, **run, max_steps=2345)
print(first.status)
path = first.to_netcdf("out/first_part.nc")
second = fm.simulate(mech, **run, restart=fm.load(path).restart)
print(second.status)

for name in whole.restart:
    if not np.array_equal(whole.restart[name], second.restart[name]):
        raise SystemExit(f"the final {name!r} differs")
force = np.concatenate([first.array("B.normal_force"), second.array("B.normal_force")])
print("saved instants:", len(first.time), "+", len(second.time), "=", len(whole.time))
largest = float(abs(force - whole.array("B.normal_force")).max())
print(f"largest difference of the contact force: {largest} N (exact 0)")
