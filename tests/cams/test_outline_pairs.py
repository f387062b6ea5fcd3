"""Contact of two outlines: distances, blocks on planes, arcs after lines, a ratchet, a Geneva wheel; messages."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError, ModelError
from flexmb.kernels import GAP_SIZE
from flexmb.testing import check_part

LAW = fm.KelvinVoigt(stiffness=1e6, damping=1e3, ramp=1e-5)
SHAPE = fm.cams.Outline(
    ((-0.1, -0.1), (0.1, -0.1), (0.15, 0.05), (0.05, 0.05), (0.05, 0.2), (-0.1, 0.2)), (0.2, 0.0, 0.0, -0.1, 0.3, 0.0)
)
PAWL = ((-0.03, -0.02), (0.03, -0.02), (0.03, 0.02), (-0.03, 0.03)), (0.0, 1.0, 0.0, -0.1)


def moved(points, at, angle):
    c, s = math.cos(angle), math.sin(angle)
    return [(at[0] + c * x - s * y, at[1] + s * x + c * y) for x, y in points]


def pair(at, points=PAWL[0], bulges=PAWL[1], shape=SHAPE, **given):
    """A link with a hollow outline and a body with a pawl of a straight, a round and a hollow side."""
    one = fm.RigidLink("one", (0.0, 0.0), (0.1, 0.17), mass=0.4, inertia=2e-3, centre=0.4)
    other = fm.RigidBody("other", at=(0.3, 0.2), mass=0.8, inertia=8e-3, theta=0.3)
    own = fm.cams.Outline(moved(points, at, 0.3), bulges)
    laws = {"normal": LAW, "friction": fm.ModifiedCoulomb(0.2, v0=1e-4, v1=1e-2)} | given
    return fm.Mechanism("pair", [one, other, fm.cams.OutlineOnOutline("pair", one, shape, other, own, **laws)])


def gaps(mech, shift=(0.0, 0.0), turn=0.0, name="pair"):
    """Gaps of all contacts, for a displacement and rotation of the second body."""
    part, out, found = mech.find(name), np.zeros(GAP_SIZE), {}
    one, two = (mech.body(p.name, "").nodes()[0] for p in (part.first, part.second))
    q = np.array([one.x, one.y, one.theta, two.x + shift[0], two.y + shift[1], two.theta + turn])
    for contact in part.contributions(mech):
        contact.gap.dispatcher(np.array(contact.p), q, np.zeros(6), out)
        found[contact.name] = float(out[0])
    return found


def dense(outline, count=300):
    """Many points of an outline."""
    found, points = [], np.array(outline.points)
    for k, (a, b) in enumerate(zip(points, np.roll(points, -1, axis=0), strict=True)):
        u, centre = np.arange(count) / count, np.array(outline.centre(k))
        if outline.bulges[k] == 0.0:
            found.append(a + u[:, None] * (b - a))
            continue
        turn = math.atan2(a[1] - centre[1], a[0] - centre[0]) + 4.0 * math.atan(outline.bulges[k]) * u
        found.append(centre + abs(outline.radius(k)) * np.column_stack([np.cos(turn), np.sin(turn)]))
    return np.concatenate(found)


@pytest.mark.slow
def test_contracts():
    """Frame indifference, balance, tangents of a half-moon in the hollow side of a crescent."""
    moon = fm.cams.Outline(((0.0, 0.0), (0.1, 0.17)), (1.0, -0.4))
    report = check_part(pair((0.02, 0.12), ((-0.03, 0.0), (0.03, 0.0)), (0.0, 1.0), moon), "pair")
    assert max(check.error for check in report.checks) < 1e-7


@pytest.mark.slow
def test_distances_are_those_of_dense_points():
    mech, rng, worst, tested = pair((0.25, 0.1)), np.random.default_rng(1), 0.0, 0
    part, at = mech.find("pair"), np.array((0.3, 0.2))
    first, second = dense(part.first_outline), dense(part.second_outline)
    assert len(part.contributions(mech)) == 9  # three rounds against five corners: hollow corners make two chains
    for _ in range(25):
        shift, turn = rng.uniform(-0.12, 0.12, 2), rng.uniform(-3.0, 3.0)
        c, s = math.cos(turn), math.sin(turn)
        there = (second - at) @ np.array([[c, s], [-s, c]]) + at + shift
        least = min(gaps(mech, shift, turn).values())
        if least > 0.0:
            tested += 1
            worst = max(worst, abs(least - min(np.hypot(*(first - p).T).min() for p in there)))
    assert tested > 20
    assert worst < 2e-4  # distance of the points, 5e-4 m, over 2; their own errors are of second order


def test_overlaps_of_a_corner_an_arc_and_a_side():
    """Depths along the normal of the nearest side, for a corner in a side, an arc in a side, an arc in an arc."""
    square = fm.cams.Outline(((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)))
    for points, bulges, shift in (
        (((0.4, 0.6), (0.7, 0.8), (0.1, 0.8)), (), (0.0, -0.11)), (((0.3, 0.7), (0.5, 0.7)), (1.0, 1.0), (0.0, -0.11)),
    ):  # fmt: skip
        one = fm.RigidBody("one", at=(0.0, 0.0), mass=1.0, inertia=1.0)
        two = fm.RigidBody("two", at=(0.0, 1.0), mass=1.0, inertia=1.0)
        contact = fm.cams.OutlineOnOutline("pair", one, square, two, fm.cams.Outline(points, bulges), normal=LAW)
        found = [g for g in gaps(fm.Mechanism("pair", [one, two, contact]), shift).values() if g < 0.0]
        assert found == [pytest.approx(-0.01, abs=1e-12)]


def stadium(half, radius, centre, angle=0.0):
    """Two straight sides and two semicircles."""
    corners = ((-half, -radius), (half, -radius), (half, radius), (-half, radius))
    return fm.cams.Outline(moved(corners, centre, angle), (0.0, 1.0, 0.0, 1.0))


@pytest.mark.parametrize("swapped", [False, True])
def test_one_contact_carries_along_lines_and_arcs(swapped):
    """A semicircle slides from the straight side of another stadium over its semicircle, 1e-5 m deep all along."""
    one = fm.RigidBody("one", at=(0.0, 0.0), mass=1.0, inertia=1.0)
    two = fm.RigidBody("two", at=(0.0, 0.3), mass=1.0, inertia=1.0, theta=0.5 * math.pi)
    outlines = stadium(0.1, 0.05, (0.0, 0.0)), stadium(0.06, 0.02, (0.0, 0.3), 0.5 * math.pi)
    ends = (two, outlines[1], one, outlines[0]) if swapped else (one, outlines[0], two, outlines[1])
    mech = fm.Mechanism("pair", [one, two, fm.cams.OutlineOnOutline("pair", *ends, normal=LAW)])
    depth, reach, carriers = 1e-5, 0.07 - 1e-5, set()
    for way in np.linspace(-0.08, 0.07, 300):  # along the line, then along the arc
        angle = max(0.0, way) / reach
        centre = (0.1 + min(way, 0.0) + reach * math.sin(angle), reach * math.cos(angle))
        shift = np.array((centre[0], centre[1] - 0.24))
        found = {n: g for n, g in gaps(mech, -shift if swapped else shift).items() if g < 0.0}
        assert list(found.values()) == [pytest.approx(-depth, abs=1e-12)]
        carriers |= set(found)
    assert carriers == ({"first2", "second1"} if swapped else {"second2"})


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("turn", [0.0, 0.15, -0.1])
def test_a_tip_in_a_hollow_corner_has_one_contact(swapped, turn):
    """The tip of a lens goes over the side of an L into its hollow corner, 1e-5 m deep: the force does not jump."""
    tip = fm.cams.Outline(moved(((-0.1, 0.0), (0.1, 0.0)), (0.2, 0.2), 0.25 * math.pi + turn), (0.3, 0.3))
    angle = fm.cams.Outline(((-0.1, -0.1), (0.1, -0.1), (0.1, 0.0), (0.0, 0.0), (0.0, 0.1), (-0.1, 0.1)))
    one = fm.RigidBody("one", at=(0.0, 0.0), mass=1.0, inertia=1.0)
    two = fm.RigidBody("two", at=(0.2, 0.2), mass=1.0, inertia=1.0)
    ends = (two, tip, one, angle) if swapped else (one, angle, two, tip)
    mech = fm.Mechanism("pair", [one, two, fm.cams.OutlineOnOutline("pair", *ends, normal=LAW)])
    start, depth = np.array(tip.points[0]), 1e-5
    ways = [(x, -depth) for x in np.linspace(1e-3, 1e-6, 20)]
    ways += [(-depth * math.sin(a), -depth * math.cos(a)) for a in np.linspace(0.0, 0.5 * math.pi, 41)]
    ways += [(-depth, y) for y in np.linspace(1e-6, 1e-3, 20)]
    for way in ways:
        shift = np.array(way) - start
        found = [g for g in gaps(mech, -shift if swapped else shift).values() if g < 0.0]
        assert found == [pytest.approx(-depth, abs=1e-12)]


def test_a_stadium_rests_on_the_ends_of_its_straight_side():
    """Two contacts with half the weight each, also where it lies on lines of the ground that arcs end."""
    ground = fm.cams.Outline(((-1.0, -0.2), (1.0, -0.2), (1.0, 0.0), (-1.0, 0.0)), (0.0, 0.4, 0.0, 0.4))
    body = fm.RigidBody("body", at=(0.0, 0.05), mass=2.0, inertia=5e-3)
    contact = fm.cams.OutlineOnOutline("rest", fm.GROUND, ground, body, stadium(0.1, 0.05, (0.0, 0.05)), normal=LAW)
    sol = fm.simulate(fm.Mechanism("rest", [body, contact], gravity=(0.0, -9.81)), t_end=0.2)
    assert sol.ok, sol.status
    forces = {n: sol[f"rest.{n}.normal_force"].values[-1] for n in contact.places()}
    assert forces["second1"] == pytest.approx(9.81, rel=1e-9)
    assert forces["second2"] == pytest.approx(9.81, rel=1e-9)
    assert sum(forces.values()) == pytest.approx(2.0 * 9.81, rel=1e-9)


MU = 0.3


@pytest.mark.parametrize("angle", [0.95 * math.atan(MU), 1.05 * math.atan(MU), 0.35])
def test_a_block_on_an_inclined_plane(angle):
    """Rest below the angle of friction, else the acceleration g (sin a - mu cos a); forces of both corners."""
    half, height, mass, g = 0.05, 0.05, 2.0, 9.81
    plane = fm.cams.Outline(moved(((-1.0, -0.2), (1.0, -0.2), (1.0, 0.0), (-1.0, 0.0)), (0.0, 0.0), angle))
    own = fm.cams.Outline(moved(((-half, 0.0), (half, 0.0), (half, height), (-half, height)), (0.0, 0.0), angle))
    at = moved([(0.0, 0.5 * height)], (0.0, 0.0), angle)[0]
    block = fm.RigidBody("block", at=at, mass=mass, inertia=2e-3, theta=angle)
    rubbing = fm.ModifiedCoulomb(MU, v0=1e-7, v1=1e-5)
    contact = fm.cams.OutlineOnOutline("plane", fm.GROUND, plane, block, own, normal=LAW, friction=rubbing)
    sol = fm.simulate(fm.Mechanism("incline", [block, contact], gravity=(0.0, -g)), t_end=0.3)
    assert sol.ok, sol.status
    c, s = math.cos(angle), math.sin(angle)
    speed = -(c * sol["block.vx"].values + s * sol["block.vy"].values)
    late = sol.time > 0.1
    slope = np.polyfit(sol.time[late], speed[late], 1)[0]
    slides = math.tan(angle) > MU
    assert slope == pytest.approx(g * (s - MU * c) if slides else 0.0, rel=1e-4, abs=1e-7)
    assert slides or abs(speed[-1]) < 1e-5
    weight, pull = mass * g * c, mass * g * min(s, MU * c)
    lower, upper = (sol[f"plane.{name}.normal_force"].values[-1] for name in ("second4", "second1"))
    lever = 0.5 * height / (2.0 * half) * pull
    assert (lower, upper) == pytest.approx((0.5 * weight + lever, 0.5 * weight - lever), rel=3e-4)  # 1e-5 m deep
    assert np.abs(sol["energy.residual"].values).max() < 1e-6 * sol["energy.turned_over"].values[-1]


TEETH = 12


def ratchet(speed):
    """A wheel thrown clockwise against a torque, and a pawl of four corners under a spring."""
    points = []
    for k in range(TEETH):
        flank = math.radians(88.0) + 2.0 * math.pi * k / TEETH
        points += [(r * math.cos(a), r * math.sin(a)) for r, a in ((0.05, flank), (0.042, flank + 1e-3))]
    wheel = fm.RigidBody("wheel", at=(0.0, 0.0), mass=0.5, inertia=5e-4, velocity=(0.0, 0.0, -speed))
    pawl = fm.RigidBody("pawl", at=(-0.025, 0.049), mass=0.03, inertia=8e-6)
    lever = fm.cams.Outline(((0.0, 0.0435), (-0.002, 0.049), (-0.052, 0.056), (-0.055, 0.051)))
    law = fm.KelvinVoigt(stiffness=1e6, damping=200.0, ramp=1e-6)
    return fm.Mechanism("ratchet", [
        wheel, pawl, fm.Revolute("O", fm.GROUND, wheel, at=(0.0, 0.0)),
        fm.Revolute("P", fm.GROUND, pawl, at=(-0.05, 0.053)),
        fm.cams.OutlineOnOutline(
            "teeth", wheel, fm.cams.Outline(points), pawl, lever, normal=law,
            friction=fm.ModifiedCoulomb(0.1, 1e-4, 1e-3),
        ),
        fm.TorsionSpring("spring", fm.GROUND, pawl, stiffness=0.5, damping=1e-3, free_angle=-0.3),
        fm.Torque("load", wheel, 0.2), fm.TorsionSpring("oil", fm.GROUND, wheel, stiffness=0.0, damping=2e-3),
    ])  # fmt: skip


def test_a_ratchet_holds_the_wheel_whole_teeth_further():
    """Rest angles of two throws differ by four pitches; the pawl is back in a gap; the balance of energy closes."""
    rests = []
    for speed in (0.0, 60.0):
        sol = fm.simulate(ratchet(speed), t_end=0.6)
        assert sol.ok, sol.status
        assert abs(sol["wheel.omega"].values[-1]) < 1e-6
        assert np.abs(sol["energy.residual"].values).max() < 1e-6 * sol["energy.turned_over"].values[-1]
        rests.append((sol["wheel.theta"].values[-1], sol["pawl.theta"].values[-1]))
    assert rests[0][0] - rests[1][0] == pytest.approx(4.0 * 2.0 * math.pi / TEETH, abs=1e-8)
    assert rests[0][1] == pytest.approx(rests[1][1], abs=1e-8)
    # the steep flank stands at the tip: tooth and pawl from the closed form of both positions
    turned, lift = rests[1]
    tip = np.array([-0.05, 0.053]) + np.array([[math.cos(lift), -math.sin(lift)], [math.sin(lift), math.cos(lift)]]) @ (
        0.05, 0.0435 - 0.053
    )  # fmt: skip
    flank = math.radians(88.0) + turned + 4.0 * 2.0 * math.pi / TEETH
    assert math.atan2(tip[1], tip[0]) == pytest.approx(flank, abs=1.1e-3)  # the flank is turned by 1e-3 at its foot


def test_names_and_places_of_the_contacts():
    places = pair((0.25, 0.1)).find("pair").places()
    assert list(places) == ["first1", "first2", "first3", "second1", "second2", "second3"]
    assert places["first3"] == pytest.approx((0.0, -0.12), abs=1e-12)  # middle of the arc with bulge 0.2


def test_wrong_pairs_are_refused():
    with pytest.raises(ModelError, match=r"the outlines overlap by 0.0\d+ m near"):
        pair((0.12, 0.0))
    flat = (-0.2, -0.01), (0.2, -0.01), (0.2, 0.01), (-0.2, 0.01)
    bars = flat, [(-y, x) for x, y in flat]
    with pytest.raises(ModelError, match=r"the outlines overlap near"):  # no corner of one in the other
        pair((0.0, 0.0), moved(bars[1], (0.0, 0.0), -0.3), (), fm.cams.Outline(bars[0]))
    one = fm.RigidBody("one", at=(0.0, 0.0), mass=1.0, inertia=1.0)
    with pytest.raises(InputError, match=r"second_outline is 3\.0; it must be of the kind Outline"):
        fm.cams.OutlineOnOutline("pair", fm.GROUND, SHAPE, one, 3.0, normal=LAW)
    with pytest.raises(InputError, match=r"depends on radii, which corners have not"):
        pair((0.25, 0.1), normal=fm.HuntCrossley.from_materials(fm.STEEL, fm.STEEL))
    turn = 2.0 * math.pi * np.arange(300) / 300
    with pytest.raises(InputError, match=r"have 3\d\d contacts, more than 256. Draw curved sides as arcs"):
        pair((0.4, 0.1), [(0.1 * math.cos(a), 0.1 * math.sin(a)) for a in turn], ())


def in_a_hollow(radius, gap, angle, swapped=False, ball=0.1):
    """A disc over the round bottom of a hollow, at an angle from it."""
    c, s, way = math.cos(angle), math.sin(angle), radius - ball - gap
    far = 2.0 * radius
    bowl = fm.cams.Outline(((-radius, 0.0), (radius, 0.0), (far, -far), (-far, -far)), (1.0, 0.0, 0.0, 0.0))
    disc = fm.cams.Outline(((way * s + ball, -way * c), (way * s - ball, -way * c)), (1.0, 1.0))
    one = fm.RigidBody("one", at=(0.0, 0.0), mass=1.0, inertia=1.0, theta=0.3)
    two = fm.RigidBody("two", at=(way * s, -way * c), mass=1.0, inertia=1.0)
    ends = (two, disc, one, bowl) if swapped else (one, bowl, two, disc)
    return fm.Mechanism("hollow", [one, two, fm.cams.OutlineOnOutline("pair", *ends, normal=LAW)])


@pytest.mark.quick(1)
@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize(("radius", "angle"), [(0.5, 0.0), (0.5, 0.4), (0.11, 0.4), (50.0, 0.001)])
def test_a_disc_may_touch_a_hollow_arc(radius, angle, swapped):
    """Chords of the hollow lie 1e-4 of its radius beside it, and were taken for it: the disc was refused."""
    for gap in (1e-3, 1e-4, 1e-5, 1e-6, 1e-9, 0.0, -1e-5, -1.9e-4):  # up to a thousandth of the disc
        found = gaps(in_a_hollow(radius, gap, angle, swapped))
        assert min(found.values(), key=lambda one: abs(one - gap)) == pytest.approx(gap, abs=1e-12)
    for gap in (-2.1e-4, -1e-2, -0.05):
        with pytest.raises(ModelError, match=rf"the outlines overlap by {-gap:.1g}"):
            in_a_hollow(radius, gap, angle, swapped)


def test_contacts_have_the_names_that_a_person_gives():
    own = {"second1_side1": "tip", "second2": "heel"}
    mech = pair((0.25, 0.1), names=own)
    before, after = gaps(pair((0.25, 0.1))), gaps(mech)
    assert after == {own.get(name, name): gap for name, gap in before.items()}
    assert "heel" in mech.find("pair").places()
    sol = fm.simulate(mech, t_end=1e-4, step=1e-5)
    assert "pair.tip.normal_force" in sol
    assert "pair.tip" in sol.contacts.names


@pytest.mark.parametrize(
    ("names", "words"),
    [
        ({"second9": "tip"}, "'second9', which is no contact"),
        ({"second2": "a.b"}, "must be a non-empty string without '.'"),
        ({"second2": "first1"}, "two contacts have the name 'first1'"),
        ("tip", "names"),
    ],
)
def test_wrong_names_of_contacts_are_refused(names, words):
    with pytest.raises(InputError, match=words):
        pair((0.25, 0.1), names=names)
