"""Factors of Newton's matrix serve many steps, also where corrections are round-off, and their error is none."""

import numpy as np
import pytest

import flexmb as fm


def ladder(rungs):
    """Two chains of links that hang side by side, joined by rungs, and swing from a slanting pose: closed loops."""
    parts, left, right, a, b = [], fm.GROUND, fm.GROUND, (0.0, 0.0), (1.0, 0.0)
    for k in range(rungs):
        c, d = ((x + 0.3, y - 1.0) for x, y in (a, b))
        for name, start, end in (("l", a, c), ("r", b, d), ("u", c, d)):
            parts.append(fm.RigidLink(f"{name}{k}", start, end, mass=1.0, inertia=0.1))
        left_link, right_link, rung = parts[-3:]
        for name, first, second, at in (
            ("A", left, left_link, a),
            ("B", right, right_link, b),
            ("C", left_link, rung, c),
            ("D", right_link, rung, d),
        ):
            parts.append(fm.Revolute(f"{name}{k}", first, second, at=at))
        a, b, left, right = c, d, rung, rung
    return fm.Mechanism("ladder", parts, gravity=(0.0, -9.81))


def chain(links):
    """Rigid links of 10 m in all that begin to fall from a straight line."""
    parts, last, length = [], fm.GROUND, 10.0 / links
    for k in range(links):
        ends = (k * length, 0.0), ((k + 1) * length, 0.0)
        link = fm.RigidLink(f"L{k}", *ends, mass=1.0 / links, inertia=length**2 / 12.0 / links)
        parts += [link, fm.Revolute(f"J{k}", last, link, ends[0])]
        last = link
    return fm.Mechanism("chain", parts, gravity=(0.0, -9.81))


def factors_of_a_step(sol):
    """Factorisations over steps."""
    assert sol.ok
    return sol.stats.factorisations / sol.stats.steps


@pytest.mark.parametrize("step", [2e-4, 5e-5], ids="{:g}".format)
def test_factors_of_a_ladder_serve_small_steps_as_well(step):
    """They were made up to 2.4 times a step: corrections at round-off counted as a poor contraction."""
    sol = fm.simulate(ladder(10), t_end=0.25, step=step, save=2)
    assert factors_of_a_step(sol) < 0.15
    assert sol.stats.evaluations < 3.2 * sol.stats.steps


def test_factors_of_a_long_straight_chain_are_reused():
    """Its pivots are some 2/n: they counted as those of a singular pose, and each iteration had its own factors."""
    sol = fm.simulate(chain(1000), t_end=4e-3, step=1e-4, save=2)
    assert factors_of_a_step(sol) < 1.2
    assert sol.stats.newton_iterations > 2.0 * sol.stats.factorisations


def test_a_ladder_with_reused_factors_converges_with_the_square_of_the_step():
    """Errors of positions and velocities against steps of 25 us, at which corrections are round-off."""

    def end(step):
        sol = fm.simulate(ladder(4), t_end=0.5, step=step, save=2)
        return np.array([sol.array(f"u{k}.{word}")[-1] for k in range(4) for word in ("x", "y", "vx", "vy")])

    exact = end(2.5e-5)
    coarse, fine = (np.abs(end(step) - exact).max() for step in (8e-4, 4e-4))
    assert coarse / fine == pytest.approx(4.0, rel=0.05)
