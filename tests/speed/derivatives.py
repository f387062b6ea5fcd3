"""Cost of derivatives by parameters: runs with p of them beside the same run without.

Run alone on a quiet machine: python tests/speed/derivatives.py
"""

import math
import statistics
import time

import numpy as np

import flexmb as fm
from flexmb.mechanisms import nine_bar, slider_crank

RUNS, COUNTS = 3, (1, 2, 4, 8)
CRANK = slider_crank(speed=2.0 * math.pi * 1000 / 60, clearance=1e-4)
MASSES = {
    "slider-crank": [f"{body}.{field}" for field in ("mass", "inertia") for body in ("crank", "rod", "slider")],
    "nine-bar": [f"{body}.{field}" for field in ("mass", "inertia") for body in ("crank1", "link2", "link3", "crank4")],
}
STIFFNESS = [
    f"{link}.{field}"
    for field in ("section.height", "material.density")
    for link in ("crank1", "link2", "link3", "crank4")
]
CASES = {
    "slider-crank": (CRANK, ["B.clearance", "B.normal.restitution", *MASSES["slider-crank"]], ["slider.ax"], 3.0),
    "nine-bar": (nine_bar(clearance=1e-4), MASSES["nine-bar"], ["slider.y"], 5.0),
    "nine-bar, flexible": (nine_bar(clearance=1e-4, flexible=True), STIFFNESS, ["slider.y"], 0.2),
}


def seconds(run):
    """Median processor time [s]; a horizon that a motion has passed is no matter here."""
    times = []
    for _ in range(RUNS + 1):
        begin = time.process_time()
        try:
            run()
        except fm.errors.SolveError as error:
            if "grew" not in str(error):
                raise
        times.append(time.process_time() - begin)
    return statistics.median(times[1:])  # the first run compiles


def ratios(mechanism, parameters, signals, t_end):
    """Time of the run alone [s], and times of the runs with COUNTS parameters over it."""
    how = {"t_end": t_end, "save": t_end / 100.0}
    plain = seconds(lambda: fm.simulate(mechanism, **how))
    return plain, [
        seconds(lambda p=p: fm.design.sensitivity(mechanism, parameters[:p], of=signals, **how)) / plain for p in COUNTS
    ]


if __name__ == "__main__":
    for name, case in CASES.items():
        plain, found = ratios(*case)
        slope, base = np.polyfit(COUNTS, found, 1)
        listed = ", ".join(f"{p}: {ratio:.2f}" for p, ratio in zip(COUNTS, found, strict=True))
        print(f"{name}: {plain:.2f} s; times of that with p parameters {listed}; {base:.2f} + {slope:.2f} p")
