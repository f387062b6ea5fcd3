"""Contact of outlines with circles: distances, hollow corners, Geneva wheels, a ratchet; contracts and messages."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError, ModelError
from flexmb.kernels import GAP_SIZE
from flexmb.testing import check_part

NORMAL = fm.LankaraniNikravesh(stiffness=2e9, restitution=0.85)
SHAPE = fm.cams.Outline(
    ((-0.1, -0.1), (0.1, -0.1), (0.15, 0.05), (0.05, 0.05), (0.05, 0.2), (-0.1, 0.2)), (0.2, 0.0, 0.0, -0.1, 0.3, 0.0)
)


def pair(centre, radius=0.02, outline=SHAPE):
    """A link with an outline and a body with a circle."""
    one = fm.RigidLink("one", (0.0, 0.0), (0.1, 0.17), mass=0.4, inertia=2e-3, centre=0.4)
    other = fm.RigidBody("other", at=(0.3, 0.2), mass=0.8, inertia=8e-3, theta=0.3)
    rubbing = fm.ModifiedCoulomb(0.2, v0=1e-4, v1=1e-2)
    circle = fm.cams.CircularCurve(centre, radius)
    contact = fm.cams.OutlineContact("pair", one, outline, other, circle, normal=NORMAL, friction=rubbing)
    return fm.Mechanism("pair", [one, other, contact])


BESIDE, ABOVE = (pytest.param(centre, marks=pytest.mark.slow) for centre in ((0.3, 0.0), (0.0, -0.2)))


@pytest.mark.parametrize("centre", [(0.2, 0.1), BESIDE, pytest.param((0.11, 0.13), marks=pytest.mark.slow), ABOVE])
def test_contracts(centre):
    report = check_part(pair(centre), "pair")
    assert max(check.error for check in report.checks) < 1e-7


def test_distances_are_those_of_the_drawn_outline():
    """Gap of a circle all around an outline with arcs, hollow arcs and corners, against its fine polygon."""
    mech = pair((0.3, 0.3), outline=fm.cams.Outline(
        ((-0.1, -0.1), (0.1, -0.1), (0.15, 0.05), (0.05, 0.1), (-0.1, 0.2)), (0.2, -0.3, 1.0, 0.0, 0.0)
    ))  # fmt: skip
    part = mech.find("pair")
    contacts = part.contributions(mech)
    polygon = part.outline.polygon
    closed = np.vstack([polygon, polygon[:1]])
    node, out, worst = mech.find("other").nodes()[0], np.zeros(GAP_SIZE), 0.0
    one = mech.find("one").nodes()[0]
    for a in np.linspace(0.0, 2.0 * math.pi, 200):
        centre = np.array([0.02 + 0.3 * math.cos(a), 0.05 + 0.3 * math.sin(a)])
        start, chord = closed[:-1], np.diff(closed, axis=0)
        share = np.clip(np.sum((centre - start) * chord, axis=1) / np.sum(chord * chord, axis=1), 0.0, 1.0)
        exact = np.hypot(*(start + share[:, None] * chord - centre).T).min() - 0.02
        shift = centre - (0.3, 0.3)
        q = np.array([one.x, one.y, one.theta, node.x + shift[0], node.y + shift[1], node.theta])
        gaps = []
        for contact in contacts:
            contact.gap.dispatcher(np.array(contact.p), q, np.zeros(6), out)
            gaps.append(float(out[0]))
        worst = max(worst, abs(min(gaps) - exact))
    assert worst < 5e-5  # of the polygon: R (1 - cos of half an angle)


@pytest.mark.parametrize("depth", [0.004, 0.02])
def test_a_circle_behind_a_hollow_corner_does_not_touch_it(depth):
    """A side sees nothing behind it: the gap of a centre within the body is its distance from the corner."""
    corners = ((-0.1, -0.1), (0.15, -0.1), (0.15, 0.05), (0.05, 0.05), (0.05, 0.2), (-0.1, 0.2))
    mech, out, gaps = pair((0.3, 0.3), outline=fm.cams.Outline(corners)), np.zeros(GAP_SIZE), []
    one, node = mech.find("one").nodes()[0], mech.find("other").nodes()[0]
    shift = 0.05 - depth / math.sqrt(2.0) - 0.3
    q = np.array([one.x, one.y, one.theta, node.x + shift, node.y + shift, node.theta])
    for contact in mech.find("pair").contributions(mech):
        contact.gap.dispatcher(np.array(contact.p), q, np.zeros(6), out)
        gaps.append(float(out[0]))
    assert gaps == pytest.approx([depth, depth], abs=1e-12)


def test_arcs_and_spline_of_a_curve_have_one_distance():
    """Gaps of a roller from a hollow curve and from its arcs, in many places."""
    curve = fm.ClosedCurve.from_function(
        lambda u: ((0.1 + 0.02 * math.cos(3.0 * u)) * math.cos(u), (0.1 + 0.02 * math.cos(3.0 * u)) * math.sin(u)), 120
    )
    outline, out = fm.cams.Outline.from_curve(curve, 1e-8), np.zeros(GAP_SIZE)
    one = fm.RigidBody("one", at=(0.0, 0.0), mass=1.0, inertia=1.0)
    other = fm.RigidBody("other", at=(0.2, 0.0), mass=1.0, inertia=1.0)
    roller = fm.cams.CircularCurve((0.2, 0.0), 0.01)
    contact = fm.cams.OutlineContact("arcs", one, outline, other, roller, normal=NORMAL)
    pair = fm.CurveOnCurve("spline", one, curve, other, roller, normal=NORMAL, start="open")
    mech = fm.Mechanism("both", [one, other, contact, pair])
    (arcs,), (spline,) = contact.contributions(mech), pair.contributions(mech)
    for u in np.linspace(0.0, 2.0 * math.pi, 400):
        size = 0.11 + 0.02 * math.cos(3.0 * u) + 2e-3 * math.sin(40.0 * u)
        q = np.array([0.0, 0.0, 0.0, size * math.cos(u), size * math.sin(u), 0.0])
        gaps = []
        for piece in (arcs, spline):
            piece.gap.dispatcher(np.array(piece.p), q, np.zeros(6), out)
            gaps.append(float(out[0]))
        assert gaps[0] == pytest.approx(gaps[1], abs=1.01e-8)


def test_a_pin_in_the_centre_of_a_hollow_arc_has_finite_forces():
    """The gap is the difference of the radii, whatever the normal."""
    points = ((-0.2, 0.0), (-0.1, 0.0), (0.1, 0.0), (0.2, 0.0), (0.2, -0.3), (-0.2, -0.3))
    outline = fm.cams.Outline(points, (0.0, 1.0, 0.0, 0.0, 0.0, 0.0))
    one = fm.RigidBody("one", at=(0.0, 0.0), mass=1.0, inertia=1.0)
    other = fm.RigidBody("other", at=(0.0, 0.0), mass=1.0, inertia=1.0)
    contact = fm.cams.OutlineContact("pin", one, outline, other, fm.cams.CircularCurve((0.0, 0.0), 0.09), normal=NORMAL)
    (piece,) = contact.contributions(fm.Mechanism("pair", [one, other, contact]))
    out = np.zeros(GAP_SIZE)
    piece.gap.dispatcher(np.array(piece.p), np.zeros(6), np.ones(6), out)
    assert np.all(np.isfinite(out))
    assert out[0] == pytest.approx(0.01, abs=1e-12)
    piece.gap.dispatcher(np.array(piece.p), np.array([0.0, 0.0, 0.0, 0.003, -0.004, 0.0]), np.ones(6), out)
    assert out[0] == pytest.approx(0.005, abs=1e-12)


def test_a_disc_in_a_v_rests_on_both_sides():
    """Two contacts, each with the force m g/(2 sin 45 deg)."""
    vee = fm.cams.Outline(((-0.2, -0.1), (0.2, -0.1), (0.2, 0.2), (0.0, 0.0), (-0.2, 0.2)))
    rest = 0.05 * math.sqrt(2.0)
    disc = fm.RigidBody("disc", at=(0.0, rest), mass=2.0, inertia=2e-3)
    law = fm.KelvinVoigt(stiffness=1e6, damping=1e3, ramp=1e-5)
    circle = fm.cams.CircularCurve((0.0, rest), 0.05)
    contact = fm.cams.OutlineContact("vee", fm.GROUND, vee, disc, circle, normal=law)
    sol = fm.simulate(fm.Mechanism("vee", [disc, contact], gravity=(0.0, -9.81)), t_end=0.2)
    assert sol.ok, sol.status
    force = 2.0 * 9.81 / (2.0 * math.sin(math.pi / 4.0))
    for side in ("side1", "side2"):
        assert sol[f"vee.{side}.normal_force"].values[-1] == pytest.approx(force, rel=1e-6)
    assert sol["disc.y"].values[-1] == pytest.approx(rest - force / 1e6 * math.sqrt(2.0), abs=1e-9)


def exact_ratio(angle, lam):
    """Speed of a Geneva wheel over that of its crank."""
    return lam * (np.cos(angle) - lam) / (1.0 - 2.0 * lam * np.cos(angle) + lam * lam)


@pytest.mark.parametrize(
    ("slots", "speed", "entry", "peak", "at"),
    [
        (3, 6.4641016151, 1.7320508, 31.3924284703, 4.758214), (4, 2.4142135624, 1.0, 5.4069810346, 11.463746),
        (8, 0.6199144044, 0.4142136, 0.6997569841, 31.642488),
    ],
)  # fmt: skip
def test_a_geneva_wheel_has_the_closed_form_of_its_motion(slots, speed, entry, peak, at):
    """Ratios of speed and acceleration: at the entry, largest, and its place."""
    lam, w = math.sin(math.pi / slots), 1.0
    begin, C = math.pi / slots - 0.5 * math.pi, 0.1
    pin = (lam * C * math.cos(begin), lam * C * math.sin(begin))
    crank = fm.RigidBody("crank", at=(0.0, 0.0), mass=0.2, inertia=1e-4)
    wheel = fm.RigidBody("wheel", at=(C, 0.0), mass=0.5, inertia=5e-4)
    sol = fm.simulate(fm.Mechanism("geneva", [
        crank, wheel,
        fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)), fm.Revolute("Q", fm.GROUND, wheel, at=(C, 0.0)),
        fm.PinSlot("pin", wheel, crank, at=pin, along=(pin[0] - C, pin[1])),
        fm.Drive("motor", "O", fm.ConstantSpeed(w)),
    ]), t_end=-2.0 * begin, method=fm.RungeKutta4(), step=-begin / 2000.0)  # fmt: skip
    assert sol.ok, sol.status
    angle = begin + sol.time
    omega, alpha = -sol["wheel.omega"].values, -sol["wheel.alpha"].values
    assert omega == pytest.approx(exact_ratio(angle, lam), abs=1e-9)
    assert omega.max() == pytest.approx(speed, rel=1e-6)
    assert alpha[0] == pytest.approx(entry, rel=1e-6)
    k = int(alpha.argmax())
    near = slice(k - 4, k + 5)
    curve = np.polynomial.Polynomial.fit(angle[near], alpha[near], 6)
    fine = np.linspace(angle[k - 1], angle[k + 1], 2001)
    assert curve(fine).max() == pytest.approx(peak, rel=1e-7)
    place = fine[int(curve(fine).argmax())]
    assert abs(math.degrees(place)) == pytest.approx(at, abs=2e-3)


def geneva(radius=0.004, clearance=2e-5, C=0.1, w=2.0 * math.pi, begin=math.radians(-60.0)):
    """Four slots and a pin with clearance; friction in its bearing holds the wheel between two turns."""
    half, tip, a = radius + clearance, C * math.cos(math.pi / 4.0), C * math.sin(math.pi / 4.0)
    reach, bottom = math.sqrt(tip * tip - half * half), C - a - 1e-3
    points, bulges = [], []
    for k in range(4):
        c, s = math.cos(0.25 * math.pi + 0.5 * math.pi * k), math.sin(0.25 * math.pi + 0.5 * math.pi * k)
        for x, y, bulge in ((reach, -half, 0.0), (bottom, -half, -1.0), (bottom, half, 0.0), (reach, half, -0.2)):
            points.append((C + c * x - s * y, s * x + c * y))
            bulges.append(bulge)
    crank = fm.RigidBody("crank", at=(0.0, 0.0), mass=0.2, inertia=1e-4)
    wheel = fm.RigidBody("wheel", at=(C, 0.0), mass=0.5, inertia=5e-4)
    rubbing = {"friction": fm.ModifiedCoulomb(0.1, v0=1e-4, v1=1e-3), "radius": 0.01, "preload": 50.0}
    circle = fm.cams.CircularCurve((a * math.cos(begin), a * math.sin(begin)), radius)
    law = fm.KelvinVoigt(stiffness=1e7, damping=3e3, ramp=1e-6)
    return fm.Mechanism("geneva", [
        crank, wheel, fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)),
        fm.Revolute("Q", fm.GROUND, wheel, at=(C, 0.0), **rubbing), fm.Drive("motor", "O", fm.ConstantSpeed(w)),
        fm.cams.OutlineContact("pin", wheel, fm.cams.Outline(points, bulges), crank, circle, normal=law),
    ])  # fmt: skip


def test_a_pin_turns_a_geneva_wheel_by_a_quarter_a_turn():
    """Two turns of the crank, slot after slot, within the play at the rim; in the slot nearly the ideal speed."""
    sol = fm.simulate(geneva(), t_end=2.0)
    assert sol.ok, sol.status
    turned = -sol["wheel.theta"].values
    after = [float(np.interp(t, sol.time, turned)) for t in (0.6, 1.6)]
    play = 2e-5 / 0.03
    assert after == pytest.approx([0.5 * math.pi, math.pi], abs=3e-3)  # it coasts a little after the exit
    assert after[1] - after[0] == pytest.approx(0.5 * math.pi, abs=0.2 * play)
    angle = (math.radians(-60.0) + 2.0 * math.pi * sol.time + math.pi) % (2.0 * math.pi) - math.pi
    inside = np.abs(angle) < math.radians(40.0)
    mean = np.trapezoid(np.where(inside, -sol["wheel.omega"].values, 0.0), sol.time)
    wanted = np.trapezoid(np.where(inside, 2.0 * math.pi * exact_ratio(angle, math.sin(math.pi / 4.0)), 0.0), sol.time)
    assert mean == pytest.approx(wanted, abs=4.0 * play)
    assert np.abs(sol["energy.residual"].values).max() < 1e-2 * sol["energy.turned_over"].values[-1]


@pytest.mark.slow
@pytest.mark.parametrize("pin_first", [False, True])
def test_a_geneva_wheel_of_two_outlines_turns_like_that_of_a_circle(pin_first):
    mech = geneva()
    contact = mech.find("pin")
    (x, y), r = contact.circle.centre, contact.circle.radius
    pin = fm.cams.Outline(((x - r, y), (x + r, y)), (1.0, 1.0))
    ends = (contact.first, contact.outline), (contact.second, pin)
    (one, own), (two, other) = ends[::-1] if pin_first else ends
    outlines = fm.cams.OutlineOnOutline("pin", one, own, two, other, normal=contact.normal)
    turned = [fm.simulate(m, t_end=0.5, signals=["wheel.theta"])["wheel.theta"].values
              for m in (mech, mech.with_part(outlines))]  # fmt: skip
    assert np.abs(turned[1] - turned[0]).max() < 5e-5


@pytest.mark.parametrize(("torque", "runs"), [(-0.2, True), (0.2, False)])
def test_a_ratchet_turns_one_way(torque, runs):
    """The steep flanks stop the wheel at a pawl that a spring holds down; along the slow flanks the pawl climbs."""
    teeth, outer, inner = 12, 0.05, 0.042
    points = []
    for k in range(teeth):
        a = 2.0 * math.pi * k / teeth
        for r, b in ((outer, a), (inner, a + 1e-3)):
            points.append((r * math.cos(b), r * math.sin(b)))
    wheel = fm.RigidBody("wheel", at=(0.0, 0.0), mass=0.5, inertia=5e-4)
    tip = (0.0, 0.0545)
    pawl = fm.RigidBody("pawl", at=(0.03, 0.0545), mass=0.05, inertia=2e-5)
    law = fm.KelvinVoigt(stiffness=1e6, damping=100.0, ramp=1e-6)
    sol = fm.simulate(fm.Mechanism("ratchet", [
        wheel, pawl,
        fm.Revolute("O", fm.GROUND, wheel, at=(0.0, 0.0)), fm.Revolute("P", fm.GROUND, pawl, at=(0.06, 0.0545)),
        fm.cams.OutlineContact(
            "tip", wheel, fm.cams.Outline(points), pawl, fm.cams.CircularCurve(tip, 0.002), normal=law
        ),
        fm.TorsionSpring("spring", fm.GROUND, pawl, stiffness=1.0, damping=2e-3, free_angle=0.3),
        fm.Torque("load", wheel, torque), fm.TorsionSpring("oil", fm.GROUND, wheel, stiffness=0.0, damping=0.02),
    ]), t_end=0.5)  # fmt: skip
    assert sol.ok, sol.status
    turned = sol["wheel.theta"].values
    if runs:
        assert -turned[-1] > 2.0 * math.pi / teeth * 3.0
    else:
        assert abs(turned[-1]) < 2.0 * math.pi / teeth
        assert abs(sol["wheel.omega"].values[-1]) < 1e-6


def test_wrong_contacts_are_refused():
    with pytest.raises(InputError, match=r"circle of radius 1 m does not fit into the hollow arc"):
        pair((2.0, 2.0), radius=1.0)
    with pytest.raises(ModelError, match=r"circle and outline overlap by 0.005 m"):
        pair((0.09, 0.065))  # over the middle of a straight side, whose hollow corner is far
    with pytest.raises(ModelError, match=r"circle and outline overlap by 0.07 m"):
        pair((0.0, 0.05), outline=fm.cams.Outline(((-0.1, 0.0), (0.1, 0.0), (0.1, 0.4), (-0.1, 0.4))))
    with pytest.raises(InputError, match=r"outline is .*; it must be of the kind Outline"):
        pair((0.2, 0.2), outline=3.0)


@pytest.mark.parametrize("width", [0.002, 0.01, 0.03])
def test_a_pin_does_not_go_through_a_tooth(width):
    """With too soft a law it passed with its whole radius, since a side sees nothing behind it, and the run was ok."""
    half = 0.5 * width
    tooth = [(-0.05, 0), (-half, 0), (-half, 0.05), (half, 0.05), (half, 0), (0.05, 0), (0.05, -0.05), (-0.05, -0.05)]
    pin = fm.RigidBody("pin", (-0.03, 0.03), mass=1.0, inertia=0.01, velocity=(1.0, 0.0, 0.0))
    circle = fm.cams.CircularCurve((-0.03, 0.03), 0.004)

    def thrown(stiffness):
        law = fm.KelvinVoigt(stiffness, 0.0)
        contact = fm.cams.OutlineContact("rack", fm.GROUND, fm.cams.Outline(tooth), pin, circle, normal=law)
        return fm.simulate(fm.Mechanism("thrown", [pin, contact]), t_end=0.08)

    soft, stiff = thrown(1e4), thrown(1e6)
    assert not soft.ok
    assert "the parts pass through each other" in soft.status
    assert soft["pin.x"].values[-1] < -half
    assert stiff.ok
    assert stiff["pin.vx"].values[-1] == pytest.approx(-1.0, rel=1e-3)
