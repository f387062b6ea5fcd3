"""What lies between two steps: contacts that a step would hop over, loads that it would not see, jumps of laws."""

import math

import numpy as np
import pytest

import flexmb as fm
from flexmb.errors import InputError

SPEED = 10.0

RADAU = fm.RadauIIA()


def thrown(law, *, radius=0.01, thickness=0.02, start=-1.0, speed=SPEED):
    """A ball that flies towards a wall 2 m from the origin."""
    wall = fm.cams.Outline(((2.0, -1.0), (2.0 + thickness, -1.0), (2.0 + thickness, 1.0), (2.0, 1.0)))
    body = fm.RigidBody("ball", at=(start, 0.0), mass=0.03, inertia=1e-6, velocity=(speed, 0.0, 0.0))
    circle = fm.cams.Circle((start, 0.0), radius)
    return fm.Mechanism("thrown", [body, fm.cams.OutlineContact("wall", fm.GROUND, wall, body, circle, normal=law)])


@pytest.mark.parametrize("method", [None, RADAU], ids=["Newmark", "Radau"])
@pytest.mark.parametrize(("radius", "thickness"), [(0.01, 0.02), (1e-3, 1e-3)])
def test_a_ball_does_not_fly_through_a_wall(radius, thickness, method):
    """One run of 10 s, whose steps may be 0.04 s, or 0.4 m, long; the restitution is that of the law."""
    law = fm.KelvinVoigt.for_restitution(1e8, 0.8, 0.03)
    sol = fm.simulate(thrown(law, radius=radius, thickness=thickness), t_end=10.0, method=method)
    assert sol.ok, sol.status
    assert sol.array("ball.vx")[-1] == pytest.approx(-0.8 * SPEED, rel=2e-3)
    assert sol.stats.steps < 500


@pytest.mark.parametrize("radius", [0.0, 0.01])
@pytest.mark.parametrize("method", [None, RADAU], ids=["Newmark", "Radau"])
def test_an_open_pair_of_curves_is_met(radius, method):
    """A spring returns the ball at its speed; steps of 1/250 of the run would be 0.4 m long, the curve is 0.04 m."""
    turn = np.linspace(0.0, 2.0 * math.pi, 60, endpoint=False)
    curve = fm.cams.ClosedCurve([(0.02 * math.cos(a), 0.02 * math.sin(a)) for a in turn])
    body = fm.RigidBody("ball", at=(-1.0, 0.0), mass=0.1, inertia=1e-5, velocity=(20.0, 0.0, 0.0))
    laws = {"normal": fm.KelvinVoigt(1e7, 0.0), "start": "open"}
    if radius > 0.0:
        pair = fm.cams.CurveOnCurve("pair", fm.GROUND, curve, body, fm.cams.Circle((-1.0, 0.0), radius), **laws)
    else:
        pair = fm.cams.PointOnCurve("pair", fm.GROUND, curve, body, at=(-1.0, 0.0), **laws)
    sol = fm.simulate(fm.Mechanism("open", [body, pair]), t_end=5.0, method=method)
    assert sol.ok, sol.status
    assert sol.array("ball.vx")[-1] == pytest.approx(-20.0, rel=1e-4)


def test_an_outline_meets_another_at_100_m_a_second():
    """An elastic law returns the block at its speed."""
    block = fm.cams.Outline(((-0.52, -0.01), (-0.5, -0.01), (-0.5, 0.01), (-0.52, 0.01)))
    wall = fm.cams.Outline(((0.0, -0.1), (0.02, -0.1), (0.02, 0.1), (0.0, 0.1)))
    body = fm.RigidBody("block", at=(-0.51, 0.0), mass=1.0, inertia=1e-4, velocity=(100.0, 0.0, 0.0))
    law = fm.KelvinVoigt(1e9, 0.0)
    pair = fm.cams.OutlineOnOutline("pair", fm.GROUND, wall, body, block, normal=law)
    for t_end in (0.02, 1.0):
        sol = fm.simulate(fm.Mechanism("block", [body, pair]), t_end=t_end)
        assert sol.ok, sol.status
        assert sol.array("block.vx")[-1] == pytest.approx(-100.0, rel=2e-3)


@pytest.mark.parametrize("method", [None, fm.RungeKutta4()], ids=["Newmark", "Runge-Kutta"])
def test_a_contact_that_a_fixed_step_hops_over_is_told(method):
    """From 0.2 m before the wall to 0.3 m behind in one step of 0.05 s."""
    mechanism = thrown(fm.KelvinVoigt(1e8, 0.0), start=-1.2)
    sol = fm.simulate(mechanism, t_end=1.0, step=0.05, method=method)
    assert sol.array("ball.vx")[-1] == pytest.approx(SPEED, rel=1e-12)  # it has not met the wall
    assert not sol.ok
    assert "went by the contact 'wall'" in sol.status
    away = fm.simulate(thrown(fm.KelvinVoigt(1e8, 0.0), speed=-SPEED), t_end=1.0, step=0.05, method=method)
    assert away.ok, away.status


# Jumps of contact laws


def swinging(law, friction, clearance=5e-4):
    """A pendulum in a worn bearing."""
    rod = fm.RigidLink("rod", (0.0, 0.0), (0.3 * math.cos(0.8), -0.3 * math.sin(0.8)), 1.0, 7.5e-3)
    laws = {"normal": law, "friction": fm.ModifiedCoulomb(friction, v0=1e-4, v1=1e-3)}
    joint = fm.RevoluteClearance("J", fm.GROUND, rod, (0.0, 0.0), clearance=clearance, bearing_radius=0.01, **laws)
    return fm.Mechanism("swinging", [rod, joint], gravity=(0.0, -9.81))


@pytest.mark.parametrize("rtol", [1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7])
def test_a_step_onto_an_onset_books_no_jump(rtol):
    """At rtol = 3e-5 steps of 0.3 ms ended 4e-15 m deep; half of the jump over them was 4e-4 J, 1 % of all work."""
    sol = fm.simulate(swinging(fm.KelvinVoigt(1e8, 2e3), 0.05), t_end=0.3, step=fm.Adaptive(rtol=rtol))
    assert sol.ok, sol.status
    turned = sol.array("energy.turned_over")[-1]
    assert np.abs(sol.array("energy.residual")).max() < 1e-6 * turned
    assert abs(sol.array("energy.dissipated_algorithm")[-1]) < 1e-3 * turned


@pytest.mark.quick(2)
@pytest.mark.parametrize("stiffness", [1e7, 1e8])
@pytest.mark.parametrize("damping", [1e3, 5e3, 2e4])
def test_a_grid_of_laws_with_a_jump_runs(stiffness, damping):
    """36 points with the other friction and clearances."""
    for friction in (0.05, 0.3):
        for clearance in (1e-4, 2e-4, 5e-4):
            mechanism = swinging(fm.KelvinVoigt(stiffness, damping), friction, clearance)
            sol = fm.simulate(mechanism, t_end=0.3, signals=["energy.*"])
            assert sol.ok, (friction, clearance, sol.status)
            share = sol.array("energy.dissipated_algorithm")[-1] / sol.array("energy.turned_over")[-1]
            assert abs(share) < 4e-3, (friction, clearance)


def test_the_advice_is_not_what_was_just_done():
    """Where the energies do not add up although rtol was made smaller, a still smaller one is no advice."""
    from flexmb.results.status import finer_steps

    assert "rtol=1e-05" in finer_steps(1e-4)
    assert "smaller rtol" not in finer_steps(1e-6)
    assert "Adaptive" in finer_steps(1.0)


def test_the_least_step_is_the_round_off_of_the_time():
    """1e-3 of a step of an impact of 1 us at t = 1 s is 3e-11 s; the default least step was up to 1e-12 of the run."""
    law = fm.contact.ExactRestitution(stiffness=1e14, restitution=0.1)
    sol = fm.simulate(thrown(law), t_end=10.0)
    assert sol.ok, sol.status
    with pytest.raises(InputError, match="min"):
        fm.Adaptive(min=0.0)


# Loads


def shaken(history, speed=SPEED):
    """A mass of 1 kg under a force of 0.5 N with a history."""
    body = fm.RigidBody("b", at=(0.0, 0.0), mass=1.0, inertia=1e-3, velocity=(speed, 0.0, 0.0))
    return fm.Mechanism("shaken", [body, fm.Force("F", body, force=(0.5, 0.0), at=(0.0, 0.0), history=history)])


def way(frequency, t):
    """x - v0 t of a mass of 1 kg from 0.5 N sin(w t): 0.5 (t/w - sin(w t)/w^2)."""
    w = 2.0 * math.pi * frequency
    return 0.5 * (t / w - math.sin(w * t) / w**2)


@fm.kernels.drive_kernel
def hum_kernel(p, t):
    """A sine."""
    return math.sin(p[0] * t), p[0] * math.cos(p[0] * t), -p[0] * p[0] * math.sin(p[0] * t)


class Hum(fm.Motion):
    """A history without a period that is told."""

    kernel = hum_kernel

    def parameters(self):
        return (2.0 * math.pi * 1000.0,)


@pytest.mark.quick(5)
@pytest.mark.parametrize("method", [None, RADAU], ids=["Newmark", "Radau"])
@pytest.mark.parametrize("frequency", [1000.0, 5000.0, 20000.0])
def test_a_fast_load_is_followed(frequency, method):
    """Whose period is that of the steps, or a fraction of it; it ended some 450 times, or 43 % of v t, off."""
    sol = fm.simulate(shaken(fm.drives.Harmonic(1.0, frequency=frequency)), t_end=0.2, method=method)
    assert sol.ok, sol.status
    assert sol.array("b.x")[-1] - SPEED * 0.2 == pytest.approx(way(frequency, 0.2), rel=0.02)
    assert sol.stats.largest_step <= 0.05001 / frequency


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["own", "table"])
def test_a_fast_load_without_a_period_is_followed(kind):
    times = np.arange(0.0, 0.2 + 2.5e-5, 5e-5)
    table = fm.drives.Table(tuple(times), tuple(np.sin(2.0 * math.pi * 1000.0 * times)))
    sol = fm.simulate(shaken(Hum() if kind == "own" else table), t_end=0.2)
    assert sol.ok, sol.status
    assert sol.array("b.x")[-1] - SPEED * 0.2 == pytest.approx(way(1000.0, 0.2), rel=0.03)


@pytest.mark.slow
def test_points_of_a_table_that_say_nothing_cost_no_steps():
    """A slow sine at 20,001 points, with noise of 0.1 %."""
    times, noise = np.linspace(0.0, 1.0, 20001), np.random.default_rng(1).normal(0.0, 1e-3, 20001)
    sol = fm.simulate(shaken(fm.drives.Table(tuple(times), tuple(np.sin(6.0 * times) + noise))), t_end=1.0)
    assert sol.stats.steps < 1100


@pytest.mark.parametrize("method", [None, RADAU, fm.RungeKutta4()], ids=["Newmark", "Radau", "Runge-Kutta"])
def test_fixed_steps_that_do_not_see_a_load_are_refused_or_told(method):
    with pytest.raises(InputError, match=r"fixed step of 0.001 s is 1 cycles of Harmonic.*Take steps of 5e-05 s"):
        fm.simulate(shaken(fm.drives.Harmonic(1.0, frequency=1000.0)), t_end=1.0, step=1e-3, method=method)
    with pytest.raises(InputError, match="see another motion"):
        fm.simulate(shaken(Hum()), t_end=1.0, step=1e-3, method=method)
    sol = fm.simulate(shaken(fm.drives.Harmonic(1.0, frequency=1000.0)), t_end=0.1, step=2e-4, method=method)
    assert any("few steps see the motion" in note for note in sol.notes)
    sol = fm.simulate(shaken(fm.drives.Harmonic(1.0, frequency=1000.0)), t_end=0.1, step=1e-4, method=method)
    assert sol.notes == ()


# Scales


def test_a_fast_rotor_does_not_excuse_the_ball_beside():
    """Its rim moves at thousands of m/s; the ball, which nothing connects to it, bounced with 0.859 for 0.833."""
    law = fm.HuntCrossley(1e8, restitution=0.8)
    ball = fm.RigidBody("ball", (0.0, 0.0), 1.0, 1.0, velocity=(1.0, 0.0, 0.0))
    play = {"clearance": 1e-3, "bearing_radius": 0.01, "normal": law}
    alone = [ball, fm.RevoluteClearance("J", fm.GROUND, ball, (0.0, 0.0), **play)]
    rotor = fm.RigidBody("rotor", (0.5, 0.0), 1.0, 1e-3, velocity=(0.0, 0.0, 1e4))
    beside = [*alone, rotor, fm.Revolute("R", fm.GROUND, rotor, (0.5, 0.0))]
    runs = [fm.simulate(fm.Mechanism("m", parts), t_end=5e-3) for parts in (alone, beside)]
    found = [sol.episodes("J")[0].restitution for sol in runs]
    assert found[1] == pytest.approx(found[0], abs=2e-4)
