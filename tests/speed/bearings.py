"""Cost of oil films and of worn contacts in a step, and of many turns: `python tests/speed/bearings.py`.

The slider-crank with a dry joint, and with each film and each worn surface in its place, in pairs.  The rows are kept
in out/speed for `python docs/performance.py --collect`.  It wants a quiet machine.
"""

import math
import statistics
import time

import numpy as np
from duel import keep

import flexmb as fm
from flexmb.mechanisms import slider_crank

STEP, PERIODS, PAIRS, TURNS = 1e-5, 2, 7, 1e6
DRY = slider_crank(speed=2.0 * math.pi * 1000 / 60, clearance=5e-5)
NEW = DRY["B"].worn_by(fm.Archard(bearing=1e-13, bins=360, width=0.02))
SHAPE, ANGLE = {"viscosity": 0.02, "width": 0.012}, 2.0 * math.pi * np.arange(360) / 360


def wet(film):
    """The joint of the slider in a film."""
    dry = DRY["B"]
    laws = {"normal": dry.normal, "friction": dry.friction, "roughness": 1e-6}
    place = {"at": (0.17, 0.0), "clearance": 5e-5, "bearing_radius": 0.010}
    return fm.JournalBearing("B", DRY["rod"], DRY["slider"], **place, film=film, **laws)


JOINTS = {
    "short film": wet(fm.ShortBearing(**SHAPE)),
    "long film": wet(fm.LongBearing(**SHAPE)),
    "finite film": wet(fm.FiniteBearing(**SHAPE)),
    "finite film, two grooves": wet(fm.FiniteBearing(**SHAPE, grooves=(0.5 * math.pi, 1.5 * math.pi))),
    "360 angles, unworn": NEW,
    "360 angles, worn": NEW.with_depths(np.maximum(9e-5 * np.cos(ANGLE) - 5e-5, 0.0)),
}


def seconds(mechanism):
    """Processor time of a step [s]."""
    begin = time.process_time()
    sol = fm.simulate(mechanism, periods=PERIODS, step=STEP, save=100)
    return (time.process_time() - begin) / sol.stats.steps


def main():
    """Measure and keep."""
    record = {"rows": [], "lives": []}
    for name, joint in JOINTS.items():
        mechanism = DRY.with_part(joint)
        pairs = [(seconds(mechanism), seconds(DRY)) for _ in range(PAIRS + 1)][1:]  # the first pair compiles
        ratio = statistics.median(own / dry for own, dry in pairs)
        record["rows"].append([name, 1e6 * statistics.median(own for own, _ in pairs), ratio])
        print(f"{name:26s} {ratio:.2f} times a step with the dry joint", flush=True)
    for tolerance in (0.02, 0.01):
        begin = time.process_time()
        life = fm.wear_out(DRY.with_part(NEW), turns=TURNS, tolerance=tolerance)
        spent, deepest = time.process_time() - begin, 1e6 * float(life["B.bearing_profile"][-1].max())
        found = [tolerance, spent, int(life["runs"][-1]), deepest, 1e9 * float(life["B.volume"][-1])]
        record["lives"].append(found)
        print("tolerance {:g}: {:.0f} s, {} runs, {:.2f} um deep, {:.4g} mm^3".format(*found), flush=True)
    keep("bearings", record)


if __name__ == "__main__":
    main()
