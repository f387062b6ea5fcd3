"""VTK files, read back with meshio and pyvista: geometry, times, section forces in closed form, bad input."""

import json
import runpy
from pathlib import Path
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest
import pyvista

import flexmb as fm
from flexmb.errors import InputError
from flexmb.model.shape import PointShape
from flexmb.results.vtk import write_vtk

handmade = runpy.run_path(str(Path(__file__).parents[1] / "handmade.py"))
solution, arc = handmade["solution"], handmade["arc"]
EI, EA, BEND, ELEMENT = (handmade[name] for name in ("EI", "EA", "BEND", "ELEMENT"))

QUARTER = 25  # of 101 frames over one turn: the curvature is at its largest


def frames_of(pvd):
    """(time, file) of every frame of a collection."""
    sets = ElementTree.parse(pvd).getroot().iter("DataSet")
    return [(float(s.get("timestep")), pvd.parent / s.get("file")) for s in sets]


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    sol = solution()
    pvd = write_vtk(sol, tmp_path_factory.mktemp("vtk") / "out" / "hand.pvd", frames=101, points_per_element=5)
    return sol, pvd, [(t, meshio.read(file)) for t, file in frames_of(pvd)]


def cells_of(mesh, name, word, pvd):
    """Cells by type whose `name` (part or kind) is `word`."""
    names = json.loads((pvd.with_suffix("") / "names.json").read_text())[f"{name}s"]
    number = int(next(k for k, n in names.items() if n == word))
    data = zip(mesh.cells, mesh.cell_data[name], strict=True)
    return {block.type: block.data[numbers == number] for block, numbers in data}


def test_times_are_in_order_and_those_of_the_solution(written):
    sol, _, frames = written
    np.testing.assert_array_equal([t for t, _ in frames], sol.time)


def test_cells(written):
    _, pvd, frames = written
    mesh = frames[0][1]
    assert {block.type: len(block.data) for block in mesh.cells} == {"line": 1 + 2 * 4, "vertex": 3}
    assert len(cells_of(mesh, "part", "crank", pvd)["line"]) == 1
    assert len(cells_of(mesh, "kind", "beam", pvd)["line"]) == 8
    assert len(cells_of(mesh, "kind", "clearance", pvd)["vertex"]) == 1


def test_ends_of_the_beam_are_the_nodes(written):
    sol, pvd, frames = written
    for k, (_, mesh) in enumerate(frames):
        line = cells_of(mesh, "part", "arm", pvd)["line"]
        start, end = mesh.points[line[0, 0]], mesh.points[line[-1, 1]]
        assert np.abs(start[:2] - [sol["arm.start.x"][k], sol["arm.start.y"][k]]).max() <= 1e-12
        assert np.abs(end[:2] - [sol["arm.end.x"][k], sol["arm.end.y"][k]]).max() <= 1e-12
        assert start[2] == end[2] == 0.0


def test_the_beam_lies_on_its_arc(written):
    _, pvd, frames = written
    mesh = frames[QUARTER][1]
    line = cells_of(mesh, "part", "arm", pvd)["line"]
    points = mesh.points[np.append(line[:, 0], line[-1, 1])][:, :2]
    centre = np.array([1.0, 1.0 / BEND])
    # the cubic differs from the arc by its fourth-order term: k^3 L^4 / 384 in the middle of the element
    np.testing.assert_allclose(np.hypot(*(points - centre).T), 1.0 / BEND, atol=1.3 * BEND**3 * ELEMENT**4 / 384.0)


def test_section_forces_of_the_arc(written):
    _, pvd, frames = written
    for k, sign in ((QUARTER, 1.0), (3 * QUARTER, -1.0)):
        mesh = frames[k][1]
        points = np.unique(cells_of(mesh, "part", "arm", pvd)["line"])
        data = {name: values[points] for name, values in mesh.point_data.items()}
        np.testing.assert_allclose(data["curvature"], sign * BEND, rtol=1e-10)
        # sin(x)/x = 1 - x^2/6 + x^4/120: the L/30 term takes the second-order part of the shortening away
        axial = EA * (BEND * ELEMENT) ** 4 / 1920.0
        np.testing.assert_allclose(data["axial_force"], axial, rtol=0.01)
        tension = axial * ELEMENT / 30.0 * 5.0 * BEND * ELEMENT / 2.0
        x = np.tile(np.linspace(0.0, 1.0, 5), 2)
        arm = axial * 0.5 * BEND * ELEMENT**2 * x * (1.0 - x)  # the axial force acts along the chord
        np.testing.assert_allclose(data["bending_moment"], sign * (EI * BEND + tension - arm), rtol=1e-5)
        np.testing.assert_allclose(data["shear_force"], 0.0, atol=1e-9)
        np.testing.assert_allclose(data["bending_stiffness"], EI)


def test_rigid_parts_carry_no_section_forces(written):
    _, pvd, frames = written
    mesh = frames[QUARTER][1]
    points = np.unique(cells_of(mesh, "part", "crank", pvd)["line"])
    for name in ("axial_force", "bending_moment", "shear_force", "curvature"):
        assert not mesh.point_data[name][points].any()


def test_crank_turns(written):
    _, pvd, frames = written
    mesh = frames[QUARTER][1]
    (segment,) = cells_of(mesh, "part", "crank", pvd)["line"]
    np.testing.assert_allclose(mesh.points[segment], [[0.0, 0.0, 0.0], [0.0, 0.2, 0.0]], atol=1e-14)
    np.testing.assert_allclose(mesh.point_data["displacement"][segment[1]], [-0.2, 0.2, 0.0], atol=1e-14)
    assert not frames[0][1].point_data["displacement"].any()


def test_bearing_journal_and_force(written):
    _, pvd, frames = written
    mesh = frames[QUARTER][1]
    ((bearing,),) = cells_of(mesh, "kind", "clearance", pvd)["vertex"]
    ((journal,),) = cells_of(mesh, "kind", "journal", pvd)["vertex"]
    np.testing.assert_allclose(mesh.points[bearing], [0.0, 0.2, 0.0], atol=1e-14)
    np.testing.assert_allclose(mesh.points[journal] - mesh.points[bearing], [0.0, -1e-3, 0.0], atol=1e-14)
    np.testing.assert_allclose(mesh.point_data["normal_force"][[bearing, journal]], 100.0)
    ((pin,),) = cells_of(mesh, "kind", "revolute", pvd)["vertex"]
    assert mesh.point_data["normal_force"][pin] == 0.0


def test_a_mechanism_warped_by_its_deformation_stays_together(tmp_path):
    """Bars of a flexible nine-bar mechanism, warped 50-fold with pyvista, meet at their joints; the slider stays."""
    sol = fm.simulate(fm.mechanisms.nine_bar(flexible=True), t_end=0.02, step=1e-3, save="steps")
    pvd = write_vtk(sol, tmp_path / "bars.pvd", frames=3, points_per_element=3)
    file = frames_of(pvd)[-1][1]
    read, mesh = meshio.read(file), pyvista.read(file)
    assert 1e-7 < np.abs(mesh["deformation"]).max() < 1e-4
    ends = {}
    for part in ("crank1", "link2", "link3", "crank4", "rocker6", "link8"):
        line = cells_of(read, "part", part, pvd)["line"]
        ends[part] = line[0, 0], line[-1, 1]
    panel = cells_of(read, "part", "panel7", pvd)["line"]
    joints = [(ends["crank1"][1], ends["link2"][0]), (ends["crank4"][1], ends["link3"][0])]
    joints += [(ends["link2"][1], ends["link3"][1]), (ends["rocker6"][1], panel[0, 0]), (ends["link2"][1], panel[8, 0])]

    def gap(field):
        warped = np.asarray(mesh.warp_by_vector(field, factor=50.0).points)
        return max(np.linalg.norm(warped[a] - warped[b]) for a, b in joints)

    assert gap("deformation") < 1e-4
    off = {name: read.point_data["deformation"][np.unique(cells)] for name in ("slider", "crank1")
           for cells in [cells_of(read, "part", name, pvd)["line"]]}  # fmt: skip
    assert np.abs(off["slider"]).max() < 1e-15
    assert np.abs(off["crank1"]).max() > 0.0
    bent = mesh["deformation"] - mesh["displacement"]
    assert np.abs(bent).max() > 1e-3  # the displacement is nearly all rigid motion


def test_pyvista_reads_the_collection(written):
    sol, pvd, _ = written
    reader = pyvista.get_reader(str(pvd))
    np.testing.assert_array_equal(reader.time_values, sol.time)
    reader.set_active_time_value(float(sol.time[QUARTER]))
    mesh = reader.read()[0]
    assert mesh.n_cells == 12
    assert set(mesh.celltypes.tolist()) == {int(pyvista.CellType.LINE), int(pyvista.CellType.VERTEX)}
    tip = arc(np.array([BEND]), 2.0 * ELEMENT)[0, :2]
    assert np.abs(mesh.points[:, :2] - tip).max(axis=1).min() <= 1e-12


def test_at_most_200_frames_by_default(tmp_path):
    frames = frames_of(write_vtk(solution(n=1001), tmp_path / "a.pvd", points_per_element=2))
    times = np.array([t for t, _ in frames])
    assert len(times) == 200
    assert times[0] == 0.0
    assert times[-1] == 1.0
    assert np.diff(times).max() <= 1.0 / 199.0 + 1e-3


def test_frames_are_even_in_time_where_saving_was_not(tmp_path):
    time = np.concatenate([np.linspace(0.0, 0.1, 901), np.linspace(0.2, 1.0, 9)])
    base = handmade["columns"](time)
    values = np.stack([v for v, _ in base.values()], axis=-1)
    frames = frames_of(write_vtk(solution(n=910, time=time, values=values), tmp_path / "a.pvd", frames=11))
    np.testing.assert_allclose([t for t, _ in frames], np.linspace(0.0, 1.0, 11), atol=1e-12)


def test_older_frames_go_and_other_files_stay(tmp_path):
    write_vtk(solution(n=9), tmp_path / "a.pvd")
    mine = tmp_path / "a" / "notes.txt"
    mine.write_text("mine")
    pvd = write_vtk(solution(n=9), str(tmp_path / "a"), frames=3)
    assert pvd == tmp_path / "a.pvd"
    left = sorted(file.name for file in (tmp_path / "a").iterdir())
    assert left == ["a_0000.vtu", "a_0001.vtu", "a_0002.vtu", "names.json", "notes.txt"]
    assert len(frames_of(pvd)) == 3
    assert sorted(file.name for file in tmp_path.iterdir()) == ["a", "a.pvd"]


def test_a_mechanism_of_points_alone(tmp_path):
    pvd = write_vtk(solution(shapes=(PointShape("O", "weld", "ground", "", (0.0, 0.5)),)), tmp_path / "a.pvd", frames=2)
    mesh = meshio.read(frames_of(pvd)[0][1])
    assert [block.type for block in mesh.cells] == ["vertex"]
    assert len(cells_of(mesh, "kind", "weld", pvd)["vertex"]) == 1


@pytest.mark.parametrize("name", ["a & b.pvd", 'say "hi".pvd', "v1.2.pvd"])
def test_names_that_xml_must_quote(tmp_path, name):
    ((_, file), _) = frames_of(write_vtk(solution(), tmp_path / name, frames=2))
    assert file.is_file()


@pytest.mark.parametrize(
    ("changes", "keywords", "words"),
    [
        ({}, {"frames": 1}, "frames is 1; it must be at least 2"),
        ({}, {"frames": 2.5}, "frames is 2.5; it must be a whole number"),
        ({}, {"points_per_element": 1}, "points_per_element is 1; it must be at least 2"),
        ({"shapes": ()}, {}, "no shapes"),
        ({"n": 0, "peaks": (np.zeros(17), np.zeros(17))}, {}, "no saved instants"),
    ],
)
def test_bad_arguments(tmp_path, changes, keywords, words):
    with pytest.raises(InputError, match=words):
        write_vtk(solution(**changes), tmp_path / "a.pvd", **keywords)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("where", ["file.txt/a.pvd", "taken.pvd", "blocked.pvd"])
def test_a_place_that_cannot_be_written(tmp_path, where):
    (tmp_path / "file.txt").write_text("text")
    (tmp_path / "taken").write_text("a file where the folder of the frames would be")
    (tmp_path / "blocked.pvd").mkdir()
    with pytest.raises(InputError, match=f"{where}.*cannot be written.*writable folder"):
        write_vtk(solution(), tmp_path / where, frames=2)


def test_another_ending(tmp_path):
    with pytest.raises(InputError, match=r"a\.vtk.*must end in \.pvd"):
        write_vtk(solution(), tmp_path / "a.vtk")


def test_paths_of_markers_belong_to_every_frame(tmp_path):
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.3, 0.0), mass=1.0, inertia=1e-2)
    parts = [crank, fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)), fm.Drive("motor", "O", fm.ConstantSpeed(5.0))]
    mech = fm.Mechanism("crank", [*parts, fm.Marker("tip", crank, at=(0.3, 0.0), trace=True)])
    sol = fm.simulate(mech, periods=1, save=100)
    path = fm.write_vtk(sol, tmp_path / "crank.pvd", frames=5)
    traced = meshio.read(tmp_path / "crank" / "traces.vtu")
    assert len(traced.points) == len(sol.time)
    np.testing.assert_allclose(np.hypot(*traced.points[:, :2].T), 0.3, rtol=1e-7)
    np.testing.assert_array_equal(traced.point_data["time"], sol.time)
    assert path.read_text().count('part="1" file="crank/traces.vtu"') == 5
    fm.write_vtk(fm.simulate(mech.without_part("tip"), periods=1, save=100), path, frames=5)
    assert not (tmp_path / "crank" / "traces.vtu").exists()
