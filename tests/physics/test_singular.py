"""Joints that say nothing new: at a singular position, exactly there or beside it, and in every pose."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import AssemblyError, ModelError

RULES = {
    "rk4": fm.RungeKutta4(),
    "alpha": fm.Newmark.generalised_alpha(0.8),
    "trapezoidal": fm.Newmark.trapezoidal(),
    "alpha-position": fm.Newmark.generalised_alpha(0.8, "position"),
}
START = -math.pi / 4
SPAN = 1.5


def parallelogram(speed=1.0, gravity=9.81):
    """Two cranks of 1 m, 1.5 m apart, the first one driven from -45 degrees: they lie flat after pi/4, 5 pi/4 s ..."""
    c, s = math.cos(START), math.sin(START)
    bodies = (
        fm.RigidLink("crank", (0.0, 0.0), (c, s), 1.0, 0.1),
        fm.RigidLink("coupler", (c, s), (c + SPAN, s), 1.0, 0.1),
        fm.RigidLink("rocker", (SPAN, 0.0), (SPAN + c, s), 1.0, 0.1),
    )
    crank, coupler, rocker = bodies
    joints = (
        fm.Revolute("O", fm.GROUND, crank, (0.0, 0.0)),
        fm.Revolute("A", crank, coupler, (c, s)),
        fm.Revolute("B", coupler, rocker, (c + SPAN, s)),
        fm.Revolute("D", fm.GROUND, rocker, (SPAN, 0.0)),
    )
    motor = fm.Drive("motor", "O", fm.ConstantSpeed(speed))
    return fm.Mechanism("parallelogram", (*bodies, *joints, motor), gravity=(0.0, -gravity))


def turned(sol):
    """Largest angle between rocker and crank, rotation of the coupler: both 0 on the branch of the start."""
    return max(
        np.abs(sol.array("rocker.theta") - sol.array("crank.theta")).max(), np.abs(sol.array("coupler.theta")).max()
    )


@pytest.mark.parametrize(
    ("rule", "steps"),
    [
        pytest.param(rule, steps, marks=pytest.mark.slow if steps == 1000 and rule != "alpha-position" else ())
        for rule in RULES
        for steps in (100, 1000)
        if (rule, steps) != ("trapezoidal", 100)
    ],
)
def test_a_step_that_ends_in_the_singular_position(rule, steps):
    """Steps of pi/4 over a whole number: one ends exactly where all links lie on one line, and two turns follow.

    The trapezoidal rule forgets nothing: accelerations of the rotation that is free for a step ring on, and with a
    hundred steps they take the mechanism to its other branch.
    """
    h = math.pi / 4 / steps
    sol = fm.simulate(parallelogram(), t_end=4 * math.pi, step=h, save="steps", method=RULES[rule])
    assert sol.ok, sol.status
    assert "Passed a singular position at t = 0.785" in sol.status
    assert "'O', 'A', 'B', 'D' are not unique" in sol.status
    # between the steps before and after it the joints leave a rotation free: an error of the size h^2
    assert turned(sol) < 2.0 * h * h * 9.81
    assert turned_late(sol) < 1e-9


def turned_late(sol):
    """`turned` a tenth of a radian and more beside the singular positions: there the joints hold."""
    away = np.abs(np.sin(sol.array("crank.theta"))) > 0.1
    rocker = np.abs(sol.array("rocker.theta") - sol.array("crank.theta"))[away].max()
    return max(rocker, np.abs(sol.array("coupler.theta"))[away].max())


@pytest.mark.parametrize("rule", ["rk4", "alpha", "trapezoidal"])
@pytest.mark.parametrize("step", [7e-3, 1.3e-3, pytest.param(2.1e-4, marks=pytest.mark.slow)])
def test_steps_of_any_size_keep_the_branch(rule, step):
    sol = fm.simulate(parallelogram(), t_end=4 * math.pi, step=step, save="steps", method=RULES[rule])
    assert sol.ok, sol.status
    assert turned(sol) < 2.0 * 9.81 * step**2
    assert turned_late(sol) < 1e-9


def test_error_controlled_steps_keep_the_branch():
    sol = fm.simulate(parallelogram(), t_end=4 * math.pi)
    assert sol.ok, sol.status
    assert turned(sol) < 1e-6


CRANKS = (0.0, 1.0, 2.5)
TORQUE, MASS, PLATE = 2.0, 1.0, 3.0


def three_cranks(at=1.0, torque=TORQUE, gravity=0.0):
    """A plate on three parallel cranks of 1 m: one of the twelve rows of their six joints is too many."""
    c, s = math.cos(at), math.sin(at)
    cranks = [fm.RigidLink(f"crank{k}", (x, 0.0), (x + c, s), MASS, MASS / 12) for k, x in enumerate(CRANKS)]
    plate = fm.RigidBody("plate", (1.2 + c, s + 0.1), PLATE, 0.5)
    feet = [fm.Revolute(f"A{k}", fm.GROUND, cranks[k], (CRANKS[k], 0.0)) for k in range(3)]
    heads = [fm.Revolute(f"B{k}", cranks[k], plate, (CRANKS[k] + c, s)) for k in range(3)]
    parts = (*cranks, plate, *feet, *heads, fm.Torque("motor", cranks[0], torque))
    return fm.Mechanism("three cranks", parts, gravity=(0.0, -gravity))


INERTIA = 3 * MASS / 3 + PLATE
"""Of the one degree of freedom, about the feet: every crank m l^2/3, the plate as a point at 1 m [kg m^2]."""


@pytest.mark.parametrize("rule", ["rk4", "alpha", "trapezoidal"])
def test_three_parallel_cranks_turn_as_one(rule):
    """Constant torque on one degree of freedom: angle = T t^2 / (2 I), before the cranks lie flat at 2.93 s."""
    sol = fm.simulate(three_cranks(), t_end=2.5, step=1e-3, save="steps", method=RULES[rule], redundant="least-norm")
    assert sol.ok, sol.status
    assert "The joints 'A0', 'A1', 'A2', 'B0', 'B1', 'B2' repeat one another" in sol.status
    angle = 0.5 * TORQUE / INERTIA * sol.time**2
    for k in range(3):
        np.testing.assert_allclose(sol.array(f"crank{k}.theta") - 1.0, angle, atol=1e-6)
    assert np.abs(sol.array("plate.theta")).max() < 1e-12
    # together the pins do what the plate needs: m a of its circular translation, whatever their shares
    spin, turn = TORQUE / INERTIA * sol.time, sol.array("crank0.theta")
    ax = -np.sin(turn) * TORQUE / INERTIA - np.cos(turn) * spin**2
    total = sum(sol.array(f"B{k}.fx") for k in range(3))
    np.testing.assert_allclose(total, PLATE * ax, atol=1e-4)


PINS = ("A0", "A1", "A2", "B0", "B1", "B2")


def multipliers(sol):
    """Forces of all joints (12, n) [N], each pin's x and y: the multipliers but for their sign."""
    return np.array([sol.array(f"{name}.{axis}") for name in PINS for axis in ("fx", "fy")])


def test_forces_of_redundant_joints_are_those_of_least_norm():
    """The forces without effect run along the cranks, foot and head alike, in shares that put no load on the plate."""
    sol = fm.simulate(three_cranks(), t_end=1.0, step=1e-3, save=10, redundant="least-norm")
    forces = multipliers(sol)
    # shares s with sum s = 0 and sum s x = 0: opposite forces on the plate that meet in no moment
    shares = np.array([CRANKS[1] - CRANKS[2], CRANKS[2] - CRANKS[0], CRANKS[0] - CRANKS[1]])
    angle = sol.array("crank0.theta")
    along = np.array([np.cos(angle), np.sin(angle)])
    null = np.concatenate([np.concatenate([s * along for s in shares])] * 2)
    overlap = np.abs((forces * null).sum(axis=0))
    assert overlap.max() < 1e-6 * np.linalg.norm(forces, axis=0).max()


@pytest.mark.parametrize("step", [1e-4, 2e-5])
def test_redundant_joints_pass_a_singular_position(step):
    """Where round-off in the redundant row is larger than the pivots that are needed, its multiplier was anything."""
    model = three_cranks(gravity=9.81)
    parts = [part for part in model.parts if part.name != "motor"]
    model = fm.Mechanism("driven", (*parts, fm.Drive("motor", "A0", fm.ConstantSpeed(5.0))), gravity=(0.0, -9.81))
    flat = (math.pi - 1.0) / 5.0
    begin, end = flat - 0.02, flat + 0.02
    common = {"t_end": end, "save_from": begin, "save": 80, "redundant": "least-norm"}
    sol = fm.simulate(model, step=step, **common)
    exact = fm.simulate(model, method=fm.DormandPrince(), step=fm.Adaptive(rtol=1e-9), **common)
    assert sol.ok, sol.status
    assert exact.ok, exact.status
    # forces grow as the inverse of the distance; the method damps what passing leaves behind in some hundred steps
    far = (sol.time < flat - 5e-4) | (sol.time > flat + 100.0 * step)
    found, wanted = multipliers(sol)[:, far], multipliers(exact)[:, far]
    assert np.abs(found - wanted).max() < 1e-3 * np.abs(wanted).max()


def test_a_restart_of_redundant_joints_goes_on_bit_for_bit():
    options = {"step": 2.0**-10, "redundant": "least-norm"}
    whole = fm.simulate(three_cranks(), t_end=1.0, **options)
    half = fm.simulate(three_cranks(), t_end=0.5, **options)
    rest = fm.simulate(three_cranks(), t_end=1.0, restart=half.restart, **options)
    for name, array in whole.restart.items():
        assert array.tobytes() == rest.restart[name].tobytes(), name


def test_redundant_joints_are_refused_unless_asked_for():
    with pytest.raises((AssemblyError, ModelError), match=r"redundant='least-norm'"):
        fm.simulate(three_cranks(), t_end=1.0, step=1e-3)


def test_a_start_in_a_singular_position_is_refused_in_any_case():
    with pytest.raises(AssemblyError, match=r"starts in a singular pose"):
        fm.simulate(three_cranks(at=0.0), t_end=1.0, step=1e-3, redundant="least-norm")


def test_joints_that_are_independent_do_not_care():
    plain = fm.simulate(parallelogram(), t_end=0.5, step=1e-3)
    asked = fm.simulate(parallelogram(), t_end=0.5, step=1e-3, redundant="least-norm")
    assert plain.status == asked.status == "Finished at t = 0.5 s."
    np.testing.assert_array_equal(plain.values, asked.values)
