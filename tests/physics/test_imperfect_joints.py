"""Where a journal stands at the start; a disc that slides and rolls in a round hollow against its exact equations."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fm
from flexmb.engine.system.state_evaluation import StateEvaluation

G = 9.81
PLAY, BEARING = 1e-3, 0.011


def hanging(start, gravity=(0.0, -G), bearing_on_bar=False):
    """A bar of 0.3 m that hangs straight down from a pin with play."""
    bar = fm.RigidLink("bar", (0.0, 0.0), (0.0, -0.3), 0.8, 6e-3)
    ends = (bar, fm.GROUND) if bearing_on_bar else (fm.GROUND, bar)
    law = fm.contact.ExactRestitution(stiffness=1e9, restitution=0.5, least_approach=1e-3)
    options = {"clearance": PLAY, "bearing_radius": BEARING, "normal": law, "start": start}
    return fm.Mechanism("hanging", (bar, fm.RevoluteClearance("J", *ends, at=(0.0, 0.0), **options)), gravity=gravity)


@pytest.mark.parametrize(
    ("start", "gravity", "expected"),
    [
        ("centred", (0.0, -G), (0.0, 0.0)),
        ("seated", (0.0, -G), (0.0, -PLAY)),
        ("seated", (3.0, 4.0), (0.6 * PLAY, 0.8 * PLAY)),
        ((0.3 * PLAY, -0.4 * PLAY), (0.0, -G), (0.3 * PLAY, -0.4 * PLAY)),
        ((0.6 * PLAY, 0.8 * PLAY), (0.0, 0.0), (0.6 * PLAY, 0.8 * PLAY)),
    ],
)
def test_place_and_speed_of_the_journal_at_the_start(start, gravity, expected):
    """As with an ideal joint nothing moves at first; the bar's centre is 0.15 m below its end."""
    sol = fm.simulate(hanging(start, gravity), t_end=1e-3, save=1)
    first = [sol.array(f"J.{name}")[0] for name in ("ex", "ey", "vex", "vey")]
    np.testing.assert_allclose(first, [*expected, 0.0, 0.0], rtol=0, atol=1e-15)
    turned = sol.array("bar.theta")[0]
    end = (sol.array("bar.x")[0] - 0.15 * math.cos(turned), sol.array("bar.y")[0] - 0.15 * math.sin(turned))
    np.testing.assert_allclose(end, expected, rtol=0, atol=1e-15)


def test_a_bearing_hangs_on_a_journal_of_the_ground():
    sol = fm.simulate(hanging("seated", bearing_on_bar=True), t_end=1e-2, save="steps")
    assert sol.array("J.ey")[0] == pytest.approx(PLAY, rel=1e-12)
    assert sol.array("bar.y")[0] == pytest.approx(-0.15 - PLAY, rel=1e-12)
    assert np.abs(np.diff(sol.array("bar.y"))).max() < 1e-6  # it stays there


def test_a_journal_moves_with_a_driven_bearing():
    """A crank turns about O; the eccentricity keeps its axes, and its rate is that of an ideal joint: none."""
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.2, 0.0), 0.5, 1e-3)
    bar = fm.RigidLink("bar", (0.2, 0.0), (0.5, 0.0), 0.8, 6e-3)
    law = fm.contact.ExactRestitution(stiffness=1e9, restitution=0.5)
    e = (0.0, 0.5 * PLAY)
    parts = (
        fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)),
        fm.RevoluteClearance(
            "J", crank, bar, at=(0.2, 0.0), clearance=PLAY, bearing_radius=BEARING, normal=law, start=e
        ),
        fm.Drive("motor", "O", fm.ConstantSpeed(20.0)),
    )
    sol = fm.simulate(fm.Mechanism("m", (crank, bar, *parts)), t_end=1e-4, save="steps")
    np.testing.assert_allclose([sol.array(f"J.{s}")[0] for s in ("ex", "ey", "vex", "vey")], [*e, 0, 0], atol=1e-14)


def test_the_rows_of_the_start_are_those_of_a_pin_but_for_the_place_of_the_journal():
    """So rates, accelerations and forces of what takes the joint for an ideal one are an ideal joint's."""
    worn = hanging((0.3 * PLAY, -0.4 * PLAY))
    ideal = worn.with_part(fm.Revolute("J", fm.GROUND, worn.find("bar"), at=(0.0, 0.0)))
    q, v, lam = np.array([0.1, -0.2, -1.1]), np.array([1.0, 2.0, 3.0]), np.array([5.0, -7.0])
    one, other = (
        StateEvaluation(fm.compile(m, closed=True)).at(q, v, lam=lam, weights=(1.0, 0.0, 0.0)) for m in (worn, ideal)
    )
    np.testing.assert_allclose(one.residual - other.residual, [-0.3 * PLAY, 0.4 * PLAY], atol=1e-16)
    assert abs(one.matrix - other.matrix).max() == 0.0
    np.testing.assert_array_equal(one.gamma, other.gamma)


def test_a_seated_pendulum_hardly_bounces():
    """From rest at the static depth's distance the force may double; from the centre it falls through the play."""
    seated, centred = (fm.simulate(hanging(s), t_end=0.02, save="steps") for s in ("seated", "centred"))
    assert seated.ok, seated.status
    depth = (0.8 * G / 1e9) ** (2 / 3)  # N = K depth^1.5
    # elastic, from rest with the weight W at depth 0: K d^2.5/2.5 = W d, so N = 2.5 W at the most
    assert seated.peak("J.normal_force").value < 2.5 * 0.8 * G
    assert seated.array("J.penetration").min() > -0.02 * depth
    assert centred.peak("J.normal_force").value > 20 * seated.peak("J.normal_force").value
    assert seated.array("J.penetration")[-1] == pytest.approx(depth, rel=0.2)


@pytest.mark.parametrize(
    ("start", "words"),
    [
        ((0.0, 1.5e-3), ["'J'", "0.0005 m outside the clearance of 0.001 m", 'start="seated"']),
        ("seatd", ["'J'", "'seatd'", "Did you mean 'seated'", "(ex, ey)"]),
        ((0.0, math.nan), ["'J'", "start[1]", "finite"]),
        ((1e-4,), ["'J'", "start", "pair"]),
        (3.0, ["'J'", "start", "pair"]),
    ],
)
def test_a_start_that_cannot_be(start, words):
    with pytest.raises(fm.errors.InputError) as error:
        hanging(start)
    for word in words:
        assert word in str(error.value)


def test_seated_without_gravity_is_refused():
    with pytest.raises(fm.errors.InputError, match=r"'J': start is 'seated'.*no gravity.*start=\(ex, ey\)"):
        hanging("seated", gravity=(0.0, 0.0))


# A disc (the journal) of radius R2 in a fixed bearing of radius R1 = R2 + c.
#
# Its centre is at e = c (sin phi, -cos phi), it turns with omega.  Speed of its surface at the contact point:
# c phi' along t = (cos phi, sin phi), and omega k x R2 n with n = (sin phi, -cos phi), which is R2 omega t.
# Slip = c phi' + R2 omega.  Energy m c^2 phi'^2/2 + J omega^2/2 - m g c cos phi.
#   no friction:  c phi'' = -g sin phi,                         small swings w^2 = g/c;
#   no slip:      omega = -c phi'/R2, inertia (m + J/R2^2) c^2, w^2 = g/(c (1 + J/(m R2^2))), homogeneous: g/(1.5 c).

C, R2, MASS = 0.05, 0.02, 0.3
INERTIA = 0.5 * MASS * R2**2
STIFF = 3e10  # the weight presses it in by 2e-7 m, 4e-6 of c
STICKY = fm.friction.LuGre(
    0.6, 0.5, stiffness=1e5, damping=70.0
)  # bristles of 1000 rad/s, damped by sqrt(1/3) of critical


def disc(phi=0.0, spin=0.0, friction=None):
    """Touching the bearing at the angle phi from the bottom, at rest but for `spin`."""
    body = fm.RigidBody("disc", (0.0, 0.0), MASS, INERTIA, velocity=(0.0, 0.0, spin))
    joint = fm.RevoluteClearance(
        "J",
        fm.GROUND,
        body,
        at=(0.0, 0.0),
        clearance=C,
        bearing_radius=C + R2,
        normal=fm.contact.ExactRestitution(stiffness=STIFF, restitution=0.3, least_approach=1e-2),
        friction=friction or fm.friction.Frictionless(),
        start=(C * math.sin(phi), -C * math.cos(phi)),
    )
    return fm.Mechanism("disc", (body, joint), gravity=(0.0, -G))


def swing(sol):
    """Angle of the disc's centre from the bottom, and slip speed of the surfaces."""
    ex, ey, vex, vey, omega = (sol.array(n) for n in ("J.ex", "J.ey", "J.vex", "J.vey", "disc.omega"))
    size = np.hypot(ex, ey)
    return np.arctan2(ex, -ey), (vex * -ey + vey * ex) / size + R2 * omega


def period(sol):
    """Twice the time between the first two passages through the bottom."""
    phi, t = swing(sol)[0], sol.time
    k = np.flatnonzero(phi[1:] * phi[:-1] < 0.0)[:2]
    first, second = t[k] - phi[k] * (t[k + 1] - t[k]) / (phi[k + 1] - phi[k])
    return 2.0 * (second - first)


@pytest.mark.parametrize(("friction", "factor"), [(None, 1.0), (STICKY, 1.5)])
@pytest.mark.parametrize("amplitude", [0.05, 0.5])
def test_period_of_a_disc_that_slides_or_rolls(friction, factor, amplitude):
    """2 pi sqrt(factor c/g), times 1/agm(1, cos(amplitude/2)) of a pendulum."""
    sol = fm.simulate(disc(amplitude, friction=friction), t_end=0.6, save="steps")
    assert sol.ok, sol.status
    mean, other = 1.0, math.cos(0.5 * amplitude)
    while abs(mean - other) > 1e-15:
        mean, other = 0.5 * (mean + other), math.sqrt(mean * other)
    assert period(sol) == pytest.approx(2.0 * math.pi * math.sqrt(factor * C / G) / mean, rel=2e-4)
    phi, slip = swing(sol)
    fastest = 2.0 * math.sqrt(G * C / factor) * math.sin(0.5 * amplitude)  # c phi' at the bottom
    late = sol.time > 0.05
    if friction is None:
        assert np.abs(sol.array("disc.omega")).max() < 1e-13  # the normal force has no lever
        assert np.abs(slip[late]).max() == pytest.approx(fastest, rel=1e-3)
    else:
        assert np.abs(slip[late]).max() < 1e-3 * fastest
        rolled = sol.array("disc.theta") - sol.array("disc.theta")[0]
        np.testing.assert_allclose(rolled, -C / R2 * (phi - amplitude), rtol=0, atol=2e-3 * C / R2 * amplitude)


def sliding(spin, mu):
    """Instant and state (phi, phi', omega) at which a disc released on the bottom begins to roll: the exact equations.

    m c phi'' = -mu N - m g sin phi, J omega' = -mu N R2, N = m (g cos phi + c phi'^2), until c phi' + R2 omega = 0.
    """

    def rates(t, y):
        phi, w, _ = y
        N = MASS * (G * math.cos(phi) + C * w * w)
        return [w, -(mu * N / MASS + G * math.sin(phi)) / C, -mu * N * R2 / INERTIA]

    def slip(t, y):
        return C * y[1] + R2 * y[2]

    slip.terminal = True
    found = solve_ivp(rates, (0.0, 1.0), [0.0, 0.0, spin], events=slip, rtol=1e-11, atol=1e-13)
    return found.t_events[0][0], found.y_events[0][0]


def test_a_spinning_disc_slides_until_it_rolls():
    spin, mu = 20.0, 0.2
    t_roll, state = sliding(spin, mu)
    # a flat track would make it roll after R omega/(3 mu g) with a third of its spin: the bowl is near that
    assert t_roll == pytest.approx(R2 * spin / (3.0 * mu * G), rel=0.1)
    mech = disc(spin=spin, friction=fm.friction.SmoothCoulomb(mu, v0=1e-5))
    sol = fm.simulate(mech, t_end=1.5 * t_roll, save="steps", step=fm.Adaptive(max=1e-4))
    assert sol.ok, sol.status
    _, slip = swing(sol)
    rolling = np.flatnonzero(slip < 1e-3 * R2 * spin)[0]
    assert sol.time[rolling] == pytest.approx(t_roll, rel=3e-3)
    before = np.interp(t_roll, sol.time, swing(sol)[0]), np.interp(t_roll, sol.time, sol.array("disc.omega"))
    assert before == pytest.approx((state[0], state[2]), rel=3e-3)
    assert np.abs(slip[sol.time > 1.02 * t_roll]).max() < 1e-3 * R2 * spin
    # T slip over the sliding phase is what the ledger calls friction
    lost = 0.5 * INERTIA * (spin**2 - state[2] ** 2) - 0.5 * MASS * (C * state[1]) ** 2
    lost -= MASS * G * C * (1.0 - math.cos(state[0]))
    assert sol.array("energy.dissipated_friction")[-1] == pytest.approx(lost, rel=5e-3)


def in_ring(ring_spin, disc_spin, depth):
    """Force (fx, fy, moment) on a disc at the bottom of a ring, both centres at rest, both turning."""
    ring = fm.RigidBody("ring", (0.0, 0.0), 1.0, 4e-3)
    body = fm.RigidBody("disc", (0.0, 0.0), MASS, INERTIA)
    law, rough = fm.contact.Hertz(stiffness=STIFF), fm.friction.SmoothCoulomb(0.3, v0=1e-6)
    options = {"clearance": C, "bearing_radius": C + R2, "normal": law, "friction": rough}
    mech = fm.Mechanism("m", (ring, body, fm.RevoluteClearance("J", ring, body, at=(0.0, 0.0), **options)))
    q = [0.0, 0.0, 0.0, 0.0, -C - depth, 0.0]
    return -StateEvaluation(fm.compile(mech)).at(q, [0.0, 0.0, ring_spin, 0.0, 0.0, disc_spin]).force.reshape(2, 3)


def test_the_slip_contains_the_rotation_of_both_bodies():
    """Wheels in each other do not slip where the speeds of both rims agree at the point of contact."""
    depth = 1e-6
    R1 = C + R2 + 0.5 * depth
    N = STIFF * depth**1.5
    together = 30.0 * R1 / (R2 - 0.5 * depth)
    assert abs(in_ring(30.0, together, depth)[1, 0]) < 1e-6 * N
    for more, sign in ((1.0, -1.0), (-1.0, 1.0)):  # the disc's rim runs ahead, towards +X: friction holds it back
        first, second = in_ring(30.0, together + more, depth)
        np.testing.assert_allclose(second, [sign * 0.3 * N, N, sign * 0.3 * N * (R2 - 0.5 * depth)], rtol=1e-9)
        np.testing.assert_allclose(first, [-sign * 0.3 * N, -N, -sign * 0.3 * N * R1], rtol=1e-9)


def test_a_driven_ring_takes_the_disc_along_until_it_rolls():
    """c phi' + R2 omega = R1 Omega from then on, while the disc swings in the turning ring."""
    turning = 6.0
    ring = fm.RigidBody("ring", (0.0, 0.0), 1.0, 4e-3)
    mech = disc(friction=STICKY)
    joint = replace(mech.find("J"), first=ring)
    parts = (
        ring,
        mech.find("disc"),
        joint,
        fm.Revolute("O", fm.GROUND, ring, at=(0.0, 0.0)),
        fm.Drive("motor", "O", fm.ConstantSpeed(turning)),
    )
    sol = fm.simulate(fm.Mechanism("mill", parts, gravity=(0.0, -G)), t_end=1.0, save="steps")
    assert sol.ok, sol.status
    slip = swing(sol)[1] - (C + R2) * turning
    assert slip[0] == pytest.approx(-(C + R2) * turning, rel=1e-6)
    assert np.abs(slip[sol.time > 0.3]).max() < 1e-3 * (C + R2) * turning
    assert np.ptp(swing(sol)[0][sol.time > 0.3]) > 0.02  # it does swing


def test_friction_turns_a_free_bearing_and_its_journal_without_changing_their_momentum():
    """Both about the common centre of mass, which rests: the spin of one goes into both spins and the orbit."""
    ring = fm.RigidBody("ring", (0.0, 0.0), 1.0, 4e-3, velocity=(-0.09, 0.12, 0.0))
    body = fm.RigidBody("disc", (0.0, 0.0), MASS, INERTIA, velocity=(0.3, -0.4, 150.0))
    law = fm.contact.ExactRestitution(stiffness=1e7, restitution=0.6)
    options = {
        "clearance": 0.01,
        "bearing_radius": 0.01 + R2,
        "normal": law,
        "friction": fm.friction.SmoothCoulomb(0.3, v0=1e-2),
    }
    joint = fm.RevoluteClearance("J", ring, body, at=(0.0, 0.0), start=(4e-3, 3e-3), **options)
    mech = fm.Mechanism("free", (ring, body, joint))
    sol = fm.simulate(mech, t_end=0.06, step=2e-6, method=fm.RungeKutta4(), save=300)
    assert sol.ok, sol.status
    assert np.ptp(sol.array("ring.omega")) > 0.5  # the bearing is turned
    assert sol.array("J.mode").max() >= 1.0
    found = fm.momentum(mech, sol)
    size = INERTIA * 150.0
    assert np.abs(found.angular - found.angular[0]).max() <= 1e-10 * size
    assert np.abs(found.linear - found.linear[0]).max() <= 1e-10 * MASS * 0.5
