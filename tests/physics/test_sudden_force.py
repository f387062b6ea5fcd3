"""Steps in which a force begins: what Newton's iterations end with satisfies the equations of motion."""

import numpy as np
import pytest

import flexmb as fm
from flexmb.engine.system.state_evaluation import StateEvaluation


@pytest.mark.parametrize("place", [0.02, 0.5])
@pytest.mark.parametrize("step", [4e-5, 3e-5, 2.3e-5])
def test_the_account_closes_over_impacts_of_one_or_two_steps(place, step):
    """A ball flies to and fro between two walls: mass and normal are constant, so the account closes exactly.

    Free flight predicts no acceleration, so the first correction of an impact is measured by another force than the
    second one; their ratio says nothing of how Newton's iterations converge.
    """
    stone = fm.RigidBody("ball", (place, 0.0), 1.0, 1.0, velocity=(1.0, 0.0, 0.0))
    law = fm.LankaraniNikravesh(stiffness=1e12, restitution=1.0, least_approach=0.0)
    joint = fm.RevoluteClearance("J", fm.GROUND, stone, (place, 0.0), clearance=2e-4, bearing_radius=1e-2, normal=law)
    sol = fm.simulate(fm.Mechanism("ball", (stone, joint)), t_end=2e-3, step=step)
    assert sol.peak("energy.residual").value < 1e-7 * sol.peak("energy.turned_over").value


STEEL, BAR = fm.Material(young=2.1e11, density=7850.0), fm.Rectangle(width=0.01, height=0.02)
TIP = 250.0 * 0.3**3 / (3.0 * 2.1e11 * 0.01 * 0.02**3 / 12.0)
"""Deflection of the cantilever at rest [m], P L^3/(3 E I)."""


def cantilever(elements, **load):
    """A cantilever of steel with 250 N at its tip."""
    rod = fm.FlexibleLink("rod", (0.0, 0.0), (0.3, 0.0), section=BAR, material=STEEL, elements=elements)
    wall = fm.Fixed("wall", fm.GROUND, rod, at=(0.0, 0.0))
    return fm.Mechanism("lever", [rod, wall, fm.Force("P", rod, at=(0.3, 0.0), force=(0.0, -250.0), **load)])


def linear(mechanism, method, h, steps):
    """Deflection of the tip by the method itself on the linear equations M a + K q + G^T lam = f, G q = 0."""
    program = fm.compile(mechanism)
    n, m, state = program.n_q, program.n_c, StateEvaluation(program)
    q0, delta = program.reference.q, method.alpha_m - method.alpha_f
    M, K = (state.at(q0, weights=w).block().toarray() for w in ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0)))
    G = state.at(q0, weights=(0.0, 0.0, 1.0)).jacobian.toarray()
    f, tip = np.zeros(n), n - 2
    f[tip] = -250.0
    saddle = np.block([[M, G.T], [G, np.zeros((m, m))]])
    q, v = np.zeros(n), np.zeros(n)
    a = x = np.linalg.solve(saddle, np.append(f, np.zeros(m)))[:n]
    found = [0.0]
    for step in range(steps):
        s = method.starting if step == 0 else method
        ka = (1.0 - s.alpha_m) / (1.0 - s.alpha_f) / (s.beta * h * h)
        known_a = ((1.0 - s.alpha_m) * 0.0 + s.alpha_m * x - s.alpha_f * a) / (1.0 - s.alpha_f)
        ahead = q + h * v + h * h * (0.5 - s.beta) * x
        saddle[:n, :n] = K + ka * M
        new = np.linalg.solve(saddle, np.append(f - M @ (known_a - ka * ahead), np.zeros(m)))[:n]
        x_new = (new - ahead) / (s.beta * h * h)
        a_new = known_a + ka * (new - ahead)
        v = v + h * ((1.0 - s.gamma) * x + s.gamma * x_new)
        x = a_new + delta * (a_new - a) if step == 0 else x_new
        q, a = new, a_new
        found.append(float(q[tip]))
    return np.array(found)


@pytest.mark.parametrize("method", [fm.Newmark.generalised_alpha(0.8), fm.Newmark.trapezoidal()])
@pytest.mark.parametrize(("elements", "h"), [(4, 3e-3), (4, 1e-3), (4, 3e-4), (16, 1e-3), (16, 3e-4), (16, 1e-4)])
def test_a_load_at_once_on_beams_that_the_steps_do_not_resolve(elements, h, method):
    """The bent rod is that of the linear equations to the second order of its slope, at any step."""
    mechanism = cantilever(elements)
    sol = fm.simulate(mechanism, t_end=50.0 * h, step=h, method=method, save="steps")
    assert sol.ok, sol.status
    exact = linear(mechanism, method, h, 50)
    assert sol["rod.end.y"].values == pytest.approx(exact, abs=0.02 * TIP)


@pytest.mark.parametrize("h", [1e-3, 3e-4])
def test_a_jump_of_the_load_in_the_middle_of_a_run(h):
    sol = fm.simulate(cantilever(4, history=fm.drives.Pulse(1.0, start=0.01)), t_end=0.05, step=h, save="steps")
    assert sol.ok, sol.status
    y = sol["rod.end.y"].values
    assert -2.05 * TIP < y.min() < -1.8 * TIP
    assert y.max() < 0.02 * TIP


@pytest.mark.parametrize(("elements", "h"), [(4, 1e-3), (16, 3e-4)])
def test_a_rod_let_go_from_its_bent_pose(elements, h):
    """It swings about the straight pose, by no more than it was bent."""
    bent = fm.static_equilibrium(cantilever(elements))
    nodes = np.array([bent[f"rod.{name}.{axis}"] for name in names(elements) for axis in ("x", "y", "theta")])
    straight = np.array([(0.3 * k / elements, 0.0, 0.0) for k in range(elements + 1)]).ravel()
    shift = tuple(map(tuple, (nodes - straight).reshape(-1, 3)))
    rod = fm.FlexibleLink(
        "rod", (0.0, 0.0), (0.3, 0.0), section=BAR, material=STEEL, elements=elements, displacement=shift
    )
    sol = fm.simulate(
        fm.Mechanism("free", [rod, fm.Fixed("wall", fm.GROUND, rod, at=(0.0, 0.0))]), t_end=50 * h, step=h, save="steps"
    )
    assert sol.ok, sol.status
    assert np.abs(sol["rod.end.y"].values).max() < 1.02 * TIP


def names(elements):
    """Names of the nodes of the rod."""
    return ["start", *(f"node{k}" for k in range(1, elements)), "end"]
