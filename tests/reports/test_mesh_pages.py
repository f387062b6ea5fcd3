"""Meshes of flexible bodies on a page: deformed, magnified, with their stress, and small."""

import numpy as np
import pytest
from pages import Page, soft_engine, unpacked

import flexmb as fm
from flexmb.results import drawing
from flexmb.results.positions import magnified
from flexmb.show.reports.scene import MOST_POINTS, coarse


@pytest.fixture(scope="module")
def engine():
    """Run of an engine with a reduced connecting rod."""
    mechanism, rod = soft_engine()
    return fm.simulate(mechanism.with_part(fm.Reduced(rod, modes=3)), t_end=0.05, step=2e-4, save=100)


@pytest.fixture(scope="module")
def page(engine, tmp_path_factory):
    return Page(fm.report(engine, tmp_path_factory.mktemp("mesh") / "run.html"))


@pytest.mark.slow
def test_a_page_holds_the_deformed_mesh_and_its_stress(engine, page):
    (mesh,) = page.data["scene"]["meshes"]
    (surface,) = drawing.surfaces(engine, np.arange(len(engine.time)))
    kept, triangles, loops = coarse(surface, MOST_POINTS)
    assert len(kept) == len(surface.shape.points)  # of a small mesh all
    assert np.array_equal(np.array(mesh["triangles"]).reshape(-1, 3), triangles)
    assert [len(loop) for loop in mesh["loops"]] == [len(loop) for loop in loops]
    x, y, angle = unpacked(page.data["scene"]["frames"])[:, 3 * mesh["frame"] : 3 * mesh["frame"] + 3].T[:, :, None]
    moved = unpacked(mesh["weights"]) @ unpacked(mesh["shapes"]).T
    assert unpacked(mesh["weights"]).shape[1] < 8
    u, v = unpacked(mesh["points"]).T[:, None] + moved.reshape(len(moved), 2, -1).transpose(1, 0, 2)
    c, s = np.cos(angle), np.sin(angle)
    found = np.stack([x + c * u - s * v, y + s * u + c * v], axis=-1)
    assert found == pytest.approx(surface.points, abs=4e-4 * mesh["largest"])
    largest = surface.von_mises.max()
    assert unpacked(mesh["stress"]) == pytest.approx(surface.von_mises, abs=0.5e-3 * largest)


@pytest.mark.slow
@pytest.mark.parametrize("factor", [1, 10])
def test_a_mesh_in_the_browser_is_that_of_the_solution(opened, engine, page, factor):
    rows = np.arange(len(engine.time))
    bends, plain = (drawing.surfaces(magnified(engine, k), rows)[0].points for k in (float(factor), 0.0))
    frame = int(np.abs(bends - plain).max(axis=(1, 2)).argmax())
    bent = np.abs(bends - plain)[frame].max()
    assert bent > 2e-4 * factor
    shown = opened(page.path)
    shown.select_option("#magnification", str(factor))
    shown.evaluate(f"flexmbReport.clock.goToFrame({frame})")
    x, y = (np.array(list(shown.evaluate(f"Array.from(flexmbReport.picture.scene.meshes[0].{a})"))) for a in "xy")
    # the page magnifies the elongation between the joints, too
    assert np.column_stack([x, y]) == pytest.approx(bends[frame], abs=2e-7 if factor == 1 else 0.1 * bent)
    pin = shown.evaluate("((s) => s.point(s.raw.points.find((p) => p.part === 'B').at))(flexmbReport.picture.scene)")
    assert pin == pytest.approx([engine.array(f"slider.{axis}")[frame] for axis in "xy"], abs=0.1 * bent)


def test_colours_show_the_stress(opened, engine, page):
    """Pixels inside the most and the least stressed triangle."""
    shown = opened(page.path)
    assert shown.input_value("#colour") == "stress"
    (surface,) = drawing.surfaces(engine, np.arange(len(engine.time)))
    frame = int(surface.von_mises.max(axis=1).argmax())
    shown.evaluate(f"flexmbReport.clock.goToFrame({frame})")
    mean = surface.von_mises[frame][surface.triangles].mean(axis=1)

    def pixel(triangle):
        x, y = surface.points[frame][surface.triangles[triangle]].mean(axis=0)
        code = f"""(() => {{ const p = flexmbReport.picture; const [px, py] = p.screen([{x}, {y}]);
            const copy = document.createElement("canvas").getContext("2d");
            copy.drawImage(p.canvas, -Math.round(px), -Math.round(py));
            return Array.from(copy.getImageData(0, 0, 1, 1).data); }})()"""
        return np.array(shown.evaluate(code)[:3])

    stressed, calm = pixel(mean.argmax()), pixel(mean.argmin())
    assert stressed[0] - stressed[2] > 120  # red
    assert abs(calm[0] - calm[2]) < 40  # grey
    limit = shown.evaluate("flexmbReport.picture.limits.stress")
    assert limit == pytest.approx(717e3, rel=1e-3)
    ticks = [float(text) for text in shown.locator("#legend-ticks span").all_inner_texts()]
    assert ticks == pytest.approx([1e-3 * limit * k / 4 for k in range(5)], rel=5e-3)
    assert "stress [kPa]" in shown.locator("#legend-text").inner_text()
    shown.select_option("#colour", "part")
    assert np.abs(pixel(mean.argmax()) - pixel(mean.argmin())).max() < 3


@pytest.mark.parametrize("width", [390, 1280])
def test_nothing_overlaps_or_is_cut(opened, layout_faults, page, width):
    assert layout_faults(opened(page.path, width, 844)) == []


def test_few_points_stand_for_a_fine_mesh():
    """They keep outline and area, and no triangle has two equal corners."""
    mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.02, hole=0.01, width=0.014, size=0.003)
    steel = fm.Material(young=2e11, density=7850.0, poisson=0.3)
    rod = fm.PlaneBody("rod", mesh, thickness=0.01, material=steel)
    sol = fm.simulate(fm.Mechanism("rod", [fm.Reduced(rod)]), t_end=1e-4, step=1e-4)
    (surface,) = drawing.surfaces(sol, np.array([0]))
    kept, triangles, loops = coarse(surface, 300)
    assert len(mesh.points) > 1500
    assert len(kept) < 300 + sum(map(len, loops))
    points = mesh.points[kept]

    def area(points, corners):
        a, b, c = points[corners].transpose(1, 2, 0)
        return 0.5 * np.abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))

    whole = area(mesh.points, surface.triangles).sum()
    assert area(points, triangles).sum() == pytest.approx(whole, rel=0.1)
    assert area(points, triangles).min() >= 0.0
    assert len({tuple(sorted(triangle)) for triangle in triangles.tolist()}) == len(triangles)
    assert [np.ptp(points[loop], axis=0) for loop in loops] == [
        pytest.approx(np.ptp(mesh.points[list(loop)], axis=0), rel=0.02) for loop in mesh.loops
    ]


@pytest.mark.slow
def test_a_long_run_of_a_fine_mesh_is_a_small_page(tmp_path):
    mesh = fm.meshes.rectangle(0.2, 0.05, 60, 16)
    rubber = fm.Material(young=1e7, density=1000.0, poisson=0.3)
    plate = fm.PlaneBody("plate", mesh, pins=("left",), thickness=0.01, material=rubber)
    wall = fm.Fixed("wall", fm.GROUND, plate, (0.0, 0.025))
    mechanism = fm.Mechanism("plate", [fm.Reduced(plate, modes=12), wall], gravity=(0.0, -9.81))
    sol = fm.simulate(mechanism, t_end=0.5, step=2.5e-4, save=1000)
    assert len(mesh.points) > 2 * MOST_POINTS
    assert fm.report(sol, tmp_path / "plate.html").stat().st_size < 10e6
