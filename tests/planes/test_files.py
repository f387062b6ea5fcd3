"""Plane meshes from files; those in files/ were written by gmsh 4.15: the link of `test_vibrations`, coarse."""

from pathlib import Path

import meshio
import numpy as np
import pytest

from flexmb.elastic.meshes.files import read
from flexmb.elastic.meshes.outlines import link_with_eyes
from flexmb.elastic.planes.cells import matrices
from flexmb.elastic.planes.plane_body import vibrations
from flexmb.errors import FileFormatError, InputError
from flexmb.model.law import Material

FILES = Path(__file__).parent / "files"
STEEL = Material(young=2.1e11, density=7850.0, poisson=0.3)
POINTS = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (2, 0), (2, 1)], dtype=float)


def written(path: Path, points: np.ndarray, cells: list, **data) -> Path:
    """A mesh file of meshio."""
    meshio.Mesh(points, cells, **data).write(path)
    return path


@pytest.mark.parametrize(
    ("name", "kind", "cells"),
    [("link_tri6_4.1.msh", "tri6", 128), ("link_quad8_2.2.msh", "tri6", 130), ("link_tri3_2.2.msh", "tri3", 128)],
)
def test_files_of_gmsh(name, kind, cells):
    """Names of physical groups; the second file mixes quadrilaterals of eight nodes and triangles."""
    mesh = read(FILES / name)
    assert (mesh.kind, len(mesh.cells)) == (kind, cells)
    assert list(mesh.sets) == ["start", "end", "outline"]
    assert {name: len(own) for name, own in mesh.regions.items()} == {"steel": cells}
    assert mesh.holes == ("start", "end")
    assert (mesh.centre_of("start"), mesh.centre_of("end")) == ((0.0, 0.0), (0.12, 0.0))
    assert mesh.area == pytest.approx(0.276293817 / 78.5, rel=3e-4 if kind == "tri6" else 5e-3)


def test_frequencies_of_a_mesh_of_gmsh_are_those_of_blocks():
    found = vibrations(matrices(read(FILES / "link_tri6_4.1.msh"), STEEL, 0.01), 3)[0]
    fine = vibrations(matrices(link_with_eyes(0.12, 0.02, 0.01, 0.02, 0.0025), STEEL, 0.01), 3)[0]
    assert (found > fine).all()
    np.testing.assert_allclose(found, fine, rtol=0.02)


def test_a_file_without_names_gets_them_by_points():
    mesh = read(FILES / "link_tri6.vtk")
    assert not mesh.sets
    named = mesh.with_holes({"start": (0.0, 0.0), "end": (0.12, 0.0)})
    whole = read(FILES / "link_tri6_4.1.msh")
    assert named.holes == whole.holes
    assert set(named.sets["end"].tolist()) == set(whole.sets["end"].tolist())


def test_millimetres(tmp_path):
    path = written(tmp_path / "mm.vtu", 1e3 * np.pad(POINTS[:4], ((0, 0), (0, 1))), [("quad", [[0, 1, 2, 3]])])
    assert read(path, unit=1e-3).area == pytest.approx(1.0)
    assert read(path).area == pytest.approx(1e6)
    with pytest.raises(InputError, match="unit is 0 m"):
        read(path, unit=0.0)


def test_clockwise_cells_are_turned_and_loose_nodes_left_out(tmp_path):
    points = np.pad(np.concatenate([[(9, 9)], POINTS]), ((0, 0), (0, 1)))
    path = written(tmp_path / "turned.vtu", points, [("quad", [[1, 4, 3, 2], [2, 5, 6, 3]])])
    mesh = read(path)
    assert len(mesh.points) == 6
    assert mesh.area == pytest.approx(2.0)


@pytest.mark.parametrize("kind", ["triangle6", "quad9", "quad8"])
def test_clockwise_quadratic_cells_are_turned(tmp_path, kind):
    mesh = link_with_eyes(0.12, 0.02, 0.01, 0.02, 0.01, "tri6" if kind == "triangle6" else "quad9")
    cells = mesh.cells[:, : int(kind[-1])].copy()
    turned = {"triangle6": [0, 2, 1, 5, 4, 3], "quad8": [0, 3, 2, 1, 7, 6, 5, 4], "quad9": [0, 3, 2, 1, 7, 6, 5, 4, 8]}
    cells[::2] = cells[::2, turned[kind]]
    path = written(tmp_path / "turned.vtu", np.pad(mesh.points, ((0, 0), (0, 1))), [(kind, cells)])
    found = read(path)
    assert found.kind == mesh.kind
    # centres that eight-node cells do not have change the inside of cells alone
    assert found.area == pytest.approx(mesh.area, rel=1e-12)


def test_groups_without_names_are_called_by_their_numbers(tmp_path):
    cells = [("line", [[0, 1]]), ("quad", [[0, 1, 2, 3], [1, 4, 5, 2]])]
    data = {"gmsh:physical": [np.array([7]), np.array([1, 2])], "gmsh:geometrical": [np.array([1]), np.array([1, 2])]}
    path = tmp_path / "tags.msh"
    meshio.Mesh(np.pad(POINTS, ((0, 0), (0, 1))), cells, cell_data=data).write(path, file_format="gmsh22", binary=False)
    mesh = read(path)
    assert mesh.sets["7"].tolist() == [0, 1]
    assert {name: own.tolist() for name, own in mesh.regions.items()} == {"1": [0], "2": [1]}


def test_regions_follow_cells_that_are_halved(tmp_path):
    cells = [("quad", [[0, 1, 2, 3]]), ("triangle", [[1, 4, 5], [1, 5, 2]])]
    data = {"gmsh:physical": [np.array([1]), np.array([2, 1])], "gmsh:geometrical": [np.array([1]), np.array([1, 1])]}
    path = tmp_path / "mixed.msh"
    meshio.Mesh(np.pad(POINTS, ((0, 0), (0, 1))), cells, cell_data=data).write(path, file_format="gmsh22", binary=False)
    mesh = read(path)
    assert mesh.kind == "tri3"
    area = {name: sum(_area(mesh.points[mesh.cells[c]]) for c in own) for name, own in mesh.regions.items()}
    assert area == pytest.approx({"1": 1.5, "2": 0.5})


def _area(corners: np.ndarray) -> float:
    a, b = corners[1] - corners[0], corners[2] - corners[0]
    return 0.5 * float(a[0] * b[1] - a[1] * b[0])


def test_sets_of_nodes_are_kept(tmp_path):
    path = tmp_path / "sets.inp"
    mesh = meshio.Mesh(np.pad(POINTS, ((0, 0), (0, 1))), [("quad", [[0, 1, 2, 3], [1, 4, 5, 2]])])
    mesh.point_sets = {"left side": np.array([0, 3])}
    mesh.write(path)
    assert read(path).sets["left side"].tolist() == [0, 3]


@pytest.mark.parametrize(
    ("points", "cells", "words"),
    [
        (np.pad(POINTS, ((0, 0), (0, 1))), [("line", [[0, 1], [1, 2]])], "no plane cells; the cells are: line"),
        (np.pad(POINTS, ((0, 0), (0, 1)), constant_values=1.0) * [1, 1, 0] + [[0, 0, k] for k in range(6)],
         [("quad", [[0, 1, 2, 3]])], "z spreads over 5 m"),
        (np.pad(POINTS, ((0, 0), (0, 1))),
         [("quad", [[0, 1, 2, 3]]), ("triangle6", [[0, 1, 2, 3, 4, 5]])], "linear and quadratic cells"),
    ],
)  # fmt: skip
def test_files_that_are_no_plane_mesh_are_refused(tmp_path, points, cells, words):
    with pytest.raises(FileFormatError, match=words):
        read(written(tmp_path / "bad.vtu", points, cells))


def test_missing_and_broken_files_are_refused(tmp_path):
    with pytest.raises(FileFormatError, match="no such file"):
        read(tmp_path / "none.msh")
    broken = tmp_path / "broken.msh"
    broken.write_text("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0", encoding="utf-8")
    with pytest.raises(FileFormatError, match="not a mesh that meshio can read"):
        read(broken)
