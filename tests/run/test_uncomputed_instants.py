"""Saved instants at which a model is not defined: never a row of NaN in a run that is fine."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.fields import record
from flexmb.kernels import drive_kernel
from flexmb.model.law import Motion


@drive_kernel
def broken_at_an_instant(p, t):
    if abs(t - 0.0512) < 1e-9:
        return math.nan, math.nan, math.nan
    return 3.0 * t, 3.0, 0.0


@record
class Broken(Motion):
    kernel = broken_at_an_instant

    def parameters(self):
        return ()


def driven(method):
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.3, 0.0), 1.0, 0.01)
    joint = fm.Revolute("O", fm.GROUND, crank, (0.0, 0.0))
    mech = fm.Mechanism("crank", (crank, joint, fm.Drive("motor", "O", Broken())))
    return fm.simulate(mech, t_end=0.1, method=method, step=0.01, save=[0.0, 0.0512, 0.1])


@pytest.mark.parametrize("method", [fm.Newmark(), fm.RadauIIA(), fm.RungeKutta4()])
def test_a_signal_that_is_no_number_is_named(method):
    """No end of a step meets the instant; the row of the drive was NaN, and the run was fine."""
    sol = driven(method)
    assert not sol.ok
    assert "At t = 0.0512 s the signal 'motor.angle' is nan." in sol.status
    assert np.isnan(sol.array("motor.angle")[1])
    assert np.isfinite(sol.array("crank.theta")).all()


def test_order_eight_ends_at_an_instant_that_it_cannot_compute():
    """Positions are projected there, onto a drive that is not defined."""
    sol = driven(fm.DormandPrince())
    assert not sol.ok
    assert "no longer finite" in sol.status
    assert np.isfinite(sol.array("crank.theta")).all()
