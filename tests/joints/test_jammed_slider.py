"""A slider that is thrown against its guide, tilts, jams by friction or chatters: the run ends, and says how."""

import math

import numpy as np
import pytest

import flexmb as fm

PLAY, HALF, HEIGHT, MASS, G = 1e-3, 0.03, 0.02, 0.5, 9.81
NORMAL = fm.contact.ExactRestitution(stiffness=1e9, restitution=0.4, least_approach=1e-2)
LAWS = {
    "modified": fm.ModifiedCoulomb(0.9, v0=1e-4, v1=1e-3),
    "smooth": fm.friction.SmoothCoulomb(0.9, v0=1e-3),
    "bristles": fm.friction.LuGre(1.0, 0.9, stiffness=1e6),
}


def thrown(friction, slope, moment=0.0, spin=-8.0):
    """Slides down a guide of that slope at 0.5 m/s, turning, with a moment that tilts it."""
    along = (math.cos(slope), math.sin(slope))
    velocity = (-0.5 * along[0], -0.5 * along[1], spin)
    slider = fm.RigidBody("slider", (0.0, 0.0), MASS, 3e-4, theta=slope, velocity=velocity)
    guide = fm.PrismaticClearance(
        "G",
        fm.GROUND,
        slider,
        along=along,
        clearance=PLAY,
        half_length=HALF,
        half_height=HEIGHT,
        normal=NORMAL,
        friction=friction,
    )
    load = fm.Torque("load", slider, moment)
    return fm.Mechanism("thrown", (slider, guide, load), gravity=(0.0, -G))


def corners(sol):
    names = ("upper_front", "upper_rear", "lower_front", "lower_rear")
    return {name: sol.array(f"G.{name}.normal_force") for name in names}


@pytest.mark.quick(6)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("slope", [0.0, 0.5, 1.2])
@pytest.mark.parametrize("moment", [0.0, 2.0])
def test_a_tilting_slider_with_high_friction_runs_to_its_end(law, slope, moment):
    sol = fm.simulate(thrown(LAWS[law], slope, moment), t_end=0.2, save=2000, max_steps=400_000)
    assert sol.ok, sol.status
    assert sol.status.startswith("Finished")
    assert "But" not in sol.status  # nor does its balance of energy miss anything
    assert sol.stats.smallest_step > 1e-9
    assert sol.stats.steps < 200_000
    assert np.isfinite(sol.values).all()


@pytest.mark.parametrize("law", ["bristles", "smooth"])
def test_a_jammed_slider_holds_its_weight(law):
    """A moment of 2 N m presses two corners across, each with about M/(2 a) = 33 N; the weight is 5 N."""
    sol = fm.simulate(thrown(LAWS[law], 0.5 * math.pi, moment=2.0), t_end=0.3, save=2000)
    assert sol.ok, sol.status
    late = sol.time > 0.25
    assert np.all(sol.array("G.mode")[late] == 2.0)
    assert np.abs(sol.array("slider.vy")[late]).max() < 1e-3
    held = sum(N[late].mean() for N in corners(sol).values())
    assert held * 0.9 > MASS * G


def test_a_run_whose_smallest_step_is_too_large_says_so():
    """A floor that impacts cannot pass: a sentence with the instant, the step and what to try."""
    mech = thrown(LAWS["bristles"], 0.5, 2.0)
    sol = fm.simulate(mech, t_end=0.2, step=fm.Adaptive(atol=1e-12, max=1e-3, min=5e-4))
    assert not sol.ok
    assert "Stopped at t = " in sol.status
    assert "Try" in sol.status
    assert sol.restart["clock"][1] >= 1e-4
