"""Reactions of an equilibrium in words: forces and moments of joints with their units, no constraints within bodies."""

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
