"""Sweep of the crank of a crank and rocker: the swing by dead centres, and cranks that cannot go round are told.

At the dead centres crank and coupler lie in line: cos(psi) = (g^2 + r^2 - (c +- a)^2)/(2 g r).  After Grashof the crank
goes round while a + c <= g + r.  Source: J. J. Uicker, G. R. Pennock, J. E. Shigley, Theory of Machines and Mechanisms.
"""

import math

import numpy as np
import pytest

import flexmb as fm

COUPLER, ROCKER, FRAME = 0.22, 0.12, 0.2
SPEED = 5.0


def linkage(crank):
    """The crank is drawn straight up."""
    d = math.hypot(FRAME, crank)
    angle = math.atan2(crank, -FRAME) - math.acos((ROCKER**2 + d**2 - COUPLER**2) / (2.0 * ROCKER * d))
    a, b = (0.0, crank), (FRAME + ROCKER * math.cos(angle), ROCKER * math.sin(angle))
    one = fm.RigidLink("crank", (0.0, 0.0), a, mass=0.1, inertia=1e-4)
    two = fm.RigidLink("coupler", a, b, mass=0.2, inertia=8e-4)
    three = fm.RigidLink("rocker", b, (FRAME, 0.0), mass=0.1, inertia=1e-4)
    return fm.Mechanism("linkage", [
        one, two, three,
        fm.Revolute("O", fm.GROUND, one, at=(0.0, 0.0)), fm.Revolute("A", one, two, at=a),
        fm.Revolute("B", two, three, at=b), fm.Revolute("C", fm.GROUND, three, at=(FRAME, 0.0)),
        fm.Drive("motor", "O", fm.ConstantSpeed(SPEED)),
    ], gravity=(0.0, 0.0))  # fmt: skip


def swing(crank):
    sol = fm.simulate(linkage(crank), periods=1, save=2000)
    return {"swing": float(np.ptp(sol["rocker.theta"].values))}


def by_hand(crank):
    far, near = (
        math.acos((FRAME**2 + ROCKER**2 - length**2) / (2.0 * FRAME * ROCKER))
        for length in (COUPLER + crank, COUPLER - crank)
    )
    return far - near


CRANKS = [0.02, 0.05, 0.08, 0.13, 0.6]  # the last but one locks at its dead centre, the last cannot be closed


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    return fm.sweep(swing, {"crank": CRANKS}, store=str(tmp_path_factory.mktemp("sweep") / "swing.zarr"))


def test_cranks_that_go_round_swing_the_rocker_as_far_as_the_dead_centres_say(found):
    assert found.ok.values[:3].all()
    exact = [by_hand(crank) for crank in CRANKS[:3]]
    assert found.swing.values[:3] == pytest.approx(exact, rel=2e-6)


def test_a_crank_that_locks_is_no_result(found):
    assert not found.ok.values[3]
    assert np.isnan(found.swing.values[3])
    assert "done" not in str(found.status.values[3])
    assert "t =" in str(found.status.values[3])  # when it stopped


def test_a_crank_that_cannot_be_drawn_is_told_and_the_sweep_goes_on(found):
    assert not found.ok.values[4]
    assert "math domain error" in str(found.status.values[4])


def test_the_swing_is_stored(found):
    assert dict(found.sizes) == {"crank": 5}
    assert list(found.crank.values) == CRANKS
