"""Plane bodies in VTK files, pictures, films and reports."""

import meshio
import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError
from flexmb.model.shape import MeshShape
from flexmb.pictures.films.film import animate
from flexmb.pictures.films.film_frames import Film
from flexmb.pictures.poses.render import render
from flexmb.reports.scene import scene
from flexmb.results import drawing
from flexmb.results.surfaces import moved_points
from flexmb.results.vtk import CELLS, write_vtk

KINDS = ("tri3", "tri6", "quad4", "quad9")


def swinging(kind="quad9"):
    """A soft pendulum of few cells after some steps."""
    mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.015, hole=0.008, width=0.014, size=0.01, kind=kind)
    soft = fm.Material(young=2e7, density=7850.0, poisson=0.3)
    body = fm.PlaneBody("rod", mesh, start=(0.1, 0.2), end=(0.1, 0.32), thickness=0.01, material=soft)
    joint = fm.Revolute("O", fm.GROUND, body, at=(0.1, 0.2))
    mechanism = fm.Mechanism("pendulum", [body, joint], gravity=(9.81, 0.0))
    return fm.simulate(mechanism, t_end=0.02, step=2e-4, save=5), body


@pytest.mark.parametrize("kind", KINDS)
def test_vtk_holds_the_deformed_mesh_with_its_stress(tmp_path, kind):
    sol, body = swinging(kind)
    path = write_vtk(sol, tmp_path / "rod.pvd")
    last = meshio.read(sorted((tmp_path / "rod").glob("*.vtu"))[-1])
    (cells,) = (block.data for block in last.cells if block.type == CELLS[kind])
    surface = drawing.surfaces(sol, np.arange(len(sol.time)))[0]
    assert path.exists()
    assert cells.shape == body.mesh.cells.shape
    offset = cells.min()
    assert np.array_equal(cells - offset, body.mesh.cells)
    assert last.points[offset:, :2] == pytest.approx(surface.points[-1])
    assert last.point_data["von_mises"][offset:] == pytest.approx(surface.von_mises[-1])
    assert last.point_data["von_mises"].max() == pytest.approx(sol.array("rod.von_mises")[-1], rel=1e-6)
    displacement = np.linalg.norm(last.point_data["displacement"][offset:], axis=1)
    assert displacement.max() > 1e-3
    assert np.all(last.point_data["stress_x"][:offset] == 0.0)


def test_pictures_and_films_show_meshes(tmp_path):
    """Every cell is a polygon; colours of a film reach to the largest stress."""
    from matplotlib.collections import PolyCollection

    sol, body = swinging()
    figure = render(sol, [0.0, 0.02])
    polygons = [artist for artist in figure.axes[0].collections if isinstance(artist, PolyCollection)]
    assert [len(artist.get_paths()) for artist in polygons] == [len(body.mesh.cells)]
    path = animate(sol, tmp_path / "rod.gif", seconds=0.2, fps=10, colour="von_mises")
    assert path.stat().st_size > 0
    film = Film(sol, sol.time, 1.0, "von_mises", {}, (), (400, 300))
    (coloured,) = (a for a in film._pose.artists if isinstance(a, PolyCollection))
    assert coloured.norm.vmin == 0.0
    assert coloured.norm.vmax == pytest.approx(film.scene.surfaces[0].von_mises.max())
    with pytest.raises(InputError, match="von_mises"):
        animate(sol, tmp_path / "rod.gif", colour="stress")


def test_report_has_the_outline_of_the_body():
    sol, body = swinging()
    shown = scene(sol, None, np.arange(len(sol.time)))
    (outline,) = (item for item in shown["rigid"] if item["part"] == "rod")
    assert [len(loop) for loop in outline["lines"]] == [len(loop) + 1 for loop in body.mesh.loops]
    first = body.mesh.points[body.mesh.loops[0]] - body.mesh.centre_of("start")
    assert np.array(outline["lines"][0])[:-1] == pytest.approx(first, abs=1e-6)


def test_reduced_mesh_moves_with_its_frame():
    """Points of a mesh by poses of two nodes: a rigid motion carries them, a shape adds its displacement."""
    points, poses = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)), ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    rigid = np.zeros((6, 6))
    x, y = np.array(points).T
    rigid[0::2, 0] = rigid[1::2, 1] = 1.0
    rigid[0::2, 2], rigid[1::2, 2] = -y, x
    rigid[4, 5] = 2.0  # a turn of the second node moves the third point along x
    shape = MeshShape(
        "body", "tri3", points, ((0, 1, 2),), ((0, 1, 2),), ("a", "b"), poses=poses,
        weights=((-0.5, 0.0), (0.5, 0.0)), basis=tuple(map(tuple, rigid.tolist())),
    )  # fmt: skip
    angle = 2.0 * np.pi * 3.0 + 0.5
    c, s = np.cos(angle), np.sin(angle)
    moved = [(2.0, 3.0, angle), (2.0 + c, 3.0 + s, angle + 1e-3)]
    found = moved_points(shape, np.array([moved]))[0]
    expected = np.array([(2.0 + c * a - s * b, 3.0 + s * a + c * b) for a, b in points])
    expected[2] += 2e-3 * np.array([c, s])
    assert found == pytest.approx(expected, abs=1e-12)
