"""Stops of joints against closed forms of bounces and balances of forces."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError, ModelError

O = (0.0, 0.0)
FINE = fm.Adaptive(rtol=1e-6)
SOFT = fm.KelvinVoigt(stiffness=2e4, damping=0.0)
J, SPEED = 0.02, 3.0


def rotor(stop, at=O, omega=SPEED, offset=0.0):
    """A rotor on a pin, thrown against its stop."""
    body = fm.RigidBody("rotor", at=(offset, 0.0), mass=1.5, inertia=J, velocity=(0.0, offset * omega, omega))
    return fm.Mechanism("rotor", [body, fm.Revolute("pin", fm.GROUND, body, at=at), stop])


def test_an_elastic_stop_returns_the_speed():
    """Half a period of a rotor on the spring k r^2: pi sqrt(J/(k r^2)), with the torque omega sqrt(J k r^2)."""
    r, limit = 0.2, 0.4
    sol = fm.simulate(rotor(fm.Stop("end", "pin", above=limit, normal=SOFT, radius=r)), t_end=0.3, step=FINE)
    assert sol.ok, sol.status
    (hit,) = sol.episodes("end")
    kappa = 2e4 * r * r
    assert hit.start == pytest.approx(limit / SPEED, rel=1e-6)
    assert hit.end - hit.start == pytest.approx(math.pi * math.sqrt(J / kappa), rel=2e-4)
    assert sol["rotor.omega"].values[-1] == pytest.approx(-SPEED, rel=1e-4)
    assert sol.peak("end.normal_force").value * r == pytest.approx(SPEED * math.sqrt(J * kappa), rel=1e-3)
    assert sol.peak("end.penetration").value / r == pytest.approx(SPEED * math.sqrt(J / kappa), rel=1e-3)
    assert np.abs(sol["energy.residual"].values).max() < 1e-4 * 0.5 * J * SPEED**2
    assert sol.peak("pin.angle").value == sol.peak("rotor.theta").value


@pytest.mark.parametrize(("side", "along"), [("above", None), ("below", (0.0, 1.0))])
def test_a_stop_loads_the_pin(side, along):
    """A bar at rest on its stop: moments about the pin, then forces on the bar, the stop across its face."""
    m, g, l, r, limit = 2.0, 9.81, 0.6, 0.25, 0.3
    sign = 1.0 if side == "above" else -1.0
    bar = fm.RigidLink("bar", O, (l, 0.0), mass=m, inertia=m * l * l / 12.0)
    law = fm.KelvinVoigt(stiffness=4e5, damping=3e3, ramp=1e-5)
    stop = fm.Stop("end", "pin", normal=law, radius=r, along=along, **{side: sign * limit})
    pin = fm.Revolute("pin", fm.GROUND, bar, at=O)
    mech = fm.Mechanism("bar", [bar, pin, stop], gravity=(0.0, sign * g))
    sol = fm.simulate(mech, t_end=1.5)
    assert sol.ok, sol.status
    angle = float(sol["bar.theta"][-1])
    force = m * g * 0.5 * l * math.cos(angle) / r
    assert sol["end.normal_force"].values[-1] == pytest.approx(force, rel=1e-5)
    assert abs(angle) - limit == pytest.approx(force / 4e5 / r, rel=1e-3)
    face = sign * limit + (0.0 if along is None else math.pi / 2.0)
    push = force * sign * np.array([math.sin(face), -math.cos(face)])
    assert [float(sol[f"end.{name}"][-1]) for name in ("fx", "fy")] == pytest.approx(push, rel=1e-4, abs=1e-3)
    assert float(sol["pin.fx"][-1]) == pytest.approx(-push[0], rel=1e-4, abs=1e-3)
    assert float(sol["pin.fy"][-1]) == pytest.approx(-push[1] - sign * m * g, rel=1e-4, abs=1e-3)


def test_a_slider_between_two_ends():
    """A slider flies from end to end; every end takes half a period pi sqrt(m/k)."""
    m, speed, low, high = 0.5, 2.0, -0.1, 0.2
    slider = fm.RigidBody("slider", at=(0.3, 0.4), mass=m, inertia=1e-3, velocity=(0.6 * speed, 0.8 * speed, 0.0))
    guide = fm.Prismatic("guide", fm.GROUND, slider, along=(3.0, 4.0))
    stop = fm.Stop("end", guide, above=high, below=low, normal=SOFT)
    sol = fm.simulate(fm.Mechanism("slider", [slider, guide, stop]), t_end=0.9, step=FINE)
    assert sol.ok, sol.status
    upper, lower = sol.episodes("end.above"), sol.episodes("end.below")
    way, rest = (high - low) / speed, math.pi * math.sqrt(m / 2e4)
    starts = sorted(hit.start for hit in (*upper, *lower))
    assert starts[0] == pytest.approx(high / speed, rel=1e-6)
    assert np.diff(starts) == pytest.approx(way + rest, rel=1e-4)
    assert (len(upper), len(lower)) == (3, 2)
    assert sol["guide.travel"].values.max() <= high + speed * math.sqrt(m / 2e4) * 1.001


def test_a_stop_between_moving_bodies_keeps_momenta():
    """A lever on a free body hits its stop: momentum, spin and energy stay; both bodies then part."""
    base = fm.RigidBody("base", at=O, mass=3.0, inertia=0.2, velocity=(0.1, 0.0, 0.0))
    lever = fm.RigidLink("lever", (0.3, 0.1), (0.8, 0.1), mass=1.0, inertia=0.03, velocity=None)
    pin = fm.Revolute("pin", base, lever, at=(0.3, 0.1))
    push = fm.Torque("push", lever, 2.0, history=fm.drives.Pulse(end=0.05))
    stop = fm.Stop(
        "end", pin, above=0.3, below=-0.2, normal=fm.HuntCrossley(stiffness=1e6, restitution=0.8), radius=0.1
    )
    mech = fm.Mechanism("free", [base, lever, pin, push, stop])
    sol = fm.simulate(mech, t_end=2.0)
    assert sol.ok, sol.status
    assert len(sol.episodes("end.above")) >= 1
    momenta, late = fm.momentum(mech, sol), sol.time > 0.06
    assert np.ptp(momenta.linear[late], axis=0) == pytest.approx(0.0, abs=1e-9)
    assert np.ptp(momenta.angular[late]) < 1e-5 * np.abs(momenta.angular).max()
    assert np.abs(sol["energy.residual"].values).max() < 1e-3


def stopped(**given):
    return fm.Stop("end", "pin", **{"above": 0.5, "normal": SOFT, **given})


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"above": None}, "above and below are None; give one"),
        ({"above": -0.1}, "above is -0.1, but the joint starts at 0"),
        ({"below": 0.2}, "below is 0.2, but the joint starts at 0"),
        ({"above": 0.0, "below": 0.0}, "above is 0, below 0; above must be larger"),
        ({"above": math.nan}, "above is nan; it must be finite"),
        ({"radius": 0.0}, "radius is 0 m; it must be > 0"),
        ({"along": (0.0, 0.0)}, "along is .* length > 0"),
        ({"normal": 1e5}, r"normal is 100000.0; it must be a normal law, e.g. KelvinVoigt"),
        ({"normal": fm.contact.Johnson(0.01, (fm.STEEL, fm.STEEL), restitution=0.4)}, "stiffness of Johnson depends"),
    ],
)
def test_wrong_stops_are_refused(given, words):
    with pytest.raises(InputError, match=words):
        stopped(**given)


def test_stops_of_wrong_joints_are_refused():
    with pytest.raises(ModelError, match=r"refers to joint 'pni'.*Did you mean 'pin'"):
        rotor(fm.Stop("end", "pni", above=0.5, normal=SOFT))
    body = fm.RigidBody("body", at=O, mass=1.0, inertia=1.0)
    weld = fm.Fixed("pin", fm.GROUND, body, at=O)
    with pytest.raises(ModelError, match="Fixed 'pin' has no angle or travel"):
        fm.Mechanism("welded", [body, weld, stopped()])
    begins = fm.Drive("motor", "pin", fm.drives.Polynomial((0.7, 1.0)))
    with pytest.raises(ModelError, match=r"Drive 'motor' begins at 0.7, beyond the limits -inf and 0.5"):
        fm.Mechanism("driven", [*rotor(stopped()).parts, begins])
