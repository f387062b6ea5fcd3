"""Linear relations, cables and one-way clutches against closed forms and balances."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import flexmb as fm
from flexmb.errors import InputError, ModelError

O, Q = (0.0, 0.0), (0.09, 0.0)
COUPLING = fm.couplings.Coupling


def wheel(name, at=O, inertia=1e-3, **given):
    return fm.RigidBody(name, at=at, mass=0.5, inertia=inertia, **given)


def train(mesh):
    pinion, second = wheel("pinion", inertia=1e-4), wheel("wheel", Q)
    return fm.Mechanism("train", [
        pinion, second, fm.Revolute("O", fm.GROUND, pinion, at=O), fm.Revolute("Q", fm.GROUND, second, at=Q), mesh,
        fm.Drive("motor", joint="O", motion=fm.drives.Polynomial((0.0, 1.0, 4.0))), fm.Torque("load", second, -3.0),
    ])  # fmt: skip


def test_a_relation_of_two_angles_is_a_gear_pair():
    gear = fm.simulate(
        train(fm.Gear("mesh", wheel("pinion"), wheel("wheel"), teeth=(20, 40), distance=0.09)), t_end=0.3
    )
    sol = fm.simulate(train(COUPLING("mesh", {"O": 20.0, "Q": 40.0})), t_end=0.3)
    assert sol.ok, sol.status
    assert sol["wheel.theta"].values == pytest.approx(gear["wheel.theta"].values, abs=1e-12)
    assert sol["mesh.Q_torque"].values[1:] == pytest.approx(gear["mesh.second_torque"].values[1:], rel=1e-8)
    assert sol["mesh.Q_power"].values[1:] == pytest.approx(gear["mesh.power"].values[1:], rel=1e-8)
    assert sol["mesh.O_power"].values + sol["mesh.Q_power"].values == pytest.approx(0.0, abs=1e-9)
    assert sol["mesh.O_speed"].values == pytest.approx(sol["motor.speed"].values, abs=1e-12)


def test_a_screw_lifts_its_load():
    """Torque = force pitch/(2 pi), as virtual work wants."""
    pitch, m, g = 4e-3, 8.0, 9.81
    screw, nut = wheel("screw"), fm.RigidBody("nut", at=(0.2, 0.5), mass=m, inertia=0.1)
    mech = fm.Mechanism("jack", [
        screw, nut, fm.Revolute("turn", fm.GROUND, screw, at=O), fm.Prismatic("lift", fm.GROUND, nut, along=(0.0, 1.0)),
        COUPLING("thread", {"turn": -pitch / (2.0 * math.pi), "lift": 1.0}),
        fm.Drive("motor", "turn", fm.ConstantSpeed(30.0)),
    ], gravity=(0.0, -g))  # fmt: skip
    sol = fm.simulate(mech, t_end=0.5)
    assert sol["nut.y"].values - 0.5 == pytest.approx(pitch / (2.0 * math.pi) * sol["screw.theta"].values, abs=1e-12)
    assert sol["thread.lift_force"].values[1:] == pytest.approx(m * g, rel=1e-8)
    assert sol["motor.torque"].values[1:] == pytest.approx(m * g * pitch / (2.0 * math.pi), rel=1e-8)
    assert sol["thread.turn_torque"].values[1:] == pytest.approx(-m * g * pitch / (2.0 * math.pi), rel=1e-8)


def spiral(value=0.0):
    """A slider on an arm that turns at 5 rad/s moves out by 0.04 m per rad, on a guide beside the centre."""
    arm = wheel("arm", inertia=0.3, angle=0.4)
    slider = fm.RigidBody("slider", at=(0.3, 0.1), mass=0.7, inertia=2e-3)
    return fm.Mechanism("spiral", [
        arm, slider, fm.Revolute("O", fm.GROUND, arm, at=O), fm.Prismatic("guide", arm, slider, along=(1.0, 0.0)),
        COUPLING("cord", {"guide": 2.0, "O": -0.08}, value), fm.Drive("motor", "O", fm.ConstantSpeed(5.0)),
    ])  # fmt: skip


def test_a_relation_on_a_turning_guide():
    """In the turning axes the slider stands at (0.3 + 0.04 angle, 0.1): force and torque from its absolute motion."""
    sol = fm.simulate(spiral(), t_end=2.0, save="steps")
    assert sol.ok, sol.status
    w, u, m = 5.0, 0.04 * 5.0, 0.7
    x, y = 0.3 + u * sol.time, 0.1
    assert sol["cord.guide_speed"].values == pytest.approx(u, rel=1e-9)
    along, across = -w * w * x, 2.0 * w * u - w * w * y  # acceleration in the turning axes
    assert sol["cord.guide_force"].values[20:] == pytest.approx(m * along[20:], rel=1e-5)
    total = m * (x * across - y * along)  # moment of the slider's inertia about O, by motor and cord
    assert (sol["motor.torque"].values + sol["cord.O_torque"].values)[20:] == pytest.approx(total[20:], rel=1e-5)
    powers = sol["cord.guide_power"].values + sol["cord.O_power"].values
    assert np.abs(powers).max() < 1e-9 * np.abs(sol["cord.guide_power"].values).max()


def test_a_value_moves_the_start():
    q = fm.simulate(spiral(value=0.05), t_end=0.1)
    assert np.hypot(q["slider.x"][0], q["slider.y"][0]) == pytest.approx(math.hypot(0.325, 0.1), rel=1e-9)


def test_a_fall_into_a_cable():
    """A mass falls h with slack cable: elongation (m g/k) (1 + sqrt(1 + 2 k h/(m g))), then it is thrown back."""
    m, g, k, slack = 2.0, 9.81, 5e3, 0.3
    stone = fm.RigidBody("stone", at=(0.0, -1.0), mass=m, inertia=1e-2, velocity=(0.0, 0.0, 0.0))
    rope = fm.couplings.Cable(
        "rope", fm.GROUND, stone, at=O, to=(0.0, -1.0), free_length=1.0 + slack, normal=fm.KelvinVoigt(k, 0.0)
    )
    sol = fm.simulate(fm.Mechanism("bungee", [stone, rope], gravity=(0.0, -g)), t_end=0.8, step=fm.Adaptive(rtol=1e-6))
    assert sol.ok, sol.status
    deep = m * g / k * (1.0 + math.sqrt(1.0 + 2.0 * k * slack / (m * g)))
    assert sol.peak("rope.penetration").value == pytest.approx(deep, rel=1e-4)
    assert sol.peak("rope.normal_force").value == pytest.approx(k * deep, rel=1e-4)
    assert sol.episodes("rope")[0].start == pytest.approx(math.sqrt(2.0 * slack / g), rel=1e-6)
    assert sol.peak("rope.distance").value == pytest.approx(1.0 + slack + deep, rel=1e-5)
    assert float(sol["rope.fy"].min()) >= 0.0  # it pulls up or does nothing


STAY, STRETCH = 1e4, 0.02


def stays(law, mass=2.0, g=9.81, damping=0.0):
    """A body between two level cables of 1 m that are drawn 2 % longer than they are."""
    body = fm.RigidBody("body", at=O, mass=mass, inertia=1e-3)
    cables = [
        fm.couplings.Cable(n, fm.GROUND, body, at=(x, 0.0), to=O, free_length=1.0 - STRETCH, normal=law)
        for n, x in (("left", -1.0), ("right", 1.0))
    ]
    return fm.Mechanism("stays", [
        body, *cables, fm.couplings.SameRotation("level", fm.GROUND, body),
        fm.SpringDamper("oil", fm.GROUND, body, at=(0.0, -1.0), to=O, stiffness=0.0, damping=damping),
    ], gravity=(0.0, -g))  # fmt: skip


def test_prestressed_cables_hang_as_their_tension_says():
    """2 k (L - L0) sin = m g with L^2 = 1 + y^2: statics, and the end of a damped run; the tension at the start."""
    mech = stays(fm.KelvinVoigt(STAY, 50.0), damping=20.0)

    def lift(y):
        return -2.0 * STAY * (math.hypot(1.0, y) - 1.0 + STRETCH) * y / math.hypot(1.0, y) - 2.0 * 9.81

    y = brentq(lift, -0.5, 0.0, xtol=1e-15)
    assert fm.static_equilibrium(mech)["body.y"] == pytest.approx(y, rel=1e-9)
    sol = fm.simulate(mech, t_end=15.0)
    assert sol.ok, sol.status
    assert sol["left.normal_force"].values[0] == pytest.approx(STAY * STRETCH, rel=1e-12)
    assert sol["body.y"].values[-1] == pytest.approx(y, rel=1e-8)
    assert np.abs(sol["energy.residual"].values).max() < 1e-4 * sol["energy.turned_over"].values[-1]


def test_pretension_is_the_stiffness_across_cables():
    """Small vibration across two cables under the tension T: omega^2 = 2 T/(m l); along them 2 k/m."""
    mech = stays(fm.KelvinVoigt(STAY, 0.0), g=0.0)
    body = mech.find("body")
    for velocity, axis, exact in (((0.0, 1e-3, 0.0), "y", STAY * STRETCH), ((1e-3, 0.0, 0.0), "x", STAY)):
        moving = mech.with_part(replace(body, velocity=velocity))
        omega = math.sqrt(2.0 * exact / 2.0)
        sol = fm.simulate(moving, t_end=4.0 * math.pi / omega, step=math.pi / omega / 400.0, method=fm.RungeKutta4())
        assert sol.ok, sol.status
        assert sol[f"body.{axis}"].values == pytest.approx(
            1e-3 / omega * np.sin(omega * sol.time), abs=2e-4 * 1e-3 / omega
        )


def test_a_taut_cable_swings_as_a_rod():
    """A stiff cable whose weight is held: tension m g cos + m v^2/l of a pendulum."""
    m, l = 1.0, 0.7
    bob = fm.RigidBody("bob", at=(l, 0.0), mass=m, inertia=1e-3)
    rope = fm.couplings.Cable("rope", fm.GROUND, bob, at=O, to=(l, 0.0), normal=fm.KelvinVoigt(1e6, 200.0, ramp=1e-6))
    sol = fm.simulate(fm.Mechanism("swing", [bob, rope], gravity=(0.0, -9.81)), t_end=0.4)
    assert sol.ok, sol.status
    drop, tension = -sol["bob.y"].values[-1], sol["rope.normal_force"].values[-1]
    assert tension == pytest.approx(3.0 * m * 9.81 * drop / l, rel=2e-3)  # from rest at the side: 3 m g sin


def clutch(omega, free="counter-clockwise", torque=0.0, damping=0.0):
    rotor = wheel("rotor", inertia=0.02, velocity=(0.0, 0.0, omega))
    parts = [
        rotor,
        fm.couplings.OneWayClutch("clutch", fm.GROUND, rotor, at=O, stiffness=800.0, damping=damping, free=free),
    ]
    return fm.Mechanism("freewheel", [*parts, fm.Torque("load", rotor, torque)] if torque else parts)


@pytest.mark.parametrize(("omega", "free"), [(-6.0, "counter-clockwise"), (6.0, "clockwise")])
def test_a_clutch_throws_back_and_lets_go(omega, free):
    """Wind-up omega sqrt(J/k), torque omega sqrt(J k), half a period; then free rotation at the same speed back."""
    sol = fm.simulate(clutch(omega, free), t_end=0.1)
    assert sol.ok, sol.status
    root = math.sqrt(0.02 * 800.0)
    assert np.abs(sol["clutch.torque"].values).max() == pytest.approx(6.0 * root, rel=1e-3)
    assert np.abs(sol["rotor.theta"].values.min() if omega < 0 else sol["rotor.theta"].values.max()) == pytest.approx(
        6.0 * 0.02 / root, rel=1e-3
    )
    assert sol["rotor.omega"].values[-1] == pytest.approx(-omega, rel=1e-3)
    assert np.all(np.sign(sol["clutch.torque"].values) != np.sign(omega))
    free_flight = sol.time > math.pi * math.sqrt(0.02 / 800.0) * 1.01
    assert np.all(sol["clutch.torque"].values[free_flight] == 0.0)
    assert np.abs(sol["energy.residual"].values).max() < 1e-6


def test_a_clutch_holds_a_load_and_overruns():
    held = fm.simulate(clutch(0.0, torque=-16.0, damping=2.0), t_end=0.4)
    assert held["clutch.torque"].values[-1] == pytest.approx(16.0, rel=1e-6)
    assert held["rotor.theta"].values[-1] == pytest.approx(-16.0 / 800.0, rel=1e-5)
    runs = fm.simulate(clutch(5.0), t_end=0.4)
    assert runs["rotor.omega"].values == pytest.approx(5.0, rel=1e-12)


def test_a_clutch_rectifies():
    """An input that swings drives the output forth only: one advance of about 2 A each period, against a brake."""
    inner, outer = wheel("inner", inertia=1e-4), wheel("outer", inertia=1e-4)
    mech = fm.Mechanism("rectifier", [
        inner, outer, fm.Revolute("O", fm.GROUND, inner, at=O),
        fm.couplings.OneWayClutch("clutch", inner, outer, at=O, stiffness=2e3, damping=0.2),
        fm.TorsionSpring("brake", fm.GROUND, outer, stiffness=0.0, damping=0.5),
        fm.Drive("motor", "O", fm.drives.Harmonic(0.3, 2.0, 0.0, 0.0)),
    ])  # fmt: skip
    sol = fm.simulate(mech, t_end=2.0)
    assert sol.ok, sol.status
    assert float(sol["outer.omega"].values.min()) > -0.05
    assert np.abs(sol["energy.residual"].values).max() < 1e-4 * np.abs(sol["energy.drive_work"].values).max()
    turned = sol["outer.theta"].values[-1] - sol["outer.theta"].values[len(sol.time) // 2]
    assert turned == pytest.approx(2.0 * 0.6, rel=0.02)


def loaded(stiffness=1e4):
    """A rotor that 20 N m bring to rest at 0.05 s and press into its clutch, with 20 (1 - cos) from there on."""
    rotor = wheel("rotor", inertia=0.1, velocity=(0.0, 0.0, 10.0))
    lock = fm.couplings.OneWayClutch("clutch", fm.GROUND, rotor, at=O, stiffness=stiffness)
    return fm.Mechanism("loaded", [rotor, lock, fm.Torque("load", rotor, -20.0)])


def torque_error(sol, stiffness=1e4):
    exact = np.where(sol.time > 0.05, 20.0 * (1.0 - np.cos(math.sqrt(stiffness / 0.1) * (sol.time - 0.05))), 0.0)
    return float(np.abs(sol["clutch.torque"].values - exact).max() / 40.0)


def test_a_clutch_is_as_exact_as_its_method():
    """The wind-up was the trapezoidal rule of its rate: RadauIIA was 10 % off by default, and ok."""
    sol = fm.simulate(loaded(), t_end=0.15, method=fm.RadauIIA())
    assert sol.ok
    assert torque_error(sol) < 1e-4


@pytest.mark.parametrize(("stiffness", "h", "least"), [(1e4, 1e-3, 0.1), (1e5, 5e-4, 0.5), (1e5, 1e-3, 0.9)])
def test_a_clutch_that_fixed_steps_do_not_resolve_is_told(stiffness, h, least):
    """Its vibration under load loses phase; nothing was said."""
    sol = fm.simulate(loaded(stiffness), t_end=0.15, step=h)
    assert torque_error(sol, stiffness) > least
    assert any(
        f"{math.sqrt(stiffness / 0.1) / (2.0 * math.pi):.4g} Hz (mostly rotor.theta)" in note for note in sol.notes
    )


def thrown_back(damping, inertia=0.1, stiffness=1e4, speed=10.0):
    """Speed of a rotor as a damped clutch lets it go: where J w'' = -(k w + d w') is 0 again."""
    decay = 0.5 * damping / inertia
    omega = math.sqrt(stiffness / inertia - decay**2)
    t = math.atan2(2.0 * decay * omega, decay**2 - omega**2) / omega
    return speed * math.exp(-decay * t) * (decay / omega * math.sin(omega * t) - math.cos(omega * t))


@pytest.mark.parametrize("damping", [2.0, 10.0, 40.0])
@pytest.mark.parametrize(("step", "within"), [(fm.Adaptive(), 5e-4), (1e-4, 5e-4), (5e-4, 1e-2)])
def test_a_damped_clutch_that_is_wound_up_from_the_start(damping, step, within):
    """It pulls at once; fixed steps of 5e-4 s were 0.9, 2.9 and 11 % off, of 1e-4 s 0.1, 0.5 and 2 %, and ok."""
    rotor = wheel("rotor", inertia=0.1, velocity=(0.0, 0.0, -10.0))
    lock = fm.couplings.OneWayClutch("clutch", fm.GROUND, rotor, at=O, stiffness=1e4, damping=damping)
    sol = fm.simulate(fm.Mechanism("damped", [rotor, lock]), t_end=0.1, step=step)
    assert sol.ok, sol.status
    assert sol["clutch.torque"].values[0] == pytest.approx(10.0 * damping, rel=1e-12)
    assert sol["rotor.omega"].values[-1] == pytest.approx(thrown_back(damping), rel=within)


@pytest.mark.quick(5)
@pytest.mark.parametrize("damping", [0.0, 2.0, 10.0, 40.0])
@pytest.mark.parametrize("steps", [4, 6, 10, 20, 40])
def test_an_engagement_of_a_few_fixed_steps_is_told(damping, steps):
    """With six steps an engagement the speed behind it was up to 10 % off, and nothing was said."""
    rotor = wheel("rotor", inertia=0.1, velocity=(0.0, 0.0, -10.0))
    lock = fm.couplings.OneWayClutch("clutch", fm.GROUND, rotor, at=O, stiffness=1e4, damping=damping)
    mech = fm.Mechanism("damped", [rotor, lock])
    sol = fm.simulate(mech, t_end=0.1, step=math.pi * math.sqrt(0.1 / 1e4) / steps)
    error = abs(float(sol["rotor.omega"].values[-1]) / (thrown_back(damping) if damping else 10.0) - 1.0)
    told = any("engages at t = " in note for note in sol.notes)
    assert told or error < 0.02
    assert not told or error > 0.004
    assert not any("engages" in note for note in fm.simulate(mech, t_end=0.1).notes)


def test_a_clutch_that_only_holds_may_have_long_steps():
    sol = fm.simulate(clutch(0.0, torque=-16.0, damping=50.0), t_end=2.0, step=1e-2)
    assert sol["clutch.torque"].values[-1] == pytest.approx(16.0, rel=1e-6)
    assert not any("engages" in note for note in sol.notes[1:])


@pytest.mark.parametrize(("h", "faster"), [(5e-4, 1.0311), (1e-3, 1.1159)])
def test_a_clutch_gives_back_no_more_than_it_took(h, faster):
    """A rotor comes back faster than it went in, since the steps pass its release: a gain was booked as friction."""
    rotor = wheel("rotor", inertia=0.1, velocity=(0.0, 0.0, -10.0))
    lock = fm.couplings.OneWayClutch("clutch", fm.GROUND, rotor, at=O, stiffness=1e5)
    mech = fm.Mechanism("spun", [rotor, lock])
    fine, coarse = fm.simulate(mech, t_end=0.15), fm.simulate(mech, t_end=0.15, step=h)
    assert fine.ok
    assert fine["rotor.omega"].values[-1] == pytest.approx(10.0, rel=1e-3)
    assert coarse["rotor.omega"].values[-1] == pytest.approx(10.0 * faster, rel=1e-3)
    made = -float(coarse["energy.dissipated_algorithm"][-1])
    assert made == pytest.approx(5.0 * (faster**2 - 1.0), rel=0.02)
    assert not coarse.ok
    assert "the steps made energy" in coarse.status


def test_wrong_relations_are_refused():
    for factors, words in (
        ({}, "factors is empty"),
        ({"O": 0.0}, r"factors\['O'\] is 0"),
        ({"O": "2"}, r"factors\['O'\] is '2'; it must be a number"),
        (3.0, "give a dictionary"),
        ({2: 1.0}, "holds the joint 2"),
        ((3.0,), "holds 3.0; give pairs"),
        ((("O", 1.0), ("O", 2.0)), "holds joint 'O' twice; add up"),
    ):
        with pytest.raises(InputError, match=words):
            COUPLING("mesh", factors)
    with pytest.raises(ModelError, match=r"refers to joint 'P'.*Known: O, Q"):
        train(COUPLING("mesh", {"O": 1.0, "P": 2.0}))
    with pytest.raises(ModelError, match="Torque 'load' has no angle or travel"):
        train(COUPLING("mesh", {"O": 1.0, "load": 2.0}))
    stone = wheel("stone", at=(1.0, 0.0))
    with pytest.raises(InputError, match="length is -1 m"):
        fm.couplings.Cable(
            "rope", fm.GROUND, stone, at=O, to=(1.0, 0.0), free_length=-1.0, normal=fm.KelvinVoigt(1.0, 0.0)
        )
    with pytest.raises(ModelError, match="ties 'stone' to itself"):
        fm.couplings.Cable("rope", stone, stone, at=O, to=(1.0, 0.0), normal=fm.KelvinVoigt(1.0, 0.0))
    with pytest.raises(InputError, match="so the cable needs a length"):
        fm.couplings.Cable("rope", fm.GROUND, stone, at=O, to=O, normal=fm.KelvinVoigt(1.0, 0.0))
    with pytest.raises(InputError, match=r"free is 'left'"):
        fm.couplings.OneWayClutch("c", fm.GROUND, stone, at=O, stiffness=1.0, free="left")
