"""Four-bar linkage with clearance in three joints beside the ideal one.

The rocker's angle by circle intersection.  Three journals inside their bearings open the loop by 3 (c + penetration)
at most, which turns the rocker by no more than that over r sin(mu), with the least transmission angle mu.
Source: J. J. Uicker, G. R. Pennock, J. E. Shigley, Theory of Machines and Mechanisms, 4th ed., Oxford 2011, ch. 1.
"""

import math

import numpy as np

import flexmb as fm

CRANK, COUPLER, ROCKER, FRAME = 0.05, 0.18, 0.12, 0.2
SPEED, BEARING = 15.0, 0.01
STEEL = fm.Material(young=207e9, density=7850.0, poisson=0.3)
LAW = fm.contact.ExactRestitution.from_materials(STEEL, STEEL, restitution=0.8)


def rocker_end(turn):
    """Joint between coupler and rocker, and the sine of the transmission angle there."""
    x, y = CRANK * np.cos(turn), CRANK * np.sin(turn)
    d = np.hypot(FRAME - x, y)
    angle = np.arctan2(y, x - FRAME) - np.arccos((ROCKER**2 + d**2 - COUPLER**2) / (2.0 * ROCKER * d))
    cosine = (COUPLER**2 + ROCKER**2 - d**2) / (2.0 * COUPLER * ROCKER)
    return np.unwrap(angle), np.sqrt(1.0 - cosine**2)


def four_bar(clearance=None):
    first = float(rocker_end(np.array([0.0]))[0][0])
    a, c = (CRANK, 0.0), (FRAME, 0.0)
    b = (FRAME + ROCKER * math.cos(first), ROCKER * math.sin(first))
    crank = fm.RigidLink("crank", (0.0, 0.0), a, mass=0.2, inertia=1e-4)
    coupler = fm.RigidLink("coupler", a, b, mass=0.4, inertia=0.4 * COUPLER**2 / 12.0)
    rocker = fm.RigidLink("rocker", b, c, mass=0.6, inertia=0.6 * ROCKER**2 / 12.0)
    pairs = {"A": (crank, coupler, a), "B": (coupler, rocker, b), "C": (fm.GROUND, rocker, c)}

    def pin(name, one, other, place):
        if clearance is None:
            return fm.Revolute(name, one, other, at=place)
        return fm.RevoluteClearance(
            name, one, other, at=place, clearance=clearance, bearing_radius=BEARING, normal=LAW, start="seated"
        )

    pins = [pin(name, *pair) for name, pair in pairs.items()]
    base = fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0))
    motor = fm.Drive("motor", "O", fm.ConstantSpeed(SPEED))
    return fm.Mechanism("four-bar", [crank, coupler, rocker, base, motor, *pins], gravity=(0.0, -9.81))


def turn_of(clearance):
    sol = fm.simulate(four_bar(clearance), periods=1).require()
    exact, sine = rocker_end(sol["O.angle"].values)
    return sol, sol["rocker.theta"].values - sol["rocker.theta"].values[0] - (exact - exact[0]), sine


def test_the_ideal_linkage_moves_as_the_circles_say():
    _, error, _ = turn_of(None)
    assert np.abs(error).max() < 1e-8


def test_journals_stay_in_their_bearings_and_the_limit_is_the_ideal_linkage():
    errors = []
    for clearance in (4e-4, 1e-4, 2.5e-5):
        sol, error, sine = turn_of(clearance)
        inside = 0.0
        for name in "ABC":
            away = np.hypot(sol[f"{name}.ex"].values, sol[f"{name}.ey"].values)
            pressed = np.maximum(sol[f"{name}.penetration"].values, 0.0)
            assert (away <= clearance + pressed + 1e-12).all()
            assert pressed.max() < 0.2 * clearance
            inside = max(inside, away.max())
        bound = 2.0 * 3.0 * inside / (ROCKER * sine.min())  # also where it starts
        assert np.abs(error).max() < bound
        errors.append(np.abs(error).max())
        assert abs(float(sol["energy.residual"][-1])) < 1e-3 * float(sol["energy.turned_over"][-1])
    assert errors[0] > 2.0 * errors[1] > 4.0 * errors[2]
