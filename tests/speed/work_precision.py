"""Error against time on the rigid slider-crank: flexmb beside scipy on the equations written by hand (minimal.py).

flexmb knows nothing of this mechanism: it solves for nine coordinates and their joint forces, and keeps an account of
the energy.  scipy gets one or two coordinates, events for the contact and, as its honest best, right-hand sides
through numba.  Times are the least of seven in turns, CPU of the process.
"""

import math
import time
from collections.abc import Callable
from unittest import mock

import minimal
import models as m
from duel import keep

import flexmb as fm

FREE, WORN = 2.0 * m.TURN, m.TURN / 3.0  # s; 24 ms and 4 ms
REPEATS, SLOW = 7, 0.5  # runs that take longer than SLOW seconds are not repeated
LARGEST = 1e-4  # s, of scipy's steps: tried; the impacts of these 4 ms are found with 1e-5 to 1e-4
STEPS = (1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6, 5e-7)
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
RTOL = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)


def costs(runs: list[Callable[[], tuple[float, float]]], error: Callable[[float], float]) -> list[list[float]]:
    """[time, error] of runs that return (time, value), in turns; the error of a run that gave up is not a number."""
    found = [[run()] for run in runs]
    for _ in range(REPEATS - 1):
        for run, known in zip(runs, found, strict=True):
            if known[0][0] < SLOW:
                known.append(run())
    return [[min(t for t, _ in known), error(known[0][1])] for known in found]


def by_flexmb(mechanism: fm.Mechanism, signal: str, t_end: float, **options) -> Callable[[], tuple[float, float]]:
    """Time and last value of a signal."""

    def run() -> tuple[float, float]:
        with mock.patch("time.perf_counter", time.process_time):
            sol = fm.simulate(mechanism, t_end=t_end, save=1, **options)
        return sol.stats.wall_time, float(sol.array(signal)[-1]) if sol.ok else math.nan

    return run


def by_scipy(solve: Callable[[], float]) -> Callable[[], tuple[float, float]]:
    """Time and what `solve` returns."""

    def run() -> tuple[float, float]:
        began = time.process_time()
        value = solve()
        return time.process_time() - began, float(value)

    return run


def curves(mechanism, signal, t_end, exact, solve, radau) -> list[dict]:
    """Curves of flexmb and of scipy; `solve` takes method, rtol and whether numba is to be used."""

    def error(value: float) -> float:
        return max(abs(value - exact), 1e-16) if math.isfinite(value) else math.nan

    method = fm.Newmark.generalised_alpha()
    found = {
        "flexmb, generalised-alpha": [by_flexmb(mechanism, signal, t_end, step=h, method=method) for h in STEPS],
        "flexmb, Runge-Kutta 4": [by_flexmb(mechanism, signal, t_end, step=h, method=fm.RungeKutta4()) for h in STEPS],
        "flexmb, Radau": [
            by_flexmb(mechanism, signal, t_end, step=fm.Adaptive(rtol=r), method=fm.RadauIIA()) for r in RTOL
        ],
        "flexmb, default": [by_flexmb(mechanism, signal, t_end)],
    }
    for name, tolerances in (("DOP853", TOLERANCES), ("Radau", radau)):
        for fast in (False, True):
            label = f"scipy {name}, {'numba' if fast else 'Python'}"
            found[label] = [by_scipy(lambda a=(name, r, fast): solve(*a)) for r in tolerances]
    points = iter(costs([run for runs in found.values() for run in runs], error))
    return [{"label": label, "points": [next(points) for _ in runs]} for label, runs in found.items()]


def measured() -> dict:
    """Both problems; the record is kept in out/speed."""
    minimal.run_free("DOP853", 1e-3, FREE, fast=True)  # compile
    minimal.run_worn("DOP853", 1e-3, 3e-4, fast=True)
    for step in (1e-5, None):
        fm.simulate(m.worn(0.0), t_end=1e-4, step=step, save=1)
    fm.simulate(m.worn(0.0), t_end=1e-4, step=1e-5, save=1, method=fm.RungeKutta4())
    fm.simulate(m.worn(0.0), t_end=1e-4, step=1e-5, save=1, method=fm.RadauIIA())
    reference = minimal.run_worn("DOP853", 1e-13, WORN, fast=True)[1]
    free = curves(
        m.ideal(driven=False),
        "crank.theta",
        FREE,
        minimal.exact_angle(FREE),
        lambda name, rtol, fast: minimal.run_free(name, rtol, FREE, fast=fast),
        TOLERANCES[:4],
    )
    worn = curves(
        m.worn(0.0),
        "slider.x",
        WORN,
        reference,
        lambda name, rtol, fast: minimal.run_worn(name, rtol, WORN, fast=fast, largest=LARGEST)[1],
        TOLERANCES[:3],
    )
    record = {
        "name": "work-precision",
        "problems": [
            {
                "title": "ideal joints, turning freely, 24 ms",
                "error": "angle of the crank at the end [rad]",
                "curves": free,
            },
            {"title": "0.5 mm of play, 4 ms", "error": "place of the slider at the end [m]", "curves": worn},
        ],
    }
    keep("work-precision", record)
    return record
