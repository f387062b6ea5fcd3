"""Plane bodies in VTK files, pictures, films and reports."""

import runpy
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest
from pages import soft_engine

import flexmb as fm
from flexmb.errors import InputError
from flexmb.model.shape import MeshShape
from flexmb.results import drawing
from flexmb.results.drawing import moved_points
from flexmb.results.positions import magnified
from flexmb.results.vtk import CELLS, write_vtk
from flexmb.show.pictures.films import Film, animate
from flexmb.show.pictures.scene import render, scene_of
from flexmb.show.pictures.window import Window

File = runpy.run_path(str(Path(__file__).parents[1] / "pictures" / "test_gltf.py"))["File"]
KINDS = ("tri3", "tri6", "quad4", "quad9")


def swinging(kind="quad9"):
    """A soft pendulum of few cells after some steps."""
    mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.015, hole=0.008, width=0.014, size=0.01, kind=kind)
    soft = fm.Material(young=2e7, density=7850.0, poisson=0.3)
    body = fm.PlaneBody("rod", mesh, start=(0.1, 0.2), end=(0.1, 0.32), thickness=0.01, material=soft)
    joint = fm.Revolute("O", fm.GROUND, body, at=(0.1, 0.2))
    mechanism = fm.Mechanism("pendulum", [body, joint], gravity=(9.81, 0.0))
    return fm.simulate(mechanism, t_end=0.02, step=2e-4, save=5), body


@pytest.mark.quick(1)
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


@pytest.mark.parametrize("of_beams", [False, True])
def test_vtk_of_a_reduced_body_has_the_stress_of_its_signal(tmp_path, of_beams):
    """Also of one that is shortened by much bending: a soft pendulum that turns and swings."""
    soft = fm.Material(young=2e8, density=7850.0, poisson=0.3)
    if of_beams:
        section = fm.Rectangle(width=0.01, height=0.01)
        body = fm.FlexibleLink("rod", (0.1, 0.2), (0.1, 0.32), section=section, material=soft, stress=True)
    else:
        mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.015, hole=0.008, width=0.014, size=0.01)
        body = fm.PlaneBody("rod", mesh, start=(0.1, 0.2), end=(0.1, 0.32), thickness=0.01, material=soft)
    joint = fm.Revolute("O", fm.GROUND, body, at=(0.1, 0.2))
    push = fm.Force("push", body, (0.1, 0.32), (5.0, 0.0))
    sol = fm.simulate(fm.Mechanism("pendulum", [fm.Reduced(body, 6), joint, push]), t_end=0.05, step=1e-4, save=5)
    write_vtk(sol, tmp_path / "rod.pvd")
    frames = [meshio.read(file).point_data["von_mises"] for file in sorted((tmp_path / "rod").glob("*.vtu"))]
    assert [frame.max() for frame in frames] == pytest.approx(sol.array("rod.von_mises"), rel=1e-9, abs=1.0)
    (mesh,) = drawing.surfaces(sol, np.arange(len(sol.time)))
    bent = replace(mesh, shape=replace(mesh.shape, shortening=())).von_mises.max(axis=1)
    assert np.abs(bent[1:] / mesh.von_mises[1:].max(axis=1) - 1.0).max() > 1e-3  # the shortening counts


@pytest.mark.slow
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


@pytest.fixture(scope="module", params=[pytest.param("all nodes", marks=pytest.mark.slow), "reduced"])
def engine(request):
    mechanism, rod = soft_engine()
    if request.param == "reduced":
        mechanism = mechanism.with_part(fm.Reduced(rod, modes=3))
    return fm.simulate(mechanism, t_end=0.03, step=2e-4, save=10), rod


def against_pins(sol, points):
    """Points (n, m, 2) in the axes of the line between the pins, from the first one."""
    first, last = (np.stack([sol.array(f"rod.{pin}.{axis}") for axis in "xy"], axis=-1) for pin in ("start", "end"))
    way = last - first
    u = way / np.hypot(*way.T)[:, None]
    x, y = np.moveaxis(points - first[:, None], -1, 0)
    c, s = u[:, 0, None], u[:, 1, None]
    return np.stack([c * x + s * y, c * y - s * x], axis=-1)


def test_magnification_acts_on_meshes(engine):
    """Deflections from the line between the pins grow by the factor; joints stay where they are, stresses are true."""
    sol, rod = engine
    rows = np.arange(len(sol.time))
    plain, large, none = (drawing.surfaces(magnified(sol, factor), rows)[0].points for factor in (1.0, 5.0, 0.0))
    reference = rod.mesh.points - rod.mesh.centre_of("start")
    across, more, rigid = (against_pins(sol, points)[..., 1] for points in (plain, large, none))
    length = np.hypot(*(sol.array(f"rod.end.{axis}") - sol.array(f"rod.start.{axis}") for axis in "xy"))
    longer = (length - 0.12)[:, None]
    assert np.abs(longer).max() > 1e-7  # laid between the joints, the body is stretched
    (mesh,) = (shape for shape in sol.shapes if isinstance(shape, MeshShape))
    if mesh.basis:  # the pins alone move, along their line: by the static shape of the last one, modes in the middle
        moved = [1.0 if name == "end" else 0.0 if name == "start" else 0.5 for name in mesh.nodes]
        spread = longer * (np.array(mesh.basis)[1::2, 0::3] @ moved)
        assert rigid == pytest.approx(reference[:, 1] + spread, abs=1e-9)
    else:  # all places grow alike, except on the rigid pins, which keep their size
        grown = longer / 0.12 * reference[:, 1]
        assert rigid == pytest.approx(reference[:, 1] + 0.5 * grown, abs=1e-12 + 0.5 * np.abs(grown).max())
        free = np.setdiff1d(np.arange(len(reference)), [k for name in ("start", "end") for k in rod.mesh.set_of(name)])
        assert rigid[:, free] == pytest.approx((reference[:, 1] + grown)[:, free], abs=1e-12)
    bent = np.abs(across - rigid).max()
    assert bent > 2e-4
    assert more - rigid == pytest.approx(5.0 * (across - rigid), abs=0.02 * 5.0 * bent)
    for name in ("rod.start.x", "rod.start.y", "rod.end.x", "rod.end.y"):
        assert magnified(sol, 5.0).array(name) == pytest.approx(sol.array(name), abs=1e-9)
    shown = scene_of(magnified(sol, 5.0), rows, true=sol)
    assert np.array_equal(shown.surfaces[0].von_mises, drawing.surfaces(sol, rows)[0].von_mises)
    assert np.array_equal(shown.surfaces[0].points, large)


def test_gltf_holds_the_moving_mesh_with_its_stress(engine, tmp_path):
    sol, _ = engine
    (surface,) = drawing.surfaces(magnified(sol, 3.0), np.arange(len(sol.time)))
    file = File(fm.plots.export_gltf(sol, tmp_path / "rod.glb", magnify=3.0))
    (mesh,) = (mesh for mesh in file.document["meshes"] if mesh["name"] == "rod")
    (piece,) = mesh["primitives"]
    first = file.array(piece["attributes"]["POSITION"])
    shapes = np.stack([file.array(target["POSITION"]) for target in piece["targets"]])
    motion = file.motion("rod")
    weights = motion["weights"].reshape(len(sol.time), len(shapes))
    assert len(shapes) < len(sol.time)
    own = first + np.einsum("nk,kmx->nmx", weights, shapes)
    z, w = motion["rotation"][:, 2], motion["rotation"][:, 3]
    c, s = (w * w - z * z)[:, None], (2.0 * z * w)[:, None]
    x, y = own[..., 0], own[..., 1]
    found = np.stack([c * x - s * y, s * x + c * y], axis=-1) + motion["translation"][:, None, :2]
    assert found == pytest.approx(surface.points, abs=3e-5)
    assert np.array_equal(file.array(piece["indices"]).reshape(-1, 3), surface.triangles)
    colours = file.array(piece["attributes"]["COLOR_0"])
    largest = drawing.surfaces(sol, np.arange(len(sol.time)))[0].von_mises.max(axis=0)
    light = colours @ [0.2126, 0.7152, 0.0722]  # colours of viridis are the lighter, the larger the number
    assert np.all(np.diff(light[np.argsort(largest)]) >= 0.0)
    assert light[largest.argmax()] > 5.0 * light[largest.argmin()]
    assert f"{largest.max():.4g} Pa" in file.document["materials"][piece["material"]]["name"]


def test_the_window_shows_the_stress_of_meshes(engine):
    pytest.importorskip("pyvista")
    sol, _ = engine
    rows = np.arange(len(sol.time))
    scene = scene_of(sol, rows)
    for colour in ("von_mises", "moment"):  # no beams are there
        window = Window(scene, colour, off_screen=True)
        (mesh,) = (mesh for mesh, _, data in window._moving if "von_mises" in data)
        window.go_to(7)
        assert np.array_equal(mesh.point_data["von_mises"], scene.surfaces[0].von_mises[7])
        assert mesh.points[:, :2] == pytest.approx(scene.surfaces[0].points[7])
        window.plotter.close()
    window = Window(scene, None, off_screen=True)
    assert not any("von_mises" in data for _, _, data in window._moving)
    window.plotter.close()


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
