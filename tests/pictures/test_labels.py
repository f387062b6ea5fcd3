"""Names of joints never overlap, in the reference configurations of all ready mechanisms and of the examples."""

import ast
import runpy
from itertools import combinations
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from andrews import andrews
from cases import slow_where
from published import n_four_bar

import flexmb as fm
from flexmb.errors import InputError
from flexmb.show.pictures.pose import boxes, place_names, with_arms
from flexmb.show.pictures.scene import reference_solution, scene_of

EXAMPLES = Path(__file__).parents[2] / "examples"


def ready():
    """Ready mechanisms of all kinds."""
    make = fm.mechanisms
    return {
        "four_bar": make.four_bar(),
        "slider_crank": make.slider_crank(clearance=1e-4, flexible=True),
        "nine_bar": make.nine_bar(clearance=5e-4),
        "nine_bar_flexible": make.nine_bar(clearance=5e-4, flexible=True),
        "n_four_bar": n_four_bar(),
        "andrews": andrews(),
    }


class Declared(Exception):
    """End of an example before its first run or flow."""

    def __init__(self, mechanism):
        super().__init__()
        self.mechanism = mechanism


def of_example(path, monkeypatch):
    """The first mechanism that an example simulates, loads or examines, or from which a search begins."""

    def stop(mechanism, *args, **keywords):
        raise Declared(mechanism)

    def stop_search(make, bounds, *args, start=None, **keywords):
        raise Declared(make(**{name: sum(ends) / 2.0 for name, ends in bounds.items()} | (start or {})))

    for name in ("simulate", "steps", "static_equilibrium"):
        monkeypatch.setattr(fm, name, stop)
    for name in ("fit", "optimise"):
        monkeypatch.setattr(fm.design, name, stop_search)
    monkeypatch.setattr(fm.chaos, "MechanismFlow", stop)
    try:
        runpy.run_path(str(path), run_name="__main__")
    except Declared as found:
        return found.mechanism
    return None


def overlapping(figure):
    """Pairs of names of the first panel whose boxes overlap, and names outside the axes."""
    ax = figure.axes[0]
    names = [text for text in ax.texts if text.get_text()]
    figure.draw_without_rendering()
    found = boxes(names)
    room = ax.get_window_extent()
    pairs = [
        (a.get_text(), b.get_text())
        for (a, one), (b, two) in combinations(zip(names, found, strict=True), 2)
        if one.overlaps(two)
    ]
    inside = [room.x0 <= box.x0 and box.x1 <= room.x1 and room.y0 <= box.y0 and box.y1 <= room.y1 for box in found]
    return pairs, [name.get_text() for name, is_in in zip(names, inside, strict=True) if not is_in], len(names)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=pytest.mark.slow) if n in ("andrews", "nine_bar", "n_four_bar", "four_bar") else n
        for n in sorted(ready())
    ],
)
@pytest.mark.parametrize("lengths", [pytest.param(False, marks=pytest.mark.slow), True])
def test_names_in_ready_mechanisms(name, lengths):
    pairs, outside, count = overlapping(ready()[name].plot(lengths=lengths))
    assert count > 2
    assert not pairs
    assert not outside


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    "path",
    slow_where(lambda n: n.stem[0] > "f", sorted(EXAMPLES.glob("*.py"))),
    ids=lambda path: path.stem,
)
def test_names_in_examples(path, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", [str(path)])
    if "fm.Mechanism" not in ast.unparse(ast.parse(path.read_text(encoding="utf-8"))):
        pytest.skip("declares no mechanism of its own")
    mechanism = of_example(path, monkeypatch)
    assert mechanism is not None
    pairs, outside, _ = overlapping(mechanism.plot())
    assert not pairs
    assert not outside


def test_the_nine_bar_names_o1_and_p1_apart():
    """They lie 45 mm apart in a picture of a metre and a half."""
    figure = ready()["nine_bar_flexible"].plot()
    found = {text.get_text(): text for text in figure.axes[0].texts}
    one, two = boxes([found["O1"], found["P1"]])
    assert not one.overlaps(two)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["nine_bar", "nine_bar_flexible", "slider_crank"])
def test_lengths_hide_neither_rings_nor_triangles_nor_links(name):
    figure = ready()[name].plot(lengths=True)
    ax = figure.axes[0]
    figure.draw_without_rendering()
    found = boxes([text for text in ax.texts if text.get_text().endswith(" m")])
    ground = [line for line in ax.lines if line.get_marker() == 6]
    assert len(found) > 1
    assert ground
    for line in ground:
        foot = ax.transData.transform(line.get_xydata()[0]) - (0.0, 4.0 * figure.dpi / 72.0)
        assert not any(box.contains(*foot) for box in found)
    rings = [patch.get_window_extent() for patch in ax.patches if hasattr(patch, "radius")]
    assert rings
    assert not any(box.overlaps(ring) for box in found for ring in rings)


def test_a_crowd_of_points_is_named_without_overlaps():
    from matplotlib.figure import Figure

    rng = np.random.default_rng(3)
    figure = Figure(figsize=(6.0, 5.0), layout="constrained")
    ax = figure.subplots()
    points = [(0.5 + 0.02 * rng.standard_normal(2), f"joint{k}") for k in range(12)]
    ax.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    names = place_names(ax, points, [])
    for one, two in combinations(boxes(names), 2):
        assert not one.overlaps(two)


def test_the_picture_is_written_and_shows_the_reference_configuration(tmp_path):
    mech = ready()["four_bar"]
    figure = mech.plot(tmp_path / "out" / "a.png", size=(5.0, 4.0))
    assert matplotlib.image.imread(tmp_path / "out" / "a.png").shape == (600, 750, 4)
    ax = figure.axes[0]
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_aspect()) == ("x [m]", "y [m]", 1.0)
    at = {tuple(np.round(line.get_xydata()[0], 9)) for line in ax.lines if line.get_marker() == "o"}
    joints = [part for part in mech.parts if isinstance(part, fm.Revolute)]
    assert {tuple(np.round(joint.at, 9)) for joint in joints} <= at


def test_lengths_are_written_beside_straight_links():
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.3, 0.4), mass=1.0, inertia=0.1)
    mech = fm.Mechanism("one", [crank, fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0))])
    texts = {text.get_text() for text in mech.plot(lengths=True).axes[0].texts}
    assert texts == {"O", "0.5 m"}


def test_a_mechanism_without_bodies_is_refused():
    with pytest.raises(InputError, match="no bodies to draw"):
        fm.Mechanism("empty", []).plot()


def test_a_pin_beside_its_centre_hangs_on_an_arm():
    """The crank of a Geneva drive is a pin circle beside its axis; the wheel surrounds its own."""
    crank = fm.RigidBody("crank", at=(0.0, 0.0), mass=0.2, inertia=1e-4)
    wheel = fm.RigidBody("wheel", at=(0.1, 0.0), mass=0.5, inertia=5e-4)
    law = fm.KelvinVoigt(1e6, 1e2, 1e-6)
    square = fm.cams.Outline([(0.08, -0.02), (0.12, -0.02), (0.12, 0.02), (0.08, 0.02)])
    pin = fm.cams.OutlineContact("pin", wheel, square, crank, fm.cams.CircularCurve((0.05, 0.01), 0.004), normal=law)
    joints = [fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)), fm.Revolute("Q", fm.GROUND, wheel, at=(0.1, 0.0))]
    scene = scene_of(reference_solution(fm.Mechanism("geneva", [crank, wheel, *joints, pin])), np.array([0]))
    straight = [line for line in with_arms(scene) if line.points.shape[1] == 2]
    assert [line.part for line in straight] == ["crank"]
    np.testing.assert_allclose(straight[0].points[0], [[0.0, 0.0], [0.05, 0.01]], atol=1e-4)


@pytest.mark.parametrize("size", ["big", (3.0,), 5.0, (1e9, 4.0), (-1.0, 4.0), ("a", "b")])
def test_sizes_that_are_none(size):
    with pytest.raises(InputError, match="plot: size"):
        fm.mechanisms.four_bar().plot(size=size)
