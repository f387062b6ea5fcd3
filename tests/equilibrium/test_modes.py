"""Rigid motions by name, slow modes beside stiff ones, damping, the sparse solver, and what `print` shows."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import flexmb as fm
from flexmb.errors import InputError
from flexmb.statics import eigen

STEEL = fm.Material(young=2.0e11, density=7850.0)
FLAT = fm.Rectangle(width=0.02, height=0.008)


def rod(name="rod", start=(0.0, 0.0), end=(0.48, 0.64), elements=8, section=FLAT, **options):
    return fm.FlexibleLink(name, start, end, section=section, material=STEEL, elements=elements, **options)


@pytest.fixture(params=["dense", "sparse"])
def solver(request, monkeypatch):
    """Both solvers, on the same models."""
    if request.param == "sparse":
        monkeypatch.setattr(eigen, "DENSE_COORDINATES", 0)
        monkeypatch.setattr(eigen, "DENSE_QUADRATIC_COORDINATES", 0)
    return request.param


def test_three_rigid_motions_of_a_free_beam(solver):
    found = fm.modes(fm.Mechanism("free", [rod()]), count=6)
    assert found.rigid == 3
    assert found.kinds[:3] == (
        "rigid: translation in x of 'rod'",
        "rigid: translation in y of 'rod'",
        "rigid: rotation of 'rod'",
    )
    assert found.kinds[3:] == ("elastic",) * 3
    assert list(found.frequencies[:3]) == [0.0, 0.0, 0.0]
    # cos z cosh z = 1: z = 4.7300407; a cubic element of z/8 overrates by (z/8)^4/1440 = 8.5e-5
    exact = 4.730040744863**2 / (2 * math.pi) * math.sqrt(2e11 * 0.008**2 / 12 / 7850.0) / 0.8**2
    assert found.frequencies[3] == pytest.approx(exact, rel=1e-4)


def test_shapes_are_orthonormal_in_the_mass(solver):
    """Rigid ones included; the mass matrix is taken from the kinetic energy of the program itself."""
    from flexmb.engine.system.state_evaluation import StateEvaluation

    program = fm.compile(fm.Mechanism("free", [rod()]))
    M = StateEvaluation(program).mass(program.reference.q)
    shapes = fm.modes(fm.Mechanism("free", [rod()]), count=8).shapes
    np.testing.assert_allclose(shapes.T @ (M @ shapes), np.eye(8), atol=1e-8)


def test_rigid_motions_of_two_pinned_bodies_in_free_flight():
    """Four of them: 6 coordinates of two bodies less 2 rows."""
    first, second = rod(), fm.RigidLink("arm", (0.0, 0.0), (-0.3, 0.0), 1.0, 1e-2)
    found = fm.modes(fm.Mechanism("pair", [first, second, fm.Revolute("J", first, second, at=(0.0, 0.0))]), count=6)
    assert found.rigid == 4
    assert found.kinds[:2] == ("rigid: translation in x of 'rod', 'arm'", "rigid: translation in y of 'rod', 'arm'")
    assert all(kind.startswith("rigid: rotation of") for kind in found.kinds[2:4])
    assert found.frequencies[4] > 1.0


def test_a_slider_moves_along_its_guide():
    body = fm.RigidBody("block", (1.0, 2.0), mass=1.0, inertia=1.0)
    guide = fm.Prismatic("guide", fm.GROUND, body, along=(3.0, 4.0))
    found = fm.modes(fm.Mechanism("block", [body, guide]))
    assert found.kinds == ("rigid: translation along (0.6, 0.8) of 'block'",)


@pytest.mark.parametrize("stiffness", [1e-3, 1e-1, 1e1])
def test_a_slow_mode_of_a_stiff_model_is_no_rigid_motion(stiffness, solver):
    """A steel beam (EA/h = 3e8 N/m, fastest mode 1e5 Hz) on a soft hinge, the other end free.

    Exact: z (sin z cosh z - cos z sinh z) = (k L/EI) (1 + cos z cosh z), omega = z^2 sqrt(EI/(m L^4)).
    Round-off of the stiffness is worth some 1e-16 EA L^2/h = 2e-8 N m.
    """
    beam = rod()
    spring = fm.TorsionSpring("k", fm.GROUND, beam, stiffness=stiffness, at=(0.0, 0.0))
    found = fm.modes(fm.Mechanism("hinged", [beam, fm.Revolute("O", fm.GROUND, beam, at=(0.0, 0.0)), spring]), count=2)
    bending, line = 2e11 * 0.02 * 0.008**3 / 12, 7850.0 * 0.02 * 0.008
    soft = stiffness * 0.8 / bending

    def equation(z):
        s, c, sh, ch = math.sin(z), math.cos(z), math.sinh(z), math.cosh(z)
        return z * (s * ch - c * sh) - soft * (1.0 + c * ch)

    z = brentq(equation, 1e-3, 1.0, xtol=1e-14)
    assert found.rigid == 0
    assert found.kinds == ("elastic", "elastic")
    exact = z**2 * math.sqrt(bending / (line * 0.8**4)) / (2 * math.pi)
    assert found.frequencies[0] == pytest.approx(exact, rel=1e-6 + 1e-7 / stiffness)


def test_without_the_spring_the_hinged_beam_is_free():
    beam = rod()
    found = fm.modes(fm.Mechanism("hinged", [beam, fm.Revolute("O", fm.GROUND, beam, at=(0.0, 0.0))]), count=2)
    assert found.kinds == ("rigid: rotation of 'rod'", "elastic")


def test_what_the_stiffness_cannot_resolve_is_said():
    """A spring of 1e-6 N m, twenty times the round-off of the beam's stiffness matrix, against 1e-16 EA L^2/h."""
    beam = rod()
    spring = fm.TorsionSpring("k", fm.GROUND, beam, stiffness=1e-6, at=(0.0, 0.0))
    found = fm.modes(fm.Mechanism("hinged", [beam, fm.Revolute("O", fm.GROUND, beam, at=(0.0, 0.0)), spring]), count=2)
    assert found.kinds == ("not resolved", "elastic")


def test_many_coordinates_take_the_sparse_solver():
    """512 elements have 1539 coordinates; three rigid motions, and the frequency of the exact beam."""
    found = fm.modes(fm.Mechanism("free", [rod(elements=512)]), count=5)
    assert len(found.names) > eigen.DENSE_COORDINATES
    assert found.rigid == 3
    assert list(found.frequencies[:3]) == [0.0, 0.0, 0.0]
    exact = 4.730040744863**2 / (2 * math.pi) * math.sqrt(2e11 * 0.008**2 / 12 / 7850.0) / 0.8**2
    assert found.frequencies[3] == pytest.approx(exact, rel=1e-5)


def test_two_free_bodies_with_very_different_masses_and_stiffness():
    heavy = fm.RigidBody("anvil", (5.0, 5.0), mass=1e6, inertia=1e6)
    found = fm.modes(fm.Mechanism("both", [rod(), heavy]), count=8)
    assert found.rigid == 6
    assert {kind.split("of ")[1] for kind in found.kinds[:6]} == {"'rod'", "'anvil'"}
    assert found.kinds[6:] == ("elastic", "elastic")


def test_an_upside_down_pendulum_on_a_weak_spring_is_unstable():
    """omega^2 = -(m g s - k)/J: it falls with exp(|omega| t)."""
    bar = fm.RigidLink("bar", (0.0, 0.0), (0.0, 1.0), 2.0, 0.3)
    hinge, spring = (
        fm.Revolute("O", fm.GROUND, bar, at=(0.0, 0.0)),
        fm.TorsionSpring("k", fm.GROUND, bar, stiffness=4.0),
    )
    inverted = fm.Mechanism("inverted", [bar, hinge, spring], gravity=(0.0, -10.0))
    found = fm.modes(inverted, at=fm.static_equilibrium(inverted, load_steps=1))
    growth = math.sqrt((2.0 * 10.0 * 0.5 - 4.0) / (0.3 + 2.0 * 0.25))
    assert found.kinds == ("unstable",)
    assert found.frequencies[0] == pytest.approx(-growth / (2 * math.pi), rel=1e-12)
    assert found.eigenvalues[0] == pytest.approx(growth, rel=1e-12)
    assert found.damping[0] == -1.0


@pytest.mark.parametrize(
    ("damping", "kind"), [(0.0, "back to unstable"), (1.0, "back to unstable"), (10.0, "overdamped")]
)
def test_what_falls_back_to_an_unstable_pose(damping, kind):
    """J s^2 + d s - (m g h - k) = 0 with J = 0.8, m g h - k = 6: at 10 N m s the damper outweighs the stiffness."""
    bar = fm.RigidLink("bar", (0.0, 0.0), (0.0, 1.0), 2.0, 0.3)
    hinge = fm.Revolute("O", fm.GROUND, bar, at=(0.0, 0.0))
    spring = fm.TorsionSpring("k", fm.GROUND, bar, stiffness=4.0, damping=damping)
    inverted = fm.Mechanism("inverted", [bar, hinge, spring], gravity=(0.0, -10.0))
    found = fm.modes(inverted, at=fm.static_equilibrium(inverted), damped=True)
    np.testing.assert_allclose(sorted(found.eigenvalues.real), sorted(np.roots([0.8, damping, -6.0])), rtol=1e-9)
    assert dict(zip(found.eigenvalues.real > 0.0, found.kinds, strict=True)) == {True: "unstable", False: kind}


@pytest.mark.parametrize(("damping", "kind"), [(0.4, "elastic"), (50.0, "overdamped")])
def test_damping_of_one_degree_of_freedom(damping, kind, solver):
    """m x'' + d x' + k x = 0: s = -d/2m +- sqrt((d/2m)^2 - k/m)."""
    body = fm.RigidBody("block", (1.0, 0.0), mass=2.0, inertia=1.0)
    parts = [
        body,
        fm.RigidBody("ballast", (3.0, 0.0), mass=1.0, inertia=1.0),
        fm.Prismatic("guide", fm.GROUND, body),
        fm.SpringDamper("k", fm.GROUND, body, (0.0, 0.0), (1.0, 0.0), stiffness=50.0, damping=damping),
    ]
    if solver == "sparse":
        # the iteration needs more coordinates than it is asked for: a beam clamped beside the block
        beam = rod()
        parts[1:2] = [beam, fm.Fixed("clamp", fm.GROUND, beam, at=(0.0, 0.0))]
    else:
        del parts[1]
    found = fm.modes(fm.Mechanism("block", parts), count=1, damped=True)
    roots = np.roots([2.0, damping, 50.0])
    lowest = min(roots, key=lambda s: (abs(s), -s.imag))
    assert found.kinds[0] == kind
    assert found.eigenvalues[0] == pytest.approx(complex(lowest.real, abs(lowest.imag)), rel=1e-10)
    assert found.damping[0] == pytest.approx(-lowest.real / abs(lowest), rel=1e-10)
    assert found.frequencies[0] == pytest.approx(abs(lowest.imag) / (2 * math.pi), rel=1e-10, abs=1e-9)


def test_stiffness_proportional_damping_of_a_free_beam():
    """xi = zeta2 omega/2 (Clough, Penzien); rigid motions stay rigid."""
    zeta = 1e-5
    still = fm.modes(fm.Mechanism("free", [rod()]), count=7)
    found = fm.modes(fm.Mechanism("free", [rod(damping=zeta)]), count=7, damped=True)
    assert found.kinds == still.kinds
    omega = 2 * math.pi * still.frequencies[3:]
    np.testing.assert_allclose(found.damping[3:], zeta * omega / 2, rtol=1e-7)
    np.testing.assert_allclose(np.abs(found.eigenvalues[3:]), omega, rtol=1e-9)


@pytest.mark.parametrize("elements", [8, 32])
def test_a_free_motion_that_a_damper_acts_on(elements):
    """A hinged beam on a torsion damper d: s = 0 and s = -d/J, J = m L^2/3, the beam hardly bent by it."""
    beam = rod(elements=elements)
    damper = fm.TorsionSpring("d", fm.GROUND, beam, stiffness=0.0, damping=1e-3, at=(0.0, 0.0))
    hinge = fm.Revolute("O", fm.GROUND, beam, at=(0.0, 0.0))
    found = fm.modes(fm.Mechanism("hinged", [beam, hinge, damper]), count=3, damped=True)
    inertia = 7850.0 * 0.02 * 0.008 * 0.8 * 0.8**2 / 3.0
    assert found.eigenvalues[0] == 0.0
    assert found.eigenvalues[1] == pytest.approx(-1e-3 / inertia, rel=1e-6)
    assert found.kinds == ("rigid: rotation of 'rod'", "overdamped", "elastic")


def test_the_table_says_what_moves():
    text = str(fm.modes(fm.Mechanism("free", [rod()]), count=4))
    lines = text.splitlines()
    assert lines[0].split() == ["mode", "frequency", "[Hz]", "damping", "kind", "moves", "most"]
    assert "rigid: rotation of 'rod'" in lines[3]
    assert lines[4].split()[-1] in {"rod.node0.theta", "rod.node8.theta"}


def test_equilibrium_of_another_model():
    """Other coordinates, and the same coordinates with other properties."""

    def hanging(section, name="rod"):
        beam = rod(name, section=section, elements=4)
        return fm.Mechanism("hanging", [beam, fm.Fixed("clamp", fm.GROUND, beam, at=(0.0, 0.0))], (0.0, -9.81))

    at = fm.static_equilibrium(hanging(FLAT))
    assert fm.modes(hanging(FLAT), at=at).rigid == 0
    with pytest.raises(InputError, match=r"has a coordinate 'rod.node0.x', the model has none. Use its own"):
        fm.modes(hanging(FLAT, "other"), at=at)
    with pytest.raises(InputError, match=r"is none of mechanism 'hanging'.*'rod.node4.theta'.*same mechanism"):
        fm.modes(hanging(fm.Rectangle(width=0.02, height=0.004)), at=at)
    with pytest.raises(InputError, match=r"has 15 coordinates, the model 27"):
        fm.modes(fm.Mechanism("free", [rod()]), at=at)
