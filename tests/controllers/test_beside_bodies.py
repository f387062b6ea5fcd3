"""States of controllers, which stand behind the coordinates of bodies, are never taken for coordinates of bodies."""

from pathlib import Path

import numpy as np
import pytest

import flexmb as fm
from flexmb.cli.command_line import main
from flexmb.results.positions import momentum


def servo(**more):
    return fm.PID("servo", "arm.theta", "actuator", target=1.0, kp=20.0, ki=10.0, kd=2.0, **more)


def codes(report):
    """Codes of findings; frequencies are those of mechanisms without states of controllers alone."""
    return {finding.code for finding in report.findings} - {"no-frequencies"}


def crank_with_massless_rod(*, controlled=True, held=True, first=False):
    """A crank that moves a slider by a massless rod."""
    arm = fm.RigidLink("arm", (0.0, 0.0), (0.5, 0.0), mass=1.0, inertia=1.0 / 48.0)
    rod = fm.RigidLink("rod", (0.5, 0.0), (1.0, 0.0), mass=0.0, inertia=0.0)
    slider = fm.RigidBody("slider", (1.0, 0.0), 1.0, 1.0)
    parts = [
        arm,
        rod,
        slider,
        fm.Revolute("A", fm.GROUND, arm, at=(0.0, 0.0)),
        fm.Revolute("B", arm, rod, at=(0.5, 0.0)),
    ]
    parts += [fm.Revolute("C", rod, slider, at=(1.0, 0.0))] if held else []
    parts += [fm.Prismatic("guide", fm.GROUND, slider, at=(1.0, 0.0)), fm.Torque("actuator", arm, 1.0)]
    pid = [servo()] if controlled else []
    return fm.Mechanism("press", [*pid, *parts] if first else [*parts, *pid], gravity=(0.0, -9.81))


@pytest.mark.parametrize("first", [False, True])
def test_a_massless_link_beside_a_controller_with_states(first, tmp_path):
    """fm.check and fm.report ended with "index 3 is out of bounds"."""
    mechanism = crank_with_massless_rod(first=first)
    found, without = fm.check(mechanism), fm.check(crank_with_massless_rod(controlled=False))
    assert found.ok
    assert (found.freedom, found.free, found.mass) == (without.freedom, without.free, without.mass)
    assert codes(found) == codes(without)
    sol = fm.simulate(mechanism, t_end=0.05)
    assert sol.ok
    assert "Examination" in fm.report(sol, tmp_path / "run.html").read_text()


def test_a_massless_link_that_moves_alone_is_named_beside_a_controller():
    for controlled in (False, True):
        mechanism = crank_with_massless_rod(controlled=controlled, held=False)
        with pytest.raises(fm.errors.ModelError, match="massless link 'rod' can move without moving a mass"):
            fm.simulate(mechanism, t_end=0.05)
        assert [f.parts for f in fm.check(mechanism).findings if f.code == "no-inertia"] == [("rod",)]


@pytest.mark.slow
def test_the_commands_do_too(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    model = tmp_path / "press.py"
    model.write_text("from test_beside_bodies import crank_with_massless_rod\nmodel = crank_with_massless_rod()\n")
    for command in (["check", str(model)], ["run", str(model), "--t-end", "0.02", "--out", str(tmp_path / "out")]):
        assert main(command) == 0


def parallel_cranks():
    """Three parallel cranks carry a bar: one of them is redundant."""
    bar = fm.RigidLink("bar", (0.0, 0.5), (1.0, 0.5), mass=1.0, inertia=0.1)
    parts = [bar]
    for name, x in (("arm", 0.0), ("second", 0.5), ("third", 1.0)):
        crank = fm.RigidLink(name, (x, 0.0), (x, 0.5), mass=0.5, inertia=0.01)
        parts += [crank, fm.Revolute(f"{name}_foot", fm.GROUND, crank, at=(x, 0.0))]
        parts += [fm.Revolute(f"{name}_head", crank, bar, at=(x, 0.5))]
    arm = next(part for part in parts if part.name == "arm")
    return [*parts, fm.Torque("actuator", arm, 1.0)]


def test_redundant_joints_beside_a_controller_with_states():
    """The examination of redundant joints compared a pose of bodies with the coordinates of states, too."""
    bare, controlled = (fm.Mechanism("m", [*parallel_cranks(), *more]) for more in ((), (servo(),)))
    assert codes(fm.check(controlled)) == codes(fm.check(bare))
    with pytest.raises(fm.errors.AssemblyError, match="starts in a singular pose"):
        fm.simulate(controlled, t_end=0.01)
    assert fm.simulate(controlled, t_end=0.01, redundant="least-norm").ok


def test_the_momentum_of_bodies_has_no_part_of_states():
    mechanism = crank_with_massless_rod()
    sol = fm.simulate(mechanism, t_end=0.05)
    found = momentum(mechanism, sol)
    assert found.mass == pytest.approx(2.0)
    assert np.asarray(found.linear)[-1, 0] == pytest.approx(
        float(sol["arm.vx"][-1] + sol["slider.vx"][-1]), rel=1e-7
    )  # a massless link has 1e-8 of the least mass
