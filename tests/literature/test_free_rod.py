"""A free-flying flexible rod: exact flight of its centre of mass, constant energy and angular momentum.

A straight rod of 10 m lies between (6, 0) and (0, 8), at rest.  For 2.5 s its lower end is pushed by 8 N along +X and
turned by -80 N m; then it flies freely, turning over and bending by large angles.  The centre of mass moves exactly as
x = 3 + 0.4 t^2 up to 2.5 s and x = 5.5 + 2 (t - 2.5) afterwards, y = 4.

The rod of the source also shears (G A = 1e4 N); the beam here does not, so the positions of its ends are stated beside
those of the source, as distances over its length.
"""

from functools import lru_cache

import numpy as np
from published import PUSHED, free_rod
from record import Curve, Problem, Value

import flexmb as fm

LENGTH, T_END, STEP = 10.0, 10.0, 2.5e-4
TIPS = {
    5.0: ((5.620, 4.764), (15.409, 4.264)),
    10.0: ((25.409, 4.790), (15.624, 4.150)),
}
"""Lower and upper end of the rod that shears [m]."""

PROBLEM = Problem(
    title="Free-flying rod",
    source="J. C. Simo, L. Vu-Quoc, J. Applied Mechanics 53 (1986) 855-863",
    kind=(
        "exact: centre of mass, and what is constant after the loads; computed once with shear by an independent code, "
        "1e-3: the ends"
    ),
    about=(
        "Loads that end at once, a body without any joint, rotary inertia of the sections. Energy, momentum and "
        "centre of mass are those of the consistent mass (`fm.momentum`). Trapezoidal rule, steps of 0.25 ms."
    ),
)


@lru_cache(maxsize=8)
def flight(elements, step=STEP):
    """The solution, saved every 0.1 s, and its momenta."""
    mech = free_rod(elements)
    sol = fm.simulate(mech, t_end=T_END, step=step, save=100, method=fm.Newmark.trapezoidal())
    assert sol.status.startswith("Finished"), sol.status  # with 4 elements strains reach .204: told, and not ok
    return sol, fm.momentum(mech, sol)


@PROBLEM.case("16 elements")
def sixteen():
    sol, found = flight(16)
    t, x = found.time, found.centre[:, 0]
    exact = np.where(t <= PUSHED, 3.0 + 0.4 * t**2, 5.5 + 2.0 * (t - PUSHED))
    free = t > PUSHED + 1e-9
    stored = (sol.array("energy.kinetic") + sol.array("energy.strain"))[free]
    angular = (found.angular - found.centre[:, 0] * found.linear[:, 1] + found.centre[:, 1] * found.linear[:, 0])[free]
    at = {instant: int(np.abs(t - instant).argmin()) for instant in TIPS}
    ends = {
        (instant, end): np.hypot(
            *(sol.array(f"rod.{end}.{axis}")[at[instant]] - want for axis, want in zip("xy", tip, strict=True))
        )
        for instant, tips in TIPS.items()
        for end, tip in zip(("start", "end"), tips, strict=True)
    }
    return [
        Value("mass [kg]", 10.0, found.mass, 1e-12),
        Value("x of the centre of mass at 10 s [m]", 20.5, x[at[10.0]], 1e-9),
        Value("largest error of x [m]", 0.0, np.abs(x - exact).max(), 1e-9, scale=1.0),
        Value("largest error of y [m]", 0.0, np.abs(found.centre[:, 1] - 4.0).max(), 1e-9, scale=1.0),
        Value("largest change of energy after the loads", 0.0, np.ptp(stored) / stored[0], 1e-6, scale=1.0),
        Value("largest change of angular momentum", 0.0, np.ptp(angular) / abs(angular[0]), 1e-6, scale=1.0),
        *(
            Value(f"{end} at {instant:g} s: distance from that of the rod that shears [m]", 0.0, d, 1e-3, scale=LENGTH)
            for (instant, end), d in ends.items()
        ),
    ]


@PROBLEM.picture("free_rod", "The rod every second; crosses: ends of the rod that shears, at 5 s and 10 s")
def picture(figure):
    sol, found = flight(16)
    axes = figure.subplots()
    for k in range(0, len(found.time), 10):
        xy = [[sol.array(f"rod.node{i}.{axis}")[k] for i in range(17)] for axis in "xy"]
        axes.plot(*xy, "k-", linewidth=1.0)
    for ends in TIPS.values():
        axes.plot(*np.transpose(ends), "rx")
    axes.plot(*found.centre.T, "b:")
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")


@PROBLEM.convergence("free_rod_elements", "Lower end at t = 5 s against 64 elements", "element length [m]", "error [m]")
def elements():
    counts = (4, 8, 16)

    def lower(n):
        sol = flight(n, 2.5e-3)[0]
        k = int(np.abs(sol.time - 5.0).argmin())
        return np.array([sol.array(f"rod.start.{axis}")[k] for axis in "xy"])

    best = lower(64)
    return [Curve("lower end", [LENGTH / n for n in counts], [np.linalg.norm(lower(n) - best) for n in counts], 2.0)]


test_case, test_curves = PROBLEM.tests()
