"""Steps in which a force begins: what Newton's iterations end with satisfies the equations of motion."""

import pytest

import flexmb as fm


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
