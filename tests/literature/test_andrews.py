"""Andrews' squeezing mechanism: seven rigid bodies in three loops, whirled by a motor of constant torque.

Model: examples/andrews.py, from rigid bodies, revolute joints, a spring and a torque; its numbers are those of
E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, Springer 1996, section VII.7.
"""

import time

import numpy as np
from andrews import ANGLES, andrews, andrews_angles
from record import Curve, Problem, Value

import flexmb as fm

PROBLEM = Problem(
    title="Andrews' squeezing mechanism",
    source=(
        "F. Mazzia, C. Magherini, Test Set for Initial Value Problem Solvers, release 2.4, University of Bari 2008, "
        "problem 'Andrews squeezing mechanism'; problem A03 of the IFToMM benchmark library"
    ),
    kind="published; angles at t = 0.01, 0.02, 0.05 s computed once from the stated equations",
    about=(
        "The seven angles after 0.03 s, when the motor has turned by 15.8 rad, beside the published ones, whose digits "
        "are good to 1e-9. Built from bodies and joints; no equation of the mechanism is used. Angles count on over "
        "the turns."
    ),
)

END = 0.03
PUBLISHED = (
    15.81077119629904, -15.75637105984298, 0.04082224013073101, -0.5347301163226948, 0.5244099658805304,
    0.5347301163226948, 1.048080741042263,
)  # fmt: skip
RATES = (
    1139.920302151208, -1424.379294994111, 11.03291221937134, 19.29337464421385, 0.5735699284790808,
    -19.29337464421385, 0.3231791658026955,
)  # fmt: skip
BETA = {0.01: 2.160113131532, 0.02: 8.184905889662, 0.05: 33.825867766956}
METHODS = {
    "Runge-Kutta 4": fm.RungeKutta4(),
    "generalised-alpha 0.8": fm.Newmark.generalised_alpha(0.8),
    "trapezoidal": fm.Newmark.trapezoidal(),
}
STEPS = {
    "Runge-Kutta 4": (75, 150, 300, 600, 1200),
    "generalised-alpha 0.8": (3_000, 10_000, 30_000, 100_000),
    "trapezoidal": (3_000, 10_000, 30_000, 100_000),
}


def solved(method, steps, end=END, save=1):
    sol = fm.simulate(andrews(), t_end=end, step=end / steps, save=save, method=METHODS[method])
    assert sol.ok, sol.status
    return sol


@PROBLEM.case("Runge-Kutta 4, 3000 steps")
def angles_and_rates():
    sol = solved("Runge-Kutta 4", 3000)
    rows = zip(ANGLES, andrews_angles(sol)[:, -1], PUBLISHED, strict=True)
    yield from (Value(f"{name} [rad]", reference, ours, 1e-8, scale=1.0) for name, ours, reference in rows)
    rows = zip(ANGLES, andrews_angles(sol, rates=True)[:, -1], RATES, strict=True)
    # an angle at 1140 rad/s that is good to 1e-9 rad, and the motor's 14222 rad/s^2: 1e-9 s is 1e-5 rad/s
    yield from (Value(f"{name}' [rad/s]", reference, ours, 1e-6, scale=1.0) for name, ours, reference in rows)


@PROBLEM.case("start")
def start():
    sol = fm.simulate(andrews(), t_end=1e-7, step=1e-7, save="steps", method=fm.RungeKutta4())
    beta, Theta = sol.array("K1.alpha")[0], sol.array("K2.alpha")[0] - sol.array("K1.alpha")[0]
    yield Value("beta'' [rad/s^2]", 14222.4439199541, beta, 1e-12)
    yield Value("Theta'' [rad/s^2]", -10666.8329399656, Theta, 1e-12)


@PROBLEM.case("0.05 s, five turns")
def five_turns():
    sol = solved("Runge-Kutta 4", 8000, end=0.05, save="steps")
    beta = andrews_angles(sol)[0]
    for t, reference in BETA.items():
        ours = beta[round(t / 0.05 * 8000)]
        yield Value(f"beta at {t} s [rad]", reference, ours, 1e-8, scale=1.0)


def error(sol):
    return float(np.abs(andrews_angles(sol)[:, -1] - PUBLISHED).max())


@PROBLEM.convergence(
    "andrews_steps", "Largest error of the seven angles at 0.03 s over the step.", "step [s]", "error [rad]", slow=True
)
def convergence():
    for name, numbers in STEPS.items():
        errors = [error(solved(name, n)) for n in numbers]
        yield Curve(name, [END / n for n in numbers], errors, 4.0 if name.startswith("Runge") else 2.0)


@PROBLEM.convergence(
    "andrews_adaptive",
    "Largest error of the seven angles at 0.03 s over the accepted error of a step, generalised-alpha.",
    "accepted error of a step [m]",
    "error [rad]",
)
def adaptive():
    """The local error is of third order in the step, the global one of second: their ratio is the order 2/3."""
    accepted = (1e-10, 1e-11, 1e-12, 1e-13)
    runs = [fm.simulate(andrews(), t_end=END, step=fm.Adaptive(atol=e), save=1) for e in accepted]
    yield Curve("adaptive", accepted, [error(sol) for sol in runs], 2.0 / 3.0)


@PROBLEM.picture("andrews_work", "Work and precision: largest error of the angles over the wall time of the run.")
def work(figure):
    axes = figure.subplots()
    for name, numbers in STEPS.items():
        took, errors = [], []
        solved(name, numbers[0])  # so that the first time is no reading of compiled code
        for n in numbers:
            began = time.perf_counter()
            errors.append(error(solved(name, n)))
            took.append(time.perf_counter() - began)
        axes.loglog(took, errors, "o-", label=name)
    axes.set_xlabel("wall time [s]")
    axes.set_ylabel("largest error of an angle [rad]")
    axes.legend()


test_case, test_curves = PROBLEM.tests()
