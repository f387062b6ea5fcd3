"""Friction in ideal joints: decay in closed form, an independent equation of motion, tangents, order, messages."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import flexmb as fm
from flexmb.engine.system.state_evaluation import StateEvaluation

MU, RADIUS, G = 0.2, 0.02, 9.81
COULOMB = fm.ModifiedCoulomb(MU, v0=0.0, v1=1e-5)


def test_amplitudes_fall_along_a_straight_line():
    """A wheel on a coil spring, pinned at its centre of mass and preloaded by P: every half swing loses 2 mu P R / k.

    The pin carries nothing but the preload, so its torque is mu P R, exactly, and each half swing is a cosine about a
    rest position shifted by it.
    """
    J, k, P, first = 0.02, 50.0, 40.0, 0.5
    wheel = fm.RigidBody("wheel", (0.0, 0.0), 1.0, J)
    turn = math.sqrt(k / J)
    parts = (
        wheel,
        fm.Revolute("O", fm.GROUND, wheel, at=(0.0, 0.0), friction=COULOMB, radius=RADIUS, preload=P),
        fm.TorsionSpring("coil", fm.GROUND, wheel, stiffness=k, free_angle=first),
    )
    half = math.pi / turn
    sol = fm.simulate(fm.Mechanism("wheel", parts), t_end=6 * half, step=half / 2000, save=6)
    loss = 2.0 * MU * P * RADIUS / k
    # from -first about the rest angle `first`: 0 is the start, the deviation changes its sign every half swing
    expected = [first + (-1) ** (n + 1) * (first - n * loss) for n in range(7)]
    np.testing.assert_allclose(sol.array("wheel.theta"), expected, atol=2e-4 * first)
    assert abs(sol.array("energy.residual")[-1]) < 1e-5 * 0.5 * k * first**2


def pendulum(mu=MU):
    bar = fm.RigidLink("bar", (0.0, 0.0), (1.0, 0.0), 2.0, 2.0 / 12.0, velocity=(0.0, -0.5, -1.0))
    law = fm.ModifiedCoulomb(mu, v0=0.0, v1=1e-5)
    pin = fm.Revolute("O", fm.GROUND, bar, at=(0.0, 0.0), friction=law, radius=RADIUS)
    return fm.Mechanism("pendulum", (bar, pin), gravity=(0.0, -G))


def fallen(t_end, mu=MU):
    """Angle of the bar after t_end, thrown down at 1 rad/s from the horizontal, from its own equation of motion.

    J a = -m g (l/2) cos(theta) - mu R |F| sign(w) with F = m (a_c - g), which contains a: solved for it.
    """
    m, arm, J = 2.0, 0.5, 2.0 / 3.0

    def acceleration(theta, w):
        def rest(a):
            fx = m * (-a * arm * math.sin(theta) - w * w * arm * math.cos(theta))
            fy = m * (a * arm * math.cos(theta) - w * w * arm * math.sin(theta) + G)
            # falling: the speed is negative, friction positive
            return J * a + m * G * arm * math.cos(theta) - mu * RADIUS * math.hypot(fx, fy)

        return brentq(rest, -50.0, 50.0, xtol=1e-14)

    found = solve_ivp(lambda t, y: [y[1], acceleration(*y)], (0.0, t_end), [0.0, -1.0], rtol=1e-11, atol=1e-13)
    return float(found.y[0, -1])


@pytest.mark.parametrize(
    ("method", "order", "steps"),
    [(fm.Newmark.generalised_alpha(0.8), 1.9, (4e-3, 2e-3)), (fm.RungeKutta4(), 3.7, (2e-2, 1e-2))],
    ids=["alpha", "runge-kutta"],
)
def test_a_falling_bar_with_a_rubbing_pin(method, order, steps):
    """Against its own equation of motion, in which the pin's force holds the acceleration; order of convergence."""
    exact, mech, errors = fallen(0.6), pendulum(), []
    for step in steps:
        sol = fm.simulate(mech, t_end=0.6, step=step, method=method, save=1)
        assert sol.ok, sol.status
        errors.append(abs(sol.array("bar.theta")[-1] - exact))
    assert math.log2(errors[0] / errors[1]) > order, errors
    assert errors[1] < 0.02 * abs(fallen(0.6, 0.0) - exact)  # far smaller than what friction does


def test_a_slider_is_braked_by_its_weight_its_preload_and_its_couple():
    """N = |F/2 + M/l| + |F/2 - M/l| + P: weight and preload; and where the weight hangs beside the slider, 2 M/l."""
    mass, v0, P, length = 1.5, 3.0, 4.0, 0.1
    slider = fm.RigidBody("slider", (0.0, 0.0), mass, 1e-2, velocity=(v0, 0.0, 0.0))
    for lever in (0.0, 0.2):
        options = {"friction": COULOMB, "length": length, "preload": P, "at": (lever, 0.0)}
        mech = fm.Mechanism("m", (slider, fm.Prismatic("G", fm.GROUND, slider, **options)), gravity=(0.0, -G))
        N = max(mass * G, 2.0 * mass * G * lever / length) + P
        sol = fm.simulate(mech, t_end=0.2, step=1e-3, save=1)
        assert sol.array("slider.x")[-1] == pytest.approx(v0 * 0.2 - 0.5 * MU * N / mass * 0.04, rel=1e-9)
        assert sol.array("G.friction_force")[-1] == pytest.approx(-MU * N, rel=1e-9)
        lost = 0.5 * mass * (v0**2 - sol.array("slider.vx")[-1] ** 2)
        assert sol.array("energy.dissipated_friction")[-1] == pytest.approx(lost, rel=1e-9)


def two_sliders():
    """A bar pinned with friction to a slider that rubs in a guide on a turning arm."""
    arm = fm.RigidBody("arm", (0.2, 0.05), 1.0, 0.02)
    slider = fm.RigidBody("slider", (0.3, 0.2), 0.5, 1e-3, theta=0.4)
    bar = fm.RigidLink("bar", (0.3, 0.2), (0.6, -0.1), 0.7, 0.01)
    law = fm.ModifiedCoulomb(0.3, v0=0.0, v1=1e3)
    parts = (
        fm.Revolute("O", fm.GROUND, arm, at=(0.0, 0.0), friction=law, radius=0.05),
        fm.Prismatic("G", arm, slider, along=(1.0, 0.5), friction=law, length=0.2, preload=3.0),
        fm.Revolute("A", slider, bar, at=(0.3, 0.2), friction=law, radius=0.03, preload=1.0),
    )
    return fm.Mechanism("rubbing", (arm, slider, bar, *parts), gravity=(0.0, -G))


@pytest.mark.parametrize("seed", range(5))
def test_the_matrix_is_the_slope_of_the_forces(seed):
    """By coordinates, velocities and multipliers, friction on two joints' forces included."""
    program = fm.compile(two_sliders())
    system, rng, n = StateEvaluation(program), np.random.default_rng(seed), program.n_q
    q = np.array(program.reference.q) + 0.1 * rng.standard_normal(n)
    v, lam = rng.standard_normal(n), 30.0 * rng.standard_normal(program.n_c)

    def force(q, v, lam):
        system.at(q, v, lam=lam)
        return system.force + system.constraint_force

    full = system.at(q, v, lam=lam, weights=(1.0, 0.0, 0.0)).matrix.toarray()[:n]
    damping = system.at(q, v, lam=lam, weights=(0.0, 1.0, 0.0)).block().toarray()
    for exact, shifted, count in (
        (full[:, :n], lambda d: force(q + d, v, lam), n),
        (damping, lambda d: force(q, v + d, lam), n),
        (full[:, n:], lambda d: force(q, v, lam + d), program.n_c),
    ):
        columns = [(shifted(d) - shifted(-d)) / 2e-6 for d in 1e-6 * np.eye(count)]
        assert abs(np.array(columns).T - exact).max() <= 1e-7 * max(abs(exact).max(), 1.0)


def test_energy_is_only_lost():
    sol = fm.simulate(two_sliders().with_({"G.friction.v1": 1e-3, "A.friction.v1": 1e-3}), t_end=0.5, save="steps")
    assert sol.ok, sol.status
    lost = sol.array("energy.dissipated_friction")
    assert np.diff(lost).min() >= 0.0
    assert abs(sol.array("energy.residual")).max() < 1e-3 * lost[-1]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"friction": 0.3}, ["'O'", "friction is 0.3", "friction law"]),
        ({"friction": COULOMB}, ["'O'", "radius is missing", "radius=..."]),
        ({"friction": COULOMB, "radius": -0.1}, ["'O'", "radius is -0.1"]),
        ({"friction": COULOMB, "radius": 0.1, "preload": -1.0}, ["'O'", "preload is -1"]),
        ({"radius": 0.1}, ["'O'", "belong to friction"]),
    ],
)
def test_bad_input(change, words):
    bar = fm.RigidLink("bar", (0.0, 0.0), (1.0, 0.0), 1.0, 0.1)
    with pytest.raises(fm.errors.InputError) as error:
        fm.Revolute("O", fm.GROUND, bar, at=(0.0, 0.0), **change)
    for word in words:
        assert word in str(error.value)


def test_friction_without_a_solution_is_told_as_such():
    """A rod hinged to a light slider wedges it: the friction that its weight asks for grows with itself."""
    angle, rub = 2.2, fm.ModifiedCoulomb(3.0, v0=0.0, v1=1e-3)
    slider = fm.RigidBody("slider", (0.0, 0.0), mass=0.01, inertia=1e-6, velocity=(1.0, 0.0, 0.0))
    rod = fm.RigidLink("rod", (0.0, 0.0), (math.cos(angle), math.sin(angle)), mass=1.0, inertia=1.0 / 12.0)
    guide = fm.Prismatic("guide", fm.GROUND, slider, at=(0.0, 0.0), along=(1.0, 0.0), friction=rub, length=0.1)
    parts = [slider, rod, guide, fm.Revolute("pin", slider, rod, at=(0.0, 0.0))]
    sol = fm.simulate(fm.Mechanism("wedged", parts, gravity=(0.0, -G)), t_end=0.2)
    assert not sol.ok
    assert "may lock the mechanism or have no solution" in sol.status
