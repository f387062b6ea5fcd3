"""Reactions of an equilibrium in words: forces and moments of joints with their units, no constraints within bodies."""

import math

import numpy as np
import pytest

import flexmb as fm


def hung():
    """A plane body with an averaged pin, clamped, with a particle on springs below its end."""
    mesh = fm.meshes.link_with_eyes(0.12, 0.015, 0.008, 0.014, 0.012)
    interface = {"end": "averaged"}
    ends = {"start": (0.0, 0.0), "end": (0.12, 0.0)}
    rod = fm.PlaneBody("rod", mesh, **ends, thickness=0.01, material=fm.STEEL, interface=interface)
    ball = fm.bodies.PointMass("ball", (0.12, -0.1), mass=0.1)
    return [
        rod,
        ball,
        fm.SpringDamper("s", rod, ball, at=(0.12, 0.0), to=(0.12, -0.1), stiffness=1e4),
        fm.SpringDamper("side", fm.GROUND, ball, at=(0.2, -0.1), to=(0.12, -0.1), stiffness=1e4),
    ]


def test_held_rotations_of_particles_and_mesh_nodes_are_no_reactions():
    parts = hung()
    clamp = fm.Fixed("O", fm.GROUND, parts[0], at=(0.0, 0.0))
    pose = fm.static_equilibrium(fm.Mechanism("hung", [*parts, clamp], gravity=(0.0, -9.81)))
    assert list(pose.reactions) == ["O"]
    _, fy, moment = pose.force("O")
    assert repr(pose).splitlines()[1] == f"  reactions: O {fy:.4g} N and {moment:.4g} N m"
    weight = 9.81 * (parts[0].total_mass() + 0.1)
    assert abs(fy / weight - 1.0) < 1e-6


def test_a_joint_without_a_moment_shows_its_force_alone():
    rod = fm.RigidLink("rod", (0.0, 0.0), (0.0, -0.5), mass=2.0, inertia=0.1)
    pin = fm.Revolute("O", fm.GROUND, rod, at=(0.0, 0.0))
    pose = fm.static_equilibrium(fm.Mechanism("pendulum", [rod, pin], gravity=(0.0, -9.81)))
    assert "reactions: O 19.62 N" in repr(pose)
    assert "N m" not in repr(pose)


def held_wheel(*parts):
    """A wheel about the origin on a torsion spring, and other parts."""
    wheel = fm.RigidBody("wheel", at=(0.0, 0.0), mass=2.0, inertia=1.0)
    axis = fm.Revolute("O", fm.GROUND, wheel, at=(0.0, 0.0))
    spring = fm.TorsionSpring("k", fm.GROUND, wheel, stiffness=50.0)
    return fm.static_equilibrium(fm.Mechanism("wheels", [wheel, axis, spring, *(part(wheel) for part in parts)]))


def test_couplings_press_their_second_body():
    """Forces on the second body and no moments of the multiplier: 10 N m at a wheel of 0.2 m are 50 N, once -50 N m."""
    other = fm.RigidBody("other", at=(0.3, 0.0), mass=2.0, inertia=1.0)
    loaded = [lambda _: other, lambda _: fm.Revolute("C", fm.GROUND, other, at=(0.3, 0.0))]
    loaded.append(lambda _: fm.Torque("T", other, 10.0))
    geared = held_wheel(*loaded, lambda wheel: fm.Gear("G", wheel, other, teeth=(10, 20), pressure_angle=0.0))
    assert geared.force("G") == pytest.approx((0.0, 50.0, 0.0), abs=1e-9)
    assert geared.force("G")[:2] == pytest.approx([-force for force in geared.force("C")[:2]], abs=1e-9)
    coupled = held_wheel(*loaded, lambda _: fm.couplings.Coupling("G", {"O": 1.0, "C": 2.0}))
    assert coupled.force("G") == pytest.approx((0.0, 0.0, -10.0))  # once -5

    rack = fm.RigidBody("rack", at=(0.0, 0.1), mass=2.0, inertia=1.0)
    pushed = [lambda _: rack, lambda _: fm.Prismatic("guide", fm.GROUND, rack, along=(1.0, 0.0))]
    pushed.append(lambda _: fm.Force("F", rack, (0.0, 0.1), (10.0, 0.0)))
    toothed = held_wheel(*pushed, lambda wheel: fm.couplings.Rack("R", wheel, rack, at=(0.0, 0.1)))
    slid = held_wheel(*pushed, lambda _: fm.couplings.Coupling("R", {"O": 1.0, "guide": 2.0}))
    for pose, apart in ((toothed, math.tan(math.radians(20.0))), (slid, 0.0)):  # once a moment of 10 and -5 N m
        assert pose.force("R") == pytest.approx((-10.0, 10.0 * apart, 0.0), abs=1e-9)


def test_a_rod_and_a_drive_along_carry_a_weight_by_forces():
    """19.62 N upwards; once moments of -19.62 and 19.62 N m. The drive's force of inverse dynamics stays a number."""
    ball = fm.bodies.PointMass("ball", (0.0, -1.0), 2.0)
    rod = fm.couplings.Distance("held", fm.GROUND, ball, (0.0, 0.0), (0.0, -1.0))
    block = fm.RigidBody("block", at=(0.0, 0.0), mass=2.0, inertia=1.0)
    lift = fm.Drive("held", joint="guide", motion=fm.ConstantSpeed(0.1))
    driven = [block, fm.Prismatic("guide", fm.GROUND, block, along=(0.0, 1.0)), lift]
    for parts in ([ball, rod], driven):
        pose = fm.static_equilibrium(fm.Mechanism("weight", parts, gravity=(0.0, -9.81)))
        assert pose.force("held") == pytest.approx((0.0, 19.62, 0.0), abs=1e-9)
        assert "held 19.62 N" in repr(pose)
        assert "N m" not in repr(pose)
    needed = fm.inverse_dynamics(fm.Mechanism("weight", driven, gravity=(0.0, -9.81)), [0.0])
    assert needed.torque("held") == pytest.approx([19.62])


O, Q, PULL = (0.0, 0.0), (0.048, 0.036), np.array([1.0, -9.81])
MESHES = {
    "outside": (lambda one, two: fm.Gear("mesh", one, two, teeth=(20, 40)), 1 / 3),
    "inside": (lambda one, two: fm.Gear("mesh", one, two, teeth=(20, 40), internal=True), -1.0),
    "belt": (lambda one, two: fm.couplings.Belt("mesh", one, two, radii=(0.02, 0.05)), -2 / 3),
    "tight belt": (lambda one, two: fm.couplings.Belt("mesh", one, two, radii=(0.02, 0.05), pretension=900.0), -2 / 3),
}


@pytest.mark.parametrize("load", [5.0, -5.0])
@pytest.mark.parametrize("held", ["drive", "spring"])
@pytest.mark.parametrize("case", MESHES)
def test_forces_and_moments_on_every_wheel_are_in_balance(case, held, load):
    """Pins, weights and teeth or strands, whose force acts at the pitch point; once teeth pushed nothing apart, and
    pins of wheels that do not move held nothing of that."""
    mesh, along = MESHES[case]
    one, two = (fm.RigidBody(name, at=at, mass=0.5, inertia=1e-3) for name, at in (("one", O), ("two", Q)))
    spring = fm.TorsionSpring("motor", fm.GROUND, one, stiffness=50.0)
    motor = fm.Drive("motor", "O", fm.ConstantSpeed(10.0)) if held == "drive" else spring
    pins = [fm.Revolute(name, fm.GROUND, body, at=at) for name, body, at in (("O", one, O), ("Q", two, Q))]
    parts = [one, two, *pins, mesh(one, two), motor, fm.Torque("load", two, load)]
    mechanism = fm.Mechanism("train", parts, gravity=tuple(PULL))
    pose = fm.static_equilibrium(mechanism)
    found = [(pose.reactions, pose["one.theta"] * -50.0)]
    if held == "drive":
        motion = fm.inverse_dynamics(mechanism, [0.0, 0.1])
        found[0] = pose.reactions, pose.force("motor")[2]
        found += [({name: row[k] for name, row in motion.forces.items()}, motion.torque("motor")[k]) for k in (0, 1)]
    for forces, torque in found:
        first, second, teeth = (np.array(forces[name][:2]) for name in ("O", "Q", "mesh"))
        assert second + teeth + 0.5 * PULL == pytest.approx(0.0, abs=1e-9)
        assert first - teeth + 0.5 * PULL == pytest.approx(0.0, abs=1e-9)
        pitch = along * np.array(Q)
        about_one, about_two = (x * teeth[1] - y * teeth[0] for x, y in (pitch, pitch - Q))
        assert torque - about_one == pytest.approx(0.0, abs=1e-9)
        assert load + about_two == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("load", [10.0, -10.0])
def test_a_rack_and_its_pinion_are_in_balance(load):
    """Teeth of 20 degrees press them apart with .364 of the force along the rack, whichever way it acts."""
    rack = fm.RigidBody("rack", at=(0.0, 0.1), mass=2.0, inertia=1.0)
    pushed = [lambda _: rack, lambda _: fm.Prismatic("guide", fm.GROUND, rack, along=(1.0, 0.0))]
    pushed.append(lambda _: fm.Force("F", rack, (0.0, 0.1), (load, 0.0)))
    pose = held_wheel(*pushed, lambda wheel: fm.couplings.Rack("R", rack=rack, pinion=wheel, at=(0.0, 0.1)))
    x, y, _ = pose.force("R")
    second = np.array([x, y])
    assert abs(y) == pytest.approx(math.tan(math.radians(20.0)) * abs(x), rel=1e-9)
    assert abs(x) == pytest.approx(10.0)
    for sign, pin, other in ((-1.0, "O", (0.0, 0.0)), (1.0, "guide", (load, 0.0))):
        assert sign * second + pose.force(pin)[:2] + other == pytest.approx(0.0, abs=1e-9)
