"""Markers report the motion of their point; rods keep their length."""

import copy
import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError

O, A = (0.0, 0.0), (0.3, 0.4)


def arm(**changes):
    """A bar at rest 53 degrees above the horizontal."""
    return fm.RigidLink("arm", O, A, mass=1.0, inertia=0.02, **changes)


def turning(body, *more):
    """A bar that turns with the angle 0.3 + 2 t + t^2 about its first end."""
    motion = fm.drives.Polynomial((0.0, 2.0, 1.0))
    return fm.Mechanism("turning", [
        body, fm.Revolute("O", fm.GROUND, body, at=O), fm.Drive("motor", "O", motion), *more,
    ])  # fmt: skip


def test_signals_of_a_point_that_turns_on_a_circle():
    marker = fm.Marker("P", arm(), at=A)
    sol = fm.simulate(turning(arm(), marker), t_end=1.0, save=50)
    t = sol.time
    angle, w, r = math.atan2(0.4, 0.3) + 2.0 * t + t**2, 2.0 + 2.0 * t, 0.5
    c, s = np.cos(angle), np.sin(angle)
    expected = {
        "x": r * c, "y": r * s, "vx": -r * w * s, "vy": r * w * c,
        "ax": -r * 2.0 * s - r * w**2 * c, "ay": r * 2.0 * c - r * w**2 * s, "theta": angle, "omega": w,
    }  # fmt: skip
    for name, value in expected.items():
        assert sol[f"P.{name}"].values == pytest.approx(value, abs=2e-3 if name[0] == "a" else 2e-5), name


def test_a_marker_off_the_node_of_a_body_agrees_with_differences():
    """A free body that spins and flies: differences of the position are the velocity."""
    body = fm.RigidBody("stone", (0.2, 0.1), 1.0, 0.1, velocity=(1.0, 2.0, 3.0))
    mech = fm.Mechanism("stone", [body, fm.Marker("P", body, at=(0.5, 0.3))], gravity=(0.0, -9.81))
    fm.testing.check_part(mech, "P")
    sol = fm.simulate(mech, t_end=1.0, save=1000)
    for place, rate in (("x", "vx"), ("y", "vy"), ("vx", "ax"), ("vy", "ay")):
        value, t = sol[f"P.{place}"].values, sol.time
        assert np.gradient(value, t)[2:-2] == pytest.approx(sol[f"P.{rate}"].values[2:-2], abs=2e-3)


def test_a_marker_of_a_flexible_body_is_its_node():
    bar = fm.FlexibleLink("bar", O, (1.0, 0.0), section=fm.Rectangle(0.02, 0.01), material=fm.STEEL, elements=4)
    load = fm.Force("load", bar, at=(1.0, 0.0), force=(0.0, -1.0))
    mech = fm.Mechanism(
        "bar", [bar, fm.Fixed("wall", fm.GROUND, bar, at=O), load, fm.Marker("tip", bar, at=(1.0, 0.0))]
    )
    sol = fm.simulate(mech, t_end=0.01, save="steps")
    assert sol["tip.y"].values == pytest.approx(sol["bar.node4.y"].values, abs=1e-12)
    with pytest.raises(InputError, match="node"):
        fm.simulate(fm.Mechanism("bar", [*mech.parts, fm.Marker("half", bar, at=(0.3, 0.2))]), t_end=0.01)


def test_a_marker_stands_for_its_point():
    body = arm()
    tip = fm.Marker("tip", body, at=A)
    spring = fm.SpringDamper("spring", fm.GROUND, body, at=(1.0, 0.0), to=tip, stiffness=10.0)
    force = fm.Force("load", body, at=tip, force=(1.0, 0.0))
    assert spring.to == A
    assert force.at == A


def test_a_rod_holds_a_pendulum():
    """A point on a massless rod is the mathematical pendulum: period 2 pi sqrt(l/g) (1 + a^2/16 + 11 a^4/3072)."""
    length, amplitude = 1.0, 0.2
    place = (length * math.sin(amplitude), -length * math.cos(amplitude))
    bob = fm.RigidBody("bob", place, 1.0, 1e-3)
    rod = fm.couplings.Distance("rod", fm.GROUND, bob, at=O, to=place)
    mech = fm.Mechanism("pendulum", [bob, rod], gravity=(0.0, -9.81))
    period = 2.0 * math.pi * math.sqrt(length / 9.81) * (1.0 + amplitude**2 / 16.0 + 11.0 * amplitude**4 / 3072.0)
    sol = fm.simulate(mech, t_end=period, step=fm.Adaptive(rtol=1e-7), save=400)
    assert sol.ok, sol.status
    assert sol["bob.x"].values[-1] == pytest.approx(place[0], abs=1e-6)
    tension = 9.81 * (3.0 * np.cos(np.arctan2(sol["bob.x"].values, -sol["bob.y"].values)) - 2.0 * math.cos(amplitude))
    assert sol["rod.force"].values[1:] == pytest.approx(tension[1:], rel=1e-4)
    assert np.hypot(sol["bob.x"].values, sol["bob.y"].values) == pytest.approx(length, abs=1e-10)


def test_contracts_of_a_rod_between_two_bodies():
    one, other = fm.RigidBody("one", O, 1.0, 0.1), fm.RigidBody("other", (0.5, 0.2), 1.0, 0.1, theta=0.3)
    mech = fm.Mechanism("pair", [one, other, fm.couplings.Distance("rod", one, other, at=(0.1, 0.05), to=(0.4, 0.3))])
    fm.testing.check_part(mech, "rod")
    with pytest.raises(InputError, match="a rod needs a length"):
        fm.couplings.Distance("rod", one, other, at=O, to=O)


def test_a_trace_is_drawn(tmp_path):
    mech = turning(arm(), fm.Marker("P", arm(), at=A, trace=True))
    sol = fm.simulate(mech, t_end=1.0, save=100)
    figure = fm.render(sol, path=tmp_path / "trace.png", times=[0.0, 1.0])
    paths = [line for line in figure.axes[0].lines if line.get_gid() == "trace P"]
    points = np.concatenate([path.get_xydata() for path in paths])  # of all poses, and up to this one
    assert len(points) > 10
    assert np.hypot(*points.T) == pytest.approx(0.5, abs=1e-6)


def test_points_follow_their_marker():
    """A force of 2 N at 0.2 m and then 0.4 m from the hinge, on an inertia of 0.5 kg m^2: alpha = 2 r / 0.5."""
    arm = fm.RigidBody("arm", (0.0, 0.0), mass=1.0, inertia=0.5)
    place = fm.Marker("P", arm, at=(0.2, 0.0))
    parts = [arm, fm.Revolute("hinge", fm.GROUND, arm, at=(0.0, 0.0)), place]
    mechanism = fm.Mechanism("arm", [*parts, fm.Force("load", arm, at=place, force=(0.0, 2.0))])

    def start(changed):
        return float(fm.simulate(changed, t_end=1e-6)["arm.alpha"][0])

    assert start(mechanism) == pytest.approx(0.8)
    moved = mechanism.with_({"P.at": (0.4, 0.0)})
    assert start(moved) == pytest.approx(1.6)  # the force stayed: 0.8
    assert start(moved.with_({"P.at": (0.1, 0.0)})) == pytest.approx(0.4)
    assert start(mechanism.with_part(fm.Marker("P", arm, at=(0.3, 0.0)))) == pytest.approx(1.2)
    assert start(mechanism.with_({"P.at": (0.4, 0.0), "load.at": (0.3, 0.0)})) == pytest.approx(1.2)
    assert start(mechanism.with_({"load.force": (0.0, 4.0)}).with_({"P.at": (0.4, 0.0)})) == pytest.approx(3.2)
    assert start(copy.deepcopy(mechanism).with_({"P.at": (0.4, 0.0)})) == pytest.approx(1.6)
    found = fm.sweep(lambda x: start(mechanism.with_({"P.at": (x, 0.0)})), {"x": [0.1, 0.3]})
    assert found["value"].values == pytest.approx([0.4, 1.2])
