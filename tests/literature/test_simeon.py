"""Simeon's slider-crank with a flexible rod: the published modal observables, and the beam that the modes stand for.

A rigid crank of 0.15 m is driven at 150 rad/s; a square steel rod of 0.30 m carries a slider; no gravity, no damping.
The source describes the rod by two lateral sine waves q1, q2 and an axial parabola through q3 (middle) and q4 (end),
with a linear stiffness.  Here the rod is a chain of nonlinear beam elements that starts with the published stretch and
the published rates.  q1 and q2 are then the first sine coefficients of the deflection w from the chord,
2/L int w sin.

How the two models differ in what is compared:

* The axial block of the published mass matrix lacks the factor 1/15 of a consistent one, so its rod vibrates axially
  with other frequencies; only the quasi-static part of q3, q4 can agree.
* The published stiffness is linear: axial force neither stiffens nor softens bending, bending does not shorten the
  chord.  The slider pulls with up to 255 N, 3.4 % of the buckling load, which shifts the phase of bending.
* J2 enters no motion, because the crank is driven.
"""

from functools import lru_cache

import numpy as np
from published import simeon
from record import Curve, Problem, Value
from rod_of_plates import ROD

import flexmb as fm

STEP, T_END = 1e-5, 0.1

PROBLEM = Problem(
    title="Flexible slider-crank of Simeon",
    source=(
        "B. Simeon, Mathematical Modelling of Systems 2 (1996) 1-18; values at t = 0.1 s: W. Lioen, J. de Swart, Test "
        "Set for Initial Value Problem Solvers, problem crank"
    ),
    kind=(
        "published: phi2, x3, q1, q2 at t = 0.1 s and their rates; computed once by an independent nonlinear beam "
        "code, good to 0.3 %: deflections of the rod's middle"
    ),
    about=(
        "Fields of displacement and velocity at the start; a nonlinear beam beside a linear modal model with the same "
        "data. phi2 and x3 are compared absolutely, in rad and m. Steps of 1e-5 s, generalised-alpha 0.8: a run of 32 "
        "elements and 10 000 steps takes 1 to 2 s."
    ),
)


@lru_cache(maxsize=8)
def run(elements, stretched=True, waving=True, step=STEP, t_end=T_END):
    """A run with every step saved."""
    mech = simeon(elements, stretched, waving)
    sol = fm.simulate(mech, t_end=t_end, step=step, save="steps")
    assert sol.ok, sol.status
    return sol


def sine_coefficients(sol, elements):
    """q1 and q2 over time: 2/L int w sin(k pi s/L) ds by the trapezoidal rule, exact for sines at equal nodes."""
    x, y = (np.stack([sol.array(f"rod.node{i}.{axis}") for i in range(elements + 1)]) for axis in "xy")
    dx, dy = x[-1] - x[0], y[-1] - y[0]
    across = (dx * (y - y[0]) - dy * (x - x[0])) / np.hypot(dx, dy)
    s = np.linspace(0.0, 1.0, elements + 1)[:, None]
    return [2.0 / elements * (np.sin(k * np.pi * s) * across).sum(axis=0) for k in (1, 2)]


def rate(values, time):
    """Rate at the last instant, from the parabola through the last three."""
    a, b, _ = np.polyfit(time[-3:] - time[-1], values[-3:], 2)
    return b


@PROBLEM.case("observables of the published modal form at t = 0.1 s, 32 elements")
def published():
    n = 32
    sol = run(n)
    dx, dy = (sol.array(f"rod.end.{axis}") - sol.array(f"rod.start.{axis}") for axis in "xy")
    phi2 = np.arctan2(dy, dx)
    q1, q2 = sine_coefficients(sol, n)
    why = (
        "the published stiffness is linear. The four modes of the source, integrated independently, give the published "
        "value within 3e-6 with it; with the strain u' + w'^2/2, in which axial force acts on bending, and with two "
        "axial and one lateral sine more they give 2.32805e-4 m. Beam elements hold that strain"
    )
    return [
        Value("phi2 [rad], absolute", -0.3311734987910881, phi2[-1], 1e-6, scale=1.0),
        Value("x3 [m], absolute", 0.1697373326718410, sol.array("slider.x")[-1], 1e-6, scale=1.0),
        Value("q1 [m]", 1.893192460247178e-4, q1[-1], 1e-2, missed=why, limit=0.25),
        Value("q1 [m], seven modes with the strain u' + w'^2/2, computed once", 2.32805e-4, q1[-1], 5e-3),
        Value("q2 [m]", 2.375751865617931e-5, q2[-1], 5e-2),
        Value("rate of phi2 [rad/s]", 60.25346682645789, rate(phi2, sol.time), 1e-3),
        Value("rate of x3 [m/s]", -8.753116989887888, sol.array("slider.vx")[-1], 1e-3),
    ]


def middle(waving, wanted, largest, when):
    """Deflections of the rod's middle at three instants, and the largest one with its time."""
    sol = run(32, stretched=False, waving=waving)
    w = sol.array("rod.deflection")
    k = int(np.abs(w).argmax())
    found = np.interp((0.01, 0.04, 0.08), sol.time, w)
    values = [Value(f"w at {t} s [m]", a, b, 5e-3) for t, a, b in zip((0.01, 0.04, 0.08), wanted, found, strict=True)]
    return [*values, Value("largest w [m]", largest, w[k], 5e-3), Value("its time [s]", when, sol.time[k], 5e-3)]


@PROBLEM.case("nonlinear beam, rod starting as a rigid one", slow=True)
def rigid_start():
    return middle(False, (6.982e-4, -9.76e-4, -1.6454e-3), 1.8672e-3, 0.0477)


@PROBLEM.case("nonlinear beam, rod starting with the published lateral waves", slow=True)
def waving_start():
    return middle(True, (8.766e-4, -7.534e-4, -1.3116e-3), 1.5618e-3, 0.0897)


@PROBLEM.convergence(
    "simeon_elements", "Deflection against 64 elements, largest error up to 0.04 s", "element length [m]", "error [m]"
)
def elements():
    counts = (4, 8, 16)
    best, *found = (run(n, waving=False, t_end=0.04).array("rod.deflection") for n in (64, *counts))
    errors = [np.abs(w - best).max() for w in found]
    # axial vibrations, which a finer chain resolves differently, leave 1e-8 m: a little less than the fourth order
    return [Curve("w of the middle", [ROD / n for n in counts], errors, 4.0, slack=0.4)]


@PROBLEM.convergence(
    "simeon_steps", "Deflection of 8 elements at 0.04 s against steps of 2 us", "step [s]", "error [m]"
)
def steps():
    sizes = (2e-4, 1e-4, 5e-5)
    best, *found = (run(8, stretched=False, step=h, t_end=0.04).array("rod.deflection")[-1] for h in (2e-6, *sizes))
    return [Curve("w of the middle", sizes, [abs(w - best) for w in found], 2.0)]


@PROBLEM.picture("simeon", "Deflection of the rod's middle from the chord, 32 elements")
def history(figure):
    axes = figure.subplots()
    for label, waving in (("starting as a rigid rod", False), ("starting with waves", True)):
        sol = run(32, stretched=False, waving=waving)
        axes.plot(sol.time, sol.array("rod.deflection"), label=label)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("deflection [m]")
    axes.legend()


test_case, test_curves = PROBLEM.tests()
