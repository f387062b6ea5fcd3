"""Figures: what is drawn, how it is labelled, that no display and no global state is needed, bad input."""

import runpy
import subprocess
import sys
import warnings
from dataclasses import replace
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import FileFormatError, InputError
from flexmb.model.shape import RigidShape
from flexmb.model.signal import Signal
from flexmb.results.solution import Peaks
from flexmb.results.vtk import write_vtk
from flexmb.show.pictures.scene import render
from flexmb.show.pictures.signals import plot
from flexmb.show.pictures.style import prefixed, unit_text
from flexmb.show.pictures.window import screenshot_vtk

handmade = runpy.run_path(str(Path(__file__).parents[1] / "handmade.py"))
solution = handmade["solution"]


@pytest.fixture(scope="module")
def sol():
    return solution()


def test_names_in_any_script_are_drawn_or_escaped(sol):
    """No font has the last private character, and each machine has one with Greek and Cyrillic letters."""
    title = "\U0010fffd Кривошип ωψ"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figure = plot(sol, "crank.ax", title=title)
        figure.draw_without_rendering()
        assert figure.get_suptitle() == "\\U0010fffd Кривошип ωψ"
        figure.draw_without_rendering()
        assert figure.get_suptitle() == "\\U0010fffd Кривошип ωψ"
        part = fm.RigidBody("曲柄 🦾", (0.0, 0.0), 1.0, 0.1)
        fm.Mechanism("机构", [part, fm.Revolute("轴", fm.GROUND, part, at=(0.1, 0.0))]).plot().draw_without_rendering()


def test_a_font_of_the_machine_is_found():
    from matplotlib import font_manager

    from flexmb.show.pictures import style as glyphs

    fonts = {font.name: font.fname for font in font_manager.fontManager.ttflist}
    glyphs._family.cache_clear()
    assert glyphs._family(fonts["cmr10"], "ω") not in ("", None, "cmr10")
    assert glyphs._family(fonts["DejaVu Sans"], "ω") == ""
    glyphs._family.cache_clear()


def test_a_solution_without_rows_is_refused(sol):
    empty = replace(sol, time=np.zeros(0), values=np.zeros((0, len(sol.names))))
    with pytest.raises(InputError, match="plot: the solution has no saved instants"):
        plot(empty, "crank.ax")


def test_one_panel_a_name(sol):
    figure = plot(sol, ["crank.ax", "arm.end.y", "P.mode"])
    assert [ax.get_ylabel() for ax in figure.axes] == ["crank.ax\n[m/s²]", "arm.end.y\n[m]", "P.mode"]
    assert [ax.get_xlabel() for ax in figure.axes] == ["", "", "time [s]"]
    (curve,) = figure.axes[0].lines
    np.testing.assert_array_equal(curve.get_xdata(), sol.time)
    np.testing.assert_array_equal(curve.get_ydata(), sol["crank.ax"].values)
    assert figure.get_suptitle() == "handmade"


def test_a_list_shares_a_panel_and_has_a_legend(sol):
    figure = plot(sol, [["arm.start.x", "arm.end.x"], "crank.theta"], title="Both ends")
    first, second = figure.axes
    assert [text.get_text() for text in first.get_legend().get_texts()] == ["arm.start.x", "arm.end.x"]
    assert first.get_ylabel() == "[m]"
    assert second.get_legend() is None
    assert figure.get_suptitle() == "Both ends"


def test_one_signal_over_another(sol):
    (ax,) = plot(sol, "P.ey", x="P.ex").axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("P.ex [mm]", "P.ey\n[mm]")
    assert ax.get_aspect() == 1.0
    np.testing.assert_array_equal(ax.lines[0].get_xdata(), sol["P.ex"].values)
    (other,) = plot(sol, "P.normal_force", x="P.ex").axes
    assert other.get_aspect() == "auto"


def test_a_single_instant_can_be_plotted():
    plot(solution(n=1), "crank.x").canvas.draw()


@pytest.mark.parametrize(
    ("units", "text"), [("m", "m"), ("m/s2", "m/s²"), ("kg m^2", "kg m²"), ("1/m", "1/m"), ("", "")]
)
def test_exponents_are_raised(units, text):
    assert unit_text(units) == text


@pytest.mark.parametrize(
    ("names", "keywords", "words"),
    [
        (["crank.axx"], {}, "Did you mean 'crank.ax'"),
        (["crank.ax"], {"x": "crank.angel"}, "no signal 'crank.angel'"),
        ([], {}, "names is empty"),
        ([[]], {}, "names is empty"),
        ([["crank.x", "crank.ax"]], {}, "different units, 'm' and 'm/s2'"),
    ],
)
def test_names_that_cannot_be_plotted(sol, names, keywords, words):
    with pytest.raises(InputError, match=words):
        plot(sol, names, **keywords)


@pytest.mark.slow
def test_pictures_leave_pyplot_alone():
    # in a process of its own: other tests may have brought pyplot in
    code = (
        "import runpy, sys; sol = runpy.run_path(sys.argv[1])['solution'](n=5);"
        "from flexmb.show.pictures.signals import plot; from flexmb.show.pictures.scene import render;"
        "plot(sol, 'crank.x').canvas.draw(); render(sol).canvas.draw();"
        "assert 'matplotlib.pyplot' not in sys.modules"
    )
    helper = Path(__file__).parents[1] / "handmade.py"
    root = Path(__file__).parents[2]
    command = [sys.executable, "-c", code, str(helper)]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_the_mechanism_at_six_instants(sol):
    figure = render(sol)
    shown = [ax for ax in figure.axes if ax.get_visible()]
    assert [ax.get_title() for ax in shown] == [f"t = {t:g} s" for t in (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)]
    assert {ax.get_aspect() for ax in shown} == {1.0}
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["crank", "arm", "joint with clearance"]
    assert [text.get_text() for text in shown[0].texts] == ["O", "P"]
    assert {ax.get_ylabel() for ax in shown} == {"y [m]", ""}


def coloured(ax):
    """Line ends of the shown pose: everything that is neither grey nor a marker."""
    lines = [line for line in ax.lines if line.get_color() not in {"0.85", "0.45"} and line.get_linestyle() != "None"]
    return [np.column_stack(line.get_data()) for line in lines]


def test_poses_are_those_of_the_chosen_instants(sol):
    figure = render(sol, [0.25, 0.75])
    first, second = figure.axes
    crank, *beam = coloured(first)
    np.testing.assert_allclose(crank, [[0.0, 0.0], [0.0, 0.2]], atol=1e-14)
    np.testing.assert_array_equal(beam[-1][-1], [sol["arm.end.x"][25], sol["arm.end.y"][25]])
    np.testing.assert_allclose(coloured(second)[0], [[0.0, 0.0], [0.0, -0.2]], atol=1e-14)


def test_earlier_poses_are_grey_and_behind(sol):
    first, second = render(sol, [0.25, 0.75]).axes
    assert not [line for line in first.lines if line.get_color() == "0.85"]
    grey = [line for line in second.lines if line.get_color() == "0.85"]
    assert grey
    front = min(line.get_zorder() for line in second.lines if line.get_color() != "0.85")
    assert max(line.get_zorder() for line in grey) < front


def test_a_body_without_extent_is_a_square(sol):
    shapes = (RigidShape("crank", "", (((0.0, 0.0), (0.0, 0.0)),)), *sol.shapes[1:])
    ax = render(solution(shapes=shapes), [0.0]).axes[0]
    assert "s" in {line.get_marker() for line in ax.lines}


@pytest.mark.slow
@pytest.mark.parametrize(
    "count",
    [
        1,
        pytest.param(2, marks=pytest.mark.slow),
        pytest.param(5, marks=pytest.mark.slow),
        pytest.param(9, marks=pytest.mark.slow),
        14,
    ],
)
def test_the_legend_lies_in_the_picture(sol, count):
    bodies = tuple(RigidShape("crank", "", (((0.0, 0.0), (0.1 * k, 0.0)),)) for k in range(1, 3))
    names = [f"body{'x' * (k % 7)}{k}" for k in range(count)]
    shapes = (*bodies, *(replace(bodies[0], part=name) for name in names))
    values = {f"{name}.{axis}": 0.0 for name in names for axis in ("x", "y", "theta")}
    more = solution(shapes=shapes)
    wide = np.column_stack([more.values, np.zeros((len(more.time), len(values)))])
    peaks = Peaks(np.abs(wide).max(axis=0), np.zeros(wide.shape[1]))
    signals = (*more.signals, *(Signal(name, "m") for name in values))
    figure = render(replace(more, values=wide, signals=signals, peaks=peaks), np.linspace(0.0, 1.0, 4))
    figure.draw_without_rendering()
    (legend,) = figure.legends
    box, page = legend.get_window_extent(), figure.bbox
    assert page.x0 <= box.x0
    assert box.x1 <= page.x1
    assert box.y0 >= page.y0


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    "n",
    [
        1,
        2,
        3,
        pytest.param(4, marks=pytest.mark.slow),
        pytest.param(5, marks=pytest.mark.slow),
        pytest.param(7, marks=pytest.mark.slow),
    ],
)
def test_any_number_of_instants(sol, n):
    figure = render(sol, np.linspace(0.1, 0.9, n))
    assert sum(ax.get_visible() for ax in figure.axes) == n


@pytest.mark.slow
def test_the_picture_is_written(sol, tmp_path):
    path = tmp_path / "out" / "a.png"
    render(sol, path=path, size=(6.0, 4.0))
    assert matplotlib.image.imread(path).shape == (600, 900, 4)


@pytest.mark.parametrize(
    ("changes", "keywords", "words"),
    [
        ({}, {"times": [0.5, 1.5]}, r"times\[1\] is 1.5 s; it must lie between 0 and 1"),
        ({}, {"times": []}, "times is empty"),
        ({}, {"size": (0.0, 4.0)}, r"size\[0\] is 0 inch"),
        ({"shapes": ()}, {}, "no shapes"),
        ({"n": 0, "peaks": (np.zeros(17), np.zeros(17))}, {}, "no saved instants"),
    ],
)
def test_what_cannot_be_rendered(changes, keywords, words):
    with pytest.raises(InputError, match=words):
        render(solution(**changes), **keywords)


@pytest.mark.parametrize("where", ["file.txt/a.png", "a.nonsense"])
def test_a_picture_that_cannot_be_written(sol, tmp_path, where):
    (tmp_path / "file.txt").write_text("text")
    with pytest.raises(InputError, match=f"{where}.*cannot be written"):
        render(sol, [0.0], path=tmp_path / where)


def test_screenshots_of_missing_and_foreign_files(tmp_path):
    with pytest.raises(FileFormatError, match=r"none\.pvd.*no such file"):
        screenshot_vtk(tmp_path / "none.pvd", tmp_path / "a.png")
    text = tmp_path / "text.xyzzy"
    text.write_text("text")
    with pytest.raises(FileFormatError, match=r"text\.xyzzy.*no file of VTK"):
        screenshot_vtk(text, tmp_path / "a.png")


def test_screenshot_of_an_unknown_field(tmp_path):
    pvd = write_vtk(solution(), tmp_path / "a.pvd", frames=2)
    with pytest.raises(InputError, match="Did you mean 'bending_moment'"):
        screenshot_vtk(pvd, tmp_path / "a.png", field="bending_momentum")


@pytest.mark.slow
def test_screenshot(tmp_path):
    pvd = write_vtk(solution(), tmp_path / "a.pvd", frames=5)
    # VTK ends the whole process where it finds no way to draw, so it is tried in one of its own
    code = (
        "import sys; from flexmb.show.pictures.window import screenshot_vtk;"
        "screenshot_vtk(sys.argv[1], sys.argv[2], time=0.25)"
    )
    target = tmp_path / "out" / "a.png"
    command = [sys.executable, "-c", code, str(pvd), str(target)]
    done = subprocess.run(command, cwd=Path(__file__).parents[2], capture_output=True, timeout=120, check=False)
    if done.returncode < 0 or (b"OpenGL" in done.stderr and not target.exists()):
        pytest.skip("VTK cannot draw on this machine")
    assert done.returncode == 0, done.stderr.decode()
    picture = matplotlib.image.imread(target)
    assert picture.shape[:2] == (800, 1200)
    assert (picture[..., :3].min(axis=-1) < 0.9).mean() > 0.005


def test_a_picture_makes_its_folder(tmp_path):
    figure = fm.mechanisms.four_bar().plot()
    figure.savefig(tmp_path / "new" / "folder" / "mechanism.png")
    assert (tmp_path / "new" / "folder" / "mechanism.png").stat().st_size > 1000


@pytest.mark.parametrize(
    ("units", "largest", "expected"),
    [
        ("m", 2e-4, (-6, "µm")),
        ("m", 0.02, (-3, "mm")),
        ("m", 3e5, (0, "m")),
        ("s", 0.024, (-3, "ms")),
        ("N", 12_000.0, (3, "kN")),
        ("N m", 138.0, (0, "N m")),
        ("N/m", 2.1e7, (6, "MN/m")),
        ("Pa", 2.07e11, (9, "GPa")),
        ("m/s2", 19_419.0, (0, "m/s2")),
        ("m2", 1e-6, (0, "m2")),
        ("rad", 1e-3, (0, "rad")),
        ("Nm", 1e5, (0, "Nm")),
        ("J", 0.0, (0, "J")),
        ("J", float("nan"), (0, "J")),
        ("m", 1e-12, (0, "m")),
    ],
)
def test_units_have_prefixes(units, largest, expected):
    assert prefixed(units, largest) == expected


def test_numbers_of_an_axis_are_those_of_its_unit(sol):
    """The orbit has a radius of 1 mm: tick labels in mm are those of the drawn numbers times 1000."""
    figure = plot(sol, "P.ey", x="P.ex")
    figure.draw_without_rendering()
    (ax,) = figure.axes
    for tick in ax.yaxis.get_major_ticks():
        assert float(tick.label1.get_text().replace("−", "-")) == pytest.approx(1e3 * tick.get_loc(), abs=1e-9)
