"""Models that several tests of physics share."""

import math

import pytest

import flexmb as fm

CRANK, ROD, BEARING, CLEARANCE = 0.05, 0.12, 0.010, 0.0005
OMEGA = 5000 * math.pi / 30
PIN_STEEL = fm.Material(young=207e9, density=7850.0, poisson=0.3)


def worn_slider_crank(mu=0.03, clearance=CLEARANCE):
    """Slider-crank whose piston pin has play: the rod carries the bearing, the slider the journal; 5000 rpm.

    Start stretched, journal centred, ideal velocities, no gravity.  clearance=None: an ideal pin.
    """
    crank = fm.RigidLink("crank", (0.0, 0.0), (CRANK, 0.0), 0.30, 1e-5)
    rod = fm.RigidLink("rod", (CRANK, 0.0), (CRANK + ROD, 0.0), 0.21, 2.5e-4)
    slider = fm.RigidBody("slider", (CRANK + ROD, 0.0), 0.14, 1e-4)
    pin = fm.Revolute("C", rod, slider, (CRANK + ROD, 0.0))
    if clearance is not None:
        pin = fm.RevoluteClearance(
            "C",
            rod,
            slider,
            (CRANK + ROD, 0.0),
            clearance=clearance,
            bearing_radius=BEARING,
            normal=fm.LankaraniNikravesh.from_materials(PIN_STEEL, PIN_STEEL, restitution=0.9, least_approach=0.0),
            friction=fm.ModifiedCoulomb(mu, v0=0.0, v1=1e-3) if mu else fm.friction.Frictionless(),
        )
    joints = (
        fm.Revolute("A", fm.GROUND, crank, (0.0, 0.0)),
        fm.Revolute("B", crank, rod, (CRANK, 0.0)),
        pin,
        fm.Prismatic("guide", fm.GROUND, slider),
        fm.Drive("motor", "A", fm.ConstantSpeed(OMEGA)),
    )
    return fm.Mechanism("worn-slider-crank", (crank, rod, slider, *joints))


@pytest.fixture(scope="session")
def slider_crank():
    """The function that makes the slider-crank with play."""
    return worn_slider_crank
