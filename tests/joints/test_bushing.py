"""An elastic joint: vibration against closed forms, the stiff limit, balance of forces, messages."""

import math
from dataclasses import replace

import numpy as np
import pytest

import flexmb as fm

MASS, INERTIA, K, TORSION = 2.0, 0.01, 8e4, 30.0


def held(damping=0.0, torsion_damping=0.0, along=(1.0, 0.0), **more):
    body = fm.RigidBody("body", (0.3, 0.1), MASS, INERTIA, **more)
    numbers = {"stiffness": (K, 2.0 * K), "torsion": TORSION, "damping": damping, "torsion_damping": torsion_damping}
    return fm.Mechanism("held", (body, fm.Bushing("B", fm.GROUND, body, at=(0.3, 0.1), along=along, **numbers)))


def test_three_frequencies():
    """sqrt(k/m) along both axes, sqrt(kt/J) in rotation; turning the axes changes none of them."""
    exact = np.sort(np.sqrt([K / MASS, 2.0 * K / MASS, TORSION / INERTIA])) / (2.0 * math.pi)
    for along in ((1.0, 0.0), (0.6, 0.8)):
        np.testing.assert_allclose(fm.modes(held(along=along)).frequencies, exact, rtol=1e-12)


def test_vibration_and_its_decay():
    """Damped by a hundredth of critical along x: x0 exp(-D w t) cos(w sqrt(1 - D^2) t) after a push off by a force."""
    w, D = math.sqrt(K / MASS), 0.01
    mech = held(damping=2.0 * D * math.sqrt(K * MASS))
    body = mech.find("body")
    pushed = mech.with_part(fm.Force("F", body, at=(0.3, 0.1), force=(80.0, 0.0)))
    period = 2.0 * math.pi / w
    sol = fm.simulate(pushed, t_end=6.0 * period, step=period / 1000, method=fm.Newmark.trapezoidal(), save="steps")
    rest, wd = 80.0 / K, w * math.sqrt(1.0 - D * D)
    t = sol.time
    decay = np.exp(-D * w * t) * (np.cos(wd * t) + D * w / wd * np.sin(wd * t))
    np.testing.assert_allclose(sol.array("B.dx"), rest * (1.0 - decay), atol=2e-4 * rest)
    assert abs(sol.array("energy.residual")).max() < 1e-4 * 80.0 * rest


def test_static_deflection_and_forces_on_the_second_body():
    """A weight hung beside the point: deflection, turn, and the bushing pushes back with as much."""
    body = fm.RigidBody("body", (0.3, 0.1), MASS, INERTIA)
    bush = fm.Bushing("B", fm.GROUND, body, at=(0.2, 0.1), stiffness=K, torsion=TORSION)
    still = fm.static_equilibrium(fm.Mechanism("m", (body, bush), gravity=(0.0, -9.81)))
    turn = still["body.theta"]
    weight = MASS * 9.81
    # moment about the point: kt turn = -W times the lever of the turned body
    assert TORSION * turn == pytest.approx(-weight * 0.1 * math.cos(turn), rel=1e-9)
    assert still["body.y"] == pytest.approx(0.1 - weight / K + 0.1 * math.sin(turn), abs=1e-12)


def test_stiffer_and_stiffer_it_tends_to_a_revolute():
    """A double pendulum: the difference to the ideal one falls as 1/k."""
    first = fm.RigidLink("a", (0.0, 0.0), (0.4, 0.0), 0.5, 7e-3)
    second = fm.RigidLink("b", (0.4, 0.0), (0.8, 0.0), 0.5, 7e-3)
    parts = (first, second, fm.Revolute("O", fm.GROUND, first, at=(0.0, 0.0)))

    def end(joint):
        mech = fm.Mechanism("m", (*parts, joint), gravity=(0.0, -9.81))
        sol = fm.simulate(mech, t_end=0.2, step=1e-4, save=1)
        return np.array([sol.array("b.x")[-1], sol.array("b.y")[-1]])

    ideal = end(fm.Revolute("B", first, second, at=(0.4, 0.0)))
    damping = 50.0
    errors = [
        np.linalg.norm(end(fm.Bushing("B", first, second, at=(0.4, 0.0), stiffness=k, damping=damping)) - ideal)
        for k in (1e5, 1e6)
    ]
    assert errors[1] < 1e-5
    assert math.log10(errors[0] / errors[1]) == pytest.approx(1.0, abs=0.1)


def test_forces_are_in_balance_far_from_the_drawn_pose(posed):
    """Action and reaction between two bodies, moments included, with unequal stiffness along the turned axes."""
    first = fm.RigidBody("a", (0.0, 0.0), 1.0, 1e-3)
    second = fm.RigidBody("b", (0.5, 0.2), 1.0, 1e-3)
    bush = fm.Bushing("B", first, second, at=(0.2, 0.3), stiffness=(1e3, 4e3), damping=(3.0, 9.0), along=(1.0, 2.0))
    moved = {"a": (0.1, 0.3, 0.7), "b": (-0.2, 0.4, -2.0)}
    forces = posed(fm.Mechanism("m", (first, second, bush))).force(moved, {"a": (1.0, 2.0, 3.0), "b": (-2.0, 1.0, 5.0)})
    points = {"a": (0.1, 0.3), "b": (0.3, 0.6)}
    total = sum(np.array(forces[name]) for name in forces)
    moment = total[2] + sum(points[n][0] * forces[n][1] - points[n][1] * forces[n][0] for n in forces)
    scale = np.abs(forces["a"]).max()
    assert scale > 1e2
    assert np.abs([*total[:2], moment]).max() < 1e-12 * scale


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"stiffness": 0.0}, ["'B'", "stiffness", "must be > 0"]),
        ({"stiffness": (1.0, -2.0)}, ["'B'", "stiffness is -2"]),
        ({"stiffness": (1.0, 2.0, 3.0)}, ["'B'", "a number or a pair"]),
        ({"damping": math.nan}, ["'B'", "damping is nan"]),
        ({"torsion": -1.0}, ["'B'", "torsion is -1"]),
        ({"along": (0.0, 0.0)}, ["'B'", "along"]),
    ],
)
def test_bad_input(change, words):
    with pytest.raises(fm.errors.InputError) as error:
        replace(held().find("B"), **change)
    for word in words:
        assert word in str(error.value)
