"""Controlled steps through impacts: exact bounces, energy, restitution, grazing, walls of any stiffness, a floor."""

import math

import numpy as np
import pytest
from scipy.special import gamma

import flexmb as fm
from flexmb.engine.step.step_size import IMPACT_STEPS

MASS, SPEED, PLAY = 0.5, 1.5, 1e-3


def ball(law, *, velocity=(SPEED, 0.0, 0.0), gravity=(0.0, 0.0)):
    """A ball in a round bearing that stands still; without gravity it flies to and fro along its first velocity."""
    body = fm.RigidBody("ball", (0.0, 0.0), MASS, 1.0, velocity=velocity)
    joint = fm.RevoluteClearance("J", fm.GROUND, body, (0.0, 0.0), clearance=PLAY, bearing_radius=0.02, normal=law)
    return fm.Mechanism("ball", (body, joint), gravity=gravity)


def hertz(stiffness, restitution=1.0):
    return fm.LankaraniNikravesh(stiffness=stiffness, restitution=restitution, least_approach=0.0)


def elastic_duration(stiffness, n, mass=MASS, speed=SPEED):
    """Duration of an elastic impact with N = K depth^n.

    Energy gives the depth d = ((n + 1) m v^2 / (2 K))^(1/(n + 1)) and the time 2 d/v times the integral of
    1/sqrt(1 - s^(n+1)) over s = 0..1, which is a beta function; n = 1: pi sqrt(m/K).
    """
    depth = ((n + 1) * mass * speed**2 / (2 * stiffness)) ** (1 / (n + 1))
    p = 1 / (n + 1)
    return 2 * depth / speed * math.sqrt(math.pi) * p * gamma(p) / gamma(p + 0.5)


def inside(sol, name):
    """Accepted steps within each finished episode, and depth after the first of them."""
    depth = sol.array(f"{name}.penetration")
    rows = [(sol.time >= e.start) & (sol.time <= e.end) for e in sol.episodes(name) if not math.isnan(e.end)]
    return [int(row.sum()) for row in rows], [float(depth[row][0]) for row in rows]


# Bounces between the walls


def thrown(rtol, bounces):
    """Error of position and speed in the middle of the flight after so many bounces of a Hertzian contact."""
    stiffness = 1e9
    period = elastic_duration(stiffness, 1.5) + 2 * PLAY / SPEED
    sol = fm.simulate(ball(hertz(stiffness)), t_end=bounces * period, step=fm.Adaptive(rtol=rtol), save="steps")
    assert sol.ok, sol.status
    assert len(sol.episodes("J")) == bounces
    assert min(inside(sol, "J")[0]) >= IMPACT_STEPS * min((1e-4 / rtol) ** (1 / 3), 1.0)
    way = (-1) ** bounces
    return abs(sol.array("ball.x")[-1]), abs(way * sol.array("ball.vx")[-1] - SPEED) / SPEED, sol.stats.steps


def test_the_error_of_bounces_falls_with_rtol():
    """Local errors are of third order in the step, the error of a run of second: its slope over rtol is 2/3."""
    rtol = np.array([1e-4, 1e-5, 1e-6, 1e-7, 1e-8])
    found = np.array([thrown(r, 4) for r in rtol])
    slopes = [np.polyfit(np.log(rtol), np.log(found[:, k]), 1)[0] for k in (0, 1)]
    print("\nrtol, position, speed, steps:\n", np.column_stack([rtol, found]), "\nslopes", slopes)
    assert min(slopes) > 0.6, slopes
    assert max(slopes) < 0.8, slopes
    assert found[0, 1] < 4e-4
    assert found[-1, 1] < 1e-6


def test_impacts_without_loss_keep_their_energy_by_default():
    """Ten bounces: less than 3.5e-4 of the energy lost or won in each.

    It scatters with the instants at which the flights' steps meet the wall: 7e-4, 2.6e-3, 2.7e-3, -8e-4 after all ten
    for largest steps of 1/250, 1/500, 1/1000, 1/2000 of the run.
    """
    start = 0.5 * MASS * SPEED**2
    period = elastic_duration(1e9, 1.5) + 2 * PLAY / SPEED
    sol = fm.simulate(ball(hertz(1e9)), t_end=10 * period)
    assert len(sol.episodes("J")) == 10
    assert abs(sol.array("energy.kinetic")[-1] / start - 1.0) < 10 * 3.5e-4


@pytest.mark.parametrize("stiffness", [1e5, 1e8, 1e11, 1e14])
def test_a_linear_wall_of_any_stiffness(stiffness):
    """Half a period of the oscillator m, K: pi sqrt(m/K).  The spring jumps in its slope at both ends."""
    law = fm.KelvinVoigt(stiffness=stiffness, damping=0.0)
    duration = elastic_duration(stiffness, 1.0)
    assert duration == pytest.approx(math.pi * math.sqrt(MASS / stiffness), rel=1e-12)
    sol = fm.simulate(ball(law), t_end=2 * PLAY / SPEED + duration, step=fm.Adaptive(max=5e-4), save="steps")
    (impact,) = sol.episodes("J")
    assert impact.duration == pytest.approx(duration, rel=2e-3)
    assert impact.restitution == pytest.approx(1.0, abs=2e-4)
    steps, first = inside(sol, "J")
    assert steps[0] >= IMPACT_STEPS
    assert first[0] <= SPEED * duration / IMPACT_STEPS
    if stiffness > 1e5:  # the softest one is 5 mm deep: there the error of positions asks for more
        assert steps[0] < 1.5 * IMPACT_STEPS
        assert sol.stats.steps < steps[0] + 100


def test_a_stiff_impact_returns_what_its_law_says():
    """Restitution 1/2 at a stiffness of 1e14 N/m^1.5: without the onset located .530 came out."""
    law = fm.contact.ExactRestitution(stiffness=1e14, restitution=0.5)
    sol = fm.simulate(ball(law), t_end=2.5e-3)
    (impact,) = sol.episodes("J")
    assert impact.restitution == pytest.approx(0.5, abs=1e-3)
    assert -sol.array("ball.vx")[-1] / SPEED == pytest.approx(0.5, abs=1e-3)


def test_a_damper_that_acts_from_the_first_touch_on():
    """The force jumps at the touch: the step ends there, and the next one starts anew, so that second order is kept."""
    law = fm.KelvinVoigt.for_restitution(1e8, 0.5, MASS)
    errors = []
    for rtol in (1e-4, 1e-6):
        sol = fm.simulate(ball(law), t_end=2.5e-3, step=fm.Adaptive(rtol=rtol))
        errors.append(abs(-sol.array("ball.vx")[-1] / SPEED - 0.5))
    assert errors[0] < 1e-3
    assert errors[1] < 0.1 * errors[0]  # 100^(2/3) = 22 times smaller


def test_walls_of_very_different_stiffness():
    """Two balls, each in its bearing: each impact is resolved by steps of its own."""
    stiffness = {"soft": 1e5, "hard": 1e11}
    parts = []
    for k, (name, K) in enumerate(stiffness.items()):
        law = fm.KelvinVoigt(stiffness=K, damping=0.0)
        body = fm.RigidBody(name, (float(k), 0.0), MASS, 1.0, velocity=(SPEED * (1.0 + 0.3 * k), 0.0, 0.0))
        options = {"clearance": PLAY, "bearing_radius": 0.02, "normal": law}
        parts += [body, fm.RevoluteClearance(f"J-{name}", fm.GROUND, body, (float(k), 0.0), **options)]
    sol = fm.simulate(fm.Mechanism("two", tuple(parts)), t_end=2e-2, save="steps")
    assert sol.ok, sol.status
    for name, K in stiffness.items():
        done = [e for e in sol.episodes(f"J-{name}") if not math.isnan(e.end)]
        assert len(done) >= 2
        for impact in done:
            assert impact.duration == pytest.approx(math.pi * math.sqrt(MASS / K), rel=3e-3)
            assert impact.restitution == pytest.approx(1.0, abs=5e-4)
        assert min(inside(sol, f"J-{name}")[0]) >= IMPACT_STEPS


# Grazing


@pytest.mark.parametrize("depth", [1e-9, 1e-7, 1e-5])
def test_a_graze_between_two_steps_is_not_missed(depth):
    """Thrown up against gravity with just the speed that lets it rise `depth` beyond the wall, for sqrt(8 depth/g).

    The Hertzian wall is so soft at such depths (K depth^1.5 against m g) that the flight is hardly changed: by parts of
    the size K depth^1.5 / (m g), which is 1e-5 for 1e-9 m.  The largest step is 175 times as long as that graze.
    """
    g, law = 9.81, hertz(1e9)
    speed = math.sqrt(2 * g * (PLAY + depth))
    mechanism = ball(law, velocity=(0.0, speed, 0.0), gravity=(0.0, -g))
    sol = fm.simulate(mechanism, t_end=0.025, step=fm.Adaptive(max=5e-3), save="steps")
    assert sol.stats.largest_step > 2.5e-3
    (graze,) = sol.episodes("J")
    assert graze.approach_speed == pytest.approx(math.sqrt(2 * g * depth), rel=1e-4)
    assert graze.start == pytest.approx(speed / g - math.sqrt(2 * depth / g), rel=1e-6)
    assert inside(sol, "J")[0][0] >= IMPACT_STEPS
    if depth == 1e-9:
        assert graze.duration == pytest.approx(math.sqrt(8 * depth / g), rel=1e-3)
        assert graze.peak_penetration == pytest.approx(depth, rel=1e-3)
    assert -sol.array("ball.vy")[-1] == pytest.approx(g * (0.025 - graze.end) + graze.separation_speed, rel=1e-6)


def test_a_flight_that_just_does_not_touch():
    g = 9.81
    mechanism = ball(hertz(1e9), velocity=(0.0, math.sqrt(2 * g * (PLAY - 1e-9)), 0.0), gravity=(0.0, -g))
    sol = fm.simulate(mechanism, t_end=0.025, step=fm.Adaptive(max=5e-3))
    assert len(sol.episodes("J")) == 0


# A floor


def test_a_floor_that_the_impact_cannot_pass_is_named():
    sol = fm.simulate(ball(hertz(1e14)), t_end=2e-3, step=fm.Adaptive(max=1e-4, min=1e-5))
    assert not sol.ok
    assert "the impact of 'J' (gap " in sol.status
    assert "gap rate -1.5 m/s) needs steps of " in sol.status
    assert "Tried: with step=Adaptive(rtol=0.0001, max=0.0001, min=1e-08) the run gets past this instant" in sol.status
    needed = float(sol.status.partition("needs steps of ")[2].split(" s")[0])
    assert needed < 1e-5
    again = fm.simulate(ball(hertz(1e14)), t_end=2e-3, step=fm.Adaptive(max=1e-4, min=0.01 * needed))
    assert again.ok, again.status
