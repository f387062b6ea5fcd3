"""Momentum of a free rod, energy of a double pendulum of beams, and what the ledger of energies says of them."""

import numpy as np
import pytest

import flexmb as fm
from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.run.run import Run
from flexmb.statics.start.consistent import Start, accelerations, consistent_start

SECTION, SOFT = fm.Rectangle(width=0.02, height=0.02), fm.Material(young=2e9, density=7850.0)
SPIN, VX, VY, LENGTH, NODES = 10.0, 3.0, -2.0, 1.0, 5


def free_rod():
    options = {"section": SECTION, "material": SOFT, "elements": NODES - 1, "velocity": (VX, VY, SPIN)}
    return fm.Mechanism("rod", (fm.FlexibleLink("rod", (0.0, 0.0), (LENGTH, 0.0), **options),))


def bent(bend):
    """Positions of a circular arc of that angle, and the velocities of its rigid motion."""
    angle = bend * np.linspace(0.0, 1.0, NODES)
    q, v = np.zeros(3 * NODES), np.zeros(3 * NODES)
    q[0::3], q[1::3], q[2::3] = np.sin(angle) / bend, (1.0 - np.cos(angle)) / bend, angle
    v[0::3], v[1::3], v[2::3] = VX - SPIN * q[1::3], VY + SPIN * (q[0::3] - 0.5 * LENGTH), SPIN
    return q, v


def momentum(system, q, v):
    """Momentum in x and y [kg m/s], angular momentum about the origin [kg m^2/s]."""
    p = system.mass(q) @ v
    px, py, pt = p[0::3], p[1::3], p[2::3]
    return np.array([px.sum(), py.sum(), (q[0::3] * py - q[1::3] * px + pt).sum()])


def drift(method, step, *, bend, steps=10_000):
    """Largest relative change of the three momenta while the rod flies, and its mean strain energy over the kinetic."""
    program = fm.compile(free_rod())
    system, n = StateEvaluation(program), program.n_q
    q, v = bent(bend)
    run = Run(program, method, fm.FixedStep(step), steps * step, None)
    run.begin(Start(q, v, *accelerations(program, q, v, 0.0)))
    start, worst, strain = momentum(system, q, v), np.zeros(3), []
    for part in range(1, 21):
        run.run_to(part * steps * step / 20, saving=None)
        found = momentum(system, run.flow.q[:n], run.flow.v[:n])
        worst = np.maximum(worst, np.abs(found - start) / np.abs(start))
        strain.append(run.flow.ledger[1])
    assert run.record.count.steps == steps
    return worst.max(), np.array(strain)


def test_momentum_of_the_rod_at_the_start_is_that_of_a_rigid_bar():
    """Straight rod: m v of its middle, and (r x m v) + m L^2/12 omega about the origin."""
    program = fm.compile(free_rod())
    mass = 7850.0 * 4e-4 * LENGTH
    start = consistent_start(free_rod(), program)
    q, v = start.q, start.v
    expected = [mass * VX, mass * VY, mass * 0.5 * LENGTH * VY + mass * LENGTH**2 / 12 * SPIN]
    np.testing.assert_allclose(momentum(StateEvaluation(program), q, v), expected, rtol=1e-13)


def test_a_vibrating_rod_keeps_its_momentum_over_ten_thousand_runge_kutta_steps():
    worst, strain = drift(fm.RungeKutta4(), 5e-6, bend=0.2)
    assert worst < 1e-11
    assert np.ptp(strain) > 0.05  # [J]: it does vibrate


def test_a_vibrating_rod_keeps_its_momentum_over_ten_thousand_implicit_steps():
    """The kinetic energy depends on the rotations, so momentum is kept to the order of the method, not to round-off."""
    worst, strain = drift(fm.Newmark.trapezoidal(), 1e-6, bend=0.01)
    assert worst < 1e-9
    assert np.ptp(strain) > 0.2 * strain.max()


@pytest.mark.parametrize("method", [fm.Newmark.trapezoidal(), fm.Newmark.generalised_alpha(0.8)])
def test_drift_of_momentum_falls_at_second_order(method):
    coarse, fine = (drift(method, h, bend=0.2, steps=round(0.02 / h))[0] for h in (2e-5, 1e-5))
    assert coarse < 1e-5
    assert np.log2(coarse / fine) > 1.9


def double_pendulum(damping=0.0):
    """Two hinged beams under gravity, from rest; they swing and ring."""
    options = {"section": SECTION, "material": SOFT, "elements": 4, "damping": damping}
    upper = fm.FlexibleLink("upper", (0.0, 0.0), (1.0, 0.0), **options)
    lower = fm.FlexibleLink("lower", (1.0, 0.0), (1.6, 0.8), **options)
    joints = (fm.Revolute("O", fm.GROUND, upper, (0.0, 0.0)), fm.Revolute("P", upper, lower, (1.0, 0.0)))
    return fm.Mechanism("pendulum", (upper, lower, *joints), gravity=(0.0, -9.81))


def stored(sol):
    return sol.array("energy.kinetic") + sol.array("energy.strain") + sol.array("energy.gravity")


def test_a_double_pendulum_of_beams_keeps_its_energy():
    changes = []
    for step in (4e-4, 2e-4, 1e-4):
        sol = fm.simulate(double_pendulum(), t_end=1.0, step=step, save="steps", method=fm.Newmark.trapezoidal())
        assert sol.ok, sol.status
        kinetic = sol.array("energy.kinetic").max()
        assert sol.array("energy.strain").max() > 5e-3 * kinetic
        changes.append(np.abs(stored(sol) - stored(sol)[0]).max() / kinetic)
    assert changes[1] < 1e-5
    assert np.log2(changes[0] / changes[1]) > 1.95
    assert np.log2(changes[1] / changes[2]) > 1.95


@pytest.mark.parametrize("method", [fm.Newmark.trapezoidal(), fm.Newmark.generalised_alpha(0.8)])
def test_the_ledger_closes_at_second_order(method):
    """Stored energy, damping and the algorithm: nothing is missing but an error of the second order."""
    rest = []
    for step in (2e-4, 1e-4):
        sol = fm.simulate(double_pendulum(damping=1e-3), t_end=0.5, step=step, save="steps", method=method)
        assert sol.array("energy.dissipated_damping")[-1] > 1e-2
        assert np.diff(sol.array("energy.dissipated_damping")).min() >= 0.0
        rest.append(np.abs(sol.array("energy.residual")).max())
    assert rest[0] < 1e-4 * sol.array("energy.kinetic").max()
    assert np.log2(rest[0] / rest[1]) > 1.9
