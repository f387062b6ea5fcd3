"""Control laws that jump: instants of relays against motions in closed form, by all methods with an estimate."""

import itertools
import math

import numpy as np
import pytest

import flexmb as fm

FORCE, MASS, DAMPING = 2.0, 1.0, 0.2
METHODS = {"newmark": (fm.Newmark.generalised_alpha(), 5e-5), "radau": (fm.RadauIIA(), 1e-5)}
METHODS["dormand-prince"] = fm.DormandPrince(), 1e-4


@fm.control_kernel
def relay(p, t, u, x, dx, y):
    y[0] = -p[0] if u[0] > 0.0 else p[0]


@fm.control_kernel
def counter(p, t, u, x, dx, y):
    """The time with u > 0, less that with u < 0."""
    dx[0] = 1.0 if u[0] > 0.0 else -1.0
    y[0] = x[0]


def carriage(*parts, control="body.x"):
    """A body on a guide, 1 m from the middle, at rest, pushed to the middle by a relay."""
    body = fm.RigidBody("body", at=(1.0, 0.0), mass=MASS, inertia=1.0)
    guide = fm.Prismatic("guide", fm.GROUND, body, along=(1.0, 0.0))
    push = fm.Force("push", body, at=(1.0, 0.0), force=(1.0, 0.0))
    switch = fm.Control("relay", [control], ["push"], relay, numbers=[FORCE])
    return fm.Mechanism("carriage", [body, guide, push, switch, *parts])


def spring(**numbers):
    """A spring or damper along the guide, without force in the middle."""
    body = fm.RigidBody("body", at=(1.0, 0.0), mass=MASS, inertia=1.0)
    return fm.SpringDamper("s", fm.GROUND, body, at=(-2.0, 0.0), to=(1.0, 0.0), free_length=2.0, **numbers)


def swings(t):
    """Place and velocity at a time [s]: parabolas of 2 s between reversals of the force at odd seconds."""
    s, sign = t % 4.0, 1.0
    s, sign = (s - 2.0, -1.0) if 1.0 <= s < 3.0 else (s - 4.0 if s >= 3.0 else s, sign)
    return sign * (1.0 - s * s), -2.0 * sign * s


def damped(t, damping=DAMPING):
    """Place and velocity of the damped carriage, from one reversal to the next."""
    x, v, side, c = 1.0, 0.0, 1.0, damping / MASS
    while True:
        top = -side * FORCE / damping  # speed that the force would reach

        def place(s, x=x, v=v, top=top):
            return x + top * s + (v - top) * -math.expm1(-c * s) / c

        grid = np.linspace(1e-9, t, 20001)
        values = side * np.array([place(s) for s in grid])
        beyond = np.flatnonzero(values < 0.0)
        if not len(beyond):
            return place(t), top + (v - top) * math.exp(-c * t)
        low, high = grid[beyond[0] - 1], grid[beyond[0]]
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if side * place(middle) > 0.0 else (low, middle)
        x, v, t, side = 0.0, top + (v - top) * math.exp(-c * high), t - high, -side


@pytest.mark.parametrize(("method", "accuracy"), METHODS.values(), ids=METHODS)
def test_a_relay_switches_at_its_instants_with_default_steps(method, accuracy):
    """Ten reversals of a force of 2 N; steps across them had an error of 1 % of the amplitude."""
    sol = fm.simulate(carriage(), t_end=20.3, method=method)
    found = float(sol["body.x"][-1]), float(sol["body.vx"][-1])
    assert sol.ok
    assert found == pytest.approx(swings(20.3), abs=2.0 * accuracy)


def test_the_error_of_a_relay_falls_with_the_tolerance():
    """Down to 1e-8: steps of 1 ns across jumps must leave no false acceleration to the step behind them."""
    errors = []
    for rtol in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8):
        sol = fm.simulate(carriage(), t_end=20.3, step=fm.Adaptive(rtol=rtol))
        errors.append(abs(float(sol["body.x"][-1]) - swings(20.3)[0]) / rtol)
    assert max(errors) < 1.0


@pytest.mark.slow
@pytest.mark.parametrize("damping", [DAMPING, 0.1, 0.37])
def test_the_error_of_a_relay_falls_with_the_tolerance_and_with_a_damper(damping):
    """A damper turns the acceleration round between two jumps, which hid them from the estimate of the error."""
    model, exact = carriage(spring(stiffness=0.0, damping=damping)), damped(12.3, damping)
    errors = []
    for rtol in (1e-4, 1e-5, 1e-6, 1e-7):
        sol = fm.simulate(model, t_end=12.3, step=fm.Adaptive(rtol=rtol))
        errors.append(abs(float(sol["body.vx"][-1]) - exact[1]))
    assert errors[0] < 2.5e-3 * max(damping, DAMPING)
    assert all(fine < 0.4 * coarse for coarse, fine in itertools.pairwise(errors))
    assert errors[-1] < 1e-5


def test_a_rate_that_jumps_is_met():
    """The state of a law counts the time on each side of the middle: 0.3 s more on the right at 20.3 s."""
    count = fm.Control("count", ["body.x"], [], counter, states={"time": 0.0}, outputs=["out"])
    sol = fm.simulate(carriage(count), t_end=20.3)
    assert float(sol["count.time"][-1]) == pytest.approx(0.3, abs=1e-4)


@pytest.mark.quick(1)
@pytest.mark.parametrize(("method", "t_end", "most"), [("newmark", 6.0, 2_000), ("dormand-prince", 2.6, 10_000)])
def test_a_law_that_slides_along_its_jump_comes_to_rest(method, t_end, most):
    """Dry friction as a law, sign(v): from 1 m two half swings shorten by 2 F/k = 4/7 m each, and it holds at -1/7."""
    sol = fm.simulate(carriage(spring(stiffness=7.0), control="body.vx"), t_end=t_end, method=METHODS[method][0])
    assert sol.ok
    assert float(sol["body.x"][-1]) == pytest.approx(-1.0 / 7.0, abs=2e-4)
    assert sol.stats.steps < most
