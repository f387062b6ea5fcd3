"""Starts: motions from rest in round-off, end slopes of tables, elastic joints that begin moving, massless links."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import AssemblyError, InputError, ModelError

O = (0.0, 0.0)
TIMES = tuple(np.linspace(0.0, 1.0, 11))
RISE = tuple(1e-3 * math.sin(0.5 * math.pi * t) ** 2 for t in TIMES)


def clamped(motion):
    """A beam that is clamped at both ends, one of which moves."""
    bar = fm.Rectangle(width=0.01, height=0.02)
    beam = fm.FlexibleLink("beam", O, (1.0, 0.0), section=bar, material=fm.STEEL, elements=4, damping=1e-4)
    ends = [fm.Fixed("A", fm.GROUND, beam, at=O), fm.Clamp("B", fm.GROUND, beam, at=(1.0, 0.0), y=motion)]
    return fm.Mechanism("clamped", [beam, *ends])


def test_a_motion_that_begins_at_rest_but_for_round_off():
    """1e-3 (cos(pi t) - 1) has a rate of 4e-19 m/s at t = 0 among floats; end force 12 E I/l^3 times the shift."""
    sol = fm.simulate(clamped(fm.drives.Harmonic(1e-3, 0.5, math.pi / 2.0, -1e-3)), t_end=1.0)
    assert sol.ok, sol.status
    bending = 12.0 * fm.STEEL.young * 0.01 * 0.02**3 / 12.0
    assert sol["B.y_force"].values[-1] == pytest.approx(-2e-3 * bending, rel=0.02)


def test_a_rate_that_is_no_round_off_is_refused_with_a_remedy():
    with pytest.raises(AssemblyError, match=r"violation .* A flexible body begins as a rigid one.*slopes=\(0.0, 0.0\)"):
        fm.simulate(clamped(fm.drives.Table(TIMES, RISE)), t_end=0.1)


def test_end_slopes_of_a_table():
    """Cubics are reproduced by their own end slopes; with (0, 0) a clamped beam can follow from rest."""
    cubic = np.polynomial.Polynomial([0.3, -1.0, 0.5, 2.0])
    times = np.array([0.0, 0.1, 0.35, 0.6, 1.0])
    table = fm.drives.Table(times, cubic(times), slopes=(-1.0, float(cubic.deriv()(1.0))))
    p = np.array(table.parameters())
    for t in np.linspace(0.0, 1.0, 23):
        assert table.kernel(p, t) == pytest.approx((cubic(t), cubic.deriv()(t), cubic.deriv(2)(t)), abs=1e-12)
    gentle = fm.drives.Table(TIMES, RISE, slopes=(0, 0))
    assert gentle.kernel(np.array(gentle.parameters()), 0.0)[1] == 0.0
    assert abs(fm.drives.Table(TIMES, RISE).kernel(np.array(fm.drives.Table(TIMES, RISE).parameters()), 0.0)[1]) > 1e-7
    assert fm.simulate(clamped(gentle), t_end=0.1).ok


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"slopes": 0.0}, "slopes is 0.0; it must be a list of two numbers"),
        ({"slopes": (0.0,)}, r"slopes is \(0.0,\); give two speeds"),
        ({"slopes": (0.0, math.inf)}, r"slopes\[1\] is inf; it must be finite"),
        ({"slopes": (0.0, 0.0), "periodic": True}, "a table that is repeated has no ends"),
    ],
)
def test_wrong_slopes_are_refused(given, words):
    with pytest.raises(InputError, match=words):
        fm.drives.Table(TIMES, RISE, **given)


def rotor(stiffness, velocity):
    """A rotor whose bearing is elastic."""
    body = fm.RigidBody("rotor", O, mass=2.0, inertia=0.01, velocity=velocity)
    return fm.Mechanism("rotor", [body, fm.Bushing("B", fm.GROUND, body, at=O, stiffness=stiffness)])


def test_a_rotor_on_springs_starts_with_its_velocity():
    """x = (v/w) sin w t along each axis, free motion along an axis without stiffness; the rotor spins on."""
    sol = fm.simulate(rotor((8e4, 2e4), (0.3, 0.4, 50.0)), t_end=0.05, step=fm.Adaptive(rtol=1e-8))
    assert sol.ok, sol.status
    for axis, k, v in (("x", 8e4, 0.3), ("y", 2e4, 0.4)):
        w = math.sqrt(k / 2.0)
        assert sol[f"rotor.{axis}"].values == pytest.approx(v / w * np.sin(w * sol.time), abs=1e-4 * v / w)
    assert sol["rotor.omega"].values == pytest.approx(50.0, rel=1e-12)
    free = fm.simulate(rotor((0.0, 2e4), (0.3, 0.0, 0.0)), t_end=0.1)
    assert free["rotor.x"].values == pytest.approx(0.3 * free.time, abs=1e-12)


def test_an_axis_without_stiffness_is_free_at_the_start():
    """A cart is drawn along the soft axis of a bushing: its load stays, where a stiff axis takes it along."""
    cart, load = (fm.RigidBody(name, O, mass=1.0, inertia=0.1) for name in ("cart", "load"))
    for stiffness, speed in (((0.0, 1e4), 0.0), ((1e4, 1e4), 2.0)):
        bush = fm.Bushing("B", cart, load, at=O, stiffness=stiffness, torsion=1.0)
        guide, drive = fm.Prismatic("guide", fm.GROUND, cart), fm.Drive("motor", "guide", fm.ConstantSpeed(2.0))
        sol = fm.simulate(fm.Mechanism("cart", [cart, load, bush, guide, drive]), t_end=0.01)
        assert sol["load.vx"].values[0] == pytest.approx(speed, abs=1e-9)
        assert sol["cart.vx"].values[0] == pytest.approx(2.0)


def four_bar(coupler):
    """A crank and a rocker with mass, tied by a coupler."""
    A, B, D = (0.1, 0.0), (0.4, 0.2), (0.4, 0.0)
    crank = fm.RigidLink("crank", O, A, mass=0.4, inertia=4e-4)
    rocker = fm.RigidLink("rocker", D, B, mass=0.6, inertia=2e-3)
    parts = [crank, rocker, fm.Revolute("O", fm.GROUND, crank, at=O), fm.Revolute("D", fm.GROUND, rocker, at=D)]
    if coupler is None:
        parts.append(fm.couplings.Distance("AB", crank, rocker, at=A, to=B))
    else:
        parts += [coupler, fm.Revolute("A", crank, coupler, at=A), fm.Revolute("B", coupler, rocker, at=B)]
    return fm.Mechanism("four-bar", [*parts, fm.Torque("push", crank, 0.2)], gravity=(0.0, -9.81))


def test_a_massless_coupler_is_a_rod():
    massless = fm.RigidLink("coupler", (0.1, 0.0), (0.4, 0.2), mass=0.0, inertia=0.0)
    step = fm.Adaptive(rtol=1e-6)
    sol, rod = fm.simulate(four_bar(massless), t_end=0.8, step=step), fm.simulate(four_bar(None), t_end=0.8, step=step)
    assert sol.ok, sol.status
    assert sol["rocker.theta"].values == pytest.approx(rod["rocker.theta"].values, abs=1e-5)
    assert sol["B.force"].values[5:] == pytest.approx(np.abs(rod["AB.force"].values[5:]), rel=1e-3, abs=1e-3)
    assert fm.check(four_bar(massless)).ok
    light = four_bar(massless).with_({"coupler.mass": 4e-10, "coupler.inertia": 4e-11 * 0.13 / 12.0})
    ends = [fm.simulate(mech, t_end=0.8, step=5e-4)["rocker.theta"].values[-1] for mech in (four_bar(massless), light)]
    assert ends[0] == pytest.approx(ends[1], abs=1e-5)  # with a tenth of its numerical mass


def test_a_massless_link_that_moves_alone_is_named():
    loose = fm.RigidLink("whip", O, (0.5, 0.0), mass=0, inertia=0)
    body = fm.RigidBody("body", O, mass=1.0, inertia=1.0)
    mech = fm.Mechanism("whip", [body, loose, fm.Revolute("O", body, loose, at=O)])
    with pytest.raises(ModelError, match=r"massless link 'whip' can move without moving a mass"):
        fm.simulate(mech, t_end=0.1)
    assert [finding.code for finding in fm.check(mech).findings if finding.severity == "error"] == ["no-inertia"]
    with pytest.raises(InputError, match=r"mass is 0 kg; it must be > 0"):
        fm.RigidLink("odd", O, (0.5, 0.0), mass=0.0, inertia=1.0)
    with pytest.raises(InputError, match=r"inertia is 0 kg m\^2; it must be > 0"):
        fm.RigidLink("odd", O, (0.5, 0.0), mass=1.0, inertia=0.0)


@pytest.mark.parametrize("length", [1e-5, 1e-6, 1e-7])
def test_free_machines_of_micrometres_start(length):
    """A four-bar linkage that falls from rest moves alike at any size, if gravity grows with it.

    Its masses, 1e-16 to 1e-22 kg, are far below the entries of its joints.
    """
    angles = []
    for L in (1.0, length):
        points, m = [(0.0, 0.0), (0.3 * L, 0.1 * L), (1.2 * L, 0.6 * L), (1.2 * L, 0.0)], 10.0 * L**3
        bars = [
            fm.RigidLink(name, points[k], points[k + 1], mass=m, inertia=share * m * L**2 / 12.0)
            for k, (name, share) in enumerate((("a", 0.1), ("b", 1.0), ("c", 0.4)))
        ]
        sides = [fm.GROUND, *bars, fm.GROUND]
        pins = [fm.Revolute(f"pin {k}", sides[k], sides[k + 1], at=points[k]) for k in range(4)]
        sol = fm.simulate(fm.Mechanism("falling", [*bars, *pins], gravity=(0.0, -9.81 * L)), t_end=0.5)
        assert sol.ok, sol.status
        angles.append(sol.array("a.theta")[-1])
    assert angles[1] == pytest.approx(angles[0], abs=1e-8)
