"""Gears, belts, racks and equal rotation against ratios, balances of torque and power, and closed forms."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError, ModelError

O, Q = (0.0, 0.0), (0.09, 0.0)


def wheel(name, at, inertia=1e-3, mass=0.5):
    """A wheel."""
    return fm.RigidBody(name, at=at, mass=mass, inertia=inertia)


def train(*parts, load=-3.0, motion=None):
    """A pinion of 20 and a wheel of 40 teeth, driven and loaded."""
    pinion, second = wheel("pinion", O, 1e-4), wheel("wheel", Q)
    return fm.Mechanism("train", [
        pinion, second,
        fm.Revolute("O", fm.GROUND, pinion, at=O), fm.Revolute("Q", fm.GROUND, second, at=Q),
        *(parts or [fm.Gear("mesh", pinion, second, teeth=(20, 40))]),
        fm.Drive("motor", joint="O", motion=motion or fm.ConstantSpeed(10.0)),
        fm.Torque("load", second, load),
    ])  # fmt: skip


def test_a_pair_turns_and_loads_as_its_teeth_say():
    sol = fm.simulate(train(), t_end=1.0)
    assert sol.ok, sol.status
    assert sol["wheel.omega"].values == pytest.approx(-5.0, abs=1e-12)
    assert sol["motor.torque"].values[1:] == pytest.approx(-1.5, abs=1e-9)
    assert sol["mesh.second_torque"].values[1:] == pytest.approx(3.0, abs=1e-9)  # holds the load
    assert sol["mesh.first_torque"].values[1:] == pytest.approx(1.5, abs=1e-9)
    assert sol["mesh.force"].values[1:] == pytest.approx(3.0 / 0.06, rel=1e-9)  # pitch radius 0.06 m
    assert sol["mesh.power"].values[1:] == pytest.approx(-15.0, abs=1e-8)


def test_inertia_is_seen_through_the_ratio():
    """The driving torque in a start is (J1 + J2/4) alpha."""
    motion = fm.drives.Polynomial((0.0, 0.0, 5.0))  # 10 rad/s^2
    sol = fm.simulate(train(load=0.0, motion=motion), t_end=0.5)
    assert sol["motor.torque"].values[1:] == pytest.approx((1e-4 + 1e-3 / 4.0) * 10.0, rel=1e-7)


def planetary(inner=20, planets=30, ring=None, held="ring"):
    """A planetary train: sun, planet on an arm, ring; one of sun, arm and ring is held."""
    ring = ring or inner + 2 * planets
    module = 2e-3
    axis = (0.5 * module * (inner + planets), 0.0)
    sun, planet = wheel("sun", O), wheel("planet", axis)
    arm = fm.RigidBody("arm", at=O, mass=0.3, inertia=2e-3)
    rim = wheel("ring", O, 5e-3)
    parts = [
        sun, planet, arm, rim,
        fm.Revolute("S", fm.GROUND, sun, at=O), fm.Revolute("C", fm.GROUND, arm, at=O),
        fm.Revolute("R", fm.GROUND, rim, at=O), fm.Revolute("P", arm, planet, at=axis),
        fm.Gear("inner", sun, planet, teeth=(inner, planets), arm=arm, module=module),
        fm.Gear("outer", planet, rim, teeth=(planets, ring), arm=arm, internal=True, module=module),
        fm.couplings.SameRotation("brake", fm.GROUND, {"ring": rim, "sun": sun}[held]),
    ]  # fmt: skip
    return fm.Mechanism("planetary", [*parts, fm.Drive("motor", "S" if held == "ring" else "R", fm.ConstantSpeed(7.0))])


@pytest.mark.parametrize(("inner", "planets"), [(20, 30), (17, 23), (40, 10)])
def test_planetary_ratios(inner, planets):
    """Willis: with a held ring the arm turns z_s/(z_s + z_r) as fast as the sun; with a held sun z_r/(z_s + z_r)."""
    ring = inner + 2 * planets
    sol = fm.simulate(planetary(inner, planets), t_end=0.7)
    assert sol.ok, sol.status
    assert sol["arm.omega"].values / 7.0 == pytest.approx(inner / (inner + ring), rel=1e-10)
    slow = fm.simulate(planetary(inner, planets, held="sun"), t_end=0.7)
    assert slow["arm.omega"].values / 7.0 == pytest.approx(ring / (inner + ring), rel=1e-10)


def test_torques_of_a_planetary_train_balance():
    """Motor, brake and load on the arm add up to nothing, and so do the powers, less what the centre moves."""
    mech = planetary()
    loaded = fm.Mechanism("loaded", [*mech.parts, fm.Torque("load", mech.find("arm"), -10.0)])
    sol = fm.simulate(loaded, t_end=0.5)
    motor, brake = sol["motor.torque"].values[1:], sol["brake.torque"].values[1:]
    assert motor == pytest.approx(10.0 * 20.0 / 100.0, rel=1e-6)  # z_s/(z_s + z_r) of the load
    assert brake + motor == pytest.approx(10.0, rel=1e-6)
    assert np.abs(sol["energy.residual"].values).max() < 1e-6


@pytest.mark.parametrize("drawn", ["gear", "belt"])
def test_a_line_of_centres_that_goes_round_needs_an_arm(drawn):
    """A planet that an arm leads round a held sun, twice: it turns by 1 + z_s/z_p, or 1 - r_s/r_p, of the arm."""
    sun, planet, arm = wheel("sun", O), wheel("planet", Q), fm.RigidBody("arm", at=O, mass=0.3, inertia=2e-3)
    pins = [
        fm.Fixed("S", fm.GROUND, sun, at=O),
        fm.Revolute("A", fm.GROUND, arm, at=O),
        fm.Revolute("P", arm, planet, at=Q),
    ]
    for ok, more in ((True, {"arm": arm}), (False, {})):
        pair = fm.Gear("pair", sun, planet, teeth=(30, 20), **more)
        if drawn == "belt":
            pair = fm.couplings.Belt("pair", sun, planet, radii=(0.03, 0.02), **more)
        mech = fm.Mechanism(
            "planet", [sun, planet, arm, *pins, pair, fm.Drive("motor", "A", fm.ConstantSpeed(4.0 * math.pi))]
        )
        sol = fm.simulate(mech, t_end=1.0)
        right = float(sol["planet.theta"][-1]) == pytest.approx((2.5 if drawn == "gear" else -0.5) * 4.0 * math.pi)
        assert (sol.ok, right) == (ok, ok)
    assert "more than half a turn" in sol.status


def test_belts_open_and_crossed():
    pinion, second = (train().find(name) for name in ("pinion", "wheel"))
    for crossed, sign in ((False, 1.0), (True, -1.0)):
        belt = fm.couplings.Belt("belt", pinion, second, radii=(0.02, 0.05), crossed=crossed)
        sol = fm.simulate(train(belt), t_end=0.3)
        assert sol["wheel.omega"].values == pytest.approx(sign * 4.0, abs=1e-12)
        assert np.abs(sol["belt.force"].values[1:]) == pytest.approx(3.0 / 0.05, rel=1e-9)


def test_a_rolling_disc_falls_down_a_slope():
    """A cylinder that rolls down a slope of 30 degrees accelerates with (2/3) g sin(30 deg)."""
    slope, r, m = math.radians(30.0), 0.1, 2.0
    u = (math.cos(slope), -math.sin(slope))
    centre = (r * math.sin(slope), r * math.cos(slope))
    disc = fm.RigidBody("disc", at=centre, mass=m, inertia=0.5 * m * r * r)
    track = fm.couplings.Rack("track", disc, fm.GROUND, at=O, along=u)
    carrier = fm.RigidBody("carrier", at=centre, mass=1e-9, inertia=1e-9)
    mech = fm.Mechanism("slope", [
        disc, carrier, track, fm.Prismatic("guide", fm.GROUND, carrier, along=u),
        fm.Revolute("axle", carrier, disc, at=centre),
    ], gravity=(0.0, -9.81))  # fmt: skip
    sol = fm.simulate(mech, t_end=1.0)
    down = (sol["disc.x"].values - centre[0]) * u[0] + (sol["disc.y"].values - centre[1]) * u[1]
    a = 2.0 / 3.0 * 9.81 * math.sin(slope)
    assert down[-1] == pytest.approx(0.5 * a, rel=1e-6)
    assert sol["disc.theta"].values[-1] == pytest.approx(-0.5 * a / r, rel=1e-6)
    assert sol["track.force"].values[5:] == pytest.approx(-m * 9.81 * math.sin(slope) / 3.0, rel=1e-5)


def test_a_rack_that_is_driven():
    """The rack moves r omega, and its force is the torque over the radius."""
    r = 0.04
    pinion, rack = wheel("pinion", (0.0, r)), fm.RigidBody("rack", at=(0.1, -0.01), mass=3.0, inertia=0.1)
    mech = fm.Mechanism("rack", [
        pinion, rack, fm.Revolute("O", fm.GROUND, pinion, at=(0.0, r)),
        fm.Prismatic("guide", fm.GROUND, rack, along=(1.0, 0.0)),
        fm.couplings.Rack("teeth", pinion, rack, at=(0.0, 0.0)),
        fm.Drive("motor", "O", fm.drives.Polynomial((0.0, 0.0, 5.0))),
    ])  # fmt: skip
    sol = fm.simulate(mech, t_end=0.4)
    assert sol["rack.x"].values - 0.1 == pytest.approx(r * sol["pinion.theta"].values, abs=1e-12)
    assert np.abs(sol["teeth.force"].values[5:]) == pytest.approx(3.0 * r * 10.0, rel=1e-6)
    assert sol["motor.torque"].values[5:] == pytest.approx((1e-3 + 3.0 * r * r) * 10.0, rel=1e-6)


@pytest.mark.quick(2)
@pytest.mark.parametrize(
    ("make", "part"),
    [
        (train, "mesh"), (planetary, "inner"), (planetary, "outer"), (planetary, "brake"),
        (lambda: train(fm.couplings.Belt("mesh", wheel("pinion", O), wheel("wheel", Q), radii=(0.02, 0.05))), "mesh"),
    ],
)  # fmt: skip
def test_contracts(make, part):
    fm.testing.check_part(make(), part)


def test_contracts_of_a_rack_between_moving_bodies():
    one, other = wheel("one", (0.1, 0.3)), fm.RigidBody("other", at=(0.2, 0.1), mass=1.0, inertia=1.0, theta=0.4)
    mech = fm.Mechanism("pair", [one, other, fm.couplings.Rack("teeth", one, other, at=(0.15, 0.12), along=(1.0, 0.5))])
    fm.testing.check_part(mech, "teeth")


def test_wrong_trains_are_refused():
    pinion, second = wheel("pinion", O), wheel("wheel", Q)
    with pytest.raises(ModelError, match=r"axes are 0.09 m apart.*module 0.002 m need 0.06 m"):
        fm.simulate(train(fm.Gear("mesh", pinion, second, teeth=(20, 40), module=2e-3)), t_end=0.1)
    with pytest.raises(InputError, match="both wheels have 20 teeth"):
        fm.Gear("mesh", pinion, second, teeth=(20, 20), internal=True)
    with pytest.raises(InputError, match=r"teeth\[1\] is -4; it must be at least 1"):
        fm.Gear("mesh", pinion, second, teeth=(20, -4))
    with pytest.raises(ModelError, match="couples a body with itself"):
        fm.Gear("mesh", pinion, pinion, teeth=(20, 40))
    with pytest.raises(ModelError, match=r"has no centre\. Give distance="):
        fm.simulate(train(fm.Gear("mesh", pinion, fm.GROUND, teeth=(20, 40))), t_end=0.1)
    with pytest.raises(InputError, match=r"radii\[0\] is -1 m"):
        fm.couplings.Belt("belt", pinion, second, radii=(-1.0, 1.0))
    with pytest.raises(ModelError, match="passes the centre of 'pinion'"):
        fm.simulate(train(fm.couplings.Rack("rack", pinion, second, at=(-0.1, 0.0))), t_end=0.1)
