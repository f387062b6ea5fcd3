"""Plate link: mass, frequencies and stress of a plane body beside a beam and closed forms.

Mass of two eyes, two holes and a shank by area; bending after Timoshenko; the stress of a bar that turns about its end,
rho w^2 (L^2 - x^2)/2.  Source: S. P. Timoshenko, Vibration Problems in Engineering, 2nd ed., 1937; G. R. Cowper,
Journal of Applied Mechanics 33 (1966) 335-340.
"""

import math

import numpy as np
import pytest

import flexmb as fm

STEEL = fm.Material(young=2.1e11, density=7850.0, poisson=0.3)
LENGTH, DEPTH, THICK = 0.4, 0.04, 0.01
SPEED = 150.0
PLACES = (0.1, 0.2, 0.3)
CENTRIFUGAL = [STEEL.density * SPEED**2 * (LENGTH**2 - x * x) / 2.0 for x in PLACES]
PULL = STEEL.density * THICK * DEPTH * SPEED**2 * LENGTH**2 / 2.0


def bar():
    mesh = fm.meshes.rectangle(LENGTH, DEPTH, 20, 2, "quad9")
    return fm.PlaneBody("bar", mesh, at=(0.0, -DEPTH / 2.0), thickness=THICK, material=STEEL, pins=("left", "right"))


def test_mass_of_a_link_with_eyes_is_its_area():
    """Two eyes R with holes r, and a shank of width w between them that ends where it meets the eyes."""
    length, eye, hole, width = 0.2, 0.02, 0.01, 0.02
    mesh = fm.meshes.link_with_eyes(length=length, eye=eye, hole=hole, width=width, size=0.0025)
    half = math.asin(width / 2.0 / eye)
    hidden = eye**2 * (half - math.sin(half) * math.cos(half))  # segment of each eye beyond the mouth of the shank
    shank = width * (length - 2.0 * eye * math.cos(half))
    area = 2.0 * (math.pi * (eye**2 - hole**2) - hidden) + shank
    link = fm.PlaneBody("link", mesh, thickness=THICK, material=STEEL)
    assert link.total_mass() == pytest.approx(STEEL.density * THICK * area, rel=1e-5)


def test_mass_and_inertia_of_a_bar():
    body = bar()
    mass = STEEL.density * THICK * LENGTH * DEPTH
    assert body.total_mass() == pytest.approx(mass, rel=1e-12)
    assert body.properties().inertia == pytest.approx(mass * (LENGTH**2 + DEPTH**2) / 12.0, rel=1e-10)


def timoshenko_clamped():
    """First frequency of a clamped bar with shear factor and rotary inertia, by the exact characteristic equation."""
    from scipy.optimize import brentq

    area, second = THICK * DEPTH, THICK * DEPTH**3 / 12.0
    e, g = STEEL.young, STEEL.young / 2.6
    kappa = 10.0 * 1.3 / (12.0 + 11.0 * 0.3)
    rho = STEEL.density

    def determinant(w):
        """Moment and shear force at the free end vanish: of the transfer matrix exp(A L) of y' = A y."""
        from scipy.linalg import expm

        a = np.zeros((4, 4))  # deflection, slope, moment, shear force
        a[0, 1], a[0, 3] = 1.0, 1.0 / (kappa * g * area)
        a[1, 2] = 1.0 / (e * second)
        a[2, 1], a[2, 3] = -rho * second * w**2, -1.0
        a[3, 0] = -rho * area * w**2
        t = expm(a * LENGTH)
        return t[2, 2] * t[3, 3] - t[2, 3] * t[3, 2]

    thin = 3.5160 * math.sqrt(e * second / (rho * area)) / LENGTH**2
    return brentq(determinant, 0.9 * thin, 1.001 * thin) / (2.0 * math.pi)


def held_at_left(body):
    return fm.Mechanism("held", [body, fm.Fixed("wall", fm.GROUND, body, at=(0.0, 0.0))], gravity=(0.0, 0.0))


def test_the_first_frequency_of_mesh_reduction_and_beam():
    exact = timoshenko_clamped()
    plate = bar()
    beam = fm.FlexibleLink(
        "bar", (0.0, 0.0), (LENGTH, 0.0), section=fm.Rectangle(THICK, DEPTH), material=STEEL, elements=16, shear=True
    )
    found = {
        "mesh": plate.frequencies(1, held=("left",))[0],
        "reduced": fm.modes(held_at_left(fm.Reduced(plate, modes=6)), count=1).frequencies[0],
        "beam": fm.modes(held_at_left(beam), count=1).frequencies[0],
    }
    assert found["beam"] == pytest.approx(exact, rel=1e-3)
    assert found["reduced"] == pytest.approx(found["mesh"], rel=1e-4)
    assert found["mesh"] == pytest.approx(exact, rel=3e-3)  # a clamped end does not contract


def rotor(body):
    hub = fm.Revolute("hub", fm.GROUND, body, at=(0.0, 0.0))
    return fm.Mechanism("rotor", [body, hub, fm.Drive("motor", "hub", fm.ConstantSpeed(SPEED))], gravity=(0.0, 0.0))


def spun(body, start=None):
    sol = fm.simulate(rotor(body), t_end=2e-3, start=start, save=40).require()
    stress = sol.stress("bar", [(x, 0.0) for x in PLACES])["sx"].values
    return stress.mean(axis=0), sol["hub.force"].values.mean()


@pytest.mark.slow
def test_the_centrifugal_stress_of_a_reduced_bar():
    body = fm.Reduced(bar(), modes=12, inertia_shapes=True)  # six leave 11 % of it in the middle
    stress, pull = spun(body, fm.static_equilibrium(rotor(body), spin=SPEED))
    assert stress == pytest.approx(CENTRIFUGAL, rel=1.5e-2)
    assert pull == pytest.approx(PULL, rel=1e-3)


@pytest.mark.slow
def test_the_centrifugal_stress_of_a_mesh():
    """Over two milliseconds, thirteen waves along the bar that the sudden start leaves."""
    stress, pull = spun(bar())
    assert stress == pytest.approx(CENTRIFUGAL, rel=5e-3)
    assert pull == pytest.approx(PULL, rel=5e-3)


@pytest.mark.slow
def test_a_mesh_starts_in_its_steady_rotation():
    stress, pull = spun(bar(), fm.static_equilibrium(rotor(bar()), spin=SPEED))
    assert stress == pytest.approx(CENTRIFUGAL, rel=3e-3)
    assert pull == pytest.approx(PULL, rel=1e-4)
