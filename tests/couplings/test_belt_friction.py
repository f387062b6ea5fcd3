"""Belts with friction against Eytelwein's limit; powers of gears, belts, racks and cams; messages."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError, ModelError
from flexmb.testing import check_part

MU, T0, CREEP, DISTANCE = 0.3, 50.0, 1e-3, 0.12
RADII = 0.02, 0.05


def drive(load, *, crossed=False, speed=20.0, make=None):
    """Two wheels on fixed axes, the first one driven, the second one loaded."""
    one = fm.RigidBody("one", at=(0.0, 0.0), mass=0.5, inertia=1e-4)
    two = fm.RigidBody("two", at=(0.0, DISTANCE), mass=0.5, inertia=1e-4)
    belt = fm.couplings.Belt("belt", one, two, radii=RADII, crossed=crossed, coefficient=MU, pretension=T0, creep=CREEP)
    return fm.Mechanism("drive", [
        one, two, fm.Revolute("O", fm.GROUND, one, at=(0.0, 0.0)), fm.Revolute("Q", fm.GROUND, two, at=(0.0, DISTANCE)),
        make(one, two) if make else belt, fm.Drive("motor", "O", fm.ConstantSpeed(speed)), fm.Torque("load", two, load),
    ])  # fmt: skip


def least_wrap(crossed):
    """Angle of wrap by the triangle of centres and tangent points."""
    if crossed:
        return 2.0 * math.pi - 2.0 * math.acos((RADII[0] + RADII[1]) / DISTANCE)
    return 2.0 * math.acos((RADII[1] - RADII[0]) / DISTANCE)


def final(sol, name):
    return float(sol[name].values[-1])


@pytest.mark.parametrize("crossed", [pytest.param(False, marks=pytest.mark.slow), True])
def test_contracts(crossed):
    """Tangents, balance of forces and moments, energies, of wheels that both move."""
    one = fm.RigidBody("one", at=(0.1, -0.2), mass=0.4, inertia=2e-3)
    two = fm.RigidBody("two", at=(0.9, 0.5), mass=0.8, inertia=8e-3, theta=0.3)
    belt = fm.couplings.Belt("belt", one, two, radii=RADII, crossed=crossed, coefficient=MU, pretension=T0, creep=0.3)
    report = check_part(fm.Mechanism("pair", [one, two, belt]), "belt")
    assert max(check.error for check in report.checks) < 1e-6


@pytest.mark.parametrize("crossed", [False, True])
def test_a_belt_slips_at_eytelweins_limit(crossed):
    """Beyond the limit T1/T2 = exp(mu phi) with T1 + T2 = 2 T0, so the loaded wheel falls behind with what is left."""
    ratio = math.exp(MU * least_wrap(crossed))
    largest = 2.0 * T0 * (ratio - 1.0) / (ratio + 1.0)
    load = 1.3 * RADII[1] * largest * (1.0 if crossed else -1.0)
    sol = fm.simulate(drive(load, crossed=crossed), t_end=0.2)
    assert sol.ok, sol.status
    assert final(sol, "belt.tension_ratio") == pytest.approx(ratio, rel=1e-9)
    left = (abs(load) - RADII[1] * largest) / 1e-4
    assert abs(final(sol, "two.alpha")) == pytest.approx(left, rel=1e-6)
    assert np.abs(sol["energy.residual"].values).max() < 1e-6 * final(sol, "energy.turned_over")


@pytest.mark.parametrize("crossed", [False, True])
def test_below_the_limit_a_belt_creeps(crossed):
    """Slip creep atanh(F/F_max); heat is what the load does not get; the bearings carry both strands."""
    load = -1.0 if not crossed else 1.0
    sol = fm.simulate(drive(load, crossed=crossed), t_end=0.2)
    force = abs(load) / RADII[1]
    largest = 2.0 * T0 * math.tanh(0.5 * MU * least_wrap(crossed))
    slip = CREEP * math.atanh(force / largest)
    assert final(sol, "belt.slip") == pytest.approx(slip, rel=1e-6)
    assert final(sol, "belt.tension_ratio") == pytest.approx((T0 + 0.5 * force) / (T0 - 0.5 * force), rel=1e-9)
    assert final(sol, "motor.power") + final(sol, "load.power") == pytest.approx(force * slip, rel=1e-6)
    assert final(sol, "belt.power") == pytest.approx(-final(sol, "load.power"), rel=1e-9)
    # each strand pulls along the common tangent: cosine and sine of its angle to the line of centres
    tilt = (RADII[0] + RADII[1] if crossed else RADII[1] - RADII[0]) / DISTANCE
    along = 2.0 * T0 * math.sqrt(1.0 - tilt * tilt)
    assert final(sol, "O.fy") == pytest.approx(-along, rel=1e-6)
    assert abs(final(sol, "O.fx")) == pytest.approx(force * tilt, rel=1e-6)


PAIRS = {
    "gear": lambda one, two: fm.Gear("pair", one, two, teeth=(20, 40)),
    "belt": lambda one, two: fm.couplings.Belt("pair", one, two, radii=RADII),
    "crossed belt": lambda one, two: fm.couplings.Belt("pair", one, two, radii=RADII, crossed=True),
    "rack": lambda one, two: fm.couplings.Rack("pair", two, one, at=(0.0, 0.02), along=(1.0, 0.0)),
}


@pytest.mark.parametrize("kind", [k for k in PAIRS if k != "rack"])
def test_ideal_wheels_lose_no_power(kind):
    """The torques times the speeds of both wheels add up to nothing, and the power is that of the second one."""
    sol = fm.simulate(drive(-2.0, make=PAIRS[kind]), t_end=0.1)
    first = sol["pair.first_torque"].values * sol["one.omega"].values
    power = sol["pair.power"].values
    assert power == pytest.approx(sol["pair.second_torque"].values * sol["two.omega"].values, rel=1e-12)
    assert np.abs(first + power)[1:].max() < 1e-9 * np.abs(power).max()
    assert np.abs(sol["pair.force"].values[1:]).min() > 1.0
    assert power[1:] == pytest.approx(sol["motor.power"].values[1:], rel=1e-8)


def test_an_ideal_rack_loses_no_power():
    """A driven pinion pushes a rack on a spring: what it takes from the motor goes into rack and spring."""
    pinion = fm.RigidBody("pinion", at=(0.0, 0.03), mass=0.5, inertia=1e-4)
    rack = fm.RigidBody("rack", at=(0.1, 0.0), mass=3.0, inertia=0.1)
    sol = fm.simulate(fm.Mechanism("rack", [
        pinion, rack, fm.Revolute("O", fm.GROUND, pinion, at=(0.0, 0.03)),
        fm.Prismatic("guide", fm.GROUND, rack, along=(1.0, 0.0)),
        fm.couplings.Rack("teeth", pinion, rack, at=(0.0, 0.0)),
        fm.SpringDamper("spring", fm.GROUND, rack, at=(-0.5, 0.0), to=(0.1, 0.0), stiffness=100.0, damping=3.0),
        fm.Drive("motor", "O", fm.drives.Harmonic(0.5, 3.0)),
    ]), t_end=1.0)  # fmt: skip
    assert sol.ok, sol.status
    power, force = sol["teeth.power"].values, sol["teeth.force"].values
    assert power == pytest.approx(sol["teeth.torque"].values * sol["pinion.omega"].values, abs=1e-9)
    given = -force * sol["rack.vx"].values  # to the rack, which the pinion drives
    assert np.abs(power + given).max() < 1e-9 * np.abs(power).max()


@pytest.mark.parametrize("knife", [False, True])
def test_ideal_cams_lose_no_power_but_by_friction(knife):
    """The motor's power goes into the follower and into heat."""
    e, R, speed, mu = 0.01, 0.03, 40.0, 0.1
    disc = fm.ClosedCurve.from_function(lambda u: (e + R * math.cos(u), R * math.sin(u)), 180)
    start = math.sqrt(R * R - e * e) if knife else R
    cam = fm.RigidBody("cam", at=(0.0, 0.0), mass=0.5, inertia=1e-3)
    follower = fm.RigidBody("follower", at=(0.0, start), mass=0.3, inertia=1e-4)
    rubbing = fm.friction.SmoothCoulomb(mu, v0=1e-4)
    pair = (
        fm.cams.PointOnCurve("pair", cam, disc, follower, (0.0, start), friction=rubbing) if knife
        else fm.CurveOnCurve("pair", cam, disc, follower, fm.Line((-0.05, R), (0.05, R)), friction=rubbing)
    )  # fmt: skip
    sol = fm.simulate(fm.Mechanism("cam", [
        cam, follower, fm.Revolute("O", fm.GROUND, cam, at=(0.0, 0.0)),
        fm.Prismatic("guide", fm.GROUND, follower, along=(0.0, 1.0)), pair,
        fm.SpringDamper(
            "spring", fm.GROUND, follower, at=(0.0, 0.2), to=(0.0, start), stiffness=2000.0, free_length=0.2
        ),
        fm.Drive("motor", "O", fm.ConstantSpeed(speed)),
    ]), periods=1, save="steps")  # fmt: skip
    assert sol.ok, sol.status
    late = slice(2, None)
    force, rub = sol["pair.force"].values[late], sol["pair.friction_force"].values[late]
    assert sol["pair.power"].values[late] == pytest.approx(force * sol["pair.normal_speed"].values[late], rel=1e-12)
    assert np.abs(rub) == pytest.approx(mu * np.abs(force), rel=1e-6)
    heat = sol["energy.dissipated_friction"].values
    lost = np.trapezoid(sol["motor.power"].values - follower_power(sol), sol.time)
    assert lost == pytest.approx(heat[-1] - heat[0], rel=2e-3)
    assert heat[-1] > 0.1


def follower_power(sol):
    """Power that mass and spring of the follower take up."""
    y, v, a = (sol[f"follower.{name}"].values for name in ("y", "vy", "ay"))
    return (0.3 * a + 2000.0 * y) * v  # the spring's free length ends at y = 0


def test_wrong_belts_are_refused():
    one = fm.RigidBody("one", at=(0.0, 0.0), mass=1.0, inertia=1.0)
    two = fm.RigidBody("two", at=(0.0, 0.06), mass=1.0, inertia=1.0)
    with pytest.raises(InputError, match=r"pretension and creep not given; a belt with friction needs coefficient"):
        fm.couplings.Belt("belt", one, two, radii=RADII, coefficient=0.3)
    with pytest.raises(InputError, match=r"coefficient is -0.1"):
        fm.couplings.Belt("belt", one, two, radii=RADII, coefficient=-0.1, pretension=1.0, creep=1e-3)
    given = {"radii": RADII, "mu": 0.3, "pretension": 10.0, "creep": 1e-3}
    belt = fm.couplings.Belt("belt", one, two, crossed=True, **given)
    with pytest.raises(ModelError, match=r"are 0.06 m apart, too near for radii of 0.02 and 0.05 m"):
        belt.contributions(fm.Mechanism("near", [one, two, belt]))
    still = fm.couplings.Belt("belt", fm.GROUND, two, **given)
    with pytest.raises(ModelError, match=r"with friction both must be bodies"):
        still.contributions(fm.Mechanism("still", [two, still]))
