"""Gear pairs with backlash: free flight, forces along the line of action, ratios, play and distance of the axes."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError, ModelError
from flexmb.kernels import GAP_SIZE
from flexmb.testing import check_part

O, Q = (0.0, 0.0), (0.09, 0.0)
LAW = fm.KelvinVoigt(stiffness=1e8, damping=2e3, ramp=1e-6)
PLAY, ALPHA = 1e-4, math.radians(20.0)
R1, R2, J2 = 0.03, 0.06, 1e-3


def train(load=-3.0, *, internal=False, backlash=PLAY, Q=Q, motion=None, **more):
    """A driven pinion of 20 and a loaded wheel of 40 teeth."""
    pinion = fm.RigidBody("pinion", at=O, mass=0.5, inertia=1e-4)
    wheel = fm.RigidBody("wheel", at=Q, mass=0.5, inertia=J2)
    given = {"normal": LAW, "internal": internal, "backlash": backlash, **more}
    return fm.Mechanism("train", [
        pinion, wheel,
        fm.Revolute("O", fm.GROUND, pinion, at=O), fm.Revolute("Q", fm.GROUND, wheel, at=Q),
        fm.Gear("mesh", pinion, wheel, teeth=(20, 40), **given),
        fm.Drive("motor", "O", motion or fm.ConstantSpeed(10.0)),
        fm.Torque("load", wheel, load),
    ])  # fmt: skip


@pytest.mark.parametrize(("load", "flank", "other"), [(3.0, "forward", "backward"), (-3.0, "backward", "forward")])
def test_free_flight_through_half_the_backlash(load, flank, other):
    """The load turns the free wheel by b/(2 r2) before the teeth meet: t = sqrt(b J2/(r2 T))."""
    sol = fm.simulate(train(load), t_end=0.3)
    assert sol.ok, sol.status
    assert sol.episodes(f"mesh.{flank}")[0].start == pytest.approx(math.sqrt(PLAY * J2 / (R2 * 3.0)), rel=1e-6)
    assert len(sol.episodes(f"mesh.{other}")) == 0
    # at rest on the flank: T over the base radius, along the line of action
    assert sol[f"mesh.{flank}.normal_force"].values[-1] == pytest.approx(3.0 / (R2 * math.cos(ALPHA)), rel=1e-7)
    assert sol["motor.torque"].values[-1] == pytest.approx(load * R1 / R2, rel=1e-7)
    bearing = np.hypot(sol["Q.fx"].values[-1], sol["Q.fy"].values[-1])
    assert bearing == pytest.approx(3.0 / (R2 * math.cos(ALPHA)), rel=1e-6)
    assert abs(math.atan2(abs(sol["Q.fx"].values[-1]), abs(sol["Q.fy"].values[-1]))) == pytest.approx(ALPHA, rel=1e-6)
    assert np.abs(sol["energy.residual"].values).max() < 1e-6 * sol["energy.turned_over"].values[-1]


def test_a_reversed_load_crosses_the_whole_backlash():
    """From flank to flank the wheel turns b/r2 and both compressions; in flight it accelerates with T/J2."""
    history = fm.drives.PiecewiseLinear((0.0, 0.1, 0.1 + 1e-9), (1.0, 1.0, -1.0))
    mech = train(3.0)
    load = fm.Torque("load", mech.find("wheel"), 3.0, history=history)
    sol = fm.simulate(mech.with_part(load), t_end=0.15, step=fm.Adaptive(rtol=1e-6))
    assert sol.ok, sol.status
    left = next(e.end for e in sol.episodes("mesh.forward") if e.end > 0.1)
    met = next(e.start for e in sol.episodes("mesh.backward"))
    k = int(np.searchsorted(sol.time, left))
    speed = -R2 * sol["wheel.omega"].values[k] - R1 * 10.0  # with which the surfaces part
    t = sol.time[k] - left
    speed -= R2 * 3.0 / J2 * t
    a = R2 * 3.0 / J2
    flight = (-speed + math.sqrt(speed * speed + 2.0 * a * PLAY)) / a
    assert met - left == pytest.approx(flight, rel=1e-4)


@pytest.mark.parametrize("internal", [False, True])
def test_the_mean_ratio_is_that_of_the_teeth(internal):
    """After many turns the wheel is where the ratio puts it, within half the play."""
    sol = fm.simulate(train(0.5, internal=internal), t_end=5.0)
    assert sol.ok, sol.status
    ratio = 0.5 if internal else -0.5
    off = sol["wheel.theta"].values - ratio * sol["pinion.theta"].values
    r2 = 0.18 if internal else R2
    assert sol["pinion.theta"].values[-1] > 49.0  # eight turns
    depth = 0.5 / (r2 * math.cos(ALPHA)) / 1e8 / math.cos(ALPHA)
    assert np.abs(off[-1000:]) == pytest.approx((0.5 * PLAY + depth) / r2, rel=1e-6)


def test_gears_on_an_arm():
    """A held sun with play: the planet turns with the arm by 1 + z_s/z_p, within the play."""
    sun = fm.RigidBody("sun", at=O, mass=0.5, inertia=1e-3)
    planet = fm.RigidBody("planet", at=(0.05, 0.0), mass=0.5, inertia=1e-3)
    arm = fm.RigidBody("arm", at=O, mass=0.3, inertia=2e-3)
    sol = fm.simulate(fm.Mechanism("train", [
        sun, planet, arm, fm.Fixed("brake", fm.GROUND, sun, at=O), fm.Revolute("C", fm.GROUND, arm, at=O),
        fm.Revolute("P", arm, planet, at=(0.05, 0.0)),
        fm.Gear("mesh", sun, planet, teeth=(20, 30), arm=arm, backlash=PLAY, normal=LAW),
        fm.Drive("motor", "C", fm.ConstantSpeed(7.0)), fm.Torque("load", planet, -0.4),
    ]), t_end=2.0)  # fmt: skip
    assert sol.ok, sol.status
    off = sol["planet.theta"].values - (1.0 + 20.0 / 30.0) * sol["arm.theta"].values
    depth = sol["mesh.backward.penetration"].values
    touching = depth > 0.0
    assert touching[-1000:].all()
    base = 0.03 * math.cos(ALPHA)  # of the planet
    assert -off[touching] * base == pytest.approx(
        0.5 * PLAY * math.cos(ALPHA) + depth[touching], abs=1e-8
    )  # between steps
    assert np.abs(off[~touching]).max() * base <= 0.5 * PLAY * math.cos(ALPHA)


@pytest.mark.parametrize("internal", [False, True])
def test_play_grows_with_the_distance_of_the_axes(internal):
    """dj/dC = 2 sin(alpha) along the line of action, of opposite sign for an internal pair; to second order."""
    mech = train(internal=internal)
    pieces = [c for c in mech.find("mesh").contributions(mech) if hasattr(c, "gap")]

    def play(apart):
        q, out, total = np.array([0.0, 0.0, 0.0, 0.09 + apart, 0.0, 0.0]), np.zeros(GAP_SIZE), 0.0
        for piece in pieces:
            piece.gap.dispatcher(np.array(piece.p), q, np.zeros(6), out)
            total += out[0]
        return total

    assert play(0.0) == pytest.approx(PLAY * math.cos(ALPHA), rel=1e-9)
    step = 1e-5
    slope = (play(step) - play(-step)) / (2.0 * step)
    assert slope == pytest.approx((-2.0 if internal else 2.0) * math.sin(ALPHA), rel=1e-6)


@pytest.mark.parametrize("given", [{}, pytest.param({"internal": True}, marks=pytest.mark.slow)])
def test_contracts(given):
    check_part(train(pressure_angle=math.radians(30.0), **given), "mesh")


def test_wrong_backlash_is_refused():
    with pytest.raises(InputError, match="normal is None; a pair with backlash needs a normal law"):
        train(normal=None)
    with pytest.raises(InputError, match="normal is given without backlash"):
        train(backlash=None)
    with pytest.raises(InputError, match=r"backlash is -1 m; it must be > 0"):
        train(backlash=-1.0)
    with pytest.raises(InputError, match=r"backlash is 0.005 m, but a tooth and its gap are 0.009425 m long"):
        fm.compile(train(backlash=0.005))
    with pytest.raises(InputError, match="pressure_angle is 20 rad"):
        train(pressure_angle=20.0)
    with pytest.raises(
        ModelError, match=r"whose centres of mass lie on their axes, 0.1 m apart; they are 0.09 m apart"
    ):
        fm.compile(train(distance=0.1))
