"""Motions of reduced bodies: rigid ones without force, momenta and energies kept, bodies that they stand for."""

import math

import numpy as np
import pytest
from cases import slow_where
from spin_up import spinning_beam

import flexmb as fm

STEEL = fm.Material(young=2.1e11, density=7850.0, poisson=0.3)
SOFT = fm.Material(young=2e9, density=1000.0, poisson=0.3)
BAR = fm.Rectangle(width=0.01, height=0.02)


def rod(material=STEEL, elements=16, **options):
    return fm.FlexibleLink("rod", (0.0, 0.0), (1.0, 0.0), section=BAR, material=material, elements=elements, **options)


def arc():
    return fm.FlexibleLink("rod", (0.0, 0.0), (0.6, 0.8), section=BAR, material=SOFT, elements=8, turn=1.2)


def frame(material=SOFT):
    points, edges = ((0.0, 0.0), (1.0, 0.0), (0.4, 0.7)), ((0, 1), (1, 2), (2, 0))
    return fm.FlexibleFrame("rod", points, edges, section=BAR, material=material, elements=3)


BODIES = {
    "chord": lambda **o: fm.Reduced(rod(SOFT, 6, **o), modes=3),
    "pin": lambda **o: fm.Reduced(rod(SOFT, 6, **o), modes=3, frame="pin"),
    "one pin": lambda **o: fm.Reduced(rod(SOFT, 6, **o), modes=3, pins=("start",)),
    "shapes of inertia": lambda **o: fm.Reduced(rod(SOFT, 8, **o), modes=3, inertia_shapes=True),
    "arc": lambda **o: fm.Reduced(arc(), modes=3, frame="pin", inertia_shapes=True),
    "frame of three pins": lambda **o: fm.Reduced(frame(), modes=3),
}


def turned(body, angle, shift):
    """Coordinates of a body turned and shifted as a rigid one."""
    c, s = math.cos(angle), math.sin(angle)
    poses = [(c * n.x - s * n.y + shift[0], s * n.x + c * n.y + shift[1], n.theta + angle) for n in body.nodes()]
    return np.array(poses).ravel()


@pytest.mark.parametrize("kind", BODIES)
@pytest.mark.parametrize("angle", slow_where(lambda angle: angle != 2.0, [0.0, 2.0, -3.1, 2000.0 * math.pi + 1.0]))
def test_a_turned_body_is_unstressed(kind, angle):
    """Forces of 1 m of stretch are the scale; angles of 1000 turns have 13 digits left."""
    body = BODIES[kind]()
    (element, *_) = body.contributions(fm.Mechanism("alone", [body]))
    q = turned(body, angle, (0.3, -2.0))
    r, zero, p = np.zeros(len(q)), np.zeros(len(q)), np.array(element.p)
    element.force.dispatcher(freeze(p), 0.0, 0.0, q, zero, zero, freeze(np.zeros(0)), r, np.zeros(0))
    assert np.abs(r).max() <= 1e-12 * (1.0 + abs(angle)) * np.abs(body.element.matrices["K"]).max()


def freeze(values):
    values.setflags(write=False)
    return values


def drifts(kind, step):
    """Largest changes of both momenta of a body that was thrown by a blow, over their sizes; energy lost, relative."""
    body = BODIES[kind]()
    blow = fm.Force("blow", body, at=(0.0, 0.0), force=(0.5, 2.0), history=fm.drives.Pulse(end=0.1))
    mechanism = fm.Mechanism("free", [body, blow])
    sol = fm.simulate(mechanism, t_end=0.4, step=step, save=50, method=fm.Newmark.trapezoidal())
    assert sol.ok, sol.status
    found, after = fm.momentum(mechanism, sol), sol.time > 0.11
    late = [(m[after], np.abs(m).max()) for m in (*found.linear.T, found.angular)]
    energy = sol.array("energy.residual")[after]
    kinetic = np.abs(sol.array("energy.kinetic")).max()
    return *(np.abs(m - m[0]).max() / size for m, size in late), np.abs(energy - energy[0]).max() / kinetic


@pytest.mark.quick(1)
@pytest.mark.parametrize("kind", slow_where(lambda n: n in ("shapes of inertia", "arc", "pin"), BODIES))
def test_a_free_body_keeps_its_momenta_and_its_energy(kind):
    """Up to the error of the integrator, which falls with the square of the step."""
    step = {"shapes of inertia": 1e-5, "pin": 2e-5, "arc": 2.5e-5}.get(kind, 4e-5)  # axial vibrations have 2 to 3 kHz
    coarse, fine = (np.array(drifts(kind, h)) for h in (step, 0.25 * step))
    assert np.all(coarse < 1e-3)
    assert np.all((fine < 0.2 * coarse) | (fine < 1e-10))


def tip(sol, length):
    """Deflection of the tip across the hub's direction [m]."""
    x, y, angle = sol.array("beam.end.x"), sol.array("beam.end.y"), sol.array("hub.angle")
    return np.cos(angle) * y - np.sin(angle) * x


@pytest.fixture(scope="module")
def spun():
    """Largest deflection of the spin-up beam of eight elements, by all its nodes."""
    return tip(fm.simulate(spinning_beam(), t_end=16.0), 10.0).min()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "within"),
    [({"frame": "pin"}, 0.005), ({}, 5e-4), pytest.param({"inertia_shapes": True}, 5e-4, marks=pytest.mark.slow)],
)
def test_spin_up_is_that_of_the_beam(spun, options, within):
    mechanism = spinning_beam()
    small = fm.Reduced(mechanism.find("beam"), modes=3, **options)
    sol = fm.simulate(mechanism.with_part(small), t_end=16.0)
    assert sol.ok, sol.status
    assert tip(sol, 10.0).min() == pytest.approx(spun, rel=within)


def test_spin_up_without_stiffening_runs_away():
    mechanism = spinning_beam()
    small = fm.Reduced(mechanism.find("beam"), modes=3, frame="pin", stiffening=False)
    sol = fm.simulate(mechanism.with_part(small), t_end=16.0)
    assert not sol.ok
    assert tip(sol, 10.0).min() < -5.0


def held(body, *more):
    return fm.Mechanism("held", [body, fm.Fixed("clamp", fm.GROUND, body, at=(0.0, 0.0)), *more])


@pytest.mark.parametrize("modes", [3, 12])
def test_shortening_leaves_the_amplitudes_of_modes_alone(modes):
    """More modes do not lead away from the beam: the frame of the chord used to be off by 0.7 and 0.9 %."""
    mechanism = spinning_beam()
    small = fm.Reduced(mechanism.find("beam"), modes=modes)
    sol = fm.simulate(mechanism.with_part(small), t_end=8.0)
    assert tip(sol, 10.0).min() == pytest.approx(-0.5738, rel=1e-3)


@pytest.mark.parametrize("frame_of", ["chord", "pin"])
def test_columns_buckle_at_eulers_load(frame_of):
    small = fm.Reduced(rod(), modes=3, frame=frame_of)
    push = fm.Force("push", small, at=(1.0, 0.0), force=(-1.0, 0.0))
    euler = math.pi**2 * 2.1e11 * 0.01 * 0.02**3 / 12.0 / 4.0
    assert fm.buckling(held(small, push)).factors[0] == pytest.approx(euler, rel=2e-4)


@pytest.mark.slow
@pytest.mark.parametrize("angle", [0.0, 0.5, 0.5 * math.pi, -2.0])
@pytest.mark.parametrize("pins", [None, ("start",)])
def test_the_direction_of_a_body_does_not_matter(angle, pins):
    """Frequencies of a cantilever whose frame is that of its first pin."""
    c, s = math.cos(angle), math.sin(angle)
    link = fm.FlexibleLink("rod", (0.0, 0.0), (c, s), section=BAR, material=STEEL, elements=16)
    small = fm.Reduced(link, modes=6, frame="pin", pins=pins)
    euler = 1.8751041**2 * math.sqrt(2.1e11 * 0.02**2 / 12.0 / 7850.0) / (2.0 * math.pi)
    assert fm.modes(held(small)).frequencies[0] == pytest.approx(euler, rel=1e-5)


HEAVY = 7.837347 * 2.1e11 * 0.02**3 * 0.01 / 12.0 / (7850.0 * 0.01 * 0.02)
"""Gravity under which a clamped column of 1 m buckles by its own weight, q L^3 = 7.837347 EI (Greenhill) [m/s^2]."""


@pytest.mark.parametrize(
    ("options", "factor", "within"),
    [
        ({}, 1.08, 0.01),
        pytest.param({"inertia_shapes": True}, 1.0, 2e-3, marks=pytest.mark.slow),
        ({"inertia_shapes": True, "frame": "pin"}, 1.0, 2e-3),
    ],
)
def test_a_heavy_column_needs_shapes_of_inertia(options, factor, within):
    """Forces of the pins alone spread half of the weight over the length: 8 % too much."""
    column = fm.FlexibleLink("rod", (0.0, 0.0), (0.0, 1.0), section=BAR, material=STEEL, elements=16)
    small = fm.Reduced(column, modes=3, **options)
    clamp = fm.Fixed("clamp", fm.GROUND, small, at=(0.0, 0.0))
    standing = fm.Mechanism("column", [small, clamp], gravity=(0.0, -1.0))
    assert fm.buckling(standing).factors[0] / HEAVY == pytest.approx(factor, rel=within)


@pytest.mark.slow
def test_a_hanging_rod_is_stiffened_by_its_weight():
    """A thin rod of 2 m on a hinge: its pins alone are off by 1.5 % in the second frequency."""
    rod = fm.FlexibleLink(
        "rod", (0.0, 0.0), (0.0, -2.0), section=fm.Rectangle(width=0.01, height=0.002), material=STEEL, elements=24
    )

    def frequencies(body):
        hinge = fm.Revolute("hinge", fm.GROUND, body, at=(0.0, 0.0))
        hanging = fm.Mechanism("hanging", [body, hinge], gravity=(0.0, -9.81))
        return fm.modes(hanging, at=fm.static_equilibrium(hanging)).frequencies[:3]

    full = frequencies(rod)
    assert frequencies(fm.Reduced(rod, modes=6, inertia_shapes=True)) == pytest.approx(full, rel=1e-4)
    assert frequencies(fm.Reduced(rod, modes=6))[1] == pytest.approx(full[1] * 0.9856, rel=1e-3)


@pytest.mark.quick(1)
@pytest.mark.parametrize("frame_of", ["chord", "pin"])
def test_a_beam_on_a_turning_disc_needs_shapes_of_inertia(frame_of):
    """A hub of radius L/2 that starts to turn: (omega^2 - omega_0^2)/Omega^2 of the first frequency."""

    def stiffened(body):
        hub = fm.Clamp("hub", fm.GROUND, body, at=(0.5, 0.0), angle=fm.ConstantSpeed(5.0))
        turning = fm.Mechanism("turning", [body, hub])
        still, fast = (fm.modes(turning, at=fm.static_equilibrium(turning, spin=s)).frequencies[0] for s in (0.0, 5.0))
        return (fast**2 - still**2) * (2.0 * math.pi / 5.0) ** 2

    link = fm.FlexibleLink("rod", (0.5, 0.0), (1.5, 0.0), section=BAR, material=STEEL, elements=16)
    full = stiffened(link)
    assert stiffened(fm.Reduced(link, modes=6, inertia_shapes=True, frame=frame_of)) == pytest.approx(full, rel=0.01)
    assert abs(stiffened(fm.Reduced(link, modes=6, frame=frame_of)) / full - 1.0) > 0.02


def test_a_turning_beam_has_the_frequencies_of_all_its_nodes():
    """100 rad/s; without stiffening the first one would be 5.1 in place of 18.0 Hz."""

    def frequencies(body):
        hub = fm.Clamp("hub", fm.GROUND, body, at=(0.0, 0.0), angle=fm.ConstantSpeed(100.0))
        turning = fm.Mechanism("turning", [body, hub])
        return fm.modes(turning, at=fm.static_equilibrium(turning, spin=100.0)).frequencies[:3]

    small = fm.Reduced(rod(), modes=6, frame="pin")
    assert frequencies(small) == pytest.approx(frequencies(rod()), rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("formulation", [pytest.param("corotated", marks=pytest.mark.slow), "total-lagrange"])
def test_plane_bodies_buckle_as_their_meshes_do(formulation):
    """A link with wide holes: forces of rigid pins do work where their nodes turn; without, 13 % too much."""
    mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.012, hole=0.006, width=0.006, size=0.004)
    body = fm.PlaneBody("rod", mesh, thickness=0.006, material=STEEL, formulation=formulation)

    def load(strut):
        slider = fm.RigidBody("slider", (0.12, 0.0), mass=0.1, inertia=1e-4)
        parts = [
            fm.Revolute("A", fm.GROUND, strut, (0.0, 0.0)),
            fm.Revolute("B", strut, slider, (0.12, 0.0)),
            fm.Prismatic("guide", fm.GROUND, slider, at=(0.12, 0.0), along=(1.0, 0.0)),
            fm.Force("push", slider, at=(0.12, 0.0), force=(-1.0, 0.0)),
        ]
        return fm.buckling(fm.Mechanism("strut", [strut, slider, *parts])).factors[0]

    assert load(fm.Reduced(body, modes=6)) == pytest.approx(
        load(body), rel=1e-3 if formulation == "corotated" else 8e-3
    )


def test_statics_of_all_bodies_agree():
    """A tip force that bends by 5 % of the length."""
    found = []
    for body in (rod(), fm.Reduced(rod(), modes=3)):
        push = fm.Force("push", body, at=(1.0, 0.0), force=(0.0, -200.0))
        found.append(fm.static_equilibrium(held(body, push))["rod.end.y"])
    assert found[1] == pytest.approx(found[0], rel=1e-4)


def test_a_joint_with_play_between_reduced_bodies():
    """Contact, tangents of differences and a restart work as between any bodies."""
    mechanism = fm.mechanisms.slider_crank(clearance=5e-4)
    link = fm.FlexibleLink(
        "rod", *ends(mechanism.find("rod")), section=fm.Rectangle(width=0.02, height=0.03), material=STEEL
    )
    mechanism = mechanism.with_part(fm.Reduced(link, modes=3))
    whole = fm.simulate(mechanism, t_end=4e-3)
    first = fm.simulate(mechanism, t_end=4e-3, max_steps=200)
    rest = fm.simulate(mechanism, t_end=4e-3, restart=first.restart)
    assert whole.ok
    assert np.array_equal(whole.restart["q"], rest.restart["q"])
    assert whole.peak("B.normal_force").value > 100.0


def ends(link):
    return link.start, link.end


def test_bending_up_and_down_are_alike():
    """A rod on two supports under sudden weight that bends it by a hundredth of its length, against the chain of beams.

    Its end moves by the shortening alone, an effect of second order; mirrored weights give mirrored motions.
    """

    def run(body, g):
        slide = fm.RigidBody("slide", (1.0, 0.0), 1e-3, 1e-6)
        joints = [fm.Revolute("A", fm.GROUND, body, (0.0, 0.0)), fm.Revolute("B", body, slide, (1.0, 0.0))]
        parts = [body, slide, *joints, fm.Prismatic("guide", fm.GROUND, slide)]
        sol = fm.simulate(fm.Mechanism("bent", parts, gravity=(0.0, g)), t_end=0.05, step=1e-4, save=100)
        return 1.0 - sol.array("rod.end.x"), sol.array("rod.start.theta")

    beams = rod(STEEL, 8, damping=1e-4)
    small = fm.Reduced(beams, modes=6)
    shortened, turned = run(small, 300.0)
    mirrored = run(small, -300.0)
    exact = run(beams, 300.0)
    assert shortened == pytest.approx(mirrored[0], abs=1e-8 * shortened.max())
    assert turned == pytest.approx(-mirrored[1], abs=1e-8 * np.abs(turned).max())
    assert turned == pytest.approx(exact[1], abs=5e-3 * np.abs(turned).max())
    assert shortened == pytest.approx(exact[0], abs=2e-2 * shortened.max())
