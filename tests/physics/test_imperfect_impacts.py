"""Impacts of nonsmooth mechanics, in closed form, against stiff contacts with `ExactRestitution`.

The impulses Pn, Pt of the contact act in an instant, the position does not change, and the normal speed of the points
in contact is returned e times (Newton; the same as Poisson and Stronge where slip keeps its direction).  What is left
is how far the bodies move during the contact: depth and duration go with K^(-1/(n+1)) = K^(-0.4), and so must the
errors.
"""

import math

import numpy as np
import pytest

import flexmb as fm

MU, E = 0.15, 0.6
PLAY, R2 = 0.02, 0.02


def law(stiffness):
    return fm.contact.ExactRestitution(stiffness=stiffness, restitution=E, least_approach=0.0)


def impulse(sol, name):
    """Integral of the contact's force (x, y) on the second body."""
    return np.array([np.trapezoid(sol.array(f"{name}.{axis}"), sol.time) for axis in ("fx", "fy")])


# A disc in a bearing, both free: it flies along X from beside the middle and meets the wall obliquely.

BODIES = {"mass1": 2.0, "mass2": 0.5, "inertia1": 3e-3, "inertia2": 2e-4}
START, VELOCITY, SPIN = (1.59e-2, 1.2e-2), (1.5, 0.0), -40.0


def oblique(stiffness, friction):
    """One impact of the disc; the solution at every step."""
    ring = fm.RigidBody("ring", (0.0, 0.0), BODIES["mass1"], BODIES["inertia1"], velocity=(0.0, 0.0, 0.0))
    ball = fm.RigidBody("ball", (0.0, 0.0), BODIES["mass2"], BODIES["inertia2"], velocity=(*VELOCITY, SPIN))
    options = {"clearance": PLAY, "bearing_radius": R2 + PLAY, "normal": law(stiffness), "friction": friction}
    joint = fm.RevoluteClearance("J", ring, ball, at=(0.0, 0.0), start=START, **options)
    mech = fm.Mechanism("oblique", (ring, ball, joint))
    sol = fm.simulate(mech, t_end=2.5e-4, save="steps", step=2e-8)
    assert sol.ok, sol.status
    assert sol.array("J.mode")[-1] == 0.0  # it has left again
    return sol


def oblique_by_hand(mu):
    """Impulse (Pn, Pt) on the disc, along -n and t; closing speed.  The centre runs on y = START[1] to |e| = PLAY."""
    n = np.array([math.sqrt(1.0 - (START[1] / PLAY) ** 2), START[1] / PLAY])
    t = np.array([-n[1], n[0]])
    closing = float(np.dot(VELOCITY, n))
    Pn = (1.0 + E) * closing / (1.0 / BODIES["mass1"] + 1.0 / BODIES["mass2"])
    slip = float(np.dot(VELOCITY, t)) + R2 * SPIN
    Pt = -math.copysign(mu * Pn, slip)
    yields = 1.0 / BODIES["mass1"] + 1.0 / BODIES["mass2"]
    yields += R2**2 / BODIES["inertia2"] + (R2 + PLAY) ** 2 / BODIES["inertia1"]
    assert abs(slip) > 2.0 * abs(Pt) * yields  # it slides in one direction to the end
    return n, t, closing, Pn, Pt


@pytest.mark.parametrize("mu", [0.0, MU])
def test_an_oblique_impact_in_a_bearing(mu):
    """Momentum balance with e and mu: impulse, speeds of separation, both spins; the error falls with K."""
    n, t, closing, Pn, Pt = oblique_by_hand(mu)
    friction = fm.friction.SmoothCoulomb(mu, v0=1e-4) if mu else fm.friction.Frictionless()
    errors = []
    for stiffness in (1e12, 1e14):
        sol = oblique(stiffness, friction)
        P = impulse(sol, "J")
        dv = np.array([sol.array(f"ball.v{a}")[-1] - sol.array(f"ring.v{a}")[-1] for a in "xy"])
        spins = sol.array("ball.omega")[-1] - SPIN, sol.array("ring.omega")[-1]
        expected = Pt * R2 / BODIES["inertia2"], -Pt * (R2 + PLAY) / BODIES["inertia1"]
        found = [-P @ n / Pn - 1.0, -dv @ n / (E * closing) - 1.0]
        if mu:
            found += [P @ t / Pt - 1.0, spins[0] / expected[0] - 1.0, spins[1] / expected[1] - 1.0]
        else:
            assert max(map(abs, spins)) < 1e-13
        errors.append(max(map(abs, found)))
    print("\nlargest relative error:", errors)
    assert errors[0] < 1e-2, errors
    assert math.log(errors[0] / errors[1], 100.0) == pytest.approx(0.4, abs=0.02)


# A slender rod that falls on its end, sliding: Kelvin's and Routh's impact with slip in one direction.

LENGTH, MASS, ANGLE, PIN = 0.4, 0.7, 0.9, 1e-3
ROD_INERTIA = MASS * LENGTH**2 / 12.0


def fallen(stiffness, speed_x, mu):
    """The rod's lower end at (0, 0) meets the lower side of a slot along X at 1 m/s; ends before it lands again."""
    end = (-LENGTH * math.cos(ANGLE), LENGTH * math.sin(ANGLE))
    rod = fm.RigidLink("rod", (0.0, 0.0), end, MASS, ROD_INERTIA, velocity=(speed_x, -1.0, 0.0))
    numbers = {"clearance": 2e-4, "pin_radius": PIN, "normal": law(stiffness)}
    slot = fm.PinSlotClearance(
        "S", fm.GROUND, rod, at=(0.0, 0.0), friction=fm.friction.SmoothCoulomb(mu, v0=1e-5), **numbers
    )
    sol = fm.simulate(fm.Mechanism("fallen", (rod, slot)), t_end=3e-4, save="steps", step=2e-8)
    assert sol.ok, sol.status
    depth = sol.array("S.penetration")
    assert depth.max() > 0.0
    assert depth[-1] < 0.0
    return sol


def fallen_by_hand(speed_x, mu):
    """(Pn, Pt, vx, vy, omega after), by dv = P/m, d(omega) = (rx Pn - ry Pt)/J, Pt = -mu Pn, u_n+ = -e u_n-.

    r leads from the rod's centre to the point of contact, at the bottom of the pin.  It slides towards +x all the time
    if it does so at first (or begins to) and still does at the end.
    """
    rx, ry = 0.5 * LENGTH * math.cos(ANGLE), -0.5 * LENGTH * math.sin(ANGLE) - PIN
    inverse = 1.0 / MASS + rx * (rx + mu * ry) / ROD_INERTIA
    Pn = (1.0 + E) * 1.0 / inverse
    Pt = -mu * Pn
    omega = (rx * Pn - ry * Pt) / ROD_INERTIA
    vx, vy = speed_x + Pt / MASS, -1.0 + Pn / MASS
    assert vx - omega * ry > 0.1  # slides towards +x to the end
    assert vy + omega * rx == pytest.approx(E, rel=1e-12)
    return np.array([Pn, Pt, vx, vy, omega])


@pytest.mark.parametrize("speed_x", [0.0, 0.8])
def test_a_rod_that_falls_on_its_end_with_friction(speed_x):
    """`speed_x` = 0: the impact itself makes the end slide, since mu is below what would hold it."""
    exact = fallen_by_hand(speed_x, MU)
    errors = []
    for stiffness in (1e11, 1e13):
        sol = fallen(stiffness, speed_x, MU)
        P = impulse(sol, "S")
        found = np.array([P[1], P[0], *(sol.array(f"rod.{s}")[-1] for s in ("vx", "vy", "omega"))])
        errors.append(float(np.abs(found / exact - 1.0).max()))
    print("\nlargest relative error:", errors)
    assert errors[0] < 1e-2, errors
    assert math.log(errors[0] / errors[1], 100.0) == pytest.approx(0.4, abs=0.02)
