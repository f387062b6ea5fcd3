"""Equilibria to which loads move a mechanism, beside those on branches that growing loads do not reach."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import flexmb as fm

STIFFNESS = 50.0  # N m/rad
MODULUS, WIDTH, HEIGHT = fm.STEEL.young, 0.02, 0.005


def pressed(force: float, torque: float) -> fm.Mechanism:
    """An upright rod of 1 m on a torsion spring, under a force on its head and a torque."""
    rod = fm.RigidLink("rod", (0.0, 0.0), (0.0, 1.0), mass=1.0, inertia=0.1)
    spring = fm.TorsionSpring("spring", fm.GROUND, rod, stiffness=STIFFNESS)
    loads = fm.Force("F", rod, at=(0.0, 1.0), force=(0.0, -force)), fm.Torque("T", rod, torque)
    return fm.Mechanism("pressed", [rod, fm.Revolute("O", fm.GROUND, rod, at=(0.0, 0.0)), spring, *loads])


@pytest.mark.quick(2)
@pytest.mark.parametrize("torque", [0.01, -2.0, pytest.param(5.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "force", [30.0, pytest.param(55.0, marks=pytest.mark.slow), 80.0, pytest.param(150.0, marks=pytest.mark.slow)]
)
def test_a_pressed_rod_falls_to_the_side_of_its_torque(force, torque):
    """k theta = F sin theta + T: the branch that begins at rest without loads ends on the side of T."""
    side = math.copysign(1.0, torque)
    angle = side * brentq(lambda x: STIFFNESS * x - force * math.sin(x) - abs(torque), 1e-6, math.pi)
    found = fm.static_equilibrium(pressed(force, torque))
    assert found["rod.theta"] - 0.5 * math.pi == pytest.approx(angle, abs=1e-9)
    assert found.stable


def test_a_pressed_rod_without_torque_stays_upright():
    found = fm.static_equilibrium(pressed(80.0, 0.0))
    assert found["rod.theta"] == 0.5 * math.pi
    assert found.stable is False


@pytest.mark.slow
@pytest.mark.parametrize("lean", [pytest.param(1e-3, marks=pytest.mark.slow), -1e-3, 0.3])
def test_a_leaning_pendulum_on_a_soft_spring_falls_to_its_side(lean):
    head = (math.sin(lean), math.cos(lean))
    rod = fm.RigidLink("rod", (0.0, 0.0), head, mass=1.0, inertia=0.1)
    parts = [fm.Revolute("O", fm.GROUND, rod, at=(0.0, 0.0)), fm.TorsionSpring("k", fm.GROUND, rod, stiffness=1.0)]
    found = fm.static_equilibrium(fm.Mechanism("leaning", [rod, *parts], gravity=(0.0, -9.81)))
    turned = 0.5 * math.pi - found["rod.theta"]  # clockwise from upright
    assert turned - lean == pytest.approx(0.5 * 9.81 * math.sin(turned), abs=1e-9)
    assert turned * lean > 0.0
    assert found.stable


def sag(load: float, across: float) -> float:
    """Movement to the side of the head of a column of 1 m, by its elastica: EI theta'' = -P sin theta - H cos theta."""
    bending = MODULUS * WIDTH * HEIGHT**3 / 12.0

    def shot(slope):
        def rates(_, y):
            return y[1], -(load * math.sin(y[0]) + across * math.cos(y[0])) / bending, math.sin(y[0])

        return solve_ivp(rates, (0.0, 1.0), (0.0, slope, 0.0), rtol=1e-10, atol=1e-12).y[:, -1]

    slopes = np.linspace(8.0, 0.01, 81)  # the largest one belongs to the column that is bent to one side
    ends = [shot(slope)[1] for slope in slopes]
    k = next(k for k in range(80) if ends[k] > 0.0 >= ends[k + 1])
    return float(shot(brentq(lambda slope: shot(slope)[1], slopes[k + 1], slopes[k], xtol=1e-10))[2])


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("factor", "across"),
    [
        (0.8, 1.0),
        (1.2, 1.0),
        pytest.param(1.5, 0.01, marks=pytest.mark.slow),
        (2.0, 1.0),
        pytest.param(3.0, 1.0, marks=pytest.mark.slow),
    ],
)
def test_a_column_bends_to_the_side_of_a_small_load(factor, across):
    euler = math.pi**2 / 4.0 * MODULUS * WIDTH * HEIGHT**3 / 12.0
    section = fm.Rectangle(WIDTH, HEIGHT)
    column = fm.FlexibleLink("c", (0.0, 0.0), (0.0, 1.0), section=section, material=fm.STEEL, elements=12)
    parts = [column, fm.Fixed("foot", fm.GROUND, column, at=(0.0, 0.0))]
    load = fm.Force("P", column, at=(0.0, 1.0), force=(across, -factor * euler))
    found = fm.static_equilibrium(fm.Mechanism("column", [*parts, load]))
    assert found["c.end.x"] == pytest.approx(sag(factor * euler, across), rel=2e-3)
    assert found.stable


@pytest.mark.slow
@pytest.mark.parametrize("angle", [-0.5 * math.pi, -1.5, -1.2, -0.8, 0.3])
def test_a_hanging_particle_is_found_wherever_it_was_drawn(angle):
    """A particle on a rod without mass hangs straight down: sqrt(g/l) / 2 pi."""
    bob = fm.bodies.PointMass("bob", at=(math.cos(angle), math.sin(angle)), mass=1.0)
    rod = fm.couplings.Distance("rod", fm.GROUND, bob, at=(0.0, 0.0), to=bob.at)
    mechanism = fm.Mechanism("hanging", [bob, rod], gravity=(0.0, -9.81))
    found = fm.static_equilibrium(mechanism)
    assert (found["bob.x"], found["bob.y"]) == (pytest.approx(0.0, abs=1e-9), pytest.approx(-1.0, abs=1e-12))
    frequency = math.sqrt(9.81) / (2.0 * math.pi)
    assert fm.modes(mechanism, at=found).frequencies == pytest.approx([frequency], rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("tilt", [0.0, 0.1, 0.3, 0.7])
def test_a_load_on_a_trolley_hangs_straight_down(tilt):
    at = (math.sin(tilt), -math.cos(tilt))
    trolley = fm.RigidBody("trolley", at=(0.0, 0.0), mass=2.0, inertia=0.1)
    load = fm.bodies.PointMass("load", at=at, mass=1.0)
    parts = [
        fm.Prismatic("rail", fm.GROUND, trolley, along=(1.0, 0.0)),
        fm.SpringDamper("spring", fm.GROUND, trolley, at=(-1.0, 0.0), to=(0.0, 0.0), stiffness=100.0),
        fm.couplings.Distance("rope", trolley, load, at=(0.0, 0.0), to=at),
    ]
    mechanism = fm.Mechanism("crane", [trolley, load, *parts], gravity=(0.0, -9.81))
    found = fm.static_equilibrium(mechanism)
    assert found["load.x"] == pytest.approx(found["trolley.x"], abs=1e-9)
    # two freedoms, x of the trolley and of the load: (k + m g/l - 2 w^2)(m g/l - w^2) = (m g/l)^2
    squares = np.linalg.eigvals(np.diag([0.5, 1.0]) @ np.array([[109.81, -9.81], [-9.81, 9.81]]))
    frequencies = np.sort(np.sqrt(squares)) / (2.0 * math.pi)
    assert fm.modes(mechanism, at=found).frequencies == pytest.approx(frequencies, rel=1e-6)


def test_a_free_trolley_under_a_falling_rod_is_refused():
    """The rod would come to rest hanging, but nothing holds the trolley anywhere."""
    trolley = fm.RigidBody("trolley", at=(0.0, 0.0), mass=2.0, inertia=0.1)
    rod = fm.RigidLink("rod", (0.0, 0.0), (math.sin(0.1), math.cos(0.1)), mass=1.0, inertia=0.1)
    parts = [
        fm.Prismatic("rail", fm.GROUND, trolley, along=(1.0, 0.0)),
        fm.Revolute("pin", trolley, rod, at=(0.0, 0.0)),
        fm.TorsionSpring("spring", trolley, rod, stiffness=1.0),
    ]
    with pytest.raises(fm.errors.SolveError, match="resisted by nothing"):
        fm.static_equilibrium(fm.Mechanism("free", [trolley, rod, *parts], gravity=(0.0, -9.81)))
