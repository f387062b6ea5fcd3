"""The end of a run is saved, on the save grid or beyond it; restarts keep their grid."""

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError

PERIOD = 0.5


def swing():
    """A driven crank with a period of 0.5 s, and a pendulum on it."""
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.1, 0.0), mass=0.2, inertia=1e-3)
    arm = fm.RigidLink("arm", (0.1, 0.0), (0.4, 0.0), mass=0.3, inertia=3e-3)
    pins = [fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)), fm.Revolute("A", crank, arm, at=(0.1, 0.0))]
    motor = fm.Drive("motor", "O", fm.ConstantSpeed(2.0 * np.pi / PERIOD))
    return fm.Mechanism("swing", [crank, arm, *pins, motor], gravity=(0.0, -9.81))


@pytest.mark.parametrize("how", [{}, {"step": 1e-3}, {"method": fm.RadauIIA()}], ids=["adaptive", "fixed", "radau"])
def test_the_last_row_is_the_end(how):
    """The row beyond the grid holds the final state, as `restart` does."""
    sol = fm.simulate(swing(), t_end=0.62, save=10, **how)
    assert sol.time == pytest.approx([*np.arange(13) * 0.05, 0.62], abs=1e-12)
    last = [sol[f"arm.{axis}"].values[-1] for axis in ("x", "y", "theta")]
    assert last == pytest.approx(sol.restart["q"][3:6], abs=1e-13)
    assert sol["motor.angle"].values[-1] == pytest.approx(0.62 * 2.0 * np.pi / PERIOD, rel=1e-12)


def test_an_end_on_the_grid_is_one_row():
    for t_end in (0.6, PERIOD, 15.0 * 0.05):
        sol = fm.simulate(swing(), t_end=t_end, save=10)
        assert len(sol.time) == round(t_end / 0.05) + 1
        assert sol.time[-1] == pytest.approx(t_end, abs=1e-12)


def test_a_restart_keeps_its_grid():
    """Rows of both runs together are those of one, and the end of the first."""
    first = fm.simulate(swing(), t_end=0.62, save=10, step=1e-3)
    second = fm.simulate(swing(), t_end=1.03, save=10, step=1e-3, restart=first.restart)
    whole = fm.simulate(swing(), t_end=1.03, save=10, step=1e-3)
    assert second.time == pytest.approx([*np.arange(13, 21) * 0.05, 1.03], abs=1e-12)
    together = np.concatenate([first.values[:-1], second.values])
    assert together == pytest.approx(whole.values, rel=1e-9, abs=1e-9)


def test_a_run_that_ends_before_has_no_row_of_an_end():
    cut = fm.simulate(swing(), t_end=0.62, save=10, step=1e-3, max_steps=333)
    assert not cut.ok
    assert cut.time[-1] == pytest.approx(0.3)
    steps = fm.simulate(swing(), t_end=0.62, save="steps", step=1e-3)
    assert np.all(np.diff(steps.time) > 0.0)
    assert steps.time[-1] == pytest.approx(0.62)


def test_a_spectrum_says_to_leave_the_end_out():
    sol = fm.simulate(swing(), t_end=0.6222, save=100)
    with pytest.raises(InputError, match="the end of the run beyond its save grid: leave the last sample out"):
        fm.chaos.power_spectrum(sol["arm.y"].values, sol.time)
