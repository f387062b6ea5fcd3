"""The shallow truss of von Mises: statics reach the limit load, and say so beyond it."""

import math

import pytest

import flexmb as fm

HALF_SPAN, RISE, STIFFNESS = 1.0, 0.2, 1000.0
LENGTH = math.hypot(HALF_SPAN, RISE)
LIMIT = 2.0 * STIFFNESS * (LENGTH ** (2 / 3) - HALF_SPAN ** (2 / 3)) ** 1.5
"""P(y) = 2 k (L0 - l) y/l with l^2 = b^2 + y^2 is largest where l^3 = L0 b^2: P = 2 k (L0^(2/3) - b^(2/3))^(3/2).
Source of the truss: R. von Mises, Zeitschrift fuer angewandte Mathematik und Mechanik 3 (1923) 406-422."""


def truss(load):
    """A point between two springs; the load presses it down."""
    node = fm.RigidBody("node", (0.0, RISE), mass=1.0, inertia=1.0)
    feet = [("left", (-HALF_SPAN, 0.0)), ("right", (HALF_SPAN, 0.0))]
    springs = [fm.SpringDamper(name, fm.GROUND, node, at, (0.0, RISE), stiffness=STIFFNESS) for name, at in feet]
    hold = fm.TorsionSpring("hold", fm.GROUND, node, stiffness=1.0)
    return fm.Mechanism("truss", (node, *springs, hold, fm.Force("P", node, (0.0, RISE), (0.0, -load))))


@pytest.mark.parametrize("load_steps", [1, 10, 100])
@pytest.mark.parametrize("share", [0.5, 0.99, 0.9999])
def test_below_the_limit_load_the_springs_carry_it(share, load_steps):
    y = fm.static_equilibrium(truss(share * LIMIT), load_steps)["node.y"]
    l = math.hypot(HALF_SPAN, y)
    assert math.sqrt((LENGTH * HALF_SPAN**2) ** (2 / 3) - HALF_SPAN**2) < y < RISE, "not the branch of the drawn pose"
    assert 2.0 * STIFFNESS * (LENGTH - l) * y / l == pytest.approx(share * LIMIT, rel=1e-9)


@pytest.mark.parametrize("share", [1.001, 3.0])
def test_beyond_the_limit_load_the_message_names_the_share_that_is_carried(share):
    with pytest.raises(fm.errors.SolveError, match=r"beyond \S+ % of the loads.*'node\.y'.*snaps through") as caught:
        fm.static_equilibrium(truss(share * LIMIT))
    carried = float(str(caught.value).split("beyond ")[1].split(" %")[0])
    assert carried == pytest.approx(100.0 / share, rel=0.01)
