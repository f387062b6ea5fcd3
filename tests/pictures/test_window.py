"""The window of a run without a display: what it shows, slider, keys, colours, bad input; PVD files in VTK's reader."""

import runpy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError
from flexmb.show.pictures.films import field_limit
from flexmb.show.pictures.scene import scene_of
from flexmb.show.pictures.window import Window

pyvista = pytest.importorskip("pyvista")

solution = runpy.run_path(str(Path(__file__).parents[1] / "handmade.py"))["solution"]


@pytest.fixture(scope="module")
def sol():
    return solution()


@pytest.mark.slow
def test_the_plotter_draws_without_a_display(sol):
    plotter = fm.view(sol, off_screen=True)
    image = plotter.screenshot(return_img=True)
    plotter.close()
    assert image.shape == (800, 1200, 3)
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 20


def test_the_slider_moves_the_parts(sol):
    window = Window(scene_of(sol, np.arange(101)), "moment", off_screen=True)
    mesh, points, _ = window._moving[0]  # the crank
    slider = window._slider.GetRepresentation()
    window.go_to(25)
    np.testing.assert_allclose(mesh.points[:, :2], [[0.0, 0.0], [0.0, 0.2]], atol=1e-7)
    assert slider.GetValue() == pytest.approx(0.25, rel=1e-6)
    window.go_to(101)  # begins again
    np.testing.assert_allclose(mesh.points[:, :2], points[0][:, :2], atol=1e-7)
    window._toggle()
    window._tick()
    assert slider.GetValue() == pytest.approx(0.01, rel=1e-5)
    window._toggle()
    window._tick()
    assert slider.GetValue() == pytest.approx(0.01, rel=1e-5)
    window.plotter.close()


def test_the_view_follows_a_node(sol):
    plotter = fm.view(sol, off_screen=True, follow="arm.end", time=0.5)
    tip = [float(sol[f"arm.end.{axis}"].sel(time=0.5, method="nearest")) for axis in "xy"]
    np.testing.assert_allclose(plotter.camera.focal_point[:2], tip, atol=1e-9)
    plotter.close()


def test_a_lone_body_is_seen():
    ball = fm.RigidBody("ball", (0.3, 0.2), 1.0, 0.1)
    still = fm.simulate(fm.Mechanism("ball", [ball]), t_end=1e-3, step=1e-3)
    plotter = fm.view(still, off_screen=True)
    image = plotter.screenshot(return_img=True)
    plotter.close()
    middle = image[350:450, 550:650].reshape(-1, 3)
    assert (middle < 250).any(axis=1).sum() > 50


def test_colours_and_bar_are_those_of_the_field(sol):
    scene = scene_of(sol, np.arange(0, 101, 10))
    window = Window(scene, "moment", off_screen=True)
    assert list(window.plotter.scalar_bars.keys()) == ["bending moment\n[N m]\n"]
    colours = next(data["bending_moment"] for _, _, data in window._moving if data)
    assert np.abs(colours).max() == pytest.approx(1.7 * 0.5 * np.sin(2.0 * np.pi * 0.2), rel=1e-3)
    assert field_limit(scene, "bending_moment") <= np.abs(colours).max()
    window.plotter.close()


@pytest.mark.parametrize(
    ("keywords", "words"),
    [
        ({"colour": "stress"}, "colour is 'stress'"),
        ({"time": 3.0}, "time is 3"),
        ({"magnify": -1.0}, "magnify is -1"),
        ({"follow": "crnk"}, "view: follow is 'crnk'"),
        ({"forces": ["Q"]}, "view: forces is 'Q'"),
    ],
)
def test_what_is_refused(sol, keywords, words):
    with pytest.raises(InputError, match=words):
        fm.view(sol, off_screen=True, **keywords)
    with pytest.raises(InputError, match="no shapes"):
        fm.view(replace(sol, shapes=()), off_screen=True)


def test_vtk_reads_a_collection_with_its_times(sol, tmp_path):
    """The reader of ParaView, through pyvista."""
    reader = pyvista.get_reader(str(fm.write_vtk(sol, tmp_path / "a.pvd", frames=5)))
    np.testing.assert_allclose(reader.time_values, [0.0, 0.25, 0.5, 0.75, 1.0])
    tips = []
    for time in reader.time_values:
        reader.set_active_time_value(time)
        mesh = reader.read()[0]
        tips.append(mesh.points[1, :2])  # end of the crank
        assert {"bending_moment", "displacement", "normal_force"} <= set(mesh.point_data)
    np.testing.assert_allclose(tips, [[0.2, 0.0], [0.0, 0.2], [-0.2, 0.0], [0.0, -0.2], [0.2, 0.0]], atol=1e-12)
