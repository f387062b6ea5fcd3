"""Contacts that begin slowly, at rest or are pressed together or released faster than they met."""

import math
from dataclasses import replace

import numpy as np
import pytest

import flexmb as fm
from flexmb.parts.contact.hysteresis import exact_chi

PLAY, MASS, K, E = 2e-4, 0.5, 1e9, 0.6
LOAD = 50.0
CHI = exact_chi(E)
REST = (LOAD / K) ** (2.0 / 3.0)
"""Depth at rest under the load [m]."""

IMPACT = math.sqrt(2.0 * LOAD * REST / (2.5 * MASS))
"""Speed of the free impact that reaches this depth without damping [m/s]."""


def law(**numbers):
    return fm.contact.ExactRestitution(stiffness=K, restitution=E, **numbers)


def pressed(normal, speed, *, t_end=0.02, step=None, periods=None):
    """A ball at the wall of its hole, pushed against it by the load and moving towards it with `speed`."""
    ball = fm.RigidBody("ball", (0.0, 0.0), MASS, 1.0, velocity=(speed, 0.0, 0.0))
    joint = fm.RevoluteClearance(
        "J", fm.GROUND, ball, (0.0, 0.0), clearance=PLAY, bearing_radius=1e-2, normal=normal, start=(PLAY, 0.0)
    )
    mech = fm.Mechanism("pressed", [ball, joint], gravity=(LOAD / MASS, 0.0))
    return fm.simulate(mech, t_end=t_end, step=step or fm.Adaptive(rtol=1e-7, max=1e-5), save="steps")


def swinging(speed, *, largest, t_end=0.02):
    """Depth at 4001 instants by an integrator of its own: m x'' = F - K x^1.5 (1 + chi x'/w), begun with `speed`."""
    t, h = 0.0, t_end / 4000 / 50
    x, v, w, found = 0.0, speed, speed, [0.0]

    def rate(x, v):
        if x <= 0.0:
            return LOAD / MASS
        scale = max(w, v, -v / E) if largest else w
        factor = 1.0 + CHI * v / scale if scale > 0.0 else 1.0
        return (LOAD - K * x**1.5 * max(factor, 0.0)) / MASS

    for k in range(200_000):
        a1 = rate(x, v)
        v2 = v + 0.5 * h * a1
        a2 = rate(x + 0.5 * h * v, v2)
        v3 = v + 0.5 * h * a2
        a3 = rate(x + 0.5 * h * v2, v3)
        v4 = v + h * a3
        a4 = rate(x + h * v3, v4)
        x, v = x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4), v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        w = max(w, v, -v / E) if largest else w
        t += h
        if k % 50 == 49:
            found.append(x)
    return np.linspace(0.0, t_end, 4001), np.array(found)


@pytest.mark.slow
@pytest.mark.parametrize("reference", ["onset", pytest.param("largest", marks=pytest.mark.slow)])
def test_at_rest_under_load(reference):
    """The contact swings about its depth at rest, damped as an impact is, and not more."""
    sol = pressed(law(reference_speed=reference), 0.0)
    assert sol.ok, sol.status
    depth = sol.array("J.penetration")
    times, wanted = swinging(0.0, largest=True)
    assert np.interp(times, sol.time, depth) == pytest.approx(wanted, abs=2e-4 * REST)
    swings = np.count_nonzero(np.diff(np.sign(depth - REST)))
    assert swings >= 10
    assert depth[-1] == pytest.approx(REST, rel=0.02)


@pytest.mark.parametrize("share", [1e-4, 1e-2, 0.3, 3.0])
def test_the_largest_speed_bounds_the_force(share):
    """N between (1 - chi e) and (1 + chi) times K depth^n at any approach speed, as in a free impact."""
    sol = pressed(law(reference_speed="largest"), share * IMPACT)
    elastic, N = K * np.maximum(sol.array("J.penetration"), 0.0) ** 1.5, sol.array("J.normal_force")
    assert ((1.0 + CHI) * elastic * (1.0 + 1e-9) >= N).all()
    assert ((1.0 - CHI * E) * elastic * (1.0 - 1e-9) <= N).all()
    assert not any("pressed together" in note for note in sol.notes)


def test_the_speed_at_the_onset_does_not_bound_it_and_the_run_says_so():
    sol = pressed(law(), 1e-2 * IMPACT)
    depth, N = sol.array("J.penetration"), sol.array("J.normal_force")
    inside = depth > 0.1 * REST
    assert (N[inside] / (K * depth[inside] ** 1.5)).max() > 2.0 * (1.0 + CHI)
    (note,) = (note for note in sol.notes if "pressed together" in note)
    excess = (N - (1.0 + CHI) * K * np.maximum(depth, 0.0) ** 1.5).max()
    assert f"up to {excess:.3g} N of damping are beyond what it is made for" in note


def released(normal, load_time, start):
    """The speed with which a ball leaves its wall that was loaded within `load_time` and is let go; its notes."""
    ball = fm.RigidBody("ball", (0.0, 0.0), MASS, 1.0)
    joint = fm.RevoluteClearance(
        "J", fm.GROUND, ball, (0.0, 0.0), clearance=PLAY, bearing_radius=1e-2, normal=normal, start=start
    )
    history = fm.drives.PiecewiseLinear(
        (0.0, load_time, load_time + 0.05, load_time + 0.05 + 1e-9), (0.0, 1.0, 1.0, 0.0)
    )
    load = fm.Force("F", ball, (0.0, 0.0), (LOAD, 0.0), history=history)
    end = load_time + 0.06
    sol = fm.simulate(fm.Mechanism("let go", [ball, joint, load]), t_end=end, step=fm.Adaptive(rtol=1e-6, max=1e-5))
    assert sol.ok, sol.status
    return -sol.array("ball.vx")[-1], sol.notes


@pytest.mark.parametrize("load_time", [0.01, 0.1])
@pytest.mark.parametrize("start", [(PLAY, 0.0), (0.999 * PLAY, 0.0)])
def test_what_is_loaded_slowly_and_let_go_springs_back(load_time, start):
    """The bracket is 1 - chi e all the way out, since the speed rises; so that part of the energy comes back."""
    whole = math.sqrt(0.8 * K * REST**2.5 / MASS)
    speed, notes = released(law(reference_speed="largest"), load_time, start)
    assert speed == pytest.approx(math.sqrt(1.0 - CHI * E) * whole, rel=0.02)
    assert not any("released" in note for note in notes)


def test_the_speed_at_the_onset_keeps_it_and_the_run_says_so():
    speed, notes = released(law(), 0.1, (0.999 * PLAY, 0.0))
    assert speed < 0.1 * math.sqrt(0.8 * K * REST**2.5 / MASS)
    assert any("or let go, faster than they had met" in note for note in notes)


@pytest.mark.parametrize("place", [(0.0, 0.0), (1.2345, 0.4115), (25.0, 8.3)])
def test_a_seated_contact_does_not_depend_on_the_round_off_of_its_gap(place):
    """As an onset, a gap of 1e-15 m under a large load would have an approach speed of 1e-5 m/s."""
    ball = fm.RigidBody("ball", place, 1e-3, 1e-6)
    joint = fm.RevoluteClearance(
        "J", fm.GROUND, ball, place, clearance=PLAY, bearing_radius=1e-2, normal=law(), start="seated"
    )
    load = fm.Force("F", ball, place, (0.0, -100.0))
    sol = fm.simulate(fm.Mechanism("seated", [ball, joint, load], gravity=(0.0, -9.81)), t_end=0.02)
    assert sol.ok, sol.status
    assert sol.array("J.penetration")[-1] == pytest.approx((100.00981 / K) ** (2.0 / 3.0), rel=1e-3)
    assert not any("least_approach" in note for note in sol.notes)
    assert np.isnan(sol.episodes("J").start[0])


def test_free_impacts_are_the_same():
    """Up to the error of the steps, by which an opening speed passes e times the approach speed."""
    found = []
    for reference in ("onset", "largest"):
        ball = fm.RigidBody("ball", (0.0, 0.0), MASS, 1.0, velocity=(0.3, 0.0, 0.0))
        joint = fm.RevoluteClearance(
            "J", fm.GROUND, ball, (0.0, 0.0), clearance=PLAY, bearing_radius=1e-2, normal=law(reference_speed=reference)
        )
        mech = fm.Mechanism("free", [ball, joint])
        found.append(fm.simulate(mech, t_end=5e-3, save="steps", step=fm.Adaptive(rtol=1e-7)))
    assert len(found[0].episodes("J")) >= 2
    speeds = [sol.episodes("J").separation_speed for sol in found]
    assert speeds[0] == pytest.approx(speeds[1], rel=1e-9)


def test_results_converge_as_the_bound_falls():
    """The largest speed does not remember the bound; the speed at the onset does not where it is faster."""
    for reference, speed in (("largest", 0.0), ("onset", 1e-2 * IMPACT)):
        bounds = [part * IMPACT for part in (1e-3, 1e-4, 1e-5, 0.0)]
        sols = [pressed(law(reference_speed=reference, least_approach=bound), speed) for bound in bounds]
        times = np.linspace(0.0, 0.02, 2001)
        depths = [np.interp(times, sol.time, sol.array("J.penetration")) for sol in sols]
        apart = [np.abs(depth - depths[-1]).max() / REST for depth in depths[:-1]]
        assert apart[0] < 1e-3
        assert apart[1] < 1e-4
        assert apart[2] < 1e-4


@pytest.mark.parametrize("reference", ["onset", "largest"])
@pytest.mark.parametrize("speed", [0.0, 1e-2, 1.0])
def test_the_account_of_energy_closes(reference, speed):
    """Damping takes, never gives, and the loss is all that is missing."""
    sol = pressed(law(reference_speed=reference), speed * IMPACT)
    assert sol.ok, sol.status
    lost, scale = sol.array("energy.dissipated_contact"), LOAD * REST
    assert np.abs(sol.array("energy.residual")).max() < 1e-5 * scale
    kept = (
        0.4 * K * np.maximum(sol.array("J.penetration"), 0.0) ** 2.5
    )  # what the account of a closed contact holds, too
    damped = lost - kept
    assert (np.diff(damped) >= -1e-6 * scale).all()
    assert damped[-1] > 0.1 * scale


def bearing(ball, normal, start):
    """A bearing of the ground whose journal, the ball, begins at (start, 0)."""
    sizes = {"clearance": PLAY, "bearing_radius": 1e-2}
    return fm.RevoluteClearance("J", fm.GROUND, ball, (0.0, 0.0), normal=normal, start=(start, 0.0), **sizes)


def test_slow_contacts_that_carry_the_impulse_are_named():
    """A ball that begins at rest carries its whole load through that contact."""
    ball = fm.RigidBody("ball", (0.0, 0.0), MASS, 1.0)
    joint = bearing(ball, law(least_approach=1.0), 0.5 * PLAY)
    mech = fm.Mechanism("slow", [ball, joint], gravity=(LOAD / MASS, 0.0))
    sol = fm.simulate(mech, t_end=0.1)
    assert (sol.episodes("J").approach_speed < 1.0).all()
    (note,) = (note for note in sol.notes if "least_approach" in note)
    assert "100 % of the impulse" in note
    for other in (law(), replace(law(least_approach=1.0), restitution=1.0)):  # the second has no damping to scale
        quiet = fm.simulate(mech.with_part(replace(joint, normal=other)), t_end=0.1)
        assert not any("least_approach" in note for note in quiet.notes)


def test_a_contact_without_onset_is_named():
    sol = pressed(law(), 1e-2 * IMPACT, t_end=0.05)
    (note,) = (note for note in sol.notes if "touched without a break" in note)
    assert "its damping still follows the" in note
    (note,) = (n for n in pressed(law(reference_speed="largest"), IMPACT, t_end=0.05).notes if "without a break" in n)
    assert "the largest speed since then" in note
    assert not any(
        "without a break" in note for note in pressed(fm.contact.Hertz(stiffness=K), IMPACT, t_end=0.05).notes
    )


@pytest.mark.parametrize("reference", ["onset", "largest"])
@pytest.mark.parametrize("start", ["centred", "seated", (0.3e-3, -0.1e-3)])
def test_a_light_contact_comes_to_rest(start, reference):
    """1 g in a bearing with 0.5 mm of play, default steps: the depth under its weight, and energies that add up."""
    normal = fm.LankaraniNikravesh.from_materials(fm.STEEL, fm.STEEL, reference_speed=reference)
    ball = fm.RigidBody("ball", (0.0, 0.0), 1e-3, 1e-8)
    friction = fm.ModifiedCoulomb(0.05, 1e-4, 1e-3)
    joint = fm.RevoluteClearance(
        "J",
        fm.GROUND,
        ball,
        (0.0, 0.0),
        clearance=0.5e-3,
        bearing_radius=1e-2,
        normal=normal,
        friction=friction,
        start=start,
    )
    sol = fm.simulate(fm.Mechanism("light", [ball, joint], gravity=(0.0, -9.81)), t_end=0.5)
    assert sol.ok, sol.status
    if isinstance(start, str):  # else it swings in the hollow
        depth, N = (sol.array(f"J.{name}")[-1] for name in ("penetration", "normal_force"))
        stiffness = normal.for_radii(1e-2, 9.5e-3).stiffness
        assert depth == pytest.approx((9.81e-3 / stiffness) ** (2.0 / 3.0), rel=1e-6)
        assert N == pytest.approx(9.81e-3, rel=1e-6)  # noqa: SIM300


@pytest.mark.parametrize("reference", ["onset", pytest.param("largest", marks=pytest.mark.slow)])
def test_the_part_keeps_its_contract(reference):
    ball = fm.RigidBody("ball", (0.0, 0.0), MASS, 1.0)
    joint = fm.RevoluteClearance(
        "J", fm.GROUND, ball, (0.0, 0.0), clearance=PLAY, bearing_radius=1e-2, normal=law(reference_speed=reference)
    )
    fm.testing.check_part(fm.Mechanism("part", [ball, joint]), "J")


def test_settled_swings_do_not_remember_a_slow_first_touch():
    """A load that swings: with the largest speed the steady motion hardly depends on how slow the first touch was.

    With the speed at the onset there is one steady motion for each first touch, and the run says why.
    """

    wave = fm.drives.Harmonic(1.0, frequency=450.0)

    def settled(reference, first):
        ball = fm.RigidBody("ball", (0.0, 0.0), MASS, 1.0, velocity=(first, 0.0, 0.0))
        joint = bearing(ball, law(reference_speed=reference), PLAY)
        swing = fm.Force("swing", ball, (0.0, 0.0), (0.3 * LOAD, 0.0), history=wave)
        mech = fm.Mechanism("swung", [ball, joint, swing], gravity=(LOAD / MASS, 0.0))
        return fm.simulate(mech, t_end=0.2, save="steps", step=fm.Adaptive(rtol=1e-6, max=1e-5))

    depths = {}
    for reference in ("onset", "largest"):
        for first in (0.02 * IMPACT, 0.2 * IMPACT):
            sol = settled(reference, first)
            late = sol.time > 0.15
            depths[reference, first] = np.ptp(sol.array("J.penetration")[late])
    a, b = (depths["largest", first] for first in (0.02 * IMPACT, 0.2 * IMPACT))
    assert a == pytest.approx(b, rel=0.02)
    a, b = (depths["onset", first] for first in (0.02 * IMPACT, 0.2 * IMPACT))
    assert abs(a - b) > 0.1 * b
