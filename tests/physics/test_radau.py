"""Radau's method: order, published digits, account of energies, instants within steps, contacts, restarts."""

import math
import runpy
from pathlib import Path

import numpy as np
import pytest
from andrews import andrews, andrews_angles
from scipy.optimize import brentq

import flexmb as fm
from flexmb.errors import InputError

double = runpy.run_path(str(Path(__file__).with_name("double_pendulum.py")))
pendulum, motion, G, UPPER = (double[name] for name in ("pendulum", "motion", "G", "UPPER"))

ANDREWS = (
    15.81077119629904, -15.75637105984298, 0.04082224013073101, -0.5347301163226948, 0.5244099658805304,
    0.5347301163226948, 1.048080741042263,
)  # fmt: skip
"""Angles of Andrews' mechanism at 0.03 s: F. Mazzia, C. Magherini, Test Set for IVP Solvers, release 2.4 (2008)."""

RADAU = fm.RadauIIA()


def missed(sol):
    """Largest errors of angles, speeds and knee force over all saved instants."""
    angles, speeds, force = motion(sol.time)
    both = [np.column_stack([sol.array(f"{rod}.{x}") for rod in ("upper", "lower")]) for x in ("theta", "omega")]
    return [
        np.abs(both[0] - angles).max(),
        np.abs(both[1] - speeds).max(),
        np.abs(sol.array("P.fx") - force[:, 0]).max(),
    ]


def run(**options):
    sol = fm.simulate(pendulum(), t_end=2.0, method=RADAU, **{"save": "steps", **options})
    assert sol.ok, sol.status
    return sol


def test_fifth_order_of_positions_velocities_and_joint_forces():
    coarse, fine = (np.array(missed(run(step=h))) for h in (0.05, 0.025))
    orders = np.log2(coarse / fine)
    assert np.all(orders > 4.6)
    assert np.all(orders < 6.5)


def test_unequal_steps_keep_the_order():
    found = [np.array(missed(run(step=fm.Adaptive(rtol=r)))) for r in (1e-4, 1e-8)]
    assert np.all(found[1] < 1e-2 * found[0])
    assert found[0][0] < 1e-4
    assert found[1][0] < 1e-8


def test_instants_within_steps_are_as_good_as_their_ends():
    sol = run(step=0.05, save=401)
    ends = np.array(missed(run(step=0.05)))
    assert np.all(np.array(missed(sol)) < 3.0 * ends)


def test_joints_stay_closed_in_positions_and_velocities():
    sol = run(step=0.05)
    theta, half = sol.array("upper.theta"), 0.5 * UPPER[0]
    x, y = sol.array("upper.x") - half * np.cos(theta), sol.array("upper.y") - half * np.sin(theta)
    vx = sol.array("upper.vx") + half * np.sin(theta) * sol.array("upper.omega")
    assert np.abs([x, y]).max() < 1e-13
    assert np.abs(vx).max() < 1e-12


def test_published_digits_of_andrews_mechanism():
    sol = fm.simulate(andrews(), t_end=0.03, method=RADAU, step=fm.Adaptive(rtol=1e-9), save=1)
    assert sol.ok, sol.status
    assert np.abs(andrews_angles(sol)[:, -1] - ANDREWS).max() < 1e-8
    assert sol.stats.steps < 2000


def driven(stiffness=2e3, damping=5.0):
    """A slider-crank that drags a spring and a damper along."""
    parts = fm.mechanisms.slider_crank().parts
    slider = next(p for p in parts if p.name == "slider")
    spring = fm.SpringDamper("spring", fm.GROUND, slider, (0.0, 0.1), (0.3, 0.0), stiffness=stiffness, damping=damping)
    return fm.Mechanism("driven", (*parts, spring))


def test_works_of_drive_and_damper_add_up():
    sol = fm.simulate(driven(), t_end=0.05, method=RADAU, step=fm.Adaptive(rtol=1e-7), save=50)
    assert sol.ok, sol.status
    drive, damped = sol.array("energy.drive_work")[-1], sol.array("energy.dissipated_damping")[-1]
    assert damped > 0.0
    assert abs(sol.array("energy.residual")[-1]) < 1e-6 * max(abs(drive), damped)


@pytest.mark.parametrize("stiffness", [1e3, 1e7, 1e11])
def test_a_stiff_spring_does_not_set_the_step(stiffness):
    """A pendulum whose bob hangs at a stiff spring: its slow motion is all that is asked for."""
    rod = fm.RigidLink("rod", (0.0, 0.0), (1.0, 0.0), 1.0, 0.1)
    bob = fm.RigidBody("bob", (1.0, 0.0), 1.0, 0.01)
    bushing = fm.Bushing("B", rod, bob, (1.0, 0.0), stiffness=stiffness)
    parts = (rod, bob, fm.Revolute("O", fm.GROUND, rod, (0.0, 0.0)), bushing)
    sol = fm.simulate(fm.Mechanism("bob", parts, gravity=(0.0, -G)), t_end=0.5, method=RADAU, save=1)
    assert sol.ok, sol.status
    assert sol.stats.steps < (3000 if stiffness < 1e4 else 1500)


@pytest.mark.parametrize("mass", [1e-2, 1e-6])
def test_what_creeps_is_as_accurate_as_asked_for(mass):
    """m x'' + c x' + k x = 0 with c^2 >> k m: speeds are stiff, and the place creeps back in c/k = 0.1 s."""
    body = fm.RigidBody("body", at=(0.1, 0.0), mass=mass, inertia=1.0)
    ends = {"at": (-1.0, 0.0), "to": body.at, "free_length": 1.0}
    spring = fm.SpringDamper("spring", fm.GROUND, body, **ends, stiffness=1e3, damping=100.0)
    slow = fm.Mechanism("slow", [body, fm.Prismatic("guide", fm.GROUND, body), spring])
    times = np.linspace(0.0, 1.0, 41)
    one, two = np.roots([mass, 100.0, 1e3])
    exact = 0.1 * (two * np.exp(one * times) - one * np.exp(two * times)) / (two - one)
    for rtol in (1e-4, 1e-6):
        sol = fm.simulate(slow, t_end=20.0, save=times, method=RADAU, step=fm.Adaptive(rtol=rtol))
        assert np.abs(sol.array("body.x") - exact).max() < 1e-3 * rtol, rtol  # 2 to 4e-6 of rtol


def test_a_rotor_that_a_film_of_oil_carries():
    """A journal without drive sinks and swings round in its film, whose damping outweighs its mass."""
    rotor = fm.RigidBody("rotor", at=(0.0, 0.0), mass=5.0, inertia=1e3, velocity=(0.0, 0.0, 300.0))
    law, film = fm.KelvinVoigt(1e9, 1e3, ramp=1e-8), fm.ShortBearing(viscosity=0.03, width=0.01)
    gap = {"clearance": 5e-5, "bearing_radius": 0.02, "normal": law, "film": film, "roughness": 1e-7}
    oil = fm.JournalBearing("oil", fm.GROUND, rotor, at=(0.0, 0.0), **gap)
    push = fm.Force("push", rotor, at=(0.0, 0.0), force=(0.0, -500.0), history=fm.drives.Pulse(1.0, 0.1))
    mech, times = fm.Mechanism("rotor", [rotor, oil, push], gravity=(0.0, -9.81)), np.linspace(0.0, 0.2, 201)
    fine = fm.simulate(mech, t_end=0.2, save=times, step=fm.Adaptive(rtol=1e-6))
    for rtol in (1e-4, 1e-5):
        sol = fm.simulate(mech, t_end=0.2, save=times, method=RADAU, step=fm.Adaptive(rtol=rtol))
        for name in ("oil.ex", "oil.ey"):
            assert np.abs(sol.array(name) - fine.array(name)).max() < 1e-3 * 5e-5, (rtol, name)


def test_a_flexible_pendulum_as_the_newmark_family_has_it():
    rod = fm.FlexibleLink(
        "rod", (0.0, 0.0), (1.0, 0.0), section=fm.Rectangle(0.02, 0.02), material=fm.STEEL, elements=2
    )
    mech = fm.Mechanism("rod", (rod, fm.Revolute("O", fm.GROUND, rod, (0.0, 0.0))), gravity=(0.0, -G))
    radau = fm.simulate(mech, t_end=0.2, method=RADAU, step=2e-4, save=4)
    fine = fm.simulate(mech, t_end=0.2, step=1e-5, save=4, method=fm.Newmark.trapezoidal())
    assert radau.ok, radau.status
    assert np.abs(radau.array("rod.end.y") - fine.array("rod.end.y")).max() < 2e-6


def thrown(**options):
    """A pin that flies against its bearing."""
    pin = fm.RigidBody("pin", at=(0.0, 0.0), mass=1.0, inertia=1.0, velocity=(1.0, 0.0, 0.0))
    law = fm.LankaraniNikravesh(stiffness=1e9, restitution=0.9)
    size = {"at": (0.0, 0.0), "clearance": 1e-3, "bearing_radius": 0.1}
    mech = fm.Mechanism("thrown", [pin, fm.RevoluteClearance("J", fm.GROUND, pin, normal=law, **size)])
    return fm.simulate(mech, t_end=0.002, method=RADAU, **options)


def test_an_impact_has_the_restitution_of_its_law():
    sol = thrown()
    hit = sol.episodes("J")[0]
    assert sol.ok, sol.status
    a = 0.75 * (1.0 - 0.9**2)
    exact = brentq(lambda e: a * (1.0 + e) - math.log((1.0 + a) / (1.0 - a * e)), 0.5, 1.0)  # `test_impact.py`
    assert hit.separation_speed == pytest.approx(exact, rel=1e-5)
    lost = 0.5 * (1.0 - hit.separation_speed**2)
    assert hit.dissipated_contact == pytest.approx(lost, rel=1e-3)
    assert abs(sol.array("energy.residual")[-1]) < 1e-4


def test_a_worn_slider_crank_as_the_newmark_family_has_it():
    mech = fm.mechanisms.slider_crank(clearance=5e-4)
    radau = fm.simulate(mech, t_end=0.004, method=RADAU, step=fm.Adaptive(rtol=1e-7), save=20)
    newmark = fm.simulate(mech, t_end=0.004, step=fm.Adaptive(rtol=1e-7), save=20)
    assert radau.ok, radau.status
    assert np.abs(radau.array("slider.x") - newmark.array("slider.x")).max() < 5e-8
    assert len(radau.episodes()) == len(newmark.episodes()) > 2


def test_a_restart_goes_on_to_the_bit():
    whole = run(step=fm.Adaptive(rtol=1e-6))
    half = fm.simulate(pendulum(), t_end=2.0, method=RADAU, step=fm.Adaptive(rtol=1e-6), save="steps", max_steps=20)
    rest = run(step=fm.Adaptive(rtol=1e-6), restart=half.restart)
    assert np.array_equal(rest.array("lower.theta")[-1:], whole.array("lower.theta")[-1:])


def test_a_restart_of_another_method_begins_anew():
    half = fm.simulate(pendulum(), t_end=1.0, save=1)
    sol = fm.simulate(pendulum(), t_end=2.0, method=RADAU, step=fm.Adaptive(rtol=1e-8), restart=half.restart, save=1)
    assert sol.ok, sol.status


def test_parallel_cranks_that_repeat_one_another():
    ends = [((0.5 * k, 0.0), (0.5 * k + 0.1, 0.2)) for k in range(3)]
    cranks = [fm.RigidLink(f"crank{k}", *ends[k], 1.0, 0.01) for k in range(3)]
    rod = fm.RigidLink("rod", ends[0][1], ends[2][1], 1.0, 0.1)
    joints = [fm.Revolute(f"A{k}", fm.GROUND, cranks[k], ends[k][0]) for k in range(3)]
    joints += [fm.Revolute(f"B{k}", cranks[k], rod, ends[k][1]) for k in range(3)]
    mech = fm.Mechanism("cranks", (*cranks, rod, *joints), gravity=(0.0, -G))
    sol = fm.simulate(mech, t_end=0.2, method=RADAU, step=1e-3, redundant="least-norm", save=10)
    newmark = fm.simulate(mech, t_end=0.2, step=1e-4, redundant="least-norm", save=10)
    assert sol.ok, sol.status
    assert np.abs(sol.array("rod.x") - newmark.array("rod.x")).max() < 1e-6


@pytest.mark.parametrize("rtol", [1e-4, 1e-8])
def test_joints_that_repeat_one_another_share_the_force_between_steps(rtol):
    """Rows of a grid lie within steps; without a choice of least norm the share of each joint was anything."""
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.3, 0.0), 1.0, 0.01)
    rod = fm.RigidLink("rod", (0.3, 0.0), (0.6, 0.0), 1.0, 0.01)
    once = [fm.Revolute("O", fm.GROUND, crank, (0.0, 0.0)), fm.Revolute("A", crank, rod, (0.3, 0.0))]
    twice = [*once, fm.Revolute("O2", fm.GROUND, crank, (0.0, 0.0))]
    runs = [
        fm.simulate(
            fm.Mechanism("pendulum", (crank, rod, *joints), gravity=(0.0, -G)),
            t_end=0.5, save=37, step=fm.Adaptive(rtol=rtol), method=RADAU, redundant="least-norm",
        )
        for joints in (once, twice)
    ]  # fmt: skip
    alone, shared = (run.array("O.fx") for run in runs)
    assert all(run.ok for run in runs)
    np.testing.assert_allclose(shared, runs[1].array("O2.fx"), rtol=0.0, atol=1e-5 * np.abs(alone).max())
    np.testing.assert_allclose(2.0 * shared, alone, rtol=0.0, atol=20.0 * rtol * np.abs(alone).max())
    assert abs(runs[1].peak("O.fx").value) <= 0.501 * abs(runs[0].peak("O.fx").value)


@pytest.mark.parametrize("step", [fm.Adaptive(), 1e-3])
def test_a_driven_crank_on_two_bearings_keeps_its_forces(step):
    """Shares that the equations leave free grew in the stages from step to step, until the run broke off."""
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.3, 0.0), 1.0, 0.01)
    rod = fm.RigidLink("rod", (0.3, 0.0), (0.6, 0.0), 1.0, 0.01)
    joints = [fm.Revolute("O", fm.GROUND, crank, (0.0, 0.0)), fm.Revolute("A", crank, rod, (0.3, 0.0))]
    joints += [fm.Revolute("O2", fm.GROUND, crank, (0.0, 0.0)), fm.Drive("motor", "O", fm.ConstantSpeed(10.0))]
    mech = fm.Mechanism("crank", (crank, rod, *joints), gravity=(0.0, -G))
    runs = [
        fm.simulate(mech, t_end=0.5, method=method, step=size, redundant="least-norm")
        for method, size in ((RADAU, step), (fm.DormandPrince(), fm.Adaptive(rtol=1e-9)))
    ]
    assert all(run.ok for run in runs), [run.status for run in runs]
    for name in ("O.force", "O2.force", "motor.torque"):
        np.testing.assert_allclose(runs[0].peak(name).value, runs[1].peak(name).value, rtol=1e-4)


def test_a_step_that_is_far_too_long_says_so():
    sol = fm.simulate(fm.mechanisms.slider_crank(), t_end=0.1, method=RADAU, step=0.05)
    assert not sol.ok
    assert "Newton did not converge" in sol.status or "energies" in sol.status or "singular" in sol.status


def test_tangents_are_refused():
    with pytest.raises(InputError, match="method is RadauIIA"):
        fm.chaos.MechanismFlow(fm.mechanisms.slider_crank(), method=RADAU)


def graze():
    """A block that just touches its stop: a stage within the wall would turn it back before it got there."""
    c, w = 1e-2, 2.0 * math.pi
    block = fm.RigidBody("b", at=(0.0, 0.0), mass=1.0, inertia=0.1, velocity=(1.05 * c * w, 0.0, 0.0))
    wheel = fm.RigidBody("w", at=(0.5, 0.0), mass=1.0, inertia=1.0, velocity=(0.0, 0.0, 0.5))
    stop = {"clearance": c, "bearing_radius": 0.1, "normal": fm.KelvinVoigt(1e7, 0.0)}
    parts = (
        block,
        wheel,
        fm.Prismatic("g", fm.GROUND, block),
        fm.SpringDamper("s", fm.GROUND, block, (-1.0, 0.0), (0.0, 0.0), stiffness=w**2),
        fm.RevoluteClearance("B", fm.GROUND, block, at=(0.0, 0.0), **stop),
        fm.Revolute("W", fm.GROUND, wheel, at=(0.5, 0.0)),
    )
    return fm.Mechanism("graze", parts)


def test_a_contact_that_a_stage_feels_is_not_stepped_over():
    sol, w = fm.simulate(graze(), t_end=10.0, method=RADAU), 2.0 * math.pi
    energy = 0.5 * sol.array("b.vx") ** 2 + 0.5 * w**2 * sol.array("b.x") ** 2
    assert sol.ok, sol.status
    assert len(sol.episodes("B")) == 25
    assert np.abs(np.median(energy[-100:]) / energy[0] - 1.0) < 1e-3


@pytest.mark.parametrize(("stiffness", "damping"), [(1e9, 1e4), (1e10, 1e5), (1e12, 0.0)])
def test_forces_between_steps_where_they_are_stiff(stiffness, damping):
    """A rubber of steel in place of a joint: the error of a position times its stiffness is no force."""
    mech = fm.mechanisms.slider_crank()
    joint = next(p for p in mech.parts if p.name == "B")
    rubber = fm.Bushing("B", joint.first, joint.second, at=joint.at, stiffness=stiffness, damping=damping)
    stiff = mech.with_part(rubber)
    sol = fm.simulate(stiff, periods=1, method=RADAU, step=fm.Adaptive(rtol=1e-6))
    rigid = fm.simulate(mech, periods=1, method=RADAU, step=fm.Adaptive(rtol=1e-6))
    assert sol.ok, sol.status
    assert np.abs(sol.array("guide.force")).max() == pytest.approx(np.abs(rigid.array("guide.force")).max(), rel=0.01)


def test_peaks_are_no_less_than_what_was_saved():
    sol = fm.simulate(fm.mechanisms.four_bar(), periods=1, method=RADAU)
    newmark = fm.simulate(fm.mechanisms.four_bar(), periods=1)
    saved = np.abs(sol.values).max(axis=0)
    assert np.all(sol.peaks.values >= saved * (1.0 - 1e-12) - 1e-300)
    assert sol.peak("motor.torque").value == pytest.approx(newmark.peak("motor.torque").value, rel=1e-3)


@pytest.mark.parametrize("speed", [40.0, 100.0])
def test_forces_between_steps_across_kinks_of_a_cam(speed):
    """Follower of a 3-4-5 cam, whose jerk jumps at dwells: force m w^2 s'' + k (s + r), at all saved instants."""
    mass, spring, radius = 0.3, 2000.0, 0.06
    lift = fm.cams.Lift(((0.0, 0.0), (1.2, 0.01), (1.6, 0.01), (2.8, 0.0)), "3-4-5")
    cam = fm.RigidBody("cam", at=(0.0, 0.0), mass=0.5, inertia=1e-3)
    follower = fm.RigidBody("follower", at=(0.0, radius), mass=mass, inertia=1e-4)
    face, profile = fm.Line((-0.1, radius), (0.1, radius)), fm.cams.flat_profile(lift, radius)
    ends = {"at": (0.0, 0.2), "to": (0.0, radius)}
    mech = fm.Mechanism("valve", [
        cam, follower, fm.Revolute("axis", fm.GROUND, cam, at=(0.0, 0.0)),
        fm.Prismatic("guide", fm.GROUND, follower, along=(0.0, 1.0)),
        fm.CurveOnCurve("tappet", cam, profile, follower, face),
        fm.SpringDamper("spring", fm.GROUND, follower, **ends, stiffness=spring, free_length=0.2),
        fm.Drive("motor", "axis", fm.ConstantSpeed(speed)),
    ])  # fmt: skip
    sol = fm.simulate(mech, periods=1, method=fm.RadauIIA(), step=fm.Adaptive(rtol=1e-8), save=756)
    laws = np.array([lift.at(speed * t) for t in sol.time])
    exact = mass * speed**2 * laws[:, 2] + spring * (laws[:, 0] + radius)
    assert sol["tappet.force"].values == pytest.approx(exact, abs=1e-5 * np.abs(exact).max())


@pytest.mark.parametrize("step", [1e-3, None])
def test_a_mechanism_without_forces_stays_at_rest(step):
    """No acceleration sets the scale of a correction; such a run stopped as not finite with fixed steps."""
    link = fm.RigidBody("link", (0.25, 0.0), mass=1.0, inertia=0.02)
    pin = fm.Revolute("pin", fm.GROUND, link, at=(0.0, 0.0))
    sol = fm.simulate(fm.Mechanism("rest", [link, pin]), t_end=0.05, method=RADAU, step=step)
    assert sol.ok, sol.status
    assert not sol.array("link.theta").any()


def test_a_light_journal_in_oil():
    """A gram moves as its film lets it, and its accelerations are errors of velocities over the step.

    Stages with such accelerations lie where the film cavitates: steps of 5e-4 s fell to 3e-7 s, 65,698 in all,
    and the speed was off by 1e-3.
    """
    shaft, film = fm.RigidBody("shaft", (0.0, 0.0), 1e-3, 1e-5), fm.ShortBearing(viscosity=0.02, width=0.01)
    walls = fm.KelvinVoigt(1e8, 1e3, ramp=1e-7)
    oil = {"clearance": 5e-5, "bearing_radius": 0.01, "normal": walls, "film": film, "start": (1e-5, -2e-5)}
    bearing = fm.JournalBearing("B", fm.GROUND, shaft, at=(0.0, 0.0), **oil)
    swing = fm.Force("swing", shaft, at=(0.0, 0.0), force=(30.0, 0.0), history=fm.drives.Harmonic(1.0, 7.0))
    weight, torque = fm.Force("weight", shaft, at=(0.0, 0.0), force=(0.0, -40.0)), fm.Torque("torque", shaft, 0.02)
    mechanism = fm.Mechanism("journal", [shaft, bearing, swing, weight, torque])
    fine = fm.simulate(mechanism, t_end=0.1, method=fm.RadauIIA(), step=fm.Adaptive(rtol=1e-7))
    sol = fm.simulate(mechanism, t_end=0.1, method=fm.RadauIIA(), max_steps=400)
    assert sol.ok, sol.status
    assert sol.array("shaft.omega")[-1] == pytest.approx(fine.array("shaft.omega")[-1], rel=1e-5)


def test_stresses_between_steps_are_those_of_the_steps():
    """A rod of 16 elements: its stiff modes, which the steps pass, are no stress at saved instants within them."""
    crank = fm.RigidLink("crank", (0.0, 0.0), (0.05, 0.0), mass=0.2, inertia=1e-4)
    bar = fm.Rectangle(width=0.01, height=0.012)
    rod = fm.FlexibleLink(
        "rod", (0.05, 0.0), (0.25, 0.0), section=bar, material=fm.STEEL, elements=16, damping=2e-5, stress=True
    )
    slider = fm.RigidBody("slider", at=(0.25, 0.0), mass=0.3, inertia=1e-4)
    joints = [
        fm.Revolute("O", fm.GROUND, crank, at=(0.0, 0.0)),
        fm.Revolute("A", crank, rod, at=(0.05, 0.0)),
        fm.Revolute("B", rod, slider, at=(0.25, 0.0)),
        fm.Prismatic("G", fm.GROUND, slider, along=(1.0, 0.0)),
        fm.Drive("motor", joint="O", motion=fm.drives.CycloidalRamp(100.0, time=0.02)),
    ]
    mechanism = fm.Mechanism("crank", [crank, rod, slider, *joints], gravity=(0.0, -9.81))
    fine = fm.simulate(mechanism, t_end=0.06, save=60, method=fm.RadauIIA(), step=fm.Adaptive(rtol=1e-8)).require()
    sol = fm.simulate(mechanism, t_end=0.06, save=60, method=fm.RadauIIA()).require()
    largest = fine.peak("rod.von_mises").value
    assert sol.peak("rod.von_mises").value == pytest.approx(largest, rel=1e-3)
    assert np.abs(sol.array("rod.von_mises") - fine.array("rod.von_mises")).max() < 2e-3 * largest
