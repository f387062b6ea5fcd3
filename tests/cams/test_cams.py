"""Cams and followers against closed forms: lifts, forces, accelerations, lift-off; contracts; messages."""

import math
import re

import numpy as np
import pytest
from cases import slow_where
from scipy.spatial import cKDTree

import flexmb as fm
from flexmb.errors import InputError, ModelError
from flexmb.parts.cams.curves import sampled
from flexmb.testing import check_part

E, R = 0.01, 0.03
M, K = 0.3, 2000.0
TURN = np.linspace(0.0, 2.0 * math.pi, 181)[:-1]
DISC = fm.ClosedCurve(np.column_stack([E + R * np.cos(TURN), R * np.sin(TURN)]))
FACE = fm.Line((-0.05, R), (0.05, R))
LIFT_OFF = math.sqrt((K * 0.02 + 2.0 * K * E) / (M * E))
"""Speed of the first lift-off [rad/s], 163.3."""


def valve(face=FACE, *, speed=40.0, curve=DISC, start=R, angle=0.0, shift=(0.0, 0.0), **pair):
    """Eccentric disc and follower under a spring, all turned and shifted."""
    c, s = math.cos(angle), math.sin(angle)

    def moved(x, y):
        return shift[0] + c * x - s * y, shift[1] + s * x + c * y

    if isinstance(face, fm.Line):
        face = fm.Line(moved(*face.start), moved(*face.end))
    else:
        face = fm.cams.CircularCurve(moved(*face.centre), face.radius)
    if angle or shift != (0.0, 0.0):
        curve = fm.ClosedCurve([moved(*p) for p in curve.points])
    cam = fm.RigidBody("cam", at=shift, mass=0.5, inertia=1e-3, theta=angle)
    follower = fm.RigidBody("follower", at=moved(0.0, start), mass=M, inertia=1e-4)
    return fm.Mechanism("valve", [
        cam, follower,
        fm.Revolute("axis", fm.GROUND, cam, at=shift),
        fm.Prismatic("guide", fm.GROUND, follower, along=(-s, c)),
        fm.CurveOnCurve("tappet", cam, curve, follower, face, **pair),
        fm.SpringDamper(
            "spring", fm.GROUND, follower, at=moved(0.0, 0.2), to=moved(0.0, start), stiffness=K, free_length=0.2
        ),
        fm.Drive("motor", "axis", fm.ConstantSpeed(speed)),
    ])  # fmt: skip


def test_flat_follower_of_an_eccentric_disc():
    """y = r + e sin wt; force k y - m e w^2 sin wt, so 44.8 N at least."""
    sol = fm.simulate(valve(), periods=2)
    assert sol.ok, sol.status
    wt = 40.0 * sol.time
    y, force = sol["follower.y"].values, sol["tappet.force"].values
    assert y == pytest.approx(R + E * np.sin(wt), abs=1e-12)
    assert y.max() - y.min() == pytest.approx(0.02, rel=1e-5)
    exact = K * (R + E * np.sin(wt)) - M * E * 1600.0 * np.sin(wt)
    assert force == pytest.approx(exact, abs=1e-4)
    assert force.min() == pytest.approx(44.8, abs=1e-4)
    assert sol["tappet.place"].values == pytest.approx(0.05 + E * np.cos(wt), abs=1e-8)  # between steps
    # the driving torque lifts follower and spring, and all of its power goes through the pair
    assert sol["tappet.normal_speed"].values == pytest.approx(E * 40.0 * np.cos(wt), abs=1e-6)
    power = sol["tappet.force"].values * sol["tappet.normal_speed"].values
    assert sol["motor.power"].values[1:] == pytest.approx(power[1:], abs=1e-4)
    assert sol["motor.torque"].values[1:] == pytest.approx((exact * E * np.cos(wt))[1:], abs=2e-6)
    assert np.abs(sol["energy.residual"].values).max() < 1e-5 * sol["energy.turned_over"].values[-1]


def test_roller_follower_of_an_eccentric_disc():
    """y = e sin wt + sqrt((r + rho)^2 - e^2 cos^2 wt)."""
    rho = 0.008
    start = math.sqrt((R + rho) ** 2 - E**2)
    sol = fm.simulate(valve(fm.cams.CircularCurve((0.0, start), rho), start=start), periods=1)
    assert sol.ok, sol.status
    wt = 40.0 * sol.time
    exact = E * np.sin(wt) + np.sqrt((R + rho) ** 2 - (E * np.cos(wt)) ** 2)
    assert sol["follower.y"].values == pytest.approx(exact, abs=2e-12)


@pytest.mark.slow
def test_an_arm_on_a_disc_is_a_four_bar():
    """Roller and disc keep the distance of their centres, as a rod does."""
    rho, pivot, centre = 0.01, (0.1, 0.0), (0.03, 0.0346)

    def machine(make):
        cam = fm.RigidBody("cam", at=(0.0, 0.0), mass=0.5, inertia=1e-3)
        arm = fm.RigidBody("arm", at=(0.08, 0.02), mass=0.4, inertia=1e-3, theta=0.5)
        return fm.Mechanism("arm", [
            cam, arm, fm.Revolute("O", fm.GROUND, cam, at=(0.0, 0.0)), fm.Revolute("P", fm.GROUND, arm, at=pivot),
            make(cam, arm), fm.Drive("motor", "O", fm.ConstantSpeed(7.0)),
        ])  # fmt: skip

    distance = math.dist((E, 0.0), centre)
    round_part = fm.cams.CircularCurve(centre, distance - R)
    cam = fm.simulate(machine(lambda a, b: fm.CurveOnCurve("pair", a, DISC, b, round_part)), periods=1)
    rod = fm.simulate(machine(lambda a, b: fm.couplings.Distance("pair", a, b, at=(E, 0.0), to=centre)), periods=1)
    assert rho < distance  # the test has a roller
    assert cam["arm.theta"].values == pytest.approx(rod["arm.theta"].values, abs=1e-10)
    assert cam["pair.force"].values == pytest.approx(
        -rod["pair.force"].values, abs=1e-6 * abs(rod["pair.force"].values).max()
    )
    follower = fm.ClosedCurve.from_function(
        lambda u: (centre[0] + (distance - R) * math.cos(u), centre[1] + (distance - R) * math.sin(u))
    )
    both = fm.simulate(machine(lambda a, b: fm.CurveOnCurve("pair", b, follower, a, DISC)), periods=1)
    assert both["arm.theta"].values == pytest.approx(rod["arm.theta"].values, abs=1e-9)


def explicit(mechanism, turns=1.0, speed=10.0):
    """Run with accelerations that hold the equations at each saved instant."""
    sol = fm.simulate(
        mechanism, t_end=turns * 2.0 * math.pi / speed, method=fm.RungeKutta4(), step=2.0 * math.pi / speed / 4000.0
    )
    assert sol.ok, sol.status
    return sol


STATIONS = ((0.0, 0.0), (1.2, 0.01), (1.6, 0.01), (2.8, 0.0))


@pytest.mark.quick(2)
@pytest.mark.parametrize("law", ["cycloidal", "3-4-5"])
@pytest.mark.parametrize("kind", ["flat", "roller", "knife"])
def test_a_profile_gives_its_lift_law(law, kind):
    """Lift to 1e-12 m and acceleration to 1e-8 of its peak, without dwell of the checks: at all angles."""
    lift = fm.cams.Lift(STATIONS, law)
    radius, offset = {"flat": (0.0, 0.0), "roller": (0.01, 0.005), "knife": (0.0, -0.004)}[kind]
    start = 0.06 if kind == "flat" else math.sqrt((0.04 + radius) ** 2 - offset**2)
    if kind == "flat":
        profile, face = fm.cams.flat_profile(lift, 0.06), fm.Line((-0.1, 0.06), (0.1, 0.06))
    else:
        profile = fm.cams.roller_profile(lift, 0.04, roller=radius, offset=offset)
        face = fm.cams.CircularCurve((offset, start), radius) if radius else None
    mech = valve(face or FACE, speed=10.0, curve=profile if face else DISC, start=start if face else R)
    if face is None:
        cam, follower = (
            fm.RigidBody("cam", at=(0.0, 0.0), mass=0.5, inertia=1e-3),
            fm.RigidBody("follower", at=(0.0, start), mass=M, inertia=1e-4),
        )
        mech = fm.Mechanism("knife", [
            cam, follower, fm.Revolute("axis", fm.GROUND, cam, at=(0.0, 0.0)),
            fm.Prismatic("guide", fm.GROUND, follower, along=(0.0, 1.0)),
            fm.cams.PointOnCurve("edge", cam, profile, follower, (offset, start)),
            fm.Drive("motor", "axis", fm.ConstantSpeed(10.0)),
        ])  # fmt: skip
    sol = explicit(mech)
    exact = np.array([lift.at(angle) for angle in 10.0 * sol.time])
    peak = np.abs(exact[:, 2]).max()
    assert sol["follower.y"].values - start == pytest.approx(exact[:, 0], abs=1e-12)
    assert np.abs(sol["follower.ay"].values / 100.0 - exact[:, 2]).max() < 1e-8 * peak


@pytest.mark.parametrize("kind", ["flat", "roller"])
def test_a_profile_gives_its_swing(kind):
    lift = fm.cams.Lift(tuple((a, 20.0 * s) for a, s in STATIONS), "3-4-5")
    pivot, first = (0.12, 0.02), 2.2
    if kind == "roller":
        profile = fm.cams.oscillating_roller_profile(lift, pivot, arm=0.1, angle=first, roller=0.01)
        face = fm.cams.CircularCurve((pivot[0] + 0.1 * math.cos(first), pivot[1] + 0.1 * math.sin(first)), 0.01)
    else:
        profile = fm.cams.oscillating_flat_profile(lift, pivot, angle=first - 0.5 * math.pi, offset=0.0)
        u = math.cos(first), math.sin(first)
        face = fm.Line(pivot, (pivot[0] + 0.3 * u[0], pivot[1] + 0.3 * u[1]))
    cam = fm.RigidBody("cam", at=(0.0, 0.0), mass=0.5, inertia=1e-3)
    arm = fm.RigidBody("arm", at=(0.1, 0.05), mass=0.4, inertia=1e-3)
    sol = explicit(fm.Mechanism("arm", [
        cam, arm, fm.Revolute("O", fm.GROUND, cam, at=(0.0, 0.0)), fm.Revolute("P", fm.GROUND, arm, at=pivot),
        fm.CurveOnCurve("pair", cam, profile, arm, face), fm.Drive("motor", "O", fm.ConstantSpeed(10.0)),
    ]))  # fmt: skip
    exact = np.array([lift.at(angle) for angle in 10.0 * sol.time])
    assert sol["arm.theta"].values == pytest.approx(exact[:, 0], abs=1e-11)
    assert np.abs(sol["arm.alpha"].values / 100.0 - exact[:, 2]).max() < 1e-8 * np.abs(exact[:, 2]).max()


def test_the_ideal_force_reaches_zero_at_the_lift_off_speed():
    """w^2 = (F0 + 2 k e)/(m e), at the top."""
    least = {}
    for speed in (163.0, 163.6):
        sol = fm.simulate(valve(speed=speed), periods=1)
        least[speed**2] = float(sol["tappet.force"].values.min())
    (a, fa), (b, fb) = least.items()
    assert fa > 0.0 > fb
    assert math.sqrt(a - fa * (b - a) / (fb - fa)) == pytest.approx(LIFT_OFF, rel=1e-5)


LAW = fm.KelvinVoigt(stiffness=1e8, damping=4e3, ramp=1e-7)


@pytest.mark.parametrize(("factor", "parts"), [(0.99, False), (1.01, True)])
def test_a_contact_opens_above_the_lift_off_speed(factor, parts):
    sol = fm.simulate(valve(speed=factor * LIFT_OFF, normal=LAW), periods=3)
    assert sol.ok, sol.status
    assert (len(sol.episodes("tappet")) > 1) is parts
    assert bool((sol["tappet.penetration"].values < -1e-7).any()) is parts


def test_a_flight_of_the_follower_is_a_free_vibration():
    """From its start to its end the follower that has lifted off swings on its spring alone."""
    sol = fm.simulate(valve(speed=200.0, normal=LAW), periods=3, step=fm.Adaptive(rtol=1e-5))
    episodes = sol.episodes("tappet")
    assert len(episodes) > 2
    begin, end = episodes[0].end, episodes[1].start
    inside = (sol.time > begin) & (sol.time < end)
    assert inside.sum() > 20
    t, y, v = sol.time[inside], sol["follower.y"].values[inside], sol["follower.vy"].values[inside]
    w = math.sqrt(K / M)
    free = y[0] * np.cos(w * (t - t[0])) + v[0] / w * np.sin(w * (t - t[0]))  # the spring is unstressed at y = 0
    assert y == pytest.approx(free, abs=2e-7)
    assert np.abs(sol["energy.residual"].values).max() < 1e-3 * sol["energy.turned_over"].values[-1]


def test_a_law_that_lets_the_cam_through_is_not_ok():
    sol = fm.simulate(valve(normal=fm.KelvinVoigt(stiffness=1e3, damping=1.0)), periods=2)
    assert not sol.ok
    assert re.search(r"'tappet' is penetrated by 0.0\d+ m", sol.status)


def test_friction_on_a_face_turns_the_cam_back():
    """Friction mu N at the height r + e sin wt adds its torque to that of the lift."""
    mu = 0.2
    sol = fm.simulate(valve(friction=fm.friction.SmoothCoulomb(mu, v0=1e-4)), periods=1)
    assert sol.ok, sol.status
    wt = 40.0 * sol.time
    force = K * (R + E * np.sin(wt)) - M * E * 1600.0 * np.sin(wt)
    torque = force * E * np.cos(wt) + mu * force * (R + E * np.sin(wt))
    assert sol["motor.torque"].values[1:] == pytest.approx(torque[1:], rel=1e-3)
    lost = np.trapezoid(mu * force * (R + E * np.sin(wt)) * 40.0, sol.time)
    assert sol["energy.dissipated_friction"].values[-1] == pytest.approx(lost, rel=1e-3)
    rubbing = fm.simulate(valve(friction=fm.friction.SmoothCoulomb(mu, v0=1e-4), normal=LAW), periods=1)
    assert np.abs(rubbing["energy.residual"].values).max() < 1e-3 * rubbing["energy.turned_over"].values[-1]
    assert rubbing["motor.torque"].values[200:] == pytest.approx(sol["motor.torque"].values[200:], abs=0.02)


def test_a_law_made_from_materials_has_the_stiffness_of_both_radii():
    """Disc of 30 mm against a face, and against a roller of 15 mm, 1/R = 1/30 mm + 1/15 mm: stiffness like sqrt(R)."""
    law, found = fm.HuntCrossley(materials=(fm.STEEL, fm.STEEL), restitution=0.9), []
    for face in (FACE, fm.cams.CircularCurve((0.0, R + 0.015), 0.015)):
        mech = valve(face, normal=law)
        found.append(mech.find("tappet").contributions(mech)[0].normal.parameters()[0])
    assert found[0] / found[1] == pytest.approx(math.sqrt(3.0), rel=1e-6)
    modulus = fm.STEEL.young / (2.0 * (1.0 - fm.STEEL.poisson**2))
    assert found[0] == pytest.approx(4.0 / 3.0 * modulus * math.sqrt(R), rel=1e-6)


def test_inverse_dynamics_takes_the_ideal_pair():
    times = np.linspace(0.0, 0.15, 7)
    found = fm.inverse_dynamics(valve(normal=LAW), times).forces["tappet"]
    wt = 40.0 * times
    assert found[:, 1] == pytest.approx(K * (R + E * np.sin(wt)) - M * E * 1600.0 * np.sin(wt), rel=1e-7)
    assert np.abs(found[:, 0]).max() < 1e-9


def test_forces_do_not_depend_on_the_frame():
    straight = fm.simulate(valve(), periods=1)
    turned = fm.simulate(valve(angle=2.3, shift=(3.0, -2.0)), periods=1)
    assert turned["tappet.force"].values == pytest.approx(straight["tappet.force"].values, rel=1e-8)
    assert turned["motor.torque"].values[1:] == pytest.approx(straight["motor.torque"].values[1:], abs=1e-8)


EGG = fm.ClosedCurve(
    [(0.02 + 0.1 * math.cos(a) + 0.012 * math.cos(2.0 * a), 0.05 + 0.13 * math.sin(a)) for a in TURN[::3]]
)
SMALL = fm.ClosedCurve([(0.172 + 0.04 * math.cos(a), 0.05 + 0.05 * math.sin(a)) for a in TURN[::3]])
SHAPES = {
    "line": fm.Line((0.132, -0.1), (0.162, 0.2)), "roller": fm.cams.CircularCurve((0.162, 0.05), 0.03), "cam": SMALL,
}  # fmt: skip
RUBBING = fm.ModifiedCoulomb(0.2, v0=1e-4, v1=1e-2)
NORMAL = fm.LankaraniNikravesh(stiffness=2e9, restitution=0.85)


def pair(shape, **given):
    """Two bodies with an egg and another shape."""
    one = fm.RigidLink("one", (0.0, 0.0), (0.1, 0.17), mass=0.4, inertia=2e-3, centre=0.4)
    other = fm.RigidBody("other", at=(0.3, 0.2), mass=0.8, inertia=8e-3, theta=0.3)
    if shape == "point":
        part = fm.cams.PointOnCurve("pair", one, EGG, other, (0.133, 0.05), **given)
    else:
        part = fm.CurveOnCurve("pair", one, EGG, other, SHAPES[shape], **given)
    return fm.Mechanism("pair", [one, other, part])


@pytest.mark.quick(2)
@pytest.mark.usefixtures("states")
@pytest.mark.parametrize("shape", [*SHAPES, "point"])
@pytest.mark.parametrize("given", [{"friction": RUBBING}, {"normal": NORMAL, "friction": RUBBING, "start": "open"}])
def test_contracts(shape, given):
    report = check_part(pair(shape, **given), "pair")
    assert max(check.error for check in report.checks) < 1e-8


@pytest.mark.parametrize("shape", slow_where(lambda n: n == "cam", SHAPES))
def test_the_nearest_points_are_found(shape):
    """Gaps against the least distance of many points of both curves, in random poses apart from each other."""
    mech = pair(shape, normal=NORMAL, start="open")
    contact = mech.find("pair").contributions(mech)[0]
    nodes = {b.name: b.node(b.main) for b in mech.bodies}
    random, worst, seen = np.random.default_rng(5), 0.0, 0
    fine = 100
    egg = sampled(EGG.array, fine)
    other = SHAPES[shape]
    if shape == "line":
        share = np.linspace(0.0, 1.0, 4001)[:, None]
        points = (1.0 - share) * np.array(other.start) + share * np.array(other.end)
    elif shape == "cam":
        points = sampled(other.array, fine)
    else:
        points = np.array([other.centre])
    for _ in range(60):
        q = np.array([*(getattr(n, k) for n in nodes.values() for k in ("x", "y", "theta"))])
        angle = random.uniform(-math.pi, math.pi)
        q[2] += angle
        if shape == "line":  # whose other side is the inside of a body
            q[3:5] += random.uniform(0.0, 0.2), random.uniform(-0.4, 0.4)
        else:
            q[3:5] += 0.3 * math.cos(angle), 0.3 * math.sin(angle)
            q[5] += random.uniform(-3.0, 3.0)
        clouds = []
        for cloud, node, at in zip((egg, points), nodes.values(), (q[:3], q[3:]), strict=True):
            turn = at[2] - node.theta
            c, s = math.cos(turn), math.sin(turn)
            x, y = (cloud - (node.x, node.y)).T
            clouds.append(np.column_stack([at[0] + c * x - s * y, at[1] + s * x + c * y]))
        away, _ = cKDTree(clouds[0]).query(clouds[1])
        exact = float(away.min()) - (other.radius if shape == "roller" else 0.0)
        if exact < 0.01:
            continue  # they overlap
        out = np.zeros(49)
        contact.gap.dispatcher(np.array(contact.p), q, np.zeros(6), out)
        worst, seen = max(worst, abs(out[0] - exact)), seen + 1
    assert seen > 20
    assert worst < 2e-6  # of the spacing of the points, squared


@pytest.mark.quick(1)
@pytest.mark.parametrize("kind", ["cam", "roller", "line"])
@pytest.mark.parametrize("depth", [1e-3, -1e-6, -1e-3])
def test_gaps_of_discs(kind, depth):
    """Distance of the centres less both radii, open and deep in contact, in any pose."""
    r1, r2 = 0.03, 0.05

    def disc(x, r):
        return fm.ClosedCurve.from_function(lambda u: (x + r * math.cos(u), r * math.sin(u)), 120)

    other = {
        "cam": disc(r1 + r2, r2), "roller": fm.cams.CircularCurve((r1 + r2, 0.0), r2),
        "line": fm.Line((r1, -1.0), (r1, 1.0)),
    }[kind]  # fmt: skip
    bodies = [fm.RigidBody(n, at=(x, 0.0), mass=1.0, inertia=1.0) for n, x in (("one", 0.0), ("two", r1 + r2))]
    part = fm.CurveOnCurve("pair", bodies[0], disc(0.0, r1), bodies[1], other, normal=NORMAL, start="open")
    contact = part.contributions(fm.Mechanism("pair", [*bodies, part]))[0]
    random, out = np.random.default_rng(3), np.zeros(49)
    for _ in range(100):
        a, turn, gap = random.uniform(-3.0, 3.0), random.uniform(-9.0, 9.0, 2), depth * random.uniform(0.1, 1.0)
        x, y = (r1 + r2 + gap) * math.cos(a), (r1 + r2 + gap) * math.sin(a)
        q = np.array([0.0, 0.0, turn[0], x, y, a if kind == "line" else turn[1]])
        contact.gap.dispatcher(np.array(contact.p), q, np.zeros(6), out)
        assert out[0] == pytest.approx(gap, abs=1e-11)


def test_pictures_show_both_curves():
    sol = fm.simulate(valve(), periods=0.1)
    lines = {(s.part, len(line)) for s in sol.shapes if hasattr(s, "lines") for line in s.lines}
    assert ("cam", 361) in lines
    assert ("follower", 2) in lines


def test_wrong_pairs_are_refused():
    with pytest.raises(
        ModelError, match=r"curves are 0.04 m apart in the reference configuration, beside a curve of 0.06"
    ):
        fm.simulate(valve(fm.Line((-0.05, 0.07), (0.05, 0.07)), start=0.07), periods=0.1)
    with pytest.raises(ModelError, match=r"touches the line -0.01 m from its start, beyond its ends"):
        fm.simulate(valve(fm.Line((0.02, R), (0.05, R))), periods=0.1)
    with pytest.raises(ModelError, match=r"curves overlap by 0.005 m in the reference configuration"):
        fm.simulate(
            valve(fm.Line((-0.05, 0.025), (0.05, 0.025)), normal=LAW, start=0.025).with_({"tappet.start": "open"})
        )
    bean = fm.ClosedCurve([((0.03 - 0.02 * math.cos(2 * a)) * math.cos(a), 0.05 * math.sin(a)) for a in TURN])
    with pytest.raises(InputError, match=r"not convex near \(.*straight face bridges"):
        valve(curve=bean)
    with pytest.raises(InputError, match=r"roller of radius 0.1 m does not fit into the hollow .* \(undercut\)"):
        valve(fm.cams.CircularCurve((0.0, 0.15), 0.1), curve=bean)
    cam, other = (fm.RigidBody(n, at=(0.0, 0.0), mass=1.0, inertia=1.0) for n in ("cam", "other"))
    with pytest.raises(InputError, match="one must be a ClosedCurve"):
        fm.CurveOnCurve("pair", cam, FACE, other, FACE)
    with pytest.raises(ModelError, match="joins 'cam' to itself"):
        fm.CurveOnCurve("pair", cam, DISC, cam, FACE)
    with pytest.raises(InputError, match=r"normal is 3\.0; it must be a normal law"):
        fm.CurveOnCurve("pair", cam, DISC, other, FACE, normal=3.0)
    with pytest.raises(InputError, match="an ideal pair cannot start open"):
        fm.CurveOnCurve("pair", cam, DISC, other, FACE, start="open")
    with pytest.raises(InputError, match=r"curve is .*it must be a ClosedCurve"):
        fm.cams.PointOnCurve("pair", cam, FACE, other, (0.0, 0.0))
    beam = fm.FlexibleLink("beam", (0.0, R), (0.5, R), section=fm.Rectangle(width=0.01, height=0.01), material=fm.STEEL)
    with pytest.raises(ModelError, match="is flexible and cannot carry a curve"):
        fm.simulate(fm.Mechanism("m", [cam, beam, fm.CurveOnCurve("pair", cam, DISC, beam, FACE)]), t_end=0.1)
