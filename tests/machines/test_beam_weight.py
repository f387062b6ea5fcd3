"""A weight on the end of a light cantilever: laid down slowly, and let go at once.

At rest the tip falls by m g L^3/(3 E I); a load that is there at once swings about that height, down to twice the
deflection, with w^2 = 3 E I/(m L^3).  From the height h: 1 + sqrt(1 + 2 h/d) times the deflection d.
Source: S. P. Timoshenko, Vibration Problems in Engineering, 2nd ed., Van Nostrand 1937, sections 1 and 13.
"""

import math

import numpy as np
import pytest

import flexmb as fm

LENGTH, WEIGHT, G = 1.0, 0.5, 9.81
LIGHT = fm.Material(young=210e9, density=1e-2, poisson=0.3)
SECTION = fm.Rectangle(width=0.03, height=0.01)
EI = 210e9 * 0.03 * 0.01**3 / 12.0
STATIC = WEIGHT * G * LENGTH**3 / (3.0 * EI)
W = math.sqrt(3.0 * EI / (WEIGHT * LENGTH**3))


def cantilever(*parts, velocity=0.0):
    def shape(s):
        """Velocities along the beam, in the shape of its deflection under the force at the tip."""
        return 0.0, velocity * (1.5 * s**2 - 0.5 * s**3), velocity * (3.0 * s - 1.5 * s**2) / LENGTH

    whole = {"section": SECTION, "material": LIGHT, "elements": 2, "velocity": shape}
    beam = fm.FlexibleLink("beam", (0.0, 0.0), (LENGTH, 0.0), **whole)
    ball = fm.bodies.PointMass("ball", at=(LENGTH, 0.0), mass=WEIGHT, velocity=(0.0, velocity))
    clamp = fm.Fixed("clamp", fm.GROUND, beam, at=(0.0, 0.0))
    seat = fm.Revolute("seat", beam, ball, at=(LENGTH, 0.0))
    return fm.Mechanism("weight on a beam", [beam, ball, clamp, seat, *parts], gravity=(0.0, -G))


def test_the_weight_at_rest():
    pose = fm.static_equilibrium(cantilever())
    assert pose["ball.y"] == pytest.approx(-STATIC, rel=2e-5)
    assert pose.force("clamp")[1] == pytest.approx(WEIGHT * G, rel=1e-5)
    assert pose.force("clamp")[2] == pytest.approx(WEIGHT * G * LENGTH, rel=1e-4)


def test_a_sudden_load_deflects_twice_as_far():
    turn = 2.0 * math.pi / W
    times = np.linspace(0.0, 2.0 * turn, 201)
    sol = fm.simulate(cantilever(), t_end=times[-1], save=times, step=fm.FixedStep(turn / 2000.0)).require()
    exact = -STATIC * (1.0 - np.cos(W * times))
    assert sol["ball.y"].values == pytest.approx(exact, abs=2e-4 * STATIC)
    assert -sol["ball.y"].values.min() / STATIC == pytest.approx(2.0, rel=1e-3)


def test_slowly_and_suddenly_end_at_the_same_energy_of_the_beam():
    """Lowered by a crane that lets go within twenty swings the weight rests at the static deflection."""
    turn = 2.0 * math.pi / W
    crane = fm.Force(
        "crane", cantilever()["ball"], at=(LENGTH, 0.0), force=(0.0, WEIGHT * G),
        history=fm.drives.PiecewiseLinear((0.0, 20.0 * turn, 30.0 * turn), (1.0, 0.0, 0.0)),
    )  # fmt: skip
    sol = fm.simulate(cantilever(crane), t_end=25.0 * turn, step=fm.FixedStep(turn / 200.0)).require()
    late = sol["ball.y"].values[sol.time > 21.0 * turn]
    assert late == pytest.approx(-STATIC, rel=1.1 / (20.0 * 2.0 * math.pi) * 2.0)  # the ramp leaves 1/(w T) of it
    assert sol["energy.strain"].values[-1] == pytest.approx(WEIGHT * G * STATIC / 2.0, rel=5e-2)


def test_a_weight_that_arrives_with_speed_deflects_further():
    height = 3.0 * STATIC
    speed = math.sqrt(2.0 * G * height)
    turn = 2.0 * math.pi / W
    sol = fm.simulate(cantilever(velocity=-speed), t_end=turn, step=fm.FixedStep(turn / 2000.0)).require()
    exact = STATIC * (1.0 + math.sqrt(1.0 + 2.0 * height / STATIC))
    assert -sol["ball.y"].values.min() == pytest.approx(exact, rel=1e-3)
