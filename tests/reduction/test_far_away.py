"""Reduced bodies far from the origin."""

import pytest

import flexmb as fm


def oiled_slider_crank(x: float) -> fm.Mechanism:
    """A reduced rod whose pin turns in oil, a slider with play in its guide, and a cable, at x [m]."""
    law, rub = fm.KelvinVoigt(1e6, 200.0, ramp=1e-6), fm.ModifiedCoulomb(0.15, v0=1e-3, v1=1e-2)
    crank = fm.RigidLink("crank", (x, 0.0), (x + 0.05, 0.0), mass=0.3, inertia=1e-4)
    mesh = fm.meshes.link_with_eyes(length=0.12, eye=0.02, hole=0.01, width=0.02, size=0.008)
    nylon, ends = fm.Material(2e9, 1200.0, 0.3), {"start": (x + 0.05, 0.0), "end": (x + 0.17, 0.0)}
    plate = fm.PlaneBody("rod", mesh, **ends, thickness=0.01, material=nylon, damping=2e-5)
    rod, at = fm.Reduced(plate, modes=6), (x + 0.17, 0.0)
    slider = fm.RigidBody("slider", at=at, mass=0.2, inertia=1e-4)
    oil = fm.ShortBearing(viscosity=0.05, width=0.01, density=870.0)
    play = {"normal": law, "friction": rub}
    parts = [
        fm.Revolute("O", fm.GROUND, crank, at=(x, 0.0)),
        fm.Revolute("A", crank, rod, at=(x + 0.05, 0.0)),
        fm.JournalBearing(
            "B", rod, slider, at=at, clearance=5e-5, bearing_radius=5e-3, film=oil, roughness=1e-6, **play
        ),
        fm.PrismaticClearance(
            "G", fm.GROUND, slider, at=at, along=(1.0, 0.0), clearance=1e-4, half_length=0.015, half_height=0.01, **play
        ),
        fm.Drive("m", joint="O", motion=fm.drives.CycloidalRamp(60.0, time=0.02)),
    ]
    return fm.Mechanism("oiled", [crank, rod, slider, *parts], gravity=(0.0, -9.81))


def test_a_reduced_rod_moves_100_m_away_as_at_the_origin():
    """Angles, of modes too, are no more exact than the places of bodies over the size of the mechanism."""
    near, far = (fm.simulate(oiled_slider_crank(x), t_end=0.08, save=20).require() for x in (0.0, 300.0))
    assert far.array("m.torque") == pytest.approx(near.array("m.torque"), rel=1e-4, abs=1e-4)
