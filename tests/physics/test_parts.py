"""Rigid bodies, springs, loads, joints and drives against exact motions."""

import math

import numpy as np
import pytest
from scipy.special import ellipk

import flexmb as fm

G = 9.81
STEP = 1e-3
RULES = {"alpha": fm.Newmark.generalised_alpha(0.8), "trapezoidal": fm.Newmark.trapezoidal(), "rk4": fm.RungeKutta4()}
rules = pytest.mark.parametrize("method", RULES.values(), ids=RULES)


def limit(method, t_end, rate=1.0):
    """Error that the method may make of a motion of size 1 and frequency `rate` [rad/s]: c (rate h)^k rate t."""
    order, constant = (4, 0.02) if isinstance(method, fm.RungeKutta4) else (2, 0.2)
    return constant * (rate * STEP) ** order * rate * t_end + 1e-11


@rules
def test_free_fall_is_exact(method):
    """A parabola, and an even spin: every method integrates them without error."""
    body = fm.RigidBody("stone", (1.0, 2.0), mass=3.0, inertia=0.2, velocity=(4.0, 5.0, -6.0))
    sol = fm.simulate(fm.Mechanism("fall", (body,), gravity=(0.5, -G)), t_end=2.0, step=STEP, method=method)
    t = sol.time
    np.testing.assert_allclose(sol.array("stone.x"), 1.0 + 4.0 * t + 0.25 * t**2, atol=1e-10)
    np.testing.assert_allclose(sol.array("stone.y"), 2.0 + 5.0 * t - 0.5 * G * t**2, atol=1e-10)
    np.testing.assert_allclose(sol.array("stone.theta"), -6.0 * t, atol=1e-10)
    assert np.abs(sol.array("energy.residual")).max() < 1e-9 * sol.array("energy.kinetic").max()


def simple_pendulum():
    """IFToMM library of benchmark problems, A01: 1 kg on a massless arm of 1 m, from (-1, 0) at rest."""
    bob = fm.RigidBody("bob", (-1.0, 0.0), mass=1.0, inertia=1e-12)
    return fm.Mechanism("A01", (bob, fm.Revolute("O", fm.GROUND, bob, (0.0, 0.0))), gravity=(0.0, -G))


def test_simple_pendulum_of_the_iftomm_library():
    """Exact positions at 5 s and 10 s (elliptic functions); energy within the library's criterion, 5e-5 J."""
    sol = fm.simulate(simple_pendulum(), t_end=10.0, step=STEP / 2, save=2, method=fm.RungeKutta4())
    exact = [(-0.942305435043757, -0.334754338414001), (-0.275087462576117, -0.961419205099125)]
    np.testing.assert_allclose(np.column_stack([sol.array("bob.x"), sol.array("bob.y")])[1:], exact, atol=1e-8)
    assert np.abs(sol.array("energy.kinetic") + sol.array("energy.gravity")).max() < 5e-5


@rules
def test_period_of_a_pendulum(method):
    """T = 4 sqrt(L/g) K(m), m = sin^2(45 deg), = 2.36784194757624 s: the bob is back after two half swings."""
    period = 4 * math.sqrt(1 / G) * ellipk(0.5)
    assert period == pytest.approx(2.36784194757624, rel=1e-14)
    sol = fm.simulate(simple_pendulum(), t_end=1.2 * period, step=STEP, save="steps", method=method)
    speed, t = sol.array("bob.omega"), sol.time
    i = int(np.flatnonzero((speed[:-1] < 0.0) & (speed[1:] >= 0.0))[-1])
    back = t[i] - speed[i] * (t[i + 1] - t[i]) / (speed[i + 1] - speed[i])
    assert back == pytest.approx(period, rel=1e-9 if isinstance(method, fm.RungeKutta4) else 3e-6)


@rules
@pytest.mark.parametrize("damping", [0.0, 6.0])
def test_spring_and_damper(method, damping):
    """x = A e^(-d t/2m) cos(w t - phi): a slider between ground and spring, released 0.1 m beyond the free length."""
    mass, k, free = 2.0, 800.0, 0.5
    body = fm.RigidBody("slider", (0.6, 0.0), mass, 1.0)
    spring = fm.SpringDamper(
        "S", fm.GROUND, body, (0.0, 0.0), (0.6, 0.0), stiffness=k, damping=damping, free_length=free
    )
    mechanism = fm.Mechanism("oscillator", (body, spring, fm.Prismatic("guide", fm.GROUND, body)))
    sol = fm.simulate(mechanism, t_end=1.0, step=STEP, save="steps", method=method)
    decay = damping / (2 * mass)
    w = math.sqrt(k / mass - decay**2)
    exact = 0.1 * np.exp(-decay * sol.time) * (np.cos(w * sol.time) + decay / w * np.sin(w * sol.time))
    np.testing.assert_allclose(sol.array("slider.x") - free, exact, atol=0.1 * limit(method, 1.0, 20.0))
    lost = sol.array("energy.dissipated_damping")[-1]
    left = sol.array("energy.kinetic")[-1] + sol.array("energy.strain")[-1]
    assert lost + left == pytest.approx(0.5 * k * 0.1**2, rel=1e-3)
    assert (lost > 1.0) == (damping > 0.0)


@rules
@pytest.mark.parametrize("damping", [0.0, 0.03])
def test_torsion_spring(method, damping):
    """theta = angle + (theta0 - angle) e^(-d t/2J) cos(...), about a rest angle of 0.3 rad from the drawn pose."""
    inertia, k, rest = 0.01, 4.0, 0.3
    wheel = fm.RigidBody("wheel", (0.2, 0.1), 1.0, inertia, theta=1.1)
    spring = fm.TorsionSpring("S", fm.GROUND, wheel, stiffness=k, damping=damping, free_angle=rest)
    mechanism = fm.Mechanism("balance", (wheel, spring, fm.Revolute("O", fm.GROUND, wheel, (0.2, 0.1))))
    sol = fm.simulate(mechanism, t_end=1.0, step=STEP, save="steps", method=method)
    decay = damping / (2 * inertia)
    w = math.sqrt(k / inertia - decay**2)
    exact = -rest * np.exp(-decay * sol.time) * (np.cos(w * sol.time) + decay / w * np.sin(w * sol.time))
    np.testing.assert_allclose(sol.array("wheel.theta") - 1.1 - rest, exact, atol=rest * limit(method, 1.0, 20.0))


def test_springs_between_two_moving_bodies():
    """Two masses on a line, no ground: the reduced mass swings at sqrt(k/mu), the centre of mass moves evenly."""
    one = fm.RigidBody("one", (0.0, 0.0), 2.0, 1.0, velocity=(1.0, 0.0, 0.0))
    two = fm.RigidBody("two", (1.0, 0.0), 3.0, 1.0, velocity=(1.0, 0.0, 0.0))
    spring = fm.SpringDamper("S", one, two, (0.0, 0.0), (1.0, 0.0), stiffness=500.0, free_length=0.9)
    sol = fm.simulate(fm.Mechanism("pair", (one, two, spring)), t_end=1.0, step=STEP, save="steps", method=RULES["rk4"])
    w = math.sqrt(500.0 / (2.0 * 3.0 / 5.0))
    stretch = sol.array("two.x") - sol.array("one.x") - 0.9
    np.testing.assert_allclose(stretch, 0.1 * np.cos(w * sol.time), atol=0.1 * limit(RULES["rk4"], 1.0, w))
    centre = (2.0 * sol.array("one.x") + 3.0 * sol.array("two.x")) / 5.0
    np.testing.assert_allclose(centre, 0.6 + sol.time, atol=1e-12)


@rules
def test_a_force_and_its_work(method):
    """A dead force on a point off the centre: the centre moves as a particle; kinetic energy = F . way of the point."""
    body = fm.RigidBody("plate", (0.0, 0.0), 2.0, 0.05)
    force = fm.Force("F", body, (0.1, 0.05), (3.0, -1.0))
    sol = fm.simulate(fm.Mechanism("pushed", (body, force)), t_end=1.0, step=STEP, save="steps", method=method)
    t, x, y, theta = (sol.time, *(sol.array(f"plate.{c}") for c in ("x", "y", "theta")))
    np.testing.assert_allclose(x, 0.75 * t**2, atol=1e-10)
    np.testing.assert_allclose(y, -0.25 * t**2, atol=1e-10)
    px = x + 0.1 * np.cos(theta) - 0.05 * np.sin(theta)
    py = y + 0.1 * np.sin(theta) + 0.05 * np.cos(theta)
    work = 3.0 * (px - 0.1) - (py - 0.05)
    assert np.abs(sol.array("plate.omega")).max() > 1.0
    np.testing.assert_allclose(sol.array("energy.kinetic"), work, atol=limit(method, 1.0, 5.0) * work.max())
    np.testing.assert_allclose(sol.array("energy.load_work"), work, atol=1e-5 * work.max())


@rules
def test_a_torque(method):
    wheel = fm.RigidBody("wheel", (0.3, 0.0), 1.0, 0.04)
    parts = (wheel, fm.Revolute("O", fm.GROUND, wheel, (0.3, 0.0)), fm.Torque("M", wheel, -0.2))
    sol = fm.simulate(fm.Mechanism("spun", parts), t_end=1.0, step=STEP, method=method)
    np.testing.assert_allclose(sol.array("wheel.theta"), -2.5 * sol.time**2, atol=1e-10)
    assert sol.array("energy.load_work")[-1] == pytest.approx(0.5, rel=1e-9)


@rules
def test_welded_bodies_move_as_one(method):
    """Thrown and spinning: even motion of the common centre; the weld holds each body by m w^2 r and no moment."""
    d, w, v = 0.4, 12.0, (2.0, 3.0)
    centre = d * 3.0 / 4.0
    one = fm.RigidBody("one", (0.0, 0.0), 1.0, 0.02, velocity=(v[0], v[1] - w * centre, w))
    two = fm.RigidBody("two", (d, 0.0), 3.0, 0.05, theta=0.7)
    mechanism = fm.Mechanism("welded", (one, two, fm.Fixed("W", one, two, (0.1, 0.0))), gravity=(0.0, -G))
    sol = fm.simulate(mechanism, t_end=1.0, step=STEP, save="steps", method=method)
    t, close = sol.time, limit(method, 1.0, w)
    x = (sol.array("one.x") + 3.0 * sol.array("two.x")) / 4.0
    y = (sol.array("one.y") + 3.0 * sol.array("two.y")) / 4.0
    np.testing.assert_allclose(x, centre + v[0] * t, atol=1e-9)
    np.testing.assert_allclose(y, v[1] * t - 0.5 * G * t**2, atol=1e-9)
    np.testing.assert_allclose(sol.array("one.theta"), w * t, atol=close)
    np.testing.assert_allclose(sol.array("two.theta") - sol.array("one.theta"), 0.7, atol=1e-9)
    np.testing.assert_allclose(sol.array("two.x") - sol.array("one.x"), d * np.cos(w * t), atol=d * close)
    tension = 3.0 * w * w * (d - centre)
    np.testing.assert_allclose(sol.array("W.force"), tension, rtol=10 * close)
    assert sol.array("W.fx")[0] == pytest.approx(-tension, rel=1e-9)
    assert np.abs(sol.array("W.moment")).max() < 10 * close * tension * d


def test_a_weld_carries_weight_and_moment():
    """A bracket welded to the ground: m g and m g times the lever, on the second body."""
    bracket = fm.RigidBody("bracket", (0.3, 0.1), 2.0, 0.1)
    mechanism = fm.Mechanism("bracket", (bracket, fm.Fixed("W", fm.GROUND, bracket, (0.0, 0.0))), gravity=(0.0, -G))
    sol = fm.simulate(mechanism, t_end=0.1, step=STEP)
    np.testing.assert_allclose(sol.array("W.fy"), 2.0 * G, rtol=1e-9)
    np.testing.assert_allclose(sol.array("W.moment"), 2.0 * G * 0.3, rtol=1e-9)


@rules
def test_a_bead_on_a_turning_rod(method):
    """r = r0 cosh(w t); the rod pushes it by 2 m w dr/dt across; the drive gives 2 m w r dr/dt."""
    w, r0, mass, t_end = 5.0, 0.1, 0.3, 0.5
    rod = fm.RigidLink("rod", (0.0, 0.0), (2.0, 0.0), 1.0, 0.3)
    bead = fm.RigidBody("bead", (r0, 0.0), mass, 1e-4)
    parts = (
        rod,
        bead,
        fm.Revolute("O", fm.GROUND, rod, (0.0, 0.0)),
        fm.Prismatic("guide", rod, bead),
        fm.Drive("motor", "O", fm.ConstantSpeed(w)),
    )
    sol = fm.simulate(fm.Mechanism("bead", parts), t_end=t_end, step=STEP, save="steps", method=method)
    t = sol.time
    r, rate = r0 * np.cosh(w * t), r0 * w * np.sinh(w * t)
    close = 10 * limit(method, t_end, w)
    np.testing.assert_allclose(np.hypot(sol.array("bead.x"), sol.array("bead.y")), r, rtol=close)
    np.testing.assert_allclose(sol.array("bead.theta"), w * t, atol=1e-9)
    push = 2 * mass * w * rate
    along = sol.array("guide.fx") * np.cos(w * t) + sol.array("guide.fy") * np.sin(w * t)
    across = sol.array("guide.fy") * np.cos(w * t) - sol.array("guide.fx") * np.sin(w * t)
    np.testing.assert_allclose(across, push, atol=close * push.max())
    np.testing.assert_allclose(along, 0.0, atol=1e-9 * push.max())
    np.testing.assert_allclose(sol.array("motor.torque"), push * r, atol=close * (push * r).max())


# Drives


def driven_wheel(motion):
    wheel = fm.RigidBody("wheel", (0.0, 0.0), 1.0, 0.25, theta=0.4)
    joint = fm.Revolute("O", fm.GROUND, wheel, (0.0, 0.0))
    return fm.Mechanism("wheel", (wheel, joint, fm.Drive("motor", "O", motion)))


CUBIC = np.polynomial.Polynomial([0.0, 2.0, -3.0, 4.0])
QUINTIC = np.polynomial.Polynomial([0.0, 0.0, 0.0, 0.0, 2.5, -3.0, 1.0])  # integral of 10 x^3 - 15 x^4 + 6 x^5


def motions():
    knots = (0.0, 0.2, 0.5, 0.7, 1.0)
    ramp = QUINTIC(np.polynomial.Polynomial([0.0, 1.0 / 0.8])) * 7.0 * 0.8
    return {
        "polynomial": (fm.drives.Polynomial((0.0, 2.0, -3.0, 4.0)), CUBIC, 1.0),
        "table": (
            fm.drives.Table(knots, tuple(float(CUBIC(t)) for t in knots)),
            CUBIC,
            1.0,
        ),  # a spline repeats a cubic
        "ramp": (fm.drives.Ramp(7.0, 0.8), ramp, 0.8),
    }


@pytest.mark.parametrize("name", motions())
def test_the_torque_of_a_drive_is_inertia_times_acceleration(name):
    motion, exact, t_end = motions()[name]
    for method in RULES.values():
        sol = fm.simulate(driven_wheel(motion), t_end=t_end, step=2e-4, save="steps", method=method)
        t = sol.time
        speed, torque = exact.deriv(1)(t), 0.25 * exact.deriv(2)(t)
        np.testing.assert_allclose(sol.array("wheel.theta") - 0.4, exact(t), atol=1e-11)
        np.testing.assert_allclose(sol.array("wheel.omega"), speed, atol=1e-9)
        np.testing.assert_allclose(sol.array("motor.angle"), exact(t), atol=1e-12)
        np.testing.assert_allclose(sol.array("motor.torque"), torque, atol=2e-6 * np.abs(torque).max())
        kinetic = 0.5 * 0.25 * (speed[-1] ** 2 - speed[0] ** 2)
        assert sol.array("energy.drive_work")[-1] == pytest.approx(kinetic, abs=1e-6 * np.abs(kinetic))


def test_a_ramp_ends_in_even_motion():
    """After the start, w (t - T/2); the greatest acceleration is 15/8 w/T, in the middle."""
    sol = fm.simulate(driven_wheel(fm.drives.Ramp(7.0, 0.8)), t_end=2.0, step=STEP, save="steps")
    late = sol.time >= 0.8
    np.testing.assert_allclose(sol.array("wheel.theta")[late] - 0.4, 7.0 * (sol.time[late] - 0.4), atol=1e-9)
    peak = sol.peak("motor.torque")
    assert peak.value == pytest.approx(0.25 * 15 / 8 * 7.0 / 0.8, rel=1e-4)
    assert peak.time == pytest.approx(0.4, abs=2 * STEP)
    assert np.abs(sol.array("motor.torque")[sol.time > 0.81]).max() < 1e-4 * peak.value


def test_a_periodic_table_goes_on_and_on():
    """A table of one turn of an uneven crank, three turns long; it grows by 2 pi a period."""
    t = np.linspace(0.0, 1.0, 41)
    table = fm.drives.Table(tuple(t), tuple(2 * math.pi * t + 0.1 * np.sin(2 * math.pi * t)), periodic=True)
    sol = fm.simulate(driven_wheel(table), t_end=3.0, step=STEP, save="steps")
    expected = 2 * math.pi * sol.time + 0.1 * np.sin(2 * math.pi * sol.time)
    # error of a cubic spline: 5/384 h^4 max|d4 s/dt4|
    np.testing.assert_allclose(
        sol.array("wheel.theta") - 0.4, expected, atol=5 / 384 * 0.025**4 * 0.1 * (2 * math.pi) ** 4 + 1e-11
    )


@rules
def test_a_driven_travel(method):
    """A slider on an incline of 30 degrees, pushed by a drive: m (s'' + g sin) along it, m g cos across."""
    mass, angle = 1.5, math.pi / 6
    slider = fm.RigidBody("slider", (0.2, 0.1), mass, 0.01)
    guide = fm.Prismatic("guide", fm.GROUND, slider, along=(math.cos(angle), math.sin(angle)))
    drive = fm.Drive("push", "guide", fm.drives.Polynomial((0.0, 0.3, 0.8)))
    mechanism = fm.Mechanism("incline", (slider, guide, drive), gravity=(0.0, -G))
    sol = fm.simulate(mechanism, t_end=1.0, step=STEP, save="steps", method=method)
    s = 0.3 * sol.time + 0.8 * sol.time**2
    np.testing.assert_allclose(sol.array("slider.x"), 0.2 + s * math.cos(angle), atol=1e-10)
    np.testing.assert_allclose(sol.array("slider.y"), 0.1 + s * math.sin(angle), atol=1e-10)
    np.testing.assert_allclose(sol.array("push.force"), mass * (1.6 + G * math.sin(angle)), rtol=1e-8)
    np.testing.assert_allclose(sol.array("guide.force"), mass * G * math.cos(angle), rtol=1e-8)
    assert sol.units("push.force") == "N"
