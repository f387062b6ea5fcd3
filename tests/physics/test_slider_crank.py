"""The slider-crank of the literature: ideal joints in closed form; play in the piston pin, before and after impacts.

Exact and converged numbers of the model in `conftest.py` (5000 rpm, r = 0.05 m, l = 0.12 m).
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fm

CRANK, ROD, OMEGA = 0.05, 0.12, 5000 * math.pi / 30
CLEARANCE, BEARING = 0.0005, 0.010

FIRST_CONTACT, CLOSING_SPEED = 2.27286e-4, 4.385783
"""Free flight up to the first contact, whatever the contact law [s, m/s]."""

CONVERGED = {0.0: (45872.0, 0.160926), 0.03: (45826.0, 0.160975)}
"""mu -> peak force of the first 1 ms [N], slider at 1 ms [m]: an independent two-coordinate code, steps of 1e-8 s."""

RULES = {"alpha": fm.Newmark.generalised_alpha(0.8), "trapezoidal": fm.Newmark.trapezoidal(), "rk4": fm.RungeKutta4()}


def slider_position(t):
    return CRANK * np.cos(OMEGA * t) + np.sqrt(ROD**2 - (CRANK * np.sin(OMEGA * t)) ** 2)


@pytest.mark.parametrize("method", RULES)
def test_ideal_joints(slider_crank, method):
    """x(t); largest acceleration r w^2 (1 + r/l) stretched; greatest drive torque of the table (138.522 N m)."""
    sol = fm.simulate(slider_crank(clearance=None), periods=1, step=5e-6, save="steps", method=RULES[method])
    np.testing.assert_allclose(sol.array("slider.x"), slider_position(sol.time), atol=1e-12)
    assert sol.peak("slider.ax").value == pytest.approx(CRANK * OMEGA**2 * (1 + CRANK / ROD), rel=1e-5)
    assert sol.peak("slider.ax").value == pytest.approx(19419.36, abs=0.2)
    assert sol.peak("motor.torque").value == pytest.approx(138.522, abs=2e-3)
    # over a turn the drive gives nothing: kinetic energy is periodic
    work = sol.array("energy.drive_work")
    assert abs(work[-1]) < 1e-3 * work.max()


def free_flight():
    """Exact flight: the slider rests, the rod swings about the crank pin; event: the play is used up."""
    inertia, moment = 2.5e-4 + 0.21 * ROD**2 / 4, 0.21 * ROD / 2

    def rates(t, y):
        ax, ay = -(OMEGA**2) * CRANK * math.cos(OMEGA * t), -(OMEGA**2) * CRANK * math.sin(OMEGA * t)
        return [y[1], moment * (math.sin(y[0]) * ax - math.cos(y[0]) * ay) / inertia]

    def play(t, y):
        ex = CRANK + ROD - CRANK * math.cos(OMEGA * t) - ROD * math.cos(y[0])
        ey = -CRANK * math.sin(OMEGA * t) - ROD * math.sin(y[0])
        return math.hypot(ex, ey) - CLEARANCE

    play.terminal = True
    start = (0.0, -OMEGA * CRANK / ROD)
    found = solve_ivp(rates, (0.0, 1e-3), start, "DOP853", events=play, rtol=1e-13, atol=1e-15, max_step=1e-5)
    (t,), (phi, spin) = found.t_events[0], found.y_events[0][0]
    ex = CRANK + ROD - CRANK * math.cos(OMEGA * t) - ROD * math.cos(phi)
    ey = -CRANK * math.sin(OMEGA * t) - ROD * math.sin(phi)
    vx = CRANK * OMEGA * math.sin(OMEGA * t) + ROD * spin * math.sin(phi)
    vy = -CRANK * OMEGA * math.cos(OMEGA * t) - ROD * spin * math.cos(phi)
    return t, (ex * vx + ey * vy) / math.hypot(ex, ey)


def test_the_published_first_contact_is_that_of_free_flight():
    t, speed = free_flight()
    assert t == pytest.approx(FIRST_CONTACT, abs=5e-10)
    assert speed == pytest.approx(CLOSING_SPEED, abs=5e-7)


def first_contact(sol):
    """Instant at which the gap falls through zero: the cubic through gap and rate at both ends of that step."""
    depth, rate = sol.array("C.penetration"), sol.array("C.penetration_rate")
    i = int(np.flatnonzero(depth > 0.0)[0])
    h = sol.time[i] - sol.time[i - 1]
    d0, d1, r0, r1 = depth[i - 1], depth[i], h * rate[i - 1], h * rate[i]
    roots = np.roots([r0 + r1 - 2 * (d1 - d0), 3 * (d1 - d0) - 2 * r0 - r1, r0, d0])
    (s,) = (x.real for x in roots if abs(x.imag) < 1e-9 and 0.0 <= x.real <= 1.0)
    return sol.time[i - 1] + s * h, i


STEPS = {"1e-6": fm.FixedStep(1e-6), "2e-7": fm.FixedStep(2e-7), "adaptive": fm.Adaptive(rtol=1e-6)}


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("mu", CONVERGED)
def test_first_contact_is_located_inside_its_step(slider_crank, mu, step):
    """The instant, and the closing speed that the contact law works with.

    Both are taken from the cubic through gap and rate at the ends of the step, of which the later one feels the contact
    already: an error of at least second order in the step.
    """
    program = fm.compile(slider_crank(mu))
    sol = fm.simulate(slider_crank(mu), t_end=2.4e-4, step=STEPS[step], save="steps")
    found, i = first_contact(sol)
    before = sol.time < FIRST_CONTACT
    np.testing.assert_allclose(sol.array("slider.x")[before], CRANK + ROD, atol=1e-12)
    approach = sol.restart["z"][program.tables.contacts.z[0, 1]]
    exact, speed = free_flight()
    accuracy = 1e-5 if step == "adaptive" else 2e-4 * (float(step) / 1e-6) ** 2
    assert found == pytest.approx(exact, rel=accuracy)
    assert approach == pytest.approx(speed, rel=accuracy)
    # the speed at the end of the step, which an unlocated onset would take, is far off
    if step == "1e-6":
        assert abs(sol.array("C.penetration_rate")[i] / speed - 1.0) > 10 * accuracy


@pytest.mark.quick(2)
@pytest.mark.parametrize("method", RULES)
@pytest.mark.parametrize("mu", CONVERGED)
def test_first_impact_and_the_motion_after_it(slider_crank, mu, method):
    """The table is rounded to 1 N and 1e-6 m."""
    peak, x = CONVERGED[mu]
    sol = fm.simulate(slider_crank(mu), t_end=1e-3, step=1e-7, method=RULES[method])
    assert sol.ok, sol.status
    assert sol.peak("C.normal_force").value == pytest.approx(peak, abs=1.0)
    assert sol.array("slider.x")[-1] == pytest.approx(x, abs=1e-6)


def test_error_controlled_steps_find_the_same_impact(slider_crank):
    peak, x = CONVERGED[0.03]
    errors = []
    for wanted in (1e-4, 1e-5, 1e-6):
        sol = fm.simulate(slider_crank(), t_end=1e-3, step=fm.Adaptive(rtol=wanted), save="steps")
        assert sol.ok, sol.status
        errors.append((abs(sol.peak("C.normal_force").value / peak - 1), abs(sol.array("slider.x")[-1] - x)))
    assert errors[2][0] < 1e-3
    assert errors[2][1] < 1e-6
    assert errors[2][0] < errors[0][0]
    assert errors[2][1] < errors[0][1]


@pytest.mark.parametrize("step", [1e-5, 5e-6, 2e-6])
def test_fixed_steps_get_through_the_turning_of_friction(slider_crank, step):
    """Two turns with a friction zone of 1 mm/s, crossed within a step; full Newton steps would jump there."""
    sol = fm.simulate(slider_crank(0.03), periods=2, step=step)
    assert sol.ok, sol.status
    slip_changes = np.count_nonzero(np.diff(np.sign(sol.array("C.friction_force"))))
    assert slip_changes > 3
    assert sol.stats.newton_iterations < 2.5 * sol.stats.steps
