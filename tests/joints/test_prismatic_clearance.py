"""A slider with play in its guide: every state of contact by hand, at rest, sliding, falling."""

import math
from dataclasses import replace

import numpy as np
import pytest

import flexmb as fm

C, A, B = 1e-3, 0.05, 0.02  # clearance, half length, half height [m]
K = 1e8
LAW = fm.LankaraniNikravesh(stiffness=K, restitution=0.8)
MU = 0.2
DIRECTION = 0.3  # of the guide [rad]


def mechanism(friction=None, direction=DIRECTION, gravity=(0.0, 0.0), **more):
    slider = fm.RigidBody("slider", (0.4, 0.1), 0.5, 1e-3, theta=direction)
    along = (math.cos(direction), math.sin(direction))
    sizes = {"clearance": C, "half_length": A, "half_height": B}
    guide = fm.PrismaticClearance(
        "G",
        fm.GROUND,
        slider,
        along=along,
        normal=LAW,
        friction=friction or fm.friction.Frictionless(),
        **sizes,
        **more,
    )
    return fm.Mechanism("guided", (slider, guide), gravity=gravity)


def in_guide(offset, tilt, travel=0.0):
    """The move of the slider that has this offset and tilt in the guide."""
    c, s = math.cos(DIRECTION), math.sin(DIRECTION)
    return (travel * c - offset * s, travel * s + offset * c, tilt)


def felt(force):
    """Along the guide, across it, moment."""
    c, s = math.cos(DIRECTION), math.sin(DIRECTION)
    return np.array([c * force[0] + s * force[1], c * force[1] - s * force[0], force[2]])


def corner(x, y, tilt, offset):
    """Position of a corner against the slider's centre, and how far it stands beyond its side."""
    px, py = x * math.cos(tilt) - y * math.sin(tilt), x * math.sin(tilt) + y * math.cos(tilt)
    return px, py, math.copysign(1.0, y) * (py + offset) - (B + C)


STATES = {
    "free": (0.5 * C, 0.005, 0, 0.0),
    "one corner": (0.9 * C, 0.004, 1, 1.0),
    "two corners across": (0.0, 0.0225, 2, 2.0),
    "face": (1.02 * C, 0.0, 2, 3.0),
    "the other face": (-1.02 * C, 0.0, 2, 3.0),
}


@pytest.mark.parametrize("state", STATES)
def test_forces_of_each_state_by_hand(posed, state):
    """N = K depth^1.5 in every corner beyond its side, back across the guide, with its lever about the centre."""
    offset, tilt, touching, _ = STATES[state]
    expected, count = np.zeros(3), 0
    for x in (A, -A):
        for y in (B, -B):
            px, _, depth = corner(x, y, tilt, offset)
            if depth > 0.0:
                N = -math.copysign(K * depth**1.5, y)
                expected += [0.0, N, px * N]
                count += 1
    found = felt(posed(mechanism()).force({"slider": in_guide(offset, tilt, 0.07)})["slider"])
    assert count == touching
    np.testing.assert_allclose(found, expected, atol=1e-9 * K * C**1.5)


def test_a_sliding_face_is_braked_and_turned_by_friction(posed):
    """Two corners on the upper side, sliding forward: -2 mu N along, and its moment about the centre, B above it."""
    offset, speed = 1.02 * C, 0.5
    c, s = math.cos(DIRECTION), math.sin(DIRECTION)
    model = posed(mechanism(fm.ModifiedCoulomb(MU, v0=1e-4, v1=1e-3)))
    found = felt(model.force({"slider": in_guide(offset, 0.0)}, {"slider": (speed * c, speed * s, 0.0)})["slider"])
    N = K * (0.02 * C) ** 1.5
    np.testing.assert_allclose(found, [-2 * MU * N, -2 * N, 2 * MU * N * B], rtol=1e-9)


@pytest.mark.parametrize("state", STATES)
def test_the_mode_says_which(state):
    offset, tilt, _, mode = STATES[state]
    mech = mechanism()
    signal = next(s for s in mech.find("G").contributions(mech) if getattr(s, "name", "") == "mode")
    q = np.array([0.0, 0.0, 0.0, 0.4, 0.1, DIRECTION])
    q[3:] += in_guide(offset, tilt)
    assert signal.kernel.python(np.array(signal.p), 0.0, q, np.zeros(6), np.zeros(6)) == mode


def test_a_slider_that_falls_on_its_side_stays_there_with_its_weight():
    """Level guide, gravity: after the bouncing it lies on both lower corners, each with half the weight."""
    mech = mechanism(direction=0.0, gravity=(0.0, -9.81))
    sol = fm.simulate(mech, t_end=0.6, save=2000)
    assert sol.ok, sol.status
    late = sol.time > 0.55
    half = 0.5 * 0.5 * 9.81
    for name in ("lower_front", "lower_rear"):
        assert sol.array(f"G.{name}.normal_force")[late].mean() == pytest.approx(half, rel=0.02)
    assert sol.array("G.offset")[-1] == pytest.approx(-C - (half / K) ** (2 / 3), abs=1e-3 * C)
    assert np.all(sol.array("G.mode")[late] == 3.0)
    assert sol.stats.smallest_step > 1e-9


def test_switched_to_ideal_and_back_by_one_part():
    mech = mechanism(gravity=(0.0, -9.81))
    slider = mech.find("slider")
    ideal = mech.with_part(fm.Prismatic("G", fm.GROUND, slider, along=(math.cos(DIRECTION), math.sin(DIRECTION))))
    # no friction: both slide down alike, s = -g sin(a) t^2/2
    sols = [fm.simulate(m, t_end=0.1, save=10) for m in (ideal, mech)]
    x = 0.4 - 0.5 * 9.81 * math.sin(DIRECTION) * 0.1**2 * math.cos(DIRECTION)
    assert sols[0].array("slider.x")[-1] == pytest.approx(x, abs=1e-9)
    assert sols[1].array("slider.x")[-1] == pytest.approx(x, abs=2 * C)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"clearance": 0.0}, ["'G'", "clearance is 0", "Prismatic"]),
        ({"half_length": -0.1}, ["'G'", "half_length is -0.1"]),
        ({"clearance": 0.06}, ["'G'", "0.06", "turn in its guide"]),
        ({"normal": fm.friction.Frictionless()}, ["'G'", "normal", "normal law"]),
        ({"friction": LAW}, ["'G'", "friction", "friction law"]),
    ],
)
def test_bad_input(change, words):
    with pytest.raises(fm.errors.InputError) as error:
        replace(mechanism().find("G"), **change)
    for word in words:
        assert word in str(error.value)


def test_a_law_from_materials_needs_the_radius_of_the_corners():
    law = fm.LankaraniNikravesh.from_materials(fm.STEEL, fm.STEEL)
    mech = mechanism()
    with pytest.raises(fm.errors.InputError, match="corner_radius"):
        fm.compile(mech.with_part(replace(mech.find("G"), normal=law)))
    fm.compile(mech.with_part(replace(mech.find("G"), normal=law, corner_radius=1e-3)))
