"""Pin in a slot: ideal against an exact motion, with play against forces by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

import flexmb as fm

C, R, LENGTH, K = 1e-3, 0.01, 0.06, 1e8
LAW = fm.LankaraniNikravesh(stiffness=K, restitution=0.8)


def scotch_yoke(joint):
    """A crank of 0.1 m whose pin runs in the upright slot of a slider."""
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.1, 0.0), 0.2, 1e-3)
    yoke = fm.RigidBody("yoke", (0.1, 0.0), 0.7, 1e-3)
    parts = (
        crank,
        yoke,
        fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)),
        fm.Prismatic("guide", fm.GROUND, yoke, along=(1.0, 0.0)),
        fm.Drive("motor", "O", fm.ConstantSpeed(20.0)),
        joint(yoke, crank),
    )
    return fm.Mechanism("scotch-yoke", parts)


def ideal(yoke, crank):
    return fm.PinSlot("P", yoke, crank, at=(0.1, 0.0), along=(0.0, 1.0))


def worn(yoke, crank):
    numbers = {"clearance": C, "pin_radius": R, "normal": fm.LankaraniNikravesh(stiffness=1e10, restitution=0.8)}
    return fm.PinSlotClearance("P", yoke, crank, at=(0.1, 0.0), along=(0.0, 1.0), **numbers)


def test_a_scotch_yoke_moves_as_a_cosine():
    """x = r cos(w t); the slot pushes the yoke by its m a; the pin travels r sin(w t)."""
    sol = fm.simulate(scotch_yoke(ideal), periods=1, save=200)
    assert sol.ok, sol.status
    x = 0.1 * np.cos(20.0 * sol.time)
    np.testing.assert_allclose(sol.array("yoke.x"), x, atol=1e-9)
    # the slot belongs to the first body, so the reported force acts on the crank
    np.testing.assert_allclose(sol.array("P.fx"), 0.7 * 400.0 * x, atol=1e-3 * 28.0)
    # between steps this signal is interpolated linearly: (w h)^2/8 of the travel
    between = (20.0 * sol.stats.largest_step) ** 2 / 8.0
    assert between < 1e-5
    np.testing.assert_allclose(sol.array("P.travel"), 0.1 * np.sin(20.0 * sol.time), atol=between * 0.1)


@pytest.mark.parametrize("wears", [False, True])
def test_the_rate_of_the_eccentricity_is_its_derivative_in_a_slot_that_turns(wears):
    """The pin travels along the slot at up to 2 m/s, which is none of the eccentricity's rate."""
    arm, pin = fm.RigidBody("arm", (0.15, 0.05), 1.0, 0.02, theta=0.4), fm.RigidBody("pin", (0.35, 0.05), 0.4, 2e-3)
    numbers = {"clearance": C, "pin_radius": 0.004, "normal": fm.KelvinVoigt(1e6, 2e2, ramp=1e-6)}
    slot = fm.PinSlotClearance("P", arm, pin, at=(0.3, 0.1), along=(1.0, 2.0), **numbers)
    if wears:
        slot = slot.worn_by(fm.wear.Archard(bearing=1e-20, width=0.02), 0.4)
    turning = fm.Revolute("O", fm.GROUND, arm, at=(0.0, 0.0)), fm.Drive("motor", "O", fm.ConstantSpeed(9.0))
    mech = fm.Mechanism("slot", (arm, pin, *turning, slot), gravity=(0.0, -9.81))
    sol = fm.simulate(mech, t_end=0.1, save="steps")
    assert sol.ok, sol.status
    assert np.abs(sol.array("P.speed")).max() > 1.0
    for place, rate in (("P.ex", "P.vex"), ("P.ey", "P.vey")):
        e, v = sol.array(place), sol.array(rate)
        way = np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(sol.time))
        assert np.abs(e[1:] - e[0] - way).max() <= 0.02 * np.ptp(e)


def test_with_little_play_it_tends_to_the_ideal_one():
    """The yoke lags by the play at most, plus how far the contact is pressed in."""
    sol = fm.simulate(scotch_yoke(worn), periods=1, save=200)
    assert sol.ok, sol.status
    depth = sol.peak("P.penetration").value
    assert np.abs(sol.array("yoke.x") - 0.1 * np.cos(20.0 * sol.time)).max() <= C + depth + 1e-9
    assert 0.0 < depth < 0.1 * C


SIDE = (0.3 * LENGTH, 1.1 * C)
END = (0.5 * LENGTH + 1.1 * C * math.cos(0.4), 1.1 * C * math.sin(0.4))


@pytest.mark.parametrize("angle", [0.0, 0.8])
@pytest.mark.parametrize(("place", "normal"), [(SIDE, math.pi / 2), (END, 0.4)])
def test_forces_by_hand(posed, angle, place, normal):
    """Depth 0.1 c in the side and in the round end, at 0.4 rad from the slot: N = K depth^1.5 through the pin."""
    disc = fm.RigidBody("disc", (0.5, 0.2), 1.0, 1e-3)
    along = (math.cos(angle), math.sin(angle))
    numbers = {"clearance": C, "pin_radius": R, "normal": LAW, "length": LENGTH}
    mech = fm.Mechanism("m", (disc, fm.PinSlotClearance("P", fm.GROUND, disc, at=(0.5, 0.2), along=along, **numbers)))
    c, s = along
    x, y = place
    fx, fy, moment = posed(mech).force({"disc": (c * x - s * y, s * x + c * y, 0.7)})["disc"]
    N = K * (0.1 * C) ** 1.5
    assert fx == pytest.approx(-N * math.cos(angle + normal), abs=1e-7 * N)
    assert fy == pytest.approx(-N * math.sin(angle + normal), abs=1e-7 * N)
    assert moment == pytest.approx(0.0, abs=1e-9 * N)


def test_derivatives_hold_in_the_round_ends_too():
    """A slot so short that the states of check_part lie beyond its ends."""
    arm = fm.RigidLink("arm", (0.0, 0.0), (0.2, 0.05), 0.5, 2e-3)
    disc = fm.RigidBody("disc", (0.2, 0.05), 0.4, 3e-3)
    numbers = {"clearance": C, "pin_radius": R, "normal": LAW, "length": 1e-4}
    slot = fm.PinSlotClearance("P", arm, disc, at=(0.2, 0.05), along=(1.0, 0.3), **numbers)
    fm.testing.check_part(fm.Mechanism("m", (arm, disc, slot)), "P")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"clearance": -1e-3}, ["'P'", "clearance is -0.001", "PinSlot"]),
        ({"pin_radius": 0.0}, ["'P'", "pin_radius is 0"]),
        ({"length": -1.0}, ["'P'", "length is -1"]),
        ({"along": (0.0, 0.0)}, ["'P'", "along", "length > 0"]),
        ({"normal": 3.0}, ["'P'", "normal is 3.0"]),
    ],
)
def test_bad_input(change, words):
    with pytest.raises(fm.errors.InputError) as error:
        replace(scotch_yoke(worn).find("P"), **change)
    for word in words:
        assert word in str(error.value)
