"""Contact of outlines at the joins of their pieces: curvature there, a disc at the bottom of a round hollow."""

import math
from itertools import pairwise

import numpy as np
import pytest

import flexmb as fm
from flexmb import places
from flexmb.kernels import GAP_SIZE

LAW = fm.KelvinVoigt(1e6, 100.0, ramp=1e-7)
RADIUS, HOLLOW, G = 0.1, 0.5, 9.81
BOTTOM = math.sqrt(G / (HOLLOW - RADIUS)) / (2.0 * math.pi)  # frequency of a disc that does not turn [Hz]


def disc(centre):
    return fm.cams.Outline(((centre[0] + RADIUS, centre[1]), (centre[0] - RADIUS, centre[1])), bulges=(1.0, 1.0))


def joined(right, left, bend=0.0):
    """Two pieces of the curvatures `right` and `left` [1/m] that meet at the origin, outward normal +Y."""

    def end(curvature, way):
        if curvature == 0.0:
            return -way, 0.0
        return -math.sin(curvature * way) / curvature, (math.cos(curvature * way) - 1.0) / curvature

    c, s, (x, y) = math.cos(bend), math.sin(bend), end(left, 0.3)
    points = (end(right, -0.3), (0.0, 0.0), (c * x - s * y, s * x + c * y), (-1.0, -1.0), (1.0, -1.0))
    return fm.cams.Outline(points, tuple(math.tan(0.075 * k) for k in (right, left)) + (0.0,) * 3)


def bowl(*angles):
    """A hollow of arcs between directions from its centre [rad]."""
    points = [(HOLLOW * math.cos(a), HOLLOW * math.sin(a)) for a in angles]
    bulges = [math.tan(0.25 * (b - a)) for a, b in pairwise(angles)]
    return fm.cams.Outline((*points, (1.0, -1.0), (-1.0, -1.0)), (*bulges, 0.0, 0.0, 0.0))


SLOT = fm.cams.Outline(  # an open slot with a round end, 2 x 0.15 wide
    ((-0.15, 0.5), (-0.15, 0.0), (0.15, 0.0), (0.15, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5), (-0.5, 0.5)),
    (0.0, 1.0, *(0.0,) * 6),
)
DOME = fm.cams.Outline(((HOLLOW, 0.0), (-HOLLOW, 0.0)), bulges=(1.0, 1.0))
# outline, its join, direction of the outward normal there [rad], curvatures before and behind the join (on the right
# and on the left of one who looks along the normal) [1/m]
JOINS = {
    "hollow": (joined(-2.0, -2.0), (0.0, 0.0), 0.5 * math.pi, (-2.0, -2.0)),
    "two hollow": (joined(-2.0, -3.0), (0.0, 0.0), 0.5 * math.pi, (-2.0, -3.0)),
    "convex": (joined(2.0, 5.0), (0.0, 0.0), 0.5 * math.pi, (2.0, 5.0)),
    "fillet": (joined(0.0, -4.0), (0.0, 0.0), 0.5 * math.pi, (0.0, -4.0)),
    "s": (joined(-3.0, 2.0), (0.0, 0.0), 0.5 * math.pi, (-3.0, 2.0)),
    "nearly smooth": (joined(-2.0, -3.0, 5e-10), (0.0, 0.0), 0.5 * math.pi, (-2.0, -3.0)),
    "bottom of a semicircle": (bowl(math.pi, 2.0 * math.pi), (0.0, -HOLLOW), 0.5 * math.pi, (-2.0, -2.0)),
    "bottom of a slot": (SLOT, (0.0, -0.15), 0.5 * math.pi, (-1.0 / 0.15, -1.0 / 0.15)),
    "wall of a slot": (SLOT, (0.15, 0.0), math.pi, (0.0, -1.0 / 0.15)),
    "top of a disc": (DOME, (0.0, HOLLOW), 0.5 * math.pi, (2.0, 2.0)),
}


def contacts(cls, outline, centre):
    """Outputs of the gap kernels of a disc around a place, and the mechanism; function of a shift of the disc."""
    body = fm.RigidBody("disc", at=centre, mass=1.0, inertia=1.0)
    other = fm.cams.CircularCurve(centre, RADIUS) if cls is fm.cams.OutlineContact else disc(centre)
    part = cls("pair", fm.GROUND, outline, body, other, normal=LAW)
    mech = fm.Mechanism("pair", [body, part])
    pieces = [(piece.gap.dispatcher, np.array(piece.p)) for piece in part.contributions(mech)]

    def every(x, y):
        found, q = [], np.array([0.0, 0.0, 0.0, x, y, 0.0])
        for kernel, p in pieces:
            out = np.zeros(GAP_SIZE)
            kernel(p, q, np.zeros(6), out)
            found.append(out)
        return found

    at = lambda x, y: min(every(x, y), key=lambda one: one[places.GAP])  # noqa: E731
    at.every = every
    return at


@pytest.mark.parametrize("cls", [fm.cams.OutlineContact, fm.cams.OutlineOnOutline])
@pytest.mark.parametrize("join", JOINS)
def test_curvature_at_and_beside_a_join_is_that_of_its_pieces(join, cls):
    """Turn of the normal per way of the centre, k/(1 + k r), from the kernel and from differences of its normals."""
    outline, (x, y), angle, curvatures = JOINS[join]
    n, depth = np.array((math.cos(angle), math.sin(angle))), 1e-6
    along = np.array((n[1], -n[0]))
    away = RADIUS - depth
    at = contacts(cls, outline, (x + (RADIUS + 1e-3) * n[0], y + (RADIUS + 1e-3) * n[1]))
    for way in (0.0, *(sign * size for size in (1e-17, 1e-12, 1e-10, 1e-9, 1e-8, 1e-5) for sign in (-1.0, 1.0))):
        here = (x, y) + away * n + way * along
        out = at(*here)
        assert out[places.GAP] == pytest.approx(-depth, abs=1e-9)
        slopes = np.array([[out[places.NORMAL_X_Q + j], out[places.NORMAL_Y_Q + j]] for j in (3, 4)])
        turn = -along @ slopes @ along
        expected = [k / (1.0 + k * away) for k in curvatures]
        if abs(way) > (1e-9 if join == "nearly smooth" else 1e-12):  # which of both is nearer
            expected = [expected[0] if way > 0.0 else expected[1]] * 2
        assert min(abs(turn - one) for one in expected) < 1e-5
        step = math.copysign(1e-6, way)
        there = at(*(here + step * along))
        change = -along @ [there[k] - out[k] for k in (places.NORMAL_X, places.NORMAL_Y)] / step
        assert change == pytest.approx(expected[0 if step > 0.0 else 1], abs=2e-5 + (1e-2 if abs(way) < 1e-7 else 0.0))


def test_corners_stay_corners():
    """The normal on a corner turns about it; a hollow corner has two sides, each straight, and none in between."""
    at = contacts(fm.cams.OutlineContact, joined(0.0, 0.0, 0.3), (0.0, 0.11))
    for direction, turn in ((0.5 * math.pi + 0.1, 1.0 / 0.0999), (0.5 * math.pi - 0.01, 0.0)):
        out = at(0.0999 * math.cos(direction), 0.0999 * math.sin(direction))
        slopes = np.array([[out[places.NORMAL_X_Q + j], out[places.NORMAL_Y_Q + j]] for j in (3, 4)])
        along = np.array((math.sin(direction), -math.cos(direction)))
        assert -along @ slopes @ along == pytest.approx(turn, abs=1e-9)
    lift = RADIUS / math.cos(0.15)
    at = contacts(fm.cams.OutlineContact, joined(0.0, 0.0, -0.3), (0.0, 0.11))
    for way in (-1e-9, 0.0, 1e-9):
        out = at(lift * math.sin(0.15) + way, lift * math.cos(0.15))
        assert out[places.GAP] == pytest.approx(0.0, abs=1e-9)
        assert abs(out[places.NORMAL_X_Q + 3]) < 1e-12


ELL = fm.cams.Outline(((0.0, 0.0), (1.0, 0.0), (1.0, 0.3), (0.3, 0.3), (0.3, 1.0), (0.0, 1.0)))


@pytest.mark.parametrize("way", [-0.01, -1e-3, -1e-4, -1e-6, 0.0, 1e-6, 1e-4, 1e-3, 0.01])
def test_one_side_carries_where_two_chains_meet_away_from_the_hollow_corner(way):
    """An L has one hollow corner; both its chains end at a point where a disc had twice its force, 1e-5 m deep."""
    far = max(ELL.points, key=lambda point: math.dist(point, (0.3, 0.3)))
    inwards = np.sign(np.array((0.5, 0.5)) - far)
    depth, along = 1e-5, np.abs(way)
    for axis in range(2):  # on both edges that meet there, and in the sector of the corner
        centre = np.array(far)
        if way >= 0.0:
            centre[axis] += along * inwards[axis]
            centre[1 - axis] -= (RADIUS - depth) * inwards[1 - axis]
        else:
            angle = 0.25 * math.pi * (1.0 - along)
            turned = np.array((math.cos(angle), math.sin(angle)))[:: 1 - 2 * axis]
            centre -= (RADIUS - depth) * inwards * turned
        gaps = [out[places.GAP] for out in contacts(fm.cams.OutlineContact, ELL, (2.0, 2.0)).every(*centre)]
        assert min(gaps) == pytest.approx(-depth, rel=1e-6)
        assert max(gaps) > 0.0


@pytest.mark.slow
@pytest.mark.parametrize(
    "start", [pytest.param(0.0, marks=pytest.mark.slow), pytest.param(0.001, marks=pytest.mark.slow), 0.01, 0.05]
)
@pytest.mark.parametrize("cls", [fm.cams.OutlineContact, fm.cams.OutlineOnOutline])
def test_a_disc_rests_at_the_bottom_of_a_hollow(cls, start):
    """Statics finds the bottom, where two arcs join, and modes the frequency of a pendulum; it was a vertex."""
    way = HOLLOW - RADIUS
    centre = (way * math.sin(start / way), -way * math.cos(start / way))
    body = fm.RigidBody("disc", at=centre, mass=3.0, inertia=0.015)
    other = fm.cams.CircularCurve(centre, RADIUS) if cls is fm.cams.OutlineContact else disc(centre)
    rest = cls("rest", fm.GROUND, bowl(math.pi, 2.0 * math.pi), body, other, normal=LAW)
    stay = fm.TorsionSpring("stay", fm.GROUND, body, stiffness=5.0)
    mech = fm.Mechanism("bowl", [body, stay, rest], gravity=(0.0, -G))
    found = fm.static_equilibrium(mech)
    assert found["disc.x"] == pytest.approx(0.0, abs=1e-9)
    assert found.stable
    assert fm.modes(mech, at=found).frequencies[0] == pytest.approx(BOTTOM, rel=2e-4)  # 3e-5 m deep


INSIDE = (-1e-5, -1e-7, 0.0, 1e-7, 5e-6, 9e-6, 2e-5)
BESIDE = [
    pytest.param(inside, first, marks=() if (inside, first) in ((-1e-7, "disc"), (5e-6, "box")) else pytest.mark.slow)
    for first in ("box", "disc")
    for inside in INSIDE
]


@pytest.mark.quick(1)
@pytest.mark.parametrize(("inside", "first"), BESIDE)
def test_a_disc_beside_the_edge_of_a_box_rests_on_its_top(first, inside):
    """1 kg on 1e6 N/m: m g/k deep, also where the side is nearer than that; it fell through there."""
    box, centre = fm.cams.Outline(((-1.0, -1.0), (0.0, -1.0), (0.0, 0.0), (-1.0, 0.0))), (-inside, RADIUS + 1e-6)
    body = fm.RigidBody("disc", at=centre, mass=1.0, inertia=0.005)
    sides = [(fm.GROUND, box), (body, disc(centre))][:: 1 if first == "box" else -1]
    pair = fm.cams.OutlineOnOutline("pair", *sides[0], *sides[1], normal=LAW)
    guide = fm.Prismatic("guide", fm.GROUND, body, along=(0.0, 1.0))
    found = fm.static_equilibrium(fm.Mechanism("box", [body, pair, guide], gravity=(0.0, -G)))
    near = RADIUS - G / 1e6
    assert found["disc.y"] == pytest.approx(math.sqrt(near**2 - min(inside, 0.0) ** 2), abs=1e-7 * near)
