"""Bearings under gears, belts and racks: forces by statics, moments about any point, friction, elastic bearings."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError, ModelError

O, Q = (0.0, 0.0), (0.048, 0.036)  # 0.06 m apart, at 36.87 degrees
ALPHA = math.radians(20.0)
E, N = np.array([0.8, 0.6]), np.array([-0.6, 0.8])  # along and across the line of centres


def wheel(name, at, mass=0.5, **more):
    return fm.RigidBody(name, at=at, mass=mass, inertia=1e-3, **more)


def train(mesh, load=5.0, *, pin=None, at=Q, gravity=(0.0, 0.0)):
    """Two wheels on fixed axes; the first one driven, the second one loaded; `mesh` of both."""
    pin = pin or (lambda name, body, point: fm.Revolute(name, fm.GROUND, body, at=point))
    one, two = wheel("one", O), wheel("two", at)
    return fm.Mechanism("train", [
        one, two, pin("O", one, O), pin("Q", two, at), mesh(one, two),
        fm.Drive("motor", "O", fm.ConstantSpeed(10.0)), fm.Torque("load", two, load),
    ], gravity=gravity)  # fmt: skip


def gear(**more):
    return lambda one, two: fm.Gear("mesh", one, two, teeth=(20, 40), **more)


def belt(**more):
    return lambda one, two: fm.couplings.Belt("mesh", one, two, radii=(0.02, 0.05), **more)


def force(sol, pin, k=-1):
    return np.array([float(sol[f"{pin}.fx"][k]), float(sol[f"{pin}.fy"][k])])


@pytest.mark.parametrize("load", [5.0, -5.0])
@pytest.mark.parametrize("internal", [False, True])
def test_the_tooth_force_stands_in_both_bearings(load, internal):
    """F = T/r2 across the line of centres; F tan(alpha) parts the wheels, draws an inner wheel to the ring's centre."""
    sol = fm.simulate(train(gear(internal=internal), load), t_end=0.2)
    assert sol.ok, sol.status
    r1, r2 = (0.06, 0.12) if internal else (0.02, 0.04)
    F = 5.0 / r2
    assert abs(float(sol["mesh.force"][-1])) == pytest.approx(F, rel=1e-9)
    on_two = -force(sol, "Q")  # by the teeth: the pin holds it
    assert on_two @ E == pytest.approx((-1.0 if internal else 1.0) * F * math.tan(ALPHA), rel=1e-9)
    # the teeth's torque about the centre of the second wheel holds the load: its arm leads back to the pitch point
    arm = r2 if internal else -r2
    assert arm * (on_two @ N) * (-1.0 if internal else 1.0) == pytest.approx(-load, rel=1e-9)
    assert force(sol, "O") == pytest.approx(on_two, rel=1e-9)
    motor = float(sol["motor.torque"][-1])
    about_o = Q[0] * force(sol, "Q")[1] - Q[1] * force(sol, "Q")[0] + motor + load
    assert about_o == pytest.approx(0.0, abs=1e-9)


def test_friction_in_the_pins_takes_its_share():
    """5 (r1 + x)/(r2 - x) with x = mu R/cos(alpha): 2.92 N m, and 2.5 N m without."""
    mu, R = 0.2, 0.01

    def pin(name, body, at):
        law = fm.friction.ModifiedCoulomb(mu, 1e-4)
        return fm.Revolute(name, fm.GROUND, body, at=at, friction=law, radius=R)

    sol = fm.simulate(train(gear(), pin=pin), t_end=0.05)
    assert sol.ok, sol.status
    x = mu * R / math.cos(ALPHA)
    assert float(sol["motor.torque"][-1]) == pytest.approx(5.0 * (0.02 + x) / (0.04 - x), rel=1e-6)
    assert 5.0 * (0.02 + x) / (0.04 - x) == pytest.approx(2.92, abs=5e-3)


def elastic(pressure_angle=ALPHA, load=5.0, damping=40.0):
    """The second wheel in a soft bearing of 1e6 N/m, the first one driven."""
    one, two = wheel("one", O), wheel("two", Q)
    soft = fm.Bushing("Q", fm.GROUND, two, at=Q, stiffness=(1e6, 1e6), damping=(damping, damping))
    return fm.Mechanism("soft", [
        one, two, fm.Revolute("O", fm.GROUND, one, at=O), soft, gear(pressure_angle=pressure_angle)(one, two),
        fm.Drive("motor", "O", fm.ConstantSpeed(0.0)), fm.Torque("load", two, load),
    ])  # fmt: skip


def test_an_elastic_bearing_yields():
    """125 N over 1e6 N/m: 0.125 mm across the line of centres, times tan(alpha) along it, and the same in statics."""
    mech = elastic()
    sol = fm.simulate(mech, t_end=1.0)
    assert sol.ok, sol.status
    moved = np.array([float(sol["two.x"][-1]) - Q[0], float(sol["two.y"][-1]) - Q[1]])
    assert abs(moved @ N) == pytest.approx(1.25e-4, rel=5e-3)  # the line of centres turns and is longer by 45 um
    assert moved @ E == pytest.approx(1.25e-4 * math.tan(ALPHA), rel=2e-2)
    rest = fm.static_equilibrium(mech)
    assert rest["two.x"] == pytest.approx(float(sol["two.x"][-1]), abs=1e-10)
    assert np.abs(sol["energy.residual"].values).max() < 1e-4 * sol["energy.turned_over"].values[-1]


def test_energy_is_kept_in_elastic_bearings():
    """Without pressure angle the gradient of the ratio is all of the force: nothing is gained or lost."""
    sol = fm.simulate(elastic(0.0, damping=0.0), t_end=0.05, step=fm.Adaptive(rtol=1e-7))
    assert sol.ok, sol.status
    assert float(np.abs(sol["energy.dissipated_friction"].values).max()) == 0.0
    turned = sol["energy.turned_over"].values[-1]
    assert np.abs(sol["energy.residual"].values).max() < 1e-5 * turned


def test_the_ratio_holds_where_the_axes_move():
    """r1 (theta1 - phi) + r2 (theta2 - phi) = 0 to round-off while the bearing swings."""
    sol = fm.simulate(elastic(damping=0.0), t_end=0.02, save="steps")
    dx, dy = sol["two.x"].values, sol["two.y"].values
    phi = np.arctan2(dy, dx) - math.atan2(Q[1], Q[0])
    held = 0.02 * (sol["one.theta"].values - phi) + 0.04 * (sol["two.theta"].values - phi)
    assert np.abs(phi).max() > 1e-3
    assert np.abs(held).max() < 1e-12


def planetary(**more):
    """Sun driven, ring the ground, a load on the arm, whose centre of mass lies elsewhere."""
    axis = (0.05, 0.0)
    sun, planet, arm = wheel("sun", O), wheel("planet", axis), fm.RigidLink("arm", O, axis, mass=0.2, inertia=6e-5)
    return fm.Mechanism("planets", [
        sun, planet, arm, fm.Revolute("S", fm.GROUND, sun, at=O), fm.Revolute("C", fm.GROUND, arm, at=O),
        fm.Revolute("P", arm, planet, at=axis),
        fm.Gear("inner", sun, planet, teeth=(20, 30), arm=arm, **more),
        fm.Gear("outer", planet, fm.GROUND, teeth=(30, 80), internal=True, arm=arm, distance=0.05, **more),
        fm.Drive("motor", "S", fm.ConstantSpeed(50.0)), fm.Torque("load", arm, -10.0),
    ])  # fmt: skip


def test_a_planet_drives_its_arm_by_its_pin():
    """T = 2 F r_arm: the pin of the planet carries two tooth forces; radial ones of sun and ring cancel in it."""
    sol = fm.simulate(planetary(), t_end=1.0, save="steps")
    assert sol.ok, sol.status
    k = len(sol.time) // 2
    assert sol["arm.omega"].values == pytest.approx(10.0, rel=1e-9)  # z_s/(z_s + z_r) of 50
    angle = float(sol["arm.theta"][k])
    e, n = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
    F = 10.0 / 0.05 / 2.0
    pin = force(sol, "P", k)  # on the planet
    assert pin @ n == pytest.approx(-2.0 * F, rel=1e-8)
    assert pin @ e == pytest.approx(-0.5 * 100.0 * 0.05, rel=1e-6)  # m omega^2 r alone
    sun = force(sol, "S", k)
    assert sun @ n == pytest.approx(F, rel=1e-8)
    assert sun @ e == pytest.approx(F * math.tan(ALPHA), rel=1e-8)
    assert float(sol["motor.torque"][k]) == pytest.approx(10.0 / 5.0, rel=1e-8)


@pytest.mark.slow
def test_the_ratio_is_exact_over_a_thousand_turns():
    """Large steps, 1,000 turns of the arm: planet and arm where the teeth put them, to round-off of the angles."""
    mech = planetary()
    load = fm.Torque("load", mech.find("arm"), -1e-3)
    sol = fm.simulate(mech.with_part(load), t_end=2000.0 * math.pi / 10.0, step=0.02, save=50)
    assert sol.ok, sol.status
    turned, sun = sol["arm.theta"].values, sol["sun.theta"].values
    assert turned[-1] > 6200.0
    assert np.abs(turned - sun / 5.0).max() < 1e-11 * turned[-1]
    planet = sol["planet.theta"].values
    assert np.abs(planet - (turned - 2.0 / 3.0 * (sun - turned))).max() < 1e-11 * sun[-1]


def test_a_wheel_that_rolls_around_another_one_keeps_its_energy():
    """A planet on a free arm around a held sun: a pendulum of inertia m l^2 + J (1 + r1/r2)^2."""
    axis, g = (0.05, 0.0), 9.81
    planet, arm = wheel("planet", axis), fm.RigidLink("arm", O, axis, mass=1e-6, inertia=1e-9)
    mech = fm.Mechanism("roller", [
        planet, arm, fm.Revolute("C", fm.GROUND, arm, at=O), fm.Revolute("P", arm, planet, at=axis),
        fm.Gear("mesh", fm.GROUND, planet, teeth=(20, 30), arm=arm, distance=0.05),
    ], gravity=(0.0, -g))  # fmt: skip
    sol = fm.simulate(mech, t_end=1.0, step=fm.Adaptive(rtol=1e-7))
    assert sol.ok, sol.status
    inertia = 0.5 * 0.05**2 + 1e-3 * (5.0 / 3.0) ** 2
    drop = -sol["planet.y"].values
    assert 0.5 * inertia * sol["arm.omega"].values ** 2 == pytest.approx(0.5 * g * drop, abs=2e-5)
    assert float(drop.max()) == pytest.approx(0.05, rel=1e-3)


def test_wheels_are_centred_at_their_pins():
    """Geared cranks: bodies whose centres of mass lie beside their axes turn as their teeth say."""
    one, two = wheel("one", (0.01, 0.02)), wheel("two", (0.07, 0.05))
    mech = fm.Mechanism("cranks", [
        one, two, fm.Revolute("O", fm.GROUND, one, at=O), fm.Revolute("Q", fm.GROUND, two, at=Q), gear()(one, two),
        fm.Drive("motor", "O", fm.ConstantSpeed(10.0)),
    ])  # fmt: skip
    sol = fm.simulate(mech, t_end=2.0)
    assert sol["two.theta"].values == pytest.approx(-0.5 * sol["one.theta"].values, abs=1e-11)
    assert mech.find("mesh").radii(mech) == pytest.approx((0.02, 0.04))


def test_wheels_drawn_apart_and_on_one_axis_are_balanced():
    """Pitch circles of 0.06 m, axes 0.09 m apart: F (r1 + r2)/D in the pins; on one axis a torque on the casing."""
    sol = fm.simulate(train(gear(distance=0.06), at=(0.09, 0.0)), t_end=0.1)
    motor, pin = float(sol["motor.torque"][-1]), force(sol, "Q")
    assert abs(pin[1]) == pytest.approx(125.0 * 0.06 / 0.09, rel=1e-9)
    assert abs(pin[0]) == pytest.approx(abs(pin[1]) * math.tan(ALPHA), rel=1e-9)
    assert 0.09 * pin[1] + motor + 5.0 == pytest.approx(0.0, abs=1e-9)
    casing = fm.RigidBody("casing", at=O, mass=1.0, inertia=0.1)
    one, two = wheel("one", O), wheel("two", O)
    mech = fm.Mechanism("box", [
        casing, one, two, fm.Fixed("foot", fm.GROUND, casing, at=(0.3, 0.0)),
        fm.Revolute("O", casing, one, at=O), fm.Revolute("Q", casing, two, at=O),
        gear(distance=0.06, arm=casing)(one, two),
        fm.Drive("motor", "O", fm.ConstantSpeed(10.0)), fm.Torque("load", two, 5.0),
    ])  # fmt: skip
    sol = fm.simulate(mech, t_end=0.1)
    assert float(sol["foot.moment"][-1]) == pytest.approx(-5.0, rel=1e-9)  # 7.5 N m of the mesh, less the motor
    assert float(sol["two.omega"][-1]) == pytest.approx(-5.0)


@pytest.mark.parametrize("crossed", [False, True])
@pytest.mark.parametrize("pretension", [None, 400.0])
def test_strands_pull_along_their_tangents(crossed, pretension):
    """Tight and slack strand with tensions F and 0, or T0 +- F/2, each a tangent of both wheels."""
    r1, r2, D = 0.02, 0.05, 0.2
    sol = fm.simulate(train(belt(crossed=crossed, pretension=pretension), at=(D, 0.0)), t_end=0.1)
    assert sol.ok, sol.status
    F = 5.0 / r2
    mean = pretension or 0.5 * F
    sine = (r1 + r2 if crossed else r1 - r2) / D
    pin = force(sol, "Q")
    assert pin[0] == pytest.approx(2.0 * mean * math.sqrt(1.0 - sine * sine), rel=1e-9)
    assert abs(pin[1]) == pytest.approx(F * abs(sine), rel=1e-9)
    assert force(sol, "O") == pytest.approx(-pin, rel=1e-9)
    assert D * pin[1] + float(sol["motor.torque"][-1]) + 5.0 == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_rack_presses_its_pinion_off(side):
    """5 N m at 0.04 m: 125 N along the rack at the pitch point, 125 tan(alpha) away from it; statics of the guide."""
    pinion, rack = wheel("pinion", (0.0, 0.04 * side)), wheel("rack", (0.1, 0.0))
    mech = fm.Mechanism("rack", [
        pinion, rack, fm.Revolute("O", fm.GROUND, pinion, at=pinion.at),
        fm.Prismatic("guide", fm.GROUND, rack, along=(1.0, 0.0)),
        fm.couplings.Rack("teeth", pinion, rack, at=(0.0, 0.0)), fm.Drive("stop", "guide", fm.ConstantSpeed(0.0)),
        fm.Torque("load", pinion, 5.0),
    ])  # fmt: skip
    sol = fm.simulate(mech, t_end=0.1)
    pin = force(sol, "O")
    assert pin == pytest.approx([125.0 * side, -125.0 * math.tan(ALPHA) * side], rel=1e-9)
    assert float(sol["guide.fy"][-1]) == pytest.approx(-pin[1], rel=1e-9)
    assert float(sol["stop.force"][-1]) == pytest.approx(-pin[0], rel=1e-9)


LAW = fm.KelvinVoigt(stiffness=1e8, damping=2e3, ramp=1e-6)


@pytest.mark.parametrize("mesh", [gear(), gear(backlash=1e-5, normal=LAW)])
def test_inverse_dynamics_loads_the_bearings(mesh):
    motion = fm.inverse_dynamics(train(mesh), [0.0, 0.1])
    assert motion.torque("motor") == pytest.approx(2.5, rel=1e-9)
    for pin in ("O", "Q"):
        assert np.hypot(*motion.forces[pin][:, :2].T) == pytest.approx(125.0 / math.cos(ALPHA), rel=1e-9)


@pytest.mark.parametrize("crossed", [False, True])
def test_a_belt_with_friction_loads_its_bearings_alike(crossed):
    """Inverse dynamics without slip, and the run whose slip creeps: the same forces in the pins."""
    mech = train(belt(crossed=crossed, coefficient=0.4, pretension=400.0, creep=1e-4), at=(0.2, 0.0))
    sol, motion = fm.simulate(mech, t_end=0.05), fm.inverse_dynamics(mech, [0.0])
    for pin in ("O", "Q"):
        assert motion.forces[pin][0, :2] == pytest.approx(force(sol, pin), rel=1e-6)


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("mech", "parts"),
    [
        (elastic(), ("mesh",)), (planetary(), ("inner", "outer")),
        (train(belt(), at=(0.2, 0.0)), ("mesh",)),
        (train(belt(crossed=True, pretension=300.0), at=(0.2, 0.0)), ("mesh",)),
        (train(lambda one, two: fm.couplings.Rack("mesh", one, two, at=(0.0, -0.03))), ("mesh",)),
    ],
)  # fmt: skip
def test_contracts(mech, parts):
    for part in parts:
        fm.testing.check_part(mech, part)


def test_wrong_centres_are_refused():
    one, two = wheel("one", O), wheel("two", Q)
    with pytest.raises(InputError, match="give two points"):
        fm.Gear("mesh", one, two, teeth=(20, 40), centres=(O,))
    with pytest.raises(ModelError, match=r"pin of the arm at its centre, or centres="):
        fm.simulate(train(lambda a, _: fm.Gear("mesh", a, fm.GROUND, teeth=(20, 40), distance=0.07)), t_end=0.1)
