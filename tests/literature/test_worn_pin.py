"""A slider-crank at 5000 rpm whose piston pin is worn: free flight, the first impact, the motion after it.

Model: `flexmb.mechanisms.slider_crank` with 0.5 mm of play in the piston pin; no gravity.
"""

import math

import numpy as np
from record import Problem, Value
from scipy.integrate import solve_ivp

import flexmb as fm

PROBLEM = Problem(
    title="Slider-crank with a worn piston pin",
    source=(
        "P. Flores, J. Ambrosio, J. C. P. Claro, H. M. Lankarani, Kinematics and Dynamics of Multibody Systems with "
        "Imperfect Joints, Springer 2008 (mechanism and contact law)"
    ),
    kind="exact up to the first contact; then computed once, by Runge-Kutta steps of 1e-8 s in two coordinates",
    about=(
        "Until the journal touches, the slider rests and the rod swings about the crank pin, whatever the contact law: "
        "the instant and the closing speed are those of one pendulum equation. The impact itself tests contact law, "
        "friction and step. The ideal mechanism is known in closed form."
    ),
)

CRANK, ROD, ROD_MASS, ROD_INERTIA, OMEGA = 0.05, 0.12, 0.21, 2.5e-4, 5000 * math.pi / 30
CLEARANCE = 0.5e-3
CONVERGED = {0.0: (45872.0, 0.160926), 0.03: (45826.0, 0.160975)}
"""Coefficient of friction -> largest force up to 1 ms [N], slider at 1 ms [m]; rounded to 1 N and 1e-6 m."""


def worn(mu):
    friction = fm.ModifiedCoulomb(mu, v0=0.0, v1=1e-3) if mu else None
    return fm.mechanisms.slider_crank(OMEGA, clearance=CLEARANCE, friction=friction)


def free_flight():
    """Instant [s] and closing speed [m/s] of the first contact: the rod as a pendulum on the crank pin."""
    about_pin = ROD_INERTIA + ROD_MASS * ROD**2 / 4

    def rates(t, y):
        ax, ay = -(OMEGA**2) * CRANK * math.cos(OMEGA * t), -(OMEGA**2) * CRANK * math.sin(OMEGA * t)
        return [y[1], ROD_MASS * ROD / 2 * (math.sin(y[0]) * ax - math.cos(y[0]) * ay) / about_pin]

    def eccentricity(t, phi):
        x = CRANK + ROD - CRANK * math.cos(OMEGA * t) - ROD * math.cos(phi)
        return x, -CRANK * math.sin(OMEGA * t) - ROD * math.sin(phi)

    def play(t, y):
        return CLEARANCE - math.hypot(*eccentricity(t, y[0]))

    play.terminal = True
    start = (0.0, -OMEGA * CRANK / ROD)
    found = solve_ivp(rates, (0.0, 1e-3), start, "DOP853", events=play, rtol=1e-13, atol=1e-15, max_step=1e-5)
    (t,), (phi, spin) = found.t_events[0], found.y_events[0][0]
    ex, ey = eccentricity(t, phi)
    vx = CRANK * OMEGA * math.sin(OMEGA * t) + ROD * spin * math.sin(phi)
    vy = -CRANK * OMEGA * math.cos(OMEGA * t) - ROD * spin * math.cos(phi)
    return t, (ex * vx + ey * vy) / math.hypot(ex, ey)


def first_contact(mu, step, method):
    """Instant and approach speed that the history of the contact keeps."""
    mechanism = worn(mu)
    at, law = fm.compile(mechanism).tables.contacts.z[0, :2]
    sol = fm.simulate(mechanism, t_end=2.35e-4, step=step, save=1, method=method)
    assert sol.ok, sol.status
    return sol.restart["z"][at + 1], sol.restart["z"][law]


@PROBLEM.case("first contact, Runge-Kutta 4, 25 ns")
def contact_explicit():
    yield from contact(fm.RungeKutta4())


@PROBLEM.case("first contact, generalised-alpha, 25 ns")
def contact_implicit():
    yield from contact(fm.Newmark.generalised_alpha(0.8))


def contact(method):
    t, speed = free_flight()
    yield Value("this flight against the table: instant [s]", 2.27286e-4, t, 5e-10, scale=1.0)
    yield Value("this flight against the table: closing speed [m/s]", 4.385783, speed, 5e-7, scale=1.0)
    found, approach = first_contact(0.03, 2.5e-8, method)
    yield Value("instant of the first contact [s]", t, found, 1e-6)
    yield Value("closing speed [m/s]", speed, approach, 1e-6)


def _impact(mu):
    @PROBLEM.case(f"first millisecond, friction {mu:g}, steps of 0.2 us")
    def case():
        sol = fm.simulate(worn(mu), t_end=1e-3, step=2e-7)
        assert sol.ok, sol.status
        peak, x = CONVERGED[mu]
        yield Value("largest normal force [N]", peak, sol.peak("B.normal_force").value, 5e-3)
        yield Value("slider at 1 ms [m]", x, sol.array("slider.x")[-1], 2e-6, scale=1.0)


for _mu in CONVERGED:
    _impact(_mu)


@PROBLEM.case("two turns, friction 0.03, trapezoidal rule, 50 ns")
def two_turns():
    """Two dozen contacts: with friction the reference itself agrees to a few um between steps of 10 and 1 ns."""
    t_end = 4.0 * math.pi / OMEGA
    sol = fm.simulate(worn(0.03), t_end=t_end, step=5e-8, save=1, method=fm.Newmark.trapezoidal())
    yield Value("contacts", 24.0, float(len(sol.episodes("B"))), 0.0)
    yield Value("slider at the end [m]", 0.170494, sol.array("slider.x")[-1], 1e-5, scale=1.0)
    yield Value("largest speed of the slider [m/s]", 30.6112, sol.peak("slider.vx").value, 1e-4)
    yield Value("largest force [N]", 45825.7, sol.peak("B.normal_force").value, 1e-4)


@PROBLEM.case("ideal pin")
def ideal():
    sol = fm.simulate(fm.mechanisms.slider_crank(OMEGA), periods=1, step=1e-6, save="steps")
    angle = OMEGA * sol.time
    x = CRANK * np.cos(angle) + np.sqrt(ROD**2 - (CRANK * np.sin(angle)) ** 2)
    yield Value("slider, largest error over a turn [m]", 0.0, np.abs(sol.array("slider.x") - x).max(), 1e-12, scale=1.0)
    yield Value("largest acceleration r w^2 (1 + r/l) [m/s^2]", 19419.36, sol.peak("slider.ax").value, 1e-6)


test_case, _ = PROBLEM.tests()
