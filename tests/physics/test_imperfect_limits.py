"""A worn slider-crank tends to the ideal one as its play and the softness of its contact vanish.

The crank turns slowly under a load that keeps the piston pin on one side of its bearing.  The rod is then longer by
the play, but for the direction of the force, which the rod's own inertia turns a little.
"""

import math

import numpy as np
import pytest

import flexmb as fm

R, L, SPEED, LOAD = 0.05, 0.12, 10.0, 20.0
BEARING = 0.01


def worn(clearance, stiffness=1e12):
    """The pin (of the slider) pressed by the load towards the crank, where it also starts."""
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.0, R), 0.30, 1e-5)
    end = (math.sqrt(L**2 - R**2), 0.0)
    rod = fm.RigidLink("rod", (0.0, R), end, 0.21, 2.5e-4)
    slider = fm.RigidBody("slider", end, 0.14, 1e-4)
    along = np.array([end[0], -R]) / L
    pin = fm.RevoluteClearance(
        "B",
        rod,
        slider,
        at=end,
        clearance=clearance,
        bearing_radius=BEARING,
        normal=fm.contact.ExactRestitution(stiffness=stiffness, restitution=0.3, least_approach=0.5),
        start=tuple(-clearance * along),
    )
    parts = (
        fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)),
        fm.Revolute("A", crank, rod, at=(0.0, R)),
        pin,
        fm.Prismatic("guide", fm.GROUND, slider),
        fm.Drive("motor", "O", fm.ConstantSpeed(SPEED)),
        fm.Force("load", slider, at=end, force=(-LOAD, 0.0)),
    )
    return fm.Mechanism("worn", (crank, rod, slider, *parts))


def run(clearance, stiffness=1e12):
    """A turn, and the slider of the ideal mechanism, r cos + sqrt(l^2 - r^2 sin^2), at the same instants."""
    sol = fm.simulate(worn(clearance, stiffness), periods=1, save=2000)
    assert sol.ok, sol.status
    late = sol.time > 0.02
    assert sol.array("B.normal_force")[late].min() > 0.5 * LOAD  # the contact lasts
    angle = 0.5 * math.pi + SPEED * sol.time
    return sol, R * np.cos(angle) + np.sqrt(L**2 - (R * np.sin(angle)) ** 2)


def slopes(x, y):
    return np.diff(np.log(y)) / np.diff(np.log(x))


def test_the_motion_tends_to_the_ideal_one_in_proportion_to_the_play():
    """The worn rod is shorter by c: the slider lags by c/cos(tilt of the rod), at most c/sqrt(1 - (r/l)^2)."""
    plays = np.array([4e-4, 2e-4, 1e-4, 5e-5])
    distances = []
    for play in plays:
        sol, ideal = run(play)
        distances.append(float(np.abs(sol.array("slider.x") - ideal).max()))
    print("\nlargest distance from the ideal motion [m]:", dict(zip(plays.tolist(), distances, strict=True)))
    rates = slopes(plays, np.array(distances))
    np.testing.assert_allclose(rates, 1.0, atol=0.02)
    np.testing.assert_allclose(distances, plays / math.sqrt(1.0 - (R / L) ** 2), rtol=0.03)


def test_the_penetration_falls_with_the_stiffness():
    """N = K depth^1.5 under the same load: depth ~ K^(-2/3), and the depth itself that of the load through the rod."""
    stiffness = np.array([1e8, 1e9, 1e10, 1e11])
    depths = []
    for K in stiffness:
        sol, _ = run(2e-4, K)
        late = sol.time > 0.1  # the shaking of the start has died away
        N, depth = sol.array("B.normal_force")[late], sol.array("B.penetration")[late]
        np.testing.assert_allclose(depth, (N / K) ** (2 / 3), rtol=1e-2)
        depths.append(depth.max())
    print("\nlargest depth [m]:", dict(zip(stiffness.tolist(), depths, strict=True)))
    assert slopes(stiffness, np.array(depths)) == pytest.approx([-2 / 3] * 3, abs=0.01)
