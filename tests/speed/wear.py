"""Cost of worn contacts in a step, and of many turns: the slider-crank with a dry joint, new and worn.

Run alone on a quiet machine: python tests/speed/wear.py
"""

import math
import statistics
import time

import numpy as np

import flexmb as fm
from flexmb.mechanisms import slider_crank

STEP, PERIODS, PAIRS, TURNS = 1e-5, 2, 7, 1e6
DRY = slider_crank(speed=2.0 * math.pi * 1000 / 60, clearance=5e-5)
NEW = DRY["B"].worn_by(fm.Archard(bearing=1e-13, bins=360, width=0.02))
ANGLE = 2.0 * math.pi * np.arange(360) / 360
DEPTHS = {"new": np.zeros(360), "worn": np.maximum(9e-5 * np.cos(ANGLE) - 5e-5, 0.0)}


def seconds(mechanism):
    """Processor time of a step [s]."""
    begin = time.process_time()
    sol = fm.simulate(mechanism, periods=PERIODS, step=STEP, save=100)
    return (time.process_time() - begin) / sol.stats.steps


if __name__ == "__main__":
    for name, depths in DEPTHS.items():
        mechanism = DRY.with_part(NEW.with_depths(depths))
        pairs = [(seconds(mechanism), seconds(DRY)) for _ in range(PAIRS + 1)][1:]  # the first pair compiles
        ratio = statistics.median(own / dry for own, dry in pairs)
        steps = 1e6 * statistics.median(dry for _, dry in pairs)
        print(f"{name:8s} {ratio:.2f} times a step with the dry joint, {steps:.2f} us")
    for tolerance in (0.02, 0.01):
        begin = time.process_time()
        life = fm.wear_out(DRY.with_part(NEW), turns=TURNS, tolerance=tolerance)
        spent, deepest = time.process_time() - begin, 1e6 * float(life["B.bearing_profile"][-1].max())
        print(
            f"{TURNS:.0e} turns, tolerance {tolerance:g}: {spent:.0f} s, {int(life['runs'][-1])} runs, "
            f"{deepest:.2f} um deep, {1e9 * float(life['B.volume'][-1]):.4g} mm^3"
        )
