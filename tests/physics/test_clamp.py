"""A clamp that moves: exact forces of a moved rigid body, the work it does, clamps on moving bodies."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError

MASS, INERTIA, ARM, GRAVITY = 2.0, 0.3, (0.4, 0.1), (0.7, -9.81)
TURN = fm.drives.Polynomial((0.0, 1.5, -0.8, 0.3))
ALONG = fm.drives.Polynomial((0.0, 0.2, 0.9))
ACROSS = fm.drives.Polynomial((0.0, -0.1, 0.0, 0.6))
T_END = 1.0


def body():
    """A body whose centre of mass lies at ARM from the clamp at the origin."""
    return fm.RigidBody("body", ARM, MASS, INERTIA)


def on_ground(**motions):
    return fm.Mechanism("clamped", [body(), fm.Clamp("clamp", fm.GROUND, body(), at=(0.0, 0.0), **motions)], GRAVITY)


def moved(t):
    """Newton and Euler for the centre of mass c = p(t) + R(angle) ARM: force and moment about the clamp's point."""
    angle, w, dw = 1.5 * t - 0.8 * t**2 + 0.3 * t**3, 1.5 - 1.6 * t + 0.9 * t**2, -1.6 + 1.8 * t
    px, py, ax, ay = 0.2 * t + 0.9 * t**2, -0.1 * t + 0.6 * t**3, 1.8 + 0.0 * t, 3.6 * t
    c, s = np.cos(angle), np.sin(angle)
    rx, ry = c * ARM[0] - s * ARM[1], s * ARM[0] + c * ARM[1]
    cx, cy = ax - dw * ry - w * w * rx, ay + dw * rx - w * w * ry
    fx, fy = MASS * (cx - GRAVITY[0]), MASS * (cy - GRAVITY[1])
    moment = INERTIA * dw + rx * fy - ry * fx
    return {"x": px, "y": py, "angle": angle, "fx": fx, "fy": fy, "moment": moment, "w": w, "px": px + rx}


def test_forces_of_a_body_moved_by_three_motions_are_those_of_newton_and_euler():
    times = np.linspace(0.0, T_END, 21)
    exact = moved(times)
    found = fm.inverse_dynamics(on_ground(angle=TURN, x=ALONG, y=ACROSS), times)
    forces = np.stack([exact["fx"], exact["fy"], exact["moment"]], axis=1)
    np.testing.assert_allclose(found.forces["clamp"], forces, rtol=0, atol=1e-10)
    np.testing.assert_allclose(found.position("body.x"), exact["px"], rtol=0, atol=1e-12)


def test_signals_of_a_run_are_the_motions_and_their_forces():
    """Positions are exact; forces hold the accelerations of the time integration, whose error falls with h^2."""
    errors = []
    for step in (1e-2, 5e-3):
        sol = fm.simulate(on_ground(angle=TURN, x=ALONG, y=ACROSS), t_end=T_END, step=step, save="steps")
        assert sol.ok, sol.status
        exact = moved(sol.time)
        for name in ("x", "y", "angle"):
            np.testing.assert_allclose(sol.array(f"clamp.{name}"), exact[name], rtol=0, atol=1e-12, err_msg=name)
        np.testing.assert_allclose(sol.array("clamp.angle_rate"), exact["w"], rtol=0, atol=1e-12)
        np.testing.assert_allclose(sol.array("body.x"), exact["px"], rtol=0, atol=1e-11)
        for one, two in (("x_force", "fx"), ("y_force", "fy"), ("angle_torque", "moment")):
            np.testing.assert_allclose(sol.array(f"clamp.{one}"), sol.array(f"clamp.{two}"), rtol=0, atol=1e-12)
        np.testing.assert_allclose(sol.array("clamp.angle_power"), sol.array("clamp.moment") * exact["w"], atol=1e-10)
        np.testing.assert_allclose(sol.array("clamp.force"), np.hypot(sol.array("clamp.fx"), sol.array("clamp.fy")))
        errors.append([np.abs(sol.array(f"clamp.{n}") - exact[n]).max() for n in ("fx", "fy", "moment")])
    assert np.max(errors[0]) < 5e-3  # of 20 N
    assert np.log2(np.array(errors[0]) / errors[1]).min() > 1.8
    assert (sol.units("clamp.x_power"), sol.units("clamp.angle_rate"), sol.units("clamp.y_force")) == (
        "W",
        "rad/s",
        "N",
    )


def test_the_work_of_all_three_motions_is_what_the_body_gains():
    """Energies at both ends are exact; the works come by the trapezoidal rule, so to second order."""
    rest = []
    for step in (2e-2, 1e-2):
        sol = fm.simulate(on_ground(angle=TURN, x=ALONG, y=ACROSS), t_end=T_END, step=step, save="steps")
        gained = [sol.array(f"energy.{name}")[-1] - sol.array(f"energy.{name}")[0] for name in ("kinetic", "gravity")]
        rest.append(abs(sol.array("energy.drive_work")[-1] - sum(gained)))
        powers = sum(sol.array(f"clamp.{name}_power") for name in ("x", "y", "angle"))
        assert np.trapezoid(powers, sol.time) == pytest.approx(sum(gained), rel=1e-2)
    assert abs(sum(gained)) > 5.0
    assert rest[1] < 1e-3 * abs(sum(gained))
    assert math.log2(rest[0] / rest[1]) > 1.9


def carried(**motions):
    """A body clamped on the rim of a wheel that turns at 3 rad/s; the wheel stands turned by 0.5 rad when drawn."""
    wheel = fm.RigidBody("wheel", (0.0, 0.0), 5.0, 0.2, theta=0.5)
    rim = (0.3 * math.cos(0.5), 0.3 * math.sin(0.5))
    load = fm.RigidBody("load", rim, MASS, INERTIA)
    parts = [
        wheel,
        load,
        fm.Revolute("O", fm.GROUND, wheel, at=(0.0, 0.0)),
        fm.Drive("motor", "O", fm.ConstantSpeed(3.0)),
    ]
    return fm.Mechanism("carried", [*parts, fm.Clamp("clamp", wheel, load, at=rim, **motions)])


def test_a_body_that_slides_out_on_a_wheel_feels_centripetal_and_coriolis_force():
    """Out along the wheel's x axis, d = 0.3 + u t + b t^2: radial m (2 b - w^2 d), across 2 m w d', on the load."""
    u, b, w, t_end = 0.2, 0.4, 3.0, 0.8
    t = np.linspace(0.0, t_end, 17)
    found = fm.inverse_dynamics(carried(x=fm.drives.Polynomial((0.0, u, b))), t).forces
    d, rate, turned = 0.3 + u * t + b * t * t, u + 2.0 * b * t, 0.5 + w * t
    radial, across = MASS * (2.0 * b - w * w * d), MASS * 2.0 * w * rate
    np.testing.assert_allclose(found["clamp"][:, 0], radial * np.cos(turned) - across * np.sin(turned), atol=1e-10)
    np.testing.assert_allclose(found["clamp"][:, 1], radial * np.sin(turned) + across * np.cos(turned), atol=1e-10)
    np.testing.assert_allclose(found["clamp"][:, 2], 0.0, atol=1e-10)
    # both ends of the clamp: the motor carries the Coriolis force at the arm d
    np.testing.assert_allclose(found["motor"][:, 2], across * d, atol=1e-10)


def test_forces_along_the_axes_of_a_turned_first_body():
    """The same motion in a run: x_force is radial in the frame of the wheel, to the order of the time integration."""
    u, b, w = 0.2, 0.4, 3.0
    sol = fm.simulate(carried(x=fm.drives.Polynomial((0.0, u, b))), t_end=0.8, step=2e-3, save="steps")
    d = 0.3 + u * sol.time + b * sol.time**2
    radial, turned = MASS * (2.0 * b - w * w * d), 0.5 + w * sol.time
    np.testing.assert_allclose(sol.array("clamp.x_force"), radial, rtol=0, atol=1e-3)
    along = sol.array("clamp.fx") * np.cos(turned) + sol.array("clamp.fy") * np.sin(turned)
    np.testing.assert_allclose(sol.array("clamp.x_force"), along, rtol=0, atol=1e-10)
    assert np.abs(radial).max() > 10.0


def test_a_clamp_without_speed_is_a_weld():
    still = fm.drives.Polynomial((0.0,))
    welded = carried(x=still).without_part("clamp")
    welded = welded.with_part(
        fm.Fixed("clamp", welded.find("wheel"), welded.find("load"), at=(0.3 * math.cos(0.5), 0.3 * math.sin(0.5)))
    )
    one, two = (fm.simulate(m, t_end=0.2, step=1e-3, save="steps") for m in (carried(x=still), welded))
    for name in ("clamp.fx", "clamp.fy", "clamp.moment", "load.x", "load.theta"):
        np.testing.assert_allclose(one.array(name), two.array(name), atol=1e-9, err_msg=name)
    assert one.array("clamp.force").max() > 5.0  # m w^2 d = 5.4 N


def test_assembly_moves_a_driven_coordinate_by_its_name():
    pose = fm.assemble(
        carried(x=fm.drives.Polynomial((0.0,)), angle=fm.drives.Polynomial((0.0,))),
        {"clamp.x": 0.2, "clamp.angle": 0.7},
    )
    assert pose["load.x"] == pytest.approx(0.5 * math.cos(0.5), abs=1e-12)
    assert pose["load.y"] == pytest.approx(0.5 * math.sin(0.5), abs=1e-12)
    assert pose["load.theta"] == pytest.approx(0.7, abs=1e-12)


def test_statics_of_a_clamp_gives_its_reaction():
    """At rest, moved 0.2 m sideways: weight and its moment about the clamp's point."""
    fx, fy, moment = fm.static_equilibrium(on_ground(x=fm.drives.Polynomial((0.2,)))).force("clamp")
    expected = (-MASS * GRAVITY[0], -MASS * GRAVITY[1], -MASS * (ARM[0] * GRAVITY[1] - ARM[1] * GRAVITY[0]))
    np.testing.assert_allclose((fx, fy, moment), expected, rtol=1e-10)


def test_a_run_goes_on_bit_for_bit():
    """Steps that are a power of two end exactly at the end of the half."""
    mech, step = on_ground(angle=TURN, y=ACROSS), 2.0**-7
    whole = fm.simulate(mech, t_end=0.5, step=step)
    half = fm.simulate(mech, t_end=0.25, step=step)
    rest = fm.simulate(mech, t_end=0.5, step=step, restart=half.restart)
    np.testing.assert_array_equal(rest.restart["q"], whole.restart["q"])
    np.testing.assert_array_equal(rest.restart["ledger"], whole.restart["ledger"])


class Jump(fm.ConstantSpeed):
    """A motion that says of itself that it jumps."""

    is_smooth = False


@pytest.mark.parametrize(
    ("motions", "message"),
    [
        ({"x": Jump(1.0)}, r"x is Jump\(...\), whose value or speed jumps"),
        ({}, "Fixed"),
        ({"angle": 1.0}, "angle is 1.0; it must be a motion"),
        ({"x": TURN, "y": "up"}, "y is 'up'"),
    ],
)
def test_what_is_no_motion_is_refused(motions, message):
    with pytest.raises(InputError, match=message) as caught:
        on_ground(**motions)
    assert str(caught.value).startswith("Clamp 'clamp'")
