"""Meshes of the gmsh package, where it is installed, and files as gmsh writes them: order 2 with physical groups."""

import math

import meshio
import numpy as np
import pytest

import flexmb as fm

LENGTH, HEIGHT, RADIUS = 0.2, 0.06, 0.01
HOLES = {"start": 0.03, "end": 0.17}
AREA = LENGTH * HEIGHT - 2.0 * math.pi * RADIUS**2


def described(mesh):
    """What a plate with two holes must show, whoever meshed it."""
    assert mesh.kind == "tri6"
    assert mesh.holes == ("start", "end")
    assert mesh.regions.keys() == {"steel"}
    assert mesh.area == pytest.approx(AREA, rel=1e-5)
    for name, x in HOLES.items():
        assert mesh.centre_of(name) == pytest.approx((x, 0.5 * HEIGHT), abs=1e-9)
    plate = fm.PlaneBody("plate", mesh, thickness={"steel": 0.01}, material=fm.STEEL)
    assert plate.total_mass() == pytest.approx(AREA * 0.01 * fm.STEEL.density, rel=1e-5)


def test_a_file_of_order_2_with_physical_groups(tmp_path):
    """Curves of three nodes name the holes, a surface the region, as in files of gmsh."""
    outline = [(0.0, 0.0), (LENGTH, 0.0), (LENGTH, HEIGHT), (0.0, HEIGHT)]
    holes = {name: ((x, 0.5 * HEIGHT), RADIUS) for name, x in HOLES.items()}
    made = fm.meshes.plate_with_holes(outline, holes, 0.008)
    blocks = [*(("line3", made.edges_in(name)) for name in HOLES), ("triangle6", made.cells)]
    tags = [np.full(len(cells), k, dtype=np.int32) for k, (_, cells) in enumerate(blocks, start=1)]
    names = {"start": np.array([1, 1]), "end": np.array([2, 1]), "steel": np.array([3, 2])}
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    file = meshio.Mesh(np.pad(made.points, ((0, 0), (0, 1))), blocks, cell_data=data, field_data=names)
    file.write(tmp_path / "plate.msh", file_format="gmsh22", binary=False)
    described(fm.meshes.read(tmp_path / "plate.msh"))


def test_the_package_meshes_a_plate(tmp_path):
    gmsh = pytest.importorskip("gmsh", reason="needs flexmb[gmsh]", exc_type=ImportError)
    gmsh.initialize(["-v", "0"], interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    try:
        occ = gmsh.model.occ
        sheet = occ.addRectangle(0.0, 0.0, 0.0, LENGTH, HEIGHT)
        discs = [(2, occ.addDisk(x, 0.5 * HEIGHT, 0.0, RADIUS, RADIUS)) for x in HOLES.values()]
        occ.cut([(2, sheet)], discs)
        occ.synchronize()
        for name, x in HOLES.items():
            rim = gmsh.model.getEntitiesInBoundingBox(x - 0.011, 0.019, -1e-3, x + 0.011, 0.041, 1e-3, 1)
            gmsh.model.addPhysicalGroup(1, [tag for _, tag in rim], name=name)
        gmsh.model.addPhysicalGroup(2, [tag for _, tag in gmsh.model.getEntities(2)], name="steel")
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.006)
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 24)
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(2)
        gmsh.write(str(tmp_path / "plate.msh"))
    finally:
        gmsh.finalize()
    described(fm.meshes.read(tmp_path / "plate.msh"))
