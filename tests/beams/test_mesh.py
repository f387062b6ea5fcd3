"""Line meshes: what is read, how it is ordered and split, and every message; the meshes of the nine-bar."""

import ast
from importlib.util import module_from_spec, spec_from_file_location
from itertools import pairwise
from math import cos, pi, sin
from pathlib import Path

import meshio
import numpy as np
import pytest
from element_matrices import beam_matrices, mass_moments

from flexmb.elastic.beams import mesh as mesh_module
from flexmb.elastic.beams import section
from flexmb.elastic.beams.mesh import LineMesh, chain, members, read_lines
from flexmb.elastic.beams.section import Rectangle
from flexmb.errors import FileFormatError, InputError
from flexmb.model import law as material
from flexmb.model.law import STEEL

MESHES = Path(__file__).parents[2] / "meshes"
LENGTHS = {"crank1": 0.045, "link2": 0.326, "link3": 0.497, "crank4": 0.095, "rocker6": 0.230, "link8": 0.336}
STRIP = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.3, 0.0, 0.0]])


def lines(points, edges, tags=None) -> LineMesh:
    edges = np.array(edges)
    return LineMesh(np.array(points, dtype=float), edges, np.array(tags or [0] * len(edges)))


def write(path: Path, points, edges, extra=(), **cell_data) -> Path:
    cells = [("line", np.array(edges)), *extra]
    meshio.Mesh(np.array(points, dtype=float), cells, cell_data=cell_data).write(path)
    return path


def make_meshes():
    spec = spec_from_file_location("make_meshes", MESHES / "make_meshes.py")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(("name", "length"), LENGTHS.items())
def test_stored_links_have_the_lengths_and_tags_of_the_mechanism(name, length):
    mesh = read_lines(MESHES / f"{name}.msh")
    nodes = chain(mesh)
    assert np.array_equal(nodes, [0, 1, 2, 3, 4])
    assert mesh.stations(nodes) == pytest.approx(np.array([0.0, 0.25, 0.5, 0.75, 1.0]) * length, rel=1e-14)
    assert np.array_equal(mesh.points[:, 1], np.zeros(5))
    assert mesh.tag_of(nodes) == (2 if name == "link3" else 1)


def test_stored_panel_is_the_triangle_with_its_three_sides():
    mesh = read_lines(MESHES / "panel7.msh")
    sides = members(mesh)
    assert [side.tolist() for side in sides] == [[0, 1, 2, 3, 4], [4, 5, 6, 7, 8], [8, 9, 10, 11, 0]]
    assert [mesh.stations(side)[-1] for side in sides] == pytest.approx([0.229, 0.315, 0.304], rel=1e-14)
    assert np.array_equal(mesh.tags, np.ones(12))
    assert mesh.points[4] == pytest.approx([0.229, 0.0])
    assert mesh.points[8, 1] < 0.0  # A, B, C clockwise, as in the mechanism


def test_stored_meshes_are_what_the_script_writes(tmp_path):
    for file in make_meshes().main(["--out", str(tmp_path / "new")]):
        if file.stem.endswith("_plane"):
            continue  # see tests/mechanisms/test_nine_bar_plates.py
        new, stored = read_lines(file), read_lines(MESHES / file.name)
        assert new.points == pytest.approx(stored.points, rel=1e-14)
        assert np.array_equal(new.edges, stored.edges)
        assert np.array_equal(new.tags, stored.tags)
    assert sorted(file.name for file in MESHES.glob("*.msh")) == sorted(f.name for f in (tmp_path / "new").iterdir())


def test_script_takes_the_number_of_elements(tmp_path):
    written = make_meshes().main(["--elements", "6", "--out", str(tmp_path)])
    assert sum(path.suffix == ".msh" for path in written) == 14
    assert len(chain(read_lines(tmp_path / "link2.msh"))) == 7
    assert len(read_lines(tmp_path / "panel7.msh").edges) == 18
    with pytest.raises(SystemExit):
        make_meshes().main(["--elements", "0", "--out", str(tmp_path)])


def test_a_mesh_gives_the_mass_of_its_bar():
    """25 mm x 12 mm x 497 mm of steel."""
    mesh = read_lines(MESHES / "link3.msh")
    matrices = beam_matrices(mesh.stations(chain(mesh)), Rectangle(width=0.012, height=0.025), STEEL)
    assert mass_moments(matrices)[0] == pytest.approx(7801.0 * 0.025 * 0.012 * 0.497, rel=1e-13)


@pytest.mark.parametrize("form", ["vtu", "vtk", "xdmf", "gmsh22"])
def test_formats_give_the_same_mesh(tmp_path, form):
    names = ["gmsh:physical", "gmsh:geometrical"] if form == "gmsh22" else ["cell_tags"]
    strip = meshio.Mesh(STRIP, [("line", np.array([[0, 1], [1, 2]]))])
    strip.cell_data = {name: [np.array([5, 7], dtype=np.int32)] for name in names}
    file = tmp_path / ("strip.msh" if form == "gmsh22" else f"strip.{form}")
    strip.write(file, file_format=form)
    mesh = read_lines(file)
    assert np.array_equal(mesh.points, STRIP[:, :2])
    assert np.array_equal(mesh.edges, [[0, 1], [1, 2]])
    assert np.array_equal(mesh.tags, [5, 7])
    assert mesh.name == str(file)


GMSH_41 = """$MeshFormat
4.1 0 8
$EndMeshFormat
$Entities
3 2 0 0
1 0 0 0 0
2 0.1 0 0 0
3 0.3 0 0 0
1 0 0 0 0.1 0 0 1 5 2 1 -2
2 0.1 0 0 0.3 0 0 1 7 2 2 -3
$EndEntities
$Nodes
3 3 1 3
0 1 0 1
1
0 0 0
0 2 0 1
2
0.1 0 0
0 3 0 1
3
0.3 0 0
$EndNodes
$Elements
2 2 1 2
1 1 1 1
1 1 2
1 2 1 1
2 2 3
$EndElements
"""


def test_gmsh_4_1_keeps_the_tags_with_its_entities(tmp_path):
    file = tmp_path / "strip.msh"
    file.write_text(GMSH_41)
    mesh = read_lines(file)
    assert np.array_equal(mesh.points, STRIP[:, :2])
    assert np.array_equal(mesh.tags, [5, 7])
    assert [nodes.tolist() for nodes in members(mesh)] == [[0, 1], [1, 2]]


def test_tags_by_rank_or_none(tmp_path):
    data = {"section": [np.array([1, 2])], "cell_tags": [np.array([3, 4])], "load": [np.array([5.0, 6.0])]}
    file = write(tmp_path / "a.vtu", STRIP, [[0, 1], [1, 2]], **data)
    assert np.array_equal(read_lines(file).tags, [3, 4])
    assert np.array_equal(read_lines(write(tmp_path / "b.vtu", STRIP, [[0, 1], [1, 2]])).tags, [0, 0])


def test_single_points_and_other_cells_are_left_out(tmp_path):
    """gmsh stores the centre of an arc as a vertex; a mesh may hold triangles beside the lines."""
    points = [[9.0, 9.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]
    extra = [("vertex", np.array([[0], [1]])), ("triangle", np.array([[1, 2, 3]]))]
    tags = [np.array([4, 4, 6]), np.array([0, 0]), np.array([8])]
    mesh = read_lines(write(tmp_path / "a.vtu", points, [[1, 2], [2, 3], [3, 1]], extra, cell_tags=tags))
    assert np.array_equal(mesh.points, [[0, 0], [1, 0], [0, 1]])
    assert np.array_equal(mesh.edges, [[0, 1], [1, 2], [2, 0]])
    assert np.array_equal(mesh.tags, [4, 4, 6])


def test_chain_orders_shuffled_nodes_the_way_the_first_line_points():
    x = np.array([0.3, 0.0, 0.5, 0.1])
    points = np.stack([x * cos(2.0), x * sin(2.0)], axis=1) + 7.0
    assert np.array_equal(chain(lines(points, [[3, 0], [1, 3], [2, 0]])), [1, 3, 0, 2])
    assert np.array_equal(chain(lines(points, [[0, 3], [1, 3], [2, 0]])), [2, 0, 3, 1])
    mesh = lines(points, [[3, 0], [1, 3], [2, 0]])
    assert mesh.stations(chain(mesh)) == pytest.approx([0.0, 0.1, 0.3, 0.5], rel=1e-13)


def test_chain_allows_the_rounding_of_single_precision():
    points = np.linspace(0.0, 1.0, 33)[:, None] * np.array([[0.3, 0.7]])
    points = (points + 1.0).astype(np.float32)
    assert len(chain(lines(points, [[i, i + 1] for i in range(32)]))) == 33


PORTAL = [[0, 0], [0, 1], [0, 2], [1, 2], [2, 2], [2, 1], [2, 0], [1, 1], [0.5, 1.5]]
PORTAL_LINES = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 6], [1, 7], [7, 5]]


def test_members_end_at_corners_branches_ends_and_changes_of_tag():
    """A portal with a tie; by hand."""
    mesh = lines(PORTAL[:8], PORTAL_LINES, [1, 1, 1, 2, 1, 1, 3, 3])
    found = [nodes.tolist() for nodes in members(mesh)]
    assert found == [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 6], [1, 7, 5]]
    assert [mesh.tag_of(nodes) for nodes in members(mesh)] == [1, 1, 1, 2, 1, 1, 3]
    whole = lines(PORTAL[:8], PORTAL_LINES)
    assert [nodes.tolist() for nodes in members(whole)] == [[0, 1], [1, 2], [2, 3, 4], [4, 5], [5, 6], [1, 7, 5]]


def test_members_cover_every_line_once_whatever_the_numbering():
    rng = np.random.default_rng(5)
    for _ in range(20):
        order = rng.permutation(8)
        edges = [list(rng.permutation([order[i], order[j]])) for i, j in PORTAL_LINES]
        edges = [edges[k] for k in rng.permutation(len(edges))]
        points = np.zeros((8, 2))
        points[order] = PORTAL[:8]
        found = members(lines(points, edges))
        pairs = sorted(sorted(map(int, pair)) for nodes in found for pair in pairwise(nodes))
        assert pairs == sorted(sorted(map(int, pair)) for pair in edges)
        assert sorted(map(len, found)) == [2, 2, 2, 2, 3, 3]


def test_a_square_loop_has_four_members_and_no_chain():
    square = lines([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1], [1, 2], [2, 3], [3, 0]])
    assert [nodes.tolist() for nodes in members(square)] == [[0, 1], [1, 2], [2, 3], [3, 0]]
    with pytest.raises(InputError, match=r"close a loop; a chain has two ends. Use members"):
        chain(square)


BAD_CHAINS = [
    (PORTAL[:8], PORTAL_LINES, "3 lines meet at node 1; a chain has no branches. Use members(mesh)"),
    ([[0, 0], [1, 0], [2, 0], [3, 0]], [[0, 1], [2, 3]], "node 0 to 1 has 2 nodes, the mesh 4. Join the pieces"),
    ([[0, 0], [1, 0], [1, 1]], [[0, 1], [1, 2]], "not straight: the one from node 0 to 1 is turned by 0.785 rad"),
    ([[0, 0], [2, 0], [1, 0]], [[0, 1], [1, 2]], "node 1 to 2 is turned by 3.14 rad against the chord"),
]


@pytest.mark.parametrize(("points", "edges", "message"), BAD_CHAINS, ids=["branch", "pieces", "corner", "folded"])
def test_what_is_no_straight_chain_is_named(points, edges, message):
    with pytest.raises(InputError) as caught:
        chain(lines(points, edges))
    assert message in str(caught.value)


@pytest.mark.parametrize("closed", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_gentle_curves_are_no_members(closed):
    n = 70_000
    angle = np.arange(n) * (2.0 * pi / n)
    edges = np.stack([np.arange(n), (np.arange(n) + 1) % n], axis=1)[: n if closed else n // 20]
    angle = angle if closed else angle[: n // 20 + 1]
    circle = LineMesh(np.stack([np.cos(angle), np.sin(angle)], axis=1), edges, np.zeros(len(edges), dtype=int))
    with pytest.raises(InputError, match="not straight"):
        members(circle)


BAD_LINES = [
    ([[0, 0], [1, 0], [2, 1]], [[0, 1]], "1 nodes belong to no line, the first is node 2 at (2, 1) m. Delete them"),
    ([[0, 0], [1, 0], [1, 0]], [[0, 1], [1, 2]], "line 1 between nodes 1 and 2 has zero length. Delete it"),
    ([[0, 0], [1, 0]], [[0, 1], [0, 0]], "line 1 between nodes 0 and 0 has zero length"),
    ([[0, 0], [1, 0]], [[0, 1], [1, 0]], "lines 0 and 1 join the same nodes 1 and 0. Delete one"),
    ([[0, 0], [1, 0], [1, 0], [2, 0]], [[0, 1], [2, 3]], "nodes 1 and 2 lie at the same place (1, 0) m"),
]


@pytest.mark.parametrize(("points", "edges", "message"), BAD_LINES, ids=range(len(BAD_LINES)))
def test_bad_lines_are_named_with_their_file(tmp_path, points, edges, message):
    file = write(tmp_path / "bad.vtu", [[*point, 0.0] for point in points], edges)
    with pytest.raises(InputError) as caught:
        read_lines(file)
    assert str(caught.value).startswith(f"{file}: ")
    assert message in str(caught.value)


def refused(path: Path) -> str:
    with pytest.raises(FileFormatError) as caught:
        read_lines(path)
    assert str(caught.value).startswith(f"{path}: ")
    return str(caught.value)


def test_missing_file_is_named(tmp_path):
    assert "no such file. The current folder is" in refused(tmp_path / "none.msh")
    assert "no such file" in refused(tmp_path)


@pytest.mark.parametrize("form", ["vtu", "msh", "vtk", "txt"])
def test_broken_files_are_named_and_nothing_is_printed(tmp_path, form, capfd):
    file = tmp_path / f"broken.{form}"
    file.write_text("$MeshFormat\nnot a mesh\n")
    assert "Export it as gmsh 2.2 (.msh) or VTK (.vtu)." in refused(file)
    assert capfd.readouterr() == ("", "")


def test_truncated_file_is_named(tmp_path):
    file = tmp_path / "half.msh"
    text = (MESHES / "panel7.msh").read_text()
    file.write_text(text[: len(text) // 2])
    assert "not a mesh that meshio can read" in refused(file)


def test_mesh_without_lines_is_named(tmp_path):
    file = tmp_path / "tri.vtu"
    meshio.Mesh(np.eye(3), [("triangle", np.array([[0, 1, 2]]))]).write(file)
    assert "no two-node line cells; the cells are: triangle. Mesh the curves" in refused(file)


def test_mesh_out_of_plane_is_named(tmp_path):
    file = write(tmp_path / "a.vtu", STRIP + np.diag([0.0, 0.0, 0.02]), [[0, 1], [1, 2]])
    assert "z spreads over 0.02 m; flexmb is plane, all z must be equal. Turn the mesh" in refused(file)


def test_coordinates_that_are_not_finite_are_named(tmp_path):
    file = write(tmp_path / "a.vtk", STRIP * [[1.0], [np.nan], [1.0]], [[0, 1], [1, 2]])
    assert "node 1 is at [nan, nan, nan]; coordinates must be finite" in refused(file)


def test_tags_that_are_no_whole_numbers_are_named(tmp_path):
    file = write(tmp_path / "a.vtu", STRIP, [[0, 1], [1, 2]], cell_tags=[np.array([0.5, 1.0])])
    assert "cell data 'cell_tags' are not one whole number for each line" in refused(file)
    file = write(tmp_path / "b.vtu", STRIP, [[0, 1], [1, 2]], section=[np.array([[1, 2, 3], [1, 2, 3]])])
    assert "Give one number a line under this name, or export the mesh without it." in refused(file)


@pytest.mark.parametrize("module", [section, material, mesh_module], ids=lambda module: module.__name__)
def test_sections_materials_and_meshes_load_no_finite_element_package(module):
    """Read from the source, since other parts of the package may load these packages first."""
    top = ast.parse(Path(module.__file__).read_text()).body
    names = {alias.name for node in top if isinstance(node, ast.Import) for alias in node.names}
    names |= {node.module for node in top if isinstance(node, ast.ImportFrom)}
    assert "flexmb" in names
    assert not {name.split(".")[0] for name in names} & {"skfem", "meshio"}
    assert "flexmb.elastic.beams.fem" not in names
