"""Static equilibrium: what hangs from hinges, what snaps through, what is unstable, what joints say twice."""

import math

import pytest
from scipy.optimize import brentq

import flexmb as fm

STEEL = fm.Material(young=207e9, density=7850.0, poisson=0.3)
ROUND = fm.Circle(0.01)
EI = 207e9 * math.pi * 0.01**4 / 64.0
DOWN = (0.0, -9.81)


def pendulum(end, *more, gravity=DOWN):
    rod = fm.RigidLink("rod", (0.0, 0.0), end, mass=1.0, inertia=0.1)
    return fm.Mechanism(
        "pendulum", (rod, fm.Revolute("O", fm.GROUND, rod, (0.0, 0.0)), *(m(rod) for m in more)), gravity
    )


@pytest.mark.quick(1)
@pytest.mark.parametrize("end", [(0.0, -1.0), (1.0, 0.0), (0.6, -0.8), (0.1, 0.99), (1e-4, 1.0), (-1.0, 1.0)])
def test_a_rigid_pendulum_hangs_down_from_every_pose(end):
    found = fm.static_equilibrium(pendulum(end))
    assert math.sin(found["rod.theta"]) == pytest.approx(-1.0, abs=1e-12)
    assert found.force("O") == pytest.approx((0.0, 9.81, 0.0), abs=1e-9)
    assert found.stable is True


def test_an_upright_pendulum_is_an_equilibrium_that_is_not_stable():
    found = fm.static_equilibrium(pendulum((0.0, 1.0)))
    assert found["rod.theta"] == math.pi / 2
    assert found.stable is False


@pytest.mark.parametrize(("share", "stable"), [(0.999, False), (1.001, True)])
def test_a_spring_holds_an_upright_pendulum_from_k_equal_to_m_g_l(share, stable):
    k = share * 1.0 * 9.81 * 0.5
    held = pendulum((0.0, 1.0), lambda rod: fm.TorsionSpring("k", fm.GROUND, rod, stiffness=k))
    assert fm.static_equilibrium(held).stable is stable


@pytest.mark.slow
def test_a_chain_of_rigid_links_hangs_as_its_statics_say():
    """tan(theta_k) = W (k - (n-1)/2)/H, with H from the span; drawn as a V of straight halves."""
    n, length, half = 20, 0.1, 0.6
    depth = math.hypot(n / 2 * length, 0.0) ** 2 - half**2
    points = [(half * k / (n // 2), -math.sqrt(depth) * (1.0 - abs(1.0 - k / (n // 2)))) for k in range(n + 1)]
    links = [fm.RigidLink(f"l{k}", points[k], points[k + 1], mass=0.2, inertia=1e-4) for k in range(n)]
    chain = [fm.GROUND, *links, fm.GROUND]
    pins = [fm.Revolute(f"J{k}", chain[k], chain[k + 1], points[k]) for k in range(n + 1)]
    found = fm.static_equilibrium(fm.Mechanism("chain", (*links, *pins), gravity=DOWN))
    W = 0.2 * 9.81
    steps = [k - (n - 1) / 2 for k in range(n)]
    H = brentq(lambda H: sum(length * H / math.hypot(H, W * s) for s in steps) - 2 * half, 1e-3, 1e3)
    assert [math.tan(found[f"l{k}.theta"]) for k in range(n)] == pytest.approx([W * s / H for s in steps], abs=1e-10)
    assert found.force("J0")[1] == pytest.approx(W * n / 2, rel=1e-10)
    assert found.stable is True


@pytest.mark.slow
def test_a_pendulum_on_a_spinning_arm_is_held_by_centrifugal_force():
    """J theta'' = -m W^2 R s sin(theta) in the turning frame, J about the pin."""
    arm = fm.RigidLink("arm", (0.0, 0.0), (1.0, 0.0), mass=1.0, inertia=0.1)
    rod = fm.RigidLink("rod", (1.0, 0.0), (1.3, 0.4), mass=1.0, inertia=0.1)
    joints = (fm.Fixed("O", fm.GROUND, arm, (0.0, 0.0)), fm.Revolute("P", arm, rod, (1.0, 0.0)))
    mech = fm.Mechanism("spinning", (arm, rod, *joints))
    found = fm.static_equilibrium(mech, spin=50.0)
    assert found["rod.theta"] == pytest.approx(0.0, abs=1e-9)
    exact = 50.0 / (2 * math.pi) * math.sqrt(1.0 * 1.0 * 0.25 / (0.1 + 0.25**2))
    assert fm.modes(mech, at=found).frequencies[0] == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("load", [(0.0, 0.0), (1.0, 0.0)])
def test_what_no_load_holds_is_refused(load, monkeypatch):
    """A body on a frictionless guide, left alone and pushed along it."""
    monkeypatch.setattr("flexmb.statics.equilibrium.MOST_STRIDES", 60)
    body = fm.RigidBody("body", (0.0, 0.0), mass=1.0, inertia=0.1)
    parts = (body, fm.Prismatic("guide", fm.GROUND, body), fm.Force("F", body, (0.0, 0.0), load))
    with pytest.raises(fm.errors.SolveError, match=r"no static equilibrium: a motion that moves 'body.x' most"):
        fm.static_equilibrium(fm.Mechanism("free", parts, gravity=DOWN))


@pytest.mark.slow
@pytest.mark.parametrize("share", [1.02, 2.0, 6.5, 30.0])
@pytest.mark.parametrize("load_steps", [1, 10])
def test_a_shallow_arch_does_not_snap_through_unseen(share, load_steps):
    """Two pinned bars; the limit is that of von Mises' truss with k = EA/L0, see tests/physics/test_snap_through.py."""
    rise, half = 0.05, 1.0
    length = math.hypot(half, rise)
    area = math.pi * 0.01**2 / 4
    limit = 2.0 * 207e9 * area / length * (length ** (2 / 3) - half ** (2 / 3)) ** 1.5
    left = fm.FlexibleLink("left", (0.0, 0.0), (half, rise), section=ROUND, material=STEEL, elements=1)
    right = fm.FlexibleLink("right", (half, rise), (2 * half, 0.0), section=ROUND, material=STEEL, elements=1)
    pins = [(fm.GROUND, left, left.start), (left, right, left.end), (right, fm.GROUND, right.end)]
    joints = [fm.Revolute(f"J{k}", *pin) for k, pin in enumerate(pins)]
    push = fm.Force("P", left, left.end, (0.0, -share * limit))
    with pytest.raises(fm.errors.SolveError, match="snaps through") as caught:
        fm.static_equilibrium(fm.Mechanism("arch", (left, right, *joints, push)), load_steps)
    carried = float(str(caught.value).split("beyond ")[1].split(" %")[0])
    step = 100.0 / load_steps / 2**8  # the smallest that is tried
    assert 100.0 / share - step - 0.02 * 100.0 / share < carried < 1.02 * 100.0 / share


@pytest.mark.parametrize(("share", "stable"), [(0.99, True), (1.01, False), (8.8, False), (9.2, False)])
def test_a_straight_column_beyond_its_buckling_load_is_called_unstable(share, stable):
    """Euler: P = (pi/2)^2 EI/L^2, and 9 times that for the second shape: two negative directions."""
    column = fm.FlexibleLink("column", (0.0, 0.0), (1.0, 0.0), section=ROUND, material=STEEL, elements=16)
    push = fm.Force("P", column, (1.0, 0.0), (-share * math.pi**2 / 4 * EI, 0.0))
    mech = fm.Mechanism("column", (column, fm.Fixed("clamp", fm.GROUND, column, (0.0, 0.0)), push))
    assert fm.static_equilibrium(mech).stable is stable


def test_a_follower_force_has_no_potential_to_judge_by():
    beam = fm.FlexibleLink("beam", (0.0, 0.0), (1.0, 0.0), section=ROUND, material=STEEL)
    push = fm.Force("P", beam, (1.0, 0.0), (0.0, 10.0), follower=True)
    mech = fm.Mechanism("beam", (beam, fm.Fixed("clamp", fm.GROUND, beam, (0.0, 0.0)), push))
    assert fm.static_equilibrium(mech).stable is None


def test_joints_that_repeat_one_another_are_named(monkeypatch):
    monkeypatch.setattr("flexmb.statics.equilibrium.MOST_STRIDES", 60)
    cranks = [fm.RigidLink(f"c{k}", (k, 0.0), (k + 0.1, -0.5), mass=1.0, inertia=0.02) for k in range(3)]
    rod = fm.RigidLink("rod", cranks[0].end, cranks[2].end, mass=3.0, inertia=1.0)
    pins = [fm.Revolute(f"A{k}", fm.GROUND, c, c.start) for k, c in enumerate(cranks)]
    pins += [fm.Revolute(f"B{k}", c, rod, c.end) for k, c in enumerate(cranks)]
    with pytest.raises(fm.errors.AssemblyError, match=r"there, .*'[AB]\d'.* repeat one another"):
        fm.static_equilibrium(fm.Mechanism("parallel", (*cranks, rod, *pins), gravity=DOWN))


def turning_arm(*more):
    arm = fm.FlexibleLink("arm", (0.0, 0.0), (1.0, 0.0), section=ROUND, material=STEEL)
    return fm.Mechanism("arm", (arm, *(part for make in more for part in make(arm))))


def test_a_travel_at_the_number_of_the_spin_is_not_steady():
    """50 m/s is no 50 rad/s."""
    mech = turning_arm(lambda arm: [fm.Clamp("hub", fm.GROUND, arm, (0.0, 0.0), x=fm.ConstantSpeed(50.0))])
    with pytest.raises(fm.errors.InputError, match=r"drive 'hub.x' moves at 50 and the frame turns at 50 rad/s.*along"):
        fm.static_equilibrium(mech, spin=50.0)


def test_an_arm_that_turns_on_a_turning_arm_is_not_steady():
    def second(arm):
        tip = fm.FlexibleLink("tip", (1.0, 0.0), (2.0, 0.0), section=ROUND, material=STEEL)
        spin = fm.ConstantSpeed(50.0)
        hub = fm.Clamp("hub", fm.GROUND, arm, (0.0, 0.0), angle=spin)
        return [tip, hub, fm.Revolute("P", arm, tip, (1.0, 0.0)), fm.Drive("wrist", joint="P", motion=spin)]

    with pytest.raises(fm.errors.InputError, match=r"drive 'wrist' moves at 50 .*against another body"):
        fm.static_equilibrium(turning_arm(second), spin=50.0)


@pytest.mark.parametrize("reversed_joint", [False, True])
def test_a_hub_turns_at_the_speed_of_the_frame_in_either_order_of_the_joint(reversed_joint):
    def hub(arm):
        first, second = (arm, fm.GROUND) if reversed_joint else (fm.GROUND, arm)
        speed = -50.0 if reversed_joint else 50.0
        return [
            fm.Revolute("O", first, second, (0.0, 0.0)),
            fm.Drive("motor", joint="O", motion=fm.ConstantSpeed(speed)),
        ]

    held = fm.static_equilibrium(turning_arm(lambda arm: [fm.Fixed("O", fm.GROUND, arm, (0.0, 0.0))]), spin=50.0)
    found = fm.static_equilibrium(turning_arm(hub), spin=50.0)
    assert found["arm.end.x"] == pytest.approx(held["arm.end.x"], abs=1e-14)
