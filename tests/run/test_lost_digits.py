"""Runs whose state has lost its digits."""

import pytest

import flexmb as fm


@pytest.mark.parametrize(("step", "said"), [(1.0, "no longer finite"), (0.25, "energies do not add up")])
def test_steps_that_are_much_too_large_are_no_success(step, said):
    links = [
        fm.RigidLink("upper", (0.0, 0.0), (0.3, 0.1), mass=0.5, inertia=0.5 * 0.1 / 12.0),
        fm.RigidLink("lower", (0.3, 0.1), (0.8, -0.2), mass=0.5, inertia=0.5 * 0.34 / 12.0),
    ]
    pins = [fm.Revolute("O", fm.GROUND, links[0], (0.0, 0.0)), fm.Revolute("A", *links, (0.3, 0.1))]
    mech = fm.Mechanism("double pendulum", [*links, *pins], gravity=(0.0, -9.81))
    sol = fm.simulate(mech, t_end=1.0, method=fm.DormandPrince(), step=step)
    assert not sol.ok
    assert said in sol.status
