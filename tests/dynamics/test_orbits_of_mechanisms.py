"""Periodic orbits of mechanisms: a driven mass against its closed form, whole turns, a slider-crank with a worn pin."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.dynamics.basins import basin
from flexmb.dynamics.orbits.continuation import follow
from flexmb.dynamics.orbits.periodic_orbit import periodic_orbit
from flexmb.dynamics.orbits.shooting import StateSpace
from flexmb.dynamics.systems.mechanism_flow import MechanismFlow

K, D, M, F, W = 100.0, 0.8, 1.0, 3.0, 8.0


def shaken():
    """A mass on spring and damper with the force F cos(W t)."""
    mass = fm.RigidBody("mass", at=(1.0, 0.0), mass=M, inertia=0.1, velocity=(0.2, 0.0, 0.0))
    ends = {"at": (0.0, 0.0), "to": (1.0, 0.0)}
    force = fm.drives.Harmonic(1.0, frequency=W / (2 * math.pi), phase=math.pi / 2)
    return fm.Mechanism(
        "shaker",
        [
            mass,
            fm.Prismatic("guide", fm.GROUND, mass, along=(1.0, 0.0)),
            fm.SpringDamper("spring", fm.GROUND, mass, **ends, stiffness=K, damping=D),
            fm.Force("shake", mass, at=(1.0, 0.0), force=(F, 0.0), history=force),
        ],
    )


def errors(parts):
    """Of state and multiplier with a period in so many steps."""
    T = 2 * math.pi / W
    orbit = periodic_orbit(MechanismFlow(shaken(), step=T / parts, period=T), tangent="differences", tolerance=1e-9)
    assert orbit.ok, orbit.status
    assert orbit.iterations == 1
    x = F / (K - M * W**2 + 1j * D * W)
    exact = np.exp((-D / 2 / M + 1j * math.sqrt(K / M - (D / 2 / M) ** 2)) * T)
    found = orbit.multipliers[np.argmax(orbit.multipliers.imag)]
    away = [orbit.state[0] - 1 - x.real, (orbit.state[3] - (1j * W * x).real) / W]
    return np.abs(away).max() / abs(x), min(abs(found - exact), abs(found - exact.conjugate()))


def test_driven_mass_is_found_with_the_order_of_the_steps():
    coarse, fine = errors(100), errors(200)
    for rough, better in zip(coarse, fine, strict=True):
        assert rough / better == pytest.approx(4.0, rel=0.05)
    assert max(fine) < 1e-3


def test_error_controlled_steps_find_it_as_well():
    T = 2 * math.pi / W
    orbit = periodic_orbit(MechanismFlow(shaken(), period=T), tangent="differences")
    assert orbit.ok, orbit.status
    x = F / (K - M * W**2 + 1j * D * W)
    assert orbit.state[0] - 1 == pytest.approx(x.real, abs=1e-4 * abs(x))
    motion = orbit.samples(50)
    t = motion["time"].values
    np.testing.assert_allclose(motion["mass.x"].values - 1, (x * np.exp(1j * W * t)).real, atol=3e-4 * abs(x))


@pytest.mark.slow
def test_driven_mass_is_followed_along_a_parameter():
    T = 2 * math.pi / W
    orbit = periodic_orbit(MechanismFlow(shaken(), step=T / 400, period=T), tangent="differences")
    branch = follow(orbit, "spring.stiffness", (100.0, 150.0), largest=0.3, step=0.1)
    assert branch.ok, branch.status
    assert all(p.stable for p in branch.points)
    for p in branch.points:
        x = F / (p.value - M * W**2 + 1j * D * W)
        assert p.state[0] - 1 == pytest.approx(x.real, abs=2e-4 * abs(x))


@pytest.mark.slow
def test_a_branch_ends_where_a_part_refuses_the_value():
    T = 2 * math.pi / W
    orbit = periodic_orbit(MechanismFlow(shaken(), step=T / 100, period=T), tangent="differences")
    branch = follow(orbit, "spring.damping", (0.8, -0.8), largest=0.3, step=0.1, smallest=1e-3)
    assert not branch.ok
    assert "must be >= 0" in branch.status
    assert 0.0 <= branch.points[-1].value < 0.05
    with pytest.raises(fm.errors.InputError, match="must be >= 0"):
        follow(orbit, "spring.damping", (-0.8, 0.8))
    with pytest.raises(fm.errors.FlexmbError, match="dampings"):
        follow(orbit, "spring.dampings", (0.8, 0.1))


def test_a_mechanism_without_drive_needs_a_period():
    flow = MechanismFlow(shaken(), step=1e-3)
    with pytest.raises(fm.errors.InputError, match="no periodic drive and no period= is given"):
        periodic_orbit(flow)


def turning(friction=None):
    """A crank that turns once a period, with a spring that pulls at it through a slider."""
    return fm.mechanisms.slider_crank(100.0, friction=friction)


def test_a_turning_crank_comes_back_a_turn_further():
    # an ideal slider-crank has no freedom: each state that its joints allow is on the orbit
    orbit = periodic_orbit(MechanismFlow(turning(), step=1e-4), tangent="differences")
    assert orbit.ok, orbit.status
    assert orbit.period == pytest.approx(2 * math.pi / 100.0)
    assert len(orbit.multipliers) == 0
    assert orbit.stable
    turned = orbit.samples(20)["crank.theta"].values
    assert turned[-1] - turned[0] == pytest.approx(2 * math.pi, abs=1e-6)


def test_histories_of_friction_must_come_back_and_those_of_contacts_are_handed_on():
    law = fm.friction.LuGre(static=0.2, kinetic=0.1)
    mechanism = fm.mechanisms.slider_crank(100.0, clearance=1e-4, friction=law)
    flow = MechanismFlow(mechanism, step=1e-5)
    space = StateSpace("test", flow)
    n, n_z = flow.program.n_q, flow.program.tables.sizes.n_z
    assert len(space.history_rows) == 2  # the bristles and their rate
    assert space.free_rows.sum() == n_z - 2
    assert not space.free_rows[space.history_rows].any()
    assert (space.history_rows >= 2 * n).all()
    one, other = flow.state(), flow.state()
    other[2] += 4 * math.pi
    assert space.length(space.difference(one, other)) < 1e-12


@pytest.mark.slow
def test_multipliers_that_steps_make_uncertain_are_told():
    """Steps that change from run to run are 41 % of a difference of motions with impacts, and none of a smooth one."""
    T, (mass, *others) = 2 * math.pi / W, shaken().parts
    law, play = fm.KelvinVoigt(stiffness=2e3, damping=3.0), 0.2 * abs(F / (K - M * W**2 + 1j * D * W))
    worn = fm.RevoluteClearance("J", fm.GROUND, mass, at=(1.0, 0.0), clearance=play, bearing_radius=0.5, normal=law)
    flow = MechanismFlow(fm.Mechanism("worn", [mass, *others, worn]), period=T)
    orbit = periodic_orbit(flow, settle=40)
    assert orbit.ok, orbit.status
    assert "Multipliers change" not in orbit.status
    beside = periodic_orbit(flow, guess=orbit.state, tangent="differences")
    assert np.abs(beside.multipliers - orbit.multipliers).max() > 0.1
    assert "Multipliers change by 0.41 with differences 5 times as large. Take fixed steps" in beside.status
    smooth = periodic_orbit(MechanismFlow(shaken(), period=T), tangent="differences")
    assert smooth.ok
    assert "Multipliers change" not in smooth.status


def test_basin_of_a_mechanism_is_asked_for_by_coordinates():
    T = 2 * math.pi / W
    heavy = shaken().with_({"spring.damping": 20.0})
    flow = MechanismFlow(heavy, step=T / 50, period=T)
    found = basin(flow, ("mass.x", [0.9, 1.1]), ("mass.vx", [-0.5, 0.5]), settle=5)
    assert found.units == ("m", "m/s")
    assert (found.number == 1).all()
    assert found.periods == (1,)
    x = F / (K - M * W**2 + 20j * W)
    assert found.attractors[0][-1][0] - 1 == pytest.approx(x.real, abs=5e-3 * abs(x))


@pytest.mark.slow
def test_slider_crank_with_worn_pin_has_an_orbit_that_simulation_confirms():
    # 3000 rpm, soft impacts, friction: an orbit of one period, found where simulation does not settle on it
    steel = fm.Material(207e9, 7801.0, 0.3)
    mechanism = fm.mechanisms.slider_crank(100 * math.pi, clearance=1e-4, friction="coulomb").with_(
        {"B.normal": fm.contact.ExactRestitution.from_materials(steel, steel, restitution=0.02)}
    )
    flow = MechanismFlow(mechanism, step=1e-6)
    orbit = periodic_orbit(flow, settle=40, tangent="differences", tolerance=1e-8)
    assert orbit.ok, orbit.status
    # each correction gains more than the one before, down to 1e-8 of the state (1e-5 of the clearance)
    assert orbit.residuals[-1] < 1e-3 * orbit.residuals[0]
    assert orbit.loss.kind == "flip"
    assert orbit.multipliers[0].real < -1.0
    assert len(orbit.multipliers) == 4
    assert np.abs(orbit.multipliers[1:]).max() < 0.5
    pin = [flow.names.index(name) for name in ("B.ex", "B.ey")]
    system = orbit.system()
    first = system.observe()[pin]
    system.advance(orbit.period)
    once = system.observe()[pin]
    assert np.abs(once - first).max() < 1e-4 * 1e-4
    system.advance(orbit.period)
    twice = system.observe()[pin]
    assert np.hypot(*first) == pytest.approx(1e-4, rel=0.05)  # the pin lies on its bearing
    assert np.abs(twice - once).max() < 1e-3 * 1e-4


@pytest.mark.slow
def test_grazing_of_a_worn_joint_is_located():
    # the pin swings freely in its bearing, until the clearance is its amplitude |F/(K - M W^2 + i D W)|
    parts = shaken().parts
    mass = parts[0]
    law = fm.KelvinVoigt(stiffness=2e3, damping=0.0)
    amplitude = abs(F / (K - M * W**2 + 1j * D * W))
    bearing = fm.RevoluteClearance(
        "J", fm.GROUND, mass, at=(1.0, 0.0), clearance=1.2 * amplitude, bearing_radius=0.5, normal=law
    )
    T = 2 * math.pi / W
    flow = MechanismFlow(fm.Mechanism("worn", [*parts, bearing]), step=T / 500, period=T)
    orbit = periodic_orbit(flow, tangent="differences")
    assert orbit.ok, orbit.status
    assert orbit.grazing["J.penetration"] == pytest.approx(0.2 * amplitude, rel=1e-3)
    branch = follow(orbit, "J.clearance", (1.2 * amplitude, 0.98 * amplitude), step=0.1, largest=0.2)
    found = [e for e in branch.events if e.kind == "grazing"]
    assert len(found) == 1
    # the steps make the amplitude larger by 4e-5
    assert found[0].value == pytest.approx(amplitude, rel=6e-5)


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("frequency", "times", "ok"), [(4.0, 1, True), (1.0, 1, False), (1.0, 2, True), (0.7, 1, False)]
)
def test_a_load_of_another_period_than_the_drives(frequency, times, ok):
    """Beside a crank with two turns a second, a load of 1 Hz has orbits of two turns, one of 0.7 Hz of twenty."""
    crank = fm.RigidBody("crank", at=(0.0, 0.0), mass=1.0, inertia=1e-3)
    block = fm.RigidBody("block", at=(0.0, 0.0), mass=1.0, inertia=1e-3)
    hinge = fm.Revolute("hinge", fm.GROUND, crank, at=(0.0, 0.0))
    guide = fm.Prismatic("guide", fm.GROUND, block, at=(0.0, 0.0))
    spring = fm.SpringDamper("spring", fm.GROUND, block, at=(-1.0, 0.0), to=(0.0, 0.0), stiffness=400.0, damping=4.0)
    history = fm.drives.Harmonic(1.0, frequency=frequency)
    push = fm.Force("push", block, at=(0.0, 0.0), force=(10.0, 0.0), history=history)
    motor = fm.Drive("motor", hinge, fm.drives.ConstantSpeed(4.0 * np.pi))
    mech = fm.Mechanism("pushed", [crank, block, hinge, guide, spring, push, motor])
    found = fm.chaos.periodic_orbit(mech, times=times)
    assert found.ok == ok
    if not ok:
        assert "comes back after 0.5 s and not after twice that: a load has another period" in found.status
