"""Outlines with cusps: two arcs with opposite tangents, between which a slit or a tip lies."""

import math

import numpy as np
import pytest

import flexmb as fm

LAW = fm.KelvinVoigt(1e6, 10.0)


def heart(turn=0.0):
    """Two semicircles of radius 1 that touch in a slit at the origin, above a triangle."""
    return fm.cams.Outline(turned([(2.0, 0.0), (0.0, 0.0), (-2.0, 0.0), (0.0, -3.0)], turn), (1.0, 1.0, 0.0, 0.0))


def star(turn=0.0):
    """Four tips, hollow quarters of circles between them."""
    bulge = -math.tan(math.pi / 8.0)
    return fm.cams.Outline(turned([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)], turn), (bulge,) * 4)


def turned(points, angle):
    c, s = math.cos(angle), math.sin(angle)
    return [(c * x - s * y, s * x + c * y) for x, y in points]


@pytest.mark.parametrize("turn", np.linspace(0.0, 6.0, 7))
def test_a_slit_is_a_hollow_corner_and_a_tip_a_convex_one(turn):
    """Round-off of the tangents does not decide which."""
    assert len(heart(turn).hollow_corners()) == 1
    assert len(heart(turn).chains()) == 2
    assert star(turn).hollow_corners() == []


@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_a_disc_rests_in_a_slit_on_both_sides(turn):
    """N = m g/(2 cos a) on each side, with sin a = R/(R + r)."""
    r, deep = 0.2, math.sqrt(1.2**2 - 1.0)
    (place,) = turned([(0.0, deep)], turn)
    disc = fm.RigidBody("disc", place, mass=1.0, inertia=1.0)
    touch = fm.cams.OutlineContact(
        "touch", fm.GROUND, heart(turn), disc, fm.cams.CircularCurve(place, radius=r), normal=LAW
    )
    spring = fm.TorsionSpring("turn", fm.GROUND, disc, stiffness=1.0)
    (down,) = turned([(0.0, -9.81)], turn)
    at = fm.static_equilibrium(fm.Mechanism("heart", [disc, touch, spring], gravity=down))
    force = 9.81 / (2.0 * deep / 1.2)
    away = math.hypot(at["disc.x"], at["disc.y"])
    assert math.sqrt(away**2 + 1.0) == pytest.approx(1.2 - force / 1e6, abs=1e-9)


@pytest.mark.parametrize("turn", [0.0, 0.5 * math.pi, math.pi])
def test_a_tip_rests_on_a_plate(turn):
    """Tips had no contact."""
    body = fm.RigidBody("star", (0.0, 0.0), mass=1.0, inertia=1.0)
    plate = fm.cams.Outline([(-3.0, -2.0), (3.0, -2.0), (3.0, -1.0), (-3.0, -1.0)])
    touch = fm.cams.OutlineOnOutline("touch", fm.GROUND, plate, body, star(turn), normal=LAW)
    guide = fm.Prismatic("guide", fm.GROUND, body, along=(0.0, 1.0))
    at = fm.static_equilibrium(fm.Mechanism("star", [body, touch, guide], gravity=(0.0, -9.81)))
    assert at["star.y"] == pytest.approx(-9.81e-6, rel=1e-6)
