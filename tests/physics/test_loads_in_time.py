"""Motions as histories of loads, and loads that follow their body, against exact formulas."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

import flexmb as fm

W, T = 6.0, 15.0  # final speed [rad/s] and time of the start [s]: the spin-up of Simo and Vu-Quoc


def value(motion, t):
    """s, s_dot, s_ddot of the compiled kernel."""
    return motion.kernel.dispatcher(np.array(motion.parameters()), float(t))


def test_cycloidal_ramp_is_the_published_spin_up():
    """Simo, Vu-Quoc (1986): the angle of the rotating beam."""
    motion = fm.drives.CycloidalRamp(W, T)
    for t in (0.5, 3.0, 7.5, 11.0, 14.99):
        angle = W / T * (t**2 / 2.0 + (T / (2.0 * math.pi)) ** 2 * (math.cos(2.0 * math.pi * t / T) - 1.0))
        assert value(motion, t)[0] == pytest.approx(angle, rel=1e-13)
    assert value(motion, T) == (pytest.approx(W * T / 2.0, rel=1e-15), W, 0.0)
    assert value(motion, 20.0) == (W * (20.0 - T / 2.0), W, 0.0)
    assert value(motion, 0.0) == (0.0, 0.0, 0.0)
    assert np.abs(value(motion, T - 1e-6)[2]) < 1e-12
    # no cancellation at the start: the angle grows as (w/T^3) (2 pi)^2 t^4/24
    assert value(motion, 1e-5)[0] == pytest.approx(W / T**3 * (2.0 * math.pi) ** 2 * 1e-20 / 24.0, rel=1e-3)


def test_load_beyond_the_end_of_its_table_is_told():
    """A measured force of 0.4 s in a run of 1 s: 4 N grow to 10 N at the last slope."""
    body = fm.RigidBody("body", at=(0.0, 0.0), mass=1.0, inertia=1.0)

    def told(t_end, times=(0.0, 0.1, 0.2, 0.3, 0.4), values=(0.0, 1.0, 2.0, 3.0, 4.0), **how):
        force = fm.Force("F", body, (0.0, 0.0), (1.0, 0.0), history=fm.drives.Table(times, values, **how))
        findings = fm.simulate(fm.Mechanism("pushed", [body, force]), t_end=t_end).findings
        return {finding.parts: finding.numbers["value"] for finding in findings if finding.code == "short-table"}

    assert told(1.0) == {("F",): pytest.approx(10.0)}
    assert not told(0.4)  # it does not end before the run
    assert not told(0.42)  # 5 % of its range
    assert not told(1.0, slopes=(10.0, 0.0))
    assert not told(1.0, values=(0.0, 1.0, 2.0, 1.0, 0.0), periodic=True)


def test_every_part_with_a_table_is_watched():
    """0 to 0.3 in 0.3 s goes on to 0.5 in 0.5 s: free lengths, angles, drives, targets, voltages and inputs of laws."""
    table = fm.drives.Table((0.0, 0.1, 0.2, 0.3), (0.0, 0.1, 0.2, 0.3))
    body = fm.RigidBody("body", at=(0.0, 0.0), mass=1.0, inertia=1.0)
    rotor = fm.RigidBody("rotor", at=(0.0, 0.0), mass=1.0, inertia=1.0)
    cart = fm.RigidBody("cart", at=(0.0, 0.0), mass=1.0, inertia=1.0)

    @fm.control_kernel
    def law(p, t, u, x, dx, y):
        y[0] = u[1]

    parts = [
        body, rotor, cart,
        fm.SpringDamper("spring", fm.GROUND, body, (0.0, 0.0), (1.0, 0.0), stiffness=1.0, free_length=table),
        fm.Revolute("axis", fm.GROUND, rotor, at=(0.0, 0.0)),
        fm.TorsionSpring("coil", fm.GROUND, rotor, stiffness=1.0, free_angle=table),
        fm.Torque("one", rotor, 1.0), fm.Torque("two", rotor, 1.0), fm.Torque("three", rotor, 1.0),
        fm.controllers.PID("pid", "rotor.theta", "one", kp=1.0, target=table),
        fm.controllers.DCMotor(
            "motor", "rotor.omega", "two", resistance=1.0, torque_constant=0.1, voltage=table
        ),
        fm.Control("own", ["rotor.omega", table], ["three"], law),
        fm.Prismatic("rail", fm.GROUND, cart), fm.Drive("push", "rail", table),
    ]  # fmt: skip
    findings = fm.simulate(fm.Mechanism("tables", parts), t_end=0.5).findings
    told = {f.parts[0]: f.numbers["value"] for f in findings if f.code == "short-table"}
    assert told == dict.fromkeys(("spring", "coil", "pid", "motor", "own", "push"), pytest.approx(0.5))


def test_harmonic_swings_between_its_ends_at_its_frequency():
    motion = fm.drives.Harmonic(0.3, frequency=4.0, phase=math.pi / 2, mean=0.1)
    assert value(motion, 0.0)[0] == pytest.approx(0.4, rel=1e-15)
    assert value(motion, 0.125)[0] == pytest.approx(-0.2, rel=1e-14)
    assert value(motion, 0.0625)[1] == pytest.approx(-0.3 * 8.0 * math.pi, rel=1e-14)
    assert motion.period == 0.25


def test_histories_have_the_values_of_just_after_a_jump():
    pulse = fm.drives.Pulse(2.0, start=1.0, end=3.0)
    assert [value(pulse, t)[0] for t in (0.0, np.nextafter(1.0, 0), 1.0, np.nextafter(3.0, 0), 3.0, 9.0)] == [
        0.0, 0.0, 2.0, 2.0, 0.0, 0.0,
    ]  # fmt: skip
    assert value(fm.drives.Pulse(2.0), 1e9)[0] == 2.0
    lines = fm.drives.PiecewiseLinear((1.0, 2.0, 4.0), (1.0, 3.0, -1.0))
    assert [value(lines, t)[0] for t in (0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 9.0)] == [1.0, 1.0, 2.0, 3.0, 1.0, -1.0, -1.0]
    assert [value(lines, t)[1] for t in (0.0, 1.0, 2.0, 4.0)] == [0.0, 2.0, -2.0, 0.0]


def test_breaks_lie_after_the_start_and_up_to_the_end():
    assert fm.drives.Pulse(1.0, end=2.0).breaks(2.0) == (2.0,)
    assert fm.drives.Pulse(1.0, end=2.0).breaks(1.9) == ()
    assert fm.drives.Pulse(1.0, start=-1.0).breaks(9.0) == ()
    assert fm.drives.PiecewiseLinear((0.0, 1.0, 2.0), (0.0, 1.0, 0.0)).breaks(1.5) == (1.0,)
    table = (0.5, 1.0, 1.5, 2.0), (0.0, 1.0, 0.0, 0.0)
    assert fm.drives.Table(*table).breaks(9.0) == (0.5, pytest.approx(2.0, rel=1e-15))
    assert fm.drives.Table(*table).breaks(2.0) == (0.5,)  # it holds at its last instant
    assert value(fm.drives.Table(*table), 2.0)[2] != 0.0
    assert value(fm.drives.Table(*table), fm.drives.Table(*table).breaks(9.0)[1])[2] == 0.0
    assert fm.drives.Table(*table, periodic=True).breaks(9.0) == ()
    assert fm.drives.Ramp(1.0, 1.0).breaks(9.0) == fm.drives.CycloidalRamp(1.0, 1.0).breaks(9.0) == ()


def wheel(*parts, inertia=0.5):
    body = fm.RigidBody("wheel", (0.0, 0.0), 1.0, inertia)
    return fm.Mechanism("wheel", [body, fm.Revolute("O", fm.GROUND, body, at=(0.0, 0.0)), *(p(body) for p in parts)])


@pytest.mark.parametrize(
    "history",
    [fm.drives.Harmonic(0.7, 3.0, 0.4, 0.1), fm.drives.Polynomial((0.0, 1.0, -2.0)), fm.drives.CycloidalRamp(2.0, 0.6)],
)
def test_a_torque_is_multiplied_by_its_history(history):
    """omega(1 s) = M/J times the integral of the history; its work is what the wheel has."""
    sol = fm.simulate(wheel(lambda b: fm.Torque("M", b, 5.0, history=history)), t_end=1.0, step=1e-3, save="steps")
    speed = 5.0 / 0.5 * quad(lambda t: value(history, t)[0], 0.0, 1.0)[0]
    assert sol.array("wheel.omega")[-1] == pytest.approx(speed, rel=2e-5)
    assert sol.array("energy.load_work")[-1] == pytest.approx(0.25 * speed**2, rel=1e-4)


def test_a_follower_thrust_beside_the_axis_turns_a_wheel_for_ever():
    """A jet at the rim, at 0.2 m, keeps its moment: theta = F R t^2/(2 J); a dead force would swing the wheel."""

    def turned(follower):
        mechanism = wheel(lambda b: fm.Force("jet", b, at=(0.2, 0.0), force=(0.0, 4.0), follower=follower))
        return fm.simulate(mechanism, t_end=5.0, step=1e-3).array("wheel.theta")

    assert turned(True)[-1] == pytest.approx(4.0 * 0.2 * 25.0 / (2.0 * 0.5), rel=1e-9)
    assert turned(False).max() < math.pi + 1e-6


def test_a_follower_force_on_a_body_drawn_at_an_angle_is_given_as_drawn():
    body = fm.RigidBody("body", (0.0, 0.0), 2.0, 0.1, theta=0.7)
    thrust = fm.Force("thrust", body, at=(0.3, 0.1), force=(4.0, -1.0), follower=True)
    sol = fm.simulate(fm.Mechanism("free", [body, thrust], gravity=(0.0, 0.0)), t_end=1e-4, step=1e-4, save="steps")
    assert (sol.array("body.ax")[0], sol.array("body.ay")[0]) == pytest.approx((2.0, -0.5), rel=1e-14)
    assert sol.array("body.alpha")[0] == pytest.approx((0.3 * -1.0 - 0.1 * 4.0) / 0.1, rel=1e-14)


# Beams

LENGTH = 1.0
BAR = fm.Rectangle(width=0.01, height=0.002)
EI = 2e11 * 0.01 * 0.002**3 / 12.0
STEEL = fm.Material(young=2e11, density=8000.0)


def beam_with(load, elements=8, *more):
    beam = fm.FlexibleLink("beam", (0.0, 0.0), (LENGTH, 0.0), section=BAR, material=STEEL, elements=elements)
    return fm.Mechanism("beam", [beam, load(beam), *(m(beam) for m in more)], gravity=(0.0, 0.0))


def clamp(beam):
    return fm.Fixed("clamp", fm.GROUND, beam, at=(0.0, 0.0))


def test_statics_takes_the_history_at_the_start():
    """Half of the moment at t = 0: the tip of a cantilever turns by M L/(2 EI)."""
    moment = 0.2 * EI / LENGTH
    history = fm.drives.PiecewiseLinear((0.0, 1.0), (0.5, 1.0))
    found = fm.static_equilibrium(
        beam_with(lambda b: fm.Torque("M", b, moment, (LENGTH, 0.0), history=history), 8, clamp)
    )
    assert found["beam.end.theta"] == pytest.approx(0.1, rel=1e-9)


def test_end_moments_on_a_free_beam_are_in_balance():
    """Opposite moments on both ends, switched off again: the middle of mass stays, momentum and spin stay zero."""
    history = fm.drives.Pulse(start=0.01, end=0.05)
    mechanism = beam_with(
        lambda b: fm.Torque("M1", b, 0.2 * EI, (LENGTH, 0.0), history=history),
        8,
        lambda b: fm.Torque("M2", b, -0.2 * EI, (0.0, 0.0), history=history),
    )
    sol = fm.simulate(mechanism, t_end=0.08, step=1e-4)
    assert sol.ok, sol.status
    assert np.ptp(sol.array("beam.deflection")) > 1e-2
    mirror = sol.array("beam.start.x") + sol.array("beam.end.x")
    np.testing.assert_allclose(mirror, LENGTH, atol=1e-9)
    np.testing.assert_allclose(sol.array("beam.start.y"), sol.array("beam.end.y"), atol=1e-9)
    after = sol.time > 0.0501
    stored = sum(sol.array(f"energy.{name}") for name in ("kinetic", "strain", "dissipated_algorithm"))
    assert np.ptp(stored[after]) < 1e-2 * stored[after].mean()


def test_modes_of_a_follower_force_are_refused():
    mechanism = beam_with(lambda b: fm.Force("thrust", b, (LENGTH, 0.0), (-EI, 0.0), follower=True), 8, clamp)
    with pytest.raises(
        fm.errors.SolveError, match=r"stiffness of mechanism 'beam' is not symmetric .* follower force does this"
    ):
        fm.modes(mechanism, at=fm.static_equilibrium(mechanism))
    dead = beam_with(lambda b: fm.Force("thrust", b, (LENGTH, 0.0), (-EI, 0.0)), 8, clamp)
    assert fm.modes(dead, count=1, at=fm.static_equilibrium(dead)).frequencies[0] > 0.0
