"""Two problems of the IFToMM benchmark library: the pendulum (A01) and the N-four-bar (A02).

The four-bars pass, twice a turn, a position in which all links lie on one line: there the joints are not independent,
and the constraint matrix loses N of its rows.
"""

import numpy as np
from published import n_four_bar
from record import Problem, Value
from scipy.special import ellipj, ellipk

import flexmb as fm

PROBLEM = Problem(
    title="Pendulum and N-four-bar of the IFToMM library",
    source=(
        "IFToMM technical committee for multibody dynamics, library of computational benchmark problems, A01 and A02; "
        "M. Gonzalez, D. Dopico, U. Lugris, J. Cuadrado, Multibody System Dynamics 16 (2006) 179-190"
    ),
    kind="exact: elliptic functions",
    about=(
        "A01: point mass of 1 kg on 1 m from the horizontal, 10 s; the library wants the energy within 5e-5 J. A02: N "
        "windows of 2 N + 1 equal links that start upright at 1 m/s; the energy within 0.1 J. They pass the flat "
        "position again and again. For N >= 2 the exact joint forces grow like 1/angle there: only couplers that point "
        "along the rockers can make the middle rockers, which carry more, fall like the outer ones."
    ),
)

G, DURATION = 9.81, 10.0


def pendulum():
    """A01.  A body needs a moment of inertia: 1e-12 kg m^2 change the period by 5e-13 of it."""
    bob = fm.RigidBody("bob", (-1.0, 0.0), mass=1.0, inertia=1e-12)
    return fm.Mechanism("pendulum", (bob, fm.Revolute("O", fm.GROUND, bob, at=(0.0, 0.0))), gravity=(0.0, -G))


def drift(sol):
    """Largest change of the energy over all steps [J]."""
    stored = sol.array("energy.kinetic") + sol.array("energy.strain") + sol.array("energy.gravity")
    return float(np.abs(stored - stored[0]).max())


def ran(mechanism, step, method):
    sol = fm.simulate(mechanism, t_end=DURATION, step=step, save="steps", method=method)
    assert sol.ok, sol.status
    return sol


@PROBLEM.case("A01, Runge-Kutta 4, 2 ms")
def a01():
    sol = ran(pendulum(), 2e-3, fm.RungeKutta4())
    x, y = sol.array("bob.x"), sol.array("bob.y")
    middle = len(sol.time) // 2
    yield Value("x at 5 s [m]", -0.942305435043757, x[middle], 1e-6, scale=1.0)
    yield Value("y at 5 s [m]", -0.334754338414001, y[middle], 1e-6, scale=1.0)
    yield Value("x at 10 s [m]", -0.275087462576117, x[-1], 1e-6, scale=1.0)
    yield Value("y at 10 s [m]", -0.961419205099125, y[-1], 1e-6, scale=1.0)
    yield Value("largest change of energy [J]", 0.0, drift(sol), 5e-5, scale=1.0)
    yield Value("period [s]", 2.36784194757624, period(sol), 1e-9)


def period(sol):
    """Twice the mean time between passages through the vertical."""
    x, v, t = sol.array("bob.x"), sol.array("bob.vx"), sol.time
    k = np.flatnonzero(x[:-1] * x[1:] < 0.0)
    h = t[k + 1] - t[k]
    s = x[k] / (x[k] - x[k + 1])
    for _ in range(5):  # Newton on the cubic through positions and velocities
        d0, d1, rise = h * v[k], h * v[k + 1], x[k + 1] - x[k]
        c2, c3 = 3 * rise - 2 * d0 - d1, d0 + d1 - 2 * rise
        s -= (x[k] + s * (d0 + s * (c2 + s * c3))) / (d0 + s * (2 * c2 + 3 * s * c3))
    passed = t[k] + s * h
    return 2.0 * (passed[-1] - passed[0]) / (len(passed) - 1)


@PROBLEM.case("A01, trapezoidal, 0.2 ms")
def a01_trapezoidal():
    sol = ran(pendulum(), 2e-4, fm.Newmark.trapezoidal())
    yield Value("largest change of energy [J]", 0.0, drift(sol), 5e-5, scale=1.0)


def upright(windows, times):
    """B0 of A02, exactly: every rocker turns by the same angle, as a pendulum that goes over the top.

    (N + 1)/3 + N is the moment of inertia, (N + 1)/2 + N the moment of the weights over g, from the upright at 1 rad/s:
    phi' ^2 = 1 + 2 g S/I (1 - cos phi), so phi/2 = am(t/2 sqrt(1 + 4 g S/I) | m) counted from below.
    """
    inertia, moment = (windows + 1) / 3.0 + windows, (windows + 1) / 2.0 + windows
    fastest = 1.0 + 4.0 * G * moment / inertia
    m = (fastest - 1.0) / fastest
    sn, cn, *_ = ellipj(0.5 * np.sqrt(fastest) * np.asarray(times) - ellipk(m), m)
    # psi = 2 am counts from the lowest point, - pi at the start: x = -sin(psi), y = -cos(psi) turning clockwise
    return -2.0 * sn * cn, 2.0 * sn**2 - 1.0


def row(windows, step, method):
    sol = ran(n_four_bar(windows), step, method)
    angle = sol.array("rocker0.theta")
    return sol, np.cos(angle), np.sin(angle)


PUBLISHED = {
    1: (-0.195020301949, -0.980799205662),
    5: (-0.811310461004, -0.584615545350),
    10: (0.328458111539, 0.944518538179),
}


@PROBLEM.case("A02, N = 2, Runge-Kutta 4, 2 ms")
def a02():
    sol, x, y = row(2, 2e-3, fm.RungeKutta4())
    for t, (x_ref, y_ref) in PUBLISHED.items():
        k = round(t / DURATION * (len(x) - 1))
        yield Value(f"B0 x at {t} s [m]", x_ref, x[k], 1e-6, scale=1.0)
        yield Value(f"B0 y at {t} s [m]", y_ref, y[k], 1e-6, scale=1.0)
    yield Value("largest change of energy [J]", 0.0, drift(sol), 0.1, scale=1.0)
    yield Value(
        "elliptic function against the table, x at 10 s [m]", PUBLISHED[10][0], upright(2, 10.0)[0], 1e-11, scale=1.0
    )


def _other(windows, step, method, name):
    @PROBLEM.case(f"A02, N = {windows}, {name}")
    def case():
        sol, x, y = row(windows, step, method)
        x_ref, y_ref = upright(windows, sol.time)
        yield Value("B0, largest error over 10 s [m]", 0.0, np.hypot(x - x_ref, y - y_ref).max(), 1e-6, scale=1.0)
        yield Value("largest change of energy [J]", 0.0, drift(sol), 0.1, scale=1.0)
        turned = max(np.abs(sol.array(f"coupler{k}.theta")).max() for k in range(1, windows + 1))
        yield Value("rotation of a coupler, 0 on the branch of the start [rad]", 0.0, turned, 1e-6, scale=1.0)


for _windows in (1, 4, 10):
    _other(_windows, 2e-3, fm.RungeKutta4(), "Runge-Kutta 4, 2 ms")
_other(2, 7.5e-5, fm.Newmark.generalised_alpha(0.8), "generalised-alpha, 0.075 ms")

test_case, _ = PROBLEM.tests()
