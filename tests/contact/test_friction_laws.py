"""Friction laws: exact values, tangents, dissipation, and blocks that creep, stick, slide and stop on a plane."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import flexmb as fm
from flexmb.errors import InputError
from flexmb.model.contributions import ContactContribution
from flexmb.model.part import Part

LAWS = {
    "ModifiedCoulomb": fm.ModifiedCoulomb(0.2, v0=1e-4, v1=1e-3),
    "SmoothCoulomb": fm.friction.SmoothCoulomb(0.2),
    "Threlfall": fm.friction.Threlfall(0.2),
    "BengisuAkay": fm.friction.BengisuAkay(0.3, 0.2),
    "Stribeck": fm.friction.Stribeck(0.3, 0.2, viscous=0.1),
    "Stribeck, exponential": fm.friction.Stribeck(0.3, 0.2, exponent=1.0),
    "BrownMcPhee": fm.friction.BrownMcPhee(0.3, 0.2, viscous=3.0),
    "LuGre": fm.friction.LuGre(0.3, 0.2, damping=50.0, viscous=0.1),
    "LuGre, most damping": fm.friction.LuGre(0.3, 0.2, damping=9.32 * 0.2 / 1e-2),
}
REGULARISED = [name for name in LAWS if not name.startswith("LuGre")]


def force(law, slip, load=1.0, h=0.0, z=()):
    """T and the history afterwards."""
    old = np.array(z or law.history())
    new = old.copy()
    return law.kernel.python(law.parameters(), h, slip, load, old, new)[0], new


# -- values ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("law", "slip", "expected"),
    [
        (fm.friction.SmoothCoulomb(0.2, v0=1e-3), 1e-3, 0.2 * 0.761594155955765),  # tanh 1
        (fm.friction.Threlfall(0.2, v0=1e-3), 1e-3, 0.2 * 0.950212931632136),  # 95 % at v0
        (fm.friction.BengisuAkay(0.3, 0.2, v0=1e-3, decay=1e3), 0.5e-3, 0.75 * 0.3),  # half way up the parabola
        (fm.friction.BengisuAkay(0.3, 0.2, v0=1e-3, decay=1e3), 1e-3, 0.3),
        (fm.friction.BengisuAkay(0.3, 0.2, v0=1e-3, decay=1e3), 1e-3 + math.log(2.0) * 1e-3, 0.25),  # a half-life later
        (fm.friction.Stribeck(0.3, 0.2, stribeck_speed=1.0, v0=1e-3), math.sqrt(math.log(2.0)), 0.25),
        (fm.friction.Stribeck(0.3, 0.2, stribeck_speed=1.0, v0=1e-3, exponent=1.0), math.log(2.0), 0.25),
        (fm.friction.Stribeck(0.3, 0.2, stribeck_speed=1e-2, viscous=0.1), 1.0, 0.3),
        (fm.friction.BrownMcPhee(0.3, 0.2, transition_speed=1e-3), 1e-3, 0.1 + 0.2 * 0.999329299739067),  # tanh 4
        (
            fm.friction.BrownMcPhee(0.3, 0.2, transition_speed=1e-3),
            3e-3,
            0.2 + 0.1 / 3.0,
        ),  # s / (s^2/4 + 3/4)^2 = 3/9 there
    ],
)
def test_value(law, slip, expected):
    for sign in (1.0, -1.0):
        assert force(law, sign * slip)[0] == pytest.approx(-sign * expected, rel=1e-10)


def test_brown_mcphee_viscous_part_fades_with_the_load():
    law = fm.friction.BrownMcPhee(0.0, 0.0, viscous=3.0, transition_load=2.0)
    assert force(law, 0.5, load=100.0)[0] == pytest.approx(-1.5, rel=1e-12)
    assert force(law, 0.5, load=0.5)[0] == pytest.approx(-1.5 * 0.761594155955765, rel=1e-12)
    assert force(law, 0.5, load=0.0)[0] == 0.0


@pytest.mark.parametrize("speed", [1e-4, 3e-3, 0.2])
@pytest.mark.parametrize("way", [1e-5, 1e-3, 1.0])
def test_lugre_ends_on_the_stribeck_curve(speed, way):
    """Steady slip: z' = 0, so T = -N (g + sigma_2 slip), whatever the step; `way` [m] is slid in each."""
    law = replace(LAWS["LuGre"], stiffness=1e5)  # bristles of 0.12 mm at most
    z = law.history()
    for _ in range(600):
        T, z_new = force(law, speed, 40.0, way / speed, z)
        z = tuple(z_new)
    g = 0.2 + 0.1 * math.exp(-((speed / 1e-2) ** 2))
    assert pytest.approx(-40.0 * (g + 0.1 * speed), rel=1e-9) == T


def test_lugre_is_a_spring_while_it_sticks():
    """A shift far below mu_s N / sigma_0 is stored: T = -sigma_0 times the shift."""
    law = fm.friction.LuGre(0.3, 0.2, stiffness=1e6)
    _, z = force(law, 1e-6, 1e4, 1e-3)
    assert force(law, 0.0, 1e4, 1e-3, tuple(z))[0] == pytest.approx(-1e6 * 1e-9, rel=1e-5)


def test_lugre_lets_go_when_the_contact_opens():
    law = fm.friction.LuGre(0.3, 0.2, stiffness=1e6, damping=50.0)
    held = (0.3 * 100.0 / 1e6, 0.0)
    for load in (10.0, 1e-3, 1e-30, 1e-250, 0.0):
        T, z = force(law, 0.0, load, 0.0, held)
        assert abs(T) <= 0.3 * load * (1 + 1e-15)
        assert abs(z[0]) <= 0.3 * load / 1e6 * (1 + 1e-15)
    assert z[0] == 0.0


# -- creep -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", REGULARISED)
@pytest.mark.parametrize("ratio", [0.01, 0.3, 0.9])
def test_creep_speed_balances_the_load(name, ratio):
    law = LAWS[name]
    static = law.parameters()[0]
    speed = law.creep_speed(ratio)
    dry = replace(law, viscous=0.0) if name == "BrownMcPhee" else law
    assert 0.0 < speed < 5e-3
    assert force(dry, speed, 7.0)[0] == pytest.approx(-ratio * static * 7.0, rel=1e-10)
    assert law.creep_speed(0.0) == 0.0
    assert law.creep_speed(1.2) == math.inf


def test_what_sticks_does_not_creep():
    assert LAWS["LuGre"].creep_speed(0.99) == 0.0
    assert LAWS["LuGre"].creep_speed(1.01) == math.inf
    assert fm.friction.Frictionless().creep_speed(0.1) == math.inf


# -- dissipation -----------------------------------------------------------------------------------------------------

speeds = st.floats(-9.0, 1.0).map(lambda e: 10.0**e)
signs = st.sampled_from([-1.0, 1.0])
loads = st.one_of(st.just(0.0), st.floats(-6.0, 6.0).map(lambda e: 10.0**e))


@given(name=st.sampled_from(REGULARISED), speed=speeds, sign=signs, load=loads)
def test_friction_opposes_the_slip(name, speed, sign, load):
    T, _ = force(LAWS[name], sign * speed, load)
    assert T * sign <= 0.0
    assert abs(T) <= 0.3 * load * (1.0 + 1e-12) + (3.0 * speed if name == "BrownMcPhee" else 0.1 * speed * load)


@given(
    name=st.sampled_from(["LuGre", "LuGre, most damping"]),
    history=st.lists(st.tuples(speeds, signs, loads), min_size=1),
    h=st.sampled_from([0.0, 1e-7, 1e-5, 1e-3, 0.1]),
    shrinking=st.sampled_from([1.0, 0.9, 0.3]),
)
def test_bristles_never_produce_energy(name, history, h, shrinking):
    """Over any slips and loads, with steps that do not grow, the work taken is at least what the bristles store.

    The work of a step is that of the rule for the bristles, h [(1 - theta) P_0 + theta P_1], P = -T slip.
    """
    law = LAWS[name]
    z, work, power, turned = law.history(), 0.0, 0.0, 0.0
    for speed, sign, load in history:
        slip = sign * speed
        T, new = force(law, slip, load, h, z)
        P = -T * slip
        assert law.stiffness * new[0] * new[1] <= P + 1e-12 * abs(P)
        g = 0.2 + 0.1 * math.exp(-((speed / 1e-2) ** 2))
        x = h * law.stiffness * speed / (g * load) if load > 0.0 else math.inf
        theta = 0.5 + x / 12.0 if x < 1e-4 else -1.0 / math.expm1(-x) - 1.0 / x
        gain = (h * (1.0 - theta) * power, h * theta * P)
        work, turned, power = work + sum(gain), turned + abs(gain[0]) + abs(gain[1]), P
        assert work >= 0.5 * law.stiffness * new[0] ** 2 - 1e-9 * turned, (speed, sign, load, h)
        assert abs(new[0]) <= law.static * load / law.stiffness * (1.0 + 1e-12)
        z, h = tuple(new), shrinking * h


def test_closed_cycles_of_bristles_lose_energy():
    """To and fro with a swelling load: all work is lost, and what is lost is less than mu_s N times the way."""
    law = LAWS["LuGre"]
    for amplitude in (1e-7, 1e-5, 1e-3):
        z, work, way, h = law.history(), 0.0, 0.0, 1e-4
        for k in range(4000):
            slip = amplitude * math.cos(2.0 * math.pi * k / 500.0) * 2.0 * math.pi / (500.0 * h)
            load = 50.0 * (1.2 + math.sin(2.0 * math.pi * k / 130.0))
            T, new = force(law, slip, load, h, z)
            z, work, way = tuple(new), work - T * slip * h, way + abs(slip) * h
        stored = 0.5 * law.stiffness * z[0] ** 2
        assert work > stored
        assert work < 0.32 * 110.0 * way


def test_too_much_damping_would_produce_energy():
    """The limit is no caution: beyond it, and with the check got round, a sudden slip is driven by the bristles."""
    law = fm.friction.LuGre(0.3, 0.2, damping=9.32 * 0.2 / 1e-2)
    p = (0.3, 0.2, 1e-2, 1e6, 40.0 * law.damping, 0.0)
    slip, load, h = 0.7e-2, 100.0, 0.0
    z = np.array([0.3 * load / 1e6, 0.0])
    T = law.kernel.python(p, h, slip, load, z, z.copy())[0]
    assert T * slip > 0.0
    assert law.kernel.python(law.parameters(), h, slip, load, z, z.copy())[0] * slip < 0.0


# -- integration of bristles -----------------------------------------------------------------------------------------

SOFT = fm.friction.LuGre(0.3, 0.2, stribeck_speed=0.05, stiffness=2e3, damping=0.5, viscous=0.1)


def after(law, slip, load, t_end, steps):
    """Force and history behind `steps` equal steps from unloaded bristles, by slip and load as functions of time."""
    _, z = force(law, slip(0.0), load(0.0))
    for k in range(1, steps + 1):
        t = t_end * k / steps
        T, z = force(law, slip(t), load(t), t_end / steps, tuple(z))
    return T, z


@pytest.mark.slow
@pytest.mark.parametrize(
    "load", [lambda t: 10.0, lambda t: 10.0 + 6.0 * math.sin(23.0 * t)], ids=["constant", "changing"]
)
@pytest.mark.parametrize("speed", [2e-3, 0.1], ids=["sticking", "sliding"])
def test_bristles_are_integrated_with_second_order(load, speed):
    """To and fro, three times, on bristles of 1.5 mm: against scipy."""

    def slip(t):
        return speed * math.cos(20.0 * t)

    def rate(t, z):
        v = slip(t)
        g = 0.2 + 0.1 * math.exp(-((v / 0.05) ** 2))
        return v - SOFT.stiffness * abs(v) * z / (g * load(t))

    exact = solve_ivp(rate, (0.0, 1.0), [0.0], method="DOP853", rtol=1e-11, atol=1e-16, max_step=1e-3).y[0, -1]
    errors = [abs(after(SOFT, slip, load, 1.0, n)[1][0] - exact) for n in (200, 400, 800)]
    assert errors[0] < 5e-3 * SOFT.static * load(1.0) / SOFT.stiffness
    assert errors[0] / errors[1] > 3.3
    assert errors[1] / errors[2] > 3.3


@pytest.mark.parametrize("steps", [20, 50])
def test_bristles_shorter_than_a_step_are_quasi_static(steps):
    """Sliding to and fro with a swelling load, bristles of 6e-8 m at most: T = -N g sign(slip) at each end of a step.

    What is left of the last force, at most mu_s 19 N, is the length of the bristles over the way of the step.
    """
    law = fm.friction.LuGre(0.3, 0.2, stribeck_speed=0.05, stiffness=1e8)
    z = law.history()
    for k in range(1, 4 * steps):
        slip, load = 0.3 * math.cos(2.0 * math.pi * (k + 0.3) / steps), 10.0 + 9.0 * math.sin(1.7 * k)
        T, z = force(law, slip, load, 1.0 / steps, tuple(z))
        g = 0.2 + 0.1 * math.exp(-((slip / 0.05) ** 2))
        left = 2.0 * 0.3 * 19.0 * (g * load / law.stiffness) * steps / abs(slip)
        assert left < 0.01
        assert pytest.approx(-load * math.copysign(g, slip), abs=left) == T


@pytest.mark.slow
def test_a_block_on_undamped_bristles_keeps_its_energy_as_on_a_spring():
    """Far below break-away, 50 periods by the trapezoidal rule, 20 steps a period: force and slip of the bristles."""
    law, mass, w = fm.friction.LuGre(0.3, 0.3, stiffness=1e4), 1.0, 100.0
    h, v, z, T = 2.0 * math.pi / (20.0 * w), 1e-6, law.history(), 0.0
    _, z = force(law, v, 1e3, 0.0, z)
    for _ in range(1000):
        low, high = -1e-5, 1e-5  # speed at the end of the step, by bisection
        for _ in range(45):
            middle = 0.5 * (low + high)
            push, new = force(law, middle, 1e3, h, tuple(z))
            low, high = (middle, high) if mass * (middle - v) < 0.5 * h * (T + push) else (low, middle)
        v, T, z = middle, push, new
    # what is lost: a block that vibrates with the amplitude A loses about A/z_most of its energy in a period
    energy = 0.5 * mass * v * v + 0.5 * law.stiffness * z[0] ** 2
    assert energy == pytest.approx(0.5 * mass * 1e-12, rel=5e-4, abs=0.0)


def vibrating_block(method, step):
    """Place of a block of 1 kg at 1 s, pushed by 0.6 N on undamped bristles of 1e4 N/m; and that by scipy."""

    def rates(t, y):
        return [y[1], 0.6 - 1e4 * y[2], y[1] - 1e4 * abs(y[1]) * y[2] / (0.3 * G)]

    exact = solve_ivp(rates, (0.0, 1.0), [0.0, 0.0, 0.0], rtol=1e-10, atol=1e-14, max_step=1e-3).y[0, -1]
    body = fm.RigidBody("block", (0.0, 0.0), 1.0, 0.01)
    law = fm.friction.LuGre(0.3, 0.3, stiffness=1e4)
    guide = fm.Prismatic("guide", fm.GROUND, body, along=(1.0, 0.0), friction=law, length=0.1)
    push = fm.Force("push", body, (0.0, 0.0), (0.6, 0.0))
    mechanism = fm.Mechanism("block", [body, guide, push], gravity=(0.0, -G))
    sol = fm.simulate(mechanism, t_end=1.0, method=method, step=step)
    assert sol.ok
    return float(sol["block.x"][-1]), exact


def test_bristles_of_a_default_run_are_right():
    """Sixteen periods below break-away, with drift: Euler's rule had an error of 35 %."""
    found, exact = vibrating_block(None, None)
    assert found == pytest.approx(exact, rel=5e-3)


@pytest.mark.slow
def test_the_error_estimate_of_radau_sees_bristles():
    """Errors fall with rtol^(1/2), and are below 2 % with default steps (2e-4 with rtol = 1e-8)."""
    for rtol in (1e-4, 1e-6, 1e-8):
        found, exact = vibrating_block(fm.RadauIIA(), fm.Adaptive(rtol=rtol))
        assert found == pytest.approx(exact, rel=2.0 * rtol**0.5)


def differences(values, x):
    """Derivative at x by values at x (1 - 4e-4), x (1 - 2e-4), x (1 + 2e-4), x (1 + 4e-4), of fourth order."""
    return (8.0 * (values[2] - values[1]) - values[3] + values[0]) / (12.0 * 2e-4 * x)


def test_derivatives_of_bristles():
    """By slip and load, behind histories of all kinds: long and short bristles, a fallen load, a turned slip."""
    law, random = LAWS["LuGre"], np.random.default_rng(1)
    near = (1.0 - 4e-4, 1.0 - 2e-4, 1.0 + 2e-4, 1.0 + 4e-4)
    for _ in range(400):
        slip, rate = (random.choice([-1.0, 1.0]) * 10.0 ** random.uniform(-6.0, 0.0) for _ in range(2))
        load, h = 10.0 ** random.uniform(-3.0, 4.0), random.choice([0.0, 1e-6, 1e-4, 1e-2])
        z = (random.choice([-1.7, -0.9, 0.0, 0.4, 1.3]) * law.static * load / law.stiffness, rate)
        T, by_slip, by_load = law.kernel.python(law.parameters(), h, slip, load, np.array(z), np.zeros(2))
        found = differences([force(law, x * slip, load, h, z)[0] for x in near], slip)
        assert by_slip == pytest.approx(found, rel=1e-7, abs=1e-7 * abs(T / slip)), (slip, load, h, z)
        found = differences([force(law, slip, x * load, h, z)[0] for x in near], load)
        assert by_load == pytest.approx(found, rel=1e-7, abs=1e-7 * abs(T / load)), (slip, load, h, z)


@pytest.mark.parametrize("load", [1e-190, 1e-30, 1.0])
@pytest.mark.parametrize("h", [0.0, 1e-9, 1.0])
def test_bristles_are_finite_under_the_smallest_loads(load, h):
    law = LAWS["LuGre"]
    for slip in (0.0, 1e-300, 1e-3, 1e3):
        new = np.zeros(2)
        found = law.kernel.python(law.parameters(), h, slip, load, np.array([1e-5, 1e-2]), new)
        assert np.isfinite([*found, *new]).all()


def test_an_instant_leaves_bristles_as_they_are():
    """A restart, or an evaluation at an accepted state: h = 0."""
    law = LAWS["LuGre"]
    T, z = force(law, 3e-3, 40.0, 1e-4, (2e-6, -1e-3))
    again, same = force(law, 3e-3, 40.0, 0.0, tuple(z))
    assert again == pytest.approx(T, rel=1e-14)
    assert same == pytest.approx(z, rel=1e-13)


# -- blocks on a plane -----------------------------------------------------------------------------------------------


@fm.kernels.gap_kernel
def plane(p, q, v, out):
    """A point of the second body over the line y = 0 of the first, which moves along x with the belt's speed p[0]."""
    out[0], out[1] = q[4] - q[1], v[4] - v[1]
    out[2] = v[3] - v[0] - p[0]
    out[4] = -1.0  # from the second surface into the first: downwards, so t = (1, 0)
    out[5], out[6] = q[3] - q[0], q[4] - q[1]
    out[9], out[10], out[11], out[12] = out[5], out[6], v[3] - v[0], v[4] - v[1]
    out[25], out[28], out[32], out[35] = -1.0, 1.0, -1.0, 1.0


@dataclass(frozen=True)
class Plane(Part):
    """The block's centre rests on the line y = 0 of the ground."""

    block: Part
    belt: float
    normal: fm.NormalLaw
    friction: fm.FrictionLaw

    def contributions(self, mechanism):
        ground, block = (("ground", "", k) for k in range(3)), ((self.block.name, "", k) for k in range(3))
        return [ContactContribution(self.name, plane, (*ground, *block), (self.belt,), self.normal, self.friction)]


MASS, G, K = 2.0, 9.81, 1e6
SPRING = fm.LankaraniNikravesh(stiffness=K, exponent=1.0, restitution=1.0)


def block(law, *, tilt=0.0, speed=0.0, belt=0.0, spring=0.0, x=0.0, t_end=1.0, step=1e-3, coarse=False, method=None):
    """Motion of a block pressed by gravity onto a plane tilted by the angle `tilt`; `spring` [N/m] pulls to x = 0."""
    down = G * math.cos(tilt)
    body = fm.RigidBody("block", (x, -MASS * down / K), MASS, 1.0, velocity=(speed, 0.0, 0.0))
    parts = [body, Plane("plane", body, belt, SPRING, law)]
    if spring:
        far = 1e3  # so far that it pulls along x only
        parts.append(
            fm.SpringDamper(
                "spring", fm.GROUND, body, (-far, 0.0), (x, -MASS * down / K), stiffness=spring, free_length=far
            )
        )
    mechanism = fm.Mechanism("block", parts, gravity=(G * math.sin(tilt), -down))
    sol = fm.simulate(mechanism, t_end=t_end, step=step, save="steps", method=method)
    assert sol.ok or (coarse and "went through contacts" in sol.status), sol.status
    assert sol.time[-1] == pytest.approx(t_end)
    return sol


@pytest.mark.parametrize("name", REGULARISED)
def test_block_on_an_incline_creeps_at_the_predicted_speed(name):
    law = LAWS[name] if name != "BrownMcPhee" else replace(LAWS[name], viscous=0.0)
    tilt = math.atan(0.6 * law.parameters()[0])  # three fifths of the friction angle
    sol = block(law, tilt=tilt)
    assert sol.array("block.vx")[-1] == pytest.approx(law.creep_speed(0.6), rel=1e-6)


def test_lugre_block_on_an_incline_stops():
    """It comes to rest displaced by load over stiffness."""
    law = fm.friction.LuGre(0.3, 0.2, stiffness=1e5, damping=40.0)
    tilt = math.atan(0.18)
    sol = block(law, tilt=tilt, t_end=2.0)
    x, v = sol.array("block.x"), sol.array("block.vx")
    assert abs(v[-1]) < 1e-12
    assert x[-1] == x[-500]
    # bristles slip a little on the way: z' = v (1 - z/z_most), so x = -z_most ln(1 - z/z_most), at least
    most, z = 0.3 * MASS * G * math.cos(tilt) / 1e5, MASS * G * math.sin(tilt) / 1e5
    assert z < x[-1] < -3.0 * most * math.log(1.0 - z / most)


def test_the_error_estimate_of_radau_sees_bristles_in_a_contact():
    """A block that vibrates on undamped bristles on an incline, far below the angle of friction: against scipy."""
    law, tilt = fm.friction.LuGre(0.3, 0.3, stiffness=1e4), 0.03
    most, pull = 0.3 * MASS * G * math.cos(tilt) / 1e4, G * math.sin(tilt)

    def rates(t, y):
        return [y[1], pull - 1e4 * y[2] / MASS, y[1] - abs(y[1]) * y[2] / most]

    exact = solve_ivp(rates, (0.0, 1.0), [0.0, 0.0, 0.0], rtol=1e-10, atol=1e-14, max_step=1e-3).y[0, -1]
    sol = block(law, tilt=tilt, step=fm.Adaptive(rtol=1e-8), method=fm.RadauIIA())
    assert sol.array("block.x")[-1] == pytest.approx(exact, rel=2e-4)


@pytest.mark.parametrize("name", ["ModifiedCoulomb", "SmoothCoulomb", "Threlfall", "LuGre"])
def test_thrown_block_stops(name):
    """After v0 / (mu g) and v0^2 / (2 mu g), up to the creep of the law."""
    law = {
        "ModifiedCoulomb": fm.ModifiedCoulomb(0.2, v0=0.0, v1=1e-3),
        "LuGre": fm.friction.LuGre(0.2, 0.2, stiffness=1e6, damping=20.0),
    }.get(name, LAWS[name])
    v0, mu = 0.5, 0.2
    # bristles are unloaded at first; the step in which they load costs mu g h/2 of braking, v0 h/2 of the way
    sol = block(law, speed=v0, t_end=0.4, step=2e-5 if name == "LuGre" else 2e-4)
    x, v, t = sol.array("block.x"), sol.array("block.vx"), sol.time
    assert x[-1] == pytest.approx(v0**2 / (2.0 * mu * G), rel=2e-4)
    assert t[np.argmax(v < 5e-3)] == pytest.approx((v0 - 5e-3) / (mu * G), rel=2e-3)
    assert abs(v[-1]) < 2e-4


def stick_slip(mu_s, mu_k, spring, belt):
    """Period of a block on a belt with two Coulomb coefficients: stick with the belt, then a piece of a sine.

    The spring reaches mu_s N at x = X_k + A, X_k = mu_k N/k, A = (mu_s - mu_k) N/k.  Sliding, x - X_k =
    A cos(w t) + (belt/w) sin(w t), until x' = belt again: -A w sin(w t) = belt (1 - cos(w t)), tan(w t/2) = -A w/belt.
    By symmetry x = X_k - A there, and the way 2 A is made up at the belt's speed.
    """
    w, amplitude = math.sqrt(spring / MASS), (mu_s - mu_k) * MASS * G / spring
    return 2.0 * amplitude / belt + 2.0 / w * (math.pi - math.atan(amplitude * w / belt))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "tolerance"),
    [
        (fm.friction.BengisuAkay(0.4, 0.25, v0=2e-4, decay=1e4), 0.005),
        (fm.friction.Stribeck(0.4, 0.25, stribeck_speed=1e-3, v0=1e-4), 0.03),  # its peak is 1 % below mu_s
        (fm.friction.BrownMcPhee(0.4, 0.25, transition_speed=1e-4), 0.005),
        # bristles that shift at k belt/sigma_0 << v_s, or they break away early; a fall so fast that the block gets
        # over its flat top, where v = k belt t^2/(2 m), in a small part of the period: sqrt(2 m v_s/(k belt)) = 3 ms
        (fm.friction.LuGre(0.4, 0.25, stribeck_speed=1e-4, stiffness=1e10, damping=14000.0), 0.005),
    ],
    ids=lambda x: type(x).__name__ if isinstance(x, fm.FrictionLaw) else "",
)
def test_stick_slip_period(law, tolerance):
    spring, belt = 500.0, 0.1
    # where friction falls, -dT/dv h/2 < m, or a step has several solutions
    sol = block(law, belt=belt, spring=spring, t_end=4.0, step=1e-4)
    x, t = sol.array("block.x"), sol.time
    middle = 0.25 * MASS * G / spring
    up = np.flatnonzero((x[:-1] < middle) & (x[1:] >= middle) & (t[1:] > 1.0))
    periods = np.diff(t[up])
    assert len(periods) >= 3
    assert periods == pytest.approx(stick_slip(0.4, 0.25, spring, belt), rel=tolerance)


@pytest.mark.parametrize("law", [
    fm.friction.BengisuAkay(0.4, 0.25, v0=1e-4, decay=1e4),
    fm.friction.LuGre(0.4, 0.25, stribeck_speed=1e-4, stiffness=1e9, damping=1000.0),
], ids=lambda x: type(x).__name__)  # fmt: skip
def test_stick_slip_with_default_steps(law):
    """Every accepted step solves m a = T - k x, also where friction falls; it slides from k x = mu_s m g on."""
    spring, belt, here = 500.0, 0.1, {"at": (0.0, 0.0), "inertia": 0.1}
    body, band = fm.RigidBody("block", mass=MASS, **here), fm.RigidBody("band", mass=1.0, **here)
    sol = fm.simulate(fm.Mechanism("belt", [
        band, fm.Prismatic("rolls", fm.GROUND, band), fm.Drive("motor", "rolls", fm.ConstantSpeed(belt)),
        body, fm.Prismatic("slip", band, body, friction=law, length=0.1),
        fm.SpringDamper("spring", fm.GROUND, body, at=(-1.0, 0.0), to=(0.0, 0.0), stiffness=spring),
    ], gravity=(0.0, -G)), t_end=1.0, save="steps")  # fmt: skip
    x, a, T = (sol.array(name) for name in ("block.x", "block.ax", "slip.friction_force"))
    assert np.abs(MASS * a - T + spring * x).max() < 1e-2
    middle, fall = 0.25 * MASS * G / spring, 0.15 * MASS * G / spring
    assert x[len(x) // 2 :].max() == pytest.approx(middle + math.hypot(fall, belt / math.sqrt(spring / MASS)), rel=5e-3)


@pytest.mark.parametrize(
    ("law", "step"),
    [
        (fm.ModifiedCoulomb(0.3, v0=0.0, v1=1e-3), 1e-2),
        (fm.ModifiedCoulomb(0.3, v0=0.0, v1=1e-6), 1e-3),
        (fm.friction.SmoothCoulomb(0.3, v0=1e-6), 1e-3),
        (fm.friction.LuGre(0.3, 0.3, stiffness=1e10, damping=100.0), 1e-3),
        (fm.friction.LuGre(0.3, 0.3, stiffness=1e9), 1e-2),
    ],
)
def test_coarse_steps_stop_the_block(law, step):
    """One step changes the speed by up to thousands of widths of the sticking zone; Newton still ends inside it.

    The longest steps stop the block in 17: the account of the energy may call them too coarse.
    """
    sol = block(law, speed=0.5, t_end=1.0, step=step, coarse=step > 5e-3)
    assert abs(sol.array("block.vx")[-1]) < 1e-6
    # in the step that stops the block the deceleration is not mu g throughout; the bristles load in the first one
    assert sol.array("block.x")[-1] == pytest.approx(0.25 / (2.0 * 0.3 * G), abs=0.5 * step)


# -- bad input -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: fm.ModifiedCoulomb(0.1, v0=2e-3, v1=1e-3), "v1 is 0.001 m/s; it must be > v0 = 0.002 m/s"),
        (lambda: fm.friction.SmoothCoulomb(-0.1), "SmoothCoulomb: coefficient is -0.1; it must be >= 0"),
        (lambda: fm.friction.SmoothCoulomb(0.1, v0=0.0), "SmoothCoulomb: v0 is 0 m/s; it must be > 0"),
        (lambda: fm.friction.Threlfall(0.1, v0=-1.0), "Threlfall: v0 is -1 m/s; it must be > 0"),
        (
            lambda: fm.friction.BengisuAkay(0.1, 0.2),
            "BengisuAkay: static is 0.1; it must be >= kinetic = 0.2. Did you exchange",
        ),
        (lambda: fm.friction.BengisuAkay(0.2, 0.1, decay=0.0), "BengisuAkay: decay is 0 s/m; it must be > 0"),
        (lambda: fm.friction.Stribeck(0.1, 0.2), "Stribeck: static is 0.1; it must be >= kinetic"),
        (
            lambda: fm.friction.Stribeck(0.2, 0.1, stribeck_speed=0.0),
            "Stribeck: stribeck_speed is 0 m/s; it must be > 0",
        ),
        (
            lambda: fm.friction.Stribeck(0.2, 0.1, v0=1e-2),
            "Stribeck: v0 is 0.01 m/s; it must lie between 0 and 0.01.*ten times",
        ),
        (lambda: fm.friction.Stribeck(0.2, 0.1, exponent=0.5), "Stribeck: exponent is 0.5; it must be >= 1"),
        (lambda: fm.friction.BrownMcPhee(0.2, -0.1), "BrownMcPhee: kinetic is -0.1; it must be >= 0"),
        (
            lambda: fm.friction.BrownMcPhee(0.2, 0.1, transition_load=0.0),
            "BrownMcPhee: transition_load is 0 N; it must be > 0",
        ),
        (
            lambda: fm.friction.LuGre(0.2, 0.0),
            r"LuGre: kinetic is 0; it must be > 0. For surfaces without friction use Friction",
        ),
        (lambda: fm.friction.LuGre(0.2, 0.1, stiffness=-1.0), "LuGre: stiffness is -1 N/m; it must be > 0"),
        (
            lambda: fm.friction.LuGre(0.2, 0.1, damping=94.0),
            r"LuGre: damping is 94 s/m; it must be <= .* = 93.2.* s/m.*Lower it",
        ),
        (lambda: fm.friction.LuGre(0.2, 0.1).creep_speed(-0.1), "LuGre: load_ratio is -0.1; it must be >= 0"),
    ],
)
def test_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_laws_in_the_wrong_place_are_refused():
    given = {"clearance": 1e-4, "bearing_radius": 5e-3}
    body = fm.RigidBody("b", (0.0, 0.0), 1.0, 1.0)
    with pytest.raises(InputError, match=r"friction is LankaraniNikravesh.*it must be a friction law"):
        fm.RevoluteClearance("J", fm.GROUND, body, (0.0, 0.0), **given, normal=SPRING, friction=SPRING)
    with pytest.raises(InputError, match=r"normal is LuGre.*it must be a normal law"):
        fm.RevoluteClearance("J", fm.GROUND, body, (0.0, 0.0), **given, normal=LAWS["LuGre"])
