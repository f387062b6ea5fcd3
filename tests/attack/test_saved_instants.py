"""Every instant that was asked for is saved, whatever the step and the room in the buffer."""

import math

import numpy as np
import pytest

import flexmb as fm


def free_fall() -> fm.Mechanism:
    body = fm.RigidBody("body", at=(0.0, 0.0), mass=2.0, inertia=0.1, velocity=(1.0, 3.0, 2.0))
    return fm.Mechanism("fall", [body], gravity=(0.0, -9.81))


@pytest.mark.parametrize(("step", "save"), [(1.0, 1000), (0.5, 3000), (1.0 / 3.0, 1537), (0.007, 5000)])
def test_a_step_may_pass_more_instants_than_the_buffer_holds(step, save):
    sol = fm.simulate(free_fall(), t_end=1.0, step=step, save=save)
    assert sol.ok
    np.testing.assert_allclose(sol.time, np.linspace(0.0, 1.0, save + 1), atol=1e-12)
    np.testing.assert_allclose(sol.array("body.y"), 3.0 * sol.time - 0.5 * 9.81 * sol.time**2, atol=1e-12)


def test_instants_of_a_step_are_not_drawn_from_the_next_one():
    """Between two steps accelerations are drawn as parabolas: no jump of their second difference may lie elsewhere."""
    body = fm.RigidBody("body", at=(1.0, 0.0), mass=1.0, inertia=0.1)
    spring = fm.SpringDamper("spring", fm.GROUND, body, at=(0.0, 0.0), to=(1.0, 0.0), stiffness=100.0, free_length=0.9)
    sol = fm.simulate(fm.Mechanism("mass", [body, spring]), t_end=2.0, step=0.02, save=1000)
    a = sol.array("body.ax")
    jumps = np.flatnonzero(np.abs(np.diff(a, 3)) > 1e-11 * np.abs(a).max()) + 2
    assert len(jumps) > 50
    assert np.all(np.minimum(jumps % 10, (jumps - 1) % 10) == 0), "10 instants a step: a jump inside a step"


def test_max_steps_keeps_the_instants_of_its_last_step():
    sol = fm.simulate(free_fall(), t_end=1.0, step=0.25, save=4000, max_steps=3)
    assert not sol.ok
    np.testing.assert_allclose(sol.time, np.linspace(0.0, 0.75, 3001), atol=1e-12)


def test_two_drives_meet_after_their_common_period():
    """Speeds 2 and -3 rad/s: after 2 pi s the cranks have made 2 and -3 turns."""
    a = fm.RigidLink("a", (0.0, 0.0), (0.1, 0.0), mass=0.1, inertia=1e-4)
    b = fm.RigidLink("b", (0.5, 0.0), (0.6, 0.0), mass=0.1, inertia=1e-4)
    joints = [fm.Revolute("A", fm.GROUND, a, at=(0.0, 0.0)), fm.Revolute("B", fm.GROUND, b, at=(0.5, 0.0))]
    drives = [fm.Drive("da", "A", fm.ConstantSpeed(2.0)), fm.Drive("db", "B", fm.ConstantSpeed(-3.0))]
    sol = fm.simulate(fm.Mechanism("two", [a, b, *joints, *drives]), periods=1, save=1)
    assert sol.time.tolist() == pytest.approx([0.0, 2.0 * math.pi])
    assert sol.array("a.theta")[-1] == pytest.approx(4.0 * math.pi)
    assert sol.array("b.theta")[-1] == pytest.approx(-6.0 * math.pi)
