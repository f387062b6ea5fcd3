"""The ledger of energies: accounts in closed form, what it leaves over and at which order, what mistakes show in it."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from spin_up import spinning_beam

import flexmb as fm
from flexmb.mechanisms import nine_bar

G = 9.81
UNSEEN = 2e-9
"""Residual of exact rules: an accepted step may lack 1e-10 of h^2 a (`REMAINING_ERROR` of Newton's tolerance), and
energies are those of the state before a last correction of up to 5e-8 of h^2 a (`NEGLIGIBLE_CORRECTION`)."""
ALPHA, TRAPEZOIDAL, RK4 = fm.Newmark.generalised_alpha(0.8), fm.Newmark.trapezoidal(), fm.RungeKutta4()
rules = pytest.mark.parametrize("method", [ALPHA, TRAPEZOIDAL, RK4], ids=["alpha", "trapezoidal", "rk4"])


def last(sol, name):
    return float(sol.array(f"energy.{name}")[-1])


def missing(sol):
    """Largest residual over the energy turned over in the whole run."""
    return sol.peak("energy.residual").value / last(sol, "turned_over")


# Accounts in closed form.


@rules
def test_a_falling_stone_turns_over_its_height(method):
    """m g H from gravity to motion, counted once."""
    stone = fm.RigidBody("stone", (0.0, 0.0), mass=3.0, inertia=0.2, velocity=(1.0, 0.0, -6.0))
    sol = fm.simulate(fm.Mechanism("fall", (stone,), gravity=(0.0, -G)), t_end=2.0, step=1e-2, method=method)
    assert last(sol, "turned_over") == pytest.approx(3.0 * G * 0.5 * G * 2.0**2, rel=1e-12)
    assert missing(sol) < 1e-13
    assert sol.status == "Finished at t = 2 s."


@rules
def test_an_oscillator_turns_over_four_times_its_energy_in_a_period(method):
    """From spring to mass and back, twice: 4 E.  A potential of second degree leaves no residual."""
    mass, k, amplitude = 2.0, 800.0, 0.1
    body = fm.RigidBody("slider", (0.6, 0.0), mass, 1.0)
    spring = fm.SpringDamper("S", fm.GROUND, body, (0.0, 0.0), (0.6, 0.0), stiffness=k, free_length=0.6 - amplitude)
    mech = fm.Mechanism("oscillator", (body, spring, fm.Prismatic("guide", fm.GROUND, body)))
    period = 2.0 * math.pi / math.sqrt(k / mass)
    sol = fm.simulate(mech, t_end=5 * period, step=period / 400, save="steps", method=method)
    energy = 0.5 * k * amplitude**2
    assert last(sol, "turned_over") == pytest.approx(5 * 4 * energy, rel=2e-4)
    if method is not RK4:
        assert missing(sol) < UNSEEN


def test_friction_takes_the_force_times_the_way():
    """A block of 2 kg slides 0.5 g with mu = 0.2 and friction force mu m g: work mu m g times the distance it moved."""
    block = fm.RigidBody("block", (0.0, 0.0), 2.0, 1.0, velocity=(3.0, 0.0, 0.0))
    law = fm.ModifiedCoulomb(0.2, v0=0.0, v1=1e-3)
    guide = fm.Prismatic("guide", fm.GROUND, block, friction=law, length=0.1)
    sol = fm.simulate(fm.Mechanism("block", (block, guide), gravity=(0.0, -G)), t_end=0.5, step=1e-2)
    way = 3.0 * 0.5 - 0.5 * 0.2 * G * 0.5**2
    assert sol.array("block.x")[-1] == pytest.approx(way, rel=1e-12)
    assert last(sol, "dissipated_friction") == pytest.approx(0.2 * 2.0 * G * way, rel=1e-12)
    assert last(sol, "turned_over") == pytest.approx(last(sol, "dissipated_friction"), rel=1e-12)


def test_a_dashpot_takes_what_the_exact_motion_says():
    """m v' = -d v: the dashpot has taken m v0^2/2 (1 - e^(-2 d t/m)); second order in the step."""
    mass, d, v0, t_end = 2.0, 6.0, 1.5, 0.4
    taken, rest = [], []
    for step in (0.02, 0.01):
        body = fm.RigidBody("slider", (1.0, 0.0), mass, 1.0, velocity=(v0, 0.0, 0.0))
        dashpot = fm.SpringDamper("D", fm.GROUND, body, (0.0, 0.0), (1.0, 0.0), stiffness=0.0, damping=d)
        mech = fm.Mechanism("dashpot", (body, dashpot, fm.Prismatic("guide", fm.GROUND, body)))
        sol = fm.simulate(mech, t_end=t_end, step=step, method=TRAPEZOIDAL)
        taken.append(last(sol, "dissipated_damping"))
        rest.append(missing(sol))
    exact = 0.5 * mass * v0**2 * (1.0 - math.exp(-2.0 * d * t_end / mass))
    assert taken[1] == pytest.approx(exact, rel=1e-4)
    assert (taken[0] - exact) / (taken[1] - exact) == pytest.approx(4.0, rel=0.05)
    assert max(rest) < 1e-13  # the mean rate times the mean force: nothing is missing whatever the step


@fm.element_kernel
def thrust_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    r[0] = -p[0] * math.cos(p[1] * t)


@dataclass(frozen=True)
class Thrust(fm.Element):
    """A force along X that varies in time, without an account of its own."""

    body: fm.Part
    force: float
    rate: float
    kernel = thrust_kernel
    coords = ("body.x",)


@pytest.mark.parametrize("step", [0.02, fm.Adaptive(max=0.02)], ids=["fixed", "adaptive"])
@pytest.mark.parametrize("method", [ALPHA, TRAPEZOIDAL], ids=["alpha", "trapezoidal"])
def test_work_of_an_element_without_an_account_is_what_moved_the_body(method, step):
    """v = F/(m w) sin w t, so the work is m v^2/2; nothing is missing."""
    body = fm.RigidBody("body", (0.0, 0.0), 2.0, 1.0)
    mech = fm.Mechanism("thrust", (body, Thrust("thrust", body, 5.0, 3.0)))
    sol = fm.simulate(mech, t_end=1.7, step=step, method=method)
    assert last(sol, "load_work") == pytest.approx(0.5 / 2.0 * (5.0 / 3.0 * math.sin(3.0 * 1.7)) ** 2, rel=3e-3)
    assert missing(sol) < UNSEEN


def ball(step, *, restitution=1.0, method=ALPHA, t_end=2e-3, mass=1.0, K=1e12, play=2e-4):
    """A ball of 1 kg and 1 m/s flies against a wall: Hertz' law, an impact of about 50 us, 15 um deep."""
    stone = fm.RigidBody("ball", (0.0, 0.0), mass, 1.0, velocity=(1.0, 0.0, 0.0))
    law = fm.LankaraniNikravesh(stiffness=K, restitution=restitution, least_approach=0.0)
    joint = fm.RevoluteClearance("J", fm.GROUND, stone, (0.0, 0.0), clearance=play, bearing_radius=1e-2, normal=law)
    return fm.simulate(fm.Mechanism("ball", (stone, joint)), t_end=t_end, step=step, method=method, save="steps")


@rules
def test_an_elastic_law_takes_nothing_whatever_the_step(method):
    """What steps of 1/10 of an impact make of its energy is the algorithm's, not the law's."""
    sol = ball(5e-6, method=method, t_end=5e-4)
    assert sol.array("J.normal_force")[-1] == 0.0
    assert sol.array("ball.vx")[-1] < -0.9
    speeds = 0.5 * (1.0 - sol.array("ball.vx")[-1] ** 2)
    assert abs(last(sol, "dissipated_contact")) < 2e-3 * 0.5
    assert last(sol, "dissipated_algorithm") + last(sol, "dissipated_contact") == pytest.approx(speeds, abs=1e-12)


def test_losses_of_episodes_add_up_to_the_ledger(slider_crank):
    sol = fm.simulate(slider_crank(), t_end=6e-3)
    episodes = sol.episodes("C")
    assert len(episodes) >= 3
    assert sum(episodes.dissipated_contact) == pytest.approx(last(sol, "dissipated_contact"), rel=1e-12)
    assert sum(episodes.dissipated_friction) == pytest.approx(last(sol, "dissipated_friction"), rel=1e-12)


# What is left over.


@pytest.mark.parametrize("method", [ALPHA, TRAPEZOIDAL], ids=["alpha", "trapezoidal"])
def test_what_is_left_of_smooth_motion_falls_at_second_order(slider_crank, method):
    """Directions of joint forces turn within a step: all that is left of a driven rigid mechanism."""
    rest = []
    for step in (4e-5, 2e-5, 1e-5):
        sol = fm.simulate(slider_crank(clearance=None), t_end=0.012, step=step, method=method)
        rest.append(missing(sol))
    assert rest[-1] < 2e-5
    np.testing.assert_allclose(np.log2(np.array(rest[:-1]) / np.array(rest[1:])), 2.0, atol=0.1)


MODELS = {
    "ideal": {},
    "clearance": {"clearance": 5e-4},
    "flexible": {"flexible": True},
    "flexible, clearance": {"flexible": True, "clearance": 5e-4},
}


@pytest.mark.slow
@pytest.mark.parametrize("options", MODELS.values(), ids=MODELS)
def test_ten_seconds_of_the_nine_bar_mechanism_leave_a_millionth(options):
    """All default settings, ten turns in 10 s; of chaotic motions, which scatter by a twentieth, the mean of four."""
    rest = []
    for k in range(4 if "clearance" in options else 1):
        sol = fm.simulate(nine_bar(speed=2.0 * math.pi * (1.0 + 1e-9 * k), **options), t_end=10.0)
        assert sol.ok, sol.status
        assert sol.status == "Finished at t = 10 s."
        rest.append(missing(sol))
    assert np.mean(rest) <= 1e-6


def test_a_turn_of_the_nine_bar_mechanism_with_play():
    """What is missing comes and goes within a turn, so after the first one it is a larger part than after ten."""
    sol = fm.simulate(nine_bar(speed=2.0 * math.pi, clearance=5e-4), t_end=1.0)
    assert sol.ok, sol.status
    assert missing(sol) <= 3e-6


def test_a_restart_goes_on_with_the_ledger_bit_for_bit(slider_crank):
    """Cut in the middle of an impact."""
    whole = fm.simulate(slider_crank(), t_end=1e-3, step=1e-6)
    cut = fm.simulate(slider_crank(), t_end=1e-3, step=1e-6, max_steps=250, save="steps")
    assert cut.array("C.normal_force")[-1] > 0.0
    rest = fm.simulate(slider_crank(), t_end=1e-3, step=1e-6, restart=cut.restart)
    for name in ("ledger", "memory"):
        np.testing.assert_array_equal(rest.restart[name], whole.restart[name])


# Mistakes show.


@fm.kernels.energy_kernel
def poor_energy(p, t, q, v):
    """The energy of a spring that is a tenth softer than the force says."""
    return 0.45 * p[0] * q[0] ** 2, 0.0, 0.0


@fm.kernels.energy_kernel
def lost_energy(p, t, q, v):
    """That of the spring, but not a number where it is pressed."""
    return (0.5 * p[0] * q[0] ** 2 if q[0] > -0.05 else math.nan), 0.0, 0.0


@fm.element_kernel
def spring_kernel(p, t, h, q, v, a, z, r, K, C, M, z_new):
    r[0] = p[0] * q[0]
    K[0, 0] = p[0]


@dataclass(frozen=True)
class PoorSpring(fm.Element):
    body: fm.Part
    k: float
    kernel = spring_kernel
    energy = poor_energy
    coords = ("body.x",)


@dataclass(frozen=True)
class LostSpring(fm.Element):
    body: fm.Part
    k: float
    kernel = spring_kernel
    energy = lost_energy
    coords = ("body.x",)


def on_a_spring(kind):
    body = fm.RigidBody("body", (0.1, 0.0), 2.0, 1.0)
    return fm.Mechanism("spring", (body, kind("spring", body, 800.0)))


def test_energies_that_do_not_belong_to_the_forces_end_the_run():
    """After a quarter of a period a tenth of k A^2/2 = 4 J is missing; the run stops, and keeps what it has."""
    sol = fm.simulate(on_a_spring(PoorSpring), t_end=10.0, step=2e-4, save="steps", method=TRAPEZOIDAL)
    assert not sol.ok
    assert 0.0 < sol.time[-1] < 1.0
    assert "energies do not add up" in sol.status
    assert "check_part" in sol.status
    stretch = 0.5 * 800.0 * (0.1**2 - sol.array("body.x") ** 2)
    np.testing.assert_allclose(sol.array("energy.residual"), 0.1 * stretch, atol=1e-11)


@fm.drive_kernel
def bump_kernel(p, t):
    x = (t - p[0]) / p[1]
    s = math.exp(-x * x)
    return s, -2.0 * x / p[1] * s, (4.0 * x * x - 2.0) / p[1] ** 2 * s


@dataclass(frozen=True)
class Bump(fm.Motion):
    """exp(-((t - middle)/width)^2)."""

    middle: float
    width: float
    kernel = bump_kernel


def test_energies_below_all_digits_are_not_judged():
    """A force of 1e-272 N grows to 1 N: early energies are 1e-320 J, whose next number is 5e-324 J away."""
    body = fm.RigidBody("body", (0.0, 0.0), 1.0, 1.0)
    push = fm.Force("push", body, at=body.at, force=(1.0, 0.0), history=Bump(5.0, 0.2))
    guide = fm.Prismatic("guide", fm.GROUND, body)
    for method in (None, fm.DormandPrince()):
        sol = fm.simulate(
            fm.Mechanism("bump", [body, guide, push]), t_end=10.0, method=method, step=fm.Adaptive(max=1e-3)
        )
        assert sol.ok, sol.status
        assert last(sol, "kinetic") == pytest.approx(0.5 * math.pi * 0.2**2, rel=1e-4)


def test_energies_that_are_not_finite_end_the_run():
    sol = fm.simulate(on_a_spring(LostSpring), t_end=10.0, step=1e-3)
    assert not sol.ok
    assert "finite" in sol.status


def test_an_impact_in_too_few_steps_is_not_ok():
    """One or two steps in an elastic impact; with some hundred, all is well."""
    coarse, fine = ball(4e-5), ball(2e-7)
    assert not coarse.ok
    assert "went through contacts" in coarse.status
    assert fine.ok
    assert fine.status == "Finished at t = 0.002 s."
    assert abs(last(fine, "dissipated_algorithm")) < 1e-4 * 0.5


def test_the_worn_slider_crank_in_steps_of_50_microseconds_is_not_ok(slider_crank):
    """Speeds of the slider far beyond those of the crank: other programs call that a success."""
    sol = fm.simulate(slider_crank(), t_end=0.024, step=5e-5)
    assert not sol.ok


def test_steps_that_make_energy_are_not_ok():
    """Newmark's rule with gamma < 1/2 is unstable: the oscillator's energy grows without any source.

    Its damping ratio is (gamma - 1/2) w h/2 (Hughes, The Finite Element Method 1987, section 9.1), so 5 % are made by
    ln(1.05)/((1/2 - gamma) w^2 h), w = 20/s.
    """
    body = fm.RigidBody("slider", (0.6, 0.0), 2.0, 1.0)
    spring = fm.SpringDamper("S", fm.GROUND, body, (0.0, 0.0), (0.6, 0.0), stiffness=800.0, free_length=0.5)
    mech = fm.Mechanism("oscillator", (body, spring, fm.Prismatic("guide", fm.GROUND, body)))
    sol = fm.simulate(mech, t_end=100.0, step=1e-3, method=fm.Newmark(beta=0.25, gamma=0.45))
    assert not sol.ok
    assert "the steps made energy" in sol.status
    assert sol.restart["clock"][0] == pytest.approx(math.log(1.05) / (0.05 * 20.0**2 * 1e-3), rel=0.02)
    assert sol.time[-1] < 100.0


def test_steps_that_take_energy_are_not_ok():
    """Newmark's rule with gamma > 1/2 damps what no part damps."""
    body = fm.RigidBody("slider", (0.6, 0.0), 2.0, 1.0)
    spring = fm.SpringDamper("S", fm.GROUND, body, (0.0, 0.0), (0.6, 0.0), stiffness=800.0, free_length=0.5)
    mech = fm.Mechanism("oscillator", (body, spring, fm.Prismatic("guide", fm.GROUND, body)))
    sol = fm.simulate(mech, t_end=5.0, step=2e-2, method=fm.Newmark(beta=0.36, gamma=0.7))
    assert not sol.ok
    assert "took energy that no law took" in sol.status


def test_what_rests_is_ok(slider_crank):
    """A block that lies still turns nothing over but round-off."""
    block = fm.RigidBody("block", (0.3, 0.7), 2.0, 1.0)
    guide = fm.Prismatic("guide", fm.GROUND, block)
    spring = fm.SpringDamper("S", fm.GROUND, block, (0.0, 0.7), (0.3, 0.7), stiffness=800.0, free_length=0.3)
    sol = fm.simulate(fm.Mechanism("rest", (block, guide, spring), gravity=(0.0, -G)), t_end=1.0, step=1e-3)
    assert sol.ok, sol.status
    assert sol.status == "Finished at t = 1 s."


def bouncing(*further):
    """A ball on a stop, with bodies beside it."""
    ball = fm.RigidBody("ball", (0.0, 0.1), mass=1.0, inertia=0.1)
    guide = fm.Prismatic("guide", fm.GROUND, ball, along=(0, 1))
    floor = fm.Stop("floor", "guide", below=-0.1, normal=fm.KelvinVoigt(1e5, 10.0))
    return fm.Mechanism("bouncing", [ball, guide, floor, *further], gravity=(0.0, -9.81))


def rotor(drive=False):
    body = fm.RigidBody("rotor", (1.0, 0.0), mass=1.0, inertia=0.1, velocity=None if drive else (0.0, 0.0, 1e4))
    pin = fm.Revolute("axis", fm.GROUND, body, at=(1.0, 0.0))
    return (body, pin, *([fm.Drive("motor", "axis", fm.ConstantSpeed(1e4))] if drive else []))


@pytest.mark.parametrize("further", [(), rotor(), pytest.param(rotor(drive=True), marks=pytest.mark.slow)])
def test_a_fast_rotor_hides_no_error_of_its_neighbour(further):
    """Steps of 2 ms add 6 % to the energy of a ball; beside 5 MJ of a rotor the run was ok."""
    sol = fm.simulate(bouncing(*further), t_end=1.0, step=2e-3)
    assert not sol.ok
    assert "the steps made energy, 0.0647 J where 1.0" in sol.status
    assert fm.simulate(bouncing(*further), t_end=0.23).ok  # through the first bounce


def test_a_spinning_beam_is_judged_by_its_own_energy():
    """Alone, what it keeps is what counts: nothing else moves, and a little of it is lost."""
    sol = fm.simulate(spinning_beam(), t_end=0.05)
    assert sol.ok, sol.status
