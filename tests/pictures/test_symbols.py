"""Symbols of springs, dampers, rods, cables, forces and wheels: where they are drawn, and how they move."""

import numpy as np
import pytest

import flexmb as fm
from flexmb.model.shape import from_json, to_json
from flexmb.results.drawing import symbols
from flexmb.show.pictures.scene import render

O, Q = (0.0, 0.0), (0.09, 0.0)


@pytest.fixture(scope="module")
def sol():
    """A gear pair, a bead in a fixed slot on a spring, an arm with a damper, two forces, a rod and a cable."""
    pinion = fm.RigidBody("pinion", at=O, mass=0.2, inertia=1e-4)
    wheel = fm.RigidBody("wheel", at=Q, mass=0.8, inertia=1e-3)
    bead = fm.bodies.PointMass("bead", at=(0.0, 0.12), mass=0.1)
    arm = fm.RigidLink("arm", (0.2, 0.0), (0.2, 0.1), mass=0.2, inertia=2e-4)
    bob = fm.bodies.PointMass("bob", at=(0.26, 0.1), mass=0.1)
    rope = fm.couplings.Cable("rope", fm.GROUND, bob, at=(0.3, 0.14), to=bob.at, normal=fm.KelvinVoigt(1e4, 1.0, 1e-6))
    return fm.simulate(fm.Mechanism("symbols", [
        pinion, wheel, bead, arm, bob, rope, fm.Revolute("O", fm.GROUND, pinion, at=O),
        fm.Revolute("Q", fm.GROUND, wheel, at=Q), fm.Gear("mesh", pinion, wheel, teeth=(20, 40)),
        fm.PinSlot("slot", fm.GROUND, bead, at=bead.at), fm.Revolute("P", fm.GROUND, arm, at=(0.2, 0.0)),
        fm.SpringDamper("spring", fm.GROUND, bead, at=(-0.1, 0.12), to=bead.at, stiffness=30.0, free_length=0.15),
        fm.SpringDamper("dashpot", wheel, arm, at=(0.09, 0.03), to=(0.2, 0.08), stiffness=0.0, damping=0.2),
        fm.Force("push", arm, at=(0.2, 0.1), force=(0.5, 0.0)),
        fm.Force("jet", arm, at=(0.2, 0.05), force=(-1.0, 0.0), follower=True),
        fm.couplings.Distance("rod", arm, bob, at=(0.2, 0.1), to=bob.at),
        fm.Drive("motor", "O", fm.ConstantSpeed(10.0)),
    ], gravity=(0.0, -9.81)), t_end=0.3, save=60)  # fmt: skip


def drawn(sol, part, size=1.0):
    found = [line for line in symbols(sol, np.arange(len(sol.time)), size) if line.part == part]
    return found if len(found) > 1 else found[0]


def point(sol, body, offset=(0.0, 0.0)):
    """A point of a body over time, by its own signals."""
    x, y, theta = (sol[f"{body}.{axis}"].values for axis in ("x", "y", "theta"))
    c, s = np.cos(theta), np.sin(theta)
    return np.stack([x + c * offset[0] - s * offset[1], y + s * offset[0] + c * offset[1]], axis=-1)


def test_lines_join_their_points_at_every_instant(sol):
    for part, last in (("spring", point(sol, "bead")), ("rod", point(sol, "bob")), ("rope", point(sol, "bob"))):
        assert drawn(sol, part).points[:, -1] == pytest.approx(last, abs=1e-12)
    assert drawn(sol, "spring").points[:, 0] == pytest.approx(np.tile([-0.1, 0.12], (len(sol.time), 1)))
    dashpot = drawn(sol, "dashpot")
    assert dashpot.kind == "damper"
    assert dashpot.points[:, 0] == pytest.approx(point(sol, "wheel", (0.0, 0.03)), abs=1e-12)
    assert dashpot.points[:, -1] == pytest.approx(point(sol, "arm", (0.03, 0.0)), abs=1e-12)


def test_a_spring_zig_zags_about_its_line(sol):
    """Teeth of equal height on both sides; the height follows the picture, the length the motion."""
    points = drawn(sol, "spring", size=2.0).points
    height = points[:, :, 1] - 0.12
    assert height.max(axis=1) == pytest.approx(0.04)
    assert height.min(axis=1) == pytest.approx(-0.04)
    assert np.all(np.diff(points[:, :, 0], axis=1) >= -1e-12)


def test_arrows_end_in_their_points(sol):
    push, jet = drawn(sol, "push"), drawn(sol, "jet")
    tip = point(sol, "arm", (0.05, 0.0))
    assert push.points[:, 1] == pytest.approx(tip, abs=1e-12)
    assert push.points[:, 0] == pytest.approx(tip - [0.14, 0.0], abs=1e-12)  # a dead force keeps its direction
    shaft = jet.points[:, 1] - jet.points[:, 0]
    turned = sol["arm.theta"].values - 0.5 * np.pi
    assert shaft == pytest.approx(-0.14 * np.stack([np.cos(turned), np.sin(turned)], axis=-1), abs=1e-12)


def test_pitch_circles_touch_and_roll(sol):
    first, second = drawn(sol, "mesh")
    for circle, body, radius in ((first, "pinion", 0.03), (second, "wheel", 0.06)):
        assert np.hypot(*np.moveaxis(circle.points[:, 1:] - point(sol, body)[:, None], -1, 0)) == pytest.approx(radius)
    spoke = second.points[:, 1] - second.points[:, 0]
    assert np.unwrap(np.arctan2(spoke[:, 1], spoke[:, 0])) == pytest.approx(-5.0 * sol.time, abs=1e-9)


def test_a_pin_is_drawn_in_its_slot(sol):
    figure = render(sol, [0.0, 0.2])
    at = float(np.interp(0.2, sol.time, sol["bead.x"].values))
    assert at > 0.01
    pins = [line.get_xydata()[0] for line in figure.axes[1].lines if line.get_marker() == "o"]
    assert min(np.hypot(*(pin - [at, 0.12])) for pin in pins) < 1e-9


def test_symbols_are_in_the_picture(sol):
    names = {line.get_gid() for line in render(sol, [0.1]).axes[0].lines if line.get_gid()}
    wanted = {
        "spring spring",
        "damper dashpot",
        "rod rod",
        "cable rope",
        "force push",
        "force jet",
        "pitch circle mesh",
    }
    assert wanted <= names


@pytest.mark.slow
def test_pictures_of_a_run_have_one_size_and_one_frame(sol):
    pictures = [render(sol, [t]) for t in (0.0, 0.15, 0.3)]
    assert len({tuple(picture.get_size_inches()) for picture in pictures}) == 1
    assert len({(picture.axes[0].get_xlim(), picture.axes[0].get_ylim()) for picture in pictures}) == 1
    assert sum(ax.get_visible() for ax in render(sol, [0.1, 0.1, 0.1]).axes) == 3


def test_shapes_are_written_and_read_back(sol):
    assert from_json(to_json(sol.shapes)) == tuple(sol.shapes)
