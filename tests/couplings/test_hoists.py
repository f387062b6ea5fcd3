"""Cables on drums and pulleys, and stops between bodies, against closed forms."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError, ModelError

LAW = fm.KelvinVoigt(1e6, 2e3, ramp=1e-6)
Cable = fm.couplings.Cable
G = 9.81


def drum(name, at, J=0.02, **more):
    return fm.RigidBody(name, at=at, mass=3.0, inertia=J, **more)


def load(at, m=8.0, name="load"):
    return fm.RigidBody(name, at=at, mass=m, inertia=0.05)


def hoist(side, *more, R=0.1):
    """A load that hangs at the tangent of a drum, on its right (side 1: wound up counter-clockwise) or on its left."""
    winch, weight = drum("winch", (0.0, 0.0), angle=0.3), load((R * side, -2.0))
    rope = Cable("rope", winch, weight, at=(0.0, 0.0), to=weight.at, radii=(side * R, 0.0), normal=LAW)
    return fm.Mechanism("hoist", [
        winch, weight, fm.Revolute("O", fm.GROUND, winch, at=(0.0, 0.0)), rope, *more,
    ], gravity=(0.0, -G))  # fmt: skip


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_load_falls_with_its_drum(side):
    """a = g/(1 + J/(m R^2)), tension m (g - a), and the bearing carries drum and rope."""
    sol = fm.simulate(hoist(side), t_end=0.5)
    assert sol.ok, sol.status
    a = G / (1.0 + 0.02 / (8.0 * 0.01))
    assert float(sol["load.y"][-1]) == pytest.approx(-2.0 - 0.5 * a * 0.25, abs=1e-4)
    assert float(sol["rope.normal_force"][-1]) == pytest.approx(8.0 * (G - a), rel=1e-4)
    assert float(sol["winch.theta"][-1]) - 0.3 == pytest.approx(-side * 0.5 * a * 0.25 / 0.1, rel=1e-4)
    assert float(sol["O.fy"][-1]) == pytest.approx(3.0 * G + 8.0 * (G - a), rel=1e-4)
    assert np.abs(sol["load.x"].values - 0.1 * side).max() < 1e-9  # the strand stays where it is
    assert np.abs(sol["energy.residual"].values).max() < 1e-6 * sol["energy.turned_over"].values[-1]


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_winch_lifts_its_load(side):
    """R alpha up: torque R m (g + R alpha) + J alpha after the jerk has died out; many turns of the drum."""
    alpha = 4.0 * side
    motor = fm.Drive("motor", "O", fm.drives.Polynomial((0.0, 0.0, 0.5 * alpha)))
    sol = fm.simulate(hoist(side, motor), t_end=1.5)
    assert sol.ok, sol.status
    torque = side * 0.1 * 8.0 * (G + 0.1 * 4.0) + 0.02 * alpha
    assert float(sol["motor.torque"][-1]) == pytest.approx(torque, rel=1e-4)
    assert float(sol["load.y"][-1]) == pytest.approx(-2.0 + 0.1 * 0.5 * 4.0 * 1.5**2, abs=2e-4)
    assert float(sol["rope.distance"][-1]) == pytest.approx(-float(sol["load.y"][-1]), rel=1e-6)


def test_a_tether_that_winds_round_a_post_ends_after_half_a_turn():
    """l^2 = l0^2 - 2 R v t of the involute; beyond, the cable was longer by a turn of the drum."""
    post, ball = drum("post", (0.0, 0.0)), fm.bodies.PointMass("ball", at=(1.0, -0.1), mass=1.0, velocity=(0.0, 3.0))
    cable = Cable("tether", post, ball, at=(0.0, 0.0), to=ball.at, radii=(-0.1, 0.0), normal=LAW)
    mech = fm.Mechanism("tether", [post, ball, fm.Fixed("O", fm.GROUND, post, at=(0.0, 0.0)), cable])
    for t, ok in ((0.8, True), (1.0, False)):
        sol = fm.simulate(mech, t_end=t)
        assert sol.ok == ok
        assert (float(sol["tether.distance"][-1]) == pytest.approx(math.sqrt(1.0 - 0.6 * t), rel=1e-3)) == ok


def test_two_loads_over_a_pulley():
    """Atwood with a heavy pulley: a = (m1 - m2) g/(m1 + m2 + J/R^2), and two tensions."""
    R, J, m1, m2 = 0.1, 0.03, 6.0, 4.0
    pulley, one, two = drum("pulley", (0.0, 0.0), J), load((-R, -1.0), m1, "one"), load((R, -1.0), m2, "two")
    mech = fm.Mechanism("atwood", [
        pulley, one, two, fm.Revolute("O", fm.GROUND, pulley, at=(0.0, 0.0)),
        Cable("left", pulley, one, at=(0.0, 0.0), to=one.at, radii=(-R, 0.0), normal=LAW),
        Cable("right", pulley, two, at=(0.0, 0.0), to=two.at, radii=(R, 0.0), normal=LAW),
    ], gravity=(0.0, -G))  # fmt: skip
    sol = fm.simulate(mech, t_end=0.4)
    assert sol.ok, sol.status
    a = (m1 - m2) * G / (m1 + m2 + J / R**2)
    assert float(sol["one.y"][-1]) == pytest.approx(-1.0 - 0.5 * a * 0.16, abs=1e-4)
    assert float(sol["left.normal_force"][-1]) == pytest.approx(m1 * (G - a), rel=1e-4)
    assert float(sol["right.normal_force"][-1]) == pytest.approx(m2 * (G + a), rel=1e-4)


def test_a_moving_pulley_halves_the_force():
    """A load on a loose pulley between a fixed end and a drum: tension m g/2 in both strands, torque R m g/2."""
    R, r = 0.1, 0.05
    block = fm.RigidBody("block", at=(0.0, -1.0), mass=10.0, inertia=1e-3)
    winch = drum("winch", (r + R, 0.0))
    parts = [
        winch, block,
        Cable("dead", fm.GROUND, block, at=(-r, 0.0), to=block.at, radii=(0.0, r), normal=LAW),
        Cable("live", winch, block, at=winch.at, to=block.at, radii=(-R, -r), normal=LAW),
    ]  # fmt: skip
    brake = fm.Fixed("brake", fm.GROUND, winch, at=winch.at)
    rest = fm.static_equilibrium(fm.Mechanism("held", [*parts, brake], gravity=(0.0, -G)))
    assert rest.force("brake")[2] == pytest.approx(-R * 5.0 * G, rel=1e-6)
    motor = fm.Revolute("O", fm.GROUND, winch, at=winch.at), fm.Drive("motor", "O", fm.ConstantSpeed(-1.0))
    sol = fm.simulate(fm.Mechanism("lifted", [*parts, *motor], gravity=(0.0, -G)), t_end=1.0)
    assert sol.ok, sol.status
    assert float(sol["live.normal_force"][-1]) == pytest.approx(5.0 * G, rel=1e-3)
    assert float(sol["dead.normal_force"][-1]) == pytest.approx(5.0 * G, rel=1e-3)
    assert float(sol["block.y"][-1]) - float(sol["block.y"][0]) == pytest.approx(0.5 * R, rel=1e-3)


def test_inverse_dynamics_feels_a_taut_cable():
    """A crank draws a cable out by d: torque R cross K d, from its own geometry; it was left out."""
    crank = fm.RigidBody("crank", at=(0.0, 0.0), mass=1.0, inertia=0.01)
    stay = Cable("stay", fm.GROUND, crank, at=(1.0, 0.0), to=(0.0, 0.2), normal=fm.KelvinVoigt(1e4, 0.0))
    mech = fm.Mechanism("drawn", [
        crank, fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)), stay, fm.Drive("motor", "O", fm.ConstantSpeed(1.0)),
    ])  # fmt: skip
    times = np.array([0.0, 0.3, 0.6, 4.5])
    motion = fm.inverse_dynamics(mech, times)
    for t, torque, pin in zip(times, motion.torque("motor"), motion.forces["O"], strict=True):
        point = 0.2 * np.array([-math.sin(t), math.cos(t)])
        d = point - np.array([1.0, 0.0])
        size = float(np.hypot(*d))
        pull = -1e4 * max(size - math.hypot(1.0, 0.2), 0.0) * d / size
        assert torque == pytest.approx(-(point[0] * pull[1] - point[1] * pull[0]), abs=1e-7)
        assert pin[:2] == pytest.approx(-pull, abs=1e-7)


def bumped(**given):
    """A body of 2 kg on a soft bushing under 530 N, with a bump stop of 1e6 N/m."""
    body = fm.RigidBody("body", at=(0.3, 0.4), mass=2.0, inertia=0.01)
    soft = fm.Bushing("rubber", fm.GROUND, body, at=body.at, stiffness=(1e4, 1e4), damping=(300.0, 300.0), torsion=1e4)
    bump = fm.Stop("bump", first=fm.GROUND, second=body, normal=fm.KelvinVoigt(1e6, 300.0, ramp=1e-6), **given)
    return fm.Mechanism("bump", [body, soft, bump, fm.Force("push", body, body.at, (0.0, 530.0))])


@pytest.mark.parametrize("given", [
    {"at": (0.3, 0.4), "along": (0.0, 1.0), "above": 0.01}, {"at": (0.3, 0.0), "to": (0.3, 0.4), "above": 0.01},
    {"at": (0.3, 0.9), "to": (0.3, 0.4), "below": -0.01},
    {"at": (0.3, 0.4), "along": (0.0, -1.0), "above": 0.02, "below": -0.01},
])  # fmt: skip
def test_a_bump_stop_carries_what_the_bushing_does_not(given):
    """k u + K (u - end) = F."""
    mech, end = bumped(**given), 0.01
    u = (530.0 + 1e6 * end) / (1e4 + 1e6)
    sol = fm.simulate(mech, t_end=0.5)
    assert sol.ok, sol.status
    assert float(sol["body.y"][-1]) - 0.4 == pytest.approx(u, rel=1e-5)
    name = "bump.below" if len([k for k in given if k in ("above", "below")]) == 2 else "bump"
    assert float(sol[f"{name}.normal_force"][-1]) == pytest.approx(1e6 * (u - end), rel=1e-4)
    assert float(sol[f"{name}.fy"][-1]) == pytest.approx(-1e6 * (u - end), rel=1e-4)
    assert fm.static_equilibrium(mech)["body.y"] - 0.4 == pytest.approx(u, rel=1e-8)


def test_a_stop_between_bodies_conserves_momentum():
    """Two free bodies meet at a stop along a direction that turns with the first one."""
    one = fm.RigidBody("one", at=(0.0, 0.0), mass=1.0, inertia=0.01, velocity=(1.0, 0.2, 0.5))
    two = fm.RigidBody("two", at=(0.5, 0.1), mass=2.0, inertia=0.03, velocity=(-1.0, 0.1, -0.3))
    bump = fm.Stop("bump", first=one, second=two, at=(0.1, 0.0), to=(0.4, 0.1), along=(1.0, 0.2), below=-0.1,
                   normal=fm.KelvinVoigt(1e5, 0.0))  # fmt: skip
    sol = fm.simulate(fm.Mechanism("meet", [one, two, bump]), t_end=0.2, step=fm.Adaptive(rtol=1e-7))
    assert sol.ok, sol.status
    assert len(sol.episodes("bump")) == 1
    bodies = (("one", 1.0, 0.01), ("two", 2.0, 0.03))

    def total(k):
        value = np.zeros(3)
        for name, m, J in bodies:
            x, y, vx, vy, w = (float(sol[f"{name}.{s}"][k]) for s in ("x", "y", "vx", "vy", "omega"))
            value += [m * vx, m * vy, J * w + m * (x * vy - y * vx)]
        return value

    assert total(-1) == pytest.approx(total(0), abs=1e-8)


def belted_drums():
    """Two drums, both moving, with bodies and offsets of their own."""
    one, two = drum("one", (0.0, 0.0)), drum("two", (0.9, 0.4), angle=0.4)
    return fm.Mechanism("drums", [one, two, Cable(
        "rope", one, two, at=(0.05, 0.02), to=(0.8, 0.5), radii=(0.1, -0.15), normal=LAW, length=0.7)])  # fmt: skip


@pytest.mark.parametrize(("mech", "part"), [
    pytest.param(hoist(1.0), "rope", marks=pytest.mark.slow), (belted_drums(), "rope"),
    (bumped(at=(0.3, 0.4), along=(0.3, 1.0), above=0.01), "bump"),
    pytest.param(bumped(at=(0.1, 0.0), to=(0.3, 0.3), above=0.01, below=-0.02), "bump", marks=pytest.mark.slow),
])  # fmt: skip
def test_contracts(mech, part):
    fm.testing.check_part(mech, part)


def test_wrong_ends_are_refused():
    body = load((0.3, 0.4))
    for given, words in (
        ({}, "give first=, second= and at="),
        ({"joint": "O", "first": fm.GROUND, "second": body, "at": (0.0, 0.0)}, "leave it out"),
        ({"first": fm.GROUND, "second": body}, "give first=, second= and at="),
        ({"first": fm.GROUND, "second": body, "at": (0.3, 0.4)}, "give along=, or another point to="),
    ):
        with pytest.raises(InputError, match=words):
            fm.Stop("bump", above=0.1, normal=LAW, **given)
    with pytest.raises(ModelError, match="stops 'load' against itself"):
        fm.Stop("bump", first=body, second=body, at=(0.3, 0.4), along=(1.0, 0.0), above=0.1, normal=LAW)
    winch = hoist(1.0).find("winch")
    near = Cable("rope", winch, body, at=(0.0, 0.0), to=(0.3, 0.4), radii=(0.6, 0.0), normal=LAW)
    with pytest.raises(ModelError, match="its drums overlap"):
        fm.compile(fm.Mechanism("near", [winch, body, near]))
