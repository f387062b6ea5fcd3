"""A bracket from a mesh file: a column that is clamped at its foot, an arm welded to its top, a load at the arm's end.

For small deflections Castigliano's theorem gives the sinking of the load,

    u = P a^3 / (3 E I) + P a^2 h / (E I) + P h / (E A),

and equilibrium the bending moment all along the column, P a.  The load is put on at once and the motion, which is
strongly damped, written as VTK files for ParaView; its last frame is at rest.
"""

from pathlib import Path

import meshio
import numpy as np

import flexmb as fm

out = Path("out")
h, a, P, n = 0.8, 0.5, 0.02, 6
width, depth = 0.02, 0.01
steel = fm.Material(young=207e9, density=7850.0)

# the mesh, as a mesh generator would write it: points, lines between them, a tag that names the cross section
column = [(0.0, h * i / n, 0.0) for i in range(n + 1)]
arm = [(a * i / n, h, 0.0) for i in range(1, n + 1)]
lines = np.array([(i, i + 1) for i in range(2 * n)])
tags = [np.ones(2 * n, dtype=np.int32)]
out.mkdir(exist_ok=True)
mesh = meshio.Mesh(column + arm, [("line", lines)], cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags})
mesh.write(out / "bracket.msh", file_format="gmsh22", binary=False)

frame = fm.FlexibleFrame.from_mesh(
    "bracket", str(out / "bracket.msh"), sections={1: fm.Rectangle(width, depth)}, material=steel, damping=0.02
)
parts = [frame, fm.Fixed("foot", fm.GROUND, frame, at=(0.0, 0.0)), fm.Force("P", frame, at=(a, h), force=(0.0, -P))]
mech = fm.Mechanism("bracket", parts, gravity=(0.0, 0.0))

EI, EA = steel.young * width * depth**3 / 12, steel.young * width * depth
exact = P * a**3 / (3 * EI) + P * a**2 * h / EI + P * h / EA
end = next(node.name for node in frame.nodes() if abs(node.x - a) < 1e-9)
sinking = h - fm.static_equilibrium(mech)[f"bracket.{end}.y"]
print(f"statics: the load sinks by {1e6 * sinking:.4f} um, Castigliano {1e6 * exact:.4f} um")

sol = fm.simulate(mech, t_end=1.5, step=1e-3, save=300)
if not sol.ok:
    raise SystemExit(sol.status)
moved = h - sol.array(f"bracket.{end}.y")[-1]
pvd = fm.write_vtk(sol, out / "bracket.pvd", frames=50)
last = meshio.read(sorted(out.glob("bracket/*.vtu"))[-1])
moment = abs(last.point_data["bending_moment"]).max()
print(f"motion:  at rest after {1e6 * moved:.4f} um")
print(f"moment:  {1e3 * moment:.5f} N mm in the column, P a = {1e3 * P * a:.5f} N mm")
print(f"frames:  {pvd}")
